// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/fds_look.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/number_word.hpp"
#include "volute/media/clock_fields.hpp"
#include "volute/media/field_members.hpp"
#include "volute/media/smoke/scene_smoke.hpp"

namespace volute {
namespace {

const FieldTable& fireFields() {
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "emission", .access = member<&FdsLook::emission>(),
       .help = "luminance per metre of fire at 1 MW/m3, or at the hottest temperature; 0 hides "
               "fire; if not given, 20, or less where flames would clip to a uniform surface",
       .least = 0,
       .option = {.value = "S", .name = "fire", .picture = true}},
      {.name = "cutoff", .access = member<&FdsLook::cutoff>(),
       .help = "heat release below which nothing is shown; if not given, the value of the case",
       .unit = "kW/m3", .least = 0,
       .option = {.value = "Q", .picture = true}},
      {.name = "temperature", .access = member<&FdsLook::flame, &FlameLaw::temperature>(),
       .help = "temperature of the black body whose colour flames have; with stored temperatures, "
               "the lowest one with full luminance", .unit = "K", .least = 500,
       .most = 20000, .option = {.value = "T", .picture = true}}};
  // clang-format on
  static const FieldTable kTable = fieldTable<FdsLook>(
      {.name = "fire", .sentence = "the heat release as light", .fields = kFields});
  return kTable;
}

FieldValue noFire(const SmokeDescription& smoke) {
  return smoke.fds.fire ? FieldValue() : FieldValue(false);
}

Status setFire(SmokeDescription& smoke, const FieldValue& value) {
  smoke.fds.fire = value.get<bool>();
  return {};
}

FieldValue cutsOf(const SmokeDescription& smoke) {
  std::string text;
  for (const FdsCut& cut : smoke.fds.cuts) {
    text += fmt::format("{}{}={}", text.empty() ? "" : ",", "xyz"[cut.axis], cut.place);
  }
  return text.empty() ? FieldValue() : FieldValue(text);
}

/// "z=2.4,x=1".
Status setCuts(SmokeDescription& smoke, const FieldValue& value) {
  const std::string text = value.get<std::string>();
  smoke.fds.cuts.clear();
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string one = text.substr(begin, end - begin);
    const auto axis = one.size() > 2 && one[1] == '=' ? std::string_view("xyz").find(one[0])
                                                      : std::string_view::npos;
    FdsCut cut;
    if (axis == std::string_view::npos || !readNumber(std::string_view(one).substr(2), cut.place) ||
        !std::isfinite(cut.place)) {
      return fail(ErrorCode::kInvalidData,
                  "'{}' is not a plane; expected x, y or z and a place in metres, as z=2.4", one);
    }
    cut.axis = static_cast<int>(axis);
    smoke.fds.cuts.push_back(cut);
    begin = end + 1;
  }
  return {};
}

FieldValue sliceRange(const SmokeDescription& smoke) {
  const auto& range = smoke.fds.sliceRange;
  return range ? FieldValue{(*range)[0], (*range)[1]} : FieldValue();
}

Status setSliceRange(SmokeDescription& smoke, const FieldValue& value) {
  if (!(value[0].get<double>() < value[1].get<double>()))
    return fail(ErrorCode::kInvalidData, "expected two numbers, the smaller one first");
  smoke.fds.sliceRange = value.get<std::array<double, 2>>();
  return {};
}

}  // namespace

const FieldTable& fdsFields() {
  using enum FieldType;
  using Smoke = SmokeDescription;
  static const FieldAccess kFire = [] {
    FieldAccess access = customMember<Smoke, noFire, setFire>();
    access.make = part<&Smoke::fds>().make;
    access.find = part<&Smoke::fds>().find;
    return access;
  }();
  // Rows that smoke on a mesh has as well.
  const FieldTable& smoke = smokeFields();
  FieldRow scale = smoke.at("scale"), massExtinction = smoke.at("mass_extinction");
  scale.option.picture = true;
  massExtinction.slider.shown = nullptr;
  static constexpr std::string_view kBuildings[] = {"whole", "open", "inside"};
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "case", .type = kFile, .access = member<&Smoke::file>(),
       .help = "an FDS case (.smv); its building and fire are shown, too", .required = true,
       .pattern = R"(\.[sS][mM][vV]$)"},
      {.name = "field", .type = kText, .access = member<&Smoke::field>(),
       .help = "source of smoke of an FDS case, as listed by `volute info`; if not given, the "
               "best one",
       .otherName = "source", .option = {"NAME"}},
      scale, massExtinction, smoke.at("mode"), smoke.at("C"), smoke.at("albedo"),
      {.name = "fire", .type = kObject, .access = kFire, .help = "show the heat release as light",
       .flagToo = true, .table = &fireFields()},
      {.name = "building", .type = kChoice,
       .access = member<&Smoke::fds, &FdsLook::building>(),
       .help = "whole; open: without the roof and the outer walls that face the camera; inside: "
               "whole, first seen from inside",
       .choices = kBuildings, .option = {.value = "NAME", .more = "; open for a case alone",
       .picture = true}, .slider = {.label = "building"}},
      {.name = "cut", .type = kText, .access = customMember<Smoke, cutsOf, setCuts>(),
       .help = "planes that cut the building open, such as z=2.4 or x=3,z=2.4 [m]; the camera's "
               "side is left out", .option = {.value = "PLANES", .picture = true}},
      {.name = "devices", .type = kFlag, .access = member<&Smoke::fds, &FdsLook::devices>(),
       .help = "mark devices", .option = {.name = "devices", .picture = true}},
      {.name = "slice", .type = kText, .access = member<&Smoke::fds, &FdsLook::slice>(),
       .help = "also show 2D slices of a quantity, such as TEMPERATURE; with a plane "
               "(\"TEMPERATURE z=1.5\"), the slice there or a cut through 3D slices",
       .option = {.value = "QUANTITY", .name = "fds-slice", .picture = true}},
      {.name = "slice_range", .type = kNumbers,
       .access = customMember<Smoke, sliceRange, setSliceRange>(),
       .help = "range of the slice's colours; if not given, the range of all values", .count = 2,
       .option = {.value = "A,B", .name = "fds-slice-range", .beside = "fds-slice",
                  .picture = true}},
      {.name = "iso", .type = kText, .access = member<&Smoke::fds, &FdsLook::iso>(),
       .help = "translucent isosurfaces of a quantity of 3D slices or PLOT3D, such as "
               "\"TEMPERATURE 60\" or \"TEMPERATURE 60,200\"; a quantity alone shows those stored in "
               "isosurface files (.iso); CPU only",
       .option = {.value = "SURFACE", .name = "fds-iso", .picture = true}},
      {.name = "particles", .type = kText, .access = member<&Smoke::fds, &FdsLook::particles>(),
       .help = "show the particles of the case (.prt5): all, the name of a class, or a stored quantity "
               "that colours them, such as \"PARTICLE TEMPERATURE\"",
       .option = {.value = "WHICH", .name = "fds-particles", .picture = true}},
      clockField<&Smoke::clock>()};
  // clang-format on
  static const FieldTable kTable =
      fieldTable<Smoke>({.name = "fds",
                         .sentence = "smoke of an FDS case, which declares what its files contain",
                         .fields = kFields,
                         .says = "smoke",
                         .thing = "an FDS case, which declares what its files contain",
                         .things = "FDS cases",
                         .sibling = smokeFields});
  return kTable;
}

}  // namespace volute
