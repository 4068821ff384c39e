// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/ranges.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "volute/base/remark_log.hpp"
#include "volute/fog/polar_fog.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/lighting/fewer_lamps.hpp"
#include "volute/media/fog/fog_parameters.hpp"
#include "volute/media/fog/fog_scene_medium.hpp"
#include "volute/media/light_blockers.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/render/scaled_medium.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// Where a scene of the first format has fog that is not where its pixels are.
void sayShift(const FogDescription& fog, const MediumContext& context, Progress& progress) {
  if (context.version >= 2 || fog.registration != FogRegistration::kCoefficient)
    return;
  std::vector<std::string> shifts;
  if (const int degree = fog.options.degree; degree > 0)
    shifts.push_back(fmt::format("the fog lies {:g} m", 0.5 * degree * fog.placement.cell));
  if (fog.top)
    shifts.push_back(fmt::format("its top lies {:g} m", 0.5 * fog.top->placement.cell));
  if (shifts.empty())
    return;
  progress.remark(
      Remark(RemarkCode::kNote,
             fmt::format("{}: {}: {} off the pixels in x and y, as a volute-scene-1 means it; "
                         "\"registration\": \"pixel\", or {}, puts it on them",
                         context.file, context.path, fmt::join(shifts, ", "), kSceneFormat))
          .in(context.file, context.path));
}

/// However its name is written.
bool sameMap(const FogDescription& a, const FogDescription& b) {
  const auto fileOf = [](const std::string& name) {
    std::error_code unknown;
    return std::filesystem::absolute(name, unknown).lexically_normal();
  };
  return fileOf(a.maps.front()) == fileOf(b.maps.front());
}

class FogKind final : public MediumKind {
 public:
  const FieldTable& fields() const override { return fogFields(); }

  bool takesAmbient() const override { return false; }  // its colour is the light it adds

  Result<std::shared_ptr<SceneMedium>> open(const nlohmann::json& entry,
                                            MediumContext& context) const override {
    VOLUTE_ASSIGN(auto fog, parseFog(entry, {context.file, context.path}));
    if (context.options.measured && fog.path == FogPath::kAuto)
      fog.path = FogPath::kWalk;
    const auto& lamps = context.lights.lamps;
    fog.shadows = shadowsOf(context.geometry);
    fog.blocks = blocksOf(context.geometry);
    fog.multiple = context.lights.multiple;
    const auto before = context.take<FogSceneMedium>([&](const FogSceneMedium& other) {
      return FogSceneMedium::readsTheSame(other.description(), fog);
    });
    const auto last = std::dynamic_pointer_cast<FogSceneMedium>(context.before);
    std::shared_ptr<FogSceneMedium> medium;
    if (before) {
      medium = before->with(fog, lamps);
      medium->remarks = before->remarks;
    } else {
      RemarkLog remarkLog(context.reading.progress);
      Reading reading = context.reading.with(remarkLog);
      sayShift(fog, context, remarkLog);
      VOLUTE_ASSIGN(medium, FogSceneMedium::open(fog, lamps, reading));
      if (!context.geometry.empty() && !lamps.empty() &&
          !shadowsFog(context.geometry, lamps, medium->fogAt(0)))
        remarkLog.remark(
            {RemarkCode::kDoubtful,
             fmt::format("{}: the scene's geometry shadows none of this fog", fog.where())});
      medium->remarks = remarkLog.remarks();
    }
    if (before || (last && sameMap(last->description(), fog)))
      medium->keepPainted(before ? *before : *last);
    return std::shared_ptr<SceneMedium>(std::move(medium));
  }

  bool opens(const std::string& path) const override { return isPicturePath(path); }

  bool assumes() const override { return true; }

  OrderedJson sceneOf(const std::string& name) const override {
    return {{"format", kSceneFormat},
            {"media", OrderedJson::array({{{"kind", "fog"}, {"map", name}, {"convert", "luma"}}})}};
  }

  std::string assume(OrderedJson& scene) const override {
    OrderedJson& fog = scene["media"][0];
    fog["cell"] = 1.0;
    fog["sigma_max"] = 0.05;
    fog["degree"] = 2;
    fog["profile"] = {{"kind", "slab"}, {"bottom", 0.0}, {"top", 10.0}};
    // Against a dim sky fog is seen from all sides.
    scene["background"] = {0.02, 0.03, 0.05};
    return "cells of 1 m, 10 m high, 0.05 /m at most, unless you say otherwise";
  }

  bool setParameter(OrderedJson& entry, const SceneMedium& medium, const std::string& key,
                    const OrderedJson&, const std::vector<double>& numbers) const override {
    return setFog(entry, dynamic_cast<const FogSceneMedium&>(medium).description(), key, numbers);
  }

  Result<std::optional<std::string>> editEntry(OrderedJson& entry, const std::string& key,
                                               bool more) const override {
    return editProfile(entry, key, more);
  }
};

}  // namespace

FogSnapshot::FogSnapshot(std::shared_ptr<const FogSceneMedium> map, double time, double factor,
                         std::vector<Lamp> lamps, FogLight light)
    : map_(std::move(map)),
      time_(time),
      fog_(map_->fogAt(time)),
      factor_(factor),
      lamps_(std::move(lamps)),
      light_(std::move(light)) {}

const std::optional<LitMedium>& FogSnapshot::lit() const {
  std::call_once(made_, [&] {
    if (!lamps_.empty() && light_.scattering.albedo.maxCoeff() > 0)
      lit_ = litFog(fog_, lamps_, light_);
  });
  return lit_;
}

void FogSnapshot::addMedia(std::vector<AnyMedium>& media) const {
  media.push_back(scaledBy(factor_, lit() ? AnyMedium(*lit()) : AnyMedium(fog_)));
}

void FogSnapshot::addExtinction(std::vector<AnyMedium>& media) const {
  media.push_back(scaledBy(factor_, AnyMedium(fog_)));
}

std::shared_ptr<const MediumSnapshot> FogSnapshot::litBy(const MediaLight& light) const {
  std::vector<Lamp> lamps = lamps_;
  constexpr std::size_t kFires = 3;
  const std::vector<Lamp> fires = fewerLamps(light.lamps, kFires);
  lamps.insert(lamps.end(), fires.begin(), fires.end());
  if (lamps.empty())
    return nullptr;
  FogLight veiled = light_;
  veiled.between.assign(light.between.begin(), light.between.end());
  return std::make_shared<const FogSnapshot>(map_, time_, factor_, std::move(lamps),
                                             std::move(veiled));
}

std::shared_ptr<const MediumSnapshot> FogSnapshot::quick() const {
  if (!light_.shadows || lamps_.empty())
    return nullptr;
  FogLight open = light_;
  open.shadows = {}, open.blocks = {};
  return std::make_shared<const FogSnapshot>(map_, time_, factor_, lamps_, std::move(open));
}

Status FogSnapshot::addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const {
  const auto options = lit() ? std::nullopt : map_->polarFor(camera, fog_);
  if (!options) {
    addMedia(media);
    return {};
  }
  auto polar = PolarFog::make(fog_, camera.eye(), *options);
  if (polar)
    media.push_back(scaledBy(factor_, AnyMedium(std::move(*polar))));
  else if (polar.error().code == ErrorCode::kUnsupported)
    addMedia(media);
  else
    return tl::unexpected(map_->description().about(std::move(polar.error())));
  return {};
}

const MediumKind& fogKind() {
  static const FogKind kind;
  return kind;
}

}  // namespace volute
