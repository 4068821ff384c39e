// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/output_folder.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "volute/base/file_name.hpp"
#include "volute/base/leftovers.hpp"
#include "volute/base/output_file.hpp"
#include "volute/base/output_place.hpp"

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

/// How often a check or commit() begins again when other runs are at work on the same target.
constexpr int kRounds = 1000;

/// A folder with files in it has the name.
bool isTaken(int reason) {
  return reason == ENOTEMPTY || reason == EEXIST;
}

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

/// Whether the folder open as `descriptor` has no entries.
bool isEmpty(int descriptor) {
  const std::unique_ptr<DIR, int (*)(DIR*)> listing(::fdopendir(::dup(descriptor)), ::closedir);
  if (!listing)
    return false;
  while (const dirent* entry = ::readdir(listing.get())) {
    const std::string_view name = entry->d_name;
    if (name != "." && name != "..")
      return false;
  }
  return true;
}

/// No folder is there, or an empty one, or one with `mark` in it. Other runs may replace it
/// meanwhile, so that all is asked of one folder, and again when that one lost its name.
Status checkReplaceable(const fs::path& target, std::string_view mark) {
  for (int round = 0; round < kRounds; ++round) {
    const int folder = ::open(target.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) {
      if (errno == ENOENT)
        return {};
      if (errno == ENOTDIR)
        return fail(ErrorCode::kIo, "{}: is there and is no folder; expected a new one",
                    target.string());
      return fail(ErrorCode::kIo, "{}: cannot read this folder: {}", target.string(),
                  std::strerror(errno));
    }
    const bool replaceable =
        ::faccessat(folder, std::string(mark).c_str(), F_OK, 0) == 0 || isEmpty(folder);
    struct stat asked{}, named{};
    const bool isSame = ::fstat(folder, &asked) == 0 && ::stat(target.c_str(), &named) == 0 &&
                        asked.st_dev == named.st_dev && asked.st_ino == named.st_ino;
    ::close(folder);
    if (replaceable)
      return {};
    if (isSame)
      break;
  }
  return fail(ErrorCode::kIo,
              "{}: holds files of something else (there is no {} in it); expected a new folder or "
              "one of ours to replace",
              target.string(), mark);
}

/// Names of the results, a line each, so that what people put beside them is not taken for one.
constexpr const char* kList = ".files";

Status writeList(const fs::path& folder) {
  std::ofstream list(folder / kList);
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
    if (!entry.is_directory())
      list << entry.path().lexically_relative(folder).string() << '\n';
  }
  list.close();
  return list ? sync(folder / kList)
              : fail(ErrorCode::kIo, "{}: cannot write", (folder / kList).string());
}

/// Removes a folder that was replaced, but for files that its list does not name: they go to the
/// new one. Folders of versions without a list hold results alone.
Status removeResults(const fs::path& old, const fs::path& target) {
  std::error_code error;
  if (std::ifstream list(old / kList); list) {
    std::set<std::string> results;
    for (std::string line; std::getline(list, line);) results.insert(line);
    std::vector<fs::path> kept;
    for (const auto& entry : fs::recursive_directory_iterator(old, error)) {
      const fs::path name = entry.path().lexically_relative(old);
      const bool isFolder = entry.is_directory(error) && !entry.is_symlink(error);
      if (!isFolder && !results.contains(name.string()))
        kept.push_back(name);
    }
    for (const fs::path& name : kept) {
      fs::path to = target / name;
      while (fs::exists(fs::symlink_status(to, error))) to += ".kept";
      fs::create_directories(to.parent_path(), error);
      fs::rename(old / name, to, error);
      if (error)
        return fail(ErrorCode::kIo, "{}: cannot move it to the new results: {}",
                    (old / name).string(), error.message());
    }
  }
  fs::remove_all(old, error);
  return {};
}

}  // namespace

Result<PendingFolder> PendingFolder::create(const fs::path& wanted, std::string_view mark) {
  const fs::path target = withoutSlash(wanted);
  VOLUTE_ASSIGN(const auto place, outputPlace(target, target.string()));
  restoreReplaced(place);
  VOLUTE_TRY(checkReplaceable(target, mark));
  std::error_code error;
  auto temporary = siblingOf(
      place, fmt::format(".{}.{}.0.part", place.filename().string().substr(0, 200), ::getpid()));
  fs::remove_all(temporary, error);
  // Memory may end here, before the folder is.
  PendingFolder pending(std::move(temporary), target, place);
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
    : temporary_(std::exchange(other.temporary_, {})),
      target_(std::move(other.target_)),
      place_(std::move(other.place_)) {}

Status PendingFolder::commit() {
  VOLUTE_TRY(checkNotWithheld(target_.string()));
  VOLUTE_TRY(writeList(temporary_));
  VOLUTE_TRY(sync(temporary_));
  const fs::path replaced = fs::path(temporary_).replace_extension(kReplaced);
  std::error_code ignored;
  // Another run may put its folder there or take it away between any two of these calls; each such
  // case is the next round's. Whoever comes last stays.
  for (int round = 0; round < kRounds; ++round) {
    // The old one and the new one change places at once, where the file system can.
    if (::renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, place_.c_str(), RENAME_EXCHANGE) == 0) {
      VOLUTE_TRY(removeResults(std::exchange(temporary_, {}), place_));
      return syncParent(place_);
    }
    const bool canExchange = errno != EINVAL && errno != ENOSYS;
    // Nothing is there, or an empty folder.
    if (::rename(temporary_.c_str(), place_.c_str()) == 0) {
      temporary_.clear();
      return syncParent(place_);
    }
    if (!isTaken(errno))
      break;
    if (canExchange)
      continue;
    if (::rename(place_.c_str(), replaced.c_str()) != 0) {
      if (errno == ENOENT)
        continue;
      break;
    }
    if (::rename(temporary_.c_str(), place_.c_str()) == 0) {
      temporary_.clear();
      VOLUTE_TRY(removeResults(replaced, place_));
      return syncParent(place_);
    }
    const int reason = errno;
    if (::rename(replaced.c_str(), place_.c_str()) != 0 && isTaken(errno))
      fs::remove_all(replaced, ignored);
    if (!isTaken(reason)) {
      errno = reason;
      break;
    }
  }
  return fail(ErrorCode::kIo, "{}: cannot finish writing: {}", target_.string(),
              std::strerror(errno));
}

}  // namespace volute
