// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "volute/base/cancel_only.hpp"
#include "volute/tomography/box_blur.hpp"
#include "volute/tomography/fit.hpp"
#include "volute/tomography/hull.hpp"
#include "volute/tomography/lattice_field.hpp"
#include "volute/tomography/project.hpp"
#include "volute/tomography/reduced_view.hpp"
#include "volute/tomography/vector_ops.hpp"

namespace volute {
namespace {

using Vector = std::vector<float>;
using Bands = std::array<double, 3>;  // from fine to coarse

// Bands end at what boxes of so many voxels take.
constexpr int kFine = 3, kCoarse = 7;
constexpr int kSamples = 3;

/// result = the mean over a cube of `width` voxels around each of the lattice.
void blur(const Support& support, int width, const LatticeField& field, LatticeField& result,
          LatticeField& spare) {
  const auto size = static_cast<std::ptrdiff_t>(support.latticeSize());
  const std::ptrdiff_t radius = width / 2;
  const auto along = [&](std::ptrdiff_t stride, const LatticeField& from, LatticeField& to) {
    forElements(support.latticeSize(), [&](std::size_t i) {
      const auto n = static_cast<std::ptrdiff_t>(i);
      Colour sum = Colour::Zero();
      for (std::ptrdiff_t r = -radius; r <= radius; ++r) {
        if (const std::ptrdiff_t m = n + r * stride; m >= 0 && m < size)
          sum += from[m];
      }
      to[n] = sum / static_cast<float>(width);
    });
  };
  const auto& stride = support.stride();
  along(stride[0], field, result);
  along(stride[1], result, spare);
  along(stride[2], spare, result);
}

/// What a frame's pictures leave open around a volume.
class Posterior {
 public:
  Posterior(const FrameProblem& problem, std::span<const TomographyView> views,
            const TomographyOptions& options, Vector estimate)
      : problem_(problem),
        support_(*problem.support),
        estimate_(std::move(estimate)),
        field_(support_),
        precision_(support_),
        blurred_(support_),
        spare_(support_) {
    setPrecision();
    setSights(views, options);
    setPreconditioner();
  }

  /// What a sample is of besides noise.
  enum class Open { kNothing, kPrior };

  /// What may be added to the estimate, three channels each.
  Vector sample(std::mt19937& random, Open open = Open::kPrior) {
    constexpr int kIterations = 40;
    Vector x(4 * support_.size()), r = rightSide(random, open), z(r.size()), h(r.size());
    const auto precondition = [&] {
      forElements(z.size(), [&](std::size_t i) { z[i] = inverse_[i] * r[i]; });
    };
    precondition();
    Vector p = z;
    double rz = dot(r, z);
    for (int k = 0; k < kIterations && rz > 0; ++k) {
      hessian(p, h);
      const double curvature = dot(p, h);
      if (!(curvature > 0))
        break;
      const auto alpha = static_cast<float>(rz / curvature);
      forElements(x.size(), [&](std::size_t i) {
        x[i] += alpha * p[i];
        r[i] -= alpha * h[i];
      });
      precondition();
      const double next = dot(r, z);
      const auto beta = static_cast<float>(next / rz);
      rz = next;
      forElements(p.size(), [&](std::size_t i) { p[i] = z[i] + beta * p[i]; });
    }
    return x;
  }

  /// The sample with its bands scaled, no further down than to a volume of 0.
  void scale(const Bands& by, bool nonNegative, Vector& x) {
    const auto blurred = [&](int width) {
      field_.fill(x);
      blur(support_, width, field_, blurred_, spare_);
      Vector out(x.size());
      blurred_.copyTo(out);
      return out;
    };
    if (by != Bands{1, 1, 1}) {
      const Vector fine = blurred(kFine), coarse = blurred(kCoarse);
      for (std::size_t i = 0; i < x.size(); ++i)
        x[i] = static_cast<float>(by[0] * (x[i] - fine[i]) + by[1] * (fine[i] - coarse[i]) +
                                  by[2] * coarse[i]);
    }
    if (nonNegative)
      forElements(x.size(), [&](std::size_t i) { x[i] = std::max(x[i], -estimate_[i]); });
  }

  /// Three times the weighted mean of each unknown and the six around it: few samples are noisy.
  void smooth(Vector& squares) {
    for (int times = 0; times < 3; ++times) {
      field_.fill(squares);
      const auto nodes = support_.nodes();
      forElements(nodes.size(), [&](std::size_t i) {
        Colour sum = 2 * field_[nodes[i]];
        for (const std::int32_t stride : support_.stride())
          sum += field_[nodes[i] - stride] + field_[nodes[i] + stride];
        for (int c = 0; c < 3; ++c) squares[4 * i + static_cast<std::size_t>(c)] = sum[c] / 8;
      });
    }
  }

