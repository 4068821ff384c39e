// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/gl_cases.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bench/gl_case_drawer.hpp"
#include "volute/gl/gl_testing.hpp"

namespace volute::bench {
namespace {

constexpr int kWidth = 48, kHeight = 36;
constexpr double kBar = 5e-4;  // of the brightest

/// The rows of `volute bench gl`, small.
class GlCasesTest : public gltest::GlRendererTest {
 protected:
  static std::size_t named(const std::vector<GlCase>& cases, std::string_view part) {
    return static_cast<std::size_t>(std::ranges::count_if(
        cases, [&](const GlCase& one) { return one.name.find(part) != std::string::npos; }));
  }

  /// The first picture is the CPU's, and a later frame is drawn.
  static void check(const GlCase& one) {
    GlCaseDrawer drawer(*renderer_);
    const auto drawn = drawer.picture(one, kWidth, kHeight);
    ASSERT_TRUE(drawn) << one.name << ": " << drawn.error().message;
    const Image expected = one.byCpu(one.camera(0, kWidth, kHeight), 0);
    ASSERT_EQ(drawn->pixels.size(), expected.pixels.size()) << one.name;
    const float brightest = *std::ranges::max_element(expected.pixels);
    ASSERT_GT(brightest, 0.01F) << one.name;
    double worst = 0;
    for (std::size_t i = 0; i < expected.pixels.size(); ++i)
      worst = std::max<double>(worst, std::fabs(drawn->pixels[i] - expected.pixels[i]));
    EXPECT_LE(worst / brightest, kBar) << one.name;
    EXPECT_TRUE(drawer.frame(one, one.camera(1, kWidth, kHeight), 1)) << one.name;
    EXPECT_FALSE(drawer.takePasses().empty()) << one.name;
  }
};

TEST_F(GlCasesTest, TheHallIsShownWithAndWithoutExitSigns) {
  std::vector<GlCase> cases;
  addHall({.quick = true, .hardware = true}, cases);
  EXPECT_EQ(cases.size(), 16u);  // two ways, four motions
  EXPECT_EQ(named(cases, "exit sign"), 8u);
  for (const GlCase& one : cases) check(one);
  // A sign is seen, and through smoke.
  const Camera camera = cases[0].camera(0, kWidth, kHeight);
  const Image without = cases[0].byCpu(camera, 0), with = cases[4].byCpu(camera, 0);
  const Sign& sign = cases[4].signs.at(0);
  const float brightest = *std::ranges::max_element(sign.picture.pixels);
  float most = 0;
  for (std::size_t i = 0; i < with.pixels.size(); ++i)
    most = std::max(most, with.pixels[i] - without.pixels[i]);
  EXPECT_GT(most, 0.01F * brightest);
  EXPECT_LT(most, 0.99F * brightest);
}

TEST_F(GlCasesTest, WithoutACardFewerMotionsAreShown) {
  std::vector<GlCase> hall, mall;
  addHall({.quick = true, .hardware = false}, hall);
  EXPECT_EQ(named(hall, "exit sign"), 2u);
  BenchInput input;
  input.quick = true;
  ASSERT_TRUE(addMall(input, {.quick = true, .hardware = false}, mall));
  EXPECT_EQ(named(mall, "animated smoke, animated camera"), mall.size());
}

TEST_F(GlCasesTest, TheMallHasFourMotions) {
  std::vector<GlCase> cases;
  BenchInput input;
  input.quick = true;
  ASSERT_TRUE(addMall(input, {.quick = true, .hardware = true}, cases));
  for (const char* motion : {"steady smoke, fixed camera", "animated smoke, fixed camera",
                             "steady smoke, animated camera", "animated smoke, animated camera"})
    EXPECT_EQ(named(cases, motion), cases.size() / 4) << motion;
  for (const GlCase& one : cases) check(one);
}

TEST_F(GlCasesTest, FogIsWalkedBeforeAndAfterTurningBackIntoSplines) {
  std::vector<GlCase> cases;
  ASSERT_TRUE(addFogTables(true, cases));
  EXPECT_EQ(named(cases, "(before"), 1u);
  EXPECT_EQ(named(cases, "(after"), 1u);
  EXPECT_EQ(named(cases, "(levels merged)"), 1u);
  std::vector<Image> table3;
  for (const GlCase& one : cases) {
    check(one);
    if (one.name.find("table 3") != std::string::npos)
      table3.push_back(one.byCpu(one.camera(0, kWidth, kHeight), 0));
  }
  // All three are the same fog.
  ASSERT_EQ(table3.size(), 3u);
  for (std::size_t i = 0; i < table3[0].pixels.size(); ++i) {
    EXPECT_NEAR(table3[1].pixels[i], table3[0].pixels[i], 1e-5);
    EXPECT_NEAR(table3[2].pixels[i], table3[0].pixels[i], 1e-5);
  }
}

/// Degree 2 has a wavelet of its own, which the quick tables do not need.
TEST_F(GlCasesTest, QuadraticFogIsWalkedInFourBases) {
  SplineGrid map(9, 11);
  for (std::size_t i = 0; i < map.c.size(); ++i) map.c[i] = 0.02 * static_cast<double>(i * i % 7);
  for (const int degree : {0, 2}) {
    for (const bool deconstructed : {false, true}) {
      const PaperPicture picture{std::make_shared<const PaperFog>(map, degree, 2), 3, 0, 12,
                                 deconstructed};
      auto drawn = GlPaperFog::make(picture);
      ASSERT_TRUE(drawn) << drawn.error().message;
      const Camera camera = Camera::pinhole({Vec3(4, 3, 6), Vec3(20, 21, 5)}, 70, kWidth, kHeight);
      GlPasses passes;
      const Image image = drawn->render(camera, passes);
      const Image expected = byCpu(picture, camera);
      for (std::size_t i = 0; i < expected.pixels.size(); ++i)
        EXPECT_NEAR(image.pixels[i], expected.pixels[i], 2e-5) << degree << deconstructed;
    }
  }
  const PaperPicture cubic{std::make_shared<const PaperFog>(map, 3, 1), 3, 0, 12, false};
  EXPECT_EQ(GlPaperFog::make(cubic).error().code, ErrorCode::kUnsupported);
}

TEST_F(GlCasesTest, TreesAreShownWithAndWithoutBoundingBoxes) {
  std::vector<GlCase> cases;
  BenchInput input;
  input.quick = true;
  ASSERT_TRUE(addTrees(input, quiet_, cases));
  EXPECT_EQ(named(cases, "without bounding boxes"), 2u);  // fire and smoke
  EXPECT_EQ(named(cases, "with bounding boxes"), 2u);
  for (const GlCase& one : cases) check(one);
}

}  // namespace
}  // namespace volute::bench
