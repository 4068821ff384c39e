// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <numbers>

#include "volute/fds/fds_field.hpp"
#include "volute/gl/gl_billboard.hpp"
#include "volute/gl/gl_fds.hpp"
#include "volute/gl/gl_testing.hpp"
#include "volute/grid/sequence.hpp"
#include "volute/render/billboard.hpp"
#include "volute/render/sign.hpp"
#include "volute/render/surfaces.hpp"

// Pictures from eyes that are many sizes of the scene away, and of scenes far from the coordinates'
// origin.

namespace volute {

using namespace gltest;

namespace {

/// In sizes of what is looked at.
constexpr double kDistances[] = {1, 2, 10, 100, 290, 1e3, 1e4, 1e5};

/// As maps of a country have them: metres in a zone of the transverse Mercator projection.
const Vec3 kFarOrigin(500'000, 4'500'000, 1200);

struct Thing {
  std::string name;
  AnyMedium medium;
  GlScene scene;
};

std::shared_ptr<const BrickSlice> sliceAt(int channels, Basis basis, const Vec3& offset) {
  VolumeInfo info = infoOf(channels, basis);
  info.bounds.min += offset, info.bounds.max += offset;
  return std::make_shared<const BrickSlice>(BrickSlice::fromDense(info, blobs(info)));
}

Thing volumeAt(const Vec3& offset, int channels, Basis basis) {
  const auto slice = sliceAt(channels, basis, offset);
  return {basis == Basis::kBox ? "volume, box" : "volume, trilinear",
          AnyMedium(VoxelMedium(slice, 1.3, 1.5)),
          {{glPart(GlVolume{slice, 1.3, 1.5})}}};
}

Thing treeAt(const Vec3& offset) {
  VolumeInfo info = infoOf(1, Basis::kTrilinear);
  info.bounds.min += offset, info.bounds.max += offset;
  info.fillDefaults();
  Sequence sequence{info, blobs(info)};
  SequenceSource source(sequence);
  Progress quiet;
  const auto tree =
      std::make_shared<const Tree4d>(Tree4d::build(source, {.relativeRms = 2e-3}, quiet).value());
  BrickSlice slice = tree->extractSlice(0);
  slice.setBasis(info.basis);
  return {"tree",
          AnyMedium(VoxelMedium(std::make_shared<const BrickSlice>(std::move(slice)), 1, 1.5)),
          {{glPart(GlTreeVolume{tree, 0, info.basis, info.bounds, 1, 1.5})}}};
}

/// A box of 6 m, whose boundary lies in planes across axes.
Thing smokeAt(const Vec3& offset, bool lit, GlSmokeMethod method) {
  const Box3 box{Vec3(-3, -3, -3) + offset, Vec3(3, 3, 3) + offset};
  const Smoke smoke(boxMesh(box, {5, 5, 5}, 0.2, 2), lit, 0.4);
  constexpr const char* kNames[] = {"smoke", "marched smoke", "projected smoke"};
  return {kNames[static_cast<int>(method)], smoke.medium(), {{smoke.onDevice(method)}}};
}

FogMedium fogAt(const Vec3& offset, int levels) {
  SplineGrid scaled = fogtest::map(9, 8, 1, 1);
  for (double& value : scaled.c) value *= 0.3;
  const FogMap map =
      *FogMap::fromCoefficients(scaled, {.origin = Vec3(-3, 2, 0.5) + offset, .cell = 1.3});
  return *FogMedium::make(map, fogtest::profiles()[1].profile,
                          {.degree = 2, .levels = levels, .color = Rgb(0.7, 0.8, 0.9)});
}

Thing plainFogAt(const Vec3& offset) {
  const FogMedium fog = fogAt(offset, 1);
  return {"fog", AnyMedium(fog), {{glPart(GlFog{fog})}}};
}

Thing polarFogAt(const Vec3& offset) {
  const FogMedium fog = fogAt(offset, 1);
  return {"fog by a polar table", AnyMedium(fog), {{glPart(GlFog{fog, 1, anyPolar})}}};
}

Thing sunlitFogAt(const Vec3& offset) {
  const Lamp sun = lampOf({Vec3(0.4, 0.2, 0.5), Rgb(3, 2.5, 2)});
  const FogMedium fog = fogAt(offset, 1);
  const LitMedium lit = litFog(fog, {&sun, 1}, {{Rgb(0.9, 0.8, 0.7), 0.5}});
  return {"fog in the sun", AnyMedium(lit), {{glPart(GlLitFog{fog, lit})}}};
}

Thing fdsAt(const Vec3& offset, bool nodal) {
  std::vector<FdsLattice> lattices{
      {0, {{{0, 0.5, 1.0, 2.0}, {0, 1, 1.5, 2}, {-1, 0, 1}}}, nodal},
      {1, {{{2, 2.25, 2.5, 2.75, 3.0}, {0, 0.5, 1, 1.5, 2}, {-1, -0.5, 0, 0.5, 1}}}, nodal}};
  for (FdsLattice& lattice : lattices) {
    for (int axis = 0; axis < 3; ++axis) {
      for (double& plane : lattice.planes[axis]) plane += offset[axis];
    }
  }
  const auto grid = FdsGrid::create(lattices).value();
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0, 2);
  std::vector<std::shared_ptr<const FdsValues>> values;
  std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells;
  for (const FdsLattice& lattice : grid->lattices()) {
    auto states = std::make_shared<std::vector<FdsCell>>(lattice.cellCount(), FdsCell::kGas);
    for (FdsCell& state : *states) state = random() % 5 == 0 ? FdsCell::kSolid : FdsCell::kGas;
    auto made = std::make_shared<FdsValues>();
    for (std::size_t i = 0; i < lattice.valueCount(); ++i) made->value.push_back(uniform(random));
    cells.push_back(std::move(states));
    values.push_back(std::move(made));
  }
  const FdsField field =
      FdsField(grid, std::move(values), std::move(cells)).withSource(Rgb(0.5, 0.7, 0.9));
  return {nodal ? "FDS, nodes" : "FDS, cells", AnyMedium(field), {{glPart(GlFds{field})}}};
}

std::vector<Thing> thingsAt(const Vec3& offset) {
  return {volumeAt(offset, 1, Basis::kTrilinear),
          volumeAt(offset, 3, Basis::kBox),
          treeAt(offset),
          smokeAt(offset, true, GlSmokeMethod::kMarch),
          smokeAt(offset, false, GlSmokeMethod::kMarch),
          smokeAt(offset, false, GlSmokeMethod::kProject),
          smokeAt(offset, true, GlSmokeMethod::kProject),
          fdsAt(offset, false),
          fdsAt(offset, true),
          plainFogAt(offset),
          sunlitFogAt(offset)};
}

/// Sees the bounds fill the picture from this many of their sizes away.
Camera cameraFrom(const Box3& bounds, const Vec3& way, double sizes, bool parallel,
                  int width = kWidth, int height = kHeight) {
  const double size = bounds.size().norm();
  const View3 view{bounds.centre() + sizes * size * way.normalized(), bounds.centre()};
  if (parallel)
    return Camera::orthographic(view, 1.1 * size, width, height);
  const double fov = 2 * std::atan(0.55 / sizes) * 180 / std::numbers::pi;
  return Camera::pinhole(view, fov, width, height);
}

class GlFarTest : public GlRendererTest {
 protected:
  void sweep(const Thing& thing, double bar = kBar) {
    for (const bool parallel : {false, true}) {
      for (const Vec3& way : {Vec3(0.48, -0.6, 0.64), Vec3(0, -1, 0)}) {
        if (way.x() == 0 && thing.scene.parts[0]->name() != "smoke")
          continue;  // along axes boundaries of meshes are seen edge on
        for (const double sizes : kDistances) {
          const Camera camera = cameraFrom(thing.medium.bounds(), way, sizes, parallel);
          const double error =
              errorOf(camera, thing.scene, {&thing.medium, 1}, {.background = Rgb(0.1, 0.2, 0.3)});
          EXPECT_LE(error, bar) << thing.name << (parallel ? ", parallel, " : ", pinhole, ")
                                << sizes << " sizes away, towards " << way;
        }
      }
    }
  }
};

TEST_F(GlFarTest, EyesMayBeFarAway) {
  for (const Thing& thing : thingsAt(Vec3::Zero())) sweep(thing);
  sweep(polarFogAt(Vec3::Zero()), 1 / 512.0);
}

TEST_F(GlFarTest, ScenesMayBeFarFromTheOrigin) {
  for (const Thing& thing : thingsAt(kFarOrigin)) sweep(thing);
  sweep(polarFogAt(kFarOrigin), 1 / 512.0);
}

/// A floor, and a wall that throws a shadow on it and hides half of what is behind.
TriangleScene surfacesAt(const Vec3& offset) {
  std::vector<Triangle> triangles;
  const auto quad = [&](const Vec3& corner, const Vec3& u, const Vec3& v, std::uint32_t material) {
    const Vec3 a = corner + offset;
    triangles.push_back({{a, a + u, a + u + v}, material});
    triangles.push_back({{a, a + u + v, a + v}, material});
  };
  quad(Vec3(-3, -3, -2.5), Vec3(6, 0, 0), Vec3(0, 6, 0), 0);
  quad(Vec3(-1, 0.1, -2.5), Vec3(2.3, 0.4, 0), Vec3(0, 0, 3), 1);
  return TriangleScene::build(std::move(triangles), {{Rgb(0.7, 0.6, 0.5)}, {Rgb(0.2, 0.5, 0.8)}})
      .value();
}

std::vector<Lamp> lampsAt(const Vec3& offset) {
  Lamp lamp;
  lamp.position = Vec3(1.2, -1.7, 2.1) + offset;
  lamp.direction = Vec3(-0.1, 0.4, -1).normalized();
  lamp.coneCosine = -1;
  lamp.intensity = Rgb(20, 17, 13);
  return {lamp};
}

TEST_F(GlFarTest, SurfacesInSmokeAreLitAndHideWhatIsBehind) {
  for (const Vec3& offset : {Vec3(0, 0, 0), kFarOrigin}) {
    const Thing thing = smokeAt(offset, true, GlSmokeMethod::kMarch);
    const TriangleScene geometry = surfacesAt(offset);
    const auto lights = lampsAt(offset);
    const SurfaceScene full{geometry, lights, Rgb(0.02, 0.03, 0.04), {&thing.medium, 1}};
    const SurfaceScene clear{geometry, lights, Rgb(0.02, 0.03, 0.04)};
    for (const bool parallel : {false, true}) {
      for (const double sizes : kDistances) {
        const Camera camera =
            cameraFrom(thing.medium.bounds(), Vec3(0.48, -0.6, 0.64), sizes, parallel);
        const auto expected = renderSurfaces(camera, full, Rgb(0.3, 0.2, 0.1), quiet_).value();
        const auto found =
            renderer_->surfaces(camera, clear, thing.scene, Rgb(0.3, 0.2, 0.1), quiet_);
        ASSERT_TRUE(found) << found.error().message;
        const auto where =
            fmt::format("{}, {} sizes away", parallel ? "parallel" : "pinhole", sizes);
        EXPECT_EQ(found->surfacePixels, expected.surfacePixels) << where;
        EXPECT_LE(difference(found->color.pixels, expected.color.pixels), kBar) << where;
        EXPECT_LE(difference(found->depth, expected.depth), 1e-6) << where;
        EXPECT_LE(errorOf(camera, thing.scene, {&thing.medium, 1}, {.behind = &expected.color},
                          expected.depth),
                  kBar)
            << where;
      }
    }
  }
}

TEST_F(GlFarTest, SignsAreFound) {
  for (const Vec3& offset : {Vec3(0, 0, 0), kFarOrigin}) {
    Sign sign;
    sign.position = Vec3(0.2, 3.4, 1.8) + offset, sign.normal = Vec3(0.3, -1, 0.5);
    sign.width = 1.2, sign.height = 0.6, sign.c = 8;
    sign.picture = exitPicture();
    const Vec3 half = Vec3::Constant(0.5);
    for (const bool parallel : {false, true}) {
      for (const double sizes : kDistances) {
        const Camera camera = cameraFrom({sign.position - half, sign.position + half},
                                         Vec3(0.48, -0.6, 0.64), sizes, parallel);
        const auto expected = signPixels(camera, {&sign, 1}, {});
        const auto found = renderer_->findSigns(camera, {&sign, 1}, {});
        ASSERT_TRUE(found) << found.error().message;
        ASSERT_EQ(found->size(), expected.size());
        EXPECT_GT(expected.size(), 60u);
        for (std::size_t i = 0; i < expected.size(); ++i) {
          EXPECT_EQ((*found)[i].pixel, expected[i].pixel);
          EXPECT_NEAR((*found)[i].distance, expected[i].distance, 1e-6 * expected[i].distance);
          for (int c = 0; c < 3; ++c)
            EXPECT_NEAR((*found)[i].radiance[c], expected[i].radiance[c], 1e-3) << sizes;
        }
      }
    }
  }
}

TEST_F(GlFarTest, Billboards) {
  for (const Vec3& offset : {Vec3(0, 0, 0), kFarOrigin}) {
    const auto slice = sliceAt(3, Basis::kTrilinear, offset);
    const BillboardOptions options{Vec3(0.4, 3, 1.6) + offset, 1.7, 1.9, 64};
    const Vec3 half = Vec3::Constant(0.6);
    for (const bool parallel : {false, true}) {
      for (const double sizes : kDistances) {
        const Camera camera = cameraFrom({options.position - half, options.position + half},
                                         Vec3(0.48, -0.6, 0.64), sizes, parallel);
        const AnyMedium board(
            Billboard::draw(AnyMedium(VoxelMedium(slice, 0.4, 1.5)), camera, options, quiet_)
                .value());
        EXPECT_LE(errorOf(camera, {{glPart(GlBillboard{{slice, 0.4, 1.5}, options})}}, {&board, 1},
                          {.background = Rgb(0.5, 0.4, 0.3)}),
                  2e-3)
            << (parallel ? "parallel, " : "pinhole, ") << sizes << " sizes away";
      }
    }
  }
}

/// Levels of detail are counted from the eye, and a lens bends rays that come from far.
TEST_F(GlFarTest, LevelsOfDetailAndLenses) {
  const FogMedium fog = fogAt(kFarOrigin, 3);
  const AnyMedium medium(fog);
  for (const bool parallel : {false, true}) {
    for (const double sizes : kDistances) {
      const Camera camera = cameraFrom(medium.bounds(), Vec3(0.48, -0.6, 0.64), sizes, parallel);
      EXPECT_LE(errorOf(camera, {{glPart(GlFog{fog})}}, {&medium, 1}, {}), kBar)
          << (parallel ? "parallel, " : "pinhole, ") << sizes << " sizes away";
    }
  }
  const Thing smoke = smokeAt(kFarOrigin, true, GlSmokeMethod::kMarch);
  const Box3 bounds = smoke.medium.bounds();
  for (const double sizes : kDistances) {
    if (sizes > 1e4)
      continue;  // such focal lengths are refused
    Calibration lens;
    lens.width = kWidth, lens.height = kHeight;
    lens.K = Mat3(27 * sizes, 1.5, 17, 0, 27 * sizes, 16, 0, 0, 1);
    lens.R = Mat3(1, 0, 0, 0, 0, -1, 0, 1, 0);
    lens.t = -lens.R * (bounds.centre() - Vec3(0, sizes * bounds.size().norm(), 0.2));
    lens.distortion.k1 = -0.1 * sizes * sizes;
    const auto camera = Camera::calibrated(lens);
    ASSERT_TRUE(camera) << camera.error().message;
    EXPECT_LE(errorOf(*camera, smoke.scene, {&smoke.medium, 1}, {}), kBar)
        << sizes << " sizes away, through a lens";
  }
}

/// Its bounds have no end; the map and what changes in its profile are small.
TEST_F(GlFarTest, FogWithoutAnEndAbove) {
  SplineGrid scaled = fogtest::map(9, 8, 1, 1);
  for (double& value : scaled.c) value *= 0.3;
  for (const Vec3& offset : {Vec3(0, 0, 0), kFarOrigin}) {
    const Vec3 corner = Vec3(-3, 2, 0.5) + offset;
    const FogMap map = *FogMap::fromCoefficients(scaled, {.origin = corner, .cell = 1.3});
    const FogMedium fog = *FogMedium::make(map, fogtest::profiles()[2].profile, {.degree = 2});
    const AnyMedium medium(fog);
    const Vec3 middle = corner + Vec3(5.5, 5, 2);
    for (const double metres : {10.0, 40.0, 1e3, 1e5, 1e6}) {
      const double fov = 2 * std::atan(6 / metres) * 180 / std::numbers::pi;
      for (const Vec3& way : {Vec3(0.48, -0.6, 0.64), Vec3(0.6, -0.8, 0.01)}) {
        const Camera camera =
            Camera::pinhole({middle + metres * way, middle}, fov, kWidth, kHeight);
        EXPECT_LE(errorOf(camera, {{glPart(GlFog{fog})}}, {&medium, 1}, {}), kBar)
            << metres << " m away, towards " << way << " from " << offset;
      }
    }
  }
}

/// Smoke of 6 m a kilometre from an eye inside of a fog that is far larger.
TEST_F(GlFarTest, SmallThingsInLargeOnes) {
  SplineGrid scaled = fogtest::map(40, 40, 1, 1);
  for (double& value : scaled.c) value *= 3e-4;
  const FogMap map =
      *FogMap::fromCoefficients(scaled, {.origin = Vec3(-1000, -1000, -30), .cell = 50});
  const FogMedium fog =
      *FogMedium::make(map, *FogProfile::slab(0, 60), {.degree = 2, .color = Rgb(0.7, 0.8, 0.9)});
  const Thing smoke = smokeAt(Vec3(300, 200, 0), true, GlSmokeMethod::kMarch);
  GlScene scene = smoke.scene;
  scene.parts.push_back(glPart(GlFog{fog}));
  const std::vector<AnyMedium> both{AnyMedium(fog), smoke.medium};
  for (const double sizes : {10.0, 100.0}) {
    const Camera camera = cameraFrom(smoke.medium.bounds(), Vec3(-0.6, -0.8, 0.01), sizes, false);
    EXPECT_TRUE(both[0].bounds().contains(camera.eye()));
    EXPECT_LE(errorOf(camera, scene, both, {.background = Rgb(0.1, 0.2, 0.3)}), kBar) << sizes;
  }
}

/// Two puffs in a box whose table of bricks no device could hold, with room for many between them.
TEST_F(GlFarTest, PuffsInAnEmptyBox) {
  VolumeInfo info;
  info.x = info.y = info.z = 100'000;
  info.bounds = {Vec3::Zero(), Vec3::Constant(1000)};
  for (const int channels : {1, 3}) {
    for (const Basis basis : {Basis::kBox, Basis::kTrilinear}) {
      info.channels = channels, info.basis = basis;
      std::vector<BrickPlace> places;
      for (const int at : {6000, 6150}) {
        for (int i = 0; i < 8; ++i)
          places.push_back({at + (i & 1), at + (i >> 1 & 1), 7000 + (i >> 2)});
      }
      std::ranges::sort(places, isBefore);
      auto slice = std::make_shared<BrickSlice>(info, places);
      std::mt19937 random(5);
      std::uniform_real_distribution<float> uniform(0, 20);
      for (const BrickSlice::Entry& entry : slice->entries())
        std::generate_n(slice->brick(entry.stored), BrickSlice::kVoxels * channels,
                        [&] { return uniform(random); });
      const AnyMedium medium(VoxelMedium(slice, 1.3, 1.5));
      for (const int at : {6000, 6150}) {
        const Vec3 middle = 0.08 * Vec3(at + 1, at + 1, 7001);
        for (const Vec3& way : {Vec3(0.48, -0.6, 0.64), Vec3(0.02, -1, 0)}) {
          const Camera camera = Camera::pinhole({middle + 2 * way, middle}, 6, kWidth, kHeight);
          EXPECT_LE(errorOf(camera, {{glPart(GlVolume{slice, 1.3, 1.5})}}, {&medium, 1}, {}), 4e-3)
              << channels << " " << static_cast<int>(basis) << " " << at << " " << way;
        }
      }
    }
  }
}

}  // namespace
}  // namespace volute
