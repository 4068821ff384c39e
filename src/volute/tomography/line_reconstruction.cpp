// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/line_reconstruction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>

#include "volute/report/report.hpp"
#include "volute/tomography/fit.hpp"
#include "volute/tomography/vector_ops.hpp"

namespace volute {
namespace {

constexpr std::size_t kFolds = 5;

/// strength / 2 * the squared differences of neighbours within a whole volume, weighted by how near
/// they are; a >= 0.
class WholeSmoothness final : public Prior {
 public:
  WholeSmoothness(const VolumeGeometry& geometry, double strength)
      : size_(geometry.resolution), strength_(strength) {
    const Vec3 voxel = geometry.voxelSize();
    for (int a = 0; a < 3; ++a)
      share_[a] = static_cast<float>(std::pow(voxel.minCoeff() / voxel[a], 2));
  }

  void proximal(std::span<float> a, std::span<const float>) override {
    forElements(a.size(), [&](std::size_t i) { a[i] = std::max(a[i], 0.0F); });
  }

  void addGradient(std::span<const float> a, std::span<float> gradient) const override {
    const auto strength = static_cast<float>(strength_);
    const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(size_[0]),
                                            static_cast<std::size_t>(size_[0]) * size_[1]};
    forElements(a.size() / 4, [&](std::size_t i) {
      float sum = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const std::size_t by = stride[axis];
        const auto at = static_cast<int>(i / by % static_cast<std::size_t>(size_[axis]));
        if (at > 0)
          sum += share_[axis] * (a[4 * i] - a[4 * (i - by)]);
        if (at + 1 < size_[axis])
          sum += share_[axis] * (a[4 * i] - a[4 * (i + by)]);
      }
      gradient[4 * i] += strength * sum;
    });
  }

  double curvature() const override { return 12 * strength_; }

 private:
  std::array<int, 3> size_;
  std::array<float, 3> share_{};
  double strength_;
};

/// The lines of one time as linear algebra.
class LineProblem {
 public:
  LineProblem(std::span<const LineMeasurement> lines, const VolumeGeometry& geometry,
              const LineOptions& options, std::uint64_t tableBytes, Progress& progress)
      : geometry_(geometry),
        options_(options),
        progress_(progress),
        support_(std::make_shared<const Support>(geometry, options.basis,
                                                 std::span<const std::uint8_t>{})) {
    std::vector<Segment> segments;
    for (const LineMeasurement& one : lines) segments.push_back(one.line);
    projector_ = std::make_unique<const Projector>(segments, support_, tableBytes);
    data_.projector = projector_.get();
    data_.measured.assign(4 * projector_->rows(), 0);
    data_.atLeast.assign(projector_->rows(), 0);
    double sum = 0;
    for (std::size_t row = 0; row < projector_->rows(); ++row) {
      const auto& one = lines[static_cast<std::size_t>(projector_->pixels()[row].pixel)];
      data_.measured[4 * row] = static_cast<float>(one.value);
      data_.atLeast[row] = one.atLeast ? 1 : 0;
      weights_.push_back(1 / (one.sigma * one.sigma));
      sum += weights_.back();
    }
    // Weights with a mean of 1, so that strengths do not depend on the unit.
    for (const double weight : weights_)
      data_.squaredWeight.push_back(
          static_cast<float>(weight * static_cast<double>(weights_.size()) / sum));
    largest_ = data_.largestEigenvalue();
  }

  double largest() const { return largest_; }

  std::size_t rows() const { return data_.rows(); }

  /// Fits all lines but those of `fold`, from where `unknowns` are; how many iterations it took.
  Result<int> fit(double lambda, const std::vector<std::uint8_t>& fold,
                  std::vector<float>& unknowns) {
    constexpr int kMax = 1000, kEvery = 10;
    LeastSquares data = fold.empty() ? data_ : withoutRows(data_, fold);
    WholeSmoothness prior(geometry_, lambda * largest_);
    const int most = options_.iterations.value_or(kMax);
    std::vector<float> before;
    const auto watch = [&](int iteration, std::span<const float> now, std::span<const float>) {
      progress_.report("solving", iteration, most);
      if (progress_.cancelled())
        return false;
      if (options_.iterations || iteration % kEvery != 0)
        return true;
      bool settled = false;
      if (!before.empty()) {
        const double change = sumElements(now.size(), [&](std::size_t i) {
          return std::pow(static_cast<double>(now[i]) - before[i], 2);
        });
        settled = change <= kSettled * kSettled * dot(now, now);
      }
      before.assign(now.begin(), now.end());
      return !settled;
    };
    const int made = solveApg(data, largest_, prior, most, unknowns, watch);
    if (progress_.cancelled())
      return fail(ErrorCode::kCancelled, "Stopped");
    projected_.assign(4 * rows(), 0);
    projector_->forward(unknowns, projected_);
    return made;
  }

  /// Weighted squares of what the last fit leaves, over the lines of `fold` or all, and of the
  /// values there.
  std::pair<double, double> squares(const std::vector<std::uint8_t>& fold) const {
    double off = 0, all = 0;
    for (std::size_t row = 0; row < rows(); ++row) {
      if (!fold.empty() && fold[row] == 0)
        continue;
      const double measured = data_.measured[4 * row];
      off += weights_[row] * std::pow<double>(data_.misfit(4 * row, &projected_[4 * row]), 2);
      all += weights_[row] * measured * measured;
    }
    return {off, all};
  }

