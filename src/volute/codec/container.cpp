// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/container.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "volute/base/checksum.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/codec/packing.hpp"

namespace volute {
namespace {

constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'V', 'L', 'T', '\r', '\n', 0x1A, '\n'};
constexpr std::uint16_t kMajor = 1;
constexpr std::uint16_t kMinor = 0;
constexpr std::size_t kPrologueBytes = 36;
constexpr std::size_t kChunkFrameBytes = 24;  // type, flags, size and two checksums
constexpr std::uint32_t kSkippable = 1;
constexpr std::array<std::string_view, 5> kTargets{"rms", "psnr", "ratio", "size", "max-error"};

// ---- writing

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
  out.u8(info.basis == Basis::kTrilinear ? 1 : 0);
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
  return pack({out.view()});
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

void writeChunk(ByteWriter& out, std::string_view type, std::span<const std::byte> payload) {
  ByteWriter frame;
  frame.bytes(std::as_bytes(std::span(type)));
  frame.u32(0);
  frame.u64(payload.size());
  out.bytes(frame.view());
  out.u32(crc32(frame.view()));
  out.bytes(payload);
  out.u32(crc32(payload));
}

// ---- reading

Status readPrologue(const InputFile& file, FileHead& head) {
  const std::string path = file.path().string();
  std::array<std::byte, kPrologueBytes> bytes{};
  const std::size_t present =
      static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), bytes.size()));
  VOLUTE_TRY(file.read(0, std::span(bytes).first(present)));
  const auto magic = std::as_bytes(std::span(kMagic)).first(std::min(present, kMagic.size()));
  if (present == 0 || !std::equal(magic.begin(), magic.end(), bytes.begin())) {
    return fail(ErrorCode::kInvalidData,
                "{}: is not a .volute file; expected one that starts with \\x89VLT", path);
  }
  if (present < bytes.size()) {
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
  if (!checksumMatches(std::span(bytes).first(kPrologueBytes - 4), in.u32())) {
    return fail(ErrorCode::kInvalidData,
                "{}: is damaged in its first {} bytes: the checksum of the prologue is wrong", path,
                kPrologueBytes);
  }
  if (head.header.versionMajor != kMajor) {
    return fail(ErrorCode::kUnsupported,
                "{}: has format version {}.{}; this program reads {}.x, a newer one may read it",
                path, head.header.versionMajor, head.header.versionMinor, kMajor);
  }
  if (codec != kWaveletCodec) {
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
    return fail(ErrorCode::kTooLarge,
                "{}: has a head of {} MiB, more than the {} MiB allowed; raise --max-memory", path,
                head.headBytes >> 20, budget >> 20);
  }
  return {};
}

struct Chunks {
  std::span<const std::byte> info, parts, index;  // parts may be empty
};

// `bytes` are those from the prologue's end to headBytes.
Result<Chunks> readChunks(std::span<const std::byte> bytes, const std::string& path) {
  Chunks chunks;
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
    std::span<const std::byte>* const place = name == "INFO"   ? &chunks.info
                                              : name == "PART" ? &chunks.parts
                                              : name == "INDX" ? &chunks.index
                                                               : nullptr;
    if (!place && flags != kSkippable) {
      return fail(ErrorCode::kUnsupported,
                  "{}: has a part at byte {} that this program does not know and may not skip; a "
                  "newer one may read it",
                  path, at);
    }
    if (!place)
      continue;
    if (flags != 0 || !place->empty() || payload.empty()) {
      return fail(ErrorCode::kInvalidData, "{}: the chunk at byte {} is impossible there", path,
                  at);
    }
    *place = payload;
  }
  if (chunks.info.empty() || chunks.index.empty()) {
    return fail(ErrorCode::kInvalidData, "{}: has no INFO or no INDX chunk", path);
  }
  return chunks;
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
  if (basis > 1)
    return false;
  info.basis = basis == 1 ? Basis::kTrilinear : Basis::kBox;
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
  auto decoder = openWaveletDecoder(parameters, {head.info.channels,
                                                 static_cast<float>(header.valueMin),
                                                 static_cast<float>(header.valueMax)});
  if (!decoder)
    return malformed(decoder.error().message);
  head.decoder = std::move(*decoder);
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
    auto decoder =
        openWaveletDecoder(parameters, {head.info.channels, part.valueMin, part.valueMax});
    if (!decoder)
      return malformed(decoder.error().message);
    part.decoder = std::move(*decoder);
    head.parts.push_back(std::move(part));
  }
  if (in.remaining() != 0)
    return malformed("it goes on after its last part");
  return {};
}

