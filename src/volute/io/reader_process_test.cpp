// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/reader_process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <future>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "volute/io/reader_helper.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;

constexpr ReaderProcess::Limits kLimits{64 << 20, 1};

/// Keeps the compiler from removing what only a damaged file would make a library do.
volatile std::size_t sink = 0;

Result<std::string> misbehave(std::string_view request, std::span<float> values) {
  if (request == "crash")
    ::raise(SIGSEGV);
  if (request == "abort")
    std::abort();
  if (request == "exit")
    ::_exit(3);
  if (request == "hang") {
    while (true) sink = sink + 1;
  }
  if (request == "memory") {
    std::vector<std::vector<char>> hoard;
    while (true) hoard.emplace_back(std::size_t{16} << 20, 'x');
  }
  if (request == "throw")
    throw std::runtime_error("odd bytes");
  if (request == "damaged")
    return fail(ErrorCode::kTruncated, "file: ends early");
  if (request == "piece")
    return ofFile(Result<std::string>(fail(ErrorCode::kTruncated, "piece: ends early")), "piece");
  if (request == "fail")
    return failFor("bounds", ErrorCode::kUnsupported, Hint::raise("max_memory").so("helps"),
                   "file: no such thing");
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
  return std::string(request) + "!";
}

TEST(ReaderProcess, RepliesAndSharesValues) {
  ReaderProcess process(misbehave);
  for (std::size_t count : {10, 1000, 3, 100000}) {
    const auto reply = process.call("file", "hello", count, kLimits);
    ASSERT_TRUE(testing::ok(reply));
    EXPECT_EQ(*reply, "hello!");
    ASSERT_EQ(process.values().size(), count);
    EXPECT_EQ(process.values()[count - 1], static_cast<float>(count - 1));
  }
}

TEST(ReaderProcess, ErrorsBeginWithTheFileOfTheCall) {
  ReaderProcess process(misbehave);
  const auto errorOf = [&](const char* request) {
    return process.call("file", request, 0, kLimits).error();
  };
  EXPECT_EQ(errorOf("damaged").message, "file: ends early");
  EXPECT_EQ(errorOf("piece").message, "file: piece: ends early");
  EXPECT_EQ(errorOf("throw").message, "file: odd bytes");
  for (const char* request : {"damaged", "piece", "throw"})
    EXPECT_EQ(errorOf(request).path, "file") << request;
}

/// As misbehave(); what it was made with comes back too.
Result<ReaderProcess::Serve> makeMisbehaving(std::string_view parameters) {
  if (parameters == "nothing")
    return fail(ErrorCode::kUnsupported, "no library");
  return [end = std::string(parameters)](std::string_view request,
                                         std::span<float> values) -> Result<std::string> {
    if (request == "wait") {
      std::this_thread::sleep_for(std::chrono::hours(1));
    }
    VOLUTE_ASSIGN(const std::string reply, misbehave(request, values));
    return reply + end;
  };
}

TEST(ReaderProcess, AConfinedOneServesTheSame) {
  for (const bool withHelper : {false, true}) {
    std::optional<ReaderHelper> helper;
    if (withHelper)
      helper.emplace();
    ReaderProcess process(ReaderJob{makeMisbehaving, std::string(300'000, '?')});
    EXPECT_THAT(process.call("file", "memory", 0, kLimits).error().message, HasSubstr("memory"));
    for (const char* request : {"crash", "abort", "exit", "hang"})
      EXPECT_FALSE(process.call("file", request, 4, kLimits)) << request;
    for (const std::size_t count : {10, 100000, 3}) {
      const auto reply = process.call("file", "hello", count, kLimits);
      ASSERT_TRUE(testing::ok(reply));
      EXPECT_EQ(reply->substr(0, 7), "hello!?");
      EXPECT_EQ(process.values()[count - 1], static_cast<float>(count - 1));
    }
  }
}

TEST(ReaderProcess, WhatCannotBeMadeSaysWhy) {
  ReaderProcess process(ReaderJob{makeMisbehaving, "nothing"});
  EXPECT_EQ(process.call("file", "hello", 0, kLimits).error().message, "file: no library");
}

TEST(ReaderProcess, OneThatWaitsForNothingIsGivenUp) {
  const ReaderHelper helper;
  ReaderProcess process(ReaderJob{makeMisbehaving});
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_FALSE(process.call("file", "wait", 0, {64 << 20, 60}));
  // 3 s; where a sanitizer works, 13 s were seen. By its CPU time it would have 20 minutes.
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(30));
}

int prepared = 0;

Result<ReaderProcess::Serve> makePrepared(std::string_view) {
  return [](std::string_view, std::span<float>) { return std::to_string(prepared); };
}

TEST(ReaderProcess, WhatAHelperHasPreparedOnceAllItsChildrenHave) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers have no helper";
#endif
  const ReaderHelper helper;
  for (int i = 0; i < 2; ++i) {
    ReaderProcess process(ReaderJob{makePrepared, "", {}, [] { ++prepared; }});
    EXPECT_EQ(process.call("file", "", 0, kLimits), "1");
  }
  EXPECT_EQ(prepared, 0);
}

std::atomic<bool> stopReading{false};

TEST(ReaderProcess, WhoeverWaitsForItCanGiveUp) {
  const ReaderHelper helper([] { return stopReading.load(); });
  ReaderProcess process(ReaderJob{makeMisbehaving});
  std::jthread other([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    stopReading = true;
  });
  const auto begun = std::chrono::steady_clock::now();
  const auto reply = process.call("file", "hang", 0, {64 << 20, 60});
  stopReading = false;
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().code, ErrorCode::kCancelled);
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(20));
}

