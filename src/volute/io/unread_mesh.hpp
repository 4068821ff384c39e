// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "volute/base/file_name.hpp"

namespace volute {

/// By its name, a mesh in a format that nothing here reads.
inline bool isUnreadMesh(const std::filesystem::path& path) {
  constexpr std::string_view kFormats[] = {".vtm",   ".vtmb", ".vts", ".pvts",  ".vtr", ".pvtr",
                                           ".cgns",  ".cas",  ".msh", ".xdmf",  ".xmf", ".plt",
                                           ".szplt", ".med",  ".unv", ".vtkhdf"};
  return std::ranges::find(kFormats, extensionOf(path)) != std::end(kFormats);
}

}  // namespace volute
