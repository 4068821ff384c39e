// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/rooms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

/// Distances to the nearest zero of a row, squared (Felzenszwalb and Huttenlocher 2012).
void lowerEnvelope(std::span<double> row) {
  const std::size_t n = row.size();
  std::vector<std::size_t> at(n);
  std::vector<double> from(n + 1), out(n);
  std::size_t k = 0;
  const auto meet = [&](std::size_t i, std::size_t j) {
    const double x = static_cast<double>(i), y = static_cast<double>(j);
    return (row[i] + x * x - row[j] - y * y) / (2 * (x - y));
  };
  from[0] = -std::numeric_limits<double>::infinity();
  from[1] = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < n; ++i) {
    double s = meet(i, at[k]);
    while (s <= from[k]) s = meet(i, at[--k]);
    at[++k] = i;
    from[k] = s;
    from[k + 1] = std::numeric_limits<double>::infinity();
  }
  k = 0;
  for (std::size_t i = 0; i < n; ++i) {
    while (from[k + 1] < static_cast<double>(i)) ++k;
    const double d = static_cast<double>(i) - static_cast<double>(at[k]);
    out[i] = d * d + row[at[k]];
  }
  std::ranges::copy(out, row.begin());
}

/// Squares with walls, and how far each is from one.
class Map {
 public:
  Map(const SightSnapshot& first, const Box3& bounds, double height) {
    constexpr double kFinest = 0.1, kMax = 60'000;  // [m], points
    const Vec3 size = bounds.max - bounds.min;
    spacing_ = std::max(kFinest, std::sqrt(size.x() * size.y() / kMax));
    px_ = std::max(1, static_cast<int>(std::ceil(size.x() / spacing_ - 1e-9)));
    py_ = std::max(1, static_cast<int>(std::ceil(size.y() / spacing_ - 1e-9)));
    nx = 2 * px_ - 1;
    ny = 2 * py_ - 1;
    low_ = bounds.min + Vec3(spacing_ / 2, spacing_ / 2, 0);
    low_.z() = height;
    free.assign(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny), 0);
    shapes_ = first.shapes(height);
    std::ranges::copy_if(shapes_, std::back_inserter(doors_), [](const PlanShape& shape) {
      return shape.kind == PlanShape::Kind::kDoor;
    });
    readPoints(first);
    readLines(first);
    measure();
  }

  Vec2 placeOf(std::size_t square) const {
    const auto x = static_cast<double>(square % static_cast<std::size_t>(nx));
    const auto y = static_cast<double>(square / static_cast<std::size_t>(nx));
    return low_.head<2>() + spacing_ / 2 * Vec2(x, y);
  }

  /// Calls `use` with each square beside another.
  template <class Use>
  void around(std::size_t square, Use&& use) const {
    const auto x = static_cast<int>(square % static_cast<std::size_t>(nx));
    const auto y = static_cast<int>(square / static_cast<std::size_t>(nx));
    const auto row = static_cast<std::size_t>(nx);
    if (x > 0)
      use(square - 1);
    if (x + 1 < nx)
      use(square + 1);
    if (y > 0)
      use(square - row);
    if (y + 1 < ny)
      use(square + row);
  }

  double squareSize() const { return spacing_ / 2; }

  Vec2 origin() const { return low_.head<2>(); }

  const std::vector<PlanShape>& shapes() const { return shapes_; }

  int nx = 0, ny = 0;
  std::vector<unsigned char> free;
  std::vector<double> wall;  ///< distance to the nearest one [m]

 private:
  std::size_t squareOf(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(x);
  }

  /// Squares that are points.
  void readPoints(const SightSnapshot& first) {
    const std::size_t count = static_cast<std::size_t>(px_) * static_cast<std::size_t>(py_);
    parallelRanges(count, 1024, [&](std::size_t begin, std::size_t end) {
      std::vector<Vec3> points;
      for (std::size_t i = begin; i < end; ++i) points.push_back(pointAt(i));
      std::vector<Place> places(points.size());
      first.places(points, places);
      for (std::size_t i = begin; i < end; ++i) {
        if (places[i - begin] == Place::kGas && !isShut(points[i - begin], points[i - begin]))
          free[squareOfPoint(i)] = 1;
      }
    });
  }

  Vec3 pointAt(std::size_t i) const {
    return low_ + spacing_ * Vec3(static_cast<double>(i % static_cast<std::size_t>(px_)),
                                  static_cast<double>(i / static_cast<std::size_t>(px_)), 0);
  }

  std::size_t squareOfPoint(std::size_t i) const {
    const auto x = static_cast<int>(i % static_cast<std::size_t>(px_));
    const auto y = static_cast<int>(i / static_cast<std::size_t>(px_));
    return squareOf(2 * x, 2 * y);
  }

  /// Whether a door stands between two points at other times.
  bool isShut(const Vec3& from, const Vec3& to) const {
    const Vec2 a = from.head<2>(), b = to.head<2>();
    const Vec2 low = a.cwiseMin(b), high = a.cwiseMax(b);
    return std::ranges::any_of(doors_, [&](const PlanShape& door) {
      return (door.min.array() <= high.array()).all() && (low.array() <= door.max.array()).all();
    });
  }

  /// Squares between points: thin walls stand there.
  void readLines(const SightSnapshot& first) {
    for (const bool up : {false, true}) {
      const int lastX = px_ - (up ? 0 : 1), lastY = py_ - (up ? 1 : 0);
      parallelRanges(static_cast<std::size_t>(std::max(0, lastY)), 4,
                     [&](std::size_t begin, std::size_t end) {
                       for (std::size_t y = begin; y < end; ++y)
                         readLine(first, static_cast<int>(y), lastX, up);
                     });
    }
    for (int y = 1; y < ny; y += 2) {
      for (int x = 1; x < nx; x += 2) {
        free[squareOf(x, y)] = free[squareOf(x - 1, y)] && free[squareOf(x + 1, y)] &&
                               free[squareOf(x, y - 1)] && free[squareOf(x, y + 1)];
      }
    }
  }

  void readLine(const SightSnapshot& first, int y, int lastX, bool up) {
    const Vec3 step = up ? Vec3(0, spacing_, 0) : Vec3(spacing_, 0, 0);
    std::vector<SightLine> lines;
    std::vector<std::size_t> squares;
    for (int x = 0; x < lastX; ++x) {
      const std::size_t at = squareOf(2 * x, 2 * y);
      const std::size_t beside = at + (up ? 2 * static_cast<std::size_t>(nx) : 2);
      if (!free[at] || !free[beside])
        continue;
      const Vec3 point = low_ + spacing_ * Vec3(x, y, 0);
      if (isShut(point, point + step))
        continue;
      lines.push_back({point, point + step});
      squares.push_back(at + (up ? static_cast<std::size_t>(nx) : 1));
    }
    std::vector<unsigned char> blocked(lines.size());
    first.blocked(lines, blocked);
    for (std::size_t i = 0; i < lines.size(); ++i) free[squares[i]] = blocked[i] ? 0 : 1;
  }

  /// Beyond the border stands a wall.
  void measure() {
    const auto width = static_cast<std::size_t>(nx) + 2, height = static_cast<std::size_t>(ny) + 2;
    const double far = static_cast<double>(width + height) * static_cast<double>(width + height);
    std::vector<double> squares(width * height, 0);
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        if (free[squareOf(x, y)])
          squares[static_cast<std::size_t>(y + 1) * width + static_cast<std::size_t>(x) + 1] = far;
      }
    }
    parallelRanges(height, 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t y = begin; y < end; ++y)
        lowerEnvelope(std::span(squares).subspan(y * width, width));
    });
    parallelRanges(width, 16, [&](std::size_t begin, std::size_t end) {
      std::vector<double> column(height);
      for (std::size_t x = begin; x < end; ++x) {
        for (std::size_t y = 0; y < height; ++y) column[y] = squares[y * width + x];
        lowerEnvelope(column);
        for (std::size_t y = 0; y < height; ++y) squares[y * width + x] = column[y];
      }
    });
    wall.resize(free.size());
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        wall[squareOf(x, y)] =
            squareSize() *
            std::sqrt(
                squares[static_cast<std::size_t>(y + 1) * width + static_cast<std::size_t>(x) + 1]);
      }
    }
  }

  double spacing_ = 0;  // of points
  int px_ = 0, py_ = 0;
  Vec3 low_ = Vec3::Zero();  // the first point
  std::vector<PlanShape> shapes_, doors_;
};

