// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_billboard.hpp"

#include <cmath>

#include "volute/gl/glsl_sources.hpp"

namespace volute {
namespace {

class SheetOnDevice final : public GlMedium {
 public:
  SheetOnDevice(const BillboardOptions& options, const Camera& view, GlTexture texture)
      : middle_(options.position),
        across_(view.right() / options.width),
        down_(view.down() / options.height),
        forward_(view.forward()),
        texture_(std::move(texture)) {}

  std::string key() const override { return "sheet"; }

  std::vector<ShaderPart> parts() const override { return {{"sheet.glsl", glsl::kSheet}}; }

  GlNature nature() const override { return {.constant = true, .points = 1}; }

  GlNeeds needs() const override { return {.textures = 1, .cells = 2, .roundsPerCell = 4}; }

  Box3 bounds() const override {
    const Vec3 half = Vec3::Constant(0.5 * std::hypot(1 / across_.norm(), 1 / down_.norm()));
    return {middle_ - half, middle_ + half};
  }

  void bind(const GlProgram& program, const std::string& prefix, const GlView& view,
            GlBindings& bindings) const override {
    program.set((prefix + "middle").c_str(), Vec3(middle_ - view.origin));
    program.set((prefix + "across").c_str(), across_);
    program.set((prefix + "down").c_str(), down_);
    program.set((prefix + "forward").c_str(), forward_);
    program.set((prefix + "texture").c_str(), bindings.texture);
    glBindTextureUnit(static_cast<GLuint>(bindings.texture++), texture_.name());
  }

 private:
  Vec3 middle_, across_, down_, forward_;
  GlTexture texture_;
};

}  // namespace

Result<std::unique_ptr<GlMedium>> BillboardPass::make(const BillboardOptions& options,
                                                      const Camera& view, GLuint drawn,
                                                      GlPasses& passes) {
  if (!program_) {
    const ShaderStage stage{GL_COMPUTE_SHADER, {{"billboard.glsl", glsl::kBillboard}}};
    VOLUTE_ASSIGN(program_, GlProgram::link({&stage, 1}));
  }
  GlTexture texture = makeTexture2d(GL_RGBA32F, view.width(), view.height());
  passes.run("billboard", "billboard", [&] {
    program_->set("drawn", 0);
    program_->set("byIntensity", options.alpha == BillboardAlpha::kIntensity ? 1 : 0);
    glBindTextureUnit(0, drawn);
    glBindImageTexture(0, texture.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    runOver(*program_, view.width(), view.height());
  });
  return std::make_unique<SheetOnDevice>(options, view, std::move(texture));
}

}  // namespace volute
