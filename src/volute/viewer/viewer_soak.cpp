// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Scripted use of the viewer for a long time: `viewer_soak SECONDS FILE...`. It opens the files
// again and again, plays, turns, walks, changes parameters, adds, removes and takes back, paints,
// makes films and gives them up, saves, hides panels, and touches the file so that it is read
// again. Every third file, each of them in turn, is drawn by OpenGL whatever there is, at a quarter
// of the size, so that its errors and its growth show on machines without a graphics card too; how
// long such frames take says nothing there. Each minute it says how much memory is held, how many
// OpenGL errors there were, and which frames took longest and why; at the end how much what is
// allocated grew from the second and third fifth of the time to the last two, after the same files.
// Exit 1 where one of them is too much, or where nothing was drawn by OpenGL.
#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <thread>

#include "volute/viewer/open_document.hpp"
#include "volute/viewer/script.hpp"

/// What is allocated [bytes]: where a sanitizer keeps the books, mallinfo2() knows nothing.
extern "C" __attribute__((weak)) std::size_t __sanitizer_get_current_allocated_bytes();

namespace {

using namespace volute;

constexpr double kLongest = 0.1;     ///< [s] a frame may take while a file loads
constexpr double kMaxGrowth = 0.05;  ///< of memory, on average
constexpr double kTellEvery = 60;    ///< [s] between two lines
constexpr int kWidth = 640, kHeight = 900;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// [s] that this thread has computed: a frame that waited for others took longer than that.
double ownSeconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Programs that want to run, on average over the last minute.
double load() {
  double average = 0;
  return ::getloadavg(&average, 1) == 1 ? average : 0;
}

double residentMiB() {
  std::ifstream status("/proc/self/statm");
  double total = 0, resident = 0;
  status >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

/// What the program has asked for and not given back. The resident memory is more: freed blocks,
/// which a sanitizer holds back on purpose, and what drivers map.
double allocatedMiB() {
  const double bytes = __sanitizer_get_current_allocated_bytes
                           ? static_cast<double>(__sanitizer_get_current_allocated_bytes())
                           : [] {
                               const auto info = ::mallinfo2();
                               return static_cast<double>(info.uordblks + info.hblkhd);
                             }();
  return bytes / (1 << 20);
}

/// The frame that took longest, and what it did.
struct Longest {
  double seconds = 0;
  std::string what{};

  void see(double took, double own, const std::string& doing, const FrameCosts& costs) {
    if (took <= seconds)
      return;
    seconds = took;
    what = fmt::format(
        "{} (taking over {:.0f}, panels {:.0f}, picture {:.0f}, showing {:.0f} ms; the thread "
        "itself {:.0f} ms)",
        doing, costs.loaded, costs.panels, costs.picture, costs.shown, 1e3 * own);
  }

  void see(const Longest& other) {
    if (other.seconds > seconds)
      *this = other;
  }
};

struct Report {
  Longest loading{}, other{};
  int frames = 0, slow = 0, glErrors = 0, opened = 0;  ///< slow: above kLongest while loading
  int byGl = 0;                                        ///< files that OpenGL drew the media of

  void add(const Report& part) {
    loading.see(part.loading);
    other.see(part.other);
    frames += part.frames, slow += part.slow, glErrors += part.glErrors, opened += part.opened;
    byGl += part.byGl;
  }

  void tell(double seconds) const {
    fmt::print(
        "{:5.0f} s, load {:.1f}: {:.0f} MiB allocated, {:.0f} resident, {} OpenGL errors, {} files "
        "opened, {} drawn by "
        "OpenGL, "
        "{} frames, {} above {:.0f} ms "
        "while loading; longest {:.0f} ms while loading: {}; {:.0f} ms else: {}\n",
        seconds, load(), allocatedMiB(), residentMiB(), glErrors, opened, byGl, frames, slow,
        1e3 * kLongest, 1e3 * loading.seconds, loading.what, 1e3 * other.seconds, other.what);
    std::fflush(stdout);
  }
};

/// How much is held after each file, which by itself takes more or less than others; the first
/// fifth of the time is for warming up.
class Memory {
 public:
  void note(double share, const std::string& file, double mebibytes) {
    if (share < 0.2)
      return;
    Sum& sum = share < 0.6 ? files_[file].before : files_[file].after;
    sum.mebibytes += mebibytes;
    ++sum.count;
  }

  /// Means of the files that were open in both parts.
  double before() const { return mean(&Both::before); }

  double after() const { return mean(&Both::after); }

  double growth() const { return before() > 0 ? after() / before() - 1 : 0; }

 private:
  struct Sum {
    double mebibytes = 0;
    int count = 0;
  };

  struct Both {
    Sum before, after;
  };

  double mean(Sum Both::* part) const {
    Sum all;
    for (const auto& [file, both] : files_) {
      if (both.before.count == 0 || both.after.count == 0)
        continue;
      all.mebibytes += (both.*part).mebibytes / (both.*part).count;
      ++all.count;
    }
    return all.count > 0 ? all.mebibytes / all.count : 0;
  }

  std::map<std::string, Both> files_;
};

/// One round: what a restless person does with a file.
class Round {
 public:
  /// @param openGl  draws, a graphics card or not
  Round(HeadlessViewer& viewer, const std::string& folder, std::mt19937& random, Report& report,
        bool openGl)
      : viewer_(viewer),
        script_(viewer, kWidth, kHeight),
        folder_(folder),
        random_(random),
        report_(report),
        openGl_(openGl) {
    script_.watch = [this](double seconds) { note(seconds); };
  }

  void use(const std::string& file) {
    what_ = "opening " + file;
    chooseRenderer();
    script_.drop(file);
    script_.frames(2);
    script_.click("leave discard");  // where fog was painted
    for (int i = 0; i < 400 && (i < 30 || viewer_.app().document().loading().busy); ++i) pause();
    ++report_.opened;
    what_ = "using " + file;
    chooseRenderer();  // the scene may say another
    pause();
    report_.byGl += !viewer_.app().view().picture().times().passes.empty();
    script_.press(Key::kSpace);
    script_.drag(300, 860, 340, 840);
    pause(40);
    script_.press(Key::kSpace);
    changeSomething();
    addAndRemove();
    paint();
    walk();
    film();
    for (const Key key :
         {Key::kF1, Key::kEscape, Key::kH, Key::kH, Key::kRight, Key::kPlus, Key::kMinus, Key::kF})
      script_.press(key);
    viewer_.app().settings().sceneName = folder_ + "/saved.json";
    script_.press(Key::kS, true);
    pause(20);
    readAgain(file);
  }

 private:
  void chooseRenderer() {
    ViewLook& look = viewer_.app().settings().look;
    look.renderer = static_cast<int>(openGl_ ? ViewRenderer::kGl : ViewRenderer::kAuto);
    look.quality = static_cast<int>(openGl_ ? Quality::kQuarter : Quality::kAuto);
  }

  /// Frames that a rasteriser on the CPU draws take what they take.
  bool counts() const { return !openGl_ || viewer_.app().view().picture().makers().hardware; }

  /// So many frames, or fewer where each takes long.
  void pause(int frames) {
    for (int i = 0; i < (counts() ? frames : frames / 5); ++i) pause();
  }

  void pause() {
    script_.frame();
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }

  void note(double seconds) {
    ++report_.frames;
    const bool loads = viewer_.app().document().loading().busy;
    const double own = ownSeconds();
    if (counts()) {
      (loads ? report_.loading : report_.other)
          .see(seconds, own - own_, what_, viewer_.app().window().costs());
      if (loads && seconds > kLongest)
        ++report_.slow;
    }
    own_ = own;
    for (GLenum error = glGetError(); error != GL_NO_ERROR; error = glGetError()) {
      fmt::print(stderr, "OpenGL error {:#x} while {}\n", error, what_);
      ++report_.glErrors;
    }
  }

  void changeSomething() {
    const DocumentInfo* document = viewer_.app().document().info();
    if (!document || document->parameters.empty())
      return;
    const auto& parameters = document->parameters;
    for (int i = 0; i < 3; ++i) {
      const std::string path = parameters[random_() % parameters.size()].path;
      script_.click(path, 0.2 + 0.1 * static_cast<double>(random_() % 6));
      script_.press(Key::kEscape);
    }
  }

  /// A sign and a lamp come; one of them is placed anew and goes, all of it is taken back.
  void addAndRemove() {
    if (!script_.click("add sign"))
      return;
    pause(10);
    script_.click("add lamp");
    pause(10);
    if (script_.click("place /signs/0"))
      script_.clickAt(320, 640);
    script_.click("remove /signs/0");
    pause(10);
    for (int i = 0; i < 4; ++i) script_.press(Key::kZ, true);
    script_.press(Key::kEscape);
  }

  void paint() {
    if (!viewer_.app().tools().painting.tool().has())
      return;
    viewer_.app().settings().painting = true;
    script_.drag(250, 600, 380, 640, 0, 12);
    script_.press(Key::kZ, true);
    viewer_.app().settings().painting = false;
  }

  void walk() {
    script_.press(Key::kM);
    script_.input().held = {Key::kW, Key::kD};
    script_.frames(counts() ? 10 : 2);
    script_.input().held.clear();
    script_.press(Key::kM);
    for (const double clicks : {2.0, -2.0}) {
      script_.input().wheel = clicks;
      script_.frame();
    }
  }

  /// Every second one is given up.
  void film() {
    viewer_.app().settings().filmName = folder_ + "/film.mp4";
    viewer_.app().settings().filmSize = 0;
    if (!script_.click("Make film"))
      return;
    what_ += ", making a film";
    pause(20);
    const bool givesUp = report_.opened % 2 == 1 || !counts();
    for (int i = 0; i < 300 && viewer_.app().playback().film(); ++i) {
      if (givesUp && script_.click("Cancel film"))
        break;
      pause();
    }
    script_.click("Cancel film");
  }

  void readAgain(const std::string& file) {
    what_ = "reading again " + file;
    std::error_code ignored;
    std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now(), ignored);
    constexpr double kSeconds = 1;  // it is looked for every half second
    for (const double begun = now();
         now() - begun < kSeconds || viewer_.app().document().loading().busy;) {
      pause();
      if (now() - begun > 20 * kSeconds)
        break;
    }
  }

  HeadlessViewer& viewer_;
  ViewerScript script_;
  std::string folder_, what_;
  double own_ = ownSeconds();
  std::mt19937& random_;
  Report& report_;
  bool openGl_;
};

}  // namespace

