// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_shader.hpp"

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "volute/fog/fog_testing.hpp"
#include "volute/fog/polar_table.hpp"

namespace volute {
namespace {

enum class Api { kDesktop45, kEs30 };

/// A context without a window; `missing` says why there is none.
class Context {
 public:
  explicit Context(Api api) {
    if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
      missing = "EGL has no surfaceless platform here";
      return;
    }
    display_ =
        eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (!eglInitialize(display_, nullptr, nullptr)) {
      missing = "EGL has no display here";
      return;
    }
    const bool es = api == Api::kEs30;
    eglBindAPI(es ? EGL_OPENGL_ES_API : EGL_OPENGL_API);
    const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                             es ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config{};
    EGLint count = 0;
    eglChooseConfig(display_, wanted, &config, 1, &count);
    const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, es ? 3 : 4, EGL_CONTEXT_MINOR_VERSION,
                              es ? 0 : 5, EGL_NONE};
    context_ = count ? eglCreateContext(display_, config, EGL_NO_CONTEXT, version) : EGL_NO_CONTEXT;
    if (!context_ || !eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
      missing = es ? "EGL has no OpenGL ES 3.0 here" : "EGL has no OpenGL 4.5 core here";
  }

  ~Context() {
    if (!context_)
      return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
  }

  std::string missing;

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

GLuint compiled(GLenum kind, const std::string& source) {
  const GLuint shader = glCreateShader(kind);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  char log[4096] = "";
  glGetShaderInfoLog(shader, sizeof log, nullptr, log);
  EXPECT_TRUE(good) << log;
  return shader;
}

GLuint linked(Api api, const std::string& functions, const std::string& body) {
  const std::string head = api == Api::kEs30
                               ? "#version 300 es\nprecision highp float;\nprecision highp int;\n"
                               : "#version 450\n";
  const GLuint program = glCreateProgram();
  glAttachShader(program, compiled(GL_VERTEX_SHADER, head + R"(
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); })"));
  glAttachShader(program,
                 compiled(GL_FRAGMENT_SHADER,
                          head + functions + "\nout vec4 result;\nvoid main() {\n" + body + "}\n"));
  glLinkProgram(program);
  GLint good = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &good);
  EXPECT_TRUE(good);
  glUseProgram(program);
  return program;
}

GLuint texture(int unit, GLint format, int width, int height, GLenum layout, const void* values) {
  GLuint name = 0;
  glGenTextures(1, &name);
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindTexture(GL_TEXTURE_2D, name);
  glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, layout, GL_FLOAT, values);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return name;
}

/// What the fragment shader gives for each pixel; the texture stays bound to `unit`.
std::vector<float> drawn(int unit, int width, int height) {
  const GLuint target = texture(unit, GL_RGBA32F, width, height, GL_RGBA, nullptr);
  GLuint frame = 0, array = 0;
  glGenFramebuffers(1, &frame);
  glBindFramebuffer(GL_FRAMEBUFFER, frame);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target, 0);
  EXPECT_EQ(glCheckFramebufferStatus(GL_FRAMEBUFFER), GLenum(GL_FRAMEBUFFER_COMPLETE));
  glGenVertexArrays(1, &array);
  glBindVertexArray(array);
  glViewport(0, 0, width, height);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  std::vector<float> pixels(4 * static_cast<std::size_t>(width) * height);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, pixels.data());
  EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));
  return pixels;
}

void setFog(GLuint program, const FogShader& shader) {
  texture(0, GL_R32F, shader.width, shader.height, GL_RED, shader.texels.data());
  glUniform1i(glGetUniformLocation(program, "fogMap"), 0);
  glUniform3f(glGetUniformLocation(program, "fogCorner"), float(shader.corner.x()),
              float(shader.corner.y()), float(shader.corner.z()));
  glUniform1f(glGetUniformLocation(program, "fogCell"), float(shader.cell));
  glUniform1f(glGetUniformLocation(program, "fogMu"), float(shader.mu));
}

/// Two textures: eye and distance, direction.
void setRays(GLuint program, std::span<const Segment> rays, int side) {
  std::vector<float> from(4 * rays.size()), towards(4 * rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      from[4 * i + axis] = float(rays[i].origin[axis]);
      towards[4 * i + axis] = float(rays[i].direction[axis]);
    }
    from[4 * i + 3] = std::isinf(rays[i].end) ? 1e30F : float(rays[i].end);
  }
  texture(1, GL_RGBA32F, side, side, GL_RGBA, from.data());
  texture(2, GL_RGBA32F, side, side, GL_RGBA, towards.data());
  glUniform1i(glGetUniformLocation(program, "testFrom"), 1);
  glUniform1i(glGetUniformLocation(program, "testTowards"), 2);
}

constexpr int kSide = 40;
const std::string kTestRays =
    "uniform highp sampler2D testFrom;\nuniform highp sampler2D testTowards;\n";
const std::string kEachRay = R"(
  vec4 from = texelFetch(testFrom, ivec2(gl_FragCoord.xy), 0);
  vec3 towards = texelFetch(testTowards, ivec2(gl_FragCoord.xy), 0).xyz;
  result = vec4()";

class Glsl : public testing::TestWithParam<Api> {};

