// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/compress.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include "volute/base/checksum.hpp"
#include "volute/base/parallel.hpp"
#include "volute/codec/block_codec.hpp"
#include "volute/codec/block_row.hpp"
#include "volute/codec/container.hpp"
#include "volute/codec/parallel_try.hpp"
#include "volute/codec/spool.hpp"
#include "volute/codec/step_search.hpp"

namespace volute {
namespace {

// Blocks encoded before their bytes go to the spools; bounds the memory of a row of many blocks.
constexpr std::size_t kBatch = 64;
// Buffers of a batch, for each value of a block: a generous bound of what encode() and decode()
// hold.
constexpr std::uint64_t kBatchBytesAValue = 16;

using Kind = ErrorTarget::Kind;

std::string nameOf(Kind kind) {
  switch (kind) {
    case Kind::kRms:
      return "rms";
    case Kind::kPsnr:
      return "psnr";
    case Kind::kRatio:
      return "ratio";
    case Kind::kSize:
      return "size";
    case Kind::kMaxError:
      return "max-error";
  }
  return "";
}

bool isSize(Kind kind) {
  return kind == Kind::kRatio || kind == Kind::kSize;
}

Status checkOptions(const CompressOptions& options) {
  if (options.wavelet == "cdf53" || options.wavelet == "cdf97") {
    return fail(ErrorCode::kUnsupported,
                "wavelet {}: codec 1 (haar-zstd) has the Haar wavelet only; use auto or haar",
                options.wavelet);
  }
  if (options.wavelet != "auto" && options.wavelet != "haar") {
    return fail(ErrorCode::kInvalidArgument,
                "wavelet '{}' is unknown; expected auto, haar, cdf53 or cdf97", options.wavelet);
  }
  const double value = options.target.value;
  if (options.target.kind == Kind::kMaxError && value == 0) {
    return fail(ErrorCode::kInvalidArgument,
                "a maximum error of 0 would need a lossless codec; ask for a positive one");
  }
  if (!std::isfinite(value) || (options.target.kind != Kind::kPsnr && value <= 0)) {
    return fail(ErrorCode::kInvalidArgument,
                "a target of {} = {} makes no sense; expected a positive number",
                nameOf(options.target.kind), value);
  }
  return {};
}

// What one way through all blocks with one step gives.
struct Outcome {
  double squaredError = 0;
  double maxError = 0;
};

struct EncodedBlock {
  std::vector<std::vector<std::byte>> tiers;
  Outcome outcome;
};

/// One call of compress().
class Compressor {
 public:
  Compressor(FrameSource& source, const std::filesystem::path& target,
             const CompressOptions& options, Progress& progress)
      : target_(target),
        options_(options),
        progress_(progress),
        info_(source.info()),
        row_(source) {
    head_.info = info_;
    head_.codec = &haarCodec();
    head_.header.writtenBy = "volute " VOLUTE_VERSION;
    head_.header.provenance = options.provenance;
    head_.header.targetKind = nameOf(options.target.kind);
    head_.header.targetValue = options.target.value;
  }

  Result<CompressReport> run();

 private:
  Status openSpools();
  Status analyse();
  Status encodeAll(double step);
  Status encodeRow(int row);
  Status append(const EncodedBlock& block, std::size_t number);
  Result<EncodedBlock> encodeBlock(std::size_t block) const;
  Status checkCancelled() const;

  StepSearch::Problem problem() const;
  double firstStep(const StepSearch::Problem& problem) const;
  double outcomeOfTry() const;
  tl::unexpected<Error> unreachable() const;
  Result<CompressReport> write();

