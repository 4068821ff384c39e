// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

namespace volute {
namespace {

Status writeAll(int descriptor, std::span<const std::byte> bytes, std::int64_t offset, const std::string& name) {
  while (!bytes.empty()) {
    const ssize_t count = offset < 0 ? ::write(descriptor, bytes.data(), bytes.size())
                                     : ::pwrite(descriptor, bytes.data(), bytes.size(), offset);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return fail(ErrorCode::kIo, "{}: cannot write: {}", name, std::strerror(errno));
    if (offset >= 0) offset += count;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

Status syncPath(const std::filesystem::path& path, const std::string& name) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  const int reason = errno;
  if (descriptor >= 0) ::close(descriptor);
  if (!synced) return fail(ErrorCode::kIo, "{}: cannot finish writing: {}", name, std::strerror(reason));
  return {};
}

}  // namespace

PendingFile::PendingFile(std::filesystem::path temporary, std::filesystem::path target)
    : temporary_(std::move(temporary)), target_(std::move(target)) {}

Result<PendingFile> PendingFile::create(const std::filesystem::path& target) {
  static std::atomic<unsigned> counter{0};
  auto temporary = target;
  temporary.replace_filename(fmt::format(".{}.{}.{}.part{}", target.stem().string(), ::getpid(), counter++,
                                         target.extension().string()));
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return fail(ErrorCode::kIo, "{}: cannot write into its folder: {}", target.string(), std::strerror(errno));
  }
  ::close(descriptor);
  return PendingFile(std::move(temporary), target);
}

PendingFile::~PendingFile() {
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

PendingFile::PendingFile(PendingFile&& other) noexcept
    : temporary_(std::exchange(other.temporary_, {})), target_(std::move(other.target_)) {}

PendingFile& PendingFile::operator=(PendingFile&& other) noexcept {
  std::swap(temporary_, other.temporary_);
  std::swap(target_, other.target_);
  return *this;
}

Status PendingFile::commit() {
  VOLUTE_TRY(syncPath(temporary_, target_.string()));
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) {
    return fail(ErrorCode::kIo, "{}: cannot finish writing: {}", target_.string(), std::strerror(errno));
  }
  temporary_.clear();
  return {};
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& target) {
  if (target == "-") return OutputFile(::dup(STDOUT_FILENO), nullptr);
  VOLUTE_ASSIGN(auto pending, PendingFile::create(target));
  const int descriptor = ::open(pending.path().c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return fail(ErrorCode::kIo, "{}: cannot write: {}", target.string(), std::strerror(errno));
  return OutputFile(descriptor, std::make_unique<PendingFile>(std::move(pending)));
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), pending_(std::move(other.pending_)), size_(other.size_) {}

std::string OutputFile::name() const { return pending_ ? pending_->target().string() : "standard output"; }

Status OutputFile::write(std::span<const std::byte> bytes) {
  VOLUTE_TRY(writeAll(descriptor_, bytes, -1, name()));
  size_ += bytes.size();
  return {};
}

Status OutputFile::overwrite(std::uint64_t offset, std::span<const std::byte> bytes) {
  return writeAll(descriptor_, bytes, static_cast<std::int64_t>(offset), name());
}

Status OutputFile::commit() {
  if (!pending_) return {};
  if (::close(std::exchange(descriptor_, -1)) != 0) {
    return fail(ErrorCode::kIo, "{}: cannot finish writing: {}", name(), std::strerror(errno));
  }
  return pending_->commit();
}

}  // namespace volute
