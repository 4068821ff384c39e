// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/exact_surfaces.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

#include "volute/gl/gl_device.hpp"

namespace volute {
namespace {

const View3 kView{Vec3(-3, -4, 2.5), Vec3(0.3, 0.2, 0.1), Vec3::UnitZ()};

void expectTheSameRays(const Camera& camera) {
  for (const auto& [left, top, width, height] :
       {std::array{0, 0, 8, 8}, std::array{13, 40, 24, 8}, std::array{50, 33, 14, 15}}) {
    const auto tile = tileOf(camera, left, top, width, height);
    ASSERT_TRUE(tile);
    EXPECT_EQ(tile->width(), width);
    EXPECT_EQ(tile->height(), height);
    for (const auto& [x, y] : {std::pair{0.5, 0.5}, std::pair{width - 0.5, height - 0.5}}) {
      const Segment part = tile->ray(x, y), whole = camera.ray(left + x, top + y);
      EXPECT_LT((part.origin - whole.origin).norm(), 1e-12);
      EXPECT_LT((part.direction - whole.direction).norm(), 1e-12);
    }
  }
}

TEST(ExactSurfaces, TilesHaveTheRaysOfThePicture) {
  expectTheSameRays(Camera::pinhole(kView, 50, 64, 48));
  expectTheSameRays(Camera::orthographic(kView, 3, 64, 48));
  Calibration lens;
  lens.width = 64, lens.height = 48;
  lens.K = Mat3(60, 0.5, 30, 0, 58, 25, 0, 0, 1);
  const auto calibrated = Camera::calibrated(lens);
  ASSERT_TRUE(calibrated);
  expectTheSameRays(*calibrated);
}

/// A wall over some of the picture, which emits what it does.
SceneSnapshot wall() {
  SceneSnapshot snapshot;
  const Vec3 corners[] = {Vec3(-1, 0, -1), Vec3(1, 0, -1), Vec3(1, 0, 1), Vec3(-1, 0, 1)};
  auto scene = TriangleScene::build(
      {{{corners[0], corners[1], corners[2]}, 0}, {{corners[0], corners[2], corners[3]}, 0}},
      {Material{.emission = Rgb(1, 2, 3)}});
  snapshot.geometry = *scene;
  return snapshot;
}

TEST(ExactSurfaces, AreTheWholePictureInTiles) {
  const auto gl = HeadlessGl::create();
  if (!gl)
    GTEST_SKIP() << gl.error().message;
  auto renderer = GlRenderer::create();
  ASSERT_TRUE(renderer);
  const auto snapshot = std::make_shared<const SceneSnapshot>(wall());
  const Camera camera = Camera::pinhole(kView, 50, 150, 77);
  Progress quiet;
  const auto whole = renderer->surfaces(camera, {snapshot->geometry}, {}, Rgb::Zero(), quiet);
  ASSERT_TRUE(whole);
  ASSERT_GT(whole->surfacePixels, 500);
  ExactSurfaces exact;
  ASSERT_TRUE(exact.begin(snapshot, camera));
  int steps = 0;
  for (; !exact.complete() && steps < 1000; ++steps) ASSERT_TRUE(exact.step(*renderer, 0));
  ASSERT_TRUE(exact.complete());
  EXPECT_GT(steps, 2) << "there are tiles";
  for (std::size_t i = 0; i < whole->depth.size(); ++i) {
    if (std::isfinite(whole->depth[i])) {
      EXPECT_NEAR(exact.texels()[4 * i + 3], whole->depth[i], 1e-5);
    } else {
      EXPECT_EQ(exact.texels()[4 * i + 3], whole->depth[i]);
    }
    EXPECT_EQ(exact.texels()[4 * i + 1], whole->color.pixels[3 * i + 1]);
  }
}

}  // namespace
}  // namespace volute
