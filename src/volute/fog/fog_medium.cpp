// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_medium.hpp"

#include <algorithm>
#include <cmath>

#include "volute/fog/cell_spline.hpp"
#include "volute/fog/fog_march.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {

/// Heights of the fog's top: linear between nodes, zero outside of its map.
struct FogMedium::Top {
  SplineGrid heights;
  double offsetX = 0, offsetY = 0;  ///< [m], from the fog map's origin
  double cell = 1;                  ///< [m]

  double at(double x, double y) const {
    const double cellX = std::floor(x), cellY = std::floor(y);
    return CellSpline(heights, 1, static_cast<int>(cellX), static_cast<int>(cellY))(x - cellX,
                                                                                    y - cellY);
  }
};

namespace {

constexpr double kRounding = 1e-15;

/// The real roots of c0 + c1 t + c2 t^2 strictly within (0, end), ascending.
std::vector<double> rootsWithin(double c0, double c1, double c2, double end) {
  std::vector<double> roots;
  const double discriminant = c1 * c1 - 4 * c2 * c0;
  if (discriminant >= 0) {
    // Of the two ways to write a root the one without cancellation.
    const double q = -0.5 * (c1 + std::copysign(std::sqrt(discriminant), c1));
    if (c2 != 0)
      roots.push_back(q / c2);
    if (q != 0)
      roots.push_back(c0 / q);
  }
  std::erase_if(roots, [&](double t) { return !(t > 0 && t < end); });
  std::ranges::sort(roots);
  return roots;
}

/// The piece of a spline along a ray times a zone of the profile. `height` is the ray's at `begin`.
Piece zonedPiece(const Polynomial& along, const FogProfile::Zone& zone, double height, double rise,
                 double begin, double end) {
  Piece piece{begin, end, along, {}, 0};
  if (zone.slope != 0) {
    piece.extinction = along.timesLine(zone(height), zone.slope * rise);
  } else {
    piece.extinction = along * zone(height);
    piece.decay = zone.decay * rise;
  }
  return piece;
}

Status check(const FogMap& map, const FogOptions& options) {
  if (options.degree < 0 || options.degree > kMaxSplineDegree) {
    return fail(ErrorCode::kInvalidArgument, "the fog's degree is {}, but must be from 0 to {}",
                options.degree, kMaxSplineDegree);
  }
  if (options.levels < 0 || options.levels > kMaxFogLevels) {
    return fail(ErrorCode::kInvalidArgument, "the fog has {} levels, but must have from 0 to {}",
                options.levels, kMaxFogLevels);
  }
  const FogDetail& detail = options.detail;
  if (!(detail.mu >= 0 && detail.mu <= 1)) {
    return fail(ErrorCode::kInvalidArgument, "the fog's mu is {}, but must be from 0 to 1",
                detail.mu);
  }
  if (!(detail.cellAngle >= 0 && std::isfinite(detail.cellAngle))) {
    return fail(ErrorCode::kInvalidArgument,
                "the fog's cell angle is {} rad, but must be finite and not negative",
                detail.cellAngle);
  }
  if (!(options.color >= 0).all() || !options.color.isFinite().all())
    return fail(ErrorCode::kInvalidArgument, "the fog's color must be finite and not negative");
  // The margin grows with the coarsest cell, so the padded map does too.
  const double most = double(1 << options.levels) * (2 * options.degree + 1);
  if ((map.coefficients.columns + most) * (map.coefficients.rows + most) > double(1 << 29)) {
    return fail(ErrorCode::kTooLarge, "a fog map of {} x {} pixels cannot have {} levels",
                map.coefficients.columns, map.coefficients.rows, options.levels);
  }
  return {};
}

}  // namespace

Result<FogMedium> FogMedium::make(const FogMap& map, const FogProfile& profile,
                                  const FogOptions& options, const std::optional<FogMap>& top) {
  VOLUTE_TRY(check(map, options));
  FogMedium fog;
  fog.levels_ = std::make_shared<const FogLevels>(map.coefficients, options.degree, options.levels,
                                                  options.restriction);
  fog.profile_ = profile;
  fog.options_ = options;
  fog.origin_ = map.origin;
  fog.cell_ = map.cell;
  if (top) {
    const Vec3 offset = top->origin - map.origin;
    fog.top_ =
        std::make_shared<const Top>(Top{top->coefficients, offset.x(), offset.y(), top->cell});
    fog.options_.detail = {};
  }
  return fog;
}

