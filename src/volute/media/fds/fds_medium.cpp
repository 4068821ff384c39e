// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_medium.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <utility>

#include "volute/base/assert.hpp"
#include "volute/base/gather_values.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/fds/fds_room.hpp"
#include "volute/image/srgb.hpp"
#include "volute/media/clock_fields.hpp"
#include "volute/media/fds/fds_probe.hpp"
#include "volute/media/fds/fds_shares.hpp"
#include "volute/media/fds/fds_sight.hpp"
#include "volute/media/fds/fds_walls.hpp"
#include "volute/media/light_blockers.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/media/shared_picture.hpp"

namespace volute {
namespace {

constexpr double kDeviceSize = 0.12;  // [m], from the middle of a mark to its corners
constexpr double kEyeHeight = 1.7;    // [m] above the floor
constexpr double kEyeShare = 0.7;     // of a low room's height, at most
constexpr double kFromWall = 0.5;     // [m]
constexpr double kIndoorFov = 60;     // [degrees]
constexpr double kOutdoorFov = 30;    // [degrees]
constexpr double kShape = 1.25;       // width over height that an outside view has room for
constexpr double kMargin = 1.06;
constexpr double kForCaption = 0.16;  // of the picture's height, below what is seen
constexpr double kAside = 25;         // [degrees] from straight before a side
constexpr double kHigh = 42;          // [degrees] above the ground
constexpr double kHighStoreys = 17;   // the same where rooms are above each other
constexpr double kPlain = 0.68;       // reflected by what has no colour of its own
constexpr double kAlongX = 0.72, kAlongY = 0.86, kDown = 0.6;  // of faces' colours
constexpr double kCutShare = 0.25, kCutLight = 0.02;
constexpr double kLine = 0.0011;  // of the building's diagonal: half the width of outlines
constexpr double kEdge = 0.0004;  // likewise of edges of faces
constexpr double kEdgeLight = 0.12;
constexpr std::size_t kMaxOutlined = 2500;  // faces; with more, edges are a grey haze
constexpr int kTimesLookedAt = 9;
constexpr double kZeroCelsius = 273.15;  // [K]
constexpr std::size_t kTimesForFire = 5;
constexpr double kBrightFire = 1.4;  // luminance of the brighter quarter of what burns; white is 1
constexpr double kOutline = 0.25, kDarkMark = 0.01, kLightMark = 0.9;
const Rgb kIdleDevice(0.02, 0.1, 0.8);
const Rgb kActiveDevice(0.9, 0.02, 0.5);

/// As bright as lines are that are drawn beside walls, which a scene's lights may leave darker than
/// the light of a case alone does.
double lineLight(const SceneLights& lights, const Box3& box) {
  constexpr double kFar = 0.2;  // of the diagonal, from lamps to walls
  const double far = kFar * box.size().norm();
  Rgb light = lights.ambient;
  for (const Lamp& lamp : lights.lamps) {
    const double reach = lamp.kind == Lamp::Kind::kSun ? 1 : std::max(far, lamp.radius);
    light += lamp.intensity / (std::numbers::pi * reach * reach);
  }
  const double most = light.maxCoeff();
  return most > 0 ? std::min(most, 1.0) : 1;
}

/// What nobody has given a colour is FDS's own cream.
bool hasOwnColour(const FdsColour& colour) {
  const FdsColour usual{1.0F, 0.8F, 0.4F, 1.0F};
  for (int c = 0; c < 3; ++c) {
    if (std::abs(colour[c] - usual[c]) > 1e-3F)
      return true;
  }
  return false;
}

Rgb linear(const FdsQuad& quad, const Vec3& normal) {
  Rgb colour(srgbDecode(quad.colour[0]), srgbDecode(quad.colour[1]), srgbDecode(quad.colour[2]));
  if (!hasOwnColour(quad.colour))
    colour = Rgb::Constant(kPlain);
  if (quad.cut)
    return kCutShare * colour + Rgb::Constant(kCutLight);
  const double share = std::abs(normal.x()) > 0.5   ? kAlongX
                       : std::abs(normal.y()) > 0.5 ? kAlongY
                       : normal.z() < 0             ? kDown
                                                    : 1;
  return share * colour;
}

std::uint32_t addMaterial(TriangleMesh& to, const Material& material) {
  to.materials.push_back(material);
  return static_cast<std::uint32_t>(to.materials.size()) - 1;
}

void addBox(TriangleMesh& to, const Box3& box, std::uint32_t material) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int side = 0; side < 2; ++side) {
      Vec3 corners[4];
      for (int c = 0; c < 4; ++c) {
        corners[c][axis] = side == 1 ? box.max[axis] : box.min[axis];
        corners[c][u] = c == 1 || c == 2 ? box.max[u] : box.min[u];
        corners[c][v] = c >= 2 ? box.max[v] : box.min[v];
      }
      to.triangles.push_back({{corners[0], corners[1], corners[2]}, material});
      to.triangles.push_back({{corners[0], corners[2], corners[3]}, material});
    }
  }
}

/// A bar along an axis with square ends, `half` to each side.
Box3 bar(Vec3 from, Vec3 to, double half) {
  Box3 box;
  box.extend(Vec3(from - Vec3::Constant(half)));
  box.extend(Vec3(to + Vec3::Constant(half)));
  return box;
}

