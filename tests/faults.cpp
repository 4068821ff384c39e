// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
//
// A library for LD_PRELOAD that makes one call of a program go wrong:
//   VOLUTE_FAULT=full:N   from the N-th call on that writes below VOLUTE_FAULT_FOLDER, the disk is
//   full VOLUTE_FAULT=once:N   the N-th of them fails with EIO, those after it do not
//   VOLUTE_FAULT=flip:N   the N-th of them that writes bytes writes one flipped bit, and says
//   nothing VOLUTE_FAULT=kill:N   the process is killed (SIGKILL) before the N-th of them
//   VOLUTE_FAULT=read:N   the N-th call that reads a file below VOLUTE_FAULT_INPUTS fails with EIO
//   VOLUTE_FAULT=memory:N the N-th operator new throws std::bad_alloc
//   VOLUTE_FAULT=clock:N  CLOCK_REALTIME jumps back and forth by N seconds, at every call
// Calls are counted from 1, over all threads of the process that was started; it writes how many
// there were to the descriptor VOLUTE_FAULT_COUNT when it ends. What it forks is left alone.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <new>

namespace {

enum class Fault { kNone, kFull, kOnce, kFlip, kKill, kRead, kMemory, kClock };

struct Plan {
  Fault fault = Fault::kNone;
  long number = 0;
  const char* folder = nullptr;
  const char* inputs = nullptr;
  int count = -1;
  pid_t process = 0;
};

Plan plan;
std::atomic<long> writes{0}, allocations{0}, reads{0}, clocks{0};

template <class Function>
Function real(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

__attribute__((constructor(101))) void begin() {
  static constexpr struct {
    const char* name;
    Fault fault;
  } kFaults[] = {{"full:", Fault::kFull},  {"once:", Fault::kOnce}, {"flip:", Fault::kFlip},
                 {"kill:", Fault::kKill},  {"read:", Fault::kRead}, {"memory:", Fault::kMemory},
                 {"clock:", Fault::kClock}};

  const char* text = std::getenv("VOLUTE_FAULT");
  for (const auto& one : kFaults) {
    if (text && std::strncmp(text, one.name, std::strlen(one.name)) == 0) {
      plan.number = std::atol(text + std::strlen(one.name));
      plan.fault = one.fault;
    }
  }
  plan.folder = std::getenv("VOLUTE_FAULT_FOLDER");
  plan.inputs = std::getenv("VOLUTE_FAULT_INPUTS");
  if (const char* count = std::getenv("VOLUTE_FAULT_COUNT"))
    plan.count = std::atoi(count);
  plan.process = ::getpid();
}

bool below(const char* path, const char* folder = plan.folder) {
  return folder && path && std::strncmp(path, folder, std::strlen(folder)) == 0;
}

bool below(int descriptor, const char* folder = plan.folder) {
  struct stat status{};
  if (::fstat(descriptor, &status) != 0 || !(S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)))
    return false;
  char link[64], path[4096];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t length = ::readlink(link, path, sizeof path - 1);
  if (length < 0)
    return false;
  path[length] = '\0';
  return below(path, folder);
}

/// Whether this call, one that reads, is to fail; errno is set then.
bool failsToRead(int descriptor) {
  if (::getpid() != plan.process || !plan.inputs || !below(descriptor, plan.inputs))
    return false;
  if (++reads != plan.number || plan.fault != Fault::kRead)
    return false;
  errno = EIO;
  return true;
}

/// Whether this call, one that writes, is to fail; errno is set then.
bool fails() {
  if (plan.fault == Fault::kMemory || plan.fault == Fault::kRead || plan.fault == Fault::kClock ||
      ::getpid() != plan.process)
    return false;
  const long number = ++writes;
  if (plan.fault == Fault::kKill && number == plan.number)
    ::kill(::getpid(), SIGKILL);
  if (plan.fault == Fault::kFull && number >= plan.number) {
    errno = ENOSPC;
    return true;
  }
  if (plan.fault == Fault::kOnce && number == plan.number) {
    errno = EIO;
    return true;
  }
  return false;
}

/// Whether this call, which writes bytes, is to write a flipped bit. Called where fails() did not.
bool flips() {
  return plan.fault == Fault::kFlip && writes == plan.number && ::getpid() == plan.process;
}

/// The bytes with the lowest bit of the middle one flipped.
struct Flipped {
  unsigned char* copy = nullptr;

  Flipped(const void* bytes, std::size_t count) {
    if (count == 0)
      return;
    copy = static_cast<unsigned char*>(std::malloc(count));
    if (!copy)
      return;
    std::memcpy(copy, bytes, count);
    copy[count / 2] ^= 1;
  }

  ~Flipped() { std::free(copy); }

