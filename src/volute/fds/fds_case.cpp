// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_case.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <set>

#include "volute/base/parallel.hpp"
#include "volute/base/printable.hpp"
#include "volute/fds/fds_input.hpp"
#include "volute/fds/fds_part.hpp"
#include "volute/fds/mean_visibility.hpp"
#include "volute/fds/solids.hpp"

namespace volute {
namespace {

constexpr double kSameTime = 1e-6;  // relative, or [s] near 0

bool sameTime(double a, double b) {
  return std::abs(a - b) <= kSameTime * std::max({1.0, std::abs(a), std::abs(b)});
}

/// "; SOOT DENSITY in mg/m3 is no such": slices of smoke of which no extinction is made.
std::string unusedSmoke(const SmvIndex& index) {
  constexpr std::string_view kWords[] = {"SOOT", "EXTINCTION", "OPTICAL DENSITY", "VISIBILITY"};
  std::set<std::string> stored;
  for (const FdsSliceEntry& slice : index.slices) {
    const std::string& quantity = slice.labels.quantity;
    if (std::ranges::any_of(kWords, [&](std::string_view word) {
          return quantity.find(word) != std::string::npos;
        }))
      stored.insert(fmt::format("{} in {}", quantity, slice.labels.unit));
  }
  return stored.empty() ? std::string() : fmt::format("; {} is no such", fmt::join(stored, ", "));
}

/// Whether boxes touch.
bool near(const Box3& a, const Box3& b) {
  return (a.min.array() <= b.max.array() + kMeshSeparation).all() &&
         (b.min.array() <= a.max.array() + kMeshSeparation).all();
}

}  // namespace

Result<FdsCase> FdsCase::open(const std::filesystem::path& path, const FdsOptions& options) {
  VOLUTE_ASSIGN(auto index, SmvIndex::read(path, options.maxMemory));
  return open(std::move(index), options);
}

/// Whether files are read as in another case of the same index, once a source is chosen.
bool FdsCase::readsAs(const FdsCase& other) const {
  const FdsOptions &a = options_, &b = other.options_;
  return source().name == other.source().name && a.quantity == b.quantity &&
         a.massExtinction == b.massExtinction && a.visibilityFactor == b.visibilityFactor &&
         (a.partly == b.partly || other.leftOut_.empty()) && a.maxMemory == b.maxMemory &&
         heldMeshes_ == other.heldMeshes_;
}

Result<FdsCase> FdsCase::open(SmvIndex index, const FdsOptions& options, const FdsCase* earlier) {
  FdsCase opened;
  opened.options_ = options;
  opened.index_ = std::move(index);
  opened.remarks_ = opened.index_.remarks;
  VOLUTE_ASSIGN(opened.heldMeshes_, meshesOfShare(opened.index_, options.share));
  VOLUTE_TRY(opened.checkSize());
  VOLUTE_TRY(opened.chooseSource(options));
  opened.chosenBy_ = opened.remarks_.size();
  if (earlier && opened.readsAs(*earlier)) {
    FdsCase same = *earlier;
    const auto own = same.remarks_.begin() + static_cast<std::ptrdiff_t>(same.chosenBy_);
    opened.remarks_.insert(opened.remarks_.end(), own, same.remarks_.end());
    same.remarks_ = std::move(opened.remarks_);
    same.chosenBy_ = opened.chosenBy_;
    same.options_ = options;
    return same;
  }
  VOLUTE_TRY(opened.openParts());
  VOLUTE_TRY(opened.findTimes());
  VOLUTE_TRY(opened.findBytes());
  VOLUTE_TRY(opened.findVisibility());
  VOLUTE_TRY(opened.buildGrid());
  opened.findChanges();
  opened.noteMissingMeshes();
  return opened;
}

/// Obstructions take a byte for each cell of the meshes, whatever part of them has smoke.
Status FdsCase::checkSize() const {
  double cells = 0;
  for (std::size_t i = 0; i < heldMeshes_.size(); ++i)
    cells += heldMeshes_[i] ? static_cast<double>(index_.meshes[i].cellCount()) : 0;
  if (cells <= static_cast<double>(options_.maxMemory))
    return {};
  return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
              "{}: its meshes have {:.3g} cells, which need {:.3g} GB; {:.3g} GB are allowed",
              index_.path.string(), cells, cells * 1e-9,
              static_cast<double>(options_.maxMemory) * 1e-9);
}

