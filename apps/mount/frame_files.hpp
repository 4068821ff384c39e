// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/codec/volute_reader.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/io/lattice.hpp"

namespace volute {

/// Bytes of a file that is in memory alone.
class MemoryFile {
 public:
  [[nodiscard]] static Result<MemoryFile> create(const std::string& name);

  ~MemoryFile();
  MemoryFile(MemoryFile&& other) noexcept;
  MemoryFile& operator=(MemoryFile&&) = delete;

  /// By which somebody can write it.
  std::string path() const;

  [[nodiscard]] Result<std::uint64_t> size() const;

  /// Bytes read, or -errno.
  long read(char* to, std::size_t count, std::uint64_t offset) const;

 private:
  explicit MemoryFile(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
};

/// The frames of a .volute file, with all of its grids, as .vdb files that are made when somebody
/// wants them: the bytes that `volute extract` writes. Threads may share it; one file at a time is
/// made, on all cores.
class FrameFiles {
 public:
  struct File {
    explicit File(MemoryFile whole) : bytes(std::move(whole)) {}

    MemoryFile bytes;
    std::uint64_t size = 0;
  };

  /// @param rate  frames per second, instead of the times that the file states
  /// @param maxMemory  [bytes] for decoded blocks and files; files that are open may be beyond it
  [[nodiscard]] static Result<std::unique_ptr<FrameFiles>> open(const std::string& path,
                                                                const std::optional<double>& rate,
                                                                std::uint64_t maxMemory);

  /// STEM_0001.vdb and so on, by the frames' numbers, ascending, with digits as the .vdb files had
  /// that it was made of.
  const std::vector<std::string>& names() const { return names_; }

  std::optional<std::size_t> find(std::string_view name) const;

  /// Of its first grid that has values.
  const VolumeInfo& info() const { return frames_; }

  /// How large a file is, which nobody knows before it was made once.
  [[nodiscard]] Result<std::uint64_t> size(std::size_t frame);

  [[nodiscard]] Result<std::shared_ptr<const File>> file(std::size_t frame);

 private:
  /// One grid.
  struct Volume {
    std::unique_ptr<FrameSource> source;  ///< null: it is empty
    VolumeInfo info;
    GridDescription description;
    double offset = 0;  ///< values are differences from it
    Bricks bricks;      ///< a frame
  };

  explicit FrameFiles(std::uint64_t maxMemory) : maxMemory_(maxMemory) {}

  [[nodiscard]] Status openGrids(const std::string& path, const std::optional<double>& rate);
  [[nodiscard]] Status writeFrame(const std::string& file, std::size_t frame);

  std::shared_ptr<const File> kept(std::size_t frame);
  void keep(std::size_t frame, std::shared_ptr<const File> file);
  [[nodiscard]] Result<std::shared_ptr<const File>> make(std::size_t frame);

  std::uint64_t maxMemory_;
  VolumeInfo frames_;
  bool plain_ = true;  ///< one grid, of which no cache has said anything
  FrameMetadata fileMetadata_;
  std::vector<std::string> names_;

  std::mutex making_;  // of what follows
  std::unique_ptr<LatticeWriter> writer_;
  std::vector<Volume> volumes_;
  std::unique_ptr<VoluteReader> whole_;  ///< of the grids that are kept as bytes

  std::mutex keeping_;                                                    // of what follows
  std::vector<std::uint64_t> sizes_;                                      // 0: not known
  std::list<std::pair<std::size_t, std::shared_ptr<const File>>> files_;  // the last one used first
};

}  // namespace volute
