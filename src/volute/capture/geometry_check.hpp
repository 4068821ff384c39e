// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/capture/capture.hpp"

namespace volute {

/// A sentence about what cannot be right in the places of cameras and volume, with the camera and
/// the numbers.
struct GeometryFault {
  std::string camera;
  std::string message;
};

/// Looks for cameras that do not see the volume: inside it, behind it, past it, so far away that it
/// covers next to nothing (centimetres for metres), and for principal points that would be centred
/// if width and height were swapped. One fault for each camera at most; none when all see it well.
/// Partly visible volumes are no fault.
std::vector<GeometryFault> checkGeometry(const Capture& capture);

}  // namespace volute
