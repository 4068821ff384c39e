// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/own_kind.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "volute/base/plain_number.hpp"
#include "volute/io/plugin.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/medium.h"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// An entry's members by their names.
struct OwnMembers {
  nlohmann::json values = nlohmann::json::object();
};

FieldAccess ownMember() {
  return {.owner = typeName<OwnMembers>(),
          .get = [](const FieldRow& field, const void* object) -> FieldValue {
            const auto& values = static_cast<const OwnMembers*>(object)->values;
            return values.value(std::string(field.name), FieldValue());
          },
          .set = [](const FieldRow& field, void* object, const FieldValue& value) -> Status {
            static_cast<OwnMembers*>(object)->values[std::string(field.name)] = value;
            return {};
          }};
}

/// What open() gave.
class OpenedMedium {
 public:
  OpenedMedium(const volute_medium_kind& kind, void* medium) : kind_(kind), medium_(medium) {}

  ~OpenedMedium() {
    if (kind_.close)
      kind_.close(medium_);
  }

  OpenedMedium(const OpenedMedium&) = delete;
  OpenedMedium& operator=(const OpenedMedium&) = delete;

  const volute_medium_kind& kind() const { return kind_; }

  void* medium() const { return medium_; }

  [[noreturn]] void fault(std::string_view what) const {
    throw OwnMediumFault(fmt::format("a medium of kind '{}': {}", kind_.name, what));
  }

  void check(const char* sentence) const {
    if (sentence)
      fault(sentence);
  }

 private:
  volute_medium_kind kind_;
  void* medium_;
};

/// Where pieces of a batch go. A fault is kept: what calls is C.
struct PieceSink {
  std::span<const volute_segment> segments;
  std::span<const std::size_t> numbers;  ///< of these segments in the batch
  std::span<std::vector<Piece>> pieces;
  double factor = 1;
  std::string fault{};
};

bool finite(const volute_piece& piece) {
  const auto all = [](std::span<const double> numbers) {
    return std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
  };
  return all(piece.extinction) && all(piece.emission[0]) && all(piece.emission[1]) &&
         all(piece.emission[2]) && std::isfinite(piece.decay) && std::isfinite(piece.begin);
}

/// The least of a piece's extinction, where that is clearly below 0; a fit may be so a little, and
/// sums by rounding.
std::optional<double> negativeExtinction(const Piece& piece) {
  constexpr double kOvershoot = 0.01;  // of the largest value
  constexpr double kNoDepth = 1e-6;    // an optical depth of no account
  constexpr double kFar = 1e6;         // [m], of pieces without end
  constexpr double kFaded = 40;        // lengths of the decay
  constexpr int kSamples = 16;
  if (std::ranges::all_of(piece.extinction.c, [](double c) { return c >= 0; }))
    return std::nullopt;
  const double length =
      std::min(piece.end - piece.begin,
               piece.decay > 0 ? kFaded / piece.decay : std::numeric_limits<double>::max());
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (int i = 0; i <= (piece.extinction.isConstant() ? 0 : kSamples); ++i) {
    const double u = length * i / kSamples;
    const double value = std::exp(-piece.decay * u) * piece.extinction(u);
    least = std::min(least, value), most = std::max(most, std::abs(value));
  }
  const bool clear = least < -kOvershoot * most && -least * std::min(length, kFar) > kNoDepth;
  return clear ? std::optional(least) : std::nullopt;
}