/// A ruler's divisions [m]: 1, 2 or 5 times a power of ten, a dozen at most over a length.
double divisionOf(double length) {
  double step = std::pow(10.0, std::floor(std::log10(length / 12)));
  for (const double factor : {2.0, 2.5, 2.0}) {
    if (length / step > 12)
      step *= factor;
  }
  return step;
}

FdsOptions optionsOf(const FdsDescription& smoke, std::uint64_t maxMemory) {
  FdsOptions options{.source = smoke.field};
  if (smoke.massExtinction != kFdsMassExtinction)
    options.massExtinction = smoke.massExtinction;
  if (smoke.givesC)
    options.visibilityFactor = smoke.law.c;
  options.maxMemory = maxMemory;
  return options;
}

}  // namespace

Result<std::shared_ptr<FdsMedium>> FdsMedium::open(const FdsDescription& description,
                                                   const MediumContext& context, Reading& reading) {
  const bool drawn = !context.options.sightOnly;
  FdsOptions options = optionsOf(description, reading.maxMemory);
  options.volume = options.orClear = drawn && description.field.empty();
  options.partly = !drawn;
  auto opened = std::make_shared<FdsMedium>();
  FdsMedium& medium = *opened;
  medium.team_ = context.options.team;
  if (medium.team_)
    options.share = {medium.team_->rank(), medium.team_->size()};
  VOLUTE_ASSIGN(auto files, FdsCase::open(description.file, options));
  medium.description_ = description;
  medium.lights_ = context.lights;
  medium.geometry_ = context.geometry;
  medium.case_ = std::make_shared<FdsCase>(std::move(files));
  const SmvIndex& index = medium.case_->index();
  VOLUTE_ASSIGN(auto walls, fdsWalls(index, medium.notes_));
  if (const FdsSource& source = medium.case_->source();
      options.massExtinction > 0 && source.kind != FdsFileKind::kClear &&
      source.quantity != SmokeQuantity::kSootDensity) {
    medium.notes_.push_back(
        {RemarkCode::kLeftOut,
         fmt::format("{}: a mass extinction of {:g} m2/kg has no effect: {} says how thick the "
                     "smoke is without one",
                     description.file, options.massExtinction, source.name)});
  }
  for (const Remark& note : medium.notes_) {
    if (drawn)
      reading.progress.remark(note);
  }
  medium.walls_ = std::make_shared<const TriangleMesh>(std::move(walls));
  medium.describe();
  if (!drawn)
    return opened;
  if (!medium.walls_->triangles.empty() && description.look.building == FdsBuildingView::kOpen) {
    reading.progress.remark(
        {RemarkCode::kLeftOut,
         "walls made of triangles (GEOM) are not drawn in an open building, which they may close"});
  }
  medium.events_ = obstructionEvents(index);
  for (const FdsMesh& mesh : index.meshes) {
    for (const FdsVent& vent : mesh.vents) {
      for (const FdsEvent& event : vent.events) medium.events_.push_back(event.time);
    }
  }
  medium.shell_ = std::make_shared<const FdsBuilding>(index, medium.caseTime(0));
  if (description.look.devices) {
    for (const FdsDevice& device : index.devices) {
      for (const FdsEvent& event : device.events) medium.events_.push_back(event.time);
    }
  }
  std::ranges::sort(medium.events_);
  for (const Remark& remark : medium.case_->remarks()) reading.progress.remark(remark);
  if (!medium.isClear()) {
    const FdsSource& source = medium.case_->source();
    reading.progress.remark(fmt::format("{}: extinction from {} ({})", description.file,
                                        source.name, source.description));
  }
  VOLUTE_TRY(medium.openFire(reading));
  if (medium.team_)
    VOLUTE_TRY(checkShares(description, index, medium.team_->size(), medium.burns()));
  medium.info_.burns = medium.burns();
  FdsLook look = description.look;
  if (medium.isClear())
    medium.showWhatThereIs(look, reading);
  if (!look.slice.empty()) {
    VOLUTE_ASSIGN(medium.slice_, FdsSliceSheet::open(index, look.slice, look.sliceRange, reading));
  }
  if (!description.look.iso.empty()) {
    VOLUTE_ASSIGN(medium.iso_, FdsIsoSheets::open(index, description.look.iso, reading));
  }
  if (!look.particles.empty()) {
    VOLUTE_ASSIGN(medium.particles_, FdsParticleCloud::open(index, look.particles, reading));
  }
  return opened;
}

/// A case that stores no smoke: its fire or particles, else the hottest slice, unless the user
/// named what to show.
void FdsMedium::showWhatThereIs(FdsLook& look, Reading& reading) const {
  const SmvIndex& index = case_->index();
  const bool named = !look.slice.empty() || !look.iso.empty() || !look.particles.empty();
  std::vector<std::string> shown{"the building"};
  if (heat_)
    shown.emplace_back("the fire");
  if (!named && !index.particles.empty())
    look.particles = "all";
  if (!look.particles.empty())
    shown.push_back("particles (" + look.particles + ")");
  if (!named && !heat_ && index.particles.empty())
    look.slice = hottestSlice(index);
  if (!look.slice.empty())
    shown.push_back("the slice " + look.slice);
  if (!look.iso.empty())
    shown.push_back("the surface " + look.iso);
  std::set<std::string> others;
  for (const FdsSliceEntry& slice : index.slices)
    others.insert("slices of " + slice.labels.quantity);
  for (const FdsIsoEntry& iso : index.isosurfaces)
    others.insert("surfaces of " + iso.labels.quantity);
  if (!index.particles.empty())
    others.insert("particles");
  reading.progress.remark(
      Remark(RemarkCode::kAssumed,
             fmt::format("{}: stores no smoke; shown: {}. The case has {}", description_.file,
                         fmt::join(shown, ", "),
                         others.empty() ? "nothing else that can be shown"
                                        : fmt::format("{}", fmt::join(others, ", "))))
          .in(description_.file));
}

