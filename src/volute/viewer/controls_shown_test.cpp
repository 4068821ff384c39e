// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What of a file is shown: choices that its fields and files offer; several files in one scene.
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "volute/viewer/commands.hpp"
#include "volute/viewer/controls_testing.hpp"

namespace volute {
namespace {

/// Of one mesh: two sources of smoke, fields that fill it, particles, a device.
void writeCase(const SceneFolder& folder) {
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {{1, 3, 1, 3, 0, 1}}, {}});
  index.smoke(1, "room_1.s3d", 8700);
  const auto slice = [&](const fdswriter::Slice& what, const std::string& file, double factor) {
    const auto values = fdswriter::atNodes(
        kFirst, what.at, [&](double x, double y, double z) { return factor * linear(x, y, z); });
    fdswriter::sliceFile(what, {{0, values}, {5, values}}).save(folder.path(file));
    index.slice(1, what, file, false);
  };
  slice({whole(kFirst), "TEMPERATURE", "temp", "C"}, "full_temp.sf", 30);
  slice({whole(kFirst), "SOOT EXTINCTION COEFFICIENT", "ext_coef_Soot", "1/m"}, "full_ext.sf", 0.3);
  index.device("T1", "TEMPERATURE", {0.3, 0.3, 0.4});
  const fdswriter::Particles::OfAClass drops{{0.2F, 0.5F, 0.8F, 0.3F, 0.4F, 0.5F, 0.4F, 0.4F, 0.4F},
                                             {20, 30, 40}};
  fdswriter::particleFile({{{"PARTICLE TEMPERATURE", "C"}}}, {{0, {drops}}, {5, {drops}}})
      .save(folder.path("full.prt5"));
  index.files +=
      "CLASS_OF_PARTICLES\n drops\n 0.0 0.0 1.0\n 1\n PARTICLE TEMPERATURE\n part\n C\n"
      "PRT5     1\n full.prt5\n 1\n 1 0\n";
  index.save(folder.path("full.smv"));
}

class ShownControls : public WideControls {
 protected:
  void chooses(const std::string& path, const std::string& choice) {
    expectSeen(path + " = " + choice, [&] { ASSERT_TRUE(script_->choose(path, choice)); });
    EXPECT_EQ(app().document().error(), "");
  }

  std::string chosen(const std::string& path) {
    const Parameter parameter = parameterAt(path);
    return parameter.choices.at(static_cast<std::size_t>(parameter.value.at(0)));
  }

  std::vector<std::string> choicesOf(const std::string& path) { return parameterAt(path).choices; }

  bool offers(const std::string& path) {
    const auto& all = app().document().info()->parameters;
    return std::ranges::find(all, path, &Parameter::path) != all.end();
  }

  void slide(const std::string& path, double across) {
    expectSeen(path, [&] { ASSERT_TRUE(script_->click(path, across)); });
  }
};

TEST_F(ShownControls, WhatAVolumesFileLeavesOpenIsChosen) {
  open("blob.npy");
  script_->input().height = 1900;
  EXPECT_EQ(chosen("/media/0/preset"), "automatic");
  chooses("/media/0/preset", "smoke");
  chooses("/media/0/basis", "trilinear");
  chooses("/media/0/basis", "cubic");
  EXPECT_EQ(choicesOf("/media/0/basis"),
            (std::vector<std::string>{"automatic", "trilinear", "cubic"}))
      << "what is lit has no boxes";
  chooses("/media/0/preset", "automatic");
  chooses("/media/0/up", "x");
  app().playback().timeline().seek(0.02);
  load();
  chooses("/media/0/interpolate", "linear");
  saveAs("shown.json");
  std::ifstream stream(folder_.path("shown.json"));
  const auto saved = nlohmann::json::parse(stream)["media"][0];
  EXPECT_FALSE(saved.contains("preset")) << "automatic again";
  EXPECT_EQ(saved["basis"], "cubic");
  EXPECT_EQ(saved["up"], "x");
  EXPECT_EQ(saved["interpolate"], "linear");
}

