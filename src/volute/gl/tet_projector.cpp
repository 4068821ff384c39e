// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/tet_projector.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "volute/base/parallel.hpp"
#include "volute/gl/glsl_sources.hpp"
#include "volute/gl/raster_view.hpp"
#include "volute/gl/tet_project.hpp"
#include "volute/gl/texel.hpp"
#include "volute/gl/weight_table.hpp"

namespace volute {
namespace {

constexpr int kTable = 512;  // points a side of the table of weights
constexpr std::size_t kGrain = 4096;
constexpr int kOpaqueUnit = 0, kWeightsUnit = 1, kPlacesUnit = 2, kTetsUnit = 3, kOutlinesUnit = 4,
              kFieldsUnit = 5;

/// Corners of a tet's cover, two triangles, as tets_vertex.glsl numbers them.
constexpr std::uint32_t kCover[] = {0, 1, 2, 0, 2, 3};

/// A ProjectedTet as tets_vertex.glsl reads it.
std::uint16_t packed(const ProjectedTet& tet) {
  int bits = tet.sides << 8;
  for (int i = 0; i < 4; ++i) bits |= tet.corners[i] << 2 * i;
  return static_cast<std::uint16_t>(bits);
}

GlTexture textureOf(const GlBuffer& buffer, GLenum format) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &name);
  glTextureBuffer(name, format, buffer.name());
  return GlTexture(name);
}

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
  GlBuffer places, tetVertices, outlines, fields, indices;
  GlTexture placesTexture, tetsTexture, outlinesTexture, fieldsTexture;  // of these buffers
  GLint gridBits = 4;  // of the rasteriser: a pixel has 2^gridBits places along each axis

  FacePlanes faces;
  std::optional<ViewOrigin> eye;    // of the sort and the projection
  std::vector<std::int32_t> order;  // front to back
  std::vector<std::uint16_t> seen;  // outlines
  std::vector<Texel> smoke;         // extinction and source of each vertex
  std::vector<char> dark;           // tets without smoke

  bool fieldsNew = true, indicesNew = true;
  TetBlend blend = TetBlend::kBackToFront;
  TetTarget format = TetTarget::kFloat32;
  int width = 0, height = 0;
  std::vector<std::uint32_t> drawn;  // indices

  State(std::shared_ptr<const TetMesh> of, GlProgram tetProgram, GlProgram wallProgram)
      : mesh(std::move(of)),
        tets(std::move(tetProgram)),
        wall(std::move(wallProgram)),
        faces(*mesh) {}

  void makeObjects();
  void project(const ViewOrigin& from);
  void fillIndices(TetBlend order);
  void resize(const Camera& camera, TetTarget wanted);
  void setOpaque(std::span<const float> opaqueDepth);
  void drawWall(const RasterView& view);
  void drawTets(const RasterView& view, bool opaqueGiven, const TetProjectorOptions& options);
};

