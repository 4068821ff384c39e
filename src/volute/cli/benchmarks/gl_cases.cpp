// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/benchmarks/gl_cases.hpp"

#include <algorithm>
#include <cmath>

#include "volute/cli/benchmarks/benchmarks.hpp"
#include "volute/fog/fog_medium.hpp"
#include "volute/grid/sequence.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/render/render.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_marcher.hpp"
#include "volute/tetmesh/tet_splat.hpp"

namespace volute::cli {
namespace {

/// The papers' pictures have 800 x 600 pixels.
struct Size {
  int width = 800, height = 600;

  static Size of(bool quick) { return quick ? Size{160, 120} : Size{}; }
};

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
Result<GlCase> fogCase(std::string name, int side, const FogOptions& options, const Size& size) {
  VOLUTE_ASSIGN(const auto map, FogMap::fromCoefficients(clouds(side), {.cell = 128.0 / side}));
  VOLUTE_ASSIGN(const auto profile, FogProfile::slab(0, 12));
  VOLUTE_ASSIGN(const auto fog, FogMedium::make(map, profile, options));
  const Camera camera =
      Camera::pinhole({Vec3(8, 5, 6), Vec3(100, 110, 5)}, 60, size.width, size.height);
  const AnyMedium medium(fog);
  return stillCase(std::move(name), camera, {.fogs = {fog}},
                   [=] { return byRender(camera, medium); });
}

/// What the processor draws of smoke with the twin of a method.
struct HallSmoke {
  std::shared_ptr<const TetLocator> locator;
  std::vector<std::vector<float>> extinctions;  // of each time
  std::vector<float> source;
  TetMarcher marcher;
  TetSplat splat;
  int set = -1;  // the time that marcher and splat hold

  HallSmoke(std::shared_ptr<const TetLocator> of, int times)
      : locator(std::move(of)), marcher(locator), splat(locator) {
    for (int t = 0; t < times; ++t) {
      extinctions.push_back(plume(locator->mesh(), 0.4 * t, 1));
      for (float& value : extinctions.back()) value *= 0.15F;
    }
    source.assign(3 * extinctions[0].size(), 0.8F);
    marcher.setSource(source);
  }

  void show(int time) {
    if (set == time)
      return;
    set = time;
    marcher.setExtinction(extinctions[time]);
    splat.setExtinction(extinctions[time]);
  }

  Image lit(const Camera& camera, int time) {
    show(time);
    Image image(camera.width(), camera.height());
    std::vector<float> rgbt(4 * image.pixels.size() / 3);
    marcher.litColor(camera, {}, rgbt);
    for (std::size_t i = 0; i < rgbt.size() / 4; ++i)
      std::copy_n(&rgbt[4 * i], 3, &image.pixels[3 * i]);
    return image;
  }

