// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "volute/base/advice.hpp"
#include "volute/base/callers_function.hpp"
#include "volute/base/file_name.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/version.hpp"
#include "volute/codec/compress.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/film/render_request.hpp"
#include "volute/film/write_film.hpp"
#ifdef VOLUTE_WITH_GL
#include "volute/gl/gl_scene_renderer.hpp"
#endif
#include "volute/grid/array_source.hpp"
#include "volute/grid/resample.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/output_names.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/scene/kinds.hpp"
#include "volute/scene/own_kind.hpp"
#include "volute/scene/scene_sight.hpp"
#include "volute/tomography/line_reconstruction.hpp"
#include "volute/visibility/sight_engine.hpp"
#include "volute/visibility/sign_file.hpp"
#include "volute/volume_files/memory_volumes.hpp"
#include "volute/volume_files/volume_resampling.hpp"
#include "volute/volute.h"

struct volute_file {
  volute::VoluteReader reader;
  std::string path;
};

struct volute_drawing {
  volute::FilmJob job;
  std::mutex mutex{};  // of it
};

struct volute_scene {
  std::shared_ptr<const volute::MemoryVolumes> volumes{};  // that it looks through
  std::unique_ptr<volute::SightField> field;
  std::mutex mutex;  // of what follows
  std::size_t time = 0;
  std::shared_ptr<const volute::SightSnapshot> snapshot;
};

struct volute_engine {
  volute::SightEngine engine;
};

namespace volute {
namespace {

thread_local std::string lastError;

volute_status statusOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return VOLUTE_INVALID_ARGUMENT;
    case ErrorCode::kNotFound:
      return VOLUTE_NOT_FOUND;
    case ErrorCode::kInvalidData:
      return VOLUTE_INVALID_DATA;
    case ErrorCode::kTruncated:
      return VOLUTE_TRUNCATED;
    case ErrorCode::kUnsupported:
      return VOLUTE_UNSUPPORTED;
    case ErrorCode::kTooLarge:
      return VOLUTE_TOO_LARGE;
    case ErrorCode::kIo:
      return VOLUTE_IO;
    case ErrorCode::kCancelled:
      return VOLUTE_CANCELLED;
  }
  return VOLUTE_INTERNAL;
}

/// How C has a setting; empty: it has none.
std::string settingText(const std::string& setting, const std::string& value) {
  static constexpr std::string_view kMembers[] = {
      "field", "bounds",   "preset", "velocity_unit", "up",  "extinction",
      "fire",  "quantity", "unit",   "air_fields",    "cut", "mass_extinction"};
  static constexpr std::pair<std::string_view, std::string_view> kStructures[] = {
      {"renderer", "view.renderer"},
      {"size", "view.width and view.height"},
      {"exposure", "view.exposure"},
      {"samples", "view.samples"},
      {"shutter", "view.shutter"},
      {"tone", "view.tone"},
      {"time", "view.time"},
      {"frames", "film.first and film.end"},
      {"speed", "film.speed"},
      {"orbit", "film.orbit"},
      {"voxel_size", "voxel_size"},
      {"grids", "grids"},
      {"rms", "rms"},
      {"output", "path"},
      {"height", "view.height"}};
  if (std::ranges::find(kMembers, setting) != std::end(kMembers)) {
    return fmt::format("\"{}\"{}{} in members", setting, value.empty() ? "" : ": ",
                       value.empty() ? "" : '"' + value + '"');
  }
  const auto found = std::ranges::find(kStructures, setting,
                                       &std::pair<std::string_view, std::string_view>::first);
  if (found == std::end(kStructures))
    return "";
  return value.empty() ? std::string(found->second)
                       : fmt::format("{} \"{}\"", found->second, value);
}

/// The same of volute_resampling.
std::string resamplingText(const std::string& setting, const std::string& value) {
  if (setting == "field")
    return value.empty() ? "grids" : fmt::format("grids \"{}\"", value);
  return setting == "bounds" ? "bounds_min and bounds_max" : settingText(setting, value);
}

/// Runs `call`, which returns a Status; nothing that it throws gets any further.
/// @param settings  what advice calls the caller's settings
template <class Call>
volute_status guarded(Call&& call, const SettingText& settings = settingText) noexcept {
  try {
    const Status done = call();
    if (done)
      return VOLUTE_OK;
    lastError = fullText(done.error(), settings);
    return statusOf(done.error().code);
  } catch (const std::bad_alloc&) {
    lastError.clear();  // needs no memory
    lastError = "out of memory";
    return VOLUTE_TOO_LARGE;
  } catch (const OwnMediumFault& fault) {
    lastError = fault.what();
    return VOLUTE_INVALID_DATA;
  } catch (const std::exception& fault) {
    lastError = fault.what();
  } catch (...) {
    lastError = "an unknown fault";
  }
  return VOLUTE_INTERNAL;
}

/// Whether all pointers are there.
template <class... Pointers>
Status given(const char* function, Pointers... pointers) {
  if (((pointers == nullptr) || ...))
    return fail(ErrorCode::kInvalidArgument, "{}: an argument is NULL", function);
  return {};
}

/// @param values  of float or double
template <class Number>
Status readRegion(const VoluteReader& reader, std::int32_t frame, const std::int32_t* begin,
                  const std::int32_t* end, Number* values, std::size_t count) {
  const VolumeInfo& info = reader.info();
  if (frame < 0 || frame >= info.frames) {
    return fail(ErrorCode::kInvalidArgument, "volute_file_read: there is no frame {}; there are {}",
                frame, info.frames);
  }
  if (!begin != !end)
    return fail(ErrorCode::kInvalidArgument,
                "volute_file_read: begin without end, or end without begin");
  std::array<int, 3> from{0, 0, 0}, to{info.z, info.y, info.x};
  const std::array<int, 3> sides = to;
  auto wanted = static_cast<std::size_t>(info.channels);
  for (int axis = 0; axis < 3; ++axis) {
    if (begin) {
      from[axis] = begin[axis];
      to[axis] = end[axis];
    }
    if (from[axis] < 0 || from[axis] >= to[axis] || to[axis] > sides[axis]) {
      return fail(ErrorCode::kInvalidArgument,
                  "volute_file_read: {} to {} on {} is no part of 0 to {}", from[axis], to[axis],
                  "zyx"[axis], sides[axis]);
    }
    wanted *= static_cast<std::size_t>(to[axis] - from[axis]);
  }
  if (count != wanted) {
    return fail(ErrorCode::kInvalidArgument,
                "volute_file_read: room for {} values; the region has {}", count, wanted);
  }
  std::vector<float> own;
  std::span<float> differences;
  if constexpr (std::is_same_v<Number, float>) {
    differences = {values, count};
  } else {
    own.resize(count);
    differences = own;
  }
  VOLUTE_TRY(reader.readRegion(frame, from, to, differences));
  const double offset = reader.offset();
  if (!own.empty() || offset != 0)
    std::ranges::transform(differences, values,
                           [=](float value) { return static_cast<Number>(offset + value); });
  return {};
}

