// For rays that carry lists of media, after the pass `surface`: each goes on through all boundaries that leave the
// medium it is in unchanged, to the first that does not; what that medium has absorbed on the way is taken off the
// ray's weight, and the materials are noted whose indices meet at the hit. One work-item a packet.
//
// Nearly all rays are in no medium or in one, and stop at the first surface, at no edge: those lanes are done
// together (`settled`). The others go one after the other.
//
// At an edge two sides of one solid are in one place. A ray that has just gone in, or out, by one of them does not cross
// the other (`solids_about`), and one that only touches the edge crosses neither (`touched`).
//
// `overflow` becomes MANY_MEDIA where a list would have needed more places; the host then refuses the picture.
#include "edges.clh"
#include "surfaces.clh"
#include "media.clh"

#if MEDIA

// takes off what a medium absorbs between a ray's origin and its hit
inline void absorb(const World world, int medium, float t, uint i, __global float *weights)
{
    if (medium == NO_MEDIUM) return;
    for (int b = 0; b < RAY_BANDS; b++) {
        const float absorption = world.materials[medium].absorption[band_at(first_band(weights, i), b)];
        if (absorption > 0.0f) weights[in_block(i, b, VALUES)] *= exponential(-absorption * t);
    }
}

// How many solids of a medium hold the point just behind a hit, on the inner side of its surface: endless ones by
// their equations; of the others' surfaces a ray from there leaves so many more than it enters. -1 where that is not
// known after ASKED surfaces.
#define ASKED 4096
inline int solids_about(const World world, __global const float *surfaces, uint i, bool inside, int medium)
{
    const Vec n = load_vector(surfaces, i, NORMAL_X, SURFACE_FIELDS);
    const Vec off = times(n, surfaces[in_block(i, LEAVE_BY, SURFACE_FIELDS)]);
    const Vec point = load_vector(surfaces, i, POINT_X, SURFACE_FIELDS);
    // the way has no edge of its own: what is asked for has to be met apart
    const Ray ray = {inside ? add(point, off) : sub(point, off), unit3(vec(0.5698f, 0.3713f, 0.7331f)), INFINITY};
    int solids = 0;
    for (int k = 0; k < world.scene->unbounded; k++) {
        const int primitive = world.unbounded[k];
        if (world.materials[world.primitives[primitive].material].medium == medium)
            solids += endless_holds(world, primitive, ray.origin);
    }
    Hit hit = {0.0f, BEFORE_ALL};
    for (int k = 0; k < ASKED; k++) {
        hit = nearest_hit(world, ray, hit.t, hit.primitive, false, NO_PRIMITIVE);
        if (hit.primitive < 0) return solids;
        int material;
        const Local at = surface_at(world, ray, 1, hit.primitive, hit.t, &material);
        bool endless = false;
        for (int i = 0; i < world.scene->unbounded; i++) endless = endless || world.unbounded[i] == hit.primitive;
        if (world.materials[material].medium == medium && !endless)
            solids += dot3(at.outward, ray.direction) > 0.0f ? 1 : -1;
    }
    return -1;
}

