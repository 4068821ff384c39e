// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <sstream>
#include <string>

// In place of the one that SZ3's own build makes.
#define SZ3_MAGIC_NUMBER 0xF342F310
#define SZ3_NAME "SZ3"
#define SZ3_VER "3.0.0"
#define SZ3_DATA_VER "3.0.0"

/// "3.1.2" in a number.
inline std::uint32_t versionInt(const std::string& version) {
  std::uint32_t major = 0, minor = 0, patch = 0;
  char dot = 0;
  std::stringstream(version) >> major >> dot >> minor >> dot >> patch;
  return major << 24 | minor << 16 | patch << 8;
}

inline std::string versionStr(std::uint32_t version) {
  return std::to_string(version >> 24) + "." + std::to_string(version >> 16 & 255) + "." +
         std::to_string(version >> 8 & 255);
}
