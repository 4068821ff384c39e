// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_part.hpp"

#include <nlohmann/json.hpp>

#include "volute/gl/gl_part_table.hpp"
#include "volute/gl/gl_testing.hpp"
#include "volute/render/scaled_medium.hpp"

// A kind of medium that the renderer does not know: all that it needs is in this file.

namespace volute {

using namespace gltest;

namespace {

/// An even ball.
struct Ball {
  Vec3 centre = Vec3::Zero();
  double radius = 1;
  double density = 1;  ///< extinction [1/m]
  Rgb glow = Rgb::Ones();
  int stretches = 1;  ///< in which a ray goes through it on a device

  Interval inside(const Segment& segment) const {
    const Vec3 from = segment.origin - centre;
    const double b = from.dot(segment.direction);
    const double q = b * b - from.squaredNorm() + radius * radius;
    return q > 0 ? Interval{-b - std::sqrt(q), -b + std::sqrt(q)}.intersect(
                       {segment.begin, segment.end})
                 : Interval{};
  }

  Box3 bounds() const { return {centre - Vec3::Constant(radius), centre + Vec3::Constant(radius)}; }

  double extinction(const Vec3& point) const {
    return (point - centre).norm() < radius ? density : 0;
  }

  Rgb emission(const Vec3& point) const { return glow * (extinction(point) > 0 ? 1.0 : 0.0); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    for (std::size_t i = 0; i < segments.size(); ++i)
      depths[i] = density * inside(segments[i]).length();
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      pieces[i].clear();
      const Interval interval = inside(segments[i]);
      if (interval.empty())
        continue;
      Piece piece{interval.begin, interval.end, {}, {}, 0};
      piece.extinction.c[0] = density;
      for (int c = 0; c < 3; ++c) piece.emission[c].c[0] = glow[c];
      pieces[i].push_back(piece);
    }
  }
};

constexpr const char* kBallShader = R"(
uniform vec3 M_centre;
uniform float M_radius;
uniform float M_density;
uniform vec3 M_glow;
uniform int M_stretches;

float M_end;
bool M_on = false;
float M_enter, M_exit;
int M_left;

void M_begin() {
  M_end = FARTHEST;
  vec3 from = rayOrigin - M_centre;
  float b = dot(from, rayDirection);
  float q = b * b - dot(from, from) + M_radius * M_radius;
  if (q <= 0.0) return;
  M_enter = max(-b - sqrt(q), rayBegin);
  M_exit = min(-b + sqrt(q), rayEnd);
  M_left = M_stretches;
  if (M_enter < M_exit) M_end = M_enter;
}

void M_next() {
  M_on = M_left > 0;
  --M_left;
  M_end = M_on ? mix(M_exit, M_enter, float(M_left) / float(M_stretches)) : FARTHEST;
}

void M_sample(float s, inout float k, inout vec3 e) {
  if (!M_on) return;
  k += M_density;
  e += M_glow;
}
)";

class BallOnDevice final : public GlMedium {
 public:
  explicit BallOnDevice(const Ball& ball) : ball_(ball) {}

  std::string key() const override { return "ball"; }

  std::vector<ShaderPart> parts() const override { return {{"ball.glsl", kBallShader}}; }

  GlMediumTraits traits() const override { return {.constant = true, .points = 1}; }

  GlNeeds needs() const override { return {.cells = 1, .roundsPerCell = 2}; }

  Box3 bounds() const override { return ball_.bounds(); }

  void bind(const GlProgram& program, const std::string& prefix, const GlView& view,
            GlBindings&) const override {
    program.set((prefix + "centre").c_str(), Vec3(ball_.centre - view.origin));
    program.set((prefix + "radius").c_str(), static_cast<float>(ball_.radius));
    program.set((prefix + "density").c_str(), static_cast<float>(ball_.density));
    program.set((prefix + "glow").c_str(), Vec3(ball_.glow));
    program.set((prefix + "stretches").c_str(), ball_.stretches);
  }

