// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/base/team.hpp"
#include "volute/base/version.hpp"

namespace volute {

/// Of what a team is made in memory: of a plug-in and the program that loads it, it must be the
/// same.
struct TeamLayout {
  char version[16] = VOLUTE_VERSION;
  std::uint64_t team = sizeof(Team), record = sizeof(UnitRecord);
  std::uint64_t calls = 2;  ///< counts what Team's virtual functions have been

  bool operator==(const TeamLayout&) const = default;
};

/// Functions of the plug-in that links MPI.
struct MpiPlugin {
  TeamLayout layout;  ///< in front for ever

  /// The team of a communicator (an MPI_Comm*); null: MPI is initialised, and the team has all
  /// processes. Without a team `error` is a sentence.
  std::unique_ptr<Team> (*makeTeam)(const void* communicator, std::string& error);
};

}  // namespace volute
