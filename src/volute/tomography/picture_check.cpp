// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/picture_check.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "volute/tomography/hull.hpp"

namespace volute {
namespace {

/// One view's pixels, counted.
struct Counts {
  double threshold = 0;
  std::size_t counted = 0;              ///< pixels that are not masked
  std::size_t lit = 0;                  ///< brighter than the threshold, or saturated
  std::size_t negative = 0;             ///< darker than the background by twice the threshold
  std::size_t saturated = 0;            ///< and not masked
  std::array<std::size_t, 4> border{};  ///< lit ones on the left, right, upper and lower border
  double light = 0, lightOutside = 0;   ///< sums over lit pixels
};

constexpr std::array<const char*, 4> kBorders{"left", "right", "upper", "lower"};

bool hits(const TomographyView& view, const Box3& bounds, int x, int y) {
  const Segment ray = view.camera.ray(x + 0.5, y + 0.5);
  return !bounds.intersect(ray.origin, ray.direction).intersect({ray.begin, ray.end}).empty();
}

Counts countPixels(const TomographyView& view, const PictureFacts& facts, const Box3& bounds,
                   std::optional<double> noiseSigma) {
  Counts counts;
  counts.threshold = silhouetteThreshold(view, noiseSigma);
  const Image& image = view.radiance;
  const std::size_t pixels = static_cast<std::size_t>(image.width) * image.height;
  counts.counted = pixels - static_cast<std::size_t>(std::lround(facts.maskedShare * pixels));
  counts.saturated = static_cast<std::size_t>(
      std::lround(facts.saturatedShare * static_cast<double>(counts.counted)));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * image.width + x;
      if (!view.weight.empty() && view.weight[pixel] == 0)
        continue;
      const float* light = &image.pixels[3 * pixel];
      const float most = std::max({light[0], light[1], light[2]});
      const float least = std::min({light[0], light[1], light[2]});
      counts.negative += least < -2 * counts.threshold ? 1 : 0;
      if (!(most > 2 * counts.threshold))
        continue;
      ++counts.lit;
      const std::array<bool, 4> at{x == 0, x + 1 == image.width, y == 0, y + 1 == image.height};
      for (std::size_t side = 0; side < at.size(); ++side) counts.border[side] += at[side] ? 1 : 0;
      counts.light += most;
      if (!hits(view, bounds, x, y))
        counts.lightOutside += most;
    }
  }
  counts.lit += counts.saturated;
  return counts;
}

/// What several cameras have in common is said once.
class SharedSentences {
 public:
  void add(const std::string& text, const std::string& camera) {
    const auto found = std::ranges::find(sentences_, text, &Sentence::text);
    (found == sentences_.end() ? sentences_.emplace_back(Sentence{text, {}}) : *found)
        .cameras.push_back(camera);
  }

  void moveTo(std::vector<std::string>& warnings, int frame) const {
    for (const Sentence& one : sentences_) {
      warnings.push_back(fmt::format("camera{} {}, frame {}: {}", one.cameras.size() > 1 ? "s" : "",
                                     fmt::join(one.cameras, ", "), frame, one.text));
    }
  }

 private:
  struct Sentence {
    std::string text;
    std::vector<std::string> cameras;
  };

  std::vector<Sentence> sentences_;
};