 private:
  Ball ball_;
};

class BallPart final : public GlPart {
 public:
  explicit BallPart(const Ball& ball) : ball_(ball) {}

  std::string name() const override { return "ball"; }

  Result<std::unique_ptr<GlMedium>> medium(const GlPicture&) const override {
    return std::make_unique<BallOnDevice>(ball_);
  }

  std::shared_ptr<const GlPart> scaled(double factor) const override {
    Ball ball = ball_;
    ball.density *= factor;
    ball.glow *= factor;
    return std::make_shared<BallPart>(ball);
  }

 private:
  Ball ball_;
};

constexpr double kOwnDepth = 0.75;

/// Draws the same depth everywhere by a way of its own, and cannot be marched.
class Sheet final : public GlPart {
 public:
  std::string name() const override { return "sheet"; }

  Result<std::unique_ptr<GlMedium>> medium(const GlPicture&) const override {
    return fail(ErrorCode::kTooLarge, "a sheet is not marched");
  }

  Status drawAlone(const GlPicture& picture, const GlTarget& target) const override {
    const float texel[4] = {0, 0, 0, static_cast<float>(kOwnDepth)};
    glClearTexImage(target.picture, 0, GL_RGBA, GL_FLOAT, texel);
    picture.resources.counts["sheets"] = {{"pictures", ++pictures_}};
    return {};
  }

  std::shared_ptr<const GlPart> scaled(double) const override { return std::make_shared<Sheet>(); }

 private:
  mutable std::int64_t pictures_ = 0;
};

class GlPartTest : public GlRendererTest {};

TEST_F(GlPartTest, AnUnknownMediumIsDrawnAloneAndAmongOthers) {
  const Ball ball{Vec3(0.2, 3, 1.6), 0.7, 1.3, Rgb(0.4, 0.8, 1.6)};
  const auto fire = sliceOf(3, Basis::kTrilinear);
  const auto part = std::make_shared<const BallPart>(ball);
  const std::vector<AnyMedium> media{AnyMedium(ball), AnyMedium(VoxelMedium(fire, 2, 3))};
  std::vector<float> wall(static_cast<std::size_t>(kWidth) * kHeight, INFINITY);
  for (std::size_t i = 0; i < wall.size(); i += 3) wall[i] = 4.4F;
  const RenderOptions options{.background = Rgb(0.1, 0.2, 0.5)};
  const AnyMedium thin(ScaledMedium(AnyMedium(ball), 0.3));
  for (const Vec3& eye : {Vec3(-0.7, -1.4, 2.1), Vec3(0.3, 3.1, 1.5)}) {
    const Camera camera = Camera::pinhole({eye, Vec3(0.2, 3.2, 1.4)}, 50, kWidth, kHeight);
    EXPECT_LE(errorOf(camera, {{part}}, {media.data(), 1}, options, wall), kBar);
    EXPECT_LE(errorOf(camera, {{part->scaled(0.3)}}, {&thin, 1}, options, wall), kBar);
    const GlScene both{{part, glPart(GlVolume{fire, 2, 3})}};
    (void)renderer_->takePasses();
    EXPECT_LE(errorOf(camera, both, media, options, wall), kBar);
    EXPECT_LE(errorOf(camera, both, media, {.aov = Aov::kOpticalDepth}, wall), kBar);
    EXPECT_TRUE(std::ranges::any_of(renderer_->takePasses(), [](const GlPassTime& pass) {
      return pass.name == "march" && pass.media == "ball + volume";
    }));
  }
}

