// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "volute/cli/benchmarks/benchmarks.hpp"
#include "volute/cli/benchmarks/gl_cases.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_splat.hpp"

namespace volute::cli {
namespace {

constexpr int kFrames = 4;
/// Extinction of 1 g/m3 of soot [1/m], as `volute bench smoke` has it.
constexpr float kPerGram = 0.15F;

/// Some instants of smoke, and what the processor draws of them.
struct AnimatedSmoke {
  std::shared_ptr<const TetLocator> locator;
  std::vector<std::vector<float>> extinctions;  // of each time
  std::vector<float> source;
  TetSplat splat;
  int set = -1;  // the time that the splat holds

  AnimatedSmoke(const std::shared_ptr<const TetMesh>& mesh, std::vector<std::vector<float>> grams)
      : locator(std::make_shared<const TetLocator>(mesh)),
        extinctions(std::move(grams)),
        source(3 * mesh->vertices().size(), 0.8F),
        splat(locator) {
    for (auto& extinction : extinctions) {
      for (float& value : extinction) value *= kPerGram;
    }
    splat.setSource(source);
  }

  void show(int time) {
    if (set == time)
      return;
    set = time;
    splat.setExtinction(extinctions[static_cast<std::size_t>(time)]);
  }

  Image lit(const Camera& camera, int time) {
    show(time);
    Image image(camera.width(), camera.height());
    std::vector<float> rgbt(4 * image.pixels.size() / 3);
    splat.litColor(camera, {}, rgbt);
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

struct Way {
  const char* name;
  GlSmokeMethod method;
  bool lit;
};

constexpr Way kWays[] = {{"marched, lit", GlSmokeMethod::kMarch, true},
                         {"projected tetrahedra, lit", GlSmokeMethod::kProject, true},
                         {"splat, transmittance", GlSmokeMethod::kSplat, false}};

struct Motion {
  bool smoke = false, camera = false;
};

using View = std::function<Camera(int frame, bool moving, int width, int height)>;

GlCase smokeCase(std::string name, const std::shared_ptr<AnimatedSmoke>& smoke, const Way& way,
                 const Motion& motion, const View& view) {
  auto scenes = std::make_shared<std::vector<GlScene>>();
  for (int t = 0; t < (motion.smoke ? kFrames : 1); ++t) {
    GlSmoke shown{smoke->locator, smoke->extinctions[static_cast<std::size_t>(t)], {}};
    if (way.lit)
      shown.source = smoke->source;
    scenes->push_back({.smokes = {std::move(shown)}, .smokeMethod = way.method});
  }
  GlCase one;
  one.name = std::move(name);
  one.camera = [=](int k, int width, int height) {
    return view(k % kFrames, motion.camera, width, height);
  };
  one.scene = [=](int k) -> const GlScene& {
    return (*scenes)[static_cast<std::size_t>(k) % scenes->size()];
  };
  one.byProcessor = [=](const Camera& camera, int k) {
    const int time = motion.smoke ? k % kFrames : 0;
    return way.lit ? smoke->lit(camera, time) : smoke->black(camera, time);
  };
  if (!way.lit)
    one.background = Rgb::Ones();
  return one;
}

/// The last instant of a mesh, and shares of it as the others.
Result<std::shared_ptr<AnimatedSmoke>> readSmoke(const std::string& file) {
  VOLUTE_ASSIGN(auto source,
                MeshSource::open(file, {.field = "smoke", .negatives = Negatives::kClamp}));
  VOLUTE_ASSIGN(auto frame, source.read(source.times().size() - 1));
  std::vector<std::vector<float>> grams{std::move(frame.values)};
  for (const float share : {0.97F, 0.94F, 0.91F}) {
    auto& thinner = grams.emplace_back(grams.front());
    for (float& value : thinner) value *= share;
  }
  return std::make_shared<AnimatedSmoke>(frame.mesh, std::move(grams));
}

std::shared_ptr<AnimatedSmoke> makeSmoke(double cell) {
  const auto mesh = hallMesh(cell, 1);
  std::vector<std::vector<float>> grams;
  for (int t = 0; t < kFrames; ++t) grams.push_back(plume(*mesh, 0.4 * t, 1));
  return std::make_shared<AnimatedSmoke>(mesh, std::move(grams));
}

}  // namespace

void addHall(bool quick, std::vector<GlCase>& cases) {
  // About as many tets as the paper's hall, 120,925.
  const auto smoke = makeSmoke(quick ? 1.2 : 0.46);
  const TetMesh& mesh = smoke->locator->mesh();
  const Vec3 middle = mesh.bounds().centre();
  const Vec3 eye = mesh.bounds().min + mesh.bounds().size().cwiseProduct(Vec3(0.1, 0.2, 0.6));
  const View view = [=](int frame, bool moving, int width, int height) {
    const Vec3 from = moving ? Vec3(eye + 0.15 * frame * Vec3(1, 0.3, 0)) : eye;
    // A fixed camera stands still and turns.
    return Camera::pinhole({from, middle + 0.5 * frame * Vec3(0, 1, 0)}, 60, width, height);
  };
  for (const Way& way : kWays) {
    for (const Motion& motion :
         {Motion{false, false}, Motion{true, false}, Motion{false, true}, Motion{true, true}}) {
      cases.push_back(
          smokeCase(fmt::format("paper C, table 3: {} tets, {}, {} smoke, {} camera",
                                mesh.tets().size(), way.name, motion.smoke ? "animated" : "steady",
                                motion.camera ? "animated" : "fixed"),
                    smoke, way, motion, view));
    }
  }
}

Status addMall(const BenchInput& input, std::vector<GlCase>& cases) {
  std::shared_ptr<AnimatedSmoke> smoke;
  std::string name;
  if (isMeshInput(input)) {
    VOLUTE_ASSIGN(smoke, readSmoke(input.volume));
    name = std::filesystem::path(input.volume).filename().string();
  } else {
    smoke = makeSmoke(input.quick ? 1.2 : 0.19);  // as many tets as the paper's Mall, 1,724,811
    name = "made mall";
  }
  const Box3 box = smoke->locator->mesh().bounds();
  const auto at = [&](double x, double y, double z) {
    return Vec3(box.min + box.size().cwiseProduct(Vec3(x, y, z)));
  };

  struct Eye {
    const char* name;
    Vec3 eye, target;
    double fov;
  };

  // As `volute bench smoke` has them.
  const Eye eyes[] = {{"outside", at(-0.32, -1.2, 2.3), at(0.5, 0.5, 0.33), 36},
                      {"inside", at(0.08, 0.57, 0.28), at(0.86, 0.5, 0.4), 60}};
  for (const Eye& eye : eyes) {
    const Vec3 towards = eye.target - eye.eye;
    const Vec3 across = towards.cross(Vec3::UnitZ()).normalized();
    const View view = [=](int frame, bool, int width, int height) {
      const Vec3 step = 0.005 * towards.norm() * frame * across;
      return Camera::pinhole({Vec3(eye.eye + step), Vec3(eye.target + 2 * step)}, eye.fov, width,
                             height);
    };
    for (const Way& way : kWays) {
      if (input.quick && way.method == GlSmokeMethod::kProject)
        continue;
      GlCase one = smokeCase(fmt::format("{}, {} tets, {}: {}, animated smoke and camera", name,
                                         smoke->locator->mesh().tets().size(), eye.name, way.name),
                             smoke, way, {true, true}, view);
      one.width = 1920, one.height = 1080;
      cases.push_back(std::move(one));
    }
  }
  return {};
}

}  // namespace volute::cli
