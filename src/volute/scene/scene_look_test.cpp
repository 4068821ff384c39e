// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_look.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <nlohmann/json.hpp>

namespace volute {
namespace {

RC_GTEST_PROP(SceneLook, IsReadAsItIsWritten, ()) {
  SceneLook look;
  look.stops = 0.5 * *rc::gen::inRange(-40, 41);
  if (*rc::gen::arbitrary<bool>())
    look.exposure = *rc::gen::inRange(1, 1000) / 7.0;
  look.colors = *rc::gen::inRange(0, 3);
  look.quality = *rc::gen::inRange(0, 4);
  look.renderer = *rc::gen::inRange(0, 3);
  look.surfaces = *rc::gen::arbitrary<bool>();
  look.walks = *rc::gen::arbitrary<bool>();
  look.speed = 0.1 * *rc::gen::inRange(1, 50);
  if (*rc::gen::arbitrary<bool>())
    look.time = *rc::gen::inRange(0, 1000) / 7.0;
  if (*rc::gen::arbitrary<bool>()) {
    const double begin = *rc::gen::inRange(0, 1000) / 7.0;
    look.loop = {begin, begin + *rc::gen::inRange(1, 1000) / 7.0};
  }
  const auto json = nlohmann::json::parse(toJson(look).dump());
  const auto read = readAs<SceneLook>(lookFields(), json, {"scene.json", "/view"});
  RC_ASSERT(read.has_value());
  RC_ASSERT(*read == look);
}

TEST(SceneLook, ErrorsSayWhere) {
  const auto error = [](const char* text) {
    return readAs<SceneLook>(lookFields(), nlohmann::json::parse(text), {"scene.json", "/view"})
        .error()
        .message;
  };
  EXPECT_THAT(error(R"({"colors": "red"})"),
              testing::AllOf(testing::HasSubstr("scene.json: /view/colors"),
                             testing::HasSubstr("grey, viridis, inferno")));
  EXPECT_THAT(error(R"({"sped": 1})"), testing::HasSubstr("did you mean 'speed'?"));
  EXPECT_THAT(error(R"({"speed": 0})"), testing::HasSubstr("/view/speed"));
  EXPECT_THAT(error(R"({"loop": [2, 1]})"),
              testing::AllOf(testing::HasSubstr("/view/loop"), testing::HasSubstr("earlier")));
}

}  // namespace
}  // namespace volute
