// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_sight.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <set>

#include "volute/base/parallel.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/fds/fds_input.hpp"
#include "volute/fds/fds_march.hpp"
#include "volute/fds/solids.hpp"
#include "volute/media/fds/fds_conditions.hpp"
#include "volute/media/fds/fds_devices.hpp"
#include "volute/media/fds/touching_cells.hpp"
#include "volute/media/occluded_sight.hpp"

namespace volute {
namespace {

/// Lengths below this are rounding [m]: coordinates in .smv files have five decimals.
constexpr double kTolerance = 2e-5;

Segment segmentOf(const SightLine& line) {
  const double length = line.length();
  const Vec3 direction = length > 0 ? Vec3((line.target - line.eye) / length) : Vec3::UnitX();
  return {line.eye, direction, 0, length};
}

/// The weights of a cell's corners in the integral of a trilinear function over a part of a line: a
/// cubic, for which the Gauss rule with two points is exact.
std::array<double, 8> cornerWeights(const FdsLattice& lattice, const std::array<int, 3>& cell,
                                    const Segment& segment, double begin, double end) {
  constexpr double kNode = 0.57735026918962576451;  // 1 / sqrt 3
  std::array<double, 8> weights{};
  const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
  for (const double s : {middle - kNode * half, middle + kNode * half}) {
    const Vec3 point = segment.at(s);
    double share[3];
    for (int axis = 0; axis < 3; ++axis) {
      const auto& planes = lattice.planes[axis];
      const double from = planes[cell[axis]];
      share[axis] = std::clamp((point[axis] - from) / (planes[cell[axis] + 1] - from), 0.0, 1.0);
    }
    for (int corner = 0; corner < 8; ++corner) {
      double weight = half;
      for (int axis = 0; axis < 3; ++axis)
        weight *= (corner >> axis & 1) != 0 ? share[axis] : 1 - share[axis];
      weights[corner] += weight;
    }
  }
  return weights;
}

std::size_t cornerPlace(const FdsLattice& lattice, const std::array<int, 3>& cell, int corner) {
  const std::size_t nx = lattice.planes[0].size(), ny = lattice.planes[1].size();
  const auto at = [&](int axis) {
    return static_cast<std::size_t>(cell[axis] + (corner >> axis & 1));
  };
  return (at(2) * ny + at(1)) * nx + at(0);
}

/// What a lattice's values say of a point in it; NaN where one that counts is not there.
SmokeBand bandAt(const FdsLattice& lattice, const FdsValues& values, const Vec3& point) {
  constexpr double kNothing = 1e-6;  // of a cell: the point is on a plane
  std::array<int, 3> cell{};
  std::array<double, 3> share{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto& planes = lattice.planes[axis];
    cell[axis] = cellBetween(planes, point[axis]);
    const double from = planes[cell[axis]];
    share[axis] = std::clamp((point[axis] - from) / (planes[cell[axis] + 1] - from), 0.0, 1.0);
  }
  std::array<double, 3> sum{};
  const auto add = [&](std::size_t place, double weight) {
    const float value = values.value[place];
    sum[0] += weight * value;
    sum[1] += weight * (values.low.empty() ? value : values.low[place]);
    sum[2] += weight * (values.high.empty() ? value : values.high[place]);
  };
  for (int corner = 0; corner < (lattice.nodal ? 8 : 1); ++corner) {
    double weight = 1;
    for (int axis = 0; lattice.nodal && axis < 3; ++axis)
      weight *= (corner >> axis & 1) != 0 ? share[axis] : 1 - share[axis];
    if (weight > kNothing)
      add(lattice.nodal ? cornerPlace(lattice, cell, corner) : lattice.cellAt(cell), weight);
  }
  return {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
}

}  // namespace

/// The least and the largest extinction in blocks of 2 x 2 x 2 cells of each lattice; solid cells
/// count as 0, unknown ones as anything. Lines go through an eighth of the cells, with one value to
/// fetch where nodes have eight; blocks of 4 leave more lines undecided, which costs more.
struct FdsSightSnapshot::Blocks {
  static constexpr int kEdge = 2;

  struct OfLattice {
    FdsLattice lattice;  ///< of blocks: every other plane
    std::vector<float> low, high;
    MarchLattice march;
  };

  std::once_flag made;
  std::vector<OfLattice> lattices;

