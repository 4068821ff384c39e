// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_signs.hpp"

#include "volute/io/image_file.hpp"
#include "volute/io/json_members.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

constexpr double kEmitting = 8, kReflecting = 3;

Status parseSignSize(const Members& members, const std::string& file, Sign& sign) {
  if (!members.has("size"))
    return {};
  const Json& size = members.at("size");
  if (size.is_array() && size.size() == 2 && size[0].is_number() && size[1].is_number()) {
    sign.width = size[0].get<double>();
    sign.height = size[1].get<double>();
    if (sign.width > 0 && sign.height > 0 && sign.width < 1e6 && sign.height < 1e6)
      return {};
  }
  return fail(ErrorCode::kInvalidData, "{}: {}: expected [width, height] > 0 [m]", file,
              members.where("size"));
}

Status parseC(const Members& members, const std::string& file, Sign& sign) {
  bool emitting = false;
  if (members.has("emitting")) {
    if (!members.at("emitting").is_boolean())
      return fail(ErrorCode::kInvalidData, "{}: {}: expected true or false", file,
                  members.where("emitting"));
    emitting = members.at("emitting").get<bool>();
  }
  sign.c = emitting ? kEmitting : kReflecting;
  if (!members.has("C"))
    return {};
  const Json& c = members.at("C");
  const auto law = visibilityLaw(c.is_string() ? c.get<std::string>() : c.dump());
  if (!law)
    return members.objection("C", law.error());
  sign.c = law->c;
  return {};
}

Status parsePicture(const Members& members, const std::string& file, Sign& sign) {
  if (!members.has("picture")) {
    sign.picture = exitPicture();
    return {};
  }
  std::string name;
  VOLUTE_TRY(members.text("picture", name, "the name of a .png or .exr"));
  VOLUTE_ASSIGN(const auto picture, readImage(besides(file, name)));
  sign.picture = Image(picture.width, picture.height, 3);
  for (std::size_t i = 0; i < sign.picture.pixels.size(); ++i) {
    const auto channels = static_cast<std::size_t>(picture.channels);
    sign.picture.pixels[i] = picture.pixels[i / 3 * channels + i % 3 % channels];
  }
  return {};
}

Result<Sign> parseSign(const Json& json, const std::string& file, const std::string& path) {
  constexpr std::string_view kNames[] = {"name",     "position", "normal", "size",
                                         "emitting", "C",        "picture"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  Sign sign;
  if (members.has("name"))
    VOLUTE_TRY(members.text("name", sign.name, "a name"));
  for (const char* key : {"position", "normal"}) {
    if (!members.has(key))
      return fail(ErrorCode::kInvalidData, "{}: {}: is missing; expected three numbers", file,
                  members.where(key));
  }
  VOLUTE_TRY(members.vector("position", sign.position));
  VOLUTE_TRY(members.vector("normal", sign.normal));
  if (!(sign.normal.norm() > 0))
    return fail(ErrorCode::kInvalidData, "{}: {}: is zero; expected a direction", file,
                members.where("normal"));
  VOLUTE_TRY(parseSignSize(members, file, sign));
  VOLUTE_TRY(parseC(members, file, sign));
  VOLUTE_TRY(parsePicture(members, file, sign));
  return sign;
}

}  // namespace

Result<std::vector<Sign>> parseSigns(const Json& json, const std::string& file,
                                     const std::string& path) {
  if (!json.is_array())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected a list", file, path);
  std::vector<Sign> signs;
  for (std::size_t i = 0; i < json.size(); ++i) {
    VOLUTE_ASSIGN(auto sign, parseSign(json[i], file, fmt::format("{}/{}", path, i)));
    signs.push_back(std::move(sign));
  }
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
