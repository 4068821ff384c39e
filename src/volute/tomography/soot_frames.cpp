// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/soot_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
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
        const auto at = [i](const std::vector<float>& all) {
          return Rgb(all[3 * i], all[3 * i + 1], all[3 * i + 2]);
        };
        const Soot deviation = deviationOf(pyrometer_, soot[i], {at(light), at(bars)},
                                           {at(lightAround), at(barsAround)}, correlation);
        values[i] = static_cast<float>(deviation.*quantity_);
      }
    });
    return {};
  }

 private:
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

Status SootFrames::addTo(nlohmann::ordered_json& report, Progress& progress) const {
  SootSummary summary(pyrometer_);
  for (int index = 0; index < frames_.info().frames; ++index) {
    VOLUTE_ASSIGN(const auto emission, frames_.volume(index));
    summary.add(frames_.geometry(), emission);
  }
  report["soot"] = summary.json();
  for (const std::string& doubt : summary.doubts()) {
    report["warnings"].push_back(doubt);
    progress.remark({RemarkCode::kDoubtful, "warning: " + doubt});
  }
  return {};
}

void SootSummary::add(const VolumeGeometry& geometry, std::span<const float> emission) {
  const auto row = static_cast<std::size_t>(geometry.resolution[0]);
  const double step = geometry.voxelSize().x();
  const auto soot = sootOf(pyrometer_, geometry.resolution, emission);
  for (std::size_t begin = 0; begin < soot.size(); begin += row) {
    double depth = 0;
    for (std::size_t i = begin; i < begin + row; ++i) {
      const Rgb sent(emission[3 * i], emission[3 * i + 1], emission[3 * i + 2]);
      light_ += sent;
      if (!(soot[i].temperature > 0))
        continue;
      known_ += sent.sum();
      weighted_ += sent.sum() * soot[i].temperature;
      greatest_ = std::max(greatest_, soot[i].temperature);
      depth += step * soot[i].extinction;
      ++voxels_;
    }
    deepest_ = std::max(deepest_, depth);
  }
}

std::vector<std::string> SootSummary::doubts() const {
  constexpr double kHalf = 0.5, kDeepest = 5, kFaintest = 1e-4, kApart = 1.2;
  const double light = light_.sum();
  if (!(light > 0))
    return {};
  if (known_ < kHalf * light) {
    const Rgb colours = light_ / light_.maxCoeff();
    const Rgb usual = pyrometer_.sootColours(kUsual) / pyrometer_.sootColours(kUsual).maxCoeff();
    return {fmt::format(
        "no temperature from 700 to 4000 K explains the colours of {:.0f} % of the light (red : "
        "green : blue = {:.2g} : {:.2g} : {:.2g}; by \"spectrum\" soot of {:g} K has {:.2g} : "
        "{:.2g} : {:.2g}): its channels in another order, a temperature not in kelvins, or mixed "
        "colours?",
        100 * (1 - known_ / light), colours[0], colours[1], colours[2], kUsual, usual[0], usual[1],
        usual[2])};
  }
  const double red = pyrometer_.sootOf(light_ * Rgb(1, 1, 0)).temperature,
               blue = pyrometer_.sootOf(light_ * Rgb(0, 1, 1)).temperature;
  if (red > 0 && blue > 0 && std::max(red, blue) > kApart * std::min(red, blue))
    return {fmt::format(
        "red and green tell {:.0f} K, green and blue {:.0f} K: \"spectrum\" is not that of these "
        "pictures, or the light is not that of soot",
        red, blue)};
  if (deepest_ > kDeepest || deepest_ < kFaintest)
    return {fmt::format(
        "the soot's optical depth is {:.2g}{}: is \"black_body\" what the pictures would hold, "
        "after \"white\", \"gain\" and \"exposure\"?",
        deepest_,
        deepest_ > kDeepest ? fmt::format(", and absorption is undone up to {:g}", kDeepest) : "")};
  return {};
}

nlohmann::ordered_json SootSummary::json() const {
  return {{"mean_temperature", known_ > 0 ? Json(weighted_ / known_) : Json()},
          {"greatest_temperature", jsonNumber(greatest_)},
          {"optical_depth", jsonNumber(deepest_)},
          {"voxels", voxels_}};
}

}  // namespace volute
