// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/tet_projector.hpp"

#include "volute/gl/gl_testing.hpp"
#include "volute/tetmesh/tet_reference.hpp"

namespace volute {

using namespace gltest;

namespace {

struct Error {
  double worst = 0, mean = 0,
         bias = 0;  ///< as shares of the brightest, and of 1 for the transmittance
};

class TetProjectorTest : public GlRendererTest {
 protected:
  static TetProjector projectorOf(const Smoke& smoke) {
    auto projector =
        TetProjector::create(std::shared_ptr<const TetMesh>(smoke.locator, &smoke.locator->mesh()));
    EXPECT_TRUE(projector) << projector.error().message;
    projector->setSmoke(smoke.extinction, smoke.source);
    return std::move(*projector);
  }

  Error compare(TetProjector& projector, const Smoke& smoke, const Camera& camera,
                const TetProjectorOptions& options = {}, std::span<const float> opaque = {}) {
    EXPECT_TRUE(projector.draw(camera, opaque, options, passes_));
    const auto found = projector.read();
    std::vector<double> expected(found.size());
    const TetMedium medium(smoke.locator, smoke.extinction, smoke.source);
    referenceColor(medium, camera, opaque, expected);
    double brightest = 0;
    for (std::size_t i = 0; i < expected.size(); ++i)
      brightest = std::max(brightest, i % 4 == 3 ? 0 : expected[i]);
    Error error;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const double scale = i % 4 == 3 || brightest == 0 ? 1 : brightest;
      const double here = std::abs(found[i] - expected[i]) / scale;
      error.worst = !(here <= error.worst) ? here : error.worst;
      error.mean += here / static_cast<double>(expected.size());
      if (i % 4 == 0)
        error.bias += (found[i] - expected[i]) / scale / static_cast<double>(expected.size() / 4);
    }
    return error;
  }

  GlPasses passes_;
};

constexpr double kProjected = 1e-4;  // the contract says 2e-3; most of it is the table of weights

TEST_F(TetProjectorTest, FloatTargetsMeetTheReference) {
  const auto box = boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {6, 5, 4}, 0.3, 5);
  for (const double thick : {0.8, 25.0}) {
    const Smoke smoke(box, true, thick);
    TetProjector projector = projectorOf(smoke);
    for (const Camera& camera : cameras(smoke.medium().bounds())) {
      if (!camera.distortion().none())
        continue;
      for (const TetBlend blend : {TetBlend::kBackToFront, TetBlend::kFrontToBack}) {
        const Error error = compare(projector, smoke, camera, {.blend = blend});
        EXPECT_LE(error.worst, kProjected) << "thick " << thick << ", eye " << camera.eye();
      }
    }
  }
}

/// Cells that let little pass, so that one too many or too few is seen: at many sizes, for how a
/// pixel's centre lies to the cells' edges differs in each.
TEST_F(TetProjectorTest, ThickCellsAreSeenOnceAtAnySize) {
  const Smoke smoke(boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {6, 5, 4}, 0.3, 5), true, 25);
  TetProjector projector = projectorOf(smoke);
  const Vec3 centre = smoke.medium().bounds().centre();
  const auto views = [&](int width, int height) {
    return std::vector{
        Camera::framing(smoke.medium().bounds(), width, height),
        Camera::pinhole({Vec3(-1.3, -0.9, 1.7), centre}, 45, width, height),
        Camera::pinhole({centre + Vec3(0.05, 0.02, -0.3), centre + Vec3(1, 2, 0.5)}, 70, width,
                        height),
        Camera::orthographic({centre + Vec3(1, -1, 0.7), centre}, 2.4, width, height)};
  };
  for (int size = 24; size <= 76; size += 4) {
    const int width = size + size / 3, height = size;
    std::vector<float> wall(static_cast<std::size_t>(width) * height);
    for (const Camera& camera : views(width, height)) {
      const double middle = camera.isOrthographic() ? 1.6 : (centre - camera.eye()).norm();
      for (std::size_t i = 0; i < wall.size(); ++i)
        wall[i] = static_cast<float>(middle * (0.8 + 0.4 * double(i % width) / width));
      for (const std::span<const float> opaque :
           {std::span<const float>(), std::span<const float>(wall)}) {
        if (!opaque.empty() && size % 8 == 0)
          continue;
        const Error error = compare(projector, smoke, camera, {}, opaque);
        EXPECT_LE(error.worst, kProjected)
            << width << " x " << height << ", eye " << camera.eye() << ", wall " << opaque.size();
      }
    }
  }
}

