// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_picture.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <set>

#include "volute/base/assert.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/write_file.hpp"
#include "volute/image/colormap.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/image_file.hpp"
#include "volute/report/canvas.hpp"

namespace volute {
namespace {

constexpr double kLeft = 92, kTop = 62, kBottom = 108, kBar = 160, kPlain = 40, kRow = 26;
constexpr std::size_t kMaxLevels = 24;  ///< that a key shows one by one
constexpr double kMinLine = 0.2;        ///< of an underlay that is drawn [pixels]
constexpr double kMinWall = 2.5;        ///< pixels across a thin wall

/// A colour as displays show it, as linear light.
Rgb linear(const Rgb& display) {
  return Rgb(srgbDecode(display[0]), srgbDecode(display[1]), srgbDecode(display[2]));
}

Rgb grey(double display) {
  return linear(Rgb::Constant(display));
}

const Rgb kSignColor(0.72, 0.03, 0.03);
const Rgb kRouteColor(0.03, 0.16, 0.62);
const Rgb kHatchColor(0.05, 0.22, 0.6);
const Rgb kOpenColor(0.0, 0.35, 0.75);
const Rgb kWallColor(0.008, 0.008, 0.008);
const Rgb kDoorColor(0.75, 0.25, 0.0);

Rgb colorOf(PlanMark mark) {
  switch (mark) {
    case PlanMark::kSolid:
      return grey(0.42);
    case PlanMark::kHidden:
      return grey(0.93);
    case PlanMark::kLost:
      return grey(0.66);
    case PlanMark::kKept:
    case PlanMark::kUnknown:
      return Rgb::Ones();
    default:
      return grey(0.97);
  }
}

/// A square of a map, or of its key.
void drawMark(Canvas& canvas, PlanMark mark, double x0, double y0, double x1, double y1) {
  canvas.rect(x0, y0, x1, y1, colorOf(mark));
  if (mark == PlanMark::kKept)
    canvas.hatch(x0, y0, x1, y1, kHatchColor);
  if (mark == PlanMark::kUnknown) {
    canvas.hatch(x0, y0, x1, y1, grey(0.45));
    canvas.hatch(x0, y0, x1, y1, grey(0.45), true);
  }
}

double niceStep(double range, int most) {
  const double rough = range / most;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough * (1 - 1e-9))
      return factor * power;
  }
  return 10 * power;
}

std::string tickText(double value) {
  return fmt::format("{:.10g}", std::abs(value) < 1e-9 ? 0.0 : std::round(value * 1e6) / 1e6);
}

/// From metres to pixels.
struct Frame {
  const FloorPlan& plan;
  double scale;

  double width() const { return plan.nx * scale; }

  double height() const { return plan.ny * scale; }

  double x(double metres) const {
    return kLeft + ((metres - plan.origin[0]) / plan.step + 0.5) * scale;
  }

  double y(double metres) const {
    return kTop + height() - ((metres - plan.origin[1]) / plan.step + 0.5) * scale;
  }

  Vec2 at(double x0, double y0) const { return {x(x0), y(y0)}; }

  double from(int axis) const { return plan.origin[axis] - 0.5 * plan.step; }

  double size(int axis) const { return plan.step * (axis == 0 ? plan.nx : plan.ny); }
};

/// The different values that the map has, ascending; empty: too many to be told apart.
std::vector<double> levelsOf(const PlanPicture& picture) {
  std::set<double> levels;
  if (!picture.stored || picture.barLabel.empty() || !picture.kinds.empty())
    return {};
  for (std::size_t i = 0; i < picture.values.size(); ++i) {
    if (picture.marks[i] == PlanMark::kValue)
      levels.insert(picture.values[i]);
    if (levels.size() > kMaxLevels)
      return {};
  }
  return {levels.begin(), levels.end()};
}

