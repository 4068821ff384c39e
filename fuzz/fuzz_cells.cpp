// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>
#include <cstring>
#include <numeric>

#include "fuzz/input_folder.hpp"
#include "volute/tetmesh/split_cells.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

// Cells as the process that reads a mesh hands them over: nothing in them may be trusted. An input
// is the counts of points and cells (a byte each), then shapes, offsets and the points (bytes, as
// eighths), and indices (bytes) up to its end. 255 stands for numbers that cannot be.
namespace {

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}

  std::uint8_t next() { return at_ == end_ ? 0 : *at_++; }

  bool atEnd() const { return at_ == end_; }

 private:
  const std::uint8_t* at_;
  const std::uint8_t* end_;
};

std::int64_t index(std::uint8_t byte) {
  return byte == 255 ? -1 : byte == 254 ? std::int64_t{1} << 40 : byte;
}

volute::CellSoup soupOf(Input in) {
  volute::CellSoup soup;
  const std::size_t points = in.next() % 64, cells = in.next() % 32;
  for (std::size_t i = 0; i < cells; ++i)
    soup.shapes.push_back(static_cast<volute::CellShape>(in.next() % 5));
  for (std::size_t i = 0; i <= cells; ++i) soup.offsets.push_back(index(in.next()));
  for (std::size_t i = 0; i < points; ++i) {
    volute::Vec3 point;
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint8_t byte = in.next();
      point[axis] = byte == 255 ? NAN : byte == 254 ? 1e300 : byte == 253 ? 1e-300 : byte / 8.0;
    }
    soup.vertices.push_back(point);
  }
  while (!in.atEnd()) soup.connectivity.push_back(index(in.next()));
  return soup;
}

}  // namespace

// Errors are fine; meshes whose tets have no volume, and values beyond those given, are not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const volute::CellSoup soup = soupOf({data, size});
  const auto split = volute::splitCells(soup, "cells");
  if (!split)
    return 0;
  std::vector<float> values(soup.vertices.size());
  std::iota(values.begin(), values.end(), 1.0f);
  for (const float value : split->added.follow(values))
    volute::fuzz::require(value >= 1 && value <= static_cast<float>(values.size()));
  const auto mesh = volute::TetMesh::build(split->vertices(soup), split->tets, "cells");
  if (!mesh)
    return 0;
  for (std::size_t i = 0; i < (*mesh)->tets().size(); ++i)
    volute::fuzz::require((*mesh)->volume(static_cast<std::int32_t>(i)) > 0);
  return 0;
}
