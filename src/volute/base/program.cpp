// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/program.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>

namespace volute {
namespace {

void openAs(int standard, const std::filesystem::path& file, int mode) {
  const int descriptor = ::open(file.empty() ? "/dev/null" : file.c_str(), mode | O_CLOEXEC);
  if (descriptor < 0 || ::dup2(descriptor, standard) != standard)
    ::_exit(127);
}

/// Its process, or -1.
pid_t startProgram(std::vector<std::string> words, const ProgramLimits& limits) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const pid_t process = ::fork();
  if (process != 0)
    return process;
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  openAs(STDIN_FILENO, limits.input, O_RDONLY);
  openAs(STDOUT_FILENO, limits.output, O_WRONLY);
  openAs(STDERR_FILENO, {}, O_WRONLY);
  ::close_range(STDERR_FILENO + 1, ~0U, 0);
  const rlimit memory{limits.memory, limits.memory};
  if (limits.memory > 0 && ::setrlimit(RLIMIT_AS, &memory) != 0)
    ::_exit(127);
  if (!limits.confine || limits.confine())
    ::execv(pointers[0], pointers.data());
  ::_exit(127);
}

}  // namespace

std::string findProgram(std::initializer_list<std::string_view> names) {
  const char* path = std::getenv("PATH");
  for (const std::string_view name : names) {
    std::string_view folders = path != nullptr ? path : "/usr/bin";
    while (!folders.empty()) {
      const std::size_t end = std::min(folders.find(':'), folders.size());
      const auto program = std::filesystem::path(folders.substr(0, end)) / name;
      if (program.is_absolute() && ::access(program.c_str(), X_OK) == 0)
        return program.string();
      folders.remove_prefix(std::min(end + 1, folders.size()));
    }
  }
  return "";
}

bool runProgram(std::vector<std::string> words, const ProgramLimits& limits) {
  constexpr auto kStep = std::chrono::milliseconds(20);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(limits.seconds);
  const pid_t process = startProgram(std::move(words), limits);
  if (process < 0)
    return true;
  int status = 0;
  while (::waitpid(process, &status, WNOHANG) != process) {
    if (std::chrono::steady_clock::now() >= end) {
      ::kill(process, SIGKILL);
      ::waitpid(process, &status, 0);
      return false;
    }
    std::this_thread::sleep_for(kStep);
  }
  return true;
}

ScratchFolder::ScratchFolder() {
  std::error_code error;
  std::string name = (std::filesystem::temp_directory_path(error) / "volute-XXXXXX").string();
  if (!error && ::mkdtemp(name.data()) != nullptr)
    path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code unknown;
  if (!path_.empty())
    std::filesystem::remove_all(path_, unknown);
}

}  // namespace volute
