// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fcntl.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <numeric>
#include <thread>
#include <vector>

#include "volute/base/checksum.hpp"
#include "volute/base/half.hpp"
#include "volute/base/input_file.hpp"
#include "volute/base/output_file.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/printable.hpp"
#include "volute/base/program.hpp"
#include "volute/base/read_text.hpp"
#include "volute/base/suggest.hpp"
#include "volute/base/thread_priority.hpp"
#include "volute/base/view.hpp"

namespace volute {
namespace {

std::span<const std::byte> bytesOf(std::string_view text) {
  return std::as_bytes(std::span(text));
}

TEST(View, SubViewSharesTheDataAtItsOrigin) {
  std::vector<int> data(2 * 3 * 4);
  std::iota(data.begin(), data.end(), 0);
  const View<int, 3> view(std::span<int>(data), {2, 3, 4});
  EXPECT_EQ(view(1, 2, 3), 23);
  const auto part = view.sub({1, 1, 1}, {1, 2, 3});
  EXPECT_EQ(part(0, 0, 0), 12 + 4 + 1);
  part(0, 1, 2) = -1;
  EXPECT_EQ(data[23], -1);
}

TEST(Crc32, AgreesWithThePublishedCheckValue) {
  EXPECT_EQ(crc32(bytesOf("123456789")), 0xCBF43926u);
}

TEST(Suggest, HugeNamesAreLikeNone) {
  const std::string_view names[] = {"extinction", "emission"};
  EXPECT_EQ(nearest("extinctoin", names), "extinction");
  EXPECT_EQ(nearest("emi", names), "emission");
  EXPECT_EQ(nearest("zebra", names), "");
  EXPECT_EQ(editDistance("kitten", "sitting"), 3U);
  EXPECT_EQ(editDistance("ab", "ba"), 1U);
  EXPECT_EQ(editDistance("", "abc"), 3U);
  const std::string huge(15 << 20, 'e');  // a table of these would take more memory than there is
  EXPECT_EQ(nearest(huge, names), "");
  EXPECT_EQ(editDistance(huge, huge), huge.size());
}

TEST(Half, FloatsBecomeTheNearestHalf) {
  for (std::uint32_t bits = 0; bits < 0x7C00u; ++bits) {
    const Half half{static_cast<std::uint16_t>(bits)}, next{static_cast<std::uint16_t>(bits + 1)};
    const float value = toFloat(half);
    ASSERT_EQ(toHalf(value).bits, bits);
    ASSERT_EQ(toHalf(-value).bits, bits | 0x8000u);
    // In the middle to the even one; the half after the greatest would be 65,536.
    const float after = bits == 0x7BFFu ? 65536.0F : toFloat(next), middle = (value + after) / 2;
    ASSERT_EQ(toHalf(middle).bits, bits % 2 == 0 ? bits : bits + 1);
    ASSERT_EQ(toHalf(std::nextafter(middle, 0.0F)).bits, bits);
    ASSERT_EQ(toHalf(std::nextafter(middle, 1e9F)).bits, bits + 1);
  }
  EXPECT_EQ(toHalf(std::numeric_limits<float>::infinity()).bits, 0x7C00u);
  EXPECT_EQ(toHalf(1e30F).bits, 0x7C00u);
  EXPECT_TRUE(std::isnan(toFloat(toHalf(std::nanf("")))));
}

TEST(Half, EveryFiniteHalfMatchesItsDefinition) {
  for (unsigned bits = 0; bits < 0x10000; ++bits) {
    const int exponent = static_cast<int>(bits >> 10 & 31);
    const double mantissa = bits & 1023;
    const double sign = bits & 0x8000 ? -1 : 1;
    const float value = toFloat(Half{static_cast<std::uint16_t>(bits)});
    if (exponent == 31) {
      EXPECT_EQ(std::isnan(value), mantissa != 0) << bits;
      if (mantissa == 0) {
        EXPECT_EQ(value, static_cast<float>(sign * INFINITY));
      }
    } else {
      const double expected =
          exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
      EXPECT_EQ(value, static_cast<float>(sign * expected)) << bits;
    }
  }
}

TEST(ParallelRanges, CoverEveryIndexOnce) {
  std::vector<std::atomic<int>> seen(10007);
  parallelRanges(seen.size(), 13, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) ++seen[i];
  });
  for (const auto& count : seen) ASSERT_EQ(count.load(), 1);
}

