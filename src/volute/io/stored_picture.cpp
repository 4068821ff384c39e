// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/stored_picture.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <memory>
#include <span>
#include <string>

#include "volute/base/file_name.hpp"
#include "volute/base/input_file.hpp"
#include "volute/base/number_word.hpp"
#include "volute/io/frame_file.hpp"
#include "volute/io/image_formats.hpp"
#include "volute/io/npy_header.hpp"
#include "volute/io/number_file.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/reader_process.hpp"
#include "volute/io/stored_color.hpp"

namespace volute {
namespace {

/// What the process that reads a .tif is asked for.
struct StillRequest {
  enum What : std::int32_t { kInfo, kValues, kProfile };

  std::int32_t what = kInfo, page = 0;
};

Result<ReaderProcess::Serve> serveStills(std::string_view parameters) {
  VOLUTE_ASSIGN(const StillPlugin* plugin, loadTiffPlugin());
  return [file = std::filesystem::path(parameters), plugin](
             std::string_view text, std::span<float> values) -> Result<std::string> {
    VOLUTE_ASSIGN(const auto request, fromMessage<StillRequest>(text));
    if (request.what == StillRequest::kProfile)
      return plugin->profile(file, request.page);
    if (request.what == StillRequest::kValues) {
      VOLUTE_TRY(plugin->read(file, request.page, values));
      return std::string();
    }
    VOLUTE_ASSIGN(const StillInfo info, plugin->describe(file, request.page));
    return toMessage(info);
  };
}

/// One .tif, read in a child process.
class TiffFile {
 public:
  static Result<TiffFile> open(const std::filesystem::path& path, std::uint64_t maxMemory) {
    VOLUTE_ASSIGN(const auto file, InputFile::open(path));
    TiffFile tiff;
    tiff.path_ = path;
    tiff.limits_ = {.memory = maxMemory, .seconds = 3 + 1e-6 * static_cast<double>(file.size())};
    tiff.process_ = std::make_unique<ReaderProcess>(ReaderJob{serveStills, path.string(), {path}});
    return tiff;
  }

  Result<StillInfo> describe(int page) {
    VOLUTE_ASSIGN(const std::string reply, call(StillRequest::kInfo, page, 0));
    VOLUTE_ASSIGN(StillInfo info, fromMessage<StillInfo>(reply));
    settleFlag(info.alpha);
    const int colors = info.channels - (info.alpha ? 1 : 0);
    if ((colors != 1 && colors != 3) || info.bits < 0 || info.bits > 32 || info.pages < 1)
      return fail(ErrorCode::kInvalidData, "{}: not a whole TIFF picture", path_.string());
    return info;
  }

  Result<StoredPicture> read(int page, std::uint64_t maxMemory) {
    VOLUTE_ASSIGN(const StillInfo info, describe(page));
    VOLUTE_TRY(checkImageSize(path_, info.width, info.height, info.channels, maxMemory));
    const auto pixels = static_cast<std::size_t>(info.width) * info.height;
    const auto each = static_cast<std::size_t>(info.channels);
    VOLUTE_TRY(call(StillRequest::kValues, page, pixels * each));
    const std::size_t colors = each - (info.alpha ? 1 : 0);
    StoredPicture picture{Image(info.width, info.height, static_cast<int>(colors))};
    if (info.alpha)
      picture.alpha = Image(info.width, info.height, 1);
    const float* value = process_->values().data();
    for (std::size_t i = 0; i < pixels; ++i, value += each) {
      std::copy_n(value, colors, &picture.image.pixels[i * colors]);
      if (info.alpha)
        // NOLINTNEXTLINE(bugprone-unchecked-optional-access): made above
        picture.alpha->pixels[i] = value[colors];
    }
    picture.linear = info.bits == 0;
    picture.largest = picture.linear ? 1 : std::ldexp(1.0, info.bits) - 1;
    if (!picture.linear) {
      VOLUTE_ASSIGN(const auto color, stated(page, picture.image.channels));
      if (color) {
        VOLUTE_ASSIGN(picture.curve, sampledCurve(*color, path_));
      }
    }
    return picture;
  }

