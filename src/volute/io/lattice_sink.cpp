// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/lattice_sink.hpp"

#include <vector>

#include "volute/base/assert.hpp"
#include "volute/base/file_name.hpp"
#include "volute/base/output_file.hpp"
#include "volute/base/write_file.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/xml_text.hpp"

namespace volute {
namespace {

Status commitAll(std::vector<PendingFile>& files, std::size_t frames) {
  if (files.size() != frames) {
    return fail(ErrorCode::kInvalidArgument, "only {} of {} frames were written", files.size(),
                frames);
  }
  for (PendingFile& file : files) VOLUTE_TRY(file.commit());
  return {};
}

class LatticeSink final : public FrameSink {
 public:
  LatticeSink(std::vector<std::filesystem::path> targets, std::filesystem::path collection,
              const VolumeInfo& info, std::unique_ptr<LatticeWriter> writer)
      : targets_(std::move(targets)),
        collection_(std::move(collection)),
        info_(info),
        writer_(std::move(writer)) {}

  Status writeFrame(std::span<const float> values) override {
    VOLUTE_ASSERT(values.size() == info_.frameValues());
    VOLUTE_ASSERT(pending_.size() < targets_.size());
    const auto& target = targets_[pending_.size()];
    VOLUTE_ASSIGN(auto file, PendingFile::create(target));
    VOLUTE_TRY(
        writer_->write(file.path(), target, info_, static_cast<int>(pending_.size()), values));
    pending_.push_back(std::move(file));
    return {};
  }

  bool takesBricks() const override { return writer_->takesBricks(); }

  Status writeBricks(const Bricks& bricks) override {
    VOLUTE_ASSERT(pending_.size() < targets_.size());
    const auto& target = targets_[pending_.size()];
    VOLUTE_ASSIGN(auto file, PendingFile::create(target));
    VOLUTE_TRY(writer_->writeBricks(file.path(), target, info_, static_cast<int>(pending_.size()),
                                    bricks));
    pending_.push_back(std::move(file));
    return {};
  }

  Status finish() override {
    VOLUTE_TRY(commitAll(pending_, targets_.size()));
    return collection_.empty() ? Status{} : writeCollection();
  }

 private:
  Status writeCollection() {
    std::string text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
        "byte_order=\"LittleEndian\">\n  <Collection>\n";
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      text += fmt::format("    <DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", info_.times[i],
                          escapedXml(targets_[i].filename().string()));
    }
    text += "  </Collection>\n</VTKFile>\n";
    return writeFile(collection_, text);
  }

  std::vector<std::filesystem::path> targets_;
  std::filesystem::path collection_;  // empty when there is none
  VolumeInfo info_;
  std::unique_ptr<LatticeWriter> writer_;
  std::vector<PendingFile> pending_;
};

/// A file for each frame.
Result<std::vector<std::filesystem::path>> targetsOf(const std::filesystem::path& output,
                                                     const VolumeInfo& info,
                                                     const FrameMetadata& files = {}) {
  if (!namesSeries(output)) {
    if (info.frames == 1)
      return std::vector{output};
    const auto example =
        siblingOf(output, output.stem().string() + "_%04d" + output.extension().string());
    return fail(ErrorCode::kInvalidArgument,
                "{}: {} frames need a file each; name them with a pattern such as {}",
                output.string(), info.frames, example.string());
  }
  VOLUTE_ASSIGN(const FramePattern pattern, FramePattern::parse(output));
  return framePaths(pattern, info, files);
}

class LatticeCacheSink final : public CacheSink {
 public:
  LatticeCacheSink(std::vector<std::filesystem::path> targets, std::vector<GridTarget> grids,
                   FrameMetadata fileMetadata, std::vector<KeptTarget> kept,
                   std::unique_ptr<LatticeWriter> writer)
      : targets_(std::move(targets)),
        grids_(std::move(grids)),
        fileMetadata_(std::move(fileMetadata)),
        kept_(std::move(kept)),
        writer_(std::move(writer)) {}

