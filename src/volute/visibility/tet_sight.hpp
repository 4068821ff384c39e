// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <vector>

#include "volute/tetmesh/tet_locator.hpp"
#include "volute/visibility/sight_field.hpp"

namespace volute {

/// Smoke on tetrahedra at one instant, extinction linear in each. The mesh's boundary is opaque:
/// a line that leaves it and comes back is blocked. Sums are exact.
///
/// A line is walked from tet to neighbour; where it meets an edge, or leaves the mesh, the slow and
/// simple TetLocator::crossings takes over.
class TetInstant final : public SightInstant {
 public:
  /// `extinction` [1/m], one for each vertex, finite and >= 0.
  TetInstant(std::shared_ptr<const TetLocator> locator, std::vector<float> extinction);

  void look(std::span<const SightLine> lines, std::span<Sight> sights) const override;
  void places(std::span<const Vec3> points, std::span<Place> places) const override;
  void extinction(std::span<const Vec3> points, std::span<double> extinction) const override;

  /// By crossings alone: what `look` is tested against.
  Sight lookSlowly(const SightLine& line) const;

 private:
  bool walk(const SightLine& line, Sight& sight) const;
  double valueAt(std::int32_t tet, const Vec3& point) const;

  std::shared_ptr<const TetLocator> locator_;
  std::vector<float> extinction_;
};

}  // namespace volute
