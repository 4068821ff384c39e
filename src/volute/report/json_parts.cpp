// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/json_parts.hpp"

#include <charconv>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "volute/base/output_file.hpp"

namespace volute {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;

/// Writes a tree piece by piece, in the layout of Json::dump(2).
class JsonWriter {
 public:
  JsonWriter(OutputFile& file, std::ifstream& parts) : file_(file), parts_(parts) {}

  template <class PartOf>
  Status write(const Json& json, std::size_t depth, const PartOf& partOf) {
    if (json.is_binary())
      return copy(partOf(json));
    if (!json.is_structured() || json.empty()) {
      text_ += json.dump(-1, ' ', false, Json::error_handler_t::replace);
      return {};
    }
    const bool object = json.is_object();
    bool first = true;
    text_ += object ? '{' : '[';
    for (auto at = json.begin(); at != json.end(); ++at, first = false) {
      text_ += first ? "\n" : ",\n";
      text_.append(2 * (depth + 1), ' ');
      if (object)
        text_ += Json(at.key()).dump(-1, ' ', false, Json::error_handler_t::replace) + ": ";
      VOLUTE_TRY(write(*at, depth + 1, partOf));
      if (text_.size() > kPiece)
        VOLUTE_TRY(flush());
    }
    text_ += '\n';
    text_.append(2 * depth, ' ');
    text_ += object ? '}' : ']';
    return {};
  }

  Status end() {
    text_ += '\n';
    return flush();
  }

 private:
  template <class Part>
  Status copy(const Part& part) {
    VOLUTE_TRY(flush());
    parts_.seekg(static_cast<std::streamoff>(part.begin));
    for (std::uint64_t left = part.size; left > 0;) {
      text_.resize(std::min<std::uint64_t>(left, kPiece));
      if (!parts_.read(text_.data(), static_cast<std::streamsize>(text_.size())))
        return fail(ErrorCode::kIo, "a part of the report cannot be read again");
      left -= text_.size();
      VOLUTE_TRY(flush());
    }
    return {};
  }

  Status flush() {
    VOLUTE_TRY(file_.write(std::as_bytes(std::span(text_))));
    text_.clear();
    return {};
  }

  OutputFile& file_;
  std::ifstream& parts_;
  std::string text_;
};

}  // namespace

JsonParts::~JsonParts() {
  std::error_code error;
  std::filesystem::remove(file_, error);
}

Json JsonParts::add(std::string_view text) {
  std::ofstream out(file_, std::ios::binary | (parts_.empty() ? std::ios::trunc : std::ios::app));
  const Part part{parts_.empty() ? 0 : parts_.back().begin + parts_.back().size, text.size()};
  if (!out.write(text.data(), static_cast<std::streamsize>(text.size())) || !out.flush())
    kept_ = fail(ErrorCode::kIo, "{}: cannot be written: is the disk full?", file_.string());
  parts_.push_back(part);
  std::vector<std::uint8_t> place;
  for (std::size_t rest = parts_.size() - 1, i = 0; i < sizeof rest; ++i, rest >>= 8)
    place.push_back(static_cast<std::uint8_t>(rest & 255));
  return Json::binary(std::move(place));
}

Status JsonParts::write(const std::filesystem::path& path, const Json& json) const {
  VOLUTE_TRY(kept_);
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  std::ifstream parts(file_, std::ios::binary);
  JsonWriter writer(file, parts);
  VOLUTE_TRY(writer.write(json, 0, [&](const Json& one) -> const Part& {
    std::size_t place = 0;
    const auto& bytes = one.get_binary();
    for (std::size_t i = bytes.size(); i-- > 0;) place = place << 8 | bytes[i];
    return parts_[place];
  }));
  VOLUTE_TRY(writer.end());
  return file.commit();
}

void appendJson(std::string& text, double value) {
  if (!std::isfinite(value)) {
    text += "null";
    return;
  }
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
  const std::string_view number(digits, static_cast<std::size_t>(end - digits));
  text += number;
  if (number.find_first_of(".e") == number.npos)
    text += ".0";
}

}  // namespace volute
