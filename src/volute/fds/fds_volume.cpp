// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_volume.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/parallel.hpp"

namespace volute {

Vec3 finestCell(const FdsGrid& grid) {
  Vec3 finest = Vec3::Constant(std::numeric_limits<double>::infinity());
  for (const FdsLattice& lattice : grid.lattices()) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto& planes = lattice.planes[axis];
      for (std::size_t i = 1; i < planes.size(); ++i)
        finest[axis] = std::min(finest[axis], planes[i] - planes[i - 1]);
    }
  }
  return finest;
}

Result<std::unique_ptr<FdsVolume>> FdsVolume::open(const std::filesystem::path& path,
                                                   Options options) {
  options.read.volume = options.read.source.empty();
  VOLUTE_ASSIGN(auto opened, FdsCase::open(path, options.read));
  std::unique_ptr<FdsVolume> volume(new FdsVolume(std::move(opened)));
  VOLUTE_TRY(volume->placeVoxels(options));
  return volume;
}

Status FdsVolume::placeVoxels(const Options& options) {
  constexpr double kSlack = 1e-3;  // of a voxel
  const std::string name = case_.index().path.string();
  Box3 bounds = case_.bounds();
  if (options.mesh) {
    Box3 part;
    for (const FdsLattice& lattice : case_.grid().lattices()) {
      if (lattice.mesh != *options.mesh)
        continue;
      part.extend(lattice.bounds());
    }
    if (part.empty()) {
      return fail(ErrorCode::kNotFound, "{}: the source '{}' has nothing of mesh {}", name,
                  case_.source().name, *options.mesh + 1);
    }
    bounds = part;
  }
  const Vec3 voxel = finestCell(case_.grid());
  Vec3 origin = bounds.min;
  std::array<double, 3> count;
  double total = 1;
  for (int axis = 0; axis < 3; ++axis) {
    double first = 0;
    double last = std::ceil(bounds.size()[axis] / voxel[axis] - kSlack);
    if (options.bounds) {
      first = std::max(
          0.0, std::floor((options.bounds->min[axis] - origin[axis]) / voxel[axis] + kSlack));
      last = std::min(last,
                      std::ceil((options.bounds->max[axis] - origin[axis]) / voxel[axis] - kSlack));
    }
    if (!(first < last)) {
      return fail(ErrorCode::kInvalidArgument, "{}: the bounds do not meet the case's meshes",
                  name);
    }
    origin[axis] += first * voxel[axis];
    count[axis] = last - first;
    total *= count[axis];
  }
  if (4 * total > static_cast<double>(options.read.maxMemory) || total > 2e9) {
    return fail(ErrorCode::kTooLarge,
                {Hint::set("bounds").so("takes a part"), Hint::raise("max_memory")},
                "{}: {} x {} x {} voxels of the finest cell size need {:.3g} GB, {:.3g} GB are "
                "allowed",
                name, count[0], count[1], count[2], 4e-9 * total,
                static_cast<double>(options.read.maxMemory) * 1e-9);
  }
  info_.name = "extinction";
  info_.unit = "1/m";
  info_.x = static_cast<int>(count[0]);
  info_.y = static_cast<int>(count[1]);
  info_.z = static_cast<int>(count[2]);
  info_.bounds = {origin, origin + voxel.cwiseProduct(Vec3(count[0], count[1], count[2]))};
  info_.times.assign(case_.times().begin(), case_.times().end());
  info_.frames = static_cast<int>(info_.times.size());
  for (int i = 0; i < info_.frames; ++i) info_.frameNumbers.push_back(i);
  return info_.validate(name);
}

Status FdsVolume::readFrame(int index, std::span<float> values) {
  VOLUTE_ASSIGN(const FdsField field, case_.field(info_.times[static_cast<std::size_t>(index)]));
  const Vec3 voxel = info_.voxelSize();
  const auto rows = static_cast<std::size_t>(info_.z) * info_.y;
  parallelRanges(rows, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const auto y = static_cast<double>(row % static_cast<std::size_t>(info_.y));
      const std::size_t layer = row / static_cast<std::size_t>(info_.y);
      const auto z = static_cast<double>(layer);
      for (int x = 0; x < info_.x; ++x) {
        const Vec3 centre = info_.bounds.min + voxel.cwiseProduct(Vec3(x + 0.5, y + 0.5, z + 0.5));
        values[row * info_.x + static_cast<std::size_t>(x)] =
            static_cast<float>(field.extinction(centre));
      }
    }
  });
  return {};
}

}  // namespace volute
