// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/polar_fog.hpp"
#include "volute/gl/gl_billboard.hpp"
#include "volute/gl/gl_testing.hpp"
#include "volute/render/billboard.hpp"
#include "volute/render/scaled_medium.hpp"

// What stands among the media of a scene: surfaces, lamps, signs, billboards, suns.

namespace volute {

using namespace gltest;

namespace {

constexpr double kScene = 2e-3;

class GlSceneTest : public GlRendererTest {};

/// A floor, two pillars that throw shadows, and a ball that glows.
TriangleScene room() {
  std::vector<Triangle> triangles;
  const auto quad = [&](const Vec3& a, const Vec3& u, const Vec3& v, std::uint32_t material) {
    triangles.push_back({{a, a + u, a + u + v}, material});
    triangles.push_back({{a, a + u + v, a + v}, material});
  };
  const auto box = [&](const Vec3& a, const Vec3& size, std::uint32_t material) {
    const Vec3 x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
    quad(a, y, x, material), quad(a + z, x, y, material);
    quad(a, x, z, material), quad(a + y, z, x, material);
    quad(a, z, y, material), quad(a + x, y, z, material);
  };
  quad(Vec3(-5, -2, 0.03), Vec3(11, 0.1, 0), Vec3(0.2, 12, 0.1), 0);
  box(Vec3(-1.6, 1.3, 0), Vec3(0.4, 0.5, 2.7), 1);
  box(Vec3(1.7, 3.1, 0.1), Vec3(0.3, 0.4, 3.1), 2);
  for (int i = 0; i < 60; ++i) {
    const auto at = [&](int k) {
      const double turn = 0.7 * k, height = -1 + 2.0 * (k % 31) / 31,
                   r = std::sqrt(1 - height * height);
      return Vec3(0.3 + 0.5 * r * std::cos(turn), 4.6 + 0.5 * r * std::sin(turn),
                  0.9 + 0.5 * height);
    };
    triangles.push_back({{at(i), at(i + 1), at(i + 9)}, 3});
  }
  return TriangleScene::build(std::move(triangles), {{Rgb(0.7, 0.6, 0.5)},
                                                     {Rgb(0.2, 0.5, 0.8)},
                                                     {Rgb(0.9, 0.3, 0.2)},
                                                     {Rgb(0.5, 0.5, 0.5), Rgb(0.05, 0.02, 0)}})
      .value();
}

std::vector<Lamp> lamps() {
  Lamp spot;
  spot.position = Vec3(0.4, 1.2, 3.9);
  spot.direction = Vec3(-0.1, 0.4, -1).normalized();
  spot.coneCosine = std::cos(0.9), spot.edge = 0.3;
  spot.intensity = Rgb(20, 17, 13);
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(0.5, 0.3, -0.8).normalized();
  sun.intensity = Rgb(1, 1.2, 1.6);
  return {spot, sun};
}

TEST_F(GlSceneTest, SurfacesAreLitThroughMediaAsByTheCpu) {
  const TriangleScene geometry = room();
  const auto lights = lamps();
  const Smoke smoke(boxMesh({Vec3(-2.1, 0.7, 0.1), Vec3(2.3, 5.2, 3.2)}, {5, 5, 4}, 0.2, 2), false,
                    0.5);
  const auto fire = sliceOf(1, Basis::kTrilinear);
  const FogMedium fog =
      fogtest::fog(fogtest::map(9, 9), fogtest::profiles()[1].profile, {.degree = 2}, 0.5, 0.6);
  const std::vector<AnyMedium> media{AnyMedium(VoxelMedium(fire, 1, 2)), AnyMedium(fog),
                                     smoke.medium()};
  const GlScene onDevice{{glPart(GlVolume{fire, 1, 2}), glPart(GlFog{fog}), smoke.onDevice()}};
  const Vec3 target(0.1, 3, 1);
  for (const Camera& camera : {Camera::pinhole({Vec3(-3.1, -2.2, 4.1), target}, 45, 70, 60),
                               Camera::orthographic({Vec3(3.2, -1.3, 2.9), target}, 6.1, 61, 50)}) {
    const SurfaceScene full{geometry, lights, Rgb(0.02, 0.03, 0.04), media};
    const SurfaceScene clear{geometry, lights, Rgb(0.02, 0.03, 0.04)};
    for (const bool smoky : {false, true}) {
      const auto expected =
          renderSurfaces(camera, smoky ? full : clear, Rgb(0.3, 0.2, 0.1), quiet_).value();
      const auto found = renderer_->surfaces(camera, clear, smoky ? onDevice : GlScene{},
                                             Rgb(0.3, 0.2, 0.1), quiet_);
      ASSERT_TRUE(found) << found.error().message;
      EXPECT_LE(difference(found->color.pixels, expected.color.pixels), kScene)
          << "media " << smoky;
      EXPECT_LE(difference(found->depth, expected.depth), 1e-6);
      EXPECT_EQ(found->surfacePixels, expected.surfacePixels);
      EXPECT_GT(found->surfacePixels, 500u);
    }
  }
}

/// A ball, which is 2 x 24 x 12 triangles where it has to be flat.
class RoundBall final : public CurvedSurface {
 public:
  static constexpr double kBallRadius = 0.9;

