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

}  // namespace

TetLocator::TetLocator(std::shared_ptr<const TetMesh> mesh) : mesh_(std::move(mesh)) {
  box_ = mesh_->bounds();
  const Vec3 size = box_.size().cwiseMax(1e-3 * box_.size().maxCoeff());
  const double cells = std::max(1.0, static_cast<double>(mesh_->tets().size()) / 4);
  const double side = std::cbrt(size.prod() / cells);
  for (int axis = 0; axis < 3; ++axis) {
    count_[axis] = static_cast<int>(std::clamp(std::ceil(size[axis] / side), 1.0, 1024.0));
    cell_[axis] = size[axis] / count_[axis];
  }
  const auto cellsOf = [&](std::size_t t) {
    Box3 bounds;
    for (const std::int32_t v : mesh_->tets()[t]) bounds.extend(mesh_->vertices()[v]);
    return cellsAround(bounds.min, bounds.max, box_, cell_, count_);
  };
  const std::size_t total = static_cast<std::size_t>(count_[0]) * count_[1] * count_[2];
  begin_.assign(total + 1, 0);
  for (std::size_t t = 0; t < mesh_->tets().size(); ++t)
    cellsOf(t).forEach(count_, [&](std::size_t cell) { ++begin_[cell + 1]; });
  for (std::size_t i = 0; i < total; ++i) begin_[i + 1] += begin_[i];
  entries_.resize(static_cast<std::size_t>(begin_.back()));
  std::vector<std::int64_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t t = 0; t < mesh_->tets().size(); ++t) {
    cellsOf(t).forEach(count_, [&](std::size_t cell) {
      entries_[static_cast<std::size_t>(next[cell]++)] = static_cast<std::int32_t>(t);
    });
  }
}

std::int32_t TetLocator::find(const Vec3& point) const {
  if (!((point - box_.min).minCoeff() >= -kTolerance &&
        (box_.max - point).minCoeff() >= -kTolerance))
    return -1;
  std::int32_t found = -1;
  cellsAround(point, point, box_, cell_, count_).forEach(count_, [&](std::size_t cell) {
    for (auto i = begin_[cell]; i < begin_[cell + 1] && found < 0; ++i) {
      const auto shares = mesh_->shares(entries_[i], point);
      if (std::ranges::all_of(shares, [](double share) { return share >= -kTolerance; }))
        found = entries_[i];
    }
  });
  return found;
}

void TetLocator::crossings(const Segment& segment, std::vector<TetCrossing>& out) const {
  out.clear();
  Box3 wide = box_;
  const Vec3 margin = Vec3::Constant(kTolerance * box_.size().maxCoeff());
  wide.min -= margin, wide.max += margin;
  const Interval inside = Interval{segment.begin, segment.end}.intersect(
      wide.intersect(segment.origin, segment.direction));
  if (inside.empty())
    return;
  // Cells layer by layer along the axis with most layers; lists of neighbouring cells repeat tets.
  std::vector<std::int32_t> candidates;
  const Vec3 layersPerMetre = segment.direction.cwiseAbs().cwiseQuotient(cell_);
  int axis = 0;
  const double rate = layersPerMetre.maxCoeff(&axis);
  const int layers = 1 + static_cast<int>(rate * inside.length());
  for (int i = 0; i < layers; ++i) {
    const double from = inside.begin + inside.length() * i / layers;
    const double to = inside.begin + inside.length() * (i + 1) / layers;
    cellsAround(segment.at(from), segment.at(to), box_, cell_, count_)
        .forEach(count_, [&](std::size_t cell) {
          candidates.insert(candidates.end(), entries_.begin() + begin_[cell],
                            entries_.begin() + begin_[cell + 1]);
        });
  }
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
      for (auto i = begin_[cell]; i < begin_[cell + 1] && !isTwice; ++i) {
        isTwice = entries_[i] != own && std::ranges::all_of(mesh_->shares(entries_[i], middle),
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

}  // namespace volute
