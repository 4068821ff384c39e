// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/text.hpp"

#if VOLUTE_HAS_FONTS
#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H
#endif

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <mutex>

namespace volute {
namespace {

constexpr double kLineHeight = 1.25;  // of the em: from the highest letter to the lowest
constexpr double kBaseline = 0.93;    // of the em, below the top
constexpr double kMonoAdvance = 0.602;
constexpr double kUnit = 64;  // FreeType's, in a pixel

void blend(Image& image, int x, int y, double cover, const Rgb& color) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height)
    return;
  for (int c = 0; c < image.channels; ++c) {
    float& value = image.at(x, y, c);
    value = static_cast<float>(value + cover * (color[c] - value));
  }
}

#if VOLUTE_HAS_FONTS

/// One typeface of this machine. FreeType's faces are for one thread at a time.
class Face {
 public:
  static Face& of(Typeface typeface) {
    static Face sans(Typeface::kSans), mono(Typeface::kMono);
    return typeface == Typeface::kMono ? mono : sans;
  }

  /// Calls draw(letter's outline, its pen's place in pixels) for each letter, gives the advance of
  /// all; nothing: there is no such file, or FreeType cannot read it.
  template <class Draw>
  std::optional<double> eachLetter(std::string_view text, const TextStyle& style, Draw&& draw) {
    const std::scoped_lock lock(mutex_);
    const auto size = static_cast<FT_F26Dot6>(std::lround(kUnit * style.size));
    if (!face_ || FT_Set_Char_Size(face_, 0, size, 72, 72) != 0)
      return std::nullopt;
    double pen = 0;
    while (!text.empty()) {
      if (FT_Load_Char(face_, takeLetter(text), FT_LOAD_NO_BITMAP | FT_LOAD_TARGET_LIGHT) != 0)
        continue;
      draw(face_->glyph, pen);
      pen += style.face == Typeface::kMono ? kMonoAdvance * style.size
                                           : face_->glyph->linearHoriAdvance / 65536.0;
    }
    return pen;
  }

 private:
  explicit Face(Typeface typeface) {
    const auto file = fontFile(typeface);
    if (!file || FT_Init_FreeType(&library_) != 0)
      return;
    if (FT_New_Face(library_, file->c_str(), 0, &face_) != 0)
      face_ = nullptr;
  }

  /// Takes the first character off a text; '?' for a byte that begins none.
  static FT_ULong takeLetter(std::string_view& text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const std::size_t bytes = byte(0) < 0x80 ? 1 : byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : 2;
    FT_ULong letter = bytes == 1 ? byte(0) : byte(0) & (0x7FU >> bytes);
    bool good = byte(0) < 0x80 || (byte(0) >= 0xC2 && byte(0) < 0xF5 && text.size() >= bytes);
    for (std::size_t i = 1; good && i < bytes; ++i) {
      good = (byte(i) & 0xC0) == 0x80;
      letter = letter << 6 | (byte(i) & 0x3FU);
    }
    text.remove_prefix(good ? bytes : 1);
    return good ? letter : '?';
  }

  std::mutex mutex_;
  FT_Library library_ = nullptr;
  FT_Face face_ = nullptr;
};

/// Calls put(column, row, cover) for the pixels of a line whose top left corner is at (x, y).
template <class Put>
bool coverText(std::string_view text, double x, double y, const TextStyle& style, Put&& put) {
  const double baseline = std::round(y + kBaseline * style.size);
  const auto draw = [&](FT_GlyphSlot glyph, double pen) {
    const double left = std::floor(x + pen);
    FT_Outline_Translate(&glyph->outline, std::lround(kUnit * (x + pen - left)), 0);
    if (FT_Render_Glyph(glyph, FT_RENDER_MODE_NORMAL) != 0)
      return;
    const FT_Bitmap& dots = glyph->bitmap;
    for (unsigned row = 0; row < dots.rows; ++row) {
      for (unsigned column = 0; column < dots.width; ++column) {
        const auto cover = dots.buffer[static_cast<std::ptrdiff_t>(row) * dots.pitch + column];
        if (cover > 0) {
          put(static_cast<int>(left) + glyph->bitmap_left + static_cast<int>(column),
              static_cast<int>(baseline) - glyph->bitmap_top + static_cast<int>(row),
              cover / 255.0);
        }
      }
    }
  };
  return Face::of(style.face).eachLetter(text, style, draw).has_value();
}

/// The advance of a line [pixels]; nothing: the machine has no such typeface.
std::optional<double> advanceOf(std::string_view text, const TextStyle& style) {
  return Face::of(style.face).eachLetter(text, style, [](FT_GlyphSlot, double) {});
}

#else

template <class Put>
bool coverText(std::string_view, double, double, const TextStyle&, Put&&) {
  return false;
}

std::optional<double> advanceOf(std::string_view, const TextStyle&) {
  return std::nullopt;
}

#endif

int dotsOf(const TextStyle& style) {
  return std::max(1, static_cast<int>(std::lround(kMonoAdvance * style.size / 6)));
}

}  // namespace

std::optional<std::string> fontFile(Typeface face) {
  const bool mono = face == Typeface::kMono;
  const char* named = std::getenv("VOLUTE_FONT_FOLDER");
  const std::string dejavu = mono ? "DejaVuSansMono.ttf" : "DejaVuSans.ttf";
  const std::string noto = mono ? "NotoSansMono-Regular.ttf" : "NotoSans-Regular.ttf";
  for (const std::string& file :
       {std::string(named ? named : "") + "/" + dejavu,
        "/usr/share/fonts/truetype/dejavu/" + dejavu, "/usr/share/fonts/TTF/" + dejavu,
        "/usr/share/fonts/dejavu/" + dejavu, "/usr/share/fonts/dejavu-sans-fonts/" + dejavu,
        "/usr/share/fonts/dejavu-sans-mono-fonts/" + dejavu,
        "/usr/share/fonts/truetype/noto/" + noto}) {
    std::error_code unknown;
    if (std::filesystem::is_regular_file(file, unknown))
      return file;
  }
  return std::nullopt;
}

TextStyle TextStyle::ofDots(int dot) {
  return {Typeface::kMono, 6 * dot / kMonoAdvance};
}

TextSize textSize(std::string_view text, const TextStyle& style) {
  const auto wide = advanceOf(text, style);
  if (!wide)
    return textSize(text, dotsOf(style));
  return {static_cast<int>(std::ceil(*wide - 1e-6)),
          static_cast<int>(std::ceil(kLineHeight * style.size))};
}

void drawText(Image& image, std::string_view text, double x, double y, const TextStyle& style,
              const Rgb& color) {
  const auto put = [&](int column, int row, double cover) {
    blend(image, column, row, cover, color);
  };
  if (!coverText(text, x, y, style, put)) {
    drawText(image, text, static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)),
             dotsOf(style), color);
  }
}

void drawTextUpwards(Image& image, std::string_view text, double x, double y,
                     const TextStyle& style, const Rgb& color) {
  const auto turned = [&](int column, int row, double cover) {
    blend(image, static_cast<int>(std::lround(x)) + row,
          static_cast<int>(std::lround(y)) - 1 - column, cover, color);
  };
  if (coverText(text, 0, 0, style, turned))
    return;
  const TextSize size = textSize(text, dotsOf(style));
  Image flat(size.width, size.height, 1);
  drawText(flat, text, 0, 0, dotsOf(style), Rgb::Ones());
  for (int row = 0; row < flat.height; ++row) {
    for (int column = 0; column < flat.width; ++column) turned(column, row, flat.at(column, row));
  }
}

}  // namespace volute
