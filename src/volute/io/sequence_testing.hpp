// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>

#include "volute/grid/sequence.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/io/volume_source.hpp"

/// Whole sequences to files and back, for tests.
namespace volute::testing {

inline Status writeAll(const std::filesystem::path& path, const Sequence& sequence,
                       const SinkOptions& options = {}) {
  VOLUTE_ASSIGN(auto sink, createSink(path, sequence.info, options));
  for (int i = 0; i < sequence.info.frames; ++i) VOLUTE_TRY(sink->writeFrame(sequence.frame(i)));
  return sink->finish();
}

inline Result<Sequence> readSequence(const std::filesystem::path& path,
                                     const SourceOptions& options = {}) {
  VOLUTE_ASSIGN(auto source, openSource(path, options));
  return readAll(*source, 1 << 30);
}

}  // namespace volute::testing
