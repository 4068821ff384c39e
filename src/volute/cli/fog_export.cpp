// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/fog_export.hpp"

namespace volute::cli {
Status exportFogShader(const FogMedium&, const std::filesystem::path&) {
  return {};
}
}  // namespace volute::cli