/// Basins of the distance to walls, which grow from their widest place.
class Basins {
 public:
  explicit Basins(const Map& map) : map_(map), labels_(map.free.size(), -1) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < map.free.size(); ++i) {
      if (map.free[i])
        order.push_back(i);
    }
    std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) { return map.wall[i]; });
    for (const std::size_t square : order) add(square);
    mergeSmall();
  }

  /// Of each square.
  std::vector<int> labels() {
    std::vector<int> out(labels_.size(), -1);
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      if (labels_[i] >= 0)
        out[i] = static_cast<int>(root(static_cast<std::size_t>(labels_[i])));
    }
    return out;
  }

 private:
  struct Basin {
    std::size_t parent = 0;
    double width = 0;  // to the nearest wall, at the widest place [m]
    std::size_t squares = 0;
  };

  std::size_t root(std::size_t basin) {
    while (basins_[basin].parent != basin) {
      basins_[basin].parent = basins_[basins_[basin].parent].parent;
      basin = basins_[basin].parent;
    }
    return basin;
  }

  static bool isPassage(double at, double room) {
    return (at < Rooms::kNarrowing * room && at < Rooms::kDoor / 2) ||
           at < Rooms::kWideNarrowing * room;
  }

  void join(std::size_t a, std::size_t b) {
    basins_[b].parent = a;
    basins_[a].width = std::max(basins_[a].width, basins_[b].width);
    basins_[a].squares += basins_[b].squares;
  }

  void add(std::size_t square) {
    const double wide = map_.wall[square];
    std::vector<std::size_t> beside;
    map_.around(square, [&](std::size_t other) {
      if (labels_[other] < 0)
        return;
      const std::size_t basin = root(static_cast<std::size_t>(labels_[other]));
      if (std::ranges::find(beside, basin) == beside.end())
        beside.push_back(basin);
    });
    if (beside.empty()) {
      labels_[square] = static_cast<int>(basins_.size());
      basins_.push_back({basins_.size(), wide, 1});
      return;
    }
    std::ranges::sort(beside, std::greater(), [&](std::size_t one) { return basins_[one].width; });
    const std::size_t into = beside.front();
    labels_[square] = static_cast<int>(into);
    ++basins_[into].squares;
    for (std::size_t i = 1; i < beside.size(); ++i) {
      if (isPassage(wide, basins_[beside[i]].width))
        passages_.push_back({into, beside[i], wide});
      else
        join(into, beside[i]);
    }
  }

  /// Niches are part of what they open to most widely.
  void mergeSmall() {
    const double square = map_.squareSize() * map_.squareSize();
    std::ranges::stable_sort(passages_, std::greater(), &Passage::width);
    for (const Passage& one : passages_) {
      const std::size_t a = root(one.first), b = root(one.second);
      if (a == b)
        continue;
      const auto least =
          static_cast<double>(std::min(basins_[a].squares, basins_[b].squares)) * square;
      if (least < Rooms::kMinSize)
        join(a, b);
    }
  }

  struct Passage {
    std::size_t first = 0, second = 0;
    double width = 0;
  };

  const Map& map_;
  std::vector<int> labels_;
  std::vector<Basin> basins_;
  std::vector<Passage> passages_;
};

