// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/velocity_frames.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "volute/report/json.hpp"

namespace volute {

Result<std::unique_ptr<VelocityFrames>> VelocityFrames::open(ReconstructedFrames& frames,
                                                             const FlowOptions& options,
                                                             const std::filesystem::path& output,
                                                             Progress& progress) {
  const VolumeInfo& light = frames.info();
  if (light.frames < 2)
    return fail(ErrorCode::kInvalidArgument,
                "A velocity needs two frames at least, and one is chosen");
  const std::string beside = output == "-" ? "-" : output.string() + ".velocity";
  VOLUTE_ASSIGN(auto work, WorkFolder::open(beside));
  std::unique_ptr<VelocityFrames> velocities(
      new VelocityFrames(frames, options, std::move(work), progress));
  velocities->info_ = light;
  velocities->info_.name = "velocity";
  velocities->info_.unit = "m/s";
  velocities->info_.channels = 3;
  const std::string how =
      fmt::format("{} {} {}", options.smoothness, options.divergence, options.warps);
  const auto& keys = frames.keys();
  velocities->finished_.resize(keys.size());
  for (std::size_t i = 0; i + 1 < keys.size(); ++i)
    velocities->keys_.push_back(digestOf(how + keys[i] + keys[i + 1]));
  return velocities;
}

double VelocityFrames::seconds(int pair) const {
  const auto i = static_cast<std::size_t>(pair);
  return info_.times[i + 1] - info_.times[i];
}

/// [m/s] of a displacement of one voxel.
Vec3 VelocityFrames::perVoxel(int pair) const {
  return info_.voxelSize() / seconds(pair);
}

Status VelocityFrames::solve(int pair) {
  const int number = info_.frameNumbers[static_cast<std::size_t>(pair)];
  VOLUTE_ASSIGN(const auto before, frames_.volume(pair));
  VOLUTE_ASSIGN(const auto after, frames_.volume(pair + 1));
  const auto first = greyVolume(before), second = greyVolume(after);
  VOLUTE_ASSIGN(const VoxelFlow flow,
                flowBetween(first, second, {info_.x, info_.y, info_.z}, options_, progress_));
  std::vector<float> values;
  for (const auto& one : flow.along) values.insert(values.end(), one.begin(), one.end());
  const Vec3 unit = perVoxel(pair);
  double light = 0, weighted = 0, greatest = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const double here = static_cast<double>(first[i]) + second[i];
    if (!(here > 0))
      continue;
    const double speed =
        Vec3(flow.along[0][i], flow.along[1][i], flow.along[2][i]).cwiseProduct(unit).norm();
    light += here;
    weighted += here * speed;
    greatest = std::max(greatest, speed);
  }
  const nlohmann::ordered_json record = {
      {"frames", {number, info_.frameNumbers[static_cast<std::size_t>(pair) + 1]}},
      {"mean_speed", jsonNumber(light > 0 ? weighted / light : 0)},
      {"greatest_speed", jsonNumber(greatest)}};
  VOLUTE_TRY(work_.store(number, keys_[static_cast<std::size_t>(pair)], values, record));
  finished_[static_cast<std::size_t>(pair)] = 1;
  return {};
}

/// A damaged one of an earlier run is estimated again.
bool VelocityFrames::finished(int pair) {
  const auto i = static_cast<std::size_t>(pair);
  if (finished_[i] == 0)
    finished_[i] = work_.sound(info_.frameNumbers[i], keys_[i]) ? 1 : 0;
  return finished_[i] != 0;
}

Status VelocityFrames::solveAll(Team& team) {
  return team.forUnits("velocities", pairs(), progress_, [&](std::int64_t unit) -> Status {
    const auto pair = static_cast<int>(unit);
    return finished(pair) ? Status() : solve(pair);
  });
}

Result<VoxelFlow> VelocityFrames::flow(int pair) {
  const auto i = static_cast<std::size_t>(pair);
  if (!finished(pair))
    VOLUTE_TRY(solve(pair));
  VOLUTE_ASSIGN(const auto values,
                work_.values(info_.frameNumbers[i], keys_[i], 3 * info_.voxels()));
  VoxelFlow flow{{info_.x, info_.y, info_.z}, {}};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(a * info_.voxels());
    flow.along[a].assign(begin, begin + static_cast<std::ptrdiff_t>(info_.voxels()));
  }
  return flow;
}

Status VelocityFrames::readFrame(int index, std::span<float> values) {
  std::optional<VoxelFlow> before, after;
  if (index > 0) {
    VOLUTE_ASSIGN(before, flow(index - 1));
  }
  if (index < pairs()) {
    VOLUTE_ASSIGN(after, flow(index));
  }
  const double ratio = before && after ? seconds(index) / seconds(index - 1) : 1;
  const VoxelFlow frame =
      flowAtFrame(before ? &*before : nullptr, after ? &*after : nullptr, ratio);
  const Vec3 unit = perVoxel(after ? index : index - 1);
  for (std::size_t i = 0; i < info_.voxels(); ++i)
    for (std::size_t a = 0; a < 3; ++a)
      values[3 * i + a] = static_cast<float>(frame.along[a][i] * unit[a]);
  return {};
}

Result<nlohmann::ordered_json> VelocityFrames::record(int pair) const {
  const auto i = static_cast<std::size_t>(pair);
  return work_.record(info_.frameNumbers[i], keys_[i]);
}

Result<nlohmann::ordered_json> VelocityFrames::json() const {
  auto list = nlohmann::ordered_json::array();
  double mean = 0, greatest = 0;
  for (int pair = 0; pair < pairs(); ++pair) {
    VOLUTE_ASSIGN(const auto one, record(pair));
    mean += one.value("mean_speed", 0.0) / pairs();
    greatest = std::max(greatest, one.value("greatest_speed", 0.0));
    list.push_back(one);
  }
  return nlohmann::ordered_json{{"unit", "m/s"},
                                {"mean_speed", jsonNumber(mean)},
                                {"greatest_speed", jsonNumber(greatest)},
                                {"pairs", list}};
}

}  // namespace volute
