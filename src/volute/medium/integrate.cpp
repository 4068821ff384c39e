// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/medium/integrate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "volute/math/quadrature.hpp"

namespace volute {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRelativeTolerance = 1e-10;
constexpr double kOpaqueDepth = 46;    // exp(-46) = 1e-20: nothing comes through
constexpr double kVanishedDecay = 80;  // exp(-80) * 80^3 = 1e-29: the rest of an infinite piece

/// The integrals of t^n exp(-x t) over 0 <= t <= 1 for n < terms.
std::array<double, Polynomial::kTerms> exponentialMoments(double x, int terms) {
  std::array<double, Polynomial::kTerms> moments{};
  if (std::abs(x) > 16) {  // integration by parts; so far from 0 nothing cancels
    moments[0] = -std::expm1(-x) / x;
    for (int n = 1; n < terms; ++n) moments[n] = (n * moments[n - 1] - std::exp(-x)) / x;
    return moments;
  }
  // Series whose terms are all positive, cut where they no longer count, and before that where
  // (16 e / 80)^80 < 1e-20:
  //   x <= 0: sum of (-x)^j / (j! (n + 1 + j)), from that of the exponential
  //   x >  0: exp(-x) * sum of x^j / ((n + 1) ... (n + 1 + j)), the same by Kummer's
  //   transformation,
  //           of the last one; by parts, adding what is positive, of those before it
  constexpr int kTerms = 80;
  constexpr double kNothing = 1e-18;
  if (!(x > 0)) {
    double term = 1;
    for (int j = 0; j < kTerms; ++j) {
      for (int n = 0; n < terms; ++n) moments[n] += term / (n + 1 + j);
      term *= -x / (j + 1);
      if (term <= kNothing * moments[terms - 1])
        break;
    }
    return moments;
  }
  const double end = std::exp(-x);
  double term = end / terms, sum = 0;
  for (int j = 0; j < kTerms; ++j) {
    sum += term;
    term *= x / (terms + 1 + j);
    if (term <= kNothing * sum)
      break;
  }
  moments[terms - 1] = sum;
  for (int n = terms - 1; n > 0; --n) moments[n - 1] = (x * moments[n] + end) / n;
  return moments;
}

/// (1 - exp(-x)) / x.
double meanTransmittance(double x) {
  return x == 0 ? 1 : -std::expm1(-x) / x;
}

/// The one factor by which an emission is the extinction (both of one piece), or NaN.
double ratio(const Polynomial& emission, const Polynomial& extinction) {
  double factor = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < Polynomial::kTerms; ++i) {
    const double e = emission.c[i];
    const double x = extinction.c[i];
    if (x == 0 && e == 0)
      continue;
    if (std::isnan(factor))
      factor = e / x;
    if (!std::isfinite(factor) || std::abs(e - factor * x) > 1e-15 * std::abs(e)) {
      return std::numeric_limits<double>::quiet_NaN();
    }
  }
  return factor;
}

/// The light of one stretch of the ray on which every layer is one piece, all with the same begin
/// and end.
class Stretch {
 public:
  explicit Stretch(std::span<const Piece> layers)
      : length_(layers.front().end - layers.front().begin) {
    for (const Piece& layer : layers) add(layer);
    for (const Piece& layer : layers_) transparent_ = transparent_ && layer.extinction.isZero();
  }

  double depth(double u) const {
    double sum = 0;
    for (const Piece& layer : layers_) sum += decayingIntegral(layer.extinction, layer.decay, u);
    return sum;
  }

  double depth() const { return depth(length_); }

  /// Emitted along the stretch and not absorbed before its begin.
  Rgb emitted(double* error) const {
    if (transparent_)
      return emissionIntegral();
    Rgb closed;
    if (closedForm(closed))
      return closed;
    const double length = effectiveLength();
    if (std::isinf(length))
      return emissionIntegral();
    Sum sum;
    refine(0, length, 0, gauss(0, length), 0, sum);
    *error = sum.error;
    return sum.value;
  }

 private:
  /// Layers of equal decay are one layer.
  void add(const Piece& layer) {
    for (Piece& mine : layers_) {
      if (mine.decay != layer.decay)
        continue;
      mine.extinction += layer.extinction;
      for (int channel = 0; channel < 3; ++channel)
        mine.emission[channel] += layer.emission[channel];
      return;
    }
    layers_.push_back(layer);
  }

  Rgb emissionIntegral() const {
    Rgb sum = Rgb::Zero();
    for (const Piece& layer : layers_) sum += pieceEmission(layer);
    return sum;
  }

