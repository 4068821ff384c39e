// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_files.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "volute/base/program.hpp"
#include "volute/fds/fds_writer.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

/// Four meshes in a row, each with a slice and a smoke file of three frames, and PLOT3D at 10 s.
SmvIndex saveFour(const ScratchFolder& folder) {
  fdswriter::Index index;
  for (int mesh = 1; mesh <= 4; ++mesh) {
    const double x = 2.0 * mesh;
    const fdswriter::Planes planes{{{x, x + 1, x + 2}, {0, 1}, {0, 1}}};
    index.meshes.push_back({planes, {}, {}});
    const fdswriter::Slice slice{{0, 2, 0, 1, 0, 1}};
    std::vector<std::pair<float, std::vector<float>>> frames;
    std::vector<std::pair<float, std::vector<std::uint8_t>>> bytes;
    for (const float time : {0.0F, 5.0F, 10.0F}) {
      frames.emplace_back(time, std::vector<float>(12, time));
      bytes.emplace_back(time, std::vector<std::uint8_t>(12, 7));
    }
    const std::string name = fmt::format("made_{}", mesh);
    fdswriter::sliceFile(slice, frames).save(folder / (name + ".sf"));
    fdswriter::smokeFile({2, 1, 1}, bytes).save(folder / (name + ".s3d"));
    fdswriter::plotFile({2, 1, 1}, std::vector<float>(60, 1)).save(folder / (name + ".q"));
    index.slice(mesh, slice, name + ".sf", false);
    index.smoke(mesh, name + ".s3d", 8700);
    index.plot(mesh, 10, name + ".q", "SOOT EXTINCTION COEFFICIENT");
  }
  index.save(folder / "made.smv");
  return *SmvIndex::read(folder / "made.smv");
}

const FdsFileCheck& find(const std::vector<FdsFileCheck>& checks, const std::string& name) {
  return *std::ranges::find_if(
      checks, [&](const FdsFileCheck& check) { return check.path.filename() == name; });
}

TEST(FdsFiles, wholeOnesAreWhole) {
  const ScratchFolder folder;
  const auto checks = checkFiles(saveFour(folder));
  ASSERT_THAT(checks, SizeIs(12));
  for (const FdsFileCheck& check : checks) {
    EXPECT_EQ(check.state, FdsFileState::kWhole) << check.path << check.reason;
    EXPECT_EQ(check.times.size(), check.kind.starts_with("PLOT3D") ? 1 : 3) << check.path;
    EXPECT_TRUE(check.reason.empty());
  }
}

TEST(FdsFiles, otherFilesAreLookedForToo) {
  const ScratchFolder folder;
  saveFour(folder);
  std::string text;
  std::ifstream in(folder / "made.smv");
  text.assign(std::istreambuf_iterator<char>(in), {});
  text = "CSVF\n hrr\n made_hrr.csv\n\n" + text +
         "\nBNDF     2     1\n made_2_1.bf\n WALL TEMPERATURE\n temp\n C\n"
         "PRT5     3\n made_3.prt5\n 1\n 1 0\n";
  fdswriter::saveText(folder / "made.smv", text);
  fdswriter::saveText(folder / "made_hrr.csv", "s,kW\n");
  fdswriter::saveText(folder / "made_2_1.bf", "");
  const auto checks = checkFiles(*SmvIndex::read(folder / "made.smv"));
  ASSERT_THAT(checks, SizeIs(15));
  EXPECT_EQ(find(checks, "made_hrr.csv").state, FdsFileState::kWhole);
  EXPECT_EQ(find(checks, "made_2_1.bf").state, FdsFileState::kEmpty);
  EXPECT_EQ(find(checks, "made_2_1.bf").mesh, 1);
  EXPECT_EQ(find(checks, "made_3.prt5").state, FdsFileState::kMissing);
}

TEST(FdsFiles, eachLossIsToldApart) {
  const ScratchFolder folder;
  const SmvIndex index = saveFour(folder);
  const auto cut = [&](const std::string& name, std::uintmax_t bytes) {
    fs::resize_file(folder / name, bytes);
  };
  const auto size = fs::file_size(folder / "made_1.sf");
  constexpr std::uintmax_t kFrame = (4 + 8) + (4 * 12 + 8);
  cut("made_1.sf", size - kFrame);          // between frames
  cut("made_2.sf", size - 2 * kFrame + 3);  // within one
  cut("made_3.sf", 50);
  fs::remove(folder / "made_3.s3d");
  cut("made_4.s3d", fs::file_size(folder / "made_4.s3d") - 1);
  fs::remove(folder / "made_2.q");
  fdswriter::saveBytes(folder / "made_1.s3d", std::vector<std::uint8_t>(100, 9));
  const auto checks = checkFiles(index);
  const auto expect = [&](const std::string& name, FdsFileState state, std::size_t frames) {
    const FdsFileCheck& check = find(checks, name);
    EXPECT_EQ(check.state, state) << name << " is " << nameOf(check.state) << ": " << check.reason;
    EXPECT_EQ(check.times.size(), frames) << name;
    EXPECT_EQ(check.reason.empty(), state == FdsFileState::kWhole) << name;
  };
  expect("made_1.sf", FdsFileState::kShort, 2);
  expect("made_2.sf", FdsFileState::kTruncated, 1);
  expect("made_3.sf", FdsFileState::kEmpty, 0);
  expect("made_4.sf", FdsFileState::kWhole, 3);
  expect("made_1.s3d", FdsFileState::kDamaged, 0);
  expect("made_2.s3d", FdsFileState::kWhole, 3);
  expect("made_3.s3d", FdsFileState::kMissing, 0);
  expect("made_4.s3d", FdsFileState::kTruncated, 2);
  expect("made_2.q", FdsFileState::kMissing, 0);
  EXPECT_THAT(
      find(checks, "made_1.sf").reason,
      HasSubstr(
          "has fewer frames (2, the last at 5 s) than made_4.sf (mesh 4: 3, the last at 10 s)"));
}

}  // namespace
}  // namespace volute
