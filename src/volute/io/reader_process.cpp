// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/reader_process.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "volute/base/packed_error.hpp"
#include "volute/base/read_files.hpp"
#include "volute/io/reader_child.hpp"
#include "volute/io/reader_helper.hpp"
#include "volute/io/reader_message.hpp"

namespace volute {
namespace {

static_assert(ReaderProcess::kMaxMessage == detail::kMaxMessage);

/// Of CPU time that a process has used [s]; nothing where the system does not say.
double cpuSecondsOf(pid_t process) {
  clockid_t clock{};
  timespec used{};
  if (::clock_getcpuclockid(process, &clock) != 0 || ::clock_gettime(clock, &used) != 0)
    return 0;
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

double monotonicSeconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Whether a thread of the process runs, would run if a core were free, or waits for a disk. True
/// where the system does not say.
bool worksOn(pid_t process) {
  const std::string folder = fmt::format("/proc/{}/task", process);
  DIR* tasks = ::opendir(folder.c_str());
  if (!tasks)
    return true;
  bool works = false;
  while (const dirent* task = ::readdir(tasks)) {
    std::ifstream file(fmt::format("{}/{}/stat", folder, task->d_name));
    std::string line;
    if (task->d_name[0] == '.' || !std::getline(file, line))
      continue;
    // The state follows the name, which is in brackets; proc(5).
    const auto place = line.rfind(") ");
    works |= place == std::string::npos || line.at(place + 2) == 'R' || line.at(place + 2) == 'D';
  }
  ::closedir(tasks);
  return works;
}

/// Finds a child that will never answer: all of its threads wait, and none of them has run for a
/// while. What they wait for could only come from themselves: a lock that another thread of the
/// parent held at the fork stays locked in the child.
class IdleWatch {
 public:
  explicit IdleWatch(pid_t child) : child_(child) {}

  bool waitsForever(double now) {
    constexpr double kWhile = 3;  // [s]
    const double used = cpuSecondsOf(child_);
    if (used == 0 || used != used_ || worksOn(child_)) {
      used_ = used;
      since_ = now;
    }
    return now - since_ > kWhile;
  }

 private:
  pid_t child_;
  double used_ = -1;
  double since_ = 0;
};

enum class Wait { kMessage, kGone, kTooLong, kForever, kCancelled };

/// For a message from the child, or until the other end closes.
Wait waitFor(int socket, pid_t child, const ReaderProcess::Limits& limits) {
  constexpr double kLook = 0.2;  // [s]
  // The CPU's clock does not run for a child that waits; this one does.
  constexpr double kWaitFactor = 20;
  pollfd descriptor{socket, POLLIN, 0};
  IdleWatch watch(child);
  const double begin = monotonicSeconds(), used = cpuSecondsOf(child);
  for (;;) {
    const double now = monotonicSeconds(), left = begin + kWaitFactor * limits.seconds - now;
    if (left <= 0 || cpuSecondsOf(child) - used > limits.seconds)
      return Wait::kTooLong;
    if (detail::readingIsCancelled())
      return Wait::kCancelled;
    const int ready = ::poll(&descriptor, 1, static_cast<int>(1000 * std::min(left, kLook) + 1));
    if (ready > 0)
      return Wait::kMessage;
    if (ready < 0 && errno != EINTR)
      return Wait::kGone;
    if (watch.waitsForever(now))
      return Wait::kForever;
  }
}

/// Limits of the session that may be why a library fails; empty: they are wide.
std::string lowLimits() {
  struct Rule {
    int which;
    rlim_t low;
    const char* option;
  };

  std::string text;
  for (const Rule& rule : {Rule{RLIMIT_NOFILE, 256, "-n"}, Rule{RLIMIT_NPROC, 256, "-u"},
                           Rule{RLIMIT_AS, RLIM_INFINITY - 1, "-v"}}) {
    rlimit limit{};
    if (::getrlimit(static_cast<__rlimit_resource_t>(rule.which), &limit) == 0 &&
        limit.rlim_cur < rule.low) {
      text += fmt::format("{}ulimit {} {}", text.empty() ? "" : ", ", rule.option,
                          rule.which == RLIMIT_AS ? limit.rlim_cur >> 10 : limit.rlim_cur);
    }
  }
  return text.empty() ? "" : fmt::format("; or this session's limits are too low ({})", text);
}

/// Why a child gave no answer.
Error noAnswer(Wait wait, int signal, const std::string& file, std::uint64_t memory) {
  if (wait == Wait::kCancelled)
    return {ErrorCode::kCancelled, fmt::format("{}: stopped while reading it", file)};
  const bool ended = wait != Wait::kGone || signal == SIGXCPU || signal == SIGKILL;
  const std::string sentence =
      ended ? std::string(
                  "reading it takes too long or too much memory: the file is damaged, or "
                  "larger than what may be used")
            // Few libraries look at what an allocation gives.
            : fmt::format(
                  "its library {} while reading it: the file is damaged, or needs more than "
                  "the {} MiB that may be used",
                  signal ? fmt::format("crashed (signal {})", signal) : "gave up", memory >> 20);
  return {ErrorCode::kInvalidData,
          fmt::format("{}: {}{}", file, sentence, lowLimits()),
          {},
          {},
          {Hint::raise("max_memory")}};
}

/// A code as it came from the other process.
ErrorCode codeOf(std::int32_t code) {
  const bool known = code >= static_cast<std::int32_t>(ErrorCode::kInvalidArgument) &&
                     code <= static_cast<std::int32_t>(ErrorCode::kCancelled);
  return known ? static_cast<ErrorCode>(code) : ErrorCode::kInvalidData;
}

int makeSharedMemory() {
  const int shared = ::memfd_create("volute-values", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  // Who shares it could make it shorter, and whoever reads past its end would be ended.
  if (shared >= 0)
    ::fcntl(shared, F_ADD_SEALS, F_SEAL_SHRINK);
  return shared;
}

}  // namespace

ReaderProcess::ReaderProcess(ReaderJob job) : job_(std::move(job)), shared_(makeSharedMemory()) {}

ReaderProcess::ReaderProcess(Serve unconfined)
    : unconfined_(std::move(unconfined)), shared_(makeSharedMemory()) {}

ReaderProcess::~ReaderProcess() {
  if (child_ > 0)
    stop();
  if (values_)
    ::munmap(values_, mappedBytes_);
  if (shared_ >= 0)
    ::close(shared_);
}

Status ReaderProcess::reserve(const std::string& file, std::size_t valueCount) {
  constexpr std::size_t kMaxValues = std::size_t{1} << 44;
  const std::size_t bytes = std::min(valueCount, kMaxValues) * sizeof(float);
  valueCount_ = valueCount;
  if (bytes <= mappedBytes_)
    return {};
  if (values_)
    ::munmap(values_, mappedBytes_);
  values_ = nullptr;
  mappedBytes_ = 0;
  valueCount_ = 0;
  void* memory = MAP_FAILED;
  if (shared_ >= 0 && valueCount <= kMaxValues &&
      ::ftruncate(shared_, static_cast<off_t>(bytes)) == 0) {
    memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, shared_, 0);
  }
  if (memory == MAP_FAILED && errno == EFBIG) {
    return fail(ErrorCode::kTooLarge,
                "{}: {} MiB of values: the limit on the size of files (ulimit -f) holds for the "
                "memory that two processes share, too; raise it",
                file, (bytes >> 20) + 1);
  }
  if (memory == MAP_FAILED) {
    return fail(ErrorCode::kTooLarge, "{}: no memory for {} MiB of values: {}", file,
                (bytes >> 20) + 1, std::strerror(errno));
  }
  values_ = static_cast<float*>(memory);
  mappedBytes_ = bytes;
  valueCount_ = valueCount;
  return {};
}

Status ReaderProcess::start(const std::string& file, std::uint64_t memory) {
  for (const auto& path : job_.readable) noteReadName(path);
  const auto cannot = [&] {
    return fail(ErrorCode::kIo, "{}: cannot start a process to read it: {}", file,
                std::strerror(errno));
  };
  int sockets[2], life[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets) != 0)
    return cannot();
  if (::pipe2(life, O_CLOEXEC) != 0) {
    const Status status = cannot();
    for (const int descriptor : sockets) ::close(descriptor);
    return status;
  }
  const detail::ReaderLine line{sockets[1], life[0], shared_,
                                unconfined_ ? shared_ : detail::writeReaderParameters(job_),
                                memory};
  if (!unconfined_ && line.parameters >= 0)
    child_ = detail::startFromHelper(job_, line);
  if (child_ < 0 && line.parameters >= 0) {
    child_ = ::fork();
    if (child_ == 0)
      unconfined_ ? detail::serveUnconfined(unconfined_, line)
                  : detail::serveAsReader(job_.make, line);
  }
  const Status status = child_ > 0 ? Status() : cannot();
  ::close(sockets[1]);
  ::close(life[0]);
  if (!unconfined_ && line.parameters >= 0)
    ::close(line.parameters);
  socket_ = sockets[0];
  lifeline_ = life[1];
  if (!status) {
    ::close(std::exchange(socket_, -1));
    ::close(std::exchange(lifeline_, -1));
  }
  return status;
}

/// The signal that ended the child, 0 when it ended by itself, -1 when it could not begin.
int ReaderProcess::stop() {
  ::close(std::exchange(socket_, -1));
  int status = 0;
  // A child that died already keeps its own status.
  ::kill(child_, SIGKILL);
  while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
  }
  ::close(std::exchange(lifeline_, -1));
  child_ = -1;
  if (WIFEXITED(status) && WEXITSTATUS(status) == detail::kNoDescriptors)
    return -1;
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

Result<std::string> ReaderProcess::call(const std::string& file, std::string_view request,
                                        std::size_t valueCount, const Limits& limits) {
  VOLUTE_TRY(reserve(file, valueCount));
  // Where one that was forked from this process met a lock that was held, the next need not.
  const int forks = unconfined_ || !detail::hasReaderHelper() ? 4 : 1;
  detail::ReaderHeader reply;
  std::string text;
  for (int fork = 1;; ++fork) {
    if (child_ < 0)
      VOLUTE_TRY(start(file, limits.memory));
    const bool sent = detail::sendReaderMessage(socket_, {valueCount, limits.seconds, -1}, request);
    Wait wait = sent ? waitFor(socket_, child_, limits) : Wait::kGone;
    if (wait == Wait::kMessage) {
      if (detail::receiveReaderMessage(socket_, reply, text))
        break;
      wait = Wait::kGone;
    }
    const int signal = stop();
    if (signal < 0) {
      return fail(ErrorCode::kIo,
                  "{}: the process that reads it has too few descriptors{}; raise the limit", file,
                  lowLimits());
    }
    if (wait != Wait::kForever || fork == forks)
      return tl::unexpected<Error>(noAnswer(wait, signal, file, limits.memory));
  }
  if (reply.code < 0)
    return text;
  Error error = unpacked(codeOf(reply.code), text);
  if (error.path.empty() && error.statement.empty()) {
    if (error.member.empty())
      error.path = file;
  } else if (error.path != file) {  // what a library threw names none
    error = inFile(std::move(error), file);
  }
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace volute
