// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench fog`: a valley under painted fog, one thread. The exact walk against uniform steps,
// polar tables and dropped details against the walk, and the figures of Giroud and Biri 2010 as
// ratios of our three ways to walk their levels.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "bench/baselines/paper_walk.hpp"
#include "bench/baselines/uniform_steps.hpp"
#include "bench/benchmark.hpp"
#include "bench/timing.hpp"
#include "volute/base/parallel.hpp"
#include "volute/camera/camera.hpp"
#include "volute/fog/fog_march.hpp"
#include "volute/fog/polar_table.hpp"
#include "volute/fog/sun_sums.hpp"
#include "volute/synth/valley.hpp"

namespace volute::bench {
namespace {

constexpr double kValleySide = 65;  // [m], of the valley
constexpr int kWidth = 800, kHeight = 600;

/// The least of several runs of each, taken in turns, so that what else the machine does hits all.
std::vector<double> minSeconds(const std::vector<std::function<void()>>& works, int rounds = 7) {
  std::vector<double> least(works.size(), std::numeric_limits<double>::infinity());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < works.size(); ++i)
      least[i] = std::min(least[i], secondsOf(works[i]));
  }
  return least;
}

double ground(double x, double y) {
  const double hill = 4 * std::exp(-(std::pow(x - 42, 2) + std::pow(y - 33, 2)) / 70);
  return 0.8 * std::sin(0.2 * x + 0.4) * std::cos(0.18 * y) + 0.4 * std::sin(0.5 * x + 0.4 * y) +
         hill;
}

/// 8-bit fog of soft blobs and streaks, a third of it empty; the same shapes at every size.
SplineGrid fogMap(int side, double share = 1) {
  std::mt19937 random(7);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  SplineGrid map(side, side);
  for (int blob = 0; blob < 22; ++blob) {
    const double cx = uniform(), cy = uniform(), width = 0.03 + 0.1 * uniform();
    const double height = 0.3 + 0.7 * uniform();
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const double x = (i + 0.5) / side - cx, y = (j + 0.5) / side - cy;
        map.at(i, j) += height * std::exp(-(x * x + y * y) / (2 * width * width));
      }
    }
  }
  double most = 0;
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const double x = 64.0 * i / side, y = 64.0 * j / side;
      double& value = map.at(i, j);
      value *= 0.55 + 0.45 * std::sin(1.9 * x + 0.7 * y) * std::sin(0.9 * x - 1.3 * y);
      value = value < 0.16 ? 0 : value;
      most = std::max(most, value);
    }
  }
  for (double& value : map.c) value = 0.06 * share * std::round(255 * value / most) / 255;
  return map;
}

/// The picture's rays, down to the ground.
struct Valley {
  Vec3 eye = Vec3(6.3, 7.7, 4.6);
  std::vector<Segment> segments;
  std::vector<float> x, y, z, distance;

  Valley() {
    const View3 view{eye, eye + Vec3(0.737, 0.673, -0.06), Vec3::UnitZ()};
    const Camera camera = Camera::pinhole(view, 60, kWidth, kHeight);
    for (int j = 0; j < kHeight; ++j) {
      for (int i = 0; i < kWidth; ++i) add(camera.ray(i + 0.5, j + 0.5));
    }
  }

  EyeRays rays() const { return {eye, x, y, z, distance}; }

 private:
  void add(Segment ray) {
    constexpr double kFar = 140;
    double s = 0.05;
    while (s < kFar) {
      const Vec3 point = ray.at(s);
      const double above = point.z() - ground(point.x(), point.y());
      if (above < 0)
        break;
      s += std::max({0.03, 0.005 * s, 0.3 * above});
    }
    ray.end = std::min(s, kFar);
    segments.push_back(ray);
    x.push_back(static_cast<float>(ray.direction.x()));
    y.push_back(static_cast<float>(ray.direction.y()));
    z.push_back(static_cast<float>(ray.direction.z()));
    distance.push_back(static_cast<float>(ray.end));
  }
};