/// Eyes in the planes of faces, on edges and on vertices, rays along them.
TEST_F(TetProjectorTest, EyesInThePlanesOfFaces) {
  const Smoke smoke(boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {4, 3, 4}, 0, 5), true, 25);
  TetProjector projector = projectorOf(smoke);
  for (const Vec3& eye : {Vec3(-2, 0.5, 0.5), Vec3(0.5, 0.5, 0.5), Vec3(1, 0.5, 0.3),
                          Vec3(1, 0.6, 0.25), Vec3(-2, 0.75, 0.5)}) {
    for (const int size : {31, 45}) {
      for (const Camera& camera :
           {Camera::pinhole({eye, eye + Vec3(1, 0, 0)}, 60, size, size),
            Camera::orthographic({eye, eye + Vec3(1, 0, 0)}, 1.2, size, size)}) {
        const Error error = compare(projector, smoke, camera);
        EXPECT_LE(error.worst, kProjected)
            << size << ", eye " << eye << (camera.isOrthographic() ? ", orthographic" : "");
      }
    }
  }
}

TEST_F(TetProjectorTest, WallsInAHallThatIsNotConvex) {
  const Smoke smoke(hallMesh(2.5, 3), true, 0.1);
  TetProjector projector = projectorOf(smoke);
  const Box3 hall = smoke.medium().bounds();
  const Camera outside = Camera::framing(hall, kWidth, kHeight);
  const Camera inside = Camera::pinhole({hall.min + Vec3(2.3, 6.1, 1.7), hall.max - Vec3(1, 4, 3)},
                                        60, kWidth, kHeight);
  for (const Camera& camera : {outside, inside}) {
    std::vector<float> wall(kWidth * kHeight);
    const double middle = (hall.centre() - camera.eye()).norm();
    for (std::size_t i = 0; i < wall.size(); ++i)
      wall[i] = static_cast<float>(middle * (i % 3 == 0 ? 1e9 : 0.6 + 0.001 * double(i % 700)));
    for (const std::span<const float> opaque :
         {std::span<const float>(), std::span<const float>(wall)}) {
      const Error error = compare(projector, smoke, camera, {}, opaque);
      EXPECT_LE(error.worst, kProjected) << camera.eye() << " " << opaque.size();
    }
  }
}

/// Without the shader's cut the depth test alone keeps smoke from being drawn over a wall.
TEST_F(TetProjectorTest, CellsBehindWallsAreCulled) {
  const Smoke smoke(boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {6, 5, 4}, 0.3, 5), true, 0.8);
  TetProjector projector = projectorOf(smoke);
  const Box3 box = smoke.medium().bounds();
  const Vec3 eye(-3, 0.7, 0.5);
  for (const Camera& camera : {Camera::pinhole({eye, box.centre()}, 30, kWidth, kHeight),
                               Camera::orthographic({eye, box.centre()}, 1.2, kWidth, kHeight)}) {
    /// The sum of what is let through, behind a wall that is so far away.
    const auto passed = [&](double distance) {
      const std::vector<float> wall(kWidth * kHeight, static_cast<float>(distance));
      EXPECT_TRUE(projector.draw(camera, wall, {.cutAtWalls = false}, passes_));
      const auto texels = projector.read();
      double sum = 0;
      for (std::size_t i = 3; i < texels.size(); i += 4) sum += texels[i];
      return sum / (kWidth * kHeight);
    };
    EXPECT_EQ(passed(2.5), 1) << "all smoke is behind it";
    const double all = passed(9), half = passed(4);
    EXPECT_LT(all, 0.9);
    EXPECT_GT(half, all + 0.02);
    EXPECT_LT(half, 1);
  }
}

