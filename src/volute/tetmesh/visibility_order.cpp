// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/visibility_order.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr std::size_t kOrderGrain = 4096;
constexpr std::int32_t kNoTet = -1;
constexpr std::int32_t kBuckets = 1 << 14;

/// Tets that may be next, by bucket.
class Buckets {
 public:
  Buckets(std::size_t tets, std::int32_t buckets)
      : head_(static_cast<std::size_t>(buckets), kNoTet), next_(tets) {}

  void push(std::int32_t tet, std::int32_t bucket) {
    next_[tet] = std::exchange(head_[std::max(bucket, first_)], tet);
  }

  /// One of the first bucket that has any, or kNoTet.
  std::int32_t pop() {
    for (; first_ < static_cast<std::int32_t>(head_.size()); ++first_) {
      const std::int32_t tet = head_[first_];
      if (tet == kNoTet)
        continue;
      head_[first_] = next_[tet];
      return tet;
    }
    return kNoTet;
  }

 private:
  std::vector<std::int32_t> head_, next_;
  std::int32_t first_ = 0;
};

/// What is known of a tet before and while it is put in order.
struct Place {
  std::uint16_t bucket = 0;  // by the distance of its centre
  std::uint8_t after = 0;    // bit k: the tet across from vertex k is behind this one
  std::uint8_t before = 0;   // the same of those that are in front of it
};

/// The distances that a mesh may have from an eye, or along a direction.
struct Range {
  double least = std::numeric_limits<double>::infinity(), most = -least;

  Range(const Box3& box, const ViewOrigin& view) {
    if (!view.orthographic)
      least = (view.eye.cwiseMax(box.min).cwiseMin(box.max) - view.eye).norm();
    for (int i = 0; i < 8; ++i) {
      const Vec3 from = box.corner(i) - view.eye;
      const double distance = view.orthographic ? from.dot(view.forward) : from.norm();
      least = std::min(least, distance), most = std::max(most, distance);
    }
  }
};

class Sorter {
 public:
  Sorter(const TetMesh& mesh, const FacePlanes& faces, const ViewOrigin& view)
      : mesh_(mesh),
        places_(mesh.tets().size()),
        ahead_(places_.size()),
        behind_(places_.size()),
        taken_(places_.size(), 0) {
    lookAtFaces(faces, view);
    setBuckets(view);
  }

  std::vector<std::int32_t> sort() {
    const std::int32_t middle = middleBucket();
    std::vector<std::int32_t> front, back;
    parallelFor(2, [&](std::size_t half) {
      if (half == 0)
        front = sortHalf<true>(middle);
      else
        back = sortHalf<false>(middle);
    });
    front.reserve(places_.size());
    if (front.size() + back.size() < places_.size())
      sortRest(front);
    front.insert(front.end(), back.rbegin(), back.rend());
    return front;
  }

