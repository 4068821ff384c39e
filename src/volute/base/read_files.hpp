// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <vector>

// Which files this process has read: a case names many, and one of them may be what somebody calls
// an output.

namespace volute {

/// InputFile notes each file that it opens.
void noteRead(dev_t device, ino_t number);

/// From now on PendingFile::commit() replaces none of these that has been read; it is refused with
/// kInvalidArgument.
void protectWhatIsRead(std::vector<std::filesystem::path> targets);

/// Whether `target` is protected, and the file that is at `place` now has been read.
[[nodiscard]] bool isProtected(const std::filesystem::path& target,
                               const std::filesystem::path& place);

}  // namespace volute
