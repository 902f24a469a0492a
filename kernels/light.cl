// Local light: what a ray's hit sends back by itself, the shadow feelers that decide about the lights, what the lights
// add, and the count of everything the hit will spawn. One work-item a packet.
//
// Queues are dense and in stable order, so `shade` counts, the sums of chunks give each its first place, and `feelers`
// writes.
// After the feelers were traced `illuminate` finds directions to the lights anew and takes the packet's feelers in the
// same order: that is cheaper than to keep what each would bring, and nothing is computed for a light that is hidden.
#include "bounce.clh"
#include "dense.clh"
#include "extent.clh"
#include "light.clh"
#include "shaft.clh"
#include "sky.clh"
#include "tinted.clh"

// the fields of a feeler behind those of its ray (dense.clh)
#define FEELER_OWNER RAY_FIELDS
#define FEELER_OWN (RAY_FIELDS + 1)
#define FEELER_BAND (RAY_FIELDS + 2)

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
    Surfaces s = load_surfaces(world, surfaces, surface_code, hit_t, weights, first, n);
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
    const VecP start = start_before(s, u);
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
            if (IS_LIGHT(material)) emission = select(emission, (floatP)(0.0f), dark(material, s, ambient_queue));
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
            const intP goes = passes_on(world, s, material, bounce, weight, from, to);
            transmitted |= goes;
            total_internal |= bounce.total_internal;
            groups += goes & SPAWN_GROUP;
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
            const intP goes = passes_on(world, s, material, bounce, weight, from, to);
            const intP goes_on = mine & select(transmitted, goes, dispersing);
            for (int b = from; b < to; b++) {
                const floatP instead = in_band(world.scene->depth_color, s, b);
                const floatP back = weight[b] * reflects(s, material, bounce, b) * instead;
                const floatP on = weight[b] * transmits(s, material, bounce, b) * instead;
                value[b] = select(value[b], value[b] + back, reflected);
                value[b] = select(value[b], value[b] + on, goes_on);
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
    if (!IS_EXTENDED(light) || light->samples < WORTH_A_SHAFT || world->scene->one_sided) return -1;
    const Vec size = fabs(light->u.xyz) + fabs(light->v.xyz) + light->radius;
    if (!shaft_between(start, which, light->place.xyz, size, &shaft)) return -1;
    return standing_in(world, &shaft, standing);
}

// Traces the feelers of the lanes `which`, at `at` and on in the queue, past the primitives that may stand between.
INLINED void pass_standing(const World *world, const Surfaces *s, const RayP *feelers, intP which, uint at, int own,
                           const Standing *standing, int count, __global uint *seen, __global float *filter)
{
    uint place[PACKET];
    for (uint left = lanes_of(which); left; left = without_first(left)) place[first_lane(left)] = at++;
#if NARROW
    if (world->scene->tinted) {  // what is appended may still be on its way
        ALIGNED int band[PACKET];
        *(intP *)band = s->band;
        for (uint left = lanes_of(which); left; left = without_first(left))
            filter[in_block(place[first_lane(left)], RAY_BANDS, VALUES)] = as_float(band[first_lane(left)]);
    }
#endif
    trace_standing(world, feelers, which, place, standing, count, own, seen, filter);
}

// The feelers of the packet at `first`; `own` and `filter` are not written where they do not matter.
INLINED void append_feelers(const World world, Surfaces s, VecP start, intP counted, const Streams streams, uint first,
                            Appended *to, __global float *feeler_rays, __global uint *owner, __global uint *seen,
                            __global int *own, __global float *filter)
{
    for (int l = 0; l < world.scene->lights; l++) {
        __global const Light *light = world.lights + l;
        Draw draw = light_draw(light, streams, l);
        Standing standing[STANDING];
        const int found = stands_between(&world, light, start, counted, standing);
        for (int i = 0; i < light->samples; i++, draw = next_draw(draw)) {
            const LightSample way = light_sample(light, start, draw);
            const intP launched = counted & is_above(s, way);
            if (!any_of(launched)) continue;
            const Appending a = appending(to, lanes_of(launched));
            const RayP ray = {start, way.direction, way.distance * FEELER_REACH};
            append_ray(to, &a, feeler_rays, ray.origin, ray.direction, ray.t_max);
            append_word(to, &a, FEELER_OWNER, owner, as_intP(counting_from(first)));
            if (own) append_word(to, &a, FEELER_OWN, own, (intP)(light->surface));
#if NARROW
            if (world.scene->tinted) append(to, &a, FEELER_BAND, filter, RAY_BANDS, VALUES, as_floatP(s.band));
#endif
            if (HAS_EXTENDED(world.scene))
                for (uint k = 0; k < a.count; k++) seen[to->at + k] = UNTRACED;
            if (found >= 0)
                pass_standing(&world, &s, &ray, launched, to->at, light->surface, standing, found, seen, filter);
            to->at += a.count;
        }
    }
}

