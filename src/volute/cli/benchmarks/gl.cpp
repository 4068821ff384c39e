// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench gl`: pictures by OpenGL on the device there is, against the processor's.
#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/cli/bench_timing.hpp"
#include "volute/cli/benchmarks/benchmarks.hpp"
#include "volute/fog/fog_medium.hpp"
#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_renderer.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_marcher.hpp"

namespace volute::cli {
namespace {

constexpr int kPixels = 256;

/// The same picture for both.
struct GlCase {
  std::string name;
  Camera camera;
  GlScene scene;
  std::function<Image()> byProcessor;
};

Image byRender(const Camera& camera, const std::vector<AnyMedium>& media) {
  Progress quiet;
  return *render(camera, media, {}, quiet);
}

Status addVolumes(const BenchInput& input, Progress& progress, std::vector<GlCase>& cases) {
  VOLUTE_ASSIGN(const auto sequences, benchSequences(input, progress));
  for (const auto& [name, sequence] : sequences) {
    const VolumeInfo& info = sequence.info;
    const Camera camera = Camera::framing(info.bounds, kPixels, kPixels);
    const double extinction = 4 / info.bounds.size().maxCoeff();
    for (const Basis basis : {Basis::kBox, Basis::kTrilinear}) {
      BrickSlice slice = BrickSlice::fromDense(info, sequence.frame(info.frames / 2));
      slice.setBasis(basis);
      const auto shared = std::make_shared<const BrickSlice>(std::move(slice));
      const std::vector<AnyMedium> media{AnyMedium(VoxelMedium(shared, 1, extinction))};
      cases.push_back(
          {fmt::format("{}, absorbing, {}", name, basis == Basis::kBox ? "box" : "trilinear"),
           camera,
           {.volumes = {{shared, 1, extinction}}},
           [=] { return byRender(camera, media); }});
    }
  }
  return {};
}

/// A hilly map of 128 x 128 quadratic B-splines in layers.
Status addFog(std::vector<GlCase>& cases) {
  constexpr int kSide = 128;
  SplineGrid grid(kSide, kSide);
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i)
      grid.at(i, j) = 0.02 * std::max(0.0, std::sin(0.19 * i) + std::cos(0.23 * j + 0.1 * i));
  }
  VOLUTE_ASSIGN(const auto map, FogMap::fromCoefficients(grid, {.cell = 2}));
  const FogProfile::Knot knots[] = {{0, 1}, {10, 0.5}, {30, 0}};
  VOLUTE_ASSIGN(const auto profile, FogProfile::linear(knots));
  VOLUTE_ASSIGN(const auto fog, FogMedium::make(map, profile, {.degree = 2}));
  const Camera camera = Camera::pinhole({Vec3(20, 5, 12), Vec3(130, 140, 4)}, 60, kPixels, kPixels);
  const std::vector<AnyMedium> media{AnyMedium(fog)};
  cases.push_back({"fog", camera, {.fogs = {fog}}, [=] { return byRender(camera, media); }});
  return {};
}

void addSmoke(std::vector<GlCase>& cases) {
  const auto mesh = hallMesh(0.8, 1);
  const auto locator = std::make_shared<const TetLocator>(mesh);
  std::vector<float> extinction = plume(*mesh, 0, 1);
  for (float& value : extinction) value *= 0.15F;
  const std::vector<float> source(3 * extinction.size(), 0.8F);
  const Camera camera = Camera::framing(mesh->bounds(), kPixels, kPixels);
  const auto marcher = std::make_shared<TetMarcher>(locator);
  marcher->setExtinction(extinction);
  marcher->setSource(source);
  cases.push_back({fmt::format("smoke, {} tetrahedra, lit", mesh->tets().size()),
                   camera,
                   {.smokes = {{locator, extinction, source}}},
                   [=] {
                     Image image(kPixels, kPixels);
                     std::vector<float> rgbt(4 * kPixels * kPixels);
                     marcher->litColor(camera, {}, rgbt);
                     for (std::size_t i = 0; i < rgbt.size() / 4; ++i)
                       std::copy_n(&rgbt[4 * i], 3, &image.pixels[3 * i]);
                     return image;
                   }});
}

double largestDifference(const Image& a, const Image& b) {
  double largest = 0, brightest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    largest = std::max<double>(largest, std::fabs(a.pixels[i] - b.pixels[i]));
    brightest = std::max<double>(brightest, b.pixels[i]);
  }
  return brightest > 0 ? largest / brightest : 0;
}

Status measure(const GlCase& one, GlRenderer& renderer, const std::string& device,
               std::vector<BenchRow>& rows) {
  Progress quiet;
  const Image expected = one.byProcessor();
  VOLUTE_ASSIGN(const Image image, renderer.render(one.camera, one.scene, {}, quiet));
  const double cpu = medianSeconds([&] { (void)one.byProcessor(); });
  const double gl = medianSeconds([&] {
    (void)renderer.draw(one.camera, one.scene, GlQuantity::kLight, quiet);
    (void)renderer.takePasses();  // waits for the device
  });
  rows.push_back({one.name + ": cpu", 1 / cpu, "frames/s", 1.0});
  rows.push_back({one.name + ": gl", 1 / gl, "frames/s", cpu / gl, {{"device", device}}, device});
  rows.push_back({one.name + ": |gl - cpu| / maximum", largestDifference(image, expected), ""});
  return {};
}

}  // namespace

Result<std::vector<BenchRow>> benchGl(const BenchInput& input, Progress& progress) {
  VOLUTE_ASSIGN(const auto gl, HeadlessGl::create());
  VOLUTE_ASSIGN(auto renderer, GlRenderer::create());
  std::vector<GlCase> cases;
  VOLUTE_TRY(addVolumes(input, progress, cases));
  VOLUTE_TRY(addFog(cases));
  addSmoke(cases);
  std::vector<BenchRow> rows;
  for (const GlCase& one : cases) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before {}", one.name);
    VOLUTE_TRY(measure(one, renderer, gl.device().renderer, rows));
  }
  return rows;
}

}  // namespace volute::cli
