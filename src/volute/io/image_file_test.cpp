// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/image_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "volute/image/srgb.hpp"
#include "volute/io/frame_file.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;

Image makePicture(int width, int height, int channels, float scale = 1) {
  Image image(width, height, channels);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = scale * static_cast<float>(i * 37 % 101) / 100;
  return image;
}

RC_GTEST_PROP(Png, ReadsWhatItWritesTo8Bits, ()) {
  const TempFolder folder;
  const auto written =
      makePicture(*rc::gen::inRange(1, 20), *rc::gen::inRange(1, 20), *rc::gen::element(1, 3));
  const auto file = folder / *rc::gen::element("a.png", "A.PNG");
  RC_ASSERT(writeImage(file, written).has_value());
  const auto read = readImage(file);
  RC_ASSERT(read.has_value());
  RC_ASSERT(read->width == written.width && read->height == written.height &&
            read->channels == written.channels);
  RC_ASSERT(toSrgb8(*read) == toSrgb8(written));
}

// Drawings, most of whose rows repeat, are written in another way.
TEST(Png, DrawingsAreKeptToTheByte) {
  const TempFolder folder;
  Image image(301, 200, 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c)
        image.at(x, y, c) = static_cast<float>((x / 7 * 31 + y / 9 * 17 + c * 5) % 64) / 64;
    }
  }
  image.at(150, 100, 1) = 0.77F;  // a row of its own
  ASSERT_TRUE(writeImage(folder / "a.png", image));
  const auto read = readImage(folder / "a.png");
  ASSERT_TRUE(read);
  EXPECT_EQ(toSrgb8(*read), toSrgb8(image));
}

TEST(Png, MapsKeep16Bits) {
  const TempFolder folder;
  Image map(7, 5, 1);
  for (std::size_t i = 0; i < map.pixels.size(); ++i)
    map.pixels[i] = static_cast<float>(i * i) / 1157.0F;
  ASSERT_TRUE(writeMap(folder / "map.png", map).has_value());
  const auto read = readImage(folder / "map.png", {.raw = true});
  ASSERT_TRUE(read.has_value());
  ASSERT_EQ(read->channels, 1);
  for (std::size_t i = 0; i < map.pixels.size(); ++i)
    EXPECT_NEAR(read->pixels[i], map.pixels[i], 0.5 / 65535 + 1e-7);
  EXPECT_FALSE(writeMap(folder / "map.jpg", map).has_value());
}

TEST(Png, RawValuesAreNotDecoded) {
  const TempFolder folder;
  Image image(2, 1, 1);
  image.pixels = {1, static_cast<float>(srgbDecode(51.0 / 255))};
  ASSERT_TRUE(ok(writeImage(folder / "a.png", image)));
  ASSERT_VALUE(const auto raw, readImage(folder / "a.png", {.raw = true}));
  EXPECT_EQ(raw.pixels, (std::vector<float>{1, 0.2f}));
  ASSERT_VALUE(const auto linear, readImage(folder / "a.png"));
  EXPECT_NEAR(linear.pixels[1], 0.0331f, 1e-4f);
}

std::string fromHex(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2)
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  return bytes;
}

// 2 x 2 pixels written by another program: 16-bit grey (0, 1, 32768, 65535); a palette with
// transparency (red, green, blue, white); RGBA (1,2,3,128), (255,0,0,0), (0,255,0,255), (9,9,9,9).
constexpr const char* kGrey16 =
    "89504e470d0a1a0a0000000d4948445200000002000000021000000000074d8ebb0000001249444154789c6360"
    "606060646860f8ff1f00050d02800170ca8c0000000049454e44ae426082";
constexpr const char* kPalette =
    "89504e470d0a1a0a0000000d49484452000000020000000208030000004568fd160000000c504c5445ff000000"
    "ff000000fffffffffb0060f60000000274524e5300809b2b4e180000000e49444154789c636060646062060000"
    "1100079ea22a120000000049454e44ae426082";
// The same without white, which its last pixel has.
constexpr const char* kShortPalette =
    "89504e470d0a1a0a0000000d49484452000000020000000208030000004568fd1600000009504c5445ff000000"
    "ff000000ff2d4acd8a0000000274524e5300809b2b4e180000000e49444154789c636060646062060000110007"
    "9ea22a120000000049454e44ae426082";
constexpr const char* kRgba =
    "89504e470d0a1a0a0000000d494844520000000200000002080600000072b60d240000001649444154789c6360"
    "64626ef8cf0002ff19fe7302010020b103a816ff1b4f0000000049454e44ae426082";

