// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "volute/tree4d/tree_data.hpp"

// Reads of the compact tree, compiled for several instruction sets; the best one is picked when the
// program runs. All give the same bits, and the same as a walk with tree_node.hpp in float.

namespace volute {

float readValue(const TreeData& data, const std::array<int, 4>& voxel, int channel);

void readValues(const TreeData& data, std::span<const std::array<int, 4>> voxels,
                std::span<float> values);

/// Time `t` of the block with entry `entry`: shape (channel, z, y, x) of 2^entryLevels cells a
/// side, not yet clamped.
/// Returns how many nodes were read.
int readBlockSlice(const TreeData& data, const TreeData::Entry& entry, int t, float* values);

/// What copyValues copies: a box of values of one channel; strides in floats.
struct BoxCopy {
  const float* from;
  std::ptrdiff_t fromRow, fromPlane;
  float* to;
  std::ptrdiff_t toStep, toRow, toPlane;
  int depth, height, width;
};

/// Copies and clamps to the data's minimum and maximum.
void copyValues(const TreeData& data, const BoxCopy& copy);

}  // namespace volute
