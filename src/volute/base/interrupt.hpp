// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <chrono>
#include <filesystem>
#include <string_view>
#include <thread>

namespace volute {

/// While it lives, SIGINT (Ctrl-C) and SIGTERM ask the running command to stop. A second one, or a
/// command that has not stopped after kPatience (or kWriting), removes the half-written outputs
/// beside the targets that were named to watch(), and ends the program by the signal. A signal that
/// was ignored when the program began (nohup, a script's `&`) stays ignored. Make it before any
/// other thread: they inherit the signal mask, and a thread of its own waits for the signals, so
/// that the answer to them is free of what signal handlers may not do.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// From now on, memory that is missing where no exception may leave ends the program with a
  /// sentence and exit code 1, half-written outputs removed, instead of by abort().
  static void explainMissingMemory();

  /// Whether somebody asked to stop.
  static bool requested();

  /// Ends the program by the signal that asked to stop, as if it had never been caught: shells then
  /// end their loops, and make and batch systems see an interruption and no failure. Call it when
  /// everything is cleaned up and no Interrupt lives; returns where nobody asked, and after
  /// keepExitCode().
  static void endBySignal();

  /// For one of several ranks, whose launcher takes a death by a signal for a crash: stopped runs
  /// end with exit code 1.
  static void keepExitCode();

  /// The parent folder of `target` is searched for half-written files when the program is ended.
  static void watch(const std::filesystem::path& target);

  /// The command writes what it has when it is asked to stop, and has kWriting for that.
  static void expectWriting();

  /// The command, which the last message begins with.
  static void name(std::string_view command);

  /// What a library computes, or a disk takes, does not ask whether to stop.
  static constexpr std::chrono::milliseconds kPatience{800};
  static constexpr std::chrono::seconds kWriting{30};

 private:
  std::thread waiter_;
};

}  // namespace volute
