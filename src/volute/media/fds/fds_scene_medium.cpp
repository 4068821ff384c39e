// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_scene_medium.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/parallel.hpp"
#include "volute/base/remark_log.hpp"
#include "volute/camera/pixel_ray.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/media/fds/fds_parameters.hpp"
#include "volute/media/fds/fds_report.hpp"
#include "volute/media/fds/fds_sight.hpp"
#include "volute/media/fds/fds_walls.hpp"
#include "volute/media/light_blockers.hpp"
#include "volute/media/smoke/shared_picture.hpp"
#include "volute/media/smoke/smoke_scene_medium.hpp"
#include "volute/render/scaled_medium.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// What ranks draw that hold a share of the meshes each.
class FdsSharesPicture final : public MediumPicture {
 public:
  FdsSharesPicture(const FdsAt& at, const FdsField& smoke, const FdsShares& shares)
      : smoke_(smoke), factor_(at.factor()), shares_(shares) {
    at.addMedia(media_);
  }

  void opticalDepth(const Camera& camera, std::span<const float> opaqueDepth,
                    std::span<float> depth) override {
    depthsOfPixels(camera, opaqueDepth, shares_.scale, depth);
  }

  void light(const Camera& camera, std::span<const float> opaqueDepth,
             std::span<float> rgbt) override {
    if (shares_.shines)
      return lightOfPieces(camera, opaqueDepth, rgbt);
    // Smoke in even light is as bright as it is thick, whatever the order.
    std::vector<float> depth(rgbt.size() / 4);
    depthsOfPixels(camera, opaqueDepth, factor_, depth);
    for (std::size_t i = 0; i < depth.size(); ++i) {
      const double taken = -std::expm1(-static_cast<double>(depth[i]));
      for (std::size_t c = 0; c < 3; ++c) {
        rgbt[4 * i + c] = static_cast<float>(taken * smoke_.source()[static_cast<Eigen::Index>(c)]);
      }
      rgbt[4 * i + 3] = static_cast<float>(1 - taken);
    }
  }

  DepthsAlong depthsOfAll() const override {
    return [this](std::span<const Segment> segments, std::span<double> depths) {
      smoke_.opticalDepth(segments, depths);
      for (double& depth : depths) depth *= shares_.scale;
      sumDepths(*shares_.holders, depths);
    };
  }

 private:
  static constexpr std::size_t kGrain = 4096;  // pixels worth a task

  void depthsOfPixels(const Camera& camera, std::span<const float> opaqueDepth, double factor,
                      std::span<float> depth) const {
    const auto width = static_cast<std::size_t>(camera.width());
    parallelRanges(depth.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      std::vector<Segment> rays;
      for (std::size_t i = begin; i < end; ++i) {
        rays.push_back(pixelRay(camera, static_cast<int>(i % width), static_cast<int>(i / width),
                                opaqueDepth));
      }
      std::vector<double> depths(rays.size());
      smoke_.opticalDepth(rays, depths);
      for (std::size_t i = begin; i < end; ++i)
        depth[i] = static_cast<float>(factor * depths[i - begin]);
    });
    sumDepths(*shares_.holders, depth);
  }

  void lightOfPieces(const Camera& camera, std::span<const float> opaqueDepth,
                     std::span<float> rgbt) const {
    const auto width = static_cast<std::size_t>(camera.width());
    composeRuns(
        *shares_.holders,
        [&](std::size_t pixel) {
          const Segment ray = pixelRay(camera, static_cast<int>(pixel % width),
                                       static_cast<int>(pixel / width), opaqueDepth);
          std::vector<std::vector<Piece>> pieces(media_.size());
          for (std::size_t m = 0; ray.begin < ray.end && m < media_.size(); ++m)
            media_[m].pieces(std::span(&ray, 1), std::span(&pieces[m], 1));
          return heldRuns(pieces);
        },
        rgbt);
  }

  FdsField smoke_;
  double factor_;
  FdsShares shares_;
  std::vector<AnyMedium> media_;
};

class FdsKind final : public MediumKind {
 public:
  const FieldTable& fields() const override { return fdsFields(); }

