// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/compress.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <vector>

#include "volute/base/checksum.hpp"
#include "volute/base/content_hash.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/version.hpp"
#include "volute/codec/block_encoder.hpp"
#include "volute/base/output_file.hpp"
#include "volute/codec/block_row.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/codec/coefficient_coder.hpp"
#include "volute/codec/container.hpp"
#include "volute/codec/parallel_try.hpp"
#include "volute/codec/spool.hpp"
#include "volute/codec/step_search.hpp"
#include "volute/codec/unit_plan.hpp"
#include "volute/codec/unit_store.hpp"
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

// What a rank has of a unit after a way through it: sizes and checksums of its segments, block by
// block and tier by tier, and where each tier's bytes lie in the rank's spools.
struct DoneUnit {
  std::int64_t unit = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> segments;
  std::array<std::uint64_t, kWaveletTiers.size()> begins{}, sizes{};
  bool hasBytes = true;
};

// A layer's sums, for the other ranks.
struct LayerOutcome {
  std::uint64_t layer = 0;
  Outcome outcome;
};

// The values of all ranks, in the order of ranks.
template <class Value>
Result<std::vector<Value>> gatherValues(Team& team, std::span<const Value> own) {
  VOLUTE_ASSIGN(const auto all, team.gatherAll(std::as_bytes(own)));
  std::vector<Value> values;
  for (const auto& bytes : all) {
    const std::size_t before = values.size();
    values.resize(before + bytes.size() / sizeof(Value));
    if (!bytes.empty())
      std::memcpy(values.data() + before, bytes.data(), bytes.size());
  }
  return values;
}

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
/// to encode them all, until the step meets the target. All ranks of a team go through them
/// together; after each way they share what they found, and rank 0's decisions are those of all.
class Compressor {
 public:
  Compressor(FrameSource& source, const std::filesystem::path& target,
             const CompressOptions& options, int layersAUnit, Progress& progress, Team& team)
      : target_(target),
        options_(options),
        progress_(progress),
        team_(team),
        info_(source.info()),
        row_(source),
        plan_(row_.grid(), layersAUnit),
        goal_(options.target.value) {
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
  Status openStore();
  Status doUnit(std::int64_t number, Way way);
  Status encodeUnit(const UnitPlan::Unit& unit, Way way, DoneUnit& done, Training& training);
  Status append(const EncodedBlock& block, std::size_t number, DoneUnit& done);
  Status keep(const DoneUnit& done, const Training& training, std::size_t firstOutcome);
  Result<bool> recall(DoneUnit& done, Training& training);
  Status shareOutcomes();
  Status shareTraining();
  Status shareModes();
  Status shareSegments();
  void takeSegments(const DoneUnit& done);
  std::optional<BlockMode> chooseMode(std::size_t block, std::span<const float> values,
                                      const BlockEncoder& encoder, bool near) const;
  Result<EncodedBlock> encodeBlock(std::size_t block, Way way, Training& training);
  Status checkCancelled() const;
  Status searchStep(double first);
  Status searchSmallest();

  void leaveRoomForHalves();
  StepSearch::Problem problem() const;
  double firstStep(const StepSearch::Problem& problem) const;
  double betterStep(const StepSearch::Problem& problem) const;
  double outcomeOfTry() const;
  tl::unexpected<Error> unreachable() const;
  Result<CompressReport> write();
  Status completeUnits();
  Status writeSegments(OutputFile& file);
  Status sendSegments();

  StreamInfo stream() const {
    return {info_.channels, static_cast<float>(head_.header.valueMin),
            static_cast<float>(head_.header.valueMax)};
  }

  std::filesystem::path target_;
  const CompressOptions& options_;
  Progress& progress_;
  Team& team_;
  const VolumeInfo& info_;
  BlockRow row_;
  UnitPlan plan_;
  double goal_;  // what is asked for, and what rounding to halves leaves of it
  FileHead head_;
  std::vector<std::byte> headBytes_;
  WaveletParameters parameters_;
  Training training_;  // of the last way through
  std::vector<std::optional<BlockMode>> modes_;
  bool chosenBefore_ = false;  // modes_ are those of another step, else a guess
  double chosenStep_ = 0;      // at which modes_ were chosen
  QuantisationModel model_;
  std::optional<UnitStore> store_;       // of finished units, where that is asked for
  std::uint64_t content_ = 0;            // a digest of all values, for it
  int way_ = -1;                         // how many ways through the units were begun before
  std::vector<Spool> spools_;            // one a tier, of this rank's units
  std::vector<DoneUnit> done_;           // of this rank, in the last way through
  std::vector<LayerOutcome> outcomes_;   // of this rank's layers
  std::vector<int> ranks_;               // of rank 0: who has which unit
  std::uint64_t fileBytes_ = 0;          // as far as it was asked for
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
  // Of rank 0 alone the target's folder is needed.
  if (!team_.leads() && !Spool::create(folder))
    folder = std::filesystem::temp_directory_path();
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
  const BlockGrid& grid = row_.grid();
  const auto width = static_cast<std::size_t>(grid.counts()[3]);
  struct LayerMoments {
    std::uint64_t layer = 0;
    ColorMoments moments;
  };
  std::vector<LayerMoments> layers;
  VOLUTE_TRY(team_.forUnits("analysing", plan_.count(), progress_, [&](std::int64_t number) -> Status {
    VOLUTE_TRY(checkCancelled());
    const UnitPlan::Unit unit = plan_.unit(number);
    VOLUTE_TRY(row_.load(unit.row, unit.firstLayer, unit.endLayer));
    // A line of blocks is a task; sums go line by line, so that they come out the same.
    const std::size_t lines = plan_.blocks(unit) / width;
    std::vector<ColorMoments> moments(lines);
    std::mutex mutex;
    parallelFor(lines, [&](std::size_t line) {
      std::vector<float> values;
      QuantisationModel model;
      std::uint64_t content = 0;
      for (std::size_t i = line * width; i < (line + 1) * width; ++i) {
        const std::size_t block = plan_.firstBlock(unit) + i;
        values.resize(grid.values(block));
        row_.cut(block, values);
        moments[line].add(values, info_.channels);
        addCoefficients(values, shapeOf(grid, block), model);
        if (!options_.work.empty())
          content += (2 * block + 1) * crc32(std::as_bytes(std::span(values)));
      }
      const std::lock_guard lock(mutex);
      model_.merge(model);
      content_ += content;
    });
    const std::size_t linesALayer = plan_.blocksALayer() / width;
    for (std::size_t line = 0; line < lines; ++line) {
      if (line % linesALayer == 0)
        layers.push_back({plan_.firstLayer(unit) + line / linesALayer, {}});
      layers.back().moments.add(moments[line]);
    }
    return {};
  }));
  VOLUTE_TRY(team_.sum(model_.counts()));
  const std::array<float, 2> own{row_.minimum(), row_.maximum()};
  VOLUTE_ASSIGN(const auto limits, gatherValues(team_, std::span<const float>(own)));
  float least = limits[0], most = limits[1];
  for (std::size_t i = 0; i < limits.size(); i += 2) {
    least = std::min(least, limits[i]);
    most = std::max(most, limits[i + 1]);
  }
  if (info_.channels == 3) {
    VOLUTE_ASSIGN(layers, gatherValues(team_, std::span<const LayerMoments>(layers)));
    std::ranges::sort(layers, {}, &LayerMoments::layer);
  }
  ColorMoments all;
  for (const LayerMoments& part : layers) all.add(part.moments);
  if (info_.channels == 3) {
    VOLUTE_ASSIGN(parameters_.color, team_.broadcast(ColorTransform::of(all)));
  }
  head_.header.valueMin = least;
  head_.header.valueMax = most;
  const float greatest = std::max(std::abs(least), std::abs(most));
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

Status Compressor::append(const EncodedBlock& block, std::size_t number, DoneUnit& done) {
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) {
    const auto& bytes = block.tiers[tier];
    done.segments.emplace_back(static_cast<std::uint32_t>(bytes.size()), crc32(bytes));
    done.sizes[tier] += bytes.size();
    VOLUTE_TRY(spools_[tier].write(bytes));
  }
  const std::uint64_t layer = number / plan_.blocksALayer();
  if (outcomes_.empty() || outcomes_.back().layer != layer)
    outcomes_.push_back({layer, {}});
  Outcome& sum = outcomes_.back().outcome;
  sum.squaredError += block.outcome.squaredError;
  sum.maxError = std::max(sum.maxError, block.outcome.maxError);
  return {};
}

Status Compressor::encodeUnit(const UnitPlan::Unit& unit, Way way, DoneUnit& done,
                              Training& training) {
  VOLUTE_TRY(row_.load(unit.row, unit.firstLayer, unit.endLayer));
  const std::size_t blocks = plan_.blocks(unit);
  std::vector<EncodedBlock> batch;
  std::mutex mutex;
  for (std::size_t begin = 0; begin < blocks; begin += kBatch) {
    VOLUTE_TRY(checkCancelled());
    batch.clear();
    batch.resize(std::min(kBatch, blocks - begin));
    const std::size_t first = plan_.firstBlock(unit) + begin;
    VOLUTE_TRY(parallelTry(batch.size(), [&](std::size_t i) -> Status {
      Training ofBlock;
      VOLUTE_ASSIGN(batch[i], encodeBlock(first + i, way, ofBlock));
      const std::lock_guard lock(mutex);
      training.add(ofBlock);
      return {};
    }));
    for (std::size_t i = 0; i < batch.size(); ++i) VOLUTE_TRY(append(batch[i], first + i, done));
  }
  return {};
}

// A unit, or what an earlier run kept of it.
Status Compressor::doUnit(std::int64_t number, Way way) {
  VOLUTE_TRY(checkCancelled());
  DoneUnit done{number, {}, {}, {}, true};
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) done.begins[tier] = spools_[tier].size();
  Training training;
  bool known = false;
  if (store_) {
    VOLUTE_ASSIGN(known, recall(done, training));
  }
  if (!known) {
    const std::size_t firstOutcome = outcomes_.size();
    VOLUTE_TRY(encodeUnit(plan_.unit(number), way, done, training));
    if (store_)
      VOLUTE_TRY(keep(done, training, firstOutcome));
  }
  training_.add(training);
  done_.push_back(std::move(done));
  return {};
}

