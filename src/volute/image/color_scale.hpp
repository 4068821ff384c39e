// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/image/colormap.hpp"

namespace volute {

/// The colours of a measured quantity, from `least` to `most`.
struct ColorScale {
  ColorMap map = ColorMap::kViridis;
  double most = 1;
  double least = 0;
  std::string unit{};  ///< stands behind `most`: "g/m3", "m or more"
};

}  // namespace volute
