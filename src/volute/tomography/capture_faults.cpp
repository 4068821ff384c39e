// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/capture_faults.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <optional>

#include "volute/image/srgb.hpp"
#include "volute/tomography/camera_correction.hpp"
#include "volute/tomography/hull.hpp"
#include "volute/tomography/match.hpp"
#include "volute/tomography/project.hpp"
#include "volute/tomography/reconstruct.hpp"
#include "volute/tomography/reduced_view.hpp"

namespace volute {
namespace {

using FaultKind = CaptureFault::Kind;
using Views = std::vector<TomographyView>;

constexpr std::size_t kFewestToTell = 4;
constexpr double kMinUnexplained = 0.05;  // of a view; below, little is looked for
constexpr double kTimesResolved = 1.3;

bool sameSize(const TomographyView& a, const TomographyView& b) {
  return a.camera.width() == b.camera.width() && a.camera.height() == b.camera.height();
}

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
      if (sameSize(view, other))
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

/// The picture with columns, rows or both in the other order.
void turnPicture(TomographyView& view, bool columns, bool rows) {
  const TomographyView before = view;
  const int width = view.radiance.width, height = view.radiance.height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int u = columns ? width - 1 - x : x, v = rows ? height - 1 - y : y;
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

/// Where red, green and blue are found.
constexpr std::array<std::array<int, 3>, 6> kOrders{
    {{0, 1, 2}, {2, 1, 0}, {1, 0, 2}, {0, 2, 1}, {1, 2, 0}, {2, 0, 1}}};

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
Views without(const Views& views, std::span<const double> white, FaultKind kind,
              const std::vector<std::size_t>& cameras, double value) {
  Views mended = views;
  std::vector<std::size_t> all(views.size());
  std::iota(all.begin(), all.end(), 0);
  if (kind == FaultKind::kExchanged) {
    std::swap(mended[cameras[0]].camera, mended[cameras[1]].camera);
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
        orderChannels(mended[v], kOrders[static_cast<std::size_t>(value)]);
        break;
      case FaultKind::kExchanged:
      case FaultKind::kBox:
        break;
    }
  }
  return mended;
}

/// A mistake that may be it.
struct Hypothesis {
  FaultKind kind = FaultKind::kMirrored;
  std::vector<std::size_t> cameras;  // empty: all
  double value = 1;
  double left = 0;  // of the pictures without it, root mean square
};

/// Whether one picture of a sequence can have it by itself.
bool canBeAlone(FaultKind kind) {
  return kind == FaultKind::kMirrored || kind == FaultKind::kFlipped ||
         kind == FaultKind::kUpsideDown || kind == FaultKind::kExchanged ||
         kind == FaultKind::kGain || kind == FaultKind::kChannels;
}

bool isResponse(FaultKind kind) {
  return kind == FaultKind::kEncoded || kind == FaultKind::kDecoded || kind == FaultKind::kExponent;
}

/// How one coarse volume explains all views.
struct Explanation {
  double all = 0;    // misfit, root mean square
  double lit = 0;    // of what is clearly brighter than the noise
  bool bad = false;  // some view is not explained
};

/// The bounds grown by half of their size on each side, and voxels of the same size.
VolumeGeometry grownGeometry(const VolumeGeometry& geometry) {
  constexpr double kShare = 0.5;
  VolumeGeometry grown = geometry;
  const Vec3 more = kShare * geometry.bounds.size();
  grown.bounds.min -= more;
  grown.bounds.max += more;
  for (int& n : grown.resolution) n *= 2;
  return grown;
}

/// Views and a volume as fine as a comparison wants them.
class Level {
 public:
  /// @param longest  voxels on the longest side, about
  /// @param hull  whether silhouettes tell where nothing is: a mistake carves its own hull
  Level(const Views& views, const VolumeGeometry& geometry, int longest, int iterations, bool hull)
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

  /// Grey: a mistake shows in all colours.
  const Views& views() const { return views_; }

  const Views& coloured() const { return coloured_; }

  Views without(const Hypothesis& fault, std::span<const double> white) const {
    if (fault.kind == FaultKind::kShift)
      return shifted(fault.value);
    if (!isResponse(fault.kind))
      return volute::without(views_, white, fault.kind, fault.cameras, fault.value);
    return greyed(volute::without(coloured_, white, fault.kind, fault.cameras, fault.value));
  }

  const VolumeGeometry& geometry() const { return geometry_; }

  void mend(std::span<const double> white, const Hypothesis& fault) {
    coloured_ = volute::without(coloured_, white, fault.kind, fault.cameras, fault.value);
    setGrey();
  }

