// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

namespace volute {

/// Whether a file that another file names lies below that one's folder: an untrusted file does not
/// get to read the rest of the machine. The system itself follows the path, links included, where
/// it knows how (openat2 with RESOLVE_BENEATH, Linux 5.6); what is not there, and paths from the
/// root, are compared as they are spelt once links are followed.
inline bool isBelowFolder(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code error;
  const auto inside = std::filesystem::weakly_canonical(file, error);
  if (error)
    return false;
  const auto root = std::filesystem::weakly_canonical(folder, error);
  const auto relative = inside.lexically_relative(root);
  if (error || relative.empty() || *relative.begin() == "..")
    return false;
  const int base = ::open(root.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (base < 0)
    return true;  // nothing can be opened in it
  open_how how{};
  how.flags = O_PATH | O_CLOEXEC;
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
  const long opened = ::syscall(SYS_openat2, base, relative.c_str(), &how, sizeof how);
  const bool leads = opened < 0 && (errno == EXDEV || errno == ELOOP);
  if (opened >= 0)
    ::close(static_cast<int>(opened));
  ::close(base);
  return !leads;
}

}  // namespace volute