  static OfLattice of(const FdsLattice& lattice, const FdsValues& values,
                      const std::vector<FdsCell>& cells);
};

FdsSightSnapshot::Blocks::OfLattice FdsSightSnapshot::Blocks::of(
    const FdsLattice& lattice, const FdsValues& values, const std::vector<FdsCell>& cells) {
  OfLattice blocks;
  std::array<int, 3> count{}, size{};  // of blocks, of values
  for (int axis = 0; axis < 3; ++axis) {
    const auto& planes = lattice.planes[axis];
    for (std::size_t i = 0; i + 1 < planes.size(); i += kEdge)
      blocks.lattice.planes[axis].push_back(planes[i]);
    blocks.lattice.planes[axis].push_back(planes.back());
    count[axis] = blocks.lattice.cells(axis);
    size[axis] = lattice.cells(axis) + (lattice.nodal ? 1 : 0);
  }
  const std::size_t all = static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) *
                          static_cast<std::size_t>(count[2]);
  constexpr float kMax = std::numeric_limits<float>::infinity();
  blocks.low.assign(all, kMax);
  blocks.high.assign(all, 0);
  const std::vector<float>& low = values.low.empty() ? values.value : values.low;
  const std::vector<float>& high = values.high.empty() ? values.value : values.high;
  parallelFor(static_cast<std::size_t>(count[2]), [&](std::size_t slab) {
    std::array<int, 3> block{0, 0, static_cast<int>(slab)};
    for (block[1] = 0; block[1] < count[1]; ++block[1]) {
      for (block[0] = 0; block[0] < count[0]; ++block[0]) {
        float least = kMax, most = 0;
        const auto forEach = [&](const std::array<int, 3>& sizes, int more, auto&& visit) {
          const auto end = [&](int axis) {
            return std::min(sizes[axis], (block[axis] + 1) * kEdge + more);
          };
          for (int z = block[2] * kEdge; z < end(2); ++z) {
            for (int y = block[1] * kEdge; y < end(1); ++y) {
              const std::size_t row =
                  (static_cast<std::size_t>(z) * static_cast<std::size_t>(sizes[1]) +
                   static_cast<std::size_t>(y)) *
                  static_cast<std::size_t>(sizes[0]);
              for (int x = block[0] * kEdge; x < end(0); ++x)
                visit(row + static_cast<std::size_t>(x));
            }
          }
        };
        forEach(size, lattice.nodal ? 1 : 0, [&](std::size_t i) {
          least = low[i] < least ? low[i] : least;  // values that are not known are NaN
          most = high[i] > most ? high[i] : most;
        });
        forEach({lattice.cells(0), lattice.cells(1), lattice.cells(2)}, 0, [&](std::size_t i) {
          if (cells[i] != FdsCell::kGas)
            least = 0;
          if (cells[i] == FdsCell::kUnknown)
            most = kMax;
        });
        blocks.low[blocks.lattice.cellAt(block)] = std::min(least, most);
        blocks.high[blocks.lattice.cellAt(block)] = most;
      }
    }
  });
  blocks.lattice.nodal = false;
  blocks.march = MarchLattice(blocks.lattice, blocks.low, blocks.high);
  return blocks;
}

const FdsSightSnapshot::Blocks& FdsSightSnapshot::blocks() const {
  std::call_once(blocks_->made, [&] {
    for (std::size_t i = 0; i < field_.grid().lattices().size(); ++i) {
      blocks_->lattices.push_back(
          Blocks::of(field_.grid().lattices()[i], field_.values(i), field_.cells(i)));
    }
  });
  return *blocks_;
}

void FdsSightSnapshot::bounds(std::span<const SightLine> lines, std::span<double> low,
                              std::span<double> high) const {
  constexpr double kRounding = 1e-5;  // of the sums that these are compared with
  const Blocks& all = blocks();
  std::vector<Segment> segments;
  for (const SightLine& line : lines) segments.push_back(segmentOf(line));
  std::vector<std::vector<MarchPart>> parts(all.lattices.size());
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    field_.grid().traverse(segments[i], [&](int index, double begin, double end) {
      parts[static_cast<std::size_t>(index)].push_back({i, begin, end});
    });
  }
  std::vector<double> known(lines.size(), 0.0);
  std::ranges::fill(low, 0.0);
  std::ranges::fill(high, 0.0);
  std::vector<MarchSum> sums;
  for (std::size_t n = 0; n < parts.size(); ++n) {
    sums.resize(parts[n].size());
    marchParts(all.lattices[n].lattice, all.lattices[n].march, segments, parts[n], sums);
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const std::size_t i = parts[n][k].segment;
      low[i] += sums[k].low;
      high[i] += sums[k].high;
      known[i] += sums[k].gas;
    }
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    low[i] = std::max(0.0, low[i] * (1 - kRounding) - kRounding);
    high[i] = segments[i].end - known[i] <= kTolerance ? high[i] * (1 + kRounding) + kRounding
                                                       : std::numeric_limits<double>::infinity();
  }
}

void FdsSightSnapshot::blocked(std::span<const SightLine> lines,
                               std::span<unsigned char> out) const {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Segment segment = segmentOf(lines[i]);
    out[i] = obstructions_.blocked(segment) || passesBorder(segment) ? 1 : 0;
  }
}

/// Whether a line leaves all meshes, or comes back, through FDS's own walls around them.
bool FdsSightSnapshot::passesBorder(const Segment& segment) const {
  if (meshes_.size() < 2)
    return false;
  const auto isWall = [&](double at) {
    const Vec3 point = segment.at(at);
    const auto has = [&](PlanShape::Kind kind) {
      return std::ranges::any_of(borders_, [&](const auto& border) {
        return border.second == kind &&
               (border.first.min.array() <= point.array() + kMeshSeparation).all() &&
               (point.array() <= border.first.max.array() + kMeshSeparation).all();
      });
    };
    return has(PlanShape::Kind::kBorder) && !has(PlanShape::Kind::kOpening);
  };
  std::vector<Interval> inside;
  for (const Box3& mesh : meshes_) {
    const Interval own =
        mesh.intersect(segment.origin, segment.direction).intersect({segment.begin, segment.end});
    if (!own.empty())
      inside.push_back(own);
  }
  std::ranges::sort(inside, {}, &Interval::begin);
  for (std::size_t i = 1; i < inside.size(); ++i) {
    const double reach = inside[i - 1].end;
    if (inside[i].begin - reach > kMeshSeparation && (isWall(reach) || isWall(inside[i].begin)))
      return true;
    inside[i].end = std::max(inside[i].end, reach);
  }
  return false;
}

FdsSightSnapshot::FdsSightSnapshot(FdsField field, FdsObstructions obstructions,
                                   std::uint64_t geometry)
    : field_(std::move(field)),
      obstructions_(std::move(obstructions)),
      geometry_(geometry),
      blocks_(std::make_shared<Blocks>()) {
  std::size_t count = 0;
  for (const FdsLattice& lattice : field_.grid().lattices()) {
    firsts_.push_back(static_cast<std::uint32_t>(count));
    count += lattice.valueCount();
  }
  if (count > std::numeric_limits<std::uint32_t>::max())
    geometry_ = 0;  // weights cannot number so many values
  if (geometry_ != 0 && firsts_.size() > 1)
    joinValues();
}

