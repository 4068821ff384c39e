// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/cell_faces.hpp"

#include <algorithm>
#include <tuple>

namespace volute {
namespace {

/// Faces of the shapes with a fixed number of vertices, aligned.
const std::vector<std::vector<int>>& facesOf(CellShape shape) {
  static const std::vector<std::vector<int>> tet{{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  static const std::vector<std::vector<int>> pyramid{
      {0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  static const std::vector<std::vector<int>> wedge{
      {0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}};
  static const std::vector<std::vector<int>> hexahedron{{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
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

/// Without collapsed edges; what is left may be no face.
void open(Polygon& face) {
  face.erase(std::unique(face.begin(), face.end()), face.end());
  while (face.size() > 1 && face.front() == face.back()) face.pop_back();
}

struct Edge {
  std::int64_t low, high;
  std::size_t face;
  bool upwards;  ///< the face passes it from `low` to `high`

  auto key() const { return std::tuple(low, high, face); }
};

std::vector<Edge> edgesOf(const std::vector<Polygon>& faces) {
  std::vector<Edge> edges;
  std::size_t count = 0;
  for (const Polygon& face : faces) count += face.size();
  edges.reserve(count);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (std::size_t i = 0; i < faces[f].size(); ++i) {
      const std::int64_t from = faces[f][i], to = faces[f][(i + 1) % faces[f].size()];
      edges.push_back({std::min(from, to), std::max(from, to), f, from < to});
    }
  }
  std::ranges::sort(edges, {}, &Edge::key);
  return edges;
}

}  // namespace

std::vector<Polygon> cellFaces(CellShape shape, std::span<const std::int64_t> cell) {
  std::vector<Polygon> faces;
  if (shape != CellShape::kPolyhedron) {
    if (cell.size() != verticesOf(shape))
      return {};
    for (const auto& face : facesOf(shape)) {
      Polygon& polygon = faces.emplace_back();
      for (const int i : face) polygon.push_back(cell[static_cast<std::size_t>(i)]);
    }
  } else {
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
    if (at != cell.size())
      return {};
  }
  for (Polygon& face : faces) open(face);
  std::erase_if(faces, [](const Polygon& face) { return face.size() < 3; });
  return faces;
}

Status alignFaces(std::vector<Polygon>& faces) {
  const std::vector<Edge> edges = edgesOf(faces);
  for (std::size_t i = 0; i < edges.size();) {
    const Edge& edge = edges[i];
    std::size_t next = i + 1;
    while (next < edges.size() && edges[next].low == edge.low && edges[next].high == edge.high)
      ++next;
    if (next - i != 2) {
      return fail(ErrorCode::kInvalidData,
                  "is not closed: its edge from vertex {} to {} belongs to {} of its faces; "
                  "expected 2; mend the mesh",
                  edge.low, edge.high, next - i);
    }
    i = next;
  }
  enum class Sense : char { kUnknown, kAsItIs, kTurned };
  std::vector<Sense> senses(faces.size(), Sense::kUnknown);
  senses[0] = Sense::kAsItIs;
  std::size_t reached = 1;
  // From each face that is known to those beside it, until nothing is new.
  for (bool goesOn = true; goesOn;) {
    goesOn = false;
    for (std::size_t i = 0; i < edges.size(); i += 2) {
      Sense *from = &senses[edges[i].face], *to = &senses[edges[i + 1].face];
      if (*from == Sense::kUnknown)
        std::swap(from, to);
      if (*from == Sense::kUnknown)
        continue;
      const bool turned = (*from == Sense::kTurned) != (edges[i].upwards == edges[i + 1].upwards);
      const Sense sense = turned ? Sense::kTurned : Sense::kAsItIs;
      if (*to == Sense::kUnknown) {
        *to = sense;
        ++reached;
        goesOn = true;
      } else if (*to != sense) {
        return fail(ErrorCode::kInvalidData,
                    "has no inside: its faces cannot all be turned outwards; mend the mesh");
      }
    }
  }
  if (reached != faces.size()) {
    return fail(ErrorCode::kInvalidData,
                "has {} faces of which {} hang together; expected one body; mend the mesh",
                faces.size(), reached);
  }
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (senses[f] == Sense::kTurned)
      std::ranges::reverse(faces[f]);
  }
  return {};
}

}  // namespace volute
