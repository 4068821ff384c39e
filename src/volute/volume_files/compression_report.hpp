// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "volute/codec/join.hpp"
#include "volute/report/report.hpp"
#include "volute/volume_files/grid_compression.hpp"

namespace volute {

/// What came of the compression of one volume: size, ratios, errors, time.
/// @param inputBytes  of the files on disk, where all of them are in the result
Report compressionReport(const std::string& target, const VolumeInfo& info,
                         const CompressReport& result, std::optional<std::uint64_t> inputBytes);

/// The same of several grids, and a row for each of them.
Report compressionReport(const std::string& target, const CompressedGrids& result, int frames,
                         std::optional<std::uint64_t> inputBytes);

/// The faint frames of grids that join() encoded again.
void addFaintFrames(Report& report, std::span<const JoinReport::Faint> faint,
                    const VolumeInfo& info);

/// A row for each grid that a file keeps as bytes.
void addKept(Report& report, std::span<const KeptResult> kept);

}  // namespace volute
