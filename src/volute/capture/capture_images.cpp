// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/capture_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "volute/base/file_name.hpp"
#include "volute/capture/background.hpp"
#include "volute/capture/clocks.hpp"
#include "volute/capture/image_name.hpp"
#include "volute/capture/optical_depth.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/stored_picture.hpp"

namespace volute {
namespace {

/// A power of the size, with the sign as it is.
double powered(double value, double exponent) {
  return exponent == 1 ? value : std::copysign(std::pow(std::abs(value), exponent), value);
}

/// Light for each of the 2^16 values that a stored one can have.
std::vector<float> lightTable(const Response& response, double exponent, double factor) {
  constexpr int kValues = 1 << 16;
  std::vector<float> table(kValues);
  for (int i = 0; i < kValues; ++i)
    table[i] = static_cast<float>(
        factor * powered(response.linear(static_cast<double>(i) / (kValues - 1)), exponent));
  return table;
}

/// White becomes 1 where values have fewer bits than their file.
/// @param largest  the integer that is 1 in the file
Status scaleBits(Image& image, int bits, double largest, const std::string& name) {
  const double white = std::ldexp(1.0, bits) - 1;
  if (bits == 0 || largest <= white)
    return {};
  for (float& value : image.pixels) value = static_cast<float>(value * (largest / white));
  const double brightest = *std::ranges::max_element(image.pixels);
  if (brightest <= 1.0001)
    return {};
  return fail(ErrorCode::kInvalidData,
              "{}: has values up to {:.0f} of {:.0f}, more than the {:.0f} of its \"bits\": {}; "
              "expected values from 0 in a file of more bits, or a larger number of bits",
              name, brightest * white, largest, white, bits);
}

/// 0 = black, 1 = white; below black there is noise.
void subtractBlack(Image& image, double black) {
  if (black == 0)
    return;
  for (float& value : image.pixels) value = static_cast<float>((value - black) / (1 - black));
}

/// What the sensor reads without light, at each pixel. Of integers white stays white.
void subtractDark(const Image& dark, bool linear, Image& image) {
  constexpr float kHot = 0.9F;
  const auto channels = static_cast<std::size_t>(image.channels),
             own = static_cast<std::size_t>(dark.channels);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const float level = dark.pixels[i / channels * own + std::min(i % channels, own - 1)];
    image.pixels[i] = (image.pixels[i] - level) / (linear ? 1 : 1 - std::min(level, kHot));
  }
}

double shareBelowOne(const Image& alpha) {
  const auto count = std::ranges::count_if(alpha.pixels, [](float a) { return a < 1; });
  return static_cast<double>(count) / static_cast<double>(alpha.pixels.size());
}

/// The first frame of which a film can have pictures.
int firstFrameOf(const PictureSource& pictures) {
  return static_cast<int>(std::ceil(pictures.videoStart - pictures.frameShift));
}

/// Whether the film can be read and has the first and the last frame that are wanted, but for those
/// that the camera's shift takes beyond them.
Status checkFilm(const CaptureCamera& camera, int firstFrame, int lastFrame,
                 std::uint64_t maxMemory) {
  const PictureSource& pictures = camera.pictures;
  auto film = FilmReader::open(pictures.video, maxMemory);
  if (!film)
    return fail(film.error().code, film.error().hints, "camera {}: {}", camera.name,
                film.error().message);
  if (film->info().width != camera.camera.width() ||
      film->info().height != camera.camera.height()) {
    return fail(ErrorCode::kInvalidData,
                "camera {}: the film {} has {} x {} pixels; the calibration is for {} x {}",
                camera.name, pictures.video.string(), film->info().width, film->info().height,
                camera.camera.width(), camera.camera.height());
  }
  const double shift = pictures.frameShift;
  firstFrame += static_cast<int>(std::ceil(std::max(-shift, 0.0)));
  lastFrame -= static_cast<int>(std::ceil(std::max(shift, 0.0)));
  if (firstFrame > lastFrame)
    return {};
  if (pictures.placeOf(firstFrame).number < 0) {
    return fail(ErrorCode::kNotFound, "camera {}, frame {}: the film {} begins with frame {}",
                camera.name, firstFrame, pictures.video.string(), firstFrameOf(pictures));
  }
  const PicturePlace last = pictures.placeOf(lastFrame);
  const int wanted = last.number + (last.share > 0 ? 2 : 1);
  const auto there = picturesOfFilm(pictures, maxMemory);
  if (!there)
    return fail(there.error().code, there.error().hints, "camera {}: {}", camera.name,
                there.error().message);
  if (*there < wanted) {
    return fail(ErrorCode::kNotFound,
                "camera {}, frame {}: the film {} has {} frames, so that it ends with frame {}; "
                "choose frames that all cameras have",
                camera.name, lastFrame, pictures.video.string(), *there,
                static_cast<int>(std::floor(pictures.videoStart - shift +
                                            pictures.placeInFilm(*there - 1) / pictures.rate)));
  }
  return {};
}

/// How many pictures each camera has, where they have different numbers of them.
std::string countsText(const Capture& capture, std::span<const std::size_t> there) {
  constexpr std::size_t kMax = 6;
  if (capture.frames.size() < 2)
    return "";
  std::vector<std::string> fewer;
  for (std::size_t i = 0; i < there.size(); ++i) {
    if (!capture.cameras[i].pictures.image.empty() && there[i] < capture.frames.size())
      fewer.push_back(fmt::format("{} has {}", capture.cameras[i].name, there[i]));
  }
  const std::size_t more = fewer.size() > kMax ? fewer.size() - kMax : 0;
  fewer.resize(fewer.size() - more);
  return fmt::format(": of {} frames {}{}", capture.frames.size(), fmt::join(fewer, ", "),
                     more > 0 ? fmt::format(" and {} more cameras fewer too", more) : "");
}

/// "picture c_0004.png", "page 4 of c.tif".
std::string nameOfPicture(const PictureSource& pictures, int number) {
  const std::string file = pictures.fileOf(number).string();
  return pictures.pages == 1 ? "picture " + file : fmt::format("page {} of {}", number, file);
}

/// One channel becomes three.
Image inColour(Image image) {
  if (image.channels == 3)
    return image;
  Image colour(image.width, image.height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    std::fill_n(&colour.pixels[3 * i], 3, image.pixels[i]);
  return colour;
}

}  // namespace

std::string CaptureImages::nameOf(std::size_t camera, int frame) const {
  return fmt::format("camera {}, frame {}", capture_->cameras[camera].name, frame);
}

Status CaptureImages::checkSize(std::size_t camera, const Image& image,
                                const std::string& name) const {
  const Camera& expected = capture_->cameras[camera].camera;
  if (image.width == expected.width() && image.height == expected.height())
    return {};
  if (image.width == expected.height() && image.height == expected.width()) {
    return fail(ErrorCode::kInvalidData,
                "{}: the picture has {} x {} pixels and the calibration says {} x {}: width and "
                "height are swapped in one of them",
                name, image.width, image.height, expected.width(), expected.height());
  }
  return fail(ErrorCode::kInvalidData,
              "{}: the picture has {} x {} pixels; the calibration is for {} x {}", name,
              image.width, image.height, expected.width(), expected.height());
}

namespace {

/// (height, width), bit c: channel c reads `saturation` or more.
std::vector<std::uint8_t> saturatedIn(const Image& image, const std::array<double, 3>& saturation) {
  const auto channels = static_cast<std::size_t>(image.channels);
  std::vector<std::uint8_t> atLeast(image.pixels.size() / channels);
  for (std::size_t i = 0; i < atLeast.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (image.pixels[channels * i + (channels == 3 ? c : 0)] >= saturation[c] - 1e-6)
        atLeast[i] |= static_cast<std::uint8_t>(1U << c);
    }
  }
  return atLeast;
}

/// The first row on top.
void turnUp(const PictureSource& pictures, Image& image) {
  const std::size_t row = static_cast<std::size_t>(image.width) * image.channels;
  for (int y = 0; pictures.bottomUp && y < image.height / 2; ++y) {
    const auto upper = image.pixels.begin() + static_cast<std::ptrdiff_t>(y * row);
    std::swap_ranges(upper, upper + static_cast<std::ptrdiff_t>(row),
                     image.pixels.end() - static_cast<std::ptrdiff_t>((y + 1) * row));
  }
}

}  // namespace

