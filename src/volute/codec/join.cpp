// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/join.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <set>

#include "volute/base/output_file.hpp"
#include "volute/codec/bundle.hpp"
#include "volute/codec/compress.hpp"
#include "volute/codec/compression_goal.hpp"
#include "volute/codec/container.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/codec/written_file.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/fitted_source.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {
namespace {

constexpr double kFarthest = 1e6;  // voxels

struct Part {
  InputFile file;
  FileHead head;
  std::shared_ptr<const VoluteReader> reader;

  std::string name() const { return file.path().string(); }

  const VolumeInfo& info() const { return head.info; }
};

/// One grid of a file; without a name the first that has values, or what stands for it.
Result<Part> openPart(const std::filesystem::path& path, std::uint64_t maxMemory,
                      const std::string& grid = "") {
  VOLUTE_ASSIGN(auto file, InputFile::open(path));
  VOLUTE_ASSIGN(auto head, readHeadAndPages(file, maxMemory, grid));
  VoluteReader::Options options;
  options.maxMemory = maxMemory;
  options.grid = grid;
  options.differences = Offsets::kAll;
  VOLUTE_ASSIGN(auto reader, VoluteReader::open(path, options));
  return Part{std::move(file), std::move(head),
              std::make_shared<const VoluteReader>(std::move(reader))};
}

std::string gridText(const VolumeInfo& info) {
  return fmt::format(
      "{} x {} x {} voxels with {} channel{} of '{}' [{}], {} basis, from ({:.6g}, {:.6g}, {:.6g}) "
      "to ({:.6g}, {:.6g}, {:.6g}) m",
      info.x, info.y, info.z, info.channels, info.channels == 1 ? "" : "s", info.name, info.unit,
      basisName(info.basis), info.bounds.min.x(), info.bounds.min.y(), info.bounds.min.z(),
      info.bounds.max.x(), info.bounds.max.y(), info.bounds.max.z());
}

bool sameGrid(const VolumeInfo& a, const VolumeInfo& b) {
  const double tolerance = 1e-9 * a.bounds.size().maxCoeff();
  return a.x == b.x && a.y == b.y && a.z == b.z && a.channels == b.channels && a.name == b.name &&
         a.unit == b.unit && a.basis == b.basis &&
         (a.bounds.min - b.bounds.min).cwiseAbs().maxCoeff() <= tolerance &&
         (a.bounds.max - b.bounds.max).cwiseAbs().maxCoeff() <= tolerance;
}

/// One up axis for all parts, the one that is stated.
Status settleUp(std::vector<Part>& parts, Progress& progress) {
  const auto stated =
      std::ranges::find_if(parts, [](const Part& part) { return part.info().up != 0; });
  if (stated == parts.end())
    return {};
  const char up = stated->info().up;
  for (Part& part : parts) {
    char& own = part.head.info.up;
    if (own != 0 && own != up) {
      return fail(ErrorCode::kInvalidData,
                  "{} and {} do not fit together: {} points upwards in one and {} in the other; "
                  "expected one up axis in all parts",
                  stated->name(), part.name(), up, own);
    }
    if (own == 0) {
      progress.remark(
          Remark(RemarkCode::kAssumed,
                 fmt::format("{}: does not say which axis points upwards; {} is taken, as {} says",
                             part.name(), up, stated->name()))
              .in(part.name()));
    }
    own = up;
  }
  return {};
}

Status checkPair(const Part& before, const Part& part) {
  if (!sameGrid(before.info(), part.info())) {
    return fail(ErrorCode::kInvalidData, "{} and {} do not fit together: {}, and {}", before.name(),
                part.name(), gridText(before.info()), gridText(part.info()));
  }
  return {};
}

/// Seconds between frame numbers that follow each other.
double periodOf(const VolumeInfo& info) {
  constexpr double kUsual = 1.0 / 25;
  if (info.frames < 2)
    return kUsual;
  return (info.times.back() - info.times.front()) /
         (info.frameNumbers.back() - info.frameNumbers.front());
}

using Rate = std::optional<double>;  ///< frames per second; nothing: the times of the parts

/// All frames of all parts; times of a part that begin before those of the one before end go on in
/// the first part's steps.
VolumeInfo joinedInfo(const std::vector<Part>& parts, const Rate& rate) {
  VolumeInfo joined = parts.front().info();
  const double period = periodOf(joined);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const VolumeInfo& info = parts[i].info();
    double shift = 0;
    if (info.times.front() <= joined.times.back()) {
      const double expected =
          joined.times.front() + (info.frameNumbers.front() - joined.frameNumbers.front()) * period;
      shift = std::max(expected, joined.times.back() + period) - info.times.front();
    }
    joined.frameNumbers.insert(joined.frameNumbers.end(), info.frameNumbers.begin(),
                               info.frameNumbers.end());
    for (const double time : info.times) joined.times.push_back(time + shift);
    joined.frames += info.frames;
  }
  if (rate)
    joined.setRate(*rate);
  return joined;
}

