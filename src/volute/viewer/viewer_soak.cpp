// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Scripted use of the viewer for a long time: `viewer_soak SECONDS FILE...`. It opens the files
// again and again, plays, turns, changes parameters, paints, saves and hides panels, and says at
// the end how much memory grew from the second and third fifth of the time to the last two, which
// OpenGL errors there were, and how long the longest frame took while a file loaded. Exit 1 where
// one of them is too much.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "volute/viewer/open_document.hpp"
#include "volute/viewer/script.hpp"

namespace {

using namespace volute;

constexpr double kLongest = 0.1;      ///< [s] a frame may take while a file loads
constexpr double kMostGrowth = 0.05;  ///< of memory, on average
constexpr int kTold = 5;              ///< rounds between two lines on memory
constexpr int kWidth = 640, kHeight = 900;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double residentMiB() {
  std::ifstream status("/proc/self/statm");
  double total = 0, resident = 0;
  status >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

struct Report {
  double longestLoading = 0, longest = 0;
  std::string slowest{};
  int frames = 0, glErrors = 0, opened = 0;
};

/// How much was held; the first fifth of the time is for warming up.
struct Memory {
  struct Sum {
    double mebibytes = 0;
    int count = 0;

    double mean() const { return count > 0 ? mebibytes / count : 0; }
  };

  Sum before, after;

  void note(double share, double mebibytes) {
    if (share < 0.2)
      return;
    Sum& sum = share < 0.6 ? before : after;
    sum.mebibytes += mebibytes;
    ++sum.count;
  }

  double growth() const {
    return before.count && after.count ? after.mean() / before.mean() - 1 : 0;
  }
};

/// One round: what a restless person does with a file.
class Round {
 public:
  Round(HeadlessViewer& viewer, const std::string& folder, std::mt19937& random, Report& report)
      : viewer_(viewer),
        script_(viewer, kWidth, kHeight),
        folder_(folder),
        random_(random),
        report_(report) {
    script_.watch = [this](double seconds) { note(seconds); };
  }

  void use(const std::string& file) {
    what_ = "opening " + file;
    script_.drop(file);
    for (int i = 0; i < 400 && (i < 30 || viewer_.app().loading().busy); ++i) pause();
    ++report_.opened;
    what_ = "using " + file;
    script_.press(Key::kSpace);
    script_.drag(300, 860, 340, 840);
    for (int i = 0; i < 40; ++i) pause();
    script_.press(Key::kSpace);
    changeSomething();
    paint();
    for (const Key key :
         {Key::kF1, Key::kEscape, Key::kH, Key::kH, Key::kRight, Key::kPlus, Key::kMinus, Key::kF})
      script_.press(key);
    viewer_.app().settings().sceneName = folder_ + "/saved.json";
    script_.press(Key::kS, true);
    for (int i = 0; i < 20; ++i) pause();
  }

 private:
  void pause() {
    script_.frame();
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }

  void note(double seconds) {
    ++report_.frames;
    report_.longest = std::max(report_.longest, seconds);
    if (viewer_.app().loading().busy && seconds > report_.longestLoading) {
      report_.longestLoading = seconds;
      report_.slowest = what_;
    }
    for (GLenum error = glGetError(); error != GL_NO_ERROR; error = glGetError()) {
      fmt::print(stderr, "OpenGL error {:#x} while {}\n", error, what_);
      ++report_.glErrors;
    }
  }

  void changeSomething() {
    const DocumentInfo* document = viewer_.app().document();
    if (!document || document->parameters.empty())
      return;
    const auto& parameters = document->parameters;
    for (int i = 0; i < 3; ++i) {
      const std::string path = parameters[random_() % parameters.size()].path;
      script_.click(path, 0.2 + 0.1 * static_cast<double>(random_() % 6));
      script_.press(Key::kEscape);
    }
  }

  void paint() {
    if (!viewer_.app().paint().has())
      return;
    viewer_.app().settings().painting = true;
    script_.drag(250, 600, 380, 640, 0, 12);
    script_.press(Key::kZ, true);
    viewer_.app().settings().painting = false;
  }

  HeadlessViewer& viewer_;
  ViewerScript script_;
  std::string folder_, what_;
  std::mt19937& random_;
  Report& report_;
};

}  // namespace

int main(int count, char** words) {
  if (count < 3) {
    fmt::print(stderr, "usage: viewer_soak SECONDS FILE...\n");
    return 2;
  }
  const double seconds = std::atof(words[1]);
  auto viewer = HeadlessViewer::create(documentOpener({.maxMemory = std::uint64_t{2} << 30}));
  if (!viewer) {
    fmt::print(stderr, "viewer_soak: {}\n", viewer.error().message);
    return 1;
  }
  std::string folder = (std::filesystem::temp_directory_path() / "volute-soak-XXXXXX").string();
  if (!::mkdtemp(folder.data()))
    return 1;
  std::mt19937 random(1);
  Report report;
  Memory memory;
  const double begun = now();
  for (int round = 0; now() - begun < seconds; ++round) {
    Round(**viewer, folder, random, report).use(words[2 + round % (count - 2)]);
    if (round % kTold == 0)
      fmt::print(stderr, "{:6.0f} s: {:.0f} MiB\n", now() - begun, residentMiB());
    memory.note((now() - begun) / seconds, residentMiB());
  }
  std::filesystem::remove_all(folder);
  const double growth = memory.growth();
  fmt::print("{:.0f} s, {} frames, {} files opened\n", now() - begun, report.frames, report.opened);
  fmt::print(
      "memory: {:.0f} MiB in the second and third fifth, {:.0f} MiB in the last two: {:+.1f} %\n",
      memory.before.mean(), memory.after.mean(), 100 * growth);
  fmt::print("OpenGL errors: {}\n", report.glErrors);
  fmt::print("longest frame: {:.1f} ms while loading ({}), {:.1f} ms at all\n",
             1e3 * report.longestLoading, report.slowest, 1e3 * report.longest);
  const bool good =
      growth <= kMostGrowth && report.glErrors == 0 && report.longestLoading <= kLongest;
  fmt::print("{}\n", good ? "good" : "NOT GOOD");
  return good ? 0 : 1;
}
