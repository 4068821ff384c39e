// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/volume_output.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "volute/io/npy.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/media/volume/volume_input.hpp"

namespace volute::cli {

Status checkTarget(const std::string& target, bool standardOutput) {
  namespace fs = std::filesystem;
  if (target == "-") {
    if (standardOutput)
      return {};
    return fail(ErrorCode::kInvalidArgument, "'-' is no target here; expected a file's name");
  }
  const fs::path path(target);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return fail(ErrorCode::kIo, "{}: there is no folder {}; make it first", target,
                folder.string());
  }
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status))
    return fail(ErrorCode::kIo, "{}: this is a folder; expected a file's name", target);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    return fail(ErrorCode::kIo,
                "{}: this is no regular file, and would be replaced by one; give another name",
                target);
  }
  if (::access(folder.c_str(), W_OK) != 0) {
    return fail(ErrorCode::kIo, "{}: cannot write into its folder: {}", target,
                std::strerror(errno));
  }
  Context::watch(path);
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
        "--output: '{}' is of no known format; expected {}.npy, %04d.vdb, %04d.vti, .pvd or -{}",
        target, voluteToo ? ".volute, " : "",
        isVolutePath(target) ? "; volute compress writes .volute files" : "");
  }
  return createSink(target, info);
}

Status copyFrames(FrameSource& source, FrameSink& sink, const std::string& stage,
                  Progress& progress) {
  const VolumeInfo& info = source.info();
  std::vector<float> frame(info.frameValues());
  for (int i = 0; i < info.frames; ++i) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: {} frame {}", stage, info.frameNumbers[i]);
    VOLUTE_TRY(source.readFrame(i, frame));
    VOLUTE_TRY(sink.writeFrame(frame));
    progress.report(stage, i + 1, info.frames);
  }
  return sink.finish();
}

}  // namespace volute::cli
