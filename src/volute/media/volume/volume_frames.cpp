// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "volute/base/lower_case.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/fitted_source.hpp"
#include "volute/io/unit.hpp"
#include "volute/io/volume_source.hpp"
#include "volute/math/eigen.hpp"
#include "volute/math/rotation.hpp"
#include "volute/media/volume/volume_medium.hpp"
#include "volute/optics/black_body.hpp"

namespace volute {
namespace {

constexpr double kRounding = 1e-12;
constexpr double kSolid = 1e4;  ///< optical depth of a voxel: more is as dark, and no number

/// Of a level set what is inside, with an edge of one voxel.
Bricks insideOf(const Bricks& distances, double voxel) {
  const auto inside = [&](float value) {
    return static_cast<float>(std::clamp(0.5 - value / voxel, 0.0, 1.0));
  };
  Bricks all(1, {inside(distances.background()[0]), 0, 0});
  all.reserve(distances.leaves().size(), distances.tiles().size());
  for (Bricks::Tile tile : distances.tiles()) {
    tile.value[0] = inside(tile.value[0]);
    all.addTile(tile);
  }
  for (std::size_t i = 0; i < distances.leaves().size(); ++i)
    std::ranges::transform(distances.values(i), all.addLeaf(distances.leaves()[i]).begin(), inside);
  return all;
}

Box3 scaled(const Box3& box, const Vec3& scale, const Vec3& offset) {
  return {scale.cwiseProduct(box.min) + offset, scale.cwiseProduct(box.max) + offset};
}

/// What flames and temperatures send, from a table over the temperature.
class BlackBodies {
 public:
  explicit BlackBodies(const Flames& flames) : flames_(flames) {
    for (std::size_t i = 0; i < light_.size(); ++i) {
      const double kelvin = kMin + (kMax - kMin) * static_cast<double>(i) / (kCount - 1);
      const auto [r, g, b] = blackBodyColour(kelvin);
      light_[i] = flames.brightness * Rgb(r, g, b);
      // Without flames what glows is as bright as it is hot.
      if (flames.field.empty())
        light_[i] *= blackBodyLuminance(kelvin, flames.hottest);
    }
  }

  /// @param temperature  null: as hot as the flame is strong
  void add(float flame, const float* temperature, float* rgb) const {
    flame *= static_cast<float>(flames_.field.empty() ? 1 : flames_.scale);
    if (!(flame > 0))
      return;
    const double kelvin =
        temperature ? flames_.zero + flames_.kelvin * *temperature
                    : flames_.coolest + (flames_.hottest - flames_.coolest) * std::min(flame, 1.0F);
    if (!(kelvin > kMin))
      return;
    const double place = std::min((kelvin - kMin) / (kMax - kMin), 1.0) * (kCount - 1);
    const auto low = std::min(static_cast<std::size_t>(place), kCount - 2);
    const double share = place - static_cast<double>(low);
    const Rgb light = (1 - share) * light_[low] + share * light_[low + 1];
    for (int c = 0; c < 3; ++c) rgb[c] += static_cast<float>(flame * light[c]);
  }

 private:
  static constexpr std::size_t kCount = 1024;
  static constexpr double kMin = 500, kMax = 6000;  // [K]; cooler is dark