/// Blocks keep their places in the joined file, and all are of one codec and one length.
bool canCopy(const std::vector<Part>& parts) {
  const int codec = parts.front().head.header.codec;
  const BlockDecoder& first = *parts.front().head.decoder;
  return std::ranges::all_of(
             parts.begin(), parts.end() - 1,
             [&](const Part& part) { return part.head.info.frames % first.blockFrames() == 0; }) &&
         std::ranges::all_of(parts, [&](const Part& part) {
           const BlockDecoder& decoder = *part.head.decoder;
           return part.head.header.codec == codec && decoder.hasTopology() == first.hasTopology() &&
                  decoder.blockFrames() == first.blockFrames() &&
                  decoder.hasMeans() == first.hasMeans() && decoder.offset() == first.offset();
         });
}

/// The parts of all, as the file lists them; none where all blocks are read alike.
std::vector<FilePart> partsOf(const std::vector<Part>& parts) {
  std::vector<FilePart> all;
  int row = 0;
  for (const Part& part : parts) {
    const FileHead& head = part.head;
    if (head.parts.empty()) {
      all.push_back({row, static_cast<float>(head.header.valueMin),
                     static_cast<float>(head.header.valueMax), head.parameters, head.decoder});
    }
    for (FilePart one : head.parts) {
      one.firstRow += row;
      all.push_back(std::move(one));
    }
    row += head.blockGrid().counts()[0];
  }
  const auto same = [](const FilePart& a, const FilePart& b) {
    return a.parameters == b.parameters && a.valueMin == b.valueMin && a.valueMax == b.valueMax;
  };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  if (all.size() == 1)
    all.clear();
  return all;
}

/// What the parts' own errors come to, all values together [absolute].
struct Errors {
  double rms = 0, most = 0;
  double low = 0, high = 0;  ///< range of the values of all parts

  double relative(double error) const { return high > low ? error / (high - low) : error; }
};

/// Ranges are of differences from the first part's offset.
Errors errorsOf(const std::vector<Part>& parts) {
  const double offset = parts.front().head.header.offset;
  Errors errors{0, 0, parts.front().head.header.valueMin, parts.front().head.header.valueMax};
  double squares = 0, frames = 0;
  for (const Part& part : parts) {
    const VoluteHeader& header = part.head.header;
    const double range = header.valueMax - header.valueMin;
    const double rms = header.reachedRms * (range > 0 ? range : 1);
    squares += rms * rms * part.info().frames;
    frames += part.info().frames;
    errors.most = std::max(errors.most, header.reachedMaxError);
    errors.low = std::min(errors.low, header.valueMin + (header.offset - offset));
    errors.high = std::max(errors.high, header.valueMax + (header.offset - offset));
  }
  errors.rms = std::sqrt(squares / frames);
  return errors;
}

/// The same over the support of all parts, whose range is the widest of theirs.
std::optional<SupportError> supportOf(const std::vector<Part>& parts, double reachedMaxError) {
  SupportError all;
  double squares = 0, voxels = 0, frames = 0;
  int first = 0;
  for (const Part& part : parts) {
    const auto& own = part.head.header.support;
    if (!own)
      return std::nullopt;
    const double rms = own->rms / CompressionGoal::relative(1, own->low, own->high);
    const double of = own->share * part.info().frames;
    squares += rms * rms * of;
    voxels += of;
    frames += part.info().frames;
    const double apart = part.head.header.offset - parts.front().head.header.offset;
    all.low = first == 0 ? own->low : std::min(all.low, own->low + apart);
    all.high = first == 0 ? own->high : std::max(all.high, own->high + apart);
    all.robust = all.robust || own->robust;
    if (part.head.header.reachedMaxError == reachedMaxError) {
      all.worstFrame = first + own->worstFrame;
      all.worstVoxel = own->worstVoxel;
    }
    first += part.info().frames;
  }
  all.share = voxels / frames;
  all.rms =
      CompressionGoal::relative(std::sqrt(squares / std::max(voxels, 1e-300)), all.low, all.high);
  return all;
}

