// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "volute/base/remark.hpp"
#include "volute/base/result.hpp"
#include "volute/math/box.hpp"
#include "volute/math/vec.hpp"

// Visibility of exit signs through a medium of any representation: cells, tetrahedra, a formula.

namespace volute {

/// From an eye to a point of a sign [m].
struct SightLine {
  Vec3 eye = Vec3::Zero();
  Vec3 target = Vec3::UnitX();

  double length() const { return (target - eye).norm(); }
};

/// What lies on a sight line.
struct Sight {
  /// Integral of the extinction K over the line (natural logarithm, dimensionless). Solids and
  /// stretches outside the field count as clear.
  double depth = 0;
  /// Bounds of the true integral, given the rounding of the field's data (to bytes, say): low <=
  /// depth <= high.
  double low = 0, high = 0;
  bool covered = true;   ///< the field knows the medium everywhere on the line, solids aside
  bool blocked = false;  ///< something opaque stands between; what ends at the target does not
};

/// Gas, solid or outside of the field, at a point.
enum class Place : unsigned char {
  kGas,      ///< one can look from here
  kSolid,    ///< inside something opaque
  kOutside,  ///< the field does not reach here
};

/// A rectangle of a floor plan; one without area is a line.
struct PlanShape {
  enum class Kind : unsigned char {
    kSolid,    ///< stands there
    kDoor,     ///< stands there at other times
    kOpening,  ///< of the field's border, to the outside
    kBorder,   ///< the field's border, closed
  };

  Kind kind = Kind::kSolid;
  Vec2 min = Vec2::Zero(), max = Vec2::Zero();  ///< [m]

  bool operator==(const PlanShape&) const = default;
};

/// One of a field's stored values, and how much it counts in an optical depth [m].
struct SightWeight {
  std::uint32_t value = 0;
  float weight = 0;
};

/// Adds to the weight of a value among the last few, since neighbouring cells share corners; else
/// appends it. The line's weights begin at `first`.
inline void addWeight(std::vector<SightWeight>& weights, std::size_t first, std::uint32_t value,
                      double weight) {
  constexpr std::size_t kRecent = 12;
  if (weight == 0)
    return;
  const std::size_t from = std::max(first, weights.size() - std::min(weights.size(), kRecent));
  for (std::size_t i = weights.size(); i-- > from;) {
    if (weights[i].value == value) {
      weights[i].weight += static_cast<float>(weight);
      return;
    }
  }
  weights.push_back({value, static_cast<float>(weight)});
}

/// The stored values [1/m]; `low` and `high` are empty when they are exact.
struct SightData {
  std::span<const float> value;
  std::span<const float> low, high;
};

/// A medium and what is opaque in it at one stored time. All calls are const and thread-safe.
///
/// Every function is pure, so that a class that wraps a snapshot does not compile until it passes
/// on a function that is added here. Media derive from BasicSightSnapshot, which has defaults.
class SightSnapshot {
 public:
  virtual ~SightSnapshot() = default;

  /// Fills sights[i] for lines[i]. Called from many threads, each with a batch of its own.
  virtual void look(std::span<const SightLine> lines, std::span<Sight> sights) const = 0;

  /// Bounds of the depth of each line, cheaper than look(): low <= Sight::low and Sight::high <=
  /// high; 0 and infinity if unknown.
  virtual void bounds(std::span<const SightLine> lines, std::span<double> low,
                      std::span<double> high) const = 0;

  /// Sight::blocked of each line alone, 1 where it is.
  virtual void blocked(std::span<const SightLine> lines, std::span<unsigned char> out) const = 0;

  /// Fills `places` with what stands at each point.
  virtual void places(std::span<const Vec3> points, std::span<Place> places) const = 0;

  /// The shapes that a horizontal plane at z [m] cuts; empty if only places() is known.
  virtual std::vector<PlanShape> shapes(double z) const = 0;

  /// K at each point [1/m]; NaN where the field does not reach or something solid stands.
  virtual void extinction(std::span<const Vec3> points, std::span<double> extinction) const = 0;

  /// Bounds of K at each point [1/m], given the rounding of the field's data; without rounding,
  /// both are extinction().
  virtual void extinctionBounds(std::span<const Vec3> points, std::span<double> low,
                                std::span<double> high) const = 0;

