// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/mesh_walls.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "volute/tetmesh/cell_faces.hpp"

namespace volute {
namespace {

using Coordinates = std::array<double, 3>;

Coordinates coordinatesOf(const Vec3& point) {
  return {point.x(), point.y(), point.z()};
}

/// The same for a face in any turn, from either side.
std::vector<Coordinates> keyOf(const WallPolygon& polygon) {
  std::vector<Coordinates> key;
  for (const Vec3& corner : polygon) key.push_back(coordinatesOf(corner));
  std::ranges::sort(key);
  return key;
}

/// A cell at walls.
struct NearCell {
  std::size_t cell = 0;
  std::vector<Polygon> faces{};
};

/// Calls each(id) for the vertices of a cell in the soup's list.
template <class Each>
void forVertices(CellSoup& soup, std::size_t cell, const Each& each) {
  const auto begin = static_cast<std::size_t>(soup.offsets[cell]);
  const auto end = static_cast<std::size_t>(soup.offsets[cell + 1]);
  if (soup.shapes[cell] != CellShape::kPolyhedron) {
    for (std::size_t i = begin; i < end; ++i) each(soup.connectivity[i]);
    return;
  }
  for (std::size_t i = begin + 1; i < end;) {  // faces, each with its count before it
    const auto count = static_cast<std::size_t>(std::max<std::int64_t>(soup.connectivity[i], 0));
    const std::size_t last = std::min(end, i + 1 + count);
    for (++i; i < last; ++i) each(soup.connectivity[i]);
  }
}

/// Which cells around each vertex hang together.
class Bonds {
 public:
  using Corner = std::pair<std::int64_t, std::size_t>;  // a vertex of a cell

  void add(const Corner& corner) { numbers_.try_emplace(corner, numbers_.size()); }

  void settle() {
    above_.resize(numbers_.size());
    std::iota(above_.begin(), above_.end(), std::size_t{0});
  }

  void join(const Corner& a, const Corner& b) { above_[top(a)] = top(b); }

  std::size_t top(const Corner& corner) {
    std::size_t at = numbers_.at(corner);
    while (above_[at] != at) at = above_[at] = above_[above_[at]];
    return at;
  }

  /// By vertex, then by cell.
  const std::map<Corner, std::size_t>& corners() const { return numbers_; }

 private:
  std::map<Corner, std::size_t> numbers_;
  std::vector<std::size_t> above_;
};

}  // namespace

std::vector<WallPolygon> wallsWithin(std::span<const WallPolygon> walls,
                                     std::span<const WallPolygon> open) {
  std::set<std::vector<Coordinates>> passable;
  for (const WallPolygon& polygon : open) passable.insert(keyOf(polygon));
  std::vector<std::pair<std::vector<Coordinates>, std::size_t>> all;
  all.reserve(walls.size());
  for (std::size_t i = 0; i < walls.size(); ++i) all.emplace_back(keyOf(walls[i]), i);
  std::ranges::sort(all);
  std::vector<WallPolygon> within;
  for (std::size_t i = 1; i < all.size(); ++i) {
    const auto& key = all[i].first;
    const bool third = i > 1 && key == all[i - 2].first;
    if (key == all[i - 1].first && !third && !passable.contains(key))
      within.push_back(walls[all[i].second]);
  }
  return within;
}

std::vector<WallCorners> splitAtWalls(std::span<const WallPolygon> walls, CellSoup& soup,
                                      std::vector<float>* values) {
  std::vector<WallCorners> triangles;
  if (walls.empty())
    return triangles;
  std::set<std::vector<Coordinates>> keys;
  std::set<Coordinates> corners;
  for (const WallPolygon& polygon : walls) {
    keys.insert(keyOf(polygon));
    for (const Vec3& corner : polygon) corners.insert(coordinatesOf(corner));
  }
  std::vector<char> isCorner;
  isCorner.reserve(soup.vertices.size());
  for (const Vec3& vertex : soup.vertices)
    isCorner.push_back(corners.contains(coordinatesOf(vertex)));
  const auto isAtWall = [&](std::int64_t id) {
    return id >= 0 && id < std::ssize(isCorner) && isCorner[static_cast<std::size_t>(id)] != 0;
  };
  std::vector<NearCell> near;
  Bonds bonds;
  for (std::size_t i = 0; i < soup.shapes.size(); ++i) {
    bool isNear = false;
    forVertices(soup, i, [&](std::int64_t id) {
      if (isAtWall(id))
        isNear = true, bonds.add({id, i});
    });
    if (!isNear)
      continue;
    const auto ids = std::span(soup.connectivity)
                         .subspan(static_cast<std::size_t>(soup.offsets[i]),
                                  static_cast<std::size_t>(soup.offsets[i + 1] - soup.offsets[i]));
    near.push_back({i, cellFaces(soup.shapes[i], ids)});
  }
  bonds.settle();
  // Faces between cells bind them, but for walls.
  std::map<std::vector<Coordinates>, std::pair<std::size_t, const Polygon*>> found;
  std::map<Polygon, std::size_t> waiting;  // for the cell on the other side
  for (const NearCell& one : near) {
    for (const Polygon& face : one.faces) {
      if (std::ranges::none_of(face, isAtWall))
        continue;
      WallPolygon polygon;
      for (const std::int64_t id : face) {
        if (isAtWall(id))
          polygon.push_back(soup.vertices[static_cast<std::size_t>(id)]);
      }
      if (polygon.size() == face.size()) {
        auto key = keyOf(polygon);
        if (keys.contains(key)) {
          found.try_emplace(std::move(key), one.cell, &face);
          continue;
        }
      }
      Polygon sorted = face;
      std::ranges::sort(sorted);
      const auto [other, first] = waiting.try_emplace(sorted, one.cell);
      for (const std::int64_t id : sorted) {
        if (!first && isAtWall(id))
          bonds.join({id, one.cell}, {id, other->second});
      }
    }
  }
  // The first of the parts around a vertex keeps it.
  std::map<Bonds::Corner, std::int64_t> renamed;
  std::map<std::size_t, std::int64_t> names;  // of each part
  std::int64_t last = -1;
  for (const auto& [corner, number] : bonds.corners()) {
    const auto [vertex, cell] = corner;
    const std::size_t part = bonds.top(corner);
    if (vertex != std::exchange(last, vertex)) {
      names = {{part, vertex}};
      continue;
    }
    const auto [name, isNew] = names.try_emplace(part, std::ssize(soup.vertices));
    if (isNew) {
      soup.vertices.push_back(Vec3(soup.vertices[static_cast<std::size_t>(vertex)]));
      if (values)
        values->push_back(float{(*values)[static_cast<std::size_t>(vertex)]});
    }
    if (name->second != vertex)
      renamed[corner] = name->second;
  }
  const auto nameOf = [&](std::int64_t vertex, std::size_t cell) {
    const auto name = renamed.find({vertex, cell});
    return name == renamed.end() ? vertex : name->second;
  };
  for (const NearCell& one : near) {
    forVertices(soup, one.cell, [&](std::int64_t& id) { id = nameOf(id, one.cell); });
  }
  for (const auto& [key, where] : found) {
    const auto& [cell, face] = where;
    for (std::size_t k = 2; k < face->size(); ++k)
      triangles.push_back(
          {nameOf((*face)[0], cell), nameOf((*face)[k - 1], cell), nameOf((*face)[k], cell)});
  }
  return triangles;
}

}  // namespace volute