// Modes, sums of layers, segments, and what was learnt; contexts that saw nothing are left out.
Status Compressor::keep(const DoneUnit& done, const Training& training,
                        std::size_t firstOutcome) {
  const auto all = allBlockModes();
  const UnitPlan::Unit unit = plan_.unit(done.unit);
  ByteWriter record;
  for (std::size_t i = 0; i < plan_.blocks(unit); ++i) {
    const auto& mode = modes_[plan_.firstBlock(unit) + i];
    record.u8(static_cast<std::uint8_t>(mode ? std::ranges::find(all, *mode) - all.begin() + 1 : 0));
  }
  for (std::size_t i = firstOutcome; i < outcomes_.size(); ++i) {
    record.u64(outcomes_[i].layer);
    record.f64(outcomes_[i].outcome.squaredError);
    record.f64(outcomes_[i].outcome.maxError);
  }
  for (const auto& [size, crc] : done.segments) {
    record.u32(size);
    record.u32(crc);
  }
  for (const std::int64_t number :
       {training.oneSum, training.oneCount, training.moreSum, training.moreCount})
    record.zigzag(number);
  const auto& seen = training.counts.seen;
  for (std::size_t at = 0, before = 0; at < seen.size(); ++at) {
    if (seen[at][0] == 0 && seen[at][1] == 0)
      continue;
    record.varint(at - before);
    record.varint(seen[at][0]);
    record.varint(seen[at][1]);
    before = at;
  }
  std::vector<std::byte> bytes;
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) {
    const std::size_t before = bytes.size();
    bytes.resize(before + done.sizes[tier]);
    VOLUTE_TRY(spools_[tier].read(done.begins[tier], std::span(bytes).subspan(before)));
  }
  return store_->store(way_, done.unit, record.view(), bytes);
}

