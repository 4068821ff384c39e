// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>
#include <cstring>

#include "fuzz/input_folder.hpp"
#include "volute/io/lattice_message.hpp"
#include "volute/io/lattice_source.hpp"

// What the process that reads .vdb and .vti files answers: a file may have taken it over. The
// first byte says which answer it is.
namespace {

using volute::fuzz::require;

/// Errors are fine; frames that cannot be laid on one lattice without overflow are not.
void lay(const std::vector<volute::LatticeFrame>& frames) {
  std::vector<volute::LatticeFile> files;
  for (const volute::LatticeFrame& frame : frames) {
    require(std::isfinite(frame.origin[0]) && frame.voxelSize[0] > 0);
    require(std::strlen(frame.grid) <= volute::LatticeFrame::kMaxName);
    files.push_back({static_cast<int>(files.size()), "a.vdb", std::nullopt});
  }
  if (frames.empty())
    return;
  if (const auto places = volute::latticePlaces(files, frames)) {
    for (int axis = 0; axis < 3; ++axis) (void)places->box.size(axis);
  }
}

void useCache(std::string_view text) {
  const auto cache = volute::detail::decodeCache(text, "a.vdb");
  if (!cache)
    return;
  std::vector<volute::LatticeFrame> frames;
  for (const volute::LatticeGrid& grid : cache->grids) {
    const int half = grid.traits.half;  // UBSan looks at it
    require(half <= 1);
    if (grid.traits.problem[0] == '\0')
      frames.push_back(grid.frame);
  }
  lay(frames);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0)
    return 0;
  const std::string_view text = volute::fuzz::textOf(data + 1, size - 1);
  switch (data[0]) {
    case 'c':
      useCache(text);
      break;
    case 'd':
      if (const auto frame = volute::detail::decodeFrame(text, "a.vdb"))
        lay({*frame, *frame});
      break;
    case 'g':
      if (const auto grids = volute::detail::decodeGridFacts(text)) {
        for (const volute::GridFacts& grid : *grids) {
          const int flags = grid.half + grid.readable;  // UBSan looks at both
          require(std::strlen(grid.name) <= volute::GridFacts::kMaxName && flags <= 2);
        }
      }
      break;
    default:
      if (const auto files = volute::detail::decodeFiles(text, "a.pvd")) {
        for (const volute::TimedFile& file : *files) require(!file.path.empty());
      }
  }
  return 0;
}
