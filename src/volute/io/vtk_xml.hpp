// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>

#include <filesystem>
#include <string>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// VTK's XML readers pass over what they do not know, and take the first number of several: a
/// letter that is wrong moves a grid or leaves out half of a mesh. The elements of a file, of which
/// is checked that it ends in </VTKFile>, that what is needed is there, that numbers are as many
/// numbers as are expected, and that no name is nearly one that is missing. Names that are like
/// none pass: other programs add their own. For the VTK plug-in alone, in the child process.
[[nodiscard]] Result<vtkSmartPointer<vtkXMLDataElement>> readVtkXml(
    const std::filesystem::path& path);

/// An array that pieces with cells (or points) lack: VTK leaves its values there as it finds them
/// in memory.
struct PartialArray {
  std::string name{};
  bool ofCells = false;
  int pieces = 0;  ///< that have it
  int all = 0;     ///< that should
};

/// Those of an image or a mesh, whichever piece has them.
[[nodiscard]] std::vector<PartialArray> partialArrays(vtkXMLDataElement& root);

}  // namespace volute
