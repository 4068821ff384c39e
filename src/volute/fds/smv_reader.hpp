// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/file_as_written.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/fds/text_lines.hpp"

// Inside of SmvIndex::read(): meshes are read in smv_index.cpp, files that are named in
// smv_files.cpp.

namespace volute {

/// The kind of a file of particles whose classes the index does not have, such as people.
inline constexpr const char* kUnknownParticles = "particles of unknown classes";

/// Reads the file block by block: a keyword at the begin of a line, then lines that begin with a
/// space or are counted.
class SmvReader {
 public:
  SmvReader(TextLines lines, std::uint64_t maxMemory)
      : lines_(std::move(lines)), maxMemory_(maxMemory) {
    index_.path = lines_.path();
  }

  Result<SmvIndex> read();

 private:
  using Handler = Status (SmvReader::*)(std::string_view rest);

  Result<std::optional<std::string>> nextLine();
  Result<std::string> need(std::string_view what);
  Result<std::vector<double>> numbers(std::string_view what, std::size_t least);
  Result<int> count(std::string_view what);
  Result<int> meshNumber(std::string_view rest);
  Status handle(std::string_view line);
  tl::unexpected<Error> wrong(std::string_view expected) const;

  Status text(std::string& into, std::string_view what);
  Result<std::filesystem::path> file(std::string_view what);
  Status claim(const std::filesystem::path& file, int mesh);
  Status readVersion(std::string_view);
  Status readTitle(std::string_view);
  Status readChid(std::string_view);
  Status readInput(std::string_view);
  Status readEnd(std::string_view);
  Status readMeshCount(std::string_view);
  Status readAlbedo(std::string_view);
  Status readFireCutoff(std::string_view);
  Status readHeatRange(std::string_view);
  Status readNorth(std::string_view);
  Status readTemperatureRange(std::string_view);
  Status readTable(std::string_view);
  Status readBoundary(std::string_view rest);
  Status readParticleClass(std::string_view);
  Status readParticles(std::string_view rest);
  Status readSurfaces(std::string_view rest, bool coloured);

  Status readIsosurface(std::string_view rest) { return readSurfaces(rest, false); }

  Status readColouredIsosurface(std::string_view rest) { return readSurfaces(rest, true); }

  Status readSurface(std::string_view);
  Status readOffset(std::string_view);
  Status readGrid(std::string_view rest);
  Status readExtent(std::string_view);
  Status checkPlanes(int axis, const std::vector<double>& planes) const;
  Status readPlanes(int axis);

  Status readTrnx(std::string_view) { return readPlanes(0); }

  Status readTrny(std::string_view) { return readPlanes(1); }

  Status readTrnz(std::string_view) { return readPlanes(2); }

  Status readObstructions(std::string_view);
  Status readVents(std::string_view);
  Status readDevice(std::string_view);
  Status readActivation(std::string_view);
  Status readLabels(FdsLabels& labels);
  Status readSliceNodes(std::string_view rest);
  Status readSliceCells(std::string_view rest);
  Status readSlice(std::string_view rest, bool cellCentred);
  Status readSmoke(std::string_view rest);
  Status readPlot(std::string_view rest);
  Status readEvent(std::string_view rest, bool ofVent, bool shown);

  Status showObstruction(std::string_view rest) { return readEvent(rest, false, true); }

  Status hideObstruction(std::string_view rest) { return readEvent(rest, false, false); }

  Status openVent(std::string_view rest) { return readEvent(rest, true, true); }

  Status closeVent(std::string_view rest) { return readEvent(rest, true, false); }

  Status readGeometry(std::string_view);
  Status readCutFaces(std::string_view);

  Result<FdsMesh*> lastMesh();
  Status checkEnds(const FdsMesh& mesh, const FdsNodeBox& box, const std::array<float, 6>& ends);
  Result<FdsNodeBox> nodeBox(std::span<const double> indices);
  Result<int> surface(double number);
  Status hold(double boxes);
  Status finish();
  void leaveOutEvacuation();
  void findInput();

  TextLines lines_;
  std::uint64_t maxMemory_;
  double boxes_ = 0;  // obstructions and vents so far
  SmvIndex index_;
  std::optional<int> meshCount_;
  std::array<int, 3> cells_{};                   // of the mesh that is being read
  std::optional<std::array<double, 6>> extent_;  // of that mesh by PDIM [m]
  std::vector<int> blocks_;                      // of each mesh: 1 with obstructions, 2 with vents
  int cutFaces_ = 0;                             // blocks of GEOM's triangles, cut by cells
  bool cutOff_ = false;                          // the file ended within a block
  std::map<std::string, int> skippedSlices_;
  std::string inputName_;
  std::string unreadSmoke_;            // the keyword of smoke in another format
  std::map<std::string, int> owners_;  // of files: meshes
  FilesAsWritten files_;
};

}  // namespace volute
