// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/frame_problem.hpp"

#include <algorithm>
#include <cmath>

#include "volute/tomography/hull.hpp"
#include "volute/tomography/pixel_weights.hpp"

namespace volute {
namespace {

Status checkView(const TomographyView& view) {
  const Image& image = view.radiance;
  if (image.width != view.camera.width() || image.height != view.camera.height() ||
      image.channels != 3)
    return fail(ErrorCode::kInvalidArgument,
                "Camera {}: its image is {} x {} with {} channels, its calibration says {} x {} "
                "with 3; check the image's size, or scale the calibration with it",
                view.name, image.width, image.height, image.channels, view.camera.width(),
                view.camera.height());
  const std::size_t pixels = static_cast<std::size_t>(image.width) * image.height;
  if ((!view.weight.empty() && view.weight.size() != pixels) ||
      (!view.silhouette.empty() && view.silhouette.size() != pixels) ||
      (!view.atLeast.empty() && view.atLeast.size() != pixels))
    return fail(ErrorCode::kInvalidArgument,
                "Camera {}: its mask is not as large as its image of {} x {} pixels", view.name,
                image.width, image.height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const bool counts = view.counts(i / 3) || view.isSaturated(i / 3);
    if (counts && !std::isfinite(image.pixels[i]))
      return fail(ErrorCode::kInvalidData,
                  "Camera {}: pixel ({}, {}) is not a finite number; repair the image or mask the "
                  "pixel",
                  view.name, i / 3 % image.width, i / 3 / image.width);
  }
  return {};
}

bool sees(const TomographyView& view) {
  for (std::size_t i = 0; i < view.radiance.pixels.size(); ++i) {
    if (view.radiance.pixels[i] > 0 && (view.weight.empty() || view.weight[i / 3] != 0))
      return true;
  }
  return false;
}

/// Values of pixels that do not count may be anything: they become 0.
TomographyView cleaned(const TomographyView& view) {
  TomographyView clean = view;
  for (std::size_t i = 0; i < clean.radiance.pixels.size(); ++i) {
    if (!view.counts(i / 3) && !view.isSaturated(i / 3))
      clean.radiance.pixels[i] = 0;
  }
  return clean;
}

Status emptyHull(std::span<const TomographyView> views) {
  for (const TomographyView& view : views) {
    if (!sees(view))
      return fail(ErrorCode::kNotFound,
                  "Camera {}: its image is black after the background was subtracted, so that the "
                  "visual hull is empty; check its image and background, or leave the hull out",
                  view.name);
  }
  return fail(ErrorCode::kNotFound,
              "The visual hull is empty: no voxel is seen in the silhouettes of all {} cameras; "
              "check the volume's bounds and unit [m], the calibration, and the silhouettes",
              views.size());
}

/// Bytes of what has a value for each voxel of the volume: the frame, the one before and the one
/// that diagnoses go on from, in three floats; and which voxels each camera sees.
std::uint64_t volumeBytes(const VolumeGeometry& geometry) {
  constexpr std::uint64_t kVoxel = 3 * 12 + 4;
  std::uint64_t voxels = 1;
  for (const int n : geometry.resolution) voxels *= static_cast<std::uint64_t>(n);
  return voxels * kVoxel;
}

/// The finest resolution of the same shape of which `room` holds what `bytes` are of `n`.
std::string fitting(std::array<int, 3> n, double bytes, double room) {
  const double shrink = std::cbrt(std::clamp(room / bytes, 0.0, 1.0));
  for (int& side : n) side = std::max(1, static_cast<int>(shrink * side));
  return fmt::format("{} x {} x {}", n[0], n[1], n[2]);
}

/// Bytes of the pictures, of copies without what does not count, and of silhouettes.
std::uint64_t pictureBytes(std::span<const TomographyView> views) {
  constexpr std::uint64_t kPixel = 2 * (12 + 4) + 4;
  std::uint64_t pixels = 0;
  for (const TomographyView& view : views) pixels += view.radiance.pixels.size() / 3;
  return pixels * kPixel;
}

/// Bytes of rays and vectors of pixels.
std::uint64_t rowBytes(std::span<const std::vector<std::uint8_t>> masks, int raysPerPixel) {
  constexpr std::uint64_t kColour = 16, kPixelVectors = 8;
  std::uint64_t pixels = 0;
  for (const auto& mask : masks)
    pixels += mask.size() - static_cast<std::uint64_t>(std::ranges::count(mask, 0));
  return pixels * (raysPerPixel * sizeof(WalkRay) + kPixelVectors * kColour);
}

/// Bytes of vectors of unknowns.
std::uint64_t unknownBytes(const Support& support) {
  constexpr std::uint64_t kColour = 16, kUnknownVectors = 10;
  return support.size() * kUnknownVectors * kColour;
}

/// @param fixed, growing  what is needed whatever the resolution, and what grows with it [bytes].
Status checkMemory(const VolumeGeometry& geometry, std::uint64_t fixed, std::uint64_t growing,
                   std::uint64_t maxMemory) {
  if (fixed + growing <= maxMemory)
    return {};
  const auto& n = geometry.resolution;
  const double room = static_cast<double>(maxMemory) - static_cast<double>(fixed);
  const auto remedy = room > 0 ? fmt::format("take a lower resolution (about {} would fit)",
                                             fitting(n, static_cast<double>(growing), room))
                               : std::string("take smaller images");
  return fail(
      ErrorCode::kTooLarge,
      Hint{Hint::Change::kRaise, "max_memory", fmt::format("{}G", ((fixed + growing) >> 30) + 1)},
      "The reconstruction of {} x {} x {} voxels needs {:.3g} GB, {:.3g} GB of them for "
      "pictures and rays, more than the {:.3g} GB that are allowed; {}, or one ray a pixel",
      n[0], n[1], n[2], static_cast<double>(fixed + growing) * 1e-9,
      static_cast<double>(fixed) * 1e-9, static_cast<double>(maxMemory) * 1e-9, remedy);
}

/// Rows of pixels that count for the projector.
std::vector<std::uint8_t> rowMask(const TomographyView& view,
                                  const std::vector<std::uint8_t>& silhouette) {
  std::vector<std::uint8_t> mask = silhouette;
  if (mask.empty())
    mask.assign(static_cast<std::size_t>(view.camera.width()) * view.camera.height(), 1);
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (!view.counts(i) && !view.isSaturated(i))
      mask[i] = 0;
  }
  return mask;
}

void fillRows(std::span<const TomographyView> views, const TomographyOptions& options,
              FrameProblem& problem) {
  // The other solvers are there to compare with: they take what they see as it is.
  const bool weighs = options.solver == TomographySolver::kApg;
  std::vector<std::vector<float>> variance;
  for (const TomographyView& view : views)
    variance.push_back(weighs ? pixelVariance(view, options.noiseSigma)
                              : std::vector<float>(view.radiance.pixels.size() / 3, 1.0F));
  const std::span<const PixelRow> rows = problem.projector->pixels();
  LeastSquares& data = problem.data;
  data.projector = problem.projector.get();
  data.measured.resize(4 * rows.size());
  data.squaredWeight.resize(rows.size());
  data.atLeast.assign(rows.size(), 0);
  const bool someGrey =
      weighs && std::ranges::any_of(views, [](const TomographyView& view) { return view.grey; });
  data.grey.assign(someGrey ? rows.size() : 0, 0);
  double sum = 0;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const TomographyView& view = views[rows[row].view];
    const std::size_t pixel = rows[row].pixel;
    std::copy_n(&view.radiance.pixels[3 * pixel], 3, &data.measured[4 * row]);
    const bool saturated = view.isSaturated(pixel) && weighs;
    const bool whole = saturated || view.weight.empty() || view.opticalDepth;
    const float own = whole && (saturated || view.counts(pixel)) ? 1 : view.weight[pixel];
    data.atLeast[row] = saturated ? view.atLeast[pixel] : 0;
    if (someGrey)
      data.grey[row] = view.grey ? 1 : 0;
    const float uncertain = variance[rows[row].view][pixel];
    data.squaredWeight[row] = uncertain > 0 ? own * own / uncertain : 0;
    sum += data.squaredWeight[row];
  }
  const auto scale = static_cast<float>(sum > 0 ? static_cast<double>(rows.size()) / sum : 0);
  for (float& weight : data.squaredWeight) weight *= scale;
  problem.variance = scale;
}

}  // namespace

