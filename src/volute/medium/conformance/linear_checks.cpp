// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>
#include <numeric>

#include "volute/medium/conformance/support.hpp"

// For media whose optical depth is P c: P is opticalDepth() as a function of the coefficients, P'
// is scatter().

namespace volute::conformance {
namespace {

/// Only segments of finite depth; an infinite one has no place in a product.
std::vector<NamedSegment> finiteSegmentsOf(const MediumUnderTest& tested) {
  std::vector<NamedSegment> segments = segmentsOf(tested);
  std::erase_if(segments, [&](const NamedSegment& named) {
    return std::isinf(depthOf(tested.medium, named.segment));
  });
  return segments;
}

/// P c.
std::vector<double> depthsWith(const LinearCalls& linear, std::span<const double> coefficients,
                               std::span<const Segment> batch) {
  std::vector<double> depths(batch.size());
  linear.withCoefficients(coefficients).opticalDepth(batch, depths);
  return depths;
}

/// P' y.
std::vector<double> gradientOf(const LinearCalls& linear, std::span<const Segment> batch,
                               std::span<const double> weights) {
  std::vector<double> gradient(linear.coefficients.size(), 0);
  linear.scatter(batch, weights, gradient);
  return gradient;
}

struct Product {
  double value = 0;
  double magnitude = 0;  ///< the sum of the magnitudes: what rounding is relative to
};

Product dot(std::span<const double> a, std::span<const double> b) {
  Product product;
  for (std::size_t i = 0; i < a.size(); ++i) {
    product.value += a[i] * b[i];
    product.magnitude += std::abs(a[i] * b[i]);
  }
  return product;
}

double largest(std::span<const double> values) {
  double most = 0;
  for (double value : values) most = std::max(most, std::abs(value));
  return most > 0 ? most : 1;
}

Failures coefficientsComeBack(const MediumUnderTest& tested) {
  Report report;
  const LinearCalls& linear = *tested.linear;
  if (linear.coefficients.empty())
    report.add("the medium has no coefficients");
  Random random(tested.traits.seed + 9);
  const auto c = random.numbers(linear.coefficients.size(), 0, largest(linear.coefficients));
  const auto again = linear.coefficientsAfter(c);
  if (again.size() != c.size()) {
    report.add("{} coefficients went in, {} came out", c.size(), again.size());
    return report.take();
  }
  for (std::size_t i = 0; i < c.size(); ++i) {
    if (!near(c[i], again[i], tested.traits.tolerance.closedForm, 0)) {
      report.add("coefficient {} went in as {:.17g} and came out as {:.17g}", i, c[i], again[i]);
    }
  }
  return report.take();
}

Failures ownCoefficientsGiveTheMedium(const MediumUnderTest& tested) {
  Report report;
  const auto segments = finiteSegmentsOf(tested);
  const auto depths = depthsWith(*tested.linear, tested.linear->coefficients, batchOf(segments));
  const Scale scale = scaleOf(tested);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const double depth = depthOf(tested.medium, segments[i].segment);
    if (!near(depth, depths[i], tested.traits.tolerance.closedForm, scale.depth)) {
      report.at(segments[i], "optical depth {:.17g}, but {:.17g} after its own coefficients", depth,
                depths[i]);
    }
  }
  return report.take();
}

Failures noCoefficientsNoDepth(const MediumUnderTest& tested) {
  Report report;
  const auto segments = segmentsOf(tested);
  const std::vector<double> zeros(tested.linear->coefficients.size(), 0);
  const auto depths = depthsWith(*tested.linear, zeros, batchOf(segments));
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (depths[i] != 0)
      report.at(segments[i], "optical depth {} with coefficients 0", depths[i]);
  }
  return report.take();
}

Failures depthsAreLinear(const MediumUnderTest& tested) {
  Report report;
  const LinearCalls& linear = *tested.linear;
  Random random(tested.traits.seed + 10);
  const double size = largest(linear.coefficients);
  const auto segments = finiteSegmentsOf(tested);
  const auto batch = batchOf(segments);
  for (int round = 0; round < 3; ++round) {
    const auto a = random.numbers(linear.coefficients.size(), 0, size);
    const auto b = random.numbers(linear.coefficients.size(), 0, size);
    const double factor = random.uniform(0.1, 20);
    std::vector<double> sum(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) sum[i] = a[i] + factor * b[i];
    const auto ofA = depthsWith(linear, a, batch), ofB = depthsWith(linear, b, batch);
    const auto ofSum = depthsWith(linear, sum, batch);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (!near(ofSum[i], ofA[i] + factor * ofB[i], tested.traits.tolerance.closedForm,
                largest(ofSum))) {
        report.at(segments[i], "P(a + {} b) = {:.12g}, but P a + {} P b = {:.12g}", factor,
                  ofSum[i], factor, ofA[i] + factor * ofB[i]);
      }
    }
  }
  return report.take();
}

Failures goodCoefficientsGiveNoNegativeDepth(const MediumUnderTest& tested) {
  Report report;
  const LinearCalls& linear = *tested.linear;
  Random random(tested.traits.seed + 11);
  const auto segments = finiteSegmentsOf(tested);
  for (int round = 0; round < 4; ++round) {
    auto c = random.numbers(linear.coefficients.size(), 0, 1);
    for (double& value : c)
      value = value < 0.7 ? 0 : value;  // sparse: an undershoot of a lone one shows
    const auto depths = depthsWith(linear, c, batchOf(segments));
    for (std::size_t i = 0; i < segments.size(); ++i) {
      if (!(depths[i] >= -tested.traits.tolerance.closedForm * largest(depths))) {
        report.at(segments[i], "optical depth {} with coefficients >= 0", depths[i]);
      }
    }
  }
  return report.take();
}

