// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <string_view>

#include "volute/base/file_name.hpp"
#include "volute/io/ensight_files.hpp"
#include "volute/io/foam_files.hpp"
#include "volute/io/grid_choice.hpp"
#include "volute/io/mesh.hpp"
#include "volute/io/mesh_walls.hpp"
#include "volute/io/vtk_cases.hpp"
#include "volute/io/vtk_errors.hpp"

namespace volute {
namespace {

struct Field {
  vtkDataArray* array = nullptr;
  bool ofCells = false;
};

void listFields(vtkDataSetAttributes* data, bool ofCells, std::vector<GridEntry>& names,
                std::vector<Field>& fields) {
  for (int i = 0; i < data->GetNumberOfArrays(); ++i) {
    vtkDataArray* array = data->GetArray(i);
    // What ParaView adds.
    if (!array || !array->GetName() || std::string_view(array->GetName()).starts_with("vtkGhost"))
      continue;
    const int components = array->GetNumberOfComponents();
    const auto what = components == 1 ? "scalar" : fmt::format("vector of {}", components);
    names.push_back({array->GetName(), fmt::format("{}, of {}", what, ofCells ? "cells" : "points"),
                     components == 1});
    fields.push_back({array, ofCells});
  }
}

void listFields(vtkUnstructuredGrid* grid, std::vector<GridEntry>& names,
                std::vector<Field>& fields) {
  listFields(grid->GetPointData(), false, names, fields);
  listFields(grid->GetCellData(), true, names, fields);
  tellApart(names, [&](std::size_t i) { return fields[i].ofCells; });
}

/// Calls each(place) for the points of a cell, places in a list as appendCell() makes it.
template <class Each>
void forPoints(CellShape shape, std::span<const std::int64_t> cell, const Each& each) {
  if (shape != CellShape::kPolyhedron) {
    for (std::size_t i = 0; i < cell.size(); ++i) each(i);
    return;
  }
  for (std::size_t at = 1; at < cell.size();) {  // faces, each with its count before it
    const std::size_t end = std::min(
        cell.size(), at + 1 + static_cast<std::size_t>(std::max<std::int64_t>(cell[at], 0)));
    for (++at; at < end; ++at) each(at);
  }
}

/// The shape of a cell with a volume; none for points, lines and surfaces.
Result<std::optional<CellShape>> shapeOf(int type, const std::string& file) {
  switch (type) {
    case VTK_TETRA:
      return CellShape::kTet;
    case VTK_PYRAMID:
      return CellShape::kPyramid;
    case VTK_WEDGE:
      return CellShape::kWedge;
    case VTK_HEXAHEDRON:
    case VTK_VOXEL:
      return CellShape::kHexahedron;
    case VTK_POLYHEDRON:
      return CellShape::kPolyhedron;
    default:
      if (type <= VTK_QUAD)
        return std::nullopt;
      return fail(ErrorCode::kUnsupported,
                  "{}: has cells of VTK type {}; expected tetrahedra, pyramids, wedges, hexahedra, "
                  "voxels or polyhedra; make the mesh linear",
                  file, type);
  }
}

/// How many points the type of a cell says, and how many it has: VTK never compares them.
Status checkPointCount(vtkUnstructuredGrid* grid, vtkIdType cell, const std::string& file) {
  static constexpr std::array<std::pair<int, int>, 10> kCounts = {{{VTK_VERTEX, 1},
                                                                   {VTK_LINE, 2},
                                                                   {VTK_TRIANGLE, 3},
                                                                   {VTK_PIXEL, 4},
                                                                   {VTK_QUAD, 4},
                                                                   {VTK_TETRA, 4},
                                                                   {VTK_PYRAMID, 5},
                                                                   {VTK_WEDGE, 6},
                                                                   {VTK_HEXAHEDRON, 8},
                                                                   {VTK_VOXEL, 8}}};
  const int type = grid->GetCellType(cell);
  const auto rule = std::ranges::find(kCounts, type, &std::pair<int, int>::first);
  vtkIdType found = 0;
  const vtkIdType* points = nullptr;
  grid->GetCellPoints(cell, found, points);
  if (rule == kCounts.end() || rule->second == found)
    return {};
  return fail(ErrorCode::kInvalidData,
              "{}: cell {} is of VTK type {} and has {} points; expected {}: the file is damaged",
              file, cell, type, found, rule->second);
}

void appendCell(vtkUnstructuredGrid* grid, vtkIdType cell, vtkIdList* ids,
                std::vector<std::int64_t>& out) {
  const int type = grid->GetCellType(cell);
  if (type == VTK_POLYHEDRON)
    grid->GetFaceStream(cell, ids);
  else
    grid->GetCellPoints(cell, ids);
  const auto begin = out.size();
  for (vtkIdType i = 0; i < ids->GetNumberOfIds(); ++i) out.push_back(ids->GetId(i));
  if (type == VTK_VOXEL && ids->GetNumberOfIds() == 8) {  // rows, not rounds
    std::swap(out[begin + 2], out[begin + 3]);
    std::swap(out[begin + 6], out[begin + 7]);
  }
}

/// @param leftOut  points that are, or empty
MeshFieldSummary summaryOf(const Field& field, std::span<const std::uint8_t> leftOut) {
  MeshFieldSummary summary;
  std::string(field.array->GetName()).copy(summary.name, MeshSize::kMaxName);
  summary.ofCells = field.ofCells;
  summary.components = field.array->GetNumberOfComponents();
  bool any = false;
  for (vtkIdType i = 0; i < field.array->GetNumberOfTuples(); ++i) {
    if (!field.ofCells && !leftOut.empty() && leftOut[static_cast<std::size_t>(i)] != 0)
      continue;
    double value = field.array->GetComponent(i, 0);
    for (int c = 1; c < summary.components; ++c)
      value = std::hypot(value, field.array->GetComponent(i, c));
    if (summary.components > 1)
      value = std::abs(value);
    if (!std::isfinite(value)) {
      ++summary.notFinite;
      continue;
    }
    summary.least = any ? std::min(summary.least, value) : value;
    summary.most = any ? std::max(summary.most, value) : value;
    any = true;
  }
  return summary;
}

class VtkMeshReader final : public MeshReader {
 public:
  Result<std::vector<double>> times(const std::filesystem::path& path) override {
    return readVtkTimes(path);
  }