/// From the space of the grid that is read to the world, in each frame; empty: it lies along the
/// axes.
std::vector<GridMatrix> placesOf(const VoluteReader& reader) {
  const auto& description = reader.grid().description;
  return description ? description->places() : std::vector<GridMatrix>();
}

/// Names of files that a function of the caller's reads in this thread, which may be what it fills.
class ReadsOfFunction {
 public:
  ReadsOfFunction() : outer_(std::exchange(running_, this)) {}

  ~ReadsOfFunction() { running_ = outer_; }

  ReadsOfFunction(const ReadsOfFunction&) = delete;
  ReadsOfFunction& operator=(const ReadsOfFunction&) = delete;

  static void note(const std::string& path) {
    if (running_ && std::ranges::find(running_->names_, path) == running_->names_.end())
      running_->names_.push_back(path);
  }

  const std::vector<std::string>& names() const { return names_; }

 private:
  static inline thread_local ReadsOfFunction* running_ = nullptr;
  ReadsOfFunction* outer_;
  std::vector<std::string> names_;
};

/// Frames that the caller's function fills.
class CallerFrames final : public RoundingSource {
 public:
  /// @param target  what they are written to
  CallerFrames(VolumeInfo info, volute_frame_function fill, void* user, std::string target)
      : info_(std::move(info)), fill_(fill), user_(user), target_(std::move(target)) {}

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int index, std::span<float> values) override {
    const CallersFunction running;
    const ReadsOfFunction reads;
    if (fill_(user_, index, values.data(), values.size()) != 0)
      return fail(ErrorCode::kCancelled, "the caller's function stopped at frame {}", index);
    VOLUTE_TRY(checkReplacesNothing(target_, reads.names()));
    for (std::size_t i = 0; offset_ != 0 && i < values.size(); ++i)
      values[i] = static_cast<float>(static_cast<double>(values[i]) - offset_);
    return {};
  }

  double rounding() const override { return 0; }

  double offset() const override { return offset_; }

  bool takesOffset() const override { return true; }

  void takeOffset(double offset) override { offset_ = offset; }

 private:
  VolumeInfo info_;
  volute_frame_function fill_;
  void* user_;
  std::string target_;
  double offset_ = 0;
};

/// Structures of programs that were compiled against an older header are shorter.
template <class Struct>
Status checkSize(const char* function, const char* name, const Struct& given) {
  if (given.size != sizeof(Struct)) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: {}.size is {}; set it to sizeof(volute_{}), which is {}", function, name,
                given.size, name, sizeof(Struct));
  }
  return {};
}

/// What a caller says of a volume.
Result<VolumeInfo> volumeOf(const char* function, const volute_info& said, const double* times) {
  VOLUTE_TRY(checkSize(function, "info", said));
  VolumeInfo info;
  info.frames = said.frames;
  info.z = said.z, info.y = said.y, info.x = said.x;
  info.channels = said.channels;
  if (said.trilinear < 0 || said.trilinear > 2) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: info.trilinear is {}; expected 0 (box), 1 (trilinear) or 2 (cubic)", function,
                said.trilinear);
  }
  info.basis = static_cast<Basis>(said.trilinear);
  const Vec3 low(said.bounds_min[0], said.bounds_min[1], said.bounds_min[2]);
  const Vec3 high(said.bounds_max[0], said.bounds_max[1], said.bounds_max[2]);
  if (times && said.frames > 0)
    info.times.assign(times, times + said.frames);
  if (said.frames > 0)
    info.fillDefaults();
  if (!low.isZero(0) || !high.isZero(0))
    info.bounds = {low, high};  // wrong ones are refused below
  Status valid = info.validate(function);
  if (!valid && valid.error().code == ErrorCode::kInvalidData)
    valid.error().code = ErrorCode::kInvalidArgument;  // no file is
  VOLUTE_TRY(std::move(valid));
  return info;
}

Status compressFrames(const char* function, const char* path, FrameSource& frames, int target,
                      double value) {
  if (extensionOf(path) != ".volute")
    return fail(ErrorCode::kInvalidArgument, "{}: '{}' does not end in .volute", function, path);
  if (target < VOLUTE_RMS || target > VOLUTE_RMS_OVER_ALL || !(value > 0) ||
      !std::isfinite(value)) {
    return fail(
        ErrorCode::kInvalidArgument,
        "{}: target {} of {}; expected VOLUTE_RMS, _PSNR, _RATIO, _SIZE or _MAX_ERROR, and a "
        "number above 0",
        function, target, value);
  }
  using Kind = ErrorTarget::Kind;
  constexpr Kind kKinds[] = {Kind::kRms,  Kind::kPsnr,     Kind::kRatio,
                             Kind::kSize, Kind::kMaxError, Kind::kRmsOverAll};
  CompressOptions options;
  options.target = {kKinds[target], value};
  Progress quiet;
  VOLUTE_TRY(compress(frames, path, options, quiet));
  return {};
}

