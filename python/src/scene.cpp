// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// volute._scene: scenes, pictures, lines of sight, and volumes from pictures.

#include "volute/scene/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "bridge.hpp"
#include "volute/base/parallel.hpp"
#include "volute/capture/geometry_check.hpp"
#include "volute/capture/open_capture.hpp"
#include "volute/codec/compress.hpp"
#include "volute/film/render_request.hpp"
#include "volute/film/write_film.hpp"
#ifdef VOLUTE_WITH_GL
#include "volute/gl/gl_scene_renderer.hpp"
#endif
#include "volute/image/srgb.hpp"
#include "volute/io/image_file.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/scene/scene_renderer.hpp"
#include "volute/scene/scene_sight.hpp"
#include "volute/tenability/walking_speed.hpp"
#include "volute/tomography/capture_refinement.hpp"
#include "volute/tomography/line_volumes.hpp"
#include "volute/tomography/reconstructed_frames.hpp"
#include "volute/tomography/reconstruction_report.hpp"
#include "volute/tomography/soot_frames.hpp"
#include "volute/visibility/criteria_file.hpp"
#include "volute/visibility/eyes.hpp"
#include "volute/visibility/sight_engine.hpp"
#include "volute/visibility/sign_file.hpp"
#include "volute/visibility/survey.hpp"
#include "volute/volume_files/memory_volumes.hpp"
#include "volute/volume_files/volume_resampling.hpp"
#include "volute/volume_files/volume_writer.hpp"

namespace volute::python {
namespace {

using OrderedJson = nlohmann::ordered_json;
using Points = py::array_t<double, py::array::c_style | py::array::forcecast>;

OrderedJson jsonOf(const std::string& text) {
  return OrderedJson::parse(text);  // json.dumps wrote it
}

/// Beyond [m] numbers have no room for a centimetre.
constexpr double kFarthest = 1e12;

std::vector<Vec3> pointsOf(const Points& points, const char* what) {
  if (points.ndim() != 2 || points.shape(1) != 3)
    throw py::value_error(fmt::format("{}: expected shape (n, 3), x y z in metres", what));
  std::vector<Vec3> result(static_cast<std::size_t>(points.shape(0)));
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double* p = points.data() + 3 * i;
    result[i] = Vec3(p[0], p[1], p[2]);
    if (!result[i].allFinite())
      throw py::value_error(fmt::format("{}: point {} is not finite", what, i));
    if (result[i].cwiseAbs().maxCoeff() > kFarthest) {
      throw py::value_error(
          fmt::format("{}: point {} is at ({:g}, {:g}, {:g}); expected at most {:g} m", what, i,
                      p[0], p[1], p[2], kFarthest));
    }
  }
  return result;
}

py::tuple boundsTuple(const Box3& box) {
  const auto point = [](const Vec3& v) { return py::make_tuple(v.x(), v.y(), v.z()); };
  return py::make_tuple(point(box.min), point(box.max));
}

SceneOptions sceneOptions(const std::string& members, std::uint64_t maxMemory) {
  SceneOptions options;
  options.maxMemory = maxMemory;
  options.members = jsonOf(members);
  return options;
}

/// (name, array or Function, shape, what is said of it) of each volume in memory; of a mesh (name,
/// Mesh, None, None).
using Volumes =
    std::vector<std::tuple<std::string, py::object, std::optional<Shape>, std::optional<py::dict>>>;

/// What it raises goes through all that reads it, and ends the call.
ValueFunction valuesOf(const py::object& function) {
  return [kept = keptObject(function)](const PlacesAtTime& at, std::span<float> values) -> Status {
    const PythonFunction running;
    const auto numbers = [](std::span<const double> from) {
      return py::array_t<double>(static_cast<py::ssize_t>(from.size()), from.data());
    };
    const py::array_t<float, py::array::c_style | py::array::forcecast> found =
        kept->attr("_values")(numbers(at.x), numbers(at.y), numbers(at.z), at.time);
    std::copy_n(found.data(), values.size(), values.data());
    return {};
  };
}

/// What volute.Mesh has checked.
MemoryMesh meshOf(const py::object& mesh) {
  const auto numbersIn = [](const auto& array) {
    return std::vector(array.data(), array.data() + array.size());
  };
  const auto [points, corners, offsets, shapes] =
      mesh.attr("_cells")
          .cast<std::tuple<py::array_t<double>, py::array_t<std::int64_t>,
                           py::array_t<std::int64_t>, py::array_t<std::uint8_t>>>();
  MemoryMesh made;
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    const double* at = points.data(i, 0);
    made.cells.vertices.emplace_back(at[0], at[1], at[2]);
  }
  made.cells.connectivity = numbersIn(corners);
  made.cells.offsets = numbersIn(offsets);
  for (const std::uint8_t shape : numbersIn(shapes))
    made.cells.shapes.push_back(static_cast<CellShape>(shape));
  made.times = mesh.attr("times").cast<std::vector<double>>();
  using Fields = std::vector<std::tuple<std::string, bool, py::array_t<float>>>;
  for (const auto& [name, ofCells, values] : mesh.attr("_fields").cast<Fields>()) {
    MemoryMesh::Field& field = made.fields.emplace_back();
    field.name = name, field.ofCells = ofCells;
    for (py::ssize_t time = 0; time < values.shape(0); ++time)
      field.values.emplace_back(values.data(time), values.data(time) + values.shape(1));
  }
  return made;
}

/// The arrays of volumes are borrowed, and kept.
void addVolumes(MemoryVolumes& to, const Volumes& volumes) {
  for (const auto& [name, values, shape, said] : volumes) {
    take(!shape || !said ? to.add(name, meshOf(values))
         : py::isinstance<py::array>(values)
             ? to.add(name, infoOf(*shape, *said), numbersOf(values))
             : to.add(name, infoOf(*shape, *said), valuesOf(values)));
  }
}

py::array_t<float> arrayOf(Image&& image) {
  std::vector<py::ssize_t> shape{image.height, image.width};
  if (image.channels != 1)
    shape.push_back(image.channels);
  return owned(std::move(image.pixels), std::move(shape));
}

