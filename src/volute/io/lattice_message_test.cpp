// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/lattice_message.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstring>
#include <limits>

#include "volute/io/reader_process.hpp"

namespace volute::detail {
namespace {

LatticeFrame someFrame() {
  LatticeFrame frame;
  std::strcpy(frame.grid, "density");
  std::strcpy(frame.others, "heat");
  frame.box = {{-1, 2, 3}, {4, 5, 6}};
  frame.voxelSize = {0.1, 0.2, 0.3};
  frame.origin = {1, 2, 3};
  return frame;
}

LatticeCache someCache() {
  LatticeGrid grid{someFrame(), {}, {{"creator", "string", "somebody"}}};
  std::strcpy(grid.traits.type, "float");
  grid.traits.voxels = 27;
  grid.traits.half = true;
  return {{grid, grid}, {{"frame", "int32", "7"}}};
}

TEST(LatticeMessage, CachesComeOverAsTheyAre) {
  const LatticeCache cache = someCache();
  const auto read = decodeCache(encodeCache(cache), "a.vdb");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->grids.size(), 2u);
  EXPECT_STREQ(read->grids[1].frame.grid, "density");
  EXPECT_EQ(read->grids[1].frame.box.end[2], 6);
  EXPECT_EQ(read->grids[1].traits.voxels, 27u);
  EXPECT_TRUE(read->grids[1].traits.half);
  ASSERT_EQ(read->grids[1].metadata.size(), 1u);
  EXPECT_EQ(read->grids[1].metadata[0].value, "somebody");
  ASSERT_EQ(read->metadata.size(), 1u);
  EXPECT_EQ(read->metadata[0].type, "int32");
}

TEST(LatticeMessage, CachesThatAreCutShortAreRefusedButBetweenGrids) {
  const std::string message = encodeCache(someCache());
  LatticeCache one = someCache();
  one.grids.pop_back();
  LatticeCache none = one;
  none.grids.clear();
  for (std::size_t length = 0; length < message.size(); ++length) {
    const bool whole = length == encodeCache(one).size() || length == encodeCache(none).size();
    const auto read = decodeCache(message.substr(0, length), "a.vdb");
    EXPECT_EQ(read.has_value(), whole) << length;
    if (!read) {
      EXPECT_EQ(read.error().code, ErrorCode::kInvalidData);
    }
  }
}

TEST(LatticeMessage, FramesThatCannotBeAreRefused) {
  EXPECT_TRUE(decodeFrame(toMessage(someFrame()), "a.vdb"));
  const auto refused = [](auto change) {
    LatticeFrame frame = someFrame();
    change(frame);
    const auto read = decodeFrame(toMessage(frame), "a.vdb");
    return !read && read.error().message.starts_with("a.vdb: ");
  };
  EXPECT_TRUE(refused([](auto& frame) { frame.channels = 2; }));
  EXPECT_TRUE(refused([](auto& frame) { frame.voxelSize[1] = 0; }));
  EXPECT_TRUE(
      refused([](auto& frame) { frame.origin[2] = std::numeric_limits<double>::infinity(); }));
  // Its absolute value is no int64.
  EXPECT_TRUE(
      refused([](auto& frame) { frame.box.begin[0] = std::numeric_limits<std::int64_t>::min(); }));
  EXPECT_TRUE(
      refused([](auto& frame) { frame.box.end[0] = std::numeric_limits<std::int64_t>::max(); }));
}

TEST(LatticeMessage, NamesEnd) {
  LatticeFrame frame = someFrame();
  std::memset(frame.grid, 'x', sizeof frame.grid);
  std::memset(frame.others, 'y', sizeof frame.others);
  const auto read = decodeFrame(toMessage(frame), "a.vdb");
  ASSERT_TRUE(read);
  EXPECT_EQ(std::strlen(read->grid), LatticeFrame::kMaxName);
  EXPECT_EQ(std::strlen(read->others), LatticeFrame::kMaxName);
}

TEST(LatticeMessage, FlagsAreTrueOrFalse) {
  std::string message = encodeGridFacts({GridFacts{}});
  message[offsetof(GridFacts, half)] = '\x04';
  const auto read = decodeGridFacts(message);
  ASSERT_TRUE(read);
  EXPECT_EQ(static_cast<int>(read->front().half), 1);
  EXPECT_FALSE(read->front().readable);
  message.pop_back();
  EXPECT_FALSE(decodeGridFacts(message));
}

TEST(LatticeMessage, FilesOfACollectionComeOverOrAreRefused) {
  const std::string message = encodeFiles({{1.5, "a.vtu"}, {2.5, "b c.vtu"}});
  const auto read = decodeFiles(message, "a.pvd");
  ASSERT_TRUE(read);
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ(read->at(1).time, 2.5);
  EXPECT_EQ(read->at(1).path, "b c.vtu");
  EXPECT_FALSE(decodeFiles(message.substr(0, message.size() - 1), "a.pvd"));
  EXPECT_FALSE(decodeFiles(message.substr(0, 4), "a.pvd"));
  EXPECT_FALSE(decodeFiles(encodeFiles({{1, ""}}), "a.pvd"));
}

}  // namespace
}  // namespace volute::detail