  Flipped(const Flipped&) = delete;
  Flipped& operator=(const Flipped&) = delete;
};

/// Not from atexit(): the program may end by _exit().
void tell() {
  if (plan.count < 0 || ::getpid() != plan.process)
    return;
  char text[64];
  const int length = std::snprintf(text, sizeof text, "%ld %ld %ld\n", writes.load(),
                                   allocations.load(), reads.load());
  static const auto write = real<ssize_t (*)(int, const void*, std::size_t)>("write");
  (void)!write(plan.count, text, static_cast<std::size_t>(length));
}

__attribute__((destructor)) void end() {
  tell();
}

void* allocate(std::size_t size, std::size_t alignment) {
  const long number = ++allocations;
  if (plan.fault == Fault::kMemory && number == plan.number && ::getpid() == plan.process) {
    if (const auto handler =
            std::get_new_handler())  // which may throw, as that of the library would
      handler();
    throw std::bad_alloc();
  }
  void* memory = alignment > 0
                     ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
                     : std::malloc(size > 0 ? size : 1);
  if (!memory)
    throw std::bad_alloc();
  return memory;
}

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* bytes, std::size_t count) {
  static const auto next = real<ssize_t (*)(int, const void*, std::size_t)>("write");
  const bool ours = below(descriptor);
  if (ours && fails())
    return -1;
  if (ours && flips()) {
    const Flipped other(bytes, count);
    return next(descriptor, other.copy ? other.copy : bytes, count);
  }
  return next(descriptor, bytes, count);
}

ssize_t writev(int descriptor, const iovec* parts, int count) {
  static const auto next = real<ssize_t (*)(int, const iovec*, int)>("writev");
  return below(descriptor) && fails() ? -1 : next(descriptor, parts, count);
}

ssize_t pwrite(int descriptor, const void* bytes, std::size_t count, off_t offset) {
  static const auto next = real<ssize_t (*)(int, const void*, std::size_t, off_t)>("pwrite");
  const bool ours = below(descriptor);
  if (ours && fails())
    return -1;
  if (ours && flips()) {
    const Flipped other(bytes, count);
    return next(descriptor, other.copy ? other.copy : bytes, count, offset);
  }
  return next(descriptor, bytes, count, offset);
}

ssize_t pwrite64(int descriptor, const void* bytes, std::size_t count, off64_t offset) {
  static const auto next = real<ssize_t (*)(int, const void*, std::size_t, off64_t)>("pwrite64");
  return below(descriptor) && fails() ? -1 : next(descriptor, bytes, count, offset);
}

ssize_t read(int descriptor, void* bytes, std::size_t count) {
  static const auto next = real<ssize_t (*)(int, void*, std::size_t)>("read");
  return failsToRead(descriptor) ? -1 : next(descriptor, bytes, count);
}

ssize_t readv(int descriptor, const iovec* parts, int count) {
  static const auto next = real<ssize_t (*)(int, const iovec*, int)>("readv");
  return failsToRead(descriptor) ? -1 : next(descriptor, parts, count);
}

ssize_t pread(int descriptor, void* bytes, std::size_t count, off_t offset) {
  static const auto next = real<ssize_t (*)(int, void*, std::size_t, off_t)>("pread");
  return failsToRead(descriptor) ? -1 : next(descriptor, bytes, count, offset);
}

ssize_t pread64(int descriptor, void* bytes, std::size_t count, off64_t offset) {
  static const auto next = real<ssize_t (*)(int, void*, std::size_t, off64_t)>("pread64");
  return failsToRead(descriptor) ? -1 : next(descriptor, bytes, count, offset);
}

int fsync(int descriptor) {
  static const auto next = real<int (*)(int)>("fsync");
  return below(descriptor) && fails() ? -1 : next(descriptor);
}

int rename(const char* from, const char* to) {
  static const auto next = real<int (*)(const char*, const char*)>("rename");
  return below(to) && fails() ? -1 : next(from, to);
}

int renameat2(int fromFolder, const char* from, int toFolder, const char* to, unsigned flags) {
  static const auto next = real<int (*)(int, const char*, int, const char*, unsigned)>("renameat2");
  return below(to) && fails() ? -1 : next(fromFolder, from, toFolder, to, flags);
}

int mkdir(const char* path, mode_t mode) {
  static const auto next = real<int (*)(const char*, mode_t)>("mkdir");
  return below(path) && fails() ? -1 : next(path, mode);
}

int open(const char* path, int flags, ...) {
  static const auto next = real<int (*)(const char*, int, ...)>("open");
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  return (flags & O_CREAT) != 0 && below(path) && fails() ? -1 : next(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  static const auto next = real<int (*)(const char*, int, ...)>("open64");
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  return (flags & O_CREAT) != 0 && below(path) && fails() ? -1 : next(path, flags, mode);
}

int clock_gettime(clockid_t clock, timespec* time) {
  static const auto next = real<int (*)(clockid_t, timespec*)>("clock_gettime");
  const int status = next(clock, time);
  if (plan.fault == Fault::kClock && clock == CLOCK_REALTIME)
    time->tv_sec += ++clocks % 2 == 0 ? plan.number : -plan.number;
  return status;
}

void _exit(int code) {
  static const auto next = real<void (*)(int)>("_exit");
  tell();
  next(code);
  __builtin_unreachable();
}

}  // extern "C"

void* operator new(std::size_t size) {
  return allocate(size, 0);
}

void* operator new[](std::size_t size) {
  return allocate(size, 0);
}

void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}

void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}

void operator delete(void* memory) noexcept {
  std::free(memory);
}

void operator delete[](void* memory) noexcept {
  std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}

void operator delete[](void* memory, std::align_val_t) noexcept {
  std::free(memory);
}

void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