  Flames flames_;
  std::array<Rgb, kCount> light_;
};

}  // namespace

VolumeMedium::VolumeMedium(VolumeInput input, const Appearance& appearance)
    : input_(std::make_shared<VolumeInput>(std::move(input))),
      appearance_(appearance),
      volume_(input_->source->info()) {
  const Placement placement = placed(appearance_);
  if (placement.turns())
    placement_ = {Vec3::Ones(), placement.offset, placement.turn};
  const Vec3 offset = placement.turns() ? Vec3(Vec3::Zero()) : placement.offset;
  volume_.bounds = scaled(volume_.bounds, placement.scale, offset);
  if (appearance_.basis)
    volume_.basis = *appearance_.basis;
  if (hasPlaces()) {
    volume_.bounds = infoAt(0).bounds;
    placement_ = placementAt(0);
  }
}

GridMatrix VolumeMedium::filePlaceAt(double framePosition) const {
  const auto position = static_cast<std::size_t>(framePosition);
  const double share = framePosition - static_cast<double>(position);
  const GridMatrix& before = input_->places[position];
  if (share == 0 || position + 1 >= input_->places.size() || before == input_->places[position + 1])
    return before;
  const GridMatrix& after = input_->places[position + 1];
  // What leads from one to the other is a turn and a stretch.
  const Mat3 step = linearOf(before).inverse() * linearOf(after);
  if (!(step.determinant() > 0))
    return before;
  const Mat3 turn = nearestRotation(step);
  const Mat3 stretch = turn.transpose() * step;
  const Eigen::Quaterniond half =
      Eigen::Quaterniond::Identity().slerp(share, Eigen::Quaterniond(asEigen(turn)));
  const Mat3 linear = linearOf(before) * Mat3(half.toRotationMatrix()) *
                      ((1 - share) * Mat3::Identity() + share * stretch);
  const Vec3 middle = 0.5 * (fileBounds().min + fileBounds().max);
  const Vec3 there = (1 - share) * (linearOf(before) * middle + offsetOf(before)) +
                     share * (linearOf(after) * middle + offsetOf(after));
  return gridMatrix(linear, there - linear * middle);
}

Placement VolumeMedium::placeAt(double framePosition) const {
  const GridMatrix own = filePlaceAt(framePosition);
  const Placement world = placed(appearance_);
  const Mat3 linear = world.turn * world.scale.asDiagonal() * linearOf(own);
  Placement place;
  place.scale = linear.columnNorms();
  // Of a sheared voxel the longest diagonal is as long as that of its box, for whoever divides it
  // into steps.
  const Vec3 edges = place.scale.cwiseProduct(fileBounds().size())
                         .cwiseQuotient(Vec3(volume_.x, volume_.y, volume_.z));
  double longest = edges.norm();
  for (int corner = 0; corner < 4; ++corner) {
    const Vec3 signs(corner & 1 ? -1 : 1, corner & 2 ? -1 : 1, 1);
    longest =
        std::max(longest, (linear * edges.cwiseProduct(signs).cwiseQuotient(place.scale)).norm());
  }
  if (constexpr double kSame = 1e-9; longest > (1 + kSame) * edges.norm())
    place.scale *= longest / edges.norm();
  place.turn = linear * place.scale.cwiseInverse().asDiagonal();
  place.offset = world.turn * world.scale.cwiseProduct(offsetOf(own)) + world.offset;
  return place;
}

VolumeInfo VolumeMedium::infoAt(double framePosition) const {
  VolumeInfo info = volume_;
  if (hasPlaces())
    info.bounds = scaled(fileBounds(), placeAt(framePosition).scale, Vec3::Zero());
  return info;
}

Placement VolumeMedium::placementAt(double framePosition) const {
  if (!hasPlaces())
    return placement_;
  Placement place = placeAt(framePosition);
  place.scale = Vec3::Ones();
  return place;
}

/// From the file's axes to ones whose z points upwards.
Mat3 VolumeMedium::upright() const {
  Mat3 turn = Mat3::Identity();
  const char up = input_->source->info().up;
  if (up == 'x')
    turn = Mat3(0, 0, -1, 0, 1, 0, 1, 0, 0);
  else if (up == 'y')
    turn = Mat3(1, 0, 0, 0, 0, -1, 0, 1, 0);  // as geometry: (x, y, z) -> (x, -z, y)
  return turn;
}

/// The appearance's placement of what stands upright, in the file's axes.
Placement VolumeMedium::placed(const Appearance& appearance) const {
  Placement placement = appearance.placement;
  const Mat3 up = upright();
  placement.turn = placement.turn * up;
  placement.scale = (up.transpose() * placement.scale.asDiagonal() * up).diagonal();
  return placement;
}

Box3 VolumeMedium::uprightBounds() const {
  const Mat3 up = upright();
  const Box3 file = aroundPlaces(fileBounds(), input_->places);
  Box3 bounds;
  bounds.extend(up * file.min), bounds.extend(up * file.max);
  return bounds;
}

void VolumeMedium::setAppearance(const Appearance& appearance) {
  shadedFramePosition_ = pathsFramePosition_ = lightFramePosition_ = negativeSoughtAt_ = -1;
  light_ = nullptr;
  drawnOf_ = drawn_ = nullptr;
  velocitiesChecked_ = velocitiesChecked_ && appearance.velocityUnit == appearance_.velocityUnit &&
                       appearance.velocityScale == appearance_.velocityScale;
  const Placement before = placed(std::exchange(appearance_, appearance));
  volume_.basis = appearance_.basis.value_or(input_->source->info().basis);
  if (slice_ && slice_->basis() != volume_.basis)
    slice_ = std::make_shared<const BrickSlice>(asItLooks(*slice_, volume_));
  const Placement now = placed(appearance_);
  if (hasPlaces()) {
    volume_.bounds = infoAt(0).bounds;
    placement_ = placementAt(0);
    slice_ = nullptr, sliceFramePosition_ = -1;
    return;
  }
  if (now.scale == before.scale && now.offset == before.offset && now.turn == before.turn)
    return;
  placement_ = {Vec3::Ones(), now.offset, now.turn};
  const Box3 bounds = scaled(fileBounds(), now.scale, Vec3::Zero());
  const double rounding = kRounding * bounds.size().norm();  // of a scale that a matrix gave
  if ((bounds.min - volume_.bounds.min).norm() <= rounding &&
      (bounds.max - volume_.bounds.max).norm() <= rounding)
    return;
  volume_.bounds = bounds;
  if (!slice_)
    return;
  BrickSlice elsewhere = *slice_;
  elsewhere.setBounds(volume_.bounds);
  slice_ = std::make_shared<const BrickSlice>(std::move(elsewhere));
}

Box3 VolumeMedium::boundsInScene() const {
  Box3 all;
  const auto add = [&](Box3 box, const Placement& place) {
    if (content_) {
      const Vec3 size = box.size(), first = box.min;
      box = {first + content_->min.cwiseProduct(size), first + content_->max.cwiseProduct(size)};
    }
    const std::array<GridMatrix, 1> matrix{gridMatrix(place.turn, place.offset)};
    const Box3 around = aroundPlaces(box, matrix);
    all.extend(around);
  };
  if (!hasPlaces())
    add(volume_.bounds, placement_);
  for (int position = 0; position < static_cast<int>(input_->places.size()); ++position)
    add(infoAt(position).bounds, placementAt(position));
  return all;
}

Result<std::shared_ptr<VolumeMedium>> VolumeMedium::open(const std::string& path,
                                                         const InputOptions& options,
                                                         const Appearance& appearance,
                                                         Reading& reading,
                                                         std::shared_ptr<LoneFrame> frame) {
  InputOptions finite = options;
  finite.notFinite = NotFinite::kRefuse;
  VOLUTE_ASSIGN(auto input, openVolume(path, finite, reading));
  const std::uint64_t bytes = 2 * input.source->brickBytes();  // as they are read, and to be drawn
  if (bytes > reading.maxMemory) {
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "{}: a frame needs {} MiB of memory, more than the {} MiB allowed", path,
                (bytes >> 20) + 1, reading.maxMemory >> 20);
  }
  if (const char up = input.source->info().up; options.stated.up == 0) {
    if (up != 0 && up != 'z' && !input.writer.empty())
      reading.progress.remark(
          {RemarkCode::kAssumed,
           fmt::format("{}: its {} axis points upwards, as in {}, which wrote it", path, up,
                       input.writer),
           {Hint::set("up", "z").so("turns z upwards")}});
    else if (up != 0 && up != 'z')
      reading.progress.remark(fmt::format("{}: its {} axis points upwards, as it says", path, up));
    else if (up == 0 && isVdbPath(path))
      reading.progress.remark(
          {RemarkCode::kAssumed,
           fmt::format("{}: does not say which axis points upwards; z is taken for it", path),
           {Hint::set("up", "y").so("turns y upwards")}});
  }
  if (!frame)
    frame = std::make_shared<LoneFrame>();
  if (!input.reader)
    input.source = LoneFrame::keeping(std::move(input.source), frame);
  std::shared_ptr<VolumeMedium> volume(new VolumeMedium(std::move(input), appearance));
  volume->frame_ = std::move(frame);
  volume->path_ = path;
  volume->options_ = std::move(finite);
  volume->progress_ = &reading.progress;
  volume->maxMemory_ = reading.maxMemory;
  VOLUTE_TRY(volume->chooseInterpolation(reading.progress));
  VOLUTE_TRY(volume->openOthers(reading));
  VOLUTE_TRY(volume->findContent(reading.progress));
  std::vector<std::string> grids{volume->input_->source->info().name};
  for (const auto& [name, other] : volume->others_) grids.push_back(name);
  volume->frame_->keepOnly(grids);
  volume->info_ = volume->describe();
  return volume;
}