Result<FogMedium> makeFog(const SplineGrid& map, const FogProfile& profile,
                          const FogOptions& options = {}) {
  const double cells = map.columns + options.degree;
  VOLUTE_ASSIGN(const FogMap fogMap, FogMap::fromCoefficients(map, {.cell = kValleySide / cells}));
  return FogMedium::make(fogMap, profile, options);
}

/// The largest |dT| against the reference over some of the rays.
double worstError(const FogMedium& fog, const Valley& valley,
                  const std::function<double(std::size_t)>& transmittance) {
  constexpr std::size_t kEach = 211;
  double worst = 0;
  for (std::size_t i = 0; i < valley.segments.size(); i += kEach) {
    double depth = 0;
    fog.opticalDepth({&valley.segments[i], 1}, {&depth, 1});
    worst = std::max(worst, std::abs(transmittance(i) - std::exp(-depth)));
  }
  return worst;
}

/// What the parts of the benchmark share.
struct Run {
  BenchRows& rows;
  Valley valley{};
  FogProfile slab = *FogProfile::slab(-50, 50);
  std::vector<double> depths = std::vector<double>(valley.segments.size());

  void add(std::string name, double value, std::string unit,
           std::optional<double> ratio = std::nullopt) {
    rows.add({std::move(name), value, std::move(unit), ratio});
  }

  std::function<void()> walk(const FogMedium& fog) {
    return [this, &fog] { marchDepths(fog, valley.segments, depths); };
  }

  double walkError(const FogMedium& fog) {
    marchDepths(fog, valley.segments, depths);
    return worstError(fog, valley, [&](std::size_t i) { return std::exp(-depths[i]); });
  }
};

/// Walk and polar table on maps of several sizes.
Status benchSizes(Run& run) {
  const auto sector = PolarSector::of(run.valley.rays());
  std::vector<float> passed(run.valley.segments.size());
  for (int side : {64, 256, 512}) {
    VOLUTE_ASSIGN(const FogMedium fog, makeFog(fogMap(side), run.slab));
    VOLUTE_TRY(PolarTable::make(fog, run.valley.eye, {.sector = sector}));
    const auto seconds = minSeconds(
        {run.walk(fog), [&] { uniformStepDepths(fog, 64, run.valley.segments, run.depths); },
         [&] {
           const auto table = PolarTable::make(fog, run.valley.eye, {.sector = sector});
           table->transmittance(run.valley.rays(), passed);
         }});
    const std::string map = fmt::format("{0} x {0}: ", side);
    run.add(map + "64 uniform steps", 1e3 * seconds[1], "ms", 1.0);
    run.add(map + "exact walk, of 64 uniform steps", 1e3 * seconds[0], "ms",
            seconds[0] / seconds[1]);
    run.add(map + "polar table made and read, of the walk", 1e3 * seconds[2], "ms",
            seconds[2] / seconds[0]);
    uniformStepDepths(fog, 64, run.valley.segments, run.depths);
    run.add(map + "|dT| of uniform steps",
            worstError(fog, run.valley, [&](std::size_t i) { return std::exp(-run.depths[i]); }),
            "");
    run.add(map + "|dT| of the walk", run.walkError(fog), "");
    run.add(map + "|dT| of the polar table, in 1/512",
            512 * worstError(fog, run.valley, [&](std::size_t i) { return passed[i]; }), "");
  }
  return {};
}

/// What details cost, and what dropping them saves.
Status benchDetail(Run& run) {
  for (int side : {64, 256}) {
    VOLUTE_ASSIGN(const FogMedium plain, makeFog(fogMap(side), run.slab));
    VOLUTE_ASSIGN(const FogMedium all, makeFog(fogMap(side), run.slab, {.levels = 3}));
    VOLUTE_ASSIGN(const FogMedium none,
                  makeFog(fogMap(side), run.slab, {.levels = 3, .detail = {.mu = 0}}));
    const double pixel = 2 * std::tan(30 * std::numbers::pi / 180) / kHeight;
    VOLUTE_ASSIGN(
        const FogMedium pixels,
        makeFog(fogMap(side), run.slab, {.levels = 3, .detail = {.cellAngle = 8 * pixel}}));
    const auto seconds =
        minSeconds({run.walk(plain), run.walk(all), run.walk(none), run.walk(pixels)}, 11);
    const std::string map = fmt::format("{0} x {0}, 3 levels: ", side);
    run.add(map + "mu = 1, of no decomposition", 1e3 * seconds[1], "ms", seconds[1] / seconds[0]);
    run.add(map + "mu = 0, times as fast", 1e3 * seconds[2], "ms", seconds[0] / seconds[2]);
    run.add(map + "cells of 8 pixels and more, times as fast", 1e3 * seconds[3], "ms",
            seconds[0] / seconds[3]);
    marchDepths(pixels, run.valley.segments, run.depths);
    run.add(map + "cells of 8 pixels and more, |dT|",
            worstError(plain, run.valley, [&](std::size_t i) { return std::exp(-run.depths[i]); }),
            "");
  }
  return {};
}

