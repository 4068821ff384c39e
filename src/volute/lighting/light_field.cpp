// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/light_field.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr int kFieldCells = 8;
constexpr int kFieldNodes = LightField::Bricks::kNodes;
constexpr int kFieldAcross = kFieldNodes * kFieldNodes;
constexpr int kFieldValues = kFieldAcross * kFieldNodes;
constexpr int kSunRoots = 4;   ///< along the longest side of what a sun lights
constexpr int kLampRoots = 2;  ///< along the distance from a lamp
constexpr double kNearestShare =
    1 / 64.0;  ///< of the farthest distance from a lamp: even steps below

}  // namespace

/// What LightField::State is made of.
namespace light_field {

/// Where a point is: in which root, and where in it, 0..1.
struct Place {
  int root = -1;  ///< outside of all of them
  double in[3] = {};
};

/// A medium may be smaller than a cell. In it and in its shadow at least, and at most, as many
/// cells go across it.
constexpr double kCellsAcross = 12, kMaxAcross = 64;

/// Of the distance from a lamp, or a metre where that is more: cells need be no shorter than the
/// least of this and `finest`.
constexpr double kFinestShare = 0.02;

/// Of a sun: from a point to a place in roots.
struct SunSpace {
  Mat3 axes;
  Vec3 offset = Vec3::Zero(), corner = Vec3::Zero();
  Mat3 world;  ///< columns: across, up, along
  Vec3 cell;   ///< [m] of a root along each axis
  std::array<int, 3> roots{};
  double rows[3][4];  ///< axes and offset
  int counts[3];      ///< roots

  SunSpace(const Lamp& lamp, const Box3& lit) {
    const Vec3 along = lamp.direction.normalized();
    const Vec3 across = along.unitOrthogonal();
    world = Mat3::ofColumns(across, along.cross(across), along);
    Box3 box;
    for (int i = 0; i < 8; ++i) box.extend(world.transpose() * lit.corner(i));
    const Vec3 size = box.size();
    const double side = std::max(size.maxCoeff(), 1e-9) / kSunRoots;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      roots[a] = std::max(1, static_cast<int>(std::ceil(size[axis] / side - 1e-9)));
      cell[axis] = std::max(size[axis], 1e-9 * side) / roots[a];
    }
    corner = box.min;
    axes = cell.cwiseInverse().asDiagonal() * world.transpose();
    offset = -corner.cwiseQuotient(cell);
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 0; k < 3; ++k) rows[axis][k] = axes(axis, k);
      rows[axis][3] = offset[axis];
      counts[axis] = roots[static_cast<std::size_t>(axis)];
    }
  }

  int count() const { return roots[0] * roots[1] * roots[2]; }

  Place find(const Vec3& point) const {
    const double p[3] = {point.x(), point.y(), point.z()};
    Place place;
    int root = 0;
    for (int axis = 2; axis >= 0; --axis) {
      const double* row = rows[axis];
      const double q = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
      const int count = counts[axis];
      if (!(q > -1e-6 && q < count + 1e-6))
        return {};
      const int at = std::clamp(static_cast<int>(q), 0, count - 1);
      place.in[axis] = std::clamp(q - at, 0.0, 1.0);
      root = root * count + at;
    }
    place.root = root;
    return place;
  }

  /// The place of a root's own corner.
  Vec3 low(int root) const {
    return Vec3(root % roots[0], root / roots[0] % roots[1], root / (roots[0] * roots[1]));
  }

  Segment column(int, double u, double v) const {
    const Vec3 at = corner + Vec3(u, v, 0).cwiseProduct(cell);
    return {world * at, world.col(2), -std::numeric_limits<double>::infinity(), 0};
  }

  double distance(double w) const { return w * cell[2]; }

  Vec3 sizes(const Vec3&, const Vec3& size) const { return size.cwiseProduct(cell); }

  /// The axes along which a brick is in a ball's shadow, or beside it in the ball.
  int shadowedBy(const ShadingBall& ball, int, const Vec3& low, const Vec3& size) const {
    const Vec3 at = world.transpose() * ball.centre - corner;
    const Vec3 begin = low.cwiseProduct(cell), end = (low + size).cwiseProduct(cell);
    const auto beside = [&](int axis) {
      return begin[axis] > at[axis] + ball.radius || end[axis] < at[axis] - ball.radius;
    };
    if (beside(0) || beside(1) || end.z() < at.z() - ball.radius)
      return 0;
    return beside(2) ? 3 : 7;
  }
};

