// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/io/frame_pattern.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {

/// Files of values and nothing else, as `options.raw` says: numbered files with a frame each, or
/// one with all of them, (t, z, y, x, c) in C order. Each file must have as many bytes as that
/// takes; of a single one they give the number of frames. Reads little more than what it is asked
/// for.
/// @param options  bounds are stated, as of a .npy; kInvalidArgument where `raw` makes no sense
[[nodiscard]] Result<std::unique_ptr<FrameSource>> openRaw(const std::filesystem::path& path,
                                                           const SourceOptions& options);

[[nodiscard]] Result<std::unique_ptr<FrameSource>> openRawSequence(
    const std::vector<NumberedFile>& files, const SourceOptions& options);

/// The size and channels of "512,512,256" or "512,512,256,3".
[[nodiscard]] Result<RawLayout> parseRawSize(const std::string& text);

/// "uint8", "int8" .. "float64", in the order of RawLayout::Type.
std::span<const std::string_view> rawTypeNames();
std::optional<RawLayout::Type> rawTypeByName(std::string_view name);

}  // namespace volute
