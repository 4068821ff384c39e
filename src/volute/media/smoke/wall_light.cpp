// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/wall_light.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>

#include "volute/base/mask.hpp"
#include "volute/base/parallel.hpp"
#include "volute/lighting/vertex_light.hpp"

namespace volute {
namespace {

constexpr double kTolerance = 5e-4;  ///< at three points of a patch, of the light without smoke
constexpr double kFewPoints = 12;    ///< on a patch: to walk from each costs no more
constexpr std::size_t kMaxKept = std::size_t{1} << 23;  ///< walks of a view's points, 64 MiB
constexpr double kInset = 1e-3;  ///< of a face: ways from its rim itself would go along other faces

bool haveTheSameRays(const Camera& a, const Camera& b) {
  return a.width() == b.width() && a.height() == b.height() && a.eye() == b.eye() &&
         a.right() == b.right() && a.down() == b.down() && a.forward() == b.forward() &&
         a.isOrthographic() == b.isOrthographic() && a.pixelSize() == b.pixelSize() &&
         a.pixelWidth() == b.pixelWidth() && a.principalPoint() == b.principalPoint() &&
         a.distortion() == b.distortion() &&
         (a.isOrthographic() || a.intrinsics() == b.intrinsics());
}

/// What a face sees of a lamp: the cone from it, or the prism, by the planes of its sides.
class Beam {
 public:
  Beam(const Lamp& lamp, const Vec3 (&corners)[3], const Vec3& inwards, double above)
      : base_(inwards), height_(inwards.dot(corners[0]) + above) {
    const Vec3 middle = (corners[0] + corners[1] + corners[2]) / 3;
    for (int i = 0; i < 3; ++i) {
      const Vec3& from = corners[i];
      const Vec3 edge = corners[(i + 1) % 3] - from;
      const Vec3 light =
          lamp.kind == Lamp::Kind::kSun ? Vec3(-lamp.direction) : Vec3(lamp.position - from);
      sides_[i] = edge.cross(light);
      if (sides_[i].dot(middle - from) < 0)
        sides_[i] = -sides_[i];
      offsets_[i] = sides_[i].dot(from);
    }
  }

  /// False where a box is surely outside.
  bool mayMeet(const Box3& box) const {
    const auto highest = [&](const Vec3& along) {
      double sum = 0;
      for (int axis = 0; axis < 3; ++axis)
        sum += along[axis] * (along[axis] > 0 ? box.max[axis] : box.min[axis]);
      return sum;
    };
    for (int i = 0; i < 3; ++i) {
      if (highest(sides_[i]) < offsets_[i])
        return false;
    }
    return highest(base_) > height_;
  }

  /// Whether some of a straight line is inside.
  bool meets(const Vec3& from, const Vec3& to) const {
    double begin = 0, end = 1;  // of the way between its ends
    const auto clip = [&](double first, double last) {
      if (first < 0 && last < 0)
        end = -1;
      else if (first < 0)
        begin = std::max(begin, first / (first - last));
      else if (last < 0)
        end = std::min(end, first / (first - last));
    };
    for (int i = 0; i < 3; ++i)
      clip(sides_[i].dot(from) - offsets_[i], sides_[i].dot(to) - offsets_[i]);
    clip(base_.dot(from) - height_, base_.dot(to) - height_);
    return begin <= end;
  }

 private:
  Vec3 sides_[3];
  double offsets_[3];
  Vec3 base_;
  double height_;
};

/// The edges at which a boundary turns away from a lamp, in a tree of boxes. All shadows begin
/// there: between them a face is lit or dark as a whole.
class Silhouettes {
 public:
  Silhouettes(const TetMesh& mesh, const MeshWalls& walls, const Lamp& lamp)
      : points_(mesh.vertices()) {
    std::vector<signed char> towards(walls.faces().size());
    for (std::size_t f = 0; f < towards.size(); ++f) {
      const WallFace& face = walls.faces()[f];
      const Segment way = lamp.towards(points_[face.vertices[0]]);
      const double cosine = way.empty() ? 0 : face.inwards.dot(way.direction);
      towards[f] = static_cast<signed char>(cosine > kAlong ? 1 : cosine < -kAlong ? -1 : 0);
    }
    for (const MeshWalls::Edge& edge : walls.edges()) {
      const bool turns = edge.second < 0 || towards[edge.first] * towards[edge.second] <= 0;
      if (turns && !isHollow(walls, edge))
        edges_.push_back({edge.from, edge.to});
    }
    if (!edges_.empty())
      split(0, edges_.size());
  }

