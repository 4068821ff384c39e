// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/shared_light.hpp"

#include <algorithm>
#include <limits>

#include "volute/base/gather_values.hpp"
#include "volute/base/parallel.hpp"
#include "volute/lighting/lamp_runs.hpp"

namespace volute {
namespace {

/// Vertices of all ranks that are looked at together.
constexpr std::size_t kVertices = std::size_t{1} << 16;
constexpr std::size_t kGrain = 256;

/// As it travels.
struct SentLampRun {
  std::uint64_t vertex = 0;  ///< of those that are looked at
  LampRun run;
};

/// The runs of ways from `vertices` in this rank's pieces, vertex by vertex.
std::vector<SentLampRun> runsOf(std::span<const Vec3> vertices, const TetLocator& own,
                                std::span<const float> extinction, const Lamp& lamp, double near) {
  std::vector<std::vector<LampRun>> each(vertices.size());
  parallelRanges(vertices.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      appendLampRuns(own, extinction, lamp.towards(vertices[i]), near, each[i]);
  });
  std::vector<SentLampRun> sent;
  for (std::size_t i = 0; i < each.size(); ++i) {
    for (const LampRun& run : each[i]) sent.push_back({i, run});
  }
  return sent;
}

}  // namespace

Result<std::vector<float>> sharedLampShares(Team& team, const TetLocator& own,
                                            std::span<const float> extinction, const Lamp& lamp,
                                            const Box3& bounds) {
  const double near = 1e-6 * bounds.size().maxCoeff();
  const std::span<const Vec3> vertices = own.mesh().vertices();

  struct Holder {
    std::uint64_t vertices = 0;
    std::uint64_t hasLamp = 0;
  };

  const bool spot = lamp.kind == Lamp::Kind::kSpot;
  const Holder self{vertices.size(), spot && own.find(lamp.position) >= 0};
  VOLUTE_ASSIGN(const auto holders, gatherValues(team, std::span<const Holder>(&self, 1)));
  const bool inside =
      std::ranges::any_of(holders, [](const Holder& one) { return one.hasLamp != 0; });
  std::vector<float> shares(vertices.size(), 0);
  // All ranks ask at once, so many vertices each.
  const std::size_t some =
      std::max<std::size_t>(1, kVertices / static_cast<std::size_t>(team.size()));
  const std::uint64_t most = std::ranges::max(holders, {}, &Holder::vertices).vertices;
  for (std::size_t first = 0; first < most; first += some) {
    const std::size_t begin = std::min(first, vertices.size());
    const std::size_t count = std::min(some, vertices.size() - begin);
    const auto places = vertices.subspan(begin, count);
    VOLUTE_ASSIGN(const auto questions, gatherEach(team, places));
    std::vector<std::vector<SentLampRun>> answers;
    for (const auto& asked : questions)
      answers.push_back(runsOf(asked, own, extinction, lamp, near));
    VOLUTE_ASSIGN(const auto received,
                  exchangeValues(team, std::span<const std::vector<SentLampRun>>(answers)));
    std::vector<std::vector<LampRun>> ofVertex(count);
    for (const auto& one : received) {
      for (const SentLampRun& sent : one) ofVertex[sent.vertex].push_back(sent.run);
    }
    parallelFor(count, [&](std::size_t i) {
      const double end =
          inside ? lamp.towards(places[i]).end : std::numeric_limits<double>::infinity();
      shares[begin + i] = static_cast<float>(lampShareOf(ofVertex[i], end, near));
    });
  }
  return shares;
}

}  // namespace volute
