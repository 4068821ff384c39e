// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/sight_csv.hpp"

#include <zstd.h>

#include <algorithm>
#include <charconv>
#include <string>
#include <vector>

#include "volute/base/parallel.hpp"
#include "volute/report/csv_cell.hpp"

namespace volute {
namespace {

constexpr std::string_view kHead =
    "time,eye_x,eye_y,eye_z,sign,distance,angle,blocked,optical_depth,optical_depth_low,"
    "optical_depth_high,mean_extinction,visibility,visible,seen\n";

/// The shortest text that reads as the same number; inf and nan by these names.
template <class T>
void append(std::string& out, T value) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value);
  out.append(text, end);
}

/// Nine digits are enough for what is computed here, and leave 0.3 as 0.3.
void appendField(std::string& out, double value) {
  out += ',';
  append(out, static_cast<float>(value));
}

void appendFlag(std::string& out, bool flag) {
  out += flag ? ",1" : ",0";
}

void appendRow(std::string& out, const std::string& head, const std::string& sign,
               const Sighting& sighting) {
  out += head;
  out += sign;
  appendField(out, sighting.distance);
  appendField(out, sighting.angle);
  appendFlag(out, sighting.blocked);
  appendField(out, sighting.depth);
  appendField(out, sighting.low);
  appendField(out, sighting.high);
  appendField(out, sighting.meanExtinction);
  appendField(out, sighting.visibility);
  appendFlag(out, sighting.visible);
  out += ',';
  out += nameOf(sighting.seen());
  out += '\n';
}

}  // namespace

/// A stream of one Zstandard frame, compressed by threads of its own while the next rows are made. Its
/// bytes do not depend on how many they are.
class SightCsv::Zst {
 public:
  Zst() : stream_(ZSTD_createCCtx(), ZSTD_freeCCtx), out_(ZSTD_CStreamOutSize()) {
    ZSTD_CCtx_setParameter(stream_.get(), ZSTD_c_compressionLevel, 3);
    ZSTD_CCtx_setParameter(stream_.get(), ZSTD_c_checksumFlag, 1);
    // Fails, and changes nothing, where the library has no threads.
    // Each has tens of megabytes, and rows are made no faster than a few can compress.
    ZSTD_CCtx_setParameter(stream_.get(), ZSTD_c_nbWorkers, std::clamp(threadCount(), 1, 4));
  }

  Status write(OutputFile& file, std::string_view text, bool end) {
    ZSTD_inBuffer in{text.data(), text.size(), 0};
    for (;;) {
      ZSTD_outBuffer out{out_.data(), out_.size(), 0};
      const std::size_t left =
          ZSTD_compressStream2(stream_.get(), &out, &in, end ? ZSTD_e_end : ZSTD_e_continue);
      if (ZSTD_isError(left) != 0)
        return fail(ErrorCode::kIo, "sight.csv.zst: {}", ZSTD_getErrorName(left));
      VOLUTE_TRY(file.write(std::span(out_).first(out.pos)));
      if (end ? left == 0 : in.pos == in.size)
        return {};
    }
  }

 private:
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> stream_;
  std::vector<std::byte> out_;
};

Result<SightFile> sightFile(std::string_view name) {
  constexpr std::pair<std::string_view, SightFile> kNames[] = {{"auto", SightFile::kAuto},
                                                               {"none", SightFile::kNone},
                                                               {"csv", SightFile::kCsv},
                                                               {"csv.zst", SightFile::kZst}};
  for (const auto& [known, kind] : kNames) {
    if (known == name)
      return kind;
  }
  return fail(ErrorCode::kInvalidArgument, "'{}': expected auto, none, csv or csv.zst", name);
}

SightCsv::SightCsv(std::filesystem::path folder, SightFile kind)
    : folder_(std::move(folder)), kind_(kind) {}

SightCsv::~SightCsv() = default;
SightCsv::SightCsv(SightCsv&&) noexcept = default;

Result<SightCsv> SightCsv::create(const std::filesystem::path& folder, SightFile kind) {
  SightCsv csv(folder, kind);
  if (kind == SightFile::kCsv || kind == SightFile::kZst)
    VOLUTE_TRY(csv.openFile(kind));
  VOLUTE_TRY(csv.addText(kHead));
  return csv;
}

Status SightCsv::openFile(SightFile kind) {
  kind_ = kind;
  VOLUTE_ASSIGN(auto file, OutputFile::create(
                             folder_ / (kind == SightFile::kZst ? "sight.csv.zst" : "sight.csv")));
  file_.emplace(std::move(file));
  if (kind == SightFile::kZst)
    zst_ = std::make_unique<Zst>();
  return {};
}

Status SightCsv::put(std::string_view text) {
  return zst_ ? zst_->write(*file_, text, false) : file_->write(std::as_bytes(std::span(text)));
}

Status SightCsv::addText(std::string_view text) {
  constexpr std::size_t kPlain = 10'000'000;  // bytes
  if (kind_ == SightFile::kNone)
    return {};
  if (kind_ != SightFile::kAuto)
    return put(text);
  waiting_ += text;
  if (waiting_.size() <= kPlain)
    return {};
  VOLUTE_TRY(openFile(SightFile::kZst));
  const std::string waiting = std::move(waiting_);
  return put(waiting);
}

Result<std::string> SightCsv::finish() {
  if (kind_ == SightFile::kNone)
    return std::string();
  if (kind_ == SightFile::kAuto) {
    VOLUTE_TRY(openFile(SightFile::kCsv));
    VOLUTE_TRY(put(waiting_));
  }
  if (zst_)
    VOLUTE_TRY(zst_->write(*file_, {}, true));
  VOLUTE_TRY(file_->commit());
  return std::string(zst_ ? "sight.csv.zst" : "sight.csv");
}

std::string SightCsv::rowsOf(double time, std::span<const Vec3> eyes,
                             std::span<const SightTarget> signs,
                             std::span<const Sighting> sightings) {
  constexpr std::size_t kEyes = 512;
  std::vector<std::string> names;
  for (const SightTarget& sign : signs) names.push_back(csvCell(sign.sign.name));
  std::string when;
  append(when, time);
  std::vector<std::string> parts((eyes.size() + kEyes - 1) / kEyes);
  parallelFor(parts.size(), [&](std::size_t p) {
    for (std::size_t i = p * kEyes; i < std::min(eyes.size(), (p + 1) * kEyes); ++i) {
      std::string head = when;
      for (int axis = 0; axis < 3; ++axis) appendField(head, eyes[i][axis]);
      head += ',';
      for (std::size_t s = 0; s < signs.size(); ++s)
        appendRow(parts[p], head, names[s], sightings[s * eyes.size() + i]);
    }
  });
  std::string rows;
  for (const std::string& part : parts) rows += part;
  return rows;
}

Status SightCsv::write(std::string_view rows, std::uint64_t count) {
  rows_ += count;
  return addText(rows);
}

}  // namespace volute
