// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_medium.hpp"

#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "volute/grid/bricks.hpp"
#include "volute/grid/refined_spline.hpp"
#include "volute/medium/affine_medium.hpp"
#include "volute/render/scaled_medium.hpp"
#include "volute/volume_files/volume_grids.hpp"

namespace volute {
namespace {

constexpr int kCoarseLevels = 2;  ///< of a block's, the coarsest first

MediumInfo infoOf(const VolumeLayer& layer) {
  const VolumeInfo& volume = layer.info();
  MediumInfo info;
  info.file = layer.path();
  info.what = "a volume";
  info.kind = "volume";
  info.size = fmt::format("{} x {} x {} voxels, {} frame{}", volume.x, volume.y, volume.z,
                          volume.frames, volume.frames == 1 ? "" : "s");
  info.bounds = layer.boundsInScene();
  info.fileBounds = layer.uprightBounds();
  info.takeFrames(layer, volume.frames, layer.appearance().clock);
  info.channels = volume.channels;
  info.interpolates = layer.interpolates();
  if (layer.appearance().transfer)
    info.channels = 3, info.measured = true;
  return info;
}

/// How many pixels a voxel of this size [m] covers where a view is closest to bounds.
double pixelsOfVoxel(const Camera& view, const Box3& bounds, double voxel) {
  if (view.isOrthographic())
    return voxel / view.pixelSize();
  const Vec3 ahead = bounds.centre() + 0.5 * bounds.size().cwiseProduct(view.forward().cwiseSign());
  if (!(view.forward().dot(ahead - view.eye()) > 0))
    return 0;  // it is behind the eye
  const Vec3 nearest = view.eye().cwiseMax(bounds.min).cwiseMin(bounds.max);
  return voxel / (view.pixelSize() * (nearest - view.eye()).norm());
}

}  // namespace

VolumeAt::VolumeAt(const VolumeLayer& layer, double moment, double factor)
    : info_(layer.infoAt(moment)),
      placement_(layer.placementAt(moment)),
      emission_(layer.appearance().emission),
      extinction_(factor * layer.appearance().extinction),
      factor_(factor),
      lightsScene_(layer.appearance().lights()) {}

VolumeAt::VolumeAt(const VolumeAt& other, std::shared_ptr<const VolumeLight> light)
    : info_(other.info_),
      placement_(other.placement_),
      emission_(other.emission_),
      extinction_(other.extinction_),
      factor_(other.factor_),
      lightsScene_(other.lightsScene_),
      light_(std::move(light)) {}

VolumeAt::VolumeAt(const VolumeLayer& layer, std::shared_ptr<const BrickSlice> slice, double moment,
                   double factor)
    : VolumeAt(layer, moment, factor) {
  slice_ = std::move(slice);
}

VolumeAt::VolumeAt(const VolumeLayer& layer, std::shared_ptr<const Tree4d> tree, int position,
                   double factor)
    : VolumeAt(layer, position, factor) {
  tree_ = std::move(tree);
  position_ = position;
}

VolumeAt::VolumeAt(const VolumeLayer& layer, std::shared_ptr<const VolumeLight> light,
                   double moment, double factor)
    : VolumeAt(layer, moment, factor) {
  light_ = std::move(light);
}

const VoxelMedium& VolumeAt::medium() const {
  std::call_once(made_, [&] {
    if (!slice_) {
      slice_ = std::make_shared<const BrickSlice>(
          asItLooks(tree_->extractSlice(position_, &nodesVisited_), info_));
    }
    medium_.emplace(slice_, emission(), extinction());
  });
  return *medium_;
}

const std::shared_ptr<const BrickSlice>& VolumeAt::slice() const {
  if (tree_)
    medium();
  return slice_;
}

AffineMap VolumeAt::place() const {
  return {placement_.turn, placement_.offset};
}

void VolumeAt::addPlaced(AnyMedium medium, std::vector<AnyMedium>& media) const {
  if (place().isIdentity())
    media.push_back(std::move(medium));
  else
    media.emplace_back(AffineMedium(std::move(medium), place()));
}

void VolumeAt::addMedia(std::vector<AnyMedium>& media) const {
  addPlaced(light_ ? scaledBy(factor_, AnyMedium(light_->seen())) : AnyMedium(medium()), media);
}

void VolumeAt::addExtinction(std::vector<AnyMedium>& media) const {
  if (!light_ && extinction_ != 0)
    addMedia(media);
  else if (light_)
    addPlaced(scaledBy(factor_, AnyMedium(light_->volume())), media);
}

ShadedVoxels seenFrom(const VolumeLight& light, const Camera& camera) {
  const bool parallel = camera.isOrthographic();
  return light.seenFrom({parallel, parallel ? camera.forward() : camera.eye()});
}

Status VolumeAt::addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const {
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

std::vector<Lamp> VolumeAt::lightSources() const {
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

std::shared_ptr<const MediumAt> VolumeAt::litBy(const MediaLight& light) const {
  if (!light_ || !(light_->lighting().albedo.maxCoeff() > 0) ||
      (light.lamps.empty() && light_->lighting().lamps.empty()))
    return nullptr;
  return std::shared_ptr<const MediumAt>(
      new VolumeAt(*this, light_->withLamps(light.lamps, light.between)));
}

/// The values, and what VoxelMedium makes of them.
std::uint64_t VolumeAt::memoryBytes() const {
  if (light_)
    return light_->memoryBytes();
  if (!slice_)
    return 0;
  return slice_->bytes() + slice_->values().size_bytes();
}

nlohmann::ordered_json VolumeAt::counts() const {
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

VolumeMedium::VolumeMedium(VolumeLayer layer) : layer_(std::move(layer)) {
  info_ = infoOf(layer_);
}

std::shared_ptr<VolumeMedium> VolumeMedium::with(const Appearance& appearance) const {
  VolumeLayer layer = layer_;
  layer.setAppearance(appearance);
  auto other = std::make_shared<VolumeMedium>(std::move(layer));
  other->lighting_ = lighting_;
  other->knowAs(*this);
  return other;
}

const std::vector<std::string>& VolumeMedium::gridNames() const {
  if (gridNames_)
    return *gridNames_;
  gridNames_.emplace();
  if (!VolumeGrids::mayBe(layer_.path()))
    return *gridNames_;
  Progress quiet;
  Reading reading{.progress = quiet};
  const auto grids = VolumeGrids::open(layer_.path(), layer_.options(), reading);
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
  VolumeLayer layer = layer_;
  layer.setProgress(quiet);
  if (const auto slice = layer.sliceAt(moment_))
    values_ = ValueCounts::of(**slice);
  return *values_;
}

MediumText VolumeMedium::text(const std::optional<Vec3>& eye) const {
  MediumText text = SceneMedium::text(eye);
  if (const auto& transfer = layer_.appearance().transfer) {
    const VolumeInfo& info = layer_.info();
    text.legend.push_back("values: " + info.name);
    text.scale = ColorScale{transfer->map, transfer->most, transfer->least, info.unit};
  }
  return text;
}

void VolumeMedium::knowAs(const VolumeMedium& other) {
  gridNames_ = other.gridNames_;
  values_ = other.values_, moment_ = other.moment_;
  checked_ = other.checked_, damaged_ = other.damaged_, block_ = other.block_;
  remarks = other.remarks;
}

int VolumeMedium::rowOf(int position) const {
  return layer_.reader() ? layer_.reader()->blocks().rowOf(position) : 0;
}

/// A .volute's block of frames that is not in memory takes its time.
bool VolumeMedium::inMemory(double time) const {
  return !layer_.reader() || rowOf(layer_.positionAt(time)) == block_;
}

Result<std::shared_ptr<const BrickSlice>> VolumeMedium::coarseSlice(int position,
                                                                    Progress& progress) const {
  VOLUTE_ASSIGN(
      const Tree4d tree,
      Tree4d::load(*layer_.reader(),
                   {.levels = kCoarseLevels, .firstFrame = position, .endFrame = position + 1},
                   progress));
  return std::make_shared<const BrickSlice>(
      asItLooks(tree.extractSlice(position), layer_.infoAt(position)));
}

Result<std::shared_ptr<const MediumAt>> VolumeMedium::at(const InstantRequest& request,
                                                         Progress& progress) {
  layer_.setProgress(progress);
  const int position = layer_.positionAt(request.time);
  const double moment = moment_ = layer_.momentAt(request.time);
  if (layer_.appearance().surface) {
    // It is among the scene's surfaces, and there is nothing else.
    auto nothing =
        std::make_shared<VolumeAt>(layer_,
                                   std::make_shared<const BrickSlice>(
                                       BrickSlice::fromBricks(layer_.infoAt(position), Bricks())),
                                   position, request.factor);
    nothing->setLamps(lighting_.lamps);
    return nothing;
  }
  if (request.tree && layer_.interpolates()) {
    return fail(ErrorCode::kUnsupported,
                "{}: the tree holds frames, and nothing between them; draw its bricks, or do not "
                "interpolate",
                layer_.path());
  }
  if (layer_.appearance().shaded()) {
    if (request.tree) {
      return fail(
          ErrorCode::kUnsupported,
          "{}: what is lit, burns or has a transfer function is not drawn from the tree; draw its "
          "bricks, or leave the preset or the transfer function out",
          layer_.path());
    }
    VOLUTE_ASSIGN(auto light, lightAt(moment, request.lit));
    block_ = rowOf(position);
    return std::make_shared<const VolumeAt>(layer_, std::move(light), moment, request.factor);
  }
  if (request.coarse && !inMemory(request.time) && !layer_.isLevelSet()) {
    VOLUTE_ASSIGN(auto slice, coarseSlice(position, progress));
    return std::make_shared<const VolumeAt>(layer_, drawn(std::move(slice)), position,
                                            request.factor);
  }
  if (request.tree) {
    VOLUTE_ASSIGN(auto tree, layer_.treeAt(position));
    block_ = rowOf(position);
    return std::make_shared<const VolumeAt>(layer_, std::move(tree), position, request.factor);
  }
  VOLUTE_ASSIGN(auto slice, layer_.sliceAt(moment));
  block_ = rowOf(position);
  return std::make_shared<const VolumeAt>(layer_, drawn(std::move(slice)), moment, request.factor);
}

std::uint64_t VolumeMedium::surfacesKey(const InstantRequest& request) const {
  if (!layer_.appearance().surface)
    return 0;
  return 1 + static_cast<std::uint64_t>(layer_.positionAt(request.time));
}

Status VolumeMedium::addSurfaces(const InstantRequest& request, TriangleMesh& to) const {
  if (!layer_.appearance().surface)
    return {};
  const Rgb base = Rgb::Constant(0.7);
  const auto material = static_cast<std::uint32_t>(to.materials.size());
  to.materials.push_back({base, base * lighting_.surrounding});
  return layer_.addSurface(layer_.positionAt(request.time), material, to.triangles);
}

bool VolumeMedium::refines(const BrickSlice& slice) const {
  return slice.basis() == Basis::kCubic && layer_.appearance().refines &&
         refinedSplineBytes(slice) <= layer_.maxMemory() / 2;
}

std::shared_ptr<const BrickSlice> VolumeMedium::drawn(std::shared_ptr<const BrickSlice> slice) {
  if (!refines(*slice))
    return slice;
  if (slice != refinedOf_) {
    refined_ = std::make_shared<const BrickSlice>(refinedSpline(*slice));
    refinedOf_ = std::move(slice);
  }
  return refined_;
}

void VolumeMedium::chooseLook(std::span<const Camera> views) {
  constexpr double kClose = 3;  // pixels
  Appearance appearance = layer_.appearance();
  if (!appearance.basisByView)
    return;
  Basis basis = layer_.fileBasis();
  if (basis == Basis::kBox) {
    const VolumeInfo info = layer_.infoAt(0);
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
  layer_.setAppearance(appearance);
  light_ = nullptr, lightMoment_ = -1;
  refinedOf_ = refined_ = nullptr;
}

Result<std::shared_ptr<const VolumeLight>> VolumeMedium::lightAt(double moment, bool lit) {
  if (moment == lightMoment_ && (lightIsWhole_ || !lit))
    return light_;
  VOLUTE_ASSIGN(auto slice, layer_.shadedSliceAt(moment));
  const Placement place = layer_.placementAt(moment);
  VolumeLighting lighting;
  lighting.ownFire = false;
  if (lit)
    lighting = lighting_;
  lighting.place = {place.turn, place.offset};
  ShadedVoxels volume =
      refines(*slice) ? ShadedVoxels::refining(std::move(slice)) : ShadedVoxels(std::move(slice));
  if (lit && layer_.appearance().scatters() && !layer_.appearance().colors.empty()) {
    VOLUTE_ASSIGN(lighting.colors, layer_.colorsAt(moment, volume.lightPoints()));
  }
  light_ = std::make_shared<const VolumeLight>(std::move(volume), std::move(lighting));
  lightMoment_ = moment;
  lightIsWhole_ = lit;
  return light_;
}

nlohmann::ordered_json VolumeMedium::counts() const {
  if (!layer_.reader())
    return nlohmann::ordered_json::object();
  const TreeCounts& tree = layer_.treeCounts();
  return {{"bytes_read", layer_.reader()->bytesRead()},
          {"blocks_decoded", layer_.reader()->blocksDecoded()},
          {"tree_nodes", tree.nodes},
          {"tree_bytes", tree.treeBytes}};
}

bool VolumeMedium::checked() const {
  return checked_ || !layer_.reader();
}

Result<std::optional<std::string>> VolumeMedium::check(Progress& progress) {
  VOLUTE_ASSIGN(const auto integrity, layer_.reader()->verify(progress));
  checked_ = true;
  damaged_ = !integrity.complete();
  if (!damaged_)
    return std::nullopt;
  return fmt::format("{}; {} of {} parts are whole and shown", integrity.firstFault,
                     integrity.intactSegments, integrity.segments);
}

Status BillboardAt::addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const {
  Progress quiet;
  VOLUTE_ASSIGN(auto drawn, Billboard::draw(AnyMedium(volume_->medium()), camera, options_, quiet));
  media.emplace_back(std::move(drawn));
  return {};
}

BillboardMedium::BillboardMedium(const VolumeMedium& volume, const SceneBillboard& board)
    : VolumeMedium(*volume.with(board.appearance)), options_(board.options) {
  options_.shown = layer().info().bounds;
  const Vec3 reach = Vec3::Constant(0.5 * std::hypot(options_.width, options_.height));
  info_.bounds = {options_.position - reach, options_.position + reach};
  info_.what = "a billboard";
  info_.kind = "billboard";
  info_.size.clear();
}

Result<std::shared_ptr<const MediumAt>> BillboardMedium::at(const InstantRequest& request,
                                                            Progress& progress) {
  if (layer().hasPlaces()) {
    return fail(ErrorCode::kUnsupported,
                "{}: its grid is turned, or moves by parts of a voxel, and stands on no billboard",
                layer().path());
  }
  InstantRequest whole = request;  // one draws bricks, of all levels
  whole.coarse = whole.tree = false;
  VOLUTE_ASSIGN(auto volume, VolumeMedium::at(whole, progress));
  return std::make_shared<const BillboardAt>(std::static_pointer_cast<const VolumeAt>(volume),
                                             options_);
}

}  // namespace volute
