// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/triangle_scene.hpp"

#include <algorithm>
#include <future>
#include <iterator>
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
  explicit Impl(TriangleMesh mesh)
      : triangles(std::move(mesh.triangles)),
        materials(std::move(mesh.materials)),
        curved(std::move(mesh.curved)) {
    for (const Triangle& triangle : triangles) {
      for (const Vec3& corner : triangle.corners) flatBounds.extend(corner);
    }
    bounds = flatBounds;
    for (const CurvedPart& part : curved) {
      const Box3& box = part.surface->bounds();
      if (!box.empty())
        bounds.extend(box);
    }
  }

  std::vector<Triangle> triangles;
  std::vector<Material> materials;
  std::vector<CurvedPart> curved;
  Box3 flatBounds, bounds;

  /// Trees are made when somebody needs them first: where Embree answers, only shadows of lamps
  /// do, and a million triangles take a second.
  const TriangleTree& tree() const {
    std::call_once(treeMade, [&] { madeTree.emplace(triangles); });
    return *madeTree;
  }

  /// Curved surfaces as triangles, after the others.
  std::span<const Triangle> all() const {
    if (curved.empty())
      return triangles;
    std::call_once(allMade, [&] {
      madeAll = triangles;
      for (const CurvedPart& part : curved) {
        part.surface->addTriangles(part.material, madeAll);
        ends.push_back(madeAll.size());
      }
    });
    return madeAll;
  }

  const TriangleTree& treeOfAll() const {
    if (curved.empty())
      return tree();
    std::call_once(treeOfAllMade, [&] { madeTreeOfAll.emplace(all()); });
    return *madeTreeOfAll;
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
    suns.emplace_back(towards, std::make_shared<const SunTree>(all(), towards));
    return suns.back().second;
  }

  static constexpr std::size_t kMaxSuns = 4;

  Execution execution = Execution::kFast;
  mutable std::mutex sunsMutex;
  mutable std::vector<std::pair<Vec3, std::shared_ptr<const SunTree>>> suns;
  mutable std::once_flag treeMade, allMade, treeOfAllMade;
  mutable std::optional<TriangleTree> madeTree, madeTreeOfAll;
  mutable std::vector<Triangle> madeAll;
  mutable std::vector<std::size_t> ends;  ///< of each curved surface in them
#if VOLUTE_HAS_EMBREE
  static constexpr std::size_t kManyTriangles = 1 << 14;

  /// Builds Embree's tree; that of many triangles beside what the caller does next.
  void buildEmbree() {
    const auto build = [this] { return EmbreeScene::make(triangles, flatBounds); };
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
    Hit hit = nearestFlat(segment);
    addCurved(segment, hit);
    return hit;
  }

  /// What curved surfaces have before a hit.
  void addCurved(const Segment& segment, Hit& hit) const {
    for (std::size_t i = 0; i < curved.size(); ++i) {
      Segment before = segment;
      before.end = std::min(segment.end, hit.distance);
      if (const auto distance = curved[i].surface->nearest(before))
        hit = {*distance, Hit::kCurved + static_cast<std::uint32_t>(i)};
    }
  }

  bool occluded(const Segment& segment) const {
    return occludedFlat(segment) || std::ranges::any_of(curved, [&](const CurvedPart& part) {
             return part.surface->nearest(segment).has_value();
           });
  }

 private:
  Hit nearestFlat(const Segment& segment) const {
#if VOLUTE_HAS_EMBREE
    if (const EmbreeScene* fast = embree())
      return fast->nearest(segment);
#endif
    return tree().nearest(segment);
  }

  bool occludedFlat(const Segment& segment) const {
#if VOLUTE_HAS_EMBREE
    if (const EmbreeScene* fast = embree())
      return fast->occluded(segment);
#endif
    return tree().occluded(segment);
  }
};

std::vector<Triangle> transformed(std::span<const Triangle> triangles, const Mat4& transform) {
  const Mat3 linear = linearPart(transform);
  const Vec3 offset = offsetPart(transform);
  std::vector<Triangle> moved(triangles.begin(), triangles.end());
  for (Triangle& triangle : moved) {
    for (Vec3& corner : triangle.corners) corner = linear * corner + offset;
  }
  return moved;
}

void append(TriangleMesh& to, TriangleMesh mesh) {
  const auto first = static_cast<std::uint32_t>(to.materials.size());
  for (Triangle& triangle : mesh.triangles) triangle.material += first;
  for (CurvedPart& part : mesh.curved) part.material += first;
  to.triangles.insert(to.triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
  to.materials.insert(to.materials.end(), mesh.materials.begin(), mesh.materials.end());
  std::ranges::move(mesh.curved, std::back_inserter(to.curved));
}

TriangleScene::TriangleScene() : impl_(std::make_shared<const Impl>(TriangleMesh())) {}

Result<TriangleScene> TriangleScene::build(std::vector<Triangle> triangles,
                                           std::vector<Material> materials, Execution execution) {
  return of(TriangleMesh{std::move(triangles), std::move(materials)}, execution);
}

Result<TriangleScene> TriangleScene::of(TriangleMesh mesh, Execution execution) {
  const auto& triangles = mesh.triangles;
  auto& materials = mesh.materials;
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
  for (const CurvedPart& part : mesh.curved) {
    if (part.material >= materials.size())
      return fail(ErrorCode::kInvalidArgument, "a surface names material {}, but there are {}",
                  part.material, materials.size());
  }
  auto impl = std::make_shared<Impl>(std::move(mesh));
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
  if (const EmbreeScene* fast = impl_->embree()) {
    fast->nearest(segments, hits);
    for (std::size_t i = 0; i < hits.size() && !impl_->curved.empty(); ++i)
      impl_->addCurved(segments[i], hits[i]);
    return;
  }
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
  shadowsOn(segment, light, impl_->treeOfAll(), dark);
}

std::span<const Triangle> TriangleScene::triangles() const {
  return impl_->all();
}

const CurvedSurface* TriangleScene::surfaceOf(std::size_t triangle) const {
  if (triangle < impl_->triangles.size())
    return nullptr;
  const auto all = impl_->all();
  VOLUTE_ASSERT(triangle < all.size());
  const auto end = std::ranges::upper_bound(impl_->ends, triangle);
  return impl_->curved[static_cast<std::size_t>(end - impl_->ends.begin())].surface.get();
}

std::span<const Triangle> TriangleScene::flat() const {
  return impl_->triangles;
}

std::span<const CurvedPart> TriangleScene::curved() const {
  return impl_->curved;
}

std::span<const Material> TriangleScene::materials() const {
  return impl_->materials;
}

const Box3& TriangleScene::bounds() const {
  return impl_->bounds;
}

}  // namespace volute
