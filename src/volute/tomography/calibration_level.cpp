// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/calibration_level.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "volute/math/eigen.hpp"
#include "volute/tomography/hull.hpp"
#include "volute/tomography/momentum.hpp"
#include "volute/tomography/ray_slopes.hpp"
#include "volute/tomography/reduced_view.hpp"
#include "volute/tomography/sight_slopes.hpp"
#include "volute/tomography/vector_ops.hpp"

namespace volute {
namespace {

/// A step makes some sixty products, which a table pays for. Few voxels are refined.
constexpr std::uint64_t kMaxTableBytes = std::uint64_t{512} << 20;

/// pivot (light / pivot)^exponent, odd, and its derivative by the exponent's logarithm.
struct PoweredLight {
  double value = 0, slope = 0;

  PoweredLight(double light, double pivot, double exponent) {
    const double share = std::abs(light) / pivot;
    if (share < 1e-6)
      return;
    value = std::copysign(pivot * std::pow(share, exponent), light);
    slope = value * exponent * std::log(share);
  }
};

float greyOf(const Image& image, std::size_t pixel) {
  const float* p = &image.pixels[pixel * image.channels];
  float sum = 0;
  for (int c = 0; c < image.channels; ++c) sum += p[c];
  return sum / static_cast<float>(image.channels);
}

std::vector<std::uint8_t> grown(std::vector<std::uint8_t> mask, int width, int height, int by) {
  for (int k = 0; k < by; ++k) {
    const std::vector<std::uint8_t> old = mask;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (old[static_cast<std::size_t>(y) * width + x] == 0)
          continue;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
          for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u)
            mask[static_cast<std::size_t>(v) * width + u] = 1;
      }
    }
  }
  return mask;
}

}  // namespace

LevelFit::LevelFit(std::span<const std::vector<TomographyView>> frames,
                   const VolumeGeometry& geometry, const Level& level,
                   std::span<const CameraCorrection> plausible,
                   std::span<const FreeParameters> free, double pivot, std::uint64_t maxMemory)
    : given_(frames),
      frames_(frames.size()),
      maxMemory_(maxMemory),
      pivot_(pivot),
      geometry_(coarserGeometry(geometry, level.voxels)),
      plausible_(plausible.begin(), plausible.end()),
      free_(free.begin(), free.end()) {
  for (std::size_t v = 0; v < frames[0].size(); ++v) addView(frames, v, level);
}

Status LevelFit::setCorrections(std::span<const CameraCorrection> corrections) {
  corrections_.assign(corrections.begin(), corrections.end());
  VOLUTE_TRY(placeCameras());
  return makeProjector();
}

Status LevelFit::begin(std::span<const CameraCorrection> corrections, Progress& progress) {
  corrections_.assign(corrections.begin(), corrections.end());
  VOLUTE_TRY(placeCameras());
  std::vector<TomographyView> seen;
  std::vector<std::vector<std::uint8_t>> silhouettes;
  for (std::size_t v = 0; v < views_.size(); ++v) {
    seen.push_back({views_[v].view.name, cameras_[v], {}});
    silhouettes.push_back(views_[v].view.silhouette);
  }
  const auto hull = visualHull(seen, silhouettes, geometry_);
  if (std::ranges::count(hull, 1) == 0)
    return fail(ErrorCode::kNotFound, "The visual hull is empty");
  support_ = std::make_shared<const Support>(geometry_, Basis::kTrilinear, hull);
  if (const std::uint64_t needed = ownBytes(); needed > maxMemory_)
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "refining it on voxels of {} x {} x {} needs {} MiB, more than the {} MiB that are "
                "allowed",
                geometry_.resolution[0], geometry_.resolution[1], geometry_.resolution[2],
                (needed >> 20) + 1, maxMemory_ >> 20);
  volume_.assign(layers() * kTogether * support_->size(), 0);
  progress_ = &progress;
  return makeProjector();
}

