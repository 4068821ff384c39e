// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// How files get in and changes out: the empty window, the list, the questions; and the hands on the
// camera that need no panel.
#include <nlohmann/json.hpp>

#include "volute/viewer/controls_testing.hpp"
#include "volute/viewer/view_report.hpp"

namespace volute {
namespace {

using DoorControls = Controls;

TEST_F(DoorControls, AnEmptyWindowOpensAFileByTheList) {
  script_->frames(4);
  ASSERT_TRUE(script_->has("Open a file"));
  ASSERT_TRUE(script_->click("Open a file"));
  script_->frames(3);
  ASSERT_NE(app().document().files().browser(), nullptr);
  app().document().files().browse(std::filesystem::path(folder_.path("x")).parent_path());
  script_->frames(3);
  ASSERT_TRUE(script_->has("entry = blob.npy"));
  ASSERT_TRUE(script_->click("entry = blob.npy"));
  script_->frames(2);
  EXPECT_EQ(app().document().files().browser()->name, "blob.npy");
  ASSERT_TRUE(script_->click("open file"));
  load();
  EXPECT_EQ(app().document().error(), "");
  ASSERT_NE(app().document().info(), nullptr);
  EXPECT_THAT(app().document().info()->title, ::testing::HasSubstr("blob.npy"));
  EXPECT_EQ(titleOf(app()), "blob.npy - Volute");
  EXPECT_FALSE(script_->has("Open a file"));
}

TEST_F(DoorControls, TheListGoesThroughFolders) {
  open("blob.npy");
  script_->press(Key::kO, true);
  script_->frames(3);
  ASSERT_NE(app().document().files().browser(), nullptr);
  const auto folder = app().document().files().browser()->folder;
  ASSERT_TRUE(script_->click("folder above"));
  script_->frames(3);
  EXPECT_EQ(app().document().files().browser()->folder, folder.parent_path());
  ASSERT_TRUE(script_->click("open cancel"));
  script_->frames(2);
  EXPECT_EQ(app().document().files().browser(), nullptr);
  script_->press(Key::kO, true);
  script_->frames(3);
  script_->type("fog.json");  // the name has the keyboard
  script_->press(Key::kEnter);
  load();
  EXPECT_EQ(titleOf(app()), "fog.json - Volute");
  script_->press(Key::kO, true);
  script_->frames(3);
  ASSERT_TRUE(script_->write("file name", "blob.npy"));  // with Enter
  load();
  EXPECT_EQ(titleOf(app()), "blob.npy - Volute");
  ASSERT_TRUE(script_->click("Open"));
  script_->frames(3);
  ASSERT_NE(app().document().files().browser(), nullptr);
  script_->press(Key::kEscape);
  EXPECT_EQ(app().document().files().browser(), nullptr);
  script_->press(Key::kO, true);
  script_->frames(3);
  ASSERT_TRUE(script_->click("open folder"));
  load();
  EXPECT_NE(app().document().error(), "") << "the folder holds no numbered frames";
}

TEST_F(DoorControls, AHintMayAppearTogetherWithAQuestion) {
  open("blob.npy");
  script_->frames(4);
  ViewerInput& input = script_->input();
  ASSERT_TRUE(script_->pointOf("Open", 0.5, 0.5, input.mouseX, input.mouseY));
  script_->press(Key::kO, true);
  script_->frames(2);
  EXPECT_TRUE(script_->has("open cancel"));
}

TEST_F(DoorControls, RecentFilesAreOffered) {
  open("blob.npy");
  EXPECT_THAT(app().document().files().recent().names(),
              ::testing::ElementsAre(folder_.path("blob.npy")));
  const ViewerOptions options{.recent = folder_.path("state/recent")};
  RecentFiles(options.recent).add(folder_.path("blob.npy"));
  ASSERT_NO_FATAL_FAILURE(restart(options));
  script_->frames(4);
  ASSERT_TRUE(script_->click("recent 0"));
  load();
  ASSERT_NE(app().document().info(), nullptr);
  EXPECT_THAT(app().document().info()->title, ::testing::HasSubstr("blob.npy"));
}

TEST_F(DoorControls, ChangesOfASceneAreNotLostUnasked) {
  open("fog.json");
  EXPECT_FALSE(app().document().info()->changed);
  app().document().set(parameterAt("/media/0/mu"), {0.25});
  load();
  EXPECT_TRUE(app().document().info()->changed);
  EXPECT_EQ(titleOf(app()), "* fog.json - Volute");
  script_->open(folder_.path("blob.npy"));
  script_->frames(3);
  ASSERT_NE(app().leaving().asked(), nullptr);
  ASSERT_TRUE(script_->click("leave cancel"));
  EXPECT_EQ(app().leaving().asked(), nullptr);
  EXPECT_EQ(titleOf(app()), "* fog.json - Volute");
  script_->close();
  script_->frames(3);
  ASSERT_TRUE(script_->write("leave scene", folder_.path("kept.json")));  // with Enter: it saves
  load();
  EXPECT_TRUE(app().leaving().ends());
  std::ifstream kept(folder_.path("kept.json"));
  EXPECT_EQ(nlohmann::json::parse(kept)["media"][0]["mu"], 0.25);
}

TEST_F(DoorControls, AnUndoneChangeIsNone) {
  open("fog.json");
  app().document().set(parameterAt("/media/0/mu"), {0.25});
  load();
  app().document().undo();
  load();
  EXPECT_FALSE(app().document().info()->changed);
  script_->open(folder_.path("blob.npy"));
  load();
  EXPECT_EQ(titleOf(app()), "blob.npy - Volute");
}

TEST_F(DoorControls, AFileOfOthersIsNotReplacedUnasked) {
  open("fog.json");
  const std::string other = folder_.path("dull.json");
  std::ifstream stream(other);
  const std::string before(std::istreambuf_iterator<char>(stream), {});
  app().settings().sceneName = other;
  script_->press(Key::kS, true);
  script_->frames(3);
  ASSERT_NE(app().document().files().replacing(), nullptr);
  ASSERT_TRUE(script_->click("keep"));
  load();
  std::ifstream same(other);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(same), {}), before);
  script_->press(Key::kS, true);
  script_->frames(3);
  ASSERT_TRUE(script_->click("replace"));
  load();
  std::ifstream now(other);
  EXPECT_NE(std::string(std::istreambuf_iterator<char>(now), {}), before);
  script_->press(Key::kS, true);
  load();
  EXPECT_EQ(app().document().files().replacing(), nullptr) << "it is the viewer's own by now";
}

