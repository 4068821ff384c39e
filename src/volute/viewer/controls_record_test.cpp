// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// No control is left out: what the panels had in any of these tests, one of them has used.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "volute/viewer/controls_testing.hpp"

namespace volute {
namespace {

/// Lines that are marked so that tests find them; and what only a picture that takes long has,
/// which ViewerTest uses.
const std::set<std::string> kNoControls = {"times", "who draws", "stop drawing", "help",
                                           "help is cut"};

TEST_F(Controls, AreCountedByKind) {
  open("smoke.json");
  const DocumentInfo* document = app().document().info();
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

using Names = std::set<std::string>;

/// What tests of controls saw.
struct Seen {
  Names ran, offered, used;

  void add(Seen other) {
    ran.merge(other.ran), offered.merge(other.offered), used.merge(other.used);
  }
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Seen, ran, offered, used)

/// Adds what the other processes of this run of ctest saw until now: they keep it in a file, which
/// the next run begins anew. A program that is started by hand has run them all, or not.
void addOthers(Seen& seen) {
  const char* const path = std::getenv("VOLUTE_CONTROLS_SEEN");
  if (!path)
    return;
  const int file = ::open(path, O_CREAT | O_RDWR | O_CLOEXEC, 0644);
  ASSERT_GE(file, 0) << path;
  ASSERT_EQ(::flock(file, LOCK_EX), 0);
  std::ifstream stream(path);
  const auto others = nlohmann::json::parse(stream, nullptr, false);
  const int run = ::getppid();
  if (others.is_object() && others["run"] == run)
    seen.add(others["seen"].get<Seen>());
  std::ofstream(path) << nlohmann::json{{"run", run}, {"seen", seen}};
  ::close(file);
}

/// Says once all tests of controls have run what none of them has used.
class EveryControl final : public ::testing::Environment {
 public:
  void TearDown() override {
    Names all;
    Seen seen{{}, controlRecord().offered, controlRecord().used};
    const auto& tests = *::testing::UnitTest::GetInstance();
    for (int i = 0; i < tests.total_test_suite_count(); ++i) {
      const auto& suite = *tests.GetTestSuite(i);
      if (!std::string(suite.name()).ends_with("Controls"))
        continue;
      for (int j = 0; j < suite.total_test_count(); ++j) {
        const auto& test = *suite.GetTestInfo(j);
        const std::string name = fmt::format("{}.{}", suite.name(), test.name());
        all.insert(name);
        if (test.should_run() && !test.result()->Skipped())
          seen.ran.insert(name);
      }
    }
    if (seen.ran.empty())
      return;
    addOthers(seen);
    if (!std::ranges::includes(seen.ran, all))
      return;
    for (const std::string& control : seen.offered) {
      EXPECT_TRUE(seen.used.contains(control) || kNoControls.contains(control))
          << control << ": no script of a test uses this control of the viewer; expected one that "
          << "checks what it changes in the picture, and in the file that is saved";
    }
  }
};

[[maybe_unused]] const auto* const kEveryControl =
    ::testing::AddGlobalTestEnvironment(new EveryControl);

}  // namespace
}  // namespace volute
