// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_scene_renderer.hpp"

#include <algorithm>
#include <cmath>

namespace volute {

Result<std::unique_ptr<GlSceneRenderer>> GlSceneRenderer::create(bool hardwareOnly,
                                                                 GlSmokeMethod method) {
  VOLUTE_ASSIGN(auto gl, HeadlessGl::create(hardwareOnly ? HeadlessGl::Wanted::kHardware
                                                         : HeadlessGl::Wanted::kAny));
  VOLUTE_ASSIGN(auto renderer, GlRenderer::create());
  return std::unique_ptr<GlSceneRenderer>(
      new GlSceneRenderer(std::move(gl), std::move(renderer), method));
}

Status GlSceneRenderer::begin(const View& view) {
  const GlSnapshotOptions options{.tables = true, .smokeMethod = method_};
  VOLUTE_ASSIGN(scene_, glSceneOf(view.snapshot, options));
  natural_ = scene_.scaled(1 / view.snapshot.law.factor());
  return {};
}

Result<SurfacePicture> GlSceneRenderer::surfaces(const View& view, Progress& progress) {
  const Snapshot& snapshot = view.snapshot;
  return renderer_.surfaces(view.camera,
                            {snapshot.geometry, snapshot.lights.lamps, snapshot.lights.ambient},
                            natural_, Rgb::Zero(), progress);
}

Result<SurfaceView> GlSceneRenderer::walls(const View& view, std::size_t medium) {
  VOLUTE_ASSIGN(const auto walls, glWallsOf(view.snapshot, medium));
  Progress quiet;
  VOLUTE_ASSIGN(auto seen, renderer_.walls(view.camera, walls, quiet));
  return SurfaceView{std::move(seen.depth), std::move(seen.color)};
}

Result<std::vector<SignPixel>> GlSceneRenderer::findSigns(const View& view) {
  return renderer_.findSigns(view.camera, view.snapshot.signs, view.opaqueDepth);
}

Result<Image> GlSceneRenderer::color(const View& view, const RenderOptions& options,
                                     Progress& progress, RenderStats& stats) {
  return renderer_.render(view.camera, scene_, options, progress, &stats, view.opaqueDepth);
}

Result<Image> GlSceneRenderer::opticalDepth(const View& view, const RenderOptions& options,
                                            Progress& progress, RenderStats& stats) {
  RenderOptions depths = options;
  depths.aov = Aov::kOpticalDepth;
  return renderer_.render(view.camera, natural_, depths, progress, &stats, view.opaqueDepth);
}

Status GlSceneRenderer::addSigns(const View& view, std::span<const SignPixel>,
                                 const RenderOptions&, Progress& progress, Image& image) {
  VOLUTE_TRY(renderer_.draw(view.camera, natural_, GlQuantity::kOpticalDepth, progress,
                            view.opaqueDepth));
  std::vector<float> powers;  // of e, of the depth
  for (const Sign& sign : view.snapshot.signs) {
    powers.push_back(static_cast<float>(
        -std::log(seenTransmittance(1, view.snapshot.law.mode, sign.c))));
  }
  VOLUTE_ASSIGN(const auto light, renderer_.signLight(powers));
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] += light.pixels[i];
  return {};
}

nlohmann::ordered_json GlSceneRenderer::stats() {
  for (const GlPassTime& pass : renderer_.takePasses()) {
    auto found = std::ranges::find_if(passes_, [&](const GlPassTime& other) {
      return other.name == pass.name && other.media == pass.media;
    });
    if (found == passes_.end())
      found = passes_.insert(passes_.end(), GlPassTime{pass.name, pass.media});
    found->times += pass.times;
    found->milliseconds += pass.milliseconds;
  }
  auto passes = nlohmann::ordered_json::array();
  for (const GlPassTime& pass : passes_) {
    passes.push_back({{"name", pass.name},
                      {"media", pass.media},
                      {"times", pass.times},
                      {"milliseconds", pass.milliseconds}});
  }
  nlohmann::ordered_json json = {
      {"device", gl_.device().renderer}, {"hardware", gl_.device().hardware}, {"passes", passes}};
  for (const auto& [way, counts] : renderer_.counts()) {
    for (const auto& [name, value] : counts) json[way][name] = value;
  }
  return json;
}

}  // namespace volute
