// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/medium/medium.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

/// Smoke on a mesh at one time as a medium: extinction is linear in each tet, and so is the light
/// that smoke scatters towards the eye. Exact, in double, one segment at a time: for pictures of
/// large meshes, TetSplat is a thousand times faster.
class TetMedium {
 public:
  /// `extinction` [1/m], one for each vertex. `source`: radiance of infinitely thick smoke, linear
  /// RGB, three for each vertex; empty: black smoke. Both must be finite and >= 0.
  TetMedium(std::shared_ptr<const TetLocator> locator, std::vector<float> extinction,
            std::vector<float> source = {});

  Box3 bounds() const { return locator_->mesh().bounds(); }

  double extinction(const Vec3& point) const;
  Rgb emission(const Vec3& point) const;

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;

  /// One piece for each tet: linear extinction tau, quadratic emission E tau (Staubli et al. 2005,
  /// equations 3 to 5).
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

 private:
  Vec4 shares(std::int32_t tet, const Vec3& point) const;

  std::shared_ptr<const TetLocator> locator_;
  std::vector<float> extinction_;
  std::vector<float> source_;
};

}  // namespace volute