 private:
  /// One over the variance of a difference between neighbours: the mean square of those nearby,
  /// times kWider^2, as the estimate is smoother than what it stands for.
  void setPrecision() {
    constexpr float kWider = 2, kFloor = 0.02F;
    field_.fill(estimate_);
    const auto& stride = support_.stride();
    const auto size = static_cast<std::ptrdiff_t>(support_.latticeSize());
    Colour sum = Colour::Zero();
    float count = 0;
    for (std::ptrdiff_t n = 0; n < size; ++n) {
      Colour square = Colour::Zero();
      for (const std::int32_t step : stride) {
        if (n + step < size)
          square += (field_[n + step] - field_[n]).square() / 3;
      }
      precision_[n] = square;
      if ((field_[n] > 0).any()) {
        sum += square;
        ++count;
      }
    }
    const Colour least = kFloor * kFloor * sum / std::max(count, 1.0F);
    blur(support_, 3, precision_, blurred_, spare_);
    forElements(support_.latticeSize(), [&](std::size_t n) {
      const auto at = static_cast<std::ptrdiff_t>(n);
      const Colour square = kWider * kWider * (blurred_[at] + least);
      precision_[at] = (square > 0).select(1 / square, Colour::Zero());
    });
  }

  /// How the picture of the estimate changes by a pixel to the right and down, where sights are
  /// uncertain.
  void setSights(std::span<const TomographyView> views, const TomographyOptions& options) {
    sightError_.resize(views.size());
    for (std::size_t v = 0; v < views.size(); ++v) sightError_[v] = views[v].sightError;
    if (std::ranges::all_of(sightError_, [](double error) { return !(error > 0); }))
      return;
    const Vector volume = toVolume(support_, estimate_);
    std::vector<Image> seen;
    for (const TomographyView& view : views)
      seen.push_back(projectVolume(volume, support_.geometry(), options.basis, view.camera,
                                   options.raysPerPixel));
    const auto rows = problem_.projector->pixels();
    slopes_.resize(8 * rows.size());
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const Image& image = seen[static_cast<std::size_t>(rows[row].view)];
      const int x = rows[row].pixel % image.width, y = rows[row].pixel / image.width;
      const int left = std::max(x - 1, 0), right = std::min(x + 1, image.width - 1);
      const int above = std::max(y - 1, 0), below = std::min(y + 1, image.height - 1);
      for (int c = 0; c < 3; ++c) {
        const auto at = 8 * row + static_cast<std::size_t>(c);
        slopes_[at] = (image.at(right, y, c) - image.at(left, y, c)) /
                      static_cast<float>(std::max(1, right - left));
        slopes_[at + 4] = (image.at(x, below, c) - image.at(x, above, c)) /
                          static_cast<float>(std::max(1, below - above));
      }
    }
  }

  void setPreconditioner() {
    constexpr float kShare = 0.1F;  // of the majorizer, which is far above the diagonal
    const auto majorizer = problem_.data.majorizer();
    const auto nodes = support_.nodes();
    inverse_.resize(4 * nodes.size());
    const auto variance = static_cast<float>(problem_.variance);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      Colour sum = 3 * precision_[nodes[i]];
      for (const std::int32_t stride : support_.stride()) sum += precision_[nodes[i] - stride];
      for (std::size_t c = 0; c < 3; ++c)
        inverse_[4 * i + c] =
            1 / std::max(1e-30F, kShare * majorizer[i] / variance + sum[static_cast<int>(c)]);
    }
  }