/// One map on one canvas.
class PlanDrawing {
 public:
  PlanDrawing(const FloorPlan& plan, const PlanPicture& picture, std::span<const SightTarget> signs,
              std::span<const Route> routes)
      : picture_(picture), signs_(signs), routes_(routes), frame_{plan, scaleOf(plan)} {
    levels_ = levelsOf(picture);
    bar_ = !picture.barLabel.empty() && picture.kinds.empty() &&
           std::ranges::find(picture.marks, PlanMark::kValue) != picture.marks.end();
    findExtent();
    findLooks();
    findRows();
    width_ = kLeft + frame_.width() + (bar_ ? kBar : kPlain);
    for (const auto* text : {&picture.title, &picture.subtitle})
      width_ = std::max(width_, kLeft + canvasTextWidth(*text) + kPlain);
    for (const Row& row : rows_)
      width_ = std::max(width_, kLeft + 42 + canvasTextWidth(row.words) + kPlain);
    legend_ = kTop + std::max(frame_.height(), bar_ ? 120.0 : 0.0) + kBottom;
    height_ = legend_ + kRow * static_cast<double>(rows_.size()) + 6;
  }

  double width() const { return std::ceil(width_); }

  double height() const { return std::ceil(height_); }

  void draw(Canvas& canvas) const {
    canvas.rect(0, 0, width(), height(), Rgb::Ones());
    canvas.text(picture_.title, kLeft, 12, grey(0));
    canvas.text(picture_.subtitle, kLeft, 36, grey(0.3));
    drawCells(canvas);
    clearOutside(canvas);
    if (picture_.underlay)
      drawUnderlay(canvas, *picture_.underlay);
    drawShapes(canvas);
    drawRoutes(canvas);
    drawAxes(canvas);
    drawSigns(canvas);
    drawLabels(canvas);
    drawScale(canvas);
    if (picture_.north)
      drawNorth(canvas, *picture_.north);
    if (bar_)
      drawKey(canvas);
    drawLegend(canvas);
  }

 private:
  /// A line of the legend, and what its swatch is.
  struct Row {
    std::function<void(Canvas&, double y)> swatch;
    std::string words;
  };

  static double scaleOf(const FloorPlan& plan) {
    constexpr int kWide = 900, kHigh = 640;
    return std::clamp(std::min(kWide / plan.nx, kHigh / plan.ny), 1, 64);
  }

  static void square(Canvas& canvas, double y, const Rgb& color) {
    canvas.rect(kLeft - 1, y - 1, kLeft + 31, y + 17, grey(0.1));
    canvas.rect(kLeft, y, kLeft + 30, y + 16, color);
  }

  bool has(PlanShape::Kind kind) const {
    return std::ranges::any_of(picture_.shapes,
                               [&](const PlanShape& shape) { return shape.kind == kind; });
  }

  void findRows() {
    for (const auto& [color, words] : picture_.kinds) {
      if (!words.empty())
        rows_.push_back(
            {[color = linear(color)](Canvas& c, double y) { square(c, y, color); }, words});
    }
    for (const auto& [mark, words] : picture_.words) {
      if (std::ranges::find(picture_.marks, mark) == picture_.marks.end() ||
          (mark == PlanMark::kSolid && has(PlanShape::Kind::kSolid)))
        continue;  // walls are drawn over it
      rows_.push_back({[mark](Canvas& c, double y) {
                         square(c, y, colorOf(mark));
                         drawMark(c, mark, kLeft, y, kLeft + 30, y + 16);
                       },
                       words});
    }
    const auto line = [&](const Rgb& color, double width, bool dashed, std::string words) {
      rows_.push_back({[=](Canvas& c, double y) {
                         c.line({kLeft, y + 8}, {kLeft + 30, y + 8}, width, color, dashed);
                       },
                       std::move(words)});
    };
    if (has(PlanShape::Kind::kSolid) || has(PlanShape::Kind::kBorder))
      line(kWallColor, 5, false, "wall or obstruction at this height");
    if (has(PlanShape::Kind::kDoor))
      line(kDoorColor, 2.5, true, "open now, shut at other times");
    if (has(PlanShape::Kind::kOpening))
      line(kOpenColor, 2.5, true, "open to the outside");
    if (!signs_.empty()) {
      rows_.push_back(
          {[](Canvas& c, double y) { drawSign(c, Vec2(kLeft + 6, y + 8), Vec2(1, 0), 7); },
           "sign, and where it faces"});
    }
    if (!routes_.empty())
      line(kRouteColor, 3, false, "route, from its square");
  }

  Rgb valueColor(double value) const {
    if (!picture_.kinds.empty()) {
      const auto kind = static_cast<std::size_t>(std::max(value, 0.0));
      return linear(picture_.kinds[std::min(kind, picture_.kinds.size() - 1)].first);
    }
    double share = (value - picture_.low) / (picture_.high - picture_.low);
    if (!levels_.empty()) {
      const auto place = std::ranges::lower_bound(levels_, value) - levels_.begin();
      share = levelShare(static_cast<std::size_t>(place));
    }
    return linear(displayColor(ColorMap::kViridis, share));
  }

