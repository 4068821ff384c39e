// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_sight.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "volute/base/file_name.hpp"
#include "volute/media/ray_sight.hpp"
#include "volute/scene/kinds.hpp"

namespace volute {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Smoke from z = 1 to 2 m, or to 3 m by its other source.
class Layer final : public SightField {
 public:
  explicit Layer(std::string source) : source_(std::move(source)) {}

  std::string description() const override { return source_; }

  std::string tallerSource() const override { return "tall"; }

  std::span<const double> times() const override { return {}; }

 protected:
  Box3 ownBounds() const override { return {{0, 0, 1}, {1, 1, source_ == "tall" ? 3.0 : 2.0}}; }

  Result<std::shared_ptr<const SightSnapshot>> readOwn(std::size_t) override {
    return sightThrough({});
  }

 private:
  std::string source_;
};

class LayerMedium final : public SceneMedium {
 public:
  explicit LayerMedium(std::string source) : source_(std::move(source)) {}

  Result<std::shared_ptr<const MediumSnapshot>> at(const SnapshotRequest&, Progress&) override {
    return fail(ErrorCode::kUnsupported, "only pictures need this");
  }

  Result<std::unique_ptr<SightField>> sight(Reading&) override {
    return std::make_unique<Layer>(source_);
  }

 private:
  std::string source_;
};

class LayerKind final : public MediumKind {
 public:
  const FieldTable& fields() const override {
    static const FieldTable kTable{.name = "layer"};
    return kTable;
  }

  bool opens(const std::string& path) const override { return extensionOf(path) == ".layer"; }

  nlohmann::ordered_json sceneOf(const std::string& name) const override {
    return {{"media", {{{"file", name}, {"field", "flat"}}}}};
  }

  Result<std::shared_ptr<SceneMedium>> open(const nlohmann::json& entry,
                                            MediumContext& context) const override {
    EXPECT_TRUE(context.options.sightOnly);
    return std::make_shared<LayerMedium>(entry.at("field"));
  }
};

TEST(OpenSight, ALayerGivesWayToATallerSourceWhereLinesLeaveIt) {
  static const LayerKind kind;
  registerUsualMedia();
  mediumKinds().insert(mediumKinds().begin(), &kind);
  Progress quiet;
  std::vector<Remark> remarks;
  SceneOptions options;
  const auto sourceFor = [&](std::vector<double> heights) {
    remarks.clear();
    return openSight("smoke.layer", options, heights, remarks, quiet).value()->description();
  };
  EXPECT_EQ(openSight("smoke.layer", options, quiet).value()->description(), "flat");
  EXPECT_EQ(sourceFor({1, 2}), "flat");
  EXPECT_THAT(remarks, IsEmpty());
  EXPECT_EQ(sourceFor({1.5, 2.5}), "tall");
  EXPECT_THAT(
      remarks,
      ElementsAre(::testing::Field(
          &Remark::sentence,
          HasSubstr("extinction is read from tall alone, because flat leaves out places"))));
  (*options.members)["field"] = "mine";
  EXPECT_EQ(sourceFor({2.5}), "mine");
  EXPECT_THAT(remarks, IsEmpty());
  mediumKinds().erase(mediumKinds().begin());
}

// There is no class that passes on what a field says, and could forget some of it.
TEST(SightField, WrappingChangesBoundsAndSnapshotsAlone) {
  Layer layer("flat");
  const auto other = sightThrough({});
  const Box3 bounds{{-1, -1, -1}, {5, 5, 5}};
  int calls = 0;
  layer.wrap(
      [&](const std::shared_ptr<const SightSnapshot>& own) {
        EXPECT_NE(own, nullptr);
        ++calls;
        return other;
      },
      bounds);
  EXPECT_EQ(layer.bounds().max, bounds.max);
  EXPECT_EQ(layer.read(0).value(), other);
  EXPECT_FALSE(layer.readAt(0.5));  // an error is not wrapped
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(layer.description(), "flat");
  EXPECT_EQ(layer.tallerSource(), "tall");
}

}  // namespace
}  // namespace volute
