// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/codec/block_codec.hpp"
#include "volute/codec/block_syntax.hpp"
#include "volute/codec/cell_field.hpp"
#include "volute/codec/symbol_coder.hpp"
#include "volute/codec/wavelet_codec.hpp"

namespace volute {
namespace {

/// The Bits of a reader.
struct ReadBits {
  AdaptiveBit* contexts;
  ArithmeticDecoder in;
  bool shared = false;  ///< the end of the string is not of bits

  bool bit(unsigned context, bool) { return in.bit(contexts[context]); }

  bool even(bool) {
    AdaptiveBit half;
    return shared ? in.bit(half) : in.even();
  }
};

/// A reader for some bits in a row, whose state can stay in registers.
class LocalBits : public ReadBits {
 public:
  explicit LocalBits(ReadBits& home) : ReadBits(home), home_(home) {}

  ~LocalBits() { home_.in = in; }

  LocalBits(const LocalBits&) = delete;
  LocalBits& operator=(const LocalBits&) = delete;

 private:
  ReadBits& home_;
};

/// What a quantised coefficient stands for.
class Dequantiser {
 public:
  explicit Dequantiser(const WaveletParameters& parameters) : parameters_(parameters) {}

  float operator()(std::int32_t q, double norm) const {
    constexpr double kLargest = std::numeric_limits<float>::max();
    const double size = std::min(parameters_.shown(q) * (parameters_.step / norm), kLargest);
    return static_cast<float>(q < 0 ? -size : size);
  }

 private:
  const WaveletParameters& parameters_;
};

tl::unexpected<Error> malformed(std::size_t tier) {
  return fail(ErrorCode::kInvalidData, "is malformed in tier {}", tier);
}

/// Room for a block; getting memory of this size costs as much as using it.
struct Scratch {
  Contexts contexts;
  std::vector<float> planes;
  std::vector<std::uint8_t> support;
  std::array<ComponentMemory, 3> memories;
  std::array<ComponentFields, 3> fields;
  std::vector<std::uint32_t> signs;  ///< where they belong
  BlockStates states;
};

/// One block on its way.
class BlockReading {
 public:
  BlockReading(const WaveletParameters& parameters, const BlockShape& shape, Scratch& scratch)
      : parameters_(parameters),
        shape_(shape),
        contexts_(scratch.contexts),
        planes_(scratch.planes),
        support_(scratch.support),
        memories_(scratch.memories),
        fields_(scratch.fields),
        signs_(scratch.signs),
        states_(scratch.states) {
    // Of contexts only what is used: copies of this size cost as much as decoding.
    const Contexts& first = parameters.contexts;
    contexts_.resize(first.size());
    const auto copy = [&](unsigned begin, unsigned end) {
      std::copy(first.begin() + begin, first.begin() + end, contexts_.begin() + begin);
    };
    copy(0, parameters.bySymbols ? context::kCell : context::kCount);
    if (parameters.bySymbols)
      copy(context::kCorrected, context::kCount);
    planes_.assign(shape.values(), 0);
    support_.clear();
    states_.clear();
  }

  Status read(Tiers tiers, int levels);
  void correct(const StreamInfo& stream, std::span<float> values) const;

  const BlockMode& mode() const { return mode_; }

  std::span<float> planes() { return planes_; }

  std::span<const std::uint8_t> support() const { return support_; }

  /// Of codec 3 alone.
  const BlockStates& states() const { return states_; }

  std::span<const Outlier> outliers() const { return outliers_; }

  /// False for a block that has nothing but its topology.
  bool coded() const { return coded_; }

 private:
  void readHead(ReadBits& bits);
  bool readTopology(ReadBits& bits);
  void readCells(ReadBits& bits, BlockWalk& walk, const TierStrides& strides);
  bool readStart(ReadBits& bits, std::optional<BlockWalk>& walk);
  void readSymbols(SymbolReader& reader, FieldWalk& walk, const TierStrides& strides, int least);
  void readScaling(ReadBits& bits, const BlockWalk& walk);
  void readCorrections(ReadBits& bits);

