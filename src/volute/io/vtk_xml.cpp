// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/vtk_xml.hpp"

#include <fmt/format.h>
#include <vtkNew.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/number_word.hpp"
#include "volute/base/suggest.hpp"
#include "volute/io/vtk_errors.hpp"

namespace volute {
namespace {

using Names = std::vector<std::string_view>;

enum class XmlValue { kText, kWhole, kReal, kOneOf };

struct XmlRule {
  std::string_view name;
  XmlValue value = XmlValue::kText;
  int count = 1;  ///< of numbers
  bool needed = false;
  Names allowed{};  ///< of kOneOf
};

struct XmlElementRule {
  std::vector<XmlRule> attributes;
  Names children{};
};

const Names kDataNames = {"DataArray", "Array"};

XmlElementRule pointsOrCells() {
  XmlElementRule rule;
  for (const std::string_view name :
       {"Scalars", "Vectors", "Normals", "Tensors", "TCoords", "GlobalIds", "PedigreeIds",
        "EdgeFlag", "Tangents", "RationalWeights", "HigherOrderDegrees", "ProcessIds"})
    rule.attributes.push_back({name});
  rule.children = {"DataArray", "Array", "PDataArray", "PArray"};
  return rule;
}

XmlElementRule dataArray() {
  XmlElementRule rule;
  rule.attributes = {
      {"type",
       XmlValue::kOneOf,
       1,
       true,
       {"Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Float32",
        "Float64", "String", "Bit", "vtkIdType"}},
      {"Name"},
      {"NumberOfComponents", XmlValue::kWhole},
      {"NumberOfTuples", XmlValue::kWhole},
      {"format", XmlValue::kOneOf, 1, false, {"ascii", "binary", "appended"}},
      {"offset", XmlValue::kWhole},
      {"RangeMin"},
      {"RangeMax"},
      {"TimeStep"},
      {"encoding"},
      {"ComponentName0"},
  };
  rule.children = {"InformationKey"};
  return rule;
}

XmlElementRule pieceOfGrid(bool parallel) {
  if (parallel)
    return {{{"Source", XmlValue::kText, 1, true}, {"Extent", XmlValue::kWhole, 6}}};
  return {{{"NumberOfPoints", XmlValue::kWhole},
           {"NumberOfCells", XmlValue::kWhole},
           {"NumberOfVerts", XmlValue::kWhole},
           {"NumberOfLines", XmlValue::kWhole},
           {"NumberOfStrips", XmlValue::kWhole},
           {"NumberOfPolys", XmlValue::kWhole},
           {"Extent", XmlValue::kWhole, 6}},
          {"PointData", "CellData", "Points", "Cells", "Verts", "Lines", "Strips", "Polys",
           "FieldData", "Coordinates"}};
}

/// What the elements may have. "P" elements are those of .pvtu.
const std::map<std::string_view, XmlElementRule>& xmlRules() {
  static const std::map<std::string_view, XmlElementRule> kRules = {
      {"VTKFile",
       {{{"type", XmlValue::kText, 1, true},
         {"version"},
         {"byte_order", XmlValue::kOneOf, 1, false, {"LittleEndian", "BigEndian"}},
         {"header_type", XmlValue::kOneOf, 1, false, {"UInt32", "UInt64"}},
         {"compressor"}},
        {"ImageData", "UnstructuredGrid", "PUnstructuredGrid", "PolyData", "Collection",
         "AppendedData", "FieldData"}}},
      {"ImageData",
       {{{"WholeExtent", XmlValue::kWhole, 6, true},
         {"Origin", XmlValue::kReal, 3},
         {"Spacing", XmlValue::kReal, 3},
         {"Direction", XmlValue::kReal, 9}},
        {"Piece", "FieldData"}}},
      {"UnstructuredGrid", {{{"GhostLevel"}}, {"Piece", "FieldData"}}},
      {"PolyData", {{{"GhostLevel"}}, {"Piece", "FieldData"}}},
      {"PUnstructuredGrid",
       {{{"GhostLevel"}},
        {"Piece", "PPointData", "PCellData", "PPoints", "PCells", "FieldData", "PFieldData"}}},
      {"PointData", pointsOrCells()},
      {"CellData", pointsOrCells()},
      {"PPointData", pointsOrCells()},
      {"PCellData", pointsOrCells()},
      {"Points", {{}, kDataNames}},
      {"Cells", {{}, kDataNames}},
      {"Verts", {{}, kDataNames}},
      {"Lines", {{}, kDataNames}},
      {"Strips", {{}, kDataNames}},
      {"Polys", {{}, kDataNames}},
      {"PPoints", {{}, {"PDataArray"}}},
      {"DataArray", dataArray()},
      {"PDataArray", dataArray()},
      {"Collection", {{}, {"DataSet"}}},
      {"DataSet",
       {{{"timestep", XmlValue::kReal},
         {"group"},
         {"part", XmlValue::kWhole},
         {"file", XmlValue::kText, 1, true},
         {"name"}}}},
      {"AppendedData", {{{"encoding", XmlValue::kOneOf, 1, true, {"raw", "base64"}}}}},
  };
  return kRules;
}

/// The arrays that say how cells are made of points.
const Names kCellArrays = {
    "connectivity",      "offsets",           "types",        "faces",
    "faceoffsets",       "face_connectivity", "face_offsets", "polyhedron_to_faces",
    "polyhedron_offsets"};

std::vector<std::string_view> wordsOf(std::string_view text) {
  std::vector<std::string_view> words;
  constexpr std::string_view kSpace = " \t\r\n";
  for (std::size_t at = text.find_first_not_of(kSpace); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kSpace, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kSpace, end);
  }
  return words;
}

template <class T>
bool isNumberWord(std::string_view word) {
  T value{};
  if (!readNumber(word, value))
    return false;
  if constexpr (std::is_floating_point_v<T>)
    return std::isfinite(value);
  return true;
}

class XmlCheck {
 public:
  explicit XmlCheck(std::string file) : file_(std::move(file)) {}

