// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <vtkAlgorithm.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataArraySelection.h>
#include <vtkDataSetAttributes.h>
#include <vtkDoubleArray.h>
#include <vtkErrorCode.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLImageDataWriter.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <span>

#include "volute/base/number_type.hpp"
#include "volute/io/grid_choice.hpp"
#include "volute/io/lattice.hpp"
#include "volute/io/vtk_cases.hpp"
#include "volute/io/vtk_errors.hpp"
#include "volute/io/vtk_xml.hpp"
#include "volute/io/xml_text.hpp"

namespace volute {
namespace {

/// An array of the file and what its values belong to.
struct ArrayEntry {
  std::string name{};  ///< in the file
  bool cells = false;
  int components = 0;
  int type = VTK_FLOAT;
};

struct Arrays {
  std::vector<GridEntry> names;
  std::vector<ArrayEntry> entries;
};

void listArrays(vtkInformation* information, bool cells, Arrays& arrays) {
  auto* fields = information->Get(cells ? vtkDataObject::CELL_DATA_VECTOR()
                                        : vtkDataObject::POINT_DATA_VECTOR());
  for (int i = 0; fields && i < fields->GetNumberOfInformationObjects(); ++i) {
    vtkInformation* field = fields->GetInformationObject(i);
    const char* name = field->Get(vtkDataObject::FIELD_NAME());
    const int components = field->Get(vtkDataObject::FIELD_NUMBER_OF_COMPONENTS());
    if (!name || std::string_view(name).starts_with("vtkGhost"))
      continue;
    const auto what = components == 1 ? "scalar" : fmt::format("vector of {}", components);
    arrays.names.push_back({name, fmt::format("{}, of {}", what, cells ? "cells" : "points"),
                            components == 1 || components == 3});
    const auto type = vtkDataObject::FIELD_ARRAY_TYPE();
    arrays.entries.push_back(
        {name, cells, components, field->Has(type) ? field->Get(type) : VTK_FLOAT});
  }
}

/// Marks those that not all pieces have, and adds those that the first, which VTK lists, lacks.
void markPartial(std::span<const PartialArray> partial, Arrays& arrays) {
  for (const PartialArray& part : partial) {
    std::size_t at = 0;
    while (at < arrays.names.size() &&
           (arrays.entries[at].name != part.name || arrays.entries[at].cells != part.ofCells))
      ++at;
    if (at == arrays.names.size()) {
      arrays.names.push_back({part.name, fmt::format("of {}", part.ofCells ? "cells" : "points")});
      arrays.entries.push_back({part.name, part.ofCells});
    }
    arrays.names[at].usable = false;
    arrays.names[at].type += fmt::format(", in {} of {} pieces", part.pieces, part.all);
  }
}

/// Refuses a partial array that is meant, `names` as told apart.
Status checkPartial(std::span<const PartialArray> partial, std::span<const GridEntry> names,
                    const std::string& meant, const std::string& file) {
  for (const GridEntry& entry : names) {
    if (entry.usable && entry.name == meant)
      return {};
  }
  for (const PartialArray& part : partial) {
    const char* const of = part.ofCells ? "cells" : "points";
    if (part.name == meant || fmt::format("{} ({})", part.name, of) == meant) {
      return fail(ErrorCode::kInvalidData,
                  "{}: array '{}' of {} is in {} of {} pieces; expected it in all of them", file,
                  part.name, of, part.pieces, part.all);
    }
  }
  return {};
}

/// Name, place and size of the wanted array.
Result<LatticeFrame> describeImage(vtkXMLImageDataReader* reader, const std::string& wanted,
                                   const std::string& file, ArrayEntry& entry,
                                   std::span<const PartialArray> partial,
                                   const std::string& usual = "density") {
  vtkInformation* information = reader->GetOutputInformation(0);
  if (!information->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT())) {
    return fail(ErrorCode::kInvalidData, "{}: states no extent", file);
  }
  Arrays arrays;
  listArrays(information, true, arrays);
  listArrays(information, false, arrays);
  tellApart(arrays.names, [&](std::size_t i) { return arrays.entries[i].cells; });
  markPartial(partial, arrays);
  VOLUTE_TRY(checkPartial(partial, arrays.names, wanted.empty() ? usual : wanted, file));
  VOLUTE_ASSIGN(const std::size_t index, chooseGrid(arrays.names, wanted, file, {.usual = usual}));
  entry = arrays.entries[index];
  LatticeFrame frame;
  arrays.names[index].name.copy(frame.grid, LatticeFrame::kMaxName);
  otherGrids(arrays.names, index, LatticeFrame::kMaxName)
      .copy(frame.others, LatticeFrame::kMaxName);
  std::string leftOut;
  for (const GridEntry& one : arrays.names) {
    if (!one.usable && wanted.empty())
      leftOut += fmt::format("{}'{}' ({})", leftOut.empty() ? "" : ", ", one.name, one.type);
  }
  leftOut.copy(frame.leftOut, LatticeFrame::kMaxName);
  frame.channels = entry.components;
  frame.rounded = entry.type != VTK_FLOAT && vtkDataArray::GetDataTypeSize(entry.type) >= 4;
  const int* extent = information->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT());
  const double* spacing = information->Get(vtkDataObject::SPACING());
  const double* origin = information->Get(vtkDataObject::ORIGIN());
  Mat3 turn = Mat3::Identity();
  if (information->Has(vtkDataObject::DIRECTION())) {
    const double* direction = information->Get(vtkDataObject::DIRECTION());
    for (int i = 0; i < 9; ++i) {
      turn(i / 3, i % 3) = direction[i];
      frame.turned = frame.turned || std::abs(direction[i] - (i % 4 == 0)) > 1e-9;
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    frame.voxelSize[axis] = spacing[axis];
    frame.origin[axis] = origin[axis] + (entry.cells ? 0.5 * spacing[axis] : 0);
    frame.box.begin[axis] = extent[2 * axis];
    frame.box.end[axis] = std::int64_t{extent[2 * axis + 1]} + (entry.cells ? 0 : 1);
    if (!(spacing[axis] > 0) || !std::isfinite(spacing[axis]) || !std::isfinite(origin[axis])) {
      return fail(
          ErrorCode::kInvalidData,
          "{}: a spacing of {} m and an origin of {} m along {}; expected a positive spacing", file,
          spacing[axis], origin[axis], "xyz"[axis]);
    }
    if (frame.box.size(axis) < 1) {
      return fail(ErrorCode::kInvalidData, "{}: no voxels along {} (extent {} to {})", file,
                  "xyz"[axis], extent[2 * axis], extent[2 * axis + 1]);
    }
  }
  if (frame.turned) {
    const Vec3 size(spacing[0], spacing[1], spacing[2]);
    const Mat3 linear = turn * size.asDiagonal();
    const Vec3 half = Vec3::Constant(entry.cells ? 0.5 : 0.0);
    frame.matrix = gridMatrix(linear, Vec3(origin[0], origin[1], origin[2]) + linear * half);
    if (!isSound(frame.matrix)) {
      return fail(ErrorCode::kInvalidData,
                  "{}: its Direction makes the grid flat; expected one that can be undone", file);
    }
    const GridSpace space = spaceOf(frame.matrix);
    frame.voxelSize = space.voxelSize, frame.origin = space.origin;
  }
  return frame;
}

/// VTK's name of the array that says which cells or points are none.
constexpr const char* kGhosts = "vtkGhostType";

bool isHidden(vtkDataArray* ghosts, vtkIdType i, bool cells) {
  const int bits =
      cells ? int{vtkDataSetAttributes::HIDDENCELL} : int{vtkDataSetAttributes::HIDDENPOINT};
  return (static_cast<int>(ghosts->GetComponent(i, 0)) & bits) != 0;
}

vtkDataSetAttributes* attributesOf(vtkImageData* image, bool cells) {
  return cells ? static_cast<vtkDataSetAttributes*>(image->GetCellData()) : image->GetPointData();
}

/// Reads these arrays of cells or points and no others.
void select(vtkXMLImageDataReader* reader, bool cells, std::initializer_list<const char*> names) {
  reader->GetPointDataArraySelection()->DisableAllArrays();
  reader->GetCellDataArraySelection()->DisableAllArrays();
  for (const char* name : names)
    (cells ? reader->GetCellDataArraySelection() : reader->GetPointDataArraySelection())
        ->EnableArray(name);
}

/// How many cells or points the file marks as none.
std::uint64_t countHidden(vtkXMLImageDataReader* reader, bool cells) {
  vtkDataArraySelection* const all =
      cells ? reader->GetCellDataArraySelection() : reader->GetPointDataArraySelection();
  if (all->ArrayExists(kGhosts) == 0)
    return 0;
  select(reader, cells, {kGhosts});
  static_cast<vtkAlgorithm&>(*reader).Update();
  vtkDataArray* ghosts = attributesOf(reader->GetOutput(), cells)->GetArray(kGhosts);
  std::uint64_t count = 0;
  for (vtkIdType i = 0; ghosts && i < ghosts->GetNumberOfTuples(); ++i)
    count += isHidden(ghosts, i, cells) ? 1 : 0;
  return count;
}

/// How VTK has the numbers of an array in memory; nothing: only it knows.
std::optional<NumberType> numbersOf(vtkDataArray* array) {
  if (!array->HasStandardMemoryLayout())
    return std::nullopt;
  using enum NumberKind;
  static constexpr NumberKind kSigned[] = {kInt8, kInt16, kInt32, kInt64},
                              kUnsigned[] = {kUint8, kUint16, kUint32, kUint64};
  constexpr bool kBig = std::endian::native == std::endian::big;
  switch (array->GetDataType()) {
    case VTK_BIT:
    case VTK_STRING:
    case VTK_VARIANT:
      return std::nullopt;
    case VTK_FLOAT:
      return NumberType{kFloat32, kBig};
    case VTK_DOUBLE:
      return NumberType{kFloat64, kBig};
    default:
      break;
  }
  const auto size = static_cast<unsigned>(array->GetDataTypeSize());
  const auto& kinds = array->GetDataTypeMin() < 0 ? kSigned : kUnsigned;
  if (!std::has_single_bit(size) || size > 8)
    return std::nullopt;
  return NumberType{kinds[std::countr_zero(size)], kBig};
}

/// The part of the file's `values` over `from` that lies in `to`, into the dense array; 0
/// elsewhere, and where `hidden` (may be null) says that nothing is.
Status copyPart(vtkDataArray* array, const std::function<bool(vtkIdType)>& hidden,
                const IndexBox& from, const IndexBox& to, std::span<float> values, double offset,
                double& rounding, const std::string& file) {
  const int channels = array->GetNumberOfComponents();
  const auto numbers = hidden ? std::nullopt : numbersOf(array);
  IndexBox part;
  for (int axis = 0; axis < 3; ++axis) {
    part.begin[axis] = std::max(from.begin[axis], to.begin[axis]);
    part.end[axis] = std::min(from.end[axis], to.end[axis]);
  }
  std::ranges::fill(values, static_cast<float>(0 - offset));
  if (part.empty())
    return {};
  const auto placeIn = [](const IndexBox& box, std::int64_t x, std::int64_t y, std::int64_t z) {
    return ((z - box.begin[2]) * box.size(1) + (y - box.begin[1])) * box.size(0) +
           (x - box.begin[0]);
  };
  for (auto z = part.begin[2]; z < part.end[2]; ++z) {
    for (auto y = part.begin[1]; y < part.end[1]; ++y) {
      const std::int64_t source = placeIn(from, part.begin[0], y, z);
      const auto row =
          values.subspan(static_cast<std::size_t>(placeIn(to, part.begin[0], y, z) * channels),
                         static_cast<std::size_t>(part.size(0) * channels));
      std::vector<double> doubles;
      for (std::int64_t i = 0; !numbers && i < part.size(0); ++i) {
        const bool none = hidden && hidden(source + i);
        for (int c = 0; c < channels; ++c)
          doubles.push_back(none ? 0 : array->GetComponent(source + i, c));
      }
      const NumberType type = numbers.value_or(
          NumberType{NumberKind::kFloat64, std::endian::native == std::endian::big});
      const void* begin = numbers ? array->GetVoidPointer(source * channels) : doubles.data();
      const auto beyond = toFloats(type, static_cast<const std::byte*>(begin),
                                   static_cast<std::ptrdiff_t>(type.size()), row, rounding, offset);
      if (beyond) {
        return fail(ErrorCode::kInvalidData,
                    "{}: the value {:g} is beyond float32, in which values are kept; expected at "
                    "most 3.4e38: scale them",
                    file, *beyond);
      }
    }
  }
  return {};
}

/// How many times an image states that is one of a sequence.
int countTimes(vtkXMLDataElement& root) {
  vtkXMLDataElement* const image = root.FindNestedElementWithName("ImageData");
  vtkXMLDataElement* const fields = image ? image->FindNestedElementWithName("FieldData") : nullptr;
  for (int i = 0; fields && i < fields->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* const array = fields->GetNestedElement(i);
    const char* name = array->GetAttribute("Name");
    int count = 0;
    if (name && std::string_view(name) == "TimeValue" &&
        array->GetScalarAttribute("NumberOfTuples", count))
      return count;
  }
  return 0;
}

class VtkReader final : public LatticeReader {
 public:
  Result<LatticeFrame> describe(const std::filesystem::path& path, const std::string& wanted,
                                const std::string& usual, bool) override {
    VOLUTE_ASSIGN(const auto root, readVtkXml(path));
    const ErrorWatch watch;
    vtkNew<vtkXMLImageDataReader> reader;
    reader->SetFileName(path.c_str());
    reader->UpdateInformation();
    VOLUTE_TRY(watch.status(path.string()));
    ArrayEntry entry;
    auto frame = describeImage(reader, wanted, path.string(), entry, partialArrays(*root), usual);
    if (!frame && frame.error().code == ErrorCode::kNotFound) {
      // Unlike grids of OpenVDB, arrays are never left out where they are empty.
      frame.error().code = ErrorCode::kInvalidData;
    }
    if (!frame)
      return frame;
    frame->time = statedTime(*reader);
    if (const int times = countTimes(*root); times > 1 && frame->leftOut[0] == '\0')
      fmt::format("all but the first of its {} times", times)
          .copy(frame->leftOut, LatticeFrame::kMaxName);
    frame->hidden = countHidden(reader, entry.cells);
    VOLUTE_TRY(watch.status(path.string()));
    return frame;
  }