TEST_F(DoorControls, TheVolumeThatIsShownIsNotReplacedByItsScene) {
  open("blob.npy");
  const auto size = std::filesystem::file_size(folder_.path("blob.npy"));
  app().settings().sceneName = folder_.path("blob.npy");
  script_->press(Key::kS, true);
  load();
  EXPECT_THAT(app().document().error(), ::testing::HasSubstr("would be replaced"));
  EXPECT_EQ(std::filesystem::file_size(folder_.path("blob.npy")), size);
}

TEST_F(DoorControls, AFileOfASceneThatMovedIsAskedFor) {
  const std::filesystem::path now = folder_.path("elsewhere");
  std::filesystem::create_directories(now);
  for (const char* name : {"smoke.pvd", "smoke.vtu", "more.vtu", "ground.obj"})
    std::filesystem::rename(folder_.path(name), now / name);
  open("blob.npy");
  app().open(folder_.path("smoke.json"));
  load();
  EXPECT_NE(app().document().error(), "");
  script_->frames(3);
  ASSERT_TRUE(script_->click("moved cancel"));
  EXPECT_THAT(app().document().info()->title, ::testing::HasSubstr("blob.npy"))
      << "nothing is lost";
  app().open(folder_.path("smoke.json"));
  load();
  script_->frames(3);
  ASSERT_NE(app().document().files().moved(), nullptr);
  ASSERT_TRUE(script_->click("find moved"));
  script_->frames(2);
  ASSERT_NE(app().document().files().browser(), nullptr);
  app().document().files().browse(now);
  const std::string sought = app().document().files().moved() ? "" : "smoke.pvd";
  script_->frames(3);
  // The first one that is missing, in the order of the scene.
  ASSERT_TRUE(script_->click("entry = " + sought));
  ASSERT_TRUE(script_->click("open file"));
  load();
  ASSERT_EQ(app().document().error(), "") << "the ground is found beside it";
  EXPECT_TRUE(app().document().info()->changed) << "no file has it";
  EXPECT_EQ(app().settings().sceneName, folder_.path("smoke.json"));
  app().document().files().allow(folder_.path("smoke.json"));
  app().saveScene();
  load();
  app().open(folder_.path("smoke.json"));
  load();
  EXPECT_EQ(app().document().error(), "") << "it was saved with the new places";
  EXPECT_EQ(app().document().files().moved(), nullptr);
}

