// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/importers.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>

#include "volute/capture/testing.hpp"
#include "volute/io/json_file.hpp"
#include "volute/math/eigen.hpp"

namespace volute {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using testing::failsWith;
using ::testing::HasSubstr;
using testing::ok;
using testing::ringCalibration;
using testing::ringJson;
using testing::sentences;
using testing::TempFolder;
using testing::writeText;

constexpr int kCameras = 3;

std::string nameOf(int i) {
  return std::string(1, static_cast<char>('a' + i));
}

std::string digits(double value) {
  return fmt::format("{:.17g}", value);
}

void writeNerf(const TempFolder& folder, bool common) {
  nlohmann::json json = {{"frames", nlohmann::json::array()}, {"aabb_scale", 2}};
  for (int i = 0; i < kCameras; ++i) {
    const Calibration c = ringCalibration(i, kCameras);
    const Mat4 toWorld =
        affine(c.R.transpose() * Vec3(1, -1, -1).asDiagonal(), -(c.R.transpose() * c.t));
    nlohmann::json frame = {{"file_path", "pictures/f_####_" + nameOf(i) + ".exr"},
                            {"transform_matrix", testing::toJson(toWorld)},
                            {"fl_x", c.K(0, 0)},
                            {"fl_y", c.K(1, 1)},
                            {"cx", c.K(0, 2)},
                            {"cy", c.K(1, 2)}};
    nlohmann::json& sizes = common ? json : frame;
    sizes["w"] = testing::kWidth;
    sizes["h"] = testing::kHeight;
    json["frames"].push_back(frame);
  }
  writeText(folder / "transforms.json", json.dump());
}

template <class T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void writeColmapBinary(const TempFolder& folder) {
  std::string cameras, images;
  put<std::uint64_t>(cameras, kCameras);
  put<std::uint64_t>(images, kCameras);
  for (int i = 0; i < kCameras; ++i) {
    const Calibration c = ringCalibration(i, kCameras);
    put<std::uint32_t>(cameras, static_cast<std::uint32_t>(i + 1));
    put<std::int32_t>(cameras, 1);
    put<std::uint64_t>(cameras, testing::kWidth);
    put<std::uint64_t>(cameras, testing::kHeight);
    for (const double p : {c.K(0, 0), c.K(1, 1), c.K(0, 2), c.K(1, 2)}) put(cameras, p);
    const Eigen::Quaterniond q(asEigen(c.R));
    put<std::uint32_t>(images, static_cast<std::uint32_t>(i + 1));
    for (const double v : {q.w(), q.x(), q.y(), q.z(), c.t.x(), c.t.y(), c.t.z()}) put(images, v);
    put<std::uint32_t>(images, static_cast<std::uint32_t>(i + 1));
    images += "f_0004_" + nameOf(i) + ".exr";
    images += '\0';
    put<std::uint64_t>(images, 2);
    images += std::string(48, 'x');
  }
  std::filesystem::create_directory(folder / "bin");
  writeText(folder / "bin" / "cameras.bin", cameras);
  writeText(folder / "bin" / "images.bin", images);
}

void writeColmapText(const TempFolder& folder, const std::string& points) {
  std::string cameras = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  std::string images = "# two lines an image\n";
  for (int i = 0; i < kCameras; ++i) {
    const Calibration c = ringCalibration(i, kCameras);
    cameras +=
        fmt::format("{} PINHOLE {} {} {} {} {} {}\n", i + 1, testing::kWidth, testing::kHeight,
                    digits(c.K(0, 0)), digits(c.K(1, 1)), digits(c.K(0, 2)), digits(c.K(1, 2)));
    const Eigen::Quaterniond q(asEigen(c.R));
    images += fmt::format("{} {} {} {} {} {} {} {} {} f_0004_{}.exr\n{}", i + 1, digits(q.w()),
                          digits(q.x()), digits(q.y()), digits(q.z()), digits(c.t.x()),
                          digits(c.t.y()), digits(c.t.z()), i + 1, nameOf(i), points);
  }
  std::filesystem::create_directory(folder / "text");
  writeText(folder / "text" / "cameras.txt", cameras);
  writeText(folder / "text" / "images.txt", images);
}

std::string openCvMatrix(const std::string& name, const Eigen::MatrixXd& m, bool json) {
  std::vector<std::string> values;
  for (int i = 0; i < m.rows(); ++i) {
    for (int j = 0; j < m.cols(); ++j) values.push_back(digits(m(i, j)));
  }
  const auto data = fmt::format("[ {} ]", fmt::join(values, ", "));
  if (json) {
    return fmt::format(
        "\"{}\": {{\"type_id\": \"opencv-matrix\", \"rows\": {}, \"cols\": {}, \"dt\": \"d\", "
        "\"data\": {}}}",
        name, m.rows(), m.cols(), data);
  }
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: {}\n", name,
                     m.rows(), m.cols(), data);
}

template <class Values>
  requires requires(const Values& values) { asEigen(values); }
std::string openCvMatrix(const std::string& name, const Values& values, bool json) {
  return openCvMatrix(name, Eigen::MatrixXd(asEigen(values)), json);
}

std::vector<std::string> openCvEntries(bool json) {
  std::vector<std::string> entries;
  for (int i = 0; i < kCameras; ++i) {
    Calibration c = ringCalibration(i, kCameras);
    c.K(0, 2) -= 0.5;  // OpenCV's centres
    c.K(1, 2) -= 0.5;
    entries.push_back(openCvMatrix("K_" + nameOf(i), c.K, json));
    entries.push_back(openCvMatrix("D_" + nameOf(i), Eigen::MatrixXd::Zero(1, 5), json));
    entries.push_back(openCvMatrix("R_" + nameOf(i), c.R, json));
    entries.push_back(openCvMatrix("T_" + nameOf(i), c.t, json));
  }
  return entries;
}

/// The same cameras, pictures, frames and volume, to rounding.
void expectSame(const Capture& a, const Capture& b) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (std::size_t i = 0; i < a.cameras.size(); ++i) {
    const auto &x = a.cameras[i], &y = b.cameras[i];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.pictures.image, y.pictures.image);
    EXPECT_EQ(x.camera.width(), y.camera.width());
    EXPECT_EQ(x.camera.height(), y.camera.height());
    EXPECT_NEAR((x.camera.intrinsics() - y.camera.intrinsics()).norm(), 0, 1e-10);
    EXPECT_NEAR((x.camera.rotation() - y.camera.rotation()).norm(), 0, 1e-12);
    EXPECT_NEAR((x.camera.eye() - y.camera.eye()).norm(), 0, 1e-12);
  }
  EXPECT_EQ(a.frames, b.frames);
  EXPECT_EQ(a.volume.bounds.min, b.volume.bounds.min);
  EXPECT_EQ(a.volume.resolution, b.volume.resolution);
}