Result<CaptureImages::Stored> CaptureImages::readFile(std::size_t camera,
                                                      const std::filesystem::path& path,
                                                      const std::string& name, int page) const {
  const auto& pictures = capture_->cameras[camera].pictures;
  Stored stored;
  auto read = readStoredPicture(path, maxMemory_, page);
  if (!read)
    return fail(read.error().code, read.error().hints, "{}: {}", name, read.error().message);
  stored.linear = read->linear;
  stored.image = std::move(read->image);
  stored.there = std::move(read->there);
  VOLUTE_TRY(checkSize(camera, stored.image, name));
  turnUp(pictures, stored.image);
  if (pictures.bottomUp && !stored.there.empty()) {
    Image there(stored.image.width, stored.image.height, 1);
    std::ranges::copy(stored.there, there.pixels.begin());
    turnUp(pictures, there);
    std::ranges::transform(there.pixels, stored.there.begin(),
                           [](float is) { return static_cast<std::uint8_t>(is); });
  }
  // NOLINTNEXTLINE(bugprone-unchecked-optional-access): 'read->' names the same optional
  stored.transparentShare = read->alpha ? shareBelowOne(*read->alpha) : 0;
  if (!stored.linear && stored.transparentShare > 0) {
    return fail(ErrorCode::kInvalidData,
                "{}: {:.1f} % of the pixels of {} are transparent, so their light is unknown; "
                "expected opaque pictures, of the medium over its background",
                name, 100 * stored.transparentShare, path.string());
  }
  if (pictures.response) {
    stored.response = *pictures.response;
  } else if (read->curve) {
    // NOLINTNEXTLINE(bugprone-unchecked-optional-access): as above
    VOLUTE_ASSIGN(stored.response, Response::table(std::move(*read->curve)));
  }
  constexpr double kNever = std::numeric_limits<double>::infinity();
  stored.saturation.fill(pictures.saturation.value_or(stored.linear ? kNever : 1));
  stored.mosaic = isMosaic(stored.image);
  if (stored.linear) {
    findIntegers(camera, stored);
    return stored;
  }
  // NOLINTNEXTLINE(bugprone-unchecked-optional-access): as above
  stored.largest = read->largest;
  VOLUTE_TRY(scaleBits(stored.image, pictures.bits, stored.largest, name));
  if (!pictures.saturation && pictures.bits == 0) {
    stored.plateau = plateauOf(stored.image, stored.largest);
    stored.bitsHolding = bitsHolding(stored.image, stored.largest);
  }
  if (stored.plateau) {
    // An evenly lit background is the brightest of a picture, and ends at no number of bits.
    stored.plateau->saturated = capture_->measured == Measured::kEmission ||
                                bitsOf(stored.plateau->value, stored.largest).has_value();
    if (stored.plateau->saturated)
      stored.saturation.fill(stored.plateau->value);
  }
  if (!pictures.saturation && pictures.bits == 0 && capture_->measured == Measured::kEmission) {
    stored.channelLimits = channelLimits(stored.image, stored.saturation[0]);
    stored.saturation = stored.channelLimits.value_or(stored.saturation);
  }
  subtractBlack(stored.image, pictures.black);
  for (double& limit : stored.saturation) limit = (limit - pictures.black) / (1 - pictures.black);
  return stored;
}

