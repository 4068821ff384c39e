// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/capture_refinement.hpp"

#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "volute/image/srgb.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/testing.hpp"
#include "volute/tomography/frame_views.hpp"
#include "volute/tomography/picture_check.hpp"
#include "volute/tomography/testing.hpp"

namespace volute {
namespace {

constexpr int kCameras = 7;
constexpr int kFrames = 4;
constexpr std::size_t kLate = 3;

/// Pictures of a changing scene, and the capture that says so.
class CaptureRefinementTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (int frame = 0; frame < kFrames; ++frame) {
      const TestScene scene(kCameras, 0, 0.5 * frame);
      for (const TomographyView& view : scene.views)
        ASSERT_TRUE(writeImage(file(view.name, frame), view.radiance));
      capture.volume = {scene.geometry.bounds, scene.geometry.resolution};
      capture.cameras.clear();
      for (const TomographyView& view : scene.views) {
        PictureSource pictures;
        pictures.image = (folder / (view.name + "_%04d.exr")).string();
        capture.cameras.push_back({view.name, view.camera, pictures});
      }
    }
    capture.frames = {1, 2};
  }

  std::string file(const std::string& camera, int frame) const {
    return (folder / fmt::format("{}_{:04}.exr", camera, frame)).string();
  }

  /// Poses, focal lengths and gains off by about what is plausible.
  void perturb() {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    for (CaptureCamera& known : capture.cameras) {
      CameraCorrection wrong = plausibleCorrection(known.camera, capture.volume.bounds.centre());
      for (int p = 0; p < CameraCorrection::kCount; ++p)
        wrong.values[p] *= p < CameraCorrection::kLens ? 0.7 * normal(random) : 0;
      known.camera = *corrected(known.camera, wrong);
      known.pictures.gain *= wrong.gain();
    }
  }

  CaptureRefinement refined(Refine refine = Refine::kAuto) {
    Progress progress;
    auto result = refineCapture(capture, {}, refine, std::uint64_t{1} << 30, progress);
    EXPECT_TRUE(result) << (result ? "" : result.error().message);
    return result.value_or(CaptureRefinement{});
  }

  /// The largest distance between where two cameras see points of the volume [pixels].
  double pixelsOff(const Camera& a, const Camera& b) const {
    double most = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 side(corner & 1 ? 0.2 : -0.2, corner & 2 ? 0.2 : -0.2, corner & 4 ? 0.2 : -0.2);
      const Vec3 point =
          capture.volume.bounds.centre() + side.cwiseProduct(capture.volume.bounds.size());
      most = std::max(most, (*a.project(point) - *b.project(point)).norm());
    }
    return most;
  }

  testing::TempFolder folder;
  Capture capture;
};

TEST_F(CaptureRefinementTest, LeavesACleanCaptureAlone) {
  const CaptureRefinement result = refined();
  EXPECT_FALSE(result.used);
  EXPECT_TRUE(result.faults.empty());
  EXPECT_EQ(std::accumulate(result.shifts.begin(), result.shifts.end(), 0), 0);
}

TEST_F(CaptureRefinementTest, FindsCalibrationAndClockTogether) {
  const double clean = refined(Refine::kAlways).after;
  perturb();
  capture.cameras[kLate].pictures.frameShift = 1;  // shows what the others see a frame later
  const CaptureRefinement result = refined();
  ASSERT_TRUE(result.used);
  EXPECT_TRUE(result.faults.empty());
  ASSERT_EQ(result.shifts.size(), std::size_t{kCameras});
  for (std::size_t v = 0; v < result.shifts.size(); ++v)
    EXPECT_EQ(result.shifts[v], v == kLate ? -1 : 0);
  EXPECT_EQ(result.capture.cameras[kLate].pictures.frameShift, 0);
  EXPECT_LT(result.after, 1.1 * clean);
  EXPECT_GT(result.before, 2 * clean);
  const auto warnings = outstandingCorrections(result);
  EXPECT_TRUE(std::ranges::any_of(warnings, [](const std::string& text) {
    return text.find("camera c3: its pictures of 1 frame earlier") != std::string::npos;
  }));
}