  const WaveletParameters& parameters_;
  const BlockShape& shape_;
  Contexts& contexts_;
  std::vector<float>& planes_;
  std::vector<std::uint8_t>& support_;
  std::span<ComponentMemory> memories_;
  std::span<ComponentFields> fields_;
  std::vector<std::uint32_t>& signs_;
  BlockStates& states_;
  std::vector<Outlier> outliers_;
  bool coded_ = true, full_ = false;
  BlockMode mode_;
  std::vector<std::int32_t> corrections_;
};

// False where outliers are no numbers.
bool BlockReading::readTopology(ReadBits& bits) {
  states_.assign(shape_.voxels(), VoxelState::kEmpty);
  LocalBits local(bits);
  codeStates(local, shape_.extents, std::span(states_), support_);
  coded_ = local.bit(context::kCoded, false);
  if (!coded_)
    return true;
  codeOutliers(local, shape_, outliers_);
  support_.resize(states_.size());
  full_ = true;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    support_[i] = isCoded(states_[i], parameters_) ? 1 : 0;
    full_ = full_ && support_[i] != 0;
  }
  return std::ranges::all_of(outliers_, [&](const Outlier& outlier) {
    return std::ranges::all_of(outlier.value, [](float value) { return std::isfinite(value); });
  });
}

void BlockReading::readHead(ReadBits& bits) {
  codeMode(bits, mode_, full_);
  if (parameters_.sparse) {
    if (!mode_.shaped)
      support_.clear();
    return;
  }
  if (!mode_.shaped)
    return;
  support_.resize(shape_.voxels());
  LocalBits local(bits);
  codeSupport(local, shape_.extents, std::span(support_));
}

void BlockReading::readScaling(ReadBits& bits, const BlockWalk& walk) {
  const Dequantiser dequantise(parameters_);
  walk.scaling([&](int c, std::ptrdiff_t position, double norm) {
    planes_[c * shape_.voxels() + position] =
        dequantise(codeNumber(bits, context::kScaling, 0), norm);
  });
}

void BlockReading::readCells(ReadBits& bits, BlockWalk& walk, const TierStrides& strides) {
  const Dequantiser dequantise(parameters_);
  walk.cells(strides,
             [&](int c, const CellLevel& level, std::ptrdiff_t position, std::uint16_t existing,
                 CellContext& context, const auto& neighbours, std::int32_t* q) {
               if (!bits.bit(context.cell, false))
                 return false;
               neighbours();
               {
                 LocalBits local(bits);
                 codeMembers(local, context, existing, q);
               }
               float* cell = planes_.data() + c * shape_.voxels() + position;
               for (unsigned left = existing; left != 0; left &= left - 1) {
                 const int k = std::countr_zero(left);
                 if (q[k] != 0)
                   cell[level.offset[k]] = dequantise(q[k], level.norm[k]);
               }
               return true;
             });
}

// The cells of a tier. Signs follow behind all of them.
// @param least  the least stride that is wanted
void BlockReading::readSymbols(SymbolReader& reader, FieldWalk& walk, const TierStrides& strides,
                               int least) {
  const Dequantiser dequantise(parameters_);
  const SymbolEnds* tables = parameters_.symbols.data();
  const unsigned mask = reader.lanes() - 1;
  SymbolReader in = reader;
  float shown[16][16];  // of each coefficient, by its symbol
  float* plane = nullptr;
  const bool wantsAll = least <= 0;
  signs_.resize(planes_.size());
  std::uint32_t* sign = signs_.data();
  // What a coefficient is that has the greatest symbol.
  const auto escape = [&](unsigned context, unsigned lane) -> std::int32_t {
    int length = static_cast<int>(
        in.symbol(tables[symbol::kLength + CellField::nearClassOf(context)], lane));
    if (length == symbol::kEscape)
      length += static_cast<int>(in.symbol(tables[symbol::kLonger], lane));
    if (length >= kMaxBits) {
      in.refuse();
      length = 0;
    }
    std::uint32_t rest = 1;
    if (length > 15)
      rest = rest << (length - 15) | in.bits(length - 15, lane);
    const int low = std::min(length, 15);
    rest = rest << low | in.bits(low, lane);
    return std::min(static_cast<std::int32_t>(rest), (1 << kMaxBits) - symbol::kEscape) +
           symbol::kEscape - 1;
  };
  walk.cells(
      strides,
      [&](int c, const CellLevel& level) {
        const bool wanted = wantsAll || level.stride >= least;
        plane = planes_.data() + static_cast<std::size_t>(c) * shape_.voxels();
        for (int k = 1; k < 16; ++k) {
          for (int s = 0; s < 16; ++s)
            shown[k][s] =
                wanted && s > 0 ? dequantise(s, level.norm[static_cast<std::size_t>(k)]) : 0;
        }
      },
      [&](int, const CellLevel& level, CellField& field, std::ptrdiff_t at, std::ptrdiff_t position,
          std::uint16_t existing, unsigned context, const CellField::Entry* parent, unsigned x) {
        if (in.symbol(tables[context], x & mask) == 0)
          return;
        std::uint16_t contexts[16];
        field.contexts(at, parent, static_cast<unsigned>(level.stride), contexts);
        alignas(16) std::uint8_t m[16] = {};
        float* cell = plane + position;
        const auto base = static_cast<std::uint32_t>(cell - planes_.data());
        unsigned sum = 0;
#pragma GCC unroll 15
        for (unsigned i = 0; i < kCellOrder.size(); ++i) {
          const unsigned k = kCellOrder[i];
          if ((existing >> k & 1) == 0)
            continue;
          const unsigned own = contexts[k] + siblingStep(siblingSum(static_cast<int>(k), m));
          const unsigned s = in.symbol(tables[own], i & mask);
          float value = shown[k][s];
          m[k] = static_cast<std::uint8_t>(s);
          sum += s;
          if (s == symbol::kEscape) [[unlikely]] {
            const std::int32_t q = escape(own, i & mask);
            m[k] = static_cast<std::uint8_t>(std::min(q, kRemembered));
            sum += m[k] - s;
            if (wantsAll || level.stride >= least)
              value = dequantise(q, level.norm[k]);
          }
          const auto offset = static_cast<std::uint32_t>(level.offset[k]);
          cell[offset] = value;
          *sign = base + offset;
          sign += s != 0 ? 1 : 0;
        }
        field.remember(at, m, sum);
      });
  const std::uint32_t* place = signs_.data();
  in.signs(static_cast<std::size_t>(sign - place), [&](std::uint32_t negative) {
    float& value = planes_[*place++];
    value = std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) ^ negative << 31);
  });
  reader = in;
}

