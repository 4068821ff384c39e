// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/fault_level.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "volute/base/assert.hpp"
#include "volute/image/srgb.hpp"
#include "volute/tomography/camera_correction.hpp"
#include "volute/tomography/hull.hpp"
#include "volute/tomography/project.hpp"
#include "volute/tomography/reduced_view.hpp"

namespace volute {
namespace {

using FaultKind = CaptureFault::Kind;
using Views = std::vector<TomographyView>;

/// Reduced so that a voxel of `coarse` is two pixels wide; those of one size alike, for they may be
/// exchanged.
Views coarseViews(const Views& views, const VolumeGeometry& coarse) {
  const auto factorOf = [&](const TomographyView& view) {
    const int most = std::max(1, std::min(view.camera.width(), view.camera.height()) / 8);
    return std::clamp(static_cast<int>(voxelInPixels(view.camera, coarse) / 2), 1, most);
  };
  Views reduced;
  for (const TomographyView& view : views) {
    int factor = factorOf(view);
    for (const TomographyView& other : views) {
      if (areOfOneSize(view, other))
        factor = std::min(factor, factorOf(other));
    }
    reduced.push_back(reducedView(view, factor));
    reduced.back().atLeast.clear();
  }
  return reduced;
}

/// The mean of the channels in each.
Views greyed(Views views) {
  for (TomographyView& view : views) {
    for (std::size_t i = 0; i + 2 < view.radiance.pixels.size(); i += 3) {
      float* p = &view.radiance.pixels[i];
      std::fill_n(p, 3, (p[0] + p[1] + p[2]) / 3);
    }
  }
  return views;
}

/// The picture with columns, rows or both in the other order, after they were exchanged where it is
/// turned by a quarter; then it is a square.
void turnPicture(TomographyView& view, bool columns, bool rows, bool quarter = false) {
  const TomographyView before = view;
  const int width = view.radiance.width, height = view.radiance.height;
  VOLUTE_ASSERT(!quarter || width == height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      int u = columns ? width - 1 - x : x, v = rows ? height - 1 - y : y;
      if (quarter)
        std::swap(u, v);
      const std::size_t to = static_cast<std::size_t>(y) * width + x,
                        from = static_cast<std::size_t>(v) * width + u;
      std::copy_n(&before.radiance.pixels[3 * from], 3, &view.radiance.pixels[3 * to]);
      if (!view.weight.empty())
        view.weight[to] = before.weight[from];
      if (!view.silhouette.empty())
        view.silhouette[to] = before.silhouette[from];
    }
  }
}

/// Light through another response.
void respond(TomographyView& view, bool decode, double white) {
  const double brightest = *std::ranges::max_element(view.radiance.pixels);
  white = std::max({white, brightest, 1e-30});
  for (float& value : view.radiance.pixels) {
    const double share = value / white;
    value = static_cast<float>(white * (decode ? srgbDecode(share) : srgbEncode(share)));
  }
}

/// Light to a power, `white` as it is.
void raise(TomographyView& view, double exponent, double white) {
  for (float& value : view.radiance.pixels) {
    const double share = value / white;
    value = static_cast<float>(white * std::copysign(std::pow(std::abs(share), exponent), share));
  }
}

void orderChannels(TomographyView& view, const std::array<int, 3>& order) {
  for (std::size_t i = 0; i + 2 < view.radiance.pixels.size(); i += 3) {
    float* p = &view.radiance.pixels[i];
    const std::array<float, 3> was{p[0], p[1], p[2]};
    for (int c = 0; c < 3; ++c) p[c] = was[order[c]];
  }
}

/// The camera with its principal point further to the right and down [pixels].
Camera shiftedBy(const Camera& camera, double pixels) {
  CameraCorrection correction;
  correction.values[CameraCorrection::kPrincipal] = pixels;
  correction.values[CameraCorrection::kPrincipal + 1] = pixels;
  return corrected(camera, correction).value_or(camera);
}

/// The views without the mistake; a shift is in pixels of these.
Views without(const Views& views, std::span<const double> white, const FaultHypothesis& fault) {
  const auto& [kind, cameras, value, left, factors] = fault;
  Views mended = views;
  std::vector<std::size_t> all(views.size());
  std::iota(all.begin(), all.end(), 0);
  if (kind == FaultKind::kExchanged) {
    std::swap(mended[cameras[0]].camera, mended[cameras[1]].camera);
    return mended;
  }
  if (kind == FaultKind::kOrder) {
    const auto order = cameraOrder(static_cast<int>(value), views.size());
    for (const std::size_t v : all) mended[v].camera = views[order[v]].camera;
    return mended;
  }
  for (const std::size_t v : cameras.empty() ? all : cameras) {
    switch (kind) {
      case FaultKind::kMirrored:
        turnPicture(mended[v], true, false);
        break;
      case FaultKind::kFlipped:
        turnPicture(mended[v], false, true);
        break;
      case FaultKind::kUpsideDown:
        turnPicture(mended[v], true, true);
        break;
      case FaultKind::kTurnedLeft:  // right
        turnPicture(mended[v], true, false, true);
        break;
      case FaultKind::kTurnedRight:
        turnPicture(mended[v], false, true, true);
        break;
      case FaultKind::kGain:
        for (float& light : mended[v].radiance.pixels) light *= static_cast<float>(value);
        break;
      case FaultKind::kZoom:
        mended[v].camera = corrected(mended[v].camera, zoomBy(value)).value_or(mended[v].camera);
        break;
      case FaultKind::kLens:
        mended[v].camera = corrected(mended[v].camera, lensBy(value)).value_or(mended[v].camera);
        break;
      case FaultKind::kEncoded:
      case FaultKind::kDecoded:
        respond(mended[v], kind == FaultKind::kEncoded, white[v]);
        break;
      case FaultKind::kExponent:
        raise(mended[v], value, white[v]);
        break;
      case FaultKind::kShift:
        mended[v].camera = shiftedBy(mended[v].camera, value);
        break;
      case FaultKind::kChannels:
        orderChannels(mended[v], kChannelOrders[static_cast<std::size_t>(value)]);
        break;
      case FaultKind::kBalance:
        for (std::size_t i = 0; i < mended[v].radiance.pixels.size(); ++i)
          mended[v].radiance.pixels[i] *=
              static_cast<float>(factors[static_cast<Eigen::Index>(i % 3)]);
        break;
      case FaultKind::kExchanged:
      case FaultKind::kOrder:
      case FaultKind::kBox:
        break;
    }
  }
  return mended;
}

/// Whether grey pictures do not show it.
bool isOfColours(FaultKind kind) {
  return isResponse(kind) || kind == FaultKind::kChannels || kind == FaultKind::kBalance;
}

}  // namespace

