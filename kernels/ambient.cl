// Ambient rays: `samples` a parent, from its slot on (thesis 3.2.2: ambient light from a sampling of the
// surroundings). One work-item a parent, since each writes many.
#include "hash.clh"
#include "ray.clh"
#include "math.clh"
#include "media.clh"

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

__kernel void gather_ambient(WORLD_PARAMETERS, __global const float *surfaces, __global const int *surface_code,
                             __global const uint *pixel_of, __global const uint *path,
                             __global const float *weights, __global const int *spawn,
                             __global const uint *slot, __global const int *media, uint n, uint generation,
                             __global float *child_rays, __global uint *child_pixel, __global uint *child_path_of,
                             __global float *child_weight, __global int *child_media)
{
    const uint i = get_global_id(0);
    if (i >= n || !(spawn[i] & SPAWN_AMBIENT)) return;
    const World world = WORLD_OF_PARAMETERS;
    const float3 point = load_vector(surfaces, i, POINT_X, SURFACE_FIELDS);
    const float3 geometric = load_vector(surfaces, i, NORMAL_X, SURFACE_FIELDS);
    const float3 shading = load_vector(surfaces, i, SHADING_X, SURFACE_FIELDS);
    const float3 start = point + geometric * surfaces[in_block(i, LEAVE_BY, SURFACE_FIELDS)];
    __global const Material *material = world.materials + surface_code[i] / SURFACE_MATERIAL;
    const bool second = surface_code[i] & SURFACE_SECOND_COLOR;
    const int band = first_band(weights, i);
    const uint samples = world.scene->ambient_samples;
    const uint key = combine(path[i] & ~(uint)PATH_FLAGS, CHILD_AMBIENT);
    const uint flags = path[i] & PATH_FLAGS | PATH_GATHERED | (generation == 0 ? PATH_GATHERED_FIRST : 0);
    for (uint k = 0; k < samples; k++) {
        const uint child = slot[i] + k;
        float3 direction = cosine_direction(shading, key, k);
        if (!(dot3(direction, geometric) > 0.0f)) direction = cosine_direction(geometric, key, k);
        store_ray(child_rays, child, start, direction, INFINITY);
        child_pixel[child] = pixel_of[i];
        child_path_of[child] = key & ~(uint)PATH_FLAGS | flags;
        for (int b = 0; b < RAY_BANDS; b++)
            child_weight[in_block(child, b, VALUES)] = weights[in_block(i, b, VALUES)]
                * (material->ka * (second ? material->color2 : material->color)[band_at(band, b)]) / (float)samples;
#if NARROW
        child_weight[in_block(child, RAY_BANDS, VALUES)] = as_float(band);
#endif
#if MEDIA
        hand_on_media(world, media, i, surface_code[i], false, child_media, child);
#endif
    }
}
