// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/sun_tree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "volute/math/vec.hpp"

namespace volute {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kSunLeaf = 24;  ///< so few triangles are not shared out any more
constexpr double kMaxCopies = 8;        ///< of a triangle, on average: long ones only multiply
constexpr double kMargin = 1e-9;        ///< of a square's side, by which triangles may miss it
constexpr double kEdgeOn = 1e-14;       ///< sine of an angle
constexpr double kSteep = 1e5;          ///< a slope
constexpr std::uint32_t kNone = 0xffffffffu;
constexpr int kPlotDepth = 6;  ///< of the plots' squares, where there are many triangles
constexpr std::size_t kFewTriangles = 4096;

/// Across a far light: x, y, and the height towards it.
struct FlatTriangle {
  Vec3 corner[3];  ///< anticlockwise
  double top, bottom;
  double left, right, low, high;  ///< of the corners' x and y
  Vec2 edge[3];                   ///< from each corner to the next
  double spread[3];               ///< |x| + |y| of the edges
  Vec2 slope;                     ///< of the height
  std::uint32_t number;
  /// Across each edge, in the same plot; kNone at a border or a fold, and where more than two meet.
  std::uint32_t neighbour[3];

  double at(const Vec2& p) const { return corner[0].z() + slope.dot(p - corner[0].head<2>()); }

  /// Twice the area of the triangle that the edge from a corner makes with a point.
  double side(int i, const Vec2& p) const {
    return edge[i].x() * (p.y() - corner[i].y()) - edge[i].y() * (p.x() - corner[i].x());
  }
};

/// How a triangle lies to a square.
struct Cover {
  bool meets = false;
  bool whole = false;              ///< the square is within the triangle
  bool middle = false;             ///< the square's middle is
  double lowest = 0, highest = 0;  ///< of its height where both are
};

template <class Square>
Cover coverOf(const FlatTriangle& triangle, const Square& square) {
  const double reach = square.half * (1 + 2 * kMargin);
  if (triangle.left > square.x + reach || triangle.right < square.x - reach ||
      triangle.low > square.y + reach || triangle.high < square.y - reach)
    return {};
  Cover cover{true, true, true, triangle.bottom, triangle.top};
  const Vec2 middle(square.x, square.y);
  for (int edge = 0; edge < 3; ++edge) {
    const double side = triangle.side(edge, middle), spread = triangle.spread[edge];
    if (side < -spread * reach)
      return {};
    cover.whole &= side >= spread * square.half;
    cover.middle &= side >= 0;
  }
  const double height = triangle.at(middle), change = triangle.slope.cwiseAbs().sum() * reach;
  cover.lowest = std::max(cover.lowest, height - change);
  cover.highest = std::min(cover.highest, height + change);
  return cover;
}

/// coverOf() of the four quarters of a square.
template <class Square>
std::array<Cover, 4> coversOfQuarters(const FlatTriangle& triangle, const Square& square) {
  const double quarter = 0.5 * square.half, reach = quarter * (1 + 2 * kMargin);
  const Vec2 middle(square.x, square.y);
  double side[3], byX[3], byY[3];  // in the middle, and their changes towards a quarter's
  for (int edge = 0; edge < 3; ++edge) {
    side[edge] = triangle.side(edge, middle);
    byX[edge] = -quarter * triangle.edge[edge].y();
    byY[edge] = quarter * triangle.edge[edge].x();
  }
  const double height = triangle.at(middle), change = triangle.slope.cwiseAbs().sum() * reach;
  std::array<Cover, 4> covers;
  for (int i = 0; i < 4; ++i) {
    const double right = i & 1 ? 1 : -1, up = i & 2 ? 1 : -1;
    const double x = square.x + right * quarter, y = square.y + up * quarter;
    if (triangle.left > x + reach || triangle.right < x - reach || triangle.low > y + reach ||
        triangle.high < y - reach)
      continue;
    Cover cover{true, true, true, triangle.bottom, triangle.top};
    for (int edge = 0; edge < 3; ++edge) {
      const double there = side[edge] + right * byX[edge] + up * byY[edge];
      cover.meets &= there >= -triangle.spread[edge] * reach;
      cover.whole &= there >= triangle.spread[edge] * quarter;
      cover.middle &= there >= 0;
    }
    const double its = height + quarter * (right * triangle.slope.x() + up * triangle.slope.y());
    cover.lowest = std::max(cover.lowest, its - change);
    cover.highest = std::min(cover.highest, its + change);
    covers[i] = cover;
  }
  return covers;
}

}  // namespace

class SunTreeBuilder {
 public:
  using Square = SunTree::Square;
  using Node = SunTree::Node;

