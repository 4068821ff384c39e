// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/program.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>

extern char** environ;

namespace volute {
namespace {

/// Its process, or -1.
pid_t startProgram(std::vector<std::string> words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  pid_t process = -1;
  if (::posix_spawn(&process, pointers[0], &actions, nullptr, pointers.data(), environ) != 0)
    process = -1;
  posix_spawn_file_actions_destroy(&actions);
  return process;
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

bool runProgram(std::vector<std::string> words, double seconds) {
  constexpr auto kStep = std::chrono::milliseconds(20);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  const pid_t process = startProgram(std::move(words));
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