/// None where a part has none.
FrameAmounts amountsOf(const std::vector<Part>& parts) {
  FrameAmounts all;
  for (const Part& part : parts) {
    if (part.head.header.amounts.shares.empty())
      return {};
    all.most = std::max(all.most, part.head.header.amounts.most);
  }
  for (const Part& part : parts) {
    const FrameAmounts& own = part.head.header.amounts;
    for (const std::uint8_t share : own.shares)
      all.shares.push_back(static_cast<std::uint8_t>(std::ceil(share * (own.most / all.most))));
  }
  return all;
}

/// "a; b", each once.
std::string joinedProvenance(const std::vector<Part>& parts) {
  std::string text;
  std::set<std::string> seen;
  for (const Part& part : parts) {
    const std::string& one = part.head.header.provenance;
    if (!one.empty() && seen.insert(one).second)
      text += (text.empty() ? "" : "; ") + one;
  }
  return text;
}

/// What was asked of all parts together: the weakest of what was asked of each, which holds for the
/// whole since its range is no smaller; where different things were, the RMS that is reached.
void joinTargets(const std::vector<Part>& parts, VoluteHeader& header) {
  const std::string kind = header.targetKind;
  const bool same = std::ranges::all_of(
      parts, [&](const Part& part) { return part.head.header.targetKind == kind; });
  if (!same && header.support) {
    header.targetKind = "support-rms";
    header.targetValue = header.support->rms;
    return;
  }
  if (!same) {
    header.targetKind = "rms";
    header.targetValue = header.reachedRms;
    return;
  }
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const double value = parts[i].head.header.targetValue;
    double& all = header.targetValue;
    all = kind == "size"                      ? all + value
          : kind == "psnr" || kind == "ratio" ? std::min(all, value)
                                              : std::max(all, value);
  }
}

/// The frames of all files, one file after another, as differences from the first one's offset.
class JoinedFrames final : public RoundingSource {
 public:
  struct File {
    int frames = 0;
    std::unique_ptr<FrameSource> source;  ///< none: its frames are all background
  };

  /// @param info  of all frames; the sources have its volume
  JoinedFrames(VolumeInfo info, std::vector<File> files,
               const std::array<double, 3>& background = {})
      : info_(std::move(info)), files_(std::move(files)), background_(background) {
    const auto first =
        std::ranges::find_if(files_, [](const File& file) { return file.source != nullptr; });
    offset_ = first == files_.end() ? 0 : offsetOf(*first->source);
  }

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int index, std::span<float> values) override {
    Bricks bricks;
    VOLUTE_TRY(readBricks(index, 0, info_.z, bricks));
    bricks.toDense({{0, 0, 0}, {info_.x, info_.y, info_.z}}, values);
    return {};
  }

  double rounding() const override { return rounding_; }

  double offset() const override { return offset_; }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    std::size_t file = 0;
    while (index >= files_[file].frames) index -= files_[file++].frames;
    if (!files_[file].source) {
      bricks = Bricks(info_.channels, {static_cast<float>(background_[0] - offset_),
                                       static_cast<float>(background_[1] - offset_),
                                       static_cast<float>(background_[2] - offset_)});
      return {};
    }
    FrameSource& source = *files_[file].source;
    VOLUTE_TRY(source.readBricks(index, first, end, bricks));
    const double apart = offsetOf(source) - offset_;
    if (apart == 0)
      return {};
    bricks = raised(bricks, apart);
    double most = 0;
    for (std::size_t i = 0; i < bricks.leaves().size(); ++i)
      for (const float value : bricks.values(i)) most = std::max<double>(most, std::abs(value));
    rounding_ = std::max(rounding_, std::ldexp(std::max(most, std::abs(apart)), -24));
    return {};
  }

  bool hasTopology() const override {
    return std::ranges::any_of(
        files_, [](const File& file) { return file.source && file.source->hasTopology(); });
  }

  std::uint64_t brickBytes() const override {
    std::uint64_t most = 0;
    for (const File& file : files_) {
      if (file.source)
        most = std::max(most, file.source->brickBytes());
    }
    return most;
  }

 private:
  VolumeInfo info_;
  std::vector<File> files_;
  std::array<double, 3> background_;
  double offset_ = 0, rounding_ = 0;
};

