// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_medium.hpp"

namespace volute {
namespace {

using testing::HasSubstr;

// With the line of the version these are lines 2 to 4 and 5 of the whole.
const std::vector<ShaderPart> kParts = {{"ray.glsl", "float a;\nfloat b;\n"},
                                        {"fog.glsl", "float c;"}};

TEST(GlProgram, LogsNameFilesAndLines) {
  EXPECT_EQ(namedShaderLog("0:5(5): error: no", kParts), "fog.glsl:1(5): error: no");
  EXPECT_EQ(namedShaderLog("0(3) : error C0000: no", kParts), "ray.glsl:2 : error C0000: no");
  EXPECT_EQ(namedShaderLog("ERROR: 0:2: 'x' : no", kParts), "ERROR: ray.glsl:1: 'x' : no");
  EXPECT_EQ(namedShaderLog("0:2(1): a\n0:5(2): b", kParts), "ray.glsl:1(1): a\nfog.glsl:1(2): b");
  EXPECT_EQ(namedShaderLog("0:900(1): beyond", kParts), "0:900(1): beyond");
  EXPECT_EQ(namedShaderLog("nothing of the kind", kParts), "nothing of the kind");
}

TEST(GlProgram, AFaultySourceIsAnErrorWithItsLine) {
  const auto gl = HeadlessGl::create();
  if (!gl)
    GTEST_SKIP() << gl.error().message;
  const ShaderStage stage{GL_COMPUTE_SHADER,
                          {{"good.glsl", "layout(local_size_x = 1) in;\n"},
                           {"bad.glsl", "\nvoid main() {\n  float x = missing;\n}\n"}}};
  const auto program = GlProgram::link({&stage, 1});
  ASSERT_FALSE(program);
  EXPECT_EQ(program.error().code, ErrorCode::kInvalidData);
  EXPECT_THAT(program.error().message, HasSubstr("bad.glsl:3"));
}

TEST(GlProgram, PrefixesAreForNamesOfTheMediumOnly) {
  EXPECT_EQ(withPrefix("M_end + M_fogMap[M_FOG_LEVELS] - M.M_x(some_M_map, fogMap, MM_a)", "m3_"),
            "m3_end + m3_fogMap[m3_FOG_LEVELS] - M.m3_x(some_M_map, fogMap, MM_a)");
}

}  // namespace
}  // namespace volute
