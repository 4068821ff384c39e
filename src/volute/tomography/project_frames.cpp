// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/project_frames.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "volute/base/file_name.hpp"
#include "volute/io/image_file.hpp"
#include "volute/tomography/project.hpp"

namespace volute {
namespace {

Status checkPattern(const ImageName& name, std::size_t cameras, std::size_t frames) {
  if (extensionOf(name.text()) != ".exr") {
    return failFor("output", ErrorCode::kInvalidArgument,
                   "'{}' does not end in .exr, which holds linear values", name.text());
  }
  if (cameras > 1 && !name.hasCamera()) {
    return failFor("output", ErrorCode::kInvalidArgument,
                   "pictures of {} cameras do not fit into '{}'; put {{camera}} into its name",
                   cameras, name.text());
  }
  if (frames > 1 && !name.hasFrame()) {
    return failFor("output", ErrorCode::kInvalidArgument,
                   "pictures of {} frames do not fit into '{}'; put %04d into its name", frames,
                   name.text());
  }
  return {};
}

Status checkMemory(const VolumeInfo& info, std::uint64_t maxMemory) {
  // The frame, its three channels with their places, and what the projector keeps of them.
  const std::uint64_t bytes = 4 * info.frameValues() + 48 * std::uint64_t{info.voxels()};
  if (bytes <= maxMemory)
    return {};
  return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
              "a frame of {} x {} x {} voxels needs {} MiB of memory, more than the {} MiB allowed",
              info.x, info.y, info.z, (bytes >> 20) + 1, maxMemory >> 20);
}

/// One channel becomes three.
std::vector<float> inColour(std::span<const float> values, int channels) {
  if (channels == 3)
    return {values.begin(), values.end()};
  std::vector<float> colour(3 * values.size());
  for (std::size_t i = 0; i < values.size(); ++i) std::fill_n(&colour[3 * i], 3, values[i]);
  return colour;
}

}  // namespace

Result<std::vector<std::string>> projectedPictures(const ProjectedFrames& subject,
                                                   const Capture& capture, const ImageName& name) {
  VOLUTE_TRY(checkPattern(name, capture.cameras.size(), subject.positions.size()));
  std::vector<std::string> targets;
  for (const CaptureCamera& camera : capture.cameras) {
    const PictureSource& own = camera.pictures;
    for (const int position : subject.positions) {
      const int number = subject.numbers[static_cast<std::size_t>(position)];
      const std::string target = name.file(camera.name, number);
      const std::string picture = own.image.empty() ? "" : own.fileOf(number).string();
      for (const std::string& kept : {picture, own.background.string(), own.mask.string()}) {
        if (!kept.empty() && std::filesystem::exists(target) && isSameFile(target, kept)) {
          return failFor("output", ErrorCode::kInvalidArgument,
                         "{} is a picture of the capture (camera {}) and would be replaced; "
                         "give another name, or remove it first",
                         target, camera.name);
        }
      }
      targets.push_back(target);
    }
  }
  return targets;
}

Status projectFrames(ProjectedFrames& subject, const Capture& capture, const ImageName& name,
                     int raysPerPixel, std::uint64_t maxMemory, Progress& progress) {
  VOLUTE_TRY(checkMemory(subject.source->info(), maxMemory));
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
      const Image image =
          projectVolume(colour, geometry, subject.basis, camera.camera, raysPerPixel);
      VOLUTE_TRY(writeImage(name.file(camera.name, number), image));
      progress.report("projecting", ++done, total);
    }
  }
  return {};
}

}  // namespace volute
