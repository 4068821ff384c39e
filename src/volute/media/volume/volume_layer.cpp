// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_layer.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <utility>

#include "volute/base/parallel.hpp"
#include "volute/grid/fitted_source.hpp"
#include "volute/optics/black_body.hpp"

namespace volute {
namespace {

constexpr double kRounding = 1e-12;

Status checkFinite(std::span<const float> frame, const VolumeInfo& info, const std::string& path,
                   int position) {
  for (std::size_t i = 0; i < frame.size(); ++i) {
    if (std::isfinite(frame[i]))
      continue;
    const std::size_t voxel = i / info.channels;
    return fail(ErrorCode::kInvalidData,
                "{}: frame {}: voxel x {}, y {}, z {} is {}; expected finite values", path,
                info.frameText(position), voxel % info.x, voxel / info.x % info.y,
                voxel / info.x / info.y, frame[i]);
  }
  return {};
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

VolumeLayer::VolumeLayer(VolumeInput input, const Appearance& appearance)
    : input_(std::make_shared<VolumeInput>(std::move(input))),
      appearance_(appearance),
      info_(input_->source->info()) {
  const Placement placement = placed(appearance_);
  if (placement.turns())
    placement_ = {Vec3::Ones(), placement.offset, placement.turn};
  const Vec3 offset = placement.turns() ? Vec3(Vec3::Zero()) : placement.offset;
  info_.bounds = scaled(info_.bounds, placement.scale, offset);
  if (appearance_.basis)
    info_.basis = *appearance_.basis;
}

/// From the file's axes to ones whose z points upwards.
Mat3 VolumeLayer::upright() const {
  Mat3 turn = Mat3::Identity();
  const char up = input_->source->info().up;
  if (up == 'x')
    turn << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  else if (up == 'y')
    turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;  // as geometry: (x, y, z) -> (x, -z, y)
  return turn;
}

/// The appearance's placement of what stands upright, in the file's axes.
Placement VolumeLayer::placed(const Appearance& appearance) const {
  Placement placement = appearance.placement;
  const Mat3 up = upright();
  placement.turn = placement.turn * up;
  placement.scale = (up.transpose() * placement.scale.asDiagonal() * up).diagonal();
  return placement;
}

Box3 VolumeLayer::uprightBounds() const {
  const Mat3 up = upright();
  Box3 bounds;
  bounds.extend(up * fileBounds().min), bounds.extend(up * fileBounds().max);
  return bounds;
}

void VolumeLayer::setAppearance(const Appearance& appearance) {
  shadedMoment_ = -1;
  const Placement before = placed(std::exchange(appearance_, appearance));
  info_.basis = appearance_.basis.value_or(input_->source->info().basis);
  if (slice_ && slice_->basis() != info_.basis)
    slice_ = std::make_shared<const BrickSlice>(asItLooks(*slice_, info_));
  const Placement now = placed(appearance_);
  if (now.scale == before.scale && now.offset == before.offset && now.turn == before.turn)
    return;
  placement_ = {Vec3::Ones(), now.offset, now.turn};
  const Box3 bounds = scaled(fileBounds(), now.scale, Vec3::Zero());
  const double rounding = kRounding * bounds.size().norm();  // of a scale that a matrix gave
  if ((bounds.min - info_.bounds.min).norm() <= rounding &&
      (bounds.max - info_.bounds.max).norm() <= rounding)
    return;
  info_.bounds = bounds;
  if (!slice_)
    return;
  BrickSlice elsewhere = *slice_;
  elsewhere.setBounds(info_.bounds);
  slice_ = std::make_shared<const BrickSlice>(std::move(elsewhere));
}

Box3 VolumeLayer::boundsInScene() const {
  const Box3& box = info_.bounds;
  Box3 turned;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 at((corner & 1 ? box.max : box.min).x(), (corner & 2 ? box.max : box.min).y(),
                  (corner & 4 ? box.max : box.min).z());
    turned.extend(placement_.turn * at + placement_.offset);
  }
  return turned;
}

Result<VolumeLayer> VolumeLayer::open(const std::string& path, const InputOptions& options,
                                      const Appearance& appearance, Reading& reading) {
  VOLUTE_ASSIGN(auto input, openVolume(path, options, reading));
  const std::uint64_t bytes = 8ull * input.source->info().frameValues();  // dense and as bricks
  if (bytes > reading.maxMemory) {
    return fail(
        ErrorCode::kTooLarge,
        "{}: a frame needs {} MiB of memory, more than the {} MiB allowed; raise --max-memory",
        path, (bytes >> 20) + 1, reading.maxMemory >> 20);
  }
  if (const char up = input.source->info().up; up != 0 && up != 'z' && options.stated.up == 0)
    reading.progress.remark(fmt::format("{}: its {} axis points upwards, as it says", path, up));
  VolumeLayer layer(std::move(input), appearance);
  layer.path_ = path;
  layer.options_ = options;
  layer.progress_ = &reading.progress;
  VOLUTE_TRY(layer.chooseInterpolation(reading.progress));
  VOLUTE_TRY(layer.openOthers(reading));
  return layer;
}

Status VolumeLayer::chooseInterpolation(Progress& progress) {
  interpolation_ = appearance_.interpolation;
  if (interpolation_ == Interpolation::kNone)
    return {};
  if (info_.frames < 2) {
    progress.remark(fmt::format("{}: one frame alone is not interpolated", path_));
    interpolation_ = Interpolation::kNone;
    return {};
  }
  if (interpolation_ == Interpolation::kLinear)
    return {};
  std::vector<std::string> grids = input_->source->otherGrids();
  grids.push_back(input_->source->info().name);
  const auto find = [&](const std::string& name) -> std::string {
    const auto same = [&](const std::string& grid) {
      return std::ranges::equal(grid, name, {}, [](unsigned char c) { return std::tolower(c); });
    };
    const auto found = std::ranges::find_if(grids, same);
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
  if (appearance_.interpolation == Interpolation::kAuto) {
    interpolation_ = velocities_.empty() ? Interpolation::kLinear : Interpolation::kVelocity;
    progress.remark(
        velocities_.empty()
            ? fmt::format("{}: no grid of velocities: its frames go over into each other in place",
                          path_)
            : fmt::format("{}: moved along '{}' between its frames, in units of {:g} m/s", path_,
                          fmt::join(velocities_, "', '"), appearance_.velocityScale));
  }
  return {};
}

Status VolumeLayer::openOthers(Reading& reading) {
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
    return {};
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
          path_, name, info.frames, input_->source->info().name, info_.frames);
    }
    others_[name] = std::make_shared<VolumeInput>(std::move(*found));
    if (std::ranges::find(velocities_, name) != velocities_.end())
      continue;  // where nothing else is, it moves nothing
    reached.extend(info.bounds.min), reached.extend(info.bounds.max);
  }
  const VolumeInfo wide = widenedTo(input_->source->info(), options_.bounds ? box : reached);
  if (8 * wide.frameValues() > reading.maxMemory) {
    return fail(
        ErrorCode::kTooLarge,
        "{}: all that its grids reach takes {} x {} x {} voxels of '{}', more than the {} MiB "
        "allowed; raise --max-memory",
        path_, wide.x, wide.y, wide.z, wide.name, reading.maxMemory >> 20);
  }
  const auto sameVoxels = [&](const VolumeInfo& info) {
    return info.x == wide.x && info.y == wide.y && info.z == wide.z && onOneLattice(info, wide);
  };
  for (auto& [name, input] : others_) {
    if (!input || sameVoxels(input->source->info()))
      continue;
    if (!onOneLattice(input->source->info(), wide)) {
      reading.progress.remark(
          fmt::format("{}: '{}' has other voxels than '{}' and is interpolated on those", path_,
                      name, wide.name));
    }
    input->source = fitTo(std::move(input->source), wide);
    input->reader = nullptr;  // its blocks are of other voxels
  }
  if (!sameVoxels(input_->source->info())) {
    input_->source = fitTo(std::move(input_->source), wide);
    input_->reader = nullptr;
    info_.x = wide.x, info_.y = wide.y, info_.z = wide.z;
    const Placement placement = placed(appearance_);
    info_.bounds = scaled(wide.bounds, placement.scale,
                          placement.turns() ? Vec3(Vec3::Zero()) : placement.offset);
  }
  return {};
}

