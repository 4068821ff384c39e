// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/compress.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/checksum.hpp"
#include "volute/base/gather_values.hpp"
#include "volute/base/parallel.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/codec/compressor.hpp"
#include "volute/codec/step_search.hpp"
#include "volute/codec/written_file.hpp"

namespace volute {
namespace {

// Buffers of a batch, for each value of a block: a generous bound of what encode() and decode()
// hold.
constexpr std::uint64_t kBatchBytesAValue = 32;

using Kind = ErrorTarget::Kind;

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

tl::unexpected<Error> tooLarge(const VolumeInfo& info, std::uint64_t needed,
                               const CompressOptions& options) {
  return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
              "{} frames of {} x {} x {} voxels, which are compressed together, need {} MiB of "
              "memory, more than the {} MiB "
              "allowed",
              std::min(info.frames, BlockGrid::kSide), info.x, info.y, info.z,
              (needed + (1 << 20) - 1) >> 20, options.maxMemory >> 20);
}

/// How many layers of blocks are read together: all 16 frames, or of sources that can be read by
/// layers as many as fit in memory; less where several ranks wait for work, but enough for all
/// threads of one.
Result<int> layersAUnit(const FrameSource& source, const CompressOptions& options,
                        const Team& team) {
  const VolumeInfo& info = source.info();
  const BlockGrid grid(info);
  const int all = grid.counts()[1];
  const auto needed = [&](int layers) {
    const std::uint64_t blocks =
        static_cast<std::uint64_t>(layers) * grid.counts()[2] * grid.counts()[3];
    return BlockRow::bytesNeeded(source, layers) +
           std::min<std::uint64_t>(kBatchOfBlocks, blocks) * kBatchBytesAValue * grid.values(0);
  };
  int layers = all;
  if (source.readsLayers()) {
    const auto aLayer = static_cast<std::size_t>(grid.counts()[2]) * grid.counts()[3];
    // The same units for any number of ranks, where those of an earlier run may be there.
    if (team.size() > 1 || !options.work.empty())
      layers = static_cast<int>(std::min<std::size_t>(all, (kBatchOfBlocks + aLayer - 1) / aLayer));
    while (layers > 1 && needed(layers) > options.maxMemory) layers = (layers + 1) / 2;
  }
  if (needed(layers) > options.maxMemory)
    return tooLarge(info, needed(layers), options);
  return layers;
}

/// The same sequence must be before all ranks.
Status checkSameInput(const VolumeInfo& info, Team& team) {
  if (team.size() == 1)
    return {};
  ByteWriter own;
  for (const int number : {info.frames, info.z, info.y, info.x, info.channels}) own.varint(number);
  for (const int number : info.frameNumbers) own.zigzag(number);
  for (const double time : info.times) own.f64(time);
  own.string(info.name);
  own.string(info.unit);
  const std::uint32_t digest = crc32(own.view());
  VOLUTE_ASSIGN(const auto all, gatherValues(team, std::span<const std::uint32_t>(&digest, 1)));
  const auto other = std::ranges::find_if(all, [&](std::uint32_t one) { return one != all[0]; });
  if (other == all.end())
    return {};
  return fail(ErrorCode::kInvalidData,
              "rank {} reads another sequence under this name than rank 0: expected the same size, "
              "frames and times everywhere",
              other - all.begin());
}

}  // namespace

Status Compressor::checkCancelled() const {
  if (progress_.cancelled())
    return fail(ErrorCode::kCancelled, "stopped: {} was not written", name_);
  return {};
}

// What the last pass over all blocks came to.
void Compressor::noteErrors() {
  const double channels = info_.channels;
  const double squared = error_.squared() / doneShare_;
  const double voxels = static_cast<double>(info_.voxels()) * info_.frames;
  relativeRms_ = overAll(std::sqrt(squared / (voxels * channels)));
  const double support = std::max(supportVoxels_, 1.0) * channels;
  support_.rms = overSupport(std::sqrt(squared / support));
  std::uint64_t place = error_.place;
  for (const auto& [number, size] :
       {std::pair{&support_.worstVoxel[0], info_.x}, std::pair{&support_.worstVoxel[1], info_.y},
        std::pair{&support_.worstVoxel[2], info_.z}}) {
    *number = static_cast<int>(place % static_cast<std::uint64_t>(size));
    place /= static_cast<std::uint64_t>(size);
  }
  support_.worstFrame = static_cast<int>(place);
  head_.header.reachedRms = relativeRms_ + overAll(options_.sourceRms + rounding_);
  head_.header.reachedMaxError = error_.maximum + options_.sourceMaxError + rounding_;
  head_.header.support = support_;
  // What the source is off is spread over its support, at worst.
  head_.header.support->rms += overSupport(
      rounding_ + options_.sourceRms * std::sqrt(voxels / std::max(supportVoxels_, 1.0)));
}

