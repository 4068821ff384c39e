// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/reader_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <new>
#include <sstream>
#include <stdexcept>
#include <vector>

// Sanitizers reserve terabytes of address space: a limit on memory would stop every child.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define VOLUTE_NO_MEMORY_LIMIT 1
#endif

namespace volute {
namespace {

/// The fixed part of a message, in both directions; the text follows.
struct Header {
  std::uint64_t valueCount = 0;
  double seconds = 0;
  std::int32_t code = -1;  // of replies: an ErrorCode, or -1 for success
};

bool sendMessage(int socket, const Header& header, std::string_view text) {
  text = text.substr(0, ReaderProcess::kMaxMessage);
  iovec parts[2] = {{const_cast<Header*>(&header), sizeof header},
                    {const_cast<char*>(text.data()), text.size()}};
  msghdr message{};
  message.msg_iov = parts;
  message.msg_iovlen = 2;
  ssize_t sent = 0;
  do {
    sent = ::sendmsg(socket, &message, MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(sizeof header + text.size());
}

bool receiveMessage(int socket, Header& header, std::string& text) {
  text.resize(ReaderProcess::kMaxMessage);
  iovec parts[2] = {{&header, sizeof header}, {text.data(), text.size()}};
  msghdr message{};
  message.msg_iov = parts;
  message.msg_iovlen = 2;
  ssize_t received = 0;
  do {
    received = ::recvmsg(socket, &message, 0);
  } while (received < 0 && errno == EINTR);
  if (received < static_cast<ssize_t>(sizeof header))
    return false;
  text.resize(received - sizeof header);
  return true;
}

/// The first line of a file of a process in /proc, empty where there is none.
std::string lineOf(pid_t process, const char* name) {
  std::ifstream file(fmt::format("/proc/{}/{}", process, name));
  std::string line;
  std::getline(file, line);
  return line;
}

/// Finds a child that will never answer: a lock that another thread of the parent held at the fork
/// stays locked in the child.
class LockWatch {
 public:
  explicit LockWatch(pid_t child) : child_(child) {}

  /// Whether none of the child's threads has run for a while and the first waits for a lock. False
  /// where the system does not say.
  bool waitsForever(double now) {
    constexpr double kWhile = 3;  // [s]; what it waits for could only come from its own threads
    const std::string used = processorTime();
    if (used.empty() || used != used_ || !lineOf(child_, "wchan").starts_with("futex")) {
      used_ = used;
      since_ = now;
    }
    return now - since_ > kWhile;
  }

 private:
  /// Fields 14 and 15 of proc(5)'s stat, which follow the name in brackets.
  std::string processorTime() const {
    const std::string line = lineOf(child_, "stat");
    std::istringstream fields(line.substr(std::min(line.rfind(')'), line.size() - 1) + 1));
    std::string field, user, system;
    for (int i = 3; i < 14 && fields >> field; ++i) {
    }
    fields >> user >> system;
    return system.empty() ? "" : user + ' ' + system;
  }

  pid_t child_;
  std::string used_ = "unknown";
  double since_ = 0;
};

double monotonicSeconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

enum class Wait { kMessage, kTooLong, kForever };

/// For a message from the child, or until the other end closes.
/// @param looks  for a child that will never answer
Wait waitFor(int socket, pid_t child, double seconds, bool looks) {
  constexpr double kLook = 0.5;  // [s]
  pollfd descriptor{socket, POLLIN, 0};
  LockWatch watch(child);
  const double begin = monotonicSeconds();
  for (;;) {
    const double now = monotonicSeconds(), left = begin + seconds - now;
    if (left <= 0)
      return Wait::kTooLong;
    const int ready = ::poll(&descriptor, 1, static_cast<int>(1000 * std::min(left, kLook) + 1));
    if (ready > 0)
      return Wait::kMessage;
    if (ready < 0 && errno != EINTR)
      return Wait::kTooLong;
    if (looks && watch.waitsForever(now))
      return Wait::kForever;
  }
}

void limitMemory([[maybe_unused]] std::uint64_t bytes) {
#ifndef VOLUTE_NO_MEMORY_LIMIT
  std::uint64_t used = 0;
  if (FILE* status = std::fopen("/proc/self/statm", "r")) {
    unsigned long long total = 0, resident = 0, shared = 0, text = 0, library = 0, data = 0;
    if (std::fscanf(status, "%llu %llu %llu %llu %llu %llu", &total, &resident, &shared, &text,
                    &library, &data) == 6) {
      used = data * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    }
    std::fclose(status);
  }
  const rlimit limit{used + bytes, used + bytes};
  ::setrlimit(RLIMIT_DATA, &limit);
#endif
}

/// The process gets SIGXCPU when it used this much more processor time.
void limitTime(double seconds) {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  rlimit limit{};
  ::getrlimit(RLIMIT_CPU, &limit);
  const double used = usage.ru_utime.tv_sec + usage.ru_stime.tv_sec;
  const auto wanted = static_cast<rlim_t>(used + std::ceil(seconds) + 2);
  limit.rlim_cur = std::min(wanted, limit.rlim_max);
  ::setrlimit(RLIMIT_CPU, &limit);
}

Result<std::string> serveSafely(const ReaderProcess::Serve& serve, std::string_view request,
                                std::span<float> values) {
  constexpr const char* kMemory =
      "reading it needs more memory than is allowed; the file is damaged, or raise --max-memory";
  try {
    return serve(request, values);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kTooLarge, "{}", kMemory);
  } catch (const std::length_error&) {
    return fail(ErrorCode::kTooLarge, "{}", kMemory);
  } catch (const std::exception& error) {
    return fail(ErrorCode::kInvalidData, "{}", error.what());
  }
}

}  // namespace

ReaderProcess::ReaderProcess(Serve serve)
    : serve_(std::move(serve)), shared_(::memfd_create("volute-values", MFD_CLOEXEC)) {}

ReaderProcess::~ReaderProcess() {
  if (child_ > 0)
    (void)stop("");
  if (values_)
    ::munmap(values_, mappedBytes_);
  if (shared_ >= 0)
    ::close(shared_);
}

Status ReaderProcess::reserve(const std::string& file, std::size_t valueCount) {
  const std::size_t bytes = valueCount * sizeof(float);
  valueCount_ = valueCount;
  if (bytes <= mappedBytes_)
    return {};
  if (values_)
    ::munmap(values_, mappedBytes_);
  values_ = nullptr;
  mappedBytes_ = 0;
  valueCount_ = 0;
  void* memory = MAP_FAILED;
  if (shared_ >= 0 && ::ftruncate(shared_, static_cast<off_t>(bytes)) == 0) {
    memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, shared_, 0);
  }
  if (memory == MAP_FAILED) {
    return fail(ErrorCode::kTooLarge, "{}: no memory for {} MiB of values: {}", file, bytes >> 20,
                std::strerror(errno));
  }
  values_ = static_cast<float*>(memory);
  mappedBytes_ = bytes;
  valueCount_ = valueCount;
  return {};
}

Status ReaderProcess::start(const std::string& file, std::uint64_t memory) {
  int sockets[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets) != 0) {
    return fail(ErrorCode::kIo, "{}: cannot start a process to read it: {}", file,
                std::strerror(errno));
  }
  child_ = ::fork();
  if (child_ == 0) {
    ::close(sockets[0]);
    limitMemory(memory);
    serveForever(sockets[1]);
  }
  ::close(sockets[1]);
  socket_ = sockets[0];
  if (child_ > 0)
    return {};
  ::close(std::exchange(socket_, -1));
  return fail(ErrorCode::kIo, "{}: cannot start a process to read it: {}", file,
              std::strerror(errno));
}

