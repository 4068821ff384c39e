// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/npy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "volute/grid/rounding_source.hpp"
#include "volute/io/npy_header.hpp"
#include "volute/io/sequence_testing.hpp"
#include "volute/io/testing.hpp"
#include "volute/io/volume_sink.hpp"

namespace volute {
namespace {

using namespace testing;

/// A file of version 1 with this dictionary and `dataBytes` zeros.
std::string npyFile(const std::string& dictionary, std::size_t dataBytes) {
  std::string text = dictionary + "\n";
  std::string file =
      "\x93"
      "NUMPY";
  file += {'\1', '\0', static_cast<char>(text.size() & 0xFF), static_cast<char>(text.size() >> 8)};
  return file + text + std::string(dataBytes, '\0');
}

std::string dictionary(const std::string& type, const std::string& shape,
                       const std::string& order = "False") {
  return "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }";
}

RC_GTEST_PROP(Npy, ReadsWhatItWrites, ()) {
  const TempFolder folder;
  const auto side = rc::gen::inRange(1, 6);
  const auto written = makeBlob(*side, *side, *side, *side, *rc::gen::element(1, 3));
  const auto file = folder / *rc::gen::element("a.npy", "A.NPY");
  RC_ASSERT(writeAll(file, written).has_value());
  const auto read = readSequence(file);
  RC_ASSERT(read.has_value());
  RC_ASSERT(read->values == written.values);
  RC_ASSERT(read->info.frames == written.info.frames);
  RC_ASSERT(read->info.channels == written.info.channels);
}

TEST(Npy, HeaderIsPaddedAsNumPyDoes) {
  const std::string header = makeNpyHeader({2, 3, 4, 5});
  EXPECT_EQ(header.size() % 64, 0u);
  EXPECT_EQ(header.substr(10, 67),
            "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 4, 5), }  ");
  EXPECT_EQ(header.back(), '\n');
}

TEST(Npy, KeepsNaNAndInfinity) {
  const TempFolder folder;
  auto sequence = makeSequence(1, 1, 1, 3);
  sequence.values = {std::numeric_limits<float>::quiet_NaN(),
                     std::numeric_limits<float>::infinity(), -0.0f};
  ASSERT_TRUE(ok(writeAll(folder / "a.npy", sequence)));
  ASSERT_VALUE(const auto read, readSequence(folder / "a.npy"));
  EXPECT_EQ(std::memcmp(read.values.data(), sequence.values.data(), 12), 0);
}

TEST(Npy, ThreeAxesAreOneFrame) {
  const TempFolder folder;
  writeBytes(folder / "a.npy", npyFile(dictionary("<f4", "(2, 3, 4)"), 96));
  ASSERT_VALUE(const auto source, openSource(folder / "a.npy", {}));
  const VolumeInfo& info = source->info();
  EXPECT_EQ(info.frames, 1);
  EXPECT_EQ(info.z, 2);
  EXPECT_EQ(info.y, 3);
  EXPECT_EQ(info.x, 4);
  EXPECT_EQ(info.bounds.max, Vec3(1, 0.75, 0.5));
}

TEST(Npy, ReadsHalves) {
  const TempFolder folder;
  std::string file = npyFile(dictionary("<f2", "(1, 1, 4)"), 0);
  for (unsigned half : {0x3C00u, 0xC000u, 0x7C00u, 0x0001u})
    file += {char(half & 0xFF), char(half >> 8)};
  writeBytes(folder / "a.npy", file);
  ASSERT_VALUE(const auto read, readSequence(folder / "a.npy"));
  EXPECT_EQ(read.values,
            (std::vector<float>{1, -2, std::numeric_limits<float>::infinity(), 0x1p-24f}));
}

/// The bytes of a number in either order.
template <class T>
std::string bytesOf(T number, bool bigEndian) {
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  if (bigEndian != (std::endian::native == std::endian::big))
    std::ranges::reverse(bytes);
  return bytes;
}

/// A file with these numbers of shape (t, z, y, x, c), in either order of bytes and of axes.
template <class T>
std::string arrayFile(const std::string& code, const Sequence& numbers, bool fortran) {
  const VolumeInfo& info = numbers.info;
  const auto shape =
      fmt::format("({}, {}, {}, {}, {})", info.frames, info.z, info.y, info.x, info.channels);
  std::string file = npyFile(dictionary(code, shape, fortran ? "True" : "False"), 0);
  const auto append = [&](int t, int z, int y, int x, int c) {
    const auto at = (((t * info.z + z) * info.y + y) * info.x + x) * info.channels + c;
    file += bytesOf(static_cast<T>(numbers.values[static_cast<std::size_t>(at)]), code[0] == '>');
  };
  const auto each = [](int count, const auto& body) {
    for (int i = 0; i < count; ++i) body(i);
  };
  if (fortran) {
    each(info.channels, [&](int c) {
      each(info.x, [&](int x) {
        each(info.y, [&](int y) {
          each(info.z, [&](int z) { each(info.frames, [&](int t) { append(t, z, y, x, c); }); });
        });
      });
    });
  } else {
    each(info.frames, [&](int t) {
      each(info.z, [&](int z) {
        each(info.y, [&](int y) {
          each(info.x, [&](int x) { each(info.channels, [&](int c) { append(t, z, y, x, c); }); });
        });
      });
    });
  }
  return file;
}

RC_GTEST_PROP(Npy, EveryTypeAndOrderGivesTheSameVolume, ()) {
  const TempFolder folder;
  const auto side = rc::gen::inRange(1, 6);
  auto numbers = makeBlob(*side, *side, *side, *side, *rc::gen::element(1, 3));
  for (float& value : numbers.values) value = std::floor(value);
  const bool fortran = *rc::gen::arbitrary<bool>();
  const auto same = [&](const std::string& file) {
    writeBytes(folder / "a.npy", file);
    SourceOptions options;
    // Frames of an array in Fortran's order are read some at a time.
    options.maxMemory = 4 * 4 * numbers.info.frameValues() * *rc::gen::inRange(1, 4);
    options.maxMemory = std::max<std::uint64_t>(options.maxMemory, 4096);
    const auto read = readSequence(folder / "a.npy", options);
    RC_ASSERT(read.has_value());
    RC_ASSERT(read->values == numbers.values);
  };
  same(arrayFile<std::uint8_t>("|u1", numbers, fortran));
  same(arrayFile<std::int8_t>("|i1", numbers, fortran));
  same(arrayFile<std::uint16_t>(">u2", numbers, fortran));
  same(arrayFile<std::int32_t>("<i4", numbers, fortran));
  same(arrayFile<std::int64_t>(">i8", numbers, fortran));
  same(arrayFile<float>("<f4", numbers, fortran));
  same(arrayFile<float>(">f4", numbers, fortran));
  same(arrayFile<double>("<f8", numbers, fortran));
  same(arrayFile<double>(">f8", numbers, fortran));
}

TEST(Npy, CountsTheRoundingOfDoubles) {
  const TempFolder folder;
  const std::string header = npyFile(dictionary("<f8", "(1, 1, 2)"), 0);
  writeBytes(folder / "a.npy", header + bytesOf(1e6 + 0.01, false) + bytesOf(1.0, false));
  ASSERT_VALUE(const auto source, openSource(folder / "a.npy", {}));
  std::vector<float> values(2);
  ASSERT_TRUE(ok(source->readFrame(0, values)));
  EXPECT_EQ(roundingOf(*source), std::abs(1e6 + 0.01 - static_cast<double>(values[0])));
  EXPECT_GT(roundingOf(*source), 0.009);

  writeBytes(folder / "a.npy", header + bytesOf(1.0, false) + bytesOf(1e300, false));
  ASSERT_VALUE(const auto beyond, openSource(folder / "a.npy", {}));
  EXPECT_THAT(beyond->readFrame(0, values).error().message,
              ::testing::HasSubstr("1e+300 is beyond float32"));
}

TEST(Npy, VersionsTwoAndThree) {
  const TempFolder folder;
  for (char version : {'\2', '\3'}) {
    std::string file = npyFile(dictionary("<f4", "(1, 1, 1)"), 4);
    file[6] = version;
    file.insert(10, 2, '\0');
    writeBytes(folder / "a.npy", file);
    EXPECT_TRUE(ok(openSource(folder / "a.npy", {})));
  }
}

TEST(Npy, BoundsAreStatedNotResampled) {
  const TempFolder folder;
  writeBytes(folder / "a.npy", npyFile(dictionary("<f4", "(2, 2, 2)"), 32));
  SourceOptions options;
  options.bounds = Box3{Vec3(1, 2, 3), Vec3(2, 4, 6)};
  ASSERT_VALUE(const auto source, openSource(folder / "a.npy", options));
  EXPECT_EQ(source->info().bounds.min, Vec3(1, 2, 3));
  EXPECT_EQ(source->info().x, 2);
}

TEST(Npy, RefusesOtherArraysByName) {
  const TempFolder folder;
  const auto message = [&](const std::string& text, std::size_t bytes) {
    writeBytes(folder / "a.npy", npyFile(text, bytes));
    const auto source = openSource(folder / "a.npy", {});
    return source ? std::string("accepted") : source.error().message;
  };
  const auto has = [](const std::string& text) { return ::testing::HasSubstr(text); };
  EXPECT_THAT(message(dictionary("<c8", "(1, 1, 1)"), 8), has("complex"));
  EXPECT_THAT(message(dictionary("<f16", "(1, 1, 1)"), 16), has("astype('float64')"));
  EXPECT_THAT(message(dictionary("|O", "(1, 1, 1)"), 8), has("'|O'; expected real numbers"));
  EXPECT_THAT(message(dictionary("<f4", "(1, 1, 1)", "Maybe"), 4), has("damaged"));
  EXPECT_THAT(message("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (1, 1, 1), }", 4),
              has("structured"));
  EXPECT_THAT(message(dictionary("<f4", "(4,)"), 16), has("1 axes"));
  EXPECT_THAT(message(dictionary("<f4", "(1, 1, 1, 1, 2)"), 8), has("2 channels"));
  EXPECT_THAT(message(dictionary("<f4", "(0, 1, 1)"), 0), has("no values"));
  EXPECT_THAT(message(dictionary("<f4", "(1, 1, 1)"), 5), has("more than its header says"));
  EXPECT_THAT(message(dictionary("<f4", "(1, 1, 2)"), 4), has("fewer than its header says"));
  EXPECT_THAT(message(dictionary("<f4", "(4294967296, 4294967296, 1)"), 4), has("fewer"));
  EXPECT_THAT(message(dictionary("<f4", "(99999999999999999999, 1, 1)"), 4), has("damaged"));
}

TEST(Npy, RefusesMoreThanTheAllowedMemory) {
  const TempFolder folder;
  writeBytes(folder / "a.npy", npyFile(dictionary("<f4", "(2, 16, 16, 16)"), 2 * 16384));
  SourceOptions options;
  options.maxMemory = 16384;
  EXPECT_TRUE(ok(openSource(folder / "a.npy", options)));
  options.maxMemory = 16383;
  EXPECT_EQ(openSource(folder / "a.npy", options).error().code, ErrorCode::kTooLarge);
}

TEST(Npy, EveryTruncationIsRefused) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeAll(folder / "a.npy", makeBlob(2, 2, 3, 2))));
  const std::string bytes = readBytes(folder / "a.npy");
  expectCutsRefused(folder / "b.npy", bytes, [](const auto& file) { return openSource(file, {}); });
  writeBytes(folder / "b.npy", bytes + "x");
  EXPECT_FALSE(openSource(folder / "b.npy", {}));
}

