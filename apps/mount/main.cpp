// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What `volute mount` runs; the command's options are declared in volute/cli/commands/mount.cpp.
#define FUSE_USE_VERSION 31
#include <fcntl.h>
#include <fuse.h>
#include <fuse_lowlevel.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include "frame_files.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/program.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute::cli {
namespace {

/// What the functions below see of the program.
struct Mounted {
  std::unique_ptr<FrameFiles> files;
  timespec changed{};  ///< of the .volute file
  Progress* progress = nullptr;
  std::mutex remarking;

  /// -errno, and the sentence for whoever looks at the terminal.
  int failed(const Error& error) {
    const std::lock_guard lock(remarking);
    progress->remark(error.message);
    return error.code == ErrorCode::kTooLarge ? -ENOMEM : -EIO;
  }
};

Mounted& mounted() {
  return *static_cast<Mounted*>(fuse_get_context()->private_data);
}

using Open = std::shared_ptr<const FrameFiles::File>;

std::optional<std::size_t> frameOf(const char* path) {
  return mounted().files->find(path + 1);
}

void* begin(fuse_conn_info* connection, fuse_config* config) {
  // Sizes of files that nobody opens are not asked for: they cost a frame.
  connection->want &= ~static_cast<unsigned>(FUSE_CAP_READDIRPLUS);
  config->kernel_cache = 1;
  constexpr double kForever = 1e6;  // [s]; nothing changes
  config->entry_timeout = config->attr_timeout = config->negative_timeout = kForever;
  return fuse_get_context()->private_data;
}

int attributes(const char* path, struct stat* status, fuse_file_info* /*open*/) {
  *status = {};
  status->st_uid = ::getuid();
  status->st_gid = ::getgid();
  status->st_mtim = status->st_ctim = status->st_atim = mounted().changed;
  if (std::strcmp(path, "/") == 0) {
    status->st_mode = S_IFDIR | 0555;
    status->st_nlink = 2;
    return 0;
  }
  const auto frame = frameOf(path);
  if (!frame)
    return -ENOENT;
  const auto size = mounted().files->size(*frame);
  if (!size)
    return mounted().failed(size.error());
  status->st_mode = S_IFREG | 0444;
  status->st_nlink = 1;
  status->st_size = static_cast<off_t>(*size);
  return 0;
}

int list(const char* path, void* buffer, fuse_fill_dir_t fill, off_t /*offset*/,
         fuse_file_info* /*open*/, fuse_readdir_flags /*flags*/) {
  if (std::strcmp(path, "/") != 0)
    return -ENOENT;
  constexpr auto kPlain = static_cast<fuse_fill_dir_flags>(0);
  fill(buffer, ".", nullptr, 0, kPlain);
  fill(buffer, "..", nullptr, 0, kPlain);
  for (const auto& name : mounted().files->names()) fill(buffer, name.c_str(), nullptr, 0, kPlain);
  return 0;
}

int open(const char* path, fuse_file_info* info) {
  const auto frame = frameOf(path);
  if (!frame)
    return -ENOENT;
  if ((info->flags & O_ACCMODE) != O_RDONLY)
    return -EROFS;
  auto file = mounted().files->file(*frame);
  if (!file)
    return mounted().failed(file.error());
  info->fh = reinterpret_cast<std::uintptr_t>(new Open(std::move(*file)));
  info->keep_cache = 1;
  return 0;
}

int read(const char* /*path*/, char* to, std::size_t count, off_t offset, fuse_file_info* info) {
  const Open& file = *reinterpret_cast<Open*>(info->fh);
  return static_cast<int>(file->bytes.read(to, count, static_cast<std::uint64_t>(offset)));
}

int release(const char* /*path*/, fuse_file_info* info) {
  delete reinterpret_cast<Open*>(info->fh);
  return 0;
}

/// What libfuse has to say, for the error.
std::string fuseSays;

void hear(fuse_log_level /*level*/, const char* format, va_list arguments) {
  std::array<char, 512> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  if (!fuseSays.empty())
    fuseSays += "; ";
  fuseSays += text.data();
  while (!fuseSays.empty() && fuseSays.back() == '\n') fuseSays.pop_back();
}

constexpr std::string_view kOtherwise =
    "`volute extract FILE -o FOLDER/frame_%04d.vdb` writes the files instead";

Status checkFuse() {
  if (::access("/dev/fuse", R_OK | W_OK) == 0)
    return {};
  if (errno == ENOENT) {
    return fail(
        ErrorCode::kUnsupported,
        "/dev/fuse is not there: this system has no FUSE, or this container was not given it "
        "(modprobe fuse; --device /dev/fuse); {}",
        kOtherwise);
  }
  return fail(ErrorCode::kUnsupported, "/dev/fuse: {}; {}", std::strerror(errno), kOtherwise);
}

Status checkFolder(const std::string& folder) {
  std::error_code error;
  const bool is = std::filesystem::is_directory(folder, error);
  const bool empty = is && std::filesystem::is_empty(folder, error);
  if (error.value() == ENOTCONN) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: what was mounted here was killed; fusermount3 -u {} lets it go", folder,
                folder);
  }
  if (!is)
    return fail(ErrorCode::kInvalidArgument, "{}: is no folder; expected an empty one", folder);
  if (error)
    return fail(ErrorCode::kIo, "{}: {}", folder, error.message());
  if (!empty) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: is not empty, and what is in it would be hidden; expected an empty folder",
                folder);
  }
  return {};
}

