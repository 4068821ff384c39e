// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/smoke_accuracy.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/parallel.hpp"
#include "volute/lighting/vertex_light.hpp"
#include "volute/tetmesh/tet_splat.hpp"

namespace volute::bench {
namespace {

/// The i-th of samples of `count` things, spread over all of them.
std::size_t sampleOf(std::size_t i, std::size_t count) {
  return i * 2654435761u % count;
}

double errorOf(TetSplat& path, const SampledOpacity& expected, const SmokeView& view) {
  std::vector<float> drawn(static_cast<std::size_t>(view.width) * view.height);
  path.opticalDepth(view.camera(), opaqueDepth(view), drawn);
  for (float& d : drawn) d = static_cast<float>(-std::expm1(-double{d}));
  return expected.errors(drawn).first;
}

}  // namespace

SampledOpacity::SampledOpacity(const TetMedium& medium, const SmokeView& view, std::size_t pixels) {
  const Camera camera = view.camera();
  const std::vector<float> opaque = opaqueDepth(view);
  const auto all = static_cast<std::size_t>(view.width) * view.height;
  std::vector<Segment> rays;
  for (std::size_t i = 0; i < pixels; ++i) {
    pixels_.push_back(sampleOf(i, all));
    rays.push_back(pixelRay(camera, static_cast<int>(pixels_[i] % view.width),
                            static_cast<int>(pixels_[i] / view.width), opaque));
  }
  std::vector<double> depths(pixels);
  const double begin = cpuSeconds();
  parallelRanges(pixels, 8, [&](std::size_t first, std::size_t last) {
    medium.opticalDepth(std::span(rays).subspan(first, last - first),
                        std::span(depths).subspan(first, last - first));
  });
  secondsPerPixel_ = (cpuSeconds() - begin) / static_cast<double>(pixels);
  for (const double depth : depths) alpha_.push_back(1 - std::exp(-depth));
}

std::pair<double, double> SampledOpacity::errors(std::span<const float> opacity) const {
  double worst = 0, off = 0;
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const double error = std::abs(opacity[pixels_[i]] - alpha_[i]);
    worst = std::max(worst, error);
    off += error > 1.0 / 255;
  }
  return {worst, off / static_cast<double>(pixels_.size())};
}

void judgeLight(const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator,
                const Vec3& position, std::size_t samples, BenchRows& rows, SmokeTargets& targets) {
  Lamp lamp;
  lamp.position = position;
  lamp.direction = -Vec3::UnitZ();
  const auto shares = LampPaths(locator).shares(smoke.extinction[0], lamp);
  const bool all = samples >= shares.size();
  samples = std::min(samples, shares.size());
  std::vector<double> errors(samples);
  std::vector<char> dark(samples);
  parallelRanges(samples, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t vertex = all ? i : sampleOf(i, shares.size());
      const Segment way = lamp.towards(smoke.mesh->vertices()[vertex]);
      errors[i] = std::abs(shares[vertex] - lampShareReference(*locator, smoke.extinction[0], way));
      dark[i] = shares[vertex] == 0;
    }
  });
  const double worst = *std::ranges::max_element(errors);
  BenchRow row;
  row.name = fmt::format("{}: light at vertices", smoke.name);
  row.value = worst;
  row.labels = {{"case", smoke.name}, {"what", "light at vertices"}};
  row.note = fmt::format(
      "largest error of {} of {} vertices, {} of them in the dark, of a lamp at ({:.3g}, {:.3g}, "
      "{:.3g})",
      samples, shares.size(), std::ranges::count(dark, 1), position.x(), position.y(),
      position.z());
  targets.addLight(worst, row.name);
  rows.add(std::move(row));
}

Status judgeSamples(const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator,
                    BenchRows& rows, SmokeTargets& targets, Progress& progress) {
  constexpr std::size_t kVertices = 2000, kPixels = 1000;
  const TetMedium medium(locator, smoke.extinction[0]);
  TetSplat splat(locator);
  splat.setExtinction(smoke.extinction[0]);
  const auto eyes = smokeEyes(*locator);
  for (const SmokeEye& eye : eyesOnMesh(*smoke.mesh, eyes.back())) {
    const SmokeSetting setting{smoke, eye, 400, 300, false};
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped in {}", setting.name());
    const SmokeView view = setting.view(0, 0, 0);
    const SampledOpacity expected(medium, view, kPixels);
    const double error = errorOf(splat, expected, view);
    BenchRow row;
    row.name = fmt::format("{}: opacity by splat", setting.name());
    row.value = error;
    row.labels = {{"case", smoke.name}, {"eye", eye.name}, {"what", "opacity by splat"}};
    row.note = fmt::format("largest error of {} pixels", kPixels);
    rows.add(std::move(row));
    targets.addError(SmokeRole::kDepth, setting, error);
  }
  judgeLight(smoke, locator, eyes.back().eye, kVertices, rows, targets);
  return {};
}

}  // namespace volute::bench
