// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/container.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <string_view>

#include "volute/base/checksum.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/codec/grid_table.hpp"
#include "volute/codec/packing.hpp"

namespace volute {
namespace {

constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'V', 'L', 'T', '\r', '\n', 0x1A, '\n'};
constexpr std::uint16_t kMajor = 1;
constexpr std::uint16_t kMinor = 0;
constexpr std::size_t kPrologueBytes = 36;
constexpr std::size_t kChunkFrameBytes = 24;  // type, flags, size and two checksums
constexpr std::uint32_t kSkippable = 1;
constexpr std::array<std::string_view, 7> kTargets{"rms",       "psnr",        "ratio", "size",
                                                   "max-error", "support-rms", "look"};

// ---- writing

constexpr int kAllDecimals = 0x80;  // of frame numbers, in names

enum TimesMode : std::uint8_t { kRegularTimes = 0, kListedTimes = 1 };

// The rate that gives exactly these times, or 0. Rounded ones first: most rates are whole.
double regularRate(const VolumeInfo& info) {
  if (info.frames < 2)
    return 1;
  const double measured =
      (info.frameNumbers[1] - info.frameNumbers[0]) / (info.times[1] - info.times[0]);
  for (const double rate : {std::round(measured), measured}) {
    if (!std::isfinite(rate) || rate <= 0)
      continue;
    bool exact = true;
    for (std::size_t i = 0; exact && i < info.times.size(); ++i) {
      const double elapsed = static_cast<double>(info.frameNumbers[i]) - info.frameNumbers[0];
      exact = info.times[0] + elapsed / rate == info.times[i];
    }
    if (exact)
      return rate;
  }
  return 0;
}

void writeVolumeInfo(ByteWriter& out, const VolumeInfo& info) {
  for (const int size : {info.frames, info.z, info.y, info.x, info.channels})
    out.varint(static_cast<std::uint64_t>(size));
  for (int axis = 0; axis < 3; ++axis) out.f64(info.bounds.min[axis]);
  for (int axis = 0; axis < 3; ++axis) out.f64(info.bounds.max[axis]);
  out.u8(static_cast<std::uint8_t>(info.basis));
  std::int64_t before = 0;
  for (const int number : info.frameNumbers) {
    out.zigzag(number - before);
    before = number;
  }
  const double rate = regularRate(info);
  if (rate > 0) {
    out.u8(kRegularTimes);
    out.f64(info.times[0]);
    out.f64(rate);
  } else {
    out.u8(kListedTimes);
    for (const double time : info.times) out.f64(time);
  }
}

std::vector<std::byte> writeInfoChunk(const FileHead& head) {
  const VoluteHeader& header = head.header;
  ByteWriter out;
  for (const auto& text : {head.info.name, head.info.unit, header.writtenBy, header.provenance})
    out.string(text);
  writeVolumeInfo(out, head.info);
  const auto target =
      std::ranges::find(kTargets, std::string_view(header.targetKind)) - kTargets.begin();
  out.u8(static_cast<std::uint8_t>(target));
  for (const double value : {header.targetValue, header.reachedRms, header.reachedMaxError,
                             header.valueMin, header.valueMax}) {
    out.f64(value);
  }
  const auto tiers = head.decoder->tierLevels();
  out.varint(tiers.size());
  for (const int levels : tiers) out.varint(static_cast<std::uint64_t>(levels));
  out.varint(head.parameters.size());
  out.bytes(head.parameters);
  if (header.support) {
    const SupportError& support = *header.support;
    for (const double value : {support.rms, support.share, support.low, support.high})
      out.f64(value);
    out.u8(support.robust ? 1 : 0);
    out.varint(static_cast<std::uint64_t>(support.worstFrame));
    for (const int place : support.worstVoxel) out.varint(static_cast<std::uint64_t>(place));
  }
  const FrameScale& scale = head.info.frameScale;
  const bool counted = header.amounts.shares.size() == static_cast<std::size_t>(head.info.frames);
  if (scale != FrameScale{} || head.info.up != 0 || counted)
    out.u8(static_cast<std::uint8_t>(scale.decimals | (scale.allDecimals ? kAllDecimals : 0)));
  if (head.info.up != 0 || counted)
    out.u8(static_cast<std::uint8_t>(head.info.up == 0 ? 0 : head.info.up - 'x' + 1));
  if (counted) {
    out.f64(header.amounts.most);
    out.bytes(std::as_bytes(std::span(header.amounts.shares)));
  }
  return pack({out.view()});
}

std::vector<std::byte> writeLookChunk(const LookFigures& look) {
  ByteWriter out;
  for (const double value : {look.least, look.most, look.column}) out.f64(value);
  return out.take();
}

// Where it makes no sense there is none.
std::optional<LookFigures> readLookChunk(std::span<const std::byte> content) {
  ByteReader in(content);
  LookFigures look;
  for (double* value : {&look.least, &look.most, &look.column}) *value = in.f64();
  const bool sound = in.ok() && std::isfinite(look.least) && std::isfinite(look.most) &&
                     std::isfinite(look.column) && look.least <= 0 && look.most >= 0 &&
                     look.column >= 0 && (look.most > 0) == (look.column > 0);
  return sound ? std::optional(look) : std::nullopt;
}

// What the parts do not have in common.
std::vector<std::byte> writePartsChunk(const FileHead& head) {
  ByteWriter out;
  out.varint(head.parts.size());
  int before = 0;
  for (const FilePart& part : head.parts) {
    out.varint(static_cast<std::uint64_t>(part.firstRow - before));
    before = part.firstRow;
    out.f32(part.valueMin);
    out.f32(part.valueMax);
    const bool asInfo = part.parameters == head.parameters;
    out.varint(asInfo ? 0 : part.parameters.size());
    if (!asInfo)
      out.bytes(part.parameters);
  }
  return pack({out.view()});
}

std::vector<std::byte> writeIndexChunk(const FileHead& head) {
  ByteWriter sizes;
  ByteWriter checksums;
  for (const SegmentEntry& segment : head.segments) {
    sizes.varint(segment.size);
    if (segment.size != 0)
      checksums.u32(segment.crc);
  }
  return pack({sizes.view(), checksums.view()});
}

void writeChunk(ByteWriter& out, std::string_view type, std::span<const std::byte> payload,
                std::uint32_t flags = 0) {
  ByteWriter frame;
  frame.bytes(std::as_bytes(std::span(type)));
  frame.u32(flags);
  frame.u64(payload.size());
  out.bytes(frame.view());
  out.u32(crc32(frame.view()));
  out.bytes(payload);
  out.u32(crc32(payload));
}

// ---- reading

// @param bytes  those that a file begins with
Status readPrologue(const InputFile& file, std::span<const std::byte> bytes, FileHead& head) {
  const std::string path = file.path().string();
  const std::size_t present = bytes.size();
  const auto magic = std::as_bytes(std::span(kMagic)).first(std::min(present, kMagic.size()));
  if (present == 0 || !std::equal(magic.begin(), magic.end(), bytes.begin())) {
    return fail(ErrorCode::kInvalidData,
                "{}: is not a .volute file; expected one that starts with \\x89VLT", path);
  }
  if (present < kPrologueBytes) {
    return fail(ErrorCode::kTruncated,
                "{}: ends at byte {} inside the prologue; nothing of it can be shown", path,
                present);
  }
  ByteReader in(bytes);
  in.bytes(kMagic.size());
  head.header.versionMajor = in.u16();
  head.header.versionMinor = in.u16();
  const std::uint32_t codec = in.u32();
  head.headBytes = in.u64();
  head.fileBytes = in.u64();
  if (!checksumMatches(bytes.first(kPrologueBytes - 4), in.u32())) {
    return fail(ErrorCode::kInvalidData,
                "{}: is damaged in its first {} bytes: the checksum of the prologue is wrong", path,
                kPrologueBytes);
  }
  if (head.header.versionMajor != kMajor) {
    return fail(ErrorCode::kUnsupported,
                "{}: has format version {}.{}; this program reads {}.x, a newer one may read it",
                path, head.header.versionMajor, head.header.versionMinor, kMajor);
  }
  if (codec != kWaveletCodec && codec != kSparseCodec) {
    return fail(ErrorCode::kUnsupported,
                "{}: uses codec {}, which this program does not know; a newer one may read it",
                path, codec);
  }
  head.header.codec = static_cast<int>(codec);
  return {};
}

Status checkSizes(const InputFile& file, const FileHead& head, std::uint64_t budget) {
  const std::string path = file.path().string();
  if (head.headBytes < kPrologueBytes || head.headBytes > head.fileBytes) {
    return fail(ErrorCode::kInvalidData, "{}: states a head of {} bytes in a file of {}", path,
                head.headBytes, head.fileBytes);
  }
  if (file.size() > head.fileBytes) {
    return fail(ErrorCode::kInvalidData, "{}: has {} bytes after its end at byte {}; expected none",
                path, file.size() - head.fileBytes, head.fileBytes);
  }
  if (file.size() < head.headBytes) {
    return fail(ErrorCode::kTruncated,
                "{}: ends at byte {} inside its head of {} bytes; nothing of it can be shown", path,
                file.size(), head.headBytes);
  }
  if (head.headBytes > budget) {
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "{}: has a head of {} MiB, more than the {} MiB allowed", path,
                head.headBytes >> 20, budget >> 20);
  }
  return {};
}

