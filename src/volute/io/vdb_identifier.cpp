// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/vdb_identifier.hpp"

#include <fmt/format.h>

#include <fstream>
#include <string_view>

namespace volute {
namespace {

constexpr std::string_view kSame = "-0000-4000-8000-0000";  // in all of ours
constexpr int kContentDigits = 8;

}  // namespace

std::string vdbIdentifier(std::uint32_t content, int number) {
  return fmt::format("{:08x}{}{:08x}", content, kSame, static_cast<std::uint32_t>(number));
}

bool hasOwnIdentifier(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string found(kSame.size(), '\0');
  stream.seekg(kVdbIdentifierPlace + kContentDigits);
  stream.read(found.data(), static_cast<std::streamsize>(found.size()));
  return stream && found == kSame;
}

}  // namespace volute
