// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>

#include "volute/fog/fog_shader.hpp"
#include "volute/gl/gl_medium.hpp"
#include "volute/gl/glsl_sources.hpp"

namespace volute {
namespace {

class FogOnDevice final : public GlMedium {
 public:
  FogOnDevice(FogShader shader, const FogMedium& fog)
      : shader_(std::move(shader)), color_(fog.options().color), degree_(fog.options().degree) {
    map_ = makeTexture2d(GL_R32F, shader_.width, shader_.height);
    glTextureSubImage2D(map_.name(), 0, 0, 0, shader_.width, shader_.height, GL_RED, GL_FLOAT,
                        shader_.texels.data());
  }

  std::string key() const override { return "fog " + shader_.walk; }

  std::vector<ShaderPart> parts() const override {
    return {{"fog_walk.glsl", shader_.walk}, {"fog_cells.glsl", glsl::kFogCells}};
  }

  GlNature nature() const override { return {.color = color_, .points = 4}; }

  void bind(const GlProgram& program, const std::string& prefix, const Vec3& eye, bool,
            GlBindings& bindings) const override {
    program.set((prefix + "fogCorner").c_str(), Vec3(shader_.corner - eye));
    program.set((prefix + "fogCell").c_str(), static_cast<float>(shader_.cell));
    program.set((prefix + "fogMu").c_str(), static_cast<float>(shader_.mu));
    program.set((prefix + "fogColor").c_str(), Vec3(color_));
    program.set((prefix + "fogMap").c_str(), bindings.texture);
    glBindTextureUnit(static_cast<GLuint>(bindings.texture++), map_.name());
  }

 private:
  FogShader shader_;
  Rgb color_;
  int degree_;
  GlTexture map_;
};

}  // namespace

Result<std::unique_ptr<GlMedium>> makeGlFog(const FogMedium& fog) {
  VOLUTE_ASSIGN(auto shader, fogShader(fog));
  return std::make_unique<FogOnDevice>(std::move(shader), fog);
}

}  // namespace volute
