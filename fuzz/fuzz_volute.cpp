// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "volute/base/parallel.hpp"
#include "volute/codec/volute_reader.hpp"

namespace {

constexpr std::uint64_t kMaxMemory = std::uint64_t{64} << 20;

/// A small file may state millions of blocks; one of 16^4 voxels takes a millisecond.
std::vector<std::size_t> someBlocks(std::size_t count) {
  if (count < 2)
    return std::vector<std::size_t>(count);
  return {0, count - 1};
}

void requireFinite(std::span<const float> values) {
  if (!std::ranges::all_of(values, [](float value) { return std::isfinite(value); }))
    std::abort();
}

// Everything that a caller can ask of a grid; errors are fine, crashes and values that are not
// finite are not. Returns whether it opened.
bool readGrid(const std::string& path, bool partial, const std::string& name,
              std::vector<std::string>* others) {
  const auto reader = volute::VoluteReader::open(path, {partial, kMaxMemory, name});
  if (!reader)
    return false;
  for (const volute::VoluteGrid& grid : reader->grids()) {
    if (others && grid.info.name != reader->info().name)
      others->push_back(grid.info.name);
    if (grid.info.frames != reader->info().frames)
      std::abort();
  }
  const volute::BlockGrid& grid = reader->blocks();
  if (grid.count() > 100000)
    return true;
  (void)reader->verify();
  std::vector<float> values;
  for (const std::size_t block : someBlocks(grid.count())) {
    values.resize(grid.values(block));
    for (const int levels : {1, 99}) {
      if (reader->readBlock(block, values, levels))
        requireFinite(values);
    }
  }
  const auto& extents = grid.volumeExtents();
  const int z = std::min(extents[1], 20);
  const int y = std::min(extents[2], 20);
  const int x = std::min(extents[3], 20);
  values.resize(static_cast<std::size_t>(z) * y * x * grid.channels());
  if (reader->readRegion(extents[0] - 1, {0, 0, 0}, {z, y, x}, values))
    requireFinite(values);
  return true;
}

bool readEverything(const std::string& path, bool partial) {
  constexpr std::size_t kMostGrids = 4;
  std::vector<std::string> others;
  const bool opened = readGrid(path, partial, "", &others);
  for (std::size_t i = 0; i < std::min(others.size(), kMostGrids); ++i)
    readGrid(path, partial, others[i], nullptr);
  return opened;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::ThreadLimit limit(1);
  static const int file = ::memfd_create("fuzz.volute", 0);
  if (::ftruncate(file, 0) != 0 || ::pwrite(file, data, size, 0) != static_cast<ssize_t>(size))
    std::abort();
  const std::string path = "/proc/self/fd/" + std::to_string(file);
  if (!readEverything(path, false))
    readEverything(path, true);
  return 0;
}
