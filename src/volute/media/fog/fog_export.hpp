// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>

#include "volute/fog/fog_medium.hpp"

namespace volute {

/// Writes into a folder, which is made where it is missing: fog.glsl (the functions),
/// fog_polar.glsl where the profile allows one, fog_map.f32 (the texture), fog.json (its size, the
/// uniforms) and README.md. Errors: of the folder, and of a fog that shaders cannot have.
[[nodiscard]] Status exportFogShader(const FogMedium& fog, const std::filesystem::path& folder);

}  // namespace volute