  bool anyIn(const Beam& beam) const { return !edges_.empty() && anyIn(beam, 0); }

 private:
  static constexpr double kAlong = 1e-9;  ///< of the cosine: neither towards a lamp nor away
  static constexpr std::size_t kLeaf = 4;

  struct Ends {
    std::int32_t from, to;
  };

  /// As between a wall and its floor: light that passes there is past nothing.
  bool isHollow(const MeshWalls& walls, const MeshWalls::Edge& edge) const {
    if (edge.second < 0)
      return false;
    const WallFace& wall = walls.faces()[static_cast<std::size_t>(edge.first)];
    for (const std::int32_t v : walls.faces()[static_cast<std::size_t>(edge.second)].vertices) {
      if (v != edge.from && v != edge.to)
        return wall.inwards.dot(points_[v] - points_[edge.from]) > 0;
    }
    return false;
  }

  struct Node {
    Box3 box;
    std::size_t begin = 0, end = 0;
    std::size_t right = 0;  ///< 0: a leaf; the left one follows
  };

  std::size_t split(std::size_t begin, std::size_t end) {
    const std::size_t at = nodes_.size();
    nodes_.push_back({{}, begin, end, 0});
    Box3 box;
    for (std::size_t i = begin; i < end; ++i) {
      box.extend(points_[edges_[i].from]);
      box.extend(points_[edges_[i].to]);
    }
    nodes_[at].box = box;
    if (end - begin <= kLeaf)
      return at;
    int axis = 0;
    box.size().maxCoeff(&axis);
    const std::size_t middle = begin + (end - begin) / 2;
    std::ranges::nth_element(
        edges_.begin() + static_cast<std::ptrdiff_t>(begin),
        edges_.begin() + static_cast<std::ptrdiff_t>(middle),
        edges_.begin() + static_cast<std::ptrdiff_t>(end), {},
        [&](const Ends& edge) { return points_[edge.from][axis] + points_[edge.to][axis]; });
    split(begin, middle);
    const std::size_t right = split(middle, end);
    nodes_[at].right = right;
    return at;
  }

  bool anyIn(const Beam& beam, std::size_t at) const {
    const Node& node = nodes_[at];
    if (!beam.mayMeet(node.box))
      return false;
    if (node.right > 0)
      return anyIn(beam, at + 1) || anyIn(beam, node.right);
    return std::any_of(
        edges_.begin() + static_cast<std::ptrdiff_t>(node.begin),
        edges_.begin() + static_cast<std::ptrdiff_t>(node.end),
        [&](const Ends& edge) { return beam.meets(points_[edge.from], points_[edge.to]); });
  }

  std::span<const Vec3> points_;
  std::vector<Ends> edges_;
  std::vector<Node> nodes_;
};

/// A part of a face: a triangle, or four.
struct Patch {
  enum Kind : std::uint8_t { kDark, kSmooth, kWalked, kCut };

  Kind kind = kWalked;
  std::int32_t first = -1;  ///< of four patches: at each corner, and in the middle
  /// At both ends of the interval: at the corners, and between them: 01, 12, 20.
  std::array<float, 6> depths[2] = {};
};

/// One lamp's light on one face, cut for so many points.
struct FacePatches {
  double points = 0;           ///< a power of four
  std::vector<Patch> patches;  ///< the first is all of it
  /// The walks of a view's points, in their order.
  std::uint64_t view = 0;
  std::vector<std::array<float, 2>> walked{};
};

/// By how many points they are for.
using FaceSets = std::vector<FacePatches>;

using Shares3 = Vec3;  ///< a point of a triangle, by its corners

double parabola(const std::array<float, 6>& depths, const Shares3& p) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    sum += p[i] * (2 * p[i] - 1) * depths[i];
    sum += 4 * p[i] * p[(i + 1) % 3] * depths[3 + i];
  }
  return sum;
}

/// The share of light that comes through at a time between the ends of an interval: depths are
/// linear in time, as extinctions are.
double shareAt(double time, double first, double second) {
  return std::exp(-(first + time * (second - first)));
}

}  // namespace

