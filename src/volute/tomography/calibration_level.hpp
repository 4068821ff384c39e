// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/tomography/camera_correction.hpp"
#include "volute/tomography/projector.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

/// How fine volume and pictures are in one level of a calibration fit.
struct Level {
  int voxels = 1;              ///< the volume's resolution is divided by this
  int steps = 1;               ///< Gauss-Newton steps
  int conjugateSteps = 12;     ///< of conjugate gradients in each
  double uncertainPixels = 0;  ///< how far silhouettes may be off [pixels of the given pictures]
};

/// Which parameters of a camera are refined.
using FreeParameters = std::array<bool, CameraCorrection::kCount>;

/// One level of a calibration fit: the volume is linear, the corrections are linearised around
/// where they are. Frames, cameras, geometry and options as refineCalibration() has them.
class LevelFit {
 public:
  static constexpr std::size_t kTogether = 4;  ///< frames in a product, for which there are colours

  LevelFit(std::span<const std::vector<TomographyView>> frames, const VolumeGeometry& geometry,
           const Level& level, std::span<const CameraCorrection> plausible,
           std::span<const FreeParameters> free, double pivot, std::uint64_t maxMemory);

  /// From the next step on. Corrections of what is no longer free stay.
  void setFree(std::span<const FreeParameters> free) { free_.assign(free.begin(), free.end()); }

  /// Other corrections, with the volume and the hull that are there.
  [[nodiscard]] Status setCorrections(std::span<const CameraCorrection> corrections);

  /// Hull and support, as the cameras are.
  [[nodiscard]] Status begin(std::span<const CameraCorrection> corrections, Progress& progress);

  /// Gives back what only further steps need; the volume stays.
  void forgetProjector() { projector_.reset(); }

  void startFrom(const LevelFit& coarse);

  /// Accelerated projected gradient, from where the volume is.
  void fitVolume(int iterations);

  /// Tukey's weights by the spread of each camera's residuals.
  void weigh();

  /// One Gauss-Newton step of volume and corrections together.
  [[nodiscard]] Status step(int conjugateSteps);

  /// Relative L2 of each view.
  std::vector<double> residuals() const;

  const std::vector<CameraCorrection>& corrections() const { return corrections_; }

  const std::vector<double>& sightError() const { return sightError_; }

  /// Standard deviations, from the last step's curvature.
  const std::vector<CameraCorrection>& uncertain() const { return uncertain_; }

 private:
  static constexpr int kCount = CameraCorrection::kCount;
  using Parameters = Eigen::Matrix<double, kCount, 1>;
  using Square = Eigen::Matrix<double, kCount, kCount>;
  using Vector = std::vector<float>;

  /// A camera's pictures of all frames.
  struct LevelView {
    TomographyView view;       ///< its camera as given, reduced
    int factor = 1;            ///< given pixels on a side of one
    std::vector<float> light;  ///< (height, width, frames): grey
    std::vector<float> slope;  ///< of `light` by the logarithm of the exponent; empty: not refined
    double exponent = 1;       ///< with which `light` was made
  };

  std::size_t rows() const { return projector_->rows(); }

  // Vectors of unknowns and rows have one layer for each four frames, and in it four floats each.
  std::size_t layers() const { return (frames_ + kTogether - 1) / kTogether; }

  /// Where a vector of so many unknowns or rows has one of them in a frame.
  static std::size_t slot(std::size_t count, std::size_t index, std::size_t frame) {
    return kTogether * (frame / kTogether * count + index) + frame % kTogether;
  }

  template <class Values>
  auto layerOf(Values& values, std::size_t layer) const {
    const std::size_t size = values.size() / layers();
    return std::span(values).subspan(layer * size, size);
  }

  /// S of all layers.
  void forward(const Vector& volume, Vector& rowsOut) const;

  /// S' of all layers.
  void adjoint(const Vector& values, Vector& volume) const;

  /// All but the projector's table [bytes]: pictures, what rows, their rays and slopes take, and
  /// vectors of unknowns, of which products take some more.
  std::uint64_t ownBytes() const;

  void addView(std::span<const std::vector<TomographyView>> frames, std::size_t v,
               const Level& level);

  [[nodiscard]] Result<Camera> cameraOf(std::size_t v, const CameraCorrection& correction) const;

  /// The light of a view with another exponent: that of each given pixel and channel, where
  /// anything may be seen.
  void applyExponent(std::size_t v, double exponent);

  [[nodiscard]] Status placeCameras();

  [[nodiscard]] Status makeProjector();

  /// 1 / majorizer, the largest over the frames.
  Vector steps() const;

  /// The derivative of each row's projection by its camera's corrections.
  void findSlopes();

  /// Pixels of the given pictures by which a camera sees points of the volume elsewhere, root mean
  /// square, if its corrections have this covariance.
  double sightErrorOf(std::size_t v, const Square& covariance) const;

  /// (S volume + slopes delta) of each row and frame.
  void forwardBoth(const Vector& volume, std::span<const Parameters> delta, Vector& rowsOut) const;

  void adjointBoth(const Vector& values, Vector& volume, std::vector<Parameters>& delta) const;

  /// Conjugate gradients on |W (r - S da - J dc)|^2 + |(c + dc) / plausible|^2, from zero,
  /// preconditioned by each voxel's and each camera's own block.
  std::vector<Parameters> solveTogether(int iterations);

  std::span<const std::vector<TomographyView>> given_;
  std::size_t frames_;
  std::uint64_t maxMemory_;
  double pivot_;
  VolumeGeometry geometry_;
  std::vector<CameraCorrection> plausible_, corrections_, uncertain_;
  std::vector<FreeParameters> free_;
  std::vector<double> sightError_;
  std::vector<LevelView> views_;
  std::vector<Camera> cameras_;
  std::shared_ptr<const Support> support_;
  std::unique_ptr<const Projector> projector_;
  Vector volume_;                   // one for each unknown and frame
  Vector measured_, projected_;     // one for each row and frame
  Vector weight_;                   // likewise: of squares
  Vector own_;                      // one a row: the pixel's weight
  std::vector<double> scale_;       // of each view's residuals
  std::vector<Parameters> slopes_;  // of each row and frame
  Progress* progress_ = nullptr;
};

}  // namespace volute