Status FdsCase::chooseSource(const FdsOptions& options) {
  sources_ = options.quantity.empty() ? findSources(index_) : findSources(index_, options.quantity);
  std::string names;
  for (const FdsSource& source : sources_) names += (names.empty() ? "" : ", ") + source.name;
  const auto found = std::ranges::find_if(sources_, [&](const FdsSource& source) {
    return options.source.empty() ? source.volume || !options.volume
                                  : source.name == options.source;
  });
  if (found != sources_.end()) {
    chosen_ = static_cast<std::size_t>(found - sources_.begin());
    if (options.source.empty())
      weighSources(options);
    noteOtherSmoke();
    return {};
  }
  if (sources_.empty() && !options.quantity.empty()) {
    return fail(ErrorCode::kNotFound, "{}: no file of the case has '{}'", index_.path.string(),
                options.quantity);
  }
  if (sources_.empty() && options.orClear) {
    sources_.push_back(clearSource(index_));
    chosen_ = 0;
    return {};
  }
  if (sources_.empty()) {
    return fail(ErrorCode::kNotFound,
                "{}: nothing in the case says how thick the smoke is: it needs slices of "
                "EXTINCTION COEFFICIENT (&SLCF), or SMOKE3D{}",
                index_.path.string(), unusedSmoke(index_));
  }
  if (options.source.empty()) {
    return fail(ErrorCode::kNotFound,
                "{}: the case has {} in layers only ({}), nothing that fills a volume",
                index_.path.string(), options.quantity.empty() ? "smoke" : options.quantity, names);
  }
  return fail(ErrorCode::kNotFound, "{}: no source '{}'; the case has {}", index_.path.string(),
              options.source, names);
}

/// Of the first of its files that can be read; 0: none can.
std::size_t FdsCase::storedTimes(const FdsSource& source) const {
  const auto framesOf = [](const auto& file) {
    return file ? file->frames().times.size() : std::size_t{0};
  };
  std::set<double> plots;
  for (const FdsSourcePart& part : source.parts) {
    const FdsMesh& mesh = index_.meshes[static_cast<std::size_t>(part.mesh)];
    std::size_t times = 0;
    if (source.kind == FdsFileKind::kSlice) {
      times = framesOf(FdsSliceFile::open(index_.slices[part.entry], mesh));
    } else if (source.kind == FdsFileKind::kPlot) {
      for (const FdsPlotEntry& plot : index_.plots) {
        if (plot.mesh == part.mesh && plotVariable(plot, source.plotted))
          plots.insert(plot.time);
      }
      times = plots.size();
    } else {
      std::filesystem::path path = index_.smoke[part.entry].file;
      if (source.kind == FdsFileKind::kSmoke16)
        times = framesOf(FdsSmoke16File::open(path.replace_extension(".s16"), mesh));
      else if (source.kind == FdsFileKind::kSmokeDensity)
        times = framesOf(FdsSmokeFile::open(path.replace_extension(".s3dd"), mesh));
      else
        times = framesOf(FdsSmokeFile::open(path, mesh));
    }
    if (times > 0)
      return times;
  }
  return 0;
}