bool FdsMedium::readsTheSame(const FdsDescription& a, const FdsDescription& b) {
  const auto sameFire = [](const FdsLook& x, const FdsLook& y) {
    return x.fire == y.fire && x.flame.temperature == y.flame.temperature &&
           x.emission == y.emission && x.flame.cutoff == y.flame.cutoff && x.cutoff == y.cutoff;
  };
  return a.file == b.file && a.field == b.field && a.massExtinction == b.massExtinction &&
         a.law.c == b.law.c && a.givesC == b.givesC && sameFire(a.look, b.look) &&
         a.look.devices == b.look.devices && a.look.slice == b.look.slice &&
         a.look.sliceRange == b.look.sliceRange && a.look.iso == b.look.iso &&
         a.look.particles == b.look.particles;
}

std::shared_ptr<FdsMedium> FdsMedium::with(const FdsDescription& description,
                                           const MediumContext& context) const {
  VOLUTE_ASSERT(readsTheSame(description_, description));
  auto medium = std::make_shared<FdsMedium>(*this);
  medium->description_ = description;
  medium->lights_ = context.lights;
  medium->geometry_ = context.geometry;
  medium->describe();
  return medium;
}

void FdsMedium::describe() {
  info_.file = description_.file;
  info_.what = "an FDS case";
  info_.kind = "smoke";
  info_.bounds = info_.fileBounds = bounds();
  info_.takeFrames(*this, static_cast<int>(case_->times().size()), description_.clock);
  info_.interpolates = true;
  info_.measured = true;
  info_.shared = info_.sharesAll = team_ != nullptr;
  info_.captioned = description_.look.building != FdsBuildingView::kWhole;
  info_.law = description_.law;
}

Result<std::shared_ptr<const MediumSnapshot>> FdsMedium::at(const SnapshotRequest& request,
                                                            Progress&) {
  const double time = request.time, scale = description_.scale;
  VOLUTE_ASSIGN(auto smoke, case_->field(caseTime(time)));
  if (lights_.multiple && team_ && request.lit && !lights_.lamps.empty()) {
    return fail(ErrorCode::kUnsupported,
                "{}: processes that share a case scatter light once; set \"scattering\" to single, "
                "or use one process",
                description_.file);
  }
  VOLUTE_ASSIGN(auto fire, fireAt(time));
  std::vector<AnyMedium> sheets;
  if (iso_) {
    VOLUTE_ASSIGN(sheets, iso_->at(caseTime(time)));
  }
  std::optional<FdsShares> shares;
  if (team_)
    shares = FdsShares{team_, scale, burns() || !lights_.lamps.empty()};
  FdsSnapshot::LightUp lightUp;
  if (request.lit) {
    smoke = smoke.withSource(description_.albedo * lights_.ambient);
    lightUp = [self = std::static_pointer_cast<const FdsMedium>(shared_from_this()), time,
               eye = request.eye](const FdsField& field, const MediaLight& light) {
      return self->inLight(field, time, eye, light);
    };
  }
  auto made =
      std::make_shared<const FdsSnapshot>(std::move(smoke), request.factor * scale, std::move(fire),
                                          std::move(sheets), shares, lightUp);
  if (team_)
    made->lit();  // which all ranks find together
  return made;
}

Result<std::unique_ptr<SightField>> FdsMedium::sight(Reading& reading) {
  if (description_.scale != 1) {
    const FieldOrigin& origin = description_.origin;
    return failIn(origin.file, origin.path + "/scale", ErrorCode::kInvalidArgument,
                  "is for meshes: the files of an FDS case say what they hold");
  }
  VOLUTE_TRY(checkOwnTimes(description_.clock, description_.origin));
  FdsOptions options = optionsOf(description_, reading.maxMemory);
  options.partly = true;
  VOLUTE_ASSIGN(auto files, FdsCase::open(case_->index(), options, case_.get()));
  // Somebody who names a source is asking for that alone.
  std::vector<FdsCase> others;
  std::vector<Remark> notes = notes_;
  if (description_.field.empty())
    others = fillingSources(files, options, case_.get(), &notes);
  const auto isCut = [](const FdsCase& one) {
    return one.source().quantity == SmokeQuantity::kVisibility;
  };
  if (options.visibilityFactor && !isCut(files) && std::ranges::none_of(others, isCut)) {
    notes.push_back(
        {RemarkCode::kLeftOut,
         fmt::format("{}: C = {:g} has no effect: {} is no visibility, and signs have their own C",
                     description_.file, *options.visibilityFactor, files.source().name)});
  }
  VOLUTE_ASSIGN(auto walls, TriangleScene::build(walls_->triangles, walls_->materials));
  return std::make_unique<FdsSight>(std::move(files), description_.file, options.maxMemory,
                                    std::move(others), std::move(walls), std::move(notes));
}

