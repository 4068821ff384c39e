// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/survey.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/plain_number.hpp"

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

Place placeAt(const SightSnapshot& snapshot, const Vec3& point) {
  Place place{};
  snapshot.places({&point, 1}, {&place, 1});
  return place;
}

}  // namespace

Result<std::vector<SightTarget>> placeSigns(const SightSnapshot& snapshot,
                                            std::span<const SafetySign> signs, const Box3& bounds,
                                            Progress& progress) {
  std::vector<SightTarget> targets;
  for (const SafetySign& sign : signs) {
    double moved = 0;
    if (placeAt(snapshot, sign.position) != Place::kGas &&
        placeAt(snapshot, sign.position + kFace * sign.normal) != Place::kGas) {
      moved = kStride;
      while (moved <= kReach &&
             placeAt(snapshot, sign.position + moved * sign.normal) != Place::kGas)
        moved += kStride;
    }
    const auto [x, y, z] = std::array{sign.position[0], sign.position[1], sign.position[2]};
    if (moved > kReach) {
      return fail(ErrorCode::kInvalidArgument,
                  "sign '{}' at {}, {}, {} m has no gas within {} m in front of it; expected "
                  "a place within {} .. {}, {} .. {}, {} .. {} m outside of "
                  "obstructions: check its position, its normal and whether the case has smoke "
                  "there",
                  sign.name, plainNumber(x), plainNumber(y), plainNumber(z), kReach,
                  plainNumber(bounds.min[0]), plainNumber(bounds.max[0]),
                  plainNumber(bounds.min[1]), plainNumber(bounds.max[1]),
                  plainNumber(bounds.min[2]), plainNumber(bounds.max[2]));
    }
    if (moved > 0) {
      progress.remark(
          {RemarkCode::kChanged,
           fmt::format("sign '{}' is inside something solid or outside of the smoke: sight lines "
                       "end {:.2f} m in front of it",
                       sign.name, moved)});
    }
    // On a wall's face: the end of the line does not count as blocked.
    targets.push_back({sign, sign.position + moved * sign.normal});
  }
  return targets;
}

void lookAround(const SightSnapshot& snapshot, std::span<const SightTarget> signs,
                std::span<const Vec3> eyes, std::span<Sighting> out) {
  VOLUTE_ASSERT(out.size() == signs.size() * eyes.size());
  forEachBatch(signs.size(), eyes.size(),
               [&](std::size_t s, std::size_t first, std::size_t count, std::size_t) {
                 std::vector<SightLine> lines(count);
                 std::vector<Sight> sights(count);
                 for (std::size_t i = 0; i < count; ++i)
                   lines[i] = {eyes[first + i], signs[s].target};
                 snapshot.look(lines, sights);
                 for (std::size_t i = 0; i < count; ++i)
                   out[s * eyes.size() + first + i] = judge(signs[s].sign, lines[i].eye, sights[i]);
               });
}

void Lookout::look(const SightSnapshot& snapshot, std::span<const SightTarget> signs,
                   std::span<const Vec3> eyes, std::span<Sighting> out, bool again) {
  VOLUTE_ASSERT(out.size() == signs.size() * eyes.size());
  const bool worth = again && snapshot.geometry() != 0 && snapshot.geometry() != tooLarge_;
  if (fits(snapshot, eyes) || (worth && workOut(snapshot, signs, eyes)))
    sum(snapshot, signs, eyes, out);
  else
    lookAround(snapshot, signs, eyes, out);
}

bool Lookout::fits(const SightSnapshot& snapshot, std::span<const Vec3> eyes) const {
  return geometry_ != 0 && snapshot.geometry() == geometry_ && std::ranges::equal(eyes, eyes_);
}

/// Every `ranks`-th batch from the `rank`-th on.
/// @return  bytes of what is kept; more than the limit: they are not all there
std::uint64_t Lookout::workOutSome(const SightSnapshot& snapshot,
                                   std::span<const SightTarget> signs, std::span<const Vec3> eyes,
                                   int rank, int ranks) {
  std::atomic<std::uint64_t> bytes{0};
  batches_.assign(signs.size() * ((eyes.size() + kBatch - 1) / kBatch), {});
  forEachBatch(signs.size(), eyes.size(),
               [&](std::size_t s, std::size_t first, std::size_t count, std::size_t b) {
                 if (bytes > maxBytes_ ||
                     b % static_cast<std::size_t>(ranks) != static_cast<std::size_t>(rank))
                   return;
                 Batch& batch = batches_[b];
                 for (std::size_t i = 0; i < count; ++i) {
                   const Vec3& eye = eyes[first + i];
                   Sight sight;
                   snapshot.weigh({eye, signs[s].target}, batch.weights, sight);
                   batch.sights.push_back(judge(signs[s].sign, eye, sight));
                   batch.ends.push_back(static_cast<std::uint32_t>(batch.weights.size()));
                 }
                 batch.weights.shrink_to_fit();
                 bytes += batch.weights.size() * sizeof(SightWeight) + count * sizeof(Sighting);
               });
  return bytes;
}

