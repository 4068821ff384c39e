// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>

#include "volute/camera/camera.hpp"
#include "volute/grid/shaded_voxels.hpp"

namespace volute {

class GlPart;

/// ShadedVoxels' twin: a volume that is lit or burns, from two atlases of its bricks on the device.
/// Extinction and emission are uploaded once for each snapshot, scattered light again for each view
/// in which it differs.
struct GlShadedVolume {
  std::function<ShadedVoxels(const Camera& camera)> seenFrom;  ///< how it looks to a camera
  std::function<void()> prepare{};  ///< does what does not depend on the camera; may be empty
  double factor = 1;                ///< of what it absorbs and sends, as ScaledMedium has it
  Mat3 turn = Mat3::Identity();     ///< linear; its points are turned, then moved
  Vec3 offset = Vec3::Zero();       ///< [m]
};

std::shared_ptr<const GlPart> glPart(GlShadedVolume volume);

}  // namespace volute