Status VolumeMedium::findContent(Progress& progress) {
  constexpr std::uint64_t kSparse = 64;  // a box of so many times what is in it may have strays
  constexpr double kRest = 1e-3;
  FrameSource& source = *input_->source;
  if (!source.hasTopology() || kSparse * source.brickBytes() > 4 * source.info().frameValues())
    return {};
  std::array<std::map<std::int64_t, double>, 3> slabs;  // what is in each layer of leaves
  double all = 0;
  const auto add = [&](const VoxelIndex& origin, double amount) {
    for (std::size_t axis = 0; axis < 3; ++axis) slabs[axis][origin[axis]] += amount;
    all += amount;
  };
  for (const int frame : std::set{0, volume_.frames / 2, volume_.frames - 1}) {
    Bricks bricks;
    VOLUTE_TRY(source.readBricks(frame, bricks));
    for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
      double sum = 0;
      for (const float value : bricks.values(i)) sum += std::isfinite(value) ? std::abs(value) : 0;
      add(bricks.leaves()[i].origin, sum);
    }
    if (!bricks.tiles().empty())
      return {};  // large things
  }
  if (!(all > 0))
    return {};
  const int size[3] = {volume_.x, volume_.y, volume_.z};
  Box3 content;
  bool smaller = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto first = slabs[axis].begin(), last = std::prev(slabs[axis].end());
    const double most = kRest / 6 * all;  // at each of six ends
    for (double rest = first->second; rest <= most; rest += first->second) ++first;
    for (double rest = last->second; rest <= most; rest += last->second) --last;
    const std::size_t at = axis;
    content.min[at] = std::max(static_cast<double>(first->first) / size[axis], 0.0);
    content.max[at] = std::min(static_cast<double>(last->first + Bricks::kSide) / size[axis], 1.0);
    smaller = smaller || content.max[at] - content.min[at] < 0.5;
  }
  // Of what is together, the border of faint voxels is seen as well.
  const auto ends = [&](std::size_t axis) {
    return std::pair{slabs[axis].begin()->first, std::prev(slabs[axis].end())->first};
  };
  bool cut = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t at = axis;
    const auto [low, high] = ends(axis);
    cut = cut || static_cast<double>(low + Bricks::kSide) / size[axis] < content.min[at] ||
          static_cast<double>(high) / size[axis] > content.max[at];
  }
  if (!smaller || !cut)
    return {};
  content_ = content;
  const Box3& whole = fileBounds();
  const Vec3 low = whole.min + content.min.cwiseProduct(whole.size()),
             high = whole.min + content.max.cwiseProduct(whole.size());
  progress.remark(fmt::format(
      "{}: 99.9 % of '{}' lie between {}, {}, {} and {}, {}, {} m, which "
      "is "
      "what is looked at; the rest is as far as {}, {}, {} and {}, {}, {} "
      "m",
      path_, volume_.name, plainNumber(low.x(), 4), plainNumber(low.y(), 4),
      plainNumber(low.z(), 4), plainNumber(high.x(), 4), plainNumber(high.y(), 4),
      plainNumber(high.z(), 4), plainNumber(whole.min.x(), 4), plainNumber(whole.min.y(), 4),
      plainNumber(whole.min.z(), 4), plainNumber(whole.max.x(), 4), plainNumber(whole.max.y(), 4),
      plainNumber(whole.max.z(), 4)));
  return {};
}

Status VolumeMedium::chooseInterpolation(Progress& progress) {
  interpolation_ = appearance_.interpolation;
  if (interpolation_ == Interpolation::kNone)
    return {};
  if (volume_.frames < 2) {
    progress.remark(
        Remark(RemarkCode::kFallback, fmt::format("{}: one frame alone is not interpolated", path_))
            .in(path_));
    interpolation_ = Interpolation::kNone;
    return {};
  }
  if (interpolation_ == Interpolation::kLinear)
    return {};
  std::vector<std::string> grids = input_->source->otherGrids();
  grids.push_back(input_->source->info().name);
  const auto find = [&](const std::string& name) -> std::string {
    const auto found = std::ranges::find(grids, name, lowerCase);
    return found == grids.end() ? "" : *found;
  };
  for (const char* name : {"velocity", "vel", "v"}) {
    if (const std::string whole = find(name); !whole.empty() && velocities_.empty())
      velocities_ = {whole};
    for (const char* link : {"_", ".", ""}) {
      std::vector<std::string> parts;
      for (const char* axis : {"x", "y", "z"})
        parts.push_back(find(std::string(name) + link + axis));
      if (velocities_.empty() && std::ranges::find(parts, "") == parts.end())
        velocities_ = parts;
    }
  }
  if (velocities_.empty() && interpolation_ == Interpolation::kVelocity) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: interpolate: it has no grid of velocities (velocity, vel, v, or three of them "
                "with _x, _y, _z); it has {}; linear goes over from frame to frame in place",
                path_, fmt::join(grids, ", "));
  }
  if (velocities_.empty()) {
    interpolation_ = Interpolation::kLinear;
    progress.remark(fmt::format(
        "{}: no grid of velocities: its frames go over into each other in place", path_));
    return {};
  }
  interpolation_ = Interpolation::kVelocity;
  // No file says its unit, and with a wrong one everything is blurred.
  Remark remark(RemarkCode::kNote,
                fmt::format("{}: moved along '{}' between its frames, in units of {:g} {}", path_,
                            fmt::join(velocities_, "', '"), appearance_.velocityScale,
                            kVelocityUnits[static_cast<std::size_t>(appearance_.velocityUnit)]));
  if (appearance_.velocityUnit == VelocityUnit::kMetresPerSecond)
    remark.hints = {Hint::set("velocity_unit").so("states another unit")};
  progress.remark(std::move(remark).in(path_));
  return {};
}

