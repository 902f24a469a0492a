// The next generation: reflection rays and transmission rays, one pass and one queue each, and the narrow rays of
// dispersion. One work-item a packet.
//
// `slot` is each parent's place in the queue of children; it was counted before, so a queue is exactly as long
// as what is written to it, and the children of a pixel stand together in the order of their parents.
#include "children.clh"
#include "bounce.clh"
#include "extent.clh"

// the flags of a child by a bounce: `route` is its kind for rays that have had none
inline uint routed(uint path, uint route)
{
    const uint flags = path & PATH_FLAGS;
    return flags & PATH_ROUTE ? flags : flags | route;
}

// Writes the children of the lanes `spawning` (from lanes_of).
INLINED void store_children(const World world, const Family f, uint first, uint spawning, bool reflecting, VecP origin,
                            VecP direction, const floatP *weight)
{
    float ox[PACKET], oy[PACKET], oz[PACKET], dx[PACKET], dy[PACKET], dz[PACKET];
    const float *w = (const float *)weight;  // a band after the other, PACKET rays each
    *(floatP *)ox = origin.x;
    *(floatP *)oy = origin.y;
    *(floatP *)oz = origin.z;
    *(floatP *)dx = direction.x;
    *(floatP *)dy = direction.y;
    *(floatP *)dz = direction.z;
    for (; spawning; spawning = without_first(spawning)) {
        const uint k = first_lane(spawning), i = first + k, at = f.slot[i];
        store_child(world, f, i, at, reflecting ? CHILD_REFLECTION : CHILD_TRANSMISSION,
                    routed(f.queue.path[i], reflecting ? 1 : 2), vec(ox[k], oy[k], oz[k]), vec(dx[k], dy[k], dz[k]));
        __global float *into = f.child.child_weights + in_block(at, 0, VALUES);
        ONE_BY_ONE
        for (int b = 0; b < RAY_BANDS; b++) into[b * LANES] = w[b * PACKET + k];
#if NARROW
        f.child.child_weights[in_block(at, RAY_BANDS, VALUES)] = as_float(first_band(f.queue.weights, i));
#endif
        hand_on_cone(f, i, at, VALUES);
    }
}

// `reflecting`: reflection rays, else transmission rays
inline void bounce_packet(const World world, const Family f, const Pixels pixels, bool reflecting)
{
    const uint first = get_global_id(0) * PACKET, n = f.queue.n;
    if (first >= n) return;
    const int spawn_bit = reflecting ? SPAWN_REFLECTION : SPAWN_TRANSMISSION;
    intP todo = ((load_word(f.shaded.spawn, first, n) & spawn_bit) != 0) & lanes_within(first, n), mine;
    const uint spawning = lanes_of(todo);
    if (!spawning) return;
    Surfaces s = load_surfaces(world, f.hits.surfaces, f.hits.surface_code, f.hits.hit_t, f.queue.weights, first, n);
    const VecP u = load_vec(f.queue.rays, first, n, DIRECTION_X, RAY_FIELDS);
    const Streams streams = gloss_streams(world, pixels, f.queue.path, first, n);
    SHOW_PICTURES(world, s, todo, SHOWN(MIRROR) | SHOWN(TINT));
    VecP direction = u;
    if (reflecting) direction = reflected(s, u);
    floatP weight[RAY_BANDS];
    for (int b = 0; b < RAY_BANDS; b++) weight[b] = (floatP)(0.0f);
    while (any_of(todo)) {
        __global const Material *material = next_material(world, &s, &todo, &mine);
        const int together = bands_together(disperses(world, s, material) & mine);
        for (int from = 0; from < RAY_BANDS; from += together) {
            const Bounce bounce = bounce_at(world, s, material, from, u, streams);
            if (!reflecting) direction = choose(direction, bounce.transmitted, mine);
            else if (IS_ROUGH(material)) direction = choose(direction, bounce.glossy, mine);
            for (int b = from; b < min(from + together, RAY_BANDS); b++) {
                const floatP share = reflecting ? reflects(s, material, bounce, b) : transmits(s, material, bounce, b);
                weight[b] = select(weight[b], load_field(f.queue.weights, first, n, b, VALUES) * share, mine);
            }
        }
    }
    if (reflecting) store_children(world, f, first, spawning, true, start_before(s, u), direction, weight);
    else store_children(world, f, first, spawning, false, start_behind(s), direction, weight);
}