TEST(Png, SixteenBits) {
  const TempFolder folder;
  writeBytes(folder / "a.png", fromHex(kGrey16));
  ASSERT_VALUE(const auto raw, readImage(folder / "a.png", {.raw = true}));
  EXPECT_EQ(raw.channels, 1);
  EXPECT_EQ(raw.pixels, (std::vector<float>{0, 1 / 65535.0f, 32768 / 65535.0f, 1}));
}

TEST(Png, PaletteAndAlpha) {
  const TempFolder folder;
  writeBytes(folder / "p.png", fromHex(kPalette));
  ASSERT_VALUE(const auto palette, readImage(folder / "p.png"));
  EXPECT_EQ(palette.channels, 3);
  EXPECT_EQ(palette.pixels, (std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}));
  ASSERT_VALUE(const auto seen, readAlpha(folder / "p.png"));
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->pixels, (std::vector<float>{0, 128 / 255.0f, 1, 1}));
  writeBytes(folder / "p.png", fromHex(kShortPalette));
  const auto shorter = readImage(folder / "p.png");
  ASSERT_FALSE(shorter);
  EXPECT_THAT(shorter.error().message, HasSubstr("pixel 1, 1 has colour 3 of a palette of 3"));
  writeBytes(folder / "a.png", fromHex(kRgba));
  ASSERT_VALUE(const auto alpha, readImage(folder / "a.png", {.raw = true}));
  EXPECT_EQ(alpha.channels, 3);
  EXPECT_EQ(alpha.pixels[2], 3 / 255.0f);
  EXPECT_EQ(alpha.pixels[3], 1);
}

TEST(Png, AlphaIsWrittenBesideGreyAsBesideColour) {
  const TempFolder folder;
  const Image alpha = makePicture(5, 4, 1, 0.5F);
  for (const int channels : {1, 3}) {
    const Image color = makePicture(5, 4, channels);
    for (const int bits : {8, 16}) {
      const auto path = folder / "a.png";
      ASSERT_TRUE(
          ok(bits == 8 ? writePngWithAlpha(path, color, alpha) : writePng16(path, color, alpha)));
      ASSERT_VALUE(const auto shown, readImage(path));
      ASSERT_VALUE(const auto seen, readAlpha(path));
      ASSERT_EQ(shown.channels, channels);
      ASSERT_TRUE(seen);
      for (std::size_t i = 0; i < color.pixels.size(); ++i)
        EXPECT_NEAR(shown.pixels[i], color.pixels[i], 6e-3) << channels << " " << bits;
      for (std::size_t i = 0; i < alpha.pixels.size(); ++i)
        EXPECT_NEAR(seen->pixels[i], alpha.pixels[i], 3e-3) << channels << " " << bits;
    }
  }
}

TEST(Png, PicturesThatAreMarkedAsTurnedAreRefused) {
  const TempFolder folder;
  // eXIf with TIFF's tag 274, big-endian: orientation 3 with its checksum, and 1.
  const std::string turned =
                        "0000001a65584966"
                        "4d4d002a0000000800010112000300000001000300000000"
                        "0000",
                    upright =
                        "0000001a65584966"
                        "4d4d002a0000000800010112000300000001000100000000"
                        "0000";
  const auto with = [&](const std::string& exif, const std::string& sum) {
    std::string hex = kGrey16;
    hex.insert(2 * 33, exif + sum);  // behind IHDR
    writeBytes(folder / "a.png", fromHex(hex));
    return readImage(folder / "a.png");
  };
  EXPECT_TRUE(with(upright, "13c075e7"));
  const auto refused = with(turned, "845f64ce");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("shown turned or mirrored (orientation 3)"));
}

TEST(Png, EveryTruncationAndEveryBitFlipIsRefused) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeImage(folder / "a.png", makePicture(5, 4, 3))));
  const std::string bytes = readBytes(folder / "a.png");
  expectCutsRefused(folder / "b.png", bytes, [](const auto& file) { return readImage(file); });
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    writeBytes(folder / "b.png", withFlippedBit(bytes, bit));
    EXPECT_FALSE(readImage(folder / "b.png")) << "bit " << bit;
  }
}

TEST(Images, KeepNotes) {
  const TempFolder folder;
  const ImageNotes notes = {{"volute.mode", "threshold"}, {"volute.time", "3 s"}};
  for (const char* name : {"a.png", "a.exr"}) {
#if !VOLUTE_HAS_EXR
    if (name == std::string("a.exr"))
      continue;
#endif
    ASSERT_TRUE(ok(writeImage(folder / name, makePicture(5, 4, 3), notes)));
    const std::string bytes = readBytes(folder / name);
    for (const auto& [key, text] : notes) {
      EXPECT_THAT(bytes, HasSubstr(key)) << name;
      EXPECT_THAT(bytes, HasSubstr(text)) << name;
    }
  }
}

