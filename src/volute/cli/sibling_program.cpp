// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/sibling_program.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "volute/base/file_name.hpp"

namespace volute::cli {

Status becomeSibling(std::string_view name, std::string_view remedy, const Context& context) {
  std::error_code error;
  const auto program = siblingOf(std::filesystem::read_symlink("/proc/self/exe", error), name);
  std::vector<std::string> words{std::string(name)};
  words.insert(words.end(), context.words.begin(), context.words.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  ::execv(program.c_str(), pointers.data());
  if (errno == ENOENT)
    return fail(ErrorCode::kUnsupported, "{} is missing: {}", program.string(), remedy);
  return fail(ErrorCode::kIo, "{}: cannot run: {}", program.string(), std::strerror(errno));
}

}  // namespace volute::cli
