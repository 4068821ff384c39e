// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/grid/grid_description.hpp"

namespace volute {

/// One grid in the table of a file's grids (docs/format.md, section 4.2).
struct GridRow {
  std::string name;
  bool empty = false;  ///< it has no INFO, no INDX and no values
  std::optional<GridDescription> description{};
  std::vector<std::uint64_t> tierBytes{};  ///< of its segments; none of an empty grid
  std::uint64_t pageBytes = 0;             ///< of its index, in codec 3
};

/// All grids of a file, and what the files of the cache say of themselves.
struct GridTable {
  std::vector<GridRow> rows;
  FrameMetadata fileMetadata;
  bool paged = false;  ///< of codec 3
};

/// The content of a GRDS chunk.
std::vector<std::byte> writeGridTable(const GridTable& table);

/// Takes any bytes: what it allocates is in proportion to them. The lists of frames have the length
/// that the bytes state, which the caller compares with the frames that there are. An error is what
/// is wrong, and wants a subject.
[[nodiscard]] Result<GridTable> readGridTable(std::span<const std::byte> content, bool paged);

}  // namespace volute