void LevelFit::startFrom(const LevelFit& coarse) {
  const auto& n = geometry_.resolution;
  const auto& m = coarse.geometry_.resolution;
  std::vector<std::int32_t> coarseAt(coarse.geometry_.voxels(), -1);
  for (std::size_t i = 0; i < coarse.support_->size(); ++i)
    coarseAt[static_cast<std::size_t>(coarse.support_->voxels()[i])] = static_cast<std::int32_t>(i);
  for (std::size_t i = 0; i < support_->size(); ++i) {
    const int voxel = support_->voxels()[i];
    const std::array<int, 3> place{voxel % n[0], voxel / n[0] % n[1], voxel / n[0] / n[1]};
    std::size_t from = 0;
    for (int a = 2; a >= 0; --a)
      from = from * m[a] + static_cast<std::size_t>(std::min(m[a] - 1, place[a] * m[a] / n[a]));
    for (std::size_t f = 0; f < frames_; ++f)
      volume_[slot(support_->size(), i, f)] =
          coarseAt[from] < 0 ? 0
                             : coarse.volume_[slot(coarse.support_->size(),
                                                   static_cast<std::size_t>(coarseAt[from]), f)];
  }
}

void LevelFit::fitVolume(int iterations) {
  const Vector step = steps();
  Vector& x = volume_;
  Vector y = x, before(x.size()), gradient(x.size()), sy(measured_.size());
  Momentum momentum;
  for (int k = 1; k <= iterations; ++k) {
    for (std::size_t layer = 0; layer < layers(); ++layer) {
      const std::span<float> sums = layerOf(sy, layer);
      const auto weight = layerOf(weight_, layer), measured = layerOf(measured_, layer);
      projector_->thereAndBack(
          layerOf(y, layer),
          [&](std::size_t row, const float* sum, float* back) {
            for (std::size_t c = 0; c < kTogether; ++c)
              back[c] = weight[kTogether * row + c] * (sum[c] - measured[kTogether * row + c]);
          },
          sums, layerOf(gradient, layer));
    }
    std::swap(before, x);
    forElements(x.size(), [&](std::size_t i) {
      x[i] = std::max(y[i] - step[i / kTogether] * gradient[i], 0.0F);
    });
    const float beta = momentum.next(x, y, before, step);
    forElements(x.size(), [&](std::size_t i) { y[i] = x[i] + beta * (x[i] - before[i]); });
  }
  projected_.resize(measured_.size());
  forward(volume_, projected_);
}

void LevelFit::weigh() {
  constexpr double kTukey = 4.685;
  scale_.assign(views_.size(), 0);
  std::vector<std::vector<float>> off(views_.size());
  for (std::size_t row = 0; row < rows(); ++row) {
    const PixelRow& at = projector_->pixels()[row];
    for (std::size_t f = 0; f < frames_; ++f) {
      const std::size_t i = slot(rows(), row, f);
      if (own_[row] > 0 && (measured_[i] != 0 || projected_[i] != 0))
        off[static_cast<std::size_t>(at.view)].push_back(std::abs(measured_[i] - projected_[i]));
    }
  }
  for (std::size_t v = 0; v < views_.size(); ++v) {
    if (off[v].empty())
      continue;
    const auto middle = off[v].begin() + static_cast<std::ptrdiff_t>(off[v].size() / 2);
    std::ranges::nth_element(off[v], middle);
    double square = 0;
    for (const float one : off[v]) square += static_cast<double>(one) * one;
    // Of very many zeros the median is none.
    scale_[v] =
        std::max(1.4826 * *middle, 0.5 * std::sqrt(square / static_cast<double>(off[v].size())));
  }
  std::vector<double> sorted = scale_;
  std::ranges::sort(sorted);
  const double least = std::max(0.3 * sorted[sorted.size() / 2], 1e-12);
  for (std::size_t row = 0; row < rows(); ++row) {
    const auto view = static_cast<std::size_t>(projector_->pixels()[row].view);
    const double scale = std::max(scale_[view], least);
    for (std::size_t f = 0; f < frames_; ++f) {
      const std::size_t i = slot(rows(), row, f);
      const double off = (measured_[i] - projected_[i]) / (kTukey * scale);
      const double trust = off * off < 1 ? (1 - off * off) * (1 - off * off) : 0;
      weight_[i] = static_cast<float>(own_[row] * trust / (scale * scale));
    }
  }
}

