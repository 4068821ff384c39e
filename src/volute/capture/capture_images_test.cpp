// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/capture_images.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "volute/capture/background.hpp"
#include "volute/capture/capture_check.hpp"
#include "volute/capture/testing.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/frame_file.hpp"

namespace volute {
namespace {

using testing::failsWith;
using testing::kHeight;
using testing::kWidth;
using testing::ok;
using testing::ringJson;
using testing::sentences;

class CaptureImagesTest : public ::testing::Test {
 protected:
  void SetUp() override { testing::writeRingPictures(folder); }

  /// A picture of the ring's size.
  Image picture(float value, int channels = 3) const {
    Image image(kWidth, kHeight, channels);
    std::ranges::fill(image.pixels, value);
    return image;
  }

  void write(const std::string& name, const Image& image) {
    std::filesystem::remove(folder / name);
    ASSERT_TRUE(ok(writeImage(folder / name, image)));
  }

  Result<CameraPicture> readPicture(std::size_t camera, int frame) {
    testing::writeText(folder / "capture.json", json.dump());
    VOLUTE_ASSIGN(capture, openCapture(folder / "capture.json", {}));
    Progress progress;
    VOLUTE_ASSIGN(auto images, CaptureImages::open(*capture, 1 << 30, progress));
    return images.read(camera, frame);
  }

  testing::TempFolder folder;
  nlohmann::json json = ringJson();
  std::optional<Capture> capture;
};

TEST_F(CaptureImagesTest, ReadsRadiance) {
  json["white"] = 2;
  json["cameras"][1]["gain"] = 0.5;
  ASSERT_VALUE(const auto a, readPicture(0, 5));
  EXPECT_FLOAT_EQ(a.radiance.at(12, 8, 1), 10);
  ASSERT_VALUE(const auto b, readPicture(1, 4));
  EXPECT_FLOAT_EQ(b.radiance.at(12, 8, 2), 4.1f);
  EXPECT_EQ(b.radiance.at(0, 0), 0);
  EXPECT_EQ(b.saturatedShare, 0);
  EXPECT_FLOAT_EQ(b.brightest, 4.1f);
  EXPECT_FALSE(b.grey);
}

TEST_F(CaptureImagesTest, ChannelsHaveGainsAndCamerasExposures) {
  write("f_0004_a.exr", picture(0.5f));
  json["cameras"][0]["gain"] = {1, 2, 0.5};
  json["cameras"][0]["exposure"] = 0.25;
  ASSERT_VALUE(const auto read, readPicture(0, 4));
  EXPECT_FLOAT_EQ(read.radiance.at(3, 3, 0), 2);
  EXPECT_FLOAT_EQ(read.radiance.at(3, 3, 1), 4);
  EXPECT_FLOAT_EQ(read.radiance.at(3, 3, 2), 1);
}

TEST_F(CaptureImagesTest, GreyPicturesBecomeThreeChannels) {
  write("f_0004_a.exr", picture(0.5f, 1));
  ASSERT_VALUE(const auto read, readPicture(0, 4));
  EXPECT_TRUE(read.grey);
  EXPECT_EQ(read.radiance.channels, 3);
  EXPECT_EQ(read.radiance.at(3, 3, 2), 0.5f);
}

TEST_F(CaptureImagesTest, PngValuesBecomeLight) {
  json["cameras"][0]["image"] = "p_%04d.png";
  Image light = picture(0.25f);
  light.at(5, 6, 0) = 1;
  write("p_0004.png", light);  // written as sRGB
  for (const auto& [color, factor] : {std::pair("srgb", 1.0), std::pair("linear", 0.5371 / 0.25)}) {
    json["color"] = color;
    ASSERT_VALUE(const auto read, readPicture(0, 4));
    EXPECT_NEAR(read.radiance.at(2, 2, 1), 0.25 * factor, 2e-3);
    EXPECT_EQ(read.weight[6 * kWidth + 5], 0) << "saturated";
    EXPECT_EQ(read.weight[0], 1);
    EXPECT_EQ(read.atLeast[0], 0);
    EXPECT_NE(read.atLeast[6 * kWidth + 5], 0);
    EXPECT_NEAR(read.saturatedShare, 1.0 / (kWidth * kHeight), 1e-12);
  }
  json["saturation"] = 0.5;
  ASSERT_VALUE(const auto all, readPicture(0, 4));
  EXPECT_EQ(all.saturatedShare, 1);
}

TEST_F(CaptureImagesTest, PngFilesMayStateHowTheyStoreLight) {
  json["cameras"][0]["image"] = "p_%04d.png";
  json.erase("color");
  const Image light = picture(0.25f);
  write("p_0004.png", light);  // states sRGB
  ASSERT_VALUE(const auto srgb, readPicture(0, 4));
  EXPECT_NEAR(srgb.radiance.at(2, 2, 1), 0.25, 2e-3);
  ASSERT_TRUE(testing::ok(writeMap(folder / "p_0004.png", light)));  // states that it is linear
  ASSERT_VALUE(const auto linear, readPicture(0, 4));
  EXPECT_NEAR(linear.radiance.at(2, 2, 1), 0.25, 1e-4);
  const auto told = [&] {
    return std::ranges::count_if(sentences(capture->remarks), [](const std::string& text) {
      return text.find("which counts") != std::string::npos;
    });
  };
  EXPECT_EQ(told(), 0);
  json["color"] = "srgb";  // what the capture states counts
  ASSERT_VALUE(const auto stated, readPicture(0, 4));
  EXPECT_EQ(told(), 1) << "the file says that it is linear";
  EXPECT_NEAR(stated.radiance.at(2, 2, 1), 0.0508, 1e-3);
  json["color"] = "gamma:1.2";
  ASSERT_VALUE(const auto near, readPicture(0, 4));
  EXPECT_EQ(told(), 1) << "another curve";
  json.erase("color");
  testing::writeText(folder / "capture.json", json.dump());
  CaptureOptions options;
  options.response = Response::srgb();
  capture.emplace(openCapture(folder / "capture.json", options).value());
  EXPECT_EQ(told(), 1) << "as is what was asked for";
  write("p_0004.png", light);  // states sRGB, which 2.2 is near
  json["color"] = "gamma:2.2";
  ASSERT_VALUE(const auto power, readPicture(0, 4));
  EXPECT_EQ(told(), 0);
  json["saturation"] = 250;
  EXPECT_TRUE(
      failsWith(readPicture(0, 4), "\"saturation\" is 250; expected a stored value up to 1"));
  json["cameras"][0]["saturation"] = 0.9;
  EXPECT_TRUE(readPicture(1, 4)) << "of floats";
}

/// A smooth flame of many values, up to `most`.
Image flame(float most, int channels = 1) {
  Image image(kWidth, kHeight, channels);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double r = std::hypot(x - 11.3, 1.5 * (y - 7.6)) / 7;
      for (int c = 0; c < channels; ++c)
        image.at(x, y, c) = most * static_cast<float>(std::exp(-r * r) * (1 - 0.1 * c));
    }
  }
  return image;
}

