// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_grid.hpp"

#include <numeric>
#include <utility>

#include "volute/fds/fds_part.hpp"

namespace volute {
namespace {

constexpr double kMaxParts = 1 << 24;

/// Moves the outer planes of all lattices onto common ones, and returns these.
std::vector<double> commonPlanes(std::vector<FdsLattice>& lattices, int axis) {
  struct End {
    double place;
    double tolerance;
    double* plane;
  };

  std::vector<End> ends;
  const double separation = meshSeparation(lattices);
  for (FdsLattice& lattice : lattices) {
    const double within = meshSeparation(lattice, axis, separation);
    ends.push_back({lattice.planes[axis].front(), within, &lattice.planes[axis].front()});
    ends.push_back({lattice.planes[axis].back(), within, &lattice.planes[axis].back()});
  }
  std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) { return a.place < b.place; });
  std::vector<double> planes;
  double reach = 0;
  for (const End& end : ends) {
    if (planes.empty() || end.place - planes.back() > std::min(reach, end.tolerance)) {
      planes.push_back(end.place);
      reach = end.tolerance;
    }
    *end.plane = planes.back();
  }
  return planes;
}

double cellVolume(const FdsLattice& lattice) {
  return lattice.bounds().size().prod() / static_cast<double>(lattice.cellCount());
}

/// Whether a lattice has cells of another one of its mesh; their outer planes may have been moved.
bool isPartOf(const FdsLattice& one, const FdsLattice& whole) {
  if (one.mesh != whole.mesh || &one == &whole || one.thinAxis >= 0 || whole.thinAxis >= 0)
    return false;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& own = one.planes[axis];
    const auto& all = whole.planes[axis];
    const double same = meshSeparation(one, axis, kMeshSeparation);
    const auto first = std::ranges::lower_bound(all, own.front() - same);
    if (all.end() - first < static_cast<std::ptrdiff_t>(own.size()) ||
        !std::equal(
            own.begin(), own.end(), first,
            [&](double a, double b) { return std::abs(a - b) <= same; }))
      return false;
  }
  return true;
}

}  // namespace

double meshSeparation(std::span<const FdsLattice> lattices) {
  double separation = kMeshSeparation;
  for (const FdsLattice& lattice : lattices)
    separation = std::min(separation, 0.05 * std::cbrt(cellVolume(lattice)));
  return separation;
}

double meshSeparation(const FdsLattice& lattice, int axis, double separation) {
  const auto& planes = lattice.planes[axis];
  for (std::size_t i = 1; i < planes.size(); ++i)
    separation = std::min(separation, 0.4 * (planes[i] - planes[i - 1]));
  return separation;
}

Result<std::shared_ptr<const FdsGrid>> FdsGrid::create(std::vector<FdsLattice> lattices,
                                                       std::vector<bool> held) {
  auto grid = std::make_shared<FdsGrid>();
  grid->lattices_ = std::move(lattices);
  grid->held_ = std::move(held);
  for (const FdsLattice& lattice : grid->lattices_) {
    if (lattice.nodeCount() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      return fail(ErrorCode::kTooLarge, "mesh {} has {} nodes, more than 2^31", lattice.mesh + 1,
                  lattice.nodeCount());
  }
  double parts = 1;
  for (int axis = 0; axis < 3; ++axis) {
    grid->planes_[axis] = commonPlanes(grid->lattices_, axis);
    parts *= static_cast<double>(grid->planes_[axis].size() - 1);
  }
  if (parts > kMaxParts) {
    return fail(ErrorCode::kTooLarge,
                "the ends of {} meshes cut space into {:.3g} parts, more than {:.3g}: align them",
                grid->lattices_.size(), parts, kMaxParts);
  }
  grid->table_.assign(static_cast<std::size_t>(parts), -1);
  std::vector<int> order(grid->lattices_.size());
  std::iota(order.rbegin(), order.rend(), 0);
  // Layers lie over what stands in for the rest of their mesh. A part of a mesh has the cells of
  // all of it, although their mean may be another.
  std::vector<double> cell;
  for (const FdsLattice& one : grid->lattices_) {
    cell.push_back(cellVolume(one));
    for (const FdsLattice& other : grid->lattices_) {
      if (isPartOf(one, other) || isPartOf(other, one))
        cell.back() = std::min(cell.back(), cellVolume(other));
    }
  }
  const auto rank = [&](int lattice) {
    return std::pair(grid->lattices_[lattice].thinAxis >= 0, -cell[lattice]);
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return rank(a) < rank(b); });
  for (const int index : order) {
    const FdsLattice& lattice = grid->lattices_[index];
    std::array<int, 3> begin;
    std::array<int, 3> end;
    for (int axis = 0; axis < 3; ++axis) {
      const auto& planes = grid->planes_[axis];
      const auto at = [&](double place) {
        return static_cast<int>(std::lower_bound(planes.begin(), planes.end(), place) -
                                planes.begin());
      };
      begin[axis] = at(lattice.planes[axis].front());
      end[axis] = at(lattice.planes[axis].back());
    }
    for (int z = begin[2]; z < end[2]; ++z) {
      for (int y = begin[1]; y < end[1]; ++y) {
        const std::size_t row = (static_cast<std::size_t>(z) * (grid->planes_[1].size() - 1) + y) *
                                (grid->planes_[0].size() - 1);
        std::fill(grid->table_.begin() + static_cast<std::ptrdiff_t>(row + begin[0]),
                  grid->table_.begin() + static_cast<std::ptrdiff_t>(row + end[0]), index);
      }
    }
    grid->bounds_.extend(lattice.bounds());
  }
  for (std::int32_t& part : grid->table_) {
    if (part >= 0 && !grid->holds(static_cast<std::size_t>(part)))
      part = -1;
  }
  return std::shared_ptr<const FdsGrid>(std::move(grid));
}

int FdsGrid::latticeAt(const Vec3& point) const {
  if (!bounds_.contains(point))
    return -1;
  std::array<std::size_t, 3> part;
  for (int axis = 0; axis < 3; ++axis)
    part[axis] = static_cast<std::size_t>(cellBetween(planes_[axis], point[axis]));
  return table_[(part[2] * (planes_[1].size() - 1) + part[1]) * (planes_[0].size() - 1) + part[0]];
}

}  // namespace volute