struct WallLight::State {
  struct OfLamp {
    Silhouettes silhouettes;
    bool inside;  ///< it is in the mesh
    std::vector<FaceSets> faces;
  };

  std::once_flag begun;
  std::vector<OfLamp> lamps;
  std::array<std::mutex, 64> guards;  ///< of faces, by their number
  std::atomic<std::uint64_t> walks = 0;
  std::atomic<std::size_t> kept = 0;  ///< walks of views' points, of all faces

  void begin(const Request& request) {
    for (const Lamp& lamp : request.lamps) {
      const bool inside =
          lamp.kind == Lamp::Kind::kSpot && request.locator.find(lamp.position) >= 0;
      lamps.push_back({Silhouettes(request.locator.mesh(), request.walls, lamp), inside,
                       std::vector<FaceSets>(request.walls.faces().size())});
    }
  }
};

namespace {

/// Cuts a face until its patches are smooth, or have few points.
class FaceWalker {
 public:
  FaceWalker(const WallLight::Request& request, std::size_t lamp, bool inside, const WallFace& face)
      : request_(request), lamp_(request.lamps[lamp]), inside_(inside), face_(face) {
    for (int i = 0; i < 3; ++i) corners_[i] = request.locator.mesh().vertices()[face.vertices[i]];
  }

  /// From a point to the lamp, at both ends of the interval; infinity: dark.
  std::array<double, 2> depths(const Shares3& p) const {
    const Segment way = lamp_.towards(at(p));
    ++walks;
    if (!request_.later.empty())
      return lampDepthsAt(request_.locator, {request_.extinction, request_.later}, way, face_.tet,
                          inside_);
    const double share =
        lampShareAt(request_.locator, request_.extinction, way, face_.tet, inside_);
    return {-std::log(share), -std::log(share)};
  }

  void make(const Silhouettes& silhouettes, FacePatches& out) const {
    out.patches.assign(1, {});
    const Shares3 root[3] = {inset(Vec3::UnitX()), inset(Vec3::UnitY()), inset(Vec3::UnitZ())};
    cut(silhouettes, root, out.points, 0, out.patches);
  }

  /// The same point by the corners of the part of the face that patches cover.
  static Shares3 withinInset(const Shares3& p) {
    return (p.array() - kInset / 3).matrix() / (1 - kInset);
  }

  static Shares3 inset(const Shares3& p) {
    return (1 - kInset) * p + Shares3::Constant(kInset / 3);
  }

  mutable std::uint64_t walks = 0;

 private:
  Vec3 at(const Shares3& p) const {
    return p[0] * corners_[0] + p[1] * corners_[1] + p[2] * corners_[2];
  }

  void cut(const Silhouettes& silhouettes, const Shares3 (&corners)[3], double points,
           std::size_t into, std::vector<Patch>& patches) const {
    if (points < kFewPoints)
      return;
    const Shares3 between[3] = {0.5 * (corners[0] + corners[1]), 0.5 * (corners[1] + corners[2]),
                                0.5 * (corners[2] + corners[0])};
    const Vec3 places[3] = {at(corners[0]), at(corners[1]), at(corners[2])};
    const double above = 1e-9 * request_.locator.mesh().bounds().size().maxCoeff();
    if (!silhouettes.anyIn(Beam(lamp_, places, face_.inwards, above))) {
      const Patch patch = whole(corners, between);
      if (patch.kind != Patch::kCut) {
        patches[into] = patch;
        return;
      }
    }
    const auto first = patches.size();
    patches[into].kind = Patch::kCut;
    patches[into].first = static_cast<std::int32_t>(first);
    patches.resize(first + 4);
    const Shares3 parts[4][3] = {{corners[0], between[0], between[2]},
                                 {between[0], corners[1], between[1]},
                                 {between[2], between[1], corners[2]},
                                 {between[1], between[2], between[0]}};
    for (std::size_t i = 0; i < 4; ++i) cut(silhouettes, parts[i], points / 4, first + i, patches);
  }