/// A mounted folder; it is let go of when this ends.
class Session {
 public:
  Status begin(Mounted& what, const std::string& folder) {
    fuse_set_log_func(hear);
    std::vector<std::string> words{
        "volute", "-o", "ro,auto_unmount,nosuid,nodev,noatime,subtype=volute,fsname=volute"};
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    fuse_args arguments = FUSE_ARGS_INIT(static_cast<int>(pointers.size()), pointers.data());
    fuse_operations operations{};
    operations.init = volute::cli::begin;
    operations.getattr = attributes;
    operations.readdir = list;
    operations.open = open;
    operations.read = read;
    operations.release = release;
    fuse_ = fuse_new(&arguments, &operations, sizeof operations, &what);
    fuse_opt_free_args(&arguments);
    if (!fuse_ || fuse_mount(fuse_, folder.c_str()) != 0) {
      return fail(
          ErrorCode::kUnsupported, "{}: cannot mount: {}; {}", folder,
          fuseSays.empty() ? "FUSE refused (is fusermount3 of the package fuse3 there?)" : fuseSays,
          kOtherwise);
    }
    mounted_ = true;
    return {};
  }

  /// Until somebody unmounts the folder or asks to stop. libfuse's own loop would wait for one more
  /// request.
  Status serve(const Progress& progress) {
    fuse_session* session = fuse_get_session(fuse_);
    const int device = fuse_session_fd(session);
    ::fcntl(device, F_SETFL, ::fcntl(device, F_GETFL) | O_NONBLOCK);
    std::vector<std::thread> servers;
    constexpr int kServers = 4;
    for (int i = 0; i < kServers; ++i) {
      servers.emplace_back([&] {
        fuse_buf buffer{};
        while (!fuse_session_exited(session) && !progress.cancelled()) {
          constexpr int kPatience = 100;  // [ms]
          pollfd ready{device, POLLIN, 0};
          if (::poll(&ready, 1, kPatience) <= 0)
            continue;
          const int received = fuse_session_receive_buf(session, &buffer);
          if (received > 0) {
            fuse_session_process_buf(session, &buffer);
          } else if (received == 0 ||
                     (received != -EAGAIN && received != -EINTR && received != -ENOENT)) {
            fuse_session_exit(session);
          }
        }
        std::free(buffer.mem);
      });
    }
    for (std::thread& server : servers) server.join();
    return {};
  }

  ~Session() {
    if (mounted_)
      fuse_unmount(fuse_);
    if (fuse_)
      fuse_destroy(fuse_);
  }

 private:
  fuse* fuse_ = nullptr;
  bool mounted_ = false;
};

Status run(const Arguments& arguments, Context& context) {
  const std::string& path = arguments.positional(0);
  const std::string& folder = arguments.positional(1);
  if (!isVolutePath(path))
    return fail(ErrorCode::kInvalidArgument,
                "'{}' does not end in .volute; 'mount' shows such files alone", path);
  VOLUTE_TRY(checkFolder(folder));
  Mounted what;
  what.progress = &context.progress;
  VOLUTE_ASSIGN(what.files,
                FrameFiles::open(path, arguments.find<double>("fps"), context.maxMemory));
  VOLUTE_TRY(checkFuse());
  struct stat status{};
  if (::stat(path.c_str(), &status) == 0)
    what.changed = status.st_mtim;
  Session session;
  VOLUTE_TRY(session.begin(what, folder));
  const auto& names = what.files->names();
  context.progress.remark(fmt::format("{}/{}{}; Ctrl-C, or fusermount3 -u {}, ends it", folder,
                                      names.front(), names.size() > 1 ? " to " + names.back() : "",
                                      folder));
  return session.serve(context.progress);
}

}  // namespace
}  // namespace volute::cli

int main(int argc, char** argv) {
  volute::cli::Command command = volute::cli::mountCommand();
  command.run = volute::cli::run;
  return volute::cli::runProgram(command, argc, argv);
}