/// The caller's numbers, where they are.
Result<NumberArray> numbersOf(const char* function, const VolumeInfo& info,
                              const volute_array& array) {
  VOLUTE_TRY(checkSize(function, "array", array));
  VOLUTE_TRY(given(function, array.data));
  const auto type = numberTypeOf(array.type ? array.type : "=f4");
  if (!type) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: array.type is '{}'; expected real numbers as \"<f4\", \"<f8\" or \"|u1\"",
                function, array.type);
  }
  NumberArray numbers{static_cast<const std::byte*>(array.data), *type, denseStrides(info, *type)};
  if (std::ranges::any_of(array.strides, [](std::int64_t stride) { return stride != 0; }))
    std::ranges::copy(array.strides, numbers.strides.begin());
  return numbers;
}

/// Asks the caller now and then.
class CallerProgress final : public Progress {
 public:
  /// @param how  has `progress` and `user`
  template <class Options>
  explicit CallerProgress(const Options& how) : call_(how.progress), user_(how.user) {}

  void report(std::string_view stage, double done, double total) override {
    if (!call_)
      return;
    const std::lock_guard lock(mutex_);
    const CallersFunction running;
    if (!stopped_ && call_(user_, std::string(stage).c_str(), done, total) != 0)
      stopped_ = true;
  }

  bool cancelled() const override { return stopped_; }

 private:
  volute_progress_function call_;
  void* user_;
  std::mutex mutex_;
  std::atomic<bool> stopped_ = false;
};

Result<RenderRequest> requestOf(const volute_view& given) {
  volute_view view{};
  // Programs of before there was a shutter, or a renderer, go on to work.
  if (given.size != offsetof(volute_view, shutter) && given.size != offsetof(volute_view, renderer))
    VOLUTE_TRY(checkSize("volute_drawing_draw", "view", given));
  std::memcpy(&view, &given, given.size);
  RenderRequest request;
  if (view.time)
    request.frames.time = *view.time;
  if (view.camera) {
    const auto camera =
        nlohmann::ordered_json::parse(view.camera, nullptr, /*allow_exceptions=*/false);
    VOLUTE_ASSIGN(request.camera, parseCamera(camera, {"view.camera"}));
  }
  constexpr int kLargest = 32768;
  if (view.width != 0 || view.height != 0) {
    if (std::min(view.width, view.height) < 1 || std::max(view.width, view.height) > kLargest) {
      return fail(ErrorCode::kInvalidArgument,
                  "view: {} x {} pixels; expected 1 to {} on each side", view.width, view.height,
                  kLargest);
    }
    request.size = Pixels{view.width, view.height};
  }
  if (!(view.exposure >= 0) || !std::isfinite(view.exposure) || view.samples < 0 ||
      view.samples > 256 || view.tone < VOLUTE_TONE_AUTO || view.tone > VOLUTE_TONE_SHOULDER) {
    return fail(
        ErrorCode::kInvalidArgument,
        "view: an exposure of {}, {} samples and tone {}; expected 0 or more, 0 to 256, and "
        "VOLUTE_TONE_AUTO to _SHOULDER",
        view.exposure, view.samples, view.tone);
  }
  if (!(view.shutter >= 0 && view.shutter <= 1)) {
    return fail(ErrorCode::kInvalidArgument, "view: a shutter of {}; expected 0 to 1",
                view.shutter);
  }
  request.exposure = view.exposure;
  request.shutter = view.shutter;
  if (view.samples > 0)
    request.samples = view.samples;
  if (view.tone != VOLUTE_TONE_AUTO)
    request.tone = static_cast<ToneCurve>(view.tone - VOLUTE_TONE_NONE);
  if (view.display)
    VOLUTE_TRY(takeTone(view.display, request));
  return request;
}

Result<ResampleRequest> requestOf(const volute_resampling& how) {
  constexpr const char* kFunction = "volute_resample";
  VOLUTE_TRY(checkSize(kFunction, "resampling", how));
  ResampleRequest request;
  request.fields = how.grids ? how.grids : "";
  request.like = how.like ? how.like : "";
  const Vec3 voxel(how.voxel_size[0], how.voxel_size[1], how.voxel_size[2]);
  const Vec3 low(how.bounds_min[0], how.bounds_min[1], how.bounds_min[2]);
  const Vec3 high(how.bounds_max[0], how.bounds_max[1], how.bounds_max[2]);
  const bool sized = voxel != Vec3::Zero(), bounded = low != high;
  if (!(how.rms >= 0 && how.rms <= 1) || (sized && !(voxel.minCoeff() > 0)) ||
      (bounded && !((high - low).minCoeff() > 0)) || (bounded && !request.like.empty())) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: expected sizes of voxels above 0, or none, bounds with min below max, or none "
                "where there is `like`, and an rms from 0 to 1",
                kFunction);
  }
  if (sized)
    request.voxelSize = voxel;
  if (bounded)
    request.bounds = Box3{low, high};
  if (how.rms > 0)
    request.rms = how.rms;
  return request;
}

Result<std::unique_ptr<SceneRenderer>> rendererNamed(const std::string& name) {
  if (name == "cpu")
    return std::make_unique<CpuRenderer>();
  if (name != "gl")
    return fail(ErrorCode::kInvalidArgument, "view.renderer: '{}'; expected cpu or gl", name);
#ifdef VOLUTE_WITH_GL
  return createGlRenderer(false);
#else
  return fail(ErrorCode::kUnsupported, "view.renderer: this build has no OpenGL");
#endif
}

/// draw() with the renderer that the view names, for it alone: a context of OpenGL belongs to its
/// thread.
template <class Draw>
std::invoke_result_t<Draw> drawnBy(const volute_view& view, FilmJob& job, Draw&& draw) {
  const bool named = view.size == sizeof(volute_view) && view.renderer;
  if (!named)
    return draw();
  VOLUTE_ASSIGN(auto renderer, rendererNamed(view.renderer));
  std::swap(job.renderer, renderer);
  auto done = draw();
  std::swap(job.renderer, renderer);
  return done;
}

