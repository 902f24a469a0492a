// What every hit of a queue is: point, normals, offset, side, material. Found once and kept. One work-item a packet.
#include "lanes.clh"

__kernel void surface(WORLD_PARAMETERS, QUEUE_PARAMETERS, HITS_PARAMETERS)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    store_surface(world, load_rays(rays, first, n), load_word(hit_primitive, first, n), load_numbers(hit_t, first, n),
                  first, n, surfaces, surface_code);
}
