// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/volume_flow.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/parallel.hpp"
#include "volute/tomography/vector_ops.hpp"

namespace volute {
namespace {

using Size = std::array<int, 3>;
using Triple = std::array<std::vector<float>, 3>;

std::size_t voxelsOf(const Size& n) {
  return static_cast<std::size_t>(n[0]) * n[1] * n[2];
}

Triple zeros(const Size& n) {
  Triple all;
  for (auto& one : all) one.assign(voxelsOf(n), 0.0F);
  return all;
}

/// body(voxel, x, y, z) for each voxel, by rows.
template <class Body>
void forVoxels(const Size& n, Body&& body) {
  parallelRanges(
      static_cast<std::size_t>(n[1]) * n[2], 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
          const int y = static_cast<int>(row % static_cast<std::size_t>(n[1]));
          const int z = static_cast<int>(row / static_cast<std::size_t>(n[1]));
          for (int x = 0; x < n[0]; ++x)
            body(row * static_cast<std::size_t>(n[0]) + static_cast<std::size_t>(x), x, y, z);
        }
      });
}

/// Interpolates between voxel centres: the eight corners and their weights.
struct Corners {
  std::array<std::size_t, 8> voxel{};
  std::array<float, 8> weight{};

  /// @param at  [voxels], 0 at the centre of the first.
  /// @param clamps  beyond the outer centres: as there, instead of 0 one voxel further.
  Corners(const Size& n, const std::array<float, 3>& at, bool clamps) {
    std::array<std::array<int, 2>, 3> place{};
    std::array<std::array<float, 2>, 3> share{};
    for (int a = 0; a < 3; ++a) {
      const float most = static_cast<float>(n[a]);
      const float on = clamps ? std::clamp(at[a], 0.0F, most - 1) : std::clamp(at[a], -1.0F, most);
      const float low = std::floor(on);
      const int first = static_cast<int>(low);
      share[a] = {1 - (on - low), on - low};
      for (int side = 0; side < 2; ++side) {
        const int index = first + side;
        place[a][side] = std::clamp(index, 0, n[a] - 1);
        if (index != place[a][side] && !clamps)
          share[a][side] = 0;
      }
    }
    for (int corner = 0; corner < 8; ++corner) {
      const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
      weight[corner] = share[0][i] * share[1][j] * share[2][k];
      voxel[corner] =
          (static_cast<std::size_t>(place[2][k]) * n[1] + place[1][j]) * n[0] + place[0][i];
    }
  }

  float of(std::span<const float> values) const {
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) sum += weight[corner] * values[voxel[corner]];
    return sum;
  }
};

std::array<float, 3> vectorAt(const Size& n, const Triple& field, const std::array<float, 3>& at) {
  const Corners corners(n, at, true);
  return {corners.of(field[0]), corners.of(field[1]), corners.of(field[2])};
}

/// Means of 2 x 2 x 2 voxels; 0 outside.
std::vector<float> halved(std::span<const float> fine, const Size& n, const Size& half) {
  std::vector<float> coarse(voxelsOf(half));
  forVoxels(half, [&](std::size_t voxel, int x, int y, int z) {
    float sum = 0;
    for (int k = 2 * z; k < std::min(2 * z + 2, n[2]); ++k)
      for (int j = 2 * y; j < std::min(2 * y + 2, n[1]); ++j)
        for (int i = 2 * x; i < std::min(2 * x + 2, n[0]); ++i)
          sum += fine[(static_cast<std::size_t>(k) * n[1] + j) * n[0] + i];
    coarse[voxel] = sum / 8;
  });
  return coarse;
}

Size halfOf(const Size& n) {
  return {(n[0] + 1) / 2, (n[1] + 1) / 2, (n[2] + 1) / 2};
}

