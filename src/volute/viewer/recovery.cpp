// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/recovery.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <utility>

#include "volute/base/number_word.hpp"

namespace volute {
namespace {

constexpr std::chrono::seconds kEvery{2};

std::filesystem::path nameBeside(const std::filesystem::path& scene) {
  return std::filesystem::path(scene).replace_extension(".name");
}

/// Whether the file's process runs; true where that cannot be told.
bool isAlive(const std::filesystem::path& scene) {
  long process = 0;
  if (!readNumber(scene.stem().string(), process) || process <= 0)
    return true;
  return ::kill(static_cast<pid_t>(process), 0) == 0 || errno != ESRCH;
}

bool writes(const std::filesystem::path& file, const std::string& text) {
  std::ofstream stream(file);
  stream << text << std::flush;
  return stream.good();
}

}  // namespace

bool Recovery::keep(const std::string& scene, const std::string& name) {
  const auto now = std::chrono::steady_clock::now();
  if (folder_.empty() || scene == kept_ || (now < next_ && !scene.empty()))
    return true;
  const std::filesystem::path file = folder_ / (std::to_string(::getpid()) + ".json");
  kept_ = scene;
  if (scene.empty()) {
    remove({file, ""});
    return true;
  }
  next_ = now + kEvery;
  std::error_code failed;
  std::filesystem::create_directories(folder_, failed);
  std::filesystem::permissions(folder_, std::filesystem::perms::owner_all, failed);
  // Not synced: that may take longer than a frame, and the machine itself seldom fails.
  const bool named = writes(nameBeside(file), name + "\n");
  const std::filesystem::path fresh = std::filesystem::path(file).replace_extension(".new");
  const bool written = named && writes(fresh, scene);
  if (written)
    std::filesystem::rename(fresh, file, failed);
  return (written && !failed) || std::exchange(fails_, true);
}

std::string Recovery::keepMended(const std::string& scene, const std::string& name) const {
  std::error_code failed;
  const auto folder = folder_.empty() ? std::filesystem::temp_directory_path(failed) /
                                            fmt::format("volute-{}", ::getuid()) / "unsaved"
                                      : folder_;
  std::filesystem::create_directories(folder, failed);
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all, failed);
  const auto file = folder / fmt::format("{}-mended.json", ::getpid());
  std::ofstream(nameBeside(file)) << name << "\n";
  std::ofstream(file) << scene;
  return file.string();
}

void Recovery::adopt(const std::string& path) {
  if (path == adopted_.string())
    return;
  if (!adopted_.empty())
    remove({adopted_, ""});
  adopted_ = nameOf(path) ? path : "";
}

std::optional<std::string> Recovery::nameOf(const std::string& path) {
  const std::filesystem::path scene = path;
  if (scene.extension() != ".json" || scene.parent_path().filename() != "unsaved")
    return std::nullopt;
  std::ifstream stream(nameBeside(scene));
  std::string name;
  return std::getline(stream, name) ? std::optional(name) : std::nullopt;
}

std::vector<Recovery::Lost> Recovery::lost() const {
  std::vector<Lost> lost;
  std::error_code unreadable;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, unreadable)) {
    if (entry.path().extension() != ".json" || isAlive(entry.path()))
      continue;
    if (const auto name = nameOf(entry.path().string()))
      lost.push_back({entry.path(), *name});
  }
  std::ranges::sort(lost, {}, &Lost::scene);
  return lost;
}

void Recovery::remove(const Lost& lost) {
  std::error_code gone;
  std::filesystem::remove(lost.scene, gone);
  std::filesystem::remove(nameBeside(lost.scene), gone);
}

}  // namespace volute
