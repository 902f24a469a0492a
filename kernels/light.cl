// Local light: what a ray's hit sends back by itself, the shadow feelers that decide about the lights, what the lights
// add, and the count of everything the hit will spawn. One work-item a packet.
//
// Queues are dense and in stable order, so `shade` counts, a scan gives every ray its places, and `feelers` writes.
// After the feelers were traced `illuminate` finds directions to the lights anew and takes the packet's feelers in the
// same order: that is cheaper than to keep what each would bring, and nothing is computed for a light that is hidden.
#include "bounce.clh"
#include "light.clh"
#include "shaft.clh"
#include "sky.clh"
#include "tinted.clh"

// Where the surface of a light shows nothing: behind, unless it shines on both sides; and to ambient rays, since feelers
// have counted it.
INLINED intP dark(__global const Material *material, const Surfaces s, uint ambient_queue)
{
    if (ambient_queue) return (intP)(-1);
    return material->light == 2 ? (intP)(0) : (s.code & SURFACE_INSIDE) != 0;
}

// `local_radiance` receives weight * (emission + ambient), or the background; where it is not black: SPAWN_LOCAL says
// so, without which it is not to be read. `spawn` receives the packed counts (layout.SPAWN). In the last generation
// nothing is spawned: `depth_color` stands for it.
__kernel void shade(WORLD_PARAMETERS, QUEUE_PARAMETERS, HITS_PARAMETERS, SHADED_PARAMETERS, PIXELS_PARAMETERS,
                    uint ambient_queue, uint last, uint terms)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    Surfaces s = load_surfaces(world, surfaces, surface_code, weights, first, n);
    const VecP u = load_vec(rays, first, n, DIRECTION_X, RAY_FIELDS);
    const intP ungathered = (load_word(path, first, n) & PATH_GATHERED) == 0;
    floatP weight[RAY_BANDS], value[RAY_BANDS];
    for (int b = 0; b < RAY_BANDS; b++) weight[b] = load_field(weights, first, n, b, VALUES);

    // misses: an ambient ray that meets nothing brings the constant ambient light
    const intP missed = s.code < 0;
    for (int b = 0; b < RAY_BANDS; b++) value[b] = (floatP)(0.0f);
    if (any_of(missed) && terms == TERM_ALL) {
        if (!ambient_queue) backgrounds(world, s, u, missed, value);
        for (int b = 0; b < RAY_BANDS; b++)
            value[b] = weight[b] * (ambient_queue ? in_band(world.scene->ambient, s, b) : value[b]);
    }

    intP found = select((intP)(SPAWN_HIT), (intP)(0), missed);
    const VecP start = offset_origin(s, s.n);
    const Pixels pixels = PIXELS_OF_PARAMETERS;
    const Streams streams = light_streams(world, pixels, path, first, n);
    const Streams facets = gloss_streams(world, pixels, path, first, n);
    intP todo = ~missed, mine;
    SHOW_PICTURES(world, s, todo, SHOWN(MIRROR) | SHOWN(TINT) | SHOWN(EMISSION));
    while (any_of(todo)) {
        __global const Material *material = next_material(world, &s, &todo, &mine);
        if (scatters(material, terms))
            for (int l = 0; l < world.scene->lights; l++) {
                __global const Light *light = world.lights + l;
                Draw draw = light_draw(light, streams, l);
                for (int i = 0; i < light->samples; i++, draw = next_draw(draw))
                    found += is_above(s, light_sample(light, start, draw)) & mine & 1;
            }

        intP gathers = (intP)(0);
        if (world.scene->ambient_samples > 0 && !last && terms & TERM_AMBIENT) {
            floatP most = (floatP)(0.0f);
            for (int b = 0; b < RAY_BANDS; b++)
                most = larger(weight[b] * (material->ka * colors(material, s, b)), most);
            gathers = ungathered & (most > 0.0f);
            found |= gathers & mine & SPAWN_AMBIENT;
        }
        for (int b = 0; b < RAY_BANDS; b++) {
            floatP emission = (floatP)(0.0f), ambient = emission;
            if (terms & TERM_EMISSION) emission = EMISSION_OF(s, material, b);
            if (material->light) emission = select(emission, (floatP)(0.0f), dark(material, s, ambient_queue));
            if (terms & TERM_AMBIENT)
                ambient = select(material->ka * colors(material, s, b) * in_band(world.scene->ambient, s, b), ambient,
                                 gathers);
            value[b] = select(value[b], weight[b] * (emission + ambient), mine);
        }
        if (terms != TERM_ALL || !(material->kr > 0.0f || material->kt > 0.0f)) continue;

        const intP dispersing = disperses(world, s, material) & mine;
        const int together = bands_together(dispersing);
        floatP most = (floatP)(0.0f);
        intP transmitted = (intP)(0), total_internal = (intP)(0), groups = (intP)(0);
        for (int from = 0; from < RAY_BANDS; from += together) {
            const int to = min(from + together, RAY_BANDS);
            const Bounce bounce = bounce_at(world, s, material, from, u, facets);
            for (int b = from; b < to; b++) most = larger(weight[b] * reflects(s, material, bounce, b), most);
            transmitted = passes_on(world, s, material, bounce, weight, from, to);
            total_internal |= bounce.total_internal;
            groups += transmitted & SPAWN_GROUP;
        }
        const intP reflected = mine & (world.scene->spd ? (intP)(-1) : worth_tracing(world, most));
        if (!last) {
            found |= (reflected & SPAWN_REFLECTION) | (total_internal & mine & SPAWN_TOTAL_INTERNAL)
                   | (select(transmitted & SPAWN_TRANSMISSION, groups, dispersing) & mine);
            continue;
        }
        for (int from = 0; from < RAY_BANDS; from += together) {
            const int to = min(from + together, RAY_BANDS);
            const Bounce bounce = bounce_at(world, s, material, from, u, facets);
            transmitted = mine & passes_on(world, s, material, bounce, weight, from, to);
            for (int b = from; b < to; b++) {
                const floatP instead = in_band(world.scene->depth_color, s, b);
                const floatP back = weight[b] * reflects(s, material, bounce, b) * instead;
                const floatP on = weight[b] * transmits(s, material, bounce, b) * instead;
                value[b] = select(value[b], value[b] + back, reflected);
                value[b] = select(value[b], value[b] + on, transmitted);
            }
        }
    }
    intP bright = (intP)(0);
    for (int b = 0; b < RAY_BANDS; b++) bright |= value[b] != 0.0f;
    found |= bright & SPAWN_LOCAL;
    if (any_of(bright))
        for (int b = 0; b < RAY_BANDS; b++) store_field(local_radiance, first, n, b, VALUES, value[b]);
