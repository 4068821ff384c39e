// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_probe.hpp"

#include "volute/media/volume/volume_medium.hpp"

namespace volute {
namespace {

/// Where and when as it was, but light alone: one unit of it for each of the values.
Appearance plain(const Appearance& appearance) {
  Appearance plain;
  plain.placement = appearance.placement;
  plain.clock = appearance.clock;
  return plain;
}

class VolumeProbe final : public FieldProbe {
 public:
  explicit VolumeProbe(const VolumeMedium& volume)
      : shown_(volume.with(plain(volume.appearance()))), names_(volume.gridNames()) {}

  Result<std::vector<ProbedField>> at(double time, const Vec3& place) override {
    VOLUTE_TRY(open());
    std::vector<ProbedField> fields;
    for (const auto& grid : grids_) {
      VOLUTE_ASSIGN(const auto now, grid->at({.time = time, .lit = false}, quiet_));
      std::vector<AnyMedium> media;
      now->addMedia(media);
      if (media.empty() || !media.front().bounds().contains(place))
        continue;
      const Rgb light = media.front().emission(place);
      const VolumeInfo& info = grid->volume();
      const std::string name = info.name.empty() ? "value" : info.name;
      fields.push_back({info.levelSet ? name + " (1: inside)" : name,
                        {light.data(), light.data() + (info.channels == 3 ? 3 : 1)},
                        info.levelSet ? "" : info.unit});
    }
    return fields;
  }

 private:
  /// A grid that cannot be read is left out where there are others.
  Status open() {
    if (!grids_.empty())
      return {};
    if (names_.empty())
      grids_.push_back(shown_);
    for (const std::string& name : names_) {
      constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;
      InputOptions options = shown_->options();
      options.grid = name;
      Reading reading{.progress = quiet_, .maxMemory = kMemory};
      auto grid = VolumeMedium::open(shown_->path(), options, shown_->appearance(), reading);
      if (grid)
        grids_.push_back(std::move(*grid));
      else if (names_.size() == 1)
        return tl::unexpected<Error>(std::move(grid.error()));
    }
    return {};
  }

  Progress quiet_;
  std::shared_ptr<VolumeMedium> shown_;
  std::vector<std::string> names_;
  std::vector<std::shared_ptr<VolumeMedium>> grids_;
};

}  // namespace

std::unique_ptr<FieldProbe> volumeProbe(const VolumeMedium& volume) {
  return std::make_unique<VolumeProbe>(volume);
}

}  // namespace volute
