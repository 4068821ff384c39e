// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/lamp_light.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

/// One value a voxel, interpolated between voxel centres, zero one voxel beyond the outer ones.
class GreyField {
 public:
  GreyField(const VolumeGeometry& geometry, std::span<const float> values)
      : cell_(geometry.voxelSize()),
        origin_(geometry.bounds.min - 0.5 * cell_),
        n_{geometry.resolution[0] + 2, geometry.resolution[1] + 2, geometry.resolution[2] + 2},
        values_(static_cast<std::size_t>(n_[0]) * n_[1] * n_[2]) {
    std::size_t i = 0;
    for (int z = 1; z + 1 < n_[2]; ++z)
      for (int y = 1; y + 1 < n_[1]; ++y)
        for (int x = 1; x + 1 < n_[0]; ++x) values_[index(x, y, z)] = values[i++];
  }

  Interval inside(const Segment& segment) const {
    const Vec3 last(n_[0] - 1, n_[1] - 1, n_[2] - 1);
    return Box3{origin_, origin_ + last.cwiseProduct(cell_)}
        .intersect(segment.origin, segment.direction)
        .intersect({segment.begin, segment.end});
  }

  /// Steps of about half a voxel.
  int steps(const Interval& part) const {
    return static_cast<int>(std::ceil((part.end - part.begin) / (0.5 * cell_.minCoeff())));
  }

  double at(const Vec3& point) const {
    const Vec3 place = (point - origin_).cwiseQuotient(cell_);
    std::array<int, 3> low{};
    Vec3 share;
    for (int a = 0; a < 3; ++a) {
      low[a] = std::clamp(static_cast<int>(place[a]), 0, n_[a] - 2);
      share[a] = std::clamp(place[a] - low[a], 0.0, 1.0);
    }
    const float* v = &values_[index(low[0], low[1], low[2])];
    const std::size_t up = static_cast<std::size_t>(n_[0]), in = up * n_[1];
    const auto row = [&](std::size_t at) { return v[at] + share[0] * (v[at + 1] - v[at]); };
    const double near = row(0) + share[1] * (row(up) - row(0));
    const double far = row(in) + share[1] * (row(in + up) - row(in));
    return near + share[2] * (far - near);
  }

  double integral(const Segment& segment) const {
    const Interval part = inside(segment);
    if (part.empty())
      return 0;
    const int count = steps(part);
    const double length = (part.end - part.begin) / count;
    double sum = 0;
    for (int k = 0; k < count; ++k) sum += at(segment.at(part.begin + (k + 0.5) * length));
    return sum * length;
  }

 private:
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * n_[1] + y) * n_[0] + x;
  }

  Vec3 cell_, origin_;
  std::array<int, 3> n_;
  std::vector<float> values_;
};

Segment towards(const CaptureLamp& lamp, const Vec3& point) {
  if (lamp.sun)
    return {point, -lamp.direction, 0, std::numeric_limits<double>::infinity()};
  const Vec3 way = lamp.position - point;
  const double distance = way.norm();
  return {point, distance > 0 ? Vec3(way / distance) : Vec3(Vec3::UnitX()), 0, distance};
}

Rgb irradiance(const CaptureLamp& lamp, const Vec3& point) {
  constexpr double kNearest = 0.05;  // [m]; lamps have a size
  if (lamp.sun)
    return lamp.light;
  const double distance = std::max((lamp.position - point).norm(), kNearest);
  return lamp.light / (distance * distance);
}

Vec3 centreOf(const VolumeGeometry& geometry, std::size_t voxel) {
  const auto& n = geometry.resolution;
  const auto x = static_cast<double>(voxel % n[0]), y = static_cast<double>(voxel / n[0] % n[1]),
             z = static_cast<double>(voxel / n[0] / n[1]);
  return geometry.bounds.min + Vec3(x + 0.5, y + 0.5, z + 0.5).cwiseProduct(geometry.voxelSize());
}

}  // namespace

std::vector<float> lampSource(const CaptureLighting& lighting, const VolumeGeometry& geometry,
                              std::span<const float> extinction, std::span<const float> wanted) {
  const GreyField field(geometry, extinction);
  const Rgb scattered = lighting.albedo / (4 * std::numbers::pi);
  std::vector<float> source(3 * geometry.voxels());
  parallelRanges(geometry.voxels(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!wanted.empty() && wanted[i] == 0)
        continue;
      const Vec3 point = centreOf(geometry, i);
      Rgb sum = Rgb::Zero();
      for (const CaptureLamp& lamp : lighting.lamps)
        sum += irradiance(lamp, point) * std::exp(-field.integral(towards(lamp, point)));
      for (int c = 0; c < 3; ++c) source[3 * i + c] = static_cast<float>(scattered[c] * sum[c]);
    }
  });
  return source;
}

