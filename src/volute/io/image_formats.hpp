// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/io/image_file.hpp"

namespace volute {

/// The formats behind readImage and writeImage.
[[nodiscard]] Result<Image> readPng(const std::filesystem::path& path,
                                    const ImageReadOptions& options);
[[nodiscard]] Result<std::optional<Image>> readPngAlpha(const std::filesystem::path& path,
                                                        const ImageReadOptions& options);
[[nodiscard]] Result<std::optional<std::vector<double>>> readPngCurve(
    const std::filesystem::path& path);

[[nodiscard]] Status writePng(const std::filesystem::path& path, const Image& image,
                              const ImageNotes& notes);
[[nodiscard]] Status writePngMap(const std::filesystem::path& path, const Image& map);
[[nodiscard]] Result<Image> readExr(const std::filesystem::path& path,
                                    const ImageReadOptions& options);
[[nodiscard]] Result<std::optional<Image>> readExrAlpha(const std::filesystem::path& path,
                                                        const ImageReadOptions& options);
[[nodiscard]] Status writeExr(const std::filesystem::path& path, const Image& image,
                              const ImageNotes& notes);

/// kTooLarge when the pixels need more than `maxMemory` bytes, or a side is beyond 2^20 pixels.
[[nodiscard]] Status checkImageSize(const std::filesystem::path& path, std::int64_t width,
                                    std::int64_t height, int channels, std::uint64_t maxMemory);

}  // namespace volute