Status LevelFit::step(int conjugateSteps) {
  findSlopes();
  std::vector<Parameters> delta = solveTogether(conjugateSteps);
  for (std::size_t v = 0; v < views_.size(); ++v) {
    // A step beyond what is plausible is not one the slopes can tell.
    const double most = (delta[v].array() / plausible_[v].values.array()).abs().maxCoeff();
    const CameraCorrection before = corrections_[v];
    corrections_[v].values += std::min(1.0, 1.5 / std::max(most, 1e-12)) * delta[v];
    // Nor does a lens fold the picture.
    if (!cameraOf(v, corrections_[v])) {
      corrections_[v].values[CameraCorrection::kLens] = before.values[CameraCorrection::kLens];
    }
  }
  std::vector<Camera> given;
  for (const LevelView& view : views_) given.push_back(view.view.camera);
  removeCommonPart(given, geometry_.bounds.centre(), plausible_, corrections_);
  VOLUTE_TRY(placeCameras());
  return makeProjector();
}

std::vector<double> LevelFit::residuals() const {
  std::vector<double> error(views_.size()), light(views_.size());
  for (std::size_t row = 0; row < rows(); ++row) {
    const auto v = static_cast<std::size_t>(projector_->pixels()[row].view);
    for (std::size_t f = 0; f < frames_; ++f) {
      const std::size_t i = slot(rows(), row, f);
      const double off = projected_[i] - measured_[i];
      error[v] += own_[row] * off * off;
      light[v] += own_[row] * measured_[i] * measured_[i];
    }
  }
  for (std::size_t v = 0; v < views_.size(); ++v)
    error[v] = light[v] > 0 ? std::sqrt(error[v] / light[v]) : 0;
  return error;
}

std::uint64_t LevelFit::ownBytes() const {
  constexpr std::uint64_t kRowVectors = 8, kUnknownVectors = 14, kRay = 2 * sizeof(WalkRay);
  const std::uint64_t values = layers() * kTogether * sizeof(float);
  const std::uint64_t row = kRowVectors * values + frames_ * sizeof(Parameters) + kRay;
  std::uint64_t pixels = 0, seen = 0;
  for (const LevelView& view : views_) {
    pixels += view.light.size() / frames_;
    seen += view.view.silhouette.size() -
            static_cast<std::uint64_t>(std::ranges::count(view.view.silhouette, 0));
  }
  return pixels * (frames_ * 8 + 4 + 1) + seen * row + support_->size() * kUnknownVectors * values +
         geometry_.voxels() * (1 + frames_ * 8 + 4) + support_->latticeSize() * 2 * 16;
}

void LevelFit::addView(std::span<const std::vector<TomographyView>> frames, std::size_t v,
                       const Level& level) {
  const TomographyView& first = frames[0][v];
  LevelView one{{first.name, first.camera, {}}, 1, {}, {}};
  // A voxel is nearly two pixels or more.
  constexpr double kPixels = 1.8;
  one.factor = std::clamp(static_cast<int>(voxelInPixels(first.camera, geometry_) / kPixels), 1,
                          std::max(1, std::min(first.camera.width(), first.camera.height()) / 8));
  const auto grow = static_cast<int>(std::ceil(level.uncertainPixels / one.factor));
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const TomographyView reduced = reducedView(frames[f][v], one.factor);
    const std::size_t pixels = reduced.radiance.pixels.size() / reduced.radiance.channels;
    auto silhouette = grown(dilatedSilhouette(reduced, {}), reduced.camera.width(),
                            reduced.camera.height(), grow);
    if (f == 0) {
      one.light.assign(frames_ * pixels, 0);
      one.view = {.name = first.name,
                  .camera = reduced.camera,
                  .radiance = {},
                  .weight = std::vector<float>(pixels, 1),
                  .silhouette = silhouette};
    }
    for (std::size_t i = 0; i < pixels; ++i) {
      one.view.silhouette[i] |= silhouette[i];
      if (!reduced.weight.empty())
        one.view.weight[i] = std::min(one.view.weight[i], reduced.weight[i]);
      one.light[frames_ * i + f] = greyOf(reduced.radiance, i);
    }
  }
  views_.push_back(std::move(one));
}

Result<Camera> LevelFit::cameraOf(std::size_t v, const CameraCorrection& correction) const {
  return corrected(views_[v].view.camera, correction, views_[v].factor);
}

