// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <filesystem>

#include "bench/benchmark.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/io/volume_source.hpp"
#include "volute/synth/synth.hpp"

namespace volute::bench {

bool isMeshInput(const BenchInput& input) {
  const std::string& file = input.volume;
  return file.ends_with(".vtu") || file.ends_with(".pvd") || isMeshCase(file);
}

Result<std::vector<NamedSequence>> benchSequences(const BenchInput& input, Progress& progress,
                                                  int size) {
  std::vector<NamedSequence> sequences;
  if (!input.volume.empty()) {
    SourceOptions options;
    options.maxMemory = input.maxMemory;
    VOLUTE_ASSIGN(auto source, openSource(input.volume, options));
    VOLUTE_ASSIGN(auto sequence, readAll(*source, input.maxMemory));
    const std::string file = std::filesystem::path(input.volume).stem().string();
    sequences.push_back({file.empty() ? source->info().name : file, std::move(sequence)});
    return sequences;
  }
  for (const auto& [name, kind] :
       {std::pair{"fire", SynthKind::kFire}, {"smoke", SynthKind::kSmoke}}) {
    const SynthOptions made{.kind = kind, .size = size, .frames = 32, .seed = 1, .channels = 1};
    VOLUTE_ASSIGN(auto sequence, synthesize(made, progress));
    sequences.push_back({name, std::move(sequence)});
  }
  return sequences;
}

double valueRange(const Sequence& sequence) {
  const auto [low, high] = std::ranges::minmax(sequence.values);
  return static_cast<double>(high) - low;
}

}  // namespace volute::bench