/// @param caller  in errors
/// @param draw  draw(job, development, progress) gives the picture
template <class Draw>
Result<Image> drawn(std::string_view caller, volute_drawing& drawing, const volute_view& view,
                    std::size_t room, const Draw& draw) {
  VOLUTE_ASSIGN(const auto request, requestOf(view));
  VOLUTE_ASSIGN(const auto lock, waitFor(drawing.mutex, "the drawing"));
  CallerProgress progress(view);
  VOLUTE_TRY(prepare(drawing.job, request, SceneOptions().maxMemory, progress));
  const Camera& camera = drawing.job.camera;
  const std::size_t needed =
      std::size_t{3} * static_cast<std::size_t>(camera.width() * camera.height());
  if (room != needed) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: room for {} values; a picture of {} x {} pixels has {}", caller, room,
                camera.width(), camera.height(), needed);
  }
  return drawnBy(view, drawing.job, [&]() -> Result<Image> {
    VOLUTE_ASSIGN(auto development, developmentOf(request, drawing.job));
    return draw(drawing.job, development, progress);
  });
}

Result<FrameRequest> requestOf(const volute_film& film, const char* path) {
  VOLUTE_TRY(checkSize("volute_drawing_film", "film", film));
  FrameRequest request{.target = path};
  if (!std::isfinite(film.speed) || film.speed < 0 || !std::isfinite(film.orbit)) {
    return fail(ErrorCode::kInvalidArgument,
                "film: a speed of {} and an orbit of {} degrees; expected 0 or more, and a number",
                film.speed, film.orbit);
  }
  if (film.first != 0 || film.end != 0)
    request.frames = FrameRange{film.first, film.end};
  if (film.speed > 0)
    request.speed = film.speed;
  if (film.orbit != 0)
    request.orbit = film.orbit;
  return request;
}

Status writeFilmOf(volute_drawing& drawing, const volute_view& view, const volute_film* film,
                   const char* path) {
  VOLUTE_ASSIGN(auto request, requestOf(view));
  if (request.frames.time) {
    return fail(ErrorCode::kInvalidArgument,
                "view: a film has its times by `first` and `end`; leave `time` out");
  }
  const volute_film all{sizeof(volute_film), 0, 0, 0, 0};
  VOLUTE_ASSIGN(request.frames, requestOf(film ? *film : all, path));
  VOLUTE_ASSIGN(const auto lock, waitFor(drawing.mutex, "the drawing"));
  CallerProgress progress(view);
  const std::uint64_t maxMemory = SceneOptions().maxMemory;
  return drawnBy(view, drawing.job, [&]() -> Status {
    VOLUTE_TRY(prepare(drawing.job, request, maxMemory, progress));
    VOLUTE_ASSIGN(auto development, developmentOf(request, drawing.job));
    Team alone;
    return writeFilm(drawing.job, path, development, maxMemory, progress, alone);
  });
}

/// The scene at a stored time. It is read once; lines are looked along without the lock.
Result<std::shared_ptr<const SightSnapshot>> snapshotOf(volute_scene& scene, std::size_t time) {
  VOLUTE_ASSIGN(const auto lock, waitFor(scene.mutex, "the scene"));
  if (time >= scene.field->times().size()) {
    return fail(ErrorCode::kInvalidArgument, "volute_scene_look: there is no time {}; there are {}",
                time, scene.field->times().size());
  }
  if (scene.snapshot && time < scene.time) {
    return fail(ErrorCode::kInvalidArgument,
                "volute_scene_look: time {} after time {}; open the scene again to go back", time,
                scene.time);
  }
  if (!scene.snapshot || time != scene.time) {
    VOLUTE_ASSIGN(scene.snapshot, scene.field->read(time));
    scene.time = time;
  }
  return scene.snapshot;
}

/// More is no array's: the size of a negative number, say.
Status checkCount(const char* function, std::size_t count) {
  constexpr std::size_t kMax = std::size_t{1} << 48;
  if (count > kMax)
    return fail(ErrorCode::kInvalidArgument, "{}: a count of {}; expected at most {}", function,
                count, kMax);
  return {};
}

/// Whether places are finite and near enough for numbers to have room for a centimetre.
bool isPlace(std::span<const double> place) {
  constexpr double kFarthest = 1e12;  // [m]
  return std::ranges::all_of(place, [](double at) { return std::abs(at) <= kFarthest; });
}

Status look(const SightSnapshot& snapshot, const double* lines, std::size_t count,
            volute_sight* sights) {
  VOLUTE_TRY(checkCount("volute_scene_look", count));
  for (std::size_t i = 0; i < count; ++i) {
    if (!isPlace({lines + 6 * i, 6}))
      return fail(ErrorCode::kInvalidArgument,
                  "volute_scene_look: line {} is not finite, or beyond 1e12 m", i);
  }
  parallelRanges(count, 64, [&](std::size_t begin, std::size_t end) {
    std::vector<SightLine> asked(end - begin);
    std::vector<Sight> seen(end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      const double* line = lines + 6 * i;
      asked[i - begin] = {Vec3(line[0], line[1], line[2]), Vec3(line[3], line[4], line[5])};
    }
    snapshot.look(asked, seen);
    for (std::size_t i = begin; i < end; ++i) {
      const Sight& sight = seen[i - begin];
      const Sighting known = judged({.covered = sight.covered}, sight.depth, sight.low, sight.high);
      sights[i] = {known.depth, known.low, known.high, sight.covered, sight.blocked};
    }
  });
  return {};
}

/// Eyes of agents, which must be finite.
Result<std::vector<Vec3>> eyesOf(const double* eyes, std::size_t agents, const char* function) {
  VOLUTE_TRY(checkCount(function, agents));
  std::vector<Vec3> places(agents);
  for (std::size_t i = 0; i < agents; ++i) {
    places[i] = Vec3(eyes[3 * i], eyes[3 * i + 1], eyes[3 * i + 2]);
    if (!isPlace({eyes + 3 * i, 3}))
      return fail(ErrorCode::kInvalidArgument,
                  "{}: the place of agent {} is not finite, or beyond 1e12 m", function, i);
  }
  return places;
}

Status checkTime(double time, const char* function) {
  if (!std::isfinite(time))
    return fail(ErrorCode::kInvalidArgument, "{}: the time is not finite", function);
  return {};
}

