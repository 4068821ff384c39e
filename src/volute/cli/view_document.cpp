// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/view_document.hpp"

#include <algorithm>
#include <cmath>

#include "volute/scene/fog_layer.hpp"
#include "volute/scene/scene_file.hpp"
#include "volute/scene/smoke_layer.hpp"
#include "volute/scene/volume_layer.hpp"

namespace volute::cli {
namespace {

constexpr double kRate = 25;      ///< frames a second of what has no times of its own
constexpr int kCoarseLevels = 2;  ///< of a block's, the coarsest first
constexpr double kHighest = 1e6;  ///< [m] that counts as an end

class ViewDocument final : public Document {
 public:
  ViewDocument(std::string path, std::uint64_t maxMemory)
      : path_(std::move(path)), maxMemory_(maxMemory) {}

  std::string title() const override { return title_; }

  Box3 bounds() const override { return bounds_; }

  std::vector<double> times() const override { return times_; }

  bool grey() const override {
    return fogs_.empty() && smokes_.empty() &&
           std::ranges::all_of(layers_,
                               [](const VolumeLayer& layer) { return layer.info().channels == 1; });
  }

  std::optional<StartView> startView() const override { return start_; }

  Rgb background() const override { return background_; }

  std::vector<std::string> remarks() const override { return remarks_; }

  std::vector<std::filesystem::path> files() const override { return files_; }

  bool coarseHelps(double time) const override;
  Result<GlScene> sceneAt(double time, bool coarse, Progress& progress) override;

  Status openVolume(Progress& progress);
  Status openScene(Progress& progress);
  Status openFogMap(Progress& progress);

 private:
  Reading reading(Progress& progress) const { return {progress, maxMemory_}; }

  Status addVolume(const std::string& file, const Appearance& appearance, Progress& progress);
  Status addFog(const FogDescription& description, const std::vector<FogSun>& suns,
                Progress& progress);
  Status addSmokes(const SceneDescription& scene, Progress& progress);
  void noteMissing(const SceneDescription& scene);
  void include(const Box3& bounds);
  Result<std::shared_ptr<const BrickSlice>> coarseSlice(const VolumeLayer& layer, int position,
                                                        Progress& progress) const;

  std::string path_;
  std::uint64_t maxMemory_;
  std::string title_;
  std::vector<VolumeLayer> layers_;
  std::vector<int> block_;  ///< of the frames that each layer has in memory
  std::vector<FogLayer> fogs_;
  std::vector<SmokeLayer> smokes_;
  Box3 bounds_;
  std::vector<double> times_{0.0};
  std::optional<StartView> start_;
  Rgb background_ = Rgb::Zero();
  std::vector<std::string> remarks_;
  std::vector<std::filesystem::path> files_;
};

/// What is infinite ends a little above the ground.
void ViewDocument::include(const Box3& bounds) {
  Box3 finite = bounds;
  const double width = bounds.size().head<2>().maxCoeff();
  if (!(finite.max.z() < kHighest))
    finite.max.z() =
        std::max(finite.min.z() > -kHighest ? finite.min.z() : 0.0, 0.0) + 0.25 * width;
  if (!(finite.min.z() > -kHighest))
    finite.min.z() = finite.max.z() - 0.25 * width;
  bounds_.extend(finite.min);
  bounds_.extend(finite.max);
}

Status ViewDocument::addVolume(const std::string& file, const Appearance& appearance,
                               Progress& progress) {
  Reading inner = reading(progress);
  VOLUTE_ASSIGN(auto layer, VolumeLayer::open(file, {.partial = true}, appearance, inner));
  include(layer.info().bounds);
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored))
    files_.emplace_back(file);
  layers_.push_back(std::move(layer));
  block_.push_back(-1);
  return {};
}

Status ViewDocument::addFog(const FogDescription& description, const std::vector<FogSun>& suns,
                            Progress& progress) {
  Reading inner = reading(progress);
  VOLUTE_ASSIGN(auto fog, FogLayer::open(description, suns, inner));
  include(fog.fogAt(0).bounds());
  if (fog.sunlit())
    remarks_.push_back("the suns' light in the fog is not shown");
  std::error_code ignored;
  for (const std::string& map : description.maps) {
    if (std::filesystem::exists(map, ignored))
      files_.emplace_back(map);
  }
  fogs_.push_back(std::move(fog));
  return {};
}

/// Smoke is lit by the lamps through itself; the scene's surfaces are not in their way.
Status ViewDocument::addSmokes(const SceneDescription& scene, Progress& progress) {
  Reading inner = reading(progress);
  auto lighting = std::make_shared<SmokeLighting>();
  lighting->lights = scene.lights;
  for (const SmokeDescription& description : scene.smokes) {
    VOLUTE_ASSIGN(auto smoke, SmokeLayer::open(description, lighting, inner));
    include(smoke.bounds());
    smokes_.push_back(std::move(smoke));
  }
  return {};
}

/// A picture that lacks something says so.
void ViewDocument::noteMissing(const SceneDescription& scene) {
  if (!scene.geometry.empty())
    remarks_.push_back("geometry is not shown, nor its shadows");
  if (!scene.signs.empty())
    remarks_.push_back("signs are not shown");
  if (!scene.billboards.empty())
    remarks_.push_back("billboards are not shown");
  if (scene.camera.ortho)
    remarks_.push_back("the scene's parallel camera is shown as a pinhole");
}

