// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_medium.hpp"

#include "volute/base/assert.hpp"

namespace volute {
namespace {

/// The value of a field along a segment inside a tet, as c0 + c1 u.
struct Line {
  double c0 = 0, c1 = 0;
};

}  // namespace

TetMedium::TetMedium(std::shared_ptr<const TetLocator> locator, std::vector<float> extinction,
                     std::vector<float> source)
    : locator_(std::move(locator)), extinction_(std::move(extinction)), source_(std::move(source)) {
  VOLUTE_ASSERT(extinction_.size() == locator_->mesh().vertices().size());
  VOLUTE_ASSERT(source_.empty() || source_.size() == 3 * extinction_.size());
}

Vec4 TetMedium::shares(std::int32_t tet, const Vec3& point) const {
  const auto shares = locator_->mesh().shares(tet, point);
  return Vec4(shares[0], shares[1], shares[2], shares[3]).cwiseMax(0);
}

double TetMedium::extinction(const Vec3& point) const {
  const std::int32_t tet = locator_->find(point);
  if (tet < 0)
    return 0;
  const Vec4 share = shares(tet, point);
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += share[k] * extinction_[locator_->mesh().tets()[tet][k]];
  return sum;
}

Rgb TetMedium::emission(const Vec3& point) const {
  const std::int32_t tet = locator_->find(point);
  if (tet < 0 || source_.empty())
    return Rgb::Zero();
  const Vec4 share = shares(tet, point);
  Rgb source = Rgb::Zero();
  for (int k = 0; k < 4; ++k) {
    const auto v = static_cast<std::size_t>(locator_->mesh().tets()[tet][k]);
    for (int c = 0; c < 3; ++c) source[c] += share[k] * source_[3 * v + c];
  }
  return source * extinction(point);
}

void TetMedium::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  std::vector<TetCrossing> crossings;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    locator_->crossings(segments[s], crossings);
    double sum = 0;
    for (const TetCrossing& crossing : crossings) {
      // Linear along the ray: the middle is the mean.
      const Vec4 share =
          shares(crossing.tet, segments[s].at(0.5 * (crossing.begin + crossing.end)));
      double mean = 0;
      for (int k = 0; k < 4; ++k)
        mean += share[k] * extinction_[locator_->mesh().tets()[crossing.tet][k]];
      sum += mean * (crossing.end - crossing.begin);
    }
    depths[s] = sum;
  }
}

void TetMedium::pieces(std::span<const Segment> segments,
                       std::span<std::vector<Piece>> pieces) const {
  std::vector<TetCrossing> crossings;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    pieces[s].clear();
    locator_->crossings(segments[s], crossings);
    for (const TetCrossing& crossing : crossings) {
      const double length = crossing.end - crossing.begin;
      const Vec4 at = shares(crossing.tet, segments[s].at(crossing.begin));
      const Vec4 slope = (shares(crossing.tet, segments[s].at(crossing.end)) - at) / length;
      const Tet& tet = locator_->mesh().tets()[crossing.tet];
      const auto line = [&](auto&& value) {
        Line sum;
        for (int k = 0; k < 4; ++k) {
          sum.c0 += at[k] * value(tet[k]);
          sum.c1 += slope[k] * value(tet[k]);
        }
        return sum;
      };
      Piece piece{crossing.begin, crossing.end, {}, {}, 0};
      const Line tau = line([&](std::int32_t v) { return extinction_[v]; });
      piece.extinction.c = {tau.c0, tau.c1, 0, 0};
      for (int c = 0; c < 3 && !source_.empty(); ++c) {
        const Line e = line([&](std::int32_t v) { return source_[3 * std::size_t(v) + c]; });
        piece.emission[c].c = {tau.c0 * e.c0, tau.c0 * e.c1 + tau.c1 * e.c0, tau.c1 * e.c1, 0};
      }
      pieces[s].push_back(piece);
    }
  }
}

}  // namespace volute
