// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/worker.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <new>
#include <thread>
#include <vector>

namespace volute {
namespace {

TEST(Worker, DoesAllInOrderAndLetsFewWait) {
  std::vector<int> done;
  std::atomic<int> waiting{0}, most{0};
  Worker worker(2);
  ASSERT_TRUE(worker.finish());  // nothing to do
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(worker.give([&, i] {
      done.push_back(i);
      --waiting;
      return Status();
    }));
    const int now = ++waiting;
    most = std::max(most.load(), now);
  }
  ASSERT_TRUE(worker.finish());
  ASSERT_EQ(done.size(), 50U);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
  EXPECT_LE(most, 4);  // two wait, one is done, one was just taken
}

TEST(Worker, AnErrorEndsIt) {
  int after = 0;
  Worker worker(1);
  ASSERT_TRUE(worker.give([] { return fail(ErrorCode::kIo, "the disk is full"); }));
  Status said;
  for (int i = 0; i < 20 && said; ++i) {
    said = worker.give([&] {
      ++after;
      return Status();
    });
  }
  ASSERT_FALSE(worker.finish());
  EXPECT_EQ(worker.finish().error().message, "the disk is full");
  EXPECT_EQ(after, 0);
}

TEST(Worker, WhatIsThrownReachesWhoWaits) {
  Worker worker(1);
  ASSERT_TRUE(worker.give([]() -> Status { throw std::bad_alloc(); }));
  EXPECT_THROW((void)worker.finish(), std::bad_alloc);
}

TEST(Worker, WhatHasNotBegunIsLeftUndone) {
  std::atomic<int> done{0};
  std::promise<void> ends;
  std::jthread later;
  {
    Worker worker(100);
    for (int i = 0; i < 100; ++i) {
      ASSERT_TRUE(worker.give([&] {
        if (done == 0)
          ends.get_future().wait();
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        ++done;
        return Status();
      }));
    }
    later = std::jthread([&] {  // it is waited for at the end of the block
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      ends.set_value();
    });
  }
  EXPECT_LT(done, 100);
}

}  // namespace
}  // namespace volute
