// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/report/json.hpp"
#include "volute/visibility/floor_plan.hpp"

// Many surveys: a case with several criteria, or many cases.

namespace volute {

/// One survey of a study.
struct StudyRun {
  std::string name;  ///< of its folder; of letters, digits, - and _ and .
  std::string casePath;
  std::string variant;             ///< empty: the study has none
  std::vector<std::string> words;  ///< options of `volute visibility`, but for -o
};

/// STUDY.json: {"cases": ["a.smv", "folder"], "options": {"signs": "signs.json", "height": 2},
/// "variants": [{"name": "C3", "options": {"criteria": "strict.json"}}], "baseline": NAME}. A
/// folder stands for all .smv files in and below it. Each case is looked at with each variant;
/// options of a variant go before those of a case ({"case": "a.smv", "name": "a", "options": {..}})
/// and those before the study's. Values are texts, numbers, true, or lists of them. Files are found
/// from the study's folder.
struct Study {
  std::vector<StudyRun> runs;
  std::string baseline;  ///< a run's name; empty: the first

  /// Errors name the place in the file.
  [[nodiscard]] static Result<Study> read(const std::string& file);
};

/// What the runs found, row by row, and how they differ.
class StudyResults {
 public:
  explicit StudyResults(std::string baseline) : baseline_(std::move(baseline)) {}

  /// From the visibility.json in a run's folder, and those of its storeys; nothing is added where
  /// one is damaged.
  [[nodiscard]] Status add(const StudyRun& run, const std::filesystem::path& folder);
  void addFailure(const StudyRun& run, const std::string& sentence);

  /// Comma-separated: a row a run, in the order in which they came.
  std::string table() const;

  /// ASET minus the baseline's for each run with the same plan, as NAME_difference.vti and .png,
  /// and the least, the mean, the largest and the spread over all of these as spread.vti. If the
  /// baseline has several storeys, each is compared with the same height of other runs:
  /// NAME_z_4.8_difference.vti, spread_z_4.8.vti. Returns sentences about runs that cannot be
  /// compared.
  [[nodiscard]] Result<std::vector<std::string>> compare(const std::filesystem::path& folder) const;

 private:
  struct Plan {
    std::string run;
    std::string storey;  ///< the name of its folder in the run's; empty: the run has one plan
    FloorPlan plan;
    std::vector<float> aset;  ///< NaN where nobody stands, infinite where nothing is lost
    double end = 0;           ///< the last time

    float timeAt(std::size_t i) const;
  };

  /// Plans of the same places, that of the baseline among them.
  struct Comparison {
    const Plan* base = nullptr;
    std::vector<const Plan*> plans;
    std::string name;  ///< "_z_4.8" of one storey of several, else empty
  };

  void addResult(const StudyRun& run, const Json& json, std::span<const Json> storeys);
  void put(std::map<std::string, std::string>& row, const std::string& column, std::string value);
  static std::optional<Plan> planOf(const std::string& run, const Json& json);
  std::vector<Comparison> comparisons(std::vector<std::string>& remarks) const;
  static Status writeDifference(const Plan& plan, const Comparison& comparison,
                                const std::filesystem::path& folder);
  static Status writeSpread(const Comparison& comparison, const std::filesystem::path& folder);

  std::string baseline_;
  std::vector<std::string> columns_;
  std::vector<std::map<std::string, std::string>> rows_;
  std::vector<Plan> plans_;
};

}  // namespace volute
