// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/volume_resampling.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "volute/base/plain_number.hpp"
#include "volute/io/output_names.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/volume_files/volume_extraction.hpp"
#include "volute/volume_files/volume_grids.hpp"
#include "volute/volume_files/volume_writer.hpp"

namespace volute {
namespace {

/// The frames of a grid before they are resampled.
struct OldGrid {
  std::unique_ptr<FrameSource> source;
  std::vector<GridMatrix> places;
  VectorKind vectors;
  std::optional<GridDescription> description;
  std::vector<int> positions;  ///< of its frames in the input
  OwnError ownError{};         ///< of a .volute
};

/// The lattice of the first frame of a volume.
Lattice latticeOf(const FrameSource& source, const std::vector<GridMatrix>& places) {
  const VolumeInfo& info = source.info();
  return {indexToWorld(info, places, 0), {{0, 0, 0}, {info.x, info.y, info.z}}};
}

/// Where a box of the world lies among voxels; what a box only touches is left out.
void extend(IndexBox& all, const Box3& box, const GridMatrix& worldFromBox,
            const GridMatrix& indexToWorld) {
  constexpr double kTouches = 1e-6, kFarthest = 1e12;  // voxels
  const Mat3 back = linearOf(indexToWorld).inverse();
  Vec3 low = Vec3::Constant(kFarthest), high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 place = back * (linearOf(worldFromBox) * box.corner(corner) +
                               offsetOf(worldFromBox) - offsetOf(indexToWorld));
    low = low.cwiseMin(place), high = high.cwiseMax(place);
  }
  IndexBox one;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t axis = a;
    const auto whole = [&](double at) {
      return std::llround(std::clamp(at, -kFarthest, kFarthest));
    };
    one.begin[a] = whole(std::floor(low[axis] + 0.5 + kTouches));
    one.end[a] =
        std::max<std::int64_t>(whole(std::ceil(high[axis] + 0.5 - kTouches)), one.begin[a] + 1);
  }
  all.extend(one);
}