Image clipped(Image image, float most) {
  for (float& value : image.pixels) value = std::min(value, most);
  return image;
}

TEST_F(CaptureImagesTest, FewBitsInFilesOfSixteen) {
  json["cameras"][0]["image"] = "p_%04d.png";
  constexpr float kTwelve = 4095.0F / 65535;
  const auto writeClipped = [&](float most, float limit) {
    std::filesystem::remove(folder / "p_0004.png");
    ASSERT_TRUE(ok(writeMap(folder / "p_0004.png", clipped(flame(most), limit))));
  };
  writeClipped(2 * kTwelve, kTwelve);
  ASSERT_VALUE(const auto told, readPicture(0, 4));
  ASSERT_TRUE(told.plateau.has_value());
  EXPECT_NEAR(told.plateau->value, kTwelve, 1e-6);
  EXPECT_EQ(bitsOf(told.plateau->value), 12);
  EXPECT_GT(told.saturatedShare, 0.05);
  EXPECT_EQ(told.weight[8 * kWidth + 11], 0);
  EXPECT_EQ(told.atLeast[8 * kWidth + 11], 7);
  json["bits"] = 12;
  ASSERT_VALUE(const auto stated, readPicture(0, 4));
  EXPECT_FALSE(stated.plateau.has_value());
  EXPECT_EQ(stated.bitsHolding, 0);
  EXPECT_EQ(stated.saturatedShare, told.saturatedShare);
  EXPECT_NEAR(stated.brightest, 1, 1e-4);
  EXPECT_NEAR(stated.radiance.at(4, 8), 65535.0F / 4095 * told.radiance.at(4, 8), 1e-3);
  json["bits"] = 10;
  EXPECT_TRUE(
      failsWith(readPicture(0, 4), "values up to 4095 of 65535, more than the 1023 of its"));
  json.erase("bits");
  writeClipped(0.3F, 0.2F);
  ASSERT_VALUE(const auto other, readPicture(0, 4));
  ASSERT_TRUE(other.plateau.has_value());
  EXPECT_FALSE(bitsOf(other.plateau->value).has_value());
  json["saturation"] = 1;
  ASSERT_VALUE(const auto denied, readPicture(0, 4));
  EXPECT_FALSE(denied.plateau.has_value());
  EXPECT_EQ(denied.saturatedShare, 0);
  json.erase("saturation");
  for (const float most : {kTwelve, 0.2F, 0.9F}) {
    writeClipped(most, 1);
    ASSERT_VALUE(const auto smooth, readPicture(0, 4));
    EXPECT_FALSE(smooth.plateau.has_value()) << most;
    EXPECT_EQ(smooth.bitsHolding, most == kTwelve ? 12 : most == 0.2F ? 14 : 16);
  }
  std::filesystem::remove(folder / "p_0004.png");
  write("p_0004.png", flame(0.5F, 3));  // 8 bits
  ASSERT_VALUE(const auto bytes, readPicture(0, 4));
  EXPECT_FALSE(bytes.plateau.has_value());
  EXPECT_EQ(bytes.bitsHolding, 0);
  write("p_0004.png", picture(0.001F));  // stored below 16 of 255
  for (const int bits : {8, 12}) {
    json["bits"] = bits;
    ASSERT_VALUE(const auto dark, readPicture(0, 4));
    EXPECT_NEAR(dark.radiance.at(3, 3), 3.0 / 255, 1e-5) << bits;
  }
  EXPECT_TRUE(std::ranges::any_of(capture->remarks, [](const Remark& remark) {
    return remark.sentence.ends_with("\"bits\": 12 has no effect: pictures hold values up to 255");
  }));
}

/// A .npy of uint32 in which all pixels have one value.
std::string wordsOf(std::uint32_t value) {
  std::string npy = std::string("\x93NUMPY\x01\0\x76\0", 10) +
                    fmt::format("{{'descr': '<u4', 'fortran_order': False, 'shape': ({}, {}), }}",
                                kHeight, kWidth);
  npy.resize(127, ' ');
  npy += '\n';
  for (int i = 0; i < kWidth * kHeight; ++i)
    npy.append(reinterpret_cast<const char*>(&value), sizeof value);
  return npy;
}

TEST_F(CaptureImagesTest, FewBitsInFilesOfThirtyTwo) {
  json["cameras"][0]["image"] = "q_%04d.npy";
  testing::writeText(folder / "q_0004.npy", wordsOf(2048));
  ASSERT_VALUE(const auto bare, readPicture(0, 4));
  EXPECT_EQ(bare.bitsHolding, 12);
  EXPECT_EQ(bare.largest, 4294967295.0);
  json["bits"] = 12;
  ASSERT_VALUE(const auto read, readPicture(0, 4));
  EXPECT_NEAR(read.radiance.at(3, 3), 2048.0 / 4095, 1e-5);
  testing::writeText(folder / "q_0004.npy", wordsOf(60000));
  EXPECT_TRUE(failsWith(readPicture(0, 4), "values up to 60000 of 4294967295, more than the 4095"));
  json["bits"] = 20;
  ASSERT_VALUE(const auto twenty, readPicture(0, 4));
  EXPECT_NEAR(twenty.radiance.at(3, 3), 60000.0 / 1048575, 1e-5);
}

