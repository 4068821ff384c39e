// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/npy_header.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <utility>

namespace volute {
namespace {

constexpr std::string_view kMagic =
    "\x93"
    "NUMPY";

/// Reads the dictionary {'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), } in any order of
/// its keys.
class DictionaryParser {
 public:
  DictionaryParser(std::string_view text, std::string where)
      : text_(text), where_(std::move(where)) {}

  Result<NpyHeader> parse() {
    VOLUTE_TRY(expect('{'));
    bool seen[3] = {};
    for (;;) {
      skipSpaces();
      if (peek() == '}')
        break;
      VOLUTE_ASSIGN(const std::string_view key, parseString());
      VOLUTE_TRY(expect(':'));
      const int which = key == "descr" ? 0 : key == "fortran_order" ? 1 : key == "shape" ? 2 : -1;
      if (which < 0 || seen[which])
        return malformed();
      seen[which] = true;
      VOLUTE_TRY(which == 0 ? parseType() : which == 1 ? parseOrder() : parseShape());
      skipSpaces();
      if (peek() == ',')
        ++at_;
    }
    ++at_;
    if (!seen[0] || !seen[1] || !seen[2])
      return malformed();
    const auto rest = text_.substr(at_);
    if (rest.empty() || rest.back() != '\n' || rest.find_first_not_of(' ') != rest.size() - 1)
      return malformed();
    return header_;
  }

 private:
  tl::unexpected<Error> malformed() const {
    return fail(ErrorCode::kInvalidData,
                "{}: the header is damaged at byte {}; expected what numpy.save writes", where_,
                at_);
  }

  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

  void skipSpaces() {
    while (peek() == ' ') ++at_;
  }

  Status expect(char wanted) {
    skipSpaces();
    if (peek() != wanted)
      return malformed();
    ++at_;
    return {};
  }

  Result<std::string_view> parseString() {
    skipSpaces();
    const char quote = peek();
    if (quote != '\'' && quote != '"')
      return malformed();
    const auto end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos)
      return malformed();
    const auto content = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return content;
  }

  Status parseType() {
    skipSpaces();
    if (peek() == '[')
      return fail(ErrorCode::kUnsupported,
                  "{}: a structured array; expected real numbers, save one of its fields", where_);
    VOLUTE_ASSIGN(const std::string_view type, parseString());
    const auto numbers = numberTypeOf(type);
    if (!numbers || type[0] == '=') {  // the order of whose machine?
      const char kind = type.size() > 1 ? type[1] : '\0';
      return fail(ErrorCode::kUnsupported,
                  "{}: values of type '{}'{}; expected real numbers: floats of up to 64 bits, "
                  "integers or bool",
                  where_, type,
                  kind == 'c'   ? ", which are complex: save their magnitude or real part"
                  : kind == 'f' ? ": save array.astype('float64') instead"
                                : "");
    }
    header_.type = *numbers;
    return {};
  }

  Status parseOrder() {
    skipSpaces();
    for (const auto& [word, value] : {std::pair("False", false), std::pair("True", true)}) {
      if (!text_.substr(at_).starts_with(word))
        continue;
      at_ += std::string_view(word).size();
      header_.fortranOrder = value;
      return {};
    }
    return malformed();
  }

  Status parseShape() {
    VOLUTE_TRY(expect('('));
    for (;;) {
      skipSpaces();
      if (peek() == ')')
        break;
      VOLUTE_ASSIGN(const std::uint64_t extent, parseExtent());
      header_.shape.push_back(extent);
      skipSpaces();
      if (peek() == ',') {
        ++at_;
      } else if (peek() != ')') {
        return malformed();
      }
    }
    ++at_;
    return {};
  }

  Result<std::uint64_t> parseExtent() {
    constexpr std::uint64_t kMax = std::numeric_limits<std::int64_t>::max() / 16;
    const std::size_t begin = at_;
    std::uint64_t value = 0;
    for (; peek() >= '0' && peek() <= '9'; ++at_) {
      value = value * 10 + static_cast<std::uint64_t>(peek() - '0');
      if (value > kMax)
        return malformed();
    }
    if (at_ == begin || (text_[begin] == '0' && at_ - begin > 1))
      return malformed();
    return value;
  }

  std::string_view text_;
  std::string where_;
  std::size_t at_ = 0;
  NpyHeader header_;
};

}  // namespace

Result<NpyHeader> readNpyHeader(std::span<const std::byte> bytes, std::uint64_t size,
                                const std::string& where) {
  std::array<unsigned char, 12> front{};
  const std::size_t present = std::min(bytes.size(), front.size());
  if (present > 0)
    std::memcpy(front.data(), bytes.data(), present);
  const std::string_view magic(reinterpret_cast<const char*>(front.data()),
                               std::min(present, kMagic.size()));
  if (magic != kMagic)
    return fail(ErrorCode::kInvalidData, "{}: not a .npy file", where);
  const int version = front[6];
  if (present > 7 && (version < 1 || version > 3 || front[7] != 0)) {
    return fail(ErrorCode::kUnsupported,
                "{}: version {}.{} of the .npy format; expected 1.0 to 3.0", where, version,
                front[7]);
  }
  const std::size_t offset = version == 1 ? 10 : 12;
  if (present < offset)
    return fail(ErrorCode::kTruncated, "{}: ends within its header, at byte {}", where, present);
  const std::uint64_t length =
      version == 1 ? front[8] | front[9] << 8
                   : front[8] | front[9] << 8 | front[10] << 16 | std::uint64_t{front[11]} << 24;
  if (offset + length > kLongestNpyHeader)
    return fail(ErrorCode::kInvalidData, "{}: a header of {} bytes; the file is damaged", where,
                length);
  if (offset + length > bytes.size())
    return fail(ErrorCode::kTruncated, "{}: ends within its header, at byte {}", where, size);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()) + offset, length);
  VOLUTE_ASSIGN(NpyHeader header, DictionaryParser(text, where).parse());
  header.dataOffset = offset + length;
  return header;
}

std::string makeNpyHeader(const std::vector<std::uint64_t>& shape, std::string_view code) {
  constexpr std::size_t kAlignment = 64;
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': (", code);
  for (std::size_t i = 0; i < shape.size(); ++i)
    text += fmt::format("{}{}", i == 0 ? "" : ", ", shape[i]);
  text += "), }";
  const std::size_t prefix = kMagic.size() + 4;
  text.append(kAlignment - 1 - (prefix + text.size()) % kAlignment, ' ');
  text += '\n';
  std::string header(kMagic);
  header +=
      {'\1', '\0', static_cast<char>(text.size() & 0xFF), static_cast<char>(text.size() >> 8)};
  return header + text;
}

}  // namespace volute
