// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/work_folder.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <thread>

#include "volute/io/testing.hpp"
#include "volute/tomography/run_key.hpp"

namespace volute {
namespace {

using volute::testing::readBytes;
using volute::testing::TempFolder;
using volute::testing::writeBytes;

TEST(WorkFolder, KeepsFramesUnderTheirKey) {
  const TempFolder folder;
  const std::vector<float> values{0, 0, 1.5f, -2, 0, 0};
  {
    ASSERT_VALUE(const auto work, WorkFolder::open(folder / "out.volute"));
    EXPECT_FALSE(work.any());
    ASSERT_TRUE(volute::testing::ok(work.store(7, "k1", values, {{"iterations", 12}})));
  }
  ASSERT_VALUE(const auto work, WorkFolder::open(folder / "out.volute"));
  EXPECT_TRUE(work.any());
  EXPECT_TRUE(work.has(7, "k1"));
  EXPECT_FALSE(work.has(7, "k2"));
  EXPECT_FALSE(work.has(8, "k1"));
  EXPECT_EQ(work.values(7, "k1", 6).value(), values);
  EXPECT_EQ(work.record(7, "k1").value()["iterations"], 12);
  work.remove();
  EXPECT_FALSE(std::filesystem::exists(folder / "out.volute.work"));
}

TEST(WorkFolder, DamageIsFound) {
  const TempFolder folder;
  ASSERT_VALUE(const auto work, WorkFolder::open(folder / "x"));
  ASSERT_TRUE(volute::testing::ok(work.store(1, "k", std::vector<float>(64, 0.25f), {})));
  EXPECT_FALSE(work.values(1, "k", 63)) << "another size";
  const auto path = folder / "x.work" / "frame_000001.k.values";
  std::string bytes = readBytes(path);
  bytes[bytes.size() / 2] ^= 1;
  writeBytes(path, bytes);
  ASSERT_FALSE(work.values(1, "k", 64));
  EXPECT_NE(work.values(1, "k", 64).error().message.find("is damaged; remove"), std::string::npos);
  EXPECT_FALSE(work.sound(1, "k"));
}

/// What a loss of power leaves of files that are not on the disk yet.
TEST(WorkFolder, FilesOfZerosAreDamaged) {
  const TempFolder folder;
  ASSERT_VALUE(const auto work, WorkFolder::open(folder / "x"));
  for (const char* kind : {"values", "json"}) {
    ASSERT_TRUE(volute::testing::ok(work.store(1, "k", std::vector<float>(64, 0.25f), {})));
    EXPECT_TRUE(work.sound(1, "k"));
    const auto path = folder / "x.work" / fmt::format("frame_000001.k.{}", kind);
    writeBytes(path, std::string(readBytes(path).size(), '\0'));
    EXPECT_FALSE(work.sound(1, "k")) << kind;
    EXPECT_TRUE(work.has(1, "k"));
    EXPECT_NE(work.values(1, "k", 64).error().message.find("is damaged; remove"),
              std::string::npos);
  }
  EXPECT_NE(work.record(1, "k").error().message.find("is damaged; remove"), std::string::npos);
  EXPECT_FALSE(work.sound(2, "k"));
}

TEST(WorkFolder, FilesOfOthersStay) {
  const TempFolder folder;
  ASSERT_VALUE(const auto work, WorkFolder::open(folder / "x"));
  writeBytes(folder / "x.work" / "notes.txt", "mine");
  work.remove();
  EXPECT_TRUE(std::filesystem::exists(folder / "x.work" / "notes.txt"));
}

TEST(WorkFolder, StaysForARunThatGoesOn) {
  const TempFolder folder;
  const std::vector<float> values{1, 2};
  ASSERT_VALUE(const auto empty, WorkFolder::open(folder / "x"));
  EXPECT_FALSE(empty.leave(false));
  EXPECT_FALSE(std::filesystem::exists(folder / "x.work"));
  ASSERT_VALUE(const auto work, WorkFolder::open(folder / "x"));
  ASSERT_TRUE(volute::testing::ok(work.store(1, "k", values, {})));
  EXPECT_TRUE(work.leave(false));
  EXPECT_TRUE(work.any());
  EXPECT_FALSE(work.leave(true));
  EXPECT_FALSE(std::filesystem::exists(folder / "x.work"));
  ASSERT_VALUE(const auto piped, WorkFolder::open("-"));
  ASSERT_TRUE(volute::testing::ok(piped.store(1, "k", values, {})));
  EXPECT_FALSE(piped.leave(false));
  EXPECT_FALSE(std::filesystem::exists(piped.path()));
}

TEST(WorkFolder, TheLastOfTwoRunsRemovesIt) {
  const TempFolder folder;
  const std::vector<float> values{1, 2};
  ASSERT_VALUE(const auto one, WorkFolder::open(folder / "x"));
  {
    ASSERT_VALUE(const auto other, WorkFolder::open(folder / "x"));
    ASSERT_TRUE(volute::testing::ok(other.store(1, "k", values, {{"by", "other"}})));
    EXPECT_TRUE(one.has(1, "k"));
    ASSERT_TRUE(volute::testing::ok(one.store(1, "k2", {}, {{"by", "one"}})));
    EXPECT_FALSE(one.leave(true));
    EXPECT_EQ(other.values(1, "k", 2).value(), values) << "not taken from under the other run";
    EXPECT_EQ(other.record(1, "k").value()["by"], "other");
    EXPECT_FALSE(other.leave(true));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "x.work"));
}

TEST(WorkFolder, ManyRunsComeAndGo) {
  const TempFolder folder;
  std::vector<std::thread> runs;
  std::atomic<int> lost = 0;
  for (int run = 0; run < 4; ++run) {
    runs.emplace_back([&] {
      for (int i = 0; i < 200; ++i) {
        const auto work = WorkFolder::open(folder / "x");
        const bool kept = work && work->store(1, "k", std::vector<float>{1, 2}, {}) &&
                          work->values(1, "k", 2) && work->record(1, "k");
        lost += kept ? 0 : 1;
        if (work)
          work->leave(true);
      }
    });
  }
  for (auto& run : runs) run.join();
  EXPECT_EQ(lost, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "x.work"));
}

