// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/array_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <utility>

#include "volute/base/assert.hpp"
#include "volute/base/file_name.hpp"
#include "volute/base/output_file.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/io/grid_choice.hpp"
#include "volute/io/netcdf_length.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/reader_process.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {
namespace {

constexpr std::size_t kTimesAtOnce = 8192;

/// Crosses to the child as bytes.
struct ArrayRequest {
  enum class What { kDescribe, kTimes, kRead };

  What what = What::kDescribe;
  bool place = true;
  std::int32_t frame = 0, first = 0, layers = 0;
  double offset = 0;
  std::uint64_t firstTime = 0;
  char name[ArrayFacts::kMaxText + 1] = {}, usual[ArrayFacts::kMaxText + 1] = {};
};

Result<ReaderProcess::Serve> serveArrays(std::string_view parameters) {
  VOLUTE_ASSIGN(const ArrayPlugin* plugin, loadArrayPlugin());
  return [reader = std::shared_ptr<ArrayReader>(plugin->makeReader()),
          times = std::vector<double>(), file = std::filesystem::path(parameters), open = false](
             std::string_view bytes, std::span<float> values) mutable -> Result<std::string> {
    VOLUTE_ASSIGN(const auto request, fromMessage<ArrayRequest>(bytes));
    if (request.what == ArrayRequest::What::kDescribe || !open) {
      VOLUTE_ASSIGN(const ArrayFacts facts,
                    reader->describe(file, request.name, request.usual, request.place));
      open = true;
      if (request.what == ArrayRequest::What::kDescribe)
        return toMessage(facts);
    }
    if (request.what == ArrayRequest::What::kTimes) {
      if (request.firstTime == 0) {
        VOLUTE_ASSIGN(times, reader->times());
      }
      const auto rest =
          std::span(times).subspan(std::min<std::size_t>(request.firstTime, times.size()));
      const auto some = rest.first(std::min(rest.size(), kTimesAtOnce));
      return std::string(reinterpret_cast<const char*>(some.data()), some.size_bytes());
    }
    ArrayReadFacts met;
    VOLUTE_TRY(
        reader->read(request.frame, request.first, request.layers, values, request.offset, met));
    return toMessage(met);
  };
}

class ArrayFileSource final : public LayerwiseSource {
 public:
  /// @param named  whether the input's name says which array is meant
  ArrayFileSource(const NamedArray& input, bool named, const SourceOptions& options)
      : path_(input.file.string()),
        named_(named),
        maxMemory_(options.maxMemory),
        process_({serveArrays, path_, {input.file}}) {
    input.name.copy(request_.name, ArrayFacts::kMaxText);
    options.usualGrid.copy(request_.usual, ArrayFacts::kMaxText);
    request_.place = !options.bounds;
  }