/// Every degree and profile on one map.
Status benchProfiles(Run& run) {
  const FogProfile::Knot knots[] = {{-2, 1}, {3, 0.8}, {6, 0.2}, {20, 0}};
  VOLUTE_ASSIGN(const FogProfile linear, FogProfile::linear(knots));
  VOLUTE_ASSIGN(const FogProfile exponential, FogProfile::exponential(0, 4));
  const FogProfile::Layer stack[] = {{-5, 2, 1}, {1, 4, 0.5}};
  VOLUTE_ASSIGN(const FogProfile layers, FogProfile::layers(stack));
  const std::pair<const char*, const FogProfile*> profiles[] = {
      {"slab", &run.slab}, {"linear", &linear}, {"exponential", &exponential}, {"layers", &layers}};
  VOLUTE_ASSIGN(const FogMedium base, makeFog(fogMap(64), run.slab));
  for (int degree = 0; degree <= 3; ++degree) {
    for (const auto& [name, profile] : profiles) {
      VOLUTE_ASSIGN(const FogMedium fog, makeFog(fogMap(64), *profile, {.degree = degree}));
      const auto seconds = minSeconds({run.walk(base), run.walk(fog)}, 3);
      const std::string row = fmt::format("degree {}, {}", degree, name);
      run.add(row + ", of degree 1, slab", 1e3 * seconds[1], "ms", seconds[1] / seconds[0]);
      run.add(row + ", |dT|", run.walkError(fog), "");
    }
  }
  return {};
}

/// Nineteen of twenty parts empty, against the same fog spread over all.
Status benchEmpty(Run& run) {
  constexpr int kMapSide = 1024, kSpot = 64;
  SplineGrid sparse(kMapSide, kMapSide), full(kMapSide, kMapSide);
  std::mt19937 random(5);
  constexpr int kSpots = (kMapSide / kSpot) * (kMapSide / kSpot) / 20;
  std::vector<int> places((kMapSide / kSpot) * (kMapSide / kSpot));
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = static_cast<int>(i);
  std::shuffle(places.begin(), places.end(), random);
  for (int spot = 0; spot < kSpots; ++spot) {
    const int x = places[spot] % (kMapSide / kSpot) * kSpot;
    const int y = places[spot] / (kMapSide / kSpot) * kSpot;
    for (int j = 0; j < kSpot - 1; ++j)
      for (int i = 0; i < kSpot - 1; ++i)
        sparse.at(x + i, y + j) = 0.3 * (0.5 + static_cast<double>(random()) / 4294967296.0);
  }
  std::ranges::fill(full.c, sparse.sum() / static_cast<double>(full.c.size()));
  VOLUTE_ASSIGN(const FogMedium few, makeFog(sparse, run.slab));
  VOLUTE_ASSIGN(const FogMedium all, makeFog(full, run.slab));
  const auto seconds = minSeconds({run.walk(all), run.walk(few)}, 3);
  run.add("1024 x 1024: full", 1e3 * seconds[0], "ms", 1.0);
  run.add("1024 x 1024: 95 % empty, as much fog, times as fast", 1e3 * seconds[1], "ms",
          seconds[0] / seconds[1]);
  run.add("1024 x 1024: 95 % empty, |dT|", run.walkError(few), "");
  return {};
}

