// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/npz.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>

#include "volute/base/checksum.hpp"
#include "volute/io/npy_header.hpp"
#include "volute/io/sequence_testing.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;

std::string little(std::uint64_t number, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(number >> (8 * i) & 0xFF);
  return text;
}

struct Packed {
  std::string name;   ///< with .npy
  std::string bytes;  ///< as they are unpacked
  bool deflated = false;
};

/// As Python's zipfile writes them; `wide`: with the 64-bit sizes of large archives.
std::string archiveOf(const std::vector<Packed>& members, bool wide = false) {
  std::string file, list;
  for (const Packed& member : members) {
    std::string bytes = member.bytes;
    if (member.deflated) {
      z_stream stream{};
      deflateInit2(&stream, 6, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
      bytes.resize(deflateBound(&stream, member.bytes.size()));
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(member.bytes.data()));
      stream.avail_in = static_cast<uInt>(member.bytes.size());
      stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
      stream.avail_out = static_cast<uInt>(bytes.size());
      EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
      bytes.resize(stream.total_out);
      deflateEnd(&stream);
    }
    const std::string crc = little(crc32(std::as_bytes(std::span(member.bytes))), 4);
    const std::string method = little(member.deflated ? 8 : 0, 2);
    const std::string sizes = crc + little(bytes.size(), 4) + little(member.bytes.size(), 4);
    const std::string wideSizes = wide ? little(1, 2) + little(24, 2) +
                                             little(member.bytes.size(), 8) +
                                             little(bytes.size(), 8) + little(file.size(), 8)
                                       : "";
    list += "PK\1\2" + little(45, 2) + little(45, 2) + little(0, 2) + method + little(0, 4) +
            (wide ? crc + little(0xFFFFFFFF, 4) + little(0xFFFFFFFF, 4) : sizes) +
            little(member.name.size(), 2) + little(wideSizes.size(), 2) + little(0, 2) +
            little(0, 2) + little(0, 2) + little(0, 4) +
            little(wide ? 0xFFFFFFFF : file.size(), 4) + member.name + wideSizes;
    file += "PK\3\4" + little(45, 2) + little(0, 2) + method + little(0, 4) + sizes +
            little(member.name.size(), 2) + little(4, 2) + member.name + little(0xCAFE, 4) + bytes;
  }
  const std::size_t at = file.size();
  file += list;
  const std::size_t count = members.size();
  if (wide) {
    const std::size_t end = file.size();
    file += "PK\6\6" + little(44, 8) + little(45, 2) + little(45, 2) + little(0, 8) +
            little(count, 8) + little(count, 8) + little(list.size(), 8) + little(at, 8);
    file += "PK\6\7" + little(0, 4) + little(end, 8) + little(1, 4);
  }
  return file + "PK\5\6" + little(0, 4) + little(count, 2) + little(count, 2) +
         little(wide ? 0xFFFFFFFF : list.size(), 4) + little(wide ? 0xFFFFFFFF : at, 4) +
         little(0, 2);
}

std::string npyOf(const Sequence& sequence) {
  const VolumeInfo& info = sequence.info;
  std::string file = makeNpyHeader({std::uint64_t(info.frames), std::uint64_t(info.z),
                                    std::uint64_t(info.y), std::uint64_t(info.x)});
  return file.append(reinterpret_cast<const char*>(sequence.values.data()),
                     4 * sequence.values.size());
}

/// A file of times and two volumes.
std::vector<Packed> severalArrays(bool deflated) {
  return {{"times.npy", makeNpyHeader({2}) + std::string(8, '\0'), deflated},
          {"heat.npy", npyOf(makeBlob(2, 3, 4, 5)), deflated},
          {"density.npy", npyOf(makeBlob(1, 6, 7, 8)), deflated}};
}