  /// The z of the highest surface below each point that carries people, at most `drop` below it
  /// [m]; the field's lower border is one. NaN: there is none, as in a shaft or a void.
  virtual void floors(std::span<const Vec3> points, double drop, std::span<double> z) const = 0;

  /// A key of the weights of lines. Optical depths are linear in the stored values, so that
  /// snapshots of one field with the same key share them: weights are computed once, then summed at
  /// each time. 0: the field has no weights.
  virtual std::uint64_t geometry() const = 0;

  /// Appends the weights of a line; sets `covered` and `blocked` of the sight.
  virtual void weigh(const SightLine& line, std::vector<SightWeight>& weights,
                     Sight& sight) const = 0;

  /// What the weights are of.
  virtual SightData data() const = 0;
};

/// A snapshot with defaults: no bounds, shapes or weights.
class BasicSightSnapshot : public SightSnapshot {
 public:
  void bounds(std::span<const SightLine>, std::span<double> low,
              std::span<double> high) const override {
    std::ranges::fill(low, 0.0);
    std::ranges::fill(high, std::numeric_limits<double>::infinity());
  }

  void blocked(std::span<const SightLine> lines, std::span<unsigned char> out) const override {
    std::vector<Sight> sights(lines.size());
    look(lines, sights);
    for (std::size_t i = 0; i < lines.size(); ++i) out[i] = sights[i].blocked ? 1 : 0;
  }

  std::vector<PlanShape> shapes(double) const override { return {}; }

  void extinctionBounds(std::span<const Vec3> points, std::span<double> low,
                        std::span<double> high) const override {
    extinction(points, low);
    std::ranges::copy(low, high.begin());
  }

  /// In steps, by places().
  void floors(std::span<const Vec3> points, double drop, std::span<double> z) const override {
    constexpr double kStride = 0.1;  // [m]
    for (std::size_t i = 0; i < points.size(); ++i) {
      z[i] = std::numeric_limits<double>::quiet_NaN();
      for (double below = kStride; below <= drop + 1e-9 && std::isnan(z[i]); below += kStride) {
        const Vec3 point = points[i] - Vec3(0, 0, below);
        Place place{};
        places({&point, 1}, {&place, 1});
        if (place != Place::kGas)
          z[i] = point.z();
      }
    }
  }

  std::uint64_t geometry() const override { return 0; }

  void weigh(const SightLine&, std::vector<SightWeight>&, Sight&) const override {}

  SightData data() const override { return {}; }
};

/// Stored times around another one [s].
struct StoredSpan {
  double from = 0, until = 0;
};

/// Where a time stands among stored ones.
struct StoredPlace {
  std::size_t first = 0, second = 0;  ///< of the values to mix; the same at a stored time
  double share = 0;                   ///< of the second
  StoredSpan span;
};

/// Nothing where the stored times do not reach. Files of one output differ by a time step, so that
/// up to a twentieth of the first or last interval beyond the ends is taken as the end; of a single
/// time there is no such interval.
[[nodiscard]] std::optional<StoredPlace> storedPlace(std::span<const double> times, double time);

/// Whether a time is stored, or so close to one as files of one output differ.
[[nodiscard]] bool isStored(std::span<const double> times, double time);

/// From here on the stored times of one source are farther apart than those of another. Those of
/// FDS's files, which are at its time steps, differ by less, and a factor of two by more.
inline constexpr double kFinerTimes = 1.5;

/// How far stored times are apart around one that they know [s], without what they differ by from
/// one interval to the next.
[[nodiscard]] double spacingAt(std::span<const double> times, double time);

/// A source of a quantity, and what it has served.
struct ServedSource {
  std::string description;
  std::size_t times = 0;             ///< that it stores; 0: it could not be read, as described
  StoredSpan stored{};               ///< the first and the last of them [s]
  std::optional<StoredSpan> served;  ///< the first and the last time for which it was taken
};

/// A quantity at a point; NaN where it is not known.
struct PointValue {
  double value = std::numeric_limits<double>::quiet_NaN();
  /// Bounds of the value around the point: low <= value <= high.
  double low = value, high = value;
  StoredSpan span{};  ///< the stored times around it, of what served
  /// Whether the bounds hold at the point itself; false: at an instrument nearby.
  bool ofPlace = true;
};

/// One quantity of the air, at points, over time.
class PointField {
 public:
  virtual ~PointField() = default;

