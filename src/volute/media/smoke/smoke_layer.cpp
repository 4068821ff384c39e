// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_layer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "volute/base/assert.hpp"
#include "volute/base/gather_values.hpp"
#include "volute/base/stopwatch.hpp"
#include "volute/media/smoke/shared_light.hpp"
#include "volute/media/smoke/smoke_words.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace volute {
namespace {

/// Smoke through which nobody sees a difference, across the whole case.
constexpr double kThinDepth = 0.05;

std::vector<float> between(const std::vector<float>& a, const std::vector<float>& b, double share) {
  std::vector<float> out(a.size());
  interpolateFields(a, b, share, out);
  return out;
}

}  // namespace

Result<SmokeLayer> SmokeLayer::open(const SmokeDescription& description,
                                    std::shared_ptr<const SmokeLighting> lighting, Reading& reading,
                                    Team* holders) {
  constexpr std::uint64_t kPerTet = 210;  // bytes, of light and of what finds tets, measured
  MeshOptions options{description.field, description.negatives, reading.maxMemory, kPerTet};
  options.alsoField = description.densityField;
  if (holders)
    options.share = {holders->rank(), holders->size()};
  VOLUTE_ASSIGN(auto source, MeshSource::open(description.file, options));
  auto files = std::make_shared<Files>(Files{std::move(source)});
  if (!description.densityField.empty()) {
    options.alsoField = std::exchange(options.field, description.densityField);
    VOLUTE_ASSIGN(files->densitySource, MeshSource::open(description.file, options));
  }
  if (const std::string absent = files->source.absentText(); !absent.empty())
    reading.progress.remark(
        Remark(RemarkCode::kLeftOut, fmt::format("{}: {}", description.file, absent))
            .in(description.file));
  SmokeLayer layer(description, std::move(files));
  layer.lighting_ = std::move(lighting);
  layer.progress_ = &reading.progress;
  layer.holders_ = holders;
  VOLUTE_ASSIGN(const auto stored, layer.readStep(0));
  VOLUTE_TRY(layer.checkShare(*stored));
  layer.bounds_ = stored->frame.mesh->bounds();
  if (holders) {
    const Box3 own = layer.bounds_;
    VOLUTE_ASSIGN(const auto shares, gatherValues(*holders, std::span(&own, 1)));
    for (const Box3& share : shares) {
      layer.bounds_.extend(share.min);
      layer.bounds_.extend(share.max);
    }
  }
  VOLUTE_ASSIGN(const auto first, layer.step(0));
  const MeshFrame& frame = first->stored->frame;
  layer.files_->field = frame.field;
  if (frame.dimensions) {
    VOLUTE_ASSIGN(const std::string unit,
                  compareDimensions(*frame.dimensions, description.model,
                                    fmt::format("{}: field '{}'", description.file, frame.field)));
    if (!unit.empty())
      reading.progress.remark({RemarkCode::kDoubtful, unit});
  }
  if (description.field.empty() && !frame.others.empty()) {
    reading.progress.remark(Remark(RemarkCode::kAssumed,
                                   fmt::format("{}: the field '{}' is read; it also has {}",
                                               description.file, frame.field, frame.others),
                                   {Hint::choose("field")})
                                .in(description.file));
  }
  return layer;
}

bool SmokeLayer::readsTheSame(const SmokeDescription& a, const SmokeDescription& b) {
  return a.file == b.file && a.field == b.field && a.densityField == b.densityField &&
         a.negatives == b.negatives;
}

Result<SmokeLayer> SmokeLayer::with(const SmokeDescription& description,
                                    std::shared_ptr<const SmokeLighting> lighting,
                                    Reading& reading) const {
  VOLUTE_ASSERT(readsTheSame(description_, description));
  SmokeLayer layer(description, files_);
  layer.lighting_ = std::move(lighting);
  layer.progress_ = &reading.progress;
  layer.bounds_ = bounds_;
  layer.holders_ = holders_;
  layer.fillsCache_ = false;
  for (const auto& stored : files_->steps) {
    VOLUTE_ASSIGN(const auto extinction, layer.extinctionOf(*stored));
    VOLUTE_ASSIGN(const double most, layer.largestOf(extinction));
    layer.remarkOn(*stored, most);
  }
  return layer;
}