Status checkVolumeSize(const VolumeGeometry& geometry, std::uint64_t maxMemory) {
  const auto& n = geometry.resolution;
  if (geometry.bounds.empty() || !geometry.bounds.min.allFinite() ||
      !geometry.bounds.max.allFinite())
    return fail(ErrorCode::kInvalidArgument,
                "The volume's bounds are empty: each maximum must be larger than its minimum");
  if (std::ranges::min(n) < 1 || std::ranges::max(n) > 1024)
    return fail(ErrorCode::kInvalidArgument,
                "The volume's resolution {} x {} x {} is out of range: 1 to 1024 voxels an axis",
                n[0], n[1], n[2]);
  if (const std::uint64_t needed = volumeBytes(geometry); needed > maxMemory) {
    return fail(ErrorCode::kTooLarge,
                Hint{Hint::Change::kRaise, "max_memory", fmt::format("{}G", (needed >> 30) + 1)},
                "A volume of {} x {} x {} voxels needs {:.3g} GB at least, more than the {:.3g} GB "
                "that are allowed; take a lower resolution (the values of {} would fit); "
                "pictures and rays need memory besides",
                n[0], n[1], n[2], static_cast<double>(needed) * 1e-9,
                static_cast<double>(maxMemory) * 1e-9,
                fitting(n, static_cast<double>(needed), static_cast<double>(maxMemory)));
  }
  return {};
}

