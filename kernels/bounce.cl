// The next generation: reflection rays, transmission rays and ambient rays, one pass and one queue each.
//
// `slot` is each parent's place in the queue of children; it was counted before, so a queue is exactly as long
// as what is written to it, and the children of a pixel stand together in the order of their parents.
#include "hash.clh"
#include "surface.clh"
#include "texture.clh"
#include "bounce.clh"

inline uint route_or(uint flags, uint route) { return flags & PATH_ROUTE ? flags : flags | route; }

__kernel void reflect(WORLD_PARAMETERS, __global const float *rays, __global const float *hit_t,
                      __global const int *hit_primitive, __global const uint *pixel_of,
                      __global const uint *path, __global const float *weight,
                      __global const uint *spawn, __global const uint *slot, uint n,
                      __global float *child_rays, __global uint *child_pixel, __global uint *child_path_of,
                      __global float *child_weight)
{
    const uint i = get_global_id(0);
    if (i >= n || !(spawn[i] & SPAWN_REFLECTION)) return;
    const World world = WORLD_OF_PARAMETERS;
    const Ray ray = load_ray(rays, i);
    const Hit hit = {hit_t[i], hit_primitive[i]};
    const Surface s = surface_at(world, ray, hit);
    const Bounce bounce = bounce_at(world, s, world.materials[s.material], ray.direction);
    const uint child = slot[i];
    store_ray(child_rays, child, leave(s, s.n), bounce.reflected, INFINITY);
    child_pixel[child] = pixel_of[i];
    child_path_of[child] = child_path(path[i], CHILD_REFLECTION, route_or(path[i] & PATH_FLAGS, 1u));
    for (int b = 0; b < BANDS; b++)
        child_weight[in_block(child, b, BANDS)] = weight[in_block(i, b, BANDS)] * bounce.reflect[b];
}

__kernel void transmit(WORLD_PARAMETERS, __global const float *rays, __global const float *hit_t,
                       __global const int *hit_primitive, __global const uint *pixel_of,
                       __global const uint *path, __global const float *weight,
                       __global const uint *spawn, __global const uint *slot, uint n,
                       __global float *child_rays, __global uint *child_pixel, __global uint *child_path_of,
                       __global float *child_weight)
{
    const uint i = get_global_id(0);
    if (i >= n || !(spawn[i] & SPAWN_TRANSMISSION)) return;
    const World world = WORLD_OF_PARAMETERS;
    const Ray ray = load_ray(rays, i);
    const Hit hit = {hit_t[i], hit_primitive[i]};
    const Surface s = surface_at(world, ray, hit);
    const Bounce bounce = bounce_at(world, s, world.materials[s.material], ray.direction);
    const uint child = slot[i];
    store_ray(child_rays, child, leave(s, -s.n), bounce.transmitted, INFINITY);
    child_pixel[child] = pixel_of[i];
    child_path_of[child] = child_path(path[i], CHILD_TRANSMISSION, route_or(path[i] & PATH_FLAGS, 2u));
    for (int b = 0; b < BANDS; b++)
        child_weight[in_block(child, b, BANDS)] = weight[in_block(i, b, BANDS)] * bounce.transmit[b];
}

// Direction `index` of a cosine-distributed set about n: the R2 sequence (Roberts 2018) shifted by a hash, on the
// disk by the concentric map (Shirley and Chiu 1997), in the frame of Duff et al. 2017.
inline float3 cosine_direction(float3 n, uint key, uint index)
{
    const float x = 2.0f * unit_interval(mix_bits(key + 1u) + index * 0xC13FA9A9u) - 1.0f;
    const float y = 2.0f * unit_interval(mix_bits(key + 2u) + index * 0x91E10DA5u) - 1.0f;
    float2 disk = (float2)(0.0f, 0.0f);
    if (fabs(x) > fabs(y)) {
        const float2 angle = sine_cosine(0.785398163f * (y / x));
        disk = (float2)(x * angle.y, x * angle.x);
    } else if (y != 0.0f) {
        const float2 angle = sine_cosine(0.785398163f * (x / y));
        disk = (float2)(y * angle.x, y * angle.y);
    }
    const float sign = n.z < 0.0f ? -1.0f : 1.0f;
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    const float3 tangent = (float3)(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    const float3 bitangent = (float3)(b, sign + n.y * n.y * a, -n.y);
    const float height = sqrt(larger(1.0f - disk.x * disk.x - disk.y * disk.y, 0.0f));
    return unit3(tangent * disk.x + bitangent * disk.y + n * height);
}

// `samples` rays a parent, from its slot on (thesis 3.2.2: ambient light from a sampling of the surroundings)
__kernel void gather_ambient(WORLD_PARAMETERS, __global const float *rays, __global const float *hit_t,
                             __global const int *hit_primitive, __global const uint *pixel_of,
                             __global const uint *path, __global const float *weight,
                             __global const uint *spawn, __global const uint *slot, uint n, uint generation,
                             __global float *child_rays, __global uint *child_pixel, __global uint *child_path_of,
                             __global float *child_weight)
{
    const uint i = get_global_id(0);
    if (i >= n || !(spawn[i] & SPAWN_AMBIENT)) return;
    const World world = WORLD_OF_PARAMETERS;
    const Ray ray = load_ray(rays, i);
    const Hit hit = {hit_t[i], hit_primitive[i]};
    const Surface s = surface_at(world, ray, hit);
    const Material material = world.materials[s.material];
    const bool second = material.checker != PLAIN && checker_odd(material, s.outward, s.relative);
    const uint samples = world.scene->ambient_samples;
    const uint key = combine(path[i] & ~(uint)PATH_FLAGS, CHILD_AMBIENT);
    const uint flags = path[i] & PATH_FLAGS | PATH_GATHERED | (generation == 0 ? PATH_GATHERED_FIRST : 0);
    for (uint k = 0; k < samples; k++) {
        const uint child = slot[i] + k;
        float3 direction = cosine_direction(s.ns, key, k);
        if (!(dot3(direction, s.n) > 0.0f)) direction = cosine_direction(s.n, key, k);
        store_ray(child_rays, child, leave(s, s.n), direction, INFINITY);
        child_pixel[child] = pixel_of[i];
        child_path_of[child] = key & ~(uint)PATH_FLAGS | flags;
        for (int b = 0; b < BANDS; b++)
            child_weight[in_block(child, b, BANDS)] = weight[in_block(i, b, BANDS)]
                * (material.ka * surface_color(material, second, b)) / (float)samples;
    }
}