/// Whether another source than the first that will do is better: FdsCase::open() says when.
void FdsCase::weighSources(const FdsOptions& options) {
  std::vector<std::size_t> eligible;
  for (std::size_t i = chosen_; i < sources_.size(); ++i) {
    if ((sources_[i].volume || !options.volume) && sources_[i].species == source().species)
      eligible.push_back(i);
  }
  if (eligible.size() < 2)
    return;
  std::size_t times = storedTimes(sources_[chosen_]);
  if (times == 0)
    return;  // what is wrong with it is said
  const auto partsLeftOut = [&](std::size_t i) { return meshesInPart(index_, sources_[i]).size(); };
  std::string others;
  std::string reason =
      sources_[chosen_].volume
          ? "the most precise"
          : "the most precise, in layers alone: what is above and below is not known";
  for (const std::size_t i : eligible) {
    if (i == chosen_ || (sources_[chosen_].volume && !sources_[i].volume))
      continue;
    const std::size_t its = storedTimes(sources_[i]);
    int more = meshesOf(sources_[i]) - meshesOf(sources_[chosen_]);
    // Volumes and pictures are of one source, so that what leaves parts of meshes out is less.
    const bool fuller = options.volume && partsLeftOut(i) < partsLeftOut(chosen_);
    if (fuller)
      more = std::max(more, 1);
    // A layer covers the meshes that it cuts, and is for who looks along it.
    if (!sources_[chosen_].volume && sources_[i].volume)
      more = std::min(more, 0);
    if (its == 0 || more < 0 || (more == 0 && its < 2 * times))
      continue;
    if (more > 0 && its < times)
      continue;
    reason = fuller     ? fmt::format("{} leaves parts of meshes out", sources_[chosen_].name)
             : more > 0 ? fmt::format("it has files of {} meshes, {} of {}", meshesOf(sources_[i]),
                                      sources_[chosen_].name, meshesOf(sources_[chosen_]))
                        : fmt::format("it has {} stored times, {} only {}", its,
                                      sources_[chosen_].name, times);
    chosen_ = i;
    times = its;
  }
  if (sources_[chosen_].kind != FdsFileKind::kSlice &&
      std::ranges::all_of(eligible, [&](std::size_t i) {
        return i == chosen_ || sources_[i].kind == FdsFileKind::kPlot;
      }))
    reason = "PLOT3D has few times";
  for (const std::size_t i : eligible) {
    if (i != chosen_)
      others += (others.empty() ? "" : ", ") + sources_[i].name;
  }
  remarks_.push_back(
      fmt::format("{}: {} is read from {} ({} stored times): {}; the case also has {}",
                  index_.path.string(), options.quantity.empty() ? "smoke" : options.quantity,
                  sources_[chosen_].name, times, reason, others));
}

/// Smoke of several kinds adds up, and that of one of them is read.
void FdsCase::noteOtherSmoke() {
  std::set<std::string> others;
  for (const FdsSource& source : sources_) {
    if (source.species != this->source().species)
      others.insert(printable(source.species));
  }
  if (others.empty())
    return;
  remarks_.push_back(
      {RemarkCode::kLeftOut,
       fmt::format("{}: warning: only the smoke of {} is seen; that of {} is thick "
                   "by itself and is left out",
                   index_.path.string(), printable(source().species), fmt::join(others, ", "))});
}

Status FdsCase::openParts() {
  const auto& wanted = source().parts;
  std::vector<Result<std::shared_ptr<Part>>> opened(wanted.size());
  parallelFor(wanted.size(), [&](std::size_t i) { opened[i] = openPart(wanted[i]); });
  for (auto& part : opened) {
    if (!part && part.error().code == ErrorCode::kTruncated) {
      leftOut_.push_back({RemarkCode::kDamaged, part.error().message + ": the file is left out"});
      continue;
    }
    if (!part && part.error().code == ErrorCode::kNotFound) {
      const auto mesh = wanted[static_cast<std::size_t>(&part - opened.data())].mesh;
      const std::string why = fmt::format("{}; {} names it for mesh {}", part.error().message,
                                          index_.path.filename().string(), mesh + 1);
      if (options_.partly) {
        leftOut_.push_back({RemarkCode::kDamaged,
                            why + ": what it holds is not known there; copy it beside that file"});
        continue;
      }
      return fail(ErrorCode::kNotFound,
                  "{}: copy it beside that file (volute info lists what is missing)", why);
    }
    VOLUTE_TRY(part);
    for (const Remark& remark : (*part)->file->frames().remarks) leftOut_.push_back(remark);
    const bool empty = std::ranges::any_of((*part)->lattice.planes,
                                           [](const auto& planes) { return planes.size() < 2; });
    if (empty) {
      leftOut_.push_back({RemarkCode::kLeftOut,
                          fmt::format("{}: holds nothing but cells outside of its mesh: it is left "
                                      "out",
                                      (*part)->path.string())});
    } else if ((*part)->file->frames().times.empty()) {
      leftOut_.push_back(
          {RemarkCode::kDamaged,
           fmt::format("{}: holds no whole frame yet: it is left out", (*part)->path.string())});
    } else {
      parts_.push_back(std::move(*part));
    }
  }
  if (source().kind == FdsFileKind::kPlot)
    noteOtherPlots();
  remarks_.insert(remarks_.end(), leftOut_.begin(), leftOut_.end());
  if (parts_.empty()) {
    return fail(ErrorCode::kTruncated, "{}: no file of the source '{}' holds a whole frame{}{}",
                index_.path.string(), source().name, remarks_.empty() ? "" : ": ",
                remarks_.empty() ? "" : remarks_.back().sentence);
  }
  return {};
}

