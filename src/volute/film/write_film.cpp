// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/film/write_film.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "volute/base/cancel_only.hpp"
#include "volute/base/file_name.hpp"
#include "volute/base/ordered_delivery.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/process_usage.hpp"
#include "volute/base/worker.hpp"
#include "volute/image/picture_style.hpp"
#include "volute/io/output_names.hpp"

namespace volute {
namespace {

Result<std::unique_ptr<PictureWriter>> writerFor(const std::string& target, const FilmJob& job,
                                                 const Development& development) {
  if (!isFilmPath(target))
    return imageFileWriter(target, development, job.frameScale);
  std::string comment;
  for (const auto& [name, text] : job.textOf(job.frames.front()).notes) {
    if (name != "volute.time")
      comment += fmt::format("{}{}: {}", comment.empty() ? "" : "; ", name, text);
  }
  return filmWriter(target, development, job.camera.width(), job.camera.height(),
                    job.framesPerSecond, comment);
}

/// How much is to come, before the first picture.
void remarkOnPictures(const FilmJob& job, const std::string& target, Progress& progress) {
  const std::size_t count = job.frames.size();
  const double first = job.frames.front().time, last = job.frames.back().time;
  std::string text = fmt::format("{}: {} pictures from {} to {} s", target, count,
                                 plainNumber(first), plainNumber(last));
  if (isFilmPath(target)) {
    text += fmt::format(", {:.3g} a second: a film of {:.3g} s", job.framesPerSecond,
                        static_cast<double>(count) / job.framesPerSecond);
  }
  progress.remark(text);
  const Camera& camera = job.camera;
  if (const auto even = evenSizeText(target, camera.width(), camera.height());
      isFilmPath(target) && !even.empty())
    progress.remark({RemarkCode::kChanged, even});
}

/// How long all of it takes if each picture takes as long as one did; nothing of a short while.
void remarkOnDuration(double seconds, std::int64_t count, std::int64_t ranks, Progress& progress) {
  constexpr double kWorthSaying = 10;
  const double all = seconds * static_cast<double>((count + ranks - 1) / ranks);
  if (all < kWorthSaying)
    return;
  progress.remark(fmt::format("one picture takes {:.2g} s, all {} about {}", seconds, count,
                              all < 90     ? fmt::format("{:.0f} s", all)
                              : all < 5400 ? fmt::format("{:.0f} min", all / 60)
                                           : fmt::format("{:.1f} h", all / 3600)));
}

/// One exposure for all pictures: from some of them, small ones, or, where they are measured, from
/// the middle one.
Result<double> exposureFor(FilmJob& job, const Development& how, Progress& progress) {
  constexpr std::size_t kTried = 7;
  constexpr int kPixels = 240;  // of the longer side
  const Camera whole = job.camera;
  const int longest = std::max(whole.width(), whole.height());
  const double factor = std::min(1.0, kPixels / static_cast<double>(longest));
  const auto size = [&](int pixels) {
    return std::max(1, static_cast<int>(std::lround(factor * pixels)));
  };
  const std::size_t count = job.frames.size();
  const std::size_t tried = job.measured ? 1 : std::min(count, kTried);
  const FilmTotals totals = job.totals;
  const int samples = std::exchange(job.samples, 1);
  const bool partial = std::exchange(job.partial, false);  // without an exposure there is nothing
  if (!job.measured)
    job.camera = whole.resized(size(whole.width()), size(whole.height()));
  std::vector<Image> pictures;
  Status status;
  for (std::size_t i = 0; i < tried && status; ++i) {
    const std::size_t at = tried == 1 ? count / 2 : i * (count - 1) / (tried - 1);
    auto one = job.picture(job.frames[at], progress);
    if (one)
      pictures.push_back(std::move(*one));
    else
      status = tl::unexpected<Error>(std::move(one.error()));
  }
  job.camera = whole, job.samples = samples, job.totals = totals;
  job.partial = partial;
  VOLUTE_TRY(status);
  const bool black = std::ranges::none_of(pictures, [](const Image& picture) {
    return std::ranges::any_of(picture.pixels, [](float value) { return value > 0; });
  });
  if (black) {
    progress.remark(
        {RemarkCode::kDoubtful,
         fmt::format("{} black: nothing in view has a light above 0; look at the "
                     "camera, the lights, the time and the sign of the values",
                     tried == 1 ? "the picture is" : "all pictures that were tried are")});
    return 1.0;
  }
  if (how.colorMap) {  // its end: of all values, and a little more of pictures that were not tried
    constexpr float kBeyond = 1.05F;
    float most = 0;
    for (const Image& picture : pictures) most = std::max(most, std::ranges::max(picture.pixels));
    progress.remark(fmt::format("the colours are of 0 to {:.4g}", kBeyond * most));
    return 1 / static_cast<double>(kBeyond * most);
  }
  const double exposure = suggestExposure(pictures, how.style.tone);
  progress.remark(count == 1 ? fmt::format("exposure {:.4g}", exposure)
                             : fmt::format("exposure {:.4g} for all, from {} of {} pictures",
                                           exposure, tried, count));
  return exposure;
}

/// Whether 1 is white in a job's pictures.
bool hasScale(const FilmJob& job) {
  return job.contour || job.options.aov == Aov::kTransmittance ||
         (measuresLight(job.scene) && job.options.aov == Aov::kNone);
}

std::vector<std::byte> bytesOf(const Image& image) {
  const std::int32_t sizes[] = {image.width, image.height, image.channels};
  std::vector<std::byte> bytes(sizeof sizes + image.pixels.size() * sizeof(float));
  std::memcpy(bytes.data(), sizes, sizeof sizes);
  std::memcpy(bytes.data() + sizeof sizes, image.pixels.data(), bytes.size() - sizeof sizes);
  return bytes;
}

/// Of this same program, on a machine of the same kind.
Image imageOf(std::span<const std::byte> bytes) {
  std::int32_t sizes[3];
  std::memcpy(sizes, bytes.data(), sizeof sizes);
  Image image(sizes[0], sizes[1], sizes[2]);
  std::memcpy(image.pixels.data(), bytes.data() + sizeof sizes, bytes.size() - sizeof sizes);
  return image;
}

/// Bytes of pictures of a film that wait for those before them.
std::uint64_t maximumPending(const Camera& camera, std::uint64_t maxMemory) {
  const std::uint64_t bytes = 3 * std::uint64_t{sizeof(float)} * camera.width() * camera.height();
  return bytes * std::clamp<std::uint64_t>(maxMemory / 8 / bytes, 1, 4);
}

/// Stills that a rank takes at once. Compressed volumes are decoded in rows of 16 frames, which two
/// ranks would both do; few units a rank would leave ranks waiting in the end.
std::int64_t framesAUnit(std::int64_t count, int ranks) {
  constexpr std::int64_t kRow = 16, kUnitsARank = 8;
  return ranks > 1 && count >= kRow * kUnitsARank * ranks ? kRow : 1;
}

/// Passes on what stages say that run at once.
class StagedProgress final : public Progress {
 public:
  explicit StagedProgress(Progress& outer) : outer_(outer) {}

