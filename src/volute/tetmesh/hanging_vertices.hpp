// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "volute/math/vec.hpp"
#include "volute/tetmesh/cell_faces.hpp"

namespace volute {

/// Vertices in the middle of edges that some faces name and others leave out: a cell beside finer
/// ones is closed only with them. They belong to an edge whatever cell it is of, so that
/// neighbours stay alike.
class HangingVertices {
 public:
  /// Looks at the faces of a cell: where an edge has but one face and others go along it through
  /// vertices between its ends, those hang on it.
  void look(const std::vector<Polygon>& faces, std::span<const Vec3> places);

  bool empty() const { return onEdge_.empty(); }

  /// Puts them into the faces of a cell; true when there were some.
  bool insert(std::vector<Polygon>& faces) const;

 private:
  /// By the lower and the higher end; from the lower on.
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::int64_t>> onEdge_;
};

}  // namespace volute