// False when there is nothing of use. Bytes may be missing: they are dropped when the next way
// begins.
Result<bool> Compressor::recall(DoneUnit& done, Training& training) {
  const auto record = store_->record(way_, done.unit);
  if (!record)
    return false;
  const auto bytes = store_->bytes(way_, done.unit).value_or(std::vector<std::byte>());
  const auto all = allBlockModes();
  const UnitPlan::Unit unit = plan_.unit(done.unit);
  const std::size_t blocks = plan_.blocks(unit), tiers = spools_.size();
  ByteReader in(*record);
  std::vector<std::optional<BlockMode>> modes(blocks);
  for (auto& mode : modes) {
    const unsigned number = in.u8();
    if (number > all.size())
      return false;
    mode = number == 0 ? std::nullopt : std::optional(all[number - 1]);
  }
  std::vector<LayerOutcome> outcomes(static_cast<std::size_t>(unit.endLayer - unit.firstLayer));
  for (LayerOutcome& layer : outcomes) {
    layer.layer = in.u64();
    layer.outcome.squaredError = in.f64();
    layer.outcome.maxError = in.f64();
  }
  std::array<std::uint64_t, kWaveletTiers.size()> sizes{};
  for (std::size_t i = 0; i < blocks * tiers; ++i) {
    const std::uint32_t size = in.u32();
    done.segments.emplace_back(size, in.u32());
    sizes[i % tiers] += size;
  }
  for (std::int64_t* number :
       {&training.oneSum, &training.oneCount, &training.moreSum, &training.moreCount})
    *number = in.zigzag();
  for (std::size_t at = 0; in.remaining() > 0;) {
    at += in.varint();
    if (at >= training.counts.seen.size())
      return false;
    training.counts.seen[at] = {static_cast<std::uint32_t>(in.varint()),
                                static_cast<std::uint32_t>(in.varint())};
  }
  std::uint64_t total = 0;
  for (const std::uint64_t size : sizes) total += size;
  const bool whole = bytes.size() == total;
  if (!in.ok() || (!whole && !bytes.empty())) {
    done.segments.clear();
    training = {};
    return false;
  }
  done.hasBytes = whole;
  if (whole) {
    std::span<const std::byte> left = bytes;
    for (std::size_t tier = 0; tier < tiers; ++tier) {
      done.sizes[tier] = sizes[tier];
      VOLUTE_TRY(spools_[tier].write(left.first(sizes[tier])));
      left = left.subspan(sizes[tier]);
    }
  }
  std::ranges::copy(modes, modes_.begin() + static_cast<std::ptrdiff_t>(plan_.firstBlock(unit)));
  outcomes_.insert(outcomes_.end(), outcomes.begin(), outcomes.end());
  return true;
}

