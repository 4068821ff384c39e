// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"

namespace volute {

/// What a rank did of one stage of a job.
struct UnitRecord {
  std::string stage;
  std::vector<std::int64_t> units;
  double seconds = 0;     ///< of wall time, inside of units
  double cpuSeconds = 0;  ///< the same of all threads of the process
};

/// Processes ("ranks") that do one job together, each of them calling the same functions with the
/// same arguments. This class is the team of a single process; volute/cluster/cluster.hpp has those
/// of MPI.
///
/// Work is cut into units whose borders depend on the job alone, never on the ranks. Ranks take
/// units from a shared counter, and what units give is put together in the order of units, so the
/// result is the same for any number of ranks.
///
/// Collective calls must be made by all ranks in the same order. Each of them succeeds on all ranks
/// or fails on all with the same error: a rank that leaves its job with an error calls agree(), and
/// the others hear of it in whatever collective call comes next. After that all collective calls
/// fail. Calls come from one thread of a process at a time.
class Team {
 public:
  virtual ~Team() = default;
  Team() = default;
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  virtual int rank() const { return 0; }

  virtual int size() const { return 1; }

  /// The machine that this rank runs on; for messages.
  virtual std::string host() const { return {}; }

  /// Rank 0 prints, and writes what there is one of.
  bool leads() const { return rank() == 0; }

  /// Collective. Fails on all ranks when any rank has an error: with that of the lowest rank, of
  /// those that were not only cancelled if there are any. The error says which rank it comes from.
  [[nodiscard]] Status agree(const Status& status);

  /// Collective. The bytes of all ranks on all ranks, in the order of ranks.
  [[nodiscard]] Result<std::vector<std::vector<std::byte>>> gatherAll(
      std::span<const std::byte> bytes);

  /// Gathers one text of each process, in the order of ranks.
  [[nodiscard]] Result<std::vector<std::string>> gatherTexts(std::string_view text);

  /// Collective. Sends toEach[rank], one for each rank, to that rank.
  /// @return what each rank sent to this one, in the order of ranks
  [[nodiscard]] Result<std::vector<std::vector<std::byte>>> exchangeAll(
      std::span<const std::vector<std::byte>> toEach);

  /// Collective. The bytes of rank 0 on all ranks.
  [[nodiscard]] Result<std::vector<std::byte>> broadcast(std::span<const std::byte> bytes);

  /// Collective. A value of rank 0, bit for bit, on all ranks.
  template <class Value>
    requires std::is_trivially_copyable_v<Value>
  [[nodiscard]] Result<Value> broadcast(Value value) {
    VOLUTE_ASSIGN(const auto bytes, broadcast(std::as_bytes(std::span(&value, 1))));
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }

  /// Collective. Adds up the numbers of all ranks, place by place, modulo 2^64.
  [[nodiscard]] Status sum(std::span<std::uint64_t> numbers);

  /// Collective. Does the units 0 to count - 1 of a stage, each once on the rank that is free for
  /// it; a rank gets its units in ascending order. An error of `body` ends the stage on all ranks.
  /// Rank 0 reports 0 units, and then those that all ranks have finished.
  /// @param last  called on each rank when there are no more units for it, before it waits for the
  ///              others: on rank 0 it can collect what they post.
  [[nodiscard]] Status forUnits(std::string_view stage, std::int64_t count, Progress& progress,
                                const std::function<Status(std::int64_t)>& body,
                                const std::function<Status()>& last = {});

  /// Sends bytes to rank 0, where collect(item) gets them; returns at once unless more than
  /// `maxPending` bytes wait to be collected. Rank 0 may send to itself, without a limit. An
  /// item, >= 0, is sent by one rank, and its number is free again after it was collected.
  [[nodiscard]] Status post(std::int64_t item, std::vector<std::byte> bytes,
                            std::uint64_t maxPending);

  /// Rank 0: waits for what a rank posts. kCancelled when a rank has left with an error: go to
  /// agree().
  [[nodiscard]] Result<std::vector<std::byte>> collect(std::int64_t item);

  /// Rank 0: whether collect() would not have to wait.
  bool arrived(std::int64_t item);

  /// What this rank did so far; stages of one name count as one.
  const std::vector<UnitRecord>& units() const { return records_; }

  /// Seconds that this rank waited for others.
  double waited() const { return waited_; }

 protected:
  enum class Counter { kTaken, kDone };

  /// A counter that is at least this says that a rank has left with an error.
  static constexpr std::int64_t kStopped = std::int64_t{1} << 60;

  // What a kind of team is made of. All ranks call the first three in the same order.
  virtual std::vector<std::vector<std::byte>> exchange(std::span<const std::byte> bytes);
  virtual std::vector<std::vector<std::byte>> exchangeEach(
      std::vector<std::vector<std::byte>> toEach);
  virtual void addUp(std::span<std::uint64_t> numbers);
  /// The value before; atomic.
  virtual std::int64_t fetchAdd(Counter counter, std::int64_t increment);
  virtual void setCounter(Counter counter, std::int64_t value);
  virtual void startSending(std::int64_t item, std::vector<std::byte> bytes);
  /// Bytes that were sent and not received yet; 0 on rank 0.
  virtual std::uint64_t sending();
  virtual std::optional<std::vector<std::byte>> receive(std::int64_t item);
  /// Waits a short while, longer each time.
  virtual void pause(int& times);

 private:
  /// `status` of this rank, and bytes where it is well.
  Result<std::vector<std::vector<std::byte>>> meet(const Status& status,
                                                   std::span<const std::byte> bytes);

  bool stopped() { return fetchAdd(Counter::kTaken, 0) >= kStopped; }

  UnitRecord& record(std::string_view stage);

  Status failed_;  // what all collective calls return after one failed
  std::vector<UnitRecord> records_;
  double waited_ = 0;
  // Of a single process, and what rank 0 sends itself.
  std::int64_t taken_ = 0, done_ = 0;
  std::vector<std::pair<std::int64_t, std::vector<std::byte>>> own_;
};

}  // namespace volute