Vec3 FogMedium::domainCorner() const {
  const CellRect map = levels_->mapCells();
  return origin_ - cell_ * Vec3(map.x0, map.y0, 0);
}

std::optional<FogMap> FogMedium::top() const {
  if (!top_)
    return std::nullopt;
  return FogMap{top_->heights, origin_ + Vec3(top_->offsetX, top_->offsetY, 0), top_->cell};
}

Box3 FogMedium::bounds() const {
  const bool padded = !options_.detail.finestOnly();
  const FogLevels::Level& finest = levels_->level(0);
  const CellRect cells =
      padded ? CellRect{0, 0, finest.cellsX, finest.cellsY} : levels_->mapCells();
  const Interval heights = profile_.heights();
  const Vec3 corner = domainCorner();
  return {corner + Vec3(cells.x0 * cell_, cells.y0 * cell_, heights.begin),
          corner + Vec3(cells.x1 * cell_, cells.y1 * cell_, heights.end)};
}

PlaneRay FogMedium::planeRay(const Segment& segment, int level) const {
  const double perCell = std::ldexp(1 / cell_, -level);
  const Vec3 local = segment.origin - domainCorner();
  return {local.x() * perCell, local.y() * perCell, segment.direction.x() * perCell,
          segment.direction.y() * perCell};
}

void FogMedium::stretches(const Segment& segment, std::vector<Stretch>& out) const {
  out.clear();
  if (segment.empty())
    return;
  double distance = segment.end;
  if (std::isinf(distance) && !options_.detail.finestOnly())
    distance = std::max(0.0, bounds().intersect(segment.origin, segment.direction).end);
  const FogDetail::Ends ends = options_.detail.ends(levels_->count() - 1, cell_, distance);
  const double height = segment.origin.z() - origin_.z(), rise = segment.direction.z();
  const auto zones = profile_.zones();
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const FogProfile::Zone& zone = zones[rise < 0 ? zones.size() - 1 - i : i];
    Interval inside{segment.begin, segment.end};
    if (rise == 0) {
      if (!(height >= zone.bottom && (height < zone.top || &zone == &zones.back())))
        continue;
      if (height > zone.top)
        continue;
    } else {
      const double a = (zone.bottom - height) / rise, b = (zone.top - height) / rise;
      inside = inside.intersect({std::min(a, b), std::max(a, b)});
    }
    for (int level = 0; level < levels_->count() && !inside.empty(); ++level) {
      const double end = std::min(inside.end, ends[level]);
      if (end > inside.begin) {
        out.push_back({level, &zone, inside.begin, end});
        inside.begin = end;
      }
    }
  }
}

/// Calls visit(stretch, cellX, cellY, ray, begin, end) for each cell of each stretch, front to
/// back, cut where the ray is above the top.
template <class Visit>
void FogMedium::cells(const Segment& segment, Visit&& visit) const {
  std::vector<Stretch> parts;
  stretches(segment, parts);
  for (const Stretch& part : parts) {
    const PlaneRay ray = planeRay(segment, part.level);
    const auto inCell = [&](int x, int y, double begin, double end) {
      visit(part, x, y, ray, begin, end);
    };
    const CellRect rect = levels_->cells(part.level);
    if (!top_) {
      walkCells(ray, rect, part.begin, part.end, inCell);
      continue;
    }
    const double perCell = 1 / top_->cell;
    const double rise = segment.direction.z();
    const PlaneRay above{(segment.origin.x() - origin_.x() - top_->offsetX) * perCell,
                         (segment.origin.y() - origin_.y() - top_->offsetY) * perCell,
                         segment.direction.x() * perCell, segment.direction.y() * perCell};
    constexpr int kFar =
        1 << 28;  // h = 0 outside of the top's map, so there is no end to its cells
    walkCells(ray, rect, part.begin, part.end, [&](int x, int y, double b, double e) {
      walkCells(above, {-kFar, -kFar, kFar, kFar}, b, e,
                [&](int topX, int topY, double begin, double end) {
                  const CellSpline cell(top_->heights, 1, topX, topY);
                  const PlaneAxis u{above.ox, above.dx}, v{above.oy, above.dy};
                  Polynomial over = cell.along(u.at(begin) - topX, above.dx, v.at(begin) - topY,
                                               above.dy);  // the top above the ray
                  over.c[0] -= segment.origin.z() - origin_.z() + begin * rise;
                  over.c[1] -= rise;
                  std::vector<double> cuts =
                      rootsWithin(over.c[0], over.c[1], over.c[2], end - begin);
                  cuts.push_back(end - begin);
                  double from = 0;
                  for (double to : cuts) {
                    if (over(0.5 * (from + to)) > 0 && begin + to > begin + from)
                      inCell(x, y, begin + from, begin + to);
                    from = to;
                  }
                });
    });
  }
}

