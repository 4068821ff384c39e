// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>

namespace volute {

/// Four floats of a buffer or a texture, as shaders read them: 16 bytes.
using Texel = std::array<float, 4>;

/// @param value  a Vec3 or an Rgb.
template <class Three>
Texel texel(const Three& value, double last = 0) {
  return {static_cast<float>(value[0]), static_cast<float>(value[1]), static_cast<float>(value[2]),
          static_cast<float>(last)};
}

}  // namespace volute
