// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/scene/scene.hpp"

namespace volute::cli {

/// Frames a second of a film of what goes through time without frames of its own.
inline constexpr double kUsualRate = 25;

/// A picture to take.
struct Moment {
  int number = 0;   ///< of the frame, for names
  double time = 0;  ///< [s], of the scene
  double turn = 0;  ///< of the camera's orbit, 0..1
};

/// The medium whose frames are counted: the first whose frames are shown as they are, else the
/// first with times of its own. Null: there is none.
const SceneMedium* leaderOf(const Scene& scene);

/// What --time and --frames choose, or what is shown without them.
[[nodiscard]] Result<std::vector<Moment>> momentsOf(const Arguments& arguments, Scene& scene,
                                                    const std::string& target, Progress& progress);

/// Of a film of these.
double framesPerSecond(const Scene& scene, const std::vector<Moment>& moments);

}  // namespace volute::cli
