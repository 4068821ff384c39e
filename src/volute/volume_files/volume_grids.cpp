// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/volume_grids.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <set>

#include "volute/codec/kept_grids.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/grid_cache.hpp"
#include "volute/io/grid_choice.hpp"

namespace volute {
namespace {

class VdbGrids final : public VolumeGrids {
 public:
  explicit VdbGrids(GridCache cache) : cache_(std::move(cache)) {
    for (const CacheGrid& grid : cache_.grids()) {
      const bool volume = grid.problem.empty();
      grids_.push_back({grid.name, volume ? std::optional(grid.description) : std::nullopt,
                        grid.empty, grid.type, grid.problem, grid.mostBytes,
                        cache_.file(grid.mostBytesIn).string()});
    }
    fileMetadata_ = cache_.fileMetadata();
    frames_ = cache_.frames();
  }

  Result<std::unique_ptr<FrameSource>> source(std::size_t grid) const override {
    return cache_.source(grid);
  }

  Result<std::unique_ptr<KeptBytes>> keep(std::size_t grid, int frame) const override {
    return cache_.keep(grid, static_cast<std::size_t>(frame));
  }

 private:
  GridCache cache_;
};

class VoluteGrids final : public VolumeGrids {
 public:
  VoluteGrids(std::string path, VoluteReader::Options options,
              std::shared_ptr<const VoluteReader> reader)
      : path_(std::move(path)), options_(std::move(options)), reader_(std::move(reader)) {
    const auto& kept = reader_->kept().grids;
    std::size_t k = 0;
    const auto addKept = [&](std::size_t before) {
      for (; k < kept.size() && kept[k].place <= before; ++k)
        grids_.push_back({kept[k].name, {}, false, kept[k].type, "of type " + kept[k].type});
    };
    for (std::size_t i = 0; i < reader_->grids().size(); ++i) {
      addKept(i);
      const VoluteGrid& grid = reader_->grids()[i];
      grids_.push_back({grid.info.name, grid.description, grid.empty});
    }
    addKept(std::numeric_limits<std::size_t>::max());
    fileMetadata_ = reader_->fileMetadata();
    frames_ = reader_->info();
  }

  Result<std::unique_ptr<FrameSource>> source(std::size_t grid) const override {
    VOLUTE_ASSIGN(auto reader, open(grid));
    return frameSource(std::make_shared<const VoluteReader>(std::move(reader)));
  }

  Result<OwnError> ownError(std::size_t grid) const override {
    VOLUTE_ASSIGN(const auto reader, open(grid));
    return ownErrorOf(reader);
  }

  Result<std::unique_ptr<KeptBytes>> keep(std::size_t grid, int frame) const override {
    const auto& kept = reader_->kept().grids;
    const auto at = std::ranges::find(kept, grids_[grid].name, &KeptGrid::name);
    if (at == kept.end())
      return VolumeGrids::keep(grid, frame);
    return reader_->keptBytes(static_cast<std::size_t>(at - kept.begin()), frame);
  }

 private:
  Result<VoluteReader> open(std::size_t grid) const {
    VoluteReader::Options options = options_;
    options.grid = grids_[grid].name;
    return VoluteReader::open(path_, options);
  }

  std::string path_;
  VoluteReader::Options options_;
  std::shared_ptr<const VoluteReader> reader_;
};

}  // namespace

bool VolumeGrids::mayBe(const std::string& path) {
  if (isVolutePath(path) || isVdbPath(path))
    return true;
  std::error_code error;
  return std::filesystem::is_directory(path, error) && listNumberedFiles(path, ".vdb").has_value();
}

Result<std::unique_ptr<VolumeGrids>> VolumeGrids::open(const std::string& path,
                                                       const InputOptions& options,
                                                       Reading& reading) {
  if (isVolutePath(path)) {
    VOLUTE_ASSIGN(const auto reader, openVolute(path, options.partial, reading, options.verify));
    return std::make_unique<VoluteGrids>(
        path, VoluteReader::Options{options.partial, reading.maxMemory, {}, options.offsets},
        reader);
  }
  SourceOptions source;
  source.bounds = options.bounds;
  source.maxMemory = reading.maxMemory;
  source.byLayers = options.byLayers;
  source.upStated = options.stated.up != 0;
  source.offsets = options.offsets;
  // A grid may be read several times.
  source.remark = [&progress = reading.progress,
                   said = std::make_shared<std::set<std::string>>()](const Remark& remark) {
    if (said->insert(remark.sentence).second)
      progress.remark(remark);
  };
  VOLUTE_ASSIGN(auto cache, GridCache::open(path, source));
  return std::make_unique<VdbGrids>(std::move(cache));
}

std::vector<std::string> gridNames(const std::string& list) {
  std::vector<std::string> names;
  for (std::size_t at = 0; !list.empty() && at <= list.size();) {
    const std::size_t end = std::min(list.find(',', at), list.size());
    names.push_back(list.substr(at, end - at));
    at = end + 1;
  }
  return names;
}

Result<std::vector<std::size_t>> VolumeGrids::choose(const std::string& list,
                                                     const std::string& path) const {
  std::vector<GridEntry> entries;
  for (const VolumeGrid& grid : grids_)
    entries.push_back({grid.name,
                       grid.empty          ? "empty"
                       : grid.description  ? grid.description->type
                       : grid.type.empty() ? "float"
                                           : grid.type,
                       true});
  std::vector<std::size_t> chosen;
  if (list.empty()) {
    for (std::size_t i = 0; i < grids_.size(); ++i) chosen.push_back(i);
    return chosen;
  }
  for (const std::string& name : gridNames(list)) {
    if (name.empty())
      return failFor("field", ErrorCode::kInvalidArgument, "'{}' has an empty name", list);
    VOLUTE_ASSIGN(const std::size_t index, chooseGrid(entries, name, path));
    if (std::ranges::find(chosen, index) != chosen.end())
      return failFor("field", ErrorCode::kInvalidArgument, "'{}' names '{}' twice", list, name);
    chosen.push_back(index);
  }
  return chosen;
}

}  // namespace volute
