// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// Triangles as a far light sees them: a tree of squares on the plane across its direction. Of each
/// square it knows above which height, towards the light, there is nothing, and below which height
/// everything is in the dark because a surface covers the square without a gap (a triangle alone,
/// or neighbours across their edges). What is decided by neither is asked of the triangles of a
/// leaf. The lower part of the tree grows where segments come by first; by any thread.
class SunTree {
 public:
  /// The triangles must outlive it. @param towards  the light; its length does not matter
  SunTree(std::span<const Triangle> triangles, const Vec3& towards);

  /// Calls `dark` for parts of a segment that are in the dark; all others are lit. Parts may
  /// overlap, but one that ends before another begins comes first, unless both are of the same
  /// leaf. The segment must not lead to the light. A triangle that the light meets nearly edge-on
  /// is given to `look`, with the part on which it may be in the light's way.
  template <class Dark, class Look>
  void walk(const Segment& segment, Dark&& dark, Look&& look) const;

 private:
  friend class SunTreeBuilder;

  static constexpr std::uint32_t kParent = 0xffffffffu, kPlot = 0xfffffffeu;
  static constexpr int kDeepest = 20;
  static constexpr double kNothing = 1e-12;  ///< of a segment's part in a leaf: rounding

  struct Node {
    double dark = 0;   ///< below it everything is in the dark
    double light = 0;  ///< above it nothing is in the way
    /// Of four children, +1: the one of larger x, +2: of larger y; of a leaf's triangles; a plot.
    std::uint32_t first = 0;
    std::uint32_t count = 0;  ///< of a leaf's triangles, or kParent, or kPlot
  };

  struct Square {
    double x = 0, y = 0;  ///< its middle
    double half = 0;      ///< half its side [m]

    Square child(int i) const {
      const double quarter = 0.5 * half;
      return {x + (i & 1 ? quarter : -quarter), y + (i & 2 ? quarter : -quarter), quarter};
    }
  };

  /// A triangle across the light, from the middle of its plot on.
  struct Face {
    /// x_i x + y_i y + rest_i: of a point, for each edge, the same numbers but for the sign for
    /// both triangles of it, and positive on the triangle's side; the last one is the height of
    /// the triangle's plane.
    std::array<double, 4> x, y, rest;
    std::uint32_t triangle = 0;
    bool edgeOn = false;  ///< so steep that its plane says little

    /// Where it is above the line from p to q, as shares of the way; empty: nowhere.
    Interval over(const Vec3& p, const Vec3& q) const;
  };

  struct Entry {
    float top = 0;  ///< at least the height of the face within the leaf
    std::uint32_t face = 0;
  };

  /// A part of the tree that grows when it is asked for first.
  struct Plot {
    Square square;
    int depth = 0;
    std::vector<std::uint32_t> triangles;  ///< until it has grown
    std::once_flag grown;
    std::vector<Node> nodes;
    std::vector<Entry> entries;  ///< of the leaves, the highest first
    std::vector<Face> faces;
  };

  const Plot& plot(std::uint32_t number) const;

  /// A node that a search has still to visit.
  struct Visit {
    const Plot* plot = nullptr;  ///< null: above the plots
    std::uint32_t node = 0;
    bool dark = false;
    Square square;
    Interval part;
    double from = 0, to = 0;  ///< heights at its begin and end
  };

  template <class Dark, class Look>
  void lookAtLeaf(const Visit& leaf, const Node& node, const Vec3& o, const Vec3& d, Dark&& dark,
                  Look&& look) const;

  std::span<const Triangle> triangles_;
  Mat3 axes_;  ///< rows: across the light, across, towards it
  Square square_;
  std::vector<Node> top_;  ///< the first is the root; none without triangles
  std::unique_ptr<Plot[]> plots_;
};

inline Interval SunTree::Face::over(const Vec3& p, const Vec3& q) const {
  std::array<double, 4> atP, atQ;
  for (int i = 0; i < 4; ++i) {
    atP[i] = x[i] * p.x() + y[i] * p.y() + rest[i];
    atQ[i] = x[i] * q.x() + y[i] * q.y() + rest[i];
  }
  atP[3] -= p.z();
  atQ[3] -= q.z();
  bool beside = false;
  for (int i = 0; i < 4; ++i) beside |= std::max(atP[i], atQ[i]) < 0;
  if (beside)
    return {};
  Interval part{0, 1};
  for (int i = 0; i < 4; ++i) {
    if (atP[i] < 0)
      part.begin = std::max(part.begin, atP[i] / (atP[i] - atQ[i]));
    else if (atQ[i] < 0)
      part.end = std::min(part.end, atP[i] / (atP[i] - atQ[i]));
  }
  return part;
}

