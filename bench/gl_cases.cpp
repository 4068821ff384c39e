// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/gl_cases.hpp"

#include <algorithm>
#include <cmath>

#include "bench/benchmark.hpp"
#include "volute/fog/fog_medium.hpp"
#include "volute/fog/polar_fog.hpp"
#include "volute/gl/gl_fog.hpp"
#include "volute/gl/gl_volume.hpp"
#include "volute/grid/sequence.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/render/render.hpp"

namespace volute::bench {
namespace {

constexpr int kPaperWidth = 800, kPaperHeight = 600;
constexpr int kFullWidth = 1920, kFullHeight = 1080;
constexpr double kMapMetres = 128, kFogTop = 12;  // of the fog's map and slab

Image byRender(const Camera& camera, const AnyMedium& medium) {
  Progress quiet;
  return *render(camera, {&medium, 1}, {}, quiet);
}

/// A painted map with clouds and holes, as smooth as the paper's.
SplineGrid clouds(int side) {
  SplineGrid grid(side, side);
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const double x = 13.0 * i / side, y = 13.0 * j / side;
      grid.at(i, j) = 0.03 * std::max(0.0, std::sin(x) + std::cos(1.3 * y + 0.4 * x));
    }
  }
  return grid;
}

/// From within the fog, over all of it, as a walker sees it.
Camera walkersView(int width, int height) {
  return Camera::pinhole({Vec3(8, 5, 6), Vec3(100, 110, 5)}, 60, width, height);
}

Result<FogMedium> cloudFog(int side, const FogOptions& options) {
  VOLUTE_ASSIGN(const auto map,
                FogMap::fromCoefficients(clouds(side), {.cell = kMapMetres / side}));
  VOLUTE_ASSIGN(const auto profile, FogProfile::slab(0, kFogTop));
  return FogMedium::make(map, profile, options);
}

Result<GlCase> fogCase(std::string name, int side, const FogOptions& options,
                       int width = kPaperWidth, int height = kPaperHeight) {
  VOLUTE_ASSIGN(const auto fog, cloudFog(side, options));
  const AnyMedium medium(fog);
  return stillCase(std::move(name), width, height, walkersView, {{glPart(GlFog{fog})}},
                   [=](const Camera& camera) { return byRender(camera, medium); });
}

/// Table 3: its fog as the paper walks it.
Result<GlCase> paperCase(const std::string& name, int degree, int side, int levels, bool after) {
  const PaperPicture picture{std::make_shared<const PaperFog>(clouds(side), degree, levels),
                             kMapMetres / side, 0, kFogTop, after};
  VOLUTE_ASSIGN(auto drawn, GlPaperFog::make(picture));
  GlCase one =
      stillCase(fmt::format("paper B, table 3 ({}): {}",
                            after ? "after, bands in splines" : "before, four bases", name),
                kPaperWidth, kPaperHeight, walkersView, {},
                [=](const Camera& camera) { return byCpu(picture, camera); });
  one.paperFog = std::make_shared<GlPaperFog>(std::move(drawn));
  return one;
}

/// By a table for the eye, which is filled in every frame.
Result<GlCase> polarCase(std::string name) {
  VOLUTE_ASSIGN(const auto fog, cloudFog(64, {.degree = 1}));
  return stillCase(std::move(name), kFullWidth, kFullHeight, walkersView,
                   {{glPart(GlFog{fog, 1, [](const Camera&) { return PolarOptions{}; }})}},
                   [=](const Camera& camera) {
                     return byRender(camera, AnyMedium(*PolarFog::make(fog, camera.eye())));
                   });
}

Status addTree(const std::string& name, const Sequence& sequence, double error, bool quick,
               Progress& progress, std::vector<GlCase>& cases) {
  const int pixels = quick ? 96 : 256;
  const VolumeInfo& info = sequence.info;
  const double extinction = 4 / info.bounds.size().maxCoeff();
  SequenceSource source(sequence);
  VOLUTE_ASSIGN(auto built, Tree4d::build(source, {.relativeRms = error}, progress));
  const auto tree = std::make_shared<const Tree4d>(std::move(built));
  const int frame = info.frames / 2;
  const auto slice = std::make_shared<const BrickSlice>(tree->extractSlice(frame));
  const AnyMedium medium(VoxelMedium(slice, 1, extinction));
  const auto view = [bounds = info.bounds](int width, int height) {
    return Camera::framing(bounds, width, height);
  };
  // From the tree to the picture, as OpenGL does.
  const auto fromTree = [=](const Camera& camera) {
    const auto extracted = std::make_shared<const BrickSlice>(tree->extractSlice(frame));
    return byRender(camera, AnyMedium(VoxelMedium(extracted, 1, extinction)));
  };
  const double bits = 8.0 * static_cast<double>(tree->memoryBytes()) /
                      (static_cast<double>(info.frameValues()) * info.frames);
  const std::string rate =
      fmt::format("paper A: {}, {:.3g} bits a value (RMS {:g})", name, bits, error);
  constexpr std::pair<GlTreeSkip, const char*> kSkips[] = {
      {GlTreeSkip::kNothing, "tree, without bounding boxes"},
      {GlTreeSkip::kBox, "tree, with bounding boxes"},
      {GlTreeSkip::kBricks, "tree, empty bricks stepped over"}};
  for (const auto& [skip, words] : kSkips) {
    GlTreeVolume walked{tree, frame, Basis::kBox, info.bounds, 1, extinction};
    walked.skip = skip;
    cases.push_back(stillCase(fmt::format("{}, {}", rate, words), pixels, pixels, view,
                              {{glPart(walked)}}, fromTree));
    cases.back().asLargeAsLast = skip != GlTreeSkip::kNothing;
  }
  cases.push_back(stillCase(rate + ", bricks that are not empty", pixels, pixels, view,
                            {{glPart(GlVolume{slice, 1, extinction})}},
                            [=](const Camera& camera) { return byRender(camera, medium); }));
  return {};
}

}  // namespace

