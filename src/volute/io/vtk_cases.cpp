// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/vtk_cases.hpp"

#include <vtkAppendFilter.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkExodusIIReader.h>
#include <vtkGenericEnSightReader.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkOpenFOAMReader.h>
#include <vtkPointData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "volute/io/vtk_errors.hpp"

namespace volute {
namespace {

/// VTK's reader for a file, with all fields asked for.
vtkSmartPointer<vtkAlgorithm> readerOf(const std::filesystem::path& path) {
  const std::string kind = path.extension().string();
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
    reader->EnableAllCellArrays();
    reader->EnableAllPointArrays();
    return reader;
  }
  if (kind == ".vtu") {
    auto reader = vtkSmartPointer<vtkXMLUnstructuredGridReader>::New();
    reader->SetFileName(path.c_str());
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

std::vector<vtkUnstructuredGrid*> volumesOf(vtkDataObject* data) {
  std::vector<vtkUnstructuredGrid*> grids;
  const auto add = [&](vtkDataObject* object) {
    auto* grid = vtkUnstructuredGrid::SafeDownCast(object);
    if (grid && hasVolume(*grid))
      grids.push_back(grid);
  };
  if (auto* blocks = vtkCompositeDataSet::SafeDownCast(data)) {
    vtkSmartPointer<vtkCompositeDataIterator> at;
    at.TakeReference(blocks->NewIterator());
    for (at->InitTraversal(); !at->IsDoneWithTraversal(); at->GoToNextItem())
      add(at->GetCurrentDataObject());
  } else {
    add(data);
  }
  return grids;
}

/// The files that an EnSight case keeps a variable in, `*` for digits; empty when it names none.
std::string patternOf(const std::filesystem::path& casePath, const std::string& field) {
  std::ifstream stream(casePath);
  for (std::string line; std::getline(stream, line);) {
    const auto colon = line.find(':');
    if (colon == std::string::npos || line.find(" per ") > colon)
      continue;
    std::istringstream words(line.substr(colon + 1));
    std::vector<std::string> all;
    for (std::string word; words >> word;) all.push_back(word);
    if (all.size() >= 2 && all[all.size() - 2] == field)
      return all.back();
  }
  return {};
}

bool matches(const std::string& name, const std::string& pattern) {
  return name.size() == pattern.size() &&
         std::equal(name.begin(), name.end(), pattern.begin(),
                    [](char c, char p) { return p == '*' ? c >= '0' && c <= '9' : c == p; });
}

/// Reading past the end, VTK repeats the last line.
Status checkLines(const std::filesystem::path& path, std::uint64_t values) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  std::string text(file.size(), ' ');
  VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(text))));
  if (text.substr(0, 256).find('\0') != std::string::npos)
    return {};  // binary: VTK counts
  const auto lines = static_cast<std::uint64_t>(std::ranges::count(text, '\n'));
  constexpr std::uint64_t kHead = 4;  // description, part, its number, coordinates or cells
  if (!text.ends_with('\n') || lines < values + kHead) {
    return fail(ErrorCode::kTruncated,
                "{}: has {} lines{}; expected {} values and {} lines before them; the file is "
                "truncated",
                path.string(), lines, text.ends_with('\n') ? "" : " and ends inside one", values,
                kHead);
  }
  return {};
}

}  // namespace

Result<std::vector<double>> readVtkTimes(const std::filesystem::path& path) {
  const ErrorWatch watch;
  const auto reader = readerOf(path);
  auto times = timesOf(*reader);
  VOLUTE_TRY(watch.status(path.string()));
  return times;
}

Result<vtkSmartPointer<vtkUnstructuredGrid>> readVtkVolume(const std::filesystem::path& path,
                                                           std::size_t instant) {
  const std::string file = path.string();
  const bool single = path.extension() == ".vtu";
  if (single)
    VOLUTE_TRY(checkEnd(path));
  const ErrorWatch watch;
  const auto reader = readerOf(path);
  if (single) {
    reader->Update();
  } else {
    const auto times = timesOf(*reader);
    VOLUTE_TRY(watch.status(file));
    if (instant >= times.size()) {
      return fail(ErrorCode::kInvalidData, "{}: has {} instants now; expected more than {}", file,
                  times.size(), instant);
    }
    reader->UpdateTimeStep(times[instant]);
  }
  VOLUTE_TRY(watch.status(file));
  if (single)
    return vtkSmartPointer<vtkUnstructuredGrid>(
        vtkUnstructuredGrid::SafeDownCast(reader->GetOutputDataObject(0)));
  const auto grids = volumesOf(reader->GetOutputDataObject(0));
  if (grids.empty()) {
    return fail(ErrorCode::kInvalidData, "{}: has no cells with a volume; expected a mesh of them",
                file);
  }
  if (grids.size() == 1)
    return vtkSmartPointer<vtkUnstructuredGrid>(grids[0]);
  vtkNew<vtkAppendFilter> append;
  append->MergePointsOn();
  append->SetTolerance(0);
  for (vtkUnstructuredGrid* grid : grids) append->AddInputData(grid);
  append->Update();
  VOLUTE_TRY(watch.status(file));
  return vtkSmartPointer<vtkUnstructuredGrid>(append->GetOutput());
}

Status checkVtkCase(const std::filesystem::path& path, const std::string& field,
                    vtkUnstructuredGrid& grid) {
  if (path.extension() != ".case")
    return {};
  const std::string pattern = patternOf(path, field);
  if (pattern.empty())
    return {};
  const std::uint64_t values = static_cast<std::uint64_t>(
      grid.GetPointData()->HasArray(field.c_str()) ? grid.GetNumberOfPoints()
                                                   : grid.GetNumberOfCells());
  const auto folder = (path.parent_path() / pattern).parent_path();
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (matches(entry.path().filename().string(), std::filesystem::path(pattern).filename()))
      VOLUTE_TRY(checkLines(entry.path(), values));
  }
  return {};
}

}  // namespace volute
