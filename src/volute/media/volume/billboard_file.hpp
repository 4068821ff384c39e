// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "volute/media/volume/volume_layer.hpp"
#include "volute/render/billboard.hpp"

namespace volute {

/// An entry of a scene's "billboards".
struct SceneBillboard {
  std::string file;  ///< of the volume
  Appearance appearance;
  BillboardOptions options;
};

/// {"volume", "position", "size", "alpha", "emission", "extinction", "time", "rows"}. Errors name
/// the file and the path inside it.
[[nodiscard]] Result<SceneBillboard> parseBillboard(const nlohmann::json& json,
                                                    const std::string& file,
                                                    const std::string& path);

}  // namespace volute
