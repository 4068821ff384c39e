// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cluster/cluster.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

// What mpirun does is tested from outside, by tests/cli/cluster_test.py.

namespace volute {
namespace {

using testing::HasSubstr;

class Cluster : public testing::Test {
 protected:
  static constexpr const char* kVariables[] = {"OMPI_COMM_WORLD_RANK",
                                               "OMPI_COMM_WORLD_SIZE",
                                               "PMI_RANK",
                                               "PMI_SIZE",
                                               "PMIX_RANK",
                                               "SLURM_STEP_NUM_TASKS",
                                               "SLURM_PROCID",
                                               "VOLUTE_PLUGIN_FOLDER"};

  void SetUp() override { clear(); }

  void TearDown() override { clear(); }

  static void clear() {
    for (const char* variable : kVariables) ::unsetenv(variable);
  }
};

TEST_F(Cluster, AloneNeedsNoMpi) {
  EXPECT_FALSE(launchOfThisProcess());
  const auto team = openTeam();
  ASSERT_TRUE(team);
  EXPECT_EQ((*team)->size(), 1);
}

TEST_F(Cluster, OneOfOneNeedsNoMpi) {
  ::setenv("OMPI_COMM_WORLD_RANK", "0", 1);
  ::setenv("OMPI_COMM_WORLD_SIZE", "1", 1);
  EXPECT_EQ((*openTeam())->size(), 1);
}

TEST_F(Cluster, NonsenseInTheEnvironmentIsNoLaunch) {
  ::setenv("OMPI_COMM_WORLD_RANK", "zero", 1);
  ::setenv("OMPI_COMM_WORLD_SIZE", "-4", 1);
  EXPECT_FALSE(launchOfThisProcess());
}

// srun without MPI starts copies that would overwrite each other's results.
TEST_F(Cluster, CopiesThatKnowNothingOfEachOtherAreRefused) {
  ::setenv("SLURM_PROCID", "2", 1);
  ::setenv("SLURM_STEP_NUM_TASKS", "4", 1);
  const auto launch = launchOfThisProcess();
  ASSERT_TRUE(launch);
  EXPECT_EQ(launch->rank, 2);
  EXPECT_FALSE(launch->mpi);
  const auto team = openTeam();
  ASSERT_FALSE(team);
  EXPECT_THAT(team.error().message, HasSubstr("PMIx"));
}

}  // namespace
}  // namespace volute
