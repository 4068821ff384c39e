// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/team.hpp"
#include "volute/visibility/study.hpp"

namespace volute {

/// What became of the runs of a study.
struct StudyCounts {
  std::size_t done = 0;  ///< now
  std::size_t kept = 0;  ///< were done before and have not changed
  std::size_t failed = 0;
};

/// Which runs of a study are done.
struct StudyChoice {
  std::array<std::size_t, 2> part{1, 1};  ///< {i, n}: every n-th, from the i-th, 1 <= i <= n
  std::optional<std::size_t> only{};      ///< this one, counted from 0, and no table
};

/// What is known of a run in a folder.
struct StudyRunState {
  bool done = false;  ///< and unchanged
  std::string why;    ///< "not run yet", or the sentence with which it failed
};

std::vector<StudyRunState> statesOf(const Study& study, const std::filesystem::path& folder);

/// "2/5" as StudyChoice::part.
[[nodiscard]] Result<std::array<std::size_t, 2>> parsePart(const std::string& text);

/// The runs: for each its number from 1, its name, and what became of it where a folder says so.
struct StudyList {
  Json json;         ///< {"runs": [{"number", "name", "case", "done", "why"}]}
  std::string text;  ///< a line a run
};

StudyList listOf(const Study& study, const std::optional<std::string>& folder);

/// Does the runs of a study into a folder: one for each run, study.csv (a row a run) and compared/
/// with maps of the differences. What is done and unchanged is kept, so that the same call goes on
/// where it was stopped; a run that fails has a sentence in the table, and the others go on. Ranks
/// share the runs, each whole on one of them, and the folder; the table is the same for any number
/// of ranks. Collective; the counts are of all ranks.
/// @param survey  does one run into its folder
[[nodiscard]] Result<StudyCounts> runStudy(
    const Study& study, const StudyChoice& choice, const std::filesystem::path& folder,
    Progress& progress, Team& team,
    const std::function<Status(const StudyRun&, const std::filesystem::path&)>& survey);

}  // namespace volute
