// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/confinement.hpp"

#include <fcntl.h>
#include <linux/capability.h>
#include <linux/landlock.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>

#if VOLUTE_HAS_SECCOMP
#include <seccomp.h>
#endif

namespace volute::detail {
namespace {

/// The version of Landlock's interface, at most 0 without it.
int landlockVersion() {
  return static_cast<int>(
      ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION));
}

/// What the kernel knows to refuse about files: 13 kinds of access at first, later versions one
/// more each.
std::uint64_t fileAccesses(int version) {
  constexpr int kKinds[] = {13, 14, 15, 15, 16};
  return (std::uint64_t{1} << kKinds[std::min(version, 5) - 1]) - 1;
}

/// Refuses all files but `readable`, where the kernel can.
/// @param rights  to each of them, besides reading
bool confineFiles(std::span<const std::filesystem::path> readable, std::uint64_t rights = 0) {
  const int version = landlockVersion();
  if (version < 1)
    return true;
  landlock_ruleset_attr attributes{};
  attributes.handled_access_fs = fileAccesses(version);
  const int rules = static_cast<int>(
      ::syscall(SYS_landlock_create_ruleset, &attributes, sizeof attributes.handled_access_fs, 0));
  if (rules < 0)
    return false;
  for (const auto& path : readable) {
    // Without the right to read a folder its files may still be open to us.
    const int place = ::open(path.c_str(), O_PATH | O_CLOEXEC);
    struct stat status{};
    if (place < 0 || ::fstat(place, &status) != 0)
      continue;  // whoever reads it will say that it is not there
    landlock_path_beneath_attr rule{};
    rule.allowed_access = LANDLOCK_ACCESS_FS_READ_FILE | rights;
    if (S_ISDIR(status.st_mode))
      rule.allowed_access |= LANDLOCK_ACCESS_FS_READ_DIR;
    rule.parent_fd = place;
    const bool added =
        ::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) == 0;
    ::close(place);
    if (!added)
      return false;
  }
  const bool confined = ::syscall(SYS_landlock_restrict_self, rules, 0) == 0;
  ::close(rules);
  return confined;
}

/// All but the right to read what belongs to others, without which root could not read the files of
/// users; that what may be read is little is Landlock's part.
void dropCapabilities() {
  constexpr std::uint32_t kKept = (1U << CAP_DAC_OVERRIDE) | (1U << CAP_DAC_READ_SEARCH);
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct data[2] = {};
  if (::syscall(SYS_capget, &header, data) != 0)
    return;
  for (auto& part : data) {
    const std::uint32_t kept = &part == data ? kKept : 0;
    part.effective &= kept;
    part.permitted &= kept;
    part.inheritable = 0;
  }
  ::syscall(SYS_capset, &header, data);
}

#if VOLUTE_HAS_SECCOMP
/// Every `call` is allowed where all conditions hold.
class SyscallFilter {
 public:
  explicit SyscallFilter(std::uint32_t others = SCMP_ACT_ERRNO(EPERM))
      : context_(::seccomp_init(others)) {}

  ~SyscallFilter() { ::seccomp_release(context_); }

  SyscallFilter(const SyscallFilter&) = delete;
  SyscallFilter& operator=(const SyscallFilter&) = delete;

  template <class... Conditions>
  void allow(int call, Conditions... conditions) {
    add(SCMP_ACT_ALLOW, call, conditions...);
  }

  template <class... Conditions>
  void add(std::uint32_t action, int call, Conditions... conditions) {
    // What another architecture has and this one has not is negative.
    if (call < 0)
      return;
    good_ = good_ &&
            ::seccomp_rule_add(context_, action, call, sizeof...(conditions), conditions...) == 0;
  }

  bool load() {
    ::seccomp_attr_set(context_, SCMP_FLTATR_CTL_NNP, 1);
    return good_ && ::seccomp_load(context_) == 0;
  }

 private:
  scmp_filter_ctx context_;
  bool good_ = true;
};

constexpr int kFree[] = {
    // files that are open, and what there is
    SCMP_SYS(read), SCMP_SYS(readv), SCMP_SYS(pread64), SCMP_SYS(preadv), SCMP_SYS(lseek),
    SCMP_SYS(fstat), SCMP_SYS(stat), SCMP_SYS(lstat), SCMP_SYS(newfstatat), SCMP_SYS(statx),
    SCMP_SYS(statfs), SCMP_SYS(fstatfs), SCMP_SYS(access), SCMP_SYS(faccessat),
    SCMP_SYS(faccessat2), SCMP_SYS(readlink), SCMP_SYS(readlinkat), SCMP_SYS(getdents64),
    SCMP_SYS(getcwd), SCMP_SYS(fadvise64), SCMP_SYS(flock),
    // memory
    SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(madvise), SCMP_SYS(brk), SCMP_SYS(membarrier),
    // threads
    SCMP_SYS(futex), SCMP_SYS(set_robust_list), SCMP_SYS(get_robust_list), SCMP_SYS(rseq),
    SCMP_SYS(set_tid_address), SCMP_SYS(sched_yield), SCMP_SYS(sched_getaffinity),
    SCMP_SYS(sched_getparam), SCMP_SYS(sched_getscheduler), SCMP_SYS(sched_get_priority_max),
    SCMP_SYS(sched_get_priority_min), SCMP_SYS(getcpu),
    // time and chance
    SCMP_SYS(nanosleep), SCMP_SYS(clock_nanosleep), SCMP_SYS(clock_gettime), SCMP_SYS(clock_getres),
    SCMP_SYS(gettimeofday), SCMP_SYS(time), SCMP_SYS(times), SCMP_SYS(getrandom),
    // signals to itself
    SCMP_SYS(rt_sigaction), SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigreturn), SCMP_SYS(sigaltstack),
    SCMP_SYS(restart_syscall),
    // about itself
    SCMP_SYS(getpid), SCMP_SYS(gettid), SCMP_SYS(getppid), SCMP_SYS(getuid), SCMP_SYS(geteuid),
    SCMP_SYS(getgid), SCMP_SYS(getegid), SCMP_SYS(getrlimit), SCMP_SYS(getrusage),
    SCMP_SYS(sysinfo), SCMP_SYS(uname), SCMP_SYS(exit), SCMP_SYS(exit_group)};

