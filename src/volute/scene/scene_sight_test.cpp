// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_sight.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "volute/base/file_name.hpp"
#include "volute/base/program.hpp"
#include "volute/base/remark_log.hpp"
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

/// Even smoke in a box of one metre at a place along x, of which nothing is known beyond it.
class Slab final : public SightField {
 public:
  Slab(double x, std::vector<double> times)
      : bounds_{{x, 0, 0}, {x + 1, 1, 1}}, times_(std::move(times)) {}

  std::string description() const override { return "slab"; }

  std::span<const double> times() const override { return times_; }

  std::vector<Remark> remarksOn(double largest) const override {
    return {Remark(fmt::format("up to {}", largest))};
  }

  std::optional<double> largestRead() const override { return bounds_.min.x(); }

 protected:
  Box3 ownBounds() const override { return bounds_; }

  Result<std::shared_ptr<const SightSnapshot>> readOwn(std::size_t time) override {
    return readOwnAt(times_[time]);
  }

  Result<std::shared_ptr<const SightSnapshot>> readOwnAt(double time) override {
    return std::make_shared<const Snapshot>(bounds_, 0.1 * time);
  }

 private:
  class Snapshot final : public BasicSightSnapshot {
   public:
    Snapshot(const Box3& bounds, double extinction) : bounds_(bounds), extinction_(extinction) {}

    void look(std::span<const SightLine> lines, std::span<Sight> sights) const override {
      for (std::size_t i = 0; i < lines.size(); ++i) {
        const double length = lines[i].length();
        const Interval in =
            bounds_.intersect(lines[i].eye, (lines[i].target - lines[i].eye) / length)
                .intersect({0, length});
        const double depth = extinction_ * in.length();
        sights[i] = {depth, 0.9 * depth, 1.1 * depth, in.length() > length - 1e-9, false};
      }
    }

    void places(std::span<const Vec3> points, std::span<Place> places) const override {
      for (std::size_t i = 0; i < points.size(); ++i)
        places[i] = bounds_.contains(points[i]) ? Place::kGas : Place::kOutside;
    }

    void extinction(std::span<const Vec3> points, std::span<double> out) const override {
      for (std::size_t i = 0; i < points.size(); ++i) {
        out[i] =
            bounds_.contains(points[i]) ? extinction_ : std::numeric_limits<double>::quiet_NaN();
      }
    }

   private:
    Box3 bounds_;
    double extinction_;
  };

  Box3 bounds_;
  std::vector<double> times_;
};

class SlabMedium final : public SceneMedium {
 public:
  SlabMedium(double x, std::vector<double> times, bool moves) : x_(x), times_(std::move(times)) {
    info_.bounds = {{x, 0, 0}, {x + 1, 1, 1}};
    info_.moves = moves;
  }

  Result<std::shared_ptr<const MediumSnapshot>> at(const SnapshotRequest&, Progress&) override {
    return fail(ErrorCode::kUnsupported, "only pictures need this");
  }

  Result<std::unique_ptr<SightField>> sight(Reading&) override {
    return std::make_unique<Slab>(x_, times_);
  }

 private:
  double x_;
  std::vector<double> times_;
};

class SlabKind final : public MediumKind {
 public:
  const FieldTable& fields() const override {
    static const FieldTable kTable{.name = "slab"};
    return kTable;
  }

  Result<std::shared_ptr<SceneMedium>> open(const nlohmann::json& entry,
                                            MediumContext&) const override {
    return std::make_shared<SlabMedium>(entry.at("x"), entry.at("times"),
                                        entry.value("moves", false));
  }
};

class SightOfSeveral : public ::testing::Test {
 protected:
  SightOfSeveral() {
    static const SlabKind kind;
    registerUsualMedia();
    mediumKinds().insert(mediumKinds().begin(), &kind);
  }

  ~SightOfSeveral() override { mediumKinds().erase(mediumKinds().begin()); }

  Result<std::unique_ptr<SightField>> open(const std::string& members) {
    std::ofstream(folder_ / "s.json") << R"({"format": "volute-scene-2", )" << members << "}";
    return openSight((folder_ / "s.json").string(), {}, log_);
  }