class Importers : public ::testing::Test {
 protected:
  void SetUp() override {
    testing::writeRingPictures(folder);
    writeText(folder / "capture.json", ringJson().dump());
    options.images = (folder / "f_%04d_{camera}.exr").string();
    options.bounds = Box3{Vec3(-1, -1, -1), Vec3(1, 1, 1)};
    options.resolution = {8, 8, 8};
  }

  void expectOurs(const std::filesystem::path& file, const std::string& convention) {
    ASSERT_VALUE(const auto ours, openCapture(folder / "capture.json", options));
    ASSERT_VALUE(const auto other, openCapture(file, options));
    expectSame(ours, other);
    EXPECT_THAT(sentences(other.remarks), Contains(HasSubstr(convention)));
  }

  TempFolder folder;
  CaptureOptions options;
};

TEST_F(Importers, NerfTransforms) {
  for (const bool common : {false, true}) {
    writeNerf(folder, common);
    expectOurs(folder / "transforms.json", "NeRF transforms: 3 cameras, pixel centres at 0.5");
  }
}

TEST_F(Importers, ColmapTextAndBinary) {
  writeColmapBinary(folder);
  expectOurs(folder / "bin", "COLMAP: 3 cameras, pixel centres at 0.5");
  expectOurs(folder / "bin" / "images.bin", "COLMAP");
  for (const char* points : {"\n", "1.5 2.5 -1 3 4 17\n", ""}) {
    writeColmapText(folder, points);
    expectOurs(folder / "text", "COLMAP");
  }
}

TEST_F(Importers, OpenCvYamlAndJson) {
  for (const char* start : {"%YAML:1.0\n---\n", "%YAML:1.0\n"}) {
    writeText(folder / "cameras.yml",
              fmt::format("{}{}", start, fmt::join(openCvEntries(false), "")));
    expectOurs(folder / "cameras.yml", "OpenCV: 3 cameras, pixel centres at 0");
  }
  writeText(folder / "cameras.json", fmt::format("{{{}}}", fmt::join(openCvEntries(true), ", ")));
  expectOurs(folder / "cameras.json", "OpenCV: 3 cameras, pixel centres at 0");
}

TEST_F(Importers, NerfWithoutPatternUsesItsOwnPaths) {
  writeNerf(folder, true);
  std::filesystem::create_directory(folder / "pictures");
  for (const char* name : {"a", "b", "c"}) {
    std::filesystem::rename(folder / fmt::format("f_0004_{}.exr", name),
                            folder / fmt::format("pictures/f_0004_{}.exr", name));
  }
  options.images.reset();
  ASSERT_VALUE(const auto capture, openCapture(folder / "transforms.json", options));
  EXPECT_EQ(capture.cameras[1].name, "f_b");
  EXPECT_EQ(capture.frames, (std::vector<int>{4}));
}

TEST_F(Importers, NerfFaults) {
  writeNerf(folder, true);
  const auto with = [&](const char* pointer, const nlohmann::json& value) {
    auto json = readJson(folder / "transforms.json").value();
    json[nlohmann::json::json_pointer(pointer)] = value;
    writeText(folder / "wrong.json", json.dump());
    return openCapture(folder / "wrong.json", options);
  };
  EXPECT_TRUE(failsWith(with("/camera_model", "OPENCV_FISHEYE"),
                        "camera_model: the camera model OPENCV_FISHEYE is not read"));
  EXPECT_TRUE(failsWith(with("/is_fisheye", true), "is_fisheye: lenses of this kind are not read"));
  EXPECT_TRUE(failsWith(with("/frames/1/is_fisheye", 1), "frames[1].is_fisheye: lenses of this"));
  EXPECT_TRUE(ok(with("/is_fisheye", false)));
  EXPECT_TRUE(failsWith(with("/ftheta_p0", 0.1), "ftheta_p0: f-theta lenses"));
  EXPECT_TRUE(failsWith(with("/frames/1/transform_matrix/2", {1, 2}),
                        "frames[1].transform_matrix[2]: expected 4 numbers"));
  EXPECT_TRUE(failsWith(with("/frames/1/transform_matrix/3", {0, 0, 2, 1}),
                        "frames[1].transform_matrix: its last row is not 0, 0, 0, 1"));
  EXPECT_TRUE(failsWith(with("/frames/2/k4", 0.1), "frames[2]: k4 is 0.1"));
  EXPECT_TRUE(failsWith(with("/frames/2/fl_x", 0), "frames[2]: has no focal length"));
  EXPECT_TRUE(failsWith(with("/frames/2/file_path", "f_####_b.exr"), "a second camera 'b'"));
}

TEST_F(Importers, NerfKeysThatAreNotKnownAreRemarkedOn) {
  writeNerf(folder, true);
  auto json = readJson(folder / "transforms.json").value();
  json["distortion"] = {0.1, 0, 0, 0};
  for (auto& frame : json["frames"]) {
    frame["sharpness"] = 30;
    frame["mask_path"] = "mask.png";
  }
  writeText(folder / "transforms.json", json.dump());
  ASSERT_VALUE(const auto capture, openCapture(folder / "transforms.json", options));
  EXPECT_THAT(sentences(capture.remarks),
              ElementsAre(HasSubstr("NeRF transforms"), HasSubstr("are taken as metres"),
                          "distortion is not known and ignored",
                          "frames[0].mask_path is not known and ignored, as in 2 more entries",
                          HasSubstr("25 frames a second are assumed")));
}

TEST_F(Importers, NerfPicturesAreFoundAsWindowsNamesThem) {
  writeNerf(folder, true);
  auto json = readJson(folder / "transforms.json").value();
  for (auto& frame : json["frames"]) {
    const auto name = frame["file_path"].get<std::string>();
    std::filesystem::create_directory(folder / "Images");
    if (std::filesystem::exists(folder / name))
      std::filesystem::rename(folder / name, folder / "Images" / name);
    frame["file_path"] = ".\\images\\" + name;
  }
  writeText(folder / "transforms.json", json.dump());
  ASSERT_VALUE(const auto capture, openCapture(folder / "transforms.json", options));
  EXPECT_EQ(capture.cameras[0].name.find('\\'), std::string::npos) << capture.cameras[0].name;
}

/// An entry for each camera and frame of writeNerf(), as D-NeRF and nerfstudio list them.
nlohmann::json entriesOf(
    const TempFolder& folder,
    const std::function<void(nlohmann::json&, int camera, int frame)>& change) {
  writeNerf(folder, true);
  auto json = readJson(folder / "transforms.json").value();
  auto entries = nlohmann::json::array();
  for (int i = 0; i < kCameras; ++i) {
    for (int f = 0; f < 2; ++f) {
      nlohmann::json entry = json["frames"][static_cast<std::size_t>(i)];
      entry["file_path"] = fmt::format("f_{:04d}_{}.exr", 4 + f, nameOf(i));
      entry["time"] = 0.1 * f;
      change(entry, i, f);
      entries.push_back(entry);
    }
  }
  json["frames"] = entries;
  return json;
}