/// Displacements at twice the resolution.
Triple doubled(const Triple& coarse, const Size& half, const Size& n) {
  Triple fine = zeros(n);
  forVoxels(n, [&](std::size_t voxel, int x, int y, int z) {
    const auto place = [](int i) { return (static_cast<float>(i) - 0.5F) / 2; };
    const Corners corners(half, {place(x), place(y), place(z)}, true);
    for (int a = 0; a < 3; ++a) fine[a][voxel] = 2 * corners.of(coarse[a]);
  });
  return fine;
}

/// 1 2 1 along each axis, 0 outside: a reconstruction's voxels are noisy one by one.
std::vector<float> smoothed(std::vector<float> values, const Size& n) {
  std::vector<float> next(values.size());
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(n[0]),
                                          static_cast<std::size_t>(n[0]) * n[1]};
  for (int a = 0; a < 3; ++a) {
    forVoxels(n, [&](std::size_t voxel, int x, int y, int z) {
      const int at = a == 0 ? x : a == 1 ? y : z;
      const float low = at > 0 ? values[voxel - stride[a]] : 0;
      const float high = at + 1 < n[a] ? values[voxel + stride[a]] : 0;
      next[voxel] = 0.25F * (low + 2 * values[voxel] + high);
    });
    values.swap(next);
  }
  return values;
}

/// One linearisation: min over d of
///   sum w (r + g . d)^2 + s |laplacian (u + d)|^2 + s b (div (u + d))^2
/// by conjugate gradients with the blocks' diagonal as preconditioner.
class FlowStep {
 public:
  FlowStep(const Size& n, std::span<const float> before, std::span<const float> after,
           const FlowOptions& options, const Triple& flow)
      : n_(n),
        smooth_(static_cast<float>(options.smoothness)),
        swell_(static_cast<float>(options.smoothness * options.divergence)),
        gradient_(zeros(n)),
        target_(zeros(n)) {
    linearise(before, after, flow);
    Triple own = zeros(n);
    regularise(flow, own);
    for (int a = 0; a < 3; ++a)
      forElements(voxelsOf(n_), [&](std::size_t i) {
        target_[a][i] = -gradient_[a][i] * difference_[i] - own[a][i];
      });
  }

  /// The change of the flow.
  Triple solve(int iterations) const {
    Triple d = zeros(n_), residual = target_, towards = zeros(n_), image = zeros(n_), z = zeros(n_);
    precondition(residual, z);
    towards = z;
    double rz = product(residual, z);
    const double end = 1e-6 * rz;
    for (int i = 0; i < iterations && rz > end; ++i) {
      apply(towards, image);
      const double curvature = product(towards, image);
      if (!(curvature > 0))
        break;
      const auto step = static_cast<float>(rz / curvature);
      for (int a = 0; a < 3; ++a)
        forElements(voxelsOf(n_), [&](std::size_t v) {
          d[a][v] += step * towards[a][v];
          residual[a][v] -= step * image[a][v];
        });
      precondition(residual, z);
      const double next = product(residual, z);
      const auto turn = static_cast<float>(next / rz);
      rz = next;
      for (int a = 0; a < 3; ++a)
        forElements(voxelsOf(n_),
                    [&](std::size_t v) { towards[a][v] = z[a][v] + turn * towards[a][v]; });
    }
    return d;
  }

 private:
  static constexpr float kFaint = 0.02F;  ///< a gradient that may be noise, in typical values

