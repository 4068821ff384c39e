// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/triangle_scene.hpp"

#include <algorithm>
#include <future>
#include <mutex>
#include <optional>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/geometry/shadow_intervals.hpp"
#include "volute/geometry/sun_tree.hpp"
#include "volute/geometry/triangle_tree.hpp"
#if VOLUTE_HAS_EMBREE
#include "volute/geometry/embree_scene.hpp"
#endif

namespace volute {

struct TriangleScene::Impl {
  Impl(std::vector<Triangle> given, std::vector<Material> looks)
      : triangles(std::move(given)), materials(std::move(looks)) {
    for (const Triangle& triangle : triangles) {
      for (const Vec3& corner : triangle.corners) bounds.extend(corner);
    }
  }

  std::vector<Triangle> triangles;
  std::vector<Material> materials;
  Box3 bounds;

  /// Made when somebody needs it first: where Embree answers, only shadows of lamps do, and a
  /// million triangles take a second.
  const TriangleTree& tree() const {
    std::call_once(treeMade, [&] { madeTree.emplace(triangles); });
    return *madeTree;
  }

  /// As a far light sees them: made when it is asked for first, and kept for the last few. In one
  /// thread, while others wait: a loop of threads in here might come back to wait for itself.
  std::shared_ptr<const SunTree> treeOf(const Vec3& towards) const {
    const std::lock_guard lock(sunsMutex);
    for (const auto& [direction, tree] : suns) {
      if (direction == towards)
        return tree;
    }
    if (suns.size() == kMaxSuns)
      suns.erase(suns.begin());
    suns.emplace_back(towards, std::make_shared<const SunTree>(triangles, towards));
    return suns.back().second;
  }

  static constexpr std::size_t kMaxSuns = 4;

  Execution execution = Execution::kFast;
  mutable std::mutex sunsMutex;
  mutable std::vector<std::pair<Vec3, std::shared_ptr<const SunTree>>> suns;
  mutable std::once_flag treeMade;
  mutable std::optional<TriangleTree> madeTree;
#if VOLUTE_HAS_EMBREE
  static constexpr std::size_t kManyTriangles = 1 << 14;

  /// Builds Embree's tree; that of many triangles beside what the caller does next.
  void buildEmbree() {
    const auto build = [this] { return EmbreeScene::make(triangles, bounds); };
    if (triangles.size() < kManyTriangles || threadCount() == 1)
      builtEmbree = build();
    else  // where no thread can be had, when it is asked for
      embreeComes = std::async(std::launch::async | std::launch::deferred, build);
  }

  /// Null where Embree does not answer. Waits for the tree.
  const EmbreeScene* embree() const {
    std::call_once(embreeThere, [&] {
      if (embreeComes.valid())
        builtEmbree = embreeComes.get();
    });
    return builtEmbree.get();
  }

  mutable std::once_flag embreeThere;
  mutable std::unique_ptr<const EmbreeScene> builtEmbree;
  /// Last: its thread uses the others.
  mutable std::future<std::unique_ptr<const EmbreeScene>> embreeComes;
#endif

  Hit nearest(const Segment& segment) const {
#if VOLUTE_HAS_EMBREE
    if (const EmbreeScene* fast = embree())
      return fast->nearest(segment);
#endif
    return tree().nearest(segment);
  }

  bool occluded(const Segment& segment) const {
#if VOLUTE_HAS_EMBREE
    if (const EmbreeScene* fast = embree())
      return fast->occluded(segment);
#endif
    return tree().occluded(segment);
  }
};

std::vector<Triangle> transformed(std::span<const Triangle> triangles, const Mat4& transform) {
  const Mat3 linear = transform.topLeftCorner<3, 3>();
  const Vec3 offset = transform.topRightCorner<3, 1>();
  std::vector<Triangle> moved(triangles.begin(), triangles.end());
  for (Triangle& triangle : moved) {
    for (Vec3& corner : triangle.corners) corner = linear * corner + offset;
  }
  return moved;
}

TriangleScene::TriangleScene()
    : impl_(std::make_shared<const Impl>(std::vector<Triangle>{}, std::vector<Material>{})) {}

Result<TriangleScene> TriangleScene::build(std::vector<Triangle> triangles,
                                           std::vector<Material> materials, Execution execution) {
  if (triangles.size() > (1ull << 31)) {
    return fail(ErrorCode::kTooLarge, "the geometry has {} triangles, more than 2^31",
                triangles.size());
  }
  if (materials.empty())
    materials.emplace_back();
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const Vec3& corner : triangles[i].corners) {
      if (!corner.allFinite())
        return fail(ErrorCode::kInvalidArgument, "triangle {} has a corner that is not finite", i);
    }
    if (triangles[i].material >= materials.size()) {
      return fail(ErrorCode::kInvalidArgument, "triangle {} names material {}, but there are {}", i,
                  triangles[i].material, materials.size());
    }
  }
  auto impl = std::make_shared<Impl>(std::move(triangles), std::move(materials));
#if VOLUTE_HAS_EMBREE
  if (execution == Execution::kFast && !impl->triangles.empty())
    impl->buildEmbree();
#endif
  impl->execution = execution;
  TriangleScene scene;
  scene.impl_ = std::move(impl);
  return scene;
}

void TriangleScene::nearest(std::span<const Segment> segments, std::span<Hit> hits) const {
  VOLUTE_ASSERT(segments.size() == hits.size());
#if VOLUTE_HAS_EMBREE
  if (const EmbreeScene* fast = impl_->embree())
    return fast->nearest(segments, hits);
#endif
  std::ranges::transform(segments, hits.begin(),
                         [&](const Segment& segment) { return impl_->nearest(segment); });
}

void TriangleScene::occluded(std::span<const Segment> segments,
                             std::span<std::uint8_t> blocked) const {
  VOLUTE_ASSERT(segments.size() == blocked.size());
  std::ranges::transform(segments, blocked.begin(),
                         [&](const Segment& segment) { return impl_->occluded(segment) ? 1 : 0; });
}

void TriangleScene::shadows(const Segment& segment, const LightPoint& light,
                            std::vector<Interval>& dark) const {
  if (light.far && impl_->execution == Execution::kFast) {
    shadowsOn(segment, light, *impl_->treeOf(light.place), *this, dark);
    return;
  }
  shadowsOn(segment, light, impl_->tree(), dark);
}

std::span<const Triangle> TriangleScene::triangles() const {
  return impl_->triangles;
}

std::span<const Material> TriangleScene::materials() const {
  return impl_->materials;
}

const Box3& TriangleScene::bounds() const {
  return impl_->bounds;
}

}  // namespace volute
