// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "volute/base/team.hpp"

// Teams whose ranks are threads of one process, for tests.

namespace volute {

/// What the ranks of such a team share.
class ThreadTable {
 public:
  explicit ThreadTable(int ranks) : messages(ranks), letters(ranks), ranks_(ranks) {}

  /// Waits for all ranks.
  void meet() {
    std::unique_lock lock(mutex);
    const int round = round_;
    if (++waiting_ == ranks_) {
      waiting_ = 0;
      ++round_;
      all_.notify_all();
    }
    all_.wait(lock, [&] { return round_ != round; });
  }

  int ranks() const { return ranks_; }

  std::vector<std::vector<std::byte>> messages;
  std::vector<std::vector<std::vector<std::byte>>> letters;  // of each rank to each
  std::atomic<std::int64_t> counters[2]{};
  std::mutex mutex;
  std::map<std::int64_t, std::vector<std::byte>> posted;
  std::vector<std::uint64_t> sums;

 private:
  int ranks_;
  std::condition_variable all_;
  int waiting_ = 0;
  int round_ = 0;
};

class ThreadTeam final : public Team {
 public:
  ThreadTeam(ThreadTable& table, int rank) : table_(table), rank_(rank) {}

  int rank() const override { return rank_; }

  int size() const override { return table_.ranks(); }

  std::string host() const override { return "here"; }

 protected:
  std::vector<std::vector<std::byte>> exchange(std::span<const std::byte> bytes) override {
    table_.messages[rank_].assign(bytes.begin(), bytes.end());
    table_.meet();
    auto all = table_.messages;
    table_.meet();
    return all;
  }

  std::vector<std::vector<std::byte>> exchangeEach(
      std::vector<std::vector<std::byte>> toEach) override {
    table_.letters[rank_] = std::move(toEach);
    table_.meet();
    std::vector<std::vector<std::byte>> received;
    for (const auto& letters : table_.letters) received.push_back(letters[rank_]);
    table_.meet();
    return received;
  }

  void addUp(std::span<std::uint64_t> numbers) override {
    const auto all = exchange(std::as_bytes(numbers));
    std::vector<std::uint64_t> other(numbers.size());
    std::ranges::fill(numbers, 0);
    for (const auto& bytes : all) {
      std::memcpy(other.data(), bytes.data(), bytes.size());
      for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] += other[i];
    }
  }

  std::int64_t fetchAdd(Counter counter, std::int64_t increment) override {
    return table_.counters[static_cast<int>(counter)].fetch_add(increment);
  }

  void setCounter(Counter counter, std::int64_t value) override {
    table_.counters[static_cast<int>(counter)] = value;
  }

  void startSending(std::int64_t item, std::vector<std::byte> bytes) override {
    const std::lock_guard lock(table_.mutex);
    sent_.push_back(item);
    table_.posted.emplace(item, std::move(bytes));
  }

  std::uint64_t sending() override {
    const std::lock_guard lock(table_.mutex);
    std::uint64_t bytes = 0;
    for (const std::int64_t item : sent_) {
      const auto found = table_.posted.find(item);
      bytes += found == table_.posted.end() ? 0 : found->second.size();
    }
    return bytes;
  }

  std::optional<std::vector<std::byte>> receive(std::int64_t item) override {
    const std::lock_guard lock(table_.mutex);
    const auto found = table_.posted.find(item);
    if (found == table_.posted.end())
      return std::nullopt;
    auto bytes = std::move(found->second);
    table_.posted.erase(found);
    return bytes;
  }

 private:
  ThreadTable& table_;
  int rank_;
  std::vector<std::int64_t> sent_;
};

/// Calls body(team) on so many ranks, and returns when all are done.
inline void onRanks(int ranks, const std::function<void(Team&)>& body) {
  ThreadTable table(ranks);
  std::vector<std::thread> threads;
  for (int rank = 0; rank < ranks; ++rank) {
    threads.emplace_back([&, rank] {
      ThreadTeam team(table, rank);
      body(team);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace volute