void BlockReading::readCorrections(ReadBits& bits) {
  if (!(parameters_.maxError > 0) || !bits.bit(context::kEnd, false))
    return;
  corrections_.resize(shape_.values());
  codeCorrections(bits, shape_, corrections_);
}

// What stands before the coefficients; false where it is malformed. A block of topology alone ends
// with it.
bool BlockReading::readStart(ReadBits& bits, std::optional<BlockWalk>& walk) {
  if (parameters_.sparse) {
    if (!readTopology(bits))
      return false;
    if (!coded_)
      return true;
  }
  readHead(bits);
  walk.emplace(shape_, mode_, support_, memories_);
  readScaling(bits, *walk);
  return true;
}

Status BlockReading::read(Tiers tiers, int levels) {
  std::optional<BlockWalk> walk;
  std::optional<FieldWalk> fieldWalk;
  const bool whole = levels >= shape_.levels();
  for (std::size_t tier = 0; tier < tiers.size(); ++tier) {
    // Symbols of a tier are read as one.
    const TierStrides strides =
        stridesOfTier(shape_, tier, parameters_.bySymbols ? shape_.levels() : levels);
    const bool last = tier + 1 == kWaveletTiers.size();
    if (tiers[tier].empty()) {
      // Zeros, which the next tier's contexts see.
      if (fieldWalk)
        fieldWalk->cells(strides, [](auto&&...) {}, [](auto&&...) {});
      else if (walk)
        walk->cells(strides, [](auto&&...) { return false; });
      continue;
    }
    // A block that has anything has it in tier 0, with the mode.
    if (tier > 0 && !walk)
      return malformed(tier);
    ReadBits bits{contexts_.data(), ArithmeticDecoder(tiers[tier]), parameters_.bySymbols};
    if (strides.scaling) {
      if (!readStart(bits, walk))
        return malformed(tier);
      if (!coded_) {
        const bool alone = std::ranges::all_of(tiers.subspan(1), [](auto& t) { return t.empty(); });
        return alone && bits.in.usedAll() ? Status() : Status(malformed(tier));
      }
      if (parameters_.bySymbols)
        fieldWalk.emplace(shape_, mode_, support_, fields_);
    }
    if (!parameters_.bySymbols) {
      readCells(bits, *walk, strides);
      if (whole && last)
        readCorrections(bits);
      if (whole && !bits.in.usedAll())
        return malformed(tier);
      continue;
    }
    const bool hasBits = strides.scaling || (last && parameters_.maxError > 0);
    if (last && whole)
      readCorrections(bits);
    SymbolReader symbols(tiers[tier]);
    readSymbols(symbols, *fieldWalk, strides, shape_.levels() - levels);
    const bool usedAll = symbols.left() <= (hasBits ? bits.in.reached() : 0);
    if (!symbols.good() || (!usedAll && (whole || !last)))
      return malformed(tier);
  }
  return {};
}

