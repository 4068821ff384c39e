// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/still.hpp"

#include <cmath>

#include "volute/base/stopwatch.hpp"
#include "volute/render/scaled_medium.hpp"
#include "volute/scene/scene_geometry.hpp"
#include "volute/scene/surface_stack.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace volute {
namespace {

/// All that is opaque from a camera; what of signs is seen goes to `signs`.
Result<SurfaceStack> opaqueThings(StillView view, const Rgb& background, StillDrawer& drawer,
                                  Progress& progress, std::vector<SignPixel>& signs,
                                  StillCounts& counts) {
  const Still& still = view.still;
  SurfaceStack surfaces(view.camera, background);
  if (!still.geometry.empty()) {
    const Stopwatch watch(counts.surfaceMilliseconds);
    VOLUTE_ASSIGN(auto seen, drawer.surfaces(view, progress));
    counts.surfacePixels += seen.surfacePixels;
    counts.shadowRays += seen.shadowRays;
    surfaces.add(SurfaceView{std::move(seen.depth), std::move(seen.color)});
  }
  for (std::size_t i = 0; i < still.smokes.size(); ++i) {
    if (!still.walls[i])
      continue;
    VOLUTE_ASSIGN(const auto seen, drawer.walls(view, i));
    surfaces.add(seen);
  }
  if (!still.signs.empty()) {
    view.opaqueDepth = surfaces.depth();
    VOLUTE_ASSIGN(signs, drawer.findSigns(view));
    surfaces.add(signs);
  }
  return surfaces;
}

}  // namespace

AnyMedium seenBy(const PictureLaw& law, AnyMedium medium) {
  const double factor = law.factor();
  return factor == 1 ? std::move(medium) : AnyMedium(ScaledMedium(std::move(medium), factor));
}

Result<Image> Still::picture(const Camera& camera, const RenderOptions& options,
                             StillDrawer& drawer, Progress& progress, StillCounts* counts) const {
  StillCounts unheard;
  StillCounts& counted = counts ? *counts : unheard;
  std::vector<AnyMedium> all = media;
  if (drawer.drawsMedia()) {
    for (const MediumForCamera& make : viewed) {
      VOLUTE_ASSIGN(auto medium, make(camera));
      all.push_back(std::move(medium));
    }
  }
  StillView view{camera, *this, all};
  std::vector<SignPixel> onSigns;
  VOLUTE_ASSIGN(const SurfaceStack surfaces,
                opaqueThings(view, options.background, drawer, progress, onSigns, counted));
  view.opaqueDepth = surfaces.depth();
  if (options.aov != Aov::kNone) {
    VOLUTE_ASSIGN(auto depth, drawer.opticalDepth(view, options, progress, counted.render));
    for (float& value : depth.pixels) {
      if (options.aov == Aov::kTransmittance)
        value = static_cast<float>(std::exp(-law.factor() * value));
    }
    return depth;
  }
  RenderOptions before = options;
  before.behind = surfaces.color();
  VOLUTE_ASSIGN(auto image, drawer.color(view, before, progress, counted.render));
  if (!onSigns.empty())
    VOLUTE_TRY(drawer.addSigns(view, onSigns, options, progress, image));
  return image;
}

Result<SurfacePicture> ProcessorDrawer::surfaces(const StillView& view, Progress& progress) {
  const Still& still = view.still;
  // Lamps' light is always attenuated physically, whatever the picture's law.
  std::vector<AnyMedium> media;
  const double factor = still.law.factor();
  for (const AnyMedium& other : view.media)
    media.push_back(factor == 1 ? other : AnyMedium(ScaledMedium(other, 1 / factor)));
  for (const SmokeState& smoke : still.smokes)
    media.emplace_back(TetMedium(smoke.locator, smoke.extinction));
  const SurfaceScene scene{still.geometry, still.lights.lamps, still.lights.ambient, media};
  return renderSurfaces(view.camera, scene, Rgb::Zero(), progress);
}

Result<SurfaceView> ProcessorDrawer::walls(const StillView& view, std::size_t smoke) {
  const Still& still = view.still;
  return lookAtWalls(view.camera, still.smokes[smoke], still.lights, *still.walls[smoke],
                     blocksOf(still.geometry));
}

Result<std::vector<SignPixel>> ProcessorDrawer::findSigns(const StillView& view) {
  return signPixels(view.camera, view.still.signs, view.opaqueDepth);
}

Result<Image> ProcessorDrawer::color(const StillView& view, const RenderOptions& options,
                                     Progress& progress, RenderStats& stats) {
  return smoke_.color(view.camera, view.smokeScene(), options, progress, stats);
}

Result<Image> ProcessorDrawer::opticalDepth(const StillView& view, const RenderOptions& options,
                                            Progress& progress, RenderStats& stats) {
  return smoke_.opticalDepth(view.camera, view.smokeScene(), options, progress, stats);
}

Status ProcessorDrawer::addSigns(const StillView& view, std::span<const SignPixel> seen,
                                 const RenderOptions& options, Progress& progress, Image& image) {
  RenderStats ofSigns;
  VOLUTE_ASSIGN(const auto depth, opticalDepth(view, options, progress, ofSigns));
  volute::addSigns(seen, view.still.signs, depth, view.still.law, image);
  return {};
}

}  // namespace volute