Status VolumeMedium::openOthers(Reading& reading) {
  std::vector<std::string> names = velocities_;
  if (appearance_.flames) {
    names.push_back(appearance_.flames->field);
    names.push_back(appearance_.flames->temperature);
  }
  if (appearance_.scatters() && !appearance_.colors.empty()) {
    const auto grids = input_->source->otherGrids();
    if (std::ranges::find(grids, appearance_.colors + "_r") != grids.end()) {
      for (const char* end : {"_r", "_g", "_b"}) names.push_back(appearance_.colors + end);
    } else {
      names.push_back(appearance_.colors);
    }
  }
  std::erase_if(names, [&](const std::string& name) {
    return name.empty() || name == input_->source->info().name;
  });
  if (names.empty())
    return checkVelocities(reading);
  // All grids over the voxels of the main one, and over all that one of them reaches.
  const Box3 box = options_.bounds.value_or(fileBounds());
  Box3 reached = box;
  InputOptions one = options_;
  one.bounds.reset();
  for (const std::string& name : names) {
    one.grid = name;
    auto found = openVolume(path_, one, reading);
    if (!found && found.error().code == ErrorCode::kInvalidData) {
      others_[name] = nullptr;  // nothing is active in it
      continue;
    }
    if (!found)
      return tl::unexpected(std::move(found.error()));
    const VolumeInfo& info = found->source->info();
    if (info.frameNumbers != input_->source->info().frameNumbers ||
        info.frameScale != input_->source->info().frameScale) {
      return fail(
          ErrorCode::kInvalidData,
          "{}: grid '{}' has {} frames, but '{}' has {}; grids that are shown together need "
          "the same",
          path_, name, info.frames, input_->source->info().name, volume_.frames);
    }
    if (!samePlaces(found->places, input_->places, info.bounds, info.voxelSize().minCoeff())) {
      return fail(ErrorCode::kUnsupported, Hint::set("preset", "smoke").so("shows the smoke alone"),
                  "{}: grid '{}' is turned otherwise than '{}', or lies elsewhere; grids that are "
                  "shown together need one place, which resampling gives them",
                  path_, name, input_->source->info().name);
    }
    if (!found->reader)
      found->source = LoneFrame::keeping(std::move(found->source), frame_);
    others_[name] = std::make_shared<VolumeInput>(std::move(*found));
    if (std::ranges::find(velocities_, name) != velocities_.end())
      continue;  // where nothing else is, it moves nothing
    reached.extend(info.bounds);
  }
  VOLUTE_TRY(checkVelocities(reading));
  const VolumeInfo wide = widenedTo(input_->source->info(), options_.bounds ? box : reached);
  const auto checkDense = [&](const FrameSource& source) -> Status {
    if ((onOneLattice(source.info(), wide) && source.hasTopology()) ||
        8 * wide.frameValues() <= reading.maxMemory)
      return {};
    return fail(ErrorCode::kTooLarge,
                "{}: all that its grids reach takes {} x {} x {} voxels of '{}', and '{}' as an "
                "array of those needs {} MiB, more than the {} MiB allowed",
                path_, wide.x, wide.y, wide.z, wide.name, source.info().name,
                (wide.frameValues() >> 17) + 1, reading.maxMemory >> 20);
  };
  const auto sameVoxels = [&](const VolumeInfo& info) {
    return info.x == wide.x && info.y == wide.y && info.z == wide.z && onOneLattice(info, wide);
  };
  for (auto& [name, input] : others_) {
    if (!input || sameVoxels(input->source->info()))
      continue;
    VOLUTE_TRY(checkDense(*input->source));
    if (!onOneLattice(input->source->info(), wide)) {
      reading.progress.remark(
          fmt::format("{}: '{}' has other voxels than '{}' and is interpolated on those", path_,
                      name, wide.name));
    }
    input->source = fitTo(std::move(input->source), wide);
    input->reader = nullptr;  // its blocks are of other voxels
  }
  if (!sameVoxels(input_->source->info())) {
    VOLUTE_TRY(checkDense(*input_->source));
    input_->source = fitTo(std::move(input_->source), wide);
    input_->reader = nullptr;
    volume_.x = wide.x, volume_.y = wide.y, volume_.z = wide.z;
    const Placement placement = placed(appearance_);
    volume_.bounds = scaled(wide.bounds, placement.scale,
                            placement.turns() ? Vec3(Vec3::Zero()) : placement.offset);
  }
  return {};
}

Result<BrickSlice> VolumeMedium::readSlice(FrameSource& source, int position) {
  VolumeInfo info = volume_;
  info.channels = source.info().channels;
  if (!source.info().levelSet && !source.hasTopology()) {
    return BrickSlice::fromLayers(info, source.readsLayers(),
                                  [&](int first, int end, std::span<float> values) {
                                    return source.readLayers(position, first, end, values);
                                  });
  }
  Bricks bricks;
  frame_->handOver();
  VOLUTE_TRY(source.readBricks(position, bricks));
  if (source.info().levelSet)
    bricks = insideOf(bricks, source.info().voxelSize().minCoeff());
  const auto tooLarge = [&](std::string_view what, std::uint64_t bytes) {
    std::vector<Hint> hints{Hint::raise("max_memory")};
    if (!isVolutePath(path_))  // a .volute file has its own bounds
      hints.insert(hints.begin(), Hint::set("bounds"));
    return fail(ErrorCode::kTooLarge, std::move(hints),
                "{}: frame {}: {} of '{}' need {} MiB of memory, more than the {} MiB allowed",
                path_, info.frameText(position), what, source.info().name, (bytes >> 20) + 1,
                maxMemory_ >> 20);
  };
  if (bricks.background() != std::array<float, 3>{}) {
    // Something everywhere.
    if (const std::uint64_t bytes = 8ull * info.frameValues(); bytes > maxMemory_) {
      return tooLarge(
          fmt::format("{} x {} x {} voxels, whose background is not 0,", info.x, info.y, info.z),
          bytes);
    }
    std::vector<float> values(info.frameValues());
    bricks.toDense({{0, 0, 0}, {info.x, info.y, info.z}}, values);
    return BrickSlice::fromDense(info, values);
  }
  constexpr std::uint64_t kPerEntry = 64;  // in tables and lists
  const std::uint64_t tiles = kPerEntry * BrickSlice::entriesOfTiles(info, bricks);
  if (tiles > maxMemory_)
    return tooLarge("the tiles", tiles);
  return BrickSlice::fromBricks(info, bricks);
}

Result<VolumeMedium::Slice> VolumeMedium::frameOf(FrameSource& source, int position) {
  for (const KeptFrame& kept : kept_) {
    if (kept.source == &source && kept.position == position)
      return kept.slice;
  }
  VOLUTE_ASSIGN(auto read, readSlice(source, position));
  auto slice = std::make_shared<const BrickSlice>(std::move(read));
  std::erase_if(kept_,
                [&](const KeptFrame& kept) { return std::abs(kept.position - position) > 1; });
  kept_.push_back({&source, position, slice});
  return slice;
}

