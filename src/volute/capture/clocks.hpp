// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/capture/importers.hpp"

// When the cameras of a capture took their pictures.

namespace volute {

inline constexpr double kUnstatedRate = 25;  ///< frames a second, where nothing says another rate

/// Sets how many pictures each camera takes for a frame of the capture, and where its first one is.
/// Cameras whose rates are not stated have those of their films where films differ, or where the
/// capture's rate is not stated, which is then the slowest of theirs. Else pictures go with frames
/// one by one; without films the capture's rate is kUnstatedRate where it is not stated. Pictures
/// of a film that do not follow each other evenly are taken at the times that it states. What was
/// taken from films, and what contradicts them, is remarked on.
/// @param maxMemory  [bytes] that opening a film may take.
void settleClocks(CaptureDraft& draft, std::uint64_t maxMemory);

/// Says that frames from `first` to -1 are left out.
[[nodiscard]] std::string framesBeforeZero(int first);

/// How many pictures the film has; they are counted where that was not done.
[[nodiscard]] Result<int> picturesOfFilm(const PictureSource& pictures, std::uint64_t maxMemory);

/// The frames of which all films have pictures; kInvalidArgument where there are none. Frames that
/// only some have, and frames before 0, are remarked on.
[[nodiscard]] Result<std::vector<int>> framesOfFilms(CaptureDraft& draft, std::uint64_t maxMemory);

}  // namespace volute