  Result<PictureKind> kind(int page) {
    VOLUTE_ASSIGN(const StillInfo info, describe(page));
    PictureKind kind{info.bits == 0, info.pages, info.channels - (info.alpha ? 1 : 0)};
    if (kind.linear)
      return kind;
    kind.largest = std::ldexp(1.0, info.bits) - 1;
    const auto color = stated(page, kind.channels);
    if (!color || !*color)
      return kind;
    if (auto curve = sampledCurve(**color, path_)) {  // else it is told when the picture is read
      kind.stated = "an ICC profile";
      kind.curve = std::move(*curve);
    }
    return kind;
  }

 private:
  Result<std::string> call(StillRequest::What what, int page, std::size_t values) {
    return process_->call(path_.string(), toMessage(StillRequest{what, page}), values, limits_);
  }

  /// By the ICC profile of integers; nothing where there is none.
  Result<std::optional<StoredColor>> stated(int page, int channels) {
    VOLUTE_ASSIGN(const std::string profile, call(StillRequest::kProfile, page, 0));
    if (profile.empty())
      return std::optional<StoredColor>();
    auto color = colorOfProfile(std::as_bytes(std::span(profile)), channels < 3);
    if (!color)
      return fail(color.error().code, color.error().hints, "{}: {}; expected a picture in sRGB",
                  path_.string(), color.error().message);
    return std::optional(std::move(*color));
  }

  std::filesystem::path path_;
  ReaderProcess::Limits limits_;
  std::unique_ptr<ReaderProcess> process_;
};

/// The front of a picture of Netpbm.
struct PnmHeader {
  int width = 0, height = 0, channels = 1;
  bool text = false, floats = false, bigEndian = true;
  double largest = 255;
  double scale = 1;       ///< of floats
  std::size_t begin = 0;  ///< of the values [bytes]
};

/// Words of a Netpbm file, between white space and comments.
class PnmWords {
 public:
  explicit PnmWords(std::string_view text) : text_(text) {}

