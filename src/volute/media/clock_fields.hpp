// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/media/clock.hpp"
#include "volute/media/field_members.hpp"

namespace volute {

/// "time" of a medium.
const FieldTable& clockFields();

/// The row of a medium whose clock this is.
template <auto... path>
FieldRow clockField();

/// For sight lines, which are of a case's own times: kInvalidArgument for a medium with others.
[[nodiscard]] Status checkOwnTimes(const Clock& clock, const FieldOrigin& origin);

/// Its sliders, where there is more than one frame.
void addClock(ParameterGroup& group, const void* clock, const MediumFacts& facts);

template <auto... path>
FieldRow clockField() {
  return {.name = "time",
          .type = FieldType::kObject,
          .access = part<path...>(),
          .help =
              "the medium's time: offset + rate * the scene's time; wind follows the scene's "
              "time",
          .table = &clockFields(),
          .slider = {.custom = addClock}};
}

}  // namespace volute
