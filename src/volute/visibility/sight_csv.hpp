// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "volute/base/output_file.hpp"
#include "volute/visibility/survey.hpp"

namespace volute {

/// What becomes of the table of sightings.
enum class SightFile {
  kAuto,  ///< sight.csv up to 10 MB, above it sight.csv.zst
  kNone,
  kCsv,
  kZst,  ///< sight.csv.zst, by Zstandard
};

/// "auto", "none", "csv" or "csv.zst".
[[nodiscard]] Result<SightFile> sightFile(std::string_view name);

/// sight.csv: one row for each stored time, eye and sign. Lengths in metres, times in seconds,
/// angles in degrees, extinction in 1/m; blocked and visible are 0 or 1, the latter at the field's
/// own depth; seen is yes, no or cannot tell, by the depth's bounds.
class SightCsv {
 public:
  [[nodiscard]] static Result<SightCsv> create(const std::filesystem::path& folder, SightFile kind);

  ~SightCsv();
  SightCsv(SightCsv&&) noexcept;
  SightCsv& operator=(SightCsv&&) = delete;

  /// The rows of a time, on all threads. `sightings` as lookAround gives them.
  static std::string rowsOf(double time, std::span<const Vec3> eyes,
                            std::span<const SightTarget> signs,
                            std::span<const Sighting> sightings);

  /// Appends `count` rows.
  [[nodiscard]] Status write(std::string_view rows, std::uint64_t count);

  /// The name of the file in its folder; empty for none.
  [[nodiscard]] Result<std::string> finish();

  std::uint64_t rows() const { return rows_; }

 private:
  class Zst;

  SightCsv(std::filesystem::path folder, SightFile kind);

  Status addText(std::string_view text);
  Status openFile(SightFile kind);
  Status put(std::string_view text);

  std::filesystem::path folder_;
  SightFile kind_;      // kAuto while that is not decided
  std::string waiting_; // what was written until then
  std::optional<OutputFile> file_;
  std::unique_ptr<Zst> zst_;
  std::uint64_t rows_ = 0;
};

}  // namespace volute
