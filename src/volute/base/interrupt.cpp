// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/interrupt.hpp"

#include <fmt/format.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <new>
#include <set>
#include <string_view>

#include "volute/base/output_place.hpp"

namespace volute {
namespace {

std::atomic<bool> stopRequested{false};
std::atomic<int> stopSignal{0};
std::atomic<bool> keepsExitCode{false};
std::atomic<bool> finished{false};
std::atomic<bool> writes{false};
std::atomic<bool> memoryWasMissing{false};
std::mutex foldersMutex;
std::set<std::filesystem::path> folders;
std::string commandName;  // after a blank

bool isIgnored(int signal) {
  struct sigaction action{};
  return ::sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

/// But for those that whoever started the program ignores.
sigset_t stopSignals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM}) {
    if (!isIgnored(signal))
      sigaddset(&set, signal);
  }
  return set;
}

/// One of stopSignals(); 0: both are ignored.
int anyStopSignal() {
  return !isIgnored(SIGTERM) ? SIGTERM : !isIgnored(SIGINT) ? SIGINT : 0;
}

void dieBy(int signal) {
  struct sigaction usual{};
  usual.sa_handler = SIG_DFL;
  ::sigaction(signal, &usual, nullptr);
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, signal);
  ::pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
  ::kill(::getpid(), signal);
  ::raise(signal);
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
                           name.find(".part") != std::string::npos &&
                           !name.ends_with(".old.part");  // somebody's results
      if (pending)
        std::filesystem::remove_all(entry.path(), error);
    }
  }
}

[[noreturn]] void endNow() {
  removePendingFiles();
  std::string note;
  {
    const std::scoped_lock lock(foldersMutex);
    note = fmt::format("{}volute{}: stopped\n", ::isatty(STDERR_FILENO) ? "\n" : "", commandName);
  }
  (void)!::write(STDERR_FILENO, note.data(), note.size());
  if (!keepsExitCode)
    dieBy(stopSignal);
  ::_exit(1);
}

/// Called by operator new. Some library functions are noexcept and allocate (libstdc++'s
/// directory_iterator): they call std::terminate(), where std::bad_alloc is no longer visible.
void noteMissingMemory() {
  memoryWasMissing = true;
  throw std::bad_alloc();
}

/// Where memory is missing while something is freed (JSON takes some for that), or in a function
/// that cannot throw.
[[noreturn]] void endWithoutMemory() {
  try {
    if (const auto error = std::current_exception())
      std::rethrow_exception(error);
    if (memoryWasMissing)
      throw std::bad_alloc();
  } catch (const std::bad_alloc&) {
    constexpr std::string_view kNote = "volute: there is not enough memory\n";
    (void)!::write(STDERR_FILENO, kNote.data(), kNote.size());
    try {
      removePendingFiles();
    } catch (const std::exception&) {
      // They stay, and the next run names them.
    }
    ::_exit(1);
  } catch (...) {
  }
  std::abort();
}

void waitForSignals() {
  const sigset_t set = stopSignals();
  int signal = 0;
  if (sigwait(&set, &signal) != 0 || finished)
    return;
  stopSignal = signal;
  stopRequested = true;
  const timespec patience =
      writes ? timespec{Interrupt::kWriting.count(), 0}
             : timespec{0, std::chrono::nanoseconds(Interrupt::kPatience).count()};
  const int second = sigtimedwait(&set, nullptr, &patience);
  if (!finished && (second > 0 || errno == EAGAIN))
    endNow();
}

}  // namespace

void Interrupt::explainMissingMemory() {
  std::set_new_handler(noteMissingMemory);
  std::set_terminate(endWithoutMemory);
}

Interrupt::Interrupt() {
  const sigset_t set = stopSignals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  if (anyStopSignal() != 0)
    waiter_ = std::thread(waitForSignals);
}

Interrupt::~Interrupt() {
  finished = true;
  if (!waiter_.joinable())
    return;
  pthread_kill(waiter_.native_handle(), anyStopSignal());
  waiter_.join();
}

void Interrupt::endBySignal() {
  if (!stopRequested || keepsExitCode)
    return;
  std::fflush(nullptr);
  dieBy(stopSignal);
}

void Interrupt::keepExitCode() {
  keepsExitCode = true;
}

bool Interrupt::requested() {
  return stopRequested;
}

void Interrupt::expectWriting() {
  writes = true;
}

void Interrupt::name(std::string_view command) {
  const std::scoped_lock lock(foldersMutex);
  commandName = fmt::format(" {}", command);
}

void Interrupt::watch(const std::filesystem::path& target) {
  const std::scoped_lock lock(foldersMutex);
  const auto named = target.has_filename() ? target : target.parent_path();  // "FOLDER/"
  const auto place = outputPlace(named, "");
  for (const auto& path : {named, place ? *place : named})
    folders.insert(path.has_parent_path() ? path.parent_path() : std::filesystem::path("."));
}

}  // namespace volute
