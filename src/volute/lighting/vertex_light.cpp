// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/vertex_light.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr std::size_t kGrain = 256;

/// Two ways out of a tet as near as this, of the mesh's size, are one edge.
constexpr double kNear = 1e-9;

double sizeOf(const TetMesh& mesh) {
  return mesh.bounds().size().maxCoeff();
}

/// Up to where a way runs, cut where it has left the bounds: towards the sun it is endless.
double endOf(const Segment& way, const TetMesh& mesh) {
  return std::min(way.end, 4 * sizeOf(mesh) + (way.origin - mesh.bounds().centre()).norm());
}

bool meshBetween(const TetLocator& locator, const Segment& way, double begin) {
  std::vector<TetCrossing> crossings;
  locator.crossings({way.origin, way.direction, begin, endOf(way, locator.mesh())}, crossings);
  double length = 0;
  for (const TetCrossing& crossing : crossings) length += crossing.end - crossing.begin;
  return length > 1e-6 * sizeOf(locator.mesh());
}

}  // namespace

LampPaths::LampPaths(std::shared_ptr<const TetLocator> locator) : locator_(std::move(locator)) {
  const TetMesh& mesh = locator_->mesh();
  begin_.assign(mesh.vertices().size() + 1, 0);
  for (const Tet& tet : mesh.tets()) {
    for (const std::int32_t v : tet) ++begin_[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t i = 0; i + 1 < begin_.size(); ++i) begin_[i + 1] += begin_[i];
  around_.resize(static_cast<std::size_t>(begin_.back()));
  std::vector<std::int32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t t = 0; t < mesh.tets().size(); ++t) {
    for (const std::int32_t v : mesh.tets()[t]) around_[next[v]++] = static_cast<std::int32_t>(t);
  }
}

/// The tet around a vertex into which a direction points; -1: none.
std::int32_t LampPaths::firstTet(std::int32_t vertex, const Vec3& direction, bool& doubtful) const {
  const TetMesh& mesh = locator_->mesh();
  constexpr double kFlat = 1e-7;  // of the cosine: along a face
  for (std::int32_t i = begin_[vertex]; i < begin_[vertex + 1]; ++i) {
    const std::int32_t tet = around_[i];
    const auto slopes = mesh.slopes(tet);
    double least = 1;
    for (int k = 0; k < 4; ++k) {
      if (mesh.tets()[tet][k] != vertex)
        least = std::min(least, slopes[k].dot(direction) / slopes[k].norm());
    }
    if (least > kFlat) {
      doubtful = false;
      return tet;
    }
    doubtful |= least > -kFlat;
  }
  return -1;
}

LampPaths::Walk LampPaths::walk(std::int32_t vertex, const Segment& way,
                                std::span<const float> extinction, bool lampInside) const {
  Walk out;
  const std::int32_t tet = firstTet(vertex, way.direction, out.doubtful);
  return out.doubtful ? out : walkFrom(*locator_, tet, way, extinction, lampInside);
}

LampPaths::Walk LampPaths::walkFrom(const TetLocator& locator, std::int32_t tet, const Segment& way,
                                    std::span<const float> extinction, bool lampInside) {
  const TetMesh& mesh = locator.mesh();
  const double near = kNear * sizeOf(mesh);
  Walk out;
  int entry = -1;  // the vertex across the face by which the walk came in
  double s = 0;
  while (tet >= 0) {
    const auto slopes = mesh.slopes(tet);
    const auto shares = mesh.shares(tet, way.origin);
    double first = std::numeric_limits<double>::infinity(), second = first, value = 0, slope = 0;
    int exit = -1;
    for (int k = 0; k < 4; ++k) {
      const double down = slopes[k].dot(way.direction);
      const float at = extinction[mesh.tets()[tet][k]];
      value += shares[k] * at;
      slope += down * at;
      if (k == entry || !(down < 0))
        continue;
      const double leave = -shares[k] / down;
      if (leave < first) {
        second = first;
        first = leave;
        exit = k;
      } else {
        second = std::min(second, leave);
      }
    }
    const double end = std::min(first, way.end);
    out.doubtful = exit < 0 || (first < way.end && second - first < near) || end < s - near;
    if (out.doubtful)
      return out;
    if (end > s)
      out.depth += (value + 0.5 * slope * (s + end)) * (end - s);
    s = std::max(s, end);
    if (first >= way.end)
      return out;
    const std::int32_t across = mesh.opposite(4 * tet + exit);
    if (across == TetMesh::kBoundary)
      break;
    tet = across / 4;
    entry = across % 4;
  }
  if (way.end - s > near)
    out.dark = lampInside || meshBetween(locator, way, s + near);
  return out;
}

