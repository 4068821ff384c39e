// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Until when is an exit sign visible from several points in a burning building, given the results
// of the Fire Dynamics Simulator?
//   example_07 case.smv

#include <fmt/format.h>

#include "volute/fds/fds_case.hpp"
#include "volute/scene/scene_sight.hpp"
#include "volute/visibility/survey.hpp"

namespace {

volute::Status lookForTheExit(const char* file) {
  volute::Progress quiet;
  VOLUTE_ASSIGN(const auto fire, volute::FdsCase::open(file));
  const volute::Box3 room = fire.bounds();
  fmt::print("{} times, {:.0f} to {:.0f} s; the room is {:.1f} x {:.1f} x {:.1f} m\n",
             fire.times().size(), fire.times().front(), fire.times().back(), room.size().x(),
             room.size().y(), room.size().z());
  for (const volute::Remark& remark : fire.remarks()) fmt::print("{}\n", remark.sentence);

  // The same case, for sight lines. Any scene works, with walls and several media.
  VOLUTE_ASSIGN(const auto smoke, volute::openSight(file, {}, quiet));

  const volute::Vec3 middle = room.min + 0.5 * room.size();
  volute::SafetySign exit;
  exit.name = "exit";
  exit.position = volute::Vec3(room.max.x(), middle.y(), middle.z());  // on the wall
  exit.normal = -volute::Vec3::UnitX();
  VOLUTE_ASSIGN(exit.law, volute::visibilityLaw("jin-emitting"));

  std::vector<volute::Vec3> eyes;
  for (const double share : {0.1, 0.5, 0.9})
    eyes.emplace_back(room.min.x() + share * room.size().x(), middle.y(), middle.z());

  for (std::size_t time = 0; time < smoke->times().size(); ++time) {
    VOLUTE_ASSIGN(const auto snapshot, smoke->read(time));
    VOLUTE_ASSIGN(const auto signs, volute::placeSigns(*snapshot, {&exit, 1}, room, quiet));
    std::vector<volute::Sighting> sightings(signs.size() * eyes.size());
    volute::lookAround(*snapshot, signs, eyes, sightings);
    for (const volute::Sighting& seen : sightings) {
      fmt::print("{:6.1f} s, {:4.1f} m away: optical depth {:.3f}, {}\n", smoke->times()[time],
                 seen.distance, seen.depth,
                 seen.blocked   ? "something stands in the way"
                 : seen.visible ? "seen"
                                : "not seen");
    }
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: {} CASE.smv\n", argv[0]);
    return 2;
  }
  if (const auto done = lookForTheExit(argv[1]); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
}