  Result<MeshSize> load(const std::filesystem::path& path, std::size_t frame,
                        const std::string& wanted, const MeshShare& share) override {
    const std::string file = path.string();
    VOLUTE_ASSIGN(VtkVolume volume, readVtkVolume(path, frame, wanted, share));
    std::vector<GridEntry> names;
    std::vector<Field> fields;
    listFields(volume.grid, names, fields);
    const bool foam = extensionOf(path) == ".foam";
    if (foam && names.empty() && !wanted.empty()) {  // to say what there is
      VOLUTE_ASSIGN(volume, readVtkVolume(path, frame, "", share));
      listFields(volume.grid, names, fields);
    }
    vtkUnstructuredGrid* grid = volume.grid;
    if (volume.partial.contains(wanted) ||
        (std::ranges::none_of(names, &GridEntry::usable) && !volume.partial.empty())) {
      return fail(ErrorCode::kUnsupported,
                  "{}: its blocks have not the same fields: {}; expected the field in all of them",
                  file, partialText(volume));
    }
    if (wanted.empty() && !volume.partial.empty()) {
      std::string all;
      for (const GridEntry& entry : names)
        all += fmt::format("{}{} ({})", all.empty() ? "" : ", ", entry.name, entry.type);
      return fail(ErrorCode::kInvalidArgument, Hint::choose("field"),
                  "{}: which field? All of its blocks have {}; others are {}", file, all,
                  partialText(volume));
    }
    VOLUTE_ASSIGN(const std::size_t chosen,
                  chooseGrid(names, wanted, file, {.noun = "field", .expected = "a scalar"}));
    data_ = {};
    data_.field = names[chosen].name;
    data_.others = otherGrids(names, chosen, MeshSize::kMaxName);
    data_.ofCells = fields[chosen].ofCells;
    data_.ghosts = volume.ghosts;
    if (wanted.empty() && extensionOf(path) == ".case")
      VOLUTE_TRY(checkEnsight(path, data_.field, volume.time));
    if (foam) {
      VOLUTE_TRY(checkFoamReference(path, data_.field, volume.time));
      data_.dimensions = foamDimensions(path, data_.field, volume.time);
      names.clear();
      for (std::string& name : foamFields(path, volume.time)) {
        if (name != data_.field)
          names.push_back({std::move(name), "", true});
      }
      data_.others = otherGrids(names, names.size(), MeshSize::kMaxName);
    }
    VOLUTE_TRY(copyCells(grid, fields[chosen], file));
    data_.walls = splitAtWalls(volume.walls, data_.soup, data_.ofCells ? nullptr : &data_.values);
    return sizeOfData();
  }

