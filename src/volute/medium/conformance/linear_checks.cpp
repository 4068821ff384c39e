// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>

#include "volute/medium/conformance/random.hpp"
#include "volute/medium/conformance/support.hpp"

// For media whose optical depth is P c: P is opticalDepth() as a function of the coefficients.

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

}  // namespace

std::vector<Check> linearChecks() {
  return {{"CoefficientsComeBack", coefficientsComeBack, true},
          {"OwnCoefficientsGiveTheMedium", ownCoefficientsGiveTheMedium, true},
          {"NoCoefficientsNoDepth", noCoefficientsNoDepth, true},
          {"DepthsAreLinear", depthsAreLinear, true},
          {"GoodCoefficientsGiveNoNegativeDepth", goodCoefficientsGiveNoNegativeDepth, true}};
}

}  // namespace volute::conformance
