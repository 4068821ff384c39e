// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_field.hpp"

#include <algorithm>
#include <mutex>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/fds/fds_march.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr std::size_t kGrain = 64;  // segments worth a task

/// A cell and a segment through it: place on each axis from 0 to 1 is at + slope * s.
struct Local {
  Local(const FdsLattice& lattice, const std::array<int, 3>& cell, const Segment& segment) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto& planes = lattice.planes[axis];
      const double begin = planes[cell[axis]];
      const double perCell = 1 / (planes[cell[axis] + 1] - begin);
      at[axis] = (segment.origin[axis] - begin) * perCell;
      slope[axis] = segment.direction[axis] * perCell;
    }
  }

  /// Trilinear, at the ray parameter s.
  double interpolate(const float* first, const NodePlaces& places, double s) const {
    const double x = at[0] + slope[0] * s;
    const double y = at[1] + slope[1] * s;
    const double z = at[2] + slope[2] * s;
    const auto row = [&](const float* v) { return v[0] + x * (static_cast<double>(v[1]) - v[0]); };
    const auto plane = [&](const float* v) {
      const double lower = row(v);
      return lower + y * (row(v + places.strideY) - lower);
    };
    const double lower = plane(first);
    return lower + z * (plane(first + places.strideZ) - lower);
  }

  /// The exact integral from begin to end: a trilinear function is a cubic along a ray, for which
  /// the Gauss rule with two points is exact.
  double integrate(const float* first, const NodePlaces& places, double begin, double end) const {
    constexpr double kNode = 0.57735026918962576451;  // 1 / sqrt 3
    const double middle = 0.5 * (begin + end);
    const double half = 0.5 * (end - begin);
    return half * (interpolate(first, places, middle - kNode * half) +
                   interpolate(first, places, middle + kNode * half));
  }

  double at[3];
  double slope[3];
};

/// The trilinear weights of a cell's corners along a segment, cubics of s - from.
std::array<Polynomial, 8> cornerCurves(const FdsLattice& lattice, const std::array<int, 3>& cell,
                                       const Segment& segment, double from) {
  const Local local(lattice, cell, segment);
  std::array<Polynomial, 8> curves;
  for (int corner = 0; corner < 8; ++corner) {
    Polynomial& curve = curves[corner];
    curve.c[0] = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double start = local.at[axis] + local.slope[axis] * from;
      curve = ((corner >> axis) & 1) ? curve.timesLine(start, local.slope[axis])
                                     : curve.timesLine(1 - start, -local.slope[axis]);
    }
  }
  return curves;
}

bool anyInfinite(const float* first, const NodePlaces& places) {
  for (int corner = 0; corner < 8; ++corner) {
    if (std::isinf(first[places.offset(corner)]))
      return true;
  }
  return false;
}

}  // namespace

FdsField::FdsField(std::shared_ptr<const FdsGrid> grid,
                   std::vector<std::shared_ptr<const FdsValues>> values,
                   std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells)
    : grid_(std::move(grid)), values_(std::move(values)), cells_(std::move(cells)) {
  VOLUTE_ASSERT(values_.size() == grid_->lattices().size());
  VOLUTE_ASSERT(cells_.size() == grid_->lattices().size());
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (!grid_->holds(i))
      continue;
    VOLUTE_ASSERT(values_[i]->value.size() == grid_->lattices()[i].valueCount());
    VOLUTE_ASSERT(values_[i]->low.size() == values_[i]->high.size());
    VOLUTE_ASSERT(cells_[i]->size() == grid_->lattices()[i].cellCount());
  }
  marches_ = std::make_shared<Marches>();
}

/// The lattices as the march wants them.
struct FdsField::Marches {
  std::once_flag made;
  std::vector<MarchLattice> lattices;
  bool known = true;  ///< there are values in all gas
};

/// One after the other: who waits here in a parallel loop must not take up other work of it, which
/// would wait for itself.
const FdsField::Marches& FdsField::marches() const {
  std::call_once(marches_->made, [&] {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      if (!grid_->holds(i)) {
        marches_->lattices.emplace_back();
        continue;
      }
      const std::vector<FdsCell>& cells = *cells_[i];
      std::vector<std::uint8_t> gas(cells.size());
      for (std::size_t c = 0; c < cells.size(); ++c) {
        gas[c] = cells[c] == FdsCell::kGas;
        marches_->known &= cells[c] != FdsCell::kUnknown;
      }
      marches_->lattices.emplace_back(grid_->lattices()[i], values_[i]->value, gas, values_[i]->low,
                                      values_[i]->high);
    }
  });
  return *marches_;
}