double SmokeLayer::timeOf(int step) const {
  return description_.clock.sceneTime(files_->source.times()[static_cast<std::size_t>(step)]);
}

Result<std::vector<float>> SmokeLayer::extinctionOf(const Stored& stored) const {
  const MeshFrame& frame = stored.frame;
  std::vector<float> extinction(frame.values.size());
  description_.model.extinction(frame.values, stored.gas, extinction);
  const auto endless = std::ranges::find_if(extinction, [](float k) { return !std::isfinite(k); });
  if (endless == extinction.end())
    return extinction;
  const auto vertex = endless - extinction.begin();
  const Vec3& place = frame.mesh->vertices()[static_cast<std::size_t>(vertex)];
  return fail(ErrorCode::kInvalidData,
              "{}: field '{}' is {} at {:.4g}, {:.4g}, {:.4g} m, which as {} is no finite "
              "extinction",
              description_.file, frame.field, frame.values[static_cast<std::size_t>(vertex)],
              place.x(), place.y(), place.z(), nameOf(description_.model.quantity));
}

/// Of what a share of a mesh is not enough for.
Status SmokeLayer::checkShare(const Stored& stored) const {
  if (!holders_)
    return {};
  std::string_view beyond;
  if (description_.walls)
    beyond = "its walls are between pieces as well: leave 'walls' out";
  else if (stored.frame.ofCells)
    beyond =
        "points between pieces have the mean of cells on both sides: convert the field to "
        "values of points";
  if (beyond.empty())
    return {};
  return fail(ErrorCode::kUnsupported,
              "{}: cannot be held in shares: {}; or let each rank hold all", description_.file,
              beyond);
}

/// Of all shares. Collective where there are several.
Result<double> SmokeLayer::largestOf(std::span<const float> extinction) {
  const double most = *std::ranges::max_element(extinction);
  if (!holders_)
    return most;
  VOLUTE_ASSIGN(const auto all, gatherValues(*holders_, std::span(&most, 1)));
  return std::ranges::max(all);
}

/// What the choice of quantity and unit comes to, at the first step with smoke.
void SmokeLayer::remarkOn(const Stored& stored, double most) {
  if (remarked_ || !(most > 0))
    return;
  remarked_ = true;
  largest_ = most;
  const SmokeModel& model = description_.model;
  const double soot = model.sootDensity(most);
  progress_->remark(fmt::format(
      "{}: field '{}' as {}: extinction up to {:.3g}/m, visibility from {:.3g} m (C = {:g}), soot "
      "up to {:.2g} kg/m3",
      description_.file, stored.frame.field, nameOf(model.quantity), most,
      description_.law.c / most, description_.law.c, soot));
  if (soot > kMuchSoot) {
    progress_->remark(
        {RemarkCode::kDoubtful, fmt::format("that is much for soot (fires in rooms: 1e-6 to 1e-3 "
                                            "kg/m3); check the quantity and the "
                                            "unit")});
  }
  remarkOnThinSmoke(stored, most);
}

