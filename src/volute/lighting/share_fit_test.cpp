// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/share_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "volute/lighting/vertex_light.hpp"
#include "volute/tetmesh/made_meshes.hpp"

namespace volute {
namespace {

/// A ball of smoke in a box of tets, and the sun on it.
struct Ball {
  std::shared_ptr<const TetMesh> mesh =
      boxMesh({Vec3(-1, -1, -1), Vec3(1, 1, 1)}, {16, 16, 16}, 0.2, 1);
  std::shared_ptr<const TetLocator> locator = std::make_shared<const TetLocator>(mesh);
  std::vector<float> extinction;
  Lamp sun{.kind = Lamp::Kind::kSun, .direction = Vec3(0.4, 0.3, -1).normalized()};

  Ball() {
    for (const Vec3& p : mesh->vertices())
      extinction.push_back(
          static_cast<float>(1.3 * std::max(0.0, 1 - std::pow(p.norm() / 0.75, 4))));
  }
};

/// What a ray sees of the smoke that sends a share of light which is linear between vertices, or
/// exact where there are none.
double seen(const Ball& ball, const Segment& ray, std::span<const float> shares) {
  std::vector<TetCrossing> crossings;
  ball.locator->crossings(ray, crossings);
  double sum = 0, passed = 1;
  constexpr int kSteps = 8;
  for (const TetCrossing& crossing : crossings) {
    const double length = (crossing.end - crossing.begin) / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      const Vec3 point = ray.at(crossing.begin + (i + 0.5) * length);
      const auto of = ball.mesh->shares(crossing.tet, point);
      double extinction = 0, share = 0;
      for (int k = 0; k < 4; ++k) {
        const std::int32_t v = ball.mesh->tets()[crossing.tet][k];
        extinction += of[k] * ball.extinction[v];
        share += shares.empty() ? 0 : of[k] * shares[v];
      }
      if (!(extinction > 0))
        continue;
      if (shares.empty())
        share = lampShareAt(*ball.locator, ball.extinction, ball.sun.towards(point), crossing.tet,
                            false);
      const double lost = -std::expm1(-extinction * length);
      sum += passed * lost * share;
      passed *= 1 - lost;
    }
  }
  return sum;
}

TEST(ShareFit, SmokeThatIsLinearBetweenVerticesIsAsBrightAsItIs) {
  const Ball ball;
  const LampPaths paths(ball.locator);
  const auto shares = paths.shares(ball.extinction, ball.sun);
  const auto means = paths.means(ball.extinction, ball.sun, shares, {});
  double before = 0, after = 0, brightest = 0;
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      const Segment ray{Vec3(-0.7 + 0.2 * i, -2, -0.71 + 0.2 * j), Vec3::UnitY(), 0, 4};
      const double exact = seen(ball, ray, {});
      brightest = std::max(brightest, exact);
      before = std::max(before, std::abs(seen(ball, ray, shares) - exact));
      after = std::max(after, std::abs(seen(ball, ray, means) - exact));
    }
  }
  EXPECT_GT(before, 0.008 * brightest);
  EXPECT_LT(after, 0.006 * brightest);
  EXPECT_LT(after, 0.45 * before);
}

TEST(ShareFit, AsksOnlyWhereThereIsSmokeAndLightChanges) {
  const Ball ball;
  const std::size_t edges = 7 * ball.mesh->vertices().size();
  const auto shares = LampPaths(ball.locator).shares(ball.extinction, ball.sun);
  const ShareFit fit(*ball.mesh, ball.extinction, shares);
  EXPECT_GT(fit.places().size(), 1000);
  EXPECT_LT(fit.places().size(), edges / 2);
  const std::vector<float> even(shares.size(), 0.5F), thin(shares.size(), 0.1F);
  EXPECT_TRUE(ShareFit(*ball.mesh, thin, even).places().empty());
  const std::vector<float> clear(shares.size(), 0);
  EXPECT_TRUE(ShareFit(*ball.mesh, clear, shares).places().empty());
}

