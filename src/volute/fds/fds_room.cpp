// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_room.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "volute/fds/obstructions.hpp"

namespace volute {
namespace {

constexpr int kColumns = 200;           ///< along the longer side
constexpr double kStep = 0.05;          ///< [m] that a floor may be uneven by
constexpr double kHeadroom = 1.9;       ///< [m]
constexpr double kMinHeight = 0.6;      ///< of the meshes', where they are low
constexpr double kMinPlan = 0.02;       ///< of the meshes' plan
constexpr std::size_t kMaxFloors = 16;  ///< levels that are looked at, the largest first
constexpr double kOpen = std::numeric_limits<double>::infinity();

/// A rectangle of columns, ends not included.
struct Plot {
  int x = 0, y = 0, endX = 0, endY = 0;

  int area() const { return (endX - x) * (endY - y); }
};

/// Columns over the meshes' plan.
class Plan {
 public:
  explicit Plan(const Box3& bounds)
      : origin_(bounds.min), cell_(bounds.size().head<2>().maxCoeff() / kColumns) {
    nx_ = std::max(1, static_cast<int>(std::ceil(bounds.size().x() / cell_ - 1e-9)));
    ny_ = std::max(1, static_cast<int>(std::ceil(bounds.size().y() / cell_ - 1e-9)));
  }

  std::size_t size() const { return static_cast<std::size_t>(nx_) * ny_; }

  /// Calls visit(column) for all columns that a box has a part in; a thin one has one's width.
  template <class Visit>
  void over(const Box3& box, Visit&& visit) const {
    const auto [x, endX] = range(box.min.x() - origin_.x(), box.max.x() - origin_.x(), nx_);
    const auto [y, endY] = range(box.min.y() - origin_.y(), box.max.y() - origin_.y(), ny_);
    for (int j = y; j < endY; ++j) {
      for (int i = x; i < endX; ++i) visit(static_cast<std::size_t>(j) * nx_ + i);
    }
  }

  /// The largest rectangle of columns that are free: for each row the largest one that ends there,
  /// by the heights of free columns above it.
  Plot largest(const std::vector<char>& free) const {
    Plot best;
    std::vector<int> depth(static_cast<std::size_t>(nx_) + 1, 0);
    for (int y = 0; y < ny_; ++y) {
      for (int x = 0; x < nx_; ++x)
        depth[x] = free[static_cast<std::size_t>(y) * nx_ + x] ? depth[x] + 1 : 0;
      std::vector<std::pair<int, int>> rising;  // where a depth begins, and it
      for (int x = 0; x <= nx_; ++x) {
        int begin = x;
        while (!rising.empty() && rising.back().second >= depth[x]) {
          const auto [from, deep] = rising.back();
          rising.pop_back();
          begin = from;
          const Plot plot{from, y + 1 - deep, x, y + 1};
          if (plot.area() > best.area())
            best = plot;
        }
        rising.emplace_back(begin, depth[x]);
      }
    }
    return best;
  }

  template <class Visit>
  void within(const Plot& plot, Visit&& visit) const {
    for (int y = plot.y; y < plot.endY; ++y) {
      for (int x = plot.x; x < plot.endX; ++x) visit(static_cast<std::size_t>(y) * nx_ + x);
    }
  }

  double area(const Plot& plot) const { return plot.area() * cell_ * cell_; }

  Box3 boxOf(const Plot& plot, double bottom, double top) const {
    return {Vec3(origin_.x() + plot.x * cell_, origin_.y() + plot.y * cell_, bottom),
            Vec3(origin_.x() + plot.endX * cell_, origin_.y() + plot.endY * cell_, top)};
  }

 private:
  std::pair<int, int> range(double from, double to, int count) const {
    constexpr double kRounding = 1e-6;
    const int first =
        static_cast<int>(std::floor(std::clamp(from / cell_ + kRounding, 0.0, count - 1.0)));
    const int end =
        static_cast<int>(std::ceil(std::clamp(to / cell_ - kRounding, 0.0, double(count))));
    return {first, std::max(end, first + 1)};
  }

