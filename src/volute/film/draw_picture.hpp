// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <optional>
#include <string>

#include "volute/image/image.hpp"
#include "volute/image/picture_style.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/scene/scene.hpp"

namespace volute {

/// The content and the style of a picture. Defaults are those of `volute render`.
struct PictureOptions {
  std::optional<double> time{};               ///< [s]; else one that has something to see
  std::optional<CameraDescription> camera{};  ///< else the scene's, else one that frames it
  std::optional<std::array<int, 2>> size{};   ///< width, height [pixels]
  double exposure = 0;                        ///< a factor of light; 0: brightest parts near white
  std::optional<ToneCurve> tone{};            ///< else filmic, or what suits measured values
  int samples = 8;                            ///< rays in a pixel where there are edges
  double shutter = 0;  ///< averages light over this share of the time to the next frame
};

/// The picture that `volute render` makes of a scene, or of any file that Volute shows, or of a
/// volume in memory ("memory:NAME", with options.files.volumes): linear light, of which toSrgb8()
/// and writeImage() make the command's bytes.
/// @param path     if not a scene, options.members are those of its entry
/// Errors: what cannot be opened, read or drawn; kInvalidArgument for a request that makes no
/// sense.
[[nodiscard]] Result<Image> drawPicture(const std::string& path, const PictureOptions& request,
                                        SceneOptions options, Progress& progress);

}  // namespace volute
