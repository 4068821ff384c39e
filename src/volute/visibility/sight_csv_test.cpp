// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/sight_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>

#include "volute/base/parallel.hpp"
#include "volute/base/read_text.hpp"
#include "volute/io/testing.hpp"
#include "volute/visibility/testing.hpp"

namespace volute {
namespace {

using ::testing::StartsWith;

/// Two signs and as many eyes as needed, in a room.
class SightTable : public ::testing::Test {
 protected:
  /// Rows of a time from `eyes` eyes.
  SightRows rowsOf(SightRowMaker& maker, double time, std::size_t eyes) const {
    std::vector<Vec3> places;
    for (std::size_t i = 0; i < eyes; ++i)
      places.emplace_back(0.001 * static_cast<double>(i), 1 + 0.002 * static_cast<double>(i % 97),
                          1.6);
    std::vector<Sighting> sightings(eyes * signs_.size());
    lookAround(Room(0.01 * (1 + time)), signs_, places, sightings);
    return maker.make(time, places, signs_, sightings).value();
  }

  /// Few, many, few and twice many rows, through a table of a kind.
  std::string file(SightFile kind, const std::string& name) const {
    SightRowMaker maker(kind);
    auto csv = SightCsv::create(folder_.path(), kind).value();
    double time = 0;
    for (const std::size_t eyes : {std::size_t{100}, kMany, std::size_t{7}, kMany + 5000, kMany})
      EXPECT_TRUE(csv.write(rowsOf(maker, time++, eyes)));
    EXPECT_EQ(csv.finish().value(), name);
    EXPECT_EQ(csv.rows(), 2 * (3 * kMany + 5107));
    return readText(folder_ / name).value();
  }

  /// Readers in Python, pandas' too, stop after the first frame.
  static std::string decompressed(const std::string& packed) {
    EXPECT_EQ(ZSTD_findFrameCompressedSize(packed.data(), packed.size()), packed.size());
    std::string text(200 * 40 * kMany + 100000, '\0');
    const std::size_t size =
        ZSTD_decompress(text.data(), text.size(), packed.data(), packed.size());
    EXPECT_FALSE(ZSTD_isError(size)) << ZSTD_getErrorName(size);
    text.resize(ZSTD_isError(size) != 0 ? 0 : size);
    return text;
  }

  static constexpr std::size_t kMany = SightRowMaker::kManyRows / 2;

  testing::TempFolder folder_;
  std::vector<SightTarget> signs_{
      {{"exit", Vec3(30, 5, 2), -Vec3::UnitX(), {}, {}, {}}, Vec3(30, 5, 2)},
      {{"in, quotes", Vec3(0, 5, 2), Vec3::UnitX(), {}, {}, {}}, Vec3(0, 5, 2)}};
};

TEST_F(SightTable, ManyRowsArePackedWhereTheyAreMade) {
  SightRowMaker packing(SightFile::kAuto), plain(SightFile::kCsv), none(SightFile::kNone);
  EXPECT_FALSE(rowsOf(packing, 1, kMany - 1).packed);
  const SightRows packed = rowsOf(packing, 1, kMany), text = rowsOf(plain, 1, kMany);
  EXPECT_TRUE(packed.packed);
  EXPECT_FALSE(text.packed);
  EXPECT_EQ(packed.count, 2 * kMany);
  EXPECT_EQ(packed.textSize, text.bytes.size());
  EXPECT_LT(packed.bytes.size(), text.bytes.size() / 2);
  EXPECT_TRUE(rowsOf(none, 1, kMany).bytes.empty());
}

TEST_F(SightTable, AllKindsHoldTheSameText) {
  const std::string text = file(SightFile::kCsv, "sight.csv");
  EXPECT_THAT(text, StartsWith("time,eye_x"));
  ASSERT_GT(text.size(), 8'000'000u);
  EXPECT_EQ(decompressed(file(SightFile::kZst, "sight.csv.zst")), text);
  const bool large = text.size() > 10'000'000;
  const std::string either = file(SightFile::kAuto, large ? "sight.csv.zst" : "sight.csv");
  EXPECT_EQ(large ? decompressed(either) : either, text);
}

TEST_F(SightTable, ASmallTableWithManyRowsInATimeIsPlainText) {
  SightRowMaker maker(SightFile::kAuto), plain(SightFile::kCsv);
  auto csv = SightCsv::create(folder_.path(), SightFile::kAuto).value();
  ASSERT_TRUE(csv.write(rowsOf(maker, 0, kMany)));
  ASSERT_EQ(csv.finish().value(), "sight.csv");
  const std::string text = readText(folder_ / "sight.csv").value();
  const std::string rows = rowsOf(plain, 0, kMany).bytes;
  EXPECT_EQ(text.substr(text.find('\n') + 1), rows);
}

// Blocks of a piece must not use what the decoder knows from the blocks before: here these end with
// runs of one byte, which piece after piece begins with.
TEST_F(SightTable, PiecesAreIndependent) {
  auto csv = SightCsv::create(folder_.path(), SightFile::kZst).value();
  SightRowMaker maker(SightFile::kZst);
  for (int i = 0; i < 4; ++i) {
    for (const double time : {0.0, 1111.0, 1e11, 123.0})
      ASSERT_TRUE(csv.write(rowsOf(maker, time, kMany)));
    ASSERT_TRUE(csv.write({0, false, 9, "aaaaaaaaa"}));
    ASSERT_TRUE(csv.write({0, false, 3 << 20, std::string(3 << 20, '\n')}));
  }
  ASSERT_TRUE(csv.finish());
  const std::string text = decompressed(readText(folder_ / "sight.csv.zst").value());
  SightRowMaker plain(SightFile::kCsv);
  const std::string rows = rowsOf(plain, 1111, kMany).bytes;
  std::size_t found = 0;
  for (std::size_t at = 0; (at = text.find(rows, at)) != text.npos; at += rows.size()) ++found;
  EXPECT_EQ(found, 4u);
  EXPECT_EQ(text.substr(text.size() - (3 << 20) - 9, 10), "aaaaaaaaa\n");
}

TEST_F(SightTable, ItsBytesDoNotDependOnThreads) {
  std::string first;
  for (const int threads : {1, 2, 5}) {
    const ThreadLimit limit(threads);
    const std::string packed = file(SightFile::kZst, "sight.csv.zst");
    if (threads == 1)
      first = packed;
    EXPECT_TRUE(packed == first) << threads;
  }
}

}  // namespace
}  // namespace volute