TEST_F(DoorControls, AFirstSceneWhoseFileMovedIsAskedForInWindowsOfAllSizes) {
  std::filesystem::remove(folder_.path("smoke.pvd"));
  for (const int width : {kNarrow, 320}) {
    restart({});
    script_->input().width = width;
    app().open(folder_.path("smoke.json"));
    load();
    script_->frames(3);
    EXPECT_FALSE(script_->has("Open a file")) << "one question at a time";
    ASSERT_TRUE(script_->click("moved cancel"));
    script_->frames(2);
    EXPECT_TRUE(script_->has("Open a file"));
  }
}

TEST_F(DoorControls, AFileThatVanishesOrIsHalfWrittenKeepsThePicture) {
  open("blob.npy");
  const Image shown = picture();
  const auto waitFor = [&](auto&& holds) {
    for (int i = 0; i < 8000 && !holds(); ++i) {
      script_->frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return holds();
  };
  const std::filesystem::path file = folder_.path("blob.npy");
  std::string bytes(std::filesystem::file_size(file), 0);
  std::ifstream(file, std::ios::binary).read(bytes.data(), std::ssize(bytes));
  const auto write = [&](const std::string& what) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << what;
    std::filesystem::last_write_time(file, std::filesystem::last_write_time(file) + clock_++);
  };
  write(bytes.substr(0, bytes.size() / 2));
  EXPECT_TRUE(waitFor([&] { return !app().document().error().empty(); })) << "half of it";
  EXPECT_THAT(app().document().error(), ::testing::HasSubstr("blob.npy"));
  EXPECT_LT(difference(shown, picture()), 1e-6) << "the picture stays";
  write(bytes);
  EXPECT_TRUE(waitFor([&] { return app().document().error().empty(); })) << "it is whole again";
  std::filesystem::remove(file);
  script_->frames(30);
  EXPECT_LT(difference(shown, picture()), 1e-6) << "the picture stays";
  ASSERT_TRUE(script_->click("exposure", 0.3)) << "and can be looked at";
  EXPECT_NE(app().settings().look.stops, 0);
}

TEST_F(DoorControls, WhatIsReadAgainKeepsUnsavedChanges) {
  open("fog.json");
  const auto mu = [&] { return valueOf("/media/0/mu").front(); };
  const auto readAgain = [&](const std::string& name) {
    const int opened = app().document().info()->opened;
    std::filesystem::last_write_time(
        folder_.path(name), std::filesystem::last_write_time(folder_.path(name)) + clock_++);
    for (int i = 0; i < 8000 && app().document().info()->opened == opened; ++i) {
      script_->frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_GT(app().document().info()->opened, opened) << name;
    load();
  };
  app().document().set(parameterAt("/media/0/mu"), {0.25});
  load();
  for (const std::string file : {"map.png", "fog.json"}) {
    readAgain(file);
    EXPECT_EQ(mu(), 0.25) << file;
    EXPECT_TRUE(app().document().info()->changed && app().document().info()->canUndo) << file;
    EXPECT_FALSE(app().document().info()->unsaved.empty()) << "what is recovered";
  }
  std::ifstream stream(folder_.path("fog.json"));
  std::string text(std::istreambuf_iterator<char>(stream), {});
  text.replace(text.find("\"mu\": 0.5"), 9, "\"mu\": 0.7");
  std::ofstream(folder_.path("fog.json")) << text;
  readAgain("fog.json");
  EXPECT_EQ(mu(), 0.25) << "others wrote the scene";
  EXPECT_THAT(app().document().message(), ::testing::HasSubstr("fog.json has changed on disk"));
  script_->press(Key::kS, true);
  script_->frames(3);
  ASSERT_TRUE(app().document().files().replacing()) << "what they wrote is not lost unasked";
  ASSERT_TRUE(script_->click("keep"));
  script_->press(Key::kZ, true);
  load();
  EXPECT_EQ(mu(), 0.7);
  EXPECT_FALSE(app().document().info()->changed);
  script_->press(Key::kY, true);
  load();
  EXPECT_EQ(mu(), 0.25);
}

TEST_F(DoorControls, EnterSavesBeforeOneLeaves) {
  open("fog.json");
  app().document().set(parameterAt("/media/0/mu"), {0.25});
  load();
  app().settings().sceneName = folder_.path("entered.json");
  script_->close();
  script_->frames(3);
  ASSERT_TRUE(app().leaving().asked());
  script_->press(Key::kEnter);
  load();
  EXPECT_TRUE(app().leaving().ends());
  EXPECT_TRUE(std::filesystem::exists(folder_.path("entered.json")));
}

TEST_F(DoorControls, ARestoredSceneHasItsName) {
  std::filesystem::create_directories(folder_.path("unsaved"));
  const Recovery recovery(folder_.path("unsaved"));
  std::ifstream stream(folder_.path("fog.json"));
  std::string text(std::istreambuf_iterator<char>(stream), {});
  text.replace(text.find("map.png"), 7, folder_.path("map.png"));
  const std::string kept = recovery.keepMended(text, folder_.path("fog.json"));
  app().open(kept);
  load();
  ASSERT_EQ(app().document().error(), "");
  EXPECT_EQ(titleOf(app()), "* fog.json (restored) - Volute");
  EXPECT_THAT(app().document().info()->title, ::testing::StartsWith("fog.json (restored)"));
}

TEST_F(DoorControls, AFileOfAnotherKindIsToldOnceWithThoseThatAreShown) {
  std::ofstream(folder_.path("notes.txt")) << "words";
  app().open(folder_.path("notes.txt"));
  load();
  EXPECT_THAT(app().document().error(), ::testing::HasSubstr(".json, .volute, .vdb"));
  EXPECT_TRUE(app().settings().alerts.empty()) << "the empty window says it";
  EXPECT_TRUE(script_->has("Open a file"));
}

TEST_F(DoorControls, BlackSurfacesAreExplained) {
  std::ofstream(folder_.path("dark.json")) << R"({"format": "volute-scene-2", "media": [],
    "camera": {"eye": [-6, 2, 4], "target": [3, 3, 0], "fov": 50}, "background": [0.5, 0.5, 0.5],
    "geometry": [{"file": "ground.obj"}]})";
  open("dark.json");
  ASSERT_TRUE(script_->settle());
  script_->frames(2);
  ASSERT_EQ(app().settings().alerts.size(), 1);
  EXPECT_THAT(app().settings().alerts[0].text, ::testing::HasSubstr("the scene has no light"));
  app().tools().pointer.add(SceneEdit::Kind::kAddAmbient);
  load();
  ASSERT_TRUE(script_->settle());
  script_->frames(2);
  EXPECT_TRUE(app().settings().alerts.empty());
}

