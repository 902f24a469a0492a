// The next generation: reflection rays and transmission rays, one pass and one queue each, and the narrow rays of
// dispersion. One work-item a packet.
//
// `slot` is each parent's place in the queue of children; it was counted before, so a queue is exactly as long
// as what is written to it, and the children of a pixel stand together in the order of their parents.
#include "hash.clh"
#include "bounce.clh"
#include "media.clh"

// the parents' words, and the queue that receives the children
typedef struct {
    __global const uint *pixel_of;
    __global const uint *path;
    __global const int *spawn;
    __global const uint *slot;
    __global const int *media;
    __global float *rays;
    __global uint *pixel;
    __global uint *path_of;
    __global float *weight;
    __global int *child_media;
} Family;

// Writes the children of the lanes that spawn one: `child` is the number that makes their key, `route` the kind
// of bounce for rays that have had none.
inline void store_children(const World world, const Family f, __global const int *surface_code, uint first, uint n,
                           int spawn_bit, uint child, uint route, Vec origin, Vec direction,
                           __global const float *weights, const floatP *weight)
{
    float ox[PACKET], oy[PACKET], oz[PACKET], dx[PACKET], dy[PACKET], dz[PACKET];
    const float *w = (const float *)weight;  // a band after the other, PACKET rays each
    *(floatP *)ox = origin.x;
    *(floatP *)oy = origin.y;
    *(floatP *)oz = origin.z;
    *(floatP *)dx = direction.x;
    *(floatP *)dy = direction.y;
    *(floatP *)dz = direction.z;
    for (uint k = 0; k < PACKET && first + k < n; k++) {
        const uint i = first + k;
        if (!(f.spawn[i] & spawn_bit)) continue;
        const uint at = f.slot[i], flags = f.path[i] & PATH_FLAGS;
        store_ray(f.rays, at, (float3)(ox[k], oy[k], oz[k]), (float3)(dx[k], dy[k], dz[k]), INFINITY);
        f.pixel[at] = f.pixel_of[i];
        f.path_of[at] = child_path(f.path[i], child, flags & PATH_ROUTE ? flags : flags | route);
        __global float *into = f.weight + in_block(at, 0, VALUES);
        ONE_BY_ONE
        for (int b = 0; b < RAY_BANDS; b++) into[b * LANES] = w[b * PACKET + k];
#if NARROW
        f.weight[in_block(at, RAY_BANDS, VALUES)] = as_float(first_band(weights, i));
#endif
#if MEDIA
        hand_on_media(world, f.media, i, surface_code[i], child == CHILD_TRANSMISSION, f.child_media, at);
#endif
    }
}

// `reflecting`: reflection rays, else transmission rays
inline void bounce_packet(const World world, __global const float *rays, __global const float *surfaces,
                          __global const int *surface_code, __global const float *weights, const Family f,
                          uint n, bool reflecting)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const int spawn_bit = reflecting ? SPAWN_REFLECTION : SPAWN_TRANSMISSION;
    intP todo = (load_word(f.spawn, first, n) & spawn_bit) != 0, mine;
    if (!any_of(todo)) return;
    const Surfaces s = load_surfaces(surfaces, surface_code, weights, first, n);
    const Vec u = load_vec(rays, first, n, DIRECTION_X, RAY_FIELDS);
    Vec direction = u;
    floatP weight[RAY_BANDS];
    for (int b = 0; b < RAY_BANDS; b++) weight[b] = (floatP)(0.0f);
    while (any_of(todo)) {
        __global const Material *material = next_material(world, s, &todo, &mine);
        const int together = bands_together(disperses(world, s, material) & mine);
        for (int from = 0; from < RAY_BANDS; from += together) {
            const Bounce bounce = bounce_at(world, s, material, from, u);
            direction = choose(direction, bounce.transmitted, mine);
            for (int b = from; b < min(from + together, RAY_BANDS); b++) {
                const floatP share = reflecting ? reflects(s, material, bounce, b) : transmits(s, material, bounce, b);
                weight[b] = select(weight[b], load_field(weights, first, n, b, VALUES) * share, mine);
            }
        }
    }
    if (reflecting)
        store_children(world, f, surface_code, first, n, spawn_bit, CHILD_REFLECTION, 1, leaves(s, s.n),
                       reflected(s, u), weights, weight);
    else
        store_children(world, f, surface_code, first, n, spawn_bit, CHILD_TRANSMISSION, 2, leaves(s, minus(s.n)),
                       direction, weights, weight);
}

