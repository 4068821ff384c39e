// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/pdf.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

extern char** environ;

namespace volute {
namespace {

/// The first browser in the PATH; empty when there is none.
std::string findBrowser() {
  const char* path = std::getenv("PATH");
  for (const std::string_view name : {"chromium", "chromium-browser", "google-chrome"}) {
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

/// Starts a program with neither input nor output; its process, or -1.
pid_t start(std::vector<std::string> words) {
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

Status printPdf(const std::filesystem::path& html, const std::filesystem::path& pdf) {
  const std::string browser = findBrowser();
  if (browser.empty()) {
    return fail(ErrorCode::kUnsupported,
                "no PDF without chromium, chromium-browser or google-chrome in the PATH; report.html "
                "can be printed from any browser");
  }
  std::error_code error;
  std::array<char, 32> folder{"/tmp/volute-pdf-XXXXXX"};
  if (::mkdtemp(folder.data()) == nullptr)
    return fail(ErrorCode::kIo, "/tmp: cannot make a folder for the browser");
  std::vector<std::string> words{browser,
                                 "--headless",
                                 "--disable-gpu",
                                 "--disable-quic",
                                 "--disable-sync",
                                 "--disable-extensions",
                                 "--disable-background-networking",
                                 "--disable-component-update",
                                 "--no-first-run",
                                 "--host-resolver-rules=MAP * ~NOTFOUND",
                                 "--user-data-dir=" + std::string(folder.data()),
                                 "--no-pdf-header-footer",
                                 "--print-to-pdf=" + std::filesystem::absolute(pdf, error).string(),
                                 "file://" + std::filesystem::absolute(html, error).string()};
  if (::geteuid() == 0)
    words.insert(words.begin() + 1, "--no-sandbox");  // which root cannot have
  const pid_t process = start(words);
  int status = -1;
  bool ended = process < 0;
  constexpr int kSteps = 1200;  // of 0.1 s
  for (int i = 0; !ended && i < kSteps; ++i) {
    ended = ::waitpid(process, &status, WNOHANG) == process;
    if (!ended)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  if (!ended) {
    ::kill(process, SIGKILL);
    ::waitpid(process, &status, 0);
  }
  std::filesystem::remove_all(folder.data(), error);
  if (!std::filesystem::exists(pdf, error)) {
    return fail(ErrorCode::kIo, "{}: {} made no PDF of report.html{}", pdf.filename().string(),
                browser, ended ? "" : " within two minutes");
  }
  return {};
}

}  // namespace volute
