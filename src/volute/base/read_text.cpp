// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/read_text.hpp"

#include "volute/base/input_file.hpp"

namespace volute {

Result<std::string> readText(const std::filesystem::path& path, std::uint64_t most) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  if (file.size() > most) {
    return fail(ErrorCode::kTooLarge, "{}: {} bytes of text are too many; expected at most {}",
                path.string(), file.size(), most);
  }
  std::string text(file.size(), '\0');
  VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(text))));
  return text;
}

}  // namespace volute
