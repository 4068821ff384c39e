// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/reader_helper.hpp"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <mutex>
#include <set>

#include "volute/io/reader_child.hpp"
#include "volute/io/reader_message.hpp"

namespace volute {
namespace {

std::mutex helperMutex;
int helperSocket = -1;
std::atomic<bool (*)()> helperCancelled = nullptr;

struct StartRequest {
  ReaderJob::Make make = nullptr;
  void (*prepare)() = nullptr;
  std::uint64_t memory = 0;
};

/// A child of the helper's parent, which waits for it as for its own. The helper has one thread, so
/// what glibc does around fork() is not needed.
pid_t forkSibling() {
  return static_cast<pid_t>(
      ::syscall(SYS_clone, CLONE_PARENT | SIGCHLD, nullptr, nullptr, nullptr, nullptr));
}

[[noreturn, maybe_unused]] void helpForever(int socket) {
  for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) ::signal(signal, SIG_IGN);
  ::dup2(socket, 3);
  ::close_range(4, ~0U, 0);
  if (const int null = ::open("/dev/null", O_RDWR); null >= 0) {
    for (int standard : {0, 1, 2}) ::dup2(null, standard);
    ::close(null);
  }
  detail::ReaderHeader header;
  std::string text;
  std::array<int, 4> given{};
  std::set<void (*)()> prepared{nullptr};
  while (detail::receiveReaderMessage(3, header, text, given)) {
    const auto request = fromMessage<StartRequest>(text);
    if (!request)
      break;
    if (prepared.insert(request->prepare).second)
      request->prepare();
    const pid_t child = forkSibling();
    if (child == 0)
      detail::serveAsReader(request->make,
                            {given[0], given[1], given[2], given[3], request->memory});
    for (const int descriptor : given) ::close(descriptor);
    const auto reply = static_cast<std::int64_t>(child);
    if (!detail::sendReaderMessage(3, {}, toMessage(reply)))
      break;
  }
  ::_exit(0);
}

/// For one thread at a time.
pid_t askHelper(const ReaderJob& job, const detail::ReaderLine& line) {
  const int descriptors[] = {line.socket, line.lifeline, line.shared, line.parameters};
  detail::ReaderHeader header;
  std::string text;
  const StartRequest request{job.make, job.prepare, line.memory};
  if (!detail::sendReaderMessage(helperSocket, {}, toMessage(request), descriptors) ||
      !detail::receiveReaderMessage(helperSocket, header, text))
    return -1;
  return static_cast<pid_t>(fromMessage<std::int64_t>(text).value_or(-1));
}

}  // namespace

namespace detail {

bool hasReaderHelper() {
  const std::lock_guard guard(helperMutex);
  return helperSocket >= 0;
}

bool readingIsCancelled() {
  bool (*const cancelled)() = helperCancelled;
  return cancelled && cancelled();
}

pid_t startFromHelper(const ReaderJob& job, const ReaderLine& line) {
  const std::lock_guard guard(helperMutex);
  return helperSocket < 0 ? -1 : askHelper(job, line);
}

}  // namespace detail

ReaderHelper::ReaderHelper(bool (*cancelled)()) {
  helperCancelled = cancelled;
// They follow fork(), but not what makes a sibling.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  int sockets[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets) != 0)
    return;
  process_ = ::fork();
  if (process_ == 0)
    helpForever(sockets[1]);
  ::close(sockets[1]);
  if (process_ < 0) {
    ::close(sockets[0]);
    return;
  }
  const std::lock_guard guard(helperMutex);
  helperSocket = sockets[0];
#endif
}

ReaderHelper::~ReaderHelper() {
  helperCancelled = nullptr;
  if (process_ <= 0)
    return;
  {
    const std::lock_guard guard(helperMutex);
    ::close(std::exchange(helperSocket, -1));
  }
  while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace volute
