// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <span>

#include "volute/capture/colmap_files.hpp"
#include "volute/capture/importers.hpp"
#include "volute/math/rotation.hpp"

namespace volute {
namespace {

/// Where a model keeps what: focal lengths, principal point, then the lens.
Status readIntrinsics(const ColmapCamera& camera, const std::string& where,
                      Calibration& calibration) {
  const auto& p = camera.parameters;
  const auto expects = [&](std::size_t count) -> Status {
    if (p.size() == count)
      return {};
    return fail(ErrorCode::kInvalidData,
                "{}: its camera of model {} has {} parameters; expected {}", where, camera.model,
                p.size(), count);
  };
  const bool oneFocal = camera.model.starts_with("SIMPLE_") || camera.model == "RADIAL";
  const std::size_t next = oneFocal ? 1 : 2;
  Distortion& lens = calibration.distortion;
  if (camera.model == "SIMPLE_PINHOLE") {
    VOLUTE_TRY(expects(3));
  } else if (camera.model == "PINHOLE") {
    VOLUTE_TRY(expects(4));
  } else if (camera.model == "SIMPLE_RADIAL") {
    VOLUTE_TRY(expects(4));
    lens.k1 = p[3];
  } else if (camera.model == "RADIAL") {
    VOLUTE_TRY(expects(5));
    lens.k1 = p[3], lens.k2 = p[4];
  } else if (camera.model == "OPENCV") {
    VOLUTE_TRY(expects(8));
    lens.k1 = p[4], lens.k2 = p[5], lens.p1 = p[6], lens.p2 = p[7];
  } else {
    return fail(ErrorCode::kUnsupported,
                "{}: the camera model {} is not read; expected SIMPLE_PINHOLE, PINHOLE, "
                "SIMPLE_RADIAL, RADIAL or OPENCV: `colmap image_undistorter` makes pictures and a "
                "model of PINHOLE cameras",
                where, camera.model);
  }
  calibration.width = camera.width, calibration.height = camera.height;
  calibration.K(0, 0) = p[0], calibration.K(1, 1) = p[next - 1];
  calibration.K(0, 2) = p[next], calibration.K(1, 2) = p[next + 1];
  return {};
}

}  // namespace

Result<CaptureDraft> readColmap(const std::filesystem::path& path, std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(const auto model, readColmapFiles(path, maxMemory));
  CaptureDraft draft;
  draft.kind = "COLMAP";
  for (const ColmapImage& image : model.images) {
    CameraDraft camera;
    camera.where = image.where;
    camera.pictureName = image.name;
    const auto found = model.cameras.find(image.camera);
    if (found == model.cameras.end()) {
      return fail(ErrorCode::kInvalidData, "{}: camera {} is not in the cameras file", image.where,
                  image.camera);
    }
    VOLUTE_TRY(readIntrinsics(found->second, image.where, camera.calibration));
    const auto& q = image.rotation;
    const Vec4 rotation(q[1], q[2], q[3], q[0]);
    if (!(std::abs(rotation.norm() - 1) < 0.01)) {
      return fail(ErrorCode::kInvalidData,
                  "{}: ({}, {}, {}, {}) is no rotation; expected a quaternion of length 1",
                  image.where, q[0], q[1], q[2], q[3]);
    }
    camera.calibration.R = turnOfQuaternion(rotation);
    camera.calibration.t = image.translation;
    draft.cameras.push_back(std::move(camera));
  }
  draft.remarks.emplace_back(
      RemarkCode::kNote,
      "lengths of the model are taken as metres; COLMAP itself finds them in a unit of its own");
  for (const std::string& doubt : model.remarks)
    draft.remarks.emplace_back(RemarkCode::kDoubtful, doubt);
  std::vector<std::uint32_t> idle;
  std::set<std::uint32_t> used;
  for (const ColmapImage& image : model.images) used.insert(image.camera);
  for (const auto& [id, camera] : model.cameras) {
    if (!used.contains(id))
      idle.push_back(id);
  }
  if (!idle.empty()) {
    constexpr std::size_t kShown = 8;
    const std::span shown = std::span(idle).first(std::min(kShown, idle.size()));
    draft.remarks.emplace_back(
        RemarkCode::kDoubtful,
        fmt::format("{} of the {} cameras have no image ({}{}): they were not registered, or the "
                    "images file is cut off",
                    idle.size(), model.cameras.size(), fmt::join(shown, ", "),
                    idle.size() > kShown ? ", ..." : ""));
  }
  return draft;
}

}  // namespace volute