/// PLOT3D files without the quantity, or with it in another unit.
void FdsCase::noteOtherPlots() {
  std::vector<const FdsPlotEntry*> without;
  std::size_t count = 0;
  for (const FdsPlotEntry& plot : index_.plots) {
    const auto part = std::ranges::find(source().parts, plot.mesh, &FdsSourcePart::mesh);
    if (part == source().parts.end())
      continue;
    ++count;
    if (!plotVariableOf(plot, *part))
      without.push_back(&plot);
  }
  if (without.empty())
    return;
  const FdsLabels& labels = labelsOf(index_, source(), source().parts.front());
  leftOut_.push_back(
      {RemarkCode::kLeftOut,
       fmt::format("{}: {} of {} PLOT3D files have no {}{}, and are left out (the first is {}, of "
                   "{:g} s)",
                   index_.path.string(), without.size(), count, printable(labels.quantity),
                   labels.unit.empty() ? "" : " in " + printable(labels.unit),
                   without.front()->file.filename().string(), without.front()->time)});
}

/// The times that all files have, and, if some may be unknown, those before the first and after the
/// last of a file's own. What one file has and another has not is said with both names.
Status FdsCase::findTimes() {
  std::vector<std::size_t> next(parts_.size(), 0);
  std::vector<std::vector<std::size_t>> frames(parts_.size());
  std::vector<double> dropped;
  bool common = false;
  const auto timesOf = [&](std::size_t i) -> const std::vector<double>& {
    return parts_[i]->file->frames().times;
  };
  for (;;) {
    double time = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (next[i] < timesOf(i).size())
        time = std::min(time, timesOf(i)[next[i]]);
    }
    if (!std::isfinite(time))
      break;
    const auto has = [&](std::size_t i) {
      return next[i] < timesOf(i).size() && sameTime(timesOf(i)[next[i]], time);
    };
    bool everywhere = true, kept = true;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const bool outside = next[i] == 0 || next[i] == timesOf(i).size();
      everywhere = everywhere && has(i);
      kept = kept && (has(i) || (options_.partly && outside));
    }
    common = common || everywhere;
    (kept ? times_ : dropped).push_back(everywhere ? timesOf(0)[next[0]] : time);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const bool its = has(i);
      if (kept)
        frames[i].push_back(its ? next[i] : Part::kNoFrame);
      next[i] += its ? 1 : 0;
    }
  }
  if (!common) {
    return fail(ErrorCode::kTruncated, "{}: the {} files of the source '{}' have no time in common",
                index_.path.string(), parts_.size(), source().name);
  }
  storedUntil_ = dropped.empty() ? times_.back() : std::max(times_.back(), dropped.back());
  if (!dropped.empty())
    noteDroppedTimes(dropped);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    whole_ = whole_ && std::ranges::find(frames[i], Part::kNoFrame) == frames[i].end();
    parts_[i]->frameAt = std::move(frames[i]);
  }
  if (!whole_)
    noteShortFiles();
  return {};
}

bool FdsCase::knows(std::size_t lattice, double time) const {
  const Place place = placeOf(time);
  const Part& part = *parts_[lattice];
  return part.hasFrame(place.first) && (place.share <= 0 || part.hasFrame(place.second));
}

/// Files that begin later or end earlier than others.
void FdsCase::noteShortFiles() {
  constexpr std::size_t kNamed = 3;
  std::vector<std::string> files;
  for (const auto& part : parts_) {
    const auto& times = part->file->frames().times;
    const bool late = !part->hasFrame(0), early = !part->hasFrame(times_.size() - 1);
    if (!late && !early)
      continue;
    std::string when = late ? fmt::format("before {:g} s", times.front()) : "";
    if (early)
      when += fmt::format("{}after {:g} s", late ? " and " : "", times.back());
    files.push_back(fmt::format("{} in mesh {} ({})", when, part->what.mesh + 1,
                                part->path.filename().string()));
  }
  const std::size_t count = files.size();
  files.resize(std::min(count, kNamed));
  leftOut_.push_back(
      {RemarkCode::kLeftOut,
       fmt::format(
           "{}: '{}' is stored from {:g} to {:g} s, but not known {}{}: {}", index_.path.string(),
           source().name, times_.front(), times_.back(), fmt::join(files, ", nor "),
           count > kNamed ? fmt::format(", nor in {} others", count - kNamed) : "",
           index_.ended ? "FDS has ended, so files were cut or are of another run: copy them again"
                        : "the case may still be running; else copy the files again")});
  remarks_.push_back(leftOut_.back());
}

