// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "volute/base/parallel.hpp"
#include "volute/math/phase_function.hpp"
#include "volute/media/light_blockers.hpp"
#include "volute/media/volume/light_fan.hpp"

namespace volute {
namespace {

constexpr std::size_t kLightGrain = 512;  // rays that are marched together
constexpr int kCoarse = 4;                // voxels between places where even light is known
constexpr std::size_t kMaxFires = 48;
constexpr int kFireStep = 4;  // voxels between places where light of its own fire is known
constexpr int kSkyWays = 100, kFewSkyWays = 26, kHalvedSkyWays = 50;
constexpr std::size_t kSmall = std::size_t{1} << 17;  // voxels, at each of which the sky is known

/// Transmittances of the volume along segments of the world.
void transmittances(const ShadedVoxels& volume, const AffineMap& place,
                    std::span<const Segment> segments, std::span<float> out) {
  std::vector<Radiance> light(segments.size());
  AffineMedium(AnyMedium(volume.absorption()), place).radiance(segments, light);
  for (std::size_t i = 0; i < light.size(); ++i)
    out[i] = static_cast<float>(light[i].transmittance);
}

/// Evenly from everywhere, of radiance 1: a spiral over half of the sphere, each way with its
/// opposite behind it. Smoke hides parts of the sky with sharp edges, which many ways average out
/// sooner than rules for smooth functions.
/// @param count  even
std::vector<Lamp> skyOf(int count) {
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<Lamp> lamps;
  for (int i = 0; i < count / 2; ++i) {
    const double up = 1 - (2 * i + 1.0) / count, aside = std::sqrt(1 - up * up);
    Lamp lamp;
    lamp.kind = Lamp::Kind::kSun;
    lamp.direction = Vec3(aside * std::cos(turn * i), aside * std::sin(turn * i), up);
    lamp.intensity.setConstant(4 * std::numbers::pi / count);
    lamps.push_back(lamp);
    lamp.direction = -lamp.direction;
    lamps.push_back(lamp);
  }
  return lamps;
}

/// From the faces and corners of a cube alone (Lebedev's rule of 14 points, exact to degree 5):
/// what the first format of scenes has.
std::vector<Lamp> skyOfCube() {
  std::vector<Lamp> lamps;
  for (int i = 0; i < 13; ++i) {
    const Vec3 way(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const auto axes = std::lround(way.squaredNorm());
    if (axes == 2)
      continue;
    Lamp lamp;
    lamp.kind = Lamp::Kind::kSun;
    lamp.direction = way.normalized();
    lamp.intensity.setConstant(4 * std::numbers::pi * (axes == 1 ? 1 / 15.0 : 3 / 40.0));
    lamps.push_back(lamp);
    lamp.direction = -lamp.direction;
    lamps.push_back(lamp);
  }
  return lamps;
}

}  // namespace

/// Light that is scattered evenly, on a lattice of every so many-th voxel, from the voxel before
/// the first on; or at each of the volume's places.
class VolumeLight::Lattice {
 public:
  /// @param places  of the volume; must outlive it
  /// @param halved  its nodes are voxels of BrickSlice::halved()
  Lattice(const BrickSlice& slice, const VoxelPlaces& places, int voxels, bool halved = false)
      : step_(voxels), halved_(halved) {
    if (step_ == 1) {
      nodes = places;
    } else {
      findNodes(slice, places);
      nodes = own_;
    }
    light.resize(nodes.size(), VoxelLight::Zero());
  }

  /// Looks up places, most of which are beside the one before.
  class Reader {
   public:
    explicit Reader(const Lattice& lattice) : lattice_(lattice) {}

