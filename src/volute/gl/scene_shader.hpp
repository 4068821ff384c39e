// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volute/gl/gl_medium.hpp"

namespace volute {

/// The compute shader that takes each pixel's ray through all these media together.
struct SceneShader {
  std::string key;  ///< shaders with the same key are the same
  std::vector<ShaderPart> parts;
};

/// What a scene's shader is for.
enum class GlQuantity { kLight, kOpticalDepth };

std::string sceneShaderKey(std::span<const std::unique_ptr<GlMedium>> media, GlQuantity quantity);

std::vector<ShaderPart> sceneShader(std::span<const std::unique_ptr<GlMedium>> media,
                                    GlQuantity quantity);

/// The prefix of a scene's medium.
std::string mediumPrefix(std::size_t index);

}  // namespace volute
