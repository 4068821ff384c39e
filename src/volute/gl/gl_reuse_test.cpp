// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include "volute/gl/gl_programs.hpp"
#include "volute/gl/gl_testing.hpp"

// What a picture need not do again that the one before it has done.

namespace volute {
using namespace gltest;

namespace {

int timesOf(const std::vector<GlPassTime>& passes, std::string_view name) {
  int times = 0;
  for (const GlPassTime& pass : passes) times += pass.name == name ? pass.times : 0;
  return times;
}

class GlReuseTest : public GlRendererTest {
 protected:
  /// How often a pass was run for this picture.
  int timesFor(const GlScene& scene, std::string_view pass, const RenderOptions& options = {}) {
    (void)renderer_->takePasses();
    EXPECT_TRUE(renderer_->render(camera_, scene, options, quiet_));
    return timesOf(renderer_->takePasses(), pass);
  }

  static GlCounts countsOf(const std::string& way) {
    const auto found = renderer_->counts().find(way);
    return found == renderer_->counts().end() ? GlCounts() : found->second;
  }

  Camera camera_ = Camera::pinhole({Vec3(-4, -3, 3), Vec3(8, 9, 1.5)}, 70, 8, 8);
};

TEST_F(GlReuseTest, SlidersOfFogLinkAndUploadOnce) {
  const FogMedium fog = fogtest::fog(fogtest::map(9, 8), fogtest::profiles()[0].profile, {});
  for (const bool polar : {false, true}) {
    int links = 0, uploads = 0;
    for (int step = 0; step < 50; ++step) {
      const FogProfile::Knot knots[] = {{0.01 * step, 1}, {2 + 0.1 * step, 1 - 0.01 * step}};
      const FogProfile profile = FogProfile::linear(knots).value();
      GlFog shown{fog.withProfile(profile).shifted(Vec3(0.02 * step, 0, 0)), 1 - 0.01 * step};
      if (polar)
        shown.polar = anyPolar;
      const GlScene scene{{glPart(shown)}};
      (void)renderer_->takePasses();
      ASSERT_TRUE(renderer_->render(camera_, scene, {}, quiet_));
      const auto passes = renderer_->takePasses();
      links += timesOf(passes, "link");
      uploads += timesOf(passes, "upload");
      EXPECT_EQ(timesOf(passes, "polar"), polar ? 1 : 0);
    }
    EXPECT_LE(links, polar ? 2 : 1);
    EXPECT_LE(uploads, 1);
  }
}

TEST_F(GlReuseTest, SlidersOfColorsAndOfVolumesLinkOnce) {
  const auto slice = sliceOf(1, Basis::kTrilinear);
  int links[2] = {};
  for (int step = 0; step < 50; ++step) {
    const FogMedium fog = fogtest::fog(fogtest::map(5, 4), fogtest::profiles()[2].profile,
                                       {.degree = 2, .color = Rgb(0.02 * step, 1, 1)});
    links[0] += timesFor({{glPart(GlFog{fog})}}, "link");
    links[1] += timesFor({{glPart(GlVolume{slice, 1 + 0.1 * step, 2 + 0.03 * step})}}, "link");
  }
  EXPECT_LE(links[0], 1);
  EXPECT_LE(links[1], 1);
}

/// Each medium twice; what is the same is not uploaded again, what has changed is, and shows.
TEST_F(GlReuseTest, WhatHasNotChangedStaysOnTheDevice) {
  const Smoke smoke(boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {4, 3, 3}, 0.2, 1), true, 2);
  const Camera camera = Camera::framing(smoke.medium().bounds(), kWidth, kHeight);
  for (const auto method : {GlSmokeMethod::kMarch, GlSmokeMethod::kProject}) {
    const RenderOptions depths{.aov = Aov::kOpticalDepth};
    const GlScene scene{{smoke.onDevice(method)}};
    const GlScene changed = scene.scaled(2);
    const Image before = renderer_->render(camera, scene, depths, quiet_).value();
    (void)renderer_->takePasses();
    const GlCounts counts = countsOf("projected_tetrahedra");
    EXPECT_EQ(renderer_->render(camera, scene, depths, quiet_).value().pixels, before.pixels);
    EXPECT_EQ(timesOf(renderer_->takePasses(), "upload"), 0) << int(method);
    const Image after = renderer_->render(camera, changed, depths, quiet_).value();
    double brightest = 0, worst = 0;
    for (std::size_t i = 0; i < after.pixels.size(); ++i) {
      brightest = std::max<double>(brightest, after.pixels[i]);
      worst = std::max<double>(worst, std::abs(after.pixels[i] - 2 * before.pixels[i]));
    }
    EXPECT_LE(worst, 2e-3 * brightest) << int(method);
    EXPECT_GT(brightest, 0.1);
    if (method != GlSmokeMethod::kProject) {
      EXPECT_EQ(timesOf(renderer_->takePasses(), "upload"), 1) << int(method);
      continue;
    }
    const GlCounts later = countsOf("projected_tetrahedra");
    ASSERT_EQ(later.size(), counts.size());
    EXPECT_EQ(later[0], counts[0]) << "sorts";
    EXPECT_EQ(later[1], GlCounts::value_type("uploads", counts[1].second + 1)) << "the fields";
    EXPECT_EQ(later[2], GlCounts::value_type("pictures", counts[2].second + 2));
  }
}

TEST_F(GlReuseTest, SunsAreUploadedOnce) {
  const FogMedium fog = fogtest::fog(fogtest::map(9, 8), fogtest::profiles()[0].profile, {});
  const Lamp sun = lampOf({Vec3(0.4, 0.2, 0.5), Rgb(3, 2.5, 2)});
  const GlScene scene{{glPart(GlLitFog{fog, litFog(fog, {&sun, 1}, {})})}};
  EXPECT_EQ(timesFor(scene, "upload"), 2) << "the map and the sun";
  EXPECT_EQ(timesFor(scene, "upload"), 0);
  EXPECT_EQ(timesFor(scene.scaled(0.5), "upload"), 0);
}

/// Parts of the surfaces between two pictures of what lights come through.
TEST_F(GlReuseTest, SurfacesLeaveThePictureAndWhatMediaHold) {
  const Smoke smoke(boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {4, 3, 3}, 0.2, 1), true, 2);
  const GlScene scene{{glPart(GlVolume{sliceOf(1, Basis::kTrilinear), 1, 2}), smoke.onDevice()}};
  const auto floor =
      TriangleScene::build({{{Vec3(-3, -3, 0), Vec3(3, -3, 0), Vec3(0, 5, 0)}, 0}}, {Material{}});
  ASSERT_TRUE(floor);
  Lamp lamp;
  lamp.kind = Lamp::Kind::kSun;
  lamp.direction = Vec3(0, 0.6, -0.8);
  lamp.intensity = Rgb(1, 1, 1);
  const Camera camera = Camera::framing(smoke.medium().bounds(), kWidth, kHeight);
  const Image before = renderer_->render(camera, scene, {}, quiet_).value();
  (void)renderer_->takePasses();
  const GLuint shown = renderer_->texture();
  const GlWalls walls{.mesh = {smoke.locator, &smoke.locator->mesh()},
                      .media = {{smoke.onDevice()}},
                      .ambient = Rgb::Ones()};
  for (const int size : {8, 24, 16}) {
    const Camera part = Camera::framing(smoke.medium().bounds(), size, size);
    const auto seen = renderer_->surfaces(part, {*floor, {&lamp, 1}}, scene, Rgb::Zero(), quiet_);
    ASSERT_TRUE(seen);
    EXPECT_GT(seen->surfacePixels, 0);
    EXPECT_TRUE(renderer_->walls(part, walls, quiet_));
    EXPECT_EQ(renderer_->texture(), shown);
  }
  EXPECT_EQ(renderer_->render(camera, scene, {}, quiet_).value().pixels, before.pixels);
  EXPECT_EQ(timesOf(renderer_->takePasses(), "upload"), 0);
}

