// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_extraction.hpp"

#include <algorithm>
#include <cstring>

#include "volute/base/ordered_delivery.hpp"
#include "volute/media/volume/volume_input.hpp"

namespace volute {
namespace {

using GridValues = std::vector<std::vector<float>>;

Status readFrames(const std::vector<std::unique_ptr<FrameSource>>& sources, int index,
                  GridValues& values) {
  values.resize(sources.size());
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (!sources[i])
      continue;
    values[i].resize(sources[i]->info().frameValues());
    VOLUTE_TRY(sources[i]->readFrame(index, values[i]));
  }
  return {};
}

/// What the cache says of a grid, of these frames of it and at this level.
GridDescription descriptionOf(const VoluteGrid& grid, const Extraction& extraction) {
  if (!grid.description)
    return {.type = grid.info.channels == 3 ? "vec3s" : "float", .gridClass = "fog volume"};
  GridDescription one = grid.description->of(extraction.positions);
  if (extraction.level == 0)
    return one;
  one.map.clear();  // voxels of another size: the bounds say where they are
  one.begin = {};
  one.shifts.clear();
  return one;
}

}  // namespace

Result<ExtractedGrids> openGrids(const std::string& path, const std::vector<std::string>& names,
                                 const Extraction& extraction, bool partial, Reading& reading) {
  ExtractedGrids all;
  all.positions = extraction.positions;
  VOLUTE_ASSIGN(const auto main, openVolute(path, partial, reading, false));
  all.fileMetadata = main->fileMetadata();
  if (!all.fileMetadata.listOf.empty())
    all.fileMetadata = all.fileMetadata.of(extraction.positions);
  double voxels = 0;  // of all, to share the memory out
  for (const VoluteGrid& grid : main->grids()) {
    if (std::ranges::find(names, grid.info.name) != names.end())
      voxels += static_cast<double>(grid.info.frameValues());
  }
  for (const std::string& name : names) {
    const auto grid = std::ranges::find_if(
        main->grids(), [&](const VoluteGrid& one) { return one.info.name == name; });
    GridTarget& target = all.targets.emplace_back();
    target.description = descriptionOf(*grid, extraction);
    if (grid->empty) {
      target.info = grid->info;
      target.info.frames = static_cast<int>(extraction.positions.size());
      target.info.frameNumbers.clear(), target.info.times.clear();
      for (const int position : extraction.positions) {
        target.info.frameNumbers.push_back(grid->info.frameNumbers[static_cast<std::size_t>(position)]);
        target.info.times.push_back(grid->info.times[static_cast<std::size_t>(position)]);
      }
      all.sources.push_back(nullptr);
      all.readers.push_back(nullptr);
      continue;
    }
    VOLUTE_ASSIGN(auto reader, openVolute(path, partial, reading, true, name));
    Extraction own = extraction;
    own.region = {{0, 0, 0}, {grid->info.x, grid->info.y, grid->info.z}};
    own.maxMemory = static_cast<std::uint64_t>(static_cast<double>(extraction.maxMemory) *
                                               static_cast<double>(grid->info.frameValues()) / voxels);
    VOLUTE_ASSIGN(auto source, ExtractSource::create(reader, std::move(own), reading.progress));
    target.info = source->info();
    all.sources.push_back(std::move(source));
    all.readers.push_back(std::move(reader));
  }
  return all;
}

Status extractFrames(const std::vector<std::unique_ptr<FrameSource>>& sources,
                     const std::vector<int>& positions, const MakeSink& makeSink,
                     Reading& reading, Team& team) {
  const auto frames = static_cast<std::int64_t>(positions.size());
  std::unique_ptr<CacheSink> sink;
  const auto make = [&]() -> Status {
    VOLUTE_ASSIGN(sink, makeSink());
    return {};
  };
  VOLUTE_TRY(team.agree(team.leads() ? make() : Status()));
  GridValues values;
  if (team.size() == 1) {
    for (std::int64_t i = 0; i < frames; ++i) {
      if (reading.progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped: extracting frame {} of {}", i + 1, frames);
      VOLUTE_TRY(readFrames(sources, static_cast<int>(i), values));
      VOLUTE_TRY(sink->writeFrame(values));
      reading.progress.report("extracting", static_cast<double>(i + 1), static_cast<double>(frames));
    }
    return sink->finish();
  }
  std::vector<std::size_t> begins;  // of rows
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (i == 0 || positions[i] / BlockGrid::kSide != positions[i - 1] / BlockGrid::kSide)
      begins.push_back(i);
  }
  begins.push_back(positions.size());
  std::vector<std::size_t> counts;
  for (const auto& source : sources)
    counts.push_back(source ? source->info().frameValues() : 0);
  GridValues taken;
  OrderedDelivery delivery(
      team, frames, reading.maxMemory / 8, [&](std::int64_t, const OrderedDelivery::Bytes& bytes) {
        taken.resize(counts.size());
        std::size_t at = 0;
        for (std::size_t i = 0; i < counts.size(); ++i) {
          taken[i].resize(counts[i]);
          if (counts[i] > 0)
            std::memcpy(taken[i].data(), bytes.data() + at, 4 * counts[i]);
          at += 4 * counts[i];
        }
        return sink->writeFrame(taken);
      });
  VOLUTE_TRY(team.forUnits(
      "extracting", static_cast<std::int64_t>(begins.size() - 1), reading.progress,
      [&](std::int64_t row) -> Status {
        const auto at = static_cast<std::size_t>(row);
        for (std::size_t i = begins[at]; i < begins[at + 1]; ++i) {
          if (reading.progress.cancelled())
            return fail(ErrorCode::kCancelled, "stopped: extracting frame {} of {}", i + 1, frames);
          VOLUTE_TRY(readFrames(sources, static_cast<int>(i), values));
          OrderedDelivery::Bytes bytes;
          for (const auto& grid : values) {
            const auto own = std::as_bytes(std::span(grid));
            bytes.insert(bytes.end(), own.begin(), own.end());
          }
          VOLUTE_TRY(delivery.give(static_cast<std::int64_t>(i), std::move(bytes)));
        }
        return {};
      },
      [&] { return delivery.finish(); }));
  return team.agree(sink ? sink->finish() : Status());
}

}  // namespace volute
