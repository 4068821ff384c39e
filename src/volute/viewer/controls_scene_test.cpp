// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Signs and lights that come and go, and painted fog that is not lost: driven by the input layer.
#include <nlohmann/json.hpp>

#include "volute/viewer/controls_testing.hpp"
#include "volute/viewer/pick_wall.hpp"

namespace volute {
namespace {

class SceneControls : public WideControls {
 protected:
  bool hasParameter(const std::string& path) {
    return std::ranges::find(app().document().info()->parameters, path, &Parameter::path) !=
           app().document().info()->parameters.end();
  }

  void press(const std::string& control) {
    ASSERT_TRUE(script_->click(control)) << control;
    load();
    EXPECT_EQ(app().document().error(), "");
  }

  Vec3 pointOf(const std::string& path) {
    const auto value = valueOf(path);
    return value.size() == 3 ? Vec3(value[0], value[1], value[2]) : Vec3::Constant(1e9);
  }
};

TEST_F(SceneControls, SignsComeAndGo) {
  open("smoke.json");
  const Image one = picture();
  expectSeen("add", [&] { press("add sign"); });
  ASSERT_TRUE(hasParameter("/signs/1/position"));
  const Vec3 at = pointOf("/signs/1/position");
  EXPECT_NEAR(at.x(), 6 - 0.02, 1e-6) << "the mesh ends at x = 6";
  EXPECT_LT((pointOf("/signs/1/normal") + Vec3::UnitX()).norm(), 1e-9);
  const auto middle = app().view().camera().camera(kWide, kTall).project(Vec3(6, at.y(), at.z()));
  ASSERT_TRUE(middle);
  EXPECT_LT((*middle - Vec2(0.5 * kWide, 0.5 * kTall)).norm(), 1e-6);
  expectSeen("duplicate", [&] { press("duplicate /signs/1"); });
  ASSERT_TRUE(hasParameter("/signs/2/position"));
  EXPECT_NEAR((pointOf("/signs/2/position") - at).norm(), 0.8, 1e-9);
  saveAs("signs.json");
  expectTheSameAfter("signs.json");
  ASSERT_TRUE(hasParameter("/signs/2/position"));
  press("remove /signs/2");
  press("remove /signs/1");
  EXPECT_FALSE(hasParameter("/signs/1/position"));
  EXPECT_LT(difference(one, picture()), 1e-6);
}

TEST_F(SceneControls, SignsOfTheSameNameHaveTheirOwnControls) {
  open("smoke.json");
  press("add sign");
  const auto names = [&] {
    std::set<std::string> groups;
    for (const Parameter& parameter : app().document().info()->parameters) {
      if (parameter.path.starts_with("/signs/"))
        groups.insert(parameter.group);
    }
    return groups;
  };
  EXPECT_EQ(names(), (std::set<std::string>{"sign: exit", "sign: exit 2"}));
  press("duplicate /signs/1");
  EXPECT_TRUE(names().contains("sign: exit 3"));
}

TEST_F(SceneControls, APointerMeetsASignFromItsFrontOnly) {
  open("smoke.json");
  const ViewScene& scene = *app().view().picture().scene();
  const Vec3 sign(5.9, 3, 1.8);
  const auto behind = pickWall(scene, {sign + 0.05 * Vec3::UnitX(), -Vec3::UnitX(), 0, 1});
  EXPECT_FALSE(behind && behind->position.x() > 5.85);
  const auto before = pickWall(scene, {sign - Vec3::UnitX(), Vec3::UnitX(), 0, 10});
  ASSERT_TRUE(before);
  EXPECT_LT((before->position - sign).norm(), 2e-3);
  EXPECT_LT((before->normal + Vec3::UnitX()).norm(), 1e-9);
  const auto beside = pickWall(scene, {sign - Vec3(1, 0.9, 0), Vec3::UnitX(), 0, 10});
  EXPECT_TRUE(!beside || beside->position.x() > 5.95);
  EXPECT_FALSE(scene.marks.empty()) << "the lamp's";
}

TEST_F(SceneControls, ASignIsPutWhereTheMouseClicks) {
  open("smoke.json");
  const Camera camera = app().view().camera().camera(kWide, kTall);
  const Vec3 onFloor(2, 3, 0);
  const auto pixel = camera.project(onFloor);
  ASSERT_TRUE(pixel);
  ASSERT_TRUE(script_->click("place /signs/0"));
  EXPECT_EQ(app().tools().pointer.placing(), "/signs/0");
  const Vec3 eye = app().view().camera().eye();
  expectSeen("place", [&] {
    script_->clickAt(pixel->x(), pixel->y());
    load();
  });
  EXPECT_EQ(app().tools().pointer.placing(), "");
  EXPECT_LT((pointOf("/signs/0/position") - onFloor - 0.02 * Vec3::UnitZ()).norm(), 1e-6);
  EXPECT_LT((pointOf("/signs/0/normal") - Vec3::UnitZ()).norm(), 1e-9);
  EXPECT_EQ(app().view().camera().eye(), eye) << "the click was not the camera's";
  saveAs("placed.json");
  expectTheSameAfter("placed.json");
  ASSERT_TRUE(script_->click("place /signs/0"));
  script_->press(Key::kEscape);
  EXPECT_EQ(app().tools().pointer.placing(), "");
}

TEST_F(SceneControls, ALampIsPutWhereTheMouseClicks) {
  open("smoke.json");
  const Vec3 onFloor(2, 3, 0), before = pointOf("/lights/1/position");
  const auto pixel = app().view().camera().camera(kWide, kTall).project(onFloor);
  ASSERT_TRUE(pixel);
  ASSERT_TRUE(script_->click("place /lights/1"));
  EXPECT_EQ(app().tools().pointer.placing(), "/lights/1");
  expectSeen("place", [&] {
    script_->clickAt(pixel->x(), pixel->y());
    load();
  });
  EXPECT_EQ(app().tools().pointer.placing(), "");
  const Vec3 at = pointOf("/lights/1/position");
  EXPECT_GT((at - before).norm(), 1);
  EXPECT_LT((at - onFloor).norm(), 0.2);
  EXPECT_GT(at.z(), 0);
  saveAs("lamp.json");
  expectTheSameAfter("lamp.json");
}

TEST_F(SceneControls, WhatHangsInTheAirFacesTheEye) {
  open("blob.npy");  // nothing to be met
  press("add sign");
  const Vec3 eye = app().view().camera().eye(), at = pointOf("/signs/0/position");
  EXPECT_NEAR((at - eye).norm(), app().view().camera().distance() - 0.02, 1e-9);
  EXPECT_LT((pointOf("/signs/0/normal") - (eye - at).normalized()).norm(), 1e-9);
}

TEST_F(SceneControls, LightsComeAndGo) {
  open("smoke.json");
  const Image begun = picture();
  expectSeen("lamp", [&] { press("add lamp"); });
  ASSERT_TRUE(hasParameter("/lights/2/target"));
  EXPECT_NEAR(pointOf("/lights/2/position").x(), 5.9, 1e-6);
  expectSeen("sun", [&] { press("add sun"); });
  ASSERT_TRUE(hasParameter("/lights/3/direction"));
  expectSeen("ambient", [&] { press("add ambient"); });
  ASSERT_TRUE(hasParameter("/lights/4/radiance"));
  expectSeen("duplicate", [&] { press("duplicate /lights/2"); });
  EXPECT_TRUE(hasParameter("/lights/3/target"));
  EXPECT_TRUE(hasParameter("/lights/5/radiance"));
  saveAs("lights.json");
  expectTheSameAfter("lights.json");
  for (const char* light : {"5", "4", "3", "2"}) press(std::string("remove /lights/") + light);
  EXPECT_FALSE(hasParameter("/lights/2/radiance"));
  EXPECT_LT(difference(begun, picture()), 1e-6);
}

TEST_F(SceneControls, ChangesAreTakenBackAndDoneAgain) {
  open("smoke.json");
  const Image begun = picture();
  const auto potential = valueOf("/media/0/smoke_potential");
  press("add sign");
  script_->click("/media/0/smoke_potential", 0.3);
  script_->click("/media/0/smoke_potential", 0.4);
  load();
  const auto moved = valueOf("/media/0/smoke_potential");
  EXPECT_NE(moved, potential);
  press("remove /signs/0");
  const Image changed = picture();
  press("Undo change");
  EXPECT_TRUE(hasParameter("/signs/1/position"));
  script_->press(Key::kZ, true);
  load();
  EXPECT_EQ(valueOf("/media/0/smoke_potential"), potential) << "both clicks were one change";
  script_->press(Key::kZ, true);
  load();
  EXPECT_FALSE(hasParameter("/signs/1/position"));
  EXPECT_FALSE(app().document().info()->canUndo);
  EXPECT_LT(difference(begun, picture()), 1e-6);
  press("Redo change");
  EXPECT_TRUE(hasParameter("/signs/1/position"));
  script_->press(Key::kY, true);
  load();
  EXPECT_EQ(valueOf("/media/0/smoke_potential"), moved);
  script_->press(Key::kY, true);
  load();
  EXPECT_FALSE(app().document().info()->canRedo);
  EXPECT_LT(difference(changed, picture()), 1e-6);
}

/// Of each object: nothing is called alike, and all that has a dimension says its unit.
TEST_F(SceneControls, ParametersHaveNamesAndUnits) {
  const std::set<std::string> plain = {"mu", "visibility C", "asymmetry"};
  for (const char* file : {"fog.json", "dull.json", "smoke.json", "blob.npy", "room.smv"}) {
    open(file);
    std::set<std::string> names;
    for (const Parameter& parameter : app().document().info()->parameters) {
      SCOPED_TRACE(parameter.path);
      EXPECT_TRUE(names.insert(parameter.group + ": " + parameter.name).second);
      if (parameter.kind == Parameter::Kind::kDirection) {
        EXPECT_TRUE(names.insert(parameter.group + ": azimuth").second);
        EXPECT_TRUE(names.insert(parameter.group + ": elevation").second);
      }
      if (parameter.kind == Parameter::Kind::kNumber) {
        EXPECT_EQ(parameter.unit.empty(), plain.contains(parameter.name));
      }
    }
  }
}

TEST(SceneEdits, PathsOfNothingAreErrors) {
  nlohmann::ordered_json json = {{"lights", {{{"kind", "sun"}}}}};
  const auto message = [&](const SceneEdit& edit) {
    const auto done = applyEdit(json, edit);
    return done ? "" : done.error().message;
  };
  for (const char* path : {"/signs/0", "/lights/1", "/lights/", "/lights/x", "/media/0", ""}) {
    EXPECT_NE(message({.kind = SceneEdit::Kind::kRemove, .path = path}), "") << path;
    EXPECT_NE(message({.kind = SceneEdit::Kind::kDuplicate, .path = path}), "") << path;
  }
  EXPECT_THAT(message({.kind = SceneEdit::Kind::kPlace, .path = "/lights/0"}),
              ::testing::HasSubstr("from afar"));
  EXPECT_EQ(json["lights"].size(), 1U);
}

class UnsavedControls : public SceneControls {
 protected:
  /// A stroke, of which no file knows.
  void paint() {
    ASSERT_NO_FATAL_FAILURE(openPaintPanel());
    ASSERT_TRUE(script_->dragFrom("plan", 0.75, 0.7, 20, 0, 12));
    load();
    ASSERT_TRUE(app().tools().painting.unsaved());
  }

