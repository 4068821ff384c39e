// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/gl_paper_fog.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "volute/base/parallel.hpp"
#include "volute/gl/gl_rays.hpp"
#include "volute/gl/glsl_sources.hpp"
#include "volute/wavelet/bspline.hpp"

namespace volute::bench {
namespace {

constexpr const char* kSettings = R"glsl(
#define DEGREE {degree}
#define SPLINES {splines}
#define WAVELETS {wavelets}
#define MOST_LEVELS {levels}
#define WAVELET_BASES {bases}
)glsl";

// Rays over cells as fog/plane_walk.hpp has them, and the functions of fog/paper_walk.cpp.
constexpr const char* kWalk = R"glsl(
layout(std430) readonly buffer Grids { float grids[]; };

uniform vec3 eye;           // x, y [cells of the map], z [m] above the slab's bottom
uniform float perMetre;     // [cells/m]
uniform float top;          // [m] above the bottom
uniform float margin;       // [cells] around the map
// Bands: the coarsest approximation, then details from the finest level on. With wavelets a detail has three grids of the
// coarser level, one after the other, else one of its own.
uniform int levels;
uniform ivec4 grid[MOST_LEVELS + 1];   // where it begins, columns, rows, the level of the cells
uniform ivec4 cells[MOST_LEVELS + 1];  // x0, y0, x1, y1
uniform vec4 splineM[DEGREE + 1];           // the splines that touch a cell, by powers of u
uniform vec4 coarseSplineM[2 * SPLINES];    // of the coarser level, in even and in odd cells of the finer
uniform vec4 coarseWaveletM[2 * WAVELETS];
uniform ivec2 firstSpline;                  // the first that touches cell 0, cell 1
uniform ivec2 firstWavelet;

// Gauss' rule, exact for the product of two pieces of the degree.
#if DEGREE == 0
const int POINTS = 1;
const float POINT[1] = float[](0.0);
const float WEIGHT[1] = float[](1.0);
#elif DEGREE == 1
const int POINTS = 2;
const float POINT[2] = float[](-0.5773502692, 0.5773502692);
const float WEIGHT[2] = float[](0.5, 0.5);
#else
const int POINTS = 3;
const float POINT[3] = float[](-0.7745966692, 0.0, 0.7745966692);
const float WEIGHT[3] = float[](0.2777777778, 0.4444444444, 0.2777777778);
#endif

float power(vec4 m, float u) { return m.x + u * (m.y + u * m.z); }

float at(int begin, ivec2 counts, int i, int j) {
  if (i < 0 || j < 0 || i >= counts.x || j >= counts.y) return 0.0;
  return grids[begin + j * counts.x + i];
}

float splineDensity(int band, ivec2 cell, vec2 u) {
  float sum = 0.0;
  for (int j = 0; j <= DEGREE; ++j) {
    float row = 0.0;
    for (int i = 0; i <= DEGREE; ++i)
      row += power(splineM[i], u.x) * at(grid[band].x, grid[band].yz, cell.x - DEGREE + i, cell.y - DEGREE + j);
    sum += power(splineM[j], u.y) * row;
  }
  return sum;
}

#if WAVELET_BASES
// phi psi, psi phi and psi psi (equation 10).
float waveletDensity(int band, ivec2 cell, vec2 u) {
  ivec2 odd = cell & 1;
  ivec2 spline = ivec2(firstSpline[odd.x], firstSpline[odd.y]) + (cell >> 1);
  ivec2 wavelet = ivec2(firstWavelet[odd.x], firstWavelet[odd.y]) + (cell >> 1);
  ivec2 counts = grid[band].yz;
  int phiPsi = grid[band].x;
  int psiPhi = phiPsi + counts.x * counts.y;
  int psiPsi = psiPhi + counts.x * counts.y;
  float phiX[SPLINES];
  float psiX[WAVELETS];
  for (int i = 0; i < SPLINES; ++i) phiX[i] = power(coarseSplineM[odd.x * SPLINES + i], u.x);
  for (int i = 0; i < WAVELETS; ++i) psiX[i] = power(coarseWaveletM[odd.x * WAVELETS + i], u.x);
  float sum = 0.0;
  for (int j = 0; j < WAVELETS; ++j) {
    float row = 0.0;
    for (int i = 0; i < SPLINES; ++i) row += phiX[i] * at(phiPsi, counts, spline.x + i, wavelet.y + j);
    for (int i = 0; i < WAVELETS; ++i) row += psiX[i] * at(psiPsi, counts, wavelet.x + i, wavelet.y + j);
    sum += power(coarseWaveletM[odd.y * WAVELETS + j], u.y) * row;
  }
  for (int j = 0; j < SPLINES; ++j) {
    float row = 0.0;
    for (int i = 0; i < WAVELETS; ++i) row += psiX[i] * at(psiPhi, counts, wavelet.x + i, spline.y + j);
    sum += power(coarseSplineM[odd.y * SPLINES + j], u.y) * row;
  }
  return sum;
}
#endif

float density(int band, ivec2 cell, vec2 u) {
#if WAVELET_BASES
  if (band > 0) return waveletDensity(band, cell, u);
#endif
  return splineDensity(band, cell, u);
}

float crossing(float o, float d, int cell) {
  return d == 0.0 ? FARTHEST : (float(cell + (d > 0.0 ? 1 : 0)) - o) / d;
}

int entered(float o, float d, float s, int low, int high) {
  float p = d == 0.0 ? o : o + d * s;
  return clamp(d < 0.0 ? int(ceil(p)) - 1 : int(floor(p)), low, high - 1);
}

float integral(int band, vec2 o, vec2 d, float end) {
  float scale = exp2(-float(grid[band].w));
  o = (o + margin) * scale;
  d *= scale;
  ivec4 rect = cells[band];
  float begin = 0.0;
  if (rect.x >= rect.z || rect.y >= rect.w) return 0.0;
  if (!clipAxis(o.x, d.x, float(rect.x), float(rect.z), begin, end)) return 0.0;
  if (!clipAxis(o.y, d.y, float(rect.y), float(rect.w), begin, end)) return 0.0;
  ivec2 cell = ivec2(entered(o.x, d.x, begin, rect.x, rect.z), entered(o.y, d.y, begin, rect.y, rect.w));
  vec2 leave = vec2(crossing(o.x, d.x, cell.x), crossing(o.y, d.y, cell.y));
  float sum = 0.0;
  while (begin < end) {
    int axis = leave.y < leave.x ? 1 : 0;
    float to = min(leave[axis], end);
    if (to > begin) {
      for (int i = 0; i < POINTS; ++i) {
        float s = 0.5 * (begin + to) + 0.5 * (to - begin) * POINT[i];
        sum += (to - begin) * WEIGHT[i] * density(band, cell, clamp(o + d * s - vec2(cell), 0.0, 1.0));
      }
      begin = to;
    }
    cell[axis] += d[axis] > 0.0 ? 1 : -1;
    if (cell[axis] < rect[axis] || cell[axis] >= rect[axis + 2]) break;
    leave[axis] = crossing(o[axis], d[axis], cell[axis]);
  }
  return sum;
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (!castRay(pixel)) return;
  float end = rayEnd;
  if (rayDirection.z != 0.0) end = ((rayDirection.z > 0.0 ? top : 0.0) - eye.z) / rayDirection.z;
  vec2 d = rayDirection.xy * perMetre;
  float sum = 0.0;
  for (int band = 0; band <= levels; ++band) sum += integral(band, eye.xy, d, end);
  imageStore(picture, pixel, vec4(vec3(1.0 - exp(-sum)), sum));
}
)glsl";