  SunTreeBuilder(SunTree::Plot& plot, std::span<const Triangle> triangles, const Mat3& axes)
      : plot_(plot) {
    std::vector<Entry> entries;
    flat_.reserve(plot.triangles.size());
    for (const std::uint32_t number : plot.triangles) {
      FlatTriangle flat;
      if (!flatten(triangles[number], number, axes, flat))
        continue;
      const Cover cover = coverOf(flat, plot.square);
      if (!cover.meets)
        continue;
      entries.push_back({static_cast<std::uint32_t>(flat_.size()), cover});
      flat_.push_back(flat);
      plot.faces.push_back(faceOf(flat, Vec2(plot.square.x, plot.square.y)));
    }
    plot_.triangles = {};
    findNeighbours();
    marks_.resize(flat_.size());
    plot_.nodes.emplace_back();
    grow(0, plot.square, plot.depth, 1, std::move(entries));
  }

  /// The part above the plots.
  static void share(SunTree& tree) {
    const auto triangles = tree.triangles_;
    std::vector<Box3> boxes(triangles.size());  // across the light
    Box3 bounds;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (const Vec3& corner : triangles[i].corners) boxes[i].extend(tree.axes_ * corner);
      bounds.extend(boxes[i]);
    }
    const double half = 0.5 * bounds.size().head<2>().maxCoeff() * (1 + 1e-6);
    if (!(half > 0))
      return;
    tree.square_ = {bounds.centre().x(), bounds.centre().y(), half};
    const int depth = plotDepth(boxes, half);
    const int across = 1 << depth;
    tree.plots_ = std::make_unique<SunTree::Plot[]>(static_cast<std::size_t>(across) * across);
    std::vector<double> light(static_cast<std::size_t>(across) * across, -kEndless);
    const double step = 2 * half / across;
    const auto place = [&](double value, double centre) {
      const double steps = std::floor((value - centre + half) / step);
      return std::clamp(static_cast<int>(steps), 0, across - 1);
    };
    const double margin = kMargin * half;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const Box3& box = boxes[i];
      const int x0 = place(box.min.x() - margin, tree.square_.x);
      const int x1 = place(box.max.x() + margin, tree.square_.x);
      const int y0 = place(box.min.y() - margin, tree.square_.y);
      const int y1 = place(box.max.y() + margin, tree.square_.y);
      for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
          const std::size_t plot = static_cast<std::size_t>(y) * across + x;
          tree.plots_[plot].triangles.push_back(static_cast<std::uint32_t>(i));
          light[plot] = std::max(light[plot], box.max.z());
        }
      }
    }
    tree.top_.emplace_back();
    lay(tree, light, 0, tree.square_, depth, across, 0, 0);
  }

 private:
  struct Entry {
    std::uint32_t flat;
    Cover cover;
  };

  /// Of the plots' squares: one for each triangle or fewer, and few copies of long triangles.
  static int plotDepth(std::span<const Box3> boxes, double half) {
    if (boxes.size() <= kFewTriangles)
      return 0;
    int depth = kPlotDepth;
    while (depth > 0 && std::size_t{1} << (2 * depth) > boxes.size()) --depth;
    for (; depth > 0; --depth) {
      const double perPlot = (1 << depth) / (2 * half);
      double copies = 0;
      for (const Box3& box : boxes) {
        const Vec3 size = box.size();
        copies += (1 + size.x() * perPlot) * (1 + size.y() * perPlot);
      }
      if (copies <= kMaxCopies * static_cast<double>(boxes.size()))
        break;
    }
    return depth;
  }

  /// False for one that the light meets edge-on: it keeps nothing in the dark.
  static bool flatten(const Triangle& triangle, std::uint32_t number, const Mat3& axes,
                      FlatTriangle& flat) {
    for (int k = 0; k < 3; ++k) flat.corner[k] = axes * triangle.corners[k];
    const Vec3 b = flat.corner[1] - flat.corner[0], c = flat.corner[2] - flat.corner[0];
    const double area = b.x() * c.y() - b.y() * c.x();
    if (!(std::abs(area) > kEdgeOn * b.norm() * c.norm()))
      return false;
    flat.slope = Vec2(b.z() * c.y() - b.y() * c.z(), b.x() * c.z() - b.z() * c.x()) / area;
    if (area < 0)
      std::swap(flat.corner[1], flat.corner[2]);
    const Vec3 most = flat.corner[0].cwiseMax(flat.corner[1]).cwiseMax(flat.corner[2]);
    const Vec3 least = flat.corner[0].cwiseMin(flat.corner[1]).cwiseMin(flat.corner[2]);
    flat.left = least.x(), flat.right = most.x(), flat.low = least.y(), flat.high = most.y();
    flat.bottom = least.z(), flat.top = most.z();
    for (int i = 0; i < 3; ++i) {
      flat.edge[i] = (flat.corner[(i + 1) % 3] - flat.corner[i]).head<2>();
      flat.spread[i] = flat.edge[i].cwiseAbs().sum();
    }
    flat.number = number;
    return true;
  }

  static SunTree::Face faceOf(const FlatTriangle& flat, const Vec2& middle) {
    SunTree::Face face;
    for (int i = 0; i < 3; ++i) {
      const Vec2 a = flat.corner[i].head<2>(), b = flat.corner[(i + 1) % 3].head<2>();
      const Vec2 base = (a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()) ? a : b) - middle;
      face.x[i] = -flat.edge[i].y(), face.y[i] = flat.edge[i].x();
      face.rest[i] = flat.edge[i].y() * base.x() - flat.edge[i].x() * base.y();
    }
    face.x[3] = flat.slope.x(), face.y[3] = flat.slope.y();
    face.rest[3] = flat.at(middle);
    face.triangle = flat.number;
    face.edgeOn = flat.slope.cwiseAbs().maxCoeff() > kSteep;
    return face;
  }

  /// As float, no lower.
  static float above(double height) {
    const auto near = static_cast<float>(height);
    return near >= height ? near : std::nextafter(near, std::numeric_limits<float>::infinity());
  }

  /// The node of the squares from (x, y) on, `across` a side.
  static void lay(SunTree& tree, std::span<const double> light, std::uint32_t node,
                  const Square& square, int above, int across, int x, int y) {
    if (above == 0) {
      const int plots = static_cast<int>(std::lround(std::sqrt(static_cast<double>(light.size()))));
      const auto number = static_cast<std::uint32_t>(y * plots + x);
      tree.plots_[number].square = square;
      tree.plots_[number].depth = static_cast<int>(std::bit_width(light.size()) - 1) / 2;
      tree.top_[node] = {-kEndless, light[number], number, SunTree::kPlot};
      return;
    }
    const auto first = static_cast<std::uint32_t>(tree.top_.size());
    tree.top_.resize(first + 4);
    double most = -kEndless;
    for (int i = 0; i < 4; ++i) {
      lay(tree, light, first + i, square.child(i), above - 1, across / 2,
          x + (i & 1 ? across / 2 : 0), y + (i & 2 ? across / 2 : 0));
      most = std::max(most, tree.top_[first + i].light);
    }
    tree.top_[node] = {-kEndless, most, first, SunTree::kParent};
  }

  void grow(std::uint32_t node, const Square& square, int depth, double copies,
            std::vector<Entry> entries) {
    double dark = -kEndless, light = -kEndless;
    for (const Entry& entry : entries) {
      light = std::max(light, entry.cover.highest);
      if (entry.cover.whole)
        dark = std::max(dark, entry.cover.lowest);
    }
    std::erase_if(entries, [&](const Entry& entry) { return entry.cover.highest < dark; });
    if (entries.size() > kSunLeaf && depth + 1 < SunTree::kDeepest && copies < kMaxCopies) {
      std::array<std::vector<Entry>, 4> parts;
      std::size_t sum = 0;
      for (auto& part : parts) part.reserve(entries.size());
      for (const Entry& entry : entries) {
        const auto covers = coversOfQuarters(flat_[entry.flat], square);
        for (int i = 0; i < 4; ++i) {
          if (covers[i].meets)
            parts[i].push_back({entry.flat, covers[i]});
        }
      }
      for (const auto& part : parts) sum += part.size();
      const double more = copies * static_cast<double>(sum) / static_cast<double>(entries.size());
      entries = {};
      const auto first = static_cast<std::uint32_t>(plot_.nodes.size());
      plot_.nodes.resize(first + 4);
      double lowest = kEndless;
      for (int i = 0; i < 4; ++i) {
        grow(first + i, square.child(i), depth + 1, more, std::move(parts[i]));
        lowest = std::min(lowest, plot_.nodes[first + i].dark);
      }
      plot_.nodes[node] = {std::max(dark, lowest), light, first, SunTree::kParent};
      return;
    }
    dark = std::max(dark, coveredTogether(square, entries));
    const auto first = static_cast<std::uint32_t>(plot_.entries.size());
    for (const Entry& entry : entries) {
      // What lies below the dark changes nothing.
      if (entry.cover.highest >= dark)
        plot_.entries.push_back({above(entry.cover.highest), entry.flat});
    }
    std::sort(plot_.entries.begin() + first, plot_.entries.end(),
              [](const SunTree::Entry& a, const SunTree::Entry& b) { return a.top > b.top; });
    plot_.nodes[node] = {dark, light, first,
                         static_cast<std::uint32_t>(plot_.entries.size()) - first};
  }

  /// Triangles that go through an edge in opposite directions lie on its two sides.
  void findNeighbours() {
    struct Side {
      std::uint32_t flat = kNone, edge = 0;
    };

    struct Slot {
      const Vec3* a = nullptr;
      const Vec3* b = nullptr;
      Side sides[2];  // that go from a to b, and from b to a
      bool shared = false;
    };

    const std::size_t mask = std::bit_ceil(flat_.size() * 6) - 1;
    std::vector<Slot> slots(mask + 1);
    for (std::uint32_t i = 0; i < flat_.size(); ++i) {
      for (std::uint32_t edge = 0; edge < 3; ++edge) {
        const Vec3* a = &flat_[i].corner[edge];
        const Vec3* b = &flat_[i].corner[edge < 2 ? edge + 1 : 0];
        std::size_t at = (hashOf(*a) + hashOf(*b)) & mask;
        for (;; at = (at + 1) & mask) {
          Slot& slot = slots[at];
          if (!slot.a) {
            slot.a = a, slot.b = b;
            slot.sides[0] = {i, edge};
            break;
          }
          const bool along = *slot.a == *a && *slot.b == *b;
          if (!along && !(*slot.a == *b && *slot.b == *a))
            continue;
          Side& side = slot.sides[along ? 0 : 1];
          slot.shared |= side.flat != kNone;
          side = {i, edge};
          break;
        }
      }
    }
    for (FlatTriangle& flat : flat_) std::ranges::fill(flat.neighbour, kNone);
    for (const Slot& slot : slots) {
      const auto& [left, right] = slot.sides;
      if (left.flat == kNone || right.flat == kNone || slot.shared)
        continue;
      flat_[left.flat].neighbour[left.edge] = right.flat;
      flat_[right.flat].neighbour[right.edge] = left.flat;
    }
  }

  static std::size_t hashOf(const Vec3& corner) {
    const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value + 0.0); };
    const std::uint64_t mixed =
        bits(corner.x()) * 0x9e3779b97f4a7c15ull + bits(corner.y()) * 0xc2b2ae3d27d4eb4full;
    return ((mixed ^ (mixed >> 29)) * 0xbf58476d1ce4e5b9ull) >> 20;
  }

  /// Whether an edge goes through a square.
  static bool meets(const FlatTriangle& flat, int edge, const Square& square) {
    const Vec2 a = flat.corner[edge].head<2>() - Vec2(square.x, square.y), b = a + flat.edge[edge];
    return std::min(a.x(), b.x()) <= square.half && std::max(a.x(), b.x()) >= -square.half &&
           std::min(a.y(), b.y()) <= square.half && std::max(a.y(), b.y()) >= -square.half &&
           std::abs(flat.side(edge, Vec2(square.x, square.y))) <= flat.spread[edge] * square.half;
  }

  /// The height below which a square lies in the dark of a surface that covers it without a gap:
  /// from a triangle over its middle, edge by edge, there is a next one wherever the edge meets
  /// the square. -infinity without such a surface.
  double coveredTogether(const Square& square, std::span<const Entry> entries) {
    const std::uint32_t here = ++mark_;
    for (const Entry& entry : entries) marks_[entry.flat] = {here, &entry, false};
    double best = -kEndless;
    for (const Entry& start : entries) {
      if (!start.cover.middle || marks_[start.flat].seen)
        continue;
      double lowest = kEndless;
      bool whole = true;
      open_.assign(1, start.flat);
      marks_[start.flat].seen = true;
      while (!open_.empty()) {
        const std::uint32_t at = open_.back();
        open_.pop_back();
        lowest = std::min(lowest, marks_[at].entry->cover.lowest);
        for (int edge = 0; edge < 3; ++edge) {
          const std::uint32_t next = flat_[at].neighbour[edge];
          if (next != kNone && marks_[next].node == here) {
            if (!marks_[next].seen) {
              marks_[next].seen = true;
              open_.push_back(next);
            }
          } else if (whole && meets(flat_[at], edge, square)) {
            whole = false;
          }
        }
      }
      if (whole)
        best = std::max(best, lowest);
    }
    return best;
  }

  struct Mark {
    std::uint32_t node = 0;
    const Entry* entry = nullptr;
    bool seen = false;
  };

  SunTree::Plot& plot_;
  std::vector<FlatTriangle> flat_;
  std::vector<Mark> marks_;
  std::vector<std::uint32_t> open_;
  std::uint32_t mark_ = 0;
};

SunTree::SunTree(std::span<const Triangle> triangles, const Vec3& towards) : triangles_(triangles) {
  const Vec3 up = towards.normalized();
  const Vec3 right = up.unitOrthogonal();
  axes_ = Mat3::ofRows(right, up.cross(right), up);
  SunTreeBuilder::share(*this);
}

const SunTree::Plot& SunTree::plot(std::uint32_t number) const {
  Plot& plot = plots_[number];
  std::call_once(plot.grown, [&] { SunTreeBuilder(plot, triangles_, axes_); });
  return plot;
}

}  // namespace volute
