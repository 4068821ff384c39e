// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_testing.hpp"
#include "volute/grid/sequence.hpp"
#include "volute/medium/affine_medium.hpp"

namespace volute {
using namespace gltest;

namespace {

TEST_F(GlRendererTest, VolumesAreThoseOfTheReference) {
  int pictures = 0;
  for (const Basis basis : {Basis::kBox, Basis::kTrilinear}) {
    for (const int channels : {1, 3}) {
      for (const double extinction : {0.0, 1.5, 40.0}) {
        const auto slice = sliceOf(channels, basis);
        const AnyMedium medium(VoxelMedium(slice, 1.3, extinction));
        const GlScene scene{{glPart(GlVolume{slice, 1.3, extinction})}};
        const auto views = cameras(medium.bounds());
        for (const Camera& camera : views) {
          if (++pictures % 3 != 0 && &camera != &views[0])
            continue;  // every camera comes with every basis, but not with everything
          const double error =
              errorOf(camera, scene, {&medium, 1}, {.background = Rgb(0.1, 0.2, 0.3)});
          EXPECT_LE(error, kBar) << "basis " << int(basis) << ", channels " << channels
                                 << ", extinction " << extinction;
        }
      }
    }
  }
}

TEST_F(GlRendererTest, OpticalDepthsAreThoseOfTheReference) {
  const auto slice = sliceOf(3, Basis::kTrilinear);
  const AnyMedium medium(VoxelMedium(slice, 1, 30));
  const Camera camera = Camera::framing(medium.bounds(), kWidth, kHeight);
  for (const Aov aov : {Aov::kOpticalDepth, Aov::kTransmittance})
    EXPECT_LE(errorOf(camera, {{glPart(GlVolume{slice, 1, 30})}}, {&medium, 1}, {.aov = aov}),
              1e-4);
}

TEST_F(GlRendererTest, VolumesMayBeTurnedMirroredAndSheared) {
  const auto slice = sliceOf(1, Basis::kTrilinear);
  Mat3 turn;
  turn = Mat3(0.6, 0, 0.8, 0, -1, 0, 0.8, 0, -0.6);
  Mat3 shear;
  shear = Mat3(1, 0.4, 0, 0, 1.5, 0.2, 0, 0, 0.7);
  const Vec3 offset(0.3, 6, 1.5);
  for (const Mat3& place : {turn, Mat3(turn * shear)}) {
    const AnyMedium medium(AffineMedium(AnyMedium(VoxelMedium(slice, 1, 2)), {place, offset}));
    for (const Camera& camera : cameras(medium.bounds()))
      EXPECT_LE(errorOf(camera, {{glPart(GlVolume{slice, 1, 2, place, offset})}}, {&medium, 1}, {}),
                kBar);
  }
}

TEST_F(GlRendererTest, OpaqueSurfacesHideWhatIsBehindThem) {
  const auto slice = sliceOf(1, Basis::kTrilinear);
  const AnyMedium medium(VoxelMedium(slice, 1, 2));
  const Camera camera = Camera::framing(medium.bounds(), kWidth, kHeight);
  std::vector<float> depth(kWidth * kHeight, INFINITY);
  const auto middle = float((medium.bounds().centre() - camera.eye()).norm());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x)
      depth[y * kWidth + x] = middle + 0.02F * float(y - kHeight / 2);
  }
  const RenderOptions options{.background = Rgb(0.5, 0.4, 0.3)};
  EXPECT_LE(errorOf(camera, {{glPart(GlVolume{slice, 1, 2})}}, {&medium, 1}, options, depth), kBar);
  Image behind(kWidth, kHeight);
  for (std::size_t i = 0; i < behind.pixels.size(); ++i) behind.pixels[i] = 0.001F * float(i % 97);
  EXPECT_LE(
      errorOf(camera, {{glPart(GlVolume{slice, 1, 2})}}, {&medium, 1}, {.behind = &behind}, depth),
      kBar);
}

