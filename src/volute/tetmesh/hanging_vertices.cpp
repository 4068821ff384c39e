// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/hanging_vertices.hpp"

#include <algorithm>
#include <iterator>

namespace volute {
namespace {

using OpenEdge = std::pair<std::int64_t, std::int64_t>;

/// Edges that one face alone has.
std::vector<OpenEdge> openEdges(const std::vector<Polygon>& faces) {
  std::vector<OpenEdge> edges;
  for (const Polygon& face : faces) {
    for (std::size_t i = 0; i < face.size(); ++i)
      edges.push_back(std::minmax({face[i], face[(i + 1) % face.size()]}));
  }
  std::ranges::sort(edges);
  std::vector<OpenEdge> open;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t next = i + 1;
    while (next < edges.size() && edges[next] == edges[i]) ++next;
    if (next - i == 1)
      open.push_back(edges[i]);
    i = next;
  }
  return open;
}

}  // namespace

void HangingVertices::look(const std::vector<Polygon>& faces, std::span<const Vec3> places) {
  constexpr double kBeside = 1e-3;  // of the edge's length; what float coordinates leave
  const std::vector<OpenEdge> open = openEdges(faces);
  if (open.empty())
    return;
  std::vector<std::int64_t> ends;
  for (const OpenEdge& edge : open) {
    ends.push_back(edge.first);
    ends.push_back(edge.second);
  }
  std::ranges::sort(ends);
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  const auto at = [&](std::int64_t v) { return places[static_cast<std::size_t>(v)]; };
  for (const OpenEdge& edge : open) {
    const Vec3 along = at(edge.second) - at(edge.first);
    std::vector<std::pair<double, std::int64_t>> between;
    for (const std::int64_t v : ends) {
      if (v == edge.first || v == edge.second)
        continue;
      const Vec3 from = at(v) - at(edge.first);
      const double share = from.dot(along) / along.squaredNorm();
      if (share > kBeside && share < 1 - kBeside &&
          (from - share * along).norm() < kBeside * along.norm())
        between.emplace_back(share, v);
    }
    if (between.empty())
      continue;
    std::ranges::sort(between);
    auto& known = onEdge_[edge];
    if (known.size() < between.size()) {
      known.clear();
      for (const auto& [share, v] : between) known.push_back(v);
    }
  }
}

bool HangingVertices::insert(std::vector<Polygon>& faces) const {
  bool any = false;
  for (Polygon& face : faces) {
    // Again for the parts of an edge, on which others may hang.
    for (bool more = true; more;) {
      more = false;
      Polygon out;
      for (std::size_t i = 0; i < face.size(); ++i) {
        const std::int64_t from = face[i], to = face[(i + 1) % face.size()];
        out.push_back(from);
        const auto found = onEdge_.find(std::minmax({from, to}));
        if (found == onEdge_.end())
          continue;
        if (from < to)
          std::ranges::copy(found->second, std::back_inserter(out));
        else
          std::ranges::reverse_copy(found->second, std::back_inserter(out));
        more = any = true;
      }
      face = std::move(out);
    }
  }
  return any;
}

}  // namespace volute