  double levelShare(std::size_t level) const {
    return levels_.size() < 2
               ? 0.5
               : static_cast<double>(level) / static_cast<double>(levels_.size() - 1);
  }

  /// Runs of one look at a time.
  void drawCells(Canvas& canvas) const {
    const FloorPlan& plan = frame_.plan;
    const auto nx = static_cast<std::size_t>(plan.nx);
    const auto alike = [&](std::size_t a, std::size_t b) {
      a = looks_[a], b = looks_[b];
      return picture_.marks[a] == picture_.marks[b] &&
             (picture_.marks[a] != PlanMark::kValue ||
              (valueColor(picture_.values[a]) == valueColor(picture_.values[b])).all());
    };
    for (std::size_t y = 0; y < static_cast<std::size_t>(plan.ny); ++y) {
      const double top = kTop + (plan.ny - 1 - static_cast<double>(y)) * frame_.scale;
      for (std::size_t x = 0; x < nx;) {
        const std::size_t i = y * nx + x;
        std::size_t end = x + 1;
        while (end < nx && alike(i, y * nx + end)) ++end;
        const double left = kLeft + static_cast<double>(x) * frame_.scale;
        const double right = kLeft + static_cast<double>(end) * frame_.scale;
        const PlanMark mark = picture_.marks[looks_[i]];
        if (mark == PlanMark::kValue)
          canvas.rect(left, top, right, top + frame_.scale, valueColor(picture_.values[looks_[i]]));
        else
          drawMark(canvas, mark, left, top, right, top + frame_.scale);
        x = end;
      }
    }
  }

  /// Which square's look each square has: its own, but of one whose middle is in a wall that of a
  /// neighbour, so that walls alone are dark and not what is left of the squares that they cut.
  void findLooks() {
    const auto nx = static_cast<std::size_t>(frame_.plan.nx);
    const auto ny = static_cast<std::size_t>(frame_.plan.ny);
    looks_.resize(picture_.marks.size());
    for (std::size_t i = 0; i < looks_.size(); ++i) looks_[i] = i;
    const auto inWall = [&](std::size_t i) {
      const Vec3 at = frame_.plan.at(i);
      return std::ranges::any_of(picture_.shapes, [&](const PlanShape& shape) {
        return shape.kind == PlanShape::Kind::kSolid &&
               (at.head<2>() - shape.min).minCoeff() >= 0 &&
               (shape.max - at.head<2>()).minCoeff() >= 0;
      });
    };
    for (std::size_t i = 0; i < looks_.size(); ++i) {
      if (picture_.marks[i] != PlanMark::kSolid || !inWall(i))
        continue;
      const std::size_t x = i % nx, y = i / nx;
      for (const auto& [there, next] : {std::pair(x > 0, i - 1), std::pair(x + 1 < nx, i + 1),
                                        std::pair(y > 0, i - nx), std::pair(y + 1 < ny, i + nx)}) {
        if (there && picture_.marks[next] != PlanMark::kSolid) {
          looks_[i] = next;
          break;
        }
      }
    }
  }

  /// Where the border is that is known, in pixels; else the plan's squares.
  void findExtent() {
    Vec2 least = Vec2::Constant(std::numeric_limits<double>::infinity()), most = -least;
    for (const PlanShape& shape : picture_.shapes) {
      if (shape.kind != PlanShape::Kind::kBorder && shape.kind != PlanShape::Kind::kOpening)
        continue;
      least = least.cwiseMin(shape.min);
      most = most.cwiseMax(shape.max);
    }
    left_ = kLeft, right_ = kLeft + frame_.width();
    top_ = kTop, bottom_ = kTop + frame_.height();
    if (!((most - least).minCoeff() > 0))
      return;
    left_ = std::clamp(frame_.x(least.x()), left_, right_);
    right_ = std::clamp(frame_.x(most.x()), left_, right_);
    top_ = std::clamp(frame_.y(most.y()), top_, bottom_);
    bottom_ = std::clamp(frame_.y(least.y()), top_, bottom_);
  }