TEST_F(GlRendererTest, TheTreeIsWalkedInPlace) {
  for (const int channels : {1, 3}) {
    VolumeInfo info = infoOf(channels, Basis::kBox);
    info.frames = 3;
    info.fillDefaults();
    Sequence sequence{info, {}};
    for (int t = 0; t < info.frames; ++t) {
      const auto values = blobs(info, t);
      sequence.values.insert(sequence.values.end(), values.begin(), values.end());
    }
    SequenceSource source(sequence);
    const auto tree = std::make_shared<const Tree4d>(
        Tree4d::build(source, {.relativeRms = 2e-3}, quiet_).value());
    for (const Basis basis : {channels == 1 ? Basis::kBox : Basis::kTrilinear}) {
      for (int frame = 0; frame < info.frames; frame += 2) {
        BrickSlice slice = tree->extractSlice(frame);
        slice.setBasis(basis);
        const AnyMedium medium(
            VoxelMedium(std::make_shared<const BrickSlice>(std::move(slice)), 1, 1.5));
        GlTreeVolume volume{tree, frame, basis, info.bounds, 1, 1.5};
        for (const GlTreeSkip skip :
             {GlTreeSkip::kBricks, GlTreeSkip::kBox, GlTreeSkip::kNothing}) {
          volume.skip = skip;
          EXPECT_LE(errorOf(Camera::framing(info.bounds, kWidth, kHeight), {{glPart(volume)}},
                            {&medium, 1}, {}),
                    kBar)
              << "channels " << channels << ", basis " << int(basis) << ", frame " << frame
              << ", skip " << int(skip);
        }
      }
    }
  }
}

TEST_F(GlRendererTest, FogIsThatOfTheReference) {
  int cases = 0;
  const SplineGrid map = fogtest::map(9, 8);
  for (int degree = 0; degree <= 3; ++degree) {
    for (const auto& [name, profile] : fogtest::profiles()) {
      for (const double mu : {1.0, 0.5}) {
        if (++cases % 3 != 0)
          continue;  // a shader of its own for each takes its time; every value comes with several
                     // others
        const FogMedium fog = fogtest::fog(map, profile,
                                           {.degree = degree,
                                            .levels = mu < 1 ? 2 : 0,
                                            .detail = {.mu = mu},
                                            .color = Rgb(0.8, 0.9, 1)});
        const AnyMedium medium(fog);
        const Camera camera =
            Camera::pinhole({Vec3(-4, -3, 3), Vec3(8, 9, 1.5)}, 70, kWidth, kHeight);
        EXPECT_LE(errorOf(camera, {{glPart(GlFog{fog})}}, {&medium, 1},
                          {.background = Rgb(0.2, 0.1, 0.4)}),
                  kBar)
            << "degree " << degree << ", " << name << ", mu " << mu;
      }
    }
  }
}

TEST_F(GlRendererTest, FogFromParallelRays) {
  const FogMedium fog =
      fogtest::fog(fogtest::map(15, 12), fogtest::profiles()[1].profile, {.degree = 2});
  const AnyMedium medium(fog);
  const Camera camera = Camera::orthographic({Vec3(6, 9, 3), Vec3(10, 14, 1)}, 12, kWidth, kHeight);
  EXPECT_LE(errorOf(camera, {{glPart(GlFog{fog})}}, {&medium, 1}, {}), kBar);
}

