// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

class SightPacker;

/// The rows of one stored time as they go into the table.
struct SightRows {
  std::uint64_t count = 0;  ///< of rows
  bool packed = false;      ///< `bytes` are blocks of a Zstandard frame instead of text
  std::uint64_t textSize = 0;
  std::string bytes;
};

/// Makes the rows of stored times on all threads, on any rank. The bytes depend on the time alone,
/// not on threads or ranks: times with many rows are compressed in pieces of a fixed number of
/// rows, unless plain text is requested.
class SightRowMaker {
 public:
  explicit SightRowMaker(SightFile kind);
  ~SightRowMaker();
  SightRowMaker(SightRowMaker&&) noexcept;
  SightRowMaker& operator=(SightRowMaker&&) = delete;

  /// `sightings` as lookAround gives them; no bytes for SightFile::kNone.
  [[nodiscard]] Result<SightRows> make(double time, std::span<const Vec3> eyes,
                                       std::span<const SightTarget> signs,
                                       std::span<const Sighting> sightings);

  /// From how many rows on a time is packed.
  static constexpr std::uint64_t kManyRows = 32768;

 private:
  SightFile kind_;
  std::unique_ptr<SightPacker> packer_;
};

/// sight.csv: one row for each stored time, eye and sign. Lengths in metres, times in seconds,
/// angles in degrees, extinction in 1/m; blocked and visible are 0 or 1, the latter at the field's
/// own depth; seen is yes, no or cannot tell, by the depth's bounds.
class SightCsv {
 public:
  [[nodiscard]] static Result<SightCsv> create(const std::filesystem::path& folder, SightFile kind);

  ~SightCsv();
  SightCsv(SightCsv&&) noexcept;
  SightCsv& operator=(SightCsv&&) = delete;

  /// Appends rows that a SightRowMaker of the same kind made.
  [[nodiscard]] Status write(SightRows rows);

  /// The name of the file in its folder; empty for none.
  [[nodiscard]] Result<std::string> finish();

  std::uint64_t rows() const { return rows_; }

 private:
  class Zst;

  SightCsv(std::filesystem::path folder, SightFile kind);

  Status add(SightRows rows);
  Status openFile(SightFile kind);
  Status put(const SightRows& rows);
  Status putWaiting();

  std::filesystem::path folder_;
  SightFile kind_;                  // kAuto while that is not decided
  std::vector<SightRows> waiting_;  // what was written until then
  std::uint64_t waitingSize_ = 0;   // of its text [bytes]
  std::optional<OutputFile> file_;
  std::unique_ptr<Zst> zst_;
  std::uint64_t rows_ = 0;
};

}  // namespace volute
