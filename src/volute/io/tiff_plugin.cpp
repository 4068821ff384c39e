// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "volute/base/half.hpp"
#include "volute/io/still.hpp"

namespace volute {
namespace {

std::string libtiffSaid;

void keepMessage(const char*, const char* format, va_list arguments) {
  std::array<char, 512> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  if (libtiffSaid.empty())
    libtiffSaid = text.data();
}

using TiffPtr = std::unique_ptr<TIFF, decltype([](TIFF* file) { TIFFClose(file); })>;

tl::unexpected<Error> damaged(const std::string& name) {
  return fail(ErrorCode::kInvalidData, "{}: not a whole TIFF picture: {}", name,
              libtiffSaid.empty() ? "it is damaged" : libtiffSaid);
}

template <class T>
T tagOf(TIFF* file, std::uint32_t tag, T otherwise) {
  T value = otherwise;
  return TIFFGetFieldDefaulted(file, tag, &value) == 1 ? value : otherwise;
}

bool isWhole(TIFF* file) {
  return (tagOf<std::uint32_t>(file, TIFFTAG_SUBFILETYPE, 0) &
          (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) == 0;
}

/// How the pixels of a directory lie in the file.
struct Layout {
  StillInfo info;
  std::string name;
  int samples = 1;   // of a pixel, with those that are not wanted
  int colors = 1;    // of them, that come first
  int alphaAt = -1;  // among them
  bool planes = false, inverted = false, palette = false;
  int orientation = ORIENTATION_TOPLEFT;
};

Status checkColors(TIFF* file, Layout& layout) {
  const auto photometric = tagOf<std::uint16_t>(file, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  const auto compression = tagOf<std::uint16_t>(file, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  layout.colors = 1;
  switch (photometric) {
    case PHOTOMETRIC_MINISWHITE:
      layout.inverted = true;
      break;
    case PHOTOMETRIC_MINISBLACK:
    case PHOTOMETRIC_CFA:  // a mosaic is told as one
      break;
    case PHOTOMETRIC_PALETTE:
      layout.palette = true;
      break;
    case PHOTOMETRIC_RGB:
      layout.colors = 3;
      break;
    case PHOTOMETRIC_YCBCR:
      if (compression == COMPRESSION_JPEG) {
        TIFFSetField(file, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
        layout.colors = 3;
        break;
      }
      [[fallthrough]];
    default:
      return fail(ErrorCode::kUnsupported,
                  "{}: its pixels are of photometric interpretation {}; expected grey, RGB or a "
                  "palette",
                  layout.name, photometric);
  }
  if (layout.samples < layout.colors)
    return fail(ErrorCode::kInvalidData, "{}: pixels of {} values; expected {}", layout.name,
                layout.samples, layout.colors);
  std::uint16_t count = 0;
  const std::uint16_t* kinds = nullptr;
  TIFFGetFieldDefaulted(file, TIFFTAG_EXTRASAMPLES, &count, &kinds);
  for (int i = 0; kinds && i < count && layout.colors + i < layout.samples; ++i) {
    if (kinds[i] != EXTRASAMPLE_UNSPECIFIED && layout.alphaAt < 0)
      layout.alphaAt = layout.colors + i;
  }
  return {};
}

Status checkNumbers(TIFF* file, Layout& layout) {
  const int bits = tagOf<std::uint16_t>(file, TIFFTAG_BITSPERSAMPLE, 1);
  const auto format = tagOf<std::uint16_t>(file, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  if (format == SAMPLEFORMAT_IEEEFP && (bits == 16 || bits == 32 || bits == 64)) {
    if (layout.palette || layout.inverted)
      return fail(ErrorCode::kUnsupported, "{}: floats that are not light; expected grey or RGB",
                  layout.name);
    layout.info.bits = 0;
    return {};
  }
  const bool whole = (bits >= 1 && bits <= 16) || bits == 32;
  if ((format != SAMPLEFORMAT_UINT && format != SAMPLEFORMAT_VOID) || !whole ||
      (layout.palette && bits > 8)) {
    constexpr std::array kFormats = {"numbers of no kind", "unsigned integers", "signed integers",
                                     "floats"};
    return fail(ErrorCode::kUnsupported,
                "{}: its values are {} of {} bits; expected unsigned integers of at most 16 or of "
                "32 bits, or floats",
                layout.name, format < kFormats.size() ? kFormats[format] : "numbers of no kind",
                bits);
  }
  layout.info.bits = layout.palette ? 16 : bits;
  return {};
}

Result<Layout> layoutOf(TIFF* file, std::string name) {
  Layout layout;
  layout.name = std::move(name);
  const auto width = tagOf<std::uint32_t>(file, TIFFTAG_IMAGEWIDTH, 0),
             height = tagOf<std::uint32_t>(file, TIFFTAG_IMAGELENGTH, 0);
  constexpr std::uint32_t kLongestSide = 1 << 20;
  if (width < 1 || height < 1 || width > kLongestSide || height > kLongestSide)
    return fail(ErrorCode::kTooLarge, "{}: a picture of {} x {} pixels; expected sides of 1 to {}",
                layout.name, width, height, kLongestSide);
  layout.info.width = static_cast<std::int32_t>(width);
  layout.info.height = static_cast<std::int32_t>(height);
  layout.samples = tagOf<std::uint16_t>(file, TIFFTAG_SAMPLESPERPIXEL, 1);
  layout.planes = tagOf<std::uint16_t>(file, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) ==
                  PLANARCONFIG_SEPARATE;
  layout.orientation = tagOf<std::uint16_t>(file, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  if (layout.orientation > ORIENTATION_BOTLEFT)
    return fail(ErrorCode::kUnsupported,
                "{}: is stored on its side (orientation {}); expected rows from left to right: "
                "turn its pixels",
                layout.name, layout.orientation);
  VOLUTE_TRY(checkColors(file, layout));
  VOLUTE_TRY(checkNumbers(file, layout));
  layout.info.alpha = layout.alphaAt >= 0;
  layout.info.channels = (layout.palette ? 3 : layout.colors) + (layout.info.alpha ? 1 : 0);
  return layout;
}

/// The directory of the picture `page`, counted among those of full size.
Result<TiffPtr> openPage(const std::filesystem::path& path, int page, int* pages) {
  TIFFSetErrorHandler(keepMessage);
  TIFFSetWarningHandler(nullptr);
  libtiffSaid.clear();
  TiffPtr file(TIFFOpen(path.c_str(), "rm"));
  if (!file)
    return damaged(path.string());
  constexpr int kMaxPages = 1 << 20;
  int found = 0, directory = -1;
  do {
    if (isWhole(file.get())) {
      if (found == page)
        directory = static_cast<int>(TIFFCurrentDirectory(file.get()));
      ++found;
      if (directory >= 0 && !pages)
        break;
    }
  } while (found < kMaxPages && TIFFReadDirectory(file.get()) == 1);
  if (pages)
    *pages = found;
  if (directory < 0)
    return fail(ErrorCode::kNotFound, "{}: has {} pictures, none of number {}", path.string(),
                found, page);
  libtiffSaid.clear();
  if (TIFFCurrentDirectory(file.get()) != static_cast<tdir_t>(directory) &&
      TIFFSetDirectory(file.get(), static_cast<tdir_t>(directory)) != 1)
    return damaged(path.string());
  return file;
}

/// Value `i` of a row of unsigned integers or floats as libtiff unpacks them: in the byte order of
/// the machine, those of odd sizes bit by bit.
double valueAt(const unsigned char* row, std::size_t i, int bits, bool isFloat) {
  const auto as = [&]<class T>(T value) {
    std::memcpy(&value, row + i * sizeof value, sizeof value);
    return value;
  };
  if (isFloat)
    return bits == 16   ? toFloat(Half{as(std::uint16_t{})})
           : bits == 32 ? as(float{})
                        : as(double{});
  if (bits == 8)
    return row[i];
  if (bits == 16)
    return as(std::uint16_t{});
  if (bits == 32)
    return as(std::uint32_t{});
  std::uint32_t value = 0;
  const std::size_t first = i * static_cast<std::size_t>(bits);
  for (std::size_t bit = first; bit < first + static_cast<std::size_t>(bits); ++bit)
    value = value << 1U | ((row[bit / 8] >> (7 - bit % 8)) & 1U);
  return value;
}

/// What is 1 of integers of so many bits; 0 bits: floats.
double largest(int bits) {
  return bits == 0 ? 1 : std::ldexp(1.0, bits) - 1;
}

/// Decodes one picture, a strip or tile at a time.
class PageReader {
 public:
  PageReader(TIFF* file, const Layout& layout, std::span<float> to)
      : file_(file), layout_(layout), to_(to) {
    bits_ = tagOf<std::uint16_t>(file, TIFFTAG_BITSPERSAMPLE, 1);
    most_ = largest(layout.info.bits);
    if (layout.palette)
      TIFFGetField(file, TIFFTAG_COLORMAP, &palette_[0], &palette_[1], &palette_[2]);
  }

  Status read() {
    if (layout_.palette && !palette_[2])
      return fail(ErrorCode::kInvalidData, "{}: its palette is missing", layout_.name);
    for (int plane = 0; plane < (layout_.planes ? layout_.samples : 1); ++plane)
      VOLUTE_TRY(TIFFIsTiled(file_) ? readTiles(plane) : readStrips(plane));
    orient();
    return {};
  }

 private:
  /// Rows of `columns` pixels from (x, y) on, of one plane.
  void take(const std::vector<unsigned char>& bytes, std::size_t rowBytes, int x, int y,
            int columns, int rows, int plane) {
    const int each = layout_.planes ? 1 : layout_.samples;
    for (int r = 0; r < rows && y + r < layout_.info.height; ++r) {
      const unsigned char* row = bytes.data() + static_cast<std::size_t>(r) * rowBytes;
      for (int i = 0; i < columns && x + i < layout_.info.width; ++i) {
        float* pixel = &to_[(static_cast<std::size_t>(y + r) * layout_.info.width + x + i) *
                            layout_.info.channels];
        for (int s = 0; s < each; ++s)
          place(
              pixel, plane + s,
              valueAt(row, static_cast<std::size_t>(i) * each + s, bits_, layout_.info.bits == 0));
      }
    }
  }

  void place(float* pixel, int sample, double value) const {
    if (sample == layout_.alphaAt) {
      pixel[layout_.info.channels - 1] =
          static_cast<float>(value / largest(layout_.info.bits == 0 ? 0 : bits_));
    } else if (sample >= layout_.colors) {
      return;
    } else if (layout_.palette) {
      for (std::size_t c = 0; c < 3; ++c)
        pixel[c] = static_cast<float>(palette_[c][static_cast<std::size_t>(value)] / most_);
    } else {
      pixel[sample] = static_cast<float>((layout_.inverted ? most_ - value : value) / most_);
    }
  }

  Status readStrips(int plane) {
    const auto rowBytes = static_cast<std::size_t>(TIFFScanlineSize64(file_));
    const auto strip = static_cast<std::size_t>(TIFFStripSize64(file_));
    const auto height = static_cast<std::uint32_t>(layout_.info.height);
    const auto rows = std::min(tagOf<std::uint32_t>(file_, TIFFTAG_ROWSPERSTRIP, height), height);
    if (rowBytes < expectedRow(layout_.info.width) || rows < 1)
      return damaged(layout_.name);
    std::vector<unsigned char> bytes(std::max(strip, rowBytes * rows));
    for (std::uint32_t y = 0; y < height; y += rows) {
      const std::uint32_t wanted = std::min(rows, height - y);
      const auto got =
          TIFFReadEncodedStrip(file_, TIFFComputeStrip(file_, y, static_cast<std::uint16_t>(plane)),
                               bytes.data(), static_cast<tmsize_t>(strip));
      if (got < static_cast<tmsize_t>(rowBytes * wanted))
        return damaged(layout_.name);
      take(bytes, rowBytes, 0, static_cast<int>(y), layout_.info.width, static_cast<int>(wanted),
           plane);
    }
    return {};
  }

  Status readTiles(int plane) {
    const auto wide = tagOf<std::uint32_t>(file_, TIFFTAG_TILEWIDTH, 0),
               high = tagOf<std::uint32_t>(file_, TIFFTAG_TILELENGTH, 0);
    const auto rowBytes = static_cast<std::size_t>(TIFFTileRowSize64(file_));
    const auto size = static_cast<std::size_t>(TIFFTileSize64(file_));
    constexpr std::uint32_t kLongest = 1 << 16;
    if (wide < 1 || high < 1 || wide > kLongest || high > kLongest ||
        rowBytes < expectedRow(static_cast<int>(wide)) || size < rowBytes * high)
      return damaged(layout_.name);
    std::vector<unsigned char> bytes(size);
    for (int y = 0; y < layout_.info.height; y += static_cast<int>(high)) {
      for (int x = 0; x < layout_.info.width; x += static_cast<int>(wide)) {
        const auto tile =
            TIFFComputeTile(file_, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), 0,
                            static_cast<std::uint16_t>(plane));
        if (TIFFReadEncodedTile(file_, tile, bytes.data(), static_cast<tmsize_t>(size)) <
            static_cast<tmsize_t>(size))
          return damaged(layout_.name);
        take(bytes, rowBytes, x, y, static_cast<int>(wide), static_cast<int>(high), plane);
      }
    }
    return {};
  }

  std::size_t expectedRow(int columns) const {
    const int each = layout_.planes ? 1 : layout_.samples;
    return (static_cast<std::size_t>(columns) * each * bits_ + 7) / 8;
  }

  /// Rows and columns that are stored the other way round.
  void orient() {
    const auto channels = static_cast<std::size_t>(layout_.info.channels);
    const auto row = static_cast<std::size_t>(layout_.info.width) * channels;
    const int o = layout_.orientation;
    if (o == ORIENTATION_BOTRIGHT || o == ORIENTATION_BOTLEFT) {
      for (std::size_t a = 0, b = to_.size() - row; a < b; a += row, b -= row)
        std::swap_ranges(&to_[a], &to_[a] + row, &to_[b]);
    }
    if (o == ORIENTATION_TOPRIGHT || o == ORIENTATION_BOTRIGHT) {
      for (std::size_t first = 0; first < to_.size(); first += row) {
        for (std::size_t a = first, b = first + row - channels; a < b; a += channels, b -= channels)
          std::swap_ranges(&to_[a], &to_[a] + channels, &to_[b]);
      }
    }
  }

  TIFF* file_;
  const Layout& layout_;
  std::span<float> to_;
  int bits_ = 1;
  double most_ = 1;
  std::array<const std::uint16_t*, 3> palette_{};
};

Result<StillInfo> describe(const std::filesystem::path& path, int page) {
  int pages = 0;
  VOLUTE_ASSIGN(const TiffPtr file, openPage(path, page, &pages));
  VOLUTE_ASSIGN(Layout layout, layoutOf(file.get(), path.string()));
  layout.info.pages = pages;
  return layout.info;
}

Status readPage(const std::filesystem::path& path, int page, std::span<float> values) {
  VOLUTE_ASSIGN(const TiffPtr file, openPage(path, page, nullptr));
  VOLUTE_ASSIGN(const Layout layout, layoutOf(file.get(), path.string()));
  const StillInfo& info = layout.info;
  if (values.size() != static_cast<std::size_t>(info.width) * info.height * info.channels)
    return fail(ErrorCode::kInvalidData, "{}: has changed while it was read", path.string());
  return PageReader(file.get(), layout, values).read();
}

Result<std::string> profileOf(const std::filesystem::path& path, int page) {
  VOLUTE_ASSIGN(const TiffPtr file, openPage(path, page, nullptr));
  std::uint32_t size = 0;
  const char* bytes = nullptr;
  if (TIFFGetField(file.get(), TIFFTAG_ICCPROFILE, &size, &bytes) != 1 || !bytes)
    return std::string();
  constexpr std::uint32_t kLargest =
      100000;  // of those with curves and primaries; one crosses as a message
  if (size > kLargest)
    return fail(ErrorCode::kUnsupported,
                "{}: a color profile of {} bytes; expected curves and primaries", path.string(),
                size);
  return std::string(bytes, size);
}

}  // namespace
}  // namespace volute

extern "C" const volute::StillPlugin* voluteTiffPlugin() {
  static constexpr volute::StillPlugin kPlugin{volute::describe, volute::readPage,
                                               volute::profileOf};
  return &kPlugin;
}
