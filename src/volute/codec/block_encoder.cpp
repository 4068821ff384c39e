// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/block_encoder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "volute/base/assert.hpp"
#include "volute/codec/block_syntax.hpp"
#include "volute/codec/cell_field.hpp"
#include "volute/codec/cost_estimate.hpp"
#include "volute/codec/mode_search.hpp"
#include "volute/codec/symbol_coder.hpp"

namespace volute {
namespace {

// What a bit is worth, in squared quantisation steps: the slope of the error of a uniform
// quantiser, 1/6 log(2) = 0.1155, and some more, since most coefficients here are in its dead zone.
constexpr double kLambda = 0.16;
constexpr double kUnit = 4096;  // of prices: parts of a bit

/// -log2 of probabilities.
class Prices {
 public:
  /// The only one there need be. To be asked for once a block: a static takes a guard.
  static const Prices& get() {
    static const Prices prices;
    return prices;
  }

  std::uint32_t operator()(const AdaptiveBit& state, bool bit) const {
    const int one = (state.one + 8) >> 4;
    return of_[static_cast<std::size_t>(bit ? one : 4096 - one)];
  }

 private:
  Prices() {
    for (int i = 0; i <= 4096; ++i)
      of_[static_cast<std::size_t>(i)] =
          static_cast<std::uint32_t>(std::lround(-kUnit * std::log2(std::max(i, 1) / 4096.0)));
  }

  std::array<std::uint32_t, 4097> of_;  // of probabilities in 1/4096
};

/// The Bits of a writer.
struct WriteBits {
  Contexts& contexts;
  Training& training;
  ArithmeticEncoder out{};
  bool shared = false;  ///< the end of the string is not of bits

  bool bit(unsigned context, bool value) {
    training.counts.add(context, value);
    out.bit(contexts[context], value);
    return value;
  }

  bool even(bool value) {
    AdaptiveBit half;
    if (shared)
      out.bit(half, value);
    else
      out.even(value);
    return value;
  }
};

/// Symbols that are written.
struct WriteSymbols {
  SymbolCounts& counts;
  SymbolWriter out{};

  void symbol(unsigned context, unsigned symbol, unsigned lane) {
    ++counts[context][symbol];
    out.symbol(context, symbol, lane);
  }

  void bits(std::uint32_t value, int count, unsigned lane) { out.bits(value, count, lane); }

  void sign(bool negative) { out.sign(negative); }
};

/// Symbols that are counted and not kept.
struct PriceSymbols {
  const SymbolPrices& prices;
  std::uint64_t price = 0;

  void symbol(unsigned context, unsigned symbol, unsigned) { price += prices[context][symbol]; }

  void bits(std::uint32_t, int count, unsigned) {
    price += static_cast<std::uint64_t>(kUnit) * static_cast<unsigned>(count);
  }

  void sign(bool) { price += static_cast<std::uint64_t>(kUnit); }
};

/// A magnitude that is not 0, behind the symbol that says so. `context`: of that symbol.
template <class Symbols>
void codeEscape(Symbols& out, unsigned context, std::int32_t magnitude, unsigned lane) {
  const auto rest = static_cast<std::uint32_t>(magnitude - (symbol::kEscape - 1));
  const int length = static_cast<int>(std::bit_width(rest)) - 1;
  out.symbol(symbol::kLength + CellField::nearClassOf(context),
             static_cast<unsigned>(std::min(length, symbol::kEscape)), lane);
  if (length >= symbol::kEscape)
    out.symbol(symbol::kLonger, static_cast<unsigned>(length - symbol::kEscape), lane);
  const int low = std::min(length, 15);
  if (length > 15)
    out.bits(rest >> 15 & ((1u << (length - 15)) - 1), length - 15, lane);
  out.bits(rest & ((1u << low) - 1), low, lane);
}

/// The coefficients `existing` of a cell in which one is not zero, and before them that it is so.
template <class Symbols>
void codeCell(Symbols& out, unsigned context, const std::uint16_t contexts[16],
              std::uint16_t existing, const std::int32_t q[16], unsigned x) {
  out.symbol(context, 1, x % kLanes);
  std::uint8_t m[16] = {};
  for (unsigned i = 0; i < kCellOrder.size(); ++i) {
    const int k = kCellOrder[i];
    if ((existing >> k & 1) == 0)
      continue;
    const unsigned own = contexts[k] + siblingStep(siblingSum(k, m));
    const std::int32_t magnitude = std::abs(q[k]);
    const std::int32_t s = std::min(magnitude, symbol::kEscape);
    out.symbol(own, static_cast<unsigned>(s), i % kLanes);
    m[k] = static_cast<std::uint8_t>(s);
    if (s == symbol::kEscape)
      codeEscape(out, own, magnitude, i % kLanes);
    if (s != 0)
      out.sign(q[k] < 0);
  }
}

/// Bits that are counted and not kept.
struct PriceBits {
  Contexts& contexts;
  const Prices& prices = Prices::get();
  std::uint64_t price = 0;

