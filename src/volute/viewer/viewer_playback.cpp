// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// How fluent the viewer is: `viewer_playback [--renderer cpu|gl] [--limit SECONDS] FILE...` opens
// each file in a headless window of 1280 x 800, frames paced as a window's are, and prints as a
// line of JSON:
//   first, fine       seconds from opening to the first picture with something in it, and until
//                     nothing gets finer any more
//   cpu               of the first, what all threads together computed [s]
//   answer            longest that a key waited for its frame while the file was opened and drawn
//   pictures          in each second of playback, and
//   played            frames of the file that were shown, of `rate`
//   scale             of the window's pixels a side that a picture while playing has, on average
//   playing, turning  longest time without a new picture while it plays, and while a hand turns it
//   jump, jump_fine   until there is a picture after a jump of the camera, and until it is fine
// A null means: not within the limit.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <thread>

#include "volute/io/reader_helper.hpp"
#include "volute/viewer/open_document.hpp"
#include "volute/viewer/script.hpp"

namespace {

using namespace volute;

constexpr int kWidth = 1280, kHeight = 800;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// By all threads of the process [s].
double computed() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

std::string number(const std::optional<double>& value) {
  return value ? fmt::format("{:.3f}", *value) : "null";
}

class Measurement {
 public:
  Measurement(HeadlessViewer& viewer, double limit) : viewer_(viewer), limit_(limit) {
    input_.width = kWidth, input_.height = kHeight;
  }

  bool run(const std::string& path) {
    ViewerApp& app = viewer_.app();
    const double opened = now(), before = computed();
    app.open(path);
    types_ = true;
    const auto first = until([&] { return something(); });
    const double cpu = computed() - before;
    const auto fine = until([&] { return app.settled(); });
    types_ = false;
    if (!app.document().error().empty())
      fmt::print(stderr, "{}\n", app.document().error());
    const auto after = [&](const std::optional<double>& when) {
      return when ? std::optional<double>(*when - opened) : std::nullopt;
    };
    fmt::print(R"({{"file": "{}", "first": {}, "cpu": {:.3f}, "fine": {}, "answer": {:.3f})", path,
               number(after(first)), cpu, number(after(fine)), longestAnswer_);
    std::fflush(stdout);
    play();
    turn();
    jump();
    fmt::print("}}\n");
    std::fflush(stdout);
    return first.has_value();
  }

 private:
  /// A frame, no sooner after the last one than a window's would be.
  void frame() {
    const double wait = begun_ + std::max(1.0 / 60, hand_ ? 0 : viewer_.app().patience()) - now();
    if (wait > 0)
      std::this_thread::sleep_for(std::chrono::duration<double>(std::min(wait, 0.1)));
    const double before = std::exchange(begun_, now());
    input_.seconds = (before > 0 ? begun_ - before : 1.0 / 60) + std::exchange(skipped_, 0);
    if (!viewer_.app().due(input_)) {
      skipped_ = input_.seconds;
      return;
    }
    if (types_)
      input_.pressed = {Key::kP};  // which asks for no other picture
    const double asked = now();
    if (!viewer_.frame(input_))
      std::exit(1);
    if (types_)
      longestAnswer_ = std::max(longestAnswer_, now() - asked);
    input_.pressed.clear();
    if (const int version = viewer_.app().view().picture().state().version; version != version_) {
      version_ = version;
      changed_ = now();
    }
  }

  /// When it became true [s].
  template <class Done>
  std::optional<double> until(const Done& done) {
    const double end = now() + limit_;
    while (now() < end) {
      frame();
      if (done())
        return now();
    }
    return std::nullopt;
  }

  /// Whether what is shown is more than one colour.
  bool something() {
    ViewerApp& app = viewer_.app();
    if (!app.view().picture().shown() || !app.document().info() || !app.view().picture().scene())
      return false;
    if (!app.view().picture().scene()->quads.empty())
      return true;  // a capture's pictures
    const Image light = app.view().picture().sampledLight(app.document().info()->background);
    const auto [least, most] = std::ranges::minmax(light.pixels);
    return most > least + 1e-3F;
  }

