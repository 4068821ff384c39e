// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/smoke_layer.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/stopwatch.hpp"

namespace volute {
namespace {

/// Room fires have 1e-6 to 1e-3 kg/m3 of soot.
constexpr double kMuchSoot = 1e-2;

std::vector<float> between(const std::vector<float>& a, const std::vector<float>& b, double share) {
  std::vector<float> out(a.size());
  interpolateFields(a, b, share, out);
  return out;
}

}  // namespace

Result<SmokeLayer> SmokeLayer::open(const SmokeDescription& description,
                                    std::shared_ptr<const SmokeLighting> lighting,
                                    Reading& reading) {
  MeshOptions options{description.field, description.negatives, reading.maxMemory};
  VOLUTE_ASSIGN(auto source, MeshSource::open(description.file, options));
  SmokeLayer layer(description, std::move(source));
  if (!description.densityField.empty()) {
    options.field = description.densityField;
    VOLUTE_ASSIGN(layer.densitySource_, MeshSource::open(description.file, options));
  }
  layer.lighting_ = std::move(lighting);
  layer.progress_ = &reading.progress;
  VOLUTE_ASSIGN(const auto first, layer.step(0));
  layer.bounds_ = first->mesh->bounds();
  return layer;
}

double SmokeLayer::timeOf(int step) const {
  const Clock& clock = description_.clock;
  return (source_.times()[static_cast<std::size_t>(step)] - clock.offset) / clock.rate;
}

Result<std::vector<float>> SmokeLayer::extinctionOf(const MeshFrame& frame, std::size_t index) {
  std::vector<float> gas;
  if (densitySource_) {
    VOLUTE_ASSIGN(auto density, densitySource_->read(index));
    gas = std::move(density.values);
  }
  std::vector<float> extinction(frame.values.size());
  description_.model.extinction(frame.values, gas, extinction);
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

/// What the choice of quantity and unit comes to, at the first step with smoke.
void SmokeLayer::remarkOn(const MeshFrame& frame, std::span<const float> extinction) {
  const double most = *std::ranges::max_element(extinction);
  if (remarked_ || !(most > 0))
    return;
  remarked_ = true;
  const SmokeModel& model = description_.model;
  const double soot = model.sootDensity(most);
  progress_->remark(fmt::format(
      "{}: field '{}' as {}: extinction up to {:.3g}/m, visibility from {:.3g} m (C = {:g}), soot "
      "up to {:.2g} kg/m3",
      description_.file, frame.field, nameOf(model.quantity), most, description_.law.c / most,
      description_.law.c, soot));
  if (soot > kMuchSoot) {
    progress_->remark(fmt::format(
        "that is much for soot (fires in rooms: 1e-6 to 1e-3 kg/m3); check the quantity and the "
        "unit"));
  }
}

Result<SmokeLayer::Step> SmokeLayer::readStep(std::size_t index) {
  VOLUTE_ASSIGN(const auto frame, source_.read(index));
  Step step;
  step.index = index;
  step.mesh = frame.mesh;
  VOLUTE_ASSIGN(step.extinction, extinctionOf(frame, index));
  for (const auto& kept : steps_) {
    if (kept->mesh == frame.mesh)
      step.paths = kept->paths;
  }
  if (!step.paths)
    step.paths = std::make_shared<const LampPaths>(std::make_shared<const TetLocator>(frame.mesh));
  remarkOn(frame, step.extinction);
  if (frame.clamped > 0) {
    progress_->remark(fmt::format("{}: step {}: {} negative values taken as 0", description_.file,
                                  index, frame.clamped));
  }
  counts_.clamped += frame.clamped;
  ++counts_.stepsRead;
  light(step);
  return step;
}

std::string SmokeLayer::lightKey(const Step& step, const Lamp& lamp) const {
  constexpr double kVersion = 1;  // of LampPaths: another one, other light
  ContentHash hash;
  hash.add(kVersion);
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  hash.add(step.mesh->vertices());
  hash.add(step.mesh->tets());
  hash.add(std::span<const float>(step.extinction));
  lamp.addTo(hash);
  hash.add(std::span<const char>(lighting_->blocksKey));
  return hash.digits();
}

void SmokeLayer::light(Step& step) {
  const Stopwatch watch(counts_.lightMilliseconds);
  for (const Lamp& lamp : lighting_->lights.lamps) {
    const std::string key = lighting_->cache ? lightKey(step, lamp) : "";
    if (lighting_->cache) {
      if (auto kept = lighting_->cache->find(key, step.extinction.size())) {
        ++counts_.lightsReused;
        step.lampShares.push_back(std::move(*kept));
        continue;
      }
    }
    step.lampShares.push_back(step.paths->shares(step.extinction, lamp, lighting_->blocks));
    ++counts_.lightsComputed;
    if (!lighting_->cache)
      continue;
    if (const auto stored = lighting_->cache->store(key, step.lampShares.back()); !stored)
      progress_->remark("light is not kept: " + stored.error().message);
  }
}

Result<std::shared_ptr<const SmokeLayer::Step>> SmokeLayer::step(std::size_t index) {
  for (const auto& kept : steps_) {
    if (kept->index == index)
      return kept;
  }
  VOLUTE_ASSIGN(auto read, readStep(index));
  if (steps_.size() == 2)
    steps_.erase(steps_.begin());
  steps_.push_back(std::make_shared<const Step>(std::move(read)));
  return steps_.back();
}

Result<SmokeState> SmokeLayer::at(double time) {
  const auto times = source_.times();
  const Clock& clock = description_.clock;
  double local = clock.offset + clock.rate * time;
  if (clock.loop && times.size() > 1) {
    const double period = times.back() - times.front() + times.back() - times[times.size() - 2];
    local -= period * std::floor((local - times.front()) / period);
  }
  const auto next = std::ranges::upper_bound(times, local);
  const std::size_t after = static_cast<std::size_t>(next - times.begin());
  const std::size_t before = after == 0 ? 0 : after - 1;
  VOLUTE_ASSIGN(const auto from, step(before));
  SmokeState state{from->paths->locator(), from->extinction, {}, from->lampShares};
  if (after > 0 && after < times.size() && local > times[before]) {
    VOLUTE_ASSIGN(const auto to, step(after));
    if (to->mesh == from->mesh) {
      const double share = (local - times[before]) / (times[after] - times[before]);
      state.extinction = between(from->extinction, to->extinction, share);
      for (std::size_t l = 0; l < state.lampShares.size(); ++l)
        state.lampShares[l] = between(from->lampShares[l], to->lampShares[l], share);
    }
  }
  const SceneLights& lights = lighting_->lights;
  if (!lights.lamps.empty() || !lights.ambient.isZero(0)) {
    state.source = scatteredLight(state.locator->mesh().vertices(), lights.lamps, state.lampShares,
                                  description_.albedo, lights.ambient);
  }
  return state;
}

}  // namespace volute
