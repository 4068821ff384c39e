// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/base/progress.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute {

/// Copies all frames and finishes the sink. Reports frames of `stage`; kCancelled names the stage
/// and the frame.
[[nodiscard]] Status copyFrames(FrameSource& source, FrameSink& sink, const std::string& stage,
                                Progress& progress);

}  // namespace volute
