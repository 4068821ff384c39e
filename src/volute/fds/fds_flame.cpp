// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_flame.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "volute/optics/black_body.hpp"

namespace volute {
namespace {

constexpr double kPerMegawatt = 1e-3;    // of kW
constexpr double kDark = 1e-3;           // of white: is no flame
constexpr double kZeroCelsius = 273.15;  // [K]

FdsField above(const FdsField& heat, double cutoff) {
  std::vector<std::shared_ptr<const FdsValues>> values;
  for (std::size_t i = 0; i < heat.grid().lattices().size(); ++i) {
    auto cut = std::make_shared<FdsValues>();
    cut->value = heat.values(i).value;
    for (float& value : cut->value) {
      // NaN stays: it marks what no gas needs.
      if (value < static_cast<float>(cutoff))
        value = 0;
    }
    values.push_back(std::move(cut));
  }
  return heat.withValues(std::move(values));
}

/// The box of all cells that have a value above 0, or corners that have; empty if none has.
Box3 litBounds(const FdsField& light) {
  Box3 box;
  for (std::size_t i = 0; i < light.grid().lattices().size(); ++i) {
    const FdsLattice& lattice = light.grid().lattices()[i];
    const auto& values = light.values(i).value;
    if (!light.grid().holds(i))
      continue;
    const int extra = lattice.nodal ? 1 : 0;
    std::size_t place = 0;
    for (int z = 0; z < lattice.cells(2) + extra; ++z) {
      for (int y = 0; y < lattice.cells(1) + extra; ++y) {
        for (int x = 0; x < lattice.cells(0) + extra; ++x) {
          if (!(values[place++] > 0))
            continue;
          const std::array<int, 3> at{x, y, z};
          for (int axis = 0; axis < 3; ++axis) {
            // A node lights the cells on both sides of it.
            const auto& planes = lattice.planes[axis];
            const int last = static_cast<int>(planes.size()) - 1;
            box.min[axis] = std::min(box.min[axis], planes[std::max(at[axis] - extra, 0)]);
            box.max[axis] = std::max(box.max[axis], planes[std::min(at[axis] + 1, last)]);
          }
        }
      }
    }
  }
  return box;
}

/// Radiance of black bodies, in units in which one of a given temperature has the luminance 1.
class BlackBodyLight {
 public:
  explicit BlackBodyLight(double brightest) {
    for (std::size_t i = 0; i < light_.size(); ++i) {
      const double kelvin = kMin + i * kStep;
      const auto [r, g, b] = blackBodyColour(kelvin);
      light_[i] = blackBodyLuminance(kelvin, brightest) * Rgb(r, g, b);
    }
  }

  Rgb at(double kelvin) const {
    const double place = (kelvin - kMin) / kStep;
    if (!(place >= 0))
      return Rgb::Zero();
    const auto low = std::min(static_cast<std::size_t>(std::min(place, 1e6)), light_.size() - 2);
    const double share = std::min(place - static_cast<double>(low), 1.0);
    return (1 - share) * light_[low] + share * light_[low + 1];
  }

 private:
  // Below the Draper point (798 K) nothing is seen to glow; FDS has no flames above 4000 K.
  static constexpr double kMin = 700, kStep = 4;  // [K]

  std::array<Rgb, 826> light_;
};

Rgb colourOf(const FlameLaw& law) {
  const auto [r, g, b] = blackBodyColour(law.temperature);
  return kPerMegawatt * law.emission * Rgb(r, g, b);
}

}  // namespace

FdsFlame::FdsFlame(std::vector<Light> lights) : lights_(std::move(lights)) {
  for (const Light& light : lights_) {
    const Box3 box = litBounds(light.field);
    if (box.empty())
      continue;
    bounds_.extend(box);
  }
  burns_ = !bounds_.empty();
  if (!burns_)
    bounds_ = lights_.front().field.bounds();
}

FdsFlame::FdsFlame(const FdsField& heat, const FlameLaw& law)
    : FdsFlame({Light{above(heat, law.cutoff), colourOf(law)}}) {}

FdsFlame FdsFlame::glowing(const FdsField& celsius, const FlameLaw& law, double brightest) {
  const BlackBodyLight table(brightest);
  std::vector<Light> lights;
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<std::shared_ptr<const FdsValues>> values;
    for (std::size_t i = 0; i < celsius.grid().lattices().size(); ++i) {
      auto light = std::make_shared<FdsValues>();
      light->value = celsius.values(i).value;
      for (float& value : light->value) {
        // NaN stays: it marks what no gas needs.
        if (!std::isnan(value))
          value = static_cast<float>(table.at(value + kZeroCelsius)[channel]);
      }
      values.push_back(std::move(light));
    }
    Rgb colour = Rgb::Zero();
    colour[channel] = law.emission;
    lights.push_back({celsius.withValues(std::move(values)), colour});
  }
  return FdsFlame(std::move(lights));
}

