// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/diffuse_light.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr int kCellsAlong = 32;  ///< the longest side
constexpr double kFluxLimit = 2;
constexpr int kFluxRounds = 4;                    ///< of the limiter, which follows the light
constexpr int kMaxGradients = 400;                ///< of conjugate gradients
constexpr double kResidual = 1e-3, kLast = 1e-6;  ///< of the squared residual: rounds, the last
constexpr std::size_t kLampGroups = 4;            ///< followed at once
constexpr double kRaysAlong = 64;                 ///< across a side of the box, of a few lamps
constexpr double kFewLamps = 4;
constexpr int kSurfaceHalvings = 7;  ///< to find a surface on a ray
constexpr double kMaxAlbedo = 1 - 1e-6;

}  // namespace

double Scattering::forward() const {
  return asymmetry > 0 ? asymmetry * asymmetry : 0;
}

double Scattering::goesOn(double share) const {
  const double forward = this->forward();
  if (forward == 0 || !(share > 0))
    return 0;
  return std::pow(share, 1 - albedo.mean() * forward) - share;
}

/// Cells x fastest.
class DiffuseLight::Solver {
 public:
  Solver(const Request& request, const Box3& box, const std::array<int, 3>& cells)
      : request_(request), low_(box.min), cells_(cells) {
    for (int axis = 0; axis < 3; ++axis)
      size_[axis] = box.size()[axis] / cells[static_cast<std::size_t>(axis)];
    strides_ = {1, static_cast<std::size_t>(cells[0]),
                static_cast<std::size_t>(cells[0]) * static_cast<std::size_t>(cells[1])};
    count_ = strides_[2] * static_cast<std::size_t>(cells[2]);
    forward_ = request.scattering.forward();
    asymmetry_ = std::max(request.scattering.asymmetry, 0.0);
    cosine_ = asymmetry_ / (1 + asymmetry_);
    albedo_ = request.scattering.albedo.max(0).min(kMaxAlbedo);
    findExtinction();
    findWalls();
    followLamps();
  }

  /// Channels of one albedo share the limiter, which follows their sum.
  std::vector<Cell> solve() {
    std::vector<Cell> light(count_);
    std::array<bool, 3> solved{};
    for (int first = 0; first < 3; ++first) {
      if (solved[static_cast<std::size_t>(first)])
        continue;
      std::vector<int> alike;
      Sources sum(count_);
      for (int c = first; c < 3; ++c) {
        if (albedo_[c] != albedo_[first])
          continue;
        alike.push_back(c), solved[static_cast<std::size_t>(c)] = true;
        for (std::size_t i = 0; i < count_; ++i) {
          sum[i].power += sent_[i][static_cast<std::size_t>(c)].power;
          sum[i].way += sent_[i][static_cast<std::size_t>(c)].way;
        }
      }
      std::vector<double> all;
      Equations equations;
      for (int round = 0; round < kFluxRounds; ++round) {
        equations = equationsOf(first, all);
        all.resize(count_, 0);
        relax(equations, sourceOf(equations, sum), round + 1 < kFluxRounds ? kResidual : kLast,
              all);
      }
      parallelFor(alike.size(), [&](std::size_t k) {
        const auto c = static_cast<std::size_t>(alike[k]);
        Sources sent(count_);
        double own = 0, whole = 0;
        for (std::size_t i = 0; i < count_; ++i) {
          sent[i] = sent_[i][c];
          own += sent[i].power, whole += sum[i].power;
        }
        std::vector<double> channel = all;
        for (double& one : channel) one *= whole > 0 ? own / whole : 0;
        relax(equations, sourceOf(equations, sent), kLast, channel);
        take(equations, sent, channel, c, light);
      });
    }
    return light;
  }

 private:
  /// Light that leaves the lamps' rays in a cell: power, and the way it goes times power.
  struct Sent {
    double power = 0;
    Vec3 way = Vec3::Zero();
  };

  using Sources = std::vector<Sent>;

