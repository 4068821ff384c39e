// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/fog_parameters.hpp"

#include <cmath>

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr const char* kProfiles[] = {"any height", "slab", "exponential", "linear", "layers"};
constexpr double kThin = 0.01;      ///< [m], the least height of a slab or a layer
constexpr double kStrongest = 200;  ///< [m/s] of wind
constexpr double kThinnest = 1e-4;  ///< [1/m]
constexpr double kPixels = 500;     ///< that draw a fog by its own size
constexpr double kEndless = 1e6;    ///< [m]

OrderedJson profileOf(const OrderedJson& fog) {
  return fog.value("profile", OrderedJson::object());
}

/// Of one entry of "knots" or "layers".
double numberAt(const OrderedJson& list, std::size_t i, std::size_t column) {
  return list.at(i).at(column).get<double>();
}

void addKnots(ParameterGroup& group, const OrderedJson& knots) {
  for (std::size_t i = 0; i < knots.size(); ++i) {
    Parameter& knot =
        group.add(fmt::format("knot {}", i + 1), fmt::format("profile/knots/{}", i),
                  Parameter::Kind::kPoint, {numberAt(knots, i, 0), numberAt(knots, i, 1)});
    knot.step = 0.01;
    knot.entry = true, knot.removable = knots.size() > 2;
    knot.help = "height above the map's origin [m]; share of the density there, 0 to 1";
  }
}

void addLayers(ParameterGroup& group, const OrderedJson& layers) {
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const Vec3 layer(numberAt(layers, i, 0), numberAt(layers, i, 1), numberAt(layers, i, 2));
    Parameter& made = group.point(fmt::format("layer {}", i + 1),
                                  fmt::format("profile/layers/{}", i), layer, "", 0.02);
    made.entry = true, made.removable = layers.size() > 1;
    made.help = "bottom and top above the map's origin [m]; share of the density, which adds";
  }
}

void addProfile(ParameterGroup& group, const OrderedJson& profile) {
  group.section("profile");
  const std::string kind = profile.value("kind", "");
  group.choice("fog at", "profile/kind", {std::begin(kProfiles), std::end(kProfiles)}, kind).help =
      "how it thins with height above the map's origin";
  const auto height = [&](const char* name, const char* key, double usual, double least,
                          double most) {
    const std::string path = std::string("profile/") + key;
    group.range(name, path.c_str(), profile.value(key, usual), least, most, "m");
  };
  if (kind == "slab") {
    height("bottom", "bottom", 0, -20, 20);
    height("top", "top", 10, 0, 100);
  } else if (kind == "exponential") {
    height("bottom", "bottom", 0, -20, 20);
    height("scale height", "height", 20, 1, 200);
  } else if (kind == "linear") {
    addKnots(group, profile.at("knots"));
  } else if (kind == "layers") {
    addLayers(group, profile.at("layers"));
  }
  group.section("");
}

void addTop(ParameterGroup& group, const FogTopDescription& top) {
  group.section("upper end");
  Parameter& height = group.range("height", "top/height", top.placement.sigmaMax, 0, 100, "m");
  height.help = "of a white pixel of its map, above the fog's origin: there is no fog above";
  group.point("corner", "top/origin", top.placement.origin, "m", 0.1 * top.placement.cell).help =
      "of its map; its height says nothing";
  group.amount("cell", "top/cell", top.placement.cell, 10, "m").help = "a pixel of its map";
  group.section("");
}

/// The heights between which another kind of profile is to be.
Interval heightsOf(const FogProfile& profile) {
  const Interval all = profile.heights();
  const double bottom = all.begin > -kEndless ? all.begin : 0;
  const double top = all.end < kEndless ? all.end : bottom + 10;
  return {bottom, top > bottom ? top : bottom + 10};
}