void FdsSightSnapshot::joinValues() {
  bool banded = false;
  for (std::size_t i = 0; i < firsts_.size(); ++i) banded |= !field_.values(i).low.empty();
  for (std::size_t i = 0; i < firsts_.size(); ++i) {
    const FdsValues& values = field_.values(i);
    const auto append = [](std::vector<float>& to, const std::vector<float>& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(value_, values.value);
    if (banded) {
      append(low_, values.low.empty() ? values.value : values.low);
      append(high_, values.high.empty() ? values.value : values.high);
    }
  }
}

SightData FdsSightSnapshot::data() const {
  if (firsts_.size() > 1)
    return {value_, low_, high_};
  const FdsValues& values = field_.values(0);
  return {values.value, values.low, values.high};
}

void FdsSightSnapshot::weigh(const SightLine& line, std::vector<SightWeight>& weights,
                             Sight& sight) const {
  const Segment segment = segmentOf(line);
  const std::size_t first = weights.size();
  double known = 0;
  field_.grid().traverse(segment, [&](int index, double begin, double end) {
    const auto number = static_cast<std::size_t>(index);
    const FdsLattice& lattice = field_.grid().lattices()[number];
    const std::vector<FdsCell>& cells = field_.cells(number);
    traversePlanes(lattice.planes, segment, begin, end,
                   [&](const std::array<int, 3>& cell, double from, double to) {
                     const std::size_t place = lattice.cellAt(cell);
                     known += cells[place] == FdsCell::kUnknown ? 0 : to - from;
                     if (cells[place] != FdsCell::kGas)
                       return true;
                     if (!lattice.nodal) {
                       weights.push_back({static_cast<std::uint32_t>(firsts_[number] + place),
                                          static_cast<float>(to - from)});
                       return true;
                     }
                     const auto corners = cornerWeights(lattice, cell, segment, from, to);
                     for (int corner = 0; corner < 8; ++corner) {
                       addWeight(weights, first,
                                 static_cast<std::uint32_t>(firsts_[number] +
                                                            cornerPlace(lattice, cell, corner)),
                                 corners[corner]);
                     }
                     return true;
                   });
  });
  sight = {};
  sight.covered = segment.end - known <= kTolerance;
  sight.blocked = obstructions_.blocked(segment) || (!sight.covered && passesBorder(segment));
}

void FdsSightSnapshot::look(std::span<const SightLine> lines, std::span<Sight> sights) const {
  std::vector<Segment> segments;
  for (const SightLine& line : lines) segments.push_back(segmentOf(line));
  std::vector<FdsDepth> depths(lines.size());
  field_.depths(segments, depths);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const FdsDepth& depth = depths[i];
    const bool covered = depth.uncovered <= kTolerance;
    sights[i] = {depth.value, depth.low, depth.high, covered,
                 obstructions_.blocked(segments[i]) || (!covered && passesBorder(segments[i]))};
  }
}

void FdsSightSnapshot::addBorders(const SmvIndex& index, double time) {
  for (const FdsMesh& mesh : index.meshes) {
    meshes_.push_back(mesh.bounds());
    for (const FdsObstruction& one : mesh.obstructions) {
      if (!one.shownAt(time))
        borders_.emplace_back(boxOf(mesh, one.nodes), PlanShape::Kind::kDoor);
    }
    for (const FdsVent& vent : mesh.vents) {
      const bool opens = vent.open && isShown(vent.events, time);
      if (opens || vent.exterior)
        borders_.emplace_back(boxOf(mesh, vent.nodes),
                              opens ? PlanShape::Kind::kOpening : PlanShape::Kind::kBorder);
    }
  }
}

void FdsSightSnapshot::extinctionBounds(std::span<const Vec3> points, std::span<double> low,
                                        std::span<double> high) const {
  extinction(points, low);
  std::ranges::copy(low, high.begin());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int lattice = std::isnan(low[i]) ? -1 : field_.grid().latticeAt(points[i]);
    if (lattice < 0 || field_.values(static_cast<std::size_t>(lattice)).low.empty())
      continue;
    const auto l = static_cast<std::size_t>(lattice);
    const SmokeBand band = bandAt(field_.grid().lattices()[l], field_.values(l), points[i]);
    low[i] = std::min<double>(low[i], band.low);
    high[i] = std::max<double>(high[i], band.high);
  }
}

namespace {

/// Boxes by where they are in the plan, so that few are looked at for a point.
class FlatBins {
 public:
  explicit FlatBins(std::span<const Box3> boxes) : bins_(kSide * kSide) {
    for (const Box3& box : boxes) bounds_.extend(box);
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      for (std::size_t y = along(1, boxes[i].min); y <= along(1, boxes[i].max); ++y) {
        for (std::size_t x = along(0, boxes[i].min); x <= along(0, boxes[i].max); ++x)
          bins_[y * kSide + x].push_back(i);
      }
    }
  }

  std::span<const std::uint32_t> at(const Vec3& point) const {
    return bins_[along(1, point) * kSide + along(0, point)];
  }

 private:
  static constexpr std::size_t kSide = 64;

  std::size_t along(int axis, const Vec3& point) const {
    const double share = (point[axis] - bounds_.min[axis]) / bounds_.size()[axis];
    // Not a number where all boxes are in one plane, or there is none.
    return !(share > 0) ? 0 : share < 1 ? static_cast<std::size_t>(share * kSide) : kSide - 1;
  }

  Box3 bounds_;
  std::vector<std::vector<std::uint32_t>> bins_;
};

}  // namespace

