// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/parallel.hpp"
#include "volute/base/remark_log.hpp"
#include "volute/camera/pixel_ray.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/media/fds/fds_medium.hpp"
#include "volute/media/fds/fds_parameters.hpp"
#include "volute/media/fds/fds_report.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/media/shared_picture.hpp"
#include "volute/render/scaled_medium.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// What ranks draw that hold a share of the meshes each.
class FdsSharesPicture final : public MediumPicture {
 public:
  FdsSharesPicture(const FdsSnapshot& at, const FdsField& smoke, const FdsShares& shares)
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
        rgbt[4 * i + c] = static_cast<float>(taken * smoke_.source()[c]);
      }
      rgbt[4 * i + 3] = static_cast<float>(1 - taken);
    }
  }

  DepthsAlong depthsOfAll() const override {
    return [this](std::span<const Segment> segments, std::span<double> depths) {
      smoke_.opticalDepth(segments, depths);
      for (double& depth : depths) depth *= shares_.scale;
      sumDepths(*shares_.team, depths);
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
    sumDepths(*shares_.team, depth);
  }

  void lightOfPieces(const Camera& camera, std::span<const float> opaqueDepth,
                     std::span<float> rgbt) const {
    const auto width = static_cast<std::size_t>(camera.width());
    composeRuns(
        *shares_.team,
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
    VOLUTE_ASSIGN(const auto smoke, parseFds(entry, {context.file, context.path}));
    const auto before = context.take<FdsMedium>([&](const FdsMedium& other) {
      return FdsMedium::readsTheSame(other.description(), smoke);
    });
    if (before)
      return before->with(smoke, context);
    RemarkLog remarkLog(context.reading.progress);
    Reading reading = context.reading.with(remarkLog);
    VOLUTE_ASSIGN(auto medium, FdsMedium::open(smoke, context, reading));
    medium->remarks = remarkLog.remarks();
    return medium;
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
    const auto& fds = dynamic_cast<const FdsMedium&>(medium);
    addCaseParameters(group, fds);
    MediumKind::addParameters(group, entry, medium, facts);
    addCaseLook(group, fds);
  }

  bool setParameter(OrderedJson& entry, const SceneMedium& medium, const std::string& key,
                    const OrderedJson& value, const std::vector<double>&) const override {
    return setCaseParameter(entry, dynamic_cast<const FdsMedium&>(medium), key, value);
  }
};

}  // namespace

const FdsSnapshot::Lit& FdsSnapshot::lit() const {
  std::call_once(asked_, [&] {
    if (lightUp_)
      lit_ = lightUp_(smoke_, {});
  });
  return lit_;
}

void FdsSnapshot::addMedia(std::vector<AnyMedium>& media) const {
  media.push_back(scaledBy(factor_, lit().smoke ? AnyMedium(*lit().smoke) : AnyMedium(smoke_)));
  if (fire_)
    media.emplace_back(*fire_);
  media.insert(media.end(), sheets_.begin(), sheets_.end());
}

void FdsSnapshot::addExtinction(std::vector<AnyMedium>& media) const {
  media.push_back(scaledBy(factor_, AnyMedium(smoke_)));
  media.insert(media.end(), sheets_.begin(), sheets_.end());
}

std::shared_ptr<const MediumSnapshot> FdsSnapshot::litBy(const MediaLight& light) const {
  if (!lightUp_ || shares_)
    return nullptr;
  const LightUp lightUp =
      [lightUp = lightUp_, lit = std::vector(light.lamps.begin(), light.lamps.end()),
       between = std::vector(light.between.begin(), light.between.end())](
          const FdsField& smoke, const MediaLight&) { return lightUp(smoke, {lit, between}); };
  return std::make_shared<const FdsSnapshot>(smoke_, factor_, fire_, sheets_, shares_, lightUp);
}

std::shared_ptr<MediumPicture> FdsSnapshot::picture(std::shared_ptr<MediumPicture>) const {
  return shares_ ? std::make_shared<FdsSharesPicture>(*this, smoke(), *shares_) : nullptr;
}

const MediumKind& fdsKind() {
  static const FdsKind kind;
  return kind;
}

}  // namespace volute