  std::string_view next() {
    while (at_ < text_.size() && (isSpace(text_[at_]) || text_[at_] == '#')) {
      if (text_[at_] == '#')
        at_ = std::min(text_.find('\n', at_), text_.size());
      else
        ++at_;
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && !isSpace(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }

  std::size_t at() const { return at_; }

 private:
  static bool isSpace(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

  std::string_view text_;
  std::size_t at_ = 0;
};

Result<PnmHeader> readPnmHeader(std::string_view front, const std::string& name) {
  PnmWords words(front);
  const std::string_view magic = words.next();
  PnmHeader header;
  if (magic != "P2" && magic != "P3" && magic != "P5" && magic != "P6" && magic != "Pf" &&
      magic != "PF") {
    return fail(ErrorCode::kInvalidData,
                "{}: begins with '{}'; expected P2, P3, P5, P6, Pf or PF of Netpbm", name,
                magic.substr(0, 8));
  }
  header.text = magic == "P2" || magic == "P3";
  header.floats = magic == "Pf" || magic == "PF";
  header.channels = magic == "P3" || magic == "P6" || magic == "PF" ? 3 : 1;
  const bool sized =
      readNumber(words.next(), header.width) && readNumber(words.next(), header.height);
  const std::string_view last = words.next();
  if (!sized || header.width < 1 || header.height < 1)
    return fail(ErrorCode::kInvalidData, "{}: its width or height is no whole number above 0",
                name);
  header.begin = words.at() + 1;
  if (header.floats) {
    double scale = 0;
    if (!readNumber(last, scale) || scale == 0 || !std::isfinite(scale))
      return fail(ErrorCode::kInvalidData, "{}: its scale '{}' is not a number other than 0", name,
                  last.substr(0, 20));
    header.bigEndian = scale > 0;
    header.scale = std::abs(scale);
    return header;
  }
  int largest = 0;
  if (!readNumber(last, largest) || largest < 1 || largest > 65535)
    return fail(ErrorCode::kInvalidData, "{}: its largest value '{}' is not from 1 to 65535", name,
                last.substr(0, 20));
  header.largest = largest;
  return header;
}

Status checkWhole(std::uint64_t there, std::uint64_t wanted, const std::string& name) {
  if (there == wanted)
    return {};
  return there < wanted ? fail(ErrorCode::kTruncated, "{}: {} bytes of pixels; expected {}", name,
                               there, wanted)
                        : fail(ErrorCode::kInvalidData,
                               "{}: {} bytes after its picture; expected one picture a file", name,
                               there - wanted);
}

Status readPnmText(std::string_view text, const PnmHeader& header, Image& image,
                   const std::string& name) {
  PnmWords words(text);
  for (float& value : image.pixels) {
    int number = 0;
    if (!readNumber(words.next(), number))
      return fail(ErrorCode::kTruncated, "{}: fewer values than its {} x {} pixels have", name,
                  image.width, image.height);
    value = static_cast<float>(number);
  }
  return words.next().empty()
             ? Status()
             : fail(ErrorCode::kInvalidData, "{}: more values than its {} x {} pixels have", name,
                    header.width, header.height);
}

Result<PnmHeader> openPnmHeader(const std::filesystem::path& path) {
  constexpr std::uint64_t kBytes = 1 << 16;  // with long comments
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  std::string front(std::min(file.size(), kBytes), '\0');
  VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(front))));
  return readPnmHeader(front, path.string());
}

Result<StoredPicture> readPnm(const std::filesystem::path& path, std::uint64_t maxMemory) {
  const std::string name = path.string();
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  if (file.size() > maxMemory)
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "{}: {} bytes, more than the {} MiB of memory allowed", name, file.size(),
                maxMemory >> 20);
  std::vector<std::byte> bytes(file.size());
  VOLUTE_TRY(file.read(0, bytes));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  VOLUTE_ASSIGN(const PnmHeader header, readPnmHeader(text, name));
  VOLUTE_TRY(checkImageSize(path, header.width, header.height, header.channels, maxMemory));
  StoredPicture picture{Image(header.width, header.height, header.channels)};
  picture.linear = header.floats;
  picture.largest = header.floats ? 1 : header.largest;
  Image& image = picture.image;
  const std::size_t begin = std::min(header.begin, bytes.size());
  if (header.text) {
    VOLUTE_TRY(readPnmText(text.substr(begin), header, image, name));
  } else {
    const NumberType type{header.floats          ? NumberKind::kFloat32
                          : header.largest > 255 ? NumberKind::kUint16
                                                 : NumberKind::kUint8,
                          header.bigEndian};
    VOLUTE_TRY(checkWhole(bytes.size() - begin, image.pixels.size() * type.size(), name));
    double rounding = 0;
    (void)toFloats(type, bytes.data() + begin, static_cast<std::ptrdiff_t>(type.size()),
                   image.pixels, rounding);
  }
  if (header.floats) {  // from the lowest row up
    const auto row = static_cast<std::ptrdiff_t>(image.width) * image.channels;
    for (int y = 0; y < image.height / 2; ++y)
      std::swap_ranges(image.pixels.begin() + y * row, image.pixels.begin() + (y + 1) * row,
                       image.pixels.begin() + (image.height - 1 - y) * row);
    return picture;
  }
  for (float& value : image.pixels) {
    if (value < 0 || value > header.largest)
      return fail(ErrorCode::kInvalidData, "{}: a value of {:g}; the largest is to be {:g}", name,
                  value, header.largest);
    value = static_cast<float>(value / header.largest);
  }
  return picture;
}

bool isFloat(NumberKind kind) {
  return kind == NumberKind::kFloat16 || kind == NumberKind::kFloat32 ||
         kind == NumberKind::kFloat64;
}

/// What is 1 of the numbers of an array; 0: that is not known.
double largestOf(NumberKind kind) {
  switch (kind) {
    case NumberKind::kUint8:
      return 255;
    case NumberKind::kUint16:
      return 65535;
    case NumberKind::kUint32:
      return 4294967295.0;
    default:
      return isFloat(kind) || kind == NumberKind::kBool ? 1 : 0;
  }
}

struct PictureArray {
  NumberFile file;
  NpyHeader header;
  int width = 0, height = 0, channels = 1;
  double largest = 1;
};

Result<PictureArray> openPictureArray(const std::filesystem::path& path) {
  const std::string name = path.string();
  VOLUTE_ASSIGN(auto file, InputFile::open(path));
  std::vector<std::byte> front(std::min<std::uint64_t>(file.size(), kLongestNpyHeader));
  VOLUTE_TRY(file.read(0, front));
  VOLUTE_ASSIGN(auto header, readNpyHeader(front, file.size(), name));
  const auto& shape = header.shape;
  constexpr std::uint64_t kLongestSide = 1 << 20;
  if (shape.size() < 2 || shape.size() > 3 ||
      (shape.size() == 3 && shape[2] != 1 && shape[2] != 3) || shape[0] > kLongestSide ||
      shape[1] > kLongestSide) {
    return fail(ErrorCode::kInvalidData,
                "{}: an array of shape ({}); expected a picture: (height, width) or (height, "
                "width, 3)",
                name, fmt::join(shape, ", "));
  }
  const double largest = largestOf(header.type.kind);
  if (largest == 0) {
    return fail(ErrorCode::kUnsupported,
                "{}: a picture of signed or of 64-bit integers, whose white is not known; expected "
                "uint8, uint16, uint32 or floats",
                name);
  }
  return PictureArray{NumberFile(std::move(file)),
                      header,
                      static_cast<int>(shape[1]),
                      static_cast<int>(shape[0]),
                      shape.size() == 3 ? static_cast<int>(shape[2]) : 1,
                      largest};
}

Result<StoredPicture> readPictureArray(const std::filesystem::path& path, std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(PictureArray array, openPictureArray(path));
  VOLUTE_TRY(checkImageSize(path, array.width, array.height, array.channels, maxMemory));
  StoredPicture picture{Image(array.width, array.height, array.channels)};
  Image& image = picture.image;
  VOLUTE_TRY(array.file.read(array.header.type, array.header.dataOffset, image.pixels));
  if (array.header.fortranOrder) {
    Image turned(image.width, image.height, image.channels);
    std::size_t i = 0;
    for (int c = 0; c < image.channels; ++c)
      for (int x = 0; x < image.width; ++x)
        for (int y = 0; y < image.height; ++y) turned.at(x, y, c) = image.pixels[i++];
    image = std::move(turned);
  }
  picture.linear = isFloat(array.header.type.kind);
  picture.largest = array.largest;
  if (array.largest != 1) {
    for (float& value : image.pixels) value = static_cast<float>(value / array.largest);
  }
  return picture;
}

/// What of a .pfm's head is not applied; what is wrong with it is told when it is read.
std::vector<Remark> remarksOfPfm(const std::filesystem::path& path) {
  constexpr std::uint64_t kFront = 4096;
  const auto file = InputFile::open(path);
  std::string front(file ? std::min(file->size(), kFront) : 0, '\0');
  if (!file || !file->read(0, std::as_writable_bytes(std::span(front))))
    return {};
  const auto header = readPnmHeader(front, path.string());
  if (!header || header->scale == 1)
    return {};
  return {
      {RemarkCode::kLeftOut, fmt::format("pictures state a scale of {:g} (.pfm), by which their "
                                         "values are not multiplied",
                                         header->scale)}};
}

/// Where a .exr has pixels; empty: everywhere.
Result<std::vector<std::uint8_t>> pixelsThere(const std::filesystem::path& path,
                                              const Image& image) {
  VOLUTE_ASSIGN(const FrameInfo info, readFrameInfo(path));
  const PixelWindow &data = info.parts[0].data, &display = info.parts[0].display;
  const auto covers = [&](int x, int y) {
    return data.contains(display.left + x, display.top + y);
  };
  if (covers(0, 0) && covers(image.width - 1, image.height - 1))
    return std::vector<std::uint8_t>();
  std::vector<std::uint8_t> there;
  there.reserve(std::size_t(image.width) * image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) there.push_back(covers(x, y) ? 1 : 0);
  return there;
}

/// What of a .exr's head is not taken as it stands.
Result<std::vector<Remark>> remarksOfExr(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const FrameInfo info, readFrameInfo(path));
  std::vector<Remark> remarks;
  if (info.parts.size() != 1)
    return remarks;  // which is an error when it is read
  const FramePart& part = info.parts[0];
  const auto toSrgb = srgbFromPrimaries(part);
  if (toSrgb && *toSrgb)
    remarks.emplace_back(RemarkCode::kChanged,
                         "pictures state other primaries than sRGB's (.exr chromaticities): their "
                         "channels are mixed to those of sRGB, and are no longer the camera's own");
  if (part.pixelAspect != 1)
    remarks.emplace_back(RemarkCode::kAssumed,
                         fmt::format("pictures state pixels {:.4g} times as wide as high (.exr): "
                                     "they are taken as stored, and the calibration to be of such "
                                     "pictures",
                                     part.pixelAspect));
  const PixelWindow &data = part.data, &display = part.display;
  const double width = std::min(data.right, display.right) - std::max(data.left, display.left),
               height = std::min(data.bottom, display.bottom) - std::max(data.top, display.top);
  const double all = static_cast<double>(display.width()) * display.height();
  const double held = std::max(width, 0.0) * std::max(height, 0.0);
  if (held < all)
    remarks.emplace_back(
        RemarkCode::kLeftOut,
        fmt::format("pictures hold nothing for {:.0f} % of their pixels (.exr data "
                    "window); these do not count",
                    100 * (1 - held / all)));
  return remarks;
}

