// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_contour.hpp"

#include <algorithm>
#include <unordered_map>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

/// Makes a surface's vertices, one for each edge of the mesh that crosses it.
class EdgePoints {
 public:
  EdgePoints(const TetMesh& mesh, std::span<const double> field, double level,
             std::span<const float> values, ContourSurface& surface)
      : mesh_(mesh), field_(field), level_(level), values_(values), surface_(surface) {}

  std::int32_t at(std::int32_t a, std::int32_t b) {
    if (a > b)
      std::swap(a, b);
    const std::uint64_t key = static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b);
    const auto [found, isNew] =
        known_.try_emplace(key, static_cast<std::int32_t>(surface_.vertices.size()));
    if (isNew)
      add(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
    return found->second;
  }

 private:
  void add(std::size_t a, std::size_t b) {
    const double share = (level_ - field_[a]) / (field_[b] - field_[a]);
    surface_.vertices.push_back((1 - share) * mesh_.vertices()[a] + share * mesh_.vertices()[b]);
    if (!values_.empty())
      surface_.values.push_back(static_cast<float>((1 - share) * values_[a] + share * values_[b]));
  }

  const TetMesh& mesh_;
  std::span<const double> field_;
  double level_;
  std::span<const float> values_;
  ContourSurface& surface_;
  std::unordered_map<std::uint64_t, std::int32_t> known_;
};

ContourSurface contour(const TetMesh& mesh, std::span<const double> field, double level,
                       std::span<const float> values) {
  VOLUTE_ASSERT(field.size() == mesh.vertices().size());
  VOLUTE_ASSERT(values.empty() || values.size() == field.size());
  ContourSurface surface;
  EdgePoints points(mesh, field, level, values, surface);
  for (const Tet& tet : mesh.tets()) {
    // Vertices below the level, then the others.
    Tet sorted = tet;
    const auto above = std::ranges::stable_partition(
        sorted, [&](std::int32_t v) { return field[static_cast<std::size_t>(v)] <= level; });
    const auto below = sorted.size() - above.size();
    if (below == 0 || below == 4)
      continue;
    const auto [a, b, c, d] = sorted;
    const auto add = [&](std::int32_t p, std::int32_t q, std::int32_t r) {
      const Vec3 &vp = surface.vertices[p], &vq = surface.vertices[q], &vr = surface.vertices[r];
      // The last vertex is above the level beyond doubt; it sees the back.
      const Vec3& upper = mesh.vertices()[static_cast<std::size_t>(d)];
      const bool front = (vq - vp).cross(vr - vp).dot(upper - vp) <= 0;
      surface.triangles.push_back(front ? std::array{p, q, r} : std::array{p, r, q});
    };
    if (below == 1) {
      add(points.at(a, b), points.at(a, c), points.at(a, d));
    } else if (below == 3) {
      add(points.at(a, d), points.at(b, d), points.at(c, d));
    } else {
      const std::int32_t ac = points.at(a, c), ad = points.at(a, d), bc = points.at(b, c),
                         bd = points.at(b, d);
      add(ac, ad, bd);
      add(ac, bd, bc);
    }
  }
  return surface;
}

}  // namespace

ContourSurface contourSurface(const TetMesh& mesh, std::span<const float> field, double level,
                              std::span<const float> values) {
  return contour(mesh, std::vector<double>(field.begin(), field.end()), level, values);
}

ContourSurface contourSlice(const TetMesh& mesh, const Vec3& normal, double offset,
                            std::span<const float> values) {
  std::vector<double> height;
  height.reserve(mesh.vertices().size());
  for (const Vec3& vertex : mesh.vertices()) height.push_back(normal.dot(vertex));
  return contour(mesh, height, offset, values);
}

}  // namespace volute