  /// Values of both frames half-way, then gradient and difference, both times the root of the
  /// weight.
  void linearise(std::span<const float> before, std::span<const float> after, const Triple& flow) {
    std::vector<float> mean(voxelsOf(n_));
    difference_.resize(mean.size());
    forVoxels(n_, [&](std::size_t voxel, int x, int y, int z) {
      const std::array<int, 3> at{x, y, z};
      std::array<float, 3> back{}, ahead{};
      for (int a = 0; a < 3; ++a) {
        back[a] = static_cast<float>(at[a]) - flow[a][voxel] / 2;
        ahead[a] = static_cast<float>(at[a]) + flow[a][voxel] / 2;
      }
      const float early = Corners(n_, back, false).of(before);
      const float late = Corners(n_, ahead, false).of(after);
      mean[voxel] = (early + late) / 2;
      difference_[voxel] = late - early;
    });
    forVoxels(n_, [&](std::size_t voxel, int x, int y, int z) {
      const std::array<int, 3> at{x, y, z};
      float square = 0;
      for (int a = 0; a < 3; ++a) {
        const float low = at[a] > 0 ? mean[voxel - stride(a)] : 0;
        const float high = at[a] + 1 < n_[a] ? mean[voxel + stride(a)] : 0;
        gradient_[a][voxel] = (high - low) / 2;
        square += gradient_[a][voxel] * gradient_[a][voxel];
      }
      // A difference that no displacement of a voxel explains is something else than motion.
      const float off = difference_[voxel] * difference_[voxel] / (square + kFaint * kFaint);
      const float root = 1 / std::sqrt((square + kFaint * kFaint) * std::sqrt(1 + off));
      for (auto& one : gradient_) one[voxel] *= root;
      difference_[voxel] *= root;
    });
  }

  std::size_t stride(int axis) const {
    return axis == 0   ? 1
           : axis == 1 ? static_cast<std::size_t>(n_[0])
                       : static_cast<std::size_t>(n_[0]) * n_[1];
  }

  /// out = the sum of differences to the neighbours, of which there are fewer at the border.
  void toNeighbours(std::span<const float> values, std::span<float> out) const {
    forVoxels(n_, [&](std::size_t voxel, int x, int y, int z) {
      const std::array<int, 3> at{x, y, z};
      float sum = 0;
      for (int a = 0; a < 3; ++a) {
        if (at[a] > 0)
          sum += values[voxel] - values[voxel - stride(a)];
        if (at[a] + 1 < n_[a])
          sum += values[voxel] - values[voxel + stride(a)];
      }
      out[voxel] = sum;
    });
  }

  /// out += what smoothness says of the flow: half the gradient of its cost.
  void regularise(const Triple& flow, Triple& out) const {
    std::vector<float> once(voxelsOf(n_)), twice(voxelsOf(n_));
    for (int a = 0; a < 3; ++a) {
      toNeighbours(flow[a], once);
      toNeighbours(once, twice);
      forElements(twice.size(), [&](std::size_t i) { out[a][i] += smooth_ * twice[i]; });
    }
    if (swell_ > 0)
      keepSize(flow, out);
  }

  /// out += swell D' D flow, D the divergence in the cubes between eight voxels.
  void keepSize(const Triple& flow, Triple& out) const {
    const Size cubes{n_[0] - 1, n_[1] - 1, n_[2] - 1};
    if (std::ranges::min(cubes) < 1)
      return;
    std::vector<float> swell(voxelsOf(cubes));
    const auto sign = [](int corner, int a) { return (corner >> a & 1) != 0 ? 0.25F : -0.25F; };
    const auto offset = [&](int corner) {
      return (corner & 1) * stride(0) + (corner >> 1 & 1) * stride(1) + (corner >> 2) * stride(2);
    };
    forVoxels(cubes, [&](std::size_t cube, int x, int y, int z) {
      const std::size_t first = x * stride(0) + y * stride(1) + z * stride(2);
      float sum = 0;
      for (int corner = 0; corner < 8; ++corner)
        for (int a = 0; a < 3; ++a) sum += sign(corner, a) * flow[a][first + offset(corner)];
      swell[cube] = swell_ * sum;
    });
    forVoxels(n_, [&](std::size_t voxel, int x, int y, int z) {
      for (int corner = 0; corner < 8; ++corner) {
        const int i = x - (corner & 1), j = y - (corner >> 1 & 1), k = z - (corner >> 2);
        if (i < 0 || j < 0 || k < 0 || i >= cubes[0] || j >= cubes[1] || k >= cubes[2])
          continue;
        const float value = swell[(static_cast<std::size_t>(k) * cubes[1] + j) * cubes[0] + i];
        for (int a = 0; a < 3; ++a) out[a][voxel] += sign(corner, a) * value;
      }
    });
  }