    /// Between the eight nodes around a place, which is the i-th of all.
    Rgb at(const Place& place, std::size_t i) {
      const int step = lattice_.step_;
      if (step == 1)
        return lattice_.light[i].cast<double>();
      const Place cell = lattice_.cellOf(place);
      const auto share = [&](std::size_t axis) {
        const double before = lattice_.halved_ ? 1.5 : 1;
        return (place[axis] + before - step * cell[axis]) / step;
      };
      if (cell != cell_ || place[1] != row_[0] || place[2] != row_[1]) {
        if (cell != cell_)
          readCorners(cell);
        row_ = {place[1], place[2]};
        const double y = share(1), z = share(2);
        const auto across = [&](int c) -> Rgb {
          const Rgb low = corners_[c] + y * (corners_[c + 2] - corners_[c]);
          const Rgb high = corners_[c + 4] + y * (corners_[c + 6] - corners_[c + 4]);
          return low + z * (high - low);
        };
        begin_ = across(0);
        along_ = across(1) - begin_;
      }
      return begin_ + share(0) * along_;
    }

   private:
    void readCorners(const Place& cell) {
      cell_ = cell;
      for (int c = 0; c < 8; ++c) {
        const std::int32_t node =
            lattice_.node_.at(cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2));
        corners_[c] = lattice_.light[static_cast<std::size_t>(node)].cast<double>();
      }
    }

    const Lattice& lattice_;
    Place cell_{-1, -1, -1};
    std::array<std::int32_t, 2> row_{};  // y and z
    Rgb corners_[8], begin_, along_;     // along a row
  };

  /// Of a node, in the volume's own space.
  Vec3 centreOf(const Place& at, const ShadedVoxels& volume) const {
    if (!halved_)
      return volume.centreOf(at);
    const Place first{2 * at[0], 2 * at[1], 2 * at[2]};
    return 0.5 *
           (volume.centreOf(first) + volume.centreOf({first[0] + 1, first[1] + 1, first[2] + 1}));
  }

  VoxelPlaces nodes;
  std::vector<VoxelLight> light;  ///< at the nodes

 private:
  void findNodes(const BrickSlice& slice, const VoxelPlaces& places) {
    // Places reach one voxel beyond the volume; cells need the node behind them.
    node_ = BrickTable({slice.x() / step_ + 3, slice.y() / step_ + 3, slice.z() / step_ + 3},
                       places.size() / static_cast<std::size_t>(step_ * step_));
    Place last{-1, -1, -1};
    VoxelPlaces::Reader at(places);
    for (std::size_t p = 0; p < places.size(); ++p) {
      const Place cell = cellOf(at[p]);
      if (cell == last)
        continue;
      last = cell;
      for (int i = 0; i < 8; ++i) {
        const BrickPlace node{cell[0] + (i & 1), cell[1] + (i >> 1 & 1), cell[2] + (i >> 2)};
        if (node_.at(node) >= 0)
          continue;
        node_.set(node, static_cast<std::int32_t>(own_.size()));
        const int own = halved_ ? step_ / 2 : step_;
        own_.push_back({own * node[0] - 1, own * node[1] - 1, own * node[2] - 1});
      }
    }
  }

  Place cellOf(const Place& place) const {
    return {(place[0] + 1) / step_, (place[1] + 1) / step_, (place[2] + 1) / step_};
  }

  int step_;
  bool halved_;
  std::vector<Place> own_;
  BrickTable node_;  // numbers of nodes
};

VolumeLight::VolumeLight(ShadedVoxels volume, VolumeLighting lighting)
    : volume_(std::move(volume)), lighting_(std::move(lighting)) {}

namespace {

/// What glows in a part of a volume.
struct Glow {
  Rgb power = Rgb::Zero();  ///< sums over voxels
  Vec3 moment = Vec3::Zero();
  double weight = 0, square = 0;

  void add(const Rgb& sent, const Vec3& at) {
    const double share = sent.sum();
    power += sent;
    moment += share * at;
    square += share * at.squaredNorm();
    weight += share;
  }

  void add(const Glow& other) {
    power += other.power, moment += other.moment;
    weight += other.weight, square += other.square;
  }