Status copyTimes(std::span<const double> from, double* times, std::size_t count) {
  if (count != from.size()) {
    return fail(ErrorCode::kInvalidArgument, "room for {} times; there are {}", count, from.size());
  }
  std::ranges::copy(from, times);
  return {};
}

}  // namespace
}  // namespace volute

using volute::guarded;
using volute::Status;

const char* volute_version(void) {
  return VOLUTE_VERSION;
}

const char* volute_error(void) {
  return volute::lastError.c_str();
}

volute_status volute_file_open(const char* path, volute_file** file) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_file_open", path, file));
    *file = nullptr;
    VOLUTE_ASSIGN(auto reader, volute::VoluteReader::open(path));
    *file = new volute_file{std::move(reader), path};
    return {};
  });
}

volute_status volute_file_open_grid(const char* path, const char* grid, volute_file** file) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_file_open_grid", path, grid, file));
    *file = nullptr;
    volute::VoluteReader::Options options;
    options.grid = grid;
    options.differences = volute::Offsets::kAll;
    VOLUTE_ASSIGN(auto reader, volute::VoluteReader::open(path, options));
    *file = new volute_file{std::move(reader), path};
    return {};
  });
}

size_t volute_file_grids(const volute_file* file) {
  return file ? file->reader.grids().size() : 0;
}

const char* volute_file_grid_name(const volute_file* file, size_t grid) {
  return grid < volute_file_grids(file) ? file->reader.grids()[grid].info.name.c_str() : nullptr;
}

int32_t volute_file_grid_is_empty(const volute_file* file, size_t grid) {
  return grid < volute_file_grids(file) && file->reader.grids()[grid].empty;
}

void volute_file_close(volute_file* file) {
  delete file;
}

volute_status volute_file_info(const volute_file* file, volute_info* info) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_file_info", file, info));
    VOLUTE_TRY(volute::checkSize("volute_file_info", "info", *info));
    const volute::VolumeInfo& from = file->reader.info();
    info->frames = from.frames;
    const bool empty = file->reader.grid().empty;
    info->z = empty ? 0 : from.z, info->y = empty ? 0 : from.y, info->x = empty ? 0 : from.x;
    info->channels = from.channels;
    info->trilinear = static_cast<std::int32_t>(from.basis);
    const auto places = volute::placesOf(file->reader);
    const volute::Box3 bounds =
        places.empty() ? from.bounds : volute::aroundPlaces(from.bounds, places);
    for (int axis = 0; axis < 3; ++axis) {
      info->bounds_min[axis] = bounds.min[axis];
      info->bounds_max[axis] = bounds.max[axis];
    }
    info->max_error = file->reader.header().reachedMaxError;
    return {};
  });
}

volute_status volute_file_matrix(const volute_file* file, int32_t frame, double matrix[12],
                                 int32_t* along_axes) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_file_matrix", file, matrix));
    const volute::VolumeInfo& info = file->reader.info();
    if (frame < 0 || frame >= info.frames) {
      return volute::fail(volute::ErrorCode::kInvalidArgument,
                          "volute_file_matrix: there is no frame {}; there are {}", frame,
                          info.frames);
    }
    const auto places = volute::placesOf(file->reader);
    std::ranges::copy(volute::indexToWorld(info, places, static_cast<std::size_t>(frame)), matrix);
    if (along_axes)
      *along_axes = places.empty();
    return {};
  });
}

const char* volute_file_name(const volute_file* file) {
  return file ? file->reader.info().name.c_str() : "";
}

const char* volute_file_unit(const volute_file* file) {
  return file ? file->reader.info().unit.c_str() : "";
}

volute_status volute_file_times(const volute_file* file, double* times, size_t frames) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_file_times", file, times));
    return volute::copyTimes(file->reader.info().times, times, frames);
  });
}

volute_status volute_file_read(const volute_file* file, int32_t frame, const int32_t begin[3],
                               const int32_t end[3], float* values, size_t count) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_file_read", file, values));
    volute::ReadsOfFunction::note(file->path);
    return volute::readRegion(file->reader, frame, begin, end, values, count);
  });
}

volute_status volute_file_read_double(const volute_file* file, int32_t frame,
                                      const int32_t begin[3], const int32_t end[3], double* values,
                                      size_t count) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_file_read_double", file, values));
    volute::ReadsOfFunction::note(file->path);
    return volute::readRegion(file->reader, frame, begin, end, values, count);
  });
}

volute_status volute_resample(const char* path, const char* target, const volute_resampling* how) {
  const auto resample = [&]() -> Status {
    VOLUTE_TRY(volute::given("volute_resample", path, target, how));
    VOLUTE_ASSIGN(const auto request, volute::requestOf(*how));
    volute::CallerProgress progress(*how);
    volute::Reading reading{progress, volute::SceneOptions().maxMemory};
    volute::Team alone;
    auto done = volute::resampleVolume(path, target, request, reading, alone);
    if (!done)
      return tl::unexpected<volute::Error>(
          volute::renamed(std::move(done.error()), "field", "grids"));
    return {};
  };
  return guarded(resample, volute::resamplingText);
}

volute_status volute_compress(const char* path, const volute_info* info, const double* times,
                              volute_frame_function fill, void* user, int target, double value) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_compress", path, info, fill));
    VOLUTE_ASSIGN(auto volume, volute::volumeOf("volute_compress", *info, times));
    volute::CallerFrames frames(std::move(volume), fill, user, path);
    VOLUTE_TRY(volute::settleOffset(frames));
    return volute::compressFrames("volute_compress", path, frames, target, value);
  });
}

volute_status volute_compress_array(const char* path, const volute_info* info, const double* times,
                                    const volute_array* array, int target, double value) {
  constexpr const char* kName = "volute_compress_array";
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given(kName, path, info, array));
    VOLUTE_ASSIGN(auto volume, volute::volumeOf(kName, *info, times));
    VOLUTE_ASSIGN(auto numbers, volute::numbersOf(kName, volume, *array));
    volute::ArraySource source(std::move(volume), std::move(numbers));
    VOLUTE_TRY(volute::settleOffset(source));
    return volute::compressFrames(kName, path, source, target, value);
  });
}