/// Floats that are no light yet. Those of absorption are compared with a background of their kind.
void CaptureImages::findIntegers(std::size_t camera, Stored& stored) const {
  constexpr double kNearlyOne = 0.1;  // less is stated where counts are known
  const PictureSource& pictures = capture_->cameras[camera].pictures;
  if (capture_->measured != Measured::kEmission)
    return;
  if (capture_->white * pictures.lightGain() > kNearlyOne)
    stored.counts = countsOf(stored.image);
  const bool encoded = pictures.response && pictures.response->kind() != Response::Kind::kLinear;
  stored.dividedIntegers = encoded && areDividedIntegers(stored.image);
}

Result<CaptureImages::Stored> CaptureImages::readStored(std::size_t camera, int number, int frame) {
  const auto& pictures = capture_->cameras[camera].pictures;
  const std::string name = nameOf(camera, frame);
  if (pictures.video.empty()) {
    const std::filesystem::path path = pictures.fileOf(number);
    std::error_code error;
    if (!pictures.isThere(number))
      return fail(ErrorCode::kNotFound, "{}: there is no {}", name,
                  nameOfPicture(pictures, number));
    if (std::filesystem::file_size(path, error) == 0 && !error)
      return fail(ErrorCode::kNotFound, "{}: the picture {} is empty, 0 bytes", name,
                  path.string());
    return readFile(camera, path, name, pictures.pages == 1 ? 0 : number);
  }
  auto film = films_.find(camera);
  if (film == films_.end()) {
    auto opened = FilmFrames::open(pictures.video, maxMemory_);
    if (!opened)
      return fail(opened.error().code, opened.error().hints, "{}: {}", name,
                  opened.error().message);
    film = films_.emplace(camera, std::move(*opened)).first;
  }
  if (number < 0) {
    return fail(ErrorCode::kNotFound, "{}: the film {} begins with frame {}", name,
                pictures.video.string(), firstFrameOf(pictures));
  }
  auto image = film->second.frame(number);
  if (!image)
    return fail(image.error().code, image.error().hints, "{}: {}", name, image.error().message);
  VOLUTE_TRY(checkSize(camera, *image, name));
  Stored stored;
  stored.image = std::move(*image);
  turnUp(pictures, stored.image);
  for (float& value : stored.image.pixels) value = static_cast<float>(srgbEncode(value));
  stored.response = pictures.response.value_or(Response::srgb());
  constexpr double kFilmWhite = 250.0 / 255;  // lossy coding scatters saturated values
  subtractBlack(stored.image, pictures.black);
  stored.saturation.fill((pictures.saturation.value_or(kFilmWhite) - pictures.black) /
                         (1 - pictures.black));
  return stored;
}

