// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/tetmesh/tet_locator.hpp"
#include "volute/tetmesh/tet_reference.hpp"

namespace volute {

/// What TetMarcher has done, summed over all pictures.
struct TetMarchCounts {
  std::uint64_t steps = 0;     ///< tets crossed
  std::uint64_t entries = 0;   ///< rays entering the mesh
  std::uint64_t doubtful = 0;  ///< pixels left to the slow twin
};

/// Pictures of smoke in order: from face to face through the neighbours, packets of rays side by
/// side. A ray enters through each front boundary face of its pixel, or begins in the eye's tet,
/// and stops at the opaque surface or, when lit, once less than 1e-6 of the light passes. Sides are
/// decided by the edges alone, the same from both of their faces, so that no ray slips between two
/// tets; one that meets an edge exactly is done by the slow twin.
///
/// Float and SIMD, on all threads; |d alpha| <= 1e-5. Results do not depend on the number of
/// threads.
class TetMarcher {
 public:
  explicit TetMarcher(std::shared_ptr<const TetLocator> locator);
  ~TetMarcher();
  TetMarcher(TetMarcher&&) noexcept;
  TetMarcher& operator=(TetMarcher&&) noexcept;

  /// [1/m], one for each vertex, finite and >= 0.
  void setExtinction(std::span<const float> extinction);

  /// Radiance of infinitely thick smoke under the light at each vertex: linear RGB, three for each
  /// vertex, finite (Staubli et al. 2005, E in equation 3). Empty: black.
  void setSource(std::span<const float> source);

  /// One depth for each pixel, row by row from the top.
  void opticalDepth(const Camera& camera, OpaqueDepth opaque, std::span<float> depth);

  /// Four for each pixel: the light that smoke sends to the eye (linear RGB), and the transmittance
  /// to what is behind. `only`: one for each pixel, 0 where the picture is to stay as it is; empty:
  /// all pixels.
  void litColor(const Camera& camera, OpaqueDepth opaque, std::span<float> rgbt,
                std::span<const std::uint8_t> only = {});

  TetMarchCounts counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace volute
