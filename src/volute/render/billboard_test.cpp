// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/render/billboard.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "volute/grid/voxel_medium.hpp"
#include "volute/math/rotation.hpp"
#include "volute/medium/affine_medium.hpp"
#include "volute/render/render.hpp"

namespace volute {
namespace {

/// A smooth blob of 2 x 2 x 3 m around the origin.
VoxelMedium blob(double emission, double extinction) {
  VolumeInfo info;
  info.x = info.y = 16, info.z = 24;
  info.channels = 1;
  info.basis = Basis::kTrilinear;
  info.bounds = {Vec3(-1, -1, -1.5), Vec3(1, 1, 1.5)};
  std::vector<float> values(info.frameValues());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = (i % 16 + 0.5) / 8 - 1, y = (i / 16 % 16 + 0.5) / 8 - 1,
                 z = (i / 256 + 0.5) / 12 - 1;
    values[i] = static_cast<float>(std::max(0.0, 1 + 0.3 * x - x * x - y * y - z * z));
  }
  return {std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)), emission, extinction};
}

Image picture(const Camera& camera, std::vector<AnyMedium> media, const Rgb& background) {
  Progress progress;
  RenderOptions options;
  options.background = background;
  return *render(camera, media, options, progress);
}

Billboard drawn(const AnyMedium& volume, const Camera& camera, const BillboardOptions& options) {
  Progress progress;
  return *Billboard::draw(volume, camera, options, progress);
}

TEST(Billboard, ForParallelRaysIsThePictureOfTheVolume) {
  const AnyMedium volume(blob(1.5, 0.8));
  // 48 pixels to 3 m, as the texture's rows: pixel centres are texel centres.
  const Camera camera =
      Camera::orthographic({Vec3(-3, -9, 0), Vec3(0, 0, 0), Vec3::UnitZ()}, 3, 64, 48);
  const Billboard board = drawn(volume, camera,
                                {.position = Vec3::Zero(),
                                 .width = 4,
                                 .height = 3,
                                 .rows = 48,
                                 .shown = {Vec3(-1, -1, -1.5), Vec3(1, 1, 1.5)}});
  const Rgb behind(0.3, 0.2, 0.1);
  const Image direct = picture(camera, {volume}, behind);
  const Image flat = picture(camera, {AnyMedium(board)}, behind);
  double worst = 0, brightest = 0;
  for (std::size_t i = 0; i < direct.pixels.size(); ++i) {
    worst = std::max<double>(worst, std::abs(direct.pixels[i] - flat.pixels[i]));
    brightest = std::max<double>(brightest, direct.pixels[i]);
  }
  EXPECT_GT(brightest, 0.8);
  EXPECT_LT(worst, 2e-6 * brightest);
}

TEST(Billboard, AFlatOneHasNoEndlessRows) {
  const Camera camera =
      Camera::orthographic({Vec3(-3, -9, 0), Vec3(0, 0, 0), Vec3::UnitZ()}, 3, 64, 48);
  const Box3 volume{Vec3(0, 0, 0), Vec3(100, 100, 1)};
  const Camera usual = billboardView(volume, camera, {.width = 8, .height = 1, .rows = 256});
  EXPECT_EQ(usual.width(), 2048);
  EXPECT_EQ(usual.height(), 256);
  const Camera flat = billboardView(volume, camera, {.width = 128, .height = 1, .rows = 256});
  EXPECT_EQ(flat.width(), 4096);
  EXPECT_EQ(flat.height(), 32);
  const Camera line = billboardView(volume, camera, {.width = 1e9, .height = 1, .rows = 256});
  EXPECT_EQ(line.width(), 4096);
  EXPECT_EQ(line.height(), 1);
}

TEST(Billboard, FacesTheEyeWhereverItStands) {
  const AnyMedium volume(blob(1, 0));
  for (const Vec3& eye : {Vec3(30, 0, 1), Vec3(-5, 40, 6), Vec3(1, 2, 50)}) {
    const Vec3 place(3, 4, 2);
    const Camera camera = Camera::pinhole({eye, place, Vec3::UnitZ()}, 10, 21, 21);
    const Billboard board = drawn(volume, camera, {.position = place, .width = 2, .height = 3});
    const Segment ray = camera.ray(10.5, 10.5);
    std::vector<Piece> pieces;
    board.pieces({&ray, 1}, {&pieces, 1});
    ASSERT_EQ(pieces.size(), 1u);
    EXPECT_NEAR(0.5 * (pieces[0].begin + pieces[0].end), (place - eye).norm(), 1e-9);
    // Its middle shows the middle of the volume.
    const Vec3 way = (place - eye).normalized();
    const Segment through{-9 * way, way, 0, 18};
    Radiance expected;
    volume.radiance({&through, 1}, {&expected, 1});
    EXPECT_NEAR(composite(pieces).emitted[0], expected.emitted[0], 1e-3);
  }
}