  /// Empty where the views have no hull in common.
  Result<std::vector<float>> fitted(const Views& views, const VolumeGeometry& geometry,
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

  /// @param volume  of `geometry`, which may be larger than the level's; empty: no volume explains
  /// it
  ViewMatch matched(const TomographyView& view, const std::vector<float>& volume,
                    const VolumeGeometry& geometry) const {
    if (volume.empty())
      return {.residual = 1, .gain = 1, .misfit = 1, .unresolved = 0};
    return matchOf(view, projectVolume(volume, geometry, options_.basis, view.camera, 1), geometry_,
                   {});
  }

  ViewMatch matched(const TomographyView& view, const std::vector<float>& volume) const {
    return matched(view, volume, geometry_);
  }

  Result<Explanation> explain(const Views& views, const VolumeGeometry& geometry,
                              const Progress& progress) const {
    VOLUTE_ASSIGN(const auto volume, fitted(views, geometry, progress));
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

  /// Besides, what is left where there is light: values that are cut off at black have a mean that
  /// no volume explains, and other curves press it down.
  Result<Explanation> explainLit(const Views& views, const Progress& progress) const {
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

  Result<Explanation> explain(const Views& views, const Progress& progress) const {
    return explain(views, geometry_, progress);
  }

  /// How far each of some cameras is from what the others predict, root mean square.
  Result<double> heldOut(const Views& views, const std::vector<std::size_t>& cameras, bool together,
                         const Progress& progress) const {
    return heldOut(views, cameras, together, geometry_, progress);
  }

  Result<double> heldOut(const Views& views, const std::vector<std::size_t>& cameras, bool together,
                         const VolumeGeometry& geometry, const Progress& progress) const {
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

 private:
  void setGrey() {
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

  /// @param pixels  of the pictures as they are
  Views shifted(double pixels) const {
    Views views = views_;
    for (std::size_t v = 0; v < views.size(); ++v)
      views[v].camera = shiftedBy(views[v].camera, pixels / reductions_[v]);
    return views;
  }

  VolumeGeometry geometry_;
  Views coloured_, views_;
  std::vector<int> reductions_;         // one a view: pixels that became one
  std::vector<std::vector<char>> lit_;  // one a view: pixels that are clearly brighter than noise
  TomographyOptions options_;
};

class FaultSearch {
 public:
  /// @param alone  only what one picture can have by itself
  FaultSearch(const Views& views, std::span<const double> white, const VolumeGeometry& geometry,
              bool alone, Progress& progress)
      : coarse_(views, geometry, kCoarse, kCoarseIterations,
                false),  // what is wrong carves all away
        fine_(views, geometry, kFine, kFineIterations, true),
        white_(white),
        alone_(alone),
        progress_(progress) {}

  /// The next mistake, if there is one that is clearly it.
  Result<std::optional<CaptureFault>> next(bool first) {
    VOLUTE_ASSIGN(const Explanation now, coarse_.explain(coarse_.views(), progress_));
    std::vector<Hypothesis> candidates;
    // Light that has no end hides everything else.
    if (now.bad && litAllAround())
      return std::optional<CaptureFault>();
    if (now.bad) {
      if (first && !alone_) {
        VOLUTE_ASSIGN(const auto cut, cutByTheBounds(now));
        if (cut)
          return std::optional(*cut);
      }
      VOLUTE_ASSIGN(candidates, likely(now));
    }
    // Neither need half a pixel, which refined poses hide.
    for (const double pixels : {-0.5, 0.5}) {
      if (first && !alone_)
        candidates.push_back({FaultKind::kShift, {}, pixels, 0});
    }
    // Flat pictures are easily explained, so that those of another response need not stand out.
    if (first && !alone_ && !white_.empty()) {
      const bool known = std::ranges::any_of(candidates, [&](const Hypothesis& one) {
        return one.kind == FaultKind::kEncoded && one.cameras.empty();
      });
      if (!known)
        candidates.push_back({FaultKind::kEncoded, {}, 1, 0});
      for (const double exponent : {0.8, 1.25})
        candidates.push_back({FaultKind::kExponent, {}, exponent, 0});
    }
    std::optional<CaptureFault> found;
    if (!candidates.empty()) {
      VOLUTE_ASSIGN(found, judged(std::move(candidates)));
    }
    if (!found && now.bad && first && !alone_) {
      VOLUTE_ASSIGN(found, cutWithin(now));
    }
    return found;
  }

  /// A camera whose red, green and blue fit in another order, in colour; the best.
  Result<std::optional<CaptureFault>> otherOrder() const {
    constexpr std::size_t kMax = 4;
    constexpr double kOwn = 0.6, kBetter = 0.75;
    const Views& views = coarse_.coloured();
    if (litAllAround() || std::ranges::all_of(views, isGreyPicture))
      return std::optional<CaptureFault>();
    VOLUTE_ASSIGN(const Explanation now, coarse_.explain(views, progress_));
    if (!now.bad)
      return std::optional<CaptureFault>();
    VOLUTE_ASSIGN(const auto volume, coarse_.fitted(views, coarse_.geometry(), progress_));
    std::vector<std::size_t> cameras;
    std::vector<double> misfits;
    for (std::size_t v = 0; v < views.size(); ++v) {
      misfits.push_back(coarse_.matched(views[v], volume).misfit);
      if (!isGreyPicture(views[v]))
        cameras.push_back(v);
    }
    std::ranges::stable_sort(cameras, std::greater(), [&](std::size_t v) { return misfits[v]; });
    cameras.resize(std::min(cameras.size(), kMax));
    std::optional<CaptureFault> best;
    for (const std::size_t v : cameras) {
      Views others = views;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(v));
      VOLUTE_ASSIGN(const auto predicted, coarse_.fitted(others, coarse_.geometry(), progress_));
      std::array<double, kOrders.size()> left{};
      for (std::size_t order = 0; order < kOrders.size(); ++order) {
        TomographyView view = views[v];
        orderChannels(view, kOrders[order]);
        left[order] = coarse_.matched(view, predicted).misfit;
      }
      const auto order = static_cast<std::size_t>(std::ranges::min_element(left) - left.begin());
      if (order == 0 || !(left[order] < kOwn * left[0]))
        continue;
      Views ordered = views;
      orderChannels(ordered[v], kOrders[order]);
      VOLUTE_ASSIGN(const Explanation after, coarse_.explain(ordered, progress_));
      if (after.all < (best ? best->after : kBetter * now.all)) {
        best = CaptureFault{
            FaultKind::kChannels, {v}, static_cast<double>(order), now.all, after.all, {}};
      }
    }
    return best;
  }

  /// Whether the pictures leave less on coarse voxels without the mistake.
  Result<bool> isBetterWithout(const CaptureFault& fault) const {
    const Hypothesis one{fault.kind, fault.cameras, fault.value, 0};
    if (fault.kind == FaultKind::kChannels) {
      Views ordered = coarse_.coloured();
      for (const std::size_t v : fault.cameras)
        orderChannels(ordered[v], kOrders[static_cast<std::size_t>(fault.value)]);
      VOLUTE_ASSIGN(const Explanation before, coarse_.explain(coarse_.coloured(), progress_));
      VOLUTE_ASSIGN(const Explanation after, coarse_.explain(ordered, progress_));
      return after.all < before.all;
    }
    VOLUTE_ASSIGN(const Explanation before, coarse_.explain(coarse_.views(), progress_));
    VOLUTE_ASSIGN(const Explanation after, coarse_.explain(mended(coarse_, one), progress_));
    return after.all < before.all;
  }

  /// The pictures as they would be without a mistake that was named.
  void mend(const CaptureFault& fault) {
    const Hypothesis one{fault.kind, fault.cameras, fault.value, 0};
    coarse_.mend(white_, one);
    fine_.mend(white_, one);
  }

 private:
  static constexpr int kCoarse = 16, kFine = 40;  // voxels on the longest side, about
  static constexpr int kCoarseIterations = 20, kFineIterations = 40;

  Views mended(const Level& level, const Hypothesis& one) const {
    return level.without(one, white_);
  }

  /// Much light outside of the bounds, and a volume in larger ones that explains the pictures.
  Result<std::optional<CaptureFault>> cutByTheBounds(const Explanation& now) const {
    constexpr double kMuch = 0.1, kMuchBetter = 0.5;
    double most = 0;
    for (const TomographyView& view : coarse_.views())
      most = std::max(most, lightOutside(view, coarse_.geometry().bounds));
    if (most < kMuch)
      return std::optional<CaptureFault>();
    VOLUTE_ASSIGN(const auto grown,
                  coarse_.explain(coarse_.views(), grownGeometry(coarse_.geometry()), progress_));
    if (!(grown.all < kMuchBetter * now.all))
      return std::optional<CaptureFault>();
    return std::optional(CaptureFault{FaultKind::kBox, {}, most, now.all, grown.all, {}});
  }

  /// What bounds cut need not lie outside of their silhouettes. Nothing else explains the pictures,
  /// and larger bounds do, by which cameras are predicted better, too: near each camera they have
  /// room for whatever it alone sees.
  Result<std::optional<CaptureFault>> cutWithin(const Explanation& now) const {
    constexpr double kMuchBetter = 0.35, kPredicted = 0.6;
    const VolumeGeometry larger = grownGeometry(coarse_.geometry());
    VOLUTE_ASSIGN(const auto grown, coarse_.explain(coarse_.views(), larger, progress_));
    if (!(grown.all < kMuchBetter * now.all))
      return std::optional<CaptureFault>();
    const auto judges = judgesOf({FaultKind::kBox, {}, 1, 0});
    VOLUTE_ASSIGN(const double before, coarse_.heldOut(coarse_.views(), judges, false, progress_));
    VOLUTE_ASSIGN(const double after,
                  coarse_.heldOut(coarse_.views(), judges, false, larger, progress_));
    if (!(after < kPredicted * before))
      return std::optional<CaptureFault>();
    double most = 0;
    for (const TomographyView& view : coarse_.views())
      most = std::max(most, lightOutside(view, coarse_.geometry().bounds));
    return std::optional(CaptureFault{FaultKind::kBox, {}, most, now.all, grown.all, {}});
  }

  static bool isGreyPicture(const TomographyView& view) {
    if (view.grey)
      return true;
    const auto& light = view.radiance.pixels;
    for (std::size_t i = 0; i + 2 < light.size(); i += 3) {
      if (light[i] != light[i + 1] || light[i] != light[i + 2])
        return false;
    }
    return true;
  }

  /// Whether most pictures are lit all along their border: by a background that is not subtracted.
  bool litAllAround() const {
    constexpr double kNearlyAll = 0.9;
    const auto& views = coarse_.views();
    const auto count = std::ranges::count_if(views, [&](const TomographyView& view) {
      const double threshold = 2 * silhouetteThreshold(view, {});
      const int width = view.radiance.width, height = view.radiance.height;
      int border = 0, lit = 0;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          if (x != 0 && y != 0 && x + 1 != width && y + 1 != height)
            continue;
          ++border;
          lit += view.radiance.at(x, y, 0) > threshold ? 1 : 0;
        }
      }
      return lit > kNearlyAll * border;
    });
    return 2 * static_cast<std::size_t>(count) > views.size();
  }

  /// The share of a view's light whose sights miss the bounds; 0 where what is lit is no more than
  /// noise.
  static double lightOutside(const TomographyView& view, const Box3& bounds) {
    const double threshold = 2 * silhouetteThreshold(view, {});
    constexpr double kOfNoise = 2e-3;  // of all pixels
    double all = 0, outside = 0;
    std::size_t lit = 0;
    for (std::size_t i = 0; i < view.radiance.pixels.size() / 3; ++i) {
      const double light = view.radiance.pixels[3 * i];
      if (!view.counts(i) || !(light > threshold))
        continue;
      const Segment ray = view.camera.ray(static_cast<double>(i % view.radiance.width) + 0.5,
                                          static_cast<double>(i / view.radiance.width) + 0.5);
      all += light, ++lit;
      if (bounds.intersect(ray.origin, ray.direction).intersect({ray.begin, ray.end}).empty())
        outside += light;
    }
    const auto pixels = static_cast<double>(view.radiance.pixels.size() / 3);
    return static_cast<double>(lit) > kOfNoise * pixels ? outside / all : 0;
  }

  /// Mistakes without which a coarse volume explains more, the best first.
  Result<std::vector<Hypothesis>> likely(const Explanation& now) const {
    constexpr std::size_t kMax = 4;
    constexpr double kWorthALook = 0.85, kMuchUnexplained = 0.12;
    std::vector<Hypothesis> found;
    const auto attempt = [&](FaultKind kind, std::vector<std::size_t> cameras,
                             double value = 1) -> Status {
      if (alone_ && (!canBeAlone(kind) || cameras.empty()))
        return {};
      Hypothesis one{kind, std::move(cameras), value, 0};
      VOLUTE_ASSIGN(const auto explained, coarse_.explain(mended(coarse_, one), progress_));
      one.left = explained.all;
      if (one.left < kWorthALook * now.all)
        found.push_back(std::move(one));
      return {};
    };
    constexpr std::array kTurned{FaultKind::kMirrored, FaultKind::kFlipped, FaultKind::kUpsideDown};
    constexpr std::array kResponses{FaultKind::kEncoded, FaultKind::kDecoded};
    constexpr std::array kZooms{0.8, 0.92, 1.09, 1.25};
    // Of the distance from the middle, at the border.
    constexpr std::array kBent{-0.4, -0.15, 0.25};
    VOLUTE_ASSIGN(const auto suspects, maxSuspicious());
    std::vector<std::vector<std::size_t>> who{{}};
    for (const std::size_t v : suspects) who.push_back({v});
    for (const auto& cameras : who) {
      for (const FaultKind kind : kTurned) VOLUTE_TRY(attempt(kind, cameras));
      for (const FaultKind kind : kResponses) {
        if (!white_.empty())
          VOLUTE_TRY(attempt(kind, cameras));
      }
      // Smaller or larger pictures in all cameras are nearly a larger or smaller medium, and take
      // in what the bounds cut: it takes much to say so.
      std::size_t others = found.size();
      for (const double zoom : kZooms) {
        if (!cameras.empty() || now.all > kMuchUnexplained)
          VOLUTE_TRY(attempt(FaultKind::kZoom, cameras, zoom));
      }
      keepTheBest(found, others);
      if (cameras.empty())
        continue;
      others = found.size();
      for (const double bent : kBent)
        VOLUTE_TRY(attempt(FaultKind::kLens, cameras, bent / borderSquare(cameras[0])));
      keepTheBest(found, others);
      VOLUTE_ASSIGN(const double gain, gainOf(cameras[0]));
      constexpr double kMin = 1.1;  // less is for the refinement alone
      if (gain > kMin || gain < 1 / kMin)
        VOLUTE_TRY(attempt(FaultKind::kGain, cameras, gain));
    }
    // Two that are exchanged spoil the others' fits as much as their own.
    constexpr std::size_t kFew = 8;
    std::vector<std::size_t> either = suspects;
    if (coarse_.views().size() <= kFew) {
      either.resize(coarse_.views().size());
      std::iota(either.begin(), either.end(), 0);
    }
    for (std::size_t a = 0; a < either.size(); ++a) {
      for (std::size_t b = a + 1; b < either.size(); ++b) {
        const auto [low, high] = std::minmax(either[a], either[b]);
        if (sameSize(coarse_.views()[low], coarse_.views()[high]))
          VOLUTE_TRY(attempt(FaultKind::kExchanged, {low, high}));
      }
    }
    std::ranges::stable_sort(found, {}, &Hypothesis::left);
    found.resize(std::min(found.size(), kMax));
    for (Hypothesis& one : found) {
      if (one.kind == FaultKind::kLens || (one.kind == FaultKind::kZoom && !one.cameras.empty()))
        VOLUTE_TRY(measure(coarse_, one, {0.5, 0.7, 0.85, 1.18, 1.4, 2, 2.8, 4}));
    }
    return found;
  }

  /// Of the hypotheses from `first` on, the one that leaves least.
  static void keepTheBest(std::vector<Hypothesis>& found, std::size_t first) {
    if (found.size() <= first)
      return;
    std::ranges::iter_swap(
        found.begin() + static_cast<std::ptrdiff_t>(first),
        std::ranges::min_element(found.begin() + static_cast<std::ptrdiff_t>(first), found.end(),
                                 {}, &Hypothesis::left));
    found.resize(first + 1);
  }

  /// Squared distance from the middle of a camera's left and right border, at a depth of 1.
  double borderSquare(std::size_t camera) const {
    const Camera& seen = coarse_.views()[camera].camera;
    return std::pow(0.5 * seen.width() * seen.pixelWidth(), 2);
  }

  /// The factor on a camera's light that fits what the others predict.
  Result<double> gainOf(std::size_t camera) const {
    Views others = coarse_.views();
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(camera));
    VOLUTE_ASSIGN(const auto volume, coarse_.fitted(others, coarse_.geometry(), progress_));
    return coarse_.matched(coarse_.views()[camera], volume).gain;
  }

  /// Those without which the others agree best, the worst first. A wrong view spoils the others'
  /// fits more than its own where it is brighter.
  Result<std::vector<std::size_t>> maxSuspicious() const {
    constexpr std::size_t kMax = 4;
    std::vector<double> left;
    std::vector<std::size_t> order(coarse_.views().size());
    std::iota(order.begin(), order.end(), 0);
    for (const std::size_t v : order) {
      Views others = coarse_.views();
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(v));
      VOLUTE_ASSIGN(const auto found, coarse_.explain(others, progress_));
      left.push_back(found.all);
    }
    std::ranges::stable_sort(order, {}, [&](std::size_t v) { return left[v]; });
    order.resize(std::min(order.size(), kMax));
    return order;
  }