// Those of one grid.
struct Chunks {
  std::span<const std::byte> info, parts, index, look;  // parts and look may be empty
};

struct AllChunks {
  std::span<const std::byte> table;  // empty: one grid, of which INFO says all
  std::span<const std::byte> kept;   // empty: nothing is kept
  std::vector<Chunks> grids;
};

// `bytes` are those from the prologue's end to headBytes.
Result<AllChunks> readChunks(std::span<const std::byte> bytes, const std::string& path) {
  AllChunks all;
  ByteReader in(bytes);
  while (in.remaining() > 0) {
    const std::size_t at = kPrologueBytes + bytes.size() - in.remaining();
    const auto frame = in.bytes(16);
    const std::uint32_t frameCrc = in.u32();
    if (!in.ok() || !checksumMatches(frame, frameCrc)) {
      return fail(ErrorCode::kInvalidData,
                  "{}: is damaged at byte {}: the checksum of a chunk's header is wrong", path, at);
    }
    ByteReader fields(frame);
    const auto type = fields.bytes(4);
    const std::string_view name(reinterpret_cast<const char*>(type.data()), type.size());
    const std::uint32_t flags = fields.u32();
    const auto payload = in.bytes(fields.u64());
    const std::uint32_t crc = in.u32();
    if (!in.ok() || !checksumMatches(payload, crc)) {
      return fail(ErrorCode::kInvalidData,
                  "{}: is damaged: the checksum of the chunk at byte {} is wrong", path, at);
    }
    const bool table = name == "GRDS", kept = name == "KEEP";
    const bool look = name == "LOOK";
    const bool known = table || kept || look || name == "INFO" || name == "PART" || name == "INDX";
    if (!known && flags != kSkippable) {
      return fail(ErrorCode::kUnsupported,
                  "{}: has a part at byte {} that this program does not know and may not skip; a "
                  "newer one may read it",
                  path, at);
    }
    if (!known)
      continue;
    // A grid begins with its INFO; of several there is a table before them.
    if (name == "INFO" && (all.grids.empty() || !all.table.empty()))
      all.grids.emplace_back();
    Chunks none;
    Chunks& grid = all.grids.empty() ? none : all.grids.back();
    std::span<const std::byte>& place = table            ? all.table
                                        : kept           ? all.kept
                                        : look           ? grid.look
                                        : name == "INFO" ? grid.info
                                        : name == "PART" ? grid.parts
                                                         : grid.index;
    const bool late = table ? !all.grids.empty() : all.grids.empty();
    if ((flags != 0 && !((table || kept || look) && flags == kSkippable)) || !place.empty() ||
        payload.empty() || late) {
      return fail(ErrorCode::kInvalidData, "{}: the chunk at byte {} is impossible there", path,
                  at);
    }
    place = payload;
  }
  if (all.grids.empty() ||
      std::ranges::any_of(all.grids, [](const Chunks& grid) { return grid.index.empty(); }))
    return fail(ErrorCode::kInvalidData, "{}: has no INFO or no INDX chunk", path);
  return all;
}

