// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_flame.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <tuple>

#include "volute/fds/fds_case_testing.hpp"
#include "volute/medium/conformance.hpp"
#include "volute/optics/black_body.hpp"

namespace volute {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const FdsOptions kHeat{.quantity = std::string(kFdsHeatRelease)};

/// A case with the heat release as a 3D slice of nodes.
FdsField heatOf(const ScratchFolder& folder, const fdswriter::Function& heat, Indices solid) {
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {solid}, {}});
  const fdswriter::Slice slice{whole(kFirst), "HRRPUV", "hrrpuv", "kW/m3"};
  fdswriter::sliceFile(slice, {{0, fdswriter::atNodes(kFirst, slice.at, heat)}})
      .save(folder / "made.sf");
  index.slice(1, slice, "made.sf", false);
  index.save(folder / "made.smv");
  FdsCase read = opened(folder / "made.smv", kHeat);
  EXPECT_EQ(read.source().name, "slice3d-hrrpuv");
  return fieldAt(read, 0);
}

conformance::MediumUnderTest underTest() {
  const ScratchFolder folder;
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(0, 900);
  const FdsFlame flame(
      heatOf(folder, [&](double, double, double) { return uniform(random); }, {1, 3, 1, 2, 0, 2}),
      {});
  conformance::Traits traits{.planes = kFirst};
  // The adaptive Simpson of the suite steps over corners of cells, where solids end.
  traits.tolerance.quadrature = 5e-3;
  return conformance::underTest(flame, traits);
}

VOLUTE_CONFORMANCE(FdsFlames, underTest());

conformance::MediumUnderTest glowingUnderTest() {
  const ScratchFolder folder;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(600, 1700);
  const FdsFlame flame = FdsFlame::glowing(
      heatOf(folder, [&](double, double, double) { return uniform(random); }, {1, 3, 1, 2, 0, 2}),
      {}, 1800);
  conformance::Traits traits{.planes = kFirst};
  traits.tolerance.quadrature = 5e-3;
  return conformance::underTest(flame, traits);
}

VOLUTE_CONFORMANCE(FdsGlowingFlames, glowingUnderTest());

TEST(FdsFlame, TemperaturesShineAsBlackBodies) {
  const ScratchFolder folder;
  // 400 degrees below x = 0.5 are dark, 1400 above shine.
  const FdsField celsius =
      heatOf(folder, [](double x, double, double) { return x < 0.5 ? 400.0 : 1400.0; },
             {0, 0, 0, 0, 0, 0});
  const FdsFlame flame = FdsFlame::glowing(celsius, {.emission = 3}, 2000);
  ASSERT_TRUE(flame.burns());
  EXPECT_NEAR(flame.bounds().min.x(), 0.4, 1e-12);
  const Segment line = between({0, 0.4, 0.3}, {1, 0.4, 0.3});
  Radiance seen;
  flame.radiance({&line, 1}, {&seen, 1});
  const double kelvin = 1400 + 273.15;
  const auto colour = blackBodyColour(kelvin);
  // Half of the cell between, and 0.4 m in full.
  const double expected = 3 * 0.5 * blackBodyLuminance(kelvin, 2000);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(seen.emitted[c], expected * colour[static_cast<std::size_t>(c)], 1e-3 * expected);
  }
  EXPECT_EQ(seen.transmittance, 1);
  const ScratchFolder cold;
  EXPECT_FALSE(
      FdsFlame::glowing(heatOf(cold, [](auto...) { return 300.0; }, {0, 0, 0, 0, 0, 0}), {}, 1500)
          .burns());
}