  void report(std::string_view stage, double done, double total) override {
    const std::lock_guard lock(guard_);
    outer_.report(stage, done, total);
  }

  void detail(std::string_view text) override {
    const std::lock_guard lock(guard_);
    outer_.detail(text);
  }

  void remark(const Remark& remark) override {
    const std::lock_guard lock(guard_);
    outer_.remark(remark);
  }

  bool cancelled() const override { return outer_.cancelled(); }

 private:
  Progress& outer_;
  std::mutex guard_;
};

/// The pictures of a job on their way into a file or files.
class FilmPass {
 public:
  FilmPass(FilmJob& job, const std::string& target, Development& development,
           std::uint64_t maxMemory, Progress& progress, Team& team)
      : job_(job),
        target_(target),
        development_(development),
        maxMemory_(maxMemory),
        progress_(progress),
        steps_(progress_),
        team_(team),
        count_(static_cast<std::int64_t>(job.frames.size())),
        film_(team, count_, maximumPending(job.camera, maxMemory),
              [this](std::int64_t i, const auto& bytes) { return write(i, imageOf(bytes)); }) {}

  Status run() {
    const auto begin = Clock::now();
    const double cpu = cpuSeconds();
    const Status done = write();
    FilmTotals& totals = job_.totals;
    totals.wall += std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    totals.cpu += 1e3 * (cpuSeconds() - cpu);
    if (writer_)
      totals.convert += writer_->converted();
    return done;
  }

 private:
  using Clock = std::chrono::steady_clock;