Failures scatterIsTheAdjoint(const MediumUnderTest& tested) {
  Report report;
  const LinearCalls& linear = *tested.linear;
  Random random(tested.traits.seed + 12);
  const auto batch = batchOf(finiteSegmentsOf(tested));
  for (int round = 0; round < 6; ++round) {
    const auto c = random.numbers(linear.coefficients.size(), 0, 1);
    const auto y = random.numbers(batch.size(), round < 3 ? -1 : 0, 3);
    const Product left = dot(depthsWith(linear, c, batch), y),
                  right = dot(c, gradientOf(linear, batch, y));
    if (!near(left.value, right.value, tested.traits.tolerance.adjoint,
              std::max(left.magnitude, right.magnitude))) {
      report.add("<P c, y> = {:.17g}, but <c, P' y> = {:.17g} (round {})", left.value, right.value,
                 round);
    }
  }
  return report.take();
}

/// The identity above, one segment at a time: a single missing cell cannot hide in a long sum.
Failures scatterIsTheAdjointOfEachSegment(const MediumUnderTest& tested) {
  Report report;
  const LinearCalls& linear = *tested.linear;
  Random random(tested.traits.seed + 13);
  const auto c = random.numbers(linear.coefficients.size(), 0.5, 1.5);
  const auto segments = finiteSegmentsOf(tested);
  const auto depths = depthsWith(linear, c, batchOf(segments));
  const double weight = 2.5;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Product product = dot(c, gradientOf(linear, {&segments[i].segment, 1}, {&weight, 1}));
    if (!near(weight * depths[i], product.value, tested.traits.tolerance.adjoint,
              std::max(product.magnitude, largest(depths)))) {
      report.at(segments[i], "y P c = {:.17g}, but <c, P' y> = {:.17g}", weight * depths[i],
                product.value);
    }
  }
  return report.take();
}

/// And one coefficient at a time, for some of those that the segments meet.
Failures scatterIsTheAdjointOfEachCoefficient(const MediumUnderTest& tested) {
  constexpr std::size_t kCoefficients = 24;
  Report report;
  const LinearCalls& linear = *tested.linear;
  Random random(tested.traits.seed + 14);
  const auto batch = batchOf(finiteSegmentsOf(tested));
  const auto y = random.numbers(batch.size(), 0, 1);
  const auto gradient = gradientOf(linear, batch, y);
  const std::size_t count = gradient.size();
  for (std::size_t k = 0; k < std::min(count, kCoefficients); ++k) {
    const std::size_t i =
        count <= kCoefficients ? k : std::size_t(random.uniform(0, double(count)));
    std::vector<double> one(count, 0);
    one[i] = 1;
    const Product product = dot(depthsWith(linear, one, batch), y);
    if (!near(product.value, gradient[i], tested.traits.tolerance.adjoint, product.magnitude)) {
      report.add("coefficient {}: <P e, y> = {:.17g}, but (P' y) = {:.17g}", i, product.value,
                 gradient[i]);
    }
  }
  return report.take();
}

Failures scatterAddsToTheGradient(const MediumUnderTest& tested) {
  Report report;
  const LinearCalls& linear = *tested.linear;
  const auto batch = batchOf(finiteSegmentsOf(tested));
  const std::vector<double> weights(batch.size(), 1.0);
  const auto fresh = gradientOf(linear, batch, weights);
  std::vector<double> twice = fresh;
  linear.scatter(batch, weights, twice);
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    if (!near(twice[i], 2 * fresh[i], tested.traits.tolerance.closedForm, 0)) {
      report.add("coefficient {}: {:.17g} after one scatter, {:.17g} after two", i, fresh[i],
                 twice[i]);
    }
  }
  return report.take();
}

Failures emptyAndMissingSegmentsScatterNothing(const MediumUnderTest& tested) {
  Report report;
  std::vector<NamedSegment> segments = emptySegmentsOf(tested);
  for (NamedSegment& named : missingSegmentsOf(tested)) segments.push_back(std::move(named));
  const double weight = 1;
  for (const NamedSegment& named : segments) {
    for (double value : gradientOf(*tested.linear, {&named.segment, 1}, {&weight, 1})) {
      if (value != 0)
        report.at(named, "scatters {}", value);
    }
  }
  return report.take();
}

}  // namespace

std::vector<Check> linearChecks() {
  return {{"CoefficientsComeBack", coefficientsComeBack, true},
          {"OwnCoefficientsGiveTheMedium", ownCoefficientsGiveTheMedium, true},
          {"NoCoefficientsNoDepth", noCoefficientsNoDepth, true},
          {"DepthsAreLinear", depthsAreLinear, true},
          {"GoodCoefficientsGiveNoNegativeDepth", goodCoefficientsGiveNoNegativeDepth, true},
          {"ScatterIsTheAdjoint", scatterIsTheAdjoint, true},
          {"ScatterIsTheAdjointOfEachSegment", scatterIsTheAdjointOfEachSegment, true},
          {"ScatterIsTheAdjointOfEachCoefficient", scatterIsTheAdjointOfEachCoefficient, true},
          {"ScatterAddsToTheGradient", scatterAddsToTheGradient, true},
          {"EmptyAndMissingSegmentsScatterNothing", emptyAndMissingSegmentsScatterNothing, true}};
}

}  // namespace volute::conformance
