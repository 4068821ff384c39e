// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/file_dialog.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <string_view>
#include <tuple>

#include "volute/base/file_name.hpp"

extern char** environ;

namespace volute {
namespace {

constexpr std::string_view kKnown[] = {".json", ".volute", ".vdb", ".nvdb", ".npy", ".npz",
                                       ".nc",   ".h5",     ".vti", ".pvd",  ".vtu", ".smv",
                                       ".png",  ".exr",    ".yml", ".yaml", ".foam"};

bool onPath(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path ? path : "";
  while (!rest.empty()) {
    const auto end = std::min(rest.find(':'), rest.size());
    const std::string file = std::string(rest.substr(0, end)) + "/" + program;
    if (::access(file.c_str(), X_OK) == 0)
      return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

std::vector<std::string> commandFor(const std::filesystem::path& folder) {
  if (onPath("zenity"))
    return {"zenity", "--file-selection", "--title=Open in Volute",
            "--filename=" + (folder / "").string()};
  if (onPath("kdialog"))
    return {"kdialog", "--title", "Open in Volute", "--getopenfilename", folder.string()};
  return {};
}

}  // namespace

std::span<const std::string_view> knownExtensions() {
  return kKnown;
}

bool isKnown(const std::filesystem::path& path) {
  return std::ranges::find(kKnown, extensionOf(path)) != std::end(kKnown);
}

std::unique_ptr<DesktopDialog> DesktopDialog::open(const std::filesystem::path& folder) {
  auto command = commandFor(folder);
  if (command.empty())
    return nullptr;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    return nullptr;
  std::vector<char*> arguments;
  for (std::string& argument : command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t process = 0;
  const int failed =
      ::posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  if (failed) {
    ::close(ends[0]);
    return nullptr;
  }
  ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
  return std::unique_ptr<DesktopDialog>(new DesktopDialog(process, ends[0]));
}

DesktopDialog::~DesktopDialog() {
  if (process_ > 0) {
    ::kill(process_, SIGTERM);
    ::waitpid(process_, nullptr, 0);
  }
  ::close(output_);
}

std::optional<std::string> DesktopDialog::poll() {
  if (process_ <= 0)
    return "";
  std::array<char, 4096> part{};
  for (;;) {
    const ssize_t count = ::read(output_, part.data(), part.size());
    if (count > 0) {
      answer_.append(part.data(), static_cast<std::size_t>(count));
      continue;
    }
    if (count < 0 && (errno == EAGAIN || errno == EINTR))
      return std::nullopt;
    break;
  }
  int status = 0;
  ::waitpid(process_, &status, 0);
  process_ = 0;
  const bool chosen = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  return chosen ? answer_.substr(0, answer_.find('\n')) : "";
}

std::vector<FolderEntry> folderEntries(const std::filesystem::path& folder, std::size_t most) {
  std::vector<FolderEntry> entries;
  std::error_code ignored;
  for (std::filesystem::directory_iterator at(folder, ignored), end; at != end && !ignored;
       at.increment(ignored)) {
    const std::string name = at->path().filename().string();
    if (name.starts_with(".") || entries.size() >= most)
      continue;
    std::error_code unknown;
    const bool isFolder = at->is_directory(unknown);
    entries.push_back({name, isFolder, !isFolder && isKnown(at->path())});
  }
  std::ranges::sort(entries, {}, [](const FolderEntry& entry) {
    return std::tuple(!entry.folder, !entry.known, entry.name);
  });
  return entries;
}

RecentFiles::RecentFiles(std::filesystem::path file) : file_(std::move(file)) {
  std::ifstream in(file_);
  for (std::string line; names_.size() < kMax && std::getline(in, line);) {
    if (!line.empty())
      names_.push_back(line);
  }
}

void RecentFiles::add(const std::string& name) {
  std::error_code failed;
  const auto absolute = std::filesystem::absolute(name, failed).lexically_normal();
  const std::string whole = failed ? name : absolute.string();
  if (whole.find('\n') != std::string::npos)
    return;
  std::erase(names_, whole);
  names_.insert(names_.begin(), whole);
  names_.resize(std::min(names_.size(), kMax));
  if (file_.empty())
    return;
  std::filesystem::create_directories(file_.parent_path(), failed);
  std::ofstream out(file_, std::ios::trunc);
  for (const std::string& each : names_) out << each << '\n';
}

std::filesystem::path RecentFiles::usualFile() {
  if (const char* state = std::getenv("XDG_STATE_HOME"); state && *state)
    return std::filesystem::path(state) / "volute" / "recent";
  if (const char* home = std::getenv("HOME"); home && *home)
    return std::filesystem::path(home) / ".local" / "state" / "volute" / "recent";
  return {};
}

}  // namespace volute
