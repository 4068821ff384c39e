// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/camera_file.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "volute/base/file_name.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/io/json_file.hpp"
#include "volute/media/field_members.hpp"
#include "volute/media/gltf_camera.hpp"

namespace volute {
namespace {

FieldValue keysOf(const CameraDescription& camera) {
  if (camera.keys.empty())
    return {};
  FieldValue rows = FieldValue::array();
  for (const CameraKey& key : camera.keys) {
    rows.push_back({key.time, key.eye.x(), key.eye.y(), key.eye.z(), key.target.x(), key.target.y(),
                    key.target.z()});
  }
  return rows;
}

Status setKeys(CameraDescription& camera, const FieldValue& value) {
  camera.keys.clear();
  for (const FieldValue& row : value) {
    const auto at = [&](std::size_t i) { return row[i].get<double>(); };
    const CameraKey key{at(0), {at(1), at(2), at(3)}, {at(4), at(5), at(6)}};
    if (!camera.keys.empty() && !(key.time > camera.keys.back().time)) {
      return fail(ErrorCode::kInvalidData, "the time {} s follows {} s; expected ascending ones",
                  plainNumber(key.time), plainNumber(camera.keys.back().time));
    }
    if (key.eye == key.target) {
      return fail(ErrorCode::kInvalidData, "at {} s eye and target are the same point",
                  plainNumber(key.time));
    }
    camera.keys.push_back(key);
  }
  return {};
}

}  // namespace

View3 CameraDescription::viewAt(double time) const {
  if (keys.empty())
    return view;
  View3 now = view;
  const auto next = std::ranges::upper_bound(keys, time, {}, &CameraKey::time);
  const auto after = static_cast<std::size_t>(next - keys.begin());
  if (after == 0 || after == keys.size()) {
    const CameraKey& key = after == 0 ? keys.front() : keys.back();
    now.eye = key.eye, now.target = key.target;
    return now;
  }
  const auto between = [&](Vec3 CameraKey::* place) {
    const auto slope = [&](std::size_t i) -> Vec3 {  // at rest at both ends
      if (i == 0 || i + 1 == keys.size())
        return Vec3::Zero();
      return (keys[i + 1].*place - keys[i - 1].*place) / (keys[i + 1].time - keys[i - 1].time);
    };
    const CameraKey &a = keys[after - 1], &b = keys[after];
    const double length = b.time - a.time, u = (time - a.time) / length;
    return Vec3((1 + 2 * u) * (1 - u) * (1 - u) * (a.*place) +
                u * (1 - u) * (1 - u) * length * slope(after - 1) +
                u * u * (3 - 2 * u) * (b.*place) + u * u * (u - 1) * length * slope(after));
  };
  now.eye = between(&CameraKey::eye), now.target = between(&CameraKey::target);
  return now;
}

const FieldTable& cameraFields() {
  using enum FieldType;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "eye", .type = kPoint, .access = member<&CameraDescription::view, &View3::eye>(),
       .help = "position of the camera", .unit = "m", .required = true, .option = {"X,Y,Z"}},
      {.name = "target", .type = kPoint,
       .access = member<&CameraDescription::view, &View3::target>(), .help = "point it looks at",
       .unit = "m", .required = true, .option = {"X,Y,Z"}},
      {.name = "up", .type = kDirection, .access = member<&CameraDescription::view, &View3::up>(),
       .help = "up direction of the picture", .option = {"X,Y,Z"}},
      {.name = "fov", .access = member<&CameraDescription::fov>(), .help = "vertical field of view",
       .unit = "degrees", .least = 0, .most = 180, .above = true, .below = true,
       .option = {"DEGREES"}},
      {.name = "ortho", .access = member<&CameraDescription::ortho>(),
       .help = "instead of fov: parallel rays without a near plane; height of the view",
       .unit = "m", .least = 0, .above = true, .option = {"HEIGHT"}},
      {.name = "size", .type = kNumbers, .access = member<&CameraDescription::size>(),
       .help = "width and height of the picture", .unit = "pixels", .least = 1, .most = 32768,
       .count = 2, .whole = true},
      {.name = "keys", .type = kRows, .access = customMember<CameraDescription, keysOf, setKeys>(),
       .help = "camera path: time [s], eye and target [m] in each row, by ascending time; smooth "
               "in between, static before the first and after the last", .count = 7}};
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
  if (camera.view.up == Vec3::Zero())
    return origin.wrong("up is 0, 0, 0; expected a direction, such as 0, 0, 1");
  // z is what cameras have without being asked: a plan from above has y upwards then.
  const Vec3 &up = camera.view.up, along = camera.view.target - camera.view.eye;
  if (camera.keys.empty() && up != Vec3::UnitZ() &&
      up.cross(along).norm() <= 1e-9 * up.norm() * along.norm())
    return origin.wrong("up is along the view, from eye to target; expected another direction");
  return camera;
}

Result<CameraDescription> readCamera(const std::string& file) {
  if (const std::string kind = extensionOf(file); kind == ".gltf" || kind == ".glb")
    return readGltfCamera(file);
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
