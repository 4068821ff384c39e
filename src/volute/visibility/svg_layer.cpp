// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/svg_layer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "volute/base/number_word.hpp"
#include "volute/base/printable.hpp"
#include "volute/base/read_text.hpp"
#include "volute/io/table_row.hpp"

namespace volute {
namespace {

constexpr std::uint64_t kLargestSvg = std::uint64_t{64} << 20;  // [bytes]
constexpr std::size_t kDeepest = 200;                           // of elements in each other

using SvgAttributes = std::map<std::string, std::string, std::less<>>;

/// x' = a x + c y + e, y' = b x + d y + f.
struct SvgTransform {
  double a = 1, b = 0, c = 0, d = 1, e = 0, f = 0;

  Vec2 operator()(const Vec2& p) const {
    return {a * p.x() + c * p.y() + e, b * p.x() + d * p.y() + f};
  }

  SvgTransform operator*(const SvgTransform& o) const {
    return {a * o.a + c * o.b, b * o.a + d * o.b,     a * o.c + c * o.d,
            b * o.c + d * o.d, a * o.e + c * o.f + e, b * o.e + d * o.f + f};
  }
};

/// Numbers and letters of SVG, which need no blanks between them: "M10-5.5.25z".
class SvgWords {
 public:
  explicit SvgWords(std::string_view text) : text_(text) {}

  /// The next letter, if one comes before a number.
  std::optional<char> letter() {
    skipBlanks();
    if (text_.empty() ||
        !((text_[0] >= 'a' && text_[0] <= 'z') || (text_[0] >= 'A' && text_[0] <= 'Z')))
      return std::nullopt;
    const char found = text_[0];
    text_.remove_prefix(1);
    return found;
  }

  std::optional<double> number() {
    skipBlanks();
    if (text_.starts_with('+'))
      text_.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
    if (error != std::errc() || !std::isfinite(value))
      return std::nullopt;
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    return value;
  }

  bool atEnd() {
    skipBlanks();
    return text_.empty();
  }

 private:
  void skipBlanks() {
    const auto at = text_.find_first_not_of(" \t\r\n,");
    text_.remove_prefix(at == text_.npos ? text_.size() : at);
  }

