// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/volume_writer.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <ranges>

#include "volute/base/plain_number.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/copy_frames.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/io/array_file.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/lattice.hpp"
#include "volute/volume_files/grid_compression.hpp"
#include "volute/volume_files/volume_extraction.hpp"

namespace volute {
namespace {

/// A source that somebody else owns.
class BorrowedSource final : public RoundingSource {
 public:
  /// @param description  learns how much is in its frames; null: nobody does
  BorrowedSource(FrameSource& source, GridDescription* description)
      : source_(source), description_(description) {}

  const VolumeInfo& info() const override { return source_.info(); }

  Status readFrame(int index, std::span<float> values) override {
    return source_.readFrame(index, values);
  }

  double rounding() const override { return roundingOf(source_); }

  double offset() const override { return offsetOf(source_); }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    VOLUTE_TRY(source_.readBricks(index, first, end, bricks));
    if (description_ && first == 0 && end == info().z) {
      description_->voxels = std::max(description_->voxels, bricks.activeVoxels());
      description_->memory = std::max(description_->memory, bricks.bytes());
    }
    return {};
  }

  bool hasTopology() const override { return source_.hasTopology(); }

  std::uint64_t brickBytes() const override { return source_.brickBytes(); }

 private:
  FrameSource& source_;
  GridDescription* description_;
};

/// The grids of one file.
class WrittenGrids final : public VolumeGrids {
 public:
  WrittenGrids(std::span<const WrittenGrid> written, FrameMetadata fileMetadata)
      : written_(written) {
    for (const WrittenGrid& grid : written)
      grids_.push_back({grid.frames->info().name, grid.description});
    for (VolumeGrid& grid : grids_)
      descriptions_.push_back(grid.description ? &*grid.description : nullptr);
    fileMetadata_ = std::move(fileMetadata);
    frames_ = written.front().frames->info();
  }

  Result<std::unique_ptr<FrameSource>> source(std::size_t grid) const override {
    return std::make_unique<BorrowedSource>(*written_[grid].frames, descriptions_[grid]);
  }

  Result<OwnError> ownError(std::size_t grid) const override { return written_[grid].ownError; }

 private:
  std::span<const WrittenGrid> written_;
  std::vector<GridDescription*> descriptions_;  // those of grids_
};

}  // namespace

void addSize(Report& report, const VolumeInfo& info) {
  report.add("frames", info.frames, fmt::format("{}", info.frames))
      .add("size", {info.x, info.y, info.z},
           fmt::format("{} x {} x {} voxels", info.x, info.y, info.z));
}

bool holdsSeveralGrids(const std::string& target) {
  return isVolutePath(target) || namesEachGrid(target) || isVdbPath(target);
}

Status checkHoldsGrids(const std::vector<std::string>& names, const std::string& path,
                       const std::string& target) {
  if (names.size() < 2 || holdsSeveralGrids(target))
    return {};
  return fail(ErrorCode::kInvalidArgument, Hint::choose("field"),
              "{} has {} grids ({}), and '{}' holds one: put {{grid}} into "
              "the name, or write %04d.vdb files, which hold all",
              path, names.size(), fmt::join(names, ", "), target);
}

bool statesTimes(const std::string& target) {
  const std::string extension = extensionOf(target);
  return target != "-" && extension != ".npy" && extension != ".nvdb";
}

