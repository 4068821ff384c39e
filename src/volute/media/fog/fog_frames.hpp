// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "volute/grid/select_frames.hpp"
#include "volute/io/frame_file.hpp"
#include "volute/io/reading.hpp"
#include "volute/media/fog/fog_scene_medium.hpp"
#include "volute/media/fog/frame_layers.hpp"
#include "volute/render/render.hpp"

// Fog over frames that another renderer made: colour, depth and camera of each are files.

namespace volute {

/// The files of one frame, or of many as patterns with the frame's number.
struct FogFrame {
  int number = 0;
  std::string color;   ///< .exr (linear, alpha multiplied in) or .png (sRGB, alpha straight)
  std::string depth;   ///< .exr, or .png with a scale; of the colour's size, or N times that
  std::string camera;  ///< a scene's camera object, .json
};

/// Layer, channel, kind and scale of depths where files do not state them.
struct FogFrameOptions {
  std::string colorLayer{};                   ///< empty: the one of the whole picture
  std::string depthChannel{};                 ///< empty: by the names that renderers give it
  DepthKind depthKind = DepthKind::kUnknown;  ///< kUnknown: what the file says, else z
  std::optional<double> depthScale{};         ///< [m] of a stored unit; needed for a .png
  double sky = std::numeric_limits<double>::infinity();  ///< [m], depths from here on are sky
  bool onlyFog = false;   ///< without the frame: light and alpha of the fog, to be put over it
  bool softEdges = true;  ///< pixels between surfaces are taken apart: frame_edges.hpp
  std::optional<double> time{};  ///< [s] of the fog; else the frame's number / rate
  double rate = 25;              ///< frames a second, > 0
  Renderer renderer = Renderer::kCpu;
};

/// Something worth saying of a frame. Of frames that follow each other, what has the same subject
/// is worth it once.
struct FrameRemark {
  RemarkCode code = RemarkCode::kNote;
  std::string subject;
  std::string text;
  Hints hints{};
};

/// How far away what a frame shows is, without the sky; empty where there is nothing else.
struct FrameReach {
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0;  ///< [m]
};

/// Whether frames that follow each other would hardly show both: all of one is ten times as far
/// away, as where a depth is in another unit.
[[nodiscard]] bool isFarFrom(const FrameReach& one, const FrameReach& other);

/// A frame with fog over it.
struct FoggedFrame {
  FramePixels pixels;
  FrameReach reach{};
  std::vector<std::string> others{};   ///< channels of the frame's file that are not among them
  std::vector<FrameRemark> remarks{};  ///< how far what it shows is; what was assumed, or is lost
};

/// Frames between those that are chosen of which there is a depth, and no colour.
[[nodiscard]] std::vector<int> framesWithoutColor(const FogFrame& names,
                                                  const std::vector<FogFrame>& frames);

/// All frames that there are of the colour's pattern, or those chosen by their numbers; a name that
/// is no pattern is one frame. kInvalidArgument ("frames: ...") where none is left.
[[nodiscard]] Result<std::vector<FogFrame>> fogFrames(const FogFrame& names,
                                                      const std::optional<FrameRange>& chosen);

/// The frame behind the fog, linear RGB: out = T color + (1 - T) fog-color, T integrated exactly
/// from the eye to the frame's depth. Alpha becomes 1 - T (1 - alpha). The frame's data and display
/// windows, pixel aspect (whose rays are the pixels') and attributes stay. Depths of 0, infinity,
/// 1e10 and more, and 65504 (the largest half) are where there is nothing: sky. Errors name the
/// file and, of depths, the pixel.
[[nodiscard]] Result<FoggedFrame> fogOver(const FogFrame& frame, FogSceneMedium& fog,
                                          const FogFrameOptions& options, Reading& reading);

}  // namespace volute