void TetProjector::State::makeObjects() {
  const std::size_t vertices = mesh->vertices().size(), count = mesh->tets().size();
  places = makeEmptyBuffer(vertices * sizeof(Texel));
  fields = makeEmptyBuffer(vertices * sizeof(Texel));
  tetVertices = makeBuffer(mesh->tets());
  outlines = makeEmptyBuffer(count * sizeof(std::uint16_t));
  indices = makeEmptyBuffer(std::size(kCover) * count * sizeof(std::uint32_t));
  placesTexture = textureOf(places, GL_RGBA32F);
  fieldsTexture = textureOf(fields, GL_RGBA32F);
  tetsTexture = textureOf(tetVertices, GL_RGBA32I);
  outlinesTexture = textureOf(outlines, GL_R16UI);
  arrays = makeVertexArray();
  noArrays = makeVertexArray();
  framebuffer = makeFramebuffer();
  glVertexArrayElementBuffer(arrays.name(), indices.name());
  glGetIntegerv(GL_SUBPIXEL_BITS, &gridBits);
  weights = makeTexture2d(GL_RG32F, kTable, kTable);
  glTextureParameteri(weights.name(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(weights.name(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(weights.name(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(weights.name(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  static const std::vector<float> kWeights = weightTable(kTable);
  glTextureSubImage2D(weights.name(), 0, 0, 0, kTable, kTable, GL_RG, GL_FLOAT, kWeights.data());
}

/// Sorts and projects for an eye: places of all vertices from it, and the tets' outlines.
void TetProjector::State::project(const ViewOrigin& from) {
  order = visibilityOrder(*mesh, faces, from);
  eye = from;
  ++counts.sorts;
  std::vector<Texel> points;
  points.reserve(mesh->vertices().size());
  for (const Vec3& vertex : mesh->vertices()) {
    const VecN<float, 3> place = (vertex - from.eye).cast<float>();
    points.push_back({place.x(), place.y(), place.z(), 1});
  }
  seen.resize(mesh->tets().size());
  parallelRanges(seen.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      seen[t] = packed(projectTet(eyeShares(*mesh, static_cast<std::int32_t>(t), from)));
  });
  upload(places, points);
  upload(outlines, seen);
  ++counts.uploads;
  indicesNew = true;
}

/// The tets that are not dark, in the order of blending; those around the eye are the nearest.
void TetProjector::State::fillIndices(TetBlend wanted) {
  blend = wanted;
  drawn.clear();
  const auto add = [&](std::int32_t t) {
    for (const std::uint32_t corner : kCover)
      drawn.push_back(4 * static_cast<std::uint32_t>(t) + corner);
  };
  const std::uint16_t eyeInside = packed({});
  std::vector<std::int32_t> around;
  for (const std::int32_t t : order) {
    if (!dark[t] && seen[t] == eyeInside)
      around.push_back(t);
  }
  if (wanted == TetBlend::kFrontToBack)
    std::ranges::for_each(around, add);
  const std::size_t count = order.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t t = order[wanted == TetBlend::kFrontToBack ? i : count - 1 - i];
    if (!dark[t] && seen[t] != eyeInside)
      add(t);
  }
  if (wanted == TetBlend::kBackToFront)
    std::ranges::for_each(around, add);
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
  tets.set("toRay", Mat3(view.toImage.inverse()));
  // Where a corner may be: on the grid beside, or off by float's rounding.
  tets.set("margin", static_cast<float>(std::ldexp(4, -gridBits) + 1e-6 * std::max(width, height)));
  tets.set("opaqueGiven", opaqueGiven && options.cutAtWalls ? 1 : 0);
  tets.set("dither", options.target == TetTarget::kFixed8Dithered ? 1 : 0);
  for (const auto& [name, unit, texture] :
       {std::tuple<const char*, int, const GlTexture*>{"opaque", kOpaqueUnit, &opaque},
        {"weights", kWeightsUnit, &weights},
        {"places", kPlacesUnit, &placesTexture},
        {"tets", kTetsUnit, &tetsTexture},
        {"outlines", kOutlinesUnit, &outlinesTexture},
        {"fields", kFieldsUnit, &fieldsTexture}}) {
    tets.set(name, unit);
    glBindTextureUnit(static_cast<GLuint>(unit), texture->name());
  }
  glBindVertexArray(arrays.name());
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  // Alpha is what passes: equations 10 and 11, or section 4.2's front to back.
  if (options.blend == TetBlend::kBackToFront)
    glBlendFuncSeparate(GL_ONE, GL_SRC_ALPHA, GL_ZERO, GL_SRC_ALPHA);
  else
    glBlendFuncSeparate(GL_DST_ALPHA, GL_ONE, GL_ZERO, GL_SRC_ALPHA);
  glDepthFunc(opaqueGiven ? GL_GEQUAL : GL_ALWAYS);
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(drawn.size()), GL_UNSIGNED_INT, nullptr);
}

TetProjector::TetProjector(std::unique_ptr<State> state) : state_(std::move(state)) {}

TetProjector::TetProjector(TetProjector&&) noexcept = default;
TetProjector& TetProjector::operator=(TetProjector&&) noexcept = default;
TetProjector::~TetProjector() = default;

Result<TetProjector> TetProjector::create(std::shared_ptr<const TetMesh> mesh) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
  if (std::max(mesh->tets().size(), mesh->vertices().size()) > static_cast<std::size_t>(most)) {
    return fail(ErrorCode::kTooLarge,
                "a mesh of {} tetrahedra is not projected on a graphics device whose textures of "
                "buffers have {} texels; march it",
                mesh->tets().size(), most);
  }
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
  const ViewOrigin eye = ViewOrigin::of(camera);
  state.resize(camera, options.target);
  passes.run("sort and project", "smoke", [&] {
    if (!state.eye || !(*state.eye == eye))
      state.project(eye);
    if (state.fieldsNew) {
      upload(state.fields, state.smoke);
      ++state.counts.uploads;
      state.fieldsNew = false;
    }
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
