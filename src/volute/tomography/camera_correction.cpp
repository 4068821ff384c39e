// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/camera_correction.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "volute/base/assert.hpp"
#include "volute/math/eigen.hpp"
#include "volute/math/rotation.hpp"

namespace volute {
namespace {

Mat3 rotationOf(const Vec3& turn) {
  return turnAbout(turn.normalized(), turn.norm());
}

Mat3 cross(const Vec3& v) {
  return {0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0};
}

}  // namespace

CameraCorrection zoomBy(double factor) {
  CameraCorrection correction;
  correction.values[CameraCorrection::kZoom] = std::log(factor);
  return correction;
}

CameraCorrection lensBy(double k1) {
  CameraCorrection correction;
  correction.values[CameraCorrection::kLens] = k1;
  return correction;
}

Result<Camera> corrected(const Camera& camera, const CameraCorrection& correction, double scale) {
  if (camera.isOrthographic())
    return fail(ErrorCode::kInvalidArgument, "is orthographic; only pinholes can be refined");
  Mat3 k = camera.intrinsics();
  const double zoom = std::exp(correction.values[CameraCorrection::kZoom]);
  for (int row = 0; row < 2; ++row) {
    k(row, 0) *= zoom, k(row, 1) *= zoom;
    k(row, 2) += correction.values[CameraCorrection::kPrincipal + row] / scale;
  }
  Distortion lens = camera.distortion();
  lens.k1 += correction.values[CameraCorrection::kLens];
  // The camera's axes turn with it.
  const Mat3 rotation = camera.rotation() * rotationOf(correction.turn()).transpose();
  const Vec3 eye = camera.eye() + correction.shift();
  return Camera::calibrated(
      {camera.width(), camera.height(), k, rotation, -(rotation * eye), lens, 0.5});
}

CameraCorrection plausibleCorrection(const Camera& camera, const Vec3& centre) {
  constexpr double kTurn = 0.5 * std::numbers::pi / 180, kShift = 0.01, kZoom = 0.02,
                   kPrincipal = 0.01, kGain = 0.1, kExponent = 0.1;
  const double lens = camera.distortion().none() ? 0.03 : 0.005;
  const double border = 0.5 * camera.width() * camera.pixelWidth(), square = border * border;
  CameraCorrection plausible;
  const double shift = kShift * (camera.eye() - centre).norm();
  plausible.values << kTurn, kTurn, kTurn, shift, shift, shift, kZoom, kPrincipal * camera.width(),
      kPrincipal * camera.width(), kGain, lens / square, kExponent;
  return plausible;
}

void removeCommonPart(std::span<const Camera> cameras, const Vec3& centre,
                      std::span<const CameraCorrection> plausible,
                      std::span<CameraCorrection> corrections) {
  VOLUTE_ASSERT(cameras.size() == corrections.size() && plausible.size() == cameras.size());
  // turn_i = omega, shift_i = tau + omega x d_i + sigma d_i, weighted least squares.
  Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, 1> right = Eigen::Matrix<double, 7, 1>::Zero();
  std::vector<Eigen::Matrix<double, 6, 7>> moves;
  double gain = 0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Vec3 from = cameras[i].eye() - centre;
    Eigen::Matrix<double, 6, 7> move = Eigen::Matrix<double, 6, 7>::Zero();
    move.topLeftCorner<3, 3>().setIdentity();
    move.bottomLeftCorner<3, 3>() = -asEigen(cross(from));
    move.block<3, 3>(3, 3).setIdentity();
    move.bottomRightCorner<3, 1>() = asEigen(from);
    const Eigen::Matrix<double, 6, 1> weight =
        plausible[i].values.head<6>().cwiseProduct(plausible[i].values.head<6>()).cwiseInverse();
    normal += move.transpose() * weight.asDiagonal() * move;
    right += move.transpose() * weight.asDiagonal() * corrections[i].values.head<6>();
    gain += corrections[i].values[CameraCorrection::kGain];
    moves.push_back(move);
  }
  // One camera leaves the turn and the shift to each other.
  normal += 1e-12 * normal.trace() * Eigen::Matrix<double, 7, 7>::Identity();
  const Eigen::Matrix<double, 7, 1> common = normal.ldlt().solve(right);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    corrections[i].values.head<6>() -= moves[i] * common;
    corrections[i].values[CameraCorrection::kGain] -= gain / static_cast<double>(cameras.size());
  }
}

