// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <thread>

#include "volute/gl/gl_volume.hpp"
#include "volute/viewer/headless_viewer.hpp"

namespace volute {
namespace {

constexpr int kWidth = 420, kHeight = 300;

std::shared_ptr<const BrickSlice> blob(double middle) {
  VolumeInfo info;
  info.frames = 1, info.x = info.y = info.z = 12;
  info.bounds = {Vec3(0, 0, 0), Vec3(1, 1, 1)};
  std::vector<float> values;
  for (int z = 0; z < 12; ++z) {
    for (int y = 0; y < 12; ++y) {
      for (int x = 0; x < 12; ++x)
        values.push_back(std::max(0.0F, 1 - float(std::hypot(x - middle, y - 5.5, z - 5.5)) / 4));
    }
  }
  return std::make_shared<const BrickSlice>(BrickSlice::fromDense(info, values));
}

/// Two frames of a blob that moves to the right; its slow reading can be held back.
class Blobs final : public Document {
 public:
  DocumentInfo info() const override {
    return {.title = "blobs",
            .bounds = {Vec3(0, 0, 0), Vec3(1, 1, 1)},
            .times = {0, 0.5},
            .grey = true};
  }

  std::vector<std::filesystem::path> files() const override { return {path}; }

  bool coarseHelps(double) const override { return true; }

  Result<ViewScene> sceneAt(const SceneRequest& request, Progress& progress) override {
    if (broken && request.time > 0)
      return fail(ErrorCode::kNotFound, "{}: it is gone", path.string());
    while (!request.coarse && held && !progress.cancelled())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ++scenes;
    return ViewScene{.media = {{glPart(GlVolume{blob(request.time < 0.5 ? 3 : 9), 1, 0})}}};
  }

  std::filesystem::path path;
  static inline std::atomic<bool> held = false, broken = false;
  static inline std::atomic<int> scenes = 0;
};

Result<std::unique_ptr<Document>> openBlobs(const std::string& path, Progress&) {
  if (!std::filesystem::exists(path))
    return fail(ErrorCode::kNotFound, "{}: there is no such file", path);
  auto document = std::make_unique<Blobs>();
  document->path = path;
  return document;
}

class ViewerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto made = HeadlessViewer::create(openBlobs, {.rasteriser = true});
    if (!made)
      GTEST_SKIP() << made.error().message;
    viewer_ = std::move(*made);
    Blobs::held = Blobs::broken = false;
    Blobs::scenes = 0;
    path_ = ::testing::TempDir() + "blobs.txt";
    std::ofstream(path_) << "1";
    input_.width = kWidth, input_.height = kHeight;
    viewer_->app().settings().look.quality = 3;
  }

  void settle() {
    Progress quiet;
    ASSERT_TRUE(viewer_->settle(input_, quiet));
    input_.pressed.clear();
  }

  void press(Key key) {
    input_.pressed = {key};
    ASSERT_TRUE(viewer_->frame(input_));
    input_.pressed.clear();
  }

  ViewerApp& app() { return viewer_->app(); }

  std::unique_ptr<HeadlessViewer> viewer_;
  std::string path_;
  ViewerInput input_;
};

/// Where the light is, from left (0) to right (1).
double centreOf(const Image& image) {
  double sum = 0, moment = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double value = image.at(x, y, 0) > 0.05 ? 1 : 0;
      sum += value;
      moment += value * (x + 0.5) / image.width;
    }
  }
  EXPECT_GT(sum, 50) << "nothing is to be seen";
  return moment / sum;
}

double greatestDifference(const Image& a, const Image& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    largest = std::max<double>(largest, std::abs(a.pixels[i] - b.pixels[i]));
  return largest;
}

TEST_F(ViewerTest, ShowsTheFrameOfItsTime) {
  app().settings().panels = false;
  app().open(path_);
  settle();
  EXPECT_EQ(app().document().error(), "");
  const double before = centreOf(viewer_->picture());
  press(Key::kRight);
  EXPECT_EQ(app().playback().timeline().time(), 0.5);
  settle();
  EXPECT_GT(centreOf(viewer_->picture()), before + 0.1);
}