void remarkOnWhatIsLost(const VolumeInfo& info, const Besides& besides, const std::string& target,
                        Reading& reading) {
  const std::string extension = extensionOf(target);
  const bool array = target == "-" || extension == ".npy";  // nothing but values
  const bool vdb = extension == ".vdb", nano = extension == ".nvdb";
  const bool unit =
      !array && (vdb ? info.unit.size() <= LatticeFrame::kMaxUnit : isArrayOutput(target));
  VolumeInfo unsaid = info;  // what is taken where a file says nothing
  unsaid.times.clear();
  unsaid.fillDefaults();
  if (isVolutePath(target))
    return;
  std::vector<std::string> lost;
  if (info.up != 0 && !vdb)
    lost.push_back(fmt::format("that {} points upwards", info.up));
  if (!info.unit.empty() && !unit)
    lost.push_back(fmt::format("that the values are in {}", info.unit));
  if (info.levelSet && !vdb && !nano)
    lost.emplace_back("that the values are distances to a surface");
  if (array && besides.turned)
    lost.emplace_back("how the voxels are turned, or move");
  if (nano && besides.metadata)
    lost.emplace_back("what metadata its grids have");
  // What values mean is lost; whoever writes bare arrays has the rest elsewhere.
  const RemarkCode code = lost.empty() ? RemarkCode::kNote : RemarkCode::kLeftOut;
  if (array && info.name != "density" && target.find(info.name) == target.npos)
    lost.push_back(fmt::format("that the values are '{}'", info.name));
  if (array && !besides.turned && !hasUsualBounds(info))
    lost.push_back(fmt::format("where the voxels lie ({})", boxText(info.bounds)));
  const bool oneFile = !namesSeries(target) && extension != ".pvd";
  const bool counted = std::ranges::equal(info.frameNumbers, std::views::iota(0, info.frames)) &&
                       info.frameScale.decimals == 0;
  if (oneFile && !counted && info.frames > 1)
    lost.push_back(fmt::format("that its frames are {} to {}", info.frameText(0),
                               info.frameText(static_cast<std::size_t>(info.frames) - 1)));
  const bool paced = !std::ranges::equal(info.times, unsaid.times, [&](double time, double usual) {
    return std::abs(time - info.times.front() - usual) < 1e-9;
  });
  if (!statesTimes(target) && info.frames > 1 && !info.timesAssumed && paced)
    lost.push_back(fmt::format("when the frames are shown ({} to {} s)",
                               plainNumber(info.times.front(), 4),
                               plainNumber(info.times.back(), 4)));
  if (!lost.empty())
    reading.progress.remark(Remark(code, fmt::format("{}: such a file does not say {}", target,
                                                     fmt::join(lost, ", or ")))
                                .in(target));
}

void remarkOnOtherFrames(const std::string& target, const VolumeInfo& info, Reading& reading) {
  constexpr std::size_t kNamed = 3;
  if (!namesSeries(target))
    return;
  const auto pattern = FramePattern::parse(target);
  const auto there = pattern ? pattern->list(SubFrames::kAllowed)
                             : Result<std::vector<NumberedFile>>(std::vector<NumberedFile>());
  std::vector<std::string> others;
  for (std::size_t i = 0; there && i < there->size(); ++i) {
    const NumberedFile& file = (*there)[i];
    const bool written = std::ranges::any_of(info.frameNumbers, [&](int number) {
      return info.frameScale.frame(number) == file.frame();
    });
    if (!written)
      others.push_back(file.path.filename().string());
  }
  if (others.empty())
    return;
  const std::size_t more = others.size() - std::min(others.size(), kNamed);
  others.resize(others.size() - more);
  reading.progress.remark(
      Remark(RemarkCode::kNote,
             fmt::format("{}: {}{} stay from before and are read as frames of the same sequence",
                         target, fmt::join(others, ", "),
                         more > 0 ? fmt::format(" and {} more", more) : ""))
          .in(target));
}

