// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/clock.hpp"

#include <cmath>

#include "volute/io/json_members.hpp"

namespace volute {

double Clock::at(double time, std::span<const double> times) const {
  const double own = offset + rate * time;
  if (!loop || times.size() < 2)
    return own;
  const double last = times.back() - times[times.size() - 2];
  const double period = times.back() - times.front() + last;
  return own - period * std::floor((own - times.front()) / period);
}

Result<Clock> parseClock(const nlohmann::json& json, const std::string& file, const std::string& path) {
  if (!json.is_object())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected offset, rate and loop", file, path);
  constexpr std::string_view kNames[] = {"offset", "rate", "loop"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  Clock clock;
  VOLUTE_TRY(members.number("offset", clock.offset));
  VOLUTE_TRY(members.number("rate", clock.rate));
  if (!(clock.rate > 0))
    return fail(ErrorCode::kInvalidData, "{}: {}/rate: expected more than 0", file, path);
  if (json.contains("loop")) {
    if (!json["loop"].is_boolean())
      return fail(ErrorCode::kInvalidData, "{}: {}/loop: expected true or false", file, path);
    clock.loop = json["loop"].get<bool>();
  }
  return clock;
}

}  // namespace volute
