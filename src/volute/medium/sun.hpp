// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/math/vec.hpp"

namespace volute {

/// A light from afar that media scatter. On surfaces and in smoke it is a Lamp (lighting/lamp.hpp).
struct Sun {
  Vec3 towards = Vec3::UnitZ();  ///< from the scene to the sun; its length does not matter
  Rgb irradiance = Rgb::Ones();  ///< on a surface that faces it, linear RGB
};

}  // namespace volute
