// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/image_file.hpp"

#include "volute/base/assert.hpp"
#include "volute/base/file_name.hpp"
#include "volute/io/frame_file.hpp"
#include "volute/io/image_formats.hpp"

namespace volute {

#if !VOLUTE_HAS_EXR
Result<Image> readExr(const std::filesystem::path& path, const ImageReadOptions&) {
  return fail(ErrorCode::kUnsupported,
              "{}: this build has no OpenEXR (VOLUTE_WITH_EXR=OFF); use .png", path.string());
}

Result<std::optional<Image>> readExrAlpha(const std::filesystem::path& path,
                                          const ImageReadOptions& options) {
  VOLUTE_TRY(readExr(path, options));
  return std::nullopt;
}

Result<FrameInfo> readFrameInfo(const std::filesystem::path& path) {
  VOLUTE_TRY(readExr(path, {}));
  return FrameInfo();
}

Result<Image> readFrameChannels(const std::filesystem::path& path, std::span<const FrameChannel>,
                                std::uint64_t) {
  return readExr(path, {});
}

Result<std::optional<Mat3>> srgbFromPrimaries(const FramePart&) {
  return std::nullopt;
}

Status writeFrame(const std::filesystem::path& path, const FramePixels&) {
  return writeExr(path, {}, {});
}

Status writeChannels(const std::filesystem::path& path, int, int, const std::vector<ImageChannel>&,
                     const ImageNotes&) {
  return writeExr(path, {}, {});
}

Status writeExr(const std::filesystem::path& path, const Image&, const ImageNotes&) {
  return fail(ErrorCode::kUnsupported,
              "{}: this build has no OpenEXR (VOLUTE_WITH_EXR=OFF); use .png", path.string());
}
#endif

Status checkImageSize(const std::filesystem::path& path, std::int64_t width, std::int64_t height,
                      int channels, std::uint64_t maxMemory) {
  constexpr std::int64_t kLongestSide = 1 << 20;
  const double bytes = 4.0 * static_cast<double>(width) * static_cast<double>(height) * channels;
  if (width < 1 || height < 1) {
    return fail(ErrorCode::kInvalidData, "{}: a picture of {} x {} pixels", path.string(), width,
                height);
  }
  if (width <= kLongestSide && height <= kLongestSide && bytes <= static_cast<double>(maxMemory))
    return {};
  if (width > kLongestSide || height > kLongestSide) {
    return fail(ErrorCode::kTooLarge,
                "{}: a picture of {} x {} pixels; expected sides of at most {}", path.string(),
                width, height, kLongestSide);
  }
  return fail(ErrorCode::kTooLarge,
              "{}: a picture of {} x {} pixels needs {:.0f} MiB, more than the {} MiB allowed",
              path.string(), width, height, bytes / (1 << 20), maxMemory >> 20);
}

Result<Image> readImage(const std::filesystem::path& path, const ImageReadOptions& options) {
  if (extensionOf(path) == ".png")
    return readPng(path, options);
  if (extensionOf(path) == ".exr")
    return readExr(path, options);
  return fail(ErrorCode::kUnsupported, "{}: not a known kind of picture; expected .png or .exr",
              path.string());
}

Result<std::optional<Image>> readAlpha(const std::filesystem::path& path,
                                       const ImageReadOptions& options) {
  if (extensionOf(path) == ".png")
    return readPngAlpha(path, options);
  if (extensionOf(path) == ".exr")
    return readExrAlpha(path, options);
  return std::nullopt;
}

Result<std::optional<std::vector<double>>> readStoredCurve(const std::filesystem::path& path) {
  if (extensionOf(path) == ".png")
    return readPngCurve(path);
  return std::nullopt;
}

Status writeImage(const std::filesystem::path& path, const Image& image, const ImageNotes& notes) {
  VOLUTE_ASSERT(image.channels == 1 || image.channels == 3);
  VOLUTE_TRY(checkImageSize(path, image.width, image.height, image.channels, ~std::uint64_t{0}));
  if (extensionOf(path) == ".png")
    return writePng(path, image, notes);
  if (extensionOf(path) == ".exr")
    return writeExr(path, image, notes);
  return fail(ErrorCode::kUnsupported,
              "{}: cannot write this kind of picture; expected .png or .exr", path.string());
}

Status writeMap(const std::filesystem::path& path, const Image& map) {
  VOLUTE_TRY(checkImageSize(path, map.width, map.height, map.channels, ~std::uint64_t{0}));
  if (extensionOf(path) == ".png")
    return writePngMap(path, map);
  if (extensionOf(path) == ".exr")
    return writeExr(path, map, {});
  return fail(ErrorCode::kUnsupported, "{}: cannot write this kind of map; expected .png or .exr",
              path.string());
}

}  // namespace volute