/// From obstructions and meshes, because the field itself may be a layer of smoke.
void FdsSightSnapshot::floors(std::span<const Vec3> points, double drop,
                              std::span<double> z) const {
  constexpr double kThin = 1e-3;  // [m]
  const auto above = [](const Box3& box, const Vec3& point) {
    return box.min.x() <= point.x() && point.x() < box.max.x() && box.min.y() <= point.y() &&
           point.y() < box.max.y();
  };
  std::vector<Box3> surfaces, openings;  // tops that carry people; borders that do not
  for (const FdsBox& box : obstructions_.boxes()) surfaces.push_back(box.bounds);
  for (const auto& [box, kind] : borders_) {
    if (kind == PlanShape::Kind::kOpening && box.size().z() < kThin)
      openings.push_back(box);
  }
  const FlatBins surfaceBins(surfaces), openingBins(openings);
  const auto isOpen = [&](const Vec3& point) {
    const auto within = [&](const Box3& mesh) {
      return above(mesh, point) && mesh.min.z() < point.z() - kThin && point.z() <= mesh.max.z();
    };
    return std::ranges::any_of(meshes_, within) ||
           std::ranges::any_of(openingBins.at(point), [&](std::uint32_t i) {
             return above(openings[i], point) && std::abs(openings[i].min.z() - point.z()) < kThin;
           });
  };
  parallelRanges(points.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3& point = points[i];
      z[i] = std::numeric_limits<double>::quiet_NaN();
      const auto offer = [&](double top) {
        if (top <= point.z() && top >= point.z() - drop && !(top <= z[i]))
          z[i] = top;
      };
      for (const std::uint32_t box : surfaceBins.at(point)) {
        if (above(surfaces[box], point))
          offer(surfaces[box].max.z());
      }
      for (const Box3& mesh : meshes_) {
        if (above(mesh, point) && !isOpen({point.x(), point.y(), mesh.min.z()}))
          offer(mesh.min.z());
      }
    }
  });
}

std::vector<PlanShape> FdsSightSnapshot::shapes(double z) const {
  std::vector<PlanShape> shapes;
  const auto add = [&](const Box3& box, PlanShape::Kind kind) {
    if (box.min.z() < box.max.z() && box.min.z() <= z && z < box.max.z())
      shapes.push_back({kind, box.min.head<2>(), box.max.head<2>()});
  };
  for (const FdsBox& box : obstructions_.boxes()) add(box.bounds, PlanShape::Kind::kSolid);
  for (const auto& [box, kind] : borders_) add(box, kind);
  return shapes;
}

namespace {

/// Gas is gas, whether its smoke is known or not.
Place placeOf(std::optional<FdsCell> cell) {
  if (!cell)
    return Place::kOutside;
  return *cell == FdsCell::kSolid ? Place::kSolid : Place::kGas;
}

}  // namespace

void FdsSightSnapshot::places(std::span<const Vec3> points, std::span<Place> places) const {
  for (std::size_t i = 0; i < points.size(); ++i) places[i] = placeOf(field_.cellAt(points[i]));
}

void FdsSightSnapshot::extinction(std::span<const Vec3> points,
                                  std::span<double> extinction) const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    extinction[i] = field_.cellAt(points[i]) == FdsCell::kGas
                        ? field_.extinction(points[i])
                        : std::numeric_limits<double>::quiet_NaN();
  }
}

namespace {

/// What the gas in the cells says of a point that may be on their planes: all cells that touch it
/// count, and the value is their mean. NaN where there is none.
SmokeBand bandAround(const FdsLattice& lattice, const FdsValues& values,
                     const std::vector<FdsCell>& cells, const Vec3& point) {
  constexpr float kNever = std::numeric_limits<float>::infinity();
  SmokeBand band{0, kNever, -kNever};
  int count = 0;
  forTouchingCells(lattice, point, [&](const std::array<int, 3>& cell) {
    const std::size_t at = lattice.cellAt(cell);
    const float value = values.value[at];
    if (cells[at] != FdsCell::kGas || std::isnan(value))
      return;
    band.value += value;
    band.low = std::min(band.low, values.low.empty() ? value : values.low[at]);
    band.high = std::max(band.high, values.high.empty() ? value : values.high[at]);
    ++count;
  });
  band.value =
      count > 0 ? band.value / static_cast<float>(count) : std::numeric_limits<float>::quiet_NaN();
  return band;
}

/// What another field of the same mesh says of a point, from the values that it has there.
std::optional<SmokeBand> bandAt(const FdsField& field, int mesh, const Vec3& point) {
  for (std::size_t l = 0; l < field.grid().lattices().size(); ++l) {
    const FdsLattice& lattice = field.grid().lattices()[l];
    if (lattice.mesh != mesh || !field.grid().holds(l) || !lattice.bounds().contains(point))
      continue;
    const SmokeBand band = lattice.nodal
                               ? bandAt(lattice, field.values(l), point)
                               : bandAround(lattice, field.values(l), field.cells(l), point);
    if (!std::isnan(band.value))
      return band;
  }
  return std::nullopt;
}

/// Where a value of a lattice lies.
Vec3 placeOfValue(const FdsLattice& lattice, std::size_t value) {
  Vec3 point;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& planes = lattice.planes[axis];
    const std::size_t count = planes.size() - (lattice.nodal ? 0 : 1);
    const std::size_t i = value % count;
    value /= count;
    point[axis] = lattice.thinAxis == axis ? lattice.place
                  : lattice.nodal          ? planes[i]
                                           : 0.5 * (planes[i] + planes[i + 1]);
  }
  return point;
}

/// The meshes of which a grid has some part.
std::set<int> meshesIn(const FdsGrid& grid) {
  std::set<int> meshes;
  for (const FdsLattice& lattice : grid.lattices()) meshes.insert(lattice.mesh);
  return meshes;
}

