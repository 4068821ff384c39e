// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/sun_sums.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/fog/fog_march.hpp"

namespace volute {
namespace {

constexpr int kApart = 32;    // cells from line to line
constexpr int kPerCell = 16;  // nodes on a line, at least
constexpr double kNoEnd = std::numeric_limits<double>::infinity();

/// z / highest over all heights.
FogProfile rising() {
  const FogProfile::Knot knots[] = {{0, 0}, {FogProfile::kFarthest, 1}};
  return *FogProfile::linear(knots);
}

FogProfile profileFor(SunSums::Weight weight, double decay) {
  switch (weight) {
    case SunSums::Weight::kOne:
      break;
    case SunSums::Weight::kWay:
      return rising();
    case SunSums::Weight::kDecay:
      return *FogProfile::exponential(0, 1 / decay);
  }
  return {};
}

}  // namespace

double SunSums::Line::at(double node) const {
  const double below = std::floor(node);
  const double share = node - below;
  const auto sumAt = [&](double which) {
    const auto index = static_cast<std::int64_t>(which) - first;
    return index >= 0 && index < std::ssize(sums) ? sums[index] : 0;
  };
  return share > 0 ? (1 - share) * sumAt(below) + share * sumAt(below + 1) : sumAt(below);
}

SunSums::SunSums(const FogMedium& fog, const Vec3& sun, int samples, Weight weight, double decay,
                 const SunSums* plain)
    : fog_(fog.withProfile(profileFor(weight, decay))),
      sun_(sun),
      weight_(weight),
      decay_(decay),
      plain_(plain) {
  VOLUTE_ASSERT(weight != Weight::kWay || plain);
  if (weight == Weight::kWay)  // z = s_z t
    factor_ = FogProfile::kFarthest / sun.z();
  along_ = std::abs(sun.x()) >= std::abs(sun.y()) ? 0 : 1;
  const CellRect map = fog.levels().mapCells();
  const int cells[] = {map.x1 - map.x0, map.y1 - map.y0};
  cellsAlong_ = cells[along_], cellsAcross_ = cells[1 - along_];
  speed_ = std::abs(sun[along_]) / fog.cell();
  // Ways to a sun above do not reach a line.
  constexpr double kHigh = 1e-6;
  if (std::max(cellsAlong_, cellsAcross_) <= kWhole || std::abs(sun[along_]) < kHigh)
    return;
  slope_ = sun[1 - along_] / std::abs(sun[along_]);
  perCell_ = (kPerCell + samples - 1) / samples * samples;
  lines_.resize((cellsAlong_ - 1) / kApart);
  for (int line = static_cast<int>(lines_.size()) - 1; line >= 0; --line) fill(line);
}

void SunSums::fill(int number) {
  constexpr std::size_t kAtOnce = 512;
  const int way = (number + 1) * kApart;
  Line& line = lines_[number];
  line.first = static_cast<std::int64_t>(std::floor(nodeAt(0, way)));
  const auto last = static_cast<std::int64_t>(std::ceil(nodeAt(cellsAcross_, way)));
  line.sums.resize(last - line.first + 1);
  const bool furthest = number + 1 == std::ssize(lines_);
  const double length = furthest ? kNoEnd : kApart / speed_;
  parallelRanges(line.sums.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec2> places;
    for (std::size_t i = begin; i < end; ++i) {
      const double node = static_cast<double>(line.first + static_cast<std::int64_t>(i));
      Vec2 place;
      place[along_] = sun_[along_] > 0 ? way : cellsAlong_ - way;
      place[1 - along_] = node / perCell_ + slope_ * way;
      places.push_back(place);
    }
    const std::vector<double> lengths(places.size(), length);
    const std::span<double> sums = std::span(line.sums).subspan(begin, end - begin);
    walk(places, lengths, sums);
    for (std::size_t i = begin; !furthest && i < end; ++i) {
      const double node = static_cast<double>(line.first + static_cast<std::int64_t>(i));
      line.sums[i] += beyond(number + 1, node, length);
    }
  });
}

void SunSums::walk(std::span<const Vec2> places, std::span<const double> lengths,
                   std::span<double> sums) const {
  const CellRect map = fog_.levels().mapCells();
  const Vec3 corner = fog_.domainCorner() + fog_.cell() * Vec3(map.x0, map.y0, 0);
  std::vector<Segment> segments(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    segments[i] = {corner + fog_.cell() * Vec3(places[i].x(), places[i].y(), 0), sun_, 0,
                   lengths[i]};
  }
  marchDepths(fog_, segments, sums, std::numeric_limits<float>::max());
  for (double& sum : sums) sum *= factor_;
}

double SunSums::beyond(int number, double node, double before) const {
  const double sum = lines_[number].at(node);
  switch (weight_) {
    case Weight::kOne:
      break;
    case Weight::kWay:
      return sum + before * plain_->lines_[number].at(node);
    case Weight::kDecay:
      return sum * std::exp(-decay_ * sun_.z() * before);
  }
  return sum;
}

void SunSums::at(std::span<const Vec2> places, std::span<double> sums) const {
  VOLUTE_ASSERT(places.size() == sums.size());
  const auto wayOf = [&](const Vec2& place) {
    return sun_[along_] > 0 ? place[along_] : cellsAlong_ - place[along_];
  };
  const auto lineAfter = [&](const Vec2& place) {
    return std::max(0, static_cast<int>(std::floor(wayOf(place) / kApart)));
  };
  std::vector<double> lengths(places.size(), kNoEnd);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const int line = lineAfter(places[i]);
    if (line < std::ssize(lines_))
      lengths[i] = ((line + 1) * kApart - wayOf(places[i])) / speed_;
  }
  walk(places, lengths, sums);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const int line = lineAfter(places[i]);
    if (line < std::ssize(lines_)) {
      const double node = nodeAt(places[i][1 - along_], wayOf(places[i]));
      sums[i] += beyond(line, node, lengths[i]);
    }
  }
}

}  // namespace volute
