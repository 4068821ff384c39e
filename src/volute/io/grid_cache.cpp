// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/grid_cache.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/base/suggest.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/io/plugin.hpp"

namespace volute {
namespace {

const LatticeGrid* gridNamed(const LatticeCache& file, const std::string& name) {
  const auto found = std::ranges::find_if(
      file.grids, [&](const LatticeGrid& grid) { return grid.frame.grid == name; });
  return found == file.grids.end() ? nullptr : &*found;
}

/// What this frame says of its grid, and how that is of another kind than in the first frame.
MetadataList metadataOf(const LatticeGrid& grid, const LatticeGrid& first) {
  MetadataList list = grid.metadata;
  const auto say = [&](const char* name, const char* type, const std::string& value) {
    if (!findEntry(list, name))
      list.push_back({name, type, value});
  };
  const GridTraits &one = grid.traits, &other = first.traits;
  if (std::string_view(one.type) != other.type)
    say(kTypeEntry, "string", one.type);
  if (std::string_view(one.gridClass) != other.gridClass)
    say("class", "string", one.gridClass);
  if (one.half != other.half)
    say("is_saved_as_half_float", "bool", std::string(1, one.half ? 1 : 0));
  return list;
}

/// What a file without the grid has that is called nearly so.
std::string missingText(const LatticeCache& cache, const LatticeFile& file,
                        const std::string& name) {
  std::vector<std::string_view> names;
  for (const LatticeGrid& grid : cache.grids) names.emplace_back(grid.frame.grid);
  const auto near = nearest(name, names);
  return fmt::format("{}: no grid named '{}'{}", file.path.string(), name,
                     near.empty() ? "" : fmt::format("; did you mean '{}'?", near));
}

/// The digits that frame numbers have in the names of files, at least: those of a pattern, else the
/// fewest of one without a sign, which some programs count as a digit.
int widthOfNumbers(const std::filesystem::path& input, const std::vector<LatticeFile>& files) {
  const auto field = findFrameField(input.filename().string());
  std::error_code error;
  if (field && *field && !std::filesystem::exists(input, error))
    // NOLINTNEXTLINE(bugprone-unchecked-optional-access): asked for above
    return (*field)->width;
  std::size_t width = 0;
  for (const LatticeFile& file : files) {
    const std::size_t digits = std::min(file.written.find('.'), file.written.size());
    if (file.number >= 0 && digits > 0)
      width = width == 0 ? digits : std::min(width, digits);
  }
  return static_cast<int>(std::max<std::size_t>(width, 1));
}

}  // namespace

Result<GridCache> GridCache::open(const std::filesystem::path& input,
                                  const SourceOptions& options) {
  GridCache cache;
  cache.options_ = options;
  VOLUTE_ASSIGN(cache.files_, listLatticeFiles(input));
  VOLUTE_ASSIGN(const auto files, describeCache(cache.files_, options.maxMemory));
  const int width = widthOfNumbers(input, cache.files_);
  // Times that one grid of each file states are those of all.
  for (std::size_t i = 0; i < files.size(); ++i) {
    for (const LatticeGrid& grid : files[i].grids) {
      cache.up_ = cache.up_ == 0 ? grid.frame.up : cache.up_;
      if (std::isfinite(grid.frame.time) && !cache.files_[i].time)
        cache.files_[i].time = grid.frame.time;
    }
    MetadataList metadata = files[i].metadata;
    const LatticeFile& file = cache.files_[i];
    if (!file.written.empty() && file.written != frameText(file.number, file.scale, width))
      metadata.insert(metadata.begin(), {kNumberEntry, "string", file.written});
    cache.fileMetadata_.add(metadata.empty() ? nullptr : &metadata);
  }
  if (cache.fileMetadata_.lists.empty())
    cache.fileMetadata_ = {};
  VOLUTE_TRY(cache.collect(files));
  return cache;
}

Status GridCache::collect(const std::vector<LatticeCache>& files) {
  std::vector<std::string> names;
  for (const LatticeCache& file : files) {
    for (const LatticeGrid& grid : file.grids) {
      if (std::ranges::find(names, grid.frame.grid) == names.end())
        names.emplace_back(grid.frame.grid);
    }
  }
  for (const std::string& name : names) {
    CacheGrid grid{name, {}, true};
    KnownGrid known{name, {}, {}, {}, {}};
    const LatticeGrid* first = nullptr;
    for (const LatticeCache& file : files) {
      const LatticeGrid* const one = gridNamed(file, name);
      if (one && !first)
        first = one;
      if (one && one->traits.problem[0] != '\0')
        grid.problem = one->traits.problem;
      if (one && one->traits.problem[0] != '\0' && one->traits.memory > grid.mostBytes) {
        grid.mostBytes = one->traits.memory;
        grid.mostBytesIn = known.present.size();
      }
      grid.places.push_back(one ? static_cast<int>(one - file.grids.data()) : -1);
      const auto metadata = one ? metadataOf(*one, *first) : MetadataList();
      grid.description.metadata.add(one ? &metadata : nullptr);
      known.present.push_back(one != nullptr);
      if (!one && known.missing.empty())
        known.missing = missingText(file, files_[known.present.size() - 1], name);
    }
    grid.type = first->traits.type;
    if (!grid.problem.empty()) {
      grid.empty = false;
      grids_.push_back(std::move(grid));
      known_.emplace_back();
      continue;
    }
    GridDescription& description = grid.description;
    description.type = first->traits.type;
    description.gridClass = first->traits.gridClass;
    description.half = first->traits.half;
    description.background = first->traits.background;
    description.map = first->traits.map;
    description.voxelSize = first->frame.voxelSize;
    known.background = description.background;
    for (const LatticeCache& file : files) {
      const LatticeGrid* const one = gridNamed(file, name);
      known.frames.push_back(one ? one->frame : first->frame);
      if (!one) {
        known.frames.back().box = {};
        known.frames.back().time = std::numeric_limits<double>::quiet_NaN();
        continue;
      }
      description.voxels = std::max(description.voxels, one->traits.voxels);
      description.memory = std::max(description.memory, one->traits.memory);
    }
    description.origin = known.frames.front().origin;
    VOLUTE_ASSIGN(auto places, latticePlaces(files_, known.frames));
    grid.empty = places.box.empty();
    description.begin = places.box.begin;
    description.matrices = std::move(places.matrices);
    if (std::ranges::any_of(places.shifts, [](const auto& shift) {
          return shift != std::array<std::int64_t, 3>{};
        }))
      description.shifts = std::move(places.shifts);
    grids_.push_back(std::move(grid));
    known_.push_back(std::move(known));
  }
  return {};
}

VolumeInfo GridCache::frames() const {
  VolumeInfo info;
  info.frames = static_cast<int>(files_.size());
  info.x = info.y = info.z = 1;
  info.frameScale = files_.front().scale;
  info.up = up_;
  for (const LatticeFile& file : files_) {
    info.frameNumbers.push_back(file.number);
    if (file.time && (info.times.empty() || *file.time > info.times.back()))
      info.times.push_back(*file.time);
  }
  if (info.times.size() != files_.size())
    info.times.clear();
  info.fillDefaults();
  return info;
}

Result<std::unique_ptr<FrameSource>> GridCache::source(std::size_t grid) const {
  VOLUTE_ASSERT(grid < grids_.size() && !grids_[grid].empty && grids_[grid].problem.empty());
  VOLUTE_ASSIGN(auto source, openLatticeSource(files_, loadVdbPlugin, options_, known_[grid]));
  VOLUTE_TRY(settleOffset(*source, options_.offsets));
  return source;
}

Result<std::unique_ptr<KeptBytes>> GridCache::keep(std::size_t grid, std::size_t file) const {
  const int place = grids_[grid].places[file];
  if (place < 0)
    return nullptr;
  if (!kept_)
    kept_ = std::make_unique<KeptReader>(files_, options_.maxMemory);
  return kept_->open(files_[file].path, static_cast<std::size_t>(place));
}

}  // namespace volute