  /// Of a part that is lit or dark as a whole.
  Patch whole(const Shares3 (&corners)[3], const Shares3 (&between)[3]) const {
    Patch patch;
    int dark = 0;
    for (std::size_t i = 0; i < 6; ++i) {
      const auto found = depths(i < 3 ? corners[i] : between[i - 3]);
      dark += std::isfinite(found[0]) && std::isfinite(found[1]) ? 0 : 1;
      for (std::size_t end = 0; end < 2; ++end)
        patch.depths[end][i] = static_cast<float>(found[end]);
    }
    patch.kind = dark == 6 ? Patch::kDark : dark > 0 ? Patch::kCut : Patch::kSmooth;
    for (int i = 0; i < 3 && patch.kind == Patch::kSmooth; ++i) {
      Shares3 local = Shares3::Constant(1 / 6.0);
      local[i] = 4 / 6.0;
      if (!isExact(patch, local,
                   depths(local[0] * corners[0] + local[1] * corners[1] + local[2] * corners[2])))
        patch.kind = Patch::kCut;
    }
    return patch;
  }

  /// At any time of the interval.
  bool isExact(const Patch& patch, const Shares3& local, const std::array<double, 2>& exact) const {
    const double first = parabola(patch.depths[0], local);
    const double second = parabola(patch.depths[1], local);
    const int last = request_.later.empty() ? 0 : kTimes;
    for (int i = 0; i <= last; ++i) {
      const double time = static_cast<double>(i) / kTimes;
      const double off = shareAt(time, first, second) - shareAt(time, exact[0], exact[1]);
      if (!(std::abs(off) <= kTolerance))
        return false;
    }
    return true;
  }

  static constexpr int kTimes = 4;  ///< of an interval, at which patches are checked

  const WallLight::Request& request_;
  const Lamp& lamp_;
  bool inside_;
  const WallFace& face_;
  Vec3 corners_[3];
};

/// The patch that a point lies on, and the point by its corners.
const Patch& find(const std::vector<Patch>& patches, Shares3& p) {
  const Patch* patch = &patches.front();
  while (patch->kind == Patch::kCut) {
    int corner = 3;
    for (int i = 0; i < 3; ++i) {
      if (p[i] >= 0.5)
        corner = i;
    }
    if (corner < 3) {
      p *= 2;
      p[corner] -= 1;
    } else {
      p = Shares3::Constant(1) - 2 * p;
    }
    patch = &patches[static_cast<std::size_t>(patch->first + corner)];
  }
  return *patch;
}

}  // namespace

Result<std::shared_ptr<const MeshWalls>> MeshWalls::make(const TetMesh& mesh) {
  auto walls = std::make_shared<MeshWalls>();
  const auto points = mesh.vertices();
  std::vector<Triangle> triangles;
  std::vector<Edge> halves;
  for (const std::int32_t f : mesh.boundary()) {
    const TetFace& face = mesh.faces()[f];
    auto [a, b, c] = face.vertices;
    Vec3 normal = (points[b] - points[a]).cross(points[c] - points[a]);
    const Vec3& inner = points[mesh.tets()[face.first / 4][face.first % 4]];
    if (normal.dot(inner - points[a]) < 0) {
      std::swap(b, c);
      normal = -normal;
    }
    const auto number = static_cast<std::int32_t>(walls->faces_.size());
    walls->faces_.push_back({{a, b, c}, face.first / 4, normal.normalized()});
    triangles.push_back({{points[a], points[b], points[c]}});
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
      halves.push_back({std::min(from, to), std::max(from, to), number, -1});
  }
  const auto ends = [](const Edge& edge) { return std::pair(edge.from, edge.to); };
  std::ranges::sort(halves, {}, ends);
  for (std::size_t i = 0; i < halves.size();) {
    std::size_t next = i + 1;
    while (next < halves.size() && ends(halves[next]) == ends(halves[i])) ++next;
    Edge edge = halves[i];
    if (next - i == 2)
      edge.second = halves[i + 1].first;
    walls->edges_.push_back(edge);
    i = next;
  }
  VOLUTE_ASSIGN(walls->scene_, TriangleScene::build(std::move(triangles)));
  return std::shared_ptr<const MeshWalls>(std::move(walls));
}

void MeshWalls::nearest(std::span<const Segment> segments, std::span<Hit> hits) const {
  scene_.nearest(segments, hits);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    // From outside, walls do not hide what they enclose.
    Segment rest = segments[i];
    while (hits[i].found() && !(faces_[hits[i].triangle].inwards.dot(rest.direction) < 0)) {
      rest.begin = hits[i].distance;
      scene_.nearest({&rest, 1}, {&hits[i], 1});
    }
  }
}