Status VolumeWriter::writeVolute(Report& report) {
  CompressOptions options;
  options.target = {ErrorTarget::Kind::kRms, grids_[0].rms};
  options.provenance = provenance_;
  options.maxMemory = reading_->maxMemory;
  if (grids_.size() == 1 && !grids_[0].description) {
    options.sourceRms = grids_[0].ownError.rms;
    options.sourceMaxError = grids_[0].ownError.maximum;
    VOLUTE_ASSIGN(const auto written,
                  compress(*grids_[0].frames, target_, options, reading_->progress, *team_));
    report.add("bytes", written.fileBytes, bytesText(written.fileBytes))
        .add("relative_rms", written.relativeRms);
    return {};
  }
  GridCompression how{options};
  std::vector<std::size_t> all;
  for (const WrittenGrid& grid : grids_) {
    how.rms[grid.frames->info().name] = grid.rms;
    all.push_back(all.size());
  }
  VOLUTE_ASSIGN(const auto written, compressGrids(WrittenGrids(grids_, fileMetadata_), all, target_,
                                                  how, *reading_, *team_));
  report.add("bytes", written.fileBytes, bytesText(written.fileBytes));
  for (const std::size_t i : all) {
    const CompressedGrid& grid = written.grids[i];
    report.add(i == 0 ? "relative_rms" : grid.name + "_relative_rms", grid.report.relativeRms);
  }
  return {};
}

Status VolumeWriter::writeCache() {
  std::vector<Bricks> values(grids_.size());
  const int count = grids_[0].frames->info().frames;
  for (int frame = 0; frame < count; ++frame) {
    if (reading_->progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: writing frame {} of {}", frame + 1, count);
    for (std::size_t i = 0; i < grids_.size(); ++i)
      VOLUTE_TRY(grids_[i].frames->readBricks(frame, values[i]));
    VOLUTE_TRY(cache_->writeFrame(values));
    reading_->progress.report("writing", frame + 1, count);
  }
  return cache_->finish();
}

Result<VolumeWriter> VolumeWriter::open(std::vector<WrittenGrid> grids, std::string target,
                                        std::string provenance, Reading& reading, Team& team,
                                        FrameMetadata fileMetadata) {
  VolumeWriter writer(std::move(grids), std::move(target), std::move(provenance), reading, team);
  writer.fileMetadata_ = std::move(fileMetadata);
  VOLUTE_TRY(checkWords(writer.target_));
  std::vector<std::string> names;
  for (const WrittenGrid& grid : writer.grids_) names.push_back(grid.frames->info().name);
  VOLUTE_TRY(checkHoldsGrids(names, "what is written", writer.target_));
  const bool each = namesEachGrid(writer.target_) && !isVolutePath(writer.target_);
  // .vdb files hold all grids, and what is to be said of them.
  const bool cache = !each && (writer.grids_.size() > 1 ||
                               (isVdbPath(writer.target_) && writer.grids_[0].description));
  if (!team.leads() || isVolutePath(writer.target_))
    return writer;
  std::vector<GridTarget> targets;
  for (const WrittenGrid& grid : writer.grids_) {
    const VolumeInfo& info = grid.frames->info();
    const double offset = offsetOf(*grid.frames);
    if (cache) {
      GridDescription description =
          grid.description.value_or(GridDescription{.gridClass = "fog volume"});
      if (!grid.description || offset != 0)
        description.type = typeOfValues(*grid.frames);
      targets.push_back({.info = info, .description = std::move(description), .offset = offset});
      continue;
    }
    const std::string own = each ? nameOfGrid(writer.target_, info.name) : writer.target_;
    VOLUTE_ASSIGN(auto sink, createSink(own, info, {.offset = offset, .orVolute = true}));
    writer.sinks_.push_back(std::move(sink));
  }
  if (cache) {
    VOLUTE_ASSIGN(writer.cache_,
                  createCacheSink(writer.target_, std::move(targets), writer.fileMetadata_));
  }
  return writer;
}

Status VolumeWriter::write(Report& report) {
  if (cache_)
    return writeCache();
  for (std::size_t i = 0; i < sinks_.size(); ++i)
    VOLUTE_TRY(copyFrames(*grids_[i].frames, *sinks_[i], "writing", reading_->progress));
  return isVolutePath(target_) ? writeVolute(report) : Status();
}

}  // namespace volute
