// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_use.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "volute/base/plain_number.hpp"
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

/// Eyes without head room: the floor is near, and something is not far above.
void findLow(const SightSnapshot& first, std::span<const Vec3> eyes, std::span<const double> floors,
             PlanUse& use) {
  constexpr double kStride = 0.1;  // [m]
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    if (use.kinds[i] != PlanUse::Kind::kPeople)
      continue;
    const double top = floors[i] + PlanUse::kHeadRoom;
    for (double z = eyes[i].z() + kStride; z <= top + 1e-9; z += kStride) {
      const Vec3 point(eyes[i].x(), eyes[i].y(), z);
      Place place{};
      first.places({&point, 1}, {&place, 1});
      if (place == Place::kSolid)
        use.kinds[i] = PlanUse::Kind::kLow;
    }
  }
}

/// Eyes above surfaces that are higher than all around them, by more than a step, and small.
void findTops(const FloorPlan& plan, std::span<const std::size_t> places,
              std::span<const double> floors, PlanUse& use) {
  const double rise = PlanUse::kStep + PlanUse::kSlope * plan.step;
  std::vector<std::ptrdiff_t> eyeAt(plan.size(), -1);
  for (std::size_t i = 0; i < places.size(); ++i) eyeAt[places[i]] = static_cast<std::ptrdiff_t>(i);
  const auto nx = static_cast<std::size_t>(plan.nx), ny = static_cast<std::size_t>(plan.ny);
  std::vector<bool> seen(places.size());
  for (std::size_t start = 0; start < places.size(); ++start) {
    if (seen[start] || use.kinds[start] != PlanUse::Kind::kPeople)
      continue;
    std::vector<std::size_t> surface{start};
    seen[start] = true;
    bool lower = false;  // floors around are
    bool higher = false;
    for (std::size_t k = 0; k < surface.size(); ++k) {
      const std::size_t i = surface[k], x = places[i] % nx, y = places[i] / nx;
      for (const auto& [there, next] :
           {std::pair(x > 0, places[i] - 1), std::pair(x + 1 < nx, places[i] + 1),
            std::pair(y > 0, places[i] - nx), std::pair(y + 1 < ny, places[i] + nx)}) {
        const std::ptrdiff_t other = there ? eyeAt[next] : -1;
        if (other < 0)
          continue;
        const auto j = static_cast<std::size_t>(other);
        if (use.kinds[j] != PlanUse::Kind::kPeople)
          continue;
        if (floors[j] < floors[i] - rise) {
          lower = true;
        } else if (floors[j] > floors[i] + rise) {
          higher = true;
        } else if (!seen[j]) {
          seen[j] = true;
          surface.push_back(j);
        }
      }
    }
    const double size = static_cast<double>(surface.size()) * plan.step * plan.step;
    if (!lower || higher || size >= PlanUse::kTopOfThings)
      continue;
    for (const std::size_t i : surface) use.kinds[i] = PlanUse::Kind::kTop;
  }
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

void PlanUse::findFire(const std::vector<bool>& eyes, std::string from) {
  std::vector<std::size_t> burning;
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    if (eyes[i] && kinds[i] == Kind::kPeople)
      burning.push_back(i);
  }
  if (burning.empty() || 2 * burning.size() > count(Kind::kPeople))
    return;
  for (const std::size_t i : burning) kinds[i] = Kind::kFire;
  firesFrom = std::move(from);
  fireUnknown = false;
  fireFound = true;
}

std::string PlanUse::words() const {
  const auto share = [&](Kind kind) {
    return percentWords(static_cast<double>(count(kind)) / static_cast<double>(kinds.size()));
  };
  std::string words;
  const auto add = [&](Kind kind, const std::string& what) {
    if (count(kind) > 0)
      words += fmt::format("{}{} of the points, {}", words.empty() ? "" : "; ", share(kind), what);
  };
  add(Kind::kVoid, fmt::format("which have no floor within {:g} m below them", kReach));
  add(Kind::kFire, fmt::format("which are the fire's own place ({})", firesFrom));
  add(Kind::kLow, fmt::format("which have less than {:g} m of head room", kHeadRoom));
  add(Kind::kTop, "which are on top of things, a step away from any floor");
  add(Kind::kNamed, fmt::format("which are in areas named as not for people ({})", areas));
  add(Kind::kHigher,
      "whose floor is higher (ramps, stairs), and where the air at the eyes above it "
      "is not known");
  if (!words.empty())
    words.insert(0, "not counted: ");
  if (fireUnknown)
    words += fmt::format("{}where it burns is not known, so that the fire's own place counts, too",
                         words.empty() ? "" : "; ");
  return words;
}

