// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/piped_input.hpp"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <span>

#include "volute/base/file_name.hpp"
#include "volute/base/input_file.hpp"

namespace volute::cli {
namespace {

using namespace std::string_view_literals;

constexpr std::size_t kHead = std::size_t{64} << 10;

/// The end of a file's name that says what its first bytes say; empty: none that lies in one file.
std::string_view kindOf(std::string_view head) {
  constexpr std::pair<std::string_view, std::string_view> kFirst[] = {
      {"\x89VLT"sv, ".volute"},       {"\x20\x42\x44\x56\0\0\0\0"sv, ".vdb"},
      {"NanoVDB"sv, ".nvdb"},         {"\x93NUMPY"sv, ".npy"},
      {"PK\x03\x04"sv, ".npz"},       {"\x89PNG"sv, ".png"},
      {"\x76\x2f\x31\x01"sv, ".exr"}, {"# vtk DataFile"sv, ".vtk"},
  };
  for (const auto& [first, kind] : kFirst) {
    if (head.starts_with(first))
      return kind;
  }
  const auto has = [&](std::string_view part) { return head.find(part) != head.npos; };
  const bool hdf = head.starts_with("\x89HDF"sv);
  if (hdf || head.starts_with("CDF"sv))
    return has("num_nod_per_el") || has("num_el_blk") ? ".e" : hdf ? ".h5" : ".nc";
  if (!has("<VTKFile"))
    return "";
  return has("\"ImageData\"") ? ".vti" : has("\"UnstructuredGrid\"") ? ".vtu" : "";
}

tl::unexpected<Error> unknownKind(std::string_view head) {
  const std::size_t first = head.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  if (head.empty())
    return fail(ErrorCode::kInvalidData, "standard input is empty");
  if (first != head.npos && (head[first] == '{' || head[first] == '[')) {
    return fail(ErrorCode::kUnsupported,
                "standard input is JSON, which names files beside it; give the name of a file");
  }
  return fail(ErrorCode::kUnsupported,
              "standard input is of no kind that is known by its first bytes and lies in one file; "
              "expected .volute, .vdb, .nvdb, .npy, .npz, .vti, .vtu, .vtk, .e, .nc, .h5, .png or "
              ".exr, or the name of a file");
}

bool isPipeName(std::string_view word) {
  return word == "/dev/stdin" || word.starts_with("/dev/fd/") || word.starts_with("/proc/self/fd/");
}

/// A descriptor that is closed at the end.
class Opened {
 public:
  explicit Opened(int descriptor) : descriptor_(descriptor) {}

  ~Opened() {
    if (descriptor_ >= 0)
      ::close(descriptor_);
  }

  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;

  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

tl::unexpected<Error> systemSays(const std::string& what) {
  return fail(ErrorCode::kIo, "standard input: {}: {}", what, std::strerror(errno));
}

/// Fills `block` as far as there is something; the number of bytes.
Result<std::size_t> readBlock(int from, std::span<char> block) {
  std::size_t filled = 0;
  while (filled < block.size()) {
    const ssize_t count = ::read(from, block.data() + filled, block.size() - filled);
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0)
      return systemSays("cannot be read");
    if (count == 0)
      break;
    filled += static_cast<std::size_t>(count);
  }
  return filled;
}

/// Where the folder of temporary files is memory, what is in it counts against the limit.
std::uint64_t allowedIn(const std::filesystem::path& folder, std::uint64_t maxMemory) {
  struct statfs of{};
  const bool memory = ::statfs(folder.c_str(), &of) == 0 && of.f_type == TMPFS_MAGIC;
  return memory ? maxMemory : std::numeric_limits<std::uint64_t>::max();
}

/// The rest of a pipe after its first bytes.
/// @return its bytes in all
Result<std::uint64_t> copyPipe(int from, std::span<char> block, std::size_t filled,
                               const std::filesystem::path& file, std::uint64_t most,
                               Progress& progress) {
  const Opened to(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (to.get() < 0)
    return systemSays("no place for it in " + file.parent_path().string());
  std::uint64_t size = 0;
  while (filled > 0) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped");
    size += filled;
    if (size > most) {
      return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                  "standard input: more than the {} MiB allowed, and {} is memory; let TMPDIR name "
                  "a folder on a disk",
                  most >> 20, file.parent_path().parent_path().string());
    }
    for (std::size_t done = 0; done < filled;) {
      const ssize_t count = ::write(to.get(), block.data() + done, filled - done);
      if (count < 0 && errno != EINTR)
        return systemSays("no place for it in " + file.parent_path().string());
      done += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
    }
    VOLUTE_ASSIGN(filled, readBlock(from, block));
  }
  return size;
}

}  // namespace