inline void cross_one(const World world, __global const float *rays, uint i, __global float *hit_t,
                      __global int *hit_primitive, __global float *surfaces, __global int *surface_code,
                      __global int *media, __global float *weights, __global uint *overflow)
{
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
        const int times = times_listed(list, medium);
        const float offset = surfaces[in_block(i, LEAVE_BY, SURFACE_FIELDS)];
        const Ray ray = load_ray(rays, i);
        // beside an edge: the ray has just crossed it by the edge's other side
        bool crossed = hit_t[i] <= BESIDE * offset && (times > 0) != inside
                    && solids_about(world, surfaces, i, inside, medium) == times;
        const bool edge = surface_code[i] & SURFACE_EDGE;
        if (!crossed && (inside ? edge || times == 0 : edge && times == 0)) {
            const Vec n = load_vector(surfaces, i, NORMAL_X, SURFACE_FIELDS);
            const Hit last = touched(world, ray, (Hit){hit_t[i], hit_primitive[i]}, n, inside, medium);
            crossed = last.primitive >= 0;
            if (crossed) {
                hit_t[i] = last.t;
                hit_primitive[i] = last.primitive;
            }
        }
        if (!crossed && !inside) {
            fits = enter_medium(&next, medium);
        } else if (!crossed && !leave_medium(&next, medium)) {
            fits = enter_medium(&list, medium);  // the ray was in it, though it is not listed
            next = list;
            leave_medium(&next, medium);
            moved = true;
        }
        if (!fits) {  // the picture is refused: what else lies on the way, thousands perhaps, need not be found
            *overflow = MANY_MEDIA;
            break;
        }
        before = top_of(world, list);
        after = top_of(world, next);
        if (before != after) break;
        list = next;
        moved = true;
        const Hit hit = nearest_hit(world, ray, hit_t[i], hit_primitive[i], false, NO_PRIMITIVE);
        hit_t[i] = hit.t;
        hit_primitive[i] = hit.primitive;
        const float width = cone_width_of(weights, i, hit.t);
        store_surface(world, ray, hit.primitive, hit.t, width, i, i + 1, surfaces, surface_code);
        face(world, rays, i, hit_t, hit_primitive, weights, surfaces, surface_code);
    }
    surfaces[in_block(i, TOP_BEFORE, SURFACE_FIELDS)] = as_float(before);
    surfaces[in_block(i, TOP_AFTER, SURFACE_FIELDS)] = as_float(after);
    if (moved) store_media(media, i, list);
    absorb(world, top_of(world, list), hit_t[i], i, weights);
}

// Lanes whose rays stop where they are, and the materials that meet there. `top` is the medium a ray is in, but in
// lanes where it is in `several`.
INLINED intP settled(const World world, intP code, intP top, intP several, intP *before, intP *after)
{
    intP todo = code >= 0, mine, done = ~todo & ~several;
    *before = *after = top;
    while (any_of(todo)) {
        const int number = first_value(code, todo) / SURFACE_MATERIAL;
        mine = todo & (code / SURFACE_MATERIAL == number);
        todo &= ~mine;
        mine &= ~several;
        __global const Material *material = world.materials + number;
        const int medium = material->medium;
        const intP inside = (code & SURFACE_INSIDE) != 0;
        if (medium == NO_MEDIUM) {
            const intP swapped = material->thin || material->fresnel == CONDUCTOR ? (intP)(0) : mine & inside;
            *after = select(*after, (intP)(number), mine & ~swapped);
            *before = select(*before, (intP)(number), swapped);
            done |= mine;
        } else {
            mine &= (code & SURFACE_EDGE) == 0;
            const intP enters = mine & ~inside & (top == NO_MEDIUM), exits = mine & inside & (top == medium);
            *after = select(select(*after, (intP)(medium), enters), (intP)(NO_MEDIUM), exits);
            done |= enters | exits;
        }
    }
    return done;
}

__kernel void cross_boundaries(WORLD_PARAMETERS, QUEUE_PARAMETERS, HITS_PARAMETERS,
                               __global uint *overflow)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const intP none = (intP)(NO_MEDIUM);
    const intP top = as_intP(load_field((__global const float *)media, first, n, 0, MEDIA));
    intP several = (intP)(0), before, after;
#if MEDIA > 1
    several = select(none, as_intP(load_field((__global const float *)media, first, n, 1, MEDIA)), top != none) != none;
#endif
    const intP done = settled(world, load_word(surface_code, first, n), top, several, &before, &after);
    store_field(surfaces, first, n, TOP_BEFORE, SURFACE_FIELDS, as_floatP(before));
    store_field(surfaces, first, n, TOP_AFTER, SURFACE_FIELDS, as_floatP(after));
    const intP within = done & (top != none);
    if (all_of(done) && !any_of(within)) return;
    int settled_lane[PACKET], medium[PACKET];
    *(intP *)settled_lane = done;
    *(intP *)medium = top;
    for (uint k = 0; k < PACKET && first + k < n; k++) {
        if (settled_lane[k]) absorb(world, medium[k], hit_t[first + k], first + k, weights);
        else
            cross_one(world, rays, first + k, hit_t, hit_primitive, surfaces, surface_code, media, weights, overflow);
    }
}

#endif
