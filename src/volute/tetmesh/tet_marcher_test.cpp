// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_marcher.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "volute/base/parallel.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/segment_weights.hpp"
#include "volute/tetmesh/tet_march.hpp"
#include "volute/tetmesh/tet_splat.hpp"

namespace volute {
namespace {

constexpr int kWidth = 76, kHeight = 51;

struct Hall {
  std::shared_ptr<const TetMesh> mesh = hallMesh(0.7, 3);
  std::shared_ptr<const TetLocator> locator = std::make_shared<TetLocator>(mesh);
  std::vector<float> extinction = plume(*mesh, 0, 1);
  std::vector<float> source;

  Hall() {
    for (float& k : extinction) k *= 0.3F;
    for (std::size_t i = 0; i < 3 * extinction.size(); ++i)
      source.push_back(static_cast<float>(0.1 + i * 7 % 11 / 11.0));
  }

  TetMedium medium() const { return {locator, extinction, source}; }
};

const Hall& hall() {
  static const Hall hall;
  return hall;
}

Camera cameraAt(const Vec3& eye, const Vec3& target, double fov = 60) {
  return Camera::pinhole({eye, target, Vec3::UnitZ()}, fov, kWidth, kHeight);
}

/// From outside, inside, and the eye on a vertex, an edge and a face of the mesh.
std::vector<std::pair<const char*, Camera>> cameras() {
  const TetMesh& mesh = *hall().mesh;
  const TetFace& face = mesh.faces()[mesh.faces().size() / 2];
  const auto vertex = [&](int i) { return mesh.vertices()[face.vertices[i]]; };
  const Vec3 target(14, 6, 3);
  const View3 view{Vec3(-9, -14, 14), target, Vec3::UnitZ()};
  return {
      {"outside", cameraAt(Vec3(-9, -14, 14), target, 36)},
      {"inside", cameraAt(Vec3(2.3, 6.8, 1.7), Vec3(24, 6, 2.4))},
      {"inside, backwards", cameraAt(Vec3(24, 6, 1.7), Vec3(20, 6, 2))},
      {"on a vertex", cameraAt(vertex(0), target)},
      {"on an edge", cameraAt(0.5 * (vertex(0) + vertex(1)), target)},
      {"on a face", cameraAt((vertex(0) + vertex(1) + vertex(2)) / 3, target)},
      {"on the floor", cameraAt(Vec3(14, 5.3, 0), Vec3(24, 6, 3))},
      {"straight along x", cameraAt(Vec3(-4, 6, 3), Vec3(24, 6, 3))},
      {"orthographic", Camera::orthographic(view, 20, kWidth, kHeight)},
      {"orthographic along x",
       Camera::orthographic({Vec3(14, 6, 3), Vec3(24, 6, 3), Vec3::UnitZ()}, 8, kWidth, kHeight)}};
}

std::vector<float> opaqueDepths() {
  std::vector<float> opaque(kWidth * kHeight);
  for (std::size_t i = 0; i < opaque.size(); ++i)
    opaque[i] = i % 5 == 0 ? std::numeric_limits<float>::infinity()
                           : 0.5F + 0.02F * static_cast<float>(i * 37 % 1009);
  return opaque;
}

double largestDifference(const std::vector<float>& depth, const std::vector<double>& expected) {
  double worst = 0;
  for (std::size_t i = 0; i < depth.size(); ++i)
    worst = std::max(worst, std::abs(std::exp(-depth[i]) - std::exp(-expected[i])));
  return worst;
}

/// Holds the fast paths against the reference.
void expectExact(const Camera& camera, OpaqueDepth opaque, const char* name) {
  TetMarcher marcher(hall().locator);
  marcher.setExtinction(hall().extinction);
  std::vector<float> depth(kWidth * kHeight);
  std::vector<double> expected(depth.size());
  referenceDepth(hall().medium(), camera, opaque, expected);
  marcher.opticalDepth(camera, opaque, depth);
  EXPECT_LE(largestDifference(depth, expected), 1e-5) << name;
  EXPECT_LT(marcher.counts().doubtful, depth.size() / 50);
  TetSplat tets(hall().locator);
  tets.setExtinction(hall().extinction);
  tets.opticalDepth(camera, opaque, depth);
  EXPECT_LE(largestDifference(depth, expected), 1e-5) << name << ", tet splat";
}

TEST(TetPictures, SeeWhatTheReferenceSees) {
  for (const auto& [name, camera] : cameras()) expectExact(camera, {}, name);
}

TEST(TetPictures, StopAtOpaqueSurfaces) {
  const auto opaque = opaqueDepths();
  for (const auto& [name, camera] : cameras()) {
    if (!camera.isOrthographic())
      expectExact(camera, opaque, name);
  }
}

TEST(TetMarcher, LightsSmoke) {
  TetMarcher marcher(hall().locator);
  marcher.setExtinction(hall().extinction);
  marcher.setSource(hall().source);
  const auto opaque = opaqueDepths();
  for (const auto& [name, camera] : cameras()) {
    std::vector<float> light(4 * kWidth * kHeight);
    std::vector<double> expected(light.size());
    const OpaqueDepth until = camera.isOrthographic() ? OpaqueDepth{} : OpaqueDepth{opaque};
    marcher.litColor(camera, until, light);
    referenceColor(hall().medium(), camera, until, expected);
    double worst = 0;
    for (std::size_t i = 0; i < light.size(); ++i)
      worst = std::max(worst, std::abs(light[i] - expected[i]));
    EXPECT_LE(worst, 1e-5) << name;
  }
}

TEST(TetMarcher, DependsOnNoThreads) {
  TetMarcher marcher(hall().locator);
  marcher.setExtinction(hall().extinction);
  const Camera camera = cameraAt(Vec3(2.3, 6.8, 1.7), Vec3(24, 6, 2.4));
  std::vector<float> many(kWidth * kHeight), one(many.size());
  marcher.opticalDepth(camera, {}, many);
  const ThreadLimit limit(1);
  marcher.opticalDepth(camera, {}, one);
  EXPECT_EQ(many, one);
}

TEST(TetSplat, DependsOnNoThreads) {
  TetSplat splat(hall().locator);
  splat.setExtinction(hall().extinction);
  const Camera camera = cameraAt(Vec3(2.3, 6.8, 1.7), Vec3(24, 6, 2.4));
  std::vector<float> many(kWidth * kHeight), one(many.size());
  splat.opticalDepth(camera, {}, many);
  const ThreadLimit limit(1);
  splat.opticalDepth(camera, {}, one);
  EXPECT_EQ(many, one);
}

TEST(TetSplat, TakesNewSmoke) {
  TetSplat splat(hall().locator);
  const Camera camera = cameraAt(Vec3(2.3, 6.8, 1.7), Vec3(24, 6, 2.4));
  std::vector<float> depth(kWidth * kHeight), fresh(depth.size());
  splat.opticalDepth(camera, {}, depth);
  EXPECT_THAT(depth, ::testing::Each(0));  // none yet
  splat.setExtinction(std::vector<float>(hall().extinction.size(), 0.1F));
  splat.opticalDepth(camera, {}, depth);
  splat.setExtinction(hall().extinction);
  splat.opticalDepth(camera, {}, depth);
  TetSplat other(hall().locator);
  other.setExtinction(hall().extinction);
  other.opticalDepth(camera, {}, fresh);
  EXPECT_EQ(depth, fresh);
}

TEST(TetSplat, SeesUniformSmokeAsItsLength) {
  // Rays along faces, edges and vertices of a regular mesh: nothing is counted twice or lost.
  const auto mesh = boxMesh({Vec3::Zero(), Vec3(8, 8, 8)}, {8, 8, 8}, 0, 1);
  TetSplat splat(std::make_shared<TetLocator>(mesh));
  splat.setExtinction(std::vector<float>(mesh->vertices().size(), 0.25F));
  std::vector<float> depth(81);
  splat.opticalDepth(Camera::orthographic({Vec3(4, -1, 4), Vec3(4, 4, 4)}, 7, 9, 9), {}, depth);
  for (const float d : depth) EXPECT_NEAR(d, 2, 1e-5);
  // From a vertex inside along the axis: the middle pixel's ray runs along edges.
  splat.opticalDepth(Camera::pinhole({Vec3(4, 4, 4), Vec3(8, 4, 4), Vec3::UnitZ()}, 60, 9, 9), {},
                     depth);
  EXPECT_NEAR(depth[40], 1, 1e-5);
}

TEST(TetMarcher, PassesThroughVertices) {
  // Pixel centres on the vertices of a regular mesh, and rays in its faces.
  const auto mesh = boxMesh({Vec3::Zero(), Vec3(8, 8, 8)}, {8, 8, 8}, 0, 1);
  const auto locator = std::make_shared<TetLocator>(mesh);
  std::vector<float> extinction;
  for (const Vec3& v : mesh->vertices())
    extinction.push_back(static_cast<float>(0.01 * (v.x() + v.y() * v.z())));
  const Camera camera = Camera::orthographic({Vec3(4, -1, 4), Vec3(4, 4, 4)}, 9, 9, 9);
  TetMarcher marcher(locator);
  marcher.setExtinction(extinction);
  std::vector<float> depth(81);
  std::vector<double> expected(81);
  marcher.opticalDepth(camera, {}, depth);
  referenceDepth({locator, extinction}, camera, {}, expected);
  for (int i = 0; i < 81; ++i) {
    const bool onBorder = i / 9 == 0 || i / 9 == 8 || i % 9 == 0 || i % 9 == 8;
    if (!onBorder) {
      EXPECT_NEAR(depth[i], expected[i], 1e-6) << i;
    }
  }
}

TEST(MarchWeights, AreTheSegmentWeights) {
  std::vector<float> d0, d1;
  const float depths[] = {0,    1e-9F, 1e-5F, 1e-3F, 0.02F, 0.2F, 0.5F,
                          0.9F, 2,     5,     11,    40,    1e3F, 1e6F};
  for (const float a : depths) {
    for (const float b : depths) d0.push_back(a), d1.push_back(b);
  }
  std::vector<float> w0(d0.size()), w1(d0.size());
  // Alone, and beside others that call for finer rules.
  for (std::size_t i = 0; i < d0.size(); ++i)
    marchWeights({&d0[i], 1}, {&d1[i], 1}, {&w0[i], 1}, {&w1[i], 1});
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t i = 0; i < d0.size(); ++i) {
      const SegmentWeights exact = segmentWeights(d0[i], d1[i]);
      EXPECT_NEAR(w0[i], exact.w0, 1e-6) << d0[i] << " " << d1[i];
      EXPECT_NEAR(w1[i], exact.w1, 1e-6) << d0[i] << " " << d1[i];
    }
    marchWeights(d0, d1, w0, w1);
  }
}

}  // namespace
}  // namespace volute
