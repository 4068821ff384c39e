// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// A new kind of medium: a growing ball of uniform smoke. One call of registerMedium() makes it
// available in scenes, pictures, light and sight lines like Volute's own kinds.

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/media/field_members.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_renderer.hpp"

namespace {

using namespace volute;

/// The medium for rays: 01_integrate_a_segment.cpp explains it.
struct Ball {
  double radius = 1, sigma = 1;  // [m], [1/m]

  Box3 bounds() const { return {Vec3::Constant(-radius), Vec3::Constant(radius)}; }

  double extinction(const Vec3& point) const { return point.norm() <= radius ? sigma : 0; }

  Rgb emission(const Vec3&) const { return Rgb::Zero(); }

  Interval chord(const Segment& s) const {
    const double middle = -s.origin.dot(s.direction);
    const double half2 = radius * radius - s.at(middle).squaredNorm();
    if (half2 <= 0)
      return {};
    return Interval{middle - std::sqrt(half2), middle + std::sqrt(half2)}.intersect(
        {s.begin, s.end});
  }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    for (std::size_t i = 0; i < segments.size(); ++i)
      depths[i] = sigma * chord(segments[i]).length();
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      pieces[i].clear();
      if (const Interval c = chord(segments[i]); !c.empty())
        pieces[i].push_back({c.begin, c.end, {{sigma}}, {}, 0});
    }
  }
};

/// The ball at one time.
class BallSnapshot final : public MediumSnapshot {
 public:
  explicit BallSnapshot(const Ball& ball) : ball_(ball) {}

  void addMedia(std::vector<AnyMedium>& media) const override { media.emplace_back(ball_); }

 private:
  Ball ball_;
};

/// The ball in time: its radius grows for two seconds.
class BallInTime final : public SceneMedium {
 public:
  BallInTime(const Ball& ball, double growth, const std::string& file)
      : ball_(ball), growth_(growth) {
    info_.file = file;
    info_.what = "a ball of smoke";
    info_.kind = "ball";
    info_.times = {0, 2};
    info_.numbers = {0, 2};
    info_.interpolates = true;
    info_.bounds = info_.fileBounds = ballAt(2).bounds();
  }

  Result<std::shared_ptr<const MediumSnapshot>> at(const SnapshotRequest& request,
                                                   Progress&) override {
    Ball ball = ballAt(request.time);
    ball.sigma *= request.factor;  // of the visibility law of the scene
    return std::make_shared<const BallSnapshot>(ball);
  }

 private:
  Ball ballAt(double time) const { return {ball_.radius + growth_ * time, ball_.sigma}; }

  Ball ball_;
  double growth_;
};

struct BallSaid {
  Ball ball;
  double growth = 0;
};

/// Its syntax in a scene: {"kind": "ball", "radius", "extinction", "growth"}. The reader, sliders
/// and error messages use this table.
class BallKind final : public MediumKind {
 public:
  const FieldTable& fields() const override {
    // clang-format off: a row is read as one
    static const FieldRow kFields[] = {
        {.name = "radius", .access = member<&BallSaid::ball, &Ball::radius>(), .help = "at 0 s",
         .unit = "m", .least = 1e-3, .slider = {.label = "radius", .least = 0.1, .most = 10}},
        {.name = "extinction", .access = member<&BallSaid::ball, &Ball::sigma>(),
         .help = "everywhere in it", .unit = "1/m", .least = 0,
         .slider = {.label = "extinction", .most = 10, .logarithmic = true}},
        {.name = "growth", .access = member<&BallSaid::growth>(), .help = "of its radius",
         .unit = "m/s", .least = 0}};
    // clang-format on
    static const FieldTable kTable = fieldTable<BallSaid>({.name = "ball",
                                                           .sentence = "an even ball of smoke",
                                                           .fields = kFields,
                                                           .kind = "ball",
                                                           .thing = "a ball of smoke",
                                                           .things = "balls of smoke"});
    return kTable;
  }

  Result<std::shared_ptr<SceneMedium>> open(const nlohmann::json& entry,
                                            MediumContext& context) const override {
    VOLUTE_ASSIGN(const auto said, readAs<BallSaid>(fields(), entry, {context.file, context.path}));
    return std::make_shared<BallInTime>(said.ball, said.growth, context.file);
  }
};

Status lookThroughTheBall() {
  static const BallKind kind;
  registerMedium(kind);

  const auto json = nlohmann::ordered_json::parse(R"({
    "format": "volute-scene-1",
    "camera": {"eye": [0, -10, 0], "target": [0, 0, 0], "fov": 30},
    "background": [1, 1, 1],
    "media": [{"kind": "ball", "radius": 1, "extinction": 0.5, "growth": 0.25}]
  })");
  Progress quiet;
  VOLUTE_ASSIGN(auto scene, Scene::make(json, "ball.json", {}, quiet));
  CpuRenderer renderer;
  for (const double time : {0.0, 1.0, 2.0}) {
    VOLUTE_ASSIGN(const auto snapshot, scene.at({.time = time}, quiet));
    VOLUTE_ASSIGN(const auto image, renderer.render(snapshot, makeCamera(*scene.camera(), {33, 33}),
                                                    {.background = snapshot.background}, quiet));
    const double seen = image.at(16, 16), truth = std::exp(-2 * (1 + 0.25 * time) * 0.5);
    fmt::print("{} s: {:.4f} of the light comes through the middle\n", time, seen);
    if (std::abs(seen - truth) > 1e-4)
      return fail(ErrorCode::kInvalidData, "it should be {}", truth);
  }
  return {};
}

}  // namespace

int main() {
  if (const auto done = lookThroughTheBall(); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
}
