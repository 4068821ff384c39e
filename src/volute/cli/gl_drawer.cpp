// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/gl_drawer.hpp"

#include <cstdlib>

namespace volute::cli {

Status processorMayDraw(const char* what) {
  const char* cpu = std::getenv("VOLUTE_CPU_RENDERER");
  if (!cpu || std::string_view(cpu) != "off")
    return {};
  return fail(ErrorCode::kUnsupported,
              "{} is drawn by the processor, which VOLUTE_CPU_RENDERER=off forbids", what);
}

Result<SurfacePicture> GlDrawer::surfaces(const StillView& view, Progress& progress) {
  return gl_.surfaces(view.camera, subject_, view.still.geometry, view.still.lights, progress);
}

Result<SurfaceView> GlDrawer::walls(const StillView& view, std::size_t smoke) {
  const Still& still = view.still;
  Progress quiet;
  VOLUTE_ASSIGN(auto seen, gl_.walls(view.camera, still.smokes[smoke], still.lights,
                                     *still.walls[smoke], still.geometry, quiet));
  return SurfaceView{std::move(seen.depth), std::move(seen.color)};
}

Result<std::vector<SignPixel>> GlDrawer::findSigns(const StillView& view) {
  return gl_.findSigns(view.camera, view.still.signs, view.opaqueDepth);
}

Result<Image> GlDrawer::color(const StillView& view, const RenderOptions& options,
                              Progress& progress, RenderStats& stats) {
  return gl_.picture(view.camera, subject_, options, progress, stats, view.opaqueDepth);
}

Result<Image> GlDrawer::opticalDepth(const StillView& view, const RenderOptions& options,
                                     Progress& progress, RenderStats& stats) {
  GlSubject natural = subject_;
  natural.factor = 1;
  RenderOptions depths = options;
  depths.aov = Aov::kOpticalDepth;
  return gl_.picture(view.camera, natural, depths, progress, stats, view.opaqueDepth);
}

Status GlDrawer::addSigns(const StillView& view, std::span<const SignPixel>, const RenderOptions&,
                          Progress& progress, Image& image) {
  VOLUTE_ASSIGN(const auto light, gl_.signLight(view.camera, subject_, view.still.signs,
                                                view.still.law, progress, view.opaqueDepth));
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] += light.pixels[i];
  return {};
}

}  // namespace volute::cli
