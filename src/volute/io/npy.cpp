// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/npy.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "volute/base/assert.hpp"
#include "volute/base/file_name.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/io/npy_header.hpp"
#include "volute/io/npz.hpp"
#include "volute/io/number_file.hpp"

namespace volute {
namespace {

/// Extents to axes, and whether the file is as long as they say.
Result<VolumeInfo> toInfo(const NpyHeader& header, const NumberFile& file, const std::string& where,
                          const SourceOptions& options) {
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
  std::uint64_t bytes = header.type.size();
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
  const bool byLayers = options.byLayers && !header.fortranOrder;
  if ((!byLayers && 4 * info.frameValues() > options.maxMemory) ||
      info.frames * kPerFrame > options.maxMemory) {
    return fail(
        ErrorCode::kTooLarge,
        "{}: a frame of {} x {} x {} voxels needs more than the {} MiB allowed; allow more memory",
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

class NpySource final : public LayerwiseSource {
 public:
  NpySource(NumberFile file, const NpyHeader& header, VolumeInfo info,
            std::vector<std::string> others)
      : file_(std::move(file)),
        header_(header),
        info_(std::move(info)),
        others_(std::move(others)) {}

  const VolumeInfo& info() const override { return info_; }

  std::vector<std::string> otherGrids() const override { return others_; }

  Status readLayers(int index, int first, [[maybe_unused]] int end,
                    std::span<float> values) override {
    const std::uint64_t layer = info_.frameValues() / static_cast<std::uint64_t>(info_.z);
    VOLUTE_ASSERT(values.size() == layer * static_cast<std::uint64_t>(end - first));
    const std::uint64_t before = info_.frameValues() * static_cast<std::uint64_t>(index) +
                                 layer * static_cast<std::uint64_t>(first);
    return file_.read(header_.type, header_.dataOffset + header_.type.size() * before, values);
  }

  double rounding() const override { return file_.rounding(); }

  double offset() const override { return file_.offset(); }

  bool mayRound() const override { return header_.type.isRounded(); }

  bool takesOffset() const override { return true; }

  void takeOffset(double offset) override { file_.takeOffset(offset); }

 private:
  NumberFile file_;
  NpyHeader header_;
  VolumeInfo info_;
  std::vector<std::string> others_;
};

/// An array whose first axis, time, is the fastest: the file is read for as many frames together as
/// there is room for.
class FortranNpySource final : public RoundingSource {
 public:
  FortranNpySource(NumberFile file, const NpyHeader& header, VolumeInfo info,
                   std::vector<std::string> others, std::uint64_t maxMemory)
      : file_(std::move(file)),
        header_(header),
        info_(std::move(info)),
        others_(std::move(others)),
        together_(static_cast<int>(std::clamp<std::uint64_t>(
            maxMemory / 4 / sizeof(float) / info_.frameValues(), 1, info_.frames))) {}

  const VolumeInfo& info() const override { return info_; }

  std::vector<std::string> otherGrids() const override { return others_; }

  Status readFrame(int index, std::span<float> values) override {
    VOLUTE_ASSERT(values.size() == info_.frameValues());
    const int first = index / together_ * together_;
    if (first != first_)
      VOLUTE_TRY(load(first));
    const auto begin = static_cast<std::size_t>(index - first) * values.size();
    std::copy_n(frames_.begin() + static_cast<std::ptrdiff_t>(begin), values.size(),
                values.begin());
    return {};
  }

  double rounding() const override { return file_.rounding(); }

  double offset() const override { return file_.offset(); }

  bool mayRound() const override { return header_.type.isRounded(); }

  bool takesOffset() const override { return true; }

  void takeOffset(double offset) override { file_.takeOffset(offset), first_ = -1; }

 private:
  // Lines along time, then along z, y, x and c.
  Status load(int first) {
    first_ = -1;
    const auto all = static_cast<std::size_t>(info_.frames);
    const std::size_t count = std::min<std::size_t>(together_, all - first);
    frames_.resize(count * info_.frameValues());
    const std::size_t lines = info_.frameValues();
    const std::size_t linesAPiece = std::max<std::size_t>(1, (std::size_t{1} << 20) / all);
    std::vector<float> piece;
    std::array<std::size_t, 4> at{};  // c, x, y, z
    const auto sides = sidesOf(info_);
    for (std::size_t line = 0; line < lines; line += linesAPiece) {
      piece.resize(std::min(linesAPiece, lines - line) * all);
      VOLUTE_TRY(
          file_.read(header_.type, header_.dataOffset + header_.type.size() * line * all, piece));
      for (const float* times = piece.data() + first; times < piece.data() + piece.size();
           times += all) {
        const std::size_t voxel =
            ((at[3] * sides[2] + at[2]) * sides[1] + at[1]) * sides[0] + at[0];
        for (std::size_t t = 0; t < count; ++t) frames_[t * lines + voxel] = times[t];
        // NOLINTNEXTLINE(bugprone-inc-dec-in-conditions): && keeps the order
        for (std::size_t axis = 4; axis-- > 0 && ++at[axis] == sides[axis];) at[axis] = 0;
      }
    }
    first_ = first;
    return {};
  }

  static std::array<std::size_t, 4> sidesOf(const VolumeInfo& info) {
    return {static_cast<std::size_t>(info.channels), static_cast<std::size_t>(info.x),
            static_cast<std::size_t>(info.y), static_cast<std::size_t>(info.z)};
  }

  NumberFile file_;
  NpyHeader header_;
  VolumeInfo info_;
  std::vector<std::string> others_;
  int together_ = 1;
  int first_ = -1;             // of the frames that are loaded
  std::vector<float> frames_;  // shape (t, z, y, x, c)
};

Result<std::unique_ptr<FrameSource>> openArray(NumberFile file, const std::string& name,
                                               std::vector<std::string> others,
                                               const SourceOptions& options) {
  const std::string path = file.path().string();
  const std::string where = name.empty() ? path : fmt::format("{}: {}", path, name);
  std::vector<std::byte> front(std::min<std::uint64_t>(file.size(), kLongestNpyHeader));
  VOLUTE_TRY(file.read(0, front));
  VOLUTE_ASSIGN(const NpyHeader header, readNpyHeader(front, file.size(), where));
  VOLUTE_ASSIGN(VolumeInfo info, toInfo(header, file, where, options));
  const auto& shape = header.shape;
  if (options.remark && shape.size() == 4 && shape[3] == 3 && shape[1] > 3 && shape[2] > 3) {
    options.remark(Remark(RemarkCode::kDoubtful,
                          fmt::format("{}: {} frames, 3 voxels wide: an array of four axes is "
                                      "(t,z,y,x); three channels are the last of five axes, "
                                      "(t,z,y,x,c)",
                                      where, shape[0]))
                       .in(path));
  }
  constexpr std::string_view kNameless = "arr_";  // numpy.savez's names of what has none
  if (!name.empty() && !name.starts_with(kNameless))
    info.name = name;
  VOLUTE_TRY(info.validate(where));
  if (header.fortranOrder) {
    return std::make_unique<FortranNpySource>(std::move(file), header, std::move(info),
                                              std::move(others), options.maxMemory);
  }
  return std::make_unique<NpySource>(std::move(file), header, std::move(info), std::move(others));
}

/// A file is open while its frame is read.
class NpySequence final : public LayerwiseSource {
 public:
  /// @param rounded  whether a float may be another number than one of a file
  NpySequence(std::vector<NumberedFile> files, SourceOptions options, VolumeInfo info, bool rounded)
      : files_(std::move(files)),
        options_(std::move(options)),
        info_(std::move(info)),
        rounded_(rounded) {}

  const VolumeInfo& info() const override { return info_; }

  Status readLayers(int index, int first, [[maybe_unused]] int end,
                    std::span<float> values) override {
    const auto& path = files_[static_cast<std::size_t>(index)].path;
    VOLUTE_ASSIGN(const auto file, openNpy(path, options_));
    VOLUTE_TRY(checkSame(file->info(), info_, path, files_.front().path));
    auto& numbers = dynamic_cast<RoundingSource&>(*file);
    numbers.takeOffset(offset_);
    VOLUTE_TRY(file->readLayers(0, first, end, values));
    rounding_ = std::max(rounding_, roundingOf(*file));
    return {};
  }

  double rounding() const override { return rounding_; }

  double offset() const override { return offset_; }

  bool mayRound() const override { return rounded_; }

  bool takesOffset() const override { return true; }

  void takeOffset(double offset) override { offset_ = offset, rounding_ = 0; }

  /// One frame, and as large as the first file's.
  static Status checkSame(const VolumeInfo& one, const VolumeInfo& all,
                          const std::filesystem::path& path, const std::filesystem::path& first) {
    if (one.frames == 1 && one.x == all.x && one.y == all.y && one.z == all.z &&
        one.channels == all.channels)
      return {};
    return fail(
        ErrorCode::kInvalidData,
        "{}: holds {} frame{} of {} x {} x {} voxels with {} channel{}; expected one of {} x {} "
        "x {} with {}, as {} has",
        path.string(), one.frames, one.frames == 1 ? "" : "s", one.x, one.y, one.z, one.channels,
        one.channels == 1 ? "" : "s", all.x, all.y, all.z, all.channels, first.filename().string());
  }

 private:
  std::vector<NumberedFile> files_;
  SourceOptions options_;
  VolumeInfo info_;
  bool rounded_;
  double rounding_ = 0, offset_ = 0;
};

/// @param chosen  becomes the name of the array in a .npz; of a .npy it stays
Result<std::unique_ptr<FrameSource>> openNamed(const std::filesystem::path& path,
                                               const SourceOptions& options, std::string& chosen) {
  if (extensionOf(path) == ".npz") {
    VOLUTE_ASSIGN(auto array, openNpzArray(path, options));
    if (options.grid.empty() && !array.others.empty() && options.remark) {
      options.remark(Remark(RemarkCode::kAssumed,
                            fmt::format("{}: the array '{}' is read; it also has {}", path.string(),
                                        array.name, fmt::join(array.others, ", ")),
                            {Hint::choose("field")})
                         .in(path.string()));
    }
    if (!array.rest.empty() && options.remark) {
      options.remark(Remark(RemarkCode::kLeftOut,
                            fmt::format("{}: arrays that are not of three to five axes are left "
                                        "out: {}",
                                        path.string(), fmt::join(array.rest, ", ")))
                         .in(path.string()));
    }
    chosen = array.name;
    return openArray(std::move(array.file), array.name, std::move(array.others), options);
  }
  if (!options.grid.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: a .npy file has no named grids; leave out the field '{}'", path.string(),
                options.grid);
  }
  VOLUTE_ASSIGN(auto file, InputFile::open(path));
  return openArray(NumberFile(std::move(file)), "", {}, options);
}

}  // namespace

Result<std::unique_ptr<FrameSource>> openNpySequence(const std::vector<NumberedFile>& files,
                                                     const SourceOptions& given) {
  VOLUTE_ASSERT(!files.empty());
  SourceOptions options = given;  // the array of the first file is that of all
  VOLUTE_ASSIGN(const auto first, openNamed(files.front().path, given, options.grid));
  VolumeInfo info = first->info();
  info.frames = static_cast<int>(files.size());
  info.frameNumbers.clear(), info.times.clear();
  for (const NumberedFile& file : files) info.frameNumbers.push_back(file.number);
  info.frameScale = files.front().scale;
  info.fillDefaults();
  VOLUTE_TRY(info.validate(files.front().path.string()));
  bool rounded = false;
  for (const NumberedFile& file : files) {
    VOLUTE_ASSIGN(const auto one, openNpy(file.path, options));
    VOLUTE_TRY(NpySequence::checkSame(one->info(), info, file.path, files.front().path));
    rounded = rounded || dynamic_cast<const RoundingSource&>(*one).mayRound();
  }
  return std::make_unique<NpySequence>(files, options, info, rounded);
}

Result<std::unique_ptr<FrameSource>> openNpy(const std::filesystem::path& path,
                                             const SourceOptions& options) {
  std::string chosen;
  return openNamed(path, options, chosen);
}

Result<std::unique_ptr<NpySink>> NpySink::create(const std::filesystem::path& path,
                                                 const VolumeInfo& info, double offset) {
  VOLUTE_TRY(info.validate(path.string()));
  std::vector<std::uint64_t> shape;
  for (int extent : {info.frames, info.z, info.y, info.x})
    shape.push_back(static_cast<std::uint64_t>(extent));
  if (info.channels > 1)
    shape.push_back(static_cast<std::uint64_t>(info.channels));
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  const std::string header = makeNpyHeader(shape, offset == 0 ? "<f4" : "<f8");
  VOLUTE_TRY(file.write(std::as_bytes(std::span(header))));
  return std::unique_ptr<NpySink>(new NpySink(std::move(file), info, offset));
}

Status NpySink::writeFrame(std::span<const float> values) {
  VOLUTE_ASSERT(values.size() == frameValues_ && written_ < frames_);
  ++written_;
  if (offset_ == 0)
    return file_.write(std::as_bytes(values));
  constexpr std::size_t kPiece = std::size_t{1} << 16;
  std::vector<double> numbers;
  for (std::size_t at = 0; at < values.size(); at += kPiece) {
    numbers.clear();
    for (const float value : values.subspan(at, std::min(kPiece, values.size() - at)))
      numbers.push_back(offset_ + value);
    VOLUTE_TRY(file_.write(std::as_bytes(std::span(numbers))));
  }
  return {};
}

Status NpySink::finish() {
  if (written_ != frames_) {
    return fail(ErrorCode::kInvalidArgument, "only {} of {} frames were written", written_,
                frames_);
  }
  return file_.commit();
}

}  // namespace volute
