// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/smoke_whole.hpp"

#include <algorithm>
#include <cmath>

#include "bench/smoke_accuracy.hpp"
#include "volute/tetmesh/tet_splat.hpp"

namespace volute::bench {
namespace {

/// A source that differs from vertex to vertex: nothing that is drawn in the wrong place or order
/// goes unseen.
std::vector<float> motley(std::size_t vertices) {
  std::vector<float> source(3 * vertices);
  for (std::size_t i = 0; i < source.size(); ++i)
    source[i] = static_cast<float>(0.1 + static_cast<double>(i * 7 % 11) / 11);
  return source;
}

/// The largest difference of two pictures of `channels` floats a pixel, and where.
struct Worst {
  double error = 0;
  std::size_t pixel = 0;

  Worst(std::span<const float> found, std::span<const double> exact, std::size_t channels) {
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double off = std::abs(found[i] - exact[i]);
      if (!(off <= error))
        error = off, pixel = i / channels;
    }
  }
};

class Judge {
 public:
  Judge(const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator)
      : smoke_(smoke),
        source_(motley(smoke.mesh->vertices().size())),
        medium_(locator, smoke.extinction[0], source_),
        splat_(locator) {
    splat_.setExtinction(smoke.extinction[0]);
    splat_.setSource(source_);
  }

  void judge(const SmokeSetting& setting, BenchRows& rows, SmokeTargets& targets) {
    const SmokeView view = setting.view(0, 0, 0);
    const Camera camera = view.camera();
    const std::vector<float> opaque = opaqueDepth(view);
    std::vector<double> depth(setting.pixels()), color(4 * setting.pixels());
    const double begin = cpuSeconds();
    referenceDepth(medium_, camera, opaque, depth);
    referenceColor(medium_, camera, opaque, color);
    rows.add({fmt::format("{}: reference, double", setting.name()),
              cpuSeconds() - begin,
              "s",
              std::nullopt,
              {},
              "of CPU time: the whole picture's optical depth and lit colour"});
    for (double& d : depth) d = -std::expm1(-d);
    std::vector<float> drawn(setting.pixels()), lit(4 * setting.pixels());
    const auto add = [&](const char* what, SmokeRole role, const Worst& worst, std::string note) {
      BenchRow row;
      row.name = fmt::format("{}: {}", setting.name(), what);
      row.value = worst.error;
      row.labels = {{"case", smoke_.name}, {"eye", setting.eye.name}, {"what", what}};
      row.note = fmt::format("largest error of {} pixels, at ({}, {}){}", setting.pixels(),
                             worst.pixel % setting.width, worst.pixel / setting.width, note);
      rows.add(std::move(row));
      targets.addError(role, setting, worst.error);
    };
    const auto opacity = [&] {
      for (float& d : drawn) d = static_cast<float>(-std::expm1(-double{d}));
      return Worst(drawn, depth, 1);
    };
    splat_.opticalDepth(camera, opaque, drawn);
    add("opacity by splat", SmokeRole::kDepth, opacity(), "");
    splat_.litColor(camera, opaque, lit);
    add("lit colour by splat", SmokeRole::kLit, {lit, color, 4},
        fmt::format("; {} pixels were left to the reference", splat_.leftOut()));
  }

 private:
  const SmokeCase& smoke_;
  std::vector<float> source_;
  TetMedium medium_;
  TetSplat splat_;
};

}  // namespace

Status judgeWholePictures(const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator,
                          bool quick, BenchRows& rows, SmokeTargets& targets, Progress& progress) {
  Judge judge(smoke, locator);
  const auto eyes = smokeEyes(*locator);
  std::vector<SmokeSetting> settings;
  for (const SmokeEye& eye : eyes) {
    settings.push_back({smoke, eye, quick ? 320 : 800, quick ? 240 : 600, false});
    settings.push_back({smoke, eye, 200, 150, true});
  }
  const auto onMesh = eyesOnMesh(*smoke.mesh, eyes.back());
  for (const SmokeEye& eye : onMesh) settings.push_back({smoke, eye, 200, 150, false});
  for (const SmokeSetting& setting : settings) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped in {}", setting.name());
    judge.judge(setting, rows, targets);
  }
  judgeLight(smoke, locator, eyes.back().eye, smoke.mesh->vertices().size(), rows, targets);
  return {};
}

}  // namespace volute::bench
