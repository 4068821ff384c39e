// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>

#include "volute/capture/geometry_check.hpp"
#include "volute/cli/capture_input.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/io/image_file.hpp"
#include "volute/tomography/project_frames.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute::cli {
namespace {

/// A .npy has no frame numbers; when it has as many frames as the capture states it has those.
std::vector<int> numbersOf(const std::string& path, const VolumeInfo& info,
                           const Capture& capture) {
  const bool counted = isNumpyPath(path);
  if (counted && capture.frames.size() == static_cast<std::size_t>(info.frames))
    return capture.frames;
  return info.frameNumbers;
}

Result<ProjectedFrames> openSubject(const std::string& path, const Arguments& arguments,
                                    const Capture& capture, Context& context) {
  InputOptions input;
  input.grid = arguments.find<std::string>("field").value_or("");
  input.usualGrid = "emission";  // light is projected, never what weakens it
  input.bounds = arguments.find<Box3>("bounds");
  input.partial = arguments.flag("partial");
  if (isNumpyPath(path) && !input.bounds) {
    if (capture.volume.bounds.empty()) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}: a .npy has no bounds, and the capture states no volume; state them with "
                  "--bounds X0,Y0,Z0,X1,Y1,Z1",
                  path);
    }
    input.bounds = capture.volume.bounds;
  }
  VOLUTE_ASSIGN(auto volume, openVolume(path, input, context));
  VOLUTE_TRY(alongAxesOnly(volume, path, "such a volume is not projected"));
  ProjectedFrames subject;
  subject.source = std::move(volume.source);
  const VolumeInfo& info = subject.source->info();
  if (volume.reader)
    subject.basis = info.basis;
  if (const auto name = arguments.find<std::string>("basis"))
    subject.basis = *name == "box" ? Basis::kBox : Basis::kTrilinear;
  if (subject.basis == Basis::kCubic) {
    return fail(
        ErrorCode::kUnsupported,
        "{}: its values are cubic B-splines, which are not projected; use --basis trilinear", path);
  }
  subject.numbers = numbersOf(path, info, capture);
  VolumeInfo numbered = info;
  numbered.frameNumbers = subject.numbers;
  VOLUTE_ASSIGN(
      subject.positions,
      selectPositions(numbered, arguments.find<FrameRange>("frames").value_or(FrameRange{})));
  return subject;
}

Status runProject(const Arguments& arguments, Context& context) {
  VOLUTE_ASSIGN(const auto name, ImageName::parse(arguments.get<std::string>("output")));
  VOLUTE_ASSIGN(auto options, captureOptionsOf(arguments, context));
  options.frames = {};
  VOLUTE_ASSIGN(const auto capture, openCalibration(arguments.positional(1), options));
  remarkOn(capture, context.progress);
  VOLUTE_ASSIGN(auto subject, openSubject(arguments.positional(0), arguments, capture, context));
  VOLUTE_ASSIGN(const auto targets, projectedPictures(subject, capture, name));
  for (const std::string& target : targets) VOLUTE_TRY(checkTarget(target));
  const VolumeInfo& info = subject.source->info();
  Capture placed = capture;
  placed.volume = {info.bounds, {info.x, info.y, info.z}};
  for (const GeometryFault& fault : checkGeometry(placed))
    context.progress.remark({RemarkCode::kDoubtful, fault.message});
  const int rays = arguments.get<std::string>("rays-per-pixel") == "1" ? 1 : 4;
  VOLUTE_TRY(projectFrames(subject, capture, name, rays, context.maxMemory, context.progress));
  Report report;
  report.add("output", name.text());
  if (!isNumpyPath(arguments.positional(0)))
    report.add("grid", info.name);
  report.add("cameras", capture.cameras.size(), fmt::format("{}", capture.cameras.size()))
      .add("frames", subject.positions.size(), fmt::format("{}", subject.positions.size()))
      .add("basis", subject.basis == Basis::kBox ? "box" : "trilinear")
      .add("rays_per_pixel", rays, fmt::format("{}", rays));
  context.print(report);
  return {};
}

}  // namespace

Command projectCommand() {
  using enum ValueKind;
  std::vector<Option> options = {
      outputOption("PATTERN.exr",
                   "pictures to write: {camera} is the camera's name, %04d the frame"),
      framesOption("frames of the volume with numbers A <= n < B, every S-th"),
      {.name = "basis",
       .kind = kChoice,
       .value = "NAME",
       .help = "interpolation between voxel centres; if not given, that of the .volute, else "
               "trilinear (zero one voxel beyond the outer centres)",
       .choices = {"trilinear", "box"}},
      raysOption(),
      fieldOption("grid of a file with several; if not given, emission"),
      partialOption()};
  for (Option& option : captureOptionTable()) {
    if (option.name == "bounds")
      option.help =
          "outer voxel faces [m]: sets those of a .npy (if not given, the capture's volume), "
          "crops or pads others on the voxel grid";
    if (option.name == "images")
      option.help = "paths of the pictures, for cameras without a size or name, as for reconstruct";
    if (option.name != "color")
      options.push_back(option);
  }
  return {
      .name = "project",
      .summary = "Computes a volume's line integrals through the cameras of a capture",
      .examples =
          {"volute project fire.volute capture.json -o 'views/{camera}_%04d.exr'",
           "volute project truth_%04d.vdb transforms.json -o 'p_%04d_{camera}.exr' --images "
           "'in/frame_%04d_{camera}.exr'"},
      .description =
          "Writes one linear float EXR with R, G, B for each camera and frame: the integral of "
          "the values along each pixel's rays [value x metre], exact for the basis. This is what "
          "the cameras would see if the volume were light, without background. CAPTURE is a "
          "capture.json, a NeRF transforms.json, the folder of a COLMAP model or an OpenCV .yml. "
          "A .npy with as many frames as the capture gets the capture's frame numbers. In a file "
          "with several grids, `emission` is used unless --field names another.",
      .positionals = {{.name = "VOLUME",
                       .help = "a volume: .volute, .npy, .npz, .vdb, .vti, .pvd, .nc, .h5, .zarr, "
                               "a pattern or a folder"},
                      {.name = "CAPTURE", .help = "the cameras"}},
      .options = std::move(options),
      .run = runProject};
}

}  // namespace volute::cli