/// How a camera stores values, as far as that is not what its file seems to say.
void checkStoring(const PictureFacts& facts, const std::string& camera, bool grey,
                  SharedSentences& warnings, SharedSentences& faults) {
  if (facts.mosaic)
    faults.add(
        "neighbouring pixels differ by their place in blocks of 2 x 2: the mosaic of a colour "
        "camera? Make it into colours first",
        camera);
  if (facts.plateau) {
    const double value = facts.plateau->value;
    const auto bits = bitsOf(value, facts.largest);
    const auto stateThat =
        bits ? fmt::format(
                   "are these {} bits? Then state \"bits\": {}; else state "
                   "\"saturation\": {:.5g}, or 1 if they are not",
                   *bits, *bits, value)
        : facts.plateau->saturated
            ? fmt::format("state \"saturation\": {:.5g}, or 1 if they are not", value)
            : fmt::format("state \"saturation\": 1, or {:.5g} if they are saturated", value);
    warnings.add(
        fmt::format("many pixels read {:.0f} of {:.0f}, the most in the picture, and are taken as "
                    "{}: {}",
                    value * facts.largest, facts.largest,
                    facts.plateau->saturated ? "saturated" : "an evenly lit background", stateThat),
        camera);
  }
  if (facts.channelLimits) {
    const auto& limits = *facts.channelLimits;
    warnings.add(
        fmt::format("red, green and blue read at most {:.0f}, {:.0f} and {:.0f} of {:.0f} in many "
                    "pixels, and are taken as saturated there (white balance after the sensor's "
                    "limit?): state \"saturation\": 1 if they are not",
                    limits[0] * facts.largest, limits[1] * facts.largest, limits[2] * facts.largest,
                    facts.largest),
        camera);
  }
  if (facts.dividedIntegers) {
    warnings.add(
        "floats that are whole parts of 255 or 65535, and \"color\" was stated: are they still "
        "encoded? Floats are taken as light: write them as integers, or decode them",
        camera);
  }
  if (facts.pedestal > 0) {
    warnings.add(
        fmt::format("all pixels beside the volume show about {:.2g} (stored, 1 = white): a black "
                    "level? It was subtracted; state it as \"black\", or a \"background\"",
                    facts.pedestal),
        camera);
  }
  if (facts.gainUntold) {
    warnings.add(
        "its gain is taken as 1 here: fewer than two cameras without \"gain_by_frame\" have a "
        "picture "
        "that would tell it",
        camera);
  }
  if (grey) {
    warnings.add(
        fmt::format("{}: it is taken as the mean of theirs; state its \"gain\" where it sees "
                    "colours otherwise",
                    facts.grey ? "one channel, while others have three"
                               : "three equal channels, while others see colours"),
        camera);
  }
}

/// Values of fewer bits than their files have look like short exposures: without a plateau nothing
/// tells them apart, but 4 of 16 bits and more are hardly left empty on purpose.
void checkBits(const FrameViews& views, PictureFindings& findings) {
  constexpr int kEmpty = 4;
  int bits = 0;
  double largest = 0;
  for (const PictureFacts& facts : views.facts) {
    if (facts.missing)
      continue;
    const int few = static_cast<int>(std::lround(std::log2(facts.largest))) - kEmpty;
    if (facts.bitsHolding == 0 || facts.bitsHolding > few || facts.plateau)
      return;
    bits = std::max(bits, facts.bitsHolding);
    largest = std::max(largest, facts.largest);
  }
  if (bits == 0)
    return;
  bits = std::max(bits + bits % 2, 10);  // as sensors have them
  const double most = std::ldexp(1.0, bits) - 1;
  findings.warnings.push_back(fmt::format(
      "frame {}: no picture reads more than {:.0f} of {:.0f}: are these {} bits? Then state "
      "\"bits\": {}, for light is taken as {:.0f} times too dark; else the exposures use little of "
      "their files",
      views.frame, most, largest, bits, bits, largest / most));
}

/// Floats that are whole numbers were counts.
void checkCounts(const FrameViews& views, PictureFindings& findings) {
  double most = 0;
  for (const PictureFacts& facts : views.facts) {
    if (facts.missing)
      continue;
    if (facts.counts == 0)
      return;  // one among others is a gain
    most = std::max(most, facts.counts);
  }
  if (most == 0)
    return;
  constexpr std::array kWhites{255, 1023, 4095, 16383, 65535};
  const int white = *std::ranges::lower_bound(kWhites, most, {}, [](int one) { return 1.0 * one; });
  findings.warnings.push_back(fmt::format(
      "frame {}: floats that are whole numbers up to {:.0f} are taken as light: are they counts? "
      "Then state \"white\": {:.3g} (1/{}), for light is taken as {} times too bright",
      views.frame, most, 1.0 / white, white, white));
}

double shareOf(std::size_t part, std::size_t whole) {
  return static_cast<double>(part) / static_cast<double>(std::max<std::size_t>(1, whole));
}

