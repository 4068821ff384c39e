// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "volute/base/advice.hpp"
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
  /// @param strict  the first remark that is more than a note ends the command
  Console(std::string command, Volume volume, SettingText settings = {}, bool strict = false);
  ~Console() override;

  void report(std::string_view stage, double done, double total) override;

  void detail(std::string_view text) override { detail_ = text; }

  /// Each remark is said once, whoever repeats it.
  void remark(const Remark& remark) override;
  bool cancelled() const override;

  std::span<const Remark> remarks() const { return remarks_; }

  /// With `strict`: the error that the first remark of that kind is, if there was one.
  Status strictness() const;

  /// How the command writes a setting.
  const SettingText& settings() const { return settings_; }

  /// Ends the line of a bar, so that something else can be written.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  std::string stageText() const;
  void drawBar(double done, double total, double elapsed);
  void writeLine(double done, double total, double elapsed);

  std::string command_;
  Volume volume_;
  SettingText settings_;
  bool strict_;
  std::vector<Remark> remarks_;
  std::set<std::array<std::string, 3>> said_;  // sentence, file, place
  bool terminal_;
  bool barShown_ = false;
  std::string stage_;
  std::string detail_;  // of the stage
  Clock::time_point stageStart_;
  Clock::time_point lastShown_;
};

}  // namespace volute::cli
