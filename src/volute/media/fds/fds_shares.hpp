// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/fds/smv_index.hpp"
#include "volute/media/fds/fds_look.hpp"

namespace volute {

/// kUnsupported for what ranks cannot draw that hold a share of a case's meshes each: iso-surfaces,
/// and fire where meshes of two shares overlap, since the fire and the smoke of a place must be
/// held together.
[[nodiscard]] Status checkShares(const FdsDescription& description, const SmvIndex& index,
                                 int shares, bool burns);

}  // namespace volute
