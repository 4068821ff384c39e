// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What the pictures of a RenderJob say about themselves.
#include "volute/cli/render_job.hpp"

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
