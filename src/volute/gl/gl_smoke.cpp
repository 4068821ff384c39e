// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_smoke.hpp"

#include <algorithm>
#include <cmath>

#include "volute/gl/face_tree.hpp"
#include "volute/gl/gl_part.hpp"
#include "volute/gl/glsl_sources.hpp"
#include "volute/gl/tet_projector.hpp"

namespace volute {
namespace {

/// A mesh without its fields.
struct GlMesh {
  Vec3 middle = Vec3::Zero();
  GlBuffer places, tets, opposites, nodes, faces;
};

struct GlSmokeFields {
  GlBuffer fields;
  std::vector<float> extinction, source;  ///< what they were made of
};

/// What a ray through tets of about equal size takes at most.
double maxCells(const TetMesh& mesh) {
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

  GlMediumTraits traits() const override {
    GlMediumTraits traits;
    if (black_)
      traits = {.color = Rgb(Rgb::Zero()), .points = 2};
    return traits;
  }

  GlNeeds needs() const override {
    return {.storage = 6, .cells = maxCells(locator_->mesh()), .roundsPerCell = 12};
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

Result<GlMesh> makeMesh(const TetMesh& mesh) {
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  if (static_cast<std::int64_t>(16 * mesh.tets().size()) > most) {
    return fail(ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
                "a mesh of {} tetrahedra does not fit in the graphics device's buffers of {} MiB",
                mesh.tets().size(), most >> 20);
  }
  GlMesh made;
  made.middle = mesh.bounds().centre();
  std::vector<std::array<float, 4>> places;
  for (const Vec3& vertex : mesh.vertices()) {
    const Vec3 place = vertex - made.middle;
    places.push_back({static_cast<float>(place.x()), static_cast<float>(place.y()),
                      static_cast<float>(place.z()), 0});
  }
  made.places = makeBuffer(places);
  made.tets = makeBuffer(mesh.tets());
  made.opposites = makeBuffer(mesh.opposites());
  const FaceTree tree(mesh, made.middle);
  static_assert(sizeof(FaceTree::Node) == 32);
  made.nodes = makeBuffer(tree.nodes);
  made.faces = makeBuffer(tree.faces);
  return made;
}

Result<GlSmokeFields> makeSmokeFields(const GlSmoke& smoke) {
  GlSmokeFields made;
  made.extinction = smoke.extinction;
  made.source = smoke.source;
  std::vector<std::array<float, 4>> fields(smoke.extinction.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    fields[i] = {smoke.extinction[i], 0, 0, 0};
    if (!smoke.source.empty())
      std::copy_n(&smoke.source[3 * i], 3, fields[i].begin() + 1);
  }
  made.fields = makeBuffer(fields);
  return made;
}

/// In sizes of the mesh: from farther eyes projected tetrahedra, whose places are floats from the
/// eye, are off by more than 5e-4 of the brightest, and smoke is marched.
constexpr double kFarthestSizes = 300;

bool isFar(const TetMesh& mesh, const Camera& camera) {
  const Box3 box = mesh.bounds();
  return (camera.eye() - box.centre()).norm() > kFarthestSizes * box.size().norm();
}

class SmokePart final : public GlPart {
 public:
  explicit SmokePart(GlSmoke smoke) : smoke_(std::move(smoke)) {}

  std::string name() const override { return "smoke"; }

  Result<std::unique_ptr<GlMedium>> medium(const GlPicture& picture) const override {
    VOLUTE_ASSIGN(auto mesh, picture.resources.upload<GlMesh>(smoke_.locator, name(), [&] {
      return makeMesh(smoke_.locator->mesh());
    }));
    const auto holds = [&](const GlSmokeFields& made) {
      return made.extinction == smoke_.extinction && made.source == smoke_.source;
    };
    VOLUTE_ASSIGN(auto fields,
                  picture.resources.upload<GlSmokeFields>(
                      smoke_.locator, name(), [&] { return makeSmokeFields(smoke_); }, holds));
    return std::make_unique<SmokeOnDevice>(smoke_, std::move(mesh), std::move(fields));
  }

  Status drawAlone(const GlPicture& picture, const GlTarget& target) const override {
    return isProjected(picture) ? project(picture, target) : GlPart::drawAlone(picture, target);
  }

  std::shared_ptr<const GlPart> scaled(double factor) const override {
    GlSmoke smoke = smoke_;
    for (float& value : smoke.extinction) value = static_cast<float>(factor * value);
    return glPart(std::move(smoke));
  }

 private:
  std::shared_ptr<const TetMesh> mesh() const { return {smoke_.locator, &smoke_.locator->mesh()}; }

  bool isProjected(const GlPicture& picture) const {
    const bool software = !picture.resources.device.hardware;
    const bool asked = smoke_.method == GlSmokeMethod::kProject ||
                       (smoke_.method == GlSmokeMethod::kAuto && software);
    return asked && picture.camera.distortion().none() &&
           !isFar(smoke_.locator->mesh(), picture.camera);
  }

  Status project(const GlPicture& picture, const GlTarget& target) const;

  GlSmoke smoke_;
};

Status SmokePart::project(const GlPicture& picture, const GlTarget& target) const {
  GlResources& resources = picture.resources;
  VOLUTE_ASSIGN(const auto made, resources.upload<TetProjector>(smoke_.locator, name(), [&] {
    return TetProjector::create(mesh());
  }));
  VOLUTE_ASSIGN(const GlProgram* resolve,
                resources.programs.get("resolve", name(), resources.passes, [] {
                  return std::vector<ShaderPart>{{"resolve.glsl", glsl::kResolve}};
                }));
  made->setSmoke(smoke_.extinction, smoke_.source);
  VOLUTE_TRY(made->draw(picture.camera, target.opaqueDepth, {}, resources.passes));
  resources.passes.run("resolve", name(), [&] {
    resolve->set("blended", 0);
    glBindTextureUnit(0, made->texture());
    glBindImageTexture(0, target.picture, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    runOver(*resolve, picture.camera.width(), picture.camera.height());
  });
  const TetProjectorCounts& tets = made->counts();
  resources.counts["projected_tetrahedra"] = {{"sorts", tets.sorts},
                                              {"uploads", tets.uploads},
                                              {"pictures", tets.pictures},
                                              {"triangles", tets.triangles}};
  return {};
}

}  // namespace

std::shared_ptr<const GlPart> glPart(GlSmoke smoke) {
  return std::make_shared<SmokePart>(std::move(smoke));
}

}  // namespace volute
