// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/stored_picture.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>
#if VOLUTE_HAS_TIFF
#include <tiffio.h>
#endif

#include "volute/io/frame_file.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;

constexpr std::uint64_t kMemory = 256 << 20;

std::string whyNoPicture(const std::filesystem::path& path, int page = 0) {
  const auto read = readStoredPicture(path, kMemory, page);
  return read ? "" : read.error().message;
}

TEST(StoredPicture, NetpbmOfBytesWordsAndText) {
  const TempFolder folder;
  writeBytes(folder / "a.pgm",
             std::string("P5\n# by hand\n2 2\n255\n") + std::string("\0\x33\x66\xFF", 4));
  ASSERT_VALUE(const auto bytes, readStoredPicture(folder / "a.pgm", kMemory));
  EXPECT_THAT(bytes.image.pixels, ::testing::ElementsAre(0, 0.2F, 0.4F, 1));
  EXPECT_EQ(bytes.largest, 255);
  EXPECT_FALSE(bytes.linear);

  writeBytes(folder / "b.ppm",
             std::string("P6 1 1 4095\n") + std::string("\x0F\xFF\x08\x00\0\0", 6));
  ASSERT_VALUE(const auto words, readStoredPicture(folder / "b.ppm", kMemory));
  EXPECT_EQ(words.image.channels, 3);
  EXPECT_FLOAT_EQ(words.image.pixels[0], 1);
  EXPECT_FLOAT_EQ(words.image.pixels[1], 2048.0F / 4095);
  EXPECT_EQ(words.largest, 4095);

  writeBytes(folder / "c.PNM", "P2\n3 1\n10\n0 5 # half\n10\n");
  ASSERT_VALUE(const auto text, readStoredPicture(folder / "c.PNM", kMemory));
  EXPECT_THAT(text.image.pixels, ::testing::ElementsAre(0, 0.5F, 1));
}

TEST(StoredPicture, FloatsOfNetpbmStandOnTheirHead) {
  const TempFolder folder;
  const float rows[] = {3, 4, 1, 2};  // the lower row first
  std::string bytes = "Pf\n2 2\n-1.0\n";
  bytes.append(reinterpret_cast<const char*>(rows), sizeof rows);
  writeBytes(folder / "a.pfm", bytes);
  ASSERT_VALUE(const auto read, readStoredPicture(folder / "a.pfm", kMemory));
  EXPECT_THAT(read.image.pixels, ::testing::ElementsAre(1, 2, 3, 4));
  EXPECT_TRUE(read.linear);
  EXPECT_TRUE(pictureKind(folder / "a.pfm", kMemory)->linear);
}

TEST(StoredPicture, WhatHeadsSayAndIsNotAppliedIsTold) {
  const TempFolder folder;
  const auto told = [&](const char* name) {
    const auto kind = pictureKind(folder / name, kMemory);
    std::string all;
    for (const Remark& remark : kind->remarks) all += remark.sentence + "\n";
    return all;
  };
  for (const auto& [scale, said] : {std::pair("-1.0", ""), std::pair("-1000", "a scale of 1000")}) {
    writeBytes(folder / "a.pfm", fmt::format("Pf\n1 1\n{}\n", scale) + std::string(4, '\0'));
    EXPECT_THAT(told("a.pfm"), HasSubstr(said));
    EXPECT_EQ(told("a.pfm").empty(), std::string_view(said).empty());
  }
  FramePixels frame{.color = Image(2, 2)};
  frame.part = {{1, 0, 3, 2}, {0, 0, 4, 2}, 2};
  std::ranges::fill(frame.color.pixels, 1.0F);
  ASSERT_TRUE(ok(writeFrame(folder / "a.exr", frame)));
  EXPECT_THAT(told("a.exr"), HasSubstr("2 times as wide as high"));
  EXPECT_THAT(told("a.exr"), HasSubstr("hold nothing for 50 % of their pixels"));
  ASSERT_VALUE(const auto read, readStoredPicture(folder / "a.exr", kMemory));
  EXPECT_EQ(read.there, (std::vector<std::uint8_t>{0, 1, 1, 0, 0, 1, 1, 0}));
  ASSERT_TRUE(ok(writeImage(folder / "a.png", Image(2, 2))));
  EXPECT_EQ(told("a.png"), "");
  // An acTL chunk with its checksum, of three pictures, before the first IDAT.
  std::string bytes = readBytes(folder / "a.png");
  bytes.insert(bytes.find("IDAT") - 4, std::string("\0\0\0\x08"
                                                   "acTL\0\0\0\3\0\0\0\0\xce\xed\xba\xc0",
                                                   20));
  writeBytes(folder / "a.png", bytes);
  EXPECT_THAT(told("a.png"), HasSubstr("an animation of 3 pictures"));
}