TEST_F(DoorControls, ARemarkIsMadeOnceHoweverOftenAMediumIsChanged) {
  std::ofstream(folder_.path("sunny.json")) << R"({"format": "volute-scene-2",
    "media": [{"kind": "volume", "file": "blob.npy", "extinction": 1, "emission": 1}],
    "lights": [{"kind": "sun", "direction": [0.4, 0.5, -0.6], "radiance": [2, 1.8, 1.5]}]})";
  open("sunny.json");
  const auto before = app().document().info()->remarks;
  ASSERT_EQ(before.size(), 2);  // on the sun, and on bounds that are not stated
  for (const double emission : {2.0, 3.0, 4.0}) {
    app().document().set(parameterAt("/media/0/emission"), {emission});
    load();
  }
  EXPECT_EQ(app().document().info()->remarks, before);
}

TEST_F(DoorControls, WhatCannotBeKeptIsToldOnce) {
  std::ofstream(folder_.path("unsaved")) << "a file where the folder would be";
  Recovery recovery(folder_.path("unsaved"));
  EXPECT_FALSE(recovery.keep("{}", "scene.json"));
  EXPECT_TRUE(recovery.keep("", ""));
  EXPECT_TRUE(recovery.keep("{ }", "scene.json")) << "it was told";
}

TEST_F(DoorControls, TheAxesTurnTheCamera) {
  script_->input().width = 900, script_->input().height = 1500;
  open("blob.npy");
  const std::pair<const char*, Vec3> kSides[] = {
      {"axis +x", Vec3::UnitX()},  {"axis -x", -Vec3::UnitX()}, {"axis +y", Vec3::UnitY()},
      {"axis -y", -Vec3::UnitY()}, {"axis +z", Vec3::UnitZ()},  {"axis -z", -Vec3::UnitZ()}};
  for (const auto& [name, side] : kSides) {
    SCOPED_TRACE(name);
    app().view().camera().set({Vec3(2, -3, 1.5), Vec3(0.5, 0.5, 0.5)});  // none is behind another
    script_->frames(3);
    const double away = (app().view().camera().eye() - app().view().camera().pivot()).norm();
    ASSERT_TRUE(script_->click(name));
    script_->frames(2);
    const Vec3 eye = app().view().camera().eye() - app().view().camera().pivot();
    EXPECT_NEAR((eye - away * side).norm(), 0, 1e-6);
  }
}

