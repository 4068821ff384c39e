// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "volute/base/file_name.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/grid/grid_matrix.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/grid/vector_kind.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/reading.hpp"
#include "volute/io/volume_source.hpp"
#include "volute/volume_files/finite_source.hpp"

namespace volute {

/// How to read a volume that a command line names.
struct InputOptions {
  std::string grid;            ///< of a file with several; empty: the only one, else `usualGrid`
  std::optional<Box3> bounds;  ///< stated, or cropped and padded to, on the voxel grid
  bool partial = false;        ///< a damaged .volute is read as far as it is intact
  bool verify = true;          ///< with `partial`: looks through it first, and remarks on damage
  std::string usualGrid = "density";  ///< which of several, when none is named
  bool byLayers = false;              ///< frames may be larger than memory; see SourceOptions
  std::optional<RawLayout> raw{};     ///< of files without a header
  StatedInfo stated{};
  std::optional<FrustumSampling> frusta{};  ///< SourceOptions::frusta
  NotFinite notFinite = NotFinite::kKeep;
  Offsets offsets = Offsets::kNone;  ///< what is read so: offsetOf() the source
};

/// An open volume of any format.
struct VolumeInput {
  std::unique_ptr<FrameSource> source;
  std::shared_ptr<const VoluteReader> reader;  ///< null unless it is a .volute file
  /// From the space of the source's bounds to the world, in each frame; empty: that is the world.
  std::vector<GridMatrix> places{};
  VectorKind vectors{};           ///< of three channels
  std::vector<double> amounts{};  ///< how much is in each frame, in any unit; empty: not known
  std::string writer{};           ///< the program whose up axis it has; empty: it says so, or not
  std::string gridClass{};        ///< "fog volume"; empty: unknown
  std::shared_ptr<ReplacedValues> replaced{};  ///< by InputOptions::notFinite, of what was read
};

/// An error unless the volume lies along the axes, in one place: of who makes something of its
/// bounds alone. `what` is that: "is not projected".
[[nodiscard]] Status alongAxesOnly(const VolumeInput& input, const std::string& path,
                                   std::string_view what);

[[nodiscard]] Result<VolumeInput> openVolume(const std::string& path, const InputOptions& options,
                                             Reading& reading);

/// A .volute file alone, for one of its grids: VoluteReader::Options, `grid` and `differences`.
/// With `partial` and `verify` says in a remark what is missing of it.
[[nodiscard]] Result<std::shared_ptr<const VoluteReader>> openVolute(const std::string& path,
                                                                     bool partial, Reading& reading,
                                                                     bool verify = true,
                                                                     const std::string& grid = {},
                                                                     Offsets differences = {});

/// "complete", or what is wrong and how much is there.
std::string integrityText(const Integrity& integrity, const VoluteReader& reader);

/// By the name's end: .volute.
bool isVolutePath(const std::string& path);

/// By the name's end: .npy or .npz, which state no bounds.
bool isNumpyPath(const std::string& path);

/// How far the values of a .volute are from what it was made of, absolute, in all frames together.
struct OwnError {
  double rms = 0, maximum = 0;
};

OwnError ownErrorOf(const VoluteReader& reader);

/// Says that an error that is stated for what is made of a .volute holds the .volute's own.
void remarkOnOwnError(const std::string& path, const VoluteReader& reader, Reading& reading);

/// Whether its bounds are those that are taken where nobody states any.
bool hasUsualBounds(const VolumeInfo& info);

/// Remarks on frames that are asked for and not there.
void remarkOnRange(const std::string& path, const VolumeInfo& info, const FrameRange& range,
                   Reading& reading);

/// The same frames; tells once what one of them lost when it was read.
std::unique_ptr<FrameSource> tellingLosses(std::unique_ptr<FrameSource> source, std::string path,
                                           Progress& log, Hints hints = {});

/// Remarks on files beside the sequence that look like a part of it and are not.
void remarkOnFiles(const std::string& path, Reading& reading);

/// Size on disk of a file, or of the files of a pattern, a folder or a collection; nothing for what
/// cannot be read, and for a case (.smv), of whose files a volume is a part.
std::optional<std::uint64_t> bytesOnDisk(const std::string& path);

}  // namespace volute
