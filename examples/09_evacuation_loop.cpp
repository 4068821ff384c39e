// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// People leave a burning building: at each step they walk towards the nearest visible exit sign, as
// fast as the smoke permits, and accumulate doses. An evacuation program makes the same two
// queries.
//   example_09 case.smv signs.json

#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "volute/scene/scene_sight.hpp"
#include "volute/tenability/walking_speed.hpp"
#include "volute/visibility/sight_engine.hpp"
#include "volute/visibility/sign_file.hpp"

namespace {

volute::Status evacuate(const char* file, const char* signFile) {
  volute::Progress quiet;
  VOLUTE_ASSIGN(auto field, volute::openSight(file, {}, quiet));
  VOLUTE_ASSIGN(const auto signs, volute::readSigns(signFile));
  const volute::Box3 room = field->bounds();
  const double height = room.min.z() + std::min(1.7, 0.7 * room.size().z());
  VOLUTE_ASSIGN(auto engine,
                volute::SightEngine::open(std::move(field), signs, volute::usualCriteria(), quiet));
  for (const auto& missing : engine.missing())
    fmt::print("not assessed: {} ({})\n", missing.criterion.words(), missing.why);

  // One person every two metres.
  std::vector<volute::Vec3> eyes;
  for (double x = room.min.x() + 1; x < room.max.x(); x += 2) {
    for (double y = room.min.y() + 1; y < room.max.y(); y += 2) eyes.emplace_back(x, y, height);
  }
  std::vector<std::int64_t> ids(eyes.size());
  std::iota(ids.begin(), ids.end(), 0);

  constexpr double kStep = 0.5;  // [s]
  const double end = engine.times().back();
  for (int i = 0; i * kStep <= end && !eyes.empty(); ++i) {
    const double t = i * kStep;
    std::vector<volute::Seen> seen(engine.signs().size() * eyes.size());
    std::vector<double> doses(engine.criteria().size() * eyes.size()), smoke(eyes.size());
    VOLUTE_TRY(engine.sees(eyes, t, seen));
    VOLUTE_TRY(engine.dose(ids, eyes, t, doses));
    VOLUTE_TRY(engine.extinction(eyes, t, smoke));
    std::size_t lost = 0, out = 0;
    std::vector<volute::Vec3> left;
    std::vector<std::int64_t> leftIds;
    for (std::size_t a = 0; a < eyes.size(); ++a) {
      const volute::SightTarget* goal = nullptr;
      for (std::size_t s = 0; s < engine.signs().size(); ++s) {
        const volute::SightTarget& sign = engine.signs()[s];
        const bool sees = seen[s * eyes.size() + a] == volute::Seen::kYes;
        if (sees &&
            (goal == nullptr || (sign.target - eyes[a]).norm() < (goal->target - eyes[a]).norm()))
          goal = &sign;
      }
      volute::Vec3 place = eyes[a];
      if (goal == nullptr) {
        ++lost;  // waits
      } else {
        volute::Vec3 way = goal->target - place;
        way.z() = 0;
        const double reach =
            kStep * volute::walkingSpeed(*volute::speedLaw("fridolf"), 1.2, smoke[a]);
        if (way.norm() < std::max(reach, 0.5)) {
          ++out;
          continue;
        }
        place += reach / way.norm() * way;
      }
      left.push_back(place);
      leftIds.push_back(ids[a]);
    }
    if (i % 10 == 0) {
      double worst = 0;
      for (std::size_t c = 0; c < engine.criteria().size(); ++c) {
        for (std::size_t a = 0; engine.criteria()[c].isDose() && a < eyes.size(); ++a)
          worst = std::max(worst,
                           std::isnan(doses[c * eyes.size() + a]) ? 0 : doses[c * eyes.size() + a]);
      }
      fmt::print(
          "{:6.1f} s: {} people, {} see no sign, {} reach an exit, the largest dose is {:.4f}\n", t,
          eyes.size(), lost, out, worst);
    }
    eyes = std::move(left);
    ids = std::move(leftIds);
  }
  fmt::print("{} people are left\n", eyes.size());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: {} CASE.smv SIGNS.json\n", argv[0]);
    return 2;
  }
  if (const auto done = evacuate(argv[1], argv[2]); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
}
