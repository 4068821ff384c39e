// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute {

struct SourceOptions;

/// What a file of named arrays says of one of them, with axes (t, z, y, x, c). Trivially copyable:
/// it crosses from the process that reads the file to ours as bytes.
struct ArrayFacts {
  static constexpr std::size_t kMaxText = 255;

  char name[kMaxText + 1] = {};    ///< ends in 0, as all texts
  char unit[kMaxText + 1] = {};    ///< of the values; empty: the file says none
  char others[kMaxText + 1] = {};  ///< arrays that could have been meant, as people read them
  char order[kMaxText + 1] = {};   ///< which dimension was taken for which axis by its place alone
  char unitless[kMaxText + 1] = {};  ///< coordinates without units, and what they are taken in
  char thin[kMaxText + 1] = {};      ///< sizes of single voxels that nothing states; empty: none
  char doubt[kMaxText + 1] = {};     ///< what coordinates say against even voxels; empty: nothing
  char range[kMaxText + 1] = {};     ///< which numbers mean that nothing is there; empty: none
  char absent[kMaxText + 1] = {};    ///< what the file lacks of the array; empty: nothing
  std::array<std::int32_t, 5> size{1, 1, 1, 1, 1};  ///< t, z, y, x, c
  bool timed = false;                               ///< times() has them
  bool placed = false;                              ///< there are bounds
  std::array<double, 6> bounds{};                   ///< [m] least x, y, z, most x, y, z
  bool rounded = false;  ///< a float may be another number than one of the file
};

/// What was met while numbers were read. Trivially copyable, too.
struct ArrayReadFacts {
  double rounding = 0;     ///< the largest difference between a number of the file and its float
  bool hasMarker = false;  ///< there were numbers that mean that nothing is there: NaN stands there
  double marker = 0;       ///< the last of them, as stored
};

/// What a library that knows such files does with one. Used inside a child process (ReaderProcess),
/// because damaged files may crash such libraries.
class ArrayReader {
 public:
  virtual ~ArrayReader() = default;

  /// The array named `name`, or the only one with three to five axes, else the one of the name
  /// `usual`; it is the one that is read from now on.
  /// @param place  whether coordinates are to give bounds, and are errors where they do not; else
  ///               they give the directions of the axes
  [[nodiscard]] virtual Result<ArrayFacts> describe(const std::filesystem::path& file,
                                                    const std::string& name,
                                                    const std::string& usual, bool place) = 0;

  /// [s] of all frames, as the coordinate says.
  [[nodiscard]] virtual Result<std::vector<double>> times() = 0;

  /// Fills `values`, shape (z, y, x, c), with some layers of a frame, as differences from `offset`.
  /// What was never written is NaN.
  [[nodiscard]] virtual Status read(int frame, int firstLayer, int layers, std::span<float> values,
                                    double offset, ArrayReadFacts& facts) = 0;
};

/// Writes a sequence as an array with the axes time, z, y, x and c, and coordinates for them, into
/// a netCDF-4 file, which is one of HDF5.
class ArrayWriter {
 public:
  virtual ~ArrayWriter() = default;

  /// @param target  for messages
  /// @param offset  values are differences from it, and numbers are written as float64
  [[nodiscard]] virtual Status begin(const std::filesystem::path& file,
                                     const std::filesystem::path& target, const VolumeInfo& info,
                                     double offset) = 0;

  /// The next frame, shape (z, y, x, c).
  [[nodiscard]] virtual Status write(std::span<const float> values) = 0;

  [[nodiscard]] virtual Status finish() = 0;
};

/// What a plug-in for files of named arrays offers.
struct ArrayPlugin {
  std::unique_ptr<ArrayReader> (*makeReader)();
  std::unique_ptr<ArrayWriter> (*makeWriter)();
};

/// A file of named arrays, and which of them is meant.
struct NamedArray {
  std::filesystem::path file;
  std::string name;  ///< empty: not said
};

/// Of "run.nc", "run.h5:/group/soot", "run.zarr:soot" and such; nothing where the file is of
/// another kind, by its name's end.
std::optional<NamedArray> namedArray(const std::filesystem::path& input);

/// An array of a netCDF, HDF5 or Zarr file as a sequence, the one of options.grid if that says one.
/// Its dimensions are axes by their names (t or time; z, height or altitude; y; x; c, channel, rgb
/// or component), all others by their places, z, y, x, of which a remark tells. Coordinates of
/// their names give bounds and times.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> openArrayFile(const NamedArray& input,
                                                                 const SourceOptions& options);

/// Whether createArraySink() writes files of this name: .nc, .nc4, .h5 and .hdf5.
bool isArrayOutput(const std::filesystem::path& output);

/// A sink for one file with all frames, which openArrayFile() reads as they were. The array is
/// called info.name.
[[nodiscard]] Result<std::unique_ptr<FrameSink>> createArraySink(
    const std::filesystem::path& output, const VolumeInfo& info, double offset);

}  // namespace volute