/// Numbers rooms from 0 in the order in which a plan is read from its upper left.
void number(Rooms& rooms) {
  std::map<int, int> numbers;
  std::map<int, std::size_t> sizes;
  for (const int label : rooms.labels) {
    if (label >= 0)
      ++sizes[label];
  }
  const double square = rooms.spacing * rooms.spacing;
  for (int y = rooms.ny - 1; y >= 0; --y) {
    for (int x = 0; x < rooms.nx; ++x) {
      const int label =
          rooms.labels[static_cast<std::size_t>(y) * static_cast<std::size_t>(rooms.nx) +
                       static_cast<std::size_t>(x)];
      if (label < 0 || numbers.contains(label))
        continue;
      const double area = static_cast<double>(sizes[label]) * square;
      numbers[label] = area < Rooms::kMinSize ? -1 : static_cast<int>(rooms.rooms.size());
      if (area >= Rooms::kMinSize)
        rooms.rooms.push_back({area});
    }
  }
  for (int& label : rooms.labels) label = label < 0 ? -1 : numbers[label];
}

/// Where two rooms touch.
void findDoors(const Map& map, Rooms& rooms) {
  using Pair = std::pair<int, int>;
  std::map<Pair, std::vector<std::size_t>> borders;
  for (std::size_t i = 0; i < rooms.labels.size(); ++i) {
    const int own = rooms.labels[i];
    if (own < 0)
      continue;
    map.around(i, [&](std::size_t other) {
      const int label = rooms.labels[other];
      if (label <= own)
        return;
      auto& border = borders[{own, label}];
      if (border.empty() || border.back() != i)
        border.push_back(i);
    });
  }
  for (auto& [pair, border] : borders) {
    // Squares of one door are near each other.
    while (!border.empty()) {
      std::vector<std::size_t> door{border.back()};
      border.pop_back();
      for (std::size_t k = 0; k < door.size(); ++k) {
        const Vec2 place = map.placeOf(door[k]);
        std::erase_if(border, [&](std::size_t one) {
          const bool near = (map.placeOf(one) - place).norm() < 2.5 * map.squareSize();
          if (near)
            door.push_back(one);
          return near;
        });
      }
      const auto widest =
          std::ranges::max_element(door, {}, [&](std::size_t one) { return map.wall[one]; });
      rooms.doors.push_back(
          {pair.first, pair.second, map.placeOf(*widest), 2 * map.wall[*widest], false});
    }
  }
}

