// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/clocks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "volute/capture/capture_images.hpp"
#include "volute/capture/testing.hpp"
#include "volute/io/film.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using testing::failsWith;
using ::testing::HasSubstr;
using testing::kHeight;
using testing::kWidth;
using testing::ok;
using testing::sentences;

TEST(PicturePlace, IsWhereTheTimeLies) {
  PictureSource pictures;
  EXPECT_EQ(pictures.placeOf(7).number, 7);
  EXPECT_EQ(pictures.placeOf(7).share, 0);
  pictures.videoStart = 2.5, pictures.rate = 2;  // picture 0 between frames 2 and 3
  EXPECT_EQ(pictures.placeOf(4).number, 3);
  EXPECT_EQ(pictures.placeOf(4).share, 0);
  EXPECT_EQ(pictures.placeOf(2).number, -1);
  pictures.rate = 0.5;
  EXPECT_EQ(pictures.placeOf(4).number, 0);
  EXPECT_DOUBLE_EQ(pictures.placeOf(4).share, 0.75);
  pictures = {};
  pictures.frameShift = -0.25;
  EXPECT_EQ(pictures.placeOf(4).number, 3);
  EXPECT_DOUBLE_EQ(pictures.placeOf(4).share, 0.75);
  pictures.frameShift = 0.004;  // a hundredth of a frame is no other picture
  EXPECT_EQ(pictures.placeOf(4).number, 4);
  EXPECT_EQ(pictures.placeOf(4).share, 0);
}

/// Two cameras with films of a wall that gets brighter evenly, of light `brightness(time)`.
class ClocksTest : public ::testing::Test {
 protected:
  static double brightness(double seconds) { return 0.1 + 1.5 * seconds; }

  /// @param start  [s] of its first picture.
  /// @return false where films cannot be written.
  bool writeFilm(const std::string& name, double start, double rate, int pictures) {
    const auto writer = FilmWriter::create(folder_ / name, kWidth, kHeight, rate);
    if (!writer)
      return false;
    for (int i = 0; i < pictures; ++i) {
      Image image(kWidth, kHeight);
      std::ranges::fill(image.pixels, static_cast<float>(brightness(start + i / rate)));
      EXPECT_TRUE(ok((*writer)->addFrame(image)));
    }
    EXPECT_TRUE(ok((*writer)->finish()));
    return true;
  }

  /// The same as .webm, with pictures at these times [ms], ascending from 0.
  bool writeUnevenFilm(const std::string& name, const std::vector<int>& times) {
    const auto writer = FilmWriter::create(folder_ / name, kWidth, kHeight, 25);
    if (!writer)
      return false;
    for (const int time : times) {
      Image image(kWidth, kHeight);
      std::ranges::fill(image.pixels, static_cast<float>(brightness(time * 1e-3)));
      EXPECT_TRUE(ok((*writer)->addFrame(image)));
    }
    EXPECT_TRUE(ok((*writer)->finish()));
    // A block begins with A3, its size, the track 81, its time in two bytes and flags.
    std::string bytes = testing::readBytes(folder_ / name);
    std::size_t at = 0;
    for (std::size_t i = 0; i < times.size(); ++i) {
      const auto time = static_cast<int>(40 * i);
      const std::string head = {'\x81', static_cast<char>(time >> 8), static_cast<char>(time)};
      do at = bytes.find(head, at + 1);
      while (at != bytes.npos && bytes.find('\xA3', at - 5) > at);
      if (at == bytes.npos)
        return false;
      bytes[at + 1] = static_cast<char>(times[i] >> 8), bytes[at + 2] = static_cast<char>(times[i]);
    }
    testing::writeBytes(folder_ / name, bytes);
    return true;
  }

  /// A capture of cameras a and b with these films.
  nlohmann::json captureOf(const std::string& a, const std::string& b) {
    nlohmann::json json = testing::ringJson();
    json["cameras"].erase(2);
    json.erase("frames");
    json["color"] = "srgb";
    const std::array<std::string, 2> films{a, b};
    for (std::size_t i = 0; i < 2; ++i) {
      json["cameras"][i].erase("image");
      json["cameras"][i]["video"] = films[i];
    }
    return json;
  }

  Result<Capture> opened(const nlohmann::json& json, const FrameRange& frames = {}) {
    testing::writeText(folder_ / "capture.json", json.dump());
    CaptureOptions options;
    options.frames = frames;
    return openCapture(folder_ / "capture.json", options);
  }