TEST(ReaderProcess, EveryEndOfTheChildIsAnErrorAndTheNextCallWorks) {
  ReaderProcess process(misbehave);
  for (const char* request : {"crash", "abort", "exit"}) {
    const auto reply = process.call("some/file", request, 4, kLimits);
    ASSERT_FALSE(reply);
    EXPECT_EQ(reply.error().code, ErrorCode::kInvalidData);
    EXPECT_THAT(reply.error().message, HasSubstr("some/file: its library"));
    EXPECT_TRUE(testing::ok(process.call("file", "hello", 4, kLimits)));
  }
}

TEST(ReaderProcess, AHangEnds) {
  ReaderProcess process(misbehave);
  const auto reply = process.call("file", "hang", 0, {64 << 20, 0.05});
  ASSERT_FALSE(reply);
  EXPECT_THAT(reply.error().message, HasSubstr("too long"));
}

/// A lock that another thread holds at the fork stays locked in the child.
TEST(ReaderProcess, AChildThatWaitsForALockIsForkedAgain) {
  if (std::ifstream wait("/proc/self/wchan"); !wait)
    GTEST_SKIP() << "the system does not say what a process waits for";
  std::mutex lock;
  ReaderProcess process([&](std::string_view, std::span<float>) -> Result<std::string> {
    const std::lock_guard guard(lock);
    return "read";
  });
  std::promise<void> held;
  std::jthread other([&] {
    const std::lock_guard guard(lock);
    held.set_value();
    std::this_thread::sleep_for(std::chrono::seconds(1));
  });
  held.get_future().wait();
  const auto begun = std::chrono::steady_clock::now();
  const auto reply = process.call("a.vtu", "", 0, {64 << 20, 10});
  ASSERT_TRUE(reply) << reply.error().message;
  EXPECT_EQ(*reply, "read");
  EXPECT_GT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(2)) << "it was not held";
}

TEST(ReaderProcess, ErrorsKeepTheirCodeAndHintsAndNameTheFile) {
  ReaderProcess process(misbehave);
  const Error error = process.call("file", "fail", 0, kLimits).error();
  EXPECT_EQ(error.code, ErrorCode::kUnsupported);
  EXPECT_EQ(error.message, "file: no such thing");
  EXPECT_EQ(error.member, "bounds");
  EXPECT_EQ(error.hints, Hints{Hint::raise("max_memory").so("helps")});
  EXPECT_EQ(process.call("file", "throw", 0, kLimits).error().message, "file: odd bytes");
}

TEST(ReaderProcess, MessagesOfAnotherSizeAreRefused) {
  EXPECT_EQ(*fromMessage<double>(toMessage(2.5)), 2.5);
  EXPECT_EQ(fromMessage<double>("short").error().message,
            "the process that reads the file answered with 5 bytes; expected 8");
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(ReaderProcess, MemoryIsLimited) {
  ReaderProcess process(misbehave);
  const auto reply = process.call("file", "memory", 0, kLimits);
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().code, ErrorCode::kTooLarge);
}
#endif

}  // namespace
}  // namespace volute
