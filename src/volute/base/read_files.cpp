// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/read_files.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <mutex>
#include <set>
#include <utility>

namespace volute {
namespace {

struct ReadFiles {
  std::mutex mutex;
  std::set<std::pair<dev_t, ino_t>> read;
  std::vector<std::filesystem::path> targets;
  bool keepsNames = false;
  std::set<std::filesystem::path> names;
};

ReadFiles& readFiles() {
  static ReadFiles files;
  return files;
}

}  // namespace

void noteRead(dev_t device, ino_t number) {
  ReadFiles& files = readFiles();
  const std::scoped_lock lock(files.mutex);
  files.read.emplace(device, number);
}

void noteReadName(const std::filesystem::path& path) {
  ReadFiles& files = readFiles();
  const std::scoped_lock lock(files.mutex);
  if (files.keepsNames)
    files.names.insert(path);
}

ReadNames::ReadNames() {
  ReadFiles& files = readFiles();
  const std::scoped_lock lock(files.mutex);
  files.keepsNames = true;
}

ReadNames::~ReadNames() {
  ReadFiles& files = readFiles();
  const std::scoped_lock lock(files.mutex);
  files.keepsNames = false;
  files.names.clear();
}

std::vector<std::filesystem::path> ReadNames::names() const {
  ReadFiles& files = readFiles();
  const std::scoped_lock lock(files.mutex);
  return {files.names.begin(), files.names.end()};
}

void protectWhatIsRead(std::vector<std::filesystem::path> targets) {
  ReadFiles& files = readFiles();
  const std::scoped_lock lock(files.mutex);
  files.targets = std::move(targets);
}

bool isProtected(const std::filesystem::path& target, const std::filesystem::path& place) {
  ReadFiles& files = readFiles();
  const std::scoped_lock lock(files.mutex);
  struct stat status{};
  return std::ranges::find(files.targets, target) != files.targets.end() &&
         ::stat(place.c_str(), &status) == 0 && files.read.contains({status.st_dev, status.st_ino});
}

}  // namespace volute