Image imageOf(const py::array_t<float, py::array::c_style | py::array::forcecast>& array) {
  const bool colour = array.ndim() == 3 && array.shape(2) == 3;
  if (!colour && array.ndim() != 2)
    throw py::value_error("a picture has shape (height, width) or (height, width, 3)");
  Image image(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)), colour ? 3 : 1);
  std::copy_n(array.data(), image.pixels.size(), image.pixels.data());
  return image;
}

/// What Python's own part asks of a picture.
RenderRequest requestOf(const py::dict& said) {
  RenderRequest request;
  const auto given = [&](const char* key) { return said.contains(key) && !said[key].is_none(); };
  if (given("target"))
    request.frames.target = said["target"].cast<std::string>();
  if (given("time"))
    request.frames.time = said["time"].cast<double>();
  if (given("frames")) {
    const auto frames = said["frames"].cast<std::array<int, 2>>();
    request.frames.frames = FrameRange{frames[0], frames[1]};
  }
  if (given("speed"))
    request.frames.speed = said["speed"].cast<double>();
  if (given("orbit"))
    request.frames.orbit = said["orbit"].cast<double>();
  if (given("camera"))
    request.camera = take(parseCamera(jsonOf(said["camera"].cast<std::string>()), {"camera"}));
  if (given("size")) {
    const auto size = said["size"].cast<std::array<int, 2>>();
    constexpr int kLargest = 32768;
    if (std::ranges::any_of(size, [](int side) { return side < 1 || side > kLargest; })) {
      throw Failure{Error{ErrorCode::kInvalidArgument,
                          fmt::format("size: {} x {} pixels; expected 1 to {} on each side",
                                      size[0], size[1], kLargest)}};
    }
    request.size = Pixels{size[0], size[1]};
  }
  if (given("background")) {
    const auto light = said["background"].cast<std::array<double, 3>>();
    request.background = Rgb(light[0], light[1], light[2]);
  }
  const auto choice = [&](const char* key) {
    return given(key) ? said[key].cast<std::string>() : std::string();
  };
  const std::string aov = choice("aov"), tone = choice("tone"), colors = choice("colormap");
  request.aov = aov == "optical-depth"   ? Aov::kOpticalDepth
                : aov == "transmittance" ? Aov::kTransmittance
                                         : Aov::kNone;
  if (!tone.empty()) {
    if (const Status taken = takeTone(tone, request); !taken)
      throw Failure{taken.error()};
  }
  if (!colors.empty())
    request.colors = colors == "viridis" ? ColorMap::kViridis : ColorMap::kInferno;
  if (given("measured"))
    request.measured = said["measured"].cast<bool>();
  if (given("exposure"))
    request.exposure = said["exposure"].cast<double>();
  if (given("bloom"))
    request.bloom = said["bloom"].cast<double>();
  if (given("shutter"))
    request.shutter = said["shutter"].cast<double>();
  if (given("samples"))
    request.samples = said["samples"].cast<int>();
  if (given("legend"))
    request.legend = said["legend"].cast<bool>();
  return request;
}

/// A scene that is open. Calls from several threads wait for each other.
class PythonScene {
 public:
  PythonScene(Scene scene, std::shared_ptr<MemoryVolumes> volumes, std::uint64_t maxMemory)
      : job_{std::move(scene), Camera::framing({}, 1, 1), {}, std::make_unique<CpuRenderer>()},
        volumes_(std::move(volumes)),
        maxMemory_(maxMemory) {}

  /// Names of files that are no UTF-8 have U+FFFD in place of what is not.
  std::string json() const {
    return job_.scene.json().dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
  }

  py::object path() const { return pathText(job_.scene.path()); }

  py::tuple bounds() const { return boundsTuple(job_.scene.bounds()); }

  std::vector<double> times() const { return job_.scene.times(); }

  std::vector<std::tuple<std::string, py::object, std::string>> media() const {
    std::vector<std::tuple<std::string, py::object, std::string>> result;
    for (const auto& medium : job_.scene.media()) {
      const MediumInfo& info = medium->info();
      result.emplace_back(info.what, pathText(info.file), info.size);
    }
    return result;
  }

  void change(const std::string& json, const Volumes& volumes, const py::object& listener) {
    MemoryVolumes more;
    addVolumes(more, volumes);
    run(listener, [&](Progress& progress) -> Status {
      VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the scene"));
      volumes_->add(more);
      return job_.scene.change(jsonOf(json), progress);
    });
  }

  /// Lets go of volumes in memory but those of these names.
  void keep(const std::vector<std::string>& names) {
    run(py::none(), [&](Progress&) -> Status {
      VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the scene"));
      volumes_->keep(names);
      return {};
    });
  }

  /// Light, as a .exr has it.
  py::array_t<float> render(const py::dict& said, const py::object& listener) {
    const RenderRequest request = requestOf(said);
    const auto renderer = said["renderer"].cast<std::string>();
    return arrayOf(run(listener, [&](Progress& progress) -> Result<Image> {
      VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the scene"));
      return drawnBy(renderer, [&]() -> Result<Image> {
        VOLUTE_TRY(prepare(job_, request, maxMemory_, progress));
        VOLUTE_ASSIGN(const auto development, developmentOf(request, job_));
        return linearPicture(job_, development, progress);
      });
    }));
  }

  /// Bytes, as a .png has them.
  py::array_t<std::uint8_t> picture(const py::dict& said, const py::object& listener) {
    const RenderRequest request = requestOf(said);
    const auto renderer = said["renderer"].cast<std::string>();
    const Image image = run(listener, [&](Progress& progress) -> Result<Image> {
      VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the scene"));
      return drawnBy(renderer, [&]() -> Result<Image> {
        VOLUTE_TRY(prepare(job_, request, maxMemory_, progress));
        VOLUTE_ASSIGN(auto development, developmentOf(request, job_));
        return visiblePicture(job_, development, progress);
      });
    });
    std::vector<py::ssize_t> shape{image.height, image.width};
    if (image.channels != 1)
      shape.push_back(image.channels);
    return owned(toSrgb8(image), std::move(shape));
  }

  void film(const py::dict& said, const py::object& listener) {
    const RenderRequest request = requestOf(said);
    const auto renderer = said["renderer"].cast<std::string>();
    run(listener, [&](Progress& progress) -> Status {
      VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the scene"));
      return drawnBy(renderer, [&]() -> Status {
        VOLUTE_TRY(prepare(job_, request, maxMemory_, progress));
        VOLUTE_ASSIGN(auto development, developmentOf(request, job_));
        Team alone;
        return writeFilm(job_, request.frames.target, development, maxMemory_, progress, alone);
      });
    });
  }