void FdsCase::noteDroppedTimes(std::span<const double> dropped) {
  const auto fewer = [](const auto& a, const auto& b) {
    return a->file->frames().times.size() < b->file->frames().times.size();
  };
  const auto [shortest, longest] = std::ranges::minmax_element(parts_, fewer);
  const auto count = [](const std::shared_ptr<Part>& part) {
    const auto& times = part->file->frames().times;
    return fmt::format("{} (mesh {}) has {}, the last at {:g} s", part->path.filename().string(),
                       part->what.mesh + 1, times.size(), times.back());
  };
  leftOut_.push_back(
      {RemarkCode::kLeftOut,
       fmt::format(
           "{}: {} of {} stored times are left out ({:g} to {:g} s): not all files of the source "
           "'{}' "
           "have them. {}, {}: {}",
           index_.path.string(), dropped.size(), dropped.size() + times_.size(), dropped.front(),
           dropped.back(), source().name, count(*longest), count(*shortest),
           index_.ended ? "FDS has ended, so files were cut or are of another run: copy them again"
                        : "the case may still be running; else copy the files again")});
  remarks_.push_back(leftOut_.back());
}

bool FdsCase::holds(const Part& part) const {
  return heldMeshes_[static_cast<std::size_t>(part.what.mesh)];
}

Status FdsCase::buildGrid() {
  std::vector<FdsLattice> lattices;
  std::vector<bool> held;
  double bytes = 0;
  for (const auto& part : parts_) {
    lattices.push_back(part->lattice);
    held.push_back(holds(*part));
    if (!held.back())
      continue;
    const double perValue = source().kind == FdsFileKind::kSlice ? 4 : 12;
    bytes += 3 * perValue * static_cast<double>(part->lattice.valueCount());  // two and one between
  }
  if (bytes > static_cast<double>(options_.maxMemory)) {
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "{}: its frames need {:.3g} GB, {:.3g} GB are allowed", index_.path.string(),
                bytes * 1e-9, static_cast<double>(options_.maxMemory) * 1e-9);
  }
  noteGaps(lattices);
  VOLUTE_ASSIGN(grid_, FdsGrid::create(std::move(lattices), std::move(held)));
  return {};
}

/// Faces of meshes that look at each other over less than a cell, and which FDS does not connect.
void FdsCase::noteGaps(std::span<const FdsLattice> lattices) {
  int count = 0;
  std::string first;
  const double separation = meshSeparation(lattices);
  for (const FdsLattice& a : lattices) {
    const Box3 one = a.bounds();
    for (const FdsLattice& b : lattices) {
      const Box3 other = b.bounds();
      for (int axis = 0; axis < 3; ++axis) {
        const double gap = other.min[axis] - one.max[axis];
        if (!(gap > 0) || a.mesh == b.mesh || a.thinAxis >= 0 || b.thinAxis >= 0)
          continue;
        const auto& planes = a.planes[axis];
        const double cell = planes.back() - planes[planes.size() - 2];
        if (gap <= std::min(meshSeparation(a, axis, separation),
                            meshSeparation(b, axis, separation)) ||
            gap >= cell)
          continue;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const bool facing = one.min[u] < other.max[u] && other.min[u] < one.max[u] &&
                            one.min[v] < other.max[v] && other.min[v] < one.max[v];
        if (facing && count++ == 0)
          first = fmt::format("{} and {} by {:.4g} mm on {}", a.mesh + 1, b.mesh + 1, 1e3 * gap,
                              "xyz"[axis]);
      }
    }
  }
  if (count > 0) {
    remarks_.push_back(
        {RemarkCode::kDoubtful,
         fmt::format("{}: {} pairs of meshes are apart by more than FDS connects ({:.3g} mm): "
                     "{}{}. Nothing is known in between: sight lines across count as blocked by "
                     "smoke that nobody knows",
                     index_.path.string(), count, 1e3 * separation, first,
                     count > 1 ? ", and others" : "")});
  }
}

