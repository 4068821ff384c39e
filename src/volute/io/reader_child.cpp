// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/reader_child.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <new>
#include <stdexcept>
#include <vector>

#include "volute/base/packed_error.hpp"
#include "volute/io/confinement.hpp"
#include "volute/io/reader_message.hpp"

// Sanitizers reserve terabytes of address space and look at files of the system: neither a limit on
// memory nor a filter lets them work.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define VOLUTE_UNCONFINED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define VOLUTE_UNCONFINED 1
#endif
#endif

namespace volute::detail {
namespace {

/// Where the child's descriptors lie, after those of standard input, output and error.
constexpr int kSocket = 3, kLifeline = 4, kShared = 5, kParameters = 6;

/// Moves what the child was given to where it is expected, and closes all else that it inherited.
void takeDescriptors(const ReaderLine& line) {
  constexpr int kAbove = kParameters + 1;  // out of the way of the four places
  int from[] = {line.socket, line.lifeline, line.shared, line.parameters};
  for (int& descriptor : from) {
    descriptor = ::fcntl(descriptor, F_DUPFD, kAbove);
    if (descriptor < 0)
      ::_exit(kNoDescriptors);
  }
  for (int i = 0; i < 4; ++i) ::dup2(from[i], kSocket + i);
  ::close_range(kParameters + 1, ~0U, 0);
  // Libraries' chatter would only confuse.
  if (const int null = ::open("/dev/null", O_RDWR); null >= 0) {
    for (int standard : {0, 1, 2}) ::dup2(null, standard);
    ::close(null);
  }
}

/// The system ends this process when the other end of the line closes, whatever it does then.
void endWithParent() {
  ::fcntl(kLifeline, F_SETOWN, ::getpid());
  ::fcntl(kLifeline, F_SETSIG, SIGKILL);
  ::fcntl(kLifeline, F_SETFL, O_ASYNC);
}

void takeSignals() {
  // Ctrl-C reaches the child too, but the parent decides.
  for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) ::signal(signal, SIG_IGN);
  for (int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU, SIGXFSZ})
    ::signal(signal, SIG_DFL);
}

void limitMemory([[maybe_unused]] std::uint64_t bytes) {
  const rlimit noCore{0, 0};
  ::setrlimit(RLIMIT_CORE, &noCore);
#ifndef VOLUTE_UNCONFINED
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

/// Memory shared with the parent, which makes it as large as it is wanted.
class SharedValues {
 public:
  /// Null when there are none.
  float* first(std::uint64_t count) {
    if (count > mapped_ / sizeof(float)) {
      if (memory_)
        ::munmap(memory_, mapped_);
      mapped_ = 0;
      memory_ =
          ::mmap(nullptr, count * sizeof(float), PROT_READ | PROT_WRITE, MAP_SHARED, kShared, 0);
      if (memory_ == MAP_FAILED) {
        memory_ = nullptr;
        throw std::bad_alloc();
      }
      mapped_ = count * sizeof(float);
    }
    return static_cast<float*>(memory_);
  }

 private:
  void* memory_ = nullptr;
  std::size_t mapped_ = 0;
};

/// The error of something that does not know the file; the parent adds it.
tl::unexpected<Error> withoutFile(tl::unexpected<Error> failed) {
  failed.value().statement = failed.value().message;
  return failed;
}

/// @param memory  bytes that it may take
template <class Function>
Result<std::string> guarded(std::uint64_t memory, Function&& function) {
  const auto tooLarge = [&] {
    return withoutFile(
        fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
             "reading it needs more than the {} MiB of memory allowed, or the file is damaged",
             memory >> 20));
  };
  try {
    return function();
  } catch (const std::bad_alloc&) {
    return tooLarge();
  } catch (const std::length_error&) {
    return tooLarge();
  } catch (const std::exception& error) {
    return withoutFile(fail(ErrorCode::kInvalidData, "{}", error.what()));
  }
}

[[noreturn]] void serveForever(const Result<ReaderJob::Serve>& serve, std::uint64_t memory) {
  SharedValues shared;
  ReaderHeader request;
  std::string text;
  while (receiveReaderMessage(kSocket, request, text)) {
    const auto result = guarded(memory, [&]() -> Result<std::string> {
      if (!serve)
        return tl::unexpected<Error>(serve.error());
      return (*serve)(text, {shared.first(request.valueCount), request.valueCount});
    });
    ReaderHeader reply;
    if (!result)
      reply.code = static_cast<std::int32_t>(result.error().code);
    if (!sendReaderMessage(kSocket, reply, result ? *result : packed(result.error())))
      break;
  }
  ::_exit(0);
}

struct Parameters {
  std::string text;
  std::vector<std::filesystem::path> readable;
};

/// As writeReaderParameters() wrote them: the text, then paths, each ended by a zero byte.
Parameters readParameters() {
  struct stat status{};
  ::fstat(kParameters, &status);
  std::string all(static_cast<std::size_t>(status.st_size), '\0');
  std::uint64_t length = 0;
  if (::pread(kParameters, &length, sizeof length, 0) != sizeof length ||
      ::pread(kParameters, all.data(), all.size(), sizeof length) < 0)
    ::_exit(1);
  ::close(kParameters);
  Parameters parameters;
  parameters.text = all.substr(0, length);
  for (std::size_t at = length; at + sizeof length < all.size();) {
    const std::string path = all.c_str() + at;
    at += path.size() + 1;
    parameters.readable.emplace_back(path);
  }
  return parameters;
}

}  // namespace

int writeReaderParameters(const ReaderJob& job) {
  std::string all = toMessage(static_cast<std::uint64_t>(job.parameters.size())) + job.parameters;
  for (const auto& path : job.readable) all += path.string() + '\0';
  const int file = ::memfd_create("volute-parameters", MFD_CLOEXEC);
  std::string_view rest = all;
  while (file >= 0 && !rest.empty()) {
    const ssize_t written = ::write(file, rest.data(), rest.size());
    if (written <= 0) {
      ::close(file);
      return -1;
    }
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  return file;
}

void serveAsReader(ReaderJob::Make make, const ReaderLine& line) {
  takeSignals();
  takeDescriptors(line);
  endWithParent();
  limitMemory(line.memory);
  const Parameters parameters = readParameters();
  Result<ReaderJob::Serve> serve = withoutFile(fail(ErrorCode::kIo, "nothing reads it"));
  const auto made = guarded(line.memory, [&]() -> Result<std::string> {
    serve = make(parameters.text);
    if (!serve)
      serve = withoutFile(tl::unexpected<Error>(serve.error()));
    return std::string();
  });
  if (!made)
    serve = tl::unexpected<Error>(made.error());
#ifndef VOLUTE_UNCONFINED
  if (!confineThisProcess({parameters.readable, kSocket, kLifeline, kShared})) {
    serve = withoutFile(
        fail(ErrorCode::kUnsupported,
             "the process that reads it cannot be confined: this kernel refuses a filter of "
             "system calls"));
  }
#endif
  serveForever(serve, line.memory);
}

void serveUnconfined(const ReaderJob::Serve& serve, const ReaderLine& line) {
  takeSignals();
  takeDescriptors(line);
  endWithParent();
  limitMemory(line.memory);
  serveForever(serve, line.memory);
}

}  // namespace volute::detail