int32_t volute_set_threads(int32_t count) {
  static std::mutex mutex;
  static auto* limit = new std::unique_ptr<volute::ThreadLimit>;  // no order at the end matters
  const std::lock_guard lock(mutex);
  if (count < 0) {
    volute::lastError = fmt::format("volute_set_threads: {} threads; expected 0 or more", count);
    return -1;
  }
  const int before = volute::threadCount();
  limit->reset();  // a lower one would hold
  *limit = std::make_unique<volute::ThreadLimit>(count);
  return before;
}

namespace volute {
namespace {

/// What the caller's function gives.
ValueFunction functionOf(volute_value_function value, void* user) {
  return [value, user](const PlacesAtTime& at, std::span<float> values) -> Status {
    const CallersFunction running;
    if (value(user, at.time, at.x.data(), at.y.data(), at.z.data(), at.x.size(), values.data()) !=
        0) {
      return fail(ErrorCode::kCancelled, "the caller's function stopped at {:g} s", at.time);
    }
    return {};
  };
}

/// Opens a file, or values in memory, for pictures or lines of sight.
struct Opening {
  explicit Opening(const char* function) : function(function) {}

  const char* function;  ///< of C
  nlohmann::ordered_json members = nlohmann::ordered_json::object();
  std::string path{};
  std::shared_ptr<MemoryVolumes> volumes = std::make_shared<MemoryVolumes>();

  Status takeMembers(const char* text) {
    if (text)
      members = nlohmann::ordered_json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!members.is_object())
      return fail(ErrorCode::kInvalidArgument,
                  "{}: members are no JSON object; expected {{\"name\": value}}", function);
    for (const char* name : {"file", "case"}) {
      if (members.contains(name))
        return fail(ErrorCode::kInvalidArgument,
                    "{}: members: \"{}\" is what is opened; leave it out", function, name);
    }
    return {};
  }

  /// @param values  an array or a function
  template <class Values>
  Status take(VolumeInfo info, Values values) {
    for (auto [name, text] : {std::pair{"name", &info.name}, {"unit", &info.unit}}) {
      const auto said = members.find(name);
      if (said == members.end())
        continue;
      if (!said->is_string())
        return fail(ErrorCode::kInvalidArgument, "{}: members: \"{}\" is no text", function, name);
      *text = said->template get<std::string>();
      members.erase(name);
    }
    path = "memory:values";
    return volumes->add("values", std::move(info), std::move(values));
  }

  Status take(MemoryMesh mesh) {
    path = "memory:mesh.vtu";
    return volumes->add("mesh", std::move(mesh));
  }

  SceneOptions options() const {
    SceneOptions options;
    options.members = members;
    options.files.volumes = volumes;
    return options;
  }

  Result<volute_drawing*> drawing() const {
    SceneOptions how = options();
    addUsualMembers(path, {}, how);
    Progress quiet;
    VOLUTE_ASSIGN(auto scene, Scene::open(path, how, quiet));
    FilmJob job{std::move(scene), Camera::framing({}, 1, 1), {}, std::make_unique<CpuRenderer>()};
    return new volute_drawing{std::move(job)};
  }

  Result<volute_scene*> scene() const {
    Progress quiet;
    VOLUTE_ASSIGN(auto field, openSight(path, options(), quiet));
    auto made = std::make_unique<volute_scene>();
    made->volumes = volumes;
    made->field = std::move(field);
    return made.release();
  }
};

Status open(Opening& opening, volute_drawing** drawing) {
  VOLUTE_ASSIGN(*drawing, opening.drawing());
  return {};
}

Status open(Opening& opening, volute_scene** scene) {
  VOLUTE_ASSIGN(*scene, opening.scene());
  return {};
}

template <class Handle>
volute_status openFile(const char* function, const char* path, const char* members,
                       Handle** handle) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(given(function, path, handle));
    *handle = nullptr;
    Opening opening(function);
    VOLUTE_TRY(opening.takeMembers(members));
    opening.path = path;
    return open(opening, handle);
  });
}

template <class Handle>
volute_status openArray(const char* function, const volute_info* info, const double* times,
                        const volute_array* array, const char* members, Handle** handle) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(given(function, info, array, handle));
    *handle = nullptr;
    Opening opening(function);
    VOLUTE_TRY(opening.takeMembers(members));
    VOLUTE_ASSIGN(auto volume, volumeOf(function, *info, times));
    VOLUTE_ASSIGN(auto numbers, numbersOf(function, volume, *array));
    VOLUTE_TRY(opening.take(std::move(volume), std::move(numbers)));
    return open(opening, handle);
  });
}

template <class Handle>
volute_status openFunction(const char* function, const volute_info* info, const double* times,
                           volute_value_function value, void* user, const char* members,
                           Handle** handle) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(given(function, info, value, handle));
    *handle = nullptr;
    Opening opening(function);
    VOLUTE_TRY(opening.takeMembers(members));
    VOLUTE_ASSIGN(auto volume, volumeOf(function, *info, times));
    VOLUTE_TRY(opening.take(std::move(volume), functionOf(value, user)));
    return open(opening, handle);
  });
}

