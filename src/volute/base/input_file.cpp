// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/input_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace volute {

namespace {

tl::unexpected<Error> notRegular(const std::filesystem::path& path, mode_t mode) {
  const char* what = S_ISDIR(mode)                    ? "a folder"
                     : S_ISFIFO(mode)                 ? "a pipe"
                     : S_ISSOCK(mode)                 ? "a socket"
                     : S_ISCHR(mode) || S_ISBLK(mode) ? "a device"
                                                      : "something else";
  return fail(ErrorCode::kIo, "{}: not a regular file: it is {}; give a file that lies on a disk",
              path.string(), what);
}

}  // namespace

Result<InputFile> InputFile::open(const std::filesystem::path& path) {
  // Without O_NONBLOCK a pipe that nobody writes to is waited for, and so are some devices. Regular
  // files do not know it.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  const int reason = errno;
  struct stat status{};
  if (descriptor < 0) {
    if (reason == ENXIO && ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
      return notRegular(path, status.st_mode);
    const ErrorCode code = reason == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
    return fail(code, "{}: cannot open: {}", path.string(), std::strerror(reason));
  }
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor);
    return notRegular(path, status.st_mode);
  }
  return InputFile(descriptor, static_cast<std::uint64_t>(status.st_size), path);
}

Status InputFile::check(const std::filesystem::path& path) {
  VOLUTE_TRY(open(path));
  return {};
}

InputFile::~InputFile() {
  if (descriptor_ >= 0)
    ::close(descriptor_);
}

InputFile::InputFile(InputFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_),
      path_(std::move(other.path_)) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  std::swap(path_, other.path_);
  return *this;
}

Status InputFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t count =
        ::pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0)
      return fail(ErrorCode::kIo, "{}: cannot read at byte {}: {}", path_.string(), offset,
                  std::strerror(errno));
    if (count == 0) {
      return fail(ErrorCode::kTruncated, "{}: ends at byte {}, {} bytes short", path_.string(),
                  size_, bytes.size());
    }
    offset += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

}  // namespace volute
