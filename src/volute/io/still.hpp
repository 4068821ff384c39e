// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "volute/base/result.hpp"

namespace volute {

/// What a file of stills says of one of its pictures.
struct StillInfo {
  std::int32_t width = 0, height = 0;  ///< [pixels]
  std::int32_t channels = 1;           ///< 1 or 3, and one more with `alpha`
  std::int32_t bits = 0;               ///< of integers, 1 to 32; 0: floats
  std::int32_t pages = 1;              ///< pictures of full size in the file
  bool alpha = false;                  ///< the last channel is alpha
};

/// What a plug-in for stills offers. Used inside a child process (ReaderProcess), because damaged
/// files may crash such libraries.
struct StillPlugin {
  Result<StillInfo> (*describe)(const std::filesystem::path& file, int page);
  /// Shape (height, width, channels): integers / (2^bits - 1), floats as they are.
  Status (*read)(const std::filesystem::path& file, int page, std::span<float> values);
  /// The ICC profile; empty: there is none.
  Result<std::string> (*profile)(const std::filesystem::path& file, int page);
};

}  // namespace volute
