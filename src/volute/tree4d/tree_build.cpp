// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Tree4d::build: blocks from a source of frames, and the step that meets a target.
#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>

#include "volute/base/parallel.hpp"
#include "volute/codec/block_row.hpp"
#include "volute/codec/step_search.hpp"
#include "volute/tree4d/quantised_subtree.hpp"
#include "volute/tree4d/tree4d.hpp"
#include "volute/tree4d/tree_builder.hpp"
#include "volute/wavelet/quantiser.hpp"

namespace volute {
namespace {

/// Reads the source a row of blocks at a time and calls body(block, its values) for each block,
/// from many threads.
template <class Body>
Status forEachBlock(BlockRow& rows, std::string_view stage, Progress& progress, Body&& body) {
  const BlockGrid& grid = rows.grid();
  for (int row = 0; row < rows.rows(); ++row) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: {} of {} rows of blocks were read", row,
                  rows.rows());
    VOLUTE_TRY(rows.load(row));
    const std::size_t first = row * grid.rowCount();
    parallelFor(grid.rowCount(), [&](std::size_t i) {
      std::vector<float> values(grid.values(first + i));
      BlockStates states;
      rows.cut(first + i, values, states);
      body(first + i, std::span<const float>(values));
    });
    progress.report(stage, row + 1, rows.rows());
  }
  return {};
}

/// What the values of all blocks are like.
struct Gathered {
  QuantisationModel model;  ///< of the orthonormal coefficients: predicts the error of any step
  float minimum = std::numeric_limits<float>::infinity();
  float maximum = -std::numeric_limits<float>::infinity();
};

Result<Gathered> gather(BlockRow& rows, const VolumeInfo& info, Progress& progress) {
  Gathered all;
  std::mutex mutex;
  VOLUTE_TRY(forEachBlock(rows, "reading", progress,
                          [&](std::size_t block, std::span<const float> values) {
                            QuantisationModel model;
                            const SubtreeShape shape{rows.grid().extents(block), info.channels, 0,
                                                     treeLevels(info).block};
                            visitCoefficients(shape, values, [&](float c) { model.add(c); });
                            const auto [least, most] = std::ranges::minmax_element(values);
                            const std::lock_guard lock(mutex);
                            all.model.merge(model);
                            all.minimum = std::min(all.minimum, *least);
                            all.maximum = std::max(all.maximum, *most);
                          }));
  return all;
}

Result<Tree4d> buildWithStep(BlockRow& rows, const VolumeInfo& info, const Gathered& gathered,
                             double step, Progress& progress) {
  std::vector<std::uint64_t> all(rows.grid().count());
  std::iota(all.begin(), all.end(), std::uint64_t{0});
  TreeBuilder builder(info, std::move(all), step, gathered.minimum, gathered.maximum);
  VOLUTE_TRY(forEachBlock(
      rows, "building the tree", progress,
      [&](std::size_t block, std::span<const float> values) { builder.addBlock(block, values); }));
  return builder.finish();
}

Result<double> squaredError(const Tree4d& tree, FrameSource& source, Progress& progress) {
  const VolumeInfo& info = source.info();
  std::vector<float> original(info.frameValues()), decoded(info.frameValues());
  double sum = 0;
  for (int t = 0; t < info.frames; ++t) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: {} of {} frames were checked", t, info.frames);
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
  const VolumeInfo& info = source.info();
  BlockRow rows(source);
  VOLUTE_ASSIGN(const Gathered gathered, gather(rows, info, progress));
  const double range = static_cast<double>(gathered.maximum) - gathered.minimum;
  if (options.step > 0 || range == 0) {
    const double step = options.step > 0 ? options.step : 1;
    return buildWithStep(rows, info, gathered, step, progress);
  }
  const auto count = static_cast<double>(info.values());
  const double predicted = gathered.model.stepFor(std::pow(options.relativeRms * range, 2) * count);
  if (predicted == 0)  // every coefficient is zero, at any step
    return buildWithStep(rows, info, gathered, range, progress);

  // The prediction is a little pessimistic where decoded values are clamped or known to be zero.
  constexpr double kGoodEnough = 0.97;
  StepSearch search({.target = options.relativeRms,
                     .closeEnough = kGoodEnough * options.relativeRms,
                     .finest = 1e-6 * predicted,
                     .coarsest = 1e6 * predicted,
                     .maxTries = 12},
                    predicted);
  for (;;) {
    VOLUTE_ASSIGN(Tree4d tree, buildWithStep(rows, info, gathered, search.step(), progress));
    VOLUTE_ASSIGN(const double error, squaredError(tree, source, progress));
    const double reached = std::sqrt(error / count) / range;
    search.tell(reached);
    if (search.found())
      return tree;
    if (search.failed())
      return fail(
          ErrorCode::kInvalidArgument,
          "a relative RMS error of {:.3g} is below what float32 values can keep; {:.3g} was "
          "reached",
          options.relativeRms, reached);
  }
}

}  // namespace volute