/// A grid of a frame; zeros where there is none.
Status VolumeLayer::readInto(FrameSource& source, int position, std::vector<float>& values) {
  values.resize(source.info().frameValues());
  VOLUTE_TRY(source.readFrame(position, values));
  VOLUTE_TRY(checkFinite(values, source.info(), path_, position));
  // Of a level set what is inside, with an edge of one voxel.
  if (source.info().levelSet) {
    const double voxel = source.info().voxelSize().minCoeff();
    for (float& value : values)
      value = static_cast<float>(std::clamp(0.5 - value / voxel, 0.0, 1.0));
  }
  return {};
}

Result<std::shared_ptr<const std::vector<float>>> VolumeLayer::frameOf(FrameSource& source,
                                                                       int position) {
  for (const KeptFrame& kept : kept_) {
    if (kept.source == &source && kept.position == position)
      return kept.values;
  }
  auto values = std::make_shared<std::vector<float>>();
  VOLUTE_TRY(readInto(source, position, *values));
  std::erase_if(kept_,
                [&](const KeptFrame& kept) { return std::abs(kept.position - position) > 1; });
  kept_.push_back({&source, position, values});
  return values;
}

/// Shape (z, y, x, 3); 0 where a frame has none.
Result<std::vector<float>> VolumeLayer::velocitiesOf(int position) {
  std::vector<float> all(3 * info_.voxels(), 0);
  for (std::size_t part = 0; part < velocities_.size(); ++part) {
    const std::string& name = velocities_[part];
    const bool main = name == input_->source->info().name;
    if (!main && !others_.at(name))
      continue;
    VOLUTE_ASSIGN(const auto values,
                  frameOf(main ? *input_->source : *others_.at(name)->source, position));
    const std::size_t channels = values->size() / info_.voxels();
    if (channels != (velocities_.size() == 1 ? 3U : 1U)) {
      return fail(ErrorCode::kInvalidData, "{}: the grid of velocities '{}' has {} channel{}",
                  path_, name, channels, channels == 1 ? "; expected 3" : "s; expected 1");
    }
    for (std::size_t i = 0; i < values->size(); ++i)
      all[channels == 3 ? i : 3 * i + part] = (*values)[i];
  }
  return all;
}

