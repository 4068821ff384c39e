// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "volute/gl/gl_passes.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/gl/gl_rays.hpp"
#include "volute/image/image.hpp"
#include "volute/render/sign.hpp"

namespace volute {

/// signPixels()' twin, and the deferred pass that shows signs through media. Under a lens a sign's
/// picture is not averaged over the pixel.
class SignPasses {
 public:
  /// Where signs are what the rays meet first.
  [[nodiscard]] Result<std::vector<SignPixel>> find(const Camera& camera,
                                                    std::span<const Sign> signs,
                                                    std::span<const float> opaqueDepth,
                                                    GlPasses& passes);

  /// What is seen of the signs found last: each through exp(-power depth), with the depths up to it
  /// in the fourth channel of a texture. @param powers  one for each sign
  [[nodiscard]] Result<Image> light(std::span<const float> powers, GLuint depths, GlPasses& passes);

 private:
  Status prepare(const Camera& camera);

  std::optional<GlProgram> find_, deferred_;
  int width_ = 0, height_ = 0;
  GlTexture opaque_, seen_, numbers_, light_;
};

}  // namespace volute