/// `kind` about where the fog was.
void takeProfile(OrderedJson& json, const FogProfile& before, const std::string& kind) {
  Interval at = heightsOf(before);
  const OrderedJson old = profileOf(json);
  if (old.value("kind", "") == "exponential")
    at = {old.value("bottom", 0.0), old.value("bottom", 0.0) + old.value("height", 20.0)};
  const double middle = 0.5 * (at.begin + at.end);
  if (kind == "slab") {
    json["profile"] = {{"kind", kind}, {"bottom", at.begin}, {"top", at.end}};
  } else if (kind == "exponential") {
    json["profile"] = {{"kind", kind}, {"bottom", at.begin}, {"height", at.length()}};
  } else if (kind == "linear") {
    json["profile"] = {{"kind", kind}};
    json["profile"]["knots"] = OrderedJson::array(
        {OrderedJson::array({at.begin, 1.0}), OrderedJson::array({middle, 0.7}), OrderedJson::array({at.end, 0.0})});
  } else if (kind == "layers") {
    json["profile"] = {{"kind", kind}};
    json["profile"]["layers"] =
        OrderedJson::array({OrderedJson::array({at.begin, middle, 1.0}), OrderedJson::array({middle, at.end, 0.5})});
  } else {
    json.erase("profile");
  }
}

/// Heights do not fall from knot to knot.
void setKnot(OrderedJson& knots, std::size_t i, const std::vector<double>& value) {
  double height = value[0];
  if (i > 0)
    height = std::max(height, numberAt(knots, i - 1, 0));
  if (i + 1 < knots.size())
    height = std::min(height, numberAt(knots, i + 1, 0));
  knots[i] = OrderedJson::array({height, std::clamp(value[1], 0.0, 1.0)});
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

void duplicateInProfile(OrderedJson& list, std::size_t i, bool knots) {
  OrderedJson copy = list.at(i);
  const double own = numberAt(list, i, 0);
  if (knots) {
    // Halfway to the next; beyond the last as far as it is from the one before.
    const bool last = i + 1 == list.size();
    const double other = numberAt(list, last ? i - 1 : i + 1, 0);
    copy[0] = last ? own + std::max(own - other, kThin) : 0.5 * (own + other);
    if (!last)
      copy[1] = 0.5 * (numberAt(list, i, 1) + numberAt(list, i + 1, 1));
  } else {
    const double top = numberAt(list, i, 1);  // the copy stands on it
    copy[0] = top, copy[1] = top + (top - own);
  }
  list.insert(list.begin() + static_cast<std::ptrdiff_t>(i) + 1, std::move(copy));
}

}  // namespace

void addFog(ParameterGroup group, const OrderedJson& json, const FogDescription& fog, bool suns,
            const MediumInfo& info) {
  Parameter& densest = group.amount("densest", "sigma_max", fog.placement.sigmaMax, 1, "/m");
  densest.least = std::min(kThinnest, fog.placement.sigmaMax);
  densest.help = "extinction of a white pixel of the map";
  group.range("mu", "mu", fog.options.detail.mu, 0, 1).help =
      "each coarser level is used from this share of the distance on; 1 keeps all details";
  group.integer("levels", "levels", fog.options.levels, 0, 6).help = "how often the map is halved";
  group.integer("degree", "degree", fog.options.degree, 0, kMostSplineDegree).help =
      "of the splines";
  group.color("colour", "color", fog.options.color).help =
      "radiance of fog that one cannot see through";
  if (suns) {
    group.color("albedo", "albedo", fog.scattering.albedo).help =
        "share of the extinction that scatters light; the rest absorbs";
    group.range("asymmetry", "asymmetry", fog.scattering.asymmetry, -0.9, 0.9).help =
        "mean cosine of the angle that light is scattered by: above 0 forward";
  }
  group.point("wind", "wind", fog.wind, "m/s", 0.05).help =
      "what the fog is blown by from 0 s on, along x, y and z";
  addProfile(group, profileOf(json));
  if (fog.top)
    addTop(group, *fog.top);
  group.section("placement");
  const double size = info.fileBounds.empty() ? 25 : info.fileBounds.size().head<2>().norm();
  group.point("corner", "origin", fog.placement.origin, "m", size / kPixels).help =
      "of the map, where x and y are least; heights count from its z";
  Parameter& cell = group.range("cell", "cell", fog.placement.cell, 0.1, 10, "m");
  cell.logarithmic = true;
  cell.help = "side of a pixel of the map";
  group.section("");
  group.clock(fog.clock, info);
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
      setKnot(*list, placeIn(key), value);
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
    duplicateInProfile(*list, placeIn(key), knots);
  } else if (list->size() > (knots ? 2 : 1)) {
    list->erase(placeIn(key));
  } else {
    return fail(ErrorCode::kInvalidArgument, "{}: a profile needs {}", key,
                knots ? "two knots" : "a layer");
  }
  return fmt::format("{} {}", knots ? "a knot" : "a layer", more ? "is added" : "is removed");
}

}  // namespace volute
