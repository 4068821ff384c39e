// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/render_job.hpp"

#include <gtest/gtest.h>

namespace volute::cli {
namespace {

/// A device for which everything is too large.
class TooSmall final : public GlPictures {
 public:
  explicit TooSmall(ErrorCode code) : code_(code) {}

  Result<Image> picture(const Camera&, const GlSubject&, const RenderOptions&, Progress&,
                        RenderStats&, std::span<const float>) override {
    return refusal();
  }

  Result<SurfacePicture> surfaces(const Camera&, const GlSubject&, const TriangleScene&,
                                  const SceneLights&, Progress&) override {
    return refusal();
  }

  Result<SurfacePicture> walls(const Camera&, const SmokeState&, const SceneLights&, const Rgb&,
                               const TriangleScene&, Progress&) override {
    return refusal();
  }

  Result<std::vector<SignPixel>> findSigns(const Camera&, std::span<const Sign>,
                                           std::span<const float>) override {
    return refusal();
  }

  Result<Image> signLight(const Camera&, const GlSubject&, std::span<const Sign>, const PictureLaw&,
                          Progress&, std::span<const float>) override {
    return refusal();
  }

  nlohmann::ordered_json stats() override { return {}; }

 private:
  tl::unexpected<Error> refusal() const { return fail(code_, "the device is too small"); }

  ErrorCode code_;
};

struct Remarks final : Progress {
  void remark(std::string_view message) override { heard += message; }

  std::string heard;
};

RenderJob jobWith(ErrorCode code, bool wish) {
  RenderJob job{{}, {}, Camera::framing({Vec3(0, 0, 0), Vec3(1, 1, 1)}, 4, 3), {}, {}, 25, {}};
  job.options.background = Rgb(0.5, 0.25, 1);
  job.gl = std::make_shared<TooSmall>(code);
  job.glIsWish = wish;
  return job;
}

TEST(RenderJob, TheProcessorDrawsWhatOpenGlCannotWhereItIsAWish) {
  for (const ErrorCode code : {ErrorCode::kTooLarge, ErrorCode::kInvalidData}) {
    RenderJob job = jobWith(code, true);
    Remarks remarks;
    const auto image = job.picture({}, remarks);
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->at(1, 1, 0), 0.5F);
    EXPECT_NE(remarks.heard.find("the device is too small"), std::string::npos);
    EXPECT_EQ(job.stats()["renderer"], "cpu");
  }
}

TEST(RenderJob, OpenGlThatWasAskedForFails) {
  Remarks remarks;
  RenderJob job = jobWith(ErrorCode::kTooLarge, false);
  EXPECT_EQ(job.picture({}, remarks).error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(remarks.heard, "");
  RenderJob stopped = jobWith(ErrorCode::kCancelled, true);
  EXPECT_EQ(stopped.picture({}, remarks).error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace volute::cli
