// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace volute {

/// The first of these programs that is in a folder of the PATH; empty when none is.
std::string findProgram(std::initializer_list<std::string_view> names);

/// Limits and standard streams of a program that is started.
struct ProgramLimits {
  double seconds = 60;                 ///< after which it is killed
  std::uint64_t memory = 0;            ///< [bytes] of address space; 0: any
  std::filesystem::path input{};       ///< its standard input; empty: nothing
  std::filesystem::path output{};      ///< its standard output, a file that is there; empty: nobody
                                       ///< reads it
  std::function<bool()> confine = {};  ///< called in its process before it begins, which it does
                                       ///< not where this is false
};

/// Runs a program and waits for it.
/// @param words  the program's path, then its arguments.
/// @return false if it was killed after its time: what it did is told by the files that it wrote.
bool runProgram(std::vector<std::string> words, const ProgramLimits& limits);

/// A folder of this process alone, in the machine's folder for temporary files; removed with what
/// is in it at the end. Its path is empty where it cannot be made.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();

  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace volute