  std::optional<double> nearest(const Segment& segment) const override {
    const Vec3 from = segment.origin - middle_;
    const double along = from.dot(segment.direction);
    const double under = along * along - from.squaredNorm() + kBallRadius * kBallRadius;
    for (const double sign : {-1.0, 1.0}) {
      const double s = -along + sign * std::sqrt(std::max(under, 0.0));
      if (under > 0 && s > segment.begin && s < segment.end)
        return s;
    }
    return std::nullopt;
  }

  Vec3 outward(const Segment& segment, double distance) const override {
    return (segment.at(distance) - middle_).normalized();
  }

  double roughness() const override { return 0.02; }

  const Box3& bounds() const override { return bounds_; }

  void addTriangles(std::uint32_t material, std::vector<Triangle>& to) const override {
    constexpr int kAround = 24, kUp = 12;
    const auto at = [&](int i, int k) {
      const double turn = 2 * M_PI * i / kAround, height = M_PI * k / kUp;
      return Vec3(middle_ + kBallRadius * Vec3(std::sin(height) * std::cos(turn),
                                               std::sin(height) * std::sin(turn),
                                               std::cos(height)));
    };
    for (int i = 0; i < kAround; ++i)
      for (int k = 0; k < kUp; ++k) {
        to.push_back({{at(i, k), at(i, k + 1), at(i + 1, k + 1)}, material});
        to.push_back({{at(i, k), at(i + 1, k + 1), at(i + 1, k)}, material});
      }
  }

  std::shared_ptr<const CurvedSurface> moved(const Mat4&) const override { return nullptr; }

