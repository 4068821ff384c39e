// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/media/field.hpp"
#include "volute/optics/visibility.hpp"

// What a member "C" may be: a number, or the name of a visibility law.

namespace volute {

inline std::span<const std::string_view> lawNames() {
  static const auto kNames = [] {
    std::vector<std::string_view> names;
    for (const VisibilityLaw& law : visibilityLaws()) names.push_back(law.name);
    return names;
  }();
  return kNames;
}

inline Result<VisibilityLaw> lawOf(const FieldValue& value) {
  return visibilityLaw(value.is_string() ? value.get<std::string>() : value.dump());
}

}  // namespace volute