  /// Voxels that a line reaches.
  double crossed() const {
    std::vector<float> ones(4 * rows(), 1), sums(4 * support_->size());
    projector_->adjoint(ones, sums);
    std::size_t count = 0;
    for (std::size_t i = 0; i < support_->size(); ++i) count += sums[4 * i] > 0 ? 1 : 0;
    return static_cast<double>(count) / static_cast<double>(support_->size());
  }

  std::size_t unknowns() const { return 4 * support_->size(); }

  std::vector<float> volume(std::span<const float> unknowns) const {
    std::vector<float> values(geometry_.voxels());
    for (std::size_t i = 0; i < support_->size(); ++i)
      values[static_cast<std::size_t>(support_->voxels()[i])] = unknowns[4 * i];
    return values;
  }

 private:
  const VolumeGeometry& geometry_;
  const LineOptions& options_;
  Progress& progress_;
  std::shared_ptr<const Support> support_;
  std::unique_ptr<const Projector> projector_;
  LeastSquares data_;
  std::vector<double> weights_;  // 1 / sigma^2
  std::vector<float> projected_;
  double largest_ = 0;
};

/// Each line is left out in one of these.
std::vector<std::vector<std::uint8_t>> foldsOf(std::size_t rows) {
  const std::size_t count = std::min(kFolds, rows);
  std::vector<std::size_t> order(rows);
  for (std::size_t i = 0; i < rows; ++i) order[i] = i;
  std::mt19937 random(1);
  for (std::size_t i = rows; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  std::vector<std::vector<std::uint8_t>> folds(count, std::vector<std::uint8_t>(rows));
  for (std::size_t i = 0; i < rows; ++i) folds[i % count][order[i]] = 1;
  return folds;
}

/// From strong to weak, each fit going on from the one before.
Result<std::pair<double, double>> chooseStrength(LineProblem& problem) {
  constexpr double kStrongest = 1, kWeakest = 1e-6, kFactor = 0.31622776601683794;
  const auto folds = foldsOf(problem.rows());
  std::vector<std::vector<float>> volumes(folds.size(), std::vector<float>(problem.unknowns()));
  double best = kStrongest, least = -1;
  for (double lambda = kStrongest; lambda > 0.9 * kWeakest; lambda *= kFactor) {
    double off = 0, all = 0;
    for (std::size_t f = 0; f < folds.size(); ++f) {
      VOLUTE_TRY(problem.fit(lambda, folds[f], volumes[f]));
      const auto [one, of] = problem.squares(folds[f]);
      off += one, all += of;
    }
    const double error = all > 0 ? std::sqrt(off / all) : 0;
    if (least >= 0 && error > 1.5 * least)
      break;  // it is all fit to noise from here on
    if (least < 0 || error < least)
      least = error, best = lambda;
  }
  return std::pair(best, least);
}

Status checkLines(std::span<const LineMeasurement> lines, const VolumeGeometry& geometry,
                  std::uint64_t maxMemory) {
  if (lines.size() < 2)
    return fail(ErrorCode::kInvalidArgument, "{} line; a volume needs two at least", lines.size());
  VOLUTE_TRY(checkVolumeSize(geometry, maxMemory));
  constexpr std::uint64_t kUnknownBytes = 16 * (kFolds + 10), kLineBytes = 400;
  const std::uint64_t needed = geometry.voxels() * kUnknownBytes + lines.size() * kLineBytes;
  if (needed > maxMemory) {
    return fail(
        ErrorCode::kTooLarge, Hint::raise("max_memory"),
        "{} lines through {} voxels need {} MiB, more than the {} MiB that are allowed; take "
        "a lower resolution",
        lines.size(), geometry.voxels(), (needed >> 20) + 1, maxMemory >> 20);
  }
  const auto beside = linesBeside(lines, geometry);
  if (beside.empty())
    return {};
  const Vec3 &low = geometry.bounds.min, &high = geometry.bounds.max;
  return fail(ErrorCode::kInvalidArgument,
              "row {}: the line misses the volume from ({}) to ({}), as "
              "do {} of {} lines; check the bounds and the unit [m]",
              lines[beside.front()].row, vectorText(low), vectorText(high), beside.size(),
              lines.size());
}

}  // namespace

std::vector<std::size_t> linesBeside(std::span<const LineMeasurement> lines,
                                     const VolumeGeometry& geometry) {
  std::vector<std::size_t> beside;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Segment& line = lines[i].line;
    const auto inside = geometry.bounds.intersect(line.origin, line.direction);
    if (inside.intersect({line.begin, line.end}).empty())
      beside.push_back(i);
  }
  return beside;
}

Result<LineReconstruction> reconstructLines(std::span<const LineMeasurement> lines,
                                            const VolumeGeometry& geometry,
                                            const LineOptions& options, Progress& progress) {
  VOLUTE_TRY(checkLines(lines, geometry, options.maxMemory));
  LineProblem problem(lines, geometry, options, options.maxMemory / 4, progress);
  LineReconstruction result;
  std::vector<float> unknowns(problem.unknowns());
  if (!(problem.largest() > 0))
    return fail(ErrorCode::kInvalidArgument, "No line meets the volume");
  result.lambda = options.lambda.value_or(0);
  if (!options.lambda) {
    VOLUTE_ASSIGN(const auto choice, chooseStrength(problem));
    result.lambda = choice.first;
    result.leftOut = choice.second;
  }
  VOLUTE_ASSIGN(result.iterations, problem.fit(result.lambda, {}, unknowns));
  const auto [off, all] = problem.squares({});
  result.residual = all > 0 ? std::sqrt(off / all) : 0;
  result.spread = std::sqrt(off / static_cast<double>(problem.rows()));
  result.crossed = problem.crossed();
  result.volume = problem.volume(unknowns);
  return result;
}

}  // namespace volute