TEST_F(ShownControls, ValuesAreSeenAsColoursThatAPersonDraws) {
  open("blob.npy");
  script_->input().height = 2300;
  chooses("/media/0/transfer/map", "inferno");
  EXPECT_FALSE(offers("/media/0/emission")) << "the transfer function stands for it";
  EXPECT_FALSE(app().view().picture().scene()->scales.empty()) << "a bar says what colours are";
  for (const char* point : {"/media/0/transfer/points/0", "/media/0/transfer/points/1"}) {
    SCOPED_TRACE(point);
    EXPECT_EQ(parameterAt(point).kind, Parameter::Kind::kPoint);
  }
  EXPECT_FALSE(parameterAt("/media/0/transfer/points/0").counts.empty()) << "a histogram";
  const std::vector<double> before = parameterAt("/media/0/transfer/points/2").value;
  expectSeen("a point is drawn down in the chart", [&] {
    ASSERT_TRUE(script_->dragFrom("/media/0/transfer/chart", 0.99, 0.13, -10, 60));
  });
  const std::vector<double> drawn = parameterAt("/media/0/transfer/points/2").value;
  EXPECT_LT(drawn[0], before[0]);
  EXPECT_LT(drawn[1], 0.8 * before[1]);
  expectSeen("a point is drawn by its numbers", [&] {
    ASSERT_TRUE(script_->dragFrom("/media/0/transfer/points/1", 0.1, 0.5, 70, 0));
  });
  slide("/media/0/transfer/range/0", 0.25);
  slide("/media/0/transfer/range/1", 0.4);
  ASSERT_TRUE(script_->click("add /media/0/transfer/points = 1"));
  load();
  EXPECT_TRUE(offers("/media/0/transfer/points/3"));
  ASSERT_TRUE(script_->click("remove /media/0/transfer/points = 1"));
  load();
  EXPECT_FALSE(offers("/media/0/transfer/points/3"));
  saveAs("colours.json");
  expectTheSameAfter("colours.json");
  app().settings().look.renderer = static_cast<int>(ViewRenderer::kGl);
  const Image byGl = picture();
  app().settings().look.renderer = static_cast<int>(ViewRenderer::kCpu);
  EXPECT_LT(difference(byGl, picture()), 0.02) << "as the command draws it";
}

TEST_F(ShownControls, MediaAreClippedByBoxesAndPlanes) {
  open("blob.npy");
  script_->input().height = 1900;
  const Image whole = picture();
  expectSeen("plane", [&] { ASSERT_TRUE(script_->click("add clip plane")); });
  expectSeen("its place",
             [&] { ASSERT_TRUE(script_->dragFrom("/clip/0/point", 0.15, 0.5, 40, 0)); });
  expectSeen("its normal", [&] { ASSERT_TRUE(script_->click("/clip/0/normal", 0.1)); });
  expectSeen("its height", [&] { ASSERT_TRUE(script_->click("/clip/0/normal elevation", 0.25)); });
  saveAs("cut.json");
  expectTheSameAfter("cut.json");
  expectSeen("gone", [&] { ASSERT_TRUE(script_->click("remove /clip/0")); });
  EXPECT_LT(difference(whole, picture()), 0.02);
  ASSERT_TRUE(script_->click("add clip box"));
  load();
  ASSERT_TRUE(offers("/clip/0/min"));
  expectSeen("from", [&] { ASSERT_TRUE(script_->dragFrom("/clip/0/min", 0.15, 0.5, 80, 0)); });
  expectSeen("to", [&] { ASSERT_TRUE(script_->dragFrom("/clip/0/max", 0.15, 0.5, -180, 0)); });
  ASSERT_TRUE(script_->click("duplicate /clip/0"));
  load();
  EXPECT_TRUE(offers("/clip/1/min"));
  EXPECT_EQ(app().document().error(), "");
}