std::set<int> partlyKnown(const FdsCase& one) {
  return meshesInPart(one.index(), one.source());
}

/// What is in one set and not in another.
std::set<int> without(std::set<int> meshes, const std::set<int>& those) {
  for (const int mesh : those) meshes.erase(mesh);
  return meshes;
}

/// Whether a case stores a time before or after those of others.
bool isBeyond(std::span<const double> times, std::span<const double> known) {
  return (times.front() < known.front() && !storedPlace(known, times.front())) ||
         (times.back() > known.back() && !storedPlace(known, times.back()));
}

/// Whether a case stores times closer together around a time that both know.
bool isFinerAt(double time, const FdsCase& one, const FdsCase& than) {
  return kFinerTimes * spacingAt(one.times(), time) <= spacingAt(than.times(), time);
}

/// At some time within the other's.
bool isFiner(const FdsCase& one, const FdsCase& than) {
  return std::ranges::any_of(one.times(), [&](double time) {
    return storedPlace(than.times(), time) && isFinerAt(time, one, than);
  });
}

/// A field of a source beside one whose times are closer together: at a time that it does not store
/// its bounds are those of the stored times around, between which it may have been either.
Result<FdsField> fieldBeside(const FdsCase& finer, FdsCase& fds, double time) {
  VOLUTE_ASSIGN(const FdsField field, fds.field(time));
  if (isStored(fds.times(), time) || !isFinerAt(time, finer, fds))
    return field;
  const auto place = storedPlace(fds.times(), time);
  std::vector<std::shared_ptr<const FdsValues>> values(field.allValues().begin(),
                                                       field.allValues().end());
  for (const std::size_t end : {place->first, place->second}) {
    VOLUTE_ASSIGN(const FdsField stored, fds.field(fds.times()[end]));
    parallelFor(values.size(), [&](std::size_t l) {
      const FdsValues& ends = stored.values(l);
      auto wide = std::make_shared<FdsValues>(*values[l]);
      if (wide->low.empty())
        wide->low = wide->high = wide->value;
      for (std::size_t i = 0; i < ends.value.size(); ++i) {
        const bool banded = !ends.low.empty();
        wide->low[i] = std::fmin(wide->low[i], banded ? ends.low[i] : ends.value[i]);
        wide->high[i] = std::fmax(wide->high[i], banded ? ends.high[i] : ends.value[i]);
      }
      values[l] = std::move(wide);
    });
  }
  return field.withValues(std::move(values));
}

/// Whether a case can take the place of another one in its meshes without leaving a part of them
/// out. A volume goes on to serve beside the layers of another source.
bool replaces(const FdsCase& one, const FdsCase& other) {
  if (other.source().volume)
    return true;
  std::map<int, std::vector<Box3>> its;  // of each mesh
  for (const FdsLattice& lattice : one.grid().lattices())
    its[lattice.mesh].push_back(lattice.bounds());
  return std::ranges::all_of(other.grid().lattices(), [&](const FdsLattice& lattice) {
    const auto found = its.find(lattice.mesh);
    return found == its.end() || std::ranges::any_of(found->second, [&](const Box3& box) {
             return box.contains(lattice.bounds().min) && box.contains(lattice.bounds().max);
           });
  });
}

}  // namespace

std::vector<FdsCase> fillingSources(const FdsCase& first, const FdsOptions& options,
                                    const FdsCase* earlier, std::vector<Remark>* unread) {
  std::vector<FdsCase> others;
  const bool cut = first.source().quantity == SmokeQuantity::kVisibility;
  std::vector<double> known(first.times().begin(), first.times().end());
  std::set<int> meshes = meshesIn(first.grid()), partly = partlyKnown(first);
  for (const FdsSource& source : first.sources()) {
    if (source.name == first.source().name || source.species != first.source().species)
      continue;
    FdsOptions other = options;
    other.source = source.name;
    auto opened = FdsCase::open(first.index(), other, earlier);
    if (!opened) {
      if (unread != nullptr)
        unread->push_back({RemarkCode::kDamaged,
                           fmt::format("{}: {} cannot serve where {} does not reach",
                                       opened.error().message, source.name, first.source().name)});
      continue;
    }
    const bool beyond = isBeyond(opened->times(), known);
    const bool precise = cut && source.quantity != SmokeQuantity::kVisibility;
    const bool finer = isFiner(*opened, first) && replaces(*opened, first);
    const std::size_t before = meshes.size();
    const std::set<int> its = meshesIn(opened->grid());
    const bool completes = without(partly, its).size() < partly.size();
    if (opened->source().volume)
      partly = without(partly, without(its, partlyKnown(*opened)));
    meshes.insert(its.begin(), its.end());
    if (!beyond && !precise && !finer && !completes && meshes.size() == before && first.isWhole()) {
      // Perhaps because it is cut.
      for (const Remark& remark : opened->leftOut()) {
        if (unread != nullptr &&
            std::ranges::find(first.remarks(), remark) == first.remarks().end())
          unread->push_back(remark);
      }
      continue;
    }
    known.insert(known.end(), opened->times().begin(), opened->times().end());
    std::ranges::sort(known);
    others.push_back(std::move(*opened));
  }
  return others;
}

