// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <Eigen/Core>

#include "volute/math/vec.hpp"

namespace volute {

/// As Eigen's; the way back needs no word: Vec3, Rgb, Mat3 and so on are made of Eigen's.
template <class T, int N>
Eigen::Matrix<T, N, 1> asEigen(const VecN<T, N>& v) {
  return Eigen::Matrix<T, N, 1>(v.data());
}

template <class T, int N>
Eigen::Array<T, N, 1> asEigen(const ArrayN<T, N>& a) {
  return Eigen::Array<T, N, 1>(a.data());
}

template <class T, int Rows, int Columns>
Eigen::Matrix<T, Rows, Columns> asEigen(const MatN<T, Rows, Columns>& m) {
  return Eigen::Map<const Eigen::Matrix<T, Rows, Columns, Eigen::ColMajor>>(m.data());
}

}  // namespace volute
