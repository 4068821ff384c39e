// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/image/image.hpp"
#include "volute/math/vec.hpp"

// What plots are drawn with. What lies outside of a picture is left out; colours are in its own
// values, and a picture of one channel takes their first.

namespace volute {

/// Fills x0 <= x < x1, y0 <= y < y1.
void fillRect(Image& image, int x0, int y0, int x1, int y1, const Rgb& color);

/// A straight line between points in pixels, `width` wide, its border smooth.
void drawLine(Image& image, double x0, double y0, double x1, double y1, double width,
              const Rgb& color);

}  // namespace volute