FdsField FdsField::withSource(const Rgb& source) const {
  FdsField other = *this;
  other.source_ = source;
  return other;
}

FdsField FdsField::withValues(std::vector<std::shared_ptr<const FdsValues>> values) const {
  FdsField other(grid_, std::move(values), cells_);
  other.source_ = source_;
  return other;
}

std::optional<FdsField::Place> FdsField::placeOf(const Vec3& point) const {
  Place place{grid_->latticeAt(point)};
  if (place.lattice < 0)
    return std::nullopt;
  const FdsLattice& lattice = grid_->lattices()[place.lattice];
  for (int axis = 0; axis < 3; ++axis)
    place.cell[axis] = cellBetween(lattice.planes[axis], point[axis]);
  return place;
}

FdsCell FdsField::cellIn(const Place& place) const {
  return (*cells_[place.lattice])[grid_->lattices()[place.lattice].cellAt(place.cell)];
}

std::optional<FdsCell> FdsField::cellAt(const Vec3& point) const {
  const auto place = placeOf(point);
  return place ? std::optional(cellIn(*place)) : std::nullopt;
}

double FdsField::extinction(const Vec3& point) const {
  const auto place = placeOf(point);
  return place ? extinction(*place, point) : 0;
}

double FdsField::extinction(const Place& place, const Vec3& point) const {
  if (cellIn(place) != FdsCell::kGas)
    return 0;
  const FdsLattice& lattice = grid_->lattices()[place.lattice];
  const float* values = values_[place.lattice]->value.data();
  if (!lattice.nodal)
    return values[lattice.cellAt(place.cell)];
  const NodePlaces places(lattice);
  return Local(lattice, place.cell, {point, Vec3::UnitX(), 0, 0})
      .interpolate(values + places.first(place.cell), places, 0);
}

double FdsField::depthOf(const Segment& segment) const {
  double sum = 0;
  grid_->traverse(segment, [&](int index, double begin, double end) {
    const FdsLattice& lattice = grid_->lattices()[index];
    const FdsCell* cells = cells_[index]->data();
    const float* values = values_[index]->value.data();
    if (lattice.nodal) {
      const NodePlaces places(lattice);
      traversePlanes(lattice.planes, segment, begin, end,
                     [&](const std::array<int, 3>& cell, double from, double to) {
                       if (cells[lattice.cellAt(cell)] == FdsCell::kGas) {
                         sum += Local(lattice, cell, segment)
                                    .integrate(values + places.first(cell), places, from, to);
                       }
                     });
    } else {
      traversePlanes(lattice.planes, segment, begin, end,
                     [&](const std::array<int, 3>& cell, double from, double to) {
                       const std::size_t place = lattice.cellAt(cell);
                       if (cells[place] == FdsCell::kGas)
                         sum += values[place] * (to - from);
                     });
    }
  });
  return sum;
}

FdsDepth FdsField::bandOf(const Segment& segment) const {
  FdsDepth depth;
  double known = 0;
  grid_->traverse(segment, [&](int index, double begin, double end) {
    const FdsLattice& lattice = grid_->lattices()[index];
    const FdsValues& values = *values_[index];
    const FdsCell* cells = cells_[index]->data();
    const NodePlaces places(lattice);
    const bool banded = !values.low.empty();
    traversePlanes(
        lattice.planes, segment, begin, end,
        [&](const std::array<int, 3>& cell, double from, double to) {
          const std::size_t place = lattice.cellAt(cell);
          if (cells[place] == FdsCell::kUnknown)
            return;
          known += to - from;
          if (cells[place] == FdsCell::kSolid) {
            depth.insideSolids += to - from;
            return;
          }
          if (!lattice.nodal) {
            const double length = to - from;
            depth.value += values.value[place] * length;
            depth.low += (banded ? values.low : values.value)[place] * length;
            depth.high += (banded ? values.high : values.value)[place] * length;
            return;
          }
          const std::size_t first = places.first(cell);
          const Local local(lattice, cell, segment);
          const double value = local.integrate(values.value.data() + first, places, from, to);
          depth.value += value;
          if (!banded) {
            depth.low += value;
            depth.high += value;
            return;
          }
          depth.low += local.integrate(values.low.data() + first, places, from, to);
          const float* high = values.high.data() + first;
          depth.high += anyInfinite(high, places) ? std::numeric_limits<double>::infinity()
                                                  : local.integrate(high, places, from, to);
        });
  });
  depth.uncovered = std::max(0.0, segment.end - segment.begin - known);
  return depth;
}

/// What the march finds on several segments.
struct FdsField::Lines {
  std::vector<double> depth, low, high;
  std::vector<double> inside;  ///< [m] within lattices
  std::vector<double> gas;     ///< [m] of it
};

