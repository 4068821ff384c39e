// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/line_reconstruction.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "volute/base/remark_log.hpp"
#include "volute/tomography/line_volumes.hpp"

namespace volute {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

const VolumeGeometry kGeometry{{Vec3(0, 0, 0), Vec3(4, 3, 2)}, {16, 12, 8}};

/// Smoke in a room, thicker under the ceiling and in a corner, up to the walls [1/m].
double smoke(const Vec3& at) {
  const double layer = 0.4 / (1 + std::exp(-(at.z() - 1.2) / 0.15));
  return layer + 0.5 * std::exp(-((at - Vec3(3, 1, 1.4)).squaredNorm()) / 0.5);
}

/// By steps of 5 mm.
double depthAlong(const Segment& line) {
  const auto inside =
      kGeometry.bounds.intersect(line.origin, line.direction).intersect({line.begin, line.end});
  const int steps = std::max(1, static_cast<int>(inside.length() / 0.005));
  const double step = inside.length() / steps;
  double sum = 0;
  for (int i = 0; i < steps; ++i) sum += step * smoke(line.at(inside.begin + (i + 0.5) * step));
  return sum;
}

/// Lines from lamps on the walls to cameras in other places.
std::vector<LineMeasurement> measured(int count, double noise) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  std::vector<LineMeasurement> lines;
  while (static_cast<int>(lines.size()) < count) {
    Vec3 ends[2];
    for (Vec3& end : ends) {
      end = Vec3(uniform(random), uniform(random), uniform(random))
                .cwiseProduct(kGeometry.bounds.size());
      const int axis = static_cast<int>(random() % 3);
      end[axis] = random() % 2 == 0 ? 0 : kGeometry.bounds.max[axis];
    }
    const Vec3 way = ends[1] - ends[0];
    if (way.cwiseAbs().minCoeff() < 0.05)
      continue;  // along a wall
    LineMeasurement one{
        {ends[0], way.normalized(), 0, way.norm()}, 0, 0.02, static_cast<int>(lines.size()) + 2};
    one.value = depthAlong(one.line) + noise * normal(random);
    lines.push_back(one);
  }
  return lines;
}

double relativeError(std::span<const float> volume) {
  double off = 0, all = 0;
  const auto& n = kGeometry.resolution;
  for (std::size_t i = 0; i < volume.size(); ++i) {
    const auto x = static_cast<int>(i) % n[0], y = static_cast<int>(i) / n[0] % n[1],
               z = static_cast<int>(i) / n[0] / n[1];
    const double truth = smoke(Vec3(x + 0.5, y + 0.5, z + 0.5).cwiseProduct(kGeometry.voxelSize()));
    off += std::pow(volume[i] - truth, 2), all += truth * truth;
  }
  return std::sqrt(off / all);
}

TEST(LineReconstruction, SmokeFromLampsThroughIt) {
  Progress progress;
  for (const double noise : {0.0, 0.02}) {
    const auto lines = measured(600, noise);
    const auto found = reconstructLines(lines, kGeometry, {}, progress);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT(relativeError(found->volume), 0.1) << noise;
    if (noise == 0) {
      LineOptions fading;
      fading.basis = Basis::kTrilinear;
      const auto other = reconstructLines(lines, kGeometry, fading, progress);
      ASSERT_TRUE(other);
      EXPECT_GT(relativeError(other->volume), relativeError(found->volume)) << "smoke at the walls";
    }
    EXPECT_LT(found->leftOut, 0.06);
    EXPECT_LT(found->residual, found->leftOut);
    EXPECT_GT(found->crossed, 0.8);
    if (noise > 0) {
      EXPECT_GT(found->spread, 0.2);  // 600 lines and 1536 voxels: some of the noise is fitted
      EXPECT_LT(found->spread, 1.2);
      // A strength that nobody chose is worse, to both sides.
      for (const double other : {1.0, 1e-6}) {
        LineOptions options;
        options.lambda = other;
        const auto fixed = reconstructLines(lines, kGeometry, options, progress);
        ASSERT_TRUE(fixed);
        EXPECT_GT(relativeError(fixed->volume), relativeError(found->volume)) << other;
      }
    }
  }
}

TEST(LineReconstruction, WhatIsSoMuchAtLeastMayBeMore) {
  Progress progress;
  auto lines = measured(600, 0);
  double most = 0;
  for (const LineMeasurement& one : lines) most = std::max(most, one.value);
  for (LineMeasurement& one : lines) one.value = std::min(one.value, 0.5 * most);
  const auto capped = reconstructLines(lines, kGeometry, {}, progress);
  ASSERT_TRUE(capped);
  for (LineMeasurement& one : lines) one.atLeast = one.value == 0.5 * most;
  const auto bounded = reconstructLines(lines, kGeometry, {}, progress);
  ASSERT_TRUE(bounded);
  EXPECT_LT(relativeError(bounded->volume), 0.8 * relativeError(capped->volume));
}

