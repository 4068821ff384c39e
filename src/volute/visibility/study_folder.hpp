// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <filesystem>
#include <functional>

#include "volute/base/progress.hpp"
#include "volute/visibility/study.hpp"

namespace volute {

/// What became of the runs of a study.
struct StudyCounts {
  std::size_t done = 0;  ///< now
  std::size_t kept = 0;  ///< were done before and have not changed
  std::size_t failed = 0;
};

/// Does the runs of a study into a folder: one for each run, study.csv (a row a run) and compared/ with
/// maps of the differences. What is done and unchanged is kept, so that the same call goes on where
/// it was stopped; a run that fails has a sentence in the table, and the others go on.
/// @param part  {i, n}: every n-th run alone, from the i-th, 1 <= i <= n
/// @param survey  does one run into its folder
[[nodiscard]] Result<StudyCounts> runStudy(
    const Study& study, const std::array<std::size_t, 2>& part, const std::filesystem::path& folder,
    Progress& progress,
    const std::function<Status(const StudyRun&, const std::filesystem::path&)>& survey);

}  // namespace volute