void FdsCase::findChanges() {
  for (const FdsMesh& mesh : index_.meshes) {
    for (const FdsObstruction& one : mesh.obstructions) {
      for (const auto& event : one.events) changes_.push_back(event.time);
    }
    for (const FdsVent& one : mesh.vents) {
      for (const auto& event : one.events) changes_.push_back(event.time);
    }
  }
  std::ranges::sort(changes_);
}

void FdsCase::noteMissingMeshes() {
  std::vector<bool> covered(index_.meshes.size(), false);
  for (const auto& part : parts_) covered[static_cast<std::size_t>(part->what.mesh)] = true;
  std::string missing;
  int count = 0;
  for (std::size_t i = 0; i < covered.size(); ++i) {
    if (!covered[i] && ++count <= 8)
      missing += (missing.empty() ? "" : ", ") + std::to_string(i + 1);
  }
  if (count > 0) {
    uncovered_ = fmt::format("{}: the source '{}' does not cover {} of {} meshes ({}{})",
                             index_.path.string(), source().name, count, covered.size(), missing,
                             count > 8 ? ", ..." : "");
    remarks_.push_back({RemarkCode::kLeftOut, uncovered_});
  }
  if (const auto partly = meshesInPart(index_, source()); !partly.empty()) {
    remarks_.push_back(fmt::format(
        "{}: the 3D slices of '{}' leave a part of {} of {} meshes out "
        "(the first is {})",
        index_.path.string(), source().name, partly.size(), covered.size(), *partly.begin() + 1));
  }
}

/// Means over nodes, which obstructions and walls dilute.
static bool isAveraged(FdsFileKind kind) {
  return kind == FdsFileKind::kSmoke || kind == FdsFileKind::kSmokeDensity ||
         kind == FdsFileKind::kSmoke16;
}

/// How many obstructions and vents have come or gone until a time.
std::size_t FdsCase::changesUntil(double time) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(changes_, time) - changes_.begin());
}

void FdsCase::findGeometry(Part& part, double time) const {
  const std::size_t changes = changesUntil(time);
  if (part.geometry && part.geometry->changes == changes)
    return;
  const FdsMesh& mesh = index_.meshes[static_cast<std::size_t>(part.what.mesh)];
  const auto own = static_cast<std::size_t>(part.what.mesh);
  auto made = std::make_shared<Part::Geometry>();
  made->changes = changes;
  std::vector<std::vector<std::uint8_t>> solid(index_.meshes.size());
  if (isAveraged(source().kind)) {
    for (std::size_t i = 0; i < solid.size(); ++i) {
      if (near(index_.meshes[i].bounds(), mesh.bounds()))
        solid[i] = solidCells(index_.meshes[i], time);
    }
    made->round = cellsRoundNodes(index_, part.what.mesh, time, solid);
  } else {
    solid[own] = solidCells(mesh, time);
  }
  made->needed = part.needed(mesh, solid[own]);
  part.geometry = std::move(made);
}

/// What was stored at the first stored time; empty where that is nothing but zeros.
Result<std::vector<float>> FdsCase::firstFrame(Part& part) const {
  std::vector<float> first;
  if (part.beginsClear && *part.beginsClear)
    return first;
  first.resize(part.file->values());
  VOLUTE_TRY(part.file->readFrame(0, first));
  part.beginsClear = std::ranges::none_of(first, [](float value) { return value > 0; });
  if (*part.beginsClear)
    first.clear();
  return first;
}

namespace {

constexpr NodeCells kAllGas{8, 0, 0};

/// Bands of stored values. Those of bytes are looked up, with the gas alone of nodes in the open.
class Bands {
 public:
  explicit Bands(const SmokeScale& scale) : scale_(scale) {
    if (scale.bytes == SmokeScale::Bytes::kNone)
      return;
    for (int byte = 0; byte < 256; ++byte) {
      all_.push_back(scale.band(static_cast<float>(byte)));
      open_.push_back(gasOnly(all_.back(), SmokeBand{}, kAllGas));
    }
  }

  SmokeBand of(float stored) const {
    return all_.empty() ? scale_.band(stored) : all_[static_cast<std::uint8_t>(stored)];
  }

  /// Of the gas round a node that has eight cells of it.
  SmokeBand inTheOpen(float stored) const {
    return open_.empty() ? gasOnly(scale_.band(stored), SmokeBand{}, kAllGas)
                         : open_[static_cast<std::uint8_t>(stored)];
  }

