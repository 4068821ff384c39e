// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/settings_check.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace volute {
namespace {

tl::unexpected<Error> idle(const char* setting, const std::string& why) {
  return failFor(setting, ErrorCode::kInvalidArgument, "has no effect {}", why);
}

/// Whether any frame has two before it in its chain, at even steps: these tell the motion.
bool anyFrameGoesOn(const Capture& capture, bool warmStart) {
  const std::vector<int>& frames = capture.frames;
  const auto begins = chainBegins(frames, warmStart);
  for (std::size_t i = 2; i < frames.size(); ++i) {
    const auto begin = *(std::ranges::upper_bound(begins, static_cast<int>(i)) - 1);
    if (static_cast<int>(i) - begin >= 2 &&
        frames[i] - frames[i - 1] == frames[i - 1] - frames[i - 2])
      return true;
  }
  return false;
}

Status checkTemporal(const ReconstructionSettings& settings, const Capture& capture) {
  if (settings.tomography.solver != TomographySolver::kApg)
    return idle("temporal", fmt::format("with the solver {}, which has no prior",
                                        tomographySolverName(settings.tomography.solver)));
  if (!settings.warmStart)
    return idle("temporal", "without a warm start: each frame is by itself");
  if (settings.singleScattering)
    return idle("temporal", "on a medium that lamps light: each frame is by itself");
  constexpr std::size_t kMoving = 3;  // two of them tell the motion
  if (capture.frames.size() < kMoving)
    return idle("temporal",
                fmt::format("on {} frame{}: it needs two before a frame, of whose "
                            "motion it goes on",
                            capture.frames.size(), capture.frames.size() == 1 ? "" : "s"));
  if (!anyFrameGoesOn(capture, settings.warmStart))
    return idle("temporal",
                "on these frames: it needs two before a frame, as far apart as that is "
                "from the second, of whose motion it goes on");
  return {};
}

}  // namespace

Status checkSettings(const ReconstructionSettings& settings, const Capture& capture) {
  const TomographyOptions& options = settings.tomography;
  const Regularization prior = options.regularization;
  const bool smooth = prior == Regularization::kSmooth || prior == Regularization::kWavelet;
  for (const auto& [name, given] : {std::pair("lambda", options.lambda.has_value()),
                                    std::pair("sparsity", options.sparsity.has_value())}) {
    if (!given)
      continue;
    if (options.solver != TomographySolver::kApg)
      return idle(name, fmt::format("with the solver {}, which has no prior",
                                    tomographySolverName(options.solver)));
    if (prior == Regularization::kNone || (smooth && std::string_view(name) == "sparsity"))
      return idle(name, fmt::format("with the regularization {}", regularizationName(prior)));
  }
  return options.temporal > 0 ? checkTemporal(settings, capture) : Status();
}

void remarkOnUnused(const ReconstructionSettings& settings, const Capture& capture,
                    Progress& progress) {
  const auto note = [&](const std::string& sentence, Hint hint) {
    progress.remark(Remark(RemarkCode::kNote, sentence, {std::move(hint)}));
  };
  const bool albedo = (capture.lighting.albedo != 1).any();
  if (!settings.singleScattering && (albedo || !capture.lighting.lamps.empty()))
    note("the capture's lamps or albedo are not used: the medium is taken to send its own light",
         Hint::set("lighting", "single-scattering").so("uses them"));
  if (!settings.flame && capture.spectrum.stated())
    note("the capture's spectrum is not used: no temperature is asked for",
         Hint::set("temperature").so("uses it"));
}

}  // namespace volute
