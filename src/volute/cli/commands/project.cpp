// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/project.hpp"

#include <algorithm>
#include <cmath>

#include "volute/capture/geometry_check.hpp"
#include "volute/capture/image_name.hpp"
#include "volute/cli/capture_input.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/overwriting.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/io/image_file.hpp"
#include "volute/media/volume/volume_input.hpp"

namespace volute::cli {
namespace {

/// An open volume, and what stands in for what its file does not say.
struct Subject {
  std::unique_ptr<FrameSource> source;
  Basis basis = Basis::kTrilinear;
  std::vector<int> numbers;    ///< one a frame
  std::vector<int> positions;  ///< of the chosen frames
};

/// A .npy has no frame numbers; when it has as many frames as the capture states it has those.
std::vector<int> numbersOf(const std::string& path, const VolumeInfo& info,
                           const Capture& capture) {
  const bool counted = extensionOf(path) == ".npy";
  if (counted && capture.frames.size() == static_cast<std::size_t>(info.frames))
    return capture.frames;
  return info.frameNumbers;
}

Result<Subject> openSubject(const std::string& path, const Arguments& arguments,
                            const Capture& capture, Context& context) {
  InputOptions input;
  input.grid = arguments.find<std::string>("field").value_or("");
  input.usualGrid = "emission";  // light is projected, never what weakens it
  input.bounds = arguments.find<Box3>("bounds");
  input.partial = arguments.flag("partial");
  if (extensionOf(path) == ".npy" && !input.bounds) {
    if (capture.volume.bounds.empty()) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}: a .npy has no bounds, and the capture states no volume; state them with "
                  "--bounds X0,Y0,Z0,X1,Y1,Z1",
                  path);
    }
    input.bounds = capture.volume.bounds;
  }
  VOLUTE_ASSIGN(auto volume, openVolume(path, input, context));
  Subject subject;
  subject.source = std::move(volume.source);
  const VolumeInfo& info = subject.source->info();
  if (volume.reader)
    subject.basis = info.basis;
  if (const auto name = arguments.find<std::string>("basis"))
    subject.basis = *name == "box" ? Basis::kBox : Basis::kTrilinear;
  subject.numbers = numbersOf(path, info, capture);
  VolumeInfo numbered = info;
  numbered.frameNumbers = subject.numbers;
  VOLUTE_ASSIGN(
      subject.positions,
      selectPositions(numbered, arguments.find<FrameRange>("frames").value_or(FrameRange{})));
  return subject;
}

Status checkPattern(const ImageName& name, std::size_t cameras, std::size_t frames) {
  if (extensionOf(name.text()) != ".exr") {
    return fail(ErrorCode::kInvalidArgument,
                "--output: '{}' does not end in .exr, which holds linear values", name.text());
  }
  if (cameras > 1 && !name.hasCamera()) {
    return fail(
        ErrorCode::kInvalidArgument,
        "--output: pictures of {} cameras do not fit into '{}'; put {{camera}} into its name",
        cameras, name.text());
  }
  if (frames > 1 && !name.hasFrame()) {
    return fail(ErrorCode::kInvalidArgument,
                "--output: pictures of {} frames do not fit into '{}'; put %04d into its name",
                frames, name.text());
  }
  return {};
}

Status checkMemory(const VolumeInfo& info, const Context& context) {
  // The frame, its three channels with their places, and what the projector keeps of them.
  const std::uint64_t bytes = 4 * info.frameValues() + 48 * std::uint64_t{info.voxels()};
  if (bytes <= context.maxMemory)
    return {};
  return fail(
      ErrorCode::kTooLarge,
      "a frame of {} x {} x {} voxels needs {} MiB of memory, more than the {} MiB allowed; "
      "raise --max-memory",
      info.x, info.y, info.z, (bytes >> 20) + 1, context.maxMemory >> 20);
}

/// One channel becomes three.
std::vector<float> inColour(std::span<const float> values, int channels) {
  if (channels == 3)
    return {values.begin(), values.end()};
  std::vector<float> colour(3 * values.size());
  for (std::size_t i = 0; i < values.size(); ++i) std::fill_n(&colour[3 * i], 3, values[i]);
  return colour;
}

Status projectAll(Subject& subject, const Capture& capture, const ImageName& name, int rays,
                  Progress& progress) {
  const VolumeInfo& info = subject.source->info();
  const VolumeGeometry geometry{info.bounds, {info.x, info.y, info.z}};
  const double total = static_cast<double>(subject.positions.size() * capture.cameras.size());
  double done = 0;
  std::vector<float> values(info.frameValues());
  for (const int position : subject.positions) {
    VOLUTE_TRY(subject.source->readFrame(position, values));
    const int number = subject.numbers[static_cast<std::size_t>(position)];
    if (!std::ranges::all_of(values, [](float value) { return std::isfinite(value); }))
      return fail(ErrorCode::kInvalidData, "frame {}: has values that are not finite", number);
    const auto colour = inColour(values, info.channels);
    for (const CaptureCamera& camera : capture.cameras) {
      if (progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped: frame {}, camera {} was not written", number,
                    camera.name);
      const Image image = projectVolume(colour, geometry, subject.basis, camera.camera, rays);
      VOLUTE_TRY(writeImage(name.file(camera.name, number), image));
      progress.report("projecting", ++done, total);
    }
  }
  return {};
}

