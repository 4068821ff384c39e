// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/gl/gl_march.hpp"
#include "volute/gl/gl_medium.hpp"
#include "volute/gl/gl_scene.hpp"

namespace volute {

/// A picture for which parts are made, and what with.
struct GlPicture {
  const Camera& camera;
  const TriangleScene& shade;  ///< GlScene::shade
  GlResources& resources;
  Progress& progress;
};

/// A medium, or one of what it consists of, as OpenGL draws it. Immutable. The renderer knows no
/// more of a medium than this: each kind has a class of its own in a file of its own.
class GlPart {
 public:
  virtual ~GlPart() = default;

  /// What the times of passes call it: "fog".
  virtual std::string name() const = 0;

  /// Does what a first picture would else wait for, and what needs no device. On any thread.
  virtual void prepare() const {}

  /// For the march through all media, as this picture's camera sees it. What it needs on the device
  /// is in the picture's resources, or comes there.
  [[nodiscard]] virtual Result<std::unique_ptr<GlMedium>> medium(
      const GlPicture& picture) const = 0;

  /// Draws a picture that has nothing else in it by a faster way. kUnsupported, before anything is
  /// drawn, where there is none: then it is marched.
  [[nodiscard]] virtual Status drawAlone(const GlPicture& picture, const GlTarget& target) const;

  /// The same with another extinction, as the law of a picture has it: this factor on all of it,
  /// and on what it scatters. What only emits stays as it is.
  virtual std::shared_ptr<const GlPart> scaled(double factor) const = 0;
};

}  // namespace volute
