// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/npz.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "volute/base/checksum.hpp"
#include "volute/io/grid_choice.hpp"
#include "volute/io/npy_header.hpp"

namespace volute {
namespace {

constexpr std::uint16_t kStored = 0, kDeflated = 8;

/// A file in the archive, as its central directory has it.
struct Member {
  std::string name;  ///< without .npy
  std::uint16_t method = kStored;
  std::uint32_t crc = 0;
  std::uint64_t packed = 0, size = 0;  ///< [bytes]
  std::uint64_t header = 0;            ///< where its local header is
};

/// Little-endian numbers of a record; zeros beyond its end, which `fits` tells.
class Record {
 public:
  explicit Record(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class Number>
  Number at(std::size_t offset) const {
    Number number = 0;
    for (std::size_t i = 0; i < sizeof number && offset + i < bytes_.size(); ++i) {
      number = static_cast<Number>(number | static_cast<Number>(bytes_[offset + i]) << (8 * i));
    }
    return number;
  }

  bool fits(std::size_t offset, std::size_t length) const {
    return offset <= bytes_.size() && length <= bytes_.size() - offset;
  }

  std::string text(std::size_t offset, std::size_t length) const {
    return {reinterpret_cast<const char*>(bytes_.data()) + offset, length};
  }

 private:
  std::span<const std::byte> bytes_;
};

class Archive {
 public:
  explicit Archive(const InputFile& file) : file_(file), where_(file.path().string()) {}

  Result<std::vector<Member>> members() const;

  /// Where the bytes of a member begin.
  Result<std::uint64_t> begin(const Member& member) const;

  /// The first `count` bytes, unpacked.
  Result<std::vector<std::byte>> unpacked(const Member& member, std::uint64_t count) const;

  /// The checksum of what is not packed, where that is quick.
  Status check(const Member& member, std::uint64_t begin) const;

 private:
  tl::unexpected<Error> damaged(std::string_view what) const {
    return fail(ErrorCode::kInvalidData, "{}: {}; expected what numpy.savez writes", where_, what);
  }

  Result<std::vector<std::byte>> bytes(std::uint64_t offset, std::uint64_t count) const {
    if (offset > file_.size() || count > file_.size() - offset) {
      return fail(ErrorCode::kTruncated, "{}: ends at byte {}, before its arrays do", where_,
                  file_.size());
    }
    std::vector<std::byte> read(count);
    VOLUTE_TRY(file_.read(offset, read));
    return read;
  }

  struct Directory {
    std::uint64_t offset = 0, size = 0;
  };

  Result<Directory> directory() const;
  Result<Member> member(const Record& record, std::size_t at) const;

