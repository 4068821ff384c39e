// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/cell_cutter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volute {
namespace {

/// Shares of an area or a volume, each times the number of pieces: 1 where all are alike.
constexpr double kGood = 1e-2;  // taken without looking further
constexpr double kMin = 1e-9;   // smaller ones are rounding

constexpr std::int64_t kNone = -1;

/// The face from its vertex of least index towards the lower of that one's neighbours: the same
/// from both sides.
Polygon canonical(const Polygon& face, bool& reversed) {
  const auto n = face.size();
  const auto low = static_cast<std::size_t>(std::ranges::min_element(face) - face.begin());
  reversed = face[(low + n - 1) % n] < face[(low + 1) % n];
  Polygon out;
  for (std::size_t i = 0; i < n; ++i) out.push_back(face[(low + (reversed ? n - i : i)) % n]);
  return out;
}

/// Cuts a polygon that is neither convex nor seen whole from its middle, ear by ear, the one first
/// that is largest for its longest side. False when there is no ear: it crosses itself.
bool clipEars(const std::vector<Vec3>& at, const Vec3& area,
              std::vector<std::array<std::size_t, 3>>& triangles) {
  const auto twice = [&](std::size_t a, std::size_t b, std::size_t c) {
    return (at[b] - at[a]).cross(at[c] - at[a]).dot(area) / area.squaredNorm();
  };
  std::vector<std::size_t> left(at.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  const auto earAt = [&](std::size_t k) {
    const std::size_t n = left.size();
    const std::size_t a = left[(k + n - 1) % n], b = left[k], c = left[(k + 1) % n];
    const double size = twice(a, b, c);
    if (!(size > kMin))
      return -1.0;
    for (const std::size_t d : left) {
      if (d != a && d != b && d != c && twice(a, b, d) >= 0 && twice(b, c, d) >= 0 &&
          twice(c, a, d) >= 0)
        return -1.0;
    }
    return size / (at[c] - at[a]).squaredNorm();
  };
  while (left.size() > 2) {
    std::size_t best = 0;
    for (std::size_t k = 1; k < left.size(); ++k) {
      if (earAt(k) > earAt(best))
        best = k;
    }
    if (!(earAt(best) > 0))
      return false;
    const std::size_t n = left.size();
    triangles.push_back({left[(best + n - 1) % n], left[best], left[(best + 1) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return true;
}

double sixVolumes(const Vec3& tip, const Vec3& a, const Vec3& b, const Vec3& c) {
  return (a - tip).dot((b - tip).cross(c - tip));
}

}  // namespace

Vec3 CellCutter::place(std::int64_t vertex) const {
  const auto v = static_cast<std::size_t>(vertex);
  return v < soup_.vertices.size() ? soup_.vertices[v]
                                   : out_.added.places[v - soup_.vertices.size()];
}

std::int64_t CellCutter::add(std::span<const std::int64_t> from, std::span<const double> shares) {
  AddedVertices& added = out_.added;
  Vec3 place = Vec3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    place += shares[i] * soup_.vertices[static_cast<std::size_t>(from[i])];
    added.from.push_back(static_cast<std::int32_t>(from[i]));
    added.shares.push_back(shares[i]);
  }
  added.places.push_back(place);
  added.offsets.push_back(added.from.size());
  return static_cast<std::int64_t>(soup_.vertices.size() + added.places.size() - 1);
}

std::int64_t CellCutter::middleOf(const Polygon& face) {
  const auto known = middles_.find(face);
  if (known != middles_.end())
    return known->second;
  const std::vector<double> shares(face.size(), 1.0 / static_cast<double>(face.size()));
  return middles_[face] = add(face, shares);
}

Status CellCutter::cutFace(const Polygon& face) {
  bool reversed = false;
  const Polygon polygon = canonical(face, reversed);
  const std::size_t n = polygon.size();
  const auto emit = [&](std::int64_t a, std::int64_t b, std::int64_t c) {
    triangles_.push_back(reversed ? Corners{a, c, b} : Corners{a, b, c});
  };
  if (n == 3) {
    emit(polygon[0], polygon[1], polygon[2]);
    return {};
  }
  // Relative to a corner, where rounding is that of the face and not of its place.
  std::vector<Vec3> at;
  Vec3 mean = Vec3::Zero(), area = Vec3::Zero();
  for (const std::int64_t v : polygon) {
    at.push_back(place(v) - place(polygon[0]));
    mean += at.back() / static_cast<double>(n);
  }
  for (std::size_t i = 1; i + 1 < n; ++i) area += at[i].cross(at[i + 1]);
  const double square = area.squaredNorm();
  // Of a face that is not flat, pieces that lean away from the rest are as bad as those without
  // area: half a right angle at an edge hides the middle of a cube.
  const auto share = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 piece = (b - a).cross(c - a);
    const double part = piece.dot(area);
    const double cosine2 = part > 0 ? part * part / (square * piece.squaredNorm()) : 1;
    return part / square * std::pow(cosine2, 4);  // of the cosine
  };
  std::vector<std::size_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = i;
  std::ranges::sort(order, {}, [&](std::size_t i) { return polygon[i]; });
  double best = -std::numeric_limits<double>::infinity();
  std::size_t tip = 0;
  for (const std::size_t candidate : order) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i + 1 < n; ++i)
      least = std::min(least,
                       share(at[candidate], at[(candidate + i) % n], at[(candidate + i + 1) % n]));
    least *= static_cast<double>(n - 2);
    if (least > best)
      best = least, tip = candidate;
    if (best >= kGood)
      break;
  }
  if (!(best >= kGood)) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n; ++i)
      least = std::min(least, share(mean, at[i], at[(i + 1) % n]));
    least *= static_cast<double>(n);
    if (!(std::max(least, best) > kMin)) {
      std::vector<std::array<std::size_t, 3>> ears;
      if (!clipEars(at, area, ears)) {
        return fail(ErrorCode::kInvalidData,
                    "has a face (of {} vertices, {}, {} and {} among them) that cannot be cut into "
                    "triangles: it is folded or without area; mend the mesh",
                    n, polygon[0], polygon[1], polygon[2]);
      }
      for (const auto& [a, b, c] : ears) emit(polygon[a], polygon[b], polygon[c]);
      return {};
    }
    if (least > best) {
      const std::int64_t middle = middleOf(polygon);
      for (std::size_t i = 0; i < n; ++i) emit(middle, polygon[i], polygon[(i + 1) % n]);
      return {};
    }
  }
  for (std::size_t i = 1; i + 1 < n; ++i)
    emit(polygon[tip], polygon[(tip + i) % n], polygon[(tip + i + 1) % n]);
  return {};
}

