// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/team_checks.hpp"

#include <fmt/ranges.h>

#include <filesystem>
#include <random>

#include "volute/base/file_name.hpp"
#include "volute/base/write_file.hpp"

namespace volute {

Status checkSameProgram(Team& team, std::string_view version,
                        const std::vector<std::string>& arguments) {
  if (team.size() == 1)
    return {};
  VOLUTE_ASSIGN(const auto versions, team.gatherTexts(version));
  for (std::size_t rank = 1; rank < versions.size(); ++rank) {
    if (versions[rank] != versions[0]) {
      return fail(ErrorCode::kUnsupported,
                  "rank {} is volute {} and rank 0 is volute {}; expected one version everywhere",
                  rank, versions[rank], versions[0]);
    }
  }
  const std::string line = fmt::format("{}", fmt::join(arguments, " "));
  VOLUTE_ASSIGN(const auto lines, team.gatherTexts(line));
  for (std::size_t rank = 1; rank < lines.size(); ++rank) {
    if (lines[rank] != lines[0]) {
      return fail(ErrorCode::kUnsupported,
                  "rank {} was started with '{}' and rank 0 with '{}'; expected the same arguments "
                  "everywhere",
                  rank, lines[rank], lines[0]);
    }
  }
  return {};
}

Status checkFolderIsShared(const std::string& target, Team& team) {
  if (team.size() == 1)
    return {};
  namespace fs = std::filesystem;
  const fs::path folder = folderOf(target);
  VOLUTE_ASSIGN(const auto number, team.broadcast(std::uint64_t{std::random_device()()}));
  const fs::path probe = folder / fmt::format(".volute-{:x}-{}", number, "shared");
  Status status;
  if (team.leads()) {
    status = writeFile(probe, fmt::format("{}", number));
    if (!status) {
      status.error().message =
          fmt::format("{}: cannot be written: {}", target, status.error().message);
    }
  }
  VOLUTE_TRY(team.agree(status));
  std::error_code error;
  Status seen;
  if (!fs::exists(probe, error)) {
    seen = fail(ErrorCode::kIo,
                "on {}, {} is another folder than that of rank 0; expected one that all machines "
                "share",
                team.host(), fs::absolute(folder).string());
  }
  seen = team.agree(seen);
  if (team.leads())
    fs::remove(probe, error);
  return seen;
}

}  // namespace volute
