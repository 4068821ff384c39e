// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volute/gl/gl_smoke.hpp"
#include "volute/lighting/light_cache.hpp"
#include "volute/viewer/document.hpp"

namespace volute {

/// How documents are opened.
struct DocumentOptions {
  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes]
  std::string file{};                                ///< that `members` are said of
  /// Of its entry in a scene, where it is a file alone.
  nlohmann::ordered_json members = nlohmann::ordered_json::object();
  std::shared_ptr<const LightCache>
      lightCache{};  ///< where light of lamps in smoke is looked for and kept
  GlSmokeMethod smokeMethod = GlSmokeMethod::kAuto;
  std::optional<double> beginAt{};  ///< [s] `file` must have something there
  std::vector<std::string> more{};  ///< files that are shown beside `file`
};

/// Opens whatever the viewer shows: a scene, a volume, a map of fog, smoke on a mesh, an FDS case,
/// a capture of any kind.
OpenDocument documentOpener(DocumentOptions options);

}  // namespace volute
