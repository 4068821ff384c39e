// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>

#include "volute/camera/camera.hpp"
#include "volute/tetmesh/tet_locator.hpp"
#include "volute/tetmesh/tet_reference.hpp"

namespace volute {

/// Pictures of smoke tet by tet. Inverse depths are affine over a picture, so that a tet is where
/// two upper and two lower bounds (or one and three) leave room between them. A ray along an edge
/// gets nothing from the tets beside it, not the wrong thing: there are no special cases.
///
/// Optical depths are summed in any order. Lit smoke goes from front to back: the tets are sorted
/// once for an eye, however it turns, and each pixel knows up to where it has come. Where a tet
/// comes too late for a pixel, as may be behind walls, the pixel is left to TetMedium.
///
/// While an eye stands still, however it turns, its distances from the planes of the faces are kept
/// from its second picture on, and the order; while nothing moves, also where the tets are seen.
/// The pictures are the same, bit by bit.
///
/// Pixels whose rays end in the eye (an opaque depth of 0, perspective) are not asked for: they
/// keep what they have, or have no smoke.
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

  /// Radiance of infinitely thick smoke under the light at each vertex: linear RGB, three for each
  /// vertex, finite (Staubli et al. 2005, E in equation 3). Empty: black.
  void setSource(std::span<const float> source);

  /// One depth for each pixel, row by row from the top.
  void opticalDepth(const Camera& camera, OpaqueDepth opaque, std::span<float> depth);

  /// Four for each pixel: the light that smoke sends to the eye (linear RGB), and the transmittance
  /// to what is behind.
  void litColor(const Camera& camera, OpaqueDepth opaque, std::span<float> rgbt);

  /// Pixels of the last lit picture that were left to TetMedium.
  std::size_t leftOut() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace volute
