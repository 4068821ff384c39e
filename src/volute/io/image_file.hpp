// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "volute/base/file_name.hpp"
#include "volute/base/result.hpp"
#include "volute/image/image.hpp"

namespace volute {

/// By the extension: .png or .exr.
inline bool isPicturePath(const std::filesystem::path& path) {
  return extensionOf(path) == ".png" || extensionOf(path) == ".exr";
}

/// How to read a picture.
struct ImageReadOptions {
  bool raw = false;  ///< PNG: stored value / maximum, without decoding; for maps and masks
  std::uint64_t maxMemory = std::uint64_t{1} << 30;  ///< [bytes] that the pixels may take
};

/// Reads a .png (8 or 16 bits, grey, RGB or palette; alpha is dropped; its values become linear
/// light of sRGB's primaries, by what it states: cICP, iCCP, sRGB, or gAMA and cHRM; else by sRGB)
/// or a .exr of one part (R, G, B, or Y, or a single channel of any name; half or float). Damaged
/// or truncated files are errors, and a .exr of several parts is kUnsupported.
[[nodiscard]] Result<Image> readImage(const std::filesystem::path& path,
                                      const ImageReadOptions& options = {});

/// The alpha channel of a .png or .exr, 0 = transparent, 1 = opaque, one channel; nothing when the
/// picture has none.
[[nodiscard]] Result<std::optional<Image>> readAlpha(const std::filesystem::path& path,
                                                     const ImageReadOptions& options = {});

/// The linear light of evenly spaced stored values, 0 to 1, where a picture states another curve
/// than sRGB's; nothing where it states that or none. The primaries that it states do not enter.
[[nodiscard]] Result<std::optional<std::vector<double>>> readStoredCurve(
    const std::filesystem::path& path);

/// Metadata of a picture, as names and texts in Latin letters: tEXt chunks of a .png, attributes
/// of a .exr.
using ImageNotes = std::vector<std::pair<std::string, std::string>>;

/// Writes a .png (8 bits, sRGB; values are clamped to 0..1) or a .exr (scan lines, float32, ZIP;
/// channels R, G, B, or Y).
[[nodiscard]] Status writeImage(const std::filesystem::path& path, const Image& image,
                                const ImageNotes& notes = {});

/// A named channel of a picture: "A", "Z", "transmittance.Y".
struct ImageChannel {
  std::string name;
  std::vector<float> values;  ///< shape (height, width)
};

/// Writes a .exr (scan lines, float32, ZIP) with channels of any names, which must differ.
[[nodiscard]] Status writeChannels(const std::filesystem::path& path, int width, int height,
                                   const std::vector<ImageChannel>& channels,
                                   const ImageNotes& notes = {});

/// Writes values 0..1 without conversion, as readImage() with `raw` reads them: a .png (16 bits,
/// linear, clamped to 0..1) or a .exr (float32).
[[nodiscard]] Status writeMap(const std::filesystem::path& path, const Image& map);

}  // namespace volute