  /// A lamp of its power. What a voxel emits goes everywhere: its power per solid angle is radiance
  /// per metre times volume. Inside of it no light is stronger than at its rim.
  /// @param voxel  its edges
  Lamp lamp(const Mat3& voxel, double scale) const {
    Lamp made;
    made.position = moment / weight;
    made.intensity = scale * std::abs(voxel.determinant()) * power;
    const double spread = std::sqrt(std::max(square / weight - made.position.squaredNorm(), 0.0));
    made.radius = std::max(spread, 0.5 * voxel.norm());
    return made;
  }
};

Glow glowOf(const BrickSlice& slice, const BrickSlice::Entry& entry, const Vec3& voxel,
            const AffineMap& space) {
  Glow glow;
  const auto [bx, by, bz] = entry.place;
  const int channels = slice.channels(), first = channels == 4 ? 1 : 0;
  const int step = channels == 1 ? 0 : BrickSlice::kVoxels;  // grey: one for all three
  const float* values = slice.brick(entry.stored) + first * BrickSlice::kVoxels;
  for (int i = 0; i < BrickSlice::kVoxels; ++i) {
    const Rgb sent = Rgb(values[i], values[i + step], values[i + 2 * step]).max(0);
    if (!(sent.sum() > 0))
      continue;
    const Vec3 place(bx * 8 + i % 8 + 0.5, by * 8 + i / 8 % 8 + 0.5, bz * 8 + i / 64 + 0.5);
    glow.add(sent, space.toWorld(slice.bounds().min + place.cwiseProduct(voxel)));
  }
  return glow;
}

}  // namespace

std::vector<Lamp> VolumeLight::lampsOf(const BrickSlice& slice, const AffineMap& place,
                                       double scale, std::size_t most) {
  const Vec3 voxel = slice.bounds().size().cwiseQuotient(Vec3(slice.x(), slice.y(), slice.z()));
  std::map<std::array<int, 3>, Glow> glows;
  for (const BrickSlice::Entry& entry : slice.entries()) {
    const Glow here = glowOf(slice, entry, voxel, place);
    if (here.weight > 0)
      glows[entry.place] = here;
  }
  while (glows.size() > std::max<std::size_t>(most, 1)) {
    std::map<std::array<int, 3>, Glow> larger;
    for (const auto& [at, glow] : glows) larger[{at[0] / 2, at[1] / 2, at[2] / 2}].add(glow);
    glows = std::move(larger);
  }
  std::vector<Lamp> lamps;
  const Mat3 edges = place.linear() * voxel.asDiagonal();
  for (const auto& [at, glow] : glows) lamps.push_back(glow.lamp(edges, scale));
  return lamps;
}

std::vector<Lamp> VolumeLight::fires() const {
  if (!lighting_.ownFire || volume_.slice().channels() != 4)
    return {};
  return lampsOf(volume_.slice(), lighting_.place, 1, kMaxFires);
}

/// From everywhere beyond the volume.
std::shared_ptr<const VolumeLight::Lattice> VolumeLight::sky() const {
  const auto places = volume_.lightPlaces();
  const bool fans = lighting_.place.keepsLengths() && volume_.slice().basis() == Basis::kTrilinear;
  // Larger volumes have larger features.
  const std::size_t small = fans ? kSmall : kSmall / 8;
  const int step = lighting_.firstSky || lighting_.fewSky ? kCoarse
                   : places.size() <= small               ? 1
                   : places.size() <= 8 * small           ? 2
                                                          : kCoarse;
  // Between places so far apart nothing is seen of single voxels.
  const bool halved = fans && step == kCoarse && !lighting_.firstSky;
  auto lattice = std::make_shared<Lattice>(volume_.slice(), places, step, halved);
  const int ways = !fans ? kFewSkyWays : halved ? kHalvedSkyWays : kSkyWays;
  const std::vector<Lamp> lamps = lighting_.firstSky ? skyOfCube() : skyOf(ways);
  const std::optional<BrickSlice> half =
      halved ? std::optional(volume_.slice().halved(0)) : std::nullopt;
  const LightFan fan(half ? *half : volume_.slice(), lattice->nodes);
  std::vector<float> passes(lattice->nodes.size()), beyond(passes.size());
  std::vector<Lamp> marched;
  for (std::size_t i = 0; i < lamps.size(); i += 2) {
    if (!fanned(fan, lamps[i], passes, beyond)) {
      marched.insert(marched.end(), {lamps[i], lamps[i + 1]});
      continue;
    }
    const VoxelLight each =
        (lamps[i].intensity / (4 * std::numbers::pi) * lighting_.surrounding).cast<float>();
    for (std::size_t n = 0; n < passes.size(); ++n)
      lattice->light[n] += (passes[n] + beyond[n]) * each;
  }
  for (Lamp& lamp : marched) lamp.intensity *= lighting_.surrounding;
  addRays(marched, *lattice);
  return lattice;
}

/// By a ray from each node to each lamp.
void VolumeLight::addRays(std::span<const Lamp> lamps, Lattice& lattice) const {
  if (lamps.empty())
    return;
  parallelRanges(lattice.nodes.size(), 1 + kLightGrain / lamps.size(),
                 [&](std::size_t begin, std::size_t end) {
                   std::vector<Segment> segments;
                   std::vector<float> passes(lamps.size());
                   VoxelPlaces::Reader at(lattice.nodes);
                   for (std::size_t i = begin; i < end; ++i) {
                     segments.clear();
                     const Vec3 node = lighting_.place.toWorld(lattice.centreOf(at[i], volume_));
                     for (const Lamp& lamp : lamps) segments.push_back(lamp.towards(node));
                     transmittances(volume_, lighting_.place, segments, passes);
                     Rgb sum = Rgb::Zero();
                     for (std::size_t k = 0; k < lamps.size(); ++k)
                       sum += passes[k] / (4 * std::numbers::pi) * lamps[k].irradiance(node);
                     lattice.light[i] += sum.cast<float>();
                   }
                 });
}

/// Whether rays of its fan, which measure lengths in the volume's space, say what arrives.
bool VolumeLight::fanned(const LightFan& fan, const Lamp& lamp, std::span<float> out,
                         std::span<float> beyond) const {
  if (!lighting_.place.keepsLengths())
    return false;
  Lamp own = lamp;
  own.position = lighting_.place.toOwn(lamp.position);
  own.direction = lighting_.place.inverse() * lamp.direction;
  return fan.transmittances(own, out, beyond);
}

/// Light points on both sides of the surface of what is nearly solid, where rays of a fan that pass
/// on both sides of a surface say little of the light between them.
const std::vector<bool>& VolumeLight::atSolid() const {
  constexpr double kSolid = 2;  // of optical depth, a voxel
  std::call_once(foundSolid_, [&] {
    const BrickSlice& slice = volume_.slice();
    const auto solid = static_cast<float>(kSolid / edges().minCoeff());
    const bool any = std::ranges::any_of(slice.entries(), [&](const BrickSlice::Entry& entry) {
      const std::span<const float> values(slice.brick(entry.stored), BrickSlice::kVoxels);
      return std::ranges::any_of(values, [&](float value) { return value > solid; });
    });
    if (!any)
      return;
    const VoxelPlaces places = volume_.lightPlaces();
    const auto isSolid = [&](const Place& at) { return slice.value(at[0], at[1], at[2]) > solid; };
    const auto isOnSurface = [&](const Place& at) {
      const bool own = isSolid(at);
      for (int n = 0; n < 27; ++n) {
        if (isSolid({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1}) != own)
          return true;
      }
      return false;
    };
    std::vector<std::uint8_t> found(places.size());
    parallelRanges(places.size(), 4096, [&](std::size_t begin, std::size_t end) {
      VoxelPlaces::Reader at(places);
      for (std::size_t i = begin; i < end; ++i) found[i] = isOnSurface(at[i]) ? 1 : 0;
    });
    atSolid_.assign(found.begin(), found.end());
  });
  return atSolid_;
}

/// How much of a lamp's light arrives at each light point.
void VolumeLight::addShares(std::size_t lamp, const ArrivingLight& arriving) const {
  const auto places = volume_.lightPlaces();
  lampShares_[lamp].resize(places.size());
  const bool fan =
      fanned(LightFan(volume_.slice(), places), lighting_.lamps[lamp], lampShares_[lamp]);
  const std::vector<bool> own = fan ? atSolid() : std::vector<bool>(places.size(), true);
  parallelRanges(places.size(), kLightGrain, [&](std::size_t begin, std::size_t end) {
    const std::span<float> shares(&lampShares_[lamp][begin], end - begin);
    std::vector<Vec3> points;
    std::vector<std::size_t> alone;  // with rays of their own
    std::vector<Segment> segments;
    VoxelPlaces::Reader at(places);
    for (std::size_t i = begin; i < end; ++i) {
      points.push_back(placeOf(at[i]));
      if (own.empty() || !own[i])
        continue;
      alone.push_back(i - begin);
      segments.push_back(lighting_.lamps[lamp].towards(points.back()));
    }
    if (!alone.empty()) {
      std::vector<float> exact(alone.size());
      transmittances(volume_, lighting_.place, segments, exact);
      for (std::size_t k = 0; k < exact.size(); ++k) shares[alone[k]] = exact[k];
    }
    arriving.takeFrom(lamp, points, shares);
  });
}

std::shared_ptr<const VolumeLight> VolumeLight::withLamps(
    std::span<const Lamp> lamps, std::span<const AnyMedium> between) const {
  const std::lock_guard lock(guard_);
  const std::size_t own = lighting_.lamps.size();
  const auto same = [&] {
    const auto had = std::span(inMore_->lighting_.lamps).subspan(own);
    return std::ranges::equal(had, lamps, [](const Lamp& a, const Lamp& b) {
      return a.position == b.position && (a.intensity == b.intensity).all() &&
             a.radius == b.radius && a.kind == b.kind && a.direction == b.direction;
    });
  };
  if (inMore_ && between.empty() && same())
    return inMore_;
  gather();
  auto more = std::make_shared<VolumeLight>(volume_, lighting_);
  more->lighting_.lamps.insert(more->lighting_.lamps.end(), lamps.begin(), lamps.end());
  more->between_.assign(between.begin(), between.end());
  std::call_once(more->gathered_, [&] {
    more->lampShares_ = lampShares_, more->even_ = even_;
    more->lampShares_.resize(more->lighting_.lamps.size());
    more->findSpreads();
    const ArrivingLight arriving(more->illumination(), bounds());
    for (std::size_t l = own; l < more->lampShares_.size(); ++l) more->addShares(l, arriving);
    std::call_once(more->beside_, [&] { more->atSurfaces_ = atSurfaces(); });
    if (between.empty())
      return;
    std::vector<Vec3> points;
    const VoxelPlaces places = volume_.lightPlaces();
    VoxelPlaces::Reader at(places);
    for (std::size_t i = 0; i < places.size(); ++i) points.push_back(placeOf(at[i]));
    for (std::size_t l = 0; l < own; ++l)  // surfaces have taken from them
      arriving.takeFrom(l, points, more->lampShares_[l], false);
  });
  if (between.empty())
    inMore_ = more;
  return more;
}

void VolumeLight::gather() const {
  std::call_once(gathered_, [&] {
    if (!(lighting_.albedo.maxCoeff() > 0))
      return;
    lampShares_.resize(lighting_.lamps.size());
    findSpreads();
    const ArrivingLight arriving(illumination(), bounds());
    for (std::size_t l = 0; l < lighting_.lamps.size(); ++l) addShares(l, arriving);
    if (lighting_.surrounding.maxCoeff() > 0)
      even_.push_back(sky());
    if (const std::vector<Lamp> lamps = fires(); !lamps.empty()) {
      auto lattice = std::make_shared<Lattice>(volume_.slice(), volume_.lightPlaces(), kFireStep);
      addRays(lamps, *lattice);
      even_.push_back(std::move(lattice));
    }
  });
}

/// Of a voxel in the world: half of its edges [m].
Mat3 VolumeLight::halfVoxel() const {
  const BrickSlice& slice = volume_.slice();
  const Vec3 own = slice.bounds().size().cwiseQuotient(Vec3(slice.x(), slice.y(), slice.z()));
  return lighting_.place.linear() * Vec3(0.5 * own).asDiagonal();
}

/// Their lengths [m].
Vec3 VolumeLight::edges() const {
  const Mat3 half = halfVoxel();
  return {2 * half.col(0).norm(), 2 * half.col(1).norm(), 2 * half.col(2).norm()};
}

/// In the world.
Box3 VolumeLight::bounds() const {
  return lighting_.place.isIdentity() ? volume_.bounds() : lighting_.place.around(volume_.bounds());
}

/// The same.
AnyMedium VolumeLight::medium() const {
  AnyMedium medium(volume_.absorption());
  if (lighting_.place.isIdentity())
    return medium;
  return AnyMedium(AffineMedium(std::move(medium), lighting_.place));
}

Illumination VolumeLight::illumination() const {
  return {.lamps = lighting_.lamps,
          .blocks = blocksOf(lighting_.surfaces),
          .between = between_,
          .multiple = lighting_.multiple};
}

/// What lamps, surroundings and its own fire send is scattered on from where it is scattered first.
const DiffuseLight* VolumeLight::again() const {
  std::call_once(scattered_, [&] {
    if (!lighting_.multiple || !(lighting_.albedo.maxCoeff() > 0))
      return;
    Illumination light = illumination();
    for (Lamp lamp : lighting_.firstSky ? skyOfCube() : skyOf(kFewSkyWays)) {
      lamp.intensity *= lighting_.surrounding;
      if (lamp.intensity.maxCoeff() > 0)
        light.lamps.push_back(lamp);
    }
    const std::vector<Lamp> own = fires();
    light.lamps.insert(light.lamps.end(), own.begin(), own.end());
    Rgb albedo = lighting_.albedo;
    if (!lighting_.colors.empty()) {
      Rgb sum = Rgb::Zero();
      for (const Rgb& color : lighting_.colors) sum += color;
      albedo *= sum / static_cast<double>(lighting_.colors.size());
    }
    const AnyMedium whole = medium();
    again_ = light.again(whole, whole.bounds(), {albedo, lighting_.asymmetry});
  });
  return again_.get();
}

namespace {

/// Of a lamp's light at a point, per unit of scattering.
/// @param way  in which it is scattered; null: evenly
/// @param share  of the light that arrives
/// @param on  of that which was scattered forwards on its way
Rgb scatteredTo(const Lamp& lamp, const Vec3& point, const Vec3* way, double share, double on,
                const Scattering& scattering) {
  constexpr double kEven = 1 / (4 * std::numbers::pi);
  const bool even = !way || scattering.asymmetry == 0;
  const auto phased = [&](double cosine) {
    if (even)
      return (share + on) * kEven;
    const double once = share * henyeyGreenstein(scattering.asymmetry, cosine);
    return on > 0 ? once + on * henyeyGreenstein(scattering.forward(), cosine) : once;
  };
  if (lamp.kind == Lamp::Kind::kSun)
    return phased(even ? 0 : lamp.direction.dot(*way)) * lamp.intensity;
  const Vec3 travels = point - lamp.position;
  const double distance = travels.norm();
  const double arrives = phased(!even && distance > 0 ? travels.dot(*way) / distance : 0.0);
  const double reach = std::max(distance, lamp.radius);
  const bool everywhere = lamp.coneCosine <= -1 && !(lamp.edge > 0);
  const double cone = everywhere ? 1 : lamp.coneShare(point);
  return arrives * cone / (reach * reach) * lamp.intensity;
}

constexpr double kNearLamp = 2.5;    // of a part's diagonal from it: light changes within the part
constexpr int kLampHalvings = 4;     // of a voxel beside a lamp
constexpr double kMeanReach = 0.36;  // where 1 / r2 is its mean in a cube of edge 1 around r = 0

/// The mean of at(point, radius) in a parallelepiped, for light that is nowhere stronger than at a
/// radius from a lamp.
/// @param half  of its edges
template <class At>
Rgb meanAround(const Vec3& lamp, const Vec3& centre, const Mat3& half, int halvings, At&& at) {
  const double diagonal = 2 * half.norm();
  if (halvings == 0 || (centre - lamp).norm() > kNearLamp * diagonal)
    return at(centre, kMeanReach * std::cbrt(8 * std::abs(half.determinant())));
  const Mat3 quarter = 0.5 * half;
  Rgb sum = Rgb::Zero();
  for (int i = 0; i < 8; ++i) {
    const Vec3 aside(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    sum += meanAround(lamp, centre + quarter * aside, quarter, halvings - 1, at);
  }
  return sum / 8;
}

/// From a point to the eye.
Vec3 wayTo(const VolumeView& view, const Vec3& point) {
  return view.parallel ? Vec3(-view.at) : Vec3((view.at - point).normalized());
}

}  // namespace

/// What arrives of all lamps' light at a place, per unit of scattering.
/// @param shareOf  of a lamp's light: 0..1
/// @param again  what was scattered forwards on its way arrives, too
template <class ShareOf>
Rgb VolumeLight::ofLamps(const Place& place, const std::optional<View>& view, bool again,
                         ShareOf&& shareOf) const {
  const Scattering scattering{lighting_.albedo, lighting_.asymmetry};
  const Vec3 point = placeOf(place);
  const Vec3 way = view ? wayTo(*view, point) : Vec3::Zero();
  Rgb sum = Rgb::Zero();
  for (std::size_t l = 0; l < lampShares_.size(); ++l) {
    const float share = shareOf(lampShares_[l]);
    if (share == 0)
      continue;
    const auto sent = [&](const Lamp& lamp, const Vec3& from) {
      return scatteredTo(lamp, from, view ? &way : nullptr, share,
                         again ? scattering.goesOn(share) : 0, scattering);
    };
    const Lamp& lamp = lighting_.lamps[l];
    if (spreads_[l] == 0 || (point - lamp.position).squaredNorm() > spreads_[l]) {
      sum += sent(lamp, point);
      continue;
    }
    Lamp larger = lamp;
    sum += meanAround(lamp.position, point, halfVoxel(), kLampHalvings,
                      [&](const Vec3& from, double spread) {
                        larger.radius = std::max(lamp.radius, spread);
                        return sent(larger, from);
                      });
  }
  return sum;
}

/// Lamps in the volume that are smaller than a voxel: there the light at a voxel is the mean in it,
/// which does not depend on where in it the lamp is.
void VolumeLight::findSpreads() const {
  const double diagonal = 2 * halfVoxel().norm();
  for (const Lamp& lamp : lighting_.lamps) {
    const bool isSmall = lamp.kind == Lamp::Kind::kSpot && lamp.radius < 0.5 * diagonal &&
                         volume_.bounds().contains(lighting_.place.toOwn(lamp.position));
    const double near = isSmall ? kNearLamp * diagonal : 0;
    spreads_.push_back(near * near);
  }
}

const std::shared_ptr<const LightAtSurfaces>& VolumeLight::atSurfaces() const {
  std::call_once(beside_, [&] {
    if (lighting_.surfaces.empty() || !(lighting_.albedo.maxCoeff() > 0))
      return;
    auto found =
        std::make_shared<const LightAtSurfaces>(volume_, lighting_.place, lighting_.surfaces);
    if (!found->empty())
      atSurfaces_ = std::move(found);
  });
  return atSurfaces_;
}

/// At each light point.
std::vector<VoxelLight> VolumeLight::scattered(const std::optional<View>& view) const {
  const DiffuseLight* const again = this->again();
  const auto places = volume_.lightPlaces();
  std::vector<VoxelLight> light(places.size());
  parallelRanges(places.size(), 4096, [&](std::size_t begin, std::size_t end) {
    std::vector<Lattice::Reader> even;
    for (const auto& lattice : even_) even.emplace_back(*lattice);
    VoxelPlaces::Reader at(places);
    for (std::size_t i = begin; i < end; ++i) {
      const Place place = at[i];
      Rgb sum = Rgb::Zero();
      for (Lattice::Reader& lattice : even) sum += lattice.at(place, i);
      const Vec3 point = placeOf(place);
      sum += ofLamps(place, view, again != nullptr,
                     [&](const std::vector<float>& shares) { return shares[i]; });
      if (again)
        sum += view ? again->towards(point, wayTo(*view, point)) : again->at(point);
      sum *= lighting_.albedo;
      if (!lighting_.colors.empty())
        sum *= lighting_.colors[i];
      light[i] = sum.cast<float>();
    }
  });
  return light;
}

/// Interpolated through surfaces.
ShadedVoxels VolumeLight::shaded(const std::optional<View>& view) const {
  gather();
  if (lampShares_.empty() && even_.empty() && !again())
    return volume_.drawn();
  return volume_.withMeansOf(scattered(view), edges());
}

/// Points that a view does not see take the light of those before the surface.
void VolumeLight::hide(const View& view, std::vector<VoxelLight>& light) const {
  const bool again = this->again() != nullptr;
  const std::vector<LightAtSurfaces::Hidden> hidden = atSurfaces()->hiddenFrom(view);
  parallelRanges(hidden.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t h = begin; h < end; ++h) {
      const LightAtSurfaces::Hidden& one = hidden[h];
      const auto i = static_cast<std::size_t>(one.point.number);
      const auto own = [&](const std::vector<float>& shares) { return shares[i]; };
      const auto before = [&](const std::vector<float>& shares) {
        float sum = 0;
        for (const LightAtSurfaces::Seen& seen : one.seen)
          sum += seen.weight * shares[static_cast<std::size_t>(seen.number)];
        return sum;
      };
      Rgb change = ofLamps(one.point.place, view, again, before) -
                   ofLamps(one.point.place, view, again, own);
      change *= lighting_.albedo;
      if (!lighting_.colors.empty())
        change *= lighting_.colors[i];
      light[i] = (light[i] + change.cast<float>()).max(0);
    }
  });
}

