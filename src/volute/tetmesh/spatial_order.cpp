// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/spatial_order.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace volute {
namespace {

using Key = std::pair<std::uint64_t, std::int32_t>;

/// Sorts by the keys alone, digit by digit; equal ones stay in their order.
void sortByKey(std::vector<Key>& keys, int keyBits) {
  constexpr int kDigit = 10;  // bits
  std::vector<Key> sorted(keys.size());
  for (int shift = 0; shift < keyBits; shift += kDigit) {
    std::array<std::size_t, 1 << kDigit> next{};
    const auto digitOf = [shift](const Key& key) {
      return static_cast<std::size_t>(key.first >> shift & ((1 << kDigit) - 1));
    };
    for (const Key& key : keys) ++next[digitOf(key)];
    std::exclusive_scan(next.begin(), next.end(), next.begin(), std::size_t{0});
    for (const Key& key : keys) sorted[next[digitOf(key)]++] = key;
    keys.swap(sorted);
  }
}

/// Every third bit of the result from the lowest 20 bits of `x`.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffffull;
  x = (x | x << 16) & 0x1f0000ff0000ffull;
  x = (x | x << 8) & 0x100f00f00f00f00full;
  x = (x | x << 4) & 0x10c30c30c30c30c3ull;
  return (x | x << 2) & 0x1249249249249249ull;
}

}  // namespace

std::vector<std::int32_t> spatialOrder(std::span<const Vec3> points) {
  Box3 box;
  for (const Vec3& point : points) {
    if (point.allFinite())
      box.extend(point);
  }
  const double size = std::max(box.size().maxCoeff(), 1e-300);
  std::vector<Key> keys;
  keys.reserve(points.size());
  for (const Vec3& point : points) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3 && point.allFinite(); ++axis) {
      const double place = (point[axis] - box.min[axis]) / size * 1048575;
      key |= spread(static_cast<std::uint64_t>(std::clamp(place, 0.0, 1048575.0))) << axis;
    }
    keys.emplace_back(key, static_cast<std::int32_t>(keys.size()));
  }
  sortByKey(keys, 3 * 20);
  std::vector<std::int32_t> order;
  order.reserve(keys.size());
  for (const auto& [key, index] : keys) order.push_back(index);
  return order;
}

MeshOrder reorderInSpace(std::vector<Vec3>& vertices, std::vector<Tet>& tets) {
  MeshOrder order{spatialOrder(vertices), {}};
  std::vector<Vec3> centres;
  centres.reserve(tets.size());
  for (const Tet& tet : tets) {
    Vec3& centre = centres.emplace_back(Vec3::Zero());
    for (const std::int32_t v : tet) centre += 0.25 * vertices[static_cast<std::size_t>(v)];
  }
  order.tetFrom = spatialOrder(centres);
  std::vector<Vec3> movedVertices;
  movedVertices.reserve(vertices.size());
  std::vector<std::int32_t> to(vertices.size());
  for (const std::int32_t from : order.vertexFrom) {
    to[static_cast<std::size_t>(from)] = static_cast<std::int32_t>(movedVertices.size());
    movedVertices.push_back(vertices[static_cast<std::size_t>(from)]);
  }
  std::vector<Tet> movedTets;
  movedTets.reserve(tets.size());
  for (const std::int32_t from : order.tetFrom) {
    Tet& tet = movedTets.emplace_back(tets[static_cast<std::size_t>(from)]);
    for (std::int32_t& v : tet) v = to[static_cast<std::size_t>(v)];
  }
  vertices.swap(movedVertices);
  tets.swap(movedTets);
  return order;
}

}  // namespace volute