  Status write() {
    if (count_ > 1)
      remarkOnPictures(job_, target_, progress_);
    VOLUTE_TRY(settleExposure());
    if (team_.leads() || !(isFilmPath(target_) || job_.together)) {
      VOLUTE_ASSIGN(writer_, writerFor(target_, job_, development_));
    }
    begun_ = Clock::now();
    if (job_.together)
      return drawTogether();
    const std::int64_t group = isFilmPath(target_) ? 1 : framesAUnit(count_, team_.size());
    VOLUTE_TRY(team_.forUnits(
        "rendering", (count_ + group - 1) / group,
        count_ > 1 ? static_cast<Progress&>(progress_) : steps_,
        [&](std::int64_t unit) -> Status {
          for (std::int64_t i = unit * group; i < std::min(count_, (unit + 1) * group); ++i)
            VOLUTE_TRY(take(i));
          return {};
        },
        [&] { return isFilmPath(target_) && !staged() ? film_.finish() : Status(); }));
    VOLUTE_TRY(writing_.finish());
    VOLUTE_TRY(finish());
    if (job_.drawnShare == 1)
      return {};
    return fail(ErrorCode::kCancelled,
                "stopped; {} shows {:.0f} % of the picture, the rest coarsely", target_,
                100 * job_.drawnShare);
  }

  Status finish() {
    if (!writer_)
      return {};
    {
      const Stopwatch watch(job_.totals.write);
      VOLUTE_TRY(writer_->finish());
    }
    if (const auto lost = writer_->halvesLost(target_))
      progress_.remark(*lost);
    return {};
  }

  /// Pictures of one process go through stages at once: one is read and decoded, another drawn, and
  /// one before converted and encoded. What a shutter or layers need is read as it is drawn.
  bool staged() const {
    return team_.size() == 1 && count_ > 1 && threadCount() > 1 && job_.layers.empty() &&
           !job_.together && !(job_.shutter > 0);
  }

  /// What is at a frame's time; the next one is read meanwhile.
  Result<SceneSnapshot> snapshotOf(std::int64_t i) {
    VOLUTE_TRY(reading_.finish());
    if (ahead_ != i)
      return job_.snapshotAt(frame(i), each());
    ahead_ = -1;
    return std::move(next_);
  }

  Status readAhead(std::int64_t i, const SceneSnapshot& now) {
    constexpr std::uint64_t kShare = 4;  // of the memory, for what is read ahead
    std::uint64_t bytes = 0;
    for (const auto& medium : now.media) bytes += medium->memoryBytes();
    if (i >= count_ || bytes > maxMemory_ / kShare)
      return {};
    ahead_ = i;
    return reading_.give([this, i]() -> Status {
      VOLUTE_ASSIGN(next_, job_.snapshotAt(frame(i), each()));
      return {};
    });
  }

  Status takeInStages(std::int64_t i) {
    VOLUTE_ASSIGN(const SceneSnapshot snapshot, snapshotOf(i));
    auto text = job_.textOf(frame(i));  // while the scene is at that time
    VOLUTE_TRY(readAhead(i + 1, snapshot));
    VOLUTE_ASSIGN(auto image, job_.drawn(snapshot, frame(i), each()));
    sayDuration();
    return writing_.give(
        [this, i, image = std::make_shared<const Image>(std::move(image)), text = std::move(text)] {
          const Stopwatch watch(job_.totals.write);
          return writer_->write(*image, frame(i).number, text);
        });
  }

  /// Rank 0 writes.
  Status drawTogether() {
    for (std::int64_t i = 0; i < count_; ++i) {
      if (count_ > 1)
        progress_.report("rendering", static_cast<double>(i), static_cast<double>(count_));
      // What a rank could not send shows here: such a picture is not written.
      const Result<Image> image = drawOne(i);
      VOLUTE_TRY(team_.agree(image ? Status() : tl::unexpected<Error>(image.error())));
      VOLUTE_TRY(team_.agree(writer_ ? write(i, *image) : Status()));
    }
    return finish();
  }