/// Ends may be off by rounding.
std::string takePiece(PieceSink& sink, const volute_piece& from) {
  constexpr double kRounding = 1e-9;
  if (from.segment >= sink.segments.size()) {
    return fmt::format("a piece is of segment {}; expected 0 to {}", from.segment,
                       sink.segments.size() - 1);
  }
  if (!finite(from))
    return fmt::format("a piece of segment {} has numbers that are not finite", from.segment);
  const volute_segment& segment = sink.segments[from.segment];
  std::vector<Piece>& pieces = sink.pieces[sink.numbers[from.segment]];
  const double before = pieces.empty() ? segment.begin : std::max(segment.begin, pieces.back().end);
  const double room =
      kRounding * (1 + std::abs(from.begin) + (std::isfinite(from.end) ? std::abs(from.end) : 0));
  if (!(from.begin < from.end))
    return fmt::format("a piece from {} to {} m is empty", from.begin, from.end);
  if (from.begin < before - room || from.end > segment.end + room) {
    return fmt::format(
        "a piece from {} to {} m lies outside its segment's {} to {} m or before an earlier one",
        from.begin, from.end, before, segment.end);
  }
  Piece piece{std::max(from.begin, before), std::min(from.end, segment.end), {}, {}, from.decay};
  if (!(piece.begin < piece.end))
    return "";
  for (std::size_t i = 0; i < 4; ++i) {
    piece.extinction.c[i] = sink.factor * from.extinction[i];
    for (std::size_t c = 0; c < 3; ++c) piece.emission[c].c[i] = from.emission[c][i];
  }
  const bool constant =
      piece.extinction.isConstant() && std::ranges::all_of(piece.emission, &Polynomial::isConstant);
  if (std::isinf(piece.end) && !(piece.decay > 0) && !constant)
    return "a piece without end varies, and has no decay";
  if (const auto least = negativeExtinction(piece)) {
    return fmt::format("a piece from {} to {} m has an extinction of {:g}/m; expected at least 0",
                       piece.begin, piece.end, *least / sink.factor);
  }
  if (piece.extinction.isConstant())  // rounding below 0 must not grow along a piece without end
    piece.extinction.c[0] = std::max(piece.extinction.c[0], 0.0);
  pieces.push_back(piece);
  return "";
}

extern "C" void takePieces(void* to, const volute_piece* pieces, std::size_t count) {
  auto& sink = *static_cast<PieceSink*>(to);
  if (!pieces && count > 0 && sink.fault.empty())
    sink.fault = fmt::format("{} pieces at NULL", count);
  for (std::size_t i = 0; i < count && sink.fault.empty(); ++i)
    sink.fault = takePiece(sink, pieces[i]);
}

/// At one time, as rays meet it.
class OwnMedium {
 public:
  OwnMedium(std::shared_ptr<const OpenedMedium> opened, const Box3& bounds, double time,
            double factor)
      : opened_(std::move(opened)), bounds_(bounds), time_(time), factor_(factor) {}

  Box3 bounds() const { return bounds_; }

  double extinction(const Vec3& point) const { return valuesAt(point).extinction; }