template <class Dark, class Look>
void SunTree::lookAtLeaf(const Visit& leaf, const Node& node, const Vec3& o, const Vec3& d,
                         Dark&& dark, Look&& look) const {
  const double lowest = std::min(leaf.from, leaf.to), length = leaf.part.length();
  const Vec3 from = o - Vec3(leaf.plot->square.x, leaf.plot->square.y, 0);
  const Vec3 p = from + leaf.part.begin * d, q = from + leaf.part.end * d;
  const auto give = [&](const Interval& over) {
    dark(Interval{leaf.part.begin + over.begin * length,
                  over.end < 1 ? leaf.part.begin + over.end * length : leaf.part.end});
  };
  Interval covered;  // by faces that touch, before they are given
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    const Entry& entry = leaf.plot->entries[i];
    if (entry.top < lowest)
      break;
    const Face& face = leaf.plot->faces[entry.face];
    if (face.edgeOn) {
      look(triangles_[face.triangle], leaf.part);
      continue;
    }
    const Interval over = face.over(p, q);
    if (!(over.length() > kNothing))
      continue;
    if (over.begin == 0 && over.end == 1) {
      dark(leaf.part);
      return;
    }
    if (over.begin > covered.end || over.end < covered.begin) {
      if (!covered.empty())
        give(covered);
      covered = over;
    } else {
      covered.begin = std::min(covered.begin, over.begin);
      covered.end = std::max(covered.end, over.end);
      if (covered.begin == 0 && covered.end == 1) {
        dark(leaf.part);
        return;
      }
    }
  }
  if (!covered.empty())
    give(covered);
}

template <class Dark, class Look>
void SunTree::walk(const Segment& segment, Dark&& dark, Look&& look) const {
  if (top_.empty())
    return;
  const Vec3 o = axes_ * segment.origin, d = axes_ * segment.direction;
  const Box3 square{Vec3(square_.x - square_.half, square_.y - square_.half, -1),
                    Vec3(square_.x + square_.half, square_.y + square_.half, 1)};
  const Interval inside = square.intersect(Vec3(o.x(), o.y(), 0), Vec3(d.x(), d.y(), 0))
                              .intersect({segment.begin, segment.end});
  if (inside.empty())
    return;
  const double perX = 1 / d.x(), perY = 1 / d.y();
  std::array<Visit, 2 * kDeepest + 4> stack;  // of three children one is gone into
  int left = 0;
  const auto heightAt = [&](double s) { return o.z() + s * d.z(); };
  // What is certainly lit is not put on the stack.
  const auto visit = [&](const Plot* in, std::uint32_t number, const Square& where,
                         const Interval& part, double from, double to) {
    const Node& node = in ? in->nodes[number] : top_[number];
    if (std::min(from, to) < node.light)
      stack[left++] = {in, number, std::max(from, to) <= node.dark, where, part, from, to};
  };
  visit(nullptr, 0, square_, inside, heightAt(inside.begin), heightAt(inside.end));
  while (left > 0) {
    const Visit& at = stack[--left];
    if (at.dark) {
      dark(at.part);
      continue;
    }
    const Node& node = at.plot ? at.plot->nodes[at.node] : top_[at.node];
    if (node.count == kPlot) {
      const Visit whole = at;
      visit(&plot(node.first), 0, whole.square, whole.part, whole.from, whole.to);
      continue;
    }
    if (node.count != kParent) {
      lookAtLeaf(at, node, o, d, dark, look);
      continue;
    }
    // Where the segment goes from one half of the square into the other; the last part is put on
    // the stack first.
    const Plot* const plot = at.plot;
    const Square middle = at.square;
    const double begin = at.part.begin, from = at.from;
    const double atX = (middle.x - o.x()) * perX, atY = (middle.y - o.y()) * perY;
    double end = at.part.end, to = at.to;
    const auto goBackTo = [&](double s, double height) {
      const double half = 0.5 * (s + end);
      const int child =
          (o.x() + half * d.x() >= middle.x ? 1 : 0) + (o.y() + half * d.y() >= middle.y ? 2 : 0);
      visit(plot, node.first + child, middle.child(child), {s, end}, height, to);
      end = s, to = height;
    };
    const double last = std::max(atX, atY), first = std::min(atX, atY);
    if (last > begin && last < end)
      goBackTo(last, heightAt(last));
    if (first > begin && first < end)
      goBackTo(first, heightAt(first));
    goBackTo(begin, from);
  }
}

}  // namespace volute
