// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/face_planes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr std::size_t kGrain = 4096;
constexpr std::int32_t kNone = -1;

/// Tets that may be next, by distance.
class Buckets {
 public:
  Buckets(std::size_t tets, std::size_t buckets) : head_(buckets, kNone), next_(tets, kNone) {}

  void push(std::int32_t tet, std::int32_t bucket) {
    next_[tet] = std::exchange(head_[std::max(bucket, first_)], tet);
  }

  /// The nearest, or kNone.
  std::int32_t pop() {
    for (; first_ < static_cast<std::int32_t>(head_.size()); ++first_) {
      const std::int32_t tet = head_[first_];
      if (tet == kNone)
        continue;
      head_[first_] = next_[tet];
      return tet;
    }
    first_ = static_cast<std::int32_t>(head_.size()) - 1;
    return kNone;
  }

 private:
  std::vector<std::int32_t> head_, next_;
  std::int32_t first_ = 0;
};

/// The bucket of each tet, by the distance of its centre.
std::vector<std::int32_t> bucketsOf(const TetMesh& mesh, const ViewOrigin& view,
                                    std::int32_t buckets) {
  std::vector<float> distance(mesh.tets().size());
  parallelRanges(distance.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      Vec3 from = -view.eye;
      for (const std::int32_t v : mesh.tets()[t]) from += 0.25 * mesh.vertices()[v];
      distance[t] = static_cast<float>(view.orthographic ? from.dot(view.forward) : from.norm());
    }
  });
  const auto [least, most] = std::ranges::minmax(distance);
  const float per = static_cast<float>(buckets - 1) / std::max(most - least, 1e-30F);
  std::vector<std::int32_t> out(distance.size());
  for (std::size_t t = 0; t < out.size(); ++t)
    out[t] = static_cast<std::int32_t>((distance[t] - least) * per);
  return out;
}

}  // namespace

FacePlanes::FacePlanes(const TetMesh& mesh)
    : planes(mesh.faces().size()), sides(mesh.tets().size()) {
  parallelRanges(planes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const TetFace& face = mesh.faces()[f];
      const Vec3 v[3] = {mesh.vertices()[face.vertices[0]], mesh.vertices()[face.vertices[1]],
                         mesh.vertices()[face.vertices[2]]};
      Vec3 normal = (v[1] - v[0]).cross(v[2] - v[0]).normalized();
      const std::int32_t apex = mesh.tets()[face.first / 4][face.first % 4];
      if (normal.dot(v[0] - mesh.vertices()[apex]) < 0)
        normal = -normal;
      planes[f] = {normal, normal.dot(v[0])};
      sides[face.first / 4][face.first % 4] = static_cast<std::int32_t>(2 * f);
      if (face.second != TetMesh::kBoundary)
        sides[face.second / 4][face.second % 4] = static_cast<std::int32_t>(2 * f + 1);
    }
  });
}

std::vector<std::int32_t> visibilityOrder(const TetMesh& mesh, const FacePlanes& faces,
                                          const ViewOrigin& view) {
  constexpr std::int32_t kBuckets = 1 << 14;
  const std::size_t tets = mesh.tets().size();
  std::vector<char> onFirst(faces.planes.size());  // the rays come through the face from its first
  parallelRanges(onFirst.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const FacePlane& plane = faces.planes[f];
      onFirst[f] = view.orthographic ? plane.normal.dot(view.forward) > 0
                                     : plane.offset - plane.normal.dot(view.eye) > 0;
    }
  });
  const auto leaves = [&](std::int32_t side) { return (onFirst[side >> 1] != 0) == !(side & 1); };
  std::vector<std::uint8_t> before(tets, 0);
  parallelRanges(tets, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      for (std::int32_t k = 0; k < 4; ++k)
        before[t] += !leaves(faces.sides[t][k]) &&
                     mesh.opposite(4 * static_cast<std::int32_t>(t) + k) != TetMesh::kBoundary;
    }
  });
  const std::vector<std::int32_t> bucket = bucketsOf(mesh, view, kBuckets);
  Buckets ready(tets, kBuckets);
  for (std::size_t t = 0; t < tets; ++t) {
    if (before[t] == 0)
      ready.push(static_cast<std::int32_t>(t), bucket[t]);
  }
  std::vector<char> done(tets, 0);
  std::vector<std::int32_t> order, byDistance;
  order.reserve(tets);
  std::size_t forced = 0;
  while (order.size() < tets) {
    std::int32_t tet = ready.pop();
    if (tet == kNone) {
      // All that are left wait for each other.
      if (byDistance.empty()) {
        for (std::size_t t = 0; t < tets; ++t) {
          if (!done[t])
            byDistance.push_back(static_cast<std::int32_t>(t));
        }
        std::ranges::stable_sort(byDistance, {}, [&](std::int32_t t) { return bucket[t]; });
      }
      while (done[byDistance[forced]]) ++forced;
      tet = byDistance[forced];
    }
    if (done[tet])
      continue;
    done[tet] = 1;
    order.push_back(tet);
    for (std::int32_t k = 0; k < 4; ++k) {
      const std::int32_t across = mesh.opposite(4 * tet + k);
      if (across == TetMesh::kBoundary || !leaves(faces.sides[tet][k]))
        continue;
      if (--before[across / 4] == 0 && !done[across / 4])
        ready.push(across / 4, bucket[across / 4]);
    }
  }
  return order;
}

}  // namespace volute
