// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "puffs/puff.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/media/field_members.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

class PuffSnapshot final : public MediumSnapshot {
 public:
  explicit PuffSnapshot(const Puff& puff) : puff_(puff) {}

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

  Result<std::shared_ptr<const MediumSnapshot>> at(const SnapshotRequest& request,
                                                   Progress&) override {
    Puff now = at(request.time);
    now.density *= request.factor;
    return std::make_shared<const PuffSnapshot>(now);
  }

 private:
  Puff at(double time) const {
    Puff now = puff_;
    now.radius += growth_ * time;
    return now;
  }

  Puff puff_;
  double growth_;
};

struct PuffSaid {
  Puff puff;
  Rgb albedo = Rgb::Zero();
  double growth = 0;
};

class PuffKind final : public MediumKind {
 public:
  const FieldTable& fields() const override {
    // clang-format off: a row is read as one
    static const FieldRow kFields[] = {
        {.name = "centre", .type = FieldType::kPoint, .access = member<&PuffSaid::puff, &Puff::centre>(),
         .help = "its middle", .unit = "m", .slider = {.label = "centre"}},
        {.name = "radius", .access = member<&PuffSaid::puff, &Puff::radius>(), .help = "at 0 s",
         .unit = "m", .least = 1e-3, .slider = {.label = "radius", .least = 0.1, .most = 10}},
        {.name = "density", .access = member<&PuffSaid::puff, &Puff::density>(),
         .help = "extinction of its middle", .unit = "1/m", .least = 0,
         .slider = {.label = "density", .most = 10, .logarithmic = true}},
        {.name = "albedo", .type = FieldType::kColor, .access = member<&PuffSaid::albedo>(),
         .help = "share of light that it scatters", .least = 0, .most = 1},
        {.name = "growth", .access = member<&PuffSaid::growth>(), .help = "of its radius",
         .unit = "m/s", .least = 0}};
    // clang-format on
    static const FieldTable kTable = fieldTable<PuffSaid>({.name = "puff",
                                                           .sentence = "a round cloud",
                                                           .fields = kFields,
                                                           .kind = "puff",
                                                           .thing = "a puff",
                                                           .things = "puffs"});
    return kTable;
  }

  Result<std::shared_ptr<SceneMedium>> open(const Json& entry,
                                            MediumContext& context) const override {
    VOLUTE_ASSIGN(auto said, readAs<PuffSaid>(fields(), entry, {context.file, context.path}));
    said.puff.source = said.albedo * context.lights.ambient;
    return std::make_shared<PuffInTime>(said.puff, said.growth, context.file);
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

void Puff::pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
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
