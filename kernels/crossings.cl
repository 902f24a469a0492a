// All that rays cross: counted first, so that the answers have their places, then written there, ray after ray. The
// walk is done twice; to keep what the first one finds would take memory that nobody can bound.
#include "asked.clh"
#include "crossings.clh"

INLINED Ray asked_ray(const Asked asked, uint i)
{
    __global const float *o = asked.origins + (size_t)i * asked.origin_step;
    __global const float *d = asked.directions + (size_t)i * asked.direction_step;
    const Vec direction = unit_of_any(vec(d[0], d[1], d[2]));
    const Ray ray = {vec(o[0], o[1], o[2]), direction, asked.t_max ? asked.t_max[i] : asked.most};
    return ray;
}

INLINED Crossed between(const Asked asked, const Ray ray, uint i)
{
    const float least = asked.t_min ? asked.t_min[i] : asked.least;
    const Crossed found = {least < 0.0f ? 0.0f : least, ray.t_max, 0, 0, 0};
    return found;
}

__kernel void count_crossings(WORLD_PARAMETERS, ASKED_PARAMETERS, __global int *crossings)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const Asked asked = ASKED_OF_PARAMETERS;
    const Ray ray = asked_ray(asked, i);
    Crossed found = between(asked, ray, i);
    cross_all(world, ray, &found);
    crossings[i] = (int)found.count;
}

// `place`: where those of each ray begin
__kernel void list_crossings(WORLD_PARAMETERS, ASKED_PARAMETERS, __global const uint *place, __global float *found_t,
                             __global int *found_primitive)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const Asked asked = ASKED_OF_PARAMETERS;
    const Ray ray = asked_ray(asked, i);
    Crossed found = between(asked, ray, i);
    found.t = found_t + place[i];
    found.primitive = found_primitive + place[i];
    cross_all(world, ray, &found);
    sort_crossed(&found);
}
