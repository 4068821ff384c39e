// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/reconstruction_output.hpp"

#include <algorithm>

#include "volute/cli/volume_output.hpp"
#include "volute/codec/compress.hpp"
#include "volute/media/volume/grid_compression.hpp"
#include "volute/media/volume/volume_extraction.hpp"
#include "volute/media/volume/volume_input.hpp"

namespace volute::cli {
namespace {

/// A source that somebody else owns.
class BorrowedSource final : public FrameSource {
 public:
  explicit BorrowedSource(FrameSource& source) : source_(source) {}

  const VolumeInfo& info() const override { return source_.info(); }

  Status readFrame(int index, std::span<float> values) override {
    return source_.readFrame(index, values);
  }

 private:
  FrameSource& source_;
};

/// Light and velocity as the grids of one file.
class ReconstructedGrids final : public VolumeGrids {
 public:
  explicit ReconstructedGrids(std::vector<FrameSource*> sources) : sources_(std::move(sources)) {
    for (const FrameSource* source : sources_) grids_.push_back({source->info().name});
  }

  Result<std::unique_ptr<FrameSource>> source(std::size_t grid) const override {
    return std::make_unique<BorrowedSource>(*sources_[grid]);
  }

 private:
  std::vector<FrameSource*> sources_;
};

CompressOptions compressionOf(const ReconstructionOutput& output, const Context& context) {
  CompressOptions options;
  options.target = {ErrorTarget::Kind::kRms, output.rms};
  options.provenance = output.provenance;
  options.maxMemory = context.maxMemory;
  return options;
}

std::string nameFor(std::string target, const std::string& grid) {
  constexpr std::string_view kWord = "{grid}";
  return target.replace(target.find(kWord), kWord.size(), grid);
}

}  // namespace

Status ReconstructionWriter::writeVolute(Report& report, Context& context) {
  auto written = compress(*sources_[0], output_.target, compressionOf(output_, context),
                          context.progress, context.team);
  // The command line was checked; what is still found invalid is an error out of reach.
  if (!written && written.error().code == ErrorCode::kInvalidArgument)
    written.error().code = ErrorCode::kUnsupported;
  if (!written)
    return tl::unexpected<Error>(written.error());
  report.add("bytes", written->fileBytes, bytesText(written->fileBytes))
      .add("relative_rms", written->relativeRms);
  return {};
}

Status ReconstructionWriter::writeVoluteOfBoth(Report& report, Context& context) {
  constexpr double kVelocityRms = 5e-3;  // less than what the estimate is off by
  const ReconstructedGrids grids(sources_);
  GridCompression how{compressionOf(output_, context)};
  how.rms = {{sources_[1]->info().name, std::max(output_.rms, kVelocityRms)}};
  VOLUTE_ASSIGN(const auto written,
                compressGrids(grids, {0, 1}, output_.target, how, context, context.team));
  report.add("bytes", written.fileBytes, bytesText(written.fileBytes))
      .add("relative_rms", written.grids[0].report.relativeRms)
      .add("velocity_relative_rms", written.grids[1].report.relativeRms);
  return {};
}

Status ReconstructionWriter::writeCache(Context& context) {
  std::vector<std::vector<float>> values(sources_.size());
  const int count = sources_[0]->info().frames;
  for (int frame = 0; frame < count; ++frame) {
    if (context.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: writing frame {} of {}", frame + 1, count);
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      values[i].resize(sources_[i]->info().frameValues());
      VOLUTE_TRY(sources_[i]->readFrame(frame, values[i]));
    }
    VOLUTE_TRY(cache_->writeFrame(values));
    context.progress.report("writing", frame + 1, count);
  }
  return cache_->finish();
}

Status checkVelocityTarget(const std::string& target) {
  if (isVolutePath(target) || namesEachGrid(target) || extensionOf(target) == ".vdb")
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "--velocity: '{}' holds one grid; put {{grid}} into its name, as in "
              "fire_{{grid}}.npy, or write a .volute or %04d.vdb",
              target);
}

Result<ReconstructionWriter> ReconstructionWriter::open(FrameSource& frames, FrameSource* velocity,
                                                        ReconstructionOutput output,
                                                        Context& context) {
  ReconstructionWriter writer;
  writer.output_ = std::move(output);
  writer.sources_.push_back(&frames);
  if (velocity)
    writer.sources_.push_back(velocity);
  const std::string& target = writer.output_.target;
  const bool each = velocity && namesEachGrid(target) && !isVolutePath(target);
  if (!context.team.leads() || (isVolutePath(target) && !each))
    return writer;
  if (velocity && !each) {
    std::vector<GridTarget> grids;
    for (const FrameSource* source : writer.sources_) {
      const VolumeInfo& info = source->info();
      grids.push_back(
          {info, {.type = info.channels == 3 ? "vec3s" : "float", .gridClass = "fog volume"}});
    }
    VOLUTE_ASSIGN(writer.cache_, createCacheSink(target, std::move(grids), {}));
    return writer;
  }
  for (const FrameSource* source : writer.sources_) {
    const VolumeInfo& info = source->info();
    VOLUTE_ASSIGN(auto sink, openSink(each ? nameFor(target, info.name) : target, info, true));
    writer.sinks_.push_back(std::move(sink));
  }
  return writer;
}

Status ReconstructionWriter::write(Report& report, Context& context) {
  if (cache_)
    return writeCache(context);
  for (std::size_t i = 0; i < sinks_.size(); ++i)
    VOLUTE_TRY(copyFrames(*sources_[i], *sinks_[i], "writing", context.progress));
  if (!isVolutePath(output_.target) || !sinks_.empty())
    return {};
  return sources_.size() > 1 ? writeVoluteOfBoth(report, context) : writeVolute(report, context);
}

}  // namespace volute::cli