/// A grey .tif of 16 bits with a page of one value for each of `levels`.
std::string stackOf(const std::vector<int>& levels) {
  std::string bytes("II*\0", 4);
  const auto put = [&]<class T>(T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  constexpr std::uint32_t kPixels = 2 * kWidth * kHeight;
  constexpr std::uint32_t kEntries = 9;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    put(static_cast<std::uint32_t>(bytes.size() + 4 + kPixels));  // where the directory is
    const auto pixels = static_cast<std::uint32_t>(bytes.size());
    for (std::uint32_t j = 0; j < kPixels / 2; ++j) put(static_cast<std::uint16_t>(levels[i]));
    put(static_cast<std::uint16_t>(kEntries));
    const auto entry = [&](int tag, int type, std::uint32_t value) {
      put(static_cast<std::uint16_t>(tag));
      put(static_cast<std::uint16_t>(type));
      put(std::uint32_t{1});
      put(value);
    };
    entry(256, 3, kWidth);
    entry(257, 3, kHeight);
    entry(258, 3, 16);
    entry(259, 3, 1);
    entry(262, 3, 1);
    entry(273, 4, pixels);
    entry(277, 3, 1);
    entry(278, 3, kHeight);
    entry(279, 4, kPixels);
  }
  put(std::uint32_t{0});
  return bytes;
}

TEST_F(CaptureImagesTest, PagesOfATiffAreFrames) {
  json.erase("frames");
  for (int i = 0; i < 3; ++i) {
    const std::string name = fmt::format("stack {}.tif", i);
    testing::writeText(folder / name, stackOf({6553, 13107, 19661 + i}));
    json["cameras"][static_cast<std::size_t>(i)]["image"] = name;
  }
  ASSERT_VALUE(const auto second, readPicture(0, 1));
  EXPECT_NEAR(second.radiance.at(3, 3), 0.2, 1e-5);
  ASSERT_VALUE(const auto third, readPicture(2, 2));
  EXPECT_NEAR(third.radiance.at(3, 3), 19663.0 / 65535, 1e-6);
  EXPECT_EQ(capture->frames, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(capture->cameras[0].pictures.pages, 3);

  json["frames"] = {1, 2, 3};  // the last is nowhere
  ASSERT_FALSE(readPicture(0, 3));
  const auto there = checkPicturesThere(*capture, false, 1 << 30);
  EXPECT_TRUE(failsWith(there, "there is no page 3 of")) << "of too few cameras";

  testing::writeText(folder / "f_0001.tif", stackOf({1, 2}));
  json["cameras"][1]["image"] = "f_%04d.tif";
  EXPECT_TRUE(failsWith(readPicture(0, 1), "holds 2 pictures; expected one in each numbered file"));
}

TEST_F(CaptureImagesTest, AnEmptyFirstPictureIsThatOfItsFrameAlone) {
  json["cameras"][0]["image"] = "p_%04d.png";
  testing::writeText(folder / "p_0004.png", "");
  write("p_0005.png", picture(0.25f));
  ASSERT_VALUE(const auto second, readPicture(0, 5));
  EXPECT_GT(second.radiance.at(2, 2, 1), 0.1);
  EXPECT_TRUE(failsWith(readPicture(0, 4), "is empty, 0 bytes"));
}

TEST_F(CaptureImagesTest, StillsOfLaboratories) {
  json["cameras"][0]["image"] = "p_%04d.pgm";
  json["cameras"][1]["image"] = "q_%04d.npy";
  std::string grey = fmt::format("P5\n{} {}\n4095\n", kWidth, kHeight);
  std::string floats = "\x93NUMPY";
  floats += std::string("\x01\0\x76\0", 4) +
            fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}", kHeight,
                        kWidth);
  floats.resize(127, ' ');
  floats += '\n';
  for (int i = 0; i < kWidth * kHeight; ++i) {
    grey += std::string("\x04\x00", 2);  // 1024
    const float value = 3.5F;
    floats.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  testing::writeText(folder / "p_0004.pgm", grey);
  testing::writeText(folder / "q_0004.npy", floats);
  for (const int bits : {0, 12}) {  // the file says it already
    json["cameras"][0]["bits"] = bits == 0 ? 16 : bits;
    ASSERT_VALUE(const auto read, readPicture(0, 4));
    EXPECT_NEAR(read.radiance.at(3, 3), 1024.0 / 4095, 1e-5);
    if (bits == 0)
      json["cameras"][0].erase("bits");
  }
  ASSERT_VALUE(const auto light, readPicture(1, 4));
  EXPECT_EQ(light.radiance.at(3, 3), 3.5F);
  EXPECT_TRUE(capture->cameras[1].pictures.linear);
  EXPECT_FALSE(capture->cameras[0].pictures.linear);
}