TEST_F(CaptureRefinementTest, AHalfExposureIsToldAndTaken) {
  capture.frames = {1};
  capture.cameras[2].pictures.gain = 0.5;
  const CaptureRefinement result = refined();
  ASSERT_TRUE(result.mended);
  ASSERT_EQ(result.faults.size(), 1U);
  EXPECT_NE(result.faults[0].find(" % too dark: its radiance"), std::string::npos)
      << result.faults[0];
  EXPECT_NEAR(result.capture.cameras[2].pictures.gain, 1, 0.03);
  EXPECT_NEAR(result.capture.cameras[3].pictures.gain, 1, 0.02);
  const CaptureRefinement never = refined(Refine::kNever);
  EXPECT_FALSE(never.used || never.mended);
  EXPECT_EQ(never.faults.size(), 1U);
  EXPECT_EQ(never.capture.cameras[2].pictures.gain, 0.5);
}

TEST_F(CaptureRefinementTest, AHalfExposureInOneFrameIsTakenThereAlone) {
  capture.frames = {0, 1, 2, 3};
  for (const int odd : {2, 0}) {  // in the middle, and the first
    const std::string name = file("c2", odd);
    const Image right = *readImage(name);
    Image half = right;
    for (float& value : half.pixels) value *= 0.5F;
    ASSERT_TRUE(writeImage(name, half));
    const CaptureRefinement result = refined();
    ASSERT_TRUE(writeImage(name, right));
    EXPECT_TRUE(result.mended);
    EXPECT_TRUE(result.pictureFaults.empty());
    ASSERT_EQ(result.faults.size(), 1U) << odd;
    EXPECT_THAT(result.faults[0], ::testing::MatchesRegex(fmt::format(
                                      "camera c2: not as bright in all frames: its radiance times "
                                      "(2|2.0[0-9]|1.9[0-9]) in frame {} and .*",
                                      odd)));
    EXPECT_TRUE(result.capture.cameras[2].pictures.gainByFrame);
    EXPECT_NEAR(result.capture.cameras[2].pictures.gain, 1, 0.03);
  }
  for (int frame = 0; frame < kFrames; ++frame) {  // in all
    Image half = *readImage(file("c2", frame));
    for (float& value : half.pixels) value *= 0.5F;
    ASSERT_TRUE(writeImage(file("c2", frame), half));
  }
  const CaptureRefinement result = refined();
  EXPECT_TRUE(result.mended);
  EXPECT_EQ(result.faults.size(), 1U);
  EXPECT_TRUE(result.pictureFaults.empty());
}

TEST_F(CaptureRefinementTest, APictureThatIsMirroredInOneFrameIsLeftOutThere) {
  capture.frames = {0, 1, 2, 3};
  const Image right = *readImage(file("c2", 2));
  Image mirrored = right;
  for (int y = 0; y < right.height; ++y)
    for (int x = 0; x < right.width; ++x)
      for (int c = 0; c < 3; ++c) mirrored.at(x, y, c) = right.at(right.width - 1 - x, y, c);
  ASSERT_TRUE(writeImage(file("c2", 2), mirrored));
  const CaptureRefinement result = refined();
  ASSERT_EQ(result.pictureFaults.size(), 1U);
  EXPECT_THAT(result.pictureFaults[0],
              ::testing::MatchesRegex("camera c2, frame 2 alone: mirrored .* left out there .*"));
  EXPECT_EQ(result.capture.cameras[2].pictures.leftOut, std::vector<int>{2});
  Progress progress;
  auto reader = ViewReader::open(result.capture, {}, std::uint64_t{1} << 30, progress);
  ASSERT_TRUE(reader);
  EXPECT_TRUE(reader->read(2)->facts[2].missing);
  EXPECT_FALSE(reader->read(1)->facts[2].missing);
  EXPECT_TRUE(refined(Refine::kNever).capture.cameras[2].pictures.leftOut.empty());
}