  Rgb emission(const Vec3& point) const { return valuesAt(point).emission; }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    for (auto& list : pieces) list.clear();
    const Batch batch(segments);
    if (batch.segments.empty())
      return;
    PieceSink sink{batch.segments, batch.numbers, pieces, factor_};
    opened_->check(kind().pieces(opened_->medium(), time_, batch.segments.data(),
                                 batch.segments.size(), takePieces, &sink));
    if (!sink.fault.empty())
      opened_->fault(sink.fault);
  }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    std::ranges::fill(depths, 0.0);
    if (!kind().optical_depth) {
      std::vector<std::vector<Piece>> all(segments.size());
      pieces(segments, all);
      for (std::size_t i = 0; i < all.size(); ++i) {
        for (const Piece& piece : all[i]) depths[i] += pieceOpticalDepth(piece);
      }
      return;
    }
    const Batch batch(segments);
    std::vector<double> own(batch.segments.size());
    if (own.empty())
      return;
    opened_->check(kind().optical_depth(opened_->medium(), time_, batch.segments.data(), own.size(),
                                        own.data()));
    for (std::size_t i = 0; i < own.size(); ++i) {
      if (!(own[i] >= 0))
        opened_->fault(fmt::format("an optical depth is {}; expected at least 0", own[i]));
      depths[batch.numbers[i]] = factor_ * own[i];
    }
  }

  /// Asked for all segments at once: a call may be one into another language.
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
    std::vector<std::vector<Piece>> all(segments.size());
    pieces(segments, all);
    for (std::size_t i = 0; i < all.size(); ++i) out[i] = composite(all[i]);
  }

 private:
  /// Without the empty ones.
  struct Batch {
    explicit Batch(std::span<const Segment> from) {
      for (std::size_t i = 0; i < from.size(); ++i) {
        const Segment& s = from[i];
        if (s.empty())
          continue;
        segments.push_back({{s.origin.x(), s.origin.y(), s.origin.z()},
                            {s.direction.x(), s.direction.y(), s.direction.z()},
                            s.begin,
                            s.end});
        numbers.push_back(i);
      }
    }

    std::vector<volute_segment> segments;
    std::vector<std::size_t> numbers;
  };

  struct Values {
    double extinction = 0;
    Rgb emission = Rgb::Zero();
  };

  const volute_medium_kind& kind() const { return opened_->kind(); }

  Values valuesAt(const Vec3& point) const {
    if (!kind().values)
      return valuesOfPieces(point);
    double extinction = 0, emission[3] = {};
    opened_->check(kind().values(opened_->medium(), time_, point.data(), 1, &extinction, emission));
    const Values values{factor_ * extinction, Rgb(emission[0], emission[1], emission[2])};
    if (!std::isfinite(extinction) || !values.emission.allFinite())
      opened_->fault(fmt::format("values at ({}, {}, {}) m are not finite", plainNumber(point.x()),
                                 plainNumber(point.y()), plainNumber(point.z())));
    return values;
  }

  /// Of the piece that a short segment along x has at the point.
  Values valuesOfPieces(const Vec3& point) const {
    const double half = 1e-6 * (1 + point.cwiseAbs().maxCoeff());
    const Segment around{point, Vec3::UnitX(), -half, half};
    std::vector<Piece> found;
    pieces({&around, 1}, {&found, 1});
    for (const Piece& piece : found) {
      if (piece.begin > 0 || piece.end < 0)
        continue;
      const double u = -piece.begin, fading = std::exp(-piece.decay * u);
      return {fading * piece.extinction(u),
              fading * Rgb(piece.emission[0](u), piece.emission[1](u), piece.emission[2](u))};
    }
    return {};
  }

  std::shared_ptr<const OpenedMedium> opened_;
  Box3 bounds_;
  double time_, factor_;
};

class OwnMediumSnapshot final : public MediumSnapshot {
 public:
  explicit OwnMediumSnapshot(const OwnMedium& medium) : medium_(medium) {}

  void addMedia(std::vector<AnyMedium>& media) const override { media.push_back(medium_); }

 private:
  AnyMedium medium_;
};

class OwnMediumInTime final : public SceneMedium {
 public:
  OwnMediumInTime(std::shared_ptr<const OpenedMedium> opened, MediumInfo info)
      : opened_(std::move(opened)) {
    info_ = std::move(info);
  }

  Result<std::shared_ptr<const MediumSnapshot>> at(const SnapshotRequest& request,
                                                   Progress&) override {
    const double time = std::clamp(request.time, info_.times.front(), info_.times.back());
    return std::make_shared<const OwnMediumSnapshot>(
        OwnMedium(opened_, info_.bounds, time, request.factor));
  }

 private:
  std::shared_ptr<const OpenedMedium> opened_;
};

/// A kind whose rows are made of what C says.
class OwnKind final : public MediumKind {
 public:
  explicit OwnKind(const volute_medium_kind& kind) : kind_(kind) {
    const auto keep = [&](const char* text) -> std::string_view {
      return texts_.emplace_back(text ? text : "");
    };
    kind_.name = keep(kind.name).data();
    kind_.sentence = keep(kind.sentence).data();
    if (kind.ending) {
      kind_.ending = keep(kind.ending).data();
      rows_.push_back({.name = "file",
                       .type = FieldType::kFile,
                       .access = ownMember(),
                       .help = "that it is read from"});
    }
    for (std::size_t i = 0; i < kind.member_count; ++i) {
      const volute_medium_member& from = kind.members[i];
      FieldRow row{.name = keep(from.name), .access = ownMember(), .help = keep(from.help)};
      if (row.help.empty())
        row.help = row.name;
      row.unit = keep(from.unit);
      nlohmann::json usual = nlohmann::json::array();
      for (int k = 0; k < from.count; ++k) usual.push_back(from.usual ? from.usual[k] : 0.0);
      if (from.count > 1)
        row.type = FieldType::kNumbers, row.count = from.count;
      else
        usual = usual[0];
      if (from.minimum != 0 || from.maximum != 0)
        row.least = from.minimum, row.most = from.maximum;
      if (from.count == 1 && std::isfinite(row.least) && std::isfinite(row.most))
        row.slider.label = row.name;
      usual_.values[std::string(row.name)] = usual;
      rows_.push_back(row);
    }
    table_ = {.name = kind_.name,
              .sentence = kind_.sentence,
              .fields = rows_,
              .kind = kind_.name,
              .thing = kind_.sentence,
              .things = keep(fmt::format("media of kind '{}'", kind_.name).c_str()),
              .usual = &usual_,
              .make = [] { return std::shared_ptr<void>(std::make_shared<OwnMembers>()); },
              .owner = typeName<OwnMembers>()};
  }

