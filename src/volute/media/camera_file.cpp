// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/camera_file.hpp"

#include "volute/io/json_file.hpp"

namespace volute {

const FieldTable& cameraFields() {
  using enum FieldType;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "eye", .type = kPoint, .access = member<&CameraDescription::view, &View3::eye>(),
       .help = "where the camera is", .unit = "m", .required = true, .option = {"X,Y,Z"}},
      {.name = "target", .type = kPoint,
       .access = member<&CameraDescription::view, &View3::target>(), .help = "what it looks at",
       .unit = "m", .required = true, .option = {"X,Y,Z"}},
      {.name = "up", .type = kDirection, .access = member<&CameraDescription::view, &View3::up>(),
       .help = "what is up in the picture", .option = {"X,Y,Z"}},
      {.name = "fov", .access = member<&CameraDescription::fov>(), .help = "vertical field of view",
       .unit = "degrees", .least = 0, .most = 180, .above = true, .below = true,
       .option = {"DEGREES"}},
      {.name = "ortho", .access = member<&CameraDescription::ortho>(),
       .help = "instead of fov: parallel rays without a near plane; height of the view",
       .unit = "m", .least = 0, .above = true, .option = {"HEIGHT"}},
      {.name = "size", .type = kNumbers, .access = member<&CameraDescription::size>(),
       .help = "width and height of the picture", .unit = "pixels", .least = 1, .most = 32768,
       .count = 2, .whole = true}};
  // clang-format on
  static const FieldTable kTable =
      fieldTable<CameraDescription>({.name = "camera",
                                     .sentence = "a pinhole (fov) or parallel rays (ortho)",
                                     .fields = kFields});
  return kTable;
}

Result<CameraDescription> parseCamera(const nlohmann::json& json, const FieldOrigin& origin) {
  VOLUTE_ASSIGN(auto camera, readAs<CameraDescription>(cameraFields(), json, origin));
  if (camera.fov.has_value() == camera.ortho.has_value())
    return origin.wrong(fmt::format("expected one of {0}fov [degrees] and {0}ortho [m]",
                                    origin.options() ? "--" : ""));
  if (camera.view.eye == camera.view.target)
    return origin.wrong("eye and target are the same point");
  return camera;
}

Result<CameraDescription> readCamera(const std::string& file) {
  VOLUTE_ASSIGN(const auto json, readJson(file));
  const bool scene = json.is_object() && json.contains("camera");
  return scene ? parseCamera(json["camera"], {file, "/camera"}) : parseCamera(json, {file});
}

Camera makeCamera(const CameraDescription& description, const Pixels& size) {
  return description.fov
             ? Camera::pinhole(description.view, *description.fov, size.width, size.height)
             : Camera::orthographic(description.view, *description.ortho, size.width, size.height);
}

}  // namespace volute
