// Camera rays: generation 0 (thesis 1.3).
//
// A tile is a list of pixel numbers; ray i is sample i % (grid*grid) of the tile's pixel i / (grid*grid). The ray
// remembers the pixel's place in the tile, not in the picture, so that the film of a tile is dense.
#include "math.clh"
#include "hash.clh"
#include "ray.clh"

__kernel void generate(__global const Camera *cameras, __global const uint *pixels, uint n,
                       __global float *rays, __global uint *pixel_of, __global uint *path,
                       __global float *weight, __global uint *local_size)
{
    const uint i = get_global_id(0);
    if (i == 0) *local_size = get_local_size(0);
    if (i >= n) return;
    const Camera camera = cameras[0];
    const uint samples = camera.grid * camera.grid;
    const uint place = i / samples, sample = i % samples;
    const uint pixel = pixels[place];
    const uint key = combine(combine(camera.seed, pixel), sample);

    float sub_x = 0.5f, sub_y = 0.5f;
    if (camera.jitter) {
        sub_x = unit_interval(mix_bits(key + 1u));
        sub_y = unit_interval(mix_bits(key + 2u));
    }
    const float grid = (float)camera.grid;
    const float x = (float)(pixel % camera.width) + camera.shift_x + ((float)(sample % camera.grid) + sub_x) / grid;
    const float y = (float)(pixel / camera.width) + camera.shift_y + ((float)(sample / camera.grid) + sub_y) / grid;
    const float across = (2.0f * x / (float)camera.width - 1.0f) * camera.half_width;
    const float above = (1.0f - 2.0f * y / (float)camera.height) * camera.half_height;
    const float3 in_view = camera.right.xyz * across + camera.up.xyz * above;

    float3 origin = camera.origin.xyz, direction = camera.forward.xyz;
    if (camera.orthographic) {
        origin = origin + in_view + direction * camera.near;
    } else {
        direction = unit3(direction + in_view);
        origin = origin + direction * (camera.near / dot3(direction, camera.forward.xyz));
    }
    store_ray(rays, i, origin, direction, INFINITY);
    pixel_of[i] = place;
    path[i] = key & ~(uint)PATH_FLAGS;
    for (int b = 0; b < RAY_BANDS; b++) weight[in_block(i, b, VALUES)] = 1.0f;
}

// The same queue from rays that the caller brings: n x 3 origins and directions of any length, n values of t_max.
// `numbers` are the rays' numbers among all that were asked for, so that a ray's key does not depend on which rays
// are traced together.
__kernel void adopt(__global const float *origins, __global const float *directions, __global const float *t_max,
                    __global const uint *numbers, uint n, __global float *rays, __global uint *pixel_of, __global uint *path,
                    __global float *weight)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const float3 origin = (float3)(origins[3 * i], origins[3 * i + 1], origins[3 * i + 2]);
    const float3 d = (float3)(directions[3 * i], directions[3 * i + 1], directions[3 * i + 2]);
    store_ray(rays, i, origin, unit3(d), t_max[i]);
    pixel_of[i] = i;
    path[i] = combine(combine(0u, numbers[i]), 0u) & ~(uint)PATH_FLAGS;
    for (int b = 0; b < RAY_BANDS; b++) weight[in_block(i, b, VALUES)] = 1.0f;
}
