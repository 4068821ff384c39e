// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/smoke_column.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "volute/base/plain_number.hpp"

namespace volute {
namespace {

/// Where the smoke below an eye is looked at, as shares of the height above the floor, and how much
/// of the largest at the eyes it has to be. Columns thin out upwards, but they widen, too, so that
/// a plan's points and a mesh's cells may miss what is narrow below; below a layer there is
/// nothing.
constexpr std::array kHeights{0.25, 0.5};
constexpr std::array kShares{0.15, 0.3};

}  // namespace

SmokeColumn::SmokeColumn(const FloorPlan& plan, std::span<const std::size_t> places,
                         std::span<const Vec3> eyes, std::span<const double> floors)
    : plan_(plan),
      places_(places.begin(), places.end()),
      eyes_(eyes.begin(), eyes.end()),
      eyeAt_(plan.size(), -1),
      firstBelow_(eyes.size(), -1) {
  constexpr double kMin = 0.5;  // above a floor [m]
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    eyeAt_[places[i]] = static_cast<std::ptrdiff_t>(i);
    const double above = eyes[i].z() - floors[i];
    if (!(above >= kMin))
      continue;
    firstBelow_[i] = static_cast<std::ptrdiff_t>(below_.size());
    for (const double share : kHeights)
      below_.emplace_back(eyes[i].x(), eyes[i].y(), floors[i] + share * above);
  }
}

std::array<std::ptrdiff_t, 4> SmokeColumn::beside(std::size_t eye) const {
  const auto nx = static_cast<std::size_t>(plan_.nx), ny = static_cast<std::size_t>(plan_.ny);
  const std::size_t place = places_[eye], x = place % nx, y = place / nx;
  return {x > 0 ? eyeAt_[place - 1] : -1, x + 1 < nx ? eyeAt_[place + 1] : -1,
          y > 0 ? eyeAt_[place - nx] : -1, y + 1 < ny ? eyeAt_[place + nx] : -1};
}

std::vector<SmokeColumn::Patch> SmokeColumn::patches(std::span<const double> here) const {
  std::vector<Patch> all;
  std::vector<bool> seen(eyes_.size());
  for (std::size_t start = 0; start < eyes_.size(); ++start) {
    if (seen[start] || !(here[start] >= kSmoke))
      continue;
    Patch& patch = all.emplace_back(Patch{start});
    seen[start] = true;
    for (std::size_t k = 0; k < patch.size(); ++k) {
      for (const std::ptrdiff_t other : beside(patch[k])) {
        const auto next = static_cast<std::size_t>(other);
        if (other < 0 || seen[next] || !(here[next] >= kSmoke))
          continue;
        seen[next] = true;
        patch.push_back(next);
      }
    }
  }
  return all;
}

bool SmokeColumn::isColumn(const Patch& patch, std::span<const double> here,
                           std::span<const double> below) const {
  if (static_cast<double>(patch.size()) * plan_.step * plan_.step > kMaxArea)
    return false;
  double atEyes = 0;
  std::array<double, kHeights.size()> under{};
  std::size_t edges = 0, clear = 0;
  for (const std::size_t eye : patch) {
    if (firstBelow_[eye] < 0)
      return false;  // it may come up from a lower storey
    atEyes = std::max(atEyes, here[eye]);
    for (std::size_t h = 0; h < under.size(); ++h)
      under[h] = std::fmax(under[h], below[static_cast<std::size_t>(firstBelow_[eye]) + h]);
    for (const std::ptrdiff_t other : beside(eye)) {
      const bool smoke = other >= 0 && here[static_cast<std::size_t>(other)] >= kSmoke;
      edges += smoke ? 0 : 1;
      clear += other >= 0 && here[static_cast<std::size_t>(other)] < kSmoke ? 1 : 0;
    }
  }
  for (std::size_t h = 0; h < under.size(); ++h) {
    if (under[h] < kShares[h] * atEyes)
      return false;
  }
  return static_cast<double>(clear) >= kClear * static_cast<double>(edges);
}

void SmokeColumn::update(double time, std::span<const double> here, std::span<const double> below) {
  if (done_)
    return;
  const std::vector<Patch> all = patches(here);
  const auto isIn = [](const std::vector<bool>& eyes) {
    return [&eyes](std::size_t eye) { return eyes[eye]; };
  };
  if (column_.empty()) {
    if (all.empty())
      return;
    time_ = time;
    column_.resize(eyes_.size());
    for (const Patch& patch : all) {
      if (!isColumn(patch, here, below))
        continue;
      for (const std::size_t eye : patch) column_[eye] = true;
    }
    done_ = std::ranges::none_of(column_, [](bool one) { return one; });
    reach_ = grown(column_, kSway);
    return;
  }
  for (const Patch& patch : all) {
    if (std::ranges::none_of(patch, isIn(reach_)))
      continue;
    if (!isColumn(patch, here, below)) {
      done_ = true;
      return;
    }
    for (const std::size_t eye : patch) column_[eye] = column_[eye] || reach_[eye];
  }
}

std::vector<bool> SmokeColumn::grown(const std::vector<bool>& eyes, double metres) const {
  std::vector<bool> out = eyes;
  for (int steps = static_cast<int>(std::ceil(metres / plan_.step)); steps > 0; --steps) {
    const std::vector<bool> last = out;
    for (std::size_t eye = 0; eye < last.size(); ++eye) {
      for (const std::ptrdiff_t other : beside(eye)) {
        if (other >= 0 && last[static_cast<std::size_t>(other)])
          out[eye] = true;
      }
    }
  }
  return out;
}

std::vector<bool> SmokeColumn::eyes() const {
  if (std::ranges::none_of(column_, [](bool one) { return one; }))
    return {};
  return grown(column_, kMargin);
}

std::string SmokeColumn::words() const {
  const std::vector<bool> in = eyes();
  Vec3 middle = Vec3::Zero();
  double count = 0;
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (in[i]) {
      middle += eyes_[i];
      ++count;
    }
  }
  middle = middle / std::max(count, 1.0);
  double farthest = 0;
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (in[i])
      farthest = std::max(farthest, (eyes_[i] - middle).head<2>().norm());
  }
  return fmt::format(
      "smoke rises from the floor around x = {:.1f}, y = {:.1f} m, up to {:.1f} m from there, "
      "first "
      "at {} s",
      middle.x(), middle.y(), farthest + plan_.step / 2, plainNumber(time_, 4));
}

}  // namespace volute