void checkSaturation(const Counts& counts, const PictureFacts& facts, const std::string& name,
                     const PictureLimits& limits, PictureFindings& findings) {
  constexpr double kWorthAWord = 0.1;
  const double share = shareOf(counts.saturated, counts.lit);
  if (counts.saturated == 0 || share <= std::min(kWorthAWord, limits.saturated))
    return;
  const auto text = fmt::format(
      "{}: {:.1f} % of the lit pixels are saturated: all that is known is how bright they are at "
      "least",
      name, 100 * share);
  if (share > limits.saturated) {
    const auto denied =
        facts.plateau && facts.plateau->saturated
            ? fmt::format(
                  ", or state \"saturation\": 1 if the camera counts beyond {:.0f} of {:.0f}",
                  facts.plateau->value * facts.largest, facts.largest)
            : std::string();
    findings.faults.push_back(fmt::format("{}, more than the {:.1f} % allowed; expose less{}", text,
                                          100 * limits.saturated, denied));
  } else {
    findings.warnings.push_back(text);
  }
}

void checkBackground(const Counts& counts, const std::string& name, bool opticalDepth,
                     PictureFindings& findings) {
  constexpr double kWorthAWord = 0.01, kMoved = 0.05;
  const double share = shareOf(counts.negative, counts.counted);
  if (share <= kWorthAWord)
    return;
  const auto text =
      opticalDepth
          ? fmt::format(
                "{}: {:.1f} % of the pixels are brighter than the background, by an optical depth "
                "of more than {:.3g}: the background moved or changed, or the medium shines",
                name, 100 * share, 2 * counts.threshold)
          : fmt::format(
                "{}: {:.1f} % of the pixels are darker than the background by more than {:.3g}: "
                "the background moved or changed, for light is never negative",
                name, 100 * share, 2 * counts.threshold);
  (share > kMoved ? findings.faults : findings.warnings).push_back(text);
}

void checkPlace(const TomographyView& view, const Counts& counts, const std::string& name,
                SharedSentences& shared, PictureFindings& findings) {
  constexpr double kLightOutside = 0.02, kBorderShare = 0.02;
  if (counts.lightOutside > kLightOutside * counts.light) {
    findings.warnings.push_back(fmt::format(
        "{}: {:.1f} % of the light lies outside the volume's bounds; enlarge them, mask what does "
        "not belong to the medium, or check the pose",
        name, 100 * counts.lightOutside / counts.light));
  }
  const auto whole = [&](std::size_t side) {
    constexpr double kNearlyAll = 0.9;
    const int length = side < 2 ? view.radiance.height : view.radiance.width;
    return static_cast<double>(counts.border[side]) > kNearlyAll * length;
  };
  if (whole(0) && whole(1) && whole(2) && whole(3)) {
    shared.add(
        view.opticalDepth
            ? "darker than the background all along the border of the picture: the background got "
              "darker than it is known, or the medium is all around"
            : "light all along the border of the picture, which is taken as the volume's: state "
              "the \"background\" (again, if it got brighter), or a \"black\" level",
        view.name);
    return;
  }
  for (std::size_t side = 0; side < counts.border.size(); ++side) {
    const int length = side < 2 ? view.radiance.height : view.radiance.width;
    if (static_cast<double>(counts.border[side]) <= std::max(3.0, kBorderShare * length))
      continue;
    findings.warnings.push_back(
        fmt::format("{}: the silhouette touches the {} border of the picture in {} of {} pixels: "
                    "some of the light lies outside",
                    name, kBorders[side], counts.border[side], length));
  }
}

/// A pixel by itself.
struct Outlier {
  int x = 0, y = 0;
  float value = 0, around = 0;  ///< its largest channel, and its neighbours' largest
};

/// What was undone is told where it is large: lamps that change so much may not be steady either.
void checkDrift(const PictureFacts& facts, const std::string& name, PictureFindings& findings) {
  constexpr double kWorthAWord = 0.05;
  if (!facts.drift)
    return;
  const auto& gain = facts.drift->gain;
  const double change = (gain[0] + gain[1] + gain[2]) / 3 - 1;
  if (std::abs(change) <= kWorthAWord)
    return;
  findings.warnings.push_back(fmt::format(
      "{}: its background is {:.1f} % {} than the one that was given, by the pixels beside the "
      "volume; that is undone, but a background of the same day would be better",
      name, 100 * std::abs(change), change > 0 ? "brighter" : "darker"));
}

void checkOpaque(const PictureFacts& facts, const std::string& name, PictureFindings& findings) {
  constexpr double kWorthAWord = 0.02;
  if (facts.opaqueShare <= kWorthAWord)
    return;
  findings.warnings.push_back(fmt::format(
      "{}: {:.1f} % of the pixels let no light through: of their optical depth only a lower bound "
      "is known; a brighter background or a longer exposure tells more",
      name, 100 * facts.opaqueShare));
}