FdsSight::FdsSight(FdsCase fds, std::string name, std::uint64_t maxMemory,
                   std::vector<FdsCase> others, TriangleScene walls, std::vector<Remark> notes)
    : case_(std::move(fds)),
      others_(std::move(others)),
      walls_(std::move(walls)),
      notes_(std::move(notes)),
      name_(std::move(name)),
      maxMemory_(maxMemory) {
  // Of each the times at which it serves.
  for (std::size_t i = 0; i <= others_.size(); ++i) {
    FdsCase& one = i == 0 ? case_ : others_[i - 1];
    std::ranges::copy_if(one.times(), std::back_inserter(times_),
                         [&](double time) { return caseAt(time).first == &one; });
  }
  std::ranges::sort(times_);
  events_ = obstructionEvents(case_.index());
  bounds_ = case_.bounds();
  std::set<int> known = meshesIn(case_.grid()), partly = partlyKnown(case_);
  for (const FdsCase& other : others_) {
    for (const FdsLattice& lattice : other.grid().lattices()) {
      if (!known.contains(lattice.mesh) || partly.contains(lattice.mesh))
        bounds_.extend(lattice.bounds());
    }
    known.merge(meshesIn(other.grid()));
  }
  for (std::size_t mesh = 0; mesh < case_.index().meshes.size(); ++mesh) {
    if (!known.contains(static_cast<int>(mesh))) {
      bounds_.extend(case_.index().meshes[mesh].bounds());
      nowhereKnown_.push_back(static_cast<int>(mesh));
    }
  }
}

std::string FdsSight::description() const {
  std::string text =
      fmt::format("{}: {} ({})", name_, case_.source().name, case_.source().description);
  for (const FdsCase& other : others_)
    text += fmt::format(", else {} ({})", other.source().name, other.source().description);
  return text;
}

std::vector<Remark> FdsSight::remarks() const {
  std::vector<Remark> remarks(case_.remarks().begin(), case_.remarks().end());
  remarks.insert(remarks.end(), notes_.begin(), notes_.end());
  for (const FdsCase& other : others_) {
    for (const Remark& remark : other.remarks()) {
      if (remark.sentence != other.uncovered() &&  // it need not
          std::ranges::find(remarks, remark) == remarks.end())
        remarks.push_back(remark);
    }
    if (isBeyond(other.times(), case_.times())) {
      remarks.push_back(fmt::format("{}: {} is stored from {} to {} s; {} serves at other times",
                                    name_, case_.source().name, plainNumber(case_.times().front()),
                                    plainNumber(case_.times().back()), other.source().name));
    }
    if (!case_.isWhole()) {
      remarks.push_back(
          fmt::format("{}: where files of {} have no frames, {} serves, as far as it "
                      "has any",
                      name_, case_.source().name, other.source().name));
    }
    if (isFiner(other, case_) && replaces(other, case_)) {
      remarks.push_back(fmt::format(
          "{}: {} is stored at {} times only; between them {}, stored at {}, serves {}, and "
          "elsewhere "
          "the smoke is known to lie between two stored times' values",
          name_, case_.source().name, case_.times().size(), other.source().name,
          other.times().size(), other.source().volume ? "in its meshes" : "in its layers"));
    }
  }
  std::set<int> known = meshesIn(case_.grid());
  const std::set<int> partly = partlyKnown(case_);
  for (const FdsCase& other : others_) {
    std::set<int> its = meshesIn(other.grid());
    if (without(partly, its).size() < partly.size()) {
      remarks.push_back(
          fmt::format("{}: {} serves where the 3D slices of {} leave a part of their "
                      "mesh out",
                      name_, other.source().name, case_.source().name));
    }
    if (std::ranges::includes(known, its))
      continue;
    remarks.push_back(fmt::format("{}: {} serves in meshes of which {} has no file", name_,
                                  other.source().name, case_.source().name));
    known.merge(its);
  }
  if (!nowhereKnown_.empty()) {
    remarks.push_back(fmt::format(
        "{}: no smoke is stored for {} of {} meshes (the first is {}): nothing is known there",
        name_, nowhereKnown_.size(), case_.index().meshes.size(), nowhereKnown_.front() + 1));
  }
  if (case_.source().quantity == SmokeQuantity::kVisibility && !others_.empty()) {
    remarks.push_back(fmt::format("{}: where {} is cut, the extinction is that of {}", name_,
                                  case_.source().name, others_.front().source().name));
  }
  const auto isMeanOfVisibilities = [](const FdsCase& one) {
    return one.source().quantity == SmokeQuantity::kVisibility &&
           one.grid().lattices().front().nodal;
  };
  const bool byMeans = isMeanOfVisibilities(case_);
  if (const auto other = std::ranges::find_if(others_, isMeanOfVisibilities);
      byMeans || other != others_.end()) {
    remarks.push_back(fmt::format(
        "{}: {} holds means of the visibility in the cells around each node, of which the mean "
        "extinction does not follow: where nothing else is stored, it is bounded by how much the "
        "nodes around differ, and times are intervals. Slices of EXTINCTION COEFFICIENT, or .s3d, "
        "end that",
        name_, (byMeans ? case_ : *other).source().name));
  }
  return remarks;
}

std::vector<Remark> FdsSight::remarksOn(double largest) const {
  constexpr double kSoot = 8700;  // [m2/kg]
  constexpr double kAir = 1.2;    // [kg/m3]
  if (!(largest > kSoot * kAir))
    return {};
  return {{RemarkCode::kDoubtful,
           fmt::format("{}: extinction up to {:.3g}/m, as of {:.2g} kg/m3 of soot, more than air "
                       "weighs: a file is damaged, or holds another quantity than it says",
                       name_, largest, largest / kSoot)}};
}

