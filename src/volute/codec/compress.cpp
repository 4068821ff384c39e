// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/compress.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <mutex>
#include <numeric>
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
#include "volute/codec/encoded_units.hpp"
#include "volute/codec/parallel_try.hpp"
#include "volute/codec/step_search.hpp"
#include "volute/codec/unit_plan.hpp"
#include "volute/codec/unit_store.hpp"
#include "volute/codec/written_file.hpp"

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
        goal_(options.target, info_),
        units_(plan_, row_.grid().count(), team) {
    head_.info = info_;
    head_.header.codec = kWaveletCodec;
    head_.header.writtenBy = "volute " VOLUTE_VERSION;
    head_.header.provenance = options.provenance;
    head_.header.targetKind = nameOf(options.target.kind);
    head_.header.targetValue = options.target.value;
  }

  Result<CompressReport> run();

 private:
  // One way through all rows of blocks, or some of them.
  enum class Way { kLearn, kChoose, kEncode };

  Status survey();
  Status encodeAll(double step, Way way);
  Status openStore();
  Status doUnit(std::int64_t number, Way way);
  Status encodeUnit(Way way, EncodedUnits::Unit& done, EncodedUnitRecord& record);
  std::span<std::optional<BlockMode>> modesOf(std::int64_t unit);
  Status keep(const EncodedUnits::Unit& done, EncodedUnitRecord& record);
  Result<std::optional<EncodedUnitRecord>> recall(EncodedUnits::Unit& done);
  Status shareErrors();
  Status shareTraining();
  Status shareModes();
  Status shareSegments();
  std::optional<BlockMode> chooseMode(std::size_t block, std::span<const float> values,
                                      const BlockEncoder& encoder, bool near) const;
  Result<EncodedBlock> encodeBlock(std::size_t block, Way way, Training& training);
  Status checkCancelled() const;
  Status searchStep(double first);
  Status searchSmallest();

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
  UnitPlan plan_;
  CompressionGoal goal_;
  FileHead head_;
  std::vector<std::byte> headBytes_;
  WaveletParameters parameters_;
  Training training_;  // of the last way through
  std::vector<std::optional<BlockMode>> modes_;
  bool chosenBefore_ = false;  // modes_ are those of another step, else a guess
  double chosenStep_ = 0;      // at which modes_ were chosen
  QuantisationModel model_;
  std::optional<UnitStore> store_;  // of finished units, where that is asked for
  std::uint64_t content_ = 0;       // a digest of all values, for it
  int way_ = -1;                    // how many ways through the units were begun before
  EncodedUnits units_;              // of the last way through
  std::vector<LayerError> layers_;  // the same, of this rank
  std::uint64_t fileBytes_ = 0;     // as far as it was asked for
  CodingError error_;
  double relativeRms_ = 0;  // of the last way through all blocks
  double rounding_ = 0;     // of the values, roundingOf() the source
  int tries_ = 0;
};

Status Compressor::checkCancelled() const {
  if (progress_.cancelled())
    return fail(ErrorCode::kCancelled, "stopped: {} was not written", target_.string());
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
  VOLUTE_TRY(
      team_.forUnits("analysing", plan_.count(), progress_, [&](std::int64_t number) -> Status {
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
  const std::array<float, 2> range{row_.minimum(), row_.maximum()};
  VOLUTE_ASSIGN(const auto limits, gatherValues(team_, std::span<const float>(range)));
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
  const double own[] = {row_.rounding()};
  VOLUTE_ASSIGN(const auto roundings, gatherValues(team_, std::span<const double>(own)));
  rounding_ = *std::ranges::max_element(roundings);
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
    result.error.squared += error * error;
    result.error.maximum = std::max(result.error.maximum, error);
  }
  if (!std::isfinite(result.error.squared)) {
    return fail(ErrorCode::kInvalidData, "grid '{}': the input changed while it was read",
                info_.name);
  }
  return result;
}

Status Compressor::encodeUnit(Way way, EncodedUnits::Unit& done, EncodedUnitRecord& record) {
  const UnitPlan::Unit unit = plan_.unit(done.number);
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
      record.training.add(ofBlock);
      return {};
    }));
    for (std::size_t i = 0; i < batch.size(); ++i) {
      VOLUTE_TRY(units_.append(batch[i], done));
      const std::uint64_t layer = (first + i) / plan_.blocksALayer();
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
    VOLUTE_ASSIGN(record, recall(done));
  }
  if (!record) {
    record.emplace();
    VOLUTE_TRY(encodeUnit(way, done, *record));
    if (store_)
      VOLUTE_TRY(keep(done, *record));
  }
  layers_.insert(layers_.end(), record->layers.begin(), record->layers.end());
  training_.add(record->training);
  units_.finish(std::move(done));
  return {};
}

std::span<std::optional<BlockMode>> Compressor::modesOf(std::int64_t number) {
  const UnitPlan::Unit unit = plan_.unit(number);
  return std::span(modes_).subspan(plan_.firstBlock(unit), plan_.blocks(unit));
}

Status Compressor::keep(const EncodedUnits::Unit& done, EncodedUnitRecord& record) {
  const auto modes = modesOf(done.number);
  record.modes.assign(modes.begin(), modes.end());
  record.segments = done.segments;
  VOLUTE_ASSIGN(const auto bytes, units_.bytesOf(done));
  return store_->store(way_, done.number, record.toBytes(), bytes);
}

