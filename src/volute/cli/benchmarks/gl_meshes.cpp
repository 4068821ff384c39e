// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>

#include "volute/cli/benchmarks/benchmarks.hpp"
#include "volute/cli/benchmarks/gl_cases.hpp"
#include "volute/cli/benchmarks/smoke_views.hpp"
#include "volute/tetmesh/tet_splat.hpp"

namespace volute::cli {
namespace {

constexpr int kFrames = 4;

/// Some instants of smoke, and what the processor draws of them.
struct AnimatedSmoke {
  std::shared_ptr<const TetLocator> locator;
  std::vector<std::vector<float>> extinctions;  // of each time
  std::vector<float> source;
  TetSplat splat;
  int set = -1;  // the time that the splat holds

  explicit AnimatedSmoke(SmokeCase smoke)
      : locator(std::make_shared<const TetLocator>(smoke.mesh)),
        extinctions(std::move(smoke.extinction)),
        source(3 * smoke.mesh->vertices().size(), 0.8F),
        splat(locator) {
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

}  // namespace

void addHall(bool quick, std::vector<GlCase>& cases) {
  // About as many tets as the paper's hall, 120,925.
  const auto smoke =
      std::make_shared<AnimatedSmoke>(madeSmokeCase("made hall", quick ? 1.2 : 0.46));
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
  SmokeCase mall;
  if (isMeshInput(input)) {
    VOLUTE_ASSIGN(mall, readSmokeCase(input));
  } else {  // as many tets as the paper's Mall, 1,724,811
    mall = madeSmokeCase("made mall", input.quick ? 1.2 : 0.19);
  }
  const std::string name = mall.name;
  const auto smoke = std::make_shared<AnimatedSmoke>(std::move(mall));
  for (const SmokeEye& eye : smokeEyes(*smoke->locator)) {
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
