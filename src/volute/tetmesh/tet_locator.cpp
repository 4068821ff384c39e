// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_locator.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

/// Shares of a point may be this far below 0, of 1: what lies in a face by more than rounding
/// belongs to both sides, and what overlaps is cut off afterwards.
constexpr double kTolerance = 1e-12;

constexpr std::size_t kLocatorGrain = 4096;

struct CellRange3 {
  std::array<int, 3> begin, end;  // inclusive

  template <class Visit>
  void forEach(const std::array<int, 3>& count, Visit&& visit) const {
    for (int z = begin[2]; z <= end[2]; ++z) {
      for (int y = begin[1]; y <= end[1]; ++y) {
        for (int x = begin[0]; x <= end[0]; ++x)
          visit((static_cast<std::size_t>(z) * count[1] + y) * count[0] + x);
      }
    }
  }
};

CellRange3 cellsAround(const Vec3& from, const Vec3& to, const Box3& box, const Vec3& cell,
                       const std::array<int, 3>& count) {
  CellRange3 range{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = [&](double x) {
      const double place = std::floor((x - box.min[axis]) / cell[axis]);
      return static_cast<int>(std::clamp(place, 0.0, count[axis] - 1.0));
    };
    const double margin = 1e-9 * cell[axis];
    range.begin[axis] = at(std::min(from[axis], to[axis]) - margin);
    range.end[axis] = at(std::max(from[axis], to[axis]) + margin);
  }
  return range;
}

/// Where along start + u * direction, 0 <= u <= length, all four shares are >= 0; empty when
/// nowhere.
Interval insideTet(const TetMesh& mesh, std::int32_t tet, const Vec3& start, const Vec3& direction,
                   double length) {
  const auto slopes = mesh.slopes(tet);
  const auto shares = mesh.shares(tet, start);
  Interval range{0, length};
  for (int k = 0; k < 4; ++k) {
    const double at = shares[k] + kTolerance;
    const double slope = slopes[k].dot(direction);
    if (slope > 0)
      range.begin = std::max(range.begin, -at / slope);
    else if (slope < 0)
      range.end = std::min(range.end, -at / slope);
    else if (at < 0)
      return {};
  }
  return range;
}

Vec3 normalOf(const ThinWall& wall) {
  return (wall[1] - wall[0]).cross(wall[2] - wall[0]);
}

/// Where a line meets a triangle, its rim included.
std::optional<double> meet(const Segment& line, const ThinWall& wall) {
  constexpr double kRim = 1e-9;  // of the shares: triangles side by side leave nothing between
  const Vec3 normal = normalOf(wall);
  const double towards = normal.dot(line.direction), area = normal.norm();
  if (!(std::abs(towards) > kTolerance * area))
    return std::nullopt;
  const double at = normal.dot(wall[0] - line.origin) / towards;
  const Vec3 point = line.at(at);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 edge = wall[(k + 1) % 3] - wall[k];
    if (edge.cross(point - wall[k]).dot(normal) < -kRim * area * area)
      return std::nullopt;
  }
  return at;
}

}  // namespace

template <class BoundsOf>
TetLocator::Lists TetLocator::listsOf(std::size_t things, const BoundsOf& boundsOf) const {
  const auto cellsOf = [&](std::size_t i) {
    const Box3 bounds = boundsOf(i);
    return cellsAround(bounds.min, bounds.max, box_, cell_, count_);
  };
  Lists lists;
  const std::size_t total = static_cast<std::size_t>(count_[0]) * count_[1] * count_[2];
  lists.begin.assign(total + 1, 0);
  for (std::size_t i = 0; i < things; ++i)
    cellsOf(i).forEach(count_, [&](std::size_t cell) { ++lists.begin[cell + 1]; });
  for (std::size_t i = 0; i < total; ++i) lists.begin[i + 1] += lists.begin[i];
  lists.entries.resize(static_cast<std::size_t>(lists.begin.back()));
  std::vector<std::int64_t> next(lists.begin.begin(), lists.begin.end() - 1);
  for (std::size_t i = 0; i < things; ++i) {
    cellsOf(i).forEach(count_, [&](std::size_t cell) {
      lists.entries[static_cast<std::size_t>(next[cell]++)] = static_cast<std::int32_t>(i);
    });
  }
  return lists;
}