double Compressor::outcomeOfTry() const {
  switch (options_.target.kind) {
    case Kind::kRatio:
    case Kind::kSize:
      return static_cast<double>(fileBytes_);
    case Kind::kMaxError:
      return error_.maximum;
    case Kind::kRms:
    case Kind::kLook:
      return dilution_ * support_.rms;
    default:
      return relativeRms_;
  }
}

tl::unexpected<Error> Compressor::unreachable() const {
  if (goal_.isSize()) {
    return fail(ErrorCode::kUnsupported,
                "{}: cannot be made as small as {} = {}; the smallest is {} bytes of {} raw ones",
                name_, nameOf(options_.target.kind), options_.target.value, fileBytes_,
                info_.rawBytes());
  }
  const double greatest =
      std::max(std::abs(head_.header.valueMin), std::abs(head_.header.valueMax));
  if (const double apart = std::ldexp(greatest, -23);
      goal_.isMaxError() && goal_.value() < apart && error_.maximum > apart) {
    return fail(ErrorCode::kUnsupported,
                "{}: {} = {} cannot be reached: it is finer than float32, in which values as large "
                "as {:.3g} are {:.2g} apart; ask for more",
                name_, nameOf(options_.target.kind), options_.target.value, greatest, apart);
  }
  // Floats as far from zero as that have an offset, unless some values lie elsewhere.
  constexpr double kFar = 32;
  const bool far = greatest > kFar * (support_.high - support_.low);
  return fail(
      ErrorCode::kUnsupported,
      "{}: {} = {} cannot be reached: the rounding of float32{} leaves a relative RMS of {:.3g} "
      "and a maximum error of {:.3g}; ask for more{}",
      name_, nameOf(options_.target.kind), options_.target.value,
      far ? fmt::format(", in which values up to {:.3g} are transformed,", greatest) : "",
      options_.target.isOverSupport() ? support_.rms + overSupport(rounding_)
                                      : relativeRms_ + overAll(rounding_),
      error_.maximum + rounding_, far ? ", or subtract what most have in common first" : "");
}

// What an earlier run kept may lack the bytes: a disk lost them.
Status Compressor::completeUnits() {
  for (std::size_t i = 0; i < units_.units().size(); ++i) {
    if (units_.units()[i].hasBytes)
      continue;
    EncodedUnits::Unit again = units_.begin(units_.units()[i].number);
    EncodedUnitRecord record;
    VOLUTE_TRY(encodeUnit(Pass::kEncode, again, record));
    units_.replace(i, std::move(again));
  }
  return {};
}

std::vector<FaintFrame> Compressor::faintFrames() const {
  constexpr double kFaint = 0.1;
  std::vector<FaintFrame> all;
  for (std::size_t i = 0; i < facts_.size(); ++i) {
    const SupportFacts& frame = facts_[i];
    const double range = static_cast<double>(frame.most) - frame.least;
    if (frame.voxels == 0 || !(range < kFaint * (support_.high - support_.low)))
      continue;
    const double rms =
        std::sqrt(frameSquares_[i] / (static_cast<double>(frame.voxels) * info_.channels));
    all.push_back(
        {static_cast<int>(i), range, CompressionGoal::relative(rms, frame.least, frame.most)});
  }
  return all;
}