/// A worker may be about to sleep, with a lock, when its process is forked.
TEST(ParallelRanges, GoOnInTheChildOfAFork) {
  const auto sum = [] {
    std::atomic<int> found = 0;
    parallelFor(64, [&](std::size_t) {
      parallelRanges(10, 3, [&](auto a, auto b) { found += static_cast<int>(b - a); });
    });
    return found.load();
  };
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(sum(), 640);
    const pid_t child = ::fork();
    if (child == 0) {
      ::alarm(20);  // ends a child that waits for workers that it does not have
      bool fine = sum() == 640;
      isolated([&] { fine = fine && sum() == 640; });
      const ThreadLimit limit(1);
      ::_exit(fine && threadCount() == 1 ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
  }
}

TEST(ThreadLimit, HoldsWhileItLives) {
  const int before = threadCount();
  {
    const ThreadLimit limit(1);
    EXPECT_EQ(threadCount(), 1);
  }
  EXPECT_EQ(threadCount(), before);
}

TEST(OutputFile, AppearsWholeOnCommitAndNotBefore) {
  const ScratchFolder folder;
  const auto target = folder / "out.bin";
  {
    auto file = OutputFile::create(target);
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write(bytesOf("hello ")));
    ASSERT_TRUE(file->write(bytesOf("world")));
    EXPECT_FALSE(std::filesystem::exists(target));
    ASSERT_TRUE(file->commit());
  }
  std::ifstream in(target);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "hello world");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(OutputFile, AbandonedLeavesNothingAndKeepsTheOldTarget) {
  const ScratchFolder folder;
  const auto target = folder / "out.bin";
  std::ofstream(target) << "old";
  {
    auto file = OutputFile::create(target);
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write(bytesOf("new")));
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
  std::ifstream in(target);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "old");
}

TEST(OutputFile, MissingFolderNamesTheTarget) {
  auto file = OutputFile::create("/nonexistent-folder/out.bin");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::kIo);
  EXPECT_NE(file.error().message.find("/nonexistent-folder/out.bin"), std::string::npos);
}

TEST(OutputFile, FullDiskIsAnErrorOfTheWrite) {
  if (!std::filesystem::exists("/dev/full"))
    GTEST_SKIP();
  const int descriptor = ::open("/dev/full", O_WRONLY);
  const int saved = ::dup(STDOUT_FILENO);
  ::dup2(descriptor, STDOUT_FILENO);
  auto file = OutputFile::create("-");
  const auto status = file->write(bytesOf("x"));
  ::dup2(saved, STDOUT_FILENO);
  ::close(saved);
  ::close(descriptor);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("No space left"), std::string::npos);
}

TEST(InputFile, ReadsAnywhereAndRefusesPastTheEnd) {
  const ScratchFolder folder;
  const auto path = folder / "in.bin";
  std::ofstream(path) << "0123456789";
  auto file = InputFile::open(path);
  ASSERT_TRUE(file);
  EXPECT_EQ(file->size(), 10u);
  std::vector<std::byte> bytes(4);
  ASSERT_TRUE(file->read(6, bytes));
  EXPECT_EQ(static_cast<char>(bytes[3]), '9');
  const auto past = file->read(7, bytes);
  ASSERT_FALSE(past);
  EXPECT_EQ(past.error().code, ErrorCode::kTruncated);
}

TEST(InputFile, MoreFilesThanTheUsualLimitAreOpened) {
  const ScratchFolder folder;
  const auto path = folder / "in.bin";
  std::ofstream(path) << "0123456789";
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  rlimit low = before;
  low.rlim_cur = 64;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &low), 0);
  std::vector<InputFile> files;
  for (int i = 0; i < 100; ++i) {
    auto file = InputFile::open(path);
    ASSERT_TRUE(file) << i << ": " << file.error().message;
    files.push_back(std::move(*file));
  }
  setrlimit(RLIMIT_NOFILE, &before);
}

TEST(ReadText, ReadsAllUpToALimit) {
  const ScratchFolder folder;
  const auto path = folder / "in.txt";
  std::ofstream(path) << "0123456789";
  EXPECT_EQ(readText(path).value(), "0123456789");
  EXPECT_EQ(readText(path, 10).value().size(), 10u);
  const auto large = readText(path, 9);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().code, ErrorCode::kTooLarge);
  EXPECT_NE(large.error().message.find("expected at most 9"), std::string::npos);
}

