// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/film.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/base/input_file.hpp"
#include "volute/io/image_formats.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/reader_process.hpp"

namespace volute {

Result<std::unique_ptr<FilmWriter>> FilmWriter::create(const std::filesystem::path& path, int width,
                                                       int height, double framesPerSecond,
                                                       const std::string& comment,
                                                       const FilmStyle& style) {
  constexpr int kLongestSide = 16384;
  if (width < 1 || height < 1 || width > kLongestSide || height > kLongestSide) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: a film of {} x {} pixels; expected 1 to {} on a side", path.string(), width,
                height, kLongestSide);
  }
  if (!std::isfinite(framesPerSecond) || framesPerSecond < 0.01 || framesPerSecond > 1000) {
    return fail(ErrorCode::kInvalidArgument, "{}: {} frames per second; expected 0.01 to 1000",
                path.string(), framesPerSecond);
  }
  if (style.bits != 8 && style.bits != 10)
    return fail(ErrorCode::kInvalidArgument, "{}: {} bits a channel; expected 8 or 10",
                path.string(), style.bits);
  const double factor = style.rateFactor.value_or(0);
  if (!(factor >= 0 && factor <= 51))
    return fail(ErrorCode::kInvalidArgument, "{}: a rate factor of {}; expected 0 to 51",
                path.string(), factor);
  VOLUTE_ASSIGN(const FilmPlugin* plugin, loadFilmPlugin());
  return plugin->makeWriter(path, width, height, framesPerSecond, comment, style);
}

/// Few enough to be passed over within the time that a call may take.
constexpr int kSkippedAtOnce = 1024;

namespace {

/// The child answers "open" with a FilmInfo, each "next" with "frame" or "end", and "skip" with the
/// times of those that it passed over.
Result<ReaderProcess::Serve> serveFilm(std::string_view parameters) {
  VOLUTE_ASSIGN(const FilmPlugin* plugin, loadFilmPlugin());
  return
      [plugin, file = std::filesystem::path(parameters), decoder = std::shared_ptr<FilmDecoder>()](
          std::string_view request, std::span<float> pixels) mutable -> Result<std::string> {
        if (request == "open") {
          decoder = plugin->makeDecoder();
          VOLUTE_ASSIGN(const FilmInfo info, decoder->open(file));
          return toMessage(info);
        }
        if (!decoder)
          return fail(ErrorCode::kInvalidData, "{}: decoding it failed before", file.string());
        if (request == "skip") {
          VOLUTE_ASSIGN(const auto times, decoder->skip(kSkippedAtOnce));
          return std::string(reinterpret_cast<const char*>(times.data()),
                             times.size() * sizeof(double));
        }
        VOLUTE_ASSIGN(const bool more, decoder->next(pixels));
        return std::string(more ? "frame" : "end");
      };
}

}  // namespace

struct FilmReader::Impl {
  explicit Impl(const std::filesystem::path& file, std::uint64_t memory)
      : path(file), maxMemory(memory), process(ReaderJob{serveFilm, file.string(), {file}}) {}

  Result<std::string> call(std::string_view request, std::size_t values) {
    constexpr std::uint64_t kLibraries = 256 << 20;
    return process.call(path.string(), request, values,
                        {std::max<std::uint64_t>(64 << 20, maxMemory) + kLibraries, 30});
  }

  std::filesystem::path path;
  std::uint64_t maxMemory;
  ReaderProcess process;
  FilmInfo info;
};

FilmReader::FilmReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

FilmReader::~FilmReader() = default;
FilmReader::FilmReader(FilmReader&&) noexcept = default;
FilmReader& FilmReader::operator=(FilmReader&&) noexcept = default;

const FilmInfo& FilmReader::info() const {
  return impl_->info;
}

Result<FilmReader> FilmReader::open(const std::filesystem::path& path, std::uint64_t maxMemory) {
  VOLUTE_TRY(InputFile::check(path));
  auto impl = std::make_unique<Impl>(path, maxMemory);
  VOLUTE_ASSIGN(const std::string reply, impl->call("open", 0));
  VOLUTE_ASSIGN(impl->info, fromMessage<FilmInfo>(reply));
  VOLUTE_TRY(checkImageSize(path, impl->info.width, impl->info.height, 3, maxMemory));
  return FilmReader(std::move(impl));
}

Result<std::optional<Image>> FilmReader::next() {
  const FilmInfo& film = impl_->info;
  VOLUTE_ASSIGN(const std::string reply,
                impl_->call("next", std::size_t{3} * film.width * film.height));
  if (reply == "end")
    return std::optional<Image>();
  Image image(film.width, film.height);
  std::ranges::copy(impl_->process.values(), image.pixels.begin());
  return std::optional<Image>(std::move(image));
}

Result<std::vector<double>> FilmReader::restOfTimes(int enough) {
  std::vector<double> times;
  bool more = true;
  while (more && times.size() < static_cast<std::size_t>(enough)) {
    VOLUTE_ASSIGN(const std::string reply, impl_->call("skip", 0));
    const std::size_t count = std::min<std::size_t>(reply.size() / sizeof(double), kSkippedAtOnce);
    times.resize(times.size() + count);
    std::memcpy(times.data() + times.size() - count, reply.data(), count * sizeof(double));
    more = count == kSkippedAtOnce;
  }
  times.resize(std::min(times.size(), static_cast<std::size_t>(enough)));
  if (std::ranges::all_of(times, [](double time) { return std::isfinite(time); }))
    std::ranges::sort(times);
  else
    std::ranges::fill(times, std::numeric_limits<double>::quiet_NaN());
  return times;
}

}  // namespace volute