Status readIndexChunk(std::span<const std::byte> content, const std::string& path,
                      const BlockGrid& grid, FileHead& head) {
  const std::size_t tiers = head.decoder->tierLevels().size();
  const std::size_t blocks = grid.count();
  ByteReader in(content);
  head.segments.resize(blocks * tiers);
  std::uint64_t offset = head.headBytes;
  for (std::size_t tier = 0; tier < tiers; ++tier) {
    for (std::size_t block = 0; block < blocks; ++block) {
      SegmentEntry& segment = head.segments[tier * blocks + block];
      const std::uint64_t size = in.varint();
      if (!in.ok() || size > head.decoder->maxSegmentBytes(shapeOf(grid, block), tier)) {
        return fail(ErrorCode::kInvalidData,
                    "{}: the index gives block {} an impossible size in tier {}", path, block,
                    tier);
      }
      segment = {offset, static_cast<std::uint32_t>(size), 0};
      offset += size;
    }
  }
  for (SegmentEntry& segment : head.segments) {
    if (segment.size != 0)
      segment.crc = in.u32();
  }
  if (!in.ok() || in.remaining() != 0 || offset != head.fileBytes) {
    return fail(ErrorCode::kInvalidData, "{}: the index does not account for the file's {} bytes",
                path, head.fileBytes);
  }
  return {};
}

// The number of segments that an INDX chunk must have; kTooLarge when a table of them does not fit.
Result<std::uint64_t> countSegments(const FileHead& head, const std::string& path,
                                    std::uint64_t budget) {
  const VolumeInfo& info = head.info;
  double blocks = static_cast<double>(head.decoder->tierLevels().size());
  for (const int side : {info.frames, info.z, info.y, info.x}) blocks *= (side + 15) / 16;
  const double bytes = blocks * (sizeof(SegmentEntry) + 9);
  if (bytes > static_cast<double>(budget) / 2) {
    return fail(
        ErrorCode::kTooLarge,
        "{}: needs {:.0f} MiB for its index, more than the {} MiB allowed; raise --max-memory",
        path, bytes / (1 << 20), budget >> 21);
  }
  return static_cast<std::uint64_t>(blocks);
}

Result<std::vector<std::byte>> unpackChunk(std::span<const std::byte> payload, std::uint64_t limit,
                                           const std::string& path, std::string_view name) {
  auto content = unpack(payload, limit);
  if (!content)
    return fail(content.error().code, "{}: the {} chunk {}", path, name, content.error().message);
  return content;
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

std::vector<std::byte> writeHead(FileHead& head) {
  const auto info = writeInfoChunk(head);
  const auto parts = head.parts.empty() ? std::vector<std::byte>() : writePartsChunk(head);
  const auto index = writeIndexChunk(head);
  head.headBytes = kPrologueBytes + 2 * kChunkFrameBytes + info.size() + index.size();
  if (!parts.empty())
    head.headBytes += kChunkFrameBytes + parts.size();
  head.fileBytes = head.headBytes;
  for (SegmentEntry& segment : head.segments) {
    segment.offset = head.fileBytes;
    head.fileBytes += segment.size;
  }
  ByteWriter out;
  out.bytes(std::as_bytes(std::span(kMagic)));
  out.u16(kMajor);
  out.u16(kMinor);
  out.u32(static_cast<std::uint32_t>(head.header.codec));
  out.u64(head.headBytes);
  out.u64(head.fileBytes);
  out.u32(crc32(out.view()));
  writeChunk(out, "INFO", info);
  if (!parts.empty())
    writeChunk(out, "PART", parts);
  writeChunk(out, "INDX", index);
  return out.take();
}

Result<FileHead> readHead(const InputFile& file, std::uint64_t maxMemory) {
  const std::uint64_t budget = std::max(maxMemory, std::uint64_t{64} << 20);
  const std::string path = file.path().string();
  FileHead head;
  VOLUTE_TRY(readPrologue(file, head));
  VOLUTE_TRY(checkSizes(file, head, budget / 4));
  std::vector<std::byte> bytes(static_cast<std::size_t>(head.headBytes - kPrologueBytes));
  VOLUTE_TRY(file.read(kPrologueBytes, bytes));
  VOLUTE_ASSIGN(const Chunks chunks, readChunks(bytes, path));
  {
    VOLUTE_ASSIGN(const auto content, unpackChunk(chunks.info, budget / 32, path, "INFO"));
    VOLUTE_TRY(readInfoChunk(content, path, head));
  }
  if (!chunks.parts.empty()) {
    VOLUTE_ASSIGN(const auto content, unpackChunk(chunks.parts, budget / 32, path, "PART"));
    VOLUTE_TRY(readPartsChunk(content, path, BlockGrid(head.info).counts()[0], head));
  }
  VOLUTE_ASSIGN(const std::uint64_t segments, countSegments(head, path, budget));
  constexpr std::uint64_t kMaxEntryBytes = 5 + 4;
  VOLUTE_ASSIGN(const auto content,
                unpackChunk(chunks.index, segments * kMaxEntryBytes, path, "INDX"));
  if (content.size() < segments) {
    return fail(ErrorCode::kInvalidData, "{}: the index has {} bytes for {} segments", path,
                content.size(), segments);
  }
  VOLUTE_TRY(readIndexChunk(content, path, BlockGrid(head.info), head));
  return head;
}

}  // namespace volute