TEST_F(CaptureRefinementTest, AGainThatDriftsIsFoundInEachFrame) {
  capture.frames = {0, 1, 2, 3};
  std::vector<Image> right;
  for (const int frame : capture.frames) {
    right.push_back(*readImage(file("c2", frame)));
    Image darker = right.back();
    for (float& value : darker.pixels) value *= 1 - 0.15F * static_cast<float>(frame);
    ASSERT_TRUE(writeImage(file("c2", frame), darker));
  }
  const CaptureRefinement result = refined();
  ASSERT_EQ(result.faults.size(), 1U);
  EXPECT_THAT(result.faults[0], ::testing::HasSubstr("camera c2: not as bright in all frames"));
  ASSERT_TRUE(result.capture.cameras[2].pictures.gainByFrame);
  Progress progress;
  auto reader = ViewReader::open(result.capture, {}, std::uint64_t{1} << 30, progress);
  ASSERT_TRUE(reader);
  for (const int frame : capture.frames) {
    const auto views = reader->read(frame);
    ASSERT_TRUE(views);
    EXPECT_NEAR(views->facts[2].gain * result.capture.cameras[2].pictures.gain,
                1 / (1 - 0.15 * frame), 0.06 / (1 - 0.15 * frame));
  }
}

TEST_F(CaptureRefinementTest, AnotherCurveIsToldByTheOneThatIsStated) {
  capture.frames = {1};
  Image image = *readImage(file("c2", 1));
  for (float& value : image.pixels) value = static_cast<float>(srgbDecode(value));
  ASSERT_TRUE(writeImage(file("c2", 1), image));
  const auto told = [&] {
    const CaptureRefinement result = refined();
    return result.faults.empty() ? std::string() : result.faults[0];
  };
  EXPECT_THAT(told(), ::testing::HasSubstr("taken as sRGB"));
  capture.cameras[2].pictures.response = Response();
  EXPECT_THAT(told(), ::testing::HasSubstr("to the power of about 0.45"));
}

TEST_F(CaptureRefinementTest, OfMosaicsNoOtherMistakeIsTold) {
  capture.frames = {1};
  for (CaptureCamera& known : capture.cameras) {
    const Image image = *readImage(file(known.name, 1));
    Image mosaic(image.width, image.height, 1);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        mosaic.at(x, y) = image.at(x, y) * (x % 2 + y % 2 == 1 ? 1.0F : 0.3F);
    ASSERT_TRUE(writeImage(file(known.name, 1), mosaic));
  }
  capture.cameras[2].pictures.gain *= 0.5;
  EXPECT_TRUE(refined().faults.empty());
}

TEST_F(CaptureRefinementTest, GainsByFrameNeedOtherCameras) {
  Progress progress;
  const auto open = [&] {
    return ViewReader::open(capture, {"c0"}, std::uint64_t{1} << 30, progress);
  };
  for (std::size_t v = 3; v < kCameras; ++v) capture.cameras[v].pictures.gainByFrame = true;
  EXPECT_TRUE(open());
  capture.cameras[1].pictures.leftOut = {1};
  auto reader = open();
  const auto untold = reader->read(1), told = reader->read(2);
  ASSERT_TRUE(untold && told);
  EXPECT_TRUE(untold->facts[3].gainUntold);
  EXPECT_FALSE(told->facts[3].gainUntold);
  EXPECT_THAT(
      checkPictures(*untold, {capture.volume.bounds, capture.volume.resolution}, 0, {}).warnings,
      ::testing::Contains(::testing::HasSubstr("its gain is taken as 1 here")));
  capture.cameras[2].pictures.gainByFrame = true;  // c1 is left, and c0, which is held out
  ASSERT_FALSE(open());
  EXPECT_THAT(open().error().message, ::testing::HasSubstr("of the fitted cameras 1 have none"));
}

TEST_F(CaptureRefinementTest, AHalfExposureBesidePosesThatAreOffIsRefinedWithThem) {
  capture.frames = {1};
  const double clean = refined(Refine::kAlways).after;
  perturb();
  capture.cameras[2].pictures.gain *= 0.5;
  const CaptureRefinement result = refined();
  ASSERT_TRUE(result.used);
  EXPECT_LT(result.after, 1.2 * clean);
  // What all gains share no picture tells.
  std::vector<double> gains;
  for (const CaptureCamera& known : result.capture.cameras) gains.push_back(known.pictures.gain);
  const auto [least, most] = std::ranges::minmax(gains);
  EXPECT_LT(most / least, 1.06) << fmt::format("{}", fmt::join(gains, " "));
}

