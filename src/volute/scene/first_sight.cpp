// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/first_sight.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "volute/base/parallel.hpp"
#include "volute/media/first_time.hpp"

namespace volute {
namespace {

constexpr int kPoints = 20;       ///< a side of the grid
constexpr double kSeen = 0.03;    ///< of what is seen most: less is hardly seen
constexpr double kNear = 0.75;    ///< of the media's largest side: surfaces that belong to them
constexpr double kEndless = 1e6;  ///< [m]

/// Whether it is around anything; it may be flat.
bool holds(const Box3& box) {
  return (box.min.array() <= box.max.array()).all();
}

void extendBy(Box3& box, const Box3& by) {
  if (!holds(by))
    return;
  box.extend(by);
}

/// Fog may have no end above or below: what is more than half as high as it is wide is hardly seen.
Box3 withEnds(Box3 box) {
  const double width = std::min(box.size().head<2>().maxCoeff(), kEndless);
  if (!(box.max.z() < kEndless))
    box.max.z() = std::max(box.min.z(), -kEndless) + 0.1 * width;
  if (!(box.min.z() > -kEndless))
    box.min.z() = box.max.z() - 0.1 * width;
  return box;
}

Box3 intersection(const Box3& a, const Box3& b) {
  Box3 both;
  both.min = a.min.cwiseMax(b.min), both.max = a.max.cwiseMin(b.max);
  return both;
}

/// What is flat gets some thickness.
Box3 thick(Box3 box) {
  const Vec3 least = Vec3::Constant(std::max(0.01 * box.size().maxCoeff(), 1e-3));
  const Vec3 half = 0.5 * box.size().cwiseMax(least), centre = box.centre();
  return {centre - half, centre + half};
}

SceneContent contentOfMedium(const AnyMedium& medium) {
  const Box3 bounds = withEnds(medium.bounds());
  if (bounds.empty() || !bounds.size().allFinite())
    return {};
  const Vec3 cell = bounds.size() / kPoints;
  const double side = bounds.size().maxCoeff();
  std::vector<double> values(kPoints * kPoints * kPoints), seen(values.size());
  parallelFor(values.size() / kPoints, [&](std::size_t row) {
    for (int x = 0; x < kPoints; ++x) {
      const Vec3 place(x + 0.5, static_cast<double>(row % kPoints) + 0.5,
                       static_cast<double>(row / kPoints) + 0.5);
      const Vec3 point = bounds.min + cell.cwiseProduct(place);
      const double extinction = std::max(medium.extinction(point), 0.0);
      const double emission = medium.emission(point).maxCoeff();
      if (!std::isfinite(extinction + emission))
        continue;
      const std::size_t i = row * kPoints + x;
      values[i] = std::max(extinction + emission, 0.0);
      // Dense smoke hides no more than all: beside it thin smoke is as visible as ever.
      seen[i] = std::max(-std::expm1(-extinction * side) / side + emission, 0.0);
    }
  });
  const double most = *std::ranges::max_element(seen);
  SceneContent content;
  if (!(most > 0))
    return content;
  for (std::size_t i = 0; i < values.size(); ++i) {
    content.amount += values[i] * cell.prod();
    if (seen[i] < kSeen * most)
      continue;
    const Vec3 place(static_cast<double>(i % kPoints), static_cast<double>(i / kPoints % kPoints),
                     static_cast<double>(i / kPoints / kPoints));
    const Vec3 low = bounds.min + cell.cwiseProduct(place);
    extendBy(content.box, {low, low + cell});
  }
  return content;
}

}  // namespace

SceneContent contentOf(const SceneSnapshot& snapshot) {
  SceneContent content;
  std::vector<AnyMedium> media;
  for (const auto& medium : snapshot.media) medium->addMedia(media);
  for (const AnyMedium& medium : media) {
    const SceneContent one = contentOfMedium(medium);
    content.amount += one.amount;
    extendBy(content.box, one.box);
  }
  for (const Sign& sign : snapshot.signs) content.box.extend(sign.position);
  if (snapshot.geometry.empty())
    return content;
  const Box3& surfaces = snapshot.geometry.bounds();
  if (!holds(content.box)) {
    content.box = surfaces;
    return content;
  }
  const Vec3 margin = Vec3::Constant(kNear * content.box.size().maxCoeff());
  const Box3 around{content.box.min - margin, content.box.max + margin};
  extendBy(content.box, intersection(surfaces, around));
  return content;
}

bool showsOneFile(const Scene& scene) {
  if (!scene.isFile())
    return true;
  const SceneDescription& says = scene.description();
  return scene.media().size() == 1 && !scene.media().front()->info().interpolates &&
         !scene.media().front()->info().endless && says.version >= kSceneVersion && !says.camera &&
         says.geometry.empty() && says.signs.empty();
}

Result<FirstSight> firstSight(Scene& scene, Progress& progress, std::uint64_t enough) {
  const auto times = scene.times();
  FirstSight sight{times.front(), scene.framed(), ""};

  struct Look {
    double time;
    SceneContent content;
  };

  std::vector<Look> looks;
  if (showsOneFile(scene) && !scene.media().empty()) {
    VOLUTE_ASSIGN(const auto known, scene.media().front()->firstTime(progress));
    if (known) {
      sight.time = known->time, sight.reason = known->reason;
      VOLUTE_ASSIGN(const auto snapshot,
                    scene.at({.time = known->time, .coarse = true, .lit = false}, progress));
      const Box3 box = contentOf(snapshot).box;
      if (holds(box))
        sight.content = thick(box);
      return sight;
    }
  }
  // The first, the middle, then what is between them.
  constexpr int kTimes = 8;
  constexpr int kOrder[kTimes] = {0, 4, 2, 6, 1, 3, 5, 7};
  std::uint64_t looked = 0;
  for (const int part : kOrder) {
    const bool found =
        std::ranges::any_of(looks, [](const Look& look) { return look.content.amount > 0; });
    if (found && looked >= enough)
      break;
    const double time = times[part * (times.size() - 1) / (kTimes - 1)];
    if (std::ranges::find(looks, time, &Look::time) != looks.end())
      continue;
    auto snapshot = scene.at({.time = time, .coarse = true, .lit = false}, progress);
    if (!snapshot) {
      if (looks.empty())
        return tl::unexpected<Error>(snapshot.error());
      break;  // what can be seen is seen
    }
    for (const auto& medium : snapshot->media) looked += medium->memoryBytes();
    looks.push_back({time, contentOf(*snapshot)});
  }
  std::ranges::sort(looks, {}, &Look::time);
  std::vector<double> amounts;
  for (const Look& look : looks) amounts.push_back(look.content.amount);
  const Look* const chosen = &looks[firstThatShows(amounts)];
  if (chosen != &looks.front()) {
    sight.reason = fmt::format(
        "of {} times looked at the first with at least half of the most that there is to see",
        looks.size());
  }
  sight.time = chosen->time;
  if (holds(chosen->content.box))
    sight.content = thick(chosen->content.box);
  return sight;
}

}  // namespace volute
