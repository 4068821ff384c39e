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

using Words = std::vector<std::string_view>;

Words wordsIn(std::string_view text) {
  Words words;
  constexpr std::string_view kSpace = " \t\r\n";
  for (std::size_t at = text.find_first_not_of(kSpace); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kSpace, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kSpace, end);
  }
  return words;
}

bool isOneOf(std::string_view word, const Words& words) {
  return std::ranges::find(words, word) != words.end();
}

/// What elements must and may have, all as words. "P" elements are those of .pvtu.
struct ElementRule {
  std::string_view names, needed, allowed, children;
};

constexpr std::string_view kPieceAttributes =
    "NumberOfPoints NumberOfCells NumberOfVerts NumberOfLines NumberOfStrips NumberOfPolys";
constexpr std::string_view kPieceChildren =
    "PointData CellData Points Cells Verts Lines Strips Polys FieldData Coordinates";
constexpr ElementRule kElements[] = {
    {"VTKFile", "type", "version byte_order header_type compressor",
     "ImageData UnstructuredGrid PUnstructuredGrid PolyData Collection AppendedData FieldData"},
    {"ImageData", "WholeExtent", "Origin Spacing Direction", "Piece FieldData"},
    {"UnstructuredGrid PolyData", "", "GhostLevel", "Piece FieldData"},
    {"PUnstructuredGrid", "", "GhostLevel",
     "Piece PPointData PCellData PPoints PCells FieldData PFieldData"},
    {"ImageData/Piece", "Extent", kPieceAttributes, kPieceChildren},
    {"UnstructuredGrid/Piece", "NumberOfPoints NumberOfCells", kPieceAttributes, kPieceChildren},
    {"PolyData/Piece", "", kPieceAttributes, kPieceChildren},
    {"PUnstructuredGrid/Piece", "Source", "Extent", ""},
    {"PointData CellData PPointData PCellData", "",
     "Scalars Vectors Normals Tensors TCoords GlobalIds PedigreeIds EdgeFlag Tangents "
     "RationalWeights HigherOrderDegrees ProcessIds",
     "DataArray Array PDataArray PArray"},
    {"Points Cells Verts Lines Strips Polys", "", "", "DataArray Array"},
    {"PPoints", "", "", "PDataArray"},
    {"DataArray PDataArray", "type",
     "Name NumberOfComponents NumberOfTuples format offset RangeMin RangeMax TimeStep "
     "ComponentName0",
     "InformationKey"},
    {"Collection", "", "", "DataSet"},
    {"DataSet", "file", "timestep group part name", ""},
    {"AppendedData", "encoding", "", ""},
};

/// What values attributes may have: `count` numbers, or one of `allowed`.
struct ValueRule {
  std::string_view names, allowed;
  int count = 0;
  bool whole = true;
};

constexpr ValueRule kValues[] = {
    {"type",
     "Int8 UInt8 Int16 UInt16 Int32 UInt32 Int64 UInt64 Float32 Float64 String Bit vtkIdType"},
    {"format", "ascii binary appended"},
    {"encoding", "raw base64"},
    {"byte_order", "LittleEndian BigEndian"},
    {"header_type", "UInt32 UInt64"},
    {"WholeExtent Extent", "", 6},
    {"Origin Spacing", "", 3, false},
    {"Direction", "", 9, false},
    {"timestep", "", 1, false},
    {"part offset NumberOfComponents NumberOfTuples", "", 1},
    {kPieceAttributes, "", 1},
};

/// The arrays that say how cells are made of points.
constexpr std::string_view kCellArrays =
    "connectivity offsets types faces faceoffsets face_connectivity face_offsets "
    "polyhedron_to_faces polyhedron_offsets";

bool isFinite(std::string_view word, bool whole) {
  std::int64_t integer = 0;
  double real = 0;
  return whole ? readNumber(word, integer) : readNumber(word, real) && std::isfinite(real);
}

/// Cells [begin, end) along x, y and z; a flat image has one layer of them.
using Cells = std::array<std::int64_t, 6>;

Cells extentOf(vtkXMLDataElement* element, const char* name) {
  Cells extent{};
  const char* text = element->GetAttribute(name);
  const auto words = wordsIn(text ? text : "");
  for (std::size_t i = 0; i < std::min(words.size(), extent.size()); ++i)
    readNumber(words[i], extent[i]);
  return extent;
}

std::vector<vtkXMLDataElement*> piecesIn(vtkXMLDataElement* grid) {
  std::vector<vtkXMLDataElement*> pieces;
  for (int i = 0; i < grid->GetNumberOfNestedElements(); ++i) {
    if (grid->GetNestedElement(i)->GetName() == std::string_view("Piece"))
      pieces.push_back(grid->GetNestedElement(i));
  }
  return pieces;
}