 private:
  Vec3 middle_{0.1, 3, 1};
  Box3 bounds_{middle_ - Vec3::Constant(kBallRadius), middle_ + Vec3::Constant(kBallRadius)};
};

/// Curved surfaces are flat pieces to a device, with the normals of what they stand for.
TEST_F(GlSceneTest, CurvedSurfacesAreLitAsByTheCpu) {
  TriangleMesh mesh = room().mesh();
  mesh.triangles.resize(2);  // the floor
  mesh.curved.push_back({std::make_shared<RoundBall>(), 1});
  const TriangleScene geometry = TriangleScene::of(std::move(mesh)).value();
  EXPECT_EQ(geometry.surfaceOf(1), nullptr);
  EXPECT_EQ(geometry.surfaceOf(2), geometry.curved()[0].surface.get());
  const auto lights = lamps();
  const SurfaceScene lit{geometry, lights, Rgb(0.02, 0.03, 0.04)};
  const Camera camera =
      Camera::pinhole({Vec3(-3.1, -2.2, 4.1), Vec3(0.1, 3, 1)}, 30, 3 * kWidth, 3 * kHeight);
  const auto expected = renderSurfaces(camera, lit, Rgb::Zero(), quiet_).value();
  const auto found = renderer_->surfaces(camera, lit, {}, Rgb::Zero(), quiet_);
  ASSERT_TRUE(found) << found.error().message;
  const float brightest = *std::ranges::max_element(expected.color.pixels);
  std::size_t off = 0, ball = 0;
  for (std::size_t i = 0; i < expected.color.pixels.size(); ++i) {
    off += std::abs(found->color.pixels[i] - expected.color.pixels[i]) > 0.02F * brightest;
    ball += expected.color.pixels[i] > 0;
  }
  EXPECT_GT(ball, 1000u);
  EXPECT_LT(static_cast<double>(off), 0.02 * static_cast<double>(ball));  // at its outline
}

/// On a pillar's top, and in the plane of its side.
TEST_F(GlSceneTest, LampsInThePlaneOfASurfaceAreThoseOfTheCpu) {
  const TriangleScene geometry = room();
  Lamp onTop, beside;
  onTop.position = Vec3(-1.4, 1.5, 2.7), onTop.intensity = Rgb(3, 2, 1);
  beside.position = Vec3(-1.6, 3.2, 1.1), beside.intensity = Rgb(1, 2, 3);
  const Lamp lamps[] = {onTop, beside};
  const SurfaceScene lit{geometry, lamps, Rgb(0.02, 0.03, 0.04)};
  const Camera camera =
      Camera::pinhole({Vec3(-3.1, -2.2, 4.1), Vec3(0.1, 3, 1)}, 45, 3 * kWidth, 3 * kHeight);
  const auto expected = renderSurfaces(camera, lit, Rgb::Zero(), quiet_).value();
  const auto found = renderer_->surfaces(camera, lit, {}, Rgb::Zero(), quiet_);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_LE(difference(found->color.pixels, expected.color.pixels), kScene);

  // In fog, too, where rays end in the lamps' peaks of light.
  const FogMedium fog = fogtest::fog(fogtest::map(9, 8, 1, 1), fogtest::profiles()[0].profile,
                                     {.degree = 2}, 0.3, 0.8);
  const LitMedium inFog =
      litFog(fog, lamps, {.scattering = {Rgb(0.9, 0.8, 0.7), 0.5}, .shadows = shadowsOf(geometry)});
  const AnyMedium medium(inFog);
  EXPECT_LE(
      errorOf(camera, {{glPart(GlLitFog{fog, inFog})}, geometry}, {&medium, 1}, {}, expected.depth),
      2e-2);
}

std::vector<Sign> signs() {
  Sign exit;
  exit.position = Vec3(0.2, 3.4, 1.8), exit.normal = Vec3(-0.3, -1, 0.2);
  exit.width = 1.2, exit.height = 0.6, exit.c = 8;
  exit.picture = exitPicture();
  Sign door = exit;
  door.position = Vec3(-0.9, 2.9, 0.9), door.normal = Vec3(0.2, -1, 0), door.c = 3;
  Sign turned = exit;
  turned.normal = Vec3(0, 1, 0);
  turned.position = Vec3(1.3, 3, 1);
  return {exit, door, turned};
}

TEST_F(GlSceneTest, SignsAreFoundAndShineThroughSmoke) {
  const auto all = signs();
  const Smoke smoke(boxMesh({Vec3(-2.1, 0.7, 0.1), Vec3(2.3, 5.2, 3.2)}, {5, 5, 4}, 0.2, 2), false,
                    0.8);
  const std::vector<AnyMedium> media{smoke.medium()};
  const Camera camera = Camera::pinhole({Vec3(-0.7, -2.2, 2.1), Vec3(0.1, 3, 1.4)}, 40, 80, 60);
  std::vector<float> wall(80 * 60, INFINITY);
  for (std::size_t i = 0; i < wall.size(); ++i) {
    if (i % 80 < 43)
      wall[i] = 5.2F;
  }
  const auto expected = signPixels(camera, all, wall);
  const auto found = renderer_->findSigns(camera, all, wall);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->size(), expected.size());
  ASSERT_GT(expected.size(), 60u);
  std::vector<float> ends = wall;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ((*found)[i].pixel, expected[i].pixel);
    EXPECT_EQ((*found)[i].sign, expected[i].sign);
    EXPECT_NEAR((*found)[i].distance, expected[i].distance, 1e-5);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR((*found)[i].radiance[c], expected[i].radiance[c], 1e-4);
    ends[expected[i].pixel] = expected[i].distance;
  }
  ASSERT_TRUE(
      renderer_->draw(camera, {{smoke.onDevice()}}, GlQuantity::kOpticalDepth, quiet_, ends));
  const float powers[] = {0.2878F, 0.7675F, 1};
  const auto light = renderer_->signLight(powers);
  ASSERT_TRUE(light);
  const Image depth =
      render(camera, media, {.renderer = Renderer::kReference, .aov = Aov::kOpticalDepth}, quiet_,
             nullptr, ends)
          .value();
  Image shown(80, 60, 3);
  for (const SignPixel& pixel : expected) {
    for (int c = 0; c < 3; ++c) {
      shown.pixels[3 * pixel.pixel + c] =
          pixel.radiance[c] * std::exp(-powers[pixel.sign] * depth.pixels[pixel.pixel]);
    }
  }
  EXPECT_LE(difference(light->pixels, shown.pixels), kScene);
}

