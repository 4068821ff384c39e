// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/written_file.hpp"

#include <gtest/gtest.h>

#include "volute/codec/codec_testing.hpp"

namespace volute {
namespace {

using namespace testing;

/// A file, and what its encoder knows of it.
struct Written {
  ScratchFile file;
  FileHead head;
  std::vector<std::byte> headBytes;
  std::string bytes;

  Written() {
    EXPECT_TRUE(
        testing::compressTo(file.path(), plumes(18, 5, 6, 19), {ErrorTarget::Kind::kRms, 2e-2}));
    const auto opened = InputFile::open(file.path());
    head = *readHeadAndPages(*opened, std::uint64_t{64} << 20);
    headBytes = writeHead(head);
    bytes = readBytes(file.path());
  }

  /// What is said of these bytes in the file's place; empty: nothing.
  std::string check(const std::string& now) const {
    const Progress quiet;
    writeBytes(file.path(), now);
    const auto opened = InputFile::open(file.path());
    const auto status = checkWritten(*opened, "out.volute", headBytes, std::span(&head, 1), quiet);
    return status ? std::string() : status.error().message;
  }
};

TEST(WrittenFile, WhatWasWrittenPasses) {
  const Written written;
  EXPECT_EQ(written.check(written.bytes), "");
}

TEST(WrittenFile, AFlippedBitIsFound) {
  const Written written;
  for (std::size_t i = 0; i < written.bytes.size(); i += 5) {
    const std::string other = testing::withFlippedBit(written.bytes, 8 * i + i % 8);
    EXPECT_NE(written.check(other).find("differs from what was written"), std::string::npos)
        << "byte " << i;
  }
}

TEST(WrittenFile, AnyOtherLengthIsFound) {
  const Written written;
  std::string other = written.bytes;
  other.push_back(0);
  EXPECT_NE(written.check(other).find("out.volute: has"), std::string::npos);
  for (std::size_t length = 0; length < written.bytes.size(); length += 37) {
    other.resize(length);
    EXPECT_NE(written.check(other), "");
  }
}

TEST(WrittenFile, AReaderMustFindWhatTheEncoderMeant) {
  Written written;
  written.head.parameters.front() ^= std::byte{1};
  EXPECT_NE(written.check(written.bytes).find("differs from what was encoded"), std::string::npos);
  written.head.parameters.front() ^= std::byte{1};
  written.head.segments.front().crc = 1;
  EXPECT_NE(written.check(written.bytes), "");
}

TEST(WrittenFile, ItCanBeStopped) {
  class Stopped final : public Progress {
   public:
    bool cancelled() const override { return true; }
  };

  const Written written;
  const auto opened = InputFile::open(written.file.path());
  const auto status = checkWritten(*opened, "out.volute", written.headBytes,
                                   std::span(&written.head, 1), Stopped());
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace volute
