// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What the pictures of a FilmJob say about themselves.
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

#include "volute/base/plain_number.hpp"
#include "volute/film/film_job.hpp"

namespace volute {
namespace {

using Shows = Contour::Shows;
using Mass = MediumInfo::Mass;

bool isSurface(const Contour& contour) {
  return contour.kind == Contour::Kind::kSurface;
}

bool showsVisibility(const Contour& contour) {
  return isSurface(contour) || contour.shows == Shows::kVisibility;
}

std::string placeOf(const Contour& slice) {
  return fmt::format("at {} = {} m", "xyz"[slice.axis], plainNumber(slice.place));
}

/// What a contour shows, in one line.
std::string lineOf(const Contour& contour, const Mass& mass) {
  if (isSurface(contour))
    return fmt::format("isosurface: local visibility S = C/K = {:g} m, C = {:g}",
                       contour.visibility, contour.c);
  if (contour.shows == Shows::kVisibility)
    return fmt::format(
        "slice: local visibility S = C/K [m], C = {:g}, the last colour and more, {}", contour.c,
        placeOf(contour));
  if (contour.shows == Shows::kExtinction)
    return "slice: extinction K [1/m], natural logarithm, " + placeOf(contour);
  return fmt::format("slice: concentration {} [{}], {}", mass.of, mass.unit, placeOf(contour));
}

/// The same in short lines, for a legend.
std::vector<std::string> legendOf(const Contour& contour, const Mass& mass) {
  if (isSurface(contour))
    return {"isosurface of visibility", fmt::format("S = C/K = {:g} m", contour.visibility),
            fmt::format("C = {:g}", contour.c)};
  if (contour.shows == Shows::kVisibility)
    return {"slice: visibility", fmt::format("S = C/K, C = {:g}", contour.c), placeOf(contour)};
  if (contour.shows == Shows::kExtinction)
    return {"slice: extinction K", placeOf(contour)};
  return {"slice: concentration", mass.of, placeOf(contour)};
}

ColorScale scaleOf(const Contour& slice, const Mass& mass) {
  return {colorMapOf(slice), slice.most, 0,
          slice.shows == Shows::kVisibility   ? "m or more"
          : slice.shows == Shows::kExtinction ? "1/m"
                                              : mass.unit};
}

/// What all media say of themselves, one after the other.
MediumText textOf(const Scene& scene, const Camera& camera) {
  MediumText all;
  for (const auto& medium : scene.media()) {
    MediumText text = medium->text(seenFrom(camera));
    std::ranges::move(text.marks, std::back_inserter(all.marks));
    all.notes.insert(all.notes.end(), text.notes.begin(), text.notes.end());
    all.legend.insert(all.legend.end(), text.legend.begin(), text.legend.end());
    if (text.scale)
      all.scale = text.scale;
  }
  return all;
}

/// Of a picture of a contour.
PictureText textOfContour(const Contour& contour, const Scene& scene, const Camera& camera,
                          bool legend, double time) {
  const auto holds = [](const auto& medium) { return medium->info().mass.has_value(); };
  const auto found = std::ranges::find_if(scene.media(), holds);
  const Mass mass = found == scene.media().end() ? Mass() : *(*found)->info().mass;
  const MediumText media = textOf(scene, camera);
  PictureText text;
  text.notes = {{"volute.mode", modeOf(contour)}, {"volute.shows", lineOf(contour, mass)}};
  if (showsVisibility(contour))
    text.notes.emplace_back("volute.C", fmt::format("{:g}", contour.c));
  if (isSurface(contour))
    text.notes.emplace_back("volute.visibility", fmt::format("{:g} m", contour.visibility));
  text.notes.emplace_back("volute.smoke", fmt::format("{}", fmt::join(media.notes, "; ")));
  text.notes.emplace_back("volute.time", fmt::format("{} s", plainNumber(time)));
  if (!legend)
    return text;
  text.legend = legendOf(contour, mass);
  text.legend.insert(text.legend.end(), media.legend.begin(), media.legend.end());
  text.legend.push_back(fmt::format("t = {:.2f} s", time));
  if (!isSurface(contour))
    text.scale = scaleOf(contour, mass);
  return text;
}

std::string shown(const RenderOptions& options) {
  if (options.aov == Aov::kOpticalDepth)
    return "optical depth (natural logarithm)";
  return options.aov == Aov::kTransmittance ? "transmittance" : "radiance";
}

}  // namespace

std::string modeOf(const Contour& contour) {
  if (isSurface(contour))
    return "isosurface of local visibility";
  return fmt::format("slice of {}", contour.shows == Shows::kVisibility   ? "local visibility"
                                    : contour.shows == Shows::kExtinction ? "extinction"
                                                                          : "concentration");
}

PictureText FilmJob::textOf(const FilmFrame& frame) const {
  if (contour)
    return textOfContour(*contour, scene, camera, legend, frame.time);
  PictureText text;
  const PictureLaw law = scene.law();
  const bool threshold = law.mode == PictureMode::kThreshold;
  const std::string mode(nameOf(law.mode));
  const std::string shows =
      layers.empty() ? shown(options) : fmt::format("{}", fmt::join(layers, ", "));
  text.notes = {{"volute.mode", mode}, {"volute.shows", shows}};
  if (threshold)
    text.notes.emplace_back("volute.C", fmt::format("{:g}", law.c));
  text.notes.emplace_back("volute.time", fmt::format("{} s", plainNumber(frame.time)));
  std::vector<std::string> lines{
      threshold ? fmt::format("{}, C = {:g}: 10 % of the light where visibility ends", mode, law.c)
                : mode + ": light as it is"};
  if (options.aov != Aov::kNone)
    lines.push_back(shown(options));
  const Camera now = cameraAt(frame);
  const MediumText media = volute::textOf(scene, now);
  // All in one: a picture's notes have different names.
  if (!media.notes.empty())
    text.notes.emplace_back("volute.smoke", fmt::format("{}", fmt::join(media.notes, "; ")));
  text.scale = media.scale;
  lines.insert(lines.end(), media.legend.begin(), media.legend.end());
  lines.push_back(fmt::format("t = {:.2f} s", frame.time));
  if (!legend)
    return text;
  text.legend = std::move(lines);
  for (const PlaceMark& mark : media.marks) {
    if (const auto pixel = now.project(mark.at))
      text.marks.push_back({*pixel, mark.text});
  }
  return text;
}

}  // namespace volute