TEST_F(Importers, NerfEntriesOfOnePoseAreFramesOfOneCamera) {
  options.images.reset();
  const auto opened = [&](const auto& change) {
    writeText(folder / "transforms.json", entriesOf(folder, change).dump());
    return openCapture(folder / "transforms.json", options);
  };
  for (const bool timed : {true, false}) {
    ASSERT_VALUE(const auto capture, opened([&](nlohmann::json& entry, int, int) {
                   if (!timed)
                     entry.erase("time");
                 }));
    ASSERT_EQ(capture.cameras.size(), std::size_t{kCameras});
    EXPECT_EQ(capture.frames, (std::vector<int>{4, 5}));
    EXPECT_EQ(capture.cameras[1].name, "f_b");
    EXPECT_EQ(capture.cameras[1].pictures.image, (folder / "f_%04d_b.exr").string());
    EXPECT_THAT(sentences(capture.remarks),
                Contains(HasSubstr("6 entries are 3 cameras that stand still, with "
                                   "2 frames")));
  }
  ASSERT_VALUE(const auto folders, opened([](nlohmann::json& entry, int camera, int frame) {
                 entry["file_path"] =
                     fmt::format("left/{}/frame_{}.png", nameOf(camera), 8 + frame);
               }));
  EXPECT_EQ(folders.cameras[1].name, "b");
  EXPECT_EQ(folders.frames, (std::vector<int>{8, 9}));
  // Pictures that are numbered through, by times: 0 to 5 in the order of the list, or by frames.
  for (const bool byCamera : {true, false}) {
    ASSERT_VALUE(const auto capture, opened([&](nlohmann::json& entry, int camera, int frame) {
                   const int number = byCamera ? 2 * camera + frame : camera + kCameras * frame;
                   entry["file_path"] = fmt::format("r_{}", number);
                   entry["time"] = 3 - frame == 3 ? -1 : 7;
                 }));
    EXPECT_EQ(capture.frames, (std::vector<int>{0, 1}));
    EXPECT_EQ(capture.cameras[2].name, "camera2");
    for (int camera = 0; camera < kCameras; ++camera) {
      for (int frame = 0; frame < 2; ++frame) {
        const auto& pictures = capture.cameras[static_cast<std::size_t>(camera)].pictures;
        const PicturePlace place = pictures.placeOf(frame);
        EXPECT_EQ(place.number, byCamera ? 2 * camera + frame : camera + kCameras * frame);
        EXPECT_EQ(place.share, 0);
      }
    }
  }
}

TEST_F(Importers, NerfTimesThatAreNotUsedAreTold) {
  const auto opened = [&](bool backwards) {
    writeText(folder / "transforms.json",
              entriesOf(folder, [&](nlohmann::json& entry, int camera, int frame) {
                entry["time"] = backwards ? -frame : frame;
                if (camera == 0 && frame == 0)
                  entry.erase("time");
              }).dump());
    return openCapture(folder / "transforms.json", options);
  };
  ASSERT_VALUE(const auto named, opened(true));
  EXPECT_THAT(sentences(named.remarks), Contains(HasSubstr("entries have 2 times (\"time\"), which "
                                                           "are not used")));
  options.images.reset();
  ASSERT_VALUE(const auto numbered, opened(false));
  EXPECT_THAT(sentences(numbered.remarks), Contains(HasSubstr("1 of 6 entries have no \"time\"")));
  EXPECT_TRUE(failsWith(opened(true), "does not rise with the number"));
}

TEST_F(Importers, NerfEntriesThatTellNoCamerasApartAreRefused) {
  options.images.reset();
  const auto opened = [&](const auto& change) {
    writeText(folder / "transforms.json", entriesOf(folder, change).dump());
    return openCapture(folder / "transforms.json", options);
  };
  EXPECT_TRUE(failsWith(opened([](nlohmann::json& entry, int camera, int frame) {
                          entry["transform_matrix"][0][3] = 3 + camera + 0.1 * frame;
                        }),
                        "entries are of 2 times (\"time\"), and each has a pose of its own"));
  EXPECT_TRUE(failsWith(opened([](nlohmann::json& entry, int camera, int frame) {
                          entry["file_path"] =
                              fmt::format("{}_{}.exr", nameOf(camera), frame ? "b" : "a");
                        }),
                        "names do not differ by one number"));
  EXPECT_TRUE(failsWith(opened([](nlohmann::json& entry, int camera, int frame) {
                          entry["file_path"] = fmt::format("r_{}.exr", 2 * camera + frame);
                          entry.erase("time");
                        }),
                        "no entry has a \"time\""));
  EXPECT_TRUE(failsWith(opened([](nlohmann::json& entry, int camera, int frame) {
                          entry["file_path"] =
                              fmt::format("r_{}.exr", camera == 1 ? 9 - frame : frame);
                        }),
                        "do not rise together"));
}

TEST_F(Importers, NerfPositionsThatToolsMovedAreRemarkedOn) {
  writeNerf(folder, true);
  auto json = readJson(folder / "transforms.json").value();
  json["applied_scale"] = 1.0;
  json["applied_transform"] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
  writeText(folder / "transforms.json", json.dump());
  ASSERT_VALUE(const auto as, openCapture(folder / "transforms.json", options));
  EXPECT_THAT(sentences(as.remarks),
              ElementsAre(HasSubstr("NeRF"), HasSubstr("are taken as metres"),
                          HasSubstr("25 frames a second")));
  json["camera_model"] = "PINHOLE";
  json["k1"] = 0.1;
  json["aabb"] = {{-1, -1, -1}, {1, 1, 1}};
  writeText(folder / "transforms.json", json.dump());
  ASSERT_VALUE(const auto bent, openCapture(folder / "transforms.json", options));
  EXPECT_THAT(sentences(bent.remarks),
              ::testing::IsSupersetOf({HasSubstr("PINHOLE has no k1, which is 0.1 and is applied"),
                                       HasSubstr("\"aabb\" is a box of the tool")}));
  for (const char* key : {"camera_model", "k1", "aabb"}) json.erase(key);
  json["applied_scale"] = 0.25;
  json["applied_transform"] = {{0, 1, 0, 0}, {1, 0, 0, 0}, {0, 0, -1, 0}};
  json["scale"] = 0.33;
  writeText(folder / "transforms.json", json.dump());
  ASSERT_VALUE(const auto moved, openCapture(folder / "transforms.json", options));
  EXPECT_THAT(sentences(moved.remarks),
              ElementsAre(HasSubstr("NeRF"), HasSubstr("scaled by 0.25 from what was measured"),
                          HasSubstr("turned or moved"), HasSubstr("are not applied"),
                          HasSubstr("25 frames a second")));
  json["scale"] = 1.0, json["offset"] = {0, 0, 0.0};  // of which nothing changes
  writeText(folder / "transforms.json", json.dump());
  EXPECT_THAT(sentences(openCapture(folder / "transforms.json", options).value().remarks),
              Not(Contains(HasSubstr("are not applied"))));
  json["applied_scale"] = 0;
  writeText(folder / "transforms.json", json.dump());
  EXPECT_TRUE(failsWith(openCapture(folder / "transforms.json", options), "applied_scale: is 0"));
}