TEST_F(CaptureImagesTest, BlackLevels) {
  constexpr float kBlack = 64.0F / 1023;
  json["volume"] = {{"min", {-.2, -.2, -.2}}, {"max", {.2, .2, .2}}, {"resolution", {8, 8, 8}}};
  json["cameras"][0]["image"] = "p_%04d.png";
  Image light = flame(1);
  for (float& value : light.pixels) value = 0.5F * std::pow(value, 4.0F);
  Image raised = light;
  for (std::size_t i = 0; i < raised.pixels.size(); ++i)
    raised.pixels[i] =
        kBlack + (1 - kBlack) * raised.pixels[i] + 0.002F * static_cast<float>(i % 3);
  ASSERT_TRUE(ok(writeMap(folder / "p_0004.png", raised)));
  ASSERT_VALUE(const auto found, readPicture(0, 4));
  EXPECT_NEAR(found.storedPedestal, kBlack + 0.002, 0.004);
  EXPECT_NEAR(found.radiance.at(0, 0), 0, 0.005);
  EXPECT_NEAR(found.radiance.at(11, 8), light.at(11, 8), 0.005);
  json["black"] = kBlack;
  ASSERT_VALUE(const auto stated, readPicture(0, 4));
  EXPECT_NEAR(stated.radiance.at(11, 8), light.at(11, 8), 0.005);
  EXPECT_LT(stated.storedPedestal, kBlack + 0.004);
  json["black"] = 0.5;  // below it values are negative
  ASSERT_VALUE(const auto below, readPicture(0, 4));
  EXPECT_LT(below.brightest, 0.1);
  json.erase("black");
  // It lies below what is stored, not below the light: a camera that encodes adds it last.
  Image narrow = light;
  for (float& value : narrow.pixels) value = 8 * std::pow(value, 4.0F);
  for (std::size_t i = 0; i < raised.pixels.size(); ++i)
    raised.pixels[i] = kBlack + (1 - kBlack) * static_cast<float>(srgbEncode(narrow.pixels[i]));
  std::filesystem::remove(folder / "p_0004.png");
  ASSERT_TRUE(ok(writeMap(folder / "p_0004.png", raised)));
  json["color"] = "srgb";
  ASSERT_VALUE(const auto encoded, readPicture(0, 4));
  EXPECT_NEAR(encoded.storedPedestal, kBlack, 0.001);
  for (int x = 0; x < kWidth; ++x)
    EXPECT_NEAR(encoded.radiance.at(x, 8), narrow.at(x, 8), 1e-4 + 1e-3 * narrow.at(x, 8)) << x;
  json.erase("color");
  // A background that is not even is none.
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      raised.at(x, y) = light.at(x, y) + 0.01F * static_cast<float>(x);
  std::filesystem::remove(folder / "p_0004.png");
  ASSERT_TRUE(ok(writeMap(folder / "p_0004.png", raised)));
  ASSERT_VALUE(const auto uneven, readPicture(0, 4));
  EXPECT_EQ(uneven.storedPedestal, 0);
}

TEST_F(CaptureImagesTest, MosaicsOfColourCameras) {
  Image image = flame(0.8F);
  write("f_0004_a.exr", image);
  ASSERT_VALUE(const auto smooth, readPicture(0, 4));
  EXPECT_FALSE(smooth.mosaic);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      image.at(x, y) *= (x + y) % 2 == 0 ? (y % 2 == 0 ? 1 : 0.2F) : 0.5F;
  write("f_0004_a.exr", image);
  ASSERT_VALUE(const auto mosaic, readPicture(0, 4));
  EXPECT_TRUE(mosaic.mosaic);
}

TEST_F(CaptureImagesTest, BackgroundsAreSubtractedAndNegativesKept) {
  json["cameras"][0]["background"] = "back.exr";
  write("back.exr", picture(0.75f));
  ASSERT_VALUE(const auto read, readPicture(0, 4));
  EXPECT_FLOAT_EQ(read.radiance.at(12, 8), 3.25f);
  EXPECT_FLOAT_EQ(read.radiance.at(0, 0), -0.75f);
  EXPECT_EQ(read.brightest, 4);
}

TEST_F(CaptureImagesTest, BackgroundsAreTheMedianOfEmptyFrames) {
  json["empty_frames"] = {0, 2};
  for (int frame = 0; frame < 3; ++frame) {
    for (const char* name : {"a", "b", "c"}) {
      Image image = picture(0.5f + 0.125f * static_cast<float>(frame));
      image.at(frame, 0) = 100;  // a spark
      write(fmt::format("f_{:04d}_{}.exr", frame, name), image);
    }
  }
  ASSERT_VALUE(const auto read, readPicture(2, 5));
  EXPECT_FLOAT_EQ(read.radiance.at(9, 9), -0.625f);
  EXPECT_FLOAT_EQ(read.radiance.at(0, 0), -0.75f) << "the spark's frame counts as the brightest";
}

TEST_F(CaptureImagesTest, LitBackgroundsGiveOpticalDepths) {
  json["kind"] = "absorption";
  EXPECT_TRUE(failsWith(readPicture(0, 4), "camera a: its background is missing"));
  for (const char* name : {"a", "b", "c"}) write(fmt::format("back_{}.exr", name), picture(0.8f));
  for (int i = 0; i < 3; ++i)
    json["cameras"][i]["background"] = fmt::format("back_{}.exr", static_cast<char>('a' + i));
  Image seen = picture(0.8f);
  for (int c = 0; c < 3; ++c)
    seen.at(12, 8, c) = 0.8f * std::exp(-0.5f * static_cast<float>(c + 1));
  seen.at(13, 8, 1) = 0;
  write("f_0004_b.exr", seen);
  json["cameras"][1]["gain"] = 2;  // of the depth: of light it cancels out
  ASSERT_VALUE(const auto read, readPicture(1, 4));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(read.radiance.at(12, 8, c), c + 1, 1e-5);
  EXPECT_EQ(read.radiance.at(0, 0), 0);
  EXPECT_NEAR(read.weight[8 * kWidth + 12], std::exp(-1.5), 1e-5);
  EXPECT_EQ(read.weight[0], 1);
  EXPECT_EQ(read.atLeast[8 * kWidth + 13], 2) << "one channel lets no light through";
  EXPECT_EQ(read.weight[8 * kWidth + 13], 0);
  EXPECT_NEAR(read.radiance.at(13, 8, 1), 2 * std::log(500.0), 1e-4) << "a bound";
  EXPECT_NEAR(read.opaqueShare, 1.0 / (kWidth * kHeight), 1e-9);
  EXPECT_EQ(read.litBackgroundSaturated, 0);
  json["cameras"][1]["exposure"] = 4;  // of the background as well
  ASSERT_VALUE(const auto longer, readPicture(1, 4));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(longer.radiance.at(12, 8, c), c + 1, 1e-5);
}

