// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/vtk_cases.hpp"

#include <vtkAppendFilter.h>
#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataSet.h>
#include <vtkDataSetAttributes.h>
#include <vtkExodusIIReader.h>
#include <vtkGenericEnSightReader.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkOpenFOAMReader.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkUnstructuredGridReader.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <sstream>
#include <string_view>

#include "volute/base/file_name.hpp"
#include "volute/base/lower_case.hpp"
#include "volute/io/ensight_files.hpp"
#include "volute/io/exodus_fill.hpp"
#include "volute/io/foam_files.hpp"
#include "volute/io/grid_choice.hpp"
#include "volute/io/vtk_errors.hpp"
#include "volute/io/vtk_xml.hpp"

namespace volute {
namespace {

/// Whether what VTK's reader takes for the displacement of nodes is one: it is the first vector
/// whose name begins with "dis", as that of a distance or a dissipation does.
bool hasDisplacement(vtkExodusIIReader& reader) {
  constexpr std::string_view kNames[] = {"disp", "displ", "displacement", "displacements"};
  for (int i = 0; i < reader.GetNumberOfObjectArrays(vtkExodusIIReader::NODAL); ++i) {
    std::string name = lowerCase(reader.GetObjectArrayName(vtkExodusIIReader::NODAL, i));
    while (name.ends_with('_')) name.pop_back();
    if (name.starts_with("dis") &&
        reader.GetNumberOfObjectArrayComponents(vtkExodusIIReader::NODAL, i) > 1)
      return std::ranges::find(kNames, name) != std::end(kNames);
  }
  return false;
}

/// VTK's reader for a file, with all fields asked for; of OpenFOAM with one, unless its name is
/// empty: others may say what VTK does not read.
vtkSmartPointer<vtkAlgorithm> readerOf(const std::filesystem::path& path,
                                       const std::string& field = "") {
  const std::string kind = extensionOf(path);
  if (kind == ".case") {
    auto reader = vtkSmartPointer<vtkGenericEnSightReader>::New();
    reader->SetCaseFileName(path.c_str());
    reader->ReadAllVariablesOn();
    return reader;
  }
  if (kind == ".foam") {
    auto reader = vtkSmartPointer<vtkOpenFOAMReader>::New();
    reader->SetFileName(path.c_str());
    reader->DecomposePolyhedraOff();
    reader->CreateCellToPointOff();
    reader->UpdateInformation();
    reader->DisableAllPatchArrays();
    reader->SetPatchArrayStatus("internalMesh", 1);
    if (field.empty()) {
      reader->EnableAllCellArrays();
      reader->EnableAllPointArrays();
    } else {
      reader->DisableAllCellArrays();
      reader->DisableAllPointArrays();
      reader->SetCellArrayStatus(field.c_str(), 1);
      reader->SetPointArrayStatus(field.c_str(), 1);
    }
    return reader;
  }
  if (kind == ".vtk") {
    auto reader = vtkSmartPointer<vtkUnstructuredGridReader>::New();
    reader->SetFileName(path.c_str());
    reader->ReadAllScalarsOn();
    reader->ReadAllFieldsOn();
    return reader;
  }
  auto reader = vtkSmartPointer<vtkExodusIIReader>::New();
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  reader->SetAllArrayStatus(vtkExodusIIReader::NODAL, 1);
  reader->SetAllArrayStatus(vtkExodusIIReader::ELEM_BLOCK, 1);
  reader->GenerateObjectIdCellArrayOff();
  reader->GenerateGlobalElementIdArrayOff();
  reader->GenerateGlobalNodeIdArrayOff();
  reader->SetApplyDisplacements(hasDisplacement(*reader) ? 1 : 0);
  return reader;
}

std::vector<double> timesOf(vtkAlgorithm& reader) {
  reader.UpdateInformation();
  vtkInformation* info = reader.GetOutputInformation(0);
  auto* key = vtkStreamingDemandDrivenPipeline::TIME_STEPS();
  if (!info || !info->Has(key) || info->Length(key) == 0)
    return {0};
  return {info->Get(key), info->Get(key) + info->Length(key)};
}

bool hasVolume(vtkUnstructuredGrid& grid) {
  for (vtkIdType i = 0; i < grid.GetNumberOfCells(); ++i) {
    if (grid.GetCellType(i) > VTK_QUAD)
      return true;
  }
  return false;
}

template <class Add>
void forEachBlock(vtkDataObject* data, const Add& add) {
  if (auto* blocks = vtkCompositeDataSet::SafeDownCast(data)) {
    vtkSmartPointer<vtkCompositeDataIterator> at;
    at.TakeReference(blocks->NewIterator());
    for (at->InitTraversal(); !at->IsDoneWithTraversal(); at->GoToNextItem())
      add(at->GetCurrentDataObject());
  } else {
    add(data);
  }
}

std::vector<vtkUnstructuredGrid*> volumesOf(vtkDataObject* data) {
  std::vector<vtkUnstructuredGrid*> grids;
  forEachBlock(data, [&](vtkDataObject* block) {
    auto* grid = vtkUnstructuredGrid::SafeDownCast(block);
    if (grid && hasVolume(*grid))
      grids.push_back(grid);
  });
  return grids;
}

/// Structured parts are not read; without them there would be clear air in their place.
Status refuseStructured(vtkDataObject* data, const std::string& file) {
  bool found = false;
  forEachBlock(data, [&](vtkDataObject* block) {
    auto* set = vtkDataSet::SafeDownCast(block);
    found =
        found || (set && !vtkUnstructuredGrid::SafeDownCast(set) && set->GetNumberOfCells() > 0 &&
                  (set->GetCellType(0) == VTK_HEXAHEDRON || set->GetCellType(0) == VTK_VOXEL));
  });
  if (!found)
    return {};
  return fail(
      ErrorCode::kUnsupported,
      "{}: has a part on a structured grid (an EnSight block); expected unstructured cells; "
      "convert it",
      file);
}

/// Of cells and points, without what ParaView adds.
std::set<std::string> fieldsOf(vtkUnstructuredGrid& grid) {
  std::set<std::string> names;
  const std::array<vtkDataSetAttributes*, 2> both{grid.GetPointData(), grid.GetCellData()};
  for (vtkDataSetAttributes* data : both) {
    for (int i = 0; i < data->GetNumberOfArrays(); ++i) {
      const char* name = data->GetArrayName(i);
      if (name && !std::string_view(name).starts_with("vtkGhost"))
        names.insert(name);
    }
  }
  return names;
}

/// Joined, blocks have only what is in all of them.
void notePartialFields(const std::vector<vtkUnstructuredGrid*>& grids, VtkVolume& volume) {
  std::map<std::string, int> counts;
  for (vtkUnstructuredGrid* grid : grids) {
    for (const std::string& name : fieldsOf(*grid)) ++counts[name];
  }
  const auto all = static_cast<int>(grids.size());
  for (const auto& [name, count] : counts) {
    if (count < all)
      volume.partial[name] = count;
  }
}

/// The grids as one, points at the same place as one; ghost cells and their points left out.
Status join(const std::vector<vtkUnstructuredGrid*>& grids, const std::string& file,
            const ErrorWatch& watch, VtkVolume& volume) {
  if (grids.empty()) {
    return fail(ErrorCode::kInvalidData, "{}: has no cells with a volume; expected a mesh of them",
                file);
  }
  volume.blocks = std::max(volume.blocks, static_cast<int>(grids.size()));
  notePartialFields(grids, volume);
  for (vtkUnstructuredGrid* grid : grids) {
    const vtkIdType before = grid->GetNumberOfCells();
    grid->RemoveGhostCells();
    volume.ghosts += static_cast<std::uint64_t>(before - grid->GetNumberOfCells());
  }
  if (grids.size() == 1) {
    volume.grid = grids[0];
    return {};
  }
  vtkNew<vtkAppendFilter> append;
  append->MergePointsOn();
  append->SetTolerance(0);
  for (vtkUnstructuredGrid* grid : grids) append->AddInputData(grid);
  append->Update();
  VOLUTE_TRY(watch.status(file));
  volume.grid = append->GetOutput();
  return {};
}

/// Fields that not all pieces of the file have are left out, and noted in `volume`.
Result<vtkSmartPointer<vtkUnstructuredGrid>> readVtu(const std::filesystem::path& path,
                                                     const ErrorWatch& watch, VtkVolume& volume) {
  VOLUTE_ASSIGN(const auto root, readVtkXml(path));
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  VOLUTE_TRY(watch.status(path.string()));
  vtkSmartPointer<vtkUnstructuredGrid> grid = reader->GetOutput();
  for (const PartialArray& array : partialArrays(*root)) {
    volume.partial[array.name] = array.pieces;
    volume.blocks = array.all;
    vtkDataSetAttributes* const data = array.ofCells
                                           ? static_cast<vtkDataSetAttributes*>(grid->GetCellData())
                                           : grid->GetPointData();
    data->RemoveArray(array.name.c_str());
  }
  return grid;
}

/// The .vtu files that a .pvtu names.
Result<std::vector<std::filesystem::path>> piecesOf(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto root, readVtkXml(path));
  vtkXMLDataElement* grid = root->FindNestedElementWithName("PUnstructuredGrid");
  std::vector<std::filesystem::path> pieces;
  for (int i = 0; grid && i < grid->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* element = grid->GetNestedElement(i);
    const char* source = element->GetAttribute("Source");
    if (element->GetName() == std::string_view("Piece") && source)
      pieces.push_back(path.parent_path() / source);
  }
  if (pieces.empty()) {
    return fail(ErrorCode::kInvalidData,
                "{}: names no pieces; expected VTKFile, PUnstructuredGrid, Piece with a Source",
                path.string());
  }
  return pieces;
}

/// Pieces without cells with a volume are left out.
Result<VtkVolume> readPvtu(const std::filesystem::path& path, const MeshShare& share) {
  const ErrorWatch watch;
  VOLUTE_ASSIGN(const auto pieces, piecesOf(path));
  const auto count = static_cast<int>(pieces.size());
  if (share.count > count) {
    return fail(ErrorCode::kUnsupported,
                "{}: is in {} pieces, and {} ranks cannot hold one each; start {} at most",
                path.string(), count, share.count, count);
  }
  const std::int64_t begin = std::int64_t{count} * share.index / share.count;
  const std::int64_t end = std::int64_t{count} * (share.index + 1) / share.count;
  std::vector<vtkSmartPointer<vtkUnstructuredGrid>> held;
  std::vector<vtkUnstructuredGrid*> grids;
  VtkVolume volume;
  for (const auto& piece : std::span(pieces).subspan(static_cast<std::size_t>(begin),
                                                     static_cast<std::size_t>(end - begin))) {
    VtkVolume its;
    VOLUTE_ASSIGN(auto grid, ofFile(readVtu(piece, watch, its), piece.string()));
    if (hasVolume(*grid)) {
      volume.partial.merge(its.partial);
      volume.blocks = std::max(volume.blocks, its.blocks);
      grids.push_back(grid);
      held.push_back(std::move(grid));
    }
  }
  VOLUTE_TRY(join(grids, path.string(), watch, volume));
  volume.ghosts = 0;  // each is a cell of another piece
  return volume;
}

/// What VTK said; of an OpenFOAM case in words for dimensions that it cannot read.
Status statusOfCase(const ErrorWatch& watch, const std::filesystem::path& path) {
  Status read = watch.status(path.string());
  if (!read && extensionOf(path) == ".foam")
    VOLUTE_TRY(checkFoamDimensions(path));
  return read;
}

/// VTK takes what stands there for the last number.
Status checkLastLine(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  std::string head(std::min<std::uint64_t>(file.size(), 512), ' ');
  VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(head))));
  std::istringstream lines(head);
  std::string line;
  for (int i = 0; i < 3; ++i) std::getline(lines, line);
  char last = '\n';
  if (file.size() > 0)
    VOLUTE_TRY(file.read(file.size() - 1, std::as_writable_bytes(std::span(&last, 1))));
  if (!line.starts_with("ASCII") ||
      std::string_view(" \t\r\n").find(last) != std::string_view::npos)
    return {};
  return fail(ErrorCode::kTruncated,
              "{}: does not end in an end of line: its last number may be cut off; copy the file "
              "again, or end it with a line",
              path.string());
}

