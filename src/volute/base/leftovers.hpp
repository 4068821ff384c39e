// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

namespace volute {

/// The process that a temporary file or folder of ours belongs to, by its name:
/// .STEM.PROCESS.COUNT.partEXTENSION (PendingFile, PendingFolder); nothing for other names.
std::optional<pid_t> processOfPart(std::string_view name);

/// Whether a process of this machine has that number. Parts of other machines, in a folder that is
/// shared, look as if theirs were gone.
bool isRunning(pid_t process);

/// Temporary files and folders of ours in a folder whose process is gone: it was killed.
std::vector<std::filesystem::path> leftoversIn(const std::filesystem::path& folder);

}  // namespace volute