bool Lookout::keep(const SightSnapshot& snapshot, std::span<const Vec3> eyes, std::uint64_t bytes) {
  const bool kept = bytes <= maxBytes_;
  geometry_ = kept ? snapshot.geometry() : 0;
  tooLarge_ = kept ? tooLarge_ : snapshot.geometry();
  eyes_.assign(eyes.begin(), eyes.end());
  if (!kept)
    batches_ = {};
  return kept;
}

bool Lookout::workOut(const SightSnapshot& snapshot, std::span<const SightTarget> signs,
                      std::span<const Vec3> eyes) {
  return keep(snapshot, eyes, workOutSome(snapshot, signs, eyes, 0, 1));
}

Status Lookout::workOutTogether(const SightSnapshot& snapshot, std::span<const SightTarget> signs,
                                std::span<const Vec3> eyes, Team& team) {
  if (team.size() == 1 || snapshot.geometry() == 0)
    return {};
  std::array<std::uint64_t, 1> bytes{workOutSome(snapshot, signs, eyes, team.rank(), team.size())};
  VOLUTE_TRY(team.sum(bytes));
  if (!keep(snapshot, eyes, bytes[0]))
    return {};
  std::vector<std::byte> own;
  const auto put = [&](const auto& values) {
    const std::uint64_t count = values.size();
    for (const auto part : {std::as_bytes(std::span(&count, 1)), std::as_bytes(std::span(values))})
      own.insert(own.end(), part.begin(), part.end());
  };
  const auto ranks = static_cast<std::size_t>(team.size());
  for (auto b = static_cast<std::size_t>(team.rank()); b < batches_.size(); b += ranks) {
    put(batches_[b].weights);
    put(batches_[b].ends);
    put(batches_[b].sights);
  }
  VOLUTE_ASSIGN(auto all, team.gatherAll(own));
  own = {};
  for (std::size_t rank = 0; rank < ranks; ++rank) {
    std::span<const std::byte> left = all[rank];
    const auto take = [&](auto& values) {
      std::uint64_t count = 0;
      std::memcpy(&count, left.data(), sizeof count);
      left = left.subspan(sizeof count);
      values.resize(count);
      const std::size_t size = count * sizeof(values[0]);
      if (size > 0)
        std::memcpy(values.data(), left.data(), size);
      left = left.subspan(size);
    };
    if (rank != static_cast<std::size_t>(team.rank())) {
      for (std::size_t b = rank; b < batches_.size(); b += ranks) {
        take(batches_[b].weights);
        take(batches_[b].ends);
        take(batches_[b].sights);
      }
    }
    all[rank] = {};
  }
  return {};
}

void Lookout::sum(const SightSnapshot& snapshot, std::span<const SightTarget> signs,
                  std::span<const Vec3> eyes, std::span<Sighting> out) const {
  const SightData data = snapshot.data();
  forEachBatch(signs.size(), eyes.size(),
               [&](std::size_t s, std::size_t first, std::size_t count, std::size_t b) {
                 const Batch& batch = batches_[b];
                 std::uint32_t begin = 0;
                 for (std::size_t i = 0; i < count; ++i) {
                   const auto weights =
                       std::span(batch.weights).subspan(begin, batch.ends[i] - begin);
                   begin = batch.ends[i];
                   double depth = 0, low = 0, high = 0;
                   for (const SightWeight& one : weights)
                     depth += static_cast<double>(one.weight) * data.value[one.value];
                   if (data.low.empty()) {
                     low = high = depth;
                   } else {
                     for (const SightWeight& one : weights) {
                       low += static_cast<double>(one.weight) * data.low[one.value];
                       high += static_cast<double>(one.weight) * data.high[one.value];
                     }
                   }
                   out[s * eyes.size() + first + i] = judged(batch.sights[i], depth, low, high);
                 }
               });
}

}  // namespace volute