TEST_F(CaptureImagesTest, DarkFieldsAreSubtractedFromPicturesAndBackgrounds) {
  Image dark = picture(0.1F, 1), seen = picture(0.1F + 0.4F, 1), lamp = picture(0.1F + 0.8F, 1);
  dark.at(12, 8) = 0.2F;
  seen.at(12, 8) = 0.2F + 0.2F;
  lamp.at(12, 8) = 0.2F + 0.8F;
  ASSERT_TRUE(ok(writeMap(folder / "dark.png", dark)));
  ASSERT_TRUE(ok(writeMap(folder / "lamp.png", lamp)));
  ASSERT_TRUE(ok(writeMap(folder / "p_0004.png", seen)));
  json["kind"] = "absorption";
  json["color"] = "linear";
  for (int i = 0; i < 3; ++i) json["cameras"][i]["background"] = "back.exr";
  write("back.exr", picture(0.8F));
  json["cameras"][0]["image"] = "p_%04d.png";
  json["cameras"][0]["background"] = "lamp.png";
  json["cameras"][0]["dark"] = "dark.png";
  ASSERT_VALUE(const auto read, readPicture(0, 4));
  EXPECT_NEAR(read.radiance.at(3, 3), std::log(0.8 / 0.4), 1e-3);
  EXPECT_NEAR(read.radiance.at(12, 8), std::log(0.8 / 0.2), 1e-3);
  EXPECT_NEAR(read.weight[0], 0.4 / 0.9, 1e-3) << "of the brightest, (12, 8)";
  // Of light white stays white.
  json["kind"] = "emission";
  json["cameras"][0].erase("background");
  ASSERT_VALUE(const auto light, readPicture(0, 4));
  EXPECT_NEAR(light.radiance.at(12, 8) / light.radiance.at(3, 3), (0.2 / 0.8) / (0.4 / 0.9), 1e-3);
  json["cameras"][0]["dark"] = "back.exr";
  EXPECT_TRUE(failsWith(readPicture(0, 4), "expected pictures of one kind"));
  json["cameras"][0]["dark"] = "none.png";
  EXPECT_FALSE(readPicture(0, 4));
}

TEST_F(CaptureImagesTest, EvenlyLitBackgroundsAreNotTakenAsSaturated) {
  for (const char* name : {"a", "b", "c"}) write(fmt::format("back_{}.exr", name), picture(0.8F));
  for (int i = 0; i < 3; ++i)
    json["cameras"][i]["background"] = fmt::format("back_{}.exr", static_cast<char>('a' + i));
  json["cameras"][0]["image"] = "p_%04d.png";
  const auto writeLit = [&](float level) {
    std::filesystem::remove(folder / "p_0004.png");
    Image image = flame(1);
    for (float& value : image.pixels) value = level * std::min(1.0F, 1.1F - 0.5F * value);
    ASSERT_TRUE(ok(writeMap(folder / "p_0004.png", image)));
  };
  writeLit(231.0F / 255);
  ASSERT_VALUE(const auto light, readPicture(0, 4));
  ASSERT_TRUE(light.plateau);
  EXPECT_TRUE(light.plateau->saturated);
  json["kind"] = "absorption";
  ASSERT_VALUE(const auto lit, readPicture(0, 4));
  ASSERT_TRUE(lit.plateau);
  EXPECT_FALSE(lit.plateau->saturated);
  EXPECT_NEAR(lit.plateau->value, 231.0 / 255, 1e-4);
  EXPECT_EQ(lit.saturatedShare, 0);
  EXPECT_GT(lit.weight[0], 0);
  writeLit(4095.0F / 65535);  // the largest value of 12 bits
  ASSERT_VALUE(const auto few, readPicture(0, 4));
  ASSERT_TRUE(few.plateau);
  EXPECT_TRUE(few.plateau->saturated);
  EXPECT_GT(few.saturatedShare, 0.1);
}

TEST_F(CaptureImagesTest, SaturatedBackgroundsGiveLowerBounds) {
  json["kind"] = "absorption";
  for (int i = 0; i < 3; ++i) json["cameras"][i]["background"] = "back.exr";
  write("back.exr", picture(0.8f));
  Image lamp = picture(0.5F, 1), seen = picture(0.4F, 1);
  lamp.at(12, 8) = lamp.at(13, 8) = 1;
  seen.at(13, 8) = 1;
  ASSERT_TRUE(ok(writeMap(folder / "lamp.png", lamp)));
  ASSERT_TRUE(ok(writeMap(folder / "p_0004.png", seen)));
  json["cameras"][0]["image"] = "p_%04d.png";
  json["cameras"][0]["background"] = "lamp.png";
  const auto expectBound = [&] {
    ASSERT_VALUE(const auto read, readPicture(0, 4));
    EXPECT_NEAR(read.radiance.at(0, 0), std::log(0.5 / 0.4), 1e-4);
    EXPECT_GT(read.weight[0], 0);
    EXPECT_EQ(read.atLeast[8 * kWidth + 12], 7);
    EXPECT_EQ(read.weight[8 * kWidth + 12], 0);
    EXPECT_NEAR(read.radiance.at(12, 8), std::log(1 / 0.4), 1e-4);
    EXPECT_EQ(read.atLeast[8 * kWidth + 13], 0) << "both are saturated";
    EXPECT_NEAR(read.litBackgroundSaturated, 1.0 / (kWidth * kHeight - 1), 1e-6);
  };
  expectBound();
  json["cameras"][0].erase("background");
  json["empty_frames"] = {1, 2, 3};
  for (const int frame : {1, 2, 3})
    ASSERT_TRUE(ok(writeMap(folder / fmt::format("p_{:04d}.png", frame), frame < 3 ? lamp : seen)));
  expectBound();
}

TEST_F(CaptureImagesTest, BackgroundsThatDriftAreFollowed) {
  json["cameras"][0]["background"] = "back.exr";
  json["volume"] = {{"min", {-.2, -.2, -.2}}, {"max", {.2, .2, .2}}, {"resolution", {8, 8, 8}}};
  Image back = picture(0);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        back.at(x, y, c) = 0.3f + 0.02f * static_cast<float>(x) + 0.1f * static_cast<float>(c);
  write("back.exr", back);
  Image now = back;
  for (float& value : now.pixels) value *= 0.93f;
  for (int c = 0; c < 3; ++c) now.at(12, 8, c) += 1.5f;
  write("f_0004_a.exr", now);
  ASSERT_VALUE(const auto read, readPicture(0, 4));
  ASSERT_TRUE(read.drift);
  EXPECT_NEAR(read.drift->gain[1], 0.93, 1e-4);
  EXPECT_NEAR(read.radiance.at(12, 8), 1.5, 1e-4);
  EXPECT_NEAR(read.radiance.at(2, 3), 0, 1e-4);
  write("f_0004_a.exr", back);
  ASSERT_VALUE(const auto still, readPicture(0, 4));
  EXPECT_FALSE(still.drift);
  EXPECT_EQ(still.radiance.at(2, 3), 0);
}