FdsField::Lines FdsField::march(std::span<const Segment> segments) const {
  struct Part {
    int lattice;
    MarchPart part;
  };

  const std::vector<double> zeros(segments.size(), 0.0);
  Lines lines{zeros, zeros, zeros, zeros, zeros};
  std::vector<Part> parts;
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    grid_->traverse(segments[i], [&](int index, double begin, double end) {
      parts.push_back({index, {i, begin, end}});
      lines.inside[i] += end - begin;
    });
  }
  std::ranges::stable_sort(parts, {}, &Part::lattice);
  const Marches& all = marches();
  std::vector<MarchPart> some;
  std::vector<MarchSum> sums;
  for (std::size_t first = 0; first < parts.size(); first += some.size()) {
    const int lattice = parts[first].lattice;
    some.clear();
    for (std::size_t i = first; i < parts.size() && parts[i].lattice == lattice; ++i)
      some.push_back(parts[i].part);
    sums.resize(some.size());
    marchParts(grid_->lattices()[lattice], all.lattices[static_cast<std::size_t>(lattice)],
               segments, some, sums);
    for (std::size_t i = 0; i < some.size(); ++i) {
      lines.depth[some[i].segment] += sums[i].depth;
      lines.gas[some[i].segment] += sums[i].gas;
      lines.low[some[i].segment] += sums[i].low;
      lines.high[some[i].segment] += sums[i].high;
    }
  }
  return lines;
}

void FdsField::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  parallelRanges(segments.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const Lines lines = march(segments.subspan(begin, end - begin));
    std::ranges::copy(lines.depth, depths.begin() + static_cast<std::ptrdiff_t>(begin));
  });
}

void FdsField::opticalDepthReference(std::span<const Segment> segments,
                                     std::span<double> depths) const {
  for (std::size_t i = 0; i < segments.size(); ++i) depths[i] = depthOf(segments[i]);
}

void FdsField::depths(std::span<const Segment> segments, std::span<FdsDepth> out) const {
  const bool known = marches().known;
  parallelRanges(segments.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    if (!known)
      return depthsReference(segments.subspan(begin, end - begin), out.subspan(begin, end - begin));
    const Lines lines = march(segments.subspan(begin, end - begin));
    for (std::size_t i = begin; i < end; ++i) {
      const double depth = lines.depth[i - begin];
      const double inside = lines.inside[i - begin];
      const double length = segments[i].end - segments[i].begin;
      out[i] = {depth, lines.low[i - begin], lines.high[i - begin], std::max(0.0, length - inside),
                std::max(0.0, inside - lines.gas[i - begin])};
    }
  });
}

void FdsField::depthsReference(std::span<const Segment> segments, std::span<FdsDepth> out) const {
  for (std::size_t i = 0; i < segments.size(); ++i) out[i] = bandOf(segments[i]);
}

Rgb FdsField::emission(const Vec3& point) const {
  return source_ * extinction(point);
}

std::vector<Piece> FdsField::piecesOf(const Segment& segment) const {
  std::vector<Piece> out;
  grid_->traverse(segment, [&](int index, double begin, double end) {
    const FdsLattice& lattice = grid_->lattices()[index];
    const FdsCell* cells = cells_[index]->data();
    const float* values = values_[index]->value.data();
    const NodePlaces places(lattice);
    traversePlanes(lattice.planes, segment, begin, end,
                   [&](const std::array<int, 3>& cell, double from, double to) {
                     const std::size_t place = lattice.cellAt(cell);
                     if (cells[place] != FdsCell::kGas)
                       return;
                     Piece piece{from, to, {}, {}, 0};
                     if (lattice.nodal) {
                       const auto corners = cornerCurves(lattice, cell, segment, from);
                       for (int corner = 0; corner < 8; ++corner)
                         piece.extinction +=
                             corners[corner] * values[places.first(cell) + places.offset(corner)];
                     } else {
                       piece.extinction.c[0] = values[place];
                     }
                     for (int c = 0; c < 3; ++c) piece.emission[c] = piece.extinction * source_[c];
                     out.push_back(piece);
                   });
  });
  return out;
}

void FdsField::pieces(std::span<const Segment> segments,
                      std::span<std::vector<Piece>> pieces) const {
  for (std::size_t i = 0; i < segments.size(); ++i) pieces[i] = piecesOf(segments[i]);
}

void FdsField::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  const Lines lines = march(segments);
  for (std::size_t i = 0; i < segments.size(); ++i)
    out[i] = {source_ * -std::expm1(-lines.depth[i]), std::exp(-lines.depth[i])};
}

}  // namespace volute