bool confineCalls(const Confinement& keep) {
  SyscallFilter filter;
  for (const int call : kFree) filter.allow(call);
  // Opening is for reading.
  constexpr scmp_datum_t kWrites = O_ACCMODE | O_CREAT | O_TRUNC;
  filter.allow(SCMP_SYS(open), SCMP_A1(SCMP_CMP_MASKED_EQ, kWrites, O_RDONLY));
  filter.allow(SCMP_SYS(openat), SCMP_A2(SCMP_CMP_MASKED_EQ, kWrites, O_RDONLY));
  filter.allow(SCMP_SYS(close), SCMP_A0(SCMP_CMP_NE, static_cast<scmp_datum_t>(keep.lifeline)));
  // Memory is of this process alone, but for what was given to it, and never becomes code.
  constexpr scmp_datum_t kType = MAP_SHARED | MAP_PRIVATE;
  const auto shared = static_cast<scmp_datum_t>(keep.shared);
  filter.allow(SCMP_SYS(mmap), SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0),
               SCMP_A3(SCMP_CMP_MASKED_EQ, kType, MAP_PRIVATE));
  filter.allow(SCMP_SYS(mmap), SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0),
               SCMP_A3(SCMP_CMP_MASKED_EQ, kType | MAP_ANONYMOUS, MAP_SHARED),
               SCMP_A4(SCMP_CMP_EQ, shared));
  filter.allow(SCMP_SYS(mprotect), SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
  // Threads, no processes. Flags of clone3 are in memory, where a filter does not see them: glibc
  // takes clone where there is no clone3.
  filter.allow(SCMP_SYS(clone), SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, CLONE_THREAD));
  filter.add(SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3));
  filter.allow(SCMP_SYS(tgkill), SCMP_A0(SCMP_CMP_EQ, static_cast<scmp_datum_t>(::getpid())));
  filter.allow(SCMP_SYS(prctl), SCMP_A0(SCMP_CMP_EQ, PR_SET_NAME));
  filter.allow(SCMP_SYS(prlimit64), SCMP_A2(SCMP_CMP_EQ, 0));
  for (const int command : {F_GETFD, F_SETFD, F_GETFL})
    filter.allow(SCMP_SYS(fcntl), SCMP_A1(SCMP_CMP_EQ, static_cast<scmp_datum_t>(command)));
  // Messages go to whoever asks; standard output and error are /dev/null.
  const auto socket = static_cast<scmp_datum_t>(keep.socket);
  filter.allow(SCMP_SYS(sendmsg), SCMP_A0(SCMP_CMP_EQ, socket));
  filter.allow(SCMP_SYS(recvmsg), SCMP_A0(SCMP_CMP_EQ, socket));
  for (const int call : {SCMP_SYS(write), SCMP_SYS(writev)})
    filter.allow(call, SCMP_A0(SCMP_CMP_LE, STDERR_FILENO));
  return filter.load();
}

/// A program may do what it likes with what it has, and reach nobody.
bool refuseConnections() {
  SyscallFilter filter(SCMP_ACT_ALLOW);
  for (const int call : {SCMP_SYS(socket), SCMP_SYS(socketpair), SCMP_SYS(connect), SCMP_SYS(bind),
                         SCMP_SYS(ptrace), SCMP_SYS(process_vm_readv), SCMP_SYS(process_vm_writev),
                         SCMP_SYS(kill), SCMP_SYS(io_uring_setup)})
    filter.add(SCMP_ACT_ERRNO(EPERM), call);
  return filter.load();
}
#else
// This build has no plug-in that reads, so none gets here but a test's.
bool confineCalls(const Confinement&) {
  return true;
}

bool refuseConnections() {
  return true;
}
#endif

}  // namespace

bool readingIsConfined() {
  return landlockVersion() >= 1;
}

bool confineThisProcess(const Confinement& keep) {
  const rlimit none{0, 0}, few{256, 256};
  ::setrlimit(RLIMIT_FSIZE, &none);
  ::setrlimit(RLIMIT_NOFILE, &few);
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
    return false;
  const bool files = confineFiles(keep.readable);
  dropCapabilities();
  return files && confineCalls(keep);
}

bool confineProgram(std::span<const std::filesystem::path> folders) {
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
    return false;
  return confineFiles(folders, LANDLOCK_ACCESS_FS_EXECUTE) && refuseConnections();
}

}  // namespace volute::detail