/// A unit that is too small makes a whole fire look like clear air.
void SmokeLayer::remarkOnThinSmoke(const Stored& stored, double most) {
  const double depth = most * bounds_.size().norm();
  const SmokeModel& model = description_.model;
  const bool clear = depth <= kThinDepth;
  if (!clear && (!holdsMass(model.quantity) || model.sootDensity(most) >= kLittleSoot))
    return;
  std::string slip =
      fmt::format("check that the field holds {}, and the scale", nameOf(model.quantity));
  if (model.quantity == SmokeQuantity::kSootDensity ||
      model.quantity == SmokeQuantity::kProductsDensity) {
    // The first larger unit with which there is as much soot as in a fire.
    for (const char* unit : {"g/m3", "kg/m3"}) {
      const double soot = model.sootDensity(most) * *densityUnit(unit) / model.unit;
      if (*densityUnit(unit) <= model.unit || soot < kLittleSoot || soot > kMuchSoot)
        continue;
      slip = fmt::format("read as {} instead of {} it would be {:.2g} kg/m3 of soot", unit,
                         unitOfField(model), soot);
      break;
    }
  }
  progress_->remark(
      Remark(RemarkCode::kDoubtful,
             fmt::format("{}: step {}: {}: no ray through the whole case meets an optical "
                         "depth above {:.2g}, which takes {:.2g} % of the light (soot in rooms on "
                         "fire: 1e-6 to "
                         "1e-3 kg/m3); {}",
                         description_.file, stored.index,
                         clear ? "this looks like clear air" : "this is little for a fire", depth,
                         -100 * std::expm1(-depth), slip))
          .in(description_.file));
}

Result<std::shared_ptr<const SmokeLayer::Stored>> SmokeLayer::readStep(std::size_t index) {
  std::vector<std::shared_ptr<const Stored>>& held = files_->steps;
  for (const auto& stored : held) {
    if (stored->index == index)
      return stored;
  }
  auto stored = std::make_shared<Stored>();
  stored->index = index;
  VOLUTE_ASSIGN(stored->frame, files_->source.read(index));
  const MeshFrame& frame = stored->frame;
  if (files_->densitySource) {
    VOLUTE_ASSIGN(auto density, files_->densitySource->read(index));
    stored->gas = std::move(density.values);
  }
  for (const auto& other : held) {
    if (other->frame.mesh == frame.mesh)
      stored->paths = other->paths, stored->meshHash = other->meshHash;
  }
  if (!stored->paths) {
    stored->paths =
        std::make_shared<const LampPaths>(std::make_shared<const TetLocator>(frame.mesh));
    constexpr double kVersion = 1;  // of LampPaths: another one, other light
    stored->meshHash.add(kVersion);
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    stored->meshHash.add(frame.mesh->vertices());
    stored->meshHash.add(frame.mesh->tets());
  }
  if (frame.clamped > 0) {
    progress_->remark(
        Remark(RemarkCode::kChanged, fmt::format("{}: step {}: {} negative values taken as 0",
                                                 description_.file, index, frame.clamped))
            .in(description_.file));
  }
  counts_.clamped += frame.clamped;
  ++counts_.stepsRead;
  if (held.size() == 2)
    held.erase(held.begin());
  held.push_back(stored);
  return stored;
}

std::string SmokeLayer::lightKey(const Step& step, const Lamp& lamp) const {
  ContentHash hash = step.stored->meshHash;
  hash.add(std::span<const float>(step.extinction));
  lamp.addTo(hash);
  hash.add(std::span<const char>(lighting_->blocksKey));
  return hash.digits();
}

std::vector<float> SmokeLayer::lightOf(const Step& step, const Lamp& lamp) {
  const LightCache* const cache = lighting_->cache.get();
  LightMemory* const memory = lighting_->memory.get();
  const std::string key = cache || memory ? lightKey(step, lamp) : "";
  std::optional<std::vector<float>> kept;
  if (memory)
    kept = memory->find(key);
  if (!kept && cache)
    kept = cache->find(key, step.extinction.size());
  if (kept) {
    ++counts_.lightsReused;
  } else {
    kept = step.stored->paths->shares(step.extinction, lamp, lighting_->blocks);
    ++counts_.lightsComputed;
    if (cache && fillsCache_) {
      if (const auto stored = cache->store(key, *kept); !stored)
        progress_->remark("light is not kept: " + stored.error().message);
    }
  }
  if (memory)
    memory->store(key, *kept);
  return std::move(*kept);
}

