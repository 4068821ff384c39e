// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/gl_pictures.hpp"

#include <algorithm>
#include <cmath>

#include "volute/gl/gl_billboard.hpp"
#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_fds.hpp"
#include "volute/gl/gl_fog.hpp"
#include "volute/gl/gl_renderer.hpp"

namespace volute::cli {
namespace {

Result<GlVolume> volumeOf(VolumeLayer& layer, int position) {
  VOLUTE_ASSIGN(auto slice, layer.sliceAt(position));
  const Appearance& look = layer.appearance();
  const Placement& placement = look.placement;
  GlVolume volume{std::move(slice), look.emission, look.extinction};
  if (placement.turns())  // else its place is in the slice's bounds
    volume.turn = placement.turn, volume.offset = placement.offset;
  return volume;
}

Result<GlTreeVolume> treeVolumeOf(VolumeLayer& layer, int position) {
  VOLUTE_ASSIGN(auto tree, layer.treeAt(position));
  const Appearance& look = layer.appearance();
  const VolumeInfo& info = layer.info();
  GlTreeVolume volume{std::move(tree), position,      info.basis,
                      info.bounds,     look.emission, look.extinction};
  if (look.placement.turns())
    volume.turn = look.placement.turn, volume.offset = look.placement.offset;
  return volume;
}

/// A case at one time: its light takes long, and a picture with surfaces and signs asks thrice.
struct FdsInstant {
  const FdsLayer* layer = nullptr;
  double time = 0;
  FdsField smoke;
  std::optional<FdsFlame> fire;
};

Result<FdsInstant> instantOf(const FdsLayer& layer, double time) {
  VOLUTE_ASSIGN(auto smoke, layer.fieldAt(time));
  VOLUTE_ASSIGN(auto fire, layer.fireAt(time));
  return FdsInstant{&layer, time, std::move(smoke), std::move(fire)};
}

/// As the subject's law sees it.
Result<GlScene> sceneOf(const GlSubject& subject, std::vector<FdsInstant>& cases) {
  GlScene scene{.shade = subject.geometry};
  const auto add = [&](auto values) { scene.parts.push_back(glPart(std::move(values))); };
  for (std::size_t i = 0; i < subject.layers.size(); ++i) {
    if (subject.volumeMethod == GlVolumeMethod::kTree) {
      VOLUTE_ASSIGN(auto volume, treeVolumeOf(subject.layers[i], subject.positions[i]));
      add(std::move(volume));
      continue;
    }
    VOLUTE_ASSIGN(auto volume, volumeOf(subject.layers[i], subject.positions[i]));
    add(std::move(volume));
  }
  for (const FogLayer& fog : subject.fogs) {
    if (!fog.sunlit()) {
      add(GlFog{.fog = fog.fogAt(subject.time),
                .polar = [fog](const Camera& camera) { return fog.polarFor(camera); }});
      continue;
    }
    VOLUTE_ASSIGN(auto lit, fog.sunlitAt(subject.time));
    add(GlSunlitFog{std::move(lit)});
  }
  for (const SmokeState& smoke : subject.smokes)
    add(GlSmoke{smoke.locator, smoke.extinction, smoke.source, subject.smokeMethod});
  std::erase_if(cases, [&](const FdsInstant& one) { return one.time != subject.time; });
  for (const FdsLayer& layer : subject.fdsCases) {
    auto found = std::ranges::find(cases, &layer, &FdsInstant::layer);
    if (found == cases.end()) {
      VOLUTE_ASSIGN(auto made, instantOf(layer, subject.time));
      found = cases.insert(cases.end(), std::move(made));
    }
    add(GlFds{found->smoke, layer.description().model.scale});
    if (found->fire)
      add(GlFds{found->fire->heat(), 1, found->fire->colour()});
  }
  for (BillboardLayer& board : subject.billboards) {
    const int position = board.volume.positionAt(subject.time);
    VOLUTE_ASSIGN(auto volume, volumeOf(board.volume, position));
    add(GlBillboard{std::move(volume), board.options});
  }
  return scene.scaled(subject.factor);
}

class Pictures final : public GlPictures {
 public:
  Pictures(HeadlessGl gl, GlRenderer renderer)
      : gl_(std::move(gl)), renderer_(std::move(renderer)) {}

  Result<Image> picture(const Camera& camera, const GlSubject& subject,
                        const RenderOptions& options, Progress& progress, RenderStats& stats,
                        std::span<const float> opaqueDepth) override {
    VOLUTE_ASSIGN(const GlScene scene, sceneOf(subject, cases_));
    return renderer_.render(camera, scene, options, progress, &stats, opaqueDepth);
  }

  Result<SurfacePicture> surfaces(const Camera& camera, const GlSubject& subject,
                                  const TriangleScene& geometry, const SceneLights& lights,
                                  Progress& progress) override {
    GlSubject natural = subject;
    natural.factor = 1;  // lamps' light is always attenuated physically
    GlScene media;
    if (!lights.lamps.empty()) {
      VOLUTE_ASSIGN(media, sceneOf(natural, cases_));
    }
    return renderer_.surfaces(camera, {geometry, lights.lamps, lights.ambient}, media, Rgb::Zero(),
                              progress);
  }

  Result<SurfacePicture> walls(const Camera& camera, const SmokeState& smoke,
                               const SceneLights& lights, const Rgb& color,
                               const TriangleScene& blocks, Progress& progress) override {
    const GlWalls walls{{smoke.locator, &smoke.locator->mesh()},
                        {{glPart(GlSmoke{smoke.locator, smoke.extinction})}},
                        lights.lamps,
                        smoke.lampShares,
                        color,
                        lights.ambient,
                        blocks};
    return renderer_.walls(camera, walls, progress);
  }

  Result<std::vector<SignPixel>> findSigns(const Camera& camera, std::span<const Sign> signs,
                                           std::span<const float> opaqueDepth) override {
    return renderer_.findSigns(camera, signs, opaqueDepth);
  }

  Result<Image> signLight(const Camera& camera, const GlSubject& subject,
                          std::span<const Sign> signs, const PictureLaw& law, Progress& progress,
                          std::span<const float> opaqueDepth) override {
    GlSubject natural = subject;
    natural.factor = 1;
    VOLUTE_ASSIGN(const GlScene scene, sceneOf(natural, cases_));
    VOLUTE_TRY(renderer_.draw(camera, scene, GlQuantity::kOpticalDepth, progress, opaqueDepth));
    std::vector<float> powers;  // of e, of the depth
    for (const Sign& sign : signs)
      powers.push_back(static_cast<float>(-std::log(seenTransmittance(1, law.mode, sign.c))));
    return renderer_.signLight(powers);
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
    nlohmann::ordered_json json = {
        {"device", gl_.device().renderer}, {"hardware", gl_.device().hardware}, {"passes", passes}};
    for (const auto& [way, counts] : renderer_.counts()) {
      for (const auto& [name, value] : counts) json[way][name] = value;
    }
    return json;
  }

 private:
  HeadlessGl gl_;  // first, so that it ends last
  GlRenderer renderer_;
  std::vector<GlPassTime> passes_;
  std::vector<FdsInstant> cases_;
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
