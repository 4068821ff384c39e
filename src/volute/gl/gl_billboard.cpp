// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_billboard.hpp"

#include <cmath>

#include "volute/gl/gl_part.hpp"
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

  GlMediumTraits traits() const override { return {.constant = true, .points = 1}; }

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

/// VoxelMedium::bounds(): between voxels there is something half a voxel further out.
Box3 boundsOf(const BrickSlice& slice) {
  Box3 bounds = slice.bounds();
  if (slice.basis() == Basis::kBox)
    return bounds;
  const Vec3 half = 0.5 * bounds.size().cwiseQuotient(Vec3(slice.x(), slice.y(), slice.z()));
  bounds.min -= half, bounds.max += half;
  return bounds;
}

class BillboardPart final : public GlPart {
 public:
  explicit BillboardPart(GlBillboard board) : board_(std::move(board)) {}

  std::string name() const override { return "billboard"; }

  Result<std::unique_ptr<GlMedium>> medium(const GlPicture& picture) const override {
    const BillboardOptions& options = board_.options;
    if (!(options.width > 0) || !(options.height > 0) || options.rows < 1) {
      return fail(ErrorCode::kInvalidArgument,
                  "a billboard of {} x {} m with {} rows; expected a size of more than 0",
                  options.width, options.height, options.rows);
    }
    GlResources& resources = picture.resources;
    std::unique_ptr<GlMedium> shown[1];
    VOLUTE_ASSIGN(shown[0], glPart(board_.volume)->medium(picture));
    const Camera view = billboardView(boundsOf(*board_.volume.slice), picture.camera, options);
    VOLUTE_TRY(checkPictureSize(view, resources.device));
    const GlTexture drawn = makeTexture2d(GL_RGBA32F, view.width(), view.height());
    VOLUTE_TRY(march(view, shown, {.picture = drawn.name()}, name(), resources, picture.progress));
    VOLUTE_ASSIGN(const GlProgram* program,
                  resources.programs.get("billboard", name(), resources.passes, [] {
                    return std::vector<ShaderPart>{{"billboard.glsl", glsl::kBillboard}};
                  }));
    GlTexture texture = makeTexture2d(GL_RGBA32F, view.width(), view.height());
    resources.passes.run("billboard", name(), [&] {
      program->set("drawn", 0);
      program->set("byIntensity", options.alpha == BillboardAlpha::kIntensity ? 1 : 0);
      glBindTextureUnit(0, drawn.name());
      glBindImageTexture(0, texture.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
      runOver(*program, view.width(), view.height());
    });
    return std::make_unique<SheetOnDevice>(options, view, std::move(texture));
  }

  std::shared_ptr<const GlPart> scaled(double factor) const override {
    GlBillboard board = board_;
    board.volume.extinction *= factor;
    return glPart(std::move(board));
  }

 private:
  GlBillboard board_;
};

}  // namespace

std::shared_ptr<const GlPart> glPart(GlBillboard board) {
  return std::make_shared<BillboardPart>(std::move(board));
}

}  // namespace volute