TetLocator::TetLocator(std::shared_ptr<const TetMesh> mesh,
                       std::shared_ptr<const std::vector<ThinWall>> walls)
    : mesh_(std::move(mesh)), walls_(std::move(walls)) {
  box_ = mesh_->bounds();
  const Vec3 size = box_.size().cwiseMax(1e-3 * box_.size().maxCoeff());
  const double cells = std::max(1.0, static_cast<double>(mesh_->tets().size()) / 4);
  const double side = std::cbrt(size.prod() / cells);
  for (int axis = 0; axis < 3; ++axis) {
    count_[axis] = static_cast<int>(std::clamp(std::ceil(size[axis] / side), 1.0, 1024.0));
    cell_[axis] = size[axis] / count_[axis];
  }
  tets_ = listsOf(mesh_->tets().size(), [&](std::size_t t) {
    Box3 bounds;
    for (const std::int32_t v : mesh_->tets()[t]) bounds.extend(mesh_->vertices()[v]);
    return bounds;
  });
  if (walls_ && walls_->empty())
    walls_ = nullptr;
  if (walls_) {
    wallLists_ = listsOf(walls_->size(), [&](std::size_t w) {
      Box3 bounds;
      for (const Vec3& corner : (*walls_)[w]) bounds.extend(corner);
      bounds.min -= Vec3::Constant(kOnWall), bounds.max += Vec3::Constant(kOnWall);
      return bounds;
    });
  }
}

std::int32_t TetLocator::find(const Vec3& point) const {
  if (!((point - box_.min).minCoeff() >= -kTolerance &&
        (box_.max - point).minCoeff() >= -kTolerance))
    return -1;
  std::int32_t found = -1;
  cellsAround(point, point, box_, cell_, count_).forEach(count_, [&](std::size_t cell) {
    for (auto i = tets_.begin[cell]; i < tets_.begin[cell + 1] && found < 0; ++i) {
      const auto shares = mesh_->shares(tets_.entries[i], point);
      if (std::ranges::all_of(shares, [](double share) { return share >= -kTolerance; }))
        found = tets_.entries[i];
    }
  });
  return found;
}

Interval TetLocator::within(const Segment& segment) const {
  Box3 wide = box_;
  const Vec3 margin = Vec3::Constant(kTolerance * box_.size().maxCoeff());
  wide.min -= margin, wide.max += margin;
  return Interval{segment.begin, segment.end}.intersect(
      wide.intersect(segment.origin, segment.direction));
}

/// Along the axis with most layers of cells.
template <class Visit>
void TetLocator::forCellsAlong(const Segment& segment, const Interval& inside,
                               const Visit& visit) const {
  const Vec3 layersPerMetre = segment.direction.cwiseAbs().cwiseQuotient(cell_);
  const int layers = 1 + static_cast<int>(layersPerMetre.maxCoeff() * inside.length());
  for (int i = 0; i < layers; ++i) {
    const double from = inside.begin + inside.length() * i / layers;
    const double to = inside.begin + inside.length() * (i + 1) / layers;
    cellsAround(segment.at(from), segment.at(to), box_, cell_, count_).forEach(count_, visit);
  }
}

std::optional<double> TetLocator::wallOn(const Segment& segment) const {
  if (!walls_)
    return std::nullopt;
  const Interval inside = within(segment);
  if (inside.empty())
    return std::nullopt;
  std::optional<double> first;
  forCellsAlong(segment, inside, [&](std::size_t cell) {
    for (auto i = wallLists_.begin[cell]; i < wallLists_.begin[cell + 1]; ++i) {
      const auto at = meet(segment, (*walls_)[static_cast<std::size_t>(wallLists_.entries[i])]);
      if (at && *at > segment.begin + kOnWall && *at < segment.end - kOnWall &&
          (!first || *at < *first))
        first = at;
    }
  });
  return first;
}

bool TetLocator::isOnWall(const Vec3& point) const {
  bool found = false;
  if (!walls_)
    return found;
  cellsAround(point, point, box_, cell_, count_).forEach(count_, [&](std::size_t cell) {
    for (auto i = wallLists_.begin[cell]; i < wallLists_.begin[cell + 1] && !found; ++i) {
      const ThinWall& wall = (*walls_)[static_cast<std::size_t>(wallLists_.entries[i])];
      const Vec3 normal = normalOf(wall).normalized();
      const auto at = meet({point - normal, normal, 0, 2}, wall);
      found = at && std::abs(*at - 1) <= kOnWall;
    }
  });
  return found;
}