Result<CompressReport> Compressor::write() {
  VOLUTE_TRY(team_.agree(completeUnits()));
  const auto writeAll = [&]() -> Status {
    VOLUTE_ASSIGN(auto file, CheckedFile::create(target_, name_));
    VOLUTE_TRY(file.bytes().write(headBytes_));
    VOLUTE_TRY(units_.writeSegments(file.bytes(), [this] { return checkCancelled(); }));
    return file.commit(headBytes_, std::span(&head_, 1), progress_);
  };
  VOLUTE_TRY(team_.agree(team_.leads() ? writeAll() : units_.sendSegments()));
  if (store_)
    store_->remove();
  CompressReport report;
  report.rawBytes = info_.rawBytes();
  report.fileBytes = fileBytes_;
  report.relativeRms = relativeRms_ + overAll(rounding_);
  report.maxError = error_.maximum + rounding_;
  report.support = support_;
  report.support.rms += overSupport(rounding_);
  report.support.low += parameters_.offset, report.support.high += parameters_.offset;
  report.faintFrames = faintFrames();
  report.valueMin = head_.header.valueMin + parameters_.offset;
  report.valueMax = head_.header.valueMax + parameters_.offset;
  report.blocks = head_.blocks.size();
  report.blockFrames = parameters_.blockFrames;
  return report;
}

Status Compressor::searchStep(double first) {
  StepSearch::Problem problem = goal_.problem();
  if (problem.grows)
    problem.closeEnough = effort_.nearness * problem.target;
  StepSearch search(problem, first);
  for (bool found = false; !found;) {
    VOLUTE_TRY(encodeAll(search.step(), Pass::kEncode));
    search.tell(outcomeOfTry());
    VOLUTE_ASSIGN(const bool failed, team_.broadcast(search.failed()));
    if (failed && dilution_ > 1) {  // float32 is too coarse for it
      dilution_ = 1;
      return searchStep(first);
    }
    if (failed)
      return unreachable();
    VOLUTE_ASSIGN(found, team_.broadcast(search.found()));
  }
  return {};
}

// The greatest error of decoded values after which floats, to which they are rounded with their
// offset, are within `maxError`: of those between two floats one may be farther.
double Compressor::withinFloats(double maxError) const {
  constexpr double kAside = 1 - 1e-6;
  if (!floats_)
    return maxError;
  const double greatest = std::max(std::abs(parameters_.offset + head_.header.valueMin),
                                   std::abs(parameters_.offset + head_.header.valueMax));
  // Of the greatest values, and those up to half as large.
  const double apart = std::ldexp(1.0, std::ilogb(greatest) - 23);
  double within = maxError;
  for (const double one : {apart, apart / 2})
    within = std::min(within, (std::floor(maxError / one) + 0.5) * one * kAside);
  return within;
}

// Corrections keep the maximum error whatever the step: the one that makes the smallest file, from
// the middle outwards.
Status Compressor::searchSmallest() {
  const double target = goal_.value();
  double best = 0;
  std::uint64_t least = 0;
  for (const double factor : {1.5, 2.1, 3.0, 1.05, 0.75}) {
    if ((factor == 3.0 && best < 2 * target) || (factor == 1.05 && best > 2 * target) ||
        (factor == 0.75 && best > 1.2 * target))
      continue;
    VOLUTE_TRY(encodeAll(factor * target, Pass::kEncode));
    if (least == 0 || fileBytes_ < least) {
      least = fileBytes_;
      best = factor * target;
    }
  }
  if (parameters_.step != best / parameters_.unit())
    VOLUTE_TRY(encodeAll(best, Pass::kEncode));
  // What float32 adds to the corrected values is made up for by finer corrections.
  constexpr int kTries = 4;
  for (int i = 0; i < kTries && !(error_.maximum <= target); ++i) {
    const double less = std::max(parameters_.maxError - 1.25 * (error_.maximum - target),
                                 0.25 * parameters_.maxError);
    parameters_.maxError = less;
    VOLUTE_TRY(encodeAll(best, Pass::kEncode));
  }
  if (!(error_.maximum <= target))
    return unreachable();
  return {};
}

double Compressor::betterStep() const {
  return goal_.betterStep(parameters_.step * parameters_.unit(), outcomeOfTry(),
                          0.5 + 0.5 * effort_.nearness, power_);
}

