// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_medium.hpp"

#include <nlohmann/json.hpp>

#include "volute/grid/bricks.hpp"
#include "volute/grid/refined_spline.hpp"
#include "volute/io/level_set_surface.hpp"
#include "volute/media/first_time.hpp"
#include "volute/media/volume/volume_probe.hpp"
#include "volute/medium/affine_medium.hpp"
#include "volute/render/scaled_medium.hpp"
#include "volute/volume_files/volume_grids.hpp"

namespace volute {
namespace {

constexpr int kCoarseLevels = 2;  ///< of a block's, the coarsest first

/// How many pixels a voxel of this size [m] covers where a view is closest to bounds.
double pixelsOfVoxel(const Camera& view, const Box3& bounds, double voxel) {
  if (view.isOrthographic())
    return voxel / view.pixelSize();
  const Vec3 signs = view.forward().unaryExpr([](double x) { return double((x > 0) - (x < 0)); });
  const Vec3 ahead = bounds.centre() + 0.5 * bounds.size().cwiseProduct(signs);
  if (!(view.forward().dot(ahead - view.eye()) > 0))
    return 0;  // it is behind the eye
  const Vec3 nearest = view.eye().cwiseMax(bounds.min).cwiseMin(bounds.max);
  return voxel / (view.pixelSize() * (nearest - view.eye()).norm());
}

}  // namespace

VolumeSnapshot::VolumeSnapshot(const VolumeMedium& of, double framePosition, double factor)
    : info_(of.infoAt(framePosition)),
      placement_(of.placementAt(framePosition)),
      emission_(of.appearance().emission),
      extinction_(factor * of.appearance().extinction),
      factor_(factor),
      lightsScene_(of.appearance().lights()) {}

VolumeSnapshot::VolumeSnapshot(const VolumeSnapshot& other,
                               std::shared_ptr<const VolumeLight> light)
    : info_(other.info_),
      placement_(other.placement_),
      emission_(other.emission_),
      extinction_(other.extinction_),
      factor_(other.factor_),
      lightsScene_(other.lightsScene_),
      light_(std::move(light)),
      provisional_(other.provisional_) {}

VolumeSnapshot::VolumeSnapshot(const VolumeMedium& of, std::shared_ptr<const BrickSlice> slice,
                               double framePosition, double factor)
    : VolumeSnapshot(of, framePosition, factor) {
  slice_ = std::move(slice);
}

VolumeSnapshot::VolumeSnapshot(const VolumeMedium& of, std::shared_ptr<const Tree4d> tree,
                               int position, double factor)
    : VolumeSnapshot(of, position, factor) {
  tree_ = std::move(tree);
  position_ = position;
}

VolumeSnapshot::VolumeSnapshot(const VolumeMedium& of, std::shared_ptr<const VolumeLight> light,
                               double framePosition, double factor)
    : VolumeSnapshot(of, framePosition, factor) {
  light_ = std::move(light);
}

const VoxelMedium& VolumeSnapshot::medium() const {
  std::call_once(made_, [&] {
    if (!slice_) {
      slice_ = std::make_shared<const BrickSlice>(
          asItLooks(tree_->extractSlice(position_, &nodesVisited_), info_));
    }
    medium_.emplace(slice_, emission(), extinction());
  });
  return *medium_;
}

const std::shared_ptr<const BrickSlice>& VolumeSnapshot::slice() const {
  if (tree_)
    medium();
  return slice_;
}

AffineMap VolumeSnapshot::place() const {
  return {placement_.turn, placement_.offset};
}

void VolumeSnapshot::addPlaced(AnyMedium medium, std::vector<AnyMedium>& media) const {
  if (place().isIdentity())
    media.push_back(std::move(medium));
  else
    media.emplace_back(AffineMedium(std::move(medium), place()));
}

void VolumeSnapshot::addMedia(std::vector<AnyMedium>& media) const {
  addPlaced(light_ ? scaledBy(factor_, AnyMedium(light_->seen())) : AnyMedium(medium()), media);
}

void VolumeSnapshot::addExtinction(std::vector<AnyMedium>& media) const {
  if (!light_ && extinction_ != 0)
    addMedia(media);
  else if (light_)
    addPlaced(scaledBy(factor_, AnyMedium(light_->volume())), media);
}

ShadedVoxels seenFrom(const VolumeLight& light, const Camera& camera) {
  const bool parallel = camera.isOrthographic();
  return light.seenFrom({parallel, parallel ? camera.forward() : camera.eye()});
}

Status VolumeSnapshot::addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const {
  if (!light_) {
    addMedia(media);
    return {};
  }
  const ShadedVoxels seen = seenFrom(*light_, camera);
  {
    const std::lock_guard lock(shadedGuard_);
    shaded_.push_back(seen);
  }
  addPlaced(scaledBy(factor_, AnyMedium(seen)), media);
  return {};
}

std::vector<Lamp> VolumeSnapshot::lightSources() const {
  if (!lamps_.empty())
    return lamps_;
  constexpr std::size_t kMaxLamps = 8;  // each costs a shadow's ray for each pixel of a surface
  if (!lightsScene_)
    return {};
  std::vector<Lamp> lamps;
  if (light_) {
    if (light_->slice().channels() == 4)
      lamps = VolumeLight::lampsOf(light_->slice(), place(), 1, kMaxLamps);
  } else if (emission_ > 0) {
    lamps = VolumeLight::lampsOf(*slice(), place(), emission_, kMaxLamps);
  }
  return lamps;
}

std::shared_ptr<const MediumSnapshot> VolumeSnapshot::litBy(const MediaLight& light) const {
  if (!light_ || !(light_->lighting().albedo.maxCoeff() > 0) ||
      (light.lamps.empty() && light_->lighting().lamps.empty()))
    return nullptr;
  return std::shared_ptr<const MediumSnapshot>(
      new VolumeSnapshot(*this, light_->withLamps(light.lamps, light.between)));
}

/// The values, and what VoxelMedium makes of them.
std::uint64_t VolumeSnapshot::memoryBytes() const {
  if (light_)
    return light_->memoryBytes();
  if (!slice_)
    return 0;
  return slice_->bytes() + slice_->values().size_bytes();
}

nlohmann::ordered_json VolumeSnapshot::counts() const {
  if (light_) {
    const std::lock_guard lock(shadedGuard_);
    MarchCounts sum;
    for (const ShadedVoxels& one : shaded_) {
      const MarchCounts counts = one.counts();
      sum.voxels += counts.voxels;
      sum.bricksVisited += counts.bricksVisited, sum.bricksSkipped += counts.bricksSkipped;
    }
    return {{"voxels_visited", sum.voxels},
            {"bricks_visited", sum.bricksVisited},
            {"bricks_skipped", sum.bricksSkipped},
            {"bricks_stored", shaded_.empty() ? 0 : shaded_.front().slice().storedBricks()},
            {"nodes_visited", 0}};
  }
  if (!medium_)
    return nlohmann::ordered_json::object();
  const MarchCounts counts = medium_->counts();
  return {{"voxels_visited", counts.voxels},
          {"bricks_visited", counts.bricksVisited},
          {"bricks_skipped", counts.bricksSkipped},
          {"bricks_stored", slice_->storedBricks()},
          {"nodes_visited", nodesVisited_}};
}

MediumInfo VolumeMedium::describe() const {
  MediumInfo info;
  info.file = path_;
  info.what = "a volume";
  info.kind = "volume";
  info.size = fmt::format("{} x {} x {} voxels, {} frame{}", volume_.x, volume_.y, volume_.z,
                          volume_.frames, volume_.frames == 1 ? "" : "s");
  info.bounds = boundsInScene();
  info.fileBounds = uprightBounds();
  info.takeFrames(*this, volume_.frames, appearance_.clock);
  info.channels = volume_.channels;
  info.interpolates = interpolation_ != Interpolation::kNone;
  if (appearance_.scatters() || appearance_.flames)
    info.channels = 3;
  if (appearance_.transfer)
    info.channels = 3, info.measured = true;
  info.absorbs = appearance_.extinction > 0 || appearance_.transfer;
  return info;
}

std::shared_ptr<VolumeMedium> VolumeMedium::with(const Appearance& appearance) const {
  std::shared_ptr<VolumeMedium> other(new VolumeMedium(*this));
  other->setAppearance(appearance);
  other->info_ = other->describe();
  return other;
}

const std::vector<std::string>& VolumeMedium::gridNames() const {
  if (gridNames_)
    return *gridNames_;
  gridNames_.emplace();
  if (!VolumeGrids::mayBe(path_))
    return *gridNames_;
  Progress quiet;
  Reading reading{.progress = quiet};
  const auto grids = VolumeGrids::open(path_, options_, reading);
  if (!grids)
    return *gridNames_;
  for (const VolumeGrid& grid : (*grids)->grids()) {
    if (!grid.empty && grid.kept.empty())
      gridNames_->push_back(grid.name);
  }
  return *gridNames_;
}

const ValueCounts& VolumeMedium::values() const {
  if (values_)
    return *values_;
  values_.emplace();
  Progress quiet;
  VolumeMedium copy = *this;
  copy.progress_ = &quiet;
  if (const auto slice = copy.sliceAt(shown_))
    values_ = ValueCounts::of(**slice);
  return *values_;
}

MediumText VolumeMedium::text(const std::optional<Vec3>& eye) const {
  MediumText text = SceneMedium::text(eye);
  if (const auto& transfer = appearance_.transfer) {
    const VolumeInfo& info = volume_;
    text.legend.push_back("values: " + info.name);
    text.scale = ColorScale{transfer->map, transfer->most, transfer->least, info.unit};
  }
  return text;
}

std::unique_ptr<FieldProbe> VolumeMedium::fieldProbe() const {
  return volumeProbe(*this);
}

int VolumeMedium::rowOf(int position) const {
  return input_->reader ? input_->reader->blocks().rowOf(position) : 0;
}

/// A .volute's block of frames that is not in memory takes its time.
bool VolumeMedium::inMemory(double time) const {
  return !input_->reader || rowOf(positionAt(time)) == block_;
}

Result<std::shared_ptr<const BrickSlice>> VolumeMedium::coarseSlice(int position,
                                                                    Progress& progress) const {
  constexpr std::uint64_t kDense = 64 << 20;  // [bytes]: beyond that most is empty
  const VolumeInfo info = infoAt(position);
  if (info.frameValues() * sizeof(float) <= kDense) {
    std::vector<float> values(info.frameValues());
    VOLUTE_TRY(input_->reader->readRegion(position, {0, 0, 0}, {info.z, info.y, info.x}, values,
                                          kCoarseLevels));
    return std::make_shared<const BrickSlice>(BrickSlice::fromDense(info, values));
  }
  VOLUTE_ASSIGN(
      const Tree4d tree,
      Tree4d::load(*input_->reader,
                   {.levels = kCoarseLevels, .firstFrame = position, .endFrame = position + 1},
                   progress));
  return std::make_shared<const BrickSlice>(asItLooks(tree.extractSlice(position), info));
}

Result<std::shared_ptr<const MediumSnapshot>> VolumeMedium::at(const SnapshotRequest& request,
                                                               Progress& progress) {
  progress_ = &progress;
  const int position = positionAt(request.time);
  const double framePosition = shown_ = framePositionAt(request.time);
  if (appearance_.surface) {
    // It is among the scene's surfaces, and there is nothing else.
    auto nothing = std::make_shared<VolumeSnapshot>(
        *this,
        std::make_shared<const BrickSlice>(BrickSlice::fromBricks(infoAt(position), Bricks())),
        position, request.factor);
    nothing->setLamps(lighting_.lamps);
    return nothing;
  }
  if (request.tree && interpolation_ != Interpolation::kNone) {
    return fail(ErrorCode::kUnsupported,
                "{}: the tree holds frames, and nothing between them; draw its bricks, or do not "
                "interpolate",
                path_);
  }
  if (appearance_.shaded()) {
    if (request.tree) {
      return fail(
          ErrorCode::kUnsupported,
          "{}: what is lit, burns or has a transfer function is not drawn from the tree; draw its "
          "bricks, or leave the preset or the transfer function out",
          path_);
    }
    VOLUTE_ASSIGN(auto light, lightAt(framePosition, request.lit, request.moving));
    block_ = rowOf(position);
    auto lit =
        std::make_shared<VolumeSnapshot>(*this, std::move(light), framePosition, request.factor);
    lit->setProvisional(lightMoves_);
    return lit;
  }
  if (request.coarse && !inMemory(request.time) && !input_->source->info().levelSet) {
    VOLUTE_ASSIGN(auto slice, coarseSlice(position, progress));
    return std::make_shared<const VolumeSnapshot>(*this, drawn(std::move(slice)), position,
                                                  request.factor);
  }
  if (request.tree) {
    VOLUTE_ASSIGN(auto tree, treeAt(position));
    block_ = rowOf(position);
    return std::make_shared<const VolumeSnapshot>(*this, std::move(tree), position, request.factor);
  }
  VOLUTE_ASSIGN(auto slice, sliceAt(framePosition));
  remarkOnNegative(*slice, framePosition);
  block_ = rowOf(position);
  const bool moves = request.moving && refines(*slice) && slice != drawnOf_;
  auto shown = std::make_shared<VolumeSnapshot>(
      *this, moves ? moved(*slice) : drawn(std::move(slice)), framePosition, request.factor);
  shown->setProvisional(moves);
  return shown;
}

std::uint64_t VolumeMedium::surfacesKey(const SnapshotRequest& request) const {
  if (!appearance_.surface)
    return 0;
  return 1 + static_cast<std::uint64_t>(positionAt(request.time));
}

Status VolumeMedium::addSurfaces(const SnapshotRequest& request, TriangleMesh& to) const {
  if (!appearance_.surface)
    return {};
  const Rgb base = Rgb::Constant(0.7);
  const auto material = static_cast<std::uint32_t>(to.materials.size());
  to.materials.push_back({base, base * lighting_.surrounding});
  const int position = positionAt(request.time);
  Bricks bricks;
  frame_->handOver();
  VOLUTE_TRY(input_->source->readBricks(position, bricks));
  const Placement world = placed(appearance_);
  const Mat3 linear = world.turn * world.scale.asDiagonal();
  GridMatrix place = gridMatrix(linear, world.offset);
  if (hasPlaces()) {
    const GridMatrix& own = input_->places[static_cast<std::size_t>(position)];
    place = gridMatrix(linear * linearOf(own), linear * offsetOf(own) + world.offset);
  }
  VOLUTE_ASSIGN(auto surface, LevelSetSurface::make(std::move(bricks), input_->source->info(),
                                                    place, maxMemory_));
  to.curved.push_back({std::move(surface), material});
  return {};
}

Result<std::optional<FirstTime>> VolumeMedium::firstTime(Progress&) {
  if (input_->amounts.empty() || std::ranges::max(input_->amounts) <= 0)
    return std::nullopt;
  const std::size_t first = firstThatShows(input_->amounts);
  std::string reason;
  if (first > 0) {
    reason = fmt::format("the first of {} with at least half of the most that there is in one",
                         volume_.frames);
  }
  return FirstTime{info_.times[first], std::move(reason)};
}

bool VolumeMedium::refines(const BrickSlice& slice) const {
  return slice.basis() == Basis::kCubic && appearance_.refines &&
         refinedSplineBytes(slice) <= maxMemory_ / 2;
}

std::shared_ptr<const BrickSlice> VolumeMedium::moved(const BrickSlice& slice) {
  BrickSlice other(slice);
  other.setBasis(Basis::kTrilinear);
  return std::make_shared<const BrickSlice>(std::move(other));
}

std::shared_ptr<const BrickSlice> VolumeMedium::splined(
    std::shared_ptr<const BrickSlice> slice) const {
  constexpr std::uint64_t kShare = 8;  // of the memory: tiles become voxels
  const std::uint64_t bytes = slice->entries().size() * sizeof(float) * BrickSlice::kVoxels *
                              static_cast<std::uint64_t>(slice->channels());
  if (slice->basis() != Basis::kCubic || input_->source->info().basis == Basis::kCubic ||
      bytes > maxMemory_ / kShare)
    return slice;
  return std::make_shared<const BrickSlice>(splineThrough(*slice));
}

std::shared_ptr<const BrickSlice> VolumeMedium::drawn(std::shared_ptr<const BrickSlice> slice) {
  if (slice->basis() != Basis::kCubic)
    return slice;
  if (slice != drawnOf_) {
    drawn_ = splined(slice);
    if (refines(*drawn_))
      drawn_ = std::make_shared<const BrickSlice>(refinedSpline(*drawn_));
    drawnOf_ = std::move(slice);
  }
  return drawn_;
}

void VolumeMedium::chooseLook(std::span<const Camera> views) {
  constexpr double kClose = 3;  // pixels
  Appearance appearance = appearance_;
  if (!appearance.basisByView || appearance.surface)
    return;
  Basis basis = input_->source->info().basis;
  if (basis == Basis::kBox) {
    const VolumeInfo info = infoAt(0);
    const double voxel =
        std::cbrt(info.bounds.size().prod() / (static_cast<double>(info.x) * info.y * info.z));
    const bool close = std::ranges::any_of(views, [&](const Camera& view) {
      return pixelsOfVoxel(view, info_.bounds, voxel) > kClose;
    });
    basis = close ? Basis::kCubic : Basis::kTrilinear;
  }
  if (appearance.basis == basis)
    return;
  appearance.basis = basis;
  setAppearance(appearance);
}

namespace {

/// Whether more than a hundredth of what is there is so dense that light ends within a voxel. Light
/// of splines is known inside of it alone, where it is dark, and not on its surface.
bool endsLight(const BrickSlice& slice) {
  constexpr double kDense = 3, kShare = 0.01;
  const Vec3 voxel = slice.bounds().size().cwiseQuotient(Vec3(slice.x(), slice.y(), slice.z()));
  const auto most = static_cast<float>(kDense / voxel.minCoeff());
  std::size_t dense = 0, all = 0;
  for (const BrickSlice::Entry& entry : slice.entries()) {
    const std::span<const float> values(slice.brick(entry.stored), BrickSlice::kVoxels);
    for (const float value : values) dense += value > most, all += value > 0;
  }
  return static_cast<double>(dense) > kShare * static_cast<double>(all);
}

}  // namespace

Result<std::shared_ptr<const VolumeLight>> VolumeMedium::lightAt(double framePosition, bool lit,
                                                                 bool moving) {
  if (framePosition == lightFramePosition_ && (lightIsWhole_ || !lit) && (moving || !lightMoves_))
    return light_;
  VOLUTE_ASSIGN(auto slice, shadedSliceAt(framePosition));
  const Placement place = placementAt(framePosition);
  VolumeLighting lighting;
  lighting.ownFire = false;
  if (lit)
    lighting = lighting_;
  lighting.place = {place.turn, place.offset};
  const bool dense = appearance_.basisByView && appearance_.scatters() &&
                     slice->basis() == Basis::kCubic && endsLight(*slice);
  const bool refined = !dense && refines(*slice);
  lighting.fewSky = moving && lit && lighting.surrounding.maxCoeff() > 0;
  slice = dense || (moving && refined) ? moved(*slice) : splined(std::move(slice));
  // Edges of shadows, colours, and light near a lamp change from voxel to voxel.
  const bool smooth = appearance_.colors.empty() && lighting.surfaces.empty() &&
                      std::ranges::all_of(lighting.lamps, [](const Lamp& lamp) {
                        return lamp.kind == Lamp::Kind::kSun;
                      });
  const bool moves = lighting.fewSky || (moving && refined);
  ShadedVoxels volume = refines(*slice) ? ShadedVoxels::refining(std::move(slice))
                        : smooth        ? ShadedVoxels::withTiles(std::move(slice))
                                        : ShadedVoxels(std::move(slice));
  if (lit && appearance_.scatters() && !appearance_.colors.empty()) {
    VOLUTE_ASSIGN(lighting.colors, colorsAt(framePosition, volume.lightPoints()));
  }
  light_ = std::make_shared<const VolumeLight>(std::move(volume), std::move(lighting));
  lightFramePosition_ = framePosition;
  lightIsWhole_ = lit;
  lightMoves_ = moves;
  return light_;
}

nlohmann::ordered_json VolumeMedium::counts() const {
  if (!input_->reader)
    return nlohmann::ordered_json::object();
  return {{"bytes_read", input_->reader->bytesRead()},
          {"blocks_decoded", input_->reader->blocksDecoded()},
          {"tree_nodes", treeNodes_},
          {"tree_bytes", treeBytes_}};
}

bool VolumeMedium::checked() const {
  return checked_ || !input_->reader;
}

Result<std::optional<std::string>> VolumeMedium::check(Progress& progress) {
  VOLUTE_ASSIGN(const auto integrity, input_->reader->verify(progress));
  checked_ = true;
  damaged_ = !integrity.complete();
  if (!damaged_)
    return std::nullopt;
  return fmt::format("{}; {} of {} parts are whole and shown", integrity.firstFault,
                     integrity.intactSegments, integrity.segments);
}

Status BillboardSnapshot::addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const {
  Progress quiet;
  VOLUTE_ASSIGN(auto drawn, Billboard::draw(AnyMedium(volume_->medium()), camera, options_, quiet));
  media.emplace_back(std::move(drawn));
  return {};
}

BillboardMedium::BillboardMedium(const VolumeMedium& volume, const SceneBillboard& board)
    : VolumeMedium(*volume.with(board.appearance)), options_(board.options) {
  options_.shown = VolumeMedium::volume().bounds;
  const Vec3 reach = Vec3::Constant(0.5 * std::hypot(options_.width, options_.height));
  info_.bounds = {options_.position - reach, options_.position + reach};
  info_.what = "a billboard";
  info_.kind = "billboard";
  info_.size.clear();
}

Result<std::shared_ptr<const MediumSnapshot>> BillboardMedium::at(const SnapshotRequest& request,
                                                                  Progress& progress) {
  if (hasPlaces()) {
    return fail(ErrorCode::kUnsupported,
                "{}: its grid is turned, or moves by parts of a voxel, and stands on no billboard",
                path());
  }
  SnapshotRequest whole = request;  // one draws bricks, of all levels
  whole.coarse = whole.tree = false;
  VOLUTE_ASSIGN(auto volume, VolumeMedium::at(whole, progress));
  return std::make_shared<const BillboardSnapshot>(
      std::static_pointer_cast<const VolumeSnapshot>(volume), options_);
}

}  // namespace volute