/// Of a lamp: faces of a cube, two shares across each, and the logarithm of the distance.
struct LampSpace {
  Vec3 position;
  double nearest = 1, farthest = 1, scale = 1;
  double brightest = 1;  ///< distance to what is lit most

  LampSpace(const Lamp& lamp, const Box3& lit) : position(lamp.position) {
    const Vec3 far = (lit.max - position).cwiseAbs().cwiseMax((lit.min - position).cwiseAbs());
    farthest = std::max(far.norm() * (1 + 1e-9), 1e-9);
    nearest = std::max(std::min(lamp.radius, farthest), kNearestShare * farthest);
    scale = kLampRoots / std::log1p(farthest / nearest);
    const double before = (position.cwiseMax(lit.min).cwiseMin(lit.max) - position).norm();
    brightest = std::max(nearest, before);
  }

  int count() const { return 6 * kLampRoots; }

  Place find(const Vec3& point) const {
    const Vec3 away = point - position;
    const double distance = away.norm();
    if (!(distance <= farthest * (1 + 1e-6)))
      return {};
    int axis = 0;
    const double most = away.cwiseAbs().maxCoeff(&axis);
    const int face = 2 * axis + (away[axis] < 0 ? 1 : 0);
    const double u = most > 0 ? away[(axis + 1) % 3] / most : 0;
    const double v = most > 0 ? away[(axis + 2) % 3] / most : 0;
    const double w = std::log1p(distance / nearest) * scale;
    const int root = std::clamp(static_cast<int>(w), 0, kLampRoots - 1);
    return {face * kLampRoots + root,
            {std::clamp(0.5 * (u + 1), 0.0, 1.0), std::clamp(0.5 * (v + 1), 0.0, 1.0),
             std::clamp(w - root, 0.0, 1.0)}};
  }

  Vec3 low(int root) const { return Vec3(0, 0, root % kLampRoots); }

  Segment column(int root, double u, double v) const {
    const int face = root / kLampRoots, axis = face / 2;
    Vec3 way = Vec3::Zero();
    way[axis] = face % 2 ? -1 : 1;
    way[(axis + 1) % 3] = 2 * u - 1;
    way[(axis + 2) % 3] = 2 * v - 1;
    return {position, way.normalized(), 0, 0};
  }

  double distance(double w) const { return nearest * std::expm1(w / scale); }

  Vec3 sizes(const Vec3& low, const Vec3& size) const {
    const double near = distance(low.z()), far = distance(low.z() + size.z());
    const double across = 0.5 * (near + far);
    return {2 * size.x() * across, 2 * size.y() * across, far - near};
  }

  int shadowedBy(const ShadingBall& ball, int root, const Vec3& low, const Vec3& size) const {
    const Vec3 away = ball.centre - position;
    const double distance = away.norm(), end = this->distance(low.z() + size.z());
    if (distance <= ball.radius || end < distance - ball.radius)
      return 0;
    const double angle = std::asin(ball.radius / distance);
    const Vec3 middle = column(root, low.x() + 0.5 * size.x(), low.y() + 0.5 * size.y()).direction;
    const double between = std::acos(std::clamp(middle.dot(away) / distance, -1.0, 1.0));
    if (between > angle + std::numbers::sqrt2 * std::max(size.x(), size.y()))
      return 0;
    return this->distance(low.z()) < distance + ball.radius ? 7 : 3;
  }
};

