// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <tuple>

#include "volute/base/content_hash.hpp"
#include "volute/base/gather_values.hpp"
#include "volute/base/parallel.hpp"
#include "volute/codec/compressor.hpp"

namespace volute {
namespace {

/// Tables of symbols are worth their bytes, and learn enough, from so many blocks on.
constexpr std::uint64_t kBlocksForSymbols = 32;

// How much shorter blocks may add to a file where nothing says what is read.
constexpr double kLittle = 0.005;
// Bytes of a block beside its coefficients: its place in the index, checksums, ends of strings.
constexpr double kBytesABlock = 32;

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

}  // namespace

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
  row_.visitValues([&](float value, std::uint64_t count, bool tile) {
    tile ? histogram_.add(value, count) : histogram_.addVoxel(value);
    const double number = parameters_.offset + value;
    floats_ = floats_ && number == static_cast<double>(static_cast<float>(number));
  });
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
  for (auto* const sums : histogram_.sums()) VOLUTE_TRY(team_.sum(*sums));
  VOLUTE_ASSIGN(const auto facts, gatherValues(team_, std::span<const SupportFacts>(facts_)));
  const std::size_t frames = facts_.size();
  for (std::size_t i = 0; i < frames; ++i) facts_[i] = {};
  for (std::size_t i = 0; i < facts.size(); ++i) facts_[i % frames].add(facts[i]);

  struct Known {
    BlockRow::InactiveValue inactive;
    std::array<float, 3> background{};
    bool loaded = false;
    double rounding = 0;
    bool floats = false;
  };

  const Known own{inactive_, row_.background(), !row_.facts().empty(), row_.rounding(), floats_};
  VOLUTE_ASSIGN(const auto known, gatherValues(team_, std::span<const Known>(&own, 1)));
  inactive_ = {};
  for (const Known& one : known) {
    inactive_.add(one.inactive);
    rounding_ = std::max(rounding_, one.rounding);
    floats_ = floats_ && one.floats;
    if (one.loaded)
      parameters_.background = one.background;
  }
  floats_ = floats_ || (options_.floats && parameters_.offset != 0);
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
  sampleModes_.assign(modes_.size(), {});
}

// As few frames as cost little, after a first pass over some blocks.
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
  // What is the same all over is as good as exact, however much there is of it.
  constexpr double kMaxDilution = 256;
  const auto varied = static_cast<double>(histogram_.varied(support_.high - support_.low));
  if (overSupport && varied > 0 && !options_.target.even)
    dilution_ = std::clamp(std::sqrt(supportVoxels_ * info_.channels / varied), 1.0, kMaxDilution);
  const double spread = overSupport ? supportVoxels_ / (dilution_ * dilution_) : voxels;
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
    const double number = parameters_.offset + value;
    const double spacing = std::ldexp(1.0, std::max(std::ilogb(number), kMinExponent) - kBits);
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

}  // namespace volute