namespace {

void multiplyChannels(const Rgb& by, Image& image) {
  if ((by == 1).all())
    return;
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] *= static_cast<float>(by[static_cast<int>(i % 3)]);
}

}  // namespace

Image CaptureImages::linearised(std::size_t camera, const Stored& stored) const {
  const auto& pictures = capture_->cameras[camera].pictures;
  // Of absorption the gain would cancel out; it is one of the depths.
  const bool light = capture_->measured == Measured::kEmission;
  const double factor = capture_->white * (light ? pictures.lightGain() : 1 / pictures.exposure);
  Image image = stored.image;
  if (stored.linear) {
    for (float& value : image.pixels)
      value = static_cast<float>(factor * powered(value, pictures.exponent));
  } else {
    const auto table = lightTable(stored.response, pictures.exponent, factor);
    const float top = static_cast<float>(table.size() - 1);
    for (float& value : image.pixels) {
      const float size = table[static_cast<std::size_t>(
          std::lround(std::clamp(std::abs(value), 0.0f, 1.0f) * top))];
      value = value < 0 ? -size : size;
    }
  }
  image = inColour(std::move(image));
  if (light)
    multiplyChannels(pictures.channelGain, image);
  return image;
}

Status CaptureImages::openDark(std::size_t camera) {
  const auto& file = capture_->cameras[camera].pictures.dark;
  if (file.empty())
    return {};
  const std::string name = fmt::format("camera {}, dark", capture_->cameras[camera].name);
  VOLUTE_ASSIGN(auto stored, readFile(camera, file, name));
  if (!stored.there.empty() ||
      !std::ranges::all_of(stored.image.pixels, [](float value) { return std::isfinite(value); }))
    return fail(ErrorCode::kInvalidData, "{}: {} has pixels without a value", name, file.string());
  darks_[camera] = std::move(stored);
  return {};
}

Status CaptureImages::withoutDark(std::size_t camera, Stored& stored) const {
  const Stored& dark = darks_[camera];
  if (dark.image.pixels.empty())
    return {};
  if (dark.linear != stored.linear)
    return fail(ErrorCode::kInvalidData,
                "camera {}, dark: {} holds {}, and what it is subtracted from does not; expected "
                "pictures of one kind",
                capture_->cameras[camera].name, capture_->cameras[camera].pictures.dark.string(),
                dark.linear ? "floats" : "integers");
  subtractDark(dark.image, stored.linear, stored.image);
  return {};
}

Status CaptureImages::openMask(std::size_t camera) {
  const PictureSource& pictures = capture_->cameras[camera].pictures;
  const auto& path = pictures.mask;
  if (path.empty())
    return {};
  const std::string name = fmt::format("camera {}, mask", capture_->cameras[camera].name);
  auto stored = readStoredPicture(path, maxMemory_);
  if (!stored)
    return fail(stored.error().code, stored.error().hints, "{}: {}", name, stored.error().message);
  Image& image = stored->image;
  VOLUTE_TRY(checkSize(camera, image, name));
  turnUp(pictures, image);
  auto& mask = masks_[camera];
  const auto channels = static_cast<std::size_t>(image.channels);
  mask.resize(image.pixels.size() / channels);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    mask[i / channels] |= image.pixels[i] > 0 ? 1 : 0;
  if (auto& alpha = stored->alpha) {
    turnUp(pictures, *alpha);
    std::size_t transparent = 0;
    for (std::size_t i = 0; i < mask.size(); ++i) {
      if (alpha->pixels[i] > 0)
        continue;
      mask[i] = 0;
      ++transparent;
    }
    transparentMasks_[camera] = static_cast<double>(transparent) / static_cast<double>(mask.size());
  }
  if (std::ranges::none_of(mask, [](char m) { return m != 0; })) {
    return fail(ErrorCode::kInvalidData, "{}: {} is 0 {}everywhere, so no pixel counts", name,
                path.string(), transparentMasks_[camera] > 0 ? "or transparent " : "");
  }
  return {};
}