/// Nodes, x fastest.
struct FieldBrick {
  std::array<float, kFieldValues> shares{};
  Vec3 low, size;               ///< in roots
  std::array<int, 3> halved{};  ///< how often
  int root = 0;
  double cell = 0;  ///< [m], the smallest side of its cells
  int axes = 0;     ///< bits of those along which it has two parts each
  mutable std::array<std::atomic<const FieldBrick*>, 8> parts{};

  FieldBrick() = default;
  FieldBrick(const FieldBrick&) = delete;
  FieldBrick& operator=(const FieldBrick&) = delete;

  ~FieldBrick() {
    for (auto& part : parts) delete part.load();
  }

  int partCount() const { return axes ? 1 << std::popcount(static_cast<unsigned>(axes)) : 0; }

  /// The part in which a place is, which becomes one in the part.
  int partAt(double (&in)[3]) const {
    int part = 0, bit = 1;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(axes >> axis & 1))
        continue;
      in[axis] *= 2;
      if (in[axis] >= 1)
        in[axis] -= 1, part |= bit;
      bit <<= 1;
    }
    return part;
  }

  double at(const double (&in)[3]) const {
    int i[3];
    float f[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double x = in[axis] * kFieldCells;
      i[axis] = std::min(static_cast<int>(x), kFieldCells - 1);
      f[axis] = static_cast<float>(x - i[axis]);
    }
    const float* v = shares.data() + i[0] + kFieldNodes * (i[1] + kFieldNodes * i[2]);
    const auto row = [&](const float* from) { return from[0] + f[0] * (from[1] - from[0]); };
    const auto plane = [&](const float* from) {
      const float a = row(from);
      return a + f[1] * (row(from + kFieldNodes) - a);
    };
    const float a = plane(v);
    return static_cast<double>(a + f[2] * (plane(v + kFieldAcross) - a));
  }

  /// The largest difference between a node and its neighbours' mean along an axis.
  double bend(int axis) const {
    const int step = axis == 0 ? 1 : axis == 1 ? kFieldNodes : kFieldAcross;
    double most = 0;
    for (int i = 0; i < kFieldValues; ++i) {
      if ((i / step % kFieldNodes) % 2 == 0)
        continue;
      const auto at = [&](int node) {
        return static_cast<double>(shares[static_cast<std::size_t>(node)]);
      };
      most = std::max(most, std::abs(at(i) - 0.5 * (at(i - step) + at(i + step))));
    }
    return most;
  }
};

}  // namespace light_field

struct LightField::State {
  using FieldBrick = light_field::FieldBrick;
  using Place = light_field::Place;

  Lamp lamp;
  std::vector<AnyMedium> media;
  LightFieldOptions options;
  bool isSun;
  light_field::SunSpace sun;
  light_field::LampSpace spot;
  std::vector<ShadingBall> balls{};
  mutable std::vector<std::atomic<const FieldBrick*>> roots;
  mutable std::atomic<std::uint64_t> made = 0;

  State(const Lamp& light, std::vector<AnyMedium> some, const Box3& box,
        const LightFieldOptions& how)
      : lamp(light),
        media(std::move(some)),
        options(how),
        isSun(light.kind == Lamp::Kind::kSun),
        sun(light, box),
        spot(light, box),
        roots(static_cast<std::size_t>(isSun ? sun.count() : spot.count())) {
    for (const AnyMedium& medium : media) {
      const Box3 around = medium.bounds();
      const double radius = 0.5 * around.size().norm();
      if (!around.empty() && std::isfinite(radius))
        balls.push_back({around.centre(), radius});
    }
  }

  State(const State&) = delete;
  State& operator=(const State&) = delete;

  ~State() {
    for (auto& root : roots) delete root.load();
  }

  Place find(const Vec3& point) const { return isSun ? sun.find(point) : spot.find(point); }