/// Walls within the mesh of an OpenFOAM case: its patches tell them, its cells do not. Read without
/// values, which may say what VTK does not read.
Status readFoamWalls(const std::filesystem::path& path, double time, VtkVolume& volume) {
  const std::vector<FoamPatch> patches = foamPatches(path, time);
  const auto patchOf = [&](std::string_view name) {
    const auto found = std::ranges::find(patches, name, &FoamPatch::name);
    return found == patches.end() ? FoamPatch{} : *found;
  };
  vtkNew<vtkOpenFOAMReader> reader;
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  reader->DisableAllCellArrays();
  reader->DisableAllPointArrays();
  reader->DisableAllPatchArrays();
  constexpr std::string_view kPrefix = "patch/";
  bool any = false;
  for (int i = 0; i < reader->GetNumberOfPatchArrays(); ++i) {
    const std::string name = reader->GetPatchArrayName(i);
    if (!name.starts_with(kPrefix))
      continue;
    const FoamPatch patch = patchOf(std::string_view(name).substr(kPrefix.size()));
    // Where such a pair lets only a part through, walls have its faces too.
    if (!patch.isWall() && patch.type.find("ACMI") == patch.type.npos)
      continue;
    reader->SetPatchArrayStatus(name.c_str(), 1);
    any = true;
  }
  if (!any)
    return {};
  reader->UpdateTimeStep(time);
  std::vector<WallPolygon> walls, open;
  const auto take = [&](vtkPolyData& faces, bool isWall) {
    for (vtkIdType i = 0; i < faces.GetNumberOfCells(); ++i) {
      vtkIdType count = 0;
      const vtkIdType* ids = nullptr;
      faces.GetCellPoints(i, count, ids);
      WallPolygon& polygon = (isWall ? walls : open).emplace_back(count);
      for (vtkIdType k = 0; k < count; ++k)
        faces.GetPoint(ids[k], polygon[static_cast<std::size_t>(k)].data());
    }
  };
  auto* blocks = vtkCompositeDataSet::SafeDownCast(reader->GetOutputDataObject(0));
  vtkSmartPointer<vtkCompositeDataIterator> at;
  if (blocks)
    at.TakeReference(blocks->NewIterator());
  for (at ? at->InitTraversal() : void(); at && !at->IsDoneWithTraversal(); at->GoToNextItem()) {
    auto* faces = vtkPolyData::SafeDownCast(at->GetCurrentDataObject());
    const char* name = at->HasCurrentMetaData()
                           ? at->GetCurrentMetaData()->Get(vtkCompositeDataSet::NAME())
                           : nullptr;
    if (faces)
      take(*faces, patchOf(name ? name : "").isWall());
  }
  volume.walls = wallsWithin(walls, open);
  return {};
}

}  // namespace