  /// The greatest difference of what a camera gives for a frame to what the wall was like then.
  static double offBy(const Capture& capture) {
    Progress progress;
    auto images = CaptureImages::open(capture, 1 << 30, progress);
    EXPECT_TRUE(ok(images));
    double most = 0;
    for (std::size_t camera = 0; camera < 2; ++camera) {
      for (const int frame : capture.frames) {
        const auto picture = images->read(camera, frame);
        EXPECT_TRUE(ok(picture));
        const double truth = brightness(frame / capture.framesPerSecond);
        most = std::max(most, std::abs(picture->radiance.at(9, 7, 1) - truth));
      }
    }
    return most;
  }

  testing::TempFolder folder_;
};

constexpr double kCoding = 0.02;  // what films of 8 bits are off by

TEST_F(ClocksTest, CamerasStartAtDifferentTimesWithDifferentRates) {
  if (!writeFilm("a.mp4", 0, 25, 12) || !writeFilm("b.mp4", 0.07, 50, 20))
    GTEST_SKIP() << "built without films";
  auto json = captureOf("a.mp4", "b.mp4");
  json["cameras"][1]["start_time"] = 0.07;  // frame 1.75
  ASSERT_VALUE(const auto capture, opened(json));
  EXPECT_EQ(capture.framesPerSecond, 25);
  EXPECT_EQ(capture.cameras[0].pictures.rate, 1);
  EXPECT_EQ(capture.cameras[1].pictures.rate, 2);
  EXPECT_THAT(sentences(capture.remarks),
              ::testing::Contains(HasSubstr("a 25, b 50 pictures a second")));
  // b ends at 0.07 + 19/50 s, which is frame 11.25.
  EXPECT_THAT(capture.frames, ElementsAre(2, 3, 4, 5, 6, 7, 8, 9, 10, 11));
  EXPECT_TRUE(checkPicturesThere(capture));
  EXPECT_LT(offBy(capture), kCoding);
  // Taken picture by picture, as before, they do not agree.
  json["cameras"][0]["frames_per_second"] = 25;
  json["cameras"][1]["frames_per_second"] = 25;
  ASSERT_VALUE(const auto wrong, opened(json));
  EXPECT_GT(offBy(wrong), 4 * kCoding);
}

TEST_F(ClocksTest, UnevenPicturesAreTakenAtTheTimesThatTheFilmStates) {
  if (!writeFilm("a.mp4", 0, 25, 18))
    GTEST_SKIP() << "built without films";
  ASSERT_TRUE(
      writeUnevenFilm("b.webm", {0, 40, 80, 120, 160, 200, 280, 360, 440, 520, 533, 546, 600}));
  const auto json = captureOf("a.mp4", "b.webm");
  ASSERT_VALUE(const auto capture, opened(json));
  EXPECT_THAT(sentences(capture.remarks), ::testing::Contains(HasSubstr("after 0.013 to 0.08 s")));
  EXPECT_EQ(capture.frames.size(), 16U);  // the last at 600 ms
  EXPECT_TRUE(checkPicturesThere(capture));
  EXPECT_LT(offBy(capture), kCoding);
  auto slow = json;
  slow["frames_per_second"] = 250;  // ten times as fast as the films say
  ASSERT_VALUE(const auto taken, opened(slow));
  EXPECT_EQ(taken.cameras[1].pictures.placeInFilm(12), 12);
}

TEST_F(ClocksTest, PartsOfAFrameAreInterpolated) {
  if (!writeFilm("a.mp4", 0, 25, 12) || !writeFilm("b.mp4", -0.026, 25, 12))
    GTEST_SKIP() << "built without films";
  auto json = captureOf("a.mp4", "b.mp4");
  json["cameras"][1]["video_start"] = -0.65;
  ASSERT_VALUE(const auto capture, opened(json));
  EXPECT_EQ(capture.frames.size(), 11U);  // b's last picture is that of frame 10.35
  EXPECT_LT(offBy(capture), kCoding);
  json["cameras"][1]["video_start"] = 0;
  json["cameras"][1]["frame_shift"] = 0.65;
  ASSERT_VALUE(const auto shifted, opened(json));
  EXPECT_LT(offBy(shifted), kCoding);
  ASSERT_VALUE(const auto more, opened(json, {0, 12, 1}));  // of the last frame b has no picture
  EXPECT_TRUE(checkPicturesThere(more));
  json["cameras"][1]["frame_shift"] = 0;
  ASSERT_VALUE(const auto wrong, opened(json));
  EXPECT_GT(offBy(wrong), kCoding);
}