  void play() {
    constexpr double kSeconds = 5;
    ViewerApp& app = viewer_.app();
    Timeline& timeline = app.playback().timeline();
    if (!timeline.moves())
      return;
    timeline.seek(timeline.first());
    until([&] { return app.settled(); });
    timeline.play(true);
    const double begin = now();
    changed_ = begin;
    double longest = 0, scales = 0;
    int shown = 0, pictures = 0, last = version_;
    double time = app.view().picture().state().time;
    while (now() < begin + kSeconds) {
      frame();
      longest = std::max(longest, now() - changed_);
      if (version_ == last)
        continue;
      last = version_;
      ++pictures;
      scales += static_cast<double>(app.view().picture().times().width) / kWidth;
      shown += frameOf(app.view().picture().state().time) != frameOf(time);
      time = app.view().picture().state().time;
    }
    const double spent = now() - begin;
    timeline.play(false);
    const double rate = (timeline.frames() - 1) / (timeline.last() - timeline.first());
    fmt::print(
        R"(, "pictures": {:.2f}, "played": {:.2f}, "rate": {:.2f}, "scale": {:.2f}, "playing": {:.3f})",
        pictures / spent, shown / spent, rate, scales / std::max(pictures, 1), longest);
    std::fflush(stdout);
    until([&] { return app.settled(); });
  }

  int frameOf(double time) {
    Timeline own = viewer_.app().playback().timeline();
    own.seek(time);
    return own.frame();
  }

  void turn() {
    constexpr double kSeconds = 3;
    ViewerApp& app = viewer_.app();
    double longest = 0;
    hand_ = true;
    input_.mouseX = kWidth / 2, input_.mouseY = kHeight / 2;
    frame();
    input_.buttons[0] = true;
    const double begin = changed_ = now();
    while (now() < begin + kSeconds) {
      input_.mouseX += 2;
      frame();
      longest = std::max(longest, now() - changed_);
    }
    hand_ = input_.buttons[0] = false;
    fmt::print(R"(, "turning": {:.3f})", longest);
    std::fflush(stdout);
    until([&] { return app.settled(); });
  }

  void jump() {
    ViewerApp& app = viewer_.app();
    const int before = version_;
    const double begin = now();
    input_.pressed = {Key::k3};
    const auto shown = until([&] { return version_ != before; });
    const auto fine = until([&] { return app.settled(); });
    fmt::print(R"(, "jump": {}, "jump_fine": {})",
               number(shown ? std::optional<double>(*shown - begin) : std::nullopt),
               number(fine ? std::optional<double>(*fine - begin) : std::nullopt));
  }

  HeadlessViewer& viewer_;
  double limit_;
  ViewerInput input_;
  double begun_ = 0, changed_ = 0, skipped_ = 0;
  int version_ = 0;
  bool types_ = false;
  double longestAnswer_ = 0;
  bool hand_ = false;  ///< moves something: a window does not rest
};

}  // namespace

int main(int argc, char** argv) {
  const ReaderHelper helper;  // as the command has one
  double limit = 60;
  ViewerOptions options;
  bool good = true;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--limit" && i + 1 < argc) {
      limit = std::atof(argv[++i]);
    } else if (argument == "--renderer" && i + 1 < argc) {
      options.renderer = argv[++i] == std::string("gl") ? ViewRenderer::kGl : ViewRenderer::kCpu;
    } else {
      auto viewer = HeadlessViewer::create(documentOpener({}), options);
      if (!viewer) {
        fmt::print(stderr, "{}\n", viewer.error().message);
        return 1;
      }
      (*viewer)->drawWholeFrames();
      good = Measurement(**viewer, limit).run(argument) && good;
    }
  }
  return good ? 0 : 1;
}
