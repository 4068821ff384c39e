// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// A reader as one that a file has taken over: it tries what the grid's name asks for, and tells in
// its error what came of it. For confinement_test.cpp.
#include <arpa/inet.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <map>

#include "volute/io/lattice.hpp"

namespace volute {
namespace {

/// Below 0, with errno, where it was refused.
using Attempt = std::function<long(const char* argument)>;

long connectSomewhere(const char*) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(9);
  return socket < 0
             ? -1
             : ::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address);
}

/// Shortens the memory that is shared, whichever descriptor it is.
long shortenAll(const char*) {
  for (int descriptor = 3; descriptor < 64; ++descriptor) {
    if (::ftruncate(descriptor, 0) == 0)
      return 0;
  }
  return -1;
}

/// The end of the parent would no longer end this process. The first descriptor is what it answers
/// through.
long closeLifeline(const char*) {
  for (int descriptor = 4; descriptor < 64; ++descriptor) {
    if (::close(descriptor) != 0 && errno == EPERM)
      return -1;
  }
  return 0;
}

long runProgram(const char* path) {
  char* arguments[] = {const_cast<char*>(path), nullptr};
  return ::execv(path, arguments);
}

long makeProcess(const char*) {
  const pid_t child = ::fork();
  if (child == 0)
    ::_exit(0);
  return child;
}

long mapMemory(int protection, int flags, std::size_t bytes = 4096) {
  return ::mmap(nullptr, bytes, protection, flags | MAP_ANONYMOUS, -1, 0) == MAP_FAILED ? -1 : 0;
}

long takeMemory(const char* mebibytes) {
  const auto bytes = static_cast<std::size_t>(std::atoi(mebibytes)) << 20;
  return mapMemory(PROT_READ | PROT_WRITE, MAP_PRIVATE, bytes);
}

const std::map<std::string, Attempt, std::less<>>& attempts() {
  static const std::map<std::string, Attempt, std::less<>> all = {
      {"read", [](const char* path) { return ::open(path, O_RDONLY); }},
      {"list", [](const char* path) { return ::open(path, O_RDONLY | O_DIRECTORY); }},
      {"write", [](const char* path) { return ::open(path, O_WRONLY); }},
      {"create", [](const char* path) { return ::open(path, O_CREAT | O_RDWR, 0666); }},
      {"remove", [](const char* path) { return ::unlink(path); }},
      {"rename", [](const char* path) { return ::rename(path, "/tmp/elsewhere"); }},
      {"connect", connectSomewhere},
      {"run", runProgram},
      {"fork", makeProcess},
      {"kill", [](const char*) { return ::kill(::getppid(), SIGKILL); }},
      {"trace", [](const char*) { return ::ptrace(PTRACE_ATTACH, ::getppid(), 0, 0); }},
      {"shorten", shortenAll},
      {"outlive", closeLifeline},
      {"code", [](const char*) { return mapMemory(PROT_READ | PROT_EXEC, MAP_PRIVATE); }},
      {"hoard", [](const char*) { return mapMemory(PROT_READ | PROT_WRITE, MAP_SHARED); }},
      {"take", takeMemory},
      {"rights", [](const char*) { return ::prctl(PR_SET_DUMPABLE, 1); }},
      {"limit", [](const char*) {
         const rlimit all{RLIM_INFINITY, RLIM_INFINITY};
         return ::setrlimit(RLIMIT_DATA, &all);
       }}};
  return all;
}

class HostileReader final : public LatticeReader {
 public:
  Result<LatticeFrame> describe(const std::filesystem::path& file, const std::string& grid,
                                const std::string&, bool) override {
    const std::size_t cut = grid.find(' ');
    const std::string argument = cut == grid.npos ? "" : grid.substr(cut + 1);
    if (grid == "lie")
      return lie();
    if (grid == "flood")
      flood();
    const auto attempt = attempts().find(grid.substr(0, cut));
    if (attempt == attempts().end())
      return fail(ErrorCode::kUnsupported, "{}: no such attempt", file.string());
    errno = 0;
    const long done = attempt->second(argument == "FILE" ? file.c_str() : argument.c_str());
    const int reason = errno;
    if (done >= 0)
      return fail(ErrorCode::kIo, "{}: {} worked", file.string(), grid);
    return fail(ErrorCode::kIo, "{}: {} was refused: {}", file.string(), grid,
                std::strerror(reason));
  }

  Status read(const std::filesystem::path& file, const std::string&, const IndexBox&,
              const IndexBox&, bool, std::span<float>, double&) override {
    return fail(ErrorCode::kUnsupported, "{}: nothing to read", file.string());
  }

 private:
  /// Names that do not end, numbers that are none.
  static LatticeFrame lie() {
    LatticeFrame frame;
    std::memset(frame.grid, 'x', sizeof frame.grid);
    std::memset(frame.others, 'x', sizeof frame.others);
    frame.channels = 1 << 30;
    frame.voxelSize = {std::numeric_limits<double>::quiet_NaN(), -1, 0};
    frame.box.end = {std::numeric_limits<std::int64_t>::max(), 1, 1};
    return frame;
  }

  /// Answers that nobody asked for, of any length and with any code.
  static void flood() {
    char bytes[200];
    for (int i = 0; i < 2000; ++i) {
      std::memset(bytes, i, sizeof bytes);
      iovec part{bytes, static_cast<std::size_t>(i % 200)};
      msghdr message{};
      message.msg_iov = &part;
      message.msg_iovlen = 1;
      for (int descriptor = 3; descriptor < 8; ++descriptor)
        ::sendmsg(descriptor, &message, MSG_DONTWAIT | MSG_NOSIGNAL);
    }
  }
};

std::unique_ptr<LatticeReader> makeHostileReader() {
  return std::make_unique<HostileReader>();
}

}  // namespace
}  // namespace volute

extern "C" const volute::LatticePlugin* voluteHostilePlugin() {
  static const volute::LatticePlugin plugin{volute::makeHostileReader, nullptr, nullptr};
  return &plugin;
}
