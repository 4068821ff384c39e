// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>

#include "volute/camera/camera.hpp"
#include "volute/tetmesh/tet_locator.hpp"
#include "volute/tetmesh/tet_reference.hpp"

namespace volute {

/// Pictures of optical depth without sorting. Along a ray the extinction is a sum of ramps, one for
/// each face that is crossed, so that the depth up to t is a sum over the faces f crossed before t:
///   1/2 J_f |n_f . d| (t - t_f)^2
/// with J_f the jump of the gradient across the face along its normal n_f; the boundary brings the
/// field itself in and out, and an eye inside begins with its own tet's line. Faces without a jump,
/// as in clear air, cost nothing; new smoke costs one gradient a tet and one jump a face.
///
/// Float and SIMD, on all threads; |d alpha| <= 1e-4. The result does not depend on the number of
/// threads. Pixels whose ray meets an edge exactly are done by the slow twin.
class FaceSplat {
 public:
  explicit FaceSplat(std::shared_ptr<const TetLocator> locator);
  ~FaceSplat();
  FaceSplat(FaceSplat&&) noexcept;
  FaceSplat& operator=(FaceSplat&&) noexcept;

  /// [1/m], one for each vertex, finite and >= 0.
  void setExtinction(std::span<const float> extinction);

  /// One depth for each pixel, row by row from the top.
  void opticalDepth(const Camera& camera, OpaqueDepth opaque, std::span<float> depth);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace volute
