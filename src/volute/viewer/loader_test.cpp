// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/loader.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <utility>

#include "volute/base/program.hpp"

namespace volute {
namespace {

using std::chrono::milliseconds;

constexpr auto kSoon = std::chrono::seconds(60);

/// Its snapshots take a while to be freed.
class Heavy final : public Document {
 public:
  DocumentInfo info() const override {
    return {.title = "heavy", .bounds = {Vec3::Zero(), Vec3::Ones()}, .times = {0}};
  }

  std::vector<std::filesystem::path> files() const override { return {}; }

  Result<ViewScene> sceneAt(const SceneRequest&, Progress&) override {
    const std::shared_ptr<int> weight(new int, [](int* held) {
      std::this_thread::sleep_for(milliseconds(30));
      delete held;
    });
    return ViewScene{.cpu = [weight](const Camera&, Progress&) { return Image(1, 1); }};
  }
};

/// Until it holds; false: it never does.
template <class Holds>
bool soon(Holds&& holds) {
  const auto begun = std::chrono::steady_clock::now();
  while (!holds()) {
    if (std::chrono::steady_clock::now() - begun > kSoon)
      return false;
    std::this_thread::yield();
  }
  return true;
}

/// Whose whole snapshots take longer than a film has.
class Slow final : public Document {
 public:
  DocumentInfo info() const override {
    return {.title = "slow", .bounds = {Vec3::Zero(), Vec3::Ones()}, .times = {0, 1, 2, 3}};
  }

  std::vector<std::filesystem::path> files() const override { return {}; }

  Result<ViewScene> sceneAt(const SceneRequest& request, Progress&) override {
    std::this_thread::sleep_for(milliseconds(request.moving ? 1 : 50));
    return ViewScene{.time = request.time, .provisional = request.moving};
  }
};

TEST(Loader, WhatPlaysIsProvisionalAndWhatRestsIsWhole) {
  Loader loader([](const std::string&, Progress&) { return std::make_unique<Slow>(); });
  loader.open("slow", std::nullopt);
  std::optional<LoadedScene> last;
  const auto shows = [&](double time, bool provisional) {
    return soon([&] {
      auto news = loader.news();
      if (news && news->loaded)
        last = std::move(news->loaded);
      return last && last->time == time && last->scene->provisional == provisional;
    });
  };
  ASSERT_TRUE(shows(0, false));
  loader.request(1, {2, 3}, 0.04);
  EXPECT_TRUE(shows(1, true)) << "50 ms are too long";
  loader.request(2, {3}, 0.04);
  EXPECT_TRUE(shows(2, true)) << "it was loaded ahead";
  loader.request(2);
  EXPECT_TRUE(shows(2, false)) << "it rests";
  loader.request(3, {1}, 1);
  loader.request(1, {0}, 1);
  loader.request(0, {1}, 1);
  EXPECT_TRUE(shows(0, false)) << "time enough";
}

/// Of one file.
class OfFile final : public Document {
 public:
  explicit OfFile(std::filesystem::path path) : path_(std::move(path)) {}

  DocumentInfo info() const override {
    return {.title = "file", .bounds = {Vec3::Zero(), Vec3::Ones()}, .times = {0}};
  }

  std::vector<std::filesystem::path> files() const override { return {path_}; }

  Result<ViewScene> sceneAt(const SceneRequest&, Progress&) override { return ViewScene{}; }

 private:
  std::filesystem::path path_;
};

TEST(Loader, AFileThatChangesWhileItIsReadIsReadAgain) {
  const ScratchFolder folder;
  const auto path = folder.path() / "a";
  std::ofstream(path) << "before";
  std::atomic<int> opened = 0;
  Loader loader([&](const std::string&, Progress&) {
    if (++opened == 1)
      std::filesystem::last_write_time(
          path, std::filesystem::last_write_time(path) + std::chrono::seconds(1));
    return std::make_unique<OfFile>(path);
  });
  loader.open(path.string(), std::nullopt);
  EXPECT_TRUE(soon([&] {
    loader.news();
    return opened == 2;
  }));
}

TEST(Loader, IsNotIdleWhileAChangeIsStillToBeMade) {
  std::atomic<bool> made = false;
  Loader loader([](const std::string&, Progress&) { return std::make_unique<Heavy>(); });
  loader.open("heavy", std::nullopt);
  ASSERT_TRUE(soon([&] {
    const auto news = loader.news();
    return news && news->idle;
  }));
  for (int i = 0; i < 5; ++i) {
    made = false;
    loader.change("some", [&](Document&, Progress&) -> Result<std::string> {
      made = true;
      return "made";
    });
    std::optional<LoaderNews> last;
    ASSERT_TRUE(soon([&] {
      last = loader.news();
      return last && last->idle;
    }));
    EXPECT_TRUE(made) << "what was asked for is done when nothing is left to be done";
    EXPECT_EQ(last->state.message, "made");
    EXPECT_FALSE(last->state.busy);
  }
}

}  // namespace
}  // namespace volute
