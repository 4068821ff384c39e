// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_iso.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "volute/base/parallel.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr double kThick = 1e-3;     // [m]
constexpr double kNormal = 0.02;    // [m], to both sides of a point: for the slope there
constexpr double kSteep = 0.55;     // of the colour, where the surface stands upright
constexpr double kTouching = 1e-9;  // [m], between pieces side by side
constexpr int kParts = 4;           // of a cell: a cubic crosses a level three times at most
constexpr int kHalvings = 40;

/// Adds where value(s) - level changes its sign.
void addRoots(const Piece& piece, double level, std::vector<double>& roots) {
  const double length = piece.end - piece.begin;
  const auto above = [&](double s) { return piece.extinction(s) >= level; };
  for (int part = 0; part < kParts; ++part) {
    double low = length * part / kParts, high = length * (part + 1) / kParts;
    const bool first = above(low);
    if (first == above(high))
      continue;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (above(middle) == first ? low : high) = middle;
    }
    roots.push_back(piece.begin + 0.5 * (low + high));
  }
}

}  // namespace

double sheetShade(double up) {
  return kSteep + (1 - kSteep) * std::abs(up);
}

void sheetPieces(const Segment& segment, std::span<const double> roots, double opacity,
                 const std::function<Rgb(std::size_t)>& colourAt, std::vector<Piece>& pieces) {
  const double depth = -std::log1p(-opacity);
  pieces.clear();
  double free = segment.begin;  // where the sheet before ends
  for (std::size_t r = 0; r < roots.size(); ++r) {
    const double next = r + 1 < roots.size() ? 0.5 * (roots[r] + roots[r + 1]) : segment.end;
    const double from = std::max(free, roots[r] - 0.5 * kThick);
    const double to = std::min(next, roots[r] + 0.5 * kThick);
    if (!(to > from))
      continue;
    const double taken = depth / (to - from);
    const Rgb colour = colourAt(r);
    Piece sheet{from, to, {}, {}, 0};
    sheet.extinction.c[0] = taken;
    for (int c = 0; c < 3; ++c) sheet.emission[c].c[0] = taken * colour[c];
    pieces.push_back(sheet);
    free = to;
  }
}

std::vector<double> FdsIso::crossings(const Segment& segment) const {
  std::vector<Piece> values;
  field_.pieces({&segment, 1}, {&values, 1});
  std::vector<double> roots;
  const Piece* before = nullptr;
  for (const Piece& piece : values) {
    // Cells that have one value each, and those of two meshes, differ at the face between them.
    if (before != nullptr && piece.begin - before->end <= kTouching &&
        (before->extinction(before->end - before->begin) >= look_.level) !=
            (piece.extinction(0) >= look_.level))
      roots.push_back(piece.begin);
    addRoots(piece, look_.level, roots);
    before = &piece;
  }
  std::ranges::sort(roots);
  return roots;
}

Rgb FdsIso::shaded(const Vec3& at) const {
  Vec3 slope = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 step = kNormal * Vec3::Unit(axis);
    const Vec3 below = at - step, above = at + step;
    // What is beside gas has no value.
    if (field_.cellAt(below) == FdsCell::kGas && field_.cellAt(above) == FdsCell::kGas)
      slope[axis] = field_.extinction(above) - field_.extinction(below);
  }
  const double length = slope.norm();
  const double up = length > 0 ? std::abs(slope.z()) / length : 1;
  return sheetShade(up) * look_.colour;
}

void FdsIso::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  const double depth = -std::log1p(-look_.opacity);
  parallelRanges(segments.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      depths[i] = depth * static_cast<double>(crossings(segments[i]).size());
  });
}

void FdsIso::pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const std::vector<double> roots = crossings(segments[i]);
    sheetPieces(
        segments[i], roots, look_.opacity,
        [&](std::size_t root) { return shaded(segments[i].at(roots[root])); }, pieces[i]);
  }
}

void FdsIso::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  radianceByPieces(*this, segments, out);
}

}  // namespace volute
