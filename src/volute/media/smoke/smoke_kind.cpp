// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "volute/base/parallel.hpp"
#include "volute/base/remark_log.hpp"
#include "volute/camera/pixel_ray.hpp"
#include "volute/lighting/inner_points.hpp"
#include "volute/media/light_blockers.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/media/shared_picture.hpp"
#include "volute/media/smoke/mesh_report.hpp"
#include "volute/media/smoke/smoke_contour.hpp"
#include "volute/media/smoke/smoke_medium.hpp"
#include "volute/media/smoke/smoke_parameters.hpp"
#include "volute/media/smoke/smoke_walls.hpp"
#include "volute/media/smoke/smoke_words.hpp"
#include "volute/tetmesh/tet_medium.hpp"
#include "volute/tetmesh/tet_splat.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

std::vector<float> scaledBy(double factor, std::vector<float> values) {
  if (factor != 1) {
    for (float& value : values) value = static_cast<float>(factor * value);
  }
  return values;
}

/// The splat of one mesh.
class MeshPicture final : public MediumPicture {
 public:
  explicit MeshPicture(const std::shared_ptr<const TetLocator>& mesh)
      : locator_(mesh), splat_(mesh) {}

  const std::shared_ptr<const TetLocator>& locator() const { return locator_; }

  void show(const SmokeSnapshot& smoke) {
    keep(natural_, smoke.state().extinction);
    keep(extinction_, smoke.extinction());
    keep(source_, smoke.state().source);
    team_ = smoke.team();
  }

  void opticalDepth(const Camera& camera, std::span<const float> opaqueDepth,
                    std::span<float> depth) override {
    setExtinction(natural_);
    splat_.opticalDepth(camera, opaqueDepth, depth);
    if (team_)
      sumDepths(*team_, depth);
  }

  void light(const Camera& camera, std::span<const float> opaqueDepth,
             std::span<float> rgbt) override {
    if (team_ && !source_.empty())
      return lightOfShares(camera, opaqueDepth, rgbt);
    setExtinction(extinction_);
    if (!source_.empty()) {
      if (!sourceShown_)
        splat_.setSource(source_);
      sourceShown_ = true;
      splat_.litColor(camera, opaqueDepth, rgbt);
      return;
    }
    std::vector<float> depth(rgbt.size() / 4);
    splat_.opticalDepth(camera, opaqueDepth, depth);
    if (team_)
      sumDepths(*team_, depth);
    constexpr std::size_t kGrain = 1 << 14;  // pixels
    parallelRanges(depth.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        std::fill_n(&rgbt[4 * i], 3, 0.0F);
        rgbt[4 * i + 3] = depth[i] > 0 ? std::exp(-depth[i]) : 1;
      }
    });
  }

 private:
  void keep(std::vector<float>& own, const std::vector<float>& given) {
    if (own == given)
      return;
    own = given, shown_ = nullptr, sourceShown_ = false;
  }

  /// Again for each picture of the same snapshot would be for nothing.
  void setExtinction(const std::vector<float>& extinction) {
    if (shown_ == &extinction || (shown_ && *shown_ == extinction))
      return;
    splat_.setExtinction(extinction);
    shown_ = &extinction;
  }

  void lightOfShares(const Camera& camera, std::span<const float> opaqueDepth,
                     std::span<float> rgbt) const {
    const TetMedium own(locator_, extinction_, source_);
    const auto width = static_cast<std::size_t>(camera.width());
    composeRuns(
        *team_,
        [&](std::size_t pixel) {
          const Segment ray = pixelRay(camera, static_cast<int>(pixel % width),
                                       static_cast<int>(pixel / width), opaqueDepth);
          std::vector<Piece> pieces;
          if (ray.begin < ray.end)
            own.pieces(std::span(&ray, 1), std::span(&pieces, 1));
          return heldRuns(std::span(&pieces, 1));
        },
        rgbt);
  }

  std::shared_ptr<const TetLocator> locator_;
  TetSplat splat_;
  std::vector<float> natural_, extinction_, source_;
  const std::vector<float>* shown_ = nullptr;  ///< what the splat has; null: something else
  bool sourceShown_ = false;
  Team* team_ = nullptr;
};