  Result<std::shared_ptr<SceneMedium>> open(const nlohmann::json& entry,
                                            MediumContext& context) const override {
    VOLUTE_ASSIGN(const auto smoke, parseSmoke(entry, {context.file, context.path}));
    const auto before = context.take<FdsSceneMedium>([&](const FdsSceneMedium& other) {
      return FdsLayer::readsTheSame(other.layer().description(), smoke);
    });
    if (before) {
      auto medium = std::make_shared<FdsSceneMedium>(before->layer().with(smoke, context.lights));
      medium->remarks = before->remarks;
      return std::shared_ptr<SceneMedium>(std::move(medium));
    }
    RemarkLog heard(context.reading.progress);
    Reading reading = context.reading.with(heard);
    VOLUTE_ASSIGN(auto layer, FdsLayer::open(smoke, context.lights, blocksOf(context.geometry),
                                             reading, context.options.holders));
    auto medium = std::make_shared<FdsSceneMedium>(std::move(layer));
    medium->remarks = heard.remarks();
    return std::shared_ptr<SceneMedium>(std::move(medium));
  }

  /// Of any of the case's sources, at its stored times, with what its bytes are rounded by.
  Result<std::unique_ptr<SightField>> openSight(const nlohmann::json& entry,
                                                MediumContext& context) const override {
    VOLUTE_ASSIGN(const auto smoke, parseSmoke(entry, {context.file, context.path}));
    if (smoke.model.scale != 1) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}/scale: is for meshes: the files of an FDS case say what they hold",
                  smoke.where);
    }
    FdsOptions options;
    options.source = smoke.field;
    if (smoke.model.massExtinction != kFdsMassExtinction)
      options.massExtinction = smoke.model.massExtinction;
    options.maxMemory = context.reading.maxMemory;
    if (smoke.givesC)
      options.visibilityFactor = smoke.model.c;
    VOLUTE_ASSIGN(auto fds, FdsCase::open(smoke.file, options));
    // Somebody who names a source is asking for that alone.
    std::vector<FdsCase> others;
    if (smoke.field.empty())
      others = fillingSources(fds, options);
    std::vector<std::string> remarks;
    VOLUTE_ASSIGN(auto mesh, fdsWalls(fds.index(), remarks));
    for (const std::string& remark : remarks)
      context.reading.progress.remark({RemarkCode::kLeftOut, remark});
    VOLUTE_ASSIGN(auto walls,
                  TriangleScene::build(std::move(mesh.triangles), std::move(mesh.materials)));
    return std::make_unique<FdsSight>(std::move(fds), smoke.file, options.maxMemory,
                                      std::move(others), std::move(walls));
  }

  bool opens(const std::string& path) const override { return isSmvPath(path); }

  Result<FileDescription> describe(const std::string& path, const DescribeRequest& request,
                                   Reading& reading) const override {
    return describeFdsCase(path, request, reading).map([](Report report) {
      return FileDescription{std::move(report)};
    });
  }

  /// An open building in even white light and before white. Thick smoke in such light is as dark as
  /// what an endless layer of it sends back: of isotropic scattering with FDS's albedo w = 0.3, by
  /// the two-stream approximation, (1 - g) / (1 + g) = 0.09 with g = sqrt(1 - w).
  OrderedJson sceneOf(const std::string& name) const override {
    return {{"format", kSceneFormat},
            {"background", {1, 1, 1}},
            {"lights", OrderedJson::array({{{"kind", "ambient"}, {"radiance", {1, 1, 1}}}})},
            {"media", OrderedJson::array({{{"kind", "smoke"},
                                           {"case", name},
                                           {"building", "open"},
                                           {"albedo", {0.09, 0.09, 0.09}}}})}};
  }

  bool shares(const std::string& key) const override { return key == "mode" || key == "C"; }

  void addParameters(ParameterGroup& group, const OrderedJson& entry, const SceneMedium& medium,
                     MediumFacts facts) const override {
    const FdsLayer& layer = dynamic_cast<const FdsSceneMedium&>(medium).layer();
    addCaseParameters(group, layer);
    MediumKind::addParameters(group, entry, medium, facts);
    addCaseLook(group, layer);
  }

  bool setParameter(OrderedJson& entry, const SceneMedium& medium, const std::string& key,
                    const OrderedJson& value, const std::vector<double>&) const override {
    return setCaseParameter(entry, dynamic_cast<const FdsSceneMedium&>(medium).layer(), key, value);
  }
};

}  // namespace

