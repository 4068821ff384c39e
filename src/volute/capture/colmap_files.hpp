// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"

namespace volute {

/// A line of COLMAP's cameras file.
struct ColmapCamera {
  std::string model;  ///< "PINHOLE"
  int width = 0, height = 0;
  std::vector<double> parameters;
};

/// A line of COLMAP's images file: world to camera, as unit quaternion (w, x, y, z) and
/// translation.
struct ColmapImage {
  std::string name;
  std::array<double, 4> rotation{};
  Vec3 translation = Vec3::Zero();
  std::uint32_t camera = 0;
  std::string where;  ///< for messages
};

struct ColmapModel {
  std::map<std::uint32_t, ColmapCamera> cameras;
  std::vector<ColmapImage> images;  ///< in the order of the file
  std::vector<std::string> remarks;
};

/// Reads cameras and images as text or, when there is no text, as binary files from a model's
/// folder; beside a file of it, those of its ending. Errors name the file and the line or byte;
/// kTooLarge for more images than `maxMemory` [bytes] holds.
[[nodiscard]] Result<ColmapModel> readColmapFiles(const std::filesystem::path& path,
                                                  std::uint64_t maxMemory);

}  // namespace volute
