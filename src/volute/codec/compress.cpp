// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/compress.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <mutex>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "volute/base/checksum.hpp"
#include "volute/base/content_hash.hpp"
#include "volute/base/gather_values.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/version.hpp"
#include "volute/codec/block_row.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/codec/coefficient_coder.hpp"
#include "volute/codec/compression_goal.hpp"
#include "volute/codec/container.hpp"
#include "volute/codec/effort_plan.hpp"
#include "volute/codec/encoded_units.hpp"
#include "volute/codec/parallel_try.hpp"
#include "volute/codec/step_search.hpp"
#include "volute/codec/unit_plan.hpp"
#include "volute/codec/unit_store.hpp"
#include "volute/codec/written_file.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/grid/value_histogram.hpp"

namespace volute {
namespace {

// Blocks encoded before their bytes go to the spools; bounds the memory of a row of many blocks.
constexpr std::size_t kBatch = 64;
// Buffers of a batch, for each value of a block: a generous bound of what encode() and decode()
// hold.
constexpr std::uint64_t kBatchBytesAValue = 32;
// A step this much finer than the one that modes were chosen for asks again about blocks left out.
constexpr double kFinerStep = 0.75;
// How the step goes with the error, where nothing tells it.
constexpr double kErrorPower = 1.2;

// The first 16 bits of a value tell it to 1/128.

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

std::vector<BlockMode> modesToTry(const CompressOptions& options) {
  using enum EffortPlan::Modes;
  if (options.mode)
    return {*options.mode};
  const EffortPlan::Modes which = planOf(options.effort).modes;
  const auto wavelet = waveletByName(options.wavelet);
  std::vector<BlockMode> modes;
  for (const BlockMode& mode : allBlockModes()) {
    if (wavelet && mode.wavelet != *wavelet)
      continue;
    const bool usual = mode.timeLevels == 0 || mode.timeLevels == 4;
    const bool known = wavelet || mode.wavelet == Wavelet::kCdf53 ||
                       (which == kUsual && mode.wavelet == Wavelet::kCdf97);
    if (which == kAll || (usual && known))
      modes.push_back(mode);
  }
  return modes;
}

// A block with less in it than this share of its voxels has a support in any mode worth having.
constexpr double kSparseBlock = 0.5;
// Steps less apart than this leave the modes of such blocks as they are.
constexpr double kSameModes = 1.5;

// Of a grid with more blocks than this to a row a part of them tells what all are like.
constexpr std::size_t kManyBlocks = 2048;
// Tables of symbols are worth their bytes, and learn enough, from so many blocks on.
constexpr std::uint64_t kBlocksForSymbols = 32;
// At least so many blocks tell it.
constexpr std::uint64_t kFewBlocks = 96;

// How much shorter blocks may add to a file where nothing says what is read.
constexpr double kLittle = 0.005;
// Bytes of a block beside its coefficients: its place in the index, checksums, ends of strings.
constexpr double kBytesABlock = 32;

double shareOf(std::span<const VoxelState> states) {
  const auto empty = std::ranges::count(states, VoxelState::kEmpty);
  return 1 - static_cast<double>(empty) / static_cast<double>(states.size());
}

// Where the search among many modes begins: none, where all of few are tried. `before`: the mode
// that the block had at another step.
std::vector<BlockMode> modesToBeginWith(const CompressOptions& options,
                                        const std::optional<BlockMode>& before, bool sparse) {
  if (options.mode || planOf(options.effort).modes != EffortPlan::Modes::kAll)
    return {};
  const auto only = waveletByName(options.wavelet);
  const auto mode = [&](bool shaped, Wavelet wavelet, int timeLevels) {
    return BlockMode{shaped, only.value_or(wavelet), timeLevels};
  };
  // With both, fine steps and coarse ones are served, that lead to other modes.
  if (sparse)
    return {before.value_or(mode(true, Wavelet::kCdf53, 0)), mode(true, Wavelet::kCdf53, 2)};
  if (before)
    return {*before, mode(true, Wavelet::kCdf97, 0)};
  return {mode(false, Wavelet::kCdf53, 4), mode(false, Wavelet::kCdf53, 0),
          mode(true, Wavelet::kCdf53, 0), mode(true, Wavelet::kCdf53, 4),
          mode(false, Wavelet::kHaar, 0)};
}

/// One call of compress(). Goes through the blocks several times: to survey the values; to learn
/// from some of them what quantised coefficients are like, and which step meets the target; to
/// choose the mode of each block; and to encode them all, until the step does. All ranks of a team
/// go through them together; after each way they share what they found, and rank 0's decisions are
/// those of all.
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
        layersAUnit_(layersAUnit),
        plan_(row_.grid(), layersAUnit),
        goal_(options.target, info_),
        modes_(static_cast<std::size_t>(plan_.count())),
        someModes_(modes_.size()),
        sampled_(row_.grid().rowCount() > kManyBlocks),
        effort_(planOf(options.effort, sampled_)),
        units_(plan_, team) {
    head_.info = info_;
    // A field that states no topology, judged over all of its voxels, pays for none.
    const bool overAll =
        options.target.kind == Kind::kRmsOverAll || options.target.kind == Kind::kPsnr;
    parameters_.extended = true;
    parameters_.means = true;
    parameters_.sparse = source.hasTopology() || !overAll;
    parameters_.offset = offsetOf(source);
    head_.header.codec = static_cast<int>(kSparseCodec);
    units_.setChecked(true);
    head_.header.writtenBy = "volute " VOLUTE_VERSION;
    head_.header.provenance = options.provenance;
    head_.header.targetKind = nameOf(options.target.kind);
    head_.header.targetValue = options.target.value;
  }

  Result<CompressReport> run();

  void setLook(const std::optional<LookFigures>& look) { head_.look = look; }

 private:
  struct LayerMoments {
    std::uint64_t layer = 0;
    ColorMoments moments;
  };

  // One way through blocks: all of them, or for kLearn and kTry those that tell what all are like.
  enum class Way { kLearn, kTry, kChoose, kEncode };