void checkLevel(const PictureFacts& facts, const std::string& name, PictureFindings& findings) {
  if (facts.levelLeft > 0)
    findings.warnings.push_back(
        fmt::format("{}: the darkest pixels all read {:.2g} % of the brightest background: a black "
                    "level (state "
                    "\"dark\" or \"black\"), stray light, or something in the way (mask it)?",
                    name, 100 * facts.levelLeft));
}

/// A background at white is brighter than that by nobody knows how much.
void checkSaturatedBackground(const PictureFacts& facts, const std::string& name,
                              PictureFindings& findings) {
  constexpr double kWorthAWord = 0.001;
  if (facts.litBackgroundSaturated <= kWorthAWord)
    return;
  findings.warnings.push_back(
      fmt::format("{}: the background is saturated in {:.1f} % of the pixels that show less than "
                  "that: of their "
                  "optical depth only a lower bound is known; expose less",
                  name, 100 * facts.litBackgroundSaturated));
}

/// Pixels that shine alone: ten times as bright as their neighbours, of which none is saturated,
/// and as what counts as lit.
std::vector<Outlier> lonelyPixels(const TomographyView& view, double threshold) {
  constexpr float kAlone = 10;
  const Image& image = view.radiance;
  const auto valueAt = [&](int x, int y) {
    const std::size_t pixel = static_cast<std::size_t>(y) * image.width + x;
    if (!view.weight.empty() && view.weight[pixel] == 0)
      return 0.0F;
    const float* light = &image.pixels[3 * pixel];
    return std::max({light[0], light[1], light[2]});
  };
  std::vector<Outlier> lonely;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float value = valueAt(x, y);
      if (!(value > kAlone * 2 * threshold))
        continue;
      float around = 0;
      for (int v = std::max(0, y - 1); v <= std::min(image.height - 1, y + 1); ++v) {
        for (int u = std::max(0, x - 1); u <= std::min(image.width - 1, x + 1); ++u) {
          const bool saturated = view.isSaturated(static_cast<std::size_t>(v) * image.width + u);
          if (u != x || v != y)
            around = std::max(around, saturated ? value : valueAt(u, v));
        }
      }
      if (value > kAlone * around)
        lonely.push_back({x, y, value, around});
    }
  }
  return lonely;
}

/// Hot pixels of a sensor, which a fit takes for light: those that are not faint beside the rest.
void checkHotPixels(const TomographyView& view, const Counts& counts, const std::string& name,
                    PictureFindings& findings) {
  constexpr float kFaint = 0.2F;
  auto lonely = lonelyPixels(view, counts.threshold);
  if (lonely.empty())
    return;
  Image rest = view.radiance;
  for (const Outlier& one : lonely) std::fill_n(&rest.at(one.x, one.y, 0), 3, 0.0F);
  const float brightest = *std::ranges::max_element(rest.pixels);
  std::erase_if(lonely, [&](const Outlier& one) { return one.value < kFaint * brightest; });
  if (lonely.empty())
    return;
  const auto worst = std::ranges::max_element(lonely, {}, &Outlier::value);
  findings.warnings.push_back(fmt::format(
      "{}: pixel ({}, {}) reads {:.3g} and those around it at most {:.3g}{}: hot pixels of the "
      "sensor? Mask them (0 = ignore)",
      name, worst->x, worst->y, worst->value, worst->around,
      lonely.size() > 1 ? fmt::format(", and {} more stand out like that", lonely.size() - 1)
                        : std::string()));
}

/// The hull of all views but one, as a share of the volume.
double hullWithout(std::span<const TomographyView> views,
                   std::span<const std::vector<std::uint8_t>> silhouettes, std::size_t left,
                   const VolumeGeometry& geometry) {
  std::vector<TomographyView> others;
  std::vector<std::vector<std::uint8_t>> theirs;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (i == left)
      continue;
    others.push_back(views[i]);
    theirs.push_back(silhouettes[i]);
  }
  const auto hull = visualHull(others, theirs, geometry);
  return shareOf(hull.size() - static_cast<std::size_t>(std::ranges::count(hull, 0)), hull.size());
}

}  // namespace

