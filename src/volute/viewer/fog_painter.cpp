// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/fog_painter.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

constexpr std::size_t kMaxSteps = 200;  ///< that can be undone
constexpr double kDabsARadius = 4;      ///< so that a fast stroke shows no beads

}  // namespace

/// Coefficients, half open.
struct FogPainter::Rect {
  int begin[2], end[2];
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

Vec2 FogPainter::size() const {
  return cell_ * Vec2(grid_.columns + degree_, grid_.rows + degree_);
}

Vec2 FogPainter::peakOf(const FogPlace& place) const {
  const double half = 0.5 * (degree_ + 1);
  return origin_ + cell_ * Vec2(place.column + half, place.row + half);
}

std::optional<FogPlace> FogPainter::nearest(const Vec2& at) const {
  const Vec2 local = at - origin_;
  if (!((local.array() >= 0).all() && (local.array() <= size().array()).all()))
    return std::nullopt;
  const Vec2 index = local / cell_ - Vec2::Constant(0.5 * (degree_ + 1));
  return FogPlace{std::clamp(static_cast<int>(std::lround(index.x())), 0, grid_.columns - 1),
                  std::clamp(static_cast<int>(std::lround(index.y())), 0, grid_.rows - 1)};
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

FogPainter::Rect FogPainter::under(const Vec2& at, double radius) const {
  const double half = 0.5 * (degree_ + 1);
  const int count[] = {grid_.columns, grid_.rows};
  Rect rect{};
  for (int axis = 0; axis < 2; ++axis) {
    const double middle = (at[axis] - origin_[axis]) / cell_ - half, reach = radius / cell_;
    const auto clamped = [&](double index) {
      return static_cast<int>(std::clamp(index, 0.0, static_cast<double>(count[axis])));
    };
    rect.begin[axis] = clamped(std::ceil(middle - reach));
    rect.end[axis] = clamped(std::floor(middle + reach) + 1);
  }
  return rect;
}

/// With weights 1 2 1 along each axis, of those that there are.
double FogPainter::meanAround(int i, int j) const {
  double sum = 0, weights = 0;
  for (int dj = -1; dj <= 1; ++dj) {
    for (int di = -1; di <= 1; ++di) {
      if (i + di < 0 || j + dj < 0 || i + di >= grid_.columns || j + dj >= grid_.rows)
        continue;
      const double weight = (2 - std::abs(di)) * (2 - std::abs(dj));
      sum += weight * grid_.at(i + di, j + dj);
      weights += weight;
    }
  }
  return sum / weights;
}

bool FogPainter::dab(const FogBrush& brush, const Vec2& at, double seconds) {
  const Rect rect = under(at, brush.radius);
  std::vector<double> values;
  for (int j = rect.begin[1]; j < rect.end[1]; ++j) {
    for (int i = rect.begin[0]; i < rect.end[0]; ++i) {
      const double share = brush.strength * seconds * brush.weight((peakOf({i, j}) - at).norm());
      const double old = grid_.at(i, j);
      const double change = brush.kind == FogBrush::Kind::kSmooth
                                ? std::min(share, 1.0) * (meanAround(i, j) - old)
                            : brush.kind == FogBrush::Kind::kAdd ? share * most_
                                                                 : -share * most_;
      values.push_back(std::clamp(old + change, 0.0, most_));
    }
  }
  bool changed = false;
  auto value = values.begin();
  for (int j = rect.begin[1]; j < rect.end[1]; ++j) {
    for (int i = rect.begin[0]; i < rect.end[0]; ++i) {
      changed |= grid_.at(i, j) != *value;
      grid_.at(i, j) = *value++;
    }
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
