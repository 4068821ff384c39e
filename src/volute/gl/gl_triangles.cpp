// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_triangles.hpp"

#include <algorithm>
#include <array>

#include "volute/base/parallel.hpp"
#include "volute/gl/box_tree.hpp"

namespace volute {

namespace {

/// Normals of the curved surfaces that triangles stand for, at their corners.
std::vector<Texel> normalsOf(const TriangleScene& scene) {
  const auto triangles = scene.triangles();
  std::vector<Texel> normals(3 * triangles.size(), Texel{});
  parallelRanges(triangles.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = std::max(begin, scene.flat().size()); i < end; ++i) {
      const CurvedSurface& surface = *scene.surfaceOf(i);
      const Vec3 across = triangles[i].normal();
      for (std::size_t k = 0; k < 3 && across.norm() > 0; ++k) {
        const Segment there{triangles[i].corners[k], across.normalized(), 0, 1};
        normals[3 * i + k] =
            texel(surface.outward(there, 0), static_cast<float>(surface.roughness()));
      }
    }
  });
  return normals;
}

}  // namespace

Result<GlTriangles> GlTriangles::make(std::span<const Triangle> triangles) {
  return make(triangles, {});
}

Result<GlTriangles> GlTriangles::make(const TriangleScene& scene) {
  return make(scene.triangles(), scene.curved().empty() ? std::vector<Texel>() : normalsOf(scene));
}

Result<GlTriangles> GlTriangles::make(std::span<const Triangle> triangles,
                                      std::span<const Texel> normals) {
  using Corner = std::array<double, 4>;
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  if (std::cmp_greater(3 * triangles.size() * sizeof(Corner), most)) {
    return fail(ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
                "{} triangles do not fit in the graphics device's buffers of {} MiB",
                triangles.size(), most >> 20);
  }
  GlTriangles made;
  Box3 bounds;
  for (const Triangle& triangle : triangles) {
    for (const Vec3& corner : triangle.corners) bounds.extend(corner);
  }
  made.bounds = bounds;
  if (!triangles.empty())
    made.middle = bounds.centre();
  std::vector<Box3> boxes;
  for (const Triangle& triangle : triangles) {
    Box3 box;
    for (const Vec3& corner : triangle.corners) {
      box.extend(corner - made.middle);
      made.reach = std::max(made.reach, (corner - made.middle).norm());
    }
    boxes.push_back(box);
  }
  const BoxTree tree(boxes);
  std::vector<Corner> corners;
  for (const std::int32_t item : tree.items) {
    const Triangle& triangle = triangles[static_cast<std::size_t>(item)];
    for (const Vec3& corner : triangle.corners) {
      const Vec3 at = corner - made.middle;
      corners.push_back({at.x(), at.y(), at.z(), static_cast<double>(triangle.material)});
    }
  }
  made.nodes = makeBuffer(std::span<const BoxTree::Node>(tree.nodes));
  made.corners = makeBuffer(std::span<const Corner>(corners));
  std::vector<Texel> inOrder(1, Texel{});  // no buffer may be empty
  if (!normals.empty()) {
    inOrder.clear();
    for (const std::int32_t item : tree.items)
      for (std::size_t k = 0; k < 3; ++k)
        inOrder.push_back(normals[3 * static_cast<std::size_t>(item) + k]);
  }
  made.normals = makeBuffer(std::span<const Texel>(inOrder));
  made.smooth = !normals.empty();
  return made;
}

void GlTriangles::bind(const GlProgram& program, const Vec3& origin, Sides sides) const {
  program.bindStorage("Nodes", 0, nodes);
  program.bindStorage("Corners", 1, corners);
  program.setExactly("originInGeometry", Vec3(origin - middle));
  program.set("sides", static_cast<int>(sides));
}

}  // namespace volute