bool areOfOneSize(const TomographyView& a, const TomographyView& b) {
  return a.camera.width() == b.camera.width() && a.camera.height() == b.camera.height();
}

std::vector<std::size_t> cameraOrder(int order, std::size_t n) {
  std::vector<std::size_t> whose(n);
  for (std::size_t v = 0; v < n; ++v)
    whose[v] = order == 0 ? (v + 1) % n : order == 1 ? (v + n - 1) % n : n - 1 - v;
  if (order == 3) {
    std::iota(whose.begin(), whose.end(), 0);
    std::ranges::sort(whose, {}, [](std::size_t v) { return std::to_string(v); });
  }
  return whose;
}

bool isResponse(FaultKind kind) {
  return kind == FaultKind::kEncoded || kind == FaultKind::kDecoded || kind == FaultKind::kExponent;
}

FaultLevel::FaultLevel(const Views& views, const VolumeGeometry& geometry, int longest,
                       int iterations, bool hull)
    : geometry_(coarserGeometry(
          geometry, std::max(1, (hull ? std::ranges::max(geometry.resolution) + longest - 1
                                      : std::ranges::max(geometry.resolution)) /
                                    longest))) {
  coloured_ = coarseViews(views, geometry_);
  for (std::size_t v = 0; v < views.size(); ++v)
    reductions_.push_back(views[v].camera.width() / coloured_[v].camera.width());
  setGrey();
  options_.regularization = Regularization::kNone;
  options_.iterations = iterations;
  options_.raysPerPixel = 1;
  options_.hull = hull;
}

Views FaultLevel::without(const FaultHypothesis& fault, std::span<const double> white) const {
  if (fault.kind == FaultKind::kShift)
    return shifted(fault.value);
  Views mended = volute::without(isOfColours(fault.kind) ? coloured_ : views_, white, fault);
  return isResponse(fault.kind) ? greyed(std::move(mended)) : mended;
}

const Views& FaultLevel::as(FaultKind kind) const {
  return isOfColours(kind) && !isResponse(kind) ? coloured_ : views_;
}

void FaultLevel::mend(const FaultHypothesis& fault, std::span<const double> white) {
  coloured_ = volute::without(coloured_, white, fault);
  setGrey();
}

Result<std::vector<float>> FaultLevel::fitted(const Views& views, const VolumeGeometry& geometry,
                                              const Progress& progress) const {
  if (progress.cancelled())
    return fail(ErrorCode::kCancelled, "Stopped");
  Progress quiet;
  auto fit = reconstruct(views, geometry, options_, {}, quiet);
  if (!fit && fit.error().code == ErrorCode::kNotFound)
    return std::vector<float>{};
  if (!fit)
    return tl::unexpected<Error>(fit.error());
  return std::move(fit->volume);
}