  /// Which files it comes from, for people.
  virtual std::string description() const = 0;

  /// When it is stored [s], ascending, one at least.
  virtual std::span<const double> times() const = 0;

  /// Values at points, interpolated linearly between stored times; NaN in solids and where the
  /// quantity is not stored, also before and after the stored times (storedPlace()). A time before
  /// that of the last call is read again.
  [[nodiscard]] virtual Status at(double time, std::span<const Vec3> points,
                                  std::span<double> out) = 0;

  /// The same with bounds of the values and the stored times around `time`, which are left
  /// unchanged where nothing is known.
  [[nodiscard]] virtual Status answer(double time, std::span<const Vec3> points,
                                      std::span<PointValue> out);

  /// Whether values leave nothing open: those of cells do not, means of the cells around nodes do.
  virtual bool isExact() const { return true; }

  /// Its sources, best first.
  virtual std::vector<ServedSource> sources() const;

 protected:
  /// at(), by answer().
  [[nodiscard]] Status valuesOf(double time, std::span<const Vec3> points, std::span<double> out);
};

/// The best of several sources of a quantity at each place and time: among those that have it
/// there, the first of those whose stored times are about as close together (kFinerTimes) as those
/// of the closest. Its bounds are intersected with the others' of these, and with those of the rest
/// at their stored times; contradicting bounds are ignored. Between the stored times of those that
/// know a place, answers are linear. At least one source.
class BestPoints final : public PointField {
 public:
  /// @param unread  sentences about further sources that could not be read.
  explicit BestPoints(std::vector<std::unique_ptr<PointField>> sources,
                      std::vector<std::string> unread = {});

  std::string description() const override;

  std::span<const double> times() const override { return times_; }

  [[nodiscard]] Status at(double time, std::span<const Vec3> points,
                          std::span<double> out) override {
    return valuesOf(time, points, out);
  }

  [[nodiscard]] Status answer(double time, std::span<const Vec3> points,
                              std::span<PointValue> out) override;
  bool isExact() const override;
  std::vector<ServedSource> sources() const override;

 private:
  struct Said;

  [[nodiscard]] Status choose(double time, std::span<const Vec3> points, std::span<PointValue> out,
                              std::span<StoredSpan> between);

  std::vector<std::unique_ptr<PointField>> sources_;
  std::vector<std::string> unread_;
  std::vector<std::optional<StoredSpan>> served_;  // of each
  std::vector<double> times_;                      // of all
};

/// Where it burns, or people cannot stand because of a burner [m].
struct FirePlace {
  Box3 bounds;
  std::string from;  ///< how that is known, for people
};

/// A curve over time of a report.
struct FactCurve {
  std::string name, unit;
  std::vector<double> times;   ///< [s]
  std::vector<double> values;  ///< as many
};

/// Facts about a case, for reports.
struct CaseFacts {
  std::vector<std::pair<std::string, std::string>> title;  ///< "FDS version", "FDS6.8.0" and so on
  std::vector<FactCurve> fire;                             ///< heat release rate
  std::vector<FactCurve> devices;                          ///< what instruments read
  std::vector<std::string> remarks;
};

/// A medium over time, for sight lines.
///
/// bounds(), read() and readAt(), which surfaces of a scene change, are not virtual: they ask the
/// medium and apply what wrap() was given. A field therefore needs no wrapper class, which could
/// forget to pass a function on.
class SightField {
 public:
  /// Puts something between a snapshot and who looks.
  using Wrap =
      std::function<std::shared_ptr<const SightSnapshot>(std::shared_ptr<const SightSnapshot>)>;

  virtual ~SightField() = default;

  /// From now on snapshots are given as `wrap` returns them, and bounds() is `bounds`.
  void wrap(Wrap wrap, const Box3& bounds) {
    wrap_ = std::move(wrap);
    wrappedBounds_ = bounds;
  }

  /// Where the extinction comes from, for people.
  virtual std::string description() const = 0;

  /// Which of a file's sources it is, where a picture can be taken of that too; empty: not known.
  virtual std::string fillingSource() const { return ""; }

