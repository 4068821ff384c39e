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
#include <new>
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

/// True when a message came, or the other end closed, within the time.
bool waitFor(int socket, double seconds) {
  pollfd descriptor{socket, POLLIN, 0};
  timespec begin{};
  clock_gettime(CLOCK_MONOTONIC, &begin);
  for (;;) {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    const double left =
        seconds - (now.tv_sec - begin.tv_sec) - 1e-9 * (now.tv_nsec - begin.tv_nsec);
    if (left <= 0)
      return false;
    const int ready = ::poll(&descriptor, 1, static_cast<int>(std::min(left * 1000 + 1, 1e6)));
    if (ready > 0)
      return true;
    if (ready < 0 && errno != EINTR)
      return false;
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
  if (child_ < 0)
    VOLUTE_TRY(start(file, limits.memory));
  // The processor's clock does not run for a child that waits for a lock; this one does.
  constexpr double kWaitFactor = 20;
  Header reply;
  std::string text;
  const bool answered = sendMessage(socket_, {valueCount, limits.seconds, -1}, request) &&
                        waitFor(socket_, kWaitFactor * limits.seconds) &&
                        receiveMessage(socket_, reply, text);
  if (!answered)
    return tl::unexpected<Error>(stop(file));
  if (reply.code < 0)
    return text;
  // What a library threw does not know the file.
  if (!text.starts_with(file))
    text = fmt::format("{}: {}", file, text);
  return tl::unexpected<Error>(Error{static_cast<ErrorCode>(reply.code), std::move(text)});
}

}  // namespace volute
