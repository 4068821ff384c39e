// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "volute/media/fds/fds_medium.hpp"
#include "volute/media/field_sliders.hpp"

namespace volute {

/// What of a case can be shown, as its files have it: sources, slices, isosurfaces, particles,
/// devices.
void addCaseParameters(ParameterGroup& group, const FdsMedium& fds);

/// How it looks: planes that cut the building, fire.
void addCaseLook(ParameterGroup& group, const FdsMedium& fds);

/// Sets one of those in the entry of a scene. False, with nothing changed, for all others.
bool setCaseParameter(nlohmann::ordered_json& entry, const FdsMedium& fds, const std::string& key,
                      const nlohmann::ordered_json& value);

}  // namespace volute
