// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "volute/visibility/exposure_meter.hpp"
#include "volute/visibility/survey.hpp"

namespace volute {

/// Tells evacuation programs which agents see which signs, and the doses they take in: called
/// repeatedly as time proceeds, for all agents at once. Call from one thread; it uses all threads.
class SightEngine {
 public:
  /// Signs are placed at the first stored time. Criteria without data in the case are left out;
  /// missing() names them. `progress` receives remarks.
  [[nodiscard]] static Result<SightEngine> open(std::shared_ptr<SightField> field,
                                                std::span<const SafetySign> signs,
                                                std::span<const Criterion> criteria,
                                                Progress& progress);

  /// Whether each agent sees each sign at a time [s]: optical depths are linear between stored
  /// times, obstructions as of `t`; before the first and after the last stored time nobody can
  /// tell. Times may be in any order; ascending ones are read once.
  /// @param eyes  [m].
  /// @param out  shape (sign, agent), agent fastest.
  [[nodiscard]] Status sees(std::span<const Vec3> eyes, double t, std::span<Seen> out);

  /// The doses of agents until `t` [s], by the trapezoidal rule from the previous time to this one;
  /// steps of a second or less are small enough for walking people. An agent absent at the previous
  /// call continues with its earlier dose, without the time in between.
  /// @param ids  of the agents, each once; else kInvalidArgument.
  /// @param eyes  position of each [m].
  /// @param out  shape (criterion, agent): doses so far, or levels; NaN where the case does not
  /// say, for doses from then on.
  /// @param worst  the same by the worst that rounding, caps and means of the files allow; empty:
  /// not asked for.
  [[nodiscard]] Status dose(std::span<const std::int64_t> ids, std::span<const Vec3> eyes, double t,
                            std::span<double> out, std::span<double> worst = {});

  /// K at each eye [1/m], for walking speeds in smoke; NaN where nothing is known.
  [[nodiscard]] Status extinction(std::span<const Vec3> eyes, double t, std::span<double> out);

  const std::vector<SightTarget>& signs() const { return signs_; }

  const std::vector<Criterion>& criteria() const { return criteria_; }

  const std::vector<ExposureMeter::Missing>& missing() const { return missing_; }

  std::span<const double> times() const { return field_->times(); }

 private:
  /// The case between two stored times.
  struct Snapshots {
    std::shared_ptr<const SightSnapshot> before, after;  // `after` is null at a known time
    double share = 0;                                    // of `after`
  };

  struct Course {
    std::vector<double> rates, doses;  // of each criterion
  };

  struct Agent {
    double time = 0;  // of the last call with them
    Course mean, worst;
  };

  /// Lines of a batch, and where their answers go.
  struct Lines {
    std::vector<SightLine> lines;
    std::vector<std::size_t> places;
    std::vector<double> limits, highs;

    std::size_t size() const { return lines.size(); }

    void add(const SightLine& line, std::size_t place, double limit, double high = 0) {
      lines.push_back(line), places.push_back(place);
      limits.push_back(limit), highs.push_back(high);
    }

    void add(const Lines& from, std::size_t k, double high) {
      add(from.lines[k], from.places[k], from.limits[k], high);
    }

    void clear() { lines.clear(), places.clear(), limits.clear(), highs.clear(); }
  };

  static std::pair<std::vector<double>, std::vector<double>> boundsOf(
      const Snapshots& now, std::span<const SightLine> lines);
  static void lookExactly(const Snapshots& now, const Lines& lines, std::span<Seen> out);
  bool knows(double t) const;
  bool changed(double stored, double now) const;
  Result<Snapshots> snapshotsAt(double t);
  Result<std::shared_ptr<const SightSnapshot>> stored(std::size_t index);
  Status largestExtinction(std::span<const Vec3> eyes, double t, std::span<double> out);

  std::shared_ptr<SightField> field_;
  std::vector<SightTarget> signs_;
  std::vector<Criterion> criteria_;
  std::vector<ExposureMeter::Missing> missing_;
  AirField air_;
  bool small_ = false;           // few enough values to be interpolated at each time
  std::vector<double> changes_;  // of what is opaque
  double time_ = -1;
  Snapshots snapshots_;
  std::map<std::size_t, std::shared_ptr<const SightSnapshot>> held_;  // stored ones, two at most
  double lastCall_ = 0;
  bool called_ = false;
  std::unordered_map<std::int64_t, Agent> agents_;
};

}  // namespace volute
