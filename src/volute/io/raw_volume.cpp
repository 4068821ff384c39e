// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/raw_volume.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/base/input_file.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/io/number_file.hpp"

namespace volute {
namespace {

NumberType numbersOf(const RawLayout& raw) {
  static_assert(static_cast<int>(RawLayout::Type::kUint8) == static_cast<int>(NumberKind::kUint8) &&
                static_cast<int>(RawLayout::Type::kFloat64) ==
                    static_cast<int>(NumberKind::kFloat64));
  return {static_cast<NumberKind>(raw.type), raw.bigEndian};
}

/// What one file of so many frames must be; none: it says how many it has.
Result<VolumeInfo> infoOf(const InputFile& file, const SourceOptions& options,
                          std::optional<int> frames) {
  // NOLINTNEXTLINE(bugprone-unchecked-optional-access): of raw files
  const RawLayout& raw = *options.raw;
  const std::string where = file.path().string();
  VolumeInfo info;
  info.x = raw.size[0];
  info.y = raw.size[1];
  info.z = raw.size[2];
  info.channels = raw.channels;
  std::uint64_t bytes = numbersOf(raw).size();
  bool possible = info.channels == 1 || info.channels == 3;
  for (const int extent : {info.x, info.y, info.z, info.channels})
    possible =
        possible && extent > 0 && !__builtin_mul_overflow(bytes, std::uint64_t(extent), &bytes);
  if (!possible || bytes > std::uint64_t{1} << 60) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: a raw frame of {} x {} x {} voxels with {} channels; expected sizes of 1 or "
                "more, and 1 or 3 channels",
                where, info.x, info.y, info.z, info.channels);
  }
  const std::uint64_t present = file.size() - std::min(file.size(), raw.offset);
  const std::uint64_t count = present / bytes;
  const bool fits = present % bytes == 0 && count > 0 &&
                    (frames ? count == static_cast<std::uint64_t>(*frames)
                            : count <= std::numeric_limits<std::int32_t>::max());
  if (!fits) {
    return fail(ErrorCode::kInvalidData,
                "{}: has {} bytes after the first {}, and a frame of {} x {} x {} voxels with {} "
                "channel{} of {} bytes takes {}; expected {} of them and nothing else",
                where, present, raw.offset, info.x, info.y, info.z, info.channels,
                info.channels == 1 ? "" : "s", numbersOf(raw).size(), bytes,
                frames ? "one" : "a whole number");
  }
  info.frames = static_cast<int>(count);
  const std::uint64_t limit = options.maxMemory;
  constexpr std::uint64_t kPerFrame = sizeof(int) + sizeof(double);
  if ((!options.byLayers && 4 * info.frameValues() > limit) || count * kPerFrame > limit) {
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "{}: {} frames of {} x {} x {} voxels need more than the {} MiB allowed", where,
                count, info.x, info.y, info.z, limit >> 20);
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

/// Files of numbered frames are open while they are read.
class RawSource final : public LayerwiseSource {
 public:
  RawSource(std::vector<std::filesystem::path> files, std::optional<NumberFile> single,
            RawLayout layout, VolumeInfo info)
      : files_(std::move(files)),
        single_(std::move(single)),
        layout_(layout),
        info_(std::move(info)) {}

  const VolumeInfo& info() const override { return info_; }

  Status readLayers(int index, int first, [[maybe_unused]] int end,
                    std::span<float> values) override {
    const std::uint64_t layer = info_.frameValues() / static_cast<std::uint64_t>(info_.z);
    VOLUTE_ASSERT(values.size() == layer * static_cast<std::uint64_t>(end - first));
    const auto frame = static_cast<std::uint64_t>(single_ ? index : 0);
    const std::uint64_t offset =
        layout_.offset + numbersOf(layout_).size() * (info_.frameValues() * frame +
                                                      layer * static_cast<std::uint64_t>(first));
    if (!single_)
      return readNumbered(index, offset, values);
    VOLUTE_TRY(single_->read(numbersOf(layout_), offset, values));
    rounding_ = single_->rounding();
    return {};
  }

  double rounding() const override { return rounding_; }

  double offset() const override { return offset_; }

  bool mayRound() const override { return numbersOf(layout_).isRounded(); }

  bool takesOffset() const override { return true; }

