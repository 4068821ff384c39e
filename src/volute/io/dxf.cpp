// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/dxf.hpp"

#include <fmt/format.h>
#include <iconv.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <set>
#include <span>
#include <sstream>
#include <string_view>

#include "volute/base/input_file.hpp"
#include "volute/base/lower_case.hpp"
#include "volute/base/number_word.hpp"
#include "volute/base/printable.hpp"
#include "volute/base/read_text.hpp"
#include "volute/base/suggest.hpp"
#include "volute/math/vec.hpp"

namespace volute {
namespace {

/// A code says what the value beside it is.
struct Pair {
  int code = 0;
  std::string_view value;
  int line = 0;  ///< of the code
};

/// What the values of an entity are, codes in the order of the file.
class Entity {
 public:
  std::string_view kind;
  int line = 0;
  std::vector<Pair> pairs;

  std::string_view text(int code) const {
    for (const Pair& pair : pairs) {
      if (pair.code == code)
        return pair.value;
    }
    return {};
  }
};

/// Moves, turns and stretches: of a block that is inserted.
struct Placement {
  Vec2 x = Vec2(1, 0), y = Vec2(0, 1), origin = Vec2::Zero();

  Vec2 at(const Vec2& p) const { return origin + p.x() * x + p.y() * y; }

  /// What is placed by `inner`, then by this.
  Placement after(const Placement& inner) const {
    const auto turned = [&](const Vec2& v) -> Vec2 { return v.x() * x + v.y() * y; };
    return {turned(inner.x), turned(inner.y), at(inner.origin)};
  }
};

struct Block {
  Vec2 base = Vec2::Zero();
  std::vector<Entity> entities;
};

/// [m]; $INSUNITS of the DXF Reference.
std::optional<double> unitOf(int code) {
  static constexpr double kUnits[] = {0,    0.0254, 0.3048,  1609.344, 1e-3,   1e-2,
                                      1,    1e3,    2.54e-8, 2.54e-5,  0.9144, 1e-10,
                                      1e-9, 1e-6,   0.1,     10,       100};
  if (code < 1 || code >= static_cast<int>(std::size(kUnits)))
    return std::nullopt;
  return kUnits[code];
}

/// In UTF-8, of a file in the code page that it states ("ANSI_1252", as AutoCAD wrote until 2006);
/// text that it cannot be is taken as Latin-1.
std::string decoded(const std::string& text) {
  if (std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x80; }))
    return text;
  std::string utf8 = asUtf8(text);
  if (utf8 == text)
    return text;
  std::string page;
  if (const std::size_t name = text.find("$DWGCODEPAGE"); name != text.npos) {
    std::istringstream lines(text.substr(name, 64));  // the name, a group code, the page
    for (int i = 0; i < 3; ++i) std::getline(lines, page);
  }
  const std::size_t digits = page.find_first_of("0123456789");
  if (digits == page.npos)
    return utf8;
  const std::string number(trimmed(page.substr(digits)));
  const iconv_t to = ::iconv_open("UTF-8", ("CP" + number).c_str());
  if (to == reinterpret_cast<iconv_t>(-1))
    return utf8;
  std::string out(4 * text.size(), '\0');
  std::string from = text;
  char *in = from.data(), *end = out.data();
  std::size_t inLeft = from.size(), outLeft = out.size();
  const bool whole = ::iconv(to, &in, &inLeft, &end, &outLeft) != static_cast<std::size_t>(-1);
  ::iconv_close(to);
  out.resize(out.size() - outLeft);
  return whole ? out : utf8;
}

/// With characters in place of their numbers: K\U+00FCche.
std::string withoutNumbers(std::string_view text) {
  constexpr std::string_view kMark = "\\U+";
  constexpr std::size_t kDigits = 4;
  std::string out;
  for (;;) {
    const std::size_t at = text.find(kMark);
    out += text.substr(0, at);
    if (at == text.npos)
      return out;
    const std::string_view digits = text.substr(at + kMark.size(), kDigits);
    std::uint32_t code = 0;
    const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), code, 16);
    const bool valid = digits.size() == kDigits && read.ptr == digits.data() + kDigits &&
                       code >= 0x20 && (code < 0xD800 || code >= 0xE000);
    if (valid)
      appendUtf8(out, code);
    else
      out += kMark;
    text.remove_prefix(at + kMark.size() + (valid ? kDigits : 0));
  }
}

