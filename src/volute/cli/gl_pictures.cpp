// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/gl_pictures.hpp"

#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_renderer.hpp"

namespace volute::cli {
namespace {

class Pictures final : public GlPictures {
 public:
  Pictures(HeadlessGl gl, GlRenderer renderer)
      : gl_(std::move(gl)), renderer_(std::move(renderer)) {}

  Result<Image> picture(const Camera& camera, const GlSubject& subject,
                        const RenderOptions& options, Progress& progress, RenderStats& stats,
                        std::span<const float> opaqueDepth) override {
    GlScene scene;
    for (std::size_t i = 0; i < subject.layers.size(); ++i) {
      VolumeLayer& layer = subject.layers[i];
      VOLUTE_ASSIGN(auto slice, layer.sliceAt(subject.positions[i]));
      const Appearance& look = layer.appearance();
      const Placement& placement = look.placement;
      GlVolume volume{std::move(slice), look.emission, subject.factor * look.extinction};
      if (placement.turns())  // else its place is in the slice's bounds
        volume.turn = placement.turn, volume.offset = placement.offset;
      scene.volumes.push_back(std::move(volume));
    }
    for (const FogLayer& fog : subject.fogs) {
      if (fog.sunlit()) {
        return fail(ErrorCode::kUnsupported,
                    "fog that a sun lights is not rendered by OpenGL; use --renderer cpu");
      }
      if (subject.factor != 1) {
        return fail(ErrorCode::kUnsupported,
                    "fog in threshold mode is not rendered by OpenGL; use --renderer cpu");
      }
      scene.fogs.push_back(fog.fogAt(subject.time));
    }
    for (const SmokeState& smoke : subject.smokes) {
      GlSmoke shown{smoke.locator, smoke.extinction, smoke.source};
      for (float& value : shown.extinction) value = static_cast<float>(subject.factor * value);
      scene.smokes.push_back(std::move(shown));
    }
    return renderer_.render(camera, scene, options, progress, &stats, opaqueDepth);
  }

  nlohmann::ordered_json stats() override {
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
    return {
        {"device", gl_.device().renderer}, {"hardware", gl_.device().hardware}, {"passes", passes}};
  }

 private:
  HeadlessGl gl_;  // first, so that it ends last
  GlRenderer renderer_;
  std::vector<GlPassTime> passes_;
};

}  // namespace

Result<std::shared_ptr<GlPictures>> GlPictures::open(bool hardwareOnly) {
  VOLUTE_ASSIGN(auto gl, HeadlessGl::create(hardwareOnly ? HeadlessGl::Wanted::kHardware
                                                         : HeadlessGl::Wanted::kAny));
  VOLUTE_ASSIGN(auto renderer, GlRenderer::create());
  return std::make_shared<Pictures>(std::move(gl), std::move(renderer));
}

Result<Report> describeGl() {
  VOLUTE_ASSIGN(const auto gl, HeadlessGl::create());
  const GlDevice& device = gl.device();
  Report report;
  report.add("device", device.renderer)
      .add("vendor", device.vendor)
      .add("opengl", device.version)
      .add("shading_language", device.shadingLanguage)
      .add("hardware", device.hardware,
           device.hardware ? "yes" : "no: the processor draws, and --renderer auto means cpu");
  for (const auto& [name, value] : device.limits())
    report.add(name, value, fmt::format("{}", value));
  return report;
}

bool glIsLikely() {
  return graphicsHardwarePresent();
}

}  // namespace volute::cli
