// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/inline_picture.hpp"

#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/input_file.hpp"

namespace volute::cli {
namespace {

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group =
          group << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kLetters[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace

Result<std::string> inlinePicture(const std::filesystem::path& png) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(png));
  std::vector<std::byte> bytes(file.size());
  VOLUTE_TRY(file.read(0, bytes));
  return "data:image/png;base64," + base64(bytes);
}

}  // namespace volute::cli
