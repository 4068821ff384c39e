// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "volute/fds/fds_field.hpp"
#include "volute/fog/polar_table.hpp"
#include "volute/fog/sunlit_fog.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/grid/brick_slice.hpp"
#include "volute/lighting/lamp.hpp"
#include "volute/render/billboard.hpp"
#include "volute/tetmesh/tet_locator.hpp"
#include "volute/tree4d/tree4d.hpp"

namespace volute {

/// VoxelMedium's twin: one instant of a volume, from an atlas of its bricks on the device.
struct GlVolume {
  std::shared_ptr<const BrickSlice> slice;
  double emission = 1;           ///< radiance per metre per unit
  double extinction = 0;         ///< 1/m per unit
  Mat3 turn = Mat3::Identity();  ///< orthogonal; points of the slice are turned by it, then moved
  Vec3 offset = Vec3::Zero();    ///< [m]
};

/// What rays through a tree step over, so that no voxel of it is walked for.
enum class GlTreeSkip {
  kNothing,  ///< no voxel
  kBox,      ///< what is outside the box of the instant's bricks that are not empty
  kBricks,   ///< that, and the bricks in it that are empty
};

/// The same, but the hexadeca-tree itself is on the device and each voxel is a walk in it
/// (Ahrenberg et al. 2005, Figures 5 and 6): no time is spent on the instant, more on each ray.
struct GlTreeVolume {
  std::shared_ptr<const Tree4d> tree;
  int frame = 0;
  Basis basis = Basis::kBox;
  Box3 bounds;  ///< outer voxel faces [m]
  double emission = 1;
  double extinction = 0;
  Mat3 turn = Mat3::Identity();           ///< as GlVolume's
  Vec3 offset = Vec3::Zero();             ///< [m]
  GlTreeSkip skip = GlTreeSkip::kBricks;  ///< the picture is the same
};

/// How a .volute is drawn.
enum class GlVolumeMethod {
  kBricks,  ///< GlVolume: each instant's bricks are extracted and uploaded
  kTree,    ///< GlTreeVolume
};

/// TetMarcher's twin: one instant of smoke on a mesh.
struct GlSmoke {
  std::shared_ptr<const TetLocator> locator;
  std::vector<float> extinction{};  ///< [1/m], one for each vertex, finite and >= 0
  std::vector<float> source{};  ///< radiance of infinitely thick smoke, RGB a vertex; empty: black
};

/// The boundary of a smoke's mesh as walls that reflect the light of lamps, seen from inside alone
/// (lookAtWalls() in scene/smoke_walls).
struct GlWalls {
  GlSmoke smoke;  ///< its extinction as light meets it
  std::span<const Lamp> lamps{};
  std::span<const std::vector<float>> shares{};  ///< of each lamp's light, at each vertex
  Rgb color = Rgb::Ones();
  Rgb ambient = Rgb::Zero();
  TriangleScene blocks{};  ///< other things that stand in the light
};

/// How a smoke is drawn that is alone in its picture. One among other media is marched with them,
/// and so is any under a camera with a lens.
enum class GlSmokeMethod {
  kAuto,     ///< black smoke and optical depths by the splat, light by the march
  kMarch,    ///< from face to face, in a compute shader
  kSplat,    ///< DepthSplat: transmittance alone; light is marched
  kProject,  ///< TetProjector, for drivers whose compute shaders are slow
};

/// FdsField's twin, or that of an FdsFlame's heat.
struct GlFds {
  FdsField field;
  double scale = 1;           ///< of the extinction and of what it scatters
  std::optional<Rgb> glow{};  ///< of fire: radiance per metre of a unit; it hides nothing
};

/// Billboard's twin: a volume's picture on a rectangle that faces the camera.
struct GlBillboard {
  GlVolume volume;
  BillboardOptions options;
};

/// All media of a picture, and the light behind them.
struct GlScene {
  std::vector<GlVolume> volumes{};
  std::vector<GlTreeVolume> trees{};
  std::vector<FogMedium> fogs{};
  std::vector<GlSmoke> smokes{};
  std::vector<SunlitFog> sunlitFogs{};
  std::vector<GlBillboard> billboards{};
  std::vector<GlFds> fds{};
  TriangleScene
      shade{};  ///< surfaces that keep the suns from fog which SunScattering::shadows knows
  double fogFactor = 1;  ///< of all fogs' extinction, as ScaledMedium has it
  /// A fog that is alone in its picture is drawn by a polar table where one serves.
  std::optional<PolarOptions> polarFog{};
  GlSmokeMethod smokeMethod = GlSmokeMethod::kAuto;

  std::size_t media() const {
    return volumes.size() + trees.size() + fogs.size() + smokes.size() + sunlitFogs.size() +
           billboards.size() + fds.size();
  }
};

}  // namespace volute
