// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "volute/fds/fds_case.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/media/sight.hpp"

namespace volute {

/// An FDS case at one time.
class FdsSightSnapshot final : public BasicSightSnapshot {
 public:
  /// `geometry` is a number for its cells and obstructions, or 0.
  FdsSightSnapshot(FdsField field, FdsObstructions obstructions, std::uint64_t geometry);

  void look(std::span<const SightLine> lines, std::span<Sight> sights) const override;
  void bounds(std::span<const SightLine> lines, std::span<double> low,
              std::span<double> high) const override;
  void blocked(std::span<const SightLine> lines, std::span<unsigned char> out) const override;
  void places(std::span<const Vec3> points, std::span<Place> places) const override;
  void extinction(std::span<const Vec3> points, std::span<double> extinction) const override;
  void extinctionBounds(std::span<const Vec3> points, std::span<double> low,
                        std::span<double> high) const override;
  void floors(std::span<const Vec3> points, double drop, std::span<double> z) const override;
  std::vector<PlanShape> shapes(double z) const override;

  std::uint64_t geometry() const override { return geometry_; }

  void weigh(const SightLine& line, std::vector<SightWeight>& weights, Sight& sight) const override;
  SightData data() const override;

  const FdsField& field() const { return field_; }

  /// Adds what plans draw besides obstructions: doors that are open, and the meshes' borders, which
  /// are floors where nothing lies below.
  void addBorders(const SmvIndex& index, double time);

 private:
  struct Blocks;

  void joinValues();
  const Blocks& blocks() const;
  bool passesBorder(const Segment& segment) const;

  FdsField field_;
  FdsObstructions obstructions_;
  std::uint64_t geometry_;
  std::vector<std::pair<Box3, PlanShape::Kind>> borders_;
  std::vector<Box3> meshes_;
  std::vector<std::uint32_t> firsts_;      // of each lattice's values among all
  std::vector<float> value_, low_, high_;  // of several lattices, one after the other
  std::shared_ptr<Blocks> blocks_;         // made when they are first asked for
};

/// Sources of the same smoke that know what another one does not: of a visibility that is cut, the
/// extinction where it is; of any, times at which it stores nothing, or fewer, and meshes of which
/// it has no file, or one that is cut. Best first. What cannot be read is left out.
/// @param options  those of `first`
/// @param earlier  see FdsCase::open()
/// @param unread  is given a remark on each that cannot be read; may be null
std::vector<FdsCase> fillingSources(const FdsCase& first, const FdsOptions& options,
                                    const FdsCase* earlier = nullptr,
                                    std::vector<Remark>* unread = nullptr);

/// An FDS case over time: obstructions come and go. It reaches over all meshes; in those of which
/// no source has smoke, nothing is known.
class FdsSight final : public SightField {
 public:
  /// `name` is the case's, for people; `maxMemory` of the frames of each of its other quantities.
  /// @param others  serve where and when `fds` does not know, or less, see fillingSources()
  /// @param walls  besides obstructions: closed bodies, see fdsWalls()
  /// @param notes  of remarks()
  explicit FdsSight(FdsCase fds, std::string name = "",
                    std::uint64_t maxMemory = std::uint64_t{4} << 30,
                    std::vector<FdsCase> others = {}, TriangleScene walls = {},
                    std::vector<Remark> notes = {});

  std::string description() const override;

  std::string fillingSource() const override {
    return case_.source().volume ? case_.source().name : "";
  }

  bool reaches(double z) const override;

  std::string tallerSource() const override;

  std::vector<Remark> remarks() const override;

  std::optional<double> largestRead() const override { return largest_; }

  std::vector<Remark> remarksOn(double largest) const override;

  std::span<const double> times() const override { return times_; }

  /// By its heat release, which FDS writes from the beginning on.
  double begin() override;
  double end() override;

  std::optional<double> north() const override { return case_.index().north; }

  std::vector<double> changes() const override;

  bool interpolates() const override { return true; }

  [[nodiscard]] Result<std::unique_ptr<PointField>> conditions(std::string_view quantity) override;
  [[nodiscard]] Result<std::vector<FirePlace>> fires() override;
  [[nodiscard]] Result<CaseFacts> facts() override;

 protected:
  Box3 ownBounds() const override { return bounds_; }

  [[nodiscard]] Result<std::shared_ptr<const SightSnapshot>> readOwn(std::size_t time) override {
    return readOwnAt(times()[time]);
  }

  [[nodiscard]] Result<std::shared_ptr<const SightSnapshot>> readOwnAt(double time) override;

 private:
  const std::pair<double, double>& span();

  /// Lattices of several sources together.
  struct Whole {
    // Of each; null: of a mesh that nobody knows.
    std::vector<std::pair<const FdsGrid*, std::size_t>> from;
    std::shared_ptr<const FdsGrid> grid;
  };

  struct Unknown {
    std::size_t changes = 0;  // of obstructions, so many until then
    std::shared_ptr<const FdsValues> values;
    std::shared_ptr<const std::vector<FdsCell>> cells;
  };

  bool sameGeometry(const FdsField& field, double time) const;
  std::pair<FdsCase*, double> caseAt(double time);
  Result<FdsField> refined(FdsField field, const FdsCase& of, double time);
  Result<FdsField> completed(FdsField field, const FdsCase& of, double time);
  const Unknown& unknownMesh(int mesh, double time);
  std::size_t changesUntil(double time) const;

  FdsCase case_;
  std::vector<FdsCase> others_;
  TriangleScene walls_;
  std::vector<Remark> notes_;
  Box3 bounds_;
  std::vector<Whole> wholes_;
  std::vector<int> nowhereKnown_;   // meshes of which no source has smoke
  std::map<int, Unknown> unknown_;  // what stands in them
  std::vector<double> times_;
  std::vector<double> events_;                     // of obstructions, ascending
  std::optional<std::pair<double, double>> span_;  // when it was asked for
  std::string name_;
  std::uint64_t maxMemory_;
  std::uint64_t geometry_ = 0;
  double lastTime_ = 0;
  std::optional<double> largest_;  // [1/m]
  std::optional<FdsField> last_;
};

}  // namespace volute