TEST_F(ShownControls, ADistanceIsMeasuredByTwoClicks) {
  open("smoke.json");
  ViewCamera& camera = app().view().camera();
  camera.set({.eye = {3, 3, 20}, .target = {3, 3, 0}, .up = Vec3::UnitY(), .ortho = 8});
  load();
  const int width = script_->input().width, height = script_->input().height;
  const double x = 0.5 * width, y = 0.5 * height;
  const Vec3 eye = camera.eye();
  ASSERT_TRUE(script_->click("Measure"));
  EXPECT_TRUE(app().settings().measuring);
  script_->clickAt(x - 40, y);
  script_->clickAt(x + 40, y + 30);
  const auto& ruler = app().tools().pointer.ruler();
  ASSERT_EQ(ruler.size(), 2);
  const double metres = 8.0 / height;  // of a pixel
  EXPECT_NEAR((ruler[1] - ruler[0]).head<2>().norm(), std::hypot(80, 30) * metres, 0.05 * metres);
  EXPECT_NEAR(ruler[1].x() - ruler[0].x(), 80 * metres, 0.05 * metres);
  EXPECT_EQ((camera.eye() - eye).norm(), 0) << "the camera stays";
  script_->press(Key::kEscape);
  EXPECT_TRUE(app().tools().pointer.ruler().empty());
  EXPECT_FALSE(app().settings().measuring);
}

TEST_F(ShownControls, WhatACaseHasIsChosenFromItsFiles) {
  writeCase(folder_);
  open("full.smv");
  script_->input().height = 2100;
  pictureWidth_ = 640, pictureHeight_ = 480;
  script_->move(640, 1000);  // over the picture, not a panel
  script_->wheel(10);
  app().settings().look.quality = 1;  // marks of particles and devices are small
  ASSERT_EQ(app().document().error(), "");
  EXPECT_EQ(chosen("/media/0/field"), "automatic");
  chooses("/media/0/field", "s3d");
  chooses("/media/0/slice", "TEMPERATURE z=0.30");
  slide("/media/0/slice/at", 0.4);
  chooses("/media/0/slice", "off");
  chooses("/media/0/iso", "TEMPERATURE");
  slide("/media/0/iso/level", 0.3);
  chooses("/media/0/iso", "off");
  chooses("/media/0/particles", "all");
  chooses("/media/0/particles", "off");
  const std::vector<double> devices = parameterAt("/media/0/devices").value;
  expectSeen("devices", [&] { ASSERT_TRUE(script_->click("/media/0/devices", 0.05)); });
  EXPECT_NE(parameterAt("/media/0/devices").value, devices);
  for (const char* axis : {"x", "y", "z"}) {
    const std::string path = std::string("/media/0/cut/") + axis;
    const std::vector<double> before = parameterAt(path).value;
    slide(path, 0.4);
    EXPECT_NE(parameterAt(path).value, before) << path;
    script_->press(Key::kZ, true);
    load();
  }
  ASSERT_TRUE(script_->choose("/media/0/building", "whole"));
  load();
  EXPECT_EQ(chosen("/media/0/building"), "whole");
  EXPECT_EQ(app().document().error(), "");
}

TEST_F(ShownControls, SeveralFilesAreOneSceneAndAFileThatIsDroppedIsAdded) {
  open("blob.npy");
  const auto before = picture();
  expectSeen("added", [&] { script_->drop(folder_.path("smoke.pvd")); });
  EXPECT_EQ(app().document().error(), "");
  EXPECT_TRUE(offers("/media/1/mode")) << "smoke on a mesh";
  EXPECT_TRUE(app().document().info()->changed);
  EXPECT_THAT(app().document().info()->title, ::testing::HasSubstr("1 volume, 1 smoke"));
  saveAs("both.json");
  script_->press(Key::kZ, true);
  load();
  EXPECT_FALSE(offers("/media/1/mode"));
  EXPECT_LT(difference(before, picture()), 1e-3) << "taken out again";
  ASSERT_TRUE(script_->click("Add file"));
  script_->frames(3);
  ASSERT_TRUE(script_->click("entry = smoke.pvd"));
  ASSERT_TRUE(script_->click("open file"));
  load();
  EXPECT_TRUE(offers("/media/1/mode")) << "chosen in the list";
  open("both.json");
  EXPECT_TRUE(offers("/media/1/mode"));
  script_->drop(folder_.path("ground.obj"));
  load();
  EXPECT_NE(app().document().error(), "") << "no medium";
  EXPECT_TRUE(offers("/media/1/mode")) << "all stays";
}

