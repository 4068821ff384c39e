// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "volute/base/program.hpp"
#include "volute/fds/fds_case.hpp"
#include "volute/fds/fds_writer.hpp"

// What tests of cases share.

namespace volute {

using fdswriter::Indices;
using fdswriter::Planes;

inline const Planes kFirst{
    {{0, 0.2, 0.4, 0.6, 0.8, 1.0}, {0, 0.2, 0.4, 0.6, 0.8}, {0, 0.3, 0.5, 0.6}}};
/// On the other side of x = 1: cells twice as fine on y, stretched on x.
inline const Planes kSecond{{{1.0, 1.1, 1.3, 1.6, 2.0},
                             {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8},
                             {0, 0.15, 0.3, 0.4, 0.5, 0.55, 0.6}}};

inline std::array<int, 3> cellsOf(const Planes& planes) {
  return {static_cast<int>(planes[0].size()) - 1, static_cast<int>(planes[1].size()) - 1,
          static_cast<int>(planes[2].size()) - 1};
}

inline Indices whole(const Planes& planes) {
  const auto cells = cellsOf(planes);
  return {0, cells[0], 0, cells[1], 0, cells[2]};
}

inline std::vector<std::string> sentences(std::span<const Remark> remarks) {
  std::vector<std::string> said;
  for (const Remark& remark : remarks) said.push_back(remark.sentence);
  return said;
}

inline double linear(double x, double y, double z) {
  return 1 + 0.5 * x + 0.25 * y + z;
}

inline double linearAt(const Vec3& p) {
  return linear(p.x(), p.y(), p.z());
}

inline Segment between(const Vec3& a, const Vec3& b) {
  return {a, (b - a).normalized(), 0, (b - a).norm()};
}

inline FdsDepth depthOf(const FdsField& field, const Segment& segment) {
  FdsDepth depth;
  field.depths({&segment, 1}, {&depth, 1});
  return depth;
}

inline FdsCase opened(const std::filesystem::path& path, const FdsOptions& options = {}) {
  auto result = FdsCase::open(path, options);
  if (!result)
    throw std::runtime_error(result.error().message);
  return std::move(*result);
}

/// A case of the mesh kFirst that a test makes.
struct MadeCase {
  explicit MadeCase(std::vector<Indices> obstructions = {}) {
    index.meshes.push_back({kFirst, std::move(obstructions), {}});
  }

  void add(const fdswriter::Slice& slice, const std::string& name,
           const std::vector<std::pair<float, std::vector<float>>>& frames,
           bool cellCentred = false) {
    fdswriter::sliceFile(slice, frames).save(folder / name);
    index.slice(1, slice, name, cellCentred);
  }

  FdsCase open(const FdsOptions& options = {}) const {
    index.save(folder / "made.smv");
    return opened(folder / "made.smv", options);
  }

  ScratchFolder folder;
  fdswriter::Index index;
};

inline FdsField fieldAt(FdsCase& opened, double time) {
  auto field = opened.field(time);
  if (!field)
    throw std::runtime_error(field.error().message);
  return std::move(*field);
}

}  // namespace volute