TEST(FdsFlame, ReachesAsFarAsItsCells) {
  const ScratchFolder folder;
  const auto heat = [](double x, double y, double z) {
    return x == 0.6 && y == 0.4 && z == 0 ? 500.0 : 10.0;
  };
  const FdsFlame flame(heatOf(folder, heat, {0, 0, 0, 0, 0, 0}), {});
  EXPECT_TRUE(flame.burns());
  EXPECT_NEAR((flame.bounds().min - Vec3(0.4, 0.2, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((flame.bounds().max - Vec3(0.8, 0.6, 0.3)).norm(), 0, 1e-12);
  const ScratchFolder cold;
  EXPECT_FALSE(
      FdsFlame(heatOf(cold, [](auto...) { return 10.0; }, {0, 0, 0, 0, 0, 0}), {}).burns());
}

TEST(FdsFlame, ShinesAsItReleasesHeatAboveItsCutoff) {
  const ScratchFolder folder;
  // 100 kW/m3 below x = 0.5, 700 above: at nodes 0, 0.2, 0.4 and 0.6, 0.8, 1.
  const FdsField heat = heatOf(
      folder, [](double x, double, double) { return x < 0.5 ? 100.0 : 700.0; }, {0, 0, 0, 0, 0, 0});
  const Segment line = between({0, 0.4, 0.3}, {1, 0.4, 0.3});
  for (const auto& [cutoff, megawatts] : {std::pair{200.0, 0.1 * 0.7 + 0.4 * 0.7},
                                          {0.0, 0.4 * 0.1 + 0.2 * 0.4 + 0.4 * 0.7},
                                          {800.0, 0.0}}) {
    const FdsFlame flame(heat, {.temperature = 2000, .emission = 3, .cutoff = cutoff});
    Radiance seen;
    flame.radiance({&line, 1}, {&seen, 1});
    const auto colour = blackBodyColour(2000);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(seen.emitted[c], 3 * megawatts * colour[static_cast<std::size_t>(c)], 1e-6);
    EXPECT_EQ(seen.transmittance, 1);
  }
}

TEST(FdsFlame, ItsLuminanceIsThatOfLinesThroughItAndItsSmoke) {
  const ScratchFolder folder;
  const FdsField heat =
      heatOf(folder, [](double, double, double) { return 700.0; }, {0, 0, 0, 0, 0, 0});
  const FdsFlame flame(heat, {.emission = 3});
  const double per = 3 * 0.7;  // luminance a metre; 1, 0.8 and 0.6 m along x, y and z
  EXPECT_NEAR(flame.luminance(heat, 0), per * 1.0, 1e-3 * per) << "the upper quartile is along x";
  const double depth = 700 * 0.01;
  EXPECT_NEAR(flame.luminance(heat, 0.01), per * (1 - std::exp(-depth)) / depth, 1e-3 * per)
      << "smoke of 7 1/m";
  const FdsFlame none(heat, {.cutoff = 800});
  EXPECT_EQ(none.luminance(heat, 0), 0);
}

/// Bytes as FDS writes them, one mesh of even heat with a byte of 254 at one node.
void saveBytes(const ScratchFolder& folder, double heat, double most, const std::string& sizes) {
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {}, {}});
  const auto byte = static_cast<std::uint8_t>(254 * heat / most);
  const std::size_t nodes = kFirst[0].size() * kFirst[1].size() * kFirst[2].size();
  fdswriter::smokeFile(cellsOf(kFirst), {{0, std::vector<std::uint8_t>(nodes, 0)},
                                         {5, std::vector<std::uint8_t>(nodes, byte)}})
      .save(folder / "made.s3d");
  fdswriter::saveText(folder / "made.s3d.sz", sizes);
  index.files += "SMOKF3D 1\n made.s3d\n HRRPUV\n hrrpuv\n kW/m3\n";
  index.save(folder / "made.smv");
}

TEST(FdsFlame, BytesHaveTheScaleThatTheirSizesSay) {
  for (const double most : {1200.0, 5000.0}) {
    const ScratchFolder folder;
    saveBytes(folder, 267.8, most, "0\n 0 1 1 0.0\n 5 1 1 267.8\n");
    FdsCase read = opened(folder / "made.smv", kHeat);
    EXPECT_EQ(read.source().name, "s3d-hrrpuv");
    const double byte = most / 254;
    // In the middle, where no wall dilutes: within a byte, or what one byte's scale leaves open.
    EXPECT_NEAR(fieldAt(read, 5).extinction({0.5, 0.4, 0.4}), 267.8, 0.6 * byte) << most;
    if (most == 1200) {
      EXPECT_THAT(sentences(read.remarks()), IsEmpty());
    } else {
      EXPECT_THAT(sentences(read.remarks()), Contains(HasSubstr("stands for")));
    }
  }
}

TEST(FdsFlame, TheIndexSaysWhatTheLastByteIs) {
  const ScratchFolder folder;
  saveBytes(folder, 267.8, 5000, "0\n 0 1 1 0.0\n 5 1 1 267.8\n");
  std::ifstream in(folder / "made.smv");
  const std::string text(std::istreambuf_iterator<char>(in), {});
  fdswriter::saveText(folder / "made.smv", "HRRPUV_MINMAX\n   0.00000   5000.00000\n\n" + text);
  FdsCase read = opened(folder / "made.smv", kHeat);
  EXPECT_NEAR(fieldAt(read, 5).extinction({0.5, 0.4, 0.4}), 267.8, 0.6 * 5000 / 254);
  EXPECT_THAT(sentences(read.remarks()), IsEmpty()) << "nothing is guessed";
  fdswriter::saveText(folder / "made.smv", "HRRPUV_MINMAX\n   5.0   -1.0\n\n" + text);
  EXPECT_FALSE(SmvIndex::read(folder / "made.smv"));
}

/// Bytes of 20 to 2000 degrees C unless `range` says otherwise: the first frame all byte 0, the
/// second all `byte`.
void saveTemperature(const ScratchFolder& folder, std::uint8_t byte, const std::string& range,
                     const std::string& sizes) {
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {}, {}});
  const std::size_t nodes = kFirst[0].size() * kFirst[1].size() * kFirst[2].size();
  fdswriter::smokeFile(cellsOf(kFirst), {{0, std::vector<std::uint8_t>(nodes, 0)},
                                         {5, std::vector<std::uint8_t>(nodes, byte)}})
      .save(folder / "made.s3d");
  fdswriter::saveText(folder / "made.s3d.sz", sizes);
  // A mass extinction that is not one: smoke it is not.
  index.files += "SMOKF3D 1 8700.\n made.s3d\n EFFECTIVE FLAME TEMPERATURE\n temp\n C\n";
  fdswriter::saveText(folder / "made.smv", range + index.text());
}

