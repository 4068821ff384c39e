// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/placement_parameters.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "volute/math/rotation.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMinScale = 1e-3, kMaxScale = 1e3;
constexpr double kSteep = 89.99;             ///< [degrees] about y: at 90 x and z would be the same
constexpr double kPlacementRounding = 1e-9;  ///< of what is shown
constexpr double kNothing = 1e-15;           ///< of a matrix, beside its largest number
constexpr double kPlacementPixels = 500;     ///< that draw a volume by its own size

Vec3 middleOf(const Box3& box) {
  return box.empty() ? Vec3(Vec3::Zero()) : box.centre();
}

Vec3 rounded(const Vec3& v) {
  return (v / kPlacementRounding).array().round().matrix() * kPlacementRounding + Vec3::Zero();
}

Vec3 inRange(const Vec3& scale) {
  return scale.cwiseMax(kMinScale).cwiseMin(kMaxScale);
}

Mat3 turnBy(const Vec3& degrees) {
  const Vec3 angles = kDegree * degrees;
  return turnAbout(Vec3::UnitZ(), angles.z()) * turnAbout(Vec3::UnitY(), angles.y()) *
         turnAbout(Vec3::UnitX(), angles.x());
}

/// The reverse.
Vec3 degreesOf(const Mat3& turn) {
  const double y = std::asin(std::clamp(-turn(2, 0), -1.0, 1.0));
  if (std::abs(turn(2, 0)) > 1 - 1e-12)
    return Vec3(0, y, std::atan2(-turn(0, 1), turn(1, 1))) / kDegree;
  return Vec3(std::atan2(turn(2, 1), turn(2, 2)), y, std::atan2(turn(1, 0), turn(0, 0))) / kDegree;
}

}  // namespace

PlacementWords wordsOf(const Placement& placement, const Box3& fileBounds) {
  PlacementWords words;
  words.mirrored = placement.turn.determinant() < 0;
  Mat3 turn = placement.turn;
  if (words.mirrored)
    turn.col(0) *= -1;
  words.turn = rounded(degreesOf(turn));
  const double largest = placement.scale.maxCoeff();
  words.scale = largest * rounded(placement.scale / largest);
  words.middle = rounded(placement.turn * placement.scale.cwiseProduct(middleOf(fileBounds)) +
                         placement.offset);
  return words;
}

OrderedJson transformOf(const PlacementWords& words, const Box3& fileBounds) {
  Vec3 scale = words.scale;
  if (words.mirrored)
    scale.x() *= -1;
  const Mat3 linear = turnBy(words.turn) * scale.asDiagonal();
  const Mat4 matrix = affine(linear, words.middle - linear * middleOf(fileBounds));
  const double nothing = kNothing * matrix.cwiseAbs().maxCoeff();
  OrderedJson numbers = OrderedJson::array();
  for (int i = 0; i < 16; ++i) {
    const double number = matrix(i / 4, i % 4);
    numbers.push_back(std::abs(number) <= nothing ? 0.0 : number);
  }
  return numbers;
}

void addPlacement(ParameterGroup& group, const Placement& placement, const Box3& fileBounds) {
  const PlacementWords words = wordsOf(placement, fileBounds);
  const double size = fileBounds.empty() ? 1 : fileBounds.size().cwiseProduct(words.scale).norm();
  group.section("placement");
  group.point("middle", "transform/middle", words.middle, "m", size / kPlacementPixels).help =
      "where the middle of the volume is";
  group.point("turned", "transform/turn", words.turn, "deg", 0.5).help =
      "about its middle: about x, then y, then z [degrees]";
  const double factor = std::cbrt(words.scale.prod());
  Parameter& size1 = group.add("size", "transform/size", Parameter::Kind::kNumber, {factor});
  size1.least = std::min(0.01, factor), size1.most = std::max(100.0, factor);
  size1.logarithmic = true;
  size1.unit = std::string("x");  // GCC 12 warns of the plain assignment
  size1.help = "of the file's, about its middle";
  group.point("along axes", "transform/scale", words.scale, "x", 0.01).help =
      "the size along the volume's own x, y and z";
  group.add("mirrored", "transform/mirror", Parameter::Kind::kFlag, {words.mirrored ? 1.0 : 0.0})
      .help = "along the volume's own x";
  group.section("");
}

void setPlacement(OrderedJson& volume, const Placement& placement, const Box3& fileBounds,
                  const std::string& key, const std::vector<double>& value) {
  PlacementWords words = wordsOf(placement, fileBounds);
  const auto vector = [&] { return Vec3(value[0], value[1], value[2]); };
  if (key == "middle")
    words.middle = vector();
  else if (key == "turn")
    words.turn = vector(), words.turn.y() = std::clamp(words.turn.y(), -kSteep, kSteep);
  else if (key == "size")
    words.scale = inRange(words.scale * (value[0] / std::cbrt(words.scale.prod())));
  else if (key == "scale")
    words.scale = inRange(vector());
  else
    words.mirrored = value[0] != 0;
  const Vec3 middle = middleOf(fileBounds);
  const bool moved = (words.middle - middle).norm() > kPlacementRounding * (1 + middle.norm());
  const bool nothing = !moved && !words.mirrored && words.turn == Vec3::Zero() &&
                       (words.scale - Vec3::Ones()).norm() <= kPlacementRounding;
  if (nothing)
    volume.erase("transform");
  else
    volume["transform"] = transformOf(words, fileBounds);
}

}  // namespace volute
