// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "volute/base/output_file.hpp"
#include "volute/visibility/survey.hpp"

namespace volute {

/// sight.csv: one row for each stored time, eye and sign. Lengths in metres, times in seconds,
/// angles in degrees, extinction in 1/m; blocked and visible are 0 or 1.
class SightCsv {
 public:
  [[nodiscard]] static Result<SightCsv> create(const std::filesystem::path& path);

  /// The rows of a time, on all threads. `sightings` as lookAround gives them.
  static std::string rowsOf(double time, std::span<const Vec3> eyes,
                            std::span<const SightTarget> signs,
                            std::span<const Sighting> sightings);

  /// Appends `count` rows.
  [[nodiscard]] Status write(std::string_view rows, std::uint64_t count);

  [[nodiscard]] Status finish() { return file_.commit(); }

  std::uint64_t rows() const { return rows_; }

 private:
  explicit SightCsv(OutputFile file) : file_(std::move(file)) {}

  OutputFile file_;
  std::uint64_t rows_ = 0;
};

}  // namespace volute