constexpr int kMaxLevels = 3;

using Powers = std::array<float, 4>;

int floorHalf(int n) {
  return n >= 0 ? n / 2 : -((1 - n) / 2);
}

/// Functions of the coarser level, sums of taps_n times fine spline 2k + begin + n, as monomials of
/// u in an even and in an odd cell of the finer level.
struct CoarsePieces {
  int count = 0;  ///< that touch a cell, at most
  std::array<int, 2> first{};
  std::vector<Powers> powers;  ///< shape (2, count)

  CoarsePieces(const std::vector<double>& taps, int begin, int degree) {
    const SplinePieces fine = splinePieces(degree);
    const int last = static_cast<int>(taps.size()) - 1;
    for (int odd = 0; odd < 2; ++odd) {
      const int touching = odd - degree - begin;  // the first fine spline, counted from begin
      first[odd] = floorHalf(touching - last + 1);
      count = std::max(count, floorHalf(odd - begin) - first[odd] + 1);
    }
    powers.resize(2 * static_cast<std::size_t>(count));
    for (int odd = 0; odd < 2; ++odd) {
      for (int k = 0; k < count; ++k) {
        for (int i = 0; i <= degree; ++i) {
          const int n = odd - degree + i - begin - 2 * (first[odd] + k);
          if (n < 0 || n > last)
            continue;
          for (int a = 0; a < 4; ++a)
            powers[odd * count + k][a] += static_cast<float>(taps[n] * fine[i][a]);
        }
      }
    }
  }
};

/// The numbers of some grids in a row, and where each band begins.
struct Packed {
  std::vector<float> values;
  std::vector<std::array<int, 4>> grids, cells;

  void add(const SplineGrid& grid, int level, const CellRect& rect) {
    grids.push_back({static_cast<int>(values.size()), grid.columns, grid.rows, level});
    cells.push_back({rect.x0, rect.y0, rect.x1, rect.y1});
    append(grid);
  }

  void append(const SplineGrid& grid) { values.insert(values.end(), grid.c.begin(), grid.c.end()); }
};

