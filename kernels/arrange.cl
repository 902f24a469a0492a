// An order of the rays of a queue in which neighbours go the same way, so that packets stay together: by octant and
// dominant axis of the direction, and among those that share them along a curve through the origins (Morton 1966).
// Nothing else changes: tracing reads rays through the order, and writes what it finds where they stand in the queue.
//
// It is found for ARRANGED rays at a time, by counting (radix sort), which keeps equal keys in their order. More rays
// at a time would bring little, since neighbours in a queue are neighbours in the picture already. It pays where rays
// scatter and what they meet stays in the caches (clrt/engine/passes.py): rays that leave a mirror or glass keep
// together by themselves, and in a large tree neighbours that meet the same nodes are worth more than packets.
#include "lanerays.clh"

#define CELLS 8  // of the origins' bounds, along each axis
#define DIGIT 7  // bits of a key that are sorted at a time, of 14

// stable, by one digit of the rays' keys; a null `from` is the queue's own order
inline void sort_by_digit(__global const uint *keys, int digit, __global const uint *from, uint start, uint end,
                          __global uint *to)
{
    uint place[1 << DIGIT];
    for (int k = 0; k < 1 << DIGIT; k++) place[k] = 0;
    for (uint i = start; i < end; i++) place[keys[i] >> digit * DIGIT & ((1 << DIGIT) - 1)]++;
    uint next = start;
    for (int k = 0; k < 1 << DIGIT; k++) {
        const uint count = place[k];
        place[k] = next;
        next += count;
    }
    for (uint i = start; i < end; i++) {
        const uint ray = from ? from[i] : i;
        to[place[keys[ray] >> digit * DIGIT & ((1 << DIGIT) - 1)]++] = ray;
    }
}

// cells along an axis to a unit of length, and in which one a coordinate lies; what is not finite lies in some
INLINED float cells_in(float extent) { return extent > 0.0f && extent < INFINITY ? CELLS / extent : 0.0f; }
INLINED intP cell_of(floatP o, float from, float cells)
{
    return convert_intP(smaller(larger((o - from) * cells, (floatP)(0.0f)), (floatP)(CELLS - 1)));
}

// every third bit of c, which has three
inline intP spread_bits(intP c) { return (c & 1) | (c & 2) << 2 | (c & 4) << 4; }

// `between` has room for as many words as `sequence`
__kernel void arrange(__global const float *rays, uint n, __global uint *keys, __global uint *between,
                      __global uint *sequence)
{
    const uint start = get_global_id(0) * ARRANGED;
    if (start >= n) return;
    const uint end = min(start + ARRANGED, n);
    VecP low = same(vec(INFINITY, INFINITY, INFINITY)), high = same(vec(-INFINITY, -INFINITY, -INFINITY));
    for (uint first = start; first < end; first += PACKET) {
        const VecP o = load_vec(rays, first, n, ORIGIN_X, RAY_FIELDS);
        low = vec(smaller(o.x, low.x), smaller(o.y, low.y), smaller(o.z, low.z));
        high = vec(larger(o.x, high.x), larger(o.y, high.y), larger(o.z, high.z));
    }
    const Vec from = vec(smallest_of(low.x), smallest_of(low.y), smallest_of(low.z));
    const Vec extent = sub(vec(largest_of(high.x), largest_of(high.y), largest_of(high.z)), from);
    const Vec cells = vec(cells_in(extent.x), cells_in(extent.y), cells_in(extent.z));
    for (uint first = start; first < end; first += PACKET) {
        const VecP o = load_vec(rays, first, n, ORIGIN_X, RAY_FIELDS);
        const intP way = way_of(load_vec(rays, first, n, DIRECTION_X, RAY_FIELDS));
        const intP x = cell_of(o.x, from.x, cells.x), y = cell_of(o.y, from.y, cells.y);
        const intP z = cell_of(o.z, from.z, cells.z);
        const intP cell = spread_bits(x) | spread_bits(y) << 1 | spread_bits(z) << 2;
        store_word((__global int *)keys, first, n, way << 9 | cell);
    }
    sort_by_digit(keys, 0, 0, start, end, between);
    sort_by_digit(keys, 1, between, start, end, sequence);
}
