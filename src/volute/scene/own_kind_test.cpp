// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/own_kind.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "volute/media/medium_kind.hpp"
#include "volute/medium.h"
#include "volute/medium/conformance.hpp"
#include "volute/scene/kinds.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_renderer.hpp"
#include "volute/scene/scene_sight.hpp"

extern "C" const volute_medium_kind* volute_medium(void);  // examples/plugin/ball.c

namespace volute {
namespace {

using testing::HasSubstr;
using Json = nlohmann::ordered_json;

Result<Scene> sceneWith(const Json& entry, Json more = Json::object()) {
  Progress quiet;
  Json json{{"format", "volute-scene-2"}, {"media", Json::array({entry})}};
  json.update(more);
  return Scene::make(json, "own.json", {}, quiet);
}

AnyMedium mediumOf(const Json& entry, double time) {
  registerUsualMedia();
  EXPECT_TRUE(registerOwnKind(*volute_medium()));
  Progress quiet;
  auto scene = sceneWith(entry);
  EXPECT_TRUE(scene) << scene.error().message;
  const auto snapshot = scene->at({.time = time}, quiet);
  std::vector<AnyMedium> media;
  snapshot->media.front()->addMedia(media);
  return media.front();
}

VOLUTE_CONFORMANCE(PluginBall, conformance::underTest(mediumOf(
                                   {{"kind", "ball"}, {"radius", 1.5}, {"growth", 0.25}}, 1)));

/// A kind that does as it is told.
struct Told {
  std::vector<volute_piece> pieces{};
  const char* why = nullptr;
  std::vector<double> times{0};
  std::vector<double> bounds{-1, -1, -1, 1, 1, 1};
  double depth = 0;
} told;

volute_medium_kind toldKind(const char* name) {
  volute_medium_kind kind{};
  kind.size = sizeof kind;
  kind.name = name;
  kind.sentence = "a medium";
  kind.open = [](void*, const double*, const char*, void** medium) -> const char* {
    *medium = &told;
    return nullptr;
  };
  kind.bounds = [](void*, double* bounds) -> const char* {
    std::ranges::copy(told.bounds, bounds);
    return nullptr;
  };
  kind.times = [](void*, double* times, std::size_t room) {
    std::copy_n(told.times.data(), std::min(room, told.times.size()), times);
    return told.times.size();
  };
  kind.pieces = [](void*, double, const volute_segment*, std::size_t, volute_pieces_function give,
                   void* to) -> const char* {
    give(to, told.pieces.data(), told.pieces.size());
    return told.why;
  };
  return kind;
}

AnyMedium toldMedium() {
  registerUsualMedia();
  EXPECT_TRUE(registerOwnKind(toldKind("told")));
  Progress quiet;
  auto scene = sceneWith({{"kind", "told"}});
  EXPECT_TRUE(scene) << scene.error().message;
  std::vector<AnyMedium> media;
  scene->at({.time = 0}, quiet)->media.front()->addMedia(media);
  return media.front();
}

std::string faultOf(volute_piece piece, double begin = -2, double end = 2) {
  told.pieces = {piece};
  const AnyMedium medium = toldMedium();
  const Segment segment{Vec3::Zero(), Vec3::UnitX(), begin, end};
  double depth = 0;
  try {
    medium.opticalDepth({&segment, 1}, {&depth, 1});
  } catch (const OwnMediumFault& fault) {
    return fault.what();
  }
  return fmt::format("{}", depth);
}

TEST(OwnKind, PiecesThatMakeNoSenseAreFaults) {
  told = {};
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(faultOf({0, -1, 1, {0.5}, {}, 0}), "1");
  EXPECT_THAT(faultOf({1, -1, 1, {0.5}, {}, 0}), HasSubstr("is of segment 1; expected 0 to 0"));
  EXPECT_THAT(faultOf({0, -1, 1, {std::nan("")}, {}, 0}), HasSubstr("not finite"));
  EXPECT_THAT(faultOf({0, -infinite, 1, {0.5}, {}, 0}), HasSubstr("not finite"));
  EXPECT_THAT(faultOf({0, 1, -1, {0.5}, {}, 0}), HasSubstr("is empty"));
  EXPECT_THAT(faultOf({0, -3, 1, {0.5}, {}, 0}), HasSubstr("outside its segment's -2 to 2 m"));
  EXPECT_THAT(faultOf({0, -1, infinite, {0, 1}, {}, 0}, -2, infinite), HasSubstr("has no decay"));
  EXPECT_EQ(faultOf({0, -1, infinite, {0.5}, {}, 2}, -2, infinite), "0.25");
  EXPECT_THAT(faultOf({0, -1, 1, {-2}, {}, 0}), HasSubstr("extinction of -2/m; expected at least"));
  EXPECT_THAT(faultOf({0, -1, 1, {1, 0, -1}, {}, 0}), HasSubstr("an extinction of -3/m"));
  EXPECT_THAT(faultOf({0, -1, infinite, {-1}, {}, 2}, -2, infinite), HasSubstr("of -1/m"));
  EXPECT_THAT(faultOf({0, -1, 1, {2, -1.0001}, {}, 0}), HasSubstr("1.99"));  // a fit's overshoot
  told.why = "no pieces today";
  EXPECT_THAT(faultOf({0, -1, 1, {0.5}, {}, 0}), HasSubstr("kind 'told': no pieces today"));
}

TEST(OwnKind, PiecesAtNullAreAFault) {
  told = {};
  volute_medium_kind kind = toldKind("none");
  kind.pieces = [](void*, double, const volute_segment*, std::size_t, volute_pieces_function give,
                   void* to) -> const char* {
    give(to, nullptr, 3);
    return nullptr;
  };
  EXPECT_TRUE(registerOwnKind(kind));
  Progress quiet;
  auto scene = sceneWith({{"kind", "none"}});
  ASSERT_TRUE(scene);
  std::vector<AnyMedium> media;
  scene->at({.time = 0}, quiet)->media.front()->addMedia(media);
  const Segment segment{Vec3::Zero(), Vec3::UnitX(), 0, 1};
  double depth = 0;
  EXPECT_THROW(media.front().opticalDepth({&segment, 1}, {&depth, 1}), OwnMediumFault);
}

TEST(OwnKind, WhatItCannotSayEndsAPicture) {
  told = {};
  told.why = "no pieces today";
  told.pieces = {};
  toldMedium();
  Progress quiet;
  auto scene = sceneWith({{"kind", "told"}});
  ASSERT_TRUE(scene);
  const auto snapshot = scene->at({.time = 0}, quiet);
  CpuRenderer renderer;
  EXPECT_THROW(
      (void)renderer.render(*snapshot, Camera::framing(scene->bounds(), 16, 16), {}, quiet),
      OwnMediumFault);
  told = {};
}

TEST(OwnKind, WrongBoundsAndTimesAreErrors) {
  toldMedium();
  told.bounds = {0, 0, 0, 1, 1, 0};
  EXPECT_THAT(sceneWith({{"kind", "told"}}).error().message, HasSubstr("expected a box"));
  told = {};
  told.times = {0, 0};
  EXPECT_THAT(sceneWith({{"kind", "told"}}).error().message, HasSubstr("expected ascending times"));
  told.times = {};
  EXPECT_THAT(sceneWith({{"kind", "told"}}).error().message, HasSubstr("says 0 times"));
  told = {};
}

TEST(OwnKind, MembersAreCheckedAsThoseOfOtherKinds) {
  mediumOf({{"kind", "ball"}}, 0);
  EXPECT_THAT(sceneWith({{"kind", "ball"}, {"radius", -1}}).error().message,
              HasSubstr("/media/0/radius"));
  EXPECT_THAT(sceneWith({{"kind", "ball"}, {"radii", 1}}).error().message, HasSubstr("radii"));
  EXPECT_THAT(sceneWith({{"kind", "bell"}}).error().message, HasSubstr("ball"));
}

TEST(OwnKind, IncompleteKindsAreRefused) {
  registerUsualMedia();
  const auto refused = [](const volute_medium_kind& kind) {
    const Status done = registerOwnKind(kind);
    return done ? std::string() : done.error().message;
  };
  EXPECT_THAT(refused(toldKind("volume")), HasSubstr("Volute has a kind 'volume' itself"));
  EXPECT_THAT(refused(toldKind("Two Words")), HasSubstr("lower case"));
  volute_medium_kind kind = toldKind("told");
  kind.pieces = nullptr;
  EXPECT_THAT(refused(kind), HasSubstr("must not be NULL"));
  kind = toldKind("told");
  kind.size = 8;
  EXPECT_THAT(refused(kind), HasSubstr("size is 8"));
  kind = toldKind("told");
  const volute_medium_member twice[] = {{"a", "", "", 1, nullptr, 0, 0},
                                        {"a", "", "", 1, nullptr, 0, 0}};
  kind.members = twice, kind.member_count = 2;
  EXPECT_THAT(refused(kind), HasSubstr("'a' of member 1"));
  const volute_medium_member outside[] = {{"a", "", "", 1, nullptr, 1, 2}};
  kind.members = outside, kind.member_count = 1;
  EXPECT_THAT(refused(kind), HasSubstr("the default 0 of 'a'; expected 1 to 2"));
}

TEST(OwnKind, SightLinesGoThroughIt) {
  registerUsualMedia();
  ASSERT_TRUE(registerOwnKind(*volute_medium()));
  auto scene = sceneWith({{"kind", "ball"}, {"radius", 2}, {"extinction", 0.5}});
  ASSERT_TRUE(scene);
  Progress quiet;
  const auto field = sightOf(std::move(*scene), {}, quiet);
  ASSERT_TRUE(field) << field.error().message;
  EXPECT_EQ((*field)->times().size(), 2U);
  const auto snapshot = (*field)->read(0);
  const SightLine line{Vec3(-5, 0, 0), Vec3(5, 0, 0)};
  Sight sight;
  (*snapshot)->look({&line, 1}, {&sight, 1});
  EXPECT_NEAR(sight.depth, 2, 1e-12);
}

}  // namespace
}  // namespace volute
