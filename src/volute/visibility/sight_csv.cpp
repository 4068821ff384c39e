// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/sight_csv.hpp"

#include <zstd.h>

#include <algorithm>
#include <charconv>
#include <mutex>
#include <utility>

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

/// Ten digits: a place in a map's coordinates is some million metres from their origin.
void appendPlace(std::string& out, double value) {
  char text[32];
  const auto [end, error] =
      std::to_chars(text, text + sizeof text, value, std::chars_format::general, 10);
  out += ',';
  out.append(text, end);
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
  appendField(out, sighting.meanExtinction());
  appendField(out, sighting.visibility());
  appendFlag(out, sighting.visible);
  out += ',';
  out += nameOf(sighting.seen());
  out += '\n';
}

Error zstdError(std::size_t code) {
  return {ErrorCode::kIo, fmt::format("sight.csv.zst: {}", ZSTD_getErrorName(code))};
}

// sight.csv.zst is one Zstandard frame (RFC 8878), as some readers, pandas among them, silently
// stop after the first. Its blocks are compressed in pieces that do not depend on each other.
constexpr int kWindowLog = 21;
/// Magic number; neither size nor checksum of the content; window.
constexpr std::string_view kFrameHead("\x28\xB5\x2F\xFD\x00\x58", 6);
static_assert(kFrameHead[5] == (kWindowLog - 10) << 3);
/// The last block, which is empty.
constexpr std::string_view kFrameEnd("\x01\x00\x00", 3);

/// Text of rows that are packed.
Result<std::string> unpacked(const SightRows& rows) {
  std::string frame(kFrameHead);
  frame.append(rows.bytes).append(kFrameEnd);
  std::string text(rows.textSize, '\0');
  const std::size_t size = ZSTD_decompress(text.data(), text.size(), frame.data(), frame.size());
  if (ZSTD_isError(size) != 0)
    return tl::unexpected<Error>(zstdError(size));
  return text;
}

}  // namespace

/// Compresses pieces of text into blocks that can follow any others in a frame of kFrameHead.
///
/// Zstandard's own threads compress jobs that cannot know what the one before has left: neither the
/// last offsets nor entropy tables nor, without overlap, its text. Each flush ends a job, so the
/// blocks of all jobs but the first, which has the frame's header, stand by themselves.
class SightPacker {
 public:
  Result<std::string> pack(std::string_view text) {
    VOLUTE_ASSIGN(Context context, take());
    ZSTD_CCtx_reset(context.get(), ZSTD_reset_session_only);
    std::string packed(ZSTD_compressBound(text.size()) + 1024, '\0');
    VOLUTE_TRY(flush(*context, "\n", packed));
    VOLUTE_ASSIGN(const std::size_t size, flush(*context, text, packed));
    packed.resize(size);
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(context));
    return packed;
  }

 private:
  struct Free {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  };

  using Context = std::unique_ptr<ZSTD_CCtx, Free>;

  /// Compresses text as jobs of its own into `out`. @return bytes
  static Result<std::size_t> flush(ZSTD_CCtx& context, std::string_view text, std::string& out) {
    ZSTD_inBuffer from{text.data(), text.size(), 0};
    ZSTD_outBuffer to{out.data(), out.size(), 0};
    for (std::size_t left = 1; left > 0;) {
      left = ZSTD_compressStream2(&context, &to, &from, ZSTD_e_flush);
      if (ZSTD_isError(left) != 0)
        return tl::unexpected<Error>(zstdError(left));
      if (left > 0 && to.pos == to.size) {
        out.resize(2 * out.size());
        to.dst = out.data(), to.size = out.size();
      }
    }
    return to.pos;
  }

  /// One for each thread that packs, as each has some megabytes and a thread.
  Result<Context> take() {
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        Context context = std::move(idle_.back());
        idle_.pop_back();
        return context;
      }
    }
    Context context(ZSTD_createCCtx());
    if (!context)
      return fail(ErrorCode::kTooLarge, "sight.csv.zst: there is no memory left to compress it");
    constexpr int kNoOverlap = 1, kJob = 1 << 21;
    for (const auto& [parameter, value] :
         {std::pair(ZSTD_c_compressionLevel, 3), std::pair(ZSTD_c_windowLog, kWindowLog),
          std::pair(ZSTD_c_nbWorkers, 1), std::pair(ZSTD_c_overlapLog, kNoOverlap),
          std::pair(ZSTD_c_jobSize, kJob)}) {
      if (const auto code = ZSTD_CCtx_setParameter(context.get(), parameter, value);
          ZSTD_isError(code) != 0) {
        return fail(ErrorCode::kUnsupported, Hint::set("sight", "csv"),
                    "sight.csv.zst: Zstandard was built here without threads ({})",
                    ZSTD_getErrorName(code));
      }
    }
    return context;
  }

  std::mutex mutex_;
  std::vector<Context> idle_;
};

SightRowMaker::SightRowMaker(SightFile kind)
    : kind_(kind), packer_(std::make_unique<SightPacker>()) {}

SightRowMaker::~SightRowMaker() = default;
SightRowMaker::SightRowMaker(SightRowMaker&&) noexcept = default;

