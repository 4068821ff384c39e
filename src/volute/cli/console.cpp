// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/console.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "volute/base/interrupt.hpp"
#include "volute/base/output_file.hpp"
#include "volute/base/printable.hpp"

namespace volute::cli {
namespace {

constexpr std::chrono::milliseconds kBarInterval(100);
constexpr std::chrono::seconds kLineInterval(10);

std::string durationText(double seconds) {
  if (seconds < 60)
    return fmt::format("{:.0f} s", seconds);
  const int whole = static_cast<int>(std::min(seconds, 1e8));
  if (seconds < 3600)
    return fmt::format("{}:{:02} min", whole / 60, whole % 60);
  return fmt::format("{}:{:02} h", whole / 3600, whole / 60 % 60);
}

int terminalWidth() {
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
    return size.ws_col;
  return 80;
}

/// Nothing can be said about the rest before some of it is done.
std::string timeLeft(double done, double total, double elapsed) {
  if (done <= 0 || elapsed < 0.5)
    return "";
  return fmt::format("{} left", durationText(elapsed * (total - done) / done));
}

}  // namespace

Console::Console(std::string command, Volume volume, SettingText settings, bool strict)
    : command_(std::move(command)),
      volume_(volume),
      settings_(settings ? std::move(settings) : [](const auto&, const auto&) { return ""; }),
      strict_(strict),
      terminal_(::isatty(STDERR_FILENO) == 1) {
  const char* kind = std::getenv("TERM");
  if (kind && std::string_view(kind) == "dumb")
    terminal_ = false;
}

Console::~Console() {
  if (strict_)
    withholdOutputs(false);
  clear();
}

void Console::report(std::string_view stage, double done, double total) {
  if (volume_ == Volume::kQuiet)
    return;
  const auto now = Clock::now();
  const bool fresh = stage != stage_;
  if (fresh) {
    clear();
    stage_ = stage;
    stageStart_ = now;
  }
  const auto interval = terminal_ ? Clock::duration(kBarInterval) : Clock::duration(kLineInterval);
  // Plain lines: a stage that is over before the interval is worth a line to those who asked for
  // more.
  const bool first = fresh && (terminal_ || volume_ == Volume::kVerbose);
  if (fresh && !first)
    lastShown_ = now;
  const bool last = terminal_ && total > 0 && done >= total;
  if (!first && !last && now - lastShown_ < interval)
    return;
  lastShown_ = now;
  const double elapsed = std::chrono::duration<double>(now - stageStart_).count();
  terminal_ ? drawBar(done, total, elapsed) : writeLine(done, total, elapsed);
}

std::string Console::stageText() const {
  return printableMessage(detail_.empty() ? stage_ : fmt::format("{}, {}", stage_, detail_));
}

void Console::drawBar(double done, double total, double elapsed) {
  const std::string stage = stageText();
  std::string line;
  if (total > 0) {
    const double share = std::clamp(done / total, 0.0, 1.0);
    const std::string tail =
        fmt::format(" {:3.0f} %  {}", 100 * share, timeLeft(done, total, elapsed));
    const int width =
        std::clamp(terminalWidth() - static_cast<int>(stage.size() + tail.size()) - 4, 5, 40);
    const int full = static_cast<int>(share * width);
    line = fmt::format("{} [{:#<{}}{:.<{}}]{}", stage, "", full, "", width - full, tail);
  } else {
    line = fmt::format("{}  {}", stage, durationText(elapsed));
  }
  say("\r\x1b[K{}", line);
  std::fflush(stderr);
  barShown_ = true;
}

void Console::writeLine(double done, double total, double elapsed) {
  if (total > 0) {
    const std::string left = timeLeft(done, total, elapsed);
    say("volute {}: {}: {:.0f} %{}{}\n", command_, stageText(),
        100 * std::clamp(done / total, 0.0, 1.0), left.empty() ? "" : ", ", left);
  } else {
    say("volute {}: {}\n", command_, stageText());
  }
}

void Console::remark(const Remark& remark) {
  const std::string text = fullText(remark, settings_);
  if (!said_.insert({text, remark.file, remark.place}).second)
    return;
  remarks_.push_back(remark);
  if (strict_ && remark.code != RemarkCode::kNote) {  // is said as the command's error
    withholdOutputs(true);
    return;
  }
  if (volume_ == Volume::kQuiet)
    return;
  clear();
  say("volute {}: {}\n", command_, printableMessage(text));
}

Status Console::strictness() const {
  const auto found = std::ranges::find_if(
      remarks_, [](const Remark& remark) { return remark.code != RemarkCode::kNote; });
  if (!strict_ || found == remarks_.end())
    return {};
  Error error{ErrorCode::kInvalidData, "not with --strict: " + found->sentence};
  error.path = found->file, error.member = found->file.empty() ? "" : found->place;
  error.hints = found->hints;
  return tl::unexpected<Error>(std::move(error));
}

bool Console::cancelled() const {
  return Interrupt::requested() || !strictness();
}

void Console::clear() {
  if (!barShown_)
    return;
  say("\r\x1b[K");
  std::fflush(stderr);
  barShown_ = false;
}

}  // namespace volute::cli
