// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/fds/fds_field.hpp"
#include "volute/fds/fds_share.hpp"
#include "volute/fds/fds_source.hpp"
#include "volute/fds/frame_file.hpp"
#include "volute/fds/obstructions.hpp"
#include "volute/fds/smoke_scale.hpp"

namespace volute {

/// How to read a case.
struct FdsOptions {
  std::string quantity{};     ///< FDS's name of a stored quantity; empty: extinction [1/m]
  std::string source{};       ///< name of a source; empty: the best, see FdsCase::open()
  bool volume = false;        ///< only sources that fill meshes, for pictures and volumes
  double massExtinction = 0;  ///< Km [m2/kg]; 0: the case's, else what FDS assumes
  /// C of visibility slices; without it VISIBILITY_FACTOR of the case's input, else FDS's 3.
  std::optional<double> visibilityFactor{};
  bool orClear = false;  ///< a case that stores no smoke is clear air, for pictures
  /// Times that not all files have stay where those of the others begin later or end earlier, and
  /// so do meshes whose file is missing: nothing is known there and then. Else such times are left
  /// out, and a missing file is an error: in a picture, what is not known looks like clear air.
  bool partly = false;
  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes], for frames
  FdsShare share{};                                  ///< fields have values of these meshes alone
};

/// The smoke of a case, or another quantity: its files, stored times, bounds, and snapshots of
/// it.
class FdsCase {
 public:
  /// Reads the index and checks all files of the chosen source. kNotFound if the case has no source
  /// of smoke. What was left out, and why, is in remarks().
  ///
  /// Without a name, the first suitable one of sources() is taken, or instead of it a later one
  /// that fills as many meshes, if it has files for more meshes, or for as many meshes and at least
  /// twice as many stored times: a fire changes more between two times than the rounding of a byte.
  /// If there are several, remarks() says which was taken and why.
  [[nodiscard]] static Result<FdsCase> open(const std::filesystem::path& path,
                                            const FdsOptions& options = {});

  /// The same with an index that was already read.
  /// @param earlier  of that index: shares its files, and is used by the same thread from then on,
  ///                 where it reads the same source in the same way; may be null
  [[nodiscard]] static Result<FdsCase> open(SmvIndex index, const FdsOptions& options = {},
                                            const FdsCase* earlier = nullptr);

  const SmvIndex& index() const { return index_; }

  /// All sources of the case, best first.
  std::span<const FdsSource> sources() const { return sources_; }

  const FdsSource& source() const { return sources_[chosen_]; }

  /// Times [s] of the stored frames that all files of the source have, and, of a case that is read
  /// partly, those at which some know nothing; ascending, at least one.
  std::span<const double> times() const { return times_; }

  /// Whether all files have frames at all times().
  bool isWhole() const { return whole_; }

  /// Whether the file of a lattice has the frames that field() takes at a time.
  bool knows(std::size_t lattice, double time) const;

  /// The last time [s] that any file of the source has.
  double storedUntil() const { return storedUntil_; }

  /// Bounds of the region the source covers.
  const Box3& bounds() const { return grid_->bounds(); }

  const FdsGrid& grid() const { return *grid_; }

  /// On truncated files, meshes without a file, caps.
  std::span<const Remark> remarks() const { return remarks_; }

  /// Those of the remarks that say which of its files and stored times are not read, as
  /// files are cut or hold no gas.
  std::span<const Remark> leftOut() const { return leftOut_; }

  /// The sentence of the remark that says which meshes the source does not cover; empty: none.
  const std::string& uncovered() const { return uncovered_; }

  /// The smoke at a time [s]: linear between the stored frames; the first frame before them, the
  /// last one after them; obstructions as of that time. Keeps the frames read last. Call from one
  /// thread at a time.
  [[nodiscard]] Result<FdsField> field(double time);

  /// The largest value over all frames according to the .sz files of 8-bit fire, in the unit of the
  /// quantity; nothing if they do not state it.
  std::optional<double> largestSaid() const;

  /// The obstructions at a time [s].
  FdsObstructions obstructions(double time) const { return {index_, time}; }

 private:
  struct Part;

  /// Of each part; null: its file has none.
  using Frame = std::vector<std::shared_ptr<const FdsValues>>;

  /// Where a time is among the stored ones.
  struct Place {
    std::size_t first = 0, second = 0;
    double share = 0;  ///< of the second; 0: it does not matter
  };

  using Cells = std::vector<std::shared_ptr<const std::vector<FdsCell>>>;

  FdsCase() = default;

  Status checkSize() const;
  Status chooseSource(const FdsOptions& options);
  void weighSources(const FdsOptions& options);
  std::size_t storedTimes(const FdsSource& source) const;
  void noteOtherSmoke();
  Status openParts();
  Result<std::shared_ptr<Part>> openPart(const FdsSourcePart& what) const;
  std::optional<std::size_t> plotVariableOf(const FdsPlotEntry& plot,
                                            const FdsSourcePart& part) const;
  void noteOtherPlots();
  Status findBytes();
  Status findVisibility();
  void tellExtinction();
  void noteGaps(std::span<const FdsLattice> lattices);
  Status findGeneration();
  Status findHeatScale();
  Status findTemperatureScale();
  Status findRounding(const Part& part);
  Result<SmokeScale> scaleOf(const Part& part, std::size_t frame) const;
  bool holds(const Part& part) const;
  Status findTimes();
  void noteDroppedTimes(std::span<const double> dropped);
  void noteShortFiles();
  Place placeOf(double time) const;
  Status buildGrid();
  void findChanges();
  void noteMissingMeshes();
  Result<std::shared_ptr<const Frame>> frame(std::size_t position);
  std::size_t changesUntil(double time) const;
  void findGeometry(Part& part, double time) const;
  Result<std::vector<float>> firstFrame(Part& part) const;
  Result<std::shared_ptr<const FdsValues>> partValues(Part& part, std::size_t position) const;
  Cells cellsAt(double time, double frameBefore, double frameAfter, const Frame& values) const;

  bool readsAs(const FdsCase& other) const;

  FdsOptions options_;
  SmvIndex index_;
  std::vector<FdsSource> sources_;
  std::size_t chosen_ = 0;
  std::vector<bool> heldMeshes_;
  std::vector<std::shared_ptr<Part>> parts_;
  bool bytesAreDensity_ = false;                      // of .s3d: the third generation
  std::array<double, 2> temperatureRange_{20, 2000};  // [degrees C], FDS's default
  double visibilityFactor_ = 3;
  double visibilityCap_ = 30;                                       // [m]
  double largestHeat_ = 1200;                                       // [kW/m3], FDS's default
  SmokeScale::Rounding rounding_ = SmokeScale::Rounding::kUnknown;  // of .s3d's opacity
  std::vector<double> times_;
  double storedUntil_ = 0;       // [s]
  bool whole_ = true;            // all files have all times
  std::vector<double> changes_;  // of obstructions and vents, ascending
  std::shared_ptr<const FdsGrid> grid_;
  std::vector<Remark> remarks_, leftOut_;
  std::string uncovered_;
  std::size_t chosenBy_ = 0;  // how many of them are about the choice of a source
  std::vector<std::pair<std::size_t, std::shared_ptr<const Frame>>> kept_;  // two at most
};

}  // namespace volute