 private:
  /// draw() with a renderer for it alone: a context of OpenGL belongs to its thread.
  template <class Draw>
  std::invoke_result_t<Draw> drawnBy(const std::string& name, Draw&& draw) {
    VOLUTE_ASSIGN(auto renderer, rendererNamed(name));
    std::swap(job_.renderer, renderer);
    auto drawn = draw();
    std::swap(job_.renderer, renderer);
    return drawn;
  }

  static Result<std::unique_ptr<SceneRenderer>> rendererNamed(const std::string& name) {
    if (name != "gl") {
      return std::make_unique<CpuRenderer>(name == "reference" ? Renderer::kReference
                                                               : Renderer::kCpu);
    }
#ifdef VOLUTE_WITH_GL
    return createGlRenderer(false);
#else
    return fail(ErrorCode::kUnsupported, "this build has no OpenGL");
#endif
  }

  FilmJob job_;
  std::shared_ptr<MemoryVolumes> volumes_;  // that job_.scene finds by name
  std::uint64_t maxMemory_;
  std::mutex mutex_;
};

/// @param scene  JSON of a scene that is in no file; empty: `path` is a file
Result<std::unique_ptr<SightField>> lookedThrough(const std::string& path, const std::string& scene,
                                                  const SceneOptions& options, Progress& progress) {
  if (scene.empty())
    return openSight(path, options, progress);
  VOLUTE_ASSIGN(auto made, Scene::make(jsonOf(scene), path, options, progress));
  return sightOf(std::move(made), options, progress);
}

/// Remarks on a field: of the reader of its files, and on the extinction that was read so far.
class FieldRemarks {
 public:
  FieldRemarks() = default;

  /// @param reader  what was told while the field was opened
  explicit FieldRemarks(std::vector<Remark> reader) : reader_(std::move(reader)) {}

  /// What is new and to be told: again where other doubts have come up, or none is left. The caller
  /// tells it without a lock: who is told may ask for sentences().
  /// @param all  whether the field was read at all of its times
  [[nodiscard]] std::vector<Remark> judge(const SightField& field, bool all) {
    const auto largest = field.largestRead();
    if (!largest)
      return {};
    largest_ = std::max(largest_, *largest);  // a field that was opened again begins anew
    auto found = field.remarksOn(largest_);
    if (!all) {
      // Times that were not read may bring more: what is too little for now is not told.
      const auto lasting = doubtsOf(field.remarksOn(kBeyondAll));
      std::erase_if(found, [&](const Remark& remark) {
        return remark.code == RemarkCode::kDoubtful &&
               std::ranges::find(lasting, lettersOf(remark)) == lasting.end();
      });
    }
    if (found.empty())
      return {};
    const bool changed = extinction_.empty() || doubtsOf(found) != doubtsOf(extinction_);
    extinction_ = std::move(found);
    return changed ? extinction_ : std::vector<Remark>();
  }

  std::vector<std::string> sentences() const {
    std::vector<std::string> all;
    for (const auto* some : {&reader_, &extinction_}) {
      for (const Remark& remark : *some) {
        std::string text = fullText(remark, argumentText);
        if (std::ranges::find(all, text) == all.end())
          all.push_back(std::move(text));
      }
    }
    return all;
  }

 private:
  /// The doubts among remarks, without the numbers in them.
  static std::vector<std::string> doubtsOf(const std::vector<Remark>& remarks) {
    std::vector<std::string> doubts;
    for (const Remark& remark : remarks) {
      if (remark.code == RemarkCode::kDoubtful)
        doubts.push_back(lettersOf(remark));
    }
    return doubts;
  }

  static std::string lettersOf(const Remark& remark) {
    std::string letters;
    std::ranges::copy_if(remark.sentence, std::back_inserter(letters),
                         [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); });
    return letters;
  }

  static constexpr double kBeyondAll = 1e12;  // [1/m]; a piece of metal is clear beside it

  std::vector<Remark> reader_, extinction_;
  double largest_ = 0;  // [1/m], that was read
};

/// Sentences, with names of files in them that need not be UTF-8.
py::list textsOf(const std::vector<std::string>& sentences) {
  py::list texts;
  for (const std::string& sentence : sentences) texts.append(pathText(sentence));
  return texts;
}

/// Passes each remark on once.
class OnceTold final : public Progress {
 public:
  explicit OnceTold(Progress& next) : next_(next) {}

  void report(std::string_view stage, double done, double total) override {
    next_.report(stage, done, total);
  }

  void remark(const Remark& remark) override {
    if (std::ranges::find(told_, remark) != told_.end())
      return;
    told_.push_back(remark);
    next_.remark(remark);
  }

  bool cancelled() const override { return next_.cancelled(); }

  const std::vector<Remark>& told() const { return told_; }

 private:
  Progress& next_;
  std::vector<Remark> told_;
};

/// As scenes and their files are opened by the command: one that sees.
class Sight {
 public:
  /// @param scene  as lookedThrough() takes it
  Sight(std::string path, const std::string& members, std::string scene, const Volumes& volumes,
        std::uint64_t maxMemory, const py::object& listener)
      : path_(std::move(path)),
        scene_(std::move(scene)),
        options_(sceneOptions(members, maxMemory)) {
    const auto own = std::make_shared<MemoryVolumes>();
    addVolumes(*own, volumes);
    options_.files.volumes = own;
    run(listener, [&](Progress& progress) -> Status {
      VOLUTE_ASSIGN(auto told, open(progress));
      remarks_ = FieldRemarks(std::move(told));
      return {};
    });
  }

  std::vector<double> times() const { return known().times; }

  std::size_t timeCount() const {
    const std::lock_guard lock(knownMutex_);
    return known_.times.size();
  }

  py::tuple bounds() const { return boundsTuple(known().bounds); }

  py::object description() const { return pathText(known().description); }

  py::list remarks() const {
    const std::lock_guard lock(knownMutex_);
    return textsOf(remarks_.sentences());
  }

