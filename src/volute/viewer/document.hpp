// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/gl/gl_scene.hpp"
#include "volute/math/box.hpp"

namespace volute {

/// From where a document wants to be seen first.
struct StartView {
  Vec3 eye = Vec3(0, -1, 0);
  Vec3 target = Vec3::Zero();
  Vec3 up = Vec3::UnitZ();
  double fov = 40;  ///< vertical [degrees]
};

/// A file that the viewer shows. Only the loader's thread calls it, one call at a time, once it is
/// open; what it says of itself does not change.
class Document {
 public:
  virtual ~Document() = default;

  virtual std::string title() const = 0;          ///< "fire.volute, 64 x 64 x 64 voxels, 48 frames"
  virtual Box3 bounds() const = 0;                ///< finite [m]
  virtual std::vector<double> times() const = 0;  ///< [s] when frames begin; one at least
  virtual bool grey() const = 0;                  ///< one channel: colour maps apply

  virtual std::optional<StartView> startView() const { return std::nullopt; }

  virtual Rgb background() const { return Rgb::Zero(); }

  virtual std::vector<std::string> remarks() const { return {}; }  ///< what is not shown

  virtual std::vector<std::filesystem::path> files() const = 0;  ///< to be watched

  /// Whether a coarse scene at this time is there much sooner than the fine one.
  virtual bool coarseHelps(double time) const {
    (void)time;
    return false;
  }

  /// The media at a time [s].
  [[nodiscard]] virtual Result<GlScene> sceneAt(double time, bool coarse, Progress& progress) = 0;
};

using OpenDocument =
    std::function<Result<std::unique_ptr<Document>>(const std::string& path, Progress& progress)>;

}  // namespace volute
