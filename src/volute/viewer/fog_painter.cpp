// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/fog_painter.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

constexpr std::size_t kMaxSteps = 200;  ///< that can be undone
constexpr double kDabsARadius = 4;      ///< so that a fast stroke shows no beads

}  // namespace

/// Along an axis, the coefficients that are shown: number m peaks at `first` + m cells.
struct FogPainter::Shown {
  int begin = 0, end = 0;  ///< half open; of a map that drifts -1 may be one
  int count = 0;           ///< of the map
  int whole = 0;           ///< cells that it has drifted
  double entered = 0;      ///< the rest, in cells
  double first = 0;        ///< [m]
  bool repeats = false;

  int coefficient(int m) const {
    const int k = m - whole;
    return repeats ? ((k % count) + count) % count : std::clamp(k, 0, count - 1);
  }

  /// Of one that enters or leaves, the part that is shown (FogSceneMedium::bordered()).
  double share(int m) const { return m < 0 ? entered : m == count - 1 ? 1 - entered : 1; }

  int nearest(double at, double cell) const {
    return std::clamp(static_cast<int>(std::lround((at - first) / cell)), begin, end - 1);
  }

  /// Those no farther than `radius`, half open.
  std::pair<int, int> within(double at, double radius, double cell) const {
    const auto clamped = [&](double m) {
      return static_cast<int>(std::clamp(m, static_cast<double>(begin), static_cast<double>(end)));
    };
    const double middle = (at - first) / cell, reach = radius / cell;
    return {clamped(std::ceil(middle - reach)), clamped(std::floor(middle + reach) + 1)};
  }
};

double FogBrush::weight(double distance) const {
  if (distance >= radius)
    return 0;
  const double inner = (1 - std::clamp(softness, 0.0, 1.0)) * radius;
  if (distance <= inner)
    return 1;
  const double t = (radius - distance) / (radius - inner);
  return t * t * (3 - 2 * t);
}

FogPainter::FogPainter(SplineGrid coefficients, const Vec2& origin, double cell, int degree,
                       double most)
    : grid_(std::move(coefficients)), origin_(origin), cell_(cell), degree_(degree), most_(most) {
  VOLUTE_ASSERT(cell > 0 && most > 0);
}

FogPainter::FogPainter(const FogMedium& fog, double most)
    : FogPainter(fog.levels().map(), Vec2::Zero(), fog.cell(), fog.options().degree, most) {
  const CellRect map = fog.levels().mapCells();
  origin_ = (fog.domainCorner() + fog.cell() * Vec3(map.x0, map.y0, 0)).head<2>();
}

void FogPainter::place(const Vec2& origin, int degree) {
  origin_ = origin;
  degree_ = degree;
}

void FogPainter::rescale(double most, double cell) {
  cell_ = cell;
  if (most == most_)
    return;
  const double factor = most / most_;
  const auto scale = [&](std::vector<double>& values) {
    for (double& value : values) value = std::min(value * factor, most);
  };
  const auto scaleStep = [&](Step& step) { scale(step.before), scale(step.after); };
  scale(grid_.c);
  if (begun_)
    scale(begun_->c);
  std::ranges::for_each(past_, scaleStep);
  std::ranges::for_each(future_, scaleStep);
  most_ = most;
}

FogPainter::Shown FogPainter::shown(int axis) const {
  Shown shown;
  shown.count = shown.end = axis == 0 ? grid_.columns : grid_.rows;
  shown.first = origin_[axis] + 0.5 * (degree_ + 1) * cell_;
  if (drift_.border == FogBorder::kZero) {
    shown.first += drift_.by[axis];
    return shown;
  }
  shown.repeats = drift_.border == FogBorder::kRepeat;
  const double way = drift_.by[axis] / cell_, cells = std::floor(way);
  shown.entered = way - cells;
  shown.whole =
      static_cast<int>(shown.repeats ? std::fmod(cells, shown.count)
                                     : std::clamp(cells, -2.0 * shown.count, 2.0 * shown.count));
  shown.first += shown.entered * cell_;
  shown.begin = shown.entered > 0 ? -1 : 0;
  return shown;
}

