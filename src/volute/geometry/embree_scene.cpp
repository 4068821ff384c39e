// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/embree_scene.hpp"

#if VOLUTE_EMBREE == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include <cmath>
#include <optional>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr double kRayMargin = 1e-5;  ///< of the scene's size, before and behind a ray's part
constexpr double kLargest = 1e15;    ///< [m]; single precision squares what it is given

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};

struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

using Device = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;
using SceneHandle = std::unique_ptr<RTCSceneTy, ReleaseScene>;

/// Where a segment crosses the triangle's plane, if strictly between its ends.
std::optional<double> atPlane(const Segment& segment, const Triangle& triangle) {
  const Vec3 normal = triangle.normal();
  const double distance =
      normal.dot(triangle.corners[0] - segment.origin) / normal.dot(segment.direction);
  if (distance > segment.begin && distance < segment.end)
    return distance;
  return std::nullopt;
}

#if VOLUTE_EMBREE == 3
using QueryContext = RTCIntersectContext;
constexpr RTCSceneFlags kFilters = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
#else
using QueryContext = RTCRayQueryContext;
constexpr RTCSceneFlags kFilters = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
#endif

/// What a filter call knows of its query: a ray's id is the place of its segment.
struct Query {
  QueryContext context;
  std::span<const Triangle> triangles;
  std::span<const Segment> segments;
};

void keepWithin(const RTCFilterFunctionNArguments* arguments) {
  const auto* query = reinterpret_cast<const Query*>(arguments->context);
  for (unsigned int i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] != -1)
      continue;
    const unsigned int triangle = RTCHitN_primID(arguments->hit, arguments->N, i);
    const unsigned int segment = RTCRayN_id(arguments->ray, arguments->N, i);
    if (!atPlane(query->segments[segment], query->triangles[triangle]))
      arguments->valid[i] = 0;
  }
}

// Both versions pass the filter with each query; the third has it in the context, the fourth in
// arguments beside it.
#if VOLUTE_EMBREE == 3
RTCIntersectContext* begin(Query& query, bool coherent = false) {
  rtcInitIntersectContext(&query.context);
  if (coherent)
    query.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  query.context.filter = keepWithin;
  return &query.context;
}

void intersect(RTCScene scene, Query& query, RTCRayHit& found) {
  rtcIntersect1(scene, begin(query), &found);
}

void intersect(RTCScene scene, Query& query, const int* valid, RTCRayHit16& found) {
  rtcIntersect16(valid, scene, begin(query, true), &found);
}

void occlude(RTCScene scene, Query& query, RTCRay& ray) {
  rtcOccluded1(scene, begin(query), &ray);
}
#else
template <class Arguments>
void begin(Query& query, Arguments& arguments, RTCRayQueryFlags order) {
  rtcInitRayQueryContext(&query.context);
  arguments.flags =
      static_cast<RTCRayQueryFlags>(order | RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER);
  arguments.context = &query.context;
  arguments.filter = keepWithin;
}

RTCIntersectArguments toIntersect(Query& query, RTCRayQueryFlags order) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  begin(query, arguments, order);
  return arguments;
}

void intersect(RTCScene scene, Query& query, RTCRayHit& found) {
  auto arguments = toIntersect(query, RTC_RAY_QUERY_FLAG_INCOHERENT);
  rtcIntersect1(scene, &found, &arguments);
}

void intersect(RTCScene scene, Query& query, const int* valid, RTCRayHit16& found) {
  auto arguments = toIntersect(query, RTC_RAY_QUERY_FLAG_COHERENT);
  rtcIntersect16(valid, scene, &found, &arguments);
}

void occlude(RTCScene scene, Query& query, RTCRay& ray) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  begin(query, arguments, RTC_RAY_QUERY_FLAG_INCOHERENT);
  rtcOccluded1(scene, &ray, &arguments);
}
#endif

bool attachTriangles(RTCDevice device, RTCScene scene, std::span<const Triangle> triangles,
                     const Vec3& centre) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* corners = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                              RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                              3 * triangles.size()));
  auto* indices = static_cast<unsigned int*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned int), triangles.size()));
  const bool filled = corners && indices;
  for (std::size_t i = 0; filled && i < triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 corner = triangles[i].corners[k] - centre;
      for (int axis = 0; axis < 3; ++axis)
        corners[3 * (3 * i + k) + axis] = static_cast<float>(corner[axis]);
      indices[3 * i + k] = static_cast<unsigned int>(3 * i + k);
    }
  }
  if (filled) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
  }
  rtcReleaseGeometry(geometry);
  return filled;
}

}  // namespace

struct EmbreeScene::Impl {
  Device device;
  SceneHandle scene;
  std::span<const Triangle> triangles;
  Box3 bounds;  ///< a little larger than the scene
  Vec3 centre;
  double margin = 0;

  std::optional<RTCRay> rayOf(const Segment& segment) const;
  Hit hitOf(const Segment& segment, unsigned int triangle) const;
};

