// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>

#include "volute/math/cubic.hpp"

namespace volute {

/// c0 + c1 s + ... + c9 s^9: what a tensor product of three cubic splines is along a line.
struct Polynomial {
  static constexpr int kTerms = 10;
  std::array<double, kTerms> c{};

  double operator()(double s) const {
    double sum = c[kTerms - 1];
    for (int i = kTerms - 2; i >= 0; --i) sum = c[i] + s * sum;
    return sum;
  }

  /// Its integral from 0 to s.
  double integral(double s) const {
    double sum = 0;
    for (int i = kTerms - 1; i >= 0; --i) sum = c[i] / (i + 1) + s * sum;
    return s * sum;
  }

  /// One more than the place of the last coefficient that is not zero.
  int terms() const {
    int terms = kTerms;
    while (terms > 0 && c[terms - 1] == 0) --terms;
    return terms;
  }

  bool isConstant() const { return terms() <= 1; }

  bool isZero() const { return terms() == 0; }

  /// The same curve in the parameter s - shift.
  Polynomial shifted(double shift) const {
    Polynomial out = *this;  // Horner's rule again and again
    const int terms = this->terms();
    for (int i = 0; i < terms; ++i) {
      for (int j = terms - 2; j >= i; --j) out.c[j] += shift * out.c[j + 1];
    }
    return out;
  }

  Polynomial& operator+=(const Polynomial& other) {
    for (int i = 0; i < kTerms; ++i) c[i] += other.c[i];
    return *this;
  }

  Polynomial operator*(double factor) const {
    Polynomial out;
    for (int i = 0; i < kTerms; ++i) out.c[i] = c[i] * factor;
    return out;
  }

  /// Times a + b s. The highest coefficient must be zero.
  Polynomial timesLine(double a, double b) const {
    Polynomial out = *this * a;
    for (int i = 1; i < kTerms; ++i) out.c[i] += b * c[i - 1];
    return out;
  }

  bool operator==(const Polynomial&) const = default;
};

inline Cubic::operator Polynomial() const {
  return {{c[0], c[1], c[2], c[3]}};
}

}  // namespace volute
