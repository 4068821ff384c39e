// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/still.hpp"

#include "volute/render/render.hpp"
#include "volute/render/scaled_medium.hpp"
#include "volute/render/surfaces.hpp"
#include "volute/scene/scene_geometry.hpp"
#include "volute/scene/surface_stack.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace volute {
namespace {

/// Lamps' light is always attenuated physically, whatever the picture's law.
std::vector<AnyMedium> physical(const Still& still, std::span<const AnyMedium> others) {
  std::vector<AnyMedium> media;
  const double factor = still.law.factor();
  for (const AnyMedium& other : others)
    media.push_back(factor == 1 ? other : AnyMedium(ScaledMedium(other, 1 / factor)));
  for (const SmokeState& smoke : still.smokes)
    media.emplace_back(TetMedium(smoke.locator, smoke.extinction));
  return media;
}

}  // namespace

Result<Image> Still::picture(const Camera& camera, SmokePictures& drawers,
                             Progress& progress) const {
  std::vector<AnyMedium> others = media;
  for (const MediumForCamera& make : viewed) {
    VOLUTE_ASSIGN(auto medium, make(camera));
    others.push_back(std::move(medium));
  }
  SurfaceStack surfaces(camera, background);
  if (!geometry.empty()) {
    const auto lit = physical(*this, others);
    VOLUTE_ASSIGN(auto seen, renderSurfaces(camera, {geometry, lights.lamps, lights.ambient, lit},
                                            Rgb::Zero(), progress));
    surfaces.add(SurfaceView{std::move(seen.depth), std::move(seen.color)});
  }
  for (std::size_t i = 0; i < smokes.size(); ++i) {
    if (!walls[i])
      continue;
    VOLUTE_ASSIGN(const auto seen,
                  lookAtWalls(camera, smokes[i], lights, *walls[i], blocksOf(geometry)));
    surfaces.add(seen);
  }
  const auto onSigns = signPixels(camera, signs, surfaces.depth());
  surfaces.add(onSigns);
  const SmokeScene scene{smokes, others, law, surfaces.depth()};
  RenderOptions options{.background = background, .behind = surfaces.color()};
  RenderStats stats;
  VOLUTE_ASSIGN(auto image, drawers.color(camera, scene, options, progress, stats));
  if (onSigns.empty())
    return image;
  VOLUTE_ASSIGN(const auto depth, drawers.opticalDepth(camera, scene, {}, progress, stats));
  addSigns(onSigns, signs, depth, law, image);
  return image;
}

}  // namespace volute
