// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/share_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

constexpr int kEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/// A tet is asked about where its shares may be so far from linear.
constexpr double kTolerance = 3e-3;

/// A share moves by at most this part of itself.
constexpr double kLargestMove = 0.25;

/// Of the way from an edge's middle to the tet's.
constexpr double kInside = 1e-5;

/// The integral over a tet of six times unit volume of products of barycentric coordinates, each
/// index one factor.
template <std::size_t N>
constexpr double integralOf(const std::array<int, N>& factors) {
  int powers[4] = {};
  double value = 1;
  for (const int f : factors) value *= ++powers[f];
  for (int i = 2; i <= static_cast<int>(N) + 3; ++i) value /= i;
  return value;
}

/// A vertex's part of an edge's curve: the integral of weight x 4 b_i b_j x b_a by weights.
struct Integrals {
  double curve[6][4][4];  ///< edge, vertex, weight
  double product[4][4][4];

  constexpr Integrals() : curve(), product() {
    for (int a = 0; a < 4; ++a) {
      for (int c = 0; c < 4; ++c) {
        for (int e = 0; e < 6; ++e)
          curve[e][a][c] = 4 * integralOf(std::array{kEdges[e][0], kEdges[e][1], a, c});
        for (int b = 0; b < 4; ++b) product[a][b][c] = integralOf(std::array{a, b, c});
      }
    }
  }
};

constexpr Integrals kIntegrals;

double weighted(const double (&integrals)[4], const double (&weights)[4]) {
  double sum = 0;
  for (int c = 0; c < 4; ++c) sum += integrals[c] * weights[c];
  return sum;
}

/// How far a share may be from linear in the middle of a tet's longest edge: e^-depth of a depth
/// that is linear, and of one that curves as the extinction changes along a way to the lamp. 0
/// where a vertex is dark.
double curveOf(const TetMesh& mesh, std::int32_t t, std::span<const float> extinction,
               std::span<const float> shares) {
  const Tet& tet = mesh.tets()[t];
  double least = 1, most = 0, thin = extinction[tet[0]], thick = thin, length = 0;
  for (int k = 0; k < 4; ++k) {
    const double share = shares[tet[k]], here = extinction[tet[k]];
    least = std::min(least, share), most = std::max(most, share);
    thin = std::min(thin, here), thick = std::max(thick, here);
  }
  if (!(least > 0))
    return 0;
  for (const auto& [a, b] : kEdges)
    length = std::max(length, (mesh.vertices()[tet[a]] - mesh.vertices()[tet[b]]).squaredNorm());
  const double fall = std::log(most / least);
  return most * std::min(0.5, (fall * fall + std::sqrt(length) * (thick - thin)) / 8);
}

}  // namespace

ShareFit::ShareFit(const TetMesh& mesh, std::span<const float> extinction,
                   std::span<const float> shares)
    : mesh_(mesh), shares_(shares), weights_(extinction.begin(), extinction.end()) {
  VOLUTE_ASSERT(extinction.size() == mesh.vertices().size() && shares.size() == extinction.size());
  for (double& weight : weights_) weight *= weight;

  struct Edge {
    std::int32_t to, at;  // at: of the asked tets' edges

    bool operator<(const Edge& other) const {
      return std::tie(to, at) < std::tie(other.to, other.at);
    }
  };

  for (std::size_t t = 0; t < mesh.tets().size(); ++t) {
    const Tet& tet = mesh.tets()[t];
    if (std::ranges::none_of(tet, [&](std::int32_t v) { return weights_[v] > 0; }))
      continue;
    smoky_.push_back(static_cast<std::int32_t>(t));
    if (!(curveOf(mesh, static_cast<std::int32_t>(t), extinction, shares) > kTolerance))
      continue;
    asked_.push_back(static_cast<std::int32_t>(t));
  }
  // Edges by the vertex from which they lead.
  const auto points = mesh.vertices();
  std::vector<std::size_t> ends(points.size() + 1, 0);
  for (const std::int32_t t : asked_) {
    for (const auto& edge : kEdges) ++ends[mesh.tets()[t][edge[0]] + 1];
  }
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  std::vector<Edge> edges(ends.back());
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    const Tet& tet = mesh.tets()[asked_[i]];
    for (int e = 0; e < 6; ++e)
      edges[ends[tet[kEdges[e][0]]]++] = {tet[kEdges[e][1]], static_cast<std::int32_t>(6 * i + e)};
  }
  placesOf_.resize(asked_.size());
  std::size_t begin = 0;
  for (std::size_t from = 0; from < points.size(); begin = ends[from++]) {
    const auto its = std::span(edges).subspan(begin, ends[from] - begin);
    std::ranges::sort(its, std::less<>());
    for (std::size_t i = 0; i < its.size(); ++i) {
      const std::int32_t of = its[i].at / 6;
      if (i == 0 || its[i - 1].to != its[i].to) {
        const Tet& tet = mesh.tets()[asked_[of]];
        const Vec3 middle = 0.5 * (points[from] + points[its[i].to]);
        const Vec3 centre =
            0.25 * (points[tet[0]] + points[tet[1]] + points[tet[2]] + points[tet[3]]);
        places_.push_back(middle + kInside * (centre - middle));
        placeTets_.push_back(asked_[of]);
      }
      placesOf_[of][its[i].at % 6] = static_cast<std::int32_t>(places_.size() - 1);
    }
  }
}