  Status check(vtkXMLDataElement* element, std::string_view parent) const {
    const std::string_view name = element->GetName();
    const bool parallel = parent == "PUnstructuredGrid";
    if (name == "Piece") {
      VOLUTE_TRY(checkElement(element, pieceOfGrid(parallel)));
      if (parent == "ImageData")
        VOLUTE_TRY(need(element, {"Extent"}));
      else if (parent == "UnstructuredGrid")
        VOLUTE_TRY(need(element, {"NumberOfPoints", "NumberOfCells"}));
    } else if (const auto rule = xmlRules().find(name); rule != xmlRules().end()) {
      VOLUTE_TRY(checkElement(element, rule->second));
    } else {
      return {};  // of another program
    }
    if (parent == "Cells" && name == "DataArray")
      VOLUTE_TRY(checkCellArray(element));
    for (int i = 0; i < element->GetNumberOfNestedElements(); ++i)
      VOLUTE_TRY(check(element->GetNestedElement(i), name));
    if (name == "ImageData")
      VOLUTE_TRY(checkExtents(element));
    if (name == "PointData" || name == "CellData")
      VOLUTE_TRY(checkArrayNames(element));
    return {};
  }

 private:
  template <class... Args>
  tl::unexpected<Error> wrong(vtkXMLDataElement* element, fmt::format_string<Args...> format,
                              Args&&... args) const {
    return fail(ErrorCode::kInvalidData, "{}: byte {}: {}: {}", file_, element->GetXMLByteIndex(),
                printable(element->GetName()), fmt::format(format, std::forward<Args>(args)...));
  }

  Status need(vtkXMLDataElement* element, const Names& names) const {
    for (const std::string_view name : names) {
      if (!element->GetAttribute(std::string(name).c_str()))
        return wrong(element, "its {} is missing", name);
    }
    return {};
  }

  Status checkElement(vtkXMLDataElement* element, const XmlElementRule& rule) const {
    Names absent;
    for (const XmlRule& attribute : rule.attributes) {
      if (!element->GetAttribute(std::string(attribute.name).c_str()))
        absent.push_back(attribute.name);
    }
    for (int i = 0; i < element->GetNumberOfAttributes(); ++i) {
      const std::string_view name = element->GetAttributeName(i);
      const auto known = std::ranges::find(rule.attributes, name, &XmlRule::name);
      if (known != rule.attributes.end()) {
        VOLUTE_TRY(checkValue(element, *known, element->GetAttributeValue(i)));
      } else if (const auto near = likeOneOf(name, absent); !near.empty()) {
        return wrong(element, "'{}' is unknown; did you mean '{}'?", printable(std::string(name)),
                     near);
      }
    }
    for (const XmlRule& attribute : rule.attributes) {
      if (attribute.needed)
        VOLUTE_TRY(need(element, {attribute.name}));
    }
    for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) {
      const std::string_view name = element->GetNestedElement(i)->GetName();
      if (std::ranges::find(rule.children, name) != rule.children.end())
        continue;
      if (const auto near = likeOneOf(name, rule.children); !near.empty())
        return wrong(element->GetNestedElement(i), "is unknown; did you mean '{}'?", near);
    }
    return {};
  }