  /// S' W^2 / variance (noise and sights) + D' sqrt(precision) noise, the latter where it is open.
  Vector rightSide(std::mt19937& random, Open open) {
    std::normal_distribution<float> normal;
    const LeastSquares& data = problem_.data;
    const auto pixels = problem_.projector->pixels();
    std::vector<std::array<float, 2>> off(sightError_.size());
    for (std::size_t v = 0; v < off.size(); ++v) {
      // The error is that of both directions together.
      const auto each = static_cast<float>(sightError_[v] * std::sqrt(0.5));
      off[v] = {each * normal(random), each * normal(random)};
    }
    const auto variance = static_cast<float>(problem_.variance);
    Vector rows(4 * data.rows()), b(4 * data.unknowns());
    for (std::size_t row = 0; row < data.rows(); ++row) {
      const float weight = data.atLeast[row] != 0 ? 0 : data.squaredWeight[row] / variance;
      const float root = std::sqrt(weight);
      const auto& shift = off[static_cast<std::size_t>(pixels[row].view)];
      const float common = normal(random);
      for (std::size_t c = 0; c < 3; ++c) {
        const bool grey = !data.grey.empty() && data.grey[row] != 0;
        rows[4 * row + c] = root * (grey ? common : normal(random));
        if (!slopes_.empty())
          rows[4 * row + c] +=
              weight * (shift[0] * slopes_[8 * row + c] + shift[1] * slopes_[8 * row + 4 + c]);
      }
    }
    problem_.projector->adjoint(rows, b);
    if (open == Open::kNothing)
      return b;
    for (const std::int32_t stride : support_.stride()) {
      const auto size = static_cast<std::ptrdiff_t>(support_.latticeSize());
      for (std::ptrdiff_t n = 0; n < size; ++n) {
        spare_[n] = Colour::Zero();
        if ((precision_[n] == 0).all())
          continue;
        for (int c = 0; c < 3; ++c) spare_[n][c] = std::sqrt(precision_[n][c]) * normal(random);
      }
      const auto nodes = support_.nodes();
      forElements(nodes.size(), [&](std::size_t i) {
        const Colour difference = spare_[nodes[i] - stride] - spare_[nodes[i]];
        for (std::size_t c = 0; c < 3; ++c) b[4 * i + c] += difference[static_cast<int>(c)];
      });
    }
    return b;
  }

  /// out = (S' W^2 S / variance + D' precision D) x.
  void hessian(const Vector& x, Vector& out) {
    const LeastSquares& data = problem_.data;
    const auto scale = static_cast<float>(1 / problem_.variance);
    projected_.resize(4 * data.rows());
    data.projector->thereAndBack(
        x,
        [&](std::size_t row, const float* sum, float* back) {
          const bool grey = !data.grey.empty() && data.grey[row] != 0;
          const float mean = (sum[0] + sum[1] + sum[2]) / 3;
          // What is only a bound tells nothing of how much more there may be.
          const float weight = data.atLeast[row] != 0 ? 0 : scale * data.squaredWeight[row];
          for (std::size_t c = 0; c < 3; ++c) back[c] = weight * (grey ? mean : sum[c]);
          back[3] = 0;
        },
        projected_, out);
    field_.fill(x);
    const auto nodes = support_.nodes();
    forElements(nodes.size(), [&](std::size_t i) {
      const std::ptrdiff_t n = nodes[i];
      Colour sum = Colour::Zero();
      for (const std::int32_t stride : support_.stride())
        sum += precision_[n - stride] * (field_[n] - field_[n - stride]) -
               precision_[n] * (field_[n + stride] - field_[n]);
      for (std::size_t c = 0; c < 3; ++c) out[4 * i + c] += sum[static_cast<int>(c)];
    });
  }

  const FrameProblem& problem_;
  const Support& support_;
  Vector estimate_;
  LatticeField field_;  // 0 where no unknown is
  LatticeField precision_, blurred_, spare_;
  std::vector<double> sightError_;  // one a view
  Vector slopes_;                   // of each row eight: to the right, down; empty: no need
  Vector inverse_, projected_;
};

/// A problem that makeFrameProblem() has of pictures as reconstruct() takes them.
Result<FrameProblem> problemOf(std::span<const TomographyView> views,
                               const VolumeGeometry& geometry, TomographyOptions options,
                               Progress& progress) {
  options.solver = TomographySolver::kApg;  // others do not know how sure pixels are
  VOLUTE_ASSIGN(auto problem, makeFrameProblem(views, geometry, options, progress));
  // A picture without noise or edges is not exact for that.
  constexpr double kExact = 1e-5;
  double light = 0;
  for (const float value : problem.data.measured)
    light = std::max(light, std::abs(static_cast<double>(value)));
  problem.variance = std::max(problem.variance, kExact * kExact * light * light);
  if (!(problem.variance > 0))
    problem.variance = 1;
  return problem;
}

/// A picture's parts by size.
std::array<Image, 3> bandsOf(Image image, double voxel) {
  const Image fine = boxBlurred(image, std::max(1.0, kFine * voxel));
  Image coarse = boxBlurred(image, std::max(1.0, kCoarse * voxel));
  std::array<Image, 3> bands{std::move(image), fine, std::move(coarse)};
  for (std::size_t i = 0; i < fine.pixels.size(); ++i) {
    bands[0].pixels[i] -= fine.pixels[i];
    bands[1].pixels[i] -= bands[2].pixels[i];
  }
  return bands;
}

