// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_scene_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_renderer.hpp"
#include "volute/gl/gl_snapshot.hpp"

namespace volute {

namespace {

class GlSceneRenderer final : public SceneRenderer {
 public:
  GlSceneRenderer(HeadlessGl gl, GlRenderer renderer, GlSmokeMethod method)
      : gl_(std::move(gl)), renderer_(std::move(renderer)), method_(method) {}

  std::string_view name() const override { return "gl"; }

  /// The device's name, and what it did, pass by pass.
  nlohmann::ordered_json stats() override;

 protected:
  Status begin(const View& view) override;
  Result<SurfacePicture> surfaces(const View& view, Progress& progress) override;
  Result<SurfaceView> walls(const View& view, std::size_t medium) override;
  Result<std::vector<SignPixel>> findSigns(const View& view) override;
  Result<Image> color(const View& view, const RenderOptions& options, Progress& progress,
                      RenderStats& stats) override;
  Result<Image> opticalDepth(const View& view, const RenderOptions& options, Progress& progress,
                             RenderStats& stats) override;
  Status addSigns(const View& view, std::span<const SignPixel> seen, const RenderOptions& options,
                  Progress& progress, Image& image) override;

 private:
  HeadlessGl gl_;  // first, so that it ends last
  GlRenderer renderer_;
  GlSmokeMethod method_;
  std::vector<GlPassTime> passes_;
  GlScene scene_, natural_;  ///< of the picture that is being taken
};

Status GlSceneRenderer::begin(const View& view) {
  const GlSnapshotOptions options{.tables = true, .smokeMethod = method_};
  VOLUTE_ASSIGN(scene_, glSceneOf(view.snapshot, options));
  natural_ = scene_.scaled(1 / view.snapshot.law.factor());
  return {};
}

Result<SurfacePicture> GlSceneRenderer::surfaces(const View& view, Progress& progress) {
  const SceneSnapshot& snapshot = view.snapshot;
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

Status GlSceneRenderer::addSigns(const View& view, std::span<const SignPixel>, const RenderOptions&,
                                 Progress& progress, Image& image) {
  VOLUTE_TRY(
      renderer_.draw(view.camera, natural_, GlQuantity::kOpticalDepth, progress, view.opaqueDepth));
  std::vector<float> powers;  // of e, of the depth
  for (const Sign& sign : view.snapshot.signs) {
    powers.push_back(
        static_cast<float>(-std::log(seenTransmittance(1, view.snapshot.law.mode, sign.c))));
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

}  // namespace

Result<std::unique_ptr<SceneRenderer>> createGlRenderer(bool hardwareOnly, GlSmokeMethod method) {
  VOLUTE_ASSIGN(auto gl, HeadlessGl::create(hardwareOnly ? HeadlessGl::Wanted::kHardware
                                                         : HeadlessGl::Wanted::kAny));
  VOLUTE_ASSIGN(auto renderer, GlRenderer::create());
  return std::make_unique<GlSceneRenderer>(std::move(gl), std::move(renderer), method);
}

}  // namespace volute