  void takeOffset(double offset) override {
    offset_ = offset, rounding_ = 0;
    if (single_)
      single_->takeOffset(offset);
  }

 private:
  Status readNumbered(int index, std::uint64_t offset, std::span<float> values) {
    VOLUTE_ASSIGN(auto opened, InputFile::open(files_[static_cast<std::size_t>(index)]));
    NumberFile file(std::move(opened));
    file.takeOffset(offset_);
    VOLUTE_TRY(file.read(numbersOf(layout_), offset, values));
    rounding_ = std::max(rounding_, file.rounding());
    return {};
  }

  std::vector<std::filesystem::path> files_;
  std::optional<NumberFile> single_;
  RawLayout layout_;
  VolumeInfo info_;
  double rounding_ = 0, offset_ = 0;
};

Status checkNoGrid(const std::filesystem::path& path, const SourceOptions& options) {
  if (options.grid.empty())
    return {};
  return fail(ErrorCode::kInvalidArgument, Hint::leaveOut("field"),
              "{}: a raw file has no grid named '{}'", path.string(), options.grid);
}

}  // namespace

Result<std::unique_ptr<FrameSource>> openRaw(const std::filesystem::path& path,
                                             const SourceOptions& options) {
  VOLUTE_ASSERT(options.raw);
  VOLUTE_TRY(checkNoGrid(path, options));
  VOLUTE_ASSIGN(auto file, InputFile::open(path));
  VOLUTE_ASSIGN(auto info, infoOf(file, options, std::nullopt));
  return std::make_unique<RawSource>(std::vector<std::filesystem::path>(),
                                     NumberFile(std::move(file)), *options.raw, std::move(info));
}

Result<std::unique_ptr<FrameSource>> openRawSequence(const std::vector<NumberedFile>& files,
                                                     const SourceOptions& options) {
  VOLUTE_ASSERT(options.raw && !files.empty());
  VOLUTE_TRY(checkNoGrid(files.front().path, options));
  VolumeInfo info;
  std::vector<int> numbers;
  std::vector<std::filesystem::path> paths;
  for (const NumberedFile& one : files) {
    VOLUTE_ASSIGN(const auto file, InputFile::open(one.path));
    VOLUTE_ASSIGN(info, infoOf(file, options, 1));
    numbers.push_back(one.number);
    paths.push_back(one.path);
  }
  info.frames = static_cast<int>(files.size());
  info.frameNumbers = std::move(numbers);
  info.frameScale = files.front().scale;
  info.times.clear();
  info.fillDefaults();
  VOLUTE_TRY(info.validate(files.front().path.string()));
  return std::make_unique<RawSource>(std::move(paths), std::nullopt, *options.raw, std::move(info));
}

Result<RawLayout> parseRawSize(const std::string& text) {
  std::vector<int> sizes;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (bool sound = true; sound;) {
    int size = 0;
    const auto [stop, error] = std::from_chars(at, end, size);
    sizes.push_back(error == std::errc() ? size : 0);
    sound = error == std::errc() && stop != end && *stop == ',';
    if (!sound && stop != end)
      sizes.back() = 0;
    at = stop + 1;
  }
  if (std::ranges::any_of(sizes, [](int size) { return size <= 0; }) ||
      (sizes.size() != 3 && !(sizes.size() == 4 && (sizes[3] == 1 || sizes[3] == 3)))) {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' is no size; expected X,Y,Z or X,Y,Z,C in voxels, with 1 or 3 channels, as "
                "512,512,256",
                text);
  }
  RawLayout raw;
  raw.size = {sizes[0], sizes[1], sizes[2]};
  raw.channels = sizes.size() == 4 ? sizes[3] : 1;
  return raw;
}

std::span<const std::string_view> rawTypeNames() {
  static constexpr std::string_view kNames[] = {"uint8", "int8",    "uint16",  "int16",  "uint32",
                                                "int32", "float16", "float32", "float64"};
  return kNames;
}

std::optional<RawLayout::Type> rawTypeByName(std::string_view name) {
  const auto names = rawTypeNames();
  const auto found = std::ranges::find(names, name);
  if (found == names.end())
    return std::nullopt;
  return static_cast<RawLayout::Type>(found - names.begin());
}

}  // namespace volute