// What decides about the result: the values, and what is asked for.
Status Compressor::openStore() {
  if (options_.work.empty())
    return {};
  VOLUTE_TRY(team_.sum(std::span(&content_, 1)));
  ByteWriter all;
  all.string(head_.header.writtenBy);
  all.u64(content_);
  for (const int number :
       {info_.frames, info_.z, info_.y, info_.x, info_.channels, options_.fast ? 1 : 0,
        static_cast<int>(options_.target.kind), static_cast<int>(plan_.unitsARow())})
    all.u32(static_cast<std::uint32_t>(number));
  all.f64(goal_);
  all.string(options_.wavelet);
  all.string(options_.mode ? shortName(*options_.mode) : "");
  ContentHash key;
  key.add(all.view());
  VOLUTE_ASSIGN(store_, UnitStore::open(options_.work, key.digits()));
  return {};
}

// Sums in the order of layers are the same on all ranks, and for any number of them.
Status Compressor::shareOutcomes() {
  VOLUTE_ASSIGN(auto all, gatherValues(team_, std::span<const LayerOutcome>(outcomes_)));
  std::ranges::sort(all, {}, &LayerOutcome::layer);
  outcome_ = {};
  for (const LayerOutcome& layer : all) {
    outcome_.squaredError += layer.outcome.squaredError;
    outcome_.maxError = std::max(outcome_.maxError, layer.outcome.maxError);
  }
  return {};
}

