// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/input_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "volute/base/read_files.hpp"

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

/// The descriptor that a name stands for; nothing of other names.
std::optional<int> descriptorOf(const std::string& path) {
  if (path == "/dev/stdin")
    return STDIN_FILENO;
  for (const std::string_view prefix : {"/dev/fd/", "/proc/self/fd/"}) {
    int number = 0;
    const char* const end = path.data() + path.size();
    if (path.starts_with(prefix) && path.size() > prefix.size() &&
        std::from_chars(path.data() + prefix.size(), end, number).ptr == end)
      return number;
  }
  return std::nullopt;
}

/// Raises the limit of open files to what the system allows this program: the usual one of 1024 is
/// less than a large case has files.
bool allowMoreFiles() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= limit.rlim_max)
    return false;
  limit.rlim_cur = limit.rlim_max;
  return setrlimit(RLIMIT_NOFILE, &limit) == 0;
}

}  // namespace

Result<InputFile> InputFile::open(const std::filesystem::path& path) {
  // Without O_NONBLOCK a pipe that nobody writes to is waited for, and so are some devices. Regular
  // files do not know it.
  constexpr int kHow = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;
  noteReadName(path);
  int descriptor = ::open(path.c_str(), kHow);
  if (descriptor < 0 && errno == EMFILE && allowMoreFiles())
    descriptor = ::open(path.c_str(), kHow);
  const int reason = errno;
  struct stat status{};
  if (descriptor < 0) {
    if (reason == ENXIO && ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
      return notRegular(path, status.st_mode);
    if (reason == EMFILE) {
      return fail(
          ErrorCode::kIo,
          "{}: cannot open: all files that the system lets one program open are open; raise "
          "the limit (ulimit -n)",
          path.string());
    }
    const ErrorCode code = reason == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
    return failIn(path.string(), "", code, "cannot open: {}", std::strerror(reason));
  }
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor);
    return notRegular(path, status.st_mode);
  }
  noteRead(status.st_dev, status.st_ino);
  return InputFile(descriptor, static_cast<std::uint64_t>(status.st_size), path);
}

Status InputFile::spool(const std::string& path) {
  const auto number = descriptorOf(path);
  struct stat of{};
  if (!number || ::fstat(*number, &of) != 0 || (!S_ISFIFO(of.st_mode) && !S_ISSOCK(of.st_mode)))
    return {};
  const int pipe = *number;
  const char* folder = std::getenv("TMPDIR");
  int file = ::open(folder && *folder ? folder : "/tmp", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file < 0)  // not all file systems have files without names
    file = ::memfd_create("volute-input", MFD_CLOEXEC);
  const auto failed = [&](const char* what) {
    const int reason = errno;
    if (file >= 0)
      ::close(file);
    return fail(ErrorCode::kIo, "{}: {}: {}", path, what, std::strerror(reason));
  };
  if (file < 0)
    return failed("no place for what comes out of the pipe");
  std::vector<char> block(1 << 16);
  for (;;) {
    const ssize_t count = ::read(pipe, block.data(), block.size());
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0)
      return failed("cannot read");
    if (count == 0)
      break;
    for (ssize_t done = 0; done < count;) {
      const ssize_t written =
          ::write(file, block.data() + done, static_cast<std::size_t>(count - done));
      if (written < 0 && errno == EINTR)
        continue;
      if (written < 0)
        return failed("no place for what comes out of the pipe");
      done += written;
    }
  }
  if (::dup2(file, pipe) < 0)
    return failed("cannot read");
  ::close(file);
  return {};
}

InputFile InputFile::ofBytes(std::span<const std::byte> bytes, const std::string& name) {
  InputFile file(-1, bytes.size(), name);
  file.bytes_ = bytes.data();
  return file;
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
      path_(std::move(other.path_)),
      bytes_(other.bytes_) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  std::swap(path_, other.path_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

Status InputFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  if (bytes_ && offset <= size_ && bytes.size() <= size_ - offset) {
    std::copy_n(bytes_ + offset, bytes.size(), bytes.begin());
    return {};
  }
  if (bytes_)
    return fail(ErrorCode::kTruncated, "{}: ends at byte {}", path_.string(), size_);
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