const FdsOptions kGlow{.quantity = std::string(kFdsFlameTemperature)};

TEST(FdsFlame, BytesOfTemperatureReachAsTheIndexSays) {
  for (const auto& [range, least, most] :
       {std::tuple{std::string("TEMP_MINMAX\n   20.0   2000.0\n\n"), 20.0, 2000.0},
        std::tuple{std::string("TEMP_MINMAX\n 100 1100\n"), 100.0, 1100.0}}) {
    const ScratchFolder folder;
    saveTemperature(folder, 127, range, "0\n 0 1 1 20.0\n 5 1 1 1010\n");
    FdsCase read = opened(folder / "made.smv", kGlow);
    EXPECT_EQ(read.source().name, "s3d-effective-flame-temperature");
    EXPECT_THAT(sentences(read.remarks()), IsEmpty());
    EXPECT_EQ(read.largestSaid(), 1010);
    const double step = (most - least) / 254;
    // At a wall too: what FDS counts behind it is not known, and nothing is put on it.
    for (const Vec3& point : {Vec3(0.5, 0.4, 0.4), Vec3(0.01, 0.4, 0.01)}) {
      EXPECT_NEAR(fieldAt(read, 5).extinction(point), least + 127.5 * step, 0.6 * step);
      EXPECT_NEAR(fieldAt(read, 0).extinction(point), least, 1e-3);
    }
    EXPECT_TRUE(findSources(read.index()).empty()) << "no smoke";
  }
}

TEST(FdsFlame, WithoutARangeBytesOfTemperatureHaveTheDefaults) {
  const ScratchFolder folder;
  saveTemperature(folder, 127, "", "0\n 0 1 1 20.0\n 5 1 1 1010\n");
  FdsCase read = opened(folder / "made.smv", kGlow);
  EXPECT_THAT(sentences(read.remarks()), Contains(HasSubstr("no TEMP_MINMAX")));
  EXPECT_NEAR(fieldAt(read, 5).extinction({0.5, 0.4, 0.4}), 20 + 127.5 * 1980 / 254, 5);
  fdswriter::saveText(folder / "made.s3d.sz", "0\n 0 1 1 20.0\n 5 1 1 2500\n");
  EXPECT_FALSE(FdsCase::open(folder / "made.smv", kGlow)) << "the bytes reach further";
  for (const char* range : {"2000 20", "20 20", "-300 20", "20 nan", "nan 20", "20 inf", "20"}) {
    saveTemperature(folder, 127, std::string("TEMP_MINMAX\n ") + range + "\n", "0\n");
    EXPECT_FALSE(SmvIndex::read(folder / "made.smv")) << range;
  }
}

TEST(FdsFlame, BytesThatContradictTheirSizesAreRefused) {
  const ScratchFolder folder;
  saveBytes(folder, 267.8, 1200, "0\n 0 1 1 0.0\n 5 1 1 267.8\n 5 1 1 900\n");
  const auto read = FdsCase::open(folder / "made.smv", kHeat);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kInvalidData);
}

TEST(FdsFlame, ACaseWithoutHeatSaysSo) {
  MadeCase made;
  made.index.save(made.folder / "made.smv");
  const auto read = FdsCase::open(made.folder / "made.smv", kHeat);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(read.error().message, HasSubstr("no file of the case has 'HRRPUV'"));
}

}  // namespace
}  // namespace volute
