// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/cli/render_job.hpp"
#include "volute/scene/smoke_walls.hpp"

// The part of a RenderJob that smoke, surfaces and signs have.

namespace volute::cli {
namespace {

/// All that is opaque, the nearest in each pixel; empty: nothing is.
class Surfaces {
 public:
  Surfaces(const Camera& camera, const Rgb& background)
      : camera_(camera), background_(background) {}

  void add(const SurfaceView& view) {
    begin();
    for (std::size_t i = 0; i < depth_.size(); ++i) {
      if (view.depth[i] < depth_[i])
        set(i, view.depth[i], &view.color.pixels[3 * i]);
    }
  }

  /// Signs are opaque, but seen through a law of their own: what they send is not added here.
  void add(std::span<const SignPixel> signs) {
    constexpr float kDark[3] = {};
    if (!signs.empty())
      begin();
    for (const SignPixel& sign : signs)
      set(static_cast<std::size_t>(sign.pixel), sign.distance, kDark);
  }

  std::span<const float> depth() const { return depth_; }

  const Image* color() const { return depth_.empty() ? nullptr : &color_; }

 private:
  void begin() {
    if (!depth_.empty())
      return;
    color_ = Image(camera_.width(), camera_.height(), 3);
    depth_.assign(color_.pixels.size() / 3, std::numeric_limits<float>::infinity());
    for (std::size_t i = 0; i < color_.pixels.size(); ++i)
      color_.pixels[i] = static_cast<float>(background_[static_cast<Eigen::Index>(i % 3)]);
  }

  void set(std::size_t pixel, float depth, const float* color) {
    depth_[pixel] = depth;
    std::copy_n(color, 3, &color_.pixels[3 * pixel]);
  }

  const Camera& camera_;
  Rgb background_;
  std::vector<float> depth_;
  Image color_;
};

std::string shown(const RenderOptions& options) {
  if (options.aov == Aov::kOpticalDepth)
    return "optical depth (natural logarithm)";
  return options.aov == Aov::kTransmittance ? "transmittance" : "radiance";
}

}  // namespace

Result<Image> RenderJob::pictureWithSmoke(double time, std::span<const AnyMedium> others,
                                          Progress& progress, RenderStats& found) {
  std::vector<SmokeState> states;
  {
    const Stopwatch watch(totals.slices);
    for (SmokeLayer& smoke : smokes) {
      VOLUTE_ASSIGN(auto state, smoke.at(time));
      states.push_back(std::move(state));
    }
  }
  Surfaces surfaces(camera, options.background);
  if (!geometry.empty()) {
    VOLUTE_ASSIGN(const auto view, viewOfGeometry(others, states, progress));
    surfaces.add(view);
  }
  for (std::size_t i = 0; i < smokes.size(); ++i) {
    if (!smokes[i].description().walls)
      continue;
    VOLUTE_ASSIGN(const auto walls, lookAtWalls(camera, states[i], smokes[i].lights(),
                                                *smokes[i].description().walls));
    surfaces.add(walls);
  }
  const auto seen = signPixels(camera, signs, surfaces.depth());
  surfaces.add(seen);
  const SmokeScene scene{states, others, law, surfaces.depth()};
  glSubject.smokes = states;
  if (options.aov != Aov::kNone) {
    VOLUTE_ASSIGN(auto depth, depthOf(scene, progress, found));
    for (float& value : depth.pixels) {
      if (options.aov == Aov::kTransmittance)
        value = static_cast<float>(std::exp(-law.factor() * value));
    }
    return depth;
  }
  RenderOptions before = options;
  before.behind = surfaces.color();
  VOLUTE_ASSIGN(auto image,
                gl ? gl->picture(camera, glSubject, before, progress, found, scene.opaqueDepth)
                   : smokePictures.color(camera, scene, before, progress, found));
  if (seen.empty())
    return image;
  RenderStats ofSigns;
  VOLUTE_ASSIGN(const auto depth, depthOf(scene, progress, ofSigns));
  addSigns(seen, signs, depth, law, image);
  return image;
}

Result<Image> RenderJob::depthOf(const SmokeScene& scene, Progress& progress, RenderStats& found) {
  if (!gl)
    return smokePictures.opticalDepth(camera, scene, options, progress, found);
  GlSubject natural = glSubject;
  natural.factor = 1;
  RenderOptions depths = options;
  depths.aov = Aov::kOpticalDepth;
  return gl->picture(camera, natural, depths, progress, found, scene.opaqueDepth);
}

PictureText RenderJob::textOf(const Moment& moment) const {
  PictureText text;
  const bool threshold = law.mode == PictureMode::kThreshold;
  const std::string mode(nameOf(law.mode));
  text.notes = {{"volute.mode", mode}, {"volute.shows", shown(options)}};
  if (threshold)
    text.notes.emplace_back("volute.C", fmt::format("{:g}", law.c));
  text.notes.emplace_back("volute.time", fmt::format("{:g} s", moment.time));
  std::vector<std::string> lines{threshold ? fmt::format("{}, C = {:g}", mode, law.c) : mode};
  if (options.aov != Aov::kNone)
    lines.push_back(shown(options));
  for (const SmokeLayer& smoke : smokes) {
    const SmokeModel& model = smoke.description().model;
    const std::string how =
        model.smokePotential && model.quantity == SmokeQuantity::kProductsDensity
            ? fmt::format("P = {:g} dB m2/g", *model.smokePotential)
            : fmt::format("Km = {:g} m2/kg", model.massExtinction);
    text.notes.emplace_back("volute.smoke", fmt::format("{}, {}", nameOf(model.quantity), how));
    lines.push_back(how);
  }
  for (const FdsLayer& fds : fdsCases) {
    text.notes.emplace_back("volute.smoke", "FDS, " + fds.source());
    lines.push_back("FDS, " + fds.source());
  }
  lines.push_back(fmt::format("t = {:.2f} s", moment.time));
  if (legend)
    text.legend = std::move(lines);
  return text;
}

}  // namespace volute::cli