bool isTiff(const std::string& extension) {
  return extension == ".tif" || extension == ".tiff";
}

bool isPnm(const std::string& extension) {
  return extension == ".pgm" || extension == ".ppm" || extension == ".pnm" || extension == ".pfm";
}

tl::unexpected<Error> noPage(const std::filesystem::path& path, int page) {
  return fail(ErrorCode::kNotFound, "{}: holds one picture, none of number {}", path.string(),
              page);
}

}  // namespace

Result<StoredPicture> readStoredPicture(const std::filesystem::path& path, std::uint64_t maxMemory,
                                        int page) {
  const std::string extension = extensionOf(path);
  if (isTiff(extension)) {
    VOLUTE_ASSIGN(auto file, TiffFile::open(path, maxMemory));
    return file.read(page, maxMemory);
  }
  if (page != 0)
    return noPage(path, page);
  if (isPnm(extension))
    return readPnm(path, maxMemory);
  if (extension == ".npy")
    return readPictureArray(path, maxMemory);
  if (extension != ".png" && extension != ".exr") {
    return fail(ErrorCode::kUnsupported,
                "{}: not a known kind of picture; expected .png, .exr, .tif, .pgm, .ppm, .pfm or "
                ".npy",
                path.string());
  }
  const ImageReadOptions options{.raw = true, .maxMemory = maxMemory};
  StoredPicture picture;
  VOLUTE_ASSIGN(picture.image, readImage(path, options));
  VOLUTE_ASSIGN(picture.alpha, readAlpha(path, options));
  picture.linear = extension == ".exr";
  if (picture.linear) {
    VOLUTE_ASSIGN(picture.there, pixelsThere(path, picture.image));
  } else {
    VOLUTE_ASSIGN(picture.curve, readStoredCurve(path));
    VOLUTE_ASSIGN(const PngKind kind, readPngKind(path));
    picture.largest = std::ldexp(1.0, kind.bits) - 1;
  }
  return picture;
}

