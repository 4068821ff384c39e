// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "volute/base/parallel.hpp"
#include "volute/math/phase_function.hpp"

namespace volute {
namespace {

constexpr std::size_t kLightGrain = 512;  // rays that are marched together
constexpr int kCoarse = 4;                // voxels between places where even light is known
constexpr std::size_t kMostFires = 48;

/// Transmittances of the volume along segments.
void transmittances(const ShadedVoxels& volume, std::span<const Segment> segments,
                    std::span<float> out) {
  std::vector<Radiance> light(segments.size());
  volume.absorption().radiance(segments, light);
  for (std::size_t i = 0; i < light.size(); ++i)
    out[i] = static_cast<float>(light[i].transmittance);
}

/// The 14 ways to the faces and corners of a cube, unit, and their shares of the sphere (Lebedev's
/// rule of 14 points, exact to degree 5).
struct Way {
  Vec3 direction;
  double share = 0;
};

const std::array<Way, 14>& ways() {
  static const auto kWays = [] {
    std::array<Way, 14> all;
    std::size_t count = 0;
    for (int i = 0; i < 27; ++i) {
      const Vec3 way(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      const auto axes = std::lround(way.squaredNorm());
      if (axes == 1 || axes == 3)
        all[count++] = {way.normalized(), axes == 1 ? 1 / 15.0 : 3 / 40.0};
    }
    return all;
  }();
  return kWays;
}

/// A value between eight that are on a lattice of every kCoarse-th voxel.
class CoarseLattice {
 public:
  CoarseLattice(const BrickSlice& slice, std::span<const Vec3> points)
      : voxel_(slice.bounds().size().cwiseQuotient(Vec3(slice.x(), slice.y(), slice.z()))),
        origin_(slice.bounds().min - 0.5 * voxel_),
        // Points reach one voxel beyond the volume; cells need the node behind them.
        count_{slice.x() / kCoarse + 3, slice.y() / kCoarse + 3, slice.z() / kCoarse + 3},
        node_(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2], -1) {
    for (const Vec3& point : points) {
      const auto [cell, place] = find(point);
      for (int i = 0; i < 8; ++i) {
        std::int32_t& node = node_[index(cell, i)];
        if (node >= 0)
          continue;
        node = static_cast<std::int32_t>(nodes.size());
        const Vec3 at(cell[0] + (i & 1), cell[1] + (i >> 1 & 1), cell[2] + (i >> 2));
        nodes.push_back(origin_ + kCoarse * voxel_.cwiseProduct(at));
      }
    }
  }

  Rgb at(const Vec3& point, std::span<const Rgb> values) const {
    const auto [cell, place] = find(point);
    Rgb sum = Rgb::Zero();
    for (int i = 0; i < 8; ++i) {
      double share = 1;
      for (int axis = 0; axis < 3; ++axis) share *= (i >> axis & 1) ? place[axis] : 1 - place[axis];
      sum += share * values[static_cast<std::size_t>(node_[index(cell, i)])];
    }
    return sum;
  }

  std::vector<Vec3> nodes;

 private:
  std::pair<std::array<int, 3>, Vec3> find(const Vec3& point) const {
    const Vec3 place = (point - origin_).cwiseQuotient(kCoarse * voxel_);
    std::array<int, 3> cell{};
    Vec3 rest;
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kRounding = 1e-6;  // points of a voxel's centre must not fall below it
      int& at = cell[static_cast<std::size_t>(axis)];
      at = std::clamp(static_cast<int>(std::floor(place[axis] + kRounding)), 0,
                      count_[static_cast<std::size_t>(axis)] - 2);
      rest[axis] = std::clamp(place[axis] - at, 0.0, 1.0);
    }
    return {cell, rest};
  }

  std::size_t index(const std::array<int, 3>& cell, int corner) const {
    const int x = cell[0] + (corner & 1), y = cell[1] + (corner >> 1 & 1),
              z = cell[2] + (corner >> 2);
    return (static_cast<std::size_t>(z) * count_[1] + y) * count_[0] + x;
  }

