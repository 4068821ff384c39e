// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_field.hpp"
#include "volute/gl/gl_fds.hpp"
#include "volute/gl/gl_testing.hpp"
#include "volute/medium/conformance/dummy_media.hpp"

// The media that the conformance suite is proved with, as far as OpenGL has media of their
// extinction: lattices of nodes are trilinear inside and nothing outside. Each picture is compared
// with that of the suite's own medium.

namespace volute {

using namespace gltest;
using namespace conformance;

namespace {

/// Nodes at even distances in a box, and the extinction of a medium there.
struct Nodes {
  Box3 box;
  std::array<int, 3> count;  ///< of nodes on each axis
  std::vector<double> extinction;
};

FdsField fieldOf(const std::vector<Nodes>& boxes) {
  std::vector<FdsLattice> lattices;
  for (const Nodes& nodes : boxes) {
    FdsLattice lattice;
    lattice.mesh = static_cast<int>(lattices.size());
    lattice.nodal = true;
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 0; i < nodes.count[axis]; ++i) {
        lattice.planes[axis].push_back(nodes.box.min[axis] +
                                       nodes.box.size()[axis] * i / (nodes.count[axis] - 1));
      }
    }
    lattices.push_back(std::move(lattice));
  }
  const auto grid = FdsGrid::create(lattices).value();
  std::vector<std::shared_ptr<const FdsValues>> values;
  std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    auto made = std::make_shared<FdsValues>();
    made->value.assign(boxes[i].extinction.begin(), boxes[i].extinction.end());
    values.push_back(std::move(made));
    cells.push_back(std::make_shared<std::vector<FdsCell>>(lattices[i].cellCount(), FdsCell::kGas));
  }
  return FdsField(grid, std::move(values), std::move(cells));
}

class GlConformanceTest : public GlRendererTest {
 protected:
  void compare(const AnyMedium& medium, const FdsField& field) {
    int views = 0;
    for (const Camera& camera : cameras(medium.bounds())) {
      for (const Aov aov : {Aov::kOpticalDepth, Aov::kTransmittance}) {
        EXPECT_LE(errorOf(camera, {{glPart(GlFds{field})}}, {&medium, 1}, {.aov = aov}), kBar)
            << "view " << views << ", quantity " << static_cast<int>(aov);
      }
      ++views;
    }
  }
};

TEST_F(GlConformanceTest, TrilinearVoxels) {
  const AnyMedium medium = trilinearVoxelsUnderTest().medium;
  const TrilinearVoxels voxels({5, 4, 6}, Vec3(-1, 0.5, 2), Vec3(0.5, 0.75, 0.25), 7);
  ASSERT_EQ(voxels.extinction(medium.bounds().centre()),
            medium.extinction(medium.bounds().centre()));
  compare(medium, fieldOf({{voxels.bounds(), {5, 4, 6}, voxels.coefficients()}}));
}

TEST_F(GlConformanceTest, TwoBoxes) {
  const AnyMedium medium = twoBoxesUnderTest().medium;
  std::vector<Nodes> boxes;
  for (const Box3& box : {TwoBoxes::kFirst, TwoBoxes::kSecond}) {
    Nodes nodes{box, {2, 2, 2}, {}};
    const Vec3 aside = Vec3(1e-9, 0, 0);
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 at = box.min + box.size().cwiseProduct(Vec3(0, 0.5, 0.5)) +
                      (corner & 1 ? Vec3(box.size().x(), 0, 0) - aside : aside);
      nodes.extinction.push_back(medium.extinction(at));
    }
    boxes.push_back(std::move(nodes));
  }
  EXPECT_LT(boxes[1].extinction[0], boxes[1].extinction[1]);
  compare(medium, fieldOf(boxes));
}

/// The ground's even layer and the exponential air above it, as a fog whose map is as wide as they
/// are.
TEST_F(GlConformanceTest, Atmosphere) {
  const double ground = 0.2;
  const AnyMedium medium = atmosphereUnderTest().medium;
  ASSERT_EQ(medium.extinction(Vec3(1, 1, 1)), ground);
  SplineGrid even(8, 8);
  for (double& value : even.c) value = ground;
  const FogMap map = *FogMap::fromCoefficients(
      even, {.origin = Vec3::Zero(), .cell = medium.bounds().max.x() / 8});
  const FogMedium fog = *FogMedium::make(
      map, *FogProfile::exponential(Atmosphere::kBottom, Atmosphere::kScaleHeight), {.degree = 0});
  // Rays that end above the ground, where the fog has none.
  const Camera camera = Camera::pinhole(
      {Vec3(3, -9, 14), medium.bounds().max.x() * Vec3(0.5, 0.5, 0)}, 40, kWidth, kHeight);
  std::vector<float> ends;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Segment ray = camera.ray(x + 0.5, y + 0.5);
      const double down = (0.1 - ray.origin.z()) / ray.direction.z();
      ends.push_back(static_cast<float>(down > 0 ? std::min(down, 40.0) : 40.0));
    }
  }
  EXPECT_LE(
      errorOf(camera, {{glPart(GlFog{fog})}}, {&medium, 1}, {.aov = Aov::kOpticalDepth}, ends),
      kBar);
}

}  // namespace
}  // namespace volute
