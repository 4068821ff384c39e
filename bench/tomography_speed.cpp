// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/tomography_speed.hpp"

#include <Eigen/SparseCore>

#include "bench/timing.hpp"
#include "volute/base/parallel.hpp"
#include "volute/tomography/hull.hpp"
#include "volute/tomography/projector.hpp"

namespace volute::bench {
namespace {

constexpr int kIterations = 200;
constexpr float kMeasured = 0.3F;  // what the residuals are to, for the time that they take

// The peer: what one writes with a library of sparse matrices.

using Sparse = Eigen::SparseMatrix<float, Eigen::RowMajor, int>;
using Colours = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

using SparseRow = std::vector<NodeWeight>;  ///< ascending columns

/// The rays of a pixel.
std::vector<WalkRay> raysOf(const Support& support, const Camera& camera, std::int32_t pixel,
                            int raysPerPixel) {
  const double x = pixel % camera.width(), y = pixel / camera.width();
  std::vector<WalkRay> rays;
  for (int i = 0; i < raysPerPixel; ++i) {
    const double dx = raysPerPixel == 1 ? 0.5 : i % 2 * 0.5 + 0.25;
    const double dy = raysPerPixel == 1 ? 0.5 : i / 2 * 0.5 + 0.25;
    const Segment segment = camera.ray(x + dx, y + dy);
    rays.push_back(walkRay(support, segment, touchedPart(support, segment)));
  }
  return rays;
}

/// Sorted, each column once, those that are no unknown left out.
SparseRow merged(SparseRow raw, std::span<const int> column) {
  std::erase_if(raw, [&](const NodeWeight& w) { return column[w.node] < 0; });
  std::ranges::sort(raw, {}, &NodeWeight::node);
  SparseRow row;
  for (const NodeWeight& w : raw) {
    if (!row.empty() && row.back().node == column[w.node])
      row.back().weight += w.weight;
    else
      row.push_back({column[w.node], w.weight});
  }
  return row;
}

/// The rows of the pixels that `projector` has, on all threads.
std::vector<SparseRow> sparseRows(const Projector& projector, std::span<const TomographyView> views,
                                  int raysPerPixel) {
  const Support& support = projector.support();
  const WalkLattice lattice{support.basis(),
                            {support.stride()[0], support.stride()[1], support.stride()[2]}};
  std::vector<int> column(support.latticeSize(), -1);
  for (std::size_t i = 0; i < support.size(); ++i) column[support.nodes()[i]] = static_cast<int>(i);
  std::vector<SparseRow> rows(projector.rows());
  parallelRanges(rows.size(), 256, [&](std::size_t begin, std::size_t end) {
    SparseRow raw;
    for (std::size_t r = begin; r < end; ++r) {
      const PixelRow& pixel = projector.pixels()[r];
      const auto rays = raysOf(support, views[pixel.view].camera, pixel.pixel, raysPerPixel);
      raw.clear();
      walkWeights(lattice, rays.data(), 1, raysPerPixel, &raw);
      rows[r] = merged(raw, column);
    }
  });
  return rows;
}

/// The matrix of the pixels that `projector` has.
Sparse assemble(const Projector& projector, std::span<const TomographyView> views,
                int raysPerPixel) {
  const auto rows = sparseRows(projector, views, raysPerPixel);
  Sparse matrix(static_cast<int>(rows.size()), static_cast<int>(projector.unknowns()));
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

/// Seconds for everything from the views to kIterations gradients S'(S a - p).
struct Timing {
  double setUp = 0, iterations = 0;

  double total() const { return setUp + iterations; }
};

Timing timeProjector(std::span<const ProjectorView> views, std::shared_ptr<const Support> support,
                     int rays, std::uint64_t tableBytes, std::unique_ptr<Projector>& projector) {
  Timing timing;
  timing.setUp =
      secondsOf([&] { projector = std::make_unique<Projector>(views, support, rays, tableBytes); });
  std::vector<float> x(4 * projector->unknowns(), 0.5F), y(4 * projector->rows()), g(x.size());
  auto residual = [](std::size_t, const float* sum, float* back) {
    for (int c = 0; c < 4; ++c) back[c] = sum[c] - kMeasured;
  };
  timing.iterations = secondsOf([&] {
    for (int k = 0; k < kIterations; ++k) projector->thereAndBack(x, residual, y, g);
  });
  return timing;
}

Timing timeSparse(const Projector& projector, std::span<const TomographyView> views, int rays) {
  Timing timing;
  Sparse matrix, transposed;
  timing.setUp = secondsOf([&] {
    matrix = assemble(projector, views, rays);
    transposed = matrix.transpose();
  });
  Colours x = Colours::Constant(matrix.cols(), 3, 0.5F), y(matrix.rows(), 3), g(x.rows(), 3);
  timing.iterations = secondsOf([&] {
    for (int k = 0; k < kIterations; ++k) {
      multiply(matrix, x, y);
      y.array() -= kMeasured;
      multiply(transposed, y, g);
    }
  });
  return timing;
}

}  // namespace

void addProjectorSpeed(const FilmedScene& filmed, int rays, BenchRows& rows) {
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
      fmt::format("speed, {}, {} gradients", rays == 1 ? "1 ray" : "2x2 rays", kIterations);
  auto add = [&](std::string_view what, const Timing& timing) {
    rows.add({fmt::format("{}: {}, set-up", prefix, what), timing.setUp, "s",
              timing.setUp / sparse.setUp});
    rows.add({fmt::format("{}: {}, with set-up", prefix, what), timing.total(), "s",
              timing.total() / sparse.total()});
  };
  add("sparse matrix (Eigen)", sparse);
  add("weights written down", written);
  add("matrix-free", walk);
}

}  // namespace volute::bench