TEST_F(Importers, FilmedFluids) {
  writeNerf(folder, true);
  const auto json = readJson(folder / "transforms.json").value();
  nlohmann::json info = {
      {"train_videos", nlohmann::json::array()},
      {"test_videos", nlohmann::json::array()},
      {"frame_bkg_color", {0, 0, 0}},
      {"voxel_scale", {1, 2, 3}},
      {"voxel_matrix", {{0, 0, 1, 0.5}, {0, 1, 0, 0}, {-1, 0, 0, 4}, {0, 0, 0, 1}}}};
  for (int i = 0; i < kCameras; ++i) {
    info[i < 2 ? "train_videos" : "test_videos"].push_back(
        {{"file_name", fmt::format("train{:02d}.mp4", i)},
         {"frame_rate", 30},
         {"camera_angle_x", 0.4},
         {"camera_hw", {48, 32}},
         {"near", 1},
         {"transform_matrix", json["frames"][static_cast<std::size_t>(i)]["transform_matrix"]}});
  }
  writeText(folder / "info.json", info.dump());
  EXPECT_TRUE(isCapture(folder / "info.json").value());
  CaptureOptions cubes;
  cubes.resolution = {16, 0, 0};
  ASSERT_VALUE(const auto read, openCalibration(folder / "info.json", cubes));
  ASSERT_EQ(read.cameras.size(), std::size_t{kCameras});
  EXPECT_EQ(read.cameras[2].name, "train02");
  EXPECT_EQ(read.cameras[2].pictures.video, folder / "train02.mp4");
  EXPECT_EQ(read.framesPerSecond, 30);
  const Camera& camera = read.cameras[1].camera;
  EXPECT_EQ(camera.width(), 32);
  EXPECT_EQ(camera.height(), 48);
  EXPECT_NEAR(camera.intrinsics()(0, 0), 16 / std::tan(0.2), 1e-9);
  EXPECT_NEAR(camera.intrinsics()(1, 2), 24, 1e-9);
  const Calibration ours = ringCalibration(1, kCameras);
  EXPECT_LT((camera.eye() + ours.R.transpose() * ours.t).norm(), 1e-9);
  EXPECT_LT((read.volume.bounds.min - Vec3(0.5, 0, 3)).norm(), 1e-9);
  EXPECT_LT((read.volume.bounds.max - Vec3(3.5, 2, 4)).norm(), 1e-9);
  EXPECT_THAT(sentences(read.remarks),
              Contains(HasSubstr("camera train02 is there to be compared with")));
  EXPECT_THAT(sentences(read.remarks), Contains("train_videos[1].near is not known and ignored"));
  info["train_videos"][0].erase("camera_hw");
  writeText(folder / "info.json", info.dump());
  EXPECT_TRUE(failsWith(openCalibration(folder / "info.json", {}), "train_videos[0]: "));
}

TEST_F(Importers, AstraDetectorsMayBeTilted) {
  constexpr int kRows = 16, kColumns = 24;
  const Vec3 source(0.4, -5, 0.2), middle(-0.3, 6, 0.1), u(0.2, 0.01, 0.005), v(0.01, -0.02, 0.18);
  nlohmann::json json{{"type", "cone_vec"},
                      {"DetectorRowCount", kRows},
                      {"DetectorColCount", kColumns},
                      {"Vectors", nlohmann::json::array()}};
  for (const double down : {-1.0, 1.0}) {
    nlohmann::json row;
    for (const Vec3& vector : {source, middle, u, Vec3(down * v)})
      for (const double number : vector) row.push_back(number);
    json["Vectors"].push_back(row);
  }
  writeText(folder / "cone.json", json.dump());
  EXPECT_TRUE(isCapture(folder / "cone.json").value());
  CaptureOptions options;
  options.bounds = Box3{Vec3(-0.5, -0.5, -0.5), Vec3(0.5, 0.5, 0.5)};
  options.resolution = {16, 0, 0};
  ASSERT_VALUE(const auto read, openCalibration(folder / "cone.json", options));
  ASSERT_EQ(read.cameras.size(), 2U);
  EXPECT_EQ(read.cameras[1].name, "0001");
  EXPECT_FALSE(read.cameras[0].pictures.bottomUp);
  EXPECT_TRUE(read.cameras[1].pictures.bottomUp);
  for (int i = 0; i < 2; ++i) {
    const Camera& camera = read.cameras[static_cast<std::size_t>(i)].camera;
    for (const auto& [column, row] : {std::pair(0, 0), std::pair(23, 5), std::pair(11, 15)}) {
      const Vec3 step = (i == 0 ? -1 : 1) * v;
      const Vec3 cell =
          middle + (column - 0.5 * (kColumns - 1)) * u + (row - 0.5 * (kRows - 1)) * step;
      const auto seen = camera.project(Vec3(source + 0.4 * (cell - source)));
      ASSERT_TRUE(seen);
      EXPECT_NEAR(seen->x(), column + 0.5, 1e-9);
      EXPECT_NEAR(seen->y(), (i == 0 ? row : kRows - 1 - row) + 0.5, 1e-9);
    }
  }
  json["Vectors"][0][6] = json["Vectors"][0][7] = json["Vectors"][0][8] = 0;
  writeText(folder / "cone.json", json.dump());
  EXPECT_TRUE(failsWith(openCalibration(folder / "cone.json", options), "Vectors[0]: expected a"));
  json["type"] = "parallel3d_vec";
  writeText(folder / "cone.json", json.dump());
  EXPECT_TRUE(failsWith(openCalibration(folder / "cone.json", options), "type: is parallel3d_vec"));
}

TEST_F(Importers, AstraDetectorsAtAnyDistanceArePinholes) {
  nlohmann::json json{{"type", "cone_vec"},
                      {"DetectorRowCount", 16},
                      {"DetectorColCount", 24},
                      {"Vectors", nlohmann::json::array()}};
  for (int i = 0; i < 100; ++i) {
    const double far = 5 + 0.137 * i;
    json["Vectors"].push_back({0, -far, 0, 0, 0.41 * far, 0, 0.2, 0, 0, 0, 0, -0.2});
  }
  writeText(folder / "cone.json", json.dump());
  CaptureOptions options;
  options.bounds = Box3{Vec3(-0.5, -0.5, -0.5), Vec3(0.5, 0.5, 0.5)};
  options.resolution = {16, 0, 0};
  ASSERT_VALUE(const auto read, openCalibration(folder / "cone.json", options));
  EXPECT_EQ(read.cameras.size(), 100U);
}