  /// Depths of lines at a stored time.
  py::array look(std::size_t time, const Points& eyes, const Points& targets,
                 const py::object& listener) {
    const auto from = pointsOf(eyes, "eyes");
    const auto to = pointsOf(targets, "targets");
    if (from.size() != to.size())
      throw py::value_error(
          fmt::format("{} eyes and {} targets; expected as many", from.size(), to.size()));
    py::array_t<LineSight> out(static_cast<py::ssize_t>(from.size()));
    LineSight* sights = out.mutable_data();
    run(listener, [&](Progress& progress) -> Status {
      VOLUTE_ASSIGN(const auto at, snapshot(time, progress));
      constexpr std::size_t kAtOnce = 1 << 14;  // between which one may ask to stop
      for (std::size_t first = 0; first < from.size(); first += kAtOnce) {
        if (progress.cancelled())
          return fail(ErrorCode::kCancelled, "stopped");
        parallelRanges(
            std::min(kAtOnce, from.size() - first), 64, [&](std::size_t begin, std::size_t end) {
              begin += first, end += first;
              std::vector<SightLine> lines;
              for (std::size_t i = begin; i < end; ++i) lines.push_back({from[i], to[i]});
              std::vector<volute::Sight> seen(lines.size());
              at->look(lines, seen);
              for (std::size_t i = begin; i < end; ++i) {
                const volute::Sight& s = seen[i - begin];
                const Sighting known = judged({.covered = s.covered}, s.depth, s.low, s.high);
                sights[i] = {known.depth, known.low, known.high, s.covered, s.blocked};
              }
            });
      }
      return judge(progress);
    });
    return out;
  }

  /// What eyes make of signs at stored times, shape (time, sign, eye).
  py::array survey(const std::vector<std::size_t>& times, const std::string& signsFile,
                   const Points& eyes, const py::object& listener) {
    const auto from = pointsOf(eyes, "eyes");
    std::vector<Sighting> all;
    std::size_t signCount = 0;
    run(listener, [&](Progress& progress) -> Status {
      VOLUTE_ASSIGN(const auto signs, readSigns(signsFile));
      signCount = signs.size();
      const std::size_t each = signs.size() * from.size();
      all.resize(times.size() * each);
      for (std::size_t t = 0; t < times.size(); ++t) {
        if (progress.cancelled())
          return fail(ErrorCode::kCancelled, "stopped");
        VOLUTE_ASSIGN(const auto at, snapshot(times[t], progress));
        VOLUTE_ASSIGN(const auto targets, placeSigns(*at, signs, known().bounds, progress));
        lookAround(*at, targets, from, std::span(all).subspan(t * each, each));
        progress.report("looking", static_cast<double>(t + 1), static_cast<double>(times.size()));
      }
      return judge(progress);
    });
    py::array_t<SignSight> out({times.size(), signCount, from.size()});
    std::ranges::transform(all, out.mutable_data(), [](const Sighting& s) {
      return SignSight{s.distance,         s.angle,        s.depth,   s.low,     s.high,
                       s.meanExtinction(), s.visibility(), s.covered, s.blocked, s.visible,
                       s.certainly,        s.possibly};
    });
    return out;
  }

  std::vector<std::string> signNames(const std::string& file) const {
    std::vector<std::string> names;
    for (const SafetySign& sign : take(readSigns(file))) names.push_back(sign.name);
    return names;
  }

  struct LineSight {
    double depth, low, high;
    bool covered, blocked;
  };

  struct SignSight {
    double distance, angle, depth, low, high, mean_extinction, visibility;
    bool covered, blocked, visible, certainly, possibly;
  };

 private:
  struct Known {
    std::vector<double> times;
    Box3 bounds;
    std::string description;
  };

  Known known() const {
    const std::lock_guard lock(knownMutex_);
    return known_;
  }

  /// @return what was told
  Result<std::vector<Remark>> open(Progress& progress) {
    OnceTold log(progress);
    snapshot_ = nullptr;
    VOLUTE_ASSIGN(field_, lookedThrough(path_, scene_, options_, log));
    Known now{
        {field_->times().begin(), field_->times().end()}, field_->bounds(), field_->description()};
    {
      const std::lock_guard lock(knownMutex_);
      known_ = std::move(now);
    }
    for (const Remark& remark : field_->remarks()) log.remark(remark);
    return log.told();
  }

  /// After what was read.
  Status judge(Progress& progress) {
    std::vector<Remark> told;
    {
      VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the Sight"));
      const std::lock_guard brief(knownMutex_);
      told = remarks_.judge(*field_, read_.size() == known_.times.size());
    }
    for (const Remark& remark : told) progress.remark(remark);
    return {};
  }

  /// Fields are read forwards: for an earlier time they are opened again.
  Result<std::shared_ptr<const SightSnapshot>> snapshot(std::size_t time, Progress& progress) {
    VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the Sight"));
    if (time >= known_.times.size()) {
      return fail(ErrorCode::kInvalidArgument, "there is no stored time {}; there are {}", time,
                  known_.times.size());
    }
    if (snapshot_ && time < time_) {
      Progress quiet;  // it has told
      VOLUTE_TRY(open(quiet));
    }
    if (!snapshot_ || time != time_) {
      if (progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped");
      VOLUTE_ASSIGN(snapshot_, field_->read(time));
      time_ = time;
      read_.insert(time);
    }
    return snapshot_;
  }

  std::string path_, scene_;
  SceneOptions options_;
  std::mutex mutex_;  // of what follows
  std::unique_ptr<SightField> field_;
  std::shared_ptr<const SightSnapshot> snapshot_;
  std::size_t time_ = 0;
  std::set<std::size_t> read_;     // times
  mutable std::mutex knownMutex_;  // of what is asked for at any time; held briefly
  Known known_;                    // written with both
  FieldRemarks remarks_;           // the same
};

/// Who sees which sign, and what people take in, asked again and again while time goes on.
class Engine {
 public:
  using Ids = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;
  using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

