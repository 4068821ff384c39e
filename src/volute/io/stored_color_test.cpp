// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/stored_color.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "volute/image/srgb.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;

std::string word(std::uint32_t value) {
  return {static_cast<char>(value >> 24), static_cast<char>(value >> 16),
          static_cast<char>(value >> 8), static_cast<char>(value)};
}

std::string half(unsigned value) {
  return word(value).substr(2);
}

std::string fixed(double value) {
  return word(static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(value * 65536))));
}

std::uint32_t pngChecksum(std::string_view bytes) {
  std::uint32_t sum = 0xFFFFFFFF;
  for (const char c : bytes) {
    sum ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) sum = sum & 1 ? 0xEDB88320 ^ (sum >> 1) : sum >> 1;
  }
  return ~sum;
}

std::string pngChunk(const std::string& name, const std::string& content) {
  return word(static_cast<std::uint32_t>(content.size())) + name + content +
         word(pngChecksum(name + content));
}

/// A .png with `chunks` instead of what it states of its colors.
std::string withColor(std::string png, const std::string& chunks) {
  for (const auto& [name, size] : {std::pair("sRGB", 1), std::pair("gAMA", 4)}) {
    if (const auto at = png.find(name); at != std::string::npos)
      png.erase(at - 4, static_cast<std::size_t>(12 + size));
  }
  constexpr std::size_t kHeader = 8 + 12 + 13;
  return png.insert(kHeader, chunks);
}

/// Bytes that zlib takes for packed ones.
std::string zlibStored(const std::string& bytes) {
  std::uint32_t a = 1, b = 0;
  for (const char c : bytes) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  const auto n = static_cast<unsigned>(bytes.size());
  const auto little = [](unsigned v) {
    return std::string{static_cast<char>(v), static_cast<char>(v >> 8)};
  };
  return std::string("\x78\x01\x01", 3) + little(n) + little(~n) + bytes + word(b << 16 | a);
}

std::string curvOfGamma(double gamma) {
  return "curv" + word(0) + word(1) + half(static_cast<unsigned>(std::lround(gamma * 256))) +
         half(0);
}

std::string xyzOf(double x, double y, double z) {
  return "XYZ " + word(0) + fixed(x) + fixed(y) + fixed(z);
}

/// A profile with these tags.
std::string profileOf(const std::vector<std::pair<std::string, std::string>>& tags,
                      const std::string& space = "RGB ") {
  std::string list = word(static_cast<std::uint32_t>(tags.size())), data;
  const std::size_t begin = 128 + 4 + 12 * tags.size();
  for (const auto& [name, content] : tags) {
    list += name + word(static_cast<std::uint32_t>(begin + data.size())) +
            word(static_cast<std::uint32_t>(content.size()));
    data += content;
  }
  std::string header(128, '\0');
  header.replace(0, 4, word(static_cast<std::uint32_t>(begin + data.size())));
  header.replace(8, 4, word(0x02100000));
  header.replace(12, 12, "mntr" + space + "XYZ ");
  header.replace(36, 4, "acsp");
  header.replace(68, 12, fixed(0.9642) + fixed(1) + fixed(0.8249));
  return header + list + data;
}

std::string srgbPrimariesWith(const std::string& curve) {
  return profileOf({{"rTRC", curve},
                    {"gTRC", curve},
                    {"bTRC", curve},
                    {"rXYZ", xyzOf(0.4360, 0.2225, 0.0139)},
                    {"gXYZ", xyzOf(0.3851, 0.7169, 0.0971)},
                    {"bXYZ", xyzOf(0.1431, 0.0606, 0.7141)}});
}

std::string iccChunk(const std::string& profile) {
  return pngChunk("iCCP", std::string("p\0\0", 3) + zlibStored(profile));
}

class PngColor : public ::testing::Test {
 protected:
  /// The light of the middle value of a grey or colored picture of 16 bits with these chunks.
  float lightWith(const std::string& chunks, int channels = 1) {
    Image map(1, 1, channels);
    std::fill(map.pixels.begin(), map.pixels.end(), 0.5F);
    EXPECT_TRUE(ok(writeMap(folder_ / "a.png", map)));
    writeBytes(folder_ / "a.png", withColor(readBytes(folder_ / "a.png"), chunks));
    const auto read = readImage(folder_ / "a.png");
    error_ = read ? "" : read.error().message;
    return read ? read->pixels[0] : -1;
  }