class DxfReader {
 public:
  DxfReader(std::filesystem::path path, std::uint64_t maxMemory, std::string_view layer)
      : path_(std::move(path)), maxMemory_(maxMemory), layer_(layer) {}

  Result<DxfDrawing> read() {
    VOLUTE_TRY(load());
    VOLUTE_TRY(readSections());
    for (const Entity& entity : model_) VOLUTE_TRY(draw(entity, Placement(), entity.text(8), 0));
    VOLUTE_TRY(checkLayer());
    std::ranges::move(attributes_, std::back_inserter(drawing_.texts));
    if (drawing_.lines.empty() && drawing_.outlines.empty()) {
      return fail(ErrorCode::kInvalidData, "{}: has no lines to draw{}", path_.string(),
                  hidden_ > 0 ? "; its layers are off or frozen" : "");
    }
    return std::move(drawing_);
  }

 private:
  template <class... Args>
  tl::unexpected<Error> fault(int line, fmt::format_string<Args...> format, Args&&... args) const {
    return fail(ErrorCode::kInvalidData, "{}: line {}: {}", path_.string(), line,
                fmt::format(format, std::forward<Args>(args)...));
  }

  /// Names of layers are the same in capitals.
  static bool isSame(std::string_view one, std::string_view other) {
    return lowerCase(one) == lowerCase(other);
  }

  Status checkLayer() const {
    if (layer_.empty() ||
        std::ranges::any_of(layers_, [&](const std::string& one) { return isSame(one, layer_); }))
      return {};
    const std::vector<std::string_view> names(layers_.begin(), layers_.end());
    const auto near = nearest(layer_, names);
    return fail(ErrorCode::kNotFound, "{}: has no layer '{}'{}", path_.string(), layer_,
                near.empty() ? fmt::format("; its layers are {}", fmt::join(names, ", "))
                             : fmt::format("; did you mean '{}'?", near));
  }