  Status open(const SourceOptions& options) {
    VOLUTE_ASSIGN(const std::string reply, ask(ArrayRequest::What::kDescribe, 0));
    VOLUTE_ASSIGN(facts_, fromMessage<ArrayFacts>(reply));
    for (char* text : {facts_.name, facts_.unit, facts_.others, facts_.order, facts_.unitless,
                       facts_.thin, facts_.doubt, facts_.range, facts_.absent})
      text[ArrayFacts::kMaxText] = 0;
    for (bool* flag : {&facts_.timed, &facts_.placed, &facts_.rounded}) settleFlag(*flag);
    info_.name = facts_.name;
    info_.unit = facts_.unit;
    info_.frames = facts_.size[0];
    info_.z = facts_.size[1], info_.y = facts_.size[2], info_.x = facts_.size[3];
    info_.channels = facts_.size[4];
    if (std::ranges::any_of(facts_.size, [](int size) { return size < 1; }))
      return fail(ErrorCode::kInvalidData, "{}: the array '{}' is empty", path_, info_.name);
    std::uint64_t bytes = sizeof(float);
    bool possible = true;
    for (const int size : std::span(facts_.size).subspan(1))
      possible = possible && !__builtin_mul_overflow(bytes, std::uint64_t(size), &bytes);
    constexpr std::uint64_t kPerFrame = sizeof(int) + sizeof(double);
    if (!possible || (!options.byLayers && bytes > maxMemory_) ||
        info_.frames * kPerFrame > maxMemory_) {
      return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                  "{}: a frame of {} x {} x {} voxels needs more than the {} MiB allowed", path_,
                  info_.x, info_.y, info_.z, maxMemory_ >> 20);
    }
    if (options.bounds && options.bounds->empty()) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}: the given bounds are empty; expected min < max on every axis", path_);
    }
    const auto& b = facts_.bounds;
    if (options.bounds)
      info_.bounds = *options.bounds;
    else if (facts_.placed)
      info_.bounds = {Vec3(b[0], b[1], b[2]), Vec3(b[3], b[4], b[5])};
    if (facts_.timed)
      VOLUTE_TRY(fetchTimes());
    info_.fillDefaults();
    VOLUTE_TRY(info_.validate(path_));
    remark_ = options.remark;
    if (options.remark)
      tell(options);
    return {};
  }

  const VolumeInfo& info() const override { return info_; }

  std::vector<std::string> otherGrids() const override {
    if (named_)  // that one is meant, whatever stands beside it
      return {};
    return namesOfGrids(facts_.others);
  }

  Status readLayers(int index, int first, int end, std::span<float> values) override {
    request_.frame = index, request_.first = first, request_.layers = end - first;
    VOLUTE_ASSIGN(const std::string reply, ask(ArrayRequest::What::kRead, values.size()));
    VOLUTE_ASSIGN(auto met, fromMessage<ArrayReadFacts>(reply));
    settleFlag(met.hasMarker);
    rounding_ = std::max(rounding_, met.rounding);
    if (met.hasMarker && facts_.absent[0] == 0 && remark_ && !std::exchange(toldMarker_, true)) {
      remark_(Remark(RemarkCode::kNote,
                     fmt::format("{}: nothing is there where '{}' has its fill value, {:g}", path_,
                                 info_.name, met.marker))
                  .in(path_));
    }
    std::ranges::copy(process_.values(), values.begin());
    return {};
  }

  double rounding() const override { return rounding_; }

  double offset() const override { return request_.offset; }

  bool mayRound() const override { return facts_.rounded; }

  bool takesOffset() const override { return true; }

  void takeOffset(double offset) override { request_.offset = offset, rounding_ = 0; }

 private:
  Result<std::string> ask(ArrayRequest::What what, std::size_t values) {
    constexpr std::uint64_t kLibraries = 256 << 20;
    request_.what = what;
    return process_.call(path_, toMessage(request_), values,
                         {std::max<std::uint64_t>(64 << 20, maxMemory_) + kLibraries,
                          10 + 1e-6 * static_cast<double>(values)});
  }

  Status fetchTimes() {
    const auto frames = static_cast<std::size_t>(info_.frames);
    while (info_.times.size() < frames) {
      request_.firstTime = info_.times.size();
      VOLUTE_ASSIGN(const std::string reply, ask(ArrayRequest::What::kTimes, 0));
      const std::size_t count =
          std::min(reply.size() / sizeof(double), frames - info_.times.size());
      if (count == 0)
        return fail(ErrorCode::kInvalidData, "{}: has {} times for {} frames", path_,
                    info_.times.size(), frames);
      info_.times.resize(info_.times.size() + count);
      std::memcpy(info_.times.data() + info_.times.size() - count, reply.data(),
                  count * sizeof(double));
    }
    return {};
  }

  void tell(const SourceOptions& options) const {
    if (request_.name[0] == 0 && facts_.others[0] != 0) {
      options.remark(Remark(RemarkCode::kAssumed,
                            fmt::format("{}: the array '{}' is read; it also has {}", path_,
                                        info_.name, facts_.others),
                            {Hint::choose("field")})
                         .in(path_));
    }
    if (facts_.order[0] != 0) {
      options.remark(Remark(RemarkCode::kAssumed,
                            fmt::format("{}: '{}' has dimensions that are axes by their order "
                                        "alone: {}",
                                        path_, info_.name, facts_.order))
                         .in(path_));
    }
    if (!facts_.placed && !options.bounds) {
      options.remark(Remark(RemarkCode::kAssumed,
                            fmt::format("{}: no bounds are stated; the longest side is 1 m", path_),
                            {Hint::set("bounds")})
                         .in(path_));
    }
    if (facts_.unitless[0] != 0) {
      options.remark(Remark(RemarkCode::kAssumed, fmt::format("{}: coordinates without units: {}",
                                                              path_, facts_.unitless))
                         .in(path_));
    }
    if (facts_.thin[0] != 0) {
      options.remark(Remark(RemarkCode::kAssumed,
                            fmt::format("{}: single voxels of a size that is not stated are taken "
                                        "to be {}",
                                        path_, facts_.thin),
                            {Hint::set("bounds")})
                         .in(path_));
    }
    if (facts_.range[0] != 0) {
      options.remark(Remark(RemarkCode::kNote, fmt::format("{}: nothing is there where '{}' has {}",
                                                           path_, info_.name, facts_.range))
                         .in(path_));
    }
    if (facts_.absent[0] != 0) {
      options.remark(Remark(RemarkCode::kAssumed,
                            fmt::format("{}: '{}': {}", path_, info_.name, facts_.absent))
                         .in(path_));
    }
    if (facts_.doubt[0] != 0) {
      options.remark(Remark(RemarkCode::kDoubtful,
                            fmt::format("{}: {}; taken as even within the bounds that are given",
                                        path_, facts_.doubt))
                         .in(path_));
    }
  }

  std::string path_;
  bool named_;
  std::uint64_t maxMemory_;
  ReaderProcess process_;
  ArrayRequest request_;
  ArrayFacts facts_;
  VolumeInfo info_;
  double rounding_ = 0;
  std::function<void(const Remark&)> remark_;
  bool toldMarker_ = false;
};

