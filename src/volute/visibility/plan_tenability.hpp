// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <optional>

#include "volute/visibility/exposure_meter.hpp"
#include "volute/visibility/plan_areas.hpp"
#include "volute/visibility/plan_picture.hpp"
#include "volute/visibility/plan_use.hpp"
#include "volute/visibility/plan_values.hpp"
#include "volute/visibility/plan_vti.hpp"
#include "volute/visibility/watch.hpp"

namespace volute {

/// Tenability over a plan: when each criterion is reached at each point, which is the first of all,
/// and what is left of it after the time that people need.
class PlanTenability {
 public:
  /// With the survey's criteria.
  /// @param air     of the survey's field
  /// @param use     which eyes verdicts are of
  /// @param areas   the plan's rooms and areas, which outlive this
  /// @param shapes  what maps draw at its place, at the eyes' height
  /// @param signs   that maps draw
  PlanTenability(const Survey& survey, AirField air, std::span<const Vec3> eyes, const PlanUse& use,
                 const PlanAreas& areas, PlanValues values, std::vector<PlanShape> shapes,
                 std::vector<SightTarget> signs);

  /// Whether the case begins before the smoke is stored.
  bool smokeIsLate() const { return meter_.air().smokeIsLate(); }

  /// Each time; those between stored ones are passed over.
  [[nodiscard]] Status take(const SurveyTime& at);

  /// Through the times at which the air is stored but no smoke.
  [[nodiscard]] Status goOn();

  double end() const { return meter_.air().end(); }

  /// Losses of sight of all signs.
  struct Sight {
    LossTimes earliest;             ///< by depths that are rounded up
    LossTimes latest;               ///< rounded down
    std::vector<LossTimes> varied;  ///< of each of variations(), rounded up
    std::vector<bool> in;           ///< where one is seen before there is smoke
  };

  /// Parts of the page, each with its headings.
  struct Parts {
    std::string criteria, results, sensitivity;
  };

  /// Which of some eyes are not known all along, of all criteria together.
  std::vector<std::size_t> notKnown(const Sight& sight, std::span<const std::size_t> eyes) const;

  /// From now on other eyes count.
  void count(const PlanUse& use);

  /// Writes maps, adds to the report, the arrays of aset.vti and the verdict, and returns its parts
  /// of the page.
  [[nodiscard]] Result<Parts> finish(const Sight& sight, Json& report,
                                     std::vector<PlanArray>& arrays, Json& verdict);

  /// What is told of parts of the plan; after finish().
  void find(AreaFindings& found) const;

 private:
  /// A map in which nothing is said of any point yet.
  PlanPicture emptyPicture(std::string title) const;
  Json criterionJson(std::size_t c) const;

  /// The first of all criteria at each point, with some losses of sight, and other times of some
  /// criteria than the meter's, which null stands for. `which`: the first, if it is not null.
  LossTimes combined(const LossTimes& signs, const std::vector<bool>& inSight,
                     const std::function<const LossTimes*(std::size_t)>& instead,
                     std::vector<int>* which) const;

  /// The same by the least smoke, heat and gases that the data allow.
  LossTimes latest(const Sight& sight) const;
  Result<std::string> sensitivity(const Sight& sight, Json& report) const;
  Status writeTimes(const std::string& name, const std::string& title, const LossTimes& times,
                    const std::vector<bool>& holds = {}) const;
  std::vector<bool> countsOf(std::size_t criterion) const;
  Status writeFirst() const;
  Result<std::string> margin(Json& report, std::vector<PlanArray>& arrays, Json& verdict);
  void addSmoke(double factor);
  bool measuresMargins() const;
  std::string rsetDescription() const;
  Json sentence(std::size_t c) const;
  Json headline(const std::vector<std::string>& names) const;
  Json ofTheFire(const std::vector<std::string>& names) const;
  std::string notAssessed() const;
  std::string unknownReasons() const;
  std::string storedWords(std::size_t c) const;

  const Survey* survey_;
  std::span<const Vec3> eyes_;
  std::vector<Vec3> free_;  // of eyes_; NaN where something opaque stands now
  PlanUse use_;
  std::vector<bool> people_;  // which eyes count
  const PlanAreas* areas_;
  PlanValues values_;
  std::vector<PlanShape> shapes_;
  std::vector<SightTarget> signs_;
  ExposureMeter meter_;
  std::vector<std::size_t> smoke_;  // criteria of the extinction where one stands
  /// Of each variation that changes the smoke; else empty. Shape (variation, smoke_).
  std::vector<std::vector<LevelWatch>> varied_;
  std::vector<std::vector<bool>> holds_;  // of each criterion, eye: it is for such a room
  LossTimes all_;                         // of all criteria together
  LossTimes latest_;                      // by the least smoke that the data allow
  PlanMargins margins_;
  std::vector<std::string> names_;  // of the first criterion of each eye
  std::vector<int> which_;          // the first: -1 none, 0 sight of signs, else criterion + 1
};

/// Adds a time of each place to a report: `key`, null where it is not known, and `key`_known. Also
/// `key`_at_the_latest, where there is such a time.
/// @param times  of the rounding that is asked for
/// @param list   makes a list or rows of one value for each place
void addTimes(Json& json, const std::string& key, const LossTimes& times, RoundTime round,
              const std::function<Json(std::span<const Json>)>& list);

/// Which source served which quantity, from when to when: of the smoke and of what a meter took in.
Json sourcesJson(const Survey& survey, const ExposureMeter* meter);

/// The same as a table of the page.
std::string sourcesTable(const Json& sources);

/// " Not stored, counted as in clean air: oxygen." of what a criterion takes in; empty: nothing.
std::string assumedWords(const ExposureMeter& meter, std::size_t criterion);

/// The criteria of a survey as a report's list, with what was missing and assumed.
Json criteriaJson(const ExposureMeter& meter);

/// The same as a table of the page.
std::string criteriaTable(const ExposureMeter& meter);

}  // namespace volute