TEST(ShareFit, WhatIsLinearStaysAndSoDoesAShadowsEdge) {
  const Ball ball;
  std::vector<float> linear, shadow;
  for (const Vec3& p : ball.mesh->vertices()) {
    linear.push_back(static_cast<float>(0.5 + 0.2 * p.x() - 0.1 * p.z()));
    shadow.push_back(p.x() < 0.03 ? 0.0F : 1.0F);
  }
  const ShareFit straight(*ball.mesh, ball.extinction, linear);
  std::vector<float> at;
  for (const Vec3& p : straight.places())
    at.push_back(static_cast<float>(0.5 + 0.2 * p.x() - 0.1 * p.z()));
  const auto fitted = straight.fitted(at);
  ASSERT_TRUE(fitted);
  for (std::size_t v = 0; v < linear.size(); ++v) EXPECT_NEAR((*fitted)[v], linear[v], 2e-6);
  const ShareFit hard(*ball.mesh, ball.extinction, shadow);
  const std::vector<float> lit(hard.places().size(), 1.0F);
  EXPECT_EQ(*hard.fitted(lit), shadow);
}

/// As a rank has it.
struct Part {
  std::shared_ptr<const TetMesh> mesh;
  std::vector<std::int32_t> vertices;  ///< in the whole
  std::vector<float> extinction, shares;
};

TEST(ShareFit, PiecesOfAMeshGiveWhatTheWholeGives) {
  const Ball ball;
  const auto shares = LampPaths(ball.locator).shares(ball.extinction, ball.sun);
  const auto curved = [](const Vec3& p) {
    return static_cast<float>(0.5 + 0.1 * p.squaredNorm() - 0.2 * p.x() * p.z());
  };
  const auto fitOf = [&](const ShareFit& fit, const ShareFit::AddPieces& add) {
    std::vector<float> at;
    for (const Vec3& p : fit.places()) at.push_back(curved(p));
    return fit.fitted(at, add);
  };
  const auto whole = fitOf(ShareFit(*ball.mesh, ball.extinction, shares), {});
  ASSERT_TRUE(whole);
  std::vector<Part> parts(2);
  for (int side = 0; side < 2; ++side) {
    Part& part = parts[side];
    std::map<std::int32_t, std::int32_t> own;
    std::vector<Tet> tets;
    std::vector<Vec3> points;
    for (const Tet& tet : ball.mesh->tets()) {
      Vec3 sum = Vec3::Zero();
      for (const std::int32_t v : tet) sum += ball.mesh->vertices()[v];
      if ((sum.x() + 0.3 * sum.y() > 0) != (side == 1))
        continue;
      Tet& mine = tets.emplace_back();
      for (int k = 0; k < 4; ++k) {
        const auto [at, added] = own.insert({tet[k], static_cast<std::int32_t>(points.size())});
        if (added) {
          points.push_back(ball.mesh->vertices()[tet[k]]);
          part.vertices.push_back(tet[k]);
          part.extinction.push_back(ball.extinction[tet[k]]);
          part.shares.push_back(shares[tet[k]]);
        }
        mine[k] = at->second;
      }
    }
    part.mesh = *TetMesh::build(points, tets, "part");
  }
  // What the other part has, call by call: each part is asked again with one more call known.
  std::vector<std::vector<double>> sums[2];
  std::vector<float> fitted[2];
  for (int round = 0; round <= 3; ++round) {
    std::vector<std::vector<double>> sent[2];
    for (int side = 0; side < 2; ++side) {
      const Part& part = parts[side];
      std::size_t call = 0;
      const auto add = [&](std::span<double> own) -> Status {
        std::vector<double> all(shares.size(), 0);
        for (std::size_t v = 0; v < own.size(); ++v) all[part.vertices[v]] = own[v];
        sent[side].push_back(all);
        if (call < sums[1 - side].size()) {
          for (std::size_t v = 0; v < own.size(); ++v)
            own[v] += sums[1 - side][call][part.vertices[v]];
        }
        ++call;
        return {};
      };
      fitted[side] = *fitOf(ShareFit(*part.mesh, part.extinction, part.shares), add);
    }
    for (int side = 0; side < 2; ++side) sums[side] = sent[side];
  }
  double moved = 0;
  for (int side = 0; side < 2; ++side) {
    for (std::size_t v = 0; v < fitted[side].size(); ++v) {
      EXPECT_NEAR(fitted[side][v], (*whole)[parts[side].vertices[v]], 1e-6);
      moved = std::max<double>(moved, std::abs(fitted[side][v] - parts[side].shares[v]));
    }
  }
  EXPECT_GT(moved, 0.005);
}

}  // namespace
}  // namespace volute
