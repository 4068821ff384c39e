// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/media/clock_fields.hpp"
#include "volute/media/field_members.hpp"
#include "volute/media/volume/appearance.hpp"
#include "volute/media/volume/volume_preset.hpp"
#include "volute/render/billboard.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {

/// A medium of kind "volume" in a scene.
struct SceneVolume {
  std::string file;  ///< found from the scene file's folder
  InputOptions input;
  VolumePreset preset = VolumePreset::kNone;
  Appearance appearance;
};

/// An entry of a scene's "billboards".
struct SceneBillboard {
  std::string file;  ///< of the volume
  Appearance appearance;
  BillboardOptions options;
};

const FieldTable& volumeFields();
const FieldTable& flameFields();
const FieldTable& billboardFields();

/// Rows of what is shown as voxels are; `path` leads to an Appearance.
/// `command`: options of commands say it too.
template <auto path, bool command = true, auto shown = nullptr>
FieldRow emissionField() {
  return {.name = "emission",
          .access = member<path, &Appearance::emission>(),
          .help = "radiance per metre that one unit of the values emits",
          .unit = "1/m",
          .option = {.value = command ? "S" : "", .picture = true},
          .slider = {.label = "emission",
                     .least = 0,
                     .most = 100,
                     .logarithmic = true,
                     .room = 2,
                     .shown = shown}};
}

template <auto path, bool command = true, auto shown = nullptr>
FieldRow extinctionField() {
  return {.name = "extinction",
          .access = member<path, &Appearance::extinction>(),
          .help = "extinction of one unit of the values",
          .unit = "1/m",
          .least = 0,
          .option = {.value = command ? "S" : "",
                     .more = "; not given, optical depths are as the unit says, 1 without a unit"},
          .slider = {.label = "extinction",
                     .least = 0,
                     .most = 100,
                     .logarithmic = true,
                     .room = 2,
                     .shown = shown}};
}

}  // namespace volute