  Engine(const std::string& path, const std::string& members, const std::string& scene,
         const Volumes& volumes, const std::string& signsFile, const std::string& criteriaFile,
         std::uint64_t maxMemory, const py::object& listener) {
    SceneOptions options = sceneOptions(members, maxMemory);
    const auto own = std::make_shared<MemoryVolumes>();
    addVolumes(*own, volumes);
    options.files.volumes = own;
    run(listener, [&](Progress& progress) -> Status {
      VOLUTE_ASSIGN(const auto signs, readSigns(signsFile));
      VOLUTE_ASSIGN(const auto criteria, criteriaOf(criteriaFile.empty() ? "usual" : criteriaFile));
      OnceTold log(progress);
      VOLUTE_ASSIGN(field_, lookedThrough(path, scene, options, log));
      VOLUTE_ASSIGN(auto made, SightEngine::open(field_, signs, criteria.criteria, log));
      engine_ = std::make_unique<SightEngine>(std::move(made));
      remarks_ = FieldRemarks(log.told());
      return {};
    });
  }

  py::list remarks() const {
    const std::lock_guard lock(remarksMutex_);
    return textsOf(remarks_.sentences());
  }

  std::vector<double> times() const { return {engine_->times().begin(), engine_->times().end()}; }

  std::vector<std::string> signs() const {
    std::vector<std::string> names;
    for (const SightTarget& sign : engine_->signs()) names.push_back(sign.sign.name);
    return names;
  }

  py::array signPlaces() const {
    const auto& signs = engine_->signs();
    py::array_t<double> out({signs.size(), std::size_t{3}});
    for (std::size_t i = 0; i < signs.size(); ++i)
      std::copy_n(signs[i].target.data(), 3, out.mutable_data() + 3 * i);
    return out;
  }

  /// (name, limit, unit) of each.
  std::vector<std::tuple<std::string, double, std::string>> criteria() const {
    std::vector<std::tuple<std::string, double, std::string>> all;
    for (const Criterion& one : engine_->criteria())
      all.emplace_back(one.name, one.limit, std::string(one.unit()));
    return all;
  }

  /// (criterion, why) of what cannot be assessed.
  std::vector<std::pair<std::string, std::string>> missing() const {
    std::vector<std::pair<std::string, std::string>> all;
    for (const auto& one : engine_->missing()) all.emplace_back(one.criterion.name, one.why);
    return all;
  }

  /// Shape (sign, agent).
  py::array sees(double time, const Points& eyes, const py::object& listener) {
    const auto from = eyesOf(time, eyes);
    std::vector<Seen> seen(engine_->signs().size() * from.size());
    ask(time, listener, [&] { return engine_->sees(from, time, seen); });
    py::array_t<std::uint8_t> out({engine_->signs().size(), from.size()});
    std::ranges::transform(seen, out.mutable_data(),
                           [](Seen one) { return static_cast<std::uint8_t>(one); });
    return out;
  }

  /// Shape (criterion, agent).
  /// @param worst  by the worst that the files allow
  py::array dose(double time, const Ids& ids, const Points& eyes, bool worst,
                 const py::object& listener) {
    const auto from = eyesOf(time, eyes);
    if (ids.ndim() != 1 || static_cast<std::size_t>(ids.shape(0)) != from.size())
      throw py::value_error(fmt::format("ids: expected shape ({},), one an agent", from.size()));
    py::array_t<double> out({engine_->criteria().size(), from.size()});
    const std::span all(out.mutable_data(), static_cast<std::size_t>(out.size()));
    std::vector<double> means(worst ? all.size() : 0);
    ask(time, listener, [&] {
      const std::span<const std::int64_t> people(ids.data(), from.size());
      return worst ? engine_->dose(people, from, time, means, all)
                   : engine_->dose(people, from, time, all);
    });
    return out;
  }

  py::array extinction(double time, const Points& eyes, const py::object& listener) {
    const auto from = eyesOf(time, eyes);
    py::array_t<double> out(static_cast<py::ssize_t>(from.size()));
    ask(time, listener,
        [&] { return engine_->extinction(from, time, {out.mutable_data(), from.size()}); });
    return out;
  }

  /// Of the speeds `clear` without smoke; NaN where the smoke is not known.
  py::array walkingSpeed(double time, const Points& eyes, const Numbers& clear,
                         const std::string& lawName, const py::object& listener) {
    py::array out = extinction(time, eyes, listener);
    const SpeedLaw law = run(py::none(), [&](Progress&) { return speedLaw(lawName); });
    if (clear.size() != out.size())
      throw py::value_error(fmt::format("clear: expected one speed an agent, {}", out.size()));
    const std::span speeds(static_cast<double*>(out.mutable_data()),
                           static_cast<std::size_t>(out.size()));
    for (std::size_t i = 0; i < speeds.size(); ++i) {
      if (!std::isnan(speeds[i]))
        speeds[i] = volute::walkingSpeed(law, clear.data()[i], speeds[i]);
    }
    return out;
  }

 private:
  static std::vector<Vec3> eyesOf(double time, const Points& eyes) {
    if (!std::isfinite(time))
      throw py::value_error("time: expected a finite number of seconds");
    return pointsOf(eyes, "eyes");
  }

  /// One thread at a time.
  template <class Question>
  void ask(double time, const py::object& listener, const Question& question) {
    run(listener, [&](Progress& progress) -> Status {
      std::vector<Remark> told;
      {
        VOLUTE_ASSIGN(const auto lock, waitFor(mutex_, "the Engine"));
        VOLUTE_TRY(question());
        const std::lock_guard brief(remarksMutex_);
        told = remarks_.judge(*field_, readAll(time));
      }
      for (const Remark& remark : told) progress.remark(remark);
      return {};
    });
  }

  /// Whether all stored times were read, those around this one [s] among them.
  bool readAll(double time) {
    const std::span<const double> times = engine_->times();
    const auto after = std::ranges::lower_bound(times, time);
    if (after != times.end()) {
      const auto index = static_cast<std::size_t>(after - times.begin());
      if (*after == time || index > 0)
        read_.insert(index);
      if (*after != time && index > 0)
        read_.insert(index - 1);
    }
    return read_.size() == times.size();
  }

  std::mutex mutex_;
  std::shared_ptr<SightField> field_;  // the engine's
  std::unique_ptr<SightEngine> engine_;
  std::set<std::size_t> read_;       // stored times
  mutable std::mutex remarksMutex_;  // held briefly, also inside mutex_
  FieldRemarks remarks_;
};

/// People of a file of trajectories at a time.
class PythonTrajectories {
 public:
  PythonTrajectories(const std::string& text, const std::string& file, std::optional<double> height,
                     double eyeHeight)
      : walks_(run(py::none(),
                   [&](Progress&) { return Trajectories::parse(text, file, height, eyeHeight); })) {
  }

