// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "volute/capture/open_capture.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/testing.hpp"

/// What the tests of captures share: a small ring of cameras around a cube of 2 m.
namespace volute::testing {

constexpr int kWidth = 24, kHeight = 16;

inline void writeText(const std::filesystem::path& path, const std::string& text) {
  writeBytes(path, text);
}

/// Camera `i` of `count` around the origin, 4 m away, looking at it; z is up.
inline Calibration ringCalibration(int i, int count) {
  const double angle = 2 * 3.14159265358979 * i / count;
  const Vec3 eye(4 * std::cos(angle), 4 * std::sin(angle), 0.3 * i);
  const Vec3 forward = (-eye).normalized();
  const Vec3 right = forward.cross(Vec3::UnitZ()).normalized();
  Calibration calibration;
  calibration.width = kWidth;
  calibration.height = kHeight;
  calibration.K = Mat3(25 + i, 0, 12 - 0.25 * i, 0, 26 + i, 8 + 0.5 * i, 0, 0, 1);
  calibration.R = Mat3::ofRows(right, forward.cross(right), forward);
  calibration.t = -(calibration.R * eye);
  return calibration;
}

template <int Rows, int Columns>
nlohmann::json toJson(const MatN<double, Rows, Columns>& matrix) {
  nlohmann::json rows = nlohmann::json::array();
  for (int row = 0; row < Rows; ++row) {
    nlohmann::json values = nlohmann::json::array();
    for (int column = 0; column < Columns; ++column) values.push_back(matrix(row, column));
    rows.push_back(values);
  }
  return rows;
}

/// A capture.json of three cameras a, b, c and frames 4, 5, as JSON.
inline nlohmann::json ringJson() {
  nlohmann::json json = {
      {"format", "volute-capture-1"},
      {"color", "linear"},
      {"pixel_centre", 0.5},
      {"frames", {4, 5}},
      {"volume", {{"min", {-1, -1, -1}}, {"max", {1, 1, 1}}, {"resolution", {8, 8, 8}}}},
      {"cameras", nlohmann::json::array()}};
  for (int i = 0; i < 3; ++i) {
    const Calibration calibration = ringCalibration(i, 3);
    const std::string name(1, static_cast<char>('a' + i));
    json["cameras"].push_back({{"name", name},
                               {"image", "f_%04d_" + name + ".exr"},
                               {"width", kWidth},
                               {"height", kHeight},
                               {"K", toJson(calibration.K)},
                               {"R", toJson(calibration.R)},
                               {"t", {calibration.t.x(), calibration.t.y(), calibration.t.z()}}});
  }
  return json;
}

/// Pictures of the ring: a bright spot whose value tells camera and frame.
inline void writeRingPictures(const TempFolder& folder) {
  for (int camera = 0; camera < 3; ++camera) {
    for (const int frame : {4, 5}) {
      Image image(kWidth, kHeight);
      for (int c = 0; c < 3; ++c) image.at(12, 8, c) = static_cast<float>(frame + 0.1 * camera);
      const std::string name(1, static_cast<char>('a' + camera));
      ASSERT_TRUE(ok(writeImage(folder / fmt::format("f_{:04d}_{}.exr", frame, name), image)));
    }
  }
}

inline std::vector<std::string> sentences(const std::vector<Remark>& remarks) {
  std::vector<std::string> sentences;
  for (const Remark& remark : remarks) sentences.push_back(remark.sentence);
  return sentences;
}

/// Expects an error whose message has `part`.
template <class T>
::testing::AssertionResult failsWith(const Result<T>& result, const std::string& part) {
  if (result)
    return ::testing::AssertionFailure() << "no error; expected one with: " << part;
  if (result.error().message.find(part) == std::string::npos)
    return ::testing::AssertionFailure() << result.error().message << "\nexpected: " << part;
  return ::testing::AssertionSuccess();
}

}  // namespace volute::testing