void LevelFit::applyExponent(std::size_t v, double exponent) {
  LevelView& view = views_[v];
  view.exponent = exponent;
  view.slope.assign(view.light.size(), 0);
  const int width = view.view.camera.width();
  for (std::size_t f = 0; f < frames_; ++f) {
    const TomographyView& given = given_[f][v];
    const int channels = given.radiance.channels;
    parallelFor(static_cast<std::size_t>(view.view.camera.height()), [&](std::size_t row) {
      for (int column = 0; column < width; ++column) {
        const std::size_t at = row * static_cast<std::size_t>(width) + column;
        if (view.view.silhouette[at] == 0)
          continue;
        double light = 0, slope = 0, weight = 0;
        for (int y = 0; y < view.factor; ++y) {
          for (int x = 0; x < view.factor; ++x) {
            const std::size_t pixel =
                (row * view.factor + y) * static_cast<std::size_t>(given.radiance.width) +
                static_cast<std::size_t>(column) * view.factor + x;
            if (!given.counts(pixel) || given.isSaturated(pixel))
              continue;
            const double own = given.weight.empty() ? 1 : given.weight[pixel];
            weight += own * channels;
            for (int c = 0; c < channels; ++c) {
              const std::size_t value = pixel * channels + c;
              const double behind =
                  given.background.pixels.empty() ? 0 : given.background.pixels[value];
              const PoweredLight all(given.radiance.pixels[value] + behind, pivot_, exponent);
              const PoweredLight less(behind, pivot_, exponent);
              light += own * (all.value - less.value);
              slope += own * (all.slope - less.slope);
            }
          }
        }
        if (!(weight > 0))
          continue;
        view.light[frames_ * at + f] = static_cast<float>(light / weight);
        view.slope[frames_ * at + f] = static_cast<float>(slope / weight);
      }
    });
  }
}

Status LevelFit::placeCameras() {
  cameras_.clear();
  for (std::size_t v = 0; v < views_.size(); ++v) {
    const double exponent = corrections_[v].exponent();
    const bool refined = free_[v][CameraCorrection::kExponent];
    if (exponent != views_[v].exponent || (refined && views_[v].slope.empty()))
      applyExponent(v, exponent);
    VOLUTE_ASSIGN(auto camera, cameraOf(v, corrections_[v]));
    cameras_.push_back(camera);
  }
  return {};
}

Status LevelFit::makeProjector() {
  std::vector<ProjectorView> seen;
  for (std::size_t v = 0; v < views_.size(); ++v)
    seen.push_back({&cameras_[v], views_[v].view.silhouette});
  projector_.reset();  // two tables at a time would be one too many
  const std::uint64_t table = std::min({kMaxTableBytes, maxMemory_ / 4, maxMemory_ - ownBytes()});
  projector_ = std::make_unique<const Projector>(seen, support_, 1, table);
  if (projector_->rows() == 0)
    return fail(ErrorCode::kNotFound, "No ray meets the volume");
  measured_.assign(layers() * kTogether * rows(), 0);
  own_.assign(rows(), 0);
  for (std::size_t row = 0; row < rows(); ++row) {
    const PixelRow& at = projector_->pixels()[row];
    const LevelView& view = views_[static_cast<std::size_t>(at.view)];
    const auto gain = static_cast<float>(corrections_[static_cast<std::size_t>(at.view)].gain());
    for (std::size_t f = 0; f < frames_; ++f)
      measured_[slot(rows(), row, f)] =
          gain * view.light[frames_ * static_cast<std::size_t>(at.pixel) + f];
    own_[row] = view.view.weight[static_cast<std::size_t>(at.pixel)] / (gain * gain);
  }
  weight_.assign(measured_.size(), 0);
  for (std::size_t f = 0; f < frames_; ++f)
    for (std::size_t row = 0; row < rows(); ++row) weight_[slot(rows(), row, f)] = own_[row];
  if (progress_->cancelled())
    return fail(ErrorCode::kCancelled, "Stopped");
  return {};
}

void LevelFit::forward(const Vector& volume, Vector& rowsOut) const {
  for (std::size_t layer = 0; layer < layers(); ++layer)
    projector_->forward(layerOf(volume, layer), layerOf(rowsOut, layer));
}

void LevelFit::adjoint(const Vector& values, Vector& volume) const {
  for (std::size_t layer = 0; layer < layers(); ++layer)
    projector_->adjoint(layerOf(values, layer), layerOf(volume, layer));
}

