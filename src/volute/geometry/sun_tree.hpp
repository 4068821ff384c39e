// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"

namespace volute {

/// Triangles as a far light sees them: a tree of squares on the plane across its direction. Of each
/// square it knows above which height, towards the light, there is nothing, and below which height
/// everything is in the dark because surfaces cover the square without a gap (a triangle alone, or
/// the few of a leaf together). What is decided by neither is asked of the triangles of a leaf. The
/// lower part of the tree grows where segments come by first; by any thread.
class SunTree {
 public:
  /// The triangles must outlive it. @param towards  the light; its length does not matter
  SunTree(std::span<const Triangle> triangles, const Vec3& towards);

  /// Calls `dark` for parts of a segment that are in the dark, and `look` for a triangle and a part
  /// on which it may be what is in the light's way. All other parts are lit. The segment must not
  /// lead to the light.
  template <class Dark, class Look>
  void walk(const Segment& segment, Dark&& dark, Look&& look) const;

 private:
  friend class SunTreeBuilder;

  static constexpr std::uint32_t kParent = 0xffffffffu, kPlot = 0xfffffffeu;
  static constexpr int kDeepest = 20;

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

  /// A part of the tree that grows when it is asked for first.
  struct Plot {
    Square square;
    int depth = 0;
    std::vector<std::uint32_t> triangles;  ///< until it has grown
    std::once_flag grown;
    std::vector<Node> nodes;
    std::vector<std::uint32_t> order;
  };

  const Plot& plot(std::uint32_t number) const;

  /// What is left to look at.
  struct Visit {
    const Plot* plot = nullptr;  ///< null: above the plots
    std::uint32_t node = 0;
    Square square;
    Interval part;
  };

  std::span<const Triangle> triangles_;
  Mat3 axes_;  ///< rows: across the light, across, towards it
  Square square_;
  std::vector<Node> top_;  ///< the first is the root; none without triangles
  std::unique_ptr<Plot[]> plots_;
};

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
  const auto heightAt = [&](double s) { return o.z() + s * d.z(); };
  std::array<Visit, 2 * kDeepest + 2> stack;  // of three children one is gone into
  int left = 0;
  // What is decided by a node's bounds is not put on the stack.
  const auto visit = [&](const Plot* in, std::uint32_t number, const Square& where,
                         const Interval& part, double from, double to) {
    const Node& node = in ? in->nodes[number] : top_[number];
    if (std::min(from, to) >= node.light)
      return;
    if (std::max(from, to) <= node.dark)
      dark(part);
    else
      stack[left++] = {in, number, where, part};
  };
  visit(nullptr, 0, square_, inside, heightAt(inside.begin), heightAt(inside.end));
  while (left > 0) {
    const Visit at = stack[--left];
    const Interval& part = at.part;
    const Node& node = at.plot ? at.plot->nodes[at.node] : top_[at.node];
    if (node.count == kPlot) {
      visit(&plot(node.first), 0, at.square, part, heightAt(part.begin), heightAt(part.end));
      continue;
    }
    if (node.count != kParent) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        look(triangles_[at.plot->order[i]], part);
      continue;
    }
    // Where the segment goes from one half of the square into the other.
    const double atX = (at.square.x - o.x()) * perX, atY = (at.square.y - o.y()) * perY;
    double begin = part.begin, from = heightAt(begin);
    const auto goTo = [&](double end) {
      const double middle = 0.5 * (begin + end), to = heightAt(end);
      const int child = (o.x() + middle * d.x() >= at.square.x ? 1 : 0) +
                        (o.y() + middle * d.y() >= at.square.y ? 2 : 0);
      visit(at.plot, node.first + child, at.square.child(child), {begin, end}, from, to);
      begin = end, from = to;
    };
    for (const double cut : {std::min(atX, atY), std::max(atX, atY)}) {
      if (cut > begin && cut < part.end)
        goTo(cut);
    }
    goTo(part.end);
  }
}

}  // namespace volute