TEST(Npy, EveryBitFlipInTheHeaderIsRefused) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeAll(folder / "a.npy", makeBlob(2, 12, 3, 20, 3))));
  const std::string bytes = readBytes(folder / "a.npy");
  ASSERT_EQ(makeNpyHeader({2, 12, 3, 20, 3}), bytes.substr(0, 128));
  for (std::size_t bit = 0; bit < 8 * 128; ++bit) {
    const std::string flipped = withFlippedBit(bytes, bit);
    writeBytes(folder / "b.npy", flipped);
    // An array whose bytes are in the other order is as whole as this one.
    const bool otherOrder = flipped[bit / 8] == '>' && bytes[bit / 8] == '<';
    EXPECT_EQ(openSource(folder / "b.npy", {}).has_value(), otherOrder)
        << "bit " << bit << ": " << flipped.substr(10, 80);
  }
}

TEST(Npy, AFullDiskLeavesNothing) {
  const auto sequence = makeBlob(4, 16, 16, 16);
  expectFullDiskLeavesNothing(
      20000, [&](const TempFolder& folder) { return writeAll(folder / "a.npy", sequence); });
}

TEST(Npy, MissingFramesLeaveNothing) {
  const TempFolder folder;
  const auto sequence = makeBlob(2, 2, 2, 2);
  {
    ASSERT_VALUE(const auto sink, createSink(folder / "a.npy", sequence.info));
    ASSERT_TRUE(ok(sink->writeFrame(sequence.frame(0))));
    EXPECT_EQ(sink->finish().error().code, ErrorCode::kInvalidArgument);
  }
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(VolumeSource, UnknownKindsAreNamed) {
  EXPECT_EQ(openSource("a.xyz", {}).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(openSource("none.npy", {}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(openSource("none_%04d.vdb", {}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(openSource("none.vti", {}).error().code, ErrorCode::kNotFound);
  const VolumeInfo info = makeSequence(1, 1, 1, 1).info;
  EXPECT_EQ(createSink("a.xyz", info).error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(createSink("a.volute", info).error().message,
              ::testing::HasSubstr("volute compress writes"));
  EXPECT_THAT(createSink("a.xyz", info, {.orVolute = true}).error().message,
              ::testing::HasSubstr("expected .volute, .npy"));
}

TEST(NpySequence, NumberedFilesAreItsFrames) {
  const TempFolder folder;
  const auto written = makeBlob(3, 4, 5, 6, 3);
  const int numbers[] = {8, 9, 12};
  for (int i = 0; i < 3; ++i) {
    Sequence one = makeSequence(1, 4, 5, 6, 3);
    std::ranges::copy(written.frame(i), one.values.begin());
    ASSERT_TRUE(ok(writeAll(folder / fmt::format("f_{:04}.npy", numbers[i]), one)));
  }
  for (const auto& input : {folder.path(), folder / "f_%04d.npy", folder / "f_####.npy"}) {
    ASSERT_VALUE(const auto read, readSequence(input));
    EXPECT_EQ(read.values, written.values);
    EXPECT_EQ(read.info.frameNumbers, (std::vector{8, 9, 12}));
    EXPECT_NEAR(read.info.times[2], 4 / 25.0, 1e-12);
  }
  // A file alone is that file.
  ASSERT_VALUE(const auto one, readSequence(folder / "f_0009.npy"));
  EXPECT_EQ(one.info.frames, 1);

  ASSERT_TRUE(ok(writeAll(folder / "g_0001.npy", makeBlob(1, 4, 5, 6, 3))));
  const auto two = readSequence(folder.path());
  ASSERT_FALSE(two);
  EXPECT_NE(two.error().message.find("f_####.npy (3 files) and g_####.npy (1 file)"),
            std::string::npos)
      << two.error().message;
  std::filesystem::remove(folder / "g_0001.npy");
  ASSERT_TRUE(ok(writeAll(folder / "f_0013.npy", makeBlob(1, 4, 5, 7, 3))));
  const auto odd = readSequence(folder.path());
  ASSERT_FALSE(odd);
  EXPECT_NE(odd.error().message.find("f_0013.npy: holds 1 frame of 7 x 5 x 4 voxels"),
            std::string::npos)
      << odd.error().message;
  writeBytes(folder / "a_0001.vdb", "x");
  EXPECT_EQ(readSequence(folder.path()).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace volute
