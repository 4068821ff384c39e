// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/ranks.hpp"

#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "volute/base/version.hpp"
#include "volute/base/write_file.hpp"
#include "volute/cluster/cluster.hpp"
#include "volute/cluster/rank_streams.hpp"
#include "volute/report/team_stats.hpp"

namespace volute::cli {

Status checkRanks(const Command& command) {
  const auto launch = launchOfThisProcess();
  if (!launch || launch->size <= 1 || command.ranks)
    return {};
  std::vector<std::string_view> names;
  for (const Command& other : commands()) {
    if (other.ranks)
      names.push_back(other.name);
  }
  return fail(ErrorCode::kInvalidArgument,
              "'{}' is done by one process, and {} were started; leave mpirun out. Several share "
              "the work of {}",
              command.name, launch->size, fmt::join(names, ", "));
}

Result<std::unique_ptr<Team>> openTeamFor(const Command& command,
                                          const std::vector<std::string>& words) {
  if (!command.ranks)
    return std::make_unique<Team>();
  auto team = openTeam();
  if (!team)
    return tl::unexpected<Error>(errorOfThisRank(team.error()));
  if (auto same = checkSameProgram(**team, VOLUTE_VERSION, words); !same) {
    letFirstRankSpeak();
    return tl::unexpected<Error>(std::move(same.error()));
  }
  return team;
}

Option statsOption(std::vector<std::string_view> kinds) {
  return {.name = "stats",
          .kind = ValueKind::kOutput,
          .value = "FILE.json",
          .help = "write statistics: counts, milliseconds, memory, and the work of each rank",
          .kinds = std::move(kinds)};
}

Status writeStats(const Arguments& arguments, Context& context, Json own) {
  const auto target = arguments.find<std::string>("stats");
  if (!target)
    return {};
  VOLUTE_ASSIGN(own["ranks"], teamStats(context.team));
  if (!context.team.leads())
    return {};
  return writeFile(*target, dumpJson(own) + "\n");
}

}  // namespace volute::cli