  Status writeFrame(std::span<const Bricks> values) override {
    VOLUTE_ASSERT(values.size() == grids_.size() && pending_.size() < targets_.size());
    const auto position = static_cast<int>(pending_.size());
    std::vector<std::unique_ptr<KeptBytes>> kept;
    for (const KeptTarget& grid : kept_) {
      VOLUTE_ASSIGN(auto bytes, grid.open(position));
      kept.push_back(std::move(bytes));
    }
    const auto& target = targets_[pending_.size()];
    VOLUTE_ASSIGN(auto file, PendingFile::create(target));
    std::vector<GridFrame> frames;
    for (std::size_t i = 0; i <= grids_.size(); ++i) {
      for (std::size_t k = 0; k < kept_.size(); ++k) {
        if (kept[k] && (i == grids_.size() ? kept_[k].place >= i : kept_[k].place == i))
          frames.push_back({.kept = kept[k].get()});
      }
      if (i == grids_.size())
        break;
      const GridTarget& grid = grids_[i];
      // A cache that has a list of metadata for some frames lacks the grid in the others.
      const auto& metadata = grid.description.metadata;
      if (!metadata.listOf.empty() && !metadata.at(position))
        continue;
      frames.push_back({&grid.info, &grid.description, position, &values[i], nullptr, grid.offset});
    }
    VOLUTE_TRY(writer_->writeGrids(file.path(), target, frames, fileMetadata_.at(position)));
    pending_.push_back(std::move(file));
    return {};
  }

  Status finish() override { return commitAll(pending_, targets_.size()); }

 private:
  std::vector<std::filesystem::path> targets_;
  std::vector<GridTarget> grids_;
  FrameMetadata fileMetadata_;
  std::vector<KeptTarget> kept_;
  std::unique_ptr<LatticeWriter> writer_;
  std::vector<PendingFile> pending_;
};

}  // namespace

std::vector<std::filesystem::path> framePaths(const FramePattern& pattern, const VolumeInfo& info,
                                              const FrameMetadata& files) {
  std::vector<std::filesystem::path> paths;
  for (std::size_t i = 0; i < info.frameNumbers.size(); ++i) {
    const MetadataList* const own = files.at(static_cast<int>(i));
    const GridMetadata* const written = own ? findEntry(*own, kNumberEntry) : nullptr;
    paths.push_back(pattern.format(info.frameNumbers[i], info.frameScale,
                                   written ? std::string_view(written->value) : ""));
  }
  return paths;
}

Result<std::unique_ptr<CacheSink>> createLatticeCacheSink(const std::filesystem::path& output,
                                                          const VolumeInfo& frames,
                                                          std::vector<GridTarget> grids,
                                                          FrameMetadata fileMetadata,
                                                          std::vector<KeptTarget> kept,
                                                          std::unique_ptr<LatticeWriter> writer) {
  VOLUTE_ASSIGN(auto targets, targetsOf(output, frames, fileMetadata));
  return std::make_unique<LatticeCacheSink>(std::move(targets), std::move(grids),
                                            std::move(fileMetadata), std::move(kept),
                                            std::move(writer));
}

Result<std::unique_ptr<FrameSink>> createLatticeSink(const std::filesystem::path& output,
                                                     const VolumeInfo& info,
                                                     std::unique_ptr<LatticeWriter> writer) {
  VOLUTE_TRY(info.validate(output.string()));
  const bool collection = extensionOf(output) == ".pvd";
  std::filesystem::path files = output;
  if (collection) {
    if (namesSeries(output)) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}: a collection is one file; leave the frame number out of its name",
                  output.string());
    }
    files = siblingOf(output, output.stem().string() + "_%04d.vti");
  }
  VOLUTE_ASSIGN(auto targets, targetsOf(files, info));
  return std::make_unique<LatticeSink>(
      std::move(targets), collection ? output : std::filesystem::path(), info, std::move(writer));
}

}  // namespace volute
