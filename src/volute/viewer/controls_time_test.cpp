// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The viewer's clock and its films.
#include <sys/resource.h>

#include <csignal>
#include <functional>
#include <numbers>

#include "volute/io/film.hpp"
#include "volute/viewer/controls_testing.hpp"

namespace volute {
namespace {

class TimeControls : public Controls {
 protected:
  /// From the beginning, by so many frames of a sixtieth of a second: how far it comes [s].
  double played(int count) {
    app().playback().timeline().seek(0);
    EXPECT_TRUE(script_->click("Play"));
    EXPECT_TRUE(app().playback().timeline().playing());
    const double begun = app().playback().timeline().time();
    script_->frames(count);
    const double time = app().playback().timeline().time() - begun;
    EXPECT_TRUE(script_->click("Play"));
    EXPECT_FALSE(app().playback().timeline().playing());
    return time;
  }

  /// Writes a slider's number.
  void writeNumber(const std::string& control, const std::string& number) {
    script_->input().control = true;
    ASSERT_TRUE(script_->click(control));
    script_->input().control = false;
    script_->press(Key::kA, true);
    script_->type(number);
    script_->press(Key::kEnter);
  }

  struct Film {
    int width = 0, height = 0, frames = 0;
    Image last{};
    bool changes = false;  ///< its pictures are not all the same
  };

  Film filmOf(const std::string& name) {
    auto reader = FilmReader::open(folder_.path(name));
    EXPECT_TRUE(reader) << reader.error().message;
    if (!reader)
      return {};
    Film film{reader->info().width, reader->info().height};
    EXPECT_NEAR(reader->info().framesPerSecond, 25, 1e-6);
    for (auto next = reader->next(); next && *next; next = reader->next()) {
      film.changes = film.changes || (film.frames > 0 && difference(film.last, **next) > 0.01);
      film.last = std::move(**next);
      ++film.frames;
    }
    return film;
  }

