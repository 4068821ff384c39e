// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/medium_probe.hpp"

#include <algorithm>

#include "volute/viewer/pick_wall.hpp"

namespace volute {
namespace {

constexpr int kSamples = 256;  ///< places along a ray
constexpr double kFar = 1e9;   ///< [m], where parallel rays are cut off

/// The part of the ray inside the medium, finite.
Interval partInside(const AnyMedium& medium, const Segment& ray, double size) {
  const Interval inside = medium.bounds().intersect(ray.origin, ray.direction);
  const bool begins = ray.begin > -0.1 * kFar;
  const double end = begins ? ray.begin + 1e3 * size + 1e3 : kFar;
  return inside.intersect({std::max(ray.begin, -kFar), std::min(ray.end, end)});
}

}  // namespace

std::optional<MediumProbe::Reading> MediumProbe::read(const std::shared_ptr<const ViewScene>& scene,
                                                      Segment ray, double size) {
  if (of_.lock() != scene) {
    media_.clear();
    for (const auto& medium : scene->now) medium->addMedia(media_.emplace_back());
    of_ = scene;
  }
  Reading reading;
  if (const auto wall = pickWall(*scene, ray)) {
    reading.onSurface = true;
    reading.place = wall->position;
    ray.end = std::max(ray.begin, (wall->position - ray.origin).dot(ray.direction));
  }
  double best = 0;
  for (const auto& media : media_) {
    for (const AnyMedium& medium : media) {
      const Interval part = partInside(medium, ray, size);
      if (part.empty() || reading.onSurface)
        continue;
      for (int i = 0; i < kSamples; ++i) {
        const Vec3 at = ray.at(part.begin + (i + 0.5) / kSamples * (part.end - part.begin));
        const double value = medium.extinction(at) + medium.emission(at).sum();
        if (value > best) {
          best = value;
          reading.place = at;
        }
      }
    }
  }
  if (!reading.onSurface && best == 0)
    return std::nullopt;
  constexpr double kBefore = 1e-3;  // of the scene's size
  reading.inside = reading.place - (reading.onSurface ? kBefore * size : 0) * ray.direction;
  for (std::size_t m = 0; m < media_.size(); ++m) {
    Medium found;
    found.name = m < scene->names.size() ? scene->names[m] : "";
    for (const AnyMedium& medium : media_[m]) {
      double depth = 0;
      medium.opticalDepth({&ray, 1}, {&depth, 1});
      found.extinction += medium.extinction(reading.place);
      found.emission += medium.emission(reading.place);
      found.opticalDepth += depth;
    }
    reading.media.push_back(std::move(found));
  }
  return reading;
}

}  // namespace volute