double FdsMedium::timeOf(int step) const {
  return description_.clock.sceneTime(case_->times()[static_cast<std::size_t>(step)]);
}

std::unique_ptr<FieldProbe> FdsMedium::fieldProbe() const {
  constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;  // of each quantity
  const auto stored = case_->times();
  return fdsProbe(
      case_->index(),
      [clock = description_.clock, times = std::vector(stored.begin(), stored.end())](double time) {
        return clock.at(time, times);
      },
      kMemory);
}

double FdsMedium::caseTime(double time) const {
  return description_.clock.at(time, case_->times());
}

FdsSnapshot::Lit FdsMedium::inLight(const FdsField& field, double time,
                                    const std::optional<Vec3>& eye, const MediaLight& other) const {
  Illumination light{.lamps = lights_.lamps,
                     .ambient = lights_.ambient,
                     .between = {other.between.begin(), other.between.end()},
                     .multiple = lights_.multiple};
  light.lamps.insert(light.lamps.end(), other.lamps.begin(), other.lamps.end());
  if (light.lamps.empty() || !(description_.albedo.maxCoeff() > 0))
    return {};
  FdsSnapshot::Lit lit{{}, inTheWay(time, eye)};
  light.blocks = blocksOf(lit.surfaces);
  const FdsLamps lamps{.light = std::move(light),
                       .surfaces = lit.surfaces,
                       .albedo = description_.albedo,
                       .density = description_.scale,
                       .team = team_};
  lit.smoke = std::make_shared<const LitMedium>(litFds(field, lamps));
  return lit;
}

TriangleScene FdsMedium::inTheWay(double time, const std::optional<Vec3>& eye) const {
  TriangleMesh all = geometry_.mesh();
  addFaces(quadsOf(buildingAt(time), eye), all);
  auto built = TriangleScene::of(std::move(all));
  return built ? *built
               : geometry_;  // corners that are not finite are refused where they are drawn
}

Status FdsMedium::openFire(Reading& reading) {
  const FdsLook& look = description_.look;
  if (!look.fire || look.emission == 0.0)
    return {};
  FdsOptions options{.volume = true};
  options.maxMemory = reading.maxMemory;
  if (team_)
    options.share = {team_->rank(), team_->size()};
  for (const std::string_view quantity : {kFdsFlameTemperature, kFdsHeatRelease}) {
    options.quantity = quantity;
    auto opened = FdsCase::open(case_->index(), options);
    if (!opened && opened.error().code == ErrorCode::kNotFound)
      continue;
    VOLUTE_TRY(opened);
    glows_ = quantity == kFdsFlameTemperature;
    heat_ = std::make_shared<FdsCase>(std::move(*opened));
    break;
  }
  if (!heat_)
    return {};
  flame_ = look.flame;
  flame_.cutoff = look.cutoff.value_or(case_->index().fireCutoff.value_or(flame_.cutoff));
  for (const Remark& remark : heat_->remarks()) {
    if (std::ranges::find(case_->remarks(), remark) == case_->remarks().end())
      reading.progress.remark(remark);
  }
  brightest_ = flame_.temperature;
  if (const auto hottest = glows_ ? heat_->largestSaid() : std::nullopt)
    brightest_ = std::max(brightest_, *hottest + kZeroCelsius);
  if (look.emission)
    flame_.emission = *look.emission;
  else
    VOLUTE_TRY(dimFire(reading));
  reading.progress.remark(fmt::format("{}: fire from {} ({}), {}", description_.file,
                                      heat_->source().name, heat_->source().description,
                                      fireLaw()));
  return {};
}