TEST_F(CaptureImagesTest, MasksTakePixelsOut) {
  json["cameras"][1]["mask"] = "mask.png";
  Image mask = picture(1, 1);
  mask.at(12, 8) = 0;
  write("mask.png", mask);
  Image broken = picture(1);
  broken.at(12, 8) = std::nanf("");
  write("f_0004_b.exr", broken);
  ASSERT_VALUE(const auto read, readPicture(1, 4));
  EXPECT_EQ(read.weight[8 * kWidth + 12], 0);
  EXPECT_EQ(read.radiance.at(12, 8), 0);
  EXPECT_NEAR(read.maskedShare, 1.0 / (kWidth * kHeight), 1e-12);
  Image alpha = picture(1, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = kWidth / 2; x < kWidth; ++x) alpha.at(x, y) = 0;
  std::filesystem::remove(folder / "mask.png");
  ASSERT_TRUE(ok(writePngWithAlpha(folder / "mask.png", picture(1), alpha)));
  ASSERT_VALUE(const auto half, readPicture(1, 4));
  EXPECT_EQ(half.maskedShare, 0.5);
  EXPECT_EQ(half.transparentMask, 0.5);
  EXPECT_EQ(half.weight[kWidth / 2], 0);
  EXPECT_EQ(half.weight[3], 1);
  write("mask.png", picture(0, 1));
  EXPECT_TRUE(failsWith(readPicture(1, 4), "camera b, mask"));
}

TEST_F(CaptureImagesTest, PixelsThatAFileDoesNotHoldDoNotCount) {
  FramePixels frame{.color = Image(10, kHeight)};
  std::ranges::fill(frame.color.pixels, 1.0F);
  frame.part = {{0, 0, 10, kHeight}, {0, 0, kWidth, kHeight}};
  ASSERT_TRUE(ok(writeFrame(folder / "f_0004_a.exr", frame)));
  ASSERT_VALUE(const auto found, readPicture(0, 4));
  EXPECT_EQ(found.weight[9], 1);
  EXPECT_EQ(found.weight[10], 0);
  EXPECT_THAT(
      testing::sentences(capture->remarks),
      ::testing::Contains(::testing::HasSubstr("camera a: pictures hold nothing for 58 %")));
}

TEST_F(CaptureImagesTest, PicturesMayBeginWithTheirLowestRow) {
  Image bright = picture(1), mask = picture(1, 1);
  bright.at(3, 2, 0) = 7;
  mask.at(5, 1, 0) = 0;
  write("f_0004_a.exr", bright);
  write("mask.exr", mask);
  json["cameras"][0]["mask"] = "mask.exr";
  json["cameras"][0]["bottom_up"] = true;
  ASSERT_VALUE(const auto read, readPicture(0, 4));
  EXPECT_EQ(read.radiance.at(3, kHeight - 3, 0), 7);
  EXPECT_EQ(read.radiance.at(3, 2, 0), 1);
  EXPECT_EQ(read.weight[(kHeight - 2) * kWidth + 5], 0);
}

TEST_F(CaptureImagesTest, ValuesThatAreNotFiniteAreNamed) {
  for (const float bad : {std::nanf(""), INFINITY, -INFINITY}) {
    Image image = picture(0.5f);
    image.at(7, 3, 1) = bad;
    write("f_0005_c.exr", image);
    EXPECT_TRUE(
        failsWith(readPicture(2, 5), "camera c, frame 5: the value at pixel (7, 3) is not finite"));
  }
}

TEST_F(CaptureImagesTest, WrongSizesAreNamed) {
  write("f_0004_b.exr", Image(kHeight, kWidth));
  EXPECT_TRUE(failsWith(readPicture(1, 4),
                        "camera b, frame 4: the picture has 16 x 24 pixels and "
                        "the calibration says 24 x 16: width and height are "
                        "swapped"));
  write("f_0004_b.exr", Image(kWidth, kHeight + 1));
  EXPECT_TRUE(failsWith(readPicture(1, 4),
                        "the picture has 24 x 17 pixels; the calibration is for "
                        "24 x 16"));
  json["cameras"][0]["background"] = "back.exr";
  write("back.exr", Image(3, 3));
  EXPECT_TRUE(failsWith(readPicture(0, 4), "camera a, background: the picture has 3 x 3"));
}

TEST_F(CaptureImagesTest, MissingViewsAreNamed) {
  std::filesystem::remove(folder / "f_0005_b.exr");
  EXPECT_TRUE(failsWith(readPicture(1, 5), "camera b, frame 5: there is no picture"));
}

TEST_F(CaptureImagesTest, OnePictureForSeveralFramesIsRefused) {
  json["cameras"][1]["image"] = "f_0004_b.exr";
  EXPECT_TRUE(failsWith(readPicture(1, 4), "cameras[1] (b): its picture"));
  EXPECT_TRUE(failsWith(readPicture(1, 4), "has no frame number in its name, and there are 2"));
  CaptureOptions one;
  one.frames = {.begin = 5, .end = 6};
  ASSERT_VALUE(const auto chosen, openCapture(folder / "capture.json", one));
  EXPECT_NE(chosen.remarks.back().sentence.find("is taken for frame 5"), std::string::npos);
  json["frames"] = {4};
  ASSERT_VALUE(const auto read, readPicture(1, 4));
  EXPECT_EQ(capture->remarks.size(), 1U) << "of one frame there is nothing to say";
}