Result<MemoryMesh> meshOf(const char* function, const volute_mesh& given) {
  VOLUTE_TRY(checkSize(function, "mesh", given));
  VOLUTE_TRY(volute::given(function, given.points, given.cells, given.values));
  const std::size_t times = std::max<std::size_t>(given.time_count, 1);
  if (times > 1)
    VOLUTE_TRY(volute::given(function, given.times));
  static constexpr std::pair<int, CellShape> kShapes[] = {{4, CellShape::kTet},
                                                          {5, CellShape::kPyramid},
                                                          {6, CellShape::kWedge},
                                                          {8, CellShape::kHexahedron}};
  const auto shape =
      std::ranges::find(kShapes, given.cell_points, &std::pair<int, CellShape>::first);
  constexpr std::size_t kMax = std::size_t{1} << 40;
  if (shape == std::end(kShapes) || given.point_count > kMax || given.cell_count > kMax ||
      times > kMax) {
    return fail(
        ErrorCode::kInvalidArgument,
        "{}: {} points, and {} cells of {} points each, at {} times; expected cells of 4, 5, "
        "6 or 8 points",
        function, given.point_count, given.cell_count, given.cell_points, times);
  }
  MemoryMesh mesh;
  mesh.cells.vertices.reserve(given.point_count);
  for (std::size_t i = 0; i < given.point_count; ++i)
    mesh.cells.vertices.emplace_back(given.points[3 * i], given.points[3 * i + 1],
                                     given.points[3 * i + 2]);
  const auto corners = static_cast<std::size_t>(given.cell_points);
  mesh.cells.shapes.assign(given.cell_count, shape->second);
  mesh.cells.connectivity.assign(given.cells, given.cells + corners * given.cell_count);
  for (std::size_t i = 0; i <= given.cell_count; ++i)
    mesh.cells.offsets.push_back(static_cast<std::int64_t>(corners * i));
  if (given.times)
    mesh.times.assign(given.times, given.times + times);
  MemoryMesh::Field field{given.field ? given.field : "density", given.of_cells != 0, {}};
  const std::size_t count = field.ofCells ? given.cell_count : given.point_count;
  for (std::size_t i = 0; i < times; ++i)
    field.values.emplace_back(given.values + i * count, given.values + (i + 1) * count);
  mesh.fields.push_back(std::move(field));
  return mesh;
}

template <class Handle>
volute_status openMesh(const char* function, const volute_mesh* mesh, const char* members,
                       Handle** handle) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(given(function, mesh, handle));
    *handle = nullptr;
    Opening opening(function);
    VOLUTE_TRY(opening.takeMembers(members));
    VOLUTE_ASSIGN(auto taken, meshOf(function, *mesh));
    VOLUTE_TRY(opening.take(std::move(taken)));
    return open(opening, handle);
  });
}

Result<std::vector<LineMeasurement>> linesOf(const char* function, const volute_lines& given) {
  VOLUTE_TRY(checkSize(function, "lines", given));
  VOLUTE_TRY(volute::given(function, given.ends, given.depths));
  VOLUTE_TRY(checkCount(function, given.count));
  std::vector<LineMeasurement> lines;
  for (std::size_t i = 0; i < given.count; ++i) {
    const double* ends = given.ends + 6 * i;
    const Vec3 from(ends[0], ends[1], ends[2]), to(ends[3], ends[4], ends[5]);
    const double length = (to - from).norm(), sigma = given.sigmas ? given.sigmas[i] : 1;
    if (!(length > 0) || !std::isfinite(length) || !std::isfinite(given.depths[i]) ||
        !(sigma > 0) || !std::isfinite(sigma)) {
      return fail(
          ErrorCode::kInvalidArgument,
          "{}: line {} has a length of {:g} m, a depth of {:g} and a sigma of {:g}; expected "
          "finite numbers, and length and sigma above 0",
          function, i, length, given.depths[i], sigma);
    }
    lines.push_back({{from, (to - from) / length, 0, length}, given.depths[i], sigma});
    lines.back().row = static_cast<int>(i) + 1;
  }
  return lines;
}

}  // namespace
}  // namespace volute

volute_status volute_lines_solve(const volute_lines* lines, const volute_info* info, float* values,
                                 size_t count) {
  constexpr const char* kName = "volute_lines_solve";
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given(kName, lines, info, values));
    VOLUTE_ASSIGN(const auto volume, volute::volumeOf(kName, *info, nullptr));
    if (volume.frames != 1 || volume.channels != 1 || volume.basis == volute::Basis::kCubic ||
        count != volume.values()) {
      return volute::fail(
          volute::ErrorCode::kInvalidArgument,
          "{}: room for {} values, {} frames, {} channels and basis {}; expected as "
          "many as voxels, one frame, one channel, and basis 0 or 1",
          kName, count, volume.frames, volume.channels, info->trilinear);
    }
    VOLUTE_ASSIGN(const auto measured, volute::linesOf(kName, *lines));
    volute::CallerProgress progress(*lines);
    volute::LineOptions how;
    how.basis = volume.basis;
    VOLUTE_ASSIGN(const auto found,
                  volute::reconstructLines(
                      measured, {volume.bounds, {volume.x, volume.y, volume.z}}, how, progress));
    std::ranges::copy(found.volume, values);
    return {};
  });
}

volute_status volute_drawing_open(const char* path, const char* members, volute_drawing** drawing) {
  return volute::openFile("volute_drawing_open", path, members, drawing);
}

volute_status volute_drawing_open_array(const volute_info* info, const double* times,
                                        const volute_array* array, const char* members,
                                        volute_drawing** drawing) {
  return volute::openArray("volute_drawing_open_array", info, times, array, members, drawing);
}

volute_status volute_drawing_open_mesh(const volute_mesh* mesh, const char* members,
                                       volute_drawing** drawing) {
  return volute::openMesh("volute_drawing_open_mesh", mesh, members, drawing);
}

volute_status volute_drawing_open_function(const volute_info* info, const double* times,
                                           volute_value_function value, void* user,
                                           const char* members, volute_drawing** drawing) {
  return volute::openFunction("volute_drawing_open_function", info, times, value, user, members,
                              drawing);
}

volute_status volute_medium_register(const volute_medium_kind* kind) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_medium_register", kind));
    volute::registerUsualMedia();
    return volute::registerOwnKind(*kind);
  });
}

void volute_drawing_close(volute_drawing* drawing) {
  delete drawing;
}

size_t volute_drawing_time_count(const volute_drawing* drawing) {
  return drawing ? drawing->job.scene.times().size() : 0;
}

volute_status volute_drawing_times(const volute_drawing* drawing, double* times, size_t count) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_drawing_times", drawing, times));
    return volute::copyTimes(drawing->job.scene.times(), times, count);
  });
}

volute_status volute_drawing_draw(volute_drawing* drawing, const volute_view* view,
                                  unsigned char* rgb, size_t bytes) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_drawing_draw", drawing, view, rgb));
    VOLUTE_ASSIGN(const auto image, volute::drawn("volute_drawing_draw", *drawing, *view, bytes,
                                                  [](auto& job, auto& how, auto& progress) {
                                                    return volute::visiblePicture(job, how,
                                                                                  progress);
                                                  }));
    std::ranges::copy(volute::toSrgb8(image), rgb);
    return {};
  });
}

