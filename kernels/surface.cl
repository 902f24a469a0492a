// What every hit of a queue is: point, normals, offset, side, material. Found once and kept, because the passes
// after it then need not know about kinds of primitives, and work on whole packets.
//
// One work-item a ray: the kinds differ too much for vectors.
#include "surface.clh"
#include "texture.clh"

__kernel void surface(WORLD_PARAMETERS, __global const float *rays, __global const float *hit_t,
                      __global const int *hit_primitive, uint n,
                      __global float *surfaces, __global int *surface_code)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const Hit hit = {hit_t[i], hit_primitive[i]};
    Surface s;
    int code = -1;
    if (hit.primitive >= 0) {
        s = surface_at(world, load_ray(rays, i), hit);
        __global const Material *material = world.materials + s.material;
        code = s.material * SURFACE_MATERIAL + (s.inside ? SURFACE_INSIDE : 0);
        if (material->checker != PLAIN && checker_odd(material, s.outward, s.relative)) code += SURFACE_SECOND_COLOR;
    } else {
        s.point = s.n = s.ns = (float3)(0.0f, 0.0f, 0.0f);
        s.offset = 0.0f;
    }
    surface_code[i] = code;
    surfaces[in_block(i, POINT_X, SURFACE_FIELDS)] = s.point.x;
    surfaces[in_block(i, POINT_Y, SURFACE_FIELDS)] = s.point.y;
    surfaces[in_block(i, POINT_Z, SURFACE_FIELDS)] = s.point.z;
    surfaces[in_block(i, NORMAL_X, SURFACE_FIELDS)] = s.n.x;
    surfaces[in_block(i, NORMAL_Y, SURFACE_FIELDS)] = s.n.y;
    surfaces[in_block(i, NORMAL_Z, SURFACE_FIELDS)] = s.n.z;
    surfaces[in_block(i, SHADING_X, SURFACE_FIELDS)] = s.ns.x;
    surfaces[in_block(i, SHADING_Y, SURFACE_FIELDS)] = s.ns.y;
    surfaces[in_block(i, SHADING_Z, SURFACE_FIELDS)] = s.ns.z;
    surfaces[in_block(i, LEAVE_BY, SURFACE_FIELDS)] = s.offset;
}