Status Compressor::shareTraining() {
  auto& seen = training_.counts.seen;
  std::vector<std::uint64_t> numbers;
  for (const auto& counts : seen) numbers.insert(numbers.end(), counts.begin(), counts.end());
  for (const std::int64_t number :
       {training_.oneSum, training_.oneCount, training_.moreSum, training_.moreCount})
    numbers.push_back(static_cast<std::uint64_t>(number));
  VOLUTE_TRY(team_.sum(numbers));
  auto number = numbers.begin();
  for (auto& counts : seen) {
    for (std::uint32_t& count : counts) count = static_cast<std::uint32_t>(*number++);
  }
  for (std::int64_t* sum :
       {&training_.oneSum, &training_.oneCount, &training_.moreSum, &training_.moreCount})
    *sum = static_cast<std::int64_t>(*number++);
  return {};
}

Status Compressor::shareModes() {
  if (team_.size() == 1)
    return {};
  const auto all = allBlockModes();
  ByteWriter own;
  for (const DoneUnit& done : done_) {
    const UnitPlan::Unit unit = plan_.unit(done.unit);
    own.u64(static_cast<std::uint64_t>(done.unit));
    for (std::size_t i = 0; i < plan_.blocks(unit); ++i) {
      const auto& mode = modes_[plan_.firstBlock(unit) + i];
      own.u8(static_cast<std::uint8_t>(
          mode ? std::ranges::find(all, *mode) - all.begin() + 1 : 0));
    }
  }
  VOLUTE_ASSIGN(const auto ranks, team_.gatherAll(own.view()));
  for (const auto& bytes : ranks) {
    for (ByteReader in(bytes); in.remaining() > 0;) {
      const UnitPlan::Unit unit = plan_.unit(static_cast<std::int64_t>(in.u64()));
      for (std::size_t i = 0; i < plan_.blocks(unit); ++i) {
        const unsigned mode = in.u8();
        modes_[plan_.firstBlock(unit) + i] =
            mode == 0 ? std::nullopt : std::optional(all[mode - 1]);
      }
    }
  }
  return {};
}

void Compressor::takeSegments(const DoneUnit& done) {
  const std::size_t count = row_.grid().count();
  const std::size_t first = plan_.firstBlock(plan_.unit(done.unit));
  const std::size_t tiers = spools_.size();
  for (std::size_t i = 0; i < done.segments.size(); ++i) {
    const auto [size, crc] = done.segments[i];
    head_.segments[i % tiers * count + first + i / tiers] = {0, size, crc};
  }
}

