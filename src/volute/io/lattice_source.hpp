// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "volute/base/frame_name.hpp"
#include "volute/io/lattice.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {

class ReaderProcess;

/// One file of a sequence on a lattice.
struct LatticeFile {
  int number = 0;
  std::filesystem::path path;
  std::optional<double>
      time;               ///< [s]; when not stated the file may state it, else the numbers give it
  FrameScale scale{};     ///< of the number
  std::string written{};  ///< the number as it stands in the file's name; empty: it does not

  std::string frameText() const { return volute::frameText(number, scale); }
};

/// What is known of a grid that is read for a cache.
struct KnownGrid {
  std::string name;
  std::vector<LatticeFrame> frames;  ///< of each file; those of files without it have an empty box
  std::vector<bool> present;         ///< whether each file has the grid
  std::array<double, 3> background{};  ///< of each channel, in files without it
  std::string missing{};               ///< of the first file without it; empty: all have it
};

/// A sequence of files, each with a grid. Where their lattices of voxels are not one along the
/// axes, with origins that differ by whole voxels, the source is one of PlacedFrames. Without
/// bounds the volume is the least box around all files' values.
/// @param loadPlugin  called in the child process that reads the files.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> openLatticeSource(
    std::vector<LatticeFile> files, Result<const LatticePlugin*> (*loadPlugin)(),
    const SourceOptions& options);

/// The same of a grid that was described before.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> openLatticeSource(
    std::vector<LatticeFile> files, Result<const LatticePlugin*> (*loadPlugin)(),
    const SourceOptions& options, KnownGrid known);

/// How far the origin of each frame lies from that of the first [voxels], and the least box around
/// the values of all, on the first one's lattice. Where they are not on one, no frame is shifted,
/// and each has a matrix from index to world.
struct LatticePlaces {
  std::vector<std::array<std::int64_t, 3>> shifts;
  IndexBox box;
  std::vector<GridMatrix> matrices{};
};

[[nodiscard]] Result<LatticePlaces> latticePlaces(const std::vector<LatticeFile>& files,
                                                  const std::vector<LatticeFrame>& frames);

/// What each file of a cache says, all read in one child process.
[[nodiscard]] Result<std::vector<LatticeCache>> describeCache(const std::vector<LatticeFile>& files,
                                                              std::uint64_t maxMemory);

/// Grids of such files as bytes, read in a child process too.
class KeptReader {
 public:
  KeptReader(const std::vector<LatticeFile>& files, std::uint64_t maxMemory);
  ~KeptReader();

  /// @param grid  its position in LatticeCache::grids of this file
  /// @return good until the next call
  [[nodiscard]] Result<std::unique_ptr<KeptBytes>> open(const std::filesystem::path& file,
                                                        std::size_t grid) const;

 private:
  std::unique_ptr<ReaderProcess> process_;
  std::uint64_t maxMemory_;
};

/// All grids of a .vdb file, read in a child process as well.
[[nodiscard]] Result<std::vector<GridFacts>> listGrids(const std::filesystem::path& file,
                                                       std::uint64_t maxMemory);

/// The files of a collection, read in a child process as well.
[[nodiscard]] Result<std::vector<TimedFile>> readCollection(
    const std::filesystem::path& collection, Result<const LatticePlugin*> (*loadPlugin)());

}  // namespace volute