/// Doors that are shut at some time stand between what is at their two sides.
void findShutDoors(const Map& map, Rooms& rooms) {
  for (const PlanShape& shape : map.shapes()) {
    if (shape.kind != PlanShape::Kind::kDoor && shape.kind != PlanShape::Kind::kOpening)
      continue;
    const Vec2 middle = 0.5 * (shape.min + shape.max), extent = shape.max - shape.min;
    const bool along = extent.x() >= extent.y();  // it stands along x
    const double reach = 0.5 * extent.minCoeff() + 4 * map.squareSize();
    const Vec2 off = along ? Vec2(0, reach) : Vec2(reach, 0);
    const auto roomAt = [&](const Vec2& place) { return rooms.at(place, 2 * map.squareSize()); };
    if (shape.kind == PlanShape::Kind::kOpening) {
      const Vec2 line = along ? Vec2(extent.x(), 0) : Vec2(0, extent.y());
      constexpr int kSteps = 50;
      for (int i = 0; i <= kSteps; ++i) {
        const Vec2 place = middle + (static_cast<double>(i) / kSteps - 0.5) * line;
        for (const int room : {roomAt(place - off), roomAt(place + off)}) {
          if (room >= 0)
            rooms.rooms[static_cast<std::size_t>(room)].outside = true;
        }
      }
      continue;
    }
    const int before = roomAt(middle - off), behind = roomAt(middle + off);
    if (before >= 0 && behind >= 0 && before != behind)
      rooms.doors.push_back(
          {std::min(before, behind), std::max(before, behind), middle, extent.maxCoeff(), true});
  }
}

}  // namespace

int Rooms::at(const Vec2& point, double reach) const {
  const Vec2 place = (point - origin) / spacing;
  const int cells = static_cast<int>(std::ceil(reach / spacing));
  const int x0 = static_cast<int>(std::lround(place.x()));
  const int y0 = static_cast<int>(std::lround(place.y()));
  int found = -1;
  double nearest = (reach / spacing) * (reach / spacing) + 1e-9;
  for (int y = std::max(0, y0 - cells); y <= std::min(ny - 1, y0 + cells); ++y) {
    for (int x = std::max(0, x0 - cells); x <= std::min(nx - 1, x0 + cells); ++x) {
      const int label = labels[static_cast<std::size_t>(y) * static_cast<std::size_t>(nx) +
                               static_cast<std::size_t>(x)];
      const double distance = (Vec2(x, y) - place).squaredNorm();
      if (label >= 0 && distance < nearest) {
        nearest = distance;
        found = label;
      }
    }
  }
  return found;
}

Rooms findRooms(const SightSnapshot& first, const Box3& bounds, double height) {
  const Map map(first, bounds, height);
  Rooms rooms;
  rooms.origin = map.origin();
  rooms.spacing = map.squareSize();
  rooms.nx = map.nx;
  rooms.ny = map.ny;
  rooms.labels = Basins(map).labels();
  number(rooms);
  findDoors(map, rooms);
  findShutDoors(map, rooms);
  return rooms;
}

}  // namespace volute
