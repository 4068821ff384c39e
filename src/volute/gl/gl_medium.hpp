// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/fog/fog_shader.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/gl/gl_scene.hpp"

namespace volute {

/// What is known of a medium's light before it is integrated.
struct GlNature {
  bool constant = false;  ///< in each cell
  bool absorbs = true;
  std::optional<Rgb> color{};  ///< emission / extinction, where that is one colour
  int points = 4;              ///< of Gauss' rule that integrate its extinction exactly
};

/// The next free texture unit; 0 to 2 are the ray's.
struct GlBindings {
  int texture = 3;
  int storage = 0;
};

/// What media need of a device.
struct GlNeeds {
  int textures = 0;
  int storage = 0;
  double cells = 0;          ///< that one ray may pass
  double roundsPerCell = 0;  ///< of loops, as llvmpipe counts them: measured, for it alone
};

/// From where a picture's rays are seen.
struct GlView {
  Vec3 origin = Vec3::Zero();  ///< what the rays' places are relative to [m]
  std::optional<Vec3> eye{};   ///< where all rays begin, if they do [m]
};

/// A medium on the device: functions for a shader that goes along a ray, and what they read. In its
/// parts M_ stands for a prefix that makes names unique, and so does a leading fog or FOG_.
class GlMedium {
 public:
  virtual ~GlMedium() = default;

  /// Media with the same key have the same parts: nothing in it changes with their values.
  virtual std::string key() const = 0;
  virtual std::vector<ShaderPart> parts() const = 0;
  virtual GlNature nature() const = 0;
  virtual GlNeeds needs() const = 0;
  virtual Box3 bounds() const = 0;  ///< [m]

  /// Before a picture.
  virtual void bind(const GlProgram& program, const std::string& prefix, const GlView& view,
                    GlBindings& bindings) const = 0;
};

/// What stays on the device between pictures.
class GlVolumeAtlas;
class GlTreeData;
class GlMesh;
class GlSmokeFields;
class GlFdsData;
struct GlTriangles;

struct GlFogMap {
  GlTexture texture;
};

[[nodiscard]] Result<std::shared_ptr<const GlVolumeAtlas>> makeVolumeAtlas(const BrickSlice& slice);
[[nodiscard]] Result<std::shared_ptr<const GlTreeData>> makeTreeData(const Tree4d& tree);

std::unique_ptr<GlMedium> makeGlVolume(const GlVolume& volume,
                                       std::shared_ptr<const GlVolumeAtlas> atlas);
std::unique_ptr<GlMedium> makeGlTreeVolume(const GlTreeVolume& volume,
                                           std::shared_ptr<const GlTreeData> tree);
[[nodiscard]] Result<std::shared_ptr<const GlMesh>> makeGlMesh(const TetMesh& mesh);

std::shared_ptr<const GlSmokeFields> makeGlSmokeFields(const GlSmoke& smoke);
/// Whether these are this smoke's extinction and source.
bool holds(const GlSmokeFields& fields, const GlSmoke& smoke);
std::unique_ptr<GlMedium> makeGlSmoke(const GlSmoke& smoke, std::shared_ptr<const GlMesh> mesh,
                                      std::shared_ptr<const GlSmokeFields> fields);

/// The texture fogMap of a fog and of all others with the same levels().
[[nodiscard]] Result<std::shared_ptr<const GlFogMap>> makeGlFogMap(const FogMedium& fog);
/// Of a walk through a fog, its suns left out.
GlNeeds fogNeeds(const FogShader& shader);
/// Gives a program the uniforms of fog/glsl/fog_walk.glsl, and the map at a texture unit.
void bindFog(const GlProgram& program, const std::string& prefix, const FogShader& shader,
             const Vec3& origin, int unit, const GlFogMap& map);
/// `factor`: of its extinction.
std::unique_ptr<GlMedium> makeGlFog(const FogMedium& fog, double factor,
                                    std::shared_ptr<const GlFogMap> map);
/// @param shade  the surfaces that shadow it. kUnsupported where it is shadowed by others.
[[nodiscard]] Result<std::unique_ptr<GlMedium>> makeGlFog(const SunlitFog& fog, double factor,
                                                          std::shared_ptr<const GlFogMap> map,
                                                          std::shared_ptr<const GlTriangles> shade);

/// kTooLarge where it does not fit into one of the device's buffers.
[[nodiscard]] Result<std::shared_ptr<const GlFdsData>> makeGlFdsData(const GlFds& fds);
/// Whether this is of the same lattices with the same values in the same light.
bool holds(const GlFdsData& data, const GlFds& fds);
std::unique_ptr<GlMedium> makeGlFds(const GlFds& fds, std::shared_ptr<const GlFdsData> data);

/// Puts a medium's own prefix into a part's text.
std::string withPrefix(const std::string& text, const std::string& prefix);

}  // namespace volute
