// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/output_folder.hpp"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <utility>

#include "volute/base/file_name.hpp"
#include "volute/base/leftovers.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

/// "FOLDER/" is FOLDER.
fs::path withoutSlash(const fs::path& target) {
  return target.has_filename() ? target : target.parent_path();
}

Status sync(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  if (descriptor >= 0)
    ::close(descriptor);
  if (!synced)
    return fail(ErrorCode::kIo, "{}: cannot finish writing", path.string());
  return {};
}

Status syncParent(const fs::path& target) {
  return sync(target.has_parent_path() ? target.parent_path() : fs::path("."));
}

/// What a folder is called while another takes its place.
constexpr const char* kReplaced = ".old.part";

/// A run that was killed after it moved the old folder away, and before the new one was there.
void restoreReplaced(const fs::path& target) {
  std::error_code error;
  if (fs::exists(target, error))
    return;
  const auto parent = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const std::string begin = fmt::format(".{}.", target.filename().string());
  for (const fs::path& part : leftoversIn(parent)) {
    const std::string name = part.filename().string();
    if (name.starts_with(begin) && name.ends_with(kReplaced)) {
      fs::rename(part, target, error);
      return;
    }
  }
}

}  // namespace

Result<PendingFolder> PendingFolder::create(const fs::path& wanted, std::string_view mark) {
  const fs::path target = withoutSlash(wanted);
  std::error_code error;
  restoreReplaced(target);
  if (fs::exists(target, error)) {
    if (!fs::is_directory(target, error))
      return fail(ErrorCode::kIo, "{}: is there and is no folder; expected a new one",
                  target.string());
    if (!fs::is_empty(target, error) && !fs::exists(target / mark, error)) {
      return fail(ErrorCode::kIo,
                  "{}: holds files of something else (there is no {} in it); expected a new folder "
                  "or one of ours to replace",
                  target.string(), mark);
    }
  }
  auto temporary =
      siblingOf(target, fmt::format(".{}.{}.0.part", target.filename().string(), ::getpid()));
  fs::remove_all(temporary, error);
  PendingFolder pending(std::move(temporary), target);  // memory may end here, before the folder is
  if (!fs::create_directory(pending.temporary_, error)) {
    pending.temporary_.clear();  // another's
    return fail(ErrorCode::kIo, "{}: cannot make this folder: {}", target.string(),
                error ? error.message() : "it is there");
  }
  return pending;
}

PendingFolder::~PendingFolder() {
  std::error_code error;
  if (!temporary_.empty())
    fs::remove_all(temporary_, error);
}

PendingFolder::PendingFolder(PendingFolder&& other) noexcept
    : temporary_(std::exchange(other.temporary_, {})), target_(std::move(other.target_)) {}

Status PendingFolder::commit() {
  VOLUTE_TRY(sync(temporary_));
  std::error_code error;
  // The old one and the new one change places at once, where the file system can.
  if (::renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0) {
    fs::remove_all(std::exchange(temporary_, {}), error);
    return syncParent(target_);
  }
  fs::path old;
  if (fs::exists(target_, error)) {
    old = temporary_;
    old.replace_extension(kReplaced);
    fs::rename(target_, old, error);
  }
  if (!error)
    fs::rename(temporary_, target_, error);
  if (error) {
    std::error_code ignored;
    if (!old.empty() && !fs::exists(target_, ignored))
      fs::rename(old, target_, ignored);
    return fail(ErrorCode::kIo, "{}: cannot finish writing: {}", target_.string(), error.message());
  }
  temporary_.clear();
  if (!old.empty())
    fs::remove_all(old, error);
  return syncParent(target_);
}

}  // namespace volute
