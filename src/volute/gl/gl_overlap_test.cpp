// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_testing.hpp"
#include "volute/lighting/vertex_light.hpp"

// Fire inside fog inside smoke that a lamp lights, and a wall through all three.

namespace volute {

using namespace gltest;

namespace {

/// The plane x = 0.5 - 0.35 (y - 3) up to z = 2.6, cut off where y > 3.6.
double wallAlong(const Segment& ray) {
  const Vec3 normal(1, 0.35, 0);
  const double s = (0.5 + 0.35 * 3 - normal.dot(ray.origin)) / normal.dot(ray.direction);
  const Vec3 at = ray.at(s);
  const bool met = s > 0 && at.z() < 2.6 && at.y() < 3.6;
  return met ? s : std::numeric_limits<double>::infinity();
}

class GlOverlapTest : public GlRendererTest {
 protected:
  GlOverlapTest()
      : fire_(sliceOf(3, Basis::kTrilinear)),
        fog_(fogtest::fog(fogtest::map(10, 10, 1, 1), fogtest::profiles()[1].profile,
                          {.degree = 2, .color = Rgb(0.7, 0.8, 0.9)}, 0.6, 0.5)),
        smoke_(boxMesh({Vec3(-4, 0, -0.5), Vec3(4, 8.5, 8)}, {6, 6, 6}, 0.25, 3), false, 0.25) {
    Lamp lamp;
    lamp.position = Vec3(-2.5, 1.2, 4.5);
    lamp.intensity = Rgb(60, 45, 30);
    const std::vector<std::vector<float>> shares{
        LampPaths(smoke_.locator).shares(smoke_.extinction, lamp)};
    smoke_.source = scatteredLight(smoke_.locator->mesh().vertices(), {&lamp, 1}, shares,
                                   Rgb(0.9, 0.8, 0.7), Rgb::Constant(0.1));
  }

  std::vector<AnyMedium> media(bool fire, bool fog, bool smoke) const {
    std::vector<AnyMedium> list;
    if (fire)
      list.emplace_back(VoxelMedium(fire_, 2, 3));
    if (fog)
      list.emplace_back(fog_);
    if (smoke)
      list.push_back(smoke_.medium());
    return list;
  }

  GlScene scene(bool fire, bool fog, bool smoke) const {
    GlScene scene;
    if (fire)
      scene.parts.push_back(glPart(GlVolume{fire_, 2, 3}));
    if (fog)
      scene.parts.push_back(glPart(GlFog{fog_}));
    if (smoke)
      scene.parts.push_back(smoke_.onDevice());
    return scene;
  }

  static std::vector<float> wallOf(const Camera& camera) {
    std::vector<float> depth;
    for (int y = 0; y < camera.height(); ++y) {
      for (int x = 0; x < camera.width(); ++x)
        depth.push_back(static_cast<float>(wallAlong(camera.ray(x + 0.5, y + 0.5))));
    }
    return depth;
  }

  std::shared_ptr<const BrickSlice> fire_;
  FogMedium fog_;
  Smoke smoke_;
};

bool within(const Box3& inner, const Box3& outer) {
  return outer.contains(inner.min) && outer.contains(inner.max);
}

/// Four from outside of everything, four among the media: in the fire, the fog, the smoke alone,
/// and close to the wall.
const Vec3 kEyes[] = {{-8, -3, 3},        {9, 1, 4},      {0, 14, 6},      {1, -6, 0.4},
                      {-0.45, 2.85, 1.2}, {-2, 3.4, 1.5}, {3.1, 7.2, 4.4}, {0.55, 2.6, 1.2}};

Camera from(const Vec3& eye) {
  const Vec3 target = (eye - Vec3(0, 3, 1.5)).norm() > 0.8 ? Vec3(0, 3, 1.5) : Vec3(0.6, 3, 2);
  return Camera::pinhole({eye, target}, 55, kWidth, kHeight);
}

TEST_F(GlOverlapTest, TheSceneIsWhatItsNameSays) {
  const auto all = media(true, true, true);
  EXPECT_TRUE(within(fire_->bounds(), all[1].bounds()));
  EXPECT_TRUE(within(all[1].bounds(), all[2].bounds()));
  for (int eye = 0; eye < 4; ++eye) EXPECT_FALSE(all[2].bounds().contains(kEyes[eye]));
  EXPECT_GT(all[0].extinction(kEyes[4]), 0);
  EXPECT_EQ(all[0].extinction(kEyes[5]), 0);
  EXPECT_GT(all[1].extinction(kEyes[5]), 0);
  EXPECT_EQ(all[1].extinction(kEyes[6]), 0);
  EXPECT_GT(all[2].extinction(kEyes[6]), 0);
  // What is seen of the wall stands in all three.
  int met[3] = {};
  for (const Vec3& eye : kEyes) {
    const Camera camera = from(eye);
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const Segment ray = camera.ray(i % kWidth + 0.5, i / kWidth + 0.5);
      const double s = wallAlong(ray);
      for (int k = 0; k < 3 && s < 1e9; ++k) met[k] += all[k].extinction(ray.at(s)) > 0;
    }
  }
  for (const int pixels : met) EXPECT_GT(pixels, 50);
  const auto [darkest, brightest] = std::ranges::minmax(smoke_.source);
  EXPECT_GT(brightest, 2 * darkest) << "the lamp does not show";
}

TEST_F(GlOverlapTest, EightEyesSeeWhatTheReferenceSees) {
  int inside = 0;
  for (const Vec3& eye : kEyes) {
    const Camera camera = from(eye);
    const auto wall = wallOf(camera);
    EXPECT_GT(std::ranges::count_if(wall, [](float s) { return s < 1e9F; }), 20) << eye;
    const auto all = media(true, true, true);
    inside += all[2].bounds().contains(eye);
    const RenderOptions options{.background = Rgb(0.1, 0.2, 0.5)};
    EXPECT_LE(errorOf(camera, scene(true, true, true), all, options, wall), kBar) << eye;
    EXPECT_LE(errorOf(camera, scene(true, true, true), all, {.aov = Aov::kOpticalDepth}, wall),
              kBar)
        << eye;
  }
  EXPECT_EQ(inside, 4);
}

TEST_F(GlOverlapTest, EachMediumAndEachTwoOfThem) {
  for (int some = 1; some < 7; ++some) {
    for (const int eye : {0, 4}) {
      const Camera camera = from(kEyes[eye]);
      EXPECT_LE(
          errorOf(camera, scene(some & 1, some & 2, some & 4), media(some & 1, some & 2, some & 4),
                  {.background = Rgb(0.3, 0.2, 0.1)}, wallOf(camera)),
          kBar)
          << "media " << some << ", eye " << kEyes[eye];
    }
  }
}

}  // namespace
}  // namespace volute
