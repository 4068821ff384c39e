// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

namespace volute {

/// Gives HDF5 the filters that it would load where it meets chunks that they packed: those of its
/// folders of plug-ins (the environment's HDF5_PLUGIN_PATH, else the system's), and Volute's own,
/// beside this library. A confined process could not load them then.
void loadHdf5Filters();

}  // namespace volute