/// Light of flames adds up along a line of sight, and above white it is cut off: a burning room
/// would be one plain surface. So the brightest of some stored times is about as bright as white.
Status FdsMedium::dimFire(Reading& reading) {
  const auto times = heat_->times();
  std::size_t before = times.size();
  double most = 0;
  for (std::size_t i = 1; i <= kTimesForFire; ++i) {
    const std::size_t place = (times.size() - 1) * i / kTimesForFire;
    if (std::exchange(before, place) == place)
      continue;
    if (reading.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: looking how bright the fire is");
    VOLUTE_ASSIGN(const double luminance, luminanceAt(times[place]));
    most = std::max(most, luminance);
  }
  if (most > kBrightFire)
    flame_.emission *= kBrightFire / most;
  return {};
}

/// FdsFlame::luminance(), of all shares.
Result<double> FdsMedium::luminanceAt(double caseTime) const {
  VOLUTE_ASSIGN(const auto flame, flameOf(caseTime));
  VOLUTE_ASSIGN(const auto smoke, case_->field(caseTime));
  const double scale = description_.scale;
  if (!team_)
    return flame.luminance(smoke, scale);
  const Box3 own = flame.burns() ? flame.bounds() : Box3();
  VOLUTE_ASSIGN(const auto boxes, gatherValues(*team_, std::span(&own, 1)));
  Box3 box;
  for (const Box3& one : boxes) {
    if (one.empty())
      continue;
    box.extend(one);
  }
  if (box.empty())
    return 0.0;
  return flame.luminance(smoke, scale, box,
                         [&](std::span<double> values) { sumDepths(*team_, values); });
}

Result<FdsFlame> FdsMedium::flameOf(double caseTime) const {
  VOLUTE_ASSIGN(const auto heat, heat_->field(caseTime));
  return glows_ ? FdsFlame::glowing(heat, flame_, brightest_) : FdsFlame(heat, flame_);
}

std::string FdsMedium::fireLaw() const {
  return glows_ ? fmt::format("black bodies, {:.3g}/m at {:.0f} K", flame_.emission, brightest_)
                : fmt::format("black body {:g} K, {:.3g}/m per MW/m3, above {:.3g} kW/m3",
                              flame_.temperature, flame_.emission, flame_.cutoff);
}

Result<std::optional<FdsFlame>> FdsMedium::fireAt(double time) const {
  if (!heat_)
    return std::nullopt;
  VOLUTE_ASSIGN(auto flame, flameOf(caseTime(time)));
  return flame.burns() ? std::optional(std::move(flame)) : std::nullopt;
}

FdsBuilding FdsMedium::buildingAt(double time) const {
  return {case_->index(), caseTime(time)};
}

FdsSides FdsMedium::openTowards(const FdsBuilding& building, const std::optional<Vec3>& eye) const {
  return eye && description_.look.building == FdsBuildingView::kOpen ? building.sidesTowards(*eye)
                                                                     : 0;
}

std::uint64_t FdsMedium::surfacesKey(const SnapshotRequest& request) const {
  const double local = caseTime(request.time);
  const std::optional<Vec3>& eye = request.eye;
  std::uint64_t key = static_cast<std::uint64_t>(
      std::ranges::count_if(events_, [&](double event) { return event <= local; }));
  if (slice_)
    key = std::bit_cast<std::uint64_t>(local);
  const FdsLook& look = description_.look;
  if (look.devices || slice_ || particles_)  // another look of the same case adds others
    key = key * 1000003 + std::hash<std::string>()(fmt::format(
                              "{} {} {} {}", look.devices, look.slice, look.particles,
                              look.sliceRange ? (*look.sliceRange)[0] + (*look.sliceRange)[1] : 0));
  if (particles_)
    key = key * 1000003 + particles_->frameAt(local);
  if (eye &&
      (description_.look.building == FdsBuildingView::kOpen || !description_.look.cuts.empty()))
    key = key * 64 + shell_->sidesTowards(*eye) + 1;
  for (const FdsCut& cut : description_.look.cuts)
    key = key * 2 + (eye && (*eye)[cut.axis] < cut.place ? 1 : 0);
  return 1 + key;
}

Status FdsMedium::addSurfaces(const SnapshotRequest& request, TriangleMesh& to) const {
  const double time = request.time;
  addBuilding(time, request.eye, to);
  if (description_.look.devices)
    addDevices(time, to);
  if (particles_)
    VOLUTE_TRY(particles_->addTo(to, caseTime(time)));
  return slice_ ? slice_->addTo(to, caseTime(time)) : Status();
}

/// An octahedron for each, which shines by itself.
void FdsMedium::addDevices(double time, TriangleMesh& to) const {
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

std::vector<std::string> FdsMedium::words(const std::optional<Vec3>& eye) const {
  const SmvIndex& index = case_->index();
  std::string title = index.path.filename().string();
  if (!index.title.empty())
    title += ": " + index.title;
  std::vector<std::string> words{title, "FDS, " + case_->source().description};
  if (heat_)
    words.push_back("fire: " + fireLaw());
  if (openTowards(*shell_, eye) != 0)
    words.push_back(fmt::format("ruler: {:g} m each", ruler(0)) +
                    (rulerAxes() > 2 ? fmt::format(", {:g} m upwards", ruler(2)) : ""));
  if (!description_.look.cuts.empty()) {
    std::string planes;
    for (const FdsCut& cut : description_.look.cuts)
      planes += fmt::format(" {} = {} m", "xyz"[cut.axis], plainNumber(cut.place));
    words.push_back("cut at" + planes);
  }
  if (description_.look.devices) {
    words.push_back(
        fmt::format("{} devices: blue, active ones magenta", case_->index().devices.size()));
  }
  if (iso_)
    words.push_back("surface: " + iso_->words());
  if (particles_)
    words.push_back(particles_->words());
  if (slice_) {
    words.push_back(fmt::format("slice: {} {:.4g} .. {:.4g} {}", slice_->quantity(),
                                slice_->range()[0], slice_->range()[1], slice_->unit()));
  }
  return words;
}

MediumText FdsMedium::text(const std::optional<Vec3>& eye) const {
  const std::vector<std::string> words = this->words(eye);
  MediumText text{words, words};
  text.marks = rulerMarks(eye);
  if (iso_ && iso_->levels().size() > 1)
    text.scale = ColorScale{ColorMap::kViridis, iso_->levels().back(), iso_->levels().front()};
  if (particles_ && particles_->range())
    text.scale =
        ColorScale{ColorMap::kViridis, (*particles_->range())[1], (*particles_->range())[0]};
  if (slice_)
    text.scale = ColorScale{ColorMap::kViridis, slice_->range()[1], slice_->range()[0]};
  return text;
}

std::optional<CameraDescription> FdsMedium::firstCamera() const {
  if (description_.look.building == FdsBuildingView::kOpen)
    return outsideCamera();
  return insideCamera();
}

std::optional<CameraDescription> FdsMedium::insideCamera() const {
  const auto room = largestRoom(case_->index(), caseTime(0));
  if (!room)
    return std::nullopt;
  const Vec3 size = room->size();
  const int along = size.x() >= size.y() ? 0 : 1;
  const double standing = std::min(kEyeHeight, kEyeShare * size.z());
  Vec3 eye = room->centre(), target = room->centre();
  eye.z() = target.z() = room->min.z() + standing;
  eye[along] = room->min[along] + std::min(kFromWall, 0.1 * size[along]);
  return CameraDescription{{eye, target, Vec3::UnitZ()},
                           kIndoorFov,
                           std::nullopt,
                           std::nullopt,
                           "from within the largest room, at the height of the eyes"};
}

namespace {

/// Towards an eye that is `azimuth` round from -y and `height` above the ground [degrees].
Vec3 directionTo(double azimuth, double height) {
  const double a = azimuth * std::numbers::pi / 180, h = height * std::numbers::pi / 180;
  return {-std::sin(a) * std::cos(h), -std::cos(a) * std::cos(h), std::sin(h)};
}

/// A view in a direction that has all of a box in it.
View3 viewOf(const Box3& box, const Vec3& towardsEye) {
  View3 view{box.centre() + towardsEye, box.centre(), Vec3::UnitZ()};
  const double half = std::tan(0.5 * kOutdoorFov * std::numbers::pi / 180);
  const double wide = kShape * half / kMargin;
  const double tall = (1 - kForCaption) * half / kMargin;
  for (int turn = 0; turn < 3; ++turn) {
    const Camera camera = Camera::pinhole(view, kOutdoorFov, 1, 1);
    double distance = 1e-3;
    for (int i = 0; i < 8; ++i) {
      const Vec3 at = box.corner(i) - view.target;
      const double deep = at.dot(camera.forward());
      distance = std::max({distance, std::abs(at.dot(camera.right())) / wide - deep,
                           std::abs(at.dot(camera.down())) / tall - deep});
    }
    view.eye = view.target + distance * towardsEye;
    // What is seen is centred.
    Vec2 least = Vec2::Constant(1e300), most = -least;
    for (int i = 0; i < 8; ++i) {
      const Vec3 at = box.corner(i) - view.eye;
      const double deep = at.dot(camera.forward());
      const Vec2 seen(at.dot(camera.right()) / deep, at.dot(camera.down()) / deep);
      least = least.cwiseMin(seen);
      most = most.cwiseMax(seen);
    }
    const Vec2 middle = 0.5 * distance * (least + most);
    const Vec3 shift = middle.x() * camera.right() + middle.y() * camera.down();
    view.target += shift;
    view.eye += shift;
  }
  const Vec3 lower = kForCaption * half * (view.eye - view.target).norm() *
                     Camera::pinhole(view, kOutdoorFov, 1, 1).down();
  view.eye += lower;
  view.target += lower;
  return view;
}

/// The share of points that a view sees, and of what is over vents: where it may burn.
double shareSeen(const FdsBuilding& building, const Vec3& eye) {
  const FdsObstructions obstructions(building.kept(building.sidesTowards(eye)));
  constexpr double kVents = 0.6;  // of what counts as rooms do
  const auto count = [](const auto& list) { return static_cast<double>(list.size()); };
  const auto vents = building.vents();
  double seen = 0, all = 0;
  const auto look = [&](const Vec3& point, double weight) {
    const Vec3 way = point - eye;
    all += weight;
    if (!obstructions.blocked({eye, way.normalized(), 0, way.norm()}))
      seen += weight;
  };
  for (const Vec3& point : building.interior()) look(point, 1);
  constexpr double kOverVent = 0.3;  // [m]
  for (const Vec3& vent : vents) {
    look(vent + Vec3(0, 0, kOverVent),
         kVents * std::max(count(building.interior()), 1.0) / count(vents));
  }
  return all > 0 ? seen / all : 0;
}

}  // namespace

CameraDescription FdsMedium::outsideCamera() const {
  const FdsBuilding& building = *shell_;
  const double height = building.storeys() > 1 ? kHighStoreys : kHigh;
  const bool wide = building.bounds().size().x() >= building.bounds().size().y();
  View3 best;
  double most = -1;
  // A broad side and the front are preferred where about as much is seen.
  constexpr double kBetter = 0.04;
  for (const double side :
       wide ? std::array{0.0, 180.0, 90.0, 270.0} : std::array{90.0, 270.0, 0.0, 180.0}) {
    for (const double aside : {kAside, -kAside}) {
      const View3 view = viewOf(building.bounds(), directionTo(side + aside, height));
      const double share = shareSeen(building, view.eye);
      if (share > most + kBetter) {
        most = share;
        best = view;
      }
    }
  }
  return {
      best, kOutdoorFov, std::nullopt, std::nullopt,
      fmt::format("from outside; the outer walls towards the eye and the roof are left out, and "
                  "{:.0f} % of what is indoors is in view",
                  100 * most)};
}

Result<std::optional<FirstTime>> FdsMedium::firstTime(Progress& progress) {
  const auto times = case_->times();
  if (times.size() < 2)
    return std::nullopt;
  if (isClear()) {
    return FirstTime{description_.clock.sceneTime(times.back()),
                     "the last one: the case stores no smoke to choose by"};
  }
  std::vector<std::size_t> looked;
  const std::size_t last = times.size() - 1;
  for (int i = 1; i <= kTimesLookedAt; ++i) {
    const std::size_t place = last * static_cast<std::size_t>(i) / kTimesLookedAt;
    if (looked.empty() || place > looked.back())
      looked.push_back(place);
  }
  std::vector<double> amounts;
  double largest = 0;
  for (const std::size_t place : looked) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: looking for a time with smoke");
    VOLUTE_ASSIGN(const FdsField field, case_->field(times[place]));
    double amount = 0;
    for (const Vec3& point : shell_->interior()) {
      constexpr double kDepth = 3;  // [m] of such smoke
      if (field.cellAt(point) == FdsCell::kGas)
        amount += 1 - std::exp(-kDepth * field.extinction(point));
    }
    amounts.push_back(amount);
  }
  if (team_)
    sumDepths(*team_, std::span<double>(amounts));
  for (const double amount : amounts) largest = std::max(largest, amount);
  const auto found = std::ranges::find_if(
      amounts, [&](double amount) { return amount > 0 && amount >= 0.5 * largest; });
  if (found == amounts.end())
    return std::nullopt;
  const double time = times[looked[static_cast<std::size_t>(found - amounts.begin())]];
  return FirstTime{description_.clock.sceneTime(time),
                   fmt::format("of {} stored times looked at the first with at least half of the "
                               "largest amount of smoke in the rooms",
                               looked.size())};
}

std::vector<FdsQuad> FdsMedium::quadsOf(const FdsBuilding& building,
                                        const std::optional<Vec3>& eye) const {
  std::vector<FdsCut> cuts = description_.look.cuts;
  for (FdsCut& cut : cuts) cut.above = !eye || (*eye)[cut.axis] >= cut.place;
  return building.quads(openTowards(building, eye), cuts);
}

void FdsMedium::addFaces(std::span<const FdsQuad> quads, TriangleMesh& to) const {
  for (const FdsQuad& quad : quads) {
    const auto& c = quad.corners;
    const Vec3 across = (c[1] - c[0]).cross(c[3] - c[0]);
    if (!(across.norm() > 0))
      continue;
    const auto material = addMaterial(to, {linear(quad, across.normalized()), Rgb::Zero()});
    to.triangles.push_back({{c[0], c[1], c[2]}, material});
    to.triangles.push_back({{c[0], c[2], c[3]}, material});
  }
  if (description_.look.building == FdsBuildingView::kOpen)
    return;
  const auto first = static_cast<std::uint32_t>(to.materials.size());
  to.materials.insert(to.materials.end(), walls_->materials.begin(), walls_->materials.end());
  for (Triangle triangle : walls_->triangles) {
    triangle.material += first;
    to.triangles.push_back(triangle);
  }
}

void FdsMedium::addBuilding(double time, const std::optional<Vec3>& eye, TriangleMesh& to) const {
  const FdsBuilding building = buildingAt(time);
  const FdsSides open = openTowards(building, eye);
  const std::vector<FdsQuad> quads = quadsOf(building, eye);
  addFaces(quads, to);
  if (open == 0)
    return;
  if (quads.size() <= kMaxOutlined)
    addEdges(quads, building.bounds(), to);
  addOutline(*shell_, openTowards(*shell_, eye), to);  // stays where things come or go
  if (case_->index().north && eye) {
    const Needle needle = northNeedle(*eye, openTowards(*shell_, eye));
    const double scale = lineLight(lights_, shell_->bounds());
    const auto dark = addMaterial(to, {Rgb::Zero(), Rgb::Constant(kDarkMark * scale)});
    const auto light = addMaterial(to, {Rgb::Zero(), Rgb::Constant(kOutline * scale)});
    to.triangles.push_back({{needle.tip, needle.left, needle.notch}, dark});
    to.triangles.push_back({{needle.tip, needle.notch, needle.right}, light});
  }
}

/// Dark lines along the edges of all faces, as drawings have them.
void FdsMedium::addEdges(std::span<const FdsQuad> quads, const Box3& bounds,
                         TriangleMesh& to) const {
  Box3 meshes;
  for (const FdsMesh& mesh : case_->index().meshes) meshes.extend(mesh.bounds());
  const double half = kEdge * bounds.size().norm();
  const auto dark =
      addMaterial(to, {Rgb::Zero(), Rgb::Constant(kEdgeLight * lineLight(lights_, bounds))});
  const auto outer = [&](const FdsQuad& quad) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double place : {meshes.min[axis], meshes.max[axis]}) {
        if (std::ranges::all_of(quad.corners,
                                [&](const Vec3& corner) { return corner[axis] == place; }))
          return true;
      }
    }
    return false;
  };
  for (const FdsQuad& quad : quads) {
    if (outer(quad))
      continue;  // FDS cuts the meshes' own walls in pieces
    for (std::size_t corner = 0; corner < 4; ++corner)
      addBox(to, bar(quad.corners[corner], quad.corners[(corner + 1) % 4], half), dark);
  }
}