/// What wind brings in is shown where the map lies in calm air.
bool FogPainter::covers(const Vec2& at) const {
  Vec2 local = at - origin_;
  if (drift_.border == FogBorder::kZero)
    local -= drift_.by;
  return (local.array() >= 0).all() && (local.array() <= size().array()).all();
}

Vec2 FogPainter::blown(const Vec2& calm) const {
  Vec2 at = calm + drift_.by;
  if (drift_.border != FogBorder::kRepeat)
    return at;
  const Vec2 period = cell_ * Vec2(grid_.columns, grid_.rows);
  at -= origin_;
  return origin_ + at - (period.array() * (at.array() / period.array()).floor()).matrix();
}

Vec2 FogPainter::size() const {
  return cell_ * Vec2(grid_.columns + degree_, grid_.rows + degree_);
}

Vec2 FogPainter::peakOf(const FogPlace& place) const {
  const double half = 0.5 * (degree_ + 1);
  return origin_ + cell_ * Vec2(place.column + half, place.row + half);
}

std::optional<FogPlace> FogPainter::nearest(const Vec2& at) const {
  if (!covers(at))
    return std::nullopt;
  const Shown across = shown(0), along = shown(1);
  return FogPlace{across.coefficient(across.nearest(at.x(), cell_)),
                  along.coefficient(along.nearest(at.y(), cell_))};
}

std::vector<FogPeak> FogPainter::around(const Vec2& at, int cells) const {
  const Shown across = shown(0), along = shown(1);
  const int column = across.nearest(at.x(), cell_), row = along.nearest(at.y(), cell_);
  std::vector<FogPeak> peaks;
  for (int j = std::max(row - cells, along.begin); j < std::min(row + cells + 1, along.end); ++j) {
    for (int i = std::max(column - cells, across.begin);
         i < std::min(column + cells + 1, across.end); ++i) {
      peaks.push_back({{across.coefficient(i), along.coefficient(j)},
                       Vec2(across.first + i * cell_, along.first + j * cell_)});
    }
  }
  return peaks;
}

void FogPainter::begin() {
  end();
  begun_ = grid_;
}

void FogPainter::end() {
  if (!begun_)
    return;
  const SplineGrid before = std::move(*begun_);
  begun_.reset();
  int left = grid_.columns, right = -1, low = grid_.rows, high = -1;
  for (int j = 0; j < grid_.rows; ++j) {
    for (int i = 0; i < grid_.columns; ++i) {
      if (before.at(i, j) == grid_.at(i, j))
        continue;
      left = std::min(left, i), right = std::max(right, i);
      low = std::min(low, j), high = std::max(high, j);
    }
  }
  if (right < 0)
    return;
  Step step{left, low, right - left + 1, high - low + 1, {}, {}, version_, ++versions_};
  for (int j = low; j <= high; ++j) {
    for (int i = left; i <= right; ++i) {
      step.before.push_back(before.at(i, j));
      step.after.push_back(grid_.at(i, j));
    }
  }
  version_ = step.versionAfter;
  past_.push_back(std::move(step));
  if (past_.size() > kMaxSteps)
    past_.pop_front();
  future_.clear();
}

void FogPainter::apply(const Step& step, const std::vector<double>& values) {
  for (int j = 0; j < step.rows; ++j) {
    for (int i = 0; i < step.columns; ++i)
      grid_.at(step.column + i, step.row + j) =
          values[static_cast<std::size_t>(j) * step.columns + i];
  }
}

bool FogPainter::undo() {
  end();
  if (past_.empty())
    return false;
  apply(past_.back(), past_.back().before);
  version_ = past_.back().versionBefore;
  future_.push_back(std::move(past_.back()));
  past_.pop_back();
  return true;
}

bool FogPainter::redo() {
  end();
  if (future_.empty())
    return false;
  apply(future_.back(), future_.back().after);
  version_ = future_.back().versionAfter;
  past_.push_back(std::move(future_.back()));
  future_.pop_back();
  return true;
}

