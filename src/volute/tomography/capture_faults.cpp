// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/capture_faults.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <optional>

#include "volute/tomography/fault_level.hpp"
#include "volute/tomography/hull.hpp"

namespace volute {
namespace {

using FaultKind = CaptureFault::Kind;
using Hypothesis = FaultHypothesis;
using Views = std::vector<TomographyView>;

constexpr std::size_t kFewestToTell = 4;

/// Whether one picture of a sequence can have it by itself.
bool canBeAlone(FaultKind kind) {
  return kind == FaultKind::kMirrored || kind == FaultKind::kFlipped ||
         kind == FaultKind::kUpsideDown || kind == FaultKind::kTurnedLeft ||
         kind == FaultKind::kTurnedRight || kind == FaultKind::kExchanged ||
         kind == FaultKind::kGain || kind == FaultKind::kChannels || kind == FaultKind::kBalance;
}

constexpr int kCoarse = 16, kCoarseIterations = 20;  // voxels on the longest side, about

/// Voxels so large that what is wrong does not carve all away.
FaultLevel coarseLevel(const Views& views, const VolumeGeometry& geometry) {
  return {views, geometry, kCoarse, kCoarseIterations, false};
}

Hypothesis hypothesisOf(const CaptureFault& fault) {
  return {fault.kind, fault.cameras, fault.value, 0, fault.factors};
}

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

class FaultSearch {
 public:
  /// @param alone  only what one picture can have by itself
  FaultSearch(const Views& views, std::span<const double> white, const VolumeGeometry& geometry,
              bool alone, Progress& progress)
      : coarse_(coarseLevel(views, geometry)),
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

  /// A camera whose red, green and blue fit in another order, or each times a factor, in colour;
  /// the best.
  Result<std::optional<CaptureFault>> otherColours() const {
    constexpr std::size_t kMax = 4;
    constexpr double kBetter = 0.75;
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
      VOLUTE_ASSIGN(const auto colours, coloursOf(v));
      if (!colours)
        continue;
      VOLUTE_ASSIGN(const Explanation after,
                    coarse_.explain(coarse_.without(*colours, white_), progress_));
      if (after.all < (best ? best->after : kBetter * now.all))
        best = CaptureFault{colours->kind, {v}, colours->value, now.all,
                            after.all,     {},  false,          colours->factors};
    }
    return best;
  }

  /// The pictures as they would be without a mistake that was named.
  void mend(const CaptureFault& fault) {
    coarse_.mend(hypothesisOf(fault), white_);
    fine_.mend(hypothesisOf(fault), white_);
  }

 private:
  static constexpr int kFine = 40, kFineIterations = 40;

  /// What a camera's colours need to fit those that the others predict much better.
  Result<std::optional<Hypothesis>> coloursOf(std::size_t camera) const {
    constexpr double kOwn = 0.6, kApart = 1.1;
    const TomographyView& seen = coarse_.coloured()[camera];
    Views others = coarse_.coloured();
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(camera));
    VOLUTE_ASSIGN(const auto predicted, coarse_.fitted(others, coarse_.geometry(), progress_));
    const auto leftOf = [&](const Hypothesis& one) {
      return coarse_.matched(coarse_.without(one, white_)[camera], predicted).misfit;
    };
    const ViewMatch now = coarse_.matched(seen, predicted);
    std::optional<Hypothesis> best;
    const auto attempt = [&](Hypothesis one, double without) {
      one.left = leftOf(one);
      if (one.left < kOwn * without && (!best || one.left < best->left))
        best = std::move(one);
    };
    for (std::size_t order = 1; order < kChannelOrders.size(); ++order)
      attempt({FaultKind::kChannels, {camera}, static_cast<double>(order), 0}, now.misfit);
    const auto balance = coarse_.balanceOf(seen, predicted);
    if (balance && balance->maxCoeff() > kApart * balance->minCoeff()) {
      // One factor for all is a gain.
      const double gain =
          leftOf({FaultKind::kGain, {camera}, now.gain, 0, Rgb::Constant(now.gain)});
      attempt({FaultKind::kBalance, {camera}, 1, 0, *balance}, std::min(now.misfit, gain));
    }
    return best;
  }