/// What a changed map costs.
Status benchChange(Run& run) {
  const SplineGrid map = fogMap(512);
  for (int degree = 1; degree <= 3; ++degree) {
    const auto seconds =
        minSeconds({[&] { const FogLevels levels(map, degree, 3, Restriction::kFullWeighting); }});
    run.add(fmt::format("512 x 512: decomposed anew, degree {}, 3 levels", degree),
            1e3 * seconds[0], "ms");
  }
  return {};
}

/// What is between every corner of cells and the sun: by lines across the map against whole ways,
/// of which one row in 64 is walked.
Status benchSunSums(Run& run) {
  constexpr int kEach = 64;
  for (const int side : {512, 2048}) {
    VOLUTE_ASSIGN(const auto map, FogMap::fromCoefficients(fogMap(side), {}));
    VOLUTE_ASSIGN(const FogMedium fog, FogMedium::make(map, {}));
    const Vec3 sun = Vec3(1, 0.37, 0.3).normalized();
    const CellRect cells = fog.levels().mapCells();
    const auto columns = static_cast<std::size_t>(cells.x1 - cells.x0);
    std::vector<double> depths(columns);
    const double sums = secondsOf([&] {
      const SunSums all(fog, sun, 1, SunSums::Weight::kOne);
      std::vector<Vec2> places(columns);
      for (int j = cells.y0; j < cells.y1; ++j) {
        for (std::size_t i = 0; i < columns; ++i) places[i] = Vec2(static_cast<double>(i), j);
        all.at(places, depths);
      }
    });
    const double ways = secondsOf([&] {
      std::vector<Segment> segments(columns);
      for (int j = cells.y0; j < cells.y1; j += kEach) {
        for (std::size_t i = 0; i < columns; ++i) {
          const Vec3 place(static_cast<double>(i), j, 0);
          segments[i] = {fog.domainCorner() + fog.cell() * place, sun, 0,
                         std::numeric_limits<double>::infinity()};
        }
        marchDepths(fog, segments, depths, std::numeric_limits<float>::max());
      }
    });
    const std::string name = fmt::format("{} x {}: the sun's depths at all corners: ", side, side);
    run.add(name + "whole ways", 1e3 * kEach * ways, "ms", 1.0);
    run.add(name + "by lines, times as fast", 1e3 * sums, "ms", kEach * ways / sums);
  }
  return {};
}

/// The parts of the rays of `volute synthesize valley` that hills and trees keep the sun from, one
/// ray per pixel: its tree of what the sun sees, grown anew, against the reference, whose tree is
/// there. Both search the rays down to the ground.
Status benchSunShadows(Run& run) {
  const ::volute::Valley valley(1);
  std::vector<Triangle> triangles = valley.surfaces(2).triangles;
  for (Triangle& triangle : triangles) triangle.material = 0;
  VOLUTE_ASSIGN(const TriangleScene scene, TriangleScene::build(triangles));
  const Camera camera = Camera::pinhole(valley.view(), 50, 640, 400);
  std::vector<Segment> segments;
  for (int j = 0; j < 400; ++j) {
    for (int i = 0; i < 640; ++i) segments.push_back(camera.ray(i + 0.5, j + 0.5));
  }
  std::vector<Hit> hits(segments.size());
  scene.nearest(segments, hits);
  const Box3& bounds = scene.bounds();
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Interval inside = bounds.intersect(segments[i].origin, segments[i].direction);
    segments[i].begin = std::max(segments[i].begin, inside.begin);
    segments[i].end = std::min({segments[i].end, inside.end, hits[i].distance});
  }
  std::erase_if(segments, [](const Segment& segment) { return segment.empty(); });
  const LightPoint sun{::volute::Valley::towardsSun()};
  std::vector<Interval> dark;
  const auto all = [&](const TriangleScene& where) {
    for (const Segment& segment : segments) where.shadows(segment, sun, dark);
  };
  VOLUTE_ASSIGN(const TriangleScene reference,
                TriangleScene::build(triangles, {}, TriangleScene::Execution::kReference));
  reference.shadows(segments.front(), sun, dark);
  double exact = std::numeric_limits<double>::infinity(), fresh = exact, kept = exact;
  for (int round = 0; round < 3; ++round) {
    exact = std::min(exact, secondsOf([&] { all(reference); }));
    VOLUTE_ASSIGN(const TriangleScene fast, TriangleScene::build(triangles));
    Hit hit;
    fast.nearest({&segments.front(), 1}, {&hit, 1});  // waits for what it does in the background
    fresh = std::min(fresh, secondsOf([&] { all(fast); }));
    kept = std::min(kept, secondsOf([&] { all(fast); }));
  }
  const std::string name = fmt::format("shadows of {} triangles: ", triangles.size());
  run.add(name + "exact tracing", 1e3 * exact, "ms", 1.0);
  run.add(name + "tree of the sun made and walked, times as fast", 1e3 * fresh, "ms",
          exact / fresh);
  run.add(name + "tree of the sun walked, times as fast", 1e3 * kept, "ms", exact / kept);
  return {};
}

