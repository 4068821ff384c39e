// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/tet_sort.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <queue>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr std::size_t kSortGrain = 4096;

/// How far the centroids are away: of the square where the eye is a point, for it sorts the same.
std::vector<float> distances(const TetMesh& mesh, const TetEye& eye) {
  std::vector<float> distance(mesh.tets().size());
  parallelRanges(distance.size(), kSortGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      Vec3 centroid = Vec3::Zero();
      for (const std::int32_t vertex : mesh.tets()[t]) centroid += 0.25 * mesh.vertices()[vertex];
      const Vec3 from = centroid - eye.point;
      distance[t] =
          static_cast<float>(eye.orthographic ? from.dot(eye.forward) : from.squaredNorm());
    }
  });
  return distance;
}

/// Which of a face's tets the eye is on the side of.
enum class Front : std::uint8_t { kFirst, kSecond, kNone };

std::vector<Front> fronts(const TetMesh& mesh, const TetEye& eye) {
  std::vector<Front> front(mesh.faces().size(), Front::kNone);
  parallelRanges(front.size(), kSortGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const TetFace& face = mesh.faces()[f];
      if (face.second == TetMesh::kBoundary)
        continue;
      const Vec3& corner = mesh.vertices()[face.vertices[0]];
      const Vec3 normal = (mesh.vertices()[face.vertices[1]] - corner)
                              .cross(mesh.vertices()[face.vertices[2]] - corner);
      const Vec3& apex = mesh.vertices()[mesh.tets()[face.first / 4][face.first % 4]];
      const double first = normal.dot(apex - corner);
      const double seen =
          eye.orthographic ? -normal.dot(eye.forward) : normal.dot(eye.point - corner);
      if (seen != 0)  // else the face is seen edge-on, and neither hides the other
        front[f] = (first > 0) == (seen > 0) ? Front::kFirst : Front::kSecond;
    }
  });
  return front;
}

/// The relations of each tet, through its half-faces.
class Relations {
 public:
  Relations(const TetMesh& mesh, const TetEye& eye)
      : mesh_(mesh), hides_(4 * mesh.tets().size()), behind_(mesh.tets().size()) {
    const std::vector<Front> front = fronts(mesh, eye);
    for (std::size_t f = 0; f < front.size(); ++f) {
      if (front[f] == Front::kNone)
        continue;
      const TetFace& face = mesh.faces()[f];
      const std::int32_t near = front[f] == Front::kFirst ? face.first : face.second;
      const std::int32_t far = front[f] == Front::kFirst ? face.second : face.first;
      hides_[far] = 1;
      ++behind_[near / 4];
    }
  }

  /// How many tets are still to be taken before this one.
  std::int8_t& behind(std::int32_t tet) { return behind_[tet]; }

  /// Calls f(near) for each tet that hides `tet` through a common face.
  template <class F>
  void forEachBefore(std::int32_t tet, F&& f) const {
    for (int k = 0; k < 4; ++k) {
      if (hides_[4 * static_cast<std::size_t>(tet) + k])
        f(mesh_.opposite(4 * tet + k) / 4);
    }
  }

 private:
  const TetMesh& mesh_;
  std::vector<char> hides_;          // half-face: the tet across is nearer
  std::vector<std::int8_t> behind_;  // 4 at most
};

std::int32_t partsOf(const TetMesh& mesh) {
  std::vector<char> seen(mesh.tets().size());
  std::vector<std::int32_t> open;
  std::int32_t parts = 0;
  for (std::size_t first = 0; first < seen.size(); ++first) {
    if (seen[first])
      continue;
    ++parts;
    seen[first] = 1;
    open.push_back(static_cast<std::int32_t>(first));
    while (!open.empty()) {
      const std::int32_t tet = open.back();
      open.pop_back();
      for (int k = 0; k < 4; ++k) {
        const std::int32_t other = mesh.opposite(4 * tet + k);
        if (other != TetMesh::kBoundary && !seen[other / 4]) {
          seen[other / 4] = 1;
          open.push_back(other / 4);
        }
      }
    }
  }
  return parts;
}

}  // namespace

TetOrder sortTets(const TetMesh& mesh, const TetEye& eye) {
  const std::vector<float> distance = distances(mesh, eye);
  Relations relations(mesh, eye);
  TetOrder order;
  order.parts = partsOf(mesh);
  const std::size_t count = mesh.tets().size();
  order.tets.reserve(count);
  const auto nearer = [&](std::int32_t a, std::int32_t b) {
    return distance[a] != distance[b] ? distance[a] < distance[b] : a > b;
  };
  std::priority_queue<std::int32_t, std::vector<std::int32_t>, decltype(nearer)> ready(nearer);
  std::vector<char> taken(count);
  std::vector<std::int32_t> byDistance;  // made when the first cycle asks for it
  std::size_t next = 0;
  for (std::size_t t = 0; t < count; ++t) {
    if (relations.behind(static_cast<std::int32_t>(t)) == 0)
      ready.push(static_cast<std::int32_t>(t));
  }
  const auto farthestLeft = [&] {
    if (byDistance.empty()) {
      for (std::size_t t = 0; t < count; ++t) byDistance.push_back(static_cast<std::int32_t>(t));
      std::ranges::sort(byDistance, [&](std::int32_t a, std::int32_t b) { return nearer(b, a); });
    }
    while (taken[byDistance[next]]) ++next;
    return byDistance[next];
  };
  while (order.tets.size() < count) {
    std::int32_t tet = 0;
    if (ready.empty()) {
      tet = farthestLeft();
      ++order.cycles;
    } else {
      tet = ready.top();
      ready.pop();
    }
    if (taken[tet])
      continue;
    taken[tet] = 1;
    order.tets.push_back(tet);
    relations.forEachBefore(tet, [&](std::int32_t near) {
      if (--relations.behind(near) == 0 && !taken[near])
        ready.push(near);
    });
  }
  return order;
}

}  // namespace volute
