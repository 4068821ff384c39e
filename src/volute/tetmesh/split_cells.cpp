// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/split_cells.hpp"

#include <algorithm>
#include <optional>
#include <span>

#include "volute/tetmesh/cell_cutter.hpp"
#include "volute/tetmesh/cell_faces.hpp"
#include "volute/tetmesh/hanging_vertices.hpp"

namespace volute {
namespace {

/// [m] So that volumes, and products of some, are numbers.
constexpr double kFarthest = 1e30;

/// Indices within the soup, places that are numbers.
Status checkCorners(const CellSoup& soup, std::size_t cell, const std::vector<Polygon>& faces,
                    std::string_view name) {
  for (const Polygon& face : faces) {
    for (const std::int64_t v : face) {
      if (v < 0 || v >= static_cast<std::int64_t>(soup.vertices.size())) {
        return fail(ErrorCode::kInvalidData, "{}: cell {} has vertex {}; there are {} vertices",
                    name, cell, v, soup.vertices.size());
      }
      const Vec3& place = soup.vertices[static_cast<std::size_t>(v)];
      if (!(place.cwiseAbs().maxCoeff() < kFarthest)) {
        return fail(ErrorCode::kInvalidData,
                    "{}: vertex {} is at ({}, {}, {}); expected metres, less than 1e30", name, v,
                    place.x(), place.y(), place.z());
      }
    }
  }
  return {};
}

std::span<const std::int64_t> cellOf(const CellSoup& soup, std::size_t i) {
  return std::span(soup.connectivity)
      .subspan(static_cast<std::size_t>(soup.offsets[i]),
               static_cast<std::size_t>(soup.offsets[i + 1] - soup.offsets[i]));
}

/// The tet that a cell of that shape already is; nothing where a corner is missing or named twice.
std::optional<Tet> plainTet(const CellSoup& soup, std::size_t i) {
  const std::int64_t from = soup.offsets[i];
  if (from < 0 || from > static_cast<std::int64_t>(soup.connectivity.size()) - 4 ||
      soup.offsets[i + 1] != from + 4)
    return std::nullopt;
  const std::int64_t* cell = soup.connectivity.data() + from;
  Tet tet;
  for (std::size_t k = 0; k < 4; ++k) {
    if (cell[k] < 0 || cell[k] >= static_cast<std::int64_t>(soup.vertices.size()) ||
        std::find(cell, cell + k, cell[k]) != cell + k)
      return std::nullopt;
    tet[k] = static_cast<std::int32_t>(cell[k]);
  }
  return tet;
}

/// The faces of a cell, its corners checked.
Result<std::vector<Polygon>> facesOf(const CellSoup& soup, std::size_t i, std::string_view name) {
  const auto end = static_cast<std::int64_t>(soup.connectivity.size());
  const std::int64_t from = soup.offsets[i], to = soup.offsets[i + 1];
  if (from < 0 || to < from || to > end)
    return fail(ErrorCode::kInvalidData, "{}: cell {} lies at {} to {} of {} indices", name, i,
                from, to, end);
  auto faces = cellFaces(soup.shapes[i], cellOf(soup, i));
  if (faces.empty())
    return fail(ErrorCode::kInvalidData, "{}: cell {} does not have the vertices of its shape",
                name, i);
  VOLUTE_TRY(checkCorners(soup, i, faces, name));
  return faces;
}

}  // namespace

std::vector<float> AddedVertices::follow(std::vector<float> values) const {
  for (std::size_t i = 0; i < places.size(); ++i) {
    double sum = 0;
    float least = values[static_cast<std::size_t>(from[offsets[i]])], most = least;
    for (std::size_t k = offsets[i]; k < offsets[i + 1]; ++k) {
      const float value = values[static_cast<std::size_t>(from[k])];
      sum += shares[k] * static_cast<double>(value);
      least = std::min(least, value);
      most = std::max(most, value);
    }
    values.push_back(std::clamp(static_cast<float>(sum), least, most));
  }
  return values;
}

std::vector<Vec3> SplitCells::vertices(const CellSoup& soup) const {
  std::vector<Vec3> all = soup.vertices;
  all.insert(all.end(), added.places.begin(), added.places.end());
  return all;
}

Result<SplitCells> splitCells(const CellSoup& soup, std::string_view name) {
  if (soup.offsets.size() != soup.shapes.size() + 1)
    return fail(ErrorCode::kInvalidData, "{}: {} cells but {} offsets", name, soup.shapes.size(),
                soup.offsets.size());
  HangingVertices hanging;
  for (std::size_t i = 0; i < soup.shapes.size(); ++i) {
    if (soup.shapes[i] != CellShape::kPolyhedron)
      continue;
    VOLUTE_ASSIGN(const auto faces, facesOf(soup, i, name));
    hanging.look(faces, soup.vertices);
  }
  SplitCells out;
  out.tets.reserve(soup.shapes.size());
  out.cellOf.reserve(soup.shapes.size());
  CellCutter cutter(soup, out);
  const bool inPlace =
      std::ranges::all_of(soup.vertices, [](const Vec3& v) { return v.allFinite(); });
  for (std::size_t i = 0; i < soup.shapes.size(); ++i) {
    // Most cells are tets, which nothing hangs on: their faces need not be made.
    const auto tet = soup.shapes[i] == CellShape::kTet ? plainTet(soup, i) : std::nullopt;
    std::vector<Polygon> faces;
    if (!tet || !inPlace || !hanging.empty()) {
      VOLUTE_ASSIGN(faces, facesOf(soup, i, name));
    }
    const bool changed = !hanging.empty() && hanging.insert(faces);
    if (tet && !changed) {
      out.tets.push_back(*tet);
      out.cellOf.push_back(static_cast<std::int32_t>(i));
      continue;
    }
    Status done;
    if (soup.shapes[i] == CellShape::kPolyhedron)
      done = alignFaces(faces);
    if (done)
      done = cutter.cut(static_cast<std::int32_t>(i), faces);
    if (!done)
      return fail(done.error().code, done.error().hints, "{}: cell {} {}", name, i,
                  done.error().message);
  }
  return out;
}

}  // namespace volute