/// Of the empty frames. A channel counts as saturated where it is so in half of them.
Result<Image> CaptureImages::medianBackground(std::size_t camera, Progress& progress) {
  const auto& frames = capture_->emptyFrames;
  PictureSource unshifted = capture_->cameras[camera].pictures;
  unshifted.frameShift = 0;              // that goes for clocks, and nothing moves here
  std::vector<std::uint32_t> saturated;  // (height, width, 3), in how many frames
  std::size_t taken = 0;
  VOLUTE_ASSIGN(
      Image median, medianImage(frames.size(), maxMemory_, [&](std::size_t i) -> Result<Image> {
        progress.report("backgrounds", static_cast<double>(camera * frames.size() + i),
                        static_cast<double>(capture_->cameras.size() * frames.size()));
        if (progress.cancelled())
          return fail(ErrorCode::kCancelled, "stopped: reading backgrounds");
        VOLUTE_ASSIGN(Seen seen, readSeen(camera, unshifted.placeOf(frames[i]).number, frames[i]));
        saturated.resize(3 * seen.atLeast.size());
        for (std::size_t j = 0; j < saturated.size(); ++j)
          saturated[j] += (seen.atLeast[j / 3] >> (j % 3)) & 1U;
        ++taken;
        return std::move(seen.light);
      }));
  auto& atLeast = backgroundsAtLeast_[camera];
  atLeast.assign(saturated.size() / 3, 0);
  for (std::size_t j = 0; j < saturated.size(); ++j) {
    if (2 * saturated[j] >= taken)
      atLeast[j / 3] |= static_cast<std::uint8_t>(1U << (j % 3));
  }
  return median;
}

Status CaptureImages::openBackground(std::size_t camera, Progress& progress) {
  const auto& pictures = capture_->cameras[camera].pictures;
  if (!pictures.background.empty()) {
    const std::string name = fmt::format("camera {}, background", capture_->cameras[camera].name);
    VOLUTE_ASSIGN(auto stored, readFile(camera, pictures.background, name));
    if (!stored.there.empty())
      return fail(ErrorCode::kInvalidData,
                  "{}: {} holds nothing for a part of its pixels (data window); expected a whole "
                  "picture",
                  name, pictures.background.string());
    backgroundsAtLeast_[camera] = saturatedIn(stored.image, stored.saturation);
    VOLUTE_TRY(withoutDark(camera, stored));
    backgrounds_[camera] = linearised(camera, stored);
  } else if (!capture_->emptyFrames.empty()) {
    VOLUTE_ASSIGN(backgrounds_[camera], medianBackground(camera, progress));
  }
  for (const float value : backgrounds_[camera].pixels) {
    if (!std::isfinite(value))
      return fail(ErrorCode::kInvalidData,
                  "camera {}: its background has a value that is not finite",
                  capture_->cameras[camera].name);
  }
  if (backgrounds_[camera].pixels.empty()) {
    if (capture_->measured == Measured::kEmission)
      return {};
    return fail(ErrorCode::kInvalidData,
                "camera {}: its background is missing; pictures of a lit background through the "
                "medium (\"kind\": \"absorption\") are compared with one of the background "
                "alone: state \"background\", or \"empty_frames\" for all cameras",
                capture_->cameras[camera].name);
  }
  if (!capture_->volume.bounds.empty())
    beside_[camera] = pixelsBeside(capture_->cameras[camera].camera, capture_->volume.bounds);
  return {};
}

Result<CaptureImages> CaptureImages::open(const Capture& capture, std::uint64_t maxMemory,
                                          Progress& progress) {
  CaptureImages images(capture, maxMemory);
  images.masks_.resize(capture.cameras.size());
  images.transparentMasks_.resize(capture.cameras.size());
  images.darks_.resize(capture.cameras.size());
  images.backgrounds_.resize(capture.cameras.size());
  images.backgroundsAtLeast_.resize(capture.cameras.size());
  images.beside_.resize(capture.cameras.size());
  for (std::size_t camera = 0; camera < capture.cameras.size(); ++camera) {
    VOLUTE_TRY(images.openMask(camera));
    VOLUTE_TRY(images.openDark(camera));
    VOLUTE_TRY(images.openBackground(camera, progress));
  }
  return images;
}

Result<CaptureImages::Seen> CaptureImages::readSeen(std::size_t camera, int number, int frame) {
  VOLUTE_ASSIGN(Stored stored, readStored(camera, number, frame));
  auto atLeast = saturatedIn(stored.image, stored.saturation);
  VOLUTE_TRY(withoutDark(camera, stored));
  Seen seen{number,
            linearised(camera, stored),
            std::move(atLeast),
            stored.transparentShare,
            stored.image.channels == 1,
            stored.mosaic,
            stored.plateau,
            stored.bitsHolding,
            stored.largest,
            stored.linear ? std::nullopt : std::optional(stored.response),
            stored.there,
            stored.channelLimits,
            stored.counts,
            stored.dividedIntegers};
  return seen;
}

