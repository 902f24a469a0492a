// Ambient rays: `samples` a parent, from its slot on (thesis 3.2.2: ambient light from a sampling of the
// surroundings). One work-item a parent, since each writes many.
#include "children.clh"

// Direction `index` of a cosine-distributed set about n: the R2 sequence (Roberts 2018) shifted by a hash, on the
// disk, in the frame of Duff et al. 2017.
inline Vec cosine_direction(Vec n, uint key, uint index)
{
    float disk_x, disk_y;
    disk(unit_interval(mix_bits(key + 1u) + index * 0xC13FA9A9u),
         unit_interval(mix_bits(key + 2u) + index * 0x91E10DA5u), &disk_x, &disk_y);
    const float sign = n.z < 0.0f ? -1.0f : 1.0f;
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    const Vec tangent = vec(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    const Vec bitangent = vec(b, sign + n.y * n.y * a, -n.y);
    const float height = sqrt(larger(1.0f - disk_x * disk_x - disk_y * disk_y, 0.0f));
    return unit3(add(add(times(tangent, disk_x), times(bitangent, disk_y)), times(n, height)));
}

__kernel void gather_ambient(SPAWN_PARAMETERS)
{
    const uint i = get_global_id(0);
    if (i >= n || !(spawn[i] & SPAWN_AMBIENT)) return;
    const World world = WORLD_OF_PARAMETERS;
    const Family family = FAMILY_OF_PARAMETERS;
    const Vec point = load_vector(surfaces, i, POINT_X, SURFACE_FIELDS);
    const Vec geometric = load_vector(surfaces, i, NORMAL_X, SURFACE_FIELDS);
    const Vec shading = load_vector(surfaces, i, SHADING_X, SURFACE_FIELDS);
    const Vec u = load_vector(rays, i, DIRECTION_X, RAY_FIELDS);
    const float offset = surfaces[in_block(i, LEAVE_BY, SURFACE_FIELDS)];
    const Vec back = times(u, starts_back(offset, surface_code[i], hit_t[i]));
    const Vec start = sub(add(point, times(geometric, offset)), back);
    __global const Material *material = world.materials + surface_code[i] / SURFACE_MATERIAL;
    const bool second = surface_code[i] & SURFACE_SECOND_COLOR;
    const int band = first_band(weights, i);
#if IMAGES
    const int texture = second ? -1 : world.pictured[surface_code[i] / SURFACE_MATERIAL].color;
    float rgb[3];
    for (int c = 0; c < 3; c++) rgb[c] = surfaces[in_block(i, TEXEL_R + c, SURFACE_FIELDS)];
#endif
    const uint samples = world.scene->ambient_samples;
    const uint key = combine(path[i] & ~(uint)PATH_FLAGS, CHILD_AMBIENT);
    const uint flags = path[i] & PATH_FLAGS | PATH_GATHERED | (generation == 0 ? PATH_GATHERED_FIRST : 0);
    for (uint k = 0; k < samples; k++) {
        const uint child = slot[i] + k;
        Vec direction = cosine_direction(shading, key, k);
        if (!(dot3(direction, geometric) > 0.0f)) direction = cosine_direction(geometric, key, k);
        store_child(world, family, i, child, CHILD_AMBIENT, flags, start, direction);
        family.child.child_path[child] = (combine(key, k) & ~(uint)PATH_FLAGS) | flags;
        for (int b = 0; b < RAY_BANDS; b++) {
            float color = (second ? material->color2 : material->color)[band_at(band, b)];
#if IMAGES
            if (texture >= 0) color = reflected_by(world.primaries, rgb, band_at(band, b));
#endif
            child_weights[in_block(child, b, VALUES)] = weights[in_block(i, b, VALUES)] * (material->ka * color)
                                                      / (float)samples;
        }
#if NARROW
        child_weights[in_block(child, RAY_BANDS, VALUES)] = as_float(band);
#endif
        hand_on_cone(family, i, child, VALUES);
    }
}