  std::string_view text_;
};

std::vector<double> svgNumbers(std::string_view text) {
  SvgWords words(text);
  std::vector<double> numbers;
  while (const auto number = words.number()) numbers.push_back(*number);
  return numbers;
}

std::string svgText(std::string_view raw) {
  constexpr std::pair<std::string_view, char> kNames[] = {
      {"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}};
  std::string text;
  while (!raw.empty()) {
    const auto* found =
        std::ranges::find_if(kNames, [&](const auto& name) { return raw.starts_with(name.first); });
    text += found == std::end(kNames) ? raw[0] : found->second;
    raw.remove_prefix(found == std::end(kNames) ? 1 : found->first.size());
  }
  return text;
}

class SvgReader {
 public:
  SvgReader(std::string_view text, std::string file, std::string layer)
      : text_(text), file_(std::move(file)), layer_(lowerCase(layer)) {}

  Result<SvgLayer> read() {
    while (at_ < text_.size()) {
      const std::size_t begin = std::min(text_.find('<', at_), text_.size());
      if (!open_.empty() && open_.back().text)
        words_ += svgText(text_.substr(at_, begin - at_));
      at_ = begin;
      if (at_ < text_.size())
        VOLUTE_TRY(tag());
    }
    if (!open_.empty())
      return wrong("it ends within an element");
    if (!(size_.minCoeff() > 0))
      return wrong("it is no drawing: it has no element 'svg' with a size");
    if (!found_) {
      return fail(ErrorCode::kNotFound, "{}: no group is labelled '{}'; it has {}", file_,
                  printable(layer_), groups());
    }
    return std::move(read_);
  }

 private:
  struct Open {
    SvgTransform transform;
    bool within = false;  // the layer
    bool text = false;
    std::string name;
  };

  tl::unexpected<Error> wrong(std::string_view what) const {
    return fail(ErrorCode::kInvalidData, "{}: line {}: {}", file_, line(), what);
  }

  std::ptrdiff_t line() const {
    return 1 + std::ranges::count(text_.substr(0, std::min(at_, text_.size())), '\n');
  }

  std::string groups() const {
    std::string all;
    std::size_t named = 0;
    for (const std::string& group : groups_) {
      if (named++ < 5)
        all += fmt::format("{}'{}'", all.empty() ? "" : ", ", printable(group));
    }
    return all.empty() ? "none with a label" : all + (named > 5 ? " and others" : "");
  }

  Status skipTo(std::string_view end) {
    const auto found = text_.find(end, at_);
    if (found == text_.npos)
      return wrong(fmt::format("no '{}' before its end", end));
    at_ = found + end.size();
    return {};
  }

  /// Of an element, a comment or another thing in < >.
  Status tag() {
    const auto begins = [&](std::string_view text) { return text_.substr(at_).starts_with(text); };
    if (begins("<!--"))
      return skipTo("-->");
    if (begins("<![CDATA["))
      return skipTo("]]>");
    if (begins("<?"))
      return skipTo("?>");
    if (begins("<!"))
      return skipTo(text_.substr(at_, text_.find('>', at_) - at_).find('[') != text_.npos ? "]>"
                                                                                          : ">");
    if (begins("</")) {
      VOLUTE_TRY(skipTo(">"));
      if (open_.empty())
        return wrong("an element ends that did not begin");
      if (open_.back().text && open_.back().name == "text")
        addText();
      open_.pop_back();
      return {};
    }
    ++at_;
    const std::size_t nameEnd = std::min(text_.find_first_of(" \t\r\n/>", at_), text_.size());
    std::string name(text_.substr(at_, nameEnd - at_));
    name = name.substr(name.find(':') == name.npos ? 0 : name.find(':') + 1);
    at_ = nameEnd;
    SvgAttributes attributes;
    for (;;) {
      at_ = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size());
      if (at_ == text_.size())
        return wrong("it ends within an element");
      if (text_[at_] == '>' || text_[at_] == '/')
        break;
      const std::size_t equals = text_.find('=', at_);
      const std::size_t quote = equals == text_.npos ? equals : text_.find_first_of("\"'", equals);
      const std::size_t end = quote == text_.npos ? quote : text_.find(text_[quote], quote + 1);
      if (end == text_.npos)
        return wrong("an attribute without a value in quotes");
      std::string key(text_.substr(at_, equals - at_));
      key.erase(key.find_last_not_of(" \t\r\n") + 1);
      attributes[key] = svgText(text_.substr(quote + 1, end - quote - 1));
      at_ = end + 1;
    }
    const bool whole = text_[at_] == '/';
    VOLUTE_TRY(element(name, attributes));
    VOLUTE_TRY(skipTo(">"));
    if (whole)
      open_.pop_back();
    return {};
  }

  static std::string_view valueOf(const SvgAttributes& attributes, std::string_view key) {
    const auto found = attributes.find(key);
    return found == attributes.end() ? std::string_view() : std::string_view(found->second);
  }

  Status element(const std::string& name, const SvgAttributes& attributes) {
    if (open_.size() == kDeepest)
      return wrong(fmt::format("more than {} elements in each other", kDeepest));
    if (name == "svg") {
      if (!open_.empty())
        return wrong("a drawing in a drawing (svg) is not read");
      VOLUTE_TRY(takeSize(attributes));
    }
    Open one = open_.empty() ? Open() : open_.back();
    one.name = name;
    one.text = one.text || name == "text";
    VOLUTE_ASSIGN(const auto own, transformOf(valueOf(attributes, "transform")));
    one.transform = one.transform * own;
    if (name == "g") {
      for (const std::string_view key : {"inkscape:label", "id"}) {
        const std::string_view label = valueOf(attributes, key);
        if (label.empty())
          continue;
        one.within = one.within || lowerCase(label) == layer_;
        groups_.emplace(label);
      }
      found_ = found_ || one.within;
    }
    open_.push_back(std::move(one));
    return open_.back().within ? shape(name, attributes) : Status{};
  }

  /// The picture's rectangle, in the units of what is drawn.
  Status takeSize(const SvgAttributes& attributes) {
    const auto box = svgNumbers(valueOf(attributes, "viewBox"));
    const auto width = svgNumbers(valueOf(attributes, "width"));
    const auto height = svgNumbers(valueOf(attributes, "height"));
    const bool sized = !width.empty() && !height.empty() && width[0] > 0 && height[0] > 0 &&
                       !valueOf(attributes, "width").ends_with('%');
    if (box.size() == 4) {
      corner_ = {box[0], box[1]};
      size_ = {box[2], box[3]};
      constexpr double kSameShape = 0.01;
      if (sized && std::abs(std::log(width[0] / height[0] * size_.y() / size_.x())) > kSameShape)
        return wrong(
            "its viewBox is of another shape than its width and height: areas would be "
            "beside what is drawn");
    } else if (sized) {
      size_ = {width[0], height[0]};
    }
    return {};
  }

  Result<SvgTransform> transformOf(std::string_view text) const {
    SvgTransform all;
    while (text.find('(') != text.npos) {
      const auto begin = text.find('('), end = text.find(')');
      if (end == text.npos || end < begin)
        return wrong(fmt::format("transform '{}'", printable(text)));
      std::string name(text.substr(0, begin));
      std::erase_if(name, [](char c) { return c == ' ' || c == ',' || c == '\n' || c == '\t'; });
      const auto n = svgNumbers(text.substr(begin + 1, end - begin - 1));
      text.remove_prefix(end + 1);
      SvgTransform one;
      if (name == "matrix" && n.size() == 6) {
        one = {n[0], n[1], n[2], n[3], n[4], n[5]};
      } else if (name == "translate" && (n.size() == 1 || n.size() == 2)) {
        one.e = n[0], one.f = n.size() > 1 ? n[1] : 0;
      } else if (name == "scale" && (n.size() == 1 || n.size() == 2)) {
        one.a = n[0], one.d = n.back();
      } else if (name == "rotate" && (n.size() == 1 || n.size() == 3)) {
        const double angle = n[0] * std::numbers::pi / 180;
        const SvgTransform turn{
            std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle), 0, 0};
        const double x = n.size() > 1 ? n[1] : 0, y = n.size() > 1 ? n[2] : 0;
        one = SvgTransform{1, 0, 0, 1, x, y} * turn * SvgTransform{1, 0, 0, 1, -x, -y};
      } else {
        return fail(ErrorCode::kUnsupported,
                    "{}: line {}: transform '{}' is not read; expected matrix, translate, scale or "
                    "rotate",
                    file_, line(), printable(name));
      }
      all = all * one;
    }
    return all;
  }

  Vec2 placed(const Vec2& point) const {
    const Vec2 share = (open_.back().transform(point) - corner_).cwiseQuotient(size_);
    return {share.x(), 1 - share.y()};
  }

  void add(const std::vector<Vec2>& points, bool closed, const SvgAttributes& attributes) {
    if (!closed) {
      ++read_.open;
      return;
    }
    auto& outline = read_.outlines.emplace_back();
    outline.name = valueOf(attributes, "inkscape:label");
    outline.where = fmt::format("line {}", line());
    for (const Vec2& point : points) outline.points.push_back(placed(point));
  }

  Status shape(const std::string& name, const SvgAttributes& attributes) {
    const auto number = [&](std::string_view key) {
      const auto n = svgNumbers(valueOf(attributes, key));
      return n.empty() ? 0.0 : n[0];
    };
    if (name == "rect") {
      const Vec2 at(number("x"), number("y")), size(number("width"), number("height"));
      add({at, at + Vec2(size.x(), 0), at + size, at + Vec2(0, size.y())}, true, attributes);
    } else if (name == "polygon" || name == "polyline") {
      const auto n = svgNumbers(valueOf(attributes, "points"));
      std::vector<Vec2> points;
      for (std::size_t i = 0; i + 1 < n.size(); i += 2) points.emplace_back(n[i], n[i + 1]);
      if (!points.empty())
        add(points, name == "polygon" || points.front() == points.back(), attributes);
    } else if (name == "path") {
      return path(valueOf(attributes, "d"), attributes);
    } else if (name == "text") {
      words_.clear();
      textAt_ = placed({number("x"), number("y")});
    } else if (name == "tspan" && words_.empty() && attributes.contains("x")) {
      textAt_ = placed({number("x"), number("y")});
    } else if (name == "circle" || name == "ellipse") {
      ++read_.curved;
    }
    return {};
  }

  Status path(std::string_view data, const SvgAttributes& attributes) {
    SvgWords words(data);
    std::vector<Vec2> points;
    Vec2 pen(0, 0);
    bool curved = false;
    const auto end = [&](bool closed) {
      if (points.size() > 1) {
        if (curved)
          ++read_.curved;
        else
          add(points, closed || points.front() == points.back(), attributes);
      }
      if (!points.empty() && closed)
        pen = points.front();
      points.clear();
      curved = false;
    };
    char command = 0;
    while (!words.atEnd()) {
      if (const auto letter = words.letter())
        command = *letter;
      else if (command == 'M' || command == 'm')
        command = command == 'M' ? 'L' : 'l';
      const bool relative = command >= 'a';
      const char kind = relative ? static_cast<char>(command - 'a' + 'A') : command;
      if (kind == 'Z') {
        end(true);
        command = 0;
        continue;
      }
      constexpr std::string_view kKinds = "MLHVCSQTA";
      constexpr std::array<std::size_t, 9> kCounts = {2, 2, 1, 1, 6, 4, 4, 2, 7};
      const std::size_t place = kKinds.find(kind);
      if (place == kKinds.npos)
        return wrong(
            fmt::format("a path that is not understood: '{}'", printable(data.substr(0, 40))));
      std::vector<double> n;
      while (n.size() < kCounts[place]) {
        const auto number = words.number();
        if (!number)
          return wrong(
              fmt::format("a path that is not understood: '{}'", printable(data.substr(0, 40))));
        n.push_back(*number);
      }
      if (kind == 'M')
        end(false);
      else if (points.empty())
        points.push_back(pen);
      const Vec2 from = relative ? pen : Vec2(0, 0);
      if (kind == 'H')
        pen.x() = from.x() + n[0];
      else if (kind == 'V')
        pen.y() = from.y() + n[0];
      else
        pen = from + Vec2(n[n.size() - 2], n.back());
      curved = curved || place > 3;
      points.push_back(pen);
    }
    end(false);
    return {};
  }

  void addText() {
    const auto begin = words_.find_first_not_of(" \t\r\n");
    if (open_.back().within && begin != words_.npos) {
      words_.erase(words_.find_last_not_of(" \t\r\n") + 1);
      read_.texts.emplace_back(textAt_, words_.substr(begin));
    }
    words_.clear();
  }

  std::string_view text_;
  std::string file_, layer_;
  std::size_t at_ = 0;
  std::vector<Open> open_;
  std::set<std::string> groups_;
  Vec2 corner_ = Vec2::Zero(), size_ = Vec2::Zero();
  bool found_ = false;
  Vec2 textAt_ = Vec2::Zero();
  std::string words_;
  SvgLayer read_;
};

}  // namespace

Result<SvgLayer> readSvgLayer(const std::filesystem::path& file, const std::string& layer) {
  VOLUTE_ASSIGN(const auto text, readText(file, kLargestSvg));
  return SvgReader(text, file.string(), layer).read();
}

}  // namespace volute
