// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/film/picture_writer.hpp"

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
    return writeImage(path,
                      extensionOf(target_) == ".exr" ? image : developed(image, development_, text),
                      text.notes);
  }

  Status writeLayers(int width, int height, const std::vector<ImageChannel>& channels,
                     int frameNumber, const PictureText& text) override {
    const auto path =
        pattern_ ? pattern_->format(frameNumber, scale_) : std::filesystem::path(target_);
    return writeChannels(path, width, height, channels, text.notes);
  }

  Status finish() override { return {}; }

 private:
  std::optional<FramePattern> pattern_;
  FrameScale scale_;
  std::string target_;
  Development development_;
};

class FilmPictures final : public PictureWriter {
 public:
  FilmPictures(std::unique_ptr<FilmWriter> film, const Development& development)
      : film_(std::move(film)), development_(development) {}

  Status write(const Image& image, int, const PictureText& text) override {
    return film_->addFrame(developed(image, development_, text));
  }

  Status writeLayers(int, int, const std::vector<ImageChannel>&, int, const PictureText&) override {
    return fail(ErrorCode::kUnsupported, "a film has no layers");
  }

  Status finish() override { return film_->finish(); }

 private:
  std::unique_ptr<FilmWriter> film_;
  Development development_;
};

}  // namespace

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
  VOLUTE_ASSIGN(auto film, FilmWriter::create(target, width, height, framesPerSecond, comment));
  return std::make_unique<FilmPictures>(std::move(film), development);
}

}  // namespace volute
