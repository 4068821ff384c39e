// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/criteria_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "volute/base/suggest.hpp"
#include "volute/io/json_file.hpp"
#include "volute/io/json_members.hpp"
#include "volute/io/json_values.hpp"

namespace volute {
namespace {

constexpr std::array<std::string_view, 12> kMembers{"name",     "kind",     "model",   "limit",
                                                    "activity", "clothing", "burns",   "C",
                                                    "falling",  "source",   "applies", "room"};

class CriterionReader {
 public:
  CriterionReader(const nlohmann::json& json, const std::string& file, std::string path)
      : json_(json), file_(file), path_(std::move(path)) {}

  Result<Criterion> read() const {
    VOLUTE_TRY(checkMembers(json_, kMembers, file_, path_));
    Criterion criterion;
    VOLUTE_ASSIGN(const auto kind, text("kind", ""));
    VOLUTE_TRY(readKind(kind, criterion));
    VOLUTE_TRY(checkEffects(kind, criterion));
    VOLUTE_ASSIGN(criterion.name, text("name", kind));
    VOLUTE_TRY(readPerson(criterion));
    VOLUTE_TRY(readLimit(kind, criterion));
    VOLUTE_ASSIGN(criterion.source, text("source", "stated by the user"));
    VOLUTE_ASSIGN(criterion.applies, text("applies", ""));
    VOLUTE_TRY(readRoom(criterion));
    criterion.checked = true;
    return criterion;
  }

 private:
  tl::unexpected<Error> wrong(std::string_view key, std::string_view message) const {
    return fail(ErrorCode::kInvalidData, "{}: {}/{}: {}", file_, path_, key, message);
  }

  Result<std::string> text(const char* key, const std::string& initial) const {
    if (!json_.contains(key))
      return initial;
    if (!json_[key].is_string())
      return wrong(key, "expected a text");
    return json_[key].get<std::string>();
  }

  /// A word of a few; the place in `choices`.
  Result<std::size_t> choice(const char* key, std::span<const std::string_view> choices,
                             std::string_view initial) const {
    VOLUTE_ASSIGN(const auto word, text(key, std::string(initial)));
    const auto found = std::ranges::find(choices, word);
    if (found == choices.end())
      return wrong(key, fmt::format("'{}'; expected {}", word, fmt::join(choices, ", ")));
    return static_cast<std::size_t>(found - choices.begin());
  }

  Status readKind(const std::string& kind, Criterion& criterion) const {
    std::vector<std::string_view> models;
    for (const DoseLawInfo& info : doseLaws()) {
      if (info.kind == kind)
        models.push_back(info.name);
    }
    if (!models.empty()) {
      VOLUTE_ASSIGN(const auto model, choice("model", models, models.front()));
      const auto found = std::ranges::find_if(doseLaws(), [&](const DoseLawInfo& info) {
        return info.kind == kind && info.name == models[model];
      });
      criterion.law = found->law;
      return {};
    }
    if (kind == "visibility" || kind == "obscuration" || kind == "optical-density") {
      criterion.quantity = Air::kExtinction;
      return {};
    }
    const auto quantity = airQuantity(kind);
    if (!quantity) {
      return wrong(
          "kind",
          fmt::format(
              "'{}'; expected fed-gas, fed-heat, fec, visibility, "
              "obscuration, optical-density, temperature, radiant-flux, extinction or a gas as "
              "carbon-monoxide or oxygen",
              kind));
    }
    criterion.quantity = *quantity;
    criterion.falling = *quantity == Air::kOxygen;
    return {};
  }

  /// What such a criterion does not use is refused.
  Status checkEffects(const std::string& kind, const Criterion& criterion) const {
    const auto isOneOf = [&](auto... laws) { return ((criterion.law == laws) || ...); };
    const std::pair<const char*, bool> used[] = {
        {"model", criterion.law.has_value()},
        {"activity", isOneOf(DoseLaw::kSfpeGas, DoseLaw::kFdsGas)},
        {"clothing", isOneOf(DoseLaw::kIsoHeat)},
        {"burns", isOneOf(DoseLaw::kIsoHeat)},
        {"C", kind == "visibility"}};
    for (const auto& [key, isUsed] : used) {
      if (json_.contains(key) && !isUsed)
        return wrong(key, fmt::format("has no effect on {}{}; leave it out", kind,
                                      criterion.law && std::string_view(key) != "C"
                                          ? fmt::format(" by {}", infoOf(*criterion.law).name)
                                          : ""));
    }
    return {};
  }

  Status readPerson(Criterion& criterion) const {
    constexpr std::array<std::string_view, 3> kActivities{"rest", "light", "heavy"};
    constexpr std::array<std::string_view, 2> kClothings{"unclothed", "clothed"};
    constexpr std::array<std::string_view, 2> kBurns{"pain", "second-degree"};
    VOLUTE_ASSIGN(const auto activity, choice("activity", kActivities, "light"));
    VOLUTE_ASSIGN(const auto clothing, choice("clothing", kClothings, "unclothed"));
    VOLUTE_ASSIGN(const auto burns, choice("burns", kBurns, "pain"));
    criterion.person = {static_cast<Activity>(activity), static_cast<Clothing>(clothing),
                        static_cast<BurnEndpoint>(burns)};
    return {};
  }

