// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/projector.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <random>

#include "volute/base/parallel.hpp"
#include "volute/tomography/project.hpp"
#include "volute/tomography/reference_projector.hpp"

namespace volute {
namespace {

struct Case {
  Basis basis;
  int raysPerPixel;
  bool table;
};

/// A small volume that is no cube, and cameras of both kinds around and inside of it.
struct Scene {
  VolumeGeometry geometry{{Vec3(-0.6, -0.4, 0.1), Vec3(0.5, 0.7, 0.9)}, {11, 9, 7}};
  std::vector<Camera> cameras;

  Scene() {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    const Vec3 centre = geometry.bounds.centre();
    for (int i = 0; i < 3; ++i) {
      const Vec3 eye = centre + 3 * Vec3(unit(random), unit(random), unit(random));
      cameras.push_back(Camera::pinhole({eye, centre + 0.1 * eye}, 35, 23, 17));
    }
    cameras.push_back(
        Camera::pinhole({centre + Vec3(0.03, 0.02, 0), centre + Vec3(1, 0.2, 0)}, 90, 9, 8));
    // Rays along an axis: parallel to faces, through voxel centres and along faces between voxels.
    cameras.push_back(Camera::orthographic({centre + Vec3(0, -2, 0), centre}, 0.8, 22, 14));
    cameras.push_back(Camera::orthographic({centre + Vec3(2, 2, 0), centre}, 1, 11, 12));
  }

  std::vector<ProjectorView> views() const {
    std::vector<ProjectorView> out;
    for (const Camera& camera : cameras) out.push_back({&camera});
    return out;
  }

  std::vector<std::uint8_t> someHull() const {
    std::mt19937 random(5);
    std::vector<std::uint8_t> hull(geometry.voxels());
    for (auto& voxel : hull) voxel = random() % 3 != 0;
    return hull;
  }
};

std::vector<float> randomColours(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<float> values(4 * count);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % 4 == 3 ? 0 : unit(random);
  return values;
}

double dot(std::span<const float> a, std::span<const float> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += static_cast<double>(a[i]) * b[i];
  return sum;
}

double norm(std::span<const float> a) {
  return std::sqrt(dot(a, a));
}

std::vector<Segment> raysOf(const Camera& camera, std::int32_t pixel, int raysPerPixel) {
  const int x = pixel % camera.width(), y = pixel / camera.width();
  if (raysPerPixel == 1)
    return {camera.ray(x + 0.5, y + 0.5)};
  return {camera.ray(x + 0.25, y + 0.25), camera.ray(x + 0.75, y + 0.25),
          camera.ray(x + 0.25, y + 0.75), camera.ray(x + 0.75, y + 0.75)};
}

class ProjectorTest : public testing::TestWithParam<Case> {
 protected:
  Projector make(std::span<const std::uint8_t> hull) const {
    const auto support = std::make_shared<const Support>(scene_.geometry, GetParam().basis, hull);
    const auto views = scene_.views();
    return Projector(views, support, GetParam().raysPerPixel,
                     GetParam().table ? std::uint64_t{1} << 30 : 0);
  }