  bool bit(unsigned context, bool value) {
    price += prices(contexts[context], value);
    contexts[context].learn(value);
    return value;
  }

  bool even(bool value) {
    price += static_cast<std::uint64_t>(kUnit);
    return value;
  }
};

/// Bits that teach nothing: what a magnitude would cost now.
struct AskBits {
  const Contexts& contexts;
  const Prices& prices;
  std::uint64_t price = 0;

  bool bit(unsigned context, bool value) {
    price += prices(contexts[context], value);
    return value;
  }

  bool even(bool value) {
    price += static_cast<std::uint64_t>(kUnit);
    return value;
  }
};

/// Chooses the quantised values of a cell: rounding down where that saves more bits than it costs
/// error, and nothing at all where the whole cell is not worth its bits.
class CellQuantiser {
 public:
  explicit CellQuantiser(const WaveletParameters& parameters) : parameters_(parameters) {}

  /// @param sizes  magnitudes in steps; `q`: rounded to the nearest on entry, chosen on return.
  void choose(const Contexts& contexts, const CellContext& c, std::uint16_t existing,
              const double sizes[16], std::int32_t q[16]) const {
    double kept = kLambda / kUnit * prices_(contexts[c.cell], true);
    double dropped = kLambda / kUnit * prices_(contexts[c.cell], false);
    std::uint8_t m[16] = {};
    for (unsigned left = existing; left != 0; left &= left - 1) {
      const int k = std::countr_zero(left);
      kept += chooseOne(contexts, c, k, m, sizes[k], q);
      m[k] = static_cast<std::uint8_t>(std::min(q[k], kRemembered));
      dropped += sizes[k] * sizes[k];
    }
    if (dropped < kept)
      std::fill(q, q + 16, 0);
  }

  /// The same where cells are coded by symbols.
  void choose(unsigned context, const std::uint16_t contexts[16], std::uint16_t existing,
              const double sizes[16], std::int32_t q[16]) const {
    const SymbolPrices& prices = parameters_.symbolPrices;
    double kept = kLambda / kUnit * prices[context][1];
    double dropped = kLambda / kUnit * prices[context][0];
    std::uint8_t m[16] = {};
    for (const int k : kCellOrder) {
      if ((existing >> k & 1) == 0)
        continue;
      const unsigned own = contexts[k] + siblingStep(siblingSum(k, m));
      const auto costOf = [&](std::int32_t magnitude) {
        PriceSymbols price{prices};
        price.symbol(own, static_cast<unsigned>(std::min(magnitude, symbol::kEscape)), 0);
        if (magnitude >= symbol::kEscape)
          codeEscape(price, own, magnitude, 0);
        if (magnitude > 0)
          price.sign(false);
        return squaredError(sizes[k], magnitude) +
               kLambda / kUnit * static_cast<double>(price.price);
      };
      double cost = costOf(q[k]);
      if (q[k] > 0) {
        const double lower = costOf(q[k] - 1);
        if (lower < cost) {
          cost = lower;
          --q[k];
        }
      }
      kept += cost;
      m[k] = static_cast<std::uint8_t>(std::min(q[k], symbol::kEscape));
      dropped += sizes[k] * sizes[k];
    }
    if (dropped < kept)
      std::fill(q, q + 16, 0);
  }

  double squaredError(double size, std::int32_t q) const {
    const double error = size - parameters_.shown(q);
    return error * error;
  }

 private:
  // The lesser of two candidates; gives its cost.
  double chooseOne(const Contexts& contexts, const CellContext& c, int k, const std::uint8_t m[16],
                   double size, std::int32_t q[16]) const {
    const unsigned siblings = CellContext::siblingsOf(k, m);
    const unsigned zero = c.zero(k, siblings);
    const unsigned context = c.size(k, siblings);
    const auto costOf = [&](std::int32_t candidate, std::uint64_t price) {
      return squaredError(size, candidate) + kLambda / kUnit * static_cast<double>(price);
    };
    const std::uint64_t ofZero = prices_(contexts[zero], false);
    if (q[k] == 0)
      return costOf(0, ofZero);
    const auto [price, ofLower] = pricesOf(contexts, zero, context, q[k]);
    const double cost = costOf(q[k], price);
    const double lower = costOf(q[k] - 1, q[k] == 1 ? ofZero : ofLower);
    if (lower >= cost)
      return cost;
    --q[k];
    return lower;
  }

