// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include "volute/io/plugin.hpp"

namespace volute {
namespace {

/// Files of others' formats are read in children of this program, hundreds of them. What is loaded
/// here they find loaded; that they can load it themselves is seen by tests/cli.
class LoadedPlugins final : public ::testing::Environment {
 public:
  void SetUp() override {
    (void)loadVdbPlugin();
    (void)loadVtkPlugin();
  }
};

[[maybe_unused]] const auto* const kLoadedPlugins =
    ::testing::AddGlobalTestEnvironment(new LoadedPlugins);

}  // namespace
}  // namespace volute
