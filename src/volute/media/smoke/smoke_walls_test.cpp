// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_walls.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "volute/media/smoke/smoke_medium.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace volute {
namespace {

/// A hall with columns, smoke and one lamp.
struct LitHall {
  SmokeState smoke;
  SceneLights lights;

  LitHall() {
    const auto mesh = hallMesh(0.8, 3);
    smoke.locator = std::make_shared<TetLocator>(mesh);
    smoke.extinction = plume(*mesh, 0, 1);
    for (float& k : smoke.extinction) k *= 0.2F;
    Lamp lamp;
    lamp.position = Vec3(10.1, 6.3, 4.5);
    lamp.intensity = Rgb::Constant(20);
    lights.lamps = {lamp};
    smoke.lampShares = {LampPaths(smoke.locator).shares(smoke.extinction, lamp)};
  }
};

const LitHall& hall() {
  static const LitHall hall;
  return hall;
}

/// Of the lamp's light on the wall in a pixel, what comes through; -1: no wall, or lit from behind.
double shareIn(const SurfaceView& view, const Camera& camera, int x, int y, Vec3& point) {
  const float depth = view.depth[static_cast<std::size_t>(y) * camera.width() + x];
  if (!std::isfinite(depth))
    return -1;
  point = camera.ray(x + 0.5, y + 0.5).at(depth);
  return view.color.at(x, y, 0) / hall().lights.lamps[0].irradiance(point)[0] * std::numbers::pi;
}

TEST(LookAtWalls, ShadowsHaveTheEdgesOfWhatCastsThem) {
  const Camera camera =
      Camera::pinhole({Vec3(2.3, 6.8, 2.7), Vec3(20, 5, 1), Vec3::UnitZ()}, 70, 64, 48);
  const auto view = lookAtWalls(camera, hall().smoke, hall().lights, Rgb::Constant(1));
  ASSERT_TRUE(view);
  int lit = 0, dark = 0, wrong = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      Vec3 point;
      const double seen = shareIn(*view, camera, x, y, point);
      if (seen < 0)
        continue;
      // From just before the wall: the cosine is not known here, but is at most 1.
      const Segment ray = camera.ray(x + 0.5, y + 0.5);
      const Segment way = hall().lights.lamps[0].towards(point - 1e-6 * ray.direction);
      const double expected =
          lampShareReference(*hall().smoke.locator, hall().smoke.extinction, way);
      (expected > 0 ? lit : dark) += 1;
      // What is dark is black, and what is lit is lit.
      wrong += expected > 0.02 ? seen > 1.02 * expected + 0.02 : seen > 0.02;
    }
  }
  EXPECT_GT(lit, 500);
  EXPECT_GT(dark, 200);
  EXPECT_LE(wrong, 6);
}

TEST(LookAtWalls, OtherThingsCastShadowsToo) {
  const Camera camera =
      Camera::pinhole({Vec3(2.3, 6.8, 2.7), Vec3(20, 5, 1), Vec3::UnitZ()}, 70, 64, 48);
  // What is beyond x = 12.3 is behind a screen.
  const Blocks screen = [](std::span<const Segment> ways, std::span<std::uint8_t> blocked) {
    for (std::size_t i = 0; i < ways.size(); ++i) blocked[i] = ways[i].origin.x() > 12.3;
  };
  const auto view = lookAtWalls(camera, hall().smoke, hall().lights, Rgb::Constant(1), screen);
  ASSERT_TRUE(view);
  int behind = 0, before = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      Vec3 point;
      const double seen = shareIn(*view, camera, x, y, point);
      if (seen < 0)
        continue;
      if (point.x() > 12.3) {
        EXPECT_LE(seen, 0.011) << point;
        ++behind;
      } else {
        before += seen > 0.05;
      }
    }
  }
  EXPECT_GT(behind, 100);
  EXPECT_GT(before, 100);
}

