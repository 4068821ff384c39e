// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_files.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <map>

#include "volute/base/parallel.hpp"
#include "volute/fds/frame_file.hpp"
#include "volute/fds/iso_file.hpp"
#include "volute/fds/particle_file.hpp"

namespace volute {
namespace {

using Look = std::function<Result<FdsFrameIndex>()>;

template <class File>
Result<FdsFrameIndex> framesOf(const Result<File>& file) {
  if (!file)
    return tl::unexpected<Error>(file.error());
  return file->frames();
}

void note(FdsFileCheck& check, const Result<FdsFrameIndex>& frames) {
  if (!frames) {
    const ErrorCode code = frames.error().code;
    check.reason = frames.error().message;
    check.state = code == ErrorCode::kNotFound    ? FdsFileState::kMissing
                  : code == ErrorCode::kTruncated ? FdsFileState::kEmpty
                                                  : FdsFileState::kDamaged;
    return;
  }
  check.times = frames->times;
  const auto cut = std::ranges::find(frames->remarks, RemarkCode::kDamaged, &Remark::code);
  if (cut != frames->remarks.end()) {
    check.state = check.times.empty() ? FdsFileState::kEmpty : FdsFileState::kTruncated;
    check.reason = cut->sentence;
  } else if (check.times.empty()) {
    check.state = FdsFileState::kEmpty;
    check.reason = fmt::format("{}: holds no whole frame", check.path.string());
  }
}

std::string spanOf(const std::vector<double>& times) {
  return times.empty() ? "none" : fmt::format("{}, the last at {:g} s", times.size(), times.back());
}

/// Which files have fewer frames than others of their kind.
void compare(std::vector<FdsFileCheck>& checks) {
  std::map<std::string, std::size_t> fullest;
  for (std::size_t i = 0; i < checks.size(); ++i) {
    const auto [best, first] = fullest.emplace(checks[i].kind, i);
    if (!first && checks[i].times.size() > checks[best->second].times.size())
      best->second = i;
  }
  for (FdsFileCheck& check : checks) {
    const FdsFileCheck& most = checks[fullest[check.kind]];
    if (check.state != FdsFileState::kWhole || check.times.size() >= most.times.size())
      continue;
    check.state = FdsFileState::kShort;
    check.reason = fmt::format("{}: has fewer frames ({}) than {} (mesh {}: {})",
                               check.path.string(), spanOf(check.times),
                               most.path.filename().string(), most.mesh + 1, spanOf(most.times));
  }
}

FdsFileCheck checkOther(const FdsOtherFile& other) {
  FdsFileCheck check{other.file, other.kind, std::max(other.mesh, 0), FdsFileState::kWhole, {}, {}};
  std::error_code code;
  const auto size = std::filesystem::file_size(other.file, code);
  if (code) {
    check.state = FdsFileState::kMissing;
    check.reason = fmt::format("{}: cannot be opened: {}", other.file.string(), code.message());
  } else if (size == 0) {
    check.state = FdsFileState::kEmpty;
    check.reason = fmt::format("{}: is empty", other.file.string());
  }
  return check;
}

bool fillsMesh(const FdsSliceEntry& slice) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!slice.nodes || slice.nodes->begin[axis] == slice.nodes->end[axis])
      return false;
  }
  return true;
}

}  // namespace

std::string_view nameOf(FdsFileState state) {
  static constexpr std::array<std::string_view, 6> kNames = {"whole",     "missing", "empty",
                                                             "truncated", "short",   "damaged"};
  return kNames[static_cast<std::size_t>(state)];
}

std::vector<FdsFileCheck> checkFiles(const SmvIndex& index) {
  std::vector<FdsFileCheck> checks;
  std::vector<Look> looks;
  const auto add = [&](const std::filesystem::path& path, std::string kind, int mesh, Look look) {
    FdsFileCheck& check = checks.emplace_back();
    check.path = path;
    check.kind = std::move(kind);
    check.mesh = mesh;
    looks.push_back(std::move(look));
  };
  const auto meshOf = [&](int mesh) -> const FdsMesh& {
    return index.meshes[static_cast<std::size_t>(mesh)];
  };
  for (const FdsSliceEntry& slice : index.slices) {
    add(slice.file,
        fmt::format("{} slices of {}{}", fillsMesh(slice) ? "3D" : "2D", slice.labels.quantity,
                    slice.cellCentred ? ", of cells" : ""),
        slice.mesh, [&] { return framesOf(FdsSliceFile::open(slice, meshOf(slice.mesh))); });
  }
  for (const FdsSmokeEntry& smoke : index.smoke) {
    add(smoke.file, "smoke3d of " + smoke.labels.quantity, smoke.mesh,
        [&] { return framesOf(FdsSmokeFile::open(smoke.file, meshOf(smoke.mesh))); });
  }
  for (const FdsPlotEntry& plot : index.plots) {
    add(plot.file, fmt::format("PLOT3D at {:g} s", plot.time), plot.mesh, [&] {
      return framesOf(
          FdsPlotFiles::open(std::span(&plot, 1), std::array{std::size_t{0}}, meshOf(plot.mesh)));
    });
  }
  for (const FdsIsoEntry& iso : index.isosurfaces) {
    add(iso.file, "isosurfaces of " + iso.labels.quantity, iso.mesh,
        [&] { return framesOf(FdsIsoFile::open(iso, meshOf(iso.mesh))); });
  }
  for (const FdsParticleEntry& particles : index.particles) {
    add(particles.file, "particles", particles.mesh,
        [&] { return framesOf(FdsParticleFile::open(particles)); });
  }
  parallelFor(checks.size(), [&](std::size_t i) { note(checks[i], looks[i]()); });
  compare(checks);
  for (const FdsOtherFile& other : index.others) checks.push_back(checkOther(other));
  return checks;
}

}  // namespace volute