TEST_F(ClocksTest, RatesOfFilmsThatAgreeAreThoseOfTheCapture) {
  if (!writeFilm("a.mp4", 0, 30, 3) || !writeFilm("b.mp4", 0, 29.97, 3))
    GTEST_SKIP() << "built without films";
  const auto json = captureOf("a.mp4", "b.mp4");
  ASSERT_VALUE(const auto capture, opened(json));
  EXPECT_NEAR(capture.framesPerSecond, 30, 0.05);
  EXPECT_EQ(capture.cameras[0].pictures.rate, 1);
  EXPECT_EQ(capture.cameras[1].pictures.rate, 1);
  EXPECT_THAT(capture.frames, ElementsAre(0, 1, 2));
  auto stated = json;
  stated["frames_per_second"] = 240;  // slow motion, which the films do not know
  ASSERT_VALUE(const auto slow, opened(stated));
  EXPECT_EQ(slow.framesPerSecond, 240);
  EXPECT_EQ(slow.cameras[0].pictures.rate, 1);
  EXPECT_THAT(sentences(slow.remarks),
              ::testing::Contains(HasSubstr("the films say 29.97 pictures a second")));
  stated.erase("frames_per_second");  // one of them alone
  stated["cameras"][0]["frames_per_second"] = 30;
  ASSERT_VALUE(const auto same, opened(stated));
  EXPECT_NEAR(same.framesPerSecond, 30, 0.05);
  EXPECT_EQ(same.cameras[1].pictures.rate, 1);
}

TEST_F(ClocksTest, FilmsKeepTheirRatesBesideOneThatIsStated) {
  if (!writeFilm("a.mp4", 0, 25, 12) || !writeFilm("b.mp4", 0, 50, 20))
    GTEST_SKIP() << "built without films";
  auto json = captureOf("a.mp4", "b.mp4");
  json["cameras"][0]["frames_per_second"] = 25;
  ASSERT_VALUE(const auto capture, opened(json));
  EXPECT_EQ(capture.framesPerSecond, 25);
  EXPECT_EQ(capture.cameras[1].pictures.rate, 2);
  EXPECT_LT(offBy(capture), kCoding);
  EXPECT_THAT(sentences(capture.remarks),
              ::testing::Not(::testing::Contains(HasSubstr("state other rates"))));
  json["cameras"][0]["frames_per_second"] = 100;  // slow motion
  ASSERT_VALUE(const auto slow, opened(json));
  EXPECT_EQ(slow.cameras[0].pictures.rate, 2 * slow.cameras[1].pictures.rate);
  EXPECT_THAT(sentences(slow.remarks),
              ::testing::Contains(HasSubstr("which count: a 100, its film 25 pictures a second")));
}

TEST_F(ClocksTest, FramesBeforeZeroAreTold) {
  for (int number = 0; number < 5; ++number) {
    for (const char* name : {"a", "b"})
      ASSERT_TRUE(
          ok(writeImage(folder_ / fmt::format("{}_{}.exr", name, number), Image(kWidth, kHeight))));
  }
  auto json = captureOf("", "");
  for (std::size_t i = 0; i < 2; ++i) {
    json["cameras"][i].erase("video");
    json["cameras"][i]["image"] = i == 0 ? "a_%d.exr" : "b_%d.exr";
  }
  ASSERT_VALUE(const auto plain, opened(json));
  EXPECT_THAT(sentences(plain.remarks), ::testing::Contains(::testing::AllOf(
                                            HasSubstr("no rate is stated: 25 frames"),
                                            HasSubstr("\"frames_per_second\" beside \"frames\""))));
  EXPECT_EQ(plain.frames.size(), 5U);
  json["frames_per_second"] = 25;
  for (std::size_t i = 0; i < 2; ++i) json["cameras"][i]["start_time"] = -0.08;
  ASSERT_VALUE(const auto early, opened(json));
  EXPECT_THAT(early.frames, ElementsAre(0, 1, 2));
  EXPECT_THAT(sentences(early.remarks),
              ::testing::Contains(HasSubstr("frames -2 to -1 are before 0")));
  if (!writeFilm("a.mp4", 0, 25, 5) || !writeFilm("b.mp4", 0, 25, 5))
    GTEST_SKIP() << "built without films";
  json = captureOf("a.mp4", "b.mp4");
  for (std::size_t i = 0; i < 2; ++i) json["cameras"][i]["video_start"] = -2;
  ASSERT_VALUE(const auto films, opened(json));
  EXPECT_THAT(films.frames, ElementsAre(0, 1, 2));
  EXPECT_THAT(sentences(films.remarks),
              ::testing::Contains(HasSubstr("frames -2 to -1 are before 0")));
}

