// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>

namespace volute {

struct Polynomial;

/// c0 + c1 s + c2 s^2 + c3 s^3.
struct Cubic {
  std::array<double, 4> c{};

  operator Polynomial() const;  // NOLINT(google-explicit-constructor): in polynomial.hpp

  double operator()(double s) const { return c[0] + s * (c[1] + s * (c[2] + s * c[3])); }

  /// Its integral from 0 to s.
  double integral(double s) const {
    return s * (c[0] + s * (c[1] / 2 + s * (c[2] / 3 + s * c[3] / 4)));
  }

  bool isConstant() const { return c[1] == 0 && c[2] == 0 && c[3] == 0; }

  bool isZero() const { return c[0] == 0 && isConstant(); }

  /// The same curve in the parameter s - shift.
  Cubic shifted(double shift) const {
    return {{(*this)(shift), c[1] + shift * (2 * c[2] + shift * 3 * c[3]), c[2] + 3 * shift * c[3],
             c[3]}};
  }

  Cubic& operator+=(const Cubic& other) {
    for (int i = 0; i < 4; ++i) c[i] += other.c[i];
    return *this;
  }

  Cubic operator*(double factor) const {
    return {{c[0] * factor, c[1] * factor, c[2] * factor, c[3] * factor}};
  }
};

}  // namespace volute