  /// What a hypothesis must leave of what is left without it: of pictures that it was fitted to,
  /// and of those that others predict.
  struct Bar {
    double fitted, heldOut;
  };

  /// Flatter pictures are always easier to explain and to predict.
  static Bar barOf(const Hypothesis& one) {
    if (one.kind == FaultKind::kDecoded && one.cameras.empty())
      return {0.6, 0.7};
    if (one.kind == FaultKind::kEncoded && one.cameras.empty())
      return {0.78, 1};
    if (one.kind == FaultKind::kExponent)
      return {0.5, 1};
    if (one.kind == FaultKind::kShift)  // refinement mends what is less clear
      return {0.6, 0.85};
    return {0.75, one.cameras.empty() ? 0.75 : 0.6};
  }

  /// Those that are asked what the others predict of them: those that are said to be wrong, or some
  /// of all.
  std::vector<std::size_t> judgesOf(const Hypothesis& one) const {
    constexpr std::size_t kMax = 4, kFewestOthers = 3;
    const std::size_t views = fine_.views().size();
    if (!one.cameras.empty() && views - one.cameras.size() >= kFewestOthers)
      return one.cameras;
    std::vector<std::size_t> some;
    for (std::size_t i = 0; i < std::min(kMax, views); ++i)
      some.push_back(i * views / std::min(kMax, views));
    return some;
  }