  py::list remarks() const {
    std::vector<std::string> sentences;
    for (const Remark& remark : walks_.remarks()) sentences.push_back(remark.sentence);
    return textsOf(sentences);
  }

  py::tuple span() const { return py::make_tuple(walks_.begin(), walks_.end()); }

  std::vector<int> ids() const { return {walks_.ids().begin(), walks_.ids().end()}; }

  /// Ids, and places of shape (person, 3).
  py::tuple at(double time) const {
    const auto people = walks_.at(time);
    py::array_t<std::int64_t> ids(static_cast<py::ssize_t>(people.size()));
    py::array_t<double> eyes({people.size(), std::size_t{3}});
    for (std::size_t i = 0; i < people.size(); ++i) {
      ids.mutable_data()[i] = people[i].id;
      std::copy_n(people[i].eye.data(), 3, eyes.mutable_data() + 3 * i);
    }
    return py::make_tuple(ids, eyes);
  }

 private:
  Trajectories walks_;
};

ReconstructionSettings settingsOf(const OrderedJson& said, const Capture& capture,
                                  std::uint64_t maxMemory) {
  ReconstructionSettings settings;
  TomographyOptions& options = settings.tomography;
  const auto take = [&](const char* key, auto& to) {
    if (said.contains(key))
      to = said[key].get<std::decay_t<decltype(to)>>();
  };
  const auto takeOptional = [&]<class T>(const char* key, std::optional<T>& to) {
    if (said.contains(key))
      to = said[key].get<T>();
  };
  options.basis = said.value("basis", "trilinear") == "box" ? Basis::kBox : Basis::kTrilinear;
  options.solver = *tomographySolverByName(said.value("solver", "apg"));
  options.regularization = *regularizationByName(said.value("regularization", "auto"));
  takeOptional("lambda", options.lambda);
  takeOptional("sparsity", options.sparsity);
  takeOptional("iterations", options.iterations);
  takeOptional("noise_sigma", options.noiseSigma);
  take("rays_per_pixel", options.raysPerPixel);
  take("hull", options.hull);
  take("coarse_to_fine", options.coarseToFine);
  take("warm_start", settings.warmStart);
  take("force", settings.force);
  take("error_bars", settings.errorBars);
  take("temperature", settings.flame);
  if (!options.noiseSigma)
    options.noiseSigma = capture.noiseSigma;
  options.maxMemory = maxMemory;
  return settings;
}

CaptureOptions captureOptions(const OrderedJson& said, std::uint64_t maxMemory) {
  CaptureOptions options;
  options.maxMemory = maxMemory;
  if (said.contains("images"))
    options.images = said["images"].get<std::string>();
  if (said.contains("bounds")) {
    const auto b = said["bounds"].get<std::array<std::array<double, 3>, 2>>();
    options.bounds = Box3{Vec3(b[0][0], b[0][1], b[0][2]), Vec3(b[1][0], b[1][1], b[1][2])};
  }
  if (said.contains("resolution"))
    options.resolution = said["resolution"].get<std::array<int, 3>>();
  if (said.contains("frames")) {
    const auto range = said["frames"].get<std::array<int, 2>>();
    options.frames = {range[0], range[1]};
  }
  return options;
}

Status checkGeometryOf(const Capture& capture, bool force, Progress& progress) {
  for (const GeometryFault& fault : checkGeometry(capture)) {
    if (!force)
      return fail(ErrorCode::kInvalidData, "{}: {} (force=True goes on)", capture.file.string(),
                  fault.message);
    progress.remark("warning: " + fault.message);
  }
  return {};
}

/// Values of shape (t, z, y, x, c) where `output` is empty; else a .volute file is written.
py::tuple reconstructCapture(const std::string& path, const std::string& output, double rms,
                             const std::string& optionsJson, std::uint64_t maxMemory,
                             const py::object& listener) {
  using namespace py::literals;
  const OrderedJson said = jsonOf(optionsJson);
  std::vector<float> values, sigma;
  VolumeInfo info;
  OrderedJson report;
  run(listener, [&](Progress& progress) -> Status {
    VOLUTE_ASSIGN(const Capture given, openCapture(path, captureOptions(said, maxMemory)));
    for (const auto& remark : given.remarks) progress.remark(remark);
    const auto heldOut = said.value("hold_out", std::vector<std::string>{});
    const ReconstructionSettings settings = settingsOf(said, given, maxMemory);
    VOLUTE_TRY(checkVolumeSize({given.volume.bounds, given.volume.resolution}, maxMemory));
    if (settings.flame && (!given.spectrum.stated() || given.measured != Measured::kEmission))
      return fail(ErrorCode::kInvalidArgument,
                  "temperature: {} states no \"spectrum\" of light that the medium sends itself",
                  given.file.string());
    VOLUTE_TRY(checkGeometryOf(given, settings.force, progress));
    const bool refine = said.value("refine", true);
    VOLUTE_ASSIGN(const CaptureRefinement refinement,
                  refineCapture(given, heldOut, refine ? Refine::kAuto : Refine::kNever, maxMemory,
                                progress));
    const Capture& capture = refinement.capture;
    VOLUTE_ASSIGN(const auto frames,
                  ReconstructedFrames::open(capture, settings, heldOut,
                                            output.empty() ? "-" : output, progress));
    const Status done = [&]() -> Status {
      VOLUTE_TRY(frames->solveAll());
      VOLUTE_ASSIGN(report, reconstructionReport(refinement, settings, *frames));
      info = frames->info();
      if (!output.empty()) {
        std::vector<WrittenGrid> grids{{frames.get(), rms}};
        if (settings.errorBars)
          grids.push_back({&frames->errorBars(), std::max(rms, 5e-3)});
        std::optional<SootFrames> soot;
        if (settings.flame) {
          soot.emplace(*frames, capture.spectrum);
          for (FrameSource* grid : soot->grids()) grids.push_back({grid, rms});
          VOLUTE_ASSIGN(report["soot"], soot->json());
        }
        Reading reading{progress, maxMemory};
        Team alone;
        Report written;
        VOLUTE_ASSIGN(auto writer, VolumeWriter::open(std::move(grids), output,
                                                      fmt::format("reconstructed from {}",
                                                                  capture.file.filename().string()),
                                                      reading, alone));
        return writer.write(written);
      }
      if (info.rawBytes() * (settings.errorBars ? 2 : 1) > maxMemory) {
        return fail(
            ErrorCode::kTooLarge,
            "{} MiB of values, more than the {} MiB allowed; give `output` or raise max_memory",
            (info.rawBytes() >> 20) + 1, maxMemory >> 20);
      }
      values.resize(info.values());
      sigma.resize(settings.errorBars ? values.size() : 0);
      for (int i = 0; i < info.frames; ++i) {
        const auto begin = i * info.frameValues();
        VOLUTE_TRY(frames->readFrame(i, std::span(values).subspan(begin, info.frameValues())));
        if (settings.errorBars)
          VOLUTE_TRY(frames->errorBars().readFrame(
              i, std::span(sigma).subspan(begin, info.frameValues())));
      }
      return {};
    }();
    frames->work().leave(done.has_value());  // what was finished serves when the call is made again
    return done;
  });
  py::object array = py::none(), bars = py::none();
  if (output.empty()) {
    if (!sigma.empty())
      bars = owned(std::move(sigma), {info.frames, info.z, info.y, info.x, info.channels});
    array = owned(std::move(values), {info.frames, info.z, info.y, info.x, info.channels});
  }
  const py::dict place("grid"_a = info.name, "unit"_a = info.unit,
                       "bounds"_a = boundsTuple(info.bounds), "times"_a = info.times,
                       "frame_numbers"_a = info.frameNumbers,
                       "basis"_a = std::string(basisName(info.basis)));
  return py::make_tuple(array, place, report.dump(), bars);
}

/// (ends (n, 6), values (n,), sigmas (n,), frame of each (n,)) of measured lines, and times of
/// frames.
LineFile linesOf(const py::tuple& said) {
  using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
  const auto ends = said[0].cast<Doubles>(), values = said[1].cast<Doubles>();
  const auto sigmas = said[2].cast<std::optional<Doubles>>();
  const auto frames = said[3].cast<std::vector<int>>();
  const auto times = said[4].cast<std::vector<double>>();
  LineFile lines;
  lines.opticalDepths = lines.hasTimes = true;
  lines.hasSigma = sigmas.has_value();
  for (std::size_t i = 0; i < times.size(); ++i)
    lines.frames.push_back({static_cast<int>(i), times[i], {}});
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double* end = ends.data() + 6 * i;
    const Vec3 from(end[0], end[1], end[2]), to(end[3], end[4], end[5]);
    const double length = (to - from).norm();
    lines.frames[static_cast<std::size_t>(frames[i])].lines.push_back(
        {{from, (to - from) / length, 0, length},
         values.data()[i],
         sigmas ? sigmas->data()[i] : 1,
         static_cast<int>(i) + 1});
  }
  return lines;
}