TEST_P(Glsl, WalkIsWithinTwoHundredThousandthsOfTheReference) {
  const Context context(GetParam());
  if (!context.missing.empty())
    GTEST_SKIP() << context.missing;
  for (int degree = 0; degree <= 3; ++degree) {
    for (const auto& [name, profile] : fogtest::profiles()) {
      for (const double mu : {1.0, 0.6, 0.0}) {
        const FogMedium fog = fogtest::fog(fogtest::map(37, 29), profile,
                                           {.degree = degree, .levels = 2, .detail = {.mu = mu}});
        const FogShader shader = fogShader(fog).value();
        const GLuint program = linked(GetParam(), shader.walk + kTestRays,
                                      kEachRay + "fogOpticalDepth(from.xyz, towards, from.w));\n");
        setFog(program, shader);
        // Planes between cells are left out for degree 0, where they are jumps.
        const auto rays = fogtest::rays(fog, kSide * kSide, 3, degree > 0);
        setRays(program, rays, kSide);
        const auto found = drawn(3, kSide, kSide);
        std::vector<double> depths(rays.size());
        fog.opticalDepth(rays, depths);
        double worst = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
          const double error = std::abs(std::exp(-found[4 * i]) - std::exp(-depths[i]));
          worst = !(error <= worst) ? error : worst;
        }
        EXPECT_LE(worst, 2e-5) << "degree " << degree << ", mu " << mu << ", " << name;
      }
    }
  }
}

TEST_P(Glsl, PolarTableIsThatOfTheLibrary) {
  const Context context(GetParam());
  if (!context.missing.empty())
    GTEST_SKIP() << context.missing;
  constexpr int kAzimuths = 512, kRadii = 192;
  const Vec3 eye(12, 9, 3);
  for (const auto& [name, profile] : fogtest::profiles()) {
    if (name == "exponential")
      continue;
    const FogMedium fog = fogtest::fog(fogtest::map(37, 29), profile, {.degree = 1});
    const FogShader shader = fogShader(fog).value();
    auto rays = fogtest::rays(fog, kSide * kSide);
    for (Segment& ray : rays) ray.origin = eye;
    const PolarTable table =
        PolarTable::make(fog, eye, {.azimuths = kAzimuths, .radii = kRadii}).value();
    const auto setPolar = [&](GLuint program) {
      setFog(program, shader);
      glUniform1i(glGetUniformLocation(program, "fogPolar"), 4);
      glUniform2f(glGetUniformLocation(program, "fogPolarYaw"), 1, 0);
      glUniform1f(glGetUniformLocation(program, "fogPolarTangent"), 1);
      glUniform1i(glGetUniformLocation(program, "fogPolarSectors"), 4);
      glUniform2f(glGetUniformLocation(program, "fogPolarRadii"), float(table.firstRadius()),
                  float(table.radiusStep()));
      const auto bends = largestBends(fog.levels().map());
      glUniform2f(glGetUniformLocation(program, "fogPolarBends"), float(bends[0]), float(bends[1]));
      glUniform2i(glGetUniformLocation(program, "testSize"), kRadii, 4 * kAzimuths);
    };
    const GLuint fill = linked(
        GetParam(), shader.walk + shader.polar + "uniform ivec2 testSize;\n",
        fmt::format("result = fogPolarEntry(vec3({:.6f}, {:.6f}, {:.6f}), ivec2(gl_FragCoord.xy), "
                    "testSize);\n",
                    eye.x(), eye.y(), eye.z()));
    setPolar(fill);
    drawn(4, kRadii, 4 * kAzimuths);
    const GLuint look = linked(GetParam(), shader.walk + shader.polar + kTestRays,
                               kEachRay + "fogPolarOpticalDepth(from.xyz, towards, from.w));\n");
    setPolar(look);
    setRays(look, rays, kSide);
    glActiveTexture(GL_TEXTURE4);
    const auto found = drawn(3, kSide, kSide);
    std::vector<float> columns[4], expected(rays.size());
    for (const Segment& ray : rays) {
      for (int axis = 0; axis < 3; ++axis) columns[axis].push_back(float(ray.direction[axis]));
      columns[3].push_back(float(ray.end));
    }
    table.lookUp({eye, columns[0], columns[1], columns[2], columns[3]}, expected);
    std::vector<double> depths(rays.size());
    fog.opticalDepth(rays, depths);
    std::size_t looked = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const double passed = std::exp(-found[4 * i]);
      EXPECT_NEAR(passed, std::exp(-depths[i]), kPolarError) << name << ", ray " << i;
      if (expected[i] < 0 || std::abs(passed - std::exp(-depths[i])) < 2e-5)
        continue;  // one of them walks it
      ++looked;
      EXPECT_NEAR(passed, expected[i], 5e-5) << name << ", ray " << i;
    }
    EXPECT_GT(looked, 0U) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Api, Glsl, testing::Values(Api::kDesktop45, Api::kEs30),
                         [](const auto& info) {
                           return info.param == Api::kEs30 ? "Es30" : "Desktop45";
                         });

TEST(FogShader, PolarOnlyWhereTheTableServes) {
  const SplineGrid map = fogtest::map(5, 5);
  EXPECT_FALSE(fogShader(fogtest::fog(map, fogtest::profiles()[0].profile, {}))->polar.empty());
  EXPECT_TRUE(fogShader(fogtest::fog(map, fogtest::profiles()[2].profile, {}))->polar.empty());
  EXPECT_TRUE(fogShader(fogtest::fog(map, fogtest::profiles()[0].profile,
                                     {.levels = 1, .detail = {.mu = 0.5}}))
                  ->polar.empty());
}

}  // namespace
}  // namespace volute
