// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

#include "volute/base/checksum.hpp"
#include "volute/base/gather_values.hpp"
#include "volute/base/parallel.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/codec/compressor.hpp"

namespace volute {
namespace {

// A step this much finer than the one that modes were chosen for asks again about blocks left out.
constexpr double kFinerStep = 0.75;
// A block with less in it than this share of its voxels has a support in any mode worth having.
constexpr double kSparseBlock = 0.5;
// Steps less apart than this leave the modes of such blocks as they are.
constexpr double kSameModes = 1.5;

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

}  // namespace

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

// Adds up the errors of a block's voxels, those of empty ones left out where they are exact. Of
// floats each is the greater of that in doubles and that of the float that is shown.
// @return the voxel of the greatest
template <bool kFloats>
std::size_t Compressor::findErrors(std::span<const float> values, std::span<const float> decoded,
                                   std::span<const VoxelState> states, const BlockShape& shape,
                                   CodingError& errors) const {
  const auto channels = static_cast<std::size_t>(shape.channels);
  const std::size_t voxels = states.size() / static_cast<std::size_t>(shape.extents[0]);
  const auto errorAt = [&](std::size_t voxel, std::size_t channel) {
    const std::size_t i = voxel * channels + channel;
    const bool counts = !parameters_.sparse || states[voxel] != VoxelState::kEmpty;
    const double error = std::abs(static_cast<double>(decoded[i]) - values[i]);
    if constexpr (kFloats) {
      const double number = parameters_.offset + static_cast<double>(values[i]);
      const auto shown = static_cast<float>(parameters_.offset + static_cast<double>(decoded[i]));
      return counts * std::max(error, std::abs(static_cast<double>(shown) - number));
    } else {
      return counts * error;
    }
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
                                             Pass pass, Training& training) {
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
  if (choosesModes(pass))
    chosen = chooseMode(content, encoder, chosenBefore_ ? chosen : std::nullopt);
  std::optional<BlockMode> mode = chosen;
  if (pass == Pass::kLearn && mode && !options_.mode && parameters_.sparse)
    mode->shaped = mode->shaped || shareOf(states) < kSparseBlock;
  // A block that was not worth its bits at the step its mode was chosen for may be at a finer one.
  // What is chosen here depends on the step alone, so that a try can be had again.
  if (pass == Pass::kEncode && !mode && parameters_.step < kFinerStep * chosenStep_)
    mode = chooseMode(content, encoder, std::nullopt);
  EncodedBlock result;
  result.tiers = encoder.encode(content, mode, training);
  // Every second block is enough to tell lengths apart.
  if (pass == Pass::kLearn && options_.access == Access::kAny && mode && block % 2 == 0 &&
      grid.frames() == BlockGrid::kSide && info_.frames > LengthCosts::kFrames.back()) {
    encoder.addLengthCosts(content, training.lengths);
    for (const auto& tier : result.tiers)
      training.lengths.bits += 8 * static_cast<std::int64_t>(tier.size());
  }
  result.means = meansOf(values);
  BlockStates decodedStates;
  VOLUTE_TRY(head_.decoder->decode(result.tiers, shape.levels(), shape, decoded, &decodedStates));
  const std::size_t worst = floats_
                                ? findErrors<true>(values, decoded, states, shape, result.error)
                                : findErrors<false>(values, decoded, states, shape, result.error);
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

Status Compressor::encodeUnit(Pass pass, EncodedUnits::Unit& done, EncodedUnitRecord& record) {
  const UnitPlan::Unit unit = plan_.unit(done.number);
  VOLUTE_TRY(row_.load(unit.row, unit.firstLayer, unit.endLayer));
  const std::vector<std::uint64_t> blocks =
      overSample(pass) ? sampleOf(row_.occupied(), oneOf_)
                       : std::vector(row_.occupied().begin(), row_.occupied().end());
  auto& modes = modesOf(pass, done.number, blocks.size());
  std::vector<EncodedBlock> batch;
  std::mutex mutex;
  for (std::size_t begin = 0; begin < blocks.size(); begin += kBatchOfBlocks) {
    VOLUTE_TRY(checkCancelled());
    batch.clear();
    batch.resize(std::min(kBatchOfBlocks, blocks.size() - begin));
    VOLUTE_TRY(parallelTry(batch.size(), [&](std::size_t i) -> Status {
      Training ofBlock;
      VOLUTE_ASSIGN(batch[i], encodeBlock(blocks[begin + i], modes[begin + i], pass, ofBlock));
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
Status Compressor::doUnit(std::int64_t number, Pass pass) {
  VOLUTE_TRY(checkCancelled());
  EncodedUnits::Unit done = units_.begin(number);
  std::optional<EncodedUnitRecord> record;
  if (store_) {
    VOLUTE_ASSIGN(record, recall(pass, done));
  }
  if (!record) {
    record.emplace();
    VOLUTE_TRY(encodeUnit(pass, done, *record));
    if (store_)
      VOLUTE_TRY(keep(pass, done, *record));
  }
  layers_.insert(layers_.end(), record->layers.begin(), record->layers.end());
  training_.add(record->training);
  units_.finish(std::move(done));
  return {};
}

// Those of a unit that has so many blocks with something in them.
std::vector<std::optional<BlockMode>>& Compressor::modesOf(Pass pass, std::int64_t number,
                                                           std::size_t blocks) {
  auto& modes = (overSample(pass) ? sampleModes_ : modes_)[static_cast<std::size_t>(number)];
  if (modes.size() < blocks)
    modes.resize(blocks, usualMode_);
  return modes;
}

Status Compressor::keep(Pass pass, const EncodedUnits::Unit& done, EncodedUnitRecord& record) {
  const auto& modes = modesOf(pass, done.number, done.blocks.size());
  record.modes.assign(modes.begin(),
                      modes.begin() + static_cast<std::ptrdiff_t>(done.blocks.size()));
  record.blocks = done.blocks;
  record.segments = done.segments;
  record.means = done.means;
  VOLUTE_ASSIGN(const auto bytes, units_.bytesOf(done));
  return store_->store(pass_, done.number, record.toBytes(), bytes);
}

// Nothing when there is nothing of use. Bytes may be missing: they are dropped when the next pass
// begins.
Result<std::optional<EncodedUnitRecord>> Compressor::recall(Pass pass, EncodedUnits::Unit& done) {
  std::optional<EncodedUnitRecord> none;
  const auto kept = store_->record(pass_, done.number);
  if (!kept)
    return none;
  const auto bytes = store_->bytes(pass_, done.number).value_or(std::vector<std::byte>());
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
  std::ranges::copy(record->modes, modesOf(pass, done.number, record->modes.size()).begin());
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

// The share of the support that the last pass covered: its blocks' voxels, for blocks hold from few
// to all; tiles are of no block, and where there are some blocks are counted instead.
Status Compressor::shareDone(Pass pass) {
  doneShare_ = 1;
  if (!overSample(pass) || blocks_ == 0)
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

Status Compressor::shareModes(Pass pass) {
  if (team_.size() == 1)
    return {};
  ByteWriter own;
  for (const EncodedUnits::Unit& done : units_.units()) {
    own.u64(static_cast<std::uint64_t>(done.number));
    own.u64(done.blocks.size());
    const auto& modes = modesOf(pass, done.number, done.blocks.size());
    for (std::size_t i = 0; i < done.blocks.size(); ++i) own.u8(byteOfMode(modes[i]));
  }
  VOLUTE_ASSIGN(const auto ranks, team_.gatherAll(own.view()));
  for (const auto& bytes : ranks) {
    for (ByteReader in(bytes); in.remaining() > 0;) {
      const auto unit = static_cast<std::int64_t>(in.u64());
      const auto blocks = static_cast<std::size_t>(in.u64());
      auto& modes = modesOf(pass, unit, blocks);
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

Status Compressor::encodeAll(double proposed, Pass pass) {
  VOLUTE_ASSIGN(const double step, team_.broadcast(proposed));
  parameters_.step = step / parameters_.unit();
  // From the first try on the parameters stay, so that what a step gives can be had again.
  if (choosesModes(pass) || (pass == Pass::kEncode && tries_ == 0))
    training_.apply(parameters_);
  if (choosesModes(pass)) {
    const double ratio = chosenStep_ > 0 ? parameters_.step / chosenStep_ : 0;
    stepsAlike_ = ratio < kSameModes && ratio > 1 / kSameModes;
    chosenStep_ = parameters_.step;
  }
  training_ = {};
  head_.parameters = writeParameters(parameters_, info_.channels);
  VOLUTE_ASSIGN(head_.decoder, openWaveletDecoder(kSparseCodec, head_.parameters, stream()));
  if (store_) {
    for (const EncodedUnits::Unit& done : units_.units()) store_->dropBytes(pass_, done.number);
  }
  ++pass_;
  layers_.clear();
  VOLUTE_TRY(units_.clear());
  tries_ += pass == Pass::kEncode ? 1 : 0;
  const std::string stage = overSample(pass) ? "learning"
                            : pass == Pass::kChoose
                                ? chosenBefore_ ? "choosing modes again" : "choosing modes"
                            : tries_ == 1 ? "compressing"
                                          : fmt::format("compressing, try {}", tries_);
  VOLUTE_TRY(team_.forUnits(stage, plan_.count(), progress_,
                            [&](std::int64_t number) { return doUnit(number, pass); }));
  chosenBefore_ = chosenBefore_ || pass == Pass::kChoose;
  VOLUTE_TRY(shareErrors());
  VOLUTE_TRY(shareDone(pass));
  noteErrors();
  if (choosesModes(pass))
    VOLUTE_TRY(shareModes(pass));
  if (pass != Pass::kEncode)
    VOLUTE_TRY(shareTraining());
  if (!overSample(pass))
    VOLUTE_TRY(shareSegments());
  return {};
}

}  // namespace volute