  /// The best of the candidates on the finer volume, if it is better than without it in all that is
  /// asked, and clearly better than the second.
  Result<std::optional<CaptureFault>> judged(std::vector<Hypothesis> candidates) const {
    constexpr double kSecond = 0.95;
    constexpr double kMinLeft = 0.02;  // of the pictures, for another curve to be looked for
    VOLUTE_ASSIGN(const Explanation now, fine_.explainLit(fine_.views(), progress_));
    if (now.all < kMinLeft) {
      std::erase_if(candidates, [](const Hypothesis& one) {
        return one.kind == FaultKind::kExponent || one.kind == FaultKind::kShift;
      });
    }
    if (candidates.empty())
      return std::optional<CaptureFault>();
    // By what each leaves over what it must, so that flat pictures have no advantage.
    std::vector<double> over, squares;
    for (Hypothesis& one : candidates) {
      VOLUTE_ASSIGN(const auto found, fine_.explainLit(mended(fine_, one), progress_));
      one.left = found.all;
      over.push_back(found.all / barOf(one).fitted);
      // Noise that is cut off at black is no curve.
      const bool ofNoise = isResponse(one.kind) && one.cameras.empty() &&
                           !(found.lit < barOf(one).fitted * now.lit && now.lit > kMinLeft);
      if (ofNoise)
        over.back() = std::numeric_limits<double>::infinity();
      if (one.kind == FaultKind::kShift)
        squares.push_back(found.all * found.all);
    }
    const auto best = static_cast<std::size_t>(std::ranges::min_element(over) - over.begin());
    Hypothesis one = candidates[best];
    const double overBest = over[best];
    over.erase(over.begin() + static_cast<std::ptrdiff_t>(best));
    const bool alone =
        over.empty() || one.left / barOf(one).fitted < kSecond * std::ranges::min(over);
    // The candidates are few; the exponent itself may leave much less.
    constexpr double kNearly = 1.4;
    const bool isExponent = one.kind == FaultKind::kExponent;
    if (!std::isfinite(overBest))
      return std::optional<CaptureFault>();
    if (one.kind == FaultKind::kShift) {
      one.value = leastBetween(squares[0], now.all * now.all, squares[1]);
      constexpr double kNearest = 0.35, kFurthest = 0.75;
      if (!(std::abs(one.value) > kNearest && std::abs(one.value) < kFurthest))
        return std::optional<CaptureFault>();
    }
    if (alone && isExponent && one.left < kNearly * barOf(one).fitted * now.all)
      VOLUTE_TRY(measure(fine_, one, {0.8, 0.875, 0.94, 1.06, 1.125}));
    if (!alone || !(one.left < barOf(one).fitted * now.all))
      return std::optional<CaptureFault>();
    const auto judges = judgesOf(one);
    const bool together = judges == one.cameras;
    VOLUTE_ASSIGN(const double before, fine_.heldOut(fine_.views(), judges, together, progress_));
    VOLUTE_ASSIGN(const double after,
                  fine_.heldOut(mended(fine_, one), judges, together, progress_));
    // Few cameras predict little, also of what is right.
    const bool obvious = one.left < 0.5 * barOf(one).fitted * now.all;
    if (!(after < (obvious ? 1 : barOf(one).heldOut) * before))
      return std::optional<CaptureFault>();
    if (one.kind == FaultKind::kZoom)
      VOLUTE_TRY(measure(fine_, one, {0.84, 0.88, 0.92, 0.96, 1.04, 1.08, 1.12, 1.16}));
    if (one.kind == FaultKind::kLens)
      VOLUTE_TRY(measure(fine_, one, {0.7, 0.8, 0.9, 0.95, 1.05, 1.1, 1.2, 1.3}));
    return std::optional(CaptureFault{one.kind, one.cameras, one.value, now.all, one.left, {}});
  }

