// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench tomography`: what each method makes of 8 views of 180 x 144 of a made-up fire, and
// how long the products with the projection matrix take beside an explicit sparse one. The pictures
// are integrals through twice the resolution in the other basis, never through the unknowns' own.
#include <Eigen/SparseCore>
#include <cmath>
#include <numbers>
#include <random>

#include "volute/base/parallel.hpp"
#include "volute/cli/bench_timing.hpp"
#include "volute/cli/benchmarks/benchmarks.hpp"
#include "volute/synth/synth.hpp"
#include "volute/tomography/hull.hpp"
#include "volute/tomography/project.hpp"
#include "volute/tomography/projector.hpp"
#include "volute/tomography/reconstruct.hpp"

namespace volute::cli {
namespace {

constexpr int kSide = 64;
constexpr int kWidth = 180, kHeight = 144;
constexpr int kIterations = 200;
constexpr double kFov = 42;

double seconds(auto&& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Cameras on a ring around the volume, at the given heights in turn.
std::vector<Camera> ring(const Box3& bounds, int count, double turn,
                         std::span<const double> heights) {
  std::vector<Camera> cameras;
  const double radius = 2.25 * bounds.size().x();
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * (i + turn) / count;
    const Vec3 eye = bounds.centre() +
                     radius * Vec3(std::cos(angle), std::sin(angle), heights[i % heights.size()]);
    cameras.push_back(Camera::pinhole({eye, bounds.centre()}, kFov, kWidth, kHeight));
  }
  return cameras;
}

/// What is filmed, and what is compared with.
struct Filmed {
  VolumeGeometry geometry;
  std::vector<float> truth;  ///< (z, y, x, 3), means over the voxels of the unknown volume
  std::vector<TomographyView> views;
  std::vector<Camera> others;
  std::vector<Image> otherImages;

  void addNoise(double sigma) {
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    for (TomographyView& view : views)
      for (float& value : view.radiance.pixels) value += static_cast<float>(sigma) * normal(random);
  }
};

std::vector<float> halved(std::span<const float> fine, int side) {
  std::vector<float> coarse(3 * static_cast<std::size_t>(side) * side * side);
  for (int z = 0; z < 2 * side; ++z)
    for (int y = 0; y < 2 * side; ++y)
      for (int x = 0; x < 2 * side; ++x)
        for (int c = 0; c < 3; ++c) {
          const std::size_t to = (static_cast<std::size_t>(z / 2) * side + y / 2) * side + x / 2;
          const std::size_t from = (static_cast<std::size_t>(z) * 2 * side + y) * 2 * side + x;
          coarse[3 * to + c] += fine[3 * from + c] / 8;
        }
  return coarse;
}

Result<Filmed> film(Progress& progress) {
  const SynthOptions options{SynthKind::kFire, 2 * kSide, 1, 3, 3};
  VOLUTE_ASSIGN(const Sequence fire, synthesize(options, progress));
  const VolumeGeometry fine{fire.info.bounds, {2 * kSide, 2 * kSide, 2 * kSide}};
  Filmed filmed;
  filmed.geometry = {fire.info.bounds, {kSide, kSide, kSide}};
  filmed.truth = halved(fire.values, kSide);
  const std::vector<double> heights{0.07, 0.16, 0.0, -0.09, 0.3};
  for (const Camera& camera : ring(fine.bounds, 8, 0.2, heights))
    filmed.views.push_back({fmt::format("c{}", filmed.views.size()), camera,
                            projectVolume(fire.values, fine, Basis::kBox, camera, 4)});
  filmed.others = ring(fine.bounds, 24, 0.5, std::vector<double>{-0.17, 0.09, 0.34, 0.57});
  for (const Camera& camera : filmed.others)
    filmed.otherImages.push_back(projectVolume(fire.values, fine, Basis::kBox, camera, 4));
  return filmed;
}

struct Quality {
  double psnr = 0;      ///< of the other views [dB]
  double relative = 0;  ///< L2 of the other views
  double volume = 0;    ///< relative L2
};

Quality qualityOf(const Filmed& filmed, std::span<const float> volume, Basis basis) {
  double error = 0, light = 0, peak = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < filmed.others.size(); ++v) {
    const Image image = projectVolume(volume, filmed.geometry, basis, filmed.others[v], 4);
    for (std::size_t i = 0; i < image.pixels.size(); ++i, ++count) {
      const double truth = filmed.otherImages[v].pixels[i];
      error += std::pow(image.pixels[i] - truth, 2);
      light += truth * truth;
      peak = std::max(peak, truth);
    }
  }
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < volume.size(); ++i) {
    difference += std::pow(static_cast<double>(volume[i]) - filmed.truth[i], 2);
    size += std::pow(filmed.truth[i], 2);
  }
  return {10 * std::log10(peak * peak * static_cast<double>(count) / error),
          std::sqrt(error / light), std::sqrt(difference / size)};
}

