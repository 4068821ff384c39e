// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// The only file that knows MPI. Built as lib/volute/volute_mpi.so and loaded by cluster.cpp.
#include "volute/cluster/mpi_plugin.hpp"

#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <list>
#include <string>
#include <string_view>
#include <thread>

namespace volute {
namespace {

// Counts are ints in MPI: what is longer goes in pieces.
constexpr std::size_t kPiece = std::size_t{1} << 30;

/// In which a launcher ends all ranks after one was killed; OpenMPI's mpirun takes two.
constexpr auto kLaunchersTime = std::chrono::seconds(4);

class MpiTeam final : public Team {
 public:
  /// @param finalise  whether MPI ends with the team.
  MpiTeam(MPI_Comm communicator, bool finalise) : finalise_(finalise) {
    MPI_Comm_dup(communicator, &meeting_);
    MPI_Comm_dup(communicator, &mail_);
    MPI_Comm_rank(meeting_, &rank_);
    MPI_Comm_size(meeting_, &size_);
    const auto bytes = static_cast<MPI_Aint>(rank_ == 0 ? kCounters * sizeof(std::int64_t) : 0);
    MPI_Win_allocate(bytes, sizeof(std::int64_t), MPI_INFO_NULL, meeting_, &counters_, &window_);
    if (rank_ == 0)
      std::fill_n(counters_, kCounters, std::int64_t{0});
    MPI_Win_lock_all(MPI_MODE_NOCHECK, window_);
    MPI_Win_sync(window_);
    findNeighbours();
    MPI_Barrier(meeting_);
    servant_ = std::thread([this] { serve(); });
  }

  // A program that ends by an error has sent what nobody has received: rank 0 takes it until all
  // are rid of theirs, else MPI_Finalize would wait.
  ~MpiTeam() override {
    leaving_ = true;
    MPI_Request all = MPI_REQUEST_NULL;
    bool entered = false;
    for (int times = 0;; pause(times)) {
      drop();
      if (!entered && sending() == 0) {
        MPI_Ibarrier(mail_, &all);
        entered = true;
      }
      int done = 0;
      if (entered)
        MPI_Test(&all, &done, MPI_STATUS_IGNORE);
      if (done)
        break;
    }
    ended_ = true;
    servant_.join();
    MPI_Win_unlock_all(window_);
    MPI_Win_free(&window_);
    MPI_Comm_free(&mail_);
    MPI_Comm_free(&meeting_);
    if (finalise_)
      MPI_Finalize();
  }

  int rank() const override { return rank_; }

  int size() const override { return size_; }

  std::string host() const override {
    char name[256] = "";
    ::gethostname(name, sizeof name - 1);
    return name;
  }

 protected:
  // Waiting ranks sleep between two looks: MPI's own waiting would keep a core busy.
  std::vector<std::vector<std::byte>> exchange(std::span<const std::byte> bytes) override {
    const std::uint64_t own = bytes.size();
    std::vector<std::uint64_t> sizes(static_cast<std::size_t>(size_));
    MPI_Request request;
    MPI_Iallgather(&own, 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, meeting_, &request);
    wait(request);
    std::uint64_t total = 0;
    for (const std::uint64_t size : sizes) total += size;
    std::vector<std::vector<std::byte>> all;
    if (total >= kPiece)
      return exchangeInTurn(bytes, sizes);
    std::vector<int> counts, places;
    int place = 0;
    for (const std::uint64_t size : sizes) {
      counts.push_back(static_cast<int>(size));
      places.push_back(place);
      place += static_cast<int>(size);
    }
    std::vector<std::byte> together(total);
    MPI_Iallgatherv(bytes.data(), static_cast<int>(own), MPI_BYTE, together.data(), counts.data(),
                    places.data(), MPI_BYTE, meeting_, &request);
    wait(request);
    auto begin = together.begin();
    for (const std::uint64_t size : sizes) {
      all.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(size));
      begin += static_cast<std::ptrdiff_t>(size);
    }
    return all;
  }

  // From rank to rank without buffers between, which cost more than the sending.
  std::vector<std::vector<std::byte>> exchangeEach(
      std::vector<std::vector<std::byte>> toEach) override {
    const auto ranks = static_cast<std::size_t>(size_), self = static_cast<std::size_t>(rank_);
    std::vector<std::uint64_t> own(ranks), sizes(ranks);
    std::ranges::transform(toEach, own.begin(), [](const auto& bytes) { return bytes.size(); });
    MPI_Request request;
    MPI_Ialltoall(own.data(), 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, meeting_, &request);
    wait(request);
    std::vector<std::vector<std::byte>> received(ranks);
    std::vector<MPI_Request> requests;
    for (std::size_t i = 0; i < ranks; ++i) {
      if (i == self)
        continue;
      received[i].resize(sizes[i]);
      forEachPiece(sizes[i], [&](std::size_t begin, int count) {
        MPI_Irecv(received[i].data() + begin, count, MPI_BYTE, static_cast<int>(i), kExchangeTag,
                  meeting_, &requests.emplace_back());
      });
    }
    for (std::size_t i = 0; i < ranks; ++i) {
      if (i == self)
        continue;
      forEachPiece(own[i], [&](std::size_t begin, int count) {
        MPI_Isend(toEach[i].data() + begin, count, MPI_BYTE, static_cast<int>(i), kExchangeTag,
                  meeting_, &requests.emplace_back());
      });
    }
    received[self] = std::move(toEach[self]);
    for (int times = 0, done = 0; !done; done ? void() : pause(times))
      MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
    return received;
  }

