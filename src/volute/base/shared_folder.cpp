// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/shared_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace volute {
namespace {

namespace fs = std::filesystem;

/// Whether a path still leads to the folder that was opened.
bool isStill(const fs::path& path, int descriptor) {
  struct stat named{}, opened{};

  return ::stat(path.c_str(), &named) == 0 && ::fstat(descriptor, &opened) == 0 &&
         named.st_dev == opened.st_dev && named.st_ino == opened.st_ino;
}

void closeIf(int descriptor) {
  if (descriptor >= 0)
    ::close(descriptor);
}

}  // namespace

Result<SharedFolder> SharedFolder::open(const fs::path& path, std::string_view purpose) {
  for (;;) {
    std::error_code error;
    fs::create_directory(path, error);
    const int lock = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock < 0 && errno == ENOENT && !error)
      continue;  // another process removed it in between
    if (lock < 0)
      return fail(ErrorCode::kIo, "{}: cannot make this folder for {}", path.string(), purpose);
    while (::flock(lock, LOCK_SH) != 0 && errno == EINTR) {
    }
    if (isStill(path, lock))
      return SharedFolder(path, lock);
    ::close(lock);
  }
}

SharedFolder::SharedFolder(SharedFolder&& other) noexcept
    : path_(std::move(other.path_)), lock_(std::exchange(other.lock_, -1)) {}

SharedFolder& SharedFolder::operator=(SharedFolder&& other) noexcept {
  closeIf(std::exchange(lock_, std::exchange(other.lock_, -1)));
  path_ = std::move(other.path_);
  return *this;
}

SharedFolder::~SharedFolder() {
  closeIf(lock_);
}

bool SharedFolder::isOnlyUser() const {
  return ::flock(lock_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

}  // namespace volute
