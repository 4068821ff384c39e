// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "volute/io/mesh_source.hpp"
#include "volute/media/field_probe.hpp"

namespace volute {

/// All scalar fields of a mesh's files, as they are stored.
/// @param shown  the field that smoke is made of, in `unit`
/// @param caseTime  from the scene's time to the case's [s]
std::unique_ptr<FieldProbe> meshProbe(MeshSource source, std::string shown, std::string unit,
                                      std::function<double(double)> caseTime);

}  // namespace volute