  const std::string& title() { return app().document().info()->title; }
};

TEST_F(UnsavedControls, AnotherFileOpensAfterTheQuestion) {
  open("fog.json");
  paint();
  const auto painted = app().tools().painting.tool().painter().coefficients().c;
  script_->drop(folder_.path("smoke.json"));
  load();
  ASSERT_TRUE(app().leaving().asked());
  EXPECT_THAT(title(), ::testing::HasSubstr("fog.json")) << "it waits for the answer";
  script_->press(Key::kZ, true);
  EXPECT_EQ(app().tools().painting.tool().painter().coefficients().c, painted)
      << "so does all else";
  press("leave cancel");
  EXPECT_FALSE(app().leaving().asked());
  EXPECT_THAT(title(), ::testing::HasSubstr("fog.json"));
  EXPECT_EQ(app().tools().painting.tool().painter().coefficients().c, painted);
  script_->drop(folder_.path("smoke.json"));
  script_->frames(2);
  ASSERT_TRUE(
      script_->write("leave map", folder_.path("nowhere/map.png")));  // with Enter: it saves
  load();
  ASSERT_TRUE(app().leaving().asked()) << "it could not be saved";
  EXPECT_THAT(app().document().error(), ::testing::HasSubstr("nowhere"));
  ASSERT_TRUE(script_->write("leave map", folder_.path("kept.exr")));  // with Enter: it saves
  load();
  ASSERT_TRUE(app().leaving().asked()) << "the scene's file names the map before";
  EXPECT_EQ(app().leaving().asked()->what, LeaveQuestion::What::kScene);
  press("leave discard");
  load();
  EXPECT_FALSE(app().leaving().asked());
  EXPECT_THAT(title(), ::testing::HasSubstr("smoke.json"));
  const auto kept = readImage(folder_.path("kept.exr"));
  ASSERT_TRUE(kept) << kept.error().message;
  ASSERT_EQ(kept->pixels.size(), painted.size());
  EXPECT_NEAR(kept->at(3, 9), painted[3] / 0.4, 1e-6) << "row 0 is at the largest y";
}

TEST_F(UnsavedControls, TheWindowClosesAfterTheQuestion) {
  open("fog.json");
  paint();
  script_->close();
  script_->frames(2);
  ASSERT_TRUE(app().leaving().asked());
  EXPECT_FALSE(app().leaving().ends());
  script_->press(Key::kEscape);
  script_->frames(2);
  EXPECT_FALSE(app().leaving().asked());
  EXPECT_FALSE(script_->has("leave cancel"));
  app().settings().panels = false;
  script_->close();
  script_->frames(2);
  ASSERT_TRUE(script_->click("leave discard")) << "it is asked without panels too";
  EXPECT_TRUE(app().leaving().ends());
}

TEST_F(UnsavedControls, NothingIsAskedWhereNothingIsLost) {
  open("fog.json");
  paint();
  script_->press(Key::kZ, true);
  load();
  script_->drop(folder_.path("dull.json"));
  load();
  EXPECT_FALSE(app().leaving().asked());
  EXPECT_THAT(title(), ::testing::HasSubstr("dull.json"));
  paint();
  Parameter densest = parameterAt("/media/0/sigma_max");
  app().document().set(densest, {0.3});
  load();
  EXPECT_TRUE(app().tools().painting.unsaved()) << "what was painted is in no file still";
  script_->close();
  script_->frames(2);
  EXPECT_FALSE(app().leaving().ends());
  ASSERT_TRUE(script_->click("leave save"));
  load();
  load();
  EXPECT_FALSE(app().tools().painting.unsaved());
  EXPECT_FALSE(app().leaving().ends()) << "the scene's change is in no file either";
  ASSERT_TRUE(script_->has("leave scene"));
  ASSERT_TRUE(script_->click("leave save"));
  load();
  load();
  EXPECT_TRUE(app().leaving().ends());
}

}  // namespace
}  // namespace volute