  /// Squares at the plan's end reach over the border that is known.
  void clearOutside(Canvas& canvas) const {
    const double left = kLeft, right = kLeft + frame_.width();
    const double top = kTop, bottom = kTop + frame_.height();
    if (right_ < right)
      canvas.rect(right_, top, right, bottom, Rgb::Ones());
    if (left_ > left)
      canvas.rect(left, top, left_, bottom, Rgb::Ones());
    if (top_ > top)
      canvas.rect(left, top, right, top_, Rgb::Ones());
    if (bottom_ < bottom)
      canvas.rect(left, bottom_, right, bottom, Rgb::Ones());
  }

  void drawUnderlay(Canvas& canvas, const PlanUnderlay& underlay) const {
    if (underlay.picture.width > 0)
      drawInk(canvas, underlay);
    const Vec2 low(kLeft, kTop), high = low + Vec2(frame_.width(), frame_.height());
    for (const auto& [from, to] : underlay.lines) {
      const auto part =
          lineWithin(frame_.at(from.x(), from.y()), frame_.at(to.x(), to.y()), low, high);
      if (part && (part->second - part->first).norm() > kMinLine)
        canvas.line(part->first, part->second, 1.2, grey(0.25));
    }
  }

  /// What is as good as white lets the map through.
  void drawInk(Canvas& canvas, const PlanUnderlay& underlay) const {
    constexpr float kWhite = 0.85F;
    const Image& image = underlay.picture;
    const double dx = (frame_.x(underlay.max.x()) - frame_.x(underlay.min.x())) / image.width;
    const double dy = (frame_.y(underlay.min.y()) - frame_.y(underlay.max.y())) / image.height;
    const double left = frame_.x(underlay.min.x()), top = frame_.y(underlay.max.y());
    const auto ink = [&](int x, int y) {
      for (int c = 0; c < image.channels && c < 3; ++c) {
        if (image.at(x, y, c) < kWhite)
          return true;
      }
      return false;
    };
    for (int y = 0; y < image.height; ++y) {
      const double begin = top + dy * y;
      if (begin < kTop || begin + dy > kTop + frame_.height())
        continue;
      for (int x = 0; x < image.width;) {
        int end = x + 1;
        if (!ink(x, y)) {
          x = end;
          continue;
        }
        while (end < image.width && ink(end, y)) ++end;
        const double from = std::max(left + dx * x, kLeft);
        const double to = std::min(left + dx * end, kLeft + frame_.width());
        if (from < to)
          canvas.rect(from, begin, to, begin + dy, grey(0.25));
        x = end;
      }
    }
  }

  /// A rectangle as lines around it; a flat one as one line.
  void outline(Canvas& canvas, const PlanShape& shape, double width, const Rgb& color) const {
    const Vec2 a = frame_.at(shape.min.x(), shape.min.y()),
               c = frame_.at(shape.max.x(), shape.max.y());
    const Vec2 b(c.x(), a.y()), d(a.x(), c.y());
    if (std::abs(a.x() - c.x()) < 1 || std::abs(a.y() - c.y()) < 1) {
      canvas.line(a, c, width, color, true);
      return;
    }
    for (const auto& [from, to] : {std::pair(a, b), {b, c}, {c, d}, {d, a}})
      canvas.line(from, to, width, color, true);
  }

  void drawShapes(Canvas& canvas) const {
    const double left = kLeft, right = kLeft + frame_.width();
    const double top = kTop, bottom = kTop + frame_.height();
    const auto solid = [&](const PlanShape& shape) {
      double x0 = frame_.x(shape.min.x()), x1 = frame_.x(shape.max.x());
      double y0 = frame_.y(shape.max.y()), y1 = frame_.y(shape.min.y());
      if (x1 - x0 < kMinWall)
        x0 -= 0.5 * (kMinWall - (x1 - x0)), x1 = x0 + kMinWall;
      if (y1 - y0 < kMinWall)
        y0 -= 0.5 * (kMinWall - (y1 - y0)), y1 = y0 + kMinWall;
      x0 = std::max(x0, left - kMinWall), x1 = std::min(x1, right + kMinWall);
      y0 = std::max(y0, top - kMinWall), y1 = std::min(y1, bottom + kMinWall);
      if (x0 < x1 && y0 < y1)
        canvas.rect(x0, y0, x1, y1, kWallColor);
    };
    for (const PlanShape& shape : picture_.shapes) {
      if (shape.kind == PlanShape::Kind::kSolid || shape.kind == PlanShape::Kind::kBorder)
        solid(shape);
    }
    for (const PlanShape& shape : picture_.shapes) {
      if (shape.kind == PlanShape::Kind::kDoor)
        outline(canvas, shape, 2, kDoorColor);
      if (shape.kind == PlanShape::Kind::kOpening)
        outline(canvas, shape, 3, kOpenColor);
    }
  }