PictureFindings checkPictures(const FrameViews& views, const VolumeGeometry& geometry,
                              std::optional<double> noiseSigma, const PictureLimits& limits) {
  PictureFindings findings;
  std::vector<Counts> counts;
  std::size_t brightest = 0;
  for (std::size_t i = 0; i < views.views.size(); ++i) {
    counts.push_back(countPixels(views.views[i], views.facts[i], geometry.bounds, noiseSigma));
    if (counts[i].lit > counts[brightest].lit)
      brightest = i;
  }
  // One or two lit pixels are hot ones, or a spark that others need not see.
  constexpr std::size_t kFew = 3;
  const auto seeing =
      std::ranges::count_if(counts, [](const Counts& count) { return count.lit >= kFew; });
  findings.dark = seeing == 0;
  const bool maxSee = 2 * static_cast<std::size_t>(seeing) > counts.size();
  SharedSentences storing, wrong, borders;
  for (std::size_t i = 0; i < counts.size(); ++i)
    checkStoring(views.facts[i], views.views[i].name, views.views[i].grey, storing, wrong);
  storing.moveTo(findings.warnings, views.frame);
  if (!findings.dark) {
    checkBits(views, findings);
    checkCounts(views, findings);
  }
  wrong.moveTo(findings.faults, views.frame);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::string name = fmt::format("camera {}, frame {}", views.views[i].name, views.frame);
    if (views.facts[i].missing) {
      findings.warnings.push_back(
          fmt::format("{}: there is no picture; the other cameras tell alone", name));
      continue;
    }
    checkHotPixels(views.views[i], counts[i], name, findings);
    if (counts[i].lit == 0 && maxSee) {
      findings.faults.push_back(fmt::format(
          "{}: {}, while camera {} has {} lit pixels: a covered lens, a wrong file, or another "
          "frame?",
          name,
          views.facts[i].brightest > 0
              ? fmt::format("shows no {} above {:.3g}",
                            views.opticalDepth ? "optical depth" : "light", 2 * counts[i].threshold)
              : std::string("the picture is all black"),
          views.views[brightest].name, counts[brightest].lit));
      continue;
    }
    checkSaturation(counts[i], views.facts[i], name, limits, findings);
    checkBackground(counts[i], name, views.opticalDepth, findings);
    checkDrift(views.facts[i], name, findings);
    checkOpaque(views.facts[i], name, findings);
    checkSaturatedBackground(views.facts[i], name, findings);
    checkLevel(views.facts[i], name, findings);
    checkPlace(views.views[i], counts[i], name, borders, findings);
    if (views.facts[i].transparentMask > 0) {
      findings.warnings.push_back(
          fmt::format("{}: {:.1f} % of the pixels of its mask are transparent, and do not count",
                      name, 100 * views.facts[i].transparentMask));
    }
    if (views.facts[i].transparentShare > 0) {
      findings.warnings.push_back(fmt::format(
          "{}: {:.1f} % of the pixels are transparent; their colours are taken as multiplied by "
          "alpha, as OpenEXR has it, with black behind them",
          name, 100 * views.facts[i].transparentShare));
    }
  }
  borders.moveTo(findings.warnings, views.frame);
  return findings;
}

std::string explainEmptyHull(const FrameViews& views, const VolumeGeometry& geometry,
                             std::optional<double> noiseSigma) {
  const auto fitted = views.fitted();
  std::vector<std::vector<std::uint8_t>> silhouettes;
  for (const TomographyView& view : fitted)
    silhouettes.push_back(dilatedSilhouette(view, noiseSigma));
  double most = 0;
  std::string culprit;
  for (std::size_t i = 0; i < fitted.size(); ++i) {
    const double share = hullWithout(fitted, silhouettes, i, geometry);
    if (share > most) {
      most = share;
      culprit = fitted[i].name;
    }
  }
  const auto text = fmt::format(
      "frame {}: the visual hull is empty: no voxel of the volume lies in the silhouettes of all "
      "{} "
      "cameras",
      views.frame, fitted.size());
  if (culprit.empty())
    return text + ", nor in those of all but one; check bounds, poses and backgrounds";
  return fmt::format(
      "{}; without camera {} it would hold {:.2f} % of them: check that camera's pose, "
      "frames and background",
      text, culprit, 100 * most);
}

}  // namespace volute
