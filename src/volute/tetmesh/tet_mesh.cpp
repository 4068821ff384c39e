// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_mesh.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <string>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr std::size_t kMeshGrain = 4096;

/// A tet is flat below this share of its longest edge cubed; float coordinates leave 1e-7.
constexpr double kFlat = 1e-13;

double sixVolumes(std::span<const Vec3> vertices, const Tet& tet) {
  const Vec3& o = vertices[tet[0]];
  return (vertices[tet[1]] - o).cross(vertices[tet[2]] - o).dot(vertices[tet[3]] - o);
}

double longestEdge(std::span<const Vec3> vertices, const Tet& tet) {
  double longest = 0;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < i; ++j)
      longest = std::max(longest, (vertices[tet[i]] - vertices[tet[j]]).squaredNorm());
  }
  return std::sqrt(longest);
}

/// Runs check(i) for each i on all threads; the error with the least i wins.
Status checkAll(std::size_t count, const std::function<Status(std::size_t)>& check) {
  std::mutex mutex;
  std::size_t worst = count;
  Status status;
  parallelRanges(count, kMeshGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Status one = check(i);
      if (one)
        continue;
      const std::lock_guard lock(mutex);
      if (i < worst)
        worst = i, status = std::move(one);
      return;
    }
  });
  return status;
}

Status checkVertices(std::span<const Vec3> vertices, std::string_view name) {
  return checkAll(vertices.size(), [&](std::size_t i) -> Status {
    if (vertices[i].allFinite())
      return {};
    return fail(ErrorCode::kInvalidData, "{}: vertex {} is at ({}, {}, {}); expected finite metres",
                name, i, vertices[i].x(), vertices[i].y(), vertices[i].z());
  });
}

Status checkTets(std::span<const Vec3> vertices, std::span<const Tet> tets, std::string_view name) {
  const auto count = static_cast<std::int32_t>(vertices.size());
  return checkAll(tets.size(), [&](std::size_t t) -> Status {
    for (const std::int32_t v : tets[t]) {
      if (v < 0 || v >= count) {
        return fail(ErrorCode::kInvalidData, "{}: tet {} has vertex {}; there are {} vertices",
                    name, t, v, count);
      }
    }
    const double edge = longestEdge(vertices, tets[t]);
    if (std::abs(sixVolumes(vertices, tets[t])) > kFlat * edge * edge * edge)
      return {};
    return fail(ErrorCode::kInvalidData,
                "{}: tet {} (vertices {}, {}, {}, {}) has no volume; mend the mesh", name, t,
                tets[t][0], tets[t][1], tets[t][2], tets[t][3]);
  });
}

Status checkConnected(std::size_t vertices, std::span<const Tet> tets, std::string_view name) {
  std::vector<char> used(vertices, 0);
  for (const Tet& tet : tets) {
    for (const std::int32_t v : tet) used[v] = 1;
  }
  const auto lone = std::ranges::count(used, 0);
  if (lone == 0)
    return {};
  return fail(ErrorCode::kInvalidData,
              "{}: {} vertices belong to no tet, vertex {} first; remove them and their values",
              name, lone, std::ranges::find(used, 0) - used.begin());
}

/// A half-face by its vertices but the lowest.
struct HalfFace {
  std::int32_t middle, highest, id;

  auto key() const { return std::pair(middle, highest); }
};

/// All half-faces by their lowest vertex, each list in ascending order.
struct HalfFaceLists {
  std::vector<std::int32_t> begin;
  std::vector<HalfFace> entries;

  HalfFaceLists(std::size_t vertices, std::span<const Tet> tets)
      : begin(vertices + 1, 0), entries(4 * tets.size()) {
    for (const Tet& tet : tets) {  // the lowest of three of four sorted ones
      begin[tet[0] + 1] += 3;
      begin[tet[1] + 1] += 1;
    }
    for (std::size_t v = 0; v < vertices; ++v) begin[v + 1] += begin[v];
    std::vector<std::int32_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t t = 0; t < tets.size(); ++t) {
      const Tet& tet = tets[t];
      for (int k = 0; k < 4; ++k) {
        const int a = k == 0 ? 1 : 0, b = k <= 1 ? 2 : 1, c = k == 3 ? 2 : 3;
        entries[next[tet[a]]++] = {tet[b], tet[c], static_cast<std::int32_t>(4 * t + k)};
      }
    }
    parallelRanges(vertices, kMeshGrain, [&](std::size_t from, std::size_t to) {
      for (std::size_t v = from; v < to; ++v) {
        std::sort(entries.begin() + begin[v], entries.begin() + begin[v + 1],
                  [](const HalfFace& x, const HalfFace& y) {
                    return x.key() != y.key() ? x.key() < y.key() : x.id < y.id;
                  });
      }
    });
  }
};

}  // namespace

double TetMesh::volume(std::int32_t tet) const {
  return std::abs(sixVolumes(vertices_, tets_[tet])) / 6;
}