TEST(StoredPicture, DamagedNetpbmIsRefused) {
  const TempFolder folder;
  const auto refused = [&](const std::string& bytes) {
    writeBytes(folder / "a.pgm", bytes);
    return whyNoPicture(folder / "a.pgm");
  };
  EXPECT_THAT(refused("P5 2 2 255\nabc"), HasSubstr("3 bytes of pixels; expected 4"));
  EXPECT_THAT(refused("P5 2 2 255\nabcde"), HasSubstr("1 bytes after its picture"));
  EXPECT_THAT(refused("P5 2 2 70000\nabcd"), HasSubstr("not from 1 to 65535"));
  EXPECT_THAT(refused("P5 -2 2 255\nabcd"), HasSubstr("width or height"));
  EXPECT_THAT(refused("P5 2000000 2 255\nabcd"), HasSubstr("expected sides of at most"));
  EXPECT_THAT(refused("P5 2 1 10\nab"), HasSubstr("the largest is to be 10"));
  EXPECT_THAT(refused("P2 2 1 10\n3"), HasSubstr("fewer values"));
  EXPECT_THAT(refused("P2 2 1 10\n3 4 5"), HasSubstr("more values"));
  EXPECT_THAT(refused("P4 2 2\nab"), HasSubstr("begins with 'P4'"));
  EXPECT_THAT(refused(""), HasSubstr("begins with ''"));
}

std::string npy(const std::string& type, const std::string& shape, const std::string& data,
                const std::string& order = "False") {
  std::string header =
      "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': (" + shape + "), }";
  header.resize(117, ' ');
  header += '\n';
  return std::string("\x93NUMPY\x01\0\x76\0", 10) + header + data;
}

TEST(StoredPicture, ArraysOfIntegersAndFloats) {
  const TempFolder folder;
  writeBytes(folder / "a.npy", npy("|u1", "2, 3", std::string("\0\x33\x66\x99\xCC\xFF", 6)));
  ASSERT_VALUE(const auto bytes, readStoredPicture(folder / "a.npy", kMemory));
  EXPECT_EQ(bytes.image.width, 3);
  EXPECT_THAT(bytes.image.pixels, ::testing::ElementsAre(0, 0.2F, 0.4F, 0.6F, 0.8F, 1));
  EXPECT_FALSE(bytes.linear);

  writeBytes(folder / "a.npy",
             npy("|u1", "2, 3", std::string("\0\x99\x33\xCC\x66\xFF", 6), "True"));
  ASSERT_VALUE(const auto turned, readStoredPicture(folder / "a.npy", kMemory));
  EXPECT_EQ(turned.image.pixels, bytes.image.pixels);

  const double light[] = {0.5, 2, 8};
  writeBytes(
      folder / "b.npy",
      npy("<f8", "1, 1, 3", std::string(reinterpret_cast<const char*>(light), sizeof light)));
  ASSERT_VALUE(const auto floats, readStoredPicture(folder / "b.npy", kMemory));
  EXPECT_TRUE(floats.linear);
  EXPECT_TRUE(pictureKind(folder / "b.npy", kMemory)->linear);
  EXPECT_THAT(floats.image.pixels, ::testing::ElementsAre(0.5F, 2, 8));

  writeBytes(folder / "c.npy", npy("<i2", "1, 1", "ab"));
  EXPECT_THAT(whyNoPicture(folder / "c.npy"), HasSubstr("whose white is not known"));
  writeBytes(folder / "c.npy", npy("|u1", "1, 1, 2", "ab"));
  EXPECT_THAT(whyNoPicture(folder / "c.npy"), HasSubstr("expected a picture: (height, width)"));
  EXPECT_THAT(whyNoPicture(folder / "b.npy", 1), HasSubstr("holds one picture"));
}

