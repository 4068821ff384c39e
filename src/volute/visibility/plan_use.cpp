// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_use.hpp"

#include <algorithm>
#include <cmath>

#include "volute/visibility/verdict.hpp"

namespace volute {
namespace {

/// Whether a body that stands on a floor, the eye at its top, touches a fire or stands on a burner.
bool isIn(const FirePlace& fire, const Vec3& eye, double floor) {
  constexpr double kOn = 0.1;  // [m]
  const Box3& box = fire.bounds;
  return box.min.x() <= eye.x() && eye.x() <= box.max.x() && box.min.y() <= eye.y() &&
         eye.y() <= box.max.y() && box.min.z() < eye.z() && box.max.z() > floor - kOn;
}

}  // namespace

std::vector<bool> PlanUse::are(Kind kind) const {
  std::vector<bool> are(kinds.size());
  for (std::size_t i = 0; i < are.size(); ++i) are[i] = kinds[i] == kind;
  return are;
}

std::size_t PlanUse::count(Kind kind) const {
  return static_cast<std::size_t>(std::ranges::count(kinds, kind));
}

std::string PlanUse::words() const {
  const auto share = [&](Kind kind) {
    return percentWords(static_cast<double>(count(kind)) / static_cast<double>(kinds.size()));
  };
  std::string words;
  if (count(Kind::kVoid) > 0)
    words = fmt::format("{} of the points, which have no floor within {:g} m below them",
                        share(Kind::kVoid), kReach);
  if (count(Kind::kFire) > 0)
    words += fmt::format("{}{} of the points, which are the fire's own place ({})",
                         words.empty() ? "" : "; ", share(Kind::kFire), firesFrom);
  return words.empty() ? words : "not counted: " + words;
}

PlanUse planUse(const Survey& survey, const SightInstant& first, std::span<const Vec3> eyes,
                Progress& progress) {
  PlanUse use{std::vector(eyes.size(), PlanUse::Kind::kPeople), ""};
  if (survey.everywhere)
    return use;
  std::vector<double> floors(eyes.size());
  first.floors(eyes, PlanUse::kReach, floors);
  const auto none = static_cast<std::size_t>(
      std::ranges::count_if(floors, [](double z) { return std::isnan(z); }));
  if (none == eyes.size()) {
    progress.remark(fmt::format(
        "no point of the plan at z = {:g} m has a floor within {:g} m below it: all points count",
        eyes.front().z(), PlanUse::kReach));
  }
  std::vector<FirePlace> fires;
  if (auto found = survey.field->fires())
    fires = std::move(*found);
  else
    progress.remark(found.error().message + ": where the fire is, is not known");
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const Vec3& eye = eyes[i];
    const double floor = std::isnan(floors[i]) ? eye.z() - PlanUse::kReach : floors[i];
    const auto fire =
        std::ranges::find_if(fires, [&](const FirePlace& one) { return isIn(one, eye, floor); });
    const bool stated = std::ranges::any_of(
        survey.fires, [&](const Vec3& spot) { return (eye - spot).head<2>().norm() <= spot.z(); });
    if (fire != fires.end() || stated) {
      use.kinds[i] = PlanUse::Kind::kFire;
      if (use.firesFrom.empty())
        use.firesFrom = stated ? "as stated" : fire->from;
    } else if (std::isnan(floors[i]) && none < eyes.size()) {
      use.kinds[i] = PlanUse::Kind::kVoid;
    }
  }
  if (use.count(PlanUse::Kind::kPeople) > 0)
    return use;
  progress.remark("no point of the plan is for people: all points count");
  return {std::vector(eyes.size(), PlanUse::Kind::kPeople), ""};
}

}  // namespace volute
