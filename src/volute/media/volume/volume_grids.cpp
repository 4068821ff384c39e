// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_grids.hpp"

#include <algorithm>

#include "volute/io/frame_pattern.hpp"
#include "volute/io/grid_cache.hpp"
#include "volute/io/grid_choice.hpp"

namespace volute {
namespace {

class VdbGrids final : public VolumeGrids {
 public:
  explicit VdbGrids(GridCache cache) : cache_(std::move(cache)) {
    for (const CacheGrid& grid : cache_.grids())
      grids_.push_back({grid.name, grid.description, grid.empty});
    leftOut_ = cache_.leftOut();
    fileMetadata_ = cache_.fileMetadata();
  }

  Result<std::unique_ptr<FrameSource>> source(std::size_t grid) const override {
    return cache_.source(grid);
  }

 private:
  GridCache cache_;
};

class VoluteGrids final : public VolumeGrids {
 public:
  VoluteGrids(std::string path, VoluteReader::Options options, const VoluteReader& reader)
      : path_(std::move(path)), options_(std::move(options)) {
    for (const VoluteGrid& grid : reader.grids())
      grids_.push_back({grid.info.name, grid.description, grid.empty});
    fileMetadata_ = reader.fileMetadata();
  }

  Result<std::unique_ptr<FrameSource>> source(std::size_t grid) const override {
    VoluteReader::Options options = options_;
    options.grid = grids_[grid].name;
    VOLUTE_ASSIGN(auto reader, VoluteReader::open(path_, options));
    return frameSource(std::make_shared<const VoluteReader>(std::move(reader)));
  }

 private:
  std::string path_;
  VoluteReader::Options options_;
};

}  // namespace

bool VolumeGrids::mayBe(const std::string& path) {
  if (isVolutePath(path) || extensionOf(path) == ".vdb")
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
        path, VoluteReader::Options{options.partial, reading.maxMemory, {}}, *reader);
  }
  SourceOptions source;
  source.bounds = options.bounds;
  source.maxMemory = reading.maxMemory;
  source.byLayers = options.byLayers;
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
                       grid.empty         ? "empty"
                       : grid.description ? grid.description->type
                                          : "float",
                       true});
  std::vector<std::size_t> chosen;
  if (list.empty()) {
    for (std::size_t i = 0; i < grids_.size(); ++i) chosen.push_back(i);
    return chosen;
  }
  for (const std::string& name : gridNames(list)) {
    if (name.empty())
      return fail(ErrorCode::kInvalidArgument, "--field: '{}' has an empty name", list);
    VOLUTE_ASSIGN(const std::size_t index, chooseGrid(entries, name, path));
    if (std::ranges::find(chosen, index) != chosen.end())
      return fail(ErrorCode::kInvalidArgument, "--field: '{}' names '{}' twice", list, name);
    chosen.push_back(index);
  }
  return chosen;
}

}  // namespace volute