TEST_F(TetProjectorTest, SortAndProjectionServeWhileTheEyeStays) {
  const Smoke smoke(boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {4, 3, 3}, 0.2, 1), true, 2);
  TetProjector projector = projectorOf(smoke);
  const Vec3 eye(-1, -2, 1.5);
  const Smoke later(std::shared_ptr<const TetMesh>(smoke.locator, &smoke.locator->mesh()), true,
                    0.7);
  (void)compare(projector, smoke, Camera::pinhole({eye, Vec3(1, 1, 0.5)}, 40, kWidth, kHeight));
  // Turned, zoomed, larger, and with new smoke.
  EXPECT_LE(compare(projector, smoke, Camera::pinhole({eye, Vec3(0.5, 1, 0.2)}, 60, 50, 41)).worst,
            kProjected);
  projector.setSmoke(later.extinction, later.source);
  EXPECT_LE(compare(projector, later, Camera::pinhole({eye, Vec3(1, 1, 0.5)}, 30, 40, 40)).worst,
            kProjected);
  EXPECT_EQ(projector.counts().sorts, 1);
  (void)compare(projector, later, Camera::pinhole({-eye, Vec3(1, 1, 0.5)}, 30, 40, 40));
  EXPECT_EQ(projector.counts().sorts, 2);
  EXPECT_EQ(projector.counts().pictures, 4);
}

/// Staubli et al. 2005, Figure 7: a block of uniform smoke, by what it is blended into. Its cells
/// pass about 254/255 of the light: 8 bits round that to 1 or to 254/255, dithering on average to
/// neither.
TEST_F(TetProjectorTest, TargetsDifferAsInThePapersFigure) {
  const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(2, 2, 2)}, {14, 14, 14}, 0.2, 2);
  Smoke smoke(mesh, false, 0);
  std::ranges::fill(smoke.extinction, 0.03F);
  smoke.source.assign(3 * smoke.extinction.size(), 1.0F);
  TetProjector projector = projectorOf(smoke);
  const Camera camera = Camera::pinhole({Vec3(-3, -2, 2.5), Vec3(1, 1, 1)}, 40, 60, 60);
  const auto errorWith = [&](TetTarget target) {
    return compare(projector, smoke, camera, {.target = target});
  };
  const Error full = errorWith(TetTarget::kFloat32), half = errorWith(TetTarget::kFloat16);
  const Error fixed = errorWith(TetTarget::kFixed8),
              dithered = errorWith(TetTarget::kFixed8Dithered);
  EXPECT_LE(full.worst, kProjected);
  EXPECT_GT(half.worst, full.worst);
  EXPECT_LE(half.worst, 0.03);
  EXPECT_LE(std::abs(half.bias), 0.01);
  EXPECT_LT(fixed.bias, -0.05);
  EXPECT_LT(std::abs(dithered.bias), 0.01);
  EXPECT_LT(dithered.mean, 0.6 * fixed.mean);
}

/// White smoke without end is white; with 8 bits it stops at a grey, where a cell's share is less
/// than half a step (Staubli et al. 2005, section 4.2): in both orders, for what is blended is
/// rounded too.
TEST_F(TetProjectorTest, EightBitsStopAtGrey) {
  const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(900, 1, 1)}, {900, 1, 1}, 0, 2);
  Smoke smoke(mesh, false, 0);
  smoke.source.assign(3 * smoke.extinction.size(), 1.0F);
  TetProjector projector = projectorOf(smoke);
  const Camera camera = Camera::orthographic({Vec3(-3, 0.4, 0.45), Vec3(1, 0.4, 0.45)}, 0.1, 8, 8);
  const auto grey = [&](double opacity, TetTarget target, TetBlend blend) {
    std::ranges::fill(smoke.extinction, static_cast<float>(3 * opacity));  // a cell is three tets
    projector.setSmoke(smoke.extinction, smoke.source);
    EXPECT_TRUE(projector.draw(camera, {}, {target, blend}, passes_));
    return projector.read()[4 * 20];
  };
  for (const TetBlend blend : {TetBlend::kBackToFront, TetBlend::kFrontToBack}) {
    EXPECT_GT(grey(1 / 255.0, TetTarget::kFloat32, blend), 0.999);
    EXPECT_LT(grey(1 / 255.0, TetTarget::kFixed8, blend), 0.8);
    EXPECT_GT(grey(20 / 255.0, TetTarget::kFixed8, blend), 0.95);
  }
}

TEST_F(TetProjectorTest, ALensIsRefused) {
  const Smoke smoke(boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {2, 2, 2}, 0.2, 1), true, 2);
  TetProjector projector = projectorOf(smoke);
  const auto drawn = projector.draw(cameras(smoke.medium().bounds()).back(), {}, {}, passes_);
  ASSERT_FALSE(drawn);
  EXPECT_EQ(drawn.error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace volute
