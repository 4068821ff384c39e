// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_device.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "volute/gl/gl_passes.hpp"

namespace volute {
namespace {

// Without a driver the tests of OpenGL are skipped; where one was installed for them (./dev test),
// that must not hide a context which cannot be made any more.
TEST(GlDevice, IsThereWhereTheTestsNeedIt) {
  if (!std::getenv("VOLUTE_TESTS_NEED_GL"))
    GTEST_SKIP() << "VOLUTE_TESTS_NEED_GL is not set";
  const auto gl = HeadlessGl::create();
  EXPECT_TRUE(gl) << gl.error().message;
}

TEST(GlDevice, HeadlessContextHasTheLimitsOfOpenGl45) {
  const auto gl = HeadlessGl::create();
  if (!gl)
    GTEST_SKIP() << gl.error().message;
  const GlDevice& device = gl->device();
  EXPECT_FALSE(device.renderer.empty());
  EXPECT_NE(device.version.find("4."), std::string::npos) << device.version;
  // The least that the standard allows.
  EXPECT_GE(device.largestTexture, 16384);
  EXPECT_GE(device.largestTexture3d, 512);
  EXPECT_GE(device.largestStorageBlock, 1 << 24);
  EXPECT_GE(device.storageBindings, 8);
  EXPECT_GE(device.groupInvocations, 1024);
  for (const auto& [name, value] : device.limits()) EXPECT_GT(value, 0) << name;
}

TEST(GlDevice, HardwareIsNeverTheCpu) {
  const auto gl = HeadlessGl::create(HeadlessGl::Wanted::kHardware);
  if (!gl) {
    EXPECT_EQ(gl.error().code, ErrorCode::kUnsupported);
    EXPECT_EQ(gl.error().message.find('\n'), std::string::npos);
    return;
  }
  EXPECT_TRUE(gl->device().hardware);
  EXPECT_EQ(gl->device().renderer.find("llvmpipe"), std::string::npos);
}

TEST(GlDevice, PassesAreTimedAndSummedByName) {
  const auto gl = HeadlessGl::create();
  if (!gl)
    GTEST_SKIP() << gl.error().message;
  GlPasses passes;
  const std::vector<float> values(1 << 20, 1.0F);
  for (int i = 0; i < 3; ++i)
    passes.run("upload", [&] { (void)makeBuffer(std::span<const float>(values)); });
  passes.run("nothing", [] {});
  const auto times = passes.take();
  ASSERT_EQ(times.size(), 2u);
  EXPECT_EQ(times[0].name, "upload");
  EXPECT_EQ(times[0].times, 3);
  EXPECT_GT(times[0].milliseconds, 0);
  EXPECT_LT(times[0].milliseconds, 60e3);
  EXPECT_EQ(times[1].times, 1);
  EXPECT_TRUE(passes.take().empty());
}

}  // namespace
}  // namespace volute