void BlockReading::correct(const StreamInfo& stream, std::span<float> values) const {
  for (std::size_t i = 0; i < corrections_.size(); ++i) {
    if (corrections_[i] == 0)
      continue;
    const auto value =
        static_cast<float>(values[i] + corrections_[i] * parameters_.correctionStep());
    values[i] = std::min(stream.valueMax, std::max(stream.valueMin, value));
  }
}

/// Right means of a shaped block without its finest levels. A sample of the support that has no
/// neighbours at an odd place is a wavelet coefficient: without its level it is 0, and others
/// are less than they should be. What becomes of a support full of ones tells by how much; what
/// nothing is known of gets what the mean of the block leaves for it.
/// @param levels  that were decoded
/// @param sums    of each channel over the support, or empty where they are not known
void fillUnknown(std::span<float> values, std::span<const std::uint8_t> support,
                 const BlockMode& mode, const BlockShape& shape, int levels,
                 std::span<const double> sums) {
  constexpr float kKnown = 0.5f;
  const AxisLevels halvings = blockLevels(shape.extents, mode.timeLevels);
  const BlockGrid::Index4& e = shape.extents;
  const int dropped = std::min(shape.levels() - levels, 4);
  const auto channels = static_cast<std::size_t>(shape.channels);
  std::vector<float> weights(support.begin(), support.end());
  shapeForward(weights, support, e, mode.wavelet, halvings);
  std::array<int, 4> beside{};  // bits of places that hold nothing but dropped levels
  for (std::size_t axis = 0; axis < 4; ++axis)
    beside[axis] = (1 << std::min(dropped, halvings[axis])) - 1;
  const auto eachVoxel = [&](const auto& visit) {
    std::size_t at = 0;
    for (int t = 0; t < e[0]; ++t)
      for (int z = 0; z < e[1]; ++z)
        for (int y = 0; y < e[2]; ++y)
          for (int x = 0; x < e[3]; ++x, ++at) visit(at, BlockGrid::Index4{t, z, y, x});
  };
  eachVoxel([&](std::size_t at, const BlockGrid::Index4& place) {
    for (std::size_t axis = 0; axis < 4; ++axis)
      if ((place[axis] & beside[axis]) != 0)
        weights[at] = 0;
  });
  shapeInverse(weights, support, e, mode.wavelet, halvings);

  struct Mean {
    double weight = 0;
    std::array<double, 3> sum{};
  };

  // Of each cube of what a level leaves, in each frame.
  const auto side = static_cast<std::size_t>(BlockGrid::kSide >> dropped);
  std::vector<Mean> cubes(static_cast<std::size_t>(e[0]) * side * side * side);
  const auto cubeOf = [&](const BlockGrid::Index4& place) -> Mean& {
    std::size_t at = static_cast<std::size_t>(place[0]);
    for (std::size_t axis = 1; axis < 4; ++axis)
      at = at * side + static_cast<std::size_t>(place[axis] >> dropped);
    return cubes[at];
  };
  eachVoxel([&](std::size_t at, const BlockGrid::Index4& place) {
    if (support[at] == 0)
      return;
    Mean& cube = cubeOf(place);
    cube.weight += weights[at];
    for (std::size_t c = 0; c < channels; ++c) cube.sum[c] += values[at * channels + c];
  });

  struct Known : Mean {
    std::array<double, 3> least, most;
  };

  Known known;
  known.least.fill(std::numeric_limits<double>::infinity());
  known.most.fill(-std::numeric_limits<double>::infinity());
  std::vector<std::size_t> unknown;
  eachVoxel([&](std::size_t at, const BlockGrid::Index4& place) {
    if (support[at] == 0)
      return;
    const Mean& cube = cubeOf(place);
    if (!(weights[at] > kKnown) && !(cube.weight > kKnown)) {
      unknown.push_back(at);
      return;
    }
    known.weight += 1;
    for (std::size_t c = 0; c < channels; ++c) {
      float& value = values[at * channels + c];
      value = weights[at] > kKnown ? value / weights[at]
                                   : static_cast<float>(cube.sum[c] / cube.weight);
      known.sum[c] += value;
      known.least[c] = std::min<double>(known.least[c], value);
      known.most[c] = std::max<double>(known.most[c], value);
    }
  });
  for (std::size_t c = 0; c < channels; ++c) {
    double left = known.weight > 0 ? known.sum[c] / known.weight : 0;
    if (!sums.empty() && !unknown.empty()) {
      left = (sums[c] - known.sum[c]) / static_cast<double>(unknown.size());
      if (known.weight > 0)
        left = std::clamp(left, known.least[c], known.most[c]);
    }
    for (const std::size_t at : unknown) values[at * channels + c] = static_cast<float>(left);
    if (sums.empty())
      continue;
    // What is nearly of one sign keeps it.
    double sum = 0, sizes = 0, count = 0;
    for (std::size_t at = 0; at < support.size(); ++at) {
      const double value = support[at] != 0 ? values[at * channels + c] : 0;
      sum += value;
      sizes += std::abs(value);
      count += support[at];
    }
    const double factor = sums[c] / sum;
    const bool scales = std::abs(sum) > 0.9 * sizes && factor > 0.25 && factor < 4;
    const double shift = (sums[c] - sum) / std::max(count, 1.0);
    for (std::size_t at = 0; at < support.size(); ++at) {
      float& value = values[at * channels + c];
      if (support[at] != 0)
        value = static_cast<float>(scales ? value * factor : value + shift);
    }
  }
}

