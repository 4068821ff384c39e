// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/fog_parameters.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/media/knots.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::string_view kProfiles[] = {"any height", "slab", "exponential", "linear", "layers"};
constexpr double kThin = 0.01;      ///< [m], the least height of a slab or a layer
constexpr double kStrongest = 200;  ///< [m/s] of wind
constexpr double kEndless = 1e6;    ///< [m]

/// Of one entry of "knots" or "layers".
double numberAt(const OrderedJson& list, std::size_t i, std::size_t column) {
  return list.at(i).at(column).get<double>();
}

void addKnots(ParameterGroup& group, const FogProfileDescription& profile) {
  if (profile.kind != FogProfileDescription::Kind::kLinear)
    return;
  for (std::size_t i = 0; i < profile.knots.size(); ++i) {
    const auto& at = profile.knots[i];
    Parameter& knot = group.add(fmt::format("knot {}", i + 1), fmt::format("profile/knots/{}", i),
                                Parameter::Kind::kPoint, {at[0], at[1]});
    knot.step = 0.01;
    knot.entry = true, knot.removable = profile.knots.size() > 2;
    knot.help = "height above the map's origin [m]; share of the density there, 0 to 1";
  }
}

void addLayers(ParameterGroup& group, const FogProfileDescription& profile) {
  if (profile.kind != FogProfileDescription::Kind::kLayers)
    return;
  for (std::size_t i = 0; i < profile.layers.size(); ++i) {
    const auto& at = profile.layers[i];
    Parameter& made =
        group.point(fmt::format("layer {}", i + 1), fmt::format("profile/layers/{}", i),
                    {at[0], at[1], at[2]}, "", 0.02);
    made.entry = true, made.removable = profile.layers.size() > 1;
    made.help = "bottom and top above the map's origin [m]; share of the density, which adds";
  }
}

/// The heights between which another kind of profile is to be.
Interval heightsOf(const FogProfile& profile) {
  const Interval all = profile.heights();
  const double bottom = all.begin > -kEndless ? all.begin : 0;
  const double top = all.end < kEndless ? all.end : bottom + 10;
  return {bottom, top > bottom ? top : bottom + 10};
}

/// `kind` about where the fog was.
void takeProfile(OrderedJson& json, const FogProfile& before, std::string_view kind) {
  Interval at = heightsOf(before);
  const OrderedJson old = json.value("profile", OrderedJson::object());
  if (old.value("kind", "") == "exponential")
    at = {old.value("bottom", 0.0), old.value("bottom", 0.0) + old.value("height", 20.0)};
  const double middle = 0.5 * (at.begin + at.end);
  if (kind == "slab") {
    json["profile"] = {{"kind", kind}, {"bottom", at.begin}, {"top", at.end}};
  } else if (kind == "exponential") {
    json["profile"] = {{"kind", kind}, {"bottom", at.begin}, {"height", at.length()}};
  } else if (kind == "linear") {
    json["profile"] = {{"kind", kind}};
    json["profile"]["knots"] =
        OrderedJson::array({OrderedJson::array({at.begin, 1.0}), OrderedJson::array({middle, 0.7}),
                            OrderedJson::array({at.end, 0.0})});
  } else if (kind == "layers") {
    json["profile"] = {{"kind", kind}};
    json["profile"]["layers"] = OrderedJson::array(
        {OrderedJson::array({at.begin, middle, 1.0}), OrderedJson::array({middle, at.end, 0.5})});
  } else {
    json.erase("profile");
  }
}

/// The end that was drawn stays beside the other.
void setLayer(OrderedJson& layers, std::size_t i, const std::vector<double>& value) {
  double bottom = value[0], top = value[1];
  if (top - bottom < kThin) {
    if (bottom != numberAt(layers, i, 0))
      bottom = top - kThin;
    else
      top = bottom + kThin;
  }
  layers[i] = OrderedJson::array({bottom, top, std::max(value[2], 0.0)});
}

void setSlab(OrderedJson& profile, const std::string& key, double value) {
  if (key == "bottom")
    profile["bottom"] = std::min(value, profile.value("top", 10.0) - kThin);
  else
    profile["top"] = std::max(value, profile.value("bottom", 0.0) + kThin);
}

/// "profile/knots/1": 1.
std::size_t placeIn(const std::string& key) {
  return static_cast<std::size_t>(std::stoul(key.substr(key.find_last_of('/') + 1)));
}

OrderedJson* listOf(OrderedJson& fog, const std::string& key) {
  for (const char* name : {"knots", "layers"}) {
    if (key.starts_with(std::string("profile/") + name + "/"))
      return &fog["profile"][name];
  }
  return nullptr;
}

/// The copy stands on it.
void duplicateLayer(OrderedJson& list, std::size_t i) {
  OrderedJson copy = list.at(i);
  const double own = numberAt(list, i, 0), top = numberAt(list, i, 1);
  copy[0] = top, copy[1] = top + (top - own);
  list.insert(list.begin() + static_cast<std::ptrdiff_t>(i) + 1, std::move(copy));
}

}  // namespace

void addProfile(ParameterGroup& group, const void* profile, const MediumFacts& facts) {
  const auto* words = static_cast<const FogProfileDescription*>(profile);
  group.section("profile");
  const std::size_t kind = words ? static_cast<std::size_t>(words->kind) + 1 : 0;
  group.choice("fog at", "profile/kind", kProfiles, kProfiles[kind]).help =
      "how it thins with height above the map's origin";
  if (!words)
    return;
  addSliders(group, fogProfileFields(), words, facts, "profile/", "profile");
  group.section("profile");
  addKnots(group, *words);
  addLayers(group, *words);
}

bool setFog(OrderedJson& json, const FogDescription& fog, const std::string& key,
            const std::vector<double>& value) {
  if (key == "wind") {
    OrderedJson wind = OrderedJson::array();
    for (const double v : value) wind.push_back(std::clamp(v, -kStrongest, kStrongest));
    if (value[2] == 0)
      wind.erase(2);
    json["wind"] = std::move(wind);
    return true;
  }
  if (key == "profile/kind") {
    const long kind = std::lround(std::clamp(value[0], 0.0, std::size(kProfiles) - 1.0));
    takeProfile(json, fog.profile, kProfiles[kind]);
    return true;
  }
  if (OrderedJson* list = listOf(json, key)) {
    if (key.starts_with("profile/knots/"))
      setKnot(*list, placeIn(key), value, 1);
    else
      setLayer(*list, placeIn(key), value);
    return true;
  }
  const bool slab = json.value("profile", OrderedJson::object()).value("kind", "") == "slab";
  if (slab && key.starts_with("profile/")) {
    setSlab(json["profile"], key.substr(key.find('/') + 1), value[0]);
    return true;
  }
  return false;
}

Result<std::optional<std::string>> editProfile(OrderedJson& fog, const std::string& key,
                                               bool more) {
  OrderedJson* const list = listOf(fog, key);
  if (!list || !list->is_array() || placeIn(key) >= list->size())
    return std::nullopt;
  const bool knots = key.starts_with("profile/knots/");
  if (more) {
    knots ? duplicateKnot(*list, placeIn(key), kThin) : duplicateLayer(*list, placeIn(key));
  } else if (list->size() > (knots ? 2 : 1)) {
    list->erase(placeIn(key));
  } else {
    return fail(ErrorCode::kInvalidArgument, "{}: a profile needs {}", key,
                knots ? "two knots" : "a layer");
  }
  return fmt::format("{} {}", knots ? "a knot" : "a layer", more ? "is added" : "is removed");
}

}  // namespace volute
