// What callers ask about rays of their own: the nearest hit, whether there is any, and the surface there. A launch reads
// the caller's arrays and writes the answers, and nothing in between: no queue of rays is made.
#include "asked.clh"

// Hits that do not lie beyond `least` are passed by: their rays look once more, alone. (Few do, where `least` keeps rays
// off the surface that they leave.)
INLINED void pass_by(const World world, const RayP ray, floatP least, bool any, PacketHit *best)
{
    const intP near = any ? least != 0.0f : !(best->t > least);
    uint again = lanes_of((best->primitive >= 0) & near);
    if (!again) return;
    LaneRays rays;
    keep_vec(ray.origin, rays.origin);
    keep_vec(ray.direction, rays.direction);
    ALIGNED float t[PACKET], after[PACKET], most[PACKET];
    ALIGNED int primitive[PACKET];
    *(floatP *)t = best->t;
    *(intP *)primitive = best->primitive;
    *(floatP *)after = least;
    *(floatP *)most = ray.t_max;
    for (; again; again = without_first(again)) {
        const int lane = first_lane(again);
        const Ray one = {of_lane(rays.origin, lane), of_lane(rays.direction, lane), most[lane]};
        const Hit hit = nearest_hit(world, one, after[lane], BEFORE_ALL, any, NO_PRIMITIVE);
        t[lane] = hit.t;
        primitive[lane] = hit.primitive;
    }
    best->t = *(floatP *)t;
    best->primitive = *(intP *)primitive;
}

__kernel void nearest(WORLD_PARAMETERS, ASKED_PARAMETERS, __global float *found_t, __global int *found_primitive)
{
    const uint packet = get_global_id(0);
    if (packet >= (n + PACKET - 1) / PACKET) return;
    const World world = WORLD_OF_PARAMETERS;
    const Asked asked = ASKED_OF_PARAMETERS;
    const Taken taken = taken_by(asked, packet);
    floatP after;
    const RayP ray = load_asked(asked, taken, &after);
    PacketHit hits = packet_hits(world, ray, (intP)(NO_PRIMITIVE), false);
    pass_by(world, ray, after, false, &hits);
    const floatP t = select(hits.t, (floatP)(INFINITY), hits.primitive < 0);
    store_asked(asked, taken, (__global int *)found_t, as_intP(t));
    store_asked(asked, taken, found_primitive, hits.primitive);
}

__kernel void blocked(WORLD_PARAMETERS, ASKED_PARAMETERS, __global uchar *found)
{
    const uint packet = get_global_id(0);
    if (packet >= (n + PACKET - 1) / PACKET) return;
    const World world = WORLD_OF_PARAMETERS;
    const Asked asked = ASKED_OF_PARAMETERS;
    const Taken taken = taken_by(asked, packet);
    floatP after;
    const RayP ray = load_asked(asked, taken, &after);
    PacketHit hits = packet_hits(world, ray, (intP)(NO_PRIMITIVE), true);
    pass_by(world, ray, after, true, &hits);
    ALIGNED int hit[PACKET];
    *(intP *)hit = (hits.primitive >= 0) & 1;
    for (uint k = 0; k < PACKET; k++) {
        const uint i = taken.first + k / PATCH * taken.row + k % PATCH;
        if (i < n) found[i] = (uchar)hit[k];
    }
}

// The surfaces at hits that were found: which shape, the outward unit normal, barycentric weights of a triangle's second
// and third corner. A null pointer is not asked for.
__kernel void met(WORLD_PARAMETERS, ASKED_PARAMETERS, __global const float *found_t,
                  __global const int *found_primitive, __global int *found_shape, __global float *found_normal,
                  __global float *found_u, __global float *found_v)
{
    const uint packet = get_global_id(0);
    if (packet >= (n + PACKET - 1) / PACKET) return;
    const World world = WORLD_OF_PARAMETERS;
    const Asked asked = ASKED_OF_PARAMETERS;
    const Taken taken = taken_by(asked, packet);
    const intP primitive = load_found(asked, taken, found_primitive), hit = primitive >= 0;
    floatP record[4];  // kind, index, shape, material
    gather4(world.primitives, 1, 0, select((intP)(0), primitive, hit), record);
    if (found_shape) store_asked(asked, taken, found_shape, select((intP)(-1), as_intP(record[2]), hit));
    if (!found_normal && !found_u && !found_v) return;
    floatP after;
    const RayP ray = load_asked(asked, taken, &after);
    const floatP t = as_floatP(load_found(asked, taken, (__global const int *)found_t));
    const VecP p = add(ray.origin, times(ray.direction, t));
    const LocalP at = surfaces_met(world, hit, as_intP(record[0]), as_intP(record[1]), ray, p);
    if (found_u) store_asked(asked, taken, (__global int *)found_u, as_intP(at.u));
    if (found_v) store_asked(asked, taken, (__global int *)found_v, as_intP(at.v));
    if (!found_normal) return;
    ALIGNED float lane[3][PACKET];
    keep_vec(at.outward, lane);
    for (uint k = 0; k < PACKET; k++) {
        const uint i = taken.first + k / PATCH * taken.row + k % PATCH;
        if (i < n) for (uint axis = 0; axis < 3; axis++) found_normal[3 * (size_t)i + axis] = lane[axis][k];
    }
}