Result<std::shared_ptr<const VoxelPaths>> VolumeLayer::pathsAt(double moment) {
  if (interpolation_ != Interpolation::kVelocity)
    return std::shared_ptr<const VoxelPaths>();
  if (moment == pathsMoment_)
    return paths_;
  const int position = static_cast<int>(moment);
  VOLUTE_ASSIGN(const auto before, velocitiesOf(position));
  VOLUTE_ASSIGN(const auto after, velocitiesOf(position + 1));
  const double seconds = info_.times[static_cast<std::size_t>(position) + 1] -
                         info_.times[static_cast<std::size_t>(position)];
  const Vec3 voxel = input_->source->info().voxelSize();  // the file's, before its placement
  const Vec3 step = (appearance_.velocityScale * seconds * Vec3::Ones()).cwiseQuotient(voxel);
  paths_ = std::make_shared<const VoxelPaths>(
      pathsBetween(info_, before, after, step, moment - position));
  pathsMoment_ = moment;
  return paths_;
}

Status VolumeLayer::readAt(FrameSource& source, double moment, std::vector<float>& values) {
  const int position = static_cast<int>(moment);
  if (!interpolates())
    return readInto(source, position, values);
  VOLUTE_ASSIGN(const auto before, frameOf(source, position));
  if (moment == position) {
    values = *before;
    return {};
  }
  VOLUTE_ASSIGN(const auto after, frameOf(source, position + 1));
  VOLUTE_ASSIGN(const auto paths, pathsAt(moment));
  values.resize(before->size());
  blendFrames(source.info(), *before, *after, moment - position, paths.get(), values);
  return {};
}

Result<std::shared_ptr<const BrickSlice>> VolumeLayer::shadedSliceAt(double moment) {
  if (moment == shadedMoment_)
    return shadedSlice_;
  const std::size_t voxels = info_.voxels();
  const int channels = info_.channels;
  std::vector<float> main;
  VOLUTE_TRY(readAt(*input_->source, moment, main));
  const auto grid = [&](const std::string& name) -> Result<std::vector<float>> {
    if (name.empty())
      return std::vector<float>();
    std::vector<float> values;
    if (name == input_->source->info().name) {
      values = main;
    } else if (const auto& other = others_.at(name)) {
      VOLUTE_TRY(readAt(*other->source, moment, values));
    }
    if (values.size() > voxels) {
      return fail(ErrorCode::kInvalidData, "{}: grid '{}' has three channels; expected one", path_,
                  name);
    }
    values.resize(voxels, 0);
    return values;
  };
  const auto flames = appearance_.flames;
  const bool emits = flames || appearance_.emission != 0;
  VolumeInfo info = info_;
  info.channels = emits ? 4 : 1;
  if (info.basis == Basis::kBox)
    info.basis = Basis::kTrilinear;
  std::vector<float> values(voxels * static_cast<std::size_t>(info.channels), 0);
  std::vector<float> burns, hot;
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
  parallelRanges(voxels, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      float* out = &values[i * static_cast<std::size_t>(info.channels)];
      float sum = 0;
      for (int c = 0; c < channels; ++c) sum += main[i * static_cast<std::size_t>(channels) + c];
      out[0] = std::max(0.0F, scale * sum);
      if (!emits)
        continue;
      for (int c = 0; c < 3 && mainGlows; ++c)
        out[1 + c] = glow * main[i * static_cast<std::size_t>(channels) + (channels == 3 ? c : 0)];
      if (flames)
        bodies.add(burns.empty() ? 1 : burns[i], hot.empty() ? nullptr : &hot[i], out + 1);
    }
  });
  shadedSlice_ = std::make_shared<const BrickSlice>(BrickSlice::fromDense(info, values));
  shadedMoment_ = moment;
  return shadedSlice_;
}