  void addUp(std::span<std::uint64_t> numbers) override {
    MPI_Request request;
    for (std::size_t begin = 0; begin < numbers.size(); begin += kPiece / 8) {
      const auto count = static_cast<int>(std::min(kPiece / 8, numbers.size() - begin));
      MPI_Iallreduce(MPI_IN_PLACE, numbers.data() + begin, count, MPI_UINT64_T, MPI_SUM, meeting_,
                     &request);
      wait(request);
    }
  }

  std::int64_t fetchAdd(Counter counter, std::int64_t increment) override {
    std::int64_t before = 0;
    MPI_Fetch_and_op(&increment, &before, MPI_INT64_T, 0, static_cast<int>(counter), MPI_SUM,
                     window_);
    MPI_Win_flush(0, window_);
    return before;
  }

  void setCounter(Counter counter, std::int64_t value) override {
    std::int64_t before = 0;
    MPI_Fetch_and_op(&value, &before, MPI_INT64_T, 0, static_cast<int>(counter), MPI_REPLACE,
                     window_);
    MPI_Win_flush(0, window_);
  }

  void startSending(std::int64_t item, std::vector<std::byte> bytes) override {
    Sent& sent = sent_.emplace_back();
    sent.bytes = std::move(bytes);
    sent.size = sent.bytes.size();
    const int tag = tagOf(item);
    MPI_Isend(&sent.size, 1, MPI_UINT64_T, 0, tag, mail_, &sent.requests.emplace_back());
    for (std::size_t begin = 0; begin < sent.bytes.size(); begin += kPiece) {
      const auto count = static_cast<int>(std::min(kPiece, sent.bytes.size() - begin));
      MPI_Isend(sent.bytes.data() + begin, count, MPI_BYTE, 0, tag, mail_,
                &sent.requests.emplace_back());
    }
  }

  std::uint64_t sending() override {
    std::uint64_t bytes = 0;
    for (auto sent = sent_.begin(); sent != sent_.end();) {
      int done = 0;
      MPI_Testall(static_cast<int>(sent->requests.size()), sent->requests.data(), &done,
                  MPI_STATUSES_IGNORE);
      if (done) {
        sent = sent_.erase(sent);
        continue;
      }
      bytes += std::max<std::uint64_t>(sent->size, 1);
      ++sent;
    }
    return bytes;
  }

  std::optional<std::vector<std::byte>> receive(std::int64_t item) override {
    return receiveTag(tagOf(item));
  }

 private:
  struct Sent {
    std::vector<std::byte> bytes;
    std::uint64_t size = 0;
    std::vector<MPI_Request> requests;
  };

  static constexpr int kExchangeTag = 1;  // in meeting_, where serve() looks for 0

  /// Calls body(begin, count) for pieces that MPI can count.
  template <class Body>
  static void forEachPiece(std::uint64_t size, Body&& body) {
    for (std::uint64_t begin = 0; begin < size; begin += kPiece)
      body(begin, static_cast<int>(std::min<std::uint64_t>(kPiece, size - begin)));
  }

  static constexpr int kCounters = 2;

  // 2^30 items may be on their way together; MPI allows tags up to 2^31 - 1 here, and 32767 at
  // least.
  static int tagOf(std::int64_t item) { return static_cast<int>(item % (std::int64_t{1} << 30)); }

  void wait(MPI_Request& request) {
    for (int times = 0;; pause(times)) {
      int done = 0;
      MPI_Test(&request, &done, MPI_STATUS_IGNORE);
      if (done)
        return;
    }
  }

  std::optional<std::vector<std::byte>> receiveTag(int tag) {
    int there = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, tag, mail_, &there, &status);
    if (!there)
      return std::nullopt;
    std::uint64_t size = 0;
    MPI_Request request;
    MPI_Irecv(&size, 1, MPI_UINT64_T, status.MPI_SOURCE, status.MPI_TAG, mail_, &request);
    wait(request);
    std::vector<std::byte> bytes(size);
    for (std::size_t begin = 0; begin < bytes.size(); begin += kPiece) {
      const auto count = static_cast<int>(std::min(kPiece, bytes.size() - begin));
      MPI_Irecv(bytes.data() + begin, count, MPI_BYTE, status.MPI_SOURCE, status.MPI_TAG, mail_,
                &request);
      wait(request);
    }
    return bytes;
  }

  void drop() {
    while (rank_ == 0 && receiveTag(MPI_ANY_TAG)) {
    }
  }

