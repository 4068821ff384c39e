// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "volute/fds/fortran_file.hpp"
#include "volute/fds/frame_times.hpp"
#include "volute/fds/smv_index.hpp"

// The binary files of a case: frames of one quantity on a box of nodes of one mesh. All check every
// record marker when they are opened, keep the times and places of the frames, and read one frame
// at a time. A file that ends within a frame loses that frame, with a remark.

namespace volute {

/// Frames of numbers.
class FdsFrameFile {
 public:
  virtual ~FdsFrameFile() = default;

  const FdsFrameIndex& frames() const { return frames_; }

  /// Values of one frame.
  std::size_t values() const { return values_; }

  /// Fills `out`, values() long, x fastest, then y, then z.
  [[nodiscard]] virtual Status readFrame(std::size_t frame, std::span<float> out) const = 0;

 protected:
  explicit FdsFrameFile(std::size_t values) : values_(values) {}

  FdsFrameFile(FdsFrameFile&&) = default;
  FdsFrameFile& operator=(FdsFrameFile&&) = default;

  std::size_t values_;
  FdsFrameIndex frames_;
};

/// .sf: float values on the nodes `nodes` (or of the cells with those indices).
class FdsSliceFile final : public FdsFrameFile {
 public:
  /// The header must name what the index names, and its indices must be those of the index where it
  /// has them, and lie in the mesh.
  [[nodiscard]] static Result<FdsSliceFile> open(const FdsSliceEntry& entry, const FdsMesh& mesh);

  const FdsNodeBox& nodes() const { return nodes_; }

  [[nodiscard]] Status readFrame(std::size_t frame, std::span<float> out) const override;

 private:
  FdsSliceFile(FortranFile file, FdsNodeBox nodes, std::size_t values)
      : FdsFrameFile(values), file_(std::move(file)), nodes_(nodes) {}

  Status findFrames(std::uint64_t offset);

  FortranFile file_;
  FdsNodeBox nodes_;
};

/// .s3d and .s3dd: bytes 0..254 at all nodes of a mesh, run-length coded. readFrame gives them as
/// floats; what they mean is up to the case (FdsSmokeScale).
class FdsSmokeFile final : public FdsFrameFile {
 public:
  [[nodiscard]] static Result<FdsSmokeFile> open(const std::filesystem::path& path,
                                                 const FdsMesh& mesh);

  [[nodiscard]] Status readFrame(std::size_t frame, std::span<float> out) const override;

  [[nodiscard]] Status readBytes(std::size_t frame, std::span<std::uint8_t> out) const;

 private:
  FdsSmokeFile(FortranFile file, std::size_t values)
      : FdsFrameFile(values), file_(std::move(file)) {}

  Status findFrames(std::uint64_t offset);

  FortranFile file_;
};

/// .s16: 16-bit values at all nodes of a mesh, in the physical unit.
class FdsSmoke16File final : public FdsFrameFile {
 public:
  [[nodiscard]] static Result<FdsSmoke16File> open(const std::filesystem::path& path,
                                                   const FdsMesh& mesh);

  /// Physical values.
  [[nodiscard]] Status readFrame(std::size_t frame, std::span<float> out) const override;

  /// The size of one step of a frame's values.
  [[nodiscard]] Result<double> step(std::size_t frame) const;

 private:
  struct FrameHead {
    std::int32_t values = 0;
    std::int32_t stored = 0;
    float least = 0;
    float most = 0;
  };

  FdsSmoke16File(FortranFile file, std::size_t values)
      : FdsFrameFile(values), file_(std::move(file)) {}

  Status findFrames(std::uint64_t offset);
  Result<FrameHead> readHead(std::uint64_t& offset, const std::string& what) const;

  FortranFile file_;
};

/// .q: one variable of PLOT3D files, one file for each time.
class FdsPlotFiles final : public FdsFrameFile {
 public:
  /// `entries` are of one mesh.
  /// @param variables  of each, 0..4
  [[nodiscard]] static Result<FdsPlotFiles> open(std::span<const FdsPlotEntry> entries,
                                                 std::span<const std::size_t> variables,
                                                 const FdsMesh& mesh);

  [[nodiscard]] Status readFrame(std::size_t frame, std::span<float> out) const override;

 private:
  explicit FdsPlotFiles(const FdsMesh& mesh) : FdsFrameFile(mesh.nodeCount()) {}

  // Offsets of frames_ are places in it.
  std::vector<std::pair<std::filesystem::path, std::size_t>> files_;  // and their variables
  std::array<std::int32_t, 3> nodes_{};
};

/// Run-length code of .s3d: 255, value, count is a run; any other byte is itself. Fails unless
/// exactly out.size() values 0..254 come out of all of `code`; the error is the place in `code`.
[[nodiscard]] tl::expected<void, std::size_t> decodeRuns(std::span<const std::uint8_t> code,
                                                         std::span<std::uint8_t> out);

/// The numbers of a .s3d.sz file, a row for each frame. A hint at best: what cannot be read is left
/// out.
struct FdsSizeRow {
  double time = 0;
  std::vector<double> columns;  ///< uncompressed size, compressed size, and what else there is
};

std::vector<FdsSizeRow> readSizeFile(const std::filesystem::path& path);

}  // namespace volute
