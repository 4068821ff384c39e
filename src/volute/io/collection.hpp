// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <limits>
#include <span>
#include <string>

namespace volute {

/// A file of a collection (.pvd).
struct CollectedFile {
  std::filesystem::path path;
  double time = 0;                                           ///< [s], the collection's
  double stated = std::numeric_limits<double>::quiet_NaN();  ///< [s], the file's; NaN: none
};

/// What a collection says against its files, as a sentence: a time that the file states otherwise,
/// or one file at two times; empty: nothing.
std::string contradictionOf(std::span<const CollectedFile> files);

}  // namespace volute
