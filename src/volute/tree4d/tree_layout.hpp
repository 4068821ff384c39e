// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/tree4d/quantised_subtree.hpp"
#include "volute/tree4d/tree_data.hpp"

namespace volute {

/// Fills the arrays of `data` from the levels of a whole tree, [0] the finest. `data.step` and
/// `data.channels` are given.
void layOut(std::span<const SubtreeLevel> levels, TreeData& data);

/// The levels that layOut was given.
std::vector<SubtreeLevel> levelsOf(const TreeData& data);

/// Fills `data.entries` (their counts given) by a walk from the root.
void enterBlocks(TreeData& data);

}  // namespace volute