JoinedFrames framesOf(const std::vector<Part>& parts, const Rate& rate) {
  std::vector<JoinedFrames::File> files;
  for (const Part& part : parts) files.push_back({part.info().frames, frameSource(part.reader)});
  return {joinedInfo(parts, rate), std::move(files)};
}

/// The head of the joined file: tier by tier, and in each part after part.
FileHead headOf(const std::vector<Part>& parts, const Errors& errors, const Rate& rate) {
  FileHead head = parts.front().head;
  head.info = joinedInfo(parts, rate);
  head.parts = partsOf(parts);
  head.header.valueMin = errors.low;
  head.header.valueMax = errors.high;
  head.header.provenance = joinedProvenance(parts);
  head.header.reachedRms = errors.relative(errors.rms);
  head.header.reachedMaxError = errors.most;
  head.header.support = supportOf(parts, errors.most);
  joinTargets(parts, head.header);
  head.header.amounts = amountsOf(parts);
  head.segments.clear();
  head.blocks.clear();
  head.means.clear();
  head.tiles.clear();
  head.kept = {};
  for (const Part& part : parts) {
    if (!part.head.look || !head.look) {
      head.look.reset();
      break;
    }
    const LookFigures& one = *part.head.look;
    head.look = {std::min(head.look->least, one.least), std::max(head.look->most, one.most),
                 std::max(head.look->column, one.column)};
  }
  std::uint64_t before = 0;  // blocks
  for (const Part& part : parts) {
    for (const std::uint64_t block : part.head.blocks) head.blocks.push_back(before + block);
    before += part.head.blockGrid().count();
    head.means.insert(head.means.end(), part.head.means.begin(), part.head.means.end());
    FrameTiles tiles = part.head.tiles;
    tiles.resize(static_cast<std::size_t>(part.info().frames));
    head.tiles.insert(head.tiles.end(), tiles.begin(), tiles.end());
  }
  for (std::size_t tier = 0; tier < head.decoder->tierLevels().size(); ++tier) {
    for (const Part& part : parts) {
      const auto blocks = static_cast<std::ptrdiff_t>(part.head.blocks.size());
      const auto begin = part.head.segments.begin() + static_cast<std::ptrdiff_t>(tier) * blocks;
      head.segments.insert(head.segments.end(), begin, begin + blocks);
    }
  }
  return head;
}

Status copySegment(const Part& part, const SegmentEntry& segment, OutputFile& out) {
  const auto bytes = readSegment(part.file, part.head, segment);
  if (!bytes) {
    return fail(ErrorCode::kInvalidData, "{}: is damaged at byte {}; it cannot be joined",
                part.name(), segment.offset);
  }
  return out.write(*bytes);
}