/// The part near the scene, around its middle; nothing where the segment passes by.
std::optional<RTCRay> EmbreeScene::Impl::rayOf(const Segment& segment) const {
  const Interval part =
      bounds.intersect(segment.origin, segment.direction).intersect({segment.begin, segment.end});
  if (part.empty())
    return std::nullopt;
  const Vec3 from = segment.at(part.begin - margin) - centre;
  RTCRay ray{};
  ray.org_x = static_cast<float>(from.x());
  ray.org_y = static_cast<float>(from.y());
  ray.org_z = static_cast<float>(from.z());
  ray.dir_x = static_cast<float>(segment.direction.x());
  ray.dir_y = static_cast<float>(segment.direction.y());
  ray.dir_z = static_cast<float>(segment.direction.z());
  ray.tfar = static_cast<float>(part.length() + 2 * margin);
  ray.mask = ~0u;
  return ray;
}

EmbreeScene::EmbreeScene(std::unique_ptr<const Impl> impl) : impl_(std::move(impl)) {}

EmbreeScene::~EmbreeScene() = default;

std::unique_ptr<const EmbreeScene> EmbreeScene::make(std::span<const Triangle> triangles,
                                                     const Box3& bounds) {
  auto impl = std::make_unique<Impl>();
  impl->triangles = triangles;
  impl->centre = bounds.centre();
  const double size = bounds.size().norm();
  if (!(size > 0) || size > kLargest)
    return nullptr;
  impl->margin = kRayMargin * size;
  impl->bounds = {(bounds.min.array() - impl->margin).matrix(),
                  (bounds.max.array() + impl->margin).matrix()};
  // By TBB, as all loops: a number of threads given here would be that of the whole program.
  impl->device.reset(rtcNewDevice(nullptr));
  if (!impl->device)
    return nullptr;
  impl->scene.reset(rtcNewScene(impl->device.get()));
  rtcSetSceneFlags(impl->scene.get(), static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | kFilters));
  if (!attachTriangles(impl->device.get(), impl->scene.get(), triangles, impl->centre))
    return nullptr;
  isolated([&] { rtcCommitScene(impl->scene.get()); });
  if (rtcGetDeviceError(impl->device.get()) != RTC_ERROR_NONE)
    return nullptr;
  return std::unique_ptr<const EmbreeScene>(new EmbreeScene(std::move(impl)));
}

Hit EmbreeScene::Impl::hitOf(const Segment& segment, unsigned int triangle) const {
  if (triangle == RTC_INVALID_GEOMETRY_ID)
    return {};
  return {*atPlane(segment, triangles[triangle]), triangle};
}

Hit EmbreeScene::nearest(const Segment& segment) const {
  const auto ray = impl_->rayOf(segment);
  if (!ray)
    return {};
  Query query{{}, impl_->triangles, {&segment, 1}};
  RTCRayHit found{*ray, {}};
  found.hit.geomID = found.hit.primID = RTC_INVALID_GEOMETRY_ID;
  intersect(impl_->scene.get(), query, found);
  return impl_->hitOf(segment, found.hit.primID);
}

void EmbreeScene::nearest(std::span<const Segment> segments, std::span<Hit> hits) const {
  constexpr std::size_t kPacket = 16;
  for (std::size_t first = 0; first < segments.size(); first += kPacket) {
    const std::size_t count = std::min(kPacket, segments.size() - first);
    const auto some = segments.subspan(first, count);
    alignas(64) int valid[kPacket] = {};
    RTCRayHit16 found{};
    for (std::size_t i = 0; i < kPacket; ++i) {
      found.hit.geomID[i] = found.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
      const auto ray = i < count ? impl_->rayOf(some[i]) : std::nullopt;
      if (!ray)
        continue;
      valid[i] = -1;
      found.ray.org_x[i] = ray->org_x, found.ray.org_y[i] = ray->org_y;
      found.ray.org_z[i] = ray->org_z;
      found.ray.dir_x[i] = ray->dir_x, found.ray.dir_y[i] = ray->dir_y;
      found.ray.dir_z[i] = ray->dir_z;
      found.ray.tfar[i] = ray->tfar, found.ray.mask[i] = ray->mask;
      found.ray.id[i] = static_cast<unsigned int>(i);
    }
    Query query{{}, impl_->triangles, some};
    intersect(impl_->scene.get(), query, valid, found);
    for (std::size_t i = 0; i < count; ++i)
      hits[first + i] = impl_->hitOf(some[i], found.hit.primID[i]);
  }
}

bool EmbreeScene::occluded(const Segment& segment) const {
  auto ray = impl_->rayOf(segment);
  if (!ray)
    return false;
  Query query{{}, impl_->triangles, {&segment, 1}};
  occlude(impl_->scene.get(), query, *ray);
  return ray->tfar < 0;
}

}  // namespace volute
