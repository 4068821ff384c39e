// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/vtk_cases.hpp"

#include <vtkAppendFilter.h>
#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkExodusIIReader.h>
#include <vtkGenericEnSightReader.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkOpenFOAMReader.h>
#include <vtkPointData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkUnstructuredGridReader.h>
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
Status checkLines(const std::filesystem::path& path, std::uint64_t expected) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  std::string text(file.size(), ' ');
  VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(text))));
  if (text.substr(0, 256).find('\0') != std::string::npos)
    return {};  // binary: VTK counts
  const auto lines = static_cast<std::uint64_t>(std::ranges::count(text, '\n'));
  if (text.ends_with('\n') && lines >= expected)
    return {};
  return fail(ErrorCode::kTruncated,
              "{}: has {} whole lines; expected {} and an end of line after the last; the file is "
              "truncated",
              path.string(), lines, expected);
}

/// The lines of an EnSight field in ASCII.
std::uint64_t linesOf(vtkDataObject* whole, const std::string& field) {
  std::uint64_t lines = 1;            // the description
  constexpr std::uint64_t kHead = 3;  // part, its number, coordinates or the kind of cells
  forEachBlock(whole, [&](vtkDataObject* block) {
    auto* data = vtkDataSet::SafeDownCast(block);
    if (!data)
      return;
    if (data->GetPointData()->HasArray(field.c_str()))
      lines += kHead + static_cast<std::uint64_t>(data->GetNumberOfPoints());
    else if (data->GetCellData()->HasArray(field.c_str()))
      lines += kHead + static_cast<std::uint64_t>(data->GetNumberOfCells());
  });
  return lines;
}

}  // namespace

Result<std::vector<double>> readVtkTimes(const std::filesystem::path& path) {
  const ErrorWatch watch;
  const auto reader = readerOf(path);
  auto times = timesOf(*reader);
  VOLUTE_TRY(watch.status(path.string()));
  return times;
}

Result<VtkVolume> readVtkVolume(const std::filesystem::path& path, std::size_t instant) {
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
  VtkVolume volume;
  volume.whole = reader->GetOutputDataObject(0);
  const auto grids = volumesOf(volume.whole);
  if (grids.empty()) {
    return fail(ErrorCode::kInvalidData, "{}: has no cells with a volume; expected a mesh of them",
                file);
  }
  volume.grid = grids[0];
  if (grids.size() > 1) {
    vtkNew<vtkAppendFilter> append;
    append->MergePointsOn();
    append->SetTolerance(0);
    for (vtkUnstructuredGrid* grid : grids) append->AddInputData(grid);
    append->Update();
    VOLUTE_TRY(watch.status(file));
    volume.grid = append->GetOutput();
  }
  return volume;
}

Status checkVtkCase(const std::filesystem::path& path, const std::string& field,
                    vtkDataObject* whole) {
  if (path.extension() != ".case")
    return {};
  const std::filesystem::path pattern = patternOf(path, field);
  if (pattern.empty())
    return {};
  const std::uint64_t lines = linesOf(whole, field);
  std::error_code error;
  for (const auto& entry :
       std::filesystem::directory_iterator((path.parent_path() / pattern).parent_path(), error)) {
    if (matches(entry.path().filename().string(), pattern.filename().string()))
      VOLUTE_TRY(checkLines(entry.path(), lines));
  }
  return {};
}

}  // namespace volute
