// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_signs.hpp"

#include <nlohmann/json.hpp>

#include "volute/io/image_file.hpp"
#include "volute/media/field_members.hpp"
#include "volute/media/field_sliders.hpp"
#include "volute/media/law_field.hpp"

namespace volute {
namespace {

constexpr double kEmitting = 8, kReflecting = 3;

FieldValue emittingOf(const Sign& sign) {
  return sign.c == kEmitting;
}

Status setEmitting(Sign& sign, const FieldValue& value) {
  sign.c = value.get<bool>() ? kEmitting : kReflecting;
  return {};
}

/// Nothing where `emitting` says it.
FieldValue signC(const Sign& sign) {
  return sign.c == kEmitting || sign.c == kReflecting ? FieldValue() : FieldValue(sign.c);
}

Status setSignC(Sign& sign, const FieldValue& value) {
  VOLUTE_ASSIGN(const auto law, lawOf(value));
  sign.c = law.c;
  return {};
}

void addSignC(ParameterGroup& group, const void* sign, const MediumFacts& /*facts*/) {
  group.add(signFields().at("C"), "C", static_cast<const Sign*>(sign)->c);
}

FieldValue normalOf(const Sign& sign) {
  return {sign.normal.x(), sign.normal.y(), sign.normal.z()};
}

Status setNormal(Sign& sign, const FieldValue& value) {
  sign.normal = {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
  if (sign.normal.norm() > 0)
    return {};
  return fail(ErrorCode::kInvalidData, "is zero; expected a direction");
}

Status readPicture(Sign& sign) {
  sign.picture = exitPicture();
  if (sign.pictureFile.empty())
    return {};
  VOLUTE_ASSIGN(const auto picture, readImage(sign.pictureFile));
  // Where a .png is transparent it does not shine; colours of a .exr are multiplied by alpha.
  std::optional<Image> alpha;
  if (extensionOf(sign.pictureFile) != ".exr") {
    VOLUTE_ASSIGN(alpha, readAlpha(sign.pictureFile, {.raw = true}));
  }
  sign.picture = Image(picture.width, picture.height, 3);
  for (std::size_t i = 0; i < sign.picture.pixels.size(); ++i) {
    const auto channels = static_cast<std::size_t>(picture.channels);
    sign.picture.pixels[i] =
        picture.pixels[i / 3 * channels + i % 3 % channels] * (alpha ? alpha->pixels[i / 3] : 1);
  }
  return {};
}

}  // namespace

const FieldTable& signFields() {
  using enum FieldType;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "name", .type = kText, .access = member<&Sign::name>(), .help = "its name"},
      {.name = "position", .type = kPoint, .access = member<&Sign::position>(),
       .help = "centre of the sign", .unit = "m", .required = true,
       .slider = {.label = "position"}},
      {.name = "normal", .type = kDirection, .access = customMember<Sign, normalOf, setNormal>(),
       .help = "towards the reader; the sign is upright and visible only from its front",
       .required = true, .slider = {.label = "normal"}},
      {.name = "emitting", .type = kFlag, .access = customMember<Sign, emittingOf, setEmitting>(),
       .help = "whether it emits light: C is 8, else 3", .slider = {.label = "emits light"}},
      {.name = "C", .access = customMember<Sign, signC, setSignC>(),
       .help = "optical depth at which it is no longer visible; overrides emitting", .least = 0,
       .above = true, .choices = lawNames(),
       .slider = {.label = "visibility C", .least = 1, .most = 10, .custom = addSignC}},
      {.name = "size", .type = kNumbers, .access = memberPair<&Sign::width, &Sign::height>(),
       .help = "width and height", .unit = "m", .least = 0, .most = 1e6, .above = true,
       .below = true, .count = 2, .slider = {.label = "width|height", .least = 0.05, .most = 3}},
      {.name = "picture", .type = kFile, .access = member<&Sign::pictureFile>(),
       .help = "a .png or .exr whose linear values, times alpha, are its radiance; if not given, a "
               "green EXIT"}};
  // clang-format on
  static const FieldTable kTable =
      fieldTable<Sign>({.name = "sign", .sentence = "an exit sign", .fields = kFields});
  return kTable;
}

Result<std::vector<Sign>> parseSigns(const nlohmann::json& json, const FieldOrigin& origin) {
  VOLUTE_ASSIGN(auto signs, readList<Sign>(signFields(), json, origin));
  for (Sign& sign : signs) VOLUTE_TRY(readPicture(sign));
  return signs;
}

void addSigns(std::span<const SignPixel> pixels, std::span<const Sign> signs, const Image& depth,
              const PictureLaw& law, Image& image) {
  for (const SignPixel& seen : pixels) {
    const auto pixel = static_cast<std::size_t>(seen.pixel);
    const double share = seenTransmittance(depth.pixels[pixel], law.mode, signs[seen.sign].c);
    for (std::size_t c = 0; c < 3; ++c)
      image.pixels[3 * pixel + c] += static_cast<float>(share * seen.radiance[c]);
  }
}

}  // namespace volute
