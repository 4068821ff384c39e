// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volute/gl/gl_medium.hpp"

namespace volute {

/// The quantity that a scene's shader computes.
enum class GlQuantity { kLight, kOpticalDepth };

/// Shaders with the same key are the same: it has the media's structure and none of their values.
std::string sceneShaderKey(std::span<const std::unique_ptr<GlMedium>> media, GlQuantity quantity);

/// The compute shader that takes each pixel's ray through all these media together.
std::vector<ShaderPart> sceneShader(std::span<const std::unique_ptr<GlMedium>> media,
                                    GlQuantity quantity);

/// Its uniform marchColor: emission / extinction, where that is one colour everywhere.
Rgb marchColor(std::span<const std::unique_ptr<GlMedium>> media);

/// The prefix of a scene's medium.
std::string mediumPrefix(std::size_t index);

}  // namespace volute