  void drawRoutes(Canvas& canvas) const {
    for (const Route& route : routes_) {
      for (std::size_t i = 1; i < route.points.size(); ++i) {
        canvas.line(frame_.at(route.points[i - 1][0], route.points[i - 1][1]),
                    frame_.at(route.points[i][0], route.points[i][1]), 3, kRouteColor);
      }
      const Vec2 at = frame_.at(route.points[0][0], route.points[0][1]);
      canvas.rect(at.x() - 5, at.y() - 5, at.x() + 6, at.y() + 6, kRouteColor);
    }
  }

  void drawAxes(Canvas& canvas) const {
    const Rgb ink = grey(0.1);
    const double bottom = bottom_, right = right_;
    for (const double y : {top_ - 1, bottom}) canvas.rect(left_ - 1, y, right + 1, y + 1, ink);
    for (const double x : {left_ - 1, right}) canvas.rect(x, top_ - 1, x + 1, bottom + 1, ink);
    for (int axis = 0; axis < 2; ++axis) {
      const double pixels = axis == 0 ? frame_.width() : frame_.height();
      const double step = niceStep(frame_.size(axis), std::max(2, static_cast<int>(pixels / 90)));
      const double end = frame_.from(axis) + frame_.size(axis) * (1 + 1e-9);
      for (double at = std::ceil(frame_.from(axis) / step - 1e-9) * step; at <= end; at += step) {
        const std::string text = tickText(at);
        if (axis == 0 ? frame_.x(at) > right + 1 || frame_.x(at) < left_ - 1
                      : frame_.y(at) > bottom + 1 || frame_.y(at) < top_ - 1)
          continue;
        if (axis == 0) {
          const double x = std::round(frame_.x(at));
          canvas.rect(x, bottom, x + 1, bottom + 6, ink);
          canvas.text(text, x, bottom + 9, ink, Canvas::Anchor::kMiddle);
        } else {
          const double y = std::round(frame_.y(at));
          canvas.rect(left_ - 6, y, left_, y + 1, ink);
          canvas.text(text, left_ - 10, y - 7, ink, Canvas::Anchor::kEnd);
        }
      }
    }
    canvas.text("x [m]", kLeft + frame_.width() / 2, bottom + 32, ink, Canvas::Anchor::kMiddle);
    canvas.textUpwards("y [m]", 10, kTop + frame_.height() / 2, ink);
  }

  /// A bar of a round length, in two parts.
  void drawScale(Canvas& canvas) const {
    const double length = niceStep(frame_.size(0), 5);
    const double pixels = length / frame_.plan.step * frame_.scale;
    const double y = kTop + frame_.height() + 66;
    canvas.rect(kLeft - 1, y - 1, kLeft + pixels + 1, y + 9, grey(0.1));
    canvas.rect(kLeft + 0.5 * pixels, y, kLeft + pixels, y + 8, Rgb::Ones());
    canvas.text(fmt::format("{:g} m", length), kLeft + pixels + 10, y - 4, grey(0.1));
  }

  /// A needle at the right, below the map, and N before its tip.
  void drawNorth(Canvas& canvas, double degrees) const {
    constexpr double kLength = 40;
    const double angle = degrees * std::numbers::pi / 180;
    const Vec2 way(std::sin(angle), -std::cos(angle)), aside(-way.y(), way.x());
    const Vec2 middle(kLeft + frame_.width() - 30, kTop + frame_.height() + 66);
    const Vec2 tip = middle + 0.5 * kLength * way, notch = middle - 0.3 * kLength * way;
    const Vec2 back = middle - 0.5 * kLength * way;
    canvas.triangle(tip, Vec2(back + 0.3 * kLength * aside), notch, grey(0.1));
    canvas.triangle(tip, notch, Vec2(back - 0.3 * kLength * aside), grey(0.6));
    const Vec2 letter = middle + (0.5 * kLength + 11) * way;
    canvas.text("N", letter.x(), letter.y() - 0.5 * kCanvasTextHeight, grey(0.1),
                Canvas::Anchor::kMiddle);
  }

