// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "volute/math/box.hpp"
#include "volute/media/field.hpp"
#include "volute/media/parameter.hpp"

namespace volute {

/// What is known of a medium, as far as its controls depend on it.
struct MediumFacts {
  int frames = 1;
  double seconds = 0;            ///< of the scene's time, from its first frame to its last
  Box3 bounds{};                 ///< before what the scene does with it [m]
  double largestExtinction = 0;  ///< of smoke on a mesh [1/m]; 0: not known
  bool suns = false;             ///< shine in the scene
};

/// Collects the parameters of one object of a scene.
class ParameterGroup {
 public:
  using Kind = Parameter::Kind;

  /// @param path  of the object in the scene's JSON: "/media/0"
  ParameterGroup(std::vector<Parameter>& out, std::string name, std::string path)
      : out_(out), begin_(out.size()), name_(std::move(name)), path_(std::move(path)) {}

  /// Begins a section: sliders that follow belong to it.
  void section(std::string_view name) { section_ = name; }

  std::size_t size() const { return out_.size() - begin_; }

  Parameter& operator[](std::size_t i) { return out_[begin_ + i]; }

  Parameter& add(const std::string& name, const std::string& key, Kind kind,
                 std::vector<double> value);

  /// What a row says of itself. `key` is its path from the object.
  Parameter& add(const FieldRow& field, const std::string& key, const FieldValue& value);

  Parameter& choice(const std::string& name, const std::string& key,
                    std::span<const std::string_view> choices, std::string_view value);

  /// @param step  for each pixel that the mouse goes
  Parameter& point(const std::string& name, const std::string& key, const Vec3& value,
                   const char* unit, double step);

 private:
  std::vector<Parameter>& out_;
  std::size_t begin_;
  std::string name_, path_, section_;
};

/// The rows of a table that have sliders, with the values of `object`.
/// @param prefix  of their keys, of an object in an object: "time/"
/// @param section  of all of them; empty: of each its own
void addSliders(ParameterGroup& group, const FieldTable& table, const void* object,
                const MediumFacts& facts, const std::string& prefix = "",
                std::string_view section = "");

/// Puts the value of a slider where it stands, "/lights/0/angle", or, of two numbers, one of them:
/// "/signs/0/size/1". `table` is that of the object at `owner`.
void putSlider(nlohmann::ordered_json& json, const FieldTable& table, const std::string& owner,
               const Parameter& parameter, const std::vector<double>& value);

/// What a slider's value is in a file.
nlohmann::ordered_json jsonOf(const Parameter& parameter, const std::vector<double>& value);

}  // namespace volute