  // What a magnitude of at least 1 costs with its sign, and what one less does.
  std::pair<std::uint64_t, std::uint64_t> pricesOf(const Contexts& contexts, unsigned zero,
                                                   unsigned context, std::int32_t q) const {
    const auto priceOf = [&](std::int32_t magnitude) {
      AskBits ask{contexts, prices_};
      ask.bit(zero, true);
      (void)codeMagnitude(ask, context, magnitude);
      ask.even(false);
      return ask.price;
    };
    if (q == 1)
      return {priceOf(1), 0};
    if (q > 15)
      return {priceOf(q), priceOf(q - 1)};
    // In unary, they begin alike.
    std::uint64_t common = prices_(contexts[zero], true) + static_cast<std::uint64_t>(kUnit);
    const auto at = [&](std::int32_t bit) -> const AdaptiveBit& {
      return contexts[context + static_cast<unsigned>(bit)];
    };
    for (std::int32_t bit = 1; bit < q - 1; ++bit) common += prices_(at(bit), true);
    return {common + prices_(at(q - 1), true) + prices_(at(q), false),
            common + prices_(at(q - 1), false)};
  }

  const Prices& prices_ = Prices::get();
  const WaveletParameters& parameters_;
};

// The greatest scaling coefficient, 4^4 times the greatest value and 1.13 of that with CDF 9/7,
// at the finest step, 2^-21 of that value, has kMaxBits.
std::int32_t rounded(double size) {
  constexpr double kGreatest = (1 << kMaxBits) - 1;
  return static_cast<std::int32_t>(std::min(size + 0.5, kGreatest));
}

std::vector<std::uint8_t> supportOf(std::span<const float> values, const BlockShape& shape) {
  std::vector<std::uint8_t> support(shape.voxels());
  const auto channels = static_cast<std::size_t>(shape.channels);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] != 0)
      support[i / channels] = 1;
  }
  return support;
}

// Without a branch for each voxel: which are active is seldom foreseen.
std::vector<std::uint8_t> supportOf(std::span<const VoxelState> states,
                                    const WaveletParameters& parameters) {
  std::vector<std::uint8_t> support(states.size());
  const std::uint8_t valued = isCoded(VoxelState::kValued, parameters);
  for (std::size_t i = 0; i < states.size(); ++i)
    support[i] = static_cast<std::uint8_t>((states[i] == VoxelState::kActive) |
                                           ((states[i] == VoxelState::kValued) & valued));
  return support;
}

/// Whether a value of the support is an outlier.
bool anyApart(std::span<const float> values, std::span<const std::uint8_t> support,
              std::size_t channels, const WaveletParameters& parameters) {
  const float low = parameters.outlierLow, high = parameters.outlierHigh;
  std::uint8_t any = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    any |= static_cast<std::uint8_t>(support[channels == 1 ? i : i / channels] &
                                     !((values[i] >= low) & (values[i] <= high)));
  return any != 0;
}

/// Takes the outliers of a block out of its values.
std::vector<Outlier> takeApart(std::span<float> values, std::span<const std::uint8_t> support,
                               std::size_t channels, const WaveletParameters& parameters) {
  std::vector<Outlier> outliers;
  if (!anyApart(values, support, channels, parameters))
    return outliers;
  for (std::size_t i = 0; i < support.size(); ++i) {
    const std::span<float> own = values.subspan(i * channels, channels);
    Outlier outlier{static_cast<std::uint32_t>(i)};
    std::ranges::copy(own, outlier.value.begin());
    bool apart = false;
    for (float& value : own) {
      const float kept = std::clamp(value, parameters.outlierLow, parameters.outlierHigh);
      apart = apart || kept != value;
      value = support[i] != 0 ? kept : value;
    }
    if (apart && support[i] != 0)
      outliers.push_back(outlier);
  }
  return outliers;
}

/// What the support of a block costs in codec 2.
double costOfSupport(const WaveletParameters& parameters, const BlockContent& block) {
  Contexts contexts(parameters.contexts);
  PriceBits bits{contexts};
  std::vector<std::uint8_t> support = block.support;
  codeSupport(bits, block.shape.extents, std::span(support));
  return kLambda / kUnit * static_cast<double>(bits.price);
}

/// The coefficients of a block in a mode.
std::vector<float> transformed(const WaveletParameters& parameters, const BlockContent& block,
                               const BlockMode& mode) {
  std::vector<float> planes = block.planes;
  const BlockShape& shape = block.shape;
  const std::size_t voxels = shape.voxels();
  const AxisLevels levels = blockLevels(shape.extents, mode.timeLevels);
  std::span<const std::uint8_t> support;
  if (mode.shaped)
    support = block.support;
  for (std::size_t begin = 0; begin < planes.size(); begin += voxels) {
    const std::span<float> plane = std::span(planes).subspan(begin, voxels);
    for (std::size_t i = 0; parameters.sparse && i < support.size(); ++i)
      plane[i] = support[i] != 0 ? plane[i] : 0;
    shapeForward(plane, support, shape.extents, mode.wavelet, levels);
  }
  return planes;
}