class ArraySink final : public FrameSink {
 public:
  ArraySink(PendingFile file, std::unique_ptr<ArrayWriter> writer, int frames)
      : file_(std::move(file)), writer_(std::move(writer)), left_(frames) {}

  Status writeFrame(std::span<const float> values) override {
    VOLUTE_ASSERT(left_ > 0);
    --left_;
    return writer_->write(values);
  }

  Status finish() override {
    if (left_ > 0) {
      return fail(ErrorCode::kInvalidArgument, "{}: {} frames are missing", file_.target().string(),
                  left_);
    }
    VOLUTE_TRY(writer_->finish());
    return file_.commit();
  }

 private:
  PendingFile file_;
  std::unique_ptr<ArrayWriter> writer_;
  int left_;
};

}  // namespace

std::optional<NamedArray> namedArray(const std::filesystem::path& input) {
  static constexpr std::string_view kKinds[] = {".nc", ".nc4", ".cdf", ".h5", ".hdf5", ".zarr"};
  const auto isArrayFile = [](const std::filesystem::path& path) {
    return std::ranges::find(kKinds, extensionOf(path)) != std::end(kKinds);
  };
  std::string whole = input.string();
  while (whole.size() > 1 && whole.ends_with('/')) whole.pop_back();  // of a folder .zarr
  if (isArrayFile(whole))
    return NamedArray{whole, {}};
  // Neither names of arrays nor those of files are without colons.
  for (std::size_t colon = whole.find(':'); colon != whole.npos;
       colon = whole.find(':', colon + 1)) {
    if (isArrayFile(whole.substr(0, colon)) && colon + 1 < whole.size())
      return NamedArray{whole.substr(0, colon), whole.substr(colon + 1)};
  }
  return std::nullopt;
}

Result<std::unique_ptr<FrameSource>> openArrayFile(const NamedArray& input,
                                                   const SourceOptions& options) {
  std::error_code error;
  if (!std::filesystem::is_directory(input.file, error))
    VOLUTE_TRY(checkNetcdfLength(input.file, true));
  if (std::filesystem::exists(input.file / "zarr.json", error)) {
    return fail(ErrorCode::kUnsupported,
                "{0}: is of Zarr's format 3; expected format 2, or let Python read it: "
                "volute.compress(zarr.open(\"{0}\")[\"{1}\"], \"{2}.volute\")",
                input.file.string(), input.name.empty() ? "name" : input.name,
                input.file.stem().string());
  }
  NamedArray chosen = input;
  if (!options.grid.empty() && !chosen.name.empty() && options.grid != chosen.name) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: the name says the array '{}', and the field '{}' is asked for; say one",
                input.file.string(), chosen.name, options.grid);
  }
  if (chosen.name.empty())
    chosen.name = options.grid;
  auto source = std::make_unique<ArrayFileSource>(chosen, !input.name.empty(), options);
  VOLUTE_TRY(source->open(options));
  return source;
}

bool isArrayOutput(const std::filesystem::path& output) {
  static constexpr std::string_view kKinds[] = {".nc", ".nc4", ".h5", ".hdf5"};
  return std::ranges::find(kKinds, extensionOf(output)) != std::end(kKinds);
}

Result<std::unique_ptr<FrameSink>> createArraySink(const std::filesystem::path& output,
                                                   const VolumeInfo& info, double offset) {
  VOLUTE_TRY(info.validate(output.string()));
  VOLUTE_ASSIGN(const ArrayPlugin* plugin, loadArrayPlugin());
  VOLUTE_ASSIGN(auto file, PendingFile::create(output));
  auto writer = plugin->makeWriter();
  VOLUTE_TRY(writer->begin(file.path(), output, info, offset));
  return std::make_unique<ArraySink>(std::move(file), std::move(writer), info.frames);
}

}  // namespace volute