Result<CaptureImages::Seen> CaptureImages::readKept(std::size_t camera, int number, int frame) {
  auto& kept = kept_[camera];
  for (const Seen& seen : kept) {
    if (seen.number == number)
      return seen;
  }
  VOLUTE_ASSIGN(Seen seen, readSeen(camera, number, frame));
  std::swap(kept[0], kept[1]);
  kept[1] = seen;
  return seen;
}

/// The light between two pictures goes from one to the other evenly.
Result<CaptureImages::Seen> CaptureImages::readAt(std::size_t camera, int frame) {
  const PicturePlace place = capture_->cameras[camera].pictures.placeOf(frame);
  if (place.share == 0 && kept_.find(camera) == kept_.end())
    return readSeen(camera, place.number, frame);
  VOLUTE_ASSIGN(Seen seen, readKept(camera, place.number, frame));
  if (place.share == 0)
    return seen;
  VOLUTE_ASSIGN(const Seen next, readKept(camera, place.number + 1, frame));
  const auto late = static_cast<float>(place.share);
  for (std::size_t i = 0; i < seen.light.pixels.size(); ++i)
    seen.light.pixels[i] += late * (next.light.pixels[i] - seen.light.pixels[i]);
  for (std::size_t i = 0; i < seen.atLeast.size(); ++i) seen.atLeast[i] |= next.atLeast[i];
  if (seen.there.empty())
    seen.there = next.there;
  for (std::size_t i = 0; i < next.there.size(); ++i) seen.there[i] &= next.there[i];
  seen.transparentShare = std::max(seen.transparentShare, next.transparentShare);
  if (!seen.plateau)
    seen.plateau = next.plateau;
  if (!seen.channelLimits)
    seen.channelLimits = next.channelLimits;
  seen.bitsHolding = std::max(seen.bitsHolding, next.bitsHolding);
  return seen;
}

Result<CameraPicture> CaptureImages::read(std::size_t camera, int frame) {
  VOLUTE_ASSIGN(Seen seen, readAt(camera, frame));
  const auto& mask = masks_[camera];
  CameraPicture picture;
  picture.radiance = std::move(seen.light);
  picture.transparentShare = seen.transparentShare;
  picture.grey = seen.grey;
  picture.mosaic = seen.mosaic;
  picture.plateau = seen.plateau;
  picture.bitsHolding = seen.bitsHolding;
  picture.largest = seen.largest;
  picture.channelLimits = seen.channelLimits;
  picture.counts = seen.counts;
  picture.dividedIntegers = seen.dividedIntegers;
  picture.transparentMask = transparentMasks_[camera];
  const std::size_t pixels = seen.atLeast.size();
  picture.weight.assign(pixels, 1);
  picture.atLeast.assign(pixels, 0);
  std::size_t masked = 0, saturated = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    float* light = &picture.radiance.pixels[3 * i];
    if ((!mask.empty() && !mask[i]) || (!seen.there.empty() && !seen.there[i])) {
      ++masked;
      picture.weight[i] = 0;
      std::fill_n(light, 3, 0.0f);  // whatever stands there, also NaN
      continue;
    }
    if (!std::isfinite(light[0]) || !std::isfinite(light[1]) || !std::isfinite(light[2])) {
      const auto width = static_cast<std::size_t>(picture.radiance.width);
      return fail(
          ErrorCode::kInvalidData,
          "{}: the value at pixel ({}, {}) is not finite; mask it (0 = ignore) or render the "
          "picture again",
          nameOf(camera, frame), i % width, i / width);
    }
    picture.atLeast[i] = seen.atLeast[i];
    if (picture.atLeast[i] != 0) {
      ++saturated;
      picture.weight[i] = 0;
    }
    for (int c = 0; c < 3; ++c) picture.brightest = std::max<double>(picture.brightest, light[c]);
  }
  picture.maskedShare = static_cast<double>(masked) / static_cast<double>(pixels);
  picture.saturatedShare = static_cast<double>(saturated) /
                           static_cast<double>(std::max<std::size_t>(1, pixels - masked));
  if (!backgrounds_[camera].pixels.empty())
    subtractBackground(camera, picture);
  else
    subtractPedestal(camera, seen.response, picture);
  return picture;
}