  const FieldTable& fields() const override { return table_; }

  bool opens(const std::string& path) const override {
    return kind_.ending && std::filesystem::path(path).filename().string().ends_with(kind_.ending);
  }

  Result<std::shared_ptr<SceneMedium>> open(const nlohmann::json& entry,
                                            MediumContext& context) const override {
    OwnMembers members = usual_;
    VOLUTE_TRY(readFields(table_, entry, {context.file, context.path}, &members));
    std::vector<double> values;
    for (const FieldRow& row : rows_) {
      if (row.type == FieldType::kFile)
        continue;
      const nlohmann::json& value = members.values[std::string(row.name)];
      for (const auto& one : value.is_array() ? value : nlohmann::json::array({value}))
        values.push_back(one.get<double>());
    }
    const std::string file = members.values.value("file", "");
    MediumInfo info;
    info.file = file.empty() ? context.file : file;
    info.what = kind_.sentence;
    info.kind = kind_.name;
    const auto wrong = [&](std::string_view what) {
      return failIn(info.file, context.path, ErrorCode::kInvalidData, "{}", what);
    };
    void* medium = nullptr;
    if (const char* why =
            kind_.open(kind_.user, values.data(), file.empty() ? nullptr : file.c_str(), &medium))
      return wrong(why);
    auto opened = std::make_shared<const OpenedMedium>(kind_, medium);
    double box[6] = {};
    if (const char* why = kind_.bounds(medium, box))
      return wrong(why);
    info.bounds = {Vec3(box[0], box[1], box[2]), Vec3(box[3], box[4], box[5])};
    info.fileBounds = info.bounds;
    if (info.bounds.empty()) {
      return wrong(
          fmt::format("the kind '{}' says bounds of ({}, {}, {}) to ({}, {}, "
                      "{}) m; expected a box",
                      kind_.name, plainNumber(box[0]), plainNumber(box[1]), plainNumber(box[2]),
                      plainNumber(box[3]), plainNumber(box[4]), plainNumber(box[5])));
    }
    if (kind_.times) {
      constexpr std::size_t kMaxTimes = 10'000'000;
      const std::size_t count = kind_.times(medium, nullptr, 0);
      if (count < 1 || count > kMaxTimes)
        return wrong(
            fmt::format("the kind '{}' says {} times; expected 1 or more", kind_.name, count));
      info.times.assign(count, 0);
      info.numbers.resize(count);
      kind_.times(medium, info.times.data(), count);
      for (std::size_t i = 0; i < count; ++i) {
        info.numbers[i] = static_cast<int>(i);
        if (!std::isfinite(info.times[i]) || (i > 0 && !(info.times[i - 1] < info.times[i]))) {
          return wrong(
              fmt::format("the kind '{}' says the time {} as number {}; expected ascending "
                          "times",
                          kind_.name, info.times[i], i));
        }
      }
      info.interpolates = true;
    }
    return std::make_shared<OwnMediumInTime>(std::move(opened), std::move(info));
  }

  void addParameters(ParameterGroup& group, const OrderedJson& entry, const SceneMedium&,
                     MediumFacts facts) const override {
    OwnMembers members = usual_;
    if (readFields(table_, nlohmann::json(entry), {}, &members))
      addSliders(group, table_, &members, facts);
  }