TEST(Billboard, StandsInOrderAmongMedia) {
  const AnyMedium volume(blob(1, 0));
  const Vec3 eye(0, -20, 0);
  const Camera camera = Camera::pinhole({eye, Vec3::Zero(), Vec3::UnitZ()}, 5, 1, 1);
  const Billboard board =
      drawn(volume, camera, {.position = Vec3::Zero(), .width = 2, .height = 3});
  // A homogeneous block of optical depth 1 before it, then behind it.
  const auto block = [](double y) {
    VolumeInfo info;
    info.x = info.y = info.z = info.channels = 1;
    info.basis = Basis::kBox;
    info.bounds = {Vec3(-5, y, -5), Vec3(5, y + 2, 5)};
    const std::vector<float> one{1};
    return AnyMedium(
        VoxelMedium(std::make_shared<BrickSlice>(BrickSlice::fromDense(info, one)), 0, 0.5));
  };
  const double alone = picture(camera, {AnyMedium(board)}, Rgb::Zero()).at(0, 0, 0);
  const auto with = [&](double y) {
    return picture(camera, {AnyMedium(board), block(y)}, Rgb::Zero()).at(0, 0, 0);
  };
  EXPECT_NEAR(with(-9), alone * std::exp(-1), 1e-5);
  EXPECT_NEAR(with(5), alone, 1e-6);
  EXPECT_NEAR(with(-1), alone * std::exp(-0.5), 1e-4);  // in the middle of it
}

TEST(Billboard, BrightFireHidesWhatIsBehindWhenAlphaIsIntensity) {
  const AnyMedium volume(blob(10, 0));
  const Camera camera = Camera::pinhole({Vec3(0, -20, 0), Vec3::Zero(), Vec3::UnitZ()}, 5, 1, 1);
  const auto seen = [&](BillboardAlpha alpha) {
    const Billboard board =
        drawn(volume, camera, {.position = Vec3::Zero(), .width = 2, .height = 3, .alpha = alpha});
    return picture(camera, {AnyMedium(board)}, Rgb::Constant(100)).at(0, 0, 0);
  };
  EXPECT_GT(seen(BillboardAlpha::kTransmittance), 100);
  EXPECT_LT(seen(BillboardAlpha::kIntensity), 30);
}

TEST(AffineMedium, TurnsVoxelsWithTheirFastPath) {
  const VoxelMedium plain = blob(1.5, 0.8);
  const Mat3 turn = turnAbout(Vec3(1, 2, 3).normalized(), 0.7) * turnAbout(Vec3::UnitX(), 0.4) *
                    Vec3(1, -1, 1).asDiagonal();
  const Vec3 offset(4, -2, 1);
  const AffineMedium turned(AnyMedium(plain), {turn, offset});
  // The camera turned as well sees the same.
  const View3 view{Vec3(3, -6, 2), Vec3(0.1, 0, 0.2), Vec3::UnitZ()};
  const auto moved = [&](const Vec3& p) { return Vec3(turn * p + offset); };
  const Camera here = Camera::pinhole(view, 40, 33, 25);
  for (int y = 0; y < 25; ++y) {
    for (int x = 0; x < 33; ++x) {
      const Segment ray = here.ray(x + 0.5, y + 0.5);
      const Segment there{moved(ray.origin), turn * ray.direction, ray.begin, ray.end};
      Radiance expected, seen;
      plain.radiance({&ray, 1}, {&expected, 1});
      turned.radiance({&there, 1}, {&seen, 1});
      ASSERT_NEAR(seen.emitted[0], expected.emitted[0], 1e-5);
      ASSERT_NEAR(seen.transmittance, expected.transmittance, 1e-5);
    }
  }
}

}  // namespace
}  // namespace volute