TEST_F(GlSceneTest, BillboardsAreThoseOfTheCpu) {
  const FogMedium fog =
      fogtest::fog(fogtest::map(9, 9), fogtest::profiles()[1].profile, {.degree = 1}, 0.9, 0.6);
  for (const BillboardAlpha alpha : {BillboardAlpha::kTransmittance, BillboardAlpha::kIntensity}) {
    for (const Basis basis : {Basis::kBox, Basis::kTrilinear}) {
      const auto slice = sliceOf(3, basis);
      const double extinction = alpha == BillboardAlpha::kIntensity ? 0 : 1.5;
      BillboardOptions options{Vec3(0.4, 3, 1.6), 1.7, 1.9, 64, alpha, {}};
      if (basis == Basis::kBox)
        options.shown = {Vec3(-0.8, 2.2, 0.8), Vec3(0.9, 3.5, 2.7)};
      const Camera camera =
          Camera::pinhole({Vec3(-0.7, -2.2, 2.1), Vec3(0.2, 3, 1.4)}, 50, kWidth, kHeight);
      const AnyMedium board(
          Billboard::draw(AnyMedium(VoxelMedium(slice, 0.4, extinction)), camera, options, quiet_)
              .value());
      const GlBillboard onDevice{{slice, 0.4, extinction}, options};
      std::vector<float> wall(kWidth * kHeight, INFINITY);
      for (std::size_t i = 0; i < wall.size(); i += 5) wall[i] = 4.5F;
      const RenderOptions behind{.background = Rgb(0.5, 0.4, 0.3)};
      EXPECT_LE(errorOf(camera, {{glPart(onDevice)}}, {&board, 1}, behind, wall), kScene)
          << "alpha " << int(alpha) << ", basis " << int(basis);
      const std::vector<AnyMedium> both{AnyMedium(fog), board};
      EXPECT_LE(errorOf(camera, {{glPart(GlFog{fog}), glPart(onDevice)}}, both, behind), kScene)
          << "in fog, alpha " << int(alpha) << ", basis " << int(basis);
    }
  }
}

TEST_F(GlSceneTest, SunsLightFog) {
  const Lamp suns[] = {lampOf({Vec3(0.4, 0.2, 0.5), Rgb(3, 2.5, 2)}),
                       lampOf({Vec3(-0.2, 0.1, 1), Rgb(0.4, 0.5, 0.9)})};
  for (const auto& [name, profile] : fogtest::profiles()) {
    const int degree = name == "slab" ? 1 : 2;
    const FogMedium fog =
        fogtest::fog(fogtest::map(9, 8), profile, {.degree = degree, .color = Rgb(0.1, 0.1, 0.2)});
    for (const int count : {1, 2}) {
      if (count == 2 && name != "linear")
        continue;
      const LitMedium lit = litFog(fog, std::span(suns).first(count), {{Rgb(0.9, 0.8, 0.7), 0.5}});
      const AnyMedium medium(lit);
      const Camera camera =
          Camera::pinhole({Vec3(-4, -3, 3), Vec3(8, 9, 1.5)}, 70, kWidth, kHeight);
      EXPECT_LE(errorOf(camera, {{glPart(GlLitFog{fog, lit})}}, {&medium, 1},
                        {.background = Rgb(0.2, 0.1, 0.4)}),
                kScene)
          << name << ", suns " << count;
    }
  }
}

