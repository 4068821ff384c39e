// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/math/box.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// Four vertices' indices.
using Tet = std::array<std::int32_t, 4>;

/// A triangle between two tets, or on the boundary.
struct TetFace {
  std::array<std::int32_t, 3> vertices{};  ///< ascending: each edge runs from its lower vertex
  std::int32_t first = -1;   ///< half-face 4 * tet + k; k is the vertex of the tet across
  std::int32_t second = -1;  ///< the same of the other tet; -1 on the boundary
};

/// A conforming mesh of tetrahedra: neighbours share whole faces. May be non-convex, have holes
/// and several parts. Immutable; hold it by shared_ptr<const TetMesh>.
///
/// The vertices of each tet are kept in ascending order, whatever their order in the file.
class TetMesh {
 public:
  static constexpr std::int32_t kBoundary = -1;

  /// Checks everything: indices, finite coordinates, tets without volume (flatter than rounding),
  /// faces of three cells, vertices of no tet, two tets on the same side of a face. Messages begin
  /// with `name`, the file. At most 2^29 tets.
  [[nodiscard]] static Result<std::shared_ptr<const TetMesh>> build(std::vector<Vec3> vertices,
                                                                    std::vector<Tet> tets,
                                                                    std::string_view name);

  std::span<const Vec3> vertices() const { return vertices_; }

  std::span<const Tet> tets() const { return tets_; }

  std::span<const TetFace> faces() const { return faces_; }

  /// Indices into faces().
  std::span<const std::int32_t> boundary() const { return boundary_; }

  /// The half-face on the other side of half-face 4 * tet + k, or kBoundary.
  std::int32_t opposite(std::int32_t halfFace) const { return opposite_[halfFace]; }

  std::span<const std::int32_t> opposites() const { return opposite_; }

  const Box3& bounds() const { return bounds_; }

  double volume(std::int32_t tet) const;  ///< [m3], > 0

  /// The gradients [1/m] of the affine functions that are 1 at one vertex of a tet and 0 at the
  /// others. They sum to 0.
  std::array<Vec3, 4> slopes(std::int32_t tet) const;

  /// Those functions' values at a point: its barycentric coordinates, which sum to 1.
  std::array<double, 4> shares(std::int32_t tet, const Vec3& point) const;

 private:
  TetMesh() = default;
  Status linkFaces(std::string_view name);

  std::vector<Vec3> vertices_;
  std::vector<Tet> tets_;
  std::vector<TetFace> faces_;
  std::vector<std::int32_t> boundary_;
  std::vector<std::int32_t> opposite_;
  Box3 bounds_;
};

}  // namespace volute