TEST(StoredPicture, WhatPngAndExrStoreIsAsBefore) {
  const TempFolder folder;
  Image image(2, 1, 3);
  image.pixels = {0, 0.5F, 1, 0.25F, 0.75F, 0.125F};
  ASSERT_TRUE(writeImage(folder / "a.png", image));
  ASSERT_VALUE(const auto stored, readStoredPicture(folder / "a.png", kMemory));
  ASSERT_VALUE(const auto raw, readImage(folder / "a.png", {.raw = true}));
  EXPECT_EQ(stored.image.pixels, raw.pixels);
  EXPECT_FALSE(stored.linear);
  EXPECT_FALSE(stored.curve);
  EXPECT_THAT(whyNoPicture(folder / "a.jpg"), HasSubstr("not a known kind of picture"));
}

#if VOLUTE_HAS_TIFF

/// How a .tif is written.
struct Style {
  int bits = 16, channels = 1, format = SAMPLEFORMAT_UINT;
  int compression = COMPRESSION_NONE, photometric = PHOTOMETRIC_MINISBLACK;
  bool tiles = false, planes = false, alpha = false, big = false;
  int orientation = ORIENTATION_TOPLEFT, subfile = 0;
};

constexpr int kWidth = 37, kHeight = 29;

/// The value of a pixel, 0..1 in steps that any number of bits above 3 tells apart.
double valueOf(int x, int y, int channel) {
  return ((x * 7 + y * 3 + channel * 5) % 8) / 7.0;
}

double stepsOf(int bits) {
  return std::ldexp(1.0, bits) - 1;
}

void putValue(std::vector<unsigned char>& row, std::size_t i, double value, const Style& style) {
  if (style.format == SAMPLEFORMAT_IEEEFP) {
    const auto number = static_cast<float>(4 * value);
    std::memcpy(&row[i * 4], &number, 4);
    return;
  }
  const auto number = static_cast<std::uint32_t>(std::lround(value * stepsOf(style.bits)));
  if (style.bits == 16) {
    const auto word = static_cast<std::uint16_t>(number);
    std::memcpy(&row[i * 2], &word, 2);
  } else if (style.bits == 32) {
    std::memcpy(&row[i * 4], &number, 4);
  } else {
    for (int b = 0; b < style.bits; ++b) {
      const std::size_t at = i * static_cast<std::size_t>(style.bits) + static_cast<std::size_t>(b);
      if ((number >> (style.bits - 1 - b) & 1U) != 0)
        row[at / 8] = static_cast<unsigned char>(row[at / 8] | 0x80U >> at % 8);
    }
  }
}