// Rank 0 gets sizes and checksums of all, makes the head of them, and tells how long the file is.
Status Compressor::shareSegments() {
  if (team_.leads()) {
    head_.segments.assign(row_.grid().count() * spools_.size(), SegmentEntry{});
    ranks_.assign(static_cast<std::size_t>(plan_.count()), 0);
    for (const DoneUnit& done : done_) takeSegments(done);
    for (int rank = 1; rank < team_.size(); ++rank) {
      VOLUTE_ASSIGN(const auto bytes, team_.collect(rank));
      for (ByteReader in(bytes); in.remaining() > 0;) {
        DoneUnit done{static_cast<std::int64_t>(in.u64()), {}, {}, {}, true};
        ranks_[static_cast<std::size_t>(done.unit)] = rank;
        for (std::uint64_t left = in.u64(); left > 0; --left) {
          const std::uint32_t size = in.u32();
          done.segments.emplace_back(size, in.u32());
        }
        takeSegments(done);
      }
    }
    headBytes_ = writeHead(head_);
    fileBytes_ = head_.fileBytes;
  } else {
    ByteWriter out;
    for (const DoneUnit& done : done_) {
      out.u64(static_cast<std::uint64_t>(done.unit));
      out.u64(done.segments.size());
      for (const auto& [size, crc] : done.segments) {
        out.u32(size);
        out.u32(crc);
      }
    }
    VOLUTE_TRY(team_.post(team_.rank(), out.take(), std::numeric_limits<std::uint64_t>::max()));
  }
  VOLUTE_ASSIGN(fileBytes_, team_.broadcast(fileBytes_));
  return {};
}

Status Compressor::encodeAll(double proposed, Way way) {
  constexpr int kRowsToLearnFrom = 4;
  VOLUTE_ASSIGN(const double step, team_.broadcast(proposed));
  parameters_.step = step / parameters_.unit();
  // From the first try on the parameters stay, so that what a step gives can be had again.
  if (way == Way::kChoose || (way == Way::kEncode && tries_ == 0))
    training_.apply(parameters_);
  if (way == Way::kChoose)
    chosenStep_ = parameters_.step;
  training_ = {};
  head_.parameters = writeParameters(parameters_, info_.channels);
  VOLUTE_ASSIGN(head_.decoder, openWaveletDecoder(head_.parameters, stream()));
  if (store_) {
    for (const DoneUnit& done : done_) store_->dropBytes(way_, done.unit);
  }
  ++way_;
  done_.clear();
  outcomes_.clear();
  for (Spool& spool : spools_) VOLUTE_TRY(spool.clear());
  const int rows = row_.rows();
  const int count = way == Way::kLearn ? std::min(rows, kRowsToLearnFrom) : rows;
  tries_ += way == Way::kEncode ? 1 : 0;
  const std::string stage = way == Way::kLearn    ? "learning"
                            : way == Way::kChoose ? chosenBefore_ ? "choosing modes again"
                                                                  : "choosing modes"
                            : tries_ == 1         ? "compressing"
                                                  : fmt::format("compressing, try {}", tries_);
  const std::int64_t unitsARow = plan_.unitsARow();
  VOLUTE_TRY(team_.forUnits(stage, count * unitsARow, progress_, [&](std::int64_t i) {
    const std::int64_t row = i / unitsARow * rows / count;
    return doUnit(row * unitsARow + i % unitsARow, way);
  }));
  chosenBefore_ = chosenBefore_ || way == Way::kChoose;
  VOLUTE_TRY(shareOutcomes());
  const double range = head_.header.valueMax - head_.header.valueMin;
  const double rms = std::sqrt(outcome_.squaredError / static_cast<double>(info_.values()));
  relativeRms_ = range > 0 ? rms / range : rms;
  head_.header.reachedRms =
      relativeRms_ + (range > 0 ? options_.sourceRms / range : options_.sourceRms);
  head_.header.reachedMaxError = outcome_.maxError + options_.sourceMaxError;
  if (way == Way::kChoose)
    VOLUTE_TRY(shareModes());
  if (way != Way::kEncode)
    VOLUTE_TRY(shareTraining());
  if (way == Way::kEncode || isSize(options_.target.kind))
    VOLUTE_TRY(shareSegments());
  return {};
}