  Result<MeshHead> head(const std::filesystem::path& path) override { return readVtkHead(path); }

  Result<std::pair<MeshContents, std::vector<MeshFieldSummary>>> describe(
      const std::filesystem::path& path, std::size_t frame) override {
    VOLUTE_ASSIGN(const VtkVolume volume, readVtkVolume(path, frame, ""));
    vtkUnstructuredGrid* grid = volume.grid;
    std::vector<GridEntry> names;
    std::vector<Field> fields;
    listFields(grid, names, fields);
    data_ = {};
    data_.ghosts = volume.ghosts;
    VOLUTE_TRY(copyCells(grid, {}, path.string()));
    data_.walls = splitAtWalls(volume.walls, data_.soup, nullptr);
    MeshContents contents;
    contents.size = sizeOfData();
    contents.size.bare = true;
    for (const CellShape shape : data_.soup.shapes)
      ++contents.shapes[static_cast<std::size_t>(shape)];
    contents.surfaces = static_cast<std::uint64_t>(grid->GetNumberOfCells()) - contents.size.cells;
    contents.blocks = volume.blocks;
    contents.walls = volume.walls.size();
    partialText(volume).copy(contents.partial, MeshSize::kMaxName);
    std::vector<MeshFieldSummary> summaries;
    for (const Field& field : fields) summaries.push_back(summaryOf(field, leftOut_));
    tellApart(summaries);
    return std::pair(contents, std::move(summaries));
  }

  Result<MeshData> take() override { return std::move(data_); }

 private:
  MeshSize sizeOfData() const {
    MeshSize size;
    data_.field.copy(size.field, MeshSize::kMaxName);
    data_.others.copy(size.others, MeshSize::kMaxName);
    size.ofCells = data_.ofCells;
    size.points = data_.soup.vertices.size();
    size.cells = data_.soup.shapes.size();
    size.indices = data_.soup.connectivity.size();
    size.walls = data_.walls.size();
    size.ghosts = data_.ghosts;
    size.hasDimensions = data_.dimensions.has_value();
    size.dimensions = data_.dimensions.value_or(size.dimensions);
    return size;
  }

