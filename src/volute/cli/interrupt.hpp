// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <thread>

namespace volute::cli {

/// While it lives, SIGINT (Ctrl-C) and SIGTERM ask the running command to stop. A second one
/// removes the half-written outputs beside the targets that were named to watch(), and ends the
/// program with exit code 1. Make it before any other thread: they inherit the signal mask, and a
/// thread of its own waits for the signals, so that the answer to them is free of what signal
/// handlers may not do.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  static bool requested();
  static void watch(const std::filesystem::path& target);

 private:
  std::thread waiter_;
};

}  // namespace volute::cli
