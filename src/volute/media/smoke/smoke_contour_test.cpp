// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include "volute/image/colormap.hpp"
#include "volute/image/srgb.hpp"
#include "volute/media/contour.hpp"
#include "volute/media/smoke/smoke_medium.hpp"
#include "volute/tetmesh/made_meshes.hpp"

namespace volute {
namespace {

/// A box of 8 m whose extinction is 0.05 x [1/m].
SmokeState rampOfSmoke() {
  const auto mesh = boxMesh({Vec3::Zero(), Vec3(8, 8, 8)}, {8, 8, 8}, 0.2, 1);
  SmokeState smoke;
  smoke.locator = std::make_shared<TetLocator>(mesh);
  for (const Vec3& v : mesh->vertices())
    smoke.extinction.push_back(static_cast<float>(0.05 * v.x()));
  return smoke;
}

std::vector<std::shared_ptr<const MediumSnapshot>> shown(const SmokeState& smoke) {
  return {std::make_shared<const SmokeSnapshot>(smoke, 1, std::make_shared<const SmokeLighting>(),
                                                std::nullopt)};
}

Rgb at(const Image& image, int x, int y) {
  return Rgb(image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2));
}

/// From above, a pixel a metre.
Camera above() {
  return Camera::orthographic({Vec3(4, 4, 12), Vec3(4, 4, 0), Vec3::UnitY()}, 8, 8, 8);
}

TEST(SmokeContour, SlicesShowLocalValues) {
  const SmokeState smoke = rampOfSmoke();
  Contour slice = *parseSlice("z=3.3");
  slice.shows = Contour::Shows::kExtinction;
  slice.most = largestOn(slice, shown(smoke));
  EXPECT_NEAR(slice.most, 0.4, 1e-6);
  auto image = lookAtContour(above(), shown(smoke), slice);
  ASSERT_TRUE(image);
  for (int x = 0; x < 8; ++x) {
    const Rgb expected = displayColor(ColorMap::kViridis, (x + 0.5) / 8).unaryExpr(&srgbDecode);
    EXPECT_TRUE(at(*image, x, 3).isApprox(expected, 1e-4)) << x;
  }
  slice.shows = Contour::Shows::kVisibility;
  slice.most = 30;
  image = lookAtContour(above(), shown(smoke), slice);
  ASSERT_TRUE(image);
  for (int x = 0; x < 8; ++x) {
    const double visibility = 3 / (0.05 * (x + 0.5));
    const Rgb expected = displayColor(ColorMap::kViridis, visibility / 30).unaryExpr(&srgbDecode);
    EXPECT_TRUE(at(*image, x, 3).isApprox(expected, 1e-4)) << x;
  }
}

TEST(SmokeContour, SlicesShowConcentrationsInTheUnitOfTheField) {
  SmokeState smoke = rampOfSmoke();
  smoke.extinctionOfUnit = 8.7;  // g/m3 of soot
  Contour slice = *parseSlice("z=3.3");
  slice.shows = Contour::Shows::kConcentration;
  slice.most = largestOn(slice, shown(smoke));
  EXPECT_NEAR(slice.most, 0.4 / 8.7, 1e-6);
  slice.most = 0.1;
  const auto image = lookAtContour(above(), shown(smoke), slice);
  ASSERT_TRUE(image);
  for (int x = 0; x < 8; ++x) {
    const double concentration = 0.05 * (x + 0.5) / 8.7;
    const Rgb expected =
        displayColor(ColorMap::kPlasma, concentration / 0.1).unaryExpr(&srgbDecode);
    EXPECT_TRUE(at(*image, x, 3).isApprox(expected, 1e-4)) << x;
  }
}

TEST(SmokeContour, SurfacesStandWhereTheVisibilityIsTheirs) {
  const SmokeState smoke = rampOfSmoke();
  Contour surface;
  surface.kind = Contour::Kind::kSurface;
  surface.visibility = 10;  // K = 0.3, x = 6
  const Camera along =
      Camera::orthographic({Vec3(7.9, 4, 4), Vec3(0, 4, 4), Vec3::UnitZ()}, 8, 8, 8);
  auto image = lookAtContour(along, shown(smoke), surface);
  ASSERT_TRUE(image);
  EXPECT_NEAR(at(*image, 3, 3)[0], 0.55, 1e-3);  // face on
  surface.visibility = 5;                        // K = 0.6: nowhere
  image = lookAtContour(along, shown(smoke), surface);
  ASSERT_TRUE(image);
  EXPECT_NEAR(at(*image, 3, 3)[0], 0.12, 1e-3);  // the wall
}

TEST(SmokeContour, RefusesWhatIsNoPlane) {
  for (const char* text : {"", "z", "z=", "w=1", "z=1.8m", "z=inf", "1.8"})
    EXPECT_FALSE(parseSlice(text)) << text;
  EXPECT_EQ(parseSlice("y=-2.5")->axis, 1);
  EXPECT_EQ(parseSlice("y=-2.5")->place, -2.5);
}

}  // namespace
}  // namespace volute
