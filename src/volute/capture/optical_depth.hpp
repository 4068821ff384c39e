// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/image/image.hpp"

namespace volute {

/// A picture of a lit background through a medium, as optical depths.
struct OpticalDepths {
  Image depth;  ///< -ln(light / background), RGB; below 0 where noise made it brighter
  std::vector<float> weight;  ///< (height, width): light / the brightest background, at most 1, of
                              ///< the darkest channel, so that noise / weight is the depth's
                              ///< noise; 0 = does not count
  std::vector<std::uint8_t> atLeast;  ///< (height, width), bit c: channel c shows no light, and its
                                      ///< depth is `depth` or more; the weight is then 0
  double opaqueShare = 0;             ///< pixels with such a bound / those whose background is lit
  /// Light / the brightest background that the darkest pixels have in common, as opaque parts do
  /// where a black level or stray light was left in; 0: they differ.
  double levelLeft = 0;
};

/// Light below this share of the brightest background cannot be told from none.
inline constexpr double kDarkestOfBackground = 0.002;

/// Beer and Lambert's law: the light of a background falls to exp(-depth) on its way through a
/// medium that absorbs or scatters it out of sight, and does not shine itself.
/// @param light, background  RGB of one size, linear, background included.
/// @param counts  (height, width), 0 = masked or saturated; empty: all count.
/// @param darkest  light that cannot be told from none [as `light`]; at least
///   kDarkestOfBackground of the brightest background is taken. Where the background itself is
///   darker than twice that, a pixel does not count.
OpticalDepths opticalDepths(const Image& light, const Image& background,
                            std::span<const float> counts, double darkest);

}  // namespace volute