void writePage(TIFF* file, const Style& style) {
  const int samples = style.channels + (style.alpha ? 1 : 0);
  TIFFSetField(file, TIFFTAG_IMAGEWIDTH, kWidth);
  TIFFSetField(file, TIFFTAG_IMAGELENGTH, kHeight);
  TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, style.bits);
  TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, samples);
  TIFFSetField(file, TIFFTAG_SAMPLEFORMAT, style.format);
  TIFFSetField(file, TIFFTAG_COMPRESSION, style.compression);
  TIFFSetField(file, TIFFTAG_PHOTOMETRIC,
               style.channels == 3 ? PHOTOMETRIC_RGB : style.photometric);
  TIFFSetField(file, TIFFTAG_PLANARCONFIG,
               style.planes ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
  TIFFSetField(file, TIFFTAG_ORIENTATION, style.orientation);
  if (style.subfile != 0)
    TIFFSetField(file, TIFFTAG_SUBFILETYPE, style.subfile);
  if (style.alpha) {
    const std::uint16_t kind = EXTRASAMPLE_UNASSALPHA;
    TIFFSetField(file, TIFFTAG_EXTRASAMPLES, 1, &kind);
  }
  constexpr int kTile = 16;
  if (style.tiles) {
    TIFFSetField(file, TIFFTAG_TILEWIDTH, kTile);
    TIFFSetField(file, TIFFTAG_TILELENGTH, kTile);
  } else {
    TIFFSetField(file, TIFFTAG_ROWSPERSTRIP, 5);
  }
  const int each = style.planes ? 1 : samples;
  const auto stored = [&](int x, int y, int sample) {
    if (sample == style.channels)
      return 1.0;
    if (style.orientation == ORIENTATION_BOTLEFT || style.orientation == ORIENTATION_BOTRIGHT)
      y = kHeight - 1 - y;
    if (style.orientation == ORIENTATION_TOPRIGHT || style.orientation == ORIENTATION_BOTRIGHT)
      x = kWidth - 1 - x;
    const double value = valueOf(x, y, sample);
    return style.photometric == PHOTOMETRIC_MINISWHITE ? 1 - value : value;
  };
  for (int plane = 0; plane < (style.planes ? samples : 1); ++plane) {
    if (!style.tiles) {
      for (int y = 0; y < kHeight; ++y) {
        std::vector<unsigned char> row(static_cast<std::size_t>(TIFFScanlineSize(file)));
        for (int x = 0; x < kWidth; ++x) {
          for (int s = 0; s < each; ++s)
            putValue(row, static_cast<std::size_t>(x * each + s), stored(x, y, plane + s), style);
        }
        ASSERT_EQ(TIFFWriteScanline(file, row.data(), static_cast<std::uint32_t>(y),
                                    static_cast<std::uint16_t>(plane)),
                  1);
      }
      continue;
    }
    for (int top = 0; top < kHeight; top += kTile) {
      for (int left = 0; left < kWidth; left += kTile) {
        std::vector<unsigned char> tile;
        for (int y = top; y < top + kTile; ++y) {
          std::vector<unsigned char> row(static_cast<std::size_t>(TIFFTileRowSize(file)));
          for (int x = left; x < left + kTile; ++x) {
            for (int s = 0; s < each && x < kWidth && y < kHeight; ++s)
              putValue(row, static_cast<std::size_t>((x - left) * each + s),
                       stored(x, y, plane + s), style);
          }
          tile.insert(tile.end(), row.begin(), row.end());
        }
        ASSERT_GT(
            TIFFWriteTile(file, tile.data(), static_cast<std::uint32_t>(left),
                          static_cast<std::uint32_t>(top), 0, static_cast<std::uint16_t>(plane)),
            0);
      }
    }
  }
}

void writeTiff(const std::filesystem::path& path, const std::vector<Style>& pages) {
  TIFF* file = TIFFOpen(path.c_str(), pages[0].big ? "w8" : "w");
  ASSERT_NE(file, nullptr);
  for (const Style& page : pages) {
    writePage(file, page);
    ASSERT_EQ(TIFFWriteDirectory(file), 1);
  }
  TIFFClose(file);
}

void expectPicture(const std::filesystem::path& path, const Style& style, int page = 0) {
  ASSERT_VALUE(const auto read, readStoredPicture(path, kMemory, page));
  ASSERT_EQ(read.image.width, kWidth);
  ASSERT_EQ(read.image.height, kHeight);
  ASSERT_EQ(read.image.channels, style.channels);
  EXPECT_EQ(read.linear, style.format == SAMPLEFORMAT_IEEEFP);
  EXPECT_EQ(read.alpha.has_value(), style.alpha);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < style.channels; ++c) {
        const double wanted =
            read.linear ? 4 * valueOf(x, y, c)
                        : std::lround(valueOf(x, y, c) * stepsOf(style.bits)) / stepsOf(style.bits);
        ASSERT_NEAR(read.image.at(x, y, c), wanted, 1e-6) << x << " " << y << " " << c;
      }
      if (style.alpha) {
        ASSERT_EQ(read.alpha->at(x, y), 1);
      }
    }
  }
}

