// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace volute {

/// The files that a name of a scene stands for: itself; the files of a .pvd collection; the
/// results of an FDS case; of a pattern those that are there, and the one that would follow them.
std::vector<std::filesystem::path> filesOf(const std::string& name);

}  // namespace volute
