// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/base/version.hpp"
#include "volute/codec/block_row.hpp"
#include "volute/codec/coefficient_coder.hpp"
#include "volute/codec/compress.hpp"
#include "volute/codec/compression_goal.hpp"
#include "volute/codec/container.hpp"
#include "volute/codec/effort_plan.hpp"
#include "volute/codec/encoded_units.hpp"
#include "volute/codec/parallel_try.hpp"
#include "volute/codec/unit_plan.hpp"
#include "volute/codec/unit_store.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/grid/value_histogram.hpp"

namespace volute {

/// Blocks encoded before their bytes go to the spools; bounds the memory of a row of many blocks.
constexpr std::size_t kBatchOfBlocks = 64;
/// Of a grid with more blocks than this to a row a part of them tells what all are like.
constexpr std::size_t kManyBlocks = 2048;
/// At least so many blocks tell it.
constexpr std::uint64_t kFewBlocks = 96;
/// How the step goes with the error, where nothing tells it.
constexpr double kErrorPower = 1.2;

/// The modes that these options leave to choose from; at least one.
std::vector<BlockMode> modesToTry(const CompressOptions& options);

/// One call of compress(). Goes through the blocks several times: to survey the values; to learn
/// from some of them what quantised coefficients are like, and which step meets the target; to
/// choose the mode of each block; and to encode them all, until the step does. All ranks of a team
/// go through them together; after each pass they share what they found, and rank 0's decisions are
/// those of all.
class Compressor {
 public:
  Compressor(FrameSource& source, const std::filesystem::path& target,
             const CompressOptions& options, int layersAUnit, Progress& progress, Team& team)
      : target_(target),
        name_(options.name.empty() ? target.string() : options.name),
        options_(options),
        progress_(progress),
        team_(team),
        info_(source.info()),
        row_(source),
        layersAUnit_(layersAUnit),
        plan_(row_.grid(), layersAUnit),
        goal_(options.target, info_),
        modes_(static_cast<std::size_t>(plan_.count())),
        sampleModes_(modes_.size()),
        sampled_(row_.grid().rowCount() > kManyBlocks),
        effort_(planOf(options.effort, sampled_)),
        units_(plan_, team) {
    head_.info = info_;
    // A field that states no topology, judged over all of its voxels, pays for none.
    const bool overAll = options.target.kind == ErrorTarget::Kind::kRmsOverAll ||
                         options.target.kind == ErrorTarget::Kind::kPsnr;
    parameters_.extended = true;
    parameters_.means = true;
    parameters_.sparse = source.hasTopology() || !overAll;
    parameters_.offset = offsetOf(source);
    floats_ = parameters_.offset != 0;
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

  // One pass over the blocks: over all of them, or, for kLearn and kTry, over a sample.
  enum class Pass { kLearn, kTry, kChoose, kEncode };

  static bool overSample(Pass pass) { return pass == Pass::kLearn || pass == Pass::kTry; }

  static bool choosesModes(Pass pass) { return pass == Pass::kTry || pass == Pass::kChoose; }

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
  Status encodeAll(double step, Pass pass);
  Status openStore();
  Status doUnit(std::int64_t number, Pass pass);
  Status encodeUnit(Pass pass, EncodedUnits::Unit& done, EncodedUnitRecord& record);
  std::vector<std::optional<BlockMode>>& modesOf(Pass pass, std::int64_t unit, std::size_t blocks);
  Status keep(Pass pass, const EncodedUnits::Unit& done, EncodedUnitRecord& record);
  Result<std::optional<EncodedUnitRecord>> recall(Pass pass, EncodedUnits::Unit& done);
  Status shareErrors();
  Status shareTraining();
  Status shareDone(Pass pass);
  Status shareModes(Pass pass);
  Status shareSegments();
  std::optional<BlockMode> chooseMode(const BlockContent& block, const BlockEncoder& encoder,
                                      const std::optional<BlockMode>& before) const;
  template <bool kFloats>
  std::size_t findErrors(std::span<const float> values, std::span<const float> decoded,
                         std::span<const VoxelState> states, const BlockShape& shape,
                         CodingError& errors) const;
  Result<EncodedBlock> encodeBlock(std::size_t block, std::optional<BlockMode>& mode, Pass pass,
                                   Training& training);
  std::vector<std::int64_t> meansOf(std::span<const float> values) const;
  Status checkCancelled() const;
  Status searchStep(double first);
  Status searchSmallest();
  double withinFloats(double maxError) const;
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
  std::string name_;  // of the target, in errors
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
  Training training_;                                               // of the last pass
  std::vector<std::vector<std::optional<BlockMode>>> modes_;        // of each unit, of its blocks
  std::vector<std::vector<std::optional<BlockMode>>> sampleModes_;  // the same, of some blocks
  BlockMode usualMode_;
  std::vector<SupportFacts> facts_;    // of each frame
  ValueHistogram histogram_;           // of the support's values
  std::vector<LayerMoments> moments_;  // of the units that this rank surveyed
  BlockRow::InactiveValue inactive_;
  SupportError support_;
  double supportVoxels_ = 0;  // of all frames
  double dilution_ = 1;       // how much greater the RMS is of what differs from place to place
  bool sampled_ = false;      // so many blocks to a row that a part of them is surveyed
  EffortPlan effort_;
  std::uint64_t blocks_ = 0;                                           // that hold something
  std::array<std::uint64_t, LengthCosts::kFrames.size()> blocksBy_{};  // the same, by their frames
  std::uint64_t oneOf_ = 1;     // of so many one tells what all are like
  double doneShare_ = 1;        // share of the support that the last pass covered
  double power_ = kErrorPower;  // how the step goes with the error
  bool chosenBefore_ = false;   // modes_ are those of another step, else a guess
  double chosenStep_ = 0;       // at which modes_ were chosen
  bool stepsAlike_ = false;     // the same and that before
  QuantisationModel model_;
  std::optional<UnitStore> store_;  // of finished units, where that is asked for
  std::uint64_t content_ = 0;       // a digest of all values, for it
  int pass_ = -1;                   // number of passes over the units before this one
  EncodedUnits units_;              // of the last pass
  std::vector<LayerError> layers_;  // the same, of this rank
  std::uint64_t fileBytes_ = 0;     // as far as it was asked for
  CodingError error_;
  std::vector<double> frameSquares_;  // the squares of it, frame by frame
  double relativeRms_ = 0;            // of the last pass over all blocks
  double rounding_ = 0;               // of the values, roundingOf() the source
  bool floats_ = false;               // values with the offset are floats, as which they come back
  int tries_ = 0;
};

}  // namespace volute
