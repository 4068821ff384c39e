// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/gl/gl_program.hpp"
#include "volute/math/box.hpp"

namespace volute {

/// What is known of a medium's light before it is integrated.
struct GlMediumTraits {
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
/// parts M_ stands for a prefix that makes names unique.
class GlMedium {
 public:
  virtual ~GlMedium() = default;

  /// Media with the same key have the same parts: nothing in it changes with their values.
  virtual std::string key() const = 0;

  /// What march.glsl and the main function of the scene's shader call:
  ///   void M_begin()   once for each ray, after castRay(): sets M_end and M_on
  ///   float M_end      where on the ray the medium changes next, FARTHEST where it never does
  ///   bool M_on        whether it is there until then
  ///   void M_next()    goes on behind M_end
  ///   void M_sample(float s, inout float k, inout vec3 e)
  ///                    adds extinction and emission [1/m] at s, before M_end
  virtual std::vector<ShaderPart> parts() const = 0;
  virtual GlMediumTraits traits() const = 0;
  virtual GlNeeds needs() const = 0;
  virtual Box3 bounds() const = 0;  ///< [m]

  /// Before a picture.
  virtual void bind(const GlProgram& program, const std::string& prefix, const GlView& view,
                    GlBindings& bindings) const = 0;
};

/// Puts a medium's own prefix into a part's text.
std::string withPrefix(const std::string& text, const std::string& prefix);

}  // namespace volute