  /// Where emission = colour * extinction all along, the integral is colour * (1 - transmittance).
  bool closedForm(Rgb& out) const {
    if (layers_.size() != 1)
      return false;
    const double tau = depth();
    const Rgb unabsorbed = emissionIntegral();
    for (int channel = 0; channel < 3; ++channel) {
      const Polynomial& emission = layers_[0].emission[channel];
      const double colour = emission.isZero() ? 0 : ratio(emission, layers_[0].extinction);
      if (emission.isZero()) {
        out[channel] = 0;
      } else if (std::isnan(colour)) {
        return false;
      } else {  // of two equal expressions the one that is accurate there
        out[channel] =
            tau > 1 ? -colour * std::expm1(-tau) : unabsorbed[channel] * meanTransmittance(tau);
      }
    }
    return true;
  }

  /// An infinite stretch ends for the quadrature where its decay or its depth leaves nothing, if it
  /// does.
  double effectiveLength() const {
    if (std::isfinite(length_))
      return length_;
    double vanished = 0;
    double opaque = kInfinity;
    for (const Piece& layer : layers_) {
      vanished = std::max(vanished, layer.decay > 0 ? kVanishedDecay / layer.decay : kInfinity);
      if (layer.decay == 0 && layer.extinction.c[0] > 0)
        opaque = std::min(opaque, kOpaqueDepth / layer.extinction.c[0]);
    }
    return std::min(vanished, opaque);
  }

  Rgb integrand(double u) const {
    Rgb sum = Rgb::Zero();
    for (const Piece& layer : layers_) {
      const double fade = std::exp(-layer.decay * u);
      for (int channel = 0; channel < 3; ++channel)
        sum[channel] += layer.emission[channel](u) * fade;
    }
    return sum * std::exp(-depth(u));
  }

  Rgb gauss(double a, double b) const {
    const GaussRule rule = gaussRule(8);
    Rgb sum = Rgb::Zero();
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      sum += rule.weights[i] * integrand(0.5 * (a + b) + 0.5 * (b - a) * rule.nodes[i]);
    }
    return sum * (0.5 * (b - a));
  }

  /// What refine() has found so far, and how often it may still halve: pieces without meaning, such
  /// as those of a damaged file, must not hold it up. What is left then counts as it is, its error
  /// too.
  struct Sum {
    Rgb value = Rgb::Zero();
    double error = 0;
    int splitsLeft = 10000;
  };

  /// Halves [a, b] until two halves agree with the whole and nothing on it varies by more than a
  /// few e-folds: a Gauss rule could otherwise step over a thin bright front altogether.
  void refine(double a, double b, double depthAtA, const Rgb& whole, int level, Sum& sum) const {
    constexpr int kLevels = 64;
    if (depthAtA > kOpaqueDepth) {
      sum.error += whole.abs().maxCoeff();
      return;
    }
    const double m = 0.5 * (a + b);
    const Rgb left = gauss(a, m);
    const Rgb right = gauss(m, b);
    const double difference = (left + right - whole).abs().maxCoeff();
    double efolds = depth(b) - depthAtA;
    for (const Piece& layer : layers_)
      efolds = std::max(efolds, 0.25 * std::abs(layer.decay) * (b - a));
    const bool agree = difference <= kRelativeTolerance * (left + right).abs().maxCoeff();
    if ((efolds <= 2 && agree) || level >= kLevels || --sum.splitsLeft < 0) {
      sum.value += left + right;
      sum.error += difference;
      return;
    }
    refine(a, m, depthAtA, left, level + 1, sum);
    refine(m, b, depth(m), right, level + 1, sum);
  }

  double length_ = 0;
  bool transparent_ = true;
  std::vector<Piece> layers_;
};

void advance(Radiance& radiance, std::span<const Piece> layers, double& error) {
  const Stretch stretch(layers);
  double stretchError = 0;
  radiance.emitted += radiance.transmittance * stretch.emitted(&stretchError);
  error += radiance.transmittance * stretchError;
  radiance.transmittance *= std::exp(-stretch.depth());
}

}  // namespace