  void waitForFilm() {
    while (app().playback().film()) load();
    script_->frame();  // the film's controls are back
    EXPECT_THAT(app().document().message(), ::testing::HasSubstr("is written"));
  }
};

TEST_F(TimeControls, ThePictureChangesWhileItPlays) {
  open("room.smv");  // of 5 s
  ASSERT_TRUE(script_->settle());
  script_->input().seconds = 0;
  ASSERT_TRUE(script_->click("Play"));
  ASSERT_TRUE(app().playback().timeline().playing());
  app().settings().panels = false;
  // What moves is drawn as fast as it can be, and differs from what rests.
  const auto until = [&](const auto& holds) {
    for (int i = 0; i < 20'000 && !holds(); ++i) {
      script_->frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return holds();
  };
  int drawn = 0;
  Image shown;
  ASSERT_TRUE(until([&] {
    const Image now = viewer_->picture();
    drawn = drawn > 0 && difference(now, shown) == 0 ? drawn + 1 : 1;
    shown = now;
    return drawn > 100;
  })) << "it stays while no time passes";
  script_->input().seconds = 0.5;
  while (app().playback().timeline().time() < 5) script_->frame();
  script_->input().seconds = 0;
  EXPECT_TRUE(until([&] { return difference(shown, viewer_->picture()) > 0.02; }));
  ASSERT_TRUE(app().playback().timeline().playing());
  app().settings().panels = true;
  script_->frames(3);
  ASSERT_TRUE(script_->click("Play"));
  script_->input().seconds = 1;
  const double time = app().playback().timeline().time();
  script_->frames(3);
  EXPECT_EQ(app().playback().timeline().time(), time) << "it is paused";
}

TEST_F(TimeControls, AtTwiceTheSpeedItComesTwiceAsFar) {
  constexpr int kFrames = 30;
  open("room.smv");
  ASSERT_NO_FATAL_FAILURE(openMore());
  ASSERT_NO_FATAL_FAILURE(writeNumber("speed", "1"));
  EXPECT_NEAR(played(kFrames), kFrames / 60.0, 1e-9);
  ASSERT_NO_FATAL_FAILURE(writeNumber("speed", "2"));
  EXPECT_EQ(app().playback().timeline().speed(), 2);
  EXPECT_NEAR(played(kFrames), 2 * kFrames / 60.0, 1e-9);
}

TEST_F(TimeControls, AFilmIsMadeBesideTheWindowOrNotAtAll) {
  open("smoke.pvd");
  ASSERT_NO_FATAL_FAILURE(openMore());
  ASSERT_TRUE(script_->choose("film size", "640 x 360"));
  ASSERT_TRUE(script_->write("film", folder_.path("film.mp4")));
  ASSERT_TRUE(script_->click("Make film"));
  if (!app().playback().film() && !app().playback().filmFailure().empty())
    GTEST_SKIP() << app().playback().filmFailure();
  script_->frames(3);
  ASSERT_TRUE(app().playback().film());
  double x = 0, y = 0;
  ASSERT_TRUE(script_->pointOf("Cancel film", 0.5, 0.5, x, y));
  ASSERT_TRUE(script_->click("Cancel film"));
  script_->frames(2);
  EXPECT_FALSE(app().playback().film());
  script_->clickAt(x, y);  // too late
  script_->frames(2);
  EXPECT_FALSE(app().playback().film());
  EXPECT_FALSE(std::filesystem::exists(folder_.path("film.mp4")));
  ASSERT_TRUE(script_->click("film around"));
  EXPECT_TRUE(app().settings().filmTurns);
  ASSERT_TRUE(script_->click("Make film"));
  waitForFilm();
  const Film film = filmOf("film.mp4");
  EXPECT_EQ(film.frames, 251) << "10 s around what moves for 0.2 s";
  EXPECT_TRUE(film.changes);
}

/// As on a disk that is full: no file may become larger.
TEST_F(TimeControls, AFilmThatFindsNoRoomSaysSoAndLeavesNoFile) {
  open("smoke.pvd");
  app().settings().filmName = folder_.path("full.mp4");
  app().settings().filmSize = 0;
  struct rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = ::signal(SIGXFSZ, SIG_IGN);
  const struct rlimit small{100, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  app().beginFilm(script_->input());
  for (int i = 0; i < 20000 && app().playback().film(); ++i) {
    script_->frame();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  ::signal(SIGXFSZ, handler);
  EXPECT_EQ(app().playback().film(), nullptr);
  EXPECT_THAT(app().playback().filmFailure(), ::testing::HasSubstr("full.mp4"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path("full.mp4")));
  const Image shown = picture();
  EXPECT_GT(shown.width, 0) << "the window goes on";
}

TEST_F(TimeControls, AFilmOnceAroundIsMadeOfAStillToo) {
  open("smoke.vtu");
  app().settings().filmName = folder_.path("around.mp4");
  app().settings().filmSize = 0;
  script_->press(Key::kF3);
  script_->frames(2);
  ASSERT_TRUE(script_->click("search"));
  script_->type("once around");
  script_->press(Key::kEnter);
  if (!app().playback().film() && !app().playback().filmFailure().empty())
    GTEST_SKIP() << app().playback().filmFailure();
  script_->frames(3);
  ASSERT_TRUE(app().playback().film());
  const FilmOrder& order = app().playback().film()->order();
  EXPECT_EQ(order.frames(), 251) << "10 s";
  const ViewCamera& begin = order.camera;
  EXPECT_EQ(order.cameraOf(0), begin);
  const Vec3 middle = begin.pivot(), axis = begin.view().up;
  const auto level = [&](int frame) {
    const Vec3 arm = order.cameraOf(frame).eye() - middle;
    return Vec3(arm - arm.dot(axis) * axis);
  };
  const double angle = std::numbers::pi * 2 * 125 / 251;
  EXPECT_NEAR(level(125).normalized().dot(level(0).normalized()), std::cos(angle), 1e-9);
  EXPECT_NEAR(level(125).norm(), level(0).norm(), 1e-9);
  app().playback().cancelFilm();
}

TEST_F(TimeControls, AroundWhatMovesBrieflyTakesItsTimesAgain) {
  FilmOrder order;
  order.begin = 2, order.end = 2.5, order.length = 10;
  EXPECT_EQ(order.frames(), 251);
  EXPECT_EQ(order.timeOf(0), 2);
  EXPECT_NEAR(order.timeOf(5), 2.2, 1e-9);
  EXPECT_NEAR(order.timeOf(15), 2.1, 1e-9);
  order.end = 2;
  EXPECT_EQ(order.timeOf(100), 2);
  open("room.smv");  // of 5 s
  app().settings().filmName = folder_.path("around.mp4");
  app().settings().filmTurns = true;
  app().playback().timeline().setSpeed(4);
  app().beginFilm(script_->input());
  if (!app().playback().film() && !app().playback().filmFailure().empty())
    GTEST_SKIP() << app().playback().filmFailure();
  ASSERT_TRUE(app().playback().film());
  EXPECT_EQ(app().playback().film()->order().frames(), 251) << "10 s, not 1.25";
  app().playback().cancelFilm();
}

TEST_F(TimeControls, ACameraPathIsSetByKeysPlayedFilmedAndSaved) {
  open("smoke.vtu");  // which rests
  EXPECT_FALSE(app().playback().timeline().moves());
  std::vector<Vec3> eyes;
  for (const double turn : {0.0, 0.5, 1.2}) {
    app().view().camera().turn(turn);
    eyes.push_back(app().view().camera().eye());
    if (turn == 0)
      EXPECT_TRUE(script_->click("Camera key"));
    else
      script_->press(Key::kK);
    load();
  }
  const auto& keys = app().view().cameraPath().keys();
  ASSERT_EQ(keys.size(), 3);
  EXPECT_EQ(keys[1].time, 2) << "two seconds apart";
  EXPECT_EQ(app().playback().timeline().last(), 4) << "it plays now";
  EXPECT_TRUE(app().document().info()->changed);
  app().playback().timeline().seek(2);
  script_->frames(2);
  EXPECT_LT((app().view().camera().eye() - eyes[1]).norm(), 1e-9) << "the camera goes along";
  app().playback().timeline().seek(1);
  script_->frames(2);
  const Vec3 between = app().view().camera().eye();
  EXPECT_GT((between - eyes[0]).norm(), 1e-3);
  EXPECT_GT((between - eyes[1]).norm(), 1e-3);
  app().settings().filmName = folder_.path("along.mp4");
  app().settings().filmSize = 0;
  ASSERT_NO_FATAL_FAILURE(openMore());
  ASSERT_TRUE(script_->has("film path"));
  app().beginFilm(script_->input());
  if (app().playback().film()) {
    const FilmOrder order = app().playback().film()->order();
    app().playback().cancelFilm();
    EXPECT_EQ(order.frames(), 101) << "4 s";
    EXPECT_LT((order.cameraOf(25).eye() - between).norm(), 1e-9);
    EXPECT_LT((order.cameraOf(100).eye() - eyes[2]).norm(), 1e-9);
  }
  ASSERT_TRUE(script_->click("film path"));
  app().playback().timeline().seek(3);
  script_->frames(2);
  EXPECT_EQ(app().view().camera().eye(), between) << "it stays";
  app().saveScene();
  load();
  app().document().undo();
  load();
  EXPECT_EQ(app().view().cameraPath().keys().size(), 2);
  app().settings().follows = true;
  app().playback().timeline().seek(2);
  script_->press(Key::kK, true);
  load();
  EXPECT_EQ(app().view().cameraPath().keys().size(), 1);
  open("smoke.vtu.json");
  EXPECT_EQ(app().view().cameraPath().keys().size(), 3);
  app().playback().timeline().seek(0);
  script_->frames(2);
  EXPECT_LT((app().view().camera().eye() - eyes[0]).norm(), 1e-9) << "where the path begins";
}

/// By the pictures that it drew before.
TEST_F(TimeControls, AFilmThatWasStoppedGoesOn) {
  open("smoke.pvd");
  ASSERT_TRUE(script_->settle());
  const auto begin = [&](const std::string& name) {
    FilmOrder order;
    order.target = folder_.path(name);
    order.width = 64, order.height = 48;
    order.end = app().playback().timeline().last();
    order.camera = app().view().camera();
    order.folder = folder_.path("films");
    order.slow = 0;
    app().playback().beginFilm(order, app().view().picture().makers());
  };
  const auto kept = [&] {
    std::error_code none;
    std::size_t count = 0;
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(folder_.path("films"), none))
      count += entry.path().extension() == ".png";
    return count;
  };
  begin("film.mp4");
  if (!app().playback().film())
    GTEST_SKIP() << app().playback().filmFailure();
  while (app().playback().film() && kept() < 3) script_->frame();
  ASSERT_TRUE(app().playback().film());
  app().playback().cancelFilm();
  EXPECT_THAT(app().document().message(), ::testing::HasSubstr("goes on"));
  EXPECT_GE(kept(), 3U);
  const ViewCamera there = app().view().camera();
  app().view().camera().turn(0.3);
  begin("film.mp4");
  while (app().playback().film() && app().playback().film()->share() == 0) script_->frame();
  ASSERT_TRUE(app().playback().film());
  EXPECT_EQ(app().playback().film()->resumed(), 0) << "of another view";
  app().playback().cancelFilm();
  app().view().camera() = there;
  begin("film.mp4");
  waitForFilm();
  EXPECT_THAT(app().document().message(), ::testing::HasSubstr("pictures were kept"));
  EXPECT_EQ(filmOf("film.mp4").frames, 6);
}

/// Whatever a person does to the scene while a film of it is made.
TEST_F(TimeControls, AFilmShowsTheSceneAsItWasWhenItWasAskedFor) {
  using Act = std::function<void()>;
  const Act setFog = [&] { app().document().set(parameterAt("/media/0/sigma_max"), {0.01}); };
  const std::pair<const char*, Act> kActs[] = {
      {"nothing", [] {}},
      {"a slider", setFog},
      {"the exposure", [&] { app().settings().look.stops = 4; }},
      {"another renderer", [&] { app().settings().look.renderer = 2; }},
      {"the view", [&] { app().view().lookFrom(Vec3::UnitZ()); }},
      {"the time", [&] { app().playback().timeline().seek(app().playback().timeline().first()); }},
      {"a light is added", [&] { app().tools().pointer.add(SceneEdit::Kind::kAddSpot); }},
      {"a change is taken back",
       [&] {
         setFog();
         load();
         app().document().undo();
         app().document().redo();
       }},
      {"fog is painted",
       [&] {
         app().tools().painting.tool().painter().fill(0.3);
         app().tools().painting.send();
       }},
      {"another file", [&] { app().open(folder_.path("smoke.json")); }},
  };
  std::ofstream(folder_.path("windy.json")) << R"({"format": "volute-scene-1",
    "camera": {"eye": [-9, -12, 11], "target": [7, 5, 0], "fov": 45}, "background": [0.2, 0.1, 0.05],
    "media": [{"kind": "fog", "map": "map.png", "cell": 1, "sigma_max": 0.4, "degree": 1,
               "wind": [1, 0.5], "profile": {"kind": "slab", "bottom": 0, "top": 4}}]})";
  std::vector<Image> still;
  for (const auto& [what, act] : kActs) {
    SCOPED_TRACE(what);
    open("windy.json");
    ASSERT_NO_FATAL_FAILURE(openMore());
    app().playback().timeline().setSpeed(40);
    app().settings().look.stops = 0;
    app().settings().look.renderer = 0;
    app().settings().filmSize = 0;
    app().settings().filmName = folder_.path(fmt::format("{}.mp4", still.empty() ? "still" : what));
    ASSERT_TRUE(script_->settle());
    app().beginFilm(script_->input());
    if (!app().playback().film() && !app().playback().filmFailure().empty())
      GTEST_SKIP() << app().playback().filmFailure();
    act();
    waitForFilm();
    auto reader = FilmReader::open(app().settings().filmName);
    ASSERT_TRUE(reader) << reader.error().message;
    std::vector<Image> film;
    for (auto next = reader->next(); next && *next; next = reader->next())
      film.push_back(std::move(**next));
    if (still.empty())
      still = film;
    ASSERT_EQ(film.size(), still.size());
    ASSERT_GT(film.size(), 5U);
    for (std::size_t i = 0; i < film.size(); ++i)
      EXPECT_LT(difference(film[i], still[i]), 0.02) << "picture " << i;
  }
}

TEST_F(TimeControls, AFilmHasItsSizeAndSpeed) {
  open("smoke.pvd");
  ASSERT_NO_FATAL_FAILURE(openMore());

  const struct {
    const char *size, *speed;
    int width, height, frames;
  } kFilms[] = {{"640 x 360", "1", 640, 360, 6},
                {"1280 x 720", "2", 1280, 720, 3},
                {"1920 x 1080", "10", 1920, 1080, 1},
                {"window", "10", kNarrow, kHigh, 1}};

  for (const auto& [size, speed, width, height, frames] : kFilms) {
    SCOPED_TRACE(size);
    const std::string name = std::string(size).substr(0, 4) + ".mp4";
    ASSERT_TRUE(script_->choose("film size", size));
    ASSERT_NO_FATAL_FAILURE(writeNumber("speed", speed));
    ASSERT_TRUE(script_->write("film", folder_.path(name)));
    ASSERT_TRUE(script_->click("Make film"));
    if (!app().playback().film() && !app().playback().filmFailure().empty())
      GTEST_SKIP() << app().playback().filmFailure();
    waitForFilm();
    const Film film = filmOf(name);
    EXPECT_EQ(film.width, width);
    EXPECT_EQ(film.height, height);
    EXPECT_EQ(film.frames, frames) << "0.2 s at this speed, 25 pictures a second";
    EXPECT_EQ(film.last.width, width);
  }
}

}  // namespace
}  // namespace volute