  const InputFile& file_;
  std::string where_;
};

// At the end of the file, before a comment of up to 64 KiB.
Result<Archive::Directory> Archive::directory() const {
  constexpr std::uint64_t kEnd = 22, kLongest = 65535, kLocator = 20;
  const std::uint64_t count = std::min(file_.size(), kEnd + kLongest + kLocator);
  VOLUTE_ASSIGN(const auto tail, bytes(file_.size() - count, count));
  const Record record(tail);
  std::optional<std::size_t> found;
  for (std::size_t at = tail.size() < kEnd ? 0 : tail.size() - kEnd + 1; at-- > 0 && !found;) {
    if (record.at<std::uint32_t>(at) == 0x06054b50 &&
        at + kEnd + record.at<std::uint16_t>(at + 20) == tail.size())
      found = at;
  }
  if (!found) {
    return fail(ErrorCode::kTruncated,
                "{}: no list of arrays at its end; the file is cut off, or no .npz", where_);
  }
  Directory directory{record.at<std::uint32_t>(*found + 16), record.at<std::uint32_t>(*found + 12)};
  if (*found >= kLocator && record.at<std::uint32_t>(*found - kLocator) == 0x07064b50) {
    VOLUTE_ASSIGN(const auto large, bytes(record.at<std::uint64_t>(*found - kLocator + 8), 56));
    const Record wide(large);
    if (wide.at<std::uint32_t>(0) != 0x06064b50)
      return damaged("its list of arrays is not where it says");
    directory = {wide.at<std::uint64_t>(48), wide.at<std::uint64_t>(40)};
  }
  return directory;
}

Result<Member> Archive::member(const Record& record, std::size_t at) const {
  const std::size_t nameSize = record.at<std::uint16_t>(at + 28);
  const std::size_t extraSize = record.at<std::uint16_t>(at + 30);
  if (!record.fits(at + 46, nameSize + extraSize))
    return damaged("its list of arrays is cut off");
  if ((record.at<std::uint16_t>(at + 8) & 1U) != 0)
    return fail(ErrorCode::kUnsupported, "{}: is encrypted; save it without a password", where_);
  Member member;
  member.name = record.text(at + 46, nameSize);
  member.method = record.at<std::uint16_t>(at + 10);
  member.crc = record.at<std::uint32_t>(at + 16);
  member.packed = record.at<std::uint32_t>(at + 20);
  member.size = record.at<std::uint32_t>(at + 24);
  member.header = record.at<std::uint32_t>(at + 42);
  // Numbers that do not fit in 32 bits follow in a field of their own, in this order.
  constexpr std::uint64_t kElsewhere = std::numeric_limits<std::uint32_t>::max();
  const std::size_t end = at + 46 + nameSize + extraSize;
  for (std::size_t field = at + 46 + nameSize; field + 4 <= end;) {
    const std::size_t length = record.at<std::uint16_t>(field + 2);
    if (record.at<std::uint16_t>(field) == 1) {
      std::size_t number = field + 4;
      for (std::uint64_t* one : {&member.size, &member.packed, &member.header}) {
        if (*one != kElsewhere)
          continue;
        if (number + 8 > std::min(end, field + 4 + length))
          return damaged("an array has no size");
        *one = record.at<std::uint64_t>(number);
        number += 8;
      }
    }
    field += 4 + length;
  }
  // A byte of deflated data gives 1032 at most.
  if (member.method == kDeflated ? member.size / 1032 > member.packed
                                 : member.method == kStored && member.size != member.packed)
    return damaged(fmt::format("the sizes of '{}' contradict each other", member.name));
  return member;
}

Result<std::vector<Member>> Archive::members() const {
  constexpr std::uint64_t kLongest = 16 << 20;
  constexpr std::size_t kMax = 4096;
  VOLUTE_ASSIGN(const Directory place, directory());
  if (place.size > kLongest)
    return damaged("its list of arrays is implausibly long");
  VOLUTE_ASSIGN(const auto list, bytes(place.offset, place.size));
  const Record record(list);
  std::vector<Member> members;
  for (std::size_t at = 0; at < list.size();) {
    if (!record.fits(at, 46) || record.at<std::uint32_t>(at) != 0x02014b50)
      return damaged("its list of arrays is inconsistent");
    VOLUTE_ASSIGN(Member one, member(record, at));
    at += std::size_t{46} + record.at<std::uint16_t>(at + 28) + record.at<std::uint16_t>(at + 30) +
          record.at<std::uint16_t>(at + 32);
    constexpr std::string_view kArray = ".npy";
    if (!one.name.ends_with(kArray))
      continue;
    one.name.resize(one.name.size() - kArray.size());
    if (members.size() == kMax)
      return damaged(fmt::format("it has more than {} arrays", kMax));
    if (std::ranges::find(members, one.name, &Member::name) != members.end())
      return damaged(fmt::format("two arrays are called '{}'", one.name));
    members.push_back(std::move(one));
  }
  return members;
}

Result<std::uint64_t> Archive::begin(const Member& member) const {
  VOLUTE_ASSIGN(const auto local, bytes(member.header, 30));
  const Record record(local);
  if (record.at<std::uint32_t>(0) != 0x04034b50)
    return damaged(fmt::format("'{}' is not where the list of arrays says", member.name));
  const std::uint64_t begin =
      member.header + 30 + record.at<std::uint16_t>(26) + record.at<std::uint16_t>(28);
  if (begin > file_.size() || member.packed > file_.size() - begin) {
    return fail(ErrorCode::kTruncated, "{}: ends at byte {}, within '{}'", where_, file_.size(),
                member.name);
  }
  return begin;
}

Status Archive::check(const Member& member, std::uint64_t begin) const {
  constexpr std::uint64_t kQuick = std::uint64_t{256} << 20, kPiece = std::uint64_t{1} << 20;
  if (member.size > kQuick)
    return {};
  std::uint32_t sum = 0;
  for (std::uint64_t at = 0; at < member.size; at += kPiece) {
    VOLUTE_ASSIGN(const auto piece, bytes(begin + at, std::min(kPiece, member.size - at)));
    sum = crc32(piece, sum);
  }
  if (sum != member.crc)
    return damaged(fmt::format("'{}' differs from its checksum", member.name));
  return {};
}

Result<std::vector<std::byte>> Archive::unpacked(const Member& member, std::uint64_t count) const {
  VOLUTE_ASSIGN(const std::uint64_t begin, this->begin(member));
  count = std::min(count, member.size);
  if (member.method == kStored)
    return bytes(begin, count);
  if (member.method != kDeflated) {
    return fail(ErrorCode::kUnsupported,
                "{}: '{}' is packed by method {}; expected numpy.savez or numpy.savez_compressed",
                where_, member.name, member.method);
  }
  std::vector<std::byte> out(count);
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK)
    return fail(ErrorCode::kTooLarge, "{}: no memory to unpack '{}'", where_, member.name);
  const std::unique_ptr<z_stream, int (*)(z_stream*)> ends(&stream, inflateEnd);
  constexpr std::uint64_t kPiece = 1 << 18;
  std::vector<std::byte> in;
  std::uint64_t taken = 0, given = 0;
  int state = Z_OK;
  while (given < count && state != Z_STREAM_END) {
    if (stream.avail_in == 0) {
      if (taken == member.packed)
        break;
      VOLUTE_ASSIGN(in, bytes(begin + taken, std::min(kPiece, member.packed - taken)));
      taken += in.size();
      stream.next_in = reinterpret_cast<Bytef*>(in.data());
      stream.avail_in = static_cast<uInt>(in.size());
    }
    const auto room = static_cast<uInt>(std::min(kPiece, count - given));
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + given);
    stream.avail_out = room;
    state = inflate(&stream, Z_NO_FLUSH);
    given += room - stream.avail_out;
    if (state != Z_OK && state != Z_STREAM_END && state != Z_BUF_ERROR)
      return damaged(fmt::format("'{}' cannot be unpacked", member.name));
  }
  if (given < count)
    return damaged(fmt::format("'{}' unpacks to {} bytes of {}", member.name, given, member.size));
  if (count == member.size && crc32(out) != member.crc)
    return damaged(fmt::format("'{}' differs from its checksum", member.name));
  return out;
}

}  // namespace