/// The edges of what the meshes fill, and rulers along the lower edges before it, and beside what
/// is tall.
void FdsMedium::addOutline(const FdsBuilding& building, FdsSides open, TriangleMesh& to) const {
  const Box3& box = building.bounds();
  const double half = kLine * box.size().norm();
  const double light = lineLight(lights_, box);
  const auto line = addMaterial(to, {Rgb::Zero(), Rgb::Constant(kOutline * light)});
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int corner = 0; corner < 4; ++corner) {
      Vec3 from = box.min, end = box.max;
      from[u] = end[u] = (corner & 1) != 0 ? box.max[u] : box.min[u];
      from[v] = end[v] = (corner & 2) != 0 ? box.max[v] : box.min[v];
      addBox(to, bar(from, end, 0.6 * half), line);
    }
  }
  const auto dark = addMaterial(to, {Rgb::Zero(), Rgb::Constant(kDarkMark * light)});
  const auto bright = addMaterial(to, {Rgb::Zero(), Rgb::Constant(kLightMark * light)});
  for (int axis = 0; axis < rulerAxes(); ++axis) {
    const double step = ruler(axis);
    const Vec3 from = rulerStart(box, axis, open, 5 * half);
    // At round coordinates, wherever the meshes begin.
    const double first = std::floor(box.min[axis] / step + 1e-6) * step;
    for (int i = 0; first + i * step < box.max[axis] - 1e-6; ++i) {
      Vec3 begin = from, end = from;
      begin[axis] = std::max(first + i * step, box.min[axis]);
      end[axis] = std::min(first + (i + 1) * step, box.max[axis]);
      Box3 mark = bar(begin, end, 2.4 * half);
      mark.min[axis] = begin[axis];
      mark.max[axis] = end[axis];
      addBox(to, mark, i % 2 == 0 ? dark : bright);
    }
  }
}

