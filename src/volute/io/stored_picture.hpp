// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/remark.hpp"
#include "volute/base/result.hpp"
#include "volute/image/image.hpp"

namespace volute {

/// A picture of a camera as its file stores it.
struct StoredPicture {
  Image image;                   ///< integers / `largest`; floats as they are
  std::optional<Image> alpha{};  ///< 0 = transparent; one channel; nothing: it has none
  bool linear = false;           ///< floats, which are light
  double largest = 65535;        ///< the integer that is 1
  /// The light of evenly spaced stored values, 0 to 1, where the file states another curve than
  /// sRGB's.
  std::optional<std::vector<double>> curve{};
  /// Each pixel; 0: the file holds nothing for it (outside of a .exr's data window). Empty: it has
  /// all.
  std::vector<std::uint8_t> there{};
};

/// What is known of pictures before they are decoded.
struct PictureKind {
  bool linear = false;   ///< floats
  int pages = 1;         ///< pictures in the file: pages of a .tif
  int channels = 0;      ///< 1 or 3; 0: that is not known
  double largest = 0;    ///< the integer that is 1; 0: that is not known
  std::string stated{};  ///< how a .png or .tif says that it stores light: "sRGB", "gAMA 1", "an
                         ///< ICC profile"; empty: it does not
  /// The light of evenly spaced stored values, where that is stated and another curve than sRGB's.
  std::optional<std::vector<double>> curve{};
  std::vector<Remark> remarks{};  ///< what is not taken as the file says it
};

/// Reads a picture of a camera: .png and .exr; .tif (unsigned integers of 1 to 16 or of 32 bits, or
/// floats, in strips or tiles; confined, by libtiff); .pgm, .ppm, .pnm and .pfm; .npy of shape
/// (height, width) or (height, width, 3), of unsigned integers or floats.
/// @param page  of a file with several pictures, from 0
/// @param maxMemory  [bytes] that the pixels may take
[[nodiscard]] Result<StoredPicture> readStoredPicture(const std::filesystem::path& path,
                                                      std::uint64_t maxMemory, int page = 0);

/// @param page  of a file with several pictures, from 0
[[nodiscard]] Result<PictureKind> pictureKind(const std::filesystem::path& path,
                                              std::uint64_t maxMemory, int page = 0);

}  // namespace volute