TEST_F(CaptureImagesTest, WhatIsMissingIsToldBeforeAnyPictureIsRead) {
  const auto check = [&]() -> Result<int> {
    testing::writeText(folder / "capture.json", json.dump());
    VOLUTE_ASSIGN(const auto opened, openCapture(folder / "capture.json", {}));
    return checkPicturesThere(opened).map([](const auto&) { return 0; });
  };
  EXPECT_TRUE(ok(check()));
  json["cameras"][2]["mask"] = "none.png";
  EXPECT_TRUE(failsWith(check(), "camera c, mask: there is no picture"));
  EXPECT_TRUE(failsWith(readPicture(2, 4), "camera c, mask: "));
  json["cameras"][2].erase("mask");
  json["cameras"][1]["background"] = "none.exr";
  EXPECT_TRUE(failsWith(check(), "camera b, background: there is no picture"));
  json["cameras"][1].erase("background");
  std::filesystem::remove(folder / "f_0005_b.exr");
  EXPECT_TRUE(failsWith(check(), "camera b, frame 5: there is no picture"));
  EXPECT_TRUE(failsWith(check(), "1 of 6 pictures are missing: of 2 frames b has 1"));
  testing::writeText(folder / "f_0004_c.exr", "");
  EXPECT_TRUE(failsWith(check(), "camera c, frame 4: the picture "));
  EXPECT_TRUE(failsWith(check(),
                        "f_0004_c.exr is empty, 0 bytes; 2 of 6 pictures are missing or "
                        "empty: of 2 frames b has 1, c has 1"));
  json["cameras"][1].erase("image");
  json["cameras"][1]["video"] = "none.mp4";
  EXPECT_TRUE(failsWith(check(), "camera b: "));
  EXPECT_TRUE(failsWith(check(), "none.mp4: cannot open: No such file"));
  EXPECT_TRUE(failsWith(readPicture(1, 4), "camera b, frame 4: "));
}

TEST_F(CaptureImagesTest, PicturesOfAnotherCameraAreRefused) {
  struct : Progress {
    void remark(const Remark& remark) override { remarks.push_back(remark); }

    std::vector<Remark> remarks;
  } heard;

  const auto check = [&](bool force = false) -> Result<int> {
    heard.remarks.clear();
    testing::writeText(folder / "capture.json", json.dump());
    VOLUTE_ASSIGN(const auto opened, openCapture(folder / "capture.json", {}));
    VOLUTE_TRY(checkCapture(opened, {}, force, 1 << 30, heard));
    return 0;
  };
  EXPECT_TRUE(ok(check()));
  json["cameras"][2]["image"] = "f_%04d_a.exr";
  const std::string told =
      "cameras a and c take their pictures from the same files at all frames; expected different "
      "ones, as they look from different places";
  EXPECT_TRUE(failsWith(check(), told));
  EXPECT_TRUE(ok(check(true)));
  EXPECT_EQ(sentences(heard.remarks), std::vector<std::string>{"warning: " + told});
  json["cameras"][2]["image"] = "f_%04d_c.exr";
  const auto copy = [&](const char* frame) {
    std::filesystem::copy_file(folder / fmt::format("f_{}_a.exr", frame),
                               folder / fmt::format("f_{}_c.exr", frame),
                               std::filesystem::copy_options::overwrite_existing);
  };
  copy("0004");
  EXPECT_TRUE(ok(check())) << "of one frame alone: it may show nothing";
  EXPECT_TRUE(heard.remarks.empty());
  copy("0005");
  EXPECT_TRUE(ok(check())) << "opposite cameras see a ball alike";
  EXPECT_EQ(sentences(heard.remarks),
            std::vector<std::string>{"warning: cameras a and c have equal pictures at all frames: "
                                     "is one a copy, or what they see symmetric?"});
  EXPECT_EQ(heard.remarks[0].code, RemarkCode::kDoubtful);
  for (const char* name : {"f_0004_a.exr", "f_0005_a.exr", "f_0004_c.exr", "f_0005_c.exr"})
    write(name, picture(0));
  EXPECT_TRUE(ok(check())) << "where nothing burns all see the same";
  EXPECT_TRUE(heard.remarks.empty());
}

TEST_F(CaptureImagesTest, APictureThatIsMissingIsLeftOut) {
  const Calibration fourth = testing::ringCalibration(3, 4);
  auto camera = json["cameras"][0];
  camera["name"] = "d";
  camera["image"] = "f_%04d_d.exr";
  camera["K"] = testing::toJson(fourth.K);
  camera["R"] = testing::toJson(fourth.R);
  camera["t"] = {fourth.t.x(), fourth.t.y(), fourth.t.z()};
  json["cameras"].push_back(camera);
  const auto check = [&](bool force = false) {
    testing::writeText(folder / "capture.json", json.dump());
    return checkPicturesThere(openCapture(folder / "capture.json", {}).value(), force);
  };
  write("f_0004_d.exr", picture(1));
  ASSERT_VALUE(const auto one, check());
  EXPECT_EQ(one,
            std::vector<std::string>{"camera d: 1 of 2 pictures is missing, of frame 5; there it "
                                     "does not count"});
  std::filesystem::remove(folder / "f_0005_b.exr");
  EXPECT_TRUE(failsWith(check(), "camera b, frame 5: there is no picture"))
      << "two cameras are left";
  ASSERT_VALUE(const auto forced, check(true));
  EXPECT_EQ(forced.size(), 2U);
  write("f_0005_b.exr", picture(1));
  std::filesystem::remove(folder / "f_0004_d.exr");
  EXPECT_TRUE(failsWith(check(), "2 of 8 pictures are missing: of 2 frames d has 0"));
}