TEST_F(DoorControls, KeysLookAlongTheAxes) {
  open("blob.npy");
  script_->press(Key::k1);
  EXPECT_NEAR((app().view().camera().forward() - Vec3::UnitY()).norm(), 0, 1e-9);
  script_->press(Key::k3);
  EXPECT_NEAR((app().view().camera().forward() + Vec3::UnitX()).norm(), 0, 1e-9);
  script_->press(Key::k7);
  EXPECT_NEAR((app().view().camera().forward() + Vec3::UnitZ()).norm(), 0, 1e-9);
  script_->press(Key::k1, true);
  EXPECT_NEAR((app().view().camera().forward() + Vec3::UnitY()).norm(), 0, 1e-9);
}

TEST_F(DoorControls, TheProbeSaysWhatIsUnderThePointer) {
  open("blob.npy");
  ASSERT_TRUE(script_->settle());
  const auto insets = app().view().insets(kNarrow);
  const auto middle =
      app().view().camera().camera(kNarrow, kHigh).project(app().view().camera().pivot());
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->x(), 0.5 * (insets.left + kNarrow - insets.right), 2)
      << "it is framed between the panels";
  const auto probe = app().tools().pointer.probeAt(middle->x(), middle->y());
  ASSERT_TRUE(probe);
  EXPECT_FALSE(probe->onSurface);
  ASSERT_EQ(probe->media.size(), 1);
  EXPECT_GT(probe->media[0].emission[0], 0.5) << "the blob's middle has 1";
  EXPECT_FALSE(app().tools().pointer.probeAt(2, 2)) << "there is nothing";
  script_->press(Key::kP);
  EXPECT_TRUE(app().settings().probe);
  script_->move(middle->x(), middle->y());
  script_->press(Key::kEscape);
  EXPECT_FALSE(app().settings().probe);
}

/// With what their files call them.
TEST_F(DoorControls, AllFieldsAreReadUnderThePointer) {
  const auto fieldsAt = [&](const std::string& file, const Vec3& place) {
    open(file);
    for (int i = 0; i < 3; ++i) {
      app().document().fieldsAt(place);
      load();
    }
    std::map<std::string, std::pair<double, std::string>> all;
    const LoadedFields* read = app().document().fieldsAt(place);
    if (!read || !read->fields || !(read->place == place))
      return all;
    for (const PlaceFields& medium : *read->fields) {
      for (const ProbedField& field : medium.fields)
        all[field.name] = {field.values[0], field.unit};
    }
    return all;
  };
  auto blob = fieldsAt("blob.npy", {0.35, 0.45, 0.45});
  ASSERT_EQ(blob.size(), 1);
  EXPECT_GT(blob.begin()->second.first, 0.7) << "1 in the middle";
  auto room = fieldsAt("soot.smv", {0.5, 0.5, 0.5});
  ASSERT_TRUE(room.contains("SOOT DENSITY"));
  EXPECT_NEAR(room["SOOT DENSITY"].first, 1e-4 * linear(0.5, 0.5, 0.5), 1e-5);
  EXPECT_EQ(room["SOOT DENSITY"].second, "kg/m3");
  auto mesh = fieldsAt("smoke.json", {3, 3, 1.5});
  ASSERT_TRUE(mesh.contains("smoke"));
  EXPECT_NEAR(mesh["smoke"].first, 5e-5 * 0.7, 5e-6);
  EXPECT_EQ(mesh["smoke"].second, "kg/m3");
  auto fog = fieldsAt("fog.json", {6, 4, 2});
  EXPECT_GT(fog["extinction"].first, 0.05);
  EXPECT_EQ(fog["extinction"].second, "1/m");
  // In the window, whatever the pointer comes to.
  open("blob.npy");
  ASSERT_TRUE(script_->settle());
  const auto middle =
      app().view().camera().camera(kNarrow, kHigh).project(app().view().camera().pivot());
  ASSERT_TRUE(script_->click("Values"));
  script_->move(middle->x(), middle->y());
  load();
  const auto probe = app().tools().pointer.probeAt(middle->x(), middle->y());
  ASSERT_TRUE(probe);
  const LoadedFields* read = app().document().fieldsAt(probe->inside);
  ASSERT_NE(read, nullptr);
  EXPECT_EQ(read->place, probe->inside) << "it was asked for by the panel";
}