Result<JoinReport> copyBlocks(const std::vector<Part>& parts, const std::filesystem::path& target,
                              const Rate& rate, Progress& progress) {
  const Errors errors = errorsOf(parts);
  FileHead head = headOf(parts, errors, rate);
  VOLUTE_ASSIGN(auto out, CheckedFile::create(target));
  const auto headBytes = writeHead(head);
  VOLUTE_TRY(out.bytes().write(headBytes));
  const std::size_t tiers = head.decoder->tierLevels().size();
  double done = 0;
  for (std::size_t tier = 0; tier < tiers; ++tier) {
    for (const Part& part : parts) {
      if (progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped: {} was not written", target.string());
      for (std::size_t place = 0; place < part.head.blocks.size(); ++place)
        VOLUTE_TRY(copySegment(part, part.head.segment(tier, place), out.bytes()));
      progress.report("copying", ++done, static_cast<double>(tiers * parts.size()));
    }
  }
  VOLUTE_TRY(out.commit(headBytes, std::span(&head, 1), progress));
  return JoinReport{head.info,     true, 0, head.header.reachedRms, head.header.reachedMaxError,
                    head.fileBytes};
}

/// @param frames  of all parts, and of more where `parts` has none
Result<JoinReport> encodeAgain(const std::vector<Part>& parts, FrameSource& frames,
                               const std::filesystem::path& target, const JoinOptions& options,
                               Progress& progress, const GridDescription* description = nullptr) {
  constexpr double kFinest = 1e-6, kMuchWorse = 10;
  const Errors errors = errorsOf(parts);
  CompressOptions how;
  const auto support = supportOf(parts, errors.most);
  const double reached = support ? support->rms : errors.relative(errors.rms);
  const bool look = std::ranges::all_of(
      parts, [](const Part& part) { return part.head.header.targetKind == "look"; });
  how.target = {!support ? ErrorTarget::Kind::kRmsOverAll
                : look   ? ErrorTarget::Kind::kLook
                         : ErrorTarget::Kind::kRms,
                options.rms.value_or(std::max(kFinest, reached))};
  how.provenance = joinedProvenance(parts);
  how.maxMemory = options.maxMemory;
  how.sourceRms = errors.rms;
  how.sourceMaxError = errors.most;
  how.halves = description && description->half;
  how.floats = description && description->isOfFloats();
  VOLUTE_ASSIGN(const auto written, compress(frames, target, how, progress));
  if (!options.rms && errors.most > 0 && written.maxError > kMuchWorse * errors.most) {
    progress.remark({RemarkCode::kDoubtful,
                     fmt::format("'{}' is encoded again, up to {:.2g} from its parts, which are "
                                 "within {:.2g} of their originals: they lie too far apart for "
                                 "one file; keep the parts",
                                 frames.info().name, written.maxError, errors.most)});
  }
  JoinReport report{frames.info(),
                    false,
                    written.relativeRms,
                    written.relativeRms + errors.relative(errors.rms),
                    written.maxError + errors.most,
                    written.fileBytes};
  if (!written.faintFrames.empty())
    report.faint.push_back({frames.info().name, written.faintFrames});
  return report;
}

/// One grid through all files.
struct GridParts {
  std::string name;
  std::vector<Part> parts{};                     ///< of the files where it has values
  std::vector<std::optional<std::size_t>> of{};  ///< of each file the place in `parts`
};

/// The least volume around those of all parts, which are on one lattice of voxels.
Result<VolumeInfo> volumeAround(const std::vector<Part>& parts) {
  const VolumeInfo& first = parts.front().info();
  Box3 around = first.bounds;
  for (const Part& part : parts) {
    const VolumeInfo& info = part.info();
    around.extend(info.bounds);
    const bool sameKind =
        info.channels == first.channels && info.unit == first.unit && info.basis == first.basis;
    if (!sameKind || !onOneLattice(info, first) ||
        around.size().cwiseQuotient(first.voxelSize()).maxCoeff() > kFarthest) {
      return fail(ErrorCode::kInvalidData, "{} and {} do not fit together: {}, and {}",
                  parts.front().name(), part.name(), gridText(first), gridText(info));
    }
  }
  return widenedTo(first, around);
}

/// Of a list over the frames of one file those that a joined list gets.
void append(FrameMetadata& all, const FrameMetadata& one, int frames) {
  for (int i = 0; i < frames; ++i) all.add(one.at(i));
}

/// Files with several grids, or with what a cache says of its one.
class GridJoin {
 public:
  GridJoin(std::vector<Part> files, const JoinOptions& options) : options_(options) {
    for (Part& file : files) files_.push_back(std::move(file));
  }

  Result<JoinReport> write(const std::filesystem::path& target, Progress& progress) {
    frames_ = joinedInfo(files_, options_.framesPerSecond);
    VOLUTE_TRY(collect());
    copies_ = maySettleOnCopies();
    std::vector<PendingFile> pending;
    std::vector<BundledGrid> bundled;
    JoinReport report{frames_, true, 0, 0, 0, 0};
    for (const GridParts& grid : grids_) {
      BundledGrid& row = bundled.emplace_back();
      row.name = grid.name;
      VOLUTE_ASSIGN(row.description, describe(grid));
      if (grid.parts.empty())
        continue;
      VOLUTE_ASSIGN(auto file, PendingFile::create(target));
      row.file = file.path();
      pending.push_back(std::move(file));
      VOLUTE_ASSIGN(const auto one, joinGrid(grid, row, progress));
      report.copied = report.copied && one.copied;
      report.partsRms = std::max(report.partsRms, one.partsRms);
      report.relativeRms = std::max(report.relativeRms, one.relativeRms);
      report.maxError = std::max(report.maxError, one.maxError);
      report.faint.insert(report.faint.end(), one.faint.begin(), one.faint.end());
    }
    FrameMetadata ofFiles;
    for (const Part& file : files_) append(ofFiles, file.head.fileMetadata, file.info().frames);
    if (ofFiles.lists.empty())
      ofFiles = {};
    VOLUTE_ASSIGN(auto kept, keepGrids(target));
    VOLUTE_ASSIGN(auto whole, PendingFile::create(target));
    const auto frames = emptyFrames(frames_);
    VOLUTE_ASSIGN(report.fileBytes, bundle(bundled, ofFiles, whole.path(), progress,
                                           kept ? &*kept : nullptr, frames.get()));
    VOLUTE_TRY(whole.commit());
    return report;
  }

 private:
  Status collect() {
    for (const Part& file : files_) {
      for (const VoluteGrid& grid : file.head.grids) {
        if (std::ranges::find(grids_, grid.info.name, &GridParts::name) == grids_.end())
          grids_.push_back({grid.info.name});
      }
    }
    for (GridParts& grid : grids_) {
      for (const Part& file : files_) {
        grid.of.emplace_back();
        const VoluteGrid* const there = gridIn(file, grid.name);
        if (!there || there->empty)
          continue;
        grid.of.back() = grid.parts.size();
        VOLUTE_ASSIGN(auto part, openPart(file.file.path(), options_.maxMemory, grid.name));
        part.head.info.up = frames_.up;
        grid.parts.push_back(std::move(part));
      }
    }
    return {};
  }

  /// What the files keep of grids that are not coded, frame after frame.
  Result<std::optional<KeptStore>> keepGrids(const std::filesystem::path& target) const {
    std::vector<KeptGrid> all;
    for (const Part& file : files_)
      for (const KeptGrid& grid : file.head.kept.grids) {
        if (std::ranges::find(all, grid.name, &KeptGrid::name) == all.end())
          all.push_back({grid.name, grid.type, grid.place});
      }
    if (all.empty())
      return std::nullopt;
    VOLUTE_ASSIGN(auto store, KeptStore::create(target));
    for (const KeptGrid& grid : all) {
      const std::string& name = grid.name;
      store.begin(grid);
      if (std::ranges::find(grids_, name, &GridParts::name) != grids_.end()) {
        return fail(ErrorCode::kInvalidData,
                    "grid '{}' is coded in some of these files and kept as it was in others", name);
      }
      for (const Part& file : files_) {
        const auto& own = file.head.kept.grids;
        const auto at = std::ranges::find(own, name, &KeptGrid::name) - own.begin();
        for (int i = 0; i < file.info().frames; ++i) {
          const auto bytes = at == std::ssize(own)
                                 ? nullptr
                                 : file.reader->keptBytes(static_cast<std::size_t>(at), i);
          VOLUTE_TRY(store.add(bytes.get()));
        }
      }
    }
    return std::optional(std::move(store));
  }

  static const VoluteGrid* gridIn(const Part& file, const std::string& name) {
    const auto found = std::ranges::find(file.head.grids, name,
                                         [](const VoluteGrid& grid) { return grid.info.name; });
    return found == file.head.grids.end() ? nullptr : &*found;
  }

  /// What all files say of a grid; how far joinGrid() lets its volume grow is not in it.
  Result<std::optional<GridDescription>> describe(const GridParts& grid) const {
    std::optional<GridDescription> all;
    const Part* from = nullptr;
    bool placed = false;
    FrameMetadata metadata;
    std::vector<GridDescription::Index> shifts;
    std::vector<GridMatrix> matrices;
    for (const Part& file : files_) {
      const VoluteGrid* const there = gridIn(file, grid.name);
      const GridDescription* const one =
          there && there->description ? &*there->description : nullptr;
      static const MetadataList kNothing;
      // Without a list for any frame all frames have the grid, which then must be said.
      const bool silent = one && one->metadata.listOf.empty();
      for (int i = 0; i < file.info().frames; ++i) {
        const MetadataList* own = one && !silent ? one->metadata.at(i) : nullptr;
        metadata.add(silent ? &kNothing : own);
      }
      GridDescription::Index apart{};
      if (one && !all) {
        all = *one;
        from = &file;
      }
      if (one && one != &*gridIn(*from, grid.name)->description) {
        if (one->type != all->type || one->gridClass != all->gridClass || one->map != all->map ||
            one->half != all->half || one->background != all->background) {
          return fail(
              ErrorCode::kInvalidData,
              "{} and {} do not fit together: grid '{}' is of type {} ({}) in one and of {} "
              "({}) in the other, or has another background",
              from->name(), file.name(), grid.name, all->type, all->gridClass, one->type,
              one->gridClass);
        }
        const bool turned = !one->matrices.empty() || !all->matrices.empty();
        if (turned && (one->matrices.empty() || all->matrices.empty() ||
                       one->voxelSize != all->voxelSize || one->origin != all->origin)) {
          return fail(ErrorCode::kInvalidData,
                      "{} and {} do not fit together: grid '{}' is turned or moves, and does not "
                      "begin at one place in both; compress all frames together",
                      from->name(), file.name(), grid.name);
        }
        for (std::size_t axis = 0; axis < 3 && all->voxelSize[axis] > 0 && !turned; ++axis) {
          apart[axis] =
              std::llround((one->origin[axis] - all->origin[axis]) / all->voxelSize[axis]);
        }
        all->voxels = std::max(all->voxels, one->voxels);
        all->memory = std::max(all->memory, one->memory);
      }
      if (one && !there->empty && !placed) {
        placed = true;
        for (std::size_t axis = 0; axis < 3; ++axis)
          all->begin[axis] = one->begin[axis] + apart[axis];
      }
      for (int i = 0; i < file.info().frames; ++i) {
        GridDescription::Index shift = apart;
        for (std::size_t axis = 0; one && !one->shifts.empty() && axis < 3; ++axis)
          shift[axis] += one->shifts[static_cast<std::size_t>(i)][axis];
        shifts.push_back(shift);
        matrices.push_back(one && !one->matrices.empty()
                               ? one->matrices[static_cast<std::size_t>(i)]
                               : GridMatrix{});
      }
    }
    if (all && !all->matrices.empty()) {
      // Frames without the grid lie where any other does.
      for (GridMatrix& matrix : matrices) {
        if (!isSound(matrix))
          matrix = all->matrices.front();
      }
      all->matrices = std::move(matrices);
    }
    if (!all)
      return all;
    const bool moves = std::ranges::any_of(
        shifts, [](const auto& shift) { return shift != GridDescription::Index{}; });
    all->shifts = moves ? std::move(shifts) : std::vector<GridDescription::Index>();
    all->metadata = std::move(metadata);
    return all;
  }

  bool sameEverywhere(const GridParts& grid) const {
    return grid.parts.size() == files_.size() &&
           std::ranges::all_of(grid.parts, [&](const Part& part) {
             return sameGrid(grid.parts.front().info(), part.info());
           });
  }

  /// Whether blocks of these files can stand beside those that are encoded anew, or all are copied:
  /// a file has one codec.
  bool maySettleOnCopies() const {
    const bool sparse = std::ranges::all_of(files_, [](const Part& file) {
      return file.head.header.codec == static_cast<int>(kSparseCodec);
    });
    return sparse || std::ranges::all_of(grids_, [&](const GridParts& grid) {
             return grid.parts.empty() || (sameEverywhere(grid) && canCopy(grid.parts));
           });
  }

  Result<JoinReport> joinGrid(const GridParts& grid, BundledGrid& row, Progress& progress) const {
    VOLUTE_ASSIGN(VolumeInfo info, volumeAround(grid.parts));
    const bool same = sameEverywhere(grid);
    if (same && canCopy(grid.parts) && copies_)
      return copyBlocks(grid.parts, row.file, options_.framesPerSecond, progress);
    const GridDescription* const said = row.description ? &*row.description : nullptr;
    if (same) {
      JoinedFrames frames = framesOf(grid.parts, options_.framesPerSecond);
      return encodeAgain(grid.parts, frames, row.file, options_, progress, said);
    }
    const VolumeInfo& first = grid.parts.front().info();
    const auto background = row.description ? row.description->background : std::array<double, 3>{};
    std::vector<JoinedFrames::File> files;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      JoinedFrames::File& file = files.emplace_back(files_[i].info().frames);
      if (grid.of[i])
        file.source = fitTo(frameSource(grid.parts[*grid.of[i]].reader), info, background);
    }
    const Vec3 moved = (info.bounds.min - first.bounds.min).cwiseQuotient(first.voxelSize());
    for (std::size_t axis = 0; row.description && axis < 3; ++axis)
      row.description->begin[axis] += std::llround(moved[axis]);
    info.frames = frames_.frames;
    info.frameNumbers = frames_.frameNumbers;
    info.times = frames_.times;
    JoinedFrames frames(std::move(info), std::move(files), background);
    return encodeAgain(grid.parts, frames, row.file, options_, progress, said);
  }

  const JoinOptions& options_;
  std::vector<Part> files_;
  VolumeInfo frames_;
  std::vector<GridParts> grids_;
  bool copies_ = false;
};