  /// `field` may have no array.
  Status copyCells(vtkUnstructuredGrid* grid, const Field& field, const std::string& file) {
    const vtkIdType expected = field.ofCells ? grid->GetNumberOfCells() : grid->GetNumberOfPoints();
    if (field.array && field.array->GetNumberOfTuples() != expected) {
      return fail(ErrorCode::kInvalidData, "{}: field '{}' has {} values; expected {}", file,
                  data_.field, field.array->GetNumberOfTuples(), expected);
    }
    data_.soup.vertices.resize(static_cast<std::size_t>(grid->GetNumberOfPoints()));
    for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i)
      grid->GetPoint(i, data_.soup.vertices[static_cast<std::size_t>(i)].data());
    vtkNew<vtkIdList> ids;
    leftOut_.clear();
    std::vector<vtkIdType> leftOut;  // points of cells without a volume
    const auto cells = static_cast<std::size_t>(grid->GetNumberOfCells());
    data_.soup.shapes.reserve(cells);
    data_.soup.offsets.reserve(cells + 1);
    data_.soup.connectivity.reserve(
        static_cast<std::size_t>(grid->GetCells()->GetNumberOfConnectivityIds()));
    data_.values.reserve(field.array ? static_cast<std::size_t>(expected) : 0);
    data_.soup.offsets.push_back(0);
    for (vtkIdType i = 0; i < grid->GetNumberOfCells(); ++i) {
      VOLUTE_ASSIGN(const auto shape, shapeOf(grid->GetCellType(i), file));
      VOLUTE_TRY(checkPointCount(grid, i, file));
      if (!shape) {
        grid->GetCellPoints(i, ids);
        for (vtkIdType k = 0; k < ids->GetNumberOfIds(); ++k) leftOut.push_back(ids->GetId(k));
        continue;
      }
      appendCell(grid, i, ids, data_.soup.connectivity);
      data_.soup.shapes.push_back(*shape);
      data_.soup.offsets.push_back(static_cast<std::int64_t>(data_.soup.connectivity.size()));
      if (field.array && field.ofCells)
        data_.values.push_back(static_cast<float>(field.array->GetComponent(i, 0)));
    }
    for (vtkIdType i = 0; field.array && !field.ofCells && i < expected; ++i)
      data_.values.push_back(static_cast<float>(field.array->GetComponent(i, 0)));
    if (extensionOf(file) == ".case") {
      // VTK leaves out ghost elements (g_hexa8 and so on), and their points in.
      leftOut.resize(data_.soup.vertices.size());
      std::iota(leftOut.begin(), leftOut.end(), 0);
    }
    if (!leftOut.empty())
      dropPoints(leftOut, field.array && !field.ofCells);
    return {};
  }

  /// Those of cells without a volume that no other cell has.
  void dropPoints(std::span<const vtkIdType> leftOut, bool withValues) {
    CellSoup& soup = data_.soup;
    constexpr std::int64_t kUsed = -1, kDropped = -2;
    std::vector<std::int64_t> place(soup.vertices.size(), kUsed);
    for (const vtkIdType point : leftOut) place[static_cast<std::size_t>(point)] = kDropped;
    const auto forAll = [&](const auto& each) {
      for (std::size_t i = 0; i < soup.shapes.size(); ++i) {
        const auto cell =
            std::span(soup.connectivity)
                .subspan(static_cast<std::size_t>(soup.offsets[i]),
                         static_cast<std::size_t>(soup.offsets[i + 1] - soup.offsets[i]));
        forPoints(soup.shapes[i], cell, [&](std::size_t k) { each(cell[k]); });
      }
    };
    const auto isPoint = [&](std::int64_t id) {
      return id >= 0 && id < static_cast<std::int64_t>(place.size());
    };
    forAll([&](std::int64_t id) {
      if (isPoint(id))
        place[static_cast<std::size_t>(id)] = kUsed;
    });
    std::size_t kept = 0;
    leftOut_.assign(place.size(), 0);
    for (std::size_t i = 0; i < place.size(); ++i) {
      if (place[i] == kDropped) {
        leftOut_[i] = 1;
        continue;
      }
      soup.vertices[kept] = soup.vertices[i];
      if (withValues)
        data_.values[kept] = data_.values[i];
      place[i] = static_cast<std::int64_t>(kept++);
    }
    soup.vertices.resize(kept);
    if (withValues)
      data_.values.resize(kept);
    forAll([&](std::int64_t& id) {
      if (isPoint(id))
        id = place[static_cast<std::size_t>(id)];
    });
  }

  MeshData data_;
  std::vector<std::uint8_t> leftOut_;  // points of the file; empty: none
};

}  // namespace
}  // namespace volute

extern "C" const volute::MeshPlugin* voluteVtkMeshPlugin() {
  using namespace volute;
  static constexpr MeshPlugin kPlugin{
      []() -> std::unique_ptr<MeshReader> { return std::make_unique<VtkMeshReader>(); }};
  return &kPlugin;
}