/// None where a frame has none.
Result<Velocities> VolumeMedium::velocitiesOf(int position) {
  Velocities all;
  for (const std::string& name : velocities_) {
    all.emplace_back();
    const bool main = name == input_->source->info().name;
    if (!main && !others_.at(name))
      continue;
    VOLUTE_ASSIGN(all.back(),
                  frameOf(main ? *input_->source : *others_.at(name)->source, position));
    const int channels = all.back()->channels();
    if (channels != (velocities_.size() == 1 ? 3 : 1)) {
      return fail(ErrorCode::kInvalidData, "{}: the grid of velocities '{}' has {} channel{}",
                  path_, name, channels, channels == 1 ? "; expected 3" : "s; expected 1");
    }
  }
  return all;
}

Status VolumeMedium::checkVelocities(Reading& reading) {
  if (interpolation_ != Interpolation::kVelocity || velocities_.size() != 1)
    return {};
  const std::string& name = velocities_[0];
  const bool main = name == input_->source->info().name;
  if (!main && !others_.at(name))
    return {};
  vectors_ = main ? input_->vectors : others_.at(name)->vectors;
  using enum VectorKind::Type;
  if (vectors_.type != kCovariantNormalize && vectors_.type != kContravariantAbsolute)
    return {};
  const std::string what = fmt::format(
      "{}: the vectors of '{}' are {}, as the file says ({})", path_, name,
      vectors_.type == kCovariantNormalize ? "normals" : "places", vectorTypeName(vectors_.type));
  if (appearance_.interpolation == Interpolation::kVelocity) {
    return fail(ErrorCode::kInvalidData,
                "{}; expected velocities (contravariant relative); linear goes over from frame to "
                "frame in place",
                what);
  }
  reading.progress.remark(
      Remark(RemarkCode::kFallback, what + ", so that frames go over into each other in place")
          .in(path_));
  interpolation_ = Interpolation::kLinear;
  velocities_.clear();
  return {};
}

VoxelMap VolumeMedium::voxelToFile(const GridMatrix& place) const {
  const Vec3 voxel = input_->source->info().voxelSize();
  const Vec3 first = fileBounds().min + 0.5 * voxel;
  const Mat3 linear = linearOf(place);
  return {linear * voxel.asDiagonal(), linear * first + offsetOf(place)};
}

BetweenFrames VolumeMedium::betweenAt(double framePosition) const {
  const auto position = static_cast<std::size_t>(framePosition);
  BetweenFrames between{framePosition - static_cast<double>(position)};
  const auto& places = input_->places;
  if (!hasPlaces() || places[position] == places[position + 1])
    return between;
  const VoxelMap here = voxelToFile(filePlaceAt(framePosition));
  const auto into = [&](const GridMatrix& place) -> VoxelMap {
    const VoxelMap back = voxelToFile(place).inverse();
    return {back.linear * here.linear, back.linear * here.offset + back.offset};
  };
  between.before = into(places[position]), between.after = into(places[position + 1]);
  return between;
}

Mat3 VolumeMedium::velocityStep(int position, int in, VelocityUnit unit) const {
  const auto at = static_cast<std::size_t>(position);
  const double frames = volume_.frameScale.frame(volume_.frameNumbers[at + 1]) -
                        volume_.frameScale.frame(volume_.frameNumbers[at]);
  const bool perSecond = unit == VelocityUnit::kMetresPerSecond;
  const double span = perSecond ? volume_.times[at + 1] - volume_.times[at] : frames;
  const double times = span * appearance_.velocityScale;
  if (unit == VelocityUnit::kVoxelsPerFrame)
    return times * Mat3::Identity();
  const Vec3 voxel = input_->source->info().voxelSize();  // the file's, before its placement
  const Mat3 toGrid = hasPlaces()
                          ? Mat3(linearOf(input_->places[static_cast<std::size_t>(in)]).inverse())
                          : Mat3::Identity();
  const Mat3 fromWorld = voxel.cwiseInverse().asDiagonal() * toGrid;
  if (vectors_.local)
    return times * fromWorld * vectorTurn(vectors_.type, fromWorld.inverse());
  // Velocities turn with the volume, wherever it is placed, gradients otherwise. What does not is
  // said to be invariant, and so is what nobody has said anything of: Houdini writes that then.
  const VectorKind::Type type = vectors_.type == VectorKind::Type::kInvariant
                                    ? VectorKind::Type::kContravariantRelative
                                    : vectors_.type;
  const Placement& placement = appearance_.placement;
  const Mat3 moved = placement.turn * placement.scale.asDiagonal(), up = upright();
  const Mat3 fromScene = up.transpose() * moved.inverse();
  return times * fromWorld * fromScene * vectorTurn(type, moved) * up;
}

/// Once for a sequence: of the first frames in which something moves.
Status VolumeMedium::checkVelocityUnit(double framePosition, const Velocities& before,
                                       const Velocities& after) {
  if (velocitiesChecked_)
    return {};
  constexpr double kPoor = 0.1, kClearly = 0.6;
  const int position = static_cast<int>(framePosition);
  VOLUTE_ASSIGN(const auto first, frameOf(*input_->source, position));
  VOLUTE_ASSIGN(const auto second, frameOf(*input_->source, position + 1));
  const BetweenFrames between = betweenAt(framePosition);
  const auto misfitIn = [&](VelocityUnit unit) {
    return misfit(*first, *second, before, after, velocityStep(position, position, unit),
                  velocityStep(position, position + 1, unit), between);
  };
  const double still = misfit(*first, *second, before, after, Mat3::Zero(), Mat3::Zero(), between);
  if (!(still > 0))
    return {};
  velocitiesChecked_ = true;
  const VelocityUnit stated = appearance_.velocityUnit;
  const double now = misfitIn(stated);
  if (!(now > kPoor))
    return {};
  VelocityUnit best = stated;
  double least = now;
  for (std::size_t i = 0; i < std::size(kVelocityUnits); ++i) {
    const auto unit = static_cast<VelocityUnit>(i);
    if (const double one = misfitIn(unit); one < least)
      best = unit, least = one;
  }
  const auto name = [](VelocityUnit unit) {
    return kVelocityUnits[static_cast<std::size_t>(unit)];
  };
  const auto at = static_cast<std::size_t>(position);
  const std::string frames =
      fmt::format("{}: frames {} and {}", path_, volume_.frameText(at), volume_.frameText(at + 1));
  const std::string along = fmt::format("along '{}'", fmt::join(velocities_, "', '"));
  if (least < kClearly * now && least < kClearly * still) {
    progress_->remark(
        Remark(RemarkCode::kDoubtful,
               fmt::format("{} fit together {} in {}, not in {}: they differ by {:.2g} instead of "
                           "{:.2g} of what is in them",
                           frames, along, name(best), name(stated), least, now),
               {Hint::set("velocity_unit", std::string(name(best)))})
            .in(path_));
  } else if (still < kClearly * now) {
    progress_->remark(
        Remark(RemarkCode::kDoubtful,
               fmt::format("{} differ more {} in {}, by {:.2g} of what is in them, than in place, "
                           "by {:.2g}: the velocities may be in another unit, or another scale",
                           frames, along, name(stated), now, still),
               {Hint::set("velocity_unit")})
            .in(path_));
  }
  return {};
}

