// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/tet_projector.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "volute/base/parallel.hpp"
#include "volute/gl/glsl_sources.hpp"
#include "volute/gl/raster_view.hpp"
#include "volute/gl/tet_project.hpp"
#include "volute/gl/weight_table.hpp"

namespace volute {
namespace {

constexpr int kTable = 512;  // points a side of the table of weights
constexpr std::size_t kGrain = 4096;
constexpr int kWeightsUnit = 1;

using Texel = std::array<float, 4>;

/// A tet's thick vertex from where the eye is.
struct Thick {
  float front[4] = {}, back[4] = {};  // shares of the four vertices
  float rest = 1;  // 1 - gap: w of the front / w of the back; 1 where orthographic
};

/// The triangles of a tet by classes, as TetProjector draws them.
struct Fan {
  std::int8_t triangles = 0;
  bool around = false;
  std::array<std::array<std::int8_t, 3>, 4> corners{};
};

GLenum formatOf(TetTarget target) {
  if (target == TetTarget::kFloat32)
    return GL_RGBA32F;
  return target == TetTarget::kFloat16 ? GL_RGBA16F : GL_RGBA8;
}

template <class T>
void upload(const GlBuffer& buffer, const std::vector<T>& values) {
  glNamedBufferSubData(buffer.name(), 0, static_cast<GLsizeiptr>(values.size() * sizeof(T)),
                       values.data());
}

Result<GlProgram> linked(const char* vertexFile, const char* vertex, const char* fragmentFile,
                         const char* fragment) {
  const ShaderStage stages[] = {{GL_VERTEX_SHADER, {{vertexFile, vertex}}},
                                {GL_FRAGMENT_SHADER, {{fragmentFile, fragment}}}};
  return GlProgram::link(stages);
}

}  // namespace

struct TetProjector::State {
  std::shared_ptr<const TetMesh> mesh;
  TetProjectorCounts counts;
  GlProgram tets, wall;
  GlTexture weights, target, opaque, depth;
  GlFramebuffer framebuffer;
  GlVertexArray arrays, noArrays;
  GlBuffer places, fields, indices;

  std::optional<TetEye> eye;  // of the sort and the projection
  TetOrder order;
  std::vector<Thick> thick;
  std::vector<Fan> fans;
  std::vector<Texel> smoke;  // extinction and source of each vertex
  std::vector<char> dark;    // tets without smoke

  bool fieldsNew = true, indicesNew = true;
  TetBlend blend = TetBlend::kBackToFront;
  TetTarget format = TetTarget::kFloat32;
  int width = 0, height = 0;
  std::vector<std::uint32_t> drawn;      // indices
  std::vector<std::int32_t> aroundTets;  // after `triangles` of the others
  std::size_t plainIndices = 0;

  State(std::shared_ptr<const TetMesh> of, GlProgram tetProgram, GlProgram wallProgram)
      : mesh(std::move(of)), tets(std::move(tetProgram)), wall(std::move(wallProgram)) {}

