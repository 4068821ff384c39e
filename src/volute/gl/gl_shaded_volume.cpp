// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_shaded_volume.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <utility>

#include "volute/gl/gl_part.hpp"
#include "volute/gl/gl_voxels.hpp"
#include "volute/gl/glsl_sources.hpp"
#include "volute/grid/voxel_cells.hpp"
#include "volute/grid/voxel_march.hpp"

namespace volute {
namespace {

constexpr int kCornersSide = BrickSlice::kSide + 1;
constexpr std::size_t kCorners = std::size_t{kCornersSide} * kCornersSide * kCornersSide;

const float* valuesOf(const MarchGrid& grid, std::size_t brick) {
  return grid.values + brick * static_cast<std::size_t>(grid.brickStride);
}

/// Extinction, and emission where there is one.
struct GlShadedAtlas {
  GlBricks bricks;
  GlTexture values;
};

Result<GlShadedAtlas> makeShadedAtlas(const MarchGrid& grid) {
  GlShadedAtlas made;
  VOLUTE_ASSIGN(made.bricks,
                makeGlBricks(voxels::cellsOf(*grid.slice), kCornersSide, kCornersSide, grid));
  if (grid.emissionChannel < 0) {
    made.values = made.bricks.makeAtlas(GL_R32F);
    std::vector<float> texels(kCorners);
    fillAtlas<float>(made.bricks, made.values, GL_RED, GL_FLOAT, [&](std::size_t b) {
      const float* from = valuesOf(grid, b);
      for (float& texel : texels) texel = *std::exchange(from, from + grid.stride[0]);
      return texels.data();
    });
    return made;
  }
  made.values = made.bricks.makeAtlas(GL_RGBA32F);
  std::vector<std::array<float, 4>> texels(kCorners);
  fillAtlas<std::array<float, 4>>(made.bricks, made.values, GL_RGBA, GL_FLOAT, [&](std::size_t b) {
    const float* from = valuesOf(grid, b);
    for (std::size_t i = 0; i < kCorners; ++i) {
      texels[i] = {from[i], from[i + kCorners], from[i + 2 * kCorners], from[i + 3 * kCorners]};
    }
    return texels.data();
  });
  return made;
}

/// The light that a unit of extinction scatters, as packLight() has it.
struct GlShadedLight {
  GlTexture values;
};

GlShadedLight makeShadedLight(const MarchGrid& grid, const GlBricks& bricks) {
  GlShadedLight made{bricks.makeAtlas(GL_R32UI)};
  std::vector<std::uint32_t> texels(kCorners);
  const std::int32_t channel = grid.lightChannel * grid.channelStride;
  fillAtlas<std::uint32_t>(
      bricks, made.values, GL_RED_INTEGER, GL_UNSIGNED_INT, [&](std::size_t b) {
        const float* from = valuesOf(grid, b) + channel;
        for (std::uint32_t& texel : texels) {
          const float value = *std::exchange(from, from + grid.stride[0]);
          texel =
              std::bit_cast<std::uint32_t>(grid.oneColor ? packLight(Rgb::Constant(value)) : value);
        }
        return texels.data();
      });
  return made;
}

class ShadedMedium final : public GlMedium {
 public:
  ShadedMedium(const GlShadedVolume& volume, double extinction,
               std::shared_ptr<const MarchGrid> grid, std::shared_ptr<const GlShadedAtlas> atlas,
               std::shared_ptr<const GlShadedLight> light)
      : volume_(volume),
        extinction_(extinction),
        grid_(std::move(grid)),
        atlas_(std::move(atlas)),
        light_(std::move(light)) {}

  std::string key() const override {
    return fmt::format("shaded {} {}", emits() ? 4 : 1, light_ ? 1 : 0);
  }

  std::vector<ShaderPart> parts() const override {
    return {{"volume settings",
             fmt::format("#define M_CHANNELS {}\n#define M_VALUE {}\n#define M_TRILINEAR 1\n"
                         "#define M_SHADED 1\n#define M_LIT {}\n",
                         emits() ? 4 : 1, emits() ? "vec4" : "float", light_ ? 1 : 0)},
            {"volume_table.glsl", glsl::kVolumeTable},
            {"volume_shaded.glsl", glsl::kVolumeShaded},
            {"volume.glsl", glsl::kVolume}};
  }