Status checkReconstruction(std::span<const TomographyView> views, const VolumeGeometry& geometry,
                           const TomographyOptions& options) {
  if (views.empty())
    return fail(ErrorCode::kInvalidArgument, "There is no view to reconstruct from");
  VOLUTE_TRY(checkVolumeSize(geometry, options.maxMemory));
  if (options.raysPerPixel != 1 && options.raysPerPixel != 4)
    return fail(ErrorCode::kInvalidArgument, "{} rays a pixel: it can be 1 or 4",
                options.raysPerPixel);
  if (options.iterations && *options.iterations < 1)
    return fail(ErrorCode::kInvalidArgument, "{} iterations: at least 1 is needed",
                *options.iterations);
  if (options.lambda && !(*options.lambda >= 0 && std::isfinite(*options.lambda)))
    return fail(ErrorCode::kInvalidArgument, "lambda {}: it must be 0 or more", *options.lambda);
  if (options.noiseSigma && !(*options.noiseSigma >= 0 && std::isfinite(*options.noiseSigma)))
    return fail(ErrorCode::kInvalidArgument, "noise sigma {}: it must be 0 or more",
                *options.noiseSigma);
  const bool penalised = options.regularization != Regularization::kNone &&
                         options.regularization != Regularization::kAuto;
  if (penalised && options.solver != TomographySolver::kApg)
    return fail(ErrorCode::kInvalidArgument,
                "The solver {} knows no regularization; use apg, or the regularization none",
                tomographySolverName(options.solver));
  const bool apg = options.solver == TomographySolver::kApg;
  if (!(options.temporal >= 0) || (options.temporal > 0 && !apg))
    return fail(ErrorCode::kInvalidArgument,
                "A temporal prior of {} with the solver {}: expected 0 or more, and apg",
                options.temporal, tomographySolverName(options.solver));
  for (const TomographyView& view : views) VOLUTE_TRY(checkView(view));
  return {};
}

