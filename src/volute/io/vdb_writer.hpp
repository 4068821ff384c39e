// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>

#include "volute/io/lattice.hpp"

namespace volute {

/// Of .vdb and .nvdb files.
std::unique_ptr<LatticeWriter> makeVdbWriter(const LatticeWriterOptions& options);

}  // namespace volute