TEST_F(ShownControls, AllFilesOfTheCommandAreThere) {
  Progress quiet;
  const std::string first = folder_.path("blob.npy");
  const auto document =
      documentOpener({.maxMemory = kViewerMemory,
                      .file = first,
                      .more = {folder_.path("map.png"), folder_.path("smoke.json")}})(first, quiet);
  ASSERT_TRUE(document) << document.error().message;
  const DocumentInfo info = (*document)->info();
  EXPECT_THAT(info.title, ::testing::HasSubstr("blob.npy: 1 volume"));
  EXPECT_THAT(info.title, ::testing::HasSubstr("1 sign"));
  EXPECT_FALSE(info.changed) << "as the command says it";
  const auto missing = documentOpener(
      {.maxMemory = kViewerMemory, .file = first, .more = {folder_.path("nothing.npy")}})(first,
                                                                                          quiet);
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message, ::testing::HasSubstr("nothing.npy"));
}

TEST_F(ShownControls, TheCameraIsParallelAndBackByAKeyAndABox) {
  open("blob.npy");
  const ViewCamera before = app().view().camera();
  script_->press(Key::k5);
  EXPECT_GT(app().view().camera().ortho(), 0);
  script_->press(Key::k5);
  EXPECT_EQ(app().view().camera().ortho(), 0);
  EXPECT_LT((app().view().camera().eye() - before.eye()).norm(), 1e-9);
  EXPECT_TRUE(script_->click("parallel", 0.05));
  EXPECT_GT(app().view().camera().ortho(), 0);
}

TEST_F(ShownControls, AnotherFileIsComparedByABorderAndAsADifference) {
  open("smoke.vtu");
  script_->input().height = 1900;
  const Image alone = picture();
  ASSERT_TRUE(script_->click("compare"));
  script_->frames(2);
  ASSERT_TRUE(script_->click("entry = more.vtu"));
  ASSERT_TRUE(script_->click("open file"));
  const Image both = picture();
  ASSERT_TRUE(app().comparison().active());
  EXPECT_EQ(app().comparison().error(), "");
  EXPECT_THAT(app().document().info()->title, ::testing::HasSubstr("smoke.vtu")) << "it stays open";
  double left = 0, right = 0;
  for (int y = 0; y < both.height; ++y) {
    for (int x = 0; x < both.width; ++x) {
      double& most = x < both.width / 2 ? left : right;
      most = std::max<double>(most, std::abs(both.at(x, y, 0) - alone.at(x, y, 0)));
    }
  }
  EXPECT_LT(left, 1e-6);
  EXPECT_GT(right, 0.01) << "three times the smoke";
  expectSeen("border", [&] { ASSERT_TRUE(script_->click("border", 0.1)); });
  expectSeen("difference", [&] { ASSERT_TRUE(script_->choose("show", "difference")); });
  expectSeen("span", [&] { ASSERT_TRUE(script_->click("up to", 0.1)); });
  ASSERT_TRUE(script_->click("end comparison"));
  EXPECT_LT(difference(alone, picture()), 1e-6);
  ASSERT_TRUE(script_->click("compare"));
  script_->frames(2);
  ASSERT_TRUE(script_->click("open cancel"));
  script_->press(Key::kO, true);
  script_->frames(2);
  ASSERT_TRUE(script_->click("entry = blob.npy"));
  ASSERT_TRUE(script_->click("open file"));
  load();
  EXPECT_THAT(app().document().info()->title, ::testing::HasSubstr("blob.npy")) << "opened";
}

