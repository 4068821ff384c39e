// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include "volute/base/file_name.hpp"
#include "volute/base/output_place.hpp"
#include "volute/base/read_files.hpp"

namespace volute {
namespace {

std::atomic<bool> outputsWithheld = false;

Status checkReplaceable(const std::filesystem::path& place, mode_t mode, const std::string& name) {
  if (!S_ISREG(mode))
    return fail(ErrorCode::kIo, "{}: is there and is no regular file; give another name", name);
  if (::access(place.c_str(), W_OK) != 0) {
    return fail(ErrorCode::kIo,
                "{}: is there and is write-protected (mode {:04o}); give another name, or allow "
                "writing to it",
                name, mode & 07777);
  }
  return {};
}

Status syncPath(const std::filesystem::path& path, const std::string& name) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  const int reason = errno;
  if (descriptor >= 0)
    ::close(descriptor);
  if (!synced)
    return fail(ErrorCode::kIo, "{}: cannot finish writing: {}", name, std::strerror(reason));
  return {};
}

/// So that the name is there after a power cut too. Some file systems sync no folders.
Status syncFolderOf(const std::filesystem::path& path, const std::string& name) {
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0)
    return {};  // may be written to, and not be read
  const bool synced = ::fsync(descriptor) == 0 || errno == EINVAL || errno == EROFS;
  const int reason = errno;
  ::close(descriptor);
  if (!synced)
    return fail(ErrorCode::kIo, "{}: cannot finish writing: {}", name, std::strerror(reason));
  return {};
}

}  // namespace

PendingFile::PendingFile(std::filesystem::path target, std::filesystem::path place,
                         std::string name)
    : target_(std::move(target)), place_(std::move(place)), name_(std::move(name)) {}

Result<PendingFile> PendingFile::create(const std::filesystem::path& target,
                                        const std::string& name) {
  static std::atomic<unsigned> counter{0};
  const std::string shown = name.empty() ? target.string() : name;
  VOLUTE_ASSIGN(const auto place, outputPlace(target, shown));
  PendingFile pending(target, place, shown);  // before the file is there: memory may end here
  struct stat old{};
  const bool replaces = ::stat(place.c_str(), &old) == 0;
  if (replaces)
    VOLUTE_TRY(checkReplaceable(place, old.st_mode, shown));
  constexpr std::size_t kLongestStem = 200, kLongestExtension = 20;  // of 255 bytes
  auto temporary = siblingOf(
      place,
      fmt::format(".{}.{}.{}.part{}", place.stem().string().substr(0, kLongestStem), ::getpid(),
                  counter++, place.extension().string().substr(0, kLongestExtension)));
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return failIn(shown, "", ErrorCode::kIo, "cannot write into its folder: {}",
                  std::strerror(errno));
  }
  if (replaces) {
    // Another owner is root's to give, and a change of owner takes bits of the mode away.
    (void)!::fchown(descriptor, old.st_uid, old.st_gid);
    (void)::fchmod(descriptor, old.st_mode & 07777);
  }
  ::close(descriptor);
  pending.temporary_ = std::move(temporary);
  return pending;
}

PendingFile::~PendingFile() {
  if (!temporary_.empty())
    ::unlink(temporary_.c_str());
}

PendingFile::PendingFile(PendingFile&& other) noexcept
    : temporary_(std::exchange(other.temporary_, {})),
      target_(std::move(other.target_)),
      place_(std::move(other.place_)),
      name_(std::move(other.name_)) {}

PendingFile& PendingFile::operator=(PendingFile&& other) noexcept {
  std::swap(temporary_, other.temporary_);
  std::swap(target_, other.target_);
  std::swap(place_, other.place_);
  std::swap(name_, other.name_);
  return *this;
}

Status PendingFile::commit() {
  VOLUTE_TRY(checkNotWithheld(name_));
  if (isProtected(target_, place_)) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: is read by this run and would be replaced; give another name", name_);
  }
  VOLUTE_TRY(syncPath(temporary_, name_));
  if (::rename(temporary_.c_str(), place_.c_str()) != 0)
    return fail(ErrorCode::kIo, "{}: cannot finish writing: {}", name_, std::strerror(errno));
  temporary_.clear();
  return syncFolderOf(place_, name_);
}

void withholdOutputs(bool withheld) {
  outputsWithheld = withheld;
}

Status checkNotWithheld(const std::string& name) {
  if (outputsWithheld)
    return fail(ErrorCode::kCancelled, "{}: not written: the run failed before", name);
  return {};
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& target,
                                      const std::string& name) {
  if (target == "-")
    return OutputFile(::dup(STDOUT_FILENO), nullptr);
  VOLUTE_ASSIGN(auto pending, PendingFile::create(target, name));
  const int descriptor = ::open(pending.path().c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0)
    return fail(ErrorCode::kIo, "{}: cannot write: {}", pending.name(), std::strerror(errno));
  return OutputFile(descriptor, std::make_unique<PendingFile>(std::move(pending)));
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0)
    ::close(descriptor_);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      pending_(std::move(other.pending_)),
      size_(other.size_) {}

std::string OutputFile::name() const {
  return pending_ ? pending_->name() : "standard output";
}

Status OutputFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0)
      return fail(ErrorCode::kIo, "{}: cannot write: {}", name(), std::strerror(errno));
    size_ += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

Status OutputFile::commit() {
  if (!pending_)
    return {};
  if (::close(std::exchange(descriptor_, -1)) != 0) {
    return fail(ErrorCode::kIo, "{}: cannot finish writing: {}", name(), std::strerror(errno));
  }
  return pending_->commit();
}

}  // namespace volute