/// Without a background, what all pixels beside the volume show evenly is none of its light. Of
/// stored values it is a black level, as "black" states one; of floats, light that is added.
void CaptureImages::subtractPedestal(std::size_t camera, const std::optional<Response>& response,
                                     CameraPicture& picture) {
  const CaptureCamera& known = capture_->cameras[camera];
  if (capture_->volume.bounds.empty() || capture_->measured != Measured::kEmission)
    return;
  std::vector<std::uint8_t>& beside = beside_[camera];
  if (beside.empty())
    beside = pixelsBeside(known.camera, capture_->volume.bounds);
  std::vector<std::uint8_t> pixels = beside;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (picture.weight[i] == 0)
      pixels[i] = 0;
  }
  const auto pedestal = findPedestal(picture.radiance, pixels);
  if (!pedestal)
    return;
  const PictureSource& source = known.pictures;
  const Rgb white = capture_->white * source.lightGain() * source.channelGain;
  const std::vector<float> light =
      lightTable(response.value_or(Response()), response ? source.exponent : 1, 1);
  const auto top = static_cast<double>(light.size() - 1);
  const auto storedOf = [&](double value) {
    const auto above = std::ranges::lower_bound(light, static_cast<float>(std::abs(value)));
    return std::copysign(std::min(static_cast<double>(above - light.begin()), top) / top, value);
  };
  const auto lightOf = [&](double stored) {
    const double size =
        light[static_cast<std::size_t>(std::lround(std::clamp(std::abs(stored), 0.0, 1.0) * top))];
    return stored < 0 ? -size : size;
  };
  const Rgb linear = *pedestal / white;
  const Rgb black = linear.unaryExpr(storedOf);
  picture.storedPedestal = source.black + (1 - source.black) * black.mean();
  for (std::size_t i = 0; i < picture.radiance.pixels.size(); ++i) {
    if (picture.weight[i / 3] == 0 && picture.atLeast[i / 3] == 0)
      continue;  // masked
    const auto c = i % 3;
    float& value = picture.radiance.pixels[i];
    if (response)
      value = static_cast<float>(white[c] *
                                 lightOf((storedOf(value / white[c]) - black[c]) / (1 - black[c])));
    else
      value -= static_cast<float>((*pedestal)[c]);
  }
}

void CaptureImages::subtractBackground(std::size_t camera, CameraPicture& picture) const {
  Image background = backgrounds_[camera];
  if (std::vector<std::uint8_t> pixels = beside_[camera]; !pixels.empty()) {
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (picture.weight[i] == 0 || backgroundsAtLeast_[camera][i] != 0)
        pixels[i] = 0;
    }
    picture.drift = findBackgroundDrift(picture.radiance, background, pixels);
    if (picture.drift)
      background = picture.drift->applied(background);
  }
  std::vector<float>& light = picture.radiance.pixels;
  if (capture_->measured == Measured::kEmission) {
    for (std::size_t i = 0; i < light.size(); ++i) {
      const bool masked = picture.weight[i / 3] == 0 && picture.atLeast[i / 3] == 0;
      light[i] -= masked ? 0 : background.pixels[i];
    }
    picture.background = std::move(background);
    return;
  }
  constexpr double kSigmas = 3;
  OpticalDepths depths = opticalDepths(picture.radiance, background, picture.weight,
                                       kSigmas * capture_->noiseSigma.value_or(0));
  picture.radiance = std::move(depths.depth);
  picture.weight = std::move(depths.weight);
  picture.atLeast = std::move(depths.atLeast);
  picture.opaqueShare = depths.opaqueShare;
  picture.levelLeft = depths.levelLeft;
  // Where the background is saturated it is brighter than it reads, and the depth larger.
  std::size_t lit = 0, saturated = 0;
  for (std::size_t i = 0; i < picture.weight.size(); ++i) {
    if (picture.weight[i] == 0 && picture.atLeast[i] == 0)
      continue;
    ++lit;
    if (const std::uint8_t bits = backgroundsAtLeast_[camera][i]; bits != 0) {
      ++saturated;
      picture.atLeast[i] |= bits;
      picture.weight[i] = 0;
    }
  }
  picture.litBackgroundSaturated =
      static_cast<double>(saturated) / static_cast<double>(std::max<std::size_t>(1, lit));
  const auto gain = static_cast<float>(capture_->cameras[camera].pictures.gain);
  for (float& depth : picture.radiance.pixels) depth *= gain;
  multiplyChannels(capture_->cameras[camera].pictures.channelGain, picture.radiance);
}

