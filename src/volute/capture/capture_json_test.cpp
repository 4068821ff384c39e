// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "volute/capture/testing.hpp"
#include "volute/capture/write_capture.hpp"

namespace volute {
namespace {

using ::testing::Contains;
using testing::failsWith;
using ::testing::HasSubstr;
using testing::ok;
using testing::ringCalibration;
using testing::ringJson;
using testing::sentences;
using testing::TempFolder;

Result<Capture> openJson(const TempFolder& folder, const nlohmann::json& json,
                         const CaptureOptions& options = {}) {
  testing::writeText(folder / "capture.json", json.dump(1));
  return openCapture(folder / "capture.json", options);
}

TEST(CaptureJson, IsReadWhole) {
  const TempFolder folder;
  auto json = ringJson();
  json["noise_sigma"] = 0.02;
  json["white"] = 3;
  json["color"] = "gamma:2.2";
  json["cameras"][1]["gain"] = 1.5;
  json["cameras"][1]["color"] = {{"table", {0, 0.25, 1}}};
  json["cameras"][1]["distortion"] = {0.1, 0.01, 0.001, -0.001, 0};
  json["cameras"][1]["background"] = "back.exr";
  ASSERT_VALUE(const auto capture, openJson(folder, json));
  EXPECT_EQ(capture.kind, "capture.json");
  EXPECT_EQ(capture.frames, (std::vector<int>{4, 5}));
  EXPECT_EQ(capture.noiseSigma, 0.02);
  EXPECT_EQ(capture.white, 3);
  EXPECT_EQ(capture.volume.resolution, (std::array<int, 3>{8, 8, 8}));
  ASSERT_EQ(capture.cameras.size(), 3u);
  const auto& b = capture.cameras[1];
  EXPECT_EQ(b.name, "b");
  EXPECT_EQ(b.pictures.image, (folder / "f_%04d_b.exr").string());
  EXPECT_EQ(b.pictures.background, folder / "back.exr");
  EXPECT_EQ(b.pictures.gain, 1.5);
  EXPECT_EQ(b.pictures.response->name(), "table of 3 values");
  EXPECT_EQ(b.camera.distortion(), (Distortion{0.1, 0.01, 0.001, -0.001, 0}));
  EXPECT_NEAR((b.camera.intrinsics() - ringCalibration(1, 3).K).norm(), 0, 1e-12);
  EXPECT_EQ(capture.cameras[0].pictures.response->name(), "gamma:2.2");
  EXPECT_THAT(sentences(capture.remarks), Contains(HasSubstr("pixel centres at 0.5")));
}

TEST(CaptureJson, PicturesAreFoundAsWindowsNamesThem) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "Views");
  testing::writeText(folder / "Views" / "back.exr", "");
  auto json = ringJson();
  json["cameras"][1]["image"] = "views\\f_%04d_b.exr";
  json["cameras"][1]["background"] = "VIEWS\\Back.EXR";
  ASSERT_VALUE(const auto capture, openJson(folder, json));
  EXPECT_EQ(capture.cameras[1].pictures.image, (folder / "Views" / "f_%04d_b.exr").string());
  EXPECT_EQ(capture.cameras[1].pictures.background, folder / "Views" / "back.exr");
  EXPECT_THAT(sentences(capture.remarks), Contains(HasSubstr("differ from those of the files")));
}

