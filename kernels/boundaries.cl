// The pass `surface` for rays that carry lists of media: first each ray goes on through all boundaries that leave
// the medium it is in unchanged, then the surface is found, and what the medium has absorbed on the way is taken off
// the ray's weight. One work-item a ray.
//
// `overflow` becomes 1 where a list would have needed more places; the host then refuses the picture.
#include "surface.clh"
#include "media.clh"

#if MEDIA

__kernel void cross_boundaries(WORLD_PARAMETERS, __global const float *rays, uint n, __global float *hit_t,
                               __global int *hit_primitive, __global float *surfaces, __global int *surface_code,
                               __global int *media, __global float *weights, __global uint *overflow)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const Ray ray = load_ray(rays, i);
    Hit hit = {hit_t[i], hit_primitive[i]};
    MediaList list = load_media(media, i);
    int before = top_of(world, list), after = before;
    Surface s;
    while (hit.primitive >= 0) {
        s = surface_at(world, ray, hit);
        __global const Material *material = world.materials + s.material;
        const int medium = material->medium;
        if (medium == NO_MEDIUM) {
            const bool opaque_inside = s.inside && !material->thin && material->fresnel != CONDUCTOR;
            after = opaque_inside ? before : s.material;
            before = opaque_inside ? s.material : before;
            break;
        }
        MediaList next = list;
        bool fits = true;
        if (!s.inside) {
            fits = enter_medium(&next, medium);
        } else if (!leave_medium(&next, medium)) {
            fits = enter_medium(&list, medium);  // the ray was in it, though it is not listed
            next = list;
            leave_medium(&next, medium);
        }
        if (!fits) *overflow = 1;
        before = top_of(world, list);
        after = top_of(world, next);
        if (before != after) break;
        list = next;
        hit = nearest_hit(world, ray, hit.t, hit.primitive, false);
    }
    store_surface(world, s, hit, i, surfaces, surface_code);
    surfaces[in_block(i, TOP_BEFORE, SURFACE_FIELDS)] = as_float(before);
    surfaces[in_block(i, TOP_AFTER, SURFACE_FIELDS)] = as_float(after);
    store_media(media, i, list);
    hit_t[i] = hit.t;
    hit_primitive[i] = hit.primitive;

    const int within = top_of(world, list);
    if (within == NO_MEDIUM) return;
    for (int b = 0; b < RAY_BANDS; b++) {
        const float absorption = world.materials[within].absorption[band_at(first_band(weights, i), b)];
        if (absorption > 0.0f) weights[in_block(i, b, VALUES)] *= exponential(-absorption * hit.t);
    }
}

#endif