TEST(Images, UnknownKindsMissingFilesAndMemory) {
  const TempFolder folder;
  EXPECT_EQ(readImage("a.gif").error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(writeImage("a.gif", makePicture(1, 1, 1)).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(readImage(folder / "none.png").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(writeImage(folder / "none/a.png", makePicture(1, 1, 1)).error().code, ErrorCode::kIo);
  ASSERT_TRUE(ok(writeImage(folder / "a.png", makePicture(10, 10, 3))));
  EXPECT_EQ(readImage(folder / "a.png", {.maxMemory = 1199}).error().code, ErrorCode::kTooLarge);
  EXPECT_TRUE(ok(readImage(folder / "a.png", {.maxMemory = 1200})));
}

#if VOLUTE_HAS_EXR

TEST(Exr, KeepsEveryFloat) {
  const TempFolder folder;
  for (int channels : {1, 3}) {
    auto written = makePicture(7, 5, channels, 1000);
    written.pixels[1] = std::numeric_limits<float>::infinity();
    written.pixels[2] = -0.25f;
    ASSERT_TRUE(ok(writeImage(folder / "a.exr", written)));
    ASSERT_VALUE(const auto read, readImage(folder / "a.exr"));
    EXPECT_EQ(read.channels, channels);
    EXPECT_EQ(read.pixels, written.pixels);
  }
}

TEST(Exr, SaysWhichColoursItsNumbersAre) {
  const TempFolder folder;
  ASSERT_TRUE(writeImage(folder / "a.exr", makePicture(5, 4, 3)));
  ASSERT_TRUE(writeImage(folder / "b.exr", makePicture(5, 4, 1)));
  const auto says = [&](const char* name) {
    const auto bytes = readBytes(folder / name);
    return std::string(bytes.begin(), bytes.end()).find("chromaticities") != std::string::npos;
  };
  EXPECT_TRUE(says("a.exr"));
  EXPECT_FALSE(says("b.exr")) << "a quantity";
}

TEST(Exr, ColoursOfOtherPrimariesBecomeThoseOfSrgb) {
  const TempFolder folder;
  Image written(4, 1, 3);
  written.pixels = {1, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  ASSERT_TRUE(writeImage(folder / "a.exr", written));
  std::string bytes = readBytes(folder / "a.exr");
  const std::string name("chromaticities\0chromaticities\0", 30);
  const std::size_t at = bytes.find(name);
  ASSERT_NE(at, std::string::npos);
  const std::array<float, 8> aces{0.7347F, 0.2653F, 0, 1, 0.0001F, -0.077F, 0.32168F, 0.33767F};
  bytes.replace(at + name.size() + 4, sizeof aces, reinterpret_cast<const char*>(aces.data()),
                sizeof aces);
  writeBytes(folder / "a.exr", bytes);
  ASSERT_VALUE(const auto read, readImage(folder / "a.exr"));
  // The Academy's matrix for Rec. 709, by Bradford's adaptation.
  const std::array<float, 12> expected{1,         1,         1,         2.52169F,
                                       -0.27648F, -0.01538F, -1.13413F, 1.37272F,
                                       -0.15298F, -0.38756F, -0.09624F, 1.16835F};
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(read.pixels[i], expected[i], 2e-3) << i;
}

TEST(Exr, EqualInputsGiveEqualBytes) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeImage(folder / "a.exr", makePicture(40, 40, 3))));
  ASSERT_TRUE(ok(writeImage(folder / "b.exr", makePicture(40, 40, 3))));
  EXPECT_TRUE(readBytes(folder / "a.exr") == readBytes(folder / "b.exr"));
}

TEST(Exr, TruncationsAreRefusedAndBitFlipsNeverCrash) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeImage(folder / "a.exr", makePicture(9, 20, 3))));
  const std::string bytes = readBytes(folder / "a.exr");
  expectCutsRefused(folder / "b.exr", bytes, [](const auto& file) { return readImage(file); });
  for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += 11) {
    writeBytes(folder / "b.exr", withFlippedBit(bytes, bit));
    const auto read = readImage(folder / "b.exr", {.maxMemory = 1 << 24});
    EXPECT_TRUE(read || !read.error().message.empty());
  }
}

TEST(Exr, MemoryIsCheckedFirst) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeImage(folder / "a.exr", makePicture(10, 10, 1))));
  EXPECT_EQ(readImage(folder / "a.exr", {.maxMemory = 399}).error().code, ErrorCode::kTooLarge);
}

#else

TEST(Exr, ABuildWithoutItSaysSo) {
  EXPECT_THAT(readImage("a.exr").error().message, HasSubstr("this build has no OpenEXR"));
  EXPECT_THAT(writeImage("a.exr", Image(1, 1)).error().message, HasSubstr("VOLUTE_WITH_EXR=OFF"));
}

#endif

}  // namespace
}  // namespace volute