std::vector<float> litExtinction(const CaptureLighting& lighting, const VolumeGeometry& geometry,
                                 std::span<const float> emission) {
  constexpr int kRounds = 12;
  constexpr double kDarkest = 0.02, kEnough = 2e-3;
  std::vector<float> wanted(geometry.voxels()), extinction(geometry.voxels());
  for (std::size_t i = 0; i < wanted.size(); ++i)
    wanted[i] = emission[3 * i] + emission[3 * i + 1] + emission[3 * i + 2];
  double darkest = 0;
  for (int round = 0; round < kRounds; ++round) {
    const auto source = lampSource(lighting, geometry, extinction, wanted);
    if (round == 0) {
      for (const float light : source) darkest = std::max(darkest, kDarkest * light);
    }
    double change = 0, size = 0;
    for (std::size_t i = 0; i < extinction.size(); ++i) {
      if (wanted[i] == 0)
        continue;
      double sent = 0, squares = darkest * darkest;
      for (int c = 0; c < 3; ++c) {
        sent += static_cast<double>(emission[3 * i + c]) * source[3 * i + c];
        squares += static_cast<double>(source[3 * i + c]) * source[3 * i + c];
      }
      const double found = std::max(0.0, sent / squares);
      // Half a step: what is found before a voxel changes its own light.
      const double next = round == 0 ? found : 0.5 * (found + extinction[i]);
      change += std::abs(next - extinction[i]);
      size += next;
      extinction[i] = static_cast<float>(next);
    }
    if (change <= kEnough * size)
      break;
  }
  return extinction;
}

std::vector<float> selfAttenuation(const Camera& camera, const VolumeGeometry& geometry,
                                   std::span<const float> extinction,
                                   std::span<const float> emission) {
  constexpr double kMax = 5;
  std::vector<float> grey(geometry.voxels());
  for (std::size_t i = 0; i < grey.size(); ++i)
    grey[i] = emission[3 * i] + emission[3 * i + 1] + emission[3 * i + 2];
  const GreyField takes(geometry, extinction), sends(geometry, grey);
  const int width = camera.width();
  std::vector<float> factors(static_cast<std::size_t>(width) * camera.height(), 1);
  parallelFor(static_cast<std::size_t>(camera.height()), [&](std::size_t row) {
    for (int x = 0; x < width; ++x) {
      const Segment ray = camera.ray(x + 0.5, static_cast<double>(row) + 0.5);
      const Interval part = takes.inside(ray);
      if (part.empty())
        continue;
      const int count = takes.steps(part);
      const double length = (part.end - part.begin) / count;
      double depth = 0, all = 0, left = 0;
      for (int k = 0; k < count; ++k) {
        const Vec3 point = ray.at(part.begin + (k + 0.5) * length);
        const double light = sends.at(point), own = takes.at(point) * length;
        all += light;
        left += light * std::exp(-depth - 0.5 * own);
        depth += own;
      }
      if (all > 0)
        factors[row * width + x] = static_cast<float>(std::min(kMax, all / std::max(left, 1e-30)));
    }
  });
  return factors;
}

Result<LitReconstruction> reconstructLit(std::span<TomographyView> views,
                                         std::span<const std::size_t> fitted,
                                         const VolumeGeometry& geometry,
                                         const TomographyOptions& options,
                                         const CaptureLighting& lighting, Progress& progress) {
  constexpr int kRounds = 4;
  if (lighting.lamps.empty())
    return fail(ErrorCode::kInvalidArgument, "there are no lamps to light the medium");
  std::vector<Image> given;
  for (const TomographyView& view : views) given.push_back(view.radiance);
  LitReconstruction lit;
  TomographyOptions now = options;
  for (int round = 0;; ++round) {
    std::vector<TomographyView> some;
    for (const std::size_t v : fitted) some.push_back(views[v]);
    VOLUTE_ASSIGN(lit.fit, reconstruct(some, geometry, now, lit.fit.volume, progress));
    lit.extinction = litExtinction(lighting, geometry, lit.fit.volume);
    if (round == kRounds)
      return lit;
    if (lit.fit.choice)
      now.choice = lit.fit.choice;
    for (std::size_t v = 0; v < views.size(); ++v) {
      const auto factors =
          selfAttenuation(views[v].camera, geometry, lit.extinction, lit.fit.volume);
      for (std::size_t i = 0; i < given[v].pixels.size(); ++i)
        views[v].radiance.pixels[i] = factors[i / 3] * given[v].pixels[i];
    }
  }
}

}  // namespace volute