TEST(LineReconstruction, LinesThatEndWithinTheVolumeCountAsFarAsTheyGo) {
  // The same smoke everywhere, which only lengths tell.
  std::vector<LineMeasurement> lines;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0.15, 0.85);
  while (lines.size() < 200) {
    Vec3 ends[2];
    for (Vec3& end : ends)
      end = Vec3(uniform(random), uniform(random), uniform(random))
                .cwiseProduct(kGeometry.bounds.size());
    const double length = (ends[1] - ends[0]).norm();
    if (length > 0.3)
      lines.push_back({{ends[0], (ends[1] - ends[0]).normalized(), 0, length}, 0.3 * length, 1, 2});
  }
  Progress progress;
  const auto found = reconstructLines(lines, kGeometry, {}, progress);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_LT(found->residual, 0.01);
  for (const float value : found->volume) EXPECT_NEAR(value, 0.3, 0.02);
}

TEST(LineReconstruction, RefusesLinesBesideTheVolume) {
  auto lines = measured(10, 0);
  lines[4].line.origin += Vec3(100, 0, 0);
  EXPECT_THAT(linesBeside(lines, kGeometry), ::testing::ElementsAre(4));
  Progress progress;
  const auto found = reconstructLines(lines, kGeometry, {}, progress);
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("row 6: the line misses the volume"));
  EXPECT_THAT(found.error().message, HasSubstr("1 of 10 lines"));
  // A line that ends before it reaches the volume misses it as well.
  lines = measured(10, 0);
  lines[0].line = {Vec3(-2, 1, 1), Vec3::UnitX(), 0, 1.5};
  EXPECT_THAT(linesBeside(lines, kGeometry), ::testing::ElementsAre(0));
}

class LineFileTest : public ::testing::Test {
 protected:
  Result<LineFile> read(const std::string& text) {
    std::ofstream(file_) << text;
    return readLines(file_);
  }

  std::string refusal(const std::string& text) {
    const auto lines = read(text);
    EXPECT_FALSE(lines) << text;
    return lines ? "" : lines.error().message;
  }

  ~LineFileTest() override { std::filesystem::remove(file_); }

  std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / fmt::format("volute-lines-{}.csv", ::getpid());
};

TEST_F(LineFileTest, TakesNoMoreMemoryThanIsAllowed) {
  std::string text = "x0,y0,z0,x1,y1,z1,value\n";
  for (int i = 0; i < 1000; ++i) text += "0,0,0,3,4,0,1\n";
  ASSERT_TRUE(read(text));
  ASSERT_TRUE(readLines(file_, 1 << 20));
  for (const std::uint64_t allowed : {10'000, 100'000}) {  // not the text, not its rows
    const auto lines = readLines(file_, allowed);
    ASSERT_FALSE(lines);
    EXPECT_EQ(lines.error().code, ErrorCode::kTooLarge);
    EXPECT_THAT(lines.error().message, HasSubstr("its lines need 1 MiB, more than the 0 MiB"));
  }
}

TEST_F(LineFileTest, ReadsEndsAndDirections) {
  const auto ends = read(
      "# a comment\n\n X0,y0,z0, x1,y1,z1 ,Optical_Depth,sigma,frame\r\n"
      "0,0,0,3,4,0,0.5,0.1,7\n0,0,1,0,0,3,1,0.2,4\n");
  ASSERT_TRUE(ends) << ends.error().message;
  EXPECT_TRUE(ends->opticalDepths);
  EXPECT_TRUE(ends->hasSigma);
  ASSERT_EQ(ends->frames.size(), 2U);
  EXPECT_EQ(ends->frames[0].number, 4);
  EXPECT_EQ(ends->frames[1].number, 7);
  const LineMeasurement& one = ends->frames[1].lines.at(0);
  EXPECT_TRUE(one.line.direction.isApprox(Vec3(0.6, 0.8, 0)));
  EXPECT_DOUBLE_EQ(one.line.end, 5);
  EXPECT_EQ(one.value, 0.5);
  EXPECT_EQ(one.row, 4);
  const auto ray = read("x,y,z,dx,dy,dz,transmittance,sigma,time\n1,2,3,0,0,-2,0.5,0.05,0.25\n");
  ASSERT_TRUE(ray) << ray.error().message;
  const LineMeasurement& other = ray->frames[0].lines.at(0);
  EXPECT_TRUE(std::isinf(other.line.end));
  EXPECT_NEAR(other.value, std::log(2), 1e-12);
  EXPECT_NEAR(other.sigma, 0.1, 1e-12);
  EXPECT_EQ(ray->frames[0].time, 0.25);
}

