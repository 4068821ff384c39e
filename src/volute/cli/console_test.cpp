// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/console.hpp"

#include <gtest/gtest.h>

namespace volute::cli {
namespace {

TEST(Console, SaysARemarkOnce) {
  Console console("info", Console::Volume::kQuiet);
  for (int i = 0; i < 3; ++i) {
    console.remark({RemarkCode::kLeftOut, "1 s is left out"});
    console.remark(Remark(RemarkCode::kLeftOut, "1 s is left out").in("other.pvd"));
  }
  ASSERT_EQ(console.remarks().size(), 2);
  EXPECT_EQ(console.remarks().front().sentence, "1 s is left out");
}

}  // namespace
}  // namespace volute::cli