Result<std::string> PipedInputs::fileOf(const std::string& pipe, Context& context) {
  struct stat of{};
  if (::stat(pipe.c_str(), &of) != 0)
    return pipe;
  // `< file`: that file, under its own name.
  std::error_code error;
  const auto named = std::filesystem::canonical(pipe, error);
  if (S_ISREG(of.st_mode))
    return !error && isSameFile(named, pipe) ? named.string() : pipe;
  if (!S_ISFIFO(of.st_mode) && !S_ISSOCK(of.st_mode)) {
    return fail(ErrorCode::kIo,
                "standard input is a terminal or a device; expected a pipe, or a file's name");
  }
  const std::string_view number = std::string_view(pipe).substr(pipe.rfind('/') + 1);
  const int descriptor = pipe == "/dev/stdin" ? STDIN_FILENO : std::atoi(number.data());
  std::vector<char> block(std::size_t{1} << 20);
  VOLUTE_ASSIGN(const std::size_t first, readBlock(descriptor, block));
  const std::string_view head(block.data(), std::min(first, kHead));
  const std::string_view kind = kindOf(head);
  if (kind.empty())
    return unknownKind(head);
  if (!folder_)
    folder_.emplace();
  if (folder_->path().empty())
    return systemSays("no place for it in the folder of temporary files");
  // By the name of a part it is removed where the program is ended.
  const auto part =
      folder_->path() / fmt::format(".stdin.{}.{}.part{}", ::getpid(), taken_.size(), kind);
  Context::watch(part);
  VOLUTE_ASSIGN(const std::uint64_t size,
                copyPipe(descriptor, block, first, part,
                         allowedIn(folder_->path(), context.maxMemory), context.progress));
  const auto file = folder_->path() / fmt::format("stdin{}{}", taken_.size() > 1 ? "2" : "", kind);
  std::filesystem::create_symlink(part.filename(), file, error);
  if (error)
    return fail(ErrorCode::kIo, "{}: {}", file.string(), error.message());
  context.progress.remark(fmt::format("standard input: {} of {}, kept in {} until the end",
                                      bytesText(size), kind, folder_->path().string()));
  return file.string();
}

Status PipedInputs::take(const Command& command, Arguments& arguments, Context& context) {
  const auto once = [&](const std::string& pipe) -> Status {
    if (context.team.size() > 1) {
      return fail(ErrorCode::kUnsupported,
                  "standard input reaches one of {} processes; give the name of a file",
                  context.team.size());
    }
    if (std::ranges::find(taken_, pipe) != taken_.end())
      return fail(ErrorCode::kInvalidArgument,
                  "standard input can be read once; it is named twice");
    taken_.push_back(pipe);
    return {};
  };
  for (std::size_t i = 0; i < arguments.positionals().size(); ++i) {
    if (!command.positionals[std::min(i, command.positionals.size() - 1)].file)
      continue;
    const std::string& word = arguments.positional(i);
    const std::string pipe = word == "-" ? "/dev/stdin" : word;
    if (!isPipeName(pipe))
      continue;
    VOLUTE_TRY(once(pipe));
    VOLUTE_ASSIGN(std::string file, fileOf(pipe, context));
    arguments.setPositional(i, std::move(file));
  }
  for (const Option& option : command.options) {
    if (option.kind != ValueKind::kFile || option.several || option.name == "output")
      continue;
    auto file = arguments.findGiven<std::string>(option.name);
    if (!file || (*file != "-" && !isPipeName(*file)))
      continue;
    if (*file == "-") {
      file = "/dev/stdin";
      arguments.set(option.name, *file, true);
    }
    VOLUTE_TRY(once(*file));
    VOLUTE_TRY(InputFile::spool(*file));
  }
  return {};
}

}  // namespace volute::cli
