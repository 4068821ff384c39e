// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/grid/select_frames.hpp"
#include "volute/scene/scene.hpp"

namespace volute {

/// Frames a second of a film of what goes through time without frames of its own.
inline constexpr double kUsualRate = 25;

/// A picture to take.
struct FilmFrame {
  int number = 0;   ///< of the frame, for names
  double time = 0;  ///< [s], of the scene
  double turn = 0;  ///< of the camera's orbit, 0..1
};

/// Which frames of a scene are wanted.
struct FrameRequest {
  std::string target;                  ///< a film, or a pattern of names: several frames; else one
  std::optional<double> time{};        ///< this one [s]
  std::optional<FrameRange> frames{};  ///< these, by the numbers of the medium that leads
  double speed = 1;                    ///< seconds of the scene in a second of film, > 0
  std::optional<double> orbit{};       ///< [degrees], over all frames
  double rate = kUsualRate;            ///< of what has no frames of its own [1/s]
  std::optional<double> pathEnd{};     ///< of a camera that moves [s]
};

/// The frames to draw, with their times; made by chooseFrames().
struct ChosenFrames {
  std::vector<FilmFrame> frames;  ///< at least one
  std::string reason{};           ///< why this frame, where the request left it open; may be empty
};

/// The medium whose frames are counted. Several frames go before one, frames that are shown as they
/// are before interpolated ones, then the one whose last frame is latest leads, then the first.
/// Null: there is none with times of its own.
const SceneMedium* leaderOf(const Scene& scene);

/// What a request chooses, or what is shown without one: all frames of a film or a pattern, `rate`
/// a second where the medium interpolates, one that shows something for a single picture.
/// kInvalidArgument, beginning with the member's name where it is one ("frames: ..."), for times
/// past the end, frames that are not there, and several pictures for one name.
[[nodiscard]] Result<ChosenFrames> chooseFrames(const FrameRequest& request, Scene& scene,
                                                Progress& progress);

/// Of a film of these frames, which chooseFrames() chose for the request [1/s].
double framesPerSecond(const Scene& scene, const FrameRequest& request,
                       const std::vector<FilmFrame>& frames);

}  // namespace volute
