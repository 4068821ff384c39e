// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/written_file.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "volute/base/checksum.hpp"
#include "volute/codec/parallel_try.hpp"

namespace volute {
namespace {

constexpr std::size_t kSegmentsATask = 256;

tl::unexpected<Error> differs(const std::string& name, std::uint64_t offset,
                              std::string_view what) {
  return fail(
      ErrorCode::kIo,
      "{}: {} at byte {} differs from what was written, so the file was not kept; check the "
      "memory and the disk of this machine",
      name, what, offset);
}

Status checkHeadBytes(const InputFile& file, const std::string& name,
                      std::span<const std::byte> expected) {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  std::vector<std::byte> piece;
  for (std::size_t at = 0; at < expected.size(); at += piece.size()) {
    const auto part = expected.subspan(at, std::min(kPiece, expected.size() - at));
    piece.resize(part.size());
    VOLUTE_TRY(file.read(at, piece));
    const auto [wrong, unused] = std::ranges::mismatch(piece, part);
    if (wrong != piece.end())
      return differs(name, at + static_cast<std::size_t>(wrong - piece.begin()), "its head");
  }
  return {};
}

/// Compares what a reader finds in the head with what the encoder knows.
Status checkGrid(const InputFile& file, const std::string& name, const FileHead& expected) {
  const auto read =
      readHeadAndPages(file, std::numeric_limits<std::uint64_t>::max(), expected.info.name);
  if (!read) {
    return fail(ErrorCode::kIo, "{}: cannot be read back, so the file was not kept: {}", name,
                read.error().message);
  }
  const bool inside = expected.header.codec == static_cast<int>(kSparseCodec);  // checksums
  const auto same = [inside](const SegmentEntry& a, const SegmentEntry& b) {
    return a.size == b.size &&
           (a.size == 0 || (a.offset == b.offset && (inside || a.crc == b.crc)));
  };
  // Without any there is no list of them.
  const auto sameTiles = [](const FrameTiles& a, const FrameTiles& b) {
    const auto none = [](const auto& frame) { return frame.empty(); };
    return a == b || (std::ranges::all_of(a, none) && std::ranges::all_of(b, none));
  };
  const auto samePart = [](const FilePart& a, const FilePart& b) {
    return a.firstRow == b.firstRow && a.parameters == b.parameters && a.valueMin == b.valueMin &&
           a.valueMax == b.valueMax;
  };
  if (read->parameters == expected.parameters && read->fileBytes == expected.fileBytes &&
      read->header.reachedRms == expected.header.reachedRms &&
      read->header.reachedMaxError == expected.header.reachedMaxError &&
      std::ranges::equal(read->parts, expected.parts, samePart) &&
      read->header.support == expected.header.support && read->blocks == expected.blocks &&
      sameTiles(read->tiles, expected.tiles) &&
      std::ranges::equal(read->segments, expected.segments, same))
    return {};
  return fail(ErrorCode::kIo,
              "{}: grid '{}' differs from what was encoded, so the file was not kept", name,
              expected.info.name);
}

Status checkSegments(const InputFile& file, const std::string& name, const FileHead& head,
                     const Progress& progress) {
  const std::span<const SegmentEntry> segments = head.segments;
  const std::size_t tasks = (segments.size() + kSegmentsATask - 1) / kSegmentsATask;
  return parallelTry(tasks, [&](std::size_t task) -> Status {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: {} was not written", name);
    const std::size_t begin = task * kSegmentsATask;
    for (const SegmentEntry& segment :
         segments.subspan(begin, std::min(kSegmentsATask, segments.size() - begin))) {
      if (segment.size == 0)
        continue;
      const auto bytes = readSegment(file, head, segment);
      // What was encoded here must be that, whatever the file says.
      if (!bytes || (segment.crc != 0 && crc32(valuesOf(head, *bytes)) != segment.crc))
        return differs(name, segment.offset, "a block");
    }
    return {};
  });
}

Status checkKept(const InputFile& file, const std::string& name, const KeptTable& kept,
                 const Progress& progress) {
  std::vector<std::byte> bytes;
  for (const SegmentEntry& part : kept.parts) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: {} was not written", name);
    bytes.resize(part.size);
    VOLUTE_TRY(file.read(part.offset, bytes));
    if (crc32(bytes) != part.crc)
      return differs(name, part.offset, "what is kept");
  }
  return {};
}

}  // namespace

Status checkWritten(const InputFile& file, const std::string& name,
                    std::span<const std::byte> headBytes, std::span<const FileHead> heads,
                    const Progress& progress) {
  if (!heads.empty() && file.size() != heads.front().fileBytes) {
    return fail(ErrorCode::kIo, "{}: has {} bytes instead of {}, so the file was not kept", name,
                file.size(), heads.front().fileBytes);
  }
  VOLUTE_TRY(checkHeadBytes(file, name, headBytes));
  for (const FileHead& head : heads) {
    if (heads.size() == 1 || !head.info.name.empty())  // without a name a reader takes another grid
      VOLUTE_TRY(checkGrid(file, name, head));
    VOLUTE_TRY(checkSegments(file, name, head, progress));
    VOLUTE_TRY(checkKept(file, name, head.kept, progress));
  }
  return {};
}

Result<CheckedFile> CheckedFile::create(const std::filesystem::path& target,
                                        const std::string& name) {
  if (target == "-") {
    VOLUTE_ASSIGN(auto out, OutputFile::create(target));
    return CheckedFile(std::nullopt, std::move(out));
  }
  VOLUTE_ASSIGN(auto pending, PendingFile::create(target, name));
  VOLUTE_ASSIGN(auto out, OutputFile::create(pending.path(), pending.name()));
  return CheckedFile(std::move(pending), std::move(out));
}

Status CheckedFile::commit(std::span<const std::byte> headBytes, std::span<const FileHead> heads,
                           const Progress& progress) {
  VOLUTE_TRY(bytes_.commit());
  if (!pending_)
    return {};
  {
    VOLUTE_ASSIGN(const auto file, InputFile::open(pending_->path()));
    VOLUTE_TRY(checkWritten(file, pending_->name(), headBytes, heads, progress));
  }
  return pending_->commit();
}

}  // namespace volute
