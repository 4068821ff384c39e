// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Every parameter of every kind of document, driven by the viewer's input layer: the picture
// changes, and so does the value, which is the same after saving and reading.
#include "volute/viewer/controls_testing.hpp"

namespace volute {
namespace {

TEST_F(Controls, EveryParameterOfFogAndItsSun) {
  open("fog.json");
  // Sunlit fog keeps its details; wind moves nothing at 0 s; a profile's kind takes its heights.
  changeAll({"/media/0/mu", "/media/0/levels", "/media/0/wind", "/media/0/profile/kind"});
  expectElevation("/lights/0/direction");
  ASSERT_TRUE(script_->click("exposure", 0.6));
  saveAs("fog2.json");
  expectTheSameAfter("fog2.json");
}

TEST_F(Controls, FogWithoutASunDropsDetails) {
  open("dull.json");
  changeAll({"/media/0/wind", "/media/0/profile/kind"});
  saveAs("dull2.json");
  expectTheSameAfter("dull2.json");
}

TEST_F(Controls, EveryParameterOfSmokeAndLamps) {
  open("smoke.json");
  // The mode comes last: C is the threshold's alone; time has a test of its own.
  changeAll({"/media/0/mode", "/media/0/time/offset", "/media/0/time/rate", "/media/0/time/loop"},
            "/media");
  const Image threshold = picture();
  ASSERT_TRUE(script_->choose("/media/0/mode", "photometric"));
  load();
  EXPECT_GT(difference(threshold, picture()), 0.0005);
  changeAll({}, "/lights");
  saveAs("smoke2.json");
  expectTheSameAfter("smoke2.json");
}

TEST_F(Controls, EveryParameterOfSigns) {
  open("smoke.json");
  std::set<std::string> done;
  Image shown = picture();
  for (const char* path : {"/signs/0/C", "/signs/0/emitting", "/signs/0/size/0",
                           "/signs/0/size/1"}) {  // while it is well seen
    expectChange(parameterAt(path), shown);
    done.insert(path);
  }
  expectElevation("/signs/0/normal");
  changeAll(done, "/signs");
  saveAs("signs2.json");
  expectTheSameAfter("signs2.json");
}

TEST_F(Controls, EveryParameterOfVolumes) {
  open("blob.npy");
  Image shown = picture();
  for (const char* colors : {"viridis", "inferno", "grey", "viridis"}) {  // while nothing lights it
    ASSERT_TRUE(script_->choose("colours", colors));
    Image now = picture();
    EXPECT_GT(difference(shown, now), 0.01) << colors;
    shown = std::move(now);
  }
  changeAll({"/background", "/media/0/time/offset", "/media/0/time/rate", "/media/0/time/loop"});
  shown = picture();
  expectChange(parameterAt("/background"), shown);
  saveAs("blob2.json");
  expectTheSameAfter("blob2.json");
  EXPECT_EQ(app().settings().look.colors, 1);
}

TEST_F(Controls, TonesOfAPicture) {
  open("blob.npy");
  Image shown = picture();
  for (const char* tone : {"none", "filmic", "shoulder", "ACES"}) {
    ASSERT_TRUE(script_->choose("tone", tone));
    Image now = picture();
    if (!app().view().toneError().empty())  // without OpenColorIO
      continue;
    EXPECT_GT(difference(shown, now), 0.002) << tone;
    shown = std::move(now);
  }
  saveAs("blob2.json");
  EXPECT_EQ(app().settings().look.tone, 4);
}

TEST_F(Controls, EveryParameterOfFdsCases) {
  open("room.smv");
  // Which says nothing about opacities; at its first step its clock says nothing either.
  changeAll({"/media/0/mass_extinction", "/media/0/time/offset", "/media/0/time/rate",
             "/media/0/time/loop"},
            "/media");
  changeAll({}, "/lights");
  changeAll({}, "/background");
  saveAs("room2.json");
  expectTheSameAfter("room2.json");
}

TEST_F(Controls, AMaterialHasItsSmokePotential) {
  open("smoke.json");
  const auto find = [&] {
    return *std::ranges::find(app().document().info()->parameters, "/media/0/material",
                              &Parameter::path);
  };
  const Image before = picture();
  ASSERT_TRUE(script_->choose("/media/0/material", find().choices[3]));
  load();
  EXPECT_EQ(find().value[0], 3);
  EXPECT_NE(valueOf("/media/0/smoke_potential")[0], 2.0);
  Image shown = picture();
  EXPECT_GT(difference(before, shown), 0.001);
  saveAs("material.json");
  expectTheSameAfter("material.json");
  EXPECT_EQ(find().value[0], 3);
  expectChange(parameterAt("/media/0/smoke_potential"), shown);
  saveAs("potential.json");
  expectTheSameAfter("potential.json");
}

TEST_F(Controls, KmSaysWhatTheSootOfAnFdsCaseAbsorbs) {
  open("soot.smv");
  Image shown = picture();
  expectChange(parameterAt("/media/0/mass_extinction"), shown);
  saveAs("soot2.json");
  expectTheSameAfter("soot2.json");
}

}  // namespace
}  // namespace volute