  void apply(const Triple& d, Triple& out) const {
    forElements(voxelsOf(n_), [&](std::size_t i) {
      const float along =
          gradient_[0][i] * d[0][i] + gradient_[1][i] * d[1][i] + gradient_[2][i] * d[2][i];
      for (int a = 0; a < 3; ++a) out[a][i] = gradient_[a][i] * along;
    });
    regularise(d, out);
  }

  void precondition(const Triple& residual, Triple& out) const {
    constexpr float kSquared = 6 * 6 + 6;  // the diagonal of toNeighbours() applied twice
    const float common = kSquared * smooth_ + 1.5F * swell_;
    for (int a = 0; a < 3; ++a)
      forElements(voxelsOf(n_), [&](std::size_t i) {
        out[a][i] = residual[a][i] / (common + gradient_[a][i] * gradient_[a][i]);
      });
  }

  double product(const Triple& a, const Triple& b) const {
    return dot(a[0], b[0]) + dot(a[1], b[1]) + dot(a[2], b[2]);
  }

  Size n_;
  float smooth_, swell_;
  Triple gradient_;
  std::vector<float> difference_;
  Triple target_;
};

/// One of the two frames at all resolutions, the finest first.
std::vector<std::vector<float>> pyramid(std::span<const float> values, std::span<const Size> sizes,
                                        float scale) {
  std::vector<float> first(values.begin(), values.end());
  for (float& value : first) value *= scale;
  std::vector<std::vector<float>> levels{smoothed(std::move(first), sizes[0])};
  for (std::size_t i = 1; i < sizes.size(); ++i)
    levels.push_back(halved(levels.back(), sizes[i - 1], sizes[i]));
  return levels;
}

Status checkFlow(std::span<const float> before, std::span<const float> after, const Size& size,
                 const FlowOptions& options) {
  if (std::ranges::min(size) < 1 || before.size() != voxelsOf(size) ||
      after.size() != voxelsOf(size))
    return fail(ErrorCode::kInvalidArgument,
                "Motion between volumes of {} and {} values: expected {} x {} x {} in both",
                before.size(), after.size(), size[0], size[1], size[2]);
  if (!(options.smoothness > 0) || !(options.divergence >= 0) || options.warps < 1)
    return fail(
        ErrorCode::kInvalidArgument,
        "Motion between volumes: smoothness {}, divergence {}, {} warps: expected more than "
        "0, 0 or more, and 1 or more",
        options.smoothness, options.divergence, options.warps);
  return {};
}

}  // namespace

Result<VoxelFlow> flowBetween(std::span<const float> before, std::span<const float> after,
                              const std::array<int, 3>& size, const FlowOptions& options,
                              Progress& progress) {
  constexpr int kCoarsest = 6;
  // What is coarse costs little, and what it leaves takes many steps between fine voxels.
  constexpr int kIterations = 100, kFineIterations = 20, kFineWarps = 2;
  VOLUTE_TRY(checkFlow(before, after, size, options));
  const auto lit = [](std::span<const float> values) {
    return static_cast<double>(std::ranges::count_if(values, [](float v) { return v != 0; }));
  };
  const double squares = dot(before, before) + dot(after, after);
  if (!(squares > 0))
    return VoxelFlow{size, zeros(size)};
  const auto scale =
      static_cast<float>(std::sqrt((lit(before) + lit(after)) / squares));  // 1 is typical
  std::vector<Size> sizes{size};
  while (std::ranges::max(sizes.back()) > kCoarsest) sizes.push_back(halfOf(sizes.back()));
  const auto early = pyramid(before, sizes, scale), late = pyramid(after, sizes, scale);
  Triple flow = zeros(sizes.back());
  for (std::size_t level = sizes.size(); level-- > 0;) {
    if (level + 1 < sizes.size())
      flow = doubled(flow, sizes[level + 1], sizes[level]);
    const int warps = level > 0 ? options.warps : std::min(options.warps, kFineWarps);
    for (int warp = 0; warp < warps; ++warp) {
      if (progress.cancelled())
        return fail(ErrorCode::kCancelled, "Stopped");
      const FlowStep step(sizes[level], early[level], late[level], options, flow);
      const Triple change = step.solve(level > 0 ? kIterations : kFineIterations);
      for (int a = 0; a < 3; ++a)
        forElements(flow[a].size(), [&](std::size_t i) { flow[a][i] += change[a][i]; });
    }
  }
  return VoxelFlow{size, std::move(flow)};
}

