// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_sight.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <mutex>

#include "volute/base/parallel.hpp"
#include "volute/fds/fds_march.hpp"
#include "volute/media/fds/fds_conditions.hpp"

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

}  // namespace

/// The least and the largest extinction in blocks of 2 x 2 x 2 cells of each lattice; solid cells
/// count as 0, unknown ones as anything. Lines go through an eighth of the cells, with one value to
/// fetch where nodes have eight; blocks of 4 leave more lines undecided, which costs more.
struct FdsInstant::Blocks {
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

FdsInstant::Blocks::OfLattice FdsInstant::Blocks::of(const FdsLattice& lattice,
                                                     const FdsValues& values,
                                                     const std::vector<FdsCell>& cells) {
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

const FdsInstant::Blocks& FdsInstant::blocks() const {
  std::call_once(blocks_->made, [&] {
    for (std::size_t i = 0; i < field_.grid().lattices().size(); ++i) {
      blocks_->lattices.push_back(
          Blocks::of(field_.grid().lattices()[i], field_.values(i), field_.cells(i)));
    }
  });
  return *blocks_;
}

void FdsInstant::bounds(std::span<const SightLine> lines, std::span<double> low,
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

void FdsInstant::blocked(std::span<const SightLine> lines, std::span<unsigned char> out) const {
  for (std::size_t i = 0; i < lines.size(); ++i)
    out[i] = obstructions_.blocked(segmentOf(lines[i])) ? 1 : 0;
}

FdsInstant::FdsInstant(FdsField field, FdsObstructions obstructions, std::uint64_t geometry)
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

void FdsInstant::joinValues() {
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

SightData FdsInstant::data() const {
  if (firsts_.size() > 1)
    return {value_, low_, high_};
  const FdsValues& values = field_.values(0);
  return {values.value, values.low, values.high};
}

void FdsInstant::weigh(const SightLine& line, std::vector<SightWeight>& weights,
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
  sight.blocked = obstructions_.blocked(segment);
}

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

void FdsInstant::addBorders(const SmvIndex& index, double time) {
  for (const FdsMesh& mesh : index.meshes) {
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

std::vector<PlanShape> FdsInstant::shapes(double z) const {
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

Place placeOf(std::optional<FdsCell> cell) {
  if (!cell || *cell == FdsCell::kUnknown)
    return Place::kOutside;
  return *cell == FdsCell::kSolid ? Place::kSolid : Place::kGas;
}

}  // namespace

void FdsInstant::places(std::span<const Vec3> points, std::span<Place> places) const {
  for (std::size_t i = 0; i < points.size(); ++i) places[i] = placeOf(field_.cellAt(points[i]));
}

void FdsInstant::extinction(std::span<const Vec3> points, std::span<double> extinction) const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    extinction[i] = field_.cellAt(points[i]) == FdsCell::kGas
                        ? field_.extinction(points[i])
                        : std::numeric_limits<double>::quiet_NaN();
  }
}

/// Whether cells and obstructions are those of the last time.
bool FdsSight::sameGeometry(const FdsField& field, double time) const {
  if (!last_)
    return false;
  for (const double event : obstructionEvents(case_.index())) {
    if (event > lastTime_ && event <= time)
      return false;
  }
  for (std::size_t i = 0; i < field.grid().lattices().size(); ++i) {
    if (&field.cells(i) != &last_->cells(i) && field.cells(i) != last_->cells(i))
      return false;
  }
  return true;
}

std::string FdsSight::tallerSource() const {
  FdsOptions filling{.volume = true};
  filling.maxMemory = maxMemory_;
  const auto other = FdsCase::open(case_.index(), filling);
  const bool taller = other && other->bounds().size().z() > ownBounds().size().z();
  return taller ? other->source().name : "";
}

std::vector<double> FdsSight::changes() const {
  std::vector<double> changes;
  for (const double event : obstructionEvents(case_.index())) {
    if (event > times().front() && event <= times().back())
      changes.push_back(event);
  }
  return changes;
}

Result<std::shared_ptr<const SightInstant>> FdsSight::readOwnAt(double when) {
  VOLUTE_ASSIGN(auto field, case_.field(when));
  if (!sameGeometry(field, when))
    ++geometry_;
  lastTime_ = when;
  last_ = field;
  auto instant =
      std::make_shared<FdsInstant>(std::move(field), case_.obstructions(when), geometry_);
  instant->addBorders(case_.index(), when);
  return std::shared_ptr<const SightInstant>(std::move(instant));
}

Result<std::unique_ptr<PointField>> FdsSight::conditions(std::string_view quantity) {
  return fdsConditions(case_.index(), quantity, maxMemory_);
}

Result<CaseFacts> FdsSight::facts() {
  return fdsFacts(case_.index());
}

}  // namespace volute