Result<std::vector<float>> ShareFit::fitted(std::span<const float> sharesAtPlaces,
                                            const AddPieces& addPieces) const {
  VOLUTE_ASSERT(sharesAtPlaces.size() == places_.size());
  std::vector<double> mass(shares_.size(), 0), missing(shares_.size(), 0);
  const auto weightsOf = [&](const Tet& tet, double(&weights)[4]) {
    for (int c = 0; c < 4; ++c) weights[c] = weights_[tet[c]];
  };
  for (const std::int32_t t : smoky_) {
    const Tet& tet = mesh_.tets()[t];
    double weights[4];
    weightsOf(tet, weights);
    const double volume = mesh_.volume(t);
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b)
        mass[tet[a]] += volume * weighted(kIntegrals.product[a][b], weights);
    }
  }
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    const Tet& tet = mesh_.tets()[asked_[i]];
    double weights[4];
    weightsOf(tet, weights);
    const double volume = mesh_.volume(asked_[i]);
    for (int e = 0; e < 6; ++e) {
      const double between =
          0.5 * (double(shares_[tet[kEdges[e][0]]]) + shares_[tet[kEdges[e][1]]]);
      const float at = sharesAtPlaces[placesOf_[i][e]];
      if (!(at > 0))
        continue;  // in a shadow
      const double curve = volume * (at - between);
      for (int a = 0; a < 4; ++a)
        missing[tet[a]] += curve * weighted(kIntegrals.curve[e][a], weights);
    }
  }
  if (addPieces) {
    VOLUTE_TRY(addPieces(mass));
    VOLUTE_TRY(addPieces(missing));
  }
  // Two steps towards the least squares, with each row's sum in place of the matrix.
  std::vector<double> moves(shares_.size(), 0), reached(shares_.size(), 0);
  const auto step = [&] {
    for (std::size_t v = 0; v < moves.size(); ++v) {
      if (mass[v] > 0)
        moves[v] += (missing[v] - reached[v]) / mass[v];
    }
  };
  step();
  for (const std::int32_t t : smoky_) {
    const Tet& tet = mesh_.tets()[t];
    if (std::ranges::all_of(tet, [&](std::int32_t v) { return moves[v] == 0; }))
      continue;
    double weights[4];
    weightsOf(tet, weights);
    const double volume = mesh_.volume(t);
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b)
        reached[tet[a]] += volume * weighted(kIntegrals.product[a][b], weights) * moves[tet[b]];
    }
  }
  if (addPieces)
    VOLUTE_TRY(addPieces(reached));
  step();
  std::vector<float> out(shares_.begin(), shares_.end());
  for (std::size_t v = 0; v < out.size(); ++v) {
    const double most = kLargestMove * out[v];
    out[v] = static_cast<float>(std::min(1.0, out[v] + std::clamp(moves[v], -most, most)));
  }
  return out;
}

}  // namespace volute
