// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/media/field.hpp"
#include "volute/optics/visibility.hpp"
#include "volute/render/sign.hpp"

namespace volute {

const FieldTable& signFields();

/// The "signs" of a scene. Reads their pictures.
[[nodiscard]] Result<std::vector<Sign>> parseSigns(const nlohmann::json& json,
                                                   const FieldOrigin& origin);

/// Adds to a picture what is seen of signs: each picture through the transmittance of its own law,
/// over the light of the smoke before it, which is there already (Staubli et al. 2005, equation
/// 15). `depth` is the optical depth up to the sign, natural logarithm.
void addSigns(std::span<const SignPixel> pixels, std::span<const Sign> signs, const Image& depth,
              const PictureLaw& law, Image& image);

}  // namespace volute