TEST_F(ShownControls, AFileOfTheSameKindIsComparedInTheFirstOnesLook) {
  VolumeInfo info;
  info.frames = 1, info.x = info.y = info.z = 10;
  info.fillDefaults();
  for (const auto& [name, most] : {std::pair("thin.npy", 1.0F), std::pair("dense.npy", 5.0F)}) {
    auto sink = NpySink::create(folder_.path(name), info);
    ASSERT_TRUE(sink);
    ASSERT_TRUE((*sink)->writeFrame(std::vector<float>(1000, most)));
    ASSERT_TRUE((*sink)->finish());
  }
  ASSERT_NO_FATAL_FAILURE(
      restart({}, {.file = folder_.path("thin.npy"), .members = {{"preset", "smoke"}}}));
  open("thin.npy");
  app().document().files().askToOpen(DocumentFiles::Purpose::kCompare);
  app().takeFile(folder_.path("dense.npy"));
  ASSERT_TRUE(script_->settle());
  const auto depthAt = [&](double x) {
    const double y = 0.5 * script_->input().height;
    PointerTools& pointer = app().tools().pointer;
    const bool other = app().comparison().isAt(x, script_->input().width);
    const auto probe =
        other ? pointer.probeOther(*app().comparison().document(), x, y) : pointer.probeAt(x, y);
    return probe && !probe->media.empty() ? probe->media[0].extinction : 0;
  };
  const double middle = 0.5 * script_->input().width;
  const double first = depthAt(middle - 20), second = depthAt(middle + 20);
  EXPECT_GT(first, 0);
  EXPECT_NEAR(second / first, 5, 0.5) << "and the values are of the file under the pointer";
  EXPECT_EQ(app().comparison().remark(*app().document().info()), "");
  app().document().set(parameterAt("/media/0/extinction"), {0.1});
  load();
  ASSERT_TRUE(script_->settle());
  EXPECT_NEAR(depthAt(middle + 20) / depthAt(middle - 20), 5, 0.5) << "it follows the first";
  app().takeFile(folder_.path("smoke.vtu"));
  ASSERT_TRUE(script_->settle());
  EXPECT_NE(app().comparison().remark(*app().document().info()), "");
}

TEST_F(ShownControls, ASceneIsComparedWithWhatItsFileSays) {
  open("smoke.json");
  app().document().set(parameterAt("/media/0/C"), {5});
  load();
  script_->press(Key::kF3);
  script_->frames(2);
  ASSERT_TRUE(script_->click("search"));
  script_->type("as it is saved");
  script_->press(Key::kEnter);
  ASSERT_TRUE(app().comparison().active());
  EXPECT_EQ(app().comparison().path(), folder_.path("smoke.json"));
  app().comparison().mode = Comparison::Mode::kDifference;
  const Image other = picture();
  app().comparison().end();
  EXPECT_GT(difference(other, picture()), 0.01);
}

TEST_F(ShownControls, AFileToCompareWithThatIsNotThereIsNamed) {
  open("smoke.vtu");
  app().document().files().askToOpen(DocumentFiles::Purpose::kCompare);
  app().takeFile(folder_.path("gone.vtu"));
  load();
  script_->settle();
  EXPECT_THAT(app().comparison().error(), ::testing::HasSubstr("gone.vtu"));
  EXPECT_EQ(app().document().error(), "");
}

TEST_F(ShownControls, PaintFogIsACommand) {
  const auto paint = [&] {
    script_->press(Key::kF3);
    script_->frames(2);
    ASSERT_TRUE(script_->click("search"));
    script_->type("paint fog");
    script_->press(Key::kEnter);
  };
  open("blob.npy");
  ASSERT_NO_FATAL_FAILURE(paint());
  EXPECT_FALSE(app().settings().painting);
  EXPECT_TRUE(app().document().saysFailure());
  open("fog.json");
  ASSERT_NO_FATAL_FAILURE(paint());
  EXPECT_TRUE(app().settings().painting);
}

TEST_F(ShownControls, EveryCommandIsFoundByItsWords) {
  open("blob.npy");
  script_->press(Key::kF3);
  script_->frames(2);
  ASSERT_TRUE(script_->click("search"));
  script_->type("PARALLEL");
  script_->frames(2);
  EXPECT_TRUE(script_->has("command parallel or perspective camera"));
  EXPECT_FALSE(script_->has("command full screen"));
  script_->press(Key::kEnter);
  script_->frames(2);
  EXPECT_GT(app().view().camera().ortho(), 0);
  EXPECT_FALSE(script_->has("search")) << "it closes";
  script_->press(Key::kSpace, true);
  script_->frames(2);
  EXPECT_TRUE(script_->click("command play, pause"));
  EXPECT_TRUE(app().playback().timeline().playing());
}