/// Where a medium says too little of what it needs, too: software rasterisers end loops.
TEST_F(GlPartTest, RaysThatADeviceEndsEarlyAreNoPicture) {
  const Camera camera = Camera::framing({Vec3(-1, -1, -1), Vec3(1, 1, 1)}, 8, 8);
  const auto drawn = [&](int stretches) {
    const Ball ball{.density = 0.1, .stretches = stretches};
    return renderer_->render(camera, {{std::make_shared<const BallPart>(ball)}}, {}, quiet_);
  };
  EXPECT_TRUE(drawn(100));
  const auto many = drawn(200000);
  ASSERT_FALSE(many && !gl_->device().hardware);
  const std::string said = many ? "" : many.error().message;
  EXPECT_TRUE(many || said.find("ends rays before") != std::string::npos) << said;
}

TEST_F(GlPartTest, AWayOfItsOwnIsTakenByWhatIsAlone) {
  const auto sheet = std::make_shared<const Sheet>();
  const auto ball = std::make_shared<const BallPart>(Ball{});
  const Camera camera = Camera::framing({Vec3(0, 0, 0), Vec3(1, 1, 1)}, 8, 8);
  const RenderOptions depths{.aov = Aov::kOpticalDepth};
  const auto alone = renderer_->render(camera, {{sheet}}, depths, quiet_);
  ASSERT_TRUE(alone) << alone.error().message;
  for (const float depth : alone->pixels) EXPECT_EQ(depth, static_cast<float>(kOwnDepth));
  EXPECT_EQ(renderer_->counts().at("sheets"), (GlCounts{{"pictures", 1}}));
  const auto among = renderer_->render(camera, {{sheet, ball}}, depths, quiet_);
  ASSERT_FALSE(among);
  EXPECT_EQ(among.error().message, "a sheet is not marched");
}

TEST(GlStore, WhatWasMadeIsKnownByItsSourceAndType) {
  GlStore store;
  const auto source = std::make_shared<const int>(1), other = std::make_shared<const int>(1);
  int made = 0;
  const auto number = [&](const auto& of, int value = 0) {
    return **store.get<int>(
        of, [&] { return Result<int>(100 * value + ++made); },
        [&](int kept) { return kept / 100 == value; });
  };
  const auto word = [&](const auto& of) {
    return **store.get<std::string>(of,
                                    [&] { return Result<std::string>(std::to_string(++made)); });
  };
  EXPECT_EQ(number(source), 1);
  EXPECT_EQ(number(other), 2);
  EXPECT_EQ(word(source), "3");
  EXPECT_EQ(number(source), 1);
  EXPECT_EQ(number(source, 1), 104) << "the source has changed";
  store.sweep();
  EXPECT_EQ(number(source, 1), 104);
  store.sweep();
  EXPECT_EQ(word(source), "3") << "it stays while anything of its source is asked for";
  EXPECT_EQ(number(other), 5) << "no one asked for it between two sweeps";
}

TEST(GlStore, WhatFailsIsNotKept) {
  GlStore store;
  const auto source = std::make_shared<const int>(1);
  const auto failing = [] { return Result<int>(fail(ErrorCode::kTooLarge, "no")); };
  EXPECT_EQ(store.get<int>(source, failing).error().message, "no");
  EXPECT_EQ(**store.get<int>(source, [] { return Result<int>(7); }), 7);
}

struct BaseSnapshot {
  virtual ~BaseSnapshot() = default;
};

struct BallSnapshot final : BaseSnapshot {
  Ball ball;
};

struct SheetSnapshot final : BaseSnapshot {};

TEST(GlPartTable, FindsPartsByTheTypeOfAMedium) {
  GlPartTable<BaseSnapshot, int> table;
  table.add<BallSnapshot>(
      [](const BallSnapshot& medium, int count) -> Result<decltype(table)::Parts> {
        return decltype(table)::Parts(static_cast<std::size_t>(count),
                                      std::make_shared<BallPart>(medium.ball));
      });
  const auto found = table.partsOf(BallSnapshot(), 2);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), 2U);
  EXPECT_EQ(found->front()->name(), "ball");
  EXPECT_EQ(table.partsOf(SheetSnapshot(), 2).error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace volute
