// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "volute/medium/medium.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// Where a segment is inside a tet.
struct TetCrossing {
  std::int32_t tet = -1;
  double begin = 0, end = 0;
};

/// Tets that lie in others too.
struct TetOverlap {
  double share = 0;           ///< of the volume of the tets that were tried, 0..1
  Vec3 first = Vec3::Zero();  ///< a place in two of them; of none if share is 0
};

/// Finds tets by place: a regular grid of lists. Knows nothing of adjacency, in double: the slow
/// twin of all that walks from face to face. Thread-safe.
class TetLocator {
 public:
  explicit TetLocator(std::shared_ptr<const TetMesh> mesh);

  const TetMesh& mesh() const { return *mesh_; }

  /// The tet that holds a point, borders included, or -1. Where several do, the first.
  std::int32_t find(const Vec3& point) const;

  /// All tets that a segment runs through, front to back, without overlap. A segment along a shared
  /// face gets one of the tets beside it.
  void crossings(const Segment& segment, std::vector<TetCrossing>& out) const;

  /// Whether the middle of tets lies in another one, by more than cells with warped faces do. Of up
  /// to 2^15 tets, spread over the mesh.
  TetOverlap overlap() const;

 private:
  std::shared_ptr<const TetMesh> mesh_;
  Box3 box_;
  std::array<int, 3> count_{};
  Vec3 cell_ = Vec3::Ones();
  std::vector<std::int64_t> begin_;    // of each cell's list
  std::vector<std::int32_t> entries_;  // tets
};

}  // namespace volute