Result<std::shared_ptr<const VoxelPaths>> VolumeMedium::pathsAt(double framePosition) {
  if (interpolation_ != Interpolation::kVelocity)
    return std::shared_ptr<const VoxelPaths>();
  if (framePosition == pathsFramePosition_)
    return paths_;
  const int position = static_cast<int>(framePosition);
  VOLUTE_ASSIGN(const auto before, velocitiesOf(position));
  VOLUTE_ASSIGN(const auto after, velocitiesOf(position + 1));
  VOLUTE_TRY(checkVelocityUnit(framePosition, before, after));
  const VelocityUnit unit = appearance_.velocityUnit;
  paths_ = std::make_shared<const VoxelPaths>(
      pathsBetween(volume_, before, after, velocityStep(position, position, unit),
                   velocityStep(position, position + 1, unit), betweenAt(framePosition)));
  pathsFramePosition_ = framePosition;
  return paths_;
}

Result<VolumeMedium::Slice> VolumeMedium::readAt(FrameSource& source, double framePosition) {
  const int position = static_cast<int>(framePosition);
  if (!(interpolation_ != Interpolation::kNone)) {
    VOLUTE_ASSIGN(auto slice, readSlice(source, position));
    return std::make_shared<const BrickSlice>(std::move(slice));
  }
  VOLUTE_ASSIGN(const auto before, frameOf(source, position));
  if (framePosition == position)
    return before;
  VOLUTE_ASSIGN(const auto after, frameOf(source, position + 1));
  VOLUTE_ASSIGN(const auto paths, pathsAt(framePosition));
  VolumeInfo info = volume_;
  info.channels = before->channels();
  return std::make_shared<const BrickSlice>(
      blendFrames(info, *before, *after, betweenAt(framePosition), paths.get()));
}

Result<std::vector<BrickPlace>> VolumeMedium::allBricks(const std::string& why) const {
  const BrickSlice shape(volume_);
  const std::uint64_t bytes = 16ull * volume_.frameValues();
  if (bytes > maxMemory_) {
    return fail(ErrorCode::kTooLarge,
                "{}: {} in all {} x {} x {} voxels, which need {} MiB of memory, more than the {} "
                "MiB allowed",
                path_, why, volume_.x, volume_.y, volume_.z, (bytes >> 20) + 1, maxMemory_ >> 20);
  }
  std::vector<BrickPlace> places;
  for (int z = 0; z < shape.bricksZ(); ++z)
    for (int y = 0; y < shape.bricksY(); ++y)
      for (int x = 0; x < shape.bricksX(); ++x) places.push_back({x, y, z});
  return places;
}

Result<std::shared_ptr<const BrickSlice>> VolumeMedium::shadedSliceAt(double framePosition) {
  if (framePosition == shadedFramePosition_)
    return shadedSlice_;
  const int channels = volume_.channels;
  VOLUTE_ASSIGN(const Slice main, readAt(*input_->source, framePosition));
  remarkOnNegative(*main, framePosition);
  const auto grid = [&](const std::string& name) -> Result<Slice> {
    if (name.empty())
      return Slice();
    Slice slice;
    if (name == input_->source->info().name) {
      slice = main;
    } else if (const auto& other = others_.at(name)) {
      VOLUTE_ASSIGN(slice, readAt(*other->source, framePosition));
    } else {
      VolumeInfo empty = volume_;
      empty.channels = 1;
      slice = std::make_shared<const BrickSlice>(empty);
    }
    if (slice->channels() != 1) {
      return fail(ErrorCode::kInvalidData, "{}: grid '{}' has three channels; expected one", path_,
                  name);
    }
    return slice;
  };
  auto flames = appearance_.flames;
  if (flames && !flames->temperature.empty() && flames->kelvin == 1 && flames->zero == 0) {
    // Nobody says what its numbers mean but the file.
    const auto other = others_.find(flames->temperature);
    const VolumeInput* heat = other == others_.end() ? input_.get() : other->second.get();
    if (const auto kelvins = heat ? unitChange(heat->source->info().unit, "K") : std::nullopt)
      flames->kelvin = kelvins->factor, flames->zero = kelvins->offset;
  }
  const auto& transfer = appearance_.transfer;
  const bool emits = flames || transfer || appearance_.emission != 0;
  VolumeInfo info = infoAt(framePosition);
  info.channels = emits ? 4 : 1;
  if (info.basis == Basis::kBox)
    info.basis = Basis::kTrilinear;
  const auto solid =
      static_cast<float>(std::clamp(kSolid / info.voxelSize().minCoeff(), kSolid, 1e30));
  // The same bricks, which may be in many places.
  if (!emits && main->channels() == 1) {
    BrickSlice same(*main);
    same.setBasis(info.basis);
    same.setBounds(info.bounds);
    const auto factor = static_cast<float>(appearance_.extinction);
    for (std::size_t i = 0; i < same.storedBricks(); ++i) {
      float* values = same.brick(static_cast<std::int32_t>(i));
      for (int k = 0; k < BrickSlice::kVoxels; ++k)
        values[k] = std::clamp(factor * values[k], 0.0F, solid);
    }
    same.dropEmpty();
    shadedSlice_ = std::make_shared<const BrickSlice>(std::move(same));
    shadedFramePosition_ = framePosition;
    return shadedSlice_;
  }
  Slice burns, hot;
  if (flames) {
    VOLUTE_ASSIGN(burns, grid(flames->field));
    VOLUTE_ASSIGN(hot, grid(flames->temperature));
  }
  const BlackBodies bodies(flames.value_or(Flames()));
  const auto scale = static_cast<float>(appearance_.extinction / channels);
  const auto glow = static_cast<float>(appearance_.emission);
  // The main grid emits by itself unless it is what flames are read from.
  const bool mainGlows = appearance_.emission != 0 &&
                         !(flames && (flames->field == input_->source->info().name ||
                                      flames->temperature == input_->source->info().name));
  std::vector<BrickPlace> places = placesOf(std::array{main, burns, hot});
  if (flames) {
    float dark[3]{};
    const float cold = 0;
    bodies.add(burns ? 0 : 1, hot ? &cold : nullptr, dark);
    if (dark[0] > 0 || dark[1] > 0 || dark[2] > 0) {
      VOLUTE_ASSIGN(places, allBricks("its flames glow where its grids are 0, which is"));
    }
  }
  if (transfer && transfer->extinctionOf(0) > 0) {
    VOLUTE_ASSIGN(places, allBricks("its transfer function shows the value 0, which is"));
  }
  BrickSlice slice(info, places);
  static const std::vector<float> kZeros(std::size_t{3} * BrickSlice::kVoxels, 0);
  const auto valuesOf = [](const Slice& of, const BrickPlace& place) -> const float* {
    if (!of)
      return nullptr;
    const std::int32_t stored = of->table().at(place);
    return stored == BrickSlice::kEmpty ? kZeros.data() : of->brick(stored);
  };
  parallelRanges(places.size(), 8, [&](std::size_t begin, std::size_t end) {
    constexpr int kVoxels = BrickSlice::kVoxels, kSide = BrickSlice::kSide;
    for (std::size_t b = begin; b < end; ++b) {
      const float* mains = valuesOf(main, places[b]);
      const float* burning = valuesOf(burns, places[b]);
      const float* heat = valuesOf(hot, places[b]);
      float* out = slice.brick(static_cast<std::int32_t>(b));
      const BrickPlace first{places[b][0] * kSide, places[b][1] * kSide, places[b][2] * kSide};
      for (int i = 0; i < kVoxels; ++i, ++out) {
        if (first[0] + i % kSide >= info.x || first[1] + i / kSide % kSide >= info.y ||
            first[2] + i / kSide / kSide >= info.z)
          continue;
        if (transfer) {
          const double value = scalarAt(mains + i, channels, kVoxels);
          const double dense = transfer->extinctionOf(value);
          out[0] = static_cast<float>(dense);
          const Rgb sent = dense > 0 ? Rgb(dense * transfer->colorOf(value)) : Rgb(Rgb::Zero());
          for (int c = 0; c < 3; ++c) out[(1 + c) * kVoxels] = static_cast<float>(sent[c]);
          continue;
        }
        float sum = 0;
        for (int c = 0; c < channels; ++c) sum += mains[c * kVoxels + i];
        out[0] = std::clamp(scale * sum, 0.0F, solid);
        if (!emits)
          continue;
        float sent[3]{};
        for (int c = 0; c < 3 && mainGlows; ++c)
          sent[c] = glow * mains[(channels == 3 ? c : 0) * kVoxels + i];
        if (flames)
          bodies.add(burning ? burning[i] : 1, heat ? &heat[i] : nullptr, sent);
        for (int c = 0; c < 3; ++c) out[(1 + c) * kVoxels] = sent[c];
      }
    }
  });
  slice.dropEmpty();
  shadedSlice_ = std::make_shared<const BrickSlice>(std::move(slice));
  shadedFramePosition_ = framePosition;
  return shadedSlice_;
}