__kernel void reflect(SPAWN_PARAMETERS, PIXELS_PARAMETERS)
{
    const World world = WORLD_OF_PARAMETERS;
    const Family family = FAMILY_OF_PARAMETERS;
    const Pixels pixels = PIXELS_OF_PARAMETERS;
    bounce_packet(world, family, pixels, true);
}

__kernel void transmit(SPAWN_PARAMETERS)
{
    const World world = WORLD_OF_PARAMETERS;
    const Family family = FAMILY_OF_PARAMETERS;
    const Pixels none = {0, 0, 0};  // what transmits is not rough
    bounce_packet(world, family, none, false);
}

#if GROUP && !NARROW

// One ray a group of bands, in the order of the groups, where the index on either side is a curve (docs/model.md,
// "Media"). The children carry one group, and its first band.
#define NARROW_VALUES (GROUP + 1 + 2 * MIPS)
__kernel void disperse(SPAWN_PARAMETERS)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    intP todo = ((load_word(spawn, first, n) & SPAWN_GROUPS) != 0) & lanes_within(first, n), mine;
    if (!any_of(todo)) return;
    const World world = WORLD_OF_PARAMETERS;
    const Family family = FAMILY_OF_PARAMETERS;
    Surfaces s = load_surfaces(world, surfaces, surface_code, hit_t, weights, first, n);
    const VecP u = load_vec(rays, first, n, DIRECTION_X, RAY_FIELDS), origin = start_behind(s);
    const Streams streams = {(uintP)(0u), (uintP)(0u)};  // what transmits is not rough
    SHOW_PICTURES(world, s, todo, SHOWN(TINT));
    float ox[PACKET], oy[PACKET], oz[PACKET], dx[PACKET], dy[PACKET], dz[PACKET], w[GROUP][PACKET];
    uint place[PACKET];
    floatP weight[BANDS];
    for (int b = 0; b < BANDS; b++) weight[b] = load_field(weights, first, n, b, VALUES);
    *(floatP *)ox = origin.x;
    *(floatP *)oy = origin.y;
    *(floatP *)oz = origin.z;
    *(intP *)place = load_word(slot, first, n);
    while (any_of(todo)) {
        __global const Material *material = next_material(world, &s, &todo, &mine);
        for (int from = 0; from < BANDS; from += GROUP) {
            const int to = min(from + GROUP, BANDS);
            const Bounce bounce = bounce_at(world, s, material, from, u, streams);
            uint launched = lanes_of(mine & passes_on(world, s, material, bounce, weight, from, to));
            *(floatP *)dx = bounce.transmitted.x;
            *(floatP *)dy = bounce.transmitted.y;
            *(floatP *)dz = bounce.transmitted.z;
            for (int b = 0; b < GROUP; b++)
                *(floatP *)w[b] = from + b < to ? weight[from + b] * transmits(s, material, bounce, from + b)
                                                : (floatP)(0.0f);
            for (; launched; launched = without_first(launched)) {
                const uint k = first_lane(launched), i = first + k, at = place[k]++;
                store_child(world, family, i, at, CHILD_TRANSMISSION, routed(path[i], 2), vec(ox[k], oy[k], oz[k]),
                            vec(dx[k], dy[k], dz[k]));
                for (int b = 0; b < GROUP; b++) child_weights[in_block(at, b, NARROW_VALUES)] = w[b][k];
                child_weights[in_block(at, GROUP, NARROW_VALUES)] = as_float(from);
                hand_on_cone(family, i, at, NARROW_VALUES);
            }
        }
    }
}

#endif