TEST(FrameKeys, GoByTheEmptyFrames) {
  Capture capture;
  PictureSource film;
  film.video = "a.mp4";
  const Camera camera = Camera::pinhole({Vec3(1, -6, 2), Vec3(0, 0, 1)}, 30, 64, 48);
  capture.cameras = {{"a", camera, film}};
  capture.frames = {0, 1};
  capture.emptyFrames = {6, 7};
  const auto before = frameKeys(capture, {}, {});
  EXPECT_EQ(frameKeys(capture, {}, {}), before);
  capture.emptyFrames = {8, 9};
  EXPECT_NE(frameKeys(capture, {}, {}), before);
}

TEST(FrameKeys, GoByPicturesThatAreLeftOutAndGainsByFrame) {
  Capture capture;
  PictureSource film;
  film.video = "a.mp4";
  const Camera camera = Camera::pinhole({Vec3(1, -6, 2), Vec3(0, 0, 1)}, 30, 64, 48);
  capture.cameras = {{"a", camera, film}};
  capture.frames = {0, 8};  // each the first of a chain
  const auto before = frameKeys(capture, {}, {});
  capture.cameras[0].pictures.leftOut = {8};
  const auto leftOut = frameKeys(capture, {}, {});
  EXPECT_EQ(leftOut[0], before[0]);
  EXPECT_NE(leftOut[1], before[1]);
  capture.cameras[0].pictures = film;
  capture.cameras[0].pictures.gainByFrame = true;
  const auto byFrame = frameKeys(capture, {}, {});
  EXPECT_NE(byFrame[0], before[0]);
  EXPECT_NE(byFrame[1], before[1]);
}

TEST(WorkFolder, Digests) {
  EXPECT_EQ(digestOf(""), "cbf29ce484222325");
  EXPECT_EQ(digestOf("a"), "af63dc4c8601ec8c");  // from the authors of FNV
}

}  // namespace
}  // namespace volute