Result<std::vector<Rgb>> VolumeMedium::colorsAt(double framePosition,
                                                std::span<const Vec3> points) {
  const std::string& name = appearance_.colors;
  Slice planes[3];
  const auto whole = others_.find(name), red = others_.find(name + "_r");
  if (name.empty() || (whole == others_.end() && red == others_.end()))
    return std::vector<Rgb>();
  if (whole != others_.end()) {
    if (!whole->second)
      return std::vector<Rgb>();
    VOLUTE_ASSIGN(planes[0], readAt(*whole->second->source, framePosition));
  } else {
    constexpr const char* kEnds[] = {"_r", "_g", "_b"};
    for (int c = 0; c < 3; ++c) {
      const auto& input = others_.at(name + kEnds[c]);
      if (!input)
        return std::vector<Rgb>();
      VOLUTE_ASSIGN(planes[c], readAt(*input->source, framePosition));
    }
  }
  // Colours may be of the smoke or times its density: the brightest channel of each is 1.
  const Box3 bounds = infoAt(framePosition).bounds;
  const Vec3 voxel = bounds.size().cwiseQuotient(Vec3(volume_.x, volume_.y, volume_.z));
  std::vector<Rgb> colors(points.size(), Rgb::Ones());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 place = (points[i] - bounds.min).cwiseQuotient(voxel);
    const int size[3] = {volume_.x, volume_.y, volume_.z};
    int at[3];
    for (int axis = 0; axis < 3; ++axis)
      at[axis] = std::clamp(static_cast<int>(std::floor(place[axis])), 0, size[axis] - 1);
    Rgb color;
    for (int c = 0; c < 3; ++c) {
      const Slice& plane = planes[1] ? planes[c] : planes[0];
      color[c] = std::max(plane->value(at[0], at[1], at[2], plane->channels() == 3 ? c : 0), 0.0F);
    }
    if (color.maxCoeff() > 0)
      colors[i] = color / color.maxCoeff();
  }
  return colors;
}

Result<std::shared_ptr<const Tree4d>> VolumeMedium::treeAt(int position) {
  if (input_->source->info().levelSet) {
    return fail(ErrorCode::kUnsupported,
                "{}: '{}' is a level set, of which the tree holds distances; draw its bricks",
                path_, input_->source->info().name);
  }
  if (!input_->reader) {
    return fail(ErrorCode::kInvalidArgument,
                "{} holds no tree; expected a .volute: volute compress makes one", path_);
  }
  if (!tree_ || position < treeBegin_ || position >= treeBegin_ + kTreeFrames) {
    tree_.reset();
    treeBegin_ = position / kTreeFrames * kTreeFrames;
    VOLUTE_ASSIGN(
        auto tree,
        Tree4d::load(*input_->reader,
                     {.firstFrame = treeBegin_, .endFrame = treeBegin_ + kTreeFrames}, *progress_));
    tree_ = std::make_shared<const Tree4d>(std::move(tree));
    treeNodes_ = std::max<std::uint64_t>(treeNodes_, tree_->nodeCount());
    treeBytes_ = std::max<std::uint64_t>(treeBytes_, tree_->memoryBytes());
  }
  return tree_;
}

BrickSlice asItLooks(BrickSlice slice, const VolumeInfo& info) {
  slice.setBasis(info.basis);
  slice.setBounds(info.bounds);
  return slice;
}