/// A needle on the ground beside that ruler which is to the right.
FdsMedium::Needle FdsMedium::northNeedle(const Vec3& eye, FdsSides open) const {
  constexpr double kLength = 0.075, kBeside = 0.15;  // of the outline's diagonal
  const Box3& box = shell_->bounds();
  const double size = box.size().norm();
  const Vec3 right = (box.centre() - eye).cross(Vec3::UnitZ());
  Vec3 middle = Vec3::Zero();
  for (int axis = 0; axis < 2; ++axis) {
    Vec3 at = rulerStart(box, axis, open, kBeside * size);
    at[axis] += 0.5 * box.size()[axis];
    if (axis == 0 || (at - middle).dot(right) > 0)
      middle = at;
  }
  const double angle = *case_->index().north * std::numbers::pi / 180;
  const Vec3 way = kLength * size * Vec3(std::sin(angle), std::cos(angle), 0);
  const Vec3 aside(0.3 * way.y(), -0.3 * way.x(), 0);
  return {middle + 0.5 * way, middle - 0.3 * way, middle - 0.5 * way - aside,
          middle - 0.5 * way + aside, middle + 0.85 * way};
}

Vec3 FdsMedium::rulerStart(const Box3& box, int axis, FdsSides open, double beside) {
  const auto far = [&](int across) { return (open >> (2 * across + 1) & 1) != 0; };
  Vec3 from = box.min;
  if (axis == 2) {  // where the ruler along x ends, on the side away from the eye
    from.x() = far(0) ? box.min.x() - beside : box.max.x() + beside;
    from.y() = far(1) ? box.max.y() : box.min.y();
    return from;
  }
  const int across = 1 - axis;
  from[across] = far(across) ? box.max[across] + beside : box.min[across] - beside;
  return from;
}

