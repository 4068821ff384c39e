// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// No control is left out: what the panels had in any of these tests, one of them has used.
#include "volute/viewer/controls_testing.hpp"

namespace volute {
namespace {

/// Lines that are marked so that tests find them.
const std::set<std::string> kNoControls = {"times", "who draws"};

TEST_F(Controls, AreCountedByKind) {
  open("smoke.json");
  const DocumentInfo* document = app().document();
  const auto kind = [&](const char* control) { return ControlRecord::kindOf(control, document); };
  EXPECT_EQ(kind("exposure"), "exposure");
  EXPECT_EQ(kind("quality = half"), "quality");
  EXPECT_EQ(kind("/media/0/C"), "smoke /media/N/C");
  EXPECT_EQ(kind("/signs/0/normal elevation"), "sign /signs/N/normal elevation");
  EXPECT_EQ(kind("/signs/0/size/1"), "sign /signs/N/size/1");
  EXPECT_EQ(kind("/lights/1/angle"), "spot /lights/N/angle");
  EXPECT_EQ(kind("remove /lights/12"), "remove /lights/N");
  EXPECT_EQ(kind("group sign: exit 2"), "group");
  EXPECT_EQ(kind("look from b"), "look from");
}

/// Says once all tests of controls have run what none of them has used.
class EveryControl final : public ::testing::Environment {
 public:
  void TearDown() override {
    if (!allRan())
      return;
    const ControlRecord& record = controlRecord();
    for (const std::string& control : record.offered) {
      EXPECT_TRUE(record.used.contains(control) || kNoControls.contains(control))
          << control << ": no script of a test uses this control of the viewer; expected one that "
          << "checks what it changes in the picture, and in the file that is saved";
    }
  }

 private:
  static bool allRan() {
    const auto& tests = *::testing::UnitTest::GetInstance();
    for (int i = 0; i < tests.total_test_suite_count(); ++i) {
      const auto& suite = *tests.GetTestSuite(i);
      if (!std::string(suite.name()).ends_with("Controls"))
        continue;
      for (int j = 0; j < suite.total_test_count(); ++j) {
        const auto& test = *suite.GetTestInfo(j);
        if (!test.should_run() || test.result()->Skipped())
          return false;
      }
    }
    return true;
  }
};

[[maybe_unused]] const auto* const kEveryControl =
    ::testing::AddGlobalTestEnvironment(new EveryControl);

}  // namespace
}  // namespace volute
