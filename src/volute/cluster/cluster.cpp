// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cluster/cluster.hpp"

#include <cstdlib>
#include <cstring>

#include "volute/base/number_word.hpp"
#include "volute/cluster/mpi_plugin.hpp"
#include "volute/io/plugin.hpp"

namespace volute {
namespace {

struct Launcher {
  const char* rank;
  const char* size;
  bool mpi;
};

// OpenMPI's mpirun; MPICH's and Intel's; srun, with PMI or PMIx and without.
constexpr Launcher kLaunchers[] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", true},
                                   {"PMI_RANK", "PMI_SIZE", true},
                                   {"PMIX_RANK", "SLURM_STEP_NUM_TASKS", true},
                                   {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS", false}};

std::optional<int> numberIn(const char* variable) {
  const char* text = std::getenv(variable);
  int number = 0;
  return text && readNumber(text, number) && number >= 0 ? std::optional(number) : std::nullopt;
}

Result<std::unique_ptr<Team>> makeTeam(const void* communicator) {
  auto loaded = loadPlugin("volute_mpi", "voluteMpiPlugin", "MPI");
  if (!loaded) {
    return fail(ErrorCode::kUnsupported,
                "{}; build Volute with VOLUTE_WITH_MPI=ON, or start it without mpirun",
                loaded.error().message);
  }
  const auto& plugin = *static_cast<const MpiPlugin*>(*loaded);
  if (!(plugin.layout == TeamLayout())) {
    return fail(
        ErrorCode::kUnsupported,
        "the plug-in volute_mpi.so was built with another Volute than this program; install "
        "or build both together");
  }
  std::string error;
  auto team = plugin.makeTeam(communicator, error);
  if (!team)
    return fail(ErrorCode::kUnsupported, "{}", error);
  return team;
}

}  // namespace

std::optional<Launch> launchOfThisProcess() {
  for (const Launcher& launcher : kLaunchers) {
    const auto rank = numberIn(launcher.rank), size = numberIn(launcher.size);
    if (rank && size)
      return Launch{*rank, *size, launcher.size, launcher.mpi};
  }
  return std::nullopt;
}

Result<std::unique_ptr<Team>> openTeam() {
  const auto launch = launchOfThisProcess();
  if (!launch || launch->size <= 1)
    return std::make_unique<Team>();
  if (!launch->mpi) {
    return fail(ErrorCode::kUnsupported,
                "{} says that {} processes were started, but not by MPI, so they would all do the "
                "same; start them with mpirun or srun (of its PMIx kind), or one alone",
                launch->variable, launch->size);
  }
  VOLUTE_ASSIGN(auto team, makeTeam(nullptr));
  if (team->size() != launch->size) {
    return fail(ErrorCode::kUnsupported,
                "{} says that {} processes were started, and MPI knows of {}: the launcher belongs "
                "to another MPI than the one that Volute was built with; use that one's mpirun",
                launch->variable, launch->size, team->size());
  }
  return team;
}

Result<std::unique_ptr<Team>> teamOf(const void* communicator) {
  return makeTeam(communicator);
}

}  // namespace volute