// One ray to each light above the surface, or to each of its points. The feelers of a packet stand light after light, so
// that neighbours in the queue go the same way (with seven lights they are traced 2.5 times as fast); `owner` says which
// ray each belongs to. One work-item a chunk of rays.
__kernel void feelers(WORLD_PARAMETERS, QUEUE_PARAMETERS, HITS_PARAMETERS, SHADED_PARAMETERS, PIXELS_PARAMETERS,
                      FEELERS_PARAMETERS)
{
    const uint chunk = get_global_id(0), end = min((chunk + 1) * CHUNK, n);
    if (chunk * CHUNK >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const Pixels pixels = PIXELS_OF_PARAMETERS;
    Appended to;
    to.first = to.at = first_feeler[chunk];
    for (uint first = chunk * CHUNK; first < end; first += PACKET) {
        const intP counted = ((load_word(spawn, first, n) & SPAWN_FEELERS) != 0) & lanes_within(first, n);
        if (!any_of(counted)) continue;
        const Surfaces s = load_surfaces(world, surfaces, surface_code, hit_t, weights, first, n);
        const VecP u = load_vec(rays, first, n, DIRECTION_X, RAY_FIELDS), start = start_before(s, u);
        const Streams streams = light_streams(world, pixels, path, first, n);
        append_feelers(world, s, start, counted, streams, first, &to, feeler_rays, owner, seen, own, filter);
    }
    for (int i = 0; i < RAY_FIELDS; i++) append_rest(&to, i, feeler_rays, i, RAY_FIELDS);
    append_rest(&to, FEELER_OWNER, (__global float *)owner, 0, 1);
    if (own) append_rest(&to, FEELER_OWN, (__global float *)own, 0, 1);
#if NARROW
    if (world.scene->tinted) append_rest(&to, FEELER_BAND, filter, RAY_BANDS, VALUES);
#endif
}

// what surfaces on the way have let through of a band: feelers at, at + 1, ... are those of the lanes `launched`, and
// those of `through` have met some
INLINED floatP filtered(__global const float *filter, uint at, uint launched, uint through, int b)
{
    ALIGNED float share[PACKET];
    *(floatP *)share = (floatP)(1.0f);
    for (; launched; launched = without_first(launched), at++)
        if (through & launched & -launched) share[first_lane(launched)] = filter[in_block(at, b, VALUES)];
    return *(floatP *)share;
}

// Adds what comes from the lights that the feelers have reached to `local_radiance`, light after light; SPAWN_LOCAL
// then says that it is to be read. One work-item a chunk of rays.
__kernel void illuminate(WORLD_PARAMETERS, QUEUE_PARAMETERS, HITS_PARAMETERS, SHADED_PARAMETERS, PIXELS_PARAMETERS,
                         FEELERS_PARAMETERS, uint terms)
{
    const uint chunk = get_global_id(0), end = min((chunk + 1) * CHUNK, n);
    if (chunk * CHUNK >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const Pixels pixels = PIXELS_OF_PARAMETERS;
    uint at = first_feeler[chunk];
    for (uint first = chunk * CHUNK; first < end; first += PACKET) {
        const intP found = load_word(spawn, first, n);
        const intP counted = ((found & SPAWN_FEELERS) != 0) & lanes_within(first, n);
        if (!any_of(counted)) continue;
        Surfaces s = load_surfaces(world, surfaces, surface_code, hit_t, weights, first, n);
        const VecP u = load_vec(rays, first, n, DIRECTION_X, RAY_FIELDS), start = start_before(s, u);
        const intP bright = (found & SPAWN_LOCAL) != 0;
        const bool any_bright = any_of(bright);
        floatP value[RAY_BANDS], radiance[RAY_BANDS];
        for (int b = 0; b < RAY_BANDS; b++) {
            value[b] = (floatP)(0.0f);
            if (any_bright) value[b] = select(value[b], load_field(local_radiance, first, n, b, VALUES), bright);
        }
        SHOW_PICTURES(world, s, counted, SHOWN(HIGHLIGHT));
        intP lighter = (intP)(0);
        const Streams streams = light_streams(world, pixels, path, first, n);
        for (int l = 0; l < world.scene->lights; l++) {
            __global const Light *light = world.lights + l;
            Draw draw = light_draw(light, streams, l);
            for (int i = 0; i < light->samples; i++, draw = next_draw(draw)) {
                const LightSample to = light_sample(light, start, draw);
                const uint launched = lanes_of(counted & is_above(s, to));
                if (!launched) continue;
                const intP arrives = load_apart(seen, at, launched);
                const uint through = lanes_of(arrives == FILTERED);
                intP todo = arrives != 0, mine;
                lighter |= todo;
                while (any_of(todo)) {
                    __global const Material *material = next_material(world, &s, &todo, &mine);
                    reflected_light(light, to, s, material, u, terms, radiance);
                    for (int b = 0; b < RAY_BANDS; b++) {
                        floatP brings = load_field(weights, first, n, b, VALUES) * radiance[b];
                        if (through) brings *= filtered(filter, at, launched, through, b);
                        value[b] = select(value[b], value[b] + brings, mine);
                    }
                }
                at += count_lanes(launched);
            }
        }
        if (!any_of(lighter)) continue;
        for (int b = 0; b < RAY_BANDS; b++) store_field(local_radiance, first, n, b, VALUES, value[b]);
        store_word((__global int *)spawn, first, n, found | (lighter & SPAWN_LOCAL));
    }
}