// Sizes, place and time. Whether they make sense together, VolumeInfo::validate says.
bool readVolumeInfo(ByteReader& in, VolumeInfo& info) {
  constexpr std::uint64_t kMaxSide = 1 << 30;
  for (int* size : {&info.frames, &info.z, &info.y, &info.x, &info.channels}) {
    const std::uint64_t value = in.varint();
    if (!in.ok() || value == 0 || value > kMaxSide)
      return false;
    *size = static_cast<int>(value);
  }
  for (int axis = 0; axis < 3; ++axis) info.bounds.min[axis] = in.f64();
  for (int axis = 0; axis < 3; ++axis) info.bounds.max[axis] = in.f64();
  const int basis = in.u8();
  if (basis > static_cast<int>(Basis::kCubic))
    return false;
  info.basis = static_cast<Basis>(basis);
  const auto frames = static_cast<std::size_t>(info.frames);
  if (!in.ok() || frames > in.remaining())
    return false;
  std::int64_t number = 0;
  info.frameNumbers.reserve(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    // Each step fits into 33 bits, so that the sum cannot overflow.
    const std::int64_t step = in.zigzag();
    if (std::abs(static_cast<double>(step)) > 0x1p32)
      return false;
    number += step;
    if (number < std::numeric_limits<int>::min() || number > std::numeric_limits<int>::max())
      return false;
    info.frameNumbers.push_back(static_cast<int>(number));
  }
  const int mode = in.u8();
  if (mode > kListedTimes || (mode == kListedTimes && in.remaining() / 8 < frames))
    return false;
  info.times.reserve(frames);
  const double start = mode == kRegularTimes ? in.f64() : 0;
  const double rate = mode == kRegularTimes ? in.f64() : 1;
  for (const int frame : info.frameNumbers) {
    const double elapsed = static_cast<double>(frame) - info.frameNumbers[0];
    info.times.push_back(mode == kRegularTimes ? start + elapsed / rate : in.f64());
  }
  return in.ok();
}

bool readSupport(ByteReader& in, const VolumeInfo& info, VoluteHeader& header) {
  SupportError& support = header.support.emplace();
  for (double* value : {&support.rms, &support.share, &support.low, &support.high}) {
    *value = in.f64();
    if (std::isnan(*value))
      return false;
  }
  const int flags = in.u8();
  support.robust = flags == 1;
  const std::uint64_t frame = in.varint();
  bool inside = flags <= 1 && frame < static_cast<std::uint64_t>(info.frames);
  support.worstFrame = inside ? static_cast<int>(frame) : 0;
  const std::array<int, 3> size{info.x, info.y, info.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::uint64_t place = in.varint();
    inside = inside && place < static_cast<std::uint64_t>(size[axis]);
    support.worstVoxel[axis] = inside ? static_cast<int>(place) : 0;
  }
  return in.ok() && inside;
}

Status readInfoChunk(std::span<const std::byte> content, const std::string& path, FileHead& head) {
  const auto malformed = [&path](std::string_view what) {
    return fail(ErrorCode::kInvalidData, "{}: the INFO chunk is malformed: {}", path, what);
  };
  VoluteHeader& header = head.header;
  ByteReader in(content);
  for (std::string* text :
       {&head.info.name, &head.info.unit, &header.writtenBy, &header.provenance})
    *text = in.string();
  if (!readVolumeInfo(in, head.info))
    return malformed("sizes, frame numbers or times");
  VOLUTE_TRY(head.info.validate(path));
  const std::size_t target = in.u8();
  if (target >= kTargets.size())
    return malformed("the target");
  header.targetKind = kTargets[target];
  for (double* value : {&header.targetValue, &header.reachedRms, &header.reachedMaxError,
                        &header.valueMin, &header.valueMax}) {
    *value = in.f64();
  }
  constexpr double kLargest = std::numeric_limits<float>::max();
  if (!(header.valueMin >= -kLargest && header.valueMin <= header.valueMax &&
        header.valueMax <= kLargest)) {
    return malformed("the range of the values");
  }
  std::vector<std::uint64_t> tiers(
      static_cast<std::size_t>(std::min<std::uint64_t>(in.varint(), 6)));
  for (std::uint64_t& levels : tiers) levels = in.varint();
  const auto parameters = in.bytes(in.varint());
  if (!in.ok())
    return malformed("it ends early");
  head.parameters.assign(parameters.begin(), parameters.end());
  if (header.codec == static_cast<int>(kSparseCodec) && !readSupport(in, head.info, header))
    return malformed("the error over the support");
  if (in.remaining() > 0) {
    const int scale = in.u8();
    head.info.frameScale = {scale & ~kAllDecimals, (scale & kAllDecimals) != 0};
    if (head.info.frameScale.decimals > FrameScale::kMaxDecimals)
      return malformed("the decimals of frame numbers");
  }
  if (in.remaining() > 0) {
    const int up = in.u8();
    if (up > 3)
      return malformed("the up axis");
    head.info.up = up == 0 ? '\0' : static_cast<char>('x' + up - 1);
  }
  if (in.remaining() > 0) {
    header.amounts.most = in.f64();
    const auto shares = in.bytes(static_cast<std::uint64_t>(head.info.frames));
    if (!in.ok() || !(header.amounts.most > 0) || !std::isfinite(header.amounts.most))
      return malformed("how much is in its frames");
    for (const std::byte share : shares)
      header.amounts.shares.push_back(std::to_integer<std::uint8_t>(share));
  }
  auto decoder = openWaveletDecoder(static_cast<std::uint32_t>(header.codec), parameters,
                                    {head.info.channels, static_cast<float>(header.valueMin),
                                     static_cast<float>(header.valueMax)});
  if (!decoder)
    return malformed(decoder.error().message);
  head.decoder = std::move(*decoder);
  header.offset = head.decoder->offset();
  if (!std::ranges::equal(tiers, head.decoder->tierLevels(), {}, {},
                          [](int levels) { return static_cast<std::uint64_t>(levels); })) {
    return malformed("tiers that the codec does not have");
  }
  return {};
}