TEST_F(GlSceneTest, SurfacesThrowShadowsIntoSunlitFog) {
  const Lamp suns[] = {lampOf({Vec3(0.4, 0.2, 0.5), Rgb(3, 2.5, 2)}),
                       lampOf({Vec3(-0.2, 0.1, 1), Rgb(0.4, 0.5, 0.9)})};
  const TriangleScene geometry = room();
  const FogMedium fog = fogtest::fog(fogtest::map(9, 8, 1, 1), fogtest::profiles()[0].profile,
                                     {.degree = 2, .color = Rgb(0.1, 0.1, 0.2)}, 0.3, 0.8);
  const LitMedium lit = litFog(fog, suns, {{Rgb(0.9, 0.8, 0.7), 0.5}, shadowsOf(geometry)});
  const AnyMedium medium(lit);
  const Vec3 target(0.1, 3, 1);
  for (const Camera& camera :
       {Camera::pinhole({Vec3(-3.1, -2.2, 4.1), target}, 45, kWidth, kHeight),
        Camera::pinhole({Vec3(0.4, 3.1, 1.2), Vec3(-2, 5, 1.5)}, 70, kWidth, kHeight),
        Camera::orthographic({Vec3(3.2, -1.3, 2.9), target}, 6.1, kWidth, kHeight)}) {
    const auto seen = renderSurfaces(camera, {geometry}, Rgb::Zero(), quiet_).value();
    EXPECT_LE(
        errorOf(camera, {{glPart(GlLitFog{fog, lit})}, geometry}, {&medium, 1}, {}, seen.depth),
        kScene);
  }
}

/// A fire and a spot, a puff between, and surfaces.
TEST_F(GlSceneTest, LampsLightFogThroughAllMedia) {
  Lamp fire, spot;
  fire.position = Vec3(0.5, 3.4, 1.2), fire.radius = 0.3, fire.intensity = Rgb(3, 2, 1);
  spot.position = Vec3(-1.5, 4, 3), spot.direction = Vec3(0.4, -0.1, -1).normalized();
  spot.coneCosine = 0.8, spot.edge = 0.3, spot.intensity = Rgb(2, 3, 4);
  const Lamp lamps[] = {fire, spot};
  const TriangleScene geometry = room();
  const FogMedium fog = fogtest::fog(fogtest::map(9, 8, 1, 1), fogtest::profiles()[0].profile,
                                     {.degree = 2, .color = Rgb(0.1, 0.1, 0.2)}, 0.3, 0.8);
  const Smoke puff(boxMesh({Vec3(-0.5, 2.5, 0.5), Vec3(0.3, 3.3, 1.5)}, {3, 3, 3}, 0.2, 1), false,
                   2);
  const LitMedium lit = litFog(fog, lamps,
                               {.scattering = {Rgb(0.9, 0.8, 0.7), 0.5},
                                .shadows = shadowsOf(geometry),
                                .between = {AnyMedium(puff.medium())}});
  const AnyMedium medium(lit);
  const Vec3 target(0.1, 3, 1);
  for (const Camera& camera :
       {Camera::pinhole({Vec3(-3.1, -2.2, 4.1), target}, 45, kWidth, kHeight),
        Camera::pinhole({Vec3(0.4, 3.1, 1.2), Vec3(-2, 5, 1.5)}, 70, kWidth, kHeight)}) {
    const auto seen = renderSurfaces(camera, {geometry}, Rgb::Zero(), quiet_).value();
    EXPECT_LE(
        errorOf(camera, {{glPart(GlLitFog{fog, lit})}, geometry}, {&medium, 1}, {}, seen.depth),
        5e-3);
  }
}