namespace {

/// Which pictures of frames are there, and which are not.
struct PicturesThere {
  std::string first;  // the first that is not
  std::size_t missing = 0, empty = 0, all = 0;
  std::vector<std::size_t> there, wanted;  // one a camera
  std::vector<std::vector<int>> gone;      // one a camera: frames
  std::optional<int> thin;                 // a frame that too few cameras see
};

PicturesThere lookForPictures(const Capture& capture) {
  constexpr std::size_t kFewestCameras = 3;
  std::error_code error;
  const std::size_t cameras = capture.cameras.size();
  PicturesThere found;
  found.there.resize(cameras);
  found.wanted.resize(cameras);
  found.gone.resize(cameras);
  for (const int frame : capture.frames) {
    std::size_t seeing = cameras;
    bool incomplete = false;
    for (std::size_t i = 0; i < cameras; ++i) {
      const CaptureCamera& camera = capture.cameras[i];
      if (camera.pictures.image.empty())
        continue;
      const double shifted = frame + camera.pictures.frameShift;
      const bool beyond = shifted < capture.frames.front() || shifted > capture.frames.back();
      const PicturePlace place = camera.pictures.placeOf(frame);
      const int next = place.number + (place.share > 0 ? 1 : 0);
      const int number = camera.pictures.isThere(next) ? place.number : next;
      const auto path = camera.pictures.fileOf(number);
      const bool exists = camera.pictures.isThere(number);
      const bool is = exists && std::filesystem::file_size(path, error) != 0;
      if (beyond && !is) {
        --seeing;
        continue;
      }
      ++found.all;
      ++found.wanted[i];
      if (is) {
        ++found.there[i];
        continue;
      }
      ++(exists ? found.empty : found.missing);
      --seeing;
      incomplete = true;
      found.gone[i].push_back(frame);
      if (found.first.empty()) {
        found.first =
            fmt::format("camera {}, frame {}: {}", camera.name, frame,
                        exists ? fmt::format("the picture {} is empty, 0 bytes", path.string())
                               : "there is no " + nameOfPicture(camera.pictures, number));
      }
    }
    if (incomplete && seeing < kFewestCameras && !found.thin)
      found.thin = frame;
  }
  return found;
}

}  // namespace

Result<std::vector<std::string>> checkPicturesThere(const Capture& capture, bool force,
                                                    std::uint64_t maxMemory) {
  std::error_code error;
  for (const CaptureCamera& camera : capture.cameras) {
    const PictureSource& pictures = camera.pictures;
    if (!pictures.video.empty())
      VOLUTE_TRY(checkFilm(camera, capture.frames.front(), capture.frames.back(), maxMemory));
    for (const auto& [file, what] :
         {std::pair(&pictures.background, "background"), std::pair(&pictures.dark, "dark"),
          std::pair(&pictures.mask, "mask")}) {
      if (!file->empty() && !std::filesystem::exists(*file, error)) {
        return fail(ErrorCode::kNotFound, "camera {}, {}: there is no picture {}", camera.name,
                    what, file->string());
      }
    }
  }
  const PicturesThere found = lookForPictures(capture);
  std::vector<std::string> remarks;
  bool many = found.thin.has_value();
  for (std::size_t i = 0; i < capture.cameras.size(); ++i) {
    const CaptureCamera& camera = capture.cameras[i];
    const bool none = !camera.pictures.image.empty() && found.there[i] == 0;
    if (none && found.wanted[i] == 0) {  // its shift takes it beyond all frames
      return fail(
          ErrorCode::kNotFound,
          "camera {}: has no picture of frames {} to {}: of the first it would be {}; check "
          "its frame_shift, video_start or start_time",
          camera.name, capture.frames.front(), capture.frames.back(),
          nameOfPicture(camera.pictures, camera.pictures.placeOf(capture.frames.front()).number));
    }
    if (found.gone[i].empty())
      continue;
    many = many || 2 * found.there[i] < found.wanted[i];
    constexpr std::size_t kNamed = 5;
    std::vector<int> named(found.gone[i].begin(),
                           found.gone[i].begin() +
                               static_cast<std::ptrdiff_t>(std::min(kNamed, found.gone[i].size())));
    remarks.push_back(fmt::format(
        "camera {}: {} of {} pictures {} missing, of frame{} {}{}; there it does not count",
        camera.name, found.gone[i].size(), found.wanted[i],
        found.gone[i].size() == 1 ? "is" : "are", found.gone[i].size() == 1 ? "" : "s",
        fmt::join(named, ", "), named.size() < found.gone[i].size() ? " and more" : ""));
  }
  if (found.missing + found.empty == 0 || (force && found.missing + found.empty < found.all) ||
      (!many && !force))
    return remarks;
  const char* what = found.empty == 0     ? "missing"
                     : found.missing == 0 ? "empty"
                                          : "missing or empty";
  Hints hints;
  if (found.missing + found.empty < found.all)
    hints.push_back(Hint::set("force").so("goes on without them"));
  return fail(ErrorCode::kNotFound, hints, "{}; {} of {} pictures are {}{}", found.first,
              found.missing + found.empty, found.all, what, countsText(capture, found.there));
}

}  // namespace volute
