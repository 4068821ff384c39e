// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "volute/io/lattice.hpp"

// How what a LatticeReader finds crosses from the process that reads a file. Nothing that comes
// over is trusted: decoding checks all that is made use of, and ends each name.

namespace volute::detail {

std::string encodeCache(const LatticeCache& cache);
[[nodiscard]] Result<LatticeCache> decodeCache(std::string_view message, const std::string& file);

/// A frame whose channels are 1 or 3, whose voxels have a size and whose box lies within 2^40.
[[nodiscard]] Result<LatticeFrame> decodeFrame(std::string_view message, const std::string& file);

/// Writes facts of grids, as many as one message holds.
std::string encodeGridFacts(const std::vector<GridFacts>& grids);
[[nodiscard]] Result<std::vector<GridFacts>> decodeGridFacts(std::string_view message);

std::string encodeFiles(const std::vector<TimedFile>& files);
[[nodiscard]] Result<std::vector<TimedFile>> decodeFiles(std::string_view message,
                                                         const std::string& collection);

}  // namespace volute::detail
