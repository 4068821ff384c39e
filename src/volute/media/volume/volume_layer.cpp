// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_layer.hpp"

#include <cmath>
#include <utility>


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
                info.frameNumbers[position], voxel % info.x, voxel / info.x % info.y,
                voxel / info.x / info.y, frame[i]);
  }
  return {};
}

Box3 scaled(const Box3& box, const Vec3& scale, const Vec3& offset) {
  return {scale.cwiseProduct(box.min) + offset, scale.cwiseProduct(box.max) + offset};
}

}  // namespace

VolumeLayer::VolumeLayer(VolumeInput input, const Appearance& appearance)
    : input_(std::make_shared<VolumeInput>(std::move(input))),
      appearance_(appearance),
      info_(input_->source->info()) {
  const Placement& placement = appearance_.placement;
  if (placement.turns())
    placement_ = {Vec3::Ones(), placement.offset, placement.turn};
  const Vec3 offset = placement.turns() ? Vec3(Vec3::Zero()) : placement.offset;
  info_.bounds = scaled(info_.bounds, placement.scale, offset);
  if (appearance_.basis)
    info_.basis = *appearance_.basis;
}

void VolumeLayer::setAppearance(const Appearance& appearance) {
  const Placement before = std::exchange(appearance_, appearance).placement;
  const Placement& now = appearance_.placement;
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
  VolumeLayer layer(std::move(input), appearance);
  layer.path_ = path;
  layer.options_ = options;
  layer.progress_ = &reading.progress;
  return layer;
}

Result<std::shared_ptr<const Tree4d>> VolumeLayer::treeAt(int position) {
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

Result<BrickSlice> VolumeLayer::sliceFromFrame(int position) {
  std::vector<float>& frame = input_->frame;
  frame.resize(info_.frameValues());
  VOLUTE_TRY(input_->source->readFrame(position, frame));
  VOLUTE_TRY(checkFinite(frame, info_, path_, position));
  return BrickSlice::fromDense(info_, frame);
}

Result<std::shared_ptr<const BrickSlice>> VolumeLayer::sliceAt(int position, bool tree) {
  if (position == position_ && tree == fromTree_)
    return slice_;
  VOLUTE_ASSIGN(auto slice, tree ? sliceFromTree(position) : sliceFromFrame(position));
  slice_ = std::make_shared<const BrickSlice>(std::move(slice));
  position_ = position;
  fromTree_ = tree;
  return slice_;
}

int VolumeLayer::positionAt(double time) const {
  constexpr double kTimeRounding = 1e-12;  // timeOf() a frame is within it
  const double own = appearance_.clock.at(time, info_.times);
  return info_.frameAt(own + kTimeRounding * (1 + std::abs(own)));
}

double VolumeLayer::timeOf(int position) const {
  return appearance_.clock.sceneTime(info_.times[position]);
}

}  // namespace volute
