// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_fds.hpp"

#include "volute/fds/fds_flame.hpp"
#include "volute/gl/gl_testing.hpp"
#include "volute/media/fds/lit_fds.hpp"
#include "volute/render/scaled_medium.hpp"

// The smoke and the fire of FDS cases, whose lattices need be neither even nor joined.

namespace volute {

using namespace gltest;

namespace {

/// A stretched mesh, a finer one at its end on x, and a third beyond a gap.
std::vector<FdsLattice> lattices(bool nodal) {
  return {{0, {{{0, 0.5, 1.0, 2.0}, {0, 1, 1.5, 2}, {-1, 0, 1}}}, nodal},
          {1, {{{2, 2.25, 2.5, 2.75, 3.0}, {0, 0.5, 1, 1.5, 2}, {-1, -0.5, 0, 0.5, 1}}}, nodal},
          {2, {{{3.25, 4}, {0.5, 2}, {-1, 1}}}, nodal}};
}

/// Values from 0 to `most`, an obstruction in every fifth cell. NaN where no cell of gas looks.
FdsField fieldOf(bool nodal, double most, std::uint32_t seed = 3) {
  const auto grid = FdsGrid::create(lattices(nodal)).value();
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, static_cast<float>(most));
  std::vector<std::shared_ptr<const FdsValues>> values;
  std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells;
  for (const FdsLattice& lattice : grid->lattices()) {
    auto states = std::make_shared<std::vector<FdsCell>>(lattice.cellCount(), FdsCell::kGas);
    for (FdsCell& state : *states) state = random() % 5 == 0 ? FdsCell::kSolid : FdsCell::kGas;
    auto made = std::make_shared<FdsValues>();
    for (std::size_t i = 0; i < lattice.valueCount(); ++i) made->value.push_back(uniform(random));
    for (std::size_t i = 0; !nodal && i < states->size(); ++i) {
      if ((*states)[i] != FdsCell::kGas)
        made->value[i] = std::numeric_limits<float>::quiet_NaN();
    }
    cells.push_back(std::move(states));
    values.push_back(std::move(made));
  }
  return FdsField(grid, std::move(values), std::move(cells)).withSource(Rgb(0.5, 0.7, 0.9));
}

TEST_F(GlRendererTest, SmokeOfFdsCasesIsThatOfTheReference) {
  for (const bool nodal : {false, true}) {
    const FdsField field = fieldOf(nodal, 2);
    const AnyMedium scaled(ScaledMedium(AnyMedium(field), 0.7));
    const GlScene scene{{glPart(GlFds{field, 0.7})}};
    const auto views = cameras(field.bounds());
    for (const Camera& camera : views) {
      EXPECT_LE(errorOf(camera, scene, {&scaled, 1}, {.background = Rgb(0.3, 0.2, 0.1)}), kBar)
          << "nodal " << nodal << ", view " << &camera - &views[0];
    }
    const AnyMedium medium(field);
    EXPECT_LE(errorOf(Camera::framing(field.bounds(), kWidth, kHeight), {{glPart(GlFds{field})}},
                      {&medium, 1}, {.aov = Aov::kOpticalDepth}),
              1e-4);
  }
}

/// A wall across, lamps at both sides of it, a sun and light that was scattered before.
TEST_F(GlRendererTest, LampsLightSmokeOfFdsCasesAsOnTheCpu) {
  const Vec3 a(1.8, 0.2, -0.8), b(1.8, 1.4, -0.8), c(1.8, 1.4, 0.6);
  FdsLamps lamps{.surfaces = TriangleScene::build({{{a, b, c}}}).value(),
                 .albedo = Rgb(0.5, 0.7, 0.9)};
  Lamp narrow, wide, sun;
  narrow.position = Vec3(0.4, 0.9, 0.9), narrow.direction = Vec3(1, 0, -0.7).normalized();
  narrow.coneCosine = 0.8, narrow.edge = 0.2, narrow.intensity = Rgb::Constant(8);
  wide.position = Vec3(2.6, 0.7, 0.3);
  sun.kind = Lamp::Kind::kSun, sun.direction = Vec3(0.5, 0.2, -1).normalized();
  lamps.light = {.lamps = {narrow, wide, sun}, .ambient = Rgb::Constant(0.1)};
  for (const bool again : {false, true}) {
    const FdsField field = fieldOf(again, 1);
    lamps.light.multiple = again;
    const auto lit = std::make_shared<const LitMedium>(litFds(field, lamps));
    const FdsField even = field.withSource(lamps.albedo * lamps.light.ambient);
    const GlScene scene{{glPart(GlFds{even, 0.7, {}, lit, lamps.surfaces})}};
    const AnyMedium medium(ScaledMedium(AnyMedium(*lit), 0.7));
    const Camera camera = cameras(field.bounds())[0];
    EXPECT_LE(errorOf(camera, scene, {&medium, 1}, {.background = Rgb(0.3, 0.2, 0.1)}), 5e-3)
        << again;
  }
}

TEST_F(GlRendererTest, FireOfFdsCasesShinesThroughItsSmokeAndFog) {
  for (const bool nodal : {false, true}) {
    const FdsField smoke = fieldOf(nodal, 1);
    const FdsFlame flame(fieldOf(nodal, 700, 8), {});
    const FogMedium fog =
        fogtest::fog(fogtest::map(9, 9), fogtest::profiles()[1].profile, {.degree = 1}, 0.5, 0.6);
    const auto burning = glPart(GlFds{flame.lights()[0].field, 1, flame.lights()[0].colour});
    const GlScene fire{{burning}};
    const GlScene all{{glPart(GlFog{fog}), glPart(GlFds{smoke}), burning}};
    const std::vector<AnyMedium> media{AnyMedium(fog), AnyMedium(smoke), AnyMedium(flame)};
    const Camera camera = cameras(smoke.bounds())[nodal ? 0 : 1];
    std::vector<float> wall(kWidth * kHeight, INFINITY);
    for (std::size_t i = 0; i < wall.size(); i += 3) wall[i] = 1.7F;
    EXPECT_LE(errorOf(camera, fire, std::span(media).last(1), {}, wall), kBar) << nodal;
    EXPECT_LE(errorOf(camera, all, media, {.background = Rgb(0.3, 0.2, 0.1)}, wall), kBar) << nodal;
  }
}

}  // namespace
}  // namespace volute