Result<SightRows> SightRowMaker::make(double time, std::span<const Vec3> eyes,
                                      std::span<const SightTarget> signs,
                                      std::span<const Sighting> sightings) {
  SightRows rows;
  rows.count = sightings.size();
  if (kind_ == SightFile::kNone)
    return rows;
  rows.packed = kind_ != SightFile::kCsv && rows.count >= kManyRows;
  constexpr std::size_t kRows = 16384;  // of a piece, 1.5 MB of text or more
  const std::size_t most = std::max<std::size_t>(kRows / std::max<std::size_t>(signs.size(), 1), 1);
  std::vector<std::string> names;
  for (const SightTarget& sign : signs) names.push_back(csvCell(sign.sign.name));
  std::string when;
  append(when, time);
  std::vector<Result<std::string>> parts((eyes.size() + most - 1) / most);
  std::vector<std::size_t> sizes(parts.size());
  parallelFor(parts.size(), [&](std::size_t p) {
    const std::size_t begin = p * most, end = std::min(eyes.size(), begin + most);
    std::string text;
    text.reserve((end - begin) * signs.size() * 128);
    for (std::size_t i = begin; i < end; ++i) {
      std::string head = when;
      for (int axis = 0; axis < 3; ++axis) appendPlace(head, eyes[i][axis]);
      head += ',';
      for (std::size_t s = 0; s < signs.size(); ++s)
        appendRow(text, head, names[s], sightings[s * eyes.size() + i]);
    }
    sizes[p] = text.size();
    parts[p] = rows.packed ? packer_->pack(text) : Result<std::string>(std::move(text));
  });
  for (std::size_t p = 0; p < parts.size(); ++p) {
    VOLUTE_ASSIGN(const auto part, std::move(parts[p]));
    rows.bytes += part;
    rows.textSize += sizes[p];
  }
  return rows;
}

/// sight.csv.zst. Text of times with few rows is packed here, some megabytes at once.
class SightCsv::Zst {
 public:
  Status begin(OutputFile& file) { return put(file, kFrameHead); }

  Status write(OutputFile& file, const SightRows& rows) {
    if (!rows.packed) {
      text_ += rows.bytes;
      return text_.size() < kPieces * kPiece ? Status() : packText(file);
    }
    VOLUTE_TRY(packText(file));
    return put(file, rows.bytes);
  }

  Status end(OutputFile& file) {
    VOLUTE_TRY(packText(file));
    return put(file, kFrameEnd);
  }

 private:
  static constexpr std::size_t kPiece = std::size_t{2} << 20, kPieces = 8;

  static Status put(OutputFile& file, std::string_view bytes) {
    return file.write(std::as_bytes(std::span(bytes)));
  }

  Status packText(OutputFile& file) {
    std::vector<Result<std::string>> pieces((text_.size() + kPiece - 1) / kPiece);
    parallelFor(pieces.size(), [&](std::size_t i) {
      pieces[i] = packer_.pack(std::string_view(text_).substr(i * kPiece, kPiece));
    });
    text_.clear();
    for (const auto& piece : pieces) {
      VOLUTE_TRY(piece);
      VOLUTE_TRY(put(file, *piece));
    }
    return {};
  }

  SightPacker packer_;
  std::string text_;
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
  VOLUTE_TRY(csv.add({0, false, kHead.size(), std::string(kHead)}));
  return csv;
}

Status SightCsv::openFile(SightFile kind) {
  kind_ = kind;
  VOLUTE_ASSIGN(auto file, OutputFile::create(folder_ / (kind == SightFile::kZst ? "sight.csv.zst"
                                                                                 : "sight.csv")));
  file_.emplace(std::move(file));
  if (kind != SightFile::kZst)
    return {};
  zst_ = std::make_unique<Zst>();
  return zst_->begin(*file_);
}

Status SightCsv::put(const SightRows& rows) {
  if (zst_)
    return zst_->write(*file_, rows);
  if (!rows.packed)
    return file_->write(std::as_bytes(std::span(rows.bytes)));
  VOLUTE_ASSIGN(const auto text, unpacked(rows));
  return file_->write(std::as_bytes(std::span(text)));
}

Status SightCsv::add(SightRows rows) {
  constexpr std::uint64_t kPlain = 10'000'000;  // bytes
  if (kind_ == SightFile::kNone)
    return {};
  if (kind_ != SightFile::kAuto)
    return put(rows);
  waitingSize_ += rows.textSize;
  waiting_.push_back(std::move(rows));
  if (waitingSize_ <= kPlain)
    return {};
  VOLUTE_TRY(openFile(SightFile::kZst));
  return putWaiting();
}

Status SightCsv::putWaiting() {
  for (const SightRows& rows : std::exchange(waiting_, {})) VOLUTE_TRY(put(rows));
  return {};
}

Result<std::string> SightCsv::finish() {
  if (kind_ == SightFile::kNone)
    return std::string();
  if (kind_ == SightFile::kAuto) {
    VOLUTE_TRY(openFile(SightFile::kCsv));
    VOLUTE_TRY(putWaiting());
  }
  if (zst_)
    VOLUTE_TRY(zst_->end(*file_));
  VOLUTE_TRY(file_->commit());
  return std::string(zst_ ? "sight.csv.zst" : "sight.csv");
}

Status SightCsv::write(SightRows rows) {
  rows_ += rows.count;
  return add(std::move(rows));
}

}  // namespace volute
