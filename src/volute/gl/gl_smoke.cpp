// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>

#include "volute/gl/face_tree.hpp"
#include "volute/gl/gl_medium.hpp"
#include "volute/gl/glsl_sources.hpp"

namespace volute {

/// A mesh without its fields.
class GlMesh {
 public:
  Vec3 middle = Vec3::Zero();
  GlBuffer places, tets, opposites, nodes, faces;
};

class GlSmokeFields {
 public:
  GlBuffer fields;
  std::vector<float> extinction, source;  ///< what they were made of
};

namespace {

/// What a ray through tets of about equal size takes at most.
double mostCells(const TetMesh& mesh) {
  return 4 * std::cbrt(static_cast<double>(mesh.tets().size()));
}

class SmokeOnDevice final : public GlMedium {
 public:
  SmokeOnDevice(const GlSmoke& smoke, std::shared_ptr<const GlMesh> mesh,
                std::shared_ptr<const GlSmokeFields> fields)
      : locator_(smoke.locator),
        mesh_(std::move(mesh)),
        fields_(std::move(fields)),
        black_(smoke.source.empty()) {}

  std::string key() const override { return "smoke"; }

  std::vector<ShaderPart> parts() const override { return {{"smoke.glsl", glsl::kSmoke}}; }

  GlNature nature() const override {
    GlNature nature;
    if (black_)
      nature = {.color = Rgb(Rgb::Zero()), .points = 2};
    return nature;
  }

  GlNeeds needs() const override {
    return {.storage = 6, .cells = mostCells(locator_->mesh()), .roundsPerCell = 12};
  }

  Box3 bounds() const override { return locator_->mesh().bounds(); }

  void bind(const GlProgram& program, const std::string& prefix, const GlView& view,
            GlBindings& bindings) const override {
    program.set((prefix + "origin").c_str(), Vec3(view.origin - mesh_->middle));
    program.set((prefix + "eyeTet").c_str(), view.eye ? locator_->find(*view.eye) : -1);
    const std::pair<const char*, const GlBuffer*> blocks[] = {
        {"Vertices", &mesh_->places},     {"Fields", &fields_->fields}, {"Tets", &mesh_->tets},
        {"Opposites", &mesh_->opposites}, {"Nodes", &mesh_->nodes},     {"Faces", &mesh_->faces}};
    for (const auto& [block, buffer] : blocks)
      program.bindStorage((prefix + block).c_str(), bindings.storage++, *buffer);
  }

 private:
  std::shared_ptr<const TetLocator> locator_;
  std::shared_ptr<const GlMesh> mesh_;
  std::shared_ptr<const GlSmokeFields> fields_;
  bool black_;
};

}  // namespace

Result<std::shared_ptr<const GlMesh>> makeGlMesh(const TetMesh& mesh) {
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  if (static_cast<std::int64_t>(16 * mesh.tets().size()) > most) {
    return fail(ErrorCode::kTooLarge,
                "a mesh of {} tetrahedra does not fit in the graphics device's buffers of {} MiB; "
                "render with --renderer cpu",
                mesh.tets().size(), most >> 20);
  }
  auto made = std::make_shared<GlMesh>();
  made->middle = mesh.bounds().centre();
  std::vector<std::array<float, 4>> places;
  for (const Vec3& vertex : mesh.vertices()) {
    const Vec3 place = vertex - made->middle;
    places.push_back({static_cast<float>(place.x()), static_cast<float>(place.y()),
                      static_cast<float>(place.z()), 0});
  }
  made->places = makeBuffer(places);
  made->tets = makeBuffer(mesh.tets());
  made->opposites = makeBuffer(mesh.opposites());
  const FaceTree tree(mesh, made->middle);
  static_assert(sizeof(FaceTree::Node) == 32);
  made->nodes = makeBuffer(tree.nodes);
  made->faces = makeBuffer(tree.faces);
  return made;
}

std::shared_ptr<const GlSmokeFields> makeGlSmokeFields(const GlSmoke& smoke) {
  auto made = std::make_shared<GlSmokeFields>();
  made->extinction = smoke.extinction;
  made->source = smoke.source;
  std::vector<std::array<float, 4>> fields(smoke.extinction.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    fields[i] = {smoke.extinction[i], 0, 0, 0};
    if (!smoke.source.empty())
      std::copy_n(&smoke.source[3 * i], 3, fields[i].begin() + 1);
  }
  made->fields = makeBuffer(fields);
  return made;
}

bool holds(const GlSmokeFields& fields, const GlSmoke& smoke) {
  return fields.extinction == smoke.extinction && fields.source == smoke.source;
}

std::unique_ptr<GlMedium> makeGlSmoke(const GlSmoke& smoke, std::shared_ptr<const GlMesh> mesh,
                                      std::shared_ptr<const GlSmokeFields> fields) {
  return std::make_unique<SmokeOnDevice>(smoke, std::move(mesh), std::move(fields));
}

}  // namespace volute