TEST_F(GlSceneTest, FogAloneByAPolarTable) {
  const FogMedium fog = fogtest::fog(fogtest::map(19, 16), fogtest::profiles()[1].profile,
                                     {.degree = 2, .color = Rgb(0.8, 0.9, 1)});
  const Camera camera = Camera::pinhole({Vec3(-4, -3, 3), Vec3(8, 9, 1.5)}, 60, kWidth, kHeight);
  const AnyMedium exact(fog);
  const GlScene scene{{glPart(GlFog{fog, 1, anyPolar})}};
  (void)renderer_->takePasses();
  std::vector<float> wall(kWidth * kHeight, INFINITY);
  for (std::size_t i = 0; i < wall.size(); i += 3) wall[i] = 0.3F + 0.02F * float(i);
  EXPECT_LE(errorOf(camera, scene, {&exact, 1}, {.background = Rgb(0.2, 0.1, 0.4)}, wall),
            1 / 512.0);
  (void)errorOf(camera, scene, {&exact, 1}, {});
  int tables = 0, pictures = 0;
  for (const GlPassTime& pass : renderer_->takePasses()) {
    tables += pass.name == "polar table" ? pass.times : 0;
    pictures += pass.name == "polar" ? pass.times : 0;
  }
  EXPECT_EQ(tables, 1) << "for one eye";
  EXPECT_EQ(pictures, 2);
  // Where no table serves, the fog is walked.
  const FogMedium other =
      fogtest::fog(fogtest::map(9, 9), fogtest::profiles()[2].profile, {.degree = 2});
  const AnyMedium walked(other);
  EXPECT_LE(errorOf(camera, {{glPart(GlFog{other, 1, anyPolar})}}, {&walked, 1}, {}), kBar);
}

TEST_F(GlSceneTest, RaysThatAPolarTableWouldMissAreWalked) {
  SplineGrid map(256, 256);
  for (int j = 0; j < 256; ++j) {
    for (int i = 0; i < 256; ++i)
      map.at(i, j) = (i > 40 && i < 44) || (j > 160 && j < 164) ? 0.05 : 0;
  }
  const FogMedium fog =
      *FogMedium::make(*FogMap::fromCoefficients(map, {}), *FogProfile::slab(0, 10), {.degree = 1});
  const AnyMedium exact(fog);
  const GlScene scene{{glPart(GlFog{fog, 1, [](const Camera&) {
                                      return std::optional(PolarOptions{
                                          .sector = PolarSector{std::numbers::pi / 2, 0.7}});
                                    }})}};
  for (const Vec3& eye : {Vec3(128, -256, 25.6), Vec3(128, -128, 25.6), Vec3(42, -30, 4)}) {
    const Camera camera = Camera::pinhole({eye, Vec3(eye.x(), 128, 0)}, 50, kWidth, kHeight);
    EXPECT_LE(errorOf(camera, scene, {&exact, 1}, {}), 2e-4) << eye.y();
  }
}

/// One zone has level rays between two, whether they are walked or marched.
TEST_F(GlSceneTest, FogIsSeenAlongABorderOfItsProfile) {
  for (const auto& [name, profile] : fogtest::profiles()) {
    const FogMedium fog = fogtest::fog(fogtest::map(19, 16), profile, {.degree = 2});
    const AnyMedium media[] = {AnyMedium(fog), AnyMedium(fog)};
    for (const double height : {0.0, 2.0, 3.0, 4.0, 6.0}) {
      const double z = 0.5 + height;
      const Camera camera = Camera::pinhole({Vec3(-4, -3, z), Vec3(8, 9, z)}, 60, kWidth, 31);
      for (const std::size_t count : {1, 2}) {
        EXPECT_LE(errorOf(camera, {std::vector(count, glPart(GlFog{fog}))}, {media, count}, {}),
                  kBar)
            << name << ", " << count << " at " << height;
      }
    }
  }
}

