// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/remark.hpp"
#include "volute/base/result.hpp"

namespace volute {

/// Powers of kg, m, s, K, mol, A and cd.
using FoamDimensions = std::array<double, 7>;

/// Those that a field's file states at a time [s]; nothing where it is not found, or states none in
/// numbers.
[[nodiscard]] std::optional<FoamDimensions> foamDimensions(const std::filesystem::path& casePath,
                                                           const std::string& field, double time);

/// Refuses dimensions that are units' names, which VTK takes for damage; reads the heads of all
/// fields of all times.
[[nodiscard]] Status checkFoamDimensions(const std::filesystem::path& casePath);

/// Refuses a field at a time [s] whose referenceLevel is not 0: OpenFOAM adds it to the values, and
/// VTK does not.
[[nodiscard]] Status checkFoamReference(const std::filesystem::path& casePath,
                                        const std::string& field, double time);

/// Whether a file of this name, packed or not, is in the folder of a time [s].
[[nodiscard]] bool hasFoamField(const std::filesystem::path& casePath, const std::string& field,
                                double time);

/// The fields of cells and points whose files are in the folder of a time [s], in order of their
/// names.
[[nodiscard]] std::vector<std::string> foamFields(const std::filesystem::path& casePath,
                                                  double time);

/// Refuses a case whose mesh, or whose times but for the first, are in the folders of a parallel
/// run or in regions alone, and says how to put it together.
[[nodiscard]] Status checkFoamMesh(const std::filesystem::path& casePath);

/// A part of the boundary of a mesh.
struct FoamPatch {
  std::string name;
  std::string type;  ///< "wall", "patch", "cyclic"; empty: not stated

  /// Whether nothing goes through it: no pair of patches, part of a parallel run or symmetry is.
  bool isWall() const;
};

/// Those that the mesh of a time [s] states; empty: none can be read.
[[nodiscard]] std::vector<FoamPatch> foamPatches(const std::filesystem::path& casePath,
                                                 double time);

/// What a case has besides what is read of it: times of a parallel run, regions, clouds.
[[nodiscard]] std::vector<Remark> foamRemarks(const std::filesystem::path& casePath);

/// A sentence on constant/g where it is not along -z; empty: it is, or there is none.
[[nodiscard]] std::string foamGravity(const std::filesystem::path& casePath);

/// Refuses binary files in the byte order of another machine, which VTK takes for its own; looks at
/// the mesh, the first and the last time.
[[nodiscard]] Status checkFoamByteOrder(const std::filesystem::path& casePath);

/// Refuses pipes, sockets and devices where files of the case are, before VTK waits for them: it
/// opens all files of a time to learn what they hold.
[[nodiscard]] Status checkFoamKinds(const std::filesystem::path& casePath);

}  // namespace volute