__kernel void reflect(WORLD_PARAMETERS, __global const float *rays, __global const float *surfaces,
                      __global const int *surface_code, __global const uint *pixel_of,
                      __global const uint *path, __global const float *weights,
                      __global const int *spawn, __global const uint *slot, __global const int *media, uint n,
                      __global float *child_rays, __global uint *child_pixel, __global uint *child_path_of,
                      __global float *child_weight, __global int *child_media)
{
    const World world = WORLD_OF_PARAMETERS;
    const Family f = {pixel_of, path, spawn, slot, media,
                      child_rays, child_pixel, child_path_of, child_weight, child_media};
    bounce_packet(world, rays, surfaces, surface_code, weights, f, n, true);
}

__kernel void transmit(WORLD_PARAMETERS, __global const float *rays, __global const float *surfaces,
                       __global const int *surface_code, __global const uint *pixel_of,
                       __global const uint *path, __global const float *weights,
                       __global const int *spawn, __global const uint *slot, __global const int *media, uint n,
                       __global float *child_rays, __global uint *child_pixel, __global uint *child_path_of,
                       __global float *child_weight, __global int *child_media)
{
    const World world = WORLD_OF_PARAMETERS;
    const Family f = {pixel_of, path, spawn, slot, media,
                      child_rays, child_pixel, child_path_of, child_weight, child_media};
    bounce_packet(world, rays, surfaces, surface_code, weights, f, n, false);
}

#if GROUP && !NARROW

// One ray a group of bands, in the order of the groups, where the index on either side is a curve (docs/model.md,
// "Media"). The children carry one group, and its first band: GROUP + 1 values.
__kernel void disperse(WORLD_PARAMETERS, __global const float *rays, __global const float *surfaces,
                       __global const int *surface_code, __global const uint *pixel_of,
                       __global const uint *path, __global const float *weights,
                       __global const int *spawn, __global const int *slot, __global const int *media, uint n,
                       __global float *child_rays, __global uint *child_pixel, __global uint *child_path_of,
                       __global float *child_weight, __global int *child_media)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    intP todo = (load_word(spawn, first, n) & SPAWN_GROUPS) != 0, mine;
    if (!any_of(todo)) return;
    const World world = WORLD_OF_PARAMETERS;
    const Surfaces s = load_surfaces(surfaces, surface_code, weights, first, n);
    const Vec u = load_vec(rays, first, n, DIRECTION_X, RAY_FIELDS), origin = leaves(s, minus(s.n));
    float ox[PACKET], oy[PACKET], oz[PACKET], dx[PACKET], dy[PACKET], dz[PACKET], w[GROUP][PACKET];
    int place[PACKET], launched[PACKET];
    floatP weight[BANDS];
    for (int b = 0; b < BANDS; b++) weight[b] = load_field(weights, first, n, b, VALUES);
    *(floatP *)ox = origin.x;
    *(floatP *)oy = origin.y;
    *(floatP *)oz = origin.z;
    *(intP *)place = load_word(slot, first, n);
    while (any_of(todo)) {
        __global const Material *material = next_material(world, s, &todo, &mine);
        for (int from = 0; from < BANDS; from += GROUP) {
            const int to = min(from + GROUP, BANDS);
            const Bounce bounce = bounce_at(world, s, material, from, u);
            *(intP *)launched = mine & passes_on(world, s, material, bounce, weight, from, to);
            *(floatP *)dx = bounce.transmitted.x;
            *(floatP *)dy = bounce.transmitted.y;
            *(floatP *)dz = bounce.transmitted.z;
            for (int b = 0; b < GROUP; b++)
                *(floatP *)w[b] = from + b < to ? weight[from + b] * transmits(s, material, bounce, from + b)
                                                : (floatP)(0.0f);
            for (uint k = 0; k < PACKET && first + k < n; k++) {
                if (!launched[k]) continue;
                const uint i = first + k, at = place[k]++, flags = path[i] & PATH_FLAGS;
                store_ray(child_rays, at, (float3)(ox[k], oy[k], oz[k]), (float3)(dx[k], dy[k], dz[k]), INFINITY);
                child_pixel[at] = pixel_of[i];
                child_path_of[at] = child_path(path[i], CHILD_TRANSMISSION, flags & PATH_ROUTE ? flags : flags | 2);
                for (int b = 0; b < GROUP; b++) child_weight[in_block(at, b, GROUP + 1)] = w[b][k];
                child_weight[in_block(at, GROUP, GROUP + 1)] = as_float(from);
#if MEDIA
                hand_on_media(world, media, i, surface_code[i], true, child_media, at);
#endif
            }
        }
    }
}

#endif
