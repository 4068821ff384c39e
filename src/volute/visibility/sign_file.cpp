// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/sign_file.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "volute/io/json_members.hpp"
#include "volute/io/json_values.hpp"

namespace volute {
namespace {

/// What a sign may say; "picture" is for scenes.
constexpr std::array<std::string_view, 9> kNames{
    "name", "position", "normal", "size", "emitting", "C", "angle_law", "picture", "routes"};

class SignReader {
 public:
  SignReader(const nlohmann::json& json, const std::string& file, std::string path)
      : json_(json), file_(file), path_(std::move(path)) {}

  Result<SafetySign> read(std::size_t number) const {
    VOLUTE_TRY(checkMembers(json_, kNames, file_, path_));
    SafetySign sign;
    VOLUTE_ASSIGN(sign.name, name(number));
    for (const char* key : {"position", "normal"}) {
      if (!json_.contains(key))
        return wrong(key, "is missing; expected three numbers");
    }
    VOLUTE_ASSIGN(sign.position, jsonToVector(json_["position"], file_, where("position")));
    VOLUTE_ASSIGN(sign.normal, jsonToVector(json_["normal"], file_, where("normal")));
    if (!(sign.normal.norm() > 1e-9))
      return wrong("normal", "is zero; expected a direction");
    sign.normal.normalize();
    VOLUTE_ASSIGN(sign.size, size());
    VOLUTE_ASSIGN(sign.law, law());
    VOLUTE_ASSIGN(sign.angle, angle());
    VOLUTE_ASSIGN(sign.routes, routes());
    return sign;
  }

 private:
  std::string where(std::string_view key) const { return fmt::format("{}/{}", path_, key); }

  tl::unexpected<Error> wrong(std::string_view key, std::string_view message) const {
    return fail(ErrorCode::kInvalidData, "{}: {}: {}", file_, where(key), message);
  }

  Result<std::string> name(std::size_t number) const {
    if (!json_.contains("name"))
      return fmt::format("sign-{}", number + 1);
    if (!json_["name"].is_string() || json_["name"].get<std::string>().empty())
      return wrong("name", "expected a text");
    return json_["name"].get<std::string>();
  }

  Result<std::array<double, 2>> size() const {
    if (!json_.contains("size"))
      return std::array{0.0, 0.0};
    const nlohmann::json& size = json_["size"];
    if (!size.is_array() || size.size() != 2)
      return wrong("size", "expected [width, height] in metres");
    std::array<double, 2> out{};
    for (std::size_t i = 0; i < 2; ++i) {
      VOLUTE_ASSIGN(out[i], jsonToNumber(size[i], file_, fmt::format("{}/{}", where("size"), i)));
      constexpr double kMax = 10;  // larger ones are in centimetres or millimetres
      if (!(out[i] > 0 && out[i] <= kMax)) {
        return wrong("size", fmt::format("{:g} is out of range; expected [width, height] in "
                                         "metres, more than 0 and at most {:g}",
                                         out[i], kMax));
      }
    }
    return out;
  }

  Result<VisibilityLaw> law() const {
    if (json_.contains("emitting") && !json_["emitting"].is_boolean())
      return wrong("emitting", "expected true or false");
    if (!json_.contains("C"))
      return visibilityLaw(json_.value("emitting", false) ? "jin-emitting" : "jin-reflecting");
    if (json_.contains("emitting"))
      return wrong("emitting", "has no effect beside C; leave one out");
    const nlohmann::json& c = json_["C"];
    auto law = visibilityLaw(c.is_string() ? c.get<std::string>() : c.dump());
    if (!law)
      return wrong("C", law.error().message);
    return law;
  }

  Result<AngleLaw> angle() const {
    if (!json_.contains("angle_law"))
      return AngleLaw{};
    const nlohmann::json& given = json_["angle_law"];
    if (given.is_string()) {
      auto law = angleLaw(given.get<std::string>());
      if (!law)
        return wrong("angle_law", law.error().message);
      return law;
    }
    if (!given.is_object() || given.size() != 1 || !given.contains("limit"))
      return wrong("angle_law", "expected front, any, cosine or {\"limit\": DEGREES}");
    VOLUTE_ASSIGN(const double limit,
                  jsonToNumber(given["limit"], file_, where("angle_law/limit")));
    if (!(limit > 0 && limit <= 180))
      return wrong("angle_law/limit", "expected more than 0 and at most 180 degrees");
    return AngleLaw{AngleLaw::Kind::kLimit, limit};
  }

  Result<std::vector<std::string>> routes() const {
    std::vector<std::string> names;
    if (!json_.contains("routes"))
      return names;
    const nlohmann::json& given = json_["routes"];
    for (const nlohmann::json& one : given.is_array() ? given : nlohmann::json::array({given})) {
      if (!one.is_string())
        return wrong("routes", "expected names of routes");
      names.push_back(one.get<std::string>());
    }
    if (names.empty())
      return wrong("routes", "is empty; expected names of routes, or no such member");
    return names;
  }

  const nlohmann::json& json_;
  const std::string& file_;
  std::string path_;
};

}  // namespace

Result<std::vector<SafetySign>> readSigns(const std::string& file) {
  VOLUTE_ASSIGN(const auto json, readJson(file));
  constexpr std::string_view kWhole[] = {"signs"};
  if (json.is_object())
    VOLUTE_TRY(checkMembers(json, kWhole, file));
  if (!json.is_object() || !json.contains("signs") || !json["signs"].is_array()) {
    return fail(ErrorCode::kInvalidData,
                "{}: /signs: expected a list of signs, {{\"signs\": [{{\"name\": .., \"position\": "
                "[x,y,z], \"normal\": [x,y,z]}}]}}",
                file);
  }
  constexpr std::size_t kMax = 10000;
  const nlohmann::json& list = json["signs"];
  if (list.empty() || list.size() > kMax)
    return fail(ErrorCode::kInvalidData, "{}: /signs: {} signs; expected 1 to {}", file,
                list.size(), kMax);
  std::vector<SafetySign> signs;
  for (std::size_t i = 0; i < list.size(); ++i) {
    VOLUTE_ASSIGN(auto sign, SignReader(list[i], file, fmt::format("/signs/{}", i)).read(i));
    if (std::ranges::find(signs, sign.name, &SafetySign::name) != signs.end()) {
      return fail(ErrorCode::kInvalidData,
                  "{}: /signs/{}/name: '{}' is another sign's name as well; expected names that "
                  "differ",
                  file, i, sign.name);
    }
    signs.push_back(std::move(sign));
  }
  return signs;
}

}  // namespace volute