  TempFolder folder_;
  std::string error_;
};

const std::string kGammaOf1 = pngChunk("gAMA", word(100000));

TEST_F(PngColor, GammaThatItStatesIsUsed) {
  const double srgb = srgbDecode(0.5);
  EXPECT_NEAR(lightWith(""), srgb, 1e-4);
  EXPECT_NEAR(lightWith(kGammaOf1), 0.5, 1e-4);
  EXPECT_NEAR(lightWith(pngChunk("gAMA", word(55556))), std::pow(0.5, 1.8), 1e-4);
  EXPECT_NEAR(lightWith(pngChunk("gAMA", word(45455))), srgb, 1e-4) << "sRGB, in short";
  EXPECT_NEAR(lightWith(pngChunk("sRGB", std::string(1, '\0')) + kGammaOf1), srgb, 1e-4);
}

TEST_F(PngColor, WhatIsWrittenLinearIsReadLinear) {
  Image map(2, 1, 1);
  map.pixels = {0.25F, 0.75F};
  ASSERT_TRUE(ok(writeMap(folder_ / "a.png", map)));
  ASSERT_VALUE(const auto read, readImage(folder_ / "a.png"));
  EXPECT_NEAR(read.pixels[0], 0.25, 1e-4);
  EXPECT_NEAR(read.pixels[1], 0.75, 1e-4);
}

TEST_F(PngColor, ProfilesAreUsed) {
  EXPECT_NEAR(lightWith(iccChunk(srgbPrimariesWith(curvOfGamma(1))), 3), 0.5, 1e-3) << error_;
  EXPECT_NEAR(lightWith(iccChunk(srgbPrimariesWith(curvOfGamma(1.8))), 3), std::pow(0.5, 1.796875),
              1e-3)
      << error_;
  const std::string srgbCurve = "para" + word(0) + half(3) + half(0) + fixed(2.4) +
                                fixed(1 / 1.055) + fixed(0.055 / 1.055) + fixed(1 / 12.92) +
                                fixed(0.04045);
  EXPECT_NEAR(lightWith(iccChunk(srgbPrimariesWith(srgbCurve)), 3), srgbDecode(0.5), 1e-3);
  EXPECT_NEAR(lightWith(iccChunk(profileOf({{"kTRC", curvOfGamma(1)}}, "GRAY"))), 0.5, 1e-3);
}

TEST_F(PngColor, OthersAreRefusedOrConverted) {
  lightWith(iccChunk(profileOf({{"A2B0", "mft2"}})), 3);
  EXPECT_THAT(error_, HasSubstr("no curve for each channel; expected a picture in sRGB"));
  lightWith(pngChunk("cICP", std::string("\x09\x10\x00\x01", 4)), 3);
  EXPECT_THAT(error_, HasSubstr("states transfer function 16"));
  EXPECT_NEAR(lightWith(pngChunk("cICP", std::string("\x01\x08\x00\x01", 4)), 3), 0.5, 1e-3);
  // Full red of Display P3 is beyond sRGB's.
  const auto p3 =
      srgbFromPrimaries(std::array{0.3127, 0.3290, 0.680, 0.320, 0.265, 0.690, 0.150, 0.060});
  ASSERT_TRUE(p3 && *p3);
  EXPECT_NEAR((**p3)(0, 0), 1.2249, 2e-3);
  EXPECT_NEAR((**p3)(1, 0), -0.0420, 2e-3);
  EXPECT_LT((**p3 * Vec3(1, 1, 1) - Vec3(1, 1, 1)).norm(), 2e-3) << "white stays white";
}

TEST_F(PngColor, CurveOfAPictureIsToldToCaptures) {
  lightWith("");
  EXPECT_EQ(readStoredCurve(folder_ / "a.png").value(), std::nullopt);
  lightWith(kGammaOf1);
  ASSERT_VALUE(const auto curve, readStoredCurve(folder_ / "a.png"));
  ASSERT_TRUE(curve);
  EXPECT_NEAR((*curve)[curve->size() / 2], 0.5, 1e-9);
}

}  // namespace
}  // namespace volute