  /// Levels one by one, or a bar.
  void drawKey(Canvas& canvas) const {
    constexpr double kWidth = 22;
    const Rgb ink = grey(0.1);
    const double left = kLeft + frame_.width() + 28;
    const double height = std::max(frame_.height(), 120.0), bottom = kTop + height;
    if (levels_.empty()) {
      canvas.textUpwards(picture_.barLabel, left + kWidth + 78, kTop + height / 2, ink);
    } else {
      const double room = height - kCanvasTextHeight - 6;
      const double each = std::min(room / static_cast<double>(levels_.size()), 36.0);
      canvas.text(picture_.barLabel, left,
                  bottom - each * static_cast<double>(levels_.size()) - kCanvasTextHeight - 6, ink);
      const auto every = static_cast<std::size_t>(std::ceil((kCanvasTextHeight + 2) / each));
      for (std::size_t i = 0; i < levels_.size(); ++i) {
        const double y = bottom - each * static_cast<double>(i + 1);
        canvas.rect(left, y, left + kWidth, y + each - (each > 6 ? 2 : 0), valueColor(levels_[i]));
        if (i % every == 0)
          canvas.text(plainNumber(levels_[i], 4), left + kWidth + 10, y + 0.5 * each - 8, ink);
      }
      return;
    }
    constexpr int kSteps = 128;
    for (int i = 0; i < kSteps; ++i) {
      const double share = (i + 0.5) / kSteps;
      canvas.rect(left, bottom - height * (i + 1) / kSteps, left + kWidth,
                  bottom - height * i / kSteps, linear(displayColor(ColorMap::kViridis, share)));
    }
    const double range = picture_.high - picture_.low;
    const double step = niceStep(range, std::max(2, static_cast<int>(height / 50)));
    for (double at = std::ceil(picture_.low / step - 1e-9) * step;
         at <= picture_.high + 1e-9 * range; at += step) {
      const double y = std::round(bottom - (at - picture_.low) / range * height);
      const bool top = at > picture_.high - 1e-6 * range;
      canvas.rect(left + kWidth, y, left + kWidth + 6, y + 1, ink);
      canvas.text(tickText(at) + (top && picture_.highIsMore ? "+" : ""), left + kWidth + 10, y - 7,
                  ink);
    }
  }

  /// A bar along the sign's face, and an arrow where it faces.
  static void drawSign(Canvas& canvas, const Vec2& at, const Vec2& facing, double half) {
    const Vec2 along(-facing.y(), facing.x());
    const Vec2 tip = at + 20 * facing, neck = at + 12 * facing;
    canvas.line(at - half * along, at + half * along, 5, kSignColor);
    canvas.line(at, neck, 2.5, kSignColor);
    canvas.triangle(tip, neck + 5 * along, neck - 5 * along, kSignColor);
  }