/// The shares of white noise in the bands.
Bands noiseShares(double voxel) {
  const double fine = 1 / std::pow(std::max(1.0, kFine * voxel), 2);
  const double coarse = 1 / std::pow(std::max(1.0, kCoarse * voxel), 2);
  return {1 - fine, fine - coarse, coarse};
}

/// The mean correlation of two channels of `off` where light is seen, without its noise.
double correlationOf(const Image& off, const Image& seen, double noise) {
  std::array<double, 3> own{}, both{};  // both: channel c and the next
  for (std::size_t i = 0; i < off.pixels.size(); i += 3) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (!(seen.pixels[i] > 0))
        continue;
      const double a = off.pixels[i + c], b = off.pixels[i + (c + 1) % 3];
      own[c] += a * a - noise;
      both[c] += a * b;
    }
  }
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double sizes = std::max(own[c], 0.0) * std::max(own[(c + 1) % 3], 0.0);
    sum += sizes > 0 ? std::clamp(both[c] / std::sqrt(sizes), 0.0, 1.0) / 3 : 0;
  }
  return sum;
}

struct Excess {
  Bands bands{};
  double correlation = 0;  // of what differs in two channels, the mean
  double spread = 1;  // of samples in the picture, squared: coarse and fine, as multiples of noise
};

/// How much a view differs, squared, in each band, from what volumes without it predict, relative
/// to what samples of those volumes do; nothing where it cannot be said.
Result<std::optional<Excess>> excessOf(std::size_t view, std::span<const TomographyView> views,
                                       const VolumeGeometry& geometry,
                                       const TomographyOptions& options,
                                       const Reconstruction& solved, Progress& progress) {
  constexpr int kIterations = 150;
  constexpr double kNoiseKnown = 0.1;  // of its variance
  std::vector<TomographyView> rest(views.begin(), views.end());
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(view));
  TomographyOptions how = options;
  how.choice = solved.choice;
  how.temporal = 0;
  if (!how.iterations && how.solver == TomographySolver::kApg)
    how.iterations = kIterations;
  const auto without = reconstruct(rest, geometry, how, {}, progress);
  if (!without && without.error().code == ErrorCode::kCancelled)
    return tl::unexpected<Error>(without.error());
  if (!without)
    return std::nullopt;
  const TomographyView& held = views[view];
  const double voxel = voxelInPixels(held.camera, geometry);
  const auto seenOf = [&](std::span<const float> volume) {
    return asSeenBy(
        held, projectVolume(volume, geometry, options.basis, held.camera, options.raysPerPixel));
  };
  const Image seen = seenOf(without->volume);
  Image off = held.radiance;
  for (std::size_t i = 0; i < off.pixels.size(); ++i)
    off.pixels[i] = held.counts(i / 3) ? off.pixels[i] - seen.pixels[i] : 0;
  const double noise = std::pow(options.noiseSigma.value_or(noiseOf(held)), 2);
  const Bands share = noiseShares(voxel);
  const auto squaresOf = [&](Image image) {
    Bands sum{};
    const auto bands = bandsOf(std::move(image), voxel);
    for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
      if (!(seen.pixels[i] > 0) || !held.counts(i / 3))
        continue;
      for (std::size_t b = 0; b < 3; ++b) sum[b] += std::pow(bands[b].pixels[i], 2);
    }
    return sum;
  };
  double pixels = 0;
  for (std::size_t i = 0; i < seen.pixels.size(); ++i)
    pixels += seen.pixels[i] > 0 && held.counts(i / 3) ? 1 : 0;
  const Bands found = squaresOf(off);
  Bands expected{};
  VOLUTE_ASSIGN(const FrameProblem problem, problemOf(rest, geometry, options, progress));
  Posterior posterior(problem, rest, options, toUnknowns(*problem.support, without->volume));
  std::mt19937 random(options.seed);
  constexpr int kHere = 2;
  for (int k = 0; k < kHere; ++k) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "Stopped");
    Vector sample = posterior.sample(random);
    posterior.scale({1, 1, 1}, options.nonNegative, sample);
    const Bands squares = squaresOf(seenOf(toVolume(*problem.support, sample)));
    for (std::size_t b = 0; b < 3; ++b) expected[b] += squares[b] / kHere;
  }
  Excess excess{{}, correlationOf(off, seen, noise)};
  if (expected[0] > 0 && expected[2] > 0)
    excess.spread = expected[2] / share[2] / (expected[0] / share[0]);
  for (std::size_t b = 0; b < 3; ++b) {
    const double ofNoise = share[b] * noise * pixels, known = kNoiseKnown * ofNoise;
    if (!(expected[b] + known > 0))
      return std::nullopt;
    excess.bands[b] = (std::max(found[b] - ofNoise, 0.0) + known) / (expected[b] + known);
  }
  return excess;
}

}  // namespace