ViewMatch FaultLevel::matched(const TomographyView& view, const std::vector<float>& volume,
                              const VolumeGeometry& geometry) const {
  if (volume.empty())
    return {.residual = 1, .gain = 1, .misfit = 1, .unresolved = 0};
  return matchOf(view, projectVolume(volume, geometry, options_.basis, view.camera, 1), geometry_,
                 {});
}

ViewMatch FaultLevel::matched(const TomographyView& view, const std::vector<float>& volume) const {
  return matched(view, volume, geometry_);
}

std::optional<Rgb> FaultLevel::balanceOf(const TomographyView& view,
                                         const std::vector<float>& volume) const {
  if (volume.empty())
    return std::nullopt;
  const Image shown =
      asSeenBy(view, projectVolume(volume, geometry_, options_.basis, view.camera, 1));
  Rgb both = Rgb::Zero(), all = Rgb::Zero();
  for (std::size_t i = 0; i < shown.pixels.size(); ++i) {
    if (!view.counts(i / 3))
      continue;
    const auto c = static_cast<Eigen::Index>(i % 3);
    const double p = shown.pixels[i];
    both[c] += p * view.radiance.pixels[i];
    all[c] += p * p;
  }
  if (!(both.minCoeff() > 0))
    return std::nullopt;
  return Rgb(all / both);
}

Result<Explanation> FaultLevel::explain(const Views& views, const VolumeGeometry& geometry,
                                        const Progress& progress) const {
  VOLUTE_ASSIGN(const auto volume, fitted(views, geometry, progress));
  constexpr double kMinUnexplained = 0.05;  // of a view; below, little is looked for
  constexpr double kTimesResolved = 1.3;
  Explanation found;
  double squares = 0;
  for (const TomographyView& view : views) {
    const ViewMatch match = matched(view, volume, geometry);
    found.bad |= match.misfit > std::max(kMinUnexplained, kTimesResolved * match.unresolved);
    squares += match.misfit * match.misfit;
  }
  found.all = std::sqrt(squares / static_cast<double>(views.size()));
  return found;
}

Result<Explanation> FaultLevel::explainLit(const Views& views, const Progress& progress) const {
  VOLUTE_ASSIGN(const auto volume, fitted(views, geometry_, progress));
  Explanation found;
  double squares = 0, lit = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    squares += std::pow(matched(views[v], volume).misfit, 2);
    TomographyView bright = views[v];
    bright.weight.assign(lit_[v].size(), 0);
    for (std::size_t i = 0; i < lit_[v].size(); ++i) {
      if (lit_[v][i] != 0)
        bright.weight[i] = views[v].weight.empty() ? 1 : views[v].weight[i];
    }
    lit +=
        volume.empty()
            ? 1
            : std::pow(matchOf(bright,
                               projectVolume(volume, geometry_, options_.basis, bright.camera, 1),
                               geometry_, noiseOf(views[v]))
                           .misfit,
                       2);
  }
  found.all = std::sqrt(squares / static_cast<double>(views.size()));
  found.lit = std::sqrt(lit / static_cast<double>(views.size()));
  return found;
}

Result<Explanation> FaultLevel::explain(const Views& views, const Progress& progress) const {
  return explain(views, geometry_, progress);
}

Result<double> FaultLevel::heldOut(const Views& views, const std::vector<std::size_t>& cameras,
                                   bool together, const Progress& progress) const {
  return heldOut(views, cameras, together, geometry_, progress);
}

Result<double> FaultLevel::heldOut(const Views& views, const std::vector<std::size_t>& cameras,
                                   bool together, const VolumeGeometry& geometry,
                                   const Progress& progress) const {
  double squares = 0;
  std::vector<float> volume;
  for (const std::size_t v : cameras) {
    if (volume.empty() || !together) {
      Views others;
      for (std::size_t i = 0; i < views.size(); ++i) {
        const bool left = together ? std::ranges::find(cameras, i) != cameras.end() : i == v;
        if (!left)
          others.push_back(views[i]);
      }
      VOLUTE_ASSIGN(volume, fitted(others, geometry, progress));
    }
    squares += std::pow(matched(views[v], volume, geometry).misfit, 2);
  }
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, cameras.size())));
}

void FaultLevel::setGrey() {
  views_ = greyed(coloured_);
  lit_.clear();
  for (const TomographyView& view : views_) {
    const double threshold = 2 * silhouetteThreshold(view, {});
    std::vector<char> is(view.radiance.pixels.size() / 3);
    for (std::size_t i = 0; i < is.size(); ++i)
      is[i] = view.radiance.pixels[3 * i] > threshold ? 1 : 0;
    lit_.push_back(std::move(is));
  }
}

Views FaultLevel::shifted(double pixels) const {
  Views views = views_;
  for (std::size_t v = 0; v < views.size(); ++v)
    views[v].camera = shiftedBy(views[v].camera, pixels / reductions_[v]);
  return views;
}

}  // namespace volute
