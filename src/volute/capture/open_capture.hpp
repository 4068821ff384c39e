// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/capture/capture.hpp"
#include "volute/grid/select_frames.hpp"

namespace volute {

/// What a calibration does not say, or says otherwise.
struct CaptureOptions {
  std::optional<std::string> images;  ///< files of all cameras: {camera}, and %04d or ####
  std::optional<Box3> bounds;         ///< outer voxel faces [m]
  /// Voxels on x, y, z. With zeros for y and z, x is for the longest side and voxels are cubes.
  std::optional<std::array<int, 3>> resolution;
  std::optional<Response> response;                  ///< of pictures of integers and films
  std::optional<double> noiseSigma;                  ///< see Capture::noiseSigma
  FrameRange frames;                                 ///< of those that there are
  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes] for one picture
};

/// Whether a file or folder is a capture, by its name; a .json by what is in it: one with cameras
/// that is no scene.
[[nodiscard]] Result<bool> isCapture(const std::filesystem::path& path);

/// Reads a capture of any kind: capture.json, NeRF transforms.json, a COLMAP model's folder (or one
/// of its files), OpenCV's .yml, .yaml or .json. Where frames are not stated they are those of
/// which any camera has a picture. Cameras without a stated size have that of their pictures.
/// Errors name the file and what in it is meant.
[[nodiscard]] Result<Capture> openCapture(const std::filesystem::path& file,
                                          const CaptureOptions& options);

/// Reads calibration alone, as openCapture, of whatever cameras there are; pictures, frames and a
/// volume need not be there. For `project`, which makes the pictures.
[[nodiscard]] Result<Capture> openCalibration(const std::filesystem::path& file,
                                              const CaptureOptions& options);

/// Passes on what was remarked on a capture, with its name.
void remarkOn(const Capture& capture, Progress& progress);

/// Voxels on x, y, z that are cubes as nearly as can be, `longest` on the longest side.
std::array<int, 3> cubicResolution(const Box3& bounds, int longest);

}  // namespace volute