Result<VoxelUncertainty> estimateUncertainty(std::span<const TomographyView> given,
                                             const VolumeGeometry& geometry,
                                             const TomographyOptions& options,
                                             const Reconstruction& solved, Progress& progress) {
  // Pixels see sums along rays: what they show is surer of voxels than they differ themselves, and
  // more so where the difference is large. Fitted to eight sets with a known truth.
  constexpr double kPower = 0.85;
  // Of so few views that none can be held out: the median of those sets.
  constexpr double kUsual = 1.5;
  // Shares of the variance: of scaled samples, and of what noise alone does, which left-out
  // pictures do not show where they are as noisy. Fitted to 116 captures with a known truth, of
  // three kinds.
  constexpr double kOfSamples = 0.85, kOfNoise = 0.35;
  // Of smooth media, whose samples differ in the small as much as in the large, volumes come out
  // better than left-out pictures tell, of filaments worse. Fitted to 69 captures of nine kinds;
  // each kind by the others, the root mean square of the logarithm falls from .45 to .29.
  constexpr double kAlike = 0.361, kSpread = 0.211, kMin = 0.4, kMax = 1.5;
  constexpr std::size_t kFewest = 3;  // two predict a third badly, but how badly is what counts
  VOLUTE_TRY(checkReconstruction(given, geometry, options));
  std::vector<TomographyView> reduced;
  TomographyOptions how = options;
  how.coarseToFine = false;
  if (const int together = pixelsTogether(given, geometry, options); together > 1) {
    for (const TomographyView& view : given) reduced.push_back(reducedView(view, together));
    if (how.noiseSigma)
      *how.noiseSigma /= together;
  }
  const std::span<const TomographyView> views = reduced.empty() ? given : reduced;
  StopOnly quiet(progress);
  progress.report("error bars", 0, 0);
  VoxelUncertainty result;
  Bands squares{};
  double spread = 0;
  for (const std::size_t view : viewsToHoldOut(views, geometry.bounds.centre(), kFewest)) {
    VOLUTE_ASSIGN(const auto excess, excessOf(view, views, geometry, how, solved, quiet));
    if (!excess)
      continue;
    result.heldOut.push_back(views[view].name);
    for (std::size_t b = 0; b < 3; ++b) squares[b] += excess->bands[b];
    result.channelCorrelation += excess->correlation;
    spread += std::log(excess->spread);
  }
  const auto folds = static_cast<double>(result.heldOut.size());
  if (folds > 0)
    result.channelCorrelation /= folds;
  for (std::size_t b = 0; b < 3; ++b)
    result.scale[b] = folds > 0 ? std::pow(squares[b] / folds, kPower / 2) : kUsual;
  VOLUTE_ASSIGN(const FrameProblem problem, problemOf(views, geometry, how, quiet));
  const Vector estimate = toUnknowns(*problem.support, solved.volume);
  Posterior posterior(problem, views, how, estimate);
  std::mt19937 random(options.seed);
  Vector mean(estimate.size());
  const auto add = [&](const Vector& sample, double share) {
    const auto each = static_cast<float>(share / kSamples);
    forElements(mean.size(), [&](std::size_t i) { mean[i] += each * sample[i] * sample[i]; });
  };
  for (int k = 0; k < kSamples; ++k) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "Stopped");
    Vector sample = posterior.sample(random);
    posterior.scale(result.scale, options.nonNegative, sample);
    add(sample, folds > 0 ? kOfSamples : 1);
    if (folds > 0)
      add(posterior.sample(random, Posterior::Open::kNothing), kOfNoise);
  }
  posterior.smooth(mean);
  if (folds > 0) {
    const double factor = std::clamp(kAlike * std::exp(kSpread * spread / folds), kMin, kMax);
    const auto squared = static_cast<float>(factor * factor);
    forElements(mean.size(), [&](std::size_t i) { mean[i] *= squared; });
  }
  const double open = sumElements(mean.size(), [&](std::size_t i) { return mean[i]; });
  const double energy = dot(estimate, estimate);
  forElements(mean.size(), [&](std::size_t i) { mean[i] = std::sqrt(mean[i]); });
  result.sigma = toVolume(*problem.support, mean);
  result.expectedError = energy > 0 ? std::sqrt(open / energy) : 0;
  result.priorShare = energy > 0 ? open / (open + energy) : 0;
  return result;
}

}  // namespace volute