 private:
  /// Which neighbours are behind each tet: on the other side of a face from the eye.
  void lookAtFaces(const FacePlanes& faces, const ViewOrigin& view) {
    std::vector<char> onFirst(faces.planes.size());  // rays come through the face from its first
    parallelRanges(onFirst.size(), kOrderGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        const FacePlane& plane = faces.planes[f];
        onFirst[f] = view.orthographic ? plane.normal.dot(view.forward) > 0
                                       : plane.offset - plane.normal.dot(view.eye) > 0;
      }
    });
    parallelRanges(places_.size(), kOrderGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        int after = 0, inside = 0;
        for (int k = 0; k < 4; ++k) {
          const std::int32_t side = faces.sides[t][k];
          after |= ((onFirst[side >> 1] != 0) == !(side & 1)) << k;
          inside |= (mesh_.opposite(4 * static_cast<std::int32_t>(t) + k) != TetMesh::kBoundary)
                    << k;
        }
        places_[t].after = static_cast<std::uint8_t>(after & inside);
        places_[t].before = static_cast<std::uint8_t>(~after & inside);
        ahead_[t] = count(places_[t].before);
        behind_[t] = count(places_[t].after);
      }
    });
  }

  void setBuckets(const ViewOrigin& view) {
    const Range range(mesh_.bounds(), view);
    const double per = (kBuckets - 1) / std::max(range.most - range.least, 1e-300);
    parallelRanges(places_.size(), kOrderGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        Vec3 from = -view.eye;
        for (const std::int32_t v : mesh_.tets()[t]) from += 0.25 * mesh_.vertices()[v];
        const double distance = view.orthographic ? from.dot(view.forward) : from.norm();
        places_[t].bucket = static_cast<std::uint16_t>(
            std::clamp((distance - range.least) * per, 0.0, kBuckets - 1.0));
      }
    });
  }

  /// Before which half of the tets are.
  std::int32_t middleBucket() const {
    std::vector<std::size_t> counts(kBuckets, 0);
    for (const Place& place : places_) ++counts[place.bucket];
    std::size_t sum = 0;
    std::int32_t bucket = 0;
    while (2 * sum < places_.size()) sum += counts[static_cast<std::size_t>(bucket++)];
    return bucket;
  }

  /// Those before the middle from the front on as far as none of them waits for one beyond it; or
  /// those beyond it from the back on, likewise.
  template <bool kFront>
  std::vector<std::int32_t> sortHalf(std::int32_t middle) {
    std::vector<std::uint8_t>& waits = kFront ? ahead_ : behind_;
    const auto bucketOf = [&](std::int32_t tet) {
      return kFront ? places_[tet].bucket : kBuckets - 1 - places_[tet].bucket;
    };
    const std::int32_t end = kFront ? middle : kBuckets - middle;
    Buckets ready(places_.size(), end);
    for (std::size_t t = 0; t < places_.size(); ++t) {
      const auto tet = static_cast<std::int32_t>(t);
      if (waits[t] == 0 && bucketOf(tet) < end)
        ready.push(tet, bucketOf(tet));
    }
    std::vector<std::int32_t> order;
    order.reserve(places_.size() / 2);
    for (std::int32_t tet = ready.pop(); tet != kNoTet; tet = ready.pop()) {
      order.push_back(tet);
      taken_[tet] = 1;
      const int next = kFront ? places_[tet].after : places_[tet].before;
      for (std::int32_t k = 0; k < 4; ++k) {
        if (!(next >> k & 1))
          continue;
        const std::int32_t across = mesh_.opposite(4 * tet + k) / 4;
        if (--waits[across] == 0 && bucketOf(across) < end)
          ready.push(across, bucketOf(across));
      }
    }
    return order;
  }

  /// What neither half took, the nearest first, those that wait for each other in a circle too.
  void sortRest(std::vector<std::int32_t>& order) {
    using Entry = std::pair<std::int32_t, std::int32_t>;  // bucket, tet
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> ready;
    std::vector<Entry> rest;
    for (std::size_t t = 0; t < places_.size(); ++t) {
      if (taken_[t])
        continue;
      rest.emplace_back(places_[t].bucket, static_cast<std::int32_t>(t));
      if (ahead_[t] == 0)
        ready.push(rest.back());
    }
    std::ranges::sort(rest);
    for (std::size_t forced = 0; forced < rest.size();) {
      std::int32_t tet = rest[forced].second;
      if (!ready.empty()) {
        tet = ready.top().second;
        ready.pop();
      } else {
        ++forced;
      }
      if (taken_[tet])
        continue;
      taken_[tet] = 1;
      order.push_back(tet);
      for (std::int32_t k = 0; k < 4; ++k) {
        if (!(places_[tet].after >> k & 1))
          continue;
        const std::int32_t across = mesh_.opposite(4 * tet + k) / 4;
        if (--ahead_[across] == 0 && !taken_[across])
          ready.emplace(places_[across].bucket, across);
      }
    }
  }

  static std::uint8_t count(int bits) {
    return static_cast<std::uint8_t>((bits & 1) + (bits >> 1 & 1) + (bits >> 2 & 1) +
                                     (bits >> 3 & 1));
  }

  const TetMesh& mesh_;
  std::vector<Place> places_;
  std::vector<std::uint8_t> ahead_, behind_;  // neighbours that are not yet in order
  std::vector<char> taken_;
};

}  // namespace

std::vector<std::int32_t> visibilityOrder(const TetMesh& mesh, const FacePlanes& faces,
                                          const ViewOrigin& view) {
  return Sorter(mesh, faces, view).sort();
}

}  // namespace volute