TEST_F(GlReuseTest, ProgramsOfLongAgoAreEnded) {
  GlPrograms programs;
  GlPasses passes;
  const auto use = [&](const char* key) {
    EXPECT_TRUE(programs.get(key, "", passes, [] {
      return std::vector<ShaderPart>{{"empty", "layout(local_size_x = 1) in;\nvoid main() {}\n"}};
    }));
  };
  use("once");
  for (int picture = 0; picture < GlPrograms::kKeptPictures; ++picture) {
    use("always");
    programs.pictureDone();
  }
  EXPECT_EQ(programs.size(), 2U);
  programs.pictureDone();
  EXPECT_EQ(programs.size(), 1U);
  use("always");
  EXPECT_EQ(timesOf(passes.take(), "link"), 2);
}

/// The message of what does not fit.
class GlLimitsTest : public GlRendererTest {
 protected:
  std::string refusal(const GlScene& scene) {
    const Camera camera = Camera::framing({Vec3(0, 0, 0), Vec3(1, 1, 1)}, 8, 8);
    const auto image = renderer_->render(camera, scene, {}, quiet_);
    EXPECT_FALSE(image);
    if (image)
      return {};
    EXPECT_EQ(image.error().code, ErrorCode::kTooLarge) << image.error().message;
    return image.error().message;
  }
};