TEST(CaptureJson, EveryErrorNamesItsPlace) {
  const TempFolder folder;

  struct Case {
    const char* pointer;
    nlohmann::json value;
    const char* message;
  };

  const Case cases[] = {
      {"/format", "volute-capture-9", "capture.json: format: is 'volute-capture-9'"},
      {"/color", "rec709", "color: 'rec709' is no known response"},
      {"/white", 0, "white: is 0; expected more than 0"},
      {"/pixel_centre", 0.25, "pixel_centre: expected 0.5 or 0"},
      {"/frames", {5, 4}, "frames[1]: expected frame numbers that ascend"},
      {"/frames", nlohmann::json::array(), "frames: expected at least one frame"},
      {"/volume/min", {1, -1, -1}, "volume: min is not below max"},
      {"/volume/resolution/2", 0, "volume.resolution[2]: expected 1 to"},
      {"/volume/resolution", {4, 4}, "volume.resolution: expected three"},
      {"/cameras/2/name", 3, "cameras[2].name: expected a text"},
      {"/cameras/2/name", "a", "cameras[2]: a second camera 'a'"},
      {"/cameras/1/width", -3, "cameras[1].width: is -3"},
      {"/cameras/1/K/1", {0, 1}, "cameras[1].K[1]: expected 3 numbers"},
      {"/cameras/1/K/1/2", "x", "cameras[1].K[1][2]: expected a number"},
      {"/cameras/1/t", {1, 2}, "cameras[1].t: expected 3 numbers"},
      {"/cameras/1/gain", -1, "cameras[1].gain: is -1"},
      {"/cameras/1/exponent", 0, "cameras[1].exponent: is 0; expected 0.1 to 10"},
      {"/cameras/1/reprojection_error", -1, "cameras[1].reprojection_error: expected 0 to 20"},
      {"/albedo", 2, "albedo: expected 0 to 1"},
      {"/lamps", {{{"kind", "moon"}}}, "lamps[0].kind: is 'moon'; expected 'sun' or 'point'"},
      {"/lamps",
       {{{"kind", "sun"}, {"direction", {0, 0, 0}}, {"radiance", 1}}},
       "lamps[0].direction: expected the direction"},
      {"/lamps",
       {{{"kind", "sun"}, {"direction", {0, 0, -1}}, {"radiance", 0}}},
       "lamps[0].radiance: expected a number above 0"},
      {"/cameras/1/distortion", {1, 2}, "cameras[1].distortion: expected the 4 or 5 numbers"},
      {"/cameras/1/image", "a_%d_%d.exr", "cameras[1].image: expected one frame number"},
      {"/cameras/0/video", "a.mp4", "cameras[0].video: the camera has an image too"},
      {"/cameras/0/color", {{"table", {1, 0}}}, "cameras[0].color.table: expected at least two"},
      {"/cameras", 7, "cameras: expected a list"},
  };
  for (const Case& wrong : cases) {
    auto json = ringJson();
    json[nlohmann::json::json_pointer(wrong.pointer)] = wrong.value;
    EXPECT_TRUE(failsWith(openJson(folder, json), wrong.message)) << wrong.pointer;
  }
}

TEST(CaptureJson, MissingPartsAreNamed) {
  const TempFolder folder;
  for (const char* key : {"name", "width", "height", "K", "R", "t"}) {
    auto json = ringJson();
    json["cameras"][1].erase(key);
    EXPECT_TRUE(failsWith(openJson(folder, json), fmt::format("cameras[1]: '{}' is missing", key)));
  }
  auto json = ringJson();
  json["cameras"][2].erase("image");
  EXPECT_TRUE(failsWith(openJson(folder, json), "cameras[2] (c): has no pictures"));
  json = ringJson();
  json.erase("volume");
  EXPECT_TRUE(failsWith(openJson(folder, json), "where the volume is"));
  json["cameras"].clear();
  EXPECT_TRUE(failsWith(openJson(folder, json), "has no cameras"));
}

TEST(CaptureJson, ImpossibleCamerasAreNamed) {
  const TempFolder folder;
  auto json = ringJson();
  for (auto& value : json["cameras"][1]["R"][0]) value = -value.get<double>();
  EXPECT_TRUE(failsWith(openJson(folder, json), "cameras[1] (b): R is mirrored (determinant -1)"));
  json = ringJson();
  for (auto& value : json["cameras"][2]["R"][0]) value = 1.1 * value.get<double>();
  EXPECT_TRUE(failsWith(openJson(folder, json),
                        "cameras[2] (c): R is no rotation: R R' is off the "
                        "identity by 0.21"));
}

TEST(CaptureJson, UnknownKeysAreRemarked) {
  const TempFolder folder;
  auto json = ringJson();
  json["cameras"][1]["distorsion"] = {0, 0, 0, 0, 0};
  ASSERT_VALUE(const auto capture, openJson(folder, json));
  EXPECT_THAT(sentences(capture.remarks),
              Contains("cameras[1].distorsion is not known and ignored"));
}

