// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench tomography`: what each method makes of 8 views of 180 x 144 of a made-up fire and
// of smoke, or of a capture whose true volume is known, and how long the products with the
// projection matrix take beside an explicit sparse one.
#include <cmath>

#include "bench/benchmark.hpp"
#include "bench/timing.hpp"
#include "bench/tomography_scenes.hpp"
#include "volute/capture/open_capture.hpp"
#include "volute/tomography/project.hpp"
#include "volute/tomography/reconstruct.hpp"

namespace volute::bench {
namespace {

TomographyOptions options(TomographySolver solver, Basis basis, int rays,
                          Regularization regularization, double lambda, int iterations) {
  TomographyOptions o;
  o.solver = solver;
  o.basis = basis;
  o.raysPerPixel = rays;
  o.regularization = regularization;
  o.lambda = lambda;
  o.iterations = iterations;
  return o;
}

/// What NumPy and SciPy made of fire and smoke from 8 views of 180 x 144 (64^3, one sparse matrix),
/// each scored by 24 other views: a yardstick of that scene, not of this one.
struct Yardstick {
  double psnr = NAN, relative = NAN, volume = NAN;
};

struct Method {
  std::string name;
  TomographyOptions options;
  Yardstick fire{}, smoke{};
};

constexpr std::string_view kPlain = "APG trilinear, 200, 2x2 rays";

std::vector<Method> methods() {
  using enum TomographySolver;
  using R = Regularization;
  const Basis box = Basis::kBox, hat = Basis::kTrilinear;
  auto unconstrained = options(kSirt, hat, 1, R::kNone, 0, 200);
  unconstrained.nonNegative = false;
  auto weak = options(kApg, hat, 4, R::kTv, 1e-5, 200), strong = weak;
  weak.sparsity = strong.sparsity = 0;
  strong.lambda = 1e-4;
  const Yardstick bestFire{61.6, .026, .168}, bestSmoke{45.8, .066};
  return {{"SIRT unconstrained, 200", unconstrained, {52.3, .076, .309}, {39.4, .139}},
          {"SIRT, 200", options(kSirt, hat, 1, R::kNone, 0, 200), {56.5, .047, .234}, {42.6, .095}},
          {"CGLS and clamp, 100",
           options(kCgls, hat, 1, R::kNone, 0, 100),
           {51.8, .081, .283},
           {38.9, .147}},
          {"MLEM, 200", options(kMlem, hat, 1, R::kNone, 0, 200), {57.7, .041, .215}, {45.2, .071}},
          {"APG box, 50", options(kApg, box, 1, R::kNone, 0, 50), {54.6}, {43.0, .091}},
          {"APG trilinear, 200",
           options(kApg, hat, 1, R::kNone, 0, 200),
           {60.5, .030, .184},
           {44.5, .077}},
          {std::string(kPlain),
           options(kApg, hat, 4, R::kNone, 0, 200),
           {61.6, .026, .168},
           {44.7, .075}},
          {"APG, wavelets 1e-4", options(kApg, hat, 4, R::kWavelet, 1e-4, 200)},
          {"APG, smooth 1e-4", options(kApg, hat, 4, R::kSmooth, 1e-4, 200)},
          {"APG, TV 1e-5", weak, {60.6, .029, .180}},
          {"APG, TV 1e-4", strong, {}, {45.8, .066}},
          {"APG, TV 1e-5, sparse", options(kApg, hat, 4, R::kTv, 1e-5, 200)},
          {"auto", TomographyOptions{}, bestFire, bestSmoke}};
}

bool isAutomatic(const Method& method) {
  return method.name == "auto";
}

/// The best without a prior, and what is taken by default.
bool isBest(const Method& method) {
  return isAutomatic(method) || method.name == kPlain;
}

std::string noteOf(double yardstick) {
  return std::isnan(yardstick) ? std::string() : fmt::format("(yardstick {})", yardstick);
}

Status addQuality(const FilmedScene& scene, const std::string& prefix, const Method& method,
                  const Yardstick& yardstick, Progress& progress, BenchRows& rows) {
  progress.report(fmt::format("{}: {}", prefix, method.name), 0, 0);
  const auto begin = Clock::now();
  VOLUTE_ASSIGN(const Reconstruction done,
                reconstruct(scene.views, scene.geometry, method.options, {}, progress));
  const double time = secondsSince(begin);
  const SceneQuality quality = qualityOf(scene, done.volume, method.options.basis);
  const std::string name = fmt::format("{}: {}", prefix, method.name);
  auto add = [&](std::string_view what, double value, std::string_view unit, std::string note) {
    rows.add({.name = fmt::format("{}, {}", name, what),
              .value = value,
              .unit = std::string(unit),
              .note = std::move(note)});
  };
  add("other views", quality.psnr, "dB", noteOf(yardstick.psnr));
  add("other views", quality.relative, "relative L2", noteOf(yardstick.relative));
  add("volume", quality.volume, "relative L2", noteOf(yardstick.volume));
  add("time", time, "s", fmt::format("({} iterations)", done.iterations));
  return {};
}

/// Every method on the pictures as they are; of quick runs the best.
Status addMethods(const FilmedScene& scene, bool smoke, bool quick, Progress& progress,
                  BenchRows& rows) {
  for (const Method& method : methods()) {
    if (quick && !isBest(method))
      continue;
    const Yardstick& yardstick = smoke ? method.smoke : method.fire;
    VOLUTE_TRY(addQuality(scene, scene.name, method, yardstick, progress, rows));
  }
  return {};
}

/// The best methods on the same pictures, spoilt.
Status addSpoilt(const FilmedScene& scene, const std::string& how, const Yardstick& plain,
                 const Yardstick& best, Progress& progress, BenchRows& rows) {
  for (const Method& method : methods()) {
    if (isBest(method))
      VOLUTE_TRY(addQuality(scene, fmt::format("{}, {}", scene.name, how), method,
                            isAutomatic(method) ? best : plain, progress, rows));
  }
  return {};
}

Status addNoiseAnd8Bit(const FilmedScene& scene, double sigma, Progress& progress,
                       BenchRows& rows) {
  constexpr double kSaturated = 0.034;
  FilmedScene noisy = scene;
  noisy.addNoise(sigma);
  VOLUTE_TRY(addSpoilt(noisy, fmt::format("noise of {:.3g}", sigma), {51.2, NAN, .435},
                       {52.9, NAN, .316}, progress, rows));
  FilmedScene stored = scene;
  stored.storeAs8Bit(kSaturated);
  return addSpoilt(stored, "8-bit sRGB, 3.4 % saturated", {}, {58.3}, progress, rows);
}

Status benchMadeUp(bool quick, BenchRows& rows, Progress& progress) {
  VOLUTE_ASSIGN(const FilmedScene fire, filmMadeUp(SynthKind::kFire, progress));
  VOLUTE_TRY(addMethods(fire, false, quick, progress, rows));
  VOLUTE_TRY(addNoiseAnd8Bit(fire, 0.02 * fire.brightest(), progress, rows));
  VOLUTE_ASSIGN(const FilmedScene smoke, filmMadeUp(SynthKind::kSmoke, progress));
  VOLUTE_TRY(addMethods(smoke, true, quick, progress, rows));
  return {};
}

/// Means of `side` x `side` pixels; what is left over at the borders is left out.
Image blocksOf(const Image& image, int side) {
  Image blocks(image.width / side, image.height / side);
  const float share = 1 / static_cast<float>(side * side);
  for (int y = 0; y < blocks.height * side; ++y)
    for (int x = 0; x < blocks.width * side; ++x)
      for (int c = 0; c < 3; ++c) blocks.at(x / side, y / side, c) += share * image.at(x, y, c);
  return blocks;
}

/// How far the given pictures are from the truth's line integrals. Noise falls with the side of the
/// blocks; a wrong model of the camera or of the volume does not.
void addPictures(const FilmedScene& scene, BenchRows& rows) {
  std::vector<Image> projected;
  for (const TomographyView& view : scene.views)
    projected.push_back(
        projectVolume(scene.truth, scene.geometry, Basis::kTrilinear, view.camera, 4));
  for (const int side : {1, 2, 4}) {
    double error = 0, light = 0;
    for (std::size_t v = 0; v < projected.size(); ++v) {
      const Image given = blocksOf(scene.views[v].radiance, side);
      const Image ours = blocksOf(projected[v], side);
      for (std::size_t i = 0; i < given.pixels.size(); ++i) {
        const double difference = static_cast<double>(ours.pixels[i]) - given.pixels[i];
        error += difference * difference;
        light += static_cast<double>(given.pixels[i]) * given.pixels[i];
      }
    }
    rows.add({fmt::format("{}: truth projected, to the pictures in blocks of {} x {}", scene.name,
                          side, side),
              std::sqrt(error / light), "relative L2"});
  }
}

/// A given picture that no method saw: of the camera in the middle of the list, or of the next one
/// all of whose pixels count.
Status addHeldOut(const FilmedScene& scene, Progress& progress, BenchRows& rows) {
  std::size_t left = scene.views.size() / 2;
  while (left < scene.views.size() && !scene.views[left].weight.empty()) ++left;
  if (scene.views.size() < 4 || left == scene.views.size())
    return {};
  FilmedScene rest = scene;
  rest.views.erase(rest.views.begin() + static_cast<std::ptrdiff_t>(left));
  rest.others = {scene.views[left].camera};
  rest.otherImages = {scene.views[left].radiance};
  for (const Method& method : methods()) {
    if (!isBest(method))
      continue;
    progress.report(fmt::format("{}: {} without a camera", scene.name, method.name), 0, 0);
    VOLUTE_ASSIGN(const Reconstruction done,
                  reconstruct(rest.views, rest.geometry, method.options, {}, progress));
    const SceneQuality quality = qualityOf(rest, done.volume, method.options.basis);
    const std::string name = fmt::format("{}: {}, given picture of {}, held out", scene.name,
                                         method.name, scene.views[left].name);
    rows.add({name, quality.psnr, "dB"});
    rows.add({name, quality.relative, "relative L2"});
  }
  return {};
}

/// All methods on the first frame, `auto` on the others.
Status benchCapture(const BenchInput& input, BenchRows& rows, Progress& progress) {
  constexpr double kNoise = 0.02;
  VOLUTE_ASSIGN(const Capture capture, openCapture(input.volume, {}));
  for (const int frame : capture.frames) {
    VOLUTE_ASSIGN(const FilmedScene scene,
                  filmCapture(capture, frame, input.truth, input.grid, input.maxMemory, progress));
    addPictures(scene, rows);
    if (frame == capture.frames.front()) {
      VOLUTE_TRY(addMethods(scene, false, input.quick, progress, rows));
      VOLUTE_TRY(addHeldOut(scene, progress, rows));
      VOLUTE_TRY(addNoiseAnd8Bit(scene, kNoise, progress, rows));
    } else {
      const Method method = methods().back();
      VOLUTE_TRY(addQuality(scene, scene.name, method, method.fire, progress, rows));
    }
  }
  return {};
}

}  // namespace

Status benchTomography(const BenchInput& input, BenchRows& rows, Progress& progress) {
  if (input.volume.empty())
    return benchMadeUp(input.quick, rows, progress);
  if (input.truth.empty())
    return fail(ErrorCode::kInvalidArgument,
                "{}: reconstructions of a capture are compared with its true volume; name it with "
                "--truth VOLUME",
                input.volume);
  return benchCapture(input, rows, progress);
}

}  // namespace volute::bench