/// Of a .csv, or of what linesOf() takes: (values (t, z, y, x), where they are, report).
py::tuple reconstructFromLines(const py::object& source, const std::string& options,
                               std::uint64_t maxMemory, const py::object& listener) {
  const auto said = jsonOf(options);
  const CaptureOptions where = captureOptions(said, maxMemory);
  LineOptions how;
  if (said.value("basis", "box") == "trilinear")
    how.basis = Basis::kTrilinear;
  if (said.contains("lambda"))
    how.lambda = said["lambda"].get<double>();
  if (said.contains("iterations"))
    how.iterations = said["iterations"].get<int>();
  const bool leaveOut = said.value("force", false);
  const bool isFile = py::isinstance<py::bytes>(source);
  const auto file = isFile ? source.cast<std::string>() : std::string("lines");
  LineFile lines = isFile ? LineFile() : linesOf(source.cast<py::tuple>());
  LineVolumes found = run(listener, [&](Progress& progress) {
    return isFile ? reconstructLineFile(file, where, how, leaveOut, progress)
                  : reconstructLineFrames(std::move(lines), file, where, how, leaveOut, progress);
  });
  using namespace py::literals;
  const VolumeInfo& info = found.volumes.info;
  const py::dict place("grid"_a = info.name, "unit"_a = info.unit,
                       "bounds"_a = boundsTuple(info.bounds), "times"_a = info.times,
                       "frame_numbers"_a = info.frameNumbers,
                       "basis"_a = std::string(basisName(info.basis)));
  return py::make_tuple(
      owned(std::move(found.volumes.values), {info.frames, info.z, info.y, info.x}), place,
      found.records.dump());
}

/// `volute resample`.
void resampleFile(const std::string& path, const std::string& target, const py::dict& said,
                  std::uint64_t maxMemory, const py::object& listener) {
  ResampleRequest request;
  const auto given = [&](const char* key) { return !said[key].is_none(); };
  request.fields = said["grids"].cast<std::string>();
  request.like = said["like"].cast<std::string>();
  request.rms = said["rms"].cast<double>();
  request.basis = *basisNamed(said["basis"].cast<std::string>());
  if (given("frames")) {
    const auto frames = said["frames"].cast<std::array<int, 2>>();
    request.frames = FrameRange{frames[0], frames[1]};
  }
  if (given("voxel_size")) {
    const auto size = said["voxel_size"].cast<std::array<double, 3>>();
    request.voxelSize = Vec3(size[0], size[1], size[2]);
  }
  if (given("bounds")) {
    const auto b = said["bounds"].cast<std::array<std::array<double, 3>, 2>>();
    request.bounds = Box3{Vec3(b[0][0], b[0][1], b[0][2]), Vec3(b[1][0], b[1][1], b[1][2])};
  }
  if (given("matrix"))
    request.matrix = said["matrix"].cast<GridMatrix>();
  run(listener, [&](Progress& progress) -> Status {
    Reading reading{progress, maxMemory};
    Team alone;
    VOLUTE_TRY(resampleVolume(path, target, request, reading, alone));
    return {};
  });
}

}  // namespace
}  // namespace volute::python

namespace volute::python {
void addOwnKinds(py::module_& m);  // own_kind.cpp
}

