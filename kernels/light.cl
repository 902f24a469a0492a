// Local light: what a ray's hit sends back by itself, the shadow feelers that will decide about the lights, and
// the count of everything the hit will spawn.
//
// Two passes, because queues are dense and in stable order: `light` counts, a scan gives every ray its places,
// `feelers` writes. Both look at the surface anew: recomputing it costs less than moving it through memory.
#include "surface.clh"
#include "texture.clh"
#include "bounce.clh"
#include "light.clh"

inline uint count_feelers(const World world, const Surface s, const Material material)
{
    if (!(material.kd > 0.0f || material.ks > 0.0f)) return 0;
    uint count = 0;
    for (int l = 0; l < world.scene->lights; l++)
        count += lit(s, towards(world.lights[l], leave(s, s.n)));
    return count;
}

// `local` receives weight * (emission + ambient), or the background; `spawn` the packed counts (layout.SPAWN).
// In the last generation nothing is spawned: `depth_color` stands for it.
__kernel void light(WORLD_PARAMETERS, __global const float *rays, __global const float *hit_t,
                    __global const int *hit_primitive, __global const uint *path, __global const float *weight,
                    uint n, uint ambient_queue, uint last, uint terms,
                    __global float *local_radiance, __global uint *spawn)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const Ray ray = load_ray(rays, i);
    const Hit hit = {hit_t[i], hit_primitive[i]};
    const bool gathered = path[i] & PATH_GATHERED;
    float radiance[BANDS];

    if (hit.primitive < 0) {
        // an ambient ray that meets nothing brings the constant ambient light
        background_of(world, ray.direction, radiance);
        for (int b = 0; b < BANDS; b++) {
            const float value = ambient_queue ? world.scene->ambient[b] : radiance[b];
            local_radiance[in_block(i, b, BANDS)] = terms == TERM_ALL ? weight[in_block(i, b, BANDS)] * value : 0.0f;
        }
        spawn[i] = 0;
        return;
    }

    const Surface s = surface_at(world, ray, hit);
    const Material material = world.materials[s.material];
    const bool second = material.checker != PLAIN && checker_odd(material, s.outward, s.relative);
    const Bounce bounce = bounce_at(world, s, material, ray.direction);
    const bool reflects = world.scene->spd ? material.kr > 0.0f || material.kt > 0.0f
                                           : worth_tracing(world, weight, i, bounce.reflect);
    const bool transmits = worth_tracing(world, weight, i, bounce.transmit);
    bool gathers = world.scene->ambient_samples > 0 && !gathered && !last && terms & TERM_AMBIENT;
    uint found = SPAWN_HIT;

    float most_ambient = 0.0f;
    for (int b = 0; b < BANDS; b++)
        most_ambient = larger(weight[in_block(i, b, BANDS)] * (material.ka * surface_color(material, second, b)),
                              most_ambient);
    gathers = gathers && most_ambient > 0.0f;

    for (int b = 0; b < BANDS; b++) {
        const float w = weight[in_block(i, b, BANDS)];
        const float emission = terms & TERM_EMISSION ? material.emission[b] : 0.0f;
        const float ambient = terms & TERM_AMBIENT && !gathers
            ? material.ka * surface_color(material, second, b) * world.scene->ambient[b] : 0.0f;
        float value = w * (emission + ambient);
        if (last && terms == TERM_ALL) {
            if (reflects) value += w * bounce.reflect[b] * world.scene->depth_color[b];
            if (transmits) value += w * bounce.transmit[b] * world.scene->depth_color[b];
        }
        local_radiance[in_block(i, b, BANDS)] = value;
    }
    if (terms & (TERM_DIFFUSE | TERM_HIGHLIGHT)) found |= count_feelers(world, s, material);
    if (!last && terms == TERM_ALL) {
        if (reflects) found |= SPAWN_REFLECTION;
        if (transmits) found |= SPAWN_TRANSMISSION;
        if (bounce.total_internal) found |= SPAWN_TOTAL_INTERNAL;
    }
    if (gathers) found |= SPAWN_AMBIENT;
    spawn[i] = found;
}

// One ray to each light above the surface, with what it would bring to the pixel if nothing is in between.
// `first` is each ray's first place in the queue of feelers.
__kernel void feelers(WORLD_PARAMETERS, __global const float *rays, __global const float *hit_t,
                      __global const int *hit_primitive, __global const float *weight,
                      __global const uint *spawn, __global const uint *first, uint n, uint terms,
                      __global float *feeler_rays, __global float *contribution)
{
    const uint i = get_global_id(0);
    if (i >= n || (spawn[i] & SPAWN_FEELERS) == 0) return;
    const World world = WORLD_OF_PARAMETERS;
    const Ray ray = load_ray(rays, i);
    const Hit hit = {hit_t[i], hit_primitive[i]};
    const Surface s = surface_at(world, ray, hit);
    const Material material = world.materials[s.material];
    const bool second = material.checker != PLAIN && checker_odd(material, s.outward, s.relative);
    const float3 start = leave(s, s.n);
    uint place = first[i];
    for (int l = 0; l < world.scene->lights; l++) {
        const Light light = world.lights[l];
        const Towards to = towards(light, start);
        if (!lit(s, to)) continue;
        float radiance[BANDS];
        reflected_light(light, to, s, material, second, ray.direction, terms, radiance);
        store_ray(feeler_rays, place, start, to.direction, to.distance);
        for (int b = 0; b < BANDS; b++)
            contribution[in_block(place, b, BANDS)] = weight[in_block(i, b, BANDS)] * radiance[b];
        place++;
    }
}