/// A block in one mode: its coefficients, and the way they are put into bits.
class BlockWriting {
 public:
  /// @param keeps  whether planes() will be asked for what was quantised.
  BlockWriting(const WaveletParameters& parameters, const BlockContent& block,
               const BlockMode& mode, bool keeps)
      : parameters_(parameters),
        keeps_(keeps),
        full_(block.full),
        quantiser_(parameters),
        shape_(block.shape),
        mode_(mode),
        planes_(transformed(parameters, block, mode)),
        contexts_(parameters.contexts) {
    if (mode.shaped)
      support_ = block.support;
    walk_.emplace(shape_, mode_, support_, memories_);
    thread_local std::array<ComponentFields, 3> fields;  // as costly to get as to use
    fieldWalk_.emplace(shape_, mode_, support_, fields);
  }

  Contexts& contexts() { return contexts_; }

  TierStrides strides(std::size_t tier) const {
    return stridesOfTier(shape_, tier, shape_.levels());
  }

  /// Whether a tier has a coefficient that may not be zero.
  bool hasAny(std::size_t tier);

  /// Codes the head, if the tier has it, and the coefficients.
  template <class Bits>
  void code(Bits& bits, std::size_t tier, Training* training);

  /// The same in two, where cells are coded by symbols.
  template <class Bits>
  void codeHead(Bits& bits);
  template <class Symbols>
  void codeSymbols(Symbols& out, std::size_t tier, Training* training);

  /// Goes past a tier that is left out.
  void skip(std::size_t tier);

  /// In squared steps, of what was coded so far.
  double squaredError() const { return squaredError_; }

  /// What the coefficients so far were quantised to, if that is kept.
  std::span<float> planes() { return planes_; }

  std::span<const std::uint8_t> support() const { return support_; }

 private:
  std::span<float> plane(int c) {
    return std::span(planes_).subspan(c * shape_.voxels(), shape_.voxels());
  }

  bool hasAny(const CellLevel& level, const float* plane) const;

  template <class Bits>
  bool codeOneCell(Bits& bits, float* at, const CellLevel& level, std::uint16_t existing,
                   CellContext& context, const auto& neighbours, std::int32_t* q,
                   Training* training);
  void settle(float& coefficient, double norm, double size, std::int32_t q, Training* training);
  void settleZeros(const CellLevel& level, float* at, std::uint16_t existing);

  /// Of a level: what a coefficient is worth in steps.
  const std::array<double, 16>& inSteps(const CellLevel& level) {
    if (level.stride != inStepsOf_) {
      for (std::size_t k = 0; k < 16; ++k) inSteps_[k] = level.norm[k] / parameters_.step;
      inStepsOf_ = level.stride;
    }
    return inSteps_;
  }

  const WaveletParameters& parameters_;
  bool keeps_;
  bool full_;
  int inStepsOf_ = -1;
  std::array<double, 16> inSteps_{};
  CellQuantiser quantiser_;
  BlockShape shape_;
  BlockMode mode_;
  std::vector<float> planes_;
  std::vector<std::uint8_t> support_;
  Contexts contexts_;
  std::array<ComponentMemory, 3> memories_;
  std::optional<BlockWalk> walk_;
  std::optional<FieldWalk> fieldWalk_;
  double squaredError_ = 0;
};

bool BlockWriting::hasAny(const CellLevel& level, const float* plane) const {
  const double enough = 0.5 * parameters_.step;
  BlockGrid::Index4 cell{};
  for (cell[0] = 0; cell[0] < level.cells[0]; ++cell[0])
    for (cell[1] = 0; cell[1] < level.cells[1]; ++cell[1])
      for (cell[2] = 0; cell[2] < level.cells[2]; ++cell[2]) {
        cell[3] = 0;
        const std::uint16_t inRow = level.existingInRow(cell);
        std::ptrdiff_t position = level.position(cell);
        for (; cell[3] < level.cells[3]; ++cell[3], position += level.step[3]) {
          std::uint16_t existing = inRow;
          if (level.cut[3] && cell[3] == level.cells[3] - 1)
            existing = static_cast<std::uint16_t>(existing & ~level.high[3]);
          if (!support_.empty())
            existing = level.within(support_.data() + position, existing);
          for (unsigned left = existing; left != 0; left &= left - 1) {
            const int k = std::countr_zero(left);
            if (std::abs(plane[position + level.offset[k]]) * level.norm[k] >= enough)
              return true;
          }
        }
      }
  return false;
}

bool BlockWriting::hasAny(std::size_t tier) {
  const TierStrides range = strides(tier);
  if (range.scaling)
    return true;
  const AxisLevels levels = blockLevels(shape_.extents, mode_.timeLevels);
  for (int stride = range.first; stride > range.end; --stride) {
    if (stride >= deepest(levels))
      continue;
    const CellLevel level(shape_.extents, levels, stride, mode_.wavelet);
    for (int c = 0; c < shape_.channels; ++c) {
      if (hasAny(level, plane(c).data()))
        return true;
    }
  }
  return false;
}