/// Two volumes and two fogs that overlap, and a wall's depth through them.
TEST_F(GlRendererTest, MediaThatOverlapAreCompositedAsTheReferenceDoes) {
  for (const Basis basis : {Basis::kTrilinear}) {
    const auto fire = sliceOf(3, basis);
    VolumeInfo info = infoOf(1, Basis::kTrilinear);
    info.bounds = {Vec3(-0.5, 2.5, 0), Vec3(1.8, 4.5, 2)};
    const auto smoke = std::make_shared<const BrickSlice>(BrickSlice::fromDense(info, blobs(info)));
    const FogMedium ground = fogtest::fog(fogtest::map(9, 9), fogtest::profiles()[1].profile,
                                          {.degree = 2, .color = Rgb(0.7, 0.8, 0.9)}, 0.9, 0.6);
    const FogMedium layer = fogtest::fog(fogtest::map(8, 8, 4), fogtest::profiles()[2].profile,
                                         {.degree = 1, .color = Rgb(0.9, 0.5, 0.2)}, 0.5, 0.7);
    const std::vector<AnyMedium> media{AnyMedium(VoxelMedium(fire, 2, 3)),
                                       AnyMedium(VoxelMedium(smoke, 0.2, 4)), AnyMedium(ground),
                                       AnyMedium(layer)};
    const GlScene scene{{glPart(GlVolume{fire, 2, 3}), glPart(GlVolume{smoke, 0.2, 4}),
                         glPart(GlFog{ground}), glPart(GlFog{layer})}};
    const Camera camera =
        Camera::pinhole({Vec3(0.2, -1, 2.6), Vec3(0.3, 3.2, 1.2)}, 50, kWidth, kHeight);
    std::vector<float> wall(kWidth * kHeight, INFINITY);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Segment ray = camera.ray(x + 0.5, y + 0.5);
        const double s = (3.3 - ray.origin.y() - 0.3 * ray.origin.x()) /
                         (ray.direction.y() + 0.3 * ray.direction.x());
        if (x < 2 * kWidth / 3 && s > 0)
          wall[y * kWidth + x] = float(s);
      }
    }
    EXPECT_LE(errorOf(camera, scene, media, {.background = Rgb(0.1, 0.2, 0.5)}, wall), kBar);
    EXPECT_LE(errorOf(camera, scene, media, {.aov = Aov::kOpticalDepth}, wall), 1e-4);
  }
}

TEST_F(GlRendererTest, SmokeIsThatOfTheReference) {
  const auto box = boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {6, 5, 4}, 0.3, 5);
  for (const bool lit : {false, true}) {
    for (const double thick : {0.8, 25.0}) {
      const Smoke smoke(box, lit, thick);
      const AnyMedium medium = smoke.medium();
      for (const Camera& camera : cameras(medium.bounds())) {
        EXPECT_LE(
            errorOf(camera, {{smoke.onDevice()}}, {&medium, 1}, {.background = Rgb(0.3, 0.5, 0.1)}),
            kBar)
            << "lit " << lit << ", thick " << thick << ", eye " << camera.eye();
      }
    }
  }
}

TEST_F(GlRendererTest, EveryWayToDrawSmokeIsTheReference) {
  const auto box = boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {6, 5, 4}, 0.3, 5);
  for (const bool lit : {false, true}) {
    const Smoke smoke(box, lit, 3);
    const AnyMedium medium = smoke.medium();
    for (const Camera& camera : cameras(medium.bounds())) {
      std::vector<float> wall(static_cast<std::size_t>(camera.width()) * camera.height(), INFINITY);
      const double middle = (medium.bounds().centre() - camera.eye()).norm();
      for (std::size_t i = 0; i < wall.size(); i += 2)
        wall[i] = static_cast<float>(middle * (0.7 + 0.0005 * double(i % 999)));
      for (const auto method : {GlSmokeMethod::kMarch, GlSmokeMethod::kProject}) {
        (void)renderer_->takePasses();
        const GlScene scene{{smoke.onDevice(method)}};
        EXPECT_LE(errorOf(camera, scene, {&medium, 1}, {.background = Rgb(0.3, 0.5, 0.1)}, wall),
                  kBar)
            << "lit " << lit << ", method " << int(method) << ", eye " << camera.eye();
        const auto passes = renderer_->takePasses();
        const bool lens = !camera.distortion().none();
        const char* pass = lens || method == GlSmokeMethod::kMarch ? "march" : "draw tetrahedra";
        EXPECT_TRUE(std::ranges::any_of(passes, [&](const GlPassTime& time) {
          return time.name == pass && time.media == "smoke";
        })) << pass;
      }
    }
  }
}