void MeshWalls::look(const Camera& camera, std::span<const std::uint8_t> only,
                     const std::function<void(std::size_t, const Hit&)>& found) const {
  const auto width = static_cast<std::size_t>(camera.width());
  parallelFor(static_cast<std::size_t>(camera.height()), [&](std::size_t y) {
    std::vector<Segment> rays;
    std::vector<std::size_t> pixels;
    forEachSet(only, y * width, (y + 1) * width, [&](std::size_t pixel) {
      pixels.push_back(pixel);
      rays.push_back(
          camera.ray(static_cast<double>(pixel - y * width) + 0.5, static_cast<double>(y) + 0.5));
    });
    if (pixels.empty())
      return;
    std::vector<Hit> hits(rays.size());
    nearest(rays, hits);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (hits[i].found())
        found(pixels[i], hits[i]);
    }
  });
}

std::shared_ptr<const WallView> MeshWalls::seenFrom(const Camera& camera) const {
  bool again = false;
  {
    const std::lock_guard lock(guard_);
    again = lastCamera_ && haveTheSameRays(*lastCamera_, camera);
    if (again && lastView_)
      return lastView_;
  }
  const std::size_t pixels =
      static_cast<std::size_t>(camera.width()) * static_cast<std::size_t>(camera.height());
  auto view = std::make_shared<WallView>();
  view->depth.assign(pixels, std::numeric_limits<float>::infinity());
  view->face.assign(pixels, WallView::kNone);
  look(camera, {}, [&](std::size_t pixel, const Hit& hit) {
    view->depth[pixel] = static_cast<float>(hit.distance);
    view->face[pixel] = hit.triangle;
  });
  static std::atomic<std::uint64_t> views = 0;
  if (again)
    view->number = ++views;
  const std::lock_guard lock(guard_);
  lastCamera_ = camera;
  lastView_ = again ? view : nullptr;
  return view;
}

WallLight::WallLight() : state_(std::make_unique<State>()) {}

WallLight::~WallLight() = default;

std::uint64_t WallLight::walks() const {
  return state_->walks;
}

void WallLight::shares(const Request& request, std::size_t lamp, std::size_t face,
                       std::span<const Vec3> points, std::span<double> shares) {
  std::call_once(state_->begun, [&] { state_->begin(request); });
  State::OfLamp& light = state_->lamps[lamp];
  const FaceWalker walker(request, lamp, light.inside, request.walls.faces()[face]);
  const std::lock_guard lock(state_->guards[face % state_->guards.size()]);
  FaceSets& sets = light.faces[face];
  const double count = std::pow(4.0, std::ceil(std::log2(static_cast<double>(points.size())) / 2));
  auto set = std::ranges::find(sets, count, &FacePatches::points);
  if (set == sets.end()) {
    sets.push_back({count, {}});
    set = std::prev(sets.end());
    walker.make(light.silhouettes, *set);
  }
  FacePatches& known = *set;
  if (request.view != 0 && known.view != request.view) {
    known.view = request.view;
    state_->kept -= known.walked.size();
    std::vector<std::array<float, 2>>().swap(known.walked);
  }
  const bool keeps = request.view != 0;
  std::size_t walked = 0;
  const auto walk = [&](const Vec3& point) {
    const std::size_t place = walked++;
    if (keeps && place < known.walked.size())
      return known.walked[place];
    const auto found = walker.depths(point);
    const std::array<float, 2> depths{static_cast<float>(found[0]), static_cast<float>(found[1])};
    if (keeps && place == known.walked.size() && state_->kept < kMaxKept) {
      known.walked.push_back(depths);
      ++state_->kept;
    }
    return depths;
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    Shares3 local = FaceWalker::withinInset(points[i]);
    const Patch& patch = find(known.patches, local);
    if (patch.kind == Patch::kDark) {
      shares[i] = 0;
    } else if (patch.kind == Patch::kWalked) {
      const auto [first, second] = walk(points[i]);
      shares[i] = std::isfinite(first) ? shareAt(request.time, first, second) : 0;
    } else {
      const double first = parabola(patch.depths[0], local);
      shares[i] = request.later.empty()
                      ? std::exp(-first)
                      : shareAt(request.time, first, parabola(patch.depths[1], local));
    }
  }
  state_->walks += walker.walks;
}

}  // namespace volute