std::shared_ptr<const SmokeLighting> lightingOf(const MediumContext& context) {
  SmokeLighting lighting{context.lights, nullptr, blocksOf(context.geometry),
                         keyOf(context.geometry), context.options.lightMemory};
  if (!context.lights.lamps.empty())
    lighting.cache = context.options.lightCache;
  return std::make_shared<const SmokeLighting>(std::move(lighting));
}

class SmokeKind final : public MediumKind {
 public:
  const FieldTable& fields() const override { return smokeFields(); }

  Result<std::shared_ptr<SceneMedium>> open(const nlohmann::json& entry,
                                            MediumContext& context) const override {
    VOLUTE_ASSIGN(const auto smoke, parseSmoke(entry, {context.file, context.path}));
    const auto lighting = lightingOf(context);
    RemarkLog remarkLog(context.reading.progress);
    Reading reading = context.reading.with(remarkLog);
    const auto before = context.take<SmokeMedium>([&](const SmokeMedium& other) {
      return SmokeMedium::readsTheSame(other.description(), smoke);
    });
    auto medium = before ? before->with(smoke, lighting, reading)
                         : SmokeMedium::open(smoke, lighting, reading, context.options);
    VOLUTE_TRY(medium);
    (*medium)->remarks = remarkLog.remarks();
    return *medium;
  }

  bool opens(const std::string& path) const override { return isSmokeCase(path); }

  Result<FileDescription> describe(const std::string& path, const DescribeRequest& request,
                                   Reading& reading) const override {
    return describeMeshCase(path, request.values, reading);
  }

  /// Black or lit before white: the picture is what passes of the light.
  OrderedJson sceneOf(const std::string& name) const override {
    return {{"format", kSceneFormat},
            {"background", {1, 1, 1}},
            {"media", OrderedJson::array({{{"kind", "smoke"}, {"case", name}}})}};
  }

  std::string assume(OrderedJson& scene) const override {
    OrderedJson& smoke = scene["media"][0];
    if (!smoke.contains("negatives"))
      smoke["negatives"] = "clamp";
    if (smoke.contains("quantity"))
      return "";
    smoke["quantity"] = "soot-density";
    if (smoke.contains("unit"))
      return "";
    smoke["unit"] = "kg/m3";
    return "the field is taken for soot in kg/m3, unless you say otherwise";
  }

  std::string guess(OrderedJson& entry, const SceneMedium& medium) const override {
    return guessSmoke(entry, dynamic_cast<const SmokeMedium&>(medium));
  }

  /// Of several fields the one with a usual name.
  std::vector<OrderedJson> alternatives(const OrderedJson& entry) const override {
    std::vector<OrderedJson> others;
    if (entry.contains("field"))
      return others;
    for (const char* name : {"smoke", "soot", "SOOT DENSITY", "soot_density", "extinction"}) {
      others.push_back(entry);
      others.back()["field"] = name;
    }
    return others;
  }

  void addParameters(ParameterGroup& group, const OrderedJson&, const SceneMedium& medium,
                     MediumFacts facts) const override {
    const auto& smoke = dynamic_cast<const SmokeMedium&>(medium);
    facts.largestExtinction = smoke.largestExtinction();
    addSliders(group, fields(), &smoke.description(), facts);
  }

  bool setParameter(OrderedJson& entry, const SceneMedium&, const std::string& key,
                    const OrderedJson& value, const std::vector<double>&) const override {
    return setSmoke(entry, key, value);
  }

  bool shares(const std::string& key) const override { return key == "mode" || key == "C"; }
};

}  // namespace

std::vector<float> SmokeSnapshot::extinction() const {
  return scaledBy(factor_, state_.extinction);
}

void SmokeSnapshot::addMedia(std::vector<AnyMedium>& media) const {
  media.emplace_back(TetMedium(state_.locator, extinction(), state().source));
}