inline void BlockWriting::settle(float& coefficient, double norm, double size, std::int32_t q,
                                 Training* training) {
  squaredError_ += quantiser_.squaredError(size, q);
  const std::int32_t m = std::abs(q);
  if (training != nullptr && m > 0) {
    const auto parts = static_cast<std::int64_t>(std::lround(65536 * (size - (m > 1 ? m : 0))));
    (m == 1 ? training->oneSum : training->moreSum) += parts;
    ++(m == 1 ? training->oneCount : training->moreCount);
  }
  if (keeps_) {
    const double shown = parameters_.shown(q) * (parameters_.step / norm);
    coefficient = static_cast<float>(q < 0 ? -shown : shown);
  }
}

template <class Bits>
void BlockWriting::codeHead(Bits& bits) {
  codeMode(bits, mode_, parameters_.sparse && full_);
  if (mode_.shaped && !parameters_.sparse)
    codeSupport(bits, shape_.extents, support_);
  walk_->scaling([&](int c, std::ptrdiff_t position, double norm) {
    float& value = plane(c)[position];
    const double size = std::abs(value) * (norm / parameters_.step);
    const std::int32_t q =
        codeNumber(bits, context::kScaling, value < 0 ? -rounded(size) : rounded(size));
    settle(value, norm, size, q, nullptr);
  });
}

template <class Bits>
bool BlockWriting::codeOneCell(Bits& bits, float* at, const CellLevel& level,
                               std::uint16_t existing, CellContext& context, const auto& neighbours,
                               std::int32_t* q, Training* training) {
  double sizes[16] = {};
  double greatest = 0;
  const auto& inSteps = this->inSteps(level);
  for (unsigned left = existing; left != 0; left &= left - 1) {
    const int k = std::countr_zero(left);
    sizes[k] = std::abs(at[level.offset[k]]) * inSteps[static_cast<std::size_t>(k)];
    greatest = std::max(greatest, sizes[k]);
  }
  bool any = rounded(greatest) != 0;
  if (!any && !keeps_) {  // most cells
    double sum = squaredError_;
    for (unsigned left = existing; left != 0; left &= left - 1) {
      const int k = std::countr_zero(left);
      sum += sizes[k] * sizes[k];
    }
    squaredError_ = sum;
    bits.bit(context.cell, false);
    return false;
  }
  if (any) {
    for (unsigned left = existing; left != 0; left &= left - 1) {
      const int k = std::countr_zero(left);
      q[k] = rounded(sizes[k]);
    }
    neighbours();
    quantiser_.choose(contexts_, context, existing, sizes, q);
    any = std::any_of(q, q + 16, [](std::int32_t value) { return value != 0; });
  }
  for (unsigned left = existing; left != 0; left &= left - 1) {
    const int k = std::countr_zero(left);
    float& value = at[level.offset[k]];
    if (value < 0)
      q[k] = -q[k];
    settle(value, level.norm[k], sizes[k], q[k], training);
  }
  bits.bit(context.cell, any);
  if (any)
    codeMembers(bits, context, existing, q);
  return any;
}

template <class Bits>
void BlockWriting::code(Bits& bits, std::size_t tier, Training* training) {
  const TierStrides range = strides(tier);
  if (range.scaling)
    codeHead(bits);
  walk_->cells(range,
               [&](int c, const CellLevel& level, std::ptrdiff_t position, std::uint16_t existing,
                   CellContext& context, const auto& neighbours, std::int32_t* q) {
                 return codeOneCell(bits, plane(c).data() + position, level, existing, context,
                                    neighbours, q, training);
               });
}

void BlockWriting::settleZeros(const CellLevel& level, float* at, std::uint16_t existing) {
  const auto& inSteps = this->inSteps(level);
  for (unsigned left = existing; left != 0; left &= left - 1) {
    const int k = std::countr_zero(left);
    const double size = std::abs(at[level.offset[k]]) * inSteps[static_cast<std::size_t>(k)];
    settle(at[level.offset[k]], level.norm[k], size, 0, nullptr);
  }
}

template <class Symbols>
void BlockWriting::codeSymbols(Symbols& out, std::size_t tier, Training* training) {
  fieldWalk_->cells(
      strides(tier), [](auto&&...) {},
      [&](int c, const CellLevel& level, CellField& field, std::ptrdiff_t place,
          std::ptrdiff_t position, std::uint16_t existing, unsigned context,
          const CellField::Entry* parent, unsigned x) {
        float* at = plane(c).data() + position;
        double sizes[16] = {};
        std::int32_t q[16] = {};
        double greatest = 0;
        const auto& inSteps = this->inSteps(level);
        for (unsigned left = existing; left != 0; left &= left - 1) {
          const auto k = static_cast<std::size_t>(std::countr_zero(left));
          sizes[k] = std::abs(at[level.offset[k]]) * inSteps[k];
          greatest = std::max(greatest, sizes[k]);
        }
        bool any = rounded(greatest) != 0;
        std::uint16_t contexts[16];
        if (any) {
          for (std::size_t k = 1; k < 16; ++k) q[k] = rounded(sizes[k]);
          field.contexts(place, parent, static_cast<unsigned>(level.stride), contexts);
          quantiser_.choose(context, contexts, existing, sizes, q);
          any = std::any_of(q, q + 16, [](std::int32_t value) { return value != 0; });
        }
        if (!any) {
          out.symbol(context, 0, x % kLanes);
          settleZeros(level, at, existing);
          return;
        }
        unsigned sum = 0;
        std::uint8_t m[16] = {};
        for (unsigned left = existing; left != 0; left &= left - 1) {
          const auto k = static_cast<std::size_t>(std::countr_zero(left));
          float& value = at[level.offset[k]];
          m[k] = static_cast<std::uint8_t>(std::min(q[k], kRemembered));
          sum += m[k];
          if (value < 0)
            q[k] = -q[k];
          settle(value, level.norm[k], sizes[k], q[k], training);
        }
        codeCell(out, context, contexts, existing, q, x);
        field.remember(place, m, sum);
      });
}