// The first part begins with the first row, and each has rows.
Status readPartsChunk(std::span<const std::byte> content, const std::string& path, int rows,
                      FileHead& head) {
  const auto malformed = [&path](std::string_view what) {
    return fail(ErrorCode::kInvalidData, "{}: the PART chunk is malformed: {}", path, what);
  };
  ByteReader in(content);
  const std::uint64_t count = in.varint();
  if (!in.ok() || count == 0 || count > static_cast<std::uint64_t>(rows))
    return malformed("the number of parts");
  std::int64_t row = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t step = in.varint();
    if (!in.ok() || step >= static_cast<std::uint64_t>(rows) || (i == 0) != (step == 0) ||
        (row += static_cast<std::int64_t>(step)) >= rows)
      return malformed("where a part begins");
    FilePart part;
    part.firstRow = static_cast<int>(row);
    part.valueMin = in.f32();
    part.valueMax = in.f32();
    auto parameters = in.bytes(in.varint());
    if (!in.ok())
      return malformed("it ends early");
    if (parameters.empty())
      parameters = head.parameters;
    if (!(part.valueMin >= static_cast<float>(head.header.valueMin) &&
          part.valueMin <= part.valueMax &&
          part.valueMax <= static_cast<float>(head.header.valueMax)))
      return malformed("the range of a part's values");
    part.parameters.assign(parameters.begin(), parameters.end());
    auto decoder = openWaveletDecoder(static_cast<std::uint32_t>(head.header.codec), parameters,
                                      {head.info.channels, part.valueMin, part.valueMax});
    if (!decoder)
      return malformed(decoder.error().message);
    part.decoder = std::move(*decoder);
    if (part.decoder->blockFrames() != head.decoder->blockFrames() ||
        part.decoder->hasMeans() != head.decoder->hasMeans() ||
        part.decoder->offset() != head.decoder->offset())
      return malformed("a part whose blocks or index are unlike those of the others");
    head.parts.push_back(std::move(part));
  }
  if (in.remaining() != 0)
    return malformed("it goes on after its last part");
  return {};
}

// Of all grids, in the order of the table: tier by tier, and in each grid by grid.
std::vector<std::vector<TierPlace>> placesOf(const GridTable& table, std::uint64_t begin) {
  std::vector<std::vector<TierPlace>> places(table.rows.size());
  std::size_t tiers = 0;
  for (const GridRow& row : table.rows) tiers = std::max(tiers, row.tierBytes.size());
  for (std::size_t tier = 0; tier < tiers; ++tier) {
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      if (tier >= table.rows[i].tierBytes.size())
        continue;
      places[i].push_back({begin, table.rows[i].tierBytes[tier]});
      begin += table.rows[i].tierBytes[tier];
    }
  }
  return places;
}

// `places` of the tiers; none: they follow one another from the head to the end of the file.
Status readIndexChunk(std::span<const std::byte> content, const std::string& path,
                      const BlockGrid& grid, std::span<const TierPlace> places, FileHead& head) {
  const std::size_t tiers = head.decoder->tierLevels().size();
  ByteReader in(content);
  head.blocks.resize(grid.count());
  std::iota(head.blocks.begin(), head.blocks.end(), std::uint64_t{0});
  const std::size_t blocks = head.blocks.size();
  head.segments.resize(blocks * tiers);
  std::uint64_t offset = head.headBytes;
  bool accounted = places.empty() || places.size() == tiers;
  for (std::size_t tier = 0; accounted && tier < tiers; ++tier) {
    if (!places.empty())
      offset = places[tier].begin;
    for (std::size_t place = 0; place < blocks; ++place) {
      SegmentEntry& segment = head.segments[tier * blocks + place];
      const std::uint64_t size = in.varint();
      const auto block = static_cast<std::size_t>(head.blocks[place]);
      if (!in.ok() || size > head.decoder->maxSegmentBytes(shapeOf(grid, block), tier)) {
        return fail(ErrorCode::kInvalidData,
                    "{}: the index gives block {} an impossible size in tier {}", path, block,
                    tier);
      }
      segment = {offset, static_cast<std::uint32_t>(size), 0};
      offset += size;
    }
    accounted = places.empty() || offset == places[tier].begin + places[tier].bytes;
  }
  if (places.empty())
    accounted = offset == head.fileBytes - head.kept.storedBytes();
  for (SegmentEntry& segment : head.segments) {
    if (segment.size != 0)
      segment.crc = in.u32();
  }
  if (!in.ok() || in.remaining() != 0 || !accounted) {
    return fail(ErrorCode::kInvalidData, "{}: the index does not account for the file's {} bytes",
                path, head.fileBytes);
  }
  return {};
}

