// For rays that carry lists of media, after the pass `surface`: each goes on through all boundaries that leave the
// medium it is in unchanged, to the first that does not; what that medium has absorbed on the way is taken off the
// ray's weight, and the materials are noted whose indices meet at the hit. One work-item a ray.
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
    MediaList list = load_media(media, i);
    int before = top_of(world, list), after = before;
    bool moved = false;
    while (surface_code[i] >= 0) {
        const int number = surface_code[i] / SURFACE_MATERIAL;
        __global const Material *material = world.materials + number;
        const int medium = material->medium;
        const bool inside = surface_code[i] & SURFACE_INSIDE;
        if (medium == NO_MEDIUM) {
            const bool opaque_inside = inside && !material->thin && material->fresnel != CONDUCTOR;
            after = opaque_inside ? before : number;
            before = opaque_inside ? number : before;
            break;
        }
        MediaList next = list;
        bool fits = true;
        if (!inside) {
            fits = enter_medium(&next, medium);
        } else if (!leave_medium(&next, medium)) {
            fits = enter_medium(&list, medium);  // the ray was in it, though it is not listed
            next = list;
            leave_medium(&next, medium);
            moved = true;
        }
        if (!fits) *overflow = 1;
        before = top_of(world, list);
        after = top_of(world, next);
        if (before != after) break;
        list = next;
        moved = true;
        const Ray ray = load_ray(rays, i);
        const Hit hit = nearest_hit(world, ray, hit_t[i], hit_primitive[i], false);
        hit_t[i] = hit.t;
        hit_primitive[i] = hit.primitive;
        store_surface(world, ray, hit, i, surfaces, surface_code);
    }
    surfaces[in_block(i, TOP_BEFORE, SURFACE_FIELDS)] = as_float(before);
    surfaces[in_block(i, TOP_AFTER, SURFACE_FIELDS)] = as_float(after);
    if (moved) store_media(media, i, list);

    const int within = top_of(world, list);
    if (within == NO_MEDIUM) return;
    for (int b = 0; b < RAY_BANDS; b++) {
        const float absorption = world.materials[within].absorption[band_at(first_band(weights, i), b)];
        if (absorption > 0.0f) weights[in_block(i, b, VALUES)] *= exponential(-absorption * hit_t[i]);
    }
}

#endif
