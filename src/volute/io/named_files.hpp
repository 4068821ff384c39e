// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace volute {

/// The files that a .json, a scene or a capture, may name: all its texts, taken as names from its
/// folder. Nothing of other files, and of what cannot be read: who reads it says what is wrong.
std::vector<std::string> filesNamedIn(const std::string& file);

/// What the DataSets of a .pvd call their files, as it stands there; nothing of what cannot be
/// read.
std::vector<std::string> namesInCollection(const std::filesystem::path& collection);

/// What may be a file's name in an FDS case's index (.smv): its lines, each once, and after "INPF"
/// always, with "/" between folders; likewise.
std::vector<std::string> namesInCase(const std::filesystem::path& index);

/// What an FDS input says is to be read with it (CATF), with "/" between folders; likewise.
std::vector<std::string> namesInInput(const std::filesystem::path& input);

/// Texts of a .json, .pvd or .smv, of the inputs of FDS, and of those that it names, that lead out
/// of their folder when they are taken as names of files, of folders or of patterns, links
/// followed, and as FilesAsWritten finds them: a stranger's scene would read what it wants of this
/// machine.
std::vector<std::string> namesOutside(const std::string& file);

}  // namespace volute