TEST_F(LineFileTest, NoLightIsABoundWhereSigmaSaysWhatCanBeTold) {
  const auto dark = read(
      "x,y,z,dx,dy,dz,transmittance,sigma\n1,2,3,0,0,-2,0.5,0.01\n"
      "1,2,3,0,1,-2,0,0.01\n1,2,3,1,1,-2,-0.02,0.01\n");
  ASSERT_TRUE(dark) << dark.error().message;
  const auto& lines = dark->frames[0].lines;
  EXPECT_FALSE(lines.at(0).atLeast);
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_TRUE(lines.at(i).atLeast);
    EXPECT_NEAR(lines[i].value, -std::log(0.01), 1e-12);
  }
  EXPECT_THAT(dark->remarks, testing::Contains(HasSubstr("2 of 3 lines let no light through")));
  EXPECT_THAT(refusal("x,y,z,dx,dy,dz,transmittance,sigma\n0,0,0,1,0,0,-0.5,0.01\n"),
              HasSubstr("transmittance is -0.5"));
}

TEST_F(LineFileTest, RefusesWrongColumnsAndValues) {
  const std::string head = "x0,y0,z0,x1,y1,z1,value\n";
  EXPECT_THAT(refusal("x0,y0,z0,x1,y1,value\n0,0,0,1,1,1\n"),
              HasSubstr("expected columns with the ends of lines, x0, y0, z0"));
  EXPECT_THAT(refusal("x0,y0,z0,x1,y1,z1\n"), HasSubstr("expected one column of optical_depth"));
  EXPECT_THAT(refusal("x0,y0,z0,x1,y1,z1,value,value\n"),
              HasSubstr("two columns are called 'value'"));
  EXPECT_THAT(refusal("x0,y0,z0,x1,y1,z1,value,frame,time\n"), HasSubstr("both frame and time"));
  EXPECT_THAT(refusal(head), HasSubstr("no line"));
  EXPECT_THAT(refusal(head + "0,0,0,1,1,1\n"), HasSubstr("line 2: 6 columns; expected 7"));
  EXPECT_THAT(refusal(head + "0,0,0,1,1,one,2\n"),
              HasSubstr("line 2: z1 is 'one'; expected a number"));
  EXPECT_THAT(refusal(head + "0,0,0,1,1,inf,2\n"), HasSubstr("z1 is 'inf'"));
  EXPECT_THAT(refusal(head + "1,1,1,1,1,1,2\n"), HasSubstr("both ends are the same point"));
  EXPECT_THAT(refusal("x,y,z,dx,dy,dz,transmittance\n0,0,0,1,0,0,0\n"),
              HasSubstr("transmittance is 0, which lets no depth be told"));
  EXPECT_THAT(refusal("x0,y0,z0,x1,y1,z1,value,sigma\n0,0,0,1,0,0,1,0\n"),
              HasSubstr("sigma is 0; expected more than 0"));
  EXPECT_THAT(refusal("x0,y0,z0,x1,y1,z1,value,frame\n0,0,0,1,0,0,1,1.5\n"),
              HasSubstr("frame is '1.5'; expected a whole number"));
}

