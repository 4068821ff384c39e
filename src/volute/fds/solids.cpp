// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/solids.hpp"

#include <algorithm>

#include "volute/fds/fds_grid.hpp"

namespace volute {
namespace {

using Cell = std::array<int, 3>;

std::size_t placeOf(const FdsMesh& mesh, const Cell& cell) {
  return (static_cast<std::size_t>(cell[2]) * mesh.cells(1) + cell[1]) * mesh.cells(0) + cell[0];
}

/// What cells across the faces of a mesh hold.
class Beyond {
 public:
  Beyond(const SmvIndex& index, int mesh, double time,
         std::span<const std::vector<std::uint8_t>> solid)
      : index_(index), mesh_(index.meshes[static_cast<std::size_t>(mesh)]), solid_(solid) {
    const Box3 own = mesh_.bounds();
    for (std::size_t i = 0; i < index.meshes.size(); ++i) {
      const Box3 other = index.meshes[i].bounds();
      const bool apart = (other.min.array() > own.max.array() + kMeshSeparation).any() ||
                         (other.max.array() < own.min.array() - kMeshSeparation).any();
      if (static_cast<int>(i) != mesh && !apart)
        neighbours_.push_back(i);
    }
    for (const FdsVent& vent : mesh_.vents) {
      if (vent.open && isShown(vent.events, time))
        openings_.push_back(vent.nodes);
    }
  }

  /// Adds to what the nodes of a face have. `cell` is one step outside on `axis`, at the minimum or
  /// the maximum; `inside` says whether the mesh's own cell there is solid.
  std::uint8_t NodeCells::* kindOf(const Cell& cell, int axis, bool insideIsSolid) const {
    const Vec3 centre = centreOf(cell, axis);
    for (const std::size_t i : neighbours_) {
      const FdsMesh& other = index_.meshes[i];
      if (solid_[i].empty() || !other.bounds().contains(centre))
        continue;
      Cell there;
      for (int a = 0; a < 3; ++a) there[a] = cellBetween(other.planes[a], centre[a]);
      return solid_[i][placeOf(other, there)] == 0 ? &NodeCells::gas : &NodeCells::held;
    }
    const int node = cell[axis] < 0 ? 0 : mesh_.cells(axis);
    for (const FdsNodeBox& opening : openings_) {
      bool within = opening.begin[axis] == node && opening.end[axis] == node;
      for (int a = 0; a < 3; ++a) {
        if (a != axis)
          within = within && cell[a] >= opening.begin[a] && cell[a] < opening.end[a];
      }
      if (within && !insideIsSolid)
        return &NodeCells::open;
    }
    return &NodeCells::held;
  }

 private:
  Vec3 centreOf(const Cell& cell, int axis) const {
    Vec3 centre;
    for (int a = 0; a < 3; ++a) {
      const auto& planes = mesh_.planes[a];
      const int last = static_cast<int>(planes.size()) - 1;
      if (a != axis) {
        centre[a] = 0.5 * (planes[cell[a]] + planes[cell[a] + 1]);
      } else if (cell[a] < 0) {
        centre[a] = planes[0] - 0.5 * (planes[1] - planes[0]);
      } else {
        centre[a] = planes[last] + 0.5 * (planes[last] - planes[last - 1]);
      }
    }
    return centre;
  }

  const SmvIndex& index_;
  const FdsMesh& mesh_;
  std::span<const std::vector<std::uint8_t>> solid_;
  std::vector<std::size_t> neighbours_;
  std::vector<FdsNodeBox> openings_;
};

}  // namespace

std::vector<std::uint8_t> solidCells(const FdsMesh& mesh, double time) {
  std::vector<std::uint8_t> solid(mesh.cellCount(), 0);
  for (const FdsObstruction& one : mesh.obstructions) {
    if (!one.shownAt(time))
      continue;
    for (int z = one.nodes.begin[2]; z < one.nodes.end[2]; ++z) {
      for (int y = one.nodes.begin[1]; y < one.nodes.end[1]; ++y) {
        const auto row = solid.begin() + static_cast<std::ptrdiff_t>(placeOf(mesh, {0, y, z}));
        std::fill(row + one.nodes.begin[0], row + one.nodes.end[0], std::uint8_t{1});
      }
    }
  }
  return solid;
}

std::vector<NodeCells> cellsRoundNodes(const SmvIndex& index, int mesh, double time,
                                       std::span<const std::vector<std::uint8_t>> solid) {
  const FdsMesh& own = index.meshes[static_cast<std::size_t>(mesh)];
  const auto& ownSolid = solid[static_cast<std::size_t>(mesh)];
  const Beyond beyond(index, mesh, time, solid);
  const Cell count{own.cells(0), own.cells(1), own.cells(2)};
  const std::size_t strideY = static_cast<std::size_t>(count[0]) + 1;
  const std::size_t strideZ = strideY * (static_cast<std::size_t>(count[1]) + 1);
  std::vector<NodeCells> nodes(own.nodeCount());
  const auto add = [&](const Cell& cell, std::uint8_t NodeCells::* kind) {
    for (int corner = 0; corner < 8; ++corner) {
      const Cell node{cell[0] + (corner & 1), cell[1] + ((corner >> 1) & 1),
                      cell[2] + (corner >> 2)};
      bool inside = true;
      for (int a = 0; a < 3; ++a) inside = inside && node[a] >= 0 && node[a] <= count[a];
      if (inside) {
        ++(nodes[static_cast<std::size_t>(node[2]) * strideZ +
                 static_cast<std::size_t>(node[1]) * strideY + static_cast<std::size_t>(node[0])].*
           kind);
      }
    }
  };
  for (int z = -1; z <= count[2]; ++z) {
    for (int y = -1; y <= count[1]; ++y) {
      for (int x = -1; x <= count[0]; ++x) {
        const Cell cell{x, y, z};
        int outside = 0;
        int axis = 0;
        Cell within = cell;
        for (int a = 0; a < 3; ++a) {
          within[a] = std::clamp(cell[a], 0, count[a] - 1);
          if (within[a] != cell[a])
            ++outside, axis = a;
        }
        if (outside > 1)
          continue;
        const bool isSolid = ownSolid[placeOf(own, within)] != 0;
        if (outside == 1) {
          add(cell, beyond.kindOf(cell, axis, isSolid));
        } else {
          add(cell, isSolid ? &NodeCells::held : &NodeCells::gas);
        }
      }
    }
  }
  return nodes;
}

}  // namespace volute