void tellApart(std::vector<MeshFieldSummary>& fields) {
  std::vector<GridEntry> names;
  for (const MeshFieldSummary& field : fields) names.push_back({field.name, "", true});
  tellApart(names, [&](std::size_t i) { return fields[i].ofCells; });
  for (std::size_t i = 0; i < fields.size(); ++i) {
    std::ranges::fill(fields[i].name, '\0');
    names[i].name.copy(fields[i].name, MeshSize::kMaxName);
  }
}

std::string partialText(const VtkVolume& volume) {
  std::string text;
  for (const auto& [name, count] : volume.partial)
    text += fmt::format("{}{} in {}", text.empty() ? "" : ", ", name, count);
  return text.empty() ? "" : fmt::format("{} of {} blocks", text, volume.blocks);
}

Result<std::vector<double>> readVtkTimes(const std::filesystem::path& path) {
  if (extensionOf(path) == ".pvtu")
    return std::vector<double>{0};
  if (extensionOf(path) == ".case")
    VOLUTE_TRY(checkEnsightCase(path));
  if (extensionOf(path) == ".foam") {
    VOLUTE_TRY(checkFoamMesh(path));
    VOLUTE_TRY(checkFoamKinds(path));
    VOLUTE_TRY(checkFoamByteOrder(path));
  }
  const ErrorWatch watch;
  const auto reader = readerOf(path);
  auto times = timesOf(*reader);
  VOLUTE_TRY(statusOfCase(watch, path));
  return times;
}

