// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/leftovers.hpp"

#include <signal.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <string>

namespace volute {
namespace {

/// Takes ".NUMBER" off the end of a name.
std::optional<int> takeNumber(std::string_view& name) {
  const std::size_t dot = name.rfind('.');
  if (dot == name.npos)
    return std::nullopt;
  const std::string_view digits = name.substr(dot + 1);
  int number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size() || number < 0)
    return std::nullopt;
  name = name.substr(0, dot);
  return number;
}

}  // namespace

std::optional<pid_t> processOfPart(std::string_view name) {
  const std::size_t part = name.rfind(".part");
  if (part == name.npos || !name.starts_with('.'))
    return std::nullopt;
  const std::string_view extension = name.substr(part + 5);
  if (!extension.empty() && extension[0] != '.')
    return std::nullopt;
  std::string_view rest = name.substr(0, part);
  if (rest.ends_with(".old"))
    rest.remove_suffix(4);
  const auto count = takeNumber(rest);
  const auto process = takeNumber(rest);
  if (!count || !process || *process == 0)
    return std::nullopt;
  return *process;
}

bool isRunning(pid_t process) {
  return ::kill(process, 0) == 0 || errno != ESRCH;
}

std::vector<std::filesystem::path> leftoversIn(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> parts;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    const auto process = processOfPart(at->path().filename().string());
    if (process && !isRunning(*process))
      parts.push_back(at->path());
  }
  std::ranges::sort(parts);
  return parts;
}

}  // namespace volute
