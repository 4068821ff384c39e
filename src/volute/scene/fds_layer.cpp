// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/fds_layer.hpp"

#include <algorithm>
#include <cmath>

#include "volute/image/srgb.hpp"
#include "volute/render/scaled_medium.hpp"

namespace volute {
namespace {

/// What a case says itself cannot be said again.
Status checkWords(const SmokeDescription& smoke) {
  const SmokeModel usual;
  const SmokeModel& model = smoke.model;
  if (model.quantity == usual.quantity && model.unit == usual.unit && model.sootYield == 0 &&
      !model.smokePotential && smoke.densityField.empty())
    return {};
  return fail(
      ErrorCode::kInvalidArgument,
      "{}: the FDS case {} says itself what its files hold; expected no quantity, unit, soot "
      "yield, material or density field",
      smoke.where, smoke.file);
}

Rgb linear(const FdsColour& colour, const Vec3& normal) {
  const double share = std::abs(normal.x()) > 0.5 ? 0.7 : std::abs(normal.y()) > 0.5 ? 0.85 : 1;
  return share * Rgb(srgbDecode(colour[0]), srgbDecode(colour[1]), srgbDecode(colour[2]));
}

}  // namespace

Result<FdsLayer> FdsLayer::open(const SmokeDescription& description, const Rgb& ambient,
                                Reading& reading) {
  VOLUTE_TRY(checkWords(description));
  FdsOptions options{.source = description.field, .volume = description.field.empty()};
  if (description.model.massExtinction != kFdsMassExtinction)
    options.massExtinction = description.model.massExtinction;
  options.visibilityFactor = description.model.c;
  options.maxMemory = reading.maxMemory;
  VOLUTE_ASSIGN(auto opened, FdsCase::open(description.file, options));
  FdsLayer layer;
  layer.description_ = description;
  layer.ambient_ = ambient;
  layer.case_ = std::make_shared<FdsCase>(std::move(opened));
  layer.events_ = obstructionEvents(layer.case_->index());
  for (const std::string& remark : layer.case_->remarks()) reading.progress.remark(remark);
  reading.progress.remark(fmt::format("{}: extinction from {} ({})", description.file,
                                      layer.case_->source().name, layer.source()));
  return layer;
}

double FdsLayer::timeOf(int step) const {
  const Clock& clock = description_.clock;
  return (case_->times()[static_cast<std::size_t>(step)] - clock.offset) / clock.rate;
}

double FdsLayer::caseTime(double time) const {
  const Clock& clock = description_.clock;
  const auto times = case_->times();
  double local = clock.offset + clock.rate * time;
  if (clock.loop && times.size() > 1) {
    const double period = times.back() - times.front() + times.back() - times[times.size() - 2];
    local -= period * std::floor((local - times.front()) / period);
  }
  return local;
}

Result<AnyMedium> FdsLayer::mediumAt(double time) const {
  VOLUTE_ASSIGN(const auto field, case_->field(caseTime(time)));
  AnyMedium medium(field.withSource(description_.albedo * ambient_));
  if (description_.model.scale == 1)
    return medium;
  return AnyMedium(ScaledMedium(std::move(medium), description_.model.scale));
}

std::size_t FdsLayer::changesUntil(double time) const {
  const double local = caseTime(time);
  return static_cast<std::size_t>(
      std::ranges::count_if(events_, [&](double event) { return event <= local; }));
}

void FdsLayer::addBuilding(double time, TriangleMesh& to) const {
  for (const FdsQuad& quad : case_->obstructions(caseTime(time)).quads()) {
    const auto& c = quad.corners;
    const Vec3 across = (c[1] - c[0]).cross(c[3] - c[0]);
    if (!(across.norm() > 0))
      continue;
    const auto material = static_cast<std::uint32_t>(to.materials.size());
    to.materials.push_back({linear(quad.colour, across.normalized()), Rgb::Zero()});
    to.triangles.push_back({{c[0], c[1], c[2]}, material});
    to.triangles.push_back({{c[0], c[2], c[3]}, material});
  }
}

}  // namespace volute