TEST_F(ShownControls, CommandsAreFoundByOtherWordsForThem) {
  for (const auto& [words, name] : {std::pair{"export", "make a film"},
                                    {"turntable", "make a film once around, of a still in 10 s"},
                                    {"exposure", "brighter by half a stop"},
                                    {"clip", "clip by a plane"},
                                    {"lamp", "add a lamp"},
                                    {"ruler", "measure a distance by two clicks"},
                                    {"speed", "twice as fast"},
                                    {"value", "show what is under the pointer"},
                                    {"fit", "the whole view, from outside"},
                                    {"transfer", "choose what is shown, in the panel Scene"}}) {
    EXPECT_TRUE(std::ranges::any_of(viewerCommands(), [&](const ViewerCommand& command) {
      return std::string_view(command.name) == name && isFound(command, words);
    })) << words;
  }
  open("blob.npy");
  script_->press(Key::kF3);
  script_->frames(2);
  ASSERT_TRUE(script_->click("search"));
  script_->type("clip plane");
  script_->press(Key::kEnter);
  load();
  EXPECT_TRUE(app().document().info()->canUndo);
}

TEST_F(ShownControls, TheLoopAndMarksAreSetByKeys) {
  open("room.smv");  // 0 to 5 s
  Timeline& timeline = app().playback().timeline();
  timeline.seek(1);
  script_->press(Key::kI);
  script_->press(Key::kB);
  timeline.seek(3);
  script_->press(Key::kO);
  EXPECT_EQ(timeline.loopBegin(), 1);
  EXPECT_EQ(timeline.loopEnd(), 3);
  script_->press(Key::kLeft, true);
  EXPECT_EQ(timeline.time(), 1);
  script_->press(Key::kUp);
  EXPECT_EQ(timeline.speed(), 2);
  timeline.play(true);
  timeline.advance(0.6);
  EXPECT_NEAR(timeline.time(), 2.2, 1e-9);
  timeline.advance(0.6);
  EXPECT_NEAR(timeline.time(), 1.4, 1e-9) << "from the loop's beginning again";
  script_->press(Key::kL);
  EXPECT_FALSE(timeline.loopsPart());
}

TEST_F(ShownControls, TheLoopIsChosenAndSaved) {
  open("room.smv");  // 0 to 5 s
  ASSERT_NO_FATAL_FAILURE(openMore());
  Timeline& timeline = app().playback().timeline();
  timeline.seek(1);
  ASSERT_TRUE(script_->choose("loop", "loop to here"));
  EXPECT_EQ(timeline.loopEnd(), 1);
  timeline.seek(3);
  ASSERT_TRUE(script_->choose("loop", "loop from here"));
  EXPECT_EQ(timeline.loopBegin(), 3) << "behind what was its end";
  EXPECT_EQ(timeline.loopEnd(), 5);
  saveAs("loop.json");
  ASSERT_TRUE(script_->choose("loop", "all frames"));
  EXPECT_FALSE(timeline.loopsPart());
  open("loop.json");
  EXPECT_EQ(timeline.loopBegin(), 3);
  EXPECT_TRUE(timeline.loopsPart());
  open("room.smv");
  EXPECT_FALSE(timeline.loopsPart()) << "it is the scene's";
}

TEST_F(ShownControls, WhatIsRefusedIsNotShownAsChosen) {
  VolumeInfo info;
  info.frames = 1, info.x = info.y = info.z = 8, info.channels = 3;
  info.fillDefaults();
  auto sink = NpySink::create(folder_.path("smoke.npy"), info);
  ASSERT_TRUE(sink);
  ASSERT_TRUE((*sink)->writeFrame(std::vector<float>(3 * 8 * 8 * 8, 0.5F)));
  ASSERT_TRUE((*sink)->finish());
  open("smoke.npy");
  const auto preset = valueOf("/media/0/preset");
  ASSERT_TRUE(script_->choose("/media/0/preset", "fire"));
  load();
  EXPECT_THAT(app().document().error(), ::testing::HasSubstr("three"));
  EXPECT_EQ(valueOf("/media/0/preset"), preset);
  ASSERT_TRUE(script_->choose("/media/0/preset", "smoke"));
  load();
  EXPECT_EQ(app().document().error(), "");
  EXPECT_NE(valueOf("/media/0/preset"), preset);
  EXPECT_THAT(app().document().info()->remarks,
              ::testing::Contains(::testing::HasSubstr("mean of the three channels")));
}