TEST_F(ViewerTest, TheFirstPictureIsCoarseAndNothingWaits) {
  app().settings().panels = false;
  Blobs::held = true;
  app().open(path_);
  for (int i = 0; i < 2000 && app().view().picture().times().history.empty(); ++i) {
    ASSERT_TRUE(viewer_->frame(input_));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_FALSE(app().view().picture().times().history.empty())
      << "the coarse picture is drawn while the fine one is read";
  EXPECT_FALSE(app().settled());
  Blobs::held = false;
  settle();
  EXPECT_EQ(Blobs::scenes, 2);
}

TEST_F(ViewerTest, PanelsHelpAndKeys) {
  app().open(path_);
  settle();
  const Image panels = viewer_->picture();
  press(Key::kF1);
  settle();
  EXPECT_TRUE(app().settings().help);
  EXPECT_GT(greatestDifference(panels, viewer_->picture()), 0.1);
  press(Key::kEscape);
  press(Key::kH);
  settle();
  const Image bare = viewer_->picture();
  EXPECT_GT(greatestDifference(panels, bare), 0.1);
  press(Key::kPlus);
  settle();
  EXPECT_GT(greatestDifference(bare, viewer_->picture()), 0.05) << "brighter";
  press(Key::kF12);
  EXPECT_TRUE(app().window().takeScreenshotRequest());
  EXPECT_FALSE(app().window().takeScreenshotRequest());
}

TEST_F(ViewerTest, TheMouseTurnsThePictureButNotThroughPanels) {
  app().open(path_);
  settle();
  const Vec3 eye = app().view().camera().eye();
  const auto drag = [&](double x, double y) {
    input_.mouseX = x, input_.mouseY = y;
    ASSERT_TRUE(viewer_->frame(input_));
    ASSERT_TRUE(viewer_->frame(input_));
    input_.buttons[0] = true;
    ASSERT_TRUE(viewer_->frame(input_));
    input_.mouseX += 40;
    ASSERT_TRUE(viewer_->frame(input_));
    input_.buttons[0] = false;
    ASSERT_TRUE(viewer_->frame(input_));
  };
  drag(60, 20);  // the panel's title
  EXPECT_EQ(app().view().camera().eye(), eye);
  drag(kWidth - 60, 40);
  EXPECT_GT((app().view().camera().eye() - eye).norm(), 0.1);
}

TEST_F(ViewerTest, ReloadsAFileThatChanged) {
  app().open(path_);
  settle();
  const int before = Blobs::scenes;
  std::ofstream(path_) << "2";
  std::filesystem::last_write_time(
      path_, std::filesystem::file_time_type::clock::now() + std::chrono::seconds(3));
  for (int i = 0; i < 3000 && Blobs::scenes == before; ++i) {
    ASSERT_TRUE(viewer_->frame(input_));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  settle();
  EXPECT_GT(Blobs::scenes, before);
}

TEST_F(ViewerTest, APictureThatCannotFollowTheTimeIsNotUpToDate) {
  app().open(path_);
  settle();
  Blobs::broken = true;
  app().playback().timeline().seek(0.5);
  const auto work = [&] { return app().window().notes().work(); };
  for (int i = 0; i < 5000 && !work().stale; ++i) {
    ASSERT_TRUE(viewer_->frame(input_));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(work().stale);
  EXPECT_EQ(work().text, "the picture is of 0 s");
  EXPECT_NE(app().document().error(), "");
}

TEST_F(ViewerTest, NothingComesToRestWhileTimePasses) {
  app().open(path_);
  settle();
  app().playback().timeline().play(true);
  Progress quiet;
  const Status playing = viewer_->settle(input_, quiet);
  ASSERT_FALSE(playing);
  EXPECT_EQ(playing.error().code, ErrorCode::kInvalidArgument);
  app().playback().timeline().play(false);
  settle();
}

TEST_F(ViewerTest, WhilePlayingOnlyWhatIsNewIsDrawn) {
  app().settings().panels = false;
  app().settings().look.renderer = static_cast<int>(ViewRenderer::kGl);
  viewer_->drawWholeFrames();
  app().open(path_);
  settle();
  app().playback().timeline().play(true);
  app().playback().timeline().setSpeed(20);  // 40 of its frames in a second
  constexpr double kFrame = 0.01;
  input_.seconds = 0;
  int steps = 0;
  double unseen = 0;
  for (int i = 0; i < 400; ++i) {
    const int before = app().view().picture().state().version;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    input_.seconds += kFrame;
    if (!app().due(input_))
      continue;
    const Image shown = viewer_->picture();
    ASSERT_TRUE(viewer_->frame(input_));
    unseen = viewer_->drew() ? 0 : unseen + input_.seconds;
    input_.seconds = 0;
    EXPECT_LT(unseen, 0.15);
    if (viewer_->drew())
      continue;
    ++steps;
    EXPECT_EQ(app().view().picture().state().version, before);
    EXPECT_EQ(greatestDifference(shown, viewer_->picture()), 0);
  }
  EXPECT_GT(steps, 10);
  press(Key::kSpace);
  settle();
  EXPECT_TRUE(viewer_->drew());
}

TEST_F(ViewerTest, WhatMovesFillsTheWindowAsWhatRests) {
  app().settings().panels = false;
  app().open(path_);
  settle();
  const Image rests = viewer_->picture();
  input_.seconds = 0;
  app().playback().timeline().play(true);
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(viewer_->frame(input_));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const Image moves = viewer_->picture();
  EXPECT_NEAR(centreOf(moves), centreOf(rests), 0.01);
  EXPECT_LT(greatestDifference(rests, moves), 0.15) << "enlarged before and after the tone curve";
}

TEST_F(ViewerTest, AnErrorIsShownAndTheOldPictureStays) {
  app().open(path_);
  settle();
  app().open(path_ + ".missing");
  settle();
  EXPECT_THAT(app().document().error(), ::testing::HasSubstr("there is no such file"));
  ASSERT_NE(app().document().info(), nullptr);
  EXPECT_EQ(app().document().info()->title, "blobs");
}

}  // namespace
}  // namespace volute
