// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace volute {

/// The first of these programs that is in a folder of the PATH; empty when none is.
std::string findProgram(std::initializer_list<std::string_view> names);

/// Runs a program with neither input nor output, and waits for it.
/// @param words  the program's path, then its arguments.
/// @param seconds  after which it is killed.
/// @return false if it was: what it did is told by the files that it wrote.
bool runProgram(std::vector<std::string> words, double seconds);

/// A folder of this process alone, in the machine's folder for temporary files; removed with what
/// is in it at the end. Its path is empty where it cannot be made.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();

  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace volute
