// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/capture/capture.hpp"

namespace volute {

/// Before any picture is read: whether enough cameras are left besides those held out, the places
/// of cameras and volume make sense, and all pictures are there and each camera's own. With
/// `force`, doubts are remarks.
[[nodiscard]] Status checkCapture(const Capture& capture, const std::vector<std::string>& heldOut,
                                  bool force, std::uint64_t maxMemory, Progress& progress);

/// Whether all pictures of the chosen frames have one channel, by their files' heads: films are in
/// colour, and pictures that are missing or damaged do not count.
[[nodiscard]] bool isGrey(const Capture& capture, std::uint64_t maxMemory);

}  // namespace volute