  void drawSigns(Canvas& canvas) const {
    constexpr std::size_t kMaxNames = 24;
    constexpr double kRowOfNames = kCanvasTextHeight + 6;
    std::vector<std::pair<Vec2, double>> names;  // corners and widths
    for (const SightTarget& target : signs_) {
      const SafetySign& sign = target.sign;
      const Vec2 at = frame_.at(sign.position[0], sign.position[1]);
      Vec2 facing(sign.normal[0], -sign.normal[1]);
      const double level = facing.norm();
      if (level > 1e-6)
        facing /= level;
      const double half = std::max(9.0, 0.5 * sign.size[0] / frame_.plan.step * frame_.scale);
      if (level > 1e-6)
        drawSign(canvas, at, facing, half);
      else
        canvas.rect(at.x() - 6, at.y() - 6, at.x() + 6, at.y() + 6, kSignColor);
      if (signs_.size() > kMaxNames)
        continue;
      // Behind the sign where there is room, else before its arrow; on a ground of its own.
      const double wide = canvasTextWidth(sign.name);
      Vec2 place = at + 24 * facing + Vec2(facing.x() >= 0 ? 2 : -wide - 2, -8);
      if (std::abs(facing.y()) > 0.7)
        place = at + Vec2(-0.5 * wide, facing.y() > 0 ? 24 : -40);
      place.x() =
          std::clamp(place.x(), kLeft + 2, std::max(kLeft + 2, kLeft + frame_.width() - wide - 4));
      place.y() = std::clamp(place.y(), kTop + 2,
                             std::max(kTop + 2, kTop + frame_.height() - kCanvasTextHeight - 2));
      // Names of signs at one place stand below each other, or above.
      const auto isFree = [&](const Vec2& corner) {
        return corner.y() >= kTop && corner.y() <= kTop + frame_.height() - kCanvasTextHeight &&
               std::ranges::none_of(names, [&](const auto& other) {
                 return std::abs(other.first.y() - corner.y()) < kRowOfNames - 1 &&
                        corner.x() < other.first.x() + other.second + 6 &&
                        other.first.x() < corner.x() + wide + 6;
               });
      };
      const Vec2 wanted = place;
      for (std::size_t row = 1; !isFree(place) && row <= 2 * kMaxNames; ++row) {
        const double rows = static_cast<double>((row + 1) / 2) * (row % 2 != 0 ? 1 : -1);
        const Vec2 other = wanted + Vec2(0, rows * kRowOfNames);
        if (isFree(other))
          place = other;
      }
      names.emplace_back(place, wide);
      canvas.rect(place.x() - 3, place.y() - 3, place.x() + wide + 3,
                  place.y() + kCanvasTextHeight + 2, Rgb::Ones());
      canvas.text(sign.name, place.x(), place.y(), kSignColor);
    }
  }

  /// Squares in which something solid stands, thin walls too.
  std::vector<char> solidSquares() const {
    const FloorPlan& plan = frame_.plan;
    std::vector<char> solid(plan.size(), 0);
    const auto square = [&](double metres, int axis, int count) {
      const double at = (metres - frame_.from(axis)) / plan.step;
      return static_cast<int>(std::clamp(std::floor(at), 0.0, count - 1.0));
    };
    for (const PlanShape& shape : picture_.shapes) {
      if (shape.kind != PlanShape::Kind::kSolid && shape.kind != PlanShape::Kind::kBorder)
        continue;
      for (int y = square(shape.min.y(), 1, plan.ny); y <= square(shape.max.y(), 1, plan.ny); ++y) {
        for (int x = square(shape.min.x(), 0, plan.nx); x <= square(shape.max.x(), 0, plan.nx); ++x)
          solid[static_cast<std::size_t>(y) * plan.nx + x] = 1;
      }
    }
    return solid;
  }

  /// Where a text of this size hides the least of walls and of what looks otherwise than `place`,
  /// as near to that as can be.
  Vec2 roomFor(const Vec2& place, double width, double height,
               const std::vector<char>& solid) const {
    const FloorPlan& plan = frame_.plan;
    const Vec2 wanted = (place - plan.origin.head<2>()) / plan.step;
    const double halfX = 0.5 * width / frame_.scale, halfY = 0.5 * height / frame_.scale;
    const auto at = [&](int x, int y) { return static_cast<std::size_t>(y) * plan.nx + x; };
    const std::size_t own =
        at(std::clamp(static_cast<int>(std::lround(wanted.x())), 0, plan.nx - 1),
           std::clamp(static_cast<int>(std::lround(wanted.y())), 0, plan.ny - 1));
    const auto isOwn = [&](int x, int y) {
      return !solid[at(x, y)] && picture_.marks[at(x, y)] == picture_.marks[own] &&
             picture_.values[at(x, y)] == picture_.values[own];
    };
    // How many of its own lie below and to the left of a corner.
    std::vector<int> before(static_cast<std::size_t>(plan.nx + 1) * (plan.ny + 1), 0);
    const auto below = [&](int x, int y) -> int& {
      return before[static_cast<std::size_t>(std::clamp(y, 0, plan.ny)) * (plan.nx + 1) +
                    std::clamp(x, 0, plan.nx)];
    };
    for (int y = 0; y < plan.ny; ++y) {
      for (int x = 0; x < plan.nx; ++x)
        below(x + 1, y + 1) = below(x, y + 1) + below(x + 1, y) - below(x, y) + isOwn(x, y);
    }
    Vec2 best = wanted;
    std::pair<int, double> least{std::numeric_limits<int>::max(), 0};
    for (int y = 0; y < plan.ny; ++y) {
      for (int x = 0; x < plan.nx; ++x) {
        if (!isOwn(x, y))
          continue;
        const int left = static_cast<int>(std::floor(x + 0.5 - halfX)),
                  right = static_cast<int>(std::ceil(x + 0.5 + halfX)),
                  low = static_cast<int>(std::floor(y + 0.5 - halfY)),
                  high = static_cast<int>(std::ceil(y + 0.5 + halfY));
        const int shown =
            below(right, high) - below(left, high) - below(right, low) + below(left, low);
        const std::pair<int, double> cost{(right - left) * (high - low) - shown,
                                          (Vec2(x, y) - wanted).squaredNorm()};
        if (cost < least)
          least = cost, best = Vec2(x, y);
      }
    }
    return best * plan.step + plan.origin.head<2>();
  }

