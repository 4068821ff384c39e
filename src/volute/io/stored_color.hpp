// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/image/image.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// How a picture's stored values, 0 to 1, become linear light.
struct StoredColor {
  using Curve = std::function<double(double)>;

  std::array<Curve, 3> curves;  ///< of each channel; empty: sRGB's. Grey pictures have the first
  bool sameCurves = true;
  std::optional<Mat3> toSrgb;  ///< linear values of its primaries to those of sRGB; none: the same
};

/// Stored values are powers of the light, with PNG's exponent (gAMA): 1 is linear; one near 1/2.2
/// is how sRGB is written in short, and read as sRGB.
[[nodiscard]] StoredColor colorOfGamma(double exponent);

/// The places of white, red, green and blue, x and y each, in the chromaticity diagram (cHRM).
/// Nothing where they are sRGB's. kInvalidData in half a sentence where they span no colors.
[[nodiscard]] Result<std::optional<Mat3>> srgbFromPrimaries(const std::array<double, 8>& places);

/// Each pixel of a picture of three channels through the matrix, in double.
void transformColors(const Mat3& matrix, Image& image);

/// Of an ICC profile with curves and primaries, or with a curve of grey, as pictures have them.
/// Nothing in it is trusted. Errors are half a sentence.
[[nodiscard]] Result<StoredColor> colorOfProfile(std::span<const std::byte> profile, bool grey);

/// Of PNG's cICP: the numbers of primaries and curve in ITU-T H.273. kUnsupported in half a
/// sentence for curves of video and of high dynamic range.
[[nodiscard]] Result<StoredColor> colorOfCodePoints(int primaries, int curve);

/// The light of evenly spaced stored values, 0 to 1, ascending; nothing: sRGB's curve. kUnsupported
/// where channels have different curves.
[[nodiscard]] Result<std::optional<std::vector<double>>> sampledCurve(
    const StoredColor& color, const std::filesystem::path& path);

}  // namespace volute