  Vec3 origin_;
  double cell_;
  int nx_ = 0, ny_ = 0;
};

/// Levels [m] that may be floors: the lower ends of the meshes, and of the obstructions' upper ends
/// those with the largest area.
std::vector<double> floorsOf(const SmvIndex& index, std::span<const FdsBox> boxes) {
  std::map<long, double> areas;  // by the level in steps
  for (const FdsBox& box : boxes) {
    const Vec3 size = box.bounds.size();
    areas[std::lround(box.bounds.max.z() / kStep)] += size.x() * size.y();
  }
  std::vector<std::pair<double, long>> largest;
  for (const auto& [level, area] : areas) largest.emplace_back(area, level);
  std::ranges::sort(largest, std::greater<>());
  largest.resize(std::min(largest.size(), kMaxFloors));
  std::vector<double> floors;
  for (const auto& [area, level] : largest) floors.push_back(kStep * static_cast<double>(level));
  for (const FdsMesh& mesh : index.meshes) {
    const double bottom = mesh.planes[2].front();
    const auto near = [&](double floor) { return std::abs(floor - bottom) < kStep; };
    if (std::ranges::none_of(floors, near))
      floors.push_back(bottom);
  }
  return floors;
}

/// Obstructions, and the tops of meshes that are closed.
std::vector<FdsBox> coversOf(const SmvIndex& index, double time) {
  const FdsObstructions obstructions(index, time);
  std::vector<FdsBox> boxes(obstructions.boxes().begin(), obstructions.boxes().end());
  for (const FdsMesh& mesh : index.meshes) {
    for (const FdsVent& vent : mesh.vents) {
      if (vent.exterior && vent.nodes.begin[2] == mesh.cells(2) && isShown(vent.events, time))
        boxes.push_back({boxOf(mesh, vent.nodes), {}, vent.drawn});
    }
  }
  return boxes;
}

}  // namespace

std::optional<Box3> largestRoom(const SmvIndex& index, double time) {
  const std::vector<FdsBox> boxes = coversOf(index, time);
  if (boxes.empty())
    return std::nullopt;
  Box3 bounds;
  for (const FdsMesh& mesh : index.meshes) bounds.extend(mesh.bounds());
  const Plan plan(bounds);
  const double headroom = std::min(kHeadroom, kMinHeight * bounds.size().z());
  std::optional<Box3> room;
  double largest = kMinPlan * bounds.size().x() * bounds.size().y();
  for (const double floor : floorsOf(index, boxes)) {
    // Over each column the lowest of what stands on the floor or is above it.
    std::vector<double> ceiling(plan.size(), kOpen);
    std::vector<char> ground(plan.size(), 0), free(plan.size(), 0);
    for (const FdsMesh& mesh : index.meshes) {
      if (std::abs(mesh.planes[2].front() - floor) < kStep)
        plan.over(mesh.bounds(), [&](std::size_t column) { ground[column] = 1; });
    }
    for (const FdsBox& box : boxes) {
      const double top = box.bounds.max.z(), bottom = box.bounds.min.z();
      if (std::abs(top - floor) < kStep)
        plan.over(box.bounds, [&](std::size_t column) { ground[column] = 1; });
      else if (top > floor)
        plan.over(box.bounds,
                  [&](std::size_t column) { ceiling[column] = std::min(ceiling[column], bottom); });
    }
    for (std::size_t i = 0; i < free.size(); ++i)
      free[i] = ground[i] && ceiling[i] < kOpen && ceiling[i] - floor >= headroom;
    const Plot plot = plan.largest(free);
    if (plan.area(plot) <= largest)
      continue;
    largest = plan.area(plot);
    double lowest = kOpen;
    plan.within(plot, [&](std::size_t column) { lowest = std::min(lowest, ceiling[column]); });
    room = plan.boxOf(plot, floor, lowest);
  }
  return room;
}

}  // namespace volute