/// Whether a piece of `grid` has cells, or points; of an image it has both or none.
bool hasAny(vtkXMLDataElement* grid, vtkXMLDataElement* piece, bool cells) {
  if (!grid->GetAttribute("WholeExtent")) {
    const char* count = piece->GetAttribute(cells ? "NumberOfCells" : "NumberOfPoints");
    std::int64_t number = 0;
    return count && readNumber(count, number) && number > 0;
  }
  const Cells whole = extentOf(grid, "WholeExtent"), extent = extentOf(piece, "Extent");
  for (std::size_t axis = 0; axis < 6; axis += 2) {
    if (extent[axis + 1] < extent[axis] + (whole[axis] == whole[axis + 1] ? 0 : 1))
      return false;
  }
  return true;
}

std::vector<PartialArray> partialIn(vtkXMLDataElement* grid) {
  std::vector<PartialArray> partial;
  for (const bool ofCells : {false, true}) {
    int all = 0;
    std::map<std::string, int> counts;
    for (vtkXMLDataElement* const piece : piecesIn(grid)) {
      if (!hasAny(grid, piece, ofCells))
        continue;
      ++all;
      vtkXMLDataElement* const arrays =
          piece->FindNestedElementWithName(ofCells ? "CellData" : "PointData");
      for (int i = 0; arrays && i < arrays->GetNumberOfNestedElements(); ++i) {
        if (const char* const name = arrays->GetNestedElement(i)->GetAttribute("Name"))
          ++counts[name];
      }
    }
    for (const auto& [name, count] : counts) {
      if (count < all)
        partial.push_back({name, ofCells, count, all});
    }
  }
  return partial;
}

class XmlCheck {
 public:
  explicit XmlCheck(std::string file) : file_(std::move(file)) {}

  Status check(vtkXMLDataElement* element, std::string_view parent) const {
    const std::string_view name = element->GetName();
    const std::string below = fmt::format("{}/{}", parent, name);
    const auto rule = std::ranges::find_if(kElements, [&](const ElementRule& known) {
      const Words names = wordsIn(known.names);
      return isOneOf(name, names) || isOneOf(below, names);
    });
    if (rule == std::end(kElements))
      return {};  // of another program
    VOLUTE_TRY(checkElement(element, *rule));
    if (parent == "Cells" && name == "DataArray")
      VOLUTE_TRY(checkCellArray(element));
    for (int i = 0; i < element->GetNumberOfNestedElements(); ++i)
      VOLUTE_TRY(check(element->GetNestedElement(i), name));
    if (name == "ImageData")
      VOLUTE_TRY(checkExtents(element));
    if (name == "ImageData" || name == "UnstructuredGrid" || name == "PolyData")
      VOLUTE_TRY(checkPieces(element));
    if (name == "PointData" || name == "CellData")
      VOLUTE_TRY(checkArrayNames(element));
    return {};
  }

 private:
  template <class... Args>
  tl::unexpected<Error> wrong(vtkXMLDataElement* element, fmt::format_string<Args...> format,
                              Args&&... args) const {
    return fail(ErrorCode::kInvalidData, "{}: byte {}: {}: {}", file_, element->GetXMLByteIndex(),
                oneLine(element->GetName()), fmt::format(format, std::forward<Args>(args)...));
  }