/// Points of a face in rows, by its corners.
std::vector<Vec3> pointsOfFace(int rows) {
  std::vector<Vec3> points;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; i + j < rows; ++j)
      points.emplace_back((i + 0.31) / rows, (j + 0.33) / rows, 1 - (i + j + 0.64) / rows);
  }
  return points;
}

TEST(WallLight, IsThatOfItsTwinEverywhere) {
  const TetMesh& mesh = hall().smoke.locator->mesh();
  const auto walls = MeshWalls::make(mesh);
  ASSERT_TRUE(walls);
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(0.5, 0.3, -1).normalized();
  Lamp outside = hall().lights.lamps[0];
  outside.position = Vec3(-4, 5, 8);
  const std::vector<Lamp> lamps = {hall().lights.lamps[0], sun, outside};
  WallLight light;
  const WallLight::Request request{*hall().smoke.locator, hall().smoke.extinction, **walls, lamps};
  const auto points = pointsOfFace(12);
  std::vector<double> shares(points.size());
  int wrong = 0, lit = 0, dark = 0;
  for (std::size_t f = 0; f < (*walls)->faces().size(); f += 7) {
    const WallFace& face = (*walls)->faces()[f];
    for (std::size_t l = 0; l < lamps.size(); ++l) {
      const Segment toward = lamps[l].towards(mesh.vertices()[face.vertices[0]]);
      if (!(face.inwards.dot(toward.direction) > 0.02))
        continue;
      light.shares(request, l, f, points, shares);
      for (std::size_t i = 0; i < points.size(); i += 3) {
        Vec3 point = Vec3::Zero();
        for (int k = 0; k < 3; ++k) point += points[i][k] * mesh.vertices()[face.vertices[k]];
        const double twin = lampShareReference(*hall().smoke.locator, hall().smoke.extinction,
                                               lamps[l].towards(point + 1e-7 * face.inwards));
        ++(twin > 0 ? lit : dark);
        wrong += !(std::abs(shares[i] - twin) <= 2e-3);
      }
    }
  }
  EXPECT_GT(lit, 5000);
  EXPECT_GT(dark, 1000);
  EXPECT_LE(wrong, (lit + dark) / 5000);  // points on the very edge of a shadow
}

/// The hall's smoke, and where it drifts to while it grows denser.
std::array<std::vector<float>, 2> driftingSmoke() {
  std::array<std::vector<float>, 2> ends{hall().smoke.extinction,
                                         plume(hall().smoke.locator->mesh(), 30, 1)};
  for (float& k : ends[1]) k *= 0.8F;
  return ends;
}

TEST(WallLight, BetweenTwoStepsIsThatOfTheirMean) {
  const TetMesh& mesh = hall().smoke.locator->mesh();
  const auto walls = MeshWalls::make(mesh);
  ASSERT_TRUE(walls);
  const auto [from, to] = driftingSmoke();
  const std::vector<Lamp>& lamps = hall().lights.lamps;
  WallLight light;
  WallLight::Request request{*hall().smoke.locator, from, **walls, lamps};
  request.later = to;
  const auto points = pointsOfFace(12);
  std::vector<double> shares(points.size());
  int wrong = 0, lit = 0;
  double changed = 0;
  for (const double time : {0.0, 0.35, 0.6, 1.0}) {
    std::vector<float> there(from.size());
    for (std::size_t i = 0; i < there.size(); ++i)
      there[i] = static_cast<float>((1 - time) * from[i] + time * to[i]);
    request.time = time;
    for (std::size_t f = 0; f < (*walls)->faces().size(); f += 11) {
      const WallFace& face = (*walls)->faces()[f];
      const Segment toward = lamps[0].towards(mesh.vertices()[face.vertices[0]]);
      if (!(face.inwards.dot(toward.direction) > 0.02))
        continue;
      light.shares(request, 0, f, points, shares);
      for (std::size_t i = 0; i < points.size(); i += 3) {
        Vec3 point = Vec3::Zero();
        for (int k = 0; k < 3; ++k) point += points[i][k] * mesh.vertices()[face.vertices[k]];
        const Segment way = lamps[0].towards(point + 1e-7 * face.inwards);
        const double twin = lampShareReference(*hall().smoke.locator, there, way);
        lit += twin > 0;
        wrong += !(std::abs(shares[i] - twin) <= 2e-3);
        changed = std::max(changed,
                           std::abs(twin - lampShareReference(*hall().smoke.locator, from, way)));
      }
    }
  }
  EXPECT_GT(changed, 0.1);
  EXPECT_GT(lit, 5000);
  EXPECT_LE(wrong, lit / 5000);
}