#if NARROW
    store_field(local_radiance, first, n, RAY_BANDS, VALUES, as_floatP(s.band));
#endif
    store_word((__global int *)spawn, first, n, found);
}

// What stands between points and a light whose feelers are worth a shaft: how many primitives; -1 where they are many,
// or not asked for.
INLINED int stands_between(const World *world, __global const Light *light, VecP start, intP which, Standing *standing)
{
    Shaft shaft;
    if (!light->extended || light->samples < WORTH_A_SHAFT || world->scene->one_sided) return -1;
    const Vec size = fabs(light->u.xyz) + fabs(light->v.xyz) + light->radius;
    if (!shaft_between(start, which, light->place.xyz, size, &shaft)) return -1;
    return standing_in(world, &shaft, standing);
}

// One ray to each light above the surface, or to each of its points. The feelers of a packet stand light after light, so
// that neighbours in the queue go the same way (with seven lights they are traced 2.5 times as fast); `owner` says which
// ray each belongs to.
__kernel void feelers(WORLD_PARAMETERS, QUEUE_PARAMETERS, HITS_PARAMETERS, SHADED_PARAMETERS, PIXELS_PARAMETERS,
                      FEELERS_PARAMETERS)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const intP counted = (load_word(spawn, first, n) & SPAWN_FEELERS) != 0;
    if (!any_of(counted)) return;
    const World world = WORLD_OF_PARAMETERS;
    const Surfaces s = load_surfaces(world, surfaces, surface_code, weights, first, n);
    const VecP start = offset_origin(s, s.n);
    float ox[PACKET], oy[PACKET], oz[PACKET], dx[PACKET], dy[PACKET], dz[PACKET], distance[PACKET];
    int launched[PACKET];
    uint place[PACKET];
    *(floatP *)ox = start.x;
    *(floatP *)oy = start.y;
    *(floatP *)oz = start.z;
    uint at = first_feeler[first];
    const uint lanes = min((uint)PACKET, n - first);
    const Pixels pixels = PIXELS_OF_PARAMETERS;
    const Streams streams = light_streams(world, pixels, path, first, n);
    for (int l = 0; l < world.scene->lights; l++) {
        __global const Light *light = world.lights + l;
        Draw draw = light_draw(light, streams, l);
        Standing standing[STANDING];
        const int found = stands_between(&world, light, start, counted, standing);
        for (int i = 0; i < light->samples; i++, draw = next_draw(draw)) {
            const LightSample to = light_sample(light, start, draw);
            const intP launch = counted & is_above(s, to);
            if (!any_of(launch)) continue;
            *(floatP *)dx = to.direction.x;
            *(floatP *)dy = to.direction.y;
            *(floatP *)dz = to.direction.z;
            *(floatP *)distance = to.distance;
            *(intP *)launched = launch;
            for (uint k = 0; k < lanes; k++) {
                if (!launched[k]) continue;
                store_ray(feeler_rays, at, vec(ox[k], oy[k], oz[k]), vec(dx[k], dy[k], dz[k]), distance[k]);
#if NARROW
                if (world.scene->tinted)
                    filter[in_block(at, RAY_BANDS, VALUES)] = as_float(first_band(weights, first + k));
#endif
                if (world.scene->surfaces) own[at] = light->surface;
                if (world.scene->extended) seen[at] = UNTRACED;
                place[k] = at;
                owner[at++] = first + k;
            }
            if (found < 0) continue;
            const RayP ray = {start, to.direction, to.distance};
            const intP all = launch & (as_intP(counting_from(0)) < (int)lanes);
            trace_standing(&world, &ray, all, place, standing, found, light->surface, seen, filter);
        }
    }
}

