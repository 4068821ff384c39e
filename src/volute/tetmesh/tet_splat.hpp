// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>

#include "volute/camera/camera.hpp"
#include "volute/tetmesh/tet_locator.hpp"
#include "volute/tetmesh/tet_reference.hpp"

namespace volute {

/// Pictures of optical depth without sorting, tet by tet: the depths of a ray's tets may be summed
/// in any order. Inverse depths are affine over a picture, so that a tet is where two upper and two
/// lower bounds (or one and three) leave room between them; there the extinction's mean is that
/// of the middle. A ray along an edge gets nothing from the tets beside it, not the wrong thing:
/// there are no special cases.
///
/// Float and SIMD, on all threads; |d alpha| <= 1e-5. The result does not depend on the number of
/// threads.
class TetSplat {
 public:
  explicit TetSplat(std::shared_ptr<const TetLocator> locator);
  ~TetSplat();
  TetSplat(TetSplat&&) noexcept;
  TetSplat& operator=(TetSplat&&) noexcept;

  /// [1/m], one for each vertex, finite and >= 0.
  void setExtinction(std::span<const float> extinction);

  /// One depth for each pixel, row by row from the top.
  void opticalDepth(const Camera& camera, OpaqueDepth opaque, std::span<float> depth);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace volute
