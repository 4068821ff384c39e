// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/cpu_thread.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace volute {
namespace {

constexpr int kWide = 320, kTall = 240;

/// Where each pixel's ray goes: a rectangle of a picture is the picture of its camera.
Image directions(const Camera& camera, double brighter = 0) {
  Image image(camera.width(), camera.height());
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Vec3 along = camera.ray(x + 0.5, y + 0.5).direction;
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(along[c] + brighter);
    }
  }
  return image;
}

/// Seconds that pass as pictures are taken, however busy the machine is.
std::atomic<double> seconds = 0;

/// Takes so many of them for each pixel, in steps between which it can be stopped.
CpuPicture slowly(double aPixel, std::atomic<int>* pictures = nullptr,
                  std::atomic<int>* begun = nullptr) {
  return [=](const Camera& camera, Progress& progress) -> Result<Image> {
    if (begun)
      ++*begun;
    const double whole = aPixel * camera.width() * camera.height();
    const int steps = std::max(static_cast<int>(1000 * whole), 1);
    for (int i = 0; i < steps; ++i) {
      if (progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped");
      seconds.fetch_add(whole / steps);
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    if (pictures)
      ++*pictures;
    return directions(camera);
  };
}

CpuJob jobOf(CpuPicture take, double first = 0.25) {
  ViewCamera camera;
  camera.set({Vec3(1, -4, 2), Vec3(0, 0, 0.5)});
  return {.take = std::move(take),
          .camera = camera,
          .width = kWide,
          .height = kTall,
          .first = first,
          .number = 1,
          .time = 2.5};
}

/// A thread whose parts are collected as they are delivered, and what a window makes of them.
struct Shown {
  std::vector<CpuPart> parts{};
  int width = 0, height = 0;
  std::vector<float> rgba{};
  std::optional<CpuProgress> begun{};  ///< as the first tile came

  Shown() {
    thread.onDelivery([this] {
      auto delivered = thread.take();
      const std::lock_guard lock(mutex_);
      for (auto& part : delivered) {
        if (part && part->scale == 1 && !part->complete && !begun)
          begun = thread.progress();
        waiting_.push_back(std::move(part));
      }
    });
  }

  void take(CpuPart part) {
    if (part.partWidth == part.width && part.partHeight == part.height) {
      width = part.width, height = part.height;
      rgba = part.rgba;
    } else {
      ASSERT_EQ(part.width, width);
      for (int y = 0; y < part.partHeight; ++y)
        std::copy_n(&part.rgba[4 * static_cast<std::size_t>(y) * part.partWidth],
                    4 * part.partWidth,
                    &rgba[4 * (static_cast<std::size_t>(part.top + y) * width + part.left)]);
    }
    parts.push_back(std::move(part));
  }

  /// Part by part until `done`, or too long.
  template <class Done>
  bool until(const Done& done) {
    for (int i = 0; i < 20000 && !done(); ++i) {
      if (auto part = next()) {
        EXPECT_TRUE(*part) << part->error().message;
        take(std::move(**part));
      } else {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    }
    return done();
  }

  bool fine() const { return !parts.empty() && parts.back().scale == 1 && parts.back().complete; }

 private:
  std::optional<Result<CpuPart>> next() {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty())
      return std::nullopt;
    std::optional<Result<CpuPart>> part(std::move(waiting_.front()));
    waiting_.pop_front();
    return part;
  }

  std::mutex mutex_;
  std::deque<Result<CpuPart>> waiting_;

 public:
  CpuThread thread{[] { return seconds.load(); }};  // last: it delivers to the others
};

TEST(CpuThread, IsCoarseFirstAndFineAtLast) {
  Shown shown;
  shown.thread.request(jobOf(slowly(1e-7)));
  ASSERT_TRUE(shown.until([&] { return shown.fine(); }));
  EXPECT_EQ(shown.parts.front().scale, 0.25);
  EXPECT_EQ(shown.parts.front().time, 2.5);
  EXPECT_EQ(shown.parts.size(), 2) << "it does not take long: nothing between";
}

TEST(CpuThread, TilesAreThePicture) {
  Shown shown;
  const CpuJob job = jobOf(slowly(1e-5));
  shown.thread.request(job);
  ASSERT_TRUE(shown.until([&] { return shown.fine(); }));
  EXPECT_GT(shown.parts.size(), 4);
  const Image whole = directions(job.camera.camera(kWide, kTall));
  float off = 0;
  for (std::size_t i = 0; i < whole.pixels.size() / 3; ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      off = std::max(off, std::abs(whole.pixels[3 * i + c] - shown.rgba[4 * i + c]));
  }
  EXPECT_LT(off, 1e-6);
}

TEST(CpuThread, WhatHasNotComeYetShowsWhatWasThere) {
  Shown shown;
  const CpuJob job = jobOf(slowly(1e-5));
  shown.thread.request(job);
  const auto begun = [&] { return !shown.parts.empty() && shown.parts.back().scale == 1; };
  ASSERT_TRUE(shown.until(begun));
  EXPECT_FALSE(shown.parts.back().complete);
  const Image whole = directions(job.camera.camera(kWide, kTall));
  for (std::size_t i = 0; i < shown.rgba.size() / 4; ++i)
    ASSERT_NEAR(shown.rgba[4 * i], whole.pixels[3 * i], 0.02) << i;
  ASSERT_TRUE(shown.begun);
  EXPECT_GT(shown.begun->share, 0);
  EXPECT_GT(shown.begun->secondsLeft, 0);
}

TEST(CpuThread, RefiningEndsForWhatIsNewAndWhenItIsTold) {
  Shown shown;
  shown.thread.request(jobOf(slowly(3e-5)));
  ASSERT_TRUE(shown.until([&] { return shown.parts.size() > 1; }));
  CpuJob next = jobOf(slowly(1e-7));
  next.number = 2;
  shown.thread.request(next);
  ASSERT_TRUE(shown.until([&] { return shown.parts.back().number == 2 && shown.fine(); }));
  shown.thread.request(jobOf(slowly(3e-5)));
  const std::size_t before = shown.parts.size();
  ASSERT_TRUE(shown.until([&] { return shown.parts.size() > before + 1; }));
  shown.thread.stop();
  for (int i = 0; i < 5000 && shown.thread.progress().busy; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_FALSE(shown.thread.progress().busy);
  shown.until([] { return true; });
  EXPECT_FALSE(shown.fine());
}

TEST(CpuThread, TheQuickPictureIsFinishedWhateverIsNew) {
  Shown shown;
  std::atomic<int> pictures = 0, begun = 0;
  for (int i = 1; i <= 40; ++i) {  // one is always waiting
    CpuJob job = jobOf(slowly(3e-6, &pictures, &begun), 0.5);
    job.refines = false;
    job.number = i;
    shown.thread.request(job);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    shown.until([] { return true; });
  }
  ASSERT_TRUE(shown.until([&] { return !shown.parts.empty() && shown.parts.back().number == 40; }));
  EXPECT_EQ(pictures, begun) << "one was stopped";
  EXPECT_LT(begun, 40) << "none came while another was drawn";
}

TEST(CpuThread, APreviewComesFirstAndIsReplaced) {
  Shown shown;
  CpuJob job = jobOf(slowly(1e-6));
  job.preview = [](const Camera& camera, Progress&) -> Result<Image> {
    return directions(camera, 1);
  };
  job.previewFirst = true;
  shown.thread.request(job);
  ASSERT_TRUE(shown.until([&] { return shown.fine(); }));
  EXPECT_TRUE(shown.parts.front().preview);
  EXPECT_FALSE(shown.parts.back().preview);
}

TEST(CpuThread, AnErrorIsDelivered) {
  CpuThread thread;
  thread.request(jobOf([](const Camera&, Progress&) -> Result<Image> {
    return fail(ErrorCode::kUnsupported, "no picture of that");
  }));
  std::vector<Result<CpuPart>> parts;
  for (int i = 0; i < 5000 && parts.empty(); ++i) {
    parts = thread.take();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_EQ(parts.size(), 1);
  ASSERT_FALSE(parts[0]);
  EXPECT_EQ(parts[0].error().message, "no picture of that");
}

}  // namespace
}  // namespace volute
