// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/film/picture_writer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "volute/image/legend.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/film.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/image_file.hpp"

namespace volute {
namespace {

Image developed(Image image, const Development& development) {
  if (!development.colorMap)
    return volute::developed(std::move(image), development.style);
  Image quantity(image.width, image.height, 1);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) quantity.at(x, y) = image.at(x, y);
  }
  return colorMapped(quantity, *development.colorMap, 0, 1 / development.style.exposure);
}

}  // namespace

Image developed(const Image& image, const Development& development, const PictureText& text) {
  Image out = developed(image, development);
  if (text.legend.empty())
    return out;
  std::optional<ColorScale> scale = text.scale;
  if (development.colorMap)
    scale = ColorScale{*development.colorMap, 1 / development.style.exposure};
  for (const PictureMark& mark : text.marks) drawMark(out, mark.text, mark.at);
  drawLegend(out, text.legend, scale);
  return out;
}

namespace {

/// Of a picture over a data window, what the display window shows.
Image displayed(const Image& data, const FramePart& part) {
  if (part.data == part.display)
    return data;
  Image image(part.display.width(), part.display.height(), data.channels);
  for (int y = std::max(part.data.top, part.display.top);
       y < std::min(part.data.bottom, part.display.bottom); ++y) {
    for (int x = std::max(part.data.left, part.display.left);
         x < std::min(part.data.right, part.display.right); ++x) {
      for (int c = 0; c < data.channels; ++c) {
        image.at(x - part.display.left, y - part.display.top, c) =
            data.at(x - part.data.left, y - part.data.top, c);
      }
    }
  }
  return image;
}

/// The colour that alpha multiplies.
Image straight(Image color, const Image& alpha) {
  for (std::size_t i = 0; i < color.pixels.size(); ++i) {
    const float share = alpha.pixels[i / static_cast<std::size_t>(color.channels)];
    color.pixels[i] = share > 0 ? color.pixels[i] / share : 0;
  }
  return color;
}

class ImageFileWriter final : public PictureWriter {
 public:
  ImageFileWriter(std::optional<FramePattern> pattern, FrameScale scale, std::string target,
                  const Development& development)
      : pattern_(std::move(pattern)),
        scale_(scale),
        target_(std::move(target)),
        development_(development) {}

  Status write(const Image& image, int frameNumber, const PictureText& text) override {
    const auto path =
        pattern_ ? pattern_->format(frameNumber, scale_) : std::filesystem::path(target_);
    if (extensionOf(target_) == ".exr") {
      if (!development_.half)
        return writeImage(path, image, text.notes);
      countHalves(image.pixels);
      return writeHalfChannels(path, image.width, image.height, channelsOf(image), text.notes);
    }
    return writeImage(path, visible(image, development_, text), text.notes);
  }

  Status writeLayers(int width, int height, const std::vector<ImageChannel>& channels,
                     int frameNumber, const PictureText& text) override {
    const auto path =
        pattern_ ? pattern_->format(frameNumber, scale_) : std::filesystem::path(target_);
    if (extensionOf(target_) == ".exr") {
      for (const ImageChannel& channel : channels) {
        if (development_.half && std::string_view("RGBA").find(channel.name) != std::string::npos)
          countHalves(channel.values);
      }
      return (development_.half ? writeHalfChannels : writeChannels)(path, width, height, channels,
                                                                     text.notes);
    }
    return writeStraight(path, width, height, channels, text);
  }

  Status writeFrame(const FramePixels& frame, int frameNumber) override {
    const auto path =
        pattern_ ? pattern_->format(frameNumber, scale_) : std::filesystem::path(target_);
    if (extensionOf(target_) == ".exr") {
      if (!development_.half)
        return volute::writeFrame(path, frame);
      countHalves(frame.color.pixels);
      FramePixels rounded = frame;
      rounded.half = true;
      return volute::writeFrame(path, rounded);
    }
    Image color = displayed(frame.color, frame.part);
    std::optional<Image> alpha;
    if (frame.alpha) {
      alpha = displayed(*frame.alpha, frame.part);
      color = straight(std::move(color), *alpha);
    }
    Development development = development_;
    development.style.dither = development.style.dither && frame.bits == 8;
    color = developed(std::move(color), development);
    if (frame.bits == 16)
      return writePng16(path, color, alpha);
    return alpha ? writePngWithAlpha(path, color, *alpha) : writeImage(path, color);
  }

  Status finish() override { return {}; }