  Status checkElement(vtkXMLDataElement* element, const ElementRule& rule) const {
    const Words needed = wordsIn(rule.needed);
    Words known = wordsIn(rule.allowed), absent;
    known.insert(known.end(), needed.begin(), needed.end());
    std::ranges::copy_if(known, std::back_inserter(absent), [&](std::string_view name) {
      return !element->GetAttribute(std::string(name).c_str());
    });
    for (int i = 0; i < element->GetNumberOfAttributes(); ++i) {
      const std::string_view name = element->GetAttributeName(i);
      if (isOneOf(name, known)) {
        VOLUTE_TRY(checkValue(element, name, element->GetAttributeValue(i)));
      } else if (const auto near = likeOneOf(name, absent); !near.empty()) {
        return wrong(element, "'{}' is unknown; did you mean '{}'?", oneLine(std::string(name)),
                     near);
      }
    }
    for (const std::string_view name : needed) {
      if (isOneOf(name, absent))
        return wrong(element, "its {} is missing", name);
    }
    const Words children = wordsIn(rule.children);
    for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) {
      const std::string_view name = element->GetNestedElement(i)->GetName();
      if (const auto near = isOneOf(name, children) ? "" : likeOneOf(name, children); !near.empty())
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
        return wrong(array, "the name '{}' is there twice", oneLine(name));
    }
    return {};
  }

  /// A name that two letters at most keep from being one of `names`.
  static std::string_view likeOneOf(std::string_view name, const Words& names) {
    const auto near = nearest(name, names);
    const bool close = editDistance(name, near) <= std::min<std::size_t>(2, near.size() / 3);
    return close || (name.size() >= 4 && near.starts_with(name)) ? near : std::string_view();
  }

  Status checkValue(vtkXMLDataElement* element, std::string_view name,
                    std::string_view value) const {
    const auto rule = std::ranges::find_if(
        kValues, [&](const ValueRule& known) { return isOneOf(name, wordsIn(known.names)); });
    const bool ofFile = element->GetName() == std::string_view("VTKFile") && name == "type";
    if (rule == std::end(kValues) || ofFile)
      return {};
    const std::string shown = oneLine(std::string(value.substr(0, 60)));
    const Words allowed = wordsIn(rule->allowed), words = wordsIn(value);
    if (rule->count == 0) {
      if (isOneOf(value, allowed))
        return {};
      return wrong(element, "{} is '{}'; expected {}", name, shown, fmt::join(allowed, ", "));
    }
    if (static_cast<int>(words.size()) == rule->count &&
        std::ranges::all_of(words, [&](auto word) { return isFinite(word, rule->whole); }))
      return {};
    return wrong(element, "{} is '{}'; expected {} {}number{}", name, shown, rule->count,
                 rule->whole ? "whole " : "", rule->count > 1 ? "s with spaces between them" : "");
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
    for (vtkXMLDataElement* const piece : piecesIn(image)) {
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

  /// VTK takes the numbers of all pieces for those of the type that the first states, and marks of
  /// hidden cells as it finds them in memory where a piece has none.
  Status checkPieces(vtkXMLDataElement* grid) const {
    std::map<std::string, std::pair<std::string, std::string>> first;
    for (vtkXMLDataElement* const piece : piecesIn(grid)) {
      for (const char* const group : {"PointData", "CellData", "Points"}) {
        vtkXMLDataElement* const arrays = piece->FindNestedElementWithName(group);
        for (int i = 0; arrays && i < arrays->GetNumberOfNestedElements(); ++i) {
          vtkXMLDataElement* const array = arrays->GetNestedElement(i);
          const auto attribute = [&](const char* name, const char* otherwise) {
            const char* const value = array->GetAttribute(name);
            return oneLine(value ? value : otherwise);
          };
          const bool points = group == std::string_view("Points");
          const std::string name = attribute("Name", points ? "Points" : "");
          const std::pair type(attribute("NumberOfComponents", "1"), attribute("type", ""));
          const auto [at, added] =
              first.emplace(fmt::format("{}/{}", group, points ? "" : name), type);
          const auto& before = at->second;
          if (before != type) {
            return wrong(
                array,
                "'{}' is of {} x {}, in a piece before it of {} x {}; expected the same in "
                "all pieces",
                name, type.first, type.second, before.first, before.second);
          }
        }
      }
    }
    for (const PartialArray& array : partialIn(grid)) {
      if (array.name == "vtkGhostType") {
        return wrong(grid, "'{}' is in {} of {} pieces; expected it in all of them", array.name,
                     array.pieces, array.all);
      }
    }
    return {};
  }

  Status checkCellArray(vtkXMLDataElement* element) const {
    const char* name = element->GetAttribute("Name");
    const Words known = wordsIn(kCellArrays);
    if (const auto near = !name || isOneOf(name, known) ? "" : likeOneOf(name, known);
        !near.empty())
      return wrong(element, "the array '{}' of Cells is unknown; did you mean '{}'?", oneLine(name),
                   near);
    return {};
  }

  std::string file_;
};

}  // namespace

std::vector<PartialArray> partialArrays(vtkXMLDataElement& root) {
  for (const char* const kind : {"ImageData", "UnstructuredGrid"}) {
    if (vtkXMLDataElement* const grid = root.FindNestedElementWithName(kind))
      return partialIn(grid);
  }
  return {};
}

Result<vtkSmartPointer<vtkXMLDataElement>> readVtkXml(const std::filesystem::path& path) {
  VOLUTE_TRY(checkEnd(path));
  const ErrorWatch watch;
  vtkNew<vtkXMLDataParser> parser;
  parser->SetFileName(path.c_str());
  const bool parsed = parser->Parse() != 0;
  VOLUTE_TRY(watch.status(path.string()));
  const vtkSmartPointer<vtkXMLDataElement> root = parsed ? parser->GetRootElement() : nullptr;
  if (!root || root->GetName() != std::string_view("VTKFile")) {
    return fail(ErrorCode::kInvalidData, "{}: is no XML of VTK; expected the element VTKFile",
                path.string());
  }
  VOLUTE_TRY(XmlCheck(path.string()).check(root, ""));
  return root;
}

}  // namespace volute