  std::filesystem::path target_;
  const CompressOptions& options_;
  Progress& progress_;
  const VolumeInfo& info_;
  BlockRow row_;
  FileHead head_;
  std::vector<std::byte> headBytes_;
  ErrorHistogram histogram_;
  std::vector<Spool> spools_;  // one a tier
  Outcome outcome_;
  double relativeRms_ = 0;  // of the last way through all blocks
  int tries_ = 0;
};

Status Compressor::checkCancelled() const {
  if (progress_.cancelled())
    return fail(ErrorCode::kCancelled, "stopped: {} was not written", target_.string());
  return {};
}

Status Compressor::openSpools() {
  auto folder = target_ == "-" ? std::filesystem::temp_directory_path() : target_.parent_path();
  if (folder.empty())
    folder = ".";
  for (std::size_t tier = 0; tier < head_.codec->tierLevels().size(); ++tier) {
    auto spool = Spool::create(folder);
    if (!spool)
      return fail(spool.error().code, "{}: cannot be written: {}", target_.string(),
                  spool.error().message);
    spools_.push_back(std::move(*spool));
  }
  return {};
}

Status Compressor::analyse() {
  // A fixed number of histograms, each of the same blocks whatever the threads, so that sums come
  // out the same.
  constexpr std::size_t kParts = 16;
  const BlockGrid& grid = row_.grid();
  const std::size_t blocks = grid.rowCount();
  const std::size_t parts = std::min(kParts, blocks);
  std::vector<ErrorHistogram> histograms(parts);
  for (int row = 0; row < row_.rows(); ++row) {
    VOLUTE_TRY(checkCancelled());
    VOLUTE_TRY(row_.load(row));
    parallelFor(parts, [&](std::size_t part) {
      std::vector<float> values;
      for (std::size_t i = blocks * part / parts; i < blocks * (part + 1) / parts; ++i) {
        const std::size_t block = row * blocks + i;
        values.resize(grid.values(block));
        row_.cut(block, values);
        head_.codec->analyse(values, shapeOf(grid, block), histograms[part]);
      }
    });
    progress_.report("analysing", row + 1, row_.rows());
  }
  for (const ErrorHistogram& histogram : histograms) histogram_.add(histogram);
  head_.header.valueMin = head_.parameters.valueMin = row_.minimum();
  head_.header.valueMax = head_.parameters.valueMax = row_.maximum();
  return {};
}

// Encodes a block and decodes it as the reader will.
Result<EncodedBlock> Compressor::encodeBlock(std::size_t block) const {
  const BlockShape shape = shapeOf(row_.grid(), block);
  std::vector<float> values(shape.values());
  std::vector<float> decoded(values.size());
  row_.cut(block, values);
  EncodedBlock result;
  result.tiers = head_.codec->encode(values, shape, head_.parameters);
  VOLUTE_TRY(head_.codec->decode(result.tiers, shape.levels(), shape, head_.parameters, decoded));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double error = std::abs(static_cast<double>(decoded[i]) - values[i]);
    result.outcome.squaredError += error * error;
    result.outcome.maxError = std::max(result.outcome.maxError, error);
  }
  if (!std::isfinite(result.outcome.squaredError)) {
    return fail(ErrorCode::kInvalidData, "grid '{}': the input changed while it was read",
                info_.name);
  }
  return result;
}

Status Compressor::append(const EncodedBlock& block, std::size_t number) {
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) {
    const auto& bytes = block.tiers[tier];
    head_.segments[tier * row_.grid().count() + number] = {
        0, static_cast<std::uint32_t>(bytes.size()), crc32(bytes)};
    VOLUTE_TRY(spools_[tier].write(bytes));
  }
  outcome_.squaredError += block.outcome.squaredError;
  outcome_.maxError = std::max(outcome_.maxError, block.outcome.maxError);
  return {};
}

Status Compressor::encodeRow(int row) {
  const std::size_t blocks = row_.grid().rowCount();
  std::vector<EncodedBlock> batch;
  for (std::size_t begin = 0; begin < blocks; begin += kBatch) {
    VOLUTE_TRY(checkCancelled());
    batch.clear();
    batch.resize(std::min(kBatch, blocks - begin));
    const std::size_t first = row * blocks + begin;
    VOLUTE_TRY(parallelTry(batch.size(), [&](std::size_t i) -> Status {
      VOLUTE_ASSIGN(batch[i], encodeBlock(first + i));
      return {};
    }));
    for (std::size_t i = 0; i < batch.size(); ++i) VOLUTE_TRY(append(batch[i], first + i));
  }
  return {};
}

Status Compressor::encodeAll(double step) {
  head_.parameters.step = step;
  head_.segments.assign(row_.grid().count() * spools_.size(), Segment{});
  outcome_ = {};
  for (Spool& spool : spools_) VOLUTE_TRY(spool.clear());
  ++tries_;
  const std::string stage =
      tries_ == 1 ? "compressing" : fmt::format("compressing, try {}", tries_);
  for (int row = 0; row < row_.rows(); ++row) {
    // A sequence of one row is still loaded from the way before.
    if (row_.rows() > 1)
      VOLUTE_TRY(row_.load(row));
    VOLUTE_TRY(encodeRow(row));
    progress_.report(stage, row + 1, row_.rows());
  }
  const double range = head_.header.valueMax - head_.header.valueMin;
  const double rms = std::sqrt(outcome_.squaredError / static_cast<double>(info_.values()));
  relativeRms_ = range > 0 ? rms / range : rms;
  head_.header.reachedRms =
      relativeRms_ + (range > 0 ? options_.sourceRms / range : options_.sourceRms);
  head_.header.reachedMaxError = outcome_.maxError + options_.sourceMaxError;
  headBytes_ = writeHead(head_);
  return {};
}