GlCase stillCase(std::string name, int width, int height,
                 std::function<Camera(int width, int height)> camera, GlScene scene,
                 std::function<Image(const Camera&)> byCpu) {
  const auto shared = std::make_shared<const GlScene>(std::move(scene));
  return {std::move(name),
          width,
          height,
          [view = std::move(camera)](int, int w, int h) { return view(w, h); },
          [=](int) -> const GlScene& { return *shared; },
          [drawn = std::move(byCpu)](const Camera& from, int) { return drawn(from); }};
}

Status addTrees(const BenchInput& input, Progress& progress, std::vector<GlCase>& cases) {
  constexpr int kSide = 64;
  BenchInput voxels = input;
  if (isMeshInput(input))
    voxels.volume.clear();
  VOLUTE_ASSIGN(const auto sequences, benchSequences(voxels, progress, input.quick ? 32 : kSide));
  for (const auto& [name, sequence] : sequences) {
    for (const double error : input.quick ? std::vector{0.03} : std::vector{0.003, 0.01, 0.03, 0.1})
      VOLUTE_TRY(addTree(name, sequence, error, input.quick, progress, cases));
  }
  if (input.quick)
    return {};
  const auto& [name, sequence] = sequences.front();
  const VolumeInfo& info = sequence.info;
  const auto view = [bounds = info.bounds](int width, int height) {
    return Camera::framing(bounds, width, height);
  };
  for (const Basis basis : {Basis::kBox, Basis::kTrilinear}) {
    const double extinction = 4 / info.bounds.size().maxCoeff();
    VolumeInfo shown = info;
    shown.basis = basis;
    const auto slice = std::make_shared<const BrickSlice>(
        BrickSlice::fromDense(shown, sequence.frame(info.frames / 2)));
    const AnyMedium medium(VoxelMedium(slice, 1, extinction));
    cases.push_back(stillCase(fmt::format("{}, {} x {} x {} voxels, {}", name, info.x, info.y,
                                          info.z, basis == Basis::kBox ? "box" : "trilinear"),
                              kFullWidth, kFullHeight, view,
                              {{glPart(GlVolume{slice, 1, extinction})}},
                              [=](const Camera& camera) { return byRender(camera, medium); }));
  }
  return {};
}

Status addFogTables(bool quick, std::vector<GlCase>& cases) {
  const auto add = [&](std::string name, int side, const FogOptions& options) -> Status {
    VOLUTE_ASSIGN(auto one, fogCase(std::move(name), side, options));
    cases.push_back(std::move(one));
    return {};
  };
  using DegreeAndSide = std::pair<int, int>;
  const std::vector<DegreeAndSide> table3 =
      quick ? std::vector<DegreeAndSide>{{1, 16}}
            : std::vector<DegreeAndSide>{{1, 16}, {1, 32}, {2, 32}};
  constexpr const char* kDegrees[] = {"Haar", "linear", "quadratic"};
  for (const int side : quick ? std::vector{32} : std::vector{16, 32, 64}) {
    for (int degree = 0; degree <= 2; ++degree) {
      VOLUTE_TRY(add(fmt::format("paper B, table 1: {} {} x {}", kDegrees[degree], side, side),
                     side, {.degree = degree}));
    }
  }
  for (const int levels : quick ? std::vector{3} : std::vector{1, 2, 3}) {
    for (const double mu :
         quick ? std::vector{1.0, 0.0} : std::vector{1.0, 0.8, 0.6, 0.4, 0.2, 0.0}) {
      VOLUTE_TRY(add(fmt::format("paper B, table 2: {} levels, mu {:g}", levels, mu), 64,
                     {.degree = 1, .levels = levels, .detail = {.mu = mu}}));
    }
  }
  for (const auto& [degree, side] : table3) {
    for (int levels = quick ? 3 : 1; levels <= 3; ++levels) {
      const std::string name =
          fmt::format("{} {} x {}, {} levels", kDegrees[degree], side, side, levels);
      for (const bool after : {false, true}) {
        VOLUTE_ASSIGN(auto one, paperCase(name, degree, side, levels, after));
        one.asLargeAsLast = after;
        cases.push_back(std::move(one));
      }
      VOLUTE_TRY(add("paper B, table 3 (levels merged): " + name, side,
                     {.degree = degree, .levels = levels}));
      cases.back().asLargeAsLast = true;
    }
  }
  if (quick)
    return {};
  VOLUTE_ASSIGN(auto walked,
                fogCase("fog, linear 64 x 64, walked", 64, {.degree = 1}, kFullWidth, kFullHeight));
  cases.push_back(std::move(walked));
  VOLUTE_ASSIGN(auto polar, polarCase("fog, linear 64 x 64, by a polar table"));
  cases.push_back(std::move(polar));
  return {};
}

}  // namespace volute::bench