  Status read(const std::filesystem::path& path, const std::string& wanted, const IndexBox&,
              const IndexBox& box, bool, std::span<float> values, double& rounding) override {
    const std::string file = path.string();
    VOLUTE_TRY(checkEnd(path));
    const ErrorWatch watch;
    vtkNew<vtkXMLImageDataReader> reader;
    reader->SetFileName(path.c_str());
    reader->UpdateInformation();
    VOLUTE_TRY(watch.status(file));
    ArrayEntry entry;
    VOLUTE_ASSIGN(const LatticeFrame frame, describeImage(reader, wanted, file, entry, {}));
    select(reader, entry.cells, {entry.name.c_str(), kGhosts});
    // Of the file's layers those that are asked for.
    IndexBox part = frame.box;
    part.begin[2] = std::max(part.begin[2], box.begin[2]);
    part.end[2] = std::min(part.end[2], box.end[2]);
    if (part.empty()) {
      std::ranges::fill(values, static_cast<float>(0 - offset_));
      return {};
    }
    int extent[6];
    for (int axis = 0; axis < 3; ++axis) {
      extent[2 * axis] = static_cast<int>(part.begin[axis]);
      extent[2 * axis + 1] = static_cast<int>(part.end[axis]) - (entry.cells ? 0 : 1);
    }
    static_cast<vtkAlgorithm&>(*reader).UpdateExtent(extent);  // hidden by a member
    VOLUTE_TRY(watch.status(file));
    vtkImageData* image = reader->GetOutput();
    vtkDataSetAttributes* const data = attributesOf(image, entry.cells);
    vtkDataArray* const ghosts = data->GetArray(kGhosts);
    std::function<bool(vtkIdType)> hidden;
    if (ghosts && ghosts->GetNumberOfTuples() == part.size(0) * part.size(1) * part.size(2))
      hidden = [ghosts, &entry](vtkIdType i) { return isHidden(ghosts, i, entry.cells); };
    vtkDataArray* array = data->GetArray(entry.name.c_str());
    const bool there = std::equal(std::begin(extent), std::end(extent), image->GetExtent());
    const std::int64_t voxels = part.size(0) * part.size(1) * part.size(2);
    if (!array || !there || array->GetNumberOfTuples() != voxels ||
        array->GetNumberOfComponents() != frame.channels) {
      return fail(ErrorCode::kInvalidData,
                  "{}: array '{}' does not have a value for each voxel; the file is damaged", file,
                  frame.grid);
    }
    return copyPart(array, hidden, part, box, values, offset_, rounding, file);
  }

