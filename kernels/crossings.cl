// All hits of a ray, one after the other: each launch moves every ray that still hits something to its next hit, in
// the order of (t, primitive number). No hit is stepped over and none is met twice, however close together they
// lie, because nothing is moved and no distance is added; the price is a walk from the root for every hit.
#include "intersect.clh"

__kernel void next_hit(WORLD_PARAMETERS, QUEUE_PARAMETERS, HITS_PARAMETERS)
{
    const uint i = get_global_id(0);
    if (i >= n || hit_primitive[i] < 0) return;
    const World world = WORLD_OF_PARAMETERS;
    const Hit hit = nearest_hit(world, load_ray(rays, i), hit_t[i], hit_primitive[i], false, NO_PRIMITIVE);
    hit_t[i] = hit.t;
    hit_primitive[i] = hit.primitive;
}