class WaveletDecoder final : public BlockDecoder {
 public:
  WaveletDecoder(WaveletParameters parameters, const StreamInfo& stream)
      : parameters_(std::move(parameters)), stream_(stream) {}

  int blockFrames() const override { return parameters_.blockFrames; }

  bool hasMeans() const override { return parameters_.means; }

  double offset() const override { return parameters_.offset; }

  float mean(std::int64_t quantised) const override {
    const float value = parameters_.mean(quantised);
    return std::min(stream_.valueMax, std::max(stream_.valueMin, value));
  }

  std::span<const int> tierLevels() const override { return kWaveletTiers; }

  std::uint64_t maxSegmentBytes(const BlockShape& shape, std::size_t) const override {
    // The topology, an outlier, 46 bits of a coefficient with their signs and 34 of a correction,
    // at the least probability, 10 bits each.
    return 128 * static_cast<std::uint64_t>(shape.values()) + 4096;
  }

  Status decode(Tiers tiers, int levels, const BlockShape& shape, std::span<float> values,
                BlockStates* states, FrameSpan wanted,
                std::span<const float> means) const override {
    VOLUTE_ASSERT(values.size() == shape.values() && tiers.size() <= kWaveletTiers.size());
    if (std::ranges::all_of(tiers, [](const auto& tier) { return tier.empty(); })) {
      const std::array<float, 3> empty =
          parameters_.sparse ? background() : std::array{zero(), zero(), zero()};
      fillFrames(values, shape, wanted, empty);
      if (states)
        states->assign(shape.voxels(), VoxelState::kEmpty);
      return {};
    }
    thread_local Scratch scratch;
    BlockReading block(parameters_, shape, scratch);
    VOLUTE_TRY(block.read(tiers, levels));
    int decoded = 0;
    for (std::size_t tier = 0; tier < tiers.size(); ++tier) decoded += kWaveletTiers[tier];
    decoded = std::min(decoded, levels);
    const bool coarse = decoded < shape.levels() || tiers.size() < kWaveletTiers.size();
    const bool shaped = !block.support().empty();
    const bool fills = block.coded() && shaped && decoded < shape.levels();
    if (fills)
      wanted = {};
    if (block.coded()) {
      reconstruct(block.planes(), block.support(), block.mode(), shape, parameters_, stream_,
                  coarse, values, wanted);
    } else {
      std::ranges::fill(values, zero());
    }
    if (fills)
      fillUnknown(values, block.support(), block.mode(), shape, decoded,
                  sumsOf(means, block, shape));
    // The means of a block without shape reach beyond what is coded.
    if (parameters_.sparse && (!coarse || shaped || !block.coded()))
      applyStates(block.states(), block.outliers(), parameters_, stream_, values);
    block.correct(stream_, values);
    if (states && parameters_.sparse)
      *states = block.states();
    else if (states)
      states->assign(shape.voxels(), VoxelState::kActive);
    return {};
  }

