// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "volute/optics/visibility.hpp"
#include "volute/render/sign.hpp"

namespace volute {

/// The "signs" of a scene: a list of {"name", "position", "normal", "size", "emitting", "C",
/// "picture"}. Reads their pictures. Errors name the file and the path inside it.
[[nodiscard]] Result<std::vector<Sign>> parseSigns(const nlohmann::json& json,
                                                   const std::string& file,
                                                   const std::string& path);

/// Adds to a picture what is seen of signs: each picture through the transmittance of its own law,
/// over the light of the smoke before it, which is there already (Staubli et al. 2005, equation
/// 15). `depth` is the optical depth up to the sign, natural logarithm.
void addSigns(std::span<const SignPixel> pixels, std::span<const Sign> signs, const Image& depth,
              const PictureLaw& law, Image& image);

}  // namespace volute