 private:
  const SmokeScale& scale_;
  std::vector<SmokeBand> all_, open_;  // of each byte; empty: of other values
};

bool isAllGas(const NodeCells& cells) {
  return cells.gas == kAllGas.gas && cells.open == 0 && cells.held == 0;
}

}  // namespace

Result<std::shared_ptr<const FdsValues>> FdsCase::partValues(Part& part,
                                                             std::size_t position) const {
  const std::size_t frame = part.frameAt[position];
  const double time = part.file->frames().times[frame];
  std::vector<float> stored(part.file->values());
  VOLUTE_TRY(part.file->readFrame(frame, stored));
  VOLUTE_ASSIGN(const SmokeScale scale, scaleOf(part, frame));
  findGeometry(part, times_[position]);
  const std::shared_ptr<const Part::Geometry> geometry = part.geometry;
  // What FDS counts as the flames' temperature of solids and behind walls is not known, so the mean
  // stays; of the air's it is the ambient one.
  const bool warm = options_.quantity == kFdsTemperature && !geometry->round.empty();
  const double ambient = inputOf(index_).ambient.value_or(20);
  const bool averaged = !geometry->round.empty() && scale.bytes != SmokeScale::Bytes::kTemperature;
  std::vector<float> first;  // stored values of the first stored time, where there were any
  SmokeScale firstScale;
  if (averaged) {
    VOLUTE_ASSIGN(first, firstFrame(part));
    VOLUTE_ASSIGN(firstScale, scaleOf(part, 0));
  }
  const Bands bands(scale), firstBands(firstScale);
  const bool means =
      part.lattice.nodal && !scale.asStored && scale.quantity == SmokeQuantity::kVisibility;
  const auto ofMeans =
      means ? bandsOfMeans(scale, stored, part.axes.size) : std::vector<SmokeBand>();
  const auto bandOf = [&](std::size_t from) {
    if (means)
      return ofMeans[from];
    if (warm && !isAllGas(geometry->round[from]))
      return gasOnly(bands.of(stored[from]), ambient, geometry->round[from]);
    if (!averaged)
      return bands.of(stored[from]);
    const NodeCells& cells = geometry->round[from];
    if (isAllGas(cells))
      return bands.inTheOpen(stored[from]);
    const bool held = !first.empty() && first[from] > 0;
    return gasOnly(bands.of(stored[from]), held ? firstBands.of(first[from]) : SmokeBand{}, cells);
  };

  auto values = std::make_shared<FdsValues>();
  values->value.assign(geometry->needed.size(), std::numeric_limits<float>::quiet_NaN());
  if (scale.inexact())
    values->low = values->high = values->value;
  std::size_t i = 0;
  for (const int z : part.axes.place[2]) {
    for (const int y : part.axes.place[1]) {
      const std::size_t row =
          (static_cast<std::size_t>(z) * part.axes.size[1] + y) * part.axes.size[0];
      for (const int x : part.axes.place[0]) {
        const std::size_t at = i++;
        const std::size_t from = row + static_cast<std::size_t>(x);
        if (geometry->needed[at] == 0)
          continue;
        const SmokeBand band = bandOf(from);
        if (!std::isfinite(band.value)) {
          return fail(ErrorCode::kInvalidData,
                      "{}: frame {} (t = {} s): value {} is {}, in gas; expected {}: the file is "
                      "damaged, or holds another quantity than it says",
                      part.path.string(), frame, time, from, stored[from],
                      scale.asStored ? "a number" : "0 or more");
        }
        values->value[at] = band.value;
        if (scale.inexact()) {
          values->low[at] = band.low;
          values->high[at] = band.high;
        }
      }
    }
  }
  return std::shared_ptr<const FdsValues>(std::move(values));
}

Result<std::shared_ptr<const FdsCase::Frame>> FdsCase::frame(std::size_t position) {
  for (const auto& [kept, frame] : kept_) {
    if (kept == position)
      return frame;
  }
  auto frame = std::make_shared<Frame>(parts_.size());
  std::mutex mutex;
  std::optional<Error> error;
  parallelFor(parts_.size(), [&](std::size_t i) {
    if (holds(*parts_[i]) && !parts_[i]->hasFrame(position))
      return;
    auto values =
        holds(*parts_[i]) ? partValues(*parts_[i], position) : std::make_shared<const FdsValues>();
    if (values) {
      (*frame)[i] = std::move(*values);
      return;
    }
    const std::lock_guard lock(mutex);
    if (!error)
      error = values.error();
  });
  if (error)
    return tl::unexpected<Error>(*error);
  if (kept_.size() == 2)
    kept_.erase(kept_.begin());
  kept_.emplace_back(position, frame);
  return std::shared_ptr<const Frame>(std::move(frame));
}

