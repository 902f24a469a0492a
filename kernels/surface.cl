// What every hit of a queue is: point, normals, offset, side, material. Found once and kept, because the passes
// after it then need not know about kinds of primitives. One work-item a packet.
#include "local.clh"

// Surfaces turned to the side the rays came from: those of `surface_at` in surface.clh.
inline void store_surfaces(const World world, const LocalP at, intP hit, intP material, Vec d, uint first, uint n,
                           __global float *surfaces, __global int *surface_code)
{
    const intP inside = dotP(at.outward, d) > 0.0f;
    const Vec geometric = choose(at.outward, minus(at.outward), inside);
    Vec shading = choose(at.smooth, minus(at.smooth), dotP(at.smooth, geometric) < 0.0f);
    shading = choose(geometric, shading, dotP(shading, d) < 0.0f);
    intP code = material * SURFACE_MATERIAL + (inside & SURFACE_INSIDE);
    intP todo = hit;
    while (any_of(todo)) {
        const int number = first_value(material, todo);
        const intP mine = todo & (material == number);
        todo &= ~mine;
        if (world.materials[number].checker != PLAIN)
            code += checker_oddP(world.materials + number, mine, at.outward, sub(at.point, at.center))
                    & mine & SURFACE_SECOND_COLOR;
    }
    store_word(surface_code, first, n, select((intP)(-1), code, hit));
    store_vec(surfaces, first, n, POINT_X, SURFACE_FIELDS, at.point);
    store_vec(surfaces, first, n, NORMAL_X, SURFACE_FIELDS, choose(zero(), geometric, hit));
    store_vec(surfaces, first, n, SHADING_X, SURFACE_FIELDS, choose(zero(), shading, hit));
    store_field(surfaces, first, n, LEAVE_BY, SURFACE_FIELDS, at.offset);
}

__kernel void surface(WORLD_PARAMETERS, __global const float *rays, __global const float *hit_t,
                      __global const int *hit_primitive, uint n,
                      __global float *surfaces, __global int *surface_code)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const intP primitive = load_word(hit_primitive, first, n), hit = primitive >= 0;
    const Vec origin = load_vec(rays, first, n, ORIGIN_X, RAY_FIELDS);
    const Vec d = load_vec(rays, first, n, DIRECTION_X, RAY_FIELDS);
    LocalP at = {zero(), zero(), zero(), zero(), (floatP)(0.0f)};
    intP material = (intP)(0);
    if (any_of(hit)) {
        floatP record[4];  // kind, index, shape, material
        gather4(world.primitives, 1, 0, select((intP)(0), primitive, hit), record);
        const Vec p = add(origin, times(d, load_numbers(hit_t, first, n)));
        at = surfaces_met(world, hit, as_intP(record[0]), as_intP(record[1]), origin, d, p);
        material = as_intP(record[3]);
    }
    store_surfaces(world, at, hit, material, d, first, n, surfaces, surface_code);
}
