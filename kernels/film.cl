// The film of a tile: sums of what rays bring to their pixels.
//
// A pixel's rays stand together in a queue. The work-item of the chunk that has the first of them adds them all up, in
// order, and then adds the sum to the film: one writer a pixel, no atomics, one result. Layers are further planes of the
// film, for which only rays whose path word matches are added.
#include "lanes.clh"

// Sums of a ray's bands. Those of all bands are kept in parts of four, as the film's are added: what was written one by
// one is not yet there for who reads four, and one by one 64 bands take twice as long.
#if NARROW
#define FOURS 0
#else
#define FOURS (BANDS / 4)
#endif

__kernel void gather(QUEUE_PARAMETERS, SHADED_PARAMETERS, uint path_mask, uint path_value, uint plane, uint pixels,
                     __global float *film)
{
    uint i = get_global_id(0) * CHUNK;
    const uint end = min(i + CHUNK, n);
    while (i > 0 && i < end && pixel_of[i] == pixel_of[i - 1]) i++;
    while (i < end) {
        const uint pixel = pixel_of[i];
        float4 four[FOURS + 1];
        float sum[BANDS];
        for (int p = 0; p < FOURS; p++) four[p] = (float4)(0.0f);
        for (int b = 4 * FOURS; b < BANDS; b++) sum[b] = 0.0f;
        bool found = false;
        for (; i < n && pixel_of[i] == pixel; i++) {
            if (path_mask && (path[i] & path_mask) != path_value) continue;
            if (!(spawn[i] & SPAWN_LOCAL)) continue;
            found = true;
            __global const float *brought = local_radiance + in_block(i, 0, VALUES);
            const int band = first_band(local_radiance, i);
            for (int p = 0; p < FOURS; p++) {
                __global const float *at = brought + 4 * p * LANES;
                four[p] += (float4)(at[0], at[LANES], at[2 * LANES], at[3 * LANES]);
            }
            ONE_BY_ONE
            for (int b = 4 * FOURS; b < RAY_BANDS && band + b < BANDS; b++) sum[band + b] += brought[b * LANES];
        }
        if (!found) continue;
        __global float *into = film + ((size_t)plane * pixels + pixel) * BANDS;
        for (int p = 0; p < FOURS; p++) vstore4(vload4(p, into) + four[p], p, into);
#if !NARROW
        ONE_BY_ONE
#endif
        for (int b = 4 * FOURS; b < BANDS; b++) into[b] += sum[b];
    }
}

// Means from sums. Light that overflowed on its way (infinite, or NaN where that met a 0) counts as the brightest
// that a pixel holds; radiance is never negative, so nothing else can be meant.
__kernel void resolve(uint n, float samples, __global float *film)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const float mean = film[i] / samples;
    film[i] = mean <= BRIGHTEST ? mean : BRIGHTEST;
}

// Each pixel's means of BANDS bands to `rows` numbers, such as red, green and blue: one row of the matrix after the
// other, its bands added up from the first on. One work-item a packet of pixels.
__kernel void develop(__global const float *film, uint n, __global const float *matrix, uint rows,
                      __global float *developed)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    floatP mean[BANDS];
    float *means = (float *)mean, lane[PACKET];
    for (uint k = 0; k < PACKET; k++)
        for (int b = 0; b < BANDS; b++) means[b * PACKET + k] = film[(size_t)min(first + k, n - 1) * BANDS + b];
    for (uint row = 0; row < rows; row++) {
        floatP sum = matrix[row * BANDS] * mean[0];
        for (int b = 1; b < BANDS; b++) sum += matrix[row * BANDS + b] * mean[b];
        *(floatP *)lane = sum;
        for (uint k = 0; k < PACKET && first + k < n; k++) developed[(size_t)(first + k) * rows + row] = lane[k];
    }
}

inline void put3(__global float *out, uint i, Vec v)
{
    out[3 * (size_t)i] = v.x;
    out[3 * (size_t)i + 1] = v.y;
    out[3 * (size_t)i + 2] = v.z;
}

// What is known of where the first of every `samples` rays hit: the layers of geometry (layers.GEOMETRY). On a miss
// `at` is 0.
__kernel void geometry(WORLD_PARAMETERS, QUEUE_PARAMETERS, HITS_PARAMETERS, __global const Camera *cameras,
                       uint samples, GEOMETRY_PARAMETERS)
{
    const uint i = get_global_id(0);
    if (i >= n / samples) return;
    const World world = WORLD_OF_PARAMETERS;
    const uint number = i * samples;
    const int primitive = hit_primitive[number], hit = primitive >= 0;
    const Ray ray = load_ray(rays, number);
    int material;
    const Local at = surface_at(world, ray, hit, primitive, hit_t[number], &material);
    const Camera camera = cameras[0];
    const Vec from_eye = sub(at.point, vec(camera.origin.x, camera.origin.y, camera.origin.z));
    const float along = dot3(from_eye, vec(camera.forward.x, camera.forward.y, camera.forward.z));
    const float away = camera.orthographic ? along : sqrt(dot3(from_eye, from_eye));
    out_depth[i] = hit ? hit_t[number] : INFINITY;
    out_z[i] = hit ? along : INFINITY;
    out_distance[i] = hit ? away : INFINITY;
    put3(out_position, i, at.point);
    put3(out_normal, i, at.outward);
    put3(out_shading_normal, i, load_vector(surfaces, number, SHADING_X, SURFACE_FIELDS));
    __global const Material *of = world.materials + (hit ? material : 0);
    const int second = surface_code[number] & SURFACE_SECOND_COLOR;
    float u = 0.0f, v = 0.0f;
#if IMAGES
    u = surfaces[in_block(number, TEXTURE_U, SURFACE_FIELDS)];
    v = surfaces[in_block(number, TEXTURE_V, SURFACE_FIELDS)];
    const int texture = hit && !second ? world.pictured[material].color : -1;
    float rgb[3];
    if (texture >= 0)
        PICTURE_AT(world.texels, world.textures + texture, u, v, surfaces[in_block(number, REACH_U, SURFACE_FIELDS)],
                   surfaces[in_block(number, REACH_V, SURFACE_FIELDS)], 1, rgb);
#endif
    out_uv[2 * (size_t)i] = u == u ? u : 0.0f;
    out_uv[2 * (size_t)i + 1] = v == v ? v : 0.0f;
    for (int b = 0; b < BANDS; b++) {
        float color = second ? of->color2[b] : of->color[b];
#if IMAGES
        if (texture >= 0) color = reflected_by(world.primaries, rgb, b);
#endif
        out_albedo[BANDS * (size_t)i + b] = hit ? of->kd * color : 0.0f;
    }
    out_shape[i] = hit ? world.primitives[primitive].shape : -1;
    out_material[i] = hit ? material : -1;
}