  static Sight look(SightField& field, std::size_t time, const Vec3& eye, const Vec3& target) {
    const SightLine line{eye, target};
    Sight sight;
    field.read(time).value()->look({&line, 1}, {&sight, 1});
    return sight;
  }

  ScratchFolder folder_;
  Progress quiet_;
  RemarkLog log_{quiet_};
};

TEST_F(SightOfSeveral, IsTheSumWhereEachEndsWhereAnotherBegins) {
  const auto opened = open(R"("media": [{"kind": "slab", "x": 0, "times": [0, 10, 20]},
                                        {"kind": "slab", "x": 1, "times": [0, 5, 10, 15, 100]}])");
  ASSERT_TRUE(opened) << opened.error().message;
  SightField& field = **opened;
  EXPECT_THAT(field.times(), ElementsAre(0, 10)) << "what is stored of both";
  EXPECT_EQ(field.end(), 100) << "and nothing is known after 10 s";
  EXPECT_THAT(field.remarks(),
              ElementsAre(::testing::Field(&Remark::sentence,
                                           HasSubstr("store, which are 2; one of them stores 5"))));
  const Sight through = look(field, 1, {0.5, 0.5, 0.5}, {1.5, 0.5, 0.5});
  EXPECT_TRUE(through.covered);
  EXPECT_NEAR(through.depth, 1, 1e-9);
  EXPECT_NEAR(through.low, 0.9, 1e-9);
  EXPECT_NEAR(through.high, 1.1, 1e-9);
  EXPECT_FALSE(look(field, 1, {0.5, 0.5, 0.5}, {2.5, 0.5, 0.5}).covered);
  EXPECT_FALSE(look(field, 1, {-5, 0.5, 0.5}, {-4, 0.5, 0.5}).covered);
  const Vec3 points[] = {{0.5, 0.5, 0.5}, {1.5, 0.5, 0.5}, {2.5, 0.5, 0.5}};
  double extinction[3];
  field.read(1).value()->extinction(points, extinction);
  EXPECT_NEAR(extinction[0], 1, 1e-9);
  EXPECT_NEAR(extinction[1], 1, 1e-9);
  EXPECT_TRUE(std::isnan(extinction[2]));
  EXPECT_THAT(field.remarksOn(1), ElementsAre(::testing::Field(&Remark::sentence, "up to 0"),
                                              ::testing::Field(&Remark::sentence, "up to 1")));
}

TEST_F(SightOfSeveral, NeedsTimesInCommon) {
  const auto opened = open(R"("media": [{"kind": "slab", "x": 0, "times": [0, 10]},
                                        {"kind": "slab", "x": 1, "times": [3, 7]}])");
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, HasSubstr("no time is stored by all of its media"));
}

TEST_F(SightOfSeveral, SeesWhatTheWindMovesAtEachTime) {
  const auto opened = open(R"("media": [{"kind": "slab", "x": 0, "times": [0, 10, 20]},
                                        {"kind": "slab", "x": 1, "times": [0], "moves": true}])");
  ASSERT_TRUE(opened) << opened.error().message;
  for (std::size_t time : {0, 1, 2}) {
    EXPECT_NEAR(look(**opened, time, {0, 0.5, 0.5}, {2, 0.5, 0.5}).depth,
                2.0 * static_cast<double>(time), 1e-9);
  }
  const auto alone = open(R"("media": [{"kind": "slab", "x": 1, "times": [0], "moves": true}])");
  ASSERT_TRUE(alone) << alone.error().message;
  EXPECT_THAT(log_.remarks(),
              ElementsAre(::testing::Field(&Remark::sentence,
                                           HasSubstr("see the media as they are at 0 s"))));
}

TEST_F(SightOfSeveral, IsNotClipped) {
  const auto opened = open(R"("media": [{"kind": "slab", "x": 0, "times": [10]},
                                        {"kind": "slab", "x": 0, "times": [10]}],
      "clip": [{"kind": "box", "min": [50, 50, 50], "max": [60, 60, 60]}])");
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_NEAR(look(**opened, 0, {0.2, 0.5, 0.5}, {0.7, 0.5, 0.5}).depth, 1, 1e-9);
  EXPECT_THAT(log_.remarks(), ElementsAre(::testing::Field(&Remark::sentence,
                                                           HasSubstr("its clip is for pictures"))));
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