TEST(InputFile, MissingFileIsNotFound) {
  auto file = InputFile::open("/nonexistent");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::kNotFound);
}

TEST(InputFile, WhatIsNoFileIsRefusedWithoutWaiting) {
  const ScratchFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  const std::string at = folder / "socket";
  ASSERT_LT(at.size(), sizeof name.sun_path);
  std::copy(at.begin(), at.end(), name.sun_path);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  for (const auto& [path, what] : {std::pair(folder / "pipe", "a pipe"),
                                   {folder / "socket", "a socket"},
                                   {folder.path(), "a folder"},
                                   {std::filesystem::path("/dev/zero"), "a device"}}) {
    const auto checked = InputFile::check(path);
    ASSERT_FALSE(checked) << path;
    EXPECT_NE(checked.error().message.find(what), std::string::npos) << checked.error().message;
  }
  ::close(socket);
}

TEST(ThreadPriority, AThreadAndThoseThatItStartsLetOthersFirst) {
  const auto niceness = [] { return ::getpriority(PRIO_PROCESS, static_cast<id_t>(::gettid())); };
  const int ours = niceness();
  int its = ours, itsOwn = ours;
  std::thread([&] {
    lowerThreadPriority();
    its = niceness();
    std::thread([&] { itsOwn = niceness(); }).join();
  }).join();
  EXPECT_EQ(its, std::max(ours, 10));
  EXPECT_EQ(itsOwn, its);
  EXPECT_EQ(niceness(), ours) << "other threads are as before";
}

TEST(ThreadPriority, WorkersLetOthersFirstAndTheLoopsCallerDoesNot) {
  const auto niceness = [] { return ::getpriority(PRIO_PROCESS, static_cast<id_t>(::gettid())); };
  const int ours = niceness();
  const auto here = [] { return std::this_thread::get_id(); };
  const auto caller = here();
  lowerWorkerPriority();
  std::mutex mutex;
  std::map<std::thread::id, int> found;
  const auto others = [&] {
    const std::lock_guard lock(mutex);
    return found.size() > found.count(caller);
  };
  parallelFor(64, [&](std::size_t) {
    // Workers come late on a busy machine.
    for (int i = 0; i < 30000 && threadCount() > 1 && here() == caller && !others(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    parallelFor(4, [&](std::size_t) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      const std::lock_guard lock(mutex);
      found[here()] = niceness();
    });
  });
  for (const auto& [thread, its] : found)
    EXPECT_EQ(its, thread == caller ? ours : std::max(ours, 10));
  if (threadCount() > 1) {
    EXPECT_GT(found.size(), 1u);
  }
  EXPECT_EQ(niceness(), ours);
}

TEST(Error, LongNamesAreCut) {
  const std::string name(15000000, 'x');
  const Error error = fail(ErrorCode::kInvalidData, "a.json: /{}: is unknown", name).value();
  EXPECT_LT(error.message.size(), 300u);
  EXPECT_TRUE(error.message.starts_with("a.json: /xxx")) << error.message;
  EXPECT_TRUE(error.message.ends_with(": is unknown")) << error.message;
  const std::string accents = [] {
    std::string text;
    for (int i = 0; i < 2000; ++i) text += "\xC3\xA9";
    return text;
  }();
  for (const std::string& text : {accents, "a" + accents}) {
    const std::string cut = fail(ErrorCode::kInvalidData, "{}", text).value().message;
    EXPECT_LT(cut.size(), 300u);
    EXPECT_EQ(asUtf8(cut), cut) << "characters stay whole";
    EXPECT_NE(cut.find("bytes)...\xC3\xA9"), std::string::npos);
  }
  const std::string spaced = fail(ErrorCode::kInvalidData, "{}",
                                  [] {
                                    std::string text;
                                    for (int i = 0; i < 1000000; ++i) text += "x ";
                                    return text;
                                  }())
                                 .value()
                                 .message;
  EXPECT_LT(spaced.size(), 100000u);
  const std::string path(1000, 'p');
  EXPECT_EQ(fail(ErrorCode::kNotFound, "{}: a", path).value().message, path + ": a");
}

}  // namespace
}  // namespace volute