Result<NpzArray> openNpzArray(const std::filesystem::path& path, const SourceOptions& options) {
  VOLUTE_ASSIGN(auto file, InputFile::open(path));
  const Archive archive(file);
  VOLUTE_ASSIGN(const auto members, archive.members());
  constexpr std::uint64_t kFront = 4096;
  std::vector<GridEntry> entries;
  for (const Member& member : members) {
    VOLUTE_ASSIGN(auto front, archive.unpacked(member, kFront));
    const std::string where = fmt::format("{}: {}", path.string(), member.name);
    const auto header = readNpyHeader(front, member.size, where);
    const bool usable = header && header->shape.size() >= 3 && header->shape.size() <= 5;
    entries.push_back({member.name,
                       header ? fmt::format("{} axes", header->shape.size()) : "no real numbers",
                       usable});
  }
  VOLUTE_ASSIGN(const std::size_t chosen,
                chooseGrid(entries, options.grid, path.string(),
                           {"array", options.usualGrid, "one with three to five axes"}));
  const Member& member = members[chosen];
  std::vector<std::string> others, rest;
  for (const GridEntry& entry : entries) {
    if (entry.name != member.name)
      (entry.usable ? others : rest).push_back(entry.name);
  }
  if (member.method == kStored) {
    VOLUTE_ASSIGN(const std::uint64_t begin, archive.begin(member));
    VOLUTE_TRY(archive.check(member, begin));
    return NpzArray{NumberFile(std::move(file), begin, member.size), member.name, others, rest};
  }
  if (member.size > options.maxMemory) {
    return fail(ErrorCode::kTooLarge,
                "{}: '{}' unpacks to {} MiB, more than the {} MiB allowed; allow more memory, or "
                "save it by numpy.savez, which does not pack",
                path.string(), member.name, member.size >> 20, options.maxMemory >> 20);
  }
  VOLUTE_ASSIGN(auto bytes, archive.unpacked(member, member.size));
  return NpzArray{NumberFile(std::move(file), std::move(bytes)), member.name, others, rest};
}

}  // namespace volute
