// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/placement.hpp"

#include <Eigen/LU>
#include <cmath>

#include "volute/io/json_values.hpp"

namespace volute {
namespace {

constexpr double kRight = 1e-6;  ///< how far from 90 degrees a volume's axes may be, as a cosine

}  // namespace

Result<Mat4> parseTransform(const nlohmann::json& json, const std::string& file, const std::string& path) {
  if (!json.is_array() || json.size() != 16) {
    return fail(ErrorCode::kInvalidData, "{}: {}: expected 16 numbers, row-major", file, path);
  }
  Mat4 matrix;
  for (int i = 0; i < 16; ++i) {
    VOLUTE_ASSIGN(matrix(i / 4, i % 4),
                  jsonToNumber(json[i], file, fmt::format("{}[{}]", path, i)));
  }
  if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    return fail(ErrorCode::kInvalidData,
                "{}: {}: expected 0, 0, 0, 1 as the last four of the numbers, which are row-major",
                file, path);
  }
  if (!(std::abs(matrix.determinant()) > 0))
    return fail(ErrorCode::kInvalidData, "{}: {}: makes everything flat", file, path);
  return matrix;
}

Result<Placement> parsePlacement(const nlohmann::json& json, const std::string& file,
                                 const std::string& path) {
  VOLUTE_ASSIGN(const Mat4 matrix, parseTransform(json, file, path));
  const Mat3 linear = matrix.topLeftCorner<3, 3>();
  Placement placement;
  placement.scale = linear.colwise().norm().transpose();
  placement.offset = matrix.topRightCorner<3, 1>();
  placement.turn = linear * placement.scale.cwiseInverse().asDiagonal();
  const Mat3 square = placement.turn.transpose() * placement.turn - Mat3::Identity();
  if (square.cwiseAbs().maxCoeff() > kRight) {
    return fail(ErrorCode::kUnsupported,
                "{}: {}: shears the volume; expected moving, turning, mirroring and scaling along "
                "the volume's axes",
                file, path);
  }
  return placement;
}

}  // namespace volute
