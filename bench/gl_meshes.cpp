// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/benchmark.hpp"
#include "bench/gl_cases.hpp"
#include "bench/smoke_views.hpp"
#include "volute/gl/gl_smoke.hpp"
#include "volute/tetmesh/tet_splat.hpp"

namespace volute::bench {
namespace {

constexpr int kMotionFrames = 4;

/// Some snapshots of smoke, and what the CPU draws of them.
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

  Image draw(const Camera& camera, int time, std::span<const Sign> signs) {
    show(time);
    Image image(camera.width(), camera.height());
    const std::size_t pixels = image.pixels.size() / 3;
    const auto found = signs.empty() ? std::vector<SignPixel>() : signPixels(camera, signs, {});
    std::vector<float> ends, passed(pixels);
    if (!signs.empty())
      ends.assign(pixels, std::numeric_limits<float>::infinity());
    for (const SignPixel& pixel : found) ends[pixel.pixel] = pixel.distance;
    std::vector<float> rgbt(4 * pixels);
    splat.litColor(camera, ends, rgbt);
    for (std::size_t i = 0; i < pixels; ++i) {
      std::copy_n(&rgbt[4 * i], 3, &image.pixels[3 * i]);
      passed[i] = rgbt[4 * i + 3];
    }
    for (const SignPixel& pixel : found) {
      for (int c = 0; c < 3; ++c) {
        image.pixels[3 * pixel.pixel + c] +=
            pixel.radiance[c] * std::pow(passed[pixel.pixel], kEmittingPower);
      }
    }
    return image;
  }
};

struct DrawMethod {
  const char* name;
  GlSmokeMethod method;
};

constexpr DrawMethod kDrawMethods[] = {{"marched, lit", GlSmokeMethod::kMarch},
                                       {"projected tetrahedra, lit", GlSmokeMethod::kProject}};

struct Motion {
  bool smoke = false, camera = false;
};

using View = std::function<Camera(int frame, bool moving, int width, int height)>;

/// The smoke at each time, drawn by one method.
using Scenes = std::shared_ptr<const std::vector<GlScene>>;

Scenes scenesOf(const AnimatedSmoke& smoke, const DrawMethod& drawn) {
  std::vector<GlScene> scenes;
  for (const auto& extinction : smoke.extinctions) {
    scenes.push_back({{glPart(GlSmoke{smoke.locator, extinction, smoke.source, drawn.method})}});
  }
  return std::make_shared<const std::vector<GlScene>>(std::move(scenes));
}

GlCase smokeCase(std::string name, const std::shared_ptr<AnimatedSmoke>& smoke,
                 const Scenes& scenes, const Motion& motion, const View& view,
                 std::vector<Sign> signs = {}) {
  const auto timeOf = [=](int k) { return motion.smoke ? k % kMotionFrames : 0; };
  GlCase one;
  one.name = std::move(name);
  one.camera = [=](int k, int width, int height) {
    return view(k % kMotionFrames, motion.camera, width, height);
  };
  one.scene = [=](int k) -> const GlScene& {
    return (*scenes)[static_cast<std::size_t>(timeOf(k))];
  };
  one.byCpu = [=](const Camera& camera, int k) { return smoke->draw(camera, timeOf(k), signs); };
  one.signs = std::move(signs);
  return one;
}

constexpr Motion kMotions[] = {{false, false}, {true, false}, {false, true}, {true, true}};

std::string words(const Motion& motion) {
  return fmt::format("{} smoke, {} camera", motion.smoke ? "animated" : "steady",
                     motion.camera ? "animated" : "fixed");
}

/// Before the eye, far enough for smoke to be between.
Sign exitSign(const Vec3& eye, const Vec3& target) {
  const Vec3 towards = target - eye;
  Sign sign;
  sign.name = "exit";
  sign.position = eye + 0.8 * towards;
  sign.normal = Vec3(-towards.x(), -towards.y(), 0);
  sign.width = 0.08 * towards.norm();
  sign.height = 0.5 * sign.width;
  sign.c = 8;
  sign.picture = exitPicture();
  return sign;
}

}  // namespace

