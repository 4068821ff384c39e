// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/vertex_spread.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

namespace volute {
namespace {

constexpr double kSpreadNear = 2.5;  ///< longest edges of a part from the lamp: light changes in it
constexpr int kSpreadHalvings = 4;   ///< of a tet beside the lamp
constexpr double kMeanReach = 0.36;  ///< where 1 / r2 is its mean in a cube of edge 1 around r = 0

double longestEdge(const std::array<Vec3, 4>& corners) {
  double square = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j)
      square = std::max(square, (corners[i] - corners[j]).squaredNorm());
  }
  return std::sqrt(square);
}

std::array<Vec3, 4> tetCorners(const TetMesh& mesh, std::int32_t tet) {
  std::array<Vec3, 4> corners;
  for (std::size_t k = 0; k < 4; ++k) corners[k] = mesh.vertices()[mesh.tets()[tet][k]];
  return corners;
}

Vec3 tetCentre(const std::array<Vec3, 4>& corners) {
  return 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
}

/// What a lamp of intensity 1 sends to a point.
double strengthAt(const Lamp& lamp, const Vec3& point, double radius) {
  const Segment way = lamp.towards(point);
  const double reach = std::max(way.end, radius);
  return lamp.coneShare(way) / (reach * reach);
}

/// A part of a tet: its corners, and the tet's shares there.
struct TetPart {
  std::array<Vec3, 4> corners;
  std::array<Vec4, 4> shares;
  double volume = 0;

  /// Of eight of the same volume: four at the corners, and four of what is left.
  std::array<TetPart, 8> halved() const {
    constexpr int kEnds[10][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 1},
                                  {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    constexpr int kParts[8][4] = {{0, 4, 5, 6}, {4, 1, 7, 8}, {5, 7, 2, 9}, {6, 8, 9, 3},
                                  {4, 5, 6, 8}, {4, 5, 7, 8}, {5, 6, 8, 9}, {5, 7, 8, 9}};
    std::array<TetPart, 8> parts;
    for (std::size_t p = 0; p < 8; ++p) {
      for (std::size_t k = 0; k < 4; ++k) {
        const auto& [a, b] = kEnds[kParts[p][k]];
        parts[p].corners[k] = 0.5 * (corners[a] + corners[b]);
        parts[p].shares[k] = 0.5 * (shares[a] + shares[b]);
      }
      parts[p].volume = volume / 8;
    }
    return parts;
  }
};

/// Adds the integral of each corner's share of the tet, times the light less what is linear.
/// @param linear  at the tet's corners
void addMissing(const Lamp& lamp, const TetPart& part, const Vec4& linear, int halvings,
                Vec4& sums) {
  const Vec3 centre = tetCentre(part.corners);
  if (halvings > 0 && (centre - lamp.position).norm() < kSpreadNear * longestEdge(part.corners)) {
    for (const TetPart& eighth : part.halved())
      addMissing(lamp, eighth, linear, halvings - 1, sums);
    return;
  }
  const Vec4 share = 0.25 * (part.shares[0] + part.shares[1] + part.shares[2] + part.shares[3]);
  const double radius = std::max(lamp.radius, kMeanReach * std::cbrt(part.volume));
  sums += part.volume * (strengthAt(lamp, centre, radius) - share.dot(linear)) * share;
}

/// Tets that share a face with one before, from `first` on.
/// @param joins  whether one is taken
template <class Joins>
std::vector<std::int32_t> spreadFrom(const TetMesh& mesh, std::vector<std::int32_t> first,
                                     Joins&& joins) {
  std::unordered_set<std::int32_t> known(first.begin(), first.end());
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (int k = 0; k < 4; ++k) {
      const std::int32_t half = mesh.opposite(4 * first[i] + k);
      if (half != TetMesh::kBoundary && !known.contains(half / 4) && joins(half / 4))
        known.insert(half / 4), first.push_back(half / 4);
    }
  }
  return first;
}

}  // namespace

std::vector<VertexIrradiance> spreadIrradiance(const TetLocator& locator, const Lamp& lamp) {
  if (lamp.kind == Lamp::Kind::kSun)
    return {};
  const std::int32_t tet = locator.find(lamp.position);
  if (tet < 0)
    return {};
  const TetMesh& mesh = locator.mesh();
  const double cell = longestEdge(tetCorners(mesh, tet));
  if (!(lamp.radius < 0.5 * cell))
    return {};
  const auto beside = spreadFrom(mesh, {tet}, [&](std::int32_t next) {
    const auto corners = tetCorners(mesh, next);
    return (tetCentre(corners) - lamp.position).norm() < kSpreadNear * longestEdge(corners);
  });

  struct Sum {
    double missing = 0, volume = 0, spread = 0;
  };

  std::unordered_map<std::int32_t, Sum> sums;
  const auto isNear = [&](std::int32_t vertex) { return sums.contains(vertex); };
  for (const std::int32_t t : beside) {
    for (const std::int32_t v : mesh.tets()[t]) sums[v];
  }
  const auto around = spreadFrom(mesh, beside, [&](std::int32_t next) {
    return std::ranges::any_of(mesh.tets()[next], isNear);
  });
  const auto spreadAt = [&](std::int32_t vertex) {
    return strengthAt(lamp, mesh.vertices()[vertex], 0.5 * cell);
  };
  for (const std::int32_t t : around) {
    TetPart part{tetCorners(mesh, t), {}, mesh.volume(t)};
    Vec4 linear, missing = Vec4::Zero();
    for (int k = 0; k < 4; ++k) {
      part.shares[static_cast<std::size_t>(k)] = Vec4::Unit(k);
      linear[k] = spreadAt(mesh.tets()[t][static_cast<std::size_t>(k)]);
    }
    addMissing(lamp, part, linear, kSpreadHalvings, missing);
    for (int k = 0; k < 4; ++k) {
      const auto found = sums.find(mesh.tets()[t][static_cast<std::size_t>(k)]);
      if (found == sums.end())
        continue;
      found->second.missing += missing[k];
      found->second.volume += 0.25 * part.volume;
    }
  }
  std::vector<VertexIrradiance> values;
  for (const auto& [vertex, sum] : sums) {
    const double strength = std::max(0.0, spreadAt(vertex) + sum.missing / sum.volume);
    values.push_back({vertex, strength * lamp.intensity});
  }
  std::ranges::sort(values, {}, &VertexIrradiance::vertex);
  return values;
}

}  // namespace volute