PYBIND11_MODULE(_scene, m) {
  using namespace volute::python;
  using namespace volute;
  using namespace py::literals;
  translateFailures();
  CallInProgress::watchEnd();
  m.doc() = "What of Volute shows and looks through scenes; use the package `volute`.";
  PYBIND11_NUMPY_DTYPE(volute::python::Sight::LineSight, depth, low, high, covered, blocked);
  PYBIND11_NUMPY_DTYPE(volute::python::Sight::SignSight, distance, angle, depth, low, high,
                       mean_extinction, visibility, covered, blocked, visible, certainly, possibly);

  py::class_<PythonScene>(m, "Scene")
      .def_static(
          "open",
          [](const std::string& path, const std::string& members, const Volumes& volumes,
             bool measured, bool depth, std::uint64_t maxMemory, const py::object& listener) {
            const auto own = std::make_shared<MemoryVolumes>();
            addVolumes(*own, volumes);
            Scene scene = run(listener, [&](Progress& progress) {
              SceneOptions options = sceneOptions(members, maxMemory);
              options.files.volumes = own;
              addUsualMembers(path, {.measured = measured, .depth = depth}, options);
              return Scene::open(path, options, progress);
            });
            return std::make_unique<PythonScene>(std::move(scene), own, maxMemory);
          },
          "path"_a, "members"_a, "volumes"_a, "measured"_a, "depth"_a, "max_memory"_a, "listener"_a)
      .def_static(
          "make",
          [](const std::string& json, const std::string& file, const Volumes& volumes,
             bool measured, bool /*depth*/, std::uint64_t maxMemory, const py::object& listener) {
            const auto own = std::make_shared<MemoryVolumes>();
            addVolumes(*own, volumes);
            Scene scene = run(listener, [&](Progress& progress) {
              SceneOptions options = sceneOptions("{}", maxMemory);
              options.files.volumes = own;
              options.files.measured = measured;
              return Scene::make(jsonOf(json), file, options, progress);
            });
            return std::make_unique<PythonScene>(std::move(scene), own, maxMemory);
          },
          "json"_a, "file"_a, "volumes"_a, "measured"_a, "depth"_a, "max_memory"_a, "listener"_a)
      .def_property_readonly("json", &PythonScene::json)
      .def_property_readonly("path", &PythonScene::path)
      .def_property_readonly("bounds", &PythonScene::bounds)
      .def_property_readonly("times", &PythonScene::times)
      .def_property_readonly("media", &PythonScene::media)
      .def("change", &PythonScene::change, "json"_a, "volumes"_a, "listener"_a)
      .def("keep", &PythonScene::keep, "names"_a)
      .def("render", &PythonScene::render, "said"_a, "listener"_a)
      .def("picture", &PythonScene::picture, "said"_a, "listener"_a)
      .def("film", &PythonScene::film, "said"_a, "listener"_a);

  m.def("resample", &resampleFile, "path"_a, "target"_a, "said"_a, "max_memory"_a, "listener"_a);

  py::class_<volute::python::Sight>(m, "Sight")
      .def(py::init<std::string, const std::string&, std::string, const Volumes&, std::uint64_t,
                    const py::object&>(),
           "path"_a, "members"_a, "scene"_a, "volumes"_a, "max_memory"_a, "listener"_a)
      .def_property_readonly("times", &volute::python::Sight::times)
      .def_property_readonly("time_count", &volute::python::Sight::timeCount)
      .def_property_readonly("bounds", &volute::python::Sight::bounds)
      .def_property_readonly("description", &volute::python::Sight::description)
      .def_property_readonly("remarks", &volute::python::Sight::remarks)
      .def("look", &volute::python::Sight::look, "time"_a, "eyes"_a, "targets"_a, "listener"_a)
      .def("survey", &volute::python::Sight::survey, "times"_a, "signs_file"_a, "eyes"_a,
           "listener"_a)
      .def("sign_names", &volute::python::Sight::signNames, "file"_a);

  py::class_<Engine>(m, "Engine")
      .def(py::init<const std::string&, const std::string&, const std::string&, const Volumes&,
                    const std::string&, const std::string&, std::uint64_t, const py::object&>(),
           "path"_a, "members"_a, "scene"_a, "volumes"_a, "signs_file"_a, "criteria_file"_a,
           "max_memory"_a, "listener"_a)
      .def_property_readonly("times", &Engine::times)
      .def_property_readonly("signs", &Engine::signs)
      .def_property_readonly("sign_places", &Engine::signPlaces)
      .def_property_readonly("criteria", &Engine::criteria)
      .def_property_readonly("missing", &Engine::missing)
      .def_property_readonly("remarks", &Engine::remarks)
      .def("sees", &Engine::sees, "time"_a, "eyes"_a, "listener"_a)
      .def("dose", &Engine::dose, "time"_a, "ids"_a, "eyes"_a, "worst"_a, "listener"_a)
      .def("extinction", &Engine::extinction, "time"_a, "eyes"_a, "listener"_a)
      .def("walking_speed", &Engine::walkingSpeed, "time"_a, "eyes"_a, "clear"_a, "law"_a,
           "listener"_a);

  py::class_<PythonTrajectories>(m, "Trajectories")
      .def(py::init<const std::string&, const std::string&, std::optional<double>, double>(),
           "text"_a, "file"_a, "height"_a, "eye_height"_a)
      .def_property_readonly("remarks", &PythonTrajectories::remarks)
      .def_property_readonly("span", &PythonTrajectories::span)
      .def_property_readonly("ids", &PythonTrajectories::ids)
      .def("at", &PythonTrajectories::at, "time"_a);

  addOwnKinds(m);
  m.def("reconstruct", &reconstructCapture, "path"_a, "output"_a, "rms"_a, "options"_a,
        "max_memory"_a, "listener"_a);
  m.def("reconstruct_lines", &reconstructFromLines, "source"_a, "options"_a, "max_memory"_a,
        "listener"_a);
  m.def(
      "read_image",
      [](const std::filesystem::path& path) {
        return arrayOf(run(py::none(), [&](Progress&) { return readImage(path); }));
      },
      "path"_a);
  m.def(
      "write_image",
      [](const std::filesystem::path& path,
         const py::array_t<float, py::array::c_style | py::array::forcecast>& array) {
        const Image image = imageOf(array);
        run(py::none(), [&](Progress&) { return writeImage(path, image); });
      },
      "path"_a, "image"_a);
}
