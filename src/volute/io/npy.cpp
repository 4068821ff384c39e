// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/npy.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include "volute/base/assert.hpp"
#include "volute/base/half.hpp"
#include "volute/base/input_file.hpp"
#include "volute/io/npy_header.hpp"

namespace volute {
namespace {

/// Extents to axes, and whether the file is as long as they say.
Result<VolumeInfo> toInfo(const NpyHeader& header, const InputFile& file,
                          const SourceOptions& options) {
  const std::string where = file.path().string();
  std::vector<std::uint64_t> shape = header.shape;
  if (shape.size() < 3 || shape.size() > 5) {
    return fail(ErrorCode::kInvalidData,
                "{}: an array with {} axes; expected (z,y,x), (t,z,y,x) or (t,z,y,x,c)", where,
                shape.size());
  }
  if (shape.size() == 3)
    shape.insert(shape.begin(), 1);
  if (shape.size() == 4)
    shape.push_back(1);
  constexpr std::uint64_t kMax = std::numeric_limits<std::int32_t>::max();
  std::uint64_t bytes = header.half ? 2 : 4;
  bool possible = true;
  for (std::uint64_t extent : shape) {
    possible = possible && extent <= kMax && !__builtin_mul_overflow(bytes, extent, &bytes);
  }
  const std::uint64_t present = file.size() - header.dataOffset;
  if (!possible || bytes != present) {
    const bool shorter = !possible || bytes > present;
    return fail(shorter ? ErrorCode::kTruncated : ErrorCode::kInvalidData,
                "{}: holds {} bytes of values, {} than its header says; the file is damaged", where,
                present, shorter ? "fewer" : "more");
  }
  VolumeInfo info;
  info.frames = static_cast<int>(shape[0]);
  info.z = static_cast<int>(shape[1]);
  info.y = static_cast<int>(shape[2]);
  info.x = static_cast<int>(shape[3]);
  info.channels = static_cast<int>(shape[4]);
  constexpr std::uint64_t kPerFrame = sizeof(int) + sizeof(double);
  if ((!options.byLayers && 4 * info.frameValues() > options.maxMemory) ||
      info.frames * kPerFrame > options.maxMemory) {
    return fail(
        ErrorCode::kTooLarge,
        "{}: a frame of {} x {} x {} voxels needs more than the {} MiB allowed; raise --max-memory",
        where, info.x, info.y, info.z, options.maxMemory >> 20);
  }
  if (options.bounds)
    info.bounds = *options.bounds;
  if (options.bounds && options.bounds->empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: the given bounds are empty; expected min < max on every axis", where);
  }
  info.fillDefaults();
  VOLUTE_TRY(info.validate(where));
  return info;
}

class NpySource final : public FrameSource {
 public:
  NpySource(InputFile file, const NpyHeader& header, VolumeInfo info)
      : file_(std::move(file)), header_(header), info_(std::move(info)) {}

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int index, std::span<float> values) override {
    return readLayers(index, 0, info_.z, values);
  }

  bool readsLayers() const override { return true; }

  Status readLayers(int index, int first, [[maybe_unused]] int end,
                    std::span<float> values) override {
    const std::uint64_t layer = info_.frameValues() / static_cast<std::uint64_t>(info_.z);
    VOLUTE_ASSERT(values.size() == layer * static_cast<std::uint64_t>(end - first));
    const std::uint64_t size = header_.half ? sizeof(Half) : sizeof(float);
    const std::uint64_t bytes = values.size() * size;
    const std::uint64_t offset =
        header_.dataOffset +
        size * (info_.frameValues() * static_cast<std::uint64_t>(index) + layer * first);
    if (!header_.half)
      return file_.read(offset, std::as_writable_bytes(values));
    // The halves go into the upper part of the floats' own memory; each is read before its place is
    // overwritten.
    auto* halves = reinterpret_cast<std::byte*>(values.data()) + bytes;
    VOLUTE_TRY(file_.read(offset, {halves, bytes}));
    for (std::size_t i = 0; i < values.size(); ++i) {
      Half half;
      std::memcpy(&half, halves + i * sizeof half, sizeof half);
      values[i] = toFloat(half);
    }
    return {};
  }