TEST_F(Importers, NerfAnglesInDegreesAreRefused) {
  writeNerf(folder, true);
  auto json = readJson(folder / "transforms.json").value();
  json["camera_angle_x"] = 45.8;
  writeText(folder / "transforms.json", json.dump());
  EXPECT_TRUE(failsWith(openCapture(folder / "transforms.json", options),
                        "camera_angle_x: is 45.8; expected an angle of view in radians, from 0 to "
                        "below 3.1416: 45.8 degrees are 0.799361"));
}

TEST_F(Importers, NerfFilesHaveOneFocalLength) {
  writeNerf(folder, true);
  auto json = readJson(folder / "transforms.json").value();
  json["camera_angle_x"] = 0.4;  // an entry's own counts before it
  auto& first = json["frames"][0];
  const double right = 2 * std::atan(0.5 * testing::kWidth / first["fl_x"].get<double>());
  first["camera_angle_x"] = right;
  writeText(folder / "transforms.json", json.dump());
  EXPECT_TRUE(ok(openCapture(folder / "transforms.json", options)));
  first["camera_angle_x"] = 0.5 * right;
  writeText(folder / "transforms.json", json.dump());
  EXPECT_TRUE(failsWith(openCapture(folder / "transforms.json", options),
                        "expected one focal length: leave out what is wrong"));
  first.erase("camera_angle_x");
  first["camera_angle_y"] = 0.1;
  writeText(folder / "transforms.json", json.dump());
  EXPECT_TRUE(failsWith(openCapture(folder / "transforms.json", options),
                        "and camera_angle_y with h says"));
}

TEST_F(Importers, NerfAnglesOfBothSides) {
  writeNerf(folder, true);
  auto json = readJson(folder / "transforms.json").value();
  json["camera_angle_x"] = 2 * std::atan(0.5 * testing::kWidth / 30);
  json["camera_angle_y"] = 2 * std::atan(0.5 * testing::kHeight / 40);
  for (auto& frame : json["frames"]) {
    frame.erase("fl_x");
    frame.erase("fl_y");
  }
  writeText(folder / "transforms.json", json.dump());
  ASSERT_VALUE(const auto capture, openCapture(folder / "transforms.json", options));
  EXPECT_NEAR(capture.cameras[1].camera.intrinsics()(0, 0), 30, 1e-9);
  EXPECT_NEAR(capture.cameras[1].camera.intrinsics()(1, 1), 40, 1e-9);
}

TEST_F(Importers, NerfSizesAreThoseOfThePicturesUnlessStated) {
  const double focal = ringCalibration(0, kCameras).K(0, 0);
  const auto K = [&](bool angles, bool height) {
    writeNerf(folder, true);
    auto json = readJson(folder / "transforms.json").value();
    json.erase("w");
    if (!height)
      json.erase("h");
    if (angles) {
      json["camera_angle_x"] = 2 * std::atan(0.5 * testing::kWidth / focal);
      json["camera_angle_y"] = 2 * std::atan(0.25 * testing::kHeight / focal);
    }
    for (auto& frame : json["frames"]) {
      for (const char* key : {"cx", "cy", "fl_y"}) frame.erase(key);
      if (angles)
        frame.erase("fl_x");
    }
    writeText(folder / "transforms.json", json.dump());
    const auto capture = openCapture(folder / "transforms.json", options);
    EXPECT_TRUE(ok(capture));
    if (!capture)
      return Mat3(Mat3::Zero());
    EXPECT_EQ(capture->cameras[0].camera.width(), testing::kWidth);
    EXPECT_EQ(capture->cameras[0].camera.height(), testing::kHeight);
    return capture->cameras[0].camera.intrinsics();
  };
  for (const bool angles : {false, true}) {
    for (const bool height : {false, true}) {
      const Mat3 found = K(angles, height);
      EXPECT_NEAR(found(0, 0), focal, 1e-9);
      EXPECT_NEAR(found(1, 1), angles ? 2 * focal : focal, 1e-9);
      EXPECT_EQ(found(0, 2), 0.5 * testing::kWidth);
      EXPECT_EQ(found(1, 2), 0.5 * testing::kHeight);
    }
  }
}

TEST_F(Importers, ColmapModelsByHalves) {
  writeColmapText(folder, "\n");
  writeColmapBinary(folder);
  const auto text = folder / "text", bin = folder / "bin";
  std::filesystem::rename(text / "images.txt", folder / "images.txt");
  EXPECT_TRUE(failsWith(openCapture(text, options), "only cameras.txt is there; expected cameras"));
  std::filesystem::copy(bin / "images.bin", text / "images.bin");
  EXPECT_TRUE(failsWith(openCapture(text, options), "only cameras.txt and images.bin are there"));
  std::filesystem::copy(bin / "cameras.bin", text / "cameras.bin");
  expectOurs(text, "COLMAP");
  // A folder with both says which are read, and a file that is named says which.
  std::filesystem::rename(folder / "images.txt", text / "images.txt");
  writeText(text / "cameras.txt",
            "1 PINHOLE 24 16 30 30 12 8\n2 PINHOLE 24 16 30 30 12 8\n3 PINHOLE 24 16 30 30 12 8\n");
  const auto focal = [&](const std::filesystem::path& path) {
    return openCapture(path, options).value().cameras[0].camera.intrinsics()(0, 0);
  };
  expectOurs(text / "images.bin", "COLMAP");
  EXPECT_EQ(focal(text / "cameras.txt"), 30);
  EXPECT_EQ(focal(text), 30);
  const auto both = openCapture(text, options);
  EXPECT_TRUE(std::ranges::any_of(sentences(both->remarks), [](const std::string& remark) {
    return remark.find("as .txt and as .bin, and the .txt were read") != remark.npos;
  }));
  std::string cameras = testing::readBytes(bin / "cameras.bin");
  cameras[12] = 40;
  writeText(bin / "cameras.bin", cameras);
  EXPECT_TRUE(failsWith(openCapture(bin, options), "camera 1: its model has the number 40"));
  cameras[12] = 5;
  cameras.insert(64, std::string(32, '\0'));  // four more parameters of the first camera
  writeText(bin / "cameras.bin", cameras);
  EXPECT_TRUE(failsWith(openCapture(bin, options), "the camera model OPENCV_FISHEYE is not read"));
}

TEST_F(Importers, ColmapModelsAreCountedWhileTheyAreRead) {
  writeColmapText(folder, "\n");
  writeColmapBinary(folder);
  options.maxMemory = 4096;
  for (const char* kind : {"text", "bin"})
    EXPECT_TRUE(failsWith(openCalibration(folder / kind, options), "has more than 2 images"));
  options.maxMemory = 64 << 10;
  EXPECT_TRUE(openCalibration(folder / "text", options));
}

