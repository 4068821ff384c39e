// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "volute/grid/select_frames.hpp"
#include "volute/media/fog/fog_layer.hpp"
#include "volute/render/render.hpp"

// Fog over frames that another renderer made: colour, depth and camera of each are files.

namespace volute {

/// The files of one frame, or of many as patterns with the frame's number.
struct FogFrame {
  int number = 0;
  std::string color;   ///< .exr (linear) or .png (sRGB), one channel or three
  std::string depth;   ///< one channel [m], inf for the sky, of the colour's size
  std::string camera;  ///< a scene's camera object, .json
};

/// What the files do not say.
struct FogFrameOptions {
  bool depthAlongRay = false;                            ///< from the eye; else along the view axis
  double sky = std::numeric_limits<double>::infinity();  ///< [m], depths from here on are sky
  std::optional<double> time{};  ///< [s] of the fog; else the frame's number / rate
  double rate = 25;              ///< frames a second, > 0
  Renderer renderer = Renderer::kCpu;
};

/// All frames that there are of the colour's pattern, or those chosen by their numbers; a name that
/// is no pattern is one frame. kInvalidArgument ("frames: ...") where none is left.
[[nodiscard]] Result<std::vector<FogFrame>> fogFrames(const FogFrame& names,
                                                      const std::optional<FrameRange>& chosen);

/// The frame behind the fog, linear RGB: out = T color + (1 - T) fog-color, T integrated exactly
/// from the eye to the frame's depth. Errors name the file and, of depths, the pixel.
[[nodiscard]] Result<Image> fogOver(const FogFrame& frame, const FogLayer& layer,
                                    const FogFrameOptions& options, Reading& reading);

}  // namespace volute
