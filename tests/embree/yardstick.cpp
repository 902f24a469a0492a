// Embree as a yardstick: the same triangles or spheres, the same rays, one thread, its single-ray call and its calls
// for packets of 8 and 16. A plain C interface, loaded from Python (clrt/bench/embree.py).
//
//   g++ -O3 -march=native -shared -fPIC yardstick.cpp -o yardstick.so -lembree3        (Debian: libembree-dev)
//   g++ -DEMBREE4 ... yardstick.cpp -o yardstick4.so embreex.libs/libembree4-*.so.4    (PyPI: embreex)
//
// Denormals are flushed while Embree works, as its manual advises, and left alone afterwards.
#ifdef EMBREE4
#include "embree4.h"
#else
#include <embree3/rtcore.h>
#endif
#include <immintrin.h>

#include <chrono>
#include <cstring>

namespace {

#ifdef EMBREE4  // what the context was went to the arguments, which are last
using Context = RTCArguments;
template <typename Call, typename Query>
void ask(Call call, RTCScene scene, Context *context, Query *query) { call(scene, query, context); }
template <typename Call, typename Query>
void ask(Call call, const int *valid, RTCScene scene, Context *context, Query *query)
{
    call(valid, scene, query, context);
}
Context context_of(int coherent)
{
    const int flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    return {flags, ~0u, nullptr, nullptr, nullptr, 0.0f};
}
#else
using Context = RTCIntersectContext;
template <typename Call, typename Query>
void ask(Call call, RTCScene scene, Context *context, Query *query) { call(scene, context, query); }
template <typename Call, typename Query>
void ask(Call call, const int *valid, RTCScene scene, Context *context, Query *query)
{
    call(valid, scene, context, query);
}
Context context_of(int coherent)
{
    Context context;
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return context;
}
#endif

struct Yardstick {
    RTCDevice device;
    RTCScene scene;
    double commit_seconds;
};

struct Flushed {
    unsigned before = _mm_getcsr();
    Flushed() { _mm_setcsr(before | 0x8040); }
    ~Flushed() { _mm_setcsr(before); }
};

// One array a field, so that a packet's rays lie side by side.
struct Rays {
    const float *origin[3], *direction[3], *t_max;
};

Yardstick *commit(RTCDevice device, RTCGeometry geometry, bool robust)
{
    Flushed flushed;
    RTCScene scene = rtcNewScene(device);
    if (robust) rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    const auto start = std::chrono::steady_clock::now();
    rtcCommitScene(scene);
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    return new Yardstick{device, scene, spent.count()};
}

// Rays first, first + 1 ... into the lanes of a packet; all W of them in copies of constant size, which cost nothing.
template <int W, typename Ray>
void load(Ray &to, const Rays &from, int first, int width)
{
    const auto lanes = [=](float *lane, const float *field) {
        if (width == W) memcpy(lane, field + first, 4 * W);
        else memcpy(lane, field + first, 4 * width);
    };
    lanes((float *)&to.org_x, from.origin[0]);
    lanes((float *)&to.org_y, from.origin[1]);
    lanes((float *)&to.org_z, from.origin[2]);
    lanes((float *)&to.dir_x, from.direction[0]);
    lanes((float *)&to.dir_y, from.direction[1]);
    lanes((float *)&to.dir_z, from.direction[2]);
    lanes((float *)&to.tfar, from.t_max);
    memset(&to.tnear, 0, 4 * W);
    memset(&to.time, 0, 4 * W);
    memset(&to.mask, 255, 4 * W);
    memset(&to.flags, 0, 4 * W);
}

template <int W>
void store(void *to, const void *from, int width)
{
    if (width == W) memcpy(to, from, 4 * W);
    else memcpy(to, from, 4 * width);
}

void closest1(RTCScene scene, Context *context, const Rays &rays, int n, float *t, int *id)
{
    for (int i = 0; i < n; i++) {
        RTCRayHit query;
        load<1>(query.ray, rays, i, 1);
        query.hit.geomID = query.hit.primID = RTC_INVALID_GEOMETRY_ID;
        ask(rtcIntersect1, scene, context, &query);
        t[i] = query.ray.tfar;
        id[i] = (int)query.hit.primID;
    }
}

void any1(RTCScene scene, Context *context, const Rays &rays, int n, int *id)
{
    for (int i = 0; i < n; i++) {
        RTCRay query;
        load<1>(query, rays, i, 1);
        ask(rtcOccluded1, scene, context, &query);
        id[i] = query.tfar < 0.0f ? 0 : -1;
    }
}

template <int W, typename RayHit, typename Call>
void closest(Call call, RTCScene scene, Context *context, const Rays &rays, int n, float *t, int *id)
{
    alignas(64) int valid[W];
    memset(valid, 255, sizeof valid);
    for (int i = 0; i < n; i += W) {
        const int width = n - i < W ? n - i : W;
        for (int k = width; k < W; k++) valid[k] = 0;
        alignas(64) RayHit query;
        load<W>(query.ray, rays, i, width);
        memset(query.hit.geomID, 255, sizeof query.hit.geomID);
        memset(query.hit.primID, 255, sizeof query.hit.primID);
        ask(call, valid, scene, context, &query);
        store<W>(t + i, query.ray.tfar, width);
        store<W>(id + i, query.hit.primID, width);
    }
}

template <int W, typename Ray, typename Call>
void any(Call call, RTCScene scene, Context *context, const Rays &rays, int n, int *id)
{
    alignas(64) int valid[W];
    memset(valid, 255, sizeof valid);
    for (int i = 0; i < n; i += W) {
        const int width = n - i < W ? n - i : W;
        for (int k = width; k < W; k++) valid[k] = 0;
        alignas(64) Ray query;
        load<W>(query, rays, i, width);
        ask(call, valid, scene, context, &query);
        for (int k = 0; k < width; k++) id[i + k] = query.tfar[k] < 0.0f ? 0 : -1;
    }
}

}  // namespace