void BlockWriting::skip(std::size_t tier) {
  if (parameters_.bySymbols) {
    fieldWalk_->cells(
        strides(tier), [](auto&&...) {},
        [&](int c, const CellLevel& level, CellField&, std::ptrdiff_t, std::ptrdiff_t position,
            std::uint16_t existing,
            auto&&...) { settleZeros(level, plane(c).data() + position, existing); });
    return;
  }
  walk_->cells(strides(tier), [&](int c, const CellLevel& level, std::ptrdiff_t position,
                                  std::uint16_t existing, const auto&, const auto&, const auto*) {
    settleZeros(level, plane(c).data() + position, existing);
    return false;
  });
}

// The simplest mode that codes a block as `mode` does: a full block has no shape, and time has no
// more halvings than there are frames for.
BlockMode simplest(BlockMode mode, const BlockShape& shape, bool full) {
  const int halvings = blockLevels(shape.extents, 4)[0];
  mode.shaped = mode.shaped && !full;
  if (halvings <= 2)
    mode.timeLevels = std::min(mode.timeLevels, halvings);
  return mode;
}

// Original - shown, in steps of correction, where it is too much.
std::vector<std::int32_t> correctionsOf(std::span<const float> values, std::span<const float> shown,
                                        const WaveletParameters& parameters) {
  constexpr double kGreatest = (1 << (kMaxBits - 2)) - 1;
  std::vector<std::int32_t> corrections(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double error = static_cast<double>(values[i]) - shown[i];
    if (std::abs(error) <= parameters.maxError)
      continue;
    const double steps = std::round(error / parameters.correctionStep());
    corrections[i] = static_cast<std::int32_t>(std::clamp(steps, -kGreatest, kGreatest));
  }
  return corrections;
}

// Codes what the coefficients left too far from the values; says whether there was anything.
bool codeCorrectionsOf(WriteBits& bits, BlockWriting& block, const BlockShape& shape,
                       const BlockMode& mode, std::span<const float> values,
                       std::span<const VoxelState> states, std::span<const Outlier> outliers,
                       const WaveletParameters& parameters, const StreamInfo& stream) {
  std::vector<float> shown(values.size());
  reconstruct(block.planes(), block.support(), mode, shape, parameters, stream, false, shown);
  if (parameters.sparse)
    applyStates(states, outliers, parameters, stream, shown);
  auto corrections = correctionsOf(values, shown, parameters);
  const bool any = std::ranges::any_of(corrections, [](std::int32_t c) { return c != 0; });
  bits.bit(context::kEnd, any);
  if (any)
    codeCorrections(bits, shape, std::span(corrections));
  return any;
}

/// What it costs to leave a block out.
/// @param bent  the values without outliers
double costOfNothing(const BlockContent& block, std::span<const float> bent,
                     const WaveletParameters& parameters, const StreamInfo& stream) {
  constexpr double kTooMuch = std::numeric_limits<double>::infinity();
  if (!block.outliers.empty())
    return kTooMuch;
  const float nothing = std::min(stream.valueMax, std::max(stream.valueMin, 0.0f));
  const auto channels = static_cast<std::size_t>(block.shape.channels);
  const auto counts = [&](std::size_t i) {
    return !parameters.sparse || block.support[channels == 1 ? i : i / channels] != 0;
  };
  for (std::size_t i = 0; parameters.maxError > 0 && i < bent.size(); ++i) {
    if (counts(i) && std::abs(static_cast<double>(block.values[i]) - nothing) > parameters.maxError)
      return kTooMuch;
  }
  const double bentNothing = parameters.bends() ? parameters.bent(nothing) : nothing;
  std::array<double, 8> sums{};  // so that no sum waits for the one before
  for (std::size_t i = 0; i < bent.size(); ++i) {
    const double error = counts(i) * (bent[i] - bentNothing);
    sums[i % sums.size()] += error * error;
  }
  const double step = parameters.step * parameters.unit();
  return std::accumulate(sums.begin(), sums.end(), 0.0) / (step * step);
}

}  // namespace