LevelFit::Vector LevelFit::steps() const {
  Vector ones(volume_.size(), 1), sums(measured_.size()), out(volume_.size() / kTogether);
  forward(ones, sums);
  forElements(sums.size(), [&](std::size_t i) { sums[i] *= weight_[i]; });
  adjoint(sums, ones);
  float largest = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = *std::max_element(&ones[kTogether * i], &ones[kTogether * i] + kTogether);
    largest = std::max(largest, out[i]);
  }
  for (float& value : out) value = 1 / std::max(value, 1e-3F * largest);
  return out;
}

void LevelFit::findSlopes() {
  std::vector<SlopedField> fields;
  for (std::size_t f = 0; f < frames_; ++f) {
    Vector whole(geometry_.voxels());
    for (std::size_t i = 0; i < support_->size(); ++i)
      whole[static_cast<std::size_t>(support_->voxels()[i])] =
          volume_[slot(support_->size(), i, f)];
    fields.emplace_back(geometry_, whole);
  }
  slopes_.assign(frames_ * rows(), Parameters::Zero());
  parallelRanges(rows(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const PixelRow& at = projector_->pixels()[row];
      const auto v = static_cast<std::size_t>(at.view);
      const double x = at.pixel % cameras_[v].width() + 0.5,
                   y = at.pixel / cameras_[v].width() + 0.5;
      const Segment ray = cameras_[v].ray(x, y);
      if (!(ray.begin < ray.end))
        continue;
      const RaySlopes change(cameras_[v], ray, corrections_[v].turn(), views_[v].factor);
      for (std::size_t f = 0; f < frames_; ++f) {
        const SightSlope slope = fields[f].along(ray);
        Parameters& out = slopes_[row * frames_ + f];
        out = change.direction.transpose() * asEigen(slope.alongDirection);
        out.segment<3>(CameraCorrection::kShift) = asEigen(slope.alongOrigin);
        out[CameraCorrection::kGain] = -slope.integral;
        if (!views_[v].slope.empty())
          out[CameraCorrection::kExponent] =
              -corrections_[v].gain() *
              views_[v].slope[frames_ * static_cast<std::size_t>(at.pixel) + f];
        for (int p = 0; p < kCount; ++p)
          out[p] = free_[v][static_cast<std::size_t>(p)] ? out[p] : 0;
      }
    }
  });
}

double LevelFit::sightErrorOf(std::size_t v, const Square& covariance) const {
  constexpr double kLittle = 0.05;
  double squares = 0;
  int seen = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 side(corner & 1 ? 0.25 : -0.25, corner & 2 ? 0.25 : -0.25,
                    corner & 4 ? 0.25 : -0.25);
    const Vec3 point = geometry_.bounds.centre() + side.cwiseProduct(geometry_.bounds.size());
    const auto place = cameras_[v].project(point);
    if (!place)
      continue;
    Eigen::Matrix<double, 2, kCount> slope = Eigen::Matrix<double, 2, kCount>::Zero();
    for (int p = 0; p < kCount; ++p) {
      if (!free_[v][static_cast<std::size_t>(p)])
        continue;
      CameraCorrection moved = corrections_[v];
      const double step = kLittle * plausible_[v].values[p];
      moved.values[p] += step;
      const auto camera = cameraOf(v, moved);
      const auto there = camera ? camera->project(point) : std::nullopt;
      if (there)
        slope.col(p) = asEigen((*there - *place) / step);
    }
    squares += (slope * covariance * slope.transpose()).trace();
    ++seen;
  }
  return views_[v].factor * std::sqrt(squares / std::max(1, seen));
}

void LevelFit::forwardBoth(const Vector& volume, std::span<const Parameters> delta,
                           Vector& rowsOut) const {
  forward(volume, rowsOut);
  forElements(rows(), [&](std::size_t row) {
    const auto v = static_cast<std::size_t>(projector_->pixels()[row].view);
    for (std::size_t f = 0; f < frames_; ++f)
      rowsOut[slot(rows(), row, f)] += static_cast<float>(slopes_[row * frames_ + f].dot(delta[v]));
  });
}

void LevelFit::adjointBoth(const Vector& values, Vector& volume,
                           std::vector<Parameters>& delta) const {
  adjoint(values, volume);
  delta.assign(views_.size(), Parameters::Zero());
  for (std::size_t row = 0; row < rows(); ++row) {
    const auto v = static_cast<std::size_t>(projector_->pixels()[row].view);
    for (std::size_t f = 0; f < frames_; ++f)
      delta[v] += values[slot(rows(), row, f)] * slopes_[row * frames_ + f];
  }
}