int main(int count, char** words) {
  if (count < 3) {
    fmt::print(stderr, "usage: viewer_soak SECONDS FILE...\n");
    return 2;
  }
  const double seconds = std::atof(words[1]);
  auto viewer = HeadlessViewer::create(documentOpener({.maxMemory = std::uint64_t{2} << 30}),
                                       {.rasteriser = true});
  if (!viewer) {
    fmt::print(stderr, "viewer_soak: {}\n", viewer.error().message);
    return 1;
  }
  (*viewer)->drawWholeFrames();
  std::string folder = (std::filesystem::temp_directory_path() / "volute-soak-XXXXXX").string();
  if (!::mkdtemp(folder.data()))
    return 1;
  std::mt19937 random(1);
  Report all, minute;
  Memory memory;
  const double begun = now();
  double told = begun;
  for (int round = 0; now() - begun < seconds; ++round) {
    const int files = count - 2;
    const bool openGl = (round + round / files) % 3 == 1;
    const std::string file = words[2 + round % files];
    Round(**viewer, folder, random, minute, openGl).use(file);
    memory.note((now() - begun) / seconds, file, allocatedMiB());
    if (now() - told < kTellEvery && now() - begun < seconds)
      continue;
    told = now();
    minute.tell(told - begun);
    all.add(std::exchange(minute, {}));
  }
  std::filesystem::remove_all(folder);
  const double growth = memory.growth();
  fmt::print(
      "allocated: {:.1f} MiB in the second and third fifth, {:.1f} MiB in the last two, after the "
      "same files: {:+.1f} %\n",
      memory.before(), memory.after(), 100 * growth);
  fmt::print("all of it: ");
  all.tell(now() - begun);
  const bool good =
      growth <= kMaxGrowth && all.glErrors == 0 && all.byGl > 0 && all.loading.seconds <= kLongest;
  fmt::print("{}\n", good ? "good" : "NOT GOOD");
  return good ? 0 : 1;
}