  Result<Image> drawOne(std::int64_t i) {
    if (progress_.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before frame {}", frame(i).number);
    auto image = job_.picture(frame(i), each());
    sayDuration();
    return image;
  }

  const FilmFrame& frame(std::int64_t i) const { return job_.frames[static_cast<std::size_t>(i)]; }

  /// Of several pictures each is one step, with its remarks.
  Progress& each() { return count_ > 1 ? static_cast<Progress&>(steps_) : progress_; }

  /// Rank 0 finds it.
  Status settleExposure() {
    double& exposure = development_.style.exposure;
    if (exposure == 0 && (hasScale(job_) || extensionOf(target_) == ".exr")) {
      exposure = 1;
    } else if (exposure == 0) {
      if (team_.leads() || job_.together) {
        VOLUTE_ASSIGN(exposure, usualExposure(job_, development_, each()));
      }
      VOLUTE_ASSIGN(exposure, team_.broadcast(exposure));
    }
    job_.style = development_.style;
    return {};
  }

  void sayDuration() {
    if (count_ == 1 || std::exchange(said_, true))
      return;
    const double seconds = std::chrono::duration<double>(Clock::now() - begun_).count();
    const auto ranks = static_cast<std::int64_t>(team_.size());
    remarkOnDuration(seconds, count_, ranks, progress_);
  }

  Status take(std::int64_t i) {
    if (progress_.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before frame {}", frame(i).number);
    if (!job_.layers.empty())
      return writeLayers(i);
    if (staged())
      return takeInStages(i);
    VOLUTE_ASSIGN(const Image image, job_.picture(frame(i), each()));
    sayDuration();
    return give(i, image);
  }

  Status writeLayers(std::int64_t i) {
    VOLUTE_ASSIGN(const auto channels, job_.layersAt(frame(i), each()));
    const Stopwatch watch(job_.totals.write);
    return writer_->writeLayers(job_.camera.width(), job_.camera.height(), channels,
                                frame(i).number, job_.textOf(frame(i)));
  }

  Status give(std::int64_t i, const Image& image) {
    return isFilmPath(target_) ? film_.give(i, bytesOf(image)) : write(i, image);
  }

  Status write(std::int64_t i, const Image& image) {
    const Stopwatch watch(job_.totals.write);
    return writer_->write(image, frame(i).number, job_.textOf(frame(i)));
  }

  FilmJob& job_;
  const std::string& target_;
  Development& development_;
  std::uint64_t maxMemory_;
  StagedProgress progress_;
  CancelOnly steps_;
  Team& team_;
  std::int64_t count_;
  OrderedDelivery film_;
  std::unique_ptr<PictureWriter> writer_;
  Clock::time_point begun_ = Clock::now();
  bool said_ = false;
  Result<SceneSnapshot> next_;      ///< of frame ahead_, once reading_ has finished
  std::int64_t ahead_ = -1;         ///< none
  Worker reading_{1}, writing_{2};  ///< last: they use the others
};

/// Adds what is counted and timed; what a scene has is the same on all ranks.
void addStats(nlohmann::ordered_json& sum, const nlohmann::ordered_json& other) {
  for (const auto& [name, value] : other.items()) {
    constexpr std::string_view kOfTheScene[] = {"size",       "C",          "triangles",
                                                "tree_nodes", "tree_bytes", "bricks_stored"};
    nlohmann::ordered_json& into = sum[name];
    if (value.is_object())
      addStats(into, value);
    else if (!value.is_number() || std::ranges::find(kOfTheScene, name) != std::end(kOfTheScene))
      continue;
    else if (name == "peak_memory_bytes")
      into = std::max(into.get<double>(), value.get<double>()) == into.get<double>() ? into : value;
    else if (value.is_number_integer())
      into = into.get<std::int64_t>() + value.get<std::int64_t>();
    else
      into = into.get<double>() + value.get<double>();
  }
}

}  // namespace

Result<double> usualExposure(FilmJob& job, const Development& how, Progress& progress) {
  if (hasScale(job))
    return 1;
  return exposureFor(job, how, progress);
}

Status writeFilm(FilmJob& job, const std::string& target, Development& development,
                 std::uint64_t maxMemory, Progress& progress, Team& team) {
  VOLUTE_TRY(checkReplacesNothing(target, job.scene.files()));
  return FilmPass(job, target, development, maxMemory, progress, team).run();
}

Result<nlohmann::ordered_json> sumOfFilmStats(const FilmJob& job, Team& team) {
  auto sum = job.stats();
  if (team.size() == 1)
    return sum;
  VOLUTE_ASSIGN(const auto all, team.gatherTexts(sum.dump()));
  for (int rank = 0; rank < team.size(); ++rank) {
    if (rank != team.rank())
      addStats(sum, nlohmann::ordered_json::parse(all[static_cast<std::size_t>(rank)]));
  }
  return sum;
}

}  // namespace volute