/// Says which parts begin at other times than they state.
void tellShifts(const std::vector<Part>& parts, const VolumeInfo& joined, Progress& progress) {
  std::size_t first = 0;
  for (const Part& part : parts) {
    const double shift = joined.times[first] - part.info().times.front();
    first += static_cast<std::size_t>(part.info().frames);
    if (shift == 0)
      continue;
    progress.remark(
        Remark(RemarkCode::kChanged,
               fmt::format("{}: begins at {:g} s, before the frames that precede it end, and its "
                           "times are moved by {:g} s",
                           part.name(), part.info().times.front(), shift),
               {Hint::set("fps")})
            .in(part.name()));
  }
}

bool isPlain(const Part& part) {
  return part.head.grids.size() == 1 && !part.head.own().empty && !part.head.own().description &&
         part.head.kept.grids.empty();
}

Status checkFrames(const Part& before, const Part& part) {
  if (part.info().frameScale != before.info().frameScale) {
    return fail(ErrorCode::kInvalidData,
                "{} numbers its frames with {} decimals and {} with {}; expected the same",
                before.name(), before.info().frameScale.decimals, part.name(),
                part.info().frameScale.decimals);
  }
  if (part.info().frameNumbers.front() > before.info().frameNumbers.back())
    return {};
  return fail(ErrorCode::kInvalidData,
              "{} has frames {} to {} and {} has {} to {}; expected parts that do not overlap",
              before.name(), before.info().frameText(0),
              before.info().frameText(before.info().frames - 1), part.name(),
              part.info().frameText(0), part.info().frameText(part.info().frames - 1));
}

}  // namespace

