// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/volume_writer.hpp"

#include "volute/grid/bricks.hpp"
#include "volute/grid/copy_frames.hpp"
#include "volute/grid/rounding_source.hpp"
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

Status VolumeWriter::writeVolute(Report& report) {
  CompressOptions options;
  options.target = {ErrorTarget::Kind::kRms, grids_[0].rms};
  options.provenance = provenance_;
  options.maxMemory = reading_->maxMemory;
  if (grids_.size() == 1 && !grids_[0].description) {
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
  const bool each = namesEachGrid(writer.target_) && !isVolutePath(writer.target_);
  // .vdb files hold all grids, and what is to be said of them.
  const bool cache = !each && (writer.grids_.size() > 1 ||
                               (isVdbPath(writer.target_) && writer.grids_[0].description));
  if (!team.leads() || isVolutePath(writer.target_))
    return writer;
  std::vector<GridTarget> targets;
  for (const WrittenGrid& grid : writer.grids_) {
    const VolumeInfo& info = grid.frames->info();
    if (cache) {
      targets.push_back(
          {info, grid.description.value_or(GridDescription{
                     .type = info.channels == 3 ? "vec3s" : "float", .gridClass = "fog volume"})});
      continue;
    }
    const std::string own = each ? nameOfGrid(writer.target_, info.name) : writer.target_;
    VOLUTE_ASSIGN(auto sink, createSink(own, info, {.orVolute = true}));
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
