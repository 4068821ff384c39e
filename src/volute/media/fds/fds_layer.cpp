// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_layer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "volute/base/assert.hpp"
#include "volute/fds/fds_room.hpp"
#include "volute/image/srgb.hpp"
#include "volute/media/fds/fds_light.hpp"

namespace volute {
namespace {

constexpr double kDeviceSize = 0.12;  // [m], from the middle of a mark to its corners
constexpr double kEyeHeight = 1.7;    // [m] above the floor
constexpr double kEyeShare = 0.7;     // of a low room's height, at most
constexpr double kFromWall = 0.5;     // [m]
constexpr double kIndoorFov = 60;     // [degrees]
const Rgb kIdleDevice(0.02, 0.1, 0.8);
const Rgb kActiveDevice(0.9, 0.02, 0.5);

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

Result<FdsLayer> FdsLayer::open(const SmokeDescription& description, const SceneLights& lights,
                                Blocks blocks, Reading& reading) {
  VOLUTE_TRY(checkWords(description));
  FdsOptions options{.source = description.field, .volume = description.field.empty()};
  if (description.model.massExtinction != kFdsMassExtinction)
    options.massExtinction = description.model.massExtinction;
  options.visibilityFactor = description.model.c;
  options.maxMemory = reading.maxMemory;
  VOLUTE_ASSIGN(auto opened, FdsCase::open(description.file, options));
  FdsLayer layer;
  layer.description_ = description;
  layer.lights_ = lights;
  layer.blocks_ = std::move(blocks);
  layer.case_ = std::make_shared<FdsCase>(std::move(opened));
  layer.events_ = obstructionEvents(layer.case_->index());
  if (description.fds.devices) {
    for (const FdsDevice& device : layer.case_->index().devices) {
      for (const FdsEvent& event : device.events) layer.events_.push_back(event.time);
    }
    std::ranges::sort(layer.events_);
  }
  for (const std::string& remark : layer.case_->remarks()) reading.progress.remark(remark);
  reading.progress.remark(fmt::format("{}: extinction from {} ({})", description.file,
                                      layer.case_->source().name, layer.source()));
  VOLUTE_TRY(layer.openFire(reading));
  if (!description.fds.slice.empty()) {
    VOLUTE_ASSIGN(layer.slice_, FdsSliceSheet::open(layer.case_->index(), description.fds.slice,
                                                    description.fds.sliceRange, reading));
  }
  return layer;
}

bool FdsLayer::readsTheSame(const SmokeDescription& a, const SmokeDescription& b) {
  const auto sameFire = [](const FdsLook& x, const FdsLook& y) {
    return x.fire == y.fire && x.flame.temperature == y.flame.temperature &&
           x.flame.emission == y.flame.emission && x.flame.cutoff == y.flame.cutoff &&
           x.cutoff == y.cutoff;
  };
  return a.file == b.file && a.field == b.field &&
         a.model.massExtinction == b.model.massExtinction && a.model.c == b.model.c &&
         sameFire(a.fds, b.fds) && a.fds.devices == b.fds.devices && a.fds.slice == b.fds.slice &&
         a.fds.sliceRange == b.fds.sliceRange;
}

FdsLayer FdsLayer::with(const SmokeDescription& description, const SceneLights& lights) const {
  VOLUTE_ASSERT(readsTheSame(description_, description));
  FdsLayer layer = *this;
  layer.description_ = description;
  layer.lights_ = lights;
  return layer;
}

double FdsLayer::timeOf(int step) const {
  return description_.clock.sceneTime(case_->times()[static_cast<std::size_t>(step)]);
}

double FdsLayer::caseTime(double time) const {
  return description_.clock.at(time, case_->times());
}

Result<FdsField> FdsLayer::fieldAt(double time) const {
  VOLUTE_ASSIGN(const auto field, case_->field(caseTime(time)));
  return inLight(field, time);
}

FdsField FdsLayer::inLight(const FdsField& field, double time) const {
  if (lights_.lamps.empty())
    return field.withSource(description_.albedo * lights_.ambient);
  return field.withLight(fdsLight(field, case_->obstructions(caseTime(time)),
                                  {.lamps = lights_.lamps,
                                   .ambient = lights_.ambient,
                                   .albedo = description_.albedo,
                                   .density = description_.model.scale,
                                   .blocks = blocks_}));
}

Status FdsLayer::openFire(Reading& reading) {
  const FdsLook& look = description_.fds;
  if (!look.fire || !(look.flame.emission > 0))
    return {};
  FdsOptions options{.volume = true};
  options.quantity = kFdsHeatRelease;
  options.maxMemory = reading.maxMemory;
  auto opened = FdsCase::open(case_->index(), options);
  if (!opened && opened.error().code == ErrorCode::kNotFound)
    return {};
  VOLUTE_TRY(opened);
  heat_ = std::make_shared<FdsCase>(std::move(*opened));
  flame_ = look.flame;
  flame_.cutoff = look.cutoff.value_or(case_->index().fireCutoff.value_or(flame_.cutoff));
  for (const std::string& remark : heat_->remarks()) {
    if (std::ranges::find(case_->remarks(), remark) == case_->remarks().end())
      reading.progress.remark(remark);
  }
  reading.progress.remark(fmt::format("{}: fire from {} ({}) above {:g} kW/m3", description_.file,
                                      heat_->source().name, heat_->source().description,
                                      flame_.cutoff));
  return {};
}

Result<std::optional<FdsFlame>> FdsLayer::fireAt(double time) const {
  if (!heat_)
    return std::nullopt;
  VOLUTE_ASSIGN(const auto heat, heat_->field(caseTime(time)));
  FdsFlame flame(heat, flame_);
  return flame.burns() ? std::optional(std::move(flame)) : std::nullopt;
}

std::uint64_t FdsLayer::surfacesAt(double time) const {
  const double local = caseTime(time);
  if (slice_)
    return std::bit_cast<std::uint64_t>(local);
  return static_cast<std::uint64_t>(
      std::ranges::count_if(events_, [&](double event) { return event <= local; }));
}

Status FdsLayer::addSurfaces(double time, TriangleMesh& to) const {
  addBuilding(time, to);
  if (description_.fds.devices)
    addDevices(time, to);
  return slice_ ? slice_->addTo(to, caseTime(time)) : Status();
}

/// An octahedron for each, which shines by itself.
void FdsLayer::addDevices(double time, TriangleMesh& to) const {
  const double local = caseTime(time);
  const auto material = static_cast<std::uint32_t>(to.materials.size());
  to.materials.push_back({Rgb::Zero(), kIdleDevice});
  to.materials.push_back({Rgb::Zero(), kActiveDevice});
  for (const FdsDevice& device : case_->index().devices) {
    const std::uint32_t look = material + (device.activeAt(local) ? 1 : 0);
    for (int side = 0; side < 8; ++side) {
      Vec3 corners[3];
      for (int axis = 0; axis < 3; ++axis) {
        corners[axis] = device.position;
        corners[axis][axis] += (side >> axis & 1) != 0 ? kDeviceSize : -kDeviceSize;
      }
      to.triangles.push_back({{corners[0], corners[1], corners[2]}, look});
    }
  }
}

std::vector<std::string> FdsLayer::words() const {
  std::vector<std::string> words{"FDS, " + source()};
  if (heat_) {
    words.push_back(fmt::format("fire: black body {:g} K, {:g}/m per MW/m3, above {:g} kW/m3",
                                flame_.temperature, flame_.emission, flame_.cutoff));
  }
  if (description_.fds.devices) {
    words.push_back(
        fmt::format("{} devices: blue, active ones magenta", case_->index().devices.size()));
  }
  if (slice_) {
    words.push_back(fmt::format("slice: {} {:.4g} .. {:.4g} {}", slice_->quantity(),
                                slice_->range()[0], slice_->range()[1], slice_->unit()));
  }
  return words;
}

std::optional<CameraDescription> FdsLayer::firstCamera() const {
  const auto room = largestRoom(case_->index(), caseTime(0));
  if (!room)
    return std::nullopt;
  const Vec3 size = room->size();
  const int along = size.x() >= size.y() ? 0 : 1;
  const double standing = std::min(kEyeHeight, kEyeShare * size.z());
  Vec3 eye = room->centre(), target = room->centre();
  eye.z() = target.z() = room->min.z() + standing;
  eye[along] = room->min[along] + std::min(kFromWall, 0.1 * size[along]);
  return CameraDescription{{eye, target, Vec3::UnitZ()}, kIndoorFov, std::nullopt, std::nullopt};
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
