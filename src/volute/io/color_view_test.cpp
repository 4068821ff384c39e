// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/color_view.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>

#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;

std::array<float, 3> shown(const ViewTransform& view, float red, float green, float blue) {
  std::array<float, 3> pixel{red, green, blue};
  view.apply(pixel);
  return pixel;
}

TEST(ColorView, AcesKeepsGreyGreyAndBrightBelowWhite) {
  if (!VOLUTE_HAS_OCIO)
    GTEST_SKIP() << "this build has no OpenColorIO";
  ASSERT_VALUE(const auto view, openColorView("aces"));
  EXPECT_EQ(view->name(), "sRGB/ACES 1.0");
  EXPECT_NEAR(shown(*view, 0, 0, 0)[0], 0, 1e-3);
  // A grey card is at a tenth of white.
  const auto grey = shown(*view, 0.18F, 0.18F, 0.18F);
  EXPECT_NEAR(grey[0], 0.349, 0.01);
  EXPECT_NEAR(grey[1], grey[0], 2e-3);
  EXPECT_NEAR(grey[2], grey[0], 2e-3);
  float last = 0;
  for (float light = 0.01F; light < 16; light *= 2) {
    const float now = shown(*view, light, light, light)[1];
    EXPECT_GT(now, last);
    EXPECT_LE(now, 1);
    last = now;
  }
  const auto red = shown(*view, 0.5F, 0.02F, 0.02F);
  EXPECT_GT(red[0], 2 * red[1]);
}

TEST(ColorView, ViewsOfAConfiguration) {
  if (!VOLUTE_HAS_OCIO)
    GTEST_SKIP() << "this build has no OpenColorIO";
  const TempFolder folder;
  const auto open = [&](const std::string& name) {
    const auto view = openColorView(name);
    return view ? (*view)->name() : view.error().message;
  };
  ::unsetenv("OCIO");
  EXPECT_THAT(open("ocio"), HasSubstr("names no configuration"));
  ::setenv("OCIO", (folder / "config.ocio").c_str(), 1);
  EXPECT_THAT(open("ocio"), HasSubstr("OpenColorIO: "));
  const std::string config = R"(ocio_profile_version: 2
roles:
  scene_linear: lin
  default: lin
displays:
  Screen:
    - !<View> {name: Half, colorspace: half}
    - !<View> {name: Plain, colorspace: lin}
  Print:
    - !<View> {name: Plain, colorspace: lin}
colorspaces:
  - !<ColorSpace>
    name: lin
  - !<ColorSpace>
    name: half
    from_scene_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}
)";
  writeBytes(folder / "config.ocio", config);
  EXPECT_THAT(open("ocio"), HasSubstr("neither the role aces_interchange nor"));
  std::string known = config;
  for (std::size_t at = 0; (at = known.find("lin\n", at)) != known.npos;)
    known.replace(at, 4, "lin_rec709\n"), at += 11;
  for (std::size_t at = 0; (at = known.find("lin}", at)) != known.npos;)
    known.replace(at, 4, "lin_rec709}"), at += 11;
  writeBytes(folder / "known.ocio", known);
  ::setenv("OCIO", (folder / "known.ocio").c_str(), 1);
  EXPECT_EQ(open("ocio"), "Screen/Half");
  EXPECT_EQ(open("ocio:Plain"), "Screen/Plain");
  EXPECT_EQ(open("ocio:Print/Plain"), "Print/Plain");
  EXPECT_THAT(open("ocio:Film"), HasSubstr("has no view 'Film' of 'Screen'; it has Screen/Half"));
  ASSERT_VALUE(const auto half, openColorView("ocio:Half"));
  EXPECT_NEAR(shown(*half, 0.5F, 0.25F, 1)[1], 0.125, 1e-6);
  ::unsetenv("OCIO");
}

TEST(ColorView, Names) {
  EXPECT_TRUE(namesColorView("aces") && namesColorView("ocio") && namesColorView("ocio:a/b"));
  EXPECT_FALSE(namesColorView("filmic") || namesColorView("ocioa") || namesColorView(""));
}

}  // namespace
}  // namespace volute