  Vec3 voxel_, origin_;
  std::array<int, 3> count_;
  std::vector<std::int32_t> node_;
};

}  // namespace

VolumeLight::VolumeLight(ShadedVoxels volume, VolumeLighting lighting)
    : volume_(std::move(volume)), lighting_(std::move(lighting)) {}

std::vector<Lamp> VolumeLight::lampsOf(const ShadedVoxels& volume, std::size_t most) {
  const BrickSlice& slice = volume.slice();
  if (slice.channels() != 4)
    return {};

  struct Fire {
    Rgb power = Rgb::Zero();
    Vec3 moment = Vec3::Zero();
    double weight = 0;
    double square = 0;
  };

  const Vec3 voxel = slice.bounds().size().cwiseQuotient(Vec3(slice.x(), slice.y(), slice.z()));
  for (int side = 1;; side *= 2) {  // [bricks]
    std::map<std::array<int, 3>, Fire> fires;
    for (int bz = 0; bz < slice.bricksZ(); ++bz) {
      for (int by = 0; by < slice.bricksY(); ++by) {
        for (int bx = 0; bx < slice.bricksX(); ++bx) {
          const std::int32_t stored = slice.brickAt(bx, by, bz);
          if (stored == BrickSlice::kEmpty)
            continue;
          const float* values = slice.brick(stored) + BrickSlice::kVoxels;
          Fire here;
          for (int i = 0; i < BrickSlice::kVoxels; ++i) {
            const Rgb sent(values[i], values[i + BrickSlice::kVoxels],
                           values[i + 2 * BrickSlice::kVoxels]);
            const double weight = sent.sum();
            if (!(weight > 0))
              continue;
            const Vec3 place(bx * 8 + i % 8 + 0.5, by * 8 + i / 8 % 8 + 0.5, bz * 8 + i / 64 + 0.5);
            const Vec3 at = slice.bounds().min + place.cwiseProduct(voxel);
            here.power += sent.max(0);
            here.moment += weight * at;
            here.square += weight * at.squaredNorm();
            here.weight += weight;
          }
          if (!(here.weight > 0))
            continue;
          Fire& fire = fires[{bx / side, by / side, bz / side}];
          fire.power += here.power, fire.moment += here.moment;
          fire.weight += here.weight, fire.square += here.square;
        }
      }
    }
    if (fires.size() > most)
      continue;
    std::vector<Lamp> lamps;
    for (const auto& [place, fire] : fires) {
      Lamp lamp;
      lamp.position = fire.moment / fire.weight;
      // What a voxel emits goes everywhere: its power per solid angle is radiance per metre times
      // volume.
      lamp.intensity = fire.power * voxel.prod();
      // Inside of it no light is stronger than at its rim.
      const double spread =
          std::sqrt(std::max(fire.square / fire.weight - lamp.position.squaredNorm(), 0.0));
      lamp.radius = std::max(spread, 0.5 * voxel.norm());
      lamps.push_back(lamp);
    }
    return lamps;
  }
}

/// Light that is scattered evenly: on a coarse lattice, since it changes slowly.
void VolumeLight::addSurrounding() const {
  const auto& points = volume_.lightPoints();
  even_.assign(points.size(), Rgb::Zero());
  const bool surrounded = lighting_.surrounding.maxCoeff() > 0;
  const std::vector<Lamp> fires =
      lighting_.ownFire ? lampsOf(volume_, kMostFires) : std::vector<Lamp>();
  if (!surrounded && fires.empty())
    return;
  const CoarseLattice lattice(volume_.slice(), points);
  std::vector<Rgb> light(lattice.nodes.size(), Rgb::Zero());
  const std::size_t rays = (surrounded ? ways().size() : 0) + fires.size();
  parallelRanges(light.size(), 1 + kLightGrain / rays, [&](std::size_t begin, std::size_t end) {
    std::vector<Segment> segments;
    std::vector<Rgb> sent;
    for (std::size_t i = begin; i < end; ++i) {
      segments.clear(), sent.clear();
      const Vec3& node = lattice.nodes[i];
      for (const Way& way : ways()) {
        if (!surrounded)
          break;
        segments.push_back({node, way.direction, 0, std::numeric_limits<double>::infinity()});
        sent.push_back(way.share * lighting_.surrounding);
      }
      for (const Lamp& fire : fires) {
        segments.push_back(fire.towards(node));
        sent.push_back(fire.irradiance(node) / (4 * std::numbers::pi));
      }
      std::vector<float> passes(segments.size());
      transmittances(volume_, segments, passes);
      for (std::size_t k = 0; k < segments.size(); ++k) light[i] += passes[k] * sent[k];
    }
  });
  parallelRanges(points.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) even_[i] = lattice.at(points[i], light);
  });
}