/// Indices of coefficients under a brush, and its weight over each: of one that is shown at several
/// places, the largest.
std::vector<std::pair<std::size_t, double>> FogPainter::under(const FogBrush& brush,
                                                              const Vec2& at) const {
  const Shown across = shown(0), along = shown(1);
  const auto [left, right] = across.within(at.x(), brush.radius, cell_);
  const auto [low, high] = along.within(at.y(), brush.radius, cell_);
  std::vector<std::pair<std::size_t, double>> weights;
  for (int j = low; j < high; ++j) {
    for (int i = left; i < right; ++i) {
      const Vec2 peak(across.first + i * cell_, along.first + j * cell_);
      weights.emplace_back(
          static_cast<std::size_t>(along.coefficient(j)) * grid_.columns + across.coefficient(i),
          across.share(i) * along.share(j) * brush.weight((peak - at).norm()));
    }
  }
  if (drift_.border == FogBorder::kZero)
    return weights;
  std::ranges::sort(weights, std::greater());
  const auto same = std::ranges::unique(weights, {}, &std::pair<std::size_t, double>::first);
  weights.erase(same.begin(), same.end());
  return weights;
}

/// With weights 1 2 1 along each axis, of those that there are.
double FogPainter::meanAround(int i, int j) const {
  const bool repeats = drift_.border == FogBorder::kRepeat;
  double sum = 0, weights = 0;
  for (int dj = -1; dj <= 1; ++dj) {
    for (int di = -1; di <= 1; ++di) {
      int column = i + di, row = j + dj;
      if (repeats) {
        column = (column + grid_.columns) % grid_.columns;
        row = (row + grid_.rows) % grid_.rows;
      }
      if (column < 0 || row < 0 || column >= grid_.columns || row >= grid_.rows)
        continue;
      const double weight = (2 - std::abs(di)) * (2 - std::abs(dj));
      sum += weight * grid_.at(column, row);
      weights += weight;
    }
  }
  return sum / weights;
}

bool FogPainter::dab(const FogBrush& brush, const Vec2& at, double seconds) {
  auto values = under(brush, at);
  for (auto& [index, value] : values) {
    const double share = brush.strength * seconds * value;
    const double old = grid_.c[index];
    const int columns = grid_.columns, k = static_cast<int>(index);
    const double change = brush.kind == FogBrush::Kind::kSmooth
                              ? std::min(share, 1.0) * (meanAround(k % columns, k / columns) - old)
                          : brush.kind == FogBrush::Kind::kAdd ? share * most_
                                                               : -share * most_;
    value = std::clamp(old + change, 0.0, most_);
  }
  bool changed = false;
  for (const auto& [index, value] : values) {
    changed |= grid_.c[index] != value;
    grid_.c[index] = value;
  }
  return changed;
}

bool FogPainter::paint(const FogBrush& brush, const Vec2& from, const Vec2& to, double seconds) {
  const bool alone = !begun_;
  if (alone)
    begin();
  const int dabs =
      1 + static_cast<int>(std::min((to - from).norm() * kDabsARadius / brush.radius, 1e3));
  bool changed = false;
  for (int i = 1; i <= dabs; ++i)
    changed |= dab(brush, from + (to - from) * i / dabs, seconds / dabs);
  if (alone)
    end();
  return changed;
}

bool FogPainter::set(const FogPlace& place, double value) {
  const bool alone = !begun_;
  if (alone)
    begin();
  double& held = grid_.at(place.column, place.row);
  const double wanted = std::clamp(value, 0.0, most_);
  const bool changed = held != wanted;
  held = wanted;
  if (alone)
    end();
  return changed;
}

bool FogPainter::fill(double value) {
  begin();
  std::ranges::fill(grid_.c, std::clamp(value, 0.0, most_));
  const std::size_t before = version_;
  end();
  return version_ != before;
}

Image FogPainter::picture() const {
  Image image(grid_.columns, grid_.rows, 1);
  for (int y = 0; y < grid_.rows; ++y) {
    for (int x = 0; x < grid_.columns; ++x)
      image.at(x, y) = static_cast<float>(grid_.at(x, grid_.rows - 1 - y) / most_);
  }
  return image;
}

}  // namespace volute
