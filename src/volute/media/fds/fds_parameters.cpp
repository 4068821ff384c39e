// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_parameters.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

namespace volute {
namespace {

constexpr const char* kOff = "off";
constexpr const char* kBest = "automatic";

/// "TEMPERATURE 60" as its two words; without a number the second is empty.
std::pair<std::string, std::string> isoWords(const std::string& iso) {
  const std::size_t last = iso.find_last_of(' ');
  const bool number = last != std::string::npos &&
                      iso.find_first_not_of("0123456789+-.,eE", last + 1) == std::string::npos;
  return number ? std::pair(iso.substr(0, last), iso.substr(last + 1)) : std::pair(iso, "");
}

using Names = std::vector<std::string>;

/// Sorted, each once, after `first`; what is chosen is among them in any case.
Names namesOf(const char* first, const std::set<std::string>& all, const std::string& chosen) {
  Names names{first};
  names.insert(names.end(), all.begin(), all.end());
  if (!chosen.empty() && std::ranges::find(names, chosen) == names.end())
    names.push_back(chosen);
  return names;
}

/// Nothing where there is nothing to be chosen.
void addChoice(ParameterGroup& group, const char* name, const char* key, const Names& names,
               const std::string& chosen, std::string_view help) {
  if (names.size() < 2)
    return;
  const std::vector<std::string_view> views(names.begin(), names.end());
  group.choice(name, key, views, chosen).help = help;
}

/// Whether it fills a box and is no plane.
bool isThick(const FdsSliceEntry& slice) {
  const auto thick = [&](int axis) { return slice.nodes->end[axis] > slice.nodes->begin[axis]; };
  return slice.nodes && thick(0) && thick(1) && thick(2);
}

/// "TEMPERATURE z=1.5": where the plane is named, and its place.
std::optional<std::pair<std::string, double>> planeOf(const std::string& slice) {
  const std::size_t equals = slice.find_last_of('=');
  if (equals == std::string::npos)
    return std::nullopt;
  const char* const end = slice.data() + slice.size();
  double place = 0;
  const auto [rest, error] = std::from_chars(slice.data() + equals + 1, end, place);
  if (error != std::errc() || rest != end)
    return std::nullopt;
  return std::pair(slice.substr(0, equals), place);
}

/// The plane through what fills a box, at the height of a person's eyes.
void addSlice(ParameterGroup& group, const FdsMedium& fds, std::string_view help) {
  const Box3& box = fds.bounds();
  const double eyes = std::min(box.min.z() + 1.7, box.centre().z());
  std::set<std::string> names;
  for (const FdsSliceEntry& slice : fds.fdsCase().index().slices) {
    const std::string& name = slice.labels.quantity;
    names.insert(isThick(slice) ? fmt::format("{} z={:.2f}", name, eyes) : name);
  }
  const std::string& chosen = fds.description().look.slice;
  addChoice(group, "slice", "slice", namesOf(kOff, names, chosen), chosen.empty() ? kOff : chosen,
            help);
  const auto plane = planeOf(chosen);
  if (!plane)
    return;
  const int axis = std::clamp(plane->first.back() - 'x', 0, 2);
  Parameter& at = group.add("slice at", "slice/at", Parameter::Kind::kNumber, {plane->second});
  at.least = std::min(plane->second, box.min[axis]);
  at.most = std::max(plane->second, box.max[axis]);
  at.unit = "m";
  at.help = fmt::format("{} of the plane", "xyz"[axis]);
}

std::set<std::string> isoQuantities(const SmvIndex& index) {
  std::set<std::string> names;
  for (const FdsIsoEntry& iso : index.isosurfaces) names.insert(iso.labels.quantity);
  for (const FdsPlotEntry& plot : index.plots) {
    for (const FdsLabels& labels : plot.labels) names.insert(labels.quantity);
  }
  for (const FdsSliceEntry& slice : index.slices) {
    if (isThick(slice))
      names.insert(slice.labels.quantity);
  }
  return names;
}

/// A value of an isosurface that says something; a person moves it.
double usualLevel(const std::string& quantity) {
  constexpr std::pair<std::string_view, double> kLevels[] = {
      {"TEMPERATURE", 60}, {"VISIBILITY", 10}, {"HRRPUV", 200}, {"DENSITY", 1e-5}};
  for (const auto& [name, level] : kLevels) {
    if (quantity.find(name) != std::string::npos)
      return level;
  }
  return 1;
}

void addIso(ParameterGroup& group, const FdsMedium& fds, std::string_view help) {
  const auto [quantity, level] = isoWords(fds.description().look.iso);
  const SmvIndex& index = fds.fdsCase().index();
  addChoice(group, "isosurface", "iso", namesOf(kOff, isoQuantities(index), quantity),
            quantity.empty() ? kOff : quantity, help);
  if (level.empty() || level.find(',') != std::string::npos)
    return;
  Parameter& at = group.add("at", "iso/level", Parameter::Kind::kNumber, {std::stod(level)});
  at.least = std::min(0.0, 2 * at.value[0]);
  at.most = std::max(2 * std::abs(at.value[0]), 2 * usualLevel(quantity));
  at.help = "value of the quantity on the surface";
}

void addCuts(ParameterGroup& group, const FdsMedium& fds, std::string_view help) {
  const Box3& box = fds.bounds();
  for (int axis = 0; axis < 3; ++axis) {
    double place = box.max[axis];
    for (const FdsCut& cut : fds.description().look.cuts) {
      if (cut.axis == axis)
        place = cut.place;
    }
    const std::string name(1, "xyz"[axis]);
    Parameter& made = group.add("cut " + name, "cut/" + name, Parameter::Kind::kNumber, {place});
    made.least = std::min(place, box.min[axis]);
    made.most = std::max(place, box.max[axis]);
    made.unit = "m";
    made.help = fmt::format("{}; at the right end: no cut", help);
  }
}

void addFire(ParameterGroup& group, const FdsMedium& fds) {
  if (!fds.burns())
    return;
  const FlameLaw& flame = fds.flame();
  Parameter& bright =
      group.add("brightness", "fire/emission", Parameter::Kind::kNumber, {flame.emission});
  bright.most = std::max(100.0, 2 * flame.emission);
  bright.logarithmic = true;
  bright.unit = "/m";
  bright.help = "luminance per metre of fire at 1 MW/m3, or at the hottest temperature";
  Parameter& kelvin =
      group.add("flames", "fire/temperature", Parameter::Kind::kNumber, {flame.temperature});
  kelvin.least = 500, kelvin.most = std::max(3000.0, flame.temperature);
  kelvin.unit = "K";
  kelvin.help = "temperature of the black body whose colour flames have";
}

}  // namespace

void addCaseParameters(ParameterGroup& group, const FdsMedium& fds) {
  const FdsLook& look = fds.description().look;
  const SmvIndex& index = fds.fdsCase().index();
  const auto help = [](const char* row) { return fdsFields().at(row).help; };
  group.section("what is shown");
  std::set<std::string> sources, clouds;
  for (const FdsSource& source : fds.fdsCase().sources()) sources.insert(source.name);
  const std::string source = fds.description().field;
  addChoice(group, "smoke from", "field", namesOf(kBest, sources, source),
            source.empty() ? kBest : source, help("field"));
  addSlice(group, fds, help("slice"));
  addIso(group, fds, help("iso"));
  if (!index.particles.empty()) {
    clouds = {"all"};
    for (const FdsParticleClass& kind : index.particleClasses) clouds.insert(kind.name);
  }
  addChoice(group, "particles", "particles", namesOf(kOff, clouds, look.particles),
            look.particles.empty() ? kOff : look.particles, help("particles"));
  if (!index.devices.empty())
    group.add("devices", "devices", Parameter::Kind::kFlag, {look.devices ? 1.0 : 0.0}).help =
        help("devices");
  group.section("");
}

void addCaseLook(ParameterGroup& group, const FdsMedium& fds) {
  const FdsLook& look = fds.description().look;
  group.section("building");
  addCuts(group, fds, fdsFields().at("cut").help);
  group.section("fire");
  if (fds.burns() || !look.fire)
    group.add("fire", "fire", Parameter::Kind::kFlag, {look.fire ? 1.0 : 0.0}).help =
        fdsFields().at("fire").help;
  addFire(group, fds);
  group.section("");
}

bool setCaseParameter(nlohmann::ordered_json& entry, const FdsMedium& fds, const std::string& key,
                      const nlohmann::ordered_json& value) {
  const auto put = [&](const char* name, const nlohmann::ordered_json& other, bool given) {
    if (given)
      entry[name] = other;
    else
      entry.erase(name);
    return true;
  };
  if (key == "field")
    return put("field", value, value != kBest);
  if (key == "slice") {
    entry.erase("slice_range");  // of another quantity
    return put("slice", value, value != kOff);
  }
  if (key == "slice/at") {
    const auto plane = planeOf(fds.description().look.slice);
    return plane &&
           put("slice", fmt::format("{}={:.10g}", plane->first, value.get<double>()), true);
  }
  if (key == "particles")
    return put(key.c_str(), value, value != kOff);
  if (key == "iso/level") {
    const std::string quantity = isoWords(fds.description().look.iso).first;
    return put("iso", fmt::format("{} {:.6g}", quantity, value.get<double>()), true);
  }
  if (key == "iso") {
    const std::string quantity = value.get<std::string>();
    const auto& stored = fds.fdsCase().index().isosurfaces;
    const bool whole = std::ranges::any_of(
        stored, [&](const FdsIsoEntry& iso) { return iso.labels.quantity == quantity; });
    return put("iso", whole ? quantity : fmt::format("{} {:g}", quantity, usualLevel(quantity)),
               quantity != kOff);
  }
  if (key.starts_with("cut/")) {
    const int axis = key.back() - 'x';
    std::string cuts;
    const auto add = [&](int of, double place) {
      cuts += fmt::format("{}{}={:.10g}", cuts.empty() ? "" : ",", "xyz"[of], place);
    };
    for (const FdsCut& cut : fds.description().look.cuts) {
      if (cut.axis != axis)
        add(cut.axis, cut.place);
    }
    if (value.get<double>() < fds.bounds().max[axis])
      add(axis, value.get<double>());
    return put("cut", cuts, !cuts.empty());
  }
  if (key == "fire")
    return put("fire", false, value == false);
  return false;
}

}  // namespace volute