std::vector<PlaceMark> FdsMedium::rulerMarks(const std::optional<Vec3>& eye) const {
  const FdsSides open = openTowards(*shell_, eye);
  if (open == 0)
    return {};
  constexpr double kBeside = 0.035;  // of the outline's diagonal
  const Box3& box = shell_->bounds();
  const double beside = kBeside * box.size().norm();
  std::vector<PlaceMark> marks;
  if (case_->index().north && eye)
    marks.push_back({northNeedle(*eye, open).letter, "N"});
  for (int axis = 0; axis < rulerAxes(); ++axis) {
    const double step = ruler(axis);
    const Vec3 from = rulerStart(box, axis, open, beside);
    const double length = box.size()[axis];
    const auto first = static_cast<int>(std::ceil(box.min[axis] / step - 1e-6));
    const auto last = static_cast<int>(std::floor(box.max[axis] / step + 1e-6));
    const int every = last - first > 6 ? 2 : 1;
    for (int i = first; i <= last; ++i) {
      if (i % every != 0)
        continue;
      Vec3 at = from;
      at[axis] = i * step;
      const double number = std::round(at[axis] * 1e4) / 1e4;
      marks.push_back({at, fmt::format("{:.12g}", number == 0 ? 0.0 : number)});
    }
    Vec3 name = rulerStart(box, axis, open, 2.2 * beside);
    name[axis] += 0.5 * length;
    marks.push_back({name, fmt::format("{} [m]", "xyz"[axis])});
  }
  return marks;
}

/// The length of its divisions [m].
double FdsMedium::ruler(int axis) const {
  const Vec3 size = shell_->bounds().size();
  return divisionOf(axis < 2 ? size.head<2>().maxCoeff() : size.z());
}

/// One upwards, too, where storeys cannot be counted at a glance.
int FdsMedium::rulerAxes() const {
  constexpr double kTall = 12;  // [m]
  return shell_->bounds().size().z() >= kTall ? 3 : 2;
}

}  // namespace volute