  static bool isOfSome(Way way) { return way == Way::kLearn || way == Way::kTry; }

  static bool choosesModes(Way way) { return way == Way::kTry || way == Way::kChoose; }

  Status survey();
  Status surveyUnit(std::int64_t number);
  Status shareSurvey();
  Status shareTiles();
  void settleRange();
  void bend(double strongest);
  double roundingToHalves() const;
  std::vector<std::uint64_t> sampleOf(std::span<const std::uint64_t> blocks,
                                      std::uint64_t oneOf) const;
  void cutBy(int frames);
  Status chooseLength();
  Status encodeAll(double step, Way way);
  Status openStore();
  Status doUnit(std::int64_t number, Way way);
  Status encodeUnit(Way way, EncodedUnits::Unit& done, EncodedUnitRecord& record);
  std::vector<std::optional<BlockMode>>& modesOf(Way way, std::int64_t unit, std::size_t blocks);
  Status keep(Way way, const EncodedUnits::Unit& done, EncodedUnitRecord& record);
  Result<std::optional<EncodedUnitRecord>> recall(Way way, EncodedUnits::Unit& done);
  Status shareErrors();
  Status shareTraining();
  Status shareDone(Way way);
  Status shareModes(Way way);
  Status shareSegments();
  std::optional<BlockMode> chooseMode(const BlockContent& block, const BlockEncoder& encoder,
                                      const std::optional<BlockMode>& before) const;
  std::size_t findErrors(std::span<const float> values, std::span<const float> decoded,
                         std::span<const VoxelState> states, const BlockShape& shape,
                         CodingError& errors) const;
  Result<EncodedBlock> encodeBlock(std::size_t block, std::optional<BlockMode>& mode, Way way,
                                   Training& training);
  std::vector<std::int64_t> meansOf(std::span<const float> values) const;
  Status checkCancelled() const;
  Status searchStep(double first);
  Status searchSmallest();
  Result<double> stepFromSome(double first);
  bool nearEnough() const;

  /// An RMS as a part of the range of all voxels, and of the support's.
  double overAll(double rms) const {
    return CompressionGoal::relative(rms, head_.header.valueMin, head_.header.valueMax);
  }

  double overSupport(double rms) const {
    return CompressionGoal::relative(rms, support_.low, support_.high);
  }