void VolumeLight::gather() const {
  std::call_once(gathered_, [&] {
    if (!(lighting_.albedo.maxCoeff() > 0))
      return;
    const auto& points = volume_.lightPoints();
    lampShares_.assign(lighting_.lamps.size(), std::vector<float>(points.size()));
    for (std::size_t l = 0; l < lighting_.lamps.size(); ++l) {
      const Lamp& lamp = lighting_.lamps[l];
      parallelRanges(points.size(), kLightGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<Segment> segments;
        for (std::size_t i = begin; i < end; ++i) segments.push_back(lamp.towards(points[i]));
        const std::span<float> shares(&lampShares_[l][begin], end - begin);
        transmittances(volume_, segments, shares);
        if (!lighting_.blocks)
          return;
        std::vector<std::uint8_t> blocked(segments.size());
        lighting_.blocks(segments, blocked);
        for (std::size_t i = 0; i < blocked.size(); ++i) {
          if (blocked[i])
            shares[i] = 0;
        }
      });
    }
    addSurrounding();
  });
}

ShadedVoxels VolumeLight::shaded(const std::optional<View>& view) const {
  gather();
  if (even_.empty())
    return volume_;
  const auto& points = volume_.lightPoints();
  std::vector<Rgb> light(points.size());
  parallelRanges(points.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Rgb sum = even_[i];
      Vec3 way = Vec3::Zero();  // from the point to the eye
      if (view)
        way = view->parallel ? Vec3(-view->at) : Vec3((view->at - points[i]).normalized());
      for (std::size_t l = 0; l < lighting_.lamps.size(); ++l) {
        const float share = lampShares_[l][i];
        if (share == 0)
          continue;
        const Lamp& lamp = lighting_.lamps[l];
        double phase = 1 / (4 * std::numbers::pi);
        if (view && lighting_.asymmetry != 0) {
          const Vec3 travels = lamp.kind == Lamp::Kind::kSun
                                   ? lamp.direction
                                   : Vec3((points[i] - lamp.position).normalized());
          phase = henyeyGreenstein(lighting_.asymmetry, travels.dot(way));
        }
        sum += share * phase * lamp.irradiance(points[i]);
      }
      light[i] = lighting_.albedo * sum;
      if (!lighting_.colors.empty())
        light[i] *= lighting_.colors[i];
    }
  });
  return volume_.withLight(volume_.forMeans(light));
}

ShadedVoxels VolumeLight::seenFrom(const View& view) const {
  const std::lock_guard lock(guard_);
  const bool same = last_ && (lighting_.asymmetry == 0 || (lastView_ && lastView_->at == view.at &&
                                                           lastView_->parallel == view.parallel));
  if (!same) {
    last_ = shaded(view);
    lastView_ = view;
  }
  return *last_;
}

std::uint64_t VolumeLight::memoryBytes() const {
  const BrickSlice& slice = volume_.slice();
  const std::uint64_t points = slice.values().size();
  const std::uint64_t colors = 3 * sizeof(float);  // of the fire, and of what is seen
  return 2 * slice.values().size_bytes() + slice.index().size_bytes() +
         points * (2 * colors + sizeof(Rgb) + lighting_.lamps.size() * sizeof(float));
}

ShadedVoxels VolumeLight::seen() const {
  return shaded(std::nullopt);
}

}  // namespace volute
