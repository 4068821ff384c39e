// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What the pictures of a RenderJob say about themselves.
#include <fmt/ranges.h>

#include "volute/cli/render_job.hpp"
#include "volute/scene/smoke_words.hpp"

namespace volute::cli {
namespace {

using Shows = SmokeContour::Shows;

/// What the smokes of a picture hold and how that becomes extinction, one for each.
std::vector<std::string> wordsOfSmokes(std::span<const SmokeLayer> smokes) {
  std::vector<std::string> words;
  for (const SmokeLayer& smoke : smokes) {
    words.push_back(fmt::format("field '{}': {}", smoke.fieldName(),
                                fmt::join(wordsOf(smoke.description().model), ", ")));
  }
  return words;
}

bool isSurface(const SmokeContour& contour) {
  return contour.kind == SmokeContour::Kind::kSurface;
}

bool showsVisibility(const SmokeContour& contour) {
  return isSurface(contour) || contour.shows == Shows::kVisibility;
}

/// Of a concentration: "of soot".
std::string_view counted(const SmokeModel& model) {
  return model.quantity == SmokeQuantity::kProductsDensity ? "of products" : "of soot";
}

std::string placeOf(const SmokeContour& slice) {
  return fmt::format("at {} = {:g} m", "xyz"[slice.axis], slice.place);
}

/// What a contour shows, in one line.
std::string lineOf(const SmokeContour& contour, const SmokeModel& model) {
  if (isSurface(contour))
    return fmt::format("isosurface: local visibility S = C/K = {:g} m, C = {:g}",
                       contour.visibility, contour.c);
  if (contour.shows == Shows::kVisibility)
    return fmt::format(
        "slice: local visibility S = C/K [m], C = {:g}, the last colour and more, {}", contour.c,
        placeOf(contour));
  if (contour.shows == Shows::kExtinction)
    return "slice: extinction K [1/m], natural logarithm, " + placeOf(contour);
  return fmt::format("slice: concentration {} [{}], {}", counted(model), unitOfConcentration(model),
                     placeOf(contour));
}

/// The same in short lines, for a legend.
std::vector<std::string> legendOf(const SmokeContour& contour, const SmokeModel& model) {
  if (isSurface(contour))
    return {"isosurface of visibility", fmt::format("S = C/K = {:g} m", contour.visibility),
            fmt::format("C = {:g}", contour.c)};
  if (contour.shows == Shows::kVisibility)
    return {"slice: visibility", fmt::format("S = C/K, C = {:g}", contour.c), placeOf(contour)};
  if (contour.shows == Shows::kExtinction)
    return {"slice: extinction K", placeOf(contour)};
  return {"slice: concentration", std::string(counted(model)), placeOf(contour)};
}

ColorScale scaleOf(const SmokeContour& slice, const SmokeModel& model) {
  return {colorMapOf(slice), slice.most, 0,
          slice.shows == Shows::kVisibility   ? "m or more"
          : slice.shows == Shows::kExtinction ? "1/m"
                                              : unitOfConcentration(model)};
}

/// Of a picture of a contour.
PictureText textOfContour(const SmokeContour& contour, std::span<const SmokeLayer> smokes,
                          bool legend, double time) {
  const SmokeModel& model = smokes.front().description().model;
  PictureText text;
  text.notes = {{"volute.mode", modeOf(contour)}, {"volute.shows", lineOf(contour, model)}};
  if (showsVisibility(contour))
    text.notes.emplace_back("volute.C", fmt::format("{:g}", contour.c));
  if (isSurface(contour))
    text.notes.emplace_back("volute.visibility", fmt::format("{:g} m", contour.visibility));
  text.notes.emplace_back("volute.smoke",
                          fmt::format("{}", fmt::join(wordsOfSmokes(smokes), "; ")));
  text.notes.emplace_back("volute.time", fmt::format("{:g} s", time));
  if (!legend)
    return text;
  text.legend = legendOf(contour, model);
  for (const SmokeLayer& smoke : smokes) {
    const auto words = wordsOf(smoke.description().model);
    text.legend.insert(text.legend.end(), words.begin(), words.end());
  }
  text.legend.push_back(fmt::format("t = {:.2f} s", time));
  if (!isSurface(contour))
    text.scale = scaleOf(contour, model);
  return text;
}

std::string shown(const RenderOptions& options) {
  if (options.aov == Aov::kOpticalDepth)
    return "optical depth (natural logarithm)";
  return options.aov == Aov::kTransmittance ? "transmittance" : "radiance";
}

}  // namespace

std::string modeOf(const SmokeContour& contour) {
  if (isSurface(contour))
    return "isosurface of local visibility";
  return fmt::format("slice of {}", contour.shows == Shows::kVisibility   ? "local visibility"
                                    : contour.shows == Shows::kExtinction ? "extinction"
                                                                          : "concentration");
}

PictureText RenderJob::textOf(const Moment& moment) const {
  if (contour)
    return textOfContour(*contour, smokes, legend, moment.time);
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
  // All in one: a picture's notes have different names.
  std::vector<std::string> held = wordsOfSmokes(smokes);
  for (const SmokeLayer& smoke : smokes) {
    const auto words = wordsOf(smoke.description().model);
    lines.insert(lines.end(), words.begin(), words.end());
  }
  for (const FdsLayer& fds : fdsCases) {
    const auto words = fds.words();
    held.insert(held.end(), words.begin(), words.end());
    lines.insert(lines.end(), words.begin(), words.end());
    if (fds.slice() != nullptr)
      text.scale = ColorScale{ColorMap::kViridis, fds.slice()->range()[1], fds.slice()->range()[0]};
  }
  if (!held.empty())
    text.notes.emplace_back("volute.smoke", fmt::format("{}", fmt::join(held, "; ")));
  lines.push_back(fmt::format("t = {:.2f} s", moment.time));
  if (legend)
    text.legend = std::move(lines);
  return text;
}

}  // namespace volute::cli
