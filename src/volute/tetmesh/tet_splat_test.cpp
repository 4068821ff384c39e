// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_splat.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "volute/base/parallel.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/segment_weights.hpp"
#include "volute/tetmesh/tet_lit_raster.hpp"
#include "volute/tetmesh/tet_reference.hpp"
#include "volute/tetmesh/visibility_order.hpp"

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

/// Holds the fast path against the reference.
void expectExact(const Camera& camera, OpaqueDepth opaque, const char* name) {
  std::vector<float> depth(kWidth * kHeight);
  std::vector<double> expected(depth.size());
  referenceDepth(hall().medium(), camera, opaque, expected);
  TetSplat tets(hall().locator);
  tets.setExtinction(hall().extinction);
  tets.opticalDepth(camera, opaque, depth);
  EXPECT_LE(largestDifference(depth, expected), 1e-5) << name;
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

std::vector<double> litReference(const Camera& camera, OpaqueDepth until) {
  std::vector<double> expected(4 * kWidth * kHeight);
  referenceColor(hall().medium(), camera, until, expected);
  return expected;
}

/// The largest error of a lit picture.
double litError(const std::vector<float>& light, const std::vector<double>& expected) {
  double worst = 0;
  for (std::size_t i = 0; i < light.size(); ++i)
    worst = std::max(worst, std::abs(light[i] - expected[i]));
  return worst;
}

/// What is in the eye is left out, and the rest is as in the whole picture, bit by bit but for lit
/// pixels that are left to TetMedium.
TEST(TetPictures, LeaveOutWhatIsInTheEye) {
  TetSplat splat(hall().locator);
  splat.setExtinction(hall().extinction), splat.setSource(hall().source);
  for (const auto& [name, camera] : cameras()) {
    if (camera.isOrthographic())
      continue;
    std::vector<float> all(kWidth * kHeight, 1e9F), some = all;
    for (std::size_t i = 0; i < some.size(); ++i)
      some[i] = i % kWidth / 7 == 3 && i / kWidth > 20 && i / kWidth < 24 ? 1e9F : 0;
    std::vector<float> whole(all.size()), part(all.size(), 7);
    std::vector<float> wholeLight(4 * all.size()), partLight(4 * all.size(), 7);
    splat.opticalDepth(camera, all, whole), splat.opticalDepth(camera, some, part);
    splat.litColor(camera, all, wholeLight), splat.litColor(camera, some, partLight);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const bool kept = some[i] == 0 && part[i] == 7,
                 keptLight = some[i] == 0 && partLight[4 * i] == 7;
      ASSERT_EQ(part[i], kept ? 7 : some[i] > 0 ? whole[i] : 0) << name << " " << i;
      for (std::size_t c = 0; c < 4; ++c) {
        const float none = c == 3 ? 1 : 0;
        const float expected = keptLight ? 7 : some[i] > 0 ? wholeLight[4 * i + c] : none;
        ASSERT_NEAR(partLight[4 * i + c], expected, 1e-5) << name << " " << i;
      }
    }
  }
}

TEST(TetPictures, LightSmoke) {
  TetSplat splat(hall().locator);
  splat.setExtinction(hall().extinction);
  splat.setSource(hall().source);
  const auto opaque = opaqueDepths();
  for (const auto& [name, camera] : cameras()) {
    std::vector<float> light(4 * kWidth * kHeight);
    const OpaqueDepth until = camera.isOrthographic() ? OpaqueDepth{} : OpaqueDepth{opaque};
    const std::vector<double> expected = litReference(camera, until);
    splat.litColor(camera, until, light);
    EXPECT_LE(litError(light, expected), 1e-5) << name;
    EXPECT_LT(splat.leftOut(), light.size() / 4 / 20) << name;
  }
}