  void noteErrors();
  std::vector<FaintFrame> faintFrames() const;
  double betterStep() const;
  double outcomeOfTry() const;
  tl::unexpected<Error> unreachable() const;
  Result<CompressReport> write();
  Status completeUnits();

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
  int layersAUnit_;
  UnitPlan plan_;
  CompressionGoal goal_;
  FileHead head_;
  std::vector<std::byte> headBytes_;
  WaveletParameters parameters_;
  Training training_;                                             // of the last way through
  std::vector<std::vector<std::optional<BlockMode>>> modes_;      // of each unit, of its blocks
  std::vector<std::vector<std::optional<BlockMode>>> someModes_;  // the same, of some blocks
  BlockMode usualMode_;
  std::vector<SupportFacts> facts_;    // of each frame
  ValueHistogram histogram_;           // of the support's values
  std::vector<LayerMoments> moments_;  // of the units that this rank surveyed
  BlockRow::InactiveValue inactive_;
  SupportError support_;
  double supportVoxels_ = 0;  // of all frames
  bool sampled_ = false;      // so many blocks to a row that a part of them is surveyed
  EffortPlan effort_;
  std::uint64_t blocks_ = 0;                                           // that hold something
  std::array<std::uint64_t, LengthCosts::kFrames.size()> blocksBy_{};  // the same, by their frames
  std::uint64_t oneOf_ = 1;     // of so many one tells what all are like
  double doneShare_ = 1;        // of the support, that the last way went through
  double power_ = kErrorPower;  // how the step goes with the error
  bool chosenBefore_ = false;   // modes_ are those of another step, else a guess
  double chosenStep_ = 0;       // at which modes_ were chosen
  bool stepsAlike_ = false;     // the same and that before
  QuantisationModel model_;
  std::optional<UnitStore> store_;  // of finished units, where that is asked for
  std::uint64_t content_ = 0;       // a digest of all values, for it
  int way_ = -1;                    // how many ways through the units were begun before
  EncodedUnits units_;              // of the last way through
  std::vector<LayerError> layers_;  // the same, of this rank
  std::uint64_t fileBytes_ = 0;     // as far as it was asked for
  CodingError error_;
  std::vector<double> frameSquares_;  // the squares of it, frame by frame
  double relativeRms_ = 0;            // of the last way through all blocks
  double rounding_ = 0;               // of the values, roundingOf() the source
  int tries_ = 0;
};

Status Compressor::checkCancelled() const {
  if (progress_.cancelled())
    return fail(ErrorCode::kCancelled, "stopped: {} was not written", target_.string());
  return {};
}

// Adds the coefficients of a block in a middling transform, each at the size it has in the values.
void addCoefficients(std::span<const float> values, std::span<const VoxelState> states,
                     const BlockShape& shape, QuantisationModel& model) {
  const AxisLevels levels = blockLevels(shape.extents, 4);
  std::vector<float> plane(shape.voxels());
  std::vector<std::uint8_t> support(shape.voxels());
  for (std::size_t i = 0; i < support.size(); ++i)
    support[i] = states[i] == VoxelState::kEmpty ? 0 : 1;
  if (std::ranges::find(support, 0) == support.end())
    support.clear();
  for (int c = 0; c < shape.channels; ++c) {
    for (std::size_t i = 0; i < plane.size(); ++i) {
      plane[i] =
          states[i] == VoxelState::kEmpty
              ? 0
              : values[i * static_cast<std::size_t>(shape.channels) + static_cast<std::size_t>(c)];
    }
    shapeForward(plane, support, shape.extents, Wavelet::kCdf53, levels);
    for (int stride = 0; stride < deepest(levels); ++stride) {
      const CellLevel level(shape.extents, levels, stride, Wavelet::kCdf53);
      CellMemory memory;
      codeLevel(
          level, support, nullptr, nullptr, memory,
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

// The blocks that tell what all of them are like: the first of each layer, and some others. Which,
// depends on their numbers alone.
std::vector<std::uint64_t> Compressor::sampleOf(std::span<const std::uint64_t> blocks,
                                                std::uint64_t oneOf) const {
  std::vector<std::uint64_t> sample;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const std::uint64_t layer = blocks[i] / plan_.blocksALayer();
    const bool first = i == 0 || layer != blocks[i - 1] / plan_.blocksALayer();
    const std::uint64_t mixed = (blocks[i] * 0x9E3779B97F4A7C15ull) >> 32;
    if (first || mixed % oneOf == 0)
      sample.push_back(blocks[i]);
  }
  return sample;
}

Status Compressor::surveyUnit(std::int64_t number) {
  VOLUTE_TRY(checkCancelled());
  const BlockGrid& grid = row_.grid();
  const UnitPlan::Unit unit = plan_.unit(number);
  VOLUTE_TRY(row_.load(unit.row, unit.firstLayer, unit.endLayer));
  const auto firstFrame = static_cast<std::size_t>(unit.row * grid.frames());
  for (std::size_t i = 0; i < row_.facts().size(); ++i) facts_[firstFrame + i].add(row_.facts()[i]);
  row_.visitValues([&](float value, std::uint64_t count) { histogram_.add(value, count); });
  inactive_.add(row_.inactiveValue());
  for (std::size_t i = 0; i < row_.facts().size(); ++i) {
    const auto tiles = row_.tilesOf(static_cast<int>(i));
    head_.tiles[firstFrame + i].insert(head_.tiles[firstFrame + i].end(), tiles.begin(),
                                       tiles.end());
  }
  // Moments are added up block by block, so that they come out the same.
  const std::uint64_t oneOf = sampled_ ? 4 : 1;
  const std::vector<std::uint64_t> sample = sampleOf(row_.occupied(), oneOf);
  // Sizes of coefficients need fewer blocks than colours do.
  const std::uint64_t oneOfModel = row_.grid().count() > 2 * kFewBlocks ? 4 : 1;
  for (std::size_t i = 0; i < blocksBy_.size(); ++i)
    blocksBy_[i] += row_.occupiedBy(LengthCosts::kFrames[i]);
  // A digest is of all of them.
  const auto occupied =
      options_.work.empty() ? std::span<const std::uint64_t>(sample) : row_.occupied();
  std::vector<ColorMoments> moments(occupied.size());
  std::mutex mutex;
  parallelRanges(occupied.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<float> values;
    BlockStates states;
    QuantisationModel model;
    std::uint64_t content = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint64_t block = occupied[i];
      values.resize(grid.values(block));
      row_.cut(block, values, states);
      if (std::ranges::binary_search(sample, block)) {
        moments[i].add(values, info_.channels);
        const bool first =
            i == 0 || occupied[i - 1] / plan_.blocksALayer() != block / plan_.blocksALayer();
        if (oneOf == oneOfModel || first || block % oneOfModel == 0)
          addCoefficients(values, states, shapeOf(grid, block), model);
      }
      if (!options_.work.empty())
        content += (2 * block + 1) * (crc32(std::as_bytes(std::span(values))) +
                                      3 * std::uint64_t{crc32(std::as_bytes(std::span(states)))});
    }
    const std::lock_guard lock(mutex);
    for (std::uint64_t i = 0; i < oneOfModel; ++i) model_.merge(model);
    content_ += content;
  });
  for (std::size_t i = 0; i < occupied.size(); ++i) {
    const std::uint64_t layer = occupied[i] / plan_.blocksALayer();
    if (moments_.empty() || moments_.back().layer != layer)
      moments_.push_back({layer, {}});
    moments_.back().moments.add(moments[i]);
  }
  return {};
}

Status Compressor::shareSurvey() {
  VOLUTE_TRY(team_.sum(model_.counts()));
  VOLUTE_TRY(team_.sum(blocksBy_));
  cutBy(options_.access == Access::kFrame ? LengthCosts::kFrames.back() : BlockGrid::kSide);
  parameters_.bySymbols = blocks_ >= kBlocksForSymbols;
  if (parameters_.bySymbols) {
    parameters_.symbols = symbolsOfTable({});
    parameters_.symbolPrices = pricesOf(parameters_.symbols);
  }
  VOLUTE_TRY(team_.sum(histogram_.counts()));
  VOLUTE_ASSIGN(const auto facts, gatherValues(team_, std::span<const SupportFacts>(facts_)));
  const std::size_t frames = facts_.size();
  for (std::size_t i = 0; i < frames; ++i) facts_[i] = {};
  for (std::size_t i = 0; i < facts.size(); ++i) facts_[i % frames].add(facts[i]);

  struct Known {
    BlockRow::InactiveValue inactive;
    std::array<float, 3> background{};
    bool loaded = false;
    double rounding = 0;
  };

  const Known own{inactive_, row_.background(), !row_.facts().empty(), row_.rounding()};
  VOLUTE_ASSIGN(const auto known, gatherValues(team_, std::span<const Known>(&own, 1)));
  inactive_ = {};
  for (const Known& one : known) {
    inactive_.add(one.inactive);
    rounding_ = std::max(rounding_, one.rounding);
    if (one.loaded)
      parameters_.background = one.background;
  }
  if (inactive_.any && !inactive_.several)
    parameters_.inactive = inactive_.value;
  if (info_.channels == 3) {
    VOLUTE_ASSIGN(moments_, gatherValues(team_, std::span<const LayerMoments>(moments_)));
    std::ranges::sort(moments_, {}, &LayerMoments::layer);
    ColorMoments all;
    for (const LayerMoments& part : moments_) all.add(part.moments);
    VOLUTE_ASSIGN(parameters_.color, team_.broadcast(ColorTransform::of(all)));
  }
  return shareTiles();
}

// From now on blocks have so many frames.
void Compressor::cutBy(int frames) {
  // Fewer frames than a block has make one row in any case.
  const int own = info_.frames <= frames ? BlockGrid::kSide : frames;
  const auto& all = LengthCosts::kFrames;
  blocks_ = blocksBy_[static_cast<std::size_t>(std::ranges::find(all, own) - all.begin())];
  oneOf_ =
      std::clamp<std::uint64_t>(blocks_ / kFewBlocks, 1, static_cast<std::uint64_t>(effort_.oneOf));
  if (own == parameters_.blockFrames)
    return;
  parameters_.blockFrames = own;
  row_.cutBy(own);
  plan_ = UnitPlan(row_.grid(), layersAUnit_);
  modes_.assign(static_cast<std::size_t>(plan_.count()), {});
  someModes_.assign(modes_.size(), {});
}

// As few frames as cost little, after a first way through some blocks.
Status Compressor::chooseLength() {
  if (options_.access != Access::kAny)
    return {};
  const LengthCosts& lengths = training_.lengths;
  int chosen = BlockGrid::kSide;
  for (std::size_t i = 1; i < lengths.costs.size() && lengths.bits > 0; ++i) {
    const double more = static_cast<double>(lengths.costs[i] - lengths.costs[0]) / 256;
    const double blocks =
        static_cast<double>(lengths.blocks) *
        (static_cast<double>(blocksBy_[i]) / static_cast<double>(blocksBy_[0]) - 1);
    if (more + 8 * kBytesABlock * blocks <= kLittle * static_cast<double>(lengths.bits))
      chosen = LengthCosts::kFrames[i];
  }
  VOLUTE_ASSIGN(chosen, team_.broadcast(chosen));
  cutBy(chosen);
  return {};
}

// All ranks get the tiles of all.
Status Compressor::shareTiles() {
  if (team_.size() > 1) {
    struct FrameTile {
      std::uint64_t frame = 0;
      Bricks::Tile tile;
    };

    std::vector<FrameTile> own;
    for (std::size_t frame = 0; frame < head_.tiles.size(); ++frame)
      for (const Bricks::Tile& tile : head_.tiles[frame]) own.push_back({frame, tile});
    VOLUTE_ASSIGN(const auto all, gatherValues(team_, std::span<const FrameTile>(own)));
    for (auto& frame : head_.tiles) frame.clear();
    for (const FrameTile& one : all) head_.tiles[one.frame].push_back(one.tile);
  }
  const auto order = [](const Bricks::Tile& a, const Bricks::Tile& b) {
    return std::tie(a.origin[2], a.origin[1], a.origin[0]) <
           std::tie(b.origin[2], b.origin[1], b.origin[0]);
  };
  for (auto& frame : head_.tiles) std::ranges::sort(frame, order);
  return {};
}

// The range of all values, and that of the support, which outliers do not rule.
void Compressor::settleRange() {
  SupportFacts all;
  for (const SupportFacts& frame : facts_) all.add(frame);
  supportVoxels_ = static_cast<double>(all.voxels);
  const double voxels = static_cast<double>(info_.voxels()) * info_.frames;
  support_.share = supportVoxels_ / voxels;
  double least = all.least, most = all.most;
  if (supportVoxels_ < voxels) {
    for (int c = 0; c < info_.channels; ++c) {
      const double background = parameters_.background[static_cast<std::size_t>(c)];
      least = std::min(least, background), most = std::max(most, background);
    }
  }
  head_.header.valueMin = least;
  head_.header.valueMax = most;
  support_.low = all.voxels > 0 ? all.least : least;
  support_.high = all.voxels > 0 ? all.most : least;
  double greatest = std::max(std::abs(least), std::abs(most));
  if (const auto range = histogram_.robustRange(support_.low, support_.high)) {
    const auto [low, high] = *range;
    support_.robust = true;
    support_.low = low;
    support_.high = high;
    parameters_.outlierLow = static_cast<float>(low - (high - low));
    parameters_.outlierHigh = static_cast<float>(high + (high - low));
    greatest = std::max(std::abs(parameters_.outlierLow), std::abs(parameters_.outlierHigh));
    for (const float background : parameters_.background)
      greatest = std::max(greatest, static_cast<double>(std::abs(background)));
  }
  FrameAmounts& amounts = head_.header.amounts;
  std::vector<double> each;
  for (const SupportFacts& frame : facts_) {
    const double strongest = std::min<double>(frame.most, support_.high) + parameters_.offset;
    each.push_back(frame.voxels > 0 ? static_cast<double>(frame.voxels) * std::max(strongest, 0.0)
                                    : 0);
  }
  amounts.most = *std::ranges::max_element(each);
  for (const double one : each) {
    if (amounts.most > 0)
      amounts.shares.push_back(static_cast<std::uint8_t>(std::ceil(255 * (one / amounts.most))));
  }
  if (greatest > 0)
    parameters_.exponent = std::clamp(std::ilogb(greatest) + 1, -126, 127);
  const bool overSupport = options_.target.isOverSupport();
  // Faint and strong mean nothing far from zero.
  if (options_.target.kind == Kind::kLook && parameters_.offset == 0)
    bend(std::max(std::abs(support_.low), std::abs(support_.high)));
  const double spread = overSupport ? supportVoxels_ : voxels;
  const double own = std::max(std::abs(support_.low), std::abs(support_.high));
  goal_.setRange(overSupport ? support_.low : least, overSupport ? support_.high : most, greatest,
                 std::min(own, greatest), spread * info_.channels, least == most);
}

// Values of `strongest` stay what they are, and below kFaint of that a step is of one size.
void Compressor::bend(double strongest) {
  constexpr double kFaint = 0.005 * 0.005;
  if (!(strongest > 1e-25 && strongest < 1e25))
    return;
  const double knee = std::sqrt(kFaint * strongest);
  parameters_.bendScale = (std::sqrt(strongest + knee * knee) - knee) / strongest;
  parameters_.bendOffset = 2 * knee;
}

// The RMS of rounding to 16-bit floats, of the values that errors are taken over.
double Compressor::roundingToHalves() const {
  constexpr int kMinExponent = -14, kBits = 10;  // below, halves are evenly spaced
  double squares = 0;
  const std::vector<std::uint64_t>& counts = histogram_.counts();
  for (std::uint32_t bin = 0; bin < counts.size(); ++bin) {
    const float value = ValueHistogram::leastOf(bin);
    const bool outlier =
        parameters_.sparse && (value < parameters_.outlierLow || value > parameters_.outlierHigh);
    if (counts[bin] == 0 || value == 0 || outlier)
      continue;
    const double spacing = std::ldexp(1.0, std::max(std::ilogb(value), kMinExponent) - kBits);
    squares += static_cast<double>(counts[bin]) * spacing * spacing / 12;
  }
  const double voxels = options_.target.isOverSupport()
                            ? supportVoxels_
                            : static_cast<double>(info_.voxels()) * info_.frames;
  return std::sqrt(squares / std::max(1.0, voxels * info_.channels));
}

Status Compressor::survey() {
  facts_.resize(static_cast<std::size_t>(info_.frames));
  head_.tiles.resize(facts_.size());
  VOLUTE_TRY(team_.forUnits("analysing", plan_.count(), progress_,
                            [&](std::int64_t number) { return surveyUnit(number); }));
  VOLUTE_TRY(shareSurvey());
  settleRange();
  const std::vector<BlockMode> modes = modesToTry(options_);
  const BlockMode usual{false, Wavelet::kCdf53, 4};
  const bool tried = std::ranges::find(modes, usual) != modes.end();
  usualMode_ = tried ? usual : modes.front();
  return {};
}

// The mode of a block at this step.
// @param before  one that it had not far from this step, if there is one
std::optional<BlockMode> Compressor::chooseMode(const BlockContent& block,
                                                const BlockEncoder& encoder,
                                                const std::optional<BlockMode>& before) const {
  const bool sparse = !block.states.empty() && shareOf(block.states) < kSparseBlock;
  if (sparse && before && stepsAlike_)
    return before;
  std::vector<BlockMode> modes = modesToTry(options_);
  if (sparse && !options_.mode)
    std::erase_if(modes, [](const BlockMode& mode) { return !mode.shaped; });
  // Of many blocks 99 in 100 take one of these.
  const auto usual = [](const BlockMode& mode) {
    return mode.timeLevels == 0 || (mode.timeLevels == 4 && mode.wavelet == Wavelet::kCdf53);
  };
  ModeChoice choice{modes, {}, effort_.coded};
  if (sparse && sampled_ && !options_.mode && options_.wavelet == "auto" && choice.coded == 0) {
    std::erase_if(modes, [&](const BlockMode& mode) {
      return !usual(mode) || mode.wavelet == Wavelet::kHaar;
    });
    choice.candidates = modes;
    return encoder.choose(block, choice);
  }
  const auto starts = modesToBeginWith(options_, before, sparse);
  choice.starts = starts;
  return encoder.choose(block, choice);
}

// Adds up the errors of a block's voxels, those of empty ones left out where they are exact.
// @return the voxel of the greatest
std::size_t Compressor::findErrors(std::span<const float> values, std::span<const float> decoded,
                                   std::span<const VoxelState> states, const BlockShape& shape,
                                   CodingError& errors) const {
  const auto channels = static_cast<std::size_t>(shape.channels);
  const std::size_t voxels = states.size() / static_cast<std::size_t>(shape.extents[0]);
  const auto errorAt = [&](std::size_t voxel, std::size_t channel) {
    const std::size_t i = voxel * channels + channel;
    const bool counts = !parameters_.sparse || states[voxel] != VoxelState::kEmpty;
    return counts * std::abs(static_cast<double>(decoded[i]) - values[i]);
  };
  std::size_t worst = 0;
  for (std::size_t frame = 0; frame * voxels < states.size(); ++frame) {
    constexpr std::size_t kLanes = 8;  // so that no sum waits for the one before
    std::array<double, kLanes> sums{}, greatest{};
    const std::size_t begin = frame * voxels, end = begin + voxels;
    for (std::size_t i = begin; i < end; ++i) {
      errors.voxels += states[i] == VoxelState::kEmpty ? 0 : 1;
      for (std::size_t c = 0; c < channels; ++c) {
        const double error = errorAt(i, c);
        sums[i % kLanes] += error * error;
        greatest[i % kLanes] = std::max(greatest[i % kLanes], error);
      }
    }
    errors.squaredOf[frame] += std::accumulate(sums.begin(), sums.end(), 0.0);
    const double most = std::ranges::max(greatest);
    if (most <= errors.maximum)
      continue;
    errors.maximum = most;
    std::size_t i = begin * channels;
    while (i + 1 < end * channels && errorAt(i / channels, i % channels) != most) ++i;
    worst = i / channels;
  }
  return worst;
}

// Encodes a block and decodes it as the reader will.
// @param chosen  its mode, which is replaced where modes are chosen
Result<EncodedBlock> Compressor::encodeBlock(std::size_t block, std::optional<BlockMode>& chosen,
                                             Way way, Training& training) {
  const BlockGrid& grid = row_.grid();
  const BlockShape shape = shapeOf(grid, block);
  std::vector<float> values(shape.values());
  std::vector<float> decoded(values.size());
  BlockStates states;
  row_.cut(block, values, states);
  const BlockEncoder encoder(parameters_, stream());
  const BlockContent content = encoder.contentOf(
      values, shape,
      parameters_.sparse ? std::span<const VoxelState>(states) : std::span<const VoxelState>());
  if (choosesModes(way))
    chosen = chooseMode(content, encoder, chosenBefore_ ? chosen : std::nullopt);
  std::optional<BlockMode> mode = chosen;
  if (way == Way::kLearn && mode && !options_.mode && parameters_.sparse)
    mode->shaped = mode->shaped || shareOf(states) < kSparseBlock;
  // A block that was not worth its bits at the step its mode was chosen for may be at a finer one.
  // What is chosen here depends on the step alone, so that a try can be had again.
  if (way == Way::kEncode && !mode && parameters_.step < kFinerStep * chosenStep_)
    mode = chooseMode(content, encoder, std::nullopt);
  EncodedBlock result;
  result.tiers = encoder.encode(content, mode, training);
  // Every second block is enough to tell lengths apart.
  if (way == Way::kLearn && options_.access == Access::kAny && mode && block % 2 == 0 &&
      grid.frames() == BlockGrid::kSide && info_.frames > LengthCosts::kFrames.back()) {
    encoder.addLengthCosts(content, training.lengths);
    for (const auto& tier : result.tiers)
      training.lengths.bits += 8 * static_cast<std::int64_t>(tier.size());
  }
  result.means = meansOf(values);
  BlockStates decodedStates;
  VOLUTE_TRY(head_.decoder->decode(result.tiers, shape.levels(), shape, decoded, &decodedStates));
  const std::size_t worst = findErrors(values, decoded, states, shape, result.error);
  if (!std::isfinite(result.error.squared()) || (parameters_.sparse && states != decodedStates)) {
    return fail(ErrorCode::kInvalidData, "grid '{}': the input changed while it was read",
                info_.name);
  }
  const BlockGrid::Index4 origin = grid.origin(block);
  std::uint64_t place = 0;
  for (std::size_t axis = 0, rest = worst; axis < 4; ++axis) {
    std::size_t inner = 1;
    for (std::size_t a = axis + 1; a < 4; ++a) inner *= static_cast<std::size_t>(shape.extents[a]);
    const std::array<int, 4> size{info_.frames, info_.z, info_.y, info_.x};
    place = place * static_cast<std::uint64_t>(size[axis]) +
            static_cast<std::uint64_t>(origin[axis]) + rest / inner;
    rest %= inner;
  }
  result.error.place = result.error.maximum > 0 ? place : 0;
  return result;
}

std::vector<std::int64_t> Compressor::meansOf(std::span<const float> values) const {
  const auto channels = static_cast<std::size_t>(info_.channels);
  std::array<double, 3> sums{};
  for (std::size_t i = 0; i < values.size(); i += channels)
    for (std::size_t c = 0; c < channels; ++c) sums[c] += values[i + c];
  std::vector<std::int64_t> means;
  for (std::size_t c = 0; c < channels; ++c)
    means.push_back(parameters_.quantisedMean(sums[c] * static_cast<double>(channels) /
                                              static_cast<double>(values.size())));
  return means;
}

Status Compressor::encodeUnit(Way way, EncodedUnits::Unit& done, EncodedUnitRecord& record) {
  const UnitPlan::Unit unit = plan_.unit(done.number);
  VOLUTE_TRY(row_.load(unit.row, unit.firstLayer, unit.endLayer));
  const std::vector<std::uint64_t> blocks =
      isOfSome(way) ? sampleOf(row_.occupied(), oneOf_)
                    : std::vector(row_.occupied().begin(), row_.occupied().end());
  auto& modes = modesOf(way, done.number, blocks.size());
  std::vector<EncodedBlock> batch;
  std::mutex mutex;
  for (std::size_t begin = 0; begin < blocks.size(); begin += kBatch) {
    VOLUTE_TRY(checkCancelled());
    batch.clear();
    batch.resize(std::min(kBatch, blocks.size() - begin));
    VOLUTE_TRY(parallelTry(batch.size(), [&](std::size_t i) -> Status {
      Training ofBlock;
      VOLUTE_ASSIGN(batch[i], encodeBlock(blocks[begin + i], modes[begin + i], way, ofBlock));
      const std::lock_guard lock(mutex);
      record.training.add(ofBlock);
      return {};
    }));
    for (std::size_t i = 0; i < batch.size(); ++i) {
      VOLUTE_TRY(units_.append(blocks[begin + i], batch[i], done));
      const std::uint64_t layer = blocks[begin + i] / plan_.blocksALayer();
      if (record.layers.empty() || record.layers.back().layer != layer)
        record.layers.push_back({layer, {}});
      record.layers.back().error.add(batch[i].error);
    }
  }
  return {};
}

// A unit, or what an earlier run kept of it.
Status Compressor::doUnit(std::int64_t number, Way way) {
  VOLUTE_TRY(checkCancelled());
  EncodedUnits::Unit done = units_.begin(number);
  std::optional<EncodedUnitRecord> record;
  if (store_) {
    VOLUTE_ASSIGN(record, recall(way, done));
  }
  if (!record) {
    record.emplace();
    VOLUTE_TRY(encodeUnit(way, done, *record));
    if (store_)
      VOLUTE_TRY(keep(way, done, *record));
  }
  layers_.insert(layers_.end(), record->layers.begin(), record->layers.end());
  training_.add(record->training);
  units_.finish(std::move(done));
  return {};
}

// Those of a unit that has so many blocks with something in them.
std::vector<std::optional<BlockMode>>& Compressor::modesOf(Way way, std::int64_t number,
                                                           std::size_t blocks) {
  auto& modes = (isOfSome(way) ? someModes_ : modes_)[static_cast<std::size_t>(number)];
  if (modes.size() < blocks)
    modes.resize(blocks, usualMode_);
  return modes;
}

Status Compressor::keep(Way way, const EncodedUnits::Unit& done, EncodedUnitRecord& record) {
  const auto& modes = modesOf(way, done.number, done.blocks.size());
  record.modes.assign(modes.begin(),
                      modes.begin() + static_cast<std::ptrdiff_t>(done.blocks.size()));
  record.blocks = done.blocks;
  record.segments = done.segments;
  record.means = done.means;
  VOLUTE_ASSIGN(const auto bytes, units_.bytesOf(done));
  return store_->store(way_, done.number, record.toBytes(), bytes);
}

// Nothing when there is nothing of use. Bytes may be missing: they are dropped when the next way
// begins.
Result<std::optional<EncodedUnitRecord>> Compressor::recall(Way way, EncodedUnits::Unit& done) {
  std::optional<EncodedUnitRecord> none;
  const auto kept = store_->record(way_, done.number);
  if (!kept)
    return none;
  const auto bytes = store_->bytes(way_, done.number).value_or(std::vector<std::byte>());
  const UnitPlan::Unit unit = plan_.unit(done.number);
  auto record = EncodedUnitRecord::fromBytes(*kept);
  const std::uint64_t first = plan_.firstBlock(unit);
  const bool own = record && std::ranges::is_sorted(record->blocks) &&
                   (record->blocks.empty() || (record->blocks.front() >= first &&
                                               record->blocks.back() - first < plan_.blocks(unit)));
  if (!own)
    return none;
  const auto sizes = record->tierSizes();
  const std::uint64_t total = std::accumulate(sizes.begin(), sizes.end(), std::uint64_t{0});
  done.hasBytes = bytes.size() == total;
  if (!done.hasBytes && !bytes.empty())
    return none;
  done.blocks = record->blocks;
  done.segments = record->segments;
  done.means = record->means;
  if (done.hasBytes) {
    done.sizes = sizes;
    VOLUTE_TRY(units_.appendBytes(done, bytes));
  }
  std::ranges::copy(record->modes, modesOf(way, done.number, record->modes.size()).begin());
  return record;
}

// What decides about the result: the values, and what is asked for.
Status Compressor::openStore() {
  if (options_.work.empty())
    return {};
  VOLUTE_TRY(team_.sum(std::span(&content_, 1)));
  ByteWriter all;
  all.string(head_.header.writtenBy);
  all.u64(content_);
  for (const int number : {info_.frames, info_.z, info_.y, info_.x, info_.channels, options_.effort,
                           static_cast<int>(options_.target.kind),
                           static_cast<int>(options_.access), static_cast<int>(plan_.unitsARow())})
    all.u32(static_cast<std::uint32_t>(number));
  all.f64(goal_.value());
  all.string(options_.wavelet);
  all.string(options_.mode ? shortName(*options_.mode) : "");
  ContentHash key;
  key.add(all.view());
  VOLUTE_ASSIGN(store_, UnitStore::open(options_.work, key.digits()));
  return {};
}

// Sums in the order of layers are the same on all ranks, and for any number of them.
Status Compressor::shareErrors() {
  VOLUTE_ASSIGN(auto all, gatherValues(team_, std::span<const LayerError>(layers_)));
  std::ranges::sort(all, {}, &LayerError::layer);
  error_ = {};
  frameSquares_.assign(facts_.size(), 0);
  for (const LayerError& layer : all) {
    error_.add(layer.error);
    const std::size_t row = layer.layer / (plan_.layers() / static_cast<std::size_t>(row_.rows()));
    for (std::size_t t = 0; t < layer.error.squaredOf.size(); ++t) {
      const std::size_t frame = row * static_cast<std::size_t>(row_.grid().frames()) + t;
      if (frame < frameSquares_.size())
        frameSquares_[frame] += layer.error.squaredOf[t];
    }
  }
  return {};
}

Status Compressor::shareTraining() {
  auto& seen = training_.counts.seen;
  std::vector<std::uint64_t> numbers;
  training_.symbols.resize(symbol::kCount);
  for (const auto& counts : seen) numbers.insert(numbers.end(), counts.begin(), counts.end());
  for (const auto& counts : training_.symbols)
    numbers.insert(numbers.end(), counts.begin(), counts.end());
  for (const std::int64_t* number : training_.sums())
    numbers.push_back(static_cast<std::uint64_t>(*number));
  VOLUTE_TRY(team_.sum(numbers));
  auto number = numbers.begin();
  for (auto& counts : seen) {
    for (std::uint32_t& count : counts) count = static_cast<std::uint32_t>(*number++);
  }
  for (auto& counts : training_.symbols) {
    for (std::uint32_t& count : counts) count = static_cast<std::uint32_t>(*number++);
  }
  for (std::int64_t* sum : training_.sums()) *sum = static_cast<std::int64_t>(*number++);
  return {};
}

// What of the support the last way went through: its blocks' voxels, for blocks hold from few to
// all; tiles are of no block, and where there are some blocks are counted instead.
Status Compressor::shareDone(Way way) {
  doneShare_ = 1;
  if (!isOfSome(way) || blocks_ == 0)
    return {};
  std::uint64_t done = 0;
  for (const EncodedUnits::Unit& unit : units_.units()) done += unit.blocks.size();
  VOLUTE_TRY(team_.sum(std::span(&done, 1)));
  const bool tiles =
      std::ranges::any_of(head_.tiles, [](const auto& frame) { return !frame.empty(); });
  doneShare_ = tiles || error_.voxels == 0
                   ? static_cast<double>(done) / static_cast<double>(blocks_)
                   : error_.voxels / supportVoxels_;
  return {};
}

Status Compressor::shareModes(Way way) {
  if (team_.size() == 1)
    return {};
  ByteWriter own;
  for (const EncodedUnits::Unit& done : units_.units()) {
    own.u64(static_cast<std::uint64_t>(done.number));
    own.u64(done.blocks.size());
    const auto& modes = modesOf(way, done.number, done.blocks.size());
    for (std::size_t i = 0; i < done.blocks.size(); ++i) own.u8(byteOfMode(modes[i]));
  }
  VOLUTE_ASSIGN(const auto ranks, team_.gatherAll(own.view()));
  for (const auto& bytes : ranks) {
    for (ByteReader in(bytes); in.remaining() > 0;) {
      const auto unit = static_cast<std::int64_t>(in.u64());
      const auto blocks = static_cast<std::size_t>(in.u64());
      auto& modes = modesOf(way, unit, blocks);
      for (std::size_t i = 0; i < blocks; ++i) modeOfByte(in.u8(), modes[i]);
    }
  }
  return {};
}

// Rank 0 makes the head of the file, and tells how long the file is.
Status Compressor::shareSegments() {
  VOLUTE_TRY(units_.shareSegments(head_));
  if (team_.leads()) {
    headBytes_ = writeHead(head_);
    fileBytes_ = head_.fileBytes;
  }
  VOLUTE_ASSIGN(fileBytes_, team_.broadcast(fileBytes_));
  return {};
}

Status Compressor::encodeAll(double proposed, Way way) {
  VOLUTE_ASSIGN(const double step, team_.broadcast(proposed));
  parameters_.step = step / parameters_.unit();
  // From the first try on the parameters stay, so that what a step gives can be had again.
  if (choosesModes(way) || (way == Way::kEncode && tries_ == 0))
    training_.apply(parameters_);
  if (choosesModes(way)) {
    const double ratio = chosenStep_ > 0 ? parameters_.step / chosenStep_ : 0;
    stepsAlike_ = ratio < kSameModes && ratio > 1 / kSameModes;
    chosenStep_ = parameters_.step;
  }
  training_ = {};
  head_.parameters = writeParameters(parameters_, info_.channels);
  VOLUTE_ASSIGN(head_.decoder, openWaveletDecoder(kSparseCodec, head_.parameters, stream()));
  if (store_) {
    for (const EncodedUnits::Unit& done : units_.units()) store_->dropBytes(way_, done.number);
  }
  ++way_;
  layers_.clear();
  VOLUTE_TRY(units_.clear());
  tries_ += way == Way::kEncode ? 1 : 0;
  const std::string stage = isOfSome(way) ? "learning"
                            : way == Way::kChoose
                                ? chosenBefore_ ? "choosing modes again" : "choosing modes"
                            : tries_ == 1 ? "compressing"
                                          : fmt::format("compressing, try {}", tries_);
  VOLUTE_TRY(team_.forUnits(stage, plan_.count(), progress_,
                            [&](std::int64_t number) { return doUnit(number, way); }));
  chosenBefore_ = chosenBefore_ || way == Way::kChoose;
  VOLUTE_TRY(shareErrors());
  VOLUTE_TRY(shareDone(way));
  noteErrors();
  if (choosesModes(way))
    VOLUTE_TRY(shareModes(way));
  if (way != Way::kEncode)
    VOLUTE_TRY(shareTraining());
  if (!isOfSome(way))
    VOLUTE_TRY(shareSegments());
  return {};
}

// What the last way through all blocks came to.
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
      return support_.rms;
    default:
      return relativeRms_;
  }
}