/// Rays of the valley over a map of side^2, in cells.
struct FlatRay {
  PlaneRay plane;
  double distance;
};

std::vector<FlatRay> flatRays(const Valley& valley, int side, int degree, std::size_t each) {
  std::vector<FlatRay> rays;
  const double perMetre = (side + degree) / kValleySide;
  for (std::size_t i = 0; i < valley.segments.size(); i += each) {
    const Segment& s = valley.segments[i];
    rays.push_back({{s.origin.x() * perMetre, s.origin.y() * perMetre, s.direction.x() * perMetre,
                     s.direction.y() * perMetre},
                    s.end});
  }
  return rays;
}

using PaperWalk = double (PaperFog::*)(const PlaneRay&, double, double) const;
constexpr std::pair<const char*, PaperWalk> kWalks[] = {
    {"undeconstructed", &PaperFog::undeconstructed},
    {"deconstructed", &PaperFog::deconstructed},
    {"merged", &PaperFog::merged}};

volatile double sink;

std::function<void()> walkAll(const PaperFog& fog, PaperWalk walk, const std::vector<FlatRay>& rays,
                              double mu) {
  return [&fog, walk, &rays, mu] {
    double sum = 0;
    for (const auto& [ray, distance] : rays) sum += (fog.*walk)(ray, distance, mu);
    sink = sum;
  };
}

/// Table 1: what degree and size cost, of the linear map of 64 x 64.
void benchTable1(Run& run) {
  constexpr int kFrames[3][3] = {{199, 142, 71}, {124, 83, 31}, {90, 45, 15}};
  const auto baseRays = flatRays(run.valley, 64, 1, 997);
  const PaperFog base(fogMap(64), 1, 0);
  for (int s = 0; s < 3; ++s) {
    for (int degree = 0; degree <= 2; ++degree) {
      const int side = 16 << s;
      const auto rays = flatRays(run.valley, side, degree, 997);
      const PaperFog fog(fogMap(side), degree, 0);
      const auto seconds = minSeconds(
          {walkAll(base, &PaperFog::merged, baseRays, 1), walkAll(fog, &PaperFog::merged, rays, 1)},
          3);
      run.add(fmt::format("table 1: {0} x {0}, degree {1}; paper {2:.2f}", side, degree,
                          kFrames[s][degree] / 45.0),
              seconds[0] / seconds[1], "x");
    }
  }
}

/// Table 2: levels and mu on the linear map of 64 x 64, of no decomposition.
void benchTable2(Run& run) {
  constexpr double kMus[] = {1, 0.8, 0.6, 0.4, 0.2, 0};
  constexpr int kFrames[3][6] = {
      {35, 39, 47, 55, 66, 83}, {31, 45, 55, 71, 90, 124}, {27, 39, 66, 76, 99, 166}};
  const auto rays = flatRays(run.valley, 64, 1, 1499);
  const PaperFog plain(fogMap(64), 1, 0);
  for (int levels = 1; levels <= 3; ++levels) {
    const PaperFog fog(fogMap(64), 1, levels);
    for (int m = 0; m < 6; ++m) {
      std::vector<std::function<void()>> works{walkAll(plain, &PaperFog::merged, rays, 1)};
      for (const auto& [name, walk] : kWalks) works.push_back(walkAll(fog, walk, rays, kMus[m]));
      const auto seconds = minSeconds(works, 5);
      for (int w = 0; w < 3; ++w) {
        run.add(fmt::format("table 2: {}, {} levels, mu {}; paper {:.2f}", kWalks[w].first, levels,
                            kMus[m], kFrames[levels - 1][m] / 45.0),
                seconds[0] / seconds[w + 1], "x");
      }
    }
  }
}