  bool hasTopology() const override { return parameters_.sparse; }

  std::array<float, 3> background() const override {
    if (parameters_.extended)
      return parameters_.background;
    return {zero(), zero(), zero()};
  }

  Result<std::string> describe(Tiers tiers, const BlockShape& shape) const override {
    if (tiers.empty() || tiers[0].empty())
      return "empty";
    Contexts contexts = parameters_.contexts;
    ReadBits bits{contexts.data(), ArithmeticDecoder(tiers[0]), parameters_.bySymbols};
    BlockMode mode;
    if (!parameters_.sparse) {
      codeMode(bits, mode);
      return volute::describe(mode);
    }
    BlockStates states(shape.voxels(), VoxelState::kEmpty);
    std::vector<std::uint8_t> room;
    codeStates(bits, shape.extents, std::span(states), room);
    if (!bits.bit(context::kCoded, false))
      return "topology";
    std::vector<Outlier> outliers;
    codeOutliers(bits, shape, outliers);
    codeMode(bits, mode, std::ranges::all_of(states, [&](VoxelState state) {
               return isCoded(state, parameters_);
             }));
    return volute::describe(mode);
  }

 private:
  /// Of each channel over the coded voxels; none where the means are not known.
  std::vector<double> sumsOf(std::span<const float> means, const BlockReading& block,
                             const BlockShape& shape) const {
    std::vector<double> sums;
    for (std::size_t c = 0; c < means.size(); ++c) {
      double sum = static_cast<double>(means[c]) * static_cast<double>(shape.voxels());
      for (const VoxelState state : block.states()) {
        if (!isCoded(state, parameters_))
          sum -=
              state == VoxelState::kEmpty ? parameters_.background[c] : (*parameters_.inactive)[c];
      }
      for (const Outlier& outlier : block.outliers()) sum -= outlier.value[c];
      sums.push_back(sum);
    }
    return sums;
  }

  /// What coefficients of zero stand for.
  float zero() const { return std::min(stream_.valueMax, std::max(stream_.valueMin, 0.0f)); }

  WaveletParameters parameters_;
  StreamInfo stream_;
};

}  // namespace

Result<std::shared_ptr<const BlockDecoder>> openWaveletDecoder(
    std::uint32_t codec, std::span<const std::byte> parameters, const StreamInfo& stream) {
  VOLUTE_ASSIGN(auto read, readParameters(codec, parameters, stream.channels));
  return std::make_shared<const WaveletDecoder>(std::move(read), stream);
}

}  // namespace volute
