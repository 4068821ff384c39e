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

/// A small file may state millions of blocks, and one of 16^4 voxels takes a millisecond: so much
/// is decoded for one input.
class Work {
 public:
  explicit Work(std::size_t size) : turn_(size) {}

  /// Whether `values` more may be decoded; the first always, whatever its size.
  bool allows(std::size_t values) {
    constexpr std::size_t kMaxValues = std::size_t{1} << 15;
    if (done_ > 0 && values > kMaxValues - std::min(done_, kMaxValues))
      return false;
    done_ += values;
    return true;
  }

  /// Inputs of other sizes begin with another way to decode, so that none is left out.
  std::size_t turn() const { return turn_; }

 private:
  std::size_t turn_;
  std::size_t done_ = 0;
};

void requireFinite(std::span<const float> values) {
  if (!std::ranges::all_of(values, [](float value) { return std::isfinite(value); }))
    std::abort();
}

void decodeBlock(const volute::VoluteReader& reader, std::size_t block, int levels, Work& work) {
  const std::size_t count = reader.blocks().values(block);
  if (!work.allows(count))
    return;
  static std::vector<float> values;
  values.resize(count);
  if (reader.readBlock(block, values, levels))
    requireFinite(values);
}

/// Up to 20 voxels on each axis are of two blocks on each, which are decoded whole; 4 are of one.
void decodeRegion(const volute::VoluteReader& reader, Work& work) {
  const volute::BlockGrid& grid = reader.blocks();
  const auto& extents = grid.volumeExtents();
  const std::size_t block = grid.values(grid.count() - 1);
  const int most = work.allows(8 * block) ? 20 : 4;
  if (most == 4 && !work.allows(block))
    return;
  const int z = std::min(extents[1], most);
  const int y = std::min(extents[2], most);
  const int x = std::min(extents[3], most);
  static std::vector<float> values;
  values.resize(static_cast<std::size_t>(z) * y * x * grid.channels());
  if (reader.readRegion(extents[0] - 1, {0, 0, 0}, {z, y, x}, values))
    requireFinite(values);
}

// Everything that a caller can ask of a grid; errors are fine, crashes and values that are not
// finite are not. Returns whether it opened.
bool readGrid(const std::string& path, bool partial, const std::string& name, Work& work,
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
  if (grid.count() == 0 || grid.count() > 100000)
    return true;
  (void)reader->verify();
  constexpr std::size_t kWays = 4;
  for (std::size_t way = 0; way < kWays; ++way) {
    switch ((work.turn() + way) % kWays) {
      case 0:
        decodeBlock(*reader, 0, 99, work);
        break;
      case 1:
        decodeBlock(*reader, grid.count() - 1, 99, work);
        break;
      case 2:
        decodeBlock(*reader, 0, 1, work);
        break;
      default:
        decodeRegion(*reader, work);
    }
  }
  return true;
}

bool readEverything(const std::string& path, bool partial, std::size_t size) {
  constexpr std::size_t kMaxGrids = 4;
  Work work(size);
  std::vector<std::string> others;
  const bool opened = readGrid(path, partial, "", work, &others);
  for (std::size_t i = 0; i < std::min(others.size(), kMaxGrids); ++i)
    readGrid(path, partial, others[i], work, nullptr);
  return opened;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::ThreadLimit limit(1);
  static const int file = ::memfd_create("fuzz.volute", 0);
  if (::ftruncate(file, 0) != 0 || ::pwrite(file, data, size, 0) != static_cast<ssize_t>(size))
    std::abort();
  const std::string path = "/proc/self/fd/" + std::to_string(file);
  if (!readEverything(path, false, size))
    readEverything(path, true, size);
  return 0;
}