  Scene scene_;
};

TEST_P(ProjectorTest, AdjointIdentity) {
  const auto hull = scene_.someHull();
  const Projector projector = make(hull);
  ASSERT_EQ(projector.usesTable(), GetParam().table);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto x = randomColours(projector.unknowns(), seed);
    const auto y = randomColours(projector.rows(), seed + 100);
    std::vector<float> sx(y.size()), sy(x.size());
    projector.forward(x, sx);
    projector.adjoint(y, sy);
    EXPECT_NEAR(dot(sx, y), dot(x, sy), 1e-6 * norm(sx) * norm(y));
  }
}

TEST_P(ProjectorTest, AgreesWithReference) {
  const auto hull = scene_.someHull();
  const Projector projector = make(hull);
  const ReferenceProjector reference(scene_.geometry, GetParam().basis);
  const auto x = randomColours(projector.unknowns(), 7);
  std::vector<float> sx(4 * projector.rows());
  projector.forward(x, sx);
  for (int c = 0; c < 3; ++c) {
    std::vector<double> volume(scene_.geometry.voxels());
    for (std::size_t i = 0; i < projector.unknowns(); ++i)
      volume[projector.support().voxels()[i]] = x[4 * i + c];
    for (std::size_t row = 0; row < projector.rows(); ++row) {
      const PixelRow& pixel = projector.pixels()[row];
      double sum = 0;
      const auto rays = raysOf(scene_.cameras[pixel.view], pixel.pixel, GetParam().raysPerPixel);
      for (const Segment& ray : rays) sum += reference.forward(volume, ray);
      EXPECT_NEAR(sx[4 * row + c], sum / static_cast<double>(rays.size()), 2e-6)
          << "view " << pixel.view << " pixel " << pixel.pixel;
    }
  }
}

TEST_P(ProjectorTest, ThereAndBackIsForwardAndAdjoint) {
  const auto hull = scene_.someHull();
  const Projector projector = make(hull);
  const auto x = randomColours(projector.unknowns(), 3), y = randomColours(projector.rows(), 4);
  std::vector<float> sx(y.size()), residual(y.size()), expected(x.size());
  projector.forward(x, sx);
  for (std::size_t i = 0; i < y.size(); ++i) residual[i] = 0.5F * (sx[i] - y[i]);
  projector.adjoint(residual, expected);
  std::vector<float> pixels(y.size()), result(x.size());
  projector.thereAndBack(
      x,
      [&](std::size_t row, const float* sum, float* back) {
        for (std::size_t c = 0; c < 4; ++c) back[c] = 0.5F * (sum[c] - y[4 * row + c]);
      },
      pixels, result);
  for (std::size_t i = 0; i < y.size(); ++i) EXPECT_NEAR(pixels[i], sx[i], 1e-6);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(result[i], expected[i], 1e-5);
}

TEST_P(ProjectorTest, WalksBothTogetherAndOneByOne) {
  const Projector projector = make(scene_.someHull());
  const bool together =
      GetParam().basis == Basis::kTrilinear && GetParam().raysPerPixel == 4 && !GetParam().table;
  EXPECT_EQ(projector.beams() > projector.rows() / 3, together);
  // Not through the camera inside of the volume.
  EXPECT_LT(projector.beams(), projector.rows());
}

TEST_P(ProjectorTest, LeavesOutNoRayThatMeetsAnUnknown) {
  const auto hull = scene_.someHull();
  const Projector projector = make(hull);
  const ReferenceProjector reference(scene_.geometry, GetParam().basis);
  std::vector<double> volume(hull.begin(), hull.end());
  std::size_t expected = 0;
  for (const Camera& camera : scene_.cameras) {
    for (int pixel = 0; pixel < camera.width() * camera.height(); ++pixel) {
      bool meets = false;
      for (const Segment& ray : raysOf(camera, pixel, GetParam().raysPerPixel))
        meets = meets || reference.forward(volume, ray) > 1e-9;
      expected += meets;
    }
  }
  EXPECT_GE(projector.rows(), expected);
}

TEST_P(ProjectorTest, SameForAnyNumberOfThreads) {
  const auto hull = scene_.someHull();
  std::vector<std::vector<float>> forward, adjoint;
  for (int threads : {1, 2, 7}) {
    const ThreadLimit limit(threads);
    const Projector projector = make(hull);
    const auto x = randomColours(projector.unknowns(), 1), y = randomColours(projector.rows(), 2);
    forward.emplace_back(y.size());
    adjoint.emplace_back(x.size());
    projector.forward(x, forward.back());
    projector.adjoint(y, adjoint.back());
  }
  for (int i : {1, 2}) {
    EXPECT_EQ(forward[0], forward[i]);
    EXPECT_EQ(adjoint[0], adjoint[i]);
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, ProjectorTest,
    testing::Values(Case{Basis::kBox, 1, false}, Case{Basis::kBox, 4, true},
                    Case{Basis::kTrilinear, 1, false}, Case{Basis::kTrilinear, 1, true},
                    Case{Basis::kTrilinear, 4, false}, Case{Basis::kTrilinear, 4, true}),
    [](const auto& info) {
      return std::string(info.param.basis == Basis::kBox ? "Box" : "Trilinear") +
             std::to_string(info.param.raysPerPixel) + (info.param.table ? "Table" : "Walk");
    });

class ReferenceTest : public testing::TestWithParam<Basis> {};

TEST_P(ReferenceTest, AdjointIdentity) {
  const Scene scene;
  const ReferenceProjector reference(scene.geometry, GetParam());
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<double> x(scene.geometry.voxels()), gradient(x.size());
  for (double& value : x) value = unit(random);
  double left = 0, size = 0;
  for (const Camera& camera : scene.cameras) {
    for (int pixel = 0; pixel < camera.width() * camera.height(); ++pixel) {
      const Segment ray = raysOf(camera, pixel, 1)[0];
      const double y = unit(random);
      const double sx = reference.forward(x, ray);
      left += sx * y;
      size += std::abs(sx * y);
      reference.adjoint(y, ray, gradient);
    }
  }
  double right = 0;
  for (std::size_t i = 0; i < x.size(); ++i) right += x[i] * gradient[i];
  EXPECT_NEAR(left, right, 1e-12 * size);
}

INSTANTIATE_TEST_SUITE_P(Bases, ReferenceTest, testing::Values(Basis::kBox, Basis::kTrilinear));

/// A field that is linear in space, sampled at voxel centres.
std::vector<double> linearField(const VolumeGeometry& geometry, const Vec3& slope, double offset) {
  std::vector<double> values;
  const auto& n = geometry.resolution;
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) {
        const Vec3 centre = geometry.bounds.min +
                            Vec3(x + 0.5, y + 0.5, z + 0.5).cwiseProduct(geometry.voxelSize());
        values.push_back(offset + slope.dot(centre));
      }
  return values;
}

TEST(ReferenceProjector, LinearFieldIsExactBetweenCentres) {
  const Scene scene;
  const Vec3 slope(0.7, -1.3, 2.1);
  const auto values = linearField(scene.geometry, slope, 0.4);
  const Vec3 margin = 0.5 * scene.geometry.voxelSize();
  const Box3 centres{scene.geometry.bounds.min + margin, scene.geometry.bounds.max - margin};
  const ReferenceProjector reference(scene.geometry, Basis::kTrilinear);
  for (const Camera& camera : scene.cameras) {
    for (int pixel = 0; pixel < camera.width() * camera.height(); ++pixel) {
      Segment ray = raysOf(camera, pixel, 1)[0];
      const Interval inside =
          centres.intersect(ray.origin, ray.direction).intersect({ray.begin, ray.end});
      if (inside.empty())
        continue;
      ray.begin = inside.begin;
      ray.end = inside.end;
      const Vec3 middle = ray.at(0.5 * (ray.begin + ray.end));
      EXPECT_NEAR(reference.forward(values, ray), (0.4 + slope.dot(middle)) * inside.length(),
                  1e-12);
    }
  }
}

TEST(ReferenceProjector, ConstantIsChordLengthInBoxes) {
  const Scene scene;
  const std::vector<double> ones(scene.geometry.voxels(), 1);
  const ReferenceProjector reference(scene.geometry, Basis::kBox);
  for (const Camera& camera : scene.cameras) {
    for (int pixel = 0; pixel < camera.width() * camera.height(); ++pixel) {
      const Segment ray = raysOf(camera, pixel, 1)[0];
      const double chord = scene.geometry.bounds.intersect(ray.origin, ray.direction)
                               .intersect({ray.begin, ray.end})
                               .length();
      EXPECT_NEAR(reference.forward(ones, ray), chord, 1e-12);
    }
  }
}

TEST(ReferenceProjector, LinearFieldAlongAnAxisOfBoxesIsTheSumOfItsCentres) {
  // In steps of whole voxels along an axis the midpoint rule is exact.
  const Scene scene;
  const Vec3 slope(0.7, -1.3, 2.1);
  const auto values = linearField(scene.geometry, slope, 0.4);
  const ReferenceProjector reference(scene.geometry, Basis::kBox);
  for (int axis = 0; axis < 3; ++axis) {
    Segment ray{scene.geometry.bounds.min + 2.5 * scene.geometry.voxelSize(), Vec3::Unit(axis), -10,
                10};
    const double length = scene.geometry.bounds.size()[axis];
    Vec3 middle = ray.origin;
    middle[axis] = scene.geometry.bounds.centre()[axis];
    EXPECT_NEAR(reference.forward(values, ray), (0.4 + slope.dot(middle)) * length, 1e-12);
  }
}

TEST(TouchedPart, IsFromTheFirstToTheLastCellThatIsTouched) {
  const Scene scene;
  std::mt19937 random(13);
  std::vector<std::uint8_t> hull(scene.geometry.voxels());
  for (auto& voxel : hull) voxel = random() % 40 == 0;  // gaps on most ways
  for (const Basis basis : {Basis::kBox, Basis::kTrilinear}) {
    const Support support(scene.geometry, basis, hull);
    int touched = 0;
    for (const Camera& camera : scene.cameras) {
      for (int pixel = 0; pixel < camera.width() * camera.height(); ++pixel) {
        const Segment ray = raysOf(camera, pixel, 1)[0];
        TouchedPart expected;
        traverseCells(support.cells(), support.range(), ray,
                      [&](const std::array<int, 3>& cell, double begin, double end) {
                        if (!support.touches(cell))
                          return;
                        if (expected.empty()) {
                          expected.part.begin = begin;
                          expected.firstCell = cell;
                        }
                        expected.part.end = end;
                      });
        const TouchedPart part = touchedPart(support, ray);
        ASSERT_EQ(part.empty(), expected.empty());
        if (expected.empty())
          continue;
        ++touched;
        EXPECT_EQ(part.firstCell, expected.firstCell);
        EXPECT_DOUBLE_EQ(part.part.begin, expected.part.begin);
        EXPECT_DOUBLE_EQ(part.part.end, expected.part.end);
      }
    }
    EXPECT_GT(touched, 100);
  }
}

TEST(Projector, RoundingDoesNotAddUpOnLongWays) {
  const VolumeGeometry geometry{{Vec3(-1, -1, -1), Vec3(1, 1, 1)}, {70, 60, 80}};
  const auto support =
      std::make_shared<const Support>(geometry, Basis::kTrilinear, std::span<const std::uint8_t>{});
  const auto x = randomColours(support->size(), 21);
  std::vector<double> volume(geometry.voxels());
  for (std::size_t i = 0; i < x.size() / 4; ++i) volume[i] = x[4 * i];
  const ReferenceProjector reference(geometry, Basis::kTrilinear);
  std::size_t rows = 0, beams = 0;
  // Along each axis both ways, along diagonals of faces and of the cube, and askew.
  for (const Vec3& from :
       {Vec3(4, 0, 0), Vec3(-4, 0, 0), Vec3(0, 4, 0.01), Vec3(0, -4, 0), Vec3(0.01, 0, 4),
        Vec3(0, 0.01, -4), Vec3(3, 3, 0), Vec3(-3, 3, 3), Vec3(0.4, -3, 3.1), Vec3(2, -1, 0.5)}) {
    const Camera camera = Camera::pinhole({from, Vec3(0.02, -0.01, 0.03)}, 20, 53, 41);
    const ProjectorView view{&camera, {}};
    const Projector projector({&view, 1}, support, 4, 0);
    rows += projector.rows();
    beams += projector.beams();
    std::vector<float> sx(4 * projector.rows());
    projector.forward(x, sx);
    for (std::size_t row = 0; row < projector.rows(); row += 11) {
      double sum = 0;
      for (const Segment& ray : raysOf(camera, projector.pixels()[row].pixel, 4))
        sum += 0.25 * reference.forward(volume, ray);
      EXPECT_NEAR(sx[4 * row], sum, 2e-6) << from << ", row " << row;
    }
    const auto y = randomColours(projector.rows(), 22);
    std::vector<float> sy(x.size());
    projector.adjoint(y, sy);
    EXPECT_NEAR(dot(sx, y), dot(x, sy), 1e-6 * norm(sx) * norm(y));
  }
  EXPECT_GT(beams, rows / 2);
}

TEST(Projector, EveryTargetGivesTheSame) {
  const Scene scene;
  const auto hull = scene.someHull();
  const auto support = std::make_shared<const Support>(scene.geometry, Basis::kTrilinear, hull);
  const auto views = scene.views();
  for (const int rays : {1, 4}) {
    const Projector projector(views, support, rays, 0);
    const auto x = randomColours(projector.unknowns(), 31), y = randomColours(projector.rows(), 32);
    std::vector<float> first, firstBack;
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      std::vector<float> sx(y.size()), sy(x.size());
      projector.forward(x, sx);
      projector.adjoint(y, sy);
      if (first.empty()) {
        first = sx;
        firstBack = sy;
      }
      for (std::size_t i = 0; i < sx.size(); ++i)
        ASSERT_NEAR(sx[i], first[i], 2e-6) << hwy::TargetName(target);
      for (std::size_t i = 0; i < sy.size(); ++i)
        ASSERT_NEAR(sy[i], firstBack[i], 2e-6 * norm(y)) << hwy::TargetName(target);
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
}

TEST(ProjectVolume, ConstantCubeShowsItsChords) {
  const VolumeGeometry geometry{{Vec3(-1, -1, -1), Vec3(1, 1, 1)}, {8, 8, 8}};
  const std::vector<float> volume(3 * geometry.voxels(), 2.0F);
  const Camera camera = Camera::orthographic({Vec3(0, -5, 0), Vec3(0, 0, 0)}, 4, 8, 8);
  const Image image = projectVolume(volume, geometry, Basis::kBox, camera, 4);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) {
      const bool inside = x >= 2 && x < 6 && y >= 2 && y < 6;
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at(x, y, c), inside ? 4 : 0, 1e-6);
    }
}

TEST(ProjectVolume, TrilinearFallsToZeroOneVoxelBeyondTheOuterCentres) {
  const VolumeGeometry geometry{{Vec3(0, 0, 0), Vec3(1, 1, 1)}, {1, 1, 1}};
  const std::vector<float> volume{1, 2, 3};
  // Through the middle of a hat of one metre to each side: the integral is 1 m.
  const Camera camera = Camera::orthographic({Vec3(0.5, -5, 0.5), Vec3(0.5, 0, 0.5)}, 3, 3, 3);
  const Image image = projectVolume(volume, geometry, Basis::kTrilinear, camera, 1);
  EXPECT_NEAR(image.at(1, 1, 0), 1, 1e-6);
  EXPECT_NEAR(image.at(1, 1, 2), 3, 1e-6);
  EXPECT_NEAR(image.at(0, 1, 0), 0, 1e-6);
}

}  // namespace
}  // namespace volute