void Training::add(const Training& other) {
  counts.add(other.counts);
  if (symbols.empty())
    symbols = other.symbols;
  else if (!other.symbols.empty())
    for (std::size_t i = 0; i < symbols.size(); ++i)
      for (std::size_t s = 0; s < symbols[i].size(); ++s) symbols[i][s] += other.symbols[i][s];
  const auto own = sums();
  const auto theirs = other.sums();
  for (std::size_t i = 0; i < own.size(); ++i) *own[i] += *theirs[i];
}

void Training::apply(WaveletParameters& parameters) const {
  const auto mean = [](std::int64_t sum, std::int64_t count) {
    return static_cast<int>(
        std::lround(static_cast<double>(sum) / static_cast<double>(count) / 256));
  };
  if (oneCount > 0)
    parameters.one = std::clamp(mean(oneSum, oneCount), 128, 384);
  if (moreCount > 0)
    parameters.more = std::clamp(mean(moreSum, moreCount), -128, 128);
  if (oneCount + moreCount > 0)
    parameters.coefficientBits =
        static_cast<double>(bits) / static_cast<double>(oneCount + moreCount);
  parameters.table = contextTable(counts);
  parameters.contexts = contextsOf(parameters.table);
  if (!parameters.bySymbols || symbols.empty())
    return;
  parameters.symbolTable = symbolTable(symbols);
  parameters.symbols = symbolsOfTable(parameters.symbolTable);
  parameters.symbolPrices = pricesOf(parameters.symbols);
}

BlockContent BlockEncoder::contentOf(std::span<const float> values, const BlockShape& shape,
                                     std::span<const VoxelState> states) const {
  VOLUTE_ASSERT(values.size() == shape.values() && parameters_.sparse == !states.empty());
  BlockContent block{shape, values, states};
  std::vector<float> coded(values.begin(), values.end());
  if (states.empty()) {
    block.support = supportOf(values, shape);
  } else {
    block.support = supportOf(states, parameters_);
    const auto channels = static_cast<std::size_t>(shape.channels);
    block.outliers = takeApart(coded, block.support, channels, parameters_);
  }
  block.full = std::ranges::find(block.support, 0) == block.support.end();
  if (parameters_.bends()) {
    for (float& value : coded) value = parameters_.bent(value);
  }
  block.costOfNothing = costOfNothing(block, coded, parameters_, stream_);
  block.planes = parameters_.color.split(coded, shape.channels, parameters_.unit());
  return block;
}

std::optional<BlockMode> BlockEncoder::choose(const BlockContent& block,
                                              const ModeChoice& choice) const {
  VOLUTE_ASSERT(!choice.candidates.empty());
  const double leftOut = block.costOfNothing;
  if (leftOut == 0)
    return std::nullopt;
  if (choice.candidates.size() == 1)
    return choice.candidates.front();
  const auto costOf = [&](const BlockMode& mode) {
    BlockWriting writing(parameters_, block, mode, false);
    PriceBits bits{writing.contexts()};
    PriceSymbols symbols{parameters_.symbolPrices};
    if (parameters_.bySymbols)
      writing.codeHead(bits);
    for (std::size_t tier = 0; tier < kWaveletTiers.size(); ++tier) {
      if (!writing.hasAny(tier))
        writing.skip(tier);
      else if (parameters_.bySymbols)
        writing.codeSymbols(symbols, tier, nullptr);
      else
        writing.code(bits, tier, nullptr);
    }
    return writing.squaredError() +
           kLambda / kUnit * static_cast<double>(bits.price + symbols.price);
  };
  const CostEstimate estimate(parameters_, kLambda);
  std::optional<double> ofSupport;  // codec 3 has its topology in any mode
  const auto estimateOf = [&](const BlockMode& mode) {
    if (mode.shaped && !ofSupport)
      ofSupport = parameters_.sparse ? 0 : costOfSupport(parameters_, block);
    return estimate.of(transformed(parameters_, block, mode), block.shape, mode) +
           (mode.shaped ? *ofSupport : 0);
  };
  const bool estimated = choice.coded != ModeChoice::kAll;
  const auto simple = [&](const BlockMode& mode) {
    return simplest(mode, block.shape, block.full);
  };
  ModeSearch search(choice.candidates, simple,
                    estimated ? ModeSearch::CostOf(estimateOf) : ModeSearch::CostOf(costOf));
  for (const BlockMode& mode : choice.starts) search.tryMode(mode);
  if (choice.starts.empty())
    search.tryAll();
  search.descend();
  if (!estimated || choice.coded == 0)
    return search.minCost() < leftOut ? search.best() : std::nullopt;
  ModeSearch coded(search.cheapest(static_cast<std::size_t>(choice.coded)), simple, costOf);
  coded.tryAll();
  return coded.minCost() < leftOut ? coded.best() : std::nullopt;
}

