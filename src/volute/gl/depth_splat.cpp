// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/depth_splat.hpp"

#include <Eigen/Geometry>
#include <vector>

#include "volute/base/parallel.hpp"
#include "volute/gl/glsl_sources.hpp"
#include "volute/gl/raster_view.hpp"
#include "volute/gl/texel.hpp"

namespace volute {
namespace {

/// Smoke that cannot reach this optical depth across the whole mesh is left out, as in TetSplat.
constexpr double kNegligible = 1e-8;

/// Rays so near to a plane of the boundary are in it, as a share of the mesh's size: float's
/// rounding.
constexpr double kGrazing = 1e-6;

/// A face's normal into its first tet, and its distance from `middle`.
Texel planeOf(const TetMesh& mesh, const TetFace& face, const Vec3& middle) {
  const Vec3 corner = mesh.vertices()[face.vertices[0]] - middle;
  Vec3 normal = (mesh.vertices()[face.vertices[1]] - middle - corner)
                    .cross(mesh.vertices()[face.vertices[2]] - middle - corner)
                    .normalized();
  const Vec3 apex = mesh.vertices()[mesh.tets()[face.first / 4][face.first % 4]] - middle;
  if (normal.dot(apex - corner) < 0)
    normal = -normal;
  return texel(normal, normal.dot(corner));
}

/// Four times the face across each vertex, + 1 for the face's second tet, + 2 on the boundary.
std::vector<Tet> facesOfTets(const TetMesh& mesh) {
  std::vector<Tet> across(mesh.tets().size());
  for (std::size_t f = 0; f < mesh.faces().size(); ++f) {
    const TetFace& face = mesh.faces()[f];
    const bool boundary = face.second == TetMesh::kBoundary;
    const auto number = static_cast<std::int32_t>(4 * f);
    across[face.first / 4][face.first % 4] = number + (boundary ? 2 : 0);
    if (!boundary)
      across[face.second / 4][face.second % 4] = number + 1;
  }
  return across;
}

}  // namespace

DepthSplat::DepthSplat(std::shared_ptr<const TetMesh> mesh, GlProgram program)
    : mesh_(std::move(mesh)),
      program_(std::move(program)),
      middle_(mesh_->bounds().centre()),
      negligible_(static_cast<float>(kNegligible / mesh_->bounds().size().norm())),
      grazing_(static_cast<float>(kGrazing * mesh_->bounds().size().norm())),
      tets_(makeBuffer(mesh_->tets())),
      extinctions_(makeEmptyBuffer(mesh_->vertices().size() * sizeof(float))),
      framebuffer_(makeFramebuffer()),
      arrays_(makeVertexArray()) {
  std::vector<Texel> places, planes(mesh_->faces().size());
  for (const Vec3& vertex : mesh_->vertices()) places.push_back(texel(vertex - middle_));
  parallelRanges(planes.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f)
      planes[f] = planeOf(*mesh_, mesh_->faces()[f], middle_);
  });
  places_ = makeBuffer(places);
  planes_ = makeBuffer(planes);
  tetFaces_ = makeBuffer(std::span<const Tet>(facesOfTets(*mesh_)));
}

Result<DepthSplat> DepthSplat::create(std::shared_ptr<const TetMesh> mesh) {
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  if (static_cast<std::int64_t>(sizeof(Texel) * mesh->faces().size()) > most) {
    return fail(ErrorCode::kTooLarge,
                "a mesh of {} tetrahedra does not fit in the graphics device's buffers of {} MiB",
                mesh->tets().size(), most >> 20);
  }
  const ShaderStage stages[] = {
      {GL_VERTEX_SHADER, {{"splat_vertex.glsl", glsl::kSplatVertex}}},
      {GL_FRAGMENT_SHADER, {{"splat_fragment.glsl", glsl::kSplatFragment}}}};
  VOLUTE_ASSIGN(auto program, GlProgram::link(stages));
  return DepthSplat(std::move(mesh), std::move(program));
}

void DepthSplat::setExtinction(std::span<const float> extinction) {
  extinction_.assign(extinction.begin(), extinction.end());
  glNamedBufferSubData(extinctions_.name(), 0, static_cast<GLsizeiptr>(extinction.size_bytes()),
                       extinction.data());
}

Status DepthSplat::add(const Camera& camera, GLuint opaque, GLuint picture) {
  VOLUTE_ASSIGN(const auto view, RasterView::of(camera, mesh_->bounds()));
  glNamedFramebufferTexture(framebuffer_.name(), GL_COLOR_ATTACHMENT0, picture, 0);
  const RasterScope scope(framebuffer_, camera.width(), camera.height());
  program_.use();
  view.bind(program_);
  program_.set("eye", Vec3(camera.eye() - middle_));
  program_.set("forward", camera.forward());
  program_.set("negligible", negligible_);
  program_.set("grazing", grazing_);
  program_.set("opaqueGiven", opaque != 0 ? 1 : 0);
  program_.set("opaque", 0);
  glBindTextureUnit(0, opaque);
  int binding = 0;
  for (const auto& [block, buffer] : {std::pair<const char*, const GlBuffer*>{"Places", &places_},
                                      {"Extinctions", &extinctions_},
                                      {"Tets", &tets_},
                                      {"Planes", &planes_},
                                      {"TetFaces", &tetFaces_}})
    program_.bindStorage(block, binding++, *buffer);
  glBindVertexArray(arrays_.name());
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(mesh_->tets().size()));
  return {};
}

}  // namespace volute
