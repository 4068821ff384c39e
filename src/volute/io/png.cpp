// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/base/output_file.hpp"
#include "volute/base/parallel.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/frame_file.hpp"
#include "volute/io/image_formats.hpp"
#include "volute/io/stored_color.hpp"

namespace volute {
namespace {

/// libpng leaves by longjmp, which runs no destructors: what its callbacks touch lives here,
/// outside.
struct PngState {
  const InputFile* input = nullptr;
  std::uint64_t at = 0;
  std::vector<std::byte> written;
  std::string message;
  png_uint_32 width = 0, height = 0;
  int channels = 0, bits = 0;
  bool linear = false;  // what is written is, not sRGB
  bool headerOnly = false;
  bool keepAlpha = false;  // as the last channel, if there is one
  bool hasAlpha = false;
  int orientation = 1;  // as EXIF counts
  int pictures = 1;     // of an animation (acTL)
  double pixelAspect = 1;
  // Of pictures whose pixels are indices: RGBA of each; libpng takes what is beyond it for black.
  std::vector<std::array<png_byte, 4>> palette;
  // What it states of its colors.
  bool srgb = false;
  double gamma = 0;  // of gAMA; 0: not there
  std::optional<std::array<double, 8>> primaries;
  std::vector<std::byte> profile;
  std::optional<std::array<int, 2>> codePoints;  // primaries and curve of cICP
  std::vector<png_byte> pixels;
  std::vector<png_bytep> rows;
};

[[noreturn]] void onError(png_structp png, png_const_charp message) {
  static_cast<PngState*>(png_get_error_ptr(png))->message = message;
  png_longjmp(png, 1);
}

/// What is there twice, and says two things.
void onWarning(png_structp png, png_const_charp message) {
  if (std::string_view(message).find("duplicate") != std::string_view::npos)
    onError(png, message);
}

void onRead(png_structp png, png_bytep to, size_t count) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  const bool read =
      state->input->read(state->at, std::as_writable_bytes(std::span(to, count))).has_value();
  if (!read)
    png_error(png, "the file ends before the picture does");
  state->at += count;
}

void onWrite(png_structp png, png_bytep from, size_t count) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  const auto bytes = std::as_bytes(std::span(from, count));
  state->written.insert(state->written.end(), bytes.begin(), bytes.end());
}

/// Runs below libpng's error handling.
void readColor(png_structp png, png_infop info, PngState& state) {
  png_unknown_chunkp chunks = nullptr;
  for (int i = 0, n = png_get_unknown_chunks(png, info, &chunks); i < n; ++i) {
    if (std::memcmp(chunks[i].name, "cICP", 4) == 0 && chunks[i].size == 4)
      state.codePoints = {chunks[i].data[0], chunks[i].data[1]};
    if (std::memcmp(chunks[i].name, "acTL", 4) == 0 && chunks[i].size == 8)
      state.pictures = chunks[i].data[0] != 0 || chunks[i].data[1] != 0
                           ? 65536
                           : 256 * chunks[i].data[2] + chunks[i].data[3];
  }
  png_charp name = nullptr;
  png_bytep profile = nullptr;
  png_uint_32 length = 0;
  int packing = 0, intent = 0;
  if (png_get_iCCP(png, info, &name, &packing, &profile, &length) != 0) {
    const auto bytes = std::as_bytes(std::span(profile, length));
    state.profile.assign(bytes.begin(), bytes.end());
  }
  state.srgb = png_get_sRGB(png, info, &intent) != 0;
  png_get_gAMA(png, info, &state.gamma);
  std::array<double, 8> p{};
  if (png_get_cHRM(png, info, &p[0], &p[1], &p[2], &p[3], &p[4], &p[5], &p[6], &p[7]) != 0)
    state.primaries = p;
}