TEST(WallLight, DoesNotDependOnWhatWasAskedBefore) {
  const auto walls = MeshWalls::make(hall().smoke.locator->mesh());
  ASSERT_TRUE(walls);
  const std::vector<Lamp>& lamps = hall().lights.lamps;
  const WallLight::Request request{*hall().smoke.locator, hall().smoke.extinction, **walls, lamps};
  const auto few = pointsOfFace(5), many = pointsOfFace(40);
  WallLight fresh, used;
  std::vector<double> first(many.size()), second(many.size()), some(few.size());
  for (std::size_t f = 0; f < (*walls)->faces().size(); f += 31) {
    used.shares(request, 0, f, few, some);
    used.shares(request, 0, f, many, second);
    fresh.shares(request, 0, f, many, first);
    EXPECT_EQ(first, second);
    fresh.shares(request, 0, f, few, first);
    EXPECT_TRUE(std::equal(some.begin(), some.end(), first.begin()));
  }
}

TEST(LookAtWalls, OfAnIntervalWalksOnceForAllItsPictures) {
  const Camera camera =
      Camera::pinhole({Vec3(2.3, 6.8, 2.7), Vec3(20, 5, 1), Vec3::UnitZ()}, 70, 160, 120);
  const auto ends = driftingSmoke();
  SmokeState smoke = hall().smoke;
  const auto walls = MeshWalls::make(smoke.locator->mesh());
  ASSERT_TRUE(walls);
  smoke.walls = *walls;
  const auto alone = [&](double time) {
    SmokeState state = smoke;
    for (std::size_t i = 0; i < state.extinction.size(); ++i)
      state.extinction[i] = static_cast<float>((1 - time) * ends[0][i] + time * ends[1][i]);
    return lookAtWalls(camera, state, hall().lights, Rgb::Constant(1));
  };
  smoke.interval = {std::make_shared<const std::vector<float>>(ends[0]),
                    std::make_shared<const std::vector<float>>(ends[1]),
                    std::make_shared<WallLight>()};
  std::vector<std::uint64_t> walks;
  for (const double time : {0.1, 0.3, 0.5, 0.9}) {
    smoke.intervalTime = time;
    const auto kept = lookAtWalls(camera, smoke, hall().lights, Rgb::Constant(1));
    walks.push_back(smoke.interval.light->walks());
    const auto fresh = alone(time);
    ASSERT_TRUE(kept && fresh);
    double most = 0;
    for (std::size_t i = 0; i < kept->color.pixels.size(); ++i)
      most = std::max<double>(most, std::abs(kept->color.pixels[i] - fresh->color.pixels[i]));
    EXPECT_LT(most, 4e-3 * *std::ranges::max_element(fresh->color.pixels)) << time;
  }
  EXPECT_EQ(walks.back(), walks[1]);  // the first has a view that is not kept
}

