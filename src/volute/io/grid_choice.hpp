// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// One grid or array of a file, as far as choosing among them needs to know it.
struct GridEntry {
  std::string name;
  std::string type;     ///< for people: "float", "vec3s", "level set", ...
  bool usable = false;  ///< what GridWords::expected says
};

/// What people call the entries of a file.
struct GridWords {
  const char* noun = "grid";                        ///< one
  std::string usual = "density";                    ///< which one is meant unless it is said
  const char* expected = "a scalar or RGB volume";  ///< what one must be
};

/// Which of `entries` is meant: the one named `wanted`; when that is empty the only usable one,
/// else the usual one. The error lists what there is, and for a wrong name suggests the nearest.
[[nodiscard]] Result<std::size_t> chooseGrid(std::span<const GridEntry> entries,
                                             const std::string& wanted, const std::string& file,
                                             const GridWords& words = {});

/// Calls two of one name, one of cells and one of points, "NAME (cells)" and "NAME (points)".
/// @param ofCells  of each entry
void tellApart(std::span<GridEntry> entries, const std::function<bool(std::size_t)>& ofCells);

/// The names of the other entries that could have been meant, "flame, heat"; cut to `most` bytes.
std::string otherGrids(std::span<const GridEntry> entries, std::size_t chosen, std::size_t most);

/// The names in such a text; those that were cut off are missing.
std::vector<std::string> namesOfGrids(std::string_view others);

}  // namespace volute