// The bytes that the content of an INDX chunk of codec 2 has at most; kTooLarge when a table of
// what codec 2 has in it does not fit.
Result<std::uint64_t> indexLimit(const FileHead& head, const std::string& path,
                                 std::uint64_t budget) {
  constexpr std::uint64_t kMaxEntryBytes = 5 + 4;
  const VolumeInfo& info = head.info;
  double blocks = static_cast<double>(head.decoder->tierLevels().size());
  for (const int side : {info.frames, info.z, info.y, info.x}) blocks *= (side + 15) / 16;
  const double bytes = blocks * (sizeof(SegmentEntry) + 9);
  if (bytes > static_cast<double>(budget) / 2) {
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "{}: needs {:.0f} MiB for its index, more than the {} MiB allowed", path,
                bytes / (1 << 20), budget >> 21);
  }
  return static_cast<std::uint64_t>(blocks) * kMaxEntryBytes;
}

Result<std::vector<std::byte>> unpackChunk(std::span<const std::byte> payload, std::uint64_t limit,
                                           const std::string& path, std::string_view name) {
  auto content = unpack(payload, limit);
  if (!content)
    return fail(content.error().code, content.error().hints, "{}: the {} chunk {}", path, name,
                content.error().message);
  return content;
}

// Of a name that no volume of the file has: `all` are those that it holds.
tl::unexpected<Error> noSuchVolume(std::span<const KeptGrid> kept, const std::string& wanted,
                                   std::string all, const std::string& path) {
  for (const KeptGrid& grid : kept)
    all += (all.empty() ? "'" : ", '") + grid.name + "' (as its bytes)";
  if (const auto at = std::ranges::find(kept, wanted, &KeptGrid::name); at != kept.end()) {
    return fail(ErrorCode::kUnsupported,
                "{}: grid '{}' is of type {}, kept as its bytes; expected a volume; the file holds "
                "{}",
                path, wanted, at->type, all);
  }
  return fail(ErrorCode::kNotFound, "{}: there is no grid '{}'; the file holds {}", path, wanted,
              all);
}

// Which grid is meant, by Options::grid.
Result<std::size_t> wantedGrid(const GridTable& table, std::span<const KeptGrid> kept,
                               const std::string& wanted, const std::string& path) {
  const auto named = [&](std::string_view name) {
    return static_cast<std::size_t>(std::ranges::find(table.rows, name, &GridRow::name) -
                                    table.rows.begin());
  };
  const std::size_t chosen = named(wanted.empty() ? VolumeInfo().name : wanted);
  const std::size_t count = table.rows.size();
  // Where all are empty, none of them.
  if (wanted.empty() && (chosen == count || table.rows[chosen].empty)) {
    return static_cast<std::size_t>(std::ranges::find(table.rows, false, &GridRow::empty) -
                                    table.rows.begin());
  }
  if (chosen == count) {
    std::string all;
    for (const GridRow& row : table.rows)
      all += (all.empty() ? "'" : ", '") + row.name + "'" + (row.empty ? " (empty)" : "");
    return noSuchVolume(kept, wanted, std::move(all), path);
  }
  if (table.rows[chosen].empty)
    return fail(ErrorCode::kInvalidData, "{}: grid '{}' is empty in all frames", path, wanted);
  return chosen;
}

// What the table says must fit to what the grids say, and to one another.
Status checkTable(const GridTable& table, const AllChunks& chunks, const FileHead& head,
                  const std::string& path) {
  const auto malformed = [&path](std::string_view what) {
    return fail(ErrorCode::kInvalidData, "{}: the table of its grids is malformed: {}", path, what);
  };
  const auto streams =
      static_cast<std::size_t>(std::ranges::count(table.rows, false, &GridRow::empty));
  if (table.rows.empty() && head.kept.grids.empty())
    return malformed("it has no grids");
  if (std::max<std::size_t>(streams, 1) != chunks.grids.size())
    return malformed(
        fmt::format("it has {} grids with values, and the file {}", streams, chunks.grids.size()));
  std::uint64_t bytes = 0;
  for (const GridRow& row : table.rows)
    for (const std::uint64_t tier : row.tierBytes) {
      if (tier > head.fileBytes || (bytes += tier) > head.fileBytes)
        return malformed("more bytes than the file has");
    }
  for (const GridRow& row : table.rows) {
    if (row.pageBytes > head.fileBytes || (bytes += row.pageBytes) > head.fileBytes)
      return malformed("more bytes than the file has");
  }
  if (bytes != head.fileBytes - head.headBytes - head.kept.storedBytes())
    return malformed(fmt::format("it does not account for the file's {} bytes", head.fileBytes));
  return {};
}

// The lists of frames must be as long as the sequence.
Status checkFrames(const FileHead& head, const std::string& path) {
  const auto frames = static_cast<std::size_t>(head.info.frames);
  const auto fits = [&](std::size_t count) { return count == 0 || count == frames; };
  bool sound = fits(head.fileMetadata.listOf.size());
  for (const KeptGrid& grid : head.kept.grids) sound = sound && grid.pieces.size() == frames;
  for (const VoluteGrid& grid : head.grids) {
    if (grid.description)
      sound = sound && fits(grid.description->metadata.listOf.size()) &&
              fits(grid.description->shifts.size()) && fits(grid.description->matrices.size());
  }
  if (sound)
    return {};
  return fail(ErrorCode::kInvalidData,
              "{}: the table of its grids is malformed: its lists are not of {} frames", path,
              frames);
}

