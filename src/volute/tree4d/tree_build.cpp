// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Tree4d::build: blocks from a source of frames, and the step that meets a target.
#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "volute/base/parallel.hpp"
#include "volute/base/view.hpp"
#include "volute/tree4d/quantised_subtree.hpp"
#include "volute/tree4d/tree4d.hpp"
#include "volute/tree4d/tree_builder.hpp"
#include "volute/wavelet/quantiser.hpp"

namespace volute {
namespace {

/// Reads the source a row of blocks at a time and calls body(block, its values) for each block, from many threads.
template <class Body>
Status forEachBlock(FrameSource& source, std::string_view stage, Progress& progress, Body&& body) {
  const VolumeInfo& info = source.info();
  const BlockGrid grid(info);
  std::vector<float> row;
  for (int first = 0; first < info.frames; first += BlockGrid::kSide) {
    const int frames = std::min(BlockGrid::kSide, info.frames - first);
    row.resize(frames * info.frameValues());
    for (int f = 0; f < frames; ++f) {
      if (progress.cancelled()) return fail(ErrorCode::kCancelled, "stopped: {} of {} frames were read", first + f, info.frames);
      VOLUTE_TRY(source.readFrame(first + f, std::span(row).subspan(f * info.frameValues(), info.frameValues())));
      progress.report(stage, first + f + 1, info.frames);
    }
    const View<const float, 5> view(std::span<const float>(row), {frames, info.z, info.y, info.x, info.channels});
    const std::size_t firstBlock = static_cast<std::size_t>(first / BlockGrid::kSide) * grid.rowCount();
    parallelFor(grid.rowCount(), [&](std::size_t i) {
      const auto origin = grid.origin(firstBlock + i);
      const auto e = grid.extents(firstBlock + i);
      std::vector<float> values;
      values.reserve(grid.values(firstBlock + i));
      for (int t = 0; t < e[0]; ++t)
        for (int z = 0; z < e[1]; ++z)
          for (int y = 0; y < e[2]; ++y) {
            const float* from = &view(t, origin[1] + z, origin[2] + y, origin[3], 0);
            values.insert(values.end(), from, from + static_cast<std::size_t>(e[3]) * info.channels);
          }
      body(firstBlock + i, std::span<const float>(values));
    });
  }
  return {};
}

int blockLevels(const VolumeInfo& info) {
  const int longest = std::max({info.frames, info.z, info.y, info.x});
  int levels = 1;
  while (levels < 4 && (1 << levels) < longest) ++levels;
  return levels;
}

struct Statistics {
  QuantisationModel model;
  float minimum = std::numeric_limits<float>::infinity();
  float maximum = -std::numeric_limits<float>::infinity();
};

Result<Statistics> gather(FrameSource& source, Progress& progress) {
  const VolumeInfo& info = source.info();
  const BlockGrid grid(info);
  Statistics all;
  bool finite = true;
  std::mutex mutex;
  VOLUTE_TRY(forEachBlock(source, "reading", progress, [&](std::size_t block, std::span<const float> values) {
    QuantisationModel model;
    const SubtreeShape shape{grid.extents(block), info.channels, 0, blockLevels(info)};
    visitCoefficients(shape, values, [&](float coefficient) { model.add(coefficient); });
    const auto [low, high] = std::ranges::minmax(values);
    const bool blockFinite = std::ranges::all_of(values, [](float v) { return std::isfinite(v); });
    const std::lock_guard lock(mutex);
    all.model.merge(model);
    all.minimum = std::min(all.minimum, low);
    all.maximum = std::max(all.maximum, high);
    finite = finite && blockFinite;
  }));
  if (!finite) return fail(ErrorCode::kInvalidData, "the volume holds NaN or infinite values; a tree needs finite ones");
  return all;
}

Result<Tree4d> buildWithStep(FrameSource& source, double step, float minimum, float maximum, Progress& progress) {
  TreeBuilder builder(source.info(), step, minimum, maximum);
  VOLUTE_TRY(forEachBlock(source, "building the tree", progress, [&](std::size_t block, std::span<const float> values) {
    builder.addBlock(block, values);
  }));
  return builder.finish();
}

Result<double> squaredError(const Tree4d& tree, FrameSource& source, Progress& progress) {
  const VolumeInfo& info = source.info();
  std::vector<float> original(info.frameValues()), decoded(info.frameValues());
  double sum = 0;
  for (int t = 0; t < info.frames; ++t) {
    if (progress.cancelled()) return fail(ErrorCode::kCancelled, "stopped: {} of {} frames were checked", t, info.frames);
    VOLUTE_TRY(source.readFrame(t, original));
    tree.extractFrame(t, decoded);
    for (std::size_t i = 0; i < original.size(); ++i) {
      const double e = static_cast<double>(decoded[i]) - original[i];
      sum += e * e;
    }
    progress.report("checking", t + 1, info.frames);
  }
  return sum;
}

}  // namespace

Result<Tree4d> Tree4d::build(FrameSource& source, const BuildOptions& options, Progress& progress) {
  VOLUTE_ASSIGN(const Statistics statistics, gather(source, progress));
  const double range = static_cast<double>(statistics.maximum) - statistics.minimum;
  if (options.step > 0 || range == 0) {
    const double step = options.step > 0 ? options.step : 1;
    return buildWithStep(source, step, statistics.minimum, statistics.maximum, progress);
  }
  const double allowed = std::pow(options.relativeRms * range, 2) * static_cast<double>(source.info().values());
  double step = std::max(statistics.model.stepFor(allowed), 1e-30);

  // The prediction is a little pessimistic where decoded values are clamped or known to be zero. Two corrections bring
  // the step to what the target allows.
  constexpr double kGoodEnough = 0.97;
  constexpr int kPasses = 4;
  double safeStep = 0;
  for (int pass = 0;; ++pass) {
    VOLUTE_ASSIGN(Tree4d tree, buildWithStep(source, step, statistics.minimum, statistics.maximum, progress));
    VOLUTE_ASSIGN(const double error, squaredError(tree, source, progress));
    const double reached = std::sqrt(error / allowed);
    if ((reached <= 1 && reached >= kGoodEnough) || (reached <= 1 && pass >= kPasses)) return tree;
    if (error == 0 && statistics.model.squaredError(step) == 0) return tree;
    if (reached <= 1) safeStep = std::max(safeStep, step);
    step = pass + 1 >= kPasses && safeStep > 0 ? safeStep : step * std::min(0.99 / reached, 4.0);
  }
}

}  // namespace volute
