// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_fds.hpp"

#include "volute/fds/fds_flame.hpp"
#include "volute/gl/gl_testing.hpp"
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
FdsField fieldOf(bool nodal, double most, bool lit, std::uint32_t seed = 3) {
  const auto grid = FdsGrid::create(lattices(nodal)).value();
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, static_cast<float>(most));
  std::vector<std::shared_ptr<const FdsValues>> values;
  std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells;
  std::vector<std::shared_ptr<const FdsLight>> light;
  for (const FdsLattice& lattice : grid->lattices()) {
    auto states = std::make_shared<std::vector<FdsCell>>(lattice.cellCount(), FdsCell::kGas);
    for (FdsCell& state : *states) state = random() % 5 == 0 ? FdsCell::kSolid : FdsCell::kGas;
    auto made = std::make_shared<FdsValues>();
    for (std::size_t i = 0; i < lattice.valueCount(); ++i) made->value.push_back(uniform(random));
    for (std::size_t i = 0; !nodal && i < states->size(); ++i) {
      if ((*states)[i] != FdsCell::kGas)
        made->value[i] = std::numeric_limits<float>::quiet_NaN();
    }
    auto shone = std::make_shared<FdsLight>();
    for (std::size_t i = 0; i < 3 * lattice.nodeCount(); ++i)
      shone->push_back(0.2F + uniform(random) / static_cast<float>(most));
    cells.push_back(std::move(states));
    values.push_back(std::move(made));
    light.push_back(std::move(shone));
  }
  const FdsField field(grid, std::move(values), std::move(cells));
  return lit ? field.withLight(std::move(light)) : field.withSource(Rgb(0.5, 0.7, 0.9));
}

TEST_F(GlRendererTest, SmokeOfFdsCasesIsThatOfTheReference) {
  for (const bool nodal : {false, true}) {
    for (const bool lit : {false, true}) {
      const FdsField field = fieldOf(nodal, 2, lit);
      const AnyMedium medium(ScaledMedium(AnyMedium(field), 0.7));
      const GlScene scene{{glPart(GlFds{field, 0.7})}};
      const auto views = cameras(field.bounds());
      for (const Camera& camera : views) {
        if (lit && !nodal && &camera != &views[0])
          continue;  // the views are the walk's, which light does not change
        EXPECT_LE(errorOf(camera, scene, {&medium, 1}, {.background = Rgb(0.3, 0.2, 0.1)}), kBar)
            << "nodal " << nodal << ", lit " << lit << ", view " << &camera - &views[0];
      }
    }
    const FdsField field = fieldOf(nodal, 2, false);
    const AnyMedium medium(field);
    EXPECT_LE(errorOf(Camera::framing(field.bounds(), kWidth, kHeight), {{glPart(GlFds{field})}},
                      {&medium, 1}, {.aov = Aov::kOpticalDepth}),
              1e-4);
  }
}

TEST_F(GlRendererTest, FireOfFdsCasesShinesThroughItsSmokeAndFog) {
  for (const bool nodal : {false, true}) {
    const FdsField smoke = fieldOf(nodal, 1, false);
    const FdsFlame flame(fieldOf(nodal, 700, false, 8), {});
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
