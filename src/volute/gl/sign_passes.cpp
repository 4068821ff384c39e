// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/sign_passes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "volute/gl/glsl_sources.hpp"
#include "volute/gl/texel.hpp"

namespace volute {
namespace {

constexpr float kNowhere = 3e38F;

std::vector<Box3> boundsOf(std::span<const Sign> signs) {
  std::vector<Box3> boxes;
  for (const Sign& sign : signs) {
    const Vec3 half = Vec3::Constant(0.5 * std::hypot(sign.width, sign.height));
    boxes.push_back({sign.position - half, sign.position + half});
  }
  return boxes;
}

/// As signs.glsl has them: what stands where, and the pictures one after the other.
void pack(std::span<const Sign> signs, const Vec3& origin, std::vector<Texel>& places,
          std::vector<Texel>& texels) {
  for (const Sign& sign : signs) {
    places.push_back(texel(sign.position - origin, sign.width));
    places.push_back(texel(sign.normal.normalized(), sign.height));
    places.push_back(texel(sign.right()));
    places.push_back(texel(sign.down()));
    const auto bits = [](std::size_t value) {
      return std::bit_cast<float>(static_cast<std::int32_t>(value));
    };
    const auto columns = static_cast<std::size_t>(sign.picture.width);
    const auto rows = static_cast<std::size_t>(sign.picture.height);
    places.push_back({bits(texels.size()), bits(columns), bits(rows), 0});
    for (std::size_t i = 0; i < columns * rows; ++i) {
      const float* from = &sign.picture.pixels[3 * i];
      texels.push_back({from[0], from[1], from[2], 0});
    }
  }
}

}  // namespace

Status SignPasses::prepare(const Camera& camera) {
  if (!find_) {
    const ShaderStage find{GL_COMPUTE_SHADER,
                           {{"ray.glsl", glsl::kRay}, {"signs.glsl", glsl::kSigns}}};
    VOLUTE_ASSIGN(find_, GlProgram::link({&find, 1}));
    const ShaderStage deferred{GL_COMPUTE_SHADER, {{"signs_deferred.glsl", glsl::kSignsDeferred}}};
    VOLUTE_ASSIGN(deferred_, GlProgram::link({&deferred, 1}));
  }
  if (width_ == camera.width() && height_ == camera.height())
    return {};
  width_ = camera.width(), height_ = camera.height();
  seen_ = makeTexture2d(GL_RGBA32F, width_, height_);
  light_ = makeTexture2d(GL_RGBA32F, width_, height_);
  numbers_ = makeTexture2d(GL_R32I, width_, height_);
  opaque_ = makeTexture2d(GL_R32F, width_, height_);
  return {};
}

Result<std::vector<SignPixel>> SignPasses::find(const Camera& camera, std::span<const Sign> signs,
                                                std::span<const float> opaqueDepth,
                                                GlPasses& passes) {
  VOLUTE_TRY(prepare(camera));
  const std::size_t pixels = static_cast<std::size_t>(width_) * height_;
  std::vector<Texel> seen(pixels);
  std::vector<std::int32_t> numbers(pixels);
  passes.run("signs", "signs", [&] {
    GlLens lens;
    if (!camera.distortion().none())
      lens = lensDirections(camera);
    if (!opaqueDepth.empty()) {
      std::vector<float> ends(opaqueDepth.begin(), opaqueDepth.end());
      for (float& end : ends) end = std::min(end, kNowhere);
      glTextureSubImage2D(opaque_.name(), 0, 0, 0, width_, height_, GL_RED, GL_FLOAT, ends.data());
    }
    std::vector<Texel> places, texels;
    const Vec3 origin = pictureOrigin(camera, boundsOf(signs));
    pack(signs, origin, places, texels);
    const GlBuffer placeBuffer = makeBuffer(places);
    const GlBuffer texelBuffer = makeBuffer(texels);
    bindRays(*find_, camera, origin,
             {.opaque = opaqueDepth.empty() ? 0 : opaque_.name(),
              .lens = lens.directions.name(),
              .rest = lens.rest.name()});
    find_->bindStorage("Signs", 0, placeBuffer);
    find_->bindStorage("Texels", 1, texelBuffer);
    find_->set("count", static_cast<int>(signs.size()));
    glBindImageTexture(1, seen_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(2, numbers_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32I);
    runOver(*find_, width_, height_);
    glGetTextureImage(seen_.name(), 0, GL_RGBA, GL_FLOAT,
                      static_cast<GLsizei>(pixels * sizeof(Texel)), seen.data());
    glGetTextureImage(numbers_.name(), 0, GL_RED_INTEGER, GL_INT,
                      static_cast<GLsizei>(pixels * sizeof(std::int32_t)), numbers.data());
  });
  std::vector<SignPixel> found;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (numbers[i] < 0)
      continue;
    const Texel& at = seen[i];
    found.push_back({static_cast<std::int32_t>(i), numbers[i], at[3], {at[0], at[1], at[2]}});
  }
  return found;
}

Result<Image> SignPasses::light(std::span<const float> powers, GLuint depths, GlPasses& passes) {
  Image image(width_, height_, 3);
  std::vector<Texel> texels(static_cast<std::size_t>(width_) * height_);
  passes.run("signs deferred", "signs", [&] {
    const GlBuffer buffer = makeBuffer(powers);
    deferred_->bindStorage("Powers", 0, buffer);
    const std::pair<const char*, GLuint> textures[] = {
        {"seen", seen_.name()}, {"numbers", numbers_.name()}, {"depths", depths}};
    GLuint unit = 0;
    for (const auto& [name, texture] : textures) {
      deferred_->set(name, static_cast<int>(unit));
      glBindTextureUnit(unit++, texture);
    }
    glBindImageTexture(0, light_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    runOver(*deferred_, width_, height_);
    glGetTextureImage(light_.name(), 0, GL_RGBA, GL_FLOAT,
                      static_cast<GLsizei>(texels.size() * sizeof(Texel)), texels.data());
  });
  for (std::size_t i = 0; i < texels.size(); ++i)
    std::copy_n(texels[i].begin(), 3, &image.pixels[3 * i]);
  return image;
}

}  // namespace volute