/// The first that stores a time; between the times of all that know it, the one whose times are
/// closest together of those that can take the first's place. And the time to read of it: between
/// what two of them store, the next one that is stored.
std::pair<FdsCase*, double> FdsSight::caseAt(double time) {
  FdsCase* best = nullptr;
  std::pair<FdsCase*, double> next{&case_, std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i <= others_.size(); ++i) {
    FdsCase& one = i == 0 ? case_ : others_[i - 1];
    if (storedPlace(one.times(), time)) {
      if (best == nullptr || (!isStored(best->times(), time) && isFinerAt(time, one, *best) &&
                              replaces(one, *best) && replaces(one, case_)))
        best = &one;
      continue;
    }
    const auto after = std::ranges::upper_bound(one.times(), time);
    if (after != one.times().end() && *after < next.second)
      next = {&one, *after};
  }
  if (best != nullptr)
    return {best, time};
  return std::isinf(next.second) ? std::pair(&case_, time) : next;
}

/// What visibilities leave open, by what the others know at that time; and where they are cut, by
/// those between whose times it lies.
Result<FdsField> FdsSight::refined(FdsField field, const FdsCase& of, double time) {
  std::vector<std::shared_ptr<const FdsValues>> values(field.allValues().begin(),
                                                       field.allValues().end());
  for (std::size_t n = 0; n <= others_.size(); ++n) {
    FdsCase& other = n == 0 ? case_ : others_[n - 1];
    if (other.source().quantity == SmokeQuantity::kVisibility || !storedPlace(other.times(), time))
      continue;
    VOLUTE_ASSIGN(const FdsField more, fieldBeside(of, other, time));
    const bool between = !isStored(other.times(), time) && isFinerAt(time, of, other);
    parallelFor(values.size(), [&](std::size_t l) {
      const FdsLattice& lattice = field.grid().lattices()[l];
      if (!field.grid().holds(l) || values[l]->low.empty())
        return;
      auto better = std::make_shared<FdsValues>(*values[l]);
      for (std::size_t i = 0; i < better->value.size(); ++i) {
        const float low = better->low[i], high = better->high[i];
        const bool cut = low <= 0;
        if (!(low < high * 0.999F) || (between && !cut))
          continue;
        const auto band = bandAt(more, lattice.mesh, placeOfValue(lattice, i));
        if (!band || band->high - band->low >= high - low)
          continue;
        better->low[i] = cut ? std::clamp(band->low, low, high) : band->low;
        better->high[i] = cut ? std::clamp(band->high, low, high) : band->high;
        better->value[i] = cut ? std::clamp(band->value, low, high) : band->value;
      }
      values[l] = std::move(better);
    });
  }
  return field.withValues(std::move(values));
}

/// How many of the changes of obstructions are before a time, or at it.
std::size_t FdsSight::changesUntil(double time) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(events_, time) - events_.begin());
}

/// What stands in a mesh of which no source has smoke.
const FdsSight::Unknown& FdsSight::unknownMesh(int mesh, double time) {
  Unknown& made = unknown_[mesh];
  if (made.cells && made.changes == changesUntil(time))
    return made;
  const FdsMesh& own = case_.index().meshes[static_cast<std::size_t>(mesh)];
  const auto solid = solidCells(own, time);
  auto cells = std::make_shared<std::vector<FdsCell>>(solid.size(), FdsCell::kUnknown);
  for (std::size_t i = 0; i < solid.size(); ++i) {
    if (solid[i] != 0)
      (*cells)[i] = FdsCell::kSolid;
  }
  made.changes = changesUntil(time);
  made.cells = std::move(cells);
  if (!made.values) {
    made.values = std::make_shared<const FdsValues>(
        FdsValues{std::vector(solid.size(), std::numeric_limits<float>::quiet_NaN()), {}, {}});
  }
  return made;
}

/// In meshes of which a source has no file, or none that reaches until that time, what the others
/// know there; so, too, above and below the layers of one that stands in for a while.
Result<FdsField> FdsSight::completed(FdsField field, const FdsCase& of, double time) {
  const auto& meshes = case_.index().meshes;
  const bool inLayers = case_.source().volume && !of.source().volume;
  const auto meshesOf = [&](const FdsCase& one) {
    if (inLayers && !one.source().volume)
      return std::set<int>();
    std::set<int> all = meshesIn(one.grid());
    for (std::size_t l = 0; !one.isWhole() && l < one.grid().lattices().size(); ++l) {
      if (!one.knows(l, time))
        all.erase(one.grid().lattices()[l].mesh);
    }
    return all;
  };
  // Sources of a part of a mesh leave the rest of it to others, to several layers as well.
  std::set<int> partly = partlyKnown(of), known = without(meshesOf(of), partly);
  if (known.size() == meshes.size())
    return field;
  std::vector<FdsLattice> lattices;
  std::vector<bool> held;
  std::vector<std::shared_ptr<const FdsValues>> values;
  std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells;
  std::vector<std::pair<const FdsGrid*, std::size_t>> from;
  const auto take = [&](const FdsField& one, const FdsCase& its, const std::set<int>& without) {
    for (std::size_t l = 0; l < one.grid().lattices().size(); ++l) {
      if (without.contains(one.grid().lattices()[l].mesh) || !its.knows(l, time))
        continue;
      lattices.push_back(one.grid().lattices()[l]);
      held.push_back(one.grid().holds(l));
      values.push_back(one.allValues()[l]);
      cells.push_back(one.allCells()[l]);
      from.emplace_back(&one.grid(), l);
    }
  };
  take(field, of, {});
  for (std::size_t i = 0; i <= others_.size(); ++i) {
    FdsCase& other = i == 0 ? case_ : others_[i - 1];
    std::set<int> its = meshesOf(other);
    if (&other == &of || std::ranges::includes(known, its) || !storedPlace(other.times(), time))
      continue;
    VOLUTE_ASSIGN(const FdsField more, fieldBeside(of, other, time));
    take(more, other, known);
    its = without(its, partlyKnown(other));
    known.merge(other.source().volume ? its : without(its, partly));
  }
  for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh) {
    const auto number = static_cast<int>(mesh);
    if (known.contains(number) || partly.contains(number))
      continue;
    const Unknown& unknown = unknownMesh(number, time);
    lattices.push_back({number, meshes[mesh].planes});
    held.push_back(true);
    values.push_back(unknown.values);
    cells.push_back(unknown.cells);
    from.emplace_back(nullptr, mesh);
  }
  if (lattices.size() == field.grid().lattices().size())
    return field;
  auto whole = std::ranges::find(wholes_, from, &Whole::from);
  if (whole == wholes_.end()) {
    VOLUTE_ASSIGN(auto grid, FdsGrid::create(std::move(lattices), std::move(held)));
    whole = wholes_.insert(wholes_.end(), {std::move(from), std::move(grid)});
  }
  return FdsField(whole->grid, std::move(values), std::move(cells));
}

