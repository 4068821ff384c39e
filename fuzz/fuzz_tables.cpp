// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/visibility/eyes.hpp"

// Tables of points, and of people who walk. Errors are fine; places that are no numbers are not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = volute::fuzz::textOf(data, size);
  if (const auto points = volute::parsePoints(text, "points.csv", 2.0)) {
    for (const volute::NamedPoint& point : *points)
      volute::fuzz::require(point.position.allFinite());
    (void)volute::routesOf(*points, "points.csv");
  }
  (void)volute::Trajectories::parse(text, "people.txt", std::nullopt);
  return 0;
}
