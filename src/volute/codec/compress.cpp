// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/compress.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <mutex>
#include <vector>

#include "volute/base/checksum.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/version.hpp"
#include "volute/codec/block_encoder.hpp"
#include "volute/codec/block_row.hpp"
#include "volute/codec/coefficient_coder.hpp"
#include "volute/codec/container.hpp"
#include "volute/codec/parallel_try.hpp"
#include "volute/codec/spool.hpp"
#include "volute/codec/step_search.hpp"
#include "volute/wavelet/quantiser.hpp"

namespace volute {
namespace {

// Blocks encoded before their bytes go to the spools; bounds the memory of a row of many blocks.
constexpr std::size_t kBatch = 64;
// Buffers of a batch, for each value of a block: a generous bound of what encode() and decode()
// hold.
constexpr std::uint64_t kBatchBytesAValue = 32;
// A step this much finer than the one that modes were chosen for asks again about blocks left out.
constexpr double kFinerStep = 0.75;

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
  if (options.wavelet != "auto" && !waveletByName(options.wavelet)) {
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

std::vector<BlockMode> modesToTry(const CompressOptions& options) {
  if (options.mode)
    return {*options.mode};
  const auto wavelet = waveletByName(options.wavelet);
  std::vector<BlockMode> modes;
  for (const BlockMode& mode : allBlockModes()) {
    const bool quick = mode.shaped ? mode.timeLevels == 0 : mode.timeLevels == 4;
    if (wavelet ? mode.wavelet != *wavelet : options.fast && mode.wavelet == Wavelet::kHaar)
      continue;
    if (!options.fast || quick)
      modes.push_back(mode);
  }
  return modes;
}

// Where the search among many modes begins: none, where all of few are tried. `before`: the mode
// that the block had at another step.
std::vector<BlockMode> modesToBeginWith(const CompressOptions& options,
                                        const std::optional<BlockMode>& before) {
  if (options.mode || options.fast)
    return {};
  const auto only = waveletByName(options.wavelet);
  const auto mode = [&](bool shaped, Wavelet wavelet, int timeLevels) {
    return BlockMode{shaped, only.value_or(wavelet), timeLevels};
  };
  // With both, fine steps and coarse ones are served, that lead to other modes.
  if (before)
    return {*before, mode(true, Wavelet::kCdf97, 0)};
  return {mode(false, Wavelet::kCdf53, 4), mode(false, Wavelet::kCdf53, 0),
          mode(true, Wavelet::kCdf53, 0), mode(true, Wavelet::kCdf53, 4),
          mode(false, Wavelet::kHaar, 0)};
}

/// One call of compress(). Goes through the blocks several times: to survey the values; to learn
/// what quantised coefficients are like, from some of them; to choose the mode of each block; and
/// to encode them all, until the step meets the target.
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
    head_.header.codec = kWaveletCodec;
    head_.header.writtenBy = "volute " VOLUTE_VERSION;
    head_.header.provenance = options.provenance;
    head_.header.targetKind = nameOf(options.target.kind);
    head_.header.targetValue = options.target.value;
    if (options.target.kind == Kind::kMaxError)
      parameters_.maxError = options.target.value;
  }

  Result<CompressReport> run();

 private:
  // One way through all rows of blocks, or some of them.
  enum class Way { kLearn, kChoose, kEncode };

  Status openSpools();
  Status survey();
  Status encodeAll(double step, Way way);
  Status encodeRow(int row, Way way);
  Status append(const EncodedBlock& block, std::size_t number);
  std::optional<BlockMode> chooseMode(std::size_t block, std::span<const float> values,
                                      const BlockEncoder& encoder, bool near) const;
  Result<EncodedBlock> encodeBlock(std::size_t block, Way way, Training& training);
  Status checkCancelled() const;
  Status searchStep(double first);
  Status searchSmallest();

  StepSearch::Problem problem() const;
  double firstStep(const StepSearch::Problem& problem) const;
  double betterStep(const StepSearch::Problem& problem) const;
  double outcomeOfTry() const;
  tl::unexpected<Error> unreachable() const;
  Result<CompressReport> write();

