// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/namelist.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/number_word.hpp"
#include "volute/base/read_text.hpp"

namespace volute {

std::string capitals(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return out;
}

namespace {

constexpr int kMaxRepeats = 10000;

bool isWordEnd(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ',' || c == '/' || c == '=' ||
         c == '!' || c == '\'' || c == '"' || c == '(';
}

class NamelistScanner {
 public:
  explicit NamelistScanner(std::string_view text) : text_(text) {}

  std::vector<Namelist> all(const std::vector<std::string_view>& groups) {
    std::vector<Namelist> found;
    while (at_ < text_.size()) {
      skipBlanks();
      if (peek() != '&') {
        nextLine();
        continue;
      }
      ++at_;
      Namelist group{capitals(word()), line_, {}};
      read(group);
      if (std::ranges::find(groups, group.group) != groups.end())
        found.push_back(std::move(group));
      nextLine();
    }
    return found;
  }

 private:
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

  void skipBlanks() {
    while (peek() == ' ' || peek() == '\t' || peek() == '\r') ++at_;
  }

  void nextLine() {
    at_ = std::min(text_.find('\n', at_), text_.size());
    if (at_ < text_.size()) {
      ++at_;
      ++line_;
    }
  }

  /// Past blanks, ends of lines and comments.
  void skipComments() {
    for (skipBlanks(); peek() == '\n' || peek() == '!'; skipBlanks()) nextLine();
  }

  /// Past blanks, commas, ends of lines and comments; false where the group ends.
  bool next() {
    for (;;) {
      skipBlanks();
      if (peek() == ',') {
        ++at_;
      } else if (peek() == '\n' || peek() == '!') {
        nextLine();
        skipBlanks();
        if (peek() == '&') {  // a slash is missing: the next group begins here
          at_ = at_ == 0 ? 0 : text_.rfind('\n', at_);
          --line_;
          return false;
        }
      } else {
        break;
      }
    }
    return at_ < text_.size() && peek() != '/';
  }

  std::string_view word() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && !isWordEnd(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }

  std::string quoted(char quote) {
    std::string out;
    for (++at_; at_ < text_.size() && text_[at_] != '\n'; ++at_) {
      if (text_[at_] != quote) {
        out += text_[at_];
      } else if (at_ + 1 < text_.size() && text_[at_ + 1] == quote) {
        out += text_[++at_];
      } else {
        ++at_;
        break;
      }
    }
    return std::string(trimmed(out));
  }

  /// "(2)" or "(1:3)" of a key.
  void skipIndices() {
    if (peek() == '(')
      at_ = std::min(text_.find_first_of(")\n", at_), text_.size());
    if (peek() == ')')
      ++at_;
  }

  void read(Namelist& group) {
    std::vector<std::string>* values = nullptr;
    while (next()) {
      const char c = peek();
      if (c == '\'' || c == '"') {
        std::string text = quoted(c);
        if (values != nullptr)
          values->push_back(std::move(text));
        continue;
      }
      const std::string_view one = word();
      const std::size_t after = at_;
      const int line = line_;
      skipIndices();
      const bool indexed = at_ != after;
      skipComments();
      if (peek() == '=') {
        ++at_;
        values = &group.values[capitals(one)];
        if (!indexed)  // what is assigned again has the later value
          values->clear();
        continue;
      }
      at_ = after;
      line_ = line;
      if (one.empty()) {
        ++at_;  // what has no place here
        continue;
      }
      if (values != nullptr)
        take(one, *values);
    }
  }

  /// "3*0.5" stands three times.
  static void take(std::string_view word, std::vector<std::string>& values) {
    const std::size_t star = word.find('*');
    int count = 0;
    if (star == word.npos || !readNumber(word.substr(0, star), count) || count < 1 ||
        count > kMaxRepeats)
      values.emplace_back(word);
    else
      values.insert(values.end(), static_cast<std::size_t>(count),
                    std::string(word.substr(star + 1)));
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

/// With D instead of E, as Fortran takes it.
std::optional<double> fortranValue(std::string text) {
  for (char& c : text) c = c == 'd' || c == 'D' ? 'e' : c;
  double value = 0;
  return readNumber(std::string_view(text), value) && std::isfinite(value) ? std::optional(value)
                                                                           : std::nullopt;
}

}  // namespace

std::string Namelist::text(const std::string& key) const {
  const auto found = values.find(key);
  return found == values.end() || found->second.empty() ? "" : found->second.front();
}

std::optional<double> Namelist::number(const std::string& key) const {
  return fortranValue(text(key));
}

std::vector<Namelist> namelists(std::string_view text,
                                const std::vector<std::string_view>& groups) {
  return NamelistScanner(text).all(groups);
}

}  // namespace volute
