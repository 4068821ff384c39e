// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/image_name.hpp"

#include <gtest/gtest.h>

#include "volute/capture/testing.hpp"

namespace volute {
namespace {

using testing::failsWith;

TEST(ImageName, FillsInCameraAndFrame) {
  for (const char* number : {"%04d", "####"}) {
    const auto name = ImageName::parse(fmt::format("in/frame_{}_{{camera}}.exr", number)).value();
    EXPECT_EQ(name.file("left", 37), "in/frame_0037_left.exr");
  }
  EXPECT_EQ(ImageName::parse("{camera}/%d.png").value().file("c1", 5), "c1/5.png");
  EXPECT_EQ(ImageName::parse("{camera}.png").value().file("c1", 5), "c1.png");
}

TEST(ImageName, FindsTheCameraInOtherNames) {
  const auto name = ImageName::parse("/x/images/frame_%04d_{camera}.exr").value();
  EXPECT_EQ(name.cameraIn("frame_0037_c0.exr"), "c0");
  EXPECT_EQ(name.cameraIn("images/frame_####_c0.png"), "c0");
  EXPECT_EQ(name.cameraIn("elsewhere/frame_%04d_left.eye.exr"), "left.eye");
  EXPECT_EQ(name.cameraIn("frame_c0.exr"), std::nullopt);
  const auto folders = ImageName::parse("shots/{camera}/%04d.png").value();
  EXPECT_EQ(folders.cameraIn("c3/0001.jpg"), "c3");
  EXPECT_EQ(folders.cameraIn("0001.jpg"), std::nullopt);
}

TEST(ImageName, SignsOfExpressionsAreLetters) {
  const auto name = ImageName::parse("a(1)+[b].{camera}.%d.exr").value();
  EXPECT_EQ(name.cameraIn("a(1)+[b].c.12.exr"), "c");
  EXPECT_EQ(name.cameraIn("a1bXcX12.exr"), std::nullopt);
}

TEST(ImageName, RefusesWhatIsAmbiguous) {
  EXPECT_TRUE(failsWith(ImageName::parse("{camera}/{camera}_%d.png"), "twice"));
  EXPECT_TRUE(failsWith(ImageName::parse("%d_{camera}_%d.png"), "more than one frame number"));
  EXPECT_TRUE(failsWith(ImageName::parse(""), "empty"));
}

TEST(ImageName, ListsFrames) {
  const testing::TempFolder folder;
  for (const char* file : {"3_c.png", "12_c.png", "7_d.png"})
    testing::writeText(folder / file, "x");
  const auto name = ImageName::parse((folder / "%d_{camera}.png").string()).value();
  FolderFiles folders;
  EXPECT_EQ(framesThere(name.ofCamera("c"), folders), (std::vector<int>{3, 12}));
  EXPECT_TRUE(framesThere(name.ofCamera("e"), folders).empty());
}

}  // namespace
}  // namespace volute
