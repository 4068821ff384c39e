// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/lighting/lamp.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

/// A face of a mesh's boundary, anticlockwise from inside.
struct WallFace {
  std::array<std::int32_t, 3> vertices{};
  std::int32_t tet = -1;         ///< behind it
  Vec3 inwards = Vec3::UnitX();  ///< unit normal
};

/// What the rays of all pixels of a camera meet.
struct WallView {
  std::vector<float> depth;         ///< [m]; infinity: no wall
  std::vector<std::uint32_t> face;  ///< its place in MeshWalls::faces(); kNone: no wall
  std::uint64_t number = 0;         ///< that no other view has; 0: it is not kept

  static constexpr std::uint32_t kNone = Hit::kNone;
};

/// The boundary of a mesh as walls that are seen from inside. Immutable. Threads may share it.
class MeshWalls {
 public:
  /// Two faces of the boundary with an edge in common; the second is -1 where an edge is of one
  /// face alone or of more than two.
  struct Edge {
    std::int32_t from = 0, to = 0;
    std::int32_t first = -1, second = -1;
  };

  [[nodiscard]] static Result<std::shared_ptr<const MeshWalls>> make(const TetMesh& mesh);

  std::span<const WallFace> faces() const { return faces_; }

  std::span<const Edge> edges() const { return edges_; }

  /// The first wall on each segment of which it meets the inner side.
  void nearest(std::span<const Segment> segments, std::span<Hit> hits) const;

  /// Calls found(pixel, hit) on several threads where the ray of a pixel meets a wall.
  /// @param only  empty, or one for each pixel: those that are asked for
  void look(const Camera& camera, std::span<const std::uint8_t> only,
            const std::function<void(std::size_t, const Hit&)>& found) const;

  /// The walls in all pixels. Of a camera that is asked for again they are kept, as long as no
  /// other one is: smoke moves before walls that do not.
  std::shared_ptr<const WallView> seenFrom(const Camera& camera) const;

 private:
  std::vector<WallFace> faces_;
  std::vector<Edge> edges_;
  TriangleScene scene_;
  mutable std::mutex guard_;  ///< of what follows
  mutable std::optional<Camera> lastCamera_;
  mutable std::shared_ptr<const WallView> lastView_;  ///< null: the camera came for the first time
};

/// How much of lamps' light comes to points of walls through the smoke before them, at one time or
/// between two, where extinctions are linear: lampShareAt(), within 2e-3. Where the depth of the
/// smoke towards a lamp is smooth on a face, a parabola stands for it, whose error was found at
/// three points; what may cast a shadow on a part of a face is known from the edges at which the
/// boundary turns away from the lamp, and there each point has a walk of its own. Found once, and
/// kept for later pictures; the walks of points up to 64 MiB, as long as the view stays. What is
/// found does not depend on what was asked before. Threads may share it.
class WallLight {
 public:
  WallLight();
  ~WallLight();

  /// A mesh whose walls are lit, and the lamps.
  struct Request {
    const TetLocator& locator;
    std::span<const float> extinction;  ///< where the interval begins
    const MeshWalls& walls;
    std::span<const Lamp> lamps;
    std::span<const float> later{};  ///< where it ends; empty: this is one time
    double time = 0;                 ///< 0..1, of the interval
    /// WallView::number of whose points they are, all of a face in the order of its pixels; 0: of
    /// none that comes again.
    std::uint64_t view = 0;
  };

  /// @param request  but for its time and view always the same
  /// @param face  its place in MeshWalls::faces()
  /// @param points  of it, by the shares of its corners
  /// @param shares  of the lamp's light: 0 in a shadow of the mesh's own walls
  void shares(const Request& request, std::size_t lamp, std::size_t face,
              std::span<const Vec3> points, std::span<double> shares);

  /// Walks that were made so far.
  std::uint64_t walks() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace volute
