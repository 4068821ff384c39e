// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/interrupt.hpp"

#include <fmt/format.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <mutex>
#include <set>

namespace volute::cli {
namespace {

std::atomic<bool> stopRequested{false};
std::atomic<bool> finished{false};
std::mutex foldersMutex;
std::set<std::filesystem::path> folders;

sigset_t stopSignals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

/// PendingFile names its files ".STEM.PID.COUNT.partEXTENSION", PendingFolder its folders alike.
void removePendingFiles() {
  const std::string ours = fmt::format(".{}.", ::getpid());
  const std::scoped_lock lock(foldersMutex);
  for (const auto& folder : folders) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      const std::string name = entry.path().filename().string();
      const bool pending = name.starts_with('.') && name.find(ours) != std::string::npos &&
                           name.find(".part") != std::string::npos;
      if (pending)
        std::filesystem::remove_all(entry.path(), error);
    }
  }
}

void waitForSignals() {
  const sigset_t set = stopSignals();
  for (;;) {
    int signal = 0;
    if (sigwait(&set, &signal) != 0)
      return;
    if (finished)
      return;
    if (stopRequested.exchange(true)) {
      removePendingFiles();
      ::_exit(1);
    }
    constexpr std::string_view kNote = "\nvolute: stopping; once more ends it at once\n";
    if (::isatty(STDERR_FILENO))
      (void)!::write(STDERR_FILENO, kNote.data(), kNote.size());
  }
}

}  // namespace

Interrupt::Interrupt() {
  const sigset_t set = stopSignals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  waiter_ = std::thread(waitForSignals);
}

Interrupt::~Interrupt() {
  finished = true;
  pthread_kill(waiter_.native_handle(), SIGTERM);
  waiter_.join();
}

bool Interrupt::requested() {
  return stopRequested;
}

void Interrupt::watch(const std::filesystem::path& target) {
  const std::scoped_lock lock(foldersMutex);
  folders.insert(target.has_parent_path() ? target.parent_path() : std::filesystem::path("."));
}

}  // namespace volute::cli