/// A bar that is much thinner than the face on which its shadow falls.
TEST(WallLight, SeesTheShadowOfWhatIsThinnerThanAFace) {
  // A box of 8 m whose faces are 8 m long, with a bar of 20 cm missing above its floor.
  std::vector<Vec3> vertices;
  std::vector<Tet> tets;
  const double x[4] = {0, 3.9, 4.1, 8}, y[4] = {0, 3.9, 4.1, 8}, z[4] = {0, 5, 5.2, 8};
  const auto at = [](int i, int j, int k) { return (k * 4 + j) * 4 + i; };
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 4; ++i) vertices.emplace_back(x[i], y[j], z[k]);
    }
  }
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) {
        if (i == 1 && k == 1)
          continue;  // along y from wall to wall
        // Six tets around the diagonal.
        const int steps[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
        for (const auto& step : steps) {
          int place[3] = {i, j, k};
          Tet tet{};
          tet[0] = at(i, j, k);
          for (int s = 0; s < 3; ++s) {
            ++place[step[s]];
            tet[s + 1] = at(place[0], place[1], place[2]);
          }
          tets.push_back(tet);
        }
      }
    }
  }
  const auto mesh = TetMesh::build(vertices, tets, "a box with a bar");
  ASSERT_TRUE(mesh) << mesh.error().message;
  const TetLocator locator(*mesh);
  const auto walls = MeshWalls::make(**mesh);
  ASSERT_TRUE(walls);
  const std::vector<float> clear((*mesh)->vertices().size(), 0);
  Lamp lamp;
  lamp.position = Vec3(4.6, 4, 7.3);
  const std::vector<Lamp> lamps = {lamp};
  WallLight light;
  const WallLight::Request request{locator, clear, **walls, lamps};
  const auto points = pointsOfFace(40);
  std::vector<double> shares(points.size());
  int dark = 0;
  for (std::size_t f = 0; f < (*walls)->faces().size(); ++f) {
    const WallFace& face = (*walls)->faces()[f];
    if (face.inwards.z() < 0.9 || vertices[face.vertices[0]].z() > 0)
      continue;
    light.shares(request, 0, f, points, shares);
    for (std::size_t i = 0; i < points.size(); ++i) {
      Vec3 point = Vec3::Zero();
      for (int k = 0; k < 3; ++k) point += points[i][k] * vertices[face.vertices[k]];
      const Vec3 way = lamp.position - point;
      const auto across = [&](double height) { return point.x() + way.x() * height / way.z(); };
      const double low = std::min(across(5), across(5.2)), high = std::max(across(5), across(5.2));
      const bool shadow = high > 3.9 && low < 4.1;
      if (std::abs(high - 3.9) < 1e-9 || std::abs(low - 4.1) < 1e-9)
        continue;
      EXPECT_EQ(shares[i], shadow ? 0 : 1) << point;
      dark += shadow;
    }
  }
  EXPECT_GT(dark, 50);
}

TEST(LookAtWalls, KnowsFromEarlierPictures) {
  const Camera camera =
      Camera::pinhole({Vec3(2.3, 6.8, 2.7), Vec3(20, 5, 1), Vec3::UnitZ()}, 70, 160, 120);
  WallLight known;
  const auto first =
      lookAtWalls(camera, hall().smoke, hall().lights, Rgb::Constant(1), {}, {}, &known);
  const std::uint64_t walks = known.walks();
  const auto second =
      lookAtWalls(camera, hall().smoke, hall().lights, Rgb::Constant(1), {}, {}, &known);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->color.pixels, second->color.pixels);
  EXPECT_LT(known.walks() - walks, walks);
}

/// The hall's smoke once more, half as thick, as if it were another medium's; and a second lamp.
TEST(MeshWalls, OneCamerasViewIsKeptFromItsSecondPictureOn) {
  const View3 view{Vec3(2.3, 6.8, 2.7), Vec3(20, 5, 1), Vec3::UnitZ()};
  const Camera camera = Camera::pinhole(view, 70, 160, 120), shifted = camera.shifted(0.25, 0);
  const auto walls = MeshWalls::make(hall().smoke.locator->mesh());
  ASSERT_TRUE(walls);
  const auto first = (*walls)->seenFrom(camera), second = (*walls)->seenFrom(camera);
  EXPECT_NE(first, second);  // a camera that moves has nothing kept for it
  EXPECT_EQ(first->depth, second->depth);
  EXPECT_EQ(first->face, second->face);
  EXPECT_EQ((*walls)->seenFrom(camera), second);
  const auto other = (*walls)->seenFrom(shifted);
  EXPECT_NE(other, second);
  EXPECT_NE(other->depth, second->depth);
  EXPECT_EQ((*walls)->seenFrom(camera)->depth, second->depth);
}

