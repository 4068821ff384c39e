// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/split_cells.hpp"

#include <algorithm>

#include "volute/tetmesh/cell_cutter.hpp"
#include "volute/tetmesh/cell_faces.hpp"

namespace volute {
namespace {

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
      if (!place.allFinite()) {
        return fail(ErrorCode::kInvalidData,
                    "{}: vertex {} is at ({}, {}, {}); expected finite metres", name, v, place.x(),
                    place.y(), place.z());
      }
    }
  }
  return {};
}

bool hasFourCorners(std::span<const std::int64_t> cell) {
  for (std::size_t i = 0; i < cell.size(); ++i) {
    if (std::ranges::count(cell, cell[i]) > 1)
      return false;
  }
  return cell.size() == 4;
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
  SplitCells out;
  CellCutter cutter(soup, out);
  const auto end = static_cast<std::int64_t>(soup.connectivity.size());
  if (soup.offsets.size() != soup.shapes.size() + 1)
    return fail(ErrorCode::kInvalidData, "{}: {} cells but {} offsets", name, soup.shapes.size(),
                soup.offsets.size());
  for (std::size_t i = 0; i < soup.shapes.size(); ++i) {
    const std::int64_t from = soup.offsets[i], to = soup.offsets[i + 1];
    if (from < 0 || to < from || to > end)
      return fail(ErrorCode::kInvalidData, "{}: cell {} lies at {} to {} of {} indices", name, i,
                  from, to, end);
    const auto cell =
        std::span(soup.connectivity)
            .subspan(static_cast<std::size_t>(from), static_cast<std::size_t>(to - from));
    auto faces = cellFaces(soup.shapes[i], cell);
    if (faces.empty())
      return fail(ErrorCode::kInvalidData, "{}: cell {} does not have the vertices of its shape",
                  name, i);
    VOLUTE_TRY(checkCorners(soup, i, faces, name));
    if (soup.shapes[i] == CellShape::kTet && hasFourCorners(cell)) {
      Tet& tet = out.tets.emplace_back();
      std::ranges::transform(cell, tet.begin(),
                             [](auto v) { return static_cast<std::int32_t>(v); });
      out.cellOf.push_back(static_cast<std::int32_t>(i));
      continue;
    }
    Status done;
    if (soup.shapes[i] == CellShape::kPolyhedron)
      done = alignFaces(faces);
    if (done)
      done = cutter.cut(static_cast<std::int32_t>(i), faces);
    if (!done)
      return fail(done.error().code, "{}: cell {} {}", name, i, done.error().message);
  }
  return out;
}

}  // namespace volute