 private:
  volute_medium_kind kind_;
  std::deque<std::string> texts_;  // that kind_ and rows_ refer to
  std::vector<FieldRow> rows_;
  OwnMembers usual_;
  FieldTable table_;
};

Status checkOwnKind(const volute_medium_kind& kind) {
  if (kind.size != sizeof kind) {
    return fail(ErrorCode::kInvalidArgument,
                "a kind of medium: size is {}; set it to sizeof(volute_medium_kind), which is {}",
                kind.size, sizeof kind);
  }
  const auto isName = [](const char* name) {
    return name && *name && std::ranges::all_of(std::string_view(name), [](char c) {
             return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
           });
  };
  const auto wrong = [&](std::string_view what) {
    return fail(ErrorCode::kInvalidArgument, "the kind of medium '{}': {}",
                kind.name ? kind.name : "", what);
  };
  if (!isName(kind.name))
    return wrong("a name has lower case letters, digits, _ and -");
  if (!kind.open || !kind.bounds || !kind.pieces)
    return wrong("open, bounds and pieces must not be NULL");
  if (kind.ending && (kind.ending[0] != '.' || !kind.ending[1]))
    return wrong("an ending begins with a dot, as \".ball\"");
  if (kind.member_count > 0 && !kind.members)
    return wrong("members is NULL");
  std::set<std::string_view> names{"kind", "file"};
  for (std::size_t i = 0; i < kind.member_count; ++i) {
    const volute_medium_member& member = kind.members[i];
    if (!isName(member.name) || !names.insert(member.name).second)
      return wrong(
          fmt::format("the name '{}' of member {}; expected one of its own, of lower case "
                      "letters, digits and _, and not 'kind' or 'file'",
                      member.name ? member.name : "", i));
    if (member.count < 1 || member.count > 16)
      return wrong(fmt::format("'{}' has {} numbers; expected 1 to 16", member.name, member.count));
    for (int k = 0; k < member.count; ++k) {
      const double usual = member.usual ? member.usual[k] : 0.0;
      const bool any = member.minimum == 0 && member.maximum == 0;
      if (!std::isfinite(usual) || (!any && !(usual >= member.minimum && usual <= member.maximum)))
        return wrong(fmt::format("the default {} of '{}'; expected {} to {}", usual, member.name,
                                 member.minimum, member.maximum));
    }
  }
  return {};
}

std::vector<std::string>& faults() {
  static std::vector<std::string> sentences;
  return sentences;
}

}  // namespace

Status registerOwnKind(const volute_medium_kind& kind) {
  VOLUTE_TRY(checkOwnKind(kind));
  static std::vector<std::unique_ptr<const OwnKind>> all;  // open scenes refer to former ones
  auto& kinds = mediumKinds();
  const auto same = std::ranges::find(kinds, std::string_view(kind.name), &MediumKind::name);
  if (same == kinds.end()) {
    // The last kind takes every file that no other does.
    kinds.insert(kinds.begin(), all.emplace_back(std::make_unique<const OwnKind>(kind)).get());
    return {};
  }
  if (!dynamic_cast<const OwnKind*>(*same)) {
    return fail(ErrorCode::kInvalidArgument,
                "the kind of medium '{0}': Volute has a kind '{0}' itself; expected another name",
                kind.name);
  }
  *same = all.emplace_back(std::make_unique<const OwnKind>(kind)).get();
  return {};
}

void registerPluginKinds() {
  for (const MediumPlugin& plugin : loadMediumPlugins()) {
    Status done = plugin.kind
                      ? registerOwnKind(*static_cast<const volute_medium_kind*>(plugin.kind))
                      : fail(ErrorCode::kUnsupported, "{}", plugin.reason);
    if (!done)
      faults().push_back(plugin.kind ? fmt::format("{}: {}", plugin.file, done.error().message)
                                     : done.error().message);
  }
}

const std::vector<std::string>& ownKindFaults() {
  return faults();
}

}  // namespace volute