double statedTime(vtkXMLReader& reader) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const auto key = vtkStreamingDemandDrivenPipeline::TIME_STEPS();
  for (int i = 0; i < reader.GetNumberOfTimeDataArrays(); ++i) {
    const std::string name = reader.GetTimeDataArray(i);
    if ((name == "TIME" || lowerCase(name) == "timevalue") &&
        !reader.GetOutputInformation(0)->Has(key)) {
      reader.SetActiveTimeDataArrayName(name.c_str());
      reader.UpdateInformation();
    }
  }
  vtkInformation* information = reader.GetOutputInformation(0);
  if (!information->Has(key) || information->Length(key) != 1)
    return kUnknown;
  return information->Get(key)[0];
}

Result<MeshHead> readVtkHead(const std::filesystem::path& path) {
  const ErrorWatch watch;
  std::filesystem::path file = path;
  if (extensionOf(path) == ".pvtu") {
    VOLUTE_ASSIGN(const auto pieces, piecesOf(path));
    file = pieces.front();
  }
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(file.c_str());
  reader->UpdateInformation();
  VOLUTE_TRY(ofFile(watch.status(file.string()), file.string()));
  MeshHead head{.time = statedTime(*reader)};
  for (const bool cells : {false, true}) {
    auto* list = reader->GetOutputInformation(0)->Get(cells ? vtkDataObject::CELL_DATA_VECTOR()
                                                            : vtkDataObject::POINT_DATA_VECTOR());
    for (int i = 0; list && i < list->GetNumberOfInformationObjects(); ++i) {
      vtkInformation* field = list->GetInformationObject(i);
      const char* name = field->Get(vtkDataObject::FIELD_NAME());
      if (!name || std::string_view(name).starts_with("vtkGhost"))
        continue;
      MeshFieldSummary& summary = head.fields.emplace_back();
      std::string_view(name).copy(summary.name, MeshSize::kMaxName);
      summary.ofCells = cells;
      summary.components = field->Get(vtkDataObject::FIELD_NUMBER_OF_COMPONENTS());
    }
  }
  tellApart(head.fields);
  return head;
}

