// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/render/surfaces.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <thread>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

/// How far a shadow's ray begins from its surface and ends before its lamp, which may be in the
/// plane of a surface: more than rounding moves it, also where coordinates are large.
constexpr double kLift = 1e-6;       ///< [m]
constexpr double kRounding = 1e-14;  ///< of the coordinates

constexpr std::size_t kGrain = 4096;  ///< segments worth a task
constexpr std::size_t kBand = std::size_t{1}
                              << 16;  ///< pixels that SurfaceScene::more is asked for at once

/// A lamp's rays from the points that face it.
struct ShadowRays {
  std::vector<std::size_t> point;  ///< whose it is
  std::vector<double> cosine;
  std::vector<Segment> segments;
};

ShadowRays shadowRaysTo(const Lamp& lamp, const TriangleScene& geometry,
                        std::span<const Segment> segments, std::span<const SurfacePoint> points) {
  ShadowRays rays;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Hit& hit = points[i].hit;
    if (!hit.found())
      continue;
    const Vec3 normal = facing(geometry, segments[i], hit);
    const Vec3 place = segments[i].at(hit.distance) + geometry.roughness(hit) * normal;
    Segment way = lamp.towards(place);
    const double cosine = normal.dot(way.direction);
    const double lift = kLift + kRounding * place.cwiseAbs().maxCoeff();
    const bool before = cosine > 0 && cosine * way.end > lift;  // the surface's plane
    if (way.empty() || !before || (lamp.irradiance(place) == 0).all())
      continue;
    way.begin = lift, way.end -= lift;
    rays.point.push_back(i);
    rays.cosine.push_back(cosine);
    rays.segments.push_back(way);
  }
  return rays;
}

/// The share of each ray's light that arrives.
std::vector<double> arriving(const SurfaceScene& scene, const ShadowRays& rays) {
  std::vector<std::uint8_t> blocked(rays.segments.size());
  parallelRanges(blocked.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    scene.geometry.occluded(std::span(rays.segments).subspan(begin, end - begin),
                            std::span(blocked).subspan(begin, end - begin));
  });
  std::vector<Segment> open;
  for (std::size_t k = 0; k < blocked.size(); ++k) {
    if (!blocked[k])
      open.push_back(rays.segments[k]);
  }
  std::vector<double> sum(open.size(), 0), depths(open.size());
  for (const AnyMedium& medium : scene.media) {
    medium.opticalDepth(open, depths);
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += depths[k];
  }
  if (scene.more) {
    scene.more(open, depths);
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += depths[k];
  }
  std::vector<double> share(blocked.size(), 0);
  std::size_t next = 0;
  for (std::size_t k = 0; k < blocked.size(); ++k) {
    if (!blocked[k])
      share[k] = std::exp(-sum[next++]);
  }
  return share;
}

}  // namespace

Vec3 facing(const TriangleScene& geometry, const Segment& segment, const Hit& hit) {
  const Vec3 normal = geometry.outward(segment, hit);
  return normal.dot(segment.direction) > 0 ? Vec3(-normal) : normal;
}

std::vector<SurfacePoint> lookAtSurfaces(const SurfaceScene& scene,
                                         std::span<const Segment> segments,
                                         std::uint64_t* shadowRays) {
  std::vector<Hit> hits(segments.size());
  parallelRanges(hits.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    scene.geometry.nearest(segments.subspan(begin, end - begin),
                           std::span(hits).subspan(begin, end - begin));
  });
  std::vector<SurfacePoint> points(segments.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].hit = hits[i];
    if (!hits[i].found())
      continue;
    const Material& material = scene.geometry.materialOf(hits[i]);
    points[i].radiance = material.emission + material.baseColor * scene.ambient;
  }
  for (const Lamp& lamp : scene.lamps) {
    const ShadowRays rays = shadowRaysTo(lamp, scene.geometry, segments, points);
    const std::vector<double> share =
        scene.shadows ? arriving(scene, rays) : std::vector<double>(rays.segments.size(), 1.0);
    for (std::size_t k = 0; k < share.size(); ++k) {
      SurfacePoint& point = points[rays.point[k]];
      const Rgb irradiance = lamp.irradiance(rays.segments[k].origin) * rays.cosine[k] * share[k];
      point.radiance +=
          scene.geometry.materialOf(point.hit).baseColor / std::numbers::pi * irradiance;
    }
    if (shadowRays)
      *shadowRays += scene.shadows ? share.size() : 0;
  }
  return points;
}

Result<SurfacePicture> renderSurfaces(const Camera& camera, const SurfaceScene& scene,
                                      const Rgb& background, Progress& progress,
                                      std::span<const std::uint8_t> only) {
  SurfacePicture picture;
  picture.color = Image(camera.width(), camera.height(), 3);
  picture.depth.resize(static_cast<std::size_t>(camera.width()) * camera.height());
  const auto caller = std::this_thread::get_id();  // the only one that may talk to `progress`
  std::atomic<bool> stopped = false;
  std::atomic<std::uint64_t> surfacePixels = 0, shadowRays = 0;
  const auto drawRows = [&](std::size_t first, std::size_t end) {
    std::vector<Segment> segments;
    std::vector<std::size_t> pixels;
    const auto width = static_cast<std::size_t>(camera.width());
    for (std::size_t pixel = first * width; pixel < end * width; ++pixel) {
      picture.depth[pixel] = std::numeric_limits<float>::infinity();
      if (!only.empty() && !only[pixel])
        continue;
      pixels.push_back(pixel);
      segments.push_back(camera.ray(static_cast<double>(pixel % width) + 0.5,
                                    static_cast<double>(pixel / width) + 0.5));
    }
    std::uint64_t rays = 0, found = 0;
    const auto points = lookAtSurfaces(scene, segments, &rays);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const SurfacePoint& point = points[i];
      const Rgb color = point.hit.found() ? point.radiance : background;
      for (std::size_t c = 0; c < 3; ++c) {
        picture.color.pixels[3 * pixels[i] + c] = static_cast<float>(color[c]);
      }
      picture.depth[pixels[i]] = static_cast<float>(point.hit.distance);
      found += point.hit.found();
    }
    surfacePixels += found, shadowRays += rays;
  };
  const auto height = static_cast<std::size_t>(camera.height());
  if (scene.more) {
    const std::size_t rows =
        std::max<std::size_t>(1, kBand / static_cast<std::size_t>(camera.width()));
    for (std::size_t y = 0; y < height; y += rows) drawRows(y, std::min(y + rows, height));
  } else {
    parallelFor(height, [&](std::size_t y) {
      if (std::this_thread::get_id() == caller && progress.cancelled())
        stopped = true;
      if (!stopped)
        drawRows(y, y + 1);
    });
  }
  if (stopped || progress.cancelled())
    return fail(ErrorCode::kCancelled, "stopped before the surfaces were drawn");
  picture.surfacePixels = surfacePixels, picture.shadowRays = shadowRays;
  return picture;
}

}  // namespace volute