Status SmokeLayer::light(Step& step) {
  const Stopwatch watch(counts_.lightMilliseconds);
  for (const Lamp& lamp : lighting_->lights.lamps) {
    if (!holders_) {
      step.lampShares.push_back(lightOf(step, lamp));
      continue;
    }
    VOLUTE_ASSIGN(auto shares, sharedLampShares(*holders_, *step.stored->paths->locator(),
                                                step.extinction, lamp, bounds_));
    step.lampShares.push_back(std::move(shares));
    ++counts_.lightsComputed;
  }
  return {};
}

Result<std::shared_ptr<const SmokeLayer::Step>> SmokeLayer::step(std::size_t index) {
  for (const auto& kept : steps_) {
    if (kept->stored->index == index)
      return kept;
  }
  Step made;
  VOLUTE_ASSIGN(made.stored, readStep(index));
  VOLUTE_ASSIGN(made.extinction, extinctionOf(*made.stored));
  VOLUTE_ASSIGN(const double most, largestOf(made.extinction));
  remarkOn(*made.stored, most);
  VOLUTE_TRY(light(made));
  if (steps_.size() == 2)
    steps_.erase(steps_.begin());
  steps_.push_back(std::make_shared<const Step>(std::move(made)));
  return steps_.back();
}

Result<std::shared_ptr<const MeshWalls>> SmokeLayer::wallsOf(const MeshFrame& frame) {
  if (!files_->walls || files_->wallsOf != frame.mesh) {
    VOLUTE_ASSIGN(files_->walls, MeshWalls::make(*frame.mesh));
    files_->wallsOf = frame.mesh;
  }
  return files_->walls;
}

std::vector<float> sourceOf(const SmokeState& state, const SmokeLighting& lighting,
                            std::span<const Lamp> lamps, std::span<const AnyMedium> between) {
  std::optional<DiffuseLight> again;
  if (lighting.lights.multiple && !lamps.empty()) {
    const AnyMedium smoke(TetMedium(state.locator, state.extinction, {}));
    again.emplace(DiffuseLight::Request{.medium = smoke,
                                        .box = smoke.bounds(),
                                        .scattering = {state.albedo},
                                        .lamps = lamps,
                                        .between = between,
                                        .blocks = lighting.blocks});
  }
  return scatteredLight(state.locator->mesh().vertices(), lamps, state.lampShares, state.albedo,
                        lighting.lights.ambient, again ? &*again : nullptr);
}

Result<SmokeState> SmokeLayer::at(double time) {
  const auto times = files_->source.times();
  const double local = description_.clock.at(time, times);
  const auto next = std::ranges::upper_bound(times, local);
  const std::size_t after = static_cast<std::size_t>(next - times.begin());
  const std::size_t before = after == 0 ? 0 : after - 1;
  VOLUTE_ASSIGN(const auto from, step(before));
  if (lighting_->lights.multiple && holders_) {
    return fail(ErrorCode::kUnsupported,
                "{}: processes that share a mesh scatter light once; set \"scattering\" to single, "
                "or use one process",
                description_.file);
  }
  SmokeState state{from->stored->paths->locator(),
                   from->extinction,
                   {},
                   from->lampShares,
                   extinctionOfConcentration(description_.model)};
  if (description_.walls) {
    VOLUTE_ASSIGN(state.walls, wallsOf(from->stored->frame));
  }
  if (after > 0 && after < times.size() && local > times[before]) {
    VOLUTE_ASSIGN(const auto to, step(after));
    if (to->stored->frame.mesh == from->stored->frame.mesh) {
      const double share = (local - times[before]) / (times[after] - times[before]);
      state.extinction = between(from->extinction, to->extinction, share);
      for (std::size_t l = 0; l < state.lampShares.size(); ++l)
        state.lampShares[l] = between(from->lampShares[l], to->lampShares[l], share);
    }
  }
  state.albedo = description_.albedo;
  const SceneLights& lights = lighting_->lights;
  if (!lights.lamps.empty() || !lights.ambient.isZero(0)) {
    state.source = sourceOf(state, *lighting_, lights.lamps, {});
  }
  return state;
}

}  // namespace volute
