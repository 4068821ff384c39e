// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// Moves a lamp's shares at the vertices of a mesh so that what is linear between them fits the
/// light inside of the tets: by least squares of what the smoke sends, extinction times share, with
/// the shares at the middles of edges known as well. Light that smoke takes is convex, so that
/// shares which are exact at vertices are too large everywhere between them, and such errors add up
/// along a ray.
///
/// Only tets with smoke in which the light changes are asked about. A tet with a dark vertex keeps
/// what it has: there is a shadow's edge.
class ShareFit {
 public:
  /// @param extinction  [1/m], one for each vertex; @param shares  exact, one for each vertex
  ShareFit(const TetMesh& mesh, std::span<const float> extinction, std::span<const float> shares);

  /// Middles of edges, each a little inside of its tet, where shares are asked for.
  std::span<const Vec3> places() const { return places_; }

  /// The tet of each place.
  std::span<const std::int32_t> tets() const { return placeTets_; }

  /// Adds to sums at vertices what other pieces of the mesh have there.
  using AddPieces = std::function<Status(std::span<double>)>;

  /// One share for each vertex.
  /// @param sharesAtPlaces  exact
  /// @param addPieces  empty: the mesh is whole
  [[nodiscard]] Result<std::vector<float>> fitted(std::span<const float> sharesAtPlaces,
                                                  const AddPieces& addPieces = {}) const;

 private:
  const TetMesh& mesh_;
  std::span<const float> shares_;
  std::vector<double> weights_;                        ///< of errors, at each vertex
  std::vector<std::int32_t> smoky_;                    ///< tets with smoke
  std::vector<std::int32_t> asked_;                    ///< those that are asked about
  std::vector<std::array<std::int32_t, 6>> placesOf_;  ///< of their edges
  std::vector<Vec3> places_;
  std::vector<std::int32_t> placeTets_;
};

}  // namespace volute
