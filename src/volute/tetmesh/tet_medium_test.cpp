// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_medium.hpp"

#include <gtest/gtest.h>

#include "volute/medium/conformance.hpp"
#include "volute/tetmesh/made_meshes.hpp"

namespace volute {
namespace {

const Box3 kMediumBox{Vec3(-1, 0.5, 2), Vec3(1, 2, 3)};

std::shared_ptr<const TetMesh> mesh() {
  return boxMesh(kMediumBox, {4, 3, 2}, 0.2, 1);
}

TetMedium medium(bool lit) {
  const auto cells = mesh();
  std::vector<float> extinction, source;
  for (std::size_t i = 0; i < cells->vertices().size(); ++i) {
    extinction.push_back(i % 5 == 0 ? 0 : 0.1F * static_cast<float>(i * 7 % 11));
    for (std::size_t c = 0; c < 3; ++c)
      source.push_back(lit ? 0.2F * static_cast<float>((i + c) * 5 % 7) : 0);
  }
  return {std::make_shared<TetLocator>(cells), std::move(extinction), std::move(source)};
}

conformance::Traits traits() {
  conformance::Traits traits;
  const auto cells = mesh();
  for (std::size_t i = 0; i < cells->vertices().size(); i += 4)
    traits.vertices.push_back(cells->vertices()[i]);
  return traits;
}

VOLUTE_CONFORMANCE(LitTets, conformance::underTest(medium(true), traits()));
VOLUTE_CONFORMANCE(BlackTets, conformance::underTest(medium(false), traits()));

/// Of the middles of a box's tets: all that lie in a second box of the same size too.
TEST(TetLocator, FindsTetsThatLieInOthers) {
  EXPECT_EQ(TetLocator(mesh()).overlap().share, 0);
  EXPECT_EQ(TetLocator(hallMesh(1, 3)).overlap().share, 0);
  const auto single = boxMesh(kMediumBox, {8, 6, 4}, 0, 1);
  const double width = kMediumBox.size().x();
  for (const double share : {0.5, 0.25}) {
    std::vector<Vec3> points(single->vertices().begin(), single->vertices().end());
    std::vector<Tet> tets(single->tets().begin(), single->tets().end());
    const auto count = static_cast<std::int32_t>(points.size());
    for (const Vec3& point : single->vertices())
      points.push_back(point + Vec3((1 - share) * width, 0, 0));
    for (Tet tet : single->tets()) {
      for (std::int32_t& v : tet) v += count;
      tets.push_back(tet);
    }
    const auto both = TetMesh::build(std::move(points), std::move(tets), "two boxes").value();
    const TetOverlap overlap = TetLocator(both).overlap();
    EXPECT_NEAR(overlap.share, share, 0.02);
    EXPECT_GT(overlap.first.x(), kMediumBox.min.x() + (1 - share) * width);
    EXPECT_LT(overlap.first.x(), kMediumBox.max.x());
  }
}

/// Grey behind uniform smoke: within half a level of 255 e^(-K L) at every distance, direction and
/// size of cells (optics of the FDS beam detector; oblique views of a unit cube of grey 100: 68
/// over sqrt 2 m, 50 over sqrt 3 m).
TEST(TetMedium, DimsAsUniformSmokeDoes) {
  const Box3 unit{Vec3::Zero(), Vec3::Ones()};
  const double k = std::log(255.0 / 100);
  for (const int cells : {1, 3, 8}) {
    const auto cube = boxMesh(unit, {cells, cells, cells}, 0.25, 2);
    const TetMedium smoke(std::make_shared<TetLocator>(cube),
                          std::vector<float>(cube->vertices().size(), static_cast<float>(k)));
    const Segment segments[] = {{Vec3(-1, 0.5, 0.5), Vec3::UnitX(), 0, 9},
                                {Vec3(-1, -1, 0.5), Vec3(1, 1, 0).normalized(), 0, 9},
                                {Vec3(-1, -1, -1), Vec3(1, 1, 1).normalized(), 0, 9}};
    double depths[3];
    smoke.opticalDepth(segments, depths);
    const double expected[] = {100, 68, 50};
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(255 * std::exp(-depths[i]), 255 * std::exp(-k * std::sqrt(i + 1.0)), 1e-4);
      EXPECT_NEAR(255 * std::exp(-depths[i]), expected[i], 0.5);
    }
  }
}

}  // namespace
}  // namespace volute