std::vector<double> standOnFloors(const SightSnapshot& first, const Box3& bounds, double height,
                                  std::span<Vec3> eyes, Progress& progress) {
  constexpr double kLowest = 1.2;  // eyes above a floor, where the field ends above them [m]
  constexpr double kTallest = 2;   // eyes above a floor [m]
  constexpr std::size_t kFifth = 5;
  constexpr double kStride = 0.1;  // [m]
  std::vector<double> floors(eyes.size());
  first.floors(eyes, PlanUse::kReach, floors);
  std::map<long, std::size_t> counts;  // of floors, by the centimetre
  for (const double floor : floors) {
    if (!std::isnan(floor))
      ++counts[std::lround(100 * floor)];
  }
  if (counts.size() < 2)
    return floors;
  // The lowest that is a fifth of the plan, or else the most frequent one.
  const auto share = [&](const auto& one) { return kFifth * one.second >= floors.size(); };
  auto common = std::ranges::find_if(counts, share);
  if (common == counts.end())
    common = std::ranges::max_element(counts, {}, [](const auto& one) { return one.second; });
  const double usual = 0.01 * static_cast<double>(common->first);
  const double above = std::min(kTallest, height - usual);
  std::size_t lifted = 0;
  double highest = 0;
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    double& z = eyes[i].z();
    double meant = floors[i] + above;
    if (bounds.max.z() >= floors[i] + kLowest)
      meant = std::min(meant, bounds.max.z() - 1e-3);  // else it is a layer of smoke
    if (!(meant > z + PlanUse::kStep))
      continue;
    ++lifted;
    highest = std::max(highest, floors[i] - usual);
    for (double next = z; next < meant;) {
      next = std::min(next + kStride, meant);
      const Vec3 point(eyes[i].x(), eyes[i].y(), next);
      Place place{};
      first.places({&point, 1}, {&place, 1});
      if (place == Place::kSolid)
        break;
      z = next;
    }
  }
  if (lifted > 0) {
    progress.remark(
        {RemarkCode::kNote,
         fmt::format("the floor of {} of the points is up to {:.3g} m higher than that "
                     "of the plan (ramps, stairs, stages): eyes are {:.3g} m above it "
                     "there, higher than z = {} m",
                     percentWords(static_cast<double>(lifted) / static_cast<double>(eyes.size())),
                     highest, above, plainNumber(height))});
  }
  return floors;
}

PlanUse planUse(const Survey& survey, const SightSnapshot& first, const FloorPlan& plan,
                std::span<const std::size_t> places, std::span<const Vec3> eyes,
                std::span<const double> floors, Progress& progress) {
  PlanUse use{std::vector(eyes.size(), PlanUse::Kind::kPeople)};
  if (survey.everywhere)
    return use;
  const auto none = static_cast<std::size_t>(
      std::ranges::count_if(floors, [](double z) { return std::isnan(z); }));
  if (none == eyes.size()) {
    progress.remark({RemarkCode::kAssumed,
                     fmt::format("no point of the plan at z = {} m has a floor within "
                                 "{} m below it: all points count",
                                 plainNumber(survey.height), plainNumber(PlanUse::kReach))});
  }
  std::vector<FirePlace> fires;
  if (auto found = survey.field->fires())
    fires = std::move(*found);
  else
    progress.remark(
        {RemarkCode::kAssumed, found.error().message + ": where the fire is, is not known"});
  use.fireUnknown = fires.empty() && survey.fires.empty();
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
  findLow(first, eyes, floors, use);
  findTops(plan, places, floors, use);
  if (use.count(PlanUse::Kind::kPeople) > 0)
    return use;
  return PlanUse::everybody(eyes.size(), progress);
}

PlanUse PlanUse::everybody(std::size_t eyes, Progress& progress) {
  progress.remark({RemarkCode::kAssumed, "no point of the plan is for people: all points count"});
  return {std::vector(eyes, Kind::kPeople)};
}

}  // namespace volute