Result<FrameProblem> makeFrameProblem(std::span<const TomographyView> views,
                                      const VolumeGeometry& geometry,
                                      const TomographyOptions& options, Progress& progress) {
  std::vector<TomographyView> clean;
  for (const TomographyView& view : views) clean.push_back(cleaned(view));
  std::vector<std::vector<std::uint8_t>> silhouettes(views.size());
  std::vector<std::uint8_t> hull;
  FrameProblem problem;
  if (options.hull) {
    for (std::size_t v = 0; v < views.size(); ++v)
      silhouettes[v] = dilatedSilhouette(clean[v], options.noiseSigma);
    progress.report("visual hull", 0, 1);
    hull = visualHull(clean, silhouettes, geometry);
    const auto kept = static_cast<std::size_t>(std::ranges::count(hull, 1));
    if (kept == 0)
      return tl::unexpected(emptyHull(clean).error());
    problem.hullShare = static_cast<double>(kept) / static_cast<double>(geometry.voxels());
  }
  if (progress.cancelled())
    return fail(ErrorCode::kCancelled, "Stopped");
  problem.support = std::make_shared<const Support>(geometry, options.basis, hull);
  std::vector<std::vector<std::uint8_t>> masks;
  std::vector<ProjectorView> seen;
  for (std::size_t v = 0; v < views.size(); ++v) masks.push_back(rowMask(clean[v], silhouettes[v]));
  const std::uint64_t fixed = rowBytes(masks, options.raysPerPixel) + pictureBytes(views);
  const std::uint64_t growing = volumeBytes(geometry) + unknownBytes(*problem.support);
  VOLUTE_TRY(checkMemory(geometry, fixed, growing, options.maxMemory));
  for (std::size_t v = 0; v < views.size(); ++v) seen.push_back({&views[v].camera, masks[v]});
  const std::uint64_t table = std::min(options.maxMemory / 4, options.maxMemory - fixed - growing);
  problem.projector =
      std::make_unique<const Projector>(seen, problem.support, options.raysPerPixel, table);
  VOLUTE_TRY(
      checkMemory(geometry, fixed, growing + problem.projector->productBytes(), options.maxMemory));
  if (problem.projector->rows() == 0)
    return fail(ErrorCode::kInvalidArgument,
                "No ray of any camera meets the volume; check its bounds and unit [m], and the "
                "calibration");
  fillRows(clean, options, problem);
  return problem;
}

std::vector<double> residualOfViews(const FrameProblem& problem, std::size_t views,
                                    std::span<const float> projected) {
  std::vector<double> error(views), light(views);
  const LeastSquares& data = problem.data;
  const auto rows = problem.projector->pixels();
  for (std::size_t i = 0; i < projected.size(); ++i) {
    if (data.atLeast[i / 4] != 0)
      continue;
    const double measured = data.measured[i];
    const double difference = data.misfit(i, &projected[i - i % 4]);
    error[rows[i / 4].view] += difference * difference;
    light[rows[i / 4].view] += measured * measured;
  }
  for (std::size_t v = 0; v < views; ++v)
    error[v] = light[v] > 0 ? std::sqrt(error[v] / light[v]) : 0;
  return error;
}

std::vector<float> toVolume(const Support& support, std::span<const float> unknowns) {
  std::vector<float> volume(3 * support.geometry().voxels());
  for (std::size_t i = 0; i < support.size(); ++i)
    std::copy_n(&unknowns[4 * i], 3, &volume[3 * static_cast<std::size_t>(support.voxels()[i])]);
  return volume;
}

std::vector<float> toUnknowns(const Support& support, std::span<const float> volume) {
  std::vector<float> unknowns(4 * support.size());
  for (std::size_t i = 0; i < support.size(); ++i)
    std::copy_n(&volume[3 * static_cast<std::size_t>(support.voxels()[i])], 3, &unknowns[4 * i]);
  return unknowns;
}

}  // namespace volute