// Modes and step from some blocks: how all came out with them is near what was asked for.
Result<double> Compressor::stepFromSome(double first) {
  constexpr double kFar = 1.15, kTellsPower = 0.1, kGreatestPower = 1.4;
  VOLUTE_TRY(encodeAll(first, Pass::kLearn));
  const double learnt = std::max(outcomeOfTry(), 1e-30);
  double step = betterStep();
  VOLUTE_TRY(chooseLength());
  const int tries = blocks_ < kFewBlocks ? 3 : 2;
  for (int i = 0; i < tries; ++i) {
    VOLUTE_TRY(encodeAll(step, Pass::kTry));
    // At fine steps the error goes as they do, at coarse ones less.
    const double steps = std::log(step / first);
    const double errors = std::log(std::max(outcomeOfTry(), 1e-30) / learnt);
    if (std::abs(steps) > kTellsPower && steps * errors > 0)
      power_ = std::clamp(steps / errors, 1.0, kGreatestPower);
    const double better = betterStep();
    const double change = std::max(better / step, step / better);
    step = better;
    if (change < kFar)
      break;
  }
  return step;
}

bool Compressor::nearEnough() const {
  const StepSearch::Problem problem = goal_.problem();
  const double outcome = outcomeOfTry();
  return outcome <= problem.target && (outcome >= effort_.nearness * problem.target ||
                                       parameters_.step * parameters_.unit() >= problem.coarsest);
}

Result<CompressReport> Compressor::run() {
  VOLUTE_TRY(units_.open(target_, name_));
  VOLUTE_TRY(survey());
  if (rounding_ > 0 && head_.header.valueMin == 0 && head_.header.valueMax == 0) {
    return fail(ErrorCode::kUnsupported,
                "all values are below float32, in which they are kept, and would become 0: they go "
                "up to {:.3g}; scale them",
                rounding_);
  }
  if (options_.halves)
    goal_.leaveRoomForHalves(roundingToHalves(), parameters_.offset);
  VOLUTE_TRY(goal_.leaveRoomFor(rounding_));
  if (goal_.isMaxError())
    // What is decoded is rounded to a float as well.
    parameters_.maxError = withinFloats(std::max(goal_.value() - rounding_, 0.5 * goal_.value()));
  VOLUTE_TRY(team_.agree(openStore()));
  goal_.setModel(model_);
  double step = goal_.firstStep();
  if (goal_.isSize() || goal_.isMaxError()) {
    VOLUTE_TRY(encodeAll(step, Pass::kLearn));
    VOLUTE_TRY(chooseLength());
  } else {
    VOLUTE_ASSIGN(step, stepFromSome(step));
  }
  VOLUTE_TRY(encodeAll(step, Pass::kChoose));
  if (goal_.isMaxError()) {
    VOLUTE_TRY(searchSmallest());
    return write();
  }
  // Modes depend on the step, and on what blocks in other modes have taught.
  VOLUTE_ASSIGN(const double better, team_.broadcast(betterStep()));
  VOLUTE_ASSIGN(step, team_.broadcast(step));
  const double change = std::max(better / step, step / better);
  if (change > (effort_.again ? 1.02 : 1.2))
    VOLUTE_TRY(encodeAll(better, Pass::kChoose));
  VOLUTE_ASSIGN(const bool near, team_.broadcast(nearEnough()));
  if (!near || effort_.again)
    VOLUTE_TRY(searchStep(betterStep()));
  return write();
}

Result<CompressReport> compress(FrameSource& source, const std::filesystem::path& target,
                                const CompressOptions& options, Progress& progress, Team& team) {
  const auto start = std::chrono::steady_clock::now();
  VOLUTE_TRY(checkOptions(options));
  VOLUTE_TRY(source.info().validate("the input"));
  VOLUTE_ASSIGN(const int layers, layersAUnit(source, options, team));
  VOLUTE_TRY(checkSameInput(source.info(), team));
  std::optional<LookFigures> look;
  const auto measure = [&]() -> Status {
    VOLUTE_ASSIGN(look, lookFigures(source));
    return {};
  };
  // Colours are light, distances no amount of anything.
  if (source.info().channels == 1 && !source.info().levelSet)
    VOLUTE_TRY(team.agree(team.leads() ? measure() : Status()));
  Compressor compressor(source, target, options, layers, progress, team);
  compressor.setLook(look);
  VOLUTE_ASSIGN(CompressReport report, compressor.run());
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

Result<CompressReport> compress(FrameSource& source, const std::filesystem::path& target,
                                const CompressOptions& options, Progress& progress) {
  Team alone;
  return compress(source, target, options, progress, alone);
}

}  // namespace volute