TEST(CaptureJson, MembersWithoutEffectAreRemarked) {
  const TempFolder folder;
  auto json = ringJson();
  json["color"] = {{"table", {0, 1}}, {"gamma", 2.2}};
  json["lamps"] = {{{"kind", "sun"}, {"direction", {0, 0, -1}}, {"radiance", 1}, {"intensity", 2}}};
  json["empty_frames"] = {1, 2};
  json["cameras"][0]["background"] = "back.exr";
  json["spectrum"] = {
      {"sensitivities", {{450, 0, 0.1, 0.9}, {550, 0.5, 1, 1}, {700, 0, 0, 0}}},
      {"black_body", {{"temperature", 1800}, {"radiance", {1, 1, 1}}, {"unit", "C"}}},
      {"scale", {1, 1, 1}}};
  ASSERT_VALUE(const auto capture, openJson(folder, json));
  EXPECT_THAT(sentences(capture.remarks),
              ::testing::IsSupersetOf(
                  {HasSubstr("color.gamma is not known"), HasSubstr("lamps[0].intensity is not"),
                   HasSubstr("camera a: \"background\" counts, and \"empty_frames\" are not"),
                   HasSubstr("spectrum.black_body.unit is not"), HasSubstr("spectrum.scale is not"),
                   HasSubstr("ends at 450 nm, where green is 10 % of"),
                   HasSubstr("ends at 450 nm, where blue is 90 % of")}));
  EXPECT_EQ(capture.remarks[0].code, RemarkCode::kNote) << "what is stated is no assumption";
  for (std::size_t i = 1; i < capture.remarks.size(); ++i)
    EXPECT_NE(capture.remarks[i].code, RemarkCode::kNote) << capture.remarks[i].sentence;
}

TEST(CaptureJson, HowFloatsAreStoredHasNoEffect) {
  const TempFolder folder;
  testing::writeRingPictures(folder);
  auto json = ringJson();
  json["frames_per_second"] = 25;
  ASSERT_VALUE(const auto right, openJson(folder, json));
  EXPECT_EQ(right.remarks.size(), 1U);
  json["black"] = 0.1, json["bits"] = 12;
  CaptureOptions options;
  options.response = Response::srgb();
  ASSERT_VALUE(const auto capture, openJson(folder, json, options));
  EXPECT_THAT(
      sentences(capture.remarks),
      Contains(HasSubstr("cameras a, b, c: \"color\", \"black\", \"bits\" have no effect on "
                         "pictures of floats")));
}

TEST(CaptureJson, FramesWithoutAnyPictureAreTold) {
  const TempFolder folder;
  testing::writeRingPictures(folder);
  auto json = ringJson();
  json["frames_per_second"] = 25;
  json.erase("frames");
  for (const char* name : {"a", "b", "c"})
    std::filesystem::rename(folder / fmt::format("f_0005_{}.exr", name),
                            folder / fmt::format("f_0008_{}.exr", name));
  ASSERT_VALUE(const auto even, openJson(folder, json));
  EXPECT_EQ(even.remarks.size(), 1U) << "they are four apart";
  std::filesystem::copy(folder / "f_0004_a.exr", folder / "f_0006_a.exr");
  std::filesystem::copy(folder / "f_0004_a.exr", folder / "f_0010_a.exr");
  std::filesystem::copy(folder / "f_0004_a.exr", folder / "f_0014_a.exr");
  ASSERT_VALUE(const auto gap, openJson(folder, json));
  EXPECT_THAT(sentences(gap.remarks), Contains(HasSubstr("12: no camera has a picture")));
}