  Status checkArrayNames(vtkXMLDataElement* element) const {
    std::set<std::string_view> names;
    for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) {
      vtkXMLDataElement* const array = element->GetNestedElement(i);
      const char* const name = array->GetAttribute("Name");
      if (name && !names.insert(name).second)
        return wrong(array, "the name '{}' is there twice", printable(name));
    }
    return {};
  }

  /// A name that two letters at most keep from being one of `names`.
  static std::string_view likeOneOf(std::string_view name, const Names& names) {
    const auto near = nearest(name, names);
    const bool close = editDistance(name, near) <= std::min<std::size_t>(2, near.size() / 3);
    return close || (name.size() >= 4 && near.starts_with(name)) ? near : std::string_view();
  }

  Status checkValue(vtkXMLDataElement* element, const XmlRule& rule, std::string_view value) const {
    const std::string shown = printable(std::string(value.substr(0, 60)));
    if (rule.value == XmlValue::kOneOf) {
      if (std::ranges::find(rule.allowed, value) != rule.allowed.end())
        return {};
      return wrong(element, "{} is '{}'; expected {}", rule.name, shown,
                   fmt::format("{}", fmt::join(rule.allowed, ", ")));
    }
    if (rule.value == XmlValue::kText)
      return {};
    const auto words = wordsOf(value);
    const bool whole = rule.value == XmlValue::kWhole;
    const bool numbers = std::ranges::all_of(words, [&](std::string_view word) {
      return whole ? isNumberWord<std::int64_t>(word) : isNumberWord<double>(word);
    });
    if (numbers && static_cast<int>(words.size()) == rule.count)
      return {};
    return wrong(element, "{} is '{}'; expected {} {}number{}", rule.name, shown, rule.count,
                 whole ? "whole " : "", rule.count > 1 ? "s with spaces between them" : "");
  }

  /// Cells [begin, end) along x, y and z; a flat image has one layer of them.
  using Cells = std::array<std::int64_t, 6>;

  static Cells extentOf(vtkXMLDataElement* element, const char* name) {
    Cells extent{};
    const char* text = element->GetAttribute(name);
    const auto words = wordsOf(text ? text : "");
    for (std::size_t i = 0; i < std::min(words.size(), extent.size()); ++i)
      readNumber(words[i], extent[i]);
    return extent;
  }

  /// Every cell is in one piece: VTK leaves what no piece fills as it finds it in memory, and of
  /// pieces that overlap the last one counts.
  Status checkExtents(vtkXMLDataElement* image) const {
    const Cells whole = extentOf(image, "WholeExtent");
    // How the number of pieces that a cell is in changes at corners, in the order of z, y and x:
    // it is 1 throughout where the changes are those of the whole extent.
    std::map<std::array<std::int64_t, 3>, int> changes;
    const auto add = [&](Cells cells, int by) {
      for (std::size_t axis = 0; axis < 6; axis += 2) {
        const bool flat = whole[axis] == whole[axis + 1];
        if (cells[axis + 1] < cells[axis] + (flat ? 0 : 1))
          return;
        if (flat)
          cells[axis] = 0, cells[axis + 1] = 1;
      }
      for (unsigned corner = 0; corner < 8; ++corner) {
        const unsigned x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
        changes[{cells[4 + z], cells[2 + y], cells[x]}] += (x + y + z) % 2 == 0 ? by : -by;
      }
    };
    add(whole, -1);
    for (int i = 0; i < image->GetNumberOfNestedElements(); ++i) {
      vtkXMLDataElement* const piece = image->GetNestedElement(i);
      if (piece->GetName() != std::string_view("Piece"))
        continue;
      const Cells extent = extentOf(piece, "Extent");
      for (std::size_t axis = 0; axis < 6; axis += 2) {
        if (extent[axis] < whole[axis] || extent[axis + 1] > whole[axis + 1])
          return wrong(
              piece,
              "its Extent along {} is {} to {}; expected it within the WholeExtent, {} to {}",
              "xyz"[axis / 2], extent[axis], extent[axis + 1], whole[axis], whole[axis + 1]);
      }
      add(extent, 1);
    }
    for (const auto& [place, change] : changes) {
      if (change == 0)
        continue;
      return wrong(image,
                   "the cell {},{},{} (x,y,z) is in {}; expected pieces that fill the "
                   "WholeExtent and do not overlap; write the file anew",
                   place[2], place[1], place[0],
                   change < 0 ? "none of its pieces" : fmt::format("{} of its pieces", 1 + change));
    }
    return {};
  }

  Status checkCellArray(vtkXMLDataElement* element) const {
    const char* name = element->GetAttribute("Name");
    if (!name || std::ranges::find(kCellArrays, std::string_view(name)) != kCellArrays.end())
      return {};
    const auto near = likeOneOf(name, kCellArrays);
    if (near.empty())
      return {};
    return wrong(element, "the array '{}' of Cells is unknown; did you mean '{}'?", printable(name),
                 near);
  }

  std::string file_;
};

}  // namespace

Status checkVtkXml(const std::filesystem::path& path) {
  VOLUTE_TRY(checkEnd(path));
  const ErrorWatch watch;
  vtkNew<vtkXMLDataParser> parser;
  parser->SetFileName(path.c_str());
  const bool parsed = parser->Parse() != 0;
  VOLUTE_TRY(watch.status(path.string()));
  vtkXMLDataElement* root = parsed ? parser->GetRootElement() : nullptr;
  if (!root || root->GetName() != std::string_view("VTKFile")) {
    return fail(ErrorCode::kInvalidData, "{}: is no XML of VTK; expected the element VTKFile",
                path.string());
  }
  return XmlCheck(path.string()).check(root, "");
}

}  // namespace volute