  Views mended(const FaultLevel& level, const Hypothesis& one) const {
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
      for (const FaultKind kind : {FaultKind::kTurnedLeft, FaultKind::kTurnedRight}) {
        if (areSquare(cameras))
          VOLUTE_TRY(attempt(kind, cameras));
      }
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
    VOLUTE_ASSIGN(auto ordered, ofOtherOrder(now));
    if (ordered && !alone_)
      found.push_back(std::move(*ordered));
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
        if (areOfOneSize(coarse_.views()[low], coarse_.views()[high]))
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

  /// All cameras' pictures as those of others; only where nothing fits.
  Result<std::optional<Hypothesis>> ofOtherOrder(const Explanation& now) const {
    constexpr double kMuchUnexplained = 0.12, kBetter = 0.5;
    const Views& views = coarse_.views();
    std::optional<Hypothesis> best;
    const bool alike = std::ranges::all_of(
        views, [&](const TomographyView& view) { return areOfOneSize(view, views[0]); });
    for (int order = 0; alike && now.all > kMuchUnexplained && order < kCameraOrders; ++order) {
      Hypothesis one{FaultKind::kOrder, {}, static_cast<double>(order), 0};
      VOLUTE_ASSIGN(const auto explained, coarse_.explain(mended(coarse_, one), progress_));
      one.left = explained.all;
      if (one.left < (best ? best->left : kBetter * now.all))
        best = std::move(one);
    }
    return best;
  }

  /// @param cameras  empty: all
  bool areSquare(const std::vector<std::size_t>& cameras) const {
    const auto isSquare = [](const TomographyView& view) {
      return view.camera.width() == view.camera.height();
    };
    if (cameras.empty())
      return std::ranges::all_of(coarse_.views(), isSquare);
    return std::ranges::all_of(cameras,
                               [&](std::size_t v) { return isSquare(coarse_.views()[v]); });
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
      // Nor what explains little: two mistakes of single cameras leave less by it, too.
      constexpr double kMuchUnexplained = 0.12;
      const bool ofOthers =
          isResponse(one.kind) && one.cameras.empty() && found.all > kMuchUnexplained;
      if (ofNoise || ofOthers)
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
  Status measure(const FaultLevel& level, Hypothesis& one,
                 std::initializer_list<double> factors) const {
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

  FaultLevel coarse_, fine_;
  std::span<const double> white_;
  bool alone_;
  Progress& progress_;
};

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
    fault->text = describeFault(*fault, views, pixelCentre);
    const bool last = fault->kind == FaultKind::kBox || fault->kind == FaultKind::kShift;
    if (!last)
      search.mend(*fault);
    faults.push_back(std::move(*fault));
    if (last)
      return faults;
  }
  while (2 * faults.size() < views.size()) {
    VOLUTE_ASSIGN(auto fault, search.otherColours());
    if (!fault)
      break;
    search.mend(*fault);
    // What grey pictures showed of it was a gain.
    const auto part = std::ranges::find_if(faults, [&](const CaptureFault& before) {
      return fault->kind == FaultKind::kBalance && before.cameras == fault->cameras &&
             (before.kind == FaultKind::kGain || before.kind == FaultKind::kBalance);
    });
    if (part != faults.end()) {
      fault->factors *= part->kind == FaultKind::kGain ? Rgb::Constant(part->value) : part->factors;
      fault->before = std::max(fault->before, part->before);
      faults.erase(part);
    }
    fault->text = describeFault(*fault, views, pixelCentre);
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

Result<double> gainByOthers(const TomographyView& view, std::vector<TomographyView> others,
                            const VolumeGeometry& geometry, const Progress& progress) {
  others.push_back(view);
  const FaultLevel coarse = coarseLevel(others, geometry);
  Views known = coarse.views();
  known.pop_back();
  VOLUTE_ASSIGN(const auto volume, coarse.fitted(known, coarse.geometry(), progress));
  return coarse.matched(coarse.views().back(), volume).gain;
}

Result<bool> hasCaptureFault(const CaptureFault& fault, const std::vector<TomographyView>& views,
                             std::span<const double> white, const VolumeGeometry& geometry,
                             Progress& progress) {
  const FaultLevel coarse = coarseLevel(views, geometry);
  VOLUTE_ASSIGN(const Explanation before, coarse.explain(coarse.as(fault.kind), progress));
  VOLUTE_ASSIGN(const Explanation after,
                coarse.explain(coarse.without(hypothesisOf(fault), white), progress));
  return after.all < before.all;
}

}  // namespace volute
