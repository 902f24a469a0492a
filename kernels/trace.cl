// Nearest hit of every ray of a queue, and occlusion of every shadow feeler.
//
// A feeler stops at the first blocker it finds (thesis 3.2.1). With tinted shadows it must see all surfaces it
// crosses, in the order of (t, primitive), so that the product of their tints is the same on every device.
#include "extent.clh"
#include "shaft.clh"
#include "tinted.clh"
#include "walk.clh"

// words of rays `first` to `first + PACKET` of an order
INLINED void store_ordered(__global int *words, __global const uint *sequence, uint first, intP value)
{
    if (!sequence) {
        *(__global intP *)(words + first) = value;
        return;
    }
    ALIGNED int lane[PACKET];
    *(intP *)lane = value;
    for (uint k = 0; k < PACKET; k++) words[sequence[first + k]] = lane[k];
}

// `sequence` (arrange.cl): in which rays are taken; null: as they stand
__kernel void closest(WORLD_PARAMETERS, QUEUE_PARAMETERS, HITS_PARAMETERS, __global const uint *sequence)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    if (first + PACKET <= n) {
        const PacketHit hits = packet_hits(world, load_packet(rays, sequence, first), (intP)(NO_PRIMITIVE), false);
        store_ordered((__global int *)hit_t, sequence, first, as_intP(hits.t));
        store_ordered(hit_primitive, sequence, first, hits.primitive);
        return;
    }
    for (uint i = first; i < n; i++) {
        const uint place = place_in(sequence, i);
        const Hit hit = nearest_hit(world, load_ray(rays, place), 0.0f, BEFORE_ALL, false, NO_PRIMITIVE);
        hit_t[place] = hit.t;
        hit_primitive[place] = hit.primitive;
    }
}

// Has the pass `feelers` found for all of a packet what stands in their way?
INLINED bool all_known(__global const uint *seen, __global const uint *sequence, uint first)
{
    bool known = true;
    for (uint k = 0; k < PACKET; k++) known &= seen[place_in(sequence, first + k)] != UNTRACED;
    return known;
}

// A ray arrives where it met nothing.
#define ARRIVES(primitive) ((primitive) < 0)

// `own`: of each ray the primitive that it passes by (the light it goes to); null: there are none
__kernel void occluded(WORLD_PARAMETERS, __global const float *rays, uint n, __global uint *seen,
                       __global const uint *sequence, __global const int *own)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    if (first + PACKET <= n) {
        if (HAS_EXTENDED(world.scene) && all_known(seen, sequence, first)) return;
        const intP passed = own_lanes(own, sequence, first);
        const PacketHit hits = packet_hits(world, load_packet(rays, sequence, first), passed, true);
        store_ordered((__global int *)seen, sequence, first, ARRIVES(hits.primitive) & 1);
        return;
    }
    for (uint i = first; i < n; i++) {
        const uint place = place_in(sequence, i);
        if (HAS_EXTENDED(world.scene) && seen[place] != UNTRACED) continue;
        const int passed = own_of(own, place);
        seen[place] = ARRIVES(nearest_hit(world, load_ray(rays, place), 0.0f, BEFORE_ALL, true, passed).primitive);
    }
}

__kernel void occluded_tinted(WORLD_PARAMETERS, __global const float *rays, uint n, __global uint *seen,
                              __global float *filter, __global const int *own, __global uint *overflow)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    if (first + PACKET <= n) {
        if (HAS_EXTENDED(world.scene) && all_known(seen, 0, first)) return;
        ALIGNED float t[PACKET];
        ALIGNED int primitive[PACKET];
        const PacketHit hits = packet_hits(world, load_packet(rays, 0, first), own_lanes(own, 0, first), false);
        store_word((__global int *)seen, first, n, (intP)(CLEAR));
        *(floatP *)t = hits.t;
        *(intP *)primitive = hits.primitive;
        for (uint left = lanes_of(hits.primitive >= 0); left; left = without_first(left)) {
            const int lane = first_lane(left);
            const Hit hit = {t[lane], primitive[lane]};
            cross_surfaces(world, load_ray(rays, first + lane), hit, first + lane, own_of(own, first + lane), seen, filter,
                           overflow);
        }
        return;
    }
    for (uint i = first; i < n; i++) {
        if (HAS_EXTENDED(world.scene) && seen[i] != UNTRACED) continue;
        const Ray ray = load_ray(rays, i);
        const int passed = own_of(own, i);
        const Hit hit = nearest_hit(world, ray, 0.0f, BEFORE_ALL, false, passed);
        cross_surfaces(world, ray, hit, i, passed, seen, filter, overflow);
    }
}
