// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/shared_options.hpp"

#include "volute/film/picture_writer.hpp"

namespace volute::cli {

Option outputOption(std::string_view value, std::string help, std::string_view derived) {
  return {.name = "output",
          .letter = 'o',
          .kind = ValueKind::kOutput,
          .value = value,
          .help = std::move(help),
          .derived = derived,
          .required = derived.empty()};
}

Option framesOption(std::string help, std::vector<std::string_view> kinds) {
  return {.name = "frames",
          .kind = ValueKind::kFrames,
          .value = "A:B[:S]",
          .help = std::move(help),
          .kinds = std::move(kinds)};
}

Option rateOption(std::string help, std::string initial, std::vector<std::string_view> aliases) {
  return {.name = "fps",
          .kind = ValueKind::kNumber,
          .value = "F",
          .help = std::move(help),
          .initial = std::move(initial),
          .most = 1e6,
          .positive = true,
          .fraction = true,
          .aliases = std::move(aliases)};
}

Option filesRateOption(std::vector<std::string_view> kinds) {
  Option option = rateOption(
      "frames per second: frame n is at (n - first) / F; if not given, the times that the files "
      "state, else 25");
  option.kinds = std::move(kinds);
  return option;
}

Option fieldOption(std::string help, std::vector<std::string_view> kinds) {
  return {.name = "field",
          .kind = ValueKind::kText,
          .value = "NAME",
          .help = std::move(help),
          .aliases = {"grid"},
          .kinds = std::move(kinds)};
}

Option fieldsOption(std::string help, std::vector<std::string_view> kinds) {
  Option option = fieldOption(std::move(help), std::move(kinds));
  option.value = "NAME[,NAME]";
  return option;
}

Option partialOption(std::vector<std::string_view> kinds) {
  return {.name = "partial",
          .help = "use the intact part of a damaged .volute",
          .kinds = std::move(kinds)};
}

Option rmsOption(std::string help, std::string initial) {
  return {.name = "rms",
          .kind = ValueKind::kNumber,
          .value = "R",
          .help = std::move(help),
          .initial = std::move(initial),
          .most = 1,
          .positive = true};
}

Option raysOption() {
  return {.name = "rays-per-pixel",
          .kind = ValueKind::kChoice,
          .value = "N",
          .help = "1: through the pixel's centre; 4: mean of four rays at its quarter points",
          .initial = "4",
          .choices = {"1", "4"}};
}

std::vector<Option> fileStyleOptions() {
  return {{.name = "film-bits",
           .kind = ValueKind::kChoice,
           .value = "N",
           .help = "bits of each channel of a film: 10 have smooth dark gradients, and not every "
                   "player shows them",
           .initial = "8",
           .choices = {"8", "10"}},
          {.name = "film-quality",
           .kind = ValueKind::kNumber,
           .value = "CRF",
           .help = "constant rate factor of a film's encoder, 0 (best, large) to 51; if not given, "
                   "16 for .mp4, 20 for .webm",
           .least = 0,
           .most = 51},
          {.name = "half",
           .help = "colours and alpha of .exr files as half floats, which take half the room and "
                   "are off by at most 1/2048, below 6e-5 by 3e-8; light beyond 65504 is cut off "
                   "and told; depths stay float32"}};
}

Status takeFileStyle(const Arguments& arguments, const std::string& target,
                     Development& development) {
  for (const char* name : {"film-bits", "film-quality"}) {
    if (arguments.given(name) && !isFilmPath(target))
      return fail(ErrorCode::kInvalidArgument, "--{} is for .mp4 and .webm; '{}' is none", name,
                  target);
  }
  development.half = arguments.flag("half");
  if (development.half && extensionOf(target) != ".exr")
    return fail(ErrorCode::kInvalidArgument, "--half is for .exr; '{}' is none", target);
  development.film.bits = arguments.get<std::string>("film-bits") == "10" ? 10 : 8;
  development.film.rateFactor = arguments.find<double>("film-quality");
  return {};
}

Option smokeMethodOption(std::string help, std::vector<std::string_view> kinds) {
  return {.name = "smoke-method",
          .kind = ValueKind::kChoice,
          .value = "NAME",
          .help = "how OpenGL draws smoke on a mesh without other media" + std::move(help),
          .initial = "auto",
          .choices = {"auto", "march", "projected"},
          .kinds = std::move(kinds)};
}

}  // namespace volute::cli
