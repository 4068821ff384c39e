// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/split_cells.hpp"

#include <algorithm>
#include <span>

namespace volute {
namespace {

using Polygon = std::vector<std::int64_t>;

/// Faces of the shapes with a fixed number of vertices.
const std::vector<std::vector<int>>& facesOf(CellShape shape) {
  static const std::vector<std::vector<int>> tet{{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
  static const std::vector<std::vector<int>> pyramid{
      {0, 1, 2, 3}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  static const std::vector<std::vector<int>> wedge{
      {0, 1, 2}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
  static const std::vector<std::vector<int>> hexahedron{{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                                        {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  switch (shape) {
    case CellShape::kPyramid:
      return pyramid;
    case CellShape::kWedge:
      return wedge;
    case CellShape::kHexahedron:
      return hexahedron;
    default:
      return tet;
  }
}

std::size_t verticesOf(CellShape shape) {
  switch (shape) {
    case CellShape::kPyramid:
      return 5;
    case CellShape::kWedge:
      return 6;
    case CellShape::kHexahedron:
      return 8;
    default:
      return 4;
  }
}

/// The faces of a cell; empty when its list does not add up.
std::vector<Polygon> polygons(CellShape shape, std::span<const std::int64_t> cell) {
  std::vector<Polygon> faces;
  if (shape != CellShape::kPolyhedron) {
    if (cell.size() != verticesOf(shape))
      return {};
    for (const auto& face : facesOf(shape)) {
      Polygon& polygon = faces.emplace_back();
      for (const int i : face) polygon.push_back(cell[static_cast<std::size_t>(i)]);
    }
    return faces;
  }
  std::size_t at = 1;
  for (std::int64_t f = 0; !cell.empty() && f < cell[0]; ++f) {
    if (at >= cell.size() || cell[at] < 3 ||
        static_cast<std::size_t>(cell[at]) > cell.size() - at - 1)
      return {};
    const auto count = static_cast<std::size_t>(cell[at]);
    const auto face = cell.subspan(at + 1, count);
    faces.emplace_back(face.begin(), face.end());
    at += 1 + count;
  }
  return at == cell.size() ? faces : std::vector<Polygon>{};
}

void addTets(const std::vector<Polygon>& faces, std::int32_t cell, SplitCells& out) {
  std::int64_t tip = faces.front().front();
  for (const Polygon& face : faces) tip = std::min(tip, std::ranges::min(face));
  for (const Polygon& face : faces) {
    if (std::ranges::find(face, tip) != face.end())
      continue;
    const auto n = face.size();
    const auto low = static_cast<std::size_t>(std::ranges::min_element(face) - face.begin());
    for (std::size_t i = 1; i + 1 < n; ++i) {
      out.tets.push_back({static_cast<std::int32_t>(tip), static_cast<std::int32_t>(face[low]),
                          static_cast<std::int32_t>(face[(low + i) % n]),
                          static_cast<std::int32_t>(face[(low + i + 1) % n])});
      out.cellOf.push_back(cell);
    }
  }
}

}  // namespace

Result<SplitCells> splitCells(const CellSoup& soup, std::string_view name) {
  SplitCells out;
  const auto end = static_cast<std::int64_t>(soup.connectivity.size());
  if (soup.offsets.size() != soup.shapes.size() + 1)
    return fail(ErrorCode::kInvalidData, "{}: {} cells but {} offsets", name, soup.shapes.size(),
                soup.offsets.size());
  for (std::size_t i = 0; i < soup.shapes.size(); ++i) {
    const std::int64_t from = soup.offsets[i], to = soup.offsets[i + 1];
    if (from < 0 || to < from || to > end)
      return fail(ErrorCode::kInvalidData, "{}: cell {} lies at {} to {} of {} indices", name, i,
                  from, to, end);
    const auto faces = polygons(soup.shapes[i], std::span(soup.connectivity)
                                                    .subspan(static_cast<std::size_t>(from),
                                                             static_cast<std::size_t>(to - from)));
    if (faces.empty())
      return fail(ErrorCode::kInvalidData, "{}: cell {} does not have the vertices of its shape",
                  name, i);
    for (const Polygon& face : faces) {
      for (const std::int64_t v : face) {
        if (v < 0 || v >= static_cast<std::int64_t>(soup.vertices.size()))
          return fail(ErrorCode::kInvalidData, "{}: cell {} has vertex {}; there are {} vertices",
                      name, i, v, soup.vertices.size());
      }
    }
    addTets(faces, static_cast<std::int32_t>(i), out);
  }
  return out;
}

}  // namespace volute