TEST_F(DoorControls, ADoubleClickIsThePivot) {
  open("smoke.json");
  ASSERT_TRUE(script_->settle());
  const double x = 0.5 * kNarrow, y = 0.8 * kHigh;
  const auto ground = app().tools().pointer.probeAt(x, y);
  ASSERT_TRUE(ground);
  script_->move(x, y);
  script_->input().twice = true;
  script_->frame();
  EXPECT_NEAR((app().view().camera().pivot() - ground->place).norm(), 0, 1e-9);
  const auto before = app().view().camera().camera(kNarrow, kHigh).project(ground->place);
  app().view().camera().drag(40, 10);
  const auto after = app().view().camera().camera(kNarrow, kHigh).project(ground->place);
  EXPECT_NEAR((*before - *after).norm(), 0, 1e-6) << "it stays under the pointer";
}

TEST_F(DoorControls, TheCameraIsCopiedAsJson) {
  open("blob.npy");
  std::string clipboard;
  app().window().clipboard().use([&] { return clipboard; },
                                 [&](const std::string& text) { clipboard = text; });
  script_->press(Key::kC, true);
  const auto camera = nlohmann::json::parse(clipboard);
  EXPECT_NEAR(camera["eye"][0].get<double>(), app().view().camera().eye().x(), 1e-9);
  EXPECT_TRUE(camera.contains("fov"));
}

TEST_F(DoorControls, AScreenshotHasNoPanels) {
  open("blob.npy");
  ASSERT_TRUE(script_->settle());
  const Image with = viewer_->picture();
  app().settings().panels = false;
  const Image without = viewer_->screenshot();
  EXPECT_GT(difference(with, without), 0.1);
  app().settings().panels = true;
}

TEST_F(DoorControls, AReportSaysWhatWasShownWhileOneGoesOn) {
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(std::filesystem::path(folder_.path("x")).parent_path());
  open("fog.json");
  script_->press(Key::kF12, true);
  ASSERT_NE(app().report().job(), nullptr);
  const std::string page = app().report().job()->target().string();
  // A change after the request is not in it.
  const auto& parameters = app().document().info()->parameters;
  const auto degree = std::ranges::find(parameters, "/media/0/sigma_max", &Parameter::path);
  ASSERT_NE(degree, parameters.end());
  EXPECT_EQ(degree->value[0], 0.4);
  app().document().set(*degree, {0.1});
  for (int i = 0; i < 2000 && app().report().job(); ++i) {
    script_->frame();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  std::filesystem::current_path(before);
  ASSERT_EQ(app().report().job(), nullptr);
  EXPECT_THAT(app().document().message(), ::testing::HasSubstr("volute_0001.html is written"));
  std::ifstream stream(page);
  const std::string text((std::istreambuf_iterator<char>(stream)), {});
  for (const char* part : {"data:image/png;base64", "map.png", "SHA-256", "/media/0/sigma_max",
                           ">0.4 ", "<td>eye</td>"})
    EXPECT_THAT(text, ::testing::HasSubstr(part));
  EXPECT_FALSE(std::filesystem::exists(folder_.path("volute_0001.picture.png")));
}

TEST_F(DoorControls, AReportIsMadeByItsButtonAndStoppedByEscape) {
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(std::filesystem::path(folder_.path("x")).parent_path());
  open("blob.npy");
  ASSERT_TRUE(script_->click("Report"));
  ASSERT_NE(app().report().job(), nullptr);
  script_->press(Key::kEscape);
  EXPECT_EQ(app().report().job(), nullptr);
  std::filesystem::current_path(before);
}

TEST(ReportJob, LeavesNoPageWhereItWasStoppedOrFindsNoRoom) {
  const SceneFolder folder;
  const auto target = folder.path("volute_0001.html");
  {
    ReportJob job({target, Image(4, 4)});
    job.stop();
    job.begin({}, {folder.path("blob.npy")});
  }
  EXPECT_FALSE(std::filesystem::exists(target));
  ReportJob job({folder.path("gone/volute_0001.html"), Image(4, 4)});
  job.begin({}, {folder.path("blob.npy")});
  while (!job.done()) std::this_thread::yield();
  ASSERT_FALSE(job.status());
  EXPECT_THAT(job.status().error().message, ::testing::HasSubstr("gone/volute_0001"));
}

}  // namespace
}  // namespace volute