// INFO of each grid, and what its row says. `head` becomes that of the wanted one.
Status readGrids(GridTable& table, const AllChunks& chunks, std::size_t wanted,
                 std::uint64_t budget, const std::string& path, FileHead& head) {
  const FileHead prologue = head;
  std::uint64_t held = 0;
  auto chunk = chunks.grids.begin();
  std::vector<VoluteGrid> grids;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    GridRow& row = table.rows[i];
    VoluteGrid& grid = grids.emplace_back();
    grid.description = std::move(row.description);
    grid.empty = row.empty;
    grid.bytes = std::accumulate(row.tierBytes.begin(), row.tierBytes.end(), std::uint64_t{0});
    if (row.empty) {
      grid.info.name = row.name;
      continue;
    }
    FileHead one = prologue;
    grid.look = readLookChunk(chunk->look);
    VOLUTE_ASSIGN(const auto content, unpackChunk((chunk++)->info, budget / 32, path, "INFO"));
    VOLUTE_TRY(readInfoChunk(content, path, one));
    held += 16 * static_cast<std::uint64_t>(one.info.frames) + one.parameters.size();
    if (held > budget / 8) {
      return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                  "{}: what its {} grids say of their frames takes more than the {} MiB allowed",
                  path, table.rows.size(), budget >> 23);
    }
    one.info.levelSet = grid.description && grid.description->gridClass == "level set";
    if (one.info.name != row.name)
      return fail(ErrorCode::kInvalidData, "{}: grid '{}' calls itself '{}'", path, row.name,
                  one.info.name);
    grid.info = one.info;
    grid.header = one.header;
    if (i == wanted)
      head = std::move(one);
  }
  if (wanted == grids.size()) {
    VOLUTE_ASSIGN(const auto content, unpackChunk(chunk->info, budget / 32, path, "INFO"));
    VOLUTE_TRY(readInfoChunk(content, path, head));
    if (!head.info.name.empty() || head.info.voxels() != 1)
      return fail(ErrorCode::kInvalidData, "{}: a grid '{}' stands for those without values", path,
                  head.info.name);
    head.standIn = {.info = head.info, .header = head.header, .empty = true};
  }
  for (VoluteGrid& grid : grids) {
    if (grid.empty) {
      grid.info.frames = head.info.frames;
      grid.info.frameNumbers = head.info.frameNumbers;
      grid.info.frameScale = head.info.frameScale;
      grid.info.times = head.info.times;
      if (grid.description && grid.description->type.starts_with("vec3"))
        grid.info.channels = 3;
    } else if (grid.info.frameNumbers != head.info.frameNumbers ||
               grid.info.frameScale != head.info.frameScale || grid.info.times != head.info.times) {
      return fail(ErrorCode::kInvalidData, "{}: grid '{}' has other frames than '{}'", path,
                  grid.info.name, head.info.name);
    }
  }
  head.grids = std::move(grids);
  head.grid = wanted;
  head.fileMetadata = std::move(table.fileMetadata);
  return {};
}

}  // namespace

BlockShape shapeOf(const BlockGrid& grid, std::size_t block) {
  return {grid.extents(block), grid.channels()};
}

bool checksumMatches([[maybe_unused]] std::span<const std::byte> bytes,
                     [[maybe_unused]] std::uint32_t crc) {
#ifdef VOLUTE_FUZZING_SKIP_CHECKSUMS
  return true;
#else
  return crc32(bytes) == crc;
#endif
}

static std::vector<std::byte> writeHeads(bool hasTable, std::span<const VoluteGrid> grids,
                                         const FrameMetadata& fileMetadata,
                                         std::span<FileHead> heads) {
  ByteWriter chunks;
  const bool paged = heads.front().header.codec == static_cast<int>(kSparseCodec);
  std::vector<WrittenPages> pages;
  std::uint64_t pageBytes = 0;
  for (const FileHead& head : heads) {
    if (!paged)
      break;
    pages.push_back(writePages({head.blocks, head.segments, head.means},
                               head.decoder->tierLevels().size(), head.tiles, head.info.channels,
                               head.decoder->blockFrames()));
    pageBytes += pages.back().pages.size();
  }
  if (hasTable) {
    GridTable table{{}, fileMetadata, paged};
    auto head = heads.begin();
    for (const VoluteGrid& grid : grids) {
      GridRow& row = table.rows.emplace_back();
      row.name = grid.info.name;
      row.empty = grid.empty;
      row.description = grid.description;
      if (grid.empty)
        continue;
      const std::size_t tiers = head->decoder->tierLevels().size();
      row.tierBytes.assign(tiers, 0);
      for (std::size_t i = 0; i < head->segments.size(); ++i)
        row.tierBytes[i / head->blocks.size()] += head->segments[i].size;
      if (paged)
        row.pageBytes = pages[static_cast<std::size_t>(head - heads.begin())].pages.size();
      ++head;
    }
    // Who knows no tables finds the values of a single grid where they are without one.
    const bool oneWithValues = std::ranges::count(table.rows, false, &GridRow::empty) == 1;
    writeChunk(chunks, "GRDS", pack({writeGridTable(table)}), oneWithValues ? kSkippable : 0);
  }
  for (std::size_t i = 0; i < heads.size(); ++i) {
    const FileHead& head = heads[i];
    writeChunk(chunks, "INFO", writeInfoChunk(head));
    if (!head.parts.empty())
      writeChunk(chunks, "PART", writePartsChunk(head));
    writeChunk(chunks, "INDX", paged ? pages[i].chunk : writeIndexChunk(head));
    if (head.look)
      writeChunk(chunks, "LOOK", writeLookChunk(*head.look), kSkippable);
  }
  KeptTable& kept = heads.front().kept;
  if (!kept.grids.empty())
    writeChunk(chunks, "KEEP", pack({writeKeptTable(kept)}), kSkippable);
  const std::uint64_t headBytes = kPrologueBytes + chunks.size();
  std::uint64_t fileBytes = headBytes + pageBytes;
  const auto tiersOf = [](const FileHead& head) { return head.decoder->tierLevels().size(); };
  std::size_t tiers = 0;
  for (const FileHead& head : heads) tiers = std::max(tiers, tiersOf(head));
  for (std::size_t tier = 0; tier < tiers; ++tier) {
    for (FileHead& head : heads) {
      const std::size_t blocks = head.blocks.size();
      for (std::size_t i = 0; tier < tiersOf(head) && i < blocks; ++i) {
        SegmentEntry& segment = head.segments[tier * blocks + i];
        segment.offset = fileBytes;
        fileBytes += segment.size;
      }
    }
  }
  kept.place(fileBytes);
  fileBytes += kept.storedBytes();
  for (FileHead& head : heads) {
    head.headBytes = headBytes;
    head.fileBytes = fileBytes;
  }
  ByteWriter out;
  out.bytes(std::as_bytes(std::span(kMagic)));
  out.u16(kMajor);
  out.u16(kMinor);
  out.u32(static_cast<std::uint32_t>(heads.front().header.codec));
  out.u64(headBytes);
  out.u64(fileBytes);
  out.u32(crc32(out.view()));
  out.bytes(chunks.view());
  for (const WrittenPages& one : pages) out.bytes(one.pages);
  return out.take();
}

