// Rays made on the device for the large proofs: aimed at the edges and corners of a closed mesh from inside, and
// leaving surfaces just hit. Numbers come from hashes of (seed, ray), so a find can be repeated.

inline float draw(uint seed, uint ray, uint number) { return unit_interval(combine(combine(seed, ray), number)); }

// A point on an edge of a random triangle, one time in four a corner; from around `center`, within `spread`.
__kernel void aim_at_edges(WORLD_PARAMETERS, uint n, uint many, uint seed, float4 center, float spread,
                           __global float *rays)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const World world = WORLD_OF_PARAMETERS;
    const Triangle t = world.triangles[combine(combine(seed, i), 0u) % many];
    const uint edge = combine(combine(seed, i), 1u) % 3;
    const float3 a = edge == 0 ? t.v0.xyz : edge == 1 ? t.v1.xyz : t.v2.xyz;
    const float3 b = edge == 0 ? t.v1.xyz : edge == 1 ? t.v2.xyz : t.v0.xyz;
    const float along = draw(seed, i, 2u) < 0.25f ? 0.0f : draw(seed, i, 3u);
    const float3 target = a + (b - a) * along;
    const float3 away = (float3)(draw(seed, i, 4u), draw(seed, i, 5u), draw(seed, i, 6u)) * 2.0f - 1.0f;
    const float3 origin = center.xyz + away * spread;
    store_ray(rays, i, origin, unit3(target - origin), INFINITY);
}

// From where each ray of a queue hit, a new ray to the outer or the inner side of the normal; one in two grazing.
// A ray that had missed leaves no direction, which misses.
__kernel void leave_surfaces(__global const float *surfaces, __global const int *surface_code, uint n, uint seed,
                             uint inner, __global float *rays)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const float3 point = load_vector(surfaces, i, POINT_X, SURFACE_FIELDS);
    const float3 facing = load_vector(surfaces, i, NORMAL_X, SURFACE_FIELDS);
    const bool inside = surface_code[i] & SURFACE_INSIDE;
    const float3 n_side = inside == (inner != 0) ? facing : -facing;
    const float3 random = (float3)(draw(seed, i, 0u), draw(seed, i, 1u), draw(seed, i, 2u)) * 2.0f - 1.0f;
    const float3 tangent = unit3(cross3(n_side, random));
    const float lift = draw(seed, i, 3u) < 0.5f ? 1e-3f : 1.0f;
    const float cosine = lift * (0.5f + 0.5f * draw(seed, i, 4u));
    const float3 direction = unit3(n_side * cosine + tangent * sqrt(1.0f - cosine * cosine));
    const float3 start = point + n_side * surfaces[in_block(i, LEAVE_BY, SURFACE_FIELDS)];
    store_ray(rays, i, start, surface_code[i] < 0 ? (float3)(0.0f, 0.0f, 0.0f) : direction, INFINITY);
}