TEST_F(Importers, AFocalLengthInMillimetresIsRemarkedOn) {
  writeColmapText(folder, "\n");
  writeText(
      folder / "text" / "cameras.txt",
      "1 PINHOLE 24 16 3.5 3.5 12 8\n2 PINHOLE 24 16 25 25 12 8\n3 PINHOLE 24 16 25 25 12 8\n");
  const auto capture = openCalibration(folder / "text", options);
  ASSERT_TRUE(capture) << capture.error().message;
  EXPECT_TRUE(std::ranges::any_of(sentences(capture->remarks), [](const std::string& remark) {
    return remark.find("of 3.5 pixels is an angle of view of 147 degrees") != remark.npos;
  }));
}

TEST_F(Importers, ColmapModelsWithLenses) {
  writeColmapText(folder, "\n");
  const auto lensOf = [&](const std::string& model) {
    writeText(folder / "text" / "cameras.txt", fmt::format("1 {0}\n2 {0}\n3 {0}\n", model));
    auto capture = openCapture(folder / "text", options);
    return capture ? Result<Distortion>(capture->cameras[0].camera.distortion())
                   : Result<Distortion>(tl::unexpected(capture.error()));
  };
  EXPECT_EQ(lensOf("SIMPLE_PINHOLE 24 16 25 12 8").value(), Distortion{});
  EXPECT_EQ(lensOf("SIMPLE_RADIAL 24 16 25 12 8 0.1").value(), (Distortion{0.1, 0, 0, 0, 0}));
  EXPECT_EQ(lensOf("RADIAL 24 16 25 12 8 0.1 0.2").value(), (Distortion{0.1, 0.2, 0, 0, 0}));
  EXPECT_EQ(lensOf("OPENCV 24 16 25 26 12 8 .1 .2 .03 .04").value(),
            (Distortion{0.1, 0.2, 0.03, 0.04, 0}));
  EXPECT_TRUE(failsWith(lensOf("FULL_OPENCV 24 16 1 1 1 1 0 0 0 0 0 0 0 0"), "FULL_OPENCV"));
  EXPECT_TRUE(failsWith(lensOf("PINHOLE 24 16 25 12 8"), "has 3 parameters; expected 4"));
  EXPECT_TRUE(failsWith(lensOf("PINHOLE 24 16 25 x 12 8"), "cameras.txt: line 1: expected"));
}

TEST_F(Importers, ColmapTruncationsNeverCrash) {
  writeColmapBinary(folder);
  for (const char* name : {"cameras.bin", "images.bin"}) {
    const auto path = folder / "bin" / name;
    const std::string whole = testing::readBytes(path);
    for (std::size_t length = 0; length < whole.size(); length += 3) {
      writeText(path, whole.substr(0, length));
      EXPECT_FALSE(openCapture(folder / "bin", options)) << name << " " << length;
    }
    for (std::size_t bit = 0; bit < 8 * whole.size(); bit += 7) {
      std::string flipped = whole;
      flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
      writeText(path, flipped);
      (void)openCapture(folder / "bin", options).has_value();
    }
    writeText(path, whole);
  }
}

TEST_F(Importers, DamagedTextsNeverCrash) {
  writeNerf(folder, false);
  writeText(folder / "cameras.yml",
            fmt::format("%YAML:1.0\n---\n{}", fmt::join(openCvEntries(false), "")));
  for (const char* name : {"capture.json", "transforms.json", "cameras.yml"}) {
    const auto path = folder / name;
    const std::string whole = testing::readBytes(path);
    for (std::size_t i = 0; i < whole.size(); i += 13) {
      writeText(path, whole.substr(0, i));
      EXPECT_FALSE(i + 20 < whole.size() && openCapture(path, options).has_value() &&
                   std::string_view(name).ends_with("json"))
          << name << " " << i;
      std::string flipped = whole;
      flipped[i] = static_cast<char>(flipped[i] ^ (1 << i % 7));
      writeText(path, flipped);
      (void)openCapture(path, options).has_value();
    }
    writeText(path, whole);
  }
}

TEST_F(Importers, OpenCvFaults) {
  const auto with = [&](const std::string& text) {
    writeText(folder / "wrong.yml", "%YAML:1.0\n---\n" + text);
    return openCapture(folder / "wrong.yml", options);
  };
  const Calibration c = ringCalibration(0, kCameras);
  const auto K = openCvMatrix("K_a", c.K, false), R = openCvMatrix("R_a", c.R, false);
  EXPECT_TRUE(failsWith(with(K), "there is no matrix R_a"));
  EXPECT_TRUE(failsWith(with(K + R + openCvMatrix("T_a", Eigen::MatrixXd::Zero(2, 1), false)),
                        "T_a is 2 x 1 with 2 values; expected 3 x 1"));
  EXPECT_TRUE(failsWith(with("a: 1\n"), "no cameras; expected matrices K_NAME"));
  EXPECT_TRUE(failsWith(with("a: [1, 2\n"), "line 4: no valid YAML"));
  EXPECT_TRUE(failsWith(with(K + openCvMatrix("D_a", Eigen::MatrixXd::Ones(1, 8), false)),
                        "D_a has 8 coefficients"));
  EXPECT_TRUE(failsWith(with("fisheye_model: 1\n" + K + R), "fisheye lenses are not read"));
}

TEST_F(Importers, OpenCvMatricesAreThereOnceAndWrittenOut) {
  const Calibration c = ringCalibration(0, kCameras);
  const auto all = openCvMatrix("K_a", c.K, false) + openCvMatrix("R_a", c.R, false) +
                   openCvMatrix("T_a", c.t, false);
  writeText(folder / "a.yml", "%YAML:1.0\n---\n" + all + openCvMatrix("K_a", 2 * c.K, false));
  EXPECT_TRUE(failsWith(openCapture(folder / "a.yml", options), "K_a is there twice"));
  std::string aliases = "%YAML:1.0\n---\nbase: &base [";
  for (int i = 0; i < 1000; ++i) aliases += "0,";
  aliases += "0]\n";
  for (int i = 0; i < 100; ++i)
    aliases += fmt::format("K_{}: {{rows: 1, cols: 1001, data: *base}}\n", i);
  writeText(folder / "a.yml", aliases);
  EXPECT_TRUE(failsWith(openCapture(folder / "a.yml", options), "its matrices repeat others"));
}

TEST_F(Importers, OpenCvFilesThatAreAppendedToAreReadWhole) {
  auto entries = openCvEntries(false);
  const std::string last(entries.back());
  entries.pop_back();
  writeText(folder / "cameras.yml",
            fmt::format("%YAML:1.0\n---\n{}...\n---\n{}...\n---\n", fmt::join(entries, ""), last));
  expectOurs(folder / "cameras.yml", "OpenCV: 3 cameras, pixel centres at 0");
  writeText(folder / "cameras.yml",
            fmt::format("%YAML:1.0\n---\n{}{}...\n---\n{}", fmt::join(entries, ""), last, last));
  EXPECT_TRUE(failsWith(openCapture(folder / "cameras.yml", options), "T_c is there twice"));
}