void addHall(const GlExtent& extent, std::vector<GlCase>& cases) {
  // About as many tets as the paper's hall, 120,925.
  const auto smoke =
      std::make_shared<AnimatedSmoke>(madeSmokeCase("made hall", extent.quick ? 1.2 : 0.46));
  const TetMesh& mesh = smoke->locator->mesh();
  const Vec3 middle = mesh.bounds().centre();
  const Vec3 eye = mesh.bounds().min + mesh.bounds().size().cwiseProduct(Vec3(0.1, 0.2, 0.6));
  const View view = [=](int frame, bool moving, int width, int height) {
    const Vec3 from = moving ? Vec3(eye + 0.15 * frame * Vec3(1, 0.3, 0)) : eye;
    // A fixed camera stands still and turns.
    return Camera::pinhole({from, middle + 0.5 * frame * Vec3(0, 1, 0)}, 60, width, height);
  };
  const Sign sign = exitSign(eye, middle);
  for (const DrawMethod& drawn : kDrawMethods) {
    const Scenes scenes = scenesOf(*smoke, drawn);
    const std::string name =
        fmt::format("paper C, table 3: hall, {} tets, {}", mesh.tets().size(), drawn.name);
    for (const Motion& motion : kMotions) {
      cases.push_back(smokeCase(name + ", " + words(motion), smoke, scenes, motion, view));
    }
    for (const Motion& motion : kMotions) {
      if (!extent.hardware && (motion.smoke != motion.camera || (extent.quick && motion.smoke)))
        continue;
      cases.push_back(
          smokeCase(name + ", exit sign, " + words(motion), smoke, scenes, motion, view, {sign}));
    }
  }
}

Status addMall(const BenchInput& input, const GlExtent& extent, std::vector<GlCase>& cases) {
  SmokeCase mall;
  if (isMeshInput(input)) {
    VOLUTE_ASSIGN(mall, readSmokeCase(input));
  } else {  // as many tets as the paper's Mall, 1,724,811
    mall = madeSmokeCase("made mall", input.quick ? 1.2 : 0.19);
  }
  const std::string name = mall.name;
  const auto smoke = std::make_shared<AnimatedSmoke>(std::move(mall));
  std::vector<Scenes> scenes;
  for (const DrawMethod& drawn : kDrawMethods) scenes.push_back(scenesOf(*smoke, drawn));
  for (const SmokeEye& eye : smokeEyes(*smoke->locator)) {
    const Vec3 towards = eye.target - eye.eye;
    const Vec3 across = towards.cross(Vec3::UnitZ()).normalized();
    const View view = [=](int frame, bool moving, int width, int height) {
      const Vec3 step = 0.005 * towards.norm() * frame * across;
      const Vec3 from = moving ? Vec3(eye.eye + step) : eye.eye;
      return Camera::pinhole({from, Vec3(eye.target + 2 * step)}, eye.fov, width, height);
    };
    for (std::size_t i = 0; i < std::size(kDrawMethods); ++i) {
      const DrawMethod& drawn = kDrawMethods[i];
      if (input.quick && drawn.method == GlSmokeMethod::kProject)
        continue;
      for (const Motion& motion : kMotions) {
        if (!extent.hardware && !(motion.smoke && motion.camera))
          continue;
        GlCase one = smokeCase(
            fmt::format("paper C, table 3: {}, {} tets, {}, {}, {}", name,
                        smoke->locator->mesh().tets().size(), eye.name, drawn.name, words(motion)),
            smoke, scenes[i], motion, view);
        one.width = 1920, one.height = 1080;
        cases.push_back(std::move(one));
      }
    }
  }
  return {};
}

}  // namespace volute::bench
