// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "puffs/puff.hpp"

#include <cmath>

#include "volute/io/json_members.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

class PuffAt final : public MediumAt {
 public:
  explicit PuffAt(const Puff& puff) : puff_(puff) {}

  void addMedia(std::vector<AnyMedium>& media) const override { media.emplace_back(puff_); }

 private:
  Puff puff_;
};

class PuffInTime final : public SceneMedium {
 public:
  PuffInTime(const Puff& puff, double growth, const std::string& file)
      : puff_(puff), growth_(growth) {
    info_.file = file;
    info_.what = "a puff";
    info_.kind = "puff";
    info_.times = {0, 1, 2};
    info_.numbers = {0, 1, 2};
    info_.interpolates = info_.measured = true;
    info_.bounds = info_.fileBounds = at(2).bounds();
  }

  Result<std::shared_ptr<const MediumAt>> at(const InstantRequest& request, Progress&) override {
    Puff now = at(request.time);
    now.density *= request.factor;
    return std::make_shared<const PuffAt>(now);
  }

  const Puff& puff() const { return puff_; }

 private:
  Puff at(double time) const {
    Puff now = puff_;
    now.radius += growth_ * time;
    return now;
  }

  Puff puff_;
  double growth_;
};

class PuffKind final : public MediumKind {
 public:
  std::string_view name() const override { return "puff"; }

  std::string_view plural() const override { return "puffs"; }

  std::string_view singular() const override { return "a puff"; }

  std::vector<std::string_view> members() const override {
    return {"centre", "radius", "density", "albedo", "growth"};
  }

  std::vector<std::string_view> fileMembers() const override { return {}; }

  Result<std::shared_ptr<SceneMedium>> open(const Json& entry,
                                            MediumContext& context) const override {
    constexpr std::string_view kNames[] = {"kind",    "centre", "radius",
                                           "density", "albedo", "growth"};
    const Members members(entry, context.file, context.path);
    VOLUTE_TRY(members.check(kNames));
    Puff puff;
    double growth = 0;
    Rgb albedo = Rgb::Zero();
    VOLUTE_TRY(members.vector("centre", puff.centre));
    VOLUTE_TRY(members.number("radius", puff.radius, 1e-3));
    VOLUTE_TRY(members.number("density", puff.density, 0));
    VOLUTE_TRY(members.color("albedo", albedo, 1));
    VOLUTE_TRY(members.number("growth", growth, 0));
    puff.source = albedo * context.lights.ambient;
    return std::make_shared<PuffInTime>(puff, growth, context.file);
  }

  void addParameters(ParameterGroup group, const nlohmann::ordered_json&,
                     const SceneMedium& medium, bool) const override {
    const Puff& puff = dynamic_cast<const PuffInTime&>(medium).puff();
    group.point("centre", "centre", puff.centre, "m", 0.01);
    group.range("radius", "radius", puff.radius, 0.1, 10, "m");
    group.amount("density", "density", puff.density, 10, "/m");
  }
};

}  // namespace

Box3 Puff::bounds() const {
  return {centre - Vec3::Constant(radius), centre + Vec3::Constant(radius)};
}

double Puff::extinction(const Vec3& point) const {
  const double inside = 1 - (point - centre).squaredNorm() / (radius * radius);
  return inside > 0 ? density * inside * inside : 0;
}

void Puff::pieces(std::span<const Segment> segments,
                  std::span<std::vector<Piece>> pieces) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    pieces[i].clear();
    const Segment& segment = segments[i];
    const double middle = (centre - segment.origin).dot(segment.direction);
    const double across = radius * radius - (segment.at(middle) - centre).squaredNorm();
    if (!(across > 0))
      continue;
    const double half = std::sqrt(across);
    Piece piece;
    piece.begin = std::max(segment.begin, middle - half);
    piece.end = std::min(segment.end, middle + half);
    if (!(piece.begin < piece.end))
      continue;
    // 1 - r^2 / R^2 = a + b u + c u^2 with u from the piece's begin.
    const double from = piece.begin - middle, square = radius * radius;
    const double a = (across - from * from) / square, b = -2 * from / square, c = -1 / square;
    piece.extinction.c = {density * a * a, density * 2 * a * b, density * (b * b + 2 * a * c),
                          density * 2 * b * c, density * c * c};
    for (int channel = 0; channel < 3; ++channel) {
      for (int k = 0; k < 5; ++k)
        piece.emission[channel].c[k] = source[channel] * piece.extinction.c[k];
    }
    pieces[i].push_back(piece);
  }
}

void Puff::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  std::vector<std::vector<Piece>> all(segments.size());
  pieces(segments, all);
  for (std::size_t i = 0; i < all.size(); ++i) {
    depths[i] = 0;
    for (const Piece& piece : all[i])
      depths[i] += piece.extinction.integral(piece.end - piece.begin);
  }
}

const MediumKind& puffKind() {
  static const PuffKind kind;
  return kind;
}

}  // namespace volute