  GlMediumTraits traits() const override {
    GlMediumTraits traits;
    if (!emits() && !light_)
      traits.color = Rgb::Zero();
    return traits;
  }

  /// The loop that reads a cell's corners reads their light too.
  GlNeeds needs() const override {
    return {.textures = light_ ? 3 : 2, .cells = atlas_->bricks.mostCells, .roundsPerCell = 12.1};
  }

  Box3 bounds() const override {
    return turnedBounds(atlas_->bricks.cells, volume_.turn, volume_.offset);
  }

  void bind(const GlProgram& program, const std::string& prefix, const GlView& view,
            GlBindings& bindings) const override {
    bindCells(program, prefix, view.origin, atlas_->bricks.cells, atlas_->bricks.range,
              volume_.factor, extinction_, volume_.turn, volume_.offset);
    const auto name = [&](const char* rest) { return prefix + rest; };
    const auto bindTexture = [&](const char* rest, const GlTexture& texture) {
      program.set(name(rest).c_str(), bindings.texture);
      glBindTextureUnit(static_cast<GLuint>(bindings.texture++), texture.name());
    };
    atlas_->bricks.bind(program, prefix, bindings);
    bindTexture("atlas", atlas_->values);
    if (!light_)
      return;
    bindTexture("light", light_->values);
    Vec3 scale;
    for (int c = 0; c < 3; ++c) {
      const double levels = grid_->oneColor ? kPackedLevels[c] : 1;
      scale[c] = grid_->lightScale[c] / (levels * levels);
    }
    program.set(name("lightScale").c_str(), scale);
  }

 private:
  bool emits() const { return grid_->emissionChannel >= 0; }

  GlShadedVolume volume_;
  double extinction_;
  std::shared_ptr<const MarchGrid> grid_;
  std::shared_ptr<const GlShadedAtlas> atlas_;
  std::shared_ptr<const GlShadedLight> light_;
};

class ShadedPart final : public GlPart {
 public:
  ShadedPart(GlShadedVolume volume, double extinction)
      : volume_(std::move(volume)), extinction_(extinction) {}

  std::string name() const override { return "lit volume"; }

  void prepare() const override {
    if (volume_.prepare)
      volume_.prepare();
  }

  Result<std::unique_ptr<GlMedium>> medium(const GlPicture& picture) const override {
    const std::shared_ptr<const MarchGrid> grid = volume_.seenFrom(picture.camera).march();
    if (!grid || !grid->fits) {
      return fail(ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
                  "a volume of large constant regions, or of more than 8 GiB, is not rendered by "
                  "OpenGL when it is lit");
    }
    VOLUTE_ASSIGN(auto atlas, picture.resources.upload<GlShadedAtlas>(
                                  grid->slice, name(), [&] { return makeShadedAtlas(*grid); }));
    std::shared_ptr<const GlShadedLight> light;
    if (grid->lightChannel >= 0) {
      VOLUTE_ASSIGN(light, picture.resources.upload<GlShadedLight>(
                               grid, name(), [&]() -> Result<GlShadedLight> {
                                 return makeShadedLight(*grid, atlas->bricks);
                               }));
    }
    return std::make_unique<ShadedMedium>(volume_, extinction_, grid, std::move(atlas),
                                          std::move(light));
  }

  std::shared_ptr<const GlPart> scaled(double factor) const override {
    return std::make_shared<ShadedPart>(volume_, extinction_ * factor);
  }

 private:
  GlShadedVolume volume_;
  double extinction_;  ///< of one unit of the values
};

}  // namespace

std::shared_ptr<const GlPart> glPart(GlShadedVolume volume) {
  const double extinction = volume.factor;
  return std::make_shared<ShadedPart>(std::move(volume), extinction);
}

}  // namespace volute