TomographyOptions options(TomographySolver solver, Basis basis, int rays,
                          Regularization regularization, double lambda, int iterations) {
  TomographyOptions o;
  o.solver = solver;
  o.basis = basis;
  o.raysPerPixel = rays;
  o.regularization = regularization;
  o.lambda = lambda;
  o.iterations = iterations;
  return o;
}

struct Method {
  std::string name;
  TomographyOptions options;
};

std::vector<Method> methods() {
  using enum TomographySolver;
  using R = Regularization;
  const Basis box = Basis::kBox, hat = Basis::kTrilinear;
  auto unconstrained = options(kSirt, hat, 1, R::kNone, 0, 200);
  unconstrained.nonNegative = false;
  auto plain = options(kApg, hat, 4, R::kTv, 1e-4, 200);
  plain.sparsity = 0;
  return {{"SIRT unconstrained, 200", unconstrained},
          {"SIRT, 200", options(kSirt, hat, 1, R::kNone, 0, 200)},
          {"CGLS and clamp, 100", options(kCgls, hat, 1, R::kNone, 0, 100)},
          {"MLEM, 200", options(kMlem, hat, 1, R::kNone, 0, 200)},
          {"APG box, 50", options(kApg, box, 1, R::kNone, 0, 50)},
          {"APG trilinear, 200", options(kApg, hat, 1, R::kNone, 0, 200)},
          {"APG trilinear, 200, 2x2 rays", options(kApg, hat, 4, R::kNone, 0, 200)},
          {"APG, wavelets 1e-4", options(kApg, hat, 4, R::kWavelet, 1e-4, 200)},
          {"APG, smooth 1e-4", options(kApg, hat, 4, R::kSmooth, 1e-4, 200)},
          {"APG, TV 1e-4", plain},
          {"APG, TV 1e-4, sparse", options(kApg, hat, 4, R::kTv, 1e-4, 200)},
          {"auto", TomographyOptions{}}};
}

Status addQuality(const Filmed& filmed, const std::string& prefix, const Method& method,
                  Progress& progress, std::vector<BenchRow>& rows) {
  progress.report(method.name, 0, 0);
  Result<Reconstruction> result;
  const double time = seconds(
      [&] { result = reconstruct(filmed.views, filmed.geometry, method.options, {}, progress); });
  VOLUTE_ASSIGN(const Reconstruction done, std::move(result));
  const Quality quality = qualityOf(filmed, done.volume, method.options.basis);
  const std::string name = fmt::format("{}: {}", prefix, method.name);
  rows.push_back({name + ", other views", quality.psnr, "dB"});
  rows.push_back({name + ", other views", quality.relative, "relative L2"});
  rows.push_back({name + ", volume", quality.volume, "relative L2"});
  rows.push_back({name + ", time", time, "s"});
  return {};
}

// The peer: what one writes with a library of sparse matrices.

using Sparse = Eigen::SparseMatrix<float, Eigen::RowMajor, int>;
using Colours = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// The matrix of the pixels that `projector` has, filled row by row on all threads.
Sparse assemble(const Projector& projector, std::span<const TomographyView> views,
                int raysPerPixel) {
  const Support& support = projector.support();
  WalkLattice lattice{support.basis(),
                      {support.stride()[0], support.stride()[1], support.stride()[2]}};
  std::vector<int> column(support.latticeSize(), -1);
  for (std::size_t i = 0; i < support.size(); ++i) column[support.nodes()[i]] = static_cast<int>(i);
  std::vector<std::vector<NodeWeight>> rows(projector.rows());
  parallelRanges(rows.size(), 256, [&](std::size_t begin, std::size_t end) {
    std::vector<NodeWeight> raw;
    for (std::size_t r = begin; r < end; ++r) {
      const PixelRow& pixel = projector.pixels()[r];
      const Camera& camera = views[pixel.view].camera;
      const double x = pixel.pixel % camera.width(), y = pixel.pixel / camera.width();
      std::vector<WalkRay> rays;
      for (int i = 0; i < raysPerPixel; ++i) {
        const double dx = raysPerPixel == 1 ? 0.5 : i % 2 * 0.5 + 0.25;
        const double dy = raysPerPixel == 1 ? 0.5 : i / 2 * 0.5 + 0.25;
        rays.push_back(walkRay(support, camera.ray(x + dx, y + dy)));
      }
      raw.clear();
      walkWeights(lattice, rays.data(), raysPerPixel, raw);
      std::erase_if(raw, [&](const NodeWeight& w) { return column[w.node] < 0; });
      std::ranges::sort(raw, {}, &NodeWeight::node);
      for (const NodeWeight& w : raw) {
        if (!rows[r].empty() && rows[r].back().node == column[w.node])
          rows[r].back().weight += w.weight;
        else
          rows[r].push_back({column[w.node], w.weight});
      }
    }
  });
  Sparse matrix(static_cast<int>(rows.size()), static_cast<int>(support.size()));
  std::size_t count = 0;
  for (const auto& row : rows) count += row.size();
  matrix.resizeNonZeros(static_cast<int>(count));
  int at = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    matrix.outerIndexPtr()[r] = at;
    for (const NodeWeight& w : rows[r]) {
      matrix.innerIndexPtr()[at] = w.node;
      matrix.valuePtr()[at++] = w.weight;
    }
  }
  matrix.outerIndexPtr()[rows.size()] = at;
  return matrix;
}