  /// "room": [from, below], floor areas; null: any.
  Status readRoom(Criterion& criterion) const {
    if (!json_.contains("room"))
      return {};
    const nlohmann::json& room = json_["room"];
    if (!room.is_array() || room.size() != 2)
      return wrong("room", "expected [from, below], floor areas in m2 or null");
    if (!room[0].is_null()) {
      VOLUTE_ASSIGN(criterion.roomFrom, jsonToNumber(room[0], file_, path_ + "/room/0"));
    }
    if (!room[1].is_null()) {
      VOLUTE_ASSIGN(criterion.roomBelow, jsonToNumber(room[1], file_, path_ + "/room/1"));
    }
    if (!(criterion.roomFrom >= 0 && criterion.roomFrom < criterion.roomBelow))
      return wrong("room", "expected floor areas of 0 or more, the first below the second");
    return {};
  }

  Status readLimit(const std::string& kind, Criterion& criterion) const {
    if (!json_.contains("limit"))
      return wrong("limit", "is missing; expected a number");
    VOLUTE_ASSIGN(criterion.limit, jsonToNumber(json_["limit"], file_, path_ + "/limit"));
    if (!(criterion.limit > 0))
      return wrong("limit", "expected a number > 0");
    if (isFraction(criterion) && !(criterion.limit <= 1)) {
      return wrong("limit", fmt::format("is {:g}; a fraction in mol/mol is at most 1: {:g} % are "
                                        "{:g}, {:g} ppm are {:g}",
                                        criterion.limit, criterion.limit, criterion.limit * 1e-2,
                                        criterion.limit, criterion.limit * 1e-6));
    }
    if (kind == "visibility") {
      double c = 3;
      if (json_.contains("C")) {
        VOLUTE_ASSIGN(c, jsonToNumber(json_["C"], file_, path_ + "/C"));
        if (!(c > 0))
          return wrong("C", "expected a number > 0");
      }
      criterion.limit = c / criterion.limit;
    }
    if (kind == "obscuration") {  // [%/m], as smoke and beam detectors state it
      if (!(criterion.limit < 100))
        return wrong("limit", "expected a number of %/m below 100");
      criterion.limit = -std::log1p(-criterion.limit / 100);
    }
    if (kind == "optical-density")  // [1/m], of the common logarithm
      criterion.limit *= std::numbers::ln10;
    if (json_.contains("falling")) {
      if (!json_["falling"].is_boolean())
        return wrong("falling", "expected true or false");
      criterion.falling = json_["falling"].get<bool>();
    }
    return {};
  }

  static bool isFraction(const Criterion& criterion) {
    return !criterion.law && criterion.quantity != Air::kExtinction &&
           quantityOf(criterion.quantity).unit == "mol/mol";
  }

  const nlohmann::json& json_;
  const std::string& file_;
  std::string path_;
};

}  // namespace

Result<std::vector<Criterion>> readCriteria(const std::string& file) {
  VOLUTE_ASSIGN(const auto json, readJson(file));
  constexpr std::size_t kMax = 100;
  constexpr std::string_view kWhole[] = {"criteria"};
  if (json.is_object())
    VOLUTE_TRY(checkMembers(json, kWhole, file));
  if (!json.is_object() || !json.contains("criteria") || !json["criteria"].is_array() ||
      json["criteria"].empty() || json["criteria"].size() > kMax) {
    return fail(ErrorCode::kInvalidData,
                "{}: /criteria: expected a list of 1 to {} criteria, {{\"criteria\": [{{\"kind\": "
                "\"temperature\", \"limit\": 60}}]}}",
                file, kMax);
  }
  std::vector<Criterion> criteria;
  for (std::size_t i = 0; i < json["criteria"].size(); ++i) {
    const std::string path = fmt::format("/criteria/{}", i);
    VOLUTE_ASSIGN(auto criterion, CriterionReader(json["criteria"][i], file, path).read());
    if (std::ranges::find(criteria, criterion.name, &Criterion::name) != criteria.end()) {
      return fail(ErrorCode::kInvalidData, "{}: {}/name: '{}' is another criterion's name as well",
                  file, path, criterion.name);
    }
    criteria.push_back(std::move(criterion));
  }
  return criteria;
}

std::vector<std::string_view> criteriaNames() {
  std::vector<std::string_view> names;
  for (const CriteriaProfile& profile : criteriaProfiles()) names.push_back(profile.name);
  return names;
}

Result<CriteriaProfile> criteriaOf(const std::string& which) {
  if (which == "none")
    return CriteriaProfile();
  for (const CriteriaProfile& profile : criteriaProfiles()) {
    if (profile.name == which)
      return profile;
  }
  const auto names = criteriaNames();
  std::error_code error;
  const bool name = which.find_first_of("./\\") == which.npos || !nearest(which, names).empty();
  if (name && !std::filesystem::exists(which, error)) {
    return fail(ErrorCode::kInvalidArgument, "criteria '{}': expected none, {} or a file (.json)",
                which, fmt::join(names, ", "));
  }
  VOLUTE_ASSIGN(auto criteria, readCriteria(which));
  return CriteriaProfile{which, "Criteria of " + which, "stated by the user", "",
                         std::move(criteria)};
}

}  // namespace volute
