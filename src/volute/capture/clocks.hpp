// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/capture/importers.hpp"

// When the cameras of a capture took their pictures.

namespace volute {

/// Sets how many pictures each camera takes for a frame of the capture, and where its first one is.
/// Where no rate is stated, and films say that theirs differ, each has that of its film. Else
/// pictures go with frames one by one, and the capture's rate is that of the films where it is not
/// stated, or 25 frames a second. Pictures of a film that do not follow each other evenly are taken
/// at the times that it states. What was taken from films is remarked on.
/// @param maxMemory  [bytes] that opening a film may take.
void settleClocks(CaptureDraft& draft, std::uint64_t maxMemory);

/// How many pictures the film has; they are counted where that was not done.
[[nodiscard]] Result<int> picturesOfFilm(const PictureSource& pictures, std::uint64_t maxMemory);

/// The frames of which all films have pictures; kInvalidArgument where there are none. Frames that
/// only some have are remarked on.
[[nodiscard]] Result<std::vector<int>> framesOfFilms(CaptureDraft& draft, std::uint64_t maxMemory);

}  // namespace volute