  /// Where a brick still has to be halved. A ray past a lamp at a distance sees a light that falls
  /// with it, so what is far away may be less exact.
  double tolerance(const FieldBrick& brick) const {
    if (isSun)
      return 2 * options.tolerance;
    const double times = spot.distance(brick.low.z() + brick.size.z()) / spot.brightest;
    return 2 * options.tolerance * std::clamp(times / 8, 1.0, 4.0);
  }

  /// From node to node of each ray of a brick, from the light on.
  void addWays(const FieldBrick& brick, std::vector<Segment>& ways) const {
    const auto placeOf = [&](int axis, int node) {
      return brick.low[axis] + brick.size[axis] * node / kFieldCells;
    };
    for (int j = 0; j < kFieldNodes; ++j) {
      for (int i = 0; i < kFieldNodes; ++i) {
        const double u = placeOf(0, i), v = placeOf(1, j);
        Segment way = isSun ? sun.column(brick.root, u, v) : spot.column(brick.root, u, v);
        for (int k = 0; k < kFieldNodes; ++k) {
          const double w = placeOf(2, k);
          way.end = isSun ? sun.distance(w) : spot.distance(w);
          ways.push_back(way);
          way.begin = way.end;
        }
      }
    }
  }

  /// A root, or a part of a brick, before anything is known of its light.
  std::unique_ptr<FieldBrick> place(int root, const FieldBrick* whole, int part) const {
    auto brick = std::make_unique<FieldBrick>();
    brick->root = root;
    if (whole) {
      brick->low = whole->low, brick->size = whole->size, brick->halved = whole->halved;
      int bit = 1;
      for (int axis = 0; axis < 3; ++axis) {
        if (!(whole->axes >> axis & 1))
          continue;
        brick->size[axis] *= 0.5;
        ++brick->halved[static_cast<std::size_t>(axis)];
        if (part & bit)
          brick->low[axis] += brick->size[axis];
        bit <<= 1;
      }
    } else {
      brick->low = isSun ? sun.low(root) : spot.low(root);
      brick->size = Vec3::Ones();
    }
    return brick;
  }