  void makeObjects();
  void project(const TetEye& from);
  void fillFields();
  void fillIndices(TetBlend order);
  void resize(const Camera& camera, TetTarget wanted);
  void setOpaque(std::span<const float> opaqueDepth);
  void drawWall(const RasterView& view);
  void drawTets(const RasterView& view, bool opaqueGiven, const TetProjectorOptions& options);
  Texel at(std::int32_t tet, const float* shares) const;
};

void TetProjector::State::makeObjects() {
  const std::size_t points = mesh->vertices().size() + mesh->tets().size();
  places = makeEmptyBuffer(points * sizeof(Texel));
  fields = makeEmptyBuffer(2 * points * sizeof(Texel));
  indices = makeEmptyBuffer(12 * mesh->tets().size() * sizeof(std::uint32_t));
  arrays = makeVertexArray();
  noArrays = makeVertexArray();
  framebuffer = makeFramebuffer();
  const GLuint name = arrays.name();
  glVertexArrayVertexBuffer(name, 0, places.name(), 0, sizeof(Texel));
  glVertexArrayVertexBuffer(name, 1, fields.name(), 0, 2 * sizeof(Texel));
  for (GLuint i = 0; i < 3; ++i) {
    glEnableVertexArrayAttrib(name, i);
    glVertexArrayAttribFormat(name, i, 4, GL_FLOAT, GL_FALSE, i == 2 ? sizeof(Texel) : 0);
    glVertexArrayAttribBinding(name, i, i == 0 ? 0 : 1);
  }
  glVertexArrayElementBuffer(name, indices.name());
  weights = makeTexture2d(GL_RG32F, kTable, kTable);
  glTextureParameteri(weights.name(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(weights.name(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(weights.name(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(weights.name(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  static const std::vector<float> kWeights = weightTable(kTable);
  glTextureSubImage2D(weights.name(), 0, 0, 0, kTable, kTable, GL_RG, GL_FLOAT, kWeights.data());
}

/// Sorts and projects for an eye: places of all vertices from it, and the thick vertices' shares.
void TetProjector::State::project(const TetEye& from) {
  order = sortTets(*mesh, from);
  eye = from;
  ++counts.sorts;
  counts.cycles = order.cycles, counts.parts = order.parts;
  const std::size_t vertices = mesh->vertices().size(), count = mesh->tets().size();
  thick.resize(count);
  fans.resize(count);
  std::vector<Texel> points(vertices + count);
  const auto put = [&](std::size_t i, const Vec3& place, double gap) {
    for (int axis = 0; axis < 3; ++axis) points[i][axis] = static_cast<float>(place[axis]);
    points[i][3] = static_cast<float>(gap);
  };
  for (std::size_t i = 0; i < vertices; ++i) put(i, mesh->vertices()[i] - from.point, 0);
  parallelRanges(count, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto tet = static_cast<std::int32_t>(t);
      const ProjectedTet seen = projectTet(eyeShares(*mesh, tet, from));
      fans[t] = {static_cast<std::int8_t>(seen.triangles), seen.shape == TetClass::kAround,
                 seen.corners};
      Vec3 front = Vec3::Zero(), back = Vec3::Zero();
      for (int k = 0; k < 4; ++k) {
        thick[t].front[k] = static_cast<float>(seen.front[k]);
        thick[t].back[k] = static_cast<float>(seen.back[k]);
        const Vec3 corner = mesh->vertices()[mesh->tets()[t][k]] - from.point;
        front += seen.front[k] * corner;
        back += seen.back[k] * corner;
      }
      const double length = (back - front).norm();
      const double gap = from.orthographic ? length : length / std::max(back.norm(), 1e-300);
      thick[t].rest = from.orthographic ? 1.0F : static_cast<float>(1 - gap);
      put(vertices + t, front, fans[t].around ? 0 : gap);
    }
  });
  upload(places, points);
  ++counts.uploads;
  fieldsNew = indicesNew = true;
}

Texel TetProjector::State::at(std::int32_t tet, const float* shares) const {
  Texel value{};
  for (int k = 0; k < 4; ++k) {
    const Texel& corner = smoke[mesh->tets()[tet][k]];
    for (int c = 0; c < 4; ++c) value[c] += shares[k] * corner[c];
  }
  return value;
}

void TetProjector::State::fillFields() {
  const std::size_t vertices = smoke.size(), count = thick.size();
  std::vector<std::array<Texel, 2>> values(vertices + count);
  for (std::size_t i = 0; i < vertices; ++i) values[i] = {smoke[i], smoke[i]};
  parallelRanges(count, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (dark[t])
        continue;
      auto& [front, back] = values[vertices + t];
      front = at(static_cast<std::int32_t>(t), thick[t].front);
      back = at(static_cast<std::int32_t>(t), thick[t].back);
      for (float& value : back) value *= thick[t].rest;
    }
  });
  upload(fields, values);
  ++counts.uploads;
  fieldsNew = false;
}

/// The tets that are not dark, in the order of blending; those around the eye are the nearest.
void TetProjector::State::fillIndices(TetBlend wanted) {
  blend = wanted;
  drawn.clear();
  aroundTets.clear();
  const auto vertices = static_cast<std::uint32_t>(mesh->vertices().size());
  const auto add = [&](std::int32_t t) {
    for (int i = 0; i < fans[t].triangles; ++i) {
      for (const std::int8_t corner : fans[t].corners[i]) {
        drawn.push_back(corner == ProjectedTet::kThick
                            ? vertices + static_cast<std::uint32_t>(t)
                            : static_cast<std::uint32_t>(mesh->tets()[t][corner]));
      }
    }
  };
  const std::size_t count = order.tets.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t t = order.tets[wanted == TetBlend::kBackToFront ? i : count - 1 - i];
    if (dark[t])
      continue;
    if (fans[t].around)
      aroundTets.push_back(t);
    else
      add(t);
  }
  plainIndices = drawn.size();
  for (const std::int32_t t : aroundTets) add(t);
  upload(indices, drawn);
  ++counts.uploads;
  indicesNew = false;
}

void TetProjector::State::resize(const Camera& camera, TetTarget wanted) {
  const bool sameFormat = formatOf(format) == formatOf(wanted);
  format = wanted;
  if (target && sameFormat && width == camera.width() && height == camera.height())
    return;
  width = camera.width(), height = camera.height();
  target = makeTexture2d(formatOf(format), width, height);
  depth = makeTexture2d(GL_DEPTH_COMPONENT32F, width, height);
  opaque = makeTexture2d(GL_R32F, width, height);
  glNamedFramebufferTexture(framebuffer.name(), GL_COLOR_ATTACHMENT0, target.name(), 0);
  glNamedFramebufferTexture(framebuffer.name(), GL_DEPTH_ATTACHMENT, depth.name(), 0);
}

void TetProjector::State::setOpaque(std::span<const float> opaqueDepth) {
  constexpr float kFarthest = 3e38F;
  std::vector<float> texels(opaqueDepth.begin(), opaqueDepth.end());
  for (float& s : texels) s = s < kFarthest ? s : kFarthest;
  glTextureSubImage2D(opaque.name(), 0, 0, 0, width, height, GL_RED, GL_FLOAT, texels.data());
}

/// Opaque depths into the depth buffer.
void TetProjector::State::drawWall(const RasterView& view) {
  wall.use();
  view.bind(wall);
  wall.set("opaque", 0);
  glBindTextureUnit(0, opaque.name());
  glBindVertexArray(noArrays.name());
  glDisable(GL_BLEND);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_ALWAYS);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void TetProjector::State::drawTets(const RasterView& view, bool opaqueGiven,
                                   const TetProjectorOptions& options) {
  tets.use();
  view.bind(tets);
  tets.set("opaque", 0);
  tets.set("opaqueGiven", opaqueGiven && options.cutAtWalls ? 1 : 0);
  tets.set("weights", kWeightsUnit);
  tets.set("dither", options.target == TetTarget::kFixed8Dithered ? 1 : 0);
  glBindTextureUnit(0, opaque.name());
  glBindTextureUnit(kWeightsUnit, weights.name());
  glBindVertexArray(arrays.name());
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  // Alpha is what passes: equations 10 and 11, or section 4.2's front to back.
  if (options.blend == TetBlend::kBackToFront)
    glBlendFuncSeparate(GL_ONE, GL_SRC_ALPHA, GL_ZERO, GL_SRC_ALPHA);
  else
    glBlendFuncSeparate(GL_DST_ALPHA, GL_ONE, GL_ZERO, GL_SRC_ALPHA);
  const auto drawOthers = [&] {
    tets.set("around", 0);
    glDepthFunc(opaqueGiven ? GL_GREATER : GL_ALWAYS);
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(plainIndices), GL_UNSIGNED_INT, nullptr);
  };
  const auto drawAround = [&] {
    tets.set("around", 1);
    glDepthFunc(GL_ALWAYS);
    for (std::size_t i = 0; i < aroundTets.size(); ++i) {
      tets.set("eyeField", at(aroundTets[i], thick[aroundTets[i]].front));
      const std::size_t first = plainIndices + 12 * i;
      glDrawElements(GL_TRIANGLES, 12, GL_UNSIGNED_INT,
                     reinterpret_cast<const void*>(first * sizeof(std::uint32_t)));
    }
  };
  if (options.blend == TetBlend::kFrontToBack)
    drawAround();
  drawOthers();
  if (options.blend == TetBlend::kBackToFront)
    drawAround();
}

TetProjector::TetProjector(std::unique_ptr<State> state) : state_(std::move(state)) {}

TetProjector::TetProjector(TetProjector&&) noexcept = default;
TetProjector& TetProjector::operator=(TetProjector&&) noexcept = default;
TetProjector::~TetProjector() = default;

Result<TetProjector> TetProjector::create(std::shared_ptr<const TetMesh> mesh) {
  VOLUTE_ASSIGN(auto tets, linked("tets_vertex.glsl", glsl::kTetsVertex, "tets_fragment.glsl",
                                  glsl::kTetsFragment));
  VOLUTE_ASSIGN(auto wall, linked("tets_wall_vertex.glsl", glsl::kTetsWallVertex,
                                  "tets_wall_fragment.glsl", glsl::kTetsWallFragment));
  auto state = std::make_unique<State>(std::move(mesh), std::move(tets), std::move(wall));
  state->makeObjects();
  TetProjector projector(std::move(state));
  const std::vector<float> clear(projector.state_->mesh->vertices().size());
  projector.setSmoke(clear, {});
  return projector;
}

void TetProjector::setSmoke(std::span<const float> extinction, std::span<const float> source) {
  State& state = *state_;
  std::vector<Texel> smoke(extinction.size());
  for (std::size_t i = 0; i < extinction.size(); ++i) {
    smoke[i] = {extinction[i], 0, 0, 0};
    if (!source.empty())
      std::copy_n(&source[3 * i], 3, smoke[i].begin() + 1);
  }
  if (smoke == state.smoke)
    return;
  state.smoke = std::move(smoke);
  std::vector<char> dark(state.mesh->tets().size());
  for (std::size_t t = 0; t < dark.size(); ++t) {
    dark[t] = std::ranges::all_of(state.mesh->tets()[t],
                                  [&](std::int32_t v) { return extinction[v] <= 0; });
  }
  state.indicesNew |= dark != state.dark;
  state.dark = std::move(dark);
  state.fieldsNew = true;
}

Status TetProjector::draw(const Camera& camera, std::span<const float> opaqueDepth,
                          const TetProjectorOptions& options, GlPasses& passes) {
  State& state = *state_;
  VOLUTE_ASSIGN(const auto view, RasterView::of(camera, state.mesh->bounds()));
  const TetEye eye = TetEye::of(camera);
  state.resize(camera, options.target);
  passes.run("sort and project", "smoke", [&] {
    if (!state.eye || !(*state.eye == eye))
      state.project(eye);
    if (state.fieldsNew)
      state.fillFields();
    if (state.indicesNew || state.blend != options.blend)
      state.fillIndices(options.blend);
    if (!opaqueDepth.empty())
      state.setOpaque(opaqueDepth);
  });
  passes.run("draw tetrahedra", "smoke", [&] {
    const RasterScope scope(state.framebuffer, state.width, state.height);
    const float clear[] = {0, 0, 0, 1};
    glClearNamedFramebufferfv(state.framebuffer.name(), GL_COLOR, 0, clear);
    if (!opaqueDepth.empty())
      state.drawWall(view);
    state.drawTets(view, !opaqueDepth.empty(), options);
  });
  ++state.counts.pictures;
  state.counts.triangles = static_cast<std::int64_t>(state.drawn.size() / 3);
  return {};
}

GLuint TetProjector::texture() const {
  return state_->target.name();
}

std::vector<float> TetProjector::read() const {
  std::vector<float> texels(4 * static_cast<std::size_t>(state_->width) * state_->height);
  glGetTextureImage(texture(), 0, GL_RGBA, GL_FLOAT,
                    static_cast<GLsizei>(texels.size() * sizeof(float)), texels.data());
  return texels;
}

const TetProjectorCounts& TetProjector::counts() const {
  return state_->counts;
}

}  // namespace volute