Result<PictureKind> pictureKind(const std::filesystem::path& path, std::uint64_t maxMemory,
                                int page) {
  const std::string extension = extensionOf(path);
  if (isTiff(extension)) {
    VOLUTE_ASSIGN(auto file, TiffFile::open(path, maxMemory));
    return file.kind(page);
  }
  if (extension == ".npy") {
    VOLUTE_ASSIGN(const PictureArray array, openPictureArray(path));
    return PictureKind{isFloat(array.header.type.kind), 1, array.channels, array.largest};
  }
  if (extension == ".png") {
    VOLUTE_ASSIGN(const PngKind png, readPngKind(path));
    PictureKind kind{false, 1, png.channels, std::ldexp(1.0, png.bits) - 1};
    if (auto curve = readStoredCurve(path)) {  // else it is told when the picture is read
      kind.stated = png.color;
      kind.curve = std::move(*curve);
    }
    if (png.pictures > 1)
      kind.remarks.emplace_back(
          RemarkCode::kLeftOut,
          fmt::format("a .png is an animation of {} pictures, of which the first counts",
                      png.pictures));
    return kind;
  }
  if (isPnm(extension)) {
    const auto header = openPnmHeader(path);
    PictureKind kind = header ? PictureKind{header->floats, 1, header->channels, header->largest}
                              : PictureKind{extension == ".pfm"};
    if (extension == ".pfm")
      kind.remarks = remarksOfPfm(path);
    return kind;
  }
  PictureKind kind{extension == ".exr"};
  if (!kind.linear)
    return kind;
  VOLUTE_ASSIGN(kind.remarks, remarksOfExr(path));
  if (const auto info = readFrameInfo(path)) {
    const auto has = [&](std::string_view name) {
      return std::ranges::find(info->channels, name, &FrameChannel::own) != info->channels.end();
    };
    kind.channels = has("R") && has("G") && has("B") ? 3 : 1;
  }
  return kind;
}

}  // namespace volute