/// As after a crash: the file of a process that is no longer there.
TEST_F(ShownControls, AnUnsavedSceneIsOfferedAfterACrash) {
  const std::filesystem::path unsaved = folder_.path("state/unsaved");
  const ViewerOptions options{.recent = folder_.path("state/recent")};
  ASSERT_NO_FATAL_FAILURE(restart(options));
  open("smoke.json");
  app().document().set(parameterAt("/media/0/C"), {5});
  load();
  script_->frames(3);
  const std::filesystem::path own = unsaved / (std::to_string(::getpid()) + ".json");
  ASSERT_TRUE(std::filesystem::exists(own));
  const std::filesystem::path dead = unsaved / "999999999.json";  // no process has this number
  const auto nameBeside = [](std::filesystem::path scene) {
    return scene.replace_extension(".name");
  };
  std::filesystem::copy_file(own, dead);
  std::filesystem::copy_file(nameBeside(own), nameBeside(dead));
  ASSERT_NO_FATAL_FAILURE(restart(options));
  EXPECT_FALSE(std::filesystem::exists(own)) << "that one ended as it should";
  script_->frames(3);
  ASSERT_TRUE(script_->click("restore 0"));
  load();
  ASSERT_EQ(app().document().error(), "");
  EXPECT_EQ(valueOf("/media/0/C"), std::vector<double>{5});
  EXPECT_TRUE(app().document().info()->changed) << "no file has it";
  EXPECT_EQ(app().settings().sceneName, folder_.path("smoke.json"));
  script_->close();
  ASSERT_TRUE(app().leaving().asked());
  script_->frames(2);
  ASSERT_TRUE(script_->click("leave save"));
  load();
  EXPECT_TRUE(app().leaving().ends());
  std::ifstream stream(folder_.path("smoke.json"));
  EXPECT_EQ(nlohmann::json::parse(stream)["media"][0]["C"], 5);
  ASSERT_NO_FATAL_FAILURE(restart(options));
  EXPECT_FALSE(std::filesystem::exists(dead)) << "it was saved";
  script_->frames(3);
  EXPECT_FALSE(script_->has("restore 0"));
  std::filesystem::create_directories(unsaved);
  std::ofstream(dead) << "{}";
  std::ofstream(nameBeside(dead)) << "other.json\n";
  script_->frames(3);
  ASSERT_TRUE(script_->click("discard 0"));
  script_->frames(3);
  EXPECT_FALSE(script_->has("restore 0"));
  EXPECT_FALSE(std::filesystem::exists(dead));
}

/// As the next window does when the context of one is lost.
TEST_F(ShownControls, AnotherViewerGoesOnWhereOneEnded) {
  const ViewerOptions options{.recent = folder_.path("state/recent")};
  ASSERT_NO_FATAL_FAILURE(restart(options));
  EXPECT_EQ(app().rest().path, "") << "nothing is open";
  open("smoke.json");
  app().document().set(parameterAt("/media/0/C"), {5});
  load();
  app().playback().timeline().seek(0.2);
  app().view().camera().turn(0.4);
  const ViewCamera camera = app().view().camera();
  const ViewerRest rest = app().rest();
  ASSERT_NO_FATAL_FAILURE(restart(options));
  app().open(rest);
  load();
  ASSERT_EQ(app().document().error(), "");
  EXPECT_EQ(valueOf("/media/0/C"), std::vector<double>{5});
  EXPECT_TRUE(app().document().info()->changed);
  EXPECT_EQ(app().settings().sceneName, folder_.path("smoke.json"));
  EXPECT_EQ(app().playback().timeline().time(), 0.2);
  EXPECT_EQ(app().view().camera(), camera);
}

TEST_F(ShownControls, AScreenshotIsAsLargeInPixelsAtAnyScaleOfTheInterface) {
  script_.reset(), viewer_.reset();  // one interface at a time
  Progress quiet;
  const ViewerStart start{
      .path = folder_.path("blob.npy"), .width = 900, .height = 600, .options = {.scale = 2}};
  const auto shot =
      viewerScreenshot(documentOpener({.maxMemory = kViewerMemory}), start, true, quiet);
  ASSERT_TRUE(shot) << shot.error().message;
  EXPECT_EQ(shot->width, 900);
  EXPECT_EQ(shot->height, 600);
}

}  // namespace
}  // namespace volute