TEST_F(Importers, OpenCvMatricesMeanOneThing) {
  const auto with = [&](const std::string& text) {
    writeText(folder / "a.yml",
              fmt::format("%YAML:1.0\n---\n{}{}", fmt::join(openCvEntries(false), ""), text));
    return openCapture(folder / "a.yml", options);
  };
  EXPECT_TRUE(failsWith(with("K_z: {rows: 3, cols: 3, rows: 1, data: [1]}\n"),
                        "rows is there twice in one matrix"));
  EXPECT_TRUE(failsWith(with("D_a: {rows: 5, cols: 1, data: [0, 0, 0, 0]}\n"), "D_a is no whole"));
  EXPECT_TRUE(failsWith(with("rvec_a: {rows: 3, cols: 1, data: [0, 0, 1]}\n"),
                        "camera a has both R_a and rvec_a"));
  EXPECT_TRUE(failsWith(
      with(
          "K_z: {rows: 3, cols: 3, data: [9, 0, 1, 0, 9, 1, 0, 0, 1]}\n"
          "T_z: {rows: 3, cols: 1, data: [0, 0, 1]}\nR_z: {rows: 3, cols: 1, data: [90, 0, 45]}\n"),
      "camera z is turned by 100.6 radians"));
  EXPECT_TRUE(
      failsWith(with("K_z: {rows: 3, cols: 3, dt: i, data: [9.5, 0, 1, 0, 9.5, 1, 0, 0, 1]}\n"),
                "K_z is no whole matrix; expected rows, cols and data of its type (dt)"));
  EXPECT_TRUE(failsWith(with("image_width: 24.5\n"), "the width of its pictures is 24.5"));
  EXPECT_TRUE(failsWith(with("error: *none\n"), "there is no &none before *none"));
  EXPECT_TRUE(failsWith(with("K_z: &z [*z]\n"), "there is no &z before *z"));
  EXPECT_TRUE(failsWith(with("error: \xE4\n"), "line 63: no valid YAML or JSON"));
  EXPECT_TRUE(failsWith(with("deep: " + std::string(70, '[') + "\n"), "more than 64 deep"));
  EXPECT_TRUE(
      ok(with("views: !!opencv-matrix\n   rows: 1\n   cols: 2\n   dt: \"2f\"\n"
              "   data: [ 1., .5, -.Inf, .Nan ]\n")));
  EXPECT_TRUE(
      ok(with("none: !!opencv-matrix\n   rows: 0\n   cols: 0\n   dt: d\n   data: []\n"
              "? [ 1, 2 ]\n: { a: [ [ 1 ], words ] }\nshared: &s [ 1, 2 ]\n"
              "one: { rows: 1, cols: 2, data: *s }\n")));
}

TEST_F(Importers, ColmapTextsThatAreCutBetweenLinesAreTold) {
  writeColmapText(folder, "\n");
  const auto path = folder / "text" / "images.txt";
  const std::string whole = testing::readBytes(path);
  const std::string two = whole.substr(0, whole.rfind("\n3 ") + 1);
  writeText(path, two);
  ASSERT_VALUE(const auto capture, openCapture(folder / "text", options));
  EXPECT_THAT(sentences(capture.remarks),
              ::testing::Contains(HasSubstr("1 of the 3 cameras have no image (3)")));
  const std::string head = "# Image list\n# Number of images: 3, mean observations per image: 2\n";
  writeText(path, head + two);
  EXPECT_TRUE(failsWith(openCapture(folder / "text", options),
                        "images.txt: has 2 images, and says at its begin that there are 3"));
  writeText(path, head + whole);
  EXPECT_TRUE(ok(openCapture(folder / "text", options)));
  std::string open = whole;
  while (open.ends_with('\n')) open.pop_back();
  writeText(path, head + open);
  EXPECT_TRUE(failsWith(openCapture(folder / "text", options), "does not end in an end of line"));
}

TEST_F(Importers, OpenCvCamerasNeverVanish) {
  const auto entries = openCvEntries(false);
  std::string whole = "%YAML:1.0\n---\n";
  for (const auto& entry : entries) whole += entry;
  writeText(folder / "c.yml", whole);
  ASSERT_VALUE(const auto all, openCapture(folder / "c.yml", options));
  const std::size_t least = all.cameras.size();
  // Cut at each line: fewer cameras are read only where the file ends behind a whole one.
  std::size_t fewer = 0;
  for (std::size_t at = whole.find("---\n") + 4; at + 1 < whole.size();) {
    at = whole.find('\n', at) + 1;
    writeText(folder / "c.yml", whole.substr(0, at));
    const auto capture = openCapture(folder / "c.yml", options);
    fewer += capture && capture->cameras.size() < least;
    if (capture && at < whole.size()) {
      EXPECT_TRUE(whole.substr(at).starts_with("K_") || whole.substr(at).starts_with("D_") ||
                  whole.substr(at).starts_with("image"))
          << whole.substr(at, 20);
    }
  }
  EXPECT_LT(fewer, least + 1);
  std::string slip = whole;
  slip.replace(slip.find("K_b"), 3, "L_b");
  writeText(folder / "c.yml", slip);
  EXPECT_TRUE(failsWith(openCapture(folder / "c.yml", options), "camera b has a pose (R_b)"));
  std::string empty = whole;
  const std::size_t rows = empty.find("rows", empty.find("K_c"));
  empty.replace(rows, 4, "rowz");
  writeText(folder / "c.yml", empty);
  EXPECT_TRUE(failsWith(openCapture(folder / "c.yml", options), "K_c is no whole matrix"));
}

TEST_F(Importers, OpenCvNamesThatNoCameraUsesAreRemarkedOn) {
  auto entries = openCvEntries(false);
  entries.push_back(openCvMatrix("D_aa", Eigen::MatrixXd::Ones(1, 5), false));
  entries.push_back(
      "image_width: 24\nimage_height: 16\nfisheye_model: 0\nerror: 0.25\nunits: mm\n");
  writeText(folder / "c.yml", fmt::format("%YAML:1.0\n---\n{}", fmt::join(entries, "")));
  ASSERT_VALUE(const auto capture, openCapture(folder / "c.yml", options));
  EXPECT_THAT(sentences(capture.remarks),
              ElementsAre(HasSubstr("OpenCV"), "no camera uses D_aa, error, units",
                          HasSubstr("25 frames a second")));
}

std::string xmlMatrix(const std::string& name, const Eigen::MatrixXd& m) {
  std::string data;
  for (int i = 0; i < m.rows(); ++i)
    for (int j = 0; j < m.cols(); ++j) data += " " + digits(m(i, j));
  return fmt::format(
      "<{0} type_id=\"opencv-matrix\">\n  <rows>{1}</rows>\n  <cols>{2}</cols>\n  <dt>d</dt>\n"
      "  <data>\n   {3}</data></{0}>\n",
      name, m.rows(), m.cols(), data);
}

template <class Values>
  requires requires(const Values& values) { asEigen(values); }