StepSearch::Problem Compressor::problem() const {
  const double greatest =
      std::max(std::abs(head_.header.valueMin), std::abs(head_.header.valueMax));
  StepSearch::Problem problem;
  // Coarser than the greatest orthonormal coefficient of a block, 4^4 times the greatest value,
  // gives nothing but zeros; finer than a float's rounding gains nothing.
  problem.coarsest = std::ldexp(greatest, 10);
  problem.finest = std::ldexp(greatest, -28);
  if (head_.header.valueMin == head_.header.valueMax) {
    // Clamping makes a constant exact whatever the step.
    problem.finest = problem.coarsest = greatest > 0 ? std::ldexp(greatest, -12) : 1;
  }
  const double value = options_.target.value;
  switch (options_.target.kind) {
    case Kind::kRms:
      problem.target = value;
      break;
    case Kind::kPsnr:
      problem.target = std::pow(10, -value / 20);
      break;
    case Kind::kRatio:
      problem.target = std::floor(static_cast<double>(info_.rawBytes()) / value);
      break;
    case Kind::kSize:
      problem.target = value;
      break;
    case Kind::kMaxError:
      problem.target = value;
      break;
  }
  problem.grows = !isSize(options_.target.kind);
  problem.closeEnough = problem.target * (isSize(options_.target.kind)              ? 0.97
                                          : options_.target.kind == Kind::kMaxError ? 0.85
                                                                                    : 0.95);
  return problem;
}

// The step that the histogram predicts to meet the target.
double Compressor::firstStep(const StepSearch::Problem& problem) const {
  constexpr double kMargin = 0.985;      // predictions of the RMS are right to about 1 %
  constexpr double kErrorOfAStep = 0.7;  // typical: step / greatest error
  if (options_.target.kind == Kind::kMaxError)
    return kErrorOfAStep * problem.target;
  const double range = head_.header.valueMax - head_.header.valueMin;
  const auto predicted = [&](double step) {
    // A coefficient that is left costs about a byte.
    if (isSize(options_.target.kind))
      return -histogram_.survivors(step);
    return std::sqrt(histogram_.squaredError(step) / static_cast<double>(info_.values())) / range;
  };
  const double wanted = isSize(options_.target.kind) ? -problem.target : kMargin * problem.target;
  double fine = problem.finest;
  double coarse = problem.coarsest;
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(fine * coarse);
    (predicted(middle) <= wanted ? fine : coarse) = middle;
  }
  return fine;
}

double Compressor::outcomeOfTry() const {
  switch (options_.target.kind) {
    case Kind::kRatio:
    case Kind::kSize:
      return static_cast<double>(head_.fileBytes);
    case Kind::kMaxError:
      return outcome_.maxError;
    default:
      return relativeRms_;
  }
}

tl::unexpected<Error> Compressor::unreachable() const {
  if (isSize(options_.target.kind)) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: cannot be made as small as {} = {}; the smallest is {} bytes of {} raw ones",
                target_.string(), nameOf(options_.target.kind), options_.target.value,
                head_.fileBytes, info_.rawBytes());
  }
  return fail(ErrorCode::kInvalidArgument,
              "{}: {} = {} cannot be reached: the rounding of float32 leaves a relative RMS of "
              "{:.3g} and a maximum error of {:.3g}; ask for more",
              target_.string(), nameOf(options_.target.kind), options_.target.value, relativeRms_,
              outcome_.maxError);
}

Result<CompressReport> Compressor::write() {
  VOLUTE_ASSIGN(auto file, OutputFile::create(target_));
  VOLUTE_TRY(file.write(headBytes_));
  for (Spool& spool : spools_) VOLUTE_TRY(spool.copyTo(file));
  VOLUTE_TRY(file.commit());
  CompressReport report;
  report.rawBytes = info_.rawBytes();
  report.fileBytes = head_.fileBytes;
  report.relativeRms = relativeRms_;
  report.maxError = outcome_.maxError;
  report.valueMin = head_.header.valueMin;
  report.valueMax = head_.header.valueMax;
  report.blocks = row_.grid().count();
  return report;
}

Result<CompressReport> Compressor::run() {
  VOLUTE_TRY(openSpools());
  VOLUTE_TRY(analyse());
  const StepSearch::Problem wanted = problem();
  StepSearch search(wanted, firstStep(wanted));
  while (!search.found()) {
    VOLUTE_TRY(encodeAll(search.step()));
    search.tell(outcomeOfTry());
    if (search.failed())
      return unreachable();
  }
  return write();
}

Status checkMemory(const VolumeInfo& info, const CompressOptions& options) {
  const std::uint64_t batchBlocks = std::min<std::uint64_t>(kBatch, BlockGrid(info).rowCount());
  const std::uint64_t needed =
      BlockRow::bytesNeeded(info) + batchBlocks * kBatchBytesAValue * BlockGrid(info).values(0);
  if (needed <= options.maxMemory)
    return {};
  return fail(ErrorCode::kTooLarge,
              "{} frames of {} x {} x {} voxels, which are compressed together, need {} MiB of "
              "memory, more than the {} MiB "
              "allowed; raise --max-memory",
              std::min(info.frames, BlockGrid::kSide), info.x, info.y, info.z,
              (needed + (1 << 20) - 1) >> 20, options.maxMemory >> 20);
}

}  // namespace

Result<CompressReport> compress(FrameSource& source, const std::filesystem::path& target,
                                const CompressOptions& options, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  VOLUTE_TRY(checkOptions(options));
  VOLUTE_TRY(source.info().validate("the input"));
  VOLUTE_TRY(checkMemory(source.info(), options));
  Compressor compressor(source, target, options, progress);
  VOLUTE_ASSIGN(CompressReport report, compressor.run());
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace volute
