// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/gl/gl_scene.hpp"
#include "volute/gl/surface_drawer.hpp"
#include "volute/image/color_scale.hpp"
#include "volute/image/image.hpp"
#include "volute/media/medium_snapshot.hpp"
#include "volute/optics/visibility.hpp"

namespace volute {

struct SceneSnapshot;

/// A line that is drawn over the picture.
struct ViewLine {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  Rgb color = Rgb::Ones();  ///< as displays take it, 0..1
};

/// The same snapshot by the CPU: linear RGB with surfaces and background in it. Thread-safe.
using CpuPicture = std::function<Result<Image>(const Camera& camera, Progress& progress)>;

/// One snapshot of a document, ready to be drawn.
struct ViewScene {
  double time = 0;  ///< [s] of the document
  GlScene media{};  ///< as the law of the picture sees them
  /// Whose boundaries a pointer meets as walls.
  std::vector<std::shared_ptr<const MediumSnapshot>> now{};
  std::vector<std::string> names{};  ///< of each of them: "smoke: hall.pvd"
  PictureLaw law{};                  ///< of the picture

  /// The colours of a quantity, and which it is.
  struct Scale {
    std::string name;
    ColorScale colors;
  };

  std::vector<Scale> scales{};
  std::shared_ptr<const GlSurfaces> surfaces{};
  std::vector<GlQuad> quads{};
  std::vector<ViewLine> lines{};
  std::vector<ViewLine> aids{};   ///< behind what there is to see, not on pictures without panels
  std::vector<ViewLine> marks{};  ///< where lamps and planes are: likewise, but before it
  CpuPicture cpu{};               ///< empty: there is none
  CpuPicture bare{};              ///< the same without surfaces; empty: there are none
  CpuPicture preview{};           ///< `cpu` sooner, without shadows; empty: no sooner
  bool inTiles = false;           ///< a rectangle of a picture costs its share
  bool provisional = false;       ///< of less detail than one that rests
  std::uint64_t bytes = 0;        ///< of memory, about, that it alone holds
  /// What a pointer or a ray meets: all triangles of the scene, however they are drawn.
  TriangleScene geometry{};
  std::vector<std::string> remarks{};  ///< what this snapshot lacks, in sentences
  /// Of which `surfaces` are an approximation; null: there is nothing finer.
  std::shared_ptr<const SceneSnapshot> snapshot{};
  std::string notByGl{};  ///< why OpenGL does not draw the media; empty: it may
};

}  // namespace volute
