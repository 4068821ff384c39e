// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/write_file.hpp"

#include "volute/base/output_file.hpp"

namespace volute {

Status writeFile(const std::filesystem::path& target, std::span<const std::byte> bytes) {
  VOLUTE_ASSIGN(auto file, OutputFile::create(target));
  VOLUTE_TRY(file.write(bytes));
  return file.commit();
}

Status writeFile(const std::filesystem::path& target, std::string_view text) {
  return writeFile(target, std::as_bytes(std::span(text)));
}

}  // namespace volute
