// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>

#include "volute/base/result.hpp"

namespace volute {

/// One grid or array of a file, as far as choosing among them needs to know it.
struct GridEntry {
  std::string name;
  std::string type;     ///< for people: "float", "vec3s", "level set", ...
  bool usable = false;  ///< a scalar or RGB volume
};

/// Which of `entries` is meant: the one named `wanted`; when that is empty the only usable one,
/// else the one called `usual`. The error lists what there is, and for a wrong name suggests the
/// nearest. `noun` is what people call an entry, and the option that names one.
[[nodiscard]] Result<std::size_t> chooseGrid(std::span<const GridEntry> entries,
                                             const std::string& wanted, const std::string& file,
                                             const char* noun = "grid",
                                             const std::string& usual = "density");

}  // namespace volute