  void takeOffset(double offset) override { offset_ = offset; }

 private:
  double offset_ = 0;
};

class VtkWriter final : public LatticeWriter {
 public:
  explicit VtkWriter(double offset) : offset_(offset) {}

  Status write(const std::filesystem::path& temporary, const std::filesystem::path& target,
               const VolumeInfo& info, int frame, std::span<const float> values) override {
    vtkNew<vtkFloatArray> floats;
    vtkNew<vtkDoubleArray> doubles;
    vtkDataArray* const array = offset_ == 0 ? static_cast<vtkDataArray*>(floats) : doubles;
    array->SetName(escapedXml(info.name).c_str());  // VTK writes it as it is
    array->SetNumberOfComponents(info.channels);
    if (offset_ == 0) {
      floats->SetArray(const_cast<float*>(values.data()), static_cast<vtkIdType>(values.size()),
                       /*save=*/1);
    } else {
      doubles->SetNumberOfValues(static_cast<vtkIdType>(values.size()));
      std::ranges::transform(values, doubles->GetPointer(0),
                             [this](float value) { return offset_ + value; });
    }
    vtkNew<vtkImageData> image;
    const Vec3 size = info.voxelSize();
    image->SetDimensions(info.x + 1, info.y + 1, info.z + 1);
    image->SetOrigin(info.bounds.min.data());
    image->SetSpacing(size.data());
    image->GetCellData()->SetScalars(array);
    vtkNew<vtkDoubleArray> time;
    time->SetName("TimeValue");
    time->InsertNextValue(info.times[static_cast<std::size_t>(frame)]);
    image->GetFieldData()->AddArray(time);
    vtkNew<vtkXMLImageDataWriter> writer;
    const ErrorWatch watch;
    writer->SetFileName(temporary.c_str());
    writer->SetInputData(image);
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    writer->SetHeaderTypeToUInt64();
    writer->SetCompressionLevel(1);  // five times as fast as the default, hardly larger
    const bool written = writer->Write() == 1 && writer->GetErrorCode() == 0;
    if (written && watch.status(target.string()))
      return {};
    return fail(ErrorCode::kIo, "{}: cannot write: {}", target.string(),
                writer->GetErrorCode()
                    ? vtkErrorCode::GetStringFromErrorCode(writer->GetErrorCode())
                    : "VTK refused");
  }

