// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <span>
#include <string>

#include "volute/io/frame_file.hpp"

// Which channels of a frame are its colour and its depth, by the names that renderers give them.

namespace volute {

/// Red, green and blue, or thrice the same one; and alpha.
struct ColorChannels {
  std::string layer;  ///< "ViewLayer.Combined"; empty: none
  FrameChannel rgb[3];
  std::optional<FrameChannel> alpha{};
};

/// @param layer  that somebody asked for; empty: the one that shows the whole picture
/// kInvalidData names the layers where it cannot be told which one that is.
[[nodiscard]] Result<ColorChannels> colorChannels(std::span<const FrameChannel> channels,
                                                  const std::string& layer);

enum class DepthKind {
  kUnknown,
  kAlongAxis,  ///< along the camera's view axis, "z"
  kAlongRay,   ///< distance from the eye
  kInverse,    ///< 1 / kAlongAxis, 0 for the sky
};

/// What says how far away each pixel is.
struct DepthChannel {
  FrameChannel channel;
  DepthKind kind = DepthKind::kUnknown;  ///< by its name
  /// A picture of depth in grey: the other two have to be the same.
  std::optional<FrameChannel> same[2]{};
  std::string unit{};  ///< a sentence, of one whose unit is known not to be the metre
};

/// @param wanted  its name, that somebody asked for; empty: the one that renderers call so
/// @param layer  of the colour: of several depths that of the same view counts
/// kInvalidData names the channels where it cannot be told which one it is.
[[nodiscard]] Result<DepthChannel> depthChannel(const FrameInfo& info, const std::string& wanted,
                                                const std::string& layer);

}  // namespace volute
