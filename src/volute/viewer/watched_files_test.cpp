// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/watched_files.hpp"

#include "volute/viewer/controls_testing.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::IsSupersetOf;
using Path = std::filesystem::path;

class WatchedFiles : public Controls {
 protected:
  Path in(const std::string& name) const { return folder_.path(name); }

  /// As if another program had written it.
  void replace(const std::string& name, const std::string& by) {
    std::filesystem::copy_file(in(by), in(name), std::filesystem::copy_options::overwrite_existing);
    std::filesystem::last_write_time(in(name),
                                     std::filesystem::last_write_time(in(name)) + clock_++);
  }

  /// The picture is another after a while.
  void expectAnother(const Image& shown) {
    const int opened = app().document().info()->opened;
    for (int i = 0; i < 20000 && app().document().info()->opened == opened; ++i) {
      script_->frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    load();
    EXPECT_EQ(app().document().error(), "");
    EXPECT_GT(difference(shown, picture()), 0.0005);
  }
};

TEST_F(WatchedFiles, ThoseOfACollection) {
  EXPECT_THAT(filesOf(folder_.path("smoke.pvd")),
              ElementsAre(in("smoke.pvd"), in("smoke.vtu"), in("more.vtu")));
  std::ofstream(in("odd.pvd")) << "<DataSet timestep='0' file='a&amp;b.vtu'/><DataSet file=\"\"/>"
                                  "<DataSet file=\"torn.vtu";
  EXPECT_THAT(filesOf(folder_.path("odd.pvd")), ElementsAre(in("odd.pvd"), in("a&b.vtu")));
  EXPECT_THAT(filesOf(folder_.path("missing.pvd")), ElementsAre(in("missing.pvd")));
}

TEST_F(WatchedFiles, ThoseOfAPatternAndTheNext) {
  for (const char* name : {"m_07.png", "m_08.png"}) std::ofstream(in(name)) << "x";
  EXPECT_THAT(filesOf(folder_.path("m_%02d.png")),
              ElementsAre(in("m_07.png"), in("m_08.png"), in("m_09.png")));
  EXPECT_THAT(filesOf(folder_.path("none_%02d.png")), ElementsAre(in("none_%02d.png")));
}

TEST_F(WatchedFiles, ThoseOfAnFdsCaseThatIsStillComputed) {
  EXPECT_THAT(filesOf(folder_.path("room.smv")), ElementsAre(in("room.smv"), in("room_1.s3d")));
  open("room.smv");
  const int opened = app().document().info()->opened;
  const std::vector<std::uint8_t> some(fdswriter::atNodes(kFirst, linear).size(), 20);
  fdswriter::smokeFile(cellsOf(kFirst), {{0, some}, {5, some}, {10, some}})
      .save(folder_.path("longer.s3d"));
  replace("room_1.s3d", "longer.s3d");
  for (int i = 0; i < 20000 && app().document().info()->opened == opened; ++i) {
    script_->frame();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  load();
  EXPECT_EQ(app().document().error(), "");
  EXPECT_EQ(app().playback().timeline().last(), 10);
}

TEST_F(WatchedFiles, AStepOfSmokeIsReadAgain) {
  open("smoke.pvd");
  script_->click("time", 0.99);
  load();
  const Image shown = picture();
  replace("more.vtu", "smoke.vtu");
  expectAnother(shown);
}

TEST_F(WatchedFiles, APictureOnASignIsReadAgain) {
  for (const auto& [name, value] : {std::pair{"dark.png", 0.1F}, {"sign.png", 0.9F}}) {
    Image picture(4, 2);
    std::ranges::fill(picture.pixels, value);
    ASSERT_TRUE(writeImage(folder_.path(name), picture));
  }
  std::ofstream(in("signs.json")) << R"({"format": "volute-scene-1",
    "camera": {"eye": [0, -3, 0], "target": [0, 0, 0], "fov": 40},
    "signs": [{"position": [0, 0, 0], "normal": [0, -1, 0], "size": [1.6, 0.8], "picture": "sign.png"}]})";
  open("signs.json");
  const Image shown = picture();
  replace("sign.png", "dark.png");
  expectAnother(shown);
}

TEST_F(WatchedFiles, AMapOfAPatternIsReadAgain) {
  std::filesystem::copy_file(in("map.png"), in("fog_01.png"));
  std::filesystem::copy_file(in("map.png"), in("fog_02.png"));
  Image white(14, 10, 1);
  std::ranges::fill(white.pixels, 0.9F);
  ASSERT_TRUE(writeMap(folder_.path("white.png"), white));
  std::ofstream(in("drift.json")) << R"({"format": "volute-scene-1",
    "camera": {"eye": [-9, -12, 11], "target": [7, 5, 0], "fov": 45}, "background": [0.2, 0.1, 0.05],
    "media": [{"kind": "fog", "map": "fog_%02d.png", "cell": 1, "sigma_max": 0.4, "degree": 1,
               "profile": {"kind": "slab", "bottom": 0, "top": 4}}]})";
  open("drift.json");
  const Image shown = picture();
  replace("fog_01.png", "white.png");
  expectAnother(shown);
  script_->input().height = 1900;  // room for all that it has
  script_->frames(3);
  for (const auto& [path, across] : {std::pair{"/media/0/time/offset", 0.3},
                                     {"/media/0/time/rate", 0.2},
                                     {"/media/0/time/loop", 0.05}}) {
    const auto before = valueOf(path);
    ASSERT_TRUE(script_->click(path, across)) << path;
    load();
    EXPECT_NE(valueOf(path), before) << path;
  }
}

}  // namespace
}  // namespace volute
