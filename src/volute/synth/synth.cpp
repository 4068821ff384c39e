// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/synth.hpp"

#include "volute/synth/simulation.hpp"

namespace volute {
namespace {

constexpr int kMaxFrames = 100000;

VolumeInfo describe(const SynthOptions& options) {
  const bool fire = options.kind == SynthKind::kFire;
  VolumeInfo info;
  info.name = !fire ? "density" : options.channels == 1 ? "flame" : "emission";
  info.unit = fire ? "radiance/m" : "1/m";
  info.frames = options.frames;
  info.x = info.y = info.z = options.size;
  info.channels = options.channels;
  info.bounds = {Vec3(-kExtent / 2, -kExtent / 2, 0), Vec3(kExtent / 2, kExtent / 2, kExtent)};
  info.fillDefaults();
  return info;
}

}  // namespace

struct SyntheticSource::State {
  std::unique_ptr<Simulation> simulation;
  int advanced = 0;  // frames since the simulation began, warm-up included
};

SyntheticSource::SyntheticSource(const SynthOptions& options, Progress& progress)
    : options_(options),
      info_(describe(options)),
      progress_(progress),
      state_(std::make_unique<State>()) {}

SyntheticSource::~SyntheticSource() = default;

Result<std::unique_ptr<SyntheticSource>> SyntheticSource::create(const SynthOptions& options,
                                                                 Progress& progress) {
  if (options.size < 16 || options.size > 128 || options.size % 8 != 0) {
    return fail(
        ErrorCode::kInvalidArgument,
        "a synthetic volume cannot have {} voxels on a side; give a multiple of 8 from 16 to 128",
        options.size);
  }
  if (options.frames < 1 || options.frames > kMaxFrames) {
    return fail(ErrorCode::kInvalidArgument,
                "a synthetic sequence cannot have {} frames; give 1 to {}", options.frames,
                kMaxFrames);
  }
  if (options.channels != 1 && options.channels != 3) {
    return fail(ErrorCode::kInvalidArgument,
                "a synthetic volume cannot have {} channels; give 1 (scalar) or 3 (RGB)",
                options.channels);
  }
  return std::unique_ptr<SyntheticSource>(new SyntheticSource(options, progress));
}

Status SyntheticSource::readFrame(int index, std::span<float> values) {
  if (index < 0 || index >= info_.frames) {
    return fail(ErrorCode::kInvalidArgument,
                "synthetic sequence: frame {} does not exist; it has {} frames", index,
                info_.frames);
  }
  VOLUTE_ASSERT(values.size() == info_.frameValues());
  State& state = *state_;
  const auto make = options_.kind == SynthKind::kFire ? makeFire : makeSmoke;
  if (!state.simulation)
    state = {make(options_.size, options_.seed), 0};
  const int warmUp = state.simulation->warmUpFrames();
  const int wanted = warmUp + index;
  if (state.advanced > wanted)
    state = {make(options_.size, options_.seed), 0};
  for (; state.advanced < wanted; ++state.advanced) {
    if (progress_.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: synthetic sequence, before frame {}", index);
    state.simulation->advanceFrame();
    progress_.report("simulate", state.advanced + 1, warmUp + info_.frames - 1);
  }
  state.simulation->write(info_.channels, values);
  return {};
}

Result<Sequence> synthesize(const SynthOptions& options, Progress& progress,
                            std::uint64_t maxBytes) {
  VOLUTE_ASSIGN(const auto source, SyntheticSource::create(options, progress));
  return readAll(*source, maxBytes);
}

}  // namespace volute