  StreamInfo stream() const {
    return {info_.channels, static_cast<float>(head_.header.valueMin),
            static_cast<float>(head_.header.valueMax)};
  }

  std::filesystem::path target_;
  const CompressOptions& options_;
  Progress& progress_;
  const VolumeInfo& info_;
  BlockRow row_;
  FileHead head_;
  std::vector<std::byte> headBytes_;
  WaveletParameters parameters_;
  Training training_;  // of the last way through
  std::vector<std::optional<BlockMode>> modes_;
  bool chosenBefore_ = false;  // modes_ are those of another step, else a guess
  double chosenStep_ = 0;      // at which modes_ were chosen
  QuantisationModel model_;
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
  for (std::size_t tier = 0; tier < kWaveletTiers.size(); ++tier) {
    auto spool = Spool::create(folder);
    if (!spool)
      return fail(spool.error().code, "{}: cannot be written: {}", target_.string(),
                  spool.error().message);
    spools_.push_back(std::move(*spool));
  }
  return {};
}

// Adds the coefficients of a block in a middling transform, each at the size it has in the values.
void addCoefficients(std::span<const float> values, const BlockShape& shape,
                     QuantisationModel& model) {
  const AxisLevels levels = blockLevels(shape.extents, 4);
  std::vector<float> plane(shape.voxels());
  for (int c = 0; c < shape.channels; ++c) {
    for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = values[i * shape.channels + c];
    shapeForward(plane, {}, shape.extents, Wavelet::kCdf53, levels);
    for (int stride = 0; stride < deepest(levels); ++stride) {
      const CellLevel level(shape.extents, levels, stride, Wavelet::kCdf53);
      CellMemory memory;
      codeLevel(
          level, {}, nullptr, nullptr, memory,
          [&](std::ptrdiff_t position, std::uint16_t existing, const CellContext&, const auto&,
              const std::int32_t*) {
            for (unsigned left = existing; left != 0; left &= left - 1) {
              const int k = std::countr_zero(left);
              model.add(static_cast<float>(plane[position + level.offset[k]] * level.norm[k]));
            }
            return false;
          });
    }
  }
}

Status Compressor::survey() {
  // A fixed number of sums, each of the same blocks whatever the threads, so that they come out
  // the same.
  constexpr std::size_t kParts = 16;
  const BlockGrid& grid = row_.grid();
  const std::size_t blocks = grid.rowCount();
  const std::size_t parts = std::min(kParts, blocks);
  std::vector<QuantisationModel> models(parts);
  std::vector<ColorMoments> moments(parts);
  for (int row = 0; row < row_.rows(); ++row) {
    VOLUTE_TRY(checkCancelled());
    VOLUTE_TRY(row_.load(row));
    parallelFor(parts, [&](std::size_t part) {
      std::vector<float> values;
      for (std::size_t i = blocks * part / parts; i < blocks * (part + 1) / parts; ++i) {
        const std::size_t block = row * blocks + i;
        values.resize(grid.values(block));
        row_.cut(block, values);
        moments[part].add(values, info_.channels);
        addCoefficients(values, shapeOf(grid, block), models[part]);
      }
    });
    progress_.report("analysing", row + 1, row_.rows());
  }
  ColorMoments all;
  for (const ColorMoments& part : moments) all.add(part);
  for (const QuantisationModel& part : models) model_.merge(part);
  if (info_.channels == 3)
    parameters_.color = ColorTransform::of(all);
  head_.header.valueMin = row_.minimum();
  head_.header.valueMax = row_.maximum();
  const float greatest = std::max(std::abs(row_.minimum()), std::abs(row_.maximum()));
  if (greatest > 0)
    parameters_.exponent = std::clamp(std::ilogb(greatest) + 1, -126, 127);
  const std::vector<BlockMode> modes = modesToTry(options_);
  const BlockMode usual{false, Wavelet::kCdf53, 4};
  const bool tried = std::ranges::find(modes, usual) != modes.end();
  modes_.assign(grid.count(), tried ? usual : modes.front());
  return {};
}

// The mode of a block at this step; `near`: not far from the one that it has, if it has one.
std::optional<BlockMode> Compressor::chooseMode(std::size_t block, std::span<const float> values,
                                                const BlockEncoder& encoder, bool near) const {
  const auto starts = modesToBeginWith(options_, near ? modes_[block] : std::nullopt);
  return encoder.choose(values, shapeOf(row_.grid(), block), modesToTry(options_), starts);
}

// Encodes a block and decodes it as the reader will.
Result<EncodedBlock> Compressor::encodeBlock(std::size_t block, Way way, Training& training) {
  const BlockShape shape = shapeOf(row_.grid(), block);
  std::vector<float> values(shape.values());
  std::vector<float> decoded(values.size());
  row_.cut(block, values);
  const BlockEncoder encoder(parameters_, stream());
  if (way == Way::kChoose)
    modes_[block] = chooseMode(block, values, encoder, chosenBefore_);
  std::optional<BlockMode> mode = modes_[block];
  // A block that was not worth its bits at the step its mode was chosen for may be at a finer one.
  // What is chosen here depends on the step alone, so that a try can be had again.
  if (way == Way::kEncode && !mode && parameters_.step < kFinerStep * chosenStep_)
    mode = chooseMode(block, values, encoder, false);
  EncodedBlock result;
  result.tiers = encoder.encode(values, shape, mode, training);
  VOLUTE_TRY(head_.decoder->decode(result.tiers, shape.levels(), shape, decoded));
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

Status Compressor::encodeRow(int row, Way way) {
  const std::size_t blocks = row_.grid().rowCount();
  std::vector<EncodedBlock> batch;
  std::mutex mutex;
  for (std::size_t begin = 0; begin < blocks; begin += kBatch) {
    VOLUTE_TRY(checkCancelled());
    batch.clear();
    batch.resize(std::min(kBatch, blocks - begin));
    const std::size_t first = row * blocks + begin;
    VOLUTE_TRY(parallelTry(batch.size(), [&](std::size_t i) -> Status {
      Training training;
      VOLUTE_ASSIGN(batch[i], encodeBlock(first + i, way, training));
      const std::lock_guard lock(mutex);
      training_.add(training);
      return {};
    }));
    for (std::size_t i = 0; i < batch.size(); ++i) VOLUTE_TRY(append(batch[i], first + i));
  }
  return {};
}

Status Compressor::encodeAll(double step, Way way) {
  constexpr int kRowsToLearnFrom = 4;
  parameters_.step = step / parameters_.unit();
  // From the first try on the parameters stay, so that what a step gives can be had again.
  if (way == Way::kChoose || (way == Way::kEncode && tries_ == 0))
    training_.apply(parameters_);
  if (way == Way::kChoose)
    chosenStep_ = parameters_.step;
  training_ = {};
  head_.parameters = writeParameters(parameters_, info_.channels);
  VOLUTE_ASSIGN(head_.decoder, openWaveletDecoder(head_.parameters, stream()));
  head_.segments.assign(row_.grid().count() * spools_.size(), SegmentEntry{});
  outcome_ = {};
  for (Spool& spool : spools_) VOLUTE_TRY(spool.clear());
  const int rows = row_.rows();
  const int count = way == Way::kLearn ? std::min(rows, kRowsToLearnFrom) : rows;
  tries_ += way == Way::kEncode ? 1 : 0;
  const std::string stage = way == Way::kLearn    ? "learning"
                            : way == Way::kChoose ? "choosing modes"
                            : tries_ == 1         ? "compressing"
                                                  : fmt::format("compressing, try {}", tries_);
  for (int i = 0; i < count; ++i) {
    const int row = static_cast<int>(static_cast<std::int64_t>(i) * rows / count);
    // A sequence of one row is still loaded from the way before.
    if (rows > 1)
      VOLUTE_TRY(row_.load(row));
    VOLUTE_TRY(encodeRow(row, way));
    progress_.report(stage, i + 1, count);
  }
  chosenBefore_ = chosenBefore_ || way == Way::kChoose;
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
  problem.finest = std::ldexp(greatest, -21);
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
      break;  // searchSmallest()
  }
  problem.grows = !isSize(options_.target.kind);
  problem.closeEnough = 0.99 * problem.target;
  return problem;
}

// The step that the survey predicts to meet the target.
double Compressor::firstStep(const StepSearch::Problem& problem) const {
  constexpr double kMaxErrorSteps = 1.5;
  if (options_.target.kind == Kind::kMaxError)
    return kMaxErrorSteps * options_.target.value;
  const double range = head_.header.valueMax - head_.header.valueMin;
  if (!isSize(options_.target.kind)) {
    const double squared = problem.target * problem.target * range * range;
    return model_.stepFor(squared * static_cast<double>(info_.values()));
  }
  // A coefficient that is left costs about a byte.
  double fine = problem.finest;
  double coarse = problem.coarsest;
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(fine * coarse);
    (static_cast<double>(model_.survivors(middle)) > problem.target ? fine : coarse) = middle;
  }
  return coarse;
}

