// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <vector>

#include "volute/fds/fortran_file.hpp"
#include "volute/fds/frame_times.hpp"
#include "volute/fds/smv_index.hpp"

namespace volute {

/// Triangles of one mesh at one time.
struct FdsIsoFrame {
  std::vector<std::array<float, 3>> vertices;          ///< [m]
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< places in `vertices`
  std::vector<std::int32_t> levels;  ///< of each triangle: its place in FdsIsoFile::levels()
};

/// .iso: isosurfaces as FDS has cut them into triangles (&ISOF; smvv.f90, ISO_HEADER_OUT and
/// ISO_OUT). Record markers are checked when it is opened, vertices and triangles when they are
/// read.
class FdsIsoFile {
 public:
  /// kUnsupported for another version, or for triangles that stay (which FDS does not write).
  [[nodiscard]] static Result<FdsIsoFile> open(const FdsIsoEntry& entry, const FdsMesh& mesh);

  const FdsFrameIndex& frames() const { return frames_; }

  /// Values of the quantity on the surfaces, as FDS numbers them.
  std::span<const float> levels() const { return levels_; }

  /// What a frame takes in memory [bytes].
  std::uint64_t bytesOf(std::size_t frame) const { return 4 * words_[frame]; }

  /// kInvalidData for a vertex that is more than a cell outside of the mesh, or a triangle of
  /// vertices or a level that are not there.
  [[nodiscard]] Result<FdsIsoFrame> readFrame(std::size_t frame) const;

 private:
  explicit FdsIsoFile(FortranFile file) : file_(std::move(file)) {}

  Result<std::uint64_t> readHeader();
  Result<std::array<std::int32_t, 2>> readSizes(std::uint64_t& offset, std::size_t frame) const;

  FortranFile file_;
  Box3 room_;  // of vertices
  std::vector<float> levels_;
  FdsFrameIndex frames_;
  std::vector<std::uint64_t> words_;  // of each frame
};

}  // namespace volute
