// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/image/image.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// Perceptually even maps of a quantity to colours, dark to light.
enum class ColorMap { kViridis, kInferno, kPlasma };

/// The colour of t (clamped to 0..1, NaN gives 0) as display values 0..1, not linear: within 0.02
/// of the tables of matplotlib, by degree 6 polynomials fitted to them (Zucker, public domain).
Rgb displayColor(ColorMap map, double t);

/// A one-channel picture in colours: `low` and below get the first, `high` and above the last. The
/// result is linear, so that writing it as a display picture gives the map's own colours.
Image colorMapped(const Image& quantity, ColorMap map, double low, double high);

}  // namespace volute
