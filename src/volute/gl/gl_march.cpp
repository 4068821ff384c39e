// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_march.hpp"

#include <array>
#include <vector>

namespace volute {
namespace {

GlView viewOf(const Camera& camera, std::span<const std::unique_ptr<GlMedium>> media,
              const GlRays& rays) {
  if (rays.origins != 0)
    return {rays.from, std::nullopt};
  std::vector<Box3> bounds;
  for (const auto& medium : media) bounds.push_back(medium->bounds());
  GlView view{pictureOrigin(camera, bounds), std::nullopt};
  if (!camera.isOrthographic())
    view.eye = camera.eye();
  return view;
}

/// Beforehand, since drivers' own words are of no help, and one of them draws a wrong picture.
Status checkNeeds(std::span<const std::unique_ptr<GlMedium>> media, const GlDevice& device) {
  constexpr std::int64_t kRayTextures = GlBindings{}.texture;
  constexpr double kRoundsOfMixtures = 6;
  GlNeeds all;
  double rounds = 0;
  for (const auto& medium : media) {
    const GlNeeds needs = medium->needs();
    all.textures += needs.textures;
    all.storage += needs.storage;
    all.cells += needs.cells;
    rounds += needs.cells * (needs.roundsPerCell + (media.size() > 1 ? kRoundsOfMixtures : 0));
  }
  if (kRayTextures + all.textures > device.textureUnits || all.storage > device.storageBindings) {
    return fail(
        ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
        "{} media need {} textures and {} buffers at a time, the graphics device has {} and "
        "{}; render fewer",
        media.size(), kRayTextures + all.textures, all.storage, device.textureUnits,
        device.storageBindings);
  }
  if (rounds > device.loopRounds()) {
    return fail(
        ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
        "rays pass up to {:.0f} cells of these media, more than the software rasteriser '{}' "
        "can go through",
        all.cells, device.renderer);
  }
  return {};
}

/// As ray.glsl has them: what is shown has dot(xyz, place) <= w, in places from the origin.
Status bindCuts(const GlProgram& program, std::span<const GlCut> cuts, const Vec3& origin) {
  constexpr std::size_t kMaxCuts = 24;
  if (cuts.size() > kMaxCuts) {
    return fail(ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
                "{} planes clip the scene; OpenGL draws up to {}, a box counting 6", cuts.size(),
                kMaxCuts);
  }
  std::vector<std::array<float, 4>> planes;
  for (const GlCut& cut : cuts) {
    const Vec3 normal = cut.normal.normalized();
    planes.push_back({static_cast<float>(normal.x()), static_cast<float>(normal.y()),
                      static_cast<float>(normal.z()),
                      static_cast<float>(normal.dot(cut.point - origin))});
  }
  program.set("cuts", static_cast<int>(planes.size()));
  if (!planes.empty())
    program.set("cutPlanes", planes);
  return {};
}

}  // namespace

Status checkPictureSize(const Camera& camera, const GlDevice& device) {
  if (camera.width() <= device.largestTexture && camera.height() <= device.largestTexture)
    return {};
  return fail(ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
              "a picture of {} x {} pixels is larger than the {} a side that the graphics device "
              "has",
              camera.width(), camera.height(), device.largestTexture);
}

Status march(const Camera& camera, std::span<const std::unique_ptr<GlMedium>> media,
             const GlTarget& target, const std::string& names, GlResources& resources,
             Progress& progress) {
  VOLUTE_TRY(checkNeeds(media, resources.device));
  VOLUTE_ASSIGN(
      const GlProgram* program,
      resources.programs.get(sceneShaderKey(media, target.quantity), names, resources.passes,
                             [&] { return sceneShader(media, target.quantity); }));
  const GlView view = viewOf(camera, media, target.rays);
  bindRays(*program, camera, view.origin, target.rays);
  VOLUTE_TRY(bindCuts(*program, target.cuts, view.origin));
  program->set("marchColor", Vec3(marchColor(media)));
  GlBindings bindings;
  for (std::size_t i = 0; i < media.size(); ++i)
    media[i]->bind(*program, mediumPrefix(i), view, bindings);
  glBindImageTexture(0, target.picture, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  return resources.passes.run("march", names, [&] {
    return runInBands(*program, camera, resources.device.rowsAtOnce(camera.width()), progress);
  });
}

}  // namespace volute
