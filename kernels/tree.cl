// The tree over the finite primitives: binned surface-area heuristic (Wald 2007, "On fast construction of
// SAH-based bounding volume hierarchies"), built top-down by one work-item.
//
// Trade-off: serial and binary, simple. The picture does not depend on the tree, only the time does. The larger
// half of every split is put on the stack first, so the stack stays below log2(n) entries; below DEEP levels the
// split is by halves, so that no distribution makes the tree deeper than the traversal's stack.
#include "intersect.clh"

#define BINS 16
#define LEAF 4
#define DEEP 32

inline float3 lower3(float3 a, float3 b) { return (float3)(smaller(a.x, b.x), smaller(a.y, b.y), smaller(a.z, b.z)); }
inline float3 upper3(float3 a, float3 b) { return (float3)(larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z)); }
inline float half_area(float3 low, float3 high)
{
    const float3 d = high - low;
    return d.x < 0.0f ? 0.0f : d.x * d.y + d.y * d.z + d.z * d.x;
}

typedef struct {
    int axis, bin;  // primitives whose bin on `axis` is below `bin` go left; axis < 0: no split found
    float cost;
} Split;

inline int bin_of(__global const Box *box, int axis, float low, float scale)
{
    const float middle = component(box->low.xyz, axis) * 0.5f + component(box->high.xyz, axis) * 0.5f;
    return clamp((int)((middle - low) * scale), 0, BINS - 1);
}

// cheapest of the BINS - 1 planes on one axis
inline Split best_plane(__global const Box *boxes, __global const int *item, int start, int end,
                        int axis, float low, float scale, Split best)
{
    float3 bin_low[BINS], bin_high[BINS];
    int bin_count[BINS];
    for (int k = 0; k < BINS; k++) {
        bin_low[k] = (float3)(INFINITY, INFINITY, INFINITY);
        bin_high[k] = -bin_low[k];
        bin_count[k] = 0;
    }
    for (int i = start; i < end; i++) {
        __global const Box *box = boxes + item[i];
        const int k = bin_of(box, axis, low, scale);
        bin_low[k] = lower3(box->low.xyz, bin_low[k]);
        bin_high[k] = upper3(box->high.xyz, bin_high[k]);
        bin_count[k]++;
    }
    float right_cost[BINS];
    float3 side_low = (float3)(INFINITY, INFINITY, INFINITY), side_high = -side_low;
    int side_count = 0;
    for (int k = BINS - 1; k > 0; k--) {
        side_low = lower3(bin_low[k], side_low);
        side_high = upper3(bin_high[k], side_high);
        side_count += bin_count[k];
        right_cost[k] = half_area(side_low, side_high) * (float)side_count;
    }
    side_low = (float3)(INFINITY, INFINITY, INFINITY);
    side_high = -side_low;
    side_count = 0;
    for (int k = 1; k < BINS; k++) {
        side_low = lower3(bin_low[k - 1], side_low);
        side_high = upper3(bin_high[k - 1], side_high);
        side_count += bin_count[k - 1];
        if (side_count == 0 || side_count == end - start) continue;
        const float cost = half_area(side_low, side_high) * (float)side_count + right_cost[k];
        if (best.axis < 0 || cost < best.cost) {
            best.axis = axis;
            best.bin = k;
            best.cost = cost;
        }
    }
    return best;
}

// `item` is a permutation of the boxes, sorted into the tree's leaves; `nodes` has room for 2 n - 1.
__kernel void build_tree(__global const Box *boxes, int n, __global int *item, __global Node *nodes,
                         __global int *node_count)
{
    int stack[STACK][4];  // node, start, end, depth
    int size = 1, used = 1;
    stack[0][0] = 0;
    stack[0][1] = 0;
    stack[0][2] = n;
    stack[0][3] = 0;
    while (size > 0) {
        size--;
        const int node = stack[size][0], start = stack[size][1], end = stack[size][2], depth = stack[size][3];
        float3 low = (float3)(INFINITY, INFINITY, INFINITY), high = -low, middle_low = low, middle_high = high;
        for (int i = start; i < end; i++) {
            const float3 box_low = boxes[item[i]].low.xyz, box_high = boxes[item[i]].high.xyz;
            const float3 middle = box_low * 0.5f + box_high * 0.5f;
            low = lower3(box_low, low);
            high = upper3(box_high, high);
            middle_low = lower3(middle, middle_low);
            middle_high = upper3(middle, middle_high);
        }
        nodes[node].low = (float4)(low, 0.0f);
        nodes[node].high = (float4)(high, 0.0f);
        nodes[node].pad0 = nodes[node].pad1 = 0;
        const int count = end - start;
        Split split = {-1, 0, 0.0f};
        if (count > 1 && depth < DEEP)
            for (int axis = 0; axis < 3; axis++) {
                const float extent = component(middle_high, axis) - component(middle_low, axis);
                if (!(extent > 0.0f)) continue;
                split = best_plane(boxes, item, start, end, axis, component(middle_low, axis),
                                   (float)BINS * 0.9999f / extent, split);
            }
        const float area = half_area(low, high);
        const bool split_pays = split.axis >= 0 && split.cost + area < (float)count * area;
        if (count <= LEAF && !split_pays) {
            nodes[node].first = start;
            nodes[node].count = count;
            continue;
        }
        int middle = start + count / 2;
        if (split.axis >= 0) {
            const float from = component(middle_low, split.axis);
            const float per_bin = (float)BINS * 0.9999f / (component(middle_high, split.axis) - from);
            int i = start, j = end - 1;
            while (i <= j) {
                const int swap = item[i];
                if (bin_of(boxes + swap, split.axis, from, per_bin) < split.bin) { i++; continue; }
                item[i] = item[j];
                item[j--] = swap;
            }
            middle = i;
        }
        nodes[node].first = used;
        nodes[node].count = 0;
        const int left_larger = middle - start >= end - middle;
        for (int k = 0; k < 2; k++) {
            const int left = (k == 0) == left_larger;
            stack[size][0] = left ? used : used + 1;
            stack[size][1] = left ? start : middle;
            stack[size][2] = left ? middle : end;
            stack[size][3] = depth + 1;
            size++;
        }
        used += 2;
    }
    *node_count = used;
}

// leaves hold primitive numbers: items of the builder are places in the list of finite primitives
__kernel void number_leaves(__global const int *finite, int n, __global int *item)
{
    const int i = get_global_id(0);
    if (i < n) item[i] = finite[item[i]];
}
