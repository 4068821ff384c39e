// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Run by mpirun -n 4: the team of a communicator of the caller's, who keeps MPI. Ends with 1 and a
// line for each check that failed.
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "volute/base/gather_values.hpp"
#include "volute/cluster/cluster.hpp"

namespace volute {
namespace {

int failures = 0;

void check(bool right, const char* what) {
  if (right)
    return;
  ++failures;
  std::fprintf(stderr, "mpi_team_test: %s\n", what);
}

/// What one rank sends another: of no length, short, or some megabytes.
std::vector<std::int32_t> letter(int from, int to) {
  constexpr std::size_t kSizes[] = {0, 3, 1 << 20};
  std::vector<std::int32_t> values(kSizes[(from + 2 * to) % 3]);
  std::iota(values.begin(), values.end(), 100 * from + to);
  return values;
}

void checkLetters(Team& team) {
  std::vector<std::vector<std::int32_t>> sent;
  for (int to = 0; to < team.size(); ++to) sent.push_back(letter(team.rank(), to));
  const auto received = exchangeValues(team, std::span<const std::vector<std::int32_t>>(sent));
  check(received && static_cast<int>(received->size()) == team.size(), "letters arrive");
  for (int from = 0; received && from < team.size(); ++from)
    check((*received)[static_cast<std::size_t>(from)] == letter(from, team.rank()), "a letter");
}

void checkUnits(Team& team) {
  Progress progress;
  std::uint64_t sum = 0;
  const Status done = team.forUnits(
      "work", 40, progress,
      [&](std::int64_t unit) -> Status {
        sum += static_cast<std::uint64_t>(unit);
        return team.post(
            unit,
            std::vector<std::byte>(static_cast<std::size_t>(50000 * (unit % 3)), std::byte(unit)),
            1 << 20);
      },
      [&]() -> Status {
        for (std::int64_t unit = 0; team.leads() && unit < 40; ++unit) {
          VOLUTE_ASSIGN(const auto bytes, team.collect(unit));
          check(bytes.size() == static_cast<std::size_t>(50000 * (unit % 3)),
                "what is posted is collected");
          check(std::ranges::all_of(bytes, [&](std::byte one) { return one == std::byte(unit); }),
                "bytes that are posted");
        }
        return {};
      });
  check(done.has_value(), "units are done");
  check(team.sum({&sum, 1}).has_value() && sum == 780, "each unit once");
  check(*team.broadcast(10 + team.rank()) == 10, "a broadcast");
}

/// @param size  of the communicator
void checkTeam(MPI_Comm communicator, int size) {
  auto team = teamOf(&communicator);
  check(team && (*team)->size() == size, "a team of the communicator's size");
  if (!team) {
    std::fprintf(stderr, "mpi_team_test: %s\n", team.error().message.c_str());
    return;
  }
  checkLetters(**team);
  checkUnits(**team);
  const bool last = (*team)->rank() == size - 1;
  const Status status =
      (*team)->agree(last ? Status(fail(ErrorCode::kIo, "no such file")) : Status());
  check(!status && status.error().message.ends_with("no such file"), "an error of one is of all");
  check(!(*team)->gatherAll({}), "and stays");
}

}  // namespace
}  // namespace volute

int main(int argc, char** argv) {
  int level = 0, rank = 0, size = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &level);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  volute::check(level == MPI_THREAD_MULTIPLE && size == 4, "four ranks");
  MPI_Comm part = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, rank == 2 ? 1 : 0, -rank, &part);  // three in reverse, and one
  volute::checkTeam(part, rank == 2 ? 1 : 3);
  volute::checkTeam(MPI_COMM_WORLD, 4);
  MPI_Comm_free(&part);
  // MPI is still the caller's.
  int all = 0;
  MPI_Allreduce(&volute::failures, &all, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  MPI_Finalize();
  return all == 0 ? 0 : 1;
}