/// The first of cICP, iCCP, sRGB, and gAMA with cHRM that is there counts (PNG, third
/// edition, 4.3). Nothing where none is.
Result<std::optional<StoredColor>> colorOf(const PngState& state, const std::string& name) {
  const auto settled = [&]() -> Result<std::optional<StoredColor>> {
    if (state.codePoints) {
      VOLUTE_ASSIGN(auto color, colorOfCodePoints((*state.codePoints)[0], (*state.codePoints)[1]));
      return color;
    }
    if (state.srgb)  // or libpng knows the profile as sRGB's
      return StoredColor();
    if (!state.profile.empty()) {
      VOLUTE_ASSIGN(auto color, colorOfProfile(state.profile, state.channels < 3));
      return color;
    }
    if (state.gamma <= 0 && !state.primaries)
      return std::nullopt;
    StoredColor color = state.gamma > 0 ? colorOfGamma(state.gamma) : StoredColor();
    if (state.primaries && state.channels >= 3) {
      VOLUTE_ASSIGN(color.toSrgb, srgbFromPrimaries(*state.primaries));
    }
    return color;
  };
  auto color = settled();
  if (!color) {
    return fail(color.error().code, color.error().hints,
                "{}: {}; expected a picture in sRGB, or one that states gAMA; "
                "convert it to sRGB",
                name, color.error().message);
  }
  return color;
}

/// The orientation of an eXIf chunk (TIFF's tag 274): 1 is upright, as where none is stated.
int orientationOf(std::span<const png_byte> exif) {
  constexpr std::size_t kHead = 8, kEntry = 12;
  constexpr std::uint32_t kOrientation = 274;
  if (exif.size() < kHead || (exif[0] != 'M' && exif[0] != 'I'))
    return 1;
  const auto number = [&](std::size_t at, std::size_t bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes && at + bytes <= exif.size(); ++i)
      value = value << 8 | exif[exif[0] == 'M' ? at + i : at + bytes - 1 - i];
    return value;
  };
  const std::size_t list = number(4, 4);
  for (std::size_t i = 0, at = list + 2; i < number(list, 2) && at < exif.size();
       ++i, at += kEntry) {
    if (number(at, 2) == kOrientation)
      return static_cast<int>(number(at + 8, 2));
  }
  return 1;
}

/// Runs below libpng's error handling.
void readPalette(png_structp png, png_infop info, PngState& state) {
  png_colorp colors = nullptr;
  png_bytep alphas = nullptr;
  int count = 0, transparent = 0;
  png_get_PLTE(png, info, &colors, &count);
  png_get_tRNS(png, info, &alphas, &transparent, nullptr);
  for (int i = 0; i < count; ++i) {
    const png_byte alpha = i < transparent ? alphas[i] : 255;
    state.palette.push_back({colors[i].red, colors[i].green, colors[i].blue, alpha});
  }
}

/// Rows that hold an index for each pixel get its colour. False: there is none.
bool applyPalette(PngState& state) {
  for (std::size_t y = 0; y < state.rows.size(); ++y) {
    for (std::size_t x = state.width; x-- > 0;) {
      const std::size_t index = state.rows[y][x];
      if (index >= state.palette.size()) {
        state.message = fmt::format("pixel {}, {} has colour {} of a palette of {}", x, y, index,
                                    state.palette.size());
        return false;
      }
      std::copy_n(state.palette[index].begin(), state.channels,
                  state.rows[y] + x * static_cast<std::size_t>(state.channels));
    }
  }
  return true;
}

/// Reads up to the first pixel and settles on 1 or 3 channels of 8 or 16 bits. False on an error.
bool readPngHeader(png_structp png, png_infop info, PngState& state) {
  if (setjmp(png_jmpbuf(png)))
    return false;
  png_set_user_limits(png, 1 << 20, 1 << 20);
  png_set_chunk_malloc_max(png, 8 << 20);
  png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
  png_set_read_fn(png, &state, onRead);
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_ALWAYS,
                              reinterpret_cast<png_const_bytep>("cICP\0acTL"), 2);
  png_read_info(png, info);
  readColor(png, info, state);
  png_bytep exif = nullptr;
  png_uint_32 exifLength = 0;
  if (png_get_eXIf_1(png, info, &exifLength, &exif) != 0)
    state.orientation = orientationOf({exif, exifLength});
  const int type = png_get_color_type(png, info);
  if (type == PNG_COLOR_TYPE_PALETTE) {
    png_set_packing(png);  // a byte for each index
    readPalette(png, info, state);
  }
  if (type == PNG_COLOR_TYPE_GRAY)
    png_set_expand_gray_1_2_4_to_8(png);
  state.hasAlpha = (type & PNG_COLOR_MASK_ALPHA) || png_get_valid(png, info, PNG_INFO_tRNS);
  if (type == PNG_COLOR_TYPE_PALETTE) {
    // applyPalette() does the rest
  } else if (state.keepAlpha && state.hasAlpha) {
    png_set_tRNS_to_alpha(png);
  } else {
    png_set_strip_alpha(png);
  }
  png_set_swap(png);  // 16 bits in our byte order
  state.width = png_get_image_width(png, info);
  state.height = png_get_image_height(png, info);
  state.channels =
      ((type & PNG_COLOR_MASK_COLOR) ? 3 : 1) + (state.keepAlpha && state.hasAlpha ? 1 : 0);
  state.bits = png_get_bit_depth(png, info) == 16 ? 16 : 8;
  constexpr double kSquare = 0.01;
  const double aspect = png_get_pixel_aspect_ratio(png, info);  // 0: not stated
  if (aspect > 0 && std::abs(aspect - 1) >= kSquare)
    state.pixelAspect = aspect;
  return true;
}