  /// Whether it is stored wherever the case has something at a height [m]; sources in layers may
  /// know a strip of it, or nothing.
  virtual bool reaches(double z) const { return z >= bounds().min.z() && z <= bounds().max.z(); }

  /// Another source of the same file that reaches further, to be asked for by its name; empty:
  /// none.
  virtual std::string tallerSource() const { return ""; }

  /// Remarks of the reader of the files.
  virtual std::vector<Remark> remarks() const { return {}; }

  /// The largest extinction of all that was read so far [1/m]; nothing: not judged.
  virtual std::optional<double> largestRead() const { return std::nullopt; }

  /// What an extinction of at most so much at all times that were looked at comes to [1/m]: whether
  /// the quantity and its unit can be right.
  virtual std::vector<Remark> remarksOn(double /*largest*/) const { return {}; }

  /// When it is stored [s], ascending.
  virtual std::span<const double> times() const = 0;

  /// When the case begins [s], as far as it says so: what is not stored since then is not known.
  [[nodiscard]] virtual double begin() { return times().front(); }

  /// When the case ends [s], as far as it says so: what is not stored until then is not known.
  [[nodiscard]] virtual double end() { return times().back(); }

  /// Whether the case begins before the first stored time, by more than storedPlace() allows.
  [[nodiscard]] bool beginsBefore() {
    return !storedPlace(times(), std::min(begin(), times().front()));
  }

  /// The frame number of a stored time.
  virtual int numberOf(std::size_t time) const { return static_cast<int>(time); }

  /// All places of which the field may know something [m].
  Box3 bounds() const { return wrap_ ? wrappedBounds_ : ownBounds(); }

  /// Whether the air beyond bounds() is clear rather than unknown.
  virtual bool clearBeyond() const { return false; }

  /// Where north is [degrees], from +y clockwise as seen from above; nothing: not known.
  virtual std::optional<double> north() const { return std::nullopt; }

  /// Reads one stored time, a position in times(). Asked in ascending order, each once; what was
  /// given before need not stay cheap to make again.
  [[nodiscard]] Result<std::shared_ptr<const SightSnapshot>> read(std::size_t time) {
    return wrapped(readOwn(time));
  }

  /// When something opaque comes or goes after the first stored time and until the last [s],
  /// ascending.
  virtual std::vector<double> changes() const { return {}; }

  /// Whether readAt() answers between stored times.
  virtual bool interpolates() const { return false; }

  /// The same between stored times: the medium is interpolated, what is opaque is that of the time.
  /// For fields that interpolates(), which those with changes() must; asked in ascending order
  /// together with read().
  [[nodiscard]] Result<std::shared_ptr<const SightSnapshot>> readAt(double time) {
    return wrapped(readOwnAt(time));
  }

  /// A quantity besides the smoke where people are: "carbon-monoxide" [mol/mol], "temperature"
  /// [degrees C] (tenability/exposure.hpp has the names). kNotFound when the case does not store
  /// it; that message stands in a list of such reasons, below the case's name.
  [[nodiscard]] virtual Result<std::unique_ptr<PointField>> conditions(std::string_view quantity) {
    return fail(ErrorCode::kNotFound, "the medium stores no {}", quantity);
  }

  /// Where it burns at some time, as far as the case says so; empty: it does not.
  [[nodiscard]] virtual Result<std::vector<FirePlace>> fires() { return std::vector<FirePlace>(); }

  /// What a report says about the case, apart from its smoke.
  [[nodiscard]] virtual Result<CaseFacts> facts() { return CaseFacts{}; }

 protected:
  // bounds(), read() and readAt() of the medium alone.
  virtual Box3 ownBounds() const = 0;
  [[nodiscard]] virtual Result<std::shared_ptr<const SightSnapshot>> readOwn(std::size_t time) = 0;

  [[nodiscard]] virtual Result<std::shared_ptr<const SightSnapshot>> readOwnAt(double time) {
    return fail(ErrorCode::kUnsupported, "{}: has nothing between its stored times ({} s)",
                description(), time);
  }

 private:
  Result<std::shared_ptr<const SightSnapshot>> wrapped(
      Result<std::shared_ptr<const SightSnapshot>> own) const {
    if (wrap_ && own)
      return wrap_(std::move(*own));
    return own;
  }

  Wrap wrap_;
  Box3 wrappedBounds_;
};

}  // namespace volute
