// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/capture_input.hpp"

namespace volute::cli {
namespace {

/// "64" or "64,48,96".
Result<std::array<int, 3>> parseResolution(const std::string& text) {
  constexpr int kMax = 1 << 14;
  std::array<int, 3> voxels{};
  const auto parts = split(text, ',');
  bool right = parts.size() == 1 || parts.size() == voxels.size();
  for (std::size_t i = 0; right && i < parts.size(); ++i) {
    voxels[i] = parseInteger(parts[i]).value_or(0);
    right = voxels[i] >= 1 && voxels[i] <= kMax;
  }
  if (right)
    return voxels;
  return fail(ErrorCode::kInvalidArgument,
              "'{}' is not a resolution; expected N or NX,NY,NZ voxels, 1 to {}", text, kMax);
}

}  // namespace

std::vector<Option> captureOptionTable() {
  using enum ValueKind;
  return {
      {.name = "images",
       .kind = kText,
       .value = "PATTERN",
       .help = "paths of the pictures, if the calibration lacks them or to override it: "
               "{camera} is the camera's name, %04d or #### the frame"},
      {.name = "bounds",
       .kind = kBounds,
       .value = "X0,Y0,Z0,X1,Y1,Z1",
       .help = "outer faces of the volume [m]; if not given, those of the capture"},
      {.name = "color",
       .kind = kText,
       .value = "CURVE",
       .help =
           "how pictures of integers and films store light: linear, srgb or gamma:G; if not given, "
           "as in the capture, else srgb (floats are linear)"}};
}

Result<CaptureOptions> captureOptionsOf(const Arguments& arguments, const Context& context) {
  CaptureOptions options;
  options.images = arguments.find<std::string>("images");
  options.bounds = arguments.find<Box3>("bounds");
  options.frames = arguments.find<FrameRange>("frames").value_or(FrameRange{});
  options.maxMemory = context.maxMemory;
  if (const auto text = arguments.find<std::string>("resolution")) {
    VOLUTE_ASSIGN(options.resolution, ofOption("resolution", parseResolution(*text)));
  }
  if (const auto text = arguments.find<std::string>("color")) {
    VOLUTE_ASSIGN(options.response, ofOption("color", Response::byName(*text)));
  }
  return options;
}

}  // namespace volute::cli
