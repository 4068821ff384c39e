// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench gl`: the papers' tables of frame rates by OpenGL on the device there is, against
// the processor's.
#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/cli/bench_timing.hpp"
#include "volute/cli/benchmarks/benchmarks.hpp"
#include "volute/cli/benchmarks/gl_cases.hpp"
#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_renderer.hpp"

namespace volute::cli {
namespace {

double largestDifference(const Image& a, const Image& b) {
  double largest = 0, brightest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    largest = std::max<double>(largest, std::fabs(a.pixels[i] - b.pixels[i]));
    brightest = std::max<double>(brightest, b.pixels[i]);
  }
  return brightest > 0 ? largest / brightest : 0;
}

bool isBlack(const GlScene& scene) {
  return scene.smokes.size() == 1 && scene.smokes[0].source.empty();
}

Status measure(const GlCase& one, GlRenderer& renderer, const std::string& device,
               BenchRows& rows) {
  Progress quiet;
  RenderOptions options;
  if (isBlack(one.scene(0)))
    options.background = Rgb::Ones();
  const auto image = renderer.render(one.camera(0), one.scene(0), options, quiet);
  if (!image) {
    rows.add({one.name + ": gl",
              std::numeric_limits<double>::quiet_NaN(),
              "frames/s",
              std::nullopt,
              {{"device", device}},
              image.error().message});
    return {};
  }
  const double difference = largestDifference(*image, one.byProcessor(0));
  int frame = 0;
  const double cpu = medianSeconds([&] { (void)one.byProcessor(frame++); });
  frame = 0;
  Status drawn;
  const double gl = medianSeconds([&] {
    const GlScene& scene = one.scene(frame);
    auto status = renderer.draw(one.camera(frame++), scene, GlQuantity::kLight, quiet);
    if (!status)
      drawn = std::move(status);
    (void)renderer.takePasses();  // waits for the device
  });
  VOLUTE_TRY(std::move(drawn));
  rows.add({one.name + ": cpu", 1 / cpu, "frames/s", 1.0});
  rows.add({one.name + ": gl", 1 / gl, "frames/s", cpu / gl, {{"device", device}}, device});
  rows.add({one.name + ": |gl - cpu| / maximum", difference, ""});
  return {};
}

}  // namespace

Status benchGl(const BenchInput& input, BenchRows& rows, Progress& progress) {
  VOLUTE_ASSIGN(const auto gl, HeadlessGl::create());
  VOLUTE_ASSIGN(auto renderer, GlRenderer::create());
  std::vector<GlCase> cases;
  addHall(input.quick, cases);
  VOLUTE_TRY(addFogTables(input.quick, cases));
  VOLUTE_TRY(addTrees(input, progress, cases));
  std::size_t done = 0;
  for (const GlCase& one : cases) {
    progress.report("measuring", static_cast<double>(done++), static_cast<double>(cases.size()));
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before {}", one.name);
    VOLUTE_TRY(measure(one, renderer, gl.device().renderer, rows));
  }
  return {};
}

}  // namespace volute::cli