std::vector<LevelFit::Parameters> LevelFit::solveTogether(int iterations) {
  // Neighbouring residuals are no independent witnesses: so many of them tell as one.
  constexpr double kWitnesses = 30;
  const Vector step = steps();
  Vector residual(measured_.size());
  forElements(residual.size(),
              [&](std::size_t i) { residual[i] = weight_[i] * (measured_[i] - projected_[i]); });
  Vector rightVolume(volume_.size());
  std::vector<Parameters> right;
  adjointBoth(residual, rightVolume, right);
  std::vector<char> free(volume_.size());
  for (std::size_t i = 0; i < free.size(); ++i)
    free[i] = volume_[i] > 0 || rightVolume[i] > 0 ? 1 : 0;
  std::vector<Square> block(views_.size(), Square::Zero());
  for (std::size_t row = 0; row < rows(); ++row) {
    const auto v = static_cast<std::size_t>(projector_->pixels()[row].view);
    for (std::size_t f = 0; f < frames_; ++f)
      block[v] += weight_[slot(rows(), row, f)] * slopes_[row * frames_ + f] *
                  slopes_[row * frames_ + f].transpose();
  }
  std::vector<Parameters> hold(views_.size());
  std::vector<Eigen::LDLT<Square>> inverse(views_.size());
  for (std::size_t v = 0; v < views_.size(); ++v) {
    hold[v] = kWitnesses * plausible_[v].values.array().square().inverse();
    for (int p = 0; p < kCount; ++p) {
      if (free_[v][static_cast<std::size_t>(p)])
        right[v][p] -= hold[v][p] * corrections_[v].values[p];
    }
    block[v] += Square(hold[v].asDiagonal());
    inverse[v].compute(block[v]);
  }
  Vector da(volume_.size()), r = rightVolume, z(r.size()), p, ap(r.size()), sp(measured_.size());
  std::vector<Parameters> dc(views_.size(), Parameters::Zero()), rc = right, zc = rc, pc, apc;
  const auto precondition = [&] {
    forElements(r.size(), [&](std::size_t i) {
      if (!free[i])
        r[i] = 0;
      z[i] = step[i / kTogether] * r[i];
    });
    double product = dot(r, z);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      zc[v] = inverse[v].solve(rc[v]);
      product += rc[v].dot(zc[v]);
    }
    return product;
  };
  double gamma = precondition();
  p = z;
  pc = zc;
  for (int k = 0; k < iterations && gamma > 0; ++k) {
    forwardBoth(p, pc, sp);
    double energy = sumElements(
        sp.size(), [&](std::size_t i) { return static_cast<double>(weight_[i]) * sp[i] * sp[i]; });
    for (std::size_t v = 0; v < views_.size(); ++v)
      energy += pc[v].dot(hold[v].cwiseProduct(pc[v]));
    if (!(energy > 0))
      break;
    const double alpha = gamma / energy;
    forElements(sp.size(), [&](std::size_t i) { sp[i] *= weight_[i]; });
    adjointBoth(sp, ap, apc);
    forElements(r.size(), [&](std::size_t i) {
      da[i] += static_cast<float>(alpha) * p[i];
      r[i] -= static_cast<float>(alpha) * ap[i];
    });
    for (std::size_t v = 0; v < views_.size(); ++v) {
      dc[v] += alpha * pc[v];
      rc[v] -= alpha * (apc[v] + hold[v].cwiseProduct(pc[v]));
    }
    const double next = precondition();
    const double beta = next / gamma;
    gamma = next;
    forElements(p.size(), [&](std::size_t i) { p[i] = z[i] + static_cast<float>(beta) * p[i]; });
    for (std::size_t v = 0; v < views_.size(); ++v) pc[v] = zc[v] + beta * pc[v];
  }
  forElements(volume_.size(),
              [&](std::size_t i) { volume_[i] = std::max(volume_[i] + da[i], 0.0F); });
  uncertain_.resize(views_.size());
  sightError_.resize(views_.size());
  for (std::size_t v = 0; v < views_.size(); ++v) {
    const Square covariance = kWitnesses * inverse[v].solve(Square::Identity());
    sightError_[v] = sightErrorOf(v, covariance);
    uncertain_[v].values = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  }
  return dc;
}

}  // namespace volute
