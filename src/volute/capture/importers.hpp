// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/capture/capture.hpp"

// What the readers of calibrations give to openCapture(), which completes and checks it.

namespace volute {

/// A camera as its file has it.
struct CameraDraft {
  std::string name;         ///< empty: from pictureName and the pattern of the images
  std::string pictureName;  ///< as the calibration calls its picture; may be empty
  std::string where;        ///< for messages: "capture.json: cameras[3]"
  Calibration calibration;  ///< width and height 0: those of its pictures
  /// Over width and height [radians]; they give the focal lengths of K that are 0. 0: not stated.
  std::array<double, 2> angles{};
  /// Whether the principal point lies in the middle of a width and height that are not known yet.
  std::array<bool, 2> centred{};
  PictureSource pictures;  ///< paths are ready to open; no image: from the pattern of the images
  std::optional<double> framesPerSecond{};  ///< of its pictures
  double reprojectionError = 0;             ///< [pixels]; 0: not stated
  std::optional<int> filmLength{};          ///< how many pictures its film is said to have
  std::optional<double> startTime{};  ///< of its first picture [s], frame 0 of the capture at 0
  std::optional<double> time{};       ///< of its one picture, in any unit, where each has an entry
};

/// A capture whose cameras are not made yet.
struct CaptureDraft {
  std::string kind;
  Measured measured = Measured::kEmission;
  double pixelCentre = 0.5;
  std::vector<CameraDraft> cameras;
  std::optional<std::vector<int>> frames;
  std::optional<Box3> bounds;
  std::optional<std::array<int, 3>> resolution;
  std::optional<double> framesPerSecond{};
  double white = 1;
  std::optional<double> noiseSigma;
  std::vector<int> emptyFrames;
  CaptureSpectrum spectrum{};
  CaptureLighting lighting{};
  std::vector<Remark> remarks;
};

/// Volute's own format, "volute-capture-1" (docs/capture.md). Errors name the path in the JSON.
[[nodiscard]] Result<CaptureDraft> readCaptureJson(const std::filesystem::path& file,
                                                   const nlohmann::json& json);

/// transforms.json as NeRF tools write it: camera to world, x right, y up, z backward; pixel
/// centres at 0.5; intrinsics in each frame, or once for all.
[[nodiscard]] Result<CaptureDraft> readNerfTransforms(const std::filesystem::path& file,
                                                      const nlohmann::json& json);

/// info.json of filmed fluids (HyFluid, PINF): "train_videos" and "test_videos", each with a film,
/// its angle of view and its pose as in transforms.json; voxel_matrix and voxel_scale are the
/// bounds.
[[nodiscard]] Result<CaptureDraft> readFilmedFluid(const std::filesystem::path& file,
                                                   const nlohmann::json& json);

/// Makes one camera of the entries that have one pose and one lens, each with a picture of its own:
/// their names may differ by one number, which tells the frame. Where entries have times, these say
/// which pictures belong together. kInvalidData where cameras move, or names do not tell. Nothing
/// for entries that are cameras already.
[[nodiscard]] Status groupEntries(CaptureDraft& draft);

/// A COLMAP model: the folder with cameras and images as .txt or .bin, or one of these files, which
/// says which of both. Of a folder with both the .txt are read, which is remarked on. Pixel centres
/// at 0.5.
[[nodiscard]] Result<CaptureDraft> readColmap(const std::filesystem::path& path,
                                              std::uint64_t maxMemory);

/// OpenCV FileStorage, YAML, XML or JSON: matrices K_NAME, D_NAME, R_NAME, T_NAME for each camera,
/// world to camera; or what OpenCV's calibration and stereo samples write. Pixel centres at 0.
[[nodiscard]] Result<CaptureDraft> readOpenCv(const std::filesystem::path& file);

/// A geometry "cone_vec" of the ASTRA toolbox, its dictionary as JSON: for each projection source,
/// middle of the detector, and the steps from column to column and from row to row. Pixel centres
/// at 0.
[[nodiscard]] Result<CaptureDraft> readAstra(const std::filesystem::path& file,
                                             const nlohmann::json& json);

}  // namespace volute