Packed pack(const PaperPicture& picture) {
  const PaperFog& fog = *picture.fog;
  Packed packed;
  const auto& coarsest = fog.approximation(fog.levels());
  packed.add(coarsest.grid, fog.levels(), coarsest.cells);
  for (int level = 0; level < fog.levels(); ++level) {
    if (picture.deconstructed) {
      packed.add(fog.detail(level).grid, level, fog.detail(level).cells);
      continue;
    }
    const auto& wavelets = fog.wavelets(level);
    packed.add(wavelets.phiPsi, level, wavelets.cells);
    packed.append(wavelets.psiPhi);
    packed.append(wavelets.psiPsi);
  }
  return packed;
}

}  // namespace

Image byCpu(const PaperPicture& picture, const Camera& camera) {
  Image image(camera.width(), camera.height());
  parallelFor(static_cast<std::size_t>(camera.height()), [&](std::size_t y) {
    for (int x = 0; x < camera.width(); ++x) {
      const Segment ray = camera.ray(x + 0.5, static_cast<double>(y) + 0.5);
      const Vec3 from = ray.origin / picture.cell, way = ray.direction / picture.cell;
      const double z = ray.direction.z();
      double end = ray.end;
      if (z != 0)
        end = ((z > 0 ? picture.top : picture.bottom) - ray.origin.z()) / z;
      const PlaneRay flat{from.x(), from.y(), way.x(), way.y()};
      const double depth = picture.deconstructed ? picture.fog->deconstructed(flat, end, 1)
                                                 : picture.fog->undeconstructed(flat, end, 1);
      const std::size_t pixel = y * static_cast<std::size_t>(camera.width()) + x;
      std::fill_n(&image.pixels[3 * pixel], 3, static_cast<float>(1 - std::exp(-depth)));
    }
  });
  return image;
}

Result<GlPaperFog> GlPaperFog::make(const PaperPicture& picture) {
  const PaperFog& fog = *picture.fog;
  const int degree = fog.degree();
  if (degree > 2 || fog.levels() > kMaxLevels) {
    return fail(ErrorCode::kUnsupported,
                "the paper's walks are drawn by OpenGL for degrees 0 to 2 and up to {} levels; got "
                "degree {} and {} levels",
                kMaxLevels, degree, fog.levels());
  }
  const CdfFilters& filters = shortestCdf(degree);
  const CoarsePieces splines(twoScale(degree), 0, degree);
  const CoarsePieces wavelets(filters.wavelet, filters.waveletFirst, degree);
  const std::string settings =
      fmt::format(kSettings, fmt::arg("degree", degree), fmt::arg("splines", splines.count),
                  fmt::arg("wavelets", wavelets.count), fmt::arg("levels", kMaxLevels),
                  fmt::arg("bases", picture.deconstructed ? 0 : 1));
  const ShaderStage stage{
      GL_COMPUTE_SHADER,
      {{"paper fog settings", settings}, {"ray.glsl", glsl::kRay}, {"gl_paper_fog.cpp", kWalk}}};
  VOLUTE_ASSIGN(auto program, GlProgram::link({&stage, 1}));
  GlPaperFog made(picture, std::move(program));
  const Packed packed = pack(picture);
  made.grids_ = makeBuffer(std::span<const float>(packed.values));
  const GlProgram& set = made.program_;
  const SplinePieces fine = splinePieces(degree);
  std::vector<Powers> own;
  for (int i = 0; i <= degree; ++i) {
    own.emplace_back();
    std::ranges::copy(fine[i], own.back().begin());
  }
  set.set("levels", fog.levels());
  set.set("grid", std::span<const std::array<int, 4>>(packed.grids));
  set.set("cells", std::span<const std::array<int, 4>>(packed.cells));
  set.set("splineM", std::span<const Powers>(own));
  set.set("coarseSplineM", std::span<const Powers>(splines.powers));
  set.set("coarseWaveletM", std::span<const Powers>(wavelets.powers));
  set.set("firstSpline", splines.first);
  set.set("firstWavelet", wavelets.first);
  set.set("margin", static_cast<float>(fog.margin()));
  set.set("perMetre", static_cast<float>(1 / picture.cell));
  set.set("top", static_cast<float>(picture.top - picture.bottom));
  return made;
}

void GlPaperFog::draw(const Camera& camera, GlPasses& passes) {
  if (camera.width() != width_ || camera.height() != height_) {
    width_ = camera.width(), height_ = camera.height();
    target_ = makeTexture2d(GL_RGBA32F, width_, height_);
  }
  const Vec3& eye = camera.eye();
  program_.set("eye",
               Vec3(eye.x() / picture_.cell, eye.y() / picture_.cell, eye.z() - picture_.bottom));
  program_.bindStorage("Grids", 0, grids_);
  bindRays(program_, camera, eye, {});
  glBindImageTexture(0, target_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  passes.run("walk", "fog", [&] { runOver(program_, width_, height_); });
}

Image GlPaperFog::render(const Camera& camera, GlPasses& passes) {
  draw(camera, passes);
  Image image(width_, height_);
  glGetTextureImage(target_.name(), 0, GL_RGB, GL_FLOAT,
                    static_cast<GLsizei>(image.pixels.size() * sizeof(float)), image.pixels.data());
  return image;
}

}  // namespace volute::bench