TEST(CaptureJson, OptionsGoBeforeTheFile) {
  const TempFolder folder;
  CaptureOptions options;
  options.bounds = Box3{Vec3(-2, -1, 0), Vec3(2, 1, 1)};
  options.resolution = {16, 0, 0};
  options.images = "elsewhere/{camera}_####.png";
  options.frames = {5, 9, 1};
  options.response = Response();
  ASSERT_VALUE(const auto capture, openJson(folder, ringJson(), options));
  EXPECT_EQ(capture.volume.bounds.max, Vec3(2, 1, 1));
  EXPECT_EQ(capture.volume.resolution, (std::array<int, 3>{16, 8, 4}));
  EXPECT_EQ(capture.cameras[2].pictures.image, "elsewhere/c_####.png");
  EXPECT_EQ(capture.frames, (std::vector<int>{5}));
  options.frames = {7, 9, 1};
  EXPECT_TRUE(failsWith(openJson(folder, ringJson(), options), "the capture has frames 4 to 5"));
}

TEST(CaptureJson, FramesAreThoseOfThePictures) {
  const TempFolder folder;
  testing::writeRingPictures(folder);
  auto json = ringJson();
  json.erase("frames");
  ASSERT_VALUE(const auto capture, openJson(folder, json));
  EXPECT_EQ(capture.frames, (std::vector<int>{4, 5}));
  json["cameras"][0]["image"] = "g_%04d.exr";
  json["cameras"][1]["image"] = "g_%04d.exr";
  json["cameras"][2]["image"] = "g_%04d.exr";
  EXPECT_TRUE(failsWith(openJson(folder, json), "no picture is called"));
}

TEST(CaptureJson, TwoEmptyFramesAreARange) {
  const TempFolder folder;
  auto json = ringJson();
  json["empty_frames"] = {0, 3};
  EXPECT_EQ(openJson(folder, json).value().emptyFrames, (std::vector<int>{0, 1, 2, 3}));
  json["empty_frames"] = {0, 3, 8};
  EXPECT_EQ(openJson(folder, json).value().emptyFrames, (std::vector<int>{0, 3, 8}));
}

