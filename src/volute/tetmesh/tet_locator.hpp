// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "volute/medium/medium.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// An opaque triangle between tets that touch.
using ThinWall = std::array<Vec3, 3>;

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
  /// So near to a thin wall is on it [m].
  static constexpr double kOnWall = 1e-5;

  /// `walls` may be null: there are none.
  explicit TetLocator(std::shared_ptr<const TetMesh> mesh,
                      std::shared_ptr<const std::vector<ThinWall>> walls = nullptr);

  const TetMesh& mesh() const { return *mesh_; }

  /// Where a segment meets the first of the thin walls [m], its ends within kOnWall left out.
  std::optional<double> wallOn(const Segment& segment) const;

  /// Whether a point is on a thin wall.
  bool isOnWall(const Vec3& point) const;

  /// The tet that holds a point, borders included, or -1. Where several do, the first.
  std::int32_t find(const Vec3& point) const;

  /// All tets that a segment runs through, front to back, without overlap. A segment along a shared
  /// face gets one of the tets beside it.
  void crossings(const Segment& segment, std::vector<TetCrossing>& out) const;

  /// Whether the middle of tets lies in another one, by more than cells with warped faces do. Of up
  /// to 2^15 tets, spread over the mesh.
  TetOverlap overlap() const;

  /// A place where the mesh's boundary touches other tets and no thin wall stands: sight passes
  /// there. Of up to 2^15 faces, spread over the boundary.
  std::optional<Vec3> openContact() const;

 private:
  /// What is in each cell of the grid.
  struct Lists {
    std::vector<std::int64_t> begin;    // of each cell's
    std::vector<std::int32_t> entries;  // tets, or walls
  };

  template <class BoundsOf>
  Lists listsOf(std::size_t things, const BoundsOf& boundsOf) const;
  /// Calls visit(cell) for the cells along a segment, layer by layer, some repeatedly.
  template <class Visit>
  void forCellsAlong(const Segment& segment, const Interval& inside, const Visit& visit) const;
  /// Where a segment is in the bounds.
  Interval within(const Segment& segment) const;

  std::shared_ptr<const TetMesh> mesh_;
  std::shared_ptr<const std::vector<ThinWall>> walls_;  // null: none
  Box3 box_;
  std::array<int, 3> count_{};
  Vec3 cell_ = Vec3::Ones();
  Lists tets_, wallLists_;
};

}  // namespace volute
