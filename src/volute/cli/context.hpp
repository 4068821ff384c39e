// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/io/reading.hpp"
#include "volute/report/json.hpp"
#include "volute/report/report.hpp"

namespace volute::cli {

class Console;

/// What a command works with besides its arguments.
struct Context : Reading {
  Team& team;                  ///< who shares the work; this process alone without mpirun
  Console* console = nullptr;  ///< whose bar ends before results are shown
  bool json = false;
  bool verbose = false;
  std::vector<std::string> words{};  ///< as the user typed them, without the command's name
  bool silent = false;               ///< results are not shown: a command of many runs has its own
  bool resultsToStderr = false;      ///< set when the data themselves go to standard output

  /// Shows results: one JSON object or lines of text, on standard output. (Of ranks but the first
  /// standard output and standard error lead nowhere.)
  void print(const Report& report) const;
  void print(std::string_view text) const;

  /// An object, completed by the remarks so far.
  void printJson(Json results) const;

  /// The parent folder of `target` is searched for half-written files when a second Ctrl-C ends the
  /// program.
  static void watch(const std::filesystem::path& target);
};

}  // namespace volute::cli
