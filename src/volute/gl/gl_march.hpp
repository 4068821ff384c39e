// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <string>

#include "volute/base/progress.hpp"
#include "volute/camera/camera.hpp"
#include "volute/gl/gl_rays.hpp"
#include "volute/gl/gl_resources.hpp"
#include "volute/gl/gl_scene.hpp"
#include "volute/gl/scene_shader.hpp"

namespace volute {

/// What is drawn, along which rays, and where it goes.
struct GlTarget {
  GlQuantity quantity = GlQuantity::kLight;
  GlRays rays{};
  std::span<const float> opaqueDepth{};  ///< the same as `rays.opaque`; empty where there is none
  std::span<const GlCut> cuts{};         ///< GlScene::cuts, of rays of a camera
  GLuint picture = 0;  ///< RGBA32F, of the camera's size at least: light and optical depth
};

/// Takes each pixel's ray through all these media together. kTooLarge, before anything is drawn,
/// for more than the device can go through; kCancelled between bands. Rays from the eye and no
/// others may begin inside of a mesh.
/// @param names  of the media, for the times of passes
[[nodiscard]] Status march(const Camera& camera, std::span<const std::unique_ptr<GlMedium>> media,
                           const GlTarget& target, const std::string& names, GlResources& resources,
                           Progress& progress);

/// kTooLarge for a picture that is larger than the device's textures.
[[nodiscard]] Status checkPictureSize(const Camera& camera, const GlDevice& device);

}  // namespace volute