std::vector<float> greyVolume(std::span<const float> colour) {
  std::vector<float> grey(colour.size() / 3);
  forElements(grey.size(), [&](std::size_t i) {
    grey[i] = (colour[3 * i] + colour[3 * i + 1] + colour[3 * i + 2]) / 3;
  });
  return grey;
}

std::vector<float> carriedOn(std::span<const float> values, int channels, const VoxelFlow& flow) {
  constexpr int kSteps = 3;  // to the place that the displacement is read at
  std::vector<float> carried(values.size());
  const Size& n = flow.size;
  forVoxels(n, [&](std::size_t voxel, int x, int y, int z) {
    const std::array<float, 3> at{static_cast<float>(x), static_cast<float>(y),
                                  static_cast<float>(z)};
    std::array<float, 3> by{flow.along[0][voxel], flow.along[1][voxel], flow.along[2][voxel]};
    for (int i = 0; i < kSteps; ++i)
      by = vectorAt(n, flow.along, {at[0] - by[0] / 2, at[1] - by[1] / 2, at[2] - by[2] / 2});
    const Corners from(n, {at[0] - by[0], at[1] - by[1], at[2] - by[2]}, false);
    for (int corner = 0; corner < 8; ++corner) {
      for (int c = 0; c < channels; ++c)
        carried[channels * voxel + c] +=
            from.weight[corner] * values[channels * from.voxel[corner] + c];
    }
  });
  return carried;
}

VoxelFlow flowAtFrame(const VoxelFlow* before, const VoxelFlow* after, double ratio) {
  constexpr int kSteps = 3;
  const Size& n = (before ? before : after)->size;
  VoxelFlow frame{n, zeros(n)};
  const double late = !before ? 1 : after ? 1 / (1 + ratio) : 0;  // the nearer middle counts more
  const auto ofLate = static_cast<float>(late);
  const auto ofEarly = static_cast<float>((1 - late) * (after ? ratio : 1));
  forVoxels(n, [&](std::size_t voxel, int x, int y, int z) {
    const std::array<float, 3> at{static_cast<float>(x), static_cast<float>(y),
                                  static_cast<float>(z)};
    // What is here now was half a displacement earlier where the motion before is known.
    const auto onTheWay = [&](const VoxelFlow& flow, float half) {
      std::array<float, 3> by{flow.along[0][voxel], flow.along[1][voxel], flow.along[2][voxel]};
      for (int i = 0; i < kSteps; ++i)
        by = vectorAt(n, flow.along,
                      {at[0] + half * by[0], at[1] + half * by[1], at[2] + half * by[2]});
      return by;
    };
    const auto a = before ? onTheWay(*before, -0.5F) : std::array<float, 3>{};
    const auto b = after ? onTheWay(*after, 0.5F) : std::array<float, 3>{};
    for (int i = 0; i < 3; ++i) frame.along[i][voxel] = ofEarly * a[i] + ofLate * b[i];
  });
  return frame;
}

}  // namespace volute