void BlockEncoder::addLengthCosts(const BlockContent& block, LengthCosts& lengths) const {
  const CostEstimate estimate(parameters_, kLambda);
  const BlockShape& shape = block.shape;
  const std::size_t voxels = shape.voxels() / static_cast<std::size_t>(shape.extents[0]);
  const auto costOf = [&](int first, int frames, int timeLevels) {
    BlockShape part = shape;
    part.extents[0] = std::min(frames, shape.extents[0] - first);
    const std::size_t begin = static_cast<std::size_t>(first) * voxels;
    const auto channels = static_cast<std::size_t>(shape.channels);
    const BlockContent content =
        contentOf(block.values.subspan(begin * channels, part.values()), part,
                  block.states.empty() ? block.states : block.states.subspan(begin, part.voxels()));
    const BlockMode mode{parameters_.sparse && !content.full, Wavelet::kCdf53, timeLevels};
    return estimate.of(transformed(parameters_, content, mode), part, mode);
  };
  constexpr int kShortest = LengthCosts::kFrames.back();
  std::array<double, BlockGrid::kSide / kShortest> still{};  // without time levels
  for (int first = 0; first < shape.extents[0]; first += kShortest)
    still[static_cast<std::size_t>(first / kShortest)] = costOf(first, kShortest, 0);
  for (std::size_t i = 0; i < lengths.costs.size(); ++i) {
    const int frames = LengthCosts::kFrames[i];
    double all = 0;
    for (int first = 0; first < shape.extents[0]; first += frames) {
      double apart = 0;
      for (int t = first; t < std::min(first + frames, shape.extents[0]); t += kShortest)
        apart += still[static_cast<std::size_t>(t / kShortest)];
      all += std::min(apart, costOf(first, frames, 4));
    }
    lengths.costs[i] += std::llround(256 * all / kLambda);
  }
  ++lengths.blocks;
}

std::vector<std::vector<std::byte>> BlockEncoder::encode(const BlockContent& block,
                                                         const std::optional<BlockMode>& mode,
                                                         Training& training) const {
  const BlockShape& shape = block.shape;
  std::vector<std::vector<std::byte>> tiers(kWaveletTiers.size());
  BlockStates topology(block.states.begin(), block.states.end());
  std::vector<std::uint8_t> room;
  if (!mode) {
    if (!parameters_.sparse)
      return tiers;
    Contexts contexts(parameters_.contexts);
    WriteBits bits{contexts, training, {}, parameters_.bySymbols};
    codeStates(bits, shape.extents, std::span(topology), room);
    bits.bit(context::kCoded, false);
    tiers[0] = bits.out.finish();
    if (tiers[0].empty())
      tiers[0].push_back(std::byte{0});
    return tiers;
  }
  if (parameters_.bySymbols)
    training.symbols.resize(symbol::kCount);
  const BlockMode simple = simplest(*mode, shape, block.full && parameters_.sparse);
  BlockWriting writing(parameters_, block, parameters_.sparse ? simple : *mode,
                       parameters_.maxError > 0);
  std::size_t others = 0;  // bytes that are not of coefficients
  for (std::size_t tier = 0; tier < tiers.size(); ++tier) {
    const bool last = tier + 1 == tiers.size();
    const bool corrects = last && parameters_.maxError > 0;
    WriteBits bits{writing.contexts(), training, {}, parameters_.bySymbols};
    WriteSymbols symbols{training.symbols};
    if (tier == 0 && parameters_.sparse) {
      codeStates(bits, shape.extents, std::span(topology), room);
      bits.bit(context::kCoded, true);
      std::vector<Outlier> outliers = block.outliers;
      codeOutliers(bits, shape, outliers);
      others = bits.out.size();
    }
    bool any = writing.hasAny(tier);
    if (parameters_.bySymbols && tier == 0)
      writing.codeHead(bits);
    if ((any || corrects) && parameters_.bySymbols)
      writing.codeSymbols(symbols, tier, &training);
    else if (any || corrects)
      writing.code(bits, tier, &training);
    if (corrects)
      any |= codeCorrectionsOf(bits, writing, shape, parameters_.sparse ? simple : *mode,
                               block.values, block.states, block.outliers, parameters_, stream_);
    if (!any) {
      if (!last)
        writing.skip(tier);
      continue;
    }
    if (!parameters_.bySymbols || tier == 0 || corrects)
      tiers[tier] = bits.out.finish();
    if (parameters_.bySymbols) {
      const auto coded = symbols.out.finish(parameters_.symbols);
      tiers[tier].insert(tiers[tier].end(), coded.begin(), coded.end());
    }
    if (tiers[tier].empty())
      tiers[tier].push_back(std::byte{0});
    training.bits += 8 * static_cast<std::int64_t>(tiers[tier].size());
  }
  training.bits -= 8 * static_cast<std::int64_t>(others);
  return tiers;
}

}  // namespace volute