std::vector<std::byte> writeHead(FileHead& head) {
  return writeHeads(false, {}, {}, std::span(&head, 1));
}

std::vector<std::byte> writeHead(std::span<const VoluteGrid> grids,
                                 const FrameMetadata& fileMetadata, std::span<FileHead> heads) {
  return writeHeads(true, grids, fileMetadata, heads);
}

Result<FileHead> readHead(const InputFile& file, std::uint64_t maxMemory, const std::string& grid) {
  const std::uint64_t budget = std::max(maxMemory, std::uint64_t{64} << 20);
  const std::string path = file.path().string();
  FileHead head;
  // Most heads are no longer.
  constexpr std::uint64_t kFirstBytes = 16384;
  std::vector<std::byte> whole(static_cast<std::size_t>(std::min(file.size(), kFirstBytes)));
  VOLUTE_TRY(file.read(0, whole));
  VOLUTE_TRY(readPrologue(file, whole, head));
  VOLUTE_TRY(checkSizes(file, head, budget / 4));
  const std::size_t first = whole.size();
  whole.resize(static_cast<std::size_t>(head.headBytes));
  head.requests = 1;
  head.bytesRead = first;
  if (whole.size() > first) {
    VOLUTE_TRY(file.read(first, std::span(whole).subspan(first)));
    head.requests = 2;
    head.bytesRead = whole.size();
  }
  const std::span<const std::byte> bytes = std::span(whole).subspan(kPrologueBytes);
  VOLUTE_ASSIGN(const AllChunks chunks, readChunks(bytes, path));
  if (!chunks.kept.empty()) {
    VOLUTE_ASSIGN(const auto content, unpackChunk(chunks.kept, budget / 64, path, "KEEP"));
    auto table = readKeptTable(content);
    if (!table)
      return fail(ErrorCode::kInvalidData, "{}: {}", path, table.error().message);
    head.kept = *std::move(table);
    const std::uint64_t stored = head.kept.storedBytes();
    if (stored > head.fileBytes - head.headBytes)
      return fail(ErrorCode::kInvalidData, "{}: keeps more bytes than it has", path);
    head.kept.place(head.fileBytes - stored);
  }
  std::vector<TierPlace> places;
  const bool paged = head.header.codec == static_cast<int>(kSparseCodec);
  std::uint64_t pagesBegin = head.headBytes;
  std::optional<std::uint64_t> ownPages;
  std::size_t stream = 0;  // of those with values
  if (chunks.table.empty()) {
    VOLUTE_ASSIGN(const auto content, unpackChunk(chunks.grids[0].info, budget / 32, path, "INFO"));
    VOLUTE_TRY(readInfoChunk(content, path, head));
    if (!grid.empty() && grid != head.info.name)
      return noSuchVolume(head.kept.grids, grid, "'" + head.info.name + "'", path);
    head.grids.push_back({head.info,
                          head.header,
                          {},
                          false,
                          head.fileBytes - head.headBytes - head.kept.storedBytes(),
                          readLookChunk(chunks.grids[0].look)});
  } else {
    VOLUTE_ASSIGN(const auto content, unpackChunk(chunks.table, budget / 64, path, "GRDS"));
    auto table = readGridTable(content, paged);
    if (!table) {
      return fail(ErrorCode::kInvalidData, "{}: the table of its grids is malformed: {}", path,
                  table.error().message);
    }
    VOLUTE_TRY(checkTable(*table, chunks, head, path));
    VOLUTE_ASSIGN(const std::size_t wanted, wantedGrid(*table, head.kept.grids, grid, path));
    std::uint64_t pageBytes = 0;
    for (std::size_t i = 0; i < table->rows.size(); ++i) {
      pageBytes += table->rows[i].pageBytes;
      pagesBegin += i < wanted ? table->rows[i].pageBytes : 0;
    }
    // A stand-in has neither pages nor segments.
    ownPages = 0;
    if (wanted < table->rows.size()) {
      places = placesOf(*table, head.headBytes + pageBytes)[wanted];
      ownPages = table->rows[wanted].pageBytes;
    }
    stream = static_cast<std::size_t>(std::count_if(
        table->rows.begin(), table->rows.begin() + static_cast<std::ptrdiff_t>(wanted),
        [](const GridRow& row) { return !row.empty; }));
    VOLUTE_TRY(readGrids(*table, chunks, wanted, budget, path, head));
  }
  VOLUTE_TRY(checkFrames(head, path));
  head.look = head.own().look;
  const Chunks& own = chunks.grids[stream];
  if (!own.parts.empty()) {
    VOLUTE_ASSIGN(const auto content, unpackChunk(own.parts, budget / 32, path, "PART"));
    VOLUTE_TRY(readPartsChunk(content, path, head.blockGrid().counts()[0], head));
  }
  if (paged) {
    VOLUTE_ASSIGN(const auto content, unpackChunk(own.index, budget / 16, path, "INDX"));
    const std::size_t tiers = head.decoder->tierLevels().size();
    auto table = readPageTable(content, head.blockGrid(), tiers, pagesBegin, places);
    if (!table) {
      return fail(ErrorCode::kInvalidData, "{}: the INDX chunk is malformed: {}", path,
                  table.error().message);
    }
    head.pages = std::move(*table);
    std::uint64_t end = pagesBegin + head.pages.bytes();
    for (const IndexPage& page : head.pages.pages)
      end = std::accumulate(page.sizes.begin(), page.sizes.end(), end);
    if (ownPages ? *ownPages != head.pages.bytes()
                 : end != head.fileBytes - head.kept.storedBytes()) {
      return fail(ErrorCode::kInvalidData, "{}: the index does not account for the file's {} bytes",
                  path, head.fileBytes);
    }
    return head;
  }
  VOLUTE_ASSIGN(const std::uint64_t limit, indexLimit(head, path, budget));
  VOLUTE_ASSIGN(const auto content, unpackChunk(own.index, limit, path, "INDX"));
  constexpr std::uint64_t kMaxEntryBytes = 5 + 4;
  if (content.size() < limit / kMaxEntryBytes) {
    return fail(ErrorCode::kInvalidData, "{}: the index has {} bytes for {} segments", path,
                content.size(), limit / kMaxEntryBytes);
  }
  VOLUTE_TRY(readIndexChunk(content, path, BlockGrid(head.info), places, head));
  return head;
}