// lanes whose feelers reached the light; `at` is the next feeler of the packet. `place` receives those of lanes that
// came through something, `through`.
INLINED intP arrivals(intP launch, uint lanes, __global const uint *seen, uint *at, uint *place, intP *through)
{
    ALIGNED int arrived[PACKET], launched[PACKET];
    *(intP *)launched = launch;
    for (uint k = 0; k < PACKET; k++) {
        arrived[k] = 0;
        if (k >= lanes || !launched[k]) continue;
        arrived[k] = seen[*at];
        place[k] = (*at)++;
    }
    *through = *(intP *)arrived == FILTERED;
    return *(intP *)arrived != 0;
}

// what surfaces on the way have let through of a band
INLINED floatP filtered(__global const float *filter, const uint *place, intP which, int b)
{
    float share[PACKET];
    int here[PACKET];
    *(intP *)here = which;
    for (uint k = 0; k < PACKET; k++) share[k] = here[k] ? filter[in_block(place[k], b, VALUES)] : 1.0f;
    return *(floatP *)share;
}

// Adds what comes from the lights that the feelers have reached to `local_radiance`, light after light; SPAWN_LOCAL
// then says that it is to be read.
__kernel void illuminate(WORLD_PARAMETERS, QUEUE_PARAMETERS, HITS_PARAMETERS, SHADED_PARAMETERS, PIXELS_PARAMETERS,
                         FEELERS_PARAMETERS, uint terms)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const intP found = load_word(spawn, first, n), counted = (found & SPAWN_FEELERS) != 0;
    if (!any_of(counted)) return;
    const World world = WORLD_OF_PARAMETERS;
    Surfaces s = load_surfaces(world, surfaces, surface_code, weights, first, n);
    const VecP u = load_vec(rays, first, n, DIRECTION_X, RAY_FIELDS), start = offset_origin(s, s.n);
    const intP bright = (found & SPAWN_LOCAL) != 0;
    const bool any_bright = any_of(bright);
    floatP value[RAY_BANDS], radiance[RAY_BANDS];
    for (int b = 0; b < RAY_BANDS; b++) {
        value[b] = (floatP)(0.0f);
        if (any_bright) value[b] = select(value[b], load_field(local_radiance, first, n, b, VALUES), bright);
    }
    SHOW_PICTURES(world, s, counted, SHOWN(HIGHLIGHT));
    uint at = first_feeler[first], place[PACKET];
    const uint lanes = min((uint)PACKET, n - first);
    intP lighter = (intP)(0);
    const Pixels pixels = PIXELS_OF_PARAMETERS;
    const Streams streams = light_streams(world, pixels, path, first, n);
    for (int l = 0; l < world.scene->lights; l++) {
        __global const Light *light = world.lights + l;
        Draw draw = light_draw(light, streams, l);
        for (int i = 0; i < light->samples; i++, draw = next_draw(draw)) {
            const LightSample to = light_sample(light, start, draw);
            const intP launch = counted & is_above(s, to);
            if (!any_of(launch)) continue;
            intP through;
            intP todo = arrivals(launch, lanes, seen, &at, place, &through), mine;
            const bool any_through = any_of(through);
            lighter |= todo;
            while (any_of(todo)) {
                __global const Material *material = next_material(world, &s, &todo, &mine);
                reflected_light(light, to, s, material, u, terms, radiance);
                for (int b = 0; b < RAY_BANDS; b++) {
                    floatP brings = load_field(weights, first, n, b, VALUES) * radiance[b];
                    if (any_through) brings *= filtered(filter, place, through, b);
                    value[b] = select(value[b], value[b] + brings, mine);
                }
            }
        }
    }
    if (!any_of(lighter)) return;
    for (int b = 0; b < RAY_BANDS; b++) store_field(local_radiance, first, n, b, VALUES, value[b]);
    store_word((__global int *)spawn, first, n, found | (lighter & SPAWN_LOCAL));
}
