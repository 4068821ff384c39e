// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_look.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/number_word.hpp"
#include "volute/media/clock_fields.hpp"
#include "volute/media/law_rows.hpp"

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

FieldValue noFire(const FdsDescription& smoke) {
  return smoke.look.fire ? FieldValue() : FieldValue(false);
}

Status setFire(FdsDescription& smoke, const FieldValue& value) {
  smoke.look.fire = value.get<bool>();
  return {};
}

FieldValue cutsOf(const FdsDescription& smoke) {
  std::string text;
  for (const FdsCut& cut : smoke.look.cuts) {
    text += fmt::format("{}{}={}", text.empty() ? "" : ",", "xyz"[cut.axis], cut.place);
  }
  return text.empty() ? FieldValue() : FieldValue(text);
}

/// "z=2.4,x=1".
Status setCuts(FdsDescription& smoke, const FieldValue& value) {
  const std::string text = value.get<std::string>();
  smoke.look.cuts.clear();
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
    smoke.look.cuts.push_back(cut);
    begin = end + 1;
  }
  return {};
}

FieldValue sliceRange(const FdsDescription& smoke) {
  const auto& range = smoke.look.sliceRange;
  return range ? FieldValue{(*range)[0], (*range)[1]} : FieldValue();
}

Status setSliceRange(FdsDescription& smoke, const FieldValue& value) {
  if (!(value[0].get<double>() < value[1].get<double>()))
    return fail(ErrorCode::kInvalidData, "expected two numbers, the smaller one first");
  smoke.look.sliceRange = value.get<std::array<double, 2>>();
  return {};
}

}  // namespace

const FieldTable& fdsFields() {
  using enum FieldType;
  using Smoke = FdsDescription;
  static const FieldAccess kFire = [] {
    FieldAccess access = customMember<Smoke, noFire, setFire>();
    access.make = part<&Smoke::look>().make;
    access.find = part<&Smoke::look>().find;
    return access;
  }();
  FieldRow scale = scaleRow(member<&Smoke::scale>());
  scale.option.picture = true;
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
      scale, massExtinctionRow(member<&Smoke::massExtinction>()), modeRow<Smoke>(),
      lawCRow<Smoke>(), albedoRow<Smoke>(),
      {.name = "fire", .type = kObject, .access = kFire, .help = "show the heat release as light",
       .flagToo = true, .table = &fireFields()},
      {.name = "building", .type = kChoice,
       .access = member<&Smoke::look, &FdsLook::building>(),
       .help = "whole; open: without the roof and the outer walls that face the camera; inside: "
               "whole, first seen from inside",
       .choices = kBuildings, .option = {.value = "NAME", .more = "; open for a case alone",
       .picture = true}, .slider = {.label = "building"}},
      {.name = "cut", .type = kText, .access = customMember<Smoke, cutsOf, setCuts>(),
       .help = "planes that cut the building open, such as z=2.4 or x=3,z=2.4 [m]; the camera's "
               "side is left out", .option = {.value = "PLANES", .picture = true}},
      {.name = "devices", .type = kFlag, .access = member<&Smoke::look, &FdsLook::devices>(),
       .help = "mark devices", .option = {.name = "devices", .picture = true}},
      {.name = "slice", .type = kText, .access = member<&Smoke::look, &FdsLook::slice>(),
       .help = "also show 2D slices of a quantity, such as TEMPERATURE; with a plane "
               "(\"TEMPERATURE z=1.5\"), the slice there or a cut through 3D slices",
       .option = {.value = "QUANTITY", .name = "fds-slice", .picture = true}},
      {.name = "slice_range", .type = kNumbers,
       .access = customMember<Smoke, sliceRange, setSliceRange>(),
       .help = "range of the slice's colours; if not given, the range of all values", .count = 2,
       .option = {.value = "A,B", .name = "fds-slice-range", .beside = "fds-slice",
                  .picture = true}},
      {.name = "iso", .type = kText, .access = member<&Smoke::look, &FdsLook::iso>(),
       .help = "translucent isosurfaces of a quantity of 3D slices or PLOT3D, such as "
               "\"TEMPERATURE 60\" or \"TEMPERATURE 60,200\"; a quantity alone shows those stored in "
               "isosurface files (.iso); CPU only",
       .option = {.value = "SURFACE", .name = "fds-iso", .picture = true}},
      {.name = "particles", .type = kText, .access = member<&Smoke::look, &FdsLook::particles>(),
       .help = "show the particles of the case (.prt5): all, the name of a class, or a stored quantity "
               "that colours them, such as \"PARTICLE TEMPERATURE\"",
       .option = {.value = "WHICH", .name = "fds-particles", .picture = true}},
      clockField<&Smoke::clock>()};
  // clang-format on
  static const FieldTable kTable =
      fieldTable<Smoke>({.name = "fds",
                         .sentence = "smoke of an FDS case, which declares what its files contain",
                         .fields = kFields,
                         .kind = "smoke",
                         .thing = "an FDS case, which declares what its files contain",
                         .things = "FDS cases"});
  return kTable;
}

Result<FdsDescription> parseFds(const nlohmann::json& json, const FieldOrigin& origin) {
  VOLUTE_ASSIGN(auto fds, readAs<FdsDescription>(fdsFields(), json, origin));
  fds.origin = origin;
  return fds;
}

}  // namespace volute