TEST_F(LineFileTest, ReadsUnitsAndRefusesWhatMeansSomethingElse) {
  const auto lines = read(
      "x [cm],y [cm],z [cm],dx,dy,dz,transmittance [%],sigma,time "
      "[ms]\n100,200,0,0,0,1,50,5,250\n");
  ASSERT_TRUE(lines) << lines.error().message;
  const LineMeasurement& one = lines->frames[0].lines.at(0);
  EXPECT_TRUE(one.line.origin.isApprox(Vec3(1, 2, 0)));
  EXPECT_NEAR(one.value, std::log(2), 1e-12);
  EXPECT_NEAR(one.sigma, 0.1, 1e-12);
  EXPECT_EQ(lines->frames[0].time, 0.25);
  EXPECT_THAT(lines->remarks, ::testing::IsEmpty());
  const std::string head = "x0,y0,z0,x1,y1,z1,";
  for (const char* name : {"optical_density", "Absorbance"}) {
    const auto tens = read(head + name + ",sigma\n0,0,0,1,1,1,2,0.1\n");
    ASSERT_TRUE(tens) << tens.error().message;
    EXPECT_TRUE(tens->opticalDepths);
    EXPECT_NEAR(tens->frames[0].lines.at(0).value, std::log(100), 1e-12);
    EXPECT_NEAR(tens->frames[0].lines.at(0).sigma, 0.1 * std::log(10), 1e-12);
  }
  EXPECT_THAT(refusal(head + "optical_density [1/m]\n0,0,0,1,1,1,2\n"), HasSubstr("1/m"));
  const auto fractions = read(head + "transmittance [%]\n0,0,0,1,1,1,0.8\n0,0,0,1,1,2,0.9\n");
  ASSERT_TRUE(fractions);
  EXPECT_THAT(fractions->remarks, Contains(HasSubstr("at most 1.2 percent: are they fractions?")));
  EXPECT_THAT(refusal(head + "transmittance\n0,0,0,1,1,1,66.11\n"),
              HasSubstr("transmittance is 66.11; expected 0 to 1"));
  EXPECT_THAT(refusal(head + "optical_depth,times\n0,0,0,1,1,1,1,0\n"),
              HasSubstr("unknown column 'times': did you mean 'time'?"));
  EXPECT_THAT(refusal(head + "optical_depth\n0,0,0,1,1,1,-0.4\n0,0,0,1,1,2,-0.1\n"),
              HasSubstr("2 of 2 optical depths are negative"));
  const auto noisy = read(head + "optical_depth\n0,0,0,1,1,1,0.4\n0,0,0,1,1,2,-0.1\n");
  ASSERT_TRUE(noisy);
  EXPECT_THAT(noisy->remarks, Contains(HasSubstr("1 of 2 optical depths are negative")));
}

TEST_F(LineFileTest, FramesBecomeVolumes) {
  std::string text = "x0,y0,z0,x1,y1,z1,optical_depth,frame\n";
  for (const int frame : {3, 4, 6}) {
    for (const LineMeasurement& one : measured(60, 0)) {
      const Vec3 a = one.line.origin, b = one.line.at(one.line.end);
      text += fmt::format("{},{},{},{},{},{},{},{}\n", a.x(), a.y(), a.z(), b.x(), b.y(), b.z(),
                          one.value, frame);
    }
  }
  text += "9,9,9,9,9,8,1,4\n";
  std::ofstream(file_) << text;
  Progress quiet;
  RemarkLog remarkLog(quiet);
  const std::string file = file_.string();
  CaptureOptions where;
  where.resolution = {8, 0, 0};
  where.frames = {4, std::nullopt, 1};
  const auto all = reconstructLineFile(file, where, {}, false, remarkLog);
  ASSERT_TRUE(all) << all.error().message;
  const VolumeInfo& info = all->volumes.info;
  EXPECT_EQ(info.name, "extinction");
  EXPECT_EQ(info.unit, "1/m");
  EXPECT_THAT(info.frameNumbers, ::testing::ElementsAre(4, 6));
  EXPECT_EQ(info.bounds.max, Vec3(9, 9, 9));
  EXPECT_EQ(all->volumes.values.size(), info.values());
  EXPECT_EQ(all->records.size(), 2U);
  EXPECT_EQ(all->records[0]["lines"], 61);
  EXPECT_TRUE(all->records[0]["spread"].is_null());
  EXPECT_GT(all->mean("residual"), 0);
  EXPECT_THAT(remarkLog.sentences(), Contains(HasSubstr("box around the lines' ends")));

  where.bounds = kGeometry.bounds;
  const auto refused = reconstructLineFile(file, where, {}, false, remarkLog);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("frame 4: row"));
  const auto rest = reconstructLineFile(file, where, {}, true, remarkLog);
  ASSERT_TRUE(rest) << rest.error().message;
  EXPECT_EQ(rest->records[0]["lines"], 60);
  EXPECT_THAT(remarkLog.sentences(),
              Contains(HasSubstr("1 of 61 lines of frame 4 miss the volume")));
  EXPECT_EQ(rest->volumes.info.x, 8);
  EXPECT_EQ(rest->volumes.info.y, 6);

  where.frames = {7, 9, 1};
  EXPECT_EQ(reconstructLineFile(file, where, {}, true, remarkLog).error().code,
            ErrorCode::kInvalidArgument);
  where.frames = {};
  where.maxMemory = 1 << 12;
  EXPECT_EQ(reconstructLineFile(file, where, {}, true, remarkLog).error().code,
            ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace volute
