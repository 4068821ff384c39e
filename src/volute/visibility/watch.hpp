// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/report/json_parts.hpp"
#include "volute/tenability/criterion.hpp"
#include "volute/tenability/walking_speed.hpp"
#include "volute/visibility/area_file.hpp"
#include "volute/visibility/eyes.hpp"
#include "volute/visibility/loss.hpp"
#include "volute/visibility/rset.hpp"
#include "volute/visibility/survey.hpp"

namespace volute {

/// Some of the signs, by position; the map of when none of them is seen any more is made.
struct SignSet {
  std::string name;
  std::vector<std::size_t> members;
};

struct PlanUnderlay;

/// Field, signs, times and settings that all parts of a survey share.
struct Survey {
  std::filesystem::path folder;  ///< where results go
  std::vector<SightTarget> signs;
  std::vector<SignSet> sets;  ///< the first has all signs
  std::vector<double> times;  ///< those that are looked at [s]
  double end = 0;             ///< of the case [s]: the last of them, or later, without smoke
  Box3 bounds;
  double step = 0.25;  ///< between points of a plan or a route [m]
  double height = 2;   ///< of a plan's points [m]
  /// A map for each sign and stored time: none, values at each time and pictures at no more times
  /// than kPicturedTimes, or both at each.
  enum class Maps { kNone, kSome, kAll };

  static constexpr std::size_t kPicturedTimes = 25;
  Maps maps = Maps::kSome;

  /// Whether maps of a stored time are drawn as pictures: of `kSome`, of times evenly spread over
  /// all.
  bool pictured(std::size_t time) const;

  double extinctionLimit = 0;                              ///< [1/m]; 0: none
  std::shared_ptr<const PlanUnderlay> underlay = nullptr;  ///< under maps; may be null
  std::optional<double> north{};                           ///< SightField::north()
  RoundTime round = RoundTime::kDown;  ///< how `rows` and verdicts give losses between times

  SightField* field = nullptr;  ///< whose air criteria ask about

  /// Whether the case begins before the smoke is looked at.
  /// Whether the case goes on when the smoke is no longer known.
  bool endsAfter() const { return end > times.back(); }

  bool beginsBefore() const {
    return field->beginsBefore() || times.front() > field->times().front();
  }

  std::vector<Criterion> criteria;  ///< of tenability, besides the sight of signs; may be empty
  std::optional<Rset> rset;         ///< what plans are compared with

  std::vector<Vec3> fires;  ///< besides what the case says: x, y and radius [m] of where it burns
  std::vector<NamedArea> areas;                ///< for verdicts of their own
  std::shared_ptr<JsonParts> parts = nullptr;  ///< of the report; may be null
  bool everywhere = false;  ///< verdicts of plans are of all points, not of those for people alone

  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes] of all that is kept of eyes
  std::uint64_t bytesOfLine = sizeof(Sighting);      ///< while a time is looked at, its rows too

  /// kTooLarge where so many eyes need more than maxMemory: what they see at one time, and
  /// @param kept  [bytes] that are kept of each all along.
  [[nodiscard]] Status checkMemory(std::uint64_t eyes, std::uint64_t kept) const;

  /// The name as part of a file's name.
  static std::string fileName(std::string_view name);
};

/// One time of a survey.
struct SurveyTime {
  std::size_t index = 0;  ///< among Survey::times
  double time = 0;        ///< [s]
  std::span<const Vec3> eyes;
  std::span<const Sighting> sightings;  ///< shape (sign, eye)
  /// Where the eyes stand [1/m], where Survey or Watch ask for it; NaN as
  /// SightSnapshot::extinction() says.
  std::span<const double> extinction{};
  /// The largest that the data's rounding allows there, for criteria.
  std::span<const double> extinctionHigh{};
  std::span<const double> extinctionLow{};  ///< the least; kSolid in what stands there now

  static constexpr double kSolid = -1;

  std::span<const double> passedHigh{}, passedLow{};  ///< the same at Watch::passed()
  /// False at the times at which something opaque comes or goes, which are given before and after.
  bool stored = true;
};

/// Where eyes are, and what becomes of what they see. One kind for each way of choosing eyes.
class Watch {
 public:
  virtual ~Watch() = default;

  /// Called once with the first snapshot. An error or a remark if no eye can see from where it is.
  [[nodiscard]] virtual Status begin(const Survey& survey, const SightSnapshot& first,
                                     Progress& progress) = 0;

  /// The eyes at a time.
  virtual std::vector<Vec3> eyes(double time) const = 0;

  /// Places besides the eyes at which the extinction of a stored time is wanted.
  virtual std::vector<Vec3> passed(double time) const {
    (void)time;
    return {};
  }

  /// Writes what files there are of a time alone. Each stored time once, in any order and on any
  /// rank, after begin() on that rank.
  [[nodiscard]] virtual Status draw(const SurveyTime& at, const SightSnapshot& snapshot) const {
    (void)snapshot;
    (void)at;
    return {};
  }

  /// Each time in ascending order, those between stored ones too, on rank 0.
  [[nodiscard]] virtual Status take(const SurveyTime& at) = 0;

  /// Adds its figures to the report, writes its files, and returns its part of the page. On rank 0.
  [[nodiscard]] virtual Result<std::string> finish(Json& report) = 0;

  /// Until when anything is stored that is asked for besides the smoke [s]. After begin().
  virtual double end() const { return -std::numeric_limits<double>::infinity(); }

  /// Whether times between stored ones, at which something opaque comes or goes, are of use.
  virtual bool wantsChanges() const { return true; }

  /// Whether SurveyTime::extinction is of use besides what Survey asks for.
  virtual bool wantsExtinction() const { return false; }

  /// Whether the eyes are elsewhere at each time.
  virtual bool moves() const { return false; }

  /// True when a page is written.
  virtual bool hasPage() const { return true; }
};

/// All points of a floor plan at a height: maps, and when signs are lost.
std::unique_ptr<Watch> planWatch();

/// The start of a walk along a route.
struct WalkStart {
  double time = 0;     ///< [s]
  double smoke = 0;    ///< [1/m]; not 0: when the extinction there reaches it, instead of `time`
  double delay = 0;    ///< [s] after that
  bool heard = false;  ///< or where any other route begins

  bool waits() const { return smoke > 0; }
};

/// "30", "smoke:K" or "smoke:K,DELAY" (they see it), "heard:K" or "heard:K,DELAY" (or somebody who
/// sees it tells them).
[[nodiscard]] Result<WalkStart> walkStart(std::string_view text);

/// How somebody walks along a route.
struct Walk {
  double speed = 1.2;  ///< in clear air [m/s]
  WalkStart start{};
  SpeedLaw slowed{};
};

/// Points along routes, and people who walk them.
std::unique_ptr<Watch> routeWatch(std::vector<Route> routes, const Walk& walk);
/// @param names  of the points, or none
std::unique_ptr<Watch> pointWatch(std::vector<Vec3> points, std::vector<std::string> names = {});
std::unique_ptr<Watch> trajectoryWatch(Trajectories people);

}  // namespace volute