// Values that are rounded to 16-bit floats are off by 2^-11 of themselves at most. Where they were
// such floats, that is no further than they were off before: one half of the goal will always do.
void Compressor::leaveRoomForHalves() {
  const double greatest =
      std::max(std::abs(head_.header.valueMin), std::abs(head_.header.valueMax));
  const double range = head_.header.valueMax - head_.header.valueMin;
  const double rounding = std::ldexp(greatest, -11);
  const auto left = [&](double rms) {
    const double relative = range > 0 ? rounding / range : 0;
    return std::sqrt(std::max(rms * rms / 4, rms * rms - relative * relative));
  };
  if (options_.target.kind == Kind::kRms)
    goal_ = left(goal_);
  else if (options_.target.kind == Kind::kPsnr)
    goal_ = -20 * std::log10(left(std::pow(10, -goal_ / 20)));
  else if (options_.target.kind == Kind::kMaxError)
    goal_ = parameters_.maxError = std::max(goal_ / 2, goal_ - rounding);
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
  const double value = goal_;
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
    return kMaxErrorSteps * goal_;
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
      return static_cast<double>(fileBytes_);
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
                fileBytes_, info_.rawBytes());
  }
  return fail(ErrorCode::kInvalidArgument,
              "{}: {} = {} cannot be reached: the rounding of float32 leaves a relative RMS of "
              "{:.3g} and a maximum error of {:.3g}; ask for more",
              target_.string(), nameOf(options_.target.kind), options_.target.value, relativeRms_,
              outcome_.maxError);
}

// The segments of all ranks, tier by tier and in each unit by unit.
Status Compressor::writeSegments(OutputFile& file) {
  constexpr std::uint64_t kPiece = std::uint64_t{1} << 20;
  std::vector<std::byte> piece;
  const std::int64_t units = plan_.count();
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) {
    auto own = done_.begin();
    for (std::int64_t unit = 0; unit < units; ++unit) {
      VOLUTE_TRY(checkCancelled());
      if (ranks_[static_cast<std::size_t>(unit)] != 0) {
        const auto item = static_cast<std::int64_t>(tier) * units + unit;
        VOLUTE_ASSIGN(const auto bytes, team_.collect(item));
        VOLUTE_TRY(file.write(bytes));
        continue;
      }
      for (std::uint64_t at = 0; at < own->sizes[tier]; at += piece.size()) {
        piece.resize(std::min(kPiece, own->sizes[tier] - at));
        VOLUTE_TRY(spools_[tier].read(own->begins[tier] + at, piece));
        VOLUTE_TRY(file.write(piece));
      }
      ++own;
    }
  }
  return {};
}

Status Compressor::sendSegments() {
  constexpr std::uint64_t kMostPending = std::uint64_t{64} << 20;
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) {
    for (const DoneUnit& done : done_) {
      std::vector<std::byte> bytes(done.sizes[tier]);
      VOLUTE_TRY(spools_[tier].read(done.begins[tier], bytes));
      const auto item = static_cast<std::int64_t>(tier) * plan_.count() + done.unit;
      VOLUTE_TRY(team_.post(item, std::move(bytes), kMostPending));
    }
  }
  return {};
}

// What an earlier run kept may lack the bytes: a disk lost them.
Status Compressor::completeUnits() {
  for (DoneUnit& done : done_) {
    if (done.hasBytes)
      continue;
    DoneUnit again{done.unit, {}, {}, {}, true};
    for (std::size_t tier = 0; tier < spools_.size(); ++tier)
      again.begins[tier] = spools_[tier].size();
    Training training;
    VOLUTE_TRY(encodeUnit(plan_.unit(done.unit), Way::kEncode, again, training));
    done = std::move(again);
  }
  return {};
}

Result<CompressReport> Compressor::write() {
  VOLUTE_TRY(team_.agree(completeUnits()));
  const auto writeAll = [&]() -> Status {
    VOLUTE_ASSIGN(auto file, OutputFile::create(target_));
    VOLUTE_TRY(file.write(headBytes_));
    VOLUTE_TRY(writeSegments(file));
    return file.commit();
  };
  VOLUTE_TRY(team_.agree(team_.leads() ? writeAll() : sendSegments()));
  if (store_ && team_.leads())
    store_->remove();
  CompressReport report;
  report.rawBytes = info_.rawBytes();
  report.fileBytes = fileBytes_;
  report.relativeRms = relativeRms_;
  report.maxError = outcome_.maxError;
  report.valueMin = head_.header.valueMin;
  report.valueMax = head_.header.valueMax;
  report.blocks = row_.grid().count();
  return report;
}