void FdsAt::addMedia(std::vector<AnyMedium>& media) const {
  media.push_back(scaledBy(factor_, AnyMedium(smoke_)));
  if (fire_)
    media.emplace_back(*fire_);
  media.insert(media.end(), sheets_.begin(), sheets_.end());
}

std::shared_ptr<const MediumAt> FdsAt::litBy(const MediaLight& light) const {
  if (!relit_ || shares_)
    return nullptr;
  auto smoke = relit_(smoke_, light);
  if (!smoke)  // only ranks can fail
    return nullptr;
  return std::make_shared<const FdsAt>(std::move(*smoke), factor_, fire_, sheets_);
}

std::shared_ptr<MediumPicture> FdsAt::picture(std::shared_ptr<MediumPicture>) const {
  return shares_ ? std::make_shared<FdsSharesPicture>(*this, smoke_, *shares_) : nullptr;
}

FdsSceneMedium::FdsSceneMedium(FdsLayer layer) : layer_(std::move(layer)) {
  const SmokeDescription& smoke = layer_.description();
  info_.file = smoke.file;
  info_.what = "an FDS case";
  info_.kind = "smoke";
  info_.bounds = info_.fileBounds = layer_.bounds();
  info_.takeFrames(layer_, layer_.steps(), smoke.clock);
  info_.interpolates = true;
  info_.measured = true;
  info_.burns = layer_.burns();
  info_.shared = info_.sharesAll = layer_.holders() != nullptr;
  info_.captioned = smoke.fds.building != FdsBuildingView::kWhole;
  info_.law = smoke.law;
}

Result<std::shared_ptr<const MediumAt>> FdsSceneMedium::at(const InstantRequest& request,
                                                           Progress&) {
  VOLUTE_ASSIGN(auto smoke, layer_.fieldAt(request.time, request.lit));
  VOLUTE_ASSIGN(auto fire, layer_.fireAt(request.time));
  VOLUTE_ASSIGN(auto sheets, layer_.isoAt(request.time));
  const double scale = layer_.description().model.scale;
  std::optional<FdsShares> shares;
  if (layer_.holders())
    shares = FdsShares{layer_.holders(), scale, layer_.shines()};
  const auto relit = [layer = layer_, time = request.time](const FdsField& field,
                                                           const MediaLight& light) {
    return layer.inLight(field, time, light);
  };
  return std::make_shared<const FdsAt>(std::move(smoke), request.factor * scale, std::move(fire),
                                       std::move(sheets), shares, relit);
}

Result<std::optional<FirstTime>> FdsSceneMedium::firstTime(Progress& progress) {
  return layer_.firstTime(progress);
}

MediumText FdsSceneMedium::text(const std::optional<Vec3>& eye) const {
  const std::vector<std::string> words = layer_.words(eye);
  MediumText text{words, words};
  text.marks = layer_.rulerMarks(eye);
  if (const FdsIsoSheets* iso = layer_.iso(); iso && iso->levels().size() > 1)
    text.scale = ColorScale{ColorMap::kViridis, iso->levels().back(), iso->levels().front()};
  if (const FdsParticleCloud* cloud = layer_.particles(); cloud && cloud->range())
    text.scale = ColorScale{ColorMap::kViridis, (*cloud->range())[1], (*cloud->range())[0]};
  if (const FdsSliceSheet* slice = layer_.slice())
    text.scale = ColorScale{ColorMap::kViridis, slice->range()[1], slice->range()[0]};
  return text;
}

const MediumKind& fdsKind() {
  static const FdsKind kind;
  return kind;
}

}  // namespace volute