TEST_F(GlRendererTest, SmokeInAHallThatRaysLeaveAndReEnter) {
  const Smoke smoke(hallMesh(2.5, 3), true, 0.1);
  const AnyMedium medium = smoke.medium();
  const Box3 hall = medium.bounds();
  const Camera outside = Camera::framing(hall, kWidth, kHeight);
  const Camera inside = Camera::pinhole({hall.min + Vec3(2.3, 6.1, 1.7), hall.max - Vec3(1, 4, 3)},
                                        60, kWidth, kHeight);
  std::vector<float> wall(kWidth * kHeight, 9.0F);
  for (const Camera& camera : {outside, inside}) {
    EXPECT_LE(errorOf(camera, {{smoke.onDevice()}}, {&medium, 1}, {}), kBar);
    EXPECT_LE(errorOf(camera, {{smoke.onDevice()}}, {&medium, 1}, {.aov = Aov::kOpticalDepth}),
              kBar);
  }
  EXPECT_LE(errorOf(inside, {{smoke.onDevice()}}, {&medium, 1}, {}, wall), kBar);
}

TEST_F(GlRendererTest, SmokeVolumeAndFogOverlap) {
  const Smoke smoke(boxMesh({Vec3(-0.8, 2.2, 0.6), Vec3(1, 3.5, 2.9)}, {4, 4, 5}, 0.2, 2), true,
                    1.5);
  const auto fire = sliceOf(3, Basis::kTrilinear);
  const FogMedium fog =
      fogtest::fog(fogtest::map(9, 9), fogtest::profiles()[1].profile, {.degree = 1}, 0.9, 0.6);
  const std::vector<AnyMedium> media{AnyMedium(VoxelMedium(fire, 2, 3)), AnyMedium(fog),
                                     smoke.medium()};
  const GlScene scene{{glPart(GlVolume{fire, 2, 3}), glPart(GlFog{fog}), smoke.onDevice()}};
  const Camera camera =
      Camera::pinhole({Vec3(0.2, -1, 2.6), Vec3(0.3, 3.2, 1.2)}, 50, kWidth, kHeight);
  EXPECT_LE(errorOf(camera, scene, media, {.background = Rgb(0.1, 0.2, 0.5)}), kBar);
}

TEST_F(GlRendererTest, RefusesWhatItCannotRender) {
  const FogMedium fog = fogtest::fog(fogtest::map(9, 9), fogtest::profiles()[0].profile, {});
  const Lamp sun = lampOf({});
  const LitMedium among =
      litFog(fog, {&sun, 1}, {{}, [](const Segment&, const Lamp&, std::vector<Interval>&) {}});
  const Camera camera = Camera::framing({Vec3(0, 0, 0), Vec3(1, 1, 1)}, 16, 16);
  const auto image = renderer_->render(camera, {{glPart(GlLitFog{fog, among})}}, {}, quiet_);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().code, ErrorCode::kUnsupported);
  const std::vector<float> wrong(5, 1.0F);
  EXPECT_EQ(renderer_->render(camera, {}, {}, quiet_, nullptr, wrong).error().code,
            ErrorCode::kInvalidArgument);
}

TEST_F(GlRendererTest, AnEmptySceneIsItsBackground) {
  const VolumeInfo info = infoOf(1, Basis::kBox);
  const auto nothing = std::make_shared<const BrickSlice>(info);
  const Camera camera = Camera::framing(info.bounds, 16, 16);
  for (const GlScene& scene : {GlScene{}, GlScene{{glPart(GlVolume{nothing, 1, 1})}}}) {
    const Image image =
        renderer_->render(camera, scene, {.background = Rgb(0.25, 0.5, 1)}, quiet_).value();
    for (std::size_t i = 0; i < image.pixels.size(); i += 3) EXPECT_EQ(image.pixels[i], 0.25F);
  }
}

}  // namespace
}  // namespace volute