 private:
  Status writeStraight(const std::filesystem::path& path, int width, int height,
                       const std::vector<ImageChannel>& channels, const PictureText& text) {
    Image color(width, height), alpha(width, height, 1);
    for (const ImageChannel& channel : channels) {
      const std::size_t at = std::string_view("RGB").find(channel.name);
      if (at == std::string_view::npos)
        alpha.pixels = channel.values;
      else
        for (std::size_t i = 0; i < channel.values.size(); ++i)
          color.pixels[3 * i + at] = channel.values[i];
    }
    Development light = development_;
    light.style.dither = false;
    color = visible(color, light, {});
    for (std::size_t i = 0; i < alpha.pixels.size(); ++i) {
      const float* shown = &color.pixels[3 * i];
      alpha.pixels[i] =
          std::clamp(std::max({alpha.pixels[i], shown[0], shown[1], shown[2]}), 0.0F, 1.0F);
    }
    color = straight(std::move(color), alpha);
    if (development_.style.dither)
      dither(color);
    ImageNotes notes = text.notes;
    notes.emplace_back("volute.alpha", "straight: colours are not multiplied by it");
    return writePngWithAlpha(path, color, alpha, notes);
  }

  std::optional<FramePattern> pattern_;
  FrameScale scale_;
  std::string target_;
  Development development_;
};

class FilmPictures final : public PictureWriter {
 public:
  FilmPictures(std::unique_ptr<FilmWriter> film, const Development& development)
      : film_(std::move(film)), development_(development) {
    development_.style.dither = false;  // the writer does that where it rounds
  }

  Status write(const Image& image, int, const PictureText& text) override {
    return film_->addFrame(visible(image, development_, text));
  }

  Status writeLayers(int, int, const std::vector<ImageChannel>&, int, const PictureText&) override {
    return fail(ErrorCode::kUnsupported, "a film has no layers");
  }

  Status writeFrame(const FramePixels& frame, int frameNumber) override {
    return write(displayed(frame.color, frame.part), frameNumber, {});
  }

  Status finish() override { return film_->finish(); }

 private:
  std::unique_ptr<FilmWriter> film_;
  Development development_;
};

}  // namespace

void PictureWriter::countHalves(std::span<const float> values) {
  constexpr float kLargest = 65504, kVanishes = 0x1p-25F;  // half of the smallest half float
  for (const float value : values) {
    const float size = std::abs(value);
    if (!std::isfinite(value))
      continue;
    largest_ = std::max(largest_, size);
    cut_ += size > kLargest ? 1 : 0;
    vanished_ += size > 0 && size <= kVanishes ? 1 : 0;
  }
}

std::optional<Remark> PictureWriter::halvesLost(const std::string& target) const {
  constexpr float kSmallest = 0x1p-14F;  // with all digits of a half float
  if (cut_ > 0) {
    return Remark(RemarkCode::kChanged,
                  fmt::format("{}: {} values are beyond 65504, the largest half float, up to {:g}: "
                              "they are cut off there; float32 holds them",
                              target, cut_, largest_))
        .in(target);
  }
  if (largest_ == 0 || largest_ >= kSmallest)
    return std::nullopt;
  return Remark(RemarkCode::kChanged,
                fmt::format("{}: all values are at most {:g}, where half floats are 6e-8 apart: {} "
                            "of them became 0; float32 holds them",
                            target, largest_, vanished_))
      .in(target);
}

bool isFilmPath(const std::string& target) {
  const std::string extension = extensionOf(target);
  return extension == ".mp4" || extension == ".webm";
}

Result<std::unique_ptr<PictureWriter>> imageFileWriter(const std::string& target,
                                                       const Development& development,
                                                       FrameScale scale) {
  std::optional<FramePattern> pattern;
  if (namesSeries(target)) {
    VOLUTE_ASSIGN(pattern, FramePattern::parse(target));
  }
  return std::make_unique<ImageFileWriter>(std::move(pattern), scale, target, development);
}

Result<std::unique_ptr<PictureWriter>> filmWriter(const std::string& target,
                                                  const Development& development, int width,
                                                  int height, double framesPerSecond,
                                                  const std::string& comment) {
  VOLUTE_ASSIGN(auto film, FilmWriter::create(target, width, height, framesPerSecond, comment,
                                              development.film));
  return std::make_unique<FilmPictures>(std::move(film), development);
}

std::string evenSizeText(const std::string& target, int width, int height) {
  const int evenWidth = width + width % 2, evenHeight = height + height % 2;
  if (evenWidth == width && evenHeight == height)
    return "";
  return fmt::format(
      "{}: is {} x {} pixels, for films have even numbers of them: the last column or row of {} x "
      "{} "
      "is repeated",
      target, evenWidth, evenHeight, width, height);
}

}  // namespace volute
