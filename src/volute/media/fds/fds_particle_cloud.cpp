// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_particle_cloud.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "volute/image/colormap.hpp"
#include "volute/image/srgb.hpp"

namespace volute {
namespace {

constexpr std::uint64_t kMaxMarks = 100000;
constexpr double kMarkShare = 0.0012;  // of the case's diagonal
constexpr std::uint32_t kCloudColours = 256;

void addMark(TriangleMesh& to, const Vec3& at, double size, std::uint32_t material) {
  for (int side = 0; side < 8; ++side) {
    Vec3 corners[3];
    for (int axis = 0; axis < 3; ++axis) {
      corners[axis] = at;
      corners[axis][axis] += (side >> axis & 1) != 0 ? size : -size;
    }
    to.triangles.push_back({{corners[0], corners[1], corners[2]}, material});
  }
}

}  // namespace

Result<FdsParticleCloud> FdsParticleCloud::open(const SmvIndex& index, const std::string& which,
                                                Reading& reading) {
  FdsParticleCloud cloud;
  for (const FdsParticleClass& one : index.particleClasses) {
    cloud.colours_.emplace_back(srgbDecode(one.colour[0]), srgbDecode(one.colour[1]),
                                srgbDecode(one.colour[2]));
  }
  Box3 bounds;
  for (const FdsMesh& mesh : index.meshes) bounds.extend(mesh.bounds());
  cloud.size_ = kMarkShare * bounds.size().norm();
  std::set<std::string> classes, quantities, shown;
  const auto isClass = [&](const FdsParticleClass& one) { return one.name == which; };
  const bool named = std::ranges::any_of(index.particleClasses, isClass);
  for (const FdsParticleEntry& entry : index.particles) {
    VOLUTE_ASSIGN(auto file, FdsParticleFile::open(entry));
    for (const Remark& remark : file.frames().remarks) reading.progress.remark(remark);
    Part part;
    for (std::size_t i = 0; i < entry.classes.size(); ++i) {
      const std::string& name =
          index.particleClasses[static_cast<std::size_t>(entry.classes[i])].name;
      classes.insert(name);
      const auto& stored = file.quantitiesOf(i);
      for (const FdsLabels& one : stored) quantities.insert(one.quantity);
      const auto found = std::ranges::find(stored, which, &FdsLabels::quantity);
      const bool coloured = which != "all" && !named && found != stored.end();
      if (which != "all" && which != name && !coloured)
        continue;
      if (coloured) {
        cloud.quantity_ = which;
        cloud.unit_ = found->unit;
      }
      shown.insert(name);
      part.classes.push_back(entry.classes[i]);
      part.inFile.push_back(static_cast<int>(i));
      part.quantity.push_back(static_cast<int>(found - stored.begin()));
    }
    if (part.classes.empty() || file.frames().times.empty())
      continue;
    part.file = std::make_shared<const FdsParticleFile>(std::move(file));
    cloud.parts_.push_back(std::move(part));
  }
  if (cloud.parts_.empty()) {
    return fail(
        ErrorCode::kNotFound, "{}: no particles of '{}'; the case has {}{}{}", index.path.string(),
        which,
        classes.empty() ? "none" : fmt::format("all, or those of {}", fmt::join(classes, ", ")),
        quantities.empty() ? "" : ", coloured by ", fmt::join(quantities, ", "));
  }
  cloud.names_.assign(shown.begin(), shown.end());
  if (!cloud.quantity_.empty())
    VOLUTE_TRY(cloud.findRange(reading));
  return cloud;
}

Status FdsParticleCloud::findRange(Reading& reading) {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const Part& part : parts_) {
    for (std::size_t frame = 0; frame < part.file->frames().times.size(); ++frame) {
      if (reading.progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped: reading particles");
      VOLUTE_ASSIGN(const auto all, part.file->readFrame(frame));
      for (std::size_t i = 0; i < part.inFile.size(); ++i) {
        const FdsParticles& particles = all[static_cast<std::size_t>(part.inFile[i])];
        if (particles.places.empty())
          continue;
        for (const float value : particles.values[static_cast<std::size_t>(part.quantity[i])]) {
          if (!std::isfinite(value))
            continue;
          least = std::min<double>(least, value);
          most = std::max<double>(most, value);
        }
      }
    }
  }
  range_ = least < most           ? std::array{least, most}
           : std::isfinite(least) ? std::array{least, least + 1}
                                  : std::array{0.0, 1.0};
  return {};
}

std::uint64_t FdsParticleCloud::countAt(double time) const {
  std::uint64_t count = 0;
  for (const Part& part : parts_)
    count += part.file->count(nearestFrame(part.file->frames().times, time));
  return count;
}

std::uint64_t FdsParticleCloud::frameAt(double time) const {
  std::uint64_t key = 0;
  for (const Part& part : parts_)
    key = key * 1000003 + nearestFrame(part.file->frames().times, time);
  return key;
}

Status FdsParticleCloud::addTo(TriangleMesh& mesh, double time) const {
  const auto first = static_cast<std::uint32_t>(mesh.materials.size());
  if (quantity_.empty()) {
    for (const Rgb& colour : colours_) mesh.materials.push_back({Rgb::Zero(), colour});
  } else {
    for (std::uint32_t i = 0; i < kCloudColours; ++i) {
      mesh.materials.push_back(
          {Rgb::Zero(),
           displayColor(ColorMap::kViridis, (i + 0.5) / kCloudColours).unaryExpr(&srgbDecode)});
    }
  }
  const std::uint64_t every = countAt(time) / kMaxMarks + 1;
  std::uint64_t number = 0;
  for (const Part& part : parts_) {
    VOLUTE_ASSIGN(const auto all,
                  part.file->readFrame(nearestFrame(part.file->frames().times, time)));
    for (std::size_t i = 0; i < part.inFile.size(); ++i) {
      const FdsParticles& particles = all[static_cast<std::size_t>(part.inFile[i])];
      for (std::size_t p = 0; p < particles.places.size(); ++p) {
        if (number++ % every != 0)
          continue;
        auto material = first + static_cast<std::uint32_t>(part.classes[i]);
        if (!quantity_.empty()) {
          const double value = particles.values[static_cast<std::size_t>(part.quantity[i])][p];
          const double share = (value - range_[0]) / (range_[1] - range_[0]);
          if (!std::isfinite(share))
            continue;
          material = first + static_cast<std::uint32_t>(
                                 std::clamp(share * kCloudColours, 0.0, double{kCloudColours} - 1));
        }
        const auto& [x, y, z] = particles.places[p];
        addMark(mesh, Vec3(x, y, z), size_, material);
      }
    }
  }
  return {};
}

std::string FdsParticleCloud::words() const {
  std::set<double> times;
  std::uint64_t most = 0;
  for (const Part& part : parts_)
    times.insert(part.file->frames().times.begin(), part.file->frames().times.end());
  for (const double time : times) most = std::max(most, countAt(time));
  std::string text = fmt::format("particles: {}", fmt::join(names_, ", "));
  if (!quantity_.empty())
    text += fmt::format(", {} {:.4g} .. {:.4g} {}", quantity_, range_[0], range_[1], unit_);
  text += fmt::format(", the nearest of {} stored times", times.size());
  if (most > kMaxMarks)
    text += fmt::format(", {} of {} at most", kMaxMarks, most);
  return text;
}

}  // namespace volute
