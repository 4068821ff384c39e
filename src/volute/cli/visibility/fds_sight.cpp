// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/visibility/fds_sight.hpp"

#include <limits>

namespace volute::cli {
namespace {

/// Lengths below this are rounding [m]: coordinates in .smv files have five decimals.
constexpr double kTolerance = 2e-5;

Segment segmentOf(const SightLine& line) {
  const double length = line.length();
  const Vec3 direction = length > 0 ? Vec3((line.target - line.eye) / length) : Vec3::UnitX();
  return {line.eye, direction, 0, length};
}

}  // namespace

void FdsInstant::look(std::span<const SightLine> lines, std::span<Sight> sights) const {
  std::vector<Segment> segments;
  for (const SightLine& line : lines) segments.push_back(segmentOf(line));
  std::vector<FdsDepth> depths(lines.size());
  field_.depths(segments, depths);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const FdsDepth& depth = depths[i];
    sights[i] = {depth.value, depth.low, depth.high, depth.uncovered <= kTolerance,
                 obstructions_.blocked(segments[i])};
  }
}

Place FdsInstant::placeAt(const Vec3& point) const {
  const int lattice = field_.grid().latticeAt(point);
  if (lattice < 0)
    return Place::kOutside;
  const FdsLattice& cells = field_.grid().lattices()[static_cast<std::size_t>(lattice)];
  std::array<int, 3> cell{};
  for (int axis = 0; axis < 3; ++axis) cell[axis] = cellBetween(cells.planes[axis], point[axis]);
  switch (field_.cells(static_cast<std::size_t>(lattice))[cells.cellAt(cell)]) {
    case FdsCell::kSolid:
      return Place::kSolid;
    case FdsCell::kUnknown:
      return Place::kOutside;
    case FdsCell::kGas:
      break;
  }
  return Place::kGas;
}

void FdsInstant::places(std::span<const Vec3> points, std::span<Place> places) const {
  for (std::size_t i = 0; i < points.size(); ++i) places[i] = placeAt(points[i]);
}

void FdsInstant::extinction(std::span<const Vec3> points, std::span<double> extinction) const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    extinction[i] = placeAt(points[i]) == Place::kGas ? field_.extinction(points[i])
                                                      : std::numeric_limits<double>::quiet_NaN();
  }
}

Result<std::shared_ptr<const SightInstant>> FdsSight::read(std::size_t time) {
  const double when = times()[time];
  VOLUTE_ASSIGN(auto field, case_.field(when));
  return std::make_shared<const FdsInstant>(std::move(field), case_.obstructions(when));
}

}  // namespace volute::cli