TEST(LookAtWalls, IsTheSameWhetherTheViewIsKeptOrNot) {
  const Camera camera =
      Camera::pinhole({Vec3(2.3, 6.8, 2.7), Vec3(20, 5, 1), Vec3::UnitZ()}, 70, 64, 48);
  SmokeState smoke = hall().smoke;
  const auto walls = MeshWalls::make(smoke.locator->mesh());
  ASSERT_TRUE(walls);
  smoke.walls = *walls;
  const std::vector<std::uint8_t> each(std::size_t{64} * 48, 1);  // one by one, nothing is kept
  SceneLights dark;
  dark.ambient = Rgb(0.1, 0.2, 0.3);
  for (const SceneLights& lights : {hall().lights, dark}) {
    const auto alone = lookAtWalls(camera, smoke, lights, Rgb::Constant(0.5), {}, each);
    for (int picture = 0; picture < 3; ++picture) {
      const auto kept = lookAtWalls(camera, smoke, lights, Rgb::Constant(0.5));
      ASSERT_TRUE(alone && kept);
      EXPECT_EQ(kept->depth, alone->depth);
      EXPECT_EQ(kept->color.pixels, alone->color.pixels);
    }
  }
}

TEST(SmokeSnapshot, IsLitThroughOtherMediaAndByWhatGlows) {
  SmokeState state = hall().smoke;
  state.albedo = Rgb(0.9, 0.8, 0.7);
  const auto lighting =
      std::make_shared<const SmokeLighting>(SmokeLighting{hall().lights, nullptr, {}, {}, nullptr});
  const SmokeSnapshot smoke(state, 1, lighting, std::nullopt);
  std::vector<float> half = state.extinction;
  for (float& k : half) k *= 0.5F;
  const std::vector<AnyMedium> between{AnyMedium(TetMedium(state.locator, half))};
  const auto lit = smoke.litBy({hall().lights.lamps, between});
  ASSERT_TRUE(lit);
  const SmokeState& found = dynamic_cast<const SmokeSnapshot&>(*lit).state();
  const Lamp& lamp = hall().lights.lamps[0];
  std::vector<float> shares = state.lampShares[0];
  for (float& share : shares) share = std::pow(share, 1.5F);
  const auto takesHalf = [&](std::span<const Vec3> points, std::span<float> there) {
    std::vector<Segment> ways;
    for (const Vec3& point : points) ways.push_back(lamp.towards(point));
    std::vector<double> depths(ways.size());
    between[0].opticalDepth(ways, depths);
    for (std::size_t i = 0; i < there.size(); ++i)
      there[i] *= static_cast<float>(std::exp(-depths[i]));
  };
  const auto means = LampPaths(state.locator).means(state.extinction, lamp, shares, takesHalf);
  ASSERT_EQ(found.lampMeans.size(), 2);
  double most = 0, moved = 0;
  for (const auto& drawn : found.lampMeans) {
    ASSERT_EQ(drawn.size(), means.size());
    for (std::size_t i = 0; i < means.size(); ++i) {
      most = std::max<double>(most, std::abs(drawn[i] - means[i]));
      moved = std::max<double>(moved, std::abs(drawn[i] - shares[i]));
    }
  }
  EXPECT_LT(most, 1e-2);
  EXPECT_GT(moved, 1e-2);
  EXPECT_EQ(found.source, scatteredLight(state.locator->mesh().vertices(), {{lamp, lamp}},
                                         found.lampMeans, state.albedo, Rgb::Zero()));
  const SmokeSnapshot black(hall().smoke, 1, lighting, std::nullopt);
  EXPECT_FALSE(black.litBy({hall().lights.lamps, between})) << "it scatters nothing";
}

}  // namespace
}  // namespace volute
