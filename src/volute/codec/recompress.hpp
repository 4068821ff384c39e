// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>

#include "volute/codec/compress.hpp"
#include "volute/codec/volute_reader.hpp"

namespace volute {

/// Sets CompressOptions::sourceRms and sourceMaxError: how far a .volute's values are from what it
/// was made of.
void addOwnError(const VoluteReader& reader, CompressOptions& options);

/// Compresses the grid that `reader` reads into a file of its own, with all that its file says of
/// it: topology, background, place, class, metadata. The report states errors relative to its
/// original, as the new file does.
/// @param info  what it says otherwise: names, numbers and times of as many frames, bounds
[[nodiscard]] Result<CompressReport> recompress(const std::shared_ptr<const VoluteReader>& reader,
                                                const VolumeInfo& info,
                                                const std::filesystem::path& target,
                                                CompressOptions options, Progress& progress);

}  // namespace volute
