// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/survey.hpp"

#include <algorithm>
#include <array>
#include <atomic>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"

namespace volute {
namespace {

/// How far in front of its face a wall's sign is looked for in rounded coordinates [m].
constexpr double kFace = 1e-4;
/// The farthest that a sign is moved, and in what steps [m].
constexpr double kReach = 0.5, kStride = 0.01;

constexpr std::size_t kBatch = 64;  // lines

/// Calls body(sign, first eye, eyes, batch): all lines in batches, those of one sign together.
template <class Body>
void forEachBatch(std::size_t signs, std::size_t eyes, Body&& body) {
  const std::size_t batches = (eyes + kBatch - 1) / kBatch;
  parallelRanges(signs * batches, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      const std::size_t first = b % batches * kBatch;
      body(b / batches, first, std::min(kBatch, eyes - first), b);
    }
  });
}

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
  forEachBatch(signs.size(), eyes.size(),
               [&](std::size_t s, std::size_t first, std::size_t count, std::size_t) {
                 std::vector<SightLine> lines(count);
                 std::vector<Sight> sights(count);
                 for (std::size_t i = 0; i < count; ++i)
                   lines[i] = {eyes[first + i], signs[s].target};
                 instant.look(lines, sights);
                 for (std::size_t i = 0; i < count; ++i)
                   out[s * eyes.size() + first + i] = judge(signs[s].sign, lines[i].eye, sights[i]);
               });
}

void Lookout::look(const SightInstant& instant, std::span<const SightTarget> signs,
                   std::span<const Vec3> eyes, std::span<Sighting> out, bool again) {
  VOLUTE_ASSERT(out.size() == signs.size() * eyes.size());
  const bool worth = again && instant.geometry() != 0 && instant.geometry() != tooLarge_;
  if (fits(instant, eyes) || (worth && workOut(instant, signs, eyes)))
    sum(instant, signs, eyes, out);
  else
    lookAround(instant, signs, eyes, out);
}

bool Lookout::fits(const SightInstant& instant, std::span<const Vec3> eyes) const {
  return geometry_ != 0 && instant.geometry() == geometry_ && std::ranges::equal(eyes, eyes_);
}

bool Lookout::workOut(const SightInstant& instant, std::span<const SightTarget> signs,
                      std::span<const Vec3> eyes) {
  std::atomic<std::uint64_t> bytes{0};
  batches_.assign(signs.size() * ((eyes.size() + kBatch - 1) / kBatch), {});
  forEachBatch(signs.size(), eyes.size(),
               [&](std::size_t s, std::size_t first, std::size_t count, std::size_t b) {
                 if (bytes > maxBytes_)
                   return;
                 Batch& batch = batches_[b];
                 for (std::size_t i = 0; i < count; ++i) {
                   instant.weigh({eyes[first + i], signs[s].target}, batch.weights,
                                 batch.sights.emplace_back());
                   batch.ends.push_back(static_cast<std::uint32_t>(batch.weights.size()));
                 }
                 batch.weights.shrink_to_fit();
                 bytes += batch.weights.size() * sizeof(SightWeight) + count * sizeof(Sight);
               });
  const bool kept = bytes <= maxBytes_;
  geometry_ = kept ? instant.geometry() : 0;
  tooLarge_ = kept ? tooLarge_ : instant.geometry();
  eyes_.assign(eyes.begin(), eyes.end());
  if (!kept)
    batches_ = {};
  return kept;
}

void Lookout::sum(const SightInstant& instant, std::span<const SightTarget> signs,
                  std::span<const Vec3> eyes, std::span<Sighting> out) const {
  const SightData data = instant.data();
  const auto dot = [](std::span<const SightWeight> weights, std::span<const float> values) {
    double sum = 0;
    for (const SightWeight& weight : weights)
      sum += static_cast<double>(weight.weight) * values[weight.value];
    return sum;
  };
  forEachBatch(signs.size(), eyes.size(),
               [&](std::size_t s, std::size_t first, std::size_t count, std::size_t b) {
                 const Batch& batch = batches_[b];
                 std::uint32_t begin = 0;
                 for (std::size_t i = 0; i < count; ++i) {
                   const auto weights =
                       std::span(batch.weights).subspan(begin, batch.ends[i] - begin);
                   begin = batch.ends[i];
                   Sight sight = batch.sights[i];
                   sight.depth = dot(weights, data.value);
                   sight.low = data.low.empty() ? sight.depth : dot(weights, data.low);
                   sight.high = data.high.empty() ? sight.depth : dot(weights, data.high);
                   out[s * eyes.size() + first + i] = judge(signs[s].sign, eyes[first + i], sight);
                 }
               });
}

}  // namespace volute