// The step that should meet the target, from what the last one gave.
double Compressor::betterStep(const StepSearch::Problem& problem) const {
  constexpr double kMostChange = 6;
  // How the step goes with the error, and with the size.
  const double power = isSize(options_.target.kind) ? -1.3 : 1.2;
  const double change = std::pow(0.995 * problem.target / std::max(outcomeOfTry(), 1e-30), power);
  return parameters_.step * parameters_.unit() * std::clamp(change, 1 / kMostChange, kMostChange);
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

Status Compressor::searchStep(double first) {
  StepSearch search(problem(), first);
  while (!search.found()) {
    VOLUTE_TRY(encodeAll(search.step(), Way::kEncode));
    search.tell(outcomeOfTry());
    if (search.failed())
      return unreachable();
  }
  return {};
}

// Corrections keep the maximum error whatever the step: the one that makes the smallest file, from
// the middle outwards.
Status Compressor::searchSmallest() {
  const double target = options_.target.value;
  double best = 0;
  std::uint64_t least = 0;
  for (const double factor : {1.5, 2.1, 3.0, 1.05, 0.75}) {
    if ((factor == 3.0 && best < 2 * target) || (factor == 1.05 && best > 2 * target) ||
        (factor == 0.75 && best > 1.2 * target))
      continue;
    VOLUTE_TRY(encodeAll(factor * target, Way::kEncode));
    if (least == 0 || head_.fileBytes < least) {
      least = head_.fileBytes;
      best = factor * target;
    }
  }
  if (parameters_.step != best / parameters_.unit())
    VOLUTE_TRY(encodeAll(best, Way::kEncode));
  if (!(outcome_.maxError <= target))
    return unreachable();
  return {};
}

Result<CompressReport> Compressor::run() {
  VOLUTE_TRY(openSpools());
  VOLUTE_TRY(survey());
  const StepSearch::Problem wanted = problem();
  const auto within = [&](double step) { return std::clamp(step, wanted.finest, wanted.coarsest); };
  const bool bounded = options_.target.kind == Kind::kMaxError;
  double step = within(firstStep(wanted));
  VOLUTE_TRY(encodeAll(step, Way::kLearn));
  VOLUTE_TRY(encodeAll(step, Way::kChoose));
  if (bounded) {
    VOLUTE_TRY(searchSmallest());
    return write();
  }
  // Modes depend on the step, and on what blocks in other modes have taught.
  const double better = within(betterStep(wanted));
  if (!options_.fast || std::max(better / step, step / better) > 1.5) {
    VOLUTE_TRY(encodeAll(better, Way::kChoose));
  }
  VOLUTE_TRY(searchStep(within(betterStep(wanted))));
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
