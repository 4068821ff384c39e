// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/base/team.hpp"

namespace volute {

/// What the plug-in that links MPI gives.
struct MpiPlugin {
  /// The team of a communicator (an MPI_Comm*); null: MPI is initialised, and the team has all
  /// processes. Without a team `error` is a sentence.
  std::unique_ptr<Team> (*makeTeam)(const void* communicator, std::string& error);
};

}  // namespace volute