double FogMedium::extinction(const Vec3& point) const {
  if (!bounds().contains(point))
    return 0;
  const double height = point.z() - origin_.z();
  if (top_) {
    const double x = (point.x() - origin_.x() - top_->offsetX) / top_->cell;
    const double y = (point.y() - origin_.y() - top_->offsetY) / top_->cell;
    if (!(height < top_->at(x, y)))
      return 0;
  }
  const Vec3 local = (point - domainCorner()) / cell_;
  const double x = std::floor(local.x()), y = std::floor(local.y());
  const CellSpline cell(levels_->pyramid().level(0), options_.degree, static_cast<int>(x),
                        static_cast<int>(y));
  return std::max(0.0, cell(local.x() - x, local.y() - y)) * profile_(height);
}

Rgb FogMedium::emission(const Vec3& point) const {
  return options_.color * extinction(point);
}

void FogMedium::pieces(std::span<const Segment> segments,
                       std::span<std::vector<Piece>> pieces) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    pieces[i].clear();
    const Segment& segment = segments[i];
    const double height = segment.origin.z() - origin_.z(), rise = segment.direction.z();
    cells(segment,
          [&](const Stretch& part, int x, int y, const PlaneRay& ray, double begin, double end) {
            const CellSpline cell(levels_->pyramid().level(part.level), options_.degree, x, y);
            if (cell.largest() == 0)
              return;
            const PlaneAxis u{ray.ox, ray.dx}, v{ray.oy, ray.dy};
            const Polynomial along = cell.along(u.at(begin) - x, ray.dx, v.at(begin) - y, ray.dy);
            // Along the border of a spline its monomials leave some rounding, perhaps below zero.
            if (std::abs(along.integral(end - begin)) < kRounding * cell.largest() * (end - begin))
              return;
            Piece piece = zonedPiece(along, *part.zone, height + begin * rise, rise, begin, end);
            for (int c = 0; c < 3; ++c) piece.emission[c] = piece.extinction * options_.color[c];
            pieces[i].push_back(piece);
          });
  }
}

void FogMedium::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  std::vector<Piece> found;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    pieces(segments.subspan(i, 1), {&found, 1});
    depths[i] = 0;
    for (const Piece& piece : found) depths[i] += pieceOpticalDepth(piece);
  }
}

void FogMedium::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  std::vector<double> depths(segments.size());
  if (top_ || !levels_->fits()) {
    opticalDepth(segments, depths);
  } else {
    marchDepths(*this, segments, depths);
  }
  for (std::size_t i = 0; i < segments.size(); ++i) {
    out[i].emitted = options_.color * -std::expm1(-depths[i]);
    out[i].transmittance = std::exp(-depths[i]);
  }
}

std::vector<double> FogMedium::coefficients() const {
  return levels_->map().c;
}

FogMedium FogMedium::withCoefficients(std::span<const double> coefficients) const {
  SplineGrid map(levels_->columns(), levels_->rows());
  map.c.assign(coefficients.begin(), coefficients.end());
  return withLevels(std::make_shared<const FogLevels>(map, options_.degree, options_.levels,
                                                      options_.restriction));
}

FogMedium FogMedium::shifted(const Vec3& by) const {
  FogMedium fog = *this;
  fog.origin_ += by;
  return fog;
}

FogMedium FogMedium::finest() const {
  FogMedium fog = *this;
  fog.options_.detail = {};
  return fog;
}

FogMedium FogMedium::withProfile(const FogProfile& profile) const {
  FogMedium fog = *this;
  fog.profile_ = profile;
  return fog;
}

FogMedium FogMedium::withLevels(std::shared_ptr<const FogLevels> levels) const {
  FogMedium fog = *this;
  fog.levels_ = std::move(levels);
  return fog;
}

}  // namespace volute