TEST_F(CaptureImagesTest, FramesAreFoundByTheClocks) {
  for (const int frame : {4, 5})
    std::filesystem::rename(folder / fmt::format("f_{:04d}_c.exr", frame),
                            folder / fmt::format("f_{:04d}_c.exr", frame + 1000));
  json.erase("frames");
  const auto opened = [&] {
    testing::writeText(folder / "capture.json", json.dump());
    return openCapture(folder / "capture.json", {});
  };
  EXPECT_TRUE(failsWith(opened(),
                        "camera c has pictures of frames 1004 to 1005, of which no other "
                        "camera has any (a: 4 to 5); if its first picture is that of frame "
                        "4, state \"frame_shift\": 1000"));
  json["cameras"][2]["frame_shift"] = 1000;
  ASSERT_VALUE(const auto shifted, opened());
  EXPECT_EQ(shifted.frames, (std::vector<int>{4, 5}));
  json["cameras"][2]["frame_shift"] = 2000;
  json["frames"] = {4, 5};
  EXPECT_TRUE(failsWith(checkPicturesThere(opened().value()),
                        "camera c: has no picture of frames 4 to 5: of the first it would be"));
}

TEST_F(CaptureImagesTest, TransparentPngsAreRefused) {
  // 24 x 16 RGBA, every pixel (255, 128, 0, 127), and the same opaque; from Python's zlib.
  constexpr const char* kTransparentPng =
      "89504e470d0a1a0a0000000d49484452000000180000001008060000000c24bf950000001e4944415478"
      "da63f8dfc0504f4bcc306ac1a805a3168c5a306ac150b00000f600fd1feed142820000000049454e44ae"
      "426082";
  constexpr const char* kOpaquePng =
      "89504e470d0a1a0a0000000d49484452000000180000001008060000000c24bf950000001e4944415478"
      "da63f8dfc0f09f969861d482510b462d18b560d482a1600100f80bbd2e41ec641e0000000049454e44ae"
      "426082";
  const auto bytes = [](const char* hex) {
    std::string text;
    for (; *hex; hex += 2) text += static_cast<char>(std::stoi(std::string(hex, 2), nullptr, 16));
    return text;
  };
  json["cameras"][0]["image"] = "t.png";
  json["frames"] = {4};
  testing::writeBytes(folder / "t.png", bytes(kTransparentPng));
  EXPECT_TRUE(failsWith(readPicture(0, 4), "camera a, frame 4: 100.0 % of the pixels of"));
  testing::writeBytes(folder / "t.png", bytes(kOpaquePng));
  ASSERT_VALUE(const auto read, readPicture(0, 4));
  EXPECT_EQ(read.transparentShare, 0);
}

TEST_F(CaptureImagesTest, FilmsAreReadByFrame) {
  const auto writer = FilmWriter::create(folder / "film.mp4", kWidth, kHeight, 25);
  if (!writer && writer.error().code == ErrorCode::kUnsupported)
    GTEST_SKIP() << writer.error().message;
  ASSERT_TRUE(ok(writer));
  for (int i = 0; i < 6; ++i)
    ASSERT_TRUE(ok((*writer)->addFrame(picture(0.1f * static_cast<float>(i)))));
  ASSERT_TRUE(ok((*writer)->finish()));
  json["color"] = "srgb";
  json["cameras"][0].erase("image");
  json["cameras"][0]["video"] = "film.mp4";
  json["cameras"][0]["video_start"] = 2;
  ASSERT_VALUE(const auto four, readPicture(0, 4));
  EXPECT_NEAR(four.radiance.at(5, 5, 1), 0.2, 0.01);
  EXPECT_TRUE(failsWith(readPicture(0, 1), "camera a, frame 1: the film"));
  const auto check = [&]() -> Result<int> {
    VOLUTE_TRY(checkPicturesThere(*capture));
    return 0;
  };
  EXPECT_TRUE(ok(check()));
  json["cameras"][0]["video_start"] = -1;  // frames -1 to 4
  EXPECT_TRUE(failsWith(readPicture(0, 5), "frame 6 was asked for"));
  EXPECT_TRUE(failsWith(check(), "camera a, frame 5: the film"));
  EXPECT_TRUE(failsWith(check(), "has 6 frames, so that it ends with frame 4"));
  json["cameras"][0]["video_start"] = 5;
  EXPECT_TRUE(failsWith(readPicture(0, 4), "begins with frame 5"));
  EXPECT_TRUE(failsWith(check(), "camera a, frame 4: the film"));
  json["cameras"][0]["video_start"] = 2;
  EXPECT_TRUE(failsWith(readPicture(0, 8), "camera a, frame 8: "));
  EXPECT_TRUE(failsWith(readPicture(0, 8), "the film has 6 frames; frame 6 was asked for"));
}

TEST(FilmFrames, AnyOrder) {
  const testing::TempFolder folder;
  const auto writer = FilmWriter::create(folder / "film.mp4", 16, 16, 25);
  if (!writer && writer.error().code == ErrorCode::kUnsupported)
    GTEST_SKIP() << writer.error().message;
  for (int i = 0; i < 5; ++i) {
    Image image(16, 16);
    std::ranges::fill(image.pixels, 0.2f * static_cast<float>(i));
    ASSERT_TRUE(ok((*writer)->addFrame(image)));
  }
  ASSERT_TRUE(ok((*writer)->finish()));
  ASSERT_VALUE(auto film, FilmFrames::open(folder / "film.mp4"));
  for (const int i : {2, 2, 4, 0, 1, 3}) {
    ASSERT_VALUE(const auto image, film.frame(i));
    EXPECT_NEAR(image.at(8, 8), 0.2 * i, 0.02) << i;
  }
  EXPECT_TRUE(failsWith(film.frame(5), "the film has 5 frames"));
  EXPECT_TRUE(ok(film.frame(1)));
}

TEST(Background, MedianOfAnyCount) {
  const auto value = [](std::size_t i) -> Result<Image> {
    Image image(1, 1, 1);
    image.pixels[0] = std::array{9.0f, 1.0f, 4.0f, 2.0f}[i];
    return image;
  };
  EXPECT_EQ(medianImage(1, 1 << 20, value).value().pixels[0], 9);
  EXPECT_EQ(medianImage(3, 1 << 20, value).value().pixels[0], 4);
  EXPECT_EQ(medianImage(4, 1 << 20, value).value().pixels[0], 3);
  EXPECT_EQ(medianImage(4, 1, value).value().pixels[0], 9) << "room for one";
}

}  // namespace
}  // namespace volute