double CellCutter::minShare(const Vec3& tip, std::int64_t vertex, double volume,
                            double enough) const {
  double least = std::numeric_limits<double>::infinity();
  int count = 0;
  for (const Corners& t : triangles_) {
    if (std::ranges::find(t, vertex) != t.end())
      continue;
    least = std::min(least, sixVolumes(tip, place(t[0]), place(t[1]), place(t[2])) / volume);
    if (std::max(least, least * static_cast<double>(triangles_.size())) <= enough)
      return least;
    ++count;
  }
  return count > 0 ? least * count : -1;
}

/// Goes from the middle towards the inner side of all faces, less deep into the cell each time
/// that it finds no way.
Vec3 CellCutter::placeInside(const Vec3& middle, double volume) const {
  constexpr int kSteps = 200;
  const double size = std::cbrt(volume);
  Vec3 at = middle;
  for (const double depth : {0.1, 0.03, 0.01, 0.003}) {
    for (int step = 0; step < kSteps; ++step) {
      double worst = 0;
      Vec3 move = Vec3::Zero();
      for (const Corners& t : triangles_) {
        const Vec3 a = place(t[0]);
        const Vec3 normal = (place(t[1]) - a).cross(place(t[2]) - a).normalized();
        const double beyond = normal.dot(at - a) + depth * size;
        if (beyond > worst)
          worst = beyond, move = -beyond * normal;
      }
      if (worst <= 1e-6 * size)
        return at;
      at += move;
    }
  }
  return at;
}

Status CellCutter::cut(std::int32_t cell, const std::vector<Polygon>& faces) {
  triangles_.clear();
  corners_.clear();
  for (const Polygon& face : faces) {
    VOLUTE_TRY(cutFace(face));
    corners_.insert(corners_.end(), face.begin(), face.end());
  }
  std::ranges::sort(corners_);
  corners_.erase(std::unique(corners_.begin(), corners_.end()), corners_.end());
  const auto n = static_cast<double>(corners_.size());
  Vec3 middle = Vec3::Zero();
  for (const std::int64_t v : corners_) middle += place(v) / n;
  double volume = 0;  // six times it
  for (const Corners& t : triangles_)
    volume += sixVolumes(middle, place(t[0]), place(t[1]), place(t[2]));
  if (volume < 0) {
    volume = -volume;
    for (Corners& t : triangles_) std::swap(t[1], t[2]);
  }
  if (!(volume > 0))
    return fail(ErrorCode::kInvalidData, "has no volume; mend the mesh");
  double best = -std::numeric_limits<double>::infinity();
  std::int64_t tip = kNone;
  for (const std::int64_t candidate : corners_) {
    const double least = minShare(place(candidate), candidate, volume, best);
    if (least > best)
      best = least, tip = candidate;
    if (best >= kGood)
      break;
  }
  if (!(best >= kGood)) {
    std::vector<double> shares(corners_.size(), 1 / n);
    double least = minShare(middle, kNone, volume, best);
    if (!(least >= kGood)) {
      // A place that sees all faces, as shares of the corners: those of the linear fit there.
      const Vec3 inside = placeInside(middle, volume / 6);
      const double there = minShare(inside, kNone, volume, best);
      if (there > least) {
        Mat3 spread = Mat3::Zero();
        for (const std::int64_t v : corners_)
          spread += outerProduct(place(v) - middle, place(v) - middle);
        const Vec3 slope = spread.inverse() * (inside - middle);
        for (std::size_t i = 0; i < shares.size(); ++i)
          shares[i] += slope.dot(place(corners_[i]) - middle);
        least = there;
      }
    }
    if (!(std::max(least, best) > kMin)) {
      return fail(ErrorCode::kInvalidData,
                  "(of {} faces) cannot be split into tetrahedra: from no place inside are all of "
                  "its faces seen; divide it or mend the mesh",
                  faces.size());
    }
    if (least > best)
      tip = add(corners_, shares);
  }
  for (const Corners& t : triangles_) {
    if (std::ranges::find(t, tip) != t.end())
      continue;
    out_.tets.push_back({static_cast<std::int32_t>(tip), static_cast<std::int32_t>(t[0]),
                         static_cast<std::int32_t>(t[1]), static_cast<std::int32_t>(t[2])});
    out_.cellOf.push_back(cell);
  }
  return {};
}

}  // namespace volute