 private:
  InputFile file_;
  NpyHeader header_;
  VolumeInfo info_;
};

/// A file is open while its frame is read.
class NpySequence final : public FrameSource {
 public:
  NpySequence(std::vector<NumberedFile> files, SourceOptions options, VolumeInfo info)
      : files_(std::move(files)), options_(std::move(options)), info_(std::move(info)) {}

  const VolumeInfo& info() const override { return info_; }

  bool readsLayers() const override { return true; }

  Status readFrame(int index, std::span<float> values) override {
    return readLayers(index, 0, info_.z, values);
  }

  Status readLayers(int index, int first, [[maybe_unused]] int end,
                    std::span<float> values) override {
    const auto& path = files_[static_cast<std::size_t>(index)].path;
    VOLUTE_ASSIGN(const auto file, openNpy(path, options_));
    VOLUTE_TRY(checkSame(file->info(), path));
    return file->readLayers(0, first, end, values);
  }

  /// One frame, and as large as the first file's.
  Status checkSame(const VolumeInfo& one, const std::filesystem::path& path) const {
    if (one.frames == 1 && one.x == info_.x && one.y == info_.y && one.z == info_.z &&
        one.channels == info_.channels)
      return {};
    return fail(
        ErrorCode::kInvalidData,
        "{}: holds {} frame{} of {} x {} x {} voxels with {} channel{}; expected one of {} x {} "
        "x {} with {}, as {} has",
        path.string(), one.frames, one.frames == 1 ? "" : "s", one.x, one.y, one.z, one.channels,
        one.channels == 1 ? "" : "s", info_.x, info_.y, info_.z, info_.channels,
        files_.front().path.filename().string());
  }

 private:
  std::vector<NumberedFile> files_;
  SourceOptions options_;
  VolumeInfo info_;
};

}  // namespace

Result<std::unique_ptr<FrameSource>> openNpySequence(const std::vector<NumberedFile>& files,
                                                     const SourceOptions& options) {
  VOLUTE_ASSERT(!files.empty());
  VOLUTE_ASSIGN(const auto first, openNpy(files.front().path, options));
  VolumeInfo info = first->info();
  info.frames = static_cast<int>(files.size());
  info.frameNumbers.clear(), info.times.clear();
  for (const NumberedFile& file : files) info.frameNumbers.push_back(file.number);
  info.frameScale = files.front().scale;
  info.fillDefaults();
  VOLUTE_TRY(info.validate(files.front().path.string()));
  auto sequence = std::make_unique<NpySequence>(files, options, info);
  for (const NumberedFile& file : files) {
    VOLUTE_ASSIGN(const auto one, openNpy(file.path, options));
    VOLUTE_TRY(sequence->checkSame(one->info(), file.path));
  }
  return sequence;
}

Result<std::unique_ptr<FrameSource>> openNpy(const std::filesystem::path& path,
                                             const SourceOptions& options) {
  if (!options.grid.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: a .npy file has no named grids; leave out --field {}", path.string(),
                options.grid);
  }
  VOLUTE_ASSIGN(auto file, InputFile::open(path));
  VOLUTE_ASSIGN(const NpyHeader header, readNpyHeader(file));
  VOLUTE_ASSIGN(VolumeInfo info, toInfo(header, file, options));
  return std::make_unique<NpySource>(std::move(file), header, std::move(info));
}

Result<std::unique_ptr<NpySink>> NpySink::create(const std::filesystem::path& path,
                                                 const VolumeInfo& info) {
  VOLUTE_TRY(info.validate(path.string()));
  std::vector<std::uint64_t> shape;
  for (int extent : {info.frames, info.z, info.y, info.x})
    shape.push_back(static_cast<std::uint64_t>(extent));
  if (info.channels > 1)
    shape.push_back(static_cast<std::uint64_t>(info.channels));
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  const std::string header = makeNpyHeader(shape);
  VOLUTE_TRY(file.write(std::as_bytes(std::span(header))));
  return std::unique_ptr<NpySink>(new NpySink(std::move(file), info));
}

Status NpySink::writeFrame(std::span<const float> values) {
  VOLUTE_ASSERT(values.size() == frameValues_ && written_ < frames_);
  ++written_;
  return file_.write(std::as_bytes(values));
}

Status NpySink::finish() {
  if (written_ != frames_) {
    return fail(ErrorCode::kInvalidArgument, "only {} of {} frames were written", written_,
                frames_);
  }
  return file_.commit();
}

}  // namespace volute
