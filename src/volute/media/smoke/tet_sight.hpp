// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <vector>

#include "volute/media/sight.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

/// Smoke on tetrahedra at one time, extinction linear in each. The mesh's boundary is opaque:
/// a line that leaves it and comes back is blocked, and so is one through a thin wall. Sums are
/// exact.
///
/// A line is walked from tet to neighbour; where it meets an edge or a thin wall, or leaves the
/// mesh, the slow and simple TetLocator::crossings takes over.
class TetSightSnapshot final : public BasicSightSnapshot {
 public:
  /// `extinction` [1/m], one for each vertex, finite and >= 0. `geometry` is a number of the mesh's
  /// own, or 0.
  TetSightSnapshot(std::shared_ptr<const TetLocator> locator, std::vector<float> extinction,
                   std::uint64_t geometry = 0);

  void look(std::span<const SightLine> lines, std::span<Sight> sights) const override;
  void places(std::span<const Vec3> points, std::span<Place> places) const override;
  void extinction(std::span<const Vec3> points, std::span<double> extinction) const override;
  /// Thin walls are floors too.
  void floors(std::span<const Vec3> points, double drop, std::span<double> z) const override;

  /// Identity of the mesh's geometry.
  std::uint64_t geometry() const override { return geometry_; }

  void weigh(const SightLine& line, std::vector<SightWeight>& weights, Sight& sight) const override;

  SightData data() const override { return {extinction_, {}, {}}; }

  /// By crossings alone: what `look` is tested against.
  Sight lookSlowly(const SightLine& line) const;

 private:
  /// Calls visit(tet, begin, end) front to back. False where the way is not sure or leaves the mesh
  /// before the target.
  template <class Visit>
  bool walk(const Segment& segment, Visit&& visit) const;
  /// The same by crossings; sets `covered` and `blocked`.
  template <class Visit>
  void cross(const Segment& segment, Sight& sight, Visit&& visit) const;
  double valueAt(std::int32_t tet, const Vec3& point) const;

  std::shared_ptr<const TetLocator> locator_;
  std::vector<float> extinction_;
  std::uint64_t geometry_;
};

}  // namespace volute