double decayingIntegral(const Polynomial& curve, double decay, double length) {
  const int terms = curve.terms();
  if (terms == 0)
    return 0;
  const auto& c = curve.c;
  double sum = 0;
  if (std::isinf(length)) {
    if (!(decay > 0))
      return kInfinity;
    for (int n = terms - 1; n >= 0; --n) sum = c[n] + (n + 1) * sum / decay;  // n! / decay^(n + 1)
    return sum / decay;
  }
  if (decay == 0)
    return curve.integral(length);
  const auto moments = exponentialMoments(decay * length, terms);
  double power = length;
  for (int n = 0; n < terms; ++n, power *= length) sum += c[n] * power * moments[n];
  return sum;
}

double pieceOpticalDepth(const Piece& piece) {
  return decayingIntegral(piece.extinction, piece.decay, piece.end - piece.begin);
}

Rgb pieceEmission(const Piece& piece) {
  Rgb sum;
  for (int channel = 0; channel < 3; ++channel) {
    sum[channel] = decayingIntegral(piece.emission[channel], piece.decay, piece.end - piece.begin);
  }
  return sum;
}

Piece clipped(const Piece& piece, double begin, double end) {
  const double shift = begin - piece.begin;
  Piece part = piece;
  part.begin = begin;
  part.end = end;
  if (shift == 0)
    return part;
  const double fade = std::exp(-piece.decay * shift);
  part.extinction = piece.extinction.shifted(shift) * fade;
  for (int channel = 0; channel < 3; ++channel) {
    part.emission[channel] = piece.emission[channel].shifted(shift) * fade;
  }
  return part;
}

Radiance composite(std::span<const Piece> pieces, double* errorBound) {
  Radiance radiance;
  double error = 0;
  for (const Piece& piece : pieces) advance(radiance, {&piece, 1}, error);
  if (errorBound)
    *errorBound = error;
  return radiance;
}

Radiance compositeMedia(std::span<const std::vector<Piece>> perMedium, double* errorBound) {
  std::vector<double> borders;
  for (const auto& pieces : perMedium) {
    for (const Piece& piece : pieces) borders.insert(borders.end(), {piece.begin, piece.end});
  }
  std::sort(borders.begin(), borders.end());
  borders.erase(std::unique(borders.begin(), borders.end()), borders.end());

  Radiance radiance;
  double error = 0;
  std::vector<std::size_t> next(perMedium.size(),
                                0);  // per medium, its first piece that ends further on
  std::vector<Piece> layers;
  for (std::size_t i = 0; i + 1 < borders.size(); ++i) {
    layers.clear();
    for (std::size_t m = 0; m < perMedium.size(); ++m) {
      const auto& pieces = perMedium[m];
      while (next[m] < pieces.size() && pieces[next[m]].end <= borders[i]) ++next[m];
      if (next[m] < pieces.size() && pieces[next[m]].begin <= borders[i]) {
        layers.push_back(clipped(pieces[next[m]], borders[i], borders[i + 1]));
      }
    }
    if (!layers.empty())
      advance(radiance, layers, error);
  }
  if (errorBound)
    *errorBound = error;
  return radiance;
}

double integralOfPoints(const std::function<double(const Vec3&)>& value, const Box3& bounds,
                        const Segment& segment, double tolerance, int cuts) {
  const Interval inside =
      bounds.intersect(segment.origin, segment.direction).intersect({segment.begin, segment.end});
  if (inside.empty())
    return 0;
  bool finite = true;  // adaptive halving would not end on what is not a number
  const auto at = [&](double s) {
    const double here = value(segment.at(s));
    finite = finite && std::isfinite(here);
    return std::isfinite(here) ? here : 0;
  };
  const auto between = [&](double begin, double end, const std::function<double(double)>& f) {
    double sum = 0;
    for (int i = 0; i < cuts; ++i) {
      sum += adaptiveIntegral(f, begin + (end - begin) * i / cuts,
                              begin + (end - begin) * (i + 1) / cuts, tolerance / cuts);
    }
    return sum;
  };
  // s = from +- t / (1 - t) brings infinity to t = 1.
  const auto toInfinity = [&](double from, double sign) {
    return between(0, 1, [&](double t) {
      return t == 1 ? 0 : at(from + sign * t / (1 - t)) / ((1 - t) * (1 - t));
    });
  };
  double sum = 0;
  if (std::isinf(inside.begin) && std::isinf(inside.end)) {
    sum = toInfinity(0, -1) + toInfinity(0, 1);
  } else if (std::isinf(inside.begin)) {
    sum = toInfinity(inside.end, -1);
  } else if (std::isinf(inside.end)) {
    sum = toInfinity(inside.begin, 1);
  } else {
    sum = between(inside.begin, inside.end, at);
  }
  return finite ? sum : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace volute
