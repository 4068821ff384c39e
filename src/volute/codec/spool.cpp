// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/spool.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace volute {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;

int openAnonymous(const std::filesystem::path& folder) {
#ifdef O_TMPFILE
  const int descriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (descriptor >= 0)
    return descriptor;
#endif
  // File systems without O_TMPFILE: a name that is gone at once.
  std::string name = (folder / ".volute-XXXXXX").string();
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0)
    ::unlink(name.c_str());
  return named;
}

}  // namespace

Result<Spool> Spool::create(const std::filesystem::path& folder) {
  const int descriptor = openAnonymous(folder);
  if (descriptor < 0) {
    return fail(ErrorCode::kIo, "{}: cannot make a temporary file: {}", folder.string(),
                std::strerror(errno));
  }
  return Spool(descriptor, folder.string());
}

Spool::~Spool() {
  if (descriptor_ >= 0)
    ::close(descriptor_);
}

Spool::Spool(Spool&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      folder_(std::move(other.folder_)),
      pending_(std::move(other.pending_)),
      written_(other.written_) {}

Status Spool::write(std::span<const std::byte> bytes) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  return pending_.size() < kPiece ? Status{} : flush();
}

Status Spool::clear() {
  pending_.clear();
  written_ = 0;
  if (::ftruncate(descriptor_, 0) != 0) {
    return fail(ErrorCode::kIo, "{}: cannot rewrite a temporary file: {}", folder_,
                std::strerror(errno));
  }
  return {};
}

Status Spool::flush() {
  std::span<const std::byte> left = pending_;
  while (!left.empty()) {
    const ssize_t count =
        ::pwrite(descriptor_, left.data(), left.size(), static_cast<off_t>(written_));
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0)
      return fail(ErrorCode::kIo, "{}: cannot write a temporary file: {}", folder_,
                  std::strerror(errno));
    written_ += static_cast<std::uint64_t>(count);
    left = left.subspan(static_cast<std::size_t>(count));
  }
  pending_.clear();
  return {};
}

Status Spool::read(std::uint64_t offset, std::span<std::byte> bytes) {
  VOLUTE_TRY(flush());
  while (!bytes.empty()) {
    const ssize_t count =
        ::pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR)
      continue;
    if (count <= 0) {
      return fail(ErrorCode::kIo, "{}: cannot read a temporary file back: {}", folder_,
                  count < 0 ? std::strerror(errno) : "it became shorter");
    }
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
  return {};
}

}  // namespace volute