void TetLocator::crossings(const Segment& segment, std::vector<TetCrossing>& out) const {
  out.clear();
  const Interval inside = within(segment);
  if (inside.empty())
    return;
  // Lists of neighbouring cells repeat tets.
  std::vector<std::int32_t> candidates;
  forCellsAlong(segment, inside, [&](std::size_t cell) {
    candidates.insert(candidates.end(), tets_.entries.begin() + tets_.begin[cell],
                      tets_.entries.begin() + tets_.begin[cell + 1]);
  });
  std::ranges::sort(candidates);
  const auto repeated = std::ranges::unique(candidates);
  candidates.erase(repeated.begin(), repeated.end());
  // From where the segment enters the bounds: its origin may be so far away that the shares there
  // mean nothing.
  const Vec3 start = segment.at(inside.begin);
  for (const std::int32_t tet : candidates) {
    const Interval range = insideTet(*mesh_, tet, start, segment.direction, inside.length());
    if (!range.empty())
      out.push_back({tet, inside.begin + range.begin, inside.begin + range.end});
  }
  std::ranges::sort(out, [](const TetCrossing& a, const TetCrossing& b) {
    return a.begin != b.begin ? a.begin < b.begin : a.tet < b.tet;
  });
  double end = inside.begin;
  std::size_t kept = 0;
  for (TetCrossing crossing : out) {
    crossing.begin = std::max(crossing.begin, end);
    if (crossing.begin < crossing.end) {
      end = crossing.end;
      out[kept++] = crossing;
    }
  }
  out.resize(kept);
}

TetOverlap TetLocator::overlap() const {
  constexpr std::size_t kTried = std::size_t{1} << 15;
  constexpr double kInside = 1e-3;  // of the shares
  const auto tets = mesh_->tets();
  const auto points = mesh_->vertices();
  const std::size_t step = tets.size() / kTried + 1;
  TetOverlap found;
  double all = 0, twice = 0;
  for (std::size_t t = 0; t < tets.size(); t += step) {
    const auto own = static_cast<std::int32_t>(t);
    const auto [a, b, c, d] = tets[t];
    const Vec3 middle = (points[a] + points[b] + points[c] + points[d]) / 4;
    const double volume = mesh_->volume(own);
    all += volume;
    bool isTwice = false;
    cellsAround(middle, middle, box_, cell_, count_).forEach(count_, [&](std::size_t cell) {
      for (auto i = tets_.begin[cell]; i < tets_.begin[cell + 1] && !isTwice; ++i) {
        const std::int32_t other = tets_.entries[i];
        isTwice = other != own && std::ranges::all_of(mesh_->shares(other, middle),
                                                      [](double s) { return s > kInside; });
      }
    });
    if (isTwice && !(twice > 0))
      found.first = middle;
    twice += isTwice ? volume : 0;
  }
  found.share = all > 0 ? twice / all : 0;
  return found;
}

std::optional<Vec3> TetLocator::openContact() const {
  constexpr std::size_t kTried = std::size_t{1} << 15;
  const auto boundary = mesh_->boundary();
  const auto points = mesh_->vertices();
  const std::size_t step = boundary.size() / kTried + 1;
  for (std::size_t i = 0; i < boundary.size(); i += step) {
    const TetFace& face = mesh_->faces()[static_cast<std::size_t>(boundary[i])];
    const ThinWall corners{points[face.vertices[0]], points[face.vertices[1]],
                           points[face.vertices[2]]};
    const Vec3 middle = (corners[0] + corners[1] + corners[2]) / 3;
    const Vec3 across = points[mesh_->tets()[face.first / 4][face.first % 4]] - middle;
    Vec3 outwards = normalOf(corners).normalized();
    if (outwards.dot(across) > 0)
      outwards = -outwards;
    if (find(middle + kOnWall * outwards) >= 0 && !isOnWall(middle))
      return middle;
  }
  return std::nullopt;
}

}  // namespace volute