  template <class Each>
  void forCells(Each&& each) const {
    std::size_t i = 0;
    for (int z = 0; z < cells_[2]; ++z) {
      for (int y = 0; y < cells_[1]; ++y) {
        for (int x = 0; x < cells_[0]; ++x, ++i) each(i, std::array<int, 3>{x, y, z});
      }
    }
  }

  double areaAcross(std::size_t axis) const { return size_.prod() / size_[static_cast<int>(axis)]; }

  void findExtinction() {
    constexpr int kAcross = 2;  // rays through a cell
    extinction_.assign(count_, 0);
    const auto columns = strides_[2];
    parallelRanges(columns, 16, [&](std::size_t begin, std::size_t end) {
      std::vector<Segment> ways;
      for (std::size_t column = begin; column < end; ++column) {
        const auto x = static_cast<double>(column % strides_[1]),
                   y = static_cast<double>(column / strides_[1]);
        for (int k = 0; k < kAcross * kAcross; ++k) {
          const Vec3 from = low_ + Vec3((x + (k % kAcross + 0.5) / kAcross) * size_.x(),
                                        (y + (k / kAcross + 0.5) / kAcross) * size_.y(), 0);
          for (int z = 0; z < cells_[2]; ++z)
            ways.push_back({from, Vec3::UnitZ(), z * size_.z(), (z + 1) * size_.z()});
        }
      }
      std::vector<double> depths(ways.size());
      const auto add = [&](const AnyMedium& medium, double times) {
        medium.opticalDepth(ways, depths);
        std::size_t way = 0;
        for (std::size_t column = begin; column < end; ++column) {
          for (int k = 0; k < kAcross * kAcross; ++k) {
            for (std::size_t z = 0; z < static_cast<std::size_t>(cells_[2]); ++z, ++way)
              extinction_[column + z * strides_[2]] +=
                  times * depths[way] / (kAcross * kAcross * size_.z());
          }
        }
      };
      add(request_.medium, request_.density);
      for (const AnyMedium& medium : request_.between) add(medium, 1);
    });
  }

  Vec3 middleOf(const std::array<int, 3>& cell) const {
    return low_ + Vec3((cell[0] + 0.5) * size_.x(), (cell[1] + 0.5) * size_.y(),
                       (cell[2] + 0.5) * size_.z());
  }