/// Table 3: what deconstruction gains, and what merging gains beyond it.
void benchTable3(Run& run) {
  struct Row {
    int side, degree;
    int frames[3][2];
  };

  constexpr Row kRows[] = {{16, 1, {{58, 111}, {47, 99}, {35, 83}}},
                           {32, 1, {{20, 62}, {15, 55}, {13, 49}}},
                           {32, 2, {{7, 23}, {5, 20}, {5, 18}}}};
  for (const Row& row : kRows) {
    const auto rays = flatRays(run.valley, row.side, row.degree, 1499);
    for (int levels = 1; levels <= 3; ++levels) {
      const PaperFog fog(fogMap(row.side), row.degree, levels);
      std::vector<std::function<void()>> works;
      for (const auto& [name, walk] : kWalks) works.push_back(walkAll(fog, walk, rays, 1));
      const auto seconds = minSeconds(works, 5);
      const std::string map =
          fmt::format("table 3: {0} x {0}, degree {1}, {2} levels: ", row.side, row.degree, levels);
      const auto& frames = row.frames[levels - 1];
      run.add(map + fmt::format("deconstruction; paper {:.2f}", double(frames[1]) / frames[0]),
              seconds[0] / seconds[1], "x");
      run.add(map + "merging, of deconstructed", seconds[1] / seconds[2], "x");
    }
  }
}

/// The three walks against each other, and the paper's sampled paths.
void benchPaths(Run& run) {
  double worst = 0;
  for (int degree = 0; degree <= 3; ++degree) {
    const auto rays = flatRays(run.valley, 64, degree, 4999);
    const PaperFog fog(fogMap(64), degree, 3), plain(fogMap(64), degree, 0);
    for (const auto& [ray, distance] : rays) {
      const double expected = plain.merged(ray, distance, 1);
      for (const auto& [name, walk] : kWalks)
        worst = std::max(worst, std::abs((fog.*walk)(ray, distance, 1) - expected));
    }
  }
  run.add("three walks at mu = 1, degrees 0 to 3: largest difference in depth", worst, "");

  const auto rays = flatRays(run.valley, 64, 1, 997);
  const SplineGrid map = fogMap(64);
  const PaperFog exact(map, 1, 0);
  for (int samples : {16, 64}) {
    const PathTable table(samples);
    const auto seconds = minSeconds({walkAll(exact, &PaperFog::merged, rays, 1),
                                     [&] {
                                       double sum = 0;
                                       for (const auto& [ray, distance] : rays)
                                         sum += table.depth(map, ray, distance);
                                       sink = sum;
                                     }},
                                    3);
    double error = 0;
    for (const auto& [ray, distance] : rays)
      error = std::max(error, std::abs(std::exp(-table.depth(map, ray, distance)) -
                                       std::exp(-exact.merged(ray, distance, 1))));
    const std::string name = fmt::format("sampled paths, {} on an edge", samples);
    run.add(name + ", of the closed form", 1e3 * seconds[1], "ms", seconds[1] / seconds[0]);
    run.add(name + ", |dT|", error, "");
  }
}

}  // namespace

Status benchFog(const BenchInput&, BenchRows& rows, Progress& progress) {
  const ThreadLimit one(1);
  Run run{rows};
  constexpr int kParts = 11;
  int done = 0;
  const auto finished = [&]() -> Status {
    progress.report("fog", ++done, kParts);
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped in the benchmark of fog");
    return {};
  };
  for (Status (*part)(Run&) : {benchSizes, benchDetail, benchProfiles, benchEmpty, benchChange,
                               benchSunSums, benchSunShadows}) {
    VOLUTE_TRY(part(run));
    VOLUTE_TRY(finished());
  }
  for (void (*part)(Run&) : {benchPaths, benchTable1, benchTable2, benchTable3}) {
    part(run);
    VOLUTE_TRY(finished());
  }
  return {};
}

}  // namespace volute::bench
