// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/scene_arguments.hpp"

#include <gtest/gtest.h>

#include "volute/scene/kinds.hpp"

namespace volute::cli {
namespace {

class AboutOptions : public testing::Test {
 protected:
  AboutOptions() { registerUsualMedia(); }

  /// About a member of the only medium of a scene that a case stands for.
  static Error about(const char* member, const char* path = "a.smv") {
    Error error =
        failIn("a.smv", member, ErrorCode::kInvalidData, "expected {}", "a number").value();
    return aboutOptions(std::move(error), path);
  }
};

TEST_F(AboutOptions, AMembersErrorIsOneOfItsOption) {
  const Error error = about("/media/0/mass_extinction[2]");
  EXPECT_EQ(error.message, "expected a number");
  EXPECT_EQ(error.member, "mass-extinction[2]");
  EXPECT_EQ(error.path, "");
  EXPECT_EQ(error.code, ErrorCode::kInvalidArgument);
}

TEST_F(AboutOptions, TheEntrysErrorIsOneOfTheFile) {
  EXPECT_EQ(about("/media/0").message, "a.smv: expected a number");
}

TEST_F(AboutOptions, OtherErrorsStay) {
  EXPECT_EQ(about("/lights/0").message, "a.smv: /lights/0: expected a number");
  EXPECT_EQ(about("/media/0", "b.smv").message, "a.smv: /media/0: expected a number");
  // Of which the place is not known apart.
  const Error whole = fail(ErrorCode::kIo, "a.smv: /media/0: gone").value();
  EXPECT_EQ(aboutOptions(*Result<Error>(whole), "a.smv").message, whole.message);
}

}  // namespace
}  // namespace volute::cli