bool readPngPixels(png_structp png, png_infop info, PngState& state) {
  if (setjmp(png_jmpbuf(png)))
    return false;
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  const std::size_t row =
      state.palette.empty() ? state.pixels.size() / state.height : std::size_t{state.width};
  if (png_get_rowbytes(png, info) != row) {
    png_error(png, "rows of an unexpected length");
  }
  png_read_image(png, state.rows.data());
  png_read_end(png, info);
  return state.palette.empty() || applyPalette(state);
}

/// @param color  null: stored values as they are
Image toImage(const PngState& state, const StoredColor* color) {
  Image image(static_cast<int>(state.width), static_cast<int>(state.height), state.channels);
  const int levels = 1 << state.bits;
  std::array<std::vector<float>, 3> tables;
  for (std::size_t c = 0; c < (color && !color->sameCurves ? 3 : 1); ++c) {
    tables[c].resize(static_cast<std::size_t>(levels));
    for (int i = 0; i < levels; ++i) {
      const double value = static_cast<double>(i) / (levels - 1);
      const auto stored = static_cast<float>(value);
      tables[c][i] = !color             ? stored
                     : color->curves[c] ? static_cast<float>(color->curves[c](value))
                                        : static_cast<float>(srgbDecode(stored));
    }
  }
  const auto channels = static_cast<std::size_t>(state.channels);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    std::uint16_t value = 0;
    if (state.bits == 16) {
      std::memcpy(&value, &state.pixels[2 * i], 2);
    } else {
      value = state.pixels[i];
    }
    const auto& table = tables[i % channels % 3];
    image.pixels[i] = (table.empty() ? tables[0] : table)[value];
  }
  if (!color || !color->toSrgb || channels != 3)
    return image;
  const MatN<float, 3, 3> toSrgb = color->toSrgb->cast<float>();
  for (std::size_t i = 0; i < image.pixels.size(); i += 3) {
    // Colors beyond sRGB's have negative shares.
    const VecN<float, 3> pixel = (toSrgb * VecN<float, 3>(&image.pixels[i])).cwiseMax(0.0f);
    std::ranges::copy(pixel, &image.pixels[i]);
  }
  return image;
}

/// Whether many rows are the row above again, those of one colour aside, as in drawings and never
/// in photographs.
bool isFlat(const PngState& state) {
  if (state.rows.size() < 2)
    return false;
  const auto row = static_cast<std::size_t>(state.rows[1] - state.rows[0]);
  const std::size_t pixel = row / state.width;
  std::size_t repeated = 0, told = 0;
  for (std::size_t y = 1; y < state.rows.size(); ++y) {
    if (std::memcmp(state.rows[y], state.rows[y] + pixel, row - pixel) == 0)
      continue;
    ++told;
    repeated += std::memcmp(state.rows[y], state.rows[y - 1], row) == 0 ? 1 : 0;
  }
  return 4 * repeated > told;
}