namespace {

using Similarity = Eigen::Matrix<double, 7, 1>;  // turn, shift [m], logarithm of the scale

Vec3 moved(const Similarity& by, const Vec3& centre, const Vec3& point) {
  return centre + Vec3(by.segment<3>(3)) +
         std::exp(by[6]) * (rotationOf(by.head<3>()) * (point - centre));
}

/// The camera that sees what `camera` sees of the moved world.
Result<Camera> movedCamera(const Camera& camera, const Similarity& by, const Vec3& centre) {
  const Mat3 turn = rotationOf(by.head<3>());
  const double scale = std::exp(by[6]);
  const Mat3 rotation = camera.rotation() * turn;
  const Vec3 t = camera.rotation() *
                 (centre + Vec3(by.segment<3>(3)) - scale * (turn * centre) - camera.eye()) / scale;
  return Camera::calibrated({camera.width(), camera.height(), camera.intrinsics(), rotation, t,
                             camera.distortion(), 0.5});
}

/// Pixels, as a share of the picture's width, between where both cameras see the points.
Eigen::VectorXd displacements(const Camera& given, const Camera& now, std::span<const Vec3> points,
                              const Similarity& by, const Vec3& centre) {
  Eigen::VectorXd off = Eigen::VectorXd::Zero(2 * static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto was = given.project(points[i]), is = now.project(moved(by, centre, points[i]));
    if (was && is)
      off.segment<2>(2 * static_cast<Eigen::Index>(i)) = asEigen((*is - *was) / given.width());
  }
  return off;
}

}  // namespace

Result<std::vector<Camera>> keepInPlace(std::span<const Camera> given, const Box3& bounds,
                                        std::span<CameraCorrection> corrections) {
  constexpr int kSteps = 30;
  constexpr double kLittle = 1e-5, kMin = 1e-4;
  const Vec3 centre = bounds.centre();
  std::vector<Vec3> points{centre};
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 side(corner & 1 ? 0.25 : -0.25, corner & 2 ? 0.25 : -0.25,
                    corner & 4 ? 0.25 : -0.25);
    points.push_back(centre + side.cwiseProduct(bounds.size()));
  }
  // Focal lengths that were wrong say nothing about the size of the world.
  std::vector<Camera> now, was;
  for (std::size_t v = 0; v < given.size(); ++v) {
    CameraCorrection zoom;
    for (const int p : {+CameraCorrection::kZoom, +CameraCorrection::kLens})
      zoom.values[p] = corrections[v].values[p];
    VOLUTE_ASSIGN(auto before, corrected(given[v], zoom));
    VOLUTE_ASSIGN(auto camera, corrected(given[v], corrections[v]));
    was.push_back(before);
    now.push_back(camera);
  }
  const double size = bounds.size().norm();
  Similarity little = Similarity::Constant(kLittle);
  little.segment<3>(3) *= size;
  Similarity by = Similarity::Zero();
  for (int k = 0; k < kSteps; ++k) {
    Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
    Similarity right = Similarity::Zero();
    for (std::size_t v = 0; v < given.size(); ++v) {
      const Eigen::VectorXd off = displacements(was[v], now[v], points, by, centre);
      Eigen::MatrixXd slope(off.size(), 7);
      for (int p = 0; p < 7; ++p) {
        Similarity beside = by;
        beside[p] += little[p];
        slope.col(p) = (displacements(was[v], now[v], points, beside, centre) - off) / little[p];
      }
      const double weight = 1 / std::max(off.norm(), kMin);
      normal += weight * slope.transpose() * slope;
      right -= weight * slope.transpose() * off;
    }
    // Cameras in one place tell no scale.
    normal += 1e-9 * normal.trace() * Eigen::Matrix<double, 7, 7>::Identity();
    by += normal.ldlt().solve(right);
  }
  std::vector<double> gains;
  for (const CameraCorrection& one : corrections)
    gains.push_back(one.values[CameraCorrection::kGain]);
  std::ranges::sort(gains);
  const double gain = 0.5 * (gains[(gains.size() - 1) / 2] + gains[gains.size() / 2]);
  std::vector<Camera> placed;
  for (std::size_t v = 0; v < given.size(); ++v) {
    VOLUTE_ASSIGN(auto camera, movedCamera(now[v], by, centre));
    // R = R0 rotation(turn)'
    const Eigen::AngleAxisd turn(asEigen(camera.rotation().transpose() * given[v].rotation()));
    corrections[v].values.segment<3>(CameraCorrection::kTurn) = turn.angle() * turn.axis();
    corrections[v].values.segment<3>(CameraCorrection::kShift) =
        asEigen(camera.eye() - given[v].eye());
    corrections[v].values[CameraCorrection::kGain] -= gain;
    placed.push_back(camera);
  }
  return placed;
}

}  // namespace volute