  /// Black smoke before black is black: so its transmittance before white.
  Image black(const Camera& camera, int time) {
    show(time);
    Image image(camera.width(), camera.height());
    std::vector<float> depth(image.pixels.size() / 3);
    splat.opticalDepth(camera, {}, depth);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = std::exp(-depth[i / 3]);
    return image;
  }
};

}  // namespace

GlCase stillCase(std::string name, const Camera& camera, GlScene scene,
                 std::function<Image()> byProcessor) {
  const auto shared = std::make_shared<const GlScene>(std::move(scene));
  return {std::move(name), 1, [=](int) { return camera; },
          [=](int) -> const GlScene& { return *shared; },
          [drawn = std::move(byProcessor)](int) { return drawn(); }};
}

Status addTrees(const BenchInput& input, Progress& progress, std::vector<GlCase>& cases) {
  const int kPixels = input.quick ? 96 : 256;
  VOLUTE_ASSIGN(const auto sequences, benchSequences(input, progress, input.quick ? 32 : 64));
  for (const auto& [name, sequence] : sequences) {
    const VolumeInfo& info = sequence.info;
    const Camera camera = Camera::framing(info.bounds, kPixels, kPixels);
    const double extinction = 4 / info.bounds.size().maxCoeff();
    for (const double error :
         input.quick ? std::vector{0.03} : std::vector{0.003, 0.01, 0.03, 0.1}) {
      SequenceSource source(sequence);
      VOLUTE_ASSIGN(auto built, Tree4d::build(source, {.relativeRms = error}, progress));
      const auto tree = std::make_shared<const Tree4d>(std::move(built));
      const int frame = info.frames / 2;
      const auto slice = std::make_shared<const BrickSlice>(tree->extractSlice(frame));
      const AnyMedium medium(VoxelMedium(slice, 1, extinction));
      const auto byProcessor = [=] { return byRender(camera, medium); };
      const std::string rate = fmt::format("paper A: {}, RMS {:g}", name, error);
      cases.push_back(stillCase(rate + ", tree walked in place", camera,
                                {.trees = {{tree, frame, Basis::kBox, info.bounds, 1, extinction}}},
                                byProcessor));
      cases.push_back(stillCase(rate + ", bricks that are not empty", camera,
                                {.volumes = {{slice, 1, extinction}}}, byProcessor));
    }
  }
  return {};
}

Status addFogTables(bool quick, std::vector<GlCase>& cases) {
  const Size size = Size::of(quick);
  const auto add = [&](std::string name, int side, const FogOptions& options) -> Status {
    VOLUTE_ASSIGN(auto one, fogCase(std::move(name), side, options, size));
    cases.push_back(std::move(one));
    return {};
  };
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
  if (quick)
    return {};
  for (const auto& [degree, side] : {std::pair{1, 16}, {1, 32}, {2, 32}}) {
    for (int levels = 1; levels <= 3; ++levels) {
      VOLUTE_TRY(add(fmt::format("paper B, table 3 (after): {} {} x {}, {} levels",
                                 kDegrees[degree], side, side, levels),
                     side, {.degree = degree, .levels = levels}));
    }
  }
  return {};
}

void addHall(bool quick, std::vector<GlCase>& cases) {
  constexpr int kFrames = 4;
  const Size size = Size::of(quick);
  // About as many tets as the paper's hall, 120,925.
  const auto mesh = hallMesh(quick ? 1.2 : 0.46, 1);
  const auto smoke = std::make_shared<HallSmoke>(std::make_shared<const TetLocator>(mesh), kFrames);
  const Vec3 middle = mesh->bounds().centre();
  const Vec3 eye = mesh->bounds().min + mesh->bounds().size().cwiseProduct(Vec3(0.1, 0.2, 0.6));
  const auto view = [=](int frame, bool moving) {
    const Vec3 from = moving ? Vec3(eye + 0.15 * frame * Vec3(1, 0.3, 0)) : eye;
    // A fixed camera stands still and turns.
    return Camera::pinhole({from, middle + 0.5 * frame * Vec3(0, 1, 0)}, 60, size.width,
                           size.height);
  };
  const std::pair<const char*, GlSmokeMethod> methods[] = {
      {"marched, lit", GlSmokeMethod::kMarch},
      {"projected tetrahedra, lit", GlSmokeMethod::kProject},
      {"splat, black", GlSmokeMethod::kSplat}};
  for (const auto& [name, method] : methods) {
    for (const bool moving : {false, true}) {
      for (const bool animated : {false, true}) {
        auto scenes = std::make_shared<std::vector<GlScene>>();
        for (int t = 0; t < (animated ? kFrames : 1); ++t) {
          GlSmoke shown{smoke->locator, smoke->extinctions[t], {}};
          if (method != GlSmokeMethod::kSplat)
            shown.source = smoke->source;
          scenes->push_back({.smokes = {std::move(shown)}, .smokeMethod = method});
        }
        const bool black = method == GlSmokeMethod::kSplat;
        cases.push_back(
            {fmt::format("paper C, table 3: {} tets, {}, {} smoke, {} camera", mesh->tets().size(),
                         name, animated ? "animated" : "steady", moving ? "animated" : "fixed"),
             kFrames, [=](int k) { return view(k % kFrames, moving); },
             [=](int k) -> const GlScene& {
               return (*scenes)[static_cast<std::size_t>(k) % scenes->size()];
             },
             [=](int k) {
               const int time = animated ? k % kFrames : 0;
               const Camera camera = view(k % kFrames, moving);
               return black ? smoke->black(camera, time) : smoke->lit(camera, time);
             }});
      }
    }
  }
}

}  // namespace volute::cli