  /// Between which cells something opaque is.
  void findWalls() {
    walls_.assign(3 * count_, 0);
    if (!request_.blocks)
      return;
    std::vector<Segment> ways;
    std::vector<std::size_t> faces;
    forCells([&](std::size_t i, const std::array<int, 3>& cell) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool inside = cell[axis] + 1 < cells_[axis];
        if (!inside || !(extinction_[i] + extinction_[i + strides_[axis]] > 0))
          continue;
        Segment way{middleOf(cell), Vec3::Unit(static_cast<int>(axis)), 0,
                    size_[static_cast<int>(axis)]};
        ways.push_back(way);
        faces.push_back(3 * i + axis);
      }
    });
    const std::vector<std::uint8_t> blocked = blockedOf(ways);
    for (std::size_t k = 0; k < faces.size(); ++k) walls_[faces[k]] = blocked[k];
  }

  std::vector<std::uint8_t> blockedOf(std::span<const Segment> ways) const {
    std::vector<std::uint8_t> blocked(ways.size(), 0);
    parallelRanges(ways.size(), 1024, [&](std::size_t begin, std::size_t end) {
      request_.blocks(ways.subspan(begin, end - begin),
                      std::span(blocked).subspan(begin, end - begin));
    });
    return blocked;
  }

  /// A ray of a lamp inside the box, and its power.
  struct Beam {
    Segment way;
    double power = 0;
  };

  /// Rays that leave the box through an even grid of each face, so that they fill it evenly.
  std::vector<Beam> beamsOf(const Lamp& lamp) const {
    const Vec3 size = size_.cwiseProduct(Vec3(cells_[0], cells_[1], cells_[2]));
    const Box3 box{low_, low_ + size};
    const double most = std::max(
        8.0, kRaysAlong *
                 std::min(1.0, std::sqrt(kFewLamps / static_cast<double>(request_.lamps.size()))));
    const bool sun = lamp.kind == Lamp::Kind::kSun;
    std::vector<Beam> beams;
    for (int face = 0; face < 6; ++face) {
      const int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto along = [&](int a) {
        const double share = cells_[static_cast<std::size_t>(a)] / double{kCellsAlong};
        return std::max(4, static_cast<int>(std::ceil(most * share)));
      };
      const int across = along(u), up = along(v);
      const double area = size[u] / across * (size[v] / up);
      for (int k = 0; k < across * up; ++k) {
        Vec3 target = box.min;
        if (face % 2)
          target[axis] = box.max[axis];
        target[u] += (k % across + 0.5) / across * size[u];
        target[v] += (k / across + 0.5) / up * size[v];
        const Vec3 away = target - lamp.position;
        const double distance = away.norm();
        if (!sun && !(distance > 0))
          continue;
        const Vec3 direction = sun ? lamp.direction : Vec3(away / distance);
        const double cosine = (face % 2 ? 1 : -1) * direction[axis];
        if (!(cosine > 0))
          continue;
        Interval inside = box.intersect(target, direction);
        inside.begin = std::max(inside.begin, sun ? inside.begin : -distance);
        inside.end = std::min(inside.end, 0.0);
        const double power =
            area * cosine * (sun ? 1 : lamp.coneShare(target) / (distance * distance));
        if (power > 0 && !inside.empty())
          beams.push_back({{target, direction, inside.begin, inside.end}, power});
      }
    }
    weaken(lamp, beams);
    return beams;
  }

  /// By what is before the box, and by surfaces.
  void weaken(const Lamp& lamp, std::vector<Beam>& beams) const {
    const bool sun = lamp.kind == Lamp::Kind::kSun;
    std::vector<Segment> ways;
    for (const Beam& beam : beams) {
      Segment way = beam.way;
      way.end = way.begin;
      way.begin =
          sun ? -std::numeric_limits<double>::infinity() : -(way.origin - lamp.position).norm();
      ways.push_back(way);
    }
    std::vector<double> depths(ways.size());
    for (const AnyMedium& medium : request_.between) {
      medium.opticalDepth(ways, depths);
      for (std::size_t i = 0; i < beams.size(); ++i) beams[i].power *= std::exp(-depths[i]);
    }
    if (!request_.blocks)
      return;
    // Where surfaces end a ray: the light comes from the lamp, so a ray is free up to there.
    std::vector<Interval> ends;
    for (const Beam& beam : beams) ends.push_back({beam.way.begin, beam.way.end});
    for (int halving = -1; halving < kSurfaceHalvings; ++halving) {
      for (std::size_t i = 0; i < beams.size(); ++i) {
        const double to = halving < 0 ? ends[i].end : 0.5 * (ends[i].begin + ends[i].end);
        // As light's way back: it may be endless.
        ways[i] = {beams[i].way.at(to), -beams[i].way.direction, 0,
                   sun ? std::numeric_limits<double>::infinity()
                       : to + (beams[i].way.origin - lamp.position).norm()};
      }
      const std::vector<std::uint8_t> blocked = blockedOf(ways);
      for (std::size_t i = 0; i < beams.size(); ++i) {
        const double middle = 0.5 * (ends[i].begin + ends[i].end);
        if (halving < 0)
          ends[i].begin = blocked[i] ? ends[i].begin : ends[i].end;
        else if (ends[i].begin < ends[i].end)
          (blocked[i] ? ends[i].end : ends[i].begin) = middle;
      }
    }
    for (std::size_t i = 0; i < beams.size(); ++i) beams[i].way.end = ends[i].begin;
  }

  /// What lamps' rays lose on their way goes to the cells: of some lamps each to cells of its own,
  /// which are added up in one order.
  void followLamps() {
    sent_.assign(count_, {});
    const std::size_t groups = std::min(kLampGroups, request_.lamps.size());
    std::vector<decltype(sent_)> each(groups);
    parallelFor(groups, [&](std::size_t group) {
      each[group].assign(count_, {});
      for (std::size_t l = group; l < request_.lamps.size(); l += groups)
        follow(request_.lamps[l], each[group]);
    });
    parallelRanges(count_, 1024, [&](std::size_t begin, std::size_t end) {
      for (const auto& some : each) {
        for (std::size_t i = begin; i < end; ++i) {
          for (std::size_t c = 0; c < 3; ++c)
            sent_[i][c].power += some[i][c].power, sent_[i][c].way += some[i][c].way;
        }
      }
    });
  }

  void follow(const Lamp& lamp, std::vector<std::array<Sent, 3>>& sent) const {
    for (const Beam& beam : beamsOf(lamp)) {
      const Segment& way = beam.way;
      if (way.empty())
        continue;
      double rate = 0;  // cells a metre
      for (int axis = 0; axis < 3; ++axis)
        rate = std::max(rate, std::abs(way.direction[axis]) / size_[axis]);
      const double length = way.end - way.begin;
      const int steps = std::max(1, static_cast<int>(std::ceil(2 * length * rate)));
      const double step = length / steps;
      Rgb power = beam.power * lamp.intensity;
      for (int k = 0; k < steps && power.maxCoeff() > 0; ++k) {
        const Vec3 at = (way.at(way.begin + (k + 0.5) * step) - low_).cwiseQuotient(size_);
        std::size_t cell = 0;
        for (int axis = 0; axis < 3; ++axis) {
          const auto a = static_cast<std::size_t>(axis);
          cell += strides_[a] * static_cast<std::size_t>(
                                    std::clamp(static_cast<int>(at[axis]), 0, cells_[a] - 1));
        }
        const double depth = extinction_[cell] * step;
        if (!(depth > 0))
          continue;
        for (int c = 0; c < 3; ++c) {
          const double loses = 1 - albedo_[c] * forward_;
          const double lost = -power[c] * std::expm1(-depth * loses);
          power[c] -= lost;
          const double scattered = lost * albedo_[c] * (1 - forward_) / loses;
          Sent& here = sent[cell][static_cast<std::size_t>(c)];
          here.power += scattered;
          here.way += scattered * way.direction;
        }
      }
    }
  }

  struct Equations {
    std::vector<double> faces;    ///< three for each cell, to the next one along each axis
    std::vector<double> taken;    ///< of each cell's light: absorbed, or out of the box
    std::vector<double> inverse;  ///< of what is taken and goes through faces
  };

  double transport(std::size_t cell, int channel) const {
    return 3 * extinction_[cell] * (1 - albedo_[channel] * asymmetry_);
  }

  /// @param light  of the round before; empty: none
  Equations equationsOf(int channel, const std::vector<double>& light) const {
    Equations all;
    all.faces.assign(3 * count_, 0);
    all.taken.resize(count_);
    const double volume = size_.prod();
    for (std::size_t i = 0; i < count_; ++i)
      all.taken[i] = extinction_[i] * (1 - albedo_[channel]) * volume;
    const auto leaves = [&](std::size_t cell, std::size_t axis) {  // half of what is there, at most
      all.taken[cell] +=
          areaAcross(axis) / (0.5 * size_[static_cast<int>(axis)] * transport(cell, channel) + 2);
    };
    // The change of light along an axis at a cell.
    const auto slope = [&](std::size_t i, const std::array<int, 3>& cell, std::size_t axis) {
      const bool low = cell[axis] > 0, high = cell[axis] + 1 < cells_[axis];
      if (!low && !high)
        return 0.0;
      return (light[high ? i + strides_[axis] : i] - light[low ? i - strides_[axis] : i]) /
             (size_[static_cast<int>(axis)] * (int{low} + int{high}));
    };
    forCells([&](std::size_t i, const std::array<int, 3>& cell) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double length = size_[static_cast<int>(axis)];
        if (cell[axis] == 0)
          leaves(i, axis);
        if (cell[axis] + 1 == cells_[axis]) {
          leaves(i, axis);
          continue;
        }
        const std::size_t next = i + strides_[axis];
        if (walls_[3 * i + axis]) {
          leaves(i, axis), leaves(next, axis);
          continue;
        }
        double change = 1 / size_.maxCoeff();  // of the light, relative to it, a metre
        if (!light.empty()) {
          std::array<int, 3> nextCell = cell;
          ++nextCell[axis];
          double squares = 0;
          for (std::size_t other = 0; other < 3; ++other) {
            const double one = other == axis
                                   ? (light[next] - light[i]) / length
                                   : 0.5 * (slope(i, cell, other) + slope(next, nextCell, other));
            squares += one * one;
          }
          const double mean = 0.5 * (light[i] + light[next]);
          change = mean > 1e-30 ? std::sqrt(squares) / mean : 1 / length;
        }
        const double thick = 0.5 * (transport(i, channel) + transport(next, channel));
        const double diffusion =
            1 / std::max(std::hypot(thick, kFluxLimit * change), 1e-6 / size_.maxCoeff());
        all.faces[3 * i + axis] = diffusion * areaAcross(axis) / length;
      }
    });
    all.inverse = all.taken;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i + strides_[axis] < count_; ++i) {
        all.inverse[i] += all.faces[3 * i + axis];
        all.inverse[i + strides_[axis]] += all.faces[3 * i + axis];
      }
    }
    for (double& one : all.inverse) one = one > 0 ? 1 / one : 0;
    return all;
  }

  std::vector<double> sourceOf(const Equations& all, const Sources& sent) const {
    std::vector<double> source(count_);
    for (std::size_t i = 0; i < count_; ++i) source[i] = sent[i].power;
    const double volume = size_.prod();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<int>(axis);
      for (std::size_t i = 0; i + strides_[axis] < count_; ++i) {
        const std::size_t next = i + strides_[axis];
        const double along = 3 * all.faces[3 * i + axis] * size_[a] * cosine_ / (2 * volume) *
                             (sent[i].way + sent[next].way)[a];
        source[i] -= along;
        source[next] += along;
      }
    }
    return source;
  }

  /// Brings the light of each cell, its integral over all ways, nearer to what the equations say.
  /// @param goal  of the squared residual, of that of no light
  void relax(const Equations& all, const std::vector<double>& source, double goal,
             std::vector<double>& light) const {
    std::vector<double> residual(count_), scaled(count_), way(count_), step(count_);
    apply(all, light, step);
    double size = 0, whole = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      residual[i] = source[i] - step[i];
      way[i] = scaled[i] = residual[i] * all.inverse[i];
      size += residual[i] * scaled[i];
      whole += source[i] * source[i] * all.inverse[i];
    }
    for (int k = 0; k < kMaxGradients && size > goal * whole; ++k) {
      apply(all, way, step);
      double along = 0, next = 0;
      for (std::size_t i = 0; i < count_; ++i) along += way[i] * step[i];
      if (!(along > 0))
        break;
      const double far = size / along;
      for (std::size_t i = 0; i < count_; ++i) {
        light[i] += far * way[i];
        residual[i] -= far * step[i];
        scaled[i] = residual[i] * all.inverse[i];
        next += residual[i] * scaled[i];
      }
      for (std::size_t i = 0; i < count_; ++i) way[i] = scaled[i] + next / size * way[i];
      size = next;
    }
    for (double& one : light) one = std::max(one, 0.0);
  }

  void apply(const Equations& all, const std::vector<double>& light,
             std::vector<double>& out) const {
    for (std::size_t i = 0; i < count_; ++i) out[i] = all.taken[i] * light[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t stride = strides_[axis];
      for (std::size_t i = 0; i + stride < count_; ++i) {
        const double flux = all.faces[3 * i + axis] * (light[i] - light[i + stride]);
        out[i] += flux;
        out[i + stride] -= flux;
      }
    }
  }

  /// Radiance and flux of a channel.
  void take(const Equations& all, const Sources& from, const std::vector<double>& light,
            std::size_t c, std::vector<Cell>& out) const {
    constexpr double kEvenly = 1 / (4 * std::numbers::pi);
    const double volume = size_.prod();
    forCells([&](std::size_t i, const std::array<int, 3>& cell) {
      out[i][c][0] = static_cast<float>(kEvenly * light[i]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double flux = 0;
        int sides = 0;
        const auto add = [&](std::size_t low) {
          const std::size_t to = low + strides_[axis];
          const double face = all.faces[3 * low + axis] / areaAcross(axis);
          const Vec3 sent = (from[low].way + from[to].way) / (2 * volume);
          flux +=
              face * (light[low] - light[to] +
                      3 * cosine_ * size_[static_cast<int>(axis)] * sent[static_cast<int>(axis)]);
          ++sides;
        };
        if (cell[axis] + 1 < cells_[axis])
          add(i);
        if (cell[axis] > 0)
          add(i - strides_[axis]);
        out[i][c][axis + 1] =
            static_cast<float>(3 * asymmetry_ * kEvenly * flux / std::max(sides, 1));
      }
    });
  }

  const Request& request_;
  Vec3 low_, size_;
  std::array<int, 3> cells_;
  std::array<std::size_t, 3> strides_{};
  std::size_t count_ = 0;
  double forward_ = 0, asymmetry_ = 0, cosine_ = 0;
  Rgb albedo_;
  std::vector<double> extinction_;
  std::vector<std::uint8_t> walls_;
  std::vector<std::array<Sent, 3>> sent_;
};

