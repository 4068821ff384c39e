// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/placement.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace volute {
namespace {

constexpr double kRight = 1e-6;  ///< how far from 90 degrees a volume's axes may be, as a cosine

}  // namespace

Result<Mat4> transformFrom(const FieldValue& numbers) {
  Mat4 matrix;
  for (int i = 0; i < 16; ++i)
    matrix(i / 4, i % 4) = numbers[static_cast<std::size_t>(i)].get<double>();
  if (matrix.row(3) != Vec4(0, 0, 0, 1)) {
    return fail(ErrorCode::kInvalidData,
                "expected 0, 0, 0, 1 as the last four of the numbers, which are row-major");
  }
  if (!(std::abs(linearPart(matrix).determinant()) > 0))
    return fail(ErrorCode::kInvalidData, "makes everything flat");
  return matrix;
}

FieldValue transformValue(const Mat4& matrix) {
  FieldValue numbers = FieldValue::array();
  for (int i = 0; i < 16; ++i) numbers.push_back(matrix(i / 4, i % 4));
  return numbers;
}

Result<Placement> placementFrom(const FieldValue& numbers) {
  VOLUTE_ASSIGN(const Mat4 matrix, transformFrom(numbers));
  const Mat3 linear = linearPart(matrix);
  Placement placement;
  placement.scale = linear.columnNorms();
  placement.offset = offsetPart(matrix);
  placement.turn = linear * placement.scale.cwiseInverse().asDiagonal();
  const Mat3 square = placement.turn.transpose() * placement.turn - Mat3::Identity();
  if (square.cwiseAbs().maxCoeff() > kRight) {
    return fail(ErrorCode::kUnsupported,
                "shears the volume; expected moving, turning, mirroring and scaling along the "
                "volume's axes");
  }
  return placement;
}

}  // namespace volute
