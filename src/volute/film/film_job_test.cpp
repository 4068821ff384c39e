// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/film/film_job.hpp"

#include <gtest/gtest.h>

namespace volute {
namespace {

/// A device for which everything is too large.
class TooSmall final : public SceneRenderer {
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

struct Remarks final : Progress {
  void remark(std::string_view message) override { heard += message; }

  std::string heard;
};

FilmJob jobWith(ErrorCode code, bool mayFallBack) {
  Progress quiet;
  auto scene = Scene::make({{"format", "volute-scene-1"}}, "scene.json", {}, quiet);
  FilmJob job{std::move(*scene), Camera::framing({Vec3(0, 0, 0), Vec3(1, 1, 1)}, 4, 3), {},
                std::make_unique<TooSmall>(code), mayFallBack, {}};
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
    EXPECT_NE(remarks.heard.find("the device is too small"), std::string::npos);
    EXPECT_EQ(job.stats()["renderer"], "cpu");
  }
}

TEST(FilmJob, OpenGlThatWasAskedForFails) {
  Remarks remarks;
  FilmJob job = jobWith(ErrorCode::kTooLarge, false);
  EXPECT_EQ(job.picture({}, remarks).error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(remarks.heard, "");
  FilmJob stopped = jobWith(ErrorCode::kCancelled, true);
  EXPECT_EQ(stopped.picture({}, remarks).error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace volute
