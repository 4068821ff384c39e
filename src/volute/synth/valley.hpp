// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/image/image.hpp"

namespace volute {

/// A made-up valley to put fog into: hills, a river, trees, a village; one height for each place,
/// every 0.5 m on a square of 512 m. x and y from 0 to 512, z up, the river near z = 0.
class Valley {
 public:
  static constexpr double kSide = 512;  ///< [m]

  explicit Valley(std::uint32_t seed);

  /// A picture without fog as any renderer would give it.
  struct Frame {
    Image color;  ///< linear RGB
    Image depth;  ///< [m] along the view axis, at pixel centres; infinite for the sky
  };

  /// Four rays for a pixel's colour, one for its depth.
  Frame look(const Camera& camera) const;

  /// A painted map of morning fog, values 0..1 in steps of 1/255 that lie along the river and in
  /// banks; its first row has the largest y. Cells of kSide / size.
  Image fogMap(int size) const;

  /// The same as triangles, of every `every`-th height, coloured by what covers each place.
  TriangleMesh surfaces(int every) const;

  /// From a slope, along the valley.
  View3 view() const;

  /// A flight through the valley, share from 0 to 1.
  View3 flight(double share) const;

  /// [m]
  double height(double x, double y) const;

  /// Of unit length; the sun stands low over the valley's end.
  static Vec3 towardsSun();

 private:
  enum class Cover : std::uint8_t { kMeadow, kForest, kRock, kWater, kCrown, kHouse };

  static constexpr int kSamples = 1025;
  static constexpr int kLevels = 3;
  static constexpr int kSides[kLevels] = {4, 16, 64};  ///< of blocks, in cells
  static constexpr double kStep = kSide / (kSamples - 1);

  std::size_t index(int i, int j) const { return static_cast<std::size_t>(j) * kSamples + i; }

  double river(double y) const;  ///< its x
  double ground(double x, double y) const;
  void plantTrees();
  void buildVillage();
  void buildHouse(const Vec3& at, double length, double width, double wall, double turn);
  void findBlocks();
  void castShadows();

  /// The distance to the ground; infinite for the sky. `begin` is where to start [m].
  double hit(const Vec3& eye, const Vec3& direction, double begin) const;
  double hitInBlocks(int level, const Vec3& eye, const Vec3& direction, double begin,
                     double end) const;
  double hitBySteps(const Vec3& eye, const Vec3& direction, double begin, double end) const;
  Rgb shade(const Vec3& point) const;
  Rgb sky(const Vec3& direction) const;

  std::uint32_t seed_;
  std::vector<float> heights_;  ///< shape (kSamples, kSamples), row 0 at y = 0
  std::vector<Cover> covers_;
  std::vector<float> lit_;               ///< share of the sun
  std::vector<float> highest_[kLevels];  ///< of blocks
};

}  // namespace volute
