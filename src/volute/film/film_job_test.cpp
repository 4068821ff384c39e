// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/film/film_job.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace volute {
namespace {

/// A device for which everything is too large.
class TooSmall : public SceneRenderer {
 public:
  explicit TooSmall(ErrorCode code) : code_(code) {}

  std::string_view name() const override { return "gl"; }

 protected:
  Status begin(const View&) override { return refusal(); }

  Result<SurfacePicture> surfaces(const View&, Progress&) override { return refusal(); }

  Result<SurfaceView> walls(const View&, std::size_t) override { return refusal(); }

  Result<std::vector<SignPixel>> findSigns(const View&) override { return refusal(); }

  Result<Image> color(const View&, const RenderOptions&, Progress&, RenderStats&) override {
    return refusal();
  }

  Result<Image> opticalDepth(const View&, const RenderOptions&, Progress&, RenderStats&) override {
    return refusal();
  }

  Status addSigns(const View&, std::span<const SignPixel>, const RenderOptions&, Progress&,
                  Image&) override {
    return refusal();
  }

 private:
  tl::unexpected<Error> refusal() const { return fail(code_, "the device is too small"); }

  ErrorCode code_;
};

/// Draws one colour, another in each call, and is stopped after some calls.
class StoppedDrawer final : public TooSmall {
 public:
  explicit StoppedDrawer(int calls) : TooSmall(ErrorCode::kUnsupported), left_(calls) {}

  std::string_view name() const override { return "cpu"; }

 protected:
  Status begin(const View&) override { return {}; }

  Result<Image> color(const View& view, const RenderOptions&, Progress&, RenderStats&) override {
    if (left_-- == 0)
      return fail(ErrorCode::kCancelled, "stopped");
    Image image(view.camera.width(), view.camera.height(), 3);
    for (float& value : image.pixels) value = value_;
    value_ += 1;
    return image;
  }

 private:
  int left_;
  float value_ = 1;
};

struct Remarks final : Progress {
  void remark(const Remark& remark) override { sentences += remark.sentence; }

  std::string sentences;
};

FilmJob jobWith(ErrorCode code, bool mayFallBack) {
  Progress quiet;
  auto scene = Scene::make({{"format", "volute-scene-1"}}, "scene.json", {}, quiet);
  FilmJob job{std::move(*scene),
              Camera::framing({Vec3(0, 0, 0), Vec3(1, 1, 1)}, 4, 3),
              {},
              std::make_unique<TooSmall>(code),
              mayFallBack,
              {}};
  job.options.background = Rgb(0.5, 0.25, 1);
  return job;
}

TEST(FilmJob, TheCpuDrawsWhatOpenGlCannotWhereItMay) {
  for (const ErrorCode code : {ErrorCode::kTooLarge, ErrorCode::kInvalidData}) {
    FilmJob job = jobWith(code, true);
    Remarks remarks;
    const auto image = job.picture({}, remarks);
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->at(1, 1, 0), 0.5F);
    EXPECT_NE(remarks.sentences.find("the device is too small"), std::string::npos);
    EXPECT_EQ(job.stats()["renderer"], "cpu");
  }
}

TEST(FilmJob, StoppedPicturesAreReturnedAsFarAsTheyAreDrawn) {
  Remarks remarks;
  const auto job = [](int calls) {
    FilmJob made = jobWith(ErrorCode::kInvalidData, false);
    made.camera = made.camera.resized(390, 390);  // nine tiles
    made.renderer = std::make_unique<StoppedDrawer>(calls);
    made.partial = true;
    return made;
  };
  FilmJob third = job(3);  // the coarse picture and two tiles
  const auto image = third.picture({}, remarks);
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->width, 390);
  EXPECT_EQ(image->height, 390);
  EXPECT_EQ(image->at(195, 195, 0), 2) << "the middle comes first";
  EXPECT_EQ(image->at(195, 50, 0), 3);
  EXPECT_EQ(image->at(10, 10, 0), 1) << "of the coarse picture";
  EXPECT_NEAR(third.drawnShare, 2 / 9.0, 1e-12);

  FilmJob whole = job(10);
  ASSERT_TRUE(whole.picture({}, remarks));
  EXPECT_EQ(whole.drawnShare, 1);
  FilmJob nothing = job(0);
  EXPECT_EQ(nothing.picture({}, remarks).error().code, ErrorCode::kCancelled);
}

TEST(FilmJob, OpenGlThatWasAskedForFails) {
  Remarks remarks;
  FilmJob job = jobWith(ErrorCode::kTooLarge, false);
  EXPECT_EQ(job.picture({}, remarks).error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(remarks.sentences, "");
  FilmJob stopped = jobWith(ErrorCode::kCancelled, true);
  EXPECT_EQ(stopped.picture({}, remarks).error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace volute
