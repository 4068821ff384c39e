// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "volute/base/team.hpp"

namespace volute {

/// What a launcher of parallel programs (mpirun, srun) told this process in its environment.
struct Launch {
  int rank = 0;
  int size = 1;
  std::string variable;  ///< that says so
  /// Whether the launcher serves MPI, rather than starting copies that know nothing of each other.
  bool mpi = true;
};

/// None when nobody launched it together with others. Needs no MPI.
std::optional<Launch> launchOfThisProcess();

/// The processes that were launched with this one; alone when there are none, or one. MPI is
/// initialised, and finalised when the team ends: make it before threads, once in a process. It
/// comes from the plug-in lib/volute/volute_mpi.so, so that nothing else needs MPI: kUnsupported
/// when that is missing, or when the launcher is not one of that MPI.
[[nodiscard]] Result<std::unique_ptr<Team>> openTeam();

/// The ranks of a communicator of the caller, who has initialised MPI with MPI_THREAD_MULTIPLE and
/// finalises it after the team's end. Collective over the communicator, which is duplicated.
/// @param communicator  points to an MPI_Comm.
[[nodiscard]] Result<std::unique_ptr<Team>> teamOf(const void* communicator);

}  // namespace volute