/// Whether cells and obstructions are those of the last time.
bool FdsSight::sameGeometry(const FdsField& field, double time) const {
  if (!last_ || &field.grid() != &last_->grid())
    return false;
  if (changesUntil(time) > changesUntil(lastTime_))
    return false;
  for (std::size_t i = 0; i < field.grid().lattices().size(); ++i) {
    if (&field.cells(i) != &last_->cells(i) && field.cells(i) != last_->cells(i))
      return false;
  }
  return true;
}

std::string FdsSight::tallerSource() const {
  FdsOptions filling{.volume = true, .partly = true};
  filling.maxMemory = maxMemory_;
  const auto other = FdsCase::open(case_.index(), filling);
  const bool further =
      other && other->source().species == case_.source().species &&
      (!case_.source().volume || other->bounds().size().z() > ownBounds().size().z());
  return further ? other->source().name : "";
}

bool FdsSight::reaches(double z) const {
  if (case_.source().volume)
    return SightField::reaches(z);
  std::map<int, std::vector<Box3>> known;  // of each mesh
  const auto add = [&](const FdsCase& one, const std::set<int>& without) {
    for (const FdsLattice& lattice : one.grid().lattices()) {
      if (!without.contains(lattice.mesh))
        known[lattice.mesh].push_back(lattice.bounds());
    }
  };
  add(case_, {});
  for (const FdsCase& other : others_) add(other, meshesIn(case_.grid()));
  for (const auto& [number, boxes] : known) {
    const Box3 mesh = case_.index().meshes[static_cast<std::size_t>(number)].bounds();
    if (z < mesh.min.z() || z > mesh.max.z())
      continue;
    constexpr int kPlaces = 32;  // on an axis
    for (int i = 0; i < kPlaces * kPlaces; ++i) {
      const Vec3 share((i % kPlaces + 0.5) / kPlaces, (i / kPlaces + 0.5) / kPlaces, 0);
      Vec3 place = mesh.min + share.cwiseProduct(mesh.size());
      place.z() = z;
      if (std::ranges::none_of(boxes, [&](const Box3& box) { return box.contains(place); }))
        return false;
    }
  }
  return true;  // of all that there is
}

std::vector<double> FdsSight::changes() const {
  std::vector<double> changes;
  for (const double event : events_) {
    if (event > times().front() && event <= times().back())
      changes.push_back(event);
  }
  return changes;
}

Result<std::shared_ptr<const SightSnapshot>> FdsSight::readOwnAt(double when) {
  const auto [best, stored] = caseAt(when);
  VOLUTE_ASSIGN(auto field, best->field(stored));
  if (best->source().quantity == SmokeQuantity::kVisibility && !others_.empty()) {
    VOLUTE_ASSIGN(field, refined(std::move(field), *best, stored));
  }
  VOLUTE_ASSIGN(field, completed(std::move(field), *best, stored));
  std::vector<float> most(field.allValues().size(), 0.0F);  // what is not known is NaN
  parallelFor(most.size(), [&](std::size_t l) {
    for (const float value : field.values(l).value)
      most[l] = value > most[l] && std::isfinite(value) ? value : most[l];
  });
  for (const float one : most) largest_ = std::max(largest_.value_or(0), static_cast<double>(one));
  if (!sameGeometry(field, when))
    ++geometry_;
  lastTime_ = when;
  last_ = field;
  auto snapshot =
      std::make_shared<FdsSightSnapshot>(std::move(field), best->obstructions(when), geometry_);
  snapshot->addBorders(case_.index(), when);
  if (walls_.empty())
    return std::shared_ptr<const SightSnapshot>(std::move(snapshot));
  return std::make_shared<const OccludedSight>(std::move(snapshot), walls_,
                                               OccludedSight::Surfaces::kBodies);
}

Result<std::unique_ptr<PointField>> FdsSight::conditions(std::string_view quantity) {
  return fdsConditions(case_.index(), quantity, maxMemory_);
}

/// When the case begins and ends [s].
const std::pair<double, double>& FdsSight::span() {
  if (!span_) {
    span_ = {times_.front(), std::max(times_.back(), case_.storedUntil())};
    const auto fire = readCurves(case_.index(), "hrr",
                                 [](const auto& name, const auto&) { return name == "HRR"; });
    const bool any = fire && !fire->curves.empty() && !fire->curves.front().times.empty();
    const double stated = inputOf(case_.index()).begin.value_or(0);
    span_->first = std::min(span_->first, any ? fire->curves.front().times.front() : stated);
    if (any)
      span_->second = std::max(span_->second, fire->curves.front().times.back());
  }
  return *span_;
}

double FdsSight::begin() {
  return span().first;
}

double FdsSight::end() {
  return span().second;
}

Result<std::vector<FirePlace>> FdsSight::fires() {
  return fdsFires(case_.index(), maxMemory_);
}

Result<CaseFacts> FdsSight::facts() {
  return fdsFacts(case_.index());
}

}  // namespace volute