 private:
  double offset_;
};

Result<std::vector<TimedFile>> readPvd(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto root, readVtkXml(path));
  vtkXMLDataElement* collection = root->FindNestedElementWithName("Collection");
  if (!collection)
    return fail(ErrorCode::kInvalidData, "{}: not a VTK collection (VTKFile, Collection, DataSet)",
                path.string());
  std::vector<TimedFile> files;
  std::string group;
  for (int i = 0; i < collection->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* element = collection->GetNestedElement(i);
    const char* file = element->GetAttribute("file");
    if (element->GetName() != std::string_view("DataSet") || !file) {
      return fail(ErrorCode::kInvalidData,
                  "{}: element {} of the collection is not a DataSet with a file", path.string(),
                  i);
    }
    int part = 0;
    if (element->GetScalarAttribute("part", part) && part != 0) {
      return fail(ErrorCode::kUnsupported,
                  "{}: {} is part {} of its time; expected one file for each time", path.string(),
                  file, part);
    }
    const char* its = element->GetAttribute("group");
    if (i > 0 && group != (its ? its : "")) {
      return fail(ErrorCode::kUnsupported,
                  "{}: {} is of the group '{}' and those before it of '{}'; expected the files of "
                  "one group",
                  path.string(), file, its ? its : "", group);
    }
    group = its ? its : "";
    TimedFile& timed = files.emplace_back();
    timed.path = file;
    const char* time = element->GetAttribute("timestep");
    if (time && !element->GetScalarAttribute("timestep", timed.time)) {
      return fail(ErrorCode::kInvalidData, "{}: {} is at '{}'; expected a time in seconds",
                  path.string(), file, time);
    }
  }
  return files;
}

}  // namespace
}  // namespace volute

extern "C" const volute::LatticePlugin* voluteVtkPlugin() {
  using namespace volute;
  static constexpr LatticePlugin kPlugin{
      []() -> std::unique_ptr<LatticeReader> { return std::make_unique<VtkReader>(); },
      [](const LatticeWriterOptions& options) -> std::unique_ptr<LatticeWriter> {
        return std::make_unique<VtkWriter>(options.offset);
      },
      readPvd};
  return &kPlugin;
}