  /// Where a parabola through the squares of what is left half a pixel to either side, and between,
  /// is least; 0 where it is nowhere.
  static double leastBetween(double left, double middle, double right) {
    const double curvature = left + right - 2 * middle;
    return curvature > 0 ? 0.25 * (left - right) / curvature : 0;
  }

  /// Takes the value that leaves least, of those times these factors.
  Status measure(const Level& level, Hypothesis& one, std::initializer_list<double> factors) const {
    const double found = one.value;
    for (const double factor : factors) {
      const Hypothesis other{one.kind, one.cameras, factor * found, 0};
      VOLUTE_ASSIGN(const auto explained, level.explain(mended(level, other), progress_));
      if (explained.all < one.left) {
        one.left = explained.all;
        one.value = other.value;
      }
    }
    return {};
  }

  Level coarse_, fine_;
  std::span<const double> white_;
  bool alone_;
  Progress& progress_;
};

std::string orderText(double value) {
  constexpr std::array<const char*, 6> kTexts{"",
                                              "red and blue exchanged (BGR)",
                                              "red and green exchanged",
                                              "green and blue exchanged",
                                              "stored as blue, red, green",
                                              "stored as green, blue, red"};
  return kTexts[static_cast<std::size_t>(value)];
}

std::string namesOf(const CaptureFault& fault, const Views& views) {
  std::vector<std::string> names;
  for (const std::size_t v : fault.cameras) names.push_back(views[v].name);
  return names.empty() ? std::string("all cameras")
                       : fmt::format("camera {}", fmt::join(names, ", "));
}

std::string describe(const CaptureFault& fault, const Views& views, double pixelCentre) {
  std::vector<std::string> names;
  for (const std::size_t v : fault.cameras) names.push_back(views[v].name);
  const std::string who = namesOf(fault, views);
  const auto evidence = fmt::format("(what is left of the pictures: {:.0f} % instead of {:.0f} %)",
                                    100 * fault.after, 100 * fault.before);
  switch (fault.kind) {
    case FaultKind::kMirrored:
      return fmt::format(
          "{}: mirrored: left and right exchanged, the pictures fit {}; mirror them "
          "back",
          who, evidence);
    case FaultKind::kFlipped:
      return fmt::format(
          "{}: flipped: above and below exchanged, the pictures fit {}; set "
          "\"bottom_up\": true, or check the rows of R, for y is down",
          who, evidence);
    case FaultKind::kUpsideDown:
      return fmt::format(
          "{}: upside down: turned by half a turn, the pictures fit {}; turn them, "
          "or the calibration",
          who, evidence);
    case FaultKind::kExchanged:
      return fmt::format(
          "cameras {} and {}: exchanged: each fits as the other {}; exchange their "
          "pictures, or their calibrations",
          names[0], names[1], evidence);
    case FaultKind::kEncoded:
      return fmt::format(
          "{}: the pictures are stored as sRGB and taken as linear {}; set \"color\": "
          "\"srgb\"",
          who, evidence);
    case FaultKind::kDecoded:
      return fmt::format(
          "{}: the pictures are stored linearly and taken as sRGB {}; set \"color\": "
          "\"linear\"",
          who, evidence);
    case FaultKind::kExponent:
      return fmt::format(
          "{}: the light is stored by another curve: to the power of about {:.2f} it fits {}; set "
          "\"color\" to that of the camera, or \"exponent\"",
          who, fault.value, evidence);
    case FaultKind::kGain:
      return fmt::format(
          "{}: {:.0f} % too {}: its radiance times {:.3g} fits the others {}; set its \"gain\"",
          who, 100 * std::abs(1 / fault.value - 1), fault.value < 1 ? "bright" : "dark",
          fault.value, evidence);
    case FaultKind::kZoom:
      return fmt::format(
          "{}: another focal length, about {:.3g} times as long, fits {}; calibrate with the lens "
          "and the size of these pictures",
          who, fault.value, evidence);
    case FaultKind::kLens:
      return fmt::format(
          "{}: a lens that its calibration does not have: with k1 {:+.2g} more it fits {}; "
          "calibrate the lens",
          who, fault.value, evidence);
    case FaultKind::kShift: {
      const bool right = fault.value > 0;
      const double centre = right ? 0 : 0.5;
      return fmt::format(
          "{}: one volume fits the pictures where principal points are half a pixel further to the "
          "{}, least at {:+.2f} pixels {}: {}",
          who, right ? "right and down" : "left and up", fault.value, evidence,
          centre != pixelCentre
              ? fmt::format("is the centre of the first pixel at {}, not at {}?", centre,
                            pixelCentre)
              : "was the calibration made with other pictures, or are they cropped?");
    }
    case FaultKind::kChannels:
      return fmt::format("{}: {}, against the others: put in order its pictures fit {}", who,
                         orderText(fault.value), evidence);
    case FaultKind::kBox:
      if (fault.value < 0.1)
        return fmt::format(
            "the volume's bounds seem to cut what the cameras see: bounds half as large again on "
            "each side explain the pictures {}; enlarge them",
            evidence);
      return fmt::format(
          "the volume's bounds cut what the cameras see: up to {:.0f} % of a camera's light lies "
          "outside, and bounds half as large again on each side explain the pictures {}; enlarge "
          "them",
          100 * fault.value, evidence);
  }
  return {};
}

/// One after the other.
Result<std::vector<CaptureFault>> foundBy(FaultSearch& search, const Views& views,
                                          double pixelCentre) {
  std::vector<CaptureFault> faults;
  if (views.size() < kFewestToTell)
    return faults;
  // More mistakes than half the cameras make are not told from one another.
  while (2 * faults.size() < views.size()) {
    VOLUTE_ASSIGN(auto fault, search.next(faults.empty()));
    if (!fault)
      break;
    // What was mended shows up again where it was something else.
    const bool again = std::ranges::any_of(faults, [&](const CaptureFault& before) {
      return before.cameras == fault->cameras &&
             (before.kind == fault->kind || (isResponse(before.kind) && isResponse(fault->kind)));
    });
    if (again)
      break;
    fault->text = describe(*fault, views, pixelCentre);
    const bool last = fault->kind == FaultKind::kBox || fault->kind == FaultKind::kShift;
    if (!last)
      search.mend(*fault);
    faults.push_back(std::move(*fault));
    if (last)
      return faults;
  }
  while (2 * faults.size() < views.size()) {
    VOLUTE_ASSIGN(auto fault, search.otherOrder());
    if (!fault)
      break;
    fault->text = describe(*fault, views, pixelCentre);
    search.mend(*fault);
    faults.push_back(std::move(*fault));
  }
  return faults;
}

}  // namespace

Result<std::vector<CaptureFault>> findCaptureFaults(const std::vector<TomographyView>& views,
                                                    std::span<const double> white,
                                                    const VolumeGeometry& geometry,
                                                    Progress& progress, double pixelCentre) {
  FaultSearch search(views, white, geometry, false, progress);
  return foundBy(search, views, pixelCentre);
}

Result<std::vector<CaptureFault>> findPictureFaults(const std::vector<TomographyView>& views,
                                                    const VolumeGeometry& geometry,
                                                    Progress& progress) {
  FaultSearch search(views, {}, geometry, true, progress);
  return foundBy(search, views, 0.5);
}

Result<bool> hasCaptureFault(const CaptureFault& fault, const std::vector<TomographyView>& views,
                             std::span<const double> white, const VolumeGeometry& geometry,
                             Progress& progress) {
  return FaultSearch(views, white, geometry, false, progress).isBetterWithout(fault);
}

std::string describeInFrames(const CaptureFault& fault, const std::vector<TomographyView>& views,
                             std::span<const int> frames) {
  const auto what = [&]() -> std::string {
    switch (fault.kind) {
      case FaultKind::kMirrored:
        return "mirrored";
      case FaultKind::kFlipped:
        return "flipped";
      case FaultKind::kUpsideDown:
        return "upside down";
      case FaultKind::kExchanged:
        return "exchanged";
      case FaultKind::kGain:
        return fmt::format("{:.0f} % too {}: its radiance times {:.3g} fits the others",
                           100 * std::abs(1 / fault.value - 1), fault.value < 1 ? "bright" : "dark",
                           fault.value);
      case FaultKind::kChannels:
        return orderText(fault.value);
      default:
        return "does not fit the others";
    }
  };
  return fmt::format(
      "{}, frame{} {} alone: {} (what is left of the pictures: {:.0f} % instead of {:.0f} %); mend "
      "these pictures, or take them away: the camera then does not count there",
      namesOf(fault, views), frames.size() == 1 ? "" : "s", fmt::join(frames, ", "), what(),
      100 * fault.after, 100 * fault.before);
}

}  // namespace volute
