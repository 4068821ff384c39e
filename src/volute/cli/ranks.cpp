// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/ranks.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <thread>

#include "volute/base/memory.hpp"
#include "volute/base/output_file.hpp"
#include "volute/base/version.hpp"
#include "volute/base/write_file.hpp"
#include "volute/cli/interrupt.hpp"
#include "volute/cluster/cluster.hpp"

namespace volute::cli {
namespace {

int realStandardError = STDERR_FILENO;

bool isOtherRank() {
  const auto launch = launchOfThisProcess();
  return launch && launch->size > 1 && launch->rank > 0;
}

/// An error that all ranks have is said by the first, whose end ends the others; what is left to
/// say after that is about this machine.
tl::unexpected<Error> sayLate(Error error) {
  if (isOtherRank()) {
    letFirstRankSpeak();
    if (!Interrupt::requested())
      ::dup2(realStandardError, STDERR_FILENO);
    error.message = fmt::format("rank {}: {}", launchOfThisProcess()->rank, error.message);
  }
  return tl::unexpected<Error>(std::move(error));
}

/// Fails on all ranks alike.
Status checkSame(Team& team, const std::vector<std::string>& words) {
  if (team.size() == 1)
    return {};
  VOLUTE_ASSIGN(const auto versions,
                team.gatherTexts(VOLUTE_VERSION));
  for (std::size_t rank = 1; rank < versions.size(); ++rank) {
    if (versions[rank] != versions[0]) {
      return fail(ErrorCode::kUnsupported,
                  "rank {} is volute {} and rank 0 is volute {}; expected one version everywhere",
                  rank, versions[rank], versions[0]);
    }
  }
  const std::string line = fmt::format("{}", fmt::join(words, " "));
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

Json statsOf(const Team& team) {
  Json units = Json::object();
  Json stages = Json::object();
  for (const UnitRecord& record : team.units()) {
    units[record.stage] = record.units;
    stages[record.stage] = {{"seconds", record.seconds}, {"cpu_seconds", record.cpuSeconds}};
  }
  return {{"rank", team.rank()},
          {"host", team.host()},
          {"units", std::move(units)},
          {"stages", std::move(stages)},
          {"waited_seconds", team.waited()},
          {"cpu_seconds", cpuSeconds()},
          {"peak_memory_bytes", peakMemoryBytes()}};
}

}  // namespace

void silenceOtherRanks() {
  if (!isOtherRank())
    return;
  realStandardError = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  if (const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC); null >= 0) {
    ::dup2(null, STDOUT_FILENO);
    ::dup2(null, STDERR_FILENO);
    ::close(null);
  }
}

void letFirstRankSpeak() {
  for (int i = 0; i < 150 && isOtherRank() && !Interrupt::requested(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

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
    return sayLate(team.error());
  VOLUTE_TRY(checkSame(**team, words));
  return team;
}

Option statsOption(std::vector<std::string_view> kinds) {
  return {.name = "stats",
          .kind = ValueKind::kOutput,
          .value = "FILE.json",
          .help = "write what was done: counts, milliseconds, memory, and the units of each rank",
          .kinds = std::move(kinds)};
}

Status writeStats(const Arguments& arguments, Context& context, Json own) {
  const auto target = arguments.find<std::string>("stats");
  if (!target)
    return {};
  VOLUTE_ASSIGN(const auto all,
                context.team.gatherTexts(statsOf(context.team).dump()));
  if (!context.team.leads())
    return {};
  own["ranks"] = Json::array();
  for (const std::string& text : all) own["ranks"].push_back(Json::parse(text));
  return writeFile(*target, dumpJson(own) + "\n");
}

Status checkFolderIsShared(const std::string& target, Team& team) {
  if (team.size() == 1)
    return {};
  namespace fs = std::filesystem;
  const fs::path folder =
      fs::path(target).has_parent_path() ? fs::path(target).parent_path() : fs::path(".");
  VOLUTE_ASSIGN(const auto number, team.broadcast(std::uint64_t{std::random_device()()}));
  const fs::path probe = folder / fmt::format(".volute-{:x}-{}", number, "shared");
  Status status;
  if (team.leads()) {
    status = writeFile(probe, fmt::format("{}", number));
    if (!status) {
      status.error().message = fmt::format("{}: cannot be written: {}", target,
                                           status.error().message);
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

}  // namespace volute::cli
