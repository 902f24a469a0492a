// The next generation: reflection rays, transmission rays and ambient rays, one pass and one queue each. One
// work-item a packet.
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
                           int spawn_bit, uint child, uint route, Vec origin, Vec direction, const floatP *weight)
{
    float ox[PACKET], oy[PACKET], oz[PACKET], dx[PACKET], dy[PACKET], dz[PACKET], w[BANDS][PACKET];
    *(floatP *)ox = origin.x;
    *(floatP *)oy = origin.y;
    *(floatP *)oz = origin.z;
    *(floatP *)dx = direction.x;
    *(floatP *)dy = direction.y;
    *(floatP *)dz = direction.z;
    for (int b = 0; b < BANDS; b++) *(floatP *)w[b] = weight[b];
    for (uint k = 0; k < PACKET && first + k < n; k++) {
        const uint i = first + k;
        if (!(f.spawn[i] & spawn_bit)) continue;
        const uint at = f.slot[i], flags = f.path[i] & PATH_FLAGS;
        store_ray(f.rays, at, (float3)(ox[k], oy[k], oz[k]), (float3)(dx[k], dy[k], dz[k]), INFINITY);
        f.pixel[at] = f.pixel_of[i];
        f.path_of[at] = child_path(f.path[i], child, flags & PATH_ROUTE ? flags : flags | route);
        for (int b = 0; b < BANDS; b++) f.weight[in_block(at, b, BANDS)] = w[b][k];
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
    const Surfaces s = load_surfaces(surfaces, surface_code, first, n);
    const Vec u = load_vec(rays, first, n, DIRECTION_X, RAY_FIELDS);
    Vec direction = u;
    floatP weight[BANDS];
    for (int b = 0; b < BANDS; b++) weight[b] = (floatP)(0.0f);
    while (any_of(todo)) {
        __global const Material *material = next_material(world, s, &todo, &mine);
        const Bounce bounce = bounce_at(world, s, material, u);
        direction = choose(direction, bounce.transmitted, mine);
        for (int b = 0; b < BANDS; b++) {
            const floatP share = reflecting ? reflects(material, bounce, b) : transmits(material, bounce, b);
            weight[b] = select(weight[b], load_field(weights, first, n, b, BANDS) * share, mine);
        }
    }
    if (reflecting)
        store_children(world, f, surface_code, first, n, spawn_bit, CHILD_REFLECTION, 1, leaves(s, s.n),
                       reflected(s, u), weight);
    else
        store_children(world, f, surface_code, first, n, spawn_bit, CHILD_TRANSMISSION, 2, leaves(s, minus(s.n)),
                       direction, weight);
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