TEST(Tiff, IntegersAndFloatsInStripsAndTiles) {
  const TempFolder folder;
  for (const int bits : {4, 8, 10, 12, 14, 16, 32}) {
    for (const int channels : {1, 3}) {
      for (const bool tiles : {false, true}) {
        for (const bool planes : {false, true}) {
          const Style style{.bits = bits, .channels = channels, .tiles = tiles, .planes = planes};
          SCOPED_TRACE(bits * 1000 + channels * 100 + (tiles ? 10 : 0) + (planes ? 1 : 0));
          writeTiff(folder / "a.tif", {style});
          expectPicture(folder / "a.tif", style);
        }
      }
    }
  }
  const Style floats{.bits = 32, .channels = 3, .format = SAMPLEFORMAT_IEEEFP};
  writeTiff(folder / "b.TIFF", {floats});
  expectPicture(folder / "b.TIFF", floats);
  EXPECT_TRUE(pictureKind(folder / "b.TIFF", kMemory)->linear);
}

TEST(Tiff, CompressionsColorsAndDirections) {
  const TempFolder folder;
  std::vector<Style> styles = {
      {.compression = COMPRESSION_LZW},
      {.channels = 3, .compression = COMPRESSION_ADOBE_DEFLATE},
      {.bits = 8, .channels = 3, .compression = COMPRESSION_PACKBITS, .alpha = true},
      {.bits = 12, .photometric = PHOTOMETRIC_MINISWHITE},
      {.big = true},
      {.orientation = ORIENTATION_BOTLEFT},
      {.channels = 3, .orientation = ORIENTATION_BOTRIGHT},
      {.channels = 3, .orientation = ORIENTATION_TOPRIGHT},
  };
  for (std::size_t i = 0; i < styles.size(); ++i) {
    SCOPED_TRACE(i);
    writeTiff(folder / "a.tif", {styles[i]});
    expectPicture(folder / "a.tif", styles[i]);
  }
}

TEST(Tiff, PagesOfFullSizeCount) {
  const TempFolder folder;
  const Style small{.subfile = FILETYPE_REDUCEDIMAGE};
  writeTiff(folder / "a.tif", {{.bits = 8}, small, {.bits = 12}, small, {.bits = 16}});
  ASSERT_VALUE(const auto kind, pictureKind(folder / "a.tif", kMemory));
  EXPECT_EQ(kind.pages, 3);
  ASSERT_VALUE(const auto second, readStoredPicture(folder / "a.tif", kMemory, 1));
  EXPECT_EQ(second.largest, 4095);
  expectPicture(folder / "a.tif", {.bits = 16}, 2);
  EXPECT_THAT(whyNoPicture(folder / "a.tif", 3), HasSubstr("has 3 pictures, none of number 3"));
}

TEST(Tiff, WhatIsNoLightIsRefused) {
  const TempFolder folder;
  writeTiff(folder / "a.tif", {{.bits = 16, .format = SAMPLEFORMAT_INT}});
  EXPECT_THAT(whyNoPicture(folder / "a.tif"), HasSubstr("signed integers of 16 bits"));
  writeTiff(folder / "a.tif", {{.orientation = ORIENTATION_RIGHTTOP}});
  EXPECT_THAT(whyNoPicture(folder / "a.tif"), HasSubstr("stored on its side (orientation 6)"));
  writeTiff(folder / "a.tif", {{.bits = 8, .photometric = PHOTOMETRIC_CIELAB}});
  EXPECT_THAT(whyNoPicture(folder / "a.tif"), HasSubstr("photometric interpretation 8"));
  writeBytes(folder / "a.tif", "II*");
  EXPECT_THAT(whyNoPicture(folder / "a.tif"), HasSubstr("not a whole TIFF picture"));
}

/// Nothing crashes, and what is read has the size that was written or is an error.
TEST(Tiff, DamageIsAnErrorAtWorst) {
  const TempFolder folder;
  const Style style{.bits = 12, .channels = 3, .compression = COMPRESSION_LZW};
  writeTiff(folder / "a.tif", {style});
  const std::string whole = readBytes(folder / "a.tif");
  const auto read = [](const std::filesystem::path& file) {
    return readStoredPicture(file, kMemory);
  };
  expectCutsRefused(folder / "b.tif", whole, read, 1 + whole.size() / 40);
  for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 80) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
    writeBytes(folder / "b.tif", bytes);
    const auto damaged = read(folder / "b.tif");
    EXPECT_TRUE(!damaged || damaged->image.width > 0) << at;
  }
}

#endif

}  // namespace
}  // namespace volute
