// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/safety_sign.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace volute {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

double degrees(double radians) {
  return radians * (180 / std::numbers::pi);
}

double cosineOf(const SafetySign& sign, const Vec3& eye, double distance) {
  return distance > 0 ? std::clamp(sign.normal.dot(eye - sign.position) / distance, -1.0, 1.0) : 1;
}

}  // namespace

double AngleLaw::factor(double cosine) const {
  switch (kind) {
    case Kind::kAny:
      return 1;
    case Kind::kCosine:
      return std::max(cosine, 0.0);
    case Kind::kLimit:
      return degrees(std::acos(cosine)) <= limit ? 1 : 0;
    case Kind::kFront:
      break;
  }
  return cosine > 1e-9 ? 1 : 0;  // in its plane, rounding aside, a sign is a line
}

Result<AngleLaw> angleLaw(std::string_view name) {
  for (const auto kind : {AngleLaw::Kind::kFront, AngleLaw::Kind::kAny, AngleLaw::Kind::kCosine}) {
    if (nameOf(AngleLaw{kind}) == name)
      return AngleLaw{kind};
  }
  return fail(ErrorCode::kInvalidArgument,
              "angle law '{}': expected front, any, cosine or an object with 'limit' in degrees",
              name);
}

std::string nameOf(const AngleLaw& law) {
  switch (law.kind) {
    case AngleLaw::Kind::kAny:
      return "any";
    case AngleLaw::Kind::kCosine:
      return "cosine";
    case AngleLaw::Kind::kLimit:
      return fmt::format("limit {:g}", law.limit);
    case AngleLaw::Kind::kFront:
      break;
  }
  return "front";
}

std::string_view nameOf(Seen seen) {
  return seen == Seen::kYes ? "yes" : (seen == Seen::kNo ? "no" : "cannot tell");
}

double Sighting::visibility() const {
  if (!(limit > 0))
    return 0;
  if (!covered)
    return kNoNumber;
  const double mean = meanExtinction();
  return mean > 0 ? limit / mean : kInfinity;
}

Sighting judged(Sighting sighting, double depth, double low, double high) {
  sighting.depth = sighting.covered ? depth : kNoNumber;
  sighting.low = low;
  sighting.high = sighting.covered ? high : kInfinity;
  const bool open = !sighting.blocked && sighting.limit > 0;
  sighting.visible = open && sighting.depth <= sighting.limit;
  sighting.certainly = open && sighting.high <= sighting.limit;
  sighting.possibly = open && sighting.low <= sighting.limit;
  return sighting;
}

Sighting judge(const SafetySign& sign, const Vec3& eye, const Sight& sight) {
  Sighting sighting;
  sighting.distance = (eye - sign.position).norm();
  const double cosine = cosineOf(sign, eye, sighting.distance);
  sighting.angle = static_cast<float>(degrees(std::acos(cosine)));
  sighting.limit = sign.law.c * sign.angle.factor(cosine);
  sighting.covered = sight.covered;
  sighting.blocked = sight.blocked;
  return judged(sighting, sight.depth, sight.low, sight.high);
}

}  // namespace volute
