// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/colormap.hpp"

#include <algorithm>
#include <array>

#include "volute/base/assert.hpp"
#include "volute/image/srgb.hpp"

namespace volute {
namespace {

using Polynomial = std::array<std::array<double, 3>, 7>;

constexpr Polynomial kViridisCoefficients{
    {{0.2777273272234177, 0.005407344544966578, 0.3340998053353061},
     {0.1050930431085774, 1.404613529898575, 1.384590162594685},
     {-0.3308618287255563, 0.214847559468213, 0.09509516302823659},
     {-4.634230498983486, -5.799100973351585, -19.33244095627987},
     {6.228269936347081, 14.17993336680509, 56.69055260068105},
     {4.776384997670288, -13.74514537774601, -65.35303263337234},
     {-5.435455855934631, 4.645852612178535, 26.3124352495832}}};

constexpr Polynomial kInfernoCoefficients{
    {{0.0002189403691192265, 0.001651004631001012, -0.01948089843709184},
     {0.1065134194856116, 0.5639564367884091, 3.932712388889277},
     {11.60249308247187, -3.972853965665698, -15.9423941062914},
     {-41.70399613139459, 17.43639888205313, 44.35414519872813},
     {77.162935699427, -33.40235894210092, -81.80730925738993},
     {-71.31942824499214, 32.62606426397723, 73.20951985803202},
     {25.13112622477341, -12.24266895238567, -23.07032500287172}}};

constexpr Polynomial kPlasmaCoefficients{
    {{0.05873234392399702, 0.02333670892565664, 0.5433401826748754},
     {2.176514634195958, 0.2383834171260182, 0.7539604599784036},
     {-2.689460476458034, -7.455851135738909, 3.110799939717086},
     {6.130348345893603, 42.3461881477227, -28.51885465332158},
     {-11.10743619062271, -82.66631109428045, 60.13984767418263},
     {10.02306557647065, 71.41361770095349, -54.07218655560067},
     {-3.658713842777788, -22.93153465461149, 18.19190778539828}}};

const Polynomial& coefficientsOf(ColorMap map) {
  switch (map) {
    case ColorMap::kInferno:
      return kInfernoCoefficients;
    case ColorMap::kPlasma:
      return kPlasmaCoefficients;
    case ColorMap::kViridis:
      break;
  }
  return kViridisCoefficients;
}

}  // namespace

Rgb displayColor(ColorMap map, double t) {
  const Polynomial& polynomial = coefficientsOf(map);
  const double x = t > 0 ? std::min(t, 1.0) : 0;
  Rgb color = Rgb::Zero();
  for (std::size_t power = polynomial.size(); power-- > 0;) {
    color = color * x + Rgb(polynomial[power][0], polynomial[power][1], polynomial[power][2]);
  }
  return color.max(0).min(1);
}

Image colorMapped(const Image& quantity, ColorMap map, double low, double high) {
  VOLUTE_ASSERT(quantity.channels == 1);
  Image result(quantity.width, quantity.height, 3);
  for (std::size_t i = 0; i < quantity.pixels.size(); ++i) {
    const double t = high > low ? (quantity.pixels[i] - low) / (high - low) : 0;
    const Rgb color = displayColor(map, t);
    for (int c = 0; c < 3; ++c) result.pixels[3 * i + c] = static_cast<float>(srgbDecode(color[c]));
  }
  return result;
}

}  // namespace volute