volute_status volute_drawing_light(volute_drawing* drawing, const volute_view* view, float* rgb,
                                   size_t count) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_drawing_light", drawing, view, rgb));
    VOLUTE_ASSIGN(const auto image, volute::drawn("volute_drawing_light", *drawing, *view, count,
                                                  [](auto& job, auto& how, auto& progress) {
                                                    return volute::linearPicture(job, how,
                                                                                 progress);
                                                  }));
    std::ranges::copy(image.pixels, rgb);
    return {};
  });
}

volute_status volute_drawing_film(volute_drawing* drawing, const volute_view* view,
                                  const volute_film* film, const char* path) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_drawing_film", drawing, view, path));
    return volute::writeFilmOf(*drawing, *view, film, path);
  });
}

volute_status volute_scene_open(const char* path, volute_scene** scene) {
  return volute::openFile("volute_scene_open", path, nullptr, scene);
}

volute_status volute_scene_open_file(const char* path, const char* members, volute_scene** scene) {
  return volute::openFile("volute_scene_open_file", path, members, scene);
}

volute_status volute_scene_open_array(const volute_info* info, const double* times,
                                      const volute_array* array, const char* members,
                                      volute_scene** scene) {
  return volute::openArray("volute_scene_open_array", info, times, array, members, scene);
}

volute_status volute_scene_open_mesh(const volute_mesh* mesh, const char* members,
                                     volute_scene** scene) {
  return volute::openMesh("volute_scene_open_mesh", mesh, members, scene);
}

volute_status volute_scene_open_function(const volute_info* info, const double* times,
                                         volute_value_function value, void* user,
                                         const char* members, volute_scene** scene) {
  return volute::openFunction("volute_scene_open_function", info, times, value, user, members,
                              scene);
}

void volute_scene_close(volute_scene* scene) {
  delete scene;
}

size_t volute_scene_time_count(const volute_scene* scene) {
  return scene ? scene->field->times().size() : 0;
}

volute_status volute_scene_times(const volute_scene* scene, double* times, size_t count) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_scene_times", scene, times));
    return volute::copyTimes(scene->field->times(), times, count);
  });
}

volute_status volute_scene_look(volute_scene* scene, size_t time, const double* lines, size_t count,
                                volute_sight* sights) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_scene_look", scene, lines, sights));
    VOLUTE_ASSIGN(const auto snapshot, volute::snapshotOf(*scene, time));
    return volute::look(*snapshot, lines, count, sights);
  });
}

volute_status volute_engine_open(const char* path, const char* signs, volute_engine** engine) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_engine_open", path, signs, engine));
    *engine = nullptr;
    volute::Progress quiet;
    VOLUTE_ASSIGN(const auto read, volute::readSigns(signs));
    VOLUTE_ASSIGN(auto field, volute::openSight(path, {}, quiet));
    VOLUTE_ASSIGN(auto made, volute::SightEngine::open(std::move(field), read,
                                                       volute::usualCriteria(), quiet));
    *engine = std::make_unique<volute_engine>(volute_engine{std::move(made)}).release();
    return {};
  });
}

void volute_engine_close(volute_engine* engine) {
  delete engine;
}

size_t volute_engine_sign_count(const volute_engine* engine) {
  return engine ? engine->engine.signs().size() : 0;
}

const char* volute_engine_sign_name(const volute_engine* engine, size_t sign) {
  return sign < volute_engine_sign_count(engine) ? engine->engine.signs()[sign].sign.name.c_str()
                                                 : nullptr;
}

size_t volute_engine_criterion_count(const volute_engine* engine) {
  return engine ? engine->engine.criteria().size() : 0;
}

const char* volute_engine_criterion_name(const volute_engine* engine, size_t criterion) {
  return criterion < volute_engine_criterion_count(engine)
             ? engine->engine.criteria()[criterion].name.c_str()
             : nullptr;
}

double volute_engine_criterion_limit(const volute_engine* engine, size_t criterion) {
  return criterion < volute_engine_criterion_count(engine)
             ? engine->engine.criteria()[criterion].limit
             : std::nan("");
}

volute_status volute_engine_sees(volute_engine* engine, double time, const double* eyes,
                                 size_t agents, unsigned char* seen) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_engine_sees", engine, eyes, seen));
    VOLUTE_TRY(volute::checkTime(time, "volute_engine_sees"));
    VOLUTE_ASSIGN(const auto places, volute::eyesOf(eyes, agents, "volute_engine_sees"));
    std::vector<volute::Seen> found(engine->engine.signs().size() * agents);
    VOLUTE_TRY(engine->engine.sees(places, time, found));
    std::ranges::transform(found, seen,
                           [](volute::Seen one) { return static_cast<unsigned char>(one); });
    return {};
  });
}

volute_status volute_engine_dose(volute_engine* engine, double time, const int64_t* ids,
                                 const double* eyes, size_t agents, double* values) {
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given("volute_engine_dose", engine, ids, eyes, values));
    VOLUTE_TRY(volute::checkTime(time, "volute_engine_dose"));
    VOLUTE_ASSIGN(const auto places, volute::eyesOf(eyes, agents, "volute_engine_dose"));
    return engine->engine.dose({ids, agents}, places, time,
                               {values, engine->engine.criteria().size() * agents});
  });
}

volute_status volute_engine_dose_at_worst(volute_engine* engine, double time, const int64_t* ids,
                                          const double* eyes, size_t agents, double* values,
                                          double* worst) {
  constexpr const char* kName = "volute_engine_dose_at_worst";
  return guarded([&]() -> Status {
    VOLUTE_TRY(volute::given(kName, engine, ids, eyes, values, worst));
    VOLUTE_TRY(volute::checkTime(time, kName));
    VOLUTE_ASSIGN(const auto places, volute::eyesOf(eyes, agents, kName));
    const std::size_t size = engine->engine.criteria().size() * agents;
    return engine->engine.dose({ids, agents}, places, time, {values, size}, {worst, size});
  });
}
