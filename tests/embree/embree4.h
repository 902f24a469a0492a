// What the yardstick needs of Embree 4's interface, declared here since the library comes without its headers in the
// wheel of embreex. From the manual of Embree 4, https://github.com/RenderKit/embree; an enum is an int there.
#pragma once
#include <cstddef>

#define RTC_INVALID_GEOMETRY_ID ((unsigned)-1)

typedef struct RTCDeviceTy *RTCDevice;
typedef struct RTCSceneTy *RTCScene;
typedef struct RTCGeometryTy *RTCGeometry;

enum { RTC_GEOMETRY_TYPE_TRIANGLE = 0, RTC_GEOMETRY_TYPE_SPHERE_POINT = 50 };
enum { RTC_BUFFER_TYPE_INDEX = 0, RTC_BUFFER_TYPE_VERTEX = 1 };
enum { RTC_FORMAT_UINT3 = 0x5003, RTC_FORMAT_FLOAT3 = 0x9003, RTC_FORMAT_FLOAT4 = 0x9004 };
enum { RTC_SCENE_FLAG_ROBUST = 1 << 2 };
enum { RTC_RAY_QUERY_FLAG_INCOHERENT = 0, RTC_RAY_QUERY_FLAG_COHERENT = 1 << 16 };
enum { RTC_DEVICE_PROPERTY_VERSION = 0 };

struct alignas(16) RTCRay {
    float org_x, org_y, org_z, tnear, dir_x, dir_y, dir_z, time, tfar;
    unsigned mask, id, flags;
};
struct alignas(16) RTCHit {
    float Ng_x, Ng_y, Ng_z, u, v;
    unsigned primID, geomID, instID, instPrimID;
};
struct RTCRayHit {
    RTCRay ray;
    RTCHit hit;
};

template <int W>
struct alignas(4 * W) RTCRays {
    float org_x[W], org_y[W], org_z[W], tnear[W], dir_x[W], dir_y[W], dir_z[W], time[W], tfar[W];
    unsigned mask[W], id[W], flags[W];
};
template <int W>
struct alignas(4 * W) RTCHits {
    float Ng_x[W], Ng_y[W], Ng_z[W], u[W], v[W];
    unsigned primID[W], geomID[W], instID[W], instPrimID[W];
};
template <int W>
struct RTCRayHits {
    RTCRays<W> ray;
    RTCHits<W> hit;
};
using RTCRay8 = RTCRays<8>;
using RTCRay16 = RTCRays<16>;
using RTCRayHit8 = RTCRayHits<8>;
using RTCRayHit16 = RTCRayHits<16>;

struct RTCArguments {  // of a call that looks for nearest hits, or for any
    int flags;
    unsigned feature_mask;
    void *context, *filter, *intersect;
    float minWidthDistanceFactor;  // where the library is built for it
};

extern "C" {
RTCDevice rtcNewDevice(const char *config);
void rtcReleaseDevice(RTCDevice);
ptrdiff_t rtcGetDeviceProperty(RTCDevice, int property);
RTCScene rtcNewScene(RTCDevice);
void rtcReleaseScene(RTCScene);
void rtcSetSceneFlags(RTCScene, int flags);
void rtcCommitScene(RTCScene);
RTCGeometry rtcNewGeometry(RTCDevice, int type);
void rtcCommitGeometry(RTCGeometry);
void rtcReleaseGeometry(RTCGeometry);
unsigned rtcAttachGeometry(RTCScene, RTCGeometry);
void *rtcSetNewGeometryBuffer(RTCGeometry, int type, unsigned slot, int format, size_t stride, size_t count);
void rtcIntersect1(RTCScene, RTCRayHit *, RTCArguments *);
void rtcIntersect8(const int *valid, RTCScene, RTCRayHit8 *, RTCArguments *);
void rtcIntersect16(const int *valid, RTCScene, RTCRayHit16 *, RTCArguments *);
void rtcOccluded1(RTCScene, RTCRay *, RTCArguments *);
void rtcOccluded8(const int *valid, RTCScene, RTCRay8 *, RTCArguments *);
void rtcOccluded16(const int *valid, RTCScene, RTCRay16 *, RTCArguments *);
}
