// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "volute/math/vec.hpp"
#include "volute/media/parameter.hpp"
#include "volute/media/scene_medium.hpp"
#include "volute/media/clock.hpp"

namespace volute {

/// Collects the parameters of one object of a scene.
class ParameterGroup {
 public:
  using Kind = Parameter::Kind;

  /// @param path  of the object in the scene's JSON: "/media/0"
  ParameterGroup(std::vector<Parameter>& out, std::string name, std::string path)
      : out_(out), name_(std::move(name)), path_(std::move(path)) {}

  /// Of what follows.
  void section(std::string name) { section_ = std::move(name); }

  Parameter& add(const std::string& name, const std::string& key, Kind kind,
                 std::vector<double> value) {
    out_.push_back({name_, name, path_ + "/" + key, kind, std::move(value)});
    out_.back().section = section_;
    return out_.back();
  }

  /// From 0, the more finely the nearer to it.
  Parameter& amount(const char* name, const char* key, double value, double most,
                    const char* unit) {
    Parameter& made = add(name, key, Kind::kNumber, {value});
    made.most = std::max(most, 2 * value);
    made.logarithmic = true;
    made.unit = std::string(unit);  // GCC 12 warns of the plain assignment
    return made;
  }

  Parameter& range(const char* name, const char* key, double value, double least, double most,
                   const char* unit = "") {
    Parameter& made = add(name, key, Kind::kNumber, {value});
    made.least = std::min(least, value), made.most = std::max(most, value);
    made.unit = std::string(unit);  // GCC 12 warns of the plain assignment
    return made;
  }

  Parameter& choice(const char* name, const char* key, std::vector<std::string> choices,
                    std::string_view value) {
    const auto found = std::ranges::find(choices, value);
    const auto place = found == choices.end() ? 0 : found - choices.begin();
    Parameter& made = add(name, key, Kind::kChoice, {static_cast<double>(place)});
    made.most = static_cast<double>(choices.size()) - 1;
    made.choices = std::move(choices);
    return made;
  }

  Parameter& integer(const char* name, const char* key, int value, int least, int most) {
    Parameter& made = add(name, key, Kind::kInteger, {static_cast<double>(value)});
    made.least = std::min(least, value), made.most = std::max(most, value);
    return made;
  }

  Parameter& flag(const char* name, const char* key, bool on) {
    return add(name, key, Kind::kFlag, {on ? 1.0 : 0.0});
  }

  /// @param step  for each pixel that the mouse goes
  Parameter& point(const std::string& name, const std::string& key, const Vec3& value,
                   const char* unit, double step) {
    Parameter& made = add(name, key, Kind::kPoint, {value.x(), value.y(), value.z()});
    made.unit = unit, made.step = step;
    return made;
  }

  Parameter& color(const char* name, const char* key, const Rgb& value) {
    return add(name, key, Kind::kColor, {value[0], value[1], value[2]});
  }

  /// "time" of a medium, where it has more than one frame.
  void clock(const Clock& clock, const MediumInfo& medium) {
    if (medium.times.size() < 2)
      return;
    section("time");
    const double seconds = clock.rate * std::abs(medium.times.back() - medium.times.front());
    const double most = std::max(seconds, 0.01);
    range("begins at", "time/offset", clock.offset, -most, most, "s").help =
        "the time of its own that it shows at 0 s";
    Parameter& speed = range("speed", "time/rate", clock.rate, 0.05, 20, "x");
    speed.logarithmic = true;
    speed.help = fmt::format("its own {:.3g} s take so many times less", seconds);
    flag("repeats", "time/loop", clock.loop).help = "after its last frame the first comes again";
    section("");
  }

 private:
  std::vector<Parameter>& out_;
  std::string name_, path_, section_;
};

}  // namespace volute
