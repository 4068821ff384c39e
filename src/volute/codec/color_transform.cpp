// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/color_transform.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace volute {

void ColorMoments::add(std::span<const float> values, int channels) {
  const auto n = static_cast<std::size_t>(channels);
  for (std::size_t at = 0; at < values.size(); at += n) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        sum[3 * i + j] += static_cast<double>(values[at + i]) * values[at + j];
  }
}

void ColorMoments::add(const ColorMoments& other) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += other.sum[i];
}

ColorTransform ColorTransform::of(const ColorMoments& moments) {
  using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(Eigen::Map<const Matrix>(moments.sum.data()));
  ColorTransform transform;
  if (solver.info() != Eigen::Success || !solver.eigenvectors().allFinite())
    return transform;
  for (int i = 0; i < 3; ++i) {
    // Ascending eigenvalues. The sign is free: the greatest part is positive.
    Eigen::Vector3d row = solver.eigenvectors().col(2 - i);
    Eigen::Index greatest = 0;
    row.cwiseAbs().maxCoeff(&greatest);
    if (row[greatest] < 0)
      row = -row;
    for (int j = 0; j < 3; ++j) transform.rows[3 * i + j] = static_cast<float>(row[j]);
  }
  return transform;
}

std::vector<float> ColorTransform::split(std::span<const float> values, int channels,
                                         float unit) const {
  std::vector<float> planes(values.size());
  if (channels == 1) {
    std::ranges::transform(values, planes.begin(), [unit](float value) { return value / unit; });
    return planes;
  }
  const std::size_t voxels = values.size() / 3;
  for (std::size_t i = 0; i < 3; ++i) {
    const float* row = &rows[3 * i];
    for (std::size_t v = 0; v < voxels; ++v) {
      const float* value = &values[3 * v];
      planes[i * voxels + v] =
          row[0] * (value[0] / unit) + row[1] * (value[1] / unit) + row[2] * (value[2] / unit);
    }
  }
  return planes;
}

void ColorTransform::merge(std::span<const float> planes, int channels, float unit,
                           std::span<float> values) const {
  if (channels == 1) {
    std::ranges::transform(planes, values.begin(), [unit](float value) { return value * unit; });
    return;
  }
  const std::size_t voxels = values.size() / 3;
  for (std::size_t v = 0; v < voxels; ++v) {
    const float a = planes[v];
    const float b = planes[voxels + v];
    const float c = planes[2 * voxels + v];
    for (std::size_t j = 0; j < 3; ++j)
      values[3 * v + j] = (rows[j] * a + rows[3 + j] * b + rows[6 + j] * c) * unit;
  }
}

}  // namespace volute
