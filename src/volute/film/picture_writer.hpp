// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/frame_name.hpp"
#include "volute/base/remark.hpp"
#include "volute/base/result.hpp"
#include "volute/base/stopwatch.hpp"
#include "volute/image/colormap.hpp"
#include "volute/image/image.hpp"
#include "volute/image/legend.hpp"
#include "volute/image/picture_style.hpp"
#include "volute/io/film.hpp"
#include "volute/io/frame_file.hpp"
#include "volute/io/image_file.hpp"

namespace volute {

/// How linear pictures become visible ones (.png, films); .exr files keep the linear values.
struct Development {
  PictureStyle style;
  std::optional<ColorMap> colorMap{};  ///< of the first channel, from 0 to 1 after the exposure
  FilmStyle film{};                    ///< of films
  bool half = false;                   ///< .exr: half floats, else float32
};

/// Letters around a pixel.
struct PictureMark {
  Vec2 at = Vec2::Zero();  ///< their middle, in pixels from the upper left corner
  std::string text;
};

/// Notes in a picture's file, and what is drawn onto it.
struct PictureText {
  ImageNotes notes{};                 ///< in the file
  std::vector<std::string> legend{};  ///< drawn into .png and films; empty: nothing
  std::optional<ColorScale>
      scale{};  ///< of a picture that comes in its colours, or of a part of one
  std::vector<PictureMark> marks{};  ///< drawn with the legend
};

/// A linear picture with its tone curve applied: linear light for toSrgb8().
Image developed(const Image& image, const Development& development, const PictureText& text);

/// Where pictures go, in order; nothing appears before it is whole. Pictures are linear RGB, or one
/// channel.
class PictureWriter {
 public:
  virtual ~PictureWriter() = default;
  [[nodiscard]] virtual Status write(const Image& image, int frameNumber,
                                     const PictureText& text = {}) = 0;
  /// Several layers of one picture, into a .exr; or R, G, B and A, the colour multiplied by A, into
  /// a .png with straight alpha. There light that hides nothing, as of flames, has as much alpha as
  /// it is bright, so that the picture over black is the one without alpha.
  [[nodiscard]] virtual Status writeLayers(int width, int height,
                                           const std::vector<ImageChannel>& channels,
                                           int frameNumber, const PictureText& text) = 0;
  /// A frame of another renderer. A .exr keeps its windows, alpha, pixel aspect and attributes; the
  /// others show the display window, black where it has no pixels: a .png of the frame's bits with
  /// straight alpha, a film over black.
  [[nodiscard]] virtual Status writeFrame(const FramePixels& frame, int frameNumber) = 0;
  /// After the last picture.
  [[nodiscard]] virtual Status finish() = 0;

  /// Milliseconds that went into making linear pictures visible.
  double converted() const { return converted_; }

  /// What half floats did not hold of what was written so far, about `target`.
  std::optional<Remark> halvesLost(const std::string& target) const;

 protected:
  Image visible(const Image& image, const Development& development, const PictureText& text) {
    const Stopwatch watch(converted_);
    return developed(image, development, text);
  }

  /// Of values that are about to be written as half floats.
  void countHalves(std::span<const float> values);

 private:
  double converted_ = 0;
  std::uint64_t cut_ = 0, vanished_ = 0;  ///< of half floats
  float largest_ = 0;
};

/// Files .png or .exr, one a picture: a pattern with the frame's number, or a plain name for a
/// single one.
/// @param scale  what the frames' numbers mean
[[nodiscard]] Result<std::unique_ptr<PictureWriter>> imageFileWriter(const std::string& target,
                                                                     const Development& development,
                                                                     FrameScale scale = {});

/// A film .mp4 or .webm, and what it says about itself.
/// @param framesPerSecond  > 0
[[nodiscard]] Result<std::unique_ptr<PictureWriter>> filmWriter(const std::string& target,
                                                                const Development& development,
                                                                int width, int height,
                                                                double framesPerSecond,
                                                                const std::string& comment = {});

/// Says that a film of an odd width or height is a pixel larger than its pictures; empty where not.
std::string evenSizeText(const std::string& target, int width, int height);

/// By the name's end: .mp4 or .webm.
bool isFilmPath(const std::string& target);

}  // namespace volute