  void drawLabels(Canvas& canvas) const {
    const std::vector<char> solid = solidSquares();
    for (const auto& [wanted, text] : picture_.labels) {
      const double half = 0.5 * canvasTextWidth(text);
      const Vec2 place = roomFor(wanted, 2 * half, kCanvasTextHeight, solid);
      const Vec2 at = frame_.at(place.x(), place.y());
      const double x =
          std::clamp(at.x(), kLeft + half, std::max(kLeft + half, kLeft + frame_.width() - half));
      canvas.text(text, x, at.y() - 0.5 * kCanvasTextHeight, grey(0), Canvas::Anchor::kMiddle);
    }
  }

  void drawLegend(Canvas& canvas) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const double y = legend_ + static_cast<double>(i) * kRow;
      rows_[i].swatch(canvas, y);
      canvas.text(rows_[i].words, kLeft + 42, y + 1, grey(0.1));
    }
  }

  const PlanPicture& picture_;
  std::span<const SightTarget> signs_;
  std::span<const Route> routes_;
  Frame frame_;
  std::vector<double> levels_;
  std::vector<std::size_t> looks_;                      // of each square
  double left_ = 0, right_ = 0, top_ = 0, bottom_ = 0;  // of what is known, in pixels
  bool bar_ = false;
  std::vector<Row> rows_;
  double width_ = 0, height_ = 0, legend_ = 0;
};

}  // namespace

std::vector<PlanMark> emptyMarks(const FloorPlan& plan) {
  std::vector<PlanMark> marks(plan.size(), PlanMark::kUnknown);
  for (std::size_t i = 0; i < std::min(marks.size(), plan.places.size()); ++i) {
    if (plan.places[i] == Place::kSolid)
      marks[i] = PlanMark::kSolid;
  }
  return marks;
}

std::vector<SightTarget> signsOfStorey(const SightSnapshot& snapshot,
                                       std::span<const SightTarget> signs, double height) {
  constexpr double kNear = 1.5;  // [m]: no floor lies between, furniture may
  std::vector<SightTarget> shown;
  for (const SightTarget& sign : signs) {
    const Vec3 below(sign.target.x(), sign.target.y(), height);
    bool apart = false;
    if (std::abs(sign.target.z() - height) > kNear) {
      const SightLine line{below, sign.target};
      Sight sight;
      snapshot.look({&line, 1}, {&sight, 1});
      apart = sight.blocked;
    }
    if (!apart)
      shown.push_back(sign);
  }
  return shown;
}

Image drawPlan(const FloorPlan& plan, const PlanPicture& picture,
               std::span<const SightTarget> signs, std::span<const Route> routes) {
  const PlanDrawing drawing(plan, picture, signs, routes);
  Image image(static_cast<int>(drawing.width()), static_cast<int>(drawing.height()), 3);
  drawing.draw(*imageCanvas(image));
  return image;
}

std::string planSvg(const FloorPlan& plan, const PlanPicture& picture,
                    std::span<const SightTarget> signs, std::span<const Route> routes) {
  const PlanDrawing drawing(plan, picture, signs, routes);
  SvgCanvas canvas(drawing.width(), drawing.height());
  drawing.draw(canvas);
  return canvas.finish();
}

Status writePlan(const std::filesystem::path& file, const FloorPlan& plan,
                 const PlanPicture& picture, std::span<const SightTarget> signs,
                 std::span<const Route> routes) {
  VOLUTE_TRY(writeImage(file, drawPlan(plan, picture, signs, routes)));
  std::filesystem::path vector = file;
  return writeFile(vector.replace_extension(".svg"), planSvg(plan, picture, signs, routes));
}

}  // namespace volute
