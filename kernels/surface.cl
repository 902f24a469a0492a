// What every hit of a queue is: point, normals, offset, side, material. Found once and kept, because the passes
// after it then need not know about kinds of primitives, and work on whole packets.
//
// One work-item a ray: the kinds differ too much for vectors.
#include "surface.clh"

__kernel void surface(WORLD_PARAMETERS, __global const float *rays, __global const float *hit_t,
                      __global const int *hit_primitive, uint n,
                      __global float *surfaces, __global int *surface_code)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const Hit hit = {hit_t[i], hit_primitive[i]};
    Surface s;
    if (hit.primitive >= 0) s = surface_at(world, load_ray(rays, i), hit);
    store_surface(world, s, hit, i, surfaces, surface_code);
}