constexpr GridMatrix kWorld{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// The new lattice along the axes, or as it is stated, without its box.
Result<GridMatrix> newMatrix(const ResampleRequest& request, const OldGrid& old) {
  if (request.matrix) {
    if (!isSound(*request.matrix)) {
      return failFor("matrix", ErrorCode::kInvalidArgument,
                     "it is not finite, or makes voxels flat; expected one that can be undone");
    }
    return *request.matrix;
  }
  const GridMatrix own = indexToWorld(old.source->info(), old.places, 0);
  const GridSpace space = spaceOf(own);
  const Vec3 voxel =
      request.voxelSize.value_or(Vec3(space.voxelSize[0], space.voxelSize[1], space.voxelSize[2]));
  // Along the axes the faces of old voxels are faces of new ones.
  Vec3 corner = Vec3::Zero();
  if (request.bounds)
    corner = request.bounds->min;
  else if (old.places.empty())
    corner = old.source->info().bounds.min;
  return gridMatrix(voxel.asDiagonal(), corner + 0.5 * voxel);
}

Result<Lattice> newLattice(const ResampleRequest& request, const OldGrid& old,
                           const std::string& path) {
  Lattice lattice;
  VOLUTE_ASSIGN(lattice.indexToWorld, newMatrix(request, old));
  const VolumeInfo& info = old.source->info();
  if (request.bounds) {
    extend(lattice.box, *request.bounds, kWorld, lattice.indexToWorld);
  } else {
    Box3 content = info.bounds;
    // How far the basis reaches beyond the voxels, unless they stay what they are.
    const double beyond = request.basis == Basis::kBox         ? 0
                          : request.basis == Basis::kTrilinear ? 0.5
                                                               : 1.5;
    if (!old.places.empty() || request.voxelSize || request.matrix) {
      content.min -= beyond * info.voxelSize();
      content.max += beyond * info.voxelSize();
    }
    if (old.places.empty())
      extend(lattice.box, content, kWorld, lattice.indexToWorld);
    for (const GridMatrix& place : old.places)
      extend(lattice.box, content, place, lattice.indexToWorld);
  }
  constexpr std::int64_t kMaxIndex = 1'000'000'000;
  for (std::size_t a = 0; a < 3; ++a) {
    if (lattice.box.size(static_cast<int>(a)) > kMaxIndex || lattice.box.begin[a] < -kMaxIndex ||
        lattice.box.end[a] > kMaxIndex) {
      return fail(ErrorCode::kTooLarge, {Hint::raise("voxel_size"), Hint::set("bounds")},
                  "{}: '{}' would take voxels {} to {} along {}; expected indices within {}", path,
                  info.name, lattice.box.begin[a], lattice.box.end[a], "xyz"[a], kMaxIndex);
    }
  }
  return lattice;
}

bool isAlongAxes(const GridMatrix& matrix) {
  const GridSpace space = spaceOf(matrix);
  return matrix == alongAxes(space.voxelSize, space.origin);
}

/// What files say of a grid on its new voxels.
GridDescription describe(const OldGrid& old, const Lattice& lattice) {
  const VolumeInfo& info = old.source->info();
  GridDescription made = old.description.value_or(GridDescription{
      .type = typeOfValues(*old.source), .gridClass = info.levelSet ? "level set" : "fog volume"});
  if (!old.description) {
    const MetadataList none;
    for (int frame = 0; frame < info.frames; ++frame) made.metadata.add(&none);
  }
  const GridSpace space = spaceOf(lattice.indexToWorld);
  const auto& size = space.voxelSize;
  made.voxelSize = size, made.origin = space.origin;
  made.begin = lattice.box.begin;
  made.map =
      size[0] == size[1] && size[0] == size[2] ? "UniformScaleTranslateMap" : "ScaleTranslateMap";
  made.shifts.clear(), made.matrices.clear();
  made.voxels = made.memory = 0;
  if (!isAlongAxes(lattice.indexToWorld)) {
    made.map = "AffineMap";
    made.matrices.assign(static_cast<std::size_t>(info.frames), lattice.indexToWorld);
  }
  return made;
}

/// Whether voxels of all frames lie along the same axes as those of the lattice, in their order.
bool isAlong(const OldGrid& old, const Lattice& lattice) {
  const VolumeInfo& info = old.source->info();
  for (std::size_t frame = 0; frame < std::max<std::size_t>(1, old.places.size()); ++frame) {
    const AffineLattices map(indexToWorld(info, old.places, frame), lattice.indexToWorld);
    const Vec3 along = map.linear().diagonal();
    const Mat3 rest = map.linear() - Mat3(along.asDiagonal());
    if (!(along.minCoeff() > 0) || rest.cwiseAbs().maxCoeff() > 1e-9 * along.maxCoeff())
      return false;
  }
  return true;
}

/// Of vectors along the grid's own axes, in each frame; of others nothing.
std::vector<Mat3> turnsOf(const OldGrid& old, const Lattice& lattice) {
  std::vector<Mat3> turns;
  const VolumeInfo& info = old.source->info();
  if (info.channels != 3 || !old.vectors.local)
    return turns;
  for (std::size_t frame = 0; frame < static_cast<std::size_t>(info.frames); ++frame) {
    const AffineLattices map(indexToWorld(info, old.places, frame), lattice.indexToWorld);
    turns.push_back(vectorTurn(old.vectors.type, map.linear().inverse()));
  }
  return turns;
}

/// What the new voxels of a grid left out in each frame.
class CutLog {
 public:
  void add(const std::string& frame, const VoxelsCut& cut) {
    const std::lock_guard lock(mutex_);
    if (cut.all > 0)
      frames_[frame] = cut;
  }

  /// Whether there was something, and nothing of it was left.
  bool all() const {
    return !frames_.empty() && std::ranges::all_of(frames_, [](const auto& frame) {
      return frame.second.outside == frame.second.all;
    });
  }

  /// "in 5 of 6 frames, most in 1006: 11513 of 11513 voxels"; empty where nothing was.
  std::string text() const {
    const auto lost = [](const VoxelsCut& cut) {
      return static_cast<double>(cut.outside) / static_cast<double>(cut.all);
    };
    std::size_t frames = 0;
    const std::pair<const std::string, VoxelsCut>* worst = nullptr;
    for (const auto& frame : frames_) {
      frames += frame.second.outside > 0 ? 1 : 0;
      if (frame.second.outside > 0 && (!worst || lost(frame.second) > lost(worst->second)))
        worst = &frame;
    }
    if (!worst)
      return {};
    return fmt::format("in {} of {} frames, most in {}: {} of {} voxels", frames, frames_.size(),
                       worst->first, worst->second.outside, worst->second.all);
  }

 private:
  std::mutex mutex_;
  std::map<std::string, VoxelsCut> frames_;
};

class Resampler {
 public:
  Resampler(const std::string& path, const std::string& target, const ResampleRequest& request,
            Reading& reading, Team& team)
      : path_(path), target_(target), request_(request), reading_(reading), team_(team) {}

  Result<Report> run();

 private:
  Result<OldGrid> open(const std::string& name, const VolumeGrid* grid);
  Status add(OldGrid old);
  Status addAll();
  void tellLosses();

  const std::string& path_;
  const std::string& target_;
  const ResampleRequest& request_;
  Reading& reading_;
  Team& team_;
  std::optional<Lattice> stated_;  // for all grids
  std::vector<std::unique_ptr<FrameSource>> sources_;
  std::vector<std::pair<std::string, std::shared_ptr<CutLog>>>
      cuts_;  // of each grid, with its name
  std::vector<WrittenGrid> written_;
  FrameMetadata fileMetadata_;
  std::set<std::string> told_;  // once for all grids
};

Result<OldGrid> Resampler::open(const std::string& name, const VolumeGrid* grid) {
  InputOptions input;
  input.grid = name;
  input.partial = request_.partial;
  input.verify = grid == nullptr;
  input.notFinite = NotFinite::kRefuse;
  // What is not compressed stays float32 where it is.
  input.offsets = isVolutePath(target_) ? Offsets::kAll : Offsets::kOfRounded;
  // What is sampled from a frustum needs no resampling any more where its lattice is known.
  FrustumSampling frusta{{}, request_.basis};
  if (stated_)
    frusta.indexToWorld = stated_->indexToWorld;
  else if (request_.matrix)
    frusta.indexToWorld = *request_.matrix;
  else if (request_.voxelSize) {
    const Vec3& voxel = *request_.voxelSize;
    const Vec3 corner = request_.bounds ? request_.bounds->min : Vec3(Vec3::Zero());
    frusta.indexToWorld = gridMatrix(voxel.asDiagonal(), corner + 0.5 * voxel);
  }
  input.frusta = frusta;
  VOLUTE_ASSIGN(auto volume, openVolume(path_, input, reading_));
  const VolumeInfo& info = volume.source->info();
  const auto once = [&](std::string_view what) { return told_.emplace(what).second; };
  if (info.frames > 1 && request_.stated.framesPerSecond && !info.timesAssumed && once("rate")) {
    reading_.progress.remark(
        Remark(RemarkCode::kNote,
               fmt::format("{}: states times, {} to {} s; the rate that is given counts", path_,
                           plainNumber(info.times.front(), 4), plainNumber(info.times.back(), 4)))
            .in(path_));
  }
  if (once("frames"))
    remarkOnRange(path_, info, request_.frames, reading_);
  volume.source =
      tellingLosses(asStated(std::move(volume.source), request_.stated), path_, reading_.progress);
  OldGrid old{nullptr, {}, volume.vectors, {}, {}};
  VOLUTE_ASSIGN(old.positions, selectPositions(volume.source->info(), request_.frames));
  if (volume.reader && isVolutePath(target_)) {
    old.ownError = ownErrorOf(*volume.reader);
    remarkOnOwnError(path_, *volume.reader, reading_);
  }
  for (const int position : old.positions) {
    if (!volume.places.empty())
      old.places.push_back(volume.places[static_cast<std::size_t>(position)]);
  }
  if (grid && grid->description)
    old.description = grid->description->of(old.positions);
  VOLUTE_ASSIGN(old.source, selectFrames(std::move(volume.source), request_.frames));
  return old;
}

Status Resampler::add(OldGrid old) {
  VOLUTE_ASSIGN(const Lattice lattice,
                stated_ ? Result<Lattice>(*stated_) : newLattice(request_, old, path_));
  if (!isAlongAxes(lattice.indexToWorld) && !isVolutePath(target_) && !isVdbPath(target_)) {
    return failFor("output", ErrorCode::kInvalidArgument,
                   "{}: the new voxels do not lie along the axes, which such a file cannot say; "
                   "expected .vdb or .volute",
                   target_);
  }
  WrittenGrid written{nullptr, request_.rms, describe(old, lattice), old.ownError};
  // At worst all of it lies within the new voxels.
  const double share =
      static_cast<double>(old.source->info().voxels()) *
      std::abs(linearOf(indexToWorld(old.source->info(), old.places, 0)).determinant()) /
      (static_cast<double>(lattice.box.size(0) * lattice.box.size(1) * lattice.box.size(2)) *
       std::abs(linearOf(lattice.indexToWorld).determinant()));
  written.ownError.rms =
      std::min(written.ownError.rms * std::sqrt(std::max(share, 1.0)), written.ownError.maximum);
  auto turns = turnsOf(old, lattice);
  std::function<void(int, const VoxelsCut&)> onCut;
  if (stated_ || request_.bounds) {
    const auto& [name, log] =
        cuts_.emplace_back(old.source->info().name, std::make_shared<CutLog>());
    onCut = [log, info = old.source->info()](int frame, const VoxelsCut& cut) {
      log->add(info.frameText(static_cast<std::size_t>(frame)), cut);
    };
  }
  auto components = Components::kAtCentres;
  if (old.source->info().channels == 3 && written.description->gridClass == kStaggered) {
    components = Components::kAtFaces;
    if (!isAlong(old, lattice)) {
      components = Components::kFacesToCentres;
      written.description->gridClass.clear();
      reading_.progress.remark(
          Remark(RemarkCode::kChanged,
                 fmt::format("{}: '{}' is staggered, and the faces of the new voxels lie across "
                             "others: its components are now at their centres",
                             path_, old.source->info().name))
              .in(path_));
    }
  }
  auto source = resampleTo(std::move(old.source), std::move(old.places), lattice, request_.basis,
                           reading_.maxMemory, std::move(turns), std::move(onCut), components);
  const VolumeInfo& info = source->info();
  const bool sparse = isVolutePath(target_) || isVdbPath(target_);
  if (const std::uint64_t bytes = 4 * std::uint64_t{info.frameValues()};
      !sparse && bytes > reading_.maxMemory) {
    return fail(ErrorCode::kTooLarge,
                {Hint::raise("voxel_size"), Hint::set("bounds"), Hint::raise("max_memory")},
                "{}: a frame of {} x {} x {} voxels needs {} MiB as an array, more than the {} MiB "
                "allowed; .vdb and .volute hold only what is not empty",
                target_, info.x, info.y, info.z, bytes >> 20, reading_.maxMemory >> 20);
  }
  if (info.levelSet && !old.description) {
    Bricks first;
    VOLUTE_TRY(source->readBricks(0, first));
    written.description->background[0] = first.background()[0];
  }
  written.frames = source.get();
  written_.push_back(std::move(written));
  sources_.push_back(std::move(source));
  return {};
}

Status Resampler::addAll() {
  if (!VolumeGrids::mayBe(path_)) {
    VOLUTE_ASSIGN(auto old, open(request_.fields, nullptr));
    return add(std::move(old));
  }
  InputOptions input;
  input.partial = request_.partial;
  input.verify = false;  // who reads a grid says what is damaged
  VOLUTE_ASSIGN(const auto grids, VolumeGrids::open(path_, input, reading_));
  VOLUTE_ASSIGN(const auto chosen, grids->choose(request_.fields, path_));
  std::vector<int> positions;
  for (const std::size_t i : chosen) {
    const VolumeGrid& grid = grids->grids()[i];
    const auto leftOut = [&](const std::string& why) {
      reading_.progress.remark(Remark(RemarkCode::kLeftOut, fmt::format("{}: '{}' is left out: {}",
                                                                        path_, grid.name, why))
                                   .in(path_));
    };
    if (grid.empty && chosen.size() > 1) {
      leftOut("it is empty");
      continue;
    }
    auto old = open(grid.name, &grid);
    if (!old && old.error().code == ErrorCode::kUnsupported && request_.fields.empty()) {
      leftOut(grid.kept.empty() ? old.error().message : "it is " + grid.kept);
      continue;
    }
    if (!old)
      return tl::unexpected(std::move(old.error()));
    positions = old->positions;
    VOLUTE_TRY(add(std::move(*old)));
  }
  if (!grids->fileMetadata().listOf.empty() && !positions.empty())
    fileMetadata_ = grids->fileMetadata().of(positions);
  return {};
}

/// Of the values' meaning: what the target has no place for.
void Resampler::tellLosses() {
  const auto says = [](const FrameMetadata& of) {
    return std::ranges::any_of(of.lists, [](const auto& list) { return !list.empty(); });
  };
  std::set<std::string> targets;
  for (const WrittenGrid& grid : written_) {
    VolumeInfo info = grid.frames->info();
    info.levelSet = info.levelSet || grid.description->gridClass == "level set";
    const std::string own = nameOfGrid(target_, info.name);
    if (!targets.insert(own).second)
      continue;
    remarkOnWhatIsLost(info, {.metadata = says(fileMetadata_) || says(grid.description->metadata)},
                       own, reading_);
    remarkOnOtherFrames(own, info, reading_);
  }
}

Result<Report> Resampler::run() {
  if (!isVolutePath(target_))
    VOLUTE_TRY(checkFormat(target_, true));
  if (!request_.like.empty()) {
    VOLUTE_ASSIGN(const auto other, openVolume(request_.like, {}, reading_));
    stated_ = latticeOf(*other.source, other.places);
  }
  VOLUTE_TRY(addAll());
  if (written_.empty())
    return fail(ErrorCode::kUnsupported, "{}: none of its grids holds a volume", path_);
  std::vector<std::string> names;
  for (const WrittenGrid& grid : written_) {
    names.push_back(grid.frames->info().name);
    VOLUTE_TRY(checkReplacesNothing(nameOfGrid(target_, names.back()), {path_, request_.like}));
  }
  VOLUTE_TRY(checkHoldsGrids(names, path_, target_));
  tellLosses();
  const int frames = written_[0].frames->info().frames;
  auto list = nlohmann::ordered_json::array();
  std::string text;
  for (const WrittenGrid& grid : written_) {
    const VolumeInfo& info = grid.frames->info();
    const auto& size = grid.description->voxelSize;
    list.push_back({{"name", info.name},
                    {"size", {info.x, info.y, info.z}},
                    {"voxel_size", size},
                    {"channels", info.channels}});
    text += fmt::format("\n  {:<16} {} x {} x {} voxels of {:.6g} x {:.6g} x {:.6g} m", info.name,
                        info.x, info.y, info.z, size[0], size[1], size[2]);
  }
  VOLUTE_ASSIGN(auto writer, VolumeWriter::open(std::move(written_), target_,
                                                fmt::format("resampled from {}", path_), reading_,
                                                team_, std::move(fileMetadata_)));
  Report report;
  report.add("output", target_)
      .add("frames", frames, fmt::format("{}", frames))
      .add("grids", list, text);
  VOLUTE_TRY(writer.write(report));
  for (const auto& [name, log] : cuts_) {
    if (const std::string cut = log->text(); !cut.empty())
      reading_.progress.remark(
          // Who states a box cuts on purpose; who leaves nothing does not.
          Remark(request_.bounds && !log->all() ? RemarkCode::kNote : RemarkCode::kLeftOut,
                 fmt::format("{}: '{}': what lies outside of the new voxels is left out {}", path_,
                             name, cut))
              .in(path_));
  }
  return report;
}

}  // namespace

Result<Report> resampleVolume(const std::string& path, const std::string& target,
                              const ResampleRequest& request, Reading& reading, Team& team) {
  VOLUTE_TRY(checkReplacesNothing(target, {path, request.like}));
  return Resampler(path, target, request, reading, team).run();
}

}  // namespace volute