void SmokeSnapshot::addExtinction(std::vector<AnyMedium>& media) const {
  media.emplace_back(TetMedium(state_.locator, extinction(), {}));
}

std::shared_ptr<MediumPicture> SmokeSnapshot::picture(
    std::shared_ptr<MediumPicture> earlier) const {
  auto picture = std::dynamic_pointer_cast<MeshPicture>(earlier);
  if (!picture || picture->locator() != state_.locator)
    picture = std::make_shared<MeshPicture>(state_.locator);
  picture->show(*this);
  return picture;
}

Illumination SmokeLighting::illumination(const MediaLight& other) const {
  Illumination light{.lamps = lights.lamps,
                     .ambient = lights.ambient,
                     .blocks = blocks,
                     .between = {other.between.begin(), other.between.end()},
                     .multiple = lights.multiple};
  light.lamps.insert(light.lamps.end(), other.lamps.begin(), other.lamps.end());
  return light;
}

/// From the shares that the state has of each lamp.
void SmokeSnapshot::light(const Illumination& light) const {
  std::call_once(lit_, [&] {
    if (light.lamps.empty() && light.ambient.isZero(0))
      return;
    const AnyMedium smoke(TetMedium(state_.locator, state_.extinction, {}));
    const auto again = light.again(smoke, smoke.bounds(), {state_.albedo});
    state_.source = scatteredLight(state_.locator->mesh().vertices(), light.lamps,
                                   state_.lampMeans.empty() ? state_.lampShares : state_.lampMeans,
                                   state_.albedo, light.ambient, again.get());
  });
}

const SmokeState& SmokeSnapshot::state() const {
  light(lighting_->illumination());
  return state_;
}

std::shared_ptr<const MediumSnapshot> SmokeSnapshot::litBy(const MediaLight& other) const {
  const Illumination light = lighting_->illumination(other);
  const std::size_t own = lighting_->lights.lamps.size();
  VOLUTE_ASSERT(state_.lampShares.size() == own);
  if (team_ || light.lamps.empty() || !(state_.albedo.maxCoeff() > 0))
    return nullptr;
  const TetMesh& mesh = state_.locator->mesh();
  const ArrivingLight arriving(light, mesh.bounds());
  const InnerSide side(mesh, arriving.hasSurfaces());
  auto lit = std::make_shared<SmokeSnapshot>(state_, factor_, lighting_, walls_);
  std::vector<std::vector<float>>& shares = lit->state_.lampShares;
  const LampPaths paths(state_.locator);
  lit->state_.lampMeans.clear();
  for (std::size_t l = 0; l < light.lamps.size(); ++l) {
    if (l >= own)
      shares.push_back(paths.shares(state_.extinction, light.lamps[l]));
    const bool surfaces = l >= own;  // from its own they have taken
    arriving.takeFrom(l, side.vertices(), shares[l], surfaces, side.rounding());
    lit->state_.lampMeans.push_back(paths.means(
        state_.extinction, light.lamps[l], shares[l],
        [&](std::span<const Vec3> points, std::span<float> there) {
          arriving.takeFrom(l, points, there, true, side.rounding());
        },
        side.lift()));
  }
  lit->state_.source.clear();
  lit->light(light);
  shares = state_.lampShares;
  return lit;
}

std::optional<WallHit> SmokeSnapshot::wallOn(const Segment& ray) const {
  return wallLeft(*state_.locator, ray);
}

Result<SurfaceView> SmokeSnapshot::lookAtWalls(const Camera& camera, const TriangleScene& others,
                                               std::span<const std::uint8_t> only) const {
  return volute::lookAtWalls(camera, state_, lighting_->lights, *walls_, blocksOf(others), only,
                             wallLight_.get());
}

bool SmokeSnapshot::addContour(const Contour& contour, const Camera& camera,
                               ContourPieces& pieces) const {
  contourPieces(contour, camera, state_, pieces);
  return true;
}

const MediumKind& smokeKind() {
  static const SmokeKind kind;
  return kind;
}

}  // namespace volute