  std::vector<std::vector<std::byte>> exchangeInTurn(std::span<const std::byte> bytes,
                                                     std::span<const std::uint64_t> sizes) {
    std::vector<std::vector<std::byte>> all;
    for (int from = 0; from < size_; ++from) {
      std::vector<std::byte> message(sizes[static_cast<std::size_t>(from)]);
      if (from == rank_)
        message.assign(bytes.begin(), bytes.end());
      for (std::size_t begin = 0; begin < message.size(); begin += kPiece) {
        const auto count = static_cast<int>(std::min(kPiece, message.size() - begin));
        MPI_Request request;
        MPI_Ibcast(message.data() + begin, count, MPI_BYTE, from, meeting_, &request);
        wait(request);
      }
      all.push_back(std::move(message));
    }
    return all;
  }

  /// A rank on this machine.
  struct Neighbour {
    int rank = 0;
    pid_t process = 0;
  };

  void findNeighbours() {
    struct Place {
      char host[64] = "";
      std::uint64_t processes = 0;  // in which process numbers mean the same
      std::int64_t process = 0;
    } own;

    ::gethostname(own.host, sizeof own.host - 1);
    struct stat space;
    own.processes = ::stat("/proc/self/ns/pid", &space) == 0 ? space.st_ino : 0;
    own.process = ::getpid();
    std::vector<Place> all(static_cast<std::size_t>(size_));
    MPI_Allgather(&own, sizeof own, MPI_BYTE, all.data(), sizeof own, MPI_BYTE, meeting_);
    for (int rank = 0; rank < size_; ++rank) {
      const Place& place = all[static_cast<std::size_t>(rank)];
      if (rank != rank_ && own.processes != 0 && place.processes == own.processes &&
          std::string_view(place.host) == own.host)
        neighbours_.push_back({rank, static_cast<pid_t>(place.process)});
    }
  }

  static bool hasEnded(pid_t process) {
    if (::kill(process, 0) != 0)
      return errno == ESRCH;
    // One that nobody has waited for is still there; its state follows the name, which is in
    // brackets: proc(5).
    std::ifstream file("/proc/" + std::to_string(process) + "/stat");
    std::string line;
    std::getline(file, line);
    const auto place = line.rfind(") ");
    return place != line.npos && line.compare(place + 2, 1, "Z") == 0;
  }

  // Over a network others reach the counters only while rank 0 is in MPI, and it computes.
  void serve() {
    using namespace std::chrono_literals;
    const auto nap = rank_ == 0 ? 1ms : 50ms;
    auto looked = std::chrono::steady_clock::now(), ended = looked;
    bool missing = false;
    while (!ended_) {
      int there = 0;
      if (rank_ == 0)
        MPI_Iprobe(MPI_ANY_SOURCE, 0, meeting_, &there, MPI_STATUS_IGNORE);
      std::this_thread::sleep_for(nap);
      const auto now = std::chrono::steady_clock::now();
      if (leaving_ || now - looked < 500ms)
        continue;
      looked = now;
      const auto gone = std::ranges::find_if(
          neighbours_, [](const Neighbour& one) { return hasEnded(one.process); });
      if (gone == neighbours_.end() || !missing)
        ended = now;
      missing = gone != neighbours_.end();
      if (now - ended < kLaunchersTime)
        continue;
      endWithout(*gone);
      return;
    }
  }

  /// For a rank that was killed MPI waits for ever, and a launcher that does not hear of its end
  /// leaves the others there.
  void endWithout(const Neighbour& gone) const {
    std::fprintf(
        stderr,
        "volute: rank %d (process %d) has ended without a word: it was killed, perhaps for "
        "its memory; the others end as well\n",
        gone.rank, static_cast<int>(gone.process));
    ::kill(::getpid(), SIGTERM);
  }

  bool finalise_;
  MPI_Comm meeting_ = MPI_COMM_NULL, mail_ = MPI_COMM_NULL;
  int rank_ = 0, size_ = 1;
  std::int64_t* counters_ = nullptr;
  MPI_Win window_ = MPI_WIN_NULL;
  std::list<Sent> sent_;
  std::atomic<bool> ended_{false}, leaving_{false};
  std::vector<Neighbour> neighbours_;
  std::thread servant_;
};

std::unique_ptr<Team> makeMpiTeam(const void* communicator, std::string& error) {
  int initialised = 0;
  MPI_Initialized(&initialised);
  int level = MPI_THREAD_SINGLE;
  if (communicator || initialised)
    MPI_Query_thread(&level);
  else if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_MULTIPLE, &level) != MPI_SUCCESS)
    error = "MPI cannot be started";
  else
    initialised = 2;
  if (error.empty() && level < MPI_THREAD_MULTIPLE)
    error = "this MPI does not serve several threads (MPI_THREAD_MULTIPLE), which Volute needs";
  if (!error.empty())
    return nullptr;
  const MPI_Comm world =
      communicator ? *static_cast<const MPI_Comm*>(communicator) : MPI_COMM_WORLD;
  return std::make_unique<MpiTeam>(world, initialised == 2);
}

}  // namespace
}  // namespace volute

extern "C" const volute::MpiPlugin* voluteMpiPlugin() {
  static const volute::MpiPlugin plugin{{}, volute::makeMpiTeam};
  return &plugin;
}