/// Also none of the capture's own pictures that are there, which cannot be taken again.
Status checkProjectTargets(const Subject& subject, const Capture& capture, const ImageName& name) {
  for (const CaptureCamera& camera : capture.cameras) {
    const PictureSource& own = camera.pictures;
    for (const int position : subject.positions) {
      const int number = subject.numbers[static_cast<std::size_t>(position)];
      const std::string target = name.file(camera.name, number);
      VOLUTE_TRY(checkTarget(target));
      const std::string picture = own.image.empty() ? "" : frameFile(own.image, number);
      for (const std::string& kept : {picture, own.background.string(), own.mask.string()}) {
        if (!kept.empty() && std::filesystem::exists(target) && isSameFile(target, kept)) {
          return fail(ErrorCode::kInvalidArgument,
                      "--output: {} is a picture of the capture (camera {}) and would be replaced; "
                      "give another name, or remove it first",
                      target, camera.name);
        }
      }
    }
  }
  return {};
}

Status runProject(const Arguments& arguments, Context& context) {
  VOLUTE_ASSIGN(const auto name, ImageName::parse(arguments.get<std::string>("output")));
  VOLUTE_ASSIGN(auto options, captureOptionsOf(arguments, context));
  options.frames = {};
  VOLUTE_ASSIGN(const auto capture, openCalibration(arguments.positional(1), options));
  remarkOn(capture, context);
  VOLUTE_ASSIGN(auto subject, openSubject(arguments.positional(0), arguments, capture, context));
  VOLUTE_TRY(checkPattern(name, capture.cameras.size(), subject.positions.size()));
  VOLUTE_TRY(checkProjectTargets(subject, capture, name));
  const VolumeInfo& info = subject.source->info();
  VOLUTE_TRY(checkMemory(info, context));
  Capture placed = capture;
  placed.volume = {info.bounds, {info.x, info.y, info.z}};
  for (const GeometryFault& fault : checkGeometry(placed)) context.progress.remark(fault.message);
  const int rays = arguments.get<std::string>("rays-per-pixel") == "1" ? 1 : 4;
  VOLUTE_TRY(projectAll(subject, capture, name, rays, context.progress));
  Report report;
  report.add("output", name.text());
  if (extensionOf(arguments.positional(0)) != ".npy")
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
      {.name = "output",
       .letter = 'o',
       .kind = kOutput,
       .value = "PATTERN.exr",
       .help = "the pictures: {camera} is the camera's name, %04d the frame",
       .required = true},
      {.name = "frames",
       .kind = kFrames,
       .value = "A:B[:S]",
       .help = "frames of the volume with numbers A <= n < B, every S-th"},
      {.name = "basis",
       .kind = kChoice,
       .value = "NAME",
       .help = "what the values mean between voxel centres; else what a .volute says, else "
               "trilinear, zero one voxel beyond the outer centres",
       .choices = {"trilinear", "box"}},
      {.name = "rays-per-pixel",
       .kind = kChoice,
       .value = "N",
       .help = "1 through the pixel's centre, or the mean of 4 at its quarters",
       .initial = "4",
       .choices = {"1", "4"}},
      fieldOption("which one of a file with several; else emission"),
      {.name = "partial", .help = "use what is intact of a damaged .volute"}};
  for (Option& option : captureOptionTable()) {
    if (option.name == "bounds")
      option.help =
          "outer voxel faces [m]: states those of a .npy, which has the capture's volume "
          "else; crops or pads others to them on the voxel grid";
    if (option.name == "images")
      option.help = "where cameras without a stated size or name find them, as for reconstruct";
    if (option.name != "color")
      options.push_back(option);
  }
  return {
      .name = "project",
      .summary = "Takes a volume's line integrals through the cameras of a capture",
      .examples =
          {"volute project fire.volute capture.json -o 'views/{camera}_%04d.exr'",
           "volute project truth_%04d.vdb transforms.json -o 'p_%04d_{camera}.exr' --images "
           "'in/frame_%04d_{camera}.exr'"},
      .description =
          "Writes one linear float EXR with R, G, B for each camera and frame: the integral of the "
          "values along each pixel's rays [value x metre], exact for the basis. This is what the "
          "cameras of a capture would see of the volume as light, without background. CAPTURE is a "
          "capture.json, a NeRF transforms.json, a COLMAP model's folder or OpenCV's .yml. A .npy "
          "with as many frames as the capture states has their numbers. Of a file with several "
          "grids "
          "it is `emission` unless --field names another; without one of that name, say which.",
      .positionals = {{.name = "VOLUME",
                       .help = "a volume: .volute, .npy, .vdb, .vti, .pvd, a pattern or a folder"},
                      {.name = "CAPTURE", .help = "the cameras"}},
      .options = std::move(options),
      .run = runProject};
}

}  // namespace volute::cli
