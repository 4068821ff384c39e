// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

namespace volute {

/// The files that a .json, a scene or a capture, may name: all its texts, taken as names from its
/// folder. Nothing of other files, and of what cannot be read: who reads it says what is wrong.
std::vector<std::string> filesNamedIn(const std::string& file);

/// Texts of a .json, and of those that it names, that lead out of its folder when they are taken as
/// names of files, of folders or of patterns, links followed: a stranger's scene would read what it
/// wants of this machine.
std::vector<std::string> namesOutside(const std::string& file);

}  // namespace volute
