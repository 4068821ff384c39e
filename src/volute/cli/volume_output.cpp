// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/volume_output.hpp"

#include <algorithm>
#include <array>

#include "volute/base/interrupt.hpp"
#include "volute/base/output_name.hpp"
#include "volute/io/npy.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/media/volume/volume_input.hpp"

namespace volute::cli {

Status checkTarget(const std::string& target, bool standardOutput) {
  VOLUTE_TRY(checkOutput(target, standardOutput));
  if (target != "-")
    Interrupt::watch(target);
  return {};
}

Result<std::unique_ptr<FrameSink>> openSink(const std::string& target, const VolumeInfo& info,
                                            bool voluteToo) {
  if (target == "-") {
    VOLUTE_ASSIGN(auto sink, NpySink::create(target, info));
    return sink;
  }
  constexpr std::array<std::string_view, 4> kKnown = {".npy", ".vdb", ".vti", ".pvd"};
  if (std::ranges::find(kKnown, extensionOf(target)) == kKnown.end()) {
    return fail(
        ErrorCode::kInvalidArgument,
        "--output: '{}' has an unknown format; expected {}.npy, %04d.vdb, %04d.vti, .pvd or -{}",
        target, voluteToo ? ".volute, " : "",
        isVolutePath(target) ? "; volute compress writes .volute files" : "");
  }
  return createSink(target, info);
}

}  // namespace volute::cli