TEST_F(GlLimitsTest, TooManyMediaAreRefusedByCounting) {
  const Smoke smoke(boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {2, 2, 2}, 0.2, 1), true, 2);
  GlScene smokes, volumes;
  for (std::int64_t i = 0; i <= gl_->device().storageBindings / 6; ++i)
    smokes.parts.push_back(smoke.onDevice());
  const auto slice = sliceOf(1, Basis::kBox);
  for (std::int64_t i = 0; i <= gl_->device().textureUnits / 2; ++i)
    volumes.parts.push_back(glPart(GlVolume{slice, 1, 1}));
  EXPECT_NE(refusal(smokes).find("buffers at a time"), std::string::npos);
  EXPECT_NE(refusal(volumes).find("textures"), std::string::npos);
}

TEST_F(GlLimitsTest, WhatIsLongerThanTexturesIsRefused) {
  const int side = static_cast<int>(gl_->device().largestTexture) + 8;
  const FogMedium fog = fogtest::fog(SplineGrid(side, 2), fogtest::profiles()[0].profile, {});
  EXPECT_NE(refusal({{glPart(GlFog{fog})}}).find("a fog map of"), std::string::npos);
}

/// Just below what is refused for its length, pictures are right: software rasterisers end loops.
/// Parallel rays march through fog, those of an eye walk.
TEST_F(GlLimitsTest, LongWaysAreDrawnRightOrRefused) {
  int refused = 0;
  const auto check = [&](const std::string& name, const AnyMedium& medium, const GlScene& scene,
                         double height, bool parallel) {
    Vec3 from = medium.bounds().centre();
    from.z() = height;
    const Vec3 to = from + Vec3(1, 0, 0);
    from.x() = medium.bounds().min.x() - 1;
    const Camera camera = parallel ? Camera::orthographic({from, to}, 0.02, 8, 8)
                                   : Camera::pinhole({from, to}, 1e-3, 8, 8);
    const RenderOptions depths{.aov = Aov::kOpticalDepth};
    const auto image = renderer_->render(camera, scene, depths, quiet_);
    if (!image) {
      EXPECT_EQ(image.error().code, ErrorCode::kTooLarge) << image.error().message;
      EXPECT_FALSE(gl_->device().hardware);
      ++refused;
      return;
    }
    const Image expected = render(camera, {&medium, 1}, depths, quiet_).value();
    EXPECT_NEAR(image->pixels[36], expected.pixels[36], 1e-3 * expected.pixels[36]) << name;
  };
  for (const int length : {3000, 5000, 5400, 5890, 9000, 12000}) {
    VolumeInfo info = infoOf(1, Basis::kTrilinear);
    info.x = length, info.y = info.z = 1;
    info.bounds = {Vec3(0, 0, 0), Vec3(0.01 * length, 1, 1)};
    const auto slice = std::make_shared<const BrickSlice>(
        BrickSlice::fromDense(info, std::vector<float>(length, 1.0F)));
    check(fmt::format("volume {}", length), AnyMedium(VoxelMedium(slice, 1, 0.1)),
          {{glPart(GlVolume{slice, 1, 0.1})}}, 0.5, true);
    SplineGrid even(length, 3);
    std::ranges::fill(even.c, 1);
    for (const auto& [profileName, profile] : fogtest::profiles()) {
      for (const bool parallel : {true, false}) {
        const FogMedium fog = fogtest::fog(even, profile, {.degree = 3}, 0.01, 0.05);
        check(fmt::format("fog {} {} {}", length, profileName, parallel), AnyMedium(fog),
              {{glPart(GlFog{fog})}}, 2, parallel);
      }
    }
  }
  EXPECT_TRUE(refused > 0 || gl_->device().hardware);
}

TEST_F(GlLimitsTest, APolarTableCanBeStopped) {
  struct StopsLater final : Progress {
    bool cancelled() const override { return ++asked > 3; }

    mutable int asked = 0;
  } progress;

  const FogMedium fog =
      fogtest::fog(fogtest::map(2000, 300), fogtest::profiles()[0].profile, {.degree = 1});
  const GlScene scene{{glPart(GlFog{fog, 1, anyPolar})}};
  const Camera camera = Camera::pinhole({Vec3(-4, -3, 3), Vec3(8, 9, 1.5)}, 70, 8, 8);
  const auto image = renderer_->render(camera, scene, {}, progress);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace volute