TEST(CaptureJson, GainsSpectraAndExposuresAreReadWrittenAndRefused) {
  const TempFolder folder;
  auto json = ringJson();
  json["cameras"][0]["gain"] = {1.1, 1, 0.9};
  json["cameras"][1]["gain"] = 2;
  json["cameras"][1]["exposure"] = 4;
  testing::writeText(folder / "rgb.csv",
                     "nm,r,g,b\n450,0,0,1\n500,0,.5,.5\n550,0,1,0\n600,1,.2,0\n650,.5,0,0\n");
  const nlohmann::json body{{"temperature", 1800}, {"radiance", {0.8, 0.3, 0.05}}};
  json["spectrum"] = {{"sensitivities", "rgb.csv"}, {"black_body", body}, {"soot_exponent", 1.2}};
  ASSERT_VALUE(const auto capture, openJson(folder, json));
  EXPECT_TRUE((capture.cameras[0].pictures.channelGain == Rgb(1.1, 1, 0.9)).all());
  EXPECT_EQ(capture.cameras[1].pictures.lightGain(), 0.5);
  EXPECT_TRUE(capture.spectrum.blackBody(1800).isApprox(Rgb(0.8, 0.3, 0.05), 1e-12));
  EXPECT_EQ(capture.spectrum.sootExponent, 1.2);
  // Its own rows, or one wavelength a channel.
  json["spectrum"] = {{"wavelengths", {620, 540, 460}}, {"radiance_scale", 0.5}};
  ASSERT_VALUE(const auto narrow, openJson(folder, json));
  EXPECT_NEAR(narrow.spectrum.blackBody(1500)[1], 0.5 * planck(540, 1500), 1e-12);
  EXPECT_THAT(sentences(narrow.remarks), ::testing::Not(Contains(HasSubstr("order"))));
  json["spectrum"]["wavelengths"] = {460, 540, 620};
  ASSERT_VALUE(const auto reversed, openJson(folder, json));
  EXPECT_THAT(sentences(reversed.remarks), Contains(HasSubstr("in another order?")));
  ASSERT_TRUE(writeCapture(folder / "again.json", capture));
  ASSERT_VALUE(const auto again, openCapture(folder / "again.json", {}));
  EXPECT_TRUE(
      again.spectrum.sootEmission(1600).isApprox(capture.spectrum.sootEmission(1600), 1e-9));
  EXPECT_TRUE((again.cameras[0].pictures.channelGain == Rgb(1.1, 1, 0.9)).all());
  const auto refused = [&](const nlohmann::json& spectrum, const char* text) {
    json["spectrum"] = spectrum;
    const auto read = openJson(folder, json);
    ASSERT_FALSE(read) << text;
    EXPECT_THAT(read.error().message, HasSubstr(text));
  };
  refused({{"black_body", body}}, "expected one of 'sensitivities' and 'wavelengths'");
  refused({{"wavelengths", {620, 540, 460}}}, "expected one of 'black_body' and 'radiance_scale'");
  refused({{"wavelengths", {0.62, 0.54, 0.46}}, {"radiance_scale", 1}}, "expected 200 to 3000 nm");
  refused({{"sensitivities", {{500, 1, 1, 0}, {600, 1, 1, 0}}}, {"radiance_scale", 1}},
          "a channel sees no light");
  refused({{"sensitivities", {{600, 1, 1, 1}, {500, 1, 1, 1}}}, {"radiance_scale", 1}},
          "do not ascend at 500 nm");
  const nlohmann::json bad{{"sensitivities", "bad.csv"}, {"radiance_scale", 1}};
  testing::writeText(folder / "bad.csv", "nm,r,g,b\n450,0,0\n");
  refused(bad, "bad.csv: line 2: 3 columns; expected 4");
  testing::writeText(folder / "bad.csv", "nm,r,g,x\n450,0,0,1\n");
  refused(bad, "bad.csv: line 1: unknown column 'x'");
  // Columns go by their names; without names by their order.
  for (const char* text : {"wavelength [um],Blue,green,R\n.45,1,0,0\n.5,.5,.5,0\n.55,0,1,0\n"
                           ".6,0,.2,1\n.65,0,0,.5\n",
                           "450 0 0 1\n500 0 .5 .5\n550 0 1 0\n600 1 .2 0\n650 .5 0 0\n"}) {
    testing::writeText(folder / "other.csv", text);
    json["spectrum"] = {
        {"sensitivities", "other.csv"}, {"black_body", body}, {"soot_exponent", 1.2}};
    ASSERT_VALUE(const auto named, openJson(folder, json));
    EXPECT_TRUE(
        named.spectrum.sootEmission(1600).isApprox(capture.spectrum.sootEmission(1600), 1e-9));
  }
  refused({{"sensitivities", "none.csv"}, {"radiance_scale", 1}}, "none.csv");
  json.erase("spectrum");
  json["cameras"][0]["gain"] = {1, 0, 1};
  EXPECT_FALSE(openJson(folder, json));
}

TEST(CaptureJson, SaysWhatPicturesMeasure) {
  const TempFolder folder;
  auto json = ringJson();
  for (const auto& [name, measured] : {std::pair("emission", Measured::kEmission),
                                       std::pair("absorption", Measured::kAbsorption)}) {
    json["kind"] = name;
    ASSERT_VALUE(const auto capture, openJson(folder, json));
    EXPECT_EQ(capture.measured, measured);
  }
  json["kind"] = "x-ray";
  EXPECT_TRUE(failsWith(openJson(folder, json), "kind: is 'x-ray'; expected 'emission' or "));
}

TEST(CaptureJson, OtherFilesAreNoCaptures) {
  const TempFolder folder;
  testing::writeText(folder / "x.json", "{\"a\": 1}");
  EXPECT_TRUE(failsWith(openCapture(folder / "x.json", {}), "no capture; expected"));
  testing::writeText(folder / "x.json", "{\"a\": ");
  EXPECT_TRUE(failsWith(openCapture(folder / "x.json", {}), "line 1 is no valid JSON"));
  testing::writeText(folder / "x.dat", "");
  EXPECT_TRUE(failsWith(openCapture(folder / "x.dat", {}), "not a known kind of calibration"));
  EXPECT_TRUE(failsWith(openCapture(folder / "none.json", {}), "there is no such file"));
}

}  // namespace
}  // namespace volute