Status ViewDocument::openVolume(Progress& progress) {
  VOLUTE_TRY(addVolume(path_, {}, progress));
  const VolumeInfo& info = layers_.front().info();
  for (int i = 0; i < info.frames; ++i) times_.push_back(layers_.front().timeOf(i));
  times_.erase(times_.begin());
  title_ = fmt::format("{}: {} x {} x {} voxels, {} frames",
                       std::filesystem::path(path_).filename().string(), info.x, info.y, info.z,
                       info.frames);
  return {};
}

Status ViewDocument::openFogMap(Progress& progress) {
  FogDescription description;
  description.where = path_;
  description.maps = {path_};
  description.colour = FogColour::kLuma;
  description.options.degree = 2;
  constexpr double kTop = 10;  // [m], cells of 1 m
  VOLUTE_ASSIGN(description.profile, FogProfile::slab(0, kTop));
  VOLUTE_TRY(addFog(description, {}, progress));
  title_ = std::filesystem::path(path_).filename().string() + ": a map of fog";
  remarks_.push_back("cells of 1 m, 10 m high, 0.05 /m at most; a scene file says otherwise");
  return {};
}

Status ViewDocument::openScene(Progress& progress) {
  VOLUTE_ASSIGN(const auto scene, readScene(path_));
  files_.emplace_back(path_);
  for (const SceneVolume& volume : scene.volumes)
    VOLUTE_TRY(addVolume(volume.file, volume.appearance, progress));
  for (const FogDescription& fog : scene.fogs) VOLUTE_TRY(addFog(fog, scene.lights.suns, progress));
  VOLUTE_TRY(addSmokes(scene, progress));
  noteMissing(scene);
  double last = 0;
  for (const VolumeLayer& layer : layers_)
    last = std::max(last, layer.timeOf(layer.info().frames - 1));
  for (const FogLayer& fog : fogs_) last = std::max(last, fog.timeOf(fog.frames() - 1));
  for (const SmokeLayer& smoke : smokes_) last = std::max(last, smoke.timeOf(smoke.steps() - 1));
  for (int frame = 1; frame <= static_cast<int>(std::lround(last * kRate)); ++frame)
    times_.push_back(frame / kRate);
  const CameraDescription& camera = scene.camera;
  start_ = StartView{camera.view.eye, camera.view.target, camera.view.up, camera.fov.value_or(40)};
  background_ = scene.background;
  if (bounds_.empty())
    bounds_ = {camera.view.target - Vec3::Ones(), camera.view.target + Vec3::Ones()};
  title_ = fmt::format("{}: {} volumes, {} fogs, {} smokes",
                       std::filesystem::path(path_).filename().string(), layers_.size(),
                       fogs_.size(), smokes_.size());
  return {};
}

/// A .volute's block of frames that is not in memory takes its time.
bool ViewDocument::coarseHelps(double time) const {
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    if (layers_[i].reader() && layers_[i].positionAt(time) / BlockGrid::kSide != block_[i])
      return true;
  }
  return false;
}

Result<std::shared_ptr<const BrickSlice>> ViewDocument::coarseSlice(const VolumeLayer& layer,
                                                                    int position,
                                                                    Progress& progress) const {
  VOLUTE_ASSIGN(
      const Tree4d tree,
      Tree4d::load(*layer.reader(),
                   {.levels = kCoarseLevels, .firstFrame = position, .endFrame = position + 1},
                   progress));
  BrickSlice slice = tree.extractSlice(position);
  slice.setBasis(layer.info().basis);
  return std::make_shared<const BrickSlice>(std::move(slice));
}

Result<GlScene> ViewDocument::sceneAt(double time, bool coarse, Progress& progress) {
  GlScene scene;
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    VolumeLayer& layer = layers_[i];
    const int position = layer.positionAt(time);
    const bool placed = coarse && layer.reader() && position / BlockGrid::kSide != block_[i];
    layer.setProgress(progress);
    VOLUTE_ASSIGN(auto slice,
                  placed ? coarseSlice(layer, position, progress) : layer.sliceAt(position));
    if (!placed)
      block_[i] = position / BlockGrid::kSide;
    const Appearance& look = layer.appearance();
    GlVolume volume{std::move(slice), look.emission, look.extinction};
    if (look.placement.turns())  // else its place is in the slice's bounds
      volume.turn = look.placement.turn, volume.offset = look.placement.offset;
    scene.volumes.push_back(std::move(volume));
  }
  for (const FogLayer& fog : fogs_) scene.fogs.push_back(fog.fogAt(time));
  for (SmokeLayer& smoke : smokes_) {
    smoke.setProgress(progress);
    VOLUTE_ASSIGN(auto state, smoke.at(time));
    scene.smokes.push_back({state.locator, std::move(state.extinction), std::move(state.source)});
  }
  return scene;
}

}  // namespace

OpenDocument documentOpener(std::uint64_t maxMemory) {
  return [maxMemory](const std::string& path,
                     Progress& progress) -> Result<std::unique_ptr<Document>> {
    auto document = std::make_unique<ViewDocument>(path, maxMemory);
    const std::string extension = extensionOf(path);
    VOLUTE_TRY(extension == ".json"  ? document->openScene(progress)
               : extension == ".png" ? document->openFogMap(progress)
                                     : document->openVolume(progress));
    return document;
  };
}

}  // namespace volute::cli
