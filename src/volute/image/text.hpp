// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "volute/image/bitmap_text.hpp"
#include "volute/image/image.hpp"
#include "volute/math/vec.hpp"

// Lines of text in pictures: DejaVu, or Noto where that is what the machine has; without either the
// letters of bitmap_text.hpp. Text is UTF-8; a byte that is none is drawn as '?'.

namespace volute {

enum class Typeface { kSans, kMono };

/// The file of a typeface on this machine; VOLUTE_FONT_FOLDER is looked at first.
std::optional<std::string> fontFile(Typeface face);

struct TextStyle {
  Typeface face = Typeface::kSans;
  double size = 16;  ///< of the em [pixels]

  /// Letters that are each six `dot` wide, as those of bitmap_text.hpp.
  static TextStyle ofDots(int dot);
};

/// Of a line, as drawText() draws it: its advance, and from the highest letter to the lowest.
TextSize textSize(std::string_view text, const TextStyle& style);

/// Draws one line with its top left corner at (x, y), its edges smooth; what lies outside of the
/// picture is left out. `color` is in the picture's own values; a picture of one channel takes its
/// first.
void drawText(Image& image, std::string_view text, double x, double y, const TextStyle& style,
              const Rgb& color);

/// The same turned to run upwards, for a vertical axis: x, y is the lower left corner.
void drawTextUpwards(Image& image, std::string_view text, double x, double y,
                     const TextStyle& style, const Rgb& color);

}  // namespace volute