extern "C" {

// vertices: n x 3, faces: m x 3; config as for rtcNewDevice, such as "threads=1"
Yardstick *yardstick_triangles(int n, const float *vertices, int m, const unsigned *faces, const char *config, int robust)
{
    RTCDevice device = rtcNewDevice(config);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, n), vertices, 12ull * n);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, m), faces, 12ull * m);
    return commit(device, geometry, robust);
}

// spheres: n x 4, centre and radius
Yardstick *yardstick_spheres(int n, const float *spheres, const char *config, int robust)
{
    RTCDevice device = rtcNewDevice(config);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 16, n), spheres, 16ull * n);
    return commit(device, geometry, robust);
}

// Of Embree, as 31305 for 3.13.5
int yardstick_version(void)
{
    RTCDevice device = rtcNewDevice("threads=1");
    const int version = (int)rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION);
    rtcReleaseDevice(device);
    return version;
}

double yardstick_commit_seconds(const Yardstick *y) { return y->commit_seconds; }

void yardstick_free(Yardstick *y)
{
    rtcReleaseScene(y->scene);
    rtcReleaseDevice(y->device);
    delete y;
}

// rays: 7 arrays of n floats in a row (origin x, y, z, direction x, y, z, t_max). Nearest hits: distance and number
// of the primitive, -1 on a miss; with `occlusion`, 0 in `id` where something is hit.
void yardstick_trace(const Yardstick *y, int width, int occlusion, int coherent, int n, const float *rays, float *t,
                     int *id)
{
    Flushed flushed;
    Context context = context_of(coherent);
    const size_t m = n;
    const Rays r = {{rays, rays + m, rays + 2 * m}, {rays + 3 * m, rays + 4 * m, rays + 5 * m}, rays + 6 * m};
    if (occlusion) {
        if (width == 1) any1(y->scene, &context, r, n, id);
        else if (width == 8) any<8, RTCRay8>(rtcOccluded8, y->scene, &context, r, n, id);
        else any<16, RTCRay16>(rtcOccluded16, y->scene, &context, r, n, id);
    } else {
        if (width == 1) closest1(y->scene, &context, r, n, t, id);
        else if (width == 8) closest<8, RTCRayHit8>(rtcIntersect8, y->scene, &context, r, n, t, id);
        else closest<16, RTCRayHit16>(rtcIntersect16, y->scene, &context, r, n, t, id);
    }
}
}
