// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "volute/fog/fog_medium.hpp"
#include "volute/lighting/lit_medium.hpp"
#include "volute/media/clock.hpp"
#include "volute/media/field.hpp"

namespace volute {

/// Where a pixel of a map is.
enum class FogRegistration {
  kPixel,  ///< where it is painted: its fog is densest in the middle of its cell, for every degree
  kCoefficient,  ///< (degree + 1) / 2 cells from the corner of its cell that is nearest the origin
};

/// What is beyond the border of a map, which wind brings in.
enum class FogBorder {
  kZero,    ///< clear air
  kRepeat,  ///< what leaves on one side comes in on the other
  kClamp,   ///< the pixels at the border
};

/// How rays are integrated.
enum class FogPath {
  kAuto,   ///< by a table where that serves and is faster: pictures of maps of 128 pixels and more
  kWalk,   ///< every ray, exactly
  kPolar,  ///< by a table of polar prefix sums where it serves: FogSceneMedium::polarFor()
};

/// No fog above a map of heights.
struct FogTopDescription {
  std::string file;
  FogPlacement placement{Vec3::Zero(), 1, 1};  ///< sigmaMax: the height of a pixel of value 1 [m]
};

/// A profile as a scene says it.
struct FogProfileDescription {
  enum class Kind { kSlab, kExponential, kLinear, kLayers };

  Kind kind = Kind::kSlab;
  double bottom = 0, top = 10, height = 20;     ///< [m]
  std::vector<std::array<double, 2>> knots;     ///< height [m], value
  std::vector<std::array<double, 3>> layers{};  ///< bottom, top [m], share
};

/// A medium of kind "fog" in a scene, or what `volute fog` was asked for.
struct FogDescription {
  FieldOrigin origin;  ///< of its entry, for errors
  /// Pictures, one a time; or one name: a picture, a pattern of pictures, or a volume one voxel
  /// high.
  std::vector<std::string> maps;
  std::vector<double> times;  ///< [s], of each map; empty: the volume's own, else by `rate`
  double rate = 25;           ///< numbered maps a second
  bool byNumber = false;  ///< map n is at n / rate, as frame n of a film is; else the first at 0 s
  FogPlacement placement;
  bool placed = false;  ///< its cell or origin is stated, not the default
  FogRegistration registration = FogRegistration::kPixel;
  std::optional<FogBorder> border{};  ///< nothing: kRepeat in wind, where there is no top
  FogColour colour = FogColour::kRefuse;
  FogOptions options;
  FogProfile profile;
  std::optional<FogProfileDescription> described{};  ///< the same in words; nothing: any height
  std::optional<FogTopDescription> top;
  Vec3 wind = Vec3::Zero();  ///< [m/s], in the scene's time
  Clock clock;
  Scattering scattering;
  ShadowsOn shadows{};    ///< of the scene's geometry; may be empty
  Blocks blocks{};        ///< the same
  bool multiple = false;  ///< SceneLights
  FogPath path = FogPath::kAuto;

  /// A member that was given and changes nothing: "profile/height".
  struct Idle {
    std::string member, reason;
  };

  std::vector<Idle> idle{};

  FogBorder borderInWind() const {
    return border.value_or(wind.head<2>().isZero(0) || top ? FogBorder::kZero : FogBorder::kRepeat);
  }

  /// "scene.json: /media/0", or "the fog" of a command.
  std::string where() const;

  /// An error whose message names no place, as one about this fog or a member of it.
  Error about(Error error, const std::string& member = {}) const;
};

const FieldTable& fogFields();
/// The members of a fog's "profile".
const FieldTable& fogProfileFields();

/// A fog object of a scene, or the options that say the same.
[[nodiscard]] Result<FogDescription> parseFog(const nlohmann::json& json,
                                              const FieldOrigin& origin);

}  // namespace volute
