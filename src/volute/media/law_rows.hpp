// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/media/field_members.hpp"
#include "volute/media/field_sliders.hpp"
#include "volute/media/law_field.hpp"

// Members of what is seen through a law of visibility. A description D has `law`, `givesC` and
// `albedo`.

namespace volute {

// clang-format off: a row is read as one
inline FieldRow scaleRow(const FieldAccess& access) {
  return {.name = "scale", .access = access, .help = "factor applied to the field first",
          .least = 0, .above = true, .option = {"S"},
          .slider = {.label = "scale", .least = 0, .most = 10, .logarithmic = true, .room = 2,
                     .unit = "x"}};
}

inline FieldRow massExtinctionRow(const FieldAccess& access) {
  return {.name = "mass_extinction", .access = access,
          .help = "extinction of 1 kg/m3 of soot (natural logarithm)", .unit = "m2/kg", .least = 0,
          .above = true, .option = {"KM"}, .slider = {.label = "mass ext. Km", .least = 1000, .most = 15000}};
}

template <class D>
FieldRow modeRow() {
  static constexpr std::string_view kModes[] = {"photometric", "threshold"};
  return {.name = "mode", .type = FieldType::kChoice,
          .access = member<&D::law, &PictureLaw::mode>(),
          .help = "photometric: physical transmittance; threshold: fades to 10 % at the limit of "
                  "visibility", .choices = kModes,
          .option = {.value = "NAME", .picture = true, .scene = true}, .slider = {.label = "mode"}};
}

template <class D>
FieldRow albedoRow() {
  return {.name = "albedo", .type = FieldType::kColor, .access = member<&D::albedo>(),
          .help = "scattered share of the extinction; the rest is absorbed", .least = 0, .most = 1,
          .option = {.value = "R,G,B", .picture = true}, .slider = {.label = "albedo"}};
}

// clang-format on

template <class D>
FieldValue lawC(const D& description) {
  return description.givesC ? FieldValue(description.law.c) : FieldValue();
}

template <class D>
Status setLawC(D& description, const FieldValue& value) {
  VOLUTE_ASSIGN(const auto law, lawOf(value));
  description.law.c = law.c;
  if constexpr (requires { description.model; })
    description.model.c = law.c;
  description.givesC = true;
  return {};
}

template <class D>
void addLawC(ParameterGroup& group, const void* description, const MediumFacts& facts);

template <class D>
FieldRow lawCRow() {
  // clang-format off: a row is read as one
  return {.name = "C", .access = customMember<D, lawC<D>, setLawC<D>>(),
          .help = "constant of visibility = C / K, for threshold mode and visibility fields: 3 for "
                  "reflecting signs, 8 for light-emitting ones", .least = 0, .above = true,
          .choices = lawNames(), .option = {.value = "C", .scene = true},
          .slider = {.label = "visibility C", .least = 1, .most = 10, .custom = addLawC<D>}};
  // clang-format on
}

template <class D>
void addLawC(ParameterGroup& group, const void* description, const MediumFacts& /*facts*/) {
  static const FieldRow kRow = lawCRow<D>();
  group.add(kRow, "C", static_cast<const D*>(description)->law.c);
}

}  // namespace volute
