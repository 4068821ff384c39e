// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_look.hpp"

#include <nlohmann/json.hpp>

#include "volute/media/field_members.hpp"

namespace volute {
namespace {

FieldValue loopOf(const SceneLook& look) {
  return look.loop ? FieldValue{(*look.loop)[0], (*look.loop)[1]} : FieldValue();
}

Status setLoop(SceneLook& look, const FieldValue& value) {
  look.loop = value.get<std::array<double, 2>>();
  if ((*look.loop)[0] < (*look.loop)[1])
    return {};
  return fail(ErrorCode::kInvalidData, "expected two times, the earlier one first");
}

}  // namespace

const FieldTable& lookFields() {
  using enum FieldType;
  static constexpr std::string_view kColors[] = {"grey", "viridis", "inferno"};
  static constexpr std::string_view kTones[] = {"automatic", "none", "filmic",
                                                "shoulder",  "aces", "ocio"};
  static constexpr std::string_view kQualities[] = {"automatic", "full", "half", "quarter"};
  static constexpr std::string_view kRenderers[] = {"automatic", "gl", "cpu"};
  static constexpr std::string_view kCameras[] = {"orbit", "walk"};
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "stops", .access = member<&SceneLook::stops>(),
       .help = "multiplies the exposure by 2^stops", .least = -20, .most = 20},
      {.name = "exposure", .access = member<&SceneLook::exposure>(),
       .help = "factor for radiance; if not given, chosen for the first picture", .least = 1e-30,
       .most = 1e30},
      {.name = "colors", .type = kChoice, .access = member<&SceneLook::colors>(),
       .help = "colour map of volumes with one channel", .choices = kColors},
      {.name = "tone", .type = kChoice, .access = member<&SceneLook::tone>(),
       .help = "tone curve; aces and ocio (the view of $OCIO) by OpenColorIO", .choices = kTones},
      {.name = "quality", .type = kChoice, .access = member<&SceneLook::quality>(),
       .help = "resolution of the pictures", .choices = kQualities},
      {.name = "renderer", .type = kChoice, .access = member<&SceneLook::renderer>(),
       .help = "renderer of the viewer", .choices = kRenderers},
      {.name = "surfaces", .type = kFlag, .access = member<&SceneLook::surfaces>(),
       .help = "show opaque surfaces"},
      {.name = "camera", .type = kChoice, .access = member<&SceneLook::walks>(),
       .help = "how the mouse moves the camera", .choices = kCameras},
      {.name = "speed", .access = member<&SceneLook::speed>(), .help = "playback speed",
       .least = 0.01, .most = 100},
      {.name = "time", .access = member<&SceneLook::time>(), .help = "time shown", .unit = "s"},
      {.name = "loop", .type = kNumbers, .access = customMember<SceneLook, loopOf, setLoop>(),
       .help = "begin and end of what is played; if not given, all frames", .unit = "s",
       .count = 2}};
  // clang-format on
  static const FieldTable kTable = fieldTable<SceneLook>(
      {.name = "view",
       .sentence = "how the viewer shows the scene; pictures do not depend on it",
       .fields = kFields});
  return kTable;
}

nlohmann::ordered_json toJson(const SceneLook& look) {
  return writeFields(lookFields(), &look, "");
}

}  // namespace volute
