// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/geometry_check.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "volute/capture/testing.hpp"

namespace volute {
namespace {

using testing::ringJson;
using testing::TempFolder;

/// The faults of the ring with a change.
std::vector<GeometryFault> faultsWith(const std::function<void(nlohmann::json&)>& change) {
  const TempFolder folder;
  auto json = ringJson();
  change(json);
  testing::writeText(folder / "capture.json", json.dump());
  const auto capture = openCapture(folder / "capture.json", {});
  if (!capture)
    return {{"", capture.error().message}};
  return checkGeometry(*capture);
}

void expectFault(const std::function<void(nlohmann::json&)>& change, const std::string& camera,
                 const std::string& part) {
  const auto faults = faultsWith(change);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].camera, camera);
  EXPECT_NE(faults[0].message.find("camera " + camera), std::string::npos) << faults[0].message;
  EXPECT_NE(faults[0].message.find(part), std::string::npos) << faults[0].message;
}

void scale(nlohmann::json& vector, double factor) {
  for (auto& value : vector) value = factor * value.get<double>();
}

TEST(GeometryCheck, CleanCapturesHaveNoFault) {
  EXPECT_TRUE(faultsWith([](nlohmann::json&) {}).empty());
}

TEST(GeometryCheck, CentimetresForMetres) {
  expectFault([](auto& json) { scale(json["cameras"][1]["t"], 100); }, "b",
              "covers only 0.2 of 24 pixels: the camera stands 401.1 m from the centre of a volume "
              "of 2 x 2 x 2 m; is one of them in centimetres");
  const auto inside = faultsWith([](auto& json) {
    scale(json["volume"]["min"], 100);
    scale(json["volume"]["max"], 100);
  });
  ASSERT_EQ(inside.size(), 3u);
  EXPECT_NE(inside[2].message.find("camera c: the camera stands inside the volume"),
            std::string::npos);
}

TEST(GeometryCheck, PrincipalPointsInTheCorner) {
  const auto at = [](double x, double y) {
    return [=](auto& json) {
      json["cameras"][1]["K"][0][2] = x;
      json["cameras"][1]["K"][1][2] = y;
    };
  };
  expectFault(
      at(0, 0), "b",
      "the principal point (0.0, 0.0) lies at the corner of the picture of 24 x 16 pixels; it "
      "is about the middle, (12.0, 8.0)");
  expectFault(at(0.9, -0.5), "b", "at the corner");
  expectFault(at(12, 0), "b", "the principal point (12.0, 0.0) lies at the border");
  expectFault(at(24, 8), "b", "lies at the border");
  expectFault(at(12, 15.5), "b", "for most cameras: is it that of a larger picture?");
  expectFault(at(23.9, 0.2), "b", "at the corner");
  expectFault(at(24, 16), "b", "is the middle of about 48 x 32 pixels");
  EXPECT_TRUE(faultsWith(at(11, 9.5)).empty());
  EXPECT_TRUE(faultsWith(at(23, 8)).empty());
}

TEST(GeometryCheck, CalibrationsOfAnotherResolution) {
  for (const auto& [factor, size] : {std::pair(2.0, "48 x 32"), std::pair(0.5, "12 x 8")}) {
    expectFault(
        [&](auto& json) {
          auto& K = json["cameras"][0]["K"];
          scale(K[0], factor);
          scale(K[1], factor);
        },
        "a", fmt::format("is the middle of about {} pixels, and the pictures have 24 x 16", size));
  }
}

TEST(GeometryCheck, VolumeBehindTheCamera) {
  expectFault(
      [](auto& json) {
        auto& R = json["cameras"][2]["R"];
        scale(R[0], -1);  // turned around its vertical axis
        scale(R[2], -1);
        // Its place stays: t = -R eye.
        json["cameras"][2]["t"][0] = -json["cameras"][2]["t"][0].template get<double>();
        json["cameras"][2]["t"][2] = -json["cameras"][2]["t"][2].template get<double>();
      },
      "c", "the volume lies behind the camera, its centre 4.045 m behind");
}

TEST(GeometryCheck, VolumeOutsideTheImage) {
  expectFault([](auto& json) { json["cameras"][0]["t"][0] = 9; }, "a",
              "the volume lies outside the image: it would appear at x");
}

TEST(GeometryCheck, WidthAndHeightSwapped) {
  expectFault(
      [](auto& json) {
        json["cameras"][0]["width"] = 16;
        json["cameras"][0]["height"] = 24;
      },
      "a", "the principal point (12.0, 8.0) is far off the middle of 16 x 24 pixels");
}

TEST(GeometryCheck, PartlyVisibleVolumesAreFine) {
  EXPECT_TRUE(faultsWith([](auto& json) { json["cameras"][0]["t"][0] = 1; }).empty());
}

}  // namespace
}  // namespace volute