Result<std::vector<Rgb>> VolumeLayer::colorsAt(double moment, std::span<const Vec3> points) {
  const std::string& name = appearance_.colors;
  std::vector<float> planes[3];
  std::size_t stride = 1;
  const auto whole = others_.find(name), red = others_.find(name + "_r");
  if (name.empty() || (whole == others_.end() && red == others_.end()))
    return std::vector<Rgb>();
  if (whole != others_.end()) {
    if (!whole->second)
      return std::vector<Rgb>();
    stride = static_cast<std::size_t>(whole->second->source->info().channels);
    VOLUTE_TRY(readAt(*whole->second->source, moment, planes[0]));
  } else {
    constexpr const char* kEnds[] = {"_r", "_g", "_b"};
    for (int c = 0; c < 3; ++c) {
      const auto& input = others_.at(name + kEnds[c]);
      if (!input)
        return std::vector<Rgb>();
      VOLUTE_TRY(readAt(*input->source, moment, planes[c]));
    }
  }
  // Colours may be of the smoke or times its density: the brightest channel of each is 1.
  const Vec3 voxel = info_.voxelSize();
  std::vector<Rgb> colors(points.size(), Rgb::Ones());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 place = (points[i] - info_.bounds.min).cwiseQuotient(voxel);
    const int size[3] = {info_.x, info_.y, info_.z};
    std::size_t at = 0;
    for (int axis = 2; axis >= 0; --axis) {
      const int index = std::clamp(static_cast<int>(std::floor(place[axis])), 0, size[axis] - 1);
      at = at * static_cast<std::size_t>(size[axis]) + static_cast<std::size_t>(index);
    }
    Rgb color;
    for (std::size_t c = 0; c < 3; ++c) {
      const float value =
          planes[1].empty() ? planes[0][at * stride + (stride == 3 ? c : 0)] : planes[c][at];
      color[static_cast<Eigen::Index>(c)] = std::max(value, 0.0F);
    }
    if (color.maxCoeff() > 0)
      colors[i] = color / color.maxCoeff();
  }
  return colors;
}

Result<std::shared_ptr<const Tree4d>> VolumeLayer::treeAt(int position) {
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
    counts_.nodes = std::max<std::uint64_t>(counts_.nodes, tree_->nodeCount());
    counts_.treeBytes = std::max<std::uint64_t>(counts_.treeBytes, tree_->memoryBytes());
  }
  return tree_;
}

Result<BrickSlice> VolumeLayer::sliceFromTree(int position) {
  VOLUTE_ASSIGN(const auto tree, treeAt(position));
  return asItLooks(tree->extractSlice(position, &counts_.nodesVisited), info_);
}

BrickSlice asItLooks(BrickSlice slice, const VolumeInfo& info) {
  slice.setBasis(info.basis);
  slice.setBounds(info.bounds);
  return slice;
}

Result<BrickSlice> VolumeLayer::sliceFromFrame(double moment) {
  std::vector<float>& frame = input_->frame;
  VOLUTE_TRY(readAt(*input_->source, moment, frame));
  return BrickSlice::fromDense(info_, frame);
}

Result<std::shared_ptr<const BrickSlice>> VolumeLayer::sliceAt(double moment, bool tree) {
  if (moment == moment_ && tree == fromTree_)
    return slice_;
  VOLUTE_ASSIGN(auto slice,
                tree ? sliceFromTree(static_cast<int>(moment)) : sliceFromFrame(moment));
  slice_ = std::make_shared<const BrickSlice>(std::move(slice));
  moment_ = moment;
  fromTree_ = tree;
  return slice_;
}

int VolumeLayer::positionAt(double time) const {
  constexpr double kTimeRounding = 1e-12;  // timeOf() a frame is within it
  const double own = appearance_.clock.at(time, info_.times);
  return info_.frameAt(own + kTimeRounding * (1 + std::abs(own)));
}

double VolumeLayer::momentAt(double time) const {
  constexpr double kWhole = 1e-6;  // of the way: this near a frame it is that frame
  const int position = positionAt(time);
  if (!interpolates() || position + 1 >= info_.frames)
    return position;
  const double before = info_.times[static_cast<std::size_t>(position)];
  const double after = info_.times[static_cast<std::size_t>(position) + 1];
  const double share = (appearance_.clock.at(time, info_.times) - before) / (after - before);
  if (!(share > kWhole))
    return position;
  return share > 1 - kWhole ? position + 1 : position + share;
}

double VolumeLayer::timeOf(int position) const {
  return appearance_.clock.sceneTime(info_.times[position]);
}

}  // namespace volute