std::string xmlMatrix(const std::string& name, const Values& values) {
  return xmlMatrix(name, Eigen::MatrixXd(asEigen(values)));
}

TEST_F(Importers, OpenCvXml) {
  std::string text = "<?xml version=\"1.0\"?>\n<!-- by hand -->\n<opencv_storage>\n";
  for (int i = 0; i < kCameras; ++i) {
    Calibration c = ringCalibration(i, kCameras);
    c.K(0, 2) -= 0.5;
    c.K(1, 2) -= 0.5;
    const std::string name(1, static_cast<char>('a' + i));
    text += xmlMatrix("K_" + name, c.K) + xmlMatrix("R_" + name, c.R) + xmlMatrix("T_" + name, c.t);
  }
  text += "<calibration_time>\"today\"</calibration_time>\n";
  writeText(folder / "cameras.xml", text + "</opencv_storage>\n");
  EXPECT_TRUE(isCapture(folder / "cameras.xml").value());
  expectOurs(folder / "cameras.xml", "OpenCV: 3 cameras, pixel centres at 0");
  writeText(folder / "cut.xml", text);
  EXPECT_TRUE(failsWith(openCapture(folder / "cut.xml", options), "cut off or damaged"));
  writeText(folder / "other.xml", "<?xml version=\"1.0\"?><VTKFile></VTKFile>");
  EXPECT_FALSE(isCapture(folder / "other.xml").value());
  EXPECT_TRUE(failsWith(openCapture(folder / "other.xml", options), "expected OpenCV's"));
  writeText(folder / "half.xml",
            "<opencv_storage><K_a><rows>3</rows><cols>3</cols></K_a></opencv_storage>");
  EXPECT_TRUE(failsWith(openCapture(folder / "half.xml", options), "K_a is no whole matrix"));
}

TEST_F(Importers, OpenCvStereoSample) {
  const Calibration a = ringCalibration(0, kCameras), b = ringCalibration(1, kCameras);
  const Mat3 turn = b.R * a.R.transpose();
  const Vec3 shift = b.t - turn * a.t;
  const std::string head = "%YAML:1.0\n---\n";
  const std::string lenses = openCvMatrix("M1", a.K, false) + openCvMatrix("M2", b.K, false);
  const std::string pose = openCvMatrix("R", turn, false) + openCvMatrix("T", shift, false) +
                           openCvMatrix("R1", Mat3::Identity(), false);
  std::filesystem::rename(folder / "f_0004_a.exr", folder / "s_0004_1.exr");
  std::filesystem::rename(folder / "f_0004_b.exr", folder / "s_0004_2.exr");
  options.images = (folder / "s_%04d_{camera}.exr").string();
  options.frames = {4, 5};
  writeText(folder / "intrinsics.yml", head + lenses);
  EXPECT_TRUE(failsWith(openCapture(folder / "intrinsics.yml", options), "without R and T"));
  writeText(folder / "extrinsics.yml", head + pose);
  writeText(folder / "both.yml", head + lenses + pose);
  for (const char* file : {"intrinsics.yml", "extrinsics.yml", "both.yml"}) {
    ASSERT_VALUE(const auto capture, openCapture(folder / file, options));
    ASSERT_EQ(capture.cameras.size(), 2U);
    EXPECT_EQ(capture.cameras[0].name, "1");
    EXPECT_NEAR(capture.cameras[0].camera.eye().norm(), 0, 1e-12);
    EXPECT_NEAR((capture.cameras[1].camera.rotation() - turn).norm(), 0, 1e-12);
    EXPECT_NEAR((capture.cameras[1].camera.eye() + turn.transpose() * shift).norm(), 0, 1e-9);
    EXPECT_THAT(sentences(capture.remarks), Contains(HasSubstr("the world is that of camera 1")));
  }
}

TEST_F(Importers, OpenCvCalibrationSample) {
  std::filesystem::create_directory(folder / "boards");
  for (int i = 0; i < kCameras; ++i) {
    const Calibration c = ringCalibration(i, kCameras);
    const Eigen::AngleAxisd turn(asEigen(c.R));
    Eigen::MatrixXd poses = Eigen::MatrixXd::Constant(2, 6, 0.25);
    poses.row(0) << (turn.angle() * turn.axis()).transpose(), asEigen(c.t).transpose();
    writeText(folder / "boards" / fmt::format("{}.yml", static_cast<char>('a' + i)),
              "%YAML:1.0\n---\nnframes: 2\nimage_width: 24\nimage_height: 16\n" +
                  openCvMatrix("camera_matrix", c.K, false) +
                  openCvMatrix("extrinsic_parameters", poses, false));
  }
  ASSERT_VALUE(const auto capture, openCapture(folder / "boards" / "b.yml", options));
  ASSERT_EQ(capture.cameras.size(), static_cast<std::size_t>(kCameras));
  for (int i = 0; i < kCameras; ++i) {
    const Calibration c = ringCalibration(i, kCameras);
    const auto& camera = capture.cameras[static_cast<std::size_t>(i)].camera;
    EXPECT_NEAR((camera.rotation() - c.R).norm(), 0, 1e-9);
    EXPECT_NEAR((camera.rotation() * camera.eye() + c.t).norm(), 0, 1e-9);
  }
  EXPECT_THAT(sentences(capture.remarks), Contains(HasSubstr("the board in the first view")));
  EXPECT_THAT(sentences(capture.remarks), ::testing::Not(Contains(HasSubstr("left out"))));
  writeText(folder / "boards" / "d.yml", "%YAML:1.0\n---\ncamera_matrix: [\n");
  ASSERT_VALUE(const auto damaged, openCapture(folder / "boards" / "b.yml", options));
  EXPECT_THAT(sentences(damaged.remarks),
              Contains(::testing::AllOf(HasSubstr("a file of its folder cannot be read"),
                                        HasSubstr("d.yml"))));
}

TEST_F(Importers, OpenCvRotationVectors) {
  const Calibration c = ringCalibration(1, kCameras);
  const Eigen::AngleAxisd turn(asEigen(c.R));
  writeText(folder / "v.yml", "%YAML:1.0\n---\n" + openCvMatrix("K_b", c.K, false) +
                                  openCvMatrix("rvec_b", turn.angle() * turn.axis(), false) +
                                  openCvMatrix("tvec_b", c.t, false));
  ASSERT_VALUE(const auto capture, openCapture(folder / "v.yml", options));
  EXPECT_NEAR((capture.cameras[0].camera.rotation() - c.R).norm(), 0, 1e-12);
}

TEST_F(Importers, WithoutPicturesAPatternIsAskedFor) {
  writeColmapText(folder, "\n");
  options.images.reset();
  EXPECT_TRUE(failsWith(openCapture(folder / "text", options), "has no pictures"));
  options.images = (folder / "f_%04d.exr").string();
  EXPECT_TRUE(failsWith(openCapture(folder / "text", options), "{camera} is missing"));
}

}  // namespace
}  // namespace volute
