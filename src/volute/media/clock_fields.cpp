// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/clock_fields.hpp"

#include "volute/media/field_members.hpp"
#include "volute/media/field_sliders.hpp"

namespace volute {

const FieldTable& clockFields() {
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "offset", .access = member<&Clock::offset>(),
       .help = "the medium's time at the scene's 0 s", .unit = "s",
       .slider = {.label = "begins at"}},
      {.name = "rate", .access = member<&Clock::rate>(),
       .help = "seconds of the medium per second of the scene", .least = 0, .above = true,
       .slider = {.label = "speed", .least = 0.05, .most = 20, .logarithmic = true, .unit = "x"}},
      {.name = "loop", .type = FieldType::kFlag, .access = member<&Clock::loop>(),
       .help = "repeat from the first frame after the last one", .slider = {.label = "repeats"}}};
  // clang-format on
  static const FieldTable kTable =
      fieldTable<Clock>({.name = "time", .sentence = "a medium's own time", .fields = kFields});
  return kTable;
}

Status checkOwnTimes(const Clock& clock, const FieldOrigin& origin) {
  if (clock == Clock())
    return {};
  return failIn(origin.file, origin.path + "/time", ErrorCode::kInvalidArgument,
                "is for pictures: sight lines and verdicts are of the case's own times; leave it "
                "out, and shift the times of people instead");
}

void addClock(ParameterGroup& group, const void* clock, const MediumFacts& facts) {
  if (facts.frames < 2)
    return;
  const double seconds = static_cast<const Clock*>(clock)->rate * facts.seconds;
  const std::size_t first = group.size();
  addSliders(group, clockFields(), clock, facts, "time/", "time");
  Parameter& begins = group[first];
  const double most = std::max({seconds, 0.01, std::abs(begins.value.front())});
  begins.least = -most, begins.most = most;
  group[first + 1].help = fmt::format("playback speed of its own {:.3g} s", seconds);
}

}  // namespace volute
