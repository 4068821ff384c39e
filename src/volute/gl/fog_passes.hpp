// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/fog/fog_shader.hpp"
#include "volute/gl/gl_fog.hpp"
#include "volute/gl/gl_part.hpp"

namespace volute {

struct GlFogMap {
  GlTexture texture;
};

/// The texture fogMap of a fog and of all others with the same levels().
[[nodiscard]] Result<std::shared_ptr<GlFogMap>> fogMapOf(const FogMedium& fog,
                                                         GlResources& resources);

/// Of a walk through a fog, its suns left out.
GlNeeds fogNeeds(const FogShader& shader);

/// Gives a program the uniforms of fog/glsl/fog_walk.glsl, and the map at a texture unit.
void bindFog(const GlProgram& program, const std::string& prefix, const FogShader& shader,
             const Vec3& origin, int unit, const GlFogMap& map);

/// A picture of fog alone that no sun lights, with nothing of what a march through any media
/// carries along: walked as fog_walk.glsl has it, or by two look-ups a pixel as PolarFog has it, in
/// a table that is filled on the device anew for each eye and each map. kUnsupported, before
/// anything is drawn, where fog has to be marched: with a top, with levels by angle, from an eye
/// far away or none. kCancelled between parts.
[[nodiscard]] Status drawFogAlone(const GlFog& fog, const GlPicture& picture,
                                  const GlTarget& target);

}  // namespace volute