Status readPages(const InputFile& file, std::uint64_t maxMemory, FileHead& head) {
  if (head.header.codec != static_cast<int>(kSparseCodec))
    return {};
  const std::uint64_t budget = std::max(maxMemory, std::uint64_t{64} << 20);
  const BlockGrid grid = head.blockGrid();
  const std::size_t tiers = head.decoder->tierLevels().size();
  std::uint64_t count = 0;
  for (const IndexPage& page : head.pages.pages) count += page.blocks;
  const std::uint64_t block = sizeof(std::uint64_t) + tiers * sizeof(SegmentEntry);
  if (count > budget / 2 / block) {
    return fail(ErrorCode::kTooLarge,
                "{}: the index of its {} blocks takes more than the {} MiB of memory allowed",
                file.path().string(), count, budget >> 21);
  }
  std::vector<PageContent> all;
  for (const IndexPage& page : head.pages.pages) {
    VOLUTE_ASSIGN(auto content, readIndexPage(file, page, grid, *head.decoder));
    all.push_back(std::move(content));
  }
  for (const PageContent& page : all) {
    head.blocks.insert(head.blocks.end(), page.blocks.begin(), page.blocks.end());
    head.means.insert(head.means.end(), page.means.begin(), page.means.end());
  }
  for (std::size_t tier = 0; tier < tiers; ++tier) {
    for (const PageContent& page : all) {
      const auto own = static_cast<std::ptrdiff_t>(page.blocks.size());
      const auto begin = page.segments.begin() + static_cast<std::ptrdiff_t>(tier) * own;
      head.segments.insert(head.segments.end(), begin, begin + own);
    }
  }
  for (std::size_t i = 0; i < head.pages.tiles.size(); ++i) {
    const int end =
        i + 1 < head.pages.tiles.size() ? head.pages.tiles[i + 1].firstRow : grid.counts()[0];
    VOLUTE_ASSIGN(auto tiles, readTilePage(file, head.pages.tiles[i], end, grid, budget / 4));
    head.tiles.resize(static_cast<std::size_t>(head.pages.tiles[i].firstRow * grid.frames()));
    head.tiles.insert(head.tiles.end(), tiles.begin(), tiles.end());
  }
  return {};
}

std::span<const std::byte> valuesOf(const FileHead& head, std::span<const std::byte> segment) {
  const bool checked = head.header.codec == static_cast<int>(kSparseCodec) && !segment.empty();
  return segment.first(segment.size() - (checked ? 4 : 0));
}

Result<FileHead> readHeadAndPages(const InputFile& file, std::uint64_t maxMemory,
                                  const std::string& grid) {
  VOLUTE_ASSIGN(auto head, readHead(file, maxMemory, grid));
  VOLUTE_TRY(readPages(file, maxMemory, head));
  return head;
}

Result<std::vector<std::byte>> readSegment(const InputFile& file, const FileHead& head,
                                           const SegmentEntry& segment) {
  std::vector<std::byte> bytes(segment.size);
  VOLUTE_TRY(file.read(segment.offset, bytes));
  const bool paged = head.header.codec == static_cast<int>(kSparseCodec);
  if (segment.size > 0 && !(paged ? isIntact(bytes) : checksumMatches(bytes, segment.crc)))
    return fail(ErrorCode::kInvalidData, "its checksum is wrong");
  return bytes;
}

}  // namespace volute
