// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/gl/gl_medium.hpp"
#include "volute/gl/gl_resources.hpp"
#include "volute/lighting/lit_medium.hpp"

namespace volute {

struct GlTriangles;

/// The lamps of a LitMedium on the device, and the surfaces that shadow it: what they add to the
/// light of any medium in a shader, as M_sunlight(place, s), after M_findShadows() at the beginning
/// of a ray. Up to M_nextShadow(s, before) the light is nearly a polynomial.
class GlLamps {
 public:
  /// Those of `lit` are kept in `resources`. kUnsupported where light is scattered more than once
  /// and not evenly.
  /// @param surfaces  which `lit` is shadowed by, if it is
  /// @param name  of the medium, for people
  [[nodiscard]] static Result<GlLamps> make(const std::shared_ptr<const LitMedium>& lit,
                                            const TriangleScene& surfaces, const std::string& name,
                                            GlResources& resources);

  /// Without any: nothing is bound.
  GlLamps() = default;

  bool any() const { return all_ != nullptr; }

  /// Lamps with the same key have the same functions.
  std::string key() const;
  std::string functions() const;
  GlNeeds needs() const;
  void bind(const GlProgram& program, const std::string& prefix, const Vec3& origin,
            GlBindings& bindings) const;

 private:
  struct One;
  struct All;

  std::shared_ptr<const All> all_;
  std::shared_ptr<const GlTriangles> shade_;  ///< null: nothing shadows
};

}  // namespace volute