Result<JoinReport> join(const std::vector<std::filesystem::path>& paths,
                        const std::filesystem::path& target, const JoinOptions& options,
                        Progress& progress) {
  if (paths.empty())
    return fail(ErrorCode::kInvalidArgument, "there is nothing to join; expected .volute files");
  std::vector<Part> parts;
  for (const auto& path : paths) {
    VOLUTE_ASSIGN(auto part, openPart(path, options.maxMemory));
    parts.push_back(std::move(part));
  }
  std::ranges::stable_sort(parts, {},
                           [](const Part& part) { return part.info().frameNumbers.front(); });
  VOLUTE_TRY(settleUp(parts, progress));
  const bool plain = std::ranges::all_of(parts, isPlain);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (plain)
      VOLUTE_TRY(checkPair(parts[i - 1], parts[i]));
    VOLUTE_TRY(checkFrames(parts[i - 1], parts[i]));
  }
  const VolumeInfo joined = joinedInfo(parts, options.framesPerSecond);
  VOLUTE_TRY(joined.validate("the joined sequence"));
  if (!options.framesPerSecond)
    tellShifts(parts, joined, progress);
  if (!plain)
    return GridJoin(std::move(parts), options).write(target, progress);
  if (canCopy(parts))
    return copyBlocks(parts, target, options.framesPerSecond, progress);
  JoinedFrames frames = framesOf(parts, options.framesPerSecond);
  return encodeAgain(parts, frames, target, options, progress);
}

}  // namespace volute
