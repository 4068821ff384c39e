// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "volute/base/progress.hpp"

namespace volute::cli {

/// To standard error. What cannot be said there (it is closed, its disk is full) ends nothing.
template <class... Args>
void say(fmt::format_string<Args...> format, Args&&... args) {
  std::fputs(fmt::format(format, std::forward<Args>(args)...).c_str(), stderr);
}

/// Progress and remarks on standard error: on a terminal a bar with the time that is left, else a
/// plain line at the start of a stage and at most every ten seconds.
class Console final : public Progress {
 public:
  enum class Volume { kQuiet, kNormal, kVerbose };

  /// `command` opens each remark: "volute compress: ...".
  Console(std::string command, Volume volume);
  ~Console() override;

  void report(std::string_view stage, double done, double total) override;

  void detail(std::string_view text) override { detail_ = text; }

  void remark(std::string_view message) override;
  bool cancelled() const override;

  /// Ends the line of a bar, so that something else can be written.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  std::string stageText() const;
  void drawBar(double done, double total, double elapsed);
  void writeLine(double done, double total, double elapsed);

  std::string command_;
  Volume volume_;
  bool terminal_;
  bool barShown_ = false;
  std::string stage_;
  std::string detail_;  // of the stage
  Clock::time_point stageStart_;
  Clock::time_point lastShown_;
};

}  // namespace volute::cli