ShadedVoxels VolumeLight::seenFrom(const View& view) const {
  const std::lock_guard lock(guard_);
  gather();
  const bool hides = !lampShares_.empty() && atSurfaces();
  const bool even = lighting_.asymmetry == 0;  // the same light towards all views
  if (last_ &&
      ((even && !hides) || (lastView_->at == view.at && lastView_->parallel == view.parallel)))
    return *last_;
  lastView_ = view;
  if (!hides) {
    last_ = shaded(view);
    return *last_;
  }
  if (!even || unhidden_.empty())
    unhidden_ = scattered(view);
  std::vector<VoxelLight> light = even ? unhidden_ : std::exchange(unhidden_, {});
  hide(view, light);
  last_ = volume_.withMeansOf(std::move(light), edges());
  return *last_;
}

std::uint64_t VolumeLight::memoryBytes() const {
  const BrickSlice& slice = volume_.slice();
  const std::uint64_t points = std::max<std::uint64_t>(volume_.lightPlaces().size(), 1);
  // Corners are in up to eight bricks: of the values with light, and of the values alone.
  const auto channels = static_cast<std::uint64_t>(slice.channels());
  const std::uint64_t corners = 3 * (2 * channels + 1) * sizeof(float) / 2;
  // What does not depend on a view is kept where surfaces change the rest of it.
  const std::uint64_t kept = lighting_.surfaces.empty() ? 0 : sizeof(VoxelLight);
  return slice.bytes() + volume_.drawnBytes() +
         points *
             (corners + sizeof(VoxelLight) / 2 + kept + lighting_.lamps.size() * sizeof(float));
}

ShadedVoxels VolumeLight::seen() const {
  return shaded(std::nullopt);
}

}  // namespace volute