  /// @param depths  of its ways
  void fill(FieldBrick& brick, std::span<const double> depths) const {
    for (int column = 0; column < kFieldAcross; ++column) {
      double depth = 0;
      for (int k = 0; k < kFieldNodes; ++k) {
        const auto node = static_cast<std::size_t>(column * kFieldNodes + k);
        depth += depths[node];
        brick.shares[static_cast<std::size_t>(column + kFieldAcross * k)] =
            static_cast<float>(std::exp(-depth));
      }
    }
    const Vec3 cells =
        (isSun ? sun.sizes(brick.low, brick.size) : spot.sizes(brick.low, brick.size)) /
        kFieldCells;
    brick.cell = cells.minCoeff();
    Vec3 finest = Vec3::Constant(options.finest), coarsest = Vec3::Constant(cells.maxCoeff());
    if (!isSun) {  // near a lamp light changes within metres, however large what is lit
      const double far = spot.distance(brick.low.z() + brick.size.z());
      finest.z() = std::min(finest.z(), std::max(1.0, light_field::kFinestShare * far));
    }
    for (const auto& ball : balls) {
      const int in = isSun ? sun.shadowedBy(ball, brick.root, brick.low, brick.size)
                           : spot.shadowedBy(ball, brick.root, brick.low, brick.size);
      for (int axis = 0; axis < 3; ++axis) {
        if (in >> axis & 1) {
          finest[axis] = std::min(finest[axis], 2 * ball.radius / light_field::kMaxAcross);
          coarsest[axis] = std::min(coarsest[axis], 2 * ball.radius / light_field::kCellsAcross);
        }
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (brick.halved[static_cast<std::size_t>(axis)] < options.halvings &&
          cells[axis] >= 2 * finest[axis] &&
          (cells[axis] > coarsest[axis] || brick.bend(axis) > tolerance(brick)))
        brick.axes |= 1 << axis;
    }
    ++made;
  }

  const FieldBrick* make(int root, const FieldBrick* whole, int part) const {
    auto brick = place(root, whole, part);
    std::vector<Segment> ways;
    ways.reserve(kFieldValues);
    addWays(*brick, ways);
    std::vector<double> sums(ways.size(), 0), depths(ways.size());
    for (const AnyMedium& medium : media) {
      medium.opticalDepth(ways, depths);
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += depths[i];
    }
    fill(*brick, sums);
    return brick.release();
  }

  /// All bricks, level by level, by depths that are known of many ways at once.
  void makeAll(
      const std::function<void(std::span<const Segment>, std::span<double>)>& depthsOf) const {
    constexpr std::size_t kTogether = 64, kMaxBricks = 1 << 16;

    struct Slot {
      std::atomic<const FieldBrick*>* at;
      int root;
      const FieldBrick* whole;
      int part;
    };

    std::vector<Slot> open;
    for (std::size_t i = 0; i < roots.size(); ++i)
      open.push_back({&roots[i], static_cast<int>(i), nullptr, 0});
    for (std::size_t done = 0; done < open.size();) {
      std::vector<std::unique_ptr<FieldBrick>> bricks;
      std::vector<Segment> ways;
      const std::size_t count = std::min(kTogether, open.size() - done);
      for (std::size_t i = 0; i < count; ++i) {
        const Slot& slot = open[done + i];
        bricks.push_back(place(slot.root, slot.whole, slot.part));
        addWays(*bricks.back(), ways);
      }
      std::vector<double> depths(ways.size());
      depthsOf(ways, depths);
      for (std::size_t i = 0; i < count; ++i, ++done) {
        FieldBrick& brick = *bricks[i];
        fill(brick, std::span(depths).subspan(i * kFieldValues, kFieldValues));
        if (open.size() + static_cast<std::size_t>(brick.partCount()) > kMaxBricks)
          brick.axes = 0;
        for (int part = 0; part < brick.partCount(); ++part)
          open.push_back({&brick.parts[static_cast<std::size_t>(part)], brick.root, &brick, part});
        open[done].at->store(bricks[i].release());
      }
    }
  }

  /// What is in a slot; whoever comes first puts it there.
  const FieldBrick& got(std::atomic<const FieldBrick*>& slot, int root, const FieldBrick* whole,
                        int part) const {
    if (const FieldBrick* there = slot.load(std::memory_order_acquire))
      return *there;
    const FieldBrick* mine = make(root, whole, part);
    const FieldBrick* other = nullptr;
    if (slot.compare_exchange_strong(other, mine, std::memory_order_acq_rel))
      return *mine;
    delete mine;
    --made;
    return *other;
  }

  const FieldBrick& rootAt(int root) const {
    return got(roots[static_cast<std::size_t>(root)], root, nullptr, 0);
  }

  const FieldBrick& partOf(const FieldBrick& brick, int part) const {
    return got(brick.parts[static_cast<std::size_t>(part)], brick.root, &brick, part);
  }
};

LightField::LightField(const Lamp& lamp, std::vector<AnyMedium> media, const Box3& lit,
                       const LightFieldOptions& options)
    : state_(std::make_shared<const State>(lamp, std::move(media), lit, options)) {}

LightField::LightField(
    const Lamp& lamp, std::vector<AnyMedium> media, const Box3& lit,
    const LightFieldOptions& options,
    const std::function<void(std::span<const Segment>, std::span<double>)>& depthsOfAll)
    : LightField(lamp, std::move(media), lit, options) {
  state_->makeAll(depthsOfAll);
}

double LightField::exactly(const Vec3& point) const {
  const Segment way = state_->lamp.towards(point);
  double sum = 0;
  if (way.empty())
    return 1;
  if (state_->options.known)
    sum = state_->options.known->opticalDepth(point);
  for (const AnyMedium& medium : state_->media) {
    double depth = 0;
    medium.opticalDepth({&way, 1}, {&depth, 1});
    sum += depth;
  }
  return std::exp(-sum);
}

LightField::Sample LightField::at(const Vec3& point) const {
  const KnownDepth* before = state_->options.known.get();
  const double known = before ? std::exp(-before->opticalDepth(point)) : 1;
  if (state_->media.empty())
    return {known, 0};
  auto place = state_->find(point);
  if (place.root < 0)
    return {exactly(point), 0};
  const auto* brick = &state_->rootAt(place.root);
  while (brick->axes) {
    const int part = brick->partAt(place.in);
    brick = &state_->partOf(*brick, part);
  }
  return {known * brick->at(place.in), brick->cell};
}

/// Distances to cylinders behind balls, or to cones from the lamp.
double LightField::evenFor(const Vec3& point) const {
  constexpr double kFine = 1 / 6.0;  // of a shadow's radius
  double even = std::numeric_limits<double>::infinity();
  for (const ShadingBall& ball : state_->balls) {
    double across = 0, radius = ball.radius;
    if (state_->isSun) {
      across = (point - ball.centre).cross(state_->sun.world.col(2)).norm();
    } else {
      const Vec3 axis = ball.centre - state_->lamp.position, away = point - state_->lamp.position;
      const double distance = axis.norm();
      if (distance > ball.radius) {
        const double along = std::max(away.dot(axis) / distance, 0.0);
        across = (away - along / distance * axis).norm();
        radius *= std::max(along, distance) / std::sqrt(distance * distance - radius * radius);
      } else {
        radius = std::max(radius, away.norm());
      }
    }
    even = std::min(even, std::max(kFine * radius, 0.7 * (across - radius)));
  }
  return even;
}

std::span<const ShadingBall> LightField::balls() const {
  return state_->balls;
}

const KnownDepth* LightField::known() const {
  return state_->options.known.get();
}

bool LightField::isKnown() const {
  return known() && state_->media.empty();
}

std::uint64_t LightField::memoryBytes() const {
  return state_->made * sizeof(light_field::FieldBrick);
}

LightField::Bricks LightField::bricks(std::size_t mostWords) const {
  using light_field::FieldBrick;
  Bricks out;
  if (state_->media.empty())
    return out;
  if (state_->isSun) {
    out.axes = state_->sun.axes, out.offset = state_->sun.offset, out.roots = state_->sun.roots;
  } else {
    out.roots = {1, 1, kLampRoots};
    out.nearest = state_->spot.nearest, out.scale = state_->spot.scale;
  }
  std::vector<const FieldBrick*> all(state_->roots.size());
  parallelFor(all.size(), [&](std::size_t i) { all[i] = &state_->rootAt(static_cast<int>(i)); });
  std::vector<std::int32_t> first;
  for (std::size_t begin = 0; begin < all.size();) {  // level by level
    const std::size_t end = all.size();
    std::vector<std::pair<const FieldBrick*, int>> wanted;
    std::size_t next = end;
    for (std::size_t i = begin; i < end; ++i) next += static_cast<std::size_t>(all[i]->partCount());
    const bool fits = next * Bricks::kStride <= mostWords;
    for (std::size_t i = begin; i < end; ++i) {
      const int parts = fits ? all[i]->partCount() : 0;
      first.push_back(parts ? static_cast<std::int32_t>(end + wanted.size()) : -1);
      for (int part = 0; part < parts; ++part) wanted.emplace_back(all[i], part);
    }
    all.resize(end + wanted.size());
    parallelFor(wanted.size(), [&](std::size_t i) {
      all[end + i] = &state_->partOf(*wanted[i].first, wanted[i].second);
    });
    begin = end;
  }
  out.words.reserve(all.size() * Bricks::kStride);
  for (std::size_t i = 0; i < all.size(); ++i) {
    out.words.push_back(static_cast<std::uint32_t>(first[i]));
    out.words.push_back(static_cast<std::uint32_t>(all[i]->axes));
    for (const float share : all[i]->shares)
      out.words.push_back(std::bit_cast<std::uint32_t>(share));
  }
  return out;
}

const Lamp& LightField::lamp() const {
  return state_->lamp;
}

}  // namespace volute