std::vector<float> LampPaths::shares(std::span<const float> extinction, const Lamp& lamp,
                                     const Blocks& blocks) const {
  const TetMesh& mesh = locator_->mesh();
  VOLUTE_ASSERT(extinction.size() == mesh.vertices().size());
  const bool inside = lamp.kind == Lamp::Kind::kSpot && locator_->find(lamp.position) >= 0;
  std::vector<float> shares(extinction.size(), 0);
  parallelRanges(shares.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<Segment> ways;
    std::vector<std::size_t> lit;
    for (std::size_t i = begin; i < end; ++i) {
      const Segment way = lamp.towards(mesh.vertices()[i]);
      const Walk walk = this->walk(static_cast<std::int32_t>(i), way, extinction, inside);
      const double share = walk.doubtful ? lampShareReference(*locator_, extinction, way)
                                         : (walk.dark ? 0 : std::exp(-walk.depth));
      shares[i] = static_cast<float>(share);
      if (share > 0 && blocks) {
        ways.push_back(way);
        lit.push_back(i);
      }
    }
    std::vector<std::uint8_t> blocked(ways.size());
    if (!ways.empty())
      blocks(ways, blocked);
    for (std::size_t k = 0; k < lit.size(); ++k) {
      if (blocked[k])
        shares[lit[k]] = 0;
    }
  });
  return shares;
}

double lampShareAt(const TetLocator& locator, std::span<const float> extinction, const Segment& way,
                   std::int32_t tet, bool lampInside) {
  const auto walk = LampPaths::walkFrom(locator, tet, way, extinction, lampInside);
  if (walk.doubtful)
    return lampShareReference(locator, extinction, way);
  return walk.dark ? 0 : std::exp(-walk.depth);
}

double lampShareReference(const TetLocator& locator, std::span<const float> extinction,
                          const Segment& way) {
  const TetMesh& mesh = locator.mesh();
  const double most = 1e-6 * sizeOf(mesh);
  std::vector<TetCrossing> crossings;
  locator.crossings({way.origin, way.direction, way.begin, endOf(way, mesh)}, crossings);
  // A way that only grazes the mesh's skin is not in it.
  std::erase_if(crossings, [](const TetCrossing& c) { return c.end - c.begin < 1e-12; });
  double depth = 0, end = 0;
  for (const TetCrossing& crossing : crossings) {
    if (crossing.begin - end > most)
      return 0;
    const auto share = mesh.shares(crossing.tet, way.at(0.5 * (crossing.begin + crossing.end)));
    for (int k = 0; k < 4; ++k) {
      depth += std::max(share[k], 0.0) * extinction[mesh.tets()[crossing.tet][k]] *
               (crossing.end - crossing.begin);
    }
    end = crossing.end;
  }
  const bool lampInside = std::isfinite(way.end) && locator.find(way.at(way.end)) >= 0;
  if (lampInside && way.end - end > most)
    return 0;
  return std::exp(-depth);
}

std::vector<float> scatteredLight(std::span<const Vec3> points, std::span<const Lamp> lamps,
                                  std::span<const std::vector<float>> shares, const Rgb& albedo,
                                  const Rgb& ambient) {
  std::vector<float> light(3 * points.size());
  parallelRanges(points.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Rgb arriving = Rgb::Zero();
      for (std::size_t l = 0; l < lamps.size(); ++l)
        arriving += shares[l][i] * lamps[l].irradiance(points[i]);
      const Rgb source = albedo * (arriving / (4 * std::numbers::pi) + ambient);
      for (int c = 0; c < 3; ++c) light[3 * i + c] = static_cast<float>(source[c]);
    }
  });
  return light;
}

}  // namespace volute