bool encodePng(png_structp png, png_infop info, std::vector<png_text>& texts, PngState& state) {
  if (setjmp(png_jmpbuf(png)))
    return false;
  png_set_write_fn(png, &state, onWrite, nullptr);
  png_set_IHDR(png, info, state.width, state.height, state.bits,
               state.channels == 4   ? PNG_COLOR_TYPE_RGB_ALPHA
               : state.channels == 3 ? PNG_COLOR_TYPE_RGB
               : state.channels == 2 ? PNG_COLOR_TYPE_GRAY_ALPHA
                                     : PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (!state.linear)
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  else
    png_set_gAMA(png, info, 1.0);
  if (!texts.empty())
    png_set_text(png, info, texts.data(), static_cast<int>(texts.size()));
  // Of 51 pictures the usual filters and level took twice as long, for 4 % fewer bytes, and level 5
  // takes twice as long as 4 for 5 % fewer. In drawings each choice of a filter for its row costs
  // bytes.
  const bool flat = isFlat(state);
  png_set_filter(png, PNG_FILTER_TYPE_BASE,
                 flat ? PNG_FILTER_NONE : PNG_FILTER_SUB | PNG_FILTER_UP);
  png_set_compression_level(png, flat ? 3 : 4);
  png_write_info(png, info);
  png_set_swap(png);  // 16 bits in our byte order
  png_write_image(png, state.rows.data());
  png_write_end(png, info);
  return true;
}

void layOutRows(PngState& state, std::size_t rowBytes) {
  state.pixels.resize(rowBytes * state.height);
  for (png_uint_32 y = 0; y < state.height; ++y) state.rows.push_back(&state.pixels[y * rowBytes]);
}

/// Fills `state` with the whole picture.
Status readPngFile(const std::filesystem::path& path, const ImageReadOptions& options,
                   PngState& state) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  state.input = &file;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &state, onError, onWarning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (!info)
    state.message = "out of memory";
  const auto readAll = [&]() -> Status {
    if (!info || !readPngHeader(png, info, state))
      return fail(ErrorCode::kInvalidData, "");
    if (state.orientation > 1) {
      return fail(
          ErrorCode::kUnsupported,
          "{}: its EXIF says that the picture is shown turned or mirrored (orientation {}); "
          "expected upright pixels: turn them, and remove the mark",
          path.string(), state.orientation);
    }
    if (state.headerOnly || (state.keepAlpha && !state.hasAlpha))
      return {};  // nothing more to read
    VOLUTE_TRY(checkImageSize(path, state.width, state.height, state.channels, options.maxMemory));
    layOutRows(state, std::size_t{state.width} * state.channels * (state.bits / 8));
    if (!readPngPixels(png, info, state))
      return fail(ErrorCode::kInvalidData, "");
    return {};
  };
  const Status status = readAll();
  png_destroy_read_struct(&png, &info, nullptr);
  if (!status && !status.error().message.empty())
    return tl::unexpected<Error>(status.error());
  if (!status)
    return fail(ErrorCode::kInvalidData, "{}: not a whole PNG picture: {}", path.string(),
                state.message);
  return {};
}

}  // namespace

Result<Image> readPng(const std::filesystem::path& path, const ImageReadOptions& options) {
  PngState state;
  VOLUTE_TRY(readPngFile(path, options, state));
  if (options.raw)
    return toImage(state, nullptr);
  VOLUTE_ASSIGN(const auto stated, colorOf(state, path.string()));
  const StoredColor color = stated.value_or(StoredColor());
  return toImage(state, &color);
}

Result<std::optional<std::vector<double>>> readPngCurve(const std::filesystem::path& path) {
  PngState state;
  state.headerOnly = true;
  VOLUTE_TRY(readPngFile(path, {}, state));
  VOLUTE_ASSIGN(const auto color, colorOf(state, path.string()));
  return color ? sampledCurve(*color, path) : std::optional<std::vector<double>>();
}

Result<PngKind> readPngKind(const std::filesystem::path& path) {
  PngState state;
  state.headerOnly = true;
  VOLUTE_TRY(readPngFile(path, {}, state));
  PngKind kind{state.channels, state.bits, "", state.pictures, state.pixelAspect, state.hasAlpha};
  if (state.codePoints)
    kind.color = fmt::format("cICP {}, {}", (*state.codePoints)[0], (*state.codePoints)[1]);
  else if (state.srgb)
    kind.color = "sRGB";
  else if (!state.profile.empty())
    kind.color = "an ICC profile";
  else if (state.gamma > 0)
    kind.color = fmt::format("gAMA {:.4g}", state.gamma);
  return kind;
}

Result<StoredPng> readStoredPng(const std::filesystem::path& path, std::uint64_t maxMemory) {
  PngState state;
  VOLUTE_TRY(readPngFile(path, {.maxMemory = maxMemory}, state));
  StoredPng stored{toImage(state, nullptr), (1 << state.bits) - 1};
  for (float& value : stored.image.pixels)
    value = std::round(value * static_cast<float>(stored.largest));
  return stored;
}

