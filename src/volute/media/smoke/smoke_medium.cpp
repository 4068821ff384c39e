// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_medium.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "volute/base/assert.hpp"
#include "volute/base/file_name.hpp"
#include "volute/base/gather_values.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/stopwatch.hpp"
#include "volute/io/foam_files.hpp"
#include "volute/lighting/inner_points.hpp"
#include "volute/lighting/share_fit.hpp"
#include "volute/media/clock_fields.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/media/smoke/mesh_probe.hpp"
#include "volute/media/smoke/mesh_sight.hpp"
#include "volute/media/smoke/shared_light.hpp"
#include "volute/media/smoke/smoke_words.hpp"
#include "volute/tetmesh/tet_medium.hpp"
#include "volute/volume_files/memory_volumes.hpp"

namespace volute {
namespace {

/// Smoke through which nobody sees a difference, across the whole case.
constexpr double kThinDepth = 0.05;

Result<MeshSource> openMesh(const std::string& file, const MeshOptions& options,
                            const Reading& reading) {
  if (auto inMemory = reading.volumes ? reading.volumes->mesh(file) : nullptr)
    return MeshSource::of(std::move(inMemory), file, options);
  return MeshSource::open(file, options);
}

/// Of a mesh that is hardly in metres.
std::string doubtOfSize(const Box3& bounds) {
  constexpr double kHigh = 300;  // [m] the smallest extent of no building's, nor of many plumes
  const Vec3 size = bounds.size();
  if (!(size.minCoeff() >= kHigh))
    return "";
  return fmt::format(
      "the mesh is {:.4g} x {:.4g} x {:.4g} m large; expected metres: in millimetres it would be "
      "{:.4g} x {:.4g} x {:.4g} m",
      size.x(), size.y(), size.z(), 1e-3 * size.x(), 1e-3 * size.y(), 1e-3 * size.z());
}

/// What the dimensions that a file states of the gas's density say against it; empty: nothing.
Result<std::string> compareDensity(const SmokeDescription& description,
                                   const std::array<double, 7>& stated) {
  constexpr std::array<double, 7> kDensity{1, -3}, kNone{};
  if (stated == kDensity)
    return std::string();
  const std::string field = fmt::format("field '{}'", description.densityField);
  if (stated == kNone)
    return field + ": the file states a number without dimensions; it is read as density [kg/m3]";
  return fail(ErrorCode::kInvalidData, {Hint::set("density_field")},
              "{}: {}: the file states {}, and the density of the gas has {}", description.file,
              field, textOfDimensions(stated), textOfDimensions(kDensity));
}

/// Smoke is conserved: cells of the visibility C / K go to points as K does.
CellMean meanFor(const SmokeDescription& smoke) {
  return smoke.model.quantity == SmokeQuantity::kVisibility ? CellMean::kInverses
                                                            : CellMean::kValues;
}

/// Both are read by the number of a time; in an EnSight case each field may have its own.
Status checkTimes(const MeshSource& source, const MeshSource& density,
                  const SmokeDescription& description) {
  if (std::ranges::equal(source.times(), density.times()))
    return {};
  return fail(ErrorCode::kUnsupported, {Hint::set("density_field")},
              "{}: field '{}' is at other times than the smoke; expected the same times",
              description.file, description.densityField);
}

std::vector<float> between(const std::vector<float>& a, const std::vector<float>& b, double share) {
  std::vector<float> out(a.size());
  interpolateFields(a, b, share, out);
  return out;
}

}  // namespace

Result<std::shared_ptr<SmokeMedium>> SmokeMedium::open(
    const SmokeDescription& description, std::shared_ptr<const SmokeLighting> lighting,
    Reading& reading, const OpenOptions& how) {
  constexpr std::uint64_t kPerTet = 210;  // bytes, of light and of what finds tets, measured
  MeshOptions options{description.field, description.negatives, reading.maxMemory};
  if (!how.sightOnly)
    options.perTet = kPerTet;
  options.alsoField = description.densityField;
  options.mean = meanFor(description);
  Team* const team = how.team;
  if (team)
    options.share = {team->rank(), team->size()};
  VOLUTE_ASSIGN(auto source, openMesh(description.file, options, reading));
  auto files = std::make_shared<Files>(Files{std::move(source)});
  if (!description.densityField.empty()) {
    options.alsoField = std::exchange(options.field, description.densityField);
    options.keepsCells = true;
    VOLUTE_ASSIGN(files->densitySource, openMesh(description.file, options, reading));
    VOLUTE_TRY(checkTimes(files->source, *files->densitySource, description));
  }
  if (const std::string absent = files->source.absentText(); !absent.empty())
    reading.progress.remark(
        Remark(RemarkCode::kLeftOut, fmt::format("{}: {}", description.file, absent))
            .in(description.file));
  for (const Remark& said : files->source.remarks()) reading.progress.remark(said);
  const std::shared_ptr<SmokeMedium> opened(new SmokeMedium(description, std::move(files)));
  SmokeMedium& medium = *opened;
  medium.remarked_ = how.sightOnly;
  medium.lighting_ = std::move(lighting);
  medium.progress_ = &reading.progress;
  medium.team_ = team;
  VOLUTE_ASSIGN(const auto stored, medium.readStep(0));
  VOLUTE_TRY(medium.checkShare(*stored));
  medium.bounds_ = stored->frame.mesh->bounds();
  if (team) {
    const Box3 own = medium.bounds_;
    VOLUTE_ASSIGN(const auto shares, gatherValues(*team, std::span(&own, 1)));
    for (const Box3& share : shares) medium.bounds_.extend(share);
  }
  VOLUTE_ASSIGN(const auto extinction, medium.extinctionOf(*stored));
  VOLUTE_ASSIGN(const double most, medium.largestOf(extinction));
  const MeshFrame& frame = stored->frame;
  medium.files_->field = frame.field, medium.files_->otherFields = frame.others;
  medium.remarkOn(*stored, most);
  const auto tell = [&](RemarkCode code, const std::string& what) {
    if (!what.empty())
      reading.progress.remark(
          Remark(code, fmt::format("{}: {}", description.file, what)).in(description.file));
  };
  if (const std::string unit = compareUnitInName(frame.field, description.model); !unit.empty())
    tell(RemarkCode::kDoubtful, fmt::format("field '{}': {}", frame.field, unit));
  // Where people look for signs it is a building; a plume may be as large.
  tell(how.sightOnly ? RemarkCode::kDoubtful : RemarkCode::kNote, doubtOfSize(medium.bounds_));
  if (frame.dimensions) {
    VOLUTE_ASSIGN(const std::string unit,
                  compareDimensions(*frame.dimensions, description.model,
                                    fmt::format("{}: field '{}'", description.file, frame.field)));
    if (!unit.empty())
      reading.progress.remark({RemarkCode::kDoubtful, unit});
  }
  if (stored->gasDimensions) {
    VOLUTE_ASSIGN(const std::string unit, compareDensity(description, *stored->gasDimensions));
    if (!unit.empty())
      tell(RemarkCode::kDoubtful, unit);
  }
  if (description.field.empty() && !frame.others.empty()) {
    reading.progress.remark(Remark(RemarkCode::kAssumed,
                                   fmt::format("{}: the field '{}' is read; it also has {}",
                                               description.file, frame.field, frame.others),
                                   {Hint::choose("field")})
                                .in(description.file));
  }
  medium.describe();
  return opened;
}

bool SmokeMedium::readsTheSame(const SmokeDescription& a, const SmokeDescription& b) {
  return a.file == b.file && a.field == b.field && a.densityField == b.densityField &&
         a.negatives == b.negatives && meanFor(a) == meanFor(b);
}

Result<std::shared_ptr<SmokeMedium>> SmokeMedium::with(
    const SmokeDescription& description, std::shared_ptr<const SmokeLighting> lighting,
    Reading& reading) const {
  VOLUTE_ASSERT(readsTheSame(description_, description));
  const std::shared_ptr<SmokeMedium> other(new SmokeMedium(description, files_));
  SmokeMedium& medium = *other;
  medium.lighting_ = std::move(lighting);
  medium.progress_ = &reading.progress;
  medium.bounds_ = bounds_;
  medium.team_ = team_;
  medium.fillsCache_ = false;
  for (const auto& stored : files_->steps) {
    VOLUTE_ASSIGN(const auto extinction, medium.extinctionOf(*stored));
    VOLUTE_ASSIGN(const double most, medium.largestOf(extinction));
    medium.remarkOn(*stored, most);
  }
  medium.describe();
  return other;
}

void SmokeMedium::describe() {
  const SmokeDescription& smoke = description_;
  const SmokeModel& model = smoke.model;
  info_.file = smoke.file;
  info_.what = "smoke on a mesh";
  info_.kind = "smoke";
  info_.shared = team_ != nullptr;
  info_.bounds = info_.fileBounds = bounds_;
  info_.takeFrames(*this, static_cast<int>(source().times().size()), smoke.clock);
  info_.interpolates = true;
  info_.measured = true;
  info_.law = smoke.law;
  info_.lawByC = smoke.givesC && model.quantity != SmokeQuantity::kVisibility;
  if (holdsMass(model.quantity)) {
    info_.mass = {model.quantity == SmokeQuantity::kProductsDensity ? "of products" : "of soot",
                  unitOfConcentration(model),
                  fmt::format("{} [{}]", nameOf(model.quantity), unitOfField(model))};
  } else {
    info_.noMass =
        fmt::format("field '{}' of {} holds {}", fieldName(), smoke.file, nameOf(model.quantity));
  }
}

Result<std::shared_ptr<const MediumSnapshot>> SmokeMedium::at(const SnapshotRequest& request,
                                                              Progress& progress) {
  VOLUTE_ASSIGN(auto state, stateAt(request.time, progress));
  return std::make_shared<const SmokeSnapshot>(std::move(state), request.factor, lighting_,
                                               description_.walls, team_);
}

MediumText SmokeMedium::text(const std::optional<Vec3>&) const {
  auto words = wordsOf(description_.model);
  return {{fmt::format("field '{}': {}", fieldName(), fmt::join(words, ", "))}, std::move(words)};
}

nlohmann::ordered_json SmokeMedium::counts() const {
  return {{"smoke",
           {{"steps_read", counts_.stepsRead},
            {"lights_computed", counts_.lightsComputed},
            {"lights_reused", counts_.lightsReused},
            {"negative_values_clamped", counts_.clamped},
            {"light_milliseconds", counts_.lightMilliseconds}}}};
}

Result<std::unique_ptr<SightField>> SmokeMedium::sight(Reading& reading) {
  if (extensionOf(description_.file) == ".foam") {
    if (const std::string said = foamGravity(description_.file); !said.empty())
      reading.progress.remark(Remark(RemarkCode::kDoubtful, said).in(description_.file));
  }
  if (description_.givesC && description_.model.quantity != SmokeQuantity::kVisibility) {
    const FieldOrigin& origin = description_.origin;
    return failIn(origin.file, origin.path + "/C", ErrorCode::kInvalidArgument,
                  "is of a visibility field, and this holds {}; a sign's C stands with the sign",
                  nameOf(description_.model.quantity));
  }
  VOLUTE_TRY(checkOwnTimes(description_.clock, description_.origin));
  VOLUTE_ASSIGN(auto air, parseMeshAir(description_.airFields));
  auto self = std::static_pointer_cast<SmokeMedium>(shared_from_this());
  return std::make_unique<MeshSight>(std::move(self), std::move(air));
}

std::unique_ptr<FieldProbe> SmokeMedium::fieldProbe() const {
  const auto stored = source().times();
  return meshProbe(source(), fieldName(), std::string(unitOfField(description_.model)),
                   [clock = description_.clock, times = std::vector(stored.begin(), stored.end())](
                       double time) { return clock.at(time, times); });
}

double SmokeMedium::timeOf(int step) const {
  return description_.clock.sceneTime(files_->source.times()[static_cast<std::size_t>(step)]);
}

Result<std::vector<float>> SmokeMedium::extinctionOf(const Stored& stored) const {
  const MeshFrame& frame = stored.frame;
  std::vector<float> extinction(frame.values.size());
  description_.model.extinction(frame.values, stored.gas, extinction);
  const auto endless = std::ranges::find_if(extinction, [](float k) { return !std::isfinite(k); });
  if (endless == extinction.end())
    return extinction;
  const auto vertex = endless - extinction.begin();
  const Vec3& place = frame.mesh->vertices()[static_cast<std::size_t>(vertex)];
  return fail(ErrorCode::kInvalidData, {Hint::choose("field"), Hint::set("quantity")},
              "{}: field '{}' is {} at {}, {}, {} m, which as {} is no finite "
              "extinction",
              description_.file, frame.field, frame.values[static_cast<std::size_t>(vertex)],
              plainNumber(place.x(), 4), plainNumber(place.y(), 4), plainNumber(place.z(), 4),
              nameOf(description_.model.quantity));
}

/// Of what a share of a mesh is not enough for.
Status SmokeMedium::checkShare(const Stored& stored) const {
  if (!team_)
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
Result<double> SmokeMedium::largestOf(std::span<const float> extinction) {
  const double most = *std::ranges::max_element(extinction);
  if (!team_)
    return most;
  VOLUTE_ASSIGN(const auto all, gatherValues(*team_, std::span(&most, 1)));
  return std::ranges::max(all);
}

/// At the first step with smoke.
void SmokeMedium::remarkOn(const Stored& stored, double most) {
  if (remarked_ || (!(most > 0) && files_->source.times().size() > 1))
    return;  // many a case begins without smoke
  remarked_ = true;
  largest_ = most;
  for (Remark& remark : remarksOn(most, fmt::format("step {}: ", stored.index)))
    progress_->remark(std::move(remark));
}

std::vector<Remark> SmokeMedium::remarksOn(double largest, const std::string& when) const {
  const std::string& file = description_.file;
  if (!(largest > 0)) {
    return {Remark(RemarkCode::kDoubtful,
                   fmt::format("{}: {}field '{}' is 0 everywhere: there is no smoke", file, when,
                               fieldName()))
                .in(file)};
  }
  const SmokeModel& model = description_.model;
  const double soot = model.sootDensity(largest);
  std::vector<Remark> remarks{Remark(fmt::format(
      "{}: {}field '{}' as {}: extinction up to {:.3g}/m, visibility from {:.3g} m (C = {:g}), "
      "soot "
      "up to {:.2g} kg/m3",
      file, files_->source.times().size() > 1 ? when : "", fieldName(), nameOf(model.quantity),
      largest, description_.law.c / largest, description_.law.c, soot))};
  if (soot > kMuchSoot) {
    remarks.push_back(Remark(RemarkCode::kDoubtful,
                             fmt::format("{}: that is much for soot (fires in rooms: 1e-6 to 1e-3 "
                                         "kg/m3); check the quantity and the unit",
                                         file))
                          .in(file));
  }
  addThinSmoke(largest, when, remarks);
  return remarks;
}

/// A unit that is too small makes a whole fire look like clear air.
void SmokeMedium::addThinSmoke(double most, const std::string& when,
                               std::vector<Remark>& remarks) const {
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
  remarks.push_back(
      Remark(RemarkCode::kDoubtful,
             fmt::format("{}: {}{}: no ray through the whole case meets an optical depth above "
                         "{:.2g}, which takes {:.2g} % of the light (soot in rooms on fire: 1e-6 "
                         "to 1e-3 kg/m3); {}",
                         description_.file, when,
                         clear ? "this looks like clear air" : "this is little for a fire", depth,
                         -100 * std::expm1(-depth), slip))
          .in(description_.file));
}

void SmokeMedium::tellOverlap(const Stored& stored) {
  constexpr double kTold = 1e-4;  // of the volume
  if (files_->overlapTold)
    return;
  const TetOverlap overlap = stored.paths->locator()->overlap();
  if (!(overlap.share > kTold))
    return;
  files_->overlapTold = true;
  progress_->remark(
      Remark(
          RemarkCode::kDoubtful,
          fmt::format("{}: step {}: {:.3g} % of the volume of its cells lie in other cells too, as "
                      "at ({}, {}, {}) m; pictures may count the smoke of both there, "
                      "sight lines that of one; write each place once, or mark the cells that are "
                      "copies (vtkGhostType)",
                      description_.file, stored.index, 100 * overlap.share,
                      plainNumber(overlap.first.x(), 4), plainNumber(overlap.first.y(), 4),
                      plainNumber(overlap.first.z(), 4)))
          .in(description_.file));
}

void SmokeMedium::tellContact(const Stored& stored) {
  if (files_->overlapTold || files_->contactTold)
    return;
  const auto place = stored.paths->locator()->openContact();
  if (!place)
    return;
  files_->contactTold = true;
  // OpenFOAM's patches say what such faces are.
  const bool foam = extensionOf(description_.file) == ".foam";
  progress_->remark(
      Remark(
          foam ? RemarkCode::kNote : RemarkCode::kDoubtful,
          fmt::format("{}: cells touch without common points, as at ({}, {}, {}) m: sight passes "
                      "there; make the points one, or leave a gap where a wall stands",
                      description_.file, plainNumber(place->x(), 4), plainNumber(place->y(), 4),
                      plainNumber(place->z(), 4)))
          .in(description_.file));
}

Result<std::shared_ptr<const SmokeMedium::Stored>> SmokeMedium::readStep(std::size_t index) {
  std::vector<std::shared_ptr<const Stored>>& held = files_->steps;
  for (const auto& stored : held) {
    if (stored->index == index)
      return stored;
  }
  auto stored = std::make_shared<Stored>();
  stored->index = index;
  std::vector<float> gasOfCells;  // the mean of cells is of what they have of both
  if (files_->densitySource) {
    VOLUTE_ASSIGN(auto density, files_->densitySource->read(index));
    stored->gas = std::move(density.values);
    stored->gasDimensions = density.dimensions;
    gasOfCells = std::move(density.cells);
  }
  VOLUTE_ASSIGN(stored->frame, files_->source.read(index, gasOfCells));
  const MeshFrame& frame = stored->frame;
  for (const auto& other : held) {
    if (other->frame.mesh == frame.mesh)
      stored->paths = other->paths, stored->meshHash = other->meshHash;
  }
  if (!stored->paths) {
    stored->paths = std::make_shared<const LampPaths>(
        std::make_shared<const TetLocator>(frame.mesh, frame.walls));
    constexpr double kVersion = 3;  // of LampPaths: another one, other light
    stored->meshHash.add(kVersion);
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    stored->meshHash.add(frame.mesh->vertices());
    stored->meshHash.add(frame.mesh->tets());
    if (frame.walls)
      stored->meshHash.add(std::span<const ThinWall>(*frame.walls));
    tellOverlap(*stored);
    tellContact(*stored);
  }
  if (frame.clamped > 0) {
    progress_->remark(
        Remark(RemarkCode::kChanged, fmt::format("{}: step {}: {} negative values taken as 0",
                                                 description_.file, index, frame.clamped))
            .in(description_.file));
  }
  if (frame.ghosts > 0 && !std::exchange(files_->ghostsTold, true)) {
    progress_->remark(Remark(RemarkCode::kLeftOut,
                             fmt::format("{}: {} cells that it marks as ghosts (vtkGhostType) are "
                                         "left out, as if another file had them",
                                         description_.file, frame.ghosts))
                          .in(description_.file));
  }
  if (frame.unusedMost > 0 && !std::exchange(files_->unusedTold, true)) {
    progress_->remark(Remark(RemarkCode::kNote,
                             fmt::format("{}: {} points that no cell has are left out, with values "
                                         "up to {:.3g}",
                                         description_.file, frame.unused, frame.unusedMost))
                          .in(description_.file));
  }
  counts_.clamped += frame.clamped;
  ++counts_.stepsRead;
  if (held.size() == 2)
    held.erase(held.begin());
  held.push_back(stored);
  return stored;
}

std::string SmokeMedium::lightKey(const Step& step, const Lamp& lamp) const {
  ContentHash hash = step.stored->meshHash;
  hash.add(std::span<const float>(step.extinction));
  lamp.addTo(hash);
  hash.add(std::span<const char>(lighting_->blocksKey));
  return hash.digits();
}

std::vector<float> SmokeMedium::lightOf(const Step& step, const Lamp& lamp) {
  const LightCache* const cache = lighting_->cache.get();
  LightMemory* const memory = lighting_->memory.get();
  const std::string key = cache || memory ? lightKey(step, lamp) : "";
  std::optional<std::vector<float>> kept;
  if (memory)
    kept = memory->find(key);
  if (!kept && cache)
    kept = cache->find(key, 2 * step.extinction.size());
  if (kept) {
    ++counts_.lightsReused;
  } else {
    const LampPaths& paths = *step.stored->paths;
    kept = paths.shares(step.extinction, lamp);
    const TetMesh& mesh = *step.stored->frame.mesh;
    const ArrivingLight arriving({.lamps = {lamp}, .blocks = lighting_->blocks}, mesh.bounds());
    const InnerSide side(mesh, arriving.hasSurfaces());
    arriving.takeFrom(0, side.vertices(), *kept, true, side.rounding());
    const auto means = paths.means(
        step.extinction, lamp, *kept,
        [&](std::span<const Vec3> points, std::span<float> shares) {
          arriving.takeFrom(0, points, shares, true, side.rounding());
        },
        side.lift());
    kept->insert(kept->end(), means.begin(), means.end());
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

Status SmokeMedium::light(Step& step) {
  const Stopwatch watch(counts_.lightMilliseconds);
  for (const Lamp& lamp : lighting_->lights.lamps) {
    VOLUTE_ASSIGN(const auto both, team_ ? sharedLightOf(step, lamp)
                                         : Result<std::vector<float>>(lightOf(step, lamp)));
    const auto middle = both.begin() + static_cast<std::ptrdiff_t>(both.size() / 2);
    step.lampShares.emplace_back(both.begin(), middle);
    step.lampMeans.emplace_back(middle, both.end());
  }
  return {};
}

Result<std::vector<float>> SmokeMedium::sharedLightOf(const Step& step, const Lamp& lamp) {
  const SharedMesh shared{*team_, *step.stored->paths->locator(), bounds_};
  const TetMesh& mesh = *step.stored->frame.mesh;
  VOLUTE_ASSIGN(auto shares, sharedLampShares(shared, step.extinction, lamp, mesh.vertices()));
  const ShareFit fit(mesh, step.extinction, shares);
  VOLUTE_ASSIGN(const auto there, sharedLampShares(shared, step.extinction, lamp, fit.places()));
  VOLUTE_ASSIGN(const auto means, fit.fitted(there, [&](std::span<double> sums) {
    return addAtSharedVertices(shared, sums);
  }));
  shares.insert(shares.end(), means.begin(), means.end());
  ++counts_.lightsComputed;
  return shares;
}

Result<std::shared_ptr<const SmokeMedium::Step>> SmokeMedium::step(std::size_t index) {
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
  if (steps_.size() == 2) {
    steps_.erase(steps_.begin());
    interval_ = {};
  }
  steps_.push_back(std::make_shared<const Step>(std::move(made)));
  return steps_.back();
}

Result<std::shared_ptr<const MeshWalls>> SmokeMedium::wallsOf(const MeshFrame& frame) {
  if (!files_->walls || files_->wallsOf != frame.mesh) {
    VOLUTE_ASSIGN(files_->walls, MeshWalls::make(*frame.mesh));
    files_->wallsOf = frame.mesh;
  }
  return files_->walls;
}

WallInterval SmokeMedium::wallsBetween(const std::shared_ptr<const Step>& from,
                                       const std::shared_ptr<const Step>& to) {
  if (interval_.from.get() != &from->extinction || interval_.to.get() != &to->extinction)
    interval_ = {{from, &from->extinction}, {to, &to->extinction}, std::make_shared<WallLight>()};
  return interval_;
}

Result<SmokeMedium::Extinction> SmokeMedium::extinctionAt(std::size_t step, Progress& progress) {
  progress_ = &progress;
  VOLUTE_ASSIGN(const auto stored, readStep(step));
  VOLUTE_ASSIGN(auto values, extinctionOf(*stored));
  return Extinction{stored->paths->locator(), std::move(values)};
}

Result<SmokeState> SmokeMedium::stateAt(double time, Progress& progress) {
  progress_ = &progress;
  const auto times = files_->source.times();
  const double local = description_.clock.at(time, times);
  const auto next = std::ranges::upper_bound(times, local);
  const std::size_t after = static_cast<std::size_t>(next - times.begin());
  const std::size_t before = after == 0 ? 0 : after - 1;
  VOLUTE_ASSIGN(const auto from, step(before));
  if (lighting_->lights.multiple && team_) {
    return fail(ErrorCode::kUnsupported,
                "{}: processes that share a mesh scatter light once; set \"scattering\" to single, "
                "or use one process",
                description_.file);
  }
  SmokeState state{from->stored->paths->locator(),
                   from->extinction,
                   {},
                   from->lampShares,
                   from->lampMeans,
                   extinctionOfConcentration(description_.model)};
  if (description_.walls) {
    VOLUTE_ASSIGN(state.walls, wallsOf(from->stored->frame));
  }
  if (after > 0 && after < times.size() && local > times[before]) {
    VOLUTE_ASSIGN(const auto to, step(after));
    if (to->stored->frame.mesh == from->stored->frame.mesh) {
      const double share = (local - times[before]) / (times[after] - times[before]);
      state.extinction = between(from->extinction, to->extinction, share);
      for (std::size_t l = 0; l < state.lampShares.size(); ++l) {
        state.lampShares[l] = between(from->lampShares[l], to->lampShares[l], share);
        state.lampMeans[l] = between(from->lampMeans[l], to->lampMeans[l], share);
      }
      if (state.walls) {
        state.interval = wallsBetween(from, to);
        state.intervalTime = share;
      }
    }
  }
  state.albedo = description_.albedo;
  return state;
}

}  // namespace volute