TEST_F(CaptureRefinementTest, AnotherFocalLengthIsToldAndTaken) {
  capture.frames = {1};
  const Camera truth = capture.cameras[2].camera;
  capture.cameras[2].camera = *corrected(truth, zoomBy(1.2));
  EXPECT_GT(pixelsOff(capture.cameras[2].camera, truth), 1.5);
  const CaptureRefinement result = refined();
  ASSERT_TRUE(result.mended);
  ASSERT_EQ(result.faults.size(), 1U);
  EXPECT_NE(result.faults[0].find("camera c2: another focal length"), std::string::npos)
      << result.faults[0];
  EXPECT_LT(pixelsOff(result.capture.cameras[2].camera, truth), 0.5);
}

TEST_F(CaptureRefinementTest, ALensIsToldAndTaken) {
  capture.frames = {1};
  const Camera truth = capture.cameras[2].camera;
  capture.cameras[2].camera = *corrected(truth, lensBy(8));
  EXPECT_GT(pixelsOff(capture.cameras[2].camera, truth), 1.5);
  const CaptureRefinement result = refined();
  ASSERT_TRUE(result.mended);
  ASSERT_EQ(result.faults.size(), 1U);
  EXPECT_NE(result.faults[0].find("camera c2: a lens that its calibration does not have"),
            std::string::npos)
      << result.faults[0];
  EXPECT_LT(pixelsOff(result.capture.cameras[2].camera, truth), 0.5)
      << result.capture.cameras[2].camera.distortion().k1;
}

TEST_F(CaptureRefinementTest, WhatIsWrongWithTwoCamerasDoesNotHinderTheOthers) {
  capture.frames = {1};
  perturb();
  std::swap(capture.cameras[1].camera, capture.cameras[4].camera);
  const CaptureRefinement result = refined();
  ASSERT_EQ(result.faults.size(), 1U);
  EXPECT_NE(result.faults[0].find("cameras c1 and c4: exchanged"), std::string::npos)
      << result.faults[0];
  EXPECT_EQ(result.leftOut, (std::vector<std::string>{"c1", "c4"}));
  ASSERT_TRUE(result.used);
  EXPECT_EQ(result.names, (std::vector<std::string>{"c0", "c2", "c3", "c5", "c6"}));
  EXPECT_LT(result.after, 0.5 * result.before);
  EXPECT_EQ(pixelsOff(result.capture.cameras[1].camera, capture.cameras[1].camera), 0);
}

TEST_F(CaptureRefinementTest, APoleBeforeOneCameraPullsNoCamera) {
  constexpr std::size_t kCovered = 2;
  capture.frames = {1};
  perturb();
  const CaptureRefinement clean = refined(Refine::kAlways);
  for (const int frame : capture.frames) {
    const std::string name = file(capture.cameras[kCovered].name, frame);
    Image image = *readImage(name);
    for (int y = 0; y < image.height; ++y)
      for (int x = 24; x < 32; ++x)
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = 0;
    ASSERT_TRUE(writeImage(name, image));
  }
  // With the pole among the pixels that count.
  Progress progress;
  auto reader = ViewReader::open(capture, {}, std::uint64_t{1} << 30, progress);
  ASSERT_TRUE(reader);
  std::vector<std::vector<TomographyView>> frames;
  for (const int frame : capture.frames) frames.push_back(reader->read(frame)->views);
  const auto pulled =
      refineCalibration(frames, {capture.volume.bounds, capture.volume.resolution},
                        {.fine = true, .maxMemory = std::uint64_t{1} << 29}, progress);
  ASSERT_TRUE(pulled) << pulled.error().message;
  double most = 0;
  for (std::size_t v = 0; v < capture.cameras.size(); ++v)
    most = std::max(most, pixelsOff(pulled->cameras[v], clean.capture.cameras[v].camera));
  RecordProperty("pulled", std::to_string(most));

  const CaptureRefinement result = refined(Refine::kAlways);
  ASSERT_TRUE(result.used);
  double worst = 0;
  for (std::size_t v = 0; v < capture.cameras.size(); ++v) {
    const double off = pixelsOff(result.capture.cameras[v].camera, clean.capture.cameras[v].camera);
    RecordProperty("pixels_off_" + std::to_string(v), std::to_string(off));
    worst = std::max(worst, off);
  }
  EXPECT_LT(worst, 0.25);
  EXPECT_LT(worst, 0.4 * most) << worst << " instead of " << most << " pixels";
  EXPECT_NEAR(result.capture.cameras[kCovered].pictures.gain,
              clean.capture.cameras[kCovered].pictures.gain, 0.04);
}