Result<std::unique_ptr<SightField>> VolumeMedium::sight(Reading& reading) {
  measuresSight_ = true;
  sliceFramePosition_ = -1;
  const double off = input_->reader ? input_->reader->header().reachedMaxError : 0;
  const double perMetre = off * std::abs(appearance_.extinction);
  constexpr double kOfNoAccount = 0.05;  // of an optical depth
  if (perMetre * info().bounds.size().norm() > kOfNoAccount) {
    remarks.push_back(
        Remark(RemarkCode::kChanged,
               fmt::format("{}: its values were compressed with loss and are off by up to {:.3g}: "
                           "bounds of optical depths do not count that, which is up to {:.3g} for "
                           "each metre",
                           path_, off, perMetre))
            .in(path_));
  }
  return SceneMedium::sight(reading);
}

namespace {

/// Of the largest value: so much below 0 an extinction may be, by rounding and by solvers.
constexpr float kOvershoot = 0.1F;
/// An optical depth of no account: so much below 0 it may be through the whole volume.
constexpr double kNoDepth = 1e-4;

struct Extremes {
  float least = 0, most = 0;  // at most 0, at least 0
};

/// In lanes, which compilers turn into SIMD.
Extremes extremesOf(std::span<const float> values) {
  constexpr std::size_t kLanes = 16;
  std::array<float, kLanes> least{}, most{};
  std::size_t i = 0;
  for (; i + kLanes <= values.size(); i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const float value = values[i + k];
      least[k] = value < least[k] ? value : least[k];
      most[k] = value > most[k] ? value : most[k];
    }
  }
  for (; i < values.size(); ++i)
    least[0] = std::min(least[0], values[i]), most[0] = std::max(most[0], values[i]);
  return {*std::ranges::min_element(least), *std::ranges::max_element(most)};
}

Extremes extremesOf(const BrickSlice& slice) {
  constexpr std::size_t kGrain = 1 << 18;
  const std::span<const float> values = slice.values();
  Extremes all;
  std::mutex mutex;
  parallelRanges(values.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const Extremes part = extremesOf(values.subspan(begin, end - begin));
    const std::lock_guard lock(mutex);
    all.least = std::min(all.least, part.least), all.most = std::max(all.most, part.most);
  });
  return all;
}

}  // namespace

bool VolumeMedium::clearlyNegative(float least, float most) const {
  return -least > kOvershoot * most &&
         -least * std::abs(appearance_.extinction) * volume_.bounds.size().norm() > kNoDepth;
}

void VolumeMedium::remarkOnNegative(const BrickSlice& slice, double framePosition) {
  if (negativeTold_ || measuresSight_ || appearance_.extinction == 0 ||
      framePosition == negativeSoughtAt_)
    return;
  negativeSoughtAt_ = framePosition;
  const auto [least, most] = extremesOf(slice);
  largestSeen_ = std::max(largestSeen_, most);
  if (!clearlyNegative(least, largestSeen_))
    return;
  negativeTold_ = true;
  const auto below = std::ranges::count_if(slice.values(), [](float value) { return value < 0; });
  progress_->remark(
      Remark(RemarkCode::kDoubtful,
             fmt::format("{}: grid '{}', frame {}: {} values are below 0, the smallest {:g}: as an "
                         "extinction they {}",
                         path_, volume_.name,
                         volume_.frameText(static_cast<std::size_t>(framePosition)), below, least,
                         appearance_.shaded() ? "count as 0" : "add light to what is behind them"))
          .in(path_));
}

Result<VolumeMedium::Slice> VolumeMedium::asExtinction(Slice slice, double framePosition) const {
  const auto [least, most] = extremesOf(*slice);
  if (least == 0)
    return slice;
  if (clearlyNegative(least, most)) {
    return fail(ErrorCode::kInvalidData,
                "{}: grid '{}', frame {}: values go from {:g} to {:g}; expected an extinction, "
                "which is not below 0",
                path_, volume_.name, volume_.frameText(static_cast<std::size_t>(framePosition)),
                least, most);
  }
  BrickSlice positive(*slice);
  for (std::size_t i = 0; i < positive.storedBricks(); ++i) {
    float* values = positive.brick(static_cast<std::int32_t>(i));
    for (int k = 0; k < BrickSlice::kVoxels * positive.channels(); ++k)
      values[k] = std::max(values[k], 0.0F);
  }
  return std::make_shared<const BrickSlice>(std::move(positive));
}

Result<std::shared_ptr<const BrickSlice>> VolumeMedium::sliceAt(double framePosition) {
  if (framePosition == sliceFramePosition_)
    return slice_;
  VOLUTE_ASSIGN(slice_, readAt(*input_->source, framePosition));
  if (measuresSight_ && appearance_.extinction != 0) {
    VOLUTE_ASSIGN(slice_, asExtinction(slice_, framePosition));
  }
  // One that was kept may have been read for another place.
  const VolumeInfo info = infoAt(framePosition);
  if (slice_->basis() != info.basis || slice_->bounds().min != info.bounds.min ||
      slice_->bounds().max != info.bounds.max)
    slice_ = std::make_shared<const BrickSlice>(asItLooks(*slice_, info));
  sliceFramePosition_ = framePosition;
  return slice_;
}

int VolumeMedium::positionAt(double time) const {
  constexpr double kTimeRounding = 1e-12;  // timeOf() a frame is within it
  constexpr double kWritten = 1e-4;        // of an interval: people write six digits of 1 / 24 s
  const double own = appearance_.clock.at(time, volume_.times);
  const int position = volume_.frameAt(own + kTimeRounding * (1 + std::abs(own)));
  if (position + 1 >= volume_.frames)
    return position;
  const double before = volume_.times[static_cast<std::size_t>(position)];
  const double after = volume_.times[static_cast<std::size_t>(position) + 1];
  return after - own <= kWritten * (after - before) ? position + 1 : position;
}

double VolumeMedium::framePositionAt(double time) const {
  constexpr double kWhole = 1e-6;  // of the way: this near a frame it is that frame
  const int position = positionAt(time);
  if (!(interpolation_ != Interpolation::kNone) || position + 1 >= volume_.frames)
    return position;
  const double before = volume_.times[static_cast<std::size_t>(position)];
  const double after = volume_.times[static_cast<std::size_t>(position) + 1];
  const double share = (appearance_.clock.at(time, volume_.times) - before) / (after - before);
  if (!(share > kWhole))
    return position;
  return share > 1 - kWhole ? position + 1 : position + share;
}

double VolumeMedium::timeOf(int position) const {
  return appearance_.clock.sceneTime(volume_.times[position]);
}

}  // namespace volute
