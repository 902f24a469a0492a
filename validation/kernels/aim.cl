// Rays made on the device for the large proofs: aimed at the edges and corners of closed meshes from inside, and
// leaving surfaces just hit. Numbers come from hashes of (seed, ray), so a find can be repeated.

inline float draw(uint seed, uint ray, uint number) { return unit_interval(combine(combine(seed, ray), number)); }

// numbers from -1 to 1
inline Vec either_way(uint seed, uint ray, uint number)
{
    return vec(draw(seed, ray, number) * 2.0f - 1.0f, draw(seed, ray, number + 1u) * 2.0f - 1.0f,
               draw(seed, ray, number + 2u) * 2.0f - 1.0f);
}

// A point on an edge of a random triangle, one time in four a corner; from around `center`, within `spread`.
__kernel void aim_at_edges(WORLD_PARAMETERS, uint n, uint many, uint seed, float4 center, float spread,
                           __global float *rays)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const Triangle t = world.triangles[combine(combine(seed, i), 0u) % many];
    const uint edge = combine(combine(seed, i), 1u) % 3;
    const Vec v0 = vec(t.v0.x, t.v0.y, t.v0.z), v1 = vec(t.v1.x, t.v1.y, t.v1.z), v2 = vec(t.v2.x, t.v2.y, t.v2.z);
    const Vec a = edge == 0 ? v0 : edge == 1 ? v1 : v2;
    const Vec b = edge == 0 ? v1 : edge == 1 ? v2 : v0;
    const float along = draw(seed, i, 2u) < 0.25f ? 0.0f : draw(seed, i, 3u);
    const Vec target = add(a, times(sub(b, a), along));
    const Vec away = either_way(seed, i, 4u);
    const Vec origin = add(vec(center.x, center.y, center.z), times(away, spread));
    store_ray(rays, i, origin, unit3(sub(target, origin)), INFINITY);
}

// The same on a lattice, an eighth of `size`: a point on an edge of a random polygon, one time in four a corner.
__kernel void aim_at_sides(WORLD_PARAMETERS, uint n, uint many, uint seed, float4 center, float size,
                           __global float *rays)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const Polygon p = world.polygons[combine(combine(seed, i), 0u) % many];
    const uint edge = combine(combine(seed, i), 1u) % (uint)(p.count);
    const float4 a = world.vertices[p.first + edge], b = world.vertices[p.first + (edge + 1u) % (uint)(p.count)];
    const float along = draw(seed, i, 2u) < 0.25f ? 0.0f : floor(draw(seed, i, 3u) * 8.0f) * 0.125f;
    const Vec target = add(vec(a.x, a.y, a.z), times(vec(b.x - a.x, b.y - a.y, b.z - a.z), along));
    const Vec away = times(either_way(seed, i, 4u), 6.0f);
    const Vec origin = add(vec(center.x, center.y, center.z),
                           times(vec(floor(away.x), floor(away.y), floor(away.z)), size * 0.125f));
    store_ray(rays, i, origin, unit3(sub(target, origin)), INFINITY);
}

// From where each ray of a queue hit, a new ray to the outer or the inner side of the normal; one in two grazing.
// A ray that had missed leaves no direction, which misses.
__kernel void leave_surfaces(__global const float *surfaces, __global const int *surface_code, uint n, uint seed,
                             uint inner, __global float *rays)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const Vec point = load_vector(surfaces, i, POINT_X, SURFACE_FIELDS);
    const Vec facing = load_vector(surfaces, i, NORMAL_X, SURFACE_FIELDS);
    const bool inside = surface_code[i] & SURFACE_INSIDE;
    const Vec n_side = inside == (inner != 0) ? facing : minus(facing);
    const Vec tangent = unit3(cross3(n_side, either_way(seed, i, 0u)));
    const float lift = draw(seed, i, 3u) < 0.5f ? 1e-3f : 1.0f;
    const float cosine = lift * (0.5f + 0.5f * draw(seed, i, 4u));
    const Vec direction = unit3(add(times(n_side, cosine), times(tangent, sqrt(1.0f - cosine * cosine))));
    const Vec start = add(point, times(n_side, surfaces[in_block(i, LEAVE_BY, SURFACE_FIELDS)]));
    store_ray(rays, i, start, surface_code[i] < 0 ? vec(0.0f, 0.0f, 0.0f) : direction, INFINITY);
}
