// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>

#include "volute/cli/render_job.hpp"
#include "volute/scene/smoke_walls.hpp"
#include "volute/scene/surface_stack.hpp"

// The part of a RenderJob that smoke, surfaces and signs have.

namespace volute::cli {
namespace {

/// Of a picture of a contour.
PictureText textOfContour(const SmokeContour& contour, bool legend, double time) {
  const bool surface = contour.kind == SmokeContour::Kind::kSurface;
  const bool visibility = contour.shows == SmokeContour::Shows::kVisibility;
  const std::string what =
      surface ? fmt::format("isosurface: local visibility S = C/K = {:g} m, C = {:g}",
                            contour.visibility, contour.c)
      : visibility
          ? fmt::format("slice: local visibility S = C/K [m], C = {:g}, the last colour and more",
                        contour.c)
          : std::string("slice: extinction K [1/m], natural logarithm");
  const std::string place =
      surface ? "" : fmt::format("at {} = {:g} m", "xyz"[contour.axis], contour.place);
  PictureText text;
  text.notes = {{"volute.shows", surface ? what : what + ", " + place},
                {"volute.time", fmt::format("{:g} s", time)}};
  if (!legend)
    return text;
  text.legend = {what, fmt::format("t = {:.2f} s", time)};
  if (!surface) {
    text.legend.insert(text.legend.begin() + 1, place);
    text.scale = ColorScale{ColorMap::kViridis, contour.most};
  }
  return text;
}

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
  if (contour)
    return lookAtContour(camera, states, *contour);
  SurfaceStack surfaces(camera, options.background);
  if (!geometry.empty()) {
    glSubject.smokes = states;
    VOLUTE_ASSIGN(const auto view, viewOfGeometry(others, states, progress));
    surfaces.add(view);
  }
  for (std::size_t i = 0; i < smokes.size(); ++i) {
    if (!smokes[i].description().walls)
      continue;
    const Rgb& color = *smokes[i].description().walls;
    if (gl) {
      VOLUTE_ASSIGN(auto seen, gl->walls(camera, states[i], lights, color, geometry, progress));
      surfaces.add(SurfaceView{std::move(seen.depth), std::move(seen.color)});
      continue;
    }
    VOLUTE_ASSIGN(const auto walls,
                  lookAtWalls(camera, states[i], smokes[i].lights(), color, smokes[i].blocks()));
    surfaces.add(walls);
  }
  VOLUTE_ASSIGN(const auto seen, findSigns(surfaces.depth()));
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
  VOLUTE_TRY(showSigns(seen, scene, progress, image));
  return image;
}

Result<std::vector<SignPixel>> RenderJob::findSigns(std::span<const float> opaqueDepth) {
  if (gl && !signs.empty())
    return gl->findSigns(camera, signs, opaqueDepth);
  return signPixels(camera, signs, opaqueDepth);
}

Status RenderJob::showSigns(std::span<const SignPixel> seen, const SmokeScene& scene,
                            Progress& progress, Image& image) {
  if (!gl) {
    RenderStats ofSigns;
    VOLUTE_ASSIGN(const auto depth, depthOf(scene, progress, ofSigns));
    addSigns(seen, signs, depth, law, image);
    return {};
  }
  VOLUTE_ASSIGN(const auto light,
                gl->signLight(camera, glSubject, signs, law, progress, scene.opaqueDepth));
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] += light.pixels[i];
  return {};
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
  if (contour)
    return textOfContour(*contour, legend, moment.time);
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
    const auto words = fds.words();
    text.notes.emplace_back("volute.smoke", fmt::format("{}", fmt::join(words, "; ")));
    lines.insert(lines.end(), words.begin(), words.end());
    if (fds.slice() != nullptr)
      text.scale = ColorScale{ColorMap::kViridis, fds.slice()->range()[1], fds.slice()->range()[0]};
  }
  lines.push_back(fmt::format("t = {:.2f} s", moment.time));
  if (legend)
    text.legend = std::move(lines);
  return text;
}

}  // namespace volute::cli
