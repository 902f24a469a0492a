// What every hit of a queue is: point, normals, offset, side, material. Found once and kept. One work-item a packet.
// Hits of inner sides at edges of opaque solids become those of the faces before them (edges.clh).
//
// In a large scene this waits for memory twice: for a hit's primitive, and for the record of its kind. So both are asked
// for some packets ahead: a packet's turn comes when they are there.
#include "edges.clh"

#define AHEAD 4            // packets
#define IN_CACHES 100000   // primitives, whose records stay there

// Asks for the primitives that the packet at `first` hits, or, when these are there, for the records they name.
INLINED void ask_for(const World world, __global const int *hit_primitive, uint first, uint n, bool records)
{
#if defined(__x86_64__) || defined(__aarch64__)
    if (first + PACKET > n) return;
    for (uint k = 0; k < PACKET; k++) {
        const int number = hit_primitive[first + k];
        if (number < 0) continue;
        __global const Primitive *p = world.primitives + number;
        __global const void *at = p;
        if (records) at = p->kind == SPHERE ? (__global const void *)(world.spheres + p->index)
                                            : (__global const void *)(world.triangles + p->index);
        __builtin_prefetch((const void *)(size_t)at);
    }
#endif
}

__kernel void surface(WORLD_PARAMETERS, QUEUE_PARAMETERS, HITS_PARAMETERS)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    if (world.scene->primitives > IN_CACHES) {
        ask_for(world, hit_primitive, first + 2 * AHEAD * PACKET, n, false);
        ask_for(world, hit_primitive, first + AHEAD * PACKET, n, true);
    }
    const floatP t = load_numbers(hit_t, first, n);
    store_surface(world, load_rays(rays, first, n), load_word(hit_primitive, first, n), t,
                  cone_width(weights, first, n, t), first, n, surfaces, surface_code);
    const intP code = load_word(surface_code, first, n);
    const int flags = SURFACE_EDGE | SURFACE_INSIDE;
    if (!any_of((code >= 0) & ((code & flags) == flags))) return;
    for (uint i = first; i < first + PACKET && i < n; i++)
        face(world, rays, i, hit_t, hit_primitive, weights, surfaces, surface_code);
}
