// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/collection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "volute/base/plain_number.hpp"

namespace volute {

std::string contradictionOf(std::span<const CollectedFile> files) {
  constexpr double kRounding = 1e-5;  // relative, of times written in few digits
  std::map<std::filesystem::path, double> known;
  for (const CollectedFile& file : files) {
    const auto [place, isNew] = known.try_emplace(file.path, file.time);
    if (!isNew) {
      return fmt::format("{}: is there at {} s and at {} s: is one of them another file?",
                         file.path.string(), plainNumber(place->second), plainNumber(file.time));
    }
    if (std::isfinite(file.stated) &&
        std::abs(file.stated - file.time) > kRounding * std::max(1.0, std::abs(file.time))) {
      return fmt::format("{}: states {} s itself; the collection's {} s is taken",
                         file.path.string(), plainNumber(file.stated), plainNumber(file.time));
    }
  }
  return "";
}

}  // namespace volute