void ReaderProcess::serveForever(int socket) {
  // Ctrl-C reaches the child too, but the parent decides. Libraries' chatter would only confuse.
  ::signal(SIGINT, SIG_IGN);
  for (int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGTERM, SIGXCPU})
    ::signal(signal, SIG_DFL);
  const rlimit noCore{0, 0};
  ::setrlimit(RLIMIT_CORE, &noCore);
  if (const int null = ::open("/dev/null", O_RDWR); null >= 0) {
    for (int standard : {0, 1, 2}) ::dup2(null, standard);
  }
  Header header;
  std::string request;
  while (receiveMessage(socket, header, request)) {
    limitTime(header.seconds);
    Header reply;
    std::string text;
    if (auto reserved = reserve("", header.valueCount); !reserved) {
      reply.code = static_cast<std::int32_t>(reserved.error().code);
      text = reserved.error().message;
    } else if (auto result = serveSafely(serve_, request, {values_, valueCount_})) {
      text = std::move(*result);
    } else {
      reply.code = static_cast<std::int32_t>(result.error().code);
      text = std::move(result.error().message);
    }
    if (!sendMessage(socket, reply, text))
      break;
  }
  ::_exit(0);
}

Error ReaderProcess::stop(const std::string& file) {
  ::close(std::exchange(socket_, -1));
  int status = 0;
  // A child that died already keeps its own status.
  ::kill(child_, SIGKILL);
  while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
  }
  child_ = -1;
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (signal == SIGXCPU || signal == SIGKILL) {
    return {
        ErrorCode::kInvalidData,
        fmt::format("{}: reading it takes too long or too much memory; the file is damaged", file)};
  }
  return {
      ErrorCode::kInvalidData,
      fmt::format("{}: the file is damaged: its library {} while reading it", file,
                  signal ? fmt::format("crashed (signal {})", signal) : std::string("gave up"))};
}

Result<std::string> ReaderProcess::call(const std::string& file, std::string_view request,
                                        std::size_t valueCount, const Limits& limits) {
  VOLUTE_TRY(reserve(file, valueCount));
  // The processor's clock does not run for a child that waits; this one does.
  constexpr double kWaitFactor = 20;
  constexpr int kForks = 4;  // where one met a lock that was held, the next need not
  Header reply;
  std::string text;
  for (int fork = 1;; ++fork) {
    if (child_ < 0)
      VOLUTE_TRY(start(file, limits.memory));
    const bool sent = sendMessage(socket_, {valueCount, limits.seconds, -1}, request);
    const Wait wait = sent ? waitFor(socket_, child_, kWaitFactor * limits.seconds, fork < kForks)
                           : Wait::kTooLong;
    if (wait == Wait::kMessage && receiveMessage(socket_, reply, text))
      break;
    const Error error = stop(file);
    if (wait != Wait::kForever)
      return tl::unexpected<Error>(error);
  }
  if (reply.code < 0)
    return text;
  // What a library threw does not know the file.
  if (!text.starts_with(file))
    text = fmt::format("{}: {}", file, text);
  return tl::unexpected<Error>(Error{static_cast<ErrorCode>(reply.code), std::move(text)});
}

}  // namespace volute
