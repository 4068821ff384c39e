// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/shared_light.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

#include "volute/base/gather_values.hpp"
#include "volute/base/parallel.hpp"
#include "volute/lighting/lamp_runs.hpp"

namespace volute {
namespace {

/// Points of all ranks that are looked at together.
constexpr std::size_t kPoints = std::size_t{1} << 16;
constexpr std::size_t kGrain = 256;

/// As it travels.
struct SentLampRun {
  std::uint64_t point = 0;  ///< of those that are looked at
  LampRun run;
};

/// The runs of ways from `points` in this rank's pieces, point by point.
std::vector<SentLampRun> runsOf(std::span<const Vec3> points, const TetLocator& own,
                                std::span<const float> extinction, const Lamp& lamp, double near) {
  std::vector<std::vector<LampRun>> each(points.size());
  parallelRanges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      appendLampRuns(own, extinction, lamp.towards(points[i]), near, each[i]);
  });
  std::vector<SentLampRun> sent;
  for (std::size_t i = 0; i < each.size(); ++i) {
    for (const LampRun& run : each[i]) sent.push_back({i, run});
  }
  return sent;
}

}  // namespace

Result<std::vector<float>> sharedLampShares(const SharedMesh& mesh,
                                            std::span<const float> extinction, const Lamp& lamp,
                                            std::span<const Vec3> points) {
  const auto& [team, own, bounds] = mesh;
  const double near = 1e-6 * bounds.size().maxCoeff();

  struct RankShare {
    std::uint64_t points = 0;
    std::uint64_t hasLamp = 0;
  };

  const bool spot = lamp.kind == Lamp::Kind::kSpot;
  const RankShare mine{points.size(), spot && own.find(lamp.position) >= 0};
  VOLUTE_ASSIGN(const auto ranks, gatherValues(team, std::span<const RankShare>(&mine, 1)));
  const bool inside =
      std::ranges::any_of(ranks, [](const RankShare& one) { return one.hasLamp != 0; });
  std::vector<float> shares(points.size(), 0);
  // All ranks ask at once, so many vertices each.
  const std::size_t some =
      std::max<std::size_t>(1, kPoints / static_cast<std::size_t>(team.size()));
  const std::uint64_t most = std::ranges::max(ranks, {}, &RankShare::points).points;
  for (std::size_t first = 0; first < most; first += some) {
    const std::size_t begin = std::min(first, points.size());
    const std::size_t count = std::min(some, points.size() - begin);
    const auto places = points.subspan(begin, count);
    VOLUTE_ASSIGN(const auto questions, gatherEach(team, places));
    std::vector<std::vector<SentLampRun>> answers;
    for (const auto& asked : questions)
      answers.push_back(runsOf(asked, own, extinction, lamp, near));
    VOLUTE_ASSIGN(const auto received,
                  exchangeValues(team, std::span<const std::vector<SentLampRun>>(answers)));
    std::vector<std::vector<LampRun>> ofPoint(count);
    for (const auto& one : received) {
      for (const SentLampRun& sent : one) ofPoint[sent.point].push_back(sent.run);
    }
    parallelFor(count, [&](std::size_t i) {
      const double end =
          inside ? lamp.towards(places[i]).end : std::numeric_limits<double>::infinity();
      shares[begin + i] = static_cast<float>(lampShareOf(ofPoint[i], end, near));
    });
  }
  return shares;
}

Status addAtSharedVertices(const SharedMesh& mesh, std::span<double> sums) {
  struct Sum {
    Vec3 at;
    double value = 0;
    std::int32_t vertex = -1;
  };

  const TetMesh& own = mesh.own.mesh();
  std::vector<std::int32_t> border;
  for (const std::int32_t f : own.boundary()) {
    const auto& face = own.faces()[static_cast<std::size_t>(f)];
    border.insert(border.end(), face.vertices.begin(), face.vertices.end());
  }
  std::ranges::sort(border);
  border.erase(std::ranges::unique(border).begin(), border.end());
  std::vector<Sum> mine;
  for (const std::int32_t v : border) mine.push_back({own.vertices()[v], sums[v], v});
  VOLUTE_ASSIGN(auto each, gatherEach(mesh.team, std::span<const Sum>(mine)));
  const auto before = [](const Sum& a, const Sum& b) {
    return std::tuple(a.at.x(), a.at.y(), a.at.z()) < std::tuple(b.at.x(), b.at.y(), b.at.z());
  };
  for (auto& others : each) std::ranges::sort(others, before);
  // In the order of ranks, this one's too, so that all come to the same.
  for (const Sum& one : mine) {
    double sum = 0;
    for (const auto& others : each) {
      const auto found = std::ranges::equal_range(others, one, before);
      for (const Sum& other : found) sum += other.value;
    }
    sums[one.vertex] = sum;
  }
  return {};
}

}  // namespace volute
