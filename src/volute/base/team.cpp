// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/team.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <thread>

#include "volute/base/assert.hpp"
#include "volute/base/packed_error.hpp"
#include "volute/base/stopwatch.hpp"

namespace volute {
namespace {

// A message of meet(): what became of the rank, then its bytes or its sentence.
constexpr std::byte kWell{0xFF};

std::vector<std::byte> messageOf(const Status& status, std::span<const std::byte> bytes) {
  std::vector<std::byte> message{status ? kWell : static_cast<std::byte>(status.error().code)};
  const std::string error = status ? "" : packed(status.error());
  if (!status)
    bytes = std::as_bytes(std::span(error));
  message.insert(message.end(), bytes.begin(), bytes.end());
  return message;
}

Error errorIn(std::span<const std::byte> message) {
  std::string text(message.size() - 1, '\0');
  std::memcpy(text.data(), message.data() + 1, text.size());
  return unpacked(static_cast<ErrorCode>(message[0]), text);
}

}  // namespace

Result<std::vector<std::vector<std::byte>>> Team::meet(const Status& status,
                                                       std::span<const std::byte> bytes) {
  if (!failed_)
    return tl::unexpected<Error>(failed_.error());
  if (!status && size() > 1)
    setCounter(Counter::kTaken, kStopped);
  double milliseconds = 0;
  auto messages = [&] {
    const Stopwatch watch(milliseconds);
    return exchange(messageOf(status, bytes));
  }();
  waited_ += milliseconds / 1000;
  const auto isWell = [](const auto& message) { return message[0] == kWell; };
  const auto isWorse = [](const auto& message) {
    return message[0] != kWell && message[0] != static_cast<std::byte>(ErrorCode::kCancelled);
  };
  auto worst = std::ranges::find_if(messages, isWorse);
  if (worst == messages.end())
    worst = std::ranges::find_if_not(messages, isWell);
  if (worst != messages.end()) {
    Error error = errorIn(*worst);
    // Errors of usage are the same on all ranks.
    if (worst != messages.begin() && error.code != ErrorCode::kInvalidArgument) {
      error.message = fmt::format("rank {}: {}", worst - messages.begin(), error.message);
      error.statement.clear();
    }
    failed_ = tl::unexpected<Error>(std::move(error));
    return tl::unexpected<Error>(failed_.error());
  }
  for (auto& message : messages) message.erase(message.begin());
  return messages;
}

Status Team::agree(const Status& status) {
  VOLUTE_TRY(meet(status, {}));
  return {};
}

Result<std::vector<std::vector<std::byte>>> Team::gatherAll(std::span<const std::byte> bytes) {
  return meet({}, bytes);
}

Result<std::vector<std::vector<std::byte>>> Team::exchangeAll(
    std::span<const std::vector<std::byte>> toEach) {
  VOLUTE_ASSERT(toEach.size() == static_cast<std::size_t>(size()));
  // Ranks that have left with an error are in agree(), which is another exchange.
  VOLUTE_TRY(agree({}));
  double milliseconds = 0;
  auto received = [&] {
    const Stopwatch watch(milliseconds);
    return exchangeEach({toEach.begin(), toEach.end()});
  }();
  waited_ += milliseconds / 1000;
  return received;
}

Result<std::vector<std::string>> Team::gatherTexts(std::string_view text) {
  VOLUTE_ASSIGN(const auto all, gatherAll(std::as_bytes(std::span(text))));
  std::vector<std::string> texts;
  for (const auto& bytes : all)
    texts.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return texts;
}

Result<std::vector<std::byte>> Team::broadcast(std::span<const std::byte> bytes) {
  VOLUTE_ASSIGN(auto all, meet({}, leads() ? bytes : std::span<const std::byte>()));
  return std::move(all.front());
}

Status Team::sum(std::span<std::uint64_t> numbers) {
  VOLUTE_TRY(agree({}));
  addUp(numbers);
  return {};
}

UnitRecord& Team::record(std::string_view stage) {
  const auto known = std::ranges::find(records_, stage, &UnitRecord::stage);
  return known != records_.end() ? *known
                                 : records_.emplace_back(UnitRecord{std::string(stage), {}});
}

Status Team::forUnits(std::string_view stage, std::int64_t count, Progress& progress,
                      const std::function<Status(std::int64_t)>& body,
                      const std::function<Status()>& last) {
  // All have left the stage before. None begins before the counters are set.
  VOLUTE_TRY(agree({}));
  if (leads()) {
    setCounter(Counter::kTaken, 0);
    setCounter(Counter::kDone, 0);
  }
  VOLUTE_TRY(agree({}));
  if (leads())
    progress.report(stage, 0, static_cast<double>(count));  // who stops here has no first unit
  double milliseconds = 0;
  const std::clock_t cpuBefore = std::clock();
  Status status;
  for (std::int64_t unit = 0; (unit = fetchAdd(Counter::kTaken, 1)) < count;) {
    if (progress.cancelled()) {
      status = fail(ErrorCode::kCancelled, "stopped");
    } else {
      const Stopwatch watch(milliseconds);
      status = body(unit);
    }
    if (!status)
      break;
    record(stage).units.push_back(unit);
    const std::int64_t before = fetchAdd(Counter::kDone, 1);
    if (leads())
      progress.report(stage, static_cast<double>(before + 1), static_cast<double>(count));
  }
  record(stage).seconds += milliseconds / 1000;
  record(stage).cpuSeconds += static_cast<double>(std::clock() - cpuBefore) / CLOCKS_PER_SEC;
  if (status && last)
    status = last();
  VOLUTE_TRY(agree(status));
  if (leads())
    progress.report(stage, static_cast<double>(count), static_cast<double>(count));
  return {};
}

Status Team::post(std::int64_t item, std::vector<std::byte> bytes, std::uint64_t maxPending) {
  if (leads()) {
    own_.emplace_back(item, std::move(bytes));
    return {};
  }
  startSending(item, std::move(bytes));
  double milliseconds = 0;
  {
    const Stopwatch watch(milliseconds);
    for (int times = 0; sending() > maxPending; pause(times)) {
      if (stopped())
        return fail(ErrorCode::kCancelled, "stopped, since another rank was");
    }
  }
  waited_ += milliseconds / 1000;
  return {};
}

bool Team::arrived(std::int64_t item) {
  if (std::ranges::find(own_, item, [](const auto& sent) { return sent.first; }) != own_.end())
    return true;
  auto bytes = receive(item);
  if (!bytes)
    return false;
  own_.emplace_back(item, std::move(*bytes));
  return true;
}

Result<std::vector<std::byte>> Team::collect(std::int64_t item) {
  VOLUTE_ASSERT(leads());
  double milliseconds = 0;
  {
    const Stopwatch watch(milliseconds);
    for (int times = 0; !arrived(item); pause(times)) {
      if (stopped() || size() == 1)
        return fail(ErrorCode::kCancelled, "stopped, since another rank was");
    }
  }
  waited_ += milliseconds / 1000;
  const auto found = std::ranges::find(own_, item, [](const auto& sent) { return sent.first; });
  auto bytes = std::move(found->second);
  own_.erase(found);
  return bytes;
}

std::vector<std::vector<std::byte>> Team::exchange(std::span<const std::byte> bytes) {
  return {{bytes.begin(), bytes.end()}};
}

std::vector<std::vector<std::byte>> Team::exchangeEach(std::vector<std::vector<std::byte>> toEach) {
  return toEach;
}

void Team::addUp(std::span<std::uint64_t>) {}

std::int64_t Team::fetchAdd(Counter counter, std::int64_t increment) {
  std::int64_t& value = counter == Counter::kTaken ? taken_ : done_;
  value += increment;
  return value - increment;
}

void Team::setCounter(Counter counter, std::int64_t value) {
  (counter == Counter::kTaken ? taken_ : done_) = value;
}

void Team::startSending(std::int64_t, std::vector<std::byte>) {}

std::uint64_t Team::sending() {
  return 0;
}

std::optional<std::vector<std::byte>> Team::receive(std::int64_t) {
  return std::nullopt;
}

void Team::pause(int& times) {
  const auto longest = std::chrono::microseconds(1000);
  std::this_thread::sleep_for(std::min(longest, std::chrono::microseconds(20 + 20 * times++)));
}

}  // namespace volute
