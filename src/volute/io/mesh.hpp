// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/tetmesh/split_cells.hpp"

namespace volute {

/// Which pieces of a mesh in several are read: all of them, or an even share.
struct MeshShare {
  int index = 0, count = 1;

  friend bool operator==(const MeshShare&, const MeshShare&) = default;
};

/// What a file's mesh takes. Trivially copyable: it crosses from the process that reads the file.
struct MeshSize {
  static constexpr std::size_t kMaxName = 255;

  char field[kMaxName + 1] = {};  ///< the name, ends in 0
  char others[kMaxName + 1] =
      {};                ///< the names of fields that were not chosen, as people read them
  bool ofCells = false;  ///< a value for each cell, else for each point
  std::uint64_t points = 0;
  std::uint64_t cells = 0;  ///< those with a volume
  std::uint64_t indices = 0;
  std::uint64_t walls = 0;   ///< triangles of them
  bool bare = false;         ///< without a field
  std::uint64_t ghosts = 0;  ///< cells that are marked as ghosts, which are left out
  /// Powers of kg, m, s, K, mol, A and cd, where the file states them (OpenFOAM).
  bool hasDimensions = false;
  std::array<double, 7> dimensions{};

  std::uint64_t values() const { return bare ? 0 : ofCells ? cells : points; }

  /// Makes it safe to use where it comes from another process: names that end, counts whose bytes
  /// can be counted.
  bool sound() {
    field[kMaxName] = '\0';
    others[kMaxName] = '\0';
    constexpr std::uint64_t kMax = std::uint64_t{1} << 40;
    return points < kMax && cells < kMax && indices < kMax && walls < kMax;
  }
};

/// A field that a file has. Trivially copyable.
struct MeshFieldSummary {
  char name[MeshSize::kMaxName + 1] = {};
  bool ofCells = false;
  std::int32_t components = 1;
  double least = 0, most = 0;   ///< of its finite values; of a vector its length
  std::uint64_t notFinite = 0;  ///< how many values are
};

/// What the head of a file of one frame says.
struct MeshHead {
  double time = std::numeric_limits<double>::quiet_NaN();  ///< [s]; NaN: not stated
  std::vector<MeshFieldSummary> fields{};                  ///< without their values
};

/// What a file has in one frame. Trivially copyable.
struct MeshContents {
  MeshSize size;
  std::array<std::uint64_t, 5> shapes{};      ///< how many cells of each CellShape
  std::uint64_t surfaces = 0;                 ///< cells without a volume, which are left out
  std::int32_t blocks = 1;                    ///< joined to one mesh
  std::uint64_t walls = 0;                    ///< faces of walls with cells on both sides
  char partial[MeshSize::kMaxName + 1] = {};  ///< fields that not all blocks have, for people
};

/// Three vertices of a wall with cells on both sides, which have vertices of their own there.
using WallCorners = std::array<std::int64_t, 3>;

/// Cells and one field of a file.
struct MeshData {
  CellSoup soup;
  std::vector<WallCorners> walls{};
  std::vector<float> values;
  bool ofCells = false;
  std::string field;
  std::string others;                               ///< fields that were not chosen
  std::optional<std::array<double, 7>> dimensions;  ///< as in MeshSize
  std::uint64_t ghosts = 0;                         ///< as in MeshSize
};

/// What a library that knows a mesh format does with one file. Used inside a child process
/// (ReaderProcess), because damaged files may crash such libraries.
class MeshReader {
 public:
  virtual ~MeshReader() = default;

  /// The times that a file has [s], ascending; of a file that says nothing of time, 0.
  [[nodiscard]] virtual Result<std::vector<double>> times(const std::filesystem::path& file) = 0;

  /// Reads one frame of the file, counted from 0; the field named `field`, or the only scalar
  /// when it is empty. An error lists the fields that are there. kUnsupported for a share of a file
  /// that names no pieces.
  [[nodiscard]] virtual Result<MeshSize> load(const std::filesystem::path& file, std::size_t frame,
                                              const std::string& field, const MeshShare& share) = 0;

  /// Reads no more of a file of one frame than what says so.
  [[nodiscard]] virtual Result<MeshHead> head(const std::filesystem::path& file) = 0;

  /// Reads one frame without values; take() gives its cells.
  [[nodiscard]] virtual Result<std::pair<MeshContents, std::vector<MeshFieldSummary>>> describe(
      const std::filesystem::path& file, std::size_t frame) = 0;

  /// Hands over the mesh that was loaded or described.
  [[nodiscard]] virtual Result<MeshData> take() = 0;
};

/// What a plug-in for a mesh format offers.
struct MeshPlugin {
  std::unique_ptr<MeshReader> (*makeReader)();
};

}  // namespace volute
