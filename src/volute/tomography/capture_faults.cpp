// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/capture_faults.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "volute/image/srgb.hpp"
#include "volute/tomography/match.hpp"
#include "volute/tomography/project.hpp"
#include "volute/tomography/reconstruct.hpp"
#include "volute/tomography/reduced_view.hpp"

namespace volute {
namespace {

using FaultKind = CaptureFault::Kind;
using Views = std::vector<TomographyView>;

constexpr std::size_t kFewestToTell = 4;
constexpr int kCoarse = 16;               // voxels on the longest side, about
constexpr double kMinUnexplained = 0.12;  // of a view; below, nothing is looked for
constexpr double kTimesResolved = 1.3;

/// The mean of the channels, reduced so that a voxel of `coarse` is two pixels wide.
TomographyView coarseView(const TomographyView& view, const VolumeGeometry& coarse) {
  const int most = std::max(1, std::min(view.camera.width(), view.camera.height()) / 8);
  const auto factor = static_cast<int>(voxelInPixels(view.camera, coarse) / 2);
  TomographyView reduced = reducedView(view, std::clamp(factor, 1, most));
  reduced.atLeast.clear();
  for (std::size_t i = 0; i + 2 < reduced.radiance.pixels.size(); i += 3) {
    float* p = &reduced.radiance.pixels[i];
    std::fill_n(p, 3, (p[0] + p[1] + p[2]) / 3);
  }
  return reduced;
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

bool sameSize(const TomographyView& a, const TomographyView& b) {
  return a.camera.width() == b.camera.width() && a.camera.height() == b.camera.height();
}

/// The views without the mistake.
Views without(const Views& views, std::span<const double> white, FaultKind kind,
              const std::vector<std::size_t>& cameras) {
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
      default:
        respond(mended[v], kind == FaultKind::kEncoded, white[v]);
    }
  }
  return mended;
}

/// How one coarse volume explains all views.
struct Explanation {
  std::vector<double> misfit;  // of each view
  double all = 0;              // root mean square
  bool bad = false;            // some view is not explained
};

class FaultSearch {
 public:
  FaultSearch(const VolumeGeometry& coarse, std::span<const double> white, Progress& progress)
      : coarse_(coarse), white_(white), progress_(progress) {
    options_.regularization = Regularization::kNone;
    options_.iterations = 20;
    options_.raysPerPixel = 1;
    options_.hull = false;  // what is wrong would carve all of it away
  }

  Result<Explanation> explain(const Views& views) {
    if (progress_.cancelled())
      return fail(ErrorCode::kCancelled, "Stopped");
    VOLUTE_ASSIGN(const auto volume, fitted(views));
    Explanation found;
    double squares = 0;
    for (const TomographyView& view : views) {
      const ViewMatch match = matched(view, volume);
      found.misfit.push_back(match.misfit);
      found.bad |= match.misfit > std::max(kMinUnexplained, kTimesResolved * match.unresolved);
      squares += match.misfit * match.misfit;
    }
    found.all = std::sqrt(squares / static_cast<double>(views.size()));
    return found;
  }

  /// Light that is taken as linear and is not makes pictures flat and so easy to explain that they
  /// need not stand out, but as it was they are explained better still.
  Result<std::optional<CaptureFault>> findEncoded(const Views& views, const Explanation& now) {
    VOLUTE_ASSIGN(const auto mended, explain(without(views, white_, FaultKind::kEncoded, {})));
    CaptureFault fault{FaultKind::kEncoded, {}, now.all, mended.all, {}};
    return isClear(fault) ? std::optional(std::move(fault)) : std::nullopt;
  }

  /// The mistake without which the views agree best, if it is clearly it.
  Result<std::optional<CaptureFault>> find(const Views& views, const Explanation& now) {
    constexpr double kSecond = 0.95;
    CaptureFault best;
    best.after = now.all;
    double second = now.all;
    const auto attempt = [&](FaultKind kind, std::vector<std::size_t> cameras) -> Status {
      VOLUTE_ASSIGN(const auto mended, explain(without(views, white_, kind, cameras)));
      if (mended.all < best.after) {
        second = best.after;
        best = {kind, std::move(cameras), now.all, mended.all, {}};
      } else {
        second = std::min(second, mended.all);
      }
      return {};
    };
    constexpr std::array kResponses{FaultKind::kEncoded, FaultKind::kDecoded};
    for (const FaultKind kind : kResponses) {
      if (!white_.empty())
        VOLUTE_TRY(attempt(kind, {}));
    }
    VOLUTE_TRY(attempt(FaultKind::kMirrored, {}));
    VOLUTE_TRY(attempt(FaultKind::kUpsideDown, {}));
    VOLUTE_ASSIGN(const auto suspects, maxSuspicious(views));
    for (const std::size_t v : suspects) {
      for (const FaultKind kind :
           {FaultKind::kMirrored, FaultKind::kFlipped, FaultKind::kUpsideDown})
        VOLUTE_TRY(attempt(kind, {v}));
      for (const FaultKind kind : kResponses) {
        if (!white_.empty())
          VOLUTE_TRY(attempt(kind, {v}));
      }
    }
    for (std::size_t a = 0; a < suspects.size(); ++a) {
      for (std::size_t b = a + 1; b < suspects.size(); ++b) {
        const auto [low, high] = std::minmax(suspects[a], suspects[b]);
        if (sameSize(views[low], views[high]))
          VOLUTE_TRY(attempt(FaultKind::kExchanged, {low, high}));
      }
    }
    if (!isClear(best) || best.after > kSecond * second)
      return std::nullopt;
    VOLUTE_ASSIGN(const bool predicted, othersPredict(views, best));
    return predicted ? std::optional(std::move(best)) : std::nullopt;
  }