Result<VtkVolume> readVtkVolume(const std::filesystem::path& path, std::size_t frame,
                                const std::string& field, const MeshShare& share) {
  const std::string file = path.string();
  const std::string kind = extensionOf(path);
  if (kind == ".pvtu")
    return readPvtu(path, share);
  if (share.count > 1) {
    return fail(ErrorCode::kUnsupported,
                "{}: is one piece, of which ranks cannot hold shares; expected a .pvtu", file);
  }
  if (kind == ".vtk")
    VOLUTE_TRY(checkLastLine(path));
  const ErrorWatch watch;
  VtkVolume volume;
  if (kind == ".vtu") {
    VOLUTE_ASSIGN(const auto grid, readVtu(path, watch, volume));
    VOLUTE_TRY(join(volumesOf(grid), file, watch, volume));
    return volume;
  }
  const auto reader = readerOf(path, field);
  const auto times = timesOf(*reader);
  VOLUTE_TRY(statusOfCase(watch, path));
  if (frame >= times.size()) {
    return fail(ErrorCode::kInvalidData, "{}: has {} instants now; expected more than {}", file,
                times.size(), frame);
  }
  volume.time = times[frame];
  if (kind == ".case")
    VOLUTE_TRY(checkEnsight(path, field, volume.time));
  reader->UpdateTimeStep(volume.time);
  VOLUTE_TRY(statusOfCase(watch, path));
  VOLUTE_TRY(refuseStructured(reader->GetOutputDataObject(0), file));
  const auto grids = volumesOf(reader->GetOutputDataObject(0));
  if (vtkExodusIIReader::SafeDownCast(reader)) {
    const auto fills = exodusFills(path);
    for (vtkUnstructuredGrid* grid : grids) settleFills(fills, *grid);
  }
  VOLUTE_TRY(join(grids, file, watch, volume));
  if (kind == ".foam") {
    VOLUTE_TRY(readFoamWalls(path, volume.time, volume));
    VOLUTE_TRY(statusOfCase(watch, path));
  }
  return volume;
}

}  // namespace volute