TEST(Npz, AnArrayIsChosenByItsName) {
  const TempFolder folder;
  for (const bool deflated : {false, true}) {
    for (const bool wide : {false, true}) {
      writeBytes(folder / "a.npz", archiveOf(severalArrays(deflated), wide));
      SourceOptions options;
      std::string remark;
      options.remark = [&](const Remark& text) { remark += text.sentence; };
      ASSERT_VALUE(const auto usual, readSequence(folder / "a.npz", options));
      EXPECT_EQ(usual.values, makeBlob(1, 6, 7, 8).values);
      EXPECT_THAT(remark, HasSubstr("'density' is read; it also has heat"));
      EXPECT_THAT(remark, HasSubstr("axes are left out: times"));
      options.grid = "heat";
      ASSERT_VALUE(const auto heat, readSequence(folder / "a.npz", options));
      EXPECT_EQ(heat.values, makeBlob(2, 3, 4, 5).values);
      EXPECT_EQ(heat.info.name, "heat");
      options.grid = "heats";
      EXPECT_THAT(openSource(folder / "a.npz", options).error().message,
                  HasSubstr("did you mean 'heat'?"));
      options.grid = "times";
      EXPECT_THAT(openSource(folder / "a.npz", options).error().message, HasSubstr("1 axes"));
    }
  }
}

TEST(Npz, TheOnlyVolumeNeedsNoName) {
  const TempFolder folder;
  writeBytes(folder / "a.npz", archiveOf({{"times.npy", makeNpyHeader({2}) + std::string(8, '\0')},
                                          {"arr_0.npy", npyOf(makeBlob(2, 3, 4, 5))}}));
  ASSERT_VALUE(const auto read, readSequence(folder / "a.npz"));
  EXPECT_EQ(read.values, makeBlob(2, 3, 4, 5).values);
  EXPECT_EQ(read.info.name, VolumeInfo().name);
}

TEST(Npz, EveryTruncationIsRefused) {
  const TempFolder folder;
  for (const bool deflated : {false, true}) {
    const std::string bytes = archiveOf(severalArrays(deflated));
    expectCutsRefused(folder / "b.npz", bytes,
                      [](const auto& file) { return openSource(file, {}); });
  }
}

TEST(Npz, DamagedValuesAreRefused) {
  const TempFolder folder;
  for (const bool deflated : {true, false}) {
    const std::string bytes = archiveOf({{"a.npy", npyOf(makeBlob(2, 3, 4, 5)), deflated}});
    const std::size_t values = bytes.find("a.npy") + 9 + 150;
    for (std::size_t bit = 0; bit < 64; ++bit) {
      writeBytes(folder / "b.npz", withFlippedBit(bytes, 8 * values + bit));
      EXPECT_FALSE(openSource(folder / "b.npz", {})) << bit;
    }
  }
}

TEST(Npz, RefusesWhatUnpacksToTooMuch) {
  const TempFolder folder;
  writeBytes(folder / "a.npz", archiveOf({{"a.npy", npyOf(makeSequence(64, 16, 16, 16)), true}}));
  SourceOptions options;
  options.maxMemory = 1 << 20;
  EXPECT_EQ(openSource(folder / "a.npz", options).error().code, ErrorCode::kTooLarge);
  options.maxMemory = 2 << 20;
  EXPECT_TRUE(ok(openSource(folder / "a.npz", options)));
}

TEST(Npz, ALaterFileOfASequenceHasTheArrayOfTheFirst) {
  const TempFolder folder;
  const auto one = makeBlob(1, 3, 4, 5);
  const auto said = [&](const std::string& later, const std::string& first = "smoke.npy") {
    for (int i = 0; i < 3; ++i) {
      writeBytes(folder / fmt::format("s_{}.npz", i),
                 archiveOf({{i == 1 ? later : first, npyOf(one)}}));
    }
    const auto read = readSequence(folder / "s_%d.npz");
    return read ? std::string() : read.error().message;
  };
  EXPECT_EQ(said("smoke.npy"), "");
  EXPECT_THAT(said("temperature.npy"),
              HasSubstr("s_1.npz: no array named 'smoke'; it has temperature (4 axes)"));
  EXPECT_THAT(said("Smoke.npy"), HasSubstr("did you mean 'Smoke'?"));
  EXPECT_THAT(said("arr_1.npy", "arr_0.npy"), HasSubstr("no array named 'arr_0'"));
}

}  // namespace
}  // namespace volute
