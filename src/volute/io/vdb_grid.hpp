// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>

namespace volute {

/// An empty grid, made by OpenVDB's registry (after openvdb::initialize()). `Grid::create()` would
/// instantiate all virtual functions of the grid and its tree here: 6 s of a compiler's time for
/// each type.
template <class Grid>
typename Grid::Ptr emptyGrid(const typename Grid::ValueType& background) {
  auto grid = openvdb::gridPtrCast<Grid>(openvdb::GridBase::createGrid(Grid::gridType()));
  grid->tree().root().setBackground(background, false);
  return grid;
}

/// Of a number and its float, a difference from `offset`.
template <class Scalar>
double roundingOf(const Scalar& number, float value, double offset) {
  const double error =
      std::abs(static_cast<double>(number) - (offset + static_cast<double>(value)));
  return std::isfinite(error) ? error : 0;
}

/// The numbers of a voxel, as floats less an offset.
template <class Value>
struct Channels {
  static constexpr int kCount = 1;

  static void store(const Value& value, float* to, double offset) {
    *to = static_cast<float>(value - static_cast<Value>(offset));
  }

  static double rounding(const Value& value, const float* to, double offset) {
    return roundingOf(value, *to, offset);
  }
};

template <class Scalar>
struct Channels<openvdb::math::Vec3<Scalar>> {
  static constexpr int kCount = 3;

  static void store(const openvdb::math::Vec3<Scalar>& value, float* to, double offset) {
    for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(value[c] - static_cast<Scalar>(offset));
  }

  static double rounding(const openvdb::math::Vec3<Scalar>& value, const float* to, double offset) {
    double most = 0;
    for (int c = 0; c < 3; ++c) most = std::max(most, roundingOf(value[c], to[c], offset));
    return most;
  }
};

}  // namespace volute