namespace {

/// (1 - share) a + share b; where one has no value, the other's.
std::vector<float> between(const std::vector<float>& a, const std::vector<float>& b, double share) {
  std::vector<float> out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i]) || std::isnan(b[i])) {
      out[i] = std::isnan(a[i]) ? b[i] : a[i];
    } else if (std::isinf(a[i]) || std::isinf(b[i])) {
      out[i] = std::numeric_limits<float>::infinity();
    } else {
      out[i] = static_cast<float>((1 - share) * a[i] + share * b[i]);
    }
  }
  return out;
}

std::shared_ptr<const FdsValues> between(const FdsValues& a, const FdsValues& b, double share) {
  return std::make_shared<FdsValues>(FdsValues{between(a.value, b.value, share),
                                               between(a.low, b.low, share),
                                               between(a.high, b.high, share)});
}

}  // namespace

/// What each cell holds at a time; gas without a value in either stored frame is unknown.
FdsCase::Cells FdsCase::cellsAt(double time, double frameBefore, double frameAfter,
                                const Frame& values) const {
  // Frames have values for the gas of their own times.
  const std::size_t changes = changesUntil(time);
  const bool known = changesUntil(frameBefore) == changes && changesUntil(frameAfter) == changes;
  Cells cells(parts_.size());
  parallelFor(parts_.size(), [&](std::size_t i) {
    Part& part = *parts_[i];
    if (!holds(part)) {
      cells[i] = std::make_shared<const std::vector<FdsCell>>();
      return;
    }
    Part::Cells& kept = values[i] ? part.cells : part.unknownCells;
    if ((known || !values[i]) && kept.second && kept.first == changes) {
      cells[i] = kept.second;
      return;
    }
    const FdsMesh& mesh = index_.meshes[static_cast<std::size_t>(part.what.mesh)];
    const auto solid = solidCells(mesh, time);
    auto states = std::make_shared<std::vector<FdsCell>>(part.lattice.cellCount(), FdsCell::kGas);
    part.forCells([&](const std::array<int, 3>& cell) {
      FdsCell& state = (*states)[part.lattice.cellAt(cell)];
      if (part.isSolid(mesh, solid, cell)) {
        state = FdsCell::kSolid;
      } else if (!values[i] || (!known && !part.hasValues(values[i]->value, cell))) {
        state = FdsCell::kUnknown;
      }
    });
    cells[i] = std::move(states);
    if (known || !values[i])
      kept = {changes, cells[i]};
  });
  return cells;
}

FdsCase::Place FdsCase::placeOf(double time) const {
  const auto after = std::upper_bound(times_.begin(), times_.end(), time);
  const std::size_t first = after == times_.begin() ? 0 : (after - times_.begin()) - 1;
  const std::size_t second = std::min(first + 1, times_.size() - 1);
  const double length = times_[second] - times_[first];
  return {first, second, length > 0 ? std::clamp((time - times_[first]) / length, 0.0, 1.0) : 0};
}

Result<FdsField> FdsCase::field(double time) {
  const auto [first, second, share] = placeOf(time);
  VOLUTE_ASSIGN(const auto a, frame(first));
  Frame values = *a;
  if (share > 0) {
    VOLUTE_ASSIGN(const auto b, frame(second));
    parallelFor(values.size(), [&, share = share](std::size_t i) {
      values[i] = (*a)[i] && (*b)[i] ? between(*(*a)[i], *(*b)[i], share) : nullptr;
    });
  }
  Cells cells = cellsAt(time, times_[first], share > 0 ? times_[second] : times_[first], values);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i])
      continue;
    std::shared_ptr<const FdsValues>& unknown = parts_[i]->unknownValues;
    if (!unknown) {
      constexpr float kNotKnown = std::numeric_limits<float>::quiet_NaN();
      unknown = std::make_shared<const FdsValues>(
          FdsValues{std::vector(parts_[i]->lattice.valueCount(), kNotKnown), {}, {}});
    }
    values[i] = unknown;
  }
  return FdsField(grid_, std::move(values), std::move(cells));
}

}  // namespace volute
