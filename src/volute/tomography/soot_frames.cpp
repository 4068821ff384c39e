// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/soot_frames.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/parallel.hpp"
#include "volute/report/json.hpp"

namespace volute {

/// One quantity.
class SootFrames::Grid final : public FrameSource {
 public:
  Grid(ReconstructedFrames& frames, const Pyrometer& pyrometer, double Soot::* quantity,
       const char* name, const char* unit, bool sigma)
      : frames_(frames), pyrometer_(pyrometer), quantity_(quantity), sigma_(sigma) {
    info_ = frames.info();
    info_.name = name;
    info_.unit = unit;
    info_.channels = 1;
  }

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int index, std::span<float> values) override {
    std::vector<float> light(3 * values.size());
    VOLUTE_TRY(frames_.readFrame(index, light));
    const auto soot = sootOf(pyrometer_, frames_.geometry().resolution, light);
    if (!sigma_) {
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<float>(soot[i].*quantity_);
      return {};
    }
    std::vector<float> bars(light.size());
    VOLUTE_TRY(frames_.errorBars().readFrame(index, bars));
    const auto& resolution = frames_.geometry().resolution;
    const std::vector<float> lightAround = meansAround(resolution, light),
                             barsAround = meansAround(resolution, bars);
    VOLUTE_ASSIGN(const auto record, frames_.record(index));
    const double correlation = record["uncertainty"].value("channel_correlation", 0.0);
    parallelRanges(values.size(), 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        values[i] = 0;
        if (!(soot[i].temperature > 0))
          continue;
        // The voxel's own colours, kept near those around it, whose errors are apart.
        const Soot own = spreadOf(&light[3 * i], &bars[3 * i], 1, soot[i], correlation);
        const Soot around =
            spreadOf(&lightAround[3 * i], &barsAround[3 * i], kAround, soot[i], correlation);
        const double kept =
            own.temperature > 0 ? 1 / std::hypot(1 / own.temperature, 1 / kNearSoot) : kNearSoot;
        const double temperature = std::hypot(kept, around.temperature);
        const Soot share{temperature, own.temperature > 0
                                          ? own.extinction * temperature / own.temperature
                                          : around.extinction};
        values[i] = static_cast<float>(share.*quantity_ * soot[i].*quantity_);
      }
    });
    return {};
  }

 private:
  static constexpr double kAround = 27;

  /// @param count  of voxels whose mean is given
  Soot spreadOf(const float* light, const float* bars, double count, const Soot& soot,
                double correlation) const {
    Rgb emission, relative;
    for (int c = 0; c < 3; ++c) {
      emission[c] = light[c];
      relative[c] = light[c] > 0 ? std::min(bars[c] / light[c], 1.0F) / std::sqrt(count) : 0;
    }
    return pyrometer_.uncertainty(emission, soot, relative, correlation);
  }

  ReconstructedFrames& frames_;
  const Pyrometer& pyrometer_;
  double Soot::* quantity_;
  bool sigma_;
  VolumeInfo info_;
};

SootFrames::SootFrames(ReconstructedFrames& frames, const CaptureSpectrum& spectrum)
    : frames_(frames), pyrometer_(spectrum) {
  const auto add = [&](double Soot::* quantity, const char* name, const char* unit, bool sigma) {
    grids_.push_back(std::make_unique<Grid>(frames, pyrometer_, quantity, name, unit, sigma));
  };
  add(&Soot::temperature, "temperature", "K", false);
  add(&Soot::extinction, "extinction", "1/m", false);
  if (!frames.hasErrorBars())
    return;
  add(&Soot::temperature, "temperature_sigma", "K", true);
  add(&Soot::extinction, "extinction_sigma", "1/m", true);
}

std::vector<FrameSource*> SootFrames::grids() const {
  std::vector<FrameSource*> all;
  for (const auto& grid : grids_) all.push_back(grid.get());
  return all;
}

Result<nlohmann::ordered_json> SootFrames::json() const {
  double light = 0, weighted = 0, greatest = 0, deepest = 0;
  std::int64_t voxels = 0;
  const VolumeGeometry geometry = frames_.geometry();
  const auto& n = geometry.resolution;
  const double step = geometry.voxelSize().x();
  for (int index = 0; index < frames_.info().frames; ++index) {
    VOLUTE_ASSIGN(const auto emission, frames_.volume(index));
    const auto soot = sootOf(pyrometer_, n, emission);
    for (std::size_t row = 0; row < soot.size(); row += static_cast<std::size_t>(n[0])) {
      double depth = 0;
      for (std::size_t i = row; i < row + static_cast<std::size_t>(n[0]); ++i) {
        if (!(soot[i].temperature > 0))
          continue;
        const double shines = emission[3 * i] + emission[3 * i + 1] + emission[3 * i + 2];
        light += shines;
        weighted += shines * soot[i].temperature;
        greatest = std::max(greatest, soot[i].temperature);
        depth += step * soot[i].extinction;
        ++voxels;
      }
      deepest = std::max(deepest, depth);
    }
  }
  return nlohmann::ordered_json{{"mean_temperature", light > 0 ? Json(weighted / light) : Json()},
                                {"greatest_temperature", jsonNumber(greatest)},
                                {"optical_depth", jsonNumber(deepest)},
                                {"voxels", voxels}};
}

}  // namespace volute