// Nothing when there is nothing of use. Bytes may be missing: they are dropped when the next way
// begins.
Result<std::optional<EncodedUnitRecord>> Compressor::recall(EncodedUnits::Unit& done) {
  std::optional<EncodedUnitRecord> none;
  const auto kept = store_->record(way_, done.number);
  if (!kept)
    return none;
  const auto bytes = store_->bytes(way_, done.number).value_or(std::vector<std::byte>());
  const UnitPlan::Unit unit = plan_.unit(done.number);
  auto record = EncodedUnitRecord::fromBytes(
      *kept, plan_.blocks(unit), static_cast<std::size_t>(unit.endLayer - unit.firstLayer));
  if (!record)
    return none;
  const auto sizes = record->tierSizes();
  const std::uint64_t total = std::accumulate(sizes.begin(), sizes.end(), std::uint64_t{0});
  done.hasBytes = bytes.size() == total;
  if (!done.hasBytes && !bytes.empty())
    return none;
  done.segments = record->segments;
  if (done.hasBytes) {
    done.sizes = sizes;
    VOLUTE_TRY(units_.appendBytes(done, bytes));
  }
  std::ranges::copy(record->modes, modesOf(done.number).begin());
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
  for (const int number :
       {info_.frames, info_.z, info_.y, info_.x, info_.channels, options_.fast ? 1 : 0,
        static_cast<int>(options_.target.kind), static_cast<int>(plan_.unitsARow())})
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
  for (const LayerError& layer : all) error_.add(layer.error);
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
  ByteWriter own;
  for (const EncodedUnits::Unit& done : units_.units()) {
    own.u64(static_cast<std::uint64_t>(done.number));
    for (const auto& mode : modesOf(done.number)) own.u8(byteOfMode(mode));
  }
  VOLUTE_ASSIGN(const auto ranks, team_.gatherAll(own.view()));
  for (const auto& bytes : ranks) {
    for (ByteReader in(bytes); in.remaining() > 0;) {
      for (auto& mode : modesOf(static_cast<std::int64_t>(in.u64()))) modeOfByte(in.u8(), mode);
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
    for (const EncodedUnits::Unit& done : units_.units()) store_->dropBytes(way_, done.number);
  }
  ++way_;
  layers_.clear();
  VOLUTE_TRY(units_.clear());
  const int rows = row_.rows();
  const int count = way == Way::kLearn ? std::min(rows, kRowsToLearnFrom) : rows;
  tries_ += way == Way::kEncode ? 1 : 0;
  const std::string stage = way == Way::kLearn ? "learning"
                            : way == Way::kChoose
                                ? chosenBefore_ ? "choosing modes again" : "choosing modes"
                            : tries_ == 1 ? "compressing"
                                          : fmt::format("compressing, try {}", tries_);
  const std::int64_t unitsARow = plan_.unitsARow();
  VOLUTE_TRY(team_.forUnits(stage, count * unitsARow, progress_, [&](std::int64_t i) {
    const std::int64_t row = i / unitsARow * rows / count;
    return doUnit(row * unitsARow + i % unitsARow, way);
  }));
  chosenBefore_ = chosenBefore_ || way == Way::kChoose;
  VOLUTE_TRY(shareErrors());
  relativeRms_ = goal_.relative(std::sqrt(error_.squared / static_cast<double>(info_.values())));
  head_.header.reachedRms = relativeRms_ + goal_.relative(options_.sourceRms + rounding_);
  head_.header.reachedMaxError = error_.maximum + options_.sourceMaxError + rounding_;
  if (way == Way::kChoose)
    VOLUTE_TRY(shareModes());
  if (way != Way::kEncode)
    VOLUTE_TRY(shareTraining());
  if (way == Way::kEncode || goal_.isSize())
    VOLUTE_TRY(shareSegments());
  return {};
}

double Compressor::outcomeOfTry() const {
  switch (options_.target.kind) {
    case Kind::kRatio:
    case Kind::kSize:
      return static_cast<double>(fileBytes_);
    case Kind::kMaxError:
      return error_.maximum;
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
              relativeRms_ + goal_.relative(rounding_), error_.maximum + rounding_);
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
  report.relativeRms = relativeRms_ + goal_.relative(rounding_);
  report.maxError = error_.maximum + rounding_;
  report.valueMin = head_.header.valueMin;
  report.valueMax = head_.header.valueMax;
  report.blocks = row_.grid().count();
  return report;
}

Status Compressor::searchStep(double first) {
  StepSearch search(goal_.problem(), first);
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
  return goal_.betterStep(parameters_.step * parameters_.unit(), outcomeOfTry());
}

Result<CompressReport> Compressor::run() {
  VOLUTE_TRY(units_.open(target_));
  VOLUTE_TRY(survey());
  goal_.setRange(head_.header.valueMin, head_.header.valueMax);
  if (options_.halves)
    goal_.leaveRoomForHalves();
  VOLUTE_TRY(goal_.leaveRoomFor(rounding_));
  if (goal_.isMaxError())
    // What is decoded is rounded to a float as well.
    parameters_.maxError = std::max(goal_.value() - rounding_, 0.5 * goal_.value());
  VOLUTE_TRY(team_.agree(openStore()));
  double step = goal_.firstStep(model_);
  VOLUTE_TRY(encodeAll(step, Way::kLearn));
  VOLUTE_TRY(encodeAll(step, Way::kChoose));
  if (goal_.isMaxError()) {
    VOLUTE_TRY(searchSmallest());
    return write();
  }
  // Modes depend on the step, and on what blocks in other modes have taught.
  VOLUTE_ASSIGN(const double better, team_.broadcast(betterStep()));
  VOLUTE_ASSIGN(step, team_.broadcast(step));
  if (!options_.fast || std::max(better / step, step / better) > 1.5) {
    VOLUTE_TRY(encodeAll(better, Way::kChoose));
  }
  VOLUTE_TRY(searchStep(betterStep()));
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