DiffuseLight::DiffuseLight(const Request& request) {
  if (request.box.empty())
    return;
  const Vec3 size = request.box.size();
  const double side = size.maxCoeff() / kCellsAlong;
  for (int axis = 0; axis < 3; ++axis) {
    cells_[static_cast<std::size_t>(axis)] = std::clamp(
        static_cast<int>(std::ceil(size[axis] / side - 1e-9)), kCellsAlong / 4, kCellsAlong);
    perMetre_[axis] = cells_[static_cast<std::size_t>(axis)] / size[axis];
  }
  low_ = request.box.min;
  light_ = Solver(request, request.box, cells_).solve();
}

DiffuseLight::Cell DiffuseLight::between(const Vec3& point) const {
  Cell sum{};
  if (light_.empty())
    return sum;
  const Vec3 place = (point - low_).cwiseProduct(perMetre_);
  std::array<std::size_t, 3> first{}, second{};
  std::array<float, 3> share{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int last = cells_[axis] - 1;
    const double at = place[static_cast<int>(axis)] - 0.5;
    if (!(at >= -1 && at <= last + 1))
      return sum;  // far outside there is none
    const double in = std::clamp(at, 0.0, static_cast<double>(last));
    first[axis] = static_cast<std::size_t>(in);
    second[axis] = std::min(first[axis] + 1, static_cast<std::size_t>(last));
    share[axis] = static_cast<float>(in - static_cast<double>(first[axis]));
  }
  for (unsigned corner = 0; corner < 8; ++corner) {
    float weight = 1;
    std::size_t cell = 0, stride = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool high = corner >> axis & 1;
      weight *= high ? share[axis] : 1 - share[axis];
      cell += stride * (high ? second[axis] : first[axis]);
      stride *= static_cast<std::size_t>(cells_[axis]);
    }
    if (!(weight > 0))
      continue;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < 4; ++k) sum[c][k] += weight * light_[cell][c][k];
    }
  }
  return sum;
}

Rgb DiffuseLight::at(const Vec3& point) const {
  const Cell cell = between(point);
  return {cell[0][0], cell[1][0], cell[2][0]};
}

Rgb DiffuseLight::towards(const Vec3& point, const Vec3& direction) const {
  const Cell cell = between(point);
  Rgb light;
  for (std::size_t c = 0; c < 3; ++c) {
    const double along =
        cell[c][1] * direction.x() + cell[c][2] * direction.y() + cell[c][3] * direction.z();
    light[static_cast<int>(c)] = std::max(cell[c][0] + along, 0.0);
  }
  return light;
}

DiffuseLight::Cells DiffuseLight::cells() const {
  Cells cells{low_, perMetre_, light_.empty() ? std::array<int, 3>{} : cells_};
  for (const Cell& cell : light_) {
    for (const auto& channel : cell)
      cells.values.insert(cells.values.end(), channel.begin(), channel.end());
  }
  return cells;
}

}  // namespace volute