Result<std::optional<Image>> readPngAlpha(const std::filesystem::path& path,
                                          const ImageReadOptions& options) {
  PngState state;
  state.keepAlpha = true;
  VOLUTE_TRY(readPngFile(path, options, state));
  if (!state.hasAlpha)
    return std::optional<Image>();
  const Image all = toImage(state, nullptr);
  Image alpha(all.width, all.height, 1);
  for (std::size_t i = 0; i < alpha.pixels.size(); ++i)
    alpha.pixels[i] = all.pixels[(i + 1) * all.channels - 1];
  return std::optional<Image>(std::move(alpha));
}

namespace {

/// Writes what is laid out in `state`.
Status writePngState(const std::filesystem::path& path, PngState& state, const ImageNotes& notes) {
  // libpng takes names and texts that it promises not to change.
  std::vector<png_text> texts;
  for (const auto& [name, text] : notes) {
    png_text& entry = texts.emplace_back();
    entry.compression = PNG_TEXT_COMPRESSION_NONE;
    entry.key = const_cast<char*>(name.c_str());
    entry.text = const_cast<char*>(text.c_str());
    entry.text_length = text.size();
  }
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &state, onError, onWarning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  const bool encoded = info && encodePng(png, info, texts, state);
  png_destroy_write_struct(&png, &info);
  if (!encoded)
    return fail(ErrorCode::kIo, "{}: cannot encode the picture: {}", path.string(), state.message);
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  VOLUTE_TRY(file.write(state.written));
  return file.commit();
}

PngState stateOf(const Image& image, int bits) {
  PngState state;
  state.width = static_cast<png_uint_32>(image.width);
  state.height = static_cast<png_uint_32>(image.height);
  state.channels = image.channels;
  state.bits = bits;
  return state;
}

/// Value i of 16 bits; NaN gives 0.
void put16(PngState& state, std::size_t i, double value) {
  const double within = value > 0 ? std::min(value, 1.0) : 0;
  const auto stored = static_cast<std::uint16_t>(std::lround(65535 * within));
  std::memcpy(&state.pixels[2 * i], &stored, sizeof stored);
}

}  // namespace

Status writePng(const std::filesystem::path& path, const Image& image, const ImageNotes& notes) {
  PngState state = stateOf(image, 8);
  state.pixels = toSrgb8(image);
  layOutRows(state, std::size_t{state.width} * image.channels);
  return writePngState(path, state, notes);
}

Status writePngWithAlpha(const std::filesystem::path& path, const Image& color, const Image& alpha,
                         const ImageNotes& notes) {
  PngState state = stateOf(color, 8);
  const auto colors = static_cast<std::ptrdiff_t>(color.channels);
  state.channels = color.channels + 1;
  const std::vector<std::uint8_t> shown = toSrgb8(color);
  for (std::size_t i = 0; i < alpha.pixels.size(); ++i) {
    const auto from = shown.begin() + static_cast<std::ptrdiff_t>(i) * colors;
    state.pixels.insert(state.pixels.end(), from, from + colors);
    state.pixels.push_back(
        static_cast<png_byte>(std::lround(255 * std::clamp(alpha.pixels[i], 0.0F, 1.0F))));
  }
  layOutRows(state, static_cast<std::size_t>(state.channels) * state.width);
  return writePngState(path, state, notes);
}

Status writePng16(const std::filesystem::path& path, const Image& color,
                  const std::optional<Image>& alpha) {
  PngState state = stateOf(color, 16);
  const auto colors = static_cast<std::size_t>(color.channels), each = colors + (alpha ? 1 : 0);
  state.channels = static_cast<int>(each);
  state.pixels.resize(2 * each * state.width * state.height);
  parallelRanges(state.height, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin * state.width; i < end * state.width; ++i) {
      for (std::size_t c = 0; c < colors; ++c)
        put16(state, each * i + c, srgbEncode(color.pixels[colors * i + c]));
      if (alpha)
        put16(state, each * i + colors, alpha->pixels[i]);
    }
  });
  layOutRows(state, 2 * each * state.width);
  return writePngState(path, state, {});
}

Status writePngMap(const std::filesystem::path& path, const Image& map) {
  PngState state = stateOf(map, 16);
  state.linear = true;
  state.pixels.resize(2 * map.pixels.size());
  for (std::size_t i = 0; i < map.pixels.size(); ++i) put16(state, i, map.pixels[i]);
  layOutRows(state, 2 * std::size_t{state.width} * map.channels);
  return writePngState(path, state, {});
}

}  // namespace volute