double FdsFlame::luminance(const FdsField& smoke, double scale) const {
  return luminance(smoke, scale, bounds_, {});
}

double FdsFlame::luminance(const FdsField& smoke, double scale, const Box3& box,
                           const std::function<void(std::span<double>)>& addUp) const {
  constexpr int kLines = 32;  // a side
  std::vector<Segment> lines;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const Vec3 size = box.size();
    for (int i = 0; i < kLines * kLines; ++i) {
      Vec3 from = box.min;
      const int row = i / kLines;
      from[u] += size[u] * (i % kLines + 0.5) / kLines;
      from[v] += size[v] * (row + 0.5) / kLines;
      lines.push_back({from, Vec3::Unit(axis), 0, size[axis]});
    }
  }
  std::vector<Radiance> seen(lines.size());
  radiance(lines, seen);
  std::vector<double> depths(lines.size()), bright;
  smoke.opticalDepth(lines, depths);
  std::vector<double> lights;
  for (const Radiance& one : seen) {
    const Rgb& light = one.emitted;
    lights.push_back(light[0] * 0.2126 + light[1] * 0.7152 + light[2] * 0.0722);
  }
  if (addUp) {
    addUp(depths);
    addUp(lights);
  }
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const double depth = scale * depths[i];
    const double passes = depth > 1e-6 ? -std::expm1(-depth) / depth : 1;
    const double luminance = passes * lights[i];
    if (luminance > kDark)
      bright.push_back(luminance);
  }
  if (bright.empty())
    return 0;
  const auto quartile = bright.begin() + static_cast<std::ptrdiff_t>(3 * bright.size() / 4);
  std::ranges::nth_element(bright, quartile);
  return *quartile;
}

Rgb FdsFlame::emission(const Vec3& point) const {
  Rgb sum = Rgb::Zero();
  for (const Light& light : lights_) sum += light.colour * light.field.extinction(point);
  return sum;
}

void FdsFlame::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  std::fill_n(depths.begin(), segments.size(), 0.0);
}

void FdsFlame::pieces(std::span<const Segment> segments,
                      std::span<std::vector<Piece>> pieces) const {
  // All lights have one grid, and so the same pieces.
  std::vector<std::vector<std::vector<Piece>>> of(lights_.size());
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    of[i].resize(segments.size());
    lights_[i].field.pieces(segments, of[i]);
  }
  for (std::size_t s = 0; s < segments.size(); ++s) {
    std::vector<Piece> list = std::move(of[0][s]);
    for (std::size_t p = 0; p < list.size(); ++p) {
      const Polynomial first = list[p].extinction;
      for (int c = 0; c < 3; ++c) list[p].emission[c] = first * lights_[0].colour[c];
      for (std::size_t i = 1; i < lights_.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
          for (std::size_t n = 0; n < first.c.size(); ++n)
            list[p].emission[c].c[n] += lights_[i].colour[c] * of[i][s][p].extinction.c[n];
        }
      }
      list[p].extinction = {};
    }
    std::erase_if(list, [](const Piece& piece) {
      return std::ranges::all_of(piece.emission, [](const Polynomial& channel) {
        return std::ranges::all_of(channel.c, [](double c) { return c == 0; });
      });
    });
    pieces[s] = std::move(list);
  }
}

void FdsFlame::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  std::fill_n(out.begin(), segments.size(), Radiance{Rgb::Zero(), 1});
  std::vector<double> along(segments.size());
  for (const Light& light : lights_) {
    light.field.opticalDepth(segments, along);
    for (std::size_t i = 0; i < segments.size(); ++i) out[i].emitted += light.colour * along[i];
  }
}

}  // namespace volute
