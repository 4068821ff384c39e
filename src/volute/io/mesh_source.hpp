// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/remark.hpp"
#include "volute/base/result.hpp"
#include "volute/io/memory_mesh.hpp"
#include "volute/io/mesh.hpp"
#include "volute/tetmesh/spatial_order.hpp"
#include "volute/tetmesh/tet_field.hpp"
#include "volute/tetmesh/tet_locator.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// One stored frame of a case. Vertices and tets are reordered so that those near in space are near
/// in memory; the order depends only on the file's mesh.
struct MeshFrame {
  std::shared_ptr<const TetMesh> mesh;
  std::shared_ptr<const std::vector<ThinWall>> walls{};  ///< within the mesh; null: none
  std::vector<float> values;                             ///< one for each vertex of the mesh, >= 0
  std::string field;
  std::string others;          ///< other available fields, as readable text
  std::size_t clamped = 0;     ///< negative values that were set to 0
  bool ofCells = false;        ///< the file has cell values, which were converted to point values
  std::vector<float> cells{};  ///< these, as the file has them, where they are asked for
  std::uint64_t ghosts = 0;    ///< cells that the file marks as ghosts, which are left out
  std::uint64_t unused = 0;    ///< points that no cell has, which are left out
  double unusedMost = 0;       ///< the largest value of these
  /// Powers of kg, m, s, K, mol, A and cd, where the file states them (OpenFOAM).
  std::optional<std::array<double, 7>> dimensions{};
};

struct MeshOptions {
  std::string field{};  ///< empty: the only scalar, or the one called "density"
  Negatives negatives = Negatives::kRefuse;
  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes], for reading one frame
  std::uint64_t perTet = 0;  ///< additional bytes of maxMemory that the caller needs per tet
  std::string alsoField{};   ///< one that is read from the same times; frames without it are absent
  MeshShare share{};         ///< of the pieces of a .pvtu; shared points are in each piece
  CellMean mean = CellMean::kValues;  ///< what is conserved where values of cells go to points
  bool keepsCells = false;            ///< frames have their values of cells too
};

/// The contents of a case at one stored time, for all its fields.
struct MeshDescription {
  MeshContents contents;
  std::vector<MeshFieldSummary> fields;
  Result<std::shared_ptr<const TetMesh>> mesh;  ///< or why its cells cannot be used
};

/// Whether a file's name is that of a case that MeshSource reads besides .vtu and .pvd: EnSight,
/// Exodus, OpenFOAM, legacy VTK or .pvtu.
bool isMeshCase(const std::filesystem::path& path);

/// Smoke on a mesh over time: a .vtu, .pvtu or legacy .vtk file, a .pvd series of .vtu or .pvtu, or
/// a case of EnSight Gold (.case), Exodus (.e, .ex2, .exo, .exii) or OpenFOAM (.foam). Cells are
/// split into tets, cell values become point values; blocks of a case and pieces of a .pvtu
/// are joined where their points are equal. Files are read in a child process.
class MeshSource {
 public:
  [[nodiscard]] static Result<MeshSource> open(const std::filesystem::path& path,
                                               const MeshOptions& options = {});

  /// A valid mesh in memory, without a copy of it. Errors call it `name`.
  static MeshSource of(std::shared_ptr<const MemoryMesh> mesh, const std::filesystem::path& name,
                       const MeshOptions& options = {});

  /// The same case for another field.
  [[nodiscard]] Result<MeshSource> withField(const std::string& field, Negatives negatives) const;

  /// The file or pattern that was opened.
  const std::filesystem::path& path() const { return path_; }

  /// [s], ascending; a single file is at 0.
  std::span<const double> times() const { return times_; }

  /// The number of a frame for --frames: the last number in its file's name if a .pvd names files
  /// in ascending order of these, as for volumes; else its position.
  int numberOf(std::size_t frame) const { return numbers_[frame]; }

  /// Reads one frame. Frames with equal cells share a mesh. Where values are of cells, points get
  /// the mean by volume times `weights`, one for each cell; empty: all are 1.
  [[nodiscard]] Result<MeshFrame> read(std::size_t frame, std::span<const float> weights = {});

  /// The contents of one frame. Fails if the file cannot be read; that a mesh cannot be used is
  /// part of the description.
  [[nodiscard]] Result<MeshDescription> describe(std::size_t frame) const;

  /// Times [s] at which the field is not there, in ascending order, and why: they are left out of
  /// times(). Found on opening where the head of a file says which fields it has (.vtu and .pvtu in
  /// a .pvd, OpenFOAM where the field is named), and where an Exodus file ends in records that were
  /// never written; elsewhere reading such a frame is an error.
  std::span<const double> absent() const { return absent_; }

  /// What absent() comes to, as a sentence; empty: nothing is absent.
  std::string absentText() const;

  /// What a .pvd says against its files (contradictionOf()), and what an OpenFOAM case has besides
  /// (foamRemarks()).
  std::span<const Remark> remarks() const { return remarks_; }

  /// The names of the fields at each time, where that is told without reading them: of each file of
  /// a .pvd (of absent ones too), of each time's folder of OpenFOAM; else empty.
  std::vector<std::vector<std::string>> fieldNames() const;

  /// The file of a frame.
  const std::filesystem::path& file(std::size_t frame) const { return locations_[frame].file; }

 private:
  [[nodiscard]] static Result<MeshSource> list(const std::filesystem::path& path,
                                               const MeshOptions& options);

  /// Location of a frame: a file, and the position in it.
  struct FrameLocation {
    std::filesystem::path file;
    std::size_t index = 0;
  };

  /// What a frame's file holds, or the mesh in memory.
  [[nodiscard]] Result<MeshData> dataOf(std::size_t frame, const std::string& field) const;

  [[nodiscard]] Status leaveOutAbsent(const std::filesystem::path& path);
  void readHeads();
  void keepTimesOf(const std::filesystem::path& path);
  [[nodiscard]] Status leaveOutUnwritten();
  template <class Absent>
  void leaveOut(const Absent& isAbsent);
  [[nodiscard]] Status settleSeries(const MeshData& data, std::size_t frame);
  [[nodiscard]] Status checkScale(const CellSoup& soup, std::size_t frame) const;
  [[nodiscard]] Status takeCells(const CellSoup& soup, const std::string& file);
  double clearUnused(std::span<float> values) const;
  [[nodiscard]] Status takeWalls(std::span<const WallCorners> corners, const std::string& file);

  std::filesystem::path path_;
  std::shared_ptr<const MemoryMesh> memory_;  // null: files
  std::vector<FrameLocation> locations_;
  std::vector<double> absent_;
  std::string absentWhat_;  // what is absent then
  std::vector<Remark> remarks_;
  std::vector<std::vector<MeshFieldSummary>> fieldLists_;
  // What the first frame that was read settled for all.
  std::string settledField_;
  bool settledOfCells_ = false;
  std::optional<std::array<double, 7>> settledDimensions_;
  std::vector<double> times_;
  std::vector<int> numbers_;
  MeshOptions options_;
  std::shared_ptr<const TetMesh> mesh_;  // of the last frame, made of:
  CellSoup soup_;                        // of files
  std::vector<WallCorners> wallCorners_;
  std::shared_ptr<const std::vector<ThinWall>> walls_;
  AddedVertices added_;
  std::vector<std::int32_t> vertexFrom_;  // of each vertex: the soup's, then the added ones
  std::vector<std::int32_t> cellOf_;      // of each tet
  std::vector<std::int32_t> unused_;      // vertices of the soup
};

}  // namespace volute