std::array<Vec3, 4> TetMesh::slopes(std::int32_t tet) const {
  const Tet& t = tets_[tet];
  const Vec3& o = vertices_[t[0]];
  const Vec3 a = vertices_[t[1]] - o, b = vertices_[t[2]] - o, c = vertices_[t[3]] - o;
  const double scale = 1 / a.cross(b).dot(c);
  const Vec3 bc = scale * b.cross(c), ca = scale * c.cross(a), ab = scale * a.cross(b);
  return {-bc - ca - ab, bc, ca, ab};
}

std::array<double, 4> TetMesh::shares(std::int32_t tet, const Vec3& point) const {
  const auto slope = slopes(tet);
  const Vec3 from = point - vertices_[tets_[tet][0]];
  const double b = slope[1].dot(from), c = slope[2].dot(from), d = slope[3].dot(from);
  return {1 - b - c - d, b, c, d};
}

Status TetMesh::linkFaces(std::string_view name) {
  const HalfFaceLists lists(vertices_.size(), tets_);
  opposite_.assign(4 * tets_.size(), kBoundary);
  std::vector<std::int32_t> place(vertices_.size() + 1, 0);  // of the first face of each list
  const auto same = [](const HalfFace& x, const HalfFace& y) { return x.key() == y.key(); };
  for (std::size_t v = 0; v < vertices_.size(); ++v) {
    std::int32_t faces = 0;
    for (auto i = lists.begin[v]; i < lists.begin[v + 1]; ++i)
      faces += i == lists.begin[v] || !same(lists.entries[i], lists.entries[i - 1]);
    place[v + 1] = place[v] + faces;
  }
  faces_.resize(static_cast<std::size_t>(place.back()));
  VOLUTE_TRY(checkAll(vertices_.size(), [&](std::size_t v) -> Status {
    std::int32_t at = place[v];
    const std::int32_t end = lists.begin[v + 1];
    for (std::int32_t i = lists.begin[v]; i < end; ++at) {
      const HalfFace& first = lists.entries[i];
      std::int32_t next = i + 1;
      while (next < end && same(first, lists.entries[next])) ++next;
      if (next - i > 2) {
        return fail(ErrorCode::kInvalidData,
                    "{}: the face of vertices {}, {}, {} belongs to {} tets ({}, {}, {} ...); a "
                    "face has one or two",
                    name, v, first.middle, first.highest, next - i, first.id / 4,
                    lists.entries[i + 1].id / 4, lists.entries[i + 2].id / 4);
      }
      TetFace& face = faces_[at];
      face = {{static_cast<std::int32_t>(v), first.middle, first.highest}, first.id, -1};
      if (next - i == 2) {
        face.second = lists.entries[i + 1].id;
        opposite_[face.first] = face.second;
        opposite_[face.second] = face.first;
      }
      i = next;
    }
    return {};
  }));
  // With sorted vertices, the side of a face that a tet lies on is the sign of its volume times
  // that of the permutation which brings the vertex across to the front.
  const auto side = [&](std::int32_t half) {
    return (sixVolumes(vertices_, tets_[half / 4]) > 0) != ((half & 1) != 0);
  };
  VOLUTE_TRY(checkAll(faces_.size(), [&](std::size_t f) -> Status {
    const TetFace& face = faces_[f];
    if (face.second == kBoundary || side(face.first) != side(face.second))
      return {};
    return fail(ErrorCode::kInvalidData,
                "{}: tets {} and {} lie on the same side of the face that they share (vertices {}, "
                "{}, {}): one is inverted; mend the mesh",
                name, face.first / 4, face.second / 4, face.vertices[0], face.vertices[1],
                face.vertices[2]);
  }));
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (faces_[f].second == kBoundary)
      boundary_.push_back(static_cast<std::int32_t>(f));
  }
  return {};
}

Result<std::shared_ptr<const TetMesh>> TetMesh::build(std::vector<Vec3> vertices,
                                                      std::vector<Tet> tets,
                                                      std::string_view name) {
  constexpr std::size_t kMaxTets = std::size_t{1} << 29;
  if (tets.empty())
    return fail(ErrorCode::kInvalidData, "{}: has no cells with a volume", name);
  if (tets.size() > kMaxTets || vertices.size() > kMaxTets) {
    return fail(ErrorCode::kTooLarge, "{}: {} tets and {} vertices; at most {} of each", name,
                tets.size(), vertices.size(), kMaxTets);
  }
  VOLUTE_TRY(checkVertices(vertices, name));
  VOLUTE_TRY(checkTets(vertices, tets, name));
  VOLUTE_TRY(checkConnected(vertices.size(), tets, name));
  const std::shared_ptr<TetMesh> mesh(new TetMesh);
  for (Tet& tet : tets) std::ranges::sort(tet);
  mesh->vertices_ = std::move(vertices);
  mesh->tets_ = std::move(tets);
  for (const Vec3& vertex : mesh->vertices_) mesh->bounds_.extend(vertex);
  VOLUTE_TRY(mesh->linkFaces(name));
  return mesh;
}

}  // namespace volute
