// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/survey.hpp"

#include <algorithm>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"

namespace volute {
namespace {

/// How far in front of its face a wall's sign is looked for in rounded coordinates [m].
constexpr double kFace = 1e-4;
/// The farthest that a sign is moved, and in what steps [m].
constexpr double kReach = 0.5, kStride = 0.01;

Place placeAt(const SightInstant& instant, const Vec3& point) {
  Place place{};
  instant.places({&point, 1}, {&place, 1});
  return place;
}

}  // namespace

Result<std::vector<SightTarget>> placeSigns(const SightInstant& instant,
                                            std::span<const SafetySign> signs, const Box3& bounds,
                                            Progress& progress) {
  std::vector<SightTarget> targets;
  for (const SafetySign& sign : signs) {
    double moved = 0;
    if (placeAt(instant, sign.position) != Place::kGas &&
        placeAt(instant, sign.position + kFace * sign.normal) != Place::kGas) {
      moved = kStride;
      while (moved <= kReach &&
             placeAt(instant, sign.position + moved * sign.normal) != Place::kGas)
        moved += kStride;
    }
    const auto [x, y, z] = std::array{sign.position[0], sign.position[1], sign.position[2]};
    if (moved > kReach) {
      return fail(ErrorCode::kInvalidArgument,
                  "sign '{}' at {:g}, {:g}, {:g} m has no gas within {} m in front of it; expected "
                  "a place within {:g} .. {:g}, {:g} .. {:g}, {:g} .. {:g} m outside of "
                  "obstructions: check its position, its normal and whether the case has smoke "
                  "there",
                  sign.name, x, y, z, kReach, bounds.min[0], bounds.max[0], bounds.min[1],
                  bounds.max[1], bounds.min[2], bounds.max[2]);
    }
    if (moved > 0) {
      progress.remark(
          fmt::format("sign '{}' is inside something solid or outside of the smoke: sight lines "
                      "end {:.2f} m in front of it",
                      sign.name, moved));
    }
    // On a wall's face: the end of the line does not count as blocked.
    targets.push_back({sign, sign.position + moved * sign.normal});
  }
  return targets;
}

void lookAround(const SightInstant& instant, std::span<const SightTarget> signs,
                std::span<const Vec3> eyes, std::span<Sighting> out) {
  VOLUTE_ASSERT(out.size() == signs.size() * eyes.size());
  constexpr std::size_t kBatch = 64;
  const std::size_t batches = (eyes.size() + kBatch - 1) / kBatch;
  // One sign after the other: neighbouring lines run through the same cells.
  parallelRanges(signs.size() * batches, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<SightLine> lines(kBatch);
    std::vector<Sight> sights(kBatch);
    for (std::size_t b = begin; b < end; ++b) {
      const std::size_t s = b / batches, first = b % batches * kBatch;
      const std::size_t count = std::min(kBatch, eyes.size() - first);
      for (std::size_t i = 0; i < count; ++i) lines[i] = {eyes[first + i], signs[s].target};
      instant.look(std::span(lines).first(count), std::span(sights).first(count));
      for (std::size_t i = 0; i < count; ++i)
        out[s * eyes.size() + first + i] = judge(signs[s].sign, lines[i].eye, sights[i]);
    }
  });
}

LossTimes::LossTimes(std::size_t places)
    : time(places, std::numeric_limits<double>::infinity()), earliest(time), latest(time) {}

void updateLoss(LossTimes& loss, double now, std::span<const std::size_t> members,
                std::span<const Sighting> sightings) {
  const std::size_t eyes = loss.time.size();
  const auto any = [&](bool Sighting::* what) {
    return [&, what](std::size_t i) {
      return std::ranges::any_of(members,
                                 [&](std::size_t s) { return sightings[s * eyes + i].*what; });
    };
  };
  loss.update(now, any(&Sighting::visible), any(&Sighting::certainly), any(&Sighting::possibly));
}

}  // namespace volute
