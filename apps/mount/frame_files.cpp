// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "frame_files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "volute/base/file_name.hpp"
#include "volute/codec/extract_source.hpp"
#include "volute/codec/kept_grids.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/lattice_sink.hpp"
#include "volute/io/plugin.hpp"

namespace volute {

Result<MemoryFile> MemoryFile::create(const std::string& name) {
  const int descriptor = ::memfd_create(name.c_str(), MFD_CLOEXEC);
  if (descriptor < 0)
    return fail(ErrorCode::kIo, "{}: cannot make a file in memory: {}", name, std::strerror(errno));
  return MemoryFile(descriptor);
}

MemoryFile::~MemoryFile() {
  if (descriptor_ >= 0)
    ::close(descriptor_);
}

MemoryFile::MemoryFile(MemoryFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

std::string MemoryFile::path() const {
  return fmt::format("/proc/self/fd/{}", descriptor_);
}

Result<std::uint64_t> MemoryFile::size() const {
  struct stat status{};
  if (::fstat(descriptor_, &status) != 0)
    return fail(ErrorCode::kIo, "a file in memory: {}", std::strerror(errno));
  return static_cast<std::uint64_t>(status.st_size);
}

long MemoryFile::read(char* to, std::size_t count, std::uint64_t offset) const {
  std::size_t done = 0;
  while (done < count) {
    const ssize_t now =
        ::pread(descriptor_, to + done, count - done, static_cast<off_t>(offset + done));
    if (now < 0 && errno == EINTR)
      continue;
    if (now < 0)
      return -errno;
    if (now == 0)
      break;
    done += static_cast<std::size_t>(now);
  }
  return static_cast<long>(done);
}

namespace {

/// Numbers as the .vdb files have them that the file was made of, else of four digits.
std::string numberField(const std::string& provenance) {
  const auto field = findFrameField(provenance);
  if (extensionOf(provenance) != ".vdb" || !field || !*field || (*field)->anyWidth)
    return "%04d";
  return (*field)->width > 1 ? fmt::format("%0{}d", (*field)->width) : "%d";
}

}  // namespace

Result<std::unique_ptr<FrameFiles>> FrameFiles::open(const std::string& path,
                                                     const std::optional<double>& rate,
                                                     std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(const LatticePlugin* plugin, loadVdbPlugin());
  auto files = std::unique_ptr<FrameFiles>(new FrameFiles(maxMemory));
  VOLUTE_TRY(files->openGrids(path, rate));
  std::string stem = std::filesystem::path(path).stem().string();
  std::ranges::replace_if(stem, [](char c) { return c == '%' || c == '#'; }, '_');
  VOLUTE_ASSIGN(
      const auto pattern,
      FramePattern::parse(stem + "_" + numberField(files->whole_->header().provenance) + ".vdb"));
  for (const auto& name : framePaths(pattern, files->info(), files->fileMetadata_))
    files->names_.push_back(name.string());
  files->writer_ =
      plugin->makeWriter({.offset = files->plain_ ? files->volumes_.front().offset : 0});
  files->sizes_.resize(files->names_.size());
  return files;
}

Status FrameFiles::openGrids(const std::string& path, const std::optional<double>& rate) {
  VOLUTE_ASSIGN(auto opened, VoluteReader::open(path, {.maxMemory = maxMemory_}));
  whole_ = std::make_unique<VoluteReader>(std::move(opened));
  const VoluteReader& whole = *whole_;
  frames_ = whole.info();
  if (rate)
    frames_.setRate(*rate);
  fileMetadata_ = whole.fileMetadata();
  plain_ = whole.grids().size() == 1 && !whole.grid().empty && !whole.grid().description &&
           whole.kept().grids.empty();
  std::uint64_t frameBytes = 0;
  for (const VoluteGrid& grid : whole.grids()) {
    Volume& volume = volumes_.emplace_back();
    volume.info = grid.info;
    volume.description = grid.description.value_or(GridDescription{
        .type = grid.info.channels == 3 ? "vec3s" : "float", .gridClass = "fog volume"});
    if (grid.empty)
      continue;
    // Each grid keeps the row of frames that was decoded last.
    const std::uint64_t room = maxMemory_ / 2 / whole.grids().size();
    VOLUTE_ASSIGN(auto reader, VoluteReader::open(path, {.maxMemory = room,
                                                         .grid = grid.info.name,
                                                         .differences = Offsets::kOfRounded}));
    const auto shared = std::make_shared<const VoluteReader>(std::move(reader));
    volume.source = withLevelSet(*shared, frameSource(shared));
    volume.info = volume.source->info();
    volume.offset = shared->offset();
    if (volume.offset != 0)
      volume.description.type = grid.info.channels == 3 ? "vec3d" : "double";
    frameBytes += volume.source->brickBytes();
  }
  for (Volume& volume : volumes_) volume.info.times = frames_.times;
  if (frameBytes > maxMemory_ / 4) {
    return fail(
        ErrorCode::kTooLarge,
        "{}: a frame takes {} MiB, more than a quarter of the {} MiB allowed; raise --max-memory",
        path, (frameBytes >> 20) + 1, maxMemory_ >> 20);
  }
  return {};
}

std::optional<std::size_t> FrameFiles::find(std::string_view name) const {
  const auto found = std::ranges::find(names_, name);
  if (found == names_.end())
    return std::nullopt;
  return static_cast<std::size_t>(found - names_.begin());
}

Result<std::uint64_t> FrameFiles::size(std::size_t frame) {
  {
    const std::lock_guard lock(keeping_);
    if (sizes_[frame] != 0)
      return sizes_[frame];
  }
  VOLUTE_ASSIGN(const auto made, file(frame));
  return made->size;
}

Result<std::shared_ptr<const FrameFiles::File>> FrameFiles::file(std::size_t frame) {
  if (auto found = kept(frame))
    return found;
  const std::lock_guard lock(making_);
  if (auto found = kept(frame))  // somebody else wanted it
    return found;
  VOLUTE_ASSIGN(auto made, make(frame));
  keep(frame, made);
  return made;
}

std::shared_ptr<const FrameFiles::File> FrameFiles::kept(std::size_t frame) {
  const std::lock_guard lock(keeping_);
  const auto found =
      std::ranges::find(files_, frame, [](const auto& entry) { return entry.first; });
  if (found == files_.end())
    return nullptr;
  files_.splice(files_.begin(), files_, found);
  return files_.front().second;
}

void FrameFiles::keep(std::size_t frame, std::shared_ptr<const File> file) {
  const std::lock_guard lock(keeping_);
  sizes_[frame] = file->size;
  files_.emplace_front(frame, std::move(file));
  std::uint64_t sum = 0;
  for (auto it = files_.begin(); it != files_.end();) {
    sum += it->second->size;
    it = it != files_.begin() && sum > maxMemory_ / 4 ? files_.erase(it) : std::next(it);
  }
}

Result<std::shared_ptr<const FrameFiles::File>> FrameFiles::make(std::size_t frame) {
  for (Volume& volume : volumes_) {
    if (volume.source)
      VOLUTE_TRY(volume.source->readBricks(static_cast<int>(frame), volume.bricks));
  }
  VOLUTE_ASSIGN(auto memory, MemoryFile::create(names_[frame]));
  auto made = std::make_shared<File>(std::move(memory));
  VOLUTE_TRY(writeFrame(made->bytes.path(), frame));
  VOLUTE_ASSIGN(made->size, made->bytes.size());
  return made;
}

Status FrameFiles::writeFrame(const std::string& file, std::size_t frame) {
  const auto position = static_cast<int>(frame);
  if (plain_)
    return writer_->writeBricks(file, names_[frame], info(), position, volumes_.front().bricks);
  std::vector<GridFrame> grids;
  std::vector<std::unique_ptr<KeptBytes>> kept;
  const auto addKept = [&](auto belongs) {
    for (std::size_t k = 0; k < whole_->kept().grids.size(); ++k) {
      if (!belongs(whole_->kept().grids[k].place))
        continue;
      kept.push_back(whole_->keptBytes(k, position));
      if (kept.back())
        grids.push_back({.kept = kept.back().get()});
    }
  };
  for (std::size_t i = 0; i < volumes_.size(); ++i) {
    const Volume& volume = volumes_[i];
    addKept([&](std::size_t place) { return place == i; });
    // A cache that has a list of metadata for some frames lacks the grid in the others.
    const FrameMetadata& metadata = volume.description.metadata;
    if (metadata.listOf.empty() || metadata.at(position))
      grids.push_back(
          {&volume.info, &volume.description, position, &volume.bricks, nullptr, volume.offset});
  }
  addKept([&](std::size_t place) { return place >= volumes_.size(); });
  return writer_->writeGrids(file, names_[frame], grids, fileMetadata_.at(position));
}

}  // namespace volute