Status Compressor::searchStep(double first) {
  StepSearch search(problem(), first);
  for (bool found = false; !found;) {
    VOLUTE_TRY(encodeAll(search.step(), Way::kEncode));
    search.tell(outcomeOfTry());
    VOLUTE_ASSIGN(const bool failed, team_.broadcast(search.failed()));
    if (failed)
      return unreachable();
    VOLUTE_ASSIGN(found, team_.broadcast(search.found()));
  }
  return {};
}

// Corrections keep the maximum error whatever the step: the one that makes the smallest file, from
// the middle outwards.
Status Compressor::searchSmallest() {
  const double target = goal_;
  double best = 0;
  std::uint64_t least = 0;
  for (const double factor : {1.5, 2.1, 3.0, 1.05, 0.75}) {
    if ((factor == 3.0 && best < 2 * target) || (factor == 1.05 && best > 2 * target) ||
        (factor == 0.75 && best > 1.2 * target))
      continue;
    VOLUTE_TRY(encodeAll(factor * target, Way::kEncode));
    if (least == 0 || fileBytes_ < least) {
      least = fileBytes_;
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
  if (options_.halves)
    leaveRoomForHalves();
  VOLUTE_TRY(team_.agree(openStore()));
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
  VOLUTE_ASSIGN(const double better, team_.broadcast(within(betterStep(wanted))));
  VOLUTE_ASSIGN(step, team_.broadcast(step));
  if (!options_.fast || std::max(better / step, step / better) > 1.5) {
    VOLUTE_TRY(encodeAll(better, Way::kChoose));
  }
  VOLUTE_TRY(searchStep(within(betterStep(wanted))));
  return write();
}

tl::unexpected<Error> tooLarge(const VolumeInfo& info, std::uint64_t needed,
                               const CompressOptions& options) {
  return fail(ErrorCode::kTooLarge,
              "{} frames of {} x {} x {} voxels, which are compressed together, need {} MiB of "
              "memory, more than the {} MiB "
              "allowed; raise --max-memory",
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
    return BlockRow::bytesNeeded(info, layers) +
           std::min<std::uint64_t>(kBatch, blocks) * kBatchBytesAValue * grid.values(0);
  };
  int layers = all;
  if (source.readsLayers()) {
    const auto aLayer = static_cast<std::size_t>(grid.counts()[2]) * grid.counts()[3];
    // The same units for any number of ranks, where those of an earlier run may be there.
    if (team.size() > 1 || !options.work.empty())
      layers = static_cast<int>(std::min<std::size_t>(all, (kBatch + aLayer - 1) / aLayer));
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
  VOLUTE_ASSIGN(const auto all, gatherValues(team, std::span(&digest, 1)));
  const auto other = std::ranges::find_if(all, [&](std::uint32_t one) { return one != all[0]; });
  if (other == all.end())
    return {};
  return fail(ErrorCode::kInvalidData,
              "rank {} reads another sequence under this name than rank 0: expected the same size, "
              "frames and times everywhere",
              other - all.begin());
}

}  // namespace

Result<CompressReport> compress(FrameSource& source, const std::filesystem::path& target,
                                const CompressOptions& options, Progress& progress, Team& team) {
  const auto start = std::chrono::steady_clock::now();
  VOLUTE_TRY(checkOptions(options));
  VOLUTE_TRY(source.info().validate("the input"));
  VOLUTE_ASSIGN(const int layers, layersAUnit(source, options, team));
  VOLUTE_TRY(checkSameInput(source.info(), team));
  Compressor compressor(source, target, options, layers, progress, team);
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
