// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/write_capture.hpp"

#include <gtest/gtest.h>

#include "volute/capture/open_capture.hpp"
#include "volute/capture/testing.hpp"

namespace volute {
namespace {

TEST(WriteCapture, ReadsAsItWas) {
  const testing::TempFolder folder;
  Capture capture;
  capture.white = 2;
  capture.measured = Measured::kAbsorption;
  capture.noiseSigma = 0.01;
  capture.frames = {3, 5};
  capture.emptyFrames = {1, 2};
  capture.framesPerSecond = 20;
  capture.volume = {{Vec3(-1, -2, 0), Vec3(1, 2, 3)}, {8, 16, 12}};
  Mat3 k;
  k = Mat3(90, 0.5, 31, 0, 91, 25, 0, 0, 1);
  const Camera seen = Camera::pinhole({Vec3(1, -6, 2), Vec3(0, 0, 1)}, 30, 64, 48);
  const Camera camera = *Camera::calibrated(
      {64, 48, k, seen.rotation(), -seen.rotation() * seen.eye(), {-0.05, 0.01, 0, 0.001, 0}, 0.5});
  PictureSource files;
  files.image = (folder / "in" / "a_%04d.png").string();
  files.mask = folder / "in" / "mask.png";
  files.gain = 1.25;
  files.exposure = 3;
  files.exponent = 1.08;
  files.videoStart = 7.5;
  files.response = Response::gamma(2.2);
  PictureSource film;
  film.video = folder / "b.mp4";
  film.videoStart = 4;
  film.frameShift = -2.25;
  film.rate = 1.5;
  film.saturation = 0.9;
  film.response = *Response::table({0, 0.2, 1});
  capture.cameras = {{"a", camera, files, 0.75}, {"b", camera, film}};
  capture.lighting.lamps = {{.direction = Vec3(0, 0.6, -0.8), .light = Rgb(3, 2, 1)},
                            {.sun = false, .position = Vec3(1, 2, 3), .light = Rgb(0, 1, 0)}};
  capture.lighting.albedo = Rgb(0.9, 0.8, 1);
  const auto file = folder / "refined.json";
  ASSERT_TRUE(writeCapture(file, capture));
  const auto read = openCalibration(file, {});
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->remarks.size(), 1U);  // the convention of pixel centres, and no unknown keys
  EXPECT_EQ(read->white, 2);
  EXPECT_EQ(read->framesPerSecond, 20);
  EXPECT_EQ(read->noiseSigma, capture.noiseSigma);
  EXPECT_EQ(read->emptyFrames, capture.emptyFrames);
  EXPECT_EQ(read->volume.resolution, capture.volume.resolution);
  EXPECT_EQ(read->volume.bounds.max, capture.volume.bounds.max);
  ASSERT_EQ(read->cameras.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const CaptureCamera &was = capture.cameras[i], &is = read->cameras[i];
    EXPECT_EQ(is.name, was.name);
    EXPECT_TRUE(is.camera.intrinsics().isApprox(k, 1e-12));
    EXPECT_TRUE(is.camera.eye().isApprox(was.camera.eye(), 1e-12));
    EXPECT_TRUE(is.camera.rotation().isApprox(was.camera.rotation(), 1e-12));
    EXPECT_EQ(is.camera.distortion(), was.camera.distortion());
    EXPECT_EQ(is.pictures.response, was.pictures.response);
    EXPECT_EQ(is.pictures.gain, was.pictures.gain);
    EXPECT_EQ(is.pictures.exposure, was.pictures.exposure);
    EXPECT_EQ(is.pictures.exponent, was.pictures.exponent);
    EXPECT_EQ(is.reprojectionError, was.reprojectionError);
    EXPECT_EQ(is.pictures.saturation, was.pictures.saturation);
    EXPECT_EQ(is.pictures.videoStart, was.pictures.videoStart);
    EXPECT_EQ(is.pictures.frameShift, was.pictures.frameShift);
    EXPECT_DOUBLE_EQ(is.pictures.rate, was.pictures.rate);
  }
  ASSERT_EQ(read->lighting.lamps.size(), 2U);
  EXPECT_TRUE(read->lighting.lamps[0].sun);
  EXPECT_TRUE(read->lighting.lamps[0].direction.isApprox(Vec3(0, 0.6, -0.8), 1e-12));
  EXPECT_FALSE(read->lighting.lamps[1].sun);
  EXPECT_EQ(read->lighting.lamps[1].position, Vec3(1, 2, 3));
  EXPECT_TRUE((read->lighting.lamps[1].light == Rgb(0, 1, 0)).all());
  EXPECT_TRUE((read->lighting.albedo == Rgb(0.9, 0.8, 1)).all());
  EXPECT_EQ(std::filesystem::weakly_canonical(read->cameras[0].pictures.image),
            std::filesystem::weakly_canonical(files.image));
  EXPECT_EQ(std::filesystem::weakly_canonical(read->cameras[0].pictures.mask),
            std::filesystem::weakly_canonical(files.mask));
}

TEST(WriteCapture, PathsAreRightFromWhereTheFileStands) {
  const testing::TempFolder folder;
  std::filesystem::create_directory(folder / "sub");
  Capture capture;
  capture.frames = {0};
  capture.volume = {{Vec3(-1, -1, -1), Vec3(1, 1, 1)}, {4, 4, 4}};
  PictureSource files;
  files.image = "no_such_%04d.png";  // from the working folder
  const Camera camera = Camera::pinhole({Vec3(1, -6, 2), Vec3(0, 0, 1)}, 30, 64, 48);
  capture.cameras = {{"a", camera, files}, {"b", camera, files}};
  const auto file = folder / "sub" / "refined.json";
  ASSERT_TRUE(writeCapture(file, capture));
  const auto read = openCalibration(file, {});
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(std::filesystem::weakly_canonical(read->cameras[0].pictures.image),
            std::filesystem::weakly_canonical(std::filesystem::absolute(files.image)));
}

TEST(WriteCapture, OfAPartHasAllFrames) {
  const testing::TempFolder folder;
  testing::writeRingPictures(folder);
  auto json = testing::ringJson();
  const auto again = [&] {
    testing::writeText(folder / "capture.json", json.dump());
    CaptureOptions options;
    options.frames = {5, 6};
    const auto part = openCapture(folder / "capture.json", options);
    EXPECT_TRUE(writeCapture(folder / "refined.json", part.value()));
    return openCapture(folder / "refined.json", {}).value();
  };
  EXPECT_EQ(again().frames, (std::vector{4, 5}));
  EXPECT_EQ(again().firstFrame, 4);
  json.erase("frames");
  EXPECT_EQ(again().frames, (std::vector{4, 5}));
  EXPECT_TRUE(again().statedFrames.empty());
}

TEST(WriteCapture, RefusesOrthographicCameras) {
  const testing::TempFolder folder;
  Capture capture;
  capture.cameras = {{"flat", Camera::orthographic({}, 2, 8, 8), {}}};
  const auto status = writeCapture(folder / "c.json", capture);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("flat"), std::string::npos);
}

}  // namespace
}  // namespace volute