  Status load() {
    constexpr std::string_view kBinary = "AutoCAD Binary DXF";
    VOLUTE_ASSIGN(const auto file, InputFile::open(path_));
    if (file.size() > maxMemory_ / 16) {
      return fail(ErrorCode::kTooLarge, "{}: {} MiB need more than the {} MiB of memory allowed",
                  path_.string(), file.size() >> 20, maxMemory_ >> 20);
    }
    text_.resize(file.size());
    VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(text_))));
    if (text_.starts_with(kBinary)) {
      return fail(ErrorCode::kUnsupported, "{}: a binary DXF file; save it as ASCII DXF",
                  path_.string());
    }
    text_ = decoded(text_);
    if (text_.find("\\U+") != text_.npos)
      text_ = withoutNumbers(text_);
    if (text_.starts_with("\xEF\xBB\xBF"))
      at_ = 3;
    return {};
  }

  std::string_view nextLine() {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    const std::string_view line = std::string_view(text_).substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    ++line_;
    return trimmed(line);
  }

  /// False at the file's end, which EOF must say.
  Result<bool> next(Pair& pair) {
    do {
      if (at_ >= text_.size())
        return fail(ErrorCode::kTruncated, "{}: ends at line {} without EOF; it is cut off",
                    path_.string(), line_);
      pair.line = line_ + 1;
      const std::string_view code = nextLine();
      if (!readNumber(code, pair.code)) {
        return fault(pair.line, "'{}' is no group code; expected an ASCII DXF file", shown(code));
      }
      if (at_ >= text_.size() && pair.code != 0)
        return fail(ErrorCode::kTruncated, "{}: ends at line {} without EOF; it is cut off",
                    path_.string(), line_);
      pair.value = nextLine();
    } while (pair.code == 999);  // a remark
    return !(pair.code == 0 && pair.value == "EOF");
  }

  static std::string shown(std::string_view text) {
    std::string word(text.substr(0, 40));
    std::ranges::replace_if(word, [](unsigned char c) { return c < ' ' || c > '~'; }, '?');
    return word;
  }

  /// The values after a 0, until the next.
  Result<bool> nextEntity(Entity& entity) {
    if (!pending_) {
      Pair pair;
      VOLUTE_ASSIGN(const bool more, next(pair));
      if (!more)
        return false;
      if (pair.code != 0)
        return fault(pair.line, "group {} outside of any entity; expected group 0", pair.code);
      pending_ = pair;
    }
    entity.kind = pending_->value;
    entity.line = pending_->line;
    entity.pairs.clear();
    pending_.reset();
    for (Pair pair;;) {
      VOLUTE_ASSIGN(const bool more, next(pair));
      if (!more) {
        ended_ = true;
        return true;
      }
      if (pair.code == 0) {
        pending_ = pair;
        return true;
      }
      entity.pairs.push_back(pair);
    }
  }

  Status readSections() {
    Entity entity;
    std::string_view section;
    Block* block = nullptr;
    while (!ended_) {
      VOLUTE_ASSIGN(const bool more, nextEntity(entity));
      if (!more)
        break;
      if (entity.kind == "SECTION") {
        section = entity.text(2);
        if (section == "HEADER")
          readHeader(entity);
      } else if (entity.kind == "ENDSEC") {
        section = {};
      } else if (entity.kind == "LAYER" && section == "TABLES") {
        readLayer(entity);
      } else if (entity.kind == "BLOCK" && section == "BLOCKS") {
        block = &blocks_[std::string(entity.text(2))];
        VOLUTE_ASSIGN(block->base, point(entity, 10, Vec2::Zero()));
      } else if (entity.kind == "ENDBLK") {
        block = nullptr;
      } else if (section == "ENTITIES") {
        model_.push_back(entity);
      } else if (section == "BLOCKS" && block) {
        block->entities.push_back(entity);
      }
    }
    if (!section.empty())
      return fail(ErrorCode::kTruncated, "{}: its section {} does not end; it is cut off",
                  path_.string(), shown(section));
    return joinVertices();
  }

  void readHeader(const Entity& header) {
    std::string_view variable;
    for (const Pair& pair : header.pairs) {
      int code = 0;
      if (pair.code == 9)
        variable = pair.value;
      else if (variable == "$INSUNITS" && pair.code == 70 && readNumber(pair.value, code))
        drawing_.unit = unitOf(code);
    }
  }

  void readLayer(const Entity& layer) {
    constexpr int kFrozen = 1;
    int flags = 0, color = 0;
    layers_.emplace(layer.text(2));
    readNumber(layer.text(70), flags);
    readNumber(layer.text(62), color);
    if ((flags & kFrozen) || color < 0)
      offLayers_.insert(lowerCase(layer.text(2)));
  }

  /// The old polylines' points are entities of their own: they become values of the polyline.
  Status joinVertices() {
    VOLUTE_TRY(joinVertices(model_));
    for (auto& [name, block] : blocks_) VOLUTE_TRY(joinVertices(block.entities));
    return {};
  }

  Status joinVertices(std::vector<Entity>& entities) {
    std::vector<Entity> joined;
    bool within = false;
    for (Entity& entity : entities) {
      if (entity.kind == "SEQEND") {
        within = false;
      } else if (entity.kind == "VERTEX") {
        constexpr int kControl = 16, kFace = 128;
        int flags = 0;
        readNumber(entity.text(70), flags);
        if (!within)
          return fault(entity.line, "a VERTEX without its POLYLINE");
        if ((flags & kControl) || (flags & (kFace | 64)) == kFace)
          continue;
        for (const Pair& pair : entity.pairs) {
          if (pair.code == 10 || pair.code == 20 || pair.code == 42)
            joined.back().pairs.push_back(pair);
        }
      } else {
        within = entity.kind == "POLYLINE";
        joined.push_back(std::move(entity));
        if (within) {  // its own point says the height alone
          std::erase_if(joined.back().pairs,
                        [](const Pair& pair) { return pair.code == 10 || pair.code == 20; });
        }
      }
    }
    entities = std::move(joined);
    return {};
  }

  Result<double> number(const Pair& pair) const {
    double value = 0;
    constexpr double kFarthest = 1e12;  // no building is as large in any unit
    if (!readNumber(pair.value, value) || !(std::abs(value) < kFarthest))
      return fault(pair.line + 1, "'{}' is no number (group {})", shown(pair.value), pair.code);
    return value;
  }

  Result<double> number(const Entity& entity, int code, std::optional<double> otherwise) const {
    for (const Pair& pair : entity.pairs) {
      if (pair.code == code)
        return number(pair);
    }
    if (otherwise)
      return *otherwise;
    return fault(entity.line, "{} without group {}", shown(entity.kind), code);
  }

  /// Of groups `code` and `code` + 10.
  Result<Vec2> point(const Entity& entity, int code,
                     std::optional<Vec2> otherwise = std::nullopt) const {
    const auto part = [&](int axis) {
      return number(entity, code + 10 * axis,
                    otherwise ? std::optional((*otherwise)[axis]) : std::nullopt);
    };
    VOLUTE_ASSIGN(const double x, part(0));
    VOLUTE_ASSIGN(const double y, part(1));
    return Vec2(x, y);
  }

  struct Corner {
    Vec2 at;
    double bulge = 0;
  };

  /// All points of groups `code` and `code` + 10, and the bulge that follows each.
  Result<std::vector<Corner>> corners(const Entity& entity, int code) const {
    std::vector<Corner> corners;
    for (const Pair& pair : entity.pairs) {
      if (pair.code != code && pair.code != code + 10 && (pair.code != 42 || code != 10))
        continue;
      VOLUTE_ASSIGN(const double value, number(pair));
      if (pair.code == code)
        corners.push_back({Vec2(value, 0)});
      else if (!corners.empty())
        (pair.code == 42 ? corners.back().bulge : corners.back().at.y()) = value;
    }
    return corners;
  }

  Status add(const Vec2& from, const Vec2& to, const Placement& place) {
    const DrawnLine line{place.at(from), place.at(to)};
    if (!line.from.allFinite() || !line.to.allFinite())
      return fail(ErrorCode::kInvalidData, "{}: a line that is nowhere: its blocks are too large",
                  path_.string());
    if (drawing_.lines.size() >= maxMemory_ / 4 / sizeof(DrawnLine)) {
      return fail(ErrorCode::kTooLarge, "{}: its lines need more than the {} MiB of memory allowed",
                  path_.string(), maxMemory_ >> 20);
    }
    drawing_.lines.push_back(line);
    return {};
  }

  /// Around `center`, from `begin` over `sweep` [radians]; `major` and `minor` are the half axes.
  Status addArc(const Vec2& center, const Vec2& major, const Vec2& minor, double begin,
                double sweep, const Placement& place) {
    constexpr double kStep = 0.0632;  // [radians]; its sagitta is 1/2000 of the radius
    const int parts = std::max(1, static_cast<int>(std::ceil(std::abs(sweep) / kStep)));
    const auto at = [&](int i) -> Vec2 {
      const double angle = begin + sweep * i / parts;
      return center + std::cos(angle) * major + std::sin(angle) * minor;
    };
    for (int i = 0; i < parts; ++i) VOLUTE_TRY(add(at(i), at(i + 1), place));
    return {};
  }

  /// A bulge is the tangent of a quarter of the arc's angle, positive to the left.
  Status addBulge(const Corner& a, const Vec2& b, const Placement& place) {
    const Vec2 chord = b - a.at;
    const double length = chord.norm();
    if (std::abs(a.bulge) < 1e-9 || length == 0)
      return add(a.at, b, place);
    const double sweep = 4 * std::atan(a.bulge);
    const Vec2 left(-chord.y(), chord.x());
    const Vec2 center = 0.5 * (a.at + b) + left * ((1 - a.bulge * a.bulge) / (4 * a.bulge));
    const Vec2 radius = a.at - center;
    return addArc(center, radius, Vec2(-radius.y(), radius.x()), 0, sweep, place);
  }

  Status addPolyline(const Entity& entity, const Placement& place) {
    constexpr int kClosed = 1, kFaces = 64;
    int flags = 0;
    readNumber(entity.text(70), flags);
    if (flags & kFaces) {
      ++drawing_.left["POLYLINE of faces"];
      return {};
    }
    VOLUTE_ASSIGN(const auto corners, this->corners(entity, 10));
    for (std::size_t i = 0; i + 1 < corners.size(); ++i)
      VOLUTE_TRY(addBulge(corners[i], corners[i + 1].at, place));
    if ((flags & kClosed) && corners.size() > 1)
      return addBulge(corners.back(), corners.front().at, place);
    return {};
  }

  Status addRing(const Entity& entity, std::initializer_list<int> codes, const Placement& place) {
    std::vector<Vec2> ring;
    for (const int code : codes) {
      VOLUTE_ASSIGN(const Vec2 corner,
                    point(entity, code, ring.empty() ? Vec2(0, 0) : ring.back()));
      ring.push_back(corner);
    }
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec2& next = ring[(i + 1) % ring.size()];
      if (ring[i] != next)
        VOLUTE_TRY(add(ring[i], next, place));
    }
    return {};
  }

  Status addRound(const Entity& entity, bool whole, const Placement& place) {
    constexpr double kRadians = std::numbers::pi / 180;
    VOLUTE_ASSIGN(const Vec2 center, point(entity, 10));
    VOLUTE_ASSIGN(const double radius, number(entity, 40, std::nullopt));
    VOLUTE_ASSIGN(const double begin, number(entity, 50, 0));
    VOLUTE_ASSIGN(const double end, number(entity, 51, 360));
    double sweep = std::fmod(end - begin, 360);
    if (sweep <= 0)
      sweep += 360;
    return addArc(center, Vec2(radius, 0), Vec2(0, radius), whole ? 0 : begin * kRadians,
                  (whole ? 360 : sweep) * kRadians, place);
  }

  Status addEllipse(const Entity& entity, const Placement& place) {
    constexpr double kTurn = 2 * std::numbers::pi;
    VOLUTE_ASSIGN(const Vec2 center, point(entity, 10));
    VOLUTE_ASSIGN(const Vec2 major, point(entity, 11));
    VOLUTE_ASSIGN(const double ratio, number(entity, 40, 1));
    VOLUTE_ASSIGN(const double begin, number(entity, 41, 0));
    VOLUTE_ASSIGN(const double end, number(entity, 42, kTurn));
    VOLUTE_ASSIGN(const double up, number(entity, 230, 1));
    double sweep = std::fmod(end - begin, kTurn);
    if (sweep <= 1e-9)
      sweep += kTurn;
    const Vec2 minor = ratio * (up < 0 ? -1.0 : 1.0) * Vec2(-major.y(), major.x());
    return addArc(center, major, minor, begin, sweep, place);
  }

  /// By de Boor's algorithm, in homogeneous coordinates where there are weights. Of splines that
  /// are given by the points that they pass alone, these are joined.
  Status addSpline(const Entity& entity, const Placement& place) {
    VOLUTE_ASSIGN(const auto control, corners(entity, 10));
    VOLUTE_ASSIGN(const auto fit, corners(entity, 11));
    std::vector<double> knots, weights;
    for (const Pair& pair : entity.pairs) {
      if (pair.code != 40 && pair.code != 41)
        continue;
      VOLUTE_ASSIGN(const double value, number(pair));
      (pair.code == 40 ? knots : weights).push_back(value);
    }
    constexpr int kHighest = 10;
    int degree = 3;
    readNumber(entity.text(71), degree);
    const auto count = static_cast<int>(control.size());
    const bool whole = degree >= 1 && degree <= kHighest && count > degree &&
                       static_cast<int>(knots.size()) == count + degree + 1 &&
                       std::ranges::is_sorted(knots) && knots[degree] < knots[count];
    if (!whole) {
      for (std::size_t i = 0; i + 1 < fit.size(); ++i)
        VOLUTE_TRY(add(fit[i].at, fit[i + 1].at, place));
      if (fit.size() < 2)
        return fault(entity.line, "a SPLINE of {} points and {} knots; expected {} knots", count,
                     knots.size(), count + degree + 1);
      return {};
    }
    if (weights.size() != control.size() ||
        !std::ranges::all_of(weights, [](double w) { return w > 1e-9; }))
      weights.assign(control.size(), 1);
    const auto at = [&](double u) -> Vec2 {
      const auto after = std::upper_bound(knots.begin() + degree, knots.begin() + count, u);
      const int span = std::clamp(static_cast<int>(after - knots.begin()) - 1, degree, count - 1);
      std::array<Vec3, kHighest + 1> d;
      for (int j = 0; j <= degree; ++j) {
        const auto i = static_cast<std::size_t>(span - degree + j);
        d[j] = Vec3(control[i].at.x(), control[i].at.y(), 1) * weights[i];
      }
      for (int r = 1; r <= degree; ++r) {
        for (int j = degree; j >= r; --j) {
          const double low = knots[span - degree + j], high = knots[span + 1 + j - r];
          const double a = high > low ? (u - low) / (high - low) : 0;
          d[j] = (1 - a) * d[j - 1] + a * d[j];
        }
      }
      return d[degree].head<2>() / d[degree].z();
    };
    constexpr int kPerSpan = 16;
    Vec2 last = at(knots[degree]);
    for (int span = degree; span < count; ++span) {
      for (int i = 1; i <= kPerSpan && knots[span] < knots[span + 1]; ++i) {
        const double share = static_cast<double>(i) / kPerSpan;
        const Vec2 next = at((1 - share) * knots[span] + share * knots[span + 1]);
        VOLUTE_TRY(add(last, next, place));
        last = next;
      }
    }
    return {};
  }

  Status addInsert(const Entity& entity, const Placement& place, std::string_view layer,
                   int depth) {
    constexpr int kDeepest = 16, kMaxCopies = 10000;
    const auto found = blocks_.find(std::string(entity.text(2)));
    if (found == blocks_.end()) {
      return fault(entity.line, "inserts the block '{}', which is not there",
                   shown(entity.text(2)));
    }
    if (depth == kDeepest) {
      return fault(entity.line, "blocks within each other, {} deep; expected fewer", depth);
    }
    VOLUTE_ASSIGN(const Vec2 at, point(entity, 10));
    VOLUTE_ASSIGN(const double sx, number(entity, 41, 1));
    VOLUTE_ASSIGN(const double sy, number(entity, 42, 1));
    VOLUTE_ASSIGN(const double degrees, number(entity, 50, 0));
    VOLUTE_ASSIGN(const double columns, number(entity, 70, 1));
    VOLUTE_ASSIGN(const double rows, number(entity, 71, 1));
    VOLUTE_ASSIGN(const double dx, number(entity, 44, 0));
    VOLUTE_ASSIGN(const double dy, number(entity, 45, 0));
    if (!(columns >= 0 && rows >= 0 && columns * rows <= kMaxCopies))
      return fault(entity.line, "{} x {} copies of a block; expected {} at most", columns, rows,
                   kMaxCopies);
    const double angle = degrees * std::numbers::pi / 180;
    const Vec2 x(std::cos(angle), std::sin(angle)), y(-x.y(), x.x());
    for (int row = 0; row < std::max(1, static_cast<int>(rows)); ++row) {
      for (int column = 0; column < std::max(1, static_cast<int>(columns)); ++column) {
        ++visits_;
        Placement inner{sx * x, sy * y, at + column * dx * x + row * dy * y};
        inner.origin -= inner.x * found->second.base.x() + inner.y * found->second.base.y();
        for (const Entity& part : found->second.entities) {
          const std::string_view own = part.text(8);
          VOLUTE_TRY(
              draw(part, place.after(inner), own == "0" || own.empty() ? layer : own, depth + 1));
        }
      }
    }
    return {};
  }

  bool isHidden(const Entity& entity) const {
    return entity.text(67) == "1" || entity.text(60) == "1" ||
           offLayers_.contains(lowerCase(entity.text(8)));
  }

  /// What is on the layer that is asked for, drawn or not.
  Status keep(const Entity& entity, const Placement& outer) {
    VOLUTE_ASSIGN(const double up, number(entity, 230, 1));
    const Placement place = up < 0 ? outer.after({Vec2(-1, 0), Vec2(0, 1), Vec2::Zero()}) : outer;
    if (entity.kind == "TEXT" || entity.kind == "MTEXT" || entity.kind == "ATTRIB") {
      VOLUTE_ASSIGN(const Vec2 at, point(entity, 10));
      std::string text;
      for (const Pair& pair : entity.pairs) {
        if (pair.code == 3 || pair.code == 1)
          text += pair.value;
      }
      if (entity.kind == "MTEXT")
        text = plain(text);
      auto& texts = entity.kind == "ATTRIB" ? attributes_ : drawing_.texts;
      texts.push_back({place.at(at), std::string(trimmed(text))});
      return {};
    }
    if (entity.kind != "LWPOLYLINE" && entity.kind != "POLYLINE" && entity.kind != "CIRCLE")
      return {};
    const std::size_t first = drawing_.lines.size();
    VOLUTE_TRY(entity.kind == "CIRCLE" ? addRound(entity, true, place)
                                       : addPolyline(entity, place));
    DrawnOutline outline{{}, entity.line};
    for (std::size_t i = first; i < drawing_.lines.size(); ++i)
      outline.points.push_back(drawing_.lines[i].from);
    const bool closed =
        outline.points.size() > 2 && (drawing_.lines.back().to - outline.points.front()).norm() <=
                                         1e-6 * (1 + outline.points.front().norm());
    drawing_.lines.resize(first);
    if (closed)
      drawing_.outlines.push_back(std::move(outline));
    else
      ++drawing_.open;
    return {};
  }

  /// MTEXT without what says how it looks: "{\\fArial|b0;Hall\\P2}" is "Hall 2".
  static std::string plain(std::string_view text) {
    constexpr std::string_view kUntilSemicolon = "ACFHQTWfp";
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '{' || text[i] == '}')
        continue;
      if (text[i] != '\\' || i + 1 == text.size()) {
        out += text[i];
      } else if (const char code = text[++i]; code == 'P' || code == '~') {
        out += ' ';
      } else if (code == '\\' || code == '{' || code == '}') {
        out += code;
      } else if (kUntilSemicolon.find(code) != std::string_view::npos) {
        i = std::min(text.find(';', i), text.size() - 1);
      }
    }
    return out;
  }

  /// @param layer  its own, or that of the block on which it is inserted
  Status draw(const Entity& entity, const Placement& outer, std::string_view layer, int depth) {
    constexpr std::uint64_t kMaxVisits = 100'000'000;
    visits_ += 1 + entity.pairs.size();
    if (visits_ > kMaxVisits)
      return fail(ErrorCode::kTooLarge,
                  "{}: more than {} values to draw, blocks within blocks counted", path_.string(),
                  kMaxVisits);
    layers_.emplace(layer);
    if (!layer_.empty() && isSame(layer, layer_) && entity.text(67) != "1")
      VOLUTE_TRY(keep(entity, outer));
    if (isHidden(entity)) {
      ++hidden_;
      if (layer_.empty() || entity.kind != "INSERT")
        return {};
      const std::size_t shown = drawing_.lines.size();
      VOLUTE_TRY(addInsert(entity, outer, layer, depth));
      drawing_.lines.resize(shown);
      return {};
    }
    const std::string_view kind = entity.kind;
    if (kind == "LINE") {
      VOLUTE_ASSIGN(const Vec2 from, point(entity, 10));
      VOLUTE_ASSIGN(const Vec2 to, point(entity, 11));
      return add(from, to, outer);
    }
    if (kind == "ELLIPSE")
      return addEllipse(entity, outer);
    if (kind == "SPLINE")
      return addSpline(entity, outer);
    if (kind == "3DFACE")
      return addRing(entity, {10, 11, 12, 13}, outer);
    // The others have coordinates of their own where their plane is seen from below.
    VOLUTE_ASSIGN(const double up, number(entity, 230, 1));
    const Placement place = up < 0 ? outer.after({Vec2(-1, 0), Vec2(0, 1), Vec2::Zero()}) : outer;
    if (kind == "LWPOLYLINE" || kind == "POLYLINE")
      return addPolyline(entity, place);
    if (kind == "ARC" || kind == "CIRCLE")
      return addRound(entity, kind == "CIRCLE", place);
    if (kind == "SOLID" || kind == "TRACE")  // whose third and fourth corner are exchanged
      return addRing(entity, {10, 11, 13, 12}, place);
    if (kind == "INSERT")
      return addInsert(entity, place, layer, depth);
    ++drawing_.left[shown(kind)];
    return {};
  }

  std::filesystem::path path_;
  std::uint64_t maxMemory_;
  std::string layer_;             // the one that is asked for
  std::set<std::string> layers_;  // all
  std::string text_;
  std::size_t at_ = 0;
  int line_ = 0;
  std::optional<Pair> pending_;
  bool ended_ = false;
  std::map<std::string, Block> blocks_;
  std::vector<Entity> model_;
  std::set<std::string> offLayers_;
  std::uint64_t visits_ = 0;
  int hidden_ = 0;
  decltype(DxfDrawing::texts) attributes_;  // of blocks; texts of the drawing go first
  DxfDrawing drawing_;
};

}  // namespace

Result<DxfDrawing> readDxf(const std::filesystem::path& path, std::uint64_t maxMemory,
                           std::string_view layer) {
  return DxfReader(path, maxMemory, layer).read();
}

}  // namespace volute
