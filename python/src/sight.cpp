// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Lines of sight, people and signs.

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <mutex>
#include <set>
#include <vector>

#include "scene_bridge.hpp"
#include "volute/base/parallel.hpp"
#include "volute/scene/scene_sight.hpp"
#include "volute/tenability/walking_speed.hpp"
#include "volute/visibility/criteria_file.hpp"
#include "volute/visibility/eyes.hpp"
#include "volute/visibility/sight_engine.hpp"
#include "volute/visibility/sign_file.hpp"
#include "volute/visibility/survey.hpp"

namespace volute::python {
namespace {

using Points = py::array_t<double, py::array::c_style | py::array::forcecast>;

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

/// @param scene  JSON of a scene that is in no file; empty: `path` is a file
Result<std::unique_ptr<SightField>> lookedThrough(const std::string& path, const std::string& scene,
                                                  const SceneOptions& options, Progress& progress) {
  if (scene.empty())
    return openSight(path, options, progress);
  SceneOptions measuring = options;
  measuring.files.depths = true;
  VOLUTE_ASSIGN(auto made, Scene::make(jsonOf(scene), path, measuring, progress));
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

}  // namespace

void addSights(py::module_& m) {
  using namespace py::literals;
  PYBIND11_NUMPY_DTYPE(Sight::LineSight, depth, low, high, covered, blocked);
  PYBIND11_NUMPY_DTYPE(Sight::SignSight, distance, angle, depth, low, high, mean_extinction,
                       visibility, covered, blocked, visible, certainly, possibly);

  py::class_<Sight>(m, "Sight")
      .def(py::init<std::string, const std::string&, std::string, const Volumes&, std::uint64_t,
                    const py::object&>(),
           "path"_a, "members"_a, "scene"_a, "volumes"_a, "max_memory"_a, "listener"_a)
      .def_property_readonly("times", &Sight::times)
      .def_property_readonly("time_count", &Sight::timeCount)
      .def_property_readonly("bounds", &Sight::bounds)
      .def_property_readonly("description", &Sight::description)
      .def_property_readonly("remarks", &Sight::remarks)
      .def("look", &Sight::look, "time"_a, "eyes"_a, "targets"_a, "listener"_a)
      .def("survey", &Sight::survey, "times"_a, "signs_file"_a, "eyes"_a, "listener"_a)
      .def("sign_names", &Sight::signNames, "file"_a);

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
}

}  // namespace volute::python