TEST_F(CaptureRefinementTest, ACameraWithoutAPictureOfAFrameDoesNotCountThere) {
  capture.cameras[kLate].pictures.frameShift = 1;
  capture.frames = {3};  // the last that has pictures
  Progress progress;
  auto reader = ViewReader::open(capture, {}, std::uint64_t{1} << 30, progress);
  ASSERT_TRUE(reader);
  const auto views = reader->read(3);
  ASSERT_TRUE(views) << views.error().message;
  EXPECT_TRUE(views->facts[kLate].missing);
  EXPECT_FALSE(views->views[kLate].counts(0));
  EXPECT_FALSE(views->facts[0].missing);
  // A frame of which no camera has a picture is an error.
  capture.cameras[kLate].pictures.frameShift = 0;
  capture.frames = {4};
  auto plain = ViewReader::open(capture, {}, std::uint64_t{1} << 30, progress);
  ASSERT_TRUE(plain);
  EXPECT_FALSE(plain->read(4));
}

TEST_F(CaptureRefinementTest, FindsResponsesOfPicturesAndLeavesThoseThatAreRight) {
  double white = 0;
  for (const CaptureCamera& known : capture.cameras) {
    for (const int frame : capture.frames) {
      const auto image = readImage(file(known.name, frame));
      ASSERT_TRUE(image);
      white = std::max<double>(white, *std::ranges::max_element(image->pixels));
    }
  }
  capture.white = white;
  for (CaptureCamera& known : capture.cameras) {
    for (const int frame : capture.frames) {
      Image image = *readImage(file(known.name, frame));
      for (float& value : image.pixels) value /= static_cast<float>(white);
      ASSERT_TRUE(writeImage(folder / fmt::format("{}_{:04}.png", known.name, frame), image));
    }
    known.pictures.image = (folder / (known.name + "_%04d.png")).string();
  }
  const CaptureRefinement clean = refined();
  EXPECT_FALSE(clean.used);
  EXPECT_TRUE(outstandingCorrections(clean).empty());
  const double stated[kCameras] = {1, 1 / 1.1, 1, 1.1, 1, 1 / 1.1, 1};
  for (std::size_t v = 0; v < kCameras; ++v) capture.cameras[v].pictures.exponent = stated[v];
  const CaptureRefinement result = refined();
  ASSERT_TRUE(result.used);
  EXPECT_TRUE(result.faults.empty());
  for (std::size_t v = 0; v < kCameras; ++v) {
    const PictureSource& pictures = result.capture.cameras[v].pictures;
    EXPECT_NEAR(pictures.exponent, 1, 0.025) << v;
    EXPECT_NEAR(pictures.gain, 1, 0.05) << v;
  }
  EXPECT_NE(describeCorrections(result)[1].find(", exponent 1."), std::string::npos)
      << describeCorrections(result)[1];
  EXPECT_GE(outstandingCorrections(result).size(), 2U);
}

TEST_F(CaptureRefinementTest, MistakesAreNamedAndNotRefinedAway) {
  std::swap(capture.cameras[1].camera, capture.cameras[4].camera);
  const CaptureRefinement result = refined();
  EXPECT_FALSE(result.used);
  ASSERT_EQ(result.faults.size(), 1U);
  EXPECT_NE(result.faults[0].find("cameras c1 and c4: exchanged"), std::string::npos)
      << result.faults[0];
}

}  // namespace
}  // namespace volute
