// Camera rays: generation 0 (thesis 1.3).
//
// A tile is a list of pixel numbers; ray i is sample i % (grid*grid) of the tile's pixel i / (grid*grid). The ray
// remembers the pixel's place in the tile, not in the picture, so that the film of a tile is dense. With an aperture
// it starts on a lens instead of in the eye, and goes through the point that is in focus (Cook, Porter, Carpenter 1984,
// "Distributed Ray Tracing"). One work-item a packet.
#include "filter.clh"

// pixel numbers at the places; rays with a pixel each have their places in order
inline uintP pixels_at(__global const uint *pixels, uintP place, uint samples, uint first, uint n)
{
    if (samples == 1) return as_uintP(load_word(pixels, first, n));
    uint lane[PACKET];
    *(uintP *)lane = place;
    for (uint k = 0; k < PACKET; k++) lane[k] = pixels[min(lane[k], (n - 1) / samples)];
    return *(uintP *)lane;
}

// Where on the lens the ray of a sample starts, from the lens's middle. A pixel's samples are a sequence that fills the
// lens evenly, shifted by the pixel's hash; its factors are not those of lights, which would tie one to the other.
inline VecP on_lens(const Camera camera, uintP pixel, uintP sample)
{
    const uintP h = combine(combine((uintP)(camera.seed), pixel), (uintP)(0x80000000u));
    floatP x, y;
    disk(unit_interval(mix_bits(h + 1u) + sample * 0x9E3779B9u),
         unit_interval(mix_bits(h + 2u) + sample * 0x6A09E667u), &x, &y);
    return times(add(times(same(camera.right), x), times(same(camera.up), y)), (floatP)(camera.aperture));
}

__kernel void generate(__global const Camera *cameras, __global const uint *pixels, QUEUE_PARAMETERS,
                       __global uint *local_size)
{
    const uint first = get_global_id(0) * PACKET;
    if (first == 0) *local_size = get_local_size(0);
    if (first >= n) return;
    const Camera camera = cameras[0];
    const uint samples = camera.grid * camera.grid;
    const uintP i = counting_from(first), place = divided(i, samples), sample = i - place * samples;
    const uintP pixel = pixels_at(pixels, place, samples, first, n);
    const uintP line = divided(pixel, camera.width), across_line = pixel - line * camera.width;
    const uintP key = combine(combine((uintP)(camera.seed), pixel), sample);

    floatP part_x, part_y;
    in_grid(camera, key, sample, &part_x, &part_y);
    if (camera.filter) {
        part_x = 0.5f + off_middle(camera, part_x);
        part_y = 0.5f + off_middle(camera, part_y);
    }
    const floatP x = convert_floatP(across_line) + camera.shift_x + part_x;
    const floatP y = convert_floatP(line) + camera.shift_y + part_y;
    const floatP across = (2.0f * x / (float)camera.width - 1.0f) * camera.half_width;
    const floatP above = (1.0f - 2.0f * y / (float)camera.height) * camera.half_height;
    const VecP in_view = add(times(same(camera.right), across), times(same(camera.up), above));

    const VecP forward = same(camera.forward);
    VecP origin = same(camera.origin), direction = forward;
    if (camera.aperture > 0.0f) {
        const VecP lens = on_lens(camera, pixel, sample), to_pixel = add(forward, in_view);
        if (camera.orthographic) origin = add(origin, in_view);
        direction = unit3(sub(camera.orthographic ? forward : to_pixel, times(lens, (floatP)(1.0f / camera.focus))));
        const floatP ahead = dot3(direction, forward);
        origin = add(add(origin, lens), times(direction, camera.near / ahead));
    } else if (camera.orthographic) {
        origin = add(add(origin, in_view), times(forward, (floatP)(camera.near)));
    } else {
        direction = unit3(add(forward, in_view));
        origin = add(origin, times(direction, camera.near / dot3(direction, forward)));
    }
    store_vec(rays, first, n, ORIGIN_X, RAY_FIELDS, origin);
    store_vec(rays, first, n, DIRECTION_X, RAY_FIELDS, direction);
    store_field(rays, first, n, T_MAX, RAY_FIELDS, (floatP)(INFINITY));
    // samples that are weighed have places of their own on the film
    store_word((__global int *)pixel_of, first, n, as_intP(camera.filter ? i : place));
    store_word((__global int *)path, first, n, as_intP(key & ~(uint)PATH_FLAGS));
    for (int b = 0; b < RAY_BANDS; b++) store_field(weights, first, n, b, VALUES, (floatP)(1.0f));
#if MIPS
    // as wide as the part of the pixel that is the sample's own, the longer side of it, at any distance
    const float side = larger(2.0f * camera.half_width / (float)camera.width,
                              2.0f * camera.half_height / (float)camera.height) / (float)camera.grid;
    const floatP spread = camera.orthographic ? (floatP)(0.0f) : side * dot3(direction, forward);
    const float width = camera.orthographic ? side : side * camera.near;
    store_field(weights, first, n, CONE_WIDTH, VALUES, (floatP)(width));
    store_field(weights, first, n, CONE_SPREAD, VALUES, spread);
#endif
}

// The same queue from rays that the caller brings: n x 3 origins and directions of any length, n values of t_max.
// `numbers` are the rays' numbers among all that were asked for, so that a ray's key does not depend on which rays
// are traced together.
__kernel void adopt(__global const float *origins, __global const float *directions, __global const float *t_max,
                    __global const uint *numbers, QUEUE_PARAMETERS)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    __global const float *from = origins + 3 * (size_t)i, *way = directions + 3 * (size_t)i;
    const Vec origin = vec(from[0], from[1], from[2]);
    const Vec d = vec(way[0], way[1], way[2]);
    store_ray(rays, i, origin, unit_of_any(d), t_max[i]);
    pixel_of[i] = i;
    path[i] = combine(combine(0u, numbers[i]), 0u) & ~(uint)PATH_FLAGS;
    for (int b = 0; b < RAY_BANDS; b++) weights[in_block(i, b, VALUES)] = 1.0f;
#if MIPS
    weights[in_block(i, CONE_WIDTH, VALUES)] = weights[in_block(i, CONE_SPREAD, VALUES)] = 0.0f;
#endif
}
