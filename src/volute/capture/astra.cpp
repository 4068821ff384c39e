// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/capture/importers.hpp"
#include "volute/capture/json_value.hpp"

namespace volute {
namespace {

/// A source and a detector as a camera without a lens. The ray of column c and row r, centres at
/// whole numbers, leaves the source along c u + r v + w; with [u v w] = Q U, Q orthonormal and U
/// upper triangular, the camera's axes are the columns of Q, and K is the inverse of U.
Status placeDetector(const JsonValue& row, CameraDraft& camera) {
  VOLUTE_ASSIGN(const auto numbers, row.numbers(12));
  const Vec3 source(&numbers[0]), centre(&numbers[3]), u(&numbers[6]);
  Vec3 v(&numbers[9]);
  Calibration& calibration = camera.calibration;
  const double middle = 0.5 * (calibration.height - 1);
  // Pictures that show the world's up at their last rows have no camera whose y is down.
  camera.pictures.bottomUp = u.cross(v).dot(centre - source) < 0;
  if (camera.pictures.bottomUp)
    v = -v;
  const Vec3 w = centre - source - 0.5 * (calibration.width - 1) * u - middle * v;
  const Vec3 x = u.normalized(), z = u.cross(v).normalized(), y = z.cross(x);
  const Mat3 axes = Mat3::ofColumns(x, y, z);
  const Mat3 corner =
      Mat3::ofColumns(Vec3(u.norm(), 0, 0), Vec3(v.dot(x), v.dot(y), 0), axes.transpose() * w);
  const double distance = corner(2, 2);
  if (!(corner(0, 0) > 0 && corner(1, 1) > 0 && distance > 1e-9 * (centre - source).norm())) {
    return row.fault(
        "expected a source, the middle of a detector that faces it, and two directions along its "
        "columns and rows");
  }
  calibration.K = corner.inverse() * distance;
  calibration.K(1, 0) = calibration.K(2, 0) = calibration.K(2, 1) = 0;
  calibration.K(2, 2) = 1;  // to the digit, which a product by an inverse need not be
  calibration.R = axes.transpose();
  calibration.t = -(calibration.R * source);
  return {};
}

}  // namespace

Result<CaptureDraft> readAstra(const std::filesystem::path& file, const nlohmann::json& json) {
  const JsonValue root(json, file.string());
  CaptureDraft draft;
  draft.kind = "ASTRA";
  draft.pixelCentre = 0;
  VOLUTE_ASSIGN(const auto type, root.at("type"));
  VOLUTE_ASSIGN(const std::string kind, type.text());
  if (kind != "cone_vec") {
    return type.fault(
        fmt::format("is {}; expected cone_vec, as astra.geom_2vec makes it of a cone", kind));
  }
  VOLUTE_ASSIGN(const auto rows, root.at("DetectorRowCount"));
  VOLUTE_ASSIGN(const auto columns, root.at("DetectorColCount"));
  VOLUTE_ASSIGN(const auto list, root.at("Vectors"));
  VOLUTE_ASSIGN(const auto vectors, list.items());
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    CameraDraft camera;
    camera.where = vectors[i].where();
    camera.name = fmt::format("{:04}", i);
    camera.calibration.pixelCentre = draft.pixelCentre;
    VOLUTE_ASSIGN(camera.calibration.height, rows.integer());
    VOLUTE_ASSIGN(camera.calibration.width, columns.integer());
    VOLUTE_TRY(placeDetector(vectors[i], camera));
    draft.cameras.push_back(std::move(camera));
  }
  draft.remarks.emplace_back(
      RemarkCode::kNote,
      "lengths of Vectors are taken as metres; ASTRA itself counts in voxels unless told "
      "otherwise");
  for (const std::string& key :
       root.unknownKeys({"type", "DetectorRowCount", "DetectorColCount", "Vectors"}))
    draft.remarks.emplace_back(RemarkCode::kLeftOut, fmt::format("{} is not used", key));
  return draft;
}

}  // namespace volute