/// y = A x by blocks of rows on all threads.
void multiply(const Sparse& a, const Colours& x, Colours& y) {
  parallelRanges(static_cast<std::size_t>(a.rows()), 64, [&](std::size_t begin, std::size_t end) {
    const auto first = static_cast<Eigen::Index>(begin),
               count = static_cast<Eigen::Index>(end - begin);
    y.middleRows(first, count).noalias() = a.middleRows(first, count) * x;
  });
}

/// Seconds for everything from the views to kIterations products with S and S' each.
struct Timing {
  double setUp = 0, iterations = 0;

  double total() const { return setUp + iterations; }
};

Timing timeProjector(std::span<const ProjectorView> views, std::shared_ptr<const Support> support,
                     int rays, std::uint64_t tableBytes, std::unique_ptr<Projector>& projector) {
  Timing timing;
  timing.setUp =
      seconds([&] { projector = std::make_unique<Projector>(views, support, rays, tableBytes); });
  std::vector<float> x(4 * projector->unknowns(), 0.5F), y(4 * projector->rows()), g(x.size());
  timing.iterations = seconds([&] {
    for (int k = 0; k < kIterations; ++k) {
      projector->forward(x, y);
      projector->adjoint(y, g);
    }
  });
  return timing;
}

Timing timeSparse(const Projector& projector, std::span<const TomographyView> views, int rays) {
  Timing timing;
  Sparse matrix, transposed;
  timing.setUp = seconds([&] {
    matrix = assemble(projector, views, rays);
    transposed = matrix.transpose();
  });
  Colours x = Colours::Constant(matrix.cols(), 3, 0.5F), y(matrix.rows(), 3), g(x.rows(), 3);
  timing.iterations = seconds([&] {
    for (int k = 0; k < kIterations; ++k) {
      multiply(matrix, x, y);
      multiply(transposed, y, g);
    }
  });
  return timing;
}

void addSpeed(const Filmed& filmed, int rays, std::vector<BenchRow>& rows) {
  std::vector<std::vector<std::uint8_t>> silhouettes;
  for (const TomographyView& view : filmed.views)
    silhouettes.push_back(dilatedSilhouette(view, {}));
  const auto hull = visualHull(filmed.views, silhouettes, filmed.geometry);
  const auto support = std::make_shared<const Support>(filmed.geometry, Basis::kTrilinear, hull);
  std::vector<ProjectorView> views;
  for (std::size_t v = 0; v < filmed.views.size(); ++v)
    views.push_back({&filmed.views[v].camera, silhouettes[v]});
  std::unique_ptr<Projector> walking, table;
  const Timing walk = timeProjector(views, support, rays, 0, walking);
  const Timing written = timeProjector(views, support, rays, std::uint64_t{1} << 31, table);
  const Timing sparse = timeSparse(*walking, filmed.views, rays);
  const std::string prefix =
      fmt::format("speed, {}, {} products each way", rays == 1 ? "1 ray" : "2x2 rays", kIterations);
  auto add = [&](std::string_view what, const Timing& timing) {
    rows.push_back({fmt::format("{}: {}, set-up", prefix, what), timing.setUp, "s",
                    timing.setUp / sparse.setUp});
    rows.push_back({fmt::format("{}: {}, with set-up", prefix, what), timing.total(), "s",
                    timing.total() / sparse.total()});
  };
  add("sparse matrix (Eigen)", sparse);
  add("weights written down", written);
  add("matrix-free", walk);
}

}  // namespace

Result<std::vector<BenchRow>> benchTomography(const BenchInput&, Progress& progress) {
  std::vector<BenchRow> rows;
  VOLUTE_ASSIGN(Filmed filmed, film(progress));
  for (int rays : {1, 4}) addSpeed(filmed, rays, rows);
  for (const Method& method : methods())
    VOLUTE_TRY(addQuality(filmed, "fire", method, progress, rows));
  float peak = 0;
  for (const TomographyView& view : filmed.views)
    peak = std::max(peak, *std::ranges::max_element(view.radiance.pixels));
  filmed.addNoise(0.02 * peak);
  for (const Method& method : methods()) {
    if (method.name == "APG trilinear, 200, 2x2 rays" || method.name == "auto")
      VOLUTE_TRY(addQuality(filmed, "fire, noise of 2 %", method, progress, rows));
  }
  return rows;
}

}  // namespace volute::cli