tl::unexpected<Error> Compressor::unreachable() const {
  if (goal_.isSize()) {
    return fail(ErrorCode::kUnsupported,
                "{}: cannot be made as small as {} = {}; the smallest is {} bytes of {} raw ones",
                target_.string(), nameOf(options_.target.kind), options_.target.value, fileBytes_,
                info_.rawBytes());
  }
  return fail(ErrorCode::kUnsupported,
              "{}: {} = {} cannot be reached: the rounding of float32 leaves a relative RMS of "
              "{:.3g} and a maximum error of {:.3g}; ask for more",
              target_.string(), nameOf(options_.target.kind), options_.target.value,
              options_.target.isOverSupport() ? support_.rms + overSupport(rounding_)
                                              : relativeRms_ + overAll(rounding_),
              error_.maximum + rounding_);
}

// What an earlier run kept may lack the bytes: a disk lost them.
Status Compressor::completeUnits() {
  for (std::size_t i = 0; i < units_.units().size(); ++i) {
    if (units_.units()[i].hasBytes)
      continue;
    EncodedUnits::Unit again = units_.begin(units_.units()[i].number);
    EncodedUnitRecord record;
    VOLUTE_TRY(encodeUnit(Way::kEncode, again, record));
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
    VOLUTE_ASSIGN(auto file, CheckedFile::create(target_));
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
  const double target = goal_.value();
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
  VOLUTE_TRY(encodeAll(first, Way::kLearn));
  const double learnt = std::max(outcomeOfTry(), 1e-30);
  double step = betterStep();
  VOLUTE_TRY(chooseLength());
  const int tries = blocks_ < kFewBlocks ? 3 : 2;
  for (int i = 0; i < tries; ++i) {
    VOLUTE_TRY(encodeAll(step, Way::kTry));
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
  VOLUTE_TRY(units_.open(target_));
  VOLUTE_TRY(survey());
  if (options_.halves)
    goal_.leaveRoomForHalves(roundingToHalves());
  VOLUTE_TRY(goal_.leaveRoomFor(rounding_));
  if (goal_.isMaxError())
    // What is decoded is rounded to a float as well.
    parameters_.maxError = std::max(goal_.value() - rounding_, 0.5 * goal_.value());
  VOLUTE_TRY(team_.agree(openStore()));
  goal_.setModel(model_);
  double step = goal_.firstStep();
  if (goal_.isSize() || goal_.isMaxError()) {
    VOLUTE_TRY(encodeAll(step, Way::kLearn));
    VOLUTE_TRY(chooseLength());
  } else {
    VOLUTE_ASSIGN(step, stepFromSome(step));
  }
  VOLUTE_TRY(encodeAll(step, Way::kChoose));
  if (goal_.isMaxError()) {
    VOLUTE_TRY(searchSmallest());
    return write();
  }
  // Modes depend on the step, and on what blocks in other modes have taught.
  VOLUTE_ASSIGN(const double better, team_.broadcast(betterStep()));
  VOLUTE_ASSIGN(step, team_.broadcast(step));
  const double change = std::max(better / step, step / better);
  if (change > (effort_.again ? 1.02 : 1.2))
    VOLUTE_TRY(encodeAll(better, Way::kChoose));
  VOLUTE_ASSIGN(const bool near, team_.broadcast(nearEnough()));
  if (!near || effort_.again)
    VOLUTE_TRY(searchStep(betterStep()));
  return write();
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