TEST_F(ClocksTest, TheOrderOfCamerasDoesNotMoveTime) {
  if (!writeFilm("a.mp4", 0, 25, 6))
    GTEST_SKIP() << "built without films";
  for (const int number : {3, 4})
    ASSERT_TRUE(ok(writeImage(folder_ / fmt::format("b_{}.exr", number), Image(kWidth, kHeight))));
  auto json = captureOf("a.mp4", "");
  json["cameras"][1].erase("video");
  json["cameras"][1]["image"] = "b_%d.exr";
  ASSERT_VALUE(const auto film, opened(json));
  std::swap(json["cameras"][0], json["cameras"][1]);
  ASSERT_VALUE(const auto files, opened(json));
  EXPECT_EQ(film.frames, files.frames);
  EXPECT_EQ(film.firstFrame, 0);
  EXPECT_EQ(files.firstFrame, 0);
}

TEST_F(ClocksTest, TellsWhatIsWrong) {
  if (!writeFilm("a.mp4", 0, 25, 4) || !writeFilm("b.mp4", 0, 25, 4))
    GTEST_SKIP() << "built without films";
  auto json = captureOf("a.mp4", "b.mp4");
  json["cameras"][1]["start_time"] = 2;
  EXPECT_TRUE(failsWith(opened(json),
                        "The films have no frame in common: that of camera b begins "
                        "with frame 50.0, that of camera a ends with frame 3.0"));
  json["cameras"][1]["video_start"] = 3;
  EXPECT_TRUE(failsWith(opened(json), "cameras[1].start_time: the camera has video_start too"));
  json["cameras"][1].erase("start_time");
  json["cameras"][1]["frames_per_second"] = 0;
  EXPECT_TRUE(failsWith(opened(json), "cameras[1].frames_per_second: is 0; expected 0.001 to"));
}

TEST_F(ClocksTest, FramesThatSomeFilmsLackAreTold) {
  if (!writeFilm("a.mp4", 0, 25, 4) || !writeFilm("b.mp4", 0, 25, 9))
    GTEST_SKIP() << "built without films";
  auto json = captureOf("a.mp4", "b.mp4");
  ASSERT_VALUE(const auto shorter, opened(json));
  EXPECT_EQ(shorter.frames, (std::vector{0, 1, 2, 3}));
  EXPECT_THAT(
      sentences(shorter.remarks),
      ::testing::Contains(HasSubstr("camera a: its film ends with frame 3, others reach frame 8")));
  json["frames"] = {0, 1};
  ASSERT_VALUE(const auto stated, opened(json));
  EXPECT_THAT(sentences(stated.remarks),
              ::testing::Not(::testing::Contains(HasSubstr("its film ends"))));
}

TEST_F(ClocksTest, NumberedFilesHaveClocksToo) {
  for (int number = 0; number < 8; ++number) {
    Image image(kWidth, kHeight);
    // 50 pictures a second, number 0 at 0.01 s.
    std::ranges::fill(image.pixels, static_cast<float>(brightness(0.01 + number / 50.0)));
    for (const char* name : {"a", "b"})
      ASSERT_TRUE(ok(writeImage(folder_ / fmt::format("{}_{}.exr", name, number), image)));
  }
  auto json = captureOf("", "");
  for (std::size_t i = 0; i < 2; ++i) {
    json["cameras"][i].erase("video");
    json["cameras"][i]["image"] = i == 0 ? "a_%d.exr" : "b_%d.exr";
    json["cameras"][i]["frames_per_second"] = 50;
    json["cameras"][i]["start_time"] = 0.01;
  }
  json["frames_per_second"] = 25;
  json["frames"] = {1, 2, 3};
  ASSERT_VALUE(const auto capture, opened(json));
  EXPECT_TRUE(checkPicturesThere(capture));
  EXPECT_LT(offBy(capture), 1e-3);
}

}  // namespace
}  // namespace volute
