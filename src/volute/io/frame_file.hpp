// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volute/io/image_file.hpp"
#include "volute/math/vec.hpp"

// Frames of other renderers: .exr files with layers, parts, windows and attributes.

namespace volute {

/// Columns left <= x < right and rows top <= y < bottom of a picture, inside its borders or not.
struct PixelWindow {
  int left = 0, top = 0, right = 0, bottom = 0;

  int width() const { return right - left; }

  int height() const { return bottom - top; }

  bool contains(int x, int y) const { return x >= left && x < right && y >= top && y < bottom; }

  bool operator==(const PixelWindow&) const = default;
};

/// A channel of half or float with a value for each pixel.
struct FrameChannel {
  /// Unique in the file: "R", "ViewLayer.Depth.Z"; in a file of several parts it begins with the
  /// part's name.
  std::string name;
  std::string own;  ///< as its part has it
  int part = 0;
};

/// Everything else that a file says about a picture: time code, chromaticities, owner.
struct FrameAttributes;

/// A part of a file.
struct FramePart {
  PixelWindow data;        ///< where there are pixels,
  PixelWindow display;     ///< of what a camera shows
  double pixelAspect = 1;  ///< width of a pixel / its height
  std::shared_ptr<const FrameAttributes> attributes{};
};

/// What is in a .exr, before its pixels are read.
struct FrameInfo {
  std::vector<FramePart> parts;
  std::vector<FrameChannel> channels;  ///< integers (object numbers) and subsampled ones left out
  std::string software{};              ///< that wrote it, where it says so
};

/// kUnsupported for deep pictures.
[[nodiscard]] Result<FrameInfo> readFrameInfo(const std::filesystem::path& path);

/// From the primaries that a part states, ACES's for one, to sRGB's; none: the same. kInvalidData
/// in half a sentence where they span no colors.
[[nodiscard]] Result<std::optional<Mat3>> srgbFromPrimaries(const FramePart& part);

/// Channels of one part over its data window, interleaved.
[[nodiscard]] Result<Image> readFrameChannels(const std::filesystem::path& path,
                                              std::span<const FrameChannel> channels,
                                              std::uint64_t maxMemory);

/// A picture in its windows: linear RGB of sRGB's primaries over `data`, and where there is alpha
/// the colour is multiplied by it.
struct FramePixels {
  Image color{};
  std::optional<Image> alpha{};
  FramePart part{};
  bool half = false;  ///< written as half floats, else float32
  int bits = 8;       ///< of a channel where it is written as a .png: 8 or 16
};

/// writeChannels() of colours, alpha and brightness (R, G, B, A, Y) as half floats, from which
/// values are off by at most 1/2048; beyond 65504 they are that. Other channels stay float32.
[[nodiscard]] Status writeHalfChannels(const std::filesystem::path& path, int width, int height,
                                       const std::vector<ImageChannel>& channels,
                                       const ImageNotes& notes = {});

/// The channels R, G, B, or Y, of a picture.
std::vector<ImageChannel> channelsOf(const Image& image);

/// Writes a .exr: scan lines, ZIP, with all attributes that still hold, in the primaries that they
/// state.
[[nodiscard]] Status writeFrame(const std::filesystem::path& path, const FramePixels& pixels);

/// The integers of a .png as they are stored, 0 to 255 or 65535, and how many a channel can be.
struct StoredPng {
  Image image{};
  int largest = 255;
};

[[nodiscard]] Result<StoredPng> readStoredPng(const std::filesystem::path& path,
                                              std::uint64_t maxMemory);

/// What the head of a .png says.
struct PngKind {
  int channels = 1;  ///< without alpha
  int bits = 8;      ///< 16, or 8 where it has as many or fewer
  /// How it stores light: "sRGB", "gAMA 1", "an ICC profile", "cICP 1, 13"; empty: not stated.
  std::string color{};
  int pictures = 1;        ///< of an animated one (APNG); the first is read
  double pixelAspect = 1;  ///< width of a pixel / its height
  bool alpha = false;      ///< some of it may be transparent
};

[[nodiscard]] Result<PngKind> readPngKind(const std::filesystem::path& path);

/// Writes a .png of 16 bits in sRGB.
/// @param color  linear RGB, or one channel; clamped to 0..1
/// @param alpha  0..1, one channel, which does not multiply the colour (straight); nothing: none
[[nodiscard]] Status writePng16(const std::filesystem::path& path, const Image& color,
                                const std::optional<Image>& alpha);

/// Writes a .png of 8 bits with alpha, which does not multiply the colour (straight).
/// @param color  linear RGB, or one channel
/// @param alpha  0..1, one channel
[[nodiscard]] Status writePngWithAlpha(const std::filesystem::path& path, const Image& color,
                                       const Image& alpha, const ImageNotes& notes = {});

}  // namespace volute