TEST(TetPictures, AreTheSameOnAllTargets) {
  const Camera camera = cameraAt(Vec3(2.3, 6.8, 1.7), Vec3(24, 6, 2.4));
  std::vector<float> light(4 * kWidth * kHeight), depth(kWidth * kHeight);
  std::vector<double> expected(depth.size());
  referenceDepth(hall().medium(), camera, {}, expected);
  const std::vector<double> lit = litReference(camera, {});
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    TetSplat splat(hall().locator);
    splat.setExtinction(hall().extinction);
    splat.setSource(hall().source);
    splat.opticalDepth(camera, {}, depth);
    EXPECT_LE(largestDifference(depth, expected), 1e-5) << hwy::TargetName(target);
    splat.litColor(camera, {}, light);
    EXPECT_LE(litError(light, lit), 1e-5) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

TEST(TetSplat, LightsFromAnEyeThatTurnsAsFromAnother) {
  TetSplat turning(hall().locator);
  turning.setExtinction(hall().extinction);
  turning.setSource(hall().source);
  std::vector<float> light(4 * kWidth * kHeight), fresh(light.size());
  const Vec3 eyes[] = {{2.3, 6.8, 1.7}, {2.3, 6.8, 1.7}, {20, 5, 2}, {-9, -14, 14}};
  for (std::size_t i = 0; i < 4; ++i) {
    const Camera camera = cameraAt(eyes[i], Vec3(14, 6 + static_cast<double>(i), 2.4));
    turning.litColor(camera, {}, light);
    TetSplat other(hall().locator);
    other.setExtinction(hall().extinction);
    other.setSource(hall().source);
    other.litColor(camera, {}, fresh);
    EXPECT_EQ(light, fresh) << i;
  }
}

TEST(TetSplat, KeepsOfAnEyeWhatChangesNoPicture) {
  const Vec3 eyes[] = {Vec3(2.3, 6.8, 1.7), Vec3(-9, -14, 14)};
  const Vec3 targets[] = {Vec3(24, 6, 2.4), Vec3(20, 9, 2), Vec3(20, 9, 2), Vec3(14, 6, 3)};
  const std::vector<float> thinner = [] {
    std::vector<float> field = hall().extinction;
    for (std::size_t i = 0; i < field.size(); ++i) field[i] = i % 3 ? 0.7F * field[i] : 0;
    return field;
  }();
  std::vector<float> far(static_cast<std::size_t>(kWidth) * kHeight, 9);
  TetSplat kept(hall().locator);
  for (const Vec3& eye : eyes) {
    for (const auto* field : {&hall().extinction, &thinner, &hall().extinction}) {
      kept.setExtinction(*field);
      kept.setSource(hall().source);
      for (const Vec3& target : targets) {
        for (const OpaqueDepth opaque : {OpaqueDepth(), OpaqueDepth(far)}) {
          const Camera camera = cameraAt(eye, target);
          TetSplat fresh(hall().locator);
          fresh.setExtinction(*field);
          fresh.setSource(hall().source);
          std::vector<float> depth(far.size()), expected(far.size());
          kept.opticalDepth(camera, opaque, depth);
          fresh.opticalDepth(camera, opaque, expected);
          EXPECT_EQ(depth, expected);
          std::vector<float> lit(4 * far.size()), litExpected(4 * far.size());
          kept.litColor(camera, opaque, lit);
          fresh.litColor(camera, opaque, litExpected);
          EXPECT_EQ(lit, litExpected);
        }
      }
    }
  }
  // And parallel rays after it, of which nothing is kept.
  const Camera parallel =
      Camera::orthographic({Vec3(-9, -14, 14), Vec3(14, 6, 3), Vec3::UnitZ()}, 20, kWidth, kHeight);
  TetSplat fresh(hall().locator);
  fresh.setExtinction(hall().extinction);
  for (int i = 0; i < 3; ++i) {
    std::vector<float> depth(far.size()), expected(far.size());
    kept.opticalDepth(parallel, {}, depth);
    fresh.opticalDepth(parallel, {}, expected);
    EXPECT_EQ(depth, expected);
  }
}

TEST(TetSplat, LeavesToTheReferenceWhatComesTooLate) {
  // Two thin boxes, one behind the other, and a third that is nearer to the eye by its middle but
  // behind the first: its long tets reach past it.
  const auto mesh = boxMesh({Vec3::Zero(), Vec3(1, 1, 1)}, {1, 1, 1}, 0, 1);
  std::vector<Vec3> vertices;
  std::vector<Tet> tets;
  const auto add = [&](const Vec3& at, const Vec3& size) {
    const auto first = static_cast<std::int32_t>(vertices.size());
    for (const Vec3& v : mesh->vertices()) vertices.emplace_back(at + v.cwiseProduct(size));
    for (Tet tet : mesh->tets()) {
      for (std::int32_t& v : tet) v += first;
      tets.push_back(tet);
    }
  };
  add(Vec3(4, -8, -1), Vec3(0.5, 9, 2));      // far off the axis by its middle, near on it
  add(Vec3(5.5, -0.5, -1), Vec3(0.5, 1, 2));  // behind it on the axis
  const auto both = TetMesh::build(vertices, tets, "boxes");
  ASSERT_TRUE(both);
  const auto locator = std::make_shared<TetLocator>(*both);
  std::vector<float> extinction((*both)->vertices().size(), 0.8F), source;
  for (const Vec3& v : (*both)->vertices()) {
    for (int c = 0; c < 3; ++c) source.push_back(static_cast<float>(v.x() > 5 ? c : 3 - c));
  }
  const Camera camera = Camera::pinhole({Vec3::Zero(), Vec3::UnitX(), Vec3::UnitZ()}, 20, 40, 40);
  TetSplat splat(locator);
  splat.setExtinction(extinction);
  splat.setSource(source);
  std::vector<float> light(4 * 1600);
  std::vector<double> expected(light.size());
  splat.litColor(camera, {}, light);
  referenceColor({locator, extinction, source}, camera, {}, expected);
  for (std::size_t i = 0; i < light.size(); ++i) ASSERT_NEAR(light[i], expected[i], 1e-5) << i;
  EXPECT_GT(splat.leftOut(), 0U);
}

TEST(VisibilityOrder, PutsNeighboursBehindEachOther) {
  const TetMesh& mesh = *hall().mesh;
  const FacePlanes faces(mesh);
  for (const Vec3& eye : {Vec3(-9, -14, 14), Vec3(2.3, 6.8, 1.7)}) {
    const auto order = visibilityOrder(mesh, faces, {eye, Vec3::UnitX(), false});
    std::vector<std::int32_t> place(mesh.tets().size(), -1);
    for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<std::int32_t>(i);
    EXPECT_THAT(place, ::testing::Each(::testing::Ge(0)));
    int wrong = 0;
    for (const TetFace& face : mesh.faces()) {
      if (face.second == TetMesh::kBoundary)
        continue;
      const FacePlane& plane = faces.planes[&face - mesh.faces().data()];
      const bool firstInFront = plane.normal.dot(eye) < plane.offset;
      wrong += (place[face.first / 4] < place[face.second / 4]) != firstInFront;
    }
    EXPECT_EQ(wrong, 0);
  }
}

/// A ring of prisms whose common sides all lean the same way, each cut in six around a diagonal:
/// seen along its axis, each prism hides the next.
std::shared_ptr<const TetMesh> leaningRing(int sides) {
  std::vector<Vec3> vertices;
  for (const int level : {0, 1}) {
    for (int side = 0; side < sides; ++side) {
      const double turn = 2 * std::numbers::pi * (side + 0.4 * level) / sides;
      for (const double radius : {1.0, 0.5})
        vertices.push_back({radius * std::cos(turn), radius * std::sin(turn), 1.0 * level});
    }
  }
  std::vector<Tet> tets;
  for (int side = 0; side < sides; ++side) {
    int axes[] = {0, 1, 2};
    do {
      int at[3] = {0, 0, 0};
      const auto vertex = [&] { return 2 * (at[2] * sides + (side + at[0]) % sides) + at[1]; };
      Tet tet{vertex()};
      for (int i = 0; i < 3; ++i) {
        at[axes[i]] = 1;
        tet[i + 1] = vertex();
      }
      tets.push_back(tet);
    } while (std::next_permutation(axes, axes + 3));
  }
  return TetMesh::build(vertices, tets, "ring").value();
}

TEST(VisibilityOrder, HasEachTetOfACycleOnce) {
  const auto ring = leaningRing(7);
  auto order = visibilityOrder(*ring, FacePlanes(*ring), {Vec3(0, 0, 40), Vec3(0, 0, -1), true});
  std::ranges::sort(order);
  ASSERT_EQ(order.size(), ring->tets().size());
  for (std::size_t t = 0; t < order.size(); ++t) EXPECT_EQ(order[t], static_cast<std::int32_t>(t));
}

TEST(VisibilityOrder, HasTheNearFirstAndDependsOnNoThreads) {
  const TetMesh& mesh = *hall().mesh;
  const FacePlanes faces(mesh);
  const ViewOrigin views[] = {{Vec3(2.3, 6.8, 1.7), Vec3::UnitX(), false},
                              {Vec3(40, 6, 3), Vec3::UnitX(), false},
                              {Vec3::Zero(), Vec3(1, 0.3, -0.2).normalized(), true}};
  for (const ViewOrigin& view : views) {
    const auto order = visibilityOrder(mesh, faces, view);
    std::vector<char> seen(mesh.tets().size(), 0);
    double near = 0, far = 0;  // mean distances of both halves
    for (std::size_t i = 0; i < order.size(); ++i) {
      seen[order[i]] = 1;
      const Vec3 from = mesh.vertices()[mesh.tets()[order[i]][0]] - view.eye;
      (i < order.size() / 2 ? near : far) +=
          view.orthographic ? from.dot(view.forward) : from.norm();
    }
    EXPECT_EQ(order.size(), mesh.tets().size());
    EXPECT_THAT(seen, ::testing::Each(1));
    EXPECT_LT(1.3 * near, far);
    const ThreadLimit limit(1);
    EXPECT_EQ(visibilityOrder(mesh, faces, view), order);
  }
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

TEST(PieceLosses, AreTheSegmentWeights) {
  std::vector<float> d, c;
  for (const float mean :
       {0.0F, 1e-9F, 1e-4F, 0.01F, 0.03F, 0.0499F, 0.051F, 0.3F, 2.0F, 5.0F, 30.0F, 1e3F}) {
    for (int i = -8; i <= 8; ++i) d.push_back(mean), c.push_back(mean * static_cast<float>(i) / 8);
  }
  std::vector<float> lost(d.size()), lean(d.size());
  // Alone, and beside others that call for finer rules.
  for (std::size_t i = 0; i < d.size(); ++i)
    pieceLosses({&d[i], 1}, {&c[i], 1}, {&lost[i], 1}, {&lean[i], 1});
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t i = 0; i < d.size(); ++i) {
      const double mean = d[i], rise = c[i];
      const SegmentWeights exact = segmentWeights(mean - rise, mean + rise);
      EXPECT_NEAR(lost[i], exact.w0 + exact.w1, 5e-7) << mean << " " << rise;
      EXPECT_NEAR(lean[i], 0.5 * (exact.w1 - exact.w0), 1e-6) << mean << " " << rise;
    }
    pieceLosses(d, c, lost, lean);
  }
}

}  // namespace
}  // namespace volute