/// Any profile, degree and number of levels; what is behind thick fog counts where depths are asked
/// for, and where a factor thins it.
TEST_F(GlSceneTest, FogAloneIsWalked) {
  const Camera near = Camera::pinhole({Vec3(-4, -3, 3), Vec3(8, 9, 1.5)}, 60, kWidth, kHeight);
  const Camera within = Camera::pinhole({Vec3(4, 6, 1), Vec3(8, 9, 1.5)}, 80, kWidth, kHeight);
  std::vector<float> wall(kWidth * kHeight, INFINITY);
  for (std::size_t i = 0; i < wall.size(); i += 3) wall[i] = 0.3F + 0.02F * float(i);
  (void)renderer_->takePasses();
  int pictures = 0;
  for (const auto& [name, profile] : fogtest::profiles()) {
    for (const int degree : {0, 2, 3}) {
      const FogOptions options{
          .degree = degree, .levels = 2, .detail = {.mu = 0.6}, .color = Rgb(0.8, 0.9, 1)};
      const FogMedium thin = fogtest::fog(fogtest::map(19, 16), profile, options);
      const FogMedium thick = fogtest::fog(fogtest::map(19, 16), profile, options, 60);
      for (const Camera& camera : {near, within}) {
        const AnyMedium exact(thin);
        EXPECT_LE(errorOf(camera, {{glPart(GlFog{thin})}}, {&exact, 1},
                          {.background = Rgb(0.2, 0.1, 0.4)}, wall),
                  kBar)
            << name << degree;
        const AnyMedium scaled(ScaledMedium(AnyMedium(thick), 0.02));
        EXPECT_LE(errorOf(camera, {{glPart(GlFog{thick, 0.02})}}, {&scaled, 1}, {}), kBar)
            << name << degree;
        const AnyMedium depths(thick);
        EXPECT_LE(
            errorOf(camera, {{glPart(GlFog{thick})}}, {&depths, 1}, {.aov = Aov::kOpticalDepth}),
            kBar)
            << name << degree;
        pictures += 3;
      }
    }
  }
  int walks = 0;
  for (const GlPassTime& pass : renderer_->takePasses()) {
    walks += pass.name == "walk" ? pass.times : 0;
    EXPECT_NE(pass.name, "march");
  }
  EXPECT_EQ(walks, pictures);
}

TEST_F(GlSceneTest, FogWithATopAndFogWithLevelsByAngle) {
  SplineGrid scaled = fogtest::map(12, 11);
  for (double& value : scaled.c) value *= 0.3;
  const FogMap map = *FogMap::fromCoefficients(scaled, {.origin = Vec3(-3, 2, 0.5), .cell = 1.3});
  FogMap top = *FogMap::fromCoefficients(fogtest::map(6, 6, 4, 1),
                                         {.origin = Vec3(-2.4, 2.7, 0), .cell = 2.1});
  for (double& height : top.coefficients.c) height = 1 + 4 * height;
  const Vec3 eyes[] = {Vec3(-6, -3, 5), Vec3(3.1, 5.2, 1.7)};
  for (const auto& [name, profile] : fogtest::profiles()) {
    const FogMedium topped = *FogMedium::make(map, profile, {.degree = 2}, top);
    const FogMedium coarse =
        *FogMedium::make(map, profile, {.degree = 1, .levels = 3, .detail = {.cellAngle = 0.3}});
    for (const FogMedium& fog : {topped, coarse}) {
      const AnyMedium medium(fog);
      for (const Vec3& eye : eyes) {
        const Camera camera = Camera::pinhole({eye, Vec3(4, 8, 1.5)}, 70, kWidth, kHeight);
        EXPECT_LE(errorOf(camera, {{glPart(GlFog{fog})}}, {&medium, 1},
                          {.background = Rgb(0.2, 0.1, 0.4)}),
                  kBar)
            << name << (fog.hasTop() ? ", top" : ", levels") << ", eye " << eye;
      }
    }
  }
}

TEST_F(GlSceneTest, FogByAFactor) {
  const FogMedium fog =
      fogtest::fog(fogtest::map(9, 8), fogtest::profiles()[1].profile, {.degree = 1});
  const AnyMedium medium(ScaledMedium(AnyMedium(fog), 0.7675));
  const Camera camera = Camera::pinhole({Vec3(-4, -3, 3), Vec3(8, 9, 1.5)}, 70, kWidth, kHeight);
  EXPECT_LE(errorOf(camera, {{glPart(GlFog{fog, 0.7675})}}, {&medium, 1}, {}), kBar);
}

}  // namespace
}  // namespace volute