 private:
  Result<std::vector<float>> fitted(const Views& views) const {
    if (progress_.cancelled())
      return fail(ErrorCode::kCancelled, "Stopped");
    Progress quiet;
    VOLUTE_ASSIGN(Reconstruction fit, reconstruct(views, coarse_, options_, {}, quiet));
    return std::move(fit.volume);
  }

  ViewMatch matched(const TomographyView& view, const std::vector<float>& volume) const {
    return matchOf(view, projectVolume(volume, coarse_, options_.basis, view.camera, 1), coarse_,
                   {});
  }

  /// Whether the other cameras predict those that are said to be wrong much better without the
  /// mistake: what fits a little better by chance is none.
  Result<bool> othersPredict(const Views& views, const CaptureFault& fault) const {
    constexpr double kMuchBetter = 0.6;
    constexpr std::size_t kFewestOthers = 3;
    Views others;
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (std::ranges::find(fault.cameras, v) == fault.cameras.end())
        others.push_back(views[v]);
    }
    if (fault.cameras.empty() || others.size() < kFewestOthers)
      return true;
    VOLUTE_ASSIGN(const auto volume, fitted(others));
    const Views mended = without(views, white_, fault.kind, fault.cameras);
    double before = 0, after = 0;
    for (const std::size_t v : fault.cameras) {
      before += std::pow(matched(views[v], volume).misfit, 2);
      after += std::pow(matched(mended[v], volume).misfit, 2);
    }
    return std::sqrt(after) < kMuchBetter * std::sqrt(before);
  }

  /// Flatter pictures are always easier to explain.
  static bool isClear(const CaptureFault& fault) {
    constexpr double kClearly = 0.75, kClearlyFlatter = 0.55;
    const bool flatter = fault.kind == FaultKind::kDecoded && fault.cameras.empty();
    return fault.after < (flatter ? kClearlyFlatter : kClearly) * fault.before;
  }

  /// Those without which the others agree best, the worst first. A wrong view spoils the others'
  /// fits more than its own where it is brighter.
  Result<std::vector<std::size_t>> maxSuspicious(const Views& views) {
    constexpr std::size_t kMax = 4;
    std::vector<double> left;
    std::vector<std::size_t> order(views.size());
    std::iota(order.begin(), order.end(), 0);
    for (const std::size_t v : order) {
      Views others = views;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(v));
      VOLUTE_ASSIGN(const auto found, explain(others));
      left.push_back(found.all);
    }
    std::ranges::stable_sort(order, {}, [&](std::size_t v) { return left[v]; });
    order.resize(std::min(order.size(), kMax));
    return order;
  }

  VolumeGeometry coarse_;
  std::span<const double> white_;
  TomographyOptions options_;
  Progress& progress_;
};

std::string describe(const CaptureFault& fault, const Views& views) {
  std::vector<std::string> names;
  for (const std::size_t v : fault.cameras) names.push_back(views[v].name);
  const std::string who =
      names.empty() ? std::string("all cameras") : fmt::format("camera {}", fmt::join(names, ", "));
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
          "{}: flipped: above and below exchanged, the pictures fit {}; flip them "
          "back, or check the rows of R, for y is down",
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
  }
  return {};
}

}  // namespace

Result<std::vector<CaptureFault>> findCaptureFaults(std::vector<TomographyView> views,
                                                    std::span<const double> white,
                                                    const VolumeGeometry& geometry,
                                                    Progress& progress) {
  std::vector<CaptureFault> faults;
  if (views.size() < kFewestToTell)
    return faults;
  const int longest = std::ranges::max(geometry.resolution);
  const VolumeGeometry coarse = coarserGeometry(geometry, std::max(1, longest / kCoarse));
  for (TomographyView& view : views) view = coarseView(view, coarse);
  FaultSearch search(coarse, white, progress);
  VOLUTE_ASSIGN(Explanation now, search.explain(views));
  // More mistakes than half the cameras make are not told from one another.
  while (2 * faults.size() < views.size()) {
    std::optional<CaptureFault> fault;
    if (now.bad) {
      VOLUTE_ASSIGN(fault, search.find(views, now));
    } else if (faults.empty() && !white.empty()) {
      VOLUTE_ASSIGN(fault, search.findEncoded(views, now));
    }
    if (!fault)
      break;
    fault->text = describe(*fault, views);
    views = without(views, white, fault->kind, fault->cameras);
    faults.push_back(std::move(*fault));
    VOLUTE_ASSIGN(now, search.explain(views));
  }
  return faults;
}

}  // namespace volute
